// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/G1Joins.h"

#include "Base/SortedSum.h"
#include "Conversion/G1Wall.h"
#include "Conversion/NetPoints.h"
#include "Conversion/NetShifts.h"
#include "Conversion/ShortSpokes.h"

#include <algorithm>
#include <map>
#include <utility>

namespace bsv
{
namespace
{

/// Each computed once, before loops run in parallel.
template <typename Rule>
using RulesOfShapes = std::map<LocalNetShape, Rule>;

/// By fan.
using ShiftsOfFans = std::map<int, std::vector<NetShift>>;

/// Groups of the wall between two creases are joined on the wall, and the change is carried into the layers before they
/// are joined.
ShiftsOfFans shiftsOfGroups(
  const ConversionContext& context, const NetFans& fans, const NetLayers& layers, RulesOfShapes<JoinRule>& rules)
{
  ShiftsOfFans result;
  for (const WallGroup& group : fans.groups)
  {
    const NetFan& fan = fans.all[group.at.fan];
    const auto sectorOf = [&](int k) { return (group.first + k) % fan.shape.sectors; };
    std::vector<Vec3> net(group.shape.size());
    group.shape.forPoints([&](int a, int k, int i, int j) {
      net[a] = layers.point(group.at.fan, fan.endLayer(group.at.end), sectorOf(k), i, j);
    });
    const std::vector<Vec3> before = net;
    rules.try_emplace(group.shape, group.shape).first->second.apply(net, true);
    std::vector<Vec3> change(fan.shape.size(), Vec3::Zero());
    group.shape.forPoints(
      [&](int a, int k, int i, int j) { change[fan.shape.sector(sectorOf(k), i, j)] = net[a] - before[a]; });
    for (NetShift& shift : carriedShifts(context, fans, layers, group.at, fan.shape, change))
    {
      result[shift.fan].push_back(std::move(shift));
    }
  }
  return result;
}

void addShifts(const std::vector<NetShift>& shifts, int layer, std::vector<Vec3>& net)
{
  for (std::size_t a = 0; a < net.size(); ++a)
  {
    std::vector<Vec3> changes;
    for (const NetShift& shift : shifts)
    {
      changes.emplace_back(shift.weights[layer] * shift.net[a]);
    }
    net[a] += sortedSum(changes);
  }
}

/// Whether this rank has points of the fan, or copies of them.
bool concerns(const ConversionContext& context, const NetFan& fan)
{
  const auto isHere = [&](const auto& use) { return context.isHere(use.block); };
  bool any = std::any_of(fan.sectors.begin(), fan.sectors.end(), isHere);
  for (int k = 0; k < fan.spokeCount() && !any; ++k)
  {
    for (const int end : { 0, 1 })
    {
      const std::vector<EdgeUse>& uses = context.complex.edges[fan.edgeOf(context.complex, k, end)].uses;
      any = any || std::any_of(uses.begin(), uses.end(), isHere);
    }
  }
  return any;
}

/// A layer of a fan and its local net.
struct LayerNet
{
  int fan, layer;
  std::vector<Vec3> points = {};
};

/// The layers of the fans that concern this rank, joined.
std::vector<LayerNet> joinedNets(
  const ConversionContext& context, const NetFans& fans, const NetLayers& layers, const Execution& run)
{
  std::vector<LayerNet> nets;
  RulesOfShapes<JoinRule> rules;
  RulesOfShapes<PccmRule> pccmRules;
  for (int f = 0; f < static_cast<int>(fans.all.size()); ++f)
  {
    const NetFan& fan = fans.all[f];
    if (context.options.twist == Twist::PCCM && PccmRule::fits(fan.shape))
    {
      pccmRules.try_emplace(fan.shape, fan.shape);
    }
    else
    {
      rules.try_emplace(fan.shape, fan.shape);
    }
    const int count = concerns(context, fan) ? fan.layers : 0;
    for (int layer = 0; layer < count; ++layer)
    {
      nets.push_back({ f, layer });
    }
  }
  const ShiftsOfFans shifts = shiftsOfGroups(context, fans, layers, rules);
  run.parallelFor(static_cast<Index>(nets.size()), 8, [&](Index begin, Index end) {
    for (Index n = begin; n < end; ++n)
    {
      auto& [f, layer, net] = nets[n];
      net = layers.net(f, layer);
      const auto found = shifts.find(f);
      if (found != shifts.end())
      {
        addShifts(found->second, layer, net);
      }
      if (layers.isJoined(f, layer))
      {
        const auto pccm = pccmRules.find(fans.all[f].shape);
        pccm != pccmRules.end() ? pccm->second.apply(net) : rules.at(fans.all[f].shape).apply(net, true);
      }
    }
  });
  return nets;
}

/// Writes what differs from the control points.
void write(const ConversionContext& context, const NetFans& fans, const std::vector<LayerNet>& nets)
{
  for (const LayerNet& net : nets)
  {
    const NetFan& fan = fans.all[net.fan];
    for (const NetCopy& copy : copiesHere(context, fan, net.layer, fan.shape))
    {
      if (context.controlPoint(copy.block, copy.place) != net.points[copy.point])
      {
        writeJoined(context, copy.block, copy.place, net.points[copy.point]);
      }
    }
  }
}

G1Report countLayers(const NetFans& fans, const NetLayers& layers)
{
  G1Report report;
  for (int f = 0; f < static_cast<int>(fans.all.size()); ++f)
  {
    const NetFan& fan = fans.all[f];
    for (int layer = 0; layer < fan.layers; ++layer)
    {
      ++(layers.isJoined(f, layer) ? report.layers : report.skippedLayers);
      report.givenUpLayers += fan.isGivenUp(layer) ? 1 : 0;
    }
    report.edges += fan.edge >= 0 ? 1 : 0;
  }
  return report;
}

} // namespace

G1Report makeExactG1(
  const ConversionContext& context, const std::vector<JoinedSpan>& avoid, bool joinNothing, const Execution& run)
{
  const NetFans fans = findNetFans(context, avoid, joinNothing);
  const NetLayers layers(context, fans, *run.ranks);
  G1Report report = countLayers(fans, layers);
  write(context, fans, joinedNets(context, fans, layers, run));
  evenShortSpokes(context, fans, layers, *run.ranks);
  if (fitWall(context, fans, layers, run, report))
  {
    evenShortSpokes(context, fans, layers, *run.ranks);
  }
  return report;
}

} // namespace bsv
