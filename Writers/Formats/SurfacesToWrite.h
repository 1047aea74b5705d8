// SPDX-License-Identifier: BSD-3-Clause
/// @file SurfacesToWrite.h
/// Untrimmed NURBS patches made ready for file formats: outward normals, and which sides are sewn together.
#pragma once

#include "Body/NURBSSurface.h"
#include "Formats/VolumeToWrite.h"

#include <array>
#include <string>
#include <vector>

namespace bsv
{

/// Two sides of patches that are one edge. A side is 0 u first, 1 u last, 2 v first, 3 v last, and runs along the
/// other parameter; those of a closed patch may be its own.
struct PatchJoin
{
  std::array<int, 2> patch{ 0, 0 };
  std::array<int, 2> side{ 0, 0 };
  /// Whether the second side runs against the first.
  bool against = false;
};

struct SurfacesToWrite
{
  /// Their outward normals are those of x_u x x_v.
  std::vector<BodyPatch> patches;
  /// Every side is in one join at most, and the normals of the two patches agree there.
  std::vector<PatchJoin> joins;
  /// What was decided for the user, one sentence each.
  std::vector<std::string> notes;
};

/// Control points of a side, and their weights if the surface is rational. The knots of the other direction are
/// clamped.
struct SideCurve
{
  int degree = 0;
  std::vector<double> knots;
  std::vector<Vec3> points;
  std::vector<double> weights;
};
SideCurve sideCurve(const NURBSSurface& surface, int side);

/// Whether all points of a side are one.
/// @param size of the body.
bool isCollapsed(const SideCurve& side, double size);

/// Diagonal of the box around all control points.
double sizeOf(const std::vector<BodyPatch>& patches);

/// A body of patches. Those whose outward normal is -(x_u x x_v) get u reversed. Sides with the same control points, up
/// to 1e-9 of the size of the body, and the same knots up to an affine change, are sewn; where more than two meet, or
/// the normals do not agree, none are, which a note says.
/// @throws Error for patches that are trimmed.
SurfacesToWrite bodyToWrite(std::vector<BodyPatch> patches);

/// The wall of a volume: the faces of the boundaries that `wall` chooses, on all ranks. Their normals point into the
/// volume, out of the body that it surrounds. A patch has the name of its boundary. Sewn is what meets through the
/// volume: around an edge of the wall from face to face until the next outer face. Collective.
SurfacesToWrite wallToWrite(const VolumeToWrite& volume, const std::vector<bool>& wall, const Execution& run);

} // namespace bsv
