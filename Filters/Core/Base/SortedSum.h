// SPDX-License-Identifier: BSD-3-Clause
/// @file SortedSum.h
/// Sums whose bits do not depend on the order of the terms.
#pragma once

#include "Base/Types.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace bsv
{

inline double sortedSum(std::vector<double> terms)
{
  std::sort(terms.begin(), terms.end());
  return std::accumulate(terms.begin(), terms.end(), 0.0);
}

inline Vec3 sortedSum(const std::vector<Vec3>& terms)
{
  Vec3 sum;
  std::vector<double> component(terms.size());
  for (int d = 0; d < 3; ++d)
  {
    std::transform(terms.begin(), terms.end(), component.begin(), [d](const Vec3& term) { return term[d]; });
    sum[d] = sortedSum(component);
  }
  return sum;
}

} // namespace bsv
