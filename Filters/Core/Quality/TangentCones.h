// SPDX-License-Identifier: BSD-3-Clause
/// @file TangentCones.h
/// A quick proof that det J > 0 on a span, where its parameter lines do not turn much.
///
/// In every point the derivative in direction d is a sum, with weights that are not negative, of the differences of
/// the span's control points along d. Let N be a matrix with det N > 0. If
///     (N a)_d > sum over c != d of |(N a)_c|
/// for all differences a along d, and for all d, the same holds for the derivatives: N J is strictly diagonally
/// dominant by columns with a positive diagonal, so det N J > 0 and det J > 0 (R. A. Horn, C. R. Johnson, Matrix
/// Analysis, 2nd ed., Cambridge 2013, theorem 6.1.10). N here has the rows b x c, c x a, a x b of the mean directions
/// a, b, c of the differences: lengths of cells do not matter, nor do the angles between lines.
#pragma once

#include "Volume/BSplineVolume.h"

#include <vector>

namespace bsv
{

/// Per span of the list whether the proof succeeds. What it says of others is nothing. It fails also where det J could
/// be of the size of the rounding errors of JacobianBounds.h, so that no verdict there differs.
/// @param volume tricubic, not rational; for others nothing is proven.
/// @param spans numbers of non-empty spans, u fastest.
/// @param leftHanded det J < 0 is what is to be proven.
std::vector<bool> provenByTangentCones(const BSplineVolume& volume, const std::vector<Index>& spans, bool leftHanded);

} // namespace bsv
