// SPDX-License-Identifier: BSD-3-Clause
/// @file Gluing.h
/// Which surface quadrilaterals meet: from declared contacts and boundaries, and from coincident points.
#pragma once

#include "Complex/BlockComplex.h"
#include "Mesh/BlockSurface.h"
#include "Mesh/PartialMesh.h"

namespace bsv
{

/// Decides for every surface quadrilateral what it meets; none is left undecided.
///
/// Declared contacts and boundaries are checked and taken. The rest is searched, if BlockComplexOptions::findInterfaces
/// says so: points that coincide become one class (bit-equal ones first, then, around quadrilaterals that are still
/// without a partner, those closer than BlockComplexOptions::matchTolerance times the shortest mesh edge at either);
/// two quadrilaterals with the same four classes meet.
///
/// Collective. Each rank searches the partners of its own quadrilaterals among all that are near them, of which it
/// fetches those of other ranks; what it finds is gathered, so that all ranks return the same contacts.
///
/// @throws Error for declarations out of bounds, overlapping or not matching the coordinates; more than two
/// quadrilaterals at one place; classes wider than the tolerance; collapsed quadrilaterals (unless allowed); and
/// quadrilaterals without a partner that cover each other (contacts that do not match node to node).
Contacts glue(PartialMesh& mesh, const SurfaceNumbering& surface, const std::vector<bool>& leftHanded,
  const BlockComplexOptions& options, const Execution& run);

} // namespace bsv
