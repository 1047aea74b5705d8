// SPDX-License-Identifier: BSD-3-Clause
/// @file ParallelSort.h
/// Sorting on several threads.
#pragma once

#include "Base/Types.h"

#include <algorithm>
#include <vector>

namespace bsv
{

/// Sorts by operator<, which must tell all values apart: then the result is the same for any number of threads. Parts
/// are sorted, then merged two by two; takes half of the memory of the values once more.
template <typename Value>
void parallelSort(std::vector<Value>& values, const Execution& run)
{
  constexpr Index Part = 1 << 18;
  const Index count = static_cast<Index>(values.size());
  const auto at = [&](Index n) { return values.begin() + std::min(n, count); };
  run.parallelFor((count + Part - 1) / Part, 1, [&](Index begin, Index end) {
    for (Index n = begin; n < end; ++n)
    {
      std::sort(at(n * Part), at((n + 1) * Part));
    }
  });
  for (Index size = Part; size < count; size *= 2)
  {
    run.parallelFor((count + 2 * size - 1) / (2 * size), 1, [&](Index begin, Index end) {
      for (Index n = begin; n < end; ++n)
      {
        std::inplace_merge(at(2 * n * size), at((2 * n + 1) * size), at((2 * n + 2) * size));
      }
    });
  }
}

} // namespace bsv
