// SPDX-License-Identifier: BSD-3-Clause
/// @file CGNSInput.h
/// What the parts of the CGNS reader share. CGNSZones.cpp goes through bases and zones; the parts read what a zone has:
/// coordinates (CGNSCoordinates.cpp), cells (CGNSHexZone.cpp), interfaces (CGNSInterfaces.cpp) and boundary conditions
/// (CGNSConditions.cpp, on blocks CGNSBoundaries.cpp).
#pragma once

#include "Formats/CGNSZones.h"

#include "Base/MemoryCheck.h"
#include "Formats/DeclaredConnectivity.h"

#include <vtk_cgns.h>
// clang-format off
#include VTK_CGNS(cgnslib.h)
// clang-format on

#include <array>
#include <map>
#include <string>
#include <vector>

namespace bsv::cgns
{

/// Names are at most 32 characters; paths of families may be longer.
using Name = std::array<char, 1024>;

/// Without blanks at the ends: the library pads some names.
std::string trimmed(const std::string& text);

/// An open file, and what of it is being read.
struct Input
{
  explicit Input(const std::string& name);
  ~Input();
  Input(const Input&) = delete;
  Input& operator=(const Input&) = delete;

  [[noreturn]] void fail(const std::string& what) const;
  /// @throws Error with the library's reason unless `status` is CG_OK
  void check(int status, const std::string& what) const;
  /// The mesh can do without the condition that is being read.
  void leaveOut(const std::string& why);

  const std::string fileName;
  int file = 0;
  int base = 0;
  int zone = 0;
  /// Place for messages: ", base 'Base', zone 'Zone'".
  std::string where;
  Leftovers left;
};

/// An array of the node that cg_goto() went to.
struct DataArray
{
  /// From 1; 0 if there is none of the name.
  int number = 0;
  CGNS_ENUMT(DataType_t) type = CGNS_ENUMV(DataTypeNull);
  int dimensions = 0;
  std::array<cgsize_t, 12> size{};
};
/// @return status of the library
int findArray(const std::string& name, DataArray& found);

//----------------------------------------------------------------------------------------------------------------------

/// Reads the coordinates of zones, which may be cylindrical, of one step.
class Coordinates
{
public:
  Coordinates(Input& input, const BlockMemory& memory, int step)
    : File(input)
    , Memory(memory)
    , Step(step)
  {
  }

  /// Those of the zone that is being read; finite.
  void read(GridBlock& block);
  /// Says what was changed, and units that differ.
  void tell() const;

private:
  bool find(const GridBlock& block);
  void readUnits(int first, int second);
  int gridOfStep() const;
  template <typename Real>
  void read(const GridBlock& block, int grid, Real* points, CGNS_ENUMT(DataType_t) type);
  template <typename Real>
  void readGrid(const GridBlock& block, int grid, Real* points, CGNS_ENUMT(DataType_t) type) const;
  template <typename Real>
  void readFirstGrid(const GridBlock& block, Real* points, CGNS_ENUMT(DataType_t) type) const;

  Input& File;
  const BlockMemory& Memory;
  MemoryDemand Demand{ this->File.fileName, "its points" };
  const int Step;
  /// Of the zone that is being read.
  std::array<std::string, 3> Axes;
  bool Cylindrical = false;
  double ToRadians = 1.0;
  std::vector<std::string> CylindricalZones;
  /// The first zone of every length unit.
  std::map<std::string, std::string> ZoneOfUnit;
};

//----------------------------------------------------------------------------------------------------------------------

struct BoundaryLabel
{
  std::string name;
  std::string type;
};

/// The families of a base.
class Families
{
public:
  void read(Input& input, const std::string& base);

  /// Its name is that of its (first) family, or its own one if that is more than a number; its type is its own one, or
  /// else that of its family. Says if the file has no such family.
  BoundaryLabel label(Input& input, const std::string& own, CGNS_ENUMT(BCType_t) ownType, int condition) const;

private:
  void readNested(const Input& input, const std::string& path, const std::string& family, int depth);
  std::vector<std::string> ofCondition(const Input& input, int condition) const;
  CGNS_ENUMT(BCType_t) typeOf(const std::string& family, int depth = 0) const;
  std::string pathOf(const std::string& name) const;
  void tellUnknown(Input& input, const std::string& family) const;

  std::string Base;
  std::vector<std::string> Names;
  /// By their path from the base.
  std::map<std::string, CGNS_ENUMT(BCType_t)> Types;
  std::map<std::string, std::vector<std::string>> Parents;
};

struct Condition
{
  std::string name;
  CGNS_ENUMT(BCType_t) type;
  CGNS_ENUMT(PointSetType_t) set;
  /// Of points, or of elements.
  cgsize_t count;
  // readPoints():
  CGNS_ENUMT(GridLocation_t) location;
  std::vector<cgsize_t> points;
  BoundaryLabel label;
};

/// Messages are about this condition from here on.
Condition readCondition(Input& input, int number, const std::string& zone);
/// @param size numbers per point
void readPoints(Input& input, const Families& families, int number, int size, Condition& condition);

//----------------------------------------------------------------------------------------------------------------------

/// @param here whether its points and cells are wanted
HexZone readHexZone(Input& input, const Families& families, Coordinates& coordinates, const std::string& name,
  cgsize_t points, bool here);

//----------------------------------------------------------------------------------------------------------------------

/// begin i, j, k, end i, j, k; from 1.
using PointRange = std::array<cgsize_t, 6>;
std::string toString(const PointRange& range);

/// The structured zone that is being read, among the blocks.
struct StructuredZone
{
  Input& input;
  const Families& families;
  /// Names and sizes of all blocks.
  const BlockMesh& mesh;
  /// Of the current base.
  const std::map<std::string, int>& blockOfName;
  int block;
  DeclaredConnectivity& declared;

  const Ijk& counts() const { return this->mesh.blocks[this->block].points.counts(); }
  /// Whether a range, or a list, can have as many points.
  bool canHave(cgsize_t count, bool isRange) const
  {
    return isRange ? count == 2 : count >= 0 && count <= 8 * this->mesh.blocks[this->block].points.size();
  }
};

/// The face of a block that a range of vertices lies on, as a range along that face's axes; false if the range is a
/// point or a line.
/// @throws Error if there is no such face
bool faceRange(const StructuredZone& zone, int block, const PointRange& range, DirectedRange& found);

void readInterfaces(const StructuredZone& zone);
void readBoundaries(const StructuredZone& zone);

/// The faces that the two corners of a range or the points of a list mean.
void addBoundary(const StructuredZone& zone, bool isRange, const std::vector<cgsize_t>& points,
  CGNS_ENUMT(GridLocation_t) location, const BoundaryLabel& label);

} // namespace bsv::cgns
