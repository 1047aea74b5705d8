// SPDX-License-Identifier: BSD-3-Clause
/// @file G1Fit.h
/// The fit R1 of the wall to the body around one extraordinary vertex, with exact G1 (LocalNet.h).
#pragma once

#include "Conversion/LocalNet.h"

#include <array>
#include <functional>
#include <vector>

namespace bsv
{

/// Point of the body and its unit normal, to either side.
struct FootPoint
{
  Vec3 point;
  Vec3 normal;
};

/// What the fit knows of the wall around the vertex: per sector the control points of index 0 .. `size` - 1 along both
/// spokes, the first one fastest, and per spoke the cells along it.
struct WallPatch
{
  int size = 0;
  std::vector<int> cells;
  /// As they are, and as they were before any fit.
  std::vector<std::vector<Vec3>> sectors, unfitted;
  /// Per sector whether another vertex is fitted at the far end of its first spoke, of its second, of both.
  std::vector<std::array<bool, 3>> others;

  /// Whether there are any. What is between two vertices neither of them sees whole: there the net is held more.
  bool isNearOthers() const;
};

struct G1FitResult
{
  /// Reach of the fitted net: 4, 3, or 0 if the start was kept.
  int reach = 0;
  /// The net of that reach.
  LocalNetShape shape;
  std::vector<Vec3> net;
  /// Root mean square distance of the samples before and after.
  double before = 0.0, after = 0.0;
};

/// Gauss-Newton rounds over the local net, subject to (a) to (d), with P fixed and c_1 in the tangent plane there:
/// least squares of the distances to the body along its normals at 4 x 4 samples a span, over all spans that the net
/// moves but for the samples nearer to another vertex that is fitted, and of the second differences of these distances,
/// which hold the curvature, with the weight 0.15 (0.3 where another vertex is near). Tangential movement and bending
/// of the change from the unfitted net are damped by 0.004 s min(1, kappa h)^(3/2), with h three times the mean |c_1 -
/// P| and kappa the largest principal curvature near the vertex: the damping vanishes with h and has no unit. Reach 4
/// if all spokes have 8 cells at least, else 3. The result is taken if no point moved by more than h / 3, with reach 3
/// h / 2, and the sum fell, with the first of s = 1 (4 where another vertex is near), and twice as much each time, for
/// which it is. Nothing is fitted where the samples are farther from the body than half of what the control points next
/// to the net are: there the wall is not on the body. The result does not depend on where the fan starts and in which
/// sense it runs.
/// @param start a closed fan of kinds 3 whose net fulfils the conditions; all of it in the order of its spokes.
/// @param foot its centre and the body's normal there; `curvature` the largest absolute principal curvature near it.
G1FitResult fitToBody(const WallPatch& start, const FootPoint& foot, double curvature,
  const std::function<FootPoint(const Vec3&)>& closest);

} // namespace bsv
