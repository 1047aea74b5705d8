// SPDX-License-Identifier: BSD-3-Clause
/// @file G1Wall.h
/// The fits of the wall to the body around all extraordinary vertices (G1Fit.h), carried into the layers.
#pragma once

#include "Conversion/NetLayers.h"

namespace bsv
{

/// Collective. @return false if there is nothing to fit.
bool fitWall(const ConversionContext& context, const NetFans& fans, const NetLayers& layers, const Execution& run,
  G1Report& report);

} // namespace bsv
