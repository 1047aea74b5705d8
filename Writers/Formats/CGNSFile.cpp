// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/CGNSFile.h"

#include "Formats/MeshToWrite.h"

// clang-format off
#include VTK_CGNS(cgns_io.h)
// clang-format on

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <iterator>

#include <unistd.h>

namespace bsv
{

namespace
{

constexpr const char* Axes[3] = { "CoordinateX", "CoordinateY", "CoordinateZ" };

CGNS_ENUMT(BCType_t) boundaryConditionType(const std::string& name)
{
  for (int type = 0; type < NofValidBCTypes; ++type)
  {
    if (name == BCTypeName[type] && type != int(CGNS_ENUMV(FamilySpecified)))
    {
      return static_cast<CGNS_ENUMT(BCType_t)>(type);
    }
  }
  return CGNS_ENUMV(BCTypeUserDefined);
}

} // namespace

CGNSLibrary::CGNSLibrary(const std::string& path, const std::string& target)
  : Path(path)
  , Target(target)
{
  // Without a handler the library writes to the console.
  cg_error_handler([](int, char*) {});
  cg_set_file_type(CG_FILE_HDF5);
  this->check(cg_open(path.c_str(), CG_MODE_WRITE, &this->Number), "the file");
  this->Open = true;
  int base = 0;
  this->check(cg_base_write(this->Number, "Base", 3, 3, &base), "the base");
}

CGNSLibrary::~CGNSLibrary()
{
  if (this->Open)
  {
    // Where it works in the process of others it has to let go of the file, for which it needs room.
    (void)!::truncate(this->Path.c_str(), 0);
    cg_close(this->Number);
  }
  cg_error_handler(nullptr);
}

void CGNSLibrary::check(int status, const std::string& what) const
{
  if (status != CG_OK)
  {
    throw FileError("Cannot write " + what + " to '" + this->Target + "': " + cg_get_error(), errno);
  }
}

void CGNSLibrary::unit(int unit)
{
  this->check(cg_goto(this->Number, 1, "end"), "units");
  this->check(cg_dataclass_write(CGNS_ENUMV(Dimensional)), "units");
  this->check(cg_units_write(CGNS_ENUMV(Kilogram), static_cast<CGNS_ENUMT(LengthUnits_t)>(unit), CGNS_ENUMV(Second),
                CGNS_ENUMV(Kelvin), CGNS_ENUMV(Degree)),
    "units");
}

void CGNSLibrary::family(const std::string& name, const std::string& type)
{
  int family = 0;
  int condition = 0;
  this->check(cg_family_write(this->Number, 1, name.c_str(), &family), "family '" + name + "'");
  this->check(cg_fambc_write(this->Number, 1, family, "FamBC", boundaryConditionType(type), &condition),
    "the type of family '" + name + "'");
}

void CGNSLibrary::zone(const std::string& name, const std::vector<cgsize_t>& size)
{
  int zone = 0;
  this->check(cg_zone_write(this->Number, 1, name.c_str(), size.data(),
                size.size() == 9 ? CGNS_ENUMV(Structured) : CGNS_ENUMV(Unstructured), &zone),
    "zone '" + name + "'");
  this->Zones.push_back(name);
}

void CGNSLibrary::description(int zone, const std::string& name, const std::string& text)
{
  this->check(cg_goto(this->Number, 1, "Zone_t", zone, "end"), "a name");
  this->check(cg_descriptor_write(name.c_str(), text.c_str()), "a name");
}

void CGNSLibrary::interface(int zone, const std::string& name, const std::string& donor,
  const std::array<cgsize_t, 6>& range, const std::array<cgsize_t, 6>& donorRange, const std::array<int, 3>& transform)
{
  int index = 0;
  this->check(cg_1to1_write(this->Number, 1, zone, name.c_str(), donor.c_str(), range.data(), donorRange.data(),
                transform.data(), &index),
    name + " of zone '" + this->Zones[zone - 1] + "'");
}

void CGNSLibrary::boundary(
  int zone, const std::string& name, const std::string& family, const std::vector<cgsize_t>& range, bool ofFaces)
{
  const std::string what = "boundary condition '" + name + "' of zone '" + this->Zones[zone - 1] + "'";
  int index = 0;
  this->check(cg_boco_write(this->Number, 1, zone, name.c_str(), CGNS_ENUMV(FamilySpecified), CGNS_ENUMV(PointRange), 2,
                range.data(), &index),
    what);
  if (ofFaces)
  {
    this->check(cg_boco_gridlocation_write(this->Number, 1, zone, index, CGNS_ENUMV(FaceCenter)), what);
  }
  this->check(cg_goto(this->Number, 1, "Zone_t", zone, "ZoneBC_t", 1, "BC_t", index, "end"), what);
  this->check(cg_famname_write(family.c_str()), what);
}

template <typename Real>
void CGNSLibrary::coordinates(int zone, int axis, const std::vector<cgsize_t>& first, const std::vector<cgsize_t>& last,
  const std::vector<Real>& values)
{
  int index = 0;
  this->check(
    cg_coord_partial_write(this->Number, 1, zone, sizeof(Real) == 4 ? CGNS_ENUMV(RealSingle) : CGNS_ENUMV(RealDouble),
      Axes[axis], first.data(), last.data(), values.data(), &index),
    Axes[axis]);
}
template void CGNSLibrary::coordinates(
  int, int, const std::vector<cgsize_t>&, const std::vector<cgsize_t>&, const std::vector<float>&);
template void CGNSLibrary::coordinates(
  int, int, const std::vector<cgsize_t>&, const std::vector<cgsize_t>&, const std::vector<double>&);

void CGNSLibrary::section(const std::string& name, int type, cgsize_t count)
{
  this->check(cg_section_partial_write(this->Number, 1, 1, name.c_str(), static_cast<CGNS_ENUMT(ElementType_t)>(type),
                1, count, 0, &this->Section),
    name);
}

void CGNSLibrary::elements(cgsize_t first, cgsize_t last, const std::vector<cgsize_t>& nodes)
{
  this->check(cg_elements_partial_write(this->Number, 1, 1, this->Section, first, last, nodes.data()), "cells");
}

void CGNSLibrary::sides(
  const std::string& name, int type, cgsize_t first, cgsize_t last, const std::vector<cgsize_t>& nodes)
{
  int index = 0;
  this->check(cg_section_write(this->Number, 1, 1, name.c_str(), static_cast<CGNS_ENUMT(ElementType_t)>(type), first,
                last, 0, nodes.data(), &index),
    "the sides of '" + name + "'");
}

std::string CGNSLibrary::close()
{
  int own = 0;
  this->check(cg_get_cgio(this->Number, &own), "the end of the file");
  this->check(cgio_flush_to_disk(own) == CGIO_ERR_NONE ? CG_OK : CG_ERROR, "the end of the file");
  this->Open = false;
  this->check(cg_close(this->Number), "the end of the file");
  int tree = 0;
  double root = 0.0;
  double version = 0.0;
  const float written = 3.4f;
  const bool changed = cgio_open_file(this->Path.c_str(), CGIO_MODE_MODIFY, CGIO_FILE_HDF5, &tree) == CGIO_ERR_NONE &&
    cgio_get_root_id(tree, &root) == CGIO_ERR_NONE &&
    cgio_get_node_id(tree, root, "CGNSLibraryVersion", &version) == CGIO_ERR_NONE &&
    cgio_write_all_data(tree, version, &written) == CGIO_ERR_NONE;
  if (cgio_close_file(tree) != CGIO_ERR_NONE || !changed)
  {
    throw FileError("Cannot write the version to '" + this->Target + "'", errno);
  }
  return {};
}

std::vector<std::string> familyNames(const std::vector<std::string>& names)
{
  return allowedNames(names, " !\"#$%&'()*+,-.:;<=>?@[]^_`{|}~", 32);
}

void writeHeader(CGNSFile& file, double lengthUnit, const std::vector<std::string>& families,
  const std::vector<std::string>& names, const std::vector<std::string>& types, std::vector<std::string>& notes)
{
  static constexpr struct
  {
    double metres;
    CGNS_ENUMT(LengthUnits_t) unit;
  } Units[] = { { 1.0, CGNS_ENUMV(Meter) }, { 0.01, CGNS_ENUMV(Centimeter) }, { 0.001, CGNS_ENUMV(Millimeter) },
    { 0.3048, CGNS_ENUMV(Foot) }, { 0.0254, CGNS_ENUMV(Inch) } };
  if (lengthUnit != 0.0)
  {
    const auto* found = std::find_if(std::begin(Units), std::end(Units),
      [&](const auto& entry) { return std::abs(entry.metres - lengthUnit) <= 1e-9 * entry.metres; });
    if (found != std::end(Units))
    {
      file.call<&CGNSLibrary::unit>(static_cast<int>(found->unit));
    }
    else
    {
      notes.push_back("CGNS has no name for the unit of length; the file declares none");
    }
  }
  for (std::size_t n = 0; n < families.size(); ++n)
  {
    file.call<&CGNSLibrary::family>(families[n], types[n]);
    if (families[n] != names[n])
    {
      notes.push_back("boundary '" + names[n] + "' is family '" + families[n] + "' in the file");
    }
  }
}

} // namespace bsv
