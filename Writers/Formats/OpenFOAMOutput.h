// SPDX-License-Identifier: BSD-3-Clause
/// @file OpenFOAMOutput.h
/// OpenFOAM cases: the folder constant/polyMesh.
#pragma once

#include "Formats/MeshToWrite.h"
#include "IO/FileParts.h"

#include <string>
#include <vector>

namespace bsv
{

/// Writes the files points, faces, owner, neighbour and boundary of the case folder that `path`, an empty file with the
/// extension `foam` by which ParaView opens cases, lies in. Points that interfaces join are one point, that of the
/// block with the lowest number. Cells follow the blocks, i fastest; faces are in upper triangular order. A patch per
/// boundary name, of type wall, symmetry or patch, and `defaultFaces` for what has no name.
/// Types: BCWall* are walls; symmetry planes become `symmetry`, which unlike `symmetryPlane` need not be plane.
///
/// Each rank writes the points of its blocks and the faces of their cells. Collective.
/// @param binary raw numbers (label=32, scalar=64) in place of text.
/// @param[in,out] notes what was changed
/// @throws Error for more points or faces than 32 bits count, and collapsed cells, Aborted
void writeOpenFOAM(const MeshToWrite& mesh, FileGroup& files, const std::string& path, bool binary,
  const Execution& run, std::vector<std::string>& notes);

} // namespace bsv
