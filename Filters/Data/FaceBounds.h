// SPDX-License-Identifier: BSD-3-Clause
/// @file FaceBounds.h
/// How large a part of a volume's outside is.
#pragma once

#include "BSplineVolumeFiltersModule.h"

#include "Data/BSplineVolumeData.h"

#include <Eigen/Geometry>

#include <vector>

namespace bsv
{

/// The bounding box of the control points of faces, or an empty one. Collective.
/// @param faces 6 per block: whether the face counts
BSPLINEVOLUMEFILTERS_EXPORT Eigen::AlignedBox3d faceBounds(
  const BSplineVolumeBlocks& volume, const std::vector<bool>& faces, const Ranks& ranks);

/// Whether each of the 6 faces of every block is in a boundary for which `chosen` says so.
BSPLINEVOLUMEFILTERS_EXPORT std::vector<bool> facesOf(
  const BSplineVolumeBlocks& volume, const std::vector<bool>& chosen);

} // namespace bsv
