// SPDX-License-Identifier: BSD-3-Clause
/// @file WholeFaces.h
/// Faces that meet as a whole, point by point and bit by bit: what most contacts are.
#pragma once

#include "Complex/GluingPass.h"

#include <array>

namespace bsv
{

/// Takes pairs of faces, undecided as a whole, that are equal point by point and bit by bit; found without a search for
/// the single points.
class WholeFaces : public GluingPass
{
public:
  explicit WholeFaces(const GluingPass& pass)
    : GluingPass(pass)
  {
  }
  /// Collective.
  void operator()();

private:
  /// Every rank gets the corners of all blocks.
  void gatherCorners();
  Vec3 faceCornerPoint(Index face, int cs, int ct) const;
  /// The one orientation code in which the corners of two faces are equal, or -1.
  int faceOrientation(Index a, Index b) const;
  /// Leaves out contacts of faces with collapsed quadrilaterals, which must be told from the others one by one.
  void withoutCollapsed(std::vector<Interface>& contacts) const;
  bool hasCollapsed(int block, int face) const;

  /// Per block the coordinates of its corners, if there are other ranks.
  std::vector<std::array<double, 24>> Corners;
};

} // namespace bsv
