// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/NetPoints.h"

namespace bsv
{

std::vector<NetCopy> copiesHere(
  const ConversionContext& context, const NetFan& fan, int layer, const LocalNetShape& shape)
{
  std::vector<NetCopy> copies;
  copies.reserve(shape.sectors * (shape.reach + 1) * (shape.reach + 1));
  for (int k = 0; k < shape.sectors; ++k)
  {
    const int block = fan.sectors[k].block;
    if (context.isHere(block))
    {
      const SectorPlaces places(context, fan.sectors[k]);
      shape.forSector(k, [&](int point, int i, int j) {
        if (point > 0)
        {
          copies.push_back({ point, block, places(layer, i, j) });
        }
      });
    }
  }
  // At the ends the spokes are edges, at which more blocks may meet: their points lie in the layers along these.
  const int end = fan.endAt(layer);
  for (int k = 0; k < shape.spokes() && end >= 0; ++k)
  {
    const auto [sector, which] = fan.spoke(k);
    const ComplexBlock& block = context.complex.blocks[sector->block];
    const int edge = sector->spokeEdge(which, end), d = edgeDirection(edge);
    const int start = sector->side(d) ^ (block.edgeReversed[edge] ? 1 : 0);
    for (const EdgeUse& use : context.complex.edges[block.edges[edge]].uses)
    {
      if (!context.isHere(use.block))
      {
        continue;
      }
      const SectorPlaces places(context, sectorAt(use, faceAxis(2 * edgeDirection(use.edge), 0)));
      for (int i = 1; i <= shape.reach; ++i)
      {
        copies.push_back(
          { shape.spoke(k, i), use.block, places(context.endPosition(sector->block, d, start, i), 0, 0) });
      }
    }
  }
  return copies;
}

void writeJoined(const ConversionContext& context, int block, Index place, const Vec3& point)
{
  context.controlPoint(block, place) = point;
  std::uint8_t& rule = context.nets[block].rules[place];
  if (rule == static_cast<std::uint8_t>(ControlPointRule::Copied) ||
    rule == static_cast<std::uint8_t>(ControlPointRule::Regular))
  {
    rule = static_cast<std::uint8_t>(ControlPointRule::ExtraordinaryEdge);
  }
}

} // namespace bsv
