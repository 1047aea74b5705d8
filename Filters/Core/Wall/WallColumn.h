// SPDX-License-Identifier: BSD-3-Clause
/// @file WallColumn.h
/// The curve of the volume that rises from a wall vertex: the height and the growth of its first cells.
#pragma once

#include "Base/Types.h"

#include <array>
#include <vector>

namespace bsv
{

/// The cubic basis on clamped integer knots at u in [0, cells]: four values, that of control point `first` first.
struct WallBasis
{
  int first;
  std::array<double, 4> values;

  WallBasis(int cells, double u);
};

/// The basis at knot u = m: what the reversed direction has at cells - m, mirrored bit for bit.
WallBasis basisAtKnot(int cells, int m);

/// The curve that rises from a wall vertex: its first control points.
struct WallColumn
{
  /// Control points at the wall that the first two spans and the first cell behind them depend on.
  static constexpr int Depth = 6;

  int cells = 0;
  std::array<Vec3, Depth> points;

  Vec3 at(double u) const;
  double firstHeight(int level) const { return (this->at(std::ldexp(1.0, -level)) - this->points[0]).norm(); }

  /// Largest ratio, or its inverse, of neighbouring cells up to the first one behind the second span.
  double growth(int level) const;
};

/// A mesh line as a curve: the column of its points, with the inserted one at the fraction `e` = 1 - c.
WallColumn lineColumn(const std::vector<Vec3>& line, double e);

/// 1 - c of the line that makes the first cell as high as `target`, not limited.
double neededFraction(const std::vector<Vec3>& line, double target, int level);

/// 1 - c that matches the growth of the layers, as in FirstLayer.h.
double smoothFraction(const std::vector<Vec3>& line);

} // namespace bsv
