// SPDX-License-Identifier: BSD-3-Clause
/// @file NetShifts.h
/// What is changed on the wall and carried into the layers, by w(d) = max(0, 1 - d / (r h)) (G1Joins.h).
#pragma once

#include "Conversion/NetLayers.h"

#include <vector>

namespace bsv
{

/// What is added to the layers of a fan: `net` on the wall, with the weights of the layers.
struct NetShift
{
  int fan;
  LocalNetShape shape;
  std::vector<Vec3> net;
  std::vector<double> weights;
};

/// A change of the wall at an end of a fan and what it becomes in the layers: in the fan and in those that continue it.
std::vector<NetShift> carriedShifts(const ConversionContext& context, const NetFans& fans, const NetLayers& layers,
  const FanEnd& wall, const LocalNetShape& shape, const std::vector<Vec3>& net);

/// Adds them to the control points of this rank; each list changes a point once, also where two of its fans meet.
void applyShifts(
  const ConversionContext& context, const NetFans& fans, const std::vector<std::vector<NetShift>>& lists);

} // namespace bsv
