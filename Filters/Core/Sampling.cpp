// SPDX-License-Identifier: BSD-3-Clause
#include "Sampling.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace bsv
{

namespace
{

/// Weights of the control points at every sample of one direction. Zeros at the ends of a window are left out.
struct WeightTable
{
  struct Window
  {
    int first; ///< control point of the first weight
    int count;
  };

  std::vector<Window> windows;
  std::vector<double> weights;
  std::size_t width = 0; ///< room per sample in `weights`

  int last() const { return static_cast<int>(this->windows.size()) - 1; }
  const double* at(int sample) const { return this->weights.data() + sample * this->width; }
  /// Whether the sample lies at a clamped end: one plane of control points is copied.
  bool clampedEnd(int sample) const
  {
    return (sample == 0 || sample == this->last()) && this->windows[sample].count == 1 && this->at(sample)[0] == 1.0;
  }
};

WeightTable weightTable(int degree, const std::vector<double>& knots, int level, int order)
{
  const std::vector<int> spans = nonEmptySpans(degree, knots);
  const int parts = 1 << level;
  const std::size_t samples = spans.size() * parts + 1;

  // Basis of span s at fraction f. Only differences of neighbouring knots are used: they are what blocks share.
  const auto basis = [&](int s, double fraction, double* values) {
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
    basisFunctions(degree, order, left, right, values);
  };

  WeightTable table;
  table.windows.reserve(samples);
  table.width = 2 * degree + 1; // two windows of degree + 1, at least one and at most degree apart
  table.weights.resize(samples * table.width);
  double* weights = table.weights.data();
  for (std::size_t i = 0; i < samples; ++i, weights += table.width)
  {
    const std::size_t span = i / parts;
    const double fraction = static_cast<double>(i % parts) / parts;
    int first = 0;
    int count = degree + 1;
    if (fraction > 0.0 || span == 0)
    {
      first = spans[span] - degree;
      basis(spans[span], fraction, weights);
    }
    else if (span == spans.size())
    {
      first = spans.back() - degree;
      basis(spans.back(), 1.0, weights);
    }
    else
    {
      double before[MaxDegree + 1];
      double after[MaxDegree + 1];
      basis(spans[span - 1], 1.0, before);
      basis(spans[span], 0.0, after);
      first = spans[span - 1] - degree;
      const int shift = spans[span] - spans[span - 1];
      count += shift;
      for (int q = 0; q < count; ++q)
      {
        const double b = q <= degree ? before[q] : 0.0;
        const double a = q >= shift ? after[q - shift] : 0.0;
        weights[q] = 0.5 * (b + a);
      }
    }
    int skip = 0;
    while (count > 1 && weights[skip + count - 1] == 0.0)
    {
      --count;
    }
    while (count > 1 && weights[skip] == 0.0)
    {
      ++skip;
      --count;
    }
    std::copy(weights + skip, weights + skip + count, weights);
    table.windows.push_back({ first + skip, count });
  }
  return table;
}

/// Range [begin, end) of samples or control points per direction.
struct Range
{
  int begin;
  int end;

  int size() const { return this->end - this->begin; }
};
using Box = std::array<Range, 3>;

/// Weighted sum of `count` rows of `length` numbers, `stride` apart; pairs from the ends inwards.
void combine(const double* weights, int count, const double* rows, Index stride, Index length, double* out)
{
  if (count == 4)
  {
    const double w0 = weights[0], w1 = weights[1], w2 = weights[2], w3 = weights[3];
    const double *r0 = rows, *r1 = rows + stride, *r2 = rows + 2 * stride, *r3 = rows + 3 * stride;
    for (Index x = 0; x < length; ++x)
    {
      out[x] = (w0 * r0[x] + w3 * r3[x]) + (w1 * r1[x] + w2 * r2[x]);
    }
    return;
  }
  if (count == 1)
  {
    for (Index x = 0; x < length; ++x)
    {
      out[x] = weights[0] * rows[x];
    }
    return;
  }
  for (int q = 0; q < (count + 1) / 2; ++q)
  {
    const int p = count - 1 - q;
    const double wq = weights[q], wp = weights[p];
    const double *rq = rows + q * stride, *rp = rows + p * stride;
    for (Index x = 0; x < length; ++x)
    {
      const double term = q < p ? wq * rq[x] + wp * rp[x] : wq * rq[x];
      out[x] = q == 0 ? term : out[x] + term;
    }
  }
}

/// One pass: turns the control points of direction d, which `in` holds for the range `control`, into the samples of the
/// range `samples`. `sizes` are the points per direction of `in`, then of `out`.
void contract(const WeightTable& table, int d, const Range& control, const Range& samples, std::array<int, 3>& sizes,
  const std::vector<double>& in, std::vector<double>& out)
{
  const Index inner = d == 0 ? 3 : d == 1 ? 3 * Index(sizes[0]) : 3 * Index(sizes[0]) * sizes[1];
  const Index outer = d == 0 ? Index(sizes[1]) * sizes[2] : d == 1 ? sizes[2] : 1;
  out.resize(static_cast<std::size_t>(inner * outer * samples.size()));
  double* to = out.data();
  for (Index o = 0; o < outer; ++o)
  {
    const double* from = in.data() + o * inner * sizes[d];
    for (int s = samples.begin; s < samples.end; ++s, to += inner)
    {
      const WeightTable::Window window = table.windows[s];
      combine(table.at(s), window.count, from + (window.first - control.begin) * inner, inner, inner, to);
    }
  }
  sizes[d] = samples.size();
}

/// Order in which the directions are summed inside the block: that of the orientation in which the control points,
/// listed with the first direction running fastest, come first in lexicographic order.
std::array<int, 3> directionOrder(const BSplineVolume& volume)
{
  struct Orientation
  {
    std::array<int, 3> order;
    std::array<Index, 3> strides;
    const double* start;
  };
  const std::array<int, 3> counts{ volume.count(0), volume.count(1), volume.count(2) };
  const std::array<Index, 3> strides{ 3, 3 * Index(counts[0]), 3 * Index(counts[0]) * counts[1] };

  const auto compare = [&](const Orientation& a, const Orientation& b) {
    for (int d = 0; d < 3; ++d)
    {
      if (counts[a.order[d]] != counts[b.order[d]])
      {
        return counts[a.order[d]] < counts[b.order[d]];
      }
    }
    for (int k = 0; k < counts[a.order[2]]; ++k)
    {
      for (int j = 0; j < counts[a.order[1]]; ++j)
      {
        for (int i = 0; i < counts[a.order[0]]; ++i)
        {
          const double* x = a.start + i * a.strides[0] + j * a.strides[1] + k * a.strides[2];
          const double* y = b.start + i * b.strides[0] + j * b.strides[1] + k * b.strides[2];
          for (int c = 0; c < 3; ++c)
          {
            if (x[c] != y[c])
            {
              return x[c] < y[c];
            }
          }
        }
      }
    }
    return false;
  };

  Orientation best{};
  std::array<int, 3> order{ 0, 1, 2 };
  do
  {
    for (int flips = 0; flips < 8; ++flips)
    {
      Orientation orientation{ order, {}, volume.points };
      for (int d = 0; d < 3; ++d)
      {
        const bool flip = (flips >> d & 1) != 0;
        orientation.strides[d] = flip ? -strides[order[d]] : strides[order[d]];
        orientation.start += flip ? (counts[order[d]] - 1) * strides[order[d]] : 0;
      }
      if (!best.start || compare(orientation, best))
      {
        best = orientation;
      }
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return best.order;
}

/// Samples boxes of one block; every thread has its own.
class BoxSampler
{
public:
  BoxSampler(const BSplineVolume& volume, const std::array<WeightTable, 3>& tables, const std::array<int, 3>& inside,
    double* samples)
    : Volume(volume)
    , Tables(tables)
    , Inside(inside)
    , Samples(samples)
  {
  }

  void operator()(const Box& box)
  {
    std::vector<int> free;
    for (int d = 0; d < 3; ++d)
    {
      if (!this->Tables[d].clampedEnd(box[d].begin))
      {
        free.push_back(d);
      }
    }
    if (free.size() == 2)
    {
      const int across = 3 - free[0] - free[1];
      this->evaluate(box, { across, free[0], free[1] }, this->Result);
      this->evaluate(box, { across, free[1], free[0] }, this->Other);
      for (std::size_t x = 0; x < this->Result.size(); ++x)
      {
        this->Result[x] = 0.5 * (this->Result[x] + this->Other[x]);
      }
    }
    else
    {
      this->evaluate(box, this->Inside, this->Result);
    }

    const Index rows = this->Tables[0].windows.size();
    const Index layers = rows * this->Tables[1].windows.size();
    const double* from = this->Result.data();
    for (Index k = box[2].begin; k < box[2].end; ++k)
    {
      for (Index j = box[1].begin; j < box[1].end; ++j, from += 3 * box[0].size())
      {
        std::copy(from, from + 3 * box[0].size(), this->Samples + 3 * (box[0].begin + j * rows + k * layers));
      }
    }
  }

private:
  void evaluate(const Box& box, const std::array<int, 3>& order, std::vector<double>& result)
  {
    Box control;
    std::array<int, 3> sizes;
    for (int d = 0; d < 3; ++d)
    {
      control[d] = { std::numeric_limits<int>::max(), 0 };
      for (int s = box[d].begin; s < box[d].end; ++s)
      {
        const WeightTable::Window window = this->Tables[d].windows[s];
        control[d].begin = std::min(control[d].begin, window.first);
        control[d].end = std::max(control[d].end, window.first + window.count);
      }
      sizes[d] = control[d].size();
    }

    this->Net.resize(static_cast<std::size_t>(3) * sizes[0] * sizes[1] * sizes[2]);
    double* to = this->Net.data();
    for (Index k = control[2].begin; k < control[2].end; ++k)
    {
      for (Index j = control[1].begin; j < control[1].end; ++j)
      {
        const double* row =
          this->Volume.points + 3 * (control[0].begin + this->Volume.count(0) * (j + this->Volume.count(1) * k));
        to = std::copy(row, row + 3 * sizes[0], to);
      }
    }

    const auto pass = [&](int d, const std::vector<double>& in, std::vector<double>& out) {
      contract(this->Tables[d], d, control[d], box[d], sizes, in, out);
    };
    pass(order[0], this->Net, this->First);
    pass(order[1], this->First, this->Net);
    pass(order[2], this->Net, result);
  }

  const BSplineVolume& Volume;
  const std::array<WeightTable, 3>& Tables;
  std::array<int, 3> Inside;
  double* Samples;
  std::vector<double> Net, First, Result, Other;
};

/// All samples in boxes small enough for the cache. A plane of samples at a clamped end is a box of its own: its values
/// must depend on the points of that face alone.
std::vector<Box> boxes(const std::array<WeightTable, 3>& tables)
{
  const std::array<int, 3> sizes{ 48, 16, 16 };
  std::array<std::vector<Range>, 3> ranges;
  for (int d = 0; d < 3; ++d)
  {
    const int last = tables[d].last();
    const int begin = tables[d].clampedEnd(0) ? 1 : 0;
    const int end = tables[d].clampedEnd(last) ? last : last + 1;
    if (begin == 1)
    {
      ranges[d].push_back({ 0, 1 });
    }
    for (int at = begin; at < end; at += sizes[d])
    {
      ranges[d].push_back({ at, std::min(at + sizes[d], end) });
    }
    if (end == last)
    {
      ranges[d].push_back({ last, last + 1 });
    }
  }
  std::vector<Box> result;
  result.reserve(ranges[0].size() * ranges[1].size() * ranges[2].size());
  for (const Range& k : ranges[2])
  {
    for (const Range& j : ranges[1])
    {
      for (const Range& i : ranges[0])
      {
        result.push_back({ i, j, k });
      }
    }
  }
  return result;
}

void samplePolynomial(
  const BSplineVolume& volume, int level, const std::array<int, 3>& derivative, double* samples, const Execution& run)
{
  std::array<WeightTable, 3> tables;
  for (int d = 0; d < 3; ++d)
  {
    tables[d] = weightTable(volume.degree[d], volume.knots[d], level, derivative[d]);
  }
  const std::array<int, 3> inside = directionOrder(volume);
  const std::vector<Box> all = boxes(tables);

  // Progress can be told, and an abort noticed, only between parallel loops.
  const Index total = static_cast<Index>(all.size());
  const Index batch = 512;
  for (Index start = 0; start < total; start += batch)
  {
    run.report(static_cast<double>(start) / total);
    run.parallelFor(std::min(batch, total - start), 4, [&](Index begin, Index end) {
      BoxSampler sampler(volume, tables, inside, samples);
      for (Index i = begin; i < end; ++i)
      {
        sampler(all[start + i]);
      }
    });
  }
  run.report(1.0);
}

/// Quotient rule on the samples of the numerator and of the denominator.
void sampleRational(
  const BSplineVolume& volume, int level, const std::array<int, 3>& derivative, double* samples, const Execution& run)
{
  const Index points = Index(volume.count(0)) * volume.count(1) * volume.count(2);
  std::vector<double> numeratorNet(3 * points);
  std::vector<double> denominatorNet(3 * points);
  for (Index i = 0; i < 3 * points; ++i)
  {
    denominatorNet[i] = volume.weights[i / 3];
    numeratorNet[i] = volume.weights[i / 3] * volume.points[i];
  }
  BSplineVolume numerator = volume;
  numerator.weights = nullptr;
  numerator.points = numeratorNet.data();
  BSplineVolume denominator = numerator;
  denominator.points = denominatorNet.data();

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
  const std::array<int, 3> counts = sampleCounts(volume, level, "volume");
  const Index size = 3 * Index(counts[0]) * counts[1] * counts[2];
  std::vector<std::vector<double>> values(lower.size());
  std::vector<std::vector<double>> weights(lower.size());
  for (std::size_t n = 0; n < lower.size(); ++n)
  {
    Execution part = run;
    part.progress = [&](double fraction) { return run.progress((n + fraction) / lower.size()); };
    values[n].resize(size);
    weights[n].resize(size);
    samplePolynomial(numerator, level, lower[n], values[n].data(), part);
    samplePolynomial(denominator, level, lower[n], weights[n].data(), part);
    for (std::size_t m = 1; m <= n; ++m)
    {
      // With orders 0 and 1 all binomial coefficients are 1.
      const std::array<int, 3> rest{ lower[n][0] - lower[m][0], lower[n][1] - lower[m][1], lower[n][2] - lower[m][2] };
      const auto found = std::find(lower.begin(), lower.end(), rest);
      if (found != lower.end())
      {
        const std::vector<double>& other = values[found - lower.begin()];
        for (Index i = 0; i < size; ++i)
        {
          values[n][i] -= weights[m][i] * other[i];
        }
      }
    }
    for (Index i = 0; i < size; ++i)
    {
      values[n][i] /= weights[0][i];
    }
  }
  std::copy(values.back().begin(), values.back().end(), samples);
}

} // namespace

std::array<int, 3> sampleCounts(const BSplineVolume& volume, int level, const std::string& name)
{
  if (level < 0 || level > MaxSamplingLevel)
  {
    throw Error(name + ": Level " + std::to_string(level) + " is not in 0.." + std::to_string(MaxSamplingLevel));
  }
  std::array<int, 3> counts;
  double bytes = 3 * sizeof(double);
  for (int d = 0; d < 3; ++d)
  {
    const Index spans = static_cast<Index>(nonEmptySpans(volume.degree[d], volume.knots[d]).size());
    const Index count = (spans << level) + 1;
    bytes *= static_cast<double>(count);
    if (count > std::numeric_limits<int>::max() || bytes > 9e18)
    {
      throw Error(name + ": Level " + std::to_string(level) + " has too many samples");
    }
    counts[d] = static_cast<int>(count);
  }
  return counts;
}

std::vector<double> sampleParameters(const BSplineVolume& volume, int direction, int level)
{
  const std::vector<double>& knots = volume.knots[direction];
  const std::vector<int> spans = nonEmptySpans(volume.degree[direction], knots);
  const int parts = 1 << level;
  std::vector<double> parameters;
  parameters.reserve(spans.size() * parts + 1);
  for (const int s : spans)
  {
    for (int j = 0; j < parts; ++j)
    {
      parameters.push_back(knots[s] + (knots[s + 1] - knots[s]) * (static_cast<double>(j) / parts));
    }
  }
  parameters.push_back(knots[spans.back() + 1]);
  return parameters;
}

void sample(
  const BSplineVolume& volume, int level, const std::array<int, 3>& derivative, double* samples, const Execution& run)
{
  for (const int order : derivative)
  {
    if (order < 0 || order > 1)
    {
      throw Error("samples of derivative order " + std::to_string(order) + " are not available, only 0 and 1");
    }
  }
  if (volume.weights)
  {
    sampleRational(volume, level, derivative, samples, run);
  }
  else
  {
    samplePolynomial(volume, level, derivative, samples, run);
  }
}

} // namespace bsv
