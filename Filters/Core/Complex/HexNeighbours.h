// SPDX-License-Identifier: BSD-3-Clause
/// @file HexNeighbours.h
/// Which cells of an unstructured hexahedral mesh meet.
#pragma once

#include "Complex/HexMesh.h"

#include <utility>
#include <vector>

namespace bsv
{

struct HexNeighbourOptions
{
  /// Boundary points are one point if they are closer than this fraction of the shortest cell edge at either of them.
  /// Range [0, 0.5); 0 takes equal points only.
  double matchTolerance = 0.05;
  /// Let quadrilaterals meet whose points have different numbers but lie at the same places. Two that have a name each
  /// stay apart.
  bool mergePoints = true;
};

struct HexNeighbours
{
  /// Per face 6 * cell + face the one that it meets, or NoHexId on the boundary.
  std::vector<HexId> next;
  /// The orientation code of the contact, seen from here.
  std::vector<std::uint8_t> orientation;
  /// Faces with a name and their tags, ascending.
  std::vector<std::pair<HexId, int>> tags;
  /// What was done and what may be wrong, one sentence each.
  std::vector<std::string> notes;
  std::vector<std::string> warnings;
};

/// Finds the faces with the same four points. Points of faces that meet by their places get one number in `mesh`: that
/// of the copy with the lexicographically smallest coordinates.
///
/// @throws Error that names cells and place: for cells with the same point twice, three cells at a face, a face whose
/// points two cells have in another order, points that are not finite, ambiguous contacts and faces that cover each
/// other without sharing their points (hanging nodes).
HexNeighbours findNeighbours(HexMesh& mesh, const HexNeighbourOptions& options, const Execution& run);

} // namespace bsv
