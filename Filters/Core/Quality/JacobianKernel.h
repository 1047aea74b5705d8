// SPDX-License-Identifier: BSD-3-Clause
/// @file JacobianKernel.h
/// Bernstein coefficients of the Jacobian determinant of B-spline spans, several spans side by side in the lanes of
/// vector registers.
///
/// A lane never touches another one, nothing is fused or reordered: the coefficients of a span are the same bits for
/// every instruction set, lane and neighbour. JacobianBounds.h is the interface for everybody else.
#pragma once

#include "Volume/BSplineVolume.h"

#include <array>
#include <vector>

namespace bsv
{

/// What the kernel is compiled for. Its results do not depend on it.
enum class InstructionSet
{
  Portable, ///< 2 lanes
  Avx2,     ///< 4 lanes
  Avx512    ///< 8 lanes
};

/// Those that this machine has, the fastest last.
const std::vector<InstructionSet>& instructionSets();

/// Some spans of equal degrees, one per lane. The arrays hold the numbers of all lanes of an entry next to each other:
/// entry n of lane l is [n * lanes + l].
///
/// With H = (x, y, z), or (w, w x, w y, w z) for a rational span, and Bezier points b of H, the scaled coefficients of
/// dH/du are
///     p C(p-1, i) C(q, j) C(r, k) (b(i+1, j, k) - b(i, j, k))
/// for degrees p, q, r, and those of a product are the convolution of those of its factors
/// (R. T. Farouki, V. T. Rajan, Algorithms for polynomials in Bernstein form, CAGD 5, 1988,
/// doi:10.1016/0167-8396(88)90016-7). The determinant is
///     D = det(H_u, H_v, H_w), of degree 3 p - 1, or D = det(H, H_u, H_v, H_w) = w^4 det J, of degree 4 p - 1,
/// per direction, expanded along the rows.
class JacobianBatch
{
public:
  /// Fixed-size loops for frequent degrees give the same bits as those for any degree (`specialised` = false).
  JacobianBatch(const std::array<int, 3>& degree, bool rational, InstructionSet instructions, bool specialised = true);

  JacobianBatch(const JacobianBatch&) = delete;
  void operator=(const JacobianBatch&) = delete;

  /// Computes everything below from control, weights and sign.
  void compute();

  const std::array<int, 3> degree;
  /// 3, or 4 with the weight first.
  const int components;
  const int lanes;

  ///@{
  /// Input. Control points: [component][point, first direction fastest]; of a rational span w and w times the point.
  /// Bezier weights per direction as bezierWeights() gives them. The determinant is multiplied by sign, 1 or -1.
  double* control;
  std::array<double*, 3> weights;
  double* sign;
  ///@}

  ///@{
  /// Output. D: coefficientCounts, first direction fastest, and the smallest and largest coefficient.
  std::array<int, 3> coefficientCounts;
  double* coefficients;
  double* lowest;
  double* highest;
  /// Largest magnitude of component c of H (row 0; only rational spans), H_u, H_v, H_w: [4 row + c].
  double* magnitudes;
  /// Smallest and largest Bezier point of w, of rational spans.
  double* lowestWeight;
  double* highestWeight;
  /// At the span's eight corners and its centre: smallest det J / (|x_u| |x_v| |x_w|), 0 where a factor is, and
  /// largest |cos| of an angle between two of x_u, x_v, x_w.
  double* scaledJacobian;
  double* cosine;
  ///@}

  /// Rounding errors on the way from the scaled derivatives' Bezier points to a coefficient of D, in the longest chain.
  int roundings() const;

private:
  friend struct JacobianKernel;

  struct alignas(64) Line
  {
    double values[8];
  };
  std::vector<Line> Memory;
  InstructionSet Instructions;
  bool Specialised;

  /// Points per direction of the derivatives H (0), H_u, H_v, H_w, and of the products of the first 2 and 3 of H_u,
  /// H_v, H_w.
  std::array<std::array<int, 3>, 4> DerivativeCounts;
  std::array<int, 3> MinorCounts;
  std::array<int, 3> DeterminantCounts;
  /// Scales: of the derivatives' points, and 1 / binomials of D.
  std::array<std::vector<double>, 4> DerivativeScales;
  std::vector<double> CoefficientScales;

  std::array<double*, 2> Bezier;
  std::array<std::array<double*, 4>, 4> Derivatives;
  std::array<std::array<double*, 4>, 4> Minors;
  std::array<double*, 4> Determinants;
};

} // namespace bsv
