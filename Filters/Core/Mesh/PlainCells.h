// SPDX-License-Identifier: BSD-3-Clause
/// @file PlainCells.h
/// The part of checking a mesh that looks at every cell, at the speed of memory.
#pragma once

#include "Base/Types.h"
#include "Mesh/GridView.h"

namespace bsv
{

/// Relative size, squared, below which a cell corner's area or volume is zero.
constexpr double FlatSquared = 1e-24;

struct PlainCells
{
  /// +1 or -1: all points are finite, no edge is as short as asked, and all corner Jacobians of all cells have this
  /// sign by a margin of more than FlatSquared. 0: this does not hold, or holds too narrowly for this quick look.
  int sign = 0;
  /// Sum of all corner Jacobians, eight times the volume; only if all cells are plain.
  double volume = 0.0;
};

/// Looks at the cells of the layers k = begin .. end - 1 of a grid, whole rows of cells at once.
PlainCells plainCells(const GridView& points, int begin, int end, double zeroLengthSquared);

} // namespace bsv
