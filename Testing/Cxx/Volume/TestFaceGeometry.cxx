// SPDX-License-Identifier: BSD-3-Clause
/// Points, normals and curvatures of block faces, against a sphere and against the evaluation of the volume.
#include "Mesh/BlockTopology.h"
#include "Volume/FaceGeometry.h"
#include "Volume/VolumeParts.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

using namespace bsv;

namespace
{

/// An eighth of the shell between two balls around the origin: u turns around z, v climbs to the pole, w goes outwards.
struct Shell
{
  std::vector<double> points, weights;
  BSplineVolume volume;

  Shell(double inner, double outer)
  {
    const double half = std::sqrt(0.5);
    const double arc[3][3] = { { 1, 0, 1 }, { 1, 1, half }, { 0, 1, 1 } }; // cosine, sine, weight
    for (const double radius : { inner, outer })
    {
      for (const auto& v : arc)
      {
        for (const auto& u : arc)
        {
          this->points.insert(this->points.end(), { radius * v[0] * u[0], radius * v[0] * u[1], radius * v[1] });
          this->weights.push_back(u[2] * v[2]);
        }
      }
    }
    this->volume.degree = { 2, 2, 1 };
    this->volume.knots = { std::vector<double>{ 0, 0, 0, 1, 1, 1 }, { 0, 0, 0, 1, 1, 1 }, { 0, 0, 1, 1 } };
    this->volume.points = this->points.data();
    this->volume.weights = this->weights.data();
  }
};

} // namespace

TEST(FaceGeometry, SphereHasItsRadiusNormalsAndCurvatures)
{
  const Shell shell(2.0, 3.0);
  for (const int face : { 4, 5 })
  {
    const double radius = face == 4 ? 2.0 : 3.0;
    const FaceGeometry geometry = faceGeometry(shell.volume, face, 7);
    ASSERT_EQ(geometry.samples, (std::array<int, 2>{ 8, 8 }));
    for (std::size_t n = 0; n < geometry.points.size(); ++n)
    {
      const Vec3 radial = geometry.points[n] / radius;
      EXPECT_NEAR(radial.norm(), 1.0, 1e-14);
      if (n / 8 == 7)
      {
        continue; // the pole has the values of a sample beside it
      }
      // Into the block: away from the inner ball, and to the centre from the outer one.
      const double sign = face == 4 ? 1.0 : -1.0;
      EXPECT_NEAR((geometry.normals[n] - sign * radial).norm(), 0.0, 1e-12);
      EXPECT_NEAR(geometry.mean[n], -sign / radius, 1e-10);
      EXPECT_NEAR(geometry.gaussian[n], 1.0 / (radius * radius), 1e-10);
    }
    for (int s = 0; s < 8; ++s)
    {
      EXPECT_EQ(geometry.normals[s + 56], geometry.normals[s + 48]);
    }
  }
}

TEST(FaceGeometry, AllFacesAndLayersOfAVolumeAreWhereItsEvaluationIs)
{
  std::mt19937 random(7);
  std::uniform_real_distribution<double> noise(-0.2, 0.2);
  BSplineVolume volume;
  volume.degree = { 3, 2, 4 };
  volume.knots = { std::vector<double>{ 0, 0, 0, 0, 1, 3, 4, 4, 4, 4 }, { -1, -1, -1, 0, 0, 2, 2, 2 },
    { 0, 0, 0, 0, 0, 2, 2, 2, 2, 2 } };
  std::vector<double> points;
  for (int c = 0; c < volume.count(2); ++c)
  {
    for (int b = 0; b < volume.count(1); ++b)
    {
      for (int a = 0; a < volume.count(0); ++a)
      {
        points.insert(points.end(), { a + noise(random), b + noise(random), c + noise(random) });
      }
    }
  }
  volume.points = points.data();
  const int parts = 2;
  // The last layer is that of the opposite face.
  for (int n = 0; n < 6 * 4; ++n)
  {
    const int face = n / 4;
    const int layer = n % 4;
    const FaceGeometry geometry = faceGeometry(volume, face, parts, {}, layer);
    std::array<std::vector<double>, 2> parameters;
    for (int axis = 0; axis < 2; ++axis)
    {
      const int d = faceAxis(face, axis);
      const std::vector<int> spans = nonEmptySpans(volume.degree[d], volume.knots[d]);
      for (const int span : spans)
      {
        for (int j = 0; j < parts; ++j)
        {
          parameters[axis].push_back(
            volume.knots[d][span] + (volume.knots[d][span + 1] - volume.knots[d][span]) * j / parts);
        }
      }
      parameters[axis].push_back(volume.knots[d].back());
      ASSERT_EQ(geometry.samples[axis], static_cast<int>(parameters[axis].size()));
    }
    const int across = faceDirection(face);
    std::vector<double> ends = volume.knots[across];
    ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
    const int depth = std::min(layer, static_cast<int>(ends.size()) - 1);
    const double place = faceSide(face) ? ends[ends.size() - 1 - depth] : ends[depth];
    for (int t = 0; t < geometry.samples[1]; ++t)
    {
      for (int s = 0; s < geometry.samples[0]; ++s)
      {
        Vec3 uvw;
        uvw[faceAxis(face, 0)] = parameters[0][s];
        uvw[faceAxis(face, 1)] = parameters[1][t];
        uvw[across] = place;
        std::array<Vec3, 3> tangents;
        for (int d = 0; d < 3; ++d)
        {
          std::array<int, 3> order{ 0, 0, 0 };
          order[d] = 1;
          tangents[d] = evaluate(volume, uvw, order);
        }
        Vec3 normal = tangents[faceAxis(face, 0)].cross(tangents[faceAxis(face, 1)]).normalized();
        if (normal.dot(tangents[across]) * (faceSide(face) ? -1.0 : 1.0) < 0.0)
        {
          normal = -normal;
        }
        const std::size_t at = s + std::size_t(geometry.samples[0]) * t;
        EXPECT_NEAR((geometry.points[at] - evaluate(volume, uvw)).norm(), 0.0, 1e-13);
        EXPECT_NEAR((geometry.normals[at] - normal).norm(), 0.0, 1e-12);
      }
    }
  }
}

// Where a face is only continuous, both sides have a sample of their own: those of the parts of the block.
TEST(FaceGeometry, BothSidesOfARepeatedKnot)
{
  std::mt19937 random(3);
  std::uniform_real_distribution<double> noise(-0.2, 0.2);
  BSplineVolume volume;
  volume.degree = { 3, 2, 1 };
  volume.knots = { std::vector<double>{ 0, 0, 0, 0, 1, 3, 3, 3, 4, 4, 4, 4 }, { -1, -1, -1, 0, 0, 2, 2, 2 },
    { 0, 0, 1, 1 } };
  std::vector<double> points;
  for (int n = 0; n < volume.count(0) * volume.count(1) * 2; ++n)
  {
    const int a = n % volume.count(0), b = n / volume.count(0) % volume.count(1);
    const int c = n / volume.count(0) / volume.count(1);
    points.insert(points.end(), { a + noise(random), b + noise(random), double(c) });
  }
  volume.points = points.data();
  const FaceGeometry whole = faceGeometry(volume, 4, 2, {}, 0, true);
  EXPECT_EQ(whole.parameters[0], (std::vector<double>{ 0, 0.5, 1, 2, 3, 3, 3.5, 4 }));
  EXPECT_EQ(whole.parameters[1], (std::vector<double>{ -1, -0.5, 0, 0, 1, 2 }));
  const VolumeParts parts = cutAtRepeatedKnots({ volume }, {});
  ASSERT_EQ(parts.volumes.size(), 4u);
  for (int part = 0; part < 4; ++part)
  {
    const FaceGeometry own = faceGeometry(parts.volumes[part], 4, 2);
    const int s0 = part % 2 == 0 ? 0 : 5, t0 = part / 2 == 0 ? 0 : 3;
    for (int t = 0; t < own.samples[1]; ++t)
    {
      for (int s = 0; s < own.samples[0]; ++s)
      {
        const std::size_t here = s + std::size_t(own.samples[0]) * t;
        const std::size_t there = s0 + s + std::size_t(whole.samples[0]) * (t0 + t);
        EXPECT_LT((own.points[here] - whole.points[there]).norm(), 1e-14);
        EXPECT_LT((own.normals[here] - whole.normals[there]).norm(), 1e-13);
      }
    }
  }
  // One side alone by default.
  EXPECT_EQ(faceGeometry(volume, 4, 2).samples, (std::array<int, 2>{ 7, 5 }));
}
