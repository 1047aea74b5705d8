// SPDX-License-Identifier: BSD-3-Clause
#include "Mesh/GridView.h"

#include "Base/SparseArray.h"
#include "Mesh/PointExchange.h"

namespace bsv
{

GridView::GridView(const PointBoxes* boxes)
  : GridView(static_cast<const double*>(nullptr), boxes->counts())
{
  this->Boxes = boxes;
}

const double* GridView::fetched(Index offset) const
{
  return this->Boxes ? this->Boxes->find(this->Start + offset) : nullptr;
}

Vec3 GridView::remote(Index offset) const
{
  const double* x = this->fetched(offset);
  if (!x)
  {
    throw Error("a mesh point was read that is on another rank");
  }
  return Vec3(x[0], x[1], x[2]);
}

const Vec3* GridView::change(Index offset, Index& count) const
{
  count = this->Changes->run(this->Start + offset, count);
  return this->Changes->find(this->Start + offset);
}

} // namespace bsv
