// SPDX-License-Identifier: BSD-3-Clause
#include "Mesh/PlainCells.h"

#include "Base/RowLoop.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace bsv
{

namespace
{

/// Vectors along a row of points: all x, all y, all z, and their squared lengths.
struct Row
{
  explicit Row(std::size_t size)
    : values(4 * size)
  {
  }

  std::vector<double> values;
};

template <typename Real>
void read(const Real* xyz, int count, Row& to)
{
  double* x = to.values.data();
  for (int i = 0; i < count; ++i)
  {
    x[i] = xyz[3 * i];
    x[i + count] = xyz[3 * i + 1];
    x[i + 2 * count] = xyz[3 * i + 2];
  }
}

/// to[i] = b[i] - a[i] for i = 0 .. count - 1, in rows of `size`
BSV_ROW_LOOP void subtract(const double* b, const double* a, int count, std::ptrdiff_t size, double* __restrict to)
{
  for (int i = 0; i < count; ++i)
  {
    const double x = b[i] - a[i];
    const double y = b[i + size] - a[i + size];
    const double z = b[i + 2 * size] - a[i + 2 * size];
    to[i] = x;
    to[i + size] = y;
    to[i + 2 * size] = z;
    to[i + 3 * size] = x * x + y * y + z * z;
  }
}

/// @name Per cell of a row: over its corners and edges
/// Minima and maxima are conditional expressions in place, which the compiler turns into vector instructions.
///@{
/// Jacobians (a x b) . c of the two corners at the ends of the edge a along i: b and c are taken at i, then at i + 1.
BSV_ROW_LOOP void takeCorners(const double* a, const double* b, const double* c, int cells, std::ptrdiff_t size,
  double* __restrict lowest, double* __restrict highest, double* __restrict sum)
{
  const std::ptrdiff_t y = size, z = 2 * size;
  for (int i = 0; i < cells; ++i)
  {
    const double ax = a[i], ay = a[i + y], az = a[i + z];
    const double first = (ay * b[i + z] - az * b[i + y]) * c[i] + (az * b[i] - ax * b[i + z]) * c[i + y] +
      (ax * b[i + y] - ay * b[i]) * c[i + z];
    const std::ptrdiff_t n = i + 1;
    const double second = (ay * b[n + z] - az * b[n + y]) * c[n] + (az * b[n] - ax * b[n + z]) * c[n + y] +
      (ax * b[n + y] - ay * b[n]) * c[n + z];
    const double low = first < second ? first : second;
    const double high = first < second ? second : first;
    lowest[i] = low < lowest[i] ? low : lowest[i];
    highest[i] = high > highest[i] ? high : highest[i];
    sum[i] += first + second;
  }
}

/// Squared lengths of four parallel edges.
BSV_ROW_LOOP void takeLengths(const double* a, const double* b, const double* c, const double* d, int cells,
  double* __restrict shortest, double* __restrict longest)
{
  for (int i = 0; i < cells; ++i)
  {
    const double shortAB = a[i] < b[i] ? a[i] : b[i], longAB = a[i] < b[i] ? b[i] : a[i];
    const double shortCD = c[i] < d[i] ? c[i] : d[i], longCD = c[i] < d[i] ? d[i] : c[i];
    const double least = shortAB < shortCD ? shortAB : shortCD;
    const double most = longAB < longCD ? longCD : longAB;
    shortest[i] = least < shortest[i] ? least : shortest[i];
    longest[i] = most > longest[i] ? most : longest[i];
  }
}

/// Whether cells so far were all positive or all negative (1 or 0), and their volume: not a number if a coordinate is
/// not. The longest edge stands for the three at a corner; it makes the bound infinite if a coordinate is. The factors
/// 2 are for rounding, for the same may be computed in other ways elsewhere.
BSV_ROW_LOOP void conclude(const double* lowest, const double* highest, const double* sum, const double* shortest,
  double* __restrict longest, int cells, double zeroLengthSquared, double* __restrict positive,
  double* __restrict negative, double* __restrict volume)
{
  // Loops of one condition each: the compiler would make jumps of several.
  double* bound = longest;
  for (int i = 0; i < cells; ++i)
  {
    const double cube = 2.0 * FlatSquared * longest[i] * longest[i] * longest[i];
    const double tooShort = shortest[i] > 2.0 * zeroLengthSquared ? 0.0 : HUGE_VAL;
    bound[i] = cube + tooShort;
  }
  for (int i = 0; i < cells; ++i)
  {
    positive[i] = lowest[i] > 0.0 ? positive[i] : 0.0;
    negative[i] = highest[i] < 0.0 ? negative[i] : 0.0;
    volume[i] += sum[i];
  }
  for (int i = 0; i < cells; ++i)
  {
    positive[i] = lowest[i] * lowest[i] > bound[i] ? positive[i] : 0.0;
    negative[i] = highest[i] * highest[i] > bound[i] ? negative[i] : 0.0;
  }
}
///@}

template <typename Real>
PlainCells check(const GridView& points, int begin, int end, double zeroLengthSquared)
{
  const std::array<int, 3>& n = points.counts();
  const int size = n[0];
  const int cells = size - 1;
  // Rows of points at j and j + 1 (first index) and k and k + 1 (second), and the edges from their points.
  const Row row(size);
  std::array<std::array<Row, 2>, 2> at{ { { row, row }, { row, row } } }, alongI = at;
  std::array<Row, 2> alongJ{ row, row }; // at k and k + 1
  std::array<Row, 2> alongK{ row, row }; // at j and j + 1
  // Per cell of a row.
  std::vector<double> lowest(size), highest(size), sum(size), shortest(size), longest(size);
  // Per i, over all rows.
  std::vector<double> positive(size, 1.0), negative(size, 1.0), volume(size, 0.0);
  for (int k = begin; k < end; ++k)
  {
    for (int j = 0; j < n[1]; ++j)
    {
      // What was at j + 1 is at j now.
      at[0].swap(at[1]);
      alongI[0].swap(alongI[1]);
      std::swap(alongK[0], alongK[1]);
      for (int layer = 0; layer < 2; ++layer)
      {
        read(points.address<Real>(0, j, k + layer), size, at[1][layer]);
        const double* x = at[1][layer].values.data();
        subtract(x + 1, x, cells, size, alongI[1][layer].values.data());
        subtract(x, at[0][layer].values.data(), size, size, alongJ[layer].values.data());
      }
      subtract(at[1][1].values.data(), at[1][0].values.data(), size, size, alongK[1].values.data());
      if (j == 0)
      {
        continue;
      }
      std::fill(lowest.begin(), lowest.end(), std::numeric_limits<double>::infinity());
      std::fill(highest.begin(), highest.end(), -std::numeric_limits<double>::infinity());
      std::fill(sum.begin(), sum.end(), 0.0);
      std::fill(shortest.begin(), shortest.end(), std::numeric_limits<double>::infinity());
      std::fill(longest.begin(), longest.end(), 0.0);
      const auto edge = [&](int direction, int low, int high) -> const double* {
        return direction == 0 ? alongI[low][high].values.data()
          : direction == 1    ? alongJ[high].values.data() + low
                              : alongK[high].values.data() + low;
      };
      for (int side = 0; side < 4; ++side)
      {
        const int cj = side & 1, ck = side >> 1;
        takeCorners(
          edge(0, cj, ck), edge(1, 0, ck), edge(2, 0, cj), cells, size, lowest.data(), highest.data(), sum.data());
      }
      for (int d = 0; d < 3; ++d)
      {
        const std::ptrdiff_t lengths = 3 * std::ptrdiff_t(size);
        takeLengths(edge(d, 0, 0) + lengths, edge(d, 1, 0) + lengths, edge(d, 0, 1) + lengths, edge(d, 1, 1) + lengths,
          cells, shortest.data(), longest.data());
      }
      conclude(lowest.data(), highest.data(), sum.data(), shortest.data(), longest.data(), cells, zeroLengthSquared,
        positive.data(), negative.data(), volume.data());
    }
  }

  PlainCells result;
  const auto all = [&](const std::vector<double>& flags) {
    return std::all_of(flags.begin(), flags.begin() + cells, [](double flag) { return flag == 1.0; });
  };
  for (int i = 0; i < cells; ++i)
  {
    result.volume += volume[i];
  }
  const bool isNumber = result.volume == result.volume;
  result.sign = !isNumber ? 0 : all(positive) ? 1 : all(negative) ? -1 : 0;
  return result;
}

} // namespace

PlainCells plainCells(const GridView& points, int begin, int end, double zeroLengthSquared)
{
  return points.isFloat() ? check<float>(points, begin, end, zeroLengthSquared)
                          : check<double>(points, begin, end, zeroLengthSquared);
}

} // namespace bsv
