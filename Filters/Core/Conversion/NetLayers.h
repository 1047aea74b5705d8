// SPDX-License-Identifier: BSD-3-Clause
/// @file NetLayers.h
/// The control points of the layers of fans, which all ranks know, and which of the layers are joined.
#pragma once

#include "Conversion/NetFans.h"
#include "Ranks/Ranks.h"

#include <functional>
#include <vector>

namespace bsv
{

/// Lists of numbers per fan, in the order of `fans`, and sector: listOf(i, k) of fans[i], which the rank of sector k
/// makes from its points. Collective; the same on all ranks.
using SectorLists = std::vector<std::vector<std::vector<double>>>;
SectorLists gatherSectors(const NetFans& fans, const std::vector<int>& indices, const Ranks& ranks,
  const std::function<std::vector<double>(int i, int k)>& listOf);

/// Of all fans, as they are before any join. A layer is joined unless it stays at an end of its fan, is given up, or a
/// face behind one of its spokes keeps points.
class NetLayers
{
public:
  /// Collective. `fans` must outlive it.
  NetLayers(const ConversionContext& context, const NetFans& fans, const Ranks& ranks);

  /// Point (i, j) of sector k, up to NetReach.
  Vec3 point(int fan, int layer, int k, int i, int j) const
  {
    return Vec3(this->Lists[fan][k].data() + LayerSize * layer + 1 + 3 * (i + (NetReach + 1) * j));
  }
  /// The local net.
  std::vector<Vec3> net(int fan, int layer) const;
  bool isJoined(int fan, int layer) const { return this->Joined[fan][layer]; }

private:
  bool canJoin(int fan, int layer) const;

  static constexpr std::size_t LayerSize = 1 + 3 * (NetReach + 1) * (NetReach + 1);

  const NetFans& Fans;
  /// Per layer whether it is kept, then its points, i fastest.
  SectorLists Lists;
  std::vector<std::vector<bool>> Joined;
};

} // namespace bsv
