// SPDX-License-Identifier: BSD-3-Clause
#include "Body/ClosestPoint.h"
#include "Body/TrimRegion.h"
#include "Support/BodyCases.h"

#include <gtest/gtest.h>

#include <cstring>
#include <thread>

using namespace bodycases;
using namespace bsv;

namespace
{

Vec3 randomPoint(std::mt19937& random, double extent)
{
  std::uniform_real_distribution<double> place(-extent, extent);
  const double x = place(random);
  const double y = place(random);
  return { x, y, place(random) };
}

/// Part of the connecting vector along the tangents, which a foot point does not have.
double residual(const BodySurface& body, const Vec3& query, const BodyPoint& at)
{
  const SurfaceDerivatives d = evaluate(body.patches()[at.patch].surface, at.u, at.v);
  const Vec3 r = query - d.x;
  return std::max(d.u.norm() > 0.0 ? std::abs(r.dot(d.u)) / d.u.norm() : 0.0,
    d.v.norm() > 0.0 ? std::abs(r.dot(d.v)) / d.v.norm() : 0.0);
}

} // namespace

TEST(ClosestPoint, SphereWithSeamAndPoles)
{
  const double r = 3.0;
  const BodySurface body({ { "ball", sphere(r), {}, false } });
  std::mt19937 random(1);
  std::vector<Vec3> queries;
  for (int n = 0; n < 3000; ++n)
  {
    queries.push_back(randomPoint(random, 6.0));
  }
  // On the seam, at the poles, and almost there.
  for (const double tiny : { 0.0, 1e-15, 1e-12, 1e-8, 1e-5 })
  {
    for (const double length : { 0.1, 3.0, 7.0 })
    {
      queries.emplace_back(length, tiny, 0.3 * length);
      queries.emplace_back(length, -tiny, -0.3 * length);
      queries.emplace_back(tiny, -tiny, length);
      queries.emplace_back(-tiny, tiny, -length);
    }
  }
  for (const Vec3& query : queries)
  {
    const BodyPoint at = body.closestPoint(query);
    ASSERT_EQ(at.patch, 0);
    // So close to the axis that rounding hides whether the distance falls beside the pole, the pole may be the result.
    const double axis = query.head<2>().norm();
    const double pole = axis < 1e-4 ? 2.0 * axis : 0.0;
    EXPECT_NEAR(at.distance, std::abs(query.norm() - r), 1e-14 * body.size() + (axis < 1e-11 ? pole : 0.0))
      << query.transpose();
    EXPECT_LE((at.geometry.point - r * query.normalized()).norm(),
      1e-12 * body.size() * (1.0 + r / query.norm()) + pole * r / query.norm())
      << query.transpose();
    EXPECT_LE((at.geometry.normal - query.normalized()).norm(), 1e-8 + pole / query.norm()) << query.transpose();
  }
  // Exactly on the seam both of its sides are found; the lower parameter owns the point.
  EXPECT_LE(body.closestPoint({ 4, 0, 1 }).u, 1e-15);
  EXPECT_EQ(body.closestPointPerPatch({ 4, 0, 1 }, 1e-9).size(), 2u);
  // The centre is as far from all points.
  EXPECT_NEAR(body.closestPoint({ 0, 0, 0 }).distance, r, 1e-13);
}

TEST(ClosestPoint, TorusInsideAndOutside)
{
  const double R = 3.0;
  const double r = 1.0;
  const BodySurface body({ { "", torus(R, r), {}, true } });
  std::mt19937 random(2);
  for (int n = 0; n < 3000; ++n)
  {
    const Vec3 query = randomPoint(random, 5.0);
    const Vec3 ring = R * Vec3(query[0], query[1], 0.0).normalized();
    const BodyPoint at = body.closestPoint(query);
    EXPECT_NEAR(at.distance, std::abs((query - ring).norm() - r), 1e-13);
    EXPECT_LE(
      (at.geometry.normal + (at.geometry.point - ring).normalized()).norm(), 1e-10 + 1e-13 / (query - ring).norm());
    EXPECT_LE(residual(body, query, at), 1e-13 * body.size());
  }
}

TEST(ClosestPoint, TrimmedPlateIsLeftAtItsCurves)
{
  // A disc with an eccentric hole, in a rectangle that is larger.
  const BodySurface body(
    { { "", rectangle(10, 8), { circleLoop({ 5, 4 }, 3.0), circleLoop({ 5.5, 4 }, 1.0) }, false } });
  EXPECT_LE(body.bounds().max()[0], 8.6);
  std::mt19937 random(3);
  int onEdge = 0;
  for (int n = 0; n < 5000; ++n)
  {
    const Vec3 query = randomPoint(random, 6.0) + Vec3(5, 4, 0);
    const Vec2 flat = query.head<2>();
    const double outer = (flat - Vec2(5, 4)).norm();
    const double inner = (flat - Vec2(5.5, 4)).norm();
    const double beside = outer > 3.0 ? outer - 3.0 : inner < 1.0 ? 1.0 - inner : 0.0;
    const BodyPoint at = body.closestPoint(query);
    EXPECT_NEAR(at.distance, std::hypot(beside, query[2]), 1e-13) << query.transpose();
    EXPECT_EQ(at.onEdge, beside > 0.0) << query.transpose();
    onEdge += at.onEdge;
    const BodyPoint edge = body.closestEdgePoint(query);
    EXPECT_NEAR(edge.distance, std::hypot(std::min(std::abs(outer - 3.0), std::abs(inner - 1.0)), query[2]), 1e-13);
  }
  EXPECT_GT(onEdge, 1000);
}

TEST(ClosestPoint, NothingOnBumpyPatchesIsCloser)
{
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (const std::array<int, 2> degree : { std::array<int, 2>{ 3, 3 }, { 1, 3 }, { 2, 5 } })
  {
    std::vector<BodyPatch> patches;
    for (unsigned int p = 0; p < 3; ++p)
    {
      NURBSSurface surface = bumpy(20 + p, degree, { 5, 4 }, 0.4, p > 0);
      for (Vec3& x : surface.points)
      {
        x += Vec3(0.3 * p, 0.2 * p, 0.5 * p);
      }
      patches.push_back({ "", surface, {}, false });
      if (p == 1)
      {
        const Vec2 middle(0.5 * surface.last(0), 0.5 * surface.last(1));
        patches.back().loops = { circleLoop(middle, 0.4 * std::min(surface.last(0), surface.last(1))) };
      }
    }
    const BodySurface body(patches);
    const TrimRegion region(patches[1].loops);
    std::vector<Vec3> samples;
    for (int n = 0; n < 30000; ++n)
    {
      const int p = n % 3;
      const Vec2 uv(unit(random) * patches[p].surface.last(0), unit(random) * patches[p].surface.last(1));
      if (p != 1 || region.contains(uv))
      {
        samples.push_back(evaluate(patches[p].surface, uv[0], uv[1]).x);
      }
    }
    for (int n = 0; n < 300; ++n)
    {
      const Vec3 query = randomPoint(random, 1.2) + Vec3(0.8, 0.7, 0.5);
      const BodyPoint at = body.closestPoint(query);
      double least = 1e300;
      for (const Vec3& sample : samples)
      {
        least = std::min(least, (sample - query).norm());
      }
      EXPECT_LE(at.distance, least);
      EXPECT_EQ(at.distance, (evaluate(patches[at.patch].surface, at.u, at.v).x - query).norm()) << at.onEdge;
      if (!at.onEdge)
      {
        EXPECT_LE(residual(body, query, at), 1e-12 * body.size());
      }
    }
  }
}

// However near to the body, and wherever its cells meet (halves of spans): in the plane, on bumps, on long thin cells.
TEST(ClosestPoint, PointsNextToTheBodyFindIt)
{
  std::mt19937 random(6);
  std::uniform_int_distribution<int> part(0, 32);
  for (const double height : { 0.0, 0.05, 0.4 })
  {
    for (const double stretch : { 1.0, 30.0 })
    {
      NURBSSurface surface = bumpy(31, { 2, 3 }, { 5, 4 }, height, height > 0.1);
      for (Vec3& x : surface.points)
      {
        x[1] *= stretch;
      }
      const BodySurface body({ { "", surface, {}, false } });
      const auto anywhere = [&](int d) {
        const std::vector<double>& knots = surface.knots[d];
        const int span = surface.degree[d] + part(random) % (surface.count(d) - surface.degree[d]);
        return knots[span] + part(random) / 32.0 * (knots[span + 1] - knots[span]);
      };
      for (int n = 0; n < 400; ++n)
      {
        const SurfaceGeometry at = surfaceGeometry(surface, anywhere(0), anywhere(1));
        for (const double above : { 0.0, 1e-9, 1e-6, 1e-3 })
        {
          const BodyPoint found = body.closestPoint(at.point + above * at.normal);
          EXPECT_LE(found.distance, above + 1e-14 * stretch);
        }
      }
    }
  }
}

TEST(ClosestPoint, KinksInsideAPatchAreEdges)
{
  // A roof of degree 1 x 1 and one of degree 2 with a double knot.
  NURBSSurface roof;
  roof.degree = { 1, 1 };
  roof.knots = { { { 0, 0, 1, 2, 2 }, { 0, 0, 1, 1 } } };
  roof.points = { { -1, 0, 0 }, { 0, 0, 1 }, { 1, 0, 0 }, { -1, 5, 0 }, { 0, 5, 1 }, { 1, 5, 0 } };
  const BodySurface body({ { "", roof, {}, false } });
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int n = 0; n < 500; ++n)
  {
    // Above the ridge, in the cone of its normals.
    const Vec3 query(0.5 * (unit(random) - 0.5), 5.0 * unit(random), 1.5 + unit(random));
    const BodyPoint at = body.closestPoint(query);
    EXPECT_TRUE(at.onEdge);
    EXPECT_LE((at.geometry.point - Vec3(0, query[1], 1)).norm(), 1e-13);
    // Below it, the nearer slope.
    const Vec3 below(query[0], query[1], 0.8);
    const BodyPoint foot = body.closestPoint(below);
    EXPECT_NEAR(foot.distance,
      (1.0 - std::abs(below[0]) - 0.8) / std::sqrt(2.0) * (1.0 - std::abs(below[0]) > 0.8 ? 1 : -1), 1e-13);
    EXPECT_FALSE(foot.onEdge);
  }
}

TEST(ClosestPoint, SharedSidesHaveOneOwner)
{
  const NURBSSurface first = rectangle(2, 3);
  NURBSSurface second = rectangle(4, 3);
  for (Vec3& x : second.points)
  {
    // Meets the first at x = 2, turned upwards.
    x = Vec3(2.0, x[1], x[0]);
  }
  const std::vector<BodyPatch> patches{ { "floor", first, {}, false }, { "wall", second, {}, false } };
  for (const bool exchanged : { false, true })
  {
    const BodySurface body(exchanged ? std::vector<BodyPatch>{ patches[1], patches[0] } : patches);
    std::mt19937 random(6);
    std::uniform_real_distribution<double> unit(0.1, 0.9);
    for (int n = 0; n < 300; ++n)
    {
      const Vec3 query(2.0 + unit(random), 3.0 * unit(random), -unit(random));
      const BodyPoint at = body.closestPoint(query);
      EXPECT_EQ(at.patch, 0);
      EXPECT_TRUE(at.onEdge);
      EXPECT_LE((at.geometry.point - Vec3(2, query[1], 0)).norm(), 1e-14);
      const std::vector<BodyPoint> both = body.closestPointPerPatch(query, 1e-9);
      ASSERT_EQ(both.size(), 2u);
      EXPECT_EQ(both[0].patch, 0);
      EXPECT_EQ(both[1].patch, 1);
      EXPECT_NEAR(both[0].geometry.normal.dot(both[1].geometry.normal), 0.0, 1e-14);
    }
  }
}

TEST(ClosestPoint, ResultsDoNotDependOnThreadsOrOrder)
{
  std::vector<BodyPatch> patches{ { "", sphere(1.0), {}, false }, { "", torus(3.0, 0.5), {}, false },
    { "", bumpy(9, { 3, 3 }, { 6, 6 }, 0.3, true), { circleLoop({ 2, 2 }, 1.5) }, false } };
  std::mt19937 random(7);
  std::vector<Vec3> queries;
  for (int n = 0; n < 4000; ++n)
  {
    queries.push_back(randomPoint(random, 4.0));
  }
  Execution two;
  two.parallelFor = [](Index count, Index grain, const Execution::Body& run) {
    std::vector<std::thread> threads;
    for (Index t = 0; t < 2; ++t)
    {
      threads.emplace_back([&, t] {
        for (Index begin = t * grain; begin < count; begin += 2 * grain)
        {
          run(begin, std::min(begin + grain, count));
        }
      });
    }
    for (std::thread& thread : threads)
    {
      thread.join();
    }
  };
  const BodySurface body(patches);
  const BodySurface parallelBody(patches, two);
  const std::vector<BodyPoint> one = body.closestPoints(queries);
  const std::vector<BodyPoint> other = parallelBody.closestPoints(queries, two);
  for (std::size_t i = queries.size(); i-- > 0;)
  {
    const BodyPoint alone = body.closestPoint(queries[i]);
    for (const BodyPoint* at : { &alone, &other[i] })
    {
      EXPECT_EQ(at->patch, one[i].patch);
      EXPECT_EQ(std::memcmp(&at->u, &one[i].u, sizeof(double)), 0);
      EXPECT_EQ(std::memcmp(&at->v, &one[i].v, sizeof(double)), 0);
      EXPECT_EQ(at->geometry.point, one[i].geometry.point);
      EXPECT_EQ(at->geometry.normal, one[i].geometry.normal);
    }
  }
}

TEST(ClosestPoint, EmptyAndWrongBodies)
{
  const BodySurface empty({});
  EXPECT_EQ(empty.closestPoint({ 0, 0, 0 }).patch, -1);
  EXPECT_EQ(empty.size(), 0.0);
  NURBSSurface wrong = sphere(1.0);
  wrong.weights[4] = -1.0;
  try
  {
    const BodySurface refused({ { "good", sphere(1.0), {}, false }, { "nose", wrong, {}, false } });
    FAIL();
  }
  catch (const Error& error)
  {
    EXPECT_NE(std::string(error.what()).find("patch 1 'nose': weight 4"), std::string::npos) << error.what();
  }
}
