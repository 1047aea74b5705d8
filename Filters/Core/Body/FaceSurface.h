// SPDX-License-Identifier: BSD-3-Clause
/// @file FaceSurface.h
/// Block faces of a B-spline volume as NURBS surfaces.
#pragma once

#include "Body/NURBSSurface.h"
#include "Mesh/BlockMesh.h"
#include "Ranks/Ranks.h"
#include "Volume/BSplineVolume.h"

#include <vector>

namespace bsv
{

/// The surface of each face, on all ranks: u and v are the face's axes (BlockTopology.h), degrees and knots those of
/// the volume. Knots across the face need not be clamped; where they are, control points are those of the volume, not
/// computed. Weights where the volume has them. Collective.
/// @param volumes must have passed checkBSplineVolume(); of blocks on other ranks the points come from there.
/// @param faces only block and face are used.
std::vector<NURBSSurface> faceSurfaces(
  const std::vector<BSplineVolume>& volumes, const std::vector<BoundaryPatch>& faces, const Ranks& ranks);

} // namespace bsv
