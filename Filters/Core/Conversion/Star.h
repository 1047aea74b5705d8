// SPDX-License-Identifier: BSD-3-Clause
/// @file Star.h
/// The star of a vertex as the rules see it.
#pragma once

#include "Conversion/ConversionContext.h"

#include <array>

namespace bsv
{

/// A vertex star, what the rules must know of it, and the control points that they make.
struct Star : VertexStar
{
  /// Fan of a star edge; star-block index per sector and star-edge index per spoke.
  struct EdgeInfo
  {
    const EdgeFan* fan = nullptr;
    std::vector<int> spokes;
    std::vector<int> sectors;
    bool whole = true; ///< the edge has one fan only
  };

  int vertex = -1;
  /// Where the mesh has the star edges' points, if they are moved.
  std::vector<Vec3> meshEdges;
  bool boundary = false;
  /// Whether it lies in the connection layer of a far-field extension.
  bool connection = false;
  std::vector<EdgeInfo> info;
  /// Weight of the vertex in the inserted point along each star edge.
  std::vector<double> near;
  /// Star faces that keep points near the vertex (FaceRule::keep), and how far at the face's point.
  std::vector<bool> keptFaces;
  std::vector<double> diagonalKeep;

  /// Control points: the centre, and inserted ones along star edges, in star faces, in star blocks.
  Vec3 center;
  std::vector<Vec3> edgePoints, facePoints, blockPoints;
  ControlPointRule rule = ControlPointRule::Regular;
  std::vector<ControlPointRule> edgeRules, faceRules, blockRules;

  /// Whether the outer surface, once converted, has no feature here that a rule across layers would have to respect.
  bool surfaceIsSmooth = false;
  /// Whether it follows a foot point on the body.
  bool hasFoot = false;
  /// The two star edges of a crease through the vertex, or -1.
  std::array<int, 2> crease{ -1, -1 };

  /// Whether kept faces meet at one of the edges so that nothing around it is regular (keptLinesMeet()).
  bool keptFacesMeet() const;
  bool keepsPoints() const
  {
    return std::find(this->keptFaces.begin(), this->keptFaces.end(), true) != this->keptFaces.end();
  }
};

/// Star edges in opposite directions around which the blocks are stacked; -1: none.
struct StackAxes
{
  int up = -1;
  int down = -1;
};

/// The star before any rule; where c varies over walls, points of faces and blocks are moved as in controlFan().
Star makeStar(const ConversionContext& context, int vertex);

/// Control points of the layer k steps away from the vertex, across a star edge.
Fan starLayer(const ConversionContext& context, const Star& star, int starEdge, int k);

StackAxes stackAxes(const ConversionContext& context, const Star& star);
/// Whether the blocks lie in two stacks around these star edges.
bool areStacked(const ConversionContext& context, const Star& star, int up, int down);

} // namespace bsv
