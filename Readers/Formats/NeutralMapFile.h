// SPDX-License-Identifier: BSD-3-Clause
/// @file NeutralMapFile.h
/// Neutral map files: contacts and boundary conditions beside a multi-block grid file.
///
/// Text, its lines ended as any system does; `#`, `!` and `//` start comments. First the number of blocks, then a line
/// per block: its number and its points per direction. Then a line per contact or boundary condition:
///
///     TYPE  B1 F1 S1 E1 S2 E2  [B2 F2 S1 E1 S2 E2 SWAP]
///
/// Blocks B, faces F and indices count from 1. Faces 1 to 6 are k min, k max, i min, i max, j min, j max. S1..E1 is the
/// range along the face's primary direction, S2..E2 along the secondary one: i and j on k faces, j and k on i faces,
/// k and i on j faces. The second half belongs to TYPE ONE_TO_ONE: S1 of either side meet, E1 too, and SWAP = TRUE says
/// that the primary direction of the first face runs along the secondary one of the second. Ranges that run backwards
/// turn the direction round. Without the flag the sizes decide, or, where these do not, the points.
///
/// Source: W. T. Jones, The Neutral Map File, NASA Langley GEOLAB (now kept at the Turbulence Modeling Resource).
#pragma once

#include "Base/Types.h"
#include "Mesh/BlockMesh.h"

#include <string>
#include <vector>

namespace bsv
{

/// Adds the interfaces and boundaries of the file to `mesh`, whose blocks must be those of the grid file, in its order.
/// A TYPE with one side names a boundary, unless a name stands behind its range. PATCHED (not point to point) and
/// UNPROCESSED say nothing and are skipped. The spelling of ONE_TO_ONE does not matter (case, blanks, dashes,
/// "1-to-1"), a contact may be listed from both sides. Types of boundaries follow from their TYPE (boundaryTypeOfName).
/// @param[out] warnings boundaries that were left out, one sentence per kind.
/// @throws Error naming file and line for anything that is not of the form above, another TYPE with two sides, blocks,
/// faces and ranges of contacts that `mesh` does not have, and contacts whose points do not coincide (see
/// checkContacts).
void readNeutralMap(
  const std::string& fileName, BlockMesh& mesh, std::vector<std::string>& warnings, const Execution& run = {});

} // namespace bsv
