// SPDX-License-Identifier: BSD-3-Clause
/// @file CGNSFile.h
/// A CGNS file that is being written through the CGNS library.
#pragma once

#include "IO/AtomicFile.h"

#include <vtk_cgns.h>
// clang-format off
#include VTK_CGNS(cgnslib.h)
// clang-format on

#include <string>
#include <vector>

namespace bsv
{

/// Opens the temporary path of an AtomicFile for the library, and hands it back complete. Not to be used from several
/// threads, nor two at a time: the library keeps its state in static variables.
class CGNSFile
{
public:
  /// @param bytes of the arrays. @param nodes no fewer than the file will have
  /// @throws FileError if there is no room for them. What the library cannot write to a file that must not become
  /// longer (RLIMIT_FSIZE), it cannot let go of either: it would be of no use for the rest of the process.
  CGNSFile(AtomicFile& file, double bytes, double nodes);
  ~CGNSFile();
  CGNSFile(const CGNSFile&) = delete;
  CGNSFile& operator=(const CGNSFile&) = delete;

  /// The library's number of the file.
  int number() const { return this->Number; }
  /// @throws Error with the library's message unless `status` is that of success. @param what was being written.
  void check(int status, const std::string& what) const;
  /// Closes the file and sets the version that it says it was written by.
  void close();

private:
  AtomicFile& File;
  int Number = 0;
  bool Open = false;
};

/// Family names of the boundaries, unique and as CGNS allows them, and the library's number of a type.
std::vector<std::string> familyNames(const std::vector<std::string>& names);
CGNS_ENUMT(BCType_t) boundaryConditionType(const std::string& name);

/// Writes the families with their types.
void writeFamilies(
  const CGNSFile& file, int base, const std::vector<std::string>& families, const std::vector<std::string>& types);
/// Writes the unit of length, if it is known: metres per unit, or 0. @return false if CGNS has no such unit.
bool writeUnits(const CGNSFile& file, int base, double lengthUnit);

} // namespace bsv
