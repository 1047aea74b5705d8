// SPDX-License-Identifier: BSD-3-Clause
/// @file MeshDoctor.h
/// Looks for blocks that should meet and do not, and for other surprises of the outer surface of a complex.
#pragma once

#include "Complex/MeshFindings.h"

#include <string>

namespace bsv
{

/// Examines the boundary faces of a complex that belong to no named boundary.
///
/// Two such faces nearly face each other where the center of a quadrilateral lies before another one that faces it, or
/// all its corners lie near those of the other, closer than 0.6 of the cells there in their own directions. Walls do
/// that, too, where a body is thin: there the surface goes on smoothly beyond the near part, or bends around the edge
/// of the body from one side to the other. If neither side does, it is a near miss.
///
/// An outer face lies in other cells if a ray from it leaves cells more often than it enters them; up to 25
/// quadrilaterals of each face are tried, and all of a face where one does.
///
/// Takes time in proportion to the outer surface. Nothing depends on the numbering of the blocks but the numbers.
/// Collective; all ranks return the same.
MeshDiagnosis diagnose(const BlockComplex& complex, const Execution& run = {});

/// One sentence with block, face, place and figures. @param mesh from which the complex was built, for its names.
std::string describe(const BlockMesh& mesh, const MeshFinding& finding);

/// @throws Error with the number of suspicious findings and the description of the first, if there are any.
void refuseSuspicious(const BlockMesh& mesh, const MeshDiagnosis& diagnosis);

} // namespace bsv
