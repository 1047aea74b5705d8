// SPDX-License-Identifier: BSD-3-Clause
#include "Mesh/PointStorage.h"

#include "Base/SparseArray.h"
#include "Mesh/PointExchange.h"

namespace bsv
{

const double* PointStorage::fetched(Index place) const
{
  return this->Boxes ? this->Boxes->find(place) : nullptr;
}

Vec3 PointStorage::remote(Index place) const
{
  const double* x = this->fetched(place);
  if (!x)
  {
    throw Error("a mesh point was read that is on another rank");
  }
  return Vec3(x[0], x[1], x[2]);
}

const Vec3* PointStorage::changed(Index place, Index& count) const
{
  count = this->Changes->run(place, count);
  return this->Changes->find(place);
}

} // namespace bsv
