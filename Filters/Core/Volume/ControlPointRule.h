// SPDX-License-Identifier: BSD-3-Clause
/// @file ControlPointRule.h
/// How the control points of a volume were made: data of a volume, as its points are.
#pragma once

#include "Base/Types.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace bsv
{

/// How a control point was made. Values are the codes of the point array `ControlPointRule`.
enum class ControlPointRule : std::uint8_t
{
  Copied,                  ///< mesh point, unchanged
  Regular,                 ///< tensor product of the knot-insertion masks (5.34)-(5.37), table 5.1
  Boundary,                ///< the rule of one dimension less, on an outer boundary
  Symmetry,                ///< the same, on a symmetry plane
  PlanarSide,              ///< unchanged points of a planar side, or inserted between them
  Body,                    ///< regular point of the body surface
  BodyExtraordinaryVertex, ///< at a body vertex where other than four patches meet (5.38)-(5.41)
  Crease,                  ///< one-dimensional rule along a crease or a sharp boundary curve, and fading above it
  Corner,                  ///< unchanged corner, or inserted next to one
  ExtraordinaryEdge,       ///< layer rule at an interior edge of valence other than four (3.31), (5.42), (5.43)
  SingularNode,            ///< at an interior vertex where the layer is not unique
  WallLayer,               ///< first inserted layer at the wall (5.44)
  FarFieldLayer,           ///< first inserted layer of the far-field extension
  Count
};

/// Names of the codes, in order.
const std::vector<std::string>& controlPointRuleNames();

/// Control points per ControlPointRule.
using RuleCounts = std::array<Index, static_cast<std::size_t>(ControlPointRule::Count)>;

} // namespace bsv
