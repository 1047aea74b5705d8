// SPDX-License-Identifier: BSD-3-Clause
/// @file Plot3DOutput.h
/// PLOT3D grid files and the neutral map files beside them.
#pragma once

#include "Formats/MeshToWrite.h"
#include "IO/FileParts.h"

#include <string>

namespace bsv
{

enum class MeshEncoding
{
  Text,
  Binary,
  Unformatted ///< Fortran records with marks of 4 bytes
};

struct Plot3DOutputOptions
{
  MeshEncoding encoding = MeshEncoding::Binary;
  bool bigEndian = false;
  bool iblank = false;
};

/// Number of blocks, points per direction, and per block all x, all y, all z and, if wanted, iblank; i fastest. Reals
/// have 4 bytes if all blocks are in single precision, else 8; text has the shortest digits that read back to the same
/// double. Collective.
/// @throws Error for records of more than 2^31 - 1 bytes, Aborted.
void writePlot3D(const MeshToWrite& mesh, AtomicFile& file, const Plot3DOutputOptions& options, const Execution& run);

/// The file that Readers/Formats/NeutralMapFile.h describes. Boundaries without a name are left out. Names become words
/// that no reader takes for something else.
/// @param[in,out] notes what was changed
void writeNeutralMap(const MeshToWrite& mesh, AtomicFile& file, const Execution& run, std::vector<std::string>& notes);

} // namespace bsv
