// SPDX-License-Identifier: BSD-3-Clause
#include "Mesh/Enclosure.h"

#include "Base/BoxTree.h"

#include <Eigen/Geometry>

#include <cmath>
#include <limits>
#include <utility>

namespace bsv
{

namespace
{

struct Triangle
{
  Vec3 a, b, c;
};

/// Whether the ray from `origin` meets the triangle farther away than `least`.
/// Source: T. Moeller, B. Trumbore, J. Graphics Tools 2 (1997) 21-28, doi:10.1080/10867651.1997.10487468.
bool meets(const Vec3& origin, const Vec3& direction, const Triangle& triangle, double least)
{
  const Vec3 ab = triangle.b - triangle.a, ac = triangle.c - triangle.a;
  const Vec3 p = direction.cross(ac);
  const double determinant = ab.dot(p);
  if (determinant == 0.0)
  {
    return false;
  }
  const Vec3 from = origin - triangle.a;
  const double u = from.dot(p) / determinant;
  const Vec3 q = from.cross(ab);
  const double v = direction.dot(q) / determinant;
  return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && ac.dot(q) / determinant > least;
}

/// Whether a ray meets any triangle.
struct RayQuery
{
  const std::vector<Triangle>& triangles;
  Vec3 origin, direction;
  double least;
  bool found;

  bool intersectVolume(const Box& box) const
  {
    double first = 0.0, last = std::numeric_limits<double>::max();
    for (int d = 0; d < 3; ++d)
    {
      const double step = 1.0 / this->direction[d];
      double a = (box.min()[d] - this->origin[d]) * step, b = (box.max()[d] - this->origin[d]) * step;
      if (step < 0.0)
      {
        std::swap(a, b);
      }
      // Comparisons with NaN, of a ray in a side of the box, change nothing.
      first = a > first ? a : first;
      last = b < last ? b : last;
    }
    return first <= last * (1.0 + 1e-12);
  }
  /// True ends the search.
  bool intersectObject(Index triangle)
  {
    this->found = meets(this->origin, this->direction, this->triangles[triangle], this->least);
    return this->found;
  }
};

} // namespace

std::vector<double> enclosure(const std::vector<CoarseFace>& faces, const Execution& run)
{
  std::vector<Triangle> triangles;
  std::vector<Box> boxes;
  Box all;
  const auto add = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    triangles.push_back({ a, b, c });
    Box box(a);
    box.extend(b);
    box.extend(c);
    boxes.push_back(box);
    all.extend(box);
  };
  for (const CoarseFace& face : faces)
  {
    const int row = face.counts[0];
    for (int t = 0; t + 1 < face.counts[1]; ++t)
    {
      for (int s = 0; s + 1 < row; ++s)
      {
        const Vec3* x = face.points.data() + s + std::size_t(row) * t;
        add(x[0], x[1], x[row + 1]);
        add(x[0], x[row + 1], x[row]);
      }
    }
  }
  std::vector<Index> numbers(triangles.size());
  std::iota(numbers.begin(), numbers.end(), Index(0));
  Eigen::KdBVH<double, 3, Index> tree;
  tree.init(numbers.begin(), numbers.end(), boxes.begin(), boxes.end());
  // So near lie only the face itself and its neighbours.
  const double least = triangles.empty() ? 0.0 : 1e-7 * all.diagonal().norm();

  std::vector<double> result(faces.size(), 0.0);
  run.report(0.0);
  run.parallelFor(static_cast<Index>(faces.size()), 4, [&](Index begin, Index end) {
    for (Index f = begin; f < end; ++f)
    {
      const CoarseFace& face = faces[f];
      const int row = face.counts[0];
      Index rays = 0, hits = 0;
      for (int t = 0; t + 1 < face.counts[1]; ++t)
      {
        for (int s = 0; s + 1 < row; ++s)
        {
          const Vec3* x = face.points.data() + s + std::size_t(row) * t;
          // On one of the two triangles, not between them: a twisted quadrilateral would hide its own middle.
          Vec3 normal = (x[1] - x[0]).cross(x[row + 1] - x[0]);
          const double length = normal.norm();
          if (!(length > 0.0))
          {
            continue;
          }
          normal /= face.outward ? length : -length;
          const Vec3 origin = (x[0] + x[1] + x[row + 1]) / 3.0;
          const Vec3 side = normal.unitOrthogonal();
          const Vec3 other = normal.cross(side);
          for (int ray = 0; ray < 13; ++ray)
          {
            // The normal, and rings at 35 and 65 degrees from it.
            const double polar = ray == 0 ? 0.0 : ray <= 6 ? 0.61 : 1.13;
            const double turn = 1.0471975511965976 * (ray + (ray > 6 ? 0.5 : 0.0));
            const Vec3 direction =
              std::cos(polar) * normal + std::sin(polar) * (std::cos(turn) * side + std::sin(turn) * other);
            RayQuery query{ triangles, origin, direction, least, false };
            Eigen::BVIntersect(tree, query);
            hits += query.found ? 1 : 0;
            ++rays;
          }
        }
      }
      result[f] = rays > 0 ? double(hits) / double(rays) : 0.0;
    }
  });
  return result;
}

} // namespace bsv
