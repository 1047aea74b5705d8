// SPDX-License-Identifier: BSD-3-Clause
/// @file BoundaryPatterns.h
/// Selects boundaries by patterns of their names.
#pragma once

#include "BSplineVolumeFiltersModule.h"

#include <cstdint>
#include <string>
#include <vector>

namespace bsv
{

struct BlockComplex;
enum class BoundaryRole : std::uint8_t;

/// Names of boundaries. Case does not matter, `*` stands for any text and `?` for one character.
using BoundaryPatterns = std::vector<std::string>;

/// What flow solvers and mesh generators call walls: the default of all filters that ask for the body.
BSPLINEVOLUMEFILTERS_EXPORT const BoundaryPatterns& defaultBodyBoundaries();

/// What they call symmetry planes.
BSPLINEVOLUMEFILTERS_EXPORT const BoundaryPatterns& defaultSymmetryBoundaries();

/// Whether any of the patterns matches the whole name.
BSPLINEVOLUMEFILTERS_EXPORT bool matchesAny(const BoundaryPatterns& patterns, const std::string& name);

/// Whether the patterns of a role choose boundary `tag`, by its name or its type. As long as `patterns` has all
/// `defaults`, these do not look at the name of a boundary whose type is known: a far field 'wall of the tunnel' is no
/// wall unless somebody says so.
/// @param types BlockMesh::boundaryTypes
BSPLINEVOLUMEFILTERS_EXPORT bool selectsBoundary(const BoundaryPatterns& patterns, const BoundaryPatterns& defaults,
  const std::vector<std::string>& names, const std::vector<std::string>& types, int tag);

/// selectsBoundary() for walls, whose defaults are defaultBodyBoundaries().
BSPLINEVOLUMEFILTERS_EXPORT bool isBodyBoundary(const BoundaryPatterns& patterns, const std::vector<std::string>& names,
  const std::vector<std::string>& types, int tag);

/// The role of every boundary of a complex: body before symmetry plane.
BSPLINEVOLUMEFILTERS_EXPORT std::vector<BoundaryRole> boundaryRoles(
  const BlockComplex& complex, const BoundaryPatterns& body, const BoundaryPatterns& symmetry);

/// "'a', 'b', 'c'", or "none": for messages that say what there is to choose from.
BSPLINEVOLUMEFILTERS_EXPORT std::string quotedList(const std::vector<std::string>& names);

} // namespace bsv
