// SPDX-License-Identifier: BSD-3-Clause
/// @file BoxTree.h
/// Which of many boxes meet another one.
#pragma once

#include "Base/Types.h"

#include <Eigen/Geometry>
#include <unsupported/Eigen/BVH>

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
  {
    std::vector<Index> numbers(boxes.size());
    std::iota(numbers.begin(), numbers.end(), Index(0));
    this->Tree.init(numbers.begin(), numbers.end(), boxes.begin(), boxes.end());
  }

  /// Calls visit(number) for boxes that may meet `box`, among them all that do.
  template <typename Visit>
  void search(const Box& box, const Visit& visit) const
  {
    this->searchIf([&](const Box& volume) { return volume.intersects(box); }, visit);
  }

  /// Calls visit(number) for boxes of which meets(box) may hold, among them all of which it does. What meets a box must
  /// meet all larger ones.
  template <typename Meets, typename Visit>
  void searchIf(const Meets& meets, const Visit& visit) const
  {
    Query<Meets, Visit> query{ meets, visit };
    Eigen::BVIntersect(this->Tree, query);
  }

private:
  template <typename Meets, typename Visit>
  struct Query
  {
    const Meets& meets;
    const Visit& visit;

    bool intersectVolume(const Box& volume) const { return this->meets(volume); }
    bool intersectObject(Index number) const
    {
      this->visit(number);
      return false;
    }
  };

  Eigen::KdBVH<double, 3, Index> Tree;
};

} // namespace bsv
