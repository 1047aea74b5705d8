// SPDX-License-Identifier: BSD-3-Clause
#include "Volume/BSplineVolume.h"

#include <algorithm>
#include <cmath>
#include <limits>
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

/// x, y, z and weight: the derivative of the numerator and of the denominator. The weight of a polynomial volume is 1.
Eigen::Vector4d homogeneous(const BSplineVolume& volume, const Vec3& uvw, const std::array<int, 3>& derivative)
{
  std::array<LocalBasis, 3> basis;
  for (int d = 0; d < 3; ++d)
  {
    basis[d] = localBasis(volume.degree[d], derivative[d], volume.knots[d], uvw[d], Axes[d]);
  }
  const Index rowStride = volume.count(0);
  const Index layerStride = rowStride * volume.count(1);
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  for (int c = 0; c <= volume.degree[2]; ++c)
  {
    Eigen::Vector4d layer = Eigen::Vector4d::Zero();
    for (int b = 0; b <= volume.degree[1]; ++b)
    {
      Index at = basis[0].first + (basis[1].first + b) * rowStride + (basis[2].first + c) * layerStride;
      Eigen::Vector4d row = Eigen::Vector4d::Zero();
      for (int a = 0; a <= volume.degree[0]; ++a, ++at)
      {
        const double weight = volume.weights ? volume.weights[at] : 1.0;
        const double* point = volume.points + 3 * at;
        row += basis[0].values[a] * Eigen::Vector4d(weight * point[0], weight * point[1], weight * point[2], weight);
      }
      layer += basis[1].values[b] * row;
    }
    sum += basis[2].values[c] * layer;
  }
  return sum;
}

double binomial(int n, int k)
{
  double result = 1.0;
  for (int i = 1; i <= k; ++i)
  {
    result = result * (n - k + i) / i;
  }
  return result;
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

bool isRepeatedKnot(int degree, const std::vector<double>& knots, int knot)
{
  const int last = static_cast<int>(knots.size()) - 1 - degree;
  return degree > 1 && knot > degree && knot + degree <= last && knots[knot] > knots[knot - 1] &&
    knots[knot] == knots[knot + degree - 1] && knots[knot] < knots[last];
}

namespace
{

/// Coordinates that are checked together.
constexpr Index Row = 4096;

} // namespace

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
  const Index points = Index(volume.count(0)) * volume.count(1) * volume.count(2);
  if (volume.points)
  {
    for (Index first = 0; first < 3 * points; first += Row)
    {
      // Whole rows at once, in vector registers; the place is looked for only if there is one.
      const Index last = std::min(first + Row, 3 * points);
      int bad = 0;
      for (Index i = first; i < last; ++i)
      {
        bad |= std::abs(volume.points[i]) <= std::numeric_limits<double>::max() ? 0 : 1;
      }
      for (Index i = first; bad && i < last; ++i)
      {
        if (!std::isfinite(volume.points[i]))
        {
          const Index n = i / 3;
          throw Error(name + ": control point (" + std::to_string(n % volume.count(0)) + ", " +
            std::to_string(n / volume.count(0) % volume.count(1)) + ", " +
            std::to_string(n / volume.count(0) / volume.count(1)) + ") is not finite");
        }
      }
    }
  }
  if (volume.weights)
  {
    for (Index i = 0; i < points; ++i)
    {
      if (!(volume.weights[i] > 0.0 && std::isfinite(volume.weights[i])))
      {
        std::ostringstream text;
        text << name << ": the weight of control point " << i << " is " << volume.weights[i] << ", not positive";
        throw Error(text.str());
      }
    }
  }
}

std::vector<double> homogeneousNet(const BSplineVolume& volume)
{
  const Index points = Index(volume.count(0)) * volume.count(1) * volume.count(2);
  std::vector<double> net;
  net.reserve(4 * points);
  for (Index i = 0; i < points; ++i)
  {
    const double weight = volume.weights ? volume.weights[i] : 1.0;
    for (int c = 0; c < 3; ++c)
    {
      net.push_back(weight * volume.points[3 * i + c]);
    }
    net.push_back(weight);
  }
  return net;
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
  for (int d = 0; d < 3; ++d)
  {
    if (derivative[d] < 0)
    {
      throw Error("derivative " + std::to_string(derivative[d]) + " in direction " + Axes[d] + " is negative");
    }
  }
  if (!volume.weights)
  {
    return homogeneous(volume, uvw, derivative).head<3>();
  }

  // All lower derivatives, in an order in which each follows those that it needs.
  const std::array<int, 3> counts{ derivative[0] + 1, derivative[1] + 1, derivative[2] + 1 };
  const auto slot = [&](int a, int b, int c) { return a + counts[0] * (b + counts[1] * c); };
  std::vector<Vec3> values(static_cast<std::size_t>(counts[0]) * counts[1] * counts[2]);
  std::vector<double> weights(values.size());
  for (int c = 0; c < counts[2]; ++c)
  {
    for (int b = 0; b < counts[1]; ++b)
    {
      for (int a = 0; a < counts[0]; ++a)
      {
        const Eigen::Vector4d point = homogeneous(volume, uvw, { a, b, c });
        weights[slot(a, b, c)] = point[3];
        Vec3 value = point.head<3>();
        for (int r = 0; r <= c; ++r)
        {
          for (int q = 0; q <= b; ++q)
          {
            for (int p = 0; p <= a; ++p)
            {
              if (p + q + r > 0)
              {
                value -= binomial(a, p) * binomial(b, q) * binomial(c, r) * weights[slot(p, q, r)] *
                  values[slot(a - p, b - q, c - r)];
              }
            }
          }
        }
        values[slot(a, b, c)] = value / weights[0];
      }
    }
  }
  return values.back();
}

} // namespace bsv
