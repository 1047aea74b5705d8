// SPDX-License-Identifier: BSD-3-Clause
/// @file UnionFind.h
/// Disjoint sets of numbered items.
#pragma once

#include "Base/Types.h"

#include <numeric>
#include <vector>

namespace bsv
{

/// Disjoint sets whose representative is always the smallest member, so that it does not depend on the order of the
/// unions.
class UnionFind
{
public:
  explicit UnionFind(Index count)
    : Parent(static_cast<std::size_t>(count))
  {
    std::iota(this->Parent.begin(), this->Parent.end(), Index(0));
  }

  Index find(Index item)
  {
    while (this->Parent[item] != item)
    {
      this->Parent[item] = this->Parent[this->Parent[item]];
      item = this->Parent[item];
    }
    return item;
  }

  void unite(Index a, Index b)
  {
    a = this->find(a);
    b = this->find(b);
    this->Parent[a < b ? b : a] = a < b ? a : b;
  }

private:
  std::vector<Index> Parent;
};

} // namespace bsv
