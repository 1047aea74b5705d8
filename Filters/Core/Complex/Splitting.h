// SPDX-License-Identifier: BSD-3-Clause
/// @file Splitting.h
/// Where the blocks must be cut so that all contacts are face to face and creases run along block edges.
#pragma once

#include "Complex/BlockComplex.h"
#include "Complex/CreaseEdges.h"
#include "Mesh/BlockSurface.h"

#include <array>
#include <vector>

namespace bsv
{

/// Mesh positions per direction of a block at which it is cut, ascending, with both ends.
using CutPositions = std::array<std::vector<int>, 3>;

/// The smallest set of cuts, per block, after which on every piece of face all quadrilaterals meet the same face in the
/// same way, or the same boundary, and no edge is a crease in part, except where only one cell lies at it. A cut goes
/// through its whole block and on through the contacts into the neighbours.
///
/// @param creases null: those cuts alone that contacts and boundaries need.
/// @throws Error for crease lines that are none, and if there are more than a million pieces.
std::vector<CutPositions> cutPositions(const BlockMesh& mesh, const SurfaceNumbering& surface, const Contacts& contacts,
  const CreaseEdges* creases, const Execution& run);

} // namespace bsv
