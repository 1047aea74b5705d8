// SPDX-License-Identifier: BSD-3-Clause
#include "Quality/SpanShape.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace bsv
{

namespace
{

/// The four edges of a span along a direction, from its low to its high side. Order: (0,0), (1,0), (0,1), (1,1) of the
/// two other directions.
struct Edges
{
  std::array<Vec3, 4> low;
  std::array<Vec3, 4> high;
};

Edges edgesAlong(const double* corners, const Ijk& counts, const Ijk& span, int direction)
{
  Edges edges;
  for (int c = 0; c < 4; ++c)
  {
    Ijk at = span;
    at[faceAxis(2 * direction, 0)] += c & 1;
    at[faceAxis(2 * direction, 1)] += c >> 1;
    for (const auto side : { &Edges::low, &Edges::high })
    {
      const Index n = at[0] + counts[0] * (at[1] + Index(counts[1]) * at[2]);
      (edges.*side)[c] = Eigen::Map<const Vec3>(corners + 3 * n);
      ++at[direction];
    }
  }
  return edges;
}

/// Sum of what belongs to the four corners of a square: symmetric, because diagonals stay diagonals.
template <typename Value>
Value symmetricSum(const Value& a, const Value& b, const Value& c, const Value& d)
{
  return (a + d) + (b + c);
}

} // namespace

double spanSize(const double* corners, const Ijk& counts, const Ijk& span, int direction)
{
  const Edges e = edgesAlong(corners, counts, span, direction);
  std::array<Vec3, 4> edge;
  for (int c = 0; c < 4; ++c)
  {
    edge[c] = e.high[c] - e.low[c];
  }
  return 0.25 * symmetricSum<Vec3>(edge[0], edge[1], edge[2], edge[3]).norm();
}

double sizeRatio(double a, double b)
{
  const double smaller = std::min(a, b);
  return smaller > 0.0 ? std::max(a, b) / smaller : 0.0;
}

double spanAspectRatio(const double* corners, const Ijk& counts, const Ijk& span)
{
  const double u = spanSize(corners, counts, span, 0);
  const double v = spanSize(corners, counts, span, 1);
  const double w = spanSize(corners, counts, span, 2);
  return sizeRatio(std::min({ u, v, w }), std::max({ u, v, w }));
}

double spanHeight(const double* corners, const Ijk& counts, const Ijk& span, int face)
{
  const Edges e = edgesAlong(corners, counts, span, faceDirection(face));
  const auto& on = faceSide(face) == 0 ? e.low : e.high;
  const auto& off = faceSide(face) == 0 ? e.high : e.low;
  const Vec3 normal = (on[3] - on[0]).cross(on[2] - on[1]);
  const double length = normal.norm();
  if (!(length > 0.0))
  {
    return 0.0;
  }
  std::array<double, 4> height;
  for (int c = 0; c < 4; ++c)
  {
    height[c] = std::abs((off[c] - on[c]).dot(normal)) / length;
  }
  return 0.25 * symmetricSum(height[0], height[1], height[2], height[3]);
}

} // namespace bsv
