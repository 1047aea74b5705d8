// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/NetLayers.h"

#include "Conversion/EdgeConversion.h"
#include "Conversion/NetPoints.h"
#include "Ranks/OwnedValues.h"

#include <algorithm>
#include <numeric>

namespace bsv
{
namespace
{

/// Per layer, whether a face behind a spoke of the sector keeps its points, in the mesh layers that it depends on.
std::vector<bool> keptLayers(const ConversionContext& context, const NetFan& fan, const FanSector& sector)
{
  std::vector<bool> kept(fan.layers, false);
  const ComplexBlock& block = context.complex.blocks[sector.block];
  const auto isSmooth = [&](int which) { return context.keeps[block.faces[sector.spokeFace(which)]].empty(); };
  if (fan.edge < 0 || (isSmooth(0) && isSmooth(1)))
  {
    return kept;
  }
  const int cells = block.cells(sector.along);
  const auto keepsMesh = [&](int k) {
    const auto keeps = [&](int which, int step) {
      const Ijk point = which == 0 ? sector.point(block, k, step, 0) : sector.point(block, k, 0, step);
      return keepAt(context, sector.block, sector.spokeFace(which), point) > 0.0;
    };
    return keeps(0, 0) || keeps(0, 1) || keeps(1, 0) || keeps(1, 1);
  };
  const auto stencils = knotInsertion(cells, context.isDoubled(sector.block, sector.along));
  for (int layer = 0; layer < fan.layers; ++layer)
  {
    for (int old = stencils[layer].first; old < stencils[layer].first + stencils[layer].terms; ++old)
    {
      // Ends and inserted points depend on two mesh layers.
      kept[layer] = kept[layer] ||
        (old <= 1         ? keepsMesh(0) || keepsMesh(1)
            : old > cells ? keepsMesh(cells - 1) || keepsMesh(cells)
                          : keepsMesh(old - 1));
    }
  }
  return kept;
}

} // namespace

SectorLists gatherSectors(const NetFans& fans, const std::vector<int>& indices, const Ranks& ranks,
  const std::function<std::vector<double>(int i, int k)>& listOf)
{
  std::vector<std::pair<int, int>> sectors;
  for (std::size_t i = 0; i < indices.size(); ++i)
  {
    for (std::size_t k = 0; k < fans.all[indices[i]].sectors.size(); ++k)
    {
      sectors.emplace_back(static_cast<int>(i), static_cast<int>(k));
    }
  }
  auto lists = gatherListsFromOwners<double>(
    ranks, sectors.size(),
    [&](std::size_t s) {
      return fans.complex.blocks[fans.all[indices[sectors[s].first]].sectors[sectors[s].second].block].rank;
    },
    [&](std::size_t s) { return listOf(sectors[s].first, sectors[s].second); });
  SectorLists result(indices.size());
  for (std::size_t s = 0; s < sectors.size(); ++s)
  {
    result[sectors[s].first].push_back(std::move(lists[s]));
  }
  return result;
}

NetLayers::NetLayers(const ConversionContext& context, const NetFans& fans, const Ranks& ranks)
  : Fans(fans)
{
  std::vector<int> all(fans.all.size());
  std::iota(all.begin(), all.end(), 0);
  this->Lists = gatherSectors(fans, all, ranks, [&](int f, int k) {
    const NetFan& fan = fans.all[f];
    const FanSector& sector = fan.sectors[k];
    const std::vector<bool> kept = keptLayers(context, fan, sector);
    const SectorPlaces places(context, sector);
    std::vector<double> list(LayerSize * fan.layers);
    double* to = list.data();
    for (int layer = 0; layer < fan.layers; ++layer)
    {
      *to++ = kept[layer] ? 1.0 : 0.0;
      for (int j = 0; j <= NetReach; ++j)
      {
        for (int i = 0; i <= NetReach; ++i, to += 3)
        {
          Eigen::Map<Vec3>{ to } = context.controlPoint(sector.block, places(layer, i, j));
        }
      }
    }
    return list;
  });
  // A layer that ends at the next fan is a layer of that, too, and both must agree.
  for (int f = 0; f < static_cast<int>(fans.all.size()); ++f)
  {
    const NetFan& fan = fans.all[f];
    this->Joined.emplace_back();
    for (int layer = 0; layer < fan.layers; ++layer)
    {
      const int end = fan.endAt(layer);
      const FanEnd next = end >= 0 ? fans.beyond({ f, end }).at : FanEnd{};
      this->Joined[f].push_back(
        this->canJoin(f, layer) && (next.fan < 0 || this->canJoin(next.fan, fans.all[next.fan].endLayer(next.end))));
    }
  }
}

bool NetLayers::canJoin(int f, int layer) const
{
  const NetFan& fan = this->Fans.all[f];
  return layer >= fan.skipped[0] && layer < fan.layers - fan.skipped[1] && !fan.isGivenUp(layer) &&
    std::none_of(this->Lists[f].begin(), this->Lists[f].end(),
      [&](const std::vector<double>& list) { return list[LayerSize * layer] != 0.0; });
}

std::vector<Vec3> NetLayers::net(int fan, int layer) const
{
  const LocalNetShape& shape = this->Fans.all[fan].shape;
  std::vector<Vec3> net(shape.size());
  shape.forPoints([&](int a, int k, int i, int j) { net[a] = this->point(fan, layer, k, i, j); });
  return net;
}

} // namespace bsv
