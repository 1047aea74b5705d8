// SPDX-License-Identifier: BSD-3-Clause
/// @file VolumeParts.h
/// The parts of a volume between knots at which it is continuous only: as blocks of their own.
#pragma once

#include "Mesh/BlockMesh.h"
#include "Volume/BSplineVolume.h"

#include <array>
#include <vector>

namespace bsv
{

struct VolumeParts
{
  /// Of each block in its order, u fastest. Knots keep their values.
  std::vector<BSplineVolume> volumes;
  /// Those of the blocks, part by part, then those inside blocks. Whole faces; ranges are not set.
  std::vector<Interface> interfaces;
  /// Per part: its block, its number there, and its first control point there.
  std::vector<int> blocks;
  std::vector<int> numbers;
  std::vector<Ijk> first;
  /// Points and weights of blocks of several parts.
  std::vector<std::vector<double>> memory;
};

/// Cuts blocks of degree 2 or more at inner knots of multiplicity `degree`; where a neighbour has none in the same
/// place the block stays whole there. Without such knots the volumes are those that were given. The same on all ranks.
/// @param interfaces whole-face contacts; their ranges are not used
VolumeParts cutAtRepeatedKnots(const std::vector<BSplineVolume>& volumes, const std::vector<Interface>& interfaces);

} // namespace bsv
