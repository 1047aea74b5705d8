// SPDX-License-Identifier: BSD-3-Clause
/// @file Join.h
/// A join of two blocks, and what is measured along it.
///
/// A *join* is an interface, two faces that meet, or a wall border, two boundary faces that meet along a block edge.
/// Knots of full multiplicity part a block (VolumeParts.h): its parts are joined like blocks, by interfaces inside it
/// and by borders on its walls.
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

#include <array>
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
enum class JoinContinuity
{
  Open, ///< the sides have a gap
  C0,   ///< layers kink that need not (on a wall border: the wall does)
  G1,   ///< NormalS, NormalT or Layer is 0 all along
  C1,   ///< the first derivatives agree
  C2    ///< so do the second ones
};

/// "open", "C0", "G1", "C1", "C2".
const char* continuityName(JoinContinuity continuity);

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
  /// Sides A and B: faces of the blocks, or of a part of them. On a wall border `face` is the boundary face and `edge`
  /// the edge along which they meet.
  struct Side
  {
    int block = 0;
    int face = 0;
    int edge = -1;
    /// Of the block, u fastest; 0 if it is whole.
    int part = 0;
  };
  std::array<Side, 2> sides;
  /// Code from A to B; for a wall border 2 if B runs the edge the other way, else 0.
  int orientation = 0;

  bool border() const { return this->sides[0].edge >= 0; }
  /// Between two parts of one block, at a repeated knot.
  bool inner() const
  {
    return this->sides[0].block == this->sides[1].block && this->sides[0].part != this->sides[1].part;
  }

  std::array<JumpMaximum, JumpKinds> worst;
  JoinContinuity continuity = JoinContinuity::C2;
  /// A wall border that is meant to be sharp: it counts in no total and is ranked last.
  bool crease = false;
  /// An interface that ends at a crease.
  bool atCrease = false;
  /// Whether a crease or a reentrant edge of the outer boundary ends at one of its corners, and the largest jump of
  /// layers, in degrees, farther from such corners than two spans.
  bool atKinkedVertex = false;
  double layerJumpAway = 0.0;
  /// Whether the layers through s, or t, are bound to kink: an extraordinary edge or a crease of the interface runs
  /// along them.
  std::array<bool, 2> boundToKink{ false, false };
  /// The jump that keeps the join from being smoother, by which joins of the same continuity are ranked: Gap,
  /// Layer (for C0), C1 (for G1), or C2 (for C1 and C2).
  JumpKind rankedBy() const;

  /// Blocks around the four edges of an interface at s = 0, s = end, t = 0, t = end; negative on the outer boundary.
  /// Of a wall border the first: blocks around it, negative; the last two: blocks around the edges that leave the wall
  /// at its ends.
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

} // namespace bsv
