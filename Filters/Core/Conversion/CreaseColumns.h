// SPDX-License-Identifier: BSD-3-Clause
/// @file CreaseColumns.h
/// How far a crease of the outer surface reaches into the volume.
///
/// On the surface a crease keeps its points, while the regular rule would round the mesh lines above it by
/// delta = rule(p) - p. In a layer thinner than that the volume would fold. So the faces that rise from a crease keep
/// their points as well, by a weight that fades out:
///
///   w = max(0, 1 - min_f |A_f (x - p)| / (r |A_f delta|))
///
/// x is the mesh point above p, r half the propagation range, and A_f the vector areas of the boundary quadrilaterals f
/// at p; those whose plane contains delta do not count. Depths are measured by volumes, so that affine maps change
/// nothing, and against each side of the crease: where one has long cells and the other short ones, as at blunt edges,
/// delta is deep against the short ones only.
///
/// Where more than two blocks meet at a crease, several faces rise from it. delta of each is that of the mask from the
/// face before to the one behind, A_f the areas beside it, and two such faces must not lean into the block between
/// them: with up = the step along the face, depths are also measured by |(up x along) . delta|. At a corner of the
/// surface the columns of several creases meet in an inner edge, whose inner points they keep; the other faces at that
/// edge then rise from it in the same way, by weights multiplied by that of the edge's point.
#pragma once

#include "Conversion/EntityRules.h"

#include <cstddef>
#include <vector>

namespace bsv
{

/// Per face how far its mesh points are kept as they are, from 0 (the smooth mask across the face) to 1; one value per
/// point, in the axes of the face's first use, s fastest. Empty: smooth. Only at points that are known on this rank, 0
/// at others.
using FaceKeeps = std::vector<std::vector<double>>;

/// Place of mesh point (s, t) of a block's face in the values of its face.
std::size_t keepIndex(const BlockComplex& complex, int block, int face, int s, int t);

/// Of every inner face that rises from a crease or from an edge where such faces meet, and of those that continue it
/// through regular edges, until the weight has faded out. Collective; each rank fills in what it knows the points of.
/// @param complex that of LocalStars. @param propagationRange 2 r; 0 turns it off.
FaceKeeps creaseColumns(
  const BlockComplex& complex, double propagationRange, const EntityRules& rules, const Ranks& ranks);

} // namespace bsv
