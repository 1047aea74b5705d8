// SPDX-License-Identifier: BSD-3-Clause
// Unstructured CGNS zones of hexahedra.
#include "Formats/CGNSInput.h"

#include "Base/UTF8.h"

#include <algorithm>
#include <limits>

namespace bsv::cgns
{

namespace
{

/// An element of an unstructured zone that is a quadrilateral: its number in the zone, its section, its corners.
struct Quad
{
  cgsize_t number;
  int section;
  std::array<Index, 4> points;
};

/// Boundaries of one name and of several types are several.
HexZone::Boundary& boundaryOf(HexZone& zone, const std::string& name, const std::string& type)
{
  const auto isKnown = [](const std::string& t) { return t != UnknownBoundaryType; };
  const auto find = [&](const std::string& wanted) {
    return std::find_if(zone.boundaries.begin(), zone.boundaries.end(),
      [&](const HexZone::Boundary& boundary) { return boundary.name == wanted; });
  };
  auto known = find(name);
  const bool differs = known != zone.boundaries.end() && isKnown(type) && isKnown(known->type) && type != known->type;
  const std::string own = differs ? name + " (" + type + ")" : name;
  known = differs ? find(own) : known;
  if (known != zone.boundaries.end())
  {
    known->type = isKnown(known->type) ? known->type : type;
    return *known;
  }
  zone.boundaries.push_back({ own, type, {} });
  return zone.boundaries.back();
}

void addQuad(HexZone::Boundary& boundary, const std::array<Index, 4>& points)
{
  boundary.quadrilaterals.insert(boundary.quadrilaterals.end(), points.begin(), points.end());
}

void addElement(const Input& input, CGNS_ENUMT(ElementType_t) type, cgsize_t number, int section, const cgsize_t* nodes,
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
    input.fail(where + ", element " + std::to_string(number) + ", is a " + kind +
      "; only hexahedra, with quadrilaterals at their boundaries, can be part of blocks");
  }
}

void readSection(const Input& input, int section, cgsize_t pointCount, HexZone& zone, std::vector<Quad>& quads,
  std::vector<std::string>& sections)
{
  Name name{};
  CGNS_ENUMT(ElementType_t) type;
  cgsize_t first = 0;
  cgsize_t last = 0;
  int boundary = 0;
  int parents = 0;
  input.check(cg_section_read(
                input.file, input.base, input.zone, section, name.data(), &type, &first, &last, &boundary, &parents),
    "section");
  const std::string where = "section '" + std::string(name.data()) + "'";
  sections.push_back(validUTF8(trimmed(name.data())));
  cgsize_t size = 0;
  input.check(cg_ElementDataSize(input.file, input.base, input.zone, section, &size), where);
  const bool mixed = type == CGNS_ENUMV(MIXED);
  int nodes = 0;
  if (!mixed && (cg_npe(type, &nodes) != CG_OK || nodes < 1))
  {
    input.fail(where + " has elements of type " + cg_ElementTypeName(type) + "; only hexahedra can be part of blocks");
  }
  if (last < first || size < 0 || size / std::max(1, nodes) < last - first + 1)
  {
    input.fail(where + " has the elements " + std::to_string(first) + " to " + std::to_string(last) + " in " +
      std::to_string(size) + " numbers");
  }
  std::vector<cgsize_t> values(static_cast<std::size_t>(size));
  const auto read = [&] {
#if CGNS_VERSION >= 4000
    if (mixed)
    {
      std::vector<cgsize_t> offsets(static_cast<std::size_t>(last - first + 2));
      return cg_poly_elements_read(input.file, input.base, input.zone, section, values.data(), offsets.data(), nullptr);
    }
#endif
    return cg_elements_read(input.file, input.base, input.zone, section, values.data(), nullptr);
  };
  input.check(read(), where);
  std::size_t at = 0;
  for (cgsize_t number = first; number <= last; ++number)
  {
    CGNS_ENUMT(ElementType_t) own = type;
    if (mixed)
    {
      own = static_cast<CGNS_ENUMT(ElementType_t)>(at < values.size() ? values[at++] : 0);
      if (cg_npe(own, &nodes) != CG_OK || nodes < 1)
      {
        input.fail(where + ", element " + std::to_string(number) + ", has the unknown type " + std::to_string(own));
      }
    }
    if (at + static_cast<std::size_t>(nodes) > values.size())
    {
      input.fail(where + " ends before element " + std::to_string(number));
    }
    for (int n = 0; n < nodes; ++n)
    {
      if (values[at + n] < 1 || values[at + n] > pointCount)
      {
        input.fail(where + ", element " + std::to_string(number) + ", has the point " + std::to_string(values[at + n]) +
          " of " + std::to_string(pointCount));
      }
    }
    addElement(input, own, number, section - 1, values.data() + at, where, zone, quads);
    at += static_cast<std::size_t>(nodes);
  }
}

/// The faces that only one cell has and all of whose points are meant.
template <typename Has>
void addFacesOfPoints(const HexZone& zone, const Has& has, HexZone::Boundary& boundary)
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

void readHexBoundaries(Input& input, const Families& families, cgsize_t pointCount, HexZone& zone,
  const std::vector<Quad>& quads, std::vector<char>& used)
{
  int conditions = 0;
  input.check(cg_nbocos(input.file, input.base, input.zone, &conditions), "boundary conditions");
  const std::string where = input.where;
  for (int c = 1; c <= conditions; ++c)
  {
    Condition condition = readCondition(input, c, where);
    const auto set = condition.set;
    const cgsize_t count = condition.count;
    const bool range = set == CGNS_ENUMV(PointRange) || set == CGNS_ENUMV(ElementRange);
    const bool list = set == CGNS_ENUMV(PointList) || set == CGNS_ENUMV(ElementList);
    if (set == CGNS_ENUMV(PointSetTypeNull) || count == 0)
    {
      input.leaveOut("it has no points");
      continue;
    }
    if ((!range && !list) || (range && count != 2) || count < 0 || count > 8 * pointCount)
    {
      input.leaveOut("its faces are given as " + std::to_string(count) + " points of a " + cg_PointSetTypeName(set));
      continue;
    }
    readPoints(input, families, c, 1, condition);
    const bool points = (set == CGNS_ENUMV(PointRange) || set == CGNS_ENUMV(PointList)) &&
      (condition.location == CGNS_ENUMV(Vertex) || condition.location == CGNS_ENUMV(GridLocationNull));
    std::vector<cgsize_t>& numbers = condition.points;
    std::sort(numbers.begin(), numbers.end());
    const auto has = [&](cgsize_t number) {
      return range ? number >= numbers[0] && number <= numbers[1]
                   : std::binary_search(numbers.begin(), numbers.end(), number);
    };
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
      input.leaveOut("no quadrilateral of the zone is meant by it");
      continue;
    }
    std::vector<Index>& all = boundaryOf(zone, condition.label.name, condition.label.type).quadrilaterals;
    all.insert(all.end(), found.quadrilaterals.begin(), found.quadrilaterals.end());
  }
  input.where = where;
}

} // namespace

HexZone readHexZone(Input& input, const Families& families, Coordinates& coordinates, const std::string& name,
  cgsize_t pointCount, bool here)
{
  if (pointCount < 8 || pointCount > std::numeric_limits<int>::max())
  {
    input.fail("the zone has " + std::to_string(pointCount) + " points; hexahedra need at least 8");
  }
  HexZone zone;
  zone.name = name;
  std::vector<Quad> quads;
  std::vector<std::string> sections;
  int count = 0;
  input.check(cg_nsections(input.file, input.base, input.zone, &count), "sections");
  for (int s = 1; s <= count; ++s)
  {
    readSection(input, s, pointCount, zone, quads, sections);
  }
  std::sort(quads.begin(), quads.end(), [](const Quad& a, const Quad& b) { return a.number < b.number; });
  std::vector<char> used(quads.size(), 0);
  readHexBoundaries(input, families, pointCount, zone, quads, used);
  for (std::size_t q = 0; q < quads.size(); ++q)
  {
    if (!used[q])
    {
      addQuad(boundaryOf(zone, sections[quads[q].section], UnknownBoundaryType), quads[q].points);
    }
  }
  if (here)
  {
    GridBlock points;
    points.name = zone.name;
    points.counts = { static_cast<int>(pointCount), 1, 1 };
    coordinates.read(points);
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
  return zone;
}

} // namespace bsv::cgns
