// SPDX-License-Identifier: BSD-3-Clause
/// @file Splitting.h
/// Where the blocks must be cut so that all contacts are face to face and creases run along block edges.
#pragma once

#include "Complex/BlockComplex.h"
#include "Mesh/BlockSurface.h"

#include <cstdint>

namespace bsv
{

/// The mesh edges on the outer boundary that are creases. Collective: every rank looks at its own blocks.
class CreaseEdges
{
public:
  CreaseEdges(const BlockMesh& mesh, const SurfaceNumbering& surface, const Contacts& contacts,
    const std::vector<bool>& leftHanded, double creaseAngle, const Ranks& ranks);

  /// The same for all quadrilaterals, of all blocks, at one mesh edge.
  bool operator()(const QuadAt& quad, int axis, int side) const
  {
    return this->any(quad.block, quad.face) &&
      (this->Bits[6 * std::size_t(quad.block) + quad.face][this->place(quad)] >> (2 * axis + side) & 1) != 0;
  }
  /// Whether any edge of a quadrilateral of the face is one.
  bool any(int block, int face) const
  {
    return !this->Bits.empty() && !this->Bits[6 * std::size_t(block) + face].empty();
  }

private:
  class Search;

  Index place(const QuadAt& quad) const
  {
    return quad.s + Index(this->Surface.faceCells(quad.block, quad.face, 0)) * quad.t;
  }

  const SurfaceNumbering& Surface;
  /// Per face and quadrilateral one bit per edge; empty while there are no creases.
  std::vector<std::vector<std::uint8_t>> Bits;
};

/// Mesh positions per direction of a block at which it is cut, ascending, with both ends.
using CutPositions = std::array<std::vector<int>, 3>;

/// The smallest set of cuts, per block, after which on every piece of face all quadrilaterals meet the same face in the
/// same way, or the same boundary, and no edge is a crease in part, except where only one cell lies at it. A cut goes
/// through its whole block and on through the contacts into the neighbours.
///
/// @throws Error for crease lines that are none, and if there are more than a million pieces.
std::vector<CutPositions> cutPositions(const BlockMesh& mesh, const SurfaceNumbering& surface, const Contacts& contacts,
  const CreaseEdges& creases, const Execution& run);

} // namespace bsv
