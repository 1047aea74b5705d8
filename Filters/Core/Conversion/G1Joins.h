// SPDX-License-Identifier: BSD-3-Clause
/// @file G1Joins.h
/// Exact G1 of converted control nets: at extraordinary edges through all layers, and at extraordinary vertices of the
/// wall.
///
/// It starts from the nets of the rules with single knots, into which double knots were inserted (DoubleKnots.h). Every
/// layer of control points across an extraordinary edge then gets the linear rule R0 (LocalNet.h). That is the same as
/// R0 in every mesh layer before the rule across the layers, since both are linear. What the fit to the body (G1Fit.h)
/// changes on the wall is carried into the layers by w(d) = max(0, 1 - d / (r h)), d along the control points of the
/// edge, h the edge length on the wall, r the propagation range: it fulfils the same conditions, at every w.
///
/// Left out, because the layers are not smooth there already: layers near singular nodes (up to the fourth control
/// layer), layers where a face that rises from a crease keeps its points, corners. So are layers next to spans that a
/// former attempt made invalid; the wall at the ends of such edges is not fitted. Layers that keep their points on
/// planar sides have their c_1 moved as little as condition (a) needs: they stay in their planes.
#pragma once

#include "Conversion/NetFans.h"

#include <vector>

namespace bsv
{

/// Makes nets with the double knots of `context.doubled` exactly G1. Collective.
/// @param avoid spans next to which layers are not joined, the same on all ranks.
/// @param joinNothing nothing is changed.
G1Report makeExactG1(
  const ConversionContext& context, const std::vector<JoinedSpan>& avoid, bool joinNothing, const Execution& run);

} // namespace bsv
