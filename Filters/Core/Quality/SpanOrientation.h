// SPDX-License-Identifier: BSD-3-Clause
/// @file SpanOrientation.h
/// In which order the control points of a span are read, so that results do not depend on how blocks are stored.
#pragma once

#include "Base/Types.h"
#include "Volume/BSplineVolume.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace bsv
{

/// How the control points of a span are read: direction d of the result runs along direction order[d] of the block.
struct SpanOrientation
{
  std::array<int, 3> order;
  std::array<bool, 3> flip;
  Index start; ///< control point
  std::array<Index, 3> strides;

  /// 1, or -1 if it is a reflection.
  double sign() const
  {
    const int inversions = (this->order[0] > this->order[1]) + (this->order[0] > this->order[2]) +
      (this->order[1] > this->order[2]) + this->flip[0] + this->flip[1] + this->flip[2];
    return inversions % 2 ? -1.0 : 1.0;
  }
};

/// Finds the orientation in which the list of a span's control points, first direction fastest, comes first in
/// lexicographic order; degrees ascend with the directions.
class CanonicalOrientation
{
public:
  explicit CanonicalOrientation(const BSplineVolume& volume)
    : Volume(volume)
    , Strides{ 1, volume.count(0), Index(volume.count(0)) * volume.count(1) }
  {
    std::iota(this->Order.begin(), this->Order.end(), 0);
    std::stable_sort(
      this->Order.begin(), this->Order.end(), [&volume](int a, int b) { return volume.degree[a] < volume.degree[b]; });
  }

  SpanOrientation operator()(Index first) const;

private:
  /// Sign of the lexicographic comparison of two control points.
  int compare(Index a, Index b) const;

  SpanOrientation orientation(Index first, const std::array<int, 3>& order, int corner) const;

  SpanOrientation search(Index first) const;

  const BSplineVolume& Volume;
  std::array<Index, 3> Strides;
  std::array<int, 3> Order;
};

} // namespace bsv
