// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/CGNSFile.h"

#include "Formats/MeshToWrite.h"

// clang-format off
#include VTK_CGNS(cgns_io.h)
// clang-format on

#include <cerrno>
#include <cmath>

#include <unistd.h>

namespace bsv
{

namespace
{

/// No less than the library takes beside the arrays, for a file and for a node in it.
constexpr double FileBytes = 65536.0;
constexpr double NodeBytes = 3072.0;

} // namespace

CGNSFile::CGNSFile(AtomicFile& file, double bytes, double nodes)
  : File(file)
{
  file.requireRoom(bytes + FileBytes + NodeBytes * nodes);
  // Without a handler the library writes to the console.
  cg_error_handler([](int, char*) {});
  cg_set_file_type(CG_FILE_HDF5);
  this->check(cg_open(file.temporaryPath().c_str(), CG_MODE_WRITE, &this->Number), "the file");
  this->Open = true;
}

CGNSFile::~CGNSFile()
{
  if (this->Open)
  {
    // The library, and HDF5 at the end of the process, need to write what they still hold: on a full disk there is room
    // for it again if what was written goes.
    (void)!::truncate(this->File.temporaryPath().c_str(), 0);
    cg_close(this->Number);
  }
  cg_error_handler(nullptr);
}

void CGNSFile::check(int status, const std::string& what) const
{
  if (status != CG_OK)
  {
    throw FileError("Cannot write " + what + " to '" + this->File.target() + "': " + cg_get_error(), errno);
  }
}

void CGNSFile::close()
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
  const bool changed =
    cgio_open_file(this->File.temporaryPath().c_str(), CGIO_MODE_MODIFY, CGIO_FILE_HDF5, &tree) == CGIO_ERR_NONE &&
    cgio_get_root_id(tree, &root) == CGIO_ERR_NONE &&
    cgio_get_node_id(tree, root, "CGNSLibraryVersion", &version) == CGIO_ERR_NONE &&
    cgio_write_all_data(tree, version, &written) == CGIO_ERR_NONE;
  if (cgio_close_file(tree) != CGIO_ERR_NONE || !changed)
  {
    throw FileError("Cannot write the version to '" + this->File.target() + "'", errno);
  }
  this->File.takeOver();
}

std::vector<std::string> familyNames(const std::vector<std::string>& names)
{
  return allowedNames(names, " !\"#$%&'()*+,-.:;<=>?@[]^_`{|}~", 32);
}

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

void writeFamilies(
  const CGNSFile& file, int base, const std::vector<std::string>& families, const std::vector<std::string>& types)
{
  for (std::size_t n = 0; n < families.size(); ++n)
  {
    int family = 0;
    int condition = 0;
    file.check(cg_family_write(file.number(), base, families[n].c_str(), &family), "family '" + families[n] + "'");
    file.check(cg_fambc_write(file.number(), base, family, "FamBC", boundaryConditionType(types[n]), &condition),
      "the type of family '" + families[n] + "'");
  }
}

bool writeUnits(const CGNSFile& file, int base, double lengthUnit)
{
  if (lengthUnit == 0.0)
  {
    return true;
  }
  static constexpr struct
  {
    double metres;
    CGNS_ENUMT(LengthUnits_t) unit;
  } Units[] = { { 1.0, CGNS_ENUMV(Meter) }, { 0.01, CGNS_ENUMV(Centimeter) }, { 0.001, CGNS_ENUMV(Millimeter) },
    { 0.3048, CGNS_ENUMV(Foot) }, { 0.0254, CGNS_ENUMV(Inch) } };
  for (const auto& entry : Units)
  {
    if (std::abs(entry.metres - lengthUnit) <= 1e-9 * entry.metres)
    {
      file.check(cg_goto(file.number(), base, "end"), "units");
      file.check(cg_dataclass_write(CGNS_ENUMV(Dimensional)), "units");
      file.check(
        cg_units_write(CGNS_ENUMV(Kilogram), entry.unit, CGNS_ENUMV(Second), CGNS_ENUMV(Kelvin), CGNS_ENUMV(Degree)),
        "units");
      return true;
    }
  }
  return false;
}

} // namespace bsv
