// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/Star.h"

#include "Base/CanonicalOrder.h"
#include "Base/OrderFreeSum.h"
#include "Conversion/EdgeConversion.h"

#include <algorithm>

namespace bsv
{

namespace
{

/// Mesh point of a block next to its corner: a step along each direction whose bit is set in `steps`.
Ijk cornerPoint(const ComplexBlock& owner, int corner, int steps)
{
  Ijk point;
  for (int d = 0; d < 3; ++d)
  {
    const int step = steps >> d & 1;
    point[d] = cornerSide(corner, d) ? owner.cells(d) - step : step;
  }
  return point;
}

/// Points of the star as ConversionContext::moved has them.
void takeMovedPoints(const ConversionContext& context, Star& star)
{
  for (const VertexStar::Edge& edge : star.edges)
  {
    star.meshEdges.push_back(edge.point);
  }
  for (VertexStar::Block& block : star.blocks)
  {
    const ComplexBlock& owner = context.complex.blocks[block.block];
    const auto take = [&](Vec3& point, int steps) {
      const Ijk ijk = cornerPoint(owner, block.corner, steps);
      if (owner.points.has(ijk))
      {
        point = context.point(block.block, ijk);
      }
    };
    take(star.point, 0);
    take(block.point, 7);
    for (int d = 0; d < 3; ++d)
    {
      take(star.edges[block.edges[d]].point, 1 << d);
      take(star.faces[block.faces[d]].point, 7 & ~(1 << d));
    }
  }
}

/// Moves points of faces and blocks as controlFan() does.
void adjustStar(const ConversionContext& context, Star& star)
{
  // The points as they are: those of faces and blocks are moved by what they have to others.
  const std::vector<VertexStar::Face> faces = star.faces;
  for (VertexStar::Block& block : star.blocks)
  {
    const ComplexBlock& owner = context.complex.blocks[block.block];
    const Ijk center = cornerPoint(owner, block.corner, 0);
    // Ratio of (1 - c) of the line along d, `steps` away from the vertex in the other directions.
    const auto ratio = [&](int d, int steps) {
      return layerRatio(
        context, block.block, 2 * d + cornerSide(block.corner, d), cornerPoint(owner, block.corner, steps), center);
    };
    std::array<Vec3, 3> offsets;
    for (int d = 0; d < 3; ++d)
    {
      offsets[d] = (ratio(d, 7 & ~(1 << d)) - 1.0) * (block.point - faces[block.faces[d]].point);
      const int a = (d + 1) % 3, b = (d + 2) % 3;
      const double ra = ratio(a, 1 << b), rb = ratio(b, 1 << a);
      if (ra != 1.0 || rb != 1.0)
      {
        const Vec3& point = faces[block.faces[d]].point;
        const Vec3 offset = (ra - 1.0) * (point - star.edges[block.edges[b]].point) +
          (rb - 1.0) * (point - star.edges[block.edges[a]].point);
        star.faces[block.faces[d]].point = point + offset;
      }
    }
    OrderFreeSum sum;
    for (const Vec3& offset : offsets)
    {
      sum.add(1.0, offset);
    }
    block.point += 3.0 * sum.result(3.0);
  }
}

} // namespace

bool Star::keptFacesMeet() const
{
  for (std::size_t e = 0; e < this->edges.size(); ++e)
  {
    std::vector<bool> kept;
    for (const int spoke : this->info[e].spokes)
    {
      kept.push_back(false);
      for (std::size_t f = 0; f < this->faces.size(); ++f)
      {
        const auto& ends = this->faces[f].edges;
        kept.back() =
          kept.back() || (this->keptFaces[f] && std::minmax(ends[0], ends[1]) == std::minmax<int>(e, spoke));
      }
    }
    if (keptLinesMeet(this->info[e].fan->closed, kept))
    {
      return true;
    }
  }
  return false;
}

Star makeStar(const ConversionContext& context, int vertex)
{
  Star star;
  static_cast<VertexStar&>(star) = vertexStar(context.complex, vertex);
  star.vertex = vertex;
  if (context.moved)
  {
    takeMovedPoints(context, star);
  }
  star.boundary = context.complex.vertices[vertex].boundary;
  star.center = star.point;
  const std::size_t edges = star.edges.size();
  star.near.assign(edges, KnotInsertion);
  star.info.resize(edges);
  star.edgePoints.resize(edges);
  star.edgeRules.resize(edges);
  star.facePoints.resize(star.faces.size());
  star.faceRules.resize(star.faces.size());
  star.blockPoints.resize(star.blocks.size());
  star.blockRules.resize(star.blocks.size());
  for (const VertexStar::Block& block : star.blocks)
  {
    for (int d = 0; d < 3; ++d)
    {
      // The line along d leaves the block's face normal to d.
      const ComplexBlock& owner = context.complex.blocks[block.block];
      const Ijk corner = cornerPoint(owner, block.corner, 0);
      const double own = context.layer.weight(block.block, 2 * d + cornerSide(block.corner, d), corner);
      double& near = star.near[block.edges[d]];
      near = own == KnotInsertion ? near : near == KnotInsertion ? own : std::max(near, own);
    }
  }
  adjustStar(context, star);
  star.connection = std::any_of(star.faces.begin(), star.faces.end(),
    [&](const VertexStar::Face& face) { return context.rules.faces[face.face].connection; });
  star.keptFaces.assign(star.faces.size(), false);
  star.diagonalKeep.assign(star.faces.size(), 0.0);
  for (const VertexStar::Block& block : star.blocks)
  {
    const ComplexBlock& owner = context.complex.blocks[block.block];
    for (int d = 0; d < 3; ++d)
    {
      const int face = 2 * d + cornerSide(block.corner, d);
      for (int steps = 0; steps < 8; ++steps)
      {
        const double keep = keepAt(context, block.block, face, cornerPoint(owner, block.corner, steps & ~(1 << d)));
        star.keptFaces[block.faces[d]] = star.keptFaces[block.faces[d]] || keep > 0.0;
        if ((steps | 1 << d) == 7)
        {
          star.diagonalKeep[block.faces[d]] = keep;
        }
      }
    }
  }
  for (std::size_t e = 0; e < edges; ++e)
  {
    const std::vector<EdgeFan>& fans = context.rules.edges[star.edges[e].edge].fans;
    Star::EdgeInfo& info = star.info[e];
    info.fan = &fans.front();
    info.whole = fans.size() == 1;
    for (const FanSector& sector : info.fan->sectors)
    {
      // The corner of the sector's block at this end of the edge.
      const int corner = sector.corner(star.edges[e].end);
      int index = 0;
      while (star.blocks[index].block != sector.block || star.blocks[index].corner != corner)
      {
        ++index;
      }
      info.sectors.push_back(index);
      info.spokes.push_back(star.blocks[index].edges[sector.first]);
    }
    if (!info.fan->closed)
    {
      info.spokes.push_back(star.blocks[info.sectors.back()].edges[info.fan->sectors.back().second]);
    }
  }
  return star;
}

Fan starLayer(const ConversionContext& context, const Star& star, int starEdge, int k)
{
  const VertexStar::Edge& edge = star.edges[starEdge];
  const int cells = context.complex.edges[edge.edge].cells;
  return edge.end == 0
    ? controlFan(context, edge.edge, *star.info[starEdge].fan, k, k - 1)
    : controlFan(context, edge.edge, *star.info[starEdge].fan, cells - k, k > 0 ? cells - k + 1 : -1);
}

bool areStacked(const ConversionContext& context, const Star& star, int up, int down)
{
  const EdgeRule& upRule = context.rules.edges[star.edges[up].edge];
  const EdgeRule& downRule = context.rules.edges[star.edges[down].edge];
  const Star::EdgeInfo& a = star.info[up];
  const Star::EdgeInfo& b = star.info[down];
  if (star.faceBetween(up, down) >= 0 || !a.whole || !b.whole || a.spokes.size() != b.spokes.size() ||
    a.sectors.size() + b.sectors.size() != star.blocks.size() || a.fan->closed != b.fan->closed ||
    upRule.anchored != downRule.anchored || upRule.rule != downRule.rule)
  {
    return false;
  }
  for (const int spoke : a.spokes)
  {
    if (std::find(b.spokes.begin(), b.spokes.end(), spoke) == b.spokes.end())
    {
      return false;
    }
  }
  for (std::size_t i = 0; i < a.sectors.size(); ++i)
  {
    // The face between the stacks: the mask across the layers must not be one that keeps points.
    const int ring = star.blocks[a.sectors[i]].faces[a.fan->sectors[i].along];
    const auto& pair = star.faces[ring].blocks;
    const int across = pair[0] == a.sectors[i] ? pair[1] : pair[0];
    if (star.keptFaces[ring] || context.rules.faces[star.faces[ring].face].connection ||
      std::find(b.sectors.begin(), b.sectors.end(), across) == b.sectors.end())
    {
      return false;
    }
  }
  // On the boundary the outer surface must agree: it is smooth, or its crease is the axis.
  const bool isCrease =
    (star.crease[0] == up && star.crease[1] == down) || (star.crease[0] == down && star.crease[1] == up);
  return !star.boundary || (upRule.feature ? isCrease : star.surfaceIsSmooth);
}

StackAxes stackAxes(const ConversionContext& context, const Star& star)
{
  StackAxes axes;
  const int edges = static_cast<int>(star.edges.size());
  const int blocks = static_cast<int>(star.blocks.size());
  // At the boundary: one stack around an interior edge that all blocks share.
  for (int e = 0; e < edges && axes.up < 0; ++e)
  {
    const Star::EdgeInfo& info = star.info[e];
    if (star.boundary && !star.edges[e].boundary && info.whole && static_cast<int>(info.sectors.size()) == blocks)
    {
      axes.up = e;
    }
  }
  // Otherwise two stacks of the same blocks around two edges without a common face, of the same kind. Where several
  // axes will do, the one with the smallest point is taken, whatever the numbering.
  const auto before = [&](int a, int b) {
    const Vec3& p = star.meshEdges.empty() ? star.edges[a].point : star.meshEdges[a];
    const Vec3& q = star.meshEdges.empty() ? star.edges[b].point : star.meshEdges[b];
    return comesBefore(p, q);
  };
  const bool single = axes.up >= 0;
  for (int e = 0; e < edges && !single; ++e)
  {
    for (int other = 0; other < edges; ++other)
    {
      if (other != e && (axes.up < 0 || before(e, axes.up)) && areStacked(context, star, e, other))
      {
        axes = { e, other };
      }
    }
  }
  return axes;
}

} // namespace bsv
