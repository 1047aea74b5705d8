// SPDX-License-Identifier: BSD-3-Clause
/// @file SpanClasses.h
/// Refinement where it is needed: levels per class of parallel knot spans.
///
/// A class are all spans (block, direction, span) that face each other across interfaces, and again across the next
/// ones: a sheet of the multi-block mesh. Cutting all spans of a class into 2^m parts keeps the samples conforming,
/// without hanging nodes, and each block one structured grid. The samples are bit for bit among those of the uniform
/// level that is the highest one.
#pragma once

#include "Mesh/BlockMesh.h"
#include "Ranks/Ranks.h"
#include "Volume/Sampling.h"

#include <string>
#include <vector>

namespace bsv
{

/// The levels that are asked for. The level of a class is the largest that any of its members is asked to have.
struct LevelRequest
{
  /// Of all spans. Range 0..MaxSamplingLevel.
  int level = 1;

  /// Block faces (block, face) that are walls.
  std::vector<std::array<int, 2>> walls;
  /// Of the spans next to walls, in the direction off them; -1: no request.
  int wallLevel = -1;
  /// How many spans off the wall that is, >= 1.
  int wallLayers = 1;
  /// Of all spans along walls; -1: no request.
  int tangentialLevel = -1;
  /// If > 0: the smallest level off each wall face with which no first cell there is higher than this, in place of
  /// wallLevel. Heights are taken at the knots on the wall.
  double firstCellHeight = 0.0;
  /// If > 0: the smallest level of each sheet across a wall with which no chord between neighbouring samples on a knot
  /// line of the wall is farther from the wall than this, at its middle, in place of tangentialLevel.
  double chordError = 0.0;

  /// Levels of all spans of a block in one direction.
  struct BlockLevel
  {
    int block = 0;
    int direction = 0;
    int level = 0;
  };
  std::vector<BlockLevel> blockLevels;
};

struct ChosenLevels
{
  /// Per block.
  std::vector<SpanLevels> levels;
  /// Number of classes, and how many of them have each level.
  int classes = 0;
  std::vector<int> classesOfLevel;
  /// What the targets led to, and where they cannot be reached, one sentence each.
  std::vector<std::string> notes;
};

/// @param interfaces whole faces; both sides must have the same number of non-empty spans.
/// @param blockName how errors call a block.
/// Collective: the levels are the same on all ranks.
/// @throws Error for levels, blocks and faces out of range, and interfaces whose spans do not match.
ChosenLevels chooseLevels(const std::vector<BSplineVolume>& volumes, const std::vector<Interface>& interfaces,
  const LevelRequest& request, const std::function<std::string(int block)>& blockName, const Execution& run = {});

/// Lengths of the first cells off wall faces at given levels, at all samples of these faces: smallest and largest.
/// Collective. Both 0 without walls.
std::array<double, 2> firstCellHeights(const std::vector<BSplineVolume>& volumes, const std::vector<SpanLevels>& levels,
  const std::vector<std::array<int, 2>>& walls, const Execution& run = {});

} // namespace bsv
