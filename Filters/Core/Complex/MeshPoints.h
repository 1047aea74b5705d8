// SPDX-License-Identifier: BSD-3-Clause
/// @file MeshPoints.h
/// Points of the mesh as entities of the complex, whatever blocks share them.
#pragma once

#include "Complex/BlockComplex.h"

#include <array>
#include <vector>

namespace bsv
{

/// A vertex of the complex (0, vertex, 0, 0, 0), a point of an edge (1, edge, steps from its first vertex, 0, 0), of a
/// face (2, face, s, t of its first block's face, 0), or inside a block (3, block, i, j, k). The same on all ranks.
using MeshPointKey = std::array<int, 5>;

/// A block and a mesh point of it.
struct MeshPointCopy
{
  int block;
  Ijk ijk;
};

MeshPointKey meshPointKey(const BlockComplex& complex, int block, const Ijk& ijk);

/// The point in all blocks that share it; several times in a block that meets itself there.
std::vector<MeshPointCopy> copiesOf(const BlockComplex& complex, const MeshPointKey& key);

/// The points of all cells at a point, itself among them, sorted.
std::vector<MeshPointKey> neighboursOf(const BlockComplex& complex, const MeshPointKey& key);

} // namespace bsv
