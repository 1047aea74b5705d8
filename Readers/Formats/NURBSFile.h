// SPDX-License-Identifier: BSD-3-Clause
/// @file NURBSFile.h
/// Reads trimmed NURBS surfaces from files: GoTools `.g2`, and IGES, STEP and BREP where OpenCASCADE was found.
///
/// Sources: GoTools' description of its file format (class 200); the other formats are left to OpenCASCADE.
#pragma once

#include "Body/NURBSSurface.h"

#include <string>
#include <utility>
#include <vector>

namespace bsv
{

/// Triangles on the trimmed patches of a body. A vertex belongs to one patch and lies on it exactly.
struct BodyTessellation
{
  struct Vertex
  {
    int patch;
    double u, v;
  };
  std::vector<Vertex> vertices;
  std::vector<std::array<int, 3>> triangles;
};

struct NURBSFileContent
{
  /// "GoTools g2", "IGES", "STEP" or "BREP".
  std::string format;
  /// Metres per unit of the coordinates as the file declares it; 0 if it does not.
  double unit = 0.0;
  /// Coordinates are the numbers of the file.
  std::vector<BodyPatch> patches;
  /// Layer (IGES level, STEP presentation layer) per patch; may be empty.
  std::vector<std::string> layers;
  BodyTessellation tessellation;
  /// What the file holds besides surfaces and was left out: name and count.
  std::vector<std::pair<std::string, int>> others;
  /// Patches that the format stores as a kind of surface with no exact NURBS form (offset surfaces).
  int approximated = 0;
  std::vector<std::string> warnings;
};

/// Reads a file; its format is found from its first bytes.
/// @param tolerance largest distance of the tessellation from the surface, as a fraction of the body's size; > 0.
/// @throws Error naming the file (and, for `.g2`, the line) for whatever is wrong with it, or if it holds no surface.
NURBSFileContent readNURBSFile(const std::string& fileName, double tolerance, const Execution& run = {});

/// Format of a file as NURBSFileContent::format, or empty if it is none of them.
std::string formatOfNURBSFile(const std::string& fileName);

/// Whether IGES, STEP and BREP can be read.
bool canReadCADFiles();

/// IGES, STEP or BREP: readNURBSFile() without the search for the format, in this process, which a damaged file may end
/// in OpenCASCADE. @throws Error; always without OpenCASCADE.
NURBSFileContent readCADFile(
  const std::string& fileName, const std::string& format, double tolerance, const Execution& run);

/// GoTools `.g2`, from its text. Spline surfaces (class 200) only; curves (100) are left out, all else is refused.
/// Knots, weights and points of polynomial surfaces are the file's numbers; the points of rational ones, which the
/// format stores multiplied by their weights, are divided by them.
NURBSFileContent parseG2(const std::string& text, const std::string& fileName, const Execution& run = {});

/// Triangles of an untrimmed patch: a grid fine enough for the tolerance (a length).
void tessellateDomain(const NURBSSurface& surface, int patch, double tolerance, BodyTessellation& tessellation);

} // namespace bsv
