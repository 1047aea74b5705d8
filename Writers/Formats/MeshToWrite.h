// SPDX-License-Identifier: BSD-3-Clause
/// @file MeshToWrite.h
/// A block mesh made ready for file formats: every part of a block face is in exactly one interface or boundary.
#pragma once

#include "Mesh/BlockMesh.h"

#include <string>
#include <vector>

namespace bsv
{

struct BlockToWrite
{
  /// All points of the block; elsewhere() on other ranks.
  GridView points;
  int rank = 0;
  std::string name;
  /// Points that are written per direction: every `step`-th.
  Ijk counts{ 0, 0, 0 };
  int step = 1;
  /// iblank of all points, i fastest, or null.
  const int* iblank = nullptr;
  /// Whether the directions i, j, k are a left-handed frame.
  bool leftHanded = false;

  Index size() const { return Index(this->counts[0]) * this->counts[1] * this->counts[2]; }
  int cells(int direction) const { return this->counts[direction] - 1; }
  Index cellCount() const { return Index(this->cells(0)) * this->cells(1) * this->cells(2); }
  /// Point (i, j, k) of those that are written.
  Vec3 at(int i, int j, int k) const { return this->points(i * this->step, j * this->step, k * this->step); }
  /// Calls visit(x, stride) with the coordinates of the first of the written points (0.., j, k) and the distance, in
  /// numbers, to those of the next. They are float or double, as stored.
  template <typename Visit>
  void row(int j, int k, const Visit& visit) const
  {
    const Index stride = 3 * this->step * this->points.stride(0);
    if (this->points.isFloat())
    {
      visit(this->points.address<float>(0, j * this->step, k * this->step), stride);
    }
    else
    {
      visit(this->points.address<double>(0, j * this->step, k * this->step), stride);
    }
  }
  /// iblank of point (i, j, k) of those that are written; 1 where there is none.
  int blank(int i, int j, int k) const
  {
    return this->iblank ? this->iblank[this->points.place({ i * this->step, j * this->step, k * this->step })] : 1;
  }
};

struct MeshToWrite
{
  std::vector<BlockToWrite> blocks;
  /// Ranges count the points that are written.
  std::vector<Interface> interfaces;
  /// Everything that is in no interface; the tag is -1 where it has no name.
  std::vector<BoundaryPatch> boundaries;
  std::vector<std::string> boundaryNames;
  /// CGNS names, one per boundary name.
  std::vector<std::string> boundaryTypes;
  /// Metres per unit of length, or 0 if that is not known.
  double lengthUnit = 0.0;
  /// What was decided for the user, one sentence each.
  std::vector<std::string> notes;

  Index pointCount() const;
  Index cellCount() const;
  /// Whether all points are in single precision.
  bool isFloat() const;
  /// Quadrilaterals in boundaries without a name.
  Index unnamedQuads() const;
  std::string label(std::size_t block) const;
};

/// Takes the mesh apart. Interfaces that are not declared are found from coincident points; what of a declared boundary
/// is in an interface is left out of it. Collective.
/// @param iblank per block, null where there is none.
/// @throws Error for ranges that leave their faces, and what buildBlockComplex() refuses.
MeshToWrite meshToWrite(const BlockMesh& mesh, const std::vector<const int*>& iblank, const Execution& run);

/// The mesh of every `step`-th point.
/// @throws Error if the number of cells of a block, or an end of a contact or boundary, is no multiple of `step`.
MeshToWrite coarsened(const MeshToWrite& mesh, int step);

/// The CGNS type of a boundary by its name: that type itself, what solvers and mesh generators call walls, symmetry
/// planes, far fields, inflows and outflows; else BCTypeUserDefined.
std::string typeOfBoundary(const std::string& name);

/// A type for every name: the given one, or else that of the name.
std::vector<std::string> completeTypes(const std::vector<std::string>& names, const std::vector<std::string>& types);

/// Names that a format allows, in the order of `names`, all different: letters, digits and what `allowed` lists; others
/// become underscores, and numbers are added to names that would be equal or longer than `longest`.
std::vector<std::string> allowedNames(
  const std::vector<std::string>& names, const std::string& allowed, std::size_t longest);

/// What is said of cells that are turned over if their faces are flat (Mesh/FlatFaces.h), or nothing. Collective.
std::string turnedCellsNote(const MeshToWrite& mesh, const Execution& run);

/// First cell heights at a type of boundaries.
struct FirstCells
{
  double smallest = 0.0;
  double mean = 0.0;
  double largest = 0.0;
  Index count = 0;
};

/// Lengths of the mesh edges off all points of boundaries of type BCWall*. Collective.
FirstCells firstCells(const MeshToWrite& mesh, const Execution& run);

} // namespace bsv
