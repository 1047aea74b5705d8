// SPDX-License-Identifier: BSD-3-Clause
/// @file SharedBox.h
/// The bounding box of points of all ranks.
#pragma once

#include "Base/Types.h"
#include "Ranks/Ranks.h"

#include <Eigen/Geometry>

#include <vector>

namespace bsv
{

/// The same on all ranks; empty if `mine` is on every one. Collective.
inline Eigen::AlignedBox3d sharedBox(const Eigen::AlignedBox3d& mine, const Ranks& ranks)
{
  std::vector<double> corners;
  if (!mine.isEmpty())
  {
    for (const Vec3& x : { mine.min(), mine.max() })
    {
      corners.insert(corners.end(), x.data(), x.data() + 3);
    }
  }
  corners = ranks.gatherAll(corners);
  Eigen::AlignedBox3d box;
  for (std::size_t n = 0; n + 2 < corners.size(); n += 3)
  {
    box.extend(Vec3(corners.data() + n));
  }
  return box;
}

} // namespace bsv
