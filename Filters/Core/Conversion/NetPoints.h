// SPDX-License-Identifier: BSD-3-Clause
/// @file NetPoints.h
/// Where the blocks have the control points of the layers of fans, and writing them.
#pragma once

#include "Conversion/NetFans.h"

#include <vector>

namespace bsv
{

/// Places of the control points of a sector in the net of its block.
class SectorPlaces
{
public:
  SectorPlaces(const ConversionContext& context, const FanSector& sector)
  {
    const auto place = [&](int layer, int i, int j) {
      const int along = context.endPosition(sector.block, sector.along, sector.reversed ? 1 : 0, layer);
      return context.index(sector.block, context.besideEdge(sector, along, i, j));
    };
    this->Start = place(0, 0, 0);
    this->Steps = { place(1, 0, 0) - this->Start, place(0, 1, 0) - this->Start, place(0, 0, 1) - this->Start };
  }

  /// Of point `i` along the first spoke and `j` along the second.
  Index operator()(int layer, int i, int j) const
  {
    return this->Start + layer * this->Steps[0] + i * this->Steps[1] + j * this->Steps[2];
  }

private:
  Index Start;
  std::array<Index, 3> Steps;
};

struct NetCopy
{
  int point; ///< of a local net
  int block;
  Index place;
};

/// The points of a layer, but for its centre, in all blocks of this rank that share them. A copy of a spoke can come
/// twice.
std::vector<NetCopy> copiesHere(
  const ConversionContext& context, const NetFan& fan, int layer, const LocalNetShape& shape);

/// Writes a control point into a block of this rank, with the rule of those that joins change.
void writeJoined(const ConversionContext& context, int block, Index place, const Vec3& point);

} // namespace bsv
