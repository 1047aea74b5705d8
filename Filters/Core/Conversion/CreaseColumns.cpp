// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/CreaseColumns.h"

#include "Base/Numbers.h"
#include "Conversion/LayerRules.h"
#include "Ranks/OwnedValues.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

namespace bsv
{
namespace
{

/// What one boundary quadrilateral at a point of a crease says about depths above the point.
struct Foot
{
  int line; ///< of the crease's mesh points
  Triple point;
  Triple area;     ///< of the quadrilateral, of either sign
  double rounding; ///< |area . delta| or what else says how deep the rounding is, not 0
  double keep;     ///< of the point itself
};

void addFoot(std::vector<Foot>& feet, int line, const Vec3& x, const Vec3& area, double rounding, double keep = 1.0)
{
  if (rounding != 0.0)
  {
    feet.push_back({ line, { x[0], x[1], x[2] }, { area[0], area[1], area[2] }, std::abs(rounding), keep });
  }
}

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
void addVertexFeet(std::vector<Foot>& feet, const BlockComplex& complex, int vertex, int line)
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
  for (const VertexStar::Face& face : star.faces)
  {
    if (face.boundary)
    {
      offsets.push_back(face.point - star.point);
      const Vec3 first = star.edges[face.edges[0]].point - star.point;
      areas.push_back(first.cross(star.edges[face.edges[1]].point - star.point));
    }
  }
  const double n = static_cast<double>(areas.size());
  const Vec3 delta = sortedSum(offsets) / (n * (n + 5.0));
  for (const Vec3& area : areas)
  {
    addFoot(feet, line, star.point, area, area.dot(delta));
  }
}

/// Of mesh point k of an edge, for the column of a spoke. Delta is that of the mask [1/6 2/3 1/6] from the spoke before
/// to the one behind.
void addSpokeFeet(
  std::vector<Foot>& feet, const BlockComplex& complex, int edge, const EdgeFan& fan, int spoke, int k, double keep)
{
  const int cells = complex.edges[edge].cells;
  const int count = fan.spokeCount();
  const auto pointAt = [&](int i, int layer, int step) {
    const auto [sector, which] = fan.spoke(i);
    const ComplexBlock& owner = complex.blocks[sector->block];
    return owner.points(sector->point(owner, layer, which == 0 ? step : 0, which == 0 ? 0 : step));
  };
  const std::array<int, 2> beside{ (spoke + count - 1) % count, (spoke + 1) % count };
  const Vec3 x = pointAt(0, k, 0);
  const Vec3 up = pointAt(spoke, k, 1) - x;
  const Vec3 along = pointAt(0, std::min(k + 1, cells), 0) - pointAt(0, std::max(k - 1, 0), 0);
  const Vec3 delta = ((pointAt(beside[0], k, 1) + pointAt(beside[1], k, 1)) - 2.0 * x) / 6.0;
  for (const int other : beside)
  {
    const Vec3 area = (pointAt(other, k, 1) - x).cross(along);
    addFoot(feet, k, x, area, area.dot(delta), keep);
    if (fan.closed || (other != 0 && other != count - 1))
    {
      addFoot(feet, k, x, area, up.cross(along).dot(delta), keep);
    }
  }
}

/// Of all mesh points of a crease edge, for the column of an inner spoke.
std::vector<Foot> feetOfCrease(const BlockComplex& complex, int edge, const EdgeFan& fan, int spoke)
{
  const ComplexEdge& shared = complex.edges[edge];
  std::vector<Foot> feet;
  addVertexFeet(feet, complex, shared.vertices[0], 0);
  addVertexFeet(feet, complex, shared.vertices[1], shared.cells);
  // Between two blocks the vertices have said all about the ends.
  const int end = fan.spokeCount() == 3 ? 1 : 0;
  for (int k = end; k <= shared.cells - end; ++k)
  {
    addSpokeFeet(feet, complex, edge, fan, spoke, k, 1.0);
  }
  return feet;
}

/// Of the mesh points of an inner edge that columns from several sides keep, for the column of a spoke.
std::vector<Foot> feetOfMeeting(
  const BlockComplex& complex, const FaceKeeps& keeps, int edge, const EdgeFan& fan, int spoke)
{
  // The outer boundary has rules of its own.
  const ComplexEdge& shared = complex.edges[edge];
  const int first = complex.vertices[shared.vertices[0]].boundary ? 1 : 0;
  const int last = shared.cells - (complex.vertices[shared.vertices[1]].boundary ? 1 : 0);
  std::vector<Foot> feet;
  for (int k = first; k <= last; ++k)
  {
    std::vector<bool> kept;
    double keep = 0.0;
    for (int i = 0; i < fan.spokeCount(); ++i)
    {
      const FanSector& sector = fan.sectors[i];
      const ComplexBlock& owner = complex.blocks[sector.block];
      const int face = sector.spokeFace(0);
      const std::vector<double>& values = keeps[owner.faces[face]];
      const auto at = [&](int step) {
        const Ijk ijk = sector.point(owner, k, step, 0);
        return values.empty()
          ? 0.0
          : values[keepIndex(complex, sector.block, face, ijk[faceAxis(face, 0)], ijk[faceAxis(face, 1)])];
      };
      kept.push_back(at(0) > 0.0 || at(1) > 0.0);
      keep = std::max(keep, at(0));
    }
    if (keep > 0.0 && keptLinesMeet(true, kept))
    {
      addSpokeFeet(feet, complex, edge, fan, spoke, k, keep);
    }
  }
  return feet;
}

/// A block face seen from the edge at its foot: mesh lines m rise from the edge through points k = 0, 1, ...
struct Column
{
  const std::vector<Foot>* feet; ///< of the crease where it starts
  int block;
  int face;
  int edge;     ///< block edge at the foot
  bool against; ///< the block edge runs against m

  int axis() const { return faceAxis(this->face, 0) == edgeDirection(this->edge) ? 0 : 1; }
  int side() const { return faceEdge(this->face, this->axis(), 0) == this->edge ? 0 : 1; }
  int topEdge() const { return faceEdge(this->face, this->axis(), 1 - this->side()); }
};

/// Enlarges `keeps` of the column's face at the points that are known here.
/// @return whether the weight has not faded out at the top.
bool fillColumn(const BlockComplex& complex, const Column& column, double range, FaceKeeps& keeps)
{
  const ComplexBlock& owner = complex.blocks[column.block];
  if (owner.points.isElsewhere())
  {
    return false;
  }
  const Ijk cells{ owner.cells(0), owner.cells(1), owner.cells(2) };
  const int last = cells[faceAxis(column.face, column.axis())];
  const int rise = cells[faceAxis(column.face, 1 - column.axis())];
  std::vector<double>& values = keeps[owner.faces[column.face]];
  values.resize(std::size_t(last + 1) * (rise + 1), 0.0);
  bool reaches = false;
  for (const Foot& foot : *column.feet)
  {
    const double reach = range * foot.rounding;
    const int along = column.against ? last - foot.line : foot.line;
    for (int k = 0; k <= rise; ++k)
    {
      const int up = column.side() == 0 ? k : rise - k;
      const int s = column.axis() == 0 ? along : up;
      const int t = column.axis() == 0 ? up : along;
      const Ijk ijk = facePoint(cells, column.face, s, t);
      if (!owner.points.has(ijk))
      {
        continue;
      }
      const Vec3 offset = owner.points(ijk) - Vec3(foot.point.data());
      const double depth = std::abs(Vec3(foot.area.data()).dot(offset));
      const double weight = depth < reach ? foot.keep * (1.0 - depth / reach) : 0.0;
      double& keep = values[keepIndex(complex, column.block, column.face, s, t)];
      keep = std::max(keep, weight);
      reaches = reaches || (k == rise && weight > 0.0);
    }
  }
  return reaches;
}

/// The face that continues a column through the edge at its top, at which four blocks meet like in one grid.
Column nextColumn(const Column& column, const EdgeFan& top)
{
  int spoke = 0;
  while (top.sectors[spoke].block != column.block || top.sectors[spoke].edge != column.topEdge())
  {
    ++spoke;
  }
  const bool against = column.against != top.sectors[spoke].reversed;
  if (top.sectors[spoke].spokeFace(0) != column.face)
  {
    spoke = (spoke + 1) % 4;
  }
  const FanSector& next = top.sectors[(spoke + 2) % 4];
  return { column.feet, next.block, next.spokeFace(0), next.edge, against != next.reversed };
}

} // namespace

std::size_t keepIndex(const BlockComplex& complex, int block, int face, int s, int t)
{
  const ComplexFace& shared = complex.faces[complex.blocks[block].faces[face]];
  const FaceUse& first = shared.uses.front();
  const ComplexBlock& owner = complex.blocks[block];
  int ns = owner.cells(faceAxis(face, 0));
  if (first.block != block || first.face != face)
  {
    const int orientation = inverseOrientation(shared.orientation);
    const std::array<int, 2> st = mapFacePoint(orientation, s, t, ns, owner.cells(faceAxis(face, 1)));
    s = st[0];
    t = st[1];
    ns = complex.blocks[first.block].cells(faceAxis(first.face, 0));
  }
  return s + std::size_t(ns + 1) * t;
}

FaceKeeps creaseColumns(
  const BlockComplex& complex, double propagationRange, const EntityRules& rules, const Ranks& ranks)
{
  FaceKeeps keeps(complex.faces.size());
  if (propagationRange <= 0.0)
  {
    return keeps;
  }
  // The default, 8, reaches four depths: where the cells of both sides are alike, two thirds of a cell.
  const double range = 0.5 * propagationRange;
  // The spokes of edges at which columns start.
  struct Start
  {
    int edge;
    int spoke;
  };
  std::set<int> filled;
  const auto rise = [&](const std::vector<Start>& starts, const auto& feetOf) {
    const auto fanOf = [&](std::size_t i) -> const EdgeFan& { return rules.edges[starts[i].edge].fans.front(); };
    const std::vector<std::vector<Foot>> feet = gatherListsFromOwners<Foot>(
      ranks, starts.size(), [&](std::size_t i) { return complex.blocks[fanOf(i).sectors.front().block].rank; },
      [&](std::size_t i) { return feetOf(starts[i].edge, fanOf(i), starts[i].spoke); });
    std::vector<Column> columns;
    for (std::size_t i = 0; i < starts.size(); ++i)
    {
      const FanSector& start = fanOf(i).sectors[starts[i].spoke];
      if (!feet[i].empty())
      {
        columns.push_back({ &feet[i], start.block, start.spokeFace(0), start.edge, start.reversed });
      }
    }
    // All columns rise by one face at a time; each has every face once at the most: a ring of faces of no extent would
    // have no end.
    for (std::size_t steps = 0; steps < complex.faces.size() && !columns.empty(); ++steps)
    {
      std::vector<char> fills;
      for (const Column& column : columns)
      {
        fills.push_back(fillColumn(complex, column, range, keeps));
        filled.insert(complex.blocks[column.block].faces[column.face]);
      }
      const std::vector<char> reaches = gatherFromOwners<char>(
        ranks, columns.size(), [&](std::size_t i) { return complex.blocks[columns[i].block].rank; },
        [&](std::size_t i) { return fills[i]; });
      std::vector<Column> next;
      for (std::size_t i = 0; i < columns.size(); ++i)
      {
        const EdgeRule& top = rules.edges[complex.blocks[columns[i].block].edges[columns[i].topEdge()]];
        if (reaches[i] && top.regular())
        {
          next.push_back(nextColumn(columns[i], top.fans.front()));
        }
      }
      columns = std::move(next);
    }
  };

  std::vector<Start> starts;
  for (std::size_t e = 0; e < complex.edges.size(); ++e)
  {
    const EdgeRule& foot = rules.edges[e];
    if (foot.feature && foot.rule == ControlPointRule::Crease && foot.fans.size() == 1)
    {
      for (int spoke = 1; spoke + 1 < foot.fans.front().spokeCount(); ++spoke)
      {
        starts.push_back({ static_cast<int>(e), spoke });
      }
    }
  }
  rise(starts, [&](int edge, const EdgeFan& fan, int spoke) { return feetOfCrease(complex, edge, fan, spoke); });

  starts.clear();
  for (std::size_t e = 0; e < complex.edges.size() && !filled.empty(); ++e)
  {
    const EdgeRule& rule = rules.edges[e];
    int count = 0;
    for (int spoke = 0; !complex.edges[e].boundary && !rule.anchored && spoke < rule.fans.front().spokeCount(); ++spoke)
    {
      count += filled.count(rule.fans.front().faceOf(complex, spoke)) > 0 ? 1 : 0;
    }
    for (int spoke = 0; count > 1 && spoke < rule.fans.front().spokeCount(); ++spoke)
    {
      starts.push_back({ static_cast<int>(e), spoke });
    }
  }
  // All from what the creases keep: the order does not matter.
  const FaceKeeps fromCreases = keeps;
  rise(starts,
    [&](int edge, const EdgeFan& fan, int spoke) { return feetOfMeeting(complex, fromCreases, edge, fan, spoke); });
  return keeps;
}

} // namespace bsv
