// SPDX-License-Identifier: BSD-3-Clause
/// @file FirstOccurrence.h
/// The first of equal items, and hashes of points.
#pragma once

#include "Base/Types.h"

#include <cstring>
#include <vector>

namespace bsv
{

/// Found so far: hash table of items of which the first of equal ones is kept.
class FirstOccurrence
{
public:
  explicit FirstOccurrence(Index expected)
  {
    std::size_t size = 16;
    while (size < static_cast<std::size_t>(expected + expected / 2))
    {
      size *= 2;
    }
    this->Slots.assign(size, Empty);
  }

  /// The earlier item for which equal(earlier) holds, or `item` itself. At most `expected` items may differ.
  template <typename Equal>
  Index insert(std::uint64_t hash, Index item, const Equal& equal)
  {
    // The upper bits of the hash are kept beside the item, so that unequal items are rarely compared.
    const std::uint64_t mark = hash & ~ItemBits;
    const std::size_t mask = this->Slots.size() - 1;
    for (std::size_t at = hash & mask;; at = (at + 1) & mask)
    {
      std::uint64_t& slot = this->Slots[at];
      if (slot == Empty)
      {
        slot = mark | static_cast<std::uint64_t>(item);
        return item;
      }
      if ((slot & ~ItemBits) == mark && equal(static_cast<Index>(slot & ItemBits)))
      {
        return static_cast<Index>(slot & ItemBits);
      }
    }
  }

private:
  static constexpr std::uint64_t ItemBits = (std::uint64_t(1) << 40) - 1;
  static constexpr std::uint64_t Empty = ~std::uint64_t(0);
  std::vector<std::uint64_t> Slots;
};

/// Mixes one more word into a hash; the constants are those of the 64-bit finalizer of MurmurHash3.
inline std::uint64_t mix(std::uint64_t hash, std::uint64_t word)
{
  hash ^= word;
  hash ^= hash >> 33;
  hash *= 0xff51afd7ed558ccdULL;
  hash ^= hash >> 33;
  hash *= 0xc4ceb9fe1a85ec53ULL;
  hash ^= hash >> 33;
  return hash;
}

inline std::uint64_t hashOf(const Vec3& x)
{
  std::uint64_t hash = 0;
  for (int d = 0; d < 3; ++d)
  {
    // +0 and -0 are the same place.
    const double value = x[d] + 0.0;
    std::uint64_t word;
    std::memcpy(&word, &value, sizeof word);
    hash = mix(hash, word);
  }
  return hash;
}

} // namespace bsv
