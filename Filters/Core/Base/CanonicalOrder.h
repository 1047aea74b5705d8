// SPDX-License-Identifier: BSD-3-Clause
/// @file CanonicalOrder.h
/// Orders that points decide and numberings do not: where something has to come first, so that every numbering and
/// orientation of the blocks gives the same bits.
#pragma once

#include "Base/Types.h"

#include <algorithm>

namespace bsv
{

/// Lexicographic order of x, y, z.
inline bool comesBefore(const Vec3& a, const Vec3& b)
{
  return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
}

/// A cycle of n items from its first one on, towards the one of its two neighbours that comes before the other. Items
/// have numbers 0 to n - 1 in their cycle; gap i lies between items i and i + 1.
class CycleOrder
{
public:
  /// @param before whether the item of one number comes before that of another. @param n at least 1.
  template <typename Before>
  CycleOrder(int n, const Before& before)
    : N(n)
  {
    for (int i = 1; i < n; ++i)
    {
      this->First = before(i, this->First) ? i : this->First;
    }
    this->Backwards = before((this->First + n - 1) % n, (this->First + 1) % n);
  }

  /// Numbers of the item and of the gap that are the i-th in this order.
  int item(int i) const { return (this->Backwards ? this->First - i + this->N : this->First + i) % this->N; }
  int gap(int i) const { return (this->Backwards ? this->First - i - 1 + this->N : this->First + i) % this->N; }
  bool backwards() const { return this->Backwards; }

private:
  int N;
  int First = 0;
  bool Backwards = false;
};

} // namespace bsv
