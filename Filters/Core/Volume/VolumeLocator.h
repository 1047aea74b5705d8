// SPDX-License-Identifier: BSD-3-Clause
/// @file VolumeLocator.h
/// The inverse of evaluation: block and parameters of points.
#pragma once

#include "Volume/BSplineVolume.h"

#include <Eigen/Geometry>

#include <memory>
#include <vector>

namespace bsv
{

/// Where a point lies in multi-block volumes.
struct VolumePlace
{
  /// -1: in none.
  int block = -1;
  /// Parameters of the knots.
  Vec3 uvw = Vec3::Zero();
  /// Of the volume at `uvw` from the point, at most the tolerance.
  double distance = 0.0;
};

/// Finds points in volumes by exclusion and Newton's method.
///
/// A span lies in the boxes of its Bezier points, along the axes and along its own directions. Spans of which one does
/// not hold the point are excluded, which is a proof; in the others Newton's method starts from the middle. Where it
/// fails, the span is halved in all directions and its parts are treated likewise, at most MaximumHalvings times. A
/// result depends on the point and the volumes alone.
class VolumeLocator
{
public:
  /// Parts of a span are excluded, or hold the point, long before; what is left then is a fold.
  static constexpr int MaximumHalvings = 6;

  /// Of volumes whose points are here. They must live as long as the locator, and their points must not change.
  explicit VolumeLocator(const std::vector<BSplineVolume>& volumes, const Execution& run = {});
  ~VolumeLocator();
  VolumeLocator(VolumeLocator&&) noexcept;
  VolumeLocator& operator=(VolumeLocator&&) noexcept;

  /// Box of all control points here; empty without any.
  const Eigen::AlignedBox3d& bounds() const;

  /// At points that blocks or spans share, the block of the lowest number, in it the span of the lowest.
  /// @param tolerance largest distance at which a point counts as found, in units of length; less than rounding, about
  /// 1e-14 of the diagonal of the volumes, finds nothing.
  VolumePlace locate(const Vec3& point, double tolerance) const;

private:
  struct Spans;
  std::unique_ptr<const Spans> Data;
};

} // namespace bsv
