// SPDX-License-Identifier: BSD-3-Clause
/// @file OrderFreeSums.h
/// OrderFreeSum for many sums with the same weights at once.
#pragma once

#include "Base/Types.h"

namespace bsv
{

/// Most terms of a sum: those of a regular vertex.
constexpr int MostOrderFreeTerms = 27;

/// results[i] = (sum over t of weights[t] * terms[t][i]) / denominator for `count` sums, each with the bits of
/// OrderFreeSum. No weight is 0.
/// @param termCount 2, 3, 4, 6, 8, 9, 12, 18 or 27: the regular rules have no others.
/// @param results overlaps none of the terms.
void orderFreeSums(
  const double* weights, const double* const* terms, int termCount, double denominator, Index count, double* results);

} // namespace bsv
