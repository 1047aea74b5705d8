// SPDX-License-Identifier: BSD-3-Clause
/// @file EntityRules.h
/// Which rule each face and edge of the complex follows. Decided once per global entity, never per block side.
#pragma once

#include "Conversion.h"
#include "EdgeFans.h"

#include <vector>

namespace bsv
{

struct FaceRule
{
  BoundaryRole role = BoundaryRole::Other;
  /// The planar side that this face belongs to, whose points are kept (ConversionOptions::planarSides), or -1.
  int planarSide = -1;

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

  /// Interior edge of four blocks under the regular rule.
  bool regular() const { return this->rule == ControlPointRule::Regular; }
};

struct EntityRules
{
  std::vector<FaceRule> faces;
  std::vector<EdgeRule> edges;
  Index planarFaces = 0;

  /// Rule of the points of a boundary face.
  ControlPointRule boundaryRule(int face) const;
};

EntityRules classify(const BlockComplex& complex, const ConversionOptions& options, const Execution& run);

} // namespace bsv
