// SPDX-License-Identifier: BSD-3-Clause
#include "Body/FaceSurface.h"

#include "Ranks/OwnedValues.h"

#include <algorithm>

namespace bsv
{

namespace
{

/// x y z of the control points of a face, and w if the volume is rational, first axis fastest.
std::vector<double> facePoints(const BSplineVolume& volume, int face)
{
  const int across = faceDirection(face);
  const int degree = volume.degree[across];
  const std::vector<double>& knots = volume.knots[across];
  const std::vector<int> spans = nonEmptySpans(degree, knots);
  const int span = faceSide(face) ? spans.back() : spans.front();
  const double at = knots[span + faceSide(face)];
  std::array<double, MaxDegree + 1> left{}, right{}, values{};
  for (int j = 1; j <= degree; ++j)
  {
    left[j] = at - knots[span + 1 - j];
    right[j] = knots[span + j] - at;
  }
  basisFunctions(degree, 0, left.data(), right.data(), values.data());
  const bool clamped = std::count(values.begin(), values.begin() + degree + 1, 0.0) == degree;

  std::vector<double> points;
  Ijk ijk;
  for (int t = 0; t < volume.count(faceAxis(face, 1)); ++t)
  {
    for (int s = 0; s < volume.count(faceAxis(face, 0)); ++s)
    {
      ijk[faceAxis(face, 0)] = s;
      ijk[faceAxis(face, 1)] = t;
      Vec3 point = Vec3::Zero();
      double weight = 0.0;
      for (int q = 0; q <= degree; ++q)
      {
        if (values[q] == 0.0)
        {
          continue;
        }
        ijk[across] = span - degree + q;
        const Index place = ijk[0] + Index(volume.count(0)) * (ijk[1] + Index(volume.count(1)) * ijk[2]);
        const Eigen::Map<const Vec3> own(volume.points + 3 * place);
        const double w = volume.weights ? volume.weights[place] : 1.0;
        point += clamped ? Vec3(own) : Vec3(values[q] * w * own);
        weight += clamped ? w : values[q] * w;
      }
      if (volume.weights && !clamped)
      {
        point /= weight;
      }
      points.insert(points.end(), point.data(), point.data() + 3);
      if (volume.weights)
      {
        points.push_back(weight);
      }
    }
  }
  return points;
}

} // namespace

std::vector<NURBSSurface> faceSurfaces(
  const std::vector<BSplineVolume>& volumes, const std::vector<BoundaryPatch>& faces, const Ranks& ranks)
{
  const auto lists = gatherListsFromOwners<double>(
    ranks, faces.size(), [&](std::size_t f) { return volumes[faces[f].block].rank; },
    [&](std::size_t f) { return facePoints(volumes[faces[f].block], faces[f].face); });
  std::vector<NURBSSurface> surfaces(faces.size());
  for (std::size_t f = 0; f < faces.size(); ++f)
  {
    const BSplineVolume& volume = volumes[faces[f].block];
    NURBSSurface& surface = surfaces[f];
    for (int d = 0; d < 2; ++d)
    {
      surface.degree[d] = volume.degree[faceAxis(faces[f].face, d)];
      surface.knots[d] = volume.knots[faceAxis(faces[f].face, d)];
    }
    const std::size_t count = std::size_t(surface.count(0)) * surface.count(1);
    const std::size_t size = lists[f].size() / count;
    for (std::size_t i = 0; i < lists[f].size(); i += size)
    {
      surface.points.emplace_back(lists[f][i], lists[f][i + 1], lists[f][i + 2]);
      if (size == 4)
      {
        surface.weights.push_back(lists[f][i + 3]);
      }
    }
  }
  return surfaces;
}

} // namespace bsv
