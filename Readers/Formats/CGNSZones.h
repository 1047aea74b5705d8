// SPDX-License-Identifier: BSD-3-Clause
/// @file CGNSZones.h
/// Zones of CGNS files (ADF or HDF5), with their 1-to-1 interfaces and boundary conditions.
#pragma once

#include "Base/Types.h"
#include "Formats/FaceContact.h"
#include "Formats/GridBlock.h"
#include "Ranks/Piece.h"

#include <string>
#include <vector>

namespace bsv
{

/// An unstructured zone, whose cells are hexahedra.
struct HexZone
{
  std::string name;
  /// Triples x y z; empty if another piece has them, as all the lists below.
  std::vector<double> points;
  /// Eight points per cell, from 0, in the order of CGNS and VTK. Of elements of higher order the corners.
  std::vector<Index> hexahedra;
  struct Boundary
  {
    std::string name;
    std::string type;
    /// Four points per quadrilateral.
    std::vector<Index> quadrilaterals;
  };
  /// One per name: boundary conditions, then the sections of quadrilaterals that belong to none.
  std::vector<Boundary> boundaries;
};

struct CGNSZones
{
  /// One per structured zone, in the order of the file, named like the zone.
  std::vector<GridBlock> blocks;
  /// The first piece has all of them. They meet where points coincide.
  std::vector<HexZone> hexZones;
  /// Each contact once, although both zones declare it. Contacts marked periodic are boundaries named `Periodic`.
  std::vector<Interface> interfaces;
  /// Boundary conditions on block faces. Point lists are cut into rectangles, one patch each; conditions on single
  /// points or lines are skipped.
  std::vector<BoundaryPatch> boundaries;
  /// The family of a boundary condition, or the first of its additional ones; within another family its path. Without
  /// one the condition's own name, or its type if the name is but a number.
  std::vector<std::string> boundaryNames;
  /// BlockMesh::boundaryTypes: the condition's own type, or else that of its family, or of one that this belongs to.
  std::vector<std::string> boundaryTypes;
  /// What was left out, one sentence per kind: boundary conditions that contradict the mesh, bases of other dimensions,
  /// overset and abutting connectivity, holes.
  std::vector<std::string> warnings;
  /// The interfaces with their places in the file, for checkContacts().
  std::vector<DeclaredContact> contacts;
};

/// Whether the file starts like a CGNS file (ADF or HDF5). Never throws.
bool looksLikeCGNS(const std::string& fileName);

/// Reads all zones of all bases, but the coordinates of a piece only: x, y, z, or r, theta, z (radian, or as the file
/// says), which become Cartesian. General (not 1-to-1) connectivity is skipped unless it is periodic: coincident points
/// tell. The points of contacts are not compared. Not to be called from several
/// threads: the CGNS library keeps its state in globals; and a damaged file may end the process in it.
/// @param memory where the points go
/// @param step of cgnsTimes(), whose coordinates are read
/// @throws Error naming file, zone and value: surfaces, elements that are no hexahedra, no or wrong coordinates,
/// contacts whose transforms or ranges do not fit, damaged files; Aborted.
CGNSZones loadCGNS(const std::string& fileName, const Execution& run = {}, const Piece& piece = {},
  const BlockMemory& memory = {}, int step = 0);

/// The times of the steps of the first base that has BaseIterativeData_t with cells of dimension 3: its TimeValues, or
/// else its IterationValues, or else 0, 1, ..; none if it has none. Not to be called from several threads.
/// @throws Error for damaged files
std::vector<double> loadCGNSTimes(const std::string& fileName);

/// The same in a process of its own; none for damaged files.
std::vector<double> cgnsTimes(const std::string& fileName);

/// The same in a process of its own (ReaderJobs.h), so that no file ends this one. Collective.
/// @throws Error for the same, and for contacts whose points do not coincide (see checkContacts); Aborted.
CGNSZones readCGNS(const std::string& fileName, const Execution& run = {}, const Piece& piece = {}, int step = 0);

} // namespace bsv
