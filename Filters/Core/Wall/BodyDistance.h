// SPDX-License-Identifier: BSD-3-Clause
/// @file BodyDistance.h
/// How far the converted wall is from the body, at its knots and between them.
#pragma once

#include "Base/Types.h"
#include "Body/ClosestPoint.h"
#include "Volume/BSplineVolume.h"

#include <vector>

namespace bsv
{

/// A face (BlockTopology.h) of a volume whose points are here.
struct VolumeFace
{
  const BSplineVolume* volume;
  int face;
};

struct BodyDistance
{
  /// The largest one, of the sample `where`; of several samples the one with the smallest coordinates.
  double largest = 0.0;
  Vec3 where = Vec3::Zero();
  /// In lengths of the chord of a span's side there, the mean of four; 0 where they have none.
  double inEdges = 0.0;
};

/// From each sample to its closest point on the body. Samples are the corners and the centre of every span of the faces
/// of all ranks, 5 x 5 in those 32 spans where these are farthest, and 9 x 9 in those 8 where they are then.
/// Collective; the same on all ranks.
/// @throws Aborted
BodyDistance bodyDistance(const std::vector<VolumeFace>& faces, const BodySurface& body, const Execution& run = {});

} // namespace bsv
