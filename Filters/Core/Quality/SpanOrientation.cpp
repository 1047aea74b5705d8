// SPDX-License-Identifier: BSD-3-Clause
#include "Quality/SpanOrientation.h"

#include "Mesh/BlockTopology.h"

#include <utility>

namespace bsv
{

SpanOrientation CanonicalOrientation::operator()(Index first) const
{
  // Nearly always the corner and its neighbours decide.
  const std::array<int, 3>& degree = this->Volume.degree;
  int corner = 0;
  bool tie = false;
  Index start = first;
  for (int c = 1; c < 8; ++c)
  {
    Index at = first;
    for (int d = 0; d < 3; ++d)
    {
      at += cornerSide(c, d) * degree[d] * this->Strides[d];
    }
    const int sign = this->compare(at, start);
    tie = sign == 0 || (tie && sign > 0);
    if (sign < 0)
    {
      corner = c;
      start = at;
    }
  }
  SpanOrientation best = this->orientation(first, this->Order, corner);
  for (const auto& [a, b] : { std::pair(0, 1), std::pair(1, 2), std::pair(0, 1) })
  {
    if (degree[best.order[a]] == degree[best.order[b]])
    {
      const int sign = this->compare(start + best.strides[a], start + best.strides[b]);
      tie = tie || sign == 0;
      if (sign > 0)
      {
        std::swap(best.order[a], best.order[b]);
        std::swap(best.flip[a], best.flip[b]);
        std::swap(best.strides[a], best.strides[b]);
      }
    }
  }
  return tie ? this->search(first) : best;
}

int CanonicalOrientation::compare(Index a, Index b) const
{
  const double* x = this->Volume.points + 3 * a;
  const double* y = this->Volume.points + 3 * b;
  for (int c = 0; c < 3; ++c)
  {
    if (x[c] != y[c])
    {
      return x[c] < y[c] ? -1 : 1;
    }
  }
  return 0;
}

SpanOrientation CanonicalOrientation::orientation(Index first, const std::array<int, 3>& order, int corner) const
{
  SpanOrientation result{ order, {}, first, {} };
  for (int d = 0; d < 3; ++d)
  {
    const int from = order[d];
    result.flip[d] = cornerSide(corner, from) == 1;
    result.start += result.flip[d] ? this->Volume.degree[from] * this->Strides[from] : 0;
    result.strides[d] = result.flip[d] ? -this->Strides[from] : this->Strides[from];
  }
  return result;
}

SpanOrientation CanonicalOrientation::search(Index first) const
{
  const std::array<int, 3>& degree = this->Volume.degree;
  SpanOrientation best = this->orientation(first, this->Order, 0);
  const auto before = [&](const SpanOrientation& a) {
    for (int k = 0; k <= degree[a.order[2]]; ++k)
    {
      for (int j = 0; j <= degree[a.order[1]]; ++j)
      {
        for (int i = 0; i <= degree[a.order[0]]; ++i)
        {
          const int sign = this->compare(a.start + i * a.strides[0] + j * a.strides[1] + k * a.strides[2],
            best.start + i * best.strides[0] + j * best.strides[1] + k * best.strides[2]);
          if (sign != 0)
          {
            return sign < 0;
          }
        }
      }
    }
    return false;
  };
  std::array<int, 3> order{ 0, 1, 2 };
  do
  {
    if (degree[order[0]] > degree[order[1]] || degree[order[1]] > degree[order[2]])
    {
      continue;
    }
    for (int corner = 0; corner < 8; ++corner)
    {
      const SpanOrientation other = this->orientation(first, order, corner);
      if (before(other))
      {
        best = other;
      }
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return best;
}

} // namespace bsv
