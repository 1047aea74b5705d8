// SPDX-License-Identifier: BSD-3-Clause
#include "Wall/LimitRows.h"

#include "Complex/EdgeFans.h"

#include <algorithm>

namespace bsv
{

LimitRows::LimitRows(const BlockComplex& complex, const EntityRules& rules, const Wall& wall)
  : Rows(wall.size())
{
  for (const int f : wall.faces())
  {
    this->addFace(complex, wall, f);
  }
  for (const int e : wall.edges())
  {
    this->addEdge(complex, rules, wall, e);
  }
  for (int v = 0; v < static_cast<int>(complex.vertices.size()); ++v)
  {
    if (wall.vertexId(v) >= 0)
    {
      this->addVertex(complex, rules, wall, v);
    }
  }
}

const std::vector<Index>& LimitRows::ring(Index id) const
{
  static const std::vector<Index> none;
  const Row& row = this->Rows[id];
  return row.kind == Kind::Ring && row.next != 4 ? row.points : none;
}

Vec3 LimitRows::apply(Index id, const std::vector<Vec3>& x) const
{
  const Row& row = this->Rows[id];
  const auto at = [&](std::size_t i) -> const Vec3& { return x[row.points[i]]; };
  switch (row.kind)
  {
    case Kind::Kept:
      return x[id];
    case Kind::Curve:
      return ((at(0) + at(1)) + 4.0 * x[id]) / 6.0;
    case Kind::Tensor:
      // Opposite points are added first: turning or reflecting the rectangle changes no bit.
      return (16.0 * x[id] + (4.0 * ((at(0) + at(1)) + (at(2) + at(3))) + ((at(4) + at(5)) + (at(6) + at(7))))) / 36.0;
    default: {
      const double n = 0.5 * static_cast<double>(row.points.size());
      OrderFreeSum sum;
      sum.add(n * n, x[id]);
      for (std::size_t i = 0; i < row.points.size(); ++i)
      {
        sum.add(2 * i < row.points.size() ? 4.0 : 1.0, at(i));
      }
      return sum.result(n * (n + 5.0));
    }
  }
}

Vec3 LimitRows::across(Index id, const std::vector<Vec3>& x) const
{
  const Row& row = this->Rows[id];
  return row.kind == Kind::Tensor ? smoothMask(x[row.points[2]], x[id], x[row.points[3]]) : x[id];
}

std::array<Index, 2> LimitRows::beside(const Row& row, Index spoke)
{
  const std::size_t n = row.next;
  const std::size_t i = std::find(row.points.begin(), row.points.begin() + n, spoke) - row.points.begin();
  return { row.points[(i + n - 1) % n], row.points[(i + 1) % n] };
}

bool LimitRows::leavesCrease(const Row& row, Index spoke)
{
  return row.kind == Kind::Curve && std::find(row.points.begin(), row.points.end(), spoke) == row.points.end();
}

Vec3 LimitRows::acrossSpoke(Index id, Index spoke, const std::vector<Vec3>& x) const
{
  const Row& row = this->Rows[id];
  if (row.kind == Kind::Ring)
  {
    const auto [before, after] = beside(row, spoke);
    return smoothMask(x[before], x[id], x[after]);
  }
  // On a crease the vertex itself; from a crease into a smooth side the curve.
  return leavesCrease(row, spoke) ? this->apply(id, x) : x[id];
}

void LimitRows::forWeights(Index id, const VisitWeight& visit) const
{
  const Row& row = this->Rows[id];
  // Of the next points, of the diagonal ones, and the sum.
  double next = 0.0, diagonal = 0.0, own = 1.0, sum = 1.0;
  const double n = 0.5 * static_cast<double>(row.points.size());
  switch (row.kind)
  {
    case Kind::Kept:
      break;
    case Kind::Curve:
      next = 1.0, own = 4.0, sum = 6.0;
      break;
    case Kind::Tensor:
    case Kind::Ring:
      next = 4.0, diagonal = 1.0, own = n * n, sum = n * (n + 5.0);
      break;
  }
  visit(id, own / sum);
  for (std::size_t i = 0; i < row.points.size() && own != sum; ++i)
  {
    visit(row.points[i], (i < row.next ? next : diagonal) / sum);
  }
}

void LimitRows::forWeightsAcross(Index id, const VisitWeight& visit) const
{
  const Row& row = this->Rows[id];
  const bool tensor = row.kind == Kind::Tensor;
  visit(id, tensor ? 2.0 / 3.0 : 1.0);
  for (std::size_t i = 2; i < 4 && tensor; ++i)
  {
    visit(row.points[i], 1.0 / 6.0);
  }
}

void LimitRows::forWeightsAcrossSpoke(Index id, Index spoke, const VisitWeight& visit) const
{
  const Row& row = this->Rows[id];
  if (leavesCrease(row, spoke))
  {
    this->forWeights(id, visit);
    return;
  }
  visit(id, row.kind == Kind::Ring ? 2.0 / 3.0 : 1.0);
  if (row.kind == Kind::Ring)
  {
    for (const Index point : beside(row, spoke))
    {
      visit(point, 1.0 / 6.0);
    }
  }
}

double LimitRows::spacing(Index id, const std::vector<Vec3>& x) const
{
  const Row& row = this->Rows[id];
  std::vector<double> lengths;
  for (std::size_t i = 0; i < row.next; ++i)
  {
    lengths.push_back((x[row.points[i]] - x[id]).norm());
  }
  std::sort(lengths.begin(), lengths.end());
  double sum = 0.0;
  for (const double length : lengths)
  {
    sum += length;
  }
  return sum / static_cast<double>(row.next);
}

void LimitRows::addFace(const BlockComplex& complex, const Wall& wall, int f)
{
  const FaceUse& use = complex.faces[f].uses.front();
  const ComplexBlock& owner = complex.blocks[use.block];
  const auto id = [&](int s, int t) { return wall.id(use.block, use.face, s, t); };
  for (int t = 1; t < owner.cells(faceAxis(use.face, 1)); ++t)
  {
    for (int s = 1; s < owner.cells(faceAxis(use.face, 0)); ++s)
    {
      this->Rows[id(s, t)] = { Kind::Tensor, 4,
        { id(s - 1, t), id(s + 1, t), id(s, t - 1), id(s, t + 1), id(s - 1, t - 1), id(s + 1, t + 1), id(s - 1, t + 1),
          id(s + 1, t - 1) } };
    }
  }
}

void LimitRows::addEdge(const BlockComplex& complex, const EntityRules& rules, const Wall& wall, int e)
{
  const ComplexEdge& edge = complex.edges[e];
  const EdgeRule& rule = rules.edges[e];
  for (int k = 1; k < edge.cells; ++k)
  {
    Row& row = this->Rows[wall.edgeId(e, k)];
    const Index before = wall.edgeId(e, k - 1), after = wall.edgeId(e, k + 1);
    if (rule.feature)
    {
      row = { Kind::Curve, 2, { before, after } };
      continue;
    }
    // Smooth: the wall goes on at both ends of the fan of blocks.
    const EdgeFan& fan = rule.fans.front();
    const auto beside = [&](int spoke, int layer) {
      const auto [sector, which] = fan.spoke(spoke);
      const ComplexBlock& owner = complex.blocks[sector->block];
      const Ijk ijk = sector->point(owner, layer, which == 0 ? 1 : 0, which == 0 ? 0 : 1);
      return wall.id(sector->block, sector->spokeFace(which), ijk);
    };
    const int last = fan.spokeCount() - 1;
    row = { Kind::Tensor, 4,
      { before, after, beside(0, k), beside(last, k), beside(0, k - 1), beside(last, k + 1), beside(0, k + 1),
        beside(last, k - 1) } };
  }
}

void LimitRows::addVertex(const BlockComplex& complex, const EntityRules& rules, const Wall& wall, int v)
{
  Row& row = this->Rows[wall.vertexId(v)];
  const VertexStar star = vertexStar(complex, v);
  const BoundaryRing ring = boundaryRing(star);
  const int n = static_cast<int>(ring.edges.size());
  const auto next = [&](int starEdge) {
    const VertexStar::Edge& edge = star.edges[starEdge];
    return wall.edgeId(edge.edge, edge.end == 0 ? 1 : complex.edges[edge.edge].cells - 1);
  };
  std::vector<int> features;
  bool all = n > 0, convexEdge = false;
  for (int i = 0; i < n; ++i)
  {
    const EdgeRule& edgeRule = rules.edges[star.edges[ring.edges[i]].edge];
    if (edgeRule.feature)
    {
      features.push_back(i);
      convexEdge = convexEdge || edgeRule.oneBlock();
    }
    all = all && wall.isWall(star.faces[ring.faces[i]].face);
  }
  const int gap = features.size() == 2 ? features[1] - features[0] : 0;
  const bool smooth = n >= 3 && (features.empty() || (features.size() == 1 && !convexEdge));
  std::vector<Index> points;
  if (all)
  {
    for (const int edge : ring.edges)
    {
      points.push_back(next(edge));
    }
    for (const int f : ring.faces)
    {
      const FaceUse& use = complex.faces[star.faces[f].face].uses.front();
      const ComplexBlock& owner = complex.blocks[use.block];
      const int corner = star.faces[f].corner;
      points.push_back(wall.id(use.block, use.face, corner & 1 ? owner.cells(faceAxis(use.face, 0)) - 1 : 1,
        corner >> 1 ? owner.cells(faceAxis(use.face, 1)) - 1 : 1));
    }
  }
  if (all && smooth)
  {
    row.kind = Kind::Ring;
    row.next = n;
    row.points = points;
    return;
  }
  // Two groups of two sectors beside a crease are regular, and without points between the features nothing changes.
  const bool regular = n == 4 && features.size() == 2 && gap == 2;
  if (all && !regular && static_cast<int>(features.size()) < n)
  {
    this->Creased[wall.vertexId(v)] = { points, features };
  }
  const bool onWall = features.size() == 2 && wall.hasEdge(star.edges[ring.edges[features[0]]].edge) &&
    wall.hasEdge(star.edges[ring.edges[features[1]]].edge);
  if (onWall && gap > 1 && gap < n - 1)
  {
    row = { Kind::Curve, 2, { next(ring.edges[features[0]]), next(ring.edges[features[1]]) } };
    return;
  }
  row.kind = Kind::Kept;
  for (std::size_t e = 0; e < star.edges.size(); ++e)
  {
    if (star.edges[e].boundary && wall.hasEdge(star.edges[e].edge))
    {
      row.points.push_back(next(static_cast<int>(e)));
    }
  }
  row.next = row.points.size();
}

ExtraordinaryFans::ExtraordinaryFans(const LimitRows& rows, Index points, Twist twist)
  : Rule(twist)
  , Creased(rows.creasedRings())
{
  const auto makeSlots = [&](const std::vector<Index>& ring) {
    for (const Index at : ring)
    {
      if (rows.isTensor(at))
      {
        this->Slots[at]; // creates it
      }
    }
  };
  for (Index id = 0; id < points; ++id)
  {
    const std::vector<Index>& ring = rows.ring(id);
    if (!ring.empty())
    {
      this->Centers.push_back(id);
      this->Rings.push_back(ring);
      this->Feet.emplace_back();
      this->HasFoot.push_back(false);
      makeSlots(ring);
    }
  }
  for (const auto& ring : this->Creased)
  {
    makeSlots(ring.second.points);
  }
}

void ExtraordinaryFans::setFoot(std::size_t fan, const SurfaceGeometry& geometry)
{
  const bool keepsLimit = this->Rule == Twist::ACC || this->Rule == Twist::PCCM;
  this->HasFoot[fan] = !keepsLimit && geometry.normal.norm() > 0.0;
  this->Feet[fan] = { geometry.point, geometry.normal, geometry.curvature, true, Vec3::Zero() };
}

void ExtraordinaryFans::correct(const std::vector<Vec3>& x, std::vector<Vec3>& values)
{
  const auto fanOf = [&](Index center, const std::vector<Index>& ring) {
    const std::size_t n = ring.size() / 2;
    Fan fan;
    fan.center = x[center];
    for (std::size_t i = 0; i < n; ++i)
    {
      fan.spokes.push_back(x[ring[i]]);
      fan.sectors.push_back(x[ring[n + i]]);
    }
    return fan;
  };
  for (std::size_t c = 0; c < this->Centers.size(); ++c)
  {
    const Fan fan = fanOf(this->Centers[c], this->Rings[c]);
    this->addChanges(this->Rings[c], fan,
      this->HasFoot[c] ? projectedFan(fan, this->Feet[c], this->Rule)
                       : smoothFan(fan, this->Rule, std::vector<double>(fan.spokeCount(), KnotInsertion)));
  }
  for (const auto& [center, ring] : this->Creased)
  {
    const Fan fan = fanOf(center, ring.points);
    const std::size_t n = fan.spokes.size();
    std::vector<bool> kept(n, false);
    for (const int feature : ring.features)
    {
      kept[feature] = true;
    }
    this->addChanges(ring.points, fan,
      creasedFan(fan, ring.features, kept, std::vector<bool>(n, false), this->Rule,
        std::vector<double>(n, KnotInsertion), std::vector<SpokeKeep>(n))
        .points);
  }
  for (auto& slot : this->Slots)
  {
    // With a term of 0 it is a sum, even if all others have the same coordinate.
    slot.second.add(1.0, Vec3::Zero());
    values[slot.first] += slot.second.result(1.0);
    slot.second.clear();
  }
}

void ExtraordinaryFans::addChanges(const std::vector<Index>& ring, const Fan& fan, const Fan& points)
{
  const int n = fan.spokeCount();
  for (int i = 0; i < n; ++i)
  {
    const int before = (i + n - 1) % n, after = (i + 1) % n;
    this->add(ring[i],
      0.25 * points.spokes[i] - smoothMask(fan.sectors[before], fan.spokes[i], fan.sectors[i]) / 12.0 -
        smoothMask(fan.spokes[before], fan.center, fan.spokes[after]) / 6.0);
    this->add(ring[n + i],
      (points.sectors[i] - (4.0 * fan.center + 2.0 * (fan.spokes[i] + fan.spokes[after]) + fan.sectors[i]) / 9.0) /
        16.0);
  }
}

void ExtraordinaryFans::add(Index id, const Vec3& change)
{
  const auto slot = this->Slots.find(id);
  if (slot != this->Slots.end())
  {
    slot->second.add(1.0, change);
  }
}

} // namespace bsv
