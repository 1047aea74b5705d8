// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/NetShifts.h"

#include "Base/SortedSum.h"
#include "Conversion/BodyPropagation.h"
#include "Conversion/NetPoints.h"

#include <algorithm>
#include <map>
#include <utility>

namespace bsv
{
namespace
{

/// r h, h the mean length of the wall's edges at the end of a fan.
double rangeAt(const ConversionContext& context, const NetFans& fans, const NetLayers& layers, const FanEnd& wall)
{
  const NetFan& fan = fans.all[wall.fan];
  std::vector<double> lengths;
  for (int k = 0; k < fan.shape.sectors; ++k)
  {
    const auto point = [&](int i) { return layers.point(wall.fan, fan.endLayer(wall.end), k, i, 0); };
    lengths.push_back(3.0 * (point(1) - point(0)).norm() / fan.shape.delta(k));
  }
  return propagationReach(context.options, std::move(lengths));
}

/// Of the layers along the edge from an end on, where the distance is `distance`; then it is that of the other end.
std::vector<double> distancesFrom(const NetFans& fans, const NetLayers& layers, const FanEnd& from, double& distance)
{
  const int count = fans.all[from.fan].layers;
  std::vector<double> distances(count);
  const auto layerAt = [&](int step) { return from.end == 0 ? step : count - 1 - step; };
  for (int step = 0; step < count; ++step)
  {
    const auto center = [&](int s) { return layers.point(from.fan, layerAt(s), 0, 0, 0); };
    distance += step > 0 ? (center(step) - center(step - 1)).norm() : 0.0;
    distances[layerAt(step)] = distance;
  }
  return distances;
}

/// Whether the boundary at an end of a fan must stay where it is. (A thin stack moves with the wall.)
bool endStays(const ConversionContext& context, const NetFan& fan, int end)
{
  return fan.skipped[end] > 0 || std::any_of(fan.sectors.begin(), fan.sectors.end(), [&](const FanSector& sector) {
    const FaceRule& face = context.rules.faces[context.complex.blocks[sector.block].faces[sector.endFace(end)]];
    return face.planar() || face.role != BoundaryRole::Other;
  });
}

/// The same shift in the order of the next fan.
NetShift continued(const NetFans& fans, const NetShift& shift, const Continuation& next)
{
  const bool same = next.sectors[1] == (next.sectors[0] + 1) % shift.shape.sectors;
  NetShift result{ next.at.fan, shift.shape, shift.net, {} };
  result.shape.kinds = fans.all[next.at.fan].shape.kinds;
  shift.shape.forPoints([&](int a, int k, int i, int j) {
    result.net[shift.shape.sector(next.sectors[k], same ? i : j, same ? j : i)] = shift.net[a];
  });
  return result;
}

} // namespace

std::vector<NetShift> carriedShifts(const ConversionContext& context, const NetFans& fans, const NetLayers& layers,
  const FanEnd& wall, const LocalNetShape& shape, const std::vector<Vec3>& net)
{
  std::vector<NetShift> shifts{ { wall.fan, shape, net, { 1.0 } } };
  if (fans.all[wall.fan].edge < 0)
  {
    return shifts;
  }
  const double range = rangeAt(context, fans, layers, wall);
  std::vector<std::vector<double>> distances;
  double distance = 0.0, cut = range;
  for (FanEnd from = wall;;)
  {
    distances.push_back(distancesFrom(fans, layers, from, distance));
    if (distance >= range)
    {
      break;
    }
    const NetFan& fan = fans.all[from.fan];
    const int end = 1 - from.end, left = fan.skipped[end];
    if (left >= NodeLayers)
    {
      cut = distances.back()[end == 0 ? left - 1 : fan.layers - left];
      break;
    }
    const Continuation next = fans.beyond({ from.fan, end });
    if (next.at.fan < 0 || context.complex.vertices[fan.vertices[end]].boundary ||
      shifts.size() > context.complex.edges.size())
    {
      cut = endStays(context, fan, end) ? distance : range;
      break;
    }
    shifts.push_back(continued(fans, shifts.back(), next));
    from = next.at;
  }
  for (std::size_t i = 0; i < shifts.size(); ++i)
  {
    shifts[i].weights.clear();
    for (const double d : distances[i])
    {
      shifts[i].weights.push_back(d == 0.0 ? 1.0 : d < cut ? 1.0 - d / cut : 0.0);
    }
  }
  return shifts;
}

void applyShifts(const ConversionContext& context, const NetFans& fans, const std::vector<std::vector<NetShift>>& lists)
{
  using Place = std::pair<int, Index>;
  std::map<Place, std::vector<Vec3>> changes;
  for (const std::vector<NetShift>& shifts : lists)
  {
    std::map<Place, Vec3> ofList;
    for (const NetShift& shift : shifts)
    {
      for (std::size_t layer = 0; layer < shift.weights.size(); ++layer)
      {
        if (shift.weights[layer] == 0.0)
        {
          continue;
        }
        for (const NetCopy& copy : copiesHere(context, fans.all[shift.fan], static_cast<int>(layer), shift.shape))
        {
          ofList.emplace(Place{ copy.block, copy.place }, shift.weights[layer] * shift.net[copy.point]);
        }
      }
    }
    for (const auto& [place, change] : ofList)
    {
      changes[place].push_back(change);
    }
  }
  for (const auto& [place, list] : changes)
  {
    const auto [block, at] = place;
    writeJoined(context, block, at, context.controlPoint(block, at) + sortedSum(list));
  }
}

} // namespace bsv
