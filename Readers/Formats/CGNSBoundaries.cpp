// SPDX-License-Identifier: BSD-3-Clause
// Boundary conditions on the faces of structured CGNS zones.
#include "Formats/CGNSInput.h"

#include <algorithm>

namespace bsv::cgns
{

namespace
{

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
  const Ijk& counts, const std::vector<cgsize_t>& points, CGNS_ENUMT(GridLocation_t) location, Location& found)
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
    const cgsize_t last = counts[d] - (found.cells ? 1 : 0);
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
cgsize_t planeOf(cgsize_t index, cgsize_t count, bool cells)
{
  return cells && index == count - 1 ? count : index;
}

void addRange(const StructuredZone& zone, const std::vector<cgsize_t>& points, CGNS_ENUMT(GridLocation_t) location,
  const BoundaryLabel& label)
{
  Input& input = zone.input;
  const Ijk& counts = zone.counts();
  PointRange range{};
  for (int d = 0; d < 3; ++d)
  {
    range[d] = std::min(points[d], points[3 + d]);
    range[3 + d] = std::max(points[d], points[3 + d]);
  }
  Location at;
  if (!locate(counts, points, location, at))
  {
    input.leaveOut("the range " + toString(range) + " at " + cg_GridLocationName(location) +
      " is not that of faces on one side of the zone");
    return;
  }
  for (int d = 0; d < 3 && at.normal >= 0; ++d)
  {
    const cgsize_t last = counts[d] - (d != at.normal || at.cells ? 1 : 0);
    if (range[d] < 1 || range[3 + d] > last)
    {
      input.leaveOut("the range " + toString(range) + " at " + cg_GridLocationName(location) + " leaves the " +
        std::to_string(last) +
        (at.cells            ? " cells"
            : d == at.normal ? " layers of faces"
                             : " faces") +
        " of the zone along " + "ijk"[d] + (range[3 + d] == counts[d] ? ", as if it counted points" : ""));
      return;
    }
  }
  for (int d = 0; d < 3; ++d)
  {
    if (d == at.normal)
    {
      range[d] = planeOf(range[d], counts[d], at.cells);
      range[3 + d] = planeOf(range[3 + d], counts[d], at.cells);
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
    if (!faceRange(zone, zone.block, range, found))
    {
      input.leaveOut("its range " + toString(range) + " is a line or a point");
      return;
    }
  }
  catch (const Error& error)
  {
    const std::string text = error.what();
    input.leaveOut(text.substr(std::min(text.size(), input.fileName.size() + input.where.size() + 2)));
    return;
  }
  zone.declared.addBoundary(found, label.name, label.type, input.where.substr(2));
}

/// A list may cover several faces, or parts of them: marks the quadrilaterals and cuts them into rectangles.
void addList(const StructuredZone& zone, const std::vector<cgsize_t>& points, CGNS_ENUMT(GridLocation_t) location,
  const BoundaryLabel& label)
{
  Input& input = zone.input;
  const Ijk& size = zone.counts();
  Location at;
  if (!locate(size, points, location, at))
  {
    input.leaveOut(std::string("the points of its list at ") + cg_GridLocationName(location) +
      " are not those of faces on one side of the zone");
    return;
  }
  const int normal = at.normal;
  for (std::size_t p = 0; p + 2 < points.size(); p += 3)
  {
    for (int d = 0; d < 3; ++d)
    {
      const cgsize_t last = size[d] - ((normal >= 0 && d != normal) || at.cells ? 1 : 0);
      if (points[p + d] < 1 || points[p + d] > last)
      {
        input.leaveOut("the point (" + std::to_string(points[p]) + ", " + std::to_string(points[p + 1]) + ", " +
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
      zone.declared.addBoundary({ zone.block, face, part.lo, part.hi }, label.name, label.type, input.where.substr(2));
      any = true;
    }
  }
  if (!any)
  {
    input.leaveOut("its list covers no quadrilateral of the zone's faces");
  }
}

void readBoundary(const StructuredZone& zone, int number, const std::string& where)
{
  Input& input = zone.input;
  Condition condition = readCondition(input, number, where);
  const bool isRange = condition.set == CGNS_ENUMV(PointRange);
  if (condition.set == CGNS_ENUMV(PointSetTypeNull) || condition.count == 0)
  {
    input.leaveOut("it has no points");
    return;
  }
  if (!isRange && condition.set != CGNS_ENUMV(PointList))
  {
    input.leaveOut(std::string("its points are given as ") + cg_PointSetTypeName(condition.set) +
      ", not as PointRange or PointList");
    return;
  }
  if (!zone.canHave(condition.count, isRange))
  {
    input.leaveOut("the number of its points is " + std::to_string(condition.count));
    return;
  }
  readPoints(input, zone.families, number, 3, condition);
  addBoundary(zone, isRange, condition.points, condition.location, condition.label);
}

} // namespace

void addBoundary(const StructuredZone& zone, bool isRange, const std::vector<cgsize_t>& points,
  CGNS_ENUMT(GridLocation_t) location, const BoundaryLabel& label)
{
  isRange ? addRange(zone, points, location, label) : addList(zone, points, location, label);
}

void readBoundaries(const StructuredZone& zone)
{
  Input& input = zone.input;
  int conditions = 0;
  input.check(cg_nbocos(input.file, input.base, input.zone, &conditions), "boundary conditions");
  const std::string where = input.where;
  for (int c = 1; c <= conditions; ++c)
  {
    readBoundary(zone, c, where);
  }
  input.where = where;
}

} // namespace bsv::cgns
