// SPDX-License-Identifier: BSD-3-Clause
#include "Volume/TensorPasses.h"

#include "Base/RowLoop.h"
#include "Volume/BSplineVolume.h"

#include <algorithm>
#include <limits>

namespace bsv
{

namespace
{

/// Range [begin, end) of results or control points per direction.
struct Range
{
  int begin;
  int end;

  int size() const { return this->end - this->begin; }
};
using Box = std::array<Range, 3>;

/// Weighted sum of `count` rows of `length` numbers, `stride` apart; pairs from the ends inwards.
BSV_ROW_LOOP void combine(
  const double* weights, int count, const double* rows, Index stride, Index length, double* __restrict out)
{
  const double *r0 = rows, *r1 = rows + stride, *r2 = rows + 2 * stride, *r3 = rows + 3 * stride;
  if (count == 4)
  {
    const double w0 = weights[0], w1 = weights[1], w2 = weights[2], w3 = weights[3];
    for (Index x = 0; x < length; ++x)
    {
      out[x] = (w0 * r0[x] + w3 * r3[x]) + (w1 * r1[x] + w2 * r2[x]);
    }
    return;
  }
  if (count == 3)
  {
    const double w0 = weights[0], w1 = weights[1], w2 = weights[2];
    for (Index x = 0; x < length; ++x)
    {
      out[x] = (w0 * r0[x] + w2 * r2[x]) + w1 * r1[x];
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

/// combine() along i, for the results of a range of one line of points: `Components` numbers a point, or `components`
/// if that is 0.
template <int Components>
void combineLine(const WeightTable& table, const Range& results, int firstPoint, int components, const double* line,
  double* __restrict out)
{
  const int size = Components == 0 ? components : Components;
  for (int s = results.begin; s < results.end; ++s, out += size)
  {
    const WeightTable::Window window = table.windows[s];
    const double* weights = table.at(s);
    const double* points = line + (window.first - firstPoint) * size;
    if (window.count == 4)
    {
      const double w0 = weights[0], w1 = weights[1], w2 = weights[2], w3 = weights[3];
      for (int c = 0; c < size; ++c)
      {
        out[c] = (w0 * points[c] + w3 * points[3 * size + c]) + (w1 * points[size + c] + w2 * points[2 * size + c]);
      }
      continue;
    }
    if (window.count == 3)
    {
      const double w0 = weights[0], w1 = weights[1], w2 = weights[2];
      for (int c = 0; c < size; ++c)
      {
        out[c] = (w0 * points[c] + w2 * points[2 * size + c]) + w1 * points[size + c];
      }
      continue;
    }
    for (int c = 0; c < size; ++c)
    {
      double sum = 0.0;
      for (int q = 0; q < (window.count + 1) / 2; ++q)
      {
        const int p = window.count - 1 - q;
        const double first = weights[q] * points[q * size + c];
        const double term = q < p ? first + weights[p] * points[p * size + c] : first;
        sum = q == 0 ? term : sum + term;
      }
      out[c] = sum;
    }
  }
}

/// Numbers of a box of points, i fastest: those of a line along i follow each other, lines and layers are apart.
struct Layout
{
  Index line;
  Index layer;
};

/// One pass: turns the control points of direction d, which `in` holds without gaps for the range `control`, into the
/// results of the range `results`. `sizes` are the points per direction of `in`, then of `out`.
void contract(const WeightTable& table, int components, int d, const Range& control, const Range& results,
  std::array<int, 3>& sizes, const double* in, double* out, const Layout& layout)
{
  const Index line = Index(components) * sizes[0];
  const Index layer = line * sizes[1];
  if (d == 0)
  {
    for (int k = 0; k < sizes[2]; ++k)
    {
      for (int j = 0; j < sizes[1]; ++j)
      {
        const auto pass = components == 3 ? &combineLine<3> : &combineLine<0>;
        pass(table, results, control.begin, components, in + j * line + k * layer,
          out + j * layout.line + k * layout.layer);
      }
    }
  }
  else
  {
    const Index step = d == 1 ? line : layer;
    const Index outStep = d == 1 ? layout.line : layout.layer;
    // Lines that are neither along i nor d; as one where they follow each other.
    const Index across = d == 1 ? layer : line;
    const Index outAcross = d == 1 ? layout.layer : layout.line;
    const bool whole = d == 2 && layout.line == line;
    const int count = whole ? 1 : sizes[3 - d];
    const Index length = whole ? layer : line;
    for (int a = 0; a < count; ++a)
    {
      for (int s = results.begin; s < results.end; ++s)
      {
        const WeightTable::Window window = table.windows[s];
        combine(table.at(s), window.count, in + a * across + (window.first - control.begin) * step, step, length,
          out + a * outAcross + (s - results.begin) * outStep);
      }
    }
  }
  sizes[d] = results.size();
}

/// Order in which the directions are summed inside the block: that of the orientation in which the control points,
/// listed with the first direction running fastest, come first in lexicographic order.
std::array<int, 3> directionOrder(const ControlNet& net)
{
  struct Orientation
  {
    std::array<int, 3> order;
    std::array<Index, 3> strides;
    const double* start;
  };
  const std::array<int, 3>& counts = net.counts;
  const Index size = net.components;
  const std::array<Index, 3> strides{ size, size * counts[0], size * counts[0] * counts[1] };

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
          for (int c = 0; c < net.components; ++c)
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
      Orientation orientation{ order, {}, net.values };
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

/// Computes boxes of the results of one block; every thread has its own.
class BoxPasses
{
public:
  BoxPasses(
    const ControlNet& net, const std::array<WeightTable, 3>& tables, const std::array<int, 3>& inside, double* results)
    : Net(net)
    , Tables(tables)
    , Inside(inside)
    , Results(results)
  {
  }

  void operator()(const Box& box)
  {
    std::vector<int> free;
    for (int d = 0; d < 3; ++d)
    {
      if (!this->Tables[d].copiesEnd(box[d].begin))
      {
        free.push_back(d);
      }
    }
    const Index components = this->Net.components;
    const Index rows = this->Tables[0].rows();
    const Layout whole{ components * rows, components * rows * this->Tables[1].rows() };
    double* results =
      this->Results + components * box[0].begin + whole.line * box[1].begin + whole.layer * box[2].begin;
    if (free.size() != 2)
    {
      this->evaluate(box, this->Inside, results, whole);
      return;
    }
    const int across = 3 - free[0] - free[1];
    const Index line = components * box[0].size();
    const Layout dense{ line, line * box[1].size() };
    double* other = room(this->Other, dense.layer * box[2].size());
    this->evaluate(box, { across, free[0], free[1] }, results, whole);
    this->evaluate(box, { across, free[1], free[0] }, other, dense);
    for (int k = 0; k < box[2].size(); ++k)
    {
      for (int j = 0; j < box[1].size(); ++j)
      {
        double* to = results + j * whole.line + k * whole.layer;
        for (Index x = 0; x < line; ++x, ++other)
        {
          to[x] = 0.5 * (to[x] + *other);
        }
      }
    }
  }

private:
  /// Memory that is reused, and not set to zero.
  static double* room(std::vector<double>& memory, Index size)
  {
    if (static_cast<Index>(memory.size()) < size)
    {
      memory.resize(size);
    }
    return memory.data();
  }

  void evaluate(const Box& box, const std::array<int, 3>& order, double* result, const Layout& layout)
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

    const Index components = this->Net.components;
    double* points = room(this->Second, components * sizes[0] * sizes[1] * sizes[2]);
    double* to = points;
    for (Index k = control[2].begin; k < control[2].end; ++k)
    {
      for (Index j = control[1].begin; j < control[1].end; ++j)
      {
        const double* row =
          this->Net.values + components * (control[0].begin + this->Net.counts[0] * (j + this->Net.counts[1] * k));
        to = std::copy(row, row + components * sizes[0], to);
      }
    }

    const auto pass = [&](int d, const double* in, std::vector<double>& memory) {
      std::array<int, 3> after = sizes;
      after[d] = box[d].size();
      const Index line = components * after[0];
      double* out = room(memory, line * after[1] * after[2]);
      contract(this->Tables[d], this->Net.components, d, control[d], box[d], sizes, in, out, { line, line * after[1] });
      return out;
    };
    const double* first = pass(order[0], points, this->First);
    const double* second = pass(order[1], first, this->Second);
    contract(this->Tables[order[2]], this->Net.components, order[2], control[order[2]], box[order[2]], sizes, second,
      result, layout);
  }

  const ControlNet& Net;
  const std::array<WeightTable, 3>& Tables;
  std::array<int, 3> Inside;
  double* Results;
  std::vector<double> First, Second, Other;
};

/// All results in boxes small enough for the cache. A plane that copies an end is a box of its own: its values must
/// depend on the points of that face alone.
std::vector<Box> boxes(const std::array<WeightTable, 3>& tables)
{
  const std::array<int, 3> sizes{ 48, 16, 16 };
  std::array<std::vector<Range>, 3> ranges;
  for (int d = 0; d < 3; ++d)
  {
    const int last = tables[d].rows() - 1;
    const int begin = tables[d].copiesEnd(0) ? 1 : 0;
    const int end = tables[d].copiesEnd(last) ? last : last + 1;
    if (begin == 1)
    {
      ranges[d].push_back({ 0, 1 });
    }
    for (int at = begin; at < end; at += sizes[d])
    {
      ranges[d].push_back({ at, std::min(at + sizes[d], end) });
    }
    if (end == last && last > 0)
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

} // namespace

WeightTable WeightTable::slice(int begin, int end) const
{
  WeightTable result;
  result.width = this->width;
  result.windows.assign(this->windows.begin() + begin, this->windows.begin() + end);
  result.weights.assign(this->at(begin), this->at(end));
  return result;
}

WeightTable weightTable(
  int degree, const std::vector<double>& knots, const std::vector<int>& parts, const SpanWeights& weightsOf)
{
  const std::vector<int> spans = nonEmptySpans(degree, knots);
  std::size_t rows = 1;
  for (const int count : parts)
  {
    rows += static_cast<std::size_t>(count);
  }
  WeightTable table;
  table.windows.reserve(rows);
  table.width = 2 * degree + 1; // two windows of degree + 1, at least one and at most degree apart
  table.weights.resize(rows * table.width);
  double* weights = table.weights.data();
  std::size_t span = 0;
  int j = 0;
  for (std::size_t i = 0; i < rows; ++i, ++j, weights += table.width)
  {
    // The last row is the end of the last span.
    if (j == parts[span] && span + 1 < spans.size())
    {
      ++span;
      j = 0;
    }
    int first = spans[span] - degree;
    int count = degree + 1;
    if (j > 0 || span == 0)
    {
      weightsOf(spans[span], j, weights);
    }
    else
    {
      double before[MaxDegree + 1];
      double after[MaxDegree + 1];
      weightsOf(spans[span - 1], parts[span - 1], before);
      weightsOf(spans[span], 0, after);
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

WeightTable weightTable(int degree, const std::vector<double>& knots, int parts, const SpanWeights& weightsOf)
{
  return weightTable(degree, knots, std::vector<int>(nonEmptySpans(degree, knots).size(), parts), weightsOf);
}

void tensorPasses(
  const ControlNet& net, const std::array<WeightTable, 3>& tables, double* results, const Execution& run)
{
  const std::array<int, 3> inside = directionOrder(net);
  const std::vector<Box> all = boxes(tables);

  // Progress can be told, and an abort noticed, only between parallel loops.
  const Index total = static_cast<Index>(all.size());
  const Index batch = 512;
  for (Index start = 0; start < total; start += batch)
  {
    run.report(static_cast<double>(start) / total);
    run.parallelFor(std::min(batch, total - start), 4, [&](Index begin, Index end) {
      BoxPasses passes(net, tables, inside, results);
      for (Index i = begin; i < end; ++i)
      {
        passes(all[start + i]);
      }
    });
  }
  run.report(1.0);
}

} // namespace bsv
