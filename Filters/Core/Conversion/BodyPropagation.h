// SPDX-License-Identifier: BSD-3-Clause
/// @file BodyPropagation.h
/// What known points of the body change in the layers above extraordinary vertices.
///
/// The rules of the body (SurfaceConversion.h) and those of the layers above disagree by more than a thin first layer.
/// So what the body rules changed is carried into the layers:
///
///   net_k <- layerRule(mesh_k) + w(d_k) (bodyNet - layerRule(mesh_0)),   w = max(0, 1 - d / (r h))
///
/// d is the distance along the block edges that rise from the vertex, h the mean length of the surface's edges there, r
/// the propagation range. Where these edges end sooner, on a boundary that need not stay where it is, this boundary
/// moves by what is left of w: thin stacks of layers would fold otherwise. On planar sides, symmetry planes and other
/// bodies w ends with the edges.
#pragma once

#include "Conversion/Star.h"

namespace bsv
{

/// The context's own corrections must be empty. Collective.
LayerCorrections bodyCorrections(const ConversionContext& context, const Ranks& ranks);

/// How far a change of the wall is carried, given the lengths of the edges around: the propagation range times their
/// mean.
double propagationReach(const ConversionOptions& options, std::vector<double> lengths);

/// Moves the outer surface at the end of layers that have not faded out there.
void moveEnd(const ConversionContext& context, Star& star);

} // namespace bsv
