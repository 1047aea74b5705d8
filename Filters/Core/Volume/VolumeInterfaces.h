// SPDX-License-Identifier: BSD-3-Clause
/// @file VolumeInterfaces.h
/// Which block faces of a multi-block B-spline volume meet, found from their geometry alone.
#pragma once

#include "Mesh/BlockMesh.h"
#include "Volume/BSplineVolume.h"

#include <functional>
#include <string>
#include <vector>

namespace bsv
{

struct VolumeInterfaceOptions
{
  /// Two faces meet if the distances of their samples are below this fraction of the shortest distance between
  /// neighbouring samples in and under either face. Range (0, 0.5).
  double tolerance = 0.05;
  /// Faces that are known not to meet another one: outer boundaries.
  std::vector<BoundaryPatch> boundaries;
  /// How errors call a block.
  std::function<std::string(int block)> blockName = [](int block) { return "block " + std::to_string(block); };
};

/// All pairs of faces that have the same shape in the same parametrisation, up to one of the eight orientations and an
/// affine change of the parameters of each direction: faces are compared at 5 x 5 points, equally spaced over the range
/// of the knots. Degrees and inner knots may differ. A block may meet itself. Faces collapsed to a curve or point meet
/// nothing. The ranges of the result count the control points of faces A.
/// The volumes must have passed checkBSplineVolume(). Of blocks on other ranks these 5 x 5 points come from there.
/// @throws Error if a face meets more than one other, or samples are not finite.
std::vector<Interface> findVolumeInterfaces(
  const std::vector<BSplineVolume>& volumes, const VolumeInterfaceOptions& options = {}, const Execution& run = {});

/// For whoever joins whole faces only: makes sure that no other faces than those of `interfaces` and of the options'
/// boundaries have spans in common, like the wake of a C-grid in one block, where the ends of a face meet. Spans are
/// the same if their corners and middles are. Of blocks on other ranks these points come from there.
/// @throws Error that names two faces and a place where they meet.
void requireWholeContacts(const std::vector<BSplineVolume>& volumes, const std::vector<Interface>& interfaces,
  const VolumeInterfaceOptions& options = {}, const Execution& run = {});

} // namespace bsv
