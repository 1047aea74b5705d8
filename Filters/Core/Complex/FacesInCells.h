// SPDX-License-Identifier: BSD-3-Clause
/// @file FacesInCells.h
/// Faces of the outer surface that lie in other cells.
#pragma once

#include "Complex/MeshFindings.h"
#include "Complex/OuterTiles.h"

namespace bsv
{

/// Adds the overlaps: outer faces without a name from which a ray leaves cells more often than it enters them. Up to 25
/// quadrilaterals of each face are tried, and all of a face where one does. Collective.
void findFacesInCells(
  const OuterSurface& surface, const OuterTiles& tiles, const Execution& run, MeshFindings& findings);

} // namespace bsv
