// SPDX-License-Identifier: BSD-3-Clause
/// @file ShortSpokes.h
/// Condition (d) of LocalNet.h between the ends of spokes of less than three cells: all points there depend on
/// extraordinary ones.
#pragma once

#include "Conversion/NetLayers.h"

namespace bsv
{

/// Moves the points beside these spokes, from the fifth on, in all layers that are joined, and in the groups of the
/// wall. Collective.
void evenShortSpokes(
  const ConversionContext& context, const NetFans& fans, const NetLayers& layers, const Ranks& ranks);

} // namespace bsv
