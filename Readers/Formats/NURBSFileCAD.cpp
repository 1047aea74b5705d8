// SPDX-License-Identifier: BSD-3-Clause
// CAD files, by OpenCASCADE, which no other files of the readers include than those behind CADShape.h.
#include "Formats/NURBSFile.h"

#ifndef BSPLINEVOLUME_WITH_OPENCASCADE

namespace bsv
{

bool canReadCADFiles()
{
  return false;
}

NURBSFileContent readCADFile(const std::string& fileName, const std::string& format, double, const Execution&)
{
  throw Error(fileName + ": " + format + " files need OpenCASCADE, without which this program was built");
}

} // namespace bsv

#else

#include "Formats/CADShape.h"
#include "Formats/TextScanner.h"

#include <BRepBndLib.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <Bnd_Box.hxx>
#include <Standard_Failure.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>

#include <cmath>
#include <filesystem>
#include <fstream>

#include <unistd.h>

namespace bsv
{

namespace
{

/// A file for OpenCASCADE, which reads no text from memory; gone with this object.
class TemporaryText
{
public:
  TemporaryText() = default;
  TemporaryText(const TemporaryText&) = delete;
  TemporaryText& operator=(const TemporaryText&) = delete;
  ~TemporaryText()
  {
    if (!this->Name.empty())
    {
      ::unlink(this->Name.c_str());
    }
  }

  /// @param original for the error
  void write(const std::string& text, const std::string& original)
  {
    std::error_code failure;
    std::string name = (std::filesystem::temp_directory_path(failure) / "bsplinevolume-XXXXXX").string();
    const int file = failure ? -1 : ::mkstemp(name.data());
    if (file >= 0)
    {
      this->Name = name;
      ::close(file);
      std::ofstream stream(name, std::ios::binary);
      stream << text;
      stream.close();
      if (stream)
      {
        return;
      }
    }
    throw Error(original + ": a plain copy of it cannot be written to the folder of temporary files");
  }
  const std::string& name() const { return this->Name; }

private:
  std::string Name;
};

/// Largest angle, in radians, between neighbouring chords of the tessellation.
constexpr double TessellationAngle = 0.35;

/// Checks the text of a file and lets OpenCASCADE read it.
cad::Shape readShape(const std::string& fileName, const std::string& format, OpenCASCADESession& session)
{
  STEPEntities entities;
  TemporaryText copy;
  {
    const std::string original = readTextFile(fileName);
    const std::string text = plainCADText(original, format);
    if (text != original)
    {
      copy.write(text, fileName);
    }
    if (format == "STEP")
    {
      entities = checkSTEPText(text, fileName);
    }
    else
    {
      format == "IGES" ? checkIGESText(text, fileName) : checkBREPText(text, fileName);
    }
  }
  const std::string opened = copy.name().empty() ? fileName : copy.name();
  if (format == "IGES")
  {
    return cad::readIGES(opened, fileName, session);
  }
  if (format == "STEP")
  {
    return cad::readSTEP(opened, fileName, entities);
  }
  cad::Shape result;
  BRep_Builder builder;
  if (!BRepTools::Read(result.shape, opened.c_str(), builder) || result.shape.IsNull())
  {
    throw Error(fileName + ": OpenCASCADE cannot read it as a BREP file");
  }
  return result;
}

/// Counts what belongs to no face.
std::vector<std::pair<std::string, int>> looseParts(const TopoDS_Shape& shape)
{
  std::vector<std::pair<std::string, int>> parts;
  const auto count = [&](TopAbs_ShapeEnum kind, TopAbs_ShapeEnum outside, const char* text) {
    TopTools_IndexedMapOfShape found;
    for (TopExp_Explorer at(shape, kind, outside); at.More(); at.Next())
    {
      found.Add(at.Current());
    }
    if (!found.IsEmpty())
    {
      parts.emplace_back(text, found.Extent());
    }
  };
  count(TopAbs_EDGE, TopAbs_FACE, "curve without a face");
  count(TopAbs_VERTEX, TopAbs_EDGE, "point without a face");
  return parts;
}

/// "face 12 'wing'".
std::string labelOf(const cad::Shape& shape, const TopoDS_Face& face, int number)
{
  const std::string name = shape.name(face);
  return "face " + std::to_string(number) + (name.empty() ? "" : " '" + name + "'");
}

/// Gives the faces of a shape triangles. @param tolerance fraction of its size
void tessellate(const TopoDS_Shape& shape, double tolerance)
{
  Bnd_Box box;
  BRepBndLib::Add(shape, box, Standard_False);
  const double size = box.IsVoid() ? 0.0 : std::sqrt(box.SquareExtent());
  if (size > 0.0 && !box.IsOpen())
  {
    BRepTools::Clean(shape);
    BRepMesh_IncrementalMesh(shape, tolerance * size, Standard_False, TessellationAngle, Standard_False);
  }
}

/// @throws Error naming the face at which tessellate() failed with `failure`
[[noreturn]] void failAtFace(const cad::Shape& shape, const TopTools_IndexedMapOfShape& faces, double tolerance,
  const Standard_Failure& failure, const std::string& fileName)
{
  const std::string why = std::string(": ") + failure.GetMessageString();
  for (int f = 1; f <= faces.Extent(); ++f)
  {
    try
    {
      tessellate(faces(f), tolerance);
    }
    catch (const Standard_Failure&)
    {
      throw Error(fileName + ": " + labelOf(shape, TopoDS::Face(faces(f)), f) +
        " cannot be cut out of its surface; do its boundary curves lie on it?" + why);
    }
  }
  throw Error(fileName + ": its faces cannot be cut out of their surfaces" + why);
}

/// Adds face `number`, which the file may hide.
void addFace(
  NURBSFileContent& content, cad::Shape& shape, const TopoDS_Face& face, int number, const std::string& fileName)
{
  if (shape.hidden(face))
  {
    ++shape.dropped[cad::HiddenSurface];
    return;
  }
  const std::string name = shape.name(face);
  const std::string label = labelOf(shape, face, number);
  try
  {
    bool approximated = false;
    BodyPatch patch =
      cad::convertFace(face, static_cast<int>(content.patches.size()), content.tessellation, approximated);
    patch.name = name.empty() ? "Face " + std::to_string(number) : name;
    content.approximated += approximated;
    content.patches.push_back(std::move(patch));
  }
  catch (const Error& error)
  {
    throw Error(fileName + ": " + label + " " + error.what());
  }
  catch (const Standard_Failure& failure)
  {
    throw Error(fileName + ": " + label + " cannot be converted: " + failure.GetMessageString());
  }
  content.layers.push_back(shape.layer(face));
}

} // namespace

bool canReadCADFiles()
{
  return true;
}

NURBSFileContent readCADFile(
  const std::string& fileName, const std::string& format, double tolerance, const Execution& run)
{
  NURBSFileContent content;
  content.format = format;
  OpenCASCADESession session;
  try
  {
    cad::Shape shape = readShape(fileName, format, session);
    content.unit = shape.unit;
    run.report(0.3);
    TopTools_IndexedMapOfShape faces;
    TopExp::MapShapes(shape.shape, TopAbs_FACE, faces);
    if (!faces.IsEmpty())
    {
      try
      {
        tessellate(shape.shape, tolerance);
      }
      catch (const Standard_Failure& failure)
      {
        failAtFace(shape, faces, tolerance, failure, fileName);
      }
      run.report(0.6);
    }
    for (int f = 1; f <= faces.Extent(); ++f)
    {
      addFace(content, shape, TopoDS::Face(faces(f)), f, fileName);
      run.report(0.6 + 0.4 * f / faces.Extent());
    }
    content.others.assign(shape.dropped.begin(), shape.dropped.end());
    for (const auto& loose : looseParts(shape.shape))
    {
      content.others.push_back(loose);
    }
  }
  catch (const Standard_Failure& failure)
  {
    const std::string why = failure.GetMessageString();
    throw Error(fileName + ": OpenCASCADE cannot read it as " + (format == "IGES" ? "an " : "a ") + format + " file" +
      (why.empty() ? "" : ": " + why));
  }
  return content;
}

} // namespace bsv

#endif
