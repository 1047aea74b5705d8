// SPDX-License-Identifier: BSD-3-Clause
/// @file NearPairs.h
/// Quadrilaterals of the outer surface that nearly face each other, and what that means.
#pragma once

#include "Complex/MeshFindings.h"
#include "Complex/OuterTiles.h"

#include <array>
#include <tuple>
#include <vector>

namespace bsv
{

/// Cosine of the angle between normals from which two quadrilaterals face each other: 120 degrees.
constexpr double FacingCosine = -0.5;

/// Two quadrilaterals that nearly face each other.
struct NearPair
{
  Index a = -1, b = -1;
  double fraction = 0.0;
  double distance = 0.0;
  Triple place{ 0, 0, 0 };
  /// Corner of b for each corner of a, if they can be matched.
  std::array<int, 4> corners{ -1, -1, -1, -1 };
  std::array<double, 4> distances{ 0, 0, 0, 0 };
  bool matched = false;
  /// Whether it is near by the geometry, and not for sharing three points only.
  bool near = false;
  /// The one pair of corners that is not shared, if three are.
  Index u = -1, v = -1;

  bool operator<(const NearPair& other) const { return std::tie(this->a, this->b) < std::tie(other.a, other.b); }
};

/// All pairs of quadrilaterals without a name that are near, ascending. Collective; all ranks return the same.
std::vector<NearPair> findNearPairs(const OuterSurface& surface, const OuterTiles& tiles, const Execution& run);

/// Adds what they are: walls close to each other, near misses, loose points. Collective.
void judgeNearPairs(
  const OuterSurface& surface, const std::vector<NearPair>& pairs, const Ranks& ranks, MeshFindings& findings);

} // namespace bsv
