// SPDX-License-Identifier: BSD-3-Clause
/// @file HexMesh.h
/// Hexahedra that only share points: no blocks are known yet.
#pragma once

#include "Base/Types.h"
#include "Mesh/GridView.h"

#include <functional>
#include <string>
#include <vector>

namespace bsv
{

/// Number of a cell, a point, or 6 * cell + face. At most 700 million cells.
using HexId = std::uint32_t;
constexpr HexId NoHexId = ~HexId(0);
constexpr Index MostHexCells = 700000000;

/// A quadrilateral of a named boundary, its points in order around it.
struct NamedQuad
{
  std::array<HexId, 4> points;
  /// Index into HexMesh::boundaryNames.
  int tag;
};

struct HexMesh
{
  /// Eight points per cell, in the order of block corners (BlockTopology.h).
  std::vector<HexId> corners;
  /// n x 1 x 1 points.
  GridView points;
  /// Their points may be those of the cells, or others at the same places.
  std::vector<NamedQuad> quads;
  std::vector<std::string> boundaryNames;
  /// Empty, or one per name (BlockMesh::boundaryTypes).
  std::vector<std::string> boundaryTypes;
  /// Index into boundaryNames for a face on the boundary with these points, as the cells had them before any were
  /// merged, or -1. May be empty. Quadrilaterals come first.
  std::function<int(const std::array<HexId, 4>&)> tagOf;
  /// What messages call a cell.
  std::function<std::string(Index)> cellName = [](Index cell) { return "cell " + std::to_string(cell); };
  /// What messages call a point.
  std::function<std::string(Index)> pointName = [](Index point) { return "point " + std::to_string(point); };

  Index cellCount() const { return static_cast<Index>(this->corners.size()) / 8; }
  Index pointCount() const { return this->points.size(); }
};

} // namespace bsv
