// SPDX-License-Identifier: BSD-3-Clause
/// @file SparseArray.h
/// An array of which few elements have a value.
#pragma once

#include "Base/Types.h"

#include <algorithm>
#include <memory>
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

  /// Number of elements that have memory.
  Index slots() const { return this->Slots; }
  /// Place of element i among them, or -1. It never changes.
  Index slot(Index i) const
  {
    const std::int32_t page = this->Slots == 0 ? -1 : this->PageOf[i / PageSize];
    return page < 0 ? -1 : PageSize * page + i % PageSize;
  }
  const T& operator[](Index slot) const { return this->Chunks[slot / ChunkSize][slot % ChunkSize]; }
  T& operator[](Index slot) { return this->Chunks[slot / ChunkSize][slot % ChunkSize]; }
  /// Element i, or null if it has no memory.
  const T* find(Index i) const
  {
    const Index slot = this->slot(i);
    return slot < 0 ? nullptr : &(*this)[slot];
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

  /// Gives element i memory, and with it all of its page, which become fill(index), if they have none yet.
  /// @return its slot.
  template <typename Fill>
  Index add(Index i, const Fill& fill)
  {
    const Index known = this->slot(i);
    if (known >= 0)
    {
      return known;
    }
    this->PageOf.resize((this->Size + PageSize - 1) / PageSize, -1);
    this->PageOf[i / PageSize] = static_cast<std::int32_t>(this->Slots / PageSize);
    if (this->Slots % ChunkSize == 0)
    {
      this->Chunks.emplace_back(new T[ChunkSize]);
    }
    this->Slots += PageSize;
    const Index first = i / PageSize * PageSize;
    for (Index at = first; at < std::min(first + PageSize, this->Size); ++at)
    {
      (*this)[this->slot(at)] = fill(at);
    }
    return this->slot(i);
  }

  /// Calls visit(i, slot) for all elements that have memory.
  template <typename Visit>
  void forEach(const Visit& visit) const
  {
    for (std::size_t p = 0; p < this->PageOf.size(); ++p)
    {
      const Index first = static_cast<Index>(p) * PageSize;
      for (Index i = first; this->PageOf[p] >= 0 && i < std::min(first + PageSize, this->Size); ++i)
      {
        visit(i, PageSize * this->PageOf[p] + i - first);
      }
    }
  }

private:
  static constexpr Index ChunkSize = 32 * PageSize;

  Index Size;
  Index Slots = 0;
  /// Number of a page among those that have memory, or -1; empty as long as all are.
  std::vector<std::int32_t> PageOf;
  std::vector<std::unique_ptr<T[]>> Chunks;
};

} // namespace bsv
