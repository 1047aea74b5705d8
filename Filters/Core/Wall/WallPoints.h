// SPDX-License-Identifier: BSD-3-Clause
/// @file WallPoints.h
/// The mesh points of the wall, each with one number.
#pragma once

#include "Complex/BlockComplex.h"
#include "Conversion/EntityRules.h"
#include "Ranks/Ranks.h"

#include <set>
#include <vector>

namespace bsv
{

/// A block and a mesh point of it.
struct PointAt
{
  int block;
  Ijk ijk;
};

/// Mesh points of the wall, numbered once each: the same on all ranks.
class Wall
{
public:
  Wall(const BlockComplex& complex, const EntityRules& rules);

  bool isWall(int face) const;
  const std::vector<int>& faces() const { return this->Faces; }
  Index size() const { return static_cast<Index>(this->Places.size()); }
  /// All points, each from the rank that has it.
  std::vector<Vec3> points(const Ranks& ranks) const;

  /// Number of mesh point (s, t) of a block's wall face.
  Index id(int block, int face, int s, int t) const;
  Index id(int block, int face, const Ijk& ijk) const;
  /// Number of point k of a wall edge.
  Index edgeId(int edge, int k) const;
  Index vertexId(int vertex) const { return this->VertexId[vertex]; }
  bool hasEdge(int edge) const;
  const std::set<int>& edges() const { return this->HasEdge; }

private:
  void numberFace(int f);

  const BlockComplex& Complex;
  const EntityRules& Rules;
  std::vector<int> Faces;
  std::vector<Index> FaceOffset, EdgeOffset, VertexId;
  std::set<int> HasEdge;
  std::vector<PointAt> Places;
};

} // namespace bsv
