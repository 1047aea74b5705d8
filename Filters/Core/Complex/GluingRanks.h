// SPDX-License-Identifier: BSD-3-Clause
/// @file GluingRanks.h
/// What several ranks tell each other when they glue a mesh.
#pragma once

#include "Mesh/BlockSurface.h"
#include "Mesh/GridView.h"
#include "Mesh/PartialMesh.h"

namespace bsv
{

/// The largest distance at which a mesh point is one with another, as far as its own mesh edges say: `matchTolerance`
/// times the shortest; 0 if none has a length.
double matchDistance(const GridView& points, const Ijk& p, double matchTolerance);

/// Appends the undecided quadrilaterals of a face with points in a range, or of the whole face, ascending.
void appendUndecided(const SurfaceNumbering& surface, const Contacts& contacts, int block, int face,
  const FaceRange* range, std::vector<Index>& quads);

/// Fetches the points of the undecided quadrilaterals near those that are here: at least of all that have a point
/// within the match distance of either, or whose box meets one of theirs, inflated by that. Of these points the match
/// distances can be computed too. Collective.
///
/// @return the undecided quadrilaterals that are here or known now, ascending.
std::vector<Index> fetchNearQuads(PartialMesh& mesh, const SurfaceNumbering& surface, const Contacts& contacts,
  double matchTolerance, const Execution& run);

/// Makes of `contacts` what was known before and what each rank has found for its own blocks since then. Collective.
///
/// @param before the same on all ranks.
/// @param quads the quadrilaterals of which this rank may have found something, ascending. A contact must be found on
/// the ranks of both sides.
void shareContacts(Contacts& contacts, const Contacts& before, const std::vector<Index>& quads,
  const SurfaceNumbering& surface, const PartialMesh& mesh, const Ranks& ranks);

} // namespace bsv
