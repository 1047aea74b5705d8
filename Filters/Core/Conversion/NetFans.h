// SPDX-License-Identifier: BSD-3-Clause
/// @file NetFans.h
/// What is joined exactly G1: the fans around edges and wall vertices whose layers have local nets (LocalNet.h), how
/// the fan of one edge continues that of another, and what of the wall is joined at their ends.
#pragma once

#include "Conversion/ConversionContext.h"
#include "Conversion/LocalNet.h"

#include <array>
#include <vector>

namespace bsv
{

/// A span by its block and the first of its control points per direction, in the nets with double knots.
struct JoinedSpan
{
  int block;
  Ijk first;
};

/// Index of the last points of local nets along their spokes; only the fit of the wall reaches further.
constexpr int NetReach = 3;
/// Control layers next to a singular node that stay as they are.
constexpr int NodeLayers = 4;

/// The layers of control points around an edge, or the one layer of the wall around a vertex: the sectors are then
/// those of block edges that leave the wall.
struct NetFan : EdgeFan
{
  int edge = -1; ///< -1: around a vertex
  /// At the start and the end of the edge.
  std::array<int, 2> vertices{ -1, -1 };
  LocalNetShape shape = {};
  int layers = 1;
  /// Cells along every spoke.
  std::vector<int> cells = {};
  /// Layers that stay at either end.
  std::array<int, 2> skipped{ 0, 0 };
  /// The layers next to spans to avoid; empty: there are none.
  std::vector<bool> givenUp = {};

  bool isGivenUp(int layer) const { return !this->givenUp.empty() && this->givenUp[layer]; }
  int endLayer(int end) const { return end == 0 ? 0 : this->layers - 1; }
  /// The end that a layer is at, or -1.
  int endAt(int layer) const { return layer == 0 ? 0 : layer == this->layers - 1 ? 1 : -1; }
};

/// The start (0) or end (1) of a fan's edge.
struct FanEnd
{
  int fan = -1; ///< -1: none
  int end = 0;

  bool operator==(const FanEnd& other) const { return this->fan == other.fan && this->end == other.end; }
};

/// A smooth group of the wall's sectors between two creases, at an end of a closed fan.
struct WallGroup
{
  FanEnd at;
  int first; ///< spoke of the fan
  LocalNetShape shape;
};

/// How a fan goes on beyond an end: the end of the fan behind it and, per sector, the sector of that across.
struct Continuation
{
  FanEnd at;
  std::vector<int> sectors;
};

struct NetFans
{
  const BlockComplex& complex;
  std::vector<NetFan> all;
  /// Per edge of the complex, or -1.
  std::vector<int> fanOfEdge;
  /// Extraordinary vertices that are fitted.
  std::vector<FanEnd> wallVertices;
  std::vector<WallGroup> groups;

  int vertexOf(const FanEnd& at) const { return this->all[at.fan].vertices[at.end]; }
  /// The fan behind an end, if it lies across all sectors.
  Continuation beyond(const FanEnd& at) const;
};

/// The same on all ranks.
/// @param avoid spans next to which layers are given up; what is carried into these is left out.
/// @param joinNothing all layers are given up.
NetFans findNetFans(const ConversionContext& context, const std::vector<JoinedSpan>& avoid, bool joinNothing);

} // namespace bsv
