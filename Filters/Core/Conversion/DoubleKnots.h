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

/// Per block and direction, whether its class has double knots. Decided by the topology and the boundaries' roles
/// alone, the same on all ranks.
std::vector<std::array<bool, 3>> doubleKnotDirections(const BlockComplex& complex, const ConversionOptions& options);

/// Control points of a direction of `cells` cells, and its knots.
int controlPointCount(int cells, bool doubled);
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

/// Inserts the double knots into a net of (I+3)(J+3)(K+3) points and rules, in place: `storage` has room for the larger
/// net. Shared points get the same bits in all blocks.
void insertDoubleKnots(const Ijk& cells, const std::array<bool, 3>& doubled, const ControlNetStorage& storage);

} // namespace bsv
