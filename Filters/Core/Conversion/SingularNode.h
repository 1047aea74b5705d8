// SPDX-License-Identifier: BSD-3-Clause
/// @file SingularNode.h
/// Limit of solid Catmull-Clark subdivision at an interior vertex of any connectivity: point and linear map.
#pragma once

#include "Complex/EdgeFans.h"

#include <vector>

namespace bsv
{

/// Where the vertex of a star goes, and how the star around it lies there.
struct SolidLimit
{
  Vec3 point;
  /// Per star edge the derivative along it, in mesh edges: all blocks see one linear map, an affine star. Empty if the
  /// star has none, or none whose blocks are shaped well.
  std::vector<Vec3> slopes;
};

/// Limit of the vertex under the subdivision rules for hexahedra of MacCracken and Joy, "Free-form deformations with
/// lattices of arbitrary topology", SIGGRAPH 1996: an affine combination of the star's points X with the dominant left
/// eigenvector of the star's subdivision matrix. With its right and left invariant subspaces R and L of the eigenvalues
/// next to it, three of them, L^T R = 1, the slopes are (R_edge - R_vertex) L^T X. The star is numbered by the
/// coordinates of its points before that, so that the result does not depend on the numbering of the blocks.
///
/// In a regular star the weights are those of the tricubic B-spline, (64, 16, 4, 1) / 216, and the slopes are its
/// derivatives.
SolidLimit solidLimit(const VertexStar& star);

} // namespace bsv
