// SPDX-License-Identifier: BSD-3-Clause
/// @file OwnedValues.h
/// Values that one rank computes from its points and all ranks then know.
#pragma once

#include "Ranks/Ranks.h"

#include <cstddef>
#include <utility>
#include <vector>

namespace bsv
{

/// Value i of `count` is valueOf(i), computed by the rank ownerOf(i) alone; what it throws is thrown on all ranks.
/// Collective.
/// @return the same on all ranks.
template <typename T, typename OwnerOf, typename ValueOf>
std::vector<T> gatherFromOwners(const Ranks& ranks, std::size_t count, const OwnerOf& ownerOf, const ValueOf& valueOf)
{
  std::vector<T> values(count);
  for (std::size_t i = 0; i < count; ++i)
  {
    if (ownerOf(i) == ranks.rank())
    {
      values[i] = valueOf(i);
    }
  }
  ranks.share(values, ownerOf);
  return values;
}

/// The same for values that are lists of any lengths.
template <typename T, typename OwnerOf, typename ListOf>
std::vector<std::vector<T>> gatherListsFromOwners(
  const Ranks& ranks, std::size_t count, const OwnerOf& ownerOf, const ListOf& listOf)
{
  std::vector<std::vector<T>> lists(count);
  std::vector<T> mine;
  const std::vector<Index> sizes = gatherFromOwners<Index>(ranks, count, ownerOf, [&](std::size_t i) {
    lists[i] = listOf(i);
    return static_cast<Index>(lists[i].size());
  });
  if (ranks.size() == 1)
  {
    return lists;
  }
  for (const std::vector<T>& list : lists)
  {
    mine.insert(mine.end(), list.begin(), list.end());
  }
  const std::vector<std::vector<T>> parts = ranks.gather(mine);
  std::vector<std::size_t> next(parts.size(), 0);
  for (std::size_t i = 0; i < count; ++i)
  {
    const int owner = ownerOf(i);
    const auto begin = parts[owner].begin() + next[owner];
    lists[i].assign(begin, begin + sizes[i]);
    next[owner] += sizes[i];
  }
  return lists;
}

/// value(i) of all i < count, on all ranks. Each computes an equal part of them, in ranges of about `grain`.
/// Collective.
template <typename T, typename Value>
std::vector<T> sharedOut(Index count, Index grain, const Execution& run, const Value& value)
{
  const Ranks& ranks = *run.ranks;
  const Index first = count * ranks.rank() / ranks.size();
  const Index last = count * (ranks.rank() + 1) / ranks.size();
  std::vector<T> mine(last - first);
  run.parallelFor(last - first, grain, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i)
    {
      mine[i] = value(first + i);
    }
  });
  return ranks.size() == 1 ? mine : ranks.gatherAll(mine);
}

} // namespace bsv
