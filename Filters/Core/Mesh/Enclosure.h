// SPDX-License-Identifier: BSD-3-Clause
/// @file Enclosure.h
/// Which outer faces of a mesh surround a hole, as the wall of a body does in the flow around it, and which bound it
/// from outside. Needed where boundaries have no names.
#pragma once

#include "Base/Types.h"

#include <array>
#include <vector>

namespace bsv
{

/// An outer face as a coarse grid of points.
struct CoarseFace
{
  /// Points along both axes, at least 2.
  std::array<int, 2> counts{ 2, 2 };
  /// Per point, first axis fastest.
  std::vector<Vec3> points;
  /// Whether the cross product of the axes, first x second, points out of the mesh.
  bool outward = true;
};

/// Points of a coarse face: at most this many per axis.
constexpr int CoarseFacePoints = 7;

/// How much of what lies before each face, on the side that is not the mesh, is hidden by other outer faces: the mean
/// over its quadrilaterals of the part of 13 directions, spread over the half space, whose rays hit a face. Near 1 in a
/// body, 0 on a convex outer boundary.
std::vector<double> enclosure(const std::vector<CoarseFace>& faces, const Execution& run = {});

/// The share from which a face counts as part of a hole.
constexpr double EnclosedShare = 0.6;

} // namespace bsv
