// SPDX-License-Identifier: BSD-3-Clause
/// @file Smoothness.h
/// How smoothly the blocks of a B-spline volume join: gaps, kinks and jumps of derivatives along every interface and
/// along the borders between the blocks on the wall.
///
/// A *join* is an interface, two faces that meet, or a wall border, two boundary faces that meet along a block edge.
/// Its two sides A and B are compared at equal parameters: those of B follow from those of A by the orientation of the
/// contact and, per direction, the affine map between the ranges of the knots. At a point of a join
///
///   x     is the position,
///   s, t  are the derivatives along the first and second axis of face A (of a wall border: s along it, no t),
///   n, n2 are the first and second derivative across the join, outwards from either side,
///
/// all taken from inside the block and with respect to the knots' own parameters. Knots are data: a block whose knots
/// across the join are spaced twice as wide as its neighbour's has derivatives half as large, and this is a jump. Then
///
/// - Gap: |x_A - x_B|, a length;
/// - NormalS: the angle, in degrees, between s_A x n_A and -s_B x n_B, the normals of the layers through s (surfaces
///   t = const) on both sides;
/// - NormalT: the same with t, for the layers s = const;
/// - Layer: the normal jump that counts, in degrees: the larger of NormalS and NormalT, but without a family that is
///   bound to kink because an extraordinary edge or a crease of the join runs along its layers (they turn there by
///   |180 - 720 / n| degrees if n blocks meet evenly). If this is so for both families the smaller one counts;
/// - Kink: the angle, in degrees, between n_A and -n_B, the curves that cross;
/// - C1: |n_A + n_B| / max(|n_A|, |n_B|);
/// - C2: h |n2_A - n2_B| / max(|n_A|, |n_B|), where h is the shorter of the two knot spans at the join.
///
/// So C2 is the part of the first derivative by which the two sides drift apart over one span: it depends neither on
/// the unit of length nor on a common factor of the knots, and stays finite where nothing is curved, as a ratio of
/// second derivatives would not. An angle with a vector that vanishes up to rounding, as at poles, is 0; so are C1 and
/// C2 where both n vanish.
///
/// The two normal jumps are kept apart because they mean different things: a join with n_B = -(a n_A + b s) is G1 for
/// the layers through s (NormalS is 0, whatever a and b) and kinks those through t. At an extraordinary edge along t
/// the layers through s are those that it pierces.
#pragma once

#include "Mesh/BlockMesh.h"
#include "Volume/BSplineVolume.h"

#include <functional>
#include <string>
#include <vector>

namespace bsv
{

enum class JumpKind
{
  Gap,
  NormalS,
  NormalT,
  Layer,
  Kink,
  C1,
  C2
};
constexpr int JumpKinds = 7;
using Jumps = std::array<double, JumpKinds>;

/// How far a join is smooth. Lower is worse.
enum class Continuity
{
  Open, ///< the sides have a gap
  C0,   ///< layers kink that need not (on a wall border: the wall does)
  G1,   ///< NormalS, NormalT or Layer is 0 all along
  C1,   ///< the first derivatives agree
  C2    ///< so do the second ones
};

/// "open", "C0", "G1", "C1", "C2".
const char* continuityName(Continuity continuity);

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

struct JumpMaximum
{
  double value = 0.0;
  /// Mean of both sides.
  Vec3 point = Vec3::Zero();
  /// Parameters in the two blocks.
  std::array<Vec3, 2> uvw{ Vec3::Zero(), Vec3::Zero() };
};

struct Join
{
  /// Sides A and B. On a wall border `face` is the boundary face and `edge` the block edge along which they meet.
  struct Side
  {
    int block = 0;
    int face = 0;
    int edge = -1;
  };
  std::array<Side, 2> sides;
  /// Code from A to B; for a wall border 2 if B runs the edge the other way, else 0.
  int orientation = 0;

  bool border() const { return this->sides[0].edge >= 0; }

  std::array<JumpMaximum, JumpKinds> worst;
  Continuity continuity = Continuity::C2;
  /// A wall border that is meant to be sharp: it counts in no total and is ranked last.
  bool crease = false;
  /// An interface that ends at a crease.
  bool atCrease = false;
  /// Whether the layers through s, or t, are bound to kink: an extraordinary edge or a crease of the interface runs
  /// along them.
  std::array<bool, 2> boundToKink{ false, false };
  /// The jump that keeps the join from being smoother, by which joins of the same continuity are ranked: Gap,
  /// Layer (for C0), C1 (for G1), or C2 (for C1 and C2).
  JumpKind rankedBy() const;

  /// Blocks around the four edges of an interface at s = 0, s = end, t = 0, t = end; negative on the outer boundary.
  /// Of a wall border only the first: blocks around it, negative.
  std::array<int, 4> valences{ 0, 0, 0, 0 };

  /// Spans along s and t. Where the knots of the two sides differ, a span of the join ends at each of either.
  std::array<int, 2> spans{ 1, 1 };
  /// Samples along s and t: samplesPerSpan * spans + 1, or 1 along the t of a wall border.
  std::array<int, 2> samples{ 0, 0 };
  /// On the rank of block A only: per sample, s fastest, the mean of both sides and the jumps. Where derivatives along
  /// the join are discontinuous there, the largest of all one-sided jumps.
  std::vector<Vec3> points;
  std::array<std::vector<double>, JumpKinds> values;
  /// On the rank of block A only: largest jump per span, s fastest.
  std::array<std::vector<double>, JumpKinds> spanMaxima;
};

/// Interior block edge at which other than four blocks meet.
struct ExtraordinaryCurve
{
  int valence = 0;
  /// One of the block edges. Only the block's rank has the points.
  int block = 0;
  int edge = 0;
  std::vector<Vec3> points;
  /// Largest jump over the joins that end here of the normals of the layers that the curve pierces. Degrees.
  std::vector<double> normalJump;
};

struct BlockSmoothness
{
  /// Maxima over the block's joins that are no creases.
  Jumps worst{};
  Continuity continuity = Continuity::C2;
  /// The worst of these joins, or -1.
  int worstJoin = -1;
};

struct SmoothnessResult
{
  /// One per interface, in their order, then the wall borders.
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

/// Points of a block face: `parts` equal parts of every span per axis.
struct FaceSamples
{
  std::array<int, 2> samples{ 0, 0 };
  std::vector<Vec3> points; ///< first face axis fastest
};
FaceSamples sampleFace(const BSplineVolume& volume, int face, int parts);

} // namespace bsv
