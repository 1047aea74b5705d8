// SPDX-License-Identifier: BSD-3-Clause
/// @file CADOutput.h
/// Sewn NURBS patches as STEP (AP214) and IGES 5.3 files, through OpenCASCADE.
#pragma once

#include "Formats/LibraryFile.h"
#include "Formats/SurfacesToWrite.h"

#include <array>
#include <string>
#include <tuple>
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
  AtomicFile& file, const Execution& run, std::vector<std::string>& notes);

/// What is asked of OpenCASCADE, in a process of its own (LibraryFile.h). close() gives the content of the file.
class CADLibrary
{
public:
  static constexpr const char* Name = "CAD";
  static constexpr auto methods() { return std::make_tuple(&CADLibrary::patch, &CADLibrary::joins, &CADLibrary::kind); }

  CADLibrary(const std::string&, const std::string&) {}

  void patch(const std::string& name, const std::array<int, 2>& degree, const std::vector<double>& knotsU,
    const std::vector<double>& knotsV, const std::vector<Vec3>& points, const std::vector<double>& weights);
  void joins(const std::vector<PatchJoin>& joins);
  void kind(CADFormat format, double metres, const std::string& name);
  std::string close();

private:
  SurfacesToWrite Surfaces;
  CADFormat Format = CADFormat::STEP;
  double Metres = 1.0;
  std::string Part;
};

} // namespace bsv
