// SPDX-License-Identifier: BSD-3-Clause
/// @file CellFormats.h
/// Files of curved hexahedra of order 2 or 3: Gmsh, HOPR, CGNS.
#pragma once

#include "Formats/CurvedCells.h"
#include "IO/FileParts.h"

#include <string>
#include <vector>

namespace bsv
{

enum class GmshVersion
{
  V2, ///< 2.2
  V4  ///< 4.1
};

/// Gmsh `.msh`, text: hexahedra (type 12 or 92) in the physical volume "volume", quadrilaterals (10 or 36) in a
/// physical surface per boundary name; an elementary volume per block and a surface per boundary patch. All cells are
/// right-handed, sides outward.
///
/// Source: https://gmsh.info/doc/texinfo/gmsh.html, "Gmsh file formats". Collective.
void writeGmsh(const CurvedCells& cells, AtomicFile& file, GmshVersion version, const Execution& run);

/// HOPR's HDF5 mesh (FLEXI, PICLas, Trixi): cells with their sides and neighbours, nodes of every cell with their
/// global numbers, boundary names and types. Boundary types: 4 wall, 2 far field and other outer boundaries, 9 symmetry
/// plane, 1 without a name.
///
/// Source: HOPR's documentation of the mesh format, https://hopr.readthedocs.io. Rank 0 writes. Collective.
/// @param[in,out] notes what was changed
/// @throws Error for more than 2^31 - 1 nodes or sides.
void writeHOPR(const CurvedCells& cells, AtomicFile& file, const Execution& run, std::vector<std::string>& notes);

/// CGNS (HDF5): one unstructured zone of HEXA_27 or HEXA_64, a section of QUAD_9 or QUAD_16 and a boundary condition
/// per boundary name, families with their types.
///
/// Source: SIDS, "Unstructured Grid Element Numbering Conventions", https://cgns.github.io. Rank 0 writes. Collective.
/// @param lengthUnit metres per unit, or 0.
/// @param[in,out] notes what was changed
void writeCGNSCells(
  const CurvedCells& cells, AtomicFile& file, double lengthUnit, const Execution& run, std::vector<std::string>& notes);

/// Values of one rank, on rank 0; the others get nothing back. Collective.
template <typename T>
std::vector<T> onFirstRank(const Ranks& ranks, int owner, std::vector<T> values)
{
  if (owner == 0)
  {
    return values;
  }
  std::vector<std::vector<T>> toRank(ranks.size());
  toRank[0] = std::move(values);
  return std::move(ranks.exchange(std::move(toRank))[owner]);
}

} // namespace bsv
