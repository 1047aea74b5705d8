// SPDX-License-Identifier: BSD-3-Clause
// Coordinates of CGNS zones: x, y, z or r, theta, z; their units; the steps of a series.
#include "Formats/CGNSInput.h"

#include "Base/Numbers.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <new>

namespace bsv::cgns
{

namespace
{

/// Compressed data may be larger than the file, but not by this much.
void checkSize(const Input& input, const Ijk& counts)
{
  std::error_code failure;
  const double bytes = double(std::filesystem::file_size(input.fileName, failure));
  if (double(counts[0]) * counts[1] * counts[2] > 1000.0 * bytes)
  {
    input.fail("the zone has " + bsv::toString(counts) + " points, but the file only " + std::to_string(Index(bytes)) +
      " bytes");
  }
}

/// r, theta, z become x, y, z.
template <typename Real>
void makeCartesian(Index count, double toRadians, Real* points)
{
  for (Index p = 0; p < count; ++p, points += 3)
  {
    const double r = points[0];
    const double theta = points[1] * toRadians;
    points[0] = static_cast<Real>(r * std::cos(theta));
    points[1] = static_cast<Real>(r * std::sin(theta));
  }
}

} // namespace

void Coordinates::tell() const
{
  for (const std::string& zone : this->CylindricalZones)
  {
    this->File.left.add("cylindrical coordinates (r, theta, z) were made Cartesian", "zone '" + zone + "'");
  }
  for (const auto& unit : this->ZoneOfUnit)
  {
    if (this->ZoneOfUnit.size() > 1)
    {
      this->File.left.add("zones have different length units, and their numbers are taken as they are",
        unit.first + " from " + unit.second + " on");
    }
  }
}

/// Finds the coordinates of the zone and checks their sizes before anything is allocated. True if all are float.
bool Coordinates::find(const GridBlock& block)
{
  std::map<std::string, std::pair<int, CGNS_ENUMT(DataType_t)>> stored;
  std::string listed;
  int coordinates = 0;
  this->File.check(cg_ncoords(this->File.file, this->File.base, this->File.zone, &coordinates), "coordinates");
  for (int c = 1; c <= coordinates; ++c)
  {
    Name name{};
    CGNS_ENUMT(DataType_t) type;
    this->File.check(
      cg_coord_info(this->File.file, this->File.base, this->File.zone, c, &type, name.data()), "coordinates");
    stored.emplace(name.data(), std::make_pair(c, type));
    listed += (c == 1 ? "" : ", ") + std::string(name.data());
  }
  const auto has = [&](const std::string& axis) { return stored.count(axis) > 0; };
  this->Cylindrical = !has("CoordinateX") && has("CoordinateR") && has("CoordinateTheta");
  this->Axes = { "CoordinateX", "CoordinateY", "CoordinateZ" };
  if (this->Cylindrical)
  {
    this->Axes = { "CoordinateR", "CoordinateTheta", "CoordinateZ" };
  }
  bool isFloat = true;
  for (const std::string& axis : this->Axes)
  {
    if (!has(axis))
    {
      this->File.fail("the zone has no " + axis + (listed.empty() ? "" : ", but " + listed) +
        "; x, y, z and r, theta, z can be read");
    }
    const CGNS_ENUMT(DataType_t) type = stored[axis].second;
    if (type != CGNS_ENUMV(RealSingle) && type != CGNS_ENUMV(RealDouble))
    {
      this->File.fail(axis + " is of type " + cg_DataTypeName(type) + ", neither float nor double");
    }
    isFloat = isFloat && type == CGNS_ENUMV(RealSingle);
  }
  this->readUnits(stored[this->Axes[0]].first, stored[this->Axes[1]].first);
  checkSize(this->File, block.counts);
  return isFloat;
}

/// The length and angle units of the first two coordinates, numbers of their arrays: those given nearest to them.
void Coordinates::readUnits(int first, int second)
{
  CGNS_ENUMT(LengthUnits_t) length = CGNS_ENUMV(LengthUnitsNull);
  CGNS_ENUMT(AngleUnits_t) angle = CGNS_ENUMV(AngleUnitsNull);
  const auto look = [&](int status, bool lengths, bool angles) {
    CGNS_ENUMT(MassUnits_t) mass;
    CGNS_ENUMT(LengthUnits_t) ownLength;
    CGNS_ENUMT(TimeUnits_t) time;
    CGNS_ENUMT(TemperatureUnits_t) temperature;
    CGNS_ENUMT(AngleUnits_t) ownAngle;
    if (status != CG_OK || cg_units_read(&mass, &ownLength, &time, &temperature, &ownAngle) != CG_OK)
    {
      return;
    }
    const bool saysLength = ownLength != CGNS_ENUMV(LengthUnitsNull) && ownLength != CGNS_ENUMV(LengthUnitsUserDefined);
    const bool saysAngle = ownAngle != CGNS_ENUMV(AngleUnitsNull) && ownAngle != CGNS_ENUMV(AngleUnitsUserDefined);
    length = lengths && saysLength ? ownLength : length;
    angle = angles && saysAngle ? ownAngle : angle;
  };
  look(cg_goto(this->File.file, this->File.base, "end"), true, true);
  look(cg_goto(this->File.file, this->File.base, "Zone_t", this->File.zone, "end"), true, true);
  look(cg_goto(this->File.file, this->File.base, "Zone_t", this->File.zone, "GridCoordinates_t", 1, "end"), true, true);
  const auto look1 = [&](int array, bool lengths) {
    look(cg_goto(this->File.file, this->File.base, "Zone_t", this->File.zone, "GridCoordinates_t", 1, "DataArray_t",
           array, "end"),
      lengths, !lengths);
  };
  look1(first, true);
  look1(second, false);
  this->ToRadians = angle == CGNS_ENUMV(Degree) ? Pi / 180.0 : 1.0;
  if (length != CGNS_ENUMV(LengthUnitsNull))
  {
    this->ZoneOfUnit.emplace(cg_LengthUnitsName(length), this->File.where.substr(2));
  }
}

/// The GridCoordinates_t that the zone has in the step, 1 for the first; 0 if it does not say.
int Coordinates::gridOfStep() const
{
  Name name{};
  if (cg_ziter_read(this->File.file, this->File.base, this->File.zone, name.data()) != CG_OK ||
    cg_goto(this->File.file, this->File.base, "Zone_t", this->File.zone, name.data(), 0, "end") != CG_OK)
  {
    return 0;
  }
  DataArray pointers;
  this->File.check(findArray("GridCoordinatesPointers", pointers), "array of ZoneIterativeData");
  if (pointers.type != CGNS_ENUMV(Character) || pointers.dimensions != 2 || pointers.size[1] <= this->Step)
  {
    return 0;
  }
  const auto length = static_cast<std::size_t>(pointers.size[0]);
  std::string names(length * pointers.size[1], ' ');
  this->File.check(cg_array_read(pointers.number, names.data()), "GridCoordinatesPointers");
  const std::string wanted = trimmed(names.substr(length * this->Step, length).c_str());
  int grids = 0;
  this->File.check(cg_ngrids(this->File.file, this->File.base, this->File.zone, &grids), "grids");
  for (int g = 1; g <= grids; ++g)
  {
    this->File.check(cg_grid_read(this->File.file, this->File.base, this->File.zone, g, name.data()), "grid");
    if (wanted == trimmed(name.data()))
    {
      return g;
    }
  }
  this->File.fail("step " + std::to_string(this->Step) + " has the coordinates '" + wanted + "', which are not there");
}

/// The coordinates of a GridCoordinates_t that is not the first.
template <typename Real>
void Coordinates::readGrid(const GridBlock& block, int grid, Real* points, CGNS_ENUMT(DataType_t) type) const
{
  this->File.check(
    cg_goto(this->File.file, this->File.base, "Zone_t", this->File.zone, "GridCoordinates_t", grid, "end"), "grid");
  std::array<int, 6> rind{};
  if (cg_rind_read(rind.data()) != CG_OK)
  {
    rind.fill(0);
  }
  std::array<Index, 3> stored{};
  for (int d = 0; d < 3; ++d)
  {
    stored[d] = Index(block.counts[d]) + std::max(0, rind[2 * d]) + std::max(0, rind[2 * d + 1]);
  }
  std::vector<Real> values;
  for (int axis = 0; axis < 3; ++axis)
  {
    DataArray array;
    this->File.check(findArray(this->Axes[axis], array), "coordinates");
    if (array.number == 0)
    {
      this->File.fail("step " + std::to_string(this->Step) + " of the zone has no " + this->Axes[axis]);
    }
    const bool flat = block.counts[1] == 1;
    if (array.dimensions != (flat ? 1 : 3) || array.size[0] != stored[0] ||
      (!flat && (array.size[1] != stored[1] || array.size[2] != stored[2])))
    {
      this->File.fail(this->Axes[axis] + " of step " + std::to_string(this->Step) + " has not the size of the zone, " +
        bsv::toString(block.counts));
    }
    values.resize(static_cast<std::size_t>(stored[0] * stored[1] * stored[2]));
    this->File.check(cg_array_read_as(array.number, type, values.data()), this->Axes[axis]);
    Real* to = points + axis;
    for (int k = 0; k < block.counts[2]; ++k)
    {
      for (int j = 0; j < block.counts[1]; ++j)
      {
        const Real* row = values.data() + rind[0] + stored[0] * (j + rind[2] + stored[1] * (k + rind[4]));
        for (int i = 0; i < block.counts[0]; ++i, to += 3)
        {
          *to = row[i];
        }
      }
    }
  }
}

/// The coordinates of the first GridCoordinates_t.
template <typename Real>
void Coordinates::readFirstGrid(const GridBlock& block, Real* points, CGNS_ENUMT(DataType_t) type) const
{
  // Some layers at a time, so that no copy of a large block is needed.
  const Index layer = Index(block.counts[0]) * block.counts[1];
  const int layers = static_cast<int>(std::clamp<Index>((Index(1) << 20) / layer, 1, block.counts[2]));
  std::vector<Real> values(static_cast<std::size_t>(layer * layers));
  for (int axis = 0; axis < 3; ++axis)
  {
    for (int k = 0; k < block.counts[2]; k += layers)
    {
      const int end = std::min(k + layers, block.counts[2]);
      const std::array<cgsize_t, 3> first{ 1, 1, k + 1 };
      const std::array<cgsize_t, 3> last{ block.counts[0], block.counts[1], end };
      this->File.check(cg_coord_read(this->File.file, this->File.base, this->File.zone, this->Axes[axis].c_str(), type,
                         first.data(), last.data(), values.data()),
        this->Axes[axis]);
      Real* to = points + 3 * layer * k + axis;
      for (Index p = 0; p < layer * (end - k); ++p)
      {
        to[3 * p] = values[p];
      }
    }
  }
}

template <typename Real>
void Coordinates::read(const GridBlock& block, int grid, Real* points, CGNS_ENUMT(DataType_t) type)
{
  grid > 1 ? this->readGrid(block, grid, points, type) : this->readFirstGrid(block, points, type);
  if (this->Cylindrical)
  {
    makeCartesian(block.size(), this->ToRadians, points);
    this->CylindricalZones.push_back(block.name);
  }
}

void Coordinates::read(GridBlock& block)
{
  const bool isFloat = this->find(block);
  const int grid = this->gridOfStep();
  try
  {
    this->Demand.add(static_cast<double>(block.size()) * (isFloat ? 12.0 : 24.0));
    block.allocate(isFloat, this->Memory);
    isFloat ? this->read(block, grid, block.floats.get(), CGNS_ENUMV(RealSingle))
            : this->read(block, grid, block.doubles.get(), CGNS_ENUMV(RealDouble));
  }
  catch (const std::bad_alloc&)
  {
    this->File.fail("not enough memory for " + bsv::toString(block.counts) + " points");
  }
  checkFinite(this->File.fileName, block);
}

} // namespace bsv::cgns
