// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/ShortSpokes.h"

#include "Conversion/NetPoints.h"

#include <algorithm>

namespace bsv
{
namespace
{

bool isShort(SpokeKind kind)
{
  return kind < 3;
}

/// Control points along a spoke, or 0 if it is long enough.
int lengthOf(const NetFan& fan, int k)
{
  return isShort(fan.shape.kinds[k]) ? controlPointCount(fan.cells[k], true) : 0;
}

/// Lengths of the spokes of a sector.
std::array<int, 2> lengthsOf(const NetFan& fan, int sector)
{
  return { lengthOf(fan, sector), lengthOf(fan, (sector + 1) % fan.spokeCount()) };
}

/// Place of point `at` along a spoke of the sector, on it or next to it.
Index placeAlong(const SectorPlaces& places, int layer, int which, int across, int at)
{
  return places(layer, which == 0 ? at : across, which == 0 ? across : at);
}

/// The points along both spokes of a sector, on them and next to them, in all layers.
std::vector<double> pointsAlong(const ConversionContext& context, const NetFan& fan, int k)
{
  const FanSector& sector = fan.sectors[k];
  const SectorPlaces places(context, sector);
  const std::array<int, 2> lengths = lengthsOf(fan, k);
  std::vector<double> list;
  for (int layer = 0; layer < fan.layers; ++layer)
  {
    for (const int which : { 0, 1 })
    {
      for (int across = 0; across < 2; ++across)
      {
        for (int at = 0; at < lengths[which]; ++at)
        {
          const auto x = context.controlPoint(sector.block, placeAlong(places, layer, which, across, at));
          list.insert(list.end(), x.data(), x.data() + 3);
        }
      }
    }
  }
  return list;
}

/// Whether the wall is joined across an edge at that vertex.
bool isJoinedAt(const NetFans& fans, int vertex, int edge)
{
  const auto isHere = [&](const FanEnd& at) { return fans.vertexOf(at) == vertex; };
  const auto hasInside = [&](const WallGroup& group) {
    bool found = false;
    for (int k = 1; k < group.shape.sectors; ++k)
    {
      const NetFan& fan = fans.all[group.at.fan];
      found = found || fan.edgeOf(fans.complex, (group.first + k) % fan.spokeCount(), group.at.end) == edge;
    }
    return isHere(group.at) && found;
  };
  return std::any_of(fans.wallVertices.begin(), fans.wallVertices.end(), isHere) ||
    std::any_of(fans.groups.begin(), fans.groups.end(), hasInside);
}

/// Whether a layer is joined at the other end of a spoke, too.
bool isJoinedBeyond(const NetFans& fans, const NetLayers& layers, const NetFan& fan, int k, int layer)
{
  const int end = fan.endAt(layer);
  if (end >= 0)
  {
    const int edge = fan.edgeOf(fans.complex, k, end);
    for (const int vertex : fans.complex.edges[edge].vertices)
    {
      if (vertex != fan.vertices[end] && isJoinedAt(fans, vertex, edge))
      {
        return true;
      }
    }
  }
  if (fan.edge < 0)
  {
    return false;
  }
  // The edge on the other side of the face behind the spoke.
  const auto [sector, which] = fan.spoke(k);
  const ComplexBlock& block = fans.complex.blocks[sector->block];
  const int face = sector->spokeFace(which), axis = faceAxis(face, 0) == sector->along ? 0 : 1;
  const int edge = faceEdge(face, axis, 1 - sector->side(faceAxis(face, 1 - axis)));
  const int beyond = fans.fanOfEdge[block.edges[edge]];
  return beyond >= 0 &&
    layers.isJoined(beyond, sector->reversed != block.edgeReversed[edge] ? fan.layers - 1 - layer : layer);
}

/// The lists of pointsAlong() of a fan's sectors.
using PointLists = std::vector<std::vector<double>>;

void evenSpoke(const ConversionContext& context, const NetFan& fan, const PointLists& lists, int k, int layer, int last)
{
  const LocalNetShape& shape = fan.shape;
  const int n = shape.spokes(), before = (k + shape.sectors - 1) % shape.sectors;
  const double wl = 1.0 / shape.delta((k + n - 1) % n), wr = 1.0 / shape.delta((k + 1) % n);
  const auto listed = [&](int sector, int which, int across, int at) {
    const std::array<int, 2> lengths = lengthsOf(fan, sector);
    const std::size_t perLayer = 2 * (lengths[0] + lengths[1]);
    return Vec3(
      lists[sector].data() + 3 * (perLayer * layer + (which == 0 ? 0 : 2 * lengths[0]) + across * lengths[which] + at));
  };
  const auto put = [&](int sector, int which, int at, const Vec3& x) {
    const FanSector& to = fan.sectors[sector];
    if (context.isHere(to.block))
    {
      writeJoined(context, to.block, placeAlong(SectorPlaces(context, to), layer, which, 1, at), x);
    }
  };
  for (int i = NetReach + 1; i <= last; ++i)
  {
    const Vec3 c = listed(k, 0, 0, i), l = listed(before, 1, 1, i), r = listed(k, 0, 1, i);
    const Vec3 defect = wl * (l - c) + wr * (r - c);
    put(before, 1, i, l - defect / (2.0 * wl));
    put(k, 0, i, r - defect / (2.0 * wr));
  }
}

} // namespace

void evenShortSpokes(const ConversionContext& context, const NetFans& fans, const NetLayers& layers, const Ranks& ranks)
{
  std::vector<int> some;
  for (int f = 0; f < static_cast<int>(fans.all.size()); ++f)
  {
    const std::vector<SpokeKind>& kinds = fans.all[f].shape.kinds;
    if (std::any_of(kinds.begin(), kinds.end(), isShort))
    {
      some.push_back(f);
    }
  }
  const SectorLists lists =
    gatherSectors(fans, some, ranks, [&](int i, int k) { return pointsAlong(context, fans.all[some[i]], k); });
  const auto even = [&](std::size_t i, int k, int layer) {
    const NetFan& fan = fans.all[some[i]];
    if (isShort(fan.shape.kinds[k]))
    {
      evenSpoke(context, fan, lists[i], k, layer,
        lengthOf(fan, k) - (isJoinedBeyond(fans, layers, fan, k, layer) ? NetReach + 2 : NetReach));
    }
  };
  for (std::size_t i = 0; i < some.size(); ++i)
  {
    const NetFan& fan = fans.all[some[i]];
    for (int layer = 0; layer < fan.layers; ++layer)
    {
      for (int k = 0; k < fan.spokeCount() && layers.isJoined(some[i], layer); ++k)
      {
        if (fan.shape.isJoined(k))
        {
          even(i, k, layer);
        }
      }
    }
    for (const WallGroup& group : fans.groups)
    {
      for (int k = 1; k < group.shape.sectors && group.at.fan == some[i]; ++k)
      {
        even(i, (group.first + k) % fan.spokeCount(), fan.endLayer(group.at.end));
      }
    }
  }
}

} // namespace bsv
