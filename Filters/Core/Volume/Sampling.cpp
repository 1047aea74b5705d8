// SPDX-License-Identifier: BSD-3-Clause
#include "Volume/Sampling.h"

#include "Volume/TensorPasses.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace bsv
{

namespace
{

/// Per direction the number of parts of every non-empty span.
using SpanParts = std::array<std::vector<int>, 3>;

SpanParts partsOf(const SpanLevels& levels)
{
  SpanParts parts = levels;
  for (std::vector<int>& direction : parts)
  {
    for (int& part : direction)
    {
      part = 1 << part;
    }
  }
  return parts;
}

std::array<WeightTable, 3> weightTables(
  const BSplineVolume& volume, const SpanParts& parts, const std::array<int, 3>& derivative)
{
  std::array<WeightTable, 3> tables;
  for (int d = 0; d < 3; ++d)
  {
    const int degree = volume.degree[d];
    const std::vector<double>& knots = volume.knots[d];
    const std::vector<int> spans = nonEmptySpans(degree, knots);
    std::vector<int> partsOfSpan(knots.size(), 1);
    for (std::size_t n = 0; n < spans.size(); ++n)
    {
      partsOfSpan[spans[n]] = parts[d][n];
    }
    // Only differences of neighbouring knots are used: they are what blocks share.
    tables[d] = weightTable(degree, knots, parts[d], [&](int s, int part, double* values) {
      const double fraction = static_cast<double>(part) / partsOfSpan[s];
      const double length = knots[s + 1] - knots[s];
      double left[MaxDegree + 1];
      double right[MaxDegree + 1];
      left[1] = fraction * length;
      right[1] = (1.0 - fraction) * length;
      for (int j = 2; j <= degree; ++j)
      {
        left[j] = left[j - 1] + (knots[s - j + 2] - knots[s - j + 1]);
        right[j] = right[j - 1] + (knots[s + j] - knots[s + j - 1]);
      }
      basisFunctions(degree, derivative[d], left, right, values);
    });
  }
  return tables;
}

/// Quotient rule on the samples of the numerator and of the denominator.
void sampleRational(const BSplineVolume& volume, const SpanParts& parts, const std::array<int, 3>& derivative,
  double* samples, const Execution& run)
{
  const std::vector<double> net = homogeneousNet(volume);
  std::vector<std::array<int, 3>> lower; // ascending: each after those that it needs
  for (int c = 0; c <= derivative[2]; ++c)
  {
    for (int b = 0; b <= derivative[1]; ++b)
    {
      for (int a = 0; a <= derivative[0]; ++a)
      {
        lower.push_back({ a, b, c });
      }
    }
  }
  std::array<int, 3> counts;
  for (int d = 0; d < 3; ++d)
  {
    counts[d] = std::accumulate(parts[d].begin(), parts[d].end(), 1);
  }
  const Index size = 4 * Index(counts[0]) * counts[1] * counts[2];
  // x, y, z of the derivatives of the volume, w those of the denominator.
  std::vector<std::vector<double>> values(lower.size());
  for (std::size_t n = 0; n < lower.size(); ++n)
  {
    Execution part = run;
    part.progress = [&](double fraction) { return run.progress((n + fraction) / lower.size()); };
    values[n].resize(size);
    tensorPasses({ { volume.count(0), volume.count(1), volume.count(2) }, 4, net.data() },
      weightTables(volume, parts, lower[n]), values[n].data(), part);
    for (std::size_t m = 1; m <= n; ++m)
    {
      // With orders 0 and 1 all binomial coefficients are 1.
      const std::array<int, 3> rest{ lower[n][0] - lower[m][0], lower[n][1] - lower[m][1], lower[n][2] - lower[m][2] };
      const auto found = std::find(lower.begin(), lower.end(), rest);
      if (found != lower.end())
      {
        const std::vector<double>& other = values[found - lower.begin()];
        for (Index i = 0; i < size; i += 4)
        {
          for (int c = 0; c < 3; ++c)
          {
            values[n][i + c] -= values[m][i + 3] * other[i + c];
          }
        }
      }
    }
    for (Index i = 0; i < size; i += 4)
    {
      for (int c = 0; c < 3; ++c)
      {
        values[n][i + c] /= values[0][i + 3];
      }
    }
  }
  for (Index i = 0; i < size; i += 4)
  {
    samples = std::copy_n(values.back().data() + i, 3, samples);
  }
}

void sampleParts(const BSplineVolume& volume, const SpanParts& parts, const std::array<int, 3>& derivative,
  double* samples, const Execution& run)
{
  if (volume.weights)
  {
    sampleRational(volume, parts, derivative, samples, run);
  }
  else
  {
    tensorPasses({ { volume.count(0), volume.count(1), volume.count(2) }, 3, volume.points },
      weightTables(volume, parts, derivative), samples, run);
  }
}

} // namespace

SpanLevels uniformLevels(const BSplineVolume& volume, int level, const std::string& name)
{
  if (level < 0 || level > MaxSamplingLevel)
  {
    throw Error(name + ": Level " + std::to_string(level) + " is not in 0.." + std::to_string(MaxSamplingLevel));
  }
  SpanLevels levels;
  for (int d = 0; d < 3; ++d)
  {
    levels[d].assign(nonEmptySpans(volume.degree[d], volume.knots[d]).size(), level);
  }
  return levels;
}

std::array<int, 3> sampleCounts(const SpanLevels& levels, const std::string& name)
{
  std::array<int, 3> counts;
  double bytes = 3 * sizeof(double);
  for (int d = 0; d < 3; ++d)
  {
    Index count = 1;
    for (const int level : levels[d])
    {
      count += Index(1) << level;
    }
    bytes *= static_cast<double>(count);
    if (count > std::numeric_limits<int>::max() || bytes > 9e18)
    {
      throw Error(name + ": Level " + std::to_string(*std::max_element(levels[d].begin(), levels[d].end())) +
        " has too many samples");
    }
    counts[d] = static_cast<int>(count);
  }
  return counts;
}

std::array<int, 3> sampleCounts(const BSplineVolume& volume, int level, const std::string& name)
{
  return sampleCounts(uniformLevels(volume, level, name), name);
}

std::vector<double> sampleParameters(const BSplineVolume& volume, int direction, const std::vector<int>& levels)
{
  const std::vector<double>& knots = volume.knots[direction];
  const std::vector<int> spans = nonEmptySpans(volume.degree[direction], knots);
  std::vector<double> parameters;
  for (std::size_t n = 0; n < spans.size(); ++n)
  {
    const int s = spans[n];
    const int parts = 1 << levels[n];
    for (int j = 0; j < parts; ++j)
    {
      parameters.push_back(knots[s] + (knots[s + 1] - knots[s]) * (static_cast<double>(j) / parts));
    }
  }
  parameters.push_back(knots[spans.back() + 1]);
  return parameters;
}

std::vector<double> sampleParameters(const BSplineVolume& volume, int direction, int level)
{
  return sampleParameters(volume, direction, uniformLevels(volume, level, "volume")[direction]);
}

void sample(const BSplineVolume& volume, const SpanLevels& levels, const std::array<int, 3>& derivative,
  double* samples, const Execution& run)
{
  for (const int order : derivative)
  {
    if (order < 0 || order > 1)
    {
      throw Error("samples of derivative order " + std::to_string(order) + " are not available, only 0 and 1");
    }
  }
  sampleParts(volume, partsOf(levels), derivative, samples, run);
}

void sample(
  const BSplineVolume& volume, int level, const std::array<int, 3>& derivative, double* samples, const Execution& run)
{
  sample(volume, uniformLevels(volume, level, "volume"), derivative, samples, run);
}

void sampleEqually(const BSplineVolume& volume, int parts, double* samples, const Execution& run)
{
  SpanParts all = uniformLevels(volume, 0, "volume");
  for (std::vector<int>& direction : all)
  {
    std::fill(direction.begin(), direction.end(), parts);
  }
  sampleParts(volume, all, { 0, 0, 0 }, samples, run);
}

} // namespace bsv
