// SPDX-License-Identifier: BSD-3-Clause
#include "Support/BodyCases.h"
#include "Support/ConversionCases.h"
#include "Support/MeshCases.h"
#include "Wall/BodyFit.h"
#include "Wall/WallPoints.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include <cmath>
#include <limits>

using namespace bsv;
using bodycases::starNormal;
using bodycases::starPoint;
using bodycases::starRadius;
using conversioncases::Converted;
using meshcases::MeshCase;

namespace
{

/// Layers around the body, the first of thickness `first`, growing by 1.2; the faces k = 0 are the wall. One cube (six
/// blocks, valence 3) or `cubes` (meshcases::polycubeBody).
MeshCase bodyMesh(int cells, double first, int layers = 8, const std::vector<Ijk>& cubes = {})
{
  std::vector<double> radii{ 1.0 };
  for (int k = 0; k < layers; ++k)
  {
    radii.push_back(radii.back() + first * std::pow(1.2, k));
  }
  MeshCase mesh = cubes.empty() ? meshcases::sphereBody(cells, radii) : meshcases::polycubeBody(cubes, cells, radii);
  mesh.apply([](const Vec3& x) { return Vec3(starRadius(x.normalized()) * x); });
  mesh.boundaryNames = { "wall" };
  for (int b = 0; b < static_cast<int>(mesh.blocks.size()); ++b)
  {
    mesh.boundaries.push_back({ b, 4, { { 0, 0 }, { cells, cells } }, 0 });
  }
  return mesh;
}

ConversionOptions wallOptions()
{
  ConversionOptions options;
  options.roles = { BoundaryRole::Body };
  return options;
}

/// Converts after fitting.
Converted convertFitted(const BlockMesh& mesh, const BodyFitOptions& fit, BodyFitReport& report)
{
  Converted result;
  result.complex = buildBlockComplex(mesh);
  report = fitBody(result.complex, wallOptions(), fit);
  conversioncases::convertComplex(result, wallOptions());
  return result;
}

/// Largest distance from the body along its own radius, sampled on the wall's patches; without the spans within
/// `margin` of the patches' borders, at which the mesh lines of this case turn.
double deviation(const Converted& converted, double margin)
{
  double worst = 0.0;
  for (std::size_t b = 0; b < converted.volumes.size(); ++b)
  {
    const BSplineVolume& volume = converted.volumes[b];
    for (const ComplexFace& face : converted.complex.faces)
    {
      if (face.tag != 0 || face.uses.front().block != static_cast<int>(b))
      {
        continue;
      }
      const int f = face.uses.front().face;
      for (double t = 0.0; t <= volume.count(faceAxis(f, 1)) - 3; t += 0.25)
      {
        for (double s = 0.0; s <= volume.count(faceAxis(f, 0)) - 3; s += 0.25)
        {
          const auto nearEnd = [&](double value, int axis) {
            return value < margin || value > volume.count(faceAxis(f, axis)) - 3 - margin;
          };
          if (nearEnd(s, 0) || nearEnd(t, 1))
          {
            continue;
          }
          Vec3 u;
          u[faceAxis(f, 0)] = s;
          u[faceAxis(f, 1)] = t;
          u[faceDirection(f)] = faceSide(f) ? volume.count(faceDirection(f)) - 3 : 0;
          const Vec3 x = evaluate(volume, u);
          worst = std::max(worst, std::abs(x.norm() - starRadius(x.normalized())));
        }
      }
    }
  }
  return worst;
}

/// How far the knots of the wall are from its mesh points.
double interpolationError(const Converted& converted, const MeshCase& mesh, int cells)
{
  double worst = 0.0;
  for (int b = 0; b < static_cast<int>(mesh.blocks.size()); ++b)
  {
    for (int j = 0; j <= cells; ++j)
    {
      for (int i = 0; i <= cells; ++i)
      {
        worst =
          std::max(worst, (evaluate(converted.volumes[b], Vec3(i, j, 0)) - mesh.blocks[b].at({ i, j, 0 })).norm());
      }
    }
  }
  return worst;
}

} // namespace

TEST(BodyFit, TheWallPassesThroughTheGivenPoints)
{
  const std::vector<Ijk> one, tromino{ { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } };
  // With two cells the points next to one extraordinary vertex are next to others too.
  for (const int cells : { 2, 3, 6 })
  {
    for (const std::vector<Ijk>& cubes : { one, tromino })
    {
      MeshCase mesh = bodyMesh(cells, 0.05, 8, cubes);
      BodyFitReport report;
      const Converted converted = convertFitted(mesh.mesh(), {}, report);
      // Euler: V = F + 2 on a closed surface of quadrilaterals.
      EXPECT_EQ(report.wallPoints, Index(mesh.blocks.size()) * cells * cells + 2);
      EXPECT_GT(report.initialResidual, 1e-3);
      EXPECT_LE(interpolationError(converted, mesh, cells), 1e-12);
    }
  }
}

// Coordinates of a million are stored to 1e-10.
TEST(BodyFit, ReachesThePointsFarFromTheOrigin)
{
  constexpr double Distance = 1e6;
  MeshCase mesh = bodyMesh(4, 0.05);
  mesh.apply([&](const Vec3& x) { return Vec3(x + Vec3(Distance, -Distance, 0.5 * Distance)); });
  BodyFitReport report;
  const Converted converted = convertFitted(mesh.mesh(), {}, report);
  EXPECT_LE(interpolationError(converted, mesh, 4), 32.0 * std::numeric_limits<double>::epsilon() * Distance);
}

// In the middle of a ball lines from opposite and from neighbouring sides of the wall are as long as each other but for
// rounding: what is carried along them must not depend on it.
TEST(BodyFit, TurnedMeshesMakeTurnedVolumes)
{
  MeshCase mesh = meshcases::ball(4, 3);
  mesh.boundaryNames = { "wall" };
  for (int b = 1; b < static_cast<int>(mesh.blocks.size()); ++b)
  {
    mesh.boundaries.push_back({ b, 5, { { 0, 0 }, { 4, 4 } }, 0 });
  }
  BodyFitReport report;
  const Converted given = convertFitted(mesh.mesh(), {}, report);
  EXPECT_GT(report.displacement, 0.01);
  const Eigen::Matrix3d turns[] = { Eigen::AngleAxisd(0.7, Vec3(1.0, 2.0, 3.0).normalized()).toRotationMatrix(),
    Eigen::Vector3d(1.0, 1.0, -1.0).asDiagonal(), 1e3 * Eigen::Matrix3d::Identity() };
  for (const Eigen::Matrix3d& turn : turns)
  {
    MeshCase turned = mesh;
    turned.apply([&](const Vec3& x) { return Vec3(turn * x); });
    const Converted made = convertFitted(turned.mesh(), {}, report);
    double worst = 0.0;
    for (std::size_t b = 0; b < given.points.size(); ++b)
    {
      ASSERT_EQ(made.points[b].size(), given.points[b].size());
      for (std::size_t p = 0; p < given.points[b].size(); p += 3)
      {
        const Eigen::Map<const Vec3> before(&given.points[b][p]), after(&made.points[b][p]);
        worst = std::max(worst, (turn.inverse() * after - before).norm());
      }
    }
    EXPECT_LE(worst, 1e-11);
  }
  // The same bits for any numbering.
  const auto net = conversioncases::canonicalNet(given);
  for (const unsigned seed : { 1u, 2u })
  {
    MeshCase other = mesh;
    meshcases::shuffle(other, seed, true);
    EXPECT_EQ(conversioncases::canonicalNet(convertFitted(other.mesh(), {}, report)), net);
  }
}

// Smooth mesh lines on a body interpolated by cubics converge with fourth order; as control points, and where the lines
// turn, with second order.
TEST(BodyFit, ConvergesFasterThanControlPoints)
{
  double fitted[2], plain[2], inner[2];
  for (int n = 0; n < 2; ++n)
  {
    MeshCase mesh = bodyMesh(16 << n, 0.05);
    BodyFitReport report;
    const Converted converted = convertFitted(mesh.mesh(), {}, report);
    fitted[n] = deviation(converted, 0.0);
    inner[n] = deviation(converted, 4 << n);
    plain[n] = deviation(conversioncases::convert(mesh.mesh(), wallOptions()), 0.0);
  }
  std::printf("distance to the body, 16 and 32 spans: control points %.2e %.2e, fitted %.2e %.2e, inside "
              "the patches %.2e %.2e\n",
    plain[0], plain[1], fitted[0], fitted[1], inner[0], inner[1]);
  EXPECT_LT(plain[1], plain[0] / 3.0);
  EXPECT_LT(fitted[1], fitted[0] / 3.0);
  EXPECT_LT(inner[1], inner[0] / 10.0);
  EXPECT_LT(fitted[1], plain[1] / 8.0);
}

TEST(BodyFit, SameBitsForAnyNumberingOrientationAndThreads)
{
  MeshCase mesh = bodyMesh(5, 0.02);
  BodyFitReport report;
  const auto reference = conversioncases::canonicalNet(convertFitted(mesh.mesh(), {}, report));
  for (unsigned seed = 1; seed <= 4; ++seed)
  {
    MeshCase other = bodyMesh(5, 0.02);
    meshcases::shuffle(other, seed, seed > 2);
    EXPECT_TRUE(conversioncases::canonicalNet(convertFitted(other.mesh(), {}, report)) == reference);
  }
}

// The corners of a wall that meets itself are in one place: they do not tell where its samples begin.
TEST(BodyFit, LeastSquaresAroundARingIsTheSameBitsForAnyOrientation)
{
  MeshCase mesh = meshcases::oGrid({ 9, 3, 4 });
  const double inner = mesh.blocks[0].at({ 0, 0, 0 }).head<2>().norm();
  const double middle = 0.5 * mesh.blocks[0].at({ 0, 0, 4 })[2];
  mesh.apply([&](const Vec3& x) {
    const double radius = x.head<2>().norm();
    const Vec3 direction = Vec3(x[0] / radius, x[1] / radius, x[2] - middle).normalized();
    return Vec3(radius / inner * starRadius(direction) * direction);
  });
  mesh.boundaryNames = { "wall" };
  mesh.boundaries.push_back({ 0, 2, { { 0, 0 }, { 9, 4 } }, 0 });
  const BodySurface body(bodycases::starPatches(Eigen::Matrix3d::Identity()));
  BodyFitOptions fit;
  fit.body = &body;
  fit.leastSquares = true;
  BodyFitReport report;
  const auto net = conversioncases::canonicalNet(convertFitted(mesh.mesh(), fit, report));
  EXPECT_GT(report.sampleRms[1], 0.0);
  for (int orientation = 1; orientation < meshcases::MirroredOrientationCount; orientation += 5)
  {
    MeshCase turned = mesh;
    meshcases::reorient(turned, 0, orientation);
    EXPECT_EQ(conversioncases::canonicalNet(convertFitted(turned.mesh(), fit, report)), net) << orientation;
  }
}

// Thin layers follow the wall: mesh lines stay in order.
TEST(BodyFit, LayersKeepTheirOrder)
{
  for (const double first : { 1e-1, 1e-2, 1e-3, 1e-4 })
  {
    MeshCase mesh = bodyMesh(5, first * 0.3, 30);
    BlockComplex complex = buildBlockComplex(mesh.mesh());
    fitBody(complex, wallOptions(), {});
    for (const ComplexBlock& block : complex.blocks)
    {
      for (int j = 0; j <= block.cells(1); ++j)
      {
        for (int i = 0; i <= block.cells(0); ++i)
        {
          for (int k = 0; k < block.cells(2); ++k)
          {
            const Vec3 up = block.points(i, j, k + 1) - block.points(i, j, k);
            EXPECT_GT(up.dot(block.points(i, j, k)), 0.0) << "first layer " << first << ", layer " << k;
          }
        }
      }
    }
  }
}

// The body's points and normals at the extraordinary vertices move the wall by far more than a thin first layer.
// Carried into the layers they leave every span valid, proven by Bernstein coefficients.
TEST(BodyPropagation, ThinLayersStayValid)
{
  const int cells = 5;
  for (const bool valenceFive : { false, true })
  {
    Index foldedWithout = 0;
    for (const double first : { 1e-1, 1e-2, 1e-3, 1e-4 })
    {
      // The edges of the surface are about 0.3 long.
      MeshCase mesh = bodyMesh(cells, 0.3 * first, 40,
        valenceFive ? std::vector<Ijk>{ { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } } : std::vector<Ijk>{});
      std::vector<std::vector<double>> points, normals;
      for (const auto& block : mesh.blocks)
      {
        points.emplace_back();
        normals.emplace_back();
        for (const Vec3& x : block.points)
        {
          const Vec3 foot = starPoint(x);
          const Vec3 normal = starNormal(x);
          points.back().insert(points.back().end(), foot.data(), foot.data() + 3);
          normals.back().insert(normals.back().end(), normal.data(), normal.data() + 3);
        }
      }
      ConversionOptions options = wallOptions();
      for (std::size_t b = 0; b < points.size(); ++b)
      {
        options.projectedPoints.push_back(points[b].data());
        options.surfaceNormals.push_back(normals[b].data());
      }
      options.repairSpans = false; // it is the rules that are tested
      // Spans next to the extraordinary vertices, in the layers where it matters.
      const auto near = [&](int, const Ijk& span) {
        return (span[0] < 2 || span[0] > cells - 3) && (span[1] < 2 || span[1] > cells - 3) && span[2] < 3;
      };
      const auto with = conversioncases::provenValid(conversioncases::convert(mesh.mesh(), options), near);
      options.propagationRange = 0.0;
      const auto without = conversioncases::provenValid(conversioncases::convert(mesh.mesh(), options), near);
      std::printf("%s, first layer %.0e edge lengths: spans not proven valid %lld of %lld with propagation, %lld "
                  "without\n",
        valenceFive ? "valences 3 and 5" : "valence 3", first, static_cast<long long>(with.others),
        static_cast<long long>(with.valid) + static_cast<long long>(with.others),
        static_cast<long long>(without.others));
      EXPECT_EQ(with.others, 0);
      foldedWithout += without.others;
    }
    EXPECT_GT(foldedWithout, 0);
  }
}

TEST(BodyPropagation, SameBitsForAnyNumberingAndOrientation)
{
  MeshCase mesh = bodyMesh(4, 0.02, 6);
  const auto with = [&](MeshCase& any) {
    ConversionOptions options = wallOptions();
    std::vector<std::vector<double>> normals;
    for (const auto& block : any.blocks)
    {
      normals.emplace_back();
      for (const Vec3& x : block.points)
      {
        const Vec3 normal = starNormal(x);
        normals.back().insert(normals.back().end(), normal.data(), normal.data() + 3);
      }
    }
    for (const auto& array : normals)
    {
      options.surfaceNormals.push_back(array.data());
    }
    return conversioncases::convert(any.mesh(), options);
  };
  const Converted converted = with(mesh);
  EXPECT_EQ(conversioncases::interfaceJumps(converted).openControlPoints, 0);
  const auto reference = conversioncases::canonicalNet(converted);
  for (unsigned seed = 1; seed <= 3; ++seed)
  {
    MeshCase other = bodyMesh(4, 0.02, 6);
    meshcases::shuffle(other, seed, true);
    EXPECT_TRUE(conversioncases::canonicalNet(with(other)) == reference);
  }
}

// Where a border of the wall passes near seams of the body's description, which its shape does not show, its points on
// the body stay where they are.
TEST(BodyFit, SeamsDoNotAttractBorders)
{
  constexpr int Cells = 8;
  const BodySurface body(
    bodycases::starPatches(Eigen::AngleAxisd(0.006, Vec3(1.0, 2.0, 3.0).normalized()).toRotationMatrix()));
  MeshCase mesh = bodyMesh(Cells, 0.05);
  mesh.blocks.resize(1);
  mesh.boundaries.resize(1);
  BlockComplex complex = buildBlockComplex(mesh.mesh());
  const EntityRules rules = classify(complex, wallOptions(), {});
  const std::vector<Vec3> given = Wall(complex, rules).points(*aloneRank());
  BodyFitOptions options;
  options.body = &body;
  const WallFit fit = solveFit(complex, wallOptions(), rules, options);
  ASSERT_EQ(fit.targets.size(), given.size());
  double moved = 0.0, nearest = 1.0, spacing = 1.0;
  for (std::size_t i = 0; i < given.size(); ++i)
  {
    moved = std::max(moved, (fit.targets[i] - given[i]).norm());
    nearest = std::min(nearest, body.closestEdgePoint(given[i]).distance);
    for (std::size_t k = 0; k < i; ++k)
    {
      spacing = std::min(spacing, (given[i] - given[k]).norm());
    }
  }
  // Seams are near, and the interpolated body is as exact as bodycases says.
  EXPECT_LT(nearest, 0.05 * spacing);
  EXPECT_LE(moved, 1e-7);
}

TEST(BodyFit, RefusesOptionsOutOfRange)
{
  MeshCase mesh = bodyMesh(2, 0.1);
  BlockComplex complex = buildBlockComplex(mesh.mesh());
  BodyFitOptions options;
  options.tolerance = 0.0;
  EXPECT_THROW(fitBody(complex, wallOptions(), options), Error);
  options = {};
  options.iterations = 1;
  EXPECT_THROW(fitBody(complex, wallOptions(), options), Error);
}

namespace
{

/// Height of a roof whose ridge is the curve y = 0; its sides are the graphs of two quadratics.
double roof(double x, double y)
{
  return y > 0.0 ? 0.1 * x * x + 0.15 * x * y - 0.3 * y + 0.1 * y * y
                 : 0.1 * x * x - 0.1 * x * y + 0.4 * y - 0.05 * y * y;
}

BodySurface roofBody()
{
  std::vector<BodyPatch> patches;
  for (const double side : { 1.0, -1.0 })
  {
    // Control points of a quadratic through its values at the ends and in the middle of [-3, 3] x [0, 3 side].
    BodyPatch patch{ side > 0.0 ? "left" : "right", {}, {}, side < 0.0 };
    patch.surface.degree = { 2, 2 };
    patch.surface.knots = { { { 0, 0, 0, 1, 1, 1 }, { 0, 0, 0, 1, 1, 1 } } };
    Eigen::Matrix3d middle, values;
    middle << 1, 0, 0, -0.5, 2, -0.5, 0, 0, 1;
    for (int j = 0; j < 3; ++j)
    {
      for (int i = 0; i < 3; ++i)
      {
        // -0 and the like fall on the side that is meant.
        values(i, j) = roof(3.0 * (i - 1), side * std::max(1.5 * j, 1e-300));
      }
    }
    values = middle * values * middle.transpose();
    for (int j = 0; j < 3; ++j)
    {
      for (int i = 0; i < 3; ++i)
      {
        patch.surface.points.emplace_back(3.0 * (i - 1), side * 1.5 * j, values(i, j));
      }
    }
    patches.push_back(patch);
  }
  return BodySurface(patches);
}

/// Six blocks around the z axis on the roof, three on each side of its ridge, which is tagged as crease.
MeshCase onRoof(int cells)
{
  MeshCase mesh = meshcases::ring(6, cells, { { 0.0, 0.3, 0.7 } });
  mesh.apply([](const Vec3& x) { return Vec3(x[0], x[1], x[2] + roof(x[0], x[1])); });
  mesh.boundaryNames = { "wall" };
  for (int b = 0; b < 6; ++b)
  {
    mesh.boundaries.push_back({ b, 4, { { 0, 0 }, { cells, cells } }, 0 });
    for (int d = 0; d < 2; ++d)
    {
      Ijk end{ 0, 0, 0 };
      end[d] = cells;
      if (std::abs(mesh.blocks[b].at(end)[1]) < 1e-9)
      {
        mesh.creases.push_back({ b, { 0, 0, 0 }, end });
      }
    }
  }
  return mesh;
}

} // namespace

// Control points on a body with an edge: the limit curve of the crease runs along the edge, and where six patches meet
// at it the three on each side have the normal of the body there.
TEST(BodyCrease, FollowsTheEdgeAndEachSideHasItsOwnNormal)
{
  const int cells = 4;
  const BodySurface body = roofBody();
  const auto converted = [&](MeshCase& mesh, bool withBody) {
    Converted result;
    result.complex = buildBlockComplex(mesh.mesh());
    ConversionOptions options = wallOptions();
    if (withBody)
    {
      options.body = &body;
      BodyFitOptions fit;
      fit.body = &body;
      fit.edgesOnly = true;
      fitBody(result.complex, options, fit);
    }
    conversioncases::convertComplex(result, options);
    return result;
  };
  MeshCase mesh = onRoof(cells);
  EXPECT_EQ(mesh.creases.size(), 4u); // two spokes, each in two blocks
  const Converted plain = converted(mesh, false), fitted = converted(mesh, true);
  EXPECT_EQ(conversioncases::interfaceJumps(fitted).openControlPoints, 0);
  const auto everywhere = [](int, const Ijk&) { return true; };
  EXPECT_EQ(conversioncases::provenValid(fitted, everywhere).others, 0);

  const auto offTheEdge = [&](const Converted& volumes) {
    double worst = 0.0;
    for (const CreaseLine& crease : mesh.creases)
    {
      for (int s = 0; s <= cells; ++s)
      {
        const Vec3 at(crease.to[0] ? s : 0, crease.to[1] ? s : 0, 0.0);
        worst = std::max(worst, body.closestEdgePoint(evaluate(volumes.volumes[crease.block], at)).distance);
      }
    }
    return worst;
  };
  const auto normalError = [&](const Converted& volumes) {
    double worst = 0.0;
    for (int b = 0; b < 6; ++b)
    {
      const auto derivative = [&](int d) { return evaluate(volumes.volumes[b], Vec3::Zero(), { d == 0, d == 1, 0 }); };
      // The slopes of roof() along y at the origin.
      const Vec3 exact = (mesh.blocks[b].at({ cells, cells, 0 })[1] > 0.0 ? Vec3(0, 0.3, 1) : Vec3(0, -0.4, 1));
      worst = std::max(worst, (derivative(0).cross(derivative(1)).normalized() - exact.normalized()).norm());
    }
    return worst;
  };
  std::printf("crease: off the edge by %.1e without the body, %.1e with it; normals at the vertex by %.1e and %.1e\n",
    offTheEdge(plain), offTheEdge(fitted), normalError(plain), normalError(fitted));
  EXPECT_GT(offTheEdge(plain), 1e-3);
  EXPECT_LE(offTheEdge(fitted), 1e-12);
  EXPECT_GT(normalError(plain), 1e-3);
  EXPECT_LE(normalError(fitted), 1e-12);

  const auto reference = conversioncases::canonicalNet(fitted);
  for (unsigned seed = 1; seed <= 3; ++seed)
  {
    MeshCase other = onRoof(cells);
    meshcases::shuffle(other, seed, true);
    EXPECT_TRUE(conversioncases::canonicalNet(converted(other, true)) == reference);
  }
}
