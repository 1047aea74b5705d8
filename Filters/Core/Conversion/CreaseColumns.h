// SPDX-License-Identifier: BSD-3-Clause
/// @file CreaseColumns.h
/// How far a crease of the outer surface reaches into the volume.
///
/// On the surface a crease keeps its points, while the regular rule would round the mesh lines above it by
/// delta = rule(p) - p. In a layer thinner than that the volume would fold. So the faces that rise from a crease keep
/// their points as well, by a weight that fades out:
///
///   w = max(0, 1 - d / (r |A delta|)),   d = |A (x - p)|
///
/// x is the mesh point above p, r the range, and A the vector area of the surface around p: depths are measured by
/// volumes, so that affine maps change nothing.
#pragma once

#include "Conversion/EntityRules.h"

namespace bsv
{

/// Fills FaceRule::keep of every face that rises from a crease between two blocks, and of those that continue it
/// through regular edges, until the weight has faded out. Collective; each rank fills in what it knows the points of.
/// @param complex that of LocalStars. @param range r, a multiple of the depth of the rounding; 0 turns it off.
void markCreaseColumns(const BlockComplex& complex, double range, EntityRules& rules, const Ranks& ranks);

} // namespace bsv
