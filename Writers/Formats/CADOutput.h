// SPDX-License-Identifier: BSD-3-Clause
/// @file CADOutput.h
/// Sewn NURBS patches as STEP (AP214) and IGES 5.3 files, through OpenCASCADE.
#pragma once

#include "Formats/SurfacesToWrite.h"
#include "IO/AtomicFile.h"

#include <string>
#include <vector>

namespace bsv
{

enum class CADFormat
{
  STEP,
  IGES
};

/// Writes a face per patch and a shell per set of patches that are sewn together. An edge is one curve, the same for
/// both faces at it. In STEP the faces are advanced faces of shell-based surface models, in IGES they are faces (510)
/// of shells (514), on B-spline surfaces (128) either way. Numbers have 17 digits, which read back to the same double;
/// below 1e-99 they become 0.
///
/// Names of patches are those of the faces: STEP encodes what is not ASCII, IGES keeps UTF-8, in a name property (form
/// 15 of entity 406) and, the first eight letters, in the label.
///
/// The same input gives the same bytes: the files say the time of the environment variable SOURCE_DATE_EPOCH (seconds
/// since 1970, UTC), or 1970-01-01 without it.
/// @param metres per unit of the points: 1, 0.01, 0.001, 1e-6, 1000, 0.0254 or 0.3048.
/// @param name of the file, without folder and extension: that of the part.
/// @throws Error for surfaces that OpenCASCADE refuses, naming the patch, points beyond 1e99, another unit, or if this
/// library was built without OpenCASCADE.
void writeCAD(const SurfacesToWrite& surfaces, CADFormat format, double metres, const std::string& name,
  AtomicFile& file, std::vector<std::string>& notes);

} // namespace bsv
