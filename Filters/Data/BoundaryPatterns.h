// SPDX-License-Identifier: BSD-3-Clause
/// @file BoundaryPatterns.h
/// Selects boundaries by patterns of their names.
#pragma once

#include "BSplineVolumeFiltersModule.h"

#include <string>
#include <vector>

namespace bsv
{

/// Names of boundaries. Case does not matter, `*` stands for any text and `?` for one character.
using BoundaryPatterns = std::vector<std::string>;

/// What flow solvers and mesh generators call walls: the default of all filters that ask for the body.
BSPLINEVOLUMEFILTERS_EXPORT const BoundaryPatterns& defaultBodyBoundaries();

/// Whether any of the patterns matches the whole name.
BSPLINEVOLUMEFILTERS_EXPORT bool matchesAny(const BoundaryPatterns& patterns, const std::string& name);

/// "'a', 'b', 'c'", or "none": for messages that say what there is to choose from.
BSPLINEVOLUMEFILTERS_EXPORT std::string quotedList(const std::vector<std::string>& names);

} // namespace bsv
