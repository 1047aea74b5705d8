// SPDX-License-Identifier: BSD-3-Clause
// Connectivity of structured CGNS zones.
#include "Formats/CGNSInput.h"

#include <cstdlib>

namespace bsv::cgns
{

namespace
{

/// -1 for a zone that is not among the blocks, as where some zones of a mesh were written alone.
int donorBlock(const StructuredZone& own, const std::string& name)
{
  // A donor may be given with its base: /base/zone.
  const std::string zone = name.substr(name.rfind('/') + 1);
  const auto found = own.blockOfName.find(zone);
  return found == own.blockOfName.end() ? -1 : found->second;
}

void addInterface(const StructuredZone& zone, const DirectedRange& own, const DirectedRange& other,
  const PointRange& range, const PointRange& donorRange, std::array<int, 3> transform)
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
      zone.input.fail("the transform (" + text + ") is no signed permutation of 1, 2, 3");
    }
    used[target] = true;
    const cgsize_t steps = range[3 + d] - range[d];
    const cgsize_t donorSteps = donorRange[3 + target] - donorRange[target];
    if (donorSteps != (transform[d] < 0 ? -steps : steps))
    {
      zone.input.fail("the transform (" + text + ") does not map the range " + toString(range) +
        " to the donor's range " + toString(donorRange));
    }
  }
  // The ranges are flat along the normals only, so the transform maps one normal to the other.
  const bool swapped = std::abs(transform[faceAxis(own.face, 0)]) - 1 != faceAxis(other.face, 0);
  Interface contact;
  try
  {
    checkRange(zone.mesh, own);
    checkRange(zone.mesh, other);
    contact = orderedContact(faceContact(own, other, swapped));
  }
  catch (const Error& error)
  {
    zone.input.fail(error.what());
  }
  // The other zone declares the same contact.
  zone.declared.addContact(contact, zone.input.fileName + zone.input.where);
}

/// The boundary of a periodic contact that lists its points.
void addPeriodic(const StructuredZone& zone, int connection, CGNS_ENUMT(PointSetType_t) set, cgsize_t count,
  CGNS_ENUMT(GridLocation_t) location)
{
  Input& input = zone.input;
  const bool isRange = set == CGNS_ENUMV(PointRange) && count == 2;
  const std::string where = input.where;
  input.where += ", connection " + std::to_string(connection);
  if (!isRange && (set != CGNS_ENUMV(PointList) || !zone.canHave(count, isRange)))
  {
    input.left.add("periodic sides without a name",
      input.where.substr(2) + ", has " + std::to_string(count) + " points of a " + cg_PointSetTypeName(set));
    input.where = where;
    return;
  }
  std::vector<cgsize_t> points(static_cast<std::size_t>(3 * count));
  input.check(cg_conn_read_short(input.file, input.base, input.zone, connection, points.data()), "points");
  addBoundary(zone, isRange, points, location, { "Periodic", UnknownBoundaryType });
  input.where = where;
}

/// What joins zones otherwise than by ranges point to point. Lists of coincident points need no word: the points
/// tell, unless they are periodic.
void readGeneralConnections(const StructuredZone& zone)
{
  Input& input = zone.input;
  int count = 0;
  input.check(cg_nconns(input.file, input.base, input.zone, &count), "general connectivity");
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
    input.check(cg_conn_info(input.file, input.base, input.zone, c, name.data(), &location, &type, &set, &points,
                  donor.data(), &donorType, &donorSet, &dataType, &donorPoints),
      "general connectivity");
    float center[3];
    float angle[3];
    float translation[3];
    if (cg_conn_periodic_read(input.file, input.base, input.zone, c, center, angle, translation) == CG_OK)
    {
      addPeriodic(zone, c, set, points, location);
    }
    else if (type != CGNS_ENUMV(Abutting1to1))
    {
      input.left.add("general connectivity left out",
        input.where.substr(2) + ", '" + name.data() + "' (" + cg_GridConnectivityTypeName(type) + " with '" +
          donor.data() + "')");
    }
  }
  input.check(cg_nholes(input.file, input.base, input.zone, &count), "holes");
  for (int h = 1; h <= count; ++h)
  {
    Name name{};
    CGNS_ENUMT(GridLocation_t) location;
    CGNS_ENUMT(PointSetType_t) set;
    int sets = 0;
    cgsize_t points = 0;
    input.check(
      cg_hole_info(input.file, input.base, input.zone, h, name.data(), &location, &set, &sets, &points), "holes");
    input.left.add(
      "holes of overset grids left out, whose cells are converted", input.where.substr(2) + ", '" + name.data() + "'");
  }
}

} // namespace

std::string toString(const PointRange& range)
{
  const auto point = [&](int at) {
    return "(" + std::to_string(range[at]) + ", " + std::to_string(range[at + 1]) + ", " +
      std::to_string(range[at + 2]) + ")";
  };
  return point(0) + " to " + point(3);
}

bool faceRange(const StructuredZone& zone, int block, const PointRange& range, DirectedRange& found)
{
  const Input& input = zone.input;
  const Ijk& counts = zone.mesh.blocks[block].points.counts();
  const std::string& name = zone.mesh.blocks[block].name;
  int flat = 0;
  found.block = block;
  for (int d = 0; d < 3; ++d)
  {
    const int count = counts[d];
    for (const cgsize_t index : { range[d], range[3 + d] })
    {
      if (index < 1 || index > count)
      {
        input.fail(
          "the range " + toString(range) + " leaves the " + bsv::toString(counts) + " points of zone '" + name + "'");
      }
    }
    if (range[d] == range[3 + d])
    {
      ++flat;
      found.face = 2 * d + (range[d] == 1 ? 0 : 1);
      if (flat == 1 && range[d] != 1 && range[d] != count)
      {
        input.fail("the range " + toString(range) + " lies inside zone '" + name + "', not on a face");
      }
    }
  }
  if (flat == 0)
  {
    input.fail("the range " + toString(range) + " is not on a face of zone '" + name + "'");
  }
  for (int axis = 0; axis < 2; ++axis)
  {
    found.begin[axis] = static_cast<int>(range[faceAxis(found.face, axis)]) - 1;
    found.end[axis] = static_cast<int>(range[3 + faceAxis(found.face, axis)]) - 1;
  }
  return flat == 1;
}

void readInterfaces(const StructuredZone& zone)
{
  Input& input = zone.input;
  int contacts = 0;
  input.check(cg_n1to1(input.file, input.base, input.zone, &contacts), "interfaces");
  const std::string where = input.where;
  for (int c = 1; c <= contacts; ++c)
  {
    Name name{};
    Name donor{};
    PointRange range{};
    PointRange donorRange{};
    std::array<int, 3> transform{};
    input.check(cg_1to1_read(input.file, input.base, input.zone, c, name.data(), donor.data(), range.data(),
                  donorRange.data(), transform.data()),
      "interface " + std::to_string(c));
    input.where = where + ", interface '" + name.data() + "'";

    DirectedRange own;
    if (!faceRange(zone, zone.block, range, own))
    {
      continue; // a line or a point joins nothing
    }
    float center[3];
    float angle[3];
    float translation[3];
    if (cg_1to1_periodic_read(input.file, input.base, input.zone, c, center, angle, translation) == CG_OK)
    {
      zone.declared.addBoundary(own, "Periodic", UnknownBoundaryType, input.where.substr(2));
      continue;
    }
    const int block = donorBlock(zone, donor.data());
    if (block < 0)
    {
      input.left.add("interfaces left out whose donor zone is not among the blocks",
        input.where.substr(2) + ": '" + donor.data() + "'");
      continue;
    }
    DirectedRange other;
    if (!faceRange(zone, block, donorRange, other))
    {
      input.left.add("interfaces left out whose donor range is a line or a point",
        input.where.substr(2) + ": " + toString(donorRange));
      continue;
    }
    addInterface(zone, own, other, range, donorRange, transform);
  }
  input.where = where;
  readGeneralConnections(zone);
}

} // namespace bsv::cgns
