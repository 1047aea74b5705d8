// SPDX-License-Identifier: BSD-3-Clause
/// @file MeshCheck.h
/// First look at a block mesh: sizes, finite points, zero extent, handedness and tangled cells.
#pragma once

#include "Mesh/BlockMesh.h"
#include "Mesh/GridView.h"

#include <vector>

namespace bsv
{

struct MeshCheck
{
  /// Per block: more negative than positive volume.
  std::vector<bool> leftHanded;
  /// Cells with a corner Jacobian that is zero or has not the sign of the block.
  Index tangledCells = 0;
  /// Where the first one is, if there is one.
  int tangledBlock = -1;
  Ijk tangledCell{ 0, 0, 0 };
};

/// Looks at every point and cell once, in parallel and with constant memory per layer of cells.
///
/// Refused are: fewer than two points in a direction, data arrays of another length than the points, sharpness that is
/// neither 0 nor infinite, non-finite points and, unless `allowDegenerate`, zero extent: mesh edges of no length
/// (beyond 16 machine epsilons of the block's coordinates), cells whose eight corner Jacobians are all zero (to 1e-12
/// of the product of the edges), and cell faces whose four corners have no area.
///
/// Collective: every rank looks at its own blocks.
///
/// @throws Error that names the first block and point or cell.
MeshCheck checkMesh(const BlockMesh& mesh, bool allowDegenerate, const Execution& run);

/// Looks at the points alone, as checkMesh() does. Collective.
/// @throws Error that names the first block and point that is not finite.
void checkFinitePoints(const BlockMesh& mesh, const Execution& run);

/// Smallest scaled Jacobian of a right-handed block, -1 to 1: over all corners of all cells, the determinant of the
/// three edges there divided by their lengths; edges of no length count as -1.
double minimumScaledJacobian(const GridView& points, const Execution& run = {});

} // namespace bsv
