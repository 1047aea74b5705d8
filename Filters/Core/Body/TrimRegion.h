// SPDX-License-Identifier: BSD-3-Clause
/// @file TrimRegion.h
/// Which part of a patch's parameter domain its trimming loops enclose, decided on the exact curves.
#pragma once

#include "Body/NURBSSurface.h"

#include <Eigen/Geometry>

#include <vector>

namespace bsv
{

using Box2 = Eigen::AlignedBox2d;

/// Points that lie inside an odd number of loops. The orientation and the order of the loops do not matter.
class TrimRegion
{
public:
  TrimRegion() = default;
  /// Of all `loops`; they may be destroyed afterwards.
  explicit TrimRegion(const std::vector<TrimLoop>& loops);

  /// Whether the point lies inside; without loops always.
  bool contains(const Vec2& point) const;

  enum class Place
  {
    Inside,
    Outside,
    Crossed
  };
  /// Place of a whole box.
  Place classify(const Box2& box) const;

  bool empty() const { return this->Pieces.empty(); }

private:
  /// Part of a curve on which v is monotone, or so short that its chord will do (curve -1).
  struct Piece
  {
    Vec2 from, to;
    Box2 box;
    int curve;
    double first, last;
  };
  double crossing(const Piece& piece, double v) const;

  std::vector<ParameterCurve> Curves;
  std::vector<Piece> Pieces;
};

} // namespace bsv
