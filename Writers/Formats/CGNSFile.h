// SPDX-License-Identifier: BSD-3-Clause
/// @file CGNSFile.h
/// A CGNS file (HDF5) that is written through the CGNS library, in a process of its own (LibraryFile.h).
#pragma once

#include "Formats/LibraryFile.h"

#include <vtk_cgns.h>
// clang-format off
#include VTK_CGNS(cgnslib.h)
// clang-format on

#include <array>
#include <string>
#include <tuple>
#include <vector>

namespace bsv
{

/// What is asked of the library. The file has one base; its zones are numbered from 1 as they come.
class CGNSLibrary
{
public:
  static constexpr const char* Name = "CGNS";
  static constexpr auto methods()
  {
    return std::make_tuple(&CGNSLibrary::unit, &CGNSLibrary::family, &CGNSLibrary::zone, &CGNSLibrary::description,
      &CGNSLibrary::interface, &CGNSLibrary::boundary, &CGNSLibrary::coordinates<float>,
      &CGNSLibrary::coordinates<double>, &CGNSLibrary::section, &CGNSLibrary::elements, &CGNSLibrary::sides);
  }

  CGNSLibrary(const std::string& path, const std::string& target);
  ~CGNSLibrary();
  CGNSLibrary(const CGNSLibrary&) = delete;
  CGNSLibrary& operator=(const CGNSLibrary&) = delete;

  /// The unit of length, one of the library's.
  void unit(int unit);
  /// @param type the CGNS name of a boundary condition type
  void family(const std::string& name, const std::string& type);
  /// @param size points, cells and 0, per direction of a structured zone
  void zone(const std::string& name, const std::vector<cgsize_t>& size);
  void description(int zone, const std::string& name, const std::string& text);
  /// One side of a 1-to-1 interface; ranges are begin and end.
  void interface(int zone, const std::string& name, const std::string& donor, const std::array<cgsize_t, 6>& range,
    const std::array<cgsize_t, 6>& donorRange, const std::array<int, 3>& transform);
  /// A boundary condition of a family on a range of points, or of faces among the elements.
  void boundary(
    int zone, const std::string& name, const std::string& family, const std::vector<cgsize_t>& range, bool ofFaces);
  /// One coordinate of a range of points.
  template <typename Real>
  void coordinates(int zone, int axis, const std::vector<cgsize_t>& first, const std::vector<cgsize_t>& last,
    const std::vector<Real>& values);
  /// Elements of zone 1 that come in parts, numbered from 1.
  void section(const std::string& name, int type, cgsize_t count);
  void elements(cgsize_t first, cgsize_t last, const std::vector<cgsize_t>& nodes);
  /// Elements that come at once.
  void sides(const std::string& name, int type, cgsize_t first, cgsize_t last, const std::vector<cgsize_t>& nodes);
  /// Closes the file and sets the version that it says it was written by.
  std::string close();

private:
  void check(int status, const std::string& what) const;

  std::string Path;
  std::string Target;
  std::vector<std::string> Zones;
  int Number = 0;
  int Section = 0;
  bool Open = false;
};

using CGNSFile = LibraryFile<CGNSLibrary>;

/// Family names of the boundaries, unique and as CGNS allows them.
std::vector<std::string> familyNames(const std::vector<std::string>& names);

/// Writes the unit of length, if it is known, and the families with their types. What is changed goes into the notes.
/// @param lengthUnit metres per unit, or 0
void writeHeader(CGNSFile& file, double lengthUnit, const std::vector<std::string>& families,
  const std::vector<std::string>& names, const std::vector<std::string>& types, std::vector<std::string>& notes);

} // namespace bsv
