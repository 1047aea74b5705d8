// SPDX-License-Identifier: BSD-3-Clause
/// @file DoubleKnots.h
/// Where exact G1 needs double knots, and their exact insertion into control nets (Boehm 1980).
///
/// A direction class is the set of block edges that are opposite to each other across block faces: all of them have the
/// same knots. It gets double knots, {0^4,1,1,2,..,I-2,I-1,I-1,I^4}, if one of its edges is a spoke of an extraordinary
/// edge or vertex; all others keep single knots. With old points b_i the new ones at either end are b0, b1,
/// (b1 + b2) / 2, (2 b2 + b3) / 3, b3. Classes of fewer than three cells get the knots of LocalNet.h.
#pragma once

#include "Complex/BlockComplex.h"
#include "Conversion/Conversion.h"

#include <array>
#include <vector>

namespace bsv
{

/// Per block and direction.
using DoubledDirections = std::vector<std::array<bool, 3>>;

/// Joins change control points of at most this index, from two ends of directions (G1Joins.h).
constexpr int JoinReach = 4;

/// Per block and direction, whether its class has double knots. Decided by the topology and the boundaries' roles
/// alone, the same on all ranks.
DoubledDirections doubleKnotDirections(const BlockComplex& complex, const ConversionOptions& options);

/// Control points of a direction of `cells` cells, and its knots.
inline int controlPointCount(int cells, bool doubled)
{
  return !doubled ? cells + 3 : cells == 1 ? 8 : cells == 2 ? 9 : cells + 5;
}
std::vector<double> volumeKnots(int cells, bool doubled);

/// One new control point of a direction with double knots: (sum of weights[i] b_(first + i)) / denominator.
struct KnotInsertionStencil
{
  int first = 0;
  int terms = 1;
  std::array<double, 4> weights{ 1.0, 0.0, 0.0, 0.0 };
  double denominator = 1.0;
  /// The old point that it is nearest to.
  int nearest = 0;

  bool copies() const { return this->terms == 1; }
};
std::vector<KnotInsertionStencil> knotInsertion(int cells, bool doubled);

/// Before the knots are inserted, nets are made with room for them. Where a direction is doubled, b0, b1 and the last
/// two points are at its ends and b_i at i + 1: most points are where they stay.
///@{
/// Moves a net of (I+3)(J+3)(K+3) points and rules, at the start of `storage`, there.
void makeRoom(const Ijk& cells, const std::array<bool, 3>& doubled, const ControlNetStorage& storage);
/// Inserts the double knots into a net with room for them. Shared points get the same bits in all blocks.
void insertDoubleKnots(const Ijk& cells, const std::array<bool, 3>& doubled, const ControlNetStorage& storage);
///@}

} // namespace bsv
