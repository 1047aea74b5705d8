// SPDX-License-Identifier: BSD-3-Clause
/// @file SpanShape.h
/// Sizes of spans, taken as hexahedra of their corners.
///
/// `corners` are the samples at level 0 (Sampling.h), `counts` of them per direction; span (i, j, k) has the corners
/// (i..i+1, j..j+1, k..k+1). All results are the same bits for any orientation of the block.
#pragma once

#include "Base/Types.h"
#include "Mesh/BlockTopology.h"

namespace bsv
{

/// Length of the hexahedron in one direction: of the mean of its four edges there, which Verdict calls a principal axis
/// (C. J. Stimpson et al., The Verdict geometric quality library, SAND2007-1751).
double spanSize(const double* corners, const Ijk& counts, const Ijk& span, int direction);

/// Largest ratio of two of the three sizes, >= 1; 0 if one of them is 0.
double spanAspectRatio(const double* corners, const Ijk& counts, const Ijk& span);

/// Larger size through smaller size, >= 1; 0 if one of them is 0.
double sizeRatio(double a, double b);

/// Mean distance of the four corners off face `face` of the span from the plane of that face: through each corner's
/// neighbour on the face, normal to the cross product of the face's diagonals. 0 if that product is 0.
double spanHeight(const double* corners, const Ijk& counts, const Ijk& span, int face);

} // namespace bsv
