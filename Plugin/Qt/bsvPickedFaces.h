// SPDX-License-Identifier: BSD-3-Clause
/**
 * Block faces that were picked in the view, by cells at them: for meshes that do not name their boundaries.
 */
#ifndef bsvPickedFaces_h
#define bsvPickedFaces_h

#include <set>
#include <string>
#include <utility>

class pqOutputPort;

namespace bsv
{

struct PickedFaces
{
  /// Block and face, numbered as in the property Body Faces.
  std::set<std::pair<int, int>> faces;
  /// What cannot be told from the selection, for the user; empty if all is clear.
  std::string problem;
};

/// The faces at which the selected cells of a partitioned collection of structured grids lie. A cell at a corner or an
/// edge of its block could belong to several: it counts for those that other cells choose, and is named if none does.
PickedFaces pickedFaces(pqOutputPort* mesh);

} // namespace bsv

#endif
