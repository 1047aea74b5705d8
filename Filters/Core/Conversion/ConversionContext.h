// SPDX-License-Identifier: BSD-3-Clause
/// @file ConversionContext.h
/// What the rules of the conversion read.
///
/// The control points of a block are those of its interior, copied, and those near its faces, edges and vertices, which
/// other blocks may share. Each rule is a free function that computes the control points owned by one entity and writes
/// them into all blocks of this rank that share it; other ranks do the same for theirs. Different entities may be
/// converted at the same time:
/// - FaceConversion.h: blocks and faces, the regular rule across one face;
/// - EdgeConversion.h: the layers of quadrilaterals across an edge;
/// - VertexConversion.h: the star of a vertex, where layers of several directions meet;
/// - SurfaceConversion.h: the outer surface around a boundary vertex;
/// - BodyPropagation.h: what known points of the body change in the layers above.
#pragma once

#include "Conversion/Conversion.h"
#include "Conversion/CreaseColumns.h"
#include "Conversion/DoubleKnots.h"
#include "Conversion/EntityRules.h"
#include "Conversion/FirstLayer.h"
#include "Conversion/LayerRules.h"
#include "Conversion/MovedPoints.h"

#include <algorithm>
#include <array>
#include <map>
#include <vector>

namespace bsv
{

/// Per vertex of the body: ConversionOptions::projectedPoints and surfaceNormals.
struct GivenFeet
{
  std::map<int, Vec3> points, normals;
};

/// Added to the control points of the layers across an edge: `delta`, in the order of the edge's fan, by a weight per
/// layer.
struct LayerCorrection
{
  Fan delta;
  std::vector<double> weights;
  /// End of the edge where the outer surface moves with the layers, or -1.
  int movedEnd = -1;
};
/// By edge.
using LayerCorrections = std::map<int, std::vector<LayerCorrection>>;

struct ConversionContext
{
  /// That of LocalStars.
  const BlockComplex& complex;
  const ConversionOptions& options;
  const std::vector<ControlNetStorage>& nets;
  int rank;
  const EntityRules& rules;
  const FaceKeeps& keeps;
  const FirstLayer& layer;
  const GivenFeet& given;
  const LayerCorrections& corrections;
  /// If not null, what the rules read in place of the mesh points; all decisions are those of the mesh.
  const MovedPoints* moved = nullptr;
  /// If not null, the nets have room for double knots (DoubleKnots.h).
  const DoubledDirections* doubled = nullptr;

  bool isHere(int block) const { return this->complex.blocks[block].rank == this->rank; }
  bool isWall(int face) const
  {
    return this->complex.faces[face].boundary() && this->rules.faces[face].role == BoundaryRole::Body;
  }
  Vec3 point(int block, const Ijk& ijk) const
  {
    const Vec3 x = this->complex.blocks[block].points(ijk);
    return this->moved ? this->moved->at(block, ijk, x) : x;
  }

  /// @name Positions in the control net of a block
  /// From either end of a direction 0, 1, .. are the end point and the inserted point; mesh points keep their order
  /// between them.
  ///@{
  bool isDoubled(int block, int d) const { return this->doubled && (*this->doubled)[block][d]; }
  int count(int block, int d) const
  {
    return controlPointCount(this->complex.blocks[block].cells(d), this->isDoubled(block, d));
  }
  int endPosition(int block, int d, int side, int fromEnd) const
  {
    return side == 0 ? fromEnd : this->count(block, d) - 1 - fromEnd;
  }
  int innerPosition(int block, int d, int meshIndex) const { return meshIndex + (this->isDoubled(block, d) ? 2 : 1); }
  /// `along` the edge of a sector, `a` from it along the first spoke and `b` along the second.
  Ijk besideEdge(const FanSector& sector, int along, int a, int b) const
  {
    Ijk position;
    position[sector.along] = along;
    position[sector.first] = this->endPosition(sector.block, sector.first, sector.side(sector.first), a);
    position[sector.second] = this->endPosition(sector.block, sector.second, sector.side(sector.second), b);
    return position;
  }
  Index index(int block, const Ijk& position) const
  {
    return position[0] + Index(this->count(block, 0)) * (position[1] + Index(this->count(block, 1)) * position[2]);
  }
  /// In the row (j, k) of a net, first and end of the points that are copies of mesh points for sure.
  std::array<int, 2> copiesInRow(int block, int j, int k) const;
  ///@}

  Eigen::Map<Vec3> controlPoint(int block, Index place) const
  {
    return Eigen::Map<Vec3>(this->nets[block].points + 3 * place);
  }
  void write(int block, const Ijk& position, const Vec3& point, ControlPointRule rule) const
  {
    if (!this->isHere(block))
    {
      return;
    }
    const Index i = this->index(block, position);
    std::copy_n(point.data(), 3, this->nets[block].points + 3 * i);
    this->nets[block].rules[i] = static_cast<std::uint8_t>(rule);
  }
};

inline std::array<int, 2> ConversionContext::copiesInRow(int block, int j, int k) const
{
  // Rules write to the first two points from an end; with double knots joins write to the first `JoinReach` + 1 in two
  // directions.
  const auto isInside = [&](int d, int position, int from) {
    return position >= from && position < this->count(block, d) - from;
  };
  const bool any = this->isDoubled(block, 0) || this->isDoubled(block, 1) || this->isDoubled(block, 2);
  constexpr int Beyond = JoinReach + 1;
  const bool row = isInside(1, j, 2) && isInside(2, k, 2) && (!any || isInside(1, j, Beyond) || isInside(2, k, Beyond));
  const int first = any ? Beyond : 2;
  return { first, row ? std::max(first, this->count(block, 0) - first) : first };
}

/// Rule of inserted points off a connection layer, or else off a wall.
inline ControlPointRule layerRule(bool connection)
{
  return connection ? ControlPointRule::FarFieldLayer : ControlPointRule::WallLayer;
}

} // namespace bsv
