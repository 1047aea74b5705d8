// SPDX-License-Identifier: BSD-3-Clause
/// @file Smoothness.h
/// How smoothly the blocks of a B-spline volume join: gaps, kinks and jumps of derivatives along every interface and
/// along the borders between the blocks on the wall.
///
/// What a join is and what the jumps are: Join.h.
#pragma once

#include "Mesh/BlockMesh.h"
#include "Quality/Join.h"
#include "Volume/BSplineVolume.h"

#include <functional>
#include <string>
#include <vector>

namespace bsv
{

struct SmoothnessOptions
{
  /// Every span is cut into this many parts per direction. Range 1..16. With as many parts as the degree no polynomial
  /// jump of position or derivatives can hide between the samples.
  int samplesPerSpan = 3;
  /// A wall border is a crease, wanted by the user, where more than half of its samples turn by more than this.
  /// Degrees, range [0, 180].
  double creaseAngle = 30.0;
  /// A join has a gap if it is wider than this fraction of the diagonal of the joins' bounding box. At least 0.
  double gapTolerance = 1e-10;
  /// Relative jumps, and angles in radians, up to this count as smooth. At least 0. Rounding leaves about the machine
  /// epsilon times the size of the coordinates over the thickness of the layer at the join.
  double tolerance = 1e-6;
  /// The outer faces that form the wall. Borders with other faces are not listed, but may be creases as well.
  std::function<bool(int block, int face)> isWall = [](int, int) { return true; };
  /// ControlPointRule per control point of each block, or null, also for blocks of other ranks; the list may be empty.
  /// A wall border whose inner control points are all made by crease or corner rules is a crease at any angle.
  std::vector<const unsigned char*> rules;
  /// How errors call a block.
  std::function<std::string(int block)> blockName = [](int block) { return "block " + std::to_string(block); };
};

struct BlockSmoothness
{
  /// Maxima over the block's joins that are no creases.
  Jumps worst{};
  JoinContinuity continuity = JoinContinuity::C2;
  /// The worst of these joins, or -1.
  int worstJoin = -1;
};

struct SmoothnessResult
{
  /// One per interface, in their order, then those inside blocks, then the wall borders. Interfaces of blocks that
  /// repeated knots part have one per pair of parts.
  std::vector<Join> joins;
  /// All joins, the worst first: by continuity, then by the jump Join::rankedBy(). Creases come last.
  std::vector<int> ranking;
  std::vector<ExtraordinaryCurve> curves;
  std::vector<BlockSmoothness> blocks;
  /// Maxima over all joins that are no creases.
  Jumps worst{};
};

/// Samples all joins and then refines the maxima: from the best samples of the spans that come within 20 % of the best
/// of their join (at most 8 of them) the jump is followed to its local maximum by quadratic fits, unless the samples
/// around promise too little, or it is below a thousandth of what counts as smooth.
///
/// The values are the same bits for any order and orientation of the blocks, if knots are spaced equally bit for bit in
/// both senses, and for any `run`, its ranks included: each measures the joins whose block A it has, from the traces
/// that the ranks of the blocks B send, and all know the maxima. Interfaces span whole faces; their ranges are not
/// used.
/// @param volumes must have passed checkBSplineVolume().
/// @throws Error for options out of range, control points of joins that are not finite, and what sharedEntities()
/// refuses; Aborted.
SmoothnessResult measureSmoothness(const std::vector<BSplineVolume>& volumes, const std::vector<Interface>& interfaces,
  const SmoothnessOptions& options = {}, const Execution& run = {});

} // namespace bsv
