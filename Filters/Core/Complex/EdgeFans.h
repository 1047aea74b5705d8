// SPDX-License-Identifier: BSD-3-Clause
/// @file EdgeFans.h
/// The blocks around an edge of the complex in cyclic order, and around a vertex.
#pragma once

#include "Complex/BlockComplex.h"

#include <vector>

namespace bsv
{

/// The other side of a block face.
struct FaceContact
{
  int block = -1; ///< -1 on the boundary
  int face = -1;
  int orientation = 0; ///< from this side to the other
};

FaceContact contactOf(const BlockComplex& complex, int block, int face);

/// One block of an edge fan.
struct FanSector
{
  int block;
  int edge; ///< the block's edge
  bool reversed;
  int along;  ///< block direction of the edge
  int first;  ///< block direction along the spoke where the sector starts
  int second; ///< block direction along the spoke where it ends

  /// Mesh point `a` steps down the first spoke and `b` down the second, in layer k counted along the global edge.
  Ijk point(const ComplexBlock& owner, int k, int a, int b) const;
  /// Block face on which the first (0) or second (1) spoke lies.
  int spokeFace(int which) const;
  /// Side (0 or 1) of the block in `direction`, one of first and second, at which the edge sits.
  int side(int direction) const { return edgeSide(this->edge, faceAxis(2 * this->along, 0) == direction ? 0 : 1); }
  /// Block face and block corner at the start (0) or end (1) of the global edge, and the block edge along the first (0)
  /// or second (1) spoke there.
  ///@{
  int endFace(int end) const { return 2 * this->along + (this->reversed ? 1 - end : end); }
  int corner(int end) const { return edgeCorner(this->edge, this->reversed ? 1 - end : end); }
  int spokeEdge(int which, int end) const;
  ///@}
};

/// A block at an edge, from the spoke in direction `first` on.
FanSector sectorAt(const EdgeUse& use, int first);

/// Blocks around an edge, each sharing a face with the next. Spoke i is the face where sector i starts; an open fan has
/// one spoke more than sectors. Where a fan starts and in which sense it runs is arbitrary.
struct EdgeFan
{
  bool closed = true;
  std::vector<FanSector> sectors;

  int spokeCount() const { return static_cast<int>(this->sectors.size()) + (this->closed ? 0 : 1); }
  /// Sector that touches spoke i, and whether the spoke is its first (0) or second (1).
  std::pair<const FanSector*, int> spoke(int i) const
  {
    return i < static_cast<int>(this->sectors.size()) ? std::make_pair(&this->sectors[i], 0)
                                                      : std::make_pair(&this->sectors.back(), 1);
  }
  /// Global face of spoke i.
  int faceOf(const BlockComplex& complex, int i) const
  {
    const auto [sector, which] = this->spoke(i);
    return complex.blocks[sector->block].faces[sector->spokeFace(which)];
  }
  /// Global edge along spoke i at the start (0) or end (1) of the edge.
  int edgeOf(const BlockComplex& complex, int i, int end) const
  {
    const auto [sector, which] = this->spoke(i);
    return complex.blocks[sector->block].edges[sector->spokeEdge(which, end)];
  }
};

/// All fans of an edge: one, unless blocks touch each other there along nothing but the edge.
std::vector<EdgeFan> edgeFans(const BlockComplex& complex, int edge);

/// Everything that touches a vertex. Edges and faces are counted once per end or corner that lies at the vertex, so a
/// block may appear several times. Points that are on other ranks and were not fetched are NaN.
struct VertexStar
{
  struct Edge
  {
    int edge; ///< global edge
    int end;  ///< 0 if the vertex is its first end
    Vec3 point;
    bool boundary;
  };
  struct Face
  {
    int face;                 ///< global face
    int corner;               ///< corner s + 2 t of the face's first use
    std::array<int, 2> edges; ///< star edges that span it
    std::array<int, 2> blocks{ -1, -1 };
    Vec3 point;
    bool boundary;
  };
  struct Block
  {
    int block;
    int corner;
    std::array<int, 3> edges; ///< star edge per block direction
    std::array<int, 3> faces; ///< star face per block direction normal to it
    Vec3 point;
  };

  Vec3 point;
  std::vector<Edge> edges;
  std::vector<Face> faces;
  std::vector<Block> blocks;

  /// Star face spanned by two star edges, or -1.
  int faceBetween(int a, int b) const;
};

VertexStar vertexStar(const BlockComplex& complex, int vertex);

/// The outer surface around a boundary vertex: star edges and star faces in cyclic order, face i between edges i and
/// i+1. Empty where the boundary faces do not form one ring. Where it starts and in which sense it runs is arbitrary.
struct BoundaryRing
{
  std::vector<int> edges;
  std::vector<int> faces;
};

BoundaryRing boundaryRing(const VertexStar& star);

} // namespace bsv
