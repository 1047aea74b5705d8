// SPDX-License-Identifier: BSD-3-Clause
#include "Body/BodyEdges.h"

#include "Base/Numbers.h"

#include <algorithm>
#include <cmath>

namespace bsv
{

double bodyTurn(const BodySurface& body, const Vec3& point, double length)
{
  // Normals of all parts, and of each a little to both sides: a patch may have kinks.
  constexpr double Nearby = 1e-4;
  std::vector<Vec3> normals;
  for (const BodyPoint& part : body.closestPointPerPatch(point, 0.02 * length))
  {
    const BodyPatch& patch = body.patches()[part.patch];
    const NURBSSurface& surface = patch.surface;
    normals.push_back(part.geometry.normal);
    for (int direction = 0; direction < 2; ++direction)
    {
      const double first = surface.first(direction), last = surface.last(direction);
      for (const double step : { -Nearby, Nearby })
      {
        std::array<double, 2> uv{ part.u, part.v };
        uv[direction] = std::min(last, std::max(first, uv[direction] + step * (last - first)));
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

} // namespace bsv
