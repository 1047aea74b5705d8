// SPDX-License-Identifier: BSD-3-Clause
/// @file WallSpacing.h
/// The wall spacing c of (5.44) at each wall vertex with which the first cell of the sampled volume has a given y+.
#pragma once

#include "Conversion/Conversion.h"
#include "Wall/FlowConditions.h"

#include <string>
#include <vector>

namespace bsv
{

struct WallSpacingOptions
{
  FlowConditions flow;
  /// Direction of the free stream, not zero.
  Vec3 direction = Vec3(1.0, 0.0, 0.0);
  /// Nearer to the leading edge than this fraction of the reference length the formulas of the flat plate are taken at
  /// this distance. Range > 0.
  double minimumDistance = 0.01;
  /// Height of the first cell in wall units, > 0.
  double targetYPlus = 1.0;
  /// Sampling level at which it shall be so: every span is cut into 2^level cells. Range [0, MaxSamplingLevel].
  int level = 1;
  /// Largest ratio of neighbouring sampled cells in the first two spans off the wall, > 1.
  double maximumGrowth = 1.2;
};

/// One value per wall vertex in all lists. Where the mesh is on several ranks these are the vertices of the wall faces
/// of this rank's blocks; numbers that are no lists are those of all ranks.
struct WallSpacingResult
{
  /// Wall face of a block of the complex: numbers of its mesh points, in the face's axes, s fastest.
  struct Side
  {
    int block;
    int face;
    std::vector<Index> vertices;
  };
  std::vector<Side> sides;

  std::vector<Vec3> points;
  /// 0 for vertices that a lower rank has, too: with these left out every vertex is counted once.
  std::vector<char> counted;
  /// Boundary layer of a flat plate at the distance from the foremost wall point of the same boundary, measured along
  /// the direction of the stream; at a vertex of several boundaries the smallest distance.
  std::vector<PlateLayer> layers;
  std::vector<double> spacing;     ///< c
  std::vector<double> firstHeight; ///< length of the first sampled cell's edge off the wall
  std::vector<double> yPlus;       ///< of that
  std::vector<double> growth;      ///< largest ratio of neighbouring sampled cells in the first two spans
  std::vector<double> cells;       ///< sampled cells inside the boundary layer, the last one in part
  /// Whether the growth allows the target here, at the level asked for.
  std::vector<char> allowed;
  /// Smallest sampling level at which a c reaches the target within the growth, or -1.
  std::vector<int> reachingLevel;

  /// c at every mesh point of a block of the mesh, i fastest, NaN off the wall; empty for blocks without a wall, and
  /// for those on other ranks.
  std::vector<std::vector<double>> spacingPoints;

  Index wallPoints = 0;
  /// Vertices where the target is met within `Accuracy`.
  Index reached = 0;
  /// Smallest level at which the growth allows the target at all vertices, or -1.
  int levelForAll = -1;
  /// Layers of constant growth, the first sampled cell being the target, that reach it in the blocks at the wall where
  /// it is farthest away, at the level asked for; 0 if there is no need, or over 2000.
  int layersForAll = 0;
  /// What would help where it is not; empty if it is everywhere.
  std::string warning;

  static constexpr double Accuracy = 0.01;
};

/// The mesh's wall (roles in `conversion`) is converted again and again with c per vertex until the sampled cells are
/// as high as they shall be: c at one vertex acts on its neighbours, by the rules in the layers. Where the target would
/// need cells that grow faster than allowed, c goes as far as they allow. Collective.
/// @throws Error for options out of range or a mesh without a wall; Aborted.
WallSpacingResult wallSpacing(const BlockMesh& mesh, const BlockComplex& complex, const ConversionOptions& conversion,
  const WallSpacingOptions& options, const Execution& run = {});

} // namespace bsv
