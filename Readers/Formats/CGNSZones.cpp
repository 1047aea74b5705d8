// SPDX-License-Identifier: BSD-3-Clause
// The bases and zones of CGNS files.
#include "Formats/CGNSInput.h"

#include "Base/UTF8.h"
#include "Formats/CGNSTree.h"
#include "Formats/ReaderJobs.h"
#include "IO/RegularFile.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <mutex>
#include <numeric>

namespace bsv
{

namespace cgns
{

std::string trimmed(const std::string& text)
{
  const std::size_t first = text.find_first_not_of(" \t");
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(" \t") + 1 - first);
}

Input::Input(const std::string& name)
  : fileName(name)
{
  const std::set<std::string> withoutPoints = checkCGNSTree(name);
  // Without a handler the library writes to the console.
  cg_error_handler([](int, char*) {});
  if (cg_open(name.c_str(), CG_MODE_READ, &this->file) != CG_OK)
  {
    const std::string reason = cg_get_error();
    cg_error_handler(nullptr);
    if (!withoutPoints.empty())
    {
      this->fail("the boundary condition " + validUTF8(*withoutPoints.begin()) +
        " has no points (PointRange or PointList), for which the CGNS library refuses the file; give it some, or "
        "remove " +
        "it: " + reason);
    }
    this->fail("the file cannot be read as CGNS, it is damaged or no such file: " + reason);
  }
}

Input::~Input()
{
  cg_close(this->file);
  cg_error_handler(nullptr);
}

void Input::fail(const std::string& what) const
{
  throw Error(this->fileName + this->where + ": " + what);
}

void Input::check(int status, const std::string& what) const
{
  if (status != CG_OK)
  {
    this->fail(what + (what.empty() ? "" : ": ") + cg_get_error());
  }
}

void Input::leaveOut(const std::string& why)
{
  this->left.add("boundary conditions left out", this->where.substr(2) + ": " + why);
}

int findArray(const std::string& name, DataArray& found)
{
  int arrays = 0;
  int status = cg_narrays(&arrays);
  for (int a = 1; a <= arrays && status == CG_OK; ++a)
  {
    Name own{};
    DataArray array{ a };
    status = cg_array_info(a, own.data(), &array.type, &array.dimensions, array.size.data());
    if (status == CG_OK && name == own.data())
    {
      found = array;
      break;
    }
  }
  return status;
}

namespace
{

/// What stands at a base.
struct Base
{
  std::string name;
  int cells = 0;
  int space = 0;
  int zones = 0;

  bool isMesh() const { return this->zones > 0 && this->cells == 3 && this->space == 3; }
};

Base readBase(const Input& input, int number)
{
  Name name{};
  Base base;
  input.check(cg_base_read(input.file, number, name.data(), &base.cells, &base.space), "base");
  input.check(cg_nzones(input.file, number, &base.zones), "zones");
  base.name = name.data();
  return base;
}

int countBases(const Input& input)
{
  int bases = 0;
  input.check(cg_nbases(input.file, &bases), "");
  return bases;
}

/// Numbers of an array; nothing is changed if there is none of that name and size.
bool readNumbers(const std::string& name, std::vector<double>& values)
{
  DataArray array;
  return findArray(name, array) == CG_OK && array.number > 0 && array.dimensions == 1 &&
    array.size[0] == static_cast<cgsize_t>(values.size()) &&
    cg_array_read_as(array.number, CGNS_ENUMV(RealDouble), values.data()) == CG_OK;
}

std::vector<double> readTimes(Input& input)
{
  for (int base = 1, bases = countBases(input); base <= bases; ++base)
  {
    Name name{};
    int steps = 0;
    if (readBase(input, base).cells != 3 || cg_biter_read(input.file, base, name.data(), &steps) != CG_OK || steps < 1)
    {
      continue;
    }
    std::vector<double> values(static_cast<std::size_t>(steps));
    std::iota(values.begin(), values.end(), 0.0);
    if (cg_goto(input.file, base, "BaseIterativeData_t", 1, "end") == CG_OK)
    {
      readNumbers("TimeValues", values) || readNumbers("IterationValues", values);
    }
    return values;
  }
  return {};
}

/// The descriptor `BlockName`, by which our writer keeps names that zones cannot have, or else the zone's name.
std::string blockName(const Input& input, const std::string& zone)
{
  int descriptors = 0;
  if (cg_goto(input.file, input.base, "Zone_t", input.zone, "end") != CG_OK || cg_ndescriptors(&descriptors) != CG_OK)
  {
    return zone;
  }
  for (int d = 1; d <= descriptors; ++d)
  {
    Name name{};
    char* text = nullptr;
    if (cg_descriptor_read(d, name.data(), &text) == CG_OK && std::string(name.data()) == "BlockName" && text)
    {
      std::string found(text);
      cg_free(text);
      return found;
    }
    cg_free(text);
  }
  return zone;
}

class Reader
{
public:
  Reader(const std::string& fileName, const Execution& run, const Piece& piece, const BlockMemory& memory, int step)
    : File(fileName)
    , Run(run)
    , Part(piece)
    , Points(this->File, memory, step)
  {
  }

  CGNSZones read()
  {
    std::vector<Base> bases;
    for (int b = 1, count = countBases(this->File); b <= count; ++b)
    {
      bases.push_back(cgns::readBase(this->File, b));
    }
    const bool others = std::any_of(bases.begin(), bases.end(), [](const Base& base) { return base.isMesh(); });
    for (const Base& base : bases)
    {
      ++this->File.base;
      this->readBase(base, others);
    }
    this->File.where.clear();
    if (this->Zones.blocks.empty() && this->Zones.hexZones.empty())
    {
      this->File.fail(this->Flat.empty() ? "the file has no zones" : this->Flat);
    }
    this->Declared.finish(this->Mesh, this->File.left);
    this->readCoordinates();
    this->Points.tell();
    this->Zones.contacts = this->Declared.contacts();
    this->Zones.interfaces = std::move(this->Mesh.interfaces);
    this->Zones.boundaries = std::move(this->Mesh.boundaries);
    this->Zones.boundaryNames = std::move(this->Mesh.boundaryNames);
    this->Zones.boundaryTypes = std::move(this->Mesh.boundaryTypes);
    this->Zones.warnings = this->File.left.sentences();
    return std::move(this->Zones);
  }

private:
  /// Where a block comes from.
  struct Place
  {
    int base, zone;
    std::string where;
  };

  /// @param others whether there are bases with meshes of volumes: then one that is none may be left out.
  void readBase(const Base& base, bool others)
  {
    Input& input = this->File;
    input.where = ", base '" + base.name + "'";
    if (base.zones > 0 && !base.isMesh())
    {
      const std::string why = "the cells are of dimension " + std::to_string(base.cells) + " in a space of dimension " +
        std::to_string(base.space) + (base.cells == 2 ? ", a surface mesh" : "") + "; hexahedra need 3 and 3";
      if (!others)
      {
        input.fail(why);
      }
      input.left.add("bases left out", input.where.substr(2) + ": " + why);
      return;
    }
    this->FamiliesOfBase.read(input, base.name);
    this->BlockOfName.clear();
    const std::string where = input.where;
    const std::size_t first = this->Places.size();
    for (input.zone = 1; input.zone <= base.zones; ++input.zone)
    {
      input.where = where + ", zone " + std::to_string(input.zone);
      this->readZone(where);
    }
    for (std::size_t block = first; block < this->Places.size(); ++block)
    {
      input.zone = this->Places[block].zone;
      input.where = this->Places[block].where;
      const StructuredZone zone{ input, this->FamiliesOfBase, this->Mesh, this->BlockOfName, static_cast<int>(block),
        this->Declared };
      readInterfaces(zone);
      readBoundaries(zone);
    }
  }

  void readZone(const std::string& base)
  {
    Input& input = this->File;
    Name name{};
    // Room for an unstructured zone, too.
    std::array<cgsize_t, 9> size{};
    CGNS_ENUMT(ZoneType_t) type;
    input.check(cg_zone_type(input.file, input.base, input.zone, &type), "type");
    input.check(cg_zone_read(input.file, input.base, input.zone, name.data(), size.data()), "size");
    input.where = base + ", zone '" + name.data() + "'";
    if (type == CGNS_ENUMV(Unstructured))
    {
      this->Zones.hexZones.push_back(readHexZone(input, this->FamiliesOfBase, this->Points,
        validUTF8(blockName(input, name.data())), size[0], this->Part.number == 0));
      return;
    }
    if (type != CGNS_ENUMV(Structured))
    {
      input.fail(std::string("the zone is of type ") + cg_ZoneTypeName(type));
    }
    GridBlock block;
    block.name = validUTF8(blockName(input, name.data()));
    const std::string points =
      std::to_string(size[0]) + " x " + std::to_string(size[1]) + " x " + std::to_string(size[2]) + " points";
    if (std::all_of(size.begin(), size.begin() + 3, [](cgsize_t count) { return count > 0; }) &&
      std::count(size.begin(), size.begin() + 3, 1) > 0)
    {
      input.left.add("zones left out that are no volumes", input.where.substr(2) + ": " + points);
      this->Flat =
        "no zone is a volume: '" + block.name + "' has " + points + "; hexahedra need at least 2 in each direction";
      return;
    }
    for (int d = 0; d < 3; ++d)
    {
      if (size[d] < 2 || size[d] > std::numeric_limits<int>::max())
      {
        input.fail("the zone has " + points + "; hexahedra need at least 2 in each direction");
      }
      block.counts[d] = static_cast<int>(size[d]);
    }
    this->Zones.blocks.push_back(std::move(block));
    this->Mesh.blocks.push_back(meshBlock(this->Zones.blocks.back()));
    this->BlockOfName.emplace(name.data(), static_cast<int>(this->Places.size()));
    this->Places.push_back({ input.base, input.zone, input.where });
  }

  /// Of the blocks that belong to the piece.
  void readCoordinates()
  {
    std::vector<Ijk> counts;
    for (const GridBlock& block : this->Zones.blocks)
    {
      counts.push_back(block.counts);
    }
    const std::vector<int> owners = this->Part.owners(counts);
    for (std::size_t b = 0; b < owners.size(); ++b)
    {
      GridBlock& block = this->Zones.blocks[b];
      block.piece = owners[b];
      if (block.piece == this->Part.number)
      {
        this->File.base = this->Places[b].base;
        this->File.zone = this->Places[b].zone;
        this->File.where = this->Places[b].where;
        this->Points.read(block);
      }
      this->Run.report(double(b + 1) / double(owners.size()));
    }
  }

  Input File;
  const Execution& Run;
  const Piece Part;
  Coordinates Points;
  CGNSZones Zones;
  /// One per block.
  std::vector<Place> Places;
  DeclaredConnectivity Declared;
  Families FamiliesOfBase;
  /// What is wrong with a zone that is no volume.
  std::string Flat;
  /// Blocks of the current base.
  std::map<std::string, int> BlockOfName;
  /// Names and sizes of the zones.
  BlockMesh Mesh;
};

/// The CGNS library and HDF5 keep their state in static variables.
std::mutex& libraryGuard()
{
  static std::mutex guard;
  return guard;
}

} // namespace

} // namespace cgns

bool looksLikeCGNS(const std::string& fileName)
{
  if (!isRegularFile(fileName))
  {
    return false;
  }
  std::array<char, 32> start{};
  std::ifstream stream(fileName, std::ios::binary);
  stream.read(start.data(), start.size());
  const std::string text(start.data(), static_cast<std::size_t>(std::max<std::streamsize>(stream.gcount(), 0)));
  return text.find("ADF Database Version") == 4 || text.find("\x89HDF\r\n\x1a\n") == 0;
}

CGNSZones loadCGNS(
  const std::string& fileName, const Execution& run, const Piece& piece, const BlockMemory& memory, int step)
{
  const std::lock_guard<std::mutex> lock(cgns::libraryGuard());
  return cgns::Reader(fileName, run, piece, memory, step).read();
}

std::vector<double> loadCGNSTimes(const std::string& fileName)
{
  const std::lock_guard<std::mutex> lock(cgns::libraryGuard());
  cgns::Input input(fileName);
  return cgns::readTimes(input);
}

std::vector<double> cgnsTimes(const std::string& fileName)
{
  try
  {
    return loadCGNSTimesApart(fileName);
  }
  catch (const Error&)
  {
    return {};
  }
}

CGNSZones readCGNS(const std::string& fileName, const Execution& run, const Piece& piece, int step)
{
  CGNSZones zones = loadCGNSApart(fileName, run, piece, step);
  BlockMesh mesh;
  for (const GridBlock& block : zones.blocks)
  {
    mesh.blocks.push_back(meshBlock(block));
  }
  checkContacts(mesh, zones.contacts, *run.ranks);
  return zones;
}

} // namespace bsv
