// SPDX-License-Identifier: BSD-3-Clause
/// @file BSplineVolume.h
/// One tensor-product B-spline volume block and its evaluation.
///
///   x(u,v,w) = sum_abc N_a(u) N_b(v) N_c(w) P_abc
///
/// and, where there are weights, the rational
///
///   x(u,v,w) = sum_abc N_a(u) N_b(v) N_c(w) w_abc P_abc / sum_abc N_a(u) N_b(v) N_c(w) w_abc.
///
/// Control points are stored a fastest, then b, then c. Knots are data: any degree up to MaxDegree and any
/// non-decreasing knot vector.
///
/// Source: L. Piegl, W. Tiller, The NURBS Book, 2nd ed., Springer 1997, doi:10.1007/978-3-642-59223-2.
#pragma once

#include "Base/Types.h"

#include <array>
#include <string>
#include <vector>

namespace bsv
{

/// Largest degree of a B-spline in any direction; the smallest is 1.
constexpr int MaxDegree = 8;

/// View of a block: knots owned, control points and weights not.
struct BSplineVolume
{
  std::array<int, 3> degree{ 3, 3, 3 };
  /// degree + 1 + count(d) non-decreasing values per direction.
  std::array<std::vector<double>, 3> knots;
  /// count(0) * count(1) * count(2) triples.
  const double* points = nullptr;
  /// One positive weight per control point, or null: a polynomial volume. Points are not multiplied by them.
  const double* weights = nullptr;
  /// The rank that has points and weights; on the others both are null.
  int rank = 0;

  int count(int direction) const
  {
    return static_cast<int>(this->knots[direction].size()) - this->degree[direction] - 1;
  }
};

/// The clamped integer knots {0,0,0,0,1,2,..,n-1,n,n,n,n} of a cubic with `cells` spans (equal spacing in all
/// blocks is what lets blocks of unequal size join C2). @throws Error for fewer than one cell.
std::vector<double> clampedIntegerKnots(int cells);

/// Indices s of the non-empty spans [knots[s], knots[s + 1]) of the domain [knots[degree], knots[size - 1 - degree]].
std::vector<int> nonEmptySpans(int degree, const std::vector<double>& knots);

/// Whether a volume is only continuous at a knot inside its domain: repeated as often as the degree, and at least
/// twice.
/// @param knot the first of its value
bool isRepeatedKnot(int degree, const std::vector<double>& knots, int knot);

/// @throws Error, beginning with `name`, unless degrees are 1..MaxDegree and every knot vector is finite and
/// non-decreasing, has at least 2 (degree + 1) knots and a non-empty domain, and repeats no knot inside the domain more
/// than degree times (the volume would be torn there), weights are finite and positive, and points here are finite.
void checkBSplineVolume(const BSplineVolume& volume, const std::string& name);

/// w x, w y, w z and w of every control point, with w = 1 in a polynomial volume.
std::vector<double> homogeneousNet(const BSplineVolume& volume);

/// The `degree` + 1 B-splines that are not zero on one span, or their derivatives, at one parameter u.
///
/// The knots are given by their distances to u: left[j] = u - t(s + 1 - j) and right[j] = t(s + j) - u for j
/// = 1..degree (entry 0 is not used); s is the span. Reversing the direction exchanges left and right, and gives
/// exactly the mirrored values. On a knot of multiplicity `degree` the values are exactly 1 and 0.
///
/// Recurrence (2.5) of Piegl and Tiller for the first degree - order steps, then (2.9) `order` times.
/// @param[out] values degree + 1 numbers: that of basis function s - degree first.
void basisFunctions(int degree, int order, const double* left, const double* right, double* values);

/// Value (derivative = {0,0,0}) or mixed partial derivative at `uvw`, which must lie in the knots' range.
/// On a knot the polynomial of the span to its right is taken, on the last knot that of the last span.
/// Derivatives of rational volumes: quotient rule, (4.20) of Piegl and Tiller for three parameters.
/// @throws Error if `uvw` lies outside or a derivative is negative.
Vec3 evaluate(const BSplineVolume& volume, const Vec3& uvw, const std::array<int, 3>& derivative = { 0, 0, 0 });

} // namespace bsv
