// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/CGNSZones.h"

#include "Base/MemoryCheck.h"
#include "Base/UTF8.h"
#include "Formats/CGNSTree.h"
#include "Formats/DeclaredConnectivity.h"
#include "Formats/ReaderJobs.h"
#include "IO/RegularFile.h"

#include <vtk_cgns.h>
// clang-format off
#include VTK_CGNS(cgnslib.h)
// clang-format on

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <mutex>
#include <new>

namespace bsv
{

namespace
{

/// Names are at most 32 characters; paths of families may be longer.
using Name = std::array<char, 1024>;
/// begin i, j, k, end i, j, k; from 1.
using PointRange = std::array<cgsize_t, 6>;

std::string toString(const PointRange& range)
{
  const auto point = [&](int at) {
    return "(" + std::to_string(range[at]) + ", " + std::to_string(range[at + 1]) + ", " +
      std::to_string(range[at + 2]) + ")";
  };
  return point(0) + " to " + point(3);
}

/// Without blanks at the ends: the library pads some names.
std::string trimmed(const std::string& text)
{
  const std::size_t first = text.find_first_not_of(" \t");
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(" \t") + 1 - first);
}

/// Whether a mesh generator made up the name by counting, such as "BC_12", "dom-3" or "C00021".
bool isNumbered(const std::string& name)
{
  std::string word;
  bool digits = false;
  for (const char c : name)
  {
    const auto letter = static_cast<unsigned char>(c);
    digits = digits || std::isdigit(letter);
    if (!std::isdigit(letter) && c != '_' && c != '-' && c != ' ' && c != '.' && c != ':' && c != '#')
    {
      if (digits)
      {
        return false;
      }
      word += static_cast<char>(std::tolower(letter));
    }
  }
  static const char* const words[] = { "", "bc", "bcs", "boco", "bnd", "bndry", "boundary", "boundarycondition",
    "condition", "cond", "dom", "domain", "face", "patch", "subface", "surface", "surf", "side", "zone", "block" };
  return (digits && word.size() == 1) ||
    ((digits || word.empty()) && std::find(std::begin(words), std::end(words), word) != std::end(words));
}

/// Without a handler the library writes to the console.
class QuietErrors
{
public:
  QuietErrors()
  {
    cg_error_handler([](int, char*) {});
  }
  ~QuietErrors() { cg_error_handler(nullptr); }
  QuietErrors(const QuietErrors&) = delete;
  QuietErrors& operator=(const QuietErrors&) = delete;
};

class CGNSReader
{
public:
  CGNSReader(const std::string& fileName, const Execution& run, const Piece& piece, const BlockMemory& memory, int step)
    : FileName(fileName)
    , Run(run)
    , Part(piece)
    , Memory(memory)
    , Step(step)
  {
    checkCGNSTree(fileName);
    if (cg_open(fileName.c_str(), CG_MODE_READ, &this->File) != CG_OK)
    {
      this->fail(std::string("the file cannot be read as CGNS, it is damaged or no such file: ") + cg_get_error());
    }
    this->IsOpen = true;
  }
  ~CGNSReader()
  {
    if (this->IsOpen)
    {
      cg_close(this->File);
    }
  }
  CGNSReader(const CGNSReader&) = delete;
  CGNSReader& operator=(const CGNSReader&) = delete;

  CGNSZones read()
  {
    int bases = 0;
    this->check(cg_nbases(this->File, &bases), "");
    const bool others = this->volumeBases(bases) > 0;
    for (this->Base = 1; this->Base <= bases; ++this->Base)
    {
      this->readBase(others);
    }
    this->Where.clear();
    if (this->Zones.blocks.empty() && this->Zones.hexZones.empty())
    {
      this->fail("the file has no zones");
    }
    this->Declared.finish(this->Mesh, this->Left);
    this->readCoordinates();
    this->tellCoordinates();
    this->Zones.contacts = this->Declared.contacts();
    this->Zones.interfaces = std::move(this->Mesh.interfaces);
    this->Zones.boundaries = std::move(this->Mesh.boundaries);
    this->Zones.boundaryNames = std::move(this->Mesh.boundaryNames);
    this->Zones.boundaryTypes = std::move(this->Mesh.boundaryTypes);
    this->Zones.warnings = this->Left.sentences();
    return std::move(this->Zones);
  }

  void tellCoordinates()
  {
    for (const std::string& zone : this->CylindricalZones)
    {
      this->Left.add("cylindrical coordinates (r, theta, z) were made Cartesian", "zone '" + zone + "'");
    }
    for (const auto& unit : this->ZoneOfUnit)
    {
      if (this->ZoneOfUnit.size() > 1)
      {
        this->Left.add("zones have different length units, and their numbers are taken as they are",
          unit.first + " from " + unit.second + " on");
      }
    }
  }

  std::vector<double> times()
  {
    int bases = 0;
    this->check(cg_nbases(this->File, &bases), "");
    for (this->Base = 1; this->Base <= bases; ++this->Base)
    {
      Name name{};
      int cellDimension = 0;
      int physicalDimension = 0;
      int steps = 0;
      this->check(cg_base_read(this->File, this->Base, name.data(), &cellDimension, &physicalDimension), "base");
      if (cellDimension != 3 || cg_biter_read(this->File, this->Base, name.data(), &steps) != CG_OK || steps < 1)
      {
        continue;
      }
      std::vector<double> values(static_cast<std::size_t>(steps));
      for (int n = 0; n < steps; ++n)
      {
        values[n] = n;
      }
      if (cg_goto(this->File, this->Base, "BaseIterativeData_t", 1, "end") == CG_OK)
      {
        this->readNumbers("TimeValues", values) || this->readNumbers("IterationValues", values);
      }
      return values;
    }
    return {};
  }

private:
  /// A node's array of numbers; false, and nothing is changed, if it has none of that name and size.
  static bool readNumbers(const std::string& wanted, std::vector<double>& values)
  {
    int arrays = 0;
    cg_narrays(&arrays);
    for (int a = 1; a <= arrays; ++a)
    {
      Name name{};
      CGNS_ENUMT(DataType_t) type;
      int dimensions = 0;
      std::array<cgsize_t, 12> size{};
      if (cg_array_info(a, name.data(), &type, &dimensions, size.data()) == CG_OK && wanted == name.data() &&
        dimensions == 1 && size[0] == static_cast<cgsize_t>(values.size()))
      {
        return cg_array_read_as(a, CGNS_ENUMV(RealDouble), values.data()) == CG_OK;
      }
    }
    return false;
  }

  [[noreturn]] void fail(const std::string& what) const { throw Error(this->FileName + this->Where + ": " + what); }

  void check(int status, const std::string& what) const
  {
    if (status != CG_OK)
    {
      this->fail(what + (what.empty() ? "" : ": ") + cg_get_error());
    }
  }

  /// Why the base holds no mesh of hexahedra; empty if it does, or if it is empty.
  std::string unusable(int zones, int cellDimension, int physicalDimension)
  {
    if (zones > 0 && (cellDimension != 3 || physicalDimension != 3))
    {
      return "the cells are of dimension " + std::to_string(cellDimension) + " in a space of dimension " +
        std::to_string(physicalDimension) + (cellDimension == 2 ? ", a surface mesh" : "") + "; hexahedra need 3 and 3";
    }
    return {};
  }

  /// @param others whether there are other bases with zones: then one that cannot be used may be left out.
  void readBase(bool others)
  {
    Name name{};
    int cellDimension = 0;
    int physicalDimension = 0;
    int zones = 0;
    this->Where.clear();
    this->check(cg_base_read(this->File, this->Base, name.data(), &cellDimension, &physicalDimension), "base");
    this->check(cg_nzones(this->File, this->Base, &zones), "zones");
    this->BaseName = name.data();
    this->Where = std::string(", base '") + name.data() + "'";
    const std::string why = this->unusable(zones, cellDimension, physicalDimension);
    if (!why.empty() && others)
    {
      this->Left.add("bases left out", this->Where.substr(2) + ": " + why);
      return;
    }
    if (!why.empty())
    {
      this->fail(why);
    }
    const std::string base = this->Where;
    this->readFamilies();

    this->BlockOfName.clear();
    std::vector<int> blockOfZone;
    for (int zone = 0; zone < zones; ++zone)
    {
      this->Zone = zone + 1;
      this->Where = base + ", zone " + std::to_string(this->Zone);
      const int block = static_cast<int>(this->Zones.blocks.size());
      blockOfZone.push_back(this->readZone(base) ? block : -1);
    }
    for (int zone = 0; zone < zones; ++zone)
    {
      this->Zone = zone + 1;
      this->Block = blockOfZone[zone];
      if (this->Block < 0)
      {
        continue;
      }
      this->Where = this->Places[this->Block].where;
      this->readInterfaces();
      this->readBoundaries();
    }
  }

  /// Bases whose cells are volumes.
  int volumeBases(int bases)
  {
    int found = 0;
    for (int base = 1; base <= bases; ++base)
    {
      Name name{};
      int cellDimension = 0;
      int physicalDimension = 0;
      int zones = 0;
      this->check(cg_base_read(this->File, base, name.data(), &cellDimension, &physicalDimension), "base");
      this->check(cg_nzones(this->File, base, &zones), "zones");
      found += zones > 0 && cellDimension == 3 && physicalDimension == 3;
    }
    return found;
  }

  /// @return whether it is structured
  bool readZone(const std::string& base)
  {
    Name name{};
    // Room for an unstructured zone, too.
    std::array<cgsize_t, 9> size{};
    CGNS_ENUMT(ZoneType_t) type;
    this->check(cg_zone_type(this->File, this->Base, this->Zone, &type), "type");
    this->check(cg_zone_read(this->File, this->Base, this->Zone, name.data(), size.data()), "size");
    this->Where = base + ", zone '" + name.data() + "'";
    if (type == CGNS_ENUMV(Unstructured))
    {
      this->readHexZone(name.data(), size[0]);
      return false;
    }
    if (type != CGNS_ENUMV(Structured))
    {
      this->fail(std::string("the zone is of type ") + cg_ZoneTypeName(type));
    }
    GridBlock block;
    block.name = validUTF8(this->blockName(name.data()));
    for (int d = 0; d < 3; ++d)
    {
      if (size[d] < 2 || size[d] > std::numeric_limits<int>::max())
      {
        this->fail("the zone has " + std::to_string(size[0]) + " x " + std::to_string(size[1]) + " x " +
          std::to_string(size[2]) + " points; hexahedra need at least 2 in each direction");
      }
      block.counts[d] = static_cast<int>(size[d]);
    }
    this->Zones.blocks.push_back(std::move(block));
    this->Mesh.blocks.push_back(meshBlock(this->Zones.blocks.back()));
    this->BlockOfName.emplace(name.data(), static_cast<int>(this->Places.size()));
    this->Places.push_back({ this->Base, this->Zone, this->Where });
    return true;
  }

  /// An element of an unstructured zone that is a quadrilateral: its number in the zone, its section, its corners.
  struct Quad
  {
    cgsize_t number;
    int section;
    std::array<Index, 4> points;
  };

  void readHexZone(const std::string& name, cgsize_t pointCount)
  {
    if (pointCount < 8 || pointCount > std::numeric_limits<int>::max())
    {
      this->fail("the zone has " + std::to_string(pointCount) + " points; hexahedra need at least 8");
    }
    HexZone zone;
    zone.name = validUTF8(this->blockName(name));
    std::vector<Quad> quads;
    std::vector<std::string> sections;
    int count = 0;
    this->check(cg_nsections(this->File, this->Base, this->Zone, &count), "sections");
    for (int s = 1; s <= count; ++s)
    {
      this->readSection(s, pointCount, zone, quads, sections);
    }
    std::sort(quads.begin(), quads.end(), [](const Quad& a, const Quad& b) { return a.number < b.number; });
    std::vector<char> used(quads.size(), 0);
    this->readHexBoundaries(pointCount, zone, quads, used);
    for (std::size_t q = 0; q < quads.size(); ++q)
    {
      if (!used[q])
      {
        addQuad(boundaryOf(zone, sections[quads[q].section], UnknownBoundaryType), quads[q].points);
      }
    }
    if (this->Part.number == 0)
    {
      GridBlock points;
      points.name = zone.name;
      points.counts = { static_cast<int>(pointCount), 1, 1 };
      this->readCoordinates(points);
      checkFinite(this->FileName, points);
      const GridView view = points.view();
      zone.points.resize(static_cast<std::size_t>(3 * pointCount));
      for (Index p = 0; p < pointCount; ++p)
      {
        const Vec3 x = view.atPlace(p);
        std::copy_n(x.data(), 3, zone.points.begin() + 3 * p);
      }
    }
    else
    {
      zone.hexahedra.clear();
      for (HexZone::Boundary& boundary : zone.boundaries)
      {
        boundary.quadrilaterals.clear();
      }
    }
    this->Zones.hexZones.push_back(std::move(zone));
  }

  static HexZone::Boundary& boundaryOf(HexZone& zone, const std::string& name, const std::string& type)
  {
    const auto known = std::find_if(zone.boundaries.begin(), zone.boundaries.end(),
      [&](const HexZone::Boundary& boundary) { return boundary.name == name; });
    if (known != zone.boundaries.end())
    {
      return *known;
    }
    zone.boundaries.push_back({ name, type, {} });
    return zone.boundaries.back();
  }

  static void addQuad(HexZone::Boundary& boundary, const std::array<Index, 4>& points)
  {
    boundary.quadrilaterals.insert(boundary.quadrilaterals.end(), points.begin(), points.end());
  }

  void readSection(
    int section, cgsize_t pointCount, HexZone& zone, std::vector<Quad>& quads, std::vector<std::string>& sections)
  {
    Name name{};
    CGNS_ENUMT(ElementType_t) type;
    cgsize_t first = 0;
    cgsize_t last = 0;
    int boundary = 0;
    int parents = 0;
    this->check(cg_section_read(
                  this->File, this->Base, this->Zone, section, name.data(), &type, &first, &last, &boundary, &parents),
      "section");
    const std::string where = "section '" + std::string(name.data()) + "'";
    sections.push_back(validUTF8(trimmed(name.data())));
    cgsize_t size = 0;
    this->check(cg_ElementDataSize(this->File, this->Base, this->Zone, section, &size), where);
    const bool mixed = type == CGNS_ENUMV(MIXED);
    int nodes = 0;
    if (!mixed && (cg_npe(type, &nodes) != CG_OK || nodes < 1))
    {
      this->fail(
        where + " has elements of type " + cg_ElementTypeName(type) + "; only hexahedra can be part of blocks");
    }
    if (last < first || size < 0 || size / std::max(1, nodes) < last - first + 1)
    {
      this->fail(where + " has the elements " + std::to_string(first) + " to " + std::to_string(last) + " in " +
        std::to_string(size) + " numbers");
    }
    std::vector<cgsize_t> values(static_cast<std::size_t>(size));
    if (mixed)
    {
#if CGNS_VERSION >= 4000
      std::vector<cgsize_t> offsets(static_cast<std::size_t>(last - first + 2));
      this->check(
        cg_poly_elements_read(this->File, this->Base, this->Zone, section, values.data(), offsets.data(), nullptr),
        where);
#else
      this->check(cg_elements_read(this->File, this->Base, this->Zone, section, values.data(), nullptr), where);
#endif
    }
    else
    {
      this->check(cg_elements_read(this->File, this->Base, this->Zone, section, values.data(), nullptr), where);
    }
    std::size_t at = 0;
    for (cgsize_t number = first; number <= last; ++number)
    {
      CGNS_ENUMT(ElementType_t) own = type;
      if (mixed)
      {
        own = static_cast<CGNS_ENUMT(ElementType_t)>(at < values.size() ? values[at++] : 0);
        if (cg_npe(own, &nodes) != CG_OK || nodes < 1)
        {
          this->fail(where + ", element " + std::to_string(number) + ", has the unknown type " + std::to_string(own));
        }
      }
      if (at + static_cast<std::size_t>(nodes) > values.size())
      {
        this->fail(where + " ends before element " + std::to_string(number));
      }
      for (int n = 0; n < nodes; ++n)
      {
        if (values[at + n] < 1 || values[at + n] > pointCount)
        {
          this->fail(where + ", element " + std::to_string(number) + ", has the point " +
            std::to_string(values[at + n]) + " of " + std::to_string(pointCount));
        }
      }
      this->addElement(own, number, section - 1, values.data() + at, where, zone, quads);
      at += static_cast<std::size_t>(nodes);
    }
  }

  void addElement(CGNS_ENUMT(ElementType_t) type, cgsize_t number, int section, const cgsize_t* nodes,
    const std::string& where, HexZone& zone, std::vector<Quad>& quads)
  {
    const std::string kind = cg_ElementTypeName(type);
    const auto starts = [&](const char* word) { return kind.rfind(word, 0) == 0; };
    if (starts("HEXA"))
    {
      for (int n = 0; n < 8; ++n)
      {
        zone.hexahedra.push_back(nodes[n] - 1);
      }
    }
    else if (starts("QUAD"))
    {
      quads.push_back({ number, section, { nodes[0] - 1, nodes[1] - 1, nodes[2] - 1, nodes[3] - 1 } });
    }
    else if (!starts("NODE") && !starts("BAR"))
    {
      this->fail(where + ", element " + std::to_string(number) + ", is a " + kind +
        "; only hexahedra, with quadrilaterals at their boundaries, can be part of blocks");
    }
  }

  void readHexBoundaries(cgsize_t pointCount, HexZone& zone, const std::vector<Quad>& quads, std::vector<char>& used)
  {
    int conditions = 0;
    this->check(cg_nbocos(this->File, this->Base, this->Zone, &conditions), "boundary conditions");
    const std::string where = this->Where;
    for (int c = 1; c <= conditions; ++c)
    {
      const auto [name, type, set, count] = this->readCondition(c, where);
      const bool range = set == CGNS_ENUMV(PointRange) || set == CGNS_ENUMV(ElementRange);
      const bool list = set == CGNS_ENUMV(PointList) || set == CGNS_ENUMV(ElementList);
      if ((!range && !list) || (range && count != 2) || count < 0 || count > 8 * pointCount)
      {
        this->leaveOut("its faces are given as " + std::to_string(count) + " points of a " + cg_PointSetTypeName(set));
        continue;
      }
      CGNS_ENUMT(GridLocation_t) location = CGNS_ENUMV(Vertex);
      this->check(cg_boco_gridlocation_read(this->File, this->Base, this->Zone, c, &location), "location");
      std::vector<cgsize_t> numbers(static_cast<std::size_t>(count));
      this->check(cg_boco_read(this->File, this->Base, this->Zone, c, numbers.data(), nullptr), "points");
      const BoundaryLabel label = this->boundaryLabel(name, type, c);
      const bool points = (set == CGNS_ENUMV(PointRange) || set == CGNS_ENUMV(PointList)) &&
        (location == CGNS_ENUMV(Vertex) || location == CGNS_ENUMV(GridLocationNull));
      const auto has = [&](cgsize_t number) {
        return range ? number >= std::min(numbers[0], numbers[1]) && number <= std::max(numbers[0], numbers[1])
                     : std::binary_search(numbers.begin(), numbers.end(), number);
      };
      if (list)
      {
        std::sort(numbers.begin(), numbers.end());
      }
      HexZone::Boundary found;
      for (std::size_t q = 0; q < quads.size(); ++q)
      {
        const auto& corners = quads[q].points;
        const bool own = points ? std::all_of(corners.begin(), corners.end(), [&](Index p) { return has(p + 1); })
                                : has(quads[q].number);
        if (own && !used[q])
        {
          used[q] = 1;
          addQuad(found, corners);
        }
      }
      if (points && found.quadrilaterals.empty())
      {
        addFacesOfPoints(zone, has, found);
      }
      if (found.quadrilaterals.empty())
      {
        this->leaveOut("no quadrilateral of the zone is meant by it");
        continue;
      }
      std::vector<Index>& all = boundaryOf(zone, label.name, label.type).quadrilaterals;
      all.insert(all.end(), found.quadrilaterals.begin(), found.quadrilaterals.end());
    }
    this->Where = where;
  }

  /// The faces that only one cell has and all of whose points are meant.
  template <typename Has>
  static void addFacesOfPoints(const HexZone& zone, const Has& has, HexZone::Boundary& boundary)
  {
    static constexpr int Faces[6][4] = { { 0, 3, 2, 1 }, { 4, 5, 6, 7 }, { 0, 1, 5, 4 }, { 1, 2, 6, 5 }, { 2, 3, 7, 6 },
      { 3, 0, 4, 7 } };
    // Sorted points, then the face itself.
    std::vector<std::array<Index, 8>> faces;
    for (std::size_t c = 0; c < zone.hexahedra.size(); c += 8)
    {
      for (const auto& corners : Faces)
      {
        std::array<Index, 8> face{};
        bool meant = true;
        for (int n = 0; n < 4 && meant; ++n)
        {
          face[n] = face[4 + n] = zone.hexahedra[c + corners[n]];
          meant = has(face[n] + 1);
        }
        if (meant)
        {
          std::sort(face.begin(), face.begin() + 4);
          faces.push_back(face);
        }
      }
    }
    std::sort(faces.begin(), faces.end());
    const auto same = [&](std::size_t a, std::size_t b) {
      return b < faces.size() && std::equal(faces[a].begin(), faces[a].begin() + 4, faces[b].begin());
    };
    for (std::size_t f = 0; f < faces.size(); ++f)
    {
      if (!same(f, f + 1) && (f == 0 || !same(f, f - 1)))
      {
        addQuad(boundary, { faces[f][4], faces[f][5], faces[f][6], faces[f][7] });
      }
    }
  }

  /// The descriptor `BlockName`, by which our writer keeps names that zones cannot have, or else the zone's name.
  std::string blockName(const std::string& zone) const
  {
    int descriptors = 0;
    if (cg_goto(this->File, this->Base, "Zone_t", this->Zone, "end") != CG_OK || cg_ndescriptors(&descriptors) != CG_OK)
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
        this->Base = this->Places[b].base;
        this->Zone = this->Places[b].zone;
        this->Where = this->Places[b].where;
        this->readCoordinates(block);
        checkFinite(this->FileName, block);
      }
      this->Run.report(double(b + 1) / double(owners.size()));
    }
  }

  /// Finds the coordinates of the zone, which may be cylindrical, and checks their sizes before anything is allocated.
  /// True if all are float.
  bool checkCoordinates(const GridBlock& block)
  {
    std::map<std::string, std::pair<int, CGNS_ENUMT(DataType_t)>> stored;
    std::string listed;
    int coordinates = 0;
    this->check(cg_ncoords(this->File, this->Base, this->Zone, &coordinates), "coordinates");
    for (int c = 1; c <= coordinates; ++c)
    {
      Name name{};
      CGNS_ENUMT(DataType_t) type;
      this->check(cg_coord_info(this->File, this->Base, this->Zone, c, &type, name.data()), "coordinates");
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
        this->fail("the zone has no " + axis + (listed.empty() ? "" : ", but " + listed) +
          "; x, y, z and r, theta, z can be read");
      }
      const CGNS_ENUMT(DataType_t) type = stored[axis].second;
      if (type != CGNS_ENUMV(RealSingle) && type != CGNS_ENUMV(RealDouble))
      {
        this->fail(axis + " is of type " + cg_DataTypeName(type) + ", neither float nor double");
      }
      isFloat = isFloat && type == CGNS_ENUMV(RealSingle);
    }
    this->readUnits(stored[this->Axes[0]].first, stored[this->Axes[1]].first);
    // Compressed data may be larger than the file, but not by this much.
    std::error_code failure;
    const double bytes = double(std::filesystem::file_size(this->FileName, failure));
    if (double(block.counts[0]) * block.counts[1] * block.counts[2] > 1000.0 * bytes)
    {
      this->fail("the zone has " + bsv::toString(block.counts) + " points, but the file only " +
        std::to_string(Index(bytes)) + " bytes");
    }
    return isFloat;
  }

  /// The length and angle units of the first two coordinates, numbers of their arrays: those given nearest to them.
  void readUnits(int first, int second)
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
      const bool saysLength =
        ownLength != CGNS_ENUMV(LengthUnitsNull) && ownLength != CGNS_ENUMV(LengthUnitsUserDefined);
      const bool saysAngle = ownAngle != CGNS_ENUMV(AngleUnitsNull) && ownAngle != CGNS_ENUMV(AngleUnitsUserDefined);
      length = lengths && saysLength ? ownLength : length;
      angle = angles && saysAngle ? ownAngle : angle;
    };
    look(cg_goto(this->File, this->Base, "end"), true, true);
    look(cg_goto(this->File, this->Base, "Zone_t", this->Zone, "end"), true, true);
    look(cg_goto(this->File, this->Base, "Zone_t", this->Zone, "GridCoordinates_t", 1, "end"), true, true);
    const auto look1 = [&](int array, bool lengths) {
      look(cg_goto(this->File, this->Base, "Zone_t", this->Zone, "GridCoordinates_t", 1, "DataArray_t", array, "end"),
        lengths, !lengths);
    };
    look1(first, true);
    look1(second, false);
    this->ToRadians = angle == CGNS_ENUMV(Degree) ? 3.14159265358979323846 / 180.0 : 1.0;
    if (length != CGNS_ENUMV(LengthUnitsNull))
    {
      this->ZoneOfUnit.emplace(cg_LengthUnitsName(length), this->Where.substr(2));
    }
  }

  /// r, theta, z become x, y, z.
  template <typename Real>
  void makeCartesian(const GridBlock& block, Real* points) const
  {
    for (Index p = 0; p < block.size(); ++p, points += 3)
    {
      const double r = points[0];
      const double theta = points[1] * this->ToRadians;
      points[0] = static_cast<Real>(r * std::cos(theta));
      points[1] = static_cast<Real>(r * std::sin(theta));
    }
  }

  /// The GridCoordinates_t that the zone has in the step, 1 for the first; 0 if it does not say.
  int gridOfStep()
  {
    Name name{};
    if (cg_ziter_read(this->File, this->Base, this->Zone, name.data()) != CG_OK ||
      cg_goto(this->File, this->Base, "Zone_t", this->Zone, name.data(), 0, "end") != CG_OK)
    {
      return 0;
    }
    int arrays = 0;
    cg_narrays(&arrays);
    for (int a = 1; a <= arrays; ++a)
    {
      CGNS_ENUMT(DataType_t) type;
      int dimensions = 0;
      std::array<cgsize_t, 12> size{};
      this->check(cg_array_info(a, name.data(), &type, &dimensions, size.data()), "array of ZoneIterativeData");
      if (std::string(name.data()) != "GridCoordinatesPointers" || type != CGNS_ENUMV(Character) || dimensions != 2 ||
        size[1] <= this->Step)
      {
        continue;
      }
      std::string names(static_cast<std::size_t>(size[0] * size[1]), ' ');
      this->check(cg_array_read(a, names.data()), "GridCoordinatesPointers");
      const std::string wanted = trimmed(names.substr(static_cast<std::size_t>(size[0]) * this->Step, size[0]).c_str());
      int grids = 0;
      this->check(cg_ngrids(this->File, this->Base, this->Zone, &grids), "grids");
      for (int g = 1; g <= grids; ++g)
      {
        this->check(cg_grid_read(this->File, this->Base, this->Zone, g, name.data()), "grid");
        if (wanted == trimmed(name.data()))
        {
          return g;
        }
      }
      this->fail("step " + std::to_string(this->Step) + " has the coordinates '" + wanted + "', which are not there");
    }
    return 0;
  }

  /// The coordinates of a GridCoordinates_t that is not the first.
  template <typename Real>
  void readGrid(const GridBlock& block, int grid, Real* points, CGNS_ENUMT(DataType_t) type)
  {
    this->check(cg_goto(this->File, this->Base, "Zone_t", this->Zone, "GridCoordinates_t", grid, "end"), "grid");
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
    int arrays = 0;
    this->check(cg_narrays(&arrays), "coordinates");
    std::vector<Real> values;
    for (int axis = 0; axis < 3; ++axis)
    {
      bool found = false;
      for (int a = 1; a <= arrays && !found; ++a)
      {
        Name name{};
        CGNS_ENUMT(DataType_t) own;
        int dimensions = 0;
        std::array<cgsize_t, 12> size{};
        this->check(cg_array_info(a, name.data(), &own, &dimensions, size.data()), "coordinates");
        if (this->Axes[axis] != name.data())
        {
          continue;
        }
        found = true;
        const bool flat = block.counts[1] == 1;
        if (dimensions != (flat ? 1 : 3) || size[0] != stored[0] ||
          (!flat && (size[1] != stored[1] || size[2] != stored[2])))
        {
          this->fail(this->Axes[axis] + " of step " + std::to_string(this->Step) + " has not the size of the zone, " +
            bsv::toString(block.counts));
        }
        values.resize(static_cast<std::size_t>(stored[0] * stored[1] * stored[2]));
        this->check(cg_array_read_as(a, type, values.data()), this->Axes[axis]);
      }
      if (!found)
      {
        this->fail("step " + std::to_string(this->Step) + " of the zone has no " + this->Axes[axis]);
      }
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

  void readCoordinates(GridBlock& block)
  {
    const bool isFloat = this->checkCoordinates(block);
    const int grid = this->gridOfStep();
    try
    {
      this->Demand.add(static_cast<double>(block.size()) * (isFloat ? 12.0 : 24.0));
      block.allocate(isFloat, this->Memory);
      isFloat ? this->readCoordinates(block, grid, block.floats.get(), CGNS_ENUMV(RealSingle))
              : this->readCoordinates(block, grid, block.doubles.get(), CGNS_ENUMV(RealDouble));
    }
    catch (const std::bad_alloc&)
    {
      this->fail("not enough memory for " + bsv::toString(block.counts) + " points");
    }
  }

  template <typename Real>
  void readCoordinates(const GridBlock& block, int grid, Real* points, CGNS_ENUMT(DataType_t) type)
  {
    grid > 1 ? this->readGrid(block, grid, points, type) : this->readGrid(block, points, type);
    if (this->Cylindrical)
    {
      this->makeCartesian(block, points);
      this->CylindricalZones.push_back(block.name);
    }
  }

  /// The coordinates of the first GridCoordinates_t.
  template <typename Real>
  void readGrid(const GridBlock& block, Real* points, CGNS_ENUMT(DataType_t) type)
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
        this->check(cg_coord_read(this->File, this->Base, this->Zone, this->Axes[axis].c_str(), type, first.data(),
                      last.data(), values.data()),
          this->Axes[axis]);
        Real* to = points + 3 * layer * k + axis;
        for (Index p = 0; p < layer * (end - k); ++p)
        {
          to[3 * p] = values[p];
        }
      }
    }
  }

  const Ijk& counts(int block) const
  {
    return this->Mesh.blocks[block].points.counts();
  }

  /// The block face that a range of vertices lies on, as a range along that face's axes; false if the range is a point
  /// or a line.
  bool faceRange(int block, const PointRange& range, DirectedRange& found) const
  {
    int flat = 0;
    found.block = block;
    for (int d = 0; d < 3; ++d)
    {
      const int count = this->counts(block)[d];
      for (const cgsize_t index : { range[d], range[3 + d] })
      {
        if (index < 1 || index > count)
        {
          this->fail("the range " + toString(range) + " leaves the " + bsv::toString(this->counts(block)) +
            " points of zone '" + this->Mesh.blocks[block].name + "'");
        }
      }
      if (range[d] == range[3 + d])
      {
        ++flat;
        found.face = 2 * d + (range[d] == 1 ? 0 : 1);
        if (flat == 1 && range[d] != 1 && range[d] != count)
        {
          this->fail("the range " + toString(range) + " lies inside zone '" + this->Mesh.blocks[block].name +
            "', not on a face");
        }
      }
    }
    if (flat == 0)
    {
      this->fail("the range " + toString(range) + " is not on a face of zone '" + this->Mesh.blocks[block].name + "'");
    }
    for (int axis = 0; axis < 2; ++axis)
    {
      found.begin[axis] = static_cast<int>(range[faceAxis(found.face, axis)]) - 1;
      found.end[axis] = static_cast<int>(range[3 + faceAxis(found.face, axis)]) - 1;
    }
    return flat == 1;
  }

  int blockOfZone(const std::string& name) const
  {
    // A donor may be given with its base: /base/zone.
    const std::string zone = name.substr(name.rfind('/') + 1);
    const auto found = this->BlockOfName.find(zone);
    if (found == this->BlockOfName.end())
    {
      this->fail("there is no donor zone '" + name + "'");
    }
    return found->second;
  }

  void readInterfaces()
  {
    int contacts = 0;
    this->check(cg_n1to1(this->File, this->Base, this->Zone, &contacts), "interfaces");
    const std::string zone = this->Where;
    for (int c = 1; c <= contacts; ++c)
    {
      Name name{};
      Name donor{};
      PointRange range{};
      PointRange donorRange{};
      std::array<int, 3> transform{};
      this->check(cg_1to1_read(this->File, this->Base, this->Zone, c, name.data(), donor.data(), range.data(),
                    donorRange.data(), transform.data()),
        "interface " + std::to_string(c));
      this->Where = zone + ", interface '" + name.data() + "'";

      DirectedRange own;
      DirectedRange other;
      if (!this->faceRange(this->Block, range, own) ||
        !this->faceRange(this->blockOfZone(donor.data()), donorRange, other))
      {
        continue; // a line or a point joins nothing
      }
      float center[3];
      float angle[3];
      float translation[3];
      if (cg_1to1_periodic_read(this->File, this->Base, this->Zone, c, center, angle, translation) == CG_OK)
      {
        this->Declared.addBoundary(own, "Periodic", UnknownBoundaryType, this->Where.substr(2));
        continue;
      }
      this->addInterface(own, other, range, donorRange, transform);
    }
    this->Where = zone;
    this->readGeneralConnections();
  }

  /// The boundary of a periodic contact that lists its points.
  void addPeriodic(int connection, CGNS_ENUMT(PointSetType_t) set, cgsize_t count, CGNS_ENUMT(GridLocation_t) location)
  {
    const int block = this->Block;
    const std::string zone = this->Where;
    const bool isRange = set == CGNS_ENUMV(PointRange) && count == 2;
    if (!isRange && (set != CGNS_ENUMV(PointList) || count < 0 || count > 8 * this->Zones.blocks[block].size()))
    {
      return;
    }
    std::vector<cgsize_t> points(static_cast<std::size_t>(3 * count));
    this->check(cg_conn_read_short(this->File, this->Base, this->Zone, connection, points.data()), "points");
    this->Where = zone + ", connection " + std::to_string(connection);
    const BoundaryLabel label{ "Periodic", UnknownBoundaryType };
    isRange ? this->addRange(block, points, location, label) : this->addList(block, points, location, label);
    this->Where = zone;
  }

  /// What joins zones otherwise than by ranges point to point. Lists of coincident points need no word: the points
  /// tell, unless they are periodic.
  void readGeneralConnections()
  {
    int count = 0;
    this->check(cg_nconns(this->File, this->Base, this->Zone, &count), "general connectivity");
    for (int c = 1; c <= count; ++c)
    {
      Name name{};
      Name donor{};
      CGNS_ENUMT(GridLocation_t) location;
      CGNS_ENUMT(GridConnectivityType_t) type;
      CGNS_ENUMT(PointSetType_t) set;
      CGNS_ENUMT(PointSetType_t) donorSet;
      CGNS_ENUMT(ZoneType_t) donorType;
      CGNS_ENUMT(DataType_t) dataType;
      cgsize_t points = 0;
      cgsize_t donorPoints = 0;
      this->check(cg_conn_info(this->File, this->Base, this->Zone, c, name.data(), &location, &type, &set, &points,
                    donor.data(), &donorType, &donorSet, &dataType, &donorPoints),
        "general connectivity");
      float center[3];
      float angle[3];
      float translation[3];
      if (cg_conn_periodic_read(this->File, this->Base, this->Zone, c, center, angle, translation) == CG_OK)
      {
        this->addPeriodic(c, set, points, location);
      }
      else if (type != CGNS_ENUMV(Abutting1to1))
      {
        this->Left.add("general connectivity left out",
          this->Where.substr(2) + ", '" + name.data() + "' (" + cg_GridConnectivityTypeName(type) + " with '" +
            donor.data() + "')");
      }
    }
    this->check(cg_nholes(this->File, this->Base, this->Zone, &count), "holes");
    for (int h = 1; h <= count; ++h)
    {
      Name name{};
      CGNS_ENUMT(GridLocation_t) location;
      CGNS_ENUMT(PointSetType_t) set;
      int sets = 0;
      cgsize_t points = 0;
      this->check(
        cg_hole_info(this->File, this->Base, this->Zone, h, name.data(), &location, &set, &sets, &points), "holes");
      this->Left.add("holes of overset grids left out, whose cells are converted",
        this->Where.substr(2) + ", '" + name.data() + "'");
    }
  }

  void addInterface(const DirectedRange& own, const DirectedRange& other, const PointRange& range,
    const PointRange& donorRange, std::array<int, 3> transform)
  {
    // The direction of the normal may be left out: 0.
    int& normal = transform[faceDirection(own.face)];
    normal = normal == 0 ? faceDirection(other.face) + 1 : normal;
    std::string text;
    std::array<bool, 3> used{};
    for (int d = 0; d < 3; ++d)
    {
      text += (d == 0 ? "" : ", ") + std::to_string(transform[d]);
    }
    for (int d = 0; d < 3; ++d)
    {
      const int target = std::abs(transform[d]) - 1;
      if (target < 0 || target > 2 || used[target])
      {
        this->fail("the transform (" + text + ") is no signed permutation of 1, 2, 3");
      }
      used[target] = true;
      const cgsize_t steps = range[3 + d] - range[d];
      const cgsize_t donorSteps = donorRange[3 + target] - donorRange[target];
      if (donorSteps != (transform[d] < 0 ? -steps : steps))
      {
        this->fail("the transform (" + text + ") does not map the range " + toString(range) + " to the donor's range " +
          toString(donorRange));
      }
    }
    // The ranges are flat along the normals only, so the transform maps one normal to the other.
    const bool swapped = std::abs(transform[faceAxis(own.face, 0)]) - 1 != faceAxis(other.face, 0);
    Interface contact;
    try
    {
      checkRange(this->Mesh, own);
      checkRange(this->Mesh, other);
      contact = orderedContact(faceContact(own, other, swapped));
    }
    catch (const Error& error)
    {
      this->fail(error.what());
    }
    // The other zone declares the same contact.
    this->Declared.addContact(contact, this->FileName + this->Where);
  }

  void readBoundaries()
  {
    int conditions = 0;
    this->check(cg_nbocos(this->File, this->Base, this->Zone, &conditions), "boundary conditions");
    const std::string zone = this->Where;
    for (int c = 1; c <= conditions; ++c)
    {
      this->readBoundary(zone, c);
    }
    this->Where = zone;
  }

  /// The mesh can do without the condition that is being read.
  void leaveOut(const std::string& why)
  {
    this->Left.add("boundary conditions left out", this->Where.substr(2) + ": " + why);
  }

  struct Condition
  {
    std::string name;
    CGNS_ENUMT(BCType_t) type;
    CGNS_ENUMT(PointSetType_t) set;
    /// Of points, or of elements.
    cgsize_t count;
  };

  /// Messages are about this condition from here on.
  Condition readCondition(int condition, const std::string& zone)
  {
    this->Where = zone + ", boundary condition " + std::to_string(condition);
    Name name{};
    Condition result{};
    CGNS_ENUMT(DataType_t) normalType;
    cgsize_t normalSize = 0;
    int normalIndex[3];
    int dataSets = 0;
    this->check(cg_boco_info(this->File, this->Base, this->Zone, condition, name.data(), &result.type, &result.set,
                  &result.count, normalIndex, &normalSize, &normalType, &dataSets),
      "");
    result.name = name.data();
    this->Where = zone + ", boundary condition '" + result.name + "'";
    return result;
  }

  void readBoundary(const std::string& zone, int condition)
  {
    const auto [name, type, set, count] = this->readCondition(condition, zone);
    const int block = this->Block;
    const bool isRange = set == CGNS_ENUMV(PointRange);
    if (!isRange && set != CGNS_ENUMV(PointList))
    {
      this->leaveOut(
        std::string("its points are given as ") + cg_PointSetTypeName(set) + ", not as PointRange or PointList");
      return;
    }
    if (isRange ? count != 2 : count < 0 || count > 8 * this->Zones.blocks[block].size())
    {
      this->leaveOut("the number of its points is " + std::to_string(count));
      return;
    }
    CGNS_ENUMT(GridLocation_t) location = CGNS_ENUMV(Vertex);
    this->check(cg_boco_gridlocation_read(this->File, this->Base, this->Zone, condition, &location), "location");
    std::vector<cgsize_t> points(static_cast<std::size_t>(3 * count));
    this->check(cg_boco_read(this->File, this->Base, this->Zone, condition, points.data(), nullptr), "points");

    const BoundaryLabel label = this->boundaryLabel(name, type, condition);
    if (isRange)
    {
      this->addRange(block, points, location, label);
    }
    else
    {
      this->addList(block, points, location, label);
    }
  }

  struct BoundaryLabel
  {
    std::string name;
    std::string type;
  };

  static bool says(CGNS_ENUMT(BCType_t) type)
  {
    return type != CGNS_ENUMV(BCTypeNull) && type != CGNS_ENUMV(BCTypeUserDefined) &&
      type != CGNS_ENUMV(FamilySpecified);
  }

  /// The family of a condition, then those that it has besides.
  std::vector<std::string> familiesOfCondition(int condition)
  {
    std::vector<std::string> families;
    if (cg_goto(this->File, this->Base, "Zone_t", this->Zone, "ZoneBC_t", 1, "BC_t", condition, "end") != CG_OK)
    {
      return families;
    }
    const auto add = [&](const Name& text) {
      const std::string family = this->familyPath(trimmed(text.data()));
      if (!family.empty())
      {
        families.push_back(family);
      }
    };
    Name text{};
    if (cg_famname_read(text.data()) == CG_OK)
    {
      add(text);
    }
    int others = 0;
    if (cg_nmultifam(&others) != CG_OK)
    {
      return families;
    }
    for (int n = 1; n <= others; ++n)
    {
      Name node{};
      text.fill(0);
      if (cg_multifam_read(n, node.data(), text.data()) == CG_OK)
      {
        add(text);
      }
    }
    return families;
  }

  /// Its name is that of its (first) family, or its own one if that is more than a number; its type is its own one, or
  /// else that of its family.
  BoundaryLabel boundaryLabel(const std::string& own, CGNS_ENUMT(BCType_t) ownType, int condition)
  {
    CGNS_ENUMT(BCType_t) type = ownType;
    std::string name = trimmed(own);
    const std::vector<std::string> families = this->familiesOfCondition(condition);
    for (const std::string& family : families)
    {
      type = says(type) ? type : this->typeOfFamily(family);
    }
    if (!families.empty())
    {
      name = families[0];
    }
    else if (says(type) && isNumbered(name))
    {
      name = cg_BCTypeName(type);
    }
    return { validUTF8(name), says(type) ? cg_BCTypeName(type) : UnknownBoundaryType };
  }

  /// Types of the families of the base, by name.
  void readFamilies()
  {
    this->TypeOfFamily.clear();
    this->ParentsOfFamily.clear();
    int families = 0;
    this->check(cg_nfamilies(this->File, this->Base, &families), "families");
    for (int f = 1; f <= families; ++f)
    {
      Name name{};
      int conditions = 0;
      int geometries = 0;
      this->check(cg_family_read(this->File, this->Base, f, name.data(), &conditions, &geometries), "family");
      for (int c = 1; c <= conditions; ++c)
      {
        Name condition{};
        CGNS_ENUMT(BCType_t) type;
        this->check(cg_fambc_read(this->File, this->Base, f, c, condition.data(), &type), "type of a family");
        this->TypeOfFamily.emplace(trimmed(name.data()), type);
      }
      int parents = 0;
      this->check(cg_nfamily_names(this->File, this->Base, f, &parents), "parents of a family");
      for (int p = 1; p <= parents; ++p)
      {
        Name node{};
        Name parent{};
        this->check(
          cg_family_name_read(this->File, this->Base, f, p, node.data(), parent.data()), "parent of a family");
        this->ParentsOfFamily[trimmed(name.data())].push_back(trimmed(parent.data()));
      }
      this->readNestedFamilies("/" + this->BaseName + "/" + name.data(), trimmed(name.data()), 0);
    }
  }

  /// Families within a family; `path` leads to it in the file, `family` from the base.
  void readNestedFamilies(
    [[maybe_unused]] const std::string& path, [[maybe_unused]] const std::string& family, [[maybe_unused]] int depth)
  {
#if CGNS_VERSION >= 4000
    constexpr int MaxDepth = 20;
    int count = 0;
    if (depth > MaxDepth || cg_gopath(this->File, path.c_str()) != CG_OK || cg_node_nfamilies(&count) != CG_OK)
    {
      return;
    }
    for (int f = 1; f <= count; ++f)
    {
      Name name{};
      int conditions = 0;
      int geometries = 0;
      this->check(cg_gopath(this->File, path.c_str()), "family");
      this->check(cg_node_family_read(f, name.data(), &conditions, &geometries), "family");
      const std::string nested = family + "/" + trimmed(name.data());
      const std::string place = path + "/" + name.data();
      if (conditions > 0)
      {
        Name condition{};
        CGNS_ENUMT(BCType_t) type;
        this->check(cg_gopath(this->File, place.c_str()), "family");
        this->check(cg_node_fambc_read(1, condition.data(), &type), "type of a family");
        this->TypeOfFamily.emplace(nested, type);
      }
      this->readNestedFamilies(place, nested, depth + 1);
    }
#endif
  }

  /// The type of a family, or else of one that it belongs to: of what its path or its FamilyName_t name.
  CGNS_ENUMT(BCType_t) typeOfFamily(const std::string& family, int depth = 0) const
  {
    constexpr int MaxDepth = 20;
    const auto known = this->TypeOfFamily.find(family);
    if (known != this->TypeOfFamily.end() && says(known->second))
    {
      return known->second;
    }
    std::vector<std::string> parents;
    const auto named = this->ParentsOfFamily.find(family);
    if (named != this->ParentsOfFamily.end())
    {
      parents = named->second;
    }
    if (family.find('/') != std::string::npos)
    {
      parents.push_back(family.substr(0, family.rfind('/')));
    }
    for (const std::string& parent : parents)
    {
      const CGNS_ENUMT(BCType_t) type =
        depth < MaxDepth ? this->typeOfFamily(this->familyPath(parent), depth + 1) : CGNS_ENUMV(BCTypeNull);
      if (says(type))
      {
        return type;
      }
    }
    return CGNS_ENUMV(BCTypeNull);
  }

  /// A family's name without the base, which may stand before it: /base/family.
  std::string familyPath(const std::string& name) const
  {
    const bool fromRoot = name.rfind('/', 0) == 0;
    const std::string path = name.substr(fromRoot);
    const std::string base = this->BaseName + "/";
    return trimmed(path.rfind(base, 0) == 0 ? path.substr(base.size())
        : fromRoot                          ? path.substr(path.rfind('/') + 1)
                                            : path);
  }

  /// How the points of a condition are meant.
  struct Location
  {
    /// Direction of the normal of faces that are listed by their centres, -1 if mesh points are listed.
    int normal = -1;
    /// Whether cells at the boundary are listed instead of its faces.
    bool cells = false;
  };

  /// @param points all points of a list, or the two corners of a range
  /// @return false if they are not known to lie on one face.
  bool locate(
    int block, const std::vector<cgsize_t>& points, CGNS_ENUMT(GridLocation_t) location, Location& found) const
  {
    switch (location)
    {
      case CGNS_ENUMV(GridLocationNull):
      case CGNS_ENUMV(Vertex):
        return true;
      case CGNS_ENUMV(IFaceCenter):
      case CGNS_ENUMV(JFaceCenter):
      case CGNS_ENUMV(KFaceCenter):
        found.normal = static_cast<int>(location) - static_cast<int>(CGNS_ENUMV(IFaceCenter));
        return true;
      case CGNS_ENUMV(FaceCenter):
      case CGNS_ENUMV(CellCenter):
        break;
      default:
        return false;
    }
    // The faces do not say which way they look: they lie on the side on which all of them are.
    found.cells = location == CGNS_ENUMV(CellCenter);
    int sides = 0;
    for (int d = 0; d < 3; ++d)
    {
      const cgsize_t last = this->counts(block)[d] - (found.cells ? 1 : 0);
      bool flat = true;
      for (std::size_t p = 0; p + 2 < points.size(); p += 3)
      {
        flat = flat && points[p + d] == points[d];
      }
      if (flat && !points.empty() && (points[d] == 1 || points[d] == last))
      {
        found.normal = d;
        ++sides;
      }
    }
    return sides == 1;
  }

  /// Faces are numbered by their mesh plane: those of the last cells lie on the plane behind them.
  static cgsize_t planeOf(cgsize_t index, cgsize_t count, bool cells)
  {
    return cells && index == count - 1 ? count : index;
  }

  void addRange(
    int block, const std::vector<cgsize_t>& points, CGNS_ENUMT(GridLocation_t) location, const BoundaryLabel& label)
  {
    PointRange range{};
    for (int d = 0; d < 3; ++d)
    {
      range[d] = std::min(points[d], points[3 + d]);
      range[3 + d] = std::max(points[d], points[3 + d]);
    }
    Location at;
    if (!this->locate(block, points, location, at))
    {
      this->leaveOut("the range " + toString(range) + " at " + cg_GridLocationName(location) +
        " is not that of faces on one side of the zone");
      return;
    }
    for (int d = 0; d < 3; ++d)
    {
      if (d == at.normal)
      {
        range[d] = planeOf(range[d], this->counts(block)[d], at.cells);
        range[3 + d] = planeOf(range[3 + d], this->counts(block)[d], at.cells);
      }
      else if (at.normal >= 0)
      {
        // Face n lies between the points n and n + 1.
        ++range[3 + d];
      }
    }
    DirectedRange found;
    try
    {
      if (!this->faceRange(block, range, found))
      {
        return; // a line or a point bounds nothing
      }
    }
    catch (const Error& error)
    {
      const std::string text = error.what();
      this->leaveOut(text.substr(std::min(text.size(), this->FileName.size() + this->Where.size() + 2)));
      return;
    }
    this->Declared.addBoundary(found, label.name, label.type, this->Where.substr(2));
  }

  /// A list may cover several faces, or parts of them: marks the quadrilaterals and cuts them into rectangles.
  void addList(
    int block, const std::vector<cgsize_t>& points, CGNS_ENUMT(GridLocation_t) location, const BoundaryLabel& label)
  {
    Location at;
    if (!this->locate(block, points, location, at))
    {
      this->leaveOut(std::string("the points of its list at ") + cg_GridLocationName(location) +
        " are not those of faces on one side of the zone");
      return;
    }
    const int normal = at.normal;
    const Ijk& size = this->counts(block);
    for (std::size_t p = 0; p + 2 < points.size(); p += 3)
    {
      for (int d = 0; d < 3; ++d)
      {
        const cgsize_t last = size[d] - ((normal >= 0 && d != normal) || at.cells ? 1 : 0);
        if (points[p + d] < 1 || points[p + d] > last)
        {
          this->leaveOut("the point (" + std::to_string(points[p]) + ", " + std::to_string(points[p + 1]) + ", " +
            std::to_string(points[p + 2]) + ") of its list leaves the " + bsv::toString(size) + " points of the zone");
          return;
        }
      }
    }
    bool any = false;
    for (int face = 0; face < 6; ++face)
    {
      const int axes[2] = { faceAxis(face, 0), faceAxis(face, 1) };
      const int ns = size[axes[0]];
      const int nt = size[axes[1]];
      // Of points (vertices) or of quadrilaterals, whichever is listed.
      std::vector<char> listed(static_cast<std::size_t>(ns) * nt, 0);
      for (std::size_t p = 0; p + 2 < points.size(); p += 3)
      {
        const int d = faceDirection(face);
        const cgsize_t side = faceSide(face) == 0 ? 1 : size[d];
        if ((normal < 0 || normal == d) && planeOf(points[p + d], size[d], at.cells) == side)
        {
          listed[(points[p + axes[1]] - 1) * ns + points[p + axes[0]] - 1] = 1;
        }
      }
      const auto isCovered = [&](int s, int t) {
        const std::size_t q = static_cast<std::size_t>(t) * ns + s;
        return listed[q] && (normal >= 0 || (listed[q + 1] && listed[q + ns] && listed[q + ns + 1]));
      };
      std::vector<char> open(static_cast<std::size_t>(ns - 1) * (nt - 1), 0);
      for (int t = 0; t + 1 < nt; ++t)
      {
        for (int s = 0; s + 1 < ns; ++s)
        {
          open[static_cast<std::size_t>(t) * (ns - 1) + s] = isCovered(s, t);
        }
      }
      for (const FaceRange& part : cutIntoRectangles(open, ns - 1, nt - 1))
      {
        this->Declared.addBoundary({ block, face, part.lo, part.hi }, label.name, label.type, this->Where.substr(2));
        any = true;
      }
    }
    if (!any && points.size() > 6)
    {
      this->leaveOut("its list covers no quadrilateral of the zone's faces");
    }
  }

  QuietErrors Quiet;
  std::string FileName;
  const Execution& Run;
  const Piece Part;
  const BlockMemory& Memory;
  MemoryDemand Demand{ this->FileName, "its points" };
  const int Step;
  int File = 0;
  bool IsOpen = false;
  int Base = 0;
  int Zone = 0;
  /// The block of the current zone.
  int Block = 0;
  /// What is being read, for error messages.
  std::string Where;
  /// The coordinates of the zone that is being read.
  std::array<std::string, 3> Axes;
  bool Cylindrical = false;
  double ToRadians = 1.0;
  std::vector<std::string> CylindricalZones;
  /// The first zone of every length unit.
  std::map<std::string, std::string> ZoneOfUnit;
  CGNSZones Zones;
  /// Where each block comes from.
  struct Place
  {
    int base, zone;
    std::string where;
  };
  std::vector<Place> Places;
  DeclaredConnectivity Declared;
  Leftovers Left;
  std::string BaseName;
  /// Of the families of the base, by their path from it.
  std::map<std::string, CGNS_ENUMT(BCType_t)> TypeOfFamily;
  std::map<std::string, std::vector<std::string>> ParentsOfFamily;
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
  const std::lock_guard<std::mutex> lock(libraryGuard());
  return CGNSReader(fileName, run, piece, memory, step).read();
}

std::vector<double> loadCGNSTimes(const std::string& fileName)
{
  const std::lock_guard<std::mutex> lock(libraryGuard());
  return CGNSReader(fileName, {}, {}, {}, 0).times();
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
  CGNSZones zones;
  zones = loadCGNSApart(fileName, run, piece, step);
  BlockMesh mesh;
  for (const GridBlock& block : zones.blocks)
  {
    mesh.blocks.push_back(meshBlock(block));
  }
  checkContacts(mesh, zones.contacts, *run.ranks);
  return zones;
}

} // namespace bsv
