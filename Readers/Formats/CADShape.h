// SPDX-License-Identifier: BSD-3-Clause
/// @file CADShape.h
/// What the parts of the CAD reader share: entities of files (CADEntities.cpp) become a shape, its faces patches
/// (CADFaces.cpp). Only files that are compiled with OpenCASCADE include this.
#pragma once

#include "Execution/OpenCASCADESession.h"
#include "Formats/CADText.h"
#include "Formats/NURBSFile.h"

#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>

#include <functional>
#include <map>
#include <string>

namespace bsv::cad
{

/// A shape, and what the file says of it.
struct Shape
{
  TopoDS_Shape shape;
  /// Metres; 0 if unknown.
  double unit = 0.0;
  std::function<std::string(const TopoDS_Face&)> name = [](const TopoDS_Face&) { return std::string(); };
  std::function<std::string(const TopoDS_Face&)> layer = [](const TopoDS_Face&) { return std::string(); };
  /// Whether the file hides the face.
  std::function<bool(const TopoDS_Face&)> hidden = [](const TopoDS_Face&) { return false; };
  /// Counts of what is left out.
  std::map<std::string, int> dropped;
};

/// What is counted as left out because the file hides it.
constexpr const char* HiddenSurface = "hidden (blanked) surface";

/// @param opened the file for OpenCASCADE, a plain copy perhaps; `fileName` is for errors
Shape readIGES(const std::string& opened, const std::string& fileName, OpenCASCADESession& session);
Shape readSTEP(const std::string& opened, const std::string& fileName, const STEPEntities& entities);

/// The NURBS form of a face; its triangles, if it has any, become those of `patch`.
/// @param[out] approximated whether the form differs from the face by more than rounding
/// @throws Error that continues "face 12"
BodyPatch convertFace(const TopoDS_Face& face, int patch, BodyTessellation& tessellation, bool& approximated);

} // namespace bsv::cad
