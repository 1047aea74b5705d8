// SPDX-License-Identifier: BSD-3-Clause
/// @file BodyCases.h
/// Bodies whose geometry is known exactly, for tests of surfaces and closest points.
#pragma once

#include "Body/NURBSSurface.h"
#include "Volume/BSplineVolume.h"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace bodycases
{

using bsv::Index;
using bsv::NURBSSurface;
using bsv::Vec2;
using bsv::Vec3;

constexpr double Pi = 3.14159265358979323846;

/// Full circle of radius 1 around the origin: control points and weights of a quadratic with four spans.
inline void circle(std::vector<double>& knots, std::vector<Vec2>& points, std::vector<double>& weights)
{
  const double h = std::sqrt(0.5);
  knots = { 0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4 };
  points = { { 1, 0 }, { 1, 1 }, { 0, 1 }, { -1, 1 }, { -1, 0 }, { -1, -1 }, { 0, -1 }, { 1, -1 }, { 1, 0 } };
  weights = { 1, h, 1, h, 1, h, 1, h, 1 };
}

/// Profile (radius, height) of a surface of revolution around z: u runs around, v along the profile.
inline NURBSSurface revolved(int degree, const std::vector<double>& knots, const std::vector<Vec2>& profile,
  const std::vector<double>& profileWeights)
{
  NURBSSurface surface;
  std::vector<Vec2> ring;
  std::vector<double> ringWeights;
  surface.degree = { 2, degree };
  circle(surface.knots[0], ring, ringWeights);
  surface.knots[1] = knots;
  for (std::size_t j = 0; j < profile.size(); ++j)
  {
    for (std::size_t i = 0; i < ring.size(); ++i)
    {
      surface.points.emplace_back(profile[j][0] * ring[i][0], profile[j][0] * ring[i][1], profile[j][1]);
      surface.weights.push_back(profileWeights[j] * ringWeights[i]);
    }
  }
  return surface;
}

/// Sphere around the origin: a seam at u = 0 and 4, poles at v = 0 (south) and 2; x_u x x_v points outward.
inline NURBSSurface sphere(double r)
{
  const double h = std::sqrt(0.5);
  return revolved(
    2, { 0, 0, 0, 1, 1, 2, 2, 2 }, { { 0, -r }, { r, -r }, { r, 0 }, { r, r }, { 0, r } }, { 1, h, 1, h, 1 });
}

/// Torus around z: ring radius R, tube radius r; two seams; x_u x x_v points outward.
inline NURBSSurface torus(double R, double r)
{
  std::vector<double> knots;
  std::vector<Vec2> points;
  std::vector<double> weights;
  circle(knots, points, weights);
  for (Vec2& p : points)
  {
    p = Vec2(R + r * p[0], r * p[1]);
  }
  return revolved(2, knots, points, weights);
}

/// Rectangle [0, width] x [0, height] in the plane z = 0, parameters = coordinates.
inline NURBSSurface rectangle(double width, double height)
{
  NURBSSurface surface;
  surface.degree = { 1, 1 };
  surface.knots = { { { 0, 0, width, width }, { 0, 0, height, height } } };
  surface.points = { { 0, 0, 0 }, { width, 0, 0 }, { 0, height, 0 }, { width, height, 0 } };
  return surface;
}

/// Circle in a parameter plane, exactly.
inline bsv::TrimLoop circleLoop(const Vec2& center, double radius)
{
  bsv::ParameterCurve curve;
  curve.degree = 2;
  circle(curve.knots, curve.points, curve.weights);
  for (Vec2& p : curve.points)
  {
    p = center + radius * p;
  }
  return { curve };
}

/// Bumpy sheet over [0, 1]^2 of a given degree, with random heights, knots and, if wanted, weights.
inline NURBSSurface bumpy(
  unsigned int seed, std::array<int, 2> degree, std::array<int, 2> spans, double height, bool rational)
{
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  NURBSSurface surface;
  surface.degree = degree;
  std::array<int, 2> counts{};
  for (int d = 0; d < 2; ++d)
  {
    std::vector<double>& knots = surface.knots[d];
    knots.assign(degree[d] + 1, 0.0);
    for (int s = 1; s < spans[d]; ++s)
    {
      knots.push_back(knots.back() + 0.5 + unit(random));
    }
    knots.insert(knots.end(), degree[d] + 1, knots.back() + 1.0);
    counts[d] = surface.count(d);
  }
  for (int j = 0; j < counts[1]; ++j)
  {
    for (int i = 0; i < counts[0]; ++i)
    {
      surface.points.emplace_back(
        double(i) / (counts[0] - 1), double(j) / (counts[1] - 1), height * (2.0 * unit(random) - 1.0));
      if (rational)
      {
        surface.weights.push_back(0.5 + unit(random));
      }
    }
  }
  return surface;
}

/// The tensor-product spline that interpolates `map` on [-1, 1]^2 at its Greville abscissae.
template <typename Map>
NURBSSurface interpolated(int degree, int spans, const Map& map)
{
  NURBSSurface surface;
  surface.degree = { degree, degree };
  std::vector<double> knots(degree + 1, -1.0);
  for (int s = 1; s < spans; ++s)
  {
    knots.push_back(2.0 * s / spans - 1.0);
  }
  knots.insert(knots.end(), degree + 1, 1.0);
  surface.knots = { knots, knots };
  const int n = surface.count(0);
  std::vector<double> sites(n);
  Eigen::MatrixXd collocation = Eigen::MatrixXd::Zero(n, n);
  for (int i = 0; i < n; ++i)
  {
    for (int k = 1; k <= degree; ++k)
    {
      sites[i] += knots[i + k] / degree;
    }
    const int span = i == n - 1
      ? n - 1
      : static_cast<int>(std::upper_bound(knots.begin() + degree, knots.begin() + n, sites[i]) - knots.begin()) - 1;
    double left[bsv::MaxDegree + 1], right[bsv::MaxDegree + 1], values[bsv::MaxDegree + 1];
    for (int j = 1; j <= degree; ++j)
    {
      left[j] = sites[i] - knots[span + 1 - j];
      right[j] = knots[span + j] - sites[i];
    }
    bsv::basisFunctions(degree, 0, left, right, values);
    for (int k = 0; k <= degree; ++k)
    {
      collocation(i, span - degree + k) = values[k];
    }
  }
  const Eigen::MatrixXd inverse = collocation.inverse();
  std::array<Eigen::MatrixXd, 3> coordinates;
  coordinates.fill(Eigen::MatrixXd(n, n));
  for (int j = 0; j < n; ++j)
  {
    for (int i = 0; i < n; ++i)
    {
      const Vec3 x = map(sites[i], sites[j]);
      for (int d = 0; d < 3; ++d)
      {
        coordinates[d](i, j) = x[d];
      }
    }
  }
  for (Eigen::MatrixXd& values : coordinates)
  {
    values = inverse * values * inverse.transpose();
  }
  for (int j = 0; j < n; ++j)
  {
    for (int i = 0; i < n; ++i)
    {
      surface.points.emplace_back(coordinates[0](i, j), coordinates[1](i, j), coordinates[2](i, j));
    }
  }
  return surface;
}

/// A body that is no sphere and has no symmetry: x = r(d) d on unit directions d.
inline double starRadius(const Vec3& d)
{
  return 1.0 + 0.25 * d[0] * d[1] + 0.15 * d[2] * d[2] * d[2] + 0.12 * d[0] * d[1] * d[2] + 0.1 * d[0];
}

/// Its point in a direction of any length.
inline Vec3 starPoint(const Vec3& x)
{
  const Vec3 d = x.normalized();
  return starRadius(d) * d;
}

/// Its unit normal there: the gradient of |x| - r(x / |x|).
inline Vec3 starNormal(const Vec3& x)
{
  const double length = x.norm();
  const Vec3 d = x / length;
  const Vec3 slope(
    0.25 * d[1] + 0.12 * d[1] * d[2] + 0.1, 0.25 * d[0] + 0.12 * d[0] * d[2], 0.45 * d[2] * d[2] + 0.12 * d[0] * d[1]);
  return (d - (slope - slope.dot(d) * d) / starRadius(d)).normalized();
}

/// It as six patches, one per side of a cube turned by `turn`, in gnomonic parameters. Quintics of 24 spans: exact to
/// about 1e-8.
inline std::vector<bsv::BodyPatch> starPatches(const Eigen::Matrix3d& turn)
{
  std::vector<bsv::BodyPatch> patches;
  for (int side = 0; side < 6; ++side)
  {
    const auto map = [&](double u, double v) {
      const double sign = side % 2 ? 1.0 : -1.0;
      Vec3 x;
      x[side / 2] = sign;
      x[(side / 2 + 1) % 3] = sign > 0 ? u : v;
      x[(side / 2 + 2) % 3] = sign > 0 ? v : u;
      return starPoint(turn * x);
    };
    patches.push_back({ "side" + std::to_string(side), interpolated(5, 24, map), {}, false });
  }
  return patches;
}

} // namespace bodycases
