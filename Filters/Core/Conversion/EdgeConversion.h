// SPDX-License-Identifier: BSD-3-Clause
/// @file EdgeConversion.h
/// Control points owned by an edge: layers of quadrilaterals across it.
#pragma once

#include "Conversion/ConversionContext.h"

namespace bsv
{

void convertEdge(const ConversionContext& context, int edge);
/// Layers begin to end - 1 of it; mesh points 0 and cells belong to the vertices.
void convertEdgeLayers(const ConversionContext& context, int edge, int begin, int end);

/// Control points of layer k, before the rule along the edge. `base` is the neighbouring wall or connection layer, or
/// -1. If the spacing c varies over it, each point is moved along its mesh line so that applying the edge's c gives the
/// result of the point's own c.
Fan controlFan(const ConversionContext& context, int edge, const EdgeFan& fan, int k, int base = -1);

/// How far the faces behind the spokes keep their points in layer k.
std::vector<SpokeKeep> spokeKeeps(const ConversionContext& context, const EdgeFan& fan, int k);

/// FaceRule::keep of a block's face at a mesh point.
double keepAt(const ConversionContext& context, int block, int face, const Ijk& point);

/// (1 - c) at one mesh point of a block's face over (1 - c) at another.
double layerRatio(const ConversionContext& context, int block, int face, const Ijk& point, const Ijk& reference);

} // namespace bsv
