// SPDX-License-Identifier: BSD-3-Clause
/// @file OuterSurface.h
/// The outer surface of a block complex as quadrilaterals: their numbers, points, neighbours and the cells behind them.
#pragma once

#include "Base/Numbers.h"
#include "Complex/BlockComplex.h"

#include <array>
#include <vector>

namespace bsv
{

/// Quadrilateral of a boundary face of the complex, with the mesh points (s, t) to (s + 1, t + 1) of that face.
struct OuterQuad
{
  int face = -1;
  int s = 0;
  int t = 0;
};

/// Edge of a quadrilateral, along face axis `axis` at side `side` of the other face axis.
struct OuterEdge
{
  OuterQuad quad;
  int axis = 0;
  int side = 0;
};

/// Calls visit(edge) for the four edges of a quadrilateral.
template <typename Visit>
void forOuterEdges(const OuterQuad& at, const Visit& visit)
{
  for (int e = 0; e < 4; ++e)
  {
    visit(OuterEdge{ at, e / 2, e % 2 });
  }
}

/// A quadrilateral and the cell behind it. Plain memory, so that ranks can send it.
struct OuterCell
{
  /// Corners (0,0), (1,0), (0,1), (1,1), and the points next to them inside.
  std::array<Triple, 4> outer, inner;
  /// 1, or -1 if the axes span the normal that points into the cell.
  double sign = 1.0;

  Vec3 corner(int c) const { return Vec3(this->outer[c].data()); }
  Vec3 behind(int c) const { return Vec3(this->inner[c].data()); }
  /// All of these are the same bits however the block runs.
  Vec3 center() const { return 0.25 * ((this->corner(0) + this->corner(3)) + (this->corner(1) + this->corner(2))); }
  /// Points out of the cell, of the length of the area: half the cross product of the diagonals.
  Vec3 area() const;
  /// Mean edge vectors along s, along t and into the cell.
  std::array<Vec3, 3> frame() const;
};

/// All quadrilaterals of the boundary faces of a complex, numbered face by face.
class OuterSurface
{
public:
  /// `complex` must outlive it.
  explicit OuterSurface(const BlockComplex& complex);

  const BlockComplex& complex() const { return this->Complex; }
  /// The boundary faces, ascending.
  const std::vector<int>& faces() const { return this->Faces; }
  Index quadCount() const { return this->QuadStart.back(); }
  Index firstQuad(int face) const { return this->QuadStart[face]; }
  Index quad(const OuterQuad& at) const
  {
    return this->QuadStart[at.face] + at.s + Index(this->cells(at.face, 0)) * at.t;
  }
  OuterQuad quadAt(Index quad) const;
  /// Quadrilaterals along an axis of a face.
  int cells(int face, int axis) const;
  /// The block face that a boundary face is.
  const FaceUse& use(int face) const { return this->Complex.faces[face].uses.front(); }
  /// Whether the face belongs to no named boundary.
  bool unnamed(int face) const { return this->Complex.faces[face].tag < 0; }
  int rankOf(int face) const { return this->Complex.blocks[this->use(face).block].rank; }

  /// Numbers of the corners (0,0), (1,0), (0,1), (1,1): equal where blocks share the point.
  std::array<Index, 4> nodes(const OuterQuad& at) const;
  /// The quadrilateral of the outer surface on the other side of an edge. At an edge that several parts of the surface
  /// touch, the one around the same cells.
  OuterEdge across(const OuterEdge& edge) const;
  /// The quadrilateral and its cell, of a block whose points are here.
  OuterCell cell(const OuterQuad& at) const;
  /// Calls visit(quadrilateral, cell) for those of a face from `first` to `last`, s fastest.
  template <typename Visit>
  void forCells(const OuterQuad& first, const OuterQuad& last, const Visit& visit) const
  {
    const FaceUse& use = this->use(first.face);
    const ComplexBlock& block = this->Complex.blocks[use.block];
    const Ijk cells{ block.cells(0), block.cells(1), block.cells(2) };
    const Ijk origin = facePoint(cells, use.face, 0, 0);
    const Index start = block.points.place(origin);
    const auto step = [&](int direction, int by) {
      Ijk p = origin;
      p[direction] += by;
      return block.points.place(p) - start;
    };
    const Index alongS = step(faceAxis(use.face, 0), 1), alongT = step(faceAxis(use.face, 1), 1);
    const Index inwards = step(faceDirection(use.face), faceSide(use.face) ? -1 : 1);
    OuterCell cell;
    cell.sign = this->sign(use);
    const auto read = [&](int c, int s, int t) {
      const Index at = start + s * alongS + t * alongT;
      const Vec3 x = block.points.atPlace(at), y = block.points.atPlace(at + inwards);
      cell.outer[c] = { x[0], x[1], x[2] };
      cell.inner[c] = { y[0], y[1], y[2] };
    };
    for (int t = first.t; t <= last.t; ++t)
    {
      read(1, first.s, t);
      read(3, first.s, t + 1);
      for (int s = first.s; s <= last.s; ++s)
      {
        for (const int c : { 0, 2 })
        {
          cell.outer[c] = cell.outer[c + 1];
          cell.inner[c] = cell.inner[c + 1];
        }
        read(1, s + 1, t);
        read(3, s + 1, t + 1);
        visit(OuterQuad{ first.face, s, t }, cell);
      }
    }
  }

private:
  struct Side
  {
    int face = -1;
    int axis = 0;
    int side = 0;
    bool reversed = false;
  };

  Index node(int face, int s, int t) const;
  /// OuterCell::sign of the cells at a face.
  double sign(const FaceUse& use) const
  {
    // Ascending axes span the positive normal of directions 0 and 2 and the negative one of direction 1.
    const bool outwards = (faceDirection(use.face) == 1) != (faceSide(use.face) == 1);
    return outwards != this->Complex.blocks[use.block].leftHanded ? 1.0 : -1.0;
  }
  Side& side(int face, int axis, int side) { return this->Across[4 * std::size_t(face) + 2 * axis + side]; }
  const Side& side(int face, int axis, int side) const { return this->Across[4 * std::size_t(face) + 2 * axis + side]; }

  const BlockComplex& Complex;
  std::vector<int> Faces;
  /// By face of the complex; faces inside have none.
  std::vector<Index> QuadStart;
  std::vector<Index> EdgeNodes, FaceNodes;
  /// By face of the complex, axis and side; reversed if the two faces run the edge in opposite senses.
  std::vector<Side> Across;
};

} // namespace bsv
