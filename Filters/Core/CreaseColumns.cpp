// SPDX-License-Identifier: BSD-3-Clause
#include "CreaseColumns.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace bsv
{
namespace
{

/// What the depth above one surface point is measured by.
struct DepthScale
{
  Vec3 area;       ///< vector area of the surface around the point, of either sign
  double rounding; ///< |area . delta|
};

/// Sum that does not depend on the order of the vectors.
Vec3 sortedSum(std::vector<Vec3>& vectors)
{
  Vec3 sum = Vec3::Zero();
  for (int d = 0; d < 3; ++d)
  {
    std::sort(vectors.begin(), vectors.end(), [d](const Vec3& a, const Vec3& b) { return a[d] < b[d]; });
    for (const Vec3& vector : vectors)
    {
      sum[d] += vector[d];
    }
  }
  return sum;
}

/// At a vertex delta is that of the Catmull-Clark limit: (4 sum (e - p) + sum (f - p)) / (n (n + 5)).
DepthScale scaleAtVertex(const BlockComplex& complex, int vertex)
{
  const VertexStar star = vertexStar(complex, vertex);
  std::vector<Vec3> areas, offsets;
  for (const VertexStar::Edge& edge : star.edges)
  {
    if (edge.boundary)
    {
      offsets.push_back(4.0 * (edge.point - star.point));
    }
  }
  double faces = 0.0;
  for (std::size_t f = 0; f < star.faces.size(); ++f)
  {
    const VertexStar::Face& face = star.faces[f];
    if (!face.boundary)
    {
      continue;
    }
    faces += 1.0;
    offsets.push_back(face.point - star.point);
    const auto edgeVector = [&](int e) { return Vec3(star.edges[e].point - star.point); };
    const Vec3 area = edgeVector(face.edges[0]).cross(edgeVector(face.edges[1]));
    // All areas point into the mesh.
    const VertexStar::Block& block = star.blocks[face.blocks[0]];
    for (int d = 0; d < 3; ++d)
    {
      if (block.faces[d] == static_cast<int>(f))
      {
        areas.push_back(area.dot(edgeVector(block.edges[d])) < 0.0 ? Vec3(-area) : area);
      }
    }
  }
  const Vec3 area = sortedSum(areas);
  return { area, std::abs(area.dot(sortedSum(offsets))) / (faces * (faces + 5.0)) };
}

/// The scales at every mesh point of a crease edge. Between its vertices delta is that of the mask [1/6 2/3 1/6].
std::vector<DepthScale> depthScales(const BlockComplex& complex, int edge, const EdgeFan& fan)
{
  const ComplexEdge& shared = complex.edges[edge];
  const FanSector& first = fan.sectors.front();
  const FanSector& last = fan.sectors.back();
  const ComplexBlock& firstOwner = complex.blocks[first.block];
  const ComplexBlock& lastOwner = complex.blocks[last.block];
  std::vector<DepthScale> scales(shared.cells + 1);
  for (int k = 1; k < shared.cells; ++k)
  {
    const auto pointAt = [&](int layer) { return firstOwner.points(first.point(firstOwner, layer, 0, 0)); };
    const Vec3 left = firstOwner.points(first.point(firstOwner, k, 1, 0));
    const Vec3 right = lastOwner.points(last.point(lastOwner, k, 0, 1));
    scales[k].area = (left - right).cross(pointAt(k + 1) - pointAt(k - 1));
    scales[k].rounding = std::abs(scales[k].area.dot((left + right) - 2.0 * pointAt(k))) / 6.0;
  }
  scales.front() = scaleAtVertex(complex, shared.vertices[0]);
  scales.back() = scaleAtVertex(complex, shared.vertices[1]);
  return scales;
}

/// A block face seen from the edge at its foot: mesh lines m rise from the edge through points k = 0, 1, ...
struct Column
{
  int block;
  int face;
  int edge;     ///< block edge at the foot
  bool against; ///< the block edge runs against m

  int axis() const { return faceAxis(this->face, 0) == edgeDirection(this->edge) ? 0 : 1; }
  int side() const { return faceEdge(this->face, this->axis(), 0) == this->edge ? 0 : 1; }
};

} // namespace

void markCreaseColumns(const BlockComplex& complex, double range, EntityRules& rules)
{
  if (range <= 0.0)
  {
    return;
  }
  for (std::size_t e = 0; e < complex.edges.size(); ++e)
  {
    const EdgeRule& foot = rules.edges[e];
    if (!foot.feature || foot.rule != ControlPointRule::Crease || foot.fans.size() != 1 ||
      foot.fans.front().sectors.size() != 2)
    {
      continue;
    }
    const int lines = complex.edges[e].cells + 1;
    const std::vector<DepthScale> scales = depthScales(complex, static_cast<int>(e), foot.fans.front());
    const FanSector& start = foot.fans.front().sectors[1];
    std::vector<Vec3> feet;
    for (int m = 0; m < lines; ++m)
    {
      const ComplexBlock& owner = complex.blocks[start.block];
      feet.push_back(owner.points(start.point(owner, m, 0, 0)));
    }
    Column column{ start.block, start.spokeFace(0), start.edge, start.reversed };
    // Every face once at the most: a ring of faces of no extent would have no end.
    for (std::size_t steps = 0; steps < complex.faces.size(); ++steps)
    {
      const ComplexBlock& owner = complex.blocks[column.block];
      const Ijk cells{ owner.cells(0), owner.cells(1), owner.cells(2) };
      const int rise = cells[faceAxis(column.face, 1 - column.axis())];
      FaceRule& rule = rules.faces[owner.faces[column.face]];
      rule.keep.resize(std::size_t(lines) * (rise + 1), 0.0);
      bool reaches = false;
      for (int m = 0; m < lines; ++m)
      {
        const int along = column.against ? lines - 1 - m : m;
        const auto pointAt = [&](int k) {
          const int up = column.side() == 0 ? k : rise - k;
          return column.axis() == 0 ? std::array<int, 2>{ along, up } : std::array<int, 2>{ up, along };
        };
        for (int k = 0; k <= rise; ++k)
        {
          const std::array<int, 2> st = pointAt(k);
          const Vec3 here = owner.points(facePoint(cells, column.face, st[0], st[1]));
          const double depth = std::abs(scales[m].area.dot(here - feet[m]));
          const double reach = range * scales[m].rounding;
          const double weight = depth < reach ? 1.0 - depth / reach : 0.0;
          double& keep = rule.keep[keepIndex(complex, column.block, column.face, st[0], st[1])];
          keep = std::max(keep, weight);
          reaches = reaches || (k == rise && weight > 0.0);
        }
      }
      // On through the edge at the top, if four blocks meet there like one grid.
      const int topEdge = faceEdge(column.face, column.axis(), 1 - column.side());
      const EdgeRule& top = rules.edges[owner.edges[topEdge]];
      if (!reaches || !top.regular())
      {
        break;
      }
      const EdgeFan& fan = top.fans.front();
      int spoke = 0;
      while (fan.sectors[spoke].block != column.block || fan.sectors[spoke].edge != topEdge)
      {
        ++spoke;
      }
      const bool topAgainst = column.against != fan.sectors[spoke].reversed;
      if (fan.sectors[spoke].spokeFace(0) != column.face)
      {
        spoke = (spoke + 1) % 4;
      }
      const FanSector& next = fan.sectors[(spoke + 2) % 4];
      column = { next.block, next.spokeFace(0), next.edge, topAgainst != next.reversed };
    }
  }
}

} // namespace bsv
