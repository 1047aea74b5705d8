// SPDX-License-Identifier: BSD-3-Clause
/// @file HexNumbering.h
/// Unstructured hexahedra whose numbers say nothing about where they are.
///
/// All steps of baseComplex() go from cell to cell and look at what is next to them. If neighbours are far apart in
/// memory, each look waits for it: a mesh of ten million cells in random order takes ten times as long. Such a mesh is
/// first numbered anew by place. No result depends on it, only the time.
#pragma once

#include "Complex/BaseComplex.h"

#include <vector>

namespace bsv
{

/// Whether most cells have no point that is numbered near to one of the next cell. Looks at a sample; small meshes,
/// which fit into the caches of a processor, never are.
bool isScattered(const HexMesh& mesh);

/// A mesh with other numbers. Takes 28 bytes per point and 4 per cell beside those of the original, and 32 per cell
/// more while it is made.
class HexNumbering
{
public:
  /// Numbers the cells along a Morton curve through their centres and the points as the cells meet them. The corners of
  /// `original` are used up; it must outlive this object.
  HexNumbering(HexMesh& original, const Execution& run);
  HexNumbering(const HexNumbering&) = delete;
  HexNumbering& operator=(const HexNumbering&) = delete;

  /// The renumbered mesh, whose messages have the original names of cells and points.
  HexMesh& mesh() { return this->Mesh; }
  /// Gives blocks of the renumbered mesh the original numbers.
  void restore(std::vector<HexBlock>& blocks, const Execution& run) const;

private:
  HexMesh Mesh;
  std::vector<Vec3> Points;
  /// Original number of each cell and point.
  std::vector<HexId> CellOf;
  std::vector<HexId> PointOf;
};

} // namespace bsv
