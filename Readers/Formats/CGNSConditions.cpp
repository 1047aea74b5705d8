// SPDX-License-Identifier: BSD-3-Clause
// Boundary conditions of CGNS zones, and the families that name them and give them types.
#include "Formats/CGNSInput.h"

#include "Base/UTF8.h"

#include <algorithm>
#include <cctype>
#include <iterator>

namespace bsv::cgns
{

namespace
{

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

bool says(CGNS_ENUMT(BCType_t) type)
{
  return type != CGNS_ENUMV(BCTypeNull) && type != CGNS_ENUMV(BCTypeUserDefined) && type != CGNS_ENUMV(FamilySpecified);
}

} // namespace

Condition readCondition(Input& input, int number, const std::string& zone)
{
  input.where = zone + ", boundary condition " + std::to_string(number);
  Name name{};
  Condition result{};
  CGNS_ENUMT(DataType_t) normalType;
  cgsize_t normalSize = 0;
  int normalIndex[3];
  int dataSets = 0;
  input.check(cg_boco_info(input.file, input.base, input.zone, number, name.data(), &result.type, &result.set,
                &result.count, normalIndex, &normalSize, &normalType, &dataSets),
    "");
  result.name = name.data();
  input.where = zone + ", boundary condition '" + result.name + "'";
  return result;
}

void readPoints(Input& input, const Families& families, int number, int size, Condition& condition)
{
  condition.location = CGNS_ENUMV(Vertex);
  input.check(cg_boco_gridlocation_read(input.file, input.base, input.zone, number, &condition.location), "location");
  condition.points.resize(static_cast<std::size_t>(size * condition.count));
  input.check(cg_boco_read(input.file, input.base, input.zone, number, condition.points.data(), nullptr), "points");
  condition.label = families.label(input, condition.name, condition.type, number);
}

void Families::read(Input& input, const std::string& base)
{
  this->Base = base;
  this->Names.clear();
  this->Types.clear();
  this->Parents.clear();
  int families = 0;
  input.check(cg_nfamilies(input.file, input.base, &families), "families");
  for (int f = 1; f <= families; ++f)
  {
    Name name{};
    int conditions = 0;
    int geometries = 0;
    input.check(cg_family_read(input.file, input.base, f, name.data(), &conditions, &geometries), "family");
    this->Names.push_back(trimmed(name.data()));
    for (int c = 1; c <= conditions; ++c)
    {
      Name condition{};
      CGNS_ENUMT(BCType_t) type;
      input.check(cg_fambc_read(input.file, input.base, f, c, condition.data(), &type), "type of a family");
      this->Types.emplace(trimmed(name.data()), type);
    }
    int parents = 0;
    input.check(cg_nfamily_names(input.file, input.base, f, &parents), "parents of a family");
    for (int p = 1; p <= parents; ++p)
    {
      Name node{};
      Name parent{};
      input.check(cg_family_name_read(input.file, input.base, f, p, node.data(), parent.data()), "parent of a family");
      this->Parents[trimmed(name.data())].push_back(trimmed(parent.data()));
    }
    this->readNested(input, "/" + this->Base + "/" + name.data(), trimmed(name.data()), 0);
  }
}

/// Families within a family; `path` leads to it in the file, `family` from the base.
void Families::readNested([[maybe_unused]] const Input& input, [[maybe_unused]] const std::string& path,
  [[maybe_unused]] const std::string& family, [[maybe_unused]] int depth)
{
#if CGNS_VERSION >= 4000
  constexpr int MaxDepth = 20;
  int count = 0;
  if (depth > MaxDepth || cg_gopath(input.file, path.c_str()) != CG_OK || cg_node_nfamilies(&count) != CG_OK)
  {
    return;
  }
  for (int f = 1; f <= count; ++f)
  {
    Name name{};
    int conditions = 0;
    int geometries = 0;
    input.check(cg_gopath(input.file, path.c_str()), "family");
    input.check(cg_node_family_read(f, name.data(), &conditions, &geometries), "family");
    const std::string nested = family + "/" + trimmed(name.data());
    const std::string place = path + "/" + name.data();
    if (conditions > 0)
    {
      Name condition{};
      CGNS_ENUMT(BCType_t) type;
      input.check(cg_gopath(input.file, place.c_str()), "family");
      input.check(cg_node_fambc_read(1, condition.data(), &type), "type of a family");
      this->Types.emplace(nested, type);
    }
    this->readNested(input, place, nested, depth + 1);
  }
#endif
}

void Families::tellUnknown(Input& input, const std::string& family) const
{
  const auto lower = [](std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
    return text;
  };
  // Families within families are not known to all versions of the library.
  if (family.find('/') == std::string::npos &&
    std::find(this->Names.begin(), this->Names.end(), family) == this->Names.end())
  {
    const auto alike = std::find_if(
      this->Names.begin(), this->Names.end(), [&](const std::string& name) { return lower(name) == lower(family); });
    input.left.add("families that the file does not have, so that their boundaries have no type",
      input.where.substr(2) + ": '" + family + "'" + (alike == this->Names.end() ? "" : " (it has '" + *alike + "')"));
  }
}

BoundaryLabel Families::label(Input& input, const std::string& own, CGNS_ENUMT(BCType_t) ownType, int condition) const
{
  CGNS_ENUMT(BCType_t) type = ownType;
  std::string name = trimmed(own);
  const std::vector<std::string> families = this->ofCondition(input, condition);
  for (const std::string& family : families)
  {
    type = says(type) ? type : this->typeOf(family);
  }
  if (!families.empty())
  {
    name = families[0];
  }
  else if (says(type) && isNumbered(name))
  {
    name = cg_BCTypeName(type);
  }
  for (std::size_t f = 0; f < families.size() && ownType == CGNS_ENUMV(FamilySpecified) && !says(type); ++f)
  {
    this->tellUnknown(input, families[f]);
  }
  return { validUTF8(name), says(type) ? cg_BCTypeName(type) : UnknownBoundaryType };
}

/// The family of a condition, then those that it has besides.
std::vector<std::string> Families::ofCondition(const Input& input, int condition) const
{
  std::vector<std::string> families;
  if (cg_goto(input.file, input.base, "Zone_t", input.zone, "ZoneBC_t", 1, "BC_t", condition, "end") != CG_OK)
  {
    return families;
  }
  const auto add = [&](const Name& text) {
    const std::string family = this->pathOf(trimmed(text.data()));
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

/// The type of a family, or else of one that it belongs to: of what its path or its FamilyName_t name.
CGNS_ENUMT(BCType_t) Families::typeOf(const std::string& family, int depth) const
{
  constexpr int MaxDepth = 20;
  const auto known = this->Types.find(family);
  if (known != this->Types.end() && says(known->second))
  {
    return known->second;
  }
  std::vector<std::string> parents;
  const auto named = this->Parents.find(family);
  if (named != this->Parents.end())
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
      depth < MaxDepth ? this->typeOf(this->pathOf(parent), depth + 1) : CGNS_ENUMV(BCTypeNull);
    if (says(type))
    {
      return type;
    }
  }
  return CGNS_ENUMV(BCTypeNull);
}

/// A family's name without the base, which may stand before it: /base/family.
std::string Families::pathOf(const std::string& name) const
{
  const bool fromRoot = name.rfind('/', 0) == 0;
  const std::string path = name.substr(fromRoot);
  const std::string base = this->Base + "/";
  return trimmed(path.rfind(base, 0) == 0 ? path.substr(base.size())
      : fromRoot                          ? path.substr(path.rfind('/') + 1)
                                          : path);
}

} // namespace bsv::cgns
