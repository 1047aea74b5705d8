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
#include "Conversion/EntityRules.h"
#include "Conversion/FirstLayer.h"
#include "Conversion/LayerRules.h"
#include "Conversion/MovedPoints.h"

#include <algorithm>
#include <map>
#include <vector>

namespace bsv
{

/// @name Positions in the control net of a direction with `cells` mesh cells
/// From either end 0, 1, .. are the end point and the inserted point; mesh points keep their order between them.
///@{
constexpr int endPosition(int side, int fromEnd, int cells)
{
  return side == 0 ? fromEnd : cells + 2 - fromEnd;
}
constexpr int innerPosition(int meshIndex)
{
  return meshIndex + 1;
}
///@}

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
  Index index(int block, const Ijk& position) const
  {
    const ComplexBlock& owner = this->complex.blocks[block];
    return position[0] + Index(owner.cells(0) + 3) * (position[1] + Index(owner.cells(1) + 3) * position[2]);
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

/// Rule of inserted points off a connection layer, or else off a wall.
inline ControlPointRule layerRule(bool connection)
{
  return connection ? ControlPointRule::FarFieldLayer : ControlPointRule::WallLayer;
}

} // namespace bsv
