// SPDX-License-Identifier: BSD-3-Clause
/// @file SurfaceTrace.h
/// What a join needs to know of one block: the face, with the derivatives across it.
#pragma once

#include "Volume/BSplineVolume.h"

#include <Eigen/Core>

#include <array>
#include <vector>

namespace bsv
{

/// Homogeneous value, first and second outward derivative: 3 x (x y z w). w is not used for polynomial volumes.
using Layers = Eigen::Array<double, 12, 1>;
using Homogeneous = Eigen::Array<double, 4, 1>;

/// B-spline surface, or curve with a second axis of degree 0, of Layers.
struct Trace
{
  std::array<int, 2> degree{ 0, 0 };
  std::array<int, 2> count{ 1, 1 };
  std::array<std::vector<double>, 2> knots{ { { 0.0, 1.0 }, { 0.0, 1.0 } } };
  std::vector<Layers> net;
  bool rational = false;
  double length = 0.0; ///< of the first span across
  double size = 0.0;   ///< largest coordinate

  std::size_t points() const { return std::size_t(this->count[0]) * this->count[1]; }
  const Layers& at(int i, int j) const { return this->net[i + std::size_t(this->count[0]) * j]; }
};

/// Parameter of a block face, across it.
double faceParameter(const BSplineVolume& volume, int face);

/// A trace without its net, which needs no control points.
Trace emptyTrace(const BSplineVolume& volume, int face, int within);

/// The block face `face`; or, with `within` >= 0, its edge in the boundary face `within`.
Trace makeTrace(const BSplineVolume& volume, int face, int within);

/// A trace as numbers for another rank. The weights of a polynomial one are the same at all its points.
std::vector<double> packedTrace(const Trace& trace);

/// Completes an emptyTrace(). @return what follows in the numbers.
const double* unpackTrace(const double* numbers, Trace& trace);

} // namespace bsv
