// SPDX-License-Identifier: BSD-3-Clause
/// @file SingularNode.h
/// Limit point of solid Catmull-Clark subdivision at an interior vertex of any connectivity.
#pragma once

#include "Complex/EdgeFans.h"

namespace bsv
{

/// Limit of the vertex under the subdivision rules for hexahedra of MacCracken and Joy, "Free-form deformations with
/// lattices of arbitrary topology", SIGGRAPH 1996: an affine combination of the star's points with the dominant left
/// eigenvector of the star's subdivision matrix. The star is numbered by the coordinates of its points before the
/// eigenvector is computed, so that the result does not depend on the numbering of the blocks.
///
/// In a regular star the weights are those of the tricubic B-spline, (64, 16, 4, 1) / 216.
Vec3 solidLimitPoint(const VertexStar& star);

} // namespace bsv
