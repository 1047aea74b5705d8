// SPDX-License-Identifier: BSD-3-Clause
/// @file Piece.h
/// Parts of a mesh that are asked for one by one, by ranks or by one process.
#pragma once

#include "Base/Types.h"
#include "Ranks/Ranks.h"

#include <array>
#include <vector>

namespace bsv
{

/// One of `count` pieces, which share out the blocks as distributeBlocks() does.
struct Piece
{
  int number = 0;
  int count = 1;

  /// The number of the piece that each block belongs to. @param counts points per direction of the blocks.
  std::vector<int> owners(const std::vector<std::array<int, 3>>& counts) const
  {
    std::vector<Index> points;
    points.reserve(counts.size());
    for (const std::array<int, 3>& block : counts)
    {
      points.push_back(Index(block[0]) * block[1] * block[2]);
    }
    return distributeBlocks(points, this->count);
  }
};

} // namespace bsv
