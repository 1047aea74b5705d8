// SPDX-License-Identifier: BSD-3-Clause
/// @file SparseArray.h
/// An array of which few elements have a value.
#pragma once

#include "Types.h"

#include <algorithm>
#include <array>
#include <deque>
#include <vector>

namespace bsv
{

/// Elements get memory in pages of PageSize, when the first of a page is written: few enough that a few layers of a
/// block take little more than their own size, whichever way they lie in memory.
template <typename T>
class SparseArray
{
public:
  static constexpr Index PageSize = 8;

  explicit SparseArray(Index size)
    : Size(size)
  {
  }

  bool empty() const { return this->Pages.empty(); }
  /// Number of elements that have memory.
  Index slots() const { return PageSize * static_cast<Index>(this->Pages.size()); }
  /// Place of element i among them, or -1. It never changes.
  Index slot(Index i) const
  {
    const std::int32_t page = this->Pages.empty() ? -1 : this->PageOf[i / PageSize];
    return page < 0 ? -1 : PageSize * page + i % PageSize;
  }
  /// Element i, or null if it has no memory.
  const T* find(Index i) const
  {
    const Index slot = this->slot(i);
    return slot < 0 ? nullptr : &this->Pages[slot / PageSize][slot % PageSize];
  }
  /// Number of elements from i on, at most `most`, that have no memory or follow each other in it.
  Index run(Index i, Index most) const
  {
    Index end = (i / PageSize + 1) * PageSize;
    while (end < i + most && this->slot(i) < 0 && this->slot(end) < 0)
    {
      end += PageSize;
    }
    return std::min(end - i, most);
  }

  /// Element i. All of its page become fill(index) if they have no memory yet.
  template <typename Fill>
  T& at(Index i, const Fill& fill)
  {
    this->PageOf.resize((this->Size + PageSize - 1) / PageSize, -1);
    std::int32_t& page = this->PageOf[i / PageSize];
    if (page < 0)
    {
      page = static_cast<std::int32_t>(this->Pages.size());
      this->Pages.emplace_back();
      const Index first = i / PageSize * PageSize;
      for (Index at = first; at < std::min(first + PageSize, this->Size); ++at)
      {
        this->Pages.back()[at - first] = fill(at);
      }
    }
    return this->Pages[page][i % PageSize];
  }

  /// Calls visit(i, element) for all elements that have memory.
  template <typename Visit>
  void forEach(const Visit& visit)
  {
    for (std::size_t p = 0; p < this->PageOf.size(); ++p)
    {
      const Index first = static_cast<Index>(p) * PageSize;
      for (Index i = first; this->PageOf[p] >= 0 && i < std::min(first + PageSize, this->Size); ++i)
      {
        visit(i, this->Pages[this->PageOf[p]][i - first]);
      }
    }
  }

private:
  Index Size;
  /// Place in Pages, or -1; empty as long as all are.
  std::vector<std::int32_t> PageOf;
  std::deque<std::array<T, PageSize>> Pages;
};

} // namespace bsv
