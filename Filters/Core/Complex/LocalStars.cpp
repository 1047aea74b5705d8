// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/LocalStars.h"

#include <algorithm>

namespace bsv
{
namespace
{

/// A face, edge or corner of a block: the side at which it lies per direction, -1 where it runs from end to end.
using Sides = std::array<int, 3>;

Sides sidesOfFace(int face)
{
  Sides sides{ -1, -1, -1 };
  sides[faceDirection(face)] = faceSide(face);
  return sides;
}

Sides sidesOfEdge(int edge)
{
  Sides sides{ -1, -1, -1 };
  for (const int axis : { 0, 1 })
  {
    sides[faceAxis(2 * edgeDirection(edge), axis)] = edgeSide(edge, axis);
  }
  return sides;
}

bool contains(const Sides& outer, const Sides& inner)
{
  for (int d = 0; d < 3; ++d)
  {
    if (outer[d] >= 0 && outer[d] != inner[d])
    {
      return false;
    }
  }
  return true;
}

PointBox pointsNear(const ComplexBlock& block, int number, const Sides& sides)
{
  PointBox box;
  box.block = number;
  for (int d = 0; d < 3; ++d)
  {
    const int n = block.cells(d);
    box.lo[d] = sides[d] == 1 ? n - 1 : 0;
    box.hi[d] = sides[d] == 0 ? 1 : n;
  }
  return box;
}

} // namespace

LocalStars::LocalStars(const BlockComplex& complex, const Ranks& ranks)
  : Original(complex)
{
  if (ranks.size() == 1)
  {
    return;
  }
  const auto anyHere = [&](const auto& uses) {
    return std::any_of(
      uses.begin(), uses.end(), [&](const auto& use) { return complex.blocks[use.block].rank == ranks.rank(); });
  };
  for (const ComplexFace& face : complex.faces)
  {
    this->Faces.push_back(anyHere(face.uses));
  }
  for (const ComplexEdge& edge : complex.edges)
  {
    this->Edges.push_back(anyHere(edge.uses));
  }
  for (const ComplexVertex& vertex : complex.vertices)
  {
    this->Vertices.push_back(anyHere(vertex.corners));
  }

  std::vector<PointBox> wanted;
  const int count = static_cast<int>(complex.blocks.size());
  for (int b = 0; b < count; ++b)
  {
    const ComplexBlock& block = complex.blocks[b];
    std::vector<Sides> shared;
    const auto add = [&](bool here, const Sides& sides) {
      // Larger entities come first and cover those that they contain.
      const auto covers = [&](const Sides& other) { return contains(other, sides); };
      if (here && std::none_of(shared.begin(), shared.end(), covers))
      {
        shared.push_back(sides);
        wanted.push_back(pointsNear(block, b, sides));
      }
    };
    if (block.rank == ranks.rank())
    {
      continue;
    }
    for (int face = 0; face < 6; ++face)
    {
      add(this->Faces[block.faces[face]], sidesOfFace(face));
    }
    for (int edge = 0; edge < 12; ++edge)
    {
      add(this->Edges[block.edges[edge]], sidesOfEdge(edge));
    }
    for (int corner = 0; corner < 8; ++corner)
    {
      add(this->Vertices[block.vertices[corner]],
        { cornerSide(corner, 0), cornerSide(corner, 1), cornerSide(corner, 2) });
    }
  }
  this->Copy = std::make_unique<BlockComplex>(complex);
  this->Memory = fetchPoints(
    wanted, count, [&](int b) { return complex.blocks[b].rank; },
    [&](int b) -> GridView& { return this->Copy->blocks[b].points; }, ranks);
}

} // namespace bsv
