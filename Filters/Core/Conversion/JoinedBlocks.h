// SPDX-License-Identifier: BSD-3-Clause
/// @file JoinedBlocks.h
/// Blocks that were cut for creases alone, joined again after the conversion: with knots of full multiplicity where
/// they were cut, which keep the shape of every piece.
#pragma once

#include "Complex/BlockComplex.h"
#include "Conversion/Conversion.h"

#include <array>
#include <vector>

namespace bsv
{

/// A block as a box of pieces.
struct JoinedBlock
{
  /// Pieces per direction.
  Ijk counts{ 1, 1, 1 };
  /// Blocks of the complex that was cut, i fastest.
  std::vector<int> pieces;
};

struct JoinedBlocks
{
  /// The one that there would be without creases, but for the points, which its blocks do not have, and for edges that
  /// are creases all along.
  BlockComplex complex;
  /// Per block of `complex`.
  std::vector<JoinedBlock> blocks;
  /// Block of `complex`, per block of the one that was cut.
  std::vector<int> blockOf;
};

/// Joins the pieces that meet at ComplexFace::creaseCut: all contacts are still whole face to whole face, as creases
/// cut both sides of a contact alike. Not collective.
JoinedBlocks joinPieces(const BlockComplex& cut);

/// Knots of one direction of a block: those of its pieces one after another, each cut a knot of multiplicity 3 at the
/// number of cells before it. @param knots per piece and direction
std::vector<double> joinedKnots(
  const JoinedBlock& block, int direction, const std::vector<std::array<std::vector<double>, 3>>& knots);

/// Puts the nets of the pieces of a block together; neighbours share a plane of points. @param nets per piece @param to
/// room for the whole net
void joinNets(const JoinedBlock& block, const std::vector<std::array<std::vector<double>, 3>>& knots,
  const std::vector<ControlNetStorage>& nets, const ControlNetStorage& to, const Execution& run = {});

} // namespace bsv
