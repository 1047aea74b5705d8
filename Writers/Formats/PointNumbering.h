// SPDX-License-Identifier: BSD-3-Clause
/// @file PointNumbering.h
/// One number for every point of a multi-block mesh, and what is behind every block face: from the interfaces alone.
#pragma once

#include "Mesh/BlockMesh.h"
#include "Mesh/BlockSurface.h"

#include <vector>

namespace bsv
{

/// Points that interfaces join have one number. Points count from 0 in the order of the blocks, i fastest, each where
/// it is met first. Needs memory for the points on the surfaces of the blocks, and for one number per row of points.
class PointNumbering
{
public:
  /// @param counts points per direction of the blocks. @param interfaces may cover parts of faces; ranges in points.
  PointNumbering(const std::vector<Ijk>& counts, const std::vector<Interface>& interfaces, const Execution& run = {});

  Index count() const { return this->BlockStart.back(); }
  /// Points that are met first in blocks before `block`.
  Index firstOf(int block) const { return this->BlockStart[block]; }

  Index operator()(int block, const Ijk& p) const
  {
    const Ijk& n = this->Counts[block];
    const bool surface =
      p[0] == 0 || p[1] == 0 || p[2] == 0 || p[0] + 1 == n[0] || p[1] + 1 == n[1] || p[2] + 1 == n[2];
    return surface ? this->Surface[this->Numbering.point(block, p)]
                   : this->RowStart[this->FirstRow[block] + p[1] + Index(n[1]) * p[2]] + p[0];
  }

  /// Calls visit(p) for the points that are met first in a block, in the order of their numbers.
  template <typename Visit>
  void forFirst(int block, const Visit& visit) const
  {
    Index next = this->BlockStart[block];
    const Ijk& n = this->Counts[block];
    for (int k = 0; k < n[2]; ++k)
    {
      for (int j = 0; j < n[1]; ++j)
      {
        for (int i = 0; i < n[0]; ++i)
        {
          if ((*this)(block, { i, j, k }) == next)
          {
            visit(Ijk{ i, j, k });
            ++next;
          }
        }
      }
    }
  }

private:
  std::vector<Ijk> Counts;
  SurfaceNumbering Numbering;
  /// Per surface point of the blocks.
  std::vector<Index> Surface;
  std::vector<Index> BlockStart;
  /// Of every row of points: the number of a point inside the block, less its i.
  std::vector<Index> RowStart;
  std::vector<Index> FirstRow;
};

/// What the interfaces say about the quadrilaterals of the block faces.
class FaceNeighbours
{
public:
  /// @param counts points per direction of the blocks.
  FaceNeighbours(const std::vector<Ijk>& counts, const std::vector<Interface>& interfaces);

  /// The quadrilateral that meets this one, seen from it: block -1 if it is on the boundary.
  struct Neighbour
  {
    QuadAt quad{ -1, 0, 0, 0 };
    int orientation = 0;
  };
  Neighbour across(const QuadAt& quad) const
  {
    for (const Interface& side : this->Sides[6 * std::size_t(quad.block) + quad.face])
    {
      const FaceRange& range = side.rangeA;
      if (quad.s >= range.lo[0] && quad.s < range.hi[0] && quad.t >= range.lo[1] && quad.t < range.hi[1])
      {
        // Of n quadrilaterals number s becomes n - 1 - s where the direction turns.
        const std::array<int, 2> p = mapFacePoint(side.orientation, quad.s - range.lo[0], quad.t - range.lo[1],
          range.hi[0] - range.lo[0] - 1, range.hi[1] - range.lo[1] - 1);
        return { { side.blockB, side.faceB, p[0] + side.originB[0], p[1] + side.originB[1] }, side.orientation };
      }
    }
    return {};
  }
  /// The cell of a block at a quadrilateral of one of its faces.
  Ijk cellAt(const QuadAt& quad) const
  {
    Ijk cell{};
    cell[faceDirection(quad.face)] = faceSide(quad.face) ? this->Counts[quad.block][faceDirection(quad.face)] - 2 : 0;
    cell[faceAxis(quad.face, 0)] = quad.s;
    cell[faceAxis(quad.face, 1)] = quad.t;
    return cell;
  }

private:
  std::vector<Ijk> Counts;
  /// Per block face, all contacts seen from it.
  std::vector<std::vector<Interface>> Sides;
};

/// The same contact with its sides exchanged.
Interface reversed(const Interface& contact);

} // namespace bsv
