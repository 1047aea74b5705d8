// SPDX-License-Identifier: BSD-3-Clause
/// @file LocalStars.h
/// The mesh points around the faces, edges and vertices of the blocks of one rank.
#pragma once

#include "Complex/BlockComplex.h"
#include "Mesh/PointExchange.h"

#include <memory>
#include <vector>

namespace bsv
{

/// A complex in which the blocks of other ranks have the points up to one step away from the faces, edges and vertices
/// that they share with blocks of this rank. So every rank can apply rules of one step's reach to all that its blocks
/// share, and get the bits that the others get.
class LocalStars
{
public:
  /// Collective. `complex` must outlive it; with one rank it is used as it is.
  LocalStars(const BlockComplex& complex, const Ranks& ranks);

  const BlockComplex& complex() const { return this->Copy ? *this->Copy : this->Original; }

  /// @name Whether a block of this rank touches the face, edge or vertex
  ///@{
  bool hasFace(int face) const { return this->Faces.empty() || this->Faces[face]; }
  bool hasEdge(int edge) const { return this->Edges.empty() || this->Edges[edge]; }
  bool hasVertex(int vertex) const { return this->Vertices.empty() || this->Vertices[vertex]; }
  ///@}

private:
  const BlockComplex& Original;
  std::unique_ptr<BlockComplex> Copy;
  std::vector<std::shared_ptr<PointBoxes>> Memory;
  std::vector<bool> Faces, Edges, Vertices;
};

} // namespace bsv
