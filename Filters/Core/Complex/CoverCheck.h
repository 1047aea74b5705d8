// SPDX-License-Identifier: BSD-3-Clause
/// @file CoverCheck.h
/// Contacts that do not match node to node.
#pragma once

#include "Complex/GluingPass.h"
#include "Complex/PointClasses.h"

namespace bsv
{

/// Refuses quadrilaterals without a partner that lie on one another face to face: an interface that does not match
/// node to node. Walls that are merely close are further apart than the matching tolerance.
class CoverCheck : public GluingPass
{
public:
  /// @param classes must outlive it.
  CoverCheck(const GluingPass& pass, const PointClasses& classes)
    : GluingPass(pass)
    , Classes(classes)
  {
  }
  /// Collective. @param single the quadrilaterals without a partner that are known here, ascending.
  void operator()(const std::vector<Index>& single) const;

private:
  /// Per quadrilateral the one that covers its center, or -1 if none does or it is not here.
  std::vector<Index> covers(const std::vector<Index>& single) const;
  /// On curved faces the centers are apart. There at least a quadrilateral is covered whose corners are all shared with
  /// others that face it and have their centers before it: a coarse one that meets a refined face.
  void coverByCorners(
    const std::vector<Index>& single, const std::vector<Vec3>& normal, std::vector<Index>& cover) const;
  /// Whether the quadrilateral of unit normal `n` has `x` in its interior, up to `tolerance` along its normal.
  bool covers(const QuadAt& at, const Vec3& n, const Vec3& x, double tolerance) const;

  static constexpr Index Chunk = 1024;
  /// Corners of many quadrilaterals are compared in up to 8 parts, to need less memory, but more time.
  static constexpr Index QuadsPerPart = 1 << 17;

  const PointClasses& Classes;
};

} // namespace bsv
