// SPDX-License-Identifier: BSD-3-Clause
/// @file LocalNet.h
/// Exact G1 around one vertex of a layer: the control points near it, the linear conditions on them, and the rule R0
/// that fulfils them with the least change.
///
/// Bicubic pieces with single knots cannot be G1 at an extraordinary vertex, those with a double knot at the first
/// inner knot, {0^4,1,1,2,3,..}, can (Peters, Fan 2010: at least two inner knots an edge, one of them double). The
/// *local net* are the control points whose index is at most `reach` in both directions: P in the centre, c_1 ..
/// c_reach along every spoke, f_ij in every sector. With r_i the f_i1 of the sector that starts at a spoke, l_i the
/// f_1i of the one that ends there, r_0 and l_0 the c_1 of the next and the previous spoke, g = 2 cos(2 pi / n), and
/// c_3' the Bezier point (c_2 + c_3) / 2 where the first span ends, the conditions are for each spoke
///
///   (a) l_0 + r_0 - 2 P = g (c_1 - P)
///   (b) l_1 + r_1 - 2 c_1 = g / 3 (c_3' - c_2)
///   (c) c_3' - 3 c_2 + 3 c_1 - P = 0           (the border is quadratic on its first span)
///   (d) l_i + r_i = 2 c_i,  i = 2 .. reach.
///
/// The derivatives across a border C(t) are then D_l + D_r = g (1 - t)^2 C'(t) on the first span, and C1 behind it.
/// Unequal first spans delta_k have the weights w_k = 1 / delta_k: every l + r - 2 c becomes w_(k-1) (l - c)
/// + w_(k+1) (r - c), and the right side w_k times as much. Open fans (creases, borders) of n sectors have the
/// conditions at their inner spokes, with g = 2 cos(pi / n); the curves of their first and last spoke are given.
/// A regular fan (n = 4 closed, n = 2 open) has g = 0.
///
/// All conditions are linear and the same in every layer: the volume F over such layers has F_s(left) + F_s(right)
/// = g (1 - t)^2 F_t across the face behind every spoke, on each layer and between layers.
#pragma once

#include "Base/Types.h"

#include <Eigen/Dense>

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace bsv
{

/// Cells along a spoke, as far as they matter to the knots there: 1, 2, or 3 for all larger numbers.
using SpokeKind = std::uint8_t;

inline SpokeKind spokeKind(int cells)
{
  return static_cast<SpokeKind>(cells < 3 ? cells : 3);
}

/// Knots along a spoke of that kind, from the vertex on: {0^4,1/3,1/3,2/3,2/3,1^4}, {0^4,1/2,1/2,1,3/2,3/2,2^4} or as
/// many of {0^4,1,1,2,3,..} as `count` says.
std::vector<double> spokeKnots(SpokeKind kind, int count);

/// Where the local net lies in a list of points: the centre, then spokes, then sectors.
struct LocalNetShape
{
  bool closed = true;
  int sectors = 0;
  int reach = 3;
  /// One per spoke.
  std::vector<SpokeKind> kinds;

  int spokes() const { return this->sectors + (this->closed ? 0 : 1); }
  int size() const { return 1 + this->reach * this->spokes() + this->reach * this->reach * this->sectors; }
  /// c_i of a spoke, i = 0 .. reach.
  int spoke(int k, int i) const { return i == 0 ? 0 : 1 + this->reach * k + i - 1; }
  /// Point `i` along the sector's first spoke and `j` along its second, both 0 .. reach.
  int sector(int k, int i, int j) const
  {
    return i == 0 ? this->spoke((k + 1) % this->spokes(), j)
      : j == 0    ? this->spoke(k, i)
                  : 1 + this->reach * this->spokes() + this->reach * this->reach * k + i - 1 + this->reach * (j - 1);
  }
  /// Calls body(point, i, j) for all points of a sector.
  template <typename Body>
  void forSector(int k, const Body& body) const
  {
    for (int j = 0; j <= this->reach; ++j)
    {
      for (int i = 0; i <= this->reach; ++i)
      {
        body(this->sector(k, i, j), i, j);
      }
    }
  }
  /// Calls body(point, k, i, j) for all points of all sectors; those of spokes come from both sides.
  template <typename Body>
  void forPoints(const Body& body) const
  {
    for (int k = 0; k < this->sectors; ++k)
    {
      this->forSector(k, [&](int point, int i, int j) { body(point, k, i, j); });
    }
  }
  /// Spokes that have conditions: all of a closed fan, the inner ones of an open one.
  bool isJoined(int k) const { return this->closed || (k > 0 && k < this->sectors); }
  /// First span of a spoke.
  double delta(int k) const;

  bool operator<(const LocalNetShape& other) const;
};

/// Conditions (a) to (d) as rows over the local net: pairs of point and coefficient.
using NetRow = std::vector<std::pair<int, double>>;
std::vector<NetRow> joinConditions(const LocalNetShape& shape);

/// Integrals over the sectors of products of derivatives of the surface, as a form on the net's points: sum over
/// sectors of |x_s|^2 + |x_t|^2 (order 1), or |x_ss|^2 + 2 |x_st|^2 + |x_tt|^2 (order 2).
Eigen::MatrixXd bendingForm(const LocalNetShape& shape, int order);

/// One condition, evaluated so that the sense of the fan does not matter to the last bit: the weighted sum of the two
/// differences to the centre, and the points of the right side with their coefficients.
struct JoinCondition
{
  int left = -1, right = -1, center = -1; ///< -1: no differences
  double leftWeight = 0.0, rightWeight = 0.0;
  std::array<std::pair<int, double>, 4> side{};
  int sideTerms = 0;

  Vec3 defect(const std::vector<Vec3>& net) const;
};

/// Makes a local net of reach 3 fulfil the conditions: P and all c_1 stay, of the other points (in an open fan but for
/// those on its borders) the change is the least one in sum of |d_s|^2 + |d_t|^2 plus 0.01 identity. Linear; the matrix
/// depends on the shape only, and is the same bit for bit wherever the fan begins and in either sense.
/// A net whose c_1 violate (a), where a layer keeps points, first has them moved as little as (a) needs if `moveFirst`.
class JoinRule
{
public:
  explicit JoinRule(const LocalNetShape& shape);

  void apply(std::vector<Vec3>& net, bool moveFirst = false) const;

private:
  void applyInOrder(std::vector<Vec3>& net, bool moveFirst) const;

  /// Where the points of the fan that the rule was computed for are in a given net; empty: in their places.
  std::vector<int> Order;
  std::vector<JoinCondition> Conditions, FirstConditions;
  /// Rows of the change of `Points` over the defects of the conditions (b) to (d).
  std::vector<int> Points;
  Eigen::MatrixXd Change;
  /// The same for (a) and the points c_1 of joined spokes.
  std::vector<int> FirstPoints;
  Eigen::MatrixXd FirstChange;
};

/// The explicit patches after Peters 2000 (PCCM, doi:10.1007/978-1-4471-0495-7_22), on closed fans of kind 3: with
/// e_k the affinely regular part of c_1 - P and d_k = ((c_2 + c_3) / 2 - P - 3 e_k) / 3, for even n without its
/// alternating part: c_1 = P + e, c_2 = P + 2 e + d, c_3 = P + 4 e + 5 d; f_11 nearest to the given ones under (b); l_i
/// and r_i shifted by half the defect of (d).
class PccmRule
{
public:
  explicit PccmRule(const LocalNetShape& shape);
  static bool fits(const LocalNetShape& shape);

  void apply(std::vector<Vec3>& net) const;

private:
  LocalNetShape Shape;
  std::vector<JoinCondition> First, Diagonal, Outer;
  std::vector<int> FirstPoints, DiagonalPoints;
  Eigen::MatrixXd FirstChange, DiagonalChange;
};

/// Largest defect of the conditions, over the largest |c_1 - P|.
double joinDefect(const LocalNetShape& shape, const std::vector<Vec3>& net);

} // namespace bsv
