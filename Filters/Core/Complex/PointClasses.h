// SPDX-License-Identifier: BSD-3-Clause
/// @file PointClasses.h
/// Which points coincide, and which quadrilaterals have the same four points.
#pragma once

#include "Base/UnionFind.h"
#include "Complex/GluingPass.h"

#include <array>
#include <optional>

namespace bsv
{

/// Points that coincide are one class: first those that are equal bit for bit, then those near each other around
/// quadrilaterals without a partner. Two quadrilaterals with the same four classes meet.
class PointClasses : public GluingPass
{
public:
  using Key = std::array<Index, 4>;

  explicit PointClasses(const GluingPass& pass)
    : GluingPass(pass)
  {
  }
  /// @param quads the undecided quadrilaterals that are known here, ascending.
  void mergeEqualPoints(const std::vector<Index>& quads);
  /// Merges classes of points that are near each other, around quadrilaterals without a partner. True if any were.
  ///
  /// Of classes with a point here all members and all near classes are known. Others may be known in part only; they
  /// are merged with those alone. If nothing is refused on any rank, all that are merged are near each other, so that
  /// this is enough to know all points of a class.
  bool mergeNearPoints(const std::vector<Index>& quads, const std::vector<Index>& single);
  /// Pairs the quadrilaterals with equal classes. @throws Error for more than two at one place and for collapsed ones,
  /// unless those are allowed.
  void pairQuads(const std::vector<Index>& quads);
  /// Classes of the corners of a quadrilateral.
  Key key(const QuadAt& at) const;

private:
  Vec3 pointOf(Index point) const;
  /// Calls visit(block, position, surface point) once for every corner of the quadrilaterals, in ascending order.
  template <typename Visit>
  void forEachPoint(const std::vector<Index>& quads, const Visit& visit) const
  {
    std::vector<bool> used;
    for (auto next = quads.begin(); next != quads.end();)
    {
      QuadAt at = this->Surface.quadAt(*next);
      const int block = at.block;
      const Index first = this->Points->firstPoint(block);
      const Index count = this->Points->firstPoint(block + 1) - first;
      used.assign(count, false);
      for (; next != quads.end() && *next < this->Surface.firstQuad(block + 1); ++next)
      {
        at = this->Surface.quadAt(*next, block);
        for (Index point : this->Points->corners(at))
        {
          used[point - first] = true;
        }
      }
      for (Index point = 0; point < count; ++point)
      {
        if (used[point])
        {
          visit(block, this->Points->pointAt(block, first + point), first + point);
        }
      }
    }
  }
  /// Orientation code from quadrilateral `a` to `quadB` with the classes `b`, which are a's in another order.
  int orientation(const QuadAt& a, Index quadB, const Key& b) const;
  /// Number of a point that is the same on all ranks.
  Index place(Index point) const;
  /// All members of a class must be near each other: a chain of near points is not one point.
  void checkWidths(const std::vector<Index>& points, const std::vector<Vec3>& x, const std::vector<double>& tolerance,
    UnionFind& merged) const;

  static constexpr Index Chunk = 1024;
  /// More points than blocks of any sensible mesh meet.
  static constexpr int MostCopies = 1000;

  /// The points of the blocks where something is searched.
  std::optional<SurfaceNumbering> Points;
  /// Per such point the one that stands for its class, or -1 where nothing is searched.
  std::vector<Index> Class;
};

} // namespace bsv
