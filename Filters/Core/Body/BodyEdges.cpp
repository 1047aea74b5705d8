// SPDX-License-Identifier: BSD-3-Clause
#include "Body/BodyEdges.h"

#include "Base/Numbers.h"

#include <algorithm>
#include <cmath>

namespace bsv
{

double bodyTurn(const BodySurface& body, const Vec3& point, double length)
{
  // Normals of all parts, and of each a little to both sides: a patch may have kinks. So little that round noses turn
  // hardly.
  constexpr double Nearby = 1e-4, NearbyLength = 1e-3;
  std::vector<Vec3> normals;
  for (const BodyPoint& part : body.closestPointPerPatch(point, 0.02 * length))
  {
    const BodyPatch& patch = body.patches()[part.patch];
    const NURBSSurface& surface = patch.surface;
    normals.push_back(part.geometry.normal);
    for (int direction = 0; direction < 2; ++direction)
    {
      const double first = surface.first(direction), last = surface.last(direction);
      const double speed = std::sqrt(direction == 0 ? part.geometry.E : part.geometry.G);
      const double most = speed > 0.0 ? NearbyLength * length / speed : last - first;
      for (const double sign : { -1.0, 1.0 })
      {
        std::array<double, 2> uv{ part.u, part.v };
        const double step = sign * std::min(Nearby * (last - first), most);
        uv[direction] = std::min(last, std::max(first, uv[direction] + step));
        normals.push_back(surfaceGeometry(surface, uv[0], uv[1], patch.reversed).normal);
      }
    }
  }
  double largest = 0.0;
  for (std::size_t a = 0; a < normals.size(); ++a)
  {
    for (std::size_t b = a + 1; b < normals.size(); ++b)
    {
      largest = std::max(largest, angleBetween(normals[a], normals[b]));
    }
  }
  return largest * DegreesPerRadian;
}

bool isShapeEdge(const BodySurface& body, const Vec3& edge, double length)
{
  constexpr double Sharp = 10.0; // degrees; a rounding of radius `length` turns by about 1
  if (bodyTurn(body, edge, length) > Sharp)
  {
    return true;
  }
  // Where the body ends, a step off it in its tangent plane stays off.
  const double step = 0.02 * length;
  const Vec3 normal = body.closestPoint(edge).geometry.normal;
  const Vec3 along = normal.unitOrthogonal(), across = normal.cross(along);
  for (const Vec3& direction : { along, across })
  {
    for (const double sign : { -1.0, 1.0 })
    {
      if (body.closestPoint(edge + sign * step * direction).distance > 0.5 * step)
      {
        return true;
      }
    }
  }
  return false;
}

} // namespace bsv
