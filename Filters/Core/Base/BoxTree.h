// SPDX-License-Identifier: BSD-3-Clause
/// @file BoxTree.h
/// Which of many boxes meet another one.
#pragma once

#include "Base/Types.h"

#include <Eigen/Geometry>
#include <unsupported/Eigen/BVH>

#include <algorithm>
#include <numeric>
#include <vector>

namespace bsv
{

using Box = Eigen::AlignedBox3d;

/// The box with `distance` more on every side.
inline Box inflated(const Box& box, double distance)
{
  return Box(box.min() - Vec3::Constant(distance), box.max() + Vec3::Constant(distance));
}

class BoxTree
{
public:
  explicit BoxTree(const std::vector<Box>& boxes)
    : BoxTree(boxes, static_cast<Index>(boxes.size()), 1)
  {
  }
  /// Box n is around items n * `together` to (n + 1) * `together` - 1 of `count`, all of which are visited for it.
  /// Where items that follow each other are near each other, this needs a fraction of the memory, which is 200 bytes
  /// per box.
  BoxTree(const std::vector<Box>& boxes, Index count, Index together)
    : Count(count)
    , Together(together)
  {
    std::vector<Index> numbers(boxes.size());
    std::iota(numbers.begin(), numbers.end(), Index(0));
    this->Tree.init(numbers.begin(), numbers.end(), boxes.begin(), boxes.end());
  }

  /// How many of `count` items in a row share a box where memory counts: of few items, which cost little, one; of
  /// many 8.
  static Index itemsPerBox(Index count) { return std::min<Index>(1 + count / (1 << 16), 8); }

  /// Calls visit(number) for items whose boxes may meet `box`, among them all of which they do.
  template <typename Visit>
  void search(const Box& box, const Visit& visit) const
  {
    this->searchIf([&](const Box& volume) { return volume.intersects(box); }, visit);
  }

  /// Calls visit(number) for items of whose boxes meets(box) may hold, among them all of which it does. What meets a
  /// box must meet all larger ones.
  template <typename Meets, typename Visit>
  void searchIf(const Meets& meets, const Visit& visit) const
  {
    Query<Meets, Visit> query{ meets, visit, this->Count, this->Together };
    Eigen::BVIntersect(this->Tree, query);
  }

private:
  template <typename Meets, typename Visit>
  struct Query
  {
    const Meets& meets;
    const Visit& visit;
    Index count;
    Index together;

    bool intersectVolume(const Box& volume) const { return this->meets(volume); }
    bool intersectObject(Index number) const
    {
      const Index end = std::min(this->count, (number + 1) * this->together);
      for (Index item = number * this->together; item < end; ++item)
      {
        this->visit(item);
      }
      return false;
    }
  };

  Eigen::KdBVH<double, 3, Index> Tree;
  Index Count;
  Index Together;
};

} // namespace bsv
