// SPDX-License-Identifier: BSD-3-Clause
#include "Base/OrderFreeSums.h"

#include "Base/RowLoop.h"

#include <array>
#include <cstddef>
#include <string>
#include <utility>

#define BSV_INLINE inline __attribute__((always_inline))
// The passes of the loop that follows are independent of each other. Clang finds out by itself.
#if defined(__GNUC__) && !defined(__clang__)
#define BSV_INDEPENDENT _Pragma("GCC ivdep")
#else
#define BSV_INDEPENDENT
#endif

namespace bsv
{

namespace
{

/// Batcher's merge exchange sort (Knuth, The Art of Computer Programming, vol. 3, 5.2.2, algorithm M): calls
/// exchange(i, j), i < j, for the pairs to be put in order.
template <typename Exchange>
constexpr void mergeExchange(int count, const Exchange& exchange)
{
  int top = 1;
  while (2 * top < count)
  {
    top *= 2;
  }
  for (int p = top; p > 0; p /= 2)
  {
    int r = 0;
    int d = p;
    for (int q = top;; q /= 2)
    {
      for (int i = 0; i + d < count; ++i)
      {
        if ((i & p) == r)
        {
          exchange(i, i + d);
        }
      }
      if (q == p)
      {
        break;
      }
      d = q - p;
      r = p;
    }
  }
}

constexpr int exchangeCount(int count)
{
  int pairs = 0;
  mergeExchange(count, [&](int, int) { ++pairs; });
  return pairs;
}

template <int Count>
constexpr std::array<std::array<int, 2>, exchangeCount(Count)> exchanges()
{
  std::array<std::array<int, 2>, exchangeCount(Count)> pairs{};
  int next = 0;
  mergeExchange(Count, [&](int i, int j) {
    pairs[next][0] = i;
    pairs[next][1] = j;
    ++next;
  });
  return pairs;
}

/// One sum, without a loop or a branch, so that the loop over sums becomes vector code.
template <int Count, std::size_t... Term, std::size_t... Pair>
BSV_INLINE double oneSum(const double* weights, const double* const* terms, double denominator, Index i,
  std::index_sequence<Term...>, std::index_sequence<Pair...>)
{
  constexpr auto Pairs = exchanges<Count>();
  double products[Count] = { weights[Term] * terms[Term][i]... };
  const auto exchange = [](double& a, double& b) {
    const double low = b < a ? b : a;
    b = b < a ? a : b;
    a = low;
  };
  (..., exchange(products[Pairs[Pair][0]], products[Pairs[Pair][1]]));
  double sum = 0.0;
  double lost = 0.0;
  const auto add = [&sum, &lost](double x) {
    // What `next` has lost, exactly, whichever of the two is larger (Knuth, vol. 2, 4.2.2, theorem B).
    const double next = sum + x;
    const double added = next - sum;
    lost += (sum - (next - added)) + (x - added);
    sum = next;
  };
  (..., add(products[Term]));
  return (sum + lost) / denominator;
}

template <int... Term>
BSV_INLINE bool allEqual(const double* const* terms, Index i, std::integer_sequence<int, Term...>)
{
  return (... & (terms[Term][i] == terms[0][i]));
}

template <int Count>
BSV_INLINE void allSums(
  const double* weights, const double* const* terms, double denominator, Index count, double* results)
{
  double w[Count];
  const double* x[Count];
  for (int t = 0; t < Count; ++t)
  {
    w[t] = weights[t];
    x[t] = terms[t];
  }
  BSV_INDEPENDENT
  for (Index i = 0; i < count; ++i)
  {
    results[i] = oneSum<Count>(
      w, x, denominator, i, std::make_index_sequence<Count>(), std::make_index_sequence<exchangeCount(Count)>());
  }
  BSV_INDEPENDENT
  for (Index i = 0; i < count; ++i)
  {
    results[i] = (allEqual(x, i, std::make_integer_sequence<int, Count>()) ? x[0][i] : results[i]) + 0.0;
  }
}

} // namespace

BSV_ROW_LOOP void orderFreeSums(
  const double* weights, const double* const* terms, int termCount, double denominator, Index count, double* results)
{
  switch (termCount)
  {
    case 2:
      return allSums<2>(weights, terms, denominator, count, results);
    case 3:
      return allSums<3>(weights, terms, denominator, count, results);
    case 4:
      return allSums<4>(weights, terms, denominator, count, results);
    case 6:
      return allSums<6>(weights, terms, denominator, count, results);
    case 8:
      return allSums<8>(weights, terms, denominator, count, results);
    case 9:
      return allSums<9>(weights, terms, denominator, count, results);
    case 12:
      return allSums<12>(weights, terms, denominator, count, results);
    case 18:
      return allSums<18>(weights, terms, denominator, count, results);
    case 27:
      return allSums<27>(weights, terms, denominator, count, results);
    default:
      throw Error("no sum of " + std::to_string(termCount) + " terms");
  }
}

} // namespace bsv
