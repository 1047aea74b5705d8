// SPDX-License-Identifier: BSD-3-Clause
/// @file CGNSOutput.h
/// Structured CGNS files (HDF5).
#pragma once

#include "Formats/MeshToWrite.h"
#include "IO/FileParts.h"

#include <string>
#include <vector>

namespace bsv
{

/// One zone per block with its coordinates, its interfaces (GridConnectivity1to1_t, from both sides) and boundary
/// conditions (BC_t of type FamilySpecified with the name of a Family_t, which has the type). The unit of length is
/// written if it is known. The file says that it was written by version 3.4 of the library, whose data structures it
/// keeps to: programs of that version refuse files of a later one.
///
/// Many readers sort zones by name. Where the order of the blocks is not that of their names, or a name is no name of
/// a zone (1 to 32 characters, unique, without '/'), zones are called 001_name, 002_name, .. and carry the block's name
/// in a Descriptor_t `BlockName`.
///
/// Rank 0 writes; the others send it the coordinates of their blocks, some layers at a time. Collective.
/// @param[in,out] notes what was changed
/// @throws Error, Aborted
void writeCGNS(const MeshToWrite& mesh, AtomicFile& file, const Execution& run, std::vector<std::string>& notes);

} // namespace bsv
