// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/OuterSurface.h"

#include "Complex/EdgeFans.h"

#include <Eigen/Geometry>

#include <algorithm>

namespace bsv
{

Vec3 OuterCell::area() const
{
  return 0.5 * this->sign * (this->corner(3) - this->corner(0)).cross(this->corner(2) - this->corner(1));
}

std::array<Vec3, 3> OuterCell::frame() const
{
  const auto depth = [this](int c) { return Vec3(this->behind(c) - this->corner(c)); };
  return { 0.5 * ((this->corner(1) - this->corner(0)) + (this->corner(3) - this->corner(2))),
    0.5 * ((this->corner(2) - this->corner(0)) + (this->corner(3) - this->corner(1))),
    0.25 * ((depth(0) + depth(3)) + (depth(1) + depth(2))) };
}

OuterSurface::OuterSurface(const BlockComplex& complex)
  : Complex(complex)
  , QuadStart{ 0 }
  , Across(4 * complex.faces.size())
{
  const int faceCount = static_cast<int>(complex.faces.size());
  Index nodes = static_cast<Index>(complex.vertices.size());
  for (const ComplexEdge& edge : complex.edges)
  {
    this->EdgeNodes.push_back(nodes);
    nodes += edge.boundary ? edge.cells - 1 : 0;
  }
  for (int face = 0; face < faceCount; ++face)
  {
    Index quads = 0;
    this->FaceNodes.push_back(nodes);
    if (complex.faces[face].boundary())
    {
      this->Faces.push_back(face);
      const Index ns = this->cells(face, 0), nt = this->cells(face, 1);
      quads = ns * nt;
      nodes += (ns - 1) * (nt - 1);
    }
    this->QuadStart.push_back(this->QuadStart.back() + quads);
  }
  for (int edge = 0; edge < static_cast<int>(complex.edges.size()); ++edge)
  {
    if (!complex.edges[edge].boundary)
    {
      continue;
    }
    for (const EdgeFan& fan : edgeFans(complex, edge))
    {
      if (fan.closed)
      {
        continue;
      }
      std::array<Side, 2> ends;
      for (int end = 0; end < 2; ++end)
      {
        const FanSector& sector = end == 0 ? fan.sectors.front() : fan.sectors.back();
        const int blockFace = sector.spokeFace(end);
        Side& at = ends[end];
        at.face = complex.blocks[sector.block].faces[blockFace];
        at.axis = faceAxis(blockFace, 0) == sector.along ? 0 : 1;
        at.side = faceEdge(blockFace, at.axis, 0) == sector.edge ? 0 : 1;
        at.reversed = sector.reversed;
      }
      const bool reversed = ends[0].reversed != ends[1].reversed;
      ends[0].reversed = ends[1].reversed = reversed;
      this->side(ends[0].face, ends[0].axis, ends[0].side) = ends[1];
      this->side(ends[1].face, ends[1].axis, ends[1].side) = ends[0];
    }
  }
}

OuterQuad OuterSurface::quadAt(Index quad) const
{
  const int face =
    static_cast<int>(std::upper_bound(this->QuadStart.begin(), this->QuadStart.end(), quad) - this->QuadStart.begin()) -
    1;
  const Index at = quad - this->QuadStart[face];
  const int ns = this->cells(face, 0);
  return { face, static_cast<int>(at % ns), static_cast<int>(at / ns) };
}

int OuterSurface::cells(int face, int axis) const
{
  const FaceUse& use = this->use(face);
  return this->Complex.blocks[use.block].cells(faceAxis(use.face, axis));
}

Index OuterSurface::node(int face, int s, int t) const
{
  const FaceUse& use = this->use(face);
  const ComplexBlock& block = this->Complex.blocks[use.block];
  const int n[2] = { this->cells(face, 0), this->cells(face, 1) };
  const bool endS = s == 0 || s == n[0], endT = t == 0 || t == n[1];
  if (endS && endT)
  {
    return block.vertices[faceCorner(use.face, s != 0, t != 0)];
  }
  if (endS || endT)
  {
    const int axis = endT ? 0 : 1;
    const int blockEdge = faceEdge(use.face, axis, (endT ? t : s) != 0);
    const int along = endT ? s : t;
    return this->EdgeNodes[block.edges[blockEdge]] + (block.edgeReversed[blockEdge] ? n[axis] - along : along) - 1;
  }
  return this->FaceNodes[face] + (s - 1) + Index(n[0] - 1) * (t - 1);
}

std::array<Index, 4> OuterSurface::nodes(const OuterQuad& at) const
{
  return { this->node(at.face, at.s, at.t), this->node(at.face, at.s + 1, at.t), this->node(at.face, at.s, at.t + 1),
    this->node(at.face, at.s + 1, at.t + 1) };
}

OuterEdge OuterSurface::across(const OuterEdge& edge) const
{
  OuterEdge other = edge;
  int& across = edge.axis == 0 ? other.quad.t : other.quad.s;
  const int last = this->cells(edge.quad.face, 1 - edge.axis) - 1;
  if (edge.side == 0 ? across > 0 : across < last)
  {
    across += edge.side == 0 ? -1 : 1;
    other.side = 1 - edge.side;
    return other;
  }
  const Side& there = this->side(edge.quad.face, edge.axis, edge.side);
  const int along = edge.axis == 0 ? edge.quad.s : edge.quad.t;
  const int n = this->cells(there.face, there.axis);
  other.axis = there.axis;
  other.side = there.side;
  other.quad.face = there.face;
  (there.axis == 0 ? other.quad.s : other.quad.t) = there.reversed ? n - 1 - along : along;
  (there.axis == 0 ? other.quad.t : other.quad.s) = there.side ? this->cells(there.face, 1 - there.axis) - 1 : 0;
  return other;
}

OuterCell OuterSurface::cell(const OuterQuad& at) const
{
  OuterCell result;
  this->forCells(at, at, [&](const OuterQuad&, const OuterCell& cell) { result = cell; });
  return result;
}

} // namespace bsv
