// SPDX-License-Identifier: BSD-3-Clause
/// @file FlatFaces.h
/// Cells as finite volume programs see them: with faces of flat triangles.
#pragma once

#include "Mesh/BlockTopology.h"
#include "Mesh/GridView.h"

#include <functional>
#include <string>
#include <vector>

namespace bsv
{

/// Cells that are turned over if their faces are flat: a face is the four triangles from its edges to the mean of its
/// corners, and the centroid of the cell is not on the inner side of all six. These are the face pyramids of OpenFOAM's
/// checkMesh. Cells that are thinner than their faces along a curved wall are warped become so without any fold of
/// the volume that they are samples of; collapsed faces are on no side of anything and count, too.
struct TurnedCells
{
  Index count = 0;
  /// The first of them, i fastest, if there is one.
  Ijk first{ 0, 0, 0 };
};

/// The turned cells of the block of every `step`-th point, whatever its handedness. In parallel over layers.
/// @throws Aborted
TurnedCells turnedCells(const GridView& points, int step, const Execution& run);

/// What is said of the turned cells of all blocks; nothing if there are none.
std::string turnedCellsNote(
  const std::vector<TurnedCells>& blocks, const std::function<std::string(std::size_t block)>& blockName);

} // namespace bsv
