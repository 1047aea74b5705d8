// SPDX-License-Identifier: BSD-3-Clause
/// @file JacobianPenalty.h
/// How far a tricubic span is from a positive Jacobian determinant, as a smooth function of its control points.
///
///   f = sum over the 9^3 Bernstein coefficients B of det J of max(0, t - B / s)^2
///
/// s is the volume that the span should have, with the sign that it should have; t is the least ratio that is wanted.
/// f = 0 proves det J >= t s.
#pragma once

#include "Base/Types.h"

#include <array>
#include <vector>

namespace bsv
{

/// The 4^3 control points of a span, first direction fastest.
using SpanControl = std::array<Vec3, 64>;

struct SpanPenalty
{
  double value = 0.0;
  /// Smallest B / s.
  double least = 0.0;
  /// Of the value.
  SpanControl gradient;
};

/// @param bezier per direction the weights of bezierWeights() for degree 3.
SpanPenalty spanPenalty(
  const SpanControl& control, const std::array<std::array<double, 16>, 3>& bezier, double scale, double threshold);

} // namespace bsv
