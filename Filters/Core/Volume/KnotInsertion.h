// SPDX-License-Identifier: BSD-3-Clause
/// @file KnotInsertion.h
/// B-spline blocks cut in two without a change of their shape.
///
/// Source: L. Piegl, W. Tiller, The NURBS Book, 2nd ed., Springer 1997, equation (5.15).
#pragma once

#include "Volume/BSplineVolume.h"

#include <array>
#include <vector>

namespace bsv
{

/// A block that owns its control points.
struct OwnedVolume
{
  /// Its pointers are those of the two lists below.
  BSplineVolume view;
  std::vector<double> points;
  /// Empty in a polynomial volume.
  std::vector<double> weights;
};

/// The two parts of a block before and behind a knot, with clamped ends there. Knots keep their values.
/// @param knot a value inside the range of the direction.
/// Of a block on another rank only the knots are cut.
/// @throws Error if `knot` is not inside.
std::array<OwnedVolume, 2> cutVolume(const BSplineVolume& volume, int direction, double knot);

} // namespace bsv
