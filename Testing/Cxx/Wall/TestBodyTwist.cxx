// SPDX-License-Identifier: BSD-3-Clause
// How smooth a wall is at its extraordinary vertices, and how close to the body, by rule for the inserted points there.
#include "Conversion/LayerRules.h"
#include "Support/BodyCases.h"
#include "Support/ConversionCases.h"
#include "Support/MeshCases.h"
#include "Wall/BodyFit.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <map>

using namespace bsv;
using conversioncases::Converted;
using meshcases::MeshCase;

namespace
{

const std::vector<Ijk> Cube{ { 0, 0, 0 } };
const std::vector<Ijk> Tromino{ { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } };

/// Two layers around the star-shaped body; the faces k = 0 are the wall and lie on it.
MeshCase starMesh(const std::vector<Ijk>& cubes, int cells)
{
  MeshCase mesh = meshcases::polycubeBody(cubes, cells, { 1.0, 1.1, 1.25 });
  mesh.apply([](const Vec3& x) { return Vec3(bodycases::starRadius(x.normalized()) * x); });
  mesh.boundaryNames = { "wall" };
  for (int b = 0; b < static_cast<int>(mesh.blocks.size()); ++b)
  {
    mesh.boundaries.push_back({ b, 4, { { 0, 0 }, { cells, cells } }, 0 });
  }
  return mesh;
}

ConversionOptions wallOptions(const BodySurface* body = nullptr)
{
  ConversionOptions options;
  options.roles = { BoundaryRole::Body };
  options.body = body;
  return options;
}

double degrees(const Vec3& a, const Vec3& b)
{
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180.0 / bodycases::Pi;
}

Vec3 wallNormal(const BSplineVolume& volume, double u, double v)
{
  const Vec3 at(u, v, 0.0);
  return evaluate(volume, at, { 1, 0, 0 }).cross(evaluate(volume, at, { 0, 1, 0 }));
}

struct Wall
{
  double normalJump = 0.0;  ///< at the borders of the patches, degrees
  double distance = 0.0;    ///< from the body, along its radius
  double normalError = 0.0; ///< degrees
};

Wall measure(const Converted& converted)
{
  Wall wall;
  // Both sides of a border are evaluated at the same points, the ends of a span and between.
  std::map<std::array<long long, 3>, Vec3> borders;
  for (const BSplineVolume& volume : converted.volumes)
  {
    const int cells = volume.count(0) - 3;
    constexpr int Fine = 16, Coarse = 4;
    for (int side = 0; side < 4; ++side)
    {
      for (int i = 0; i <= Fine * cells; ++i)
      {
        const double along = static_cast<double>(i) / Fine, across = side % 2 ? cells : 0.0;
        const double u = side < 2 ? across : along, v = side < 2 ? along : across;
        const Vec3 x = evaluate(volume, Vec3(u, v, 0.0));
        std::array<long long, 3> key;
        for (int d = 0; d < 3; ++d)
        {
          key[d] = std::llround(x[d] * 1e8);
        }
        const Vec3 normal = wallNormal(volume, u, v);
        const auto found = borders.emplace(key, normal).first;
        wall.normalJump = std::max(wall.normalJump, degrees(found->second, normal));
      }
    }
    for (int j = 0; j <= Coarse * cells; ++j)
    {
      for (int i = 0; i <= Coarse * cells; ++i)
      {
        const double u = static_cast<double>(i) / Coarse, v = static_cast<double>(j) / Coarse;
        const Vec3 x = evaluate(volume, Vec3(u, v, 0.0));
        wall.distance = std::max(wall.distance, (x - bodycases::starPoint(x)).norm());
        wall.normalError = std::max(wall.normalError, degrees(wallNormal(volume, u, v), bodycases::starNormal(x)));
      }
    }
  }
  return wall;
}

} // namespace

// The wall of a fitted mesh, on two surface meshes, the body each time in two parametrisations: u and v turned and
// elsewhere on it in the second. Rules converge or do not; the default does, and does not see the parametrisation.
TEST(BodyTwist, TableOfTheRules)
{
  const Eigen::Matrix3d turn =
    (Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()) * Eigen::AngleAxisd(0.5 * bodycases::Pi, Vec3::UnitZ()))
      .toRotationMatrix();
  const BodySurface bodies[2]{ BodySurface(bodycases::starPatches(Eigen::Matrix3d::Identity())),
    BodySurface(bodycases::starPatches(turn)) };
  const std::pair<Twist, const char*> rules[]{ { Twist::Literal, "Literal" }, { Twist::Parallelogram, "Parallelogram" },
    { Twist::Mask, "Mask" }, { Twist::ACC, "ACC" }, { Twist::SecondFundamentalForm, "SecondFundamentalForm" } };
  // Normal jumps of an implementation of the same rule written apart, on its own meshes, at 8 and 32 spans; 0: unknown.
  const double expected[2][2]{ { 0.39, 0.067 }, { 0.67, 0.0 } };

  for (int shape = 0; shape < 2; ++shape)
  {
    std::map<Twist, std::map<int, Wall>> table[2];
    for (const int cells : { 4, 8, 16, 32 })
    {
      MeshCase mesh = starMesh(shape == 0 ? Cube : Tromino, cells);
      for (int b = 0; b < 2; ++b)
      {
        ConversionOptions options = wallOptions(&bodies[b]);
        BodyFitOptions fit;
        fit.body = &bodies[b];
        Converted converted;
        converted.complex = buildBlockComplex(mesh.mesh());
        fitBody(converted.complex, options, fit);
        for (const auto& rule : rules)
        {
          options.twist = rule.first;
          conversioncases::convertComplex(converted, options);
          const Wall wall = measure(converted);
          table[b][rule.first][cells] = wall;
          std::printf("%-16s %2d spans, parametrisation %d, %-21s: normal jump %7.3f, distance %.2e, "
                      "normal error %7.3f\n",
            shape == 0 ? "valence 3" : "valences 3 and 5", cells, b, rule.second, wall.normalJump, wall.distance,
            wall.normalError);
        }
      }
    }
    auto& best = table[0][Twist::SecondFundamentalForm];
    for (const int cells : { 4, 8, 16, 32 })
    {
      // The two bodies are the same to about 1e-8 of their size, their normals to 1e-6.
      const Wall& other = table[1][Twist::SecondFundamentalForm][cells];
      EXPECT_NEAR(best[cells].normalJump, other.normalJump, 1e-4);
      EXPECT_NEAR(best[cells].distance, other.distance, 1e-7);
      // First order at least; the wall second.
      if (cells > 4)
      {
        EXPECT_LT(best[cells].normalJump, 0.6 * best[cells / 2].normalJump);
        EXPECT_LT(best[cells].distance, 0.35 * best[cells / 2].distance);
      }
      for (const Twist twist : { Twist::Literal, Twist::Parallelogram, Twist::Mask })
      {
        EXPECT_LT(best[cells].normalJump, table[0][twist][cells].normalJump);
      }
    }
    EXPECT_LT(best[8].normalJump, 1.2 * expected[shape][0]);
    if (expected[shape][1] > 0.0)
    {
      EXPECT_LT(best[32].normalJump, 1.2 * expected[shape][1]);
    }
    // The thesis formulas: 6 to 12 degrees here, whatever the mesh.
    for (const int cells : { 8, 16, 32 })
    {
      for (auto& ofBody : table)
      {
        EXPECT_GT(ofBody[Twist::Literal][cells].normalJump, 5.0);
        EXPECT_LT(ofBody[Twist::Literal][cells].normalJump, 21.0);
      }
    }
    // They do not converge, and change with the directions of the parameters.
    auto& literal = table[0][Twist::Literal];
    EXPECT_GT(literal[32].normalJump, 0.5 * literal[8].normalJump);
    EXPECT_GT(literal[32].normalJump, 5.0);
    EXPECT_GT(std::abs(literal[8].normalJump - table[1][Twist::Literal][8].normalJump), 0.1);
  }
}

// At a regular vertex the exact corner is known: the B-spline's own. The height that the body's second fundamental form
// gives the inserted point tends to it with the edge length.
TEST(BodyTwist, CurvatureGivesTheExactCornerAtRegularVertices)
{
  const BodySurface body(bodycases::starPatches(Eigen::Matrix3d::Identity()));
  double before = 1.0;
  for (const int cells : { 16, 32, 64 })
  {
    MeshCase mesh = starMesh(Cube, cells);
    BlockComplex complex = buildBlockComplex(mesh.mesh());
    fitBody(complex, wallOptions(), {});

    std::vector<double> exact, given;
    for (const ComplexBlock& block : complex.blocks)
    {
      for (int j = 1; j < cells; ++j)
      {
        for (int i = 1; i < cells; ++i)
        {
          Fan fan;
          fan.center = block.points(i, j, 0);
          const int di[4]{ 1, 0, -1, 0 }, dj[4]{ 0, 1, 0, -1 };
          for (int s = 0; s < 4; ++s)
          {
            const int n = (s + 1) % 4;
            fan.spokes.push_back(block.points(i + di[s], j + dj[s], 0));
            fan.sectors.push_back(block.points(i + di[s] + di[n], j + dj[s] + dj[n], 0));
          }
          const Fan regular = smoothFan(fan, Twist::SecondFundamentalForm, std::vector<double>(4, 2.0 / 3.0));
          const BodyPoint foot = body.closestPoint(regular.center);
          const Fan projected = projectedFan(fan,
            { foot.geometry.point, foot.geometry.normal, foot.geometry.curvature, true, Vec3::Zero() },
            Twist::SecondFundamentalForm);
          for (int s = 0; s < 4; ++s)
          {
            const Vec3 normal =
              (regular.spokes[s] - regular.center).cross(regular.spokes[(s + 1) % 4] - regular.center).normalized();
            exact.push_back(normal.dot(regular.sectors[s] - regular.center));
            given.push_back(foot.geometry.normal.dot(projected.sectors[s] - projected.center));
          }
        }
      }
    }
    const Eigen::Map<const Eigen::ArrayXd> a(exact.data(), exact.size()), b(given.data(), given.size());
    const Eigen::ArrayXd x = a - a.mean(), y = b - b.mean();
    const double correlation = (x * y).sum() / std::sqrt(x.square().sum() * y.square().sum());
    const double slope = (x * y).sum() / x.square().sum();
    std::printf("twist from the second fundamental form at %zu regular corners: correlation %.6f, slope %.4f\n",
      exact.size(), correlation, slope);
    EXPECT_NEAR(slope, 1.0, 1e-3);
    EXPECT_LT(1.0 - correlation, 0.5 * before);
    before = 1.0 - correlation;
  }
  EXPECT_LT(before, 1e-3);
}

// One body in two parametrisations, u running the other way in the second: the default must not see the difference, the
// source's own rule does, because x_uv changes its sign.
// The thesis formulas see the directions of the parameters, not their scale, and no twist on extruded surfaces.
TEST(BodyTwist, ThesisFormulasDoNotSeeTheScaleOfTheParameters)
{
  const int cells = 6;
  MeshCase mesh = starMesh(Cube, cells);
  std::vector<BodyPatch> patches = bodycases::starPatches(Eigen::Matrix3d::Identity());
  const BodySurface body(patches);
  for (BodyPatch& patch : patches)
  {
    for (int d = 0; d < 2; ++d)
    {
      for (double& knot : patch.surface.knots[d])
      {
        knot *= d == 0 ? 1000.0 : 0.03;
      }
    }
  }
  const BodySurface scaled(patches);
  std::vector<Converted> converted;
  for (const BodySurface* b : { &body, &scaled })
  {
    ConversionOptions options = wallOptions(b);
    options.twist = Twist::Literal;
    converted.push_back(conversioncases::convert(mesh.mesh(), options));
  }
  for (std::size_t b = 0; b < converted[0].points.size(); ++b)
  {
    for (std::size_t i = 0; i < converted[0].points[b].size(); ++i)
    {
      EXPECT_NEAR(converted[0].points[b][i], converted[1].points[b][i], 1e-10);
    }
  }
}

TEST(BodyTwist, DefaultIsFreeOfTheParametrisationAndLiteralIsNot)
{
  Eigen::Matrix3d matrix;
  matrix << 1.3, 0.2, 0.1, 0.0, 0.9, 0.3, -0.1, 0.0, 1.1;
  NURBSSurface surface = bodycases::sphere(1.0);
  for (Vec3& x : surface.points)
  {
    x = matrix * x;
  }
  NURBSSurface turned = surface;
  const int nu = surface.count(0);
  for (int v = 0; v < surface.count(1); ++v)
  {
    for (int u = 0; u < nu; ++u)
    {
      turned.points[u + nu * v] = surface.points[nu - 1 - u + nu * v];
      turned.weights[u + nu * v] = surface.weights[nu - 1 - u + nu * v];
    }
  }
  const BodySurface bodies[2]{ BodySurface({ { "body", surface, {}, false } }),
    BodySurface({ { "body", turned, {}, true } }) };

  const int cells = 6;
  MeshCase mesh = meshcases::sphereBody(cells, { 1.0, 1.2, 1.5 });
  mesh.apply([&](const Vec3& x) { return Vec3(matrix * x); });
  mesh.boundaryNames = { "wall" };
  for (int b = 0; b < 6; ++b)
  {
    mesh.boundaries.push_back({ b, 4, { { 0, 0 }, { cells, cells } }, 0 });
  }
  for (const Twist twist : { Twist::SecondFundamentalForm, Twist::Literal })
  {
    double difference = 0.0;
    std::vector<Converted> converted;
    for (const BodySurface& body : bodies)
    {
      ConversionOptions options = wallOptions();
      options.twist = twist;
      options.body = &body;
      converted.push_back(conversioncases::convert(mesh.mesh(), options));
    }
    for (std::size_t b = 0; b < converted[0].points.size(); ++b)
    {
      for (std::size_t i = 0; i < converted[0].points[b].size(); ++i)
      {
        difference = std::max(difference, std::abs(converted[0].points[b][i] - converted[1].points[b][i]));
      }
    }
    // Points of the same surface found from other parameters: as exact as the closest point, 1e-12 of the body's size.
    if (twist == Twist::SecondFundamentalForm)
    {
      EXPECT_LE(difference, 1e-11);
    }
    else
    {
      EXPECT_GE(difference, 1e-2);
    }
    // The extraordinary vertices lie on the body either way.
    for (int corner = 0; corner < 4; ++corner)
    {
      const Vec3 x = converted[0].controlPoint(0, { corner & 1 ? cells + 2 : 0, corner >> 1 ? cells + 2 : 0, 0 });
      EXPECT_NEAR((matrix.inverse() * x).norm(), 1.0, 1e-12);
    }
  }
  ConversionOptions without = wallOptions();
  without.twist = Twist::Literal;
  EXPECT_THROW(conversioncases::convert(mesh.mesh(), without), Error);
  without.twist = Twist::PCCM;
  EXPECT_THROW(conversioncases::convert(mesh.mesh(), without), Error);
}
