// SPDX-License-Identifier: BSD-3-Clause
/// @file ExtraordinaryCurves.h
/// The interior block edges at which other than four blocks meet, with the kinks of the layers that they pierce.
#pragma once

#include "Mesh/SharedEntities.h"
#include "Quality/Join.h"
#include "Volume/BSplineVolume.h"

#include <vector>

namespace bsv
{

class Ranks;

/// Interior edge at which other than four blocks meet.
bool isExtraordinary(const SharedEntities::Edge& edge);

/// The rank that measures a join, and has its samples.
int rankOf(const std::vector<BSplineVolume>& volumes, const Join& join);

/// Collective. @param joins measured ones
std::vector<ExtraordinaryCurve> extraordinaryCurves(const std::vector<BSplineVolume>& volumes,
  const SharedEntities& shared, const std::vector<Join>& joins, const Ranks& ranks);

} // namespace bsv
