// SPDX-License-Identifier: BSD-3-Clause
/// @file BezierSegments.h
/// Bezier form of B-spline spans and its halving, on control points of any vector type.
#pragma once

#include "Volume/BSplineVolume.h"

#include <vector>

namespace bsv
{

/// Bezier points of span `span` of a B-spline, from its control points first..first + degree (`at(i)` gives the i-th of
/// them): b_j is the blossom at degree - j times the left and j times the right end of the span.
template <typename Point, typename At>
void bezierOfSpan(int degree, const std::vector<double>& knots, int span, const At& at, Point* bezier)
{
  std::vector<Point> work(degree + 1);
  for (int j = 0; j <= degree; ++j)
  {
    for (int i = 0; i <= degree; ++i)
    {
      work[i] = at(i);
    }
    for (int r = 1; r <= degree; ++r)
    {
      const double x = r <= degree - j ? knots[span] : knots[span + 1];
      for (int i = degree; i >= r; --i)
      {
        const double low = knots[span - degree + i];
        const double high = knots[span + 1 + i - r];
        const double s = (x - low) / (high - low);
        work[i] = (1.0 - s) * work[i - 1] + s * work[i];
      }
    }
    bezier[j] = work[degree];
  }
}

/// bezierOfSpan() as a matrix: Bezier point j is sum_i weights[j (degree + 1) + i] times control point
/// span - degree + i. Reversing the knots mirrors the weights exactly.
/// @param[out] weights (degree + 1)^2 numbers; degree is at most MaxDegree.
inline void bezierWeights(int degree, const std::vector<double>& knots, int span, double* weights)
{
  const int size = degree + 1;
  // The knots that matter, seen from the other end.
  std::vector<double> mirrored(2 * size);
  for (int i = 0; i < 2 * size; ++i)
  {
    mirrored[i] = -knots[span + 1 + degree - i];
  }
  double forward[MaxDegree + 1];
  double backward[MaxDegree + 1];
  for (int i = 0; i < size; ++i)
  {
    bezierOfSpan(
      degree, knots, span, [i](int k) { return k == i ? 1.0 : 0.0; }, forward);
    bezierOfSpan(
      degree, mirrored, degree, [&](int k) { return k == degree - i ? 1.0 : 0.0; }, backward);
    for (int j = 0; j < size; ++j)
    {
      weights[j * size + i] = 0.5 * (forward[j] + backward[degree - j]);
    }
  }
}

/// Halves a Bezier curve of `degree` with `stride` between its points in memory: the left half replaces `points`, the
/// right half goes to `right`.
template <typename Point>
void halveBezier(int degree, int stride, Point* points, Point* right)
{
  right[degree * stride] = points[degree * stride];
  for (int r = 1; r <= degree; ++r)
  {
    for (int i = degree; i >= r; --i)
    {
      points[i * stride] = 0.5 * (points[(i - 1) * stride] + points[i * stride]);
    }
    right[(degree - r) * stride] = points[degree * stride];
  }
}

} // namespace bsv
