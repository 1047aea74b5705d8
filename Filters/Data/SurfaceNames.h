// SPDX-License-Identifier: BSD-3-Clause
/// @file SurfaceNames.h
/// Surfaces beside blocks, which name the boundaries of the blocks: what ParaView's readers make of patches.
#pragma once

#include "Data/HexBlockData.h"

#include <vector>

namespace bsv
{

/// Whether a leaf is a surface: vtkPolyData, or a structured grid of one point in one direction.
bool isSurface(vtkDataObject* leaf);

/// Gives faces of blocks the names of the surfaces whose quadrilaterals have the same points, bit for bit. Faces that
/// have a name keep it; where two block faces meet there is no boundary. What fits no face makes a warning. Collective.
void nameBySurfaces(BlockMesh& mesh, const std::vector<NamedLeaf>& surfaces, const Ranks& ranks);

} // namespace bsv
