// SPDX-License-Identifier: BSD-3-Clause
/// @file NURBSSurface.h
/// Rational tensor-product B-spline surfaces and their trimming: the patches of a body, and their local geometry.
///
///   x(u,v) = sum_ab N_a(u) N_b(v) w_ab P_ab / sum_ab N_a(u) N_b(v) w_ab
///
/// Control points are stored a fastest. Degrees are 1..MaxSurfaceDegree; knots are any non-decreasing vectors.
///
/// Source: L. Piegl, W. Tiller, The NURBS Book, 2nd ed., Springer 1997, doi:10.1007/978-3-642-59223-2; rational
/// derivatives are those of algorithm A4.4.
#pragma once

#include "Base/Types.h"

#include <array>
#include <string>
#include <vector>

namespace bsv
{

using Vec2 = Eigen::Vector2d;

/// Largest degree of a surface or of a trimming curve: what CAD kernels exchange.
constexpr int MaxSurfaceDegree = 25;

struct NURBSSurface
{
  std::array<int, 2> degree{ 3, 3 };
  /// degree + 1 + count(d) non-decreasing values per direction.
  std::array<std::vector<double>, 2> knots;
  /// count(0) * count(1) points, not multiplied by their weights.
  std::vector<Vec3> points;
  /// One positive weight per point, or empty: all 1.
  std::vector<double> weights;

  int count(int direction) const
  {
    return static_cast<int>(this->knots[direction].size()) - this->degree[direction] - 1;
  }
  /// Domain [first(d), last(d)] of parameter d.
  double first(int direction) const { return this->knots[direction][this->degree[direction]]; }
  double last(int direction) const { return this->knots[direction][this->count(direction)]; }
  bool rational() const { return !this->weights.empty(); }
};

/// A rational B-spline curve in the parameter plane of a surface.
struct ParameterCurve
{
  int degree = 1;
  std::vector<double> knots;
  std::vector<Vec2> points;
  /// One positive weight per point, or empty: all 1.
  std::vector<double> weights;

  double first() const { return this->knots[this->degree]; }
  double last() const { return this->knots[this->points.size()]; }
};

/// Closed chain of curves. Ends that do not meet exactly are joined by a straight line.
using TrimLoop = std::vector<ParameterCurve>;

/// A face of a body: the part of a surface that lies inside an odd number of its loops; without loops all of it.
struct BodyPatch
{
  std::string name;
  NURBSSurface surface;
  std::vector<TrimLoop> loops;
  /// Whether the outward normal is that of -(x_u x x_v).
  bool reversed = false;
};

/// @throws Error, beginning with `name`, unless degrees are 1..MaxSurfaceDegree, knot vectors are finite,
/// non-decreasing, at least 2 (degree + 1) long, with a non-empty domain, and repeat no knot inside it more than degree
/// times; there is one finite point per pair of basis functions; weights, if any, are as many, finite and positive.
void checkNURBSSurface(const NURBSSurface& surface, const std::string& name);

/// The same for the surface and the trimming curves of a patch. @throws Error, beginning with `name`.
void checkBodyPatch(const BodyPatch& patch, const std::string& name);

/// Point and derivatives.
struct SurfaceDerivatives
{
  Vec3 x, u, v, uu, uv, vv;
};

/// Value and derivatives up to the second at (u,v), which is moved into the domain. On a knot the polynomial of the
/// span to its right is taken, on the last knot that of the last span.
SurfaceDerivatives evaluate(const NURBSSurface& surface, double u, double v);

/// Point of a trimming curve and its first two derivatives, at `t` moved into the curve's domain.
std::array<Vec2, 3> evaluate(const ParameterCurve& curve, double t);

/// Local geometry of a surface.
struct SurfaceGeometry
{
  Vec3 point = Vec3::Zero();
  /// Unit normal; zero only where the surface has none, not even as a limit.
  Vec3 normal = Vec3::Zero();
  /// First fundamental form: x_u.x_u, x_u.x_v, x_v.x_v.
  double E = 0.0, F = 0.0, G = 0.0;
  /// Second fundamental form: normal . x_uu, x_uv, x_vv.
  double L = 0.0, M = 0.0, N = 0.0;
  /// II(a,b) = a^T curvature b for any vectors a and b; the part along the normal counts nothing. Free of the
  /// parametrisation, and defined at poles too, where E G - F^2 = 0 and L, M, N say nothing.
  Eigen::Matrix3d curvature = Eigen::Matrix3d::Zero();
  /// Whether x_u and x_v are parallel or zero here; the normal and the curvature are limits from inside the domain.
  bool degenerate = false;
};

/// Geometry at (u,v), moved into the domain; with `reversed` the normal is -(x_u x x_v)/|..|, and L, M, N and the
/// curvature change their sign with it.
SurfaceGeometry surfaceGeometry(const NURBSSurface& surface, double u, double v, bool reversed = false);

/// Area of the patch, trimmed: Gauss quadrature of the integral over the enclosed domain, turned into one along the
/// loops by Green's theorem. Loops do not cross; their orientation does not matter. `tolerance` is the relative error
/// at which halving of intervals stops.
double patchArea(const BodyPatch& patch, double tolerance = 1e-9);

/// Parts of a surface between its kinks, the inner knots of multiplicity degree, where derivatives may jump. Control
/// points and knots are copied, not computed.
std::vector<NURBSSurface> smoothPieces(const NURBSSurface& surface);

/// The four sides of the domain, counter-clockwise from (first(0), first(1)).
TrimLoop domainLoop(const NURBSSurface& surface);

} // namespace bsv
