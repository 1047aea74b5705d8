// SPDX-License-Identifier: BSD-3-Clause
#include "Wall/Displacements.h"

#include "Base/SortedSum.h"
#include "Complex/EdgeFans.h"
#include "Mesh/BlockSurface.h"
#include "Ranks/Ranks.h"

#include <iterator>
#include <utility>

namespace bsv
{

Displacements::Displacements(const BlockComplex& complex, const Ranks& ranks)
  : Complex(complex)
  , Group(ranks)
{
  for (int b = 0; b < static_cast<int>(complex.blocks.size()); ++b)
  {
    const ComplexBlock& block = complex.blocks[b];
    this->Grids.resize(std::max<std::size_t>(this->Grids.size(), block.parent + 1));
    Index& size = this->Grids[block.parent].size;
    size = std::max(size, this->place({ b, { block.cells(0), block.cells(1), block.cells(2) } }) + 1);
  }
  for (Grid& grid : this->Grids)
  {
    grid.offsets = std::make_shared<ChangedPoints>(grid.size);
  }
}

void Displacements::raise(const PointAt& point, const Displacement& displacement)
{
  Grid& grid = this->Grids[this->Complex.blocks[point.block].parent];
  const Index slot = grid.offsets->add(this->place(point), [](Index) { return unmoved(); });
  if (slot >= static_cast<Index>(grid.weights.size()))
  {
    grid.weights.resize(grid.offsets->slots(), 0.0);
  }
  Displacement largest{ grid.weights[slot], (*grid.offsets)[slot] }, other = displacement;
  const bool larger = largest < other;
  if (larger)
  {
    std::swap(largest, other);
    grid.weights[slot] = largest.weight;
    (*grid.offsets)[slot] = largest.offset;
  }
  const auto found = grid.others.find(slot);
  if (larger && found != grid.others.end())
  {
    std::set<Displacement> left;
    std::copy_if(found->second.begin(), found->second.end(), std::inserter(left, left.end()),
      [&](const Displacement& one) { return one.equals(largest); });
    found->second = std::move(left);
  }
  if (other.equals(largest) && other < largest)
  {
    grid.others[slot].insert(other);
  }
}

std::vector<Displacement> Displacements::Grid::counting(Index slot) const
{
  std::vector<Displacement> all{ { this->weights[slot], (*this->offsets)[slot] } };
  const auto found = this->others.find(slot);
  if (found != this->others.end())
  {
    all.insert(all.end(), found->second.begin(), found->second.end());
  }
  return all;
}

void Displacements::share()
{
  std::vector<std::vector<Message>> toRank(this->Group.size());
  for (int f = 0; f < static_cast<int>(this->Complex.faces.size()); ++f)
  {
    const ComplexFace& face = this->Complex.faces[f];
    if (!face.boundary() && this->reachesAny(face.uses))
    {
      const FaceUse& use = face.uses.front();
      const ComplexBlock& block = this->Complex.blocks[use.block];
      for (int t = 1; t < block.cells(faceAxis(use.face, 1)); ++t)
      {
        for (int s = 1; s < block.cells(faceAxis(use.face, 0)); ++s)
        {
          this->unite({ SharedPoint::Face, f, s, t }, toRank);
        }
      }
    }
  }
  for (int e = 0; e < static_cast<int>(this->Complex.edges.size()); ++e)
  {
    const ComplexEdge& edge = this->Complex.edges[e];
    for (int k = 1; k < edge.cells && this->reachesAny(edge.uses); ++k)
    {
      this->unite({ SharedPoint::Edge, e, k, 0 }, toRank);
    }
  }
  for (int v = 0; v < static_cast<int>(this->Complex.vertices.size()); ++v)
  {
    if (this->reachesAny(this->Complex.vertices[v].corners))
    {
      this->unite({ SharedPoint::Vertex, v, 0, 0 }, toRank);
    }
  }
  const std::vector<std::vector<Message>> received = this->Group.exchange(toRank);
  for (const std::vector<Message>& messages : received)
  {
    for (const Message& message : messages)
    {
      for (const PointAt& copy : this->copies(message.point))
      {
        if (this->isHere(copy.block))
        {
          this->raise(copy, { message.weight, vec3(message.offset) });
        }
      }
    }
  }
}

void Displacements::apply(BlockComplex& complex)
{
  std::map<int, std::vector<ComplexBlock*>> piecesOf;
  for (int b = 0; b < static_cast<int>(complex.blocks.size()); ++b)
  {
    if (this->reaches(b))
    {
      piecesOf[complex.blocks[b].parent].push_back(&complex.blocks[b]);
    }
  }
  for (const auto& [parent, pieces] : piecesOf)
  {
    const Grid& grid = this->Grids[parent];
    ChangedPoints& points = *grid.offsets;
    const GridView before = pieces.front()->points;
    const auto given = [&](Index i) { return before.atPlace(i); };
    for (const auto& [slot, others] : grid.others)
    {
      std::vector<Vec3> offsets;
      for (const Displacement& one : grid.counting(slot))
      {
        offsets.push_back(one.offset);
      }
      points[slot] = sortedSum(offsets) / static_cast<double>(offsets.size());
    }
    points.forEach([&](Index i, Index slot) {
      const Vec3 x = given(i);
      points[slot] = isUnmoved(points[slot]) ? x : Vec3(x + points[slot]);
    });
    for (Index i = 0; before.changes() && i < grid.size; ++i)
    {
      if (before.changes()->find(i))
      {
        points.add(i, given);
      }
    }
    for (ComplexBlock* piece : pieces)
    {
      piece->points = piece->points.changed(&points);
    }
    complex.changedPoints.push_back(grid.offsets);
  }
}

Index Displacements::place(const PointAt& point) const
{
  return this->Complex.blocks[point.block].points.place(point.ijk);
}

std::vector<PointAt> Displacements::copies(const SharedPoint& point) const
{
  std::vector<PointAt> copies;
  switch (point.kind)
  {
    case SharedPoint::Face: {
      const ComplexFace& face = this->Complex.faces[point.entity];
      std::array<int, 2> st{ point.s, point.t }, cells{ 0, 0 };
      for (const FaceUse& use : face.uses)
      {
        const ComplexBlock& block = this->Complex.blocks[use.block];
        if (!copies.empty())
        {
          st = mapFacePoint(face.orientation, point.s, point.t, cells[0], cells[1]);
        }
        cells = { block.cells(faceAxis(use.face, 0)), block.cells(faceAxis(use.face, 1)) };
        copies.push_back(
          { use.block, facePoint({ block.cells(0), block.cells(1), block.cells(2) }, use.face, st[0], st[1]) });
      }
      break;
    }
    case SharedPoint::Edge: {
      const ComplexEdge& edge = this->Complex.edges[point.entity];
      for (const EdgeUse& use : edge.uses)
      {
        const ComplexBlock& block = this->Complex.blocks[use.block];
        const int along = edgeDirection(use.edge);
        Ijk ijk;
        ijk[along] = use.reversed ? edge.cells - point.s : point.s;
        for (int axis = 0; axis < 2; ++axis)
        {
          const int d = faceAxis(2 * along, axis);
          ijk[d] = edgeSide(use.edge, axis) ? block.cells(d) : 0;
        }
        copies.push_back({ use.block, ijk });
      }
      break;
    }
    case SharedPoint::Vertex:
      for (const CornerUse& use : this->Complex.vertices[point.entity].corners)
      {
        const ComplexBlock& block = this->Complex.blocks[use.block];
        Ijk ijk;
        for (int d = 0; d < 3; ++d)
        {
          ijk[d] = cornerSide(use.corner, d) ? block.cells(d) : 0;
        }
        copies.push_back({ use.block, ijk });
      }
      break;
  }
  return copies;
}

void Displacements::unite(const SharedPoint& point, std::vector<std::vector<Message>>& toRank)
{
  const std::vector<PointAt> copies = this->copies(point);
  std::set<Displacement> reaching;
  for (const PointAt& copy : copies)
  {
    const Grid& grid = this->Grids[this->Complex.blocks[copy.block].parent];
    const Index slot = grid.offsets->slot(this->place(copy));
    if (slot >= 0 && grid.weights[slot] > 0.0)
    {
      const std::vector<Displacement> counting = grid.counting(slot);
      reaching.insert(counting.begin(), counting.end());
    }
  }
  std::set<int> told;
  for (const PointAt& copy : copies)
  {
    const int rank = this->Complex.blocks[copy.block].rank;
    const bool first = told.insert(rank).second;
    for (const Displacement& displacement : reaching)
    {
      if (rank == this->Group.rank())
      {
        this->raise(copy, displacement);
      }
      else if (first)
      {
        toRank[rank].push_back({ point, displacement.weight, triple(displacement.offset) });
      }
    }
  }
}

namespace
{

/// Follows the line through a block.
/// @return whether it goes on into another one: `line` then enters that.
bool passBlock(const BlockComplex& complex, MeshLine& line, const VisitLine& visit)
{
  const ComplexBlock& owner = complex.blocks[line.block];
  const Ijk cells{ owner.cells(0), owner.cells(1), owner.cells(2) };
  const int normal = faceDirection(line.face);
  Ijk ijk = facePoint(cells, line.face, line.s, line.t);
  Vec3 below = owner.points(ijk);
  for (int k = 0; k <= cells[normal]; ++k)
  {
    ijk[normal] = faceSide(line.face) ? cells[normal] - k : k;
    const Vec3 here = owner.points(ijk);
    line.distance += (here - below).norm();
    below = here;
    const double weight = line.distance == 0.0 ? 1.0
      : line.distance < line.reach             ? 1.0 - line.distance / line.reach
                                               : 0.0;
    if (weight == 0.0)
    {
      return false;
    }
    visit({ line.block, ijk }, weight, line);
  }
  const FaceContact contact = contactOf(complex, line.block, line.face ^ 1);
  if (contact.block < 0 || ++line.passed > static_cast<int>(complex.blocks.size()))
  {
    return false;
  }
  const auto st =
    mapFacePoint(contact.orientation, line.s, line.t, cells[faceAxis(line.face, 0)], cells[faceAxis(line.face, 1)]);
  line.block = contact.block;
  line.face = contact.face;
  line.s = st[0];
  line.t = st[1];
  return true;
}

} // namespace

void follow(const BlockComplex& complex, std::vector<MeshLine> lines, const VisitLine& visit, const Ranks& ranks)
{
  do
  {
    std::vector<std::vector<MeshLine>> toRank(ranks.size());
    for (MeshLine& line : lines)
    {
      while (passBlock(complex, line, visit))
      {
        if (complex.blocks[line.block].rank != ranks.rank())
        {
          toRank[complex.blocks[line.block].rank].push_back(line);
          break;
        }
      }
    }
    lines.clear();
    for (const std::vector<MeshLine>& part : ranks.exchange(toRank))
    {
      lines.insert(lines.end(), part.begin(), part.end());
    }
  } while (ranks.any(!lines.empty()));
}

void carry(const BlockComplex& complex, std::vector<MeshLine> lines, Displacements& displacements, const Ranks& ranks)
{
  follow(
    complex, std::move(lines),
    [&](const PointAt& point, double weight, const MeshLine& line) {
      displacements.raise(point, { weight, weight * vec3(line.offset) });
    },
    ranks);
}

} // namespace bsv
