// SPDX-License-Identifier: BSD-3-Clause
// Meshes without inverted cells become volumes without inverted spans.
#include "Body/ClosestPoint.h"
#include "Support/BodyCases.h"
#include "Support/ConversionCases.h"
#include "Support/MeshCases.h"
#include "Wall/BodyFit.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>

using namespace bsv;
using conversioncases::convert;
using conversioncases::Converted;
using meshcases::MeshCase;

namespace
{

Index notProven(const Converted& converted)
{
  return conversioncases::provenValid(converted, [](int, const Ijk&) { return true; }).others;
}

/// Two blocks around a blunt edge, a convex corner of 90 degrees of the wall j = 0: long cells (a) on the side y = 0,
/// cells of length 1 on the side x = 0. Columns rise at right angles, that of the corner in the direction (lean, 1).
MeshCase bluntEdge(double a, double lean, double firstLayer)
{
  constexpr int Cells = 4, Layers = 24, Span = 3;
  MeshCase mesh;
  const auto height = [&](int k) { return firstLayer * (std::pow(1.5, k) - 1.0) / 0.5; };
  const auto above = [&](const Vec3& foot, const Vec3& direction, int j, int k) {
    return Vec3(foot + height(j) * direction + Vec3(0, 0, 0.5 * k));
  };
  const Vec3 corner(lean, 1, 0);
  mesh.add({ Cells, Layers, Span }, [&](const Ijk& p) {
    return above(Vec3(a * (p[0] - Cells), 0, 0), p[0] == Cells ? corner : Vec3(0, 1, 0), p[1], p[2]);
  });
  mesh.add({ Cells, Layers, Span },
    [&](const Ijk& p) { return above(Vec3(0, -p[0], 0), p[0] == 0 ? corner : Vec3(1, 0, 0), p[1], p[2]); });
  mesh.boundaryNames = { "wall" };
  for (int b = 0; b < 2; ++b)
  {
    mesh.boundaries.push_back({ b, 2, { { 0, 0 }, { Cells, Span } }, 0 });
  }
  return mesh;
}

/// A box of 5^3 cells whose inner points are displaced at random by up to `amount` cells.
MeshCase displacedBox(unsigned seed, double amount)
{
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-amount, amount);
  const Ijk cells{ 5, 5, 5 };
  std::map<std::array<int, 3>, Vec3> offsets;
  MeshCase mesh = meshcases::cutBox(cells, {}, [&](const Vec3& x) {
    const std::array<int, 3> at{ static_cast<int>(x[0]), static_cast<int>(x[1]), static_cast<int>(x[2]) };
    const bool inner = std::all_of(at.begin(), at.end(), [](int i) { return i > 0 && i < 5; });
    const auto [found, isNew] = offsets.emplace(at, Vec3::Zero());
    if (isNew && inner)
    {
      for (int d = 0; d < 3; ++d)
      {
        found->second[d] = unit(random);
      }
    }
    return Vec3(x + found->second);
  });
  return mesh;
}

} // namespace

// Both sides of the corner decide how far the crease reaches into the layers.
TEST(ValidSpans, BluntEdges)
{
  ConversionOptions options;
  options.roles = { BoundaryRole::Body };
  for (const double ratio : { 1.0, 5.0, 15.0, 20.0, 50.0, 100.0 })
  {
    for (const double lean : { 1.0, 0.6, 0.3 })
    {
      for (const double firstLayer : { 1e-1, 1e-3, 1e-5 })
      {
        MeshCase mesh = bluntEdge(ratio, lean, firstLayer);
        for (const double creaseAngle : { 30.0, 180.0 })
        {
          BlockComplexOptions complexOptions;
          complexOptions.creaseAngle = creaseAngle;
          EXPECT_EQ(notProven(convert(mesh.mesh(), options, complexOptions)), 0)
            << "a / b " << ratio << ", lean " << lean << ", first layer " << firstLayer << ", crease angle "
            << creaseAngle;
        }
      }
    }
  }
}

// Cubes and bars with sharp edges, one long cell along them and thin layers around: where three blocks meet at an edge,
// and more edges at a corner, the mesh lines above them keep their places without any repair.
TEST(ValidSpans, SharpEdgesBetweenSeveralBlocks)
{
  const Eigen::AngleAxisd turn(0.7, Vec3(1, 2, 3).normalized());
  for (const bool bar : { true, false })
  {
    for (const double firstLayer : bar ? std::vector<double>{ 1e-1, 1e-3, 1e-6 } : std::vector<double>{ 1e-1, 3e-2 })
    {
      for (const double shear : { 0.0, 0.8 })
      {
        MeshCase mesh = meshcases::aroundCube(1, firstLayer, bar);
        mesh.apply([&](const Vec3& x) { return turn * Vec3(x[0] + shear * x[1], x[1] - 0.5 * shear * x[2], x[2]); });
        ConversionOptions options;
        options.roles = { BoundaryRole::Body };
        options.repairSpans = false;
        BlockComplexOptions complexOptions;
        complexOptions.creaseAngle = 30.0;
        const Converted converted = convert(mesh.mesh(), options, complexOptions);
        EXPECT_EQ(notProven(converted), 0) << "bar " << bar << ", first layer " << firstLayer << ", shear " << shear;
        EXPECT_EQ(conversioncases::interfaceJumps(converted).openControlPoints, 0);
        MeshCase other = mesh;
        meshcases::shuffle(other, 5, true);
        EXPECT_TRUE(conversioncases::canonicalNet(convert(other.mesh(), options, complexOptions)) ==
          conversioncases::canonicalNet(converted));
      }
    }
  }
}

// The edge of a single block that runs out in a smooth surface: at its end the cell's three edges must not lie in one
// plane.
TEST(ValidSpans, EdgeOfOneBlockEndsAtACorner)
{
  // Five of the eight octants around a vertex: its only convex edge is that along y.
  MeshCase mesh = meshcases::latticeBlocks({ { { 0, 0, 0 }, { 2, 2, 2 } }, { { 2, 0, 0 }, { 4, 2, 2 } },
    { { 0, 2, 0 }, { 2, 4, 2 } }, { { 0, 0, 2 }, { 2, 2, 4 } }, { { 2, 0, 2 }, { 4, 2, 4 } } });
  const Converted converted = convert(mesh.mesh());
  EXPECT_EQ(notProven(converted), 0);
}

// All layers together are much thinner than the wall's cells.
TEST(ValidSpans, ThinStacks)
{
  const std::vector<std::vector<Ijk>> bodies{ { { 0, 0, 0 } }, { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } } };
  const BodySurface body(bodycases::starPatches(Eigen::Matrix3d::Identity()));
  for (const std::vector<Ijk>& cubes : bodies)
  {
    for (const double firstLayer : { 1e-1, 1e-2, 1e-3, 1e-4, 1e-5 })
    {
      constexpr int Cells = 4;
      std::vector<double> radii;
      for (int k = 0; k <= 8; ++k)
      {
        radii.push_back(1.0 + firstLayer / Cells * k);
      }
      MeshCase mesh = meshcases::polycubeBody(cubes, Cells, radii);
      mesh.apply([](const Vec3& x) { return Vec3(bodycases::starRadius(x.normalized()) * x); });
      mesh.boundaryNames = { "wall" };
      for (int b = 0; b < static_cast<int>(mesh.blocks.size()); ++b)
      {
        mesh.boundaries.push_back({ b, 4, { { 0, 0 }, { Cells, Cells } }, 0 });
      }
      ConversionOptions options;
      options.roles = { BoundaryRole::Body };
      options.body = &body;
      const Converted converted = convert(mesh.mesh(), options);
      EXPECT_EQ(notProven(converted), 0) << cubes.size() << " cubes, first layer " << firstLayer;
    }
  }
}

// Where smoothing folds valid cells, mesh points are moved until all spans are valid; shared control points stay equal,
// joins as smooth, and the bits the same for any numbering, orientation and threads.
TEST(ValidSpans, RepairOfWhatSmoothingFolds)
{
  Index failed = 0;
  for (unsigned seed = 1; seed <= 24; ++seed)
  {
    SCOPED_TRACE(seed);
    MeshCase mesh = meshcases::randomBoxes(seed);
    ConversionOptions options;
    options.planarSides = PlanarSides::None;
    options.repairSpans = false;
    const Converted before = convert(mesh.mesh(), options);
    options.repairSpans = true;
    const Converted after = convert(mesh.mesh(), options);
    EXPECT_EQ(after.report.spans.checked, before.report.spans.checked);
    EXPECT_EQ(before.report.spans.left.size(), std::size_t(after.report.spans.failed));
    EXPECT_LE(after.report.spans.left.size(), before.report.spans.left.size());
    EXPECT_EQ(conversioncases::interfaceJumps(after).openControlPoints, 0);
    if (before.report.spans.failed == 0)
    {
      EXPECT_TRUE(conversioncases::canonicalNet(after) == conversioncases::canonicalNet(before));
      continue;
    }
    failed += before.report.spans.failed;
    EXPECT_TRUE(conversioncases::canonicalNet(convert(mesh.mesh(), options, {}, conversioncases::twoThreads())) ==
      conversioncases::canonicalNet(after));
    MeshCase other = mesh;
    meshcases::shuffle(other, seed, true);
    EXPECT_TRUE(conversioncases::canonicalNet(convert(other.mesh(), options)) == conversioncases::canonicalNet(after));
  }
  EXPECT_GT(failed, 0);
}

// A wall that is moved onto its points may fold cells that were valid: these spans are for the conversion to answer
// for.
TEST(ValidSpans, CellsAreJudgedAsTheMeshHasThem)
{
  MeshCase mesh = bluntEdge(20.0, 0.3, 1e-2);
  ConversionOptions options;
  options.roles = { BoundaryRole::Body };
  options.repairSpans = false;
  Converted converted;
  converted.complex = buildBlockComplex(mesh.mesh());
  fitBody(converted.complex, options, {});
  conversioncases::convertComplex(converted, options);
  EXPECT_GT(converted.report.spans.left.size(), 0U);
  EXPECT_EQ(converted.report.spans.invalidCells, 0);

  // The wall folds them, whose points are not moved: the repair gives up as soon as nothing becomes better.
  options.repairSpans = true;
  conversioncases::convertComplex(converted, options);
  EXPECT_GT(converted.report.spans.left.size(), 0U);
  EXPECT_LT(converted.report.spans.sweeps, 40);
}

// Exact joins are given up where they would make spans invalid; the report says what the spans are.
TEST(ValidSpans, ExactG1)
{
  for (unsigned seed = 1; seed <= 12; ++seed)
  {
    SCOPED_TRACE(seed);
    MeshCase mesh = meshcases::randomBoxes(seed);
    ConversionOptions options;
    options.planarSides = PlanarSides::None;
    options.checkSpans = CheckSpans::All;
    const Converted single = convert(mesh.mesh(), options);
    options.continuity = Continuity::ExactG1;
    const Converted exact = convert(mesh.mesh(), options);
    EXPECT_EQ(exact.report.spans.left.size() + exact.report.spans.invalidCells, std::size_t(notProven(exact)));
    EXPECT_EQ(conversioncases::interfaceJumps(exact).openControlPoints, 0);
    EXPECT_EQ(exact.report.g1.layers + exact.report.g1.skippedLayers > 0, exact.report.g1.edges > 0);
    if (notProven(single) == 0)
    {
      EXPECT_EQ(notProven(exact), 0);
    }
    options.repairSpans = false;
    EXPECT_LE(notProven(exact), notProven(convert(mesh.mesh(), options)));
  }
}

// Inverted cells: moved points make all spans valid, and none that was valid becomes invalid.
TEST(ValidSpans, UntanglesDisplacedPoints)
{
  constexpr int Meshes = 10;
  int valid = 0;
  for (unsigned seed = 1; seed <= Meshes; ++seed)
  {
    SCOPED_TRACE(seed);
    MeshCase mesh = displacedBox(seed, 2.0);
    ConversionOptions options;
    options.checkSpans = CheckSpans::All;
    options.repairSpans = false;
    const Converted before = convert(mesh.mesh(), options);
    EXPECT_GT(before.complex.tangledCells, 0);
    options.untangle = true;
    const Converted after = convert(mesh.mesh(), options);
    EXPECT_LE(notProven(after), notProven(before));
    EXPECT_EQ(conversioncases::interfaceJumps(after).openControlPoints, 0);
    valid += notProven(after) == 0 ? 1 : 0;
  }
  EXPECT_EQ(valid, Meshes);
}

// Planar sides inside the mesh that keep their points: spans beside them that fold are repaired or counted, none is
// passed over.
TEST(ValidSpans, PlanarSidesInsideTheMesh)
{
  ConversionOptions options;
  options.planarSides = PlanarSides::All;
  Index repaired = 0;
  for (MeshCase mesh : { meshcases::torus(3, 2), meshcases::torus(4, 3), meshcases::ring(5, 3, { { 0.0, 1.0, 2.0 } }) })
  {
    const conversioncases::Converted converted = conversioncases::convert(mesh.mesh(), options);
    const SpanReport& spans = converted.report.spans;
    EXPECT_GT(spans.checked, 0);
    EXPECT_EQ(Index(spans.left.size()) + spans.invalidCells, notProven(converted));
    repaired += spans.repaired;
  }
  EXPECT_GT(repaired, 0) << "no case is harmed";
}
