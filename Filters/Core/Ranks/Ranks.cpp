// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Ranks.h"

#include <algorithm>

namespace bsv
{

std::shared_ptr<const Ranks> aloneRank()
{
  static const std::shared_ptr<const Ranks> alone = std::make_shared<Ranks>();
  return alone;
}

bool Ranks::any(bool mine) const
{
  const std::vector<char> all = this->gatherAll(std::vector<char>{ static_cast<char>(mine) });
  return std::find(all.begin(), all.end(), 1) != all.end();
}

std::vector<int> distributeBlocks(const std::vector<Index>& points, int size)
{
  Index total = 0;
  for (const Index count : points)
  {
    total += count;
  }
  std::vector<int> ranks;
  Index before = 0;
  for (const Index count : points)
  {
    // The rank in whose share of all points the middle of the block lies.
    const double middle = static_cast<double>(before) + 0.5 * static_cast<double>(count);
    ranks.push_back(total > 0 ? std::min(size - 1, static_cast<int>(size * middle / static_cast<double>(total))) : 0);
    before += count;
  }
  return ranks;
}

} // namespace bsv
