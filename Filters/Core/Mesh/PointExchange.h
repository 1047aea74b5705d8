// SPDX-License-Identifier: BSD-3-Clause
/// @file PointExchange.h
/// Points of blocks that are on other ranks.
#pragma once

#include "Base/Types.h"
#include "Mesh/GridView.h"
#include "Ranks/Ranks.h"

#include <array>
#include <functional>
#include <memory>
#include <vector>

namespace bsv
{

/// A box of mesh points of a block, both ends included.
struct PointBox
{
  int block = 0;
  std::array<int, 3> lo{ 0, 0, 0 };
  std::array<int, 3> hi{ 0, 0, 0 };
};

/// The boxes of points of one structured grid that are known here; behind a GridView.
class PointBoxes
{
public:
  explicit PointBoxes(const std::array<int, 3>& counts)
    : Counts(counts)
  {
  }

  const std::array<int, 3>& counts() const { return this->Counts; }
  /// Points of the grid per box, i fastest.
  void add(const std::array<int, 3>& lo, const std::array<int, 3>& hi, std::vector<double> xyz);
  /// Address of the x y z of the point at an offset in the whole grid, i fastest, or null.
  const double* find(Index offset) const;

private:
  struct Box
  {
    std::array<int, 3> lo, hi;
    std::vector<double> points;
  };
  std::array<int, 3> Counts;
  std::vector<Box> Boxes;
};

/// Gives the views of blocks on other ranks the points of the boxes wanted of them, and takes from them all others.
/// Boxes of blocks that are here are ignored. Collective.
///
/// @param wanted boxes of any blocks, in the coordinates of their views.
/// @param blockCount number of blocks, the same on all ranks. @param rankOf rank that has a block's points.
/// @param viewOf the view of a block.
/// @return the memory behind the views.
std::vector<std::shared_ptr<PointBoxes>> fetchPoints(const std::vector<PointBox>& wanted, int blockCount,
  const std::function<int(int block)>& rankOf, const std::function<GridView&(int block)>& viewOf, const Ranks& ranks);

} // namespace bsv
