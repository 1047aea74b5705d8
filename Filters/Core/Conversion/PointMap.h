// SPDX-License-Identifier: BSD-3-Clause
/// @file PointMap.h
/// The control points that a mesh point owns: writing them, and what they are as combinations of mesh points.
#pragma once

#include "Conversion/ConversionContext.h"

#include <array>
#include <utility>
#include <vector>

namespace bsv
{

/// Writes the control points owned by a mesh point.
void convertPoint(const ConversionContext& context, const MeshPointKey& key);

/// First and last position in a control net of the control points owned by mesh point i of a direction.
std::array<int, 2> positionsOf(int i, int cells);
/// The mesh point that owns a position.
int meshIndexOf(int position, int cells);

/// Control points owned by a mesh point, in blocks of this rank, as combinations of mesh points that may move.
struct PointMap
{
  std::vector<MeshPointKey> inputs;
  /// Block and place in its net.
  std::vector<std::pair<int, Index>> outputs;
  /// Of input i in output o at [o * inputs.size() + i].
  std::vector<double> weights;
};

/// Found by differences: the rules are linear. The control points are the same afterwards.
PointMap pointMap(const ConversionContext& context, const MeshPointKey& owner);

} // namespace bsv
