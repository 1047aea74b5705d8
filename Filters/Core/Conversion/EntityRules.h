// SPDX-License-Identifier: BSD-3-Clause
/// @file EntityRules.h
/// Which rule each face and edge of the complex follows. Decided once per global entity, never per block side.
#pragma once

#include "Complex/EdgeFans.h"
#include "Complex/LocalStars.h"
#include "Conversion/Conversion.h"
#include "Conversion/FarField.h"

#include <string>
#include <vector>

namespace bsv
{

struct FaceRule
{
  BoundaryRole role = BoundaryRole::Other;
  /// The planar side that this face belongs to, whose points are kept (ConversionOptions::planarSides), or -1.
  int planarSide = -1;
  /// Inner face of a side to which a far-field extension is attached.
  bool connection = false;

  bool planar() const { return this->planarSide >= 0; }
};

struct EdgeRule
{
  std::vector<EdgeFan> fans;
  /// Boundary edge where the outer surface is not smooth: a single block, a crease, a change between body, symmetry
  /// plane, planar sides and other boundaries, or blocks that touch along the edge only.
  bool feature = false;
  /// The centre of the layers around this edge keeps its points (features, planar sides, fans too small to be smooth).
  bool anchored = false;
  ControlPointRule rule = ControlPointRule::Regular;

  /// Whether a single block lies at it: a convex edge of the block structure, if it is on the boundary.
  bool oneBlock() const { return this->fans.size() == 1 && this->fans.front().sectors.size() == 1; }
  /// Interior edge of four blocks under the regular rule.
  bool regular() const { return this->rule == ControlPointRule::Regular; }
};

struct EntityRules
{
  std::vector<FaceRule> faces;
  std::vector<EdgeRule> edges;
  Index planarFaces = 0;
  /// Where a far-field extension is attached; none if there are no planar sides.
  std::vector<FarFieldSide> farField;
  /// What was too near a limit to be told by it, for the report; the same on all ranks.
  std::vector<std::string> notes;

  /// Notes how many of the planar sides that a slightly thicker plane holds are not `kept`.
  void notePlanarLimit(const std::vector<char>& kept, const std::vector<char>& thicker, double tolerance);

  /// Rule of the points of a boundary face.
  ControlPointRule boundaryRule(int face) const;
};

/// The same on all ranks. Collective.
///@{
EntityRules classify(const BlockComplex& complex, const ConversionOptions& options, const Execution& run);
EntityRules classify(const LocalStars& stars, const ConversionOptions& options, const Execution& run);
///@}

} // namespace bsv
