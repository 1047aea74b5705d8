// SPDX-License-Identifier: BSD-3-Clause
#include "BSplineVolume.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace bsv
{

namespace
{

constexpr char Axes[] = "uvw";

struct LocalBasis
{
  int first;
  std::array<double, MaxDegree + 1> values;
};

LocalBasis localBasis(int degree, int order, const std::vector<double>& knots, double u, char axis)
{
  const std::size_t count = knots.size() - degree - 1;
  if (!(u >= knots[degree] && u <= knots[count]))
  {
    std::ostringstream text;
    text << axis << " = " << u << " lies outside the knots' range " << knots[degree] << ".." << knots[count];
    throw Error(text.str());
  }
  // The span to the right of u; at the end, the last one that is not empty.
  auto next = std::upper_bound(knots.begin() + degree, knots.begin() + count, u);
  if (u == knots[count])
  {
    next = std::lower_bound(knots.begin() + degree, knots.begin() + count, u);
  }
  const int span = static_cast<int>(next - knots.begin()) - 1;

  double left[MaxDegree + 1];
  double right[MaxDegree + 1];
  for (int j = 1; j <= degree; ++j)
  {
    left[j] = u - knots[span + 1 - j];
    right[j] = knots[span + j] - u;
  }
  LocalBasis basis{ span - degree, {} };
  basisFunctions(degree, order, left, right, basis.values.data());
  return basis;
}

} // namespace

std::vector<double> clampedIntegerKnots(int cells)
{
  if (cells < 1)
  {
    throw Error("clamped knots need at least one cell, not " + std::to_string(cells));
  }
  std::vector<double> knots(static_cast<std::size_t>(cells) + 7);
  for (std::size_t i = 0; i < knots.size(); ++i)
  {
    knots[i] = std::min(std::max(static_cast<double>(i) - 3.0, 0.0), static_cast<double>(cells));
  }
  return knots;
}

std::vector<int> nonEmptySpans(int degree, const std::vector<double>& knots)
{
  std::vector<int> spans;
  for (int s = degree; s + degree + 1 < static_cast<int>(knots.size()); ++s)
  {
    if (knots[s] < knots[s + 1])
    {
      spans.push_back(s);
    }
  }
  return spans;
}

void checkBSplineVolume(const BSplineVolume& volume, const std::string& name)
{
  for (int d = 0; d < 3; ++d)
  {
    const auto fail = [&](const std::string& what) { throw Error(name + ": " + what + " in direction " + Axes[d]); };
    const int degree = volume.degree[d];
    const std::vector<double>& knots = volume.knots[d];
    if (degree < 1 || degree > MaxDegree)
    {
      fail("degree " + std::to_string(degree) + " is not in 1.." + std::to_string(MaxDegree));
    }
    if (knots.size() < 2 * static_cast<std::size_t>(degree + 1))
    {
      fail(std::to_string(knots.size()) + " knots are too few for degree " + std::to_string(degree));
    }
    for (std::size_t i = 0; i < knots.size(); ++i)
    {
      if (!std::isfinite(knots[i]))
      {
        fail("knot " + std::to_string(i) + " is not finite");
      }
      if (i > 0 && knots[i] < knots[i - 1])
      {
        fail("knot " + std::to_string(i) + " is smaller than the one before it");
      }
    }
    const std::size_t count = knots.size() - degree - 1;
    if (!(knots[degree] < knots[count]))
    {
      fail("the knots' range is empty");
    }
    for (std::size_t i = degree + 1; i + degree < knots.size(); ++i)
    {
      if (knots[i] == knots[i + degree] && knots[i] > knots[degree] && knots[i] < knots[count])
      {
        fail("knot " + std::to_string(i) + " is repeated more than " + std::to_string(degree) + " times");
      }
    }
  }
}

void basisFunctions(int degree, int order, const double* left, const double* right, double* values)
{
  if (order > degree)
  {
    std::fill(values, values + degree + 1, 0.0);
    return;
  }
  values[0] = 1.0;
  for (int j = 1; j <= degree; ++j)
  {
    double saved = 0.0;
    for (int r = 0; r < j; ++r)
    {
      const double support = right[r + 1] + left[j - r];
      if (j <= degree - order)
      {
        const double old = values[r];
        values[r] = saved + old * (right[r + 1] / support);
        saved = old * (left[j - r] / support);
      }
      else
      {
        const double slope = j * (values[r] / support);
        values[r] = saved - slope;
        saved = slope;
      }
    }
    values[j] = saved;
  }
}

Vec3 evaluate(const BSplineVolume& volume, const Vec3& uvw, const std::array<int, 3>& derivative)
{
  std::array<LocalBasis, 3> basis;
  for (int d = 0; d < 3; ++d)
  {
    if (derivative[d] < 0)
    {
      throw Error("derivative " + std::to_string(derivative[d]) + " in direction " + Axes[d] + " is negative");
    }
    basis[d] = localBasis(volume.degree[d], derivative[d], volume.knots[d], uvw[d], Axes[d]);
  }

  const Index rowStride = volume.count(0);
  const Index layerStride = rowStride * volume.count(1);
  Vec3 sum = Vec3::Zero();
  for (int c = 0; c <= volume.degree[2]; ++c)
  {
    Vec3 layer = Vec3::Zero();
    for (int b = 0; b <= volume.degree[1]; ++b)
    {
      const double* point =
        volume.points + 3 * (basis[0].first + (basis[1].first + b) * rowStride + (basis[2].first + c) * layerStride);
      Vec3 row = Vec3::Zero();
      for (int a = 0; a <= volume.degree[0]; ++a, point += 3)
      {
        row += basis[0].values[a] * Eigen::Map<const Vec3>(point);
      }
      layer += basis[1].values[b] * row;
    }
    sum += basis[2].values[c] * layer;
  }
  return sum;
}

} // namespace bsv
