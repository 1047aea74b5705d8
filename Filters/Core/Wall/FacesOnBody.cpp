// SPDX-License-Identifier: BSD-3-Clause
#include "Wall/FacesOnBody.h"

#include "Complex/BlockComplex.h"
#include "Ranks/Ranks.h"

#include <algorithm>

namespace bsv
{

namespace
{

constexpr int PointsPerAxis = 17;
constexpr double Nearer = 0.5;
constexpr double ShareOfEdge = 0.05;
constexpr double ShareOfPoints = 0.95;

/// Of `count` indices at most PointsPerAxis, the ends among them.
std::vector<int> spread(int count)
{
  const int parts = std::min(count, PointsPerAxis) - 1;
  std::vector<int> indices;
  for (int n = 0; n <= parts; ++n)
  {
    indices.push_back(n * (count - 1) / parts);
  }
  return indices;
}

struct Place
{
  Vec3 point;
  Vec3 next;
  double edge;
};

std::vector<Place> placesOf(const GridView& points, int face)
{
  const Ijk cells{ points.counts()[0] - 1, points.counts()[1] - 1, points.counts()[2] - 1 };
  const int across = faceDirection(face);
  std::vector<Place> places;
  for (const int t : spread(cells[faceAxis(face, 1)] + 1))
  {
    for (const int s : spread(cells[faceAxis(face, 0)] + 1))
    {
      const Ijk at = facePoint(cells, face, s, t);
      Place place{ points(at), Vec3::Zero(), 0.0 };
      Ijk next = at;
      next[across] += faceSide(face) ? -1 : 1;
      place.next = points(next);
      int edges = 0;
      for (int axis = 0; axis < 2; ++axis)
      {
        for (const int step : { -1, 1 })
        {
          Ijk beside = at;
          beside[faceAxis(face, axis)] += step;
          if (beside[faceAxis(face, axis)] >= 0 && beside[faceAxis(face, axis)] <= cells[faceAxis(face, axis)])
          {
            place.edge += (points(beside) - place.point).norm();
            ++edges;
          }
        }
      }
      place.edge /= edges;
      places.push_back(place);
    }
  }
  return places;
}

} // namespace

std::vector<std::array<int, 2>> facesOnBody(const BlockMesh& mesh, const BodySurface& body, const Execution& run)
{
  std::vector<char> on(6 * mesh.blocks.size(), 0);
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b)
  {
    run.report(static_cast<double>(b) / mesh.blocks.size());
    for (int face = 0; face < 6 && mesh.blocks[b].rank == run.ranks->rank(); ++face)
    {
      const std::vector<Place> places = placesOf(mesh.blocks[b].points, face);
      std::vector<char> near(places.size(), 0);
      const auto isNear = [&](const Place& place) {
        const double distance = body.closestPoint(place.point).distance;
        return distance <= ShareOfEdge * place.edge && distance <= Nearer * body.closestPoint(place.next).distance;
      };
      // Most faces are far from the body: their middle tells.
      const Place& middle = places[places.size() / 2];
      if (body.closestPoint(middle.point).distance > 10.0 * ShareOfEdge * middle.edge)
      {
        continue;
      }
      run.parallelFor(static_cast<Index>(places.size()), 16, [&](Index begin, Index end) {
        for (Index n = begin; n < end; ++n)
        {
          near[n] = isNear(places[n]) ? 1 : 0;
        }
      });
      on[6 * b + face] =
        std::count(near.begin(), near.end(), 1) >= ShareOfPoints * static_cast<double>(places.size()) ? 1 : 0;
    }
  }
  run.ranks->share(on, [&](Index n) { return mesh.blocks[n / 6].rank; });
  std::vector<std::array<int, 2>> faces;
  for (std::size_t n = 0; n < on.size(); ++n)
  {
    if (on[n])
    {
      faces.push_back({ static_cast<int>(n / 6), static_cast<int>(n % 6) });
    }
  }
  return faces;
}

} // namespace bsv
