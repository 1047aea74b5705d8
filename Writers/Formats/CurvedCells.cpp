// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/CurvedCells.h"

#include "Ranks/Ranks.h"
#include "Volume/Sampling.h"

#include <algorithm>

namespace bsv
{

namespace
{

Ijk scaled(const Ijk& corner, int order)
{
  return { corner[0] * order, corner[1] * order, corner[2] * order };
}

/// The nodes inside an edge, from one corner to the other.
void appendEdge(NodeList& nodes, const Ijk& from, const Ijk& to, int order)
{
  for (int n = 1; n < order; ++n)
  {
    Ijk node{};
    for (int d = 0; d < 3; ++d)
    {
      node[d] = from[d] + (to[d] - from[d]) / order * n;
    }
    nodes.push_back(node);
  }
}

/// A quadrilateral with these corners: themselves, then the edges, then what is inside, which is a quadrilateral of
/// order - 2 in the same order; order 0 is one node.
void appendQuad(NodeList& nodes, const std::array<Ijk, 4>& corners, int order)
{
  if (order == 0)
  {
    nodes.push_back(corners[0]);
    return;
  }
  nodes.insert(nodes.end(), corners.begin(), corners.end());
  for (int e = 0; e < 4; ++e)
  {
    appendEdge(nodes, corners[e], corners[(e + 1) % 4], order);
  }
  if (order > 1)
  {
    std::array<Ijk, 4> inside{};
    for (int c = 0; c < 4; ++c)
    {
      for (int d = 0; d < 3; ++d)
      {
        // One step along each edge at the corner.
        inside[c][d] = corners[c][d] + (corners[(c + 1) % 4][d] - corners[c][d]) / order +
          (corners[(c + 3) % 4][d] - corners[c][d]) / order;
      }
    }
    appendQuad(nodes, inside, order - 2);
  }
}

constexpr int GmshEdges[12][2] = { { 0, 1 }, { 0, 3 }, { 0, 4 }, { 1, 2 }, { 1, 5 }, { 2, 3 }, { 2, 6 }, { 3, 7 },
  { 4, 5 }, { 4, 7 }, { 5, 6 }, { 6, 7 } };
constexpr int GmshFaces[6][4] = { { 0, 3, 2, 1 }, { 0, 1, 5, 4 }, { 0, 4, 7, 3 }, { 1, 2, 6, 5 }, { 2, 3, 7, 6 },
  { 4, 5, 6, 7 } };
constexpr int CGNSEdges[12][2] = { { 0, 1 }, { 1, 2 }, { 2, 3 }, { 3, 0 }, { 0, 4 }, { 1, 5 }, { 2, 6 }, { 3, 7 },
  { 4, 5 }, { 5, 6 }, { 6, 7 }, { 7, 4 } };
/// In the order in which the nodes inside the faces are numbered.
constexpr int CGNSFaces[6][4] = { { 0, 1, 2, 3 }, { 0, 1, 5, 4 }, { 1, 2, 6, 5 }, { 2, 3, 7, 6 }, { 3, 0, 4, 7 },
  { 4, 5, 6, 7 } };

/// A hexahedron with its lowest corner at `first` and `order` steps of the lattice along its edges.
void appendHex(NodeList& nodes, NodeOrder kind, const Ijk& first, int order)
{
  if (order == 0)
  {
    nodes.push_back(first);
    return;
  }
  std::array<Ijk, 8> corners{};
  for (int c = 0; c < 8; ++c)
  {
    const Ijk at = scaled(HexCorners[c], order);
    corners[c] = { first[0] + at[0], first[1] + at[1], first[2] + at[2] };
    nodes.push_back(corners[c]);
  }
  const auto& edges = kind == NodeOrder::Gmsh ? GmshEdges : CGNSEdges;
  const auto& faces = kind == NodeOrder::Gmsh ? GmshFaces : CGNSFaces;
  for (const auto& edge : edges)
  {
    appendEdge(nodes, corners[edge[0]], corners[edge[1]], order);
  }
  if (order == 1)
  {
    return;
  }
  for (const auto& face : faces)
  {
    NodeList quad;
    appendQuad(quad, { corners[face[0]], corners[face[1]], corners[face[2]], corners[face[3]] }, order);
    nodes.insert(nodes.end(), quad.begin() + 4 * order, quad.end());
  }
  appendHex(nodes, kind, { first[0] + 1, first[1] + 1, first[2] + 1 }, order - 2);
}

std::vector<Ijk> spansOf(const VolumeToWrite& volume)
{
  std::vector<Ijk> spans;
  for (const BSplineVolume& block : volume.volumes)
  {
    Ijk count{};
    for (int d = 0; d < 3; ++d)
    {
      count[d] = static_cast<int>(nonEmptySpans(block.degree[d], block.knots[d]).size());
    }
    spans.push_back(count);
  }
  return spans;
}

/// Points per direction with `order` of them per span.
std::vector<Ijk> lattice(const VolumeToWrite& volume, int order)
{
  std::vector<Ijk> counts = spansOf(volume);
  for (Ijk& count : counts)
  {
    for (int& n : count)
    {
      n = n * order + 1;
    }
  }
  return counts;
}

/// The interfaces with their ranges in a lattice.
std::vector<Interface> contacts(const VolumeToWrite& volume, int order)
{
  const std::vector<Ijk> spans = spansOf(volume);
  std::vector<Interface> result = volume.interfaces;
  for (Interface& contact : result)
  {
    contact.originB = { 0, 0 };
    contact.rangeA.lo = { 0, 0 };
    for (int axis = 0; axis < 2; ++axis)
    {
      const int axisB = swapsAxes(contact.orientation) ? 1 - axis : axis;
      const int a = spans[contact.blockA][faceAxis(contact.faceA, axis)];
      const int b = spans[contact.blockB][faceAxis(contact.faceB, axisB)];
      if (a != b)
      {
        throw Error(volume.label(contact.blockA) + ", face " + std::to_string(contact.faceA) + " has " +
          std::to_string(a) + " spans, but " + volume.label(contact.blockB) + ", face " +
          std::to_string(contact.faceB) + " that it meets has " + std::to_string(b) +
          ": their cells do not share nodes");
      }
      contact.rangeA.hi[axis] = a * order;
    }
  }
  return result;
}

} // namespace

NodeList cellNodes(NodeOrder kind, int order)
{
  NodeList nodes;
  if (kind != NodeOrder::Lexicographic)
  {
    appendHex(nodes, kind, { 0, 0, 0 }, order);
    return nodes;
  }
  for (int k = 0; k <= order; ++k)
  {
    for (int j = 0; j <= order; ++j)
    {
      for (int i = 0; i <= order; ++i)
      {
        nodes.push_back({ i, j, k });
      }
    }
  }
  return nodes;
}

NodeList sideNodes(int side, int order)
{
  NodeList nodes;
  std::array<Ijk, 4> corners{};
  for (int c = 0; c < 4; ++c)
  {
    corners[c] = scaled(HexCorners[HexSides[side][c]], order);
  }
  appendQuad(nodes, corners, order);
  return nodes;
}

CurvedCells::CurvedCells(const VolumeToWrite& volume, int order, const Execution& run)
  : Volume(volume)
  , Order(order)
  , Spans(spansOf(volume))
  , Numbers(lattice(volume, order), contacts(volume, order), run)
  , SpanNeighbours(lattice(volume, 1), contacts(volume, 1))
{
  this->FirstCell.push_back(0);
  for (int b = 0; b < this->blockCount(); ++b)
  {
    this->FirstCell.push_back(this->FirstCell.back() + this->cellCount(b));
  }
}

Ijk CurvedCells::nodes(int block) const
{
  Ijk counts = this->Spans[block];
  for (int& count : counts)
  {
    count = count * this->Order + 1;
  }
  return counts;
}

Index CurvedCells::cellCount(int block) const
{
  return Index(this->Spans[block][0]) * this->Spans[block][1] * this->Spans[block][2];
}

std::vector<double> CurvedCells::positions(int block, const Execution& run) const
{
  const Ijk counts = this->nodes(block);
  std::vector<double> points(3 * static_cast<std::size_t>(counts[0]) * counts[1] * counts[2]);
  sampleEqually(this->Volume.volumes[block], this->Order, points.data(), run);
  return points;
}

bool CurvedCells::exact(const Ranks& ranks) const
{
  bool inexact = this->Volume.isRational();
  for (const BSplineVolume& block : this->Volume.volumes)
  {
    inexact = inexact || std::any_of(block.degree.begin(), block.degree.end(), [&](int d) { return d > this->Order; });
  }
  return !ranks.any(inexact);
}

} // namespace bsv
