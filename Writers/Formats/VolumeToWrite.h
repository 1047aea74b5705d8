// SPDX-License-Identifier: BSD-3-Clause
/// @file VolumeToWrite.h
/// A multi-block B-spline volume made ready for file formats.
#pragma once

#include "Mesh/BlockMesh.h"
#include "Volume/BSplineVolume.h"
#include "Volume/KnotInsertion.h"

#include <memory>
#include <string>
#include <vector>

namespace bsv
{

struct VolumeToWrite
{
  std::vector<BSplineVolume> volumes;
  std::vector<std::string> names;
  /// Block of the input that each one is, or is a part of.
  std::vector<int> parents;
  /// Whole faces; their ranges are not used.
  std::vector<Interface> interfaces;
  /// One per block face that is in no interface; the tag is -1 where it has no name.
  std::vector<BoundaryPatch> boundaries;
  std::vector<std::string> boundaryNames;
  std::vector<std::string> boundaryTypes;
  /// Whether the directions u, v, w of a block are a left-handed frame.
  std::vector<char> leftHanded;
  /// What was decided for the user, one sentence each.
  std::vector<std::string> notes;
  /// Memory of blocks that were cut.
  std::vector<std::shared_ptr<std::array<OwnedVolume, 2>>> memory;

  std::string label(int block) const { return "block " + std::to_string(block) + " '" + this->names[block] + "'"; }
  bool isRational() const;
};

/// Completes a volume of which everything up to `boundaryTypes` is given, but boundaries only as far as they have
/// names: handedness, the boundaries without a name. Collective.
/// @throws Error for a face in two interfaces or boundaries, or in both.
void completeVolume(VolumeToWrite& volume, const Execution& run);

/// Cuts block `block` at the middle knot of `direction`, or between two knots if it has one span, and all blocks that
/// it faces in this direction, so that all still meet whole face to whole face. Collective.
/// @throws Error if the blocks that face each other have different numbers of spans, or turn the direction round on
/// themselves.
void cutSheet(VolumeToWrite& volume, int block, int direction);

} // namespace bsv
