// SPDX-License-Identifier: BSD-3-Clause
/// @file LayerRules.h
/// The two-dimensional rules: control points around one vertex of a layer of quadrilaterals.
///
/// A *fan* is the centre, its spokes (next points along the edges) and its sectors (opposite corners of the
/// quadrilaterals; sector i lies between spokes i and i+1). A closed fan of n sectors has n spokes, an open one n + 1.
/// A rule turns the fan into control points: the centre, one inserted point along every spoke, one inserted point
/// inside every sector.
#pragma once

#include "Base/Types.h"
#include "Conversion/Conversion.h"

#include <vector>

namespace bsv
{

struct Fan
{
  bool closed = true;
  Vec3 center = Vec3::Zero();
  std::vector<Vec3> spokes;
  std::vector<Vec3> sectors;

  int sectorCount() const { return static_cast<int>(this->sectors.size()); }
  int spokeCount() const { return static_cast<int>(this->spokes.size()); }
  /// Spoke at the end of sector i.
  int nextSpoke(int i) const { return (i + 1) % this->spokeCount(); }
};

/// Smooth rule.
///
/// Closed fan of n sectors:
/// - centre: the limit point (n^2 p + 4 sum e + sum f) / (n (n + 5)) (3.31);
/// - spoke i: b_i = P + a_i, a_i = mu T_i, where T_i is the Catmull-Clark limit tangent along spoke i, scaled to be the
///   spoke itself on the affine regular fan with f_i = e_i + e_(i+1), and mu = (1 + cos(2 pi / n) / 3) / 3;
/// - sector: P + x_n (a_i + a_(i+1)) + S(a_i, a_(i+1)), x_n = (6 + g) / (3 (2 + g)), g = 2 cos(2 pi / n), where S is
/// the
///   vector-valued symmetric bilinear form of the quadratic that fits the fan best (least squares over the affine
///   regular fan): the second fundamental form estimated on the layer.
/// The fan of four is the tensor product of the masks [1/6 2/3 1/6] and [2/3 1/3]; there the general formulas give the
/// same. Every rule is linear in the points, so it commutes with affine maps and with the rule across the layers. (The
/// source projects the neighbours onto the tangent plane instead (5.42) and completes a parallelogram (5.43).)
///
/// Open fan (a border or crease runs through the first and last spoke): the one-dimensional rule on the border, inside
/// the same construction with the limit tangents of the border and 2 n in place of n.
///
/// `nearWeight[i]` is the weight c of the centre in the inserted point along spoke i (5.44), 2/3 except across walls.
/// `twist` chooses the inserted points of sectors at fans other than the regular ones.
///
/// A closed fan needs at least 3 sectors, an open one at least 2.
Fan smoothFan(const Fan& fan, Twist twist, const std::vector<double>& nearWeight);

/// smoothFan() of `count` regular fans at once, closed ones of four sectors or open ones of two, with the
/// knot-insertion weight: the same bits.
/// @param points, values per point of the fan (the centre, the spokes, the sectors) its `count` places.
void smoothRegularFans(
  bool closed, const std::vector<const Vec3*>& points, Index count, const std::vector<Vec3*>& values);

/// Rule for a centre that is given: inserted points along spokes between the centre and the values `along[i]` one step
/// down, in sectors by the regular mask [2/3 1/3] x [2/3 1/3] of the fan's points. `nearWeight` as in smoothFan.
Fan anchoredFan(
  const Fan& fan, const Vec3& center, const std::vector<Vec3>& along, const std::vector<double>& nearWeight);

/// How far the face behind a spoke keeps its points (FaceRule::keep): at the centre and one step down the spoke.
struct SpokeKeep
{
  double center = 0.0;
  double step = 0.0;

  bool any() const { return this->center > 0.0 || this->step > 0.0; }
};

struct CreasedFan
{
  Fan points;
  /// A smooth curve runs through two features; otherwise the centre is a corner and keeps its point.
  bool crease = false;
};

/// Whether kept spokes are more than one line across a regular fan: fadedFan() then blends the whole fan, and no point
/// of it is regular.
bool keptLinesMeet(bool closed, const std::vector<bool>& keptSpokes);

/// Rule for a closed fan that `features` (spokes, ascending, at least one) cut into groups of sectors. Two features
/// with two sectors or more on both sides are a crease: the centre and the points along the features follow the
/// one-dimensional rule, the groups are smooth open fans. All else is a corner (one sector between two smooth features
/// would have a Jacobian of 0). Groups in which `planarSectors` is set, and all at corners, are anchored; `keptSpokes`
/// keep their points there one step down; `keeps` as in fadedFan, for the spokes between the features.
CreasedFan creasedFan(const Fan& fan, const std::vector<int>& features, const std::vector<bool>& keptSpokes,
  const std::vector<bool>& planarSectors, Twist twist, const std::vector<double>& nearWeight,
  const std::vector<SpokeKeep>& keeps);

/// smoothFan, fading into creasedFan along spokes that keep their points. In regular fans the mask across such spokes
/// becomes fadedMask point by point, so that the rule along them stays as smooth as it was.
Fan fadedFan(const Fan& fan, Twist twist, const std::vector<double>& nearWeight, const std::vector<SpokeKeep>& keeps);

/// What is known of the body at an extraordinary vertex.
struct BodyFoot
{
  Vec3 point;
  /// Unit normal, to either side.
  Vec3 normal;
  /// II(a, b) = a^T curvature b with respect to `normal`; only if `hasCurvature`, else it is estimated on the fan.
  Eigen::Matrix3d curvature = Eigen::Matrix3d::Zero();
  bool hasCurvature = false;
  /// x_uv / |x_uv| of the surface in its own parameters, or 0, for Twist::Literal.
  Eigen::Vector3d mixedDirection = Eigen::Vector3d::Zero();
  /// Neighbours are the offsets of smoothFan projected onto the tangent plane, which stay affinely regular as exact G1
  /// needs, in place of the projected border points of (5.38).
  bool regularOffsets = false;
};

/// Fan of an extraordinary body vertex with a known foot on the given surface ((5.38) to (5.41) with the twist from
/// the second fundamental form): the centre is the foot point, the neighbours are the border points (f + 4 e + f) / 6
/// projected onto the tangent plane, the inserted point of a sector is P + x_n (a + b) + n II(a, b).
/// Closed fans of at least 3 sectors only. Orthogonal projection does not commute with affine maps other than
/// similarities.
Fan projectedFan(const Fan& fan, const BodyFoot& foot, Twist twist);

/// The same for a smooth group of a creased fan, `points`: its sectors first..first + size - 1 between two features.
/// Only the side of the surface that the group lies on counts, each side of a crease has its own foot. Centre and
/// spokes of the features stay; spokes between them are projected onto the tangent plane. `foot` must have a curvature.
/// @param mesh the mesh points that `points` come from.
void projectGroup(Fan& points, const Fan& mesh, int first, int size, const BodyFoot& foot, Twist twist);

/// Unit normal of the Catmull-Clark limit surface at the centre of a closed smooth fan (4.18), zero where the limit
/// tangents are parallel. Its sign follows the sense of the fan.
Vec3 limitNormal(const Fan& fan);

/// Interpolation between the 2^n corners of a box at the point whose weight of side 0 is `nearWeight[d]` in direction
/// d; corner index has bit d set for side 1. The bits do not depend on the order of the directions.
Vec3 multilinear(const Vec3* corners, const double* nearWeight, int n);

/// [1/6 2/3 1/6]: (a + 4 p + b) / 6.
inline Vec3 smoothMask(const Vec3& a, const Vec3& p, const Vec3& b)
{
  return ((a + b) + 4.0 * p) / 6.0;
}

/// (1 - keep) smoothMask + keep p.
inline Vec3 fadedMask(const Vec3& a, const Vec3& p, const Vec3& b, double keep)
{
  const Vec3 smooth = smoothMask(a, p, b);
  return keep > 0.0 ? Vec3(smooth + keep * (p - smooth)) : smooth;
}

/// [c, 1 - c] with the knot-insertion weight 2/3 evaluated exactly as (2 a + b) / 3.
inline Vec3 insertMask(const Vec3& a, const Vec3& b, double nearWeight)
{
  if (nearWeight == KnotInsertion)
  {
    return (2.0 * a + b) / 3.0;
  }
  return nearWeight * a + (1.0 - nearWeight) * b;
}

} // namespace bsv
