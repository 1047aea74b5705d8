// SPDX-License-Identifier: BSD-3-Clause
/// @file NURBSSurfaceFile.h
/// Files of untrimmed NURBS patches: STEP, IGES, GoTools `.g2` (class 200).
#pragma once

#include "Formats/SurfacesToWrite.h"

#include <string>
#include <vector>

namespace bsv
{

/// Writes the patches in the format that the file's extension names: step, stp, igs, iges (CADOutput.h) or g2, which
/// has no names, units and joins, and in which numbers are the shortest that read back to the same double.
/// @param metres per unit of the points.
/// @param[in,out] notes gets one sentence for each thing that the format cannot hold.
/// @throws Error for another extension, what writeCAD() refuses, and what AtomicFile refuses.
void writeNURBSSurfaceFile(const SurfacesToWrite& surfaces, const std::string& fileName, double metres,
  const Execution& run, std::vector<std::string>& notes);

} // namespace bsv
