// SPDX-License-Identifier: BSD-3-Clause
/// @file LimitMasks.h
/// Limit position and tangents of Catmull-Clark surfaces at a vertex, as weights of the points around it.
/// The masks are OpenSubdiv's (Sdc::Scheme), but for one that its own refinement contradicts; this is the only place
/// that includes it.
#pragma once

#include <vector>

namespace bsv
{

/// Affine or differential combination of the points of a fan: the centre, its spokes (next points along the edges) and
/// its sectors (opposite corners of the quadrilaterals; sector i lies between spokes i and i+1).
struct FanMask
{
  double center = 0.0;
  std::vector<double> spokes;
  std::vector<double> sectors;
};

struct LimitMasks
{
  FanMask position;
  /// Along spoke 0.
  FanMask tangent1;
  /// Closed fan: along the direction a quarter turn ahead of spoke 0 (up to scale, in the fan's affine shape: along
  /// spoke 1). Open fan: across the border, into the fan.
  FanMask tangent2;
};

/// Smooth interior vertex with `valence` >= 3 quadrilaterals around it (thesis (3.31), (4.18)).
LimitMasks closedFanLimitMasks(int valence);

/// Vertex on a smooth border or crease with `sectors` >= 1 quadrilaterals on the side in question.
LimitMasks openFanLimitMasks(int sectors);

} // namespace bsv
