// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/EdgeFans.h"

#include <algorithm>
#include <limits>

namespace bsv
{
namespace
{

/// The block edge that touches `edge` of `block` on the other side of `face`.
int edgeAcross(int face, int edge, const FaceContact& contact)
{
  const int axis = faceAxis(face, 0) == edgeDirection(edge) ? 0 : 1;
  int side = 0;
  for (side = 0; side < 2; ++side)
  {
    if (faceEdge(face, axis, side) == edge)
    {
      break;
    }
  }
  const std::array<int, 2> from =
    axis == 0 ? mapFacePoint(contact.orientation, 0, side, 1, 1) : mapFacePoint(contact.orientation, side, 0, 1, 1);
  const int axisB = swapsAxes(contact.orientation) ? 1 - axis : axis;
  return faceEdge(contact.face, axisB, from[1 - axisB]);
}

int findUse(const ComplexEdge& edge, int block, int blockEdge)
{
  for (int i = 0; i < edge.valence(); ++i)
  {
    if (edge.uses[i].block == block && edge.uses[i].edge == blockEdge)
    {
      return i;
    }
  }
  throw Error("block complex is inconsistent: edge " + std::to_string(blockEdge) + " of block " +
    std::to_string(block) + " is not part of the edge across its face");
}

} // namespace

FaceContact contactOf(const BlockComplex& complex, int block, int face)
{
  const ComplexFace& shared = complex.faces[complex.blocks[block].faces[face]];
  if (shared.boundary())
  {
    return {};
  }
  const bool isFirst = shared.uses[0].block == block && shared.uses[0].face == face;
  const FaceUse& other = shared.uses[isFirst ? 1 : 0];
  return { other.block, other.face, isFirst ? shared.orientation : inverseOrientation(shared.orientation) };
}

FanSector sectorAt(const EdgeUse& use, int first)
{
  const int along = edgeDirection(use.edge);
  return { use.block, use.edge, use.reversed, along, first, 3 - along - first };
}

Ijk FanSector::point(const ComplexBlock& owner, int k, int a, int b) const
{
  Ijk ijk;
  ijk[this->along] = this->reversed ? owner.cells(this->along) - k : k;
  ijk[this->first] = this->side(this->first) ? owner.cells(this->first) - a : a;
  ijk[this->second] = this->side(this->second) ? owner.cells(this->second) - b : b;
  return ijk;
}

int FanSector::spokeFace(int which) const
{
  const int normal = which == 0 ? this->second : this->first;
  return 2 * normal + this->side(normal);
}

int FanSector::spokeEdge(int which, int end) const
{
  const int face = this->spokeFace(which);
  return faceEdge(face, faceAxis(face, 0) == this->along ? 1 : 0, faceSide(this->endFace(end)));
}

std::vector<EdgeFan> edgeFans(const BlockComplex& complex, int edge)
{
  const ComplexEdge& shared = complex.edges[edge];
  std::vector<EdgeFan> fans;
  std::vector<bool> visited(shared.uses.size(), false);

  // From a sector through its second spoke; false on the boundary.
  const auto step = [&](FanSector& sector) {
    const int face = sector.spokeFace(1);
    const FaceContact contact = contactOf(complex, sector.block, face);
    if (contact.block < 0)
    {
      return false;
    }
    const int use = findUse(shared, contact.block, edgeAcross(face, sector.edge, contact));
    // In the next block the spoke we came through lies on contact.face, so it runs along the other direction.
    const int along = edgeDirection(shared.uses[use].edge);
    sector = sectorAt(shared.uses[use], 3 - along - faceDirection(contact.face));
    return true;
  };
  const auto turned = [](FanSector sector) {
    std::swap(sector.first, sector.second);
    return sector;
  };
  const auto same = [](const FanSector& a, const FanSector& b) { return a.block == b.block && a.edge == b.edge; };

  for (std::size_t start = 0; start < shared.uses.size(); ++start)
  {
    if (visited[start])
    {
      continue;
    }
    const FanSector origin = sectorAt(shared.uses[start], faceAxis(2 * edgeDirection(shared.uses[start].edge), 0));
    // Walk backwards to the border, if there is one.
    FanSector first = turned(origin);
    bool closed = true;
    do
    {
      if (!step(first))
      {
        closed = false;
        break;
      }
    } while (!same(first, origin));
    EdgeFan fan;
    fan.closed = closed;
    FanSector sector = closed ? origin : turned(first);
    const FanSector begin = sector;
    do
    {
      visited[findUse(shared, sector.block, sector.edge)] = true;
      fan.sectors.push_back(sector);
    } while (step(sector) && !same(sector, begin));
    fans.push_back(std::move(fan));
  }
  return fans;
}

int VertexStar::faceBetween(int a, int b) const
{
  for (std::size_t i = 0; i < this->faces.size(); ++i)
  {
    const auto& e = this->faces[i].edges;
    if ((e[0] == a && e[1] == b) || (e[0] == b && e[1] == a))
    {
      return static_cast<int>(i);
    }
  }
  return -1;
}

VertexStar vertexStar(const BlockComplex& complex, int vertex)
{
  VertexStar star;
  const std::vector<CornerUse>& corners = complex.vertices[vertex].corners;
  for (std::size_t index = 0; index < corners.size(); ++index)
  {
    const int block = corners[index].block;
    const int corner = corners[index].corner;
    const ComplexBlock& owner = complex.blocks[block];
    const auto pointAt = [&](int di, int dj, int dk) {
      const Ijk steps{ di, dj, dk };
      Ijk ijk;
      for (int d = 0; d < 3; ++d)
      {
        ijk[d] = cornerSide(corner, d) ? owner.cells(d) - steps[d] : steps[d];
      }
      return owner.points.has(ijk) ? owner.points(ijk) : Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
    };
    star.point = pointAt(0, 0, 0);
    VertexStar::Block entry{ block, corner, {}, {}, pointAt(1, 1, 1) };
    for (int d = 0; d < 3; ++d)
    {
      const int blockEdge =
        edgeIndex(d, cornerSide(corner, faceAxis(2 * d, 0)), cornerSide(corner, faceAxis(2 * d, 1)));
      const int edge = owner.edges[blockEdge];
      const int end = cornerSide(corner, d) ^ (owner.edgeReversed[blockEdge] ? 1 : 0);
      auto found = std::find_if(star.edges.begin(), star.edges.end(),
        [&](const VertexStar::Edge& e) { return e.edge == edge && e.end == end; });
      if (found == star.edges.end())
      {
        star.edges.push_back({ edge, end, pointAt(d == 0, d == 1, d == 2), complex.edges[edge].boundary });
        found = star.edges.end() - 1;
      }
      entry.edges[d] = static_cast<int>(found - star.edges.begin());
    }
    for (int d = 0; d < 3; ++d)
    {
      const int blockFace = 2 * d + cornerSide(corner, d);
      const int face = owner.faces[blockFace];
      const ComplexFace& shared = complex.faces[face];
      int s = cornerSide(corner, faceAxis(blockFace, 0));
      int t = cornerSide(corner, faceAxis(blockFace, 1));
      if (shared.uses[0].block != block || shared.uses[0].face != blockFace)
      {
        const auto first = mapFacePoint(inverseOrientation(shared.orientation), s, t, 1, 1);
        s = first[0];
        t = first[1];
      }
      auto found = std::find_if(star.faces.begin(), star.faces.end(),
        [&](const VertexStar::Face& f) { return f.face == face && f.corner == s + 2 * t; });
      if (found == star.faces.end())
      {
        star.faces.push_back(
          { face, s + 2 * t, { entry.edges[faceAxis(blockFace, 0)], entry.edges[faceAxis(blockFace, 1)] }, { -1, -1 },
            pointAt(d != 0, d != 1, d != 2), shared.boundary() });
        found = star.faces.end() - 1;
      }
      entry.faces[d] = static_cast<int>(found - star.faces.begin());
      found->blocks[found->blocks[0] < 0 ? 0 : 1] = static_cast<int>(index);
    }
    star.blocks.push_back(entry);
  }
  return star;
}

BoundaryRing boundaryRing(const VertexStar& star)
{
  std::vector<int> faces;
  std::vector<int> facesAtEdge(star.edges.size(), 0);
  for (int f = 0; f < static_cast<int>(star.faces.size()); ++f)
  {
    if (star.faces[f].boundary)
    {
      faces.push_back(f);
      ++facesAtEdge[star.faces[f].edges[0]];
      ++facesAtEdge[star.faces[f].edges[1]];
    }
  }
  if (faces.empty() ||
    !std::all_of(facesAtEdge.begin(), facesAtEdge.end(), [](int count) { return count == 0 || count == 2; }))
  {
    return {};
  }
  BoundaryRing ring;
  int face = faces.front();
  int edge = star.faces[face].edges[0];
  do
  {
    ring.edges.push_back(edge);
    ring.faces.push_back(face);
    const auto& ends = star.faces[face].edges;
    edge = ends[0] == edge ? ends[1] : ends[0];
    for (const int other : faces)
    {
      if (other != face && (star.faces[other].edges[0] == edge || star.faces[other].edges[1] == edge))
      {
        face = other;
        break;
      }
    }
  } while (edge != ring.edges.front() && ring.edges.size() <= faces.size());
  return ring.faces.size() == faces.size() ? ring : BoundaryRing{};
}

} // namespace bsv
