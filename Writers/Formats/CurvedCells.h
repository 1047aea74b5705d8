// SPDX-License-Identifier: BSD-3-Clause
/// @file CurvedCells.h
/// Knot spans as hexahedra of order 2 or 3: one cell per span, its nodes at equally spaced parameters. For spans of
/// degree up to the order, and without weights, they are exact.
#pragma once

#include "Formats/PointNumbering.h"
#include "Formats/VolumeToWrite.h"

#include <array>
#include <vector>

namespace bsv
{

/// Nodes of a cell, or of one of its sides, by their place in the lattice 0..order of the cell.
using NodeList = std::vector<Ijk>;

/// Programs number the nodes of a cell in their own ways.
enum class NodeOrder
{
  Gmsh,
  CGNS,
  Lexicographic ///< i fastest: HOPR
};

/// Corners of the hexahedron in VTK's order, as places 0 or 1.
constexpr Ijk HexCorners[8] = { { 0, 0, 0 }, { 1, 0, 0 }, { 1, 1, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { 1, 0, 1 },
  { 1, 1, 1 }, { 0, 1, 1 } };
/// Corners of the sides i min, i max, j min, j max, k min, k max, outward.
constexpr int HexSides[6][4] = { { 0, 4, 7, 3 }, { 1, 2, 6, 5 }, { 0, 1, 5, 4 }, { 3, 7, 6, 2 }, { 0, 3, 2, 1 },
  { 4, 5, 6, 7 } };

/// All nodes of a cell of order 1 to 3.
NodeList cellNodes(NodeOrder kind, int order);
/// The nodes of side i min, .. (HexSides): corners, then those inside the edges, then those inside.
NodeList sideNodes(int side, int order);

/// The cells of all blocks, with shared nodes.
class CurvedCells
{
public:
  CurvedCells(const VolumeToWrite& volume, int order, const Execution& run = {});

  const VolumeToWrite& volume() const { return this->Volume; }
  int order() const { return this->Order; }
  int blockCount() const { return static_cast<int>(this->Spans.size()); }
  const Ijk& spans(int block) const { return this->Spans[block]; }
  /// Nodes per direction of a block.
  Ijk nodes(int block) const;
  Index cellCount(int block) const;
  Index cellCount() const { return this->FirstCell.back(); }
  /// Number, from 0, of the first cell of a block. Cells follow each other with i fastest.
  Index firstCell(int block) const { return this->FirstCell[block]; }
  Index cellNumber(int block, const Ijk& cell) const
  {
    return this->FirstCell[block] + cell[0] +
      Index(this->Spans[block][0]) * (cell[1] + Index(this->Spans[block][1]) * cell[2]);
  }
  const PointNumbering& numbers() const { return this->Numbers; }

  /// Place in the block's node lattice of a node of a cell. In left-handed blocks the cell is taken mirrored along i,
  /// so that all cells are right-handed.
  Ijk node(int block, const Ijk& cell, const Ijk& local) const
  {
    const int p = this->Order;
    const int i = this->Volume.leftHanded[block] ? p - local[0] : local[0];
    return { p * cell[0] + i, p * cell[1] + local[1], p * cell[2] + local[2] };
  }
  /// Side of a cell that lies on a block face, and back.
  int sideOf(int block, int face) const { return this->Volume.leftHanded[block] && face < 2 ? 1 - face : face; }

  /// Quadrilaterals of a boundary patch.
  Index quadCount(const BoundaryPatch& patch) const
  {
    return Index(this->Spans[patch.block][faceAxis(patch.face, 0)]) * this->Spans[patch.block][faceAxis(patch.face, 1)];
  }
  /// Calls visit(cell) for the cells of a boundary patch.
  template <typename Visit>
  void forQuads(const BoundaryPatch& patch, const Visit& visit) const
  {
    const Ijk& spans = this->Spans[patch.block];
    for (int t = 0; t < spans[faceAxis(patch.face, 1)]; ++t)
    {
      for (int s = 0; s < spans[faceAxis(patch.face, 0)]; ++s)
      {
        visit(this->SpanNeighbours.cellAt({ patch.block, patch.face, s, t }));
      }
    }
  }
  /// What is across side `face` of a cell on the border of its block.
  FaceNeighbours::Neighbour across(int block, int face, const Ijk& cell) const
  {
    return this->SpanNeighbours.across({ block, face, cell[faceAxis(face, 0)], cell[faceAxis(face, 1)] });
  }
  Ijk cellAt(const QuadAt& quad) const { return this->SpanNeighbours.cellAt(quad); }

  /// The nodes of a block that is here, x y z, i fastest. @throws Aborted
  std::vector<double> positions(int block, const Execution& run) const;

  /// Whether cells of this order are exact: degrees up to it and no weights, on all ranks. Collective.
  bool exact(const Ranks& ranks) const;

private:
  const VolumeToWrite& Volume;
  int Order;
  std::vector<Ijk> Spans;
  std::vector<Index> FirstCell;
  PointNumbering Numbers;
  FaceNeighbours SpanNeighbours;
};

} // namespace bsv
