// SPDX-License-Identifier: BSD-3-Clause
/// @file SpanRepair.h
/// Whether the converted spans are valid, and the repair of those that are not although their mesh cells are.
///
/// Smoothing can fold coarse or strongly distorted cells. Then mesh points near the failing spans are moved, and the
/// conversion, with all its decisions unchanged, makes the control points from the moved ones: what is shared stays
/// shared, what joins smoothly still does. A control point is a fixed linear combination of mesh points, so the
/// gradient of a span's penalty (JacobianPenalty.h) with respect to these is known.
///
/// In a sweep every failing span e proposes the least-squares step d = -2 f g / |g|^2 in the coordinates of its points'
/// cells (S, the square root of the mean of e e^T over the cells' edges at a point; thin layers are not crossed); no
/// step is longer than 0.15 cells. Points take the sum of what is proposed to them, divided by the number of spans that
/// need the point, if it is more than one. All spans of a sweep start from the same points, all sums are sorted:
/// numbering, threads and ranks do not matter.
///
/// Untangling (ConversionOptions::untangle) is the same for spans whose mesh cells are not valid either; s is then the
/// volume of a cell with the mean edges around. The penalty is that of P. M. Knupp, Hexahedral and tetrahedral mesh
/// untangling, Engineering with Computers 17, 2001, doi:10.1007/s003660170006, squared, with all Bernstein coefficients
/// in place of the corners' determinants.
///
/// Sweeps end when neither fewer spans fail nor their penalties become smaller for some sweeps.
///
/// Where spans linked by moved points do not all become valid, their points are put back, unless fewer fail than before
/// and only such as did before.
///
/// Points of the body and of connection layers never move. Other boundary points move once a span that they belong to
/// has failed for some sweeps: in their plane on planar sides and symmetry planes, along the curve on creases.
#pragma once

#include "Conversion/ConversionContext.h"
#include "Conversion/G1Joins.h"

#include <functional>

namespace bsv
{

/// Certifies the spans chosen by ConversionOptions::checkSpans and repairs them, if ConversionOptions::repairSpans.
/// The nets must be converted; `context.moved` must be null. Collective; the report is the same on all ranks.
SpanReport checkSpans(const ConversionContext& context, const Execution& run);

/// ExactG1: converted nets with room for double knots get these and joins (G1Joins.h); then their spans are certified.
/// Where some are not proven, and ConversionOptions::repairSpans, the nets with single knots are checked and repaired
/// first, as above. Where the joins still make spans invalid that were valid, layers next to them are left as they are,
/// in rounds; at last all are.
/// @param convert makes the nets with single knots, without that room, with their check and repair. Collective.
/// @param[out] spans as of checkSpans().
G1Report joinAndCheck(const ConversionContext& context, const std::function<SpanReport()>& convert, SpanReport& spans,
  const Execution& run);

} // namespace bsv
