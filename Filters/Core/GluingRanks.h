// SPDX-License-Identifier: BSD-3-Clause
/// @file GluingRanks.h
/// What several ranks tell each other when they glue a mesh.
#pragma once

#include "BlockSurface.h"
#include "PartialMesh.h"

namespace bsv
{

/// The largest distance at which a mesh point is one with another, as far as its own mesh edges say: `matchTolerance` times
/// the shortest; 0 if none has a length.
double matchDistance(const GridView& points, const Ijk& p, double matchTolerance);

/// Fetches the points of the undecided quadrilaterals near those that are here: at least of all that have a point within
/// the match distance of either, or whose box meets one of theirs, inflated by that. Of these points the match distances
/// can be computed too. Collective.
///
/// @param open the undecided quadrilaterals of the whole mesh, ascending.
/// @return those of `open` that are here or known now, ascending.
std::vector<Index> fetchNearQuads(PartialMesh& mesh, const SurfaceNumbering& surface, const std::vector<Index>& open,
  double matchTolerance, const Execution& run);

/// Gives all ranks what each has found for the quadrilaterals of its own blocks, and forgets what it has found for others.
/// Collective.
///
/// @param quads the quadrilaterals of which this rank may have found something, ascending. A contact is known on the ranks
/// of both sides.
void shareContacts(Contacts& contacts, const std::vector<Index>& quads, const SurfaceNumbering& surface,
  const PartialMesh& mesh, const Ranks& ranks);

} // namespace bsv
