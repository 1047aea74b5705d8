// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/NetFans.h"

#include <algorithm>

namespace bsv
{
namespace
{

void addSpoke(const BlockComplex& complex, int edge, NetFan& fan)
{
  fan.cells.push_back(complex.edges[edge].cells);
  fan.shape.kinds.push_back(spokeKind(fan.cells.back()));
}

void addEdge(const ConversionContext& context, int edge, NetFans& fans)
{
  const EdgeRule& rule = context.rules.edges[edge];
  if (rule.anchored || rule.feature || rule.fans.size() != 1)
  {
    return;
  }
  const EdgeFan& around = rule.fans.front();
  const int n = static_cast<int>(around.sectors.size());
  if (n < 3 || (around.closed && n == 4))
  {
    return;
  }
  NetFan fan{ around, edge, context.complex.edges[edge].vertices, { around.closed, n, NetReach, {} } };
  for (int k = 0; k < fan.spokeCount(); ++k)
  {
    addSpoke(context.complex, fan.edgeOf(context.complex, k, 0), fan);
  }
  fan.layers = context.count(fan.sectors.front().block, fan.sectors.front().along);
  fans.fanOfEdge[edge] = static_cast<int>(fans.all.size());
  fans.all.push_back(std::move(fan));
}

/// The group of `size` sectors from the spoke `first` on.
WallGroup groupAt(const NetFans& fans, const FanEnd& at, int first, int size)
{
  const LocalNetShape& whole = fans.all[at.fan].shape;
  WallGroup group{ at, first, { false, size, NetReach, {} } };
  for (int k = 0; k <= size; ++k)
  {
    group.shape.kinds.push_back(whole.kinds[(first + k) % whole.spokes()]);
  }
  return group;
}

/// Which layers at an end of an edge stay, and where the wall there is fitted or has creases.
void setEnd(const ConversionContext& context, const FanEnd& at, NetFans& fans)
{
  NetFan& fan = fans.all[at.fan];
  const int n = fan.shape.sectors;
  const ComplexVertex& vertex = context.complex.vertices[fans.vertexOf(at)];
  const int around = static_cast<int>(vertex.corners.size());
  int& skipped = fan.skipped[at.end];
  if (around == 2 * n && fans.beyond(at).at.fan >= 0)
  {
    return;
  }
  if (around != n || !vertex.boundary)
  {
    skipped = NodeLayers;
    return;
  }
  // All blocks at the vertex are around the edge: the boundary is their first layer.
  std::vector<int> features;
  for (int k = 0; k < fan.spokeCount(); ++k)
  {
    if (context.rules.edges[fan.edgeOf(context.complex, k, at.end)].feature)
    {
      features.push_back(k);
    }
  }
  if (!fan.closed)
  {
    // Smooth up to its borders.
    skipped = std::any_of(features.begin(), features.end(), [&](int k) { return k > 0 && k < n; }) ? 1 : 0;
    return;
  }
  const bool wall = std::all_of(fan.sectors.begin(), fan.sectors.end(), [&](const FanSector& sector) {
    return context.isWall(context.complex.blocks[sector.block].faces[sector.endFace(at.end)]);
  });
  if (features.size() < 2)
  {
    if (wall)
    {
      fans.wallVertices.push_back(at);
    }
    return;
  }
  skipped = 1;
  if (wall && features.size() == 2)
  {
    const int sizes[2] = { features[1] - features[0], n - features[1] + features[0] };
    for (int c = 0; c < 2; ++c)
    {
      if (sizes[0] >= 2 && sizes[1] >= 2 && sizes[c] > 2)
      {
        fans.groups.push_back(groupAt(fans, at, features[c], sizes[c]));
      }
    }
  }
}

/// Wall around a boundary vertex that is no end of a single extraordinary edge.
void addVertex(const ConversionContext& context, int vertex, NetFans& fans)
{
  if (!context.complex.vertices[vertex].boundary)
  {
    return;
  }
  const VertexStar star = vertexStar(context.complex, vertex);
  const BoundaryRing ring = boundaryRing(star);
  const int n = static_cast<int>(ring.edges.size());
  const auto isFeature = [&](int e) { return context.rules.edges[star.edges[e].edge].feature; };
  const auto isWall = [&](int f) { return context.isWall(star.faces[f].face); };
  if (n < 3 || n == 4 || !std::all_of(ring.faces.begin(), ring.faces.end(), isWall) ||
    std::count_if(ring.edges.begin(), ring.edges.end(), isFeature) >= 2 ||
    std::any_of(fans.wallVertices.begin(), fans.wallVertices.end(),
      [&](const FanEnd& other) { return fans.vertexOf(other) == vertex; }))
  {
    return;
  }
  NetFan fan{ {}, -1, { vertex, vertex }, { true, n, NetReach, {} } };
  for (int i = 0; i < n; ++i)
  {
    const VertexStar::Face& face = star.faces[ring.faces[i]];
    const FaceUse& use = context.complex.faces[face.face].uses.front();
    const EdgeUse leaving{ use.block, edgeIndex(faceDirection(use.face), face.corner & 1, face.corner >> 1),
      faceSide(use.face) != 0 };
    fan.sectors.push_back(sectorAt(leaving, faceAxis(use.face, face.edges[0] == ring.edges[i] ? 0 : 1)));
    addSpoke(context.complex, star.edges[ring.edges[i]].edge, fan);
  }
  fans.wallVertices.push_back({ static_cast<int>(fans.all.size()), 0 });
  fans.all.push_back(std::move(fan));
}

/// Gives up the layers of a fan that a span depends on.
void giveUp(const ConversionContext& context, const JoinedSpan& span, NetFan& fan)
{
  // Of the span's four control points, the nearest one to a side.
  const auto nearest = [&](int d, int side) {
    return context.endPosition(span.block, d, side, span.first[d] + 3 * side);
  };
  for (const FanSector& sector : fan.sectors)
  {
    const auto isNear = [&](int d) { return nearest(d, sector.side(d)) <= JoinReach; };
    if (sector.block == span.block && isNear(sector.first) && isNear(sector.second))
    {
      fan.givenUp.resize(fan.layers, false);
      const int first = fan.layers > 1 ? nearest(sector.along, sector.reversed ? 1 : 0) : 0;
      std::fill(fan.givenUp.begin() + first, fan.givenUp.begin() + std::min(first + 4, fan.layers), true);
    }
  }
}

} // namespace

Continuation NetFans::beyond(const FanEnd& at) const
{
  const NetFan& fan = this->all[at.fan];
  Continuation result;
  for (const FanSector& sector : fan.sectors)
  {
    const FaceContact contact = contactOf(this->complex, sector.block, sector.endFace(at.end));
    if (fan.edge < 0 || contact.block < 0)
    {
      return {};
    }
    const auto [s, t] = mapFacePoint(contact.orientation, edgeSide(sector.edge, 0), edgeSide(sector.edge, 1), 1, 1);
    const int edge = edgeIndex(faceDirection(contact.face), s, t);
    const int next = this->fanOfEdge[this->complex.blocks[contact.block].edges[edge]];
    if (next < 0 || this->all[next].closed != fan.closed || this->all[next].sectors.size() != fan.sectors.size())
    {
      return {};
    }
    const std::vector<FanSector>& sectors = this->all[next].sectors;
    const auto across = std::find_if(sectors.begin(), sectors.end(),
      [&](const FanSector& other) { return other.block == contact.block && other.edge == edge; });
    const FanEnd behind{ next, across->endFace(0) == contact.face ? 0 : 1 };
    if (!result.sectors.empty() && !(behind == result.at))
    {
      return {};
    }
    result.at = behind;
    result.sectors.push_back(static_cast<int>(across - sectors.begin()));
  }
  return result;
}

NetFans findNetFans(const ConversionContext& context, const std::vector<JoinedSpan>& avoid, bool joinNothing)
{
  NetFans fans{ context.complex, {}, std::vector<int>(context.complex.edges.size(), -1), {}, {} };
  for (int e = 0; e < static_cast<int>(context.complex.edges.size()); ++e)
  {
    addEdge(context, e, fans);
  }
  for (int f = 0; f < static_cast<int>(fans.all.size()); ++f)
  {
    setEnd(context, { f, 0 }, fans);
    setEnd(context, { f, 1 }, fans);
  }
  for (int v = 0; v < static_cast<int>(context.complex.vertices.size()); ++v)
  {
    addVertex(context, v, fans);
  }
  for (NetFan& fan : fans.all)
  {
    fan.givenUp.assign(joinNothing ? fan.layers : 0, true);
    for (const JoinedSpan& span : avoid)
    {
      giveUp(context, span, fan);
    }
  }
  const auto isTouched = [&](const FanEnd& at) { return !fans.all[at.fan].givenUp.empty(); };
  fans.wallVertices.erase(
    std::remove_if(fans.wallVertices.begin(), fans.wallVertices.end(), isTouched), fans.wallVertices.end());
  fans.groups.erase(
    std::remove_if(fans.groups.begin(), fans.groups.end(), [&](const WallGroup& group) { return isTouched(group.at); }),
    fans.groups.end());
  return fans;
}

} // namespace bsv
