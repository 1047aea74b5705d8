// SPDX-License-Identifier: BSD-3-Clause
#include "Wall/WallPoints.h"

#include "Base/Numbers.h"
#include "Ranks/OwnedValues.h"

#include <algorithm>

namespace bsv
{

Wall::Wall(const BlockComplex& complex, const EntityRules& rules)
  : Complex(complex)
  , Rules(rules)
  , FaceOffset(complex.faces.size(), -1)
  , EdgeOffset(complex.edges.size(), -1)
  , VertexId(complex.vertices.size(), -1)
{
  for (int f = 0; f < static_cast<int>(complex.faces.size()); ++f)
  {
    if (this->isWall(f))
    {
      this->Faces.push_back(f);
      this->numberFace(f);
    }
  }
}

bool Wall::isWall(int face) const
{
  return this->Complex.faces[face].boundary() && this->Rules.faces[face].role == BoundaryRole::Body;
}

std::vector<Vec3> Wall::points(const Ranks& ranks) const
{
  const std::vector<ComplexBlock>& blocks = this->Complex.blocks;
  const std::vector<Triple> all = gatherFromOwners<Triple>(
    ranks, this->Places.size(), [&](std::size_t i) { return blocks[this->Places[i].block].rank; },
    [&](std::size_t i) { return triple(blocks[this->Places[i].block].points(this->Places[i].ijk)); });
  std::vector<Vec3> points(all.size());
  std::transform(all.begin(), all.end(), points.begin(), vec3);
  return points;
}

Index Wall::id(int block, int face, int s, int t) const
{
  const ComplexBlock& owner = this->Complex.blocks[block];
  const int ns = owner.cells(faceAxis(face, 0));
  const int nt = owner.cells(faceAxis(face, 1));
  const bool endS = s == 0 || s == ns;
  const bool endT = t == 0 || t == nt;
  if (endS && endT)
  {
    return this->VertexId[owner.vertices[faceCorner(face, s == 0 ? 0 : 1, t == 0 ? 0 : 1)]];
  }
  if (endS || endT)
  {
    const int edge = faceEdge(face, endS ? 1 : 0, endS ? (s == 0 ? 0 : 1) : (t == 0 ? 0 : 1));
    const int along = endS ? t : s;
    return this->edgeId(owner.edges[edge], owner.edgeReversed[edge] ? (endS ? nt : ns) - along : along);
  }
  return this->FaceOffset[owner.faces[face]] + (s - 1) + Index(ns - 1) * (t - 1);
}

Index Wall::id(int block, int face, const Ijk& ijk) const
{
  return this->id(block, face, ijk[faceAxis(face, 0)], ijk[faceAxis(face, 1)]);
}

Index Wall::edgeId(int edge, int k) const
{
  const ComplexEdge& shared = this->Complex.edges[edge];
  return k == 0         ? this->VertexId[shared.vertices[0]]
    : k == shared.cells ? this->VertexId[shared.vertices[1]]
                        : this->EdgeOffset[edge] + k - 1;
}

bool Wall::hasEdge(int edge) const
{
  return this->VertexId[this->Complex.edges[edge].vertices[0]] >= 0 && this->HasEdge.count(edge) > 0;
}

void Wall::numberFace(int f)
{
  const FaceUse& use = this->Complex.faces[f].uses.front();
  const ComplexBlock& owner = this->Complex.blocks[use.block];
  const Ijk cells{ owner.cells(0), owner.cells(1), owner.cells(2) };
  const int ns = cells[faceAxis(use.face, 0)];
  const int nt = cells[faceAxis(use.face, 1)];
  for (int corner = 0; corner < 4; ++corner)
  {
    Index& id = this->VertexId[owner.vertices[faceCorner(use.face, corner & 1, corner >> 1)]];
    if (id < 0)
    {
      id = this->size();
      this->Places.push_back({ use.block, facePoint(cells, use.face, (corner & 1) * ns, (corner >> 1) * nt) });
    }
  }
  for (int axis = 0; axis < 2; ++axis)
  {
    for (int side = 0; side < 2; ++side)
    {
      const int edge = faceEdge(use.face, axis, side);
      const int global = owner.edges[edge];
      if (!this->HasEdge.insert(global).second)
      {
        continue;
      }
      this->EdgeOffset[global] = this->size();
      const int n = axis == 0 ? ns : nt;
      for (int k = 1; k < n; ++k)
      {
        const int along = owner.edgeReversed[edge] ? n - k : k;
        const int across = side * (axis == 0 ? nt : ns);
        this->Places.push_back(
          { use.block, facePoint(cells, use.face, axis == 0 ? along : across, axis == 0 ? across : along) });
      }
    }
  }
  this->FaceOffset[f] = this->size();
  for (int t = 1; t < nt; ++t)
  {
    for (int s = 1; s < ns; ++s)
    {
      this->Places.push_back({ use.block, facePoint(cells, use.face, s, t) });
    }
  }
}

} // namespace bsv
