// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/EdgeConversion.h"

#include <algorithm>
#include <array>
#include <iterator>

namespace bsv
{

double layerRatio(const ConversionContext& context, int block, int face, const Ijk& point, const Ijk& reference)
{
  if (!context.layer.varies(block, face))
  {
    return 1.0;
  }
  const double weight = context.layer.weight(block, face, point);
  const double other = context.layer.weight(block, face, reference);
  return weight == other ? 1.0 : (1.0 - weight) / (1.0 - other);
}

double keepAt(const ConversionContext& context, int block, int face, const Ijk& point)
{
  const std::vector<double>& keep = context.keeps[context.complex.blocks[block].faces[face]];
  return keep.empty()
    ? 0.0
    : keep[keepIndex(context.complex, block, face, point[faceAxis(face, 0)], point[faceAxis(face, 1)])];
}

std::vector<SpokeKeep> spokeKeeps(const ConversionContext& context, const EdgeFan& fan, int k)
{
  std::vector<SpokeKeep> keeps(fan.spokeCount());
  for (int i = 0; i < fan.spokeCount(); ++i)
  {
    const auto [sector, which] = fan.spoke(i);
    const ComplexBlock& owner = context.complex.blocks[sector->block];
    const int face = sector->spokeFace(which);
    keeps[i].center = keepAt(context, sector->block, face, sector->point(owner, k, 0, 0));
    keeps[i].step =
      keepAt(context, sector->block, face, sector->point(owner, k, which == 0 ? 1 : 0, which == 0 ? 0 : 1));
  }
  return keeps;
}

namespace
{

/// Mesh points of layer k.
Fan meshFan(const ConversionContext& context, const EdgeFan& fan, int k)
{
  Fan result;
  result.closed = fan.closed;
  for (const FanSector& sector : fan.sectors)
  {
    const ComplexBlock& owner = context.complex.blocks[sector.block];
    result.center = context.point(sector.block, sector.point(owner, k, 0, 0));
    result.spokes.push_back(context.point(sector.block, sector.point(owner, k, 1, 0)));
    result.sectors.push_back(context.point(sector.block, sector.point(owner, k, 1, 1)));
  }
  if (!fan.closed)
  {
    const FanSector& last = fan.sectors.back();
    result.spokes.push_back(context.point(last.block, last.point(context.complex.blocks[last.block], k, 0, 1)));
  }
  return result;
}

/// Weight of the edge in the inserted points along each spoke of layer k.
std::vector<double> nearWeights(const ConversionContext& context, const EdgeFan& fan, int k)
{
  // The second spoke of a sector leaves the block face on which the first one lies, and the other way round.
  std::vector<double> weights(fan.spokeCount(), KnotInsertion);
  for (int i = 0; i < static_cast<int>(fan.sectors.size()); ++i)
  {
    const FanSector& sector = fan.sectors[i];
    const Ijk point = sector.point(context.complex.blocks[sector.block], k, 0, 0);
    for (const int which : { 0, 1 })
    {
      double& weight = weights[(i + 1 - which) % fan.spokeCount()];
      const double own = context.layer.weight(sector.block, sector.spokeFace(which), point);
      weight = own == KnotInsertion ? weight : weight == KnotInsertion ? own : std::max(weight, own);
    }
  }
  return weights;
}

/// Moves points as controlFan() says, in sectors whose spokes leave a wall or connection layer.
void adjustSectors(const ConversionContext& context, Fan& points, const EdgeFan& fan, int k)
{
  for (int i = 0; i < points.sectorCount(); ++i)
  {
    const FanSector& sector = fan.sectors[i];
    const ComplexBlock& owner = context.complex.blocks[sector.block];
    const Ijk center = sector.point(owner, k, 0, 0);
    const double first = layerRatio(context, sector.block, sector.spokeFace(0), sector.point(owner, k, 1, 0), center);
    const double second = layerRatio(context, sector.block, sector.spokeFace(1), sector.point(owner, k, 0, 1), center);
    const Vec3 point = points.sectors[i];
    const Vec3 offsets[2] = { (first - 1.0) * (point - points.spokes[i]),
      (second - 1.0) * (point - points.spokes[points.nextSpoke(i)]) };
    if (first != 1.0 || second != 1.0)
    {
      points.sectors[i] += offsets[0] + offsets[1];
    }
  }
}

/// The same above the layer `base`.
void adjustLayer(const ConversionContext& context, Fan& points, const EdgeFan& fan, int base)
{
  const Fan below = meshFan(context, fan, base);
  const auto ratioAt = [&](const FanSector& sector, int a, int b) {
    const ComplexBlock& owner = context.complex.blocks[sector.block];
    return layerRatio(context, sector.block, sector.endFace(base == 0 ? 0 : 1), sector.point(owner, base, a, b),
      sector.point(owner, base, 0, 0));
  };
  std::vector<double> spokes(points.spokeCount(), 1.0);
  for (int i = 0; i < points.sectorCount(); ++i)
  {
    const FanSector& sector = fan.sectors[i];
    points.sectors[i] += (ratioAt(sector, 1, 1) - 1.0) * (points.sectors[i] - below.sectors[i]);
    // A spoke is seen by two sectors; one of them may have no wall below.
    for (const int which : { 0, 1 })
    {
      double& ratio = spokes[(i + which) % points.spokeCount()];
      const double own = which == 0 ? ratioAt(sector, 1, 0) : ratioAt(sector, 0, 1);
      ratio = own == 1.0 ? ratio : ratio == 1.0 ? own : std::max(ratio, own);
    }
  }
  for (int i = 0; i < points.spokeCount(); ++i)
  {
    points.spokes[i] += (spokes[i] - 1.0) * (points.spokes[i] - below.spokes[i]);
  }
}

} // namespace

Fan controlFan(const ConversionContext& context, int edge, const EdgeFan& fan, int k, int base)
{
  Fan points = meshFan(context, fan, k);
  adjustSectors(context, points, fan, k);
  if (base >= 0)
  {
    adjustLayer(context, points, fan, base);
  }
  const std::vector<double> weights = nearWeights(context, fan, k);
  const std::vector<SpokeKeep> keeps = spokeKeeps(context, fan, k);
  if (!context.rules.edges[edge].anchored)
  {
    Fan result = fadedFan(points, context.options.twist, weights, keeps);
    const auto corrections = context.corrections.find(edge);
    if (corrections != context.corrections.end())
    {
      // At most one comes from either end: their sum does not depend on the order.
      const auto correct = [&](Vec3& point, const auto& deltaOf) {
        Vec3 sum = Vec3::Zero();
        for (const LayerCorrection& correction : corrections->second)
        {
          sum += correction.weights[k] * deltaOf(correction.delta);
        }
        point += sum;
      };
      correct(result.center, [](const Fan& delta) { return delta.center; });
      for (int i = 0; i < result.spokeCount(); ++i)
      {
        correct(result.spokes[i], [i](const Fan& delta) { return delta.spokes[i]; });
      }
      for (int i = 0; i < result.sectorCount(); ++i)
      {
        correct(result.sectors[i], [i](const Fan& delta) { return delta.sectors[i]; });
      }
    }
    return result;
  }
  std::vector<Vec3> along = points.spokes;
  const int sectors = points.sectorCount();
  for (int i = 0; i < points.spokeCount(); ++i)
  {
    const int face = fan.faceOf(context.complex, i);
    if (!context.complex.faces[face].boundary() && !context.rules.faces[face].planar())
    {
      along[i] = fadedMask(
        points.sectors[(i + sectors - 1) % sectors], points.spokes[i], points.sectors[i % sectors], keeps[i].step);
    }
  }
  return anchoredFan(points, points.center, along, weights);
}

namespace
{

/// Control point of a sector's block in layer k, `a` from the end along the first spoke and `b` along the second.
Ijk controlPosition(const ConversionContext& context, const FanSector& sector, int k, int a, int b)
{
  const int cells = context.complex.blocks[sector.block].cells(sector.along);
  const int along = context.innerPosition(sector.block, sector.along, sector.reversed ? cells - k : k);
  return context.besideEdge(sector, along, a, b);
}

/// Whether the layers of a fan follow the regular rule, with knot insertion in all faces around.
bool hasRegularLayers(const ConversionContext& context, int edge, const EdgeFan& fan)
{
  if (context.moved || context.rules.edges[edge].anchored || context.corrections.count(edge) > 0 ||
    fan.sectors.size() != (fan.closed ? 4 : 2))
  {
    return false;
  }
  return std::all_of(fan.sectors.begin(), fan.sectors.end(), [&](const FanSector& sector) {
    bool plain = true;
    for (const int which : { 0, 1 })
    {
      const int face = sector.spokeFace(which);
      plain = plain && context.layer.isKnotInsertion(sector.block, face) &&
        context.keeps[context.complex.blocks[sector.block].faces[face]].empty();
    }
    return plain;
  });
}

/// The layers begin..end - 1 of such a fan, many at once.
void convertRegularLayers(const ConversionContext& context, int edge, const EdgeFan& fan, int begin, int end)
{
  constexpr int Most = 32;
  const int spokes = fan.spokeCount();
  const int sectors = static_cast<int>(fan.sectors.size());
  std::array<std::array<Vec3, Most>, 9> points, values;
  std::vector<const Vec3*> from;
  std::vector<Vec3*> to;
  for (int i = 0; i < 1 + spokes + sectors; ++i)
  {
    from.push_back(points[i].data());
    to.push_back(values[i].data());
  }
  for (int first = begin; first < end; first += Most)
  {
    const int count = std::min(Most, end - first);
    const auto read = [&](int i, const FanSector& sector, int a, int b) {
      const ComplexBlock& owner = context.complex.blocks[sector.block];
      const Index start = owner.points.place(sector.point(owner, first, a, b));
      const Index step = (sector.reversed ? -1 : 1) * owner.points.stride(sector.along);
      for (int k = 0; k < count; ++k)
      {
        points[i][k] = owner.points.atPlace(start + k * step);
      }
    };
    read(0, fan.sectors[0], 0, 0);
    for (int i = 0; i < sectors; ++i)
    {
      read(1 + i, fan.sectors[i], 1, 0);
      read(1 + spokes + i, fan.sectors[i], 1, 1);
    }
    if (!fan.closed)
    {
      read(spokes, fan.sectors.back(), 0, 1);
    }
    smoothRegularFans(fan.closed, from, count, to);
    for (int i = 0; i < sectors; ++i)
    {
      const FanSector& sector = fan.sectors[i];
      if (!context.isHere(sector.block))
      {
        continue;
      }
      const ControlNetStorage& net = context.nets[sector.block];
      const auto write = [&](int a, int b, int from) {
        const Index start = context.index(sector.block, controlPosition(context, sector, first, a, b));
        const Index step = context.index(sector.block, controlPosition(context, sector, first + 1, a, b)) - start;
        for (int k = 0; k < count; ++k)
        {
          std::copy_n(values[from][k].data(), 3, net.points + 3 * (start + k * step));
          net.rules[start + k * step] = static_cast<std::uint8_t>(context.rules.edges[edge].rule);
        }
      };
      write(0, 0, 0);
      write(1, 0, 1 + i);
      write(0, 1, 1 + (i + 1) % spokes);
      write(1, 1, 1 + spokes + i);
    }
  }
}

} // namespace

void convertEdge(const ConversionContext& context, int edge)
{
  convertEdgeLayers(context, edge, 1, context.complex.edges[edge].cells);
}

void convertEdgeLayers(const ConversionContext& context, int edge, int begin, int end)
{
  const EdgeRule& edgeRule = context.rules.edges[edge];
  for (const EdgeFan& fan : edgeRule.fans)
  {
    if (hasRegularLayers(context, edge, fan))
    {
      convertRegularLayers(context, edge, fan, begin, end);
      continue;
    }
    const bool ordinary = edgeRule.rule != ControlPointRule::ExtraordinaryEdge;
    bool connection = false;
    for (int i = 0; i < fan.spokeCount(); ++i)
    {
      connection = connection || context.rules.faces[fan.faceOf(context.complex, i)].connection;
    }
    const auto ruleOf = [&](double weightFirst, double weightSecond) {
      return ordinary && (weightFirst != KnotInsertion || weightSecond != KnotInsertion) ? layerRule(connection)
                                                                                         : edgeRule.rule;
    };
    for (int k = begin; k < end; ++k)
    {
      const std::vector<double> weights = nearWeights(context, fan, k);
      const Fan values = controlFan(context, edge, fan, k);
      const std::vector<SpokeKeep> keeps = spokeKeeps(context, fan, k);
      std::vector<bool> kept;
      std::transform(
        keeps.begin(), keeps.end(), std::back_inserter(kept), [](const SpokeKeep& keep) { return keep.any(); });
      const bool keepsAny = std::find(kept.begin(), kept.end(), true) != kept.end();
      const bool keepsAll = keptLinesMeet(fan.closed, kept);
      const auto spokeRule = [&](int i) {
        return kept[i] || keepsAll ? ControlPointRule::Crease : ruleOf(weights[i], KnotInsertion);
      };
      for (int i = 0; i < static_cast<int>(fan.sectors.size()); ++i)
      {
        const FanSector& sector = fan.sectors[i];
        const int next = (i + 1) % fan.spokeCount();
        const auto put = [&](int a, int b, const Vec3& point, ControlPointRule rule) {
          context.write(sector.block, controlPosition(context, sector, k, a, b), point, rule);
        };
        put(0, 0, values.center, keepsAny ? ControlPointRule::Crease : edgeRule.rule);
        put(1, 0, values.spokes[i], spokeRule(i));
        put(0, 1, values.spokes[next], spokeRule(next));
        put(1, 1, values.sectors[i], keepsAll ? ControlPointRule::Crease : ruleOf(weights[i], weights[next]));
      }
    }
  }
}

} // namespace bsv
