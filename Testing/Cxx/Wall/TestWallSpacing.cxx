// SPDX-License-Identifier: BSD-3-Clause
// Wall spacing: formulas against published numbers, c per boundary, point and growth, and y+ measured on sampled
// volumes.
#include "Support/ConversionCases.h"
#include "Support/MeshCases.h"
#include "Support/ThreadRanks.h"
#include "Volume/Sampling.h"
#include "Wall/WallSpacing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <random>

namespace
{

using namespace conversioncases;
using namespace meshcases;
using bsv::BoundaryRole;
using bsv::ConversionOptions;
using bsv::FlowConditions;

constexpr double NaN = std::numeric_limits<double>::quiet_NaN();

//------------------------------------------------------------------------------
// Formulas

TEST(FlowConditions, ViscosityOfAirAsInTheStandardAtmosphere)
{
  // U.S. Standard Atmosphere 1976, table III: dynamic viscosity at the temperatures of 0, 5, 11 and 20 km.
  EXPECT_NEAR(bsv::sutherlandViscosity(288.150), 1.7894e-5, 1e-9);
  EXPECT_NEAR(bsv::sutherlandViscosity(255.676), 1.6282e-5, 1e-9);
  EXPECT_NEAR(bsv::sutherlandViscosity(216.774), 1.4223e-5, 1e-9);
  EXPECT_NEAR(bsv::sutherlandViscosity(216.650), 1.4216e-5, 1e-9);
}

TEST(FlowConditions, ReferenceStateIsThatOfTheStandardAtmosphere)
{
  // Sea level: a = 340.294 m/s, rho = 1.2250 kg/m^3, p = 101325 Pa, k = 0.025326 W/(m K) (tables I and III; the heat
  // conductivity there follows its own fit, which is Pr = 0.710). The Reynolds number that belongs to 1 m and M = 0.5:
  FlowConditions flow;
  flow.machNumber = 0.5;
  flow.prandtlNumber = 0.710;
  flow.reynoldsNumber = 1.2250 * 0.5 * 340.294 / 1.7894e-5;
  const bsv::ReferenceState state = bsv::referenceState(flow);
  EXPECT_NEAR(state.soundSpeed, 340.294, 1e-3);
  EXPECT_NEAR(state.velocity, 170.147, 1e-3);
  EXPECT_NEAR(state.density, 1.2250, 1e-4);
  EXPECT_NEAR(state.pressure, 101325.0, 10.0);
  EXPECT_NEAR(state.conductivity, 0.025326, 2e-5);
  // What makes the equations dimensionless, from the dimensional quantities by their definition.
  EXPECT_NEAR(state.viscousCoefficient, state.viscosity / (state.density * state.velocity), 1e-15);
  EXPECT_NEAR(state.heatCoefficient, state.conductivity * 288.15 / (state.density * std::pow(state.velocity, 3)),
    1e-10 * state.heatCoefficient);
  EXPECT_NEAR(state.pressureCoefficient, state.pressure / (state.density * state.velocity * state.velocity), 1e-12);

  // The same flow with the mesh in millimetres.
  FlowConditions millimetres = flow;
  millimetres.referenceLength = 1000.0;
  millimetres.lengthUnit = 1e-3;
  EXPECT_NEAR(bsv::referenceState(millimetres).density, state.density, 1e-12);

  for (double FlowConditions::*member : { &FlowConditions::reynoldsNumber, &FlowConditions::machNumber,
         &FlowConditions::referenceLength, &FlowConditions::temperature, &FlowConditions::prandtlNumber })
  {
    FlowConditions wrong = flow;
    wrong.*member = 0.0;
    EXPECT_THROW(bsv::referenceState(wrong), bsv::Error);
  }
}

TEST(FlowConditions, LaminarLayerSolvesTheBlasiusEquation)
{
  // f''' + f f'' / 2 = 0, f(0) = f'(0) = 0, f'(inf) = 1, integrated here from the curvature that the scaling of the
  // equation gives: a solution with f''(0) = 1 and f'(inf) = m becomes the wanted one with f''(0) = m^(-3/2).
  double f = 0.0, slope = 0.0, curvature = 1.0;
  const double step = 1e-4;
  const auto advance = [&](double& g, double& g1, double& g2) {
    // Midpoint rule.
    const double h = 0.5 * step;
    const double mid = g + h * g1, mid1 = g1 + h * g2, mid2 = g2 - h * 0.5 * g * g2;
    g += step * mid1;
    g1 += step * mid2;
    g2 -= step * 0.5 * mid * mid2;
  };
  for (double eta = 0.0; eta < 12.0; eta += step)
  {
    advance(f, slope, curvature);
  }
  const double wallCurvature = std::pow(slope, -1.5);
  f = slope = 0.0;
  curvature = wallCurvature;
  double eta = 0.0;
  for (; slope < 0.99; eta += step)
  {
    advance(f, slope, curvature);
  }
  FlowConditions flow;
  flow.reynoldsNumber = 1e5;
  flow.transition = std::numeric_limits<double>::infinity();
  const bsv::PlateLayer layer = bsv::plateLayer(flow, 0.4);
  EXPECT_DOUBLE_EQ(layer.reynolds, 4e4);
  EXPECT_FALSE(layer.turbulent);
  EXPECT_NEAR(layer.skinFriction, 2.0 * wallCurvature / std::sqrt(4e4), 1e-3 * layer.skinFriction);
  EXPECT_NEAR(layer.thickness, eta * 0.4 / std::sqrt(4e4), 0.02 * layer.thickness);
}

TEST(FlowConditions, TurbulentLayerIsThatOfThePowerLaw)
{
  // With the one-seventh power law the momentum thickness is 7/72 delta, and c_f = 2 d theta / dx (von Karman).
  FlowConditions flow;
  flow.reynoldsNumber = 5e6;
  const double x = 0.8, h = 1e-4;
  const auto thickness = [&](double at) { return bsv::plateLayer(flow, at).thickness; };
  const double slope = (thickness(x + h) - thickness(x - h)) / (2.0 * h);
  EXPECT_NEAR(bsv::plateLayer(flow, x).skinFriction, 2.0 * 7.0 / 72.0 * slope, 0.04 * 2.0 * 7.0 / 72.0 * slope);
  // Schultz-Grunow's fit of measurements (1941): c_f = 0.370 (log10 Re_x)^(-2.584).
  EXPECT_NEAR(bsv::plateLayer(flow, x).skinFriction, 0.370 * std::pow(std::log10(4e6), -2.584), 1e-4);

  flow.transition = 0.2;
  EXPECT_FALSE(bsv::plateLayer(flow, 0.2).turbulent);
  EXPECT_TRUE(bsv::plateLayer(flow, 0.2001).turbulent);
  double before = 0.0;
  for (double at = 0.01; at < 1.0; at += 0.01)
  {
    EXPECT_GE(bsv::plateLayer(flow, at).thickness, before);
    before = bsv::plateLayer(flow, at).thickness;
  }
  // y+ from the definition with dimensional quantities.
  const bsv::ReferenceState state = bsv::referenceState(flow);
  const bsv::PlateLayer layer = bsv::plateLayer(flow, 0.7);
  const double stress = 0.5 * layer.skinFriction * state.density * state.velocity * state.velocity;
  const double height = bsv::heightOf(flow, layer.skinFriction, 2.5);
  EXPECT_NEAR(height * std::sqrt(stress / state.density) * state.density / state.viscosity, 2.5, 1e-12);
  EXPECT_NEAR(bsv::yPlus(flow, layer.skinFriction, height), 2.5, 1e-12);
}

//------------------------------------------------------------------------------
// c in the conversion

/// A plate of 2 x 2 blocks on z = 0 with two boundaries, x < 2 and x > 2, layers at the given heights.
MeshCase plate(int cells, const std::vector<double>& heights, const Map& map = {})
{
  MeshCase mesh;
  mesh.boundaryNames = { "wall left", "wall right" };
  for (int b = 0; b < 4; ++b)
  {
    mesh.add({ cells, cells, int(heights.size()) - 1 }, [&](const Ijk& p) {
      const int row = b / 2;
      const Vec3 x(2.0 * (b % 2) + 2.0 * p[0] / cells, 2.0 * row + 2.0 * p[1] / cells, heights[p[2]]);
      return map ? map(x) : x;
    });
    mesh.boundaries.push_back({ b, 4, { { 0, 0 }, { cells, cells } }, b % 2 });
  }
  return mesh;
}

std::vector<double> geometric(double first, double growth, int layers)
{
  std::vector<double> heights{ 0.0 };
  for (int k = 0; k < layers; ++k, first *= growth)
  {
    heights.push_back(heights.back() + first);
  }
  return heights;
}

ConversionOptions walls()
{
  ConversionOptions options;
  options.roles = { BoundaryRole::Body, BoundaryRole::Body };
  return options;
}

/// Height of the first inserted layer over that of the first mesh layer, above each place of the wall.
std::vector<double> layerFractions(const Converted& converted, int block, double firstHeight)
{
  std::vector<double> fractions;
  const bsv::BSplineVolume& volume = converted.volumes[block];
  for (int j = 0; j < volume.count(1); ++j)
  {
    for (int i = 0; i < volume.count(0); ++i)
    {
      fractions.push_back(converted.controlPoint(block, { i, j, 1 })[2] / firstHeight);
    }
  }
  return fractions;
}

TEST(WallSpacing, OneValuePerVertexAndTheMeanBetweenBoundaries)
{
  const int cells = 4;
  MeshCase mesh = plate(cells, { 0.0, 0.1, 0.3, 0.6 });
  ConversionOptions options = walls();
  options.wallSpacing = 0.6;
  options.boundaryWallSpacing = { 0.8, NaN };
  const Converted converted = convert(mesh.mesh(), options);
  EXPECT_EQ(interfaceJumps(converted).openControlPoints, 0);
  EXPECT_DOUBLE_EQ(converted.report.wallSpacing[0], 0.6);
  EXPECT_DOUBLE_EQ(converted.report.wallSpacing[1], 0.8);
  const std::vector<double> left = layerFractions(converted, 0, 0.1), right = layerFractions(converted, 1, 0.1);
  for (int j = 0; j < cells + 3; ++j)
  {
    const auto row = [&](const std::vector<double>& list, int i) { return list[i + (cells + 3) * j]; };
    EXPECT_NEAR(row(left, 0), 0.2, 1e-14);
    EXPECT_NEAR(row(right, cells + 2), 0.4, 1e-14);
    // 1 - c is 0.2, 0.3 and 0.4 before, on and behind the border: there [1 4 1]/6 and beside it [2 1]/3 of that.
    EXPECT_NEAR(row(left, cells + 2), 0.3, 1e-14);
    EXPECT_NEAR(row(left, cells + 1), (2.0 * 0.3 + 0.2) / 3.0, 1e-14);
    EXPECT_NEAR(row(right, 1), (2.0 * 0.3 + 0.4) / 3.0, 1e-14);
  }
  // The layer is as smooth as any other.
  const Jumps jumps = interfaceJumps(converted);
  EXPECT_GT(jumps.regular, 0);
  EXPECT_FALSE(jumps.exceeds()[0] || jumps.exceeds()[1] || jumps.exceeds()[2]);
}

TEST(WallSpacing, BothSidesOfABaffleKeepTheirOwn)
{
  // Two blocks of walls in one place, which nothing but coordinates could mistake for each other.
  const int cells = 2;
  MeshCase mesh;
  mesh.boundaryNames = { "below", "above" };
  for (int b = 0; b < 2; ++b)
  {
    mesh.add({ cells, cells, 3 }, [&](const Ijk& p) { return Vec3(p[0], p[1], b == 0 ? p[2] - 3.0 : p[2]); });
  }
  mesh.boundaries = { { 0, 5, { { 0, 0 }, { cells, cells } }, 0 }, { 1, 4, { { 0, 0 }, { cells, cells } }, 1 } };
  ConversionOptions options = walls();
  options.boundaryWallSpacing = { 0.5, 0.9 };
  const Converted converted = convert(mesh.mesh(), options);
  EXPECT_EQ(converted.report.wallSpacing, (std::array<double, 2>{ 0.5, 0.9 }));
  for (int j = 0; j < cells + 3; ++j)
  {
    for (int i = 0; i < cells + 3; ++i)
    {
      EXPECT_NEAR(converted.controlPoint(0, { i, j, 4 })[2], -0.5, 1e-14);
      EXPECT_NEAR(converted.controlPoint(1, { i, j, 1 })[2], 0.1, 1e-14);
    }
  }
}

TEST(WallSpacing, PointsOverrideBoundariesAndAutomaticFollowsTheGrowth)
{
  const int cells = 3;
  const double growth = 1.3;
  MeshCase mesh = plate(cells, geometric(0.01, growth, 6));
  std::vector<double> points(mesh.blocks[0].points.size(), NaN);
  points[mesh.blocks[0].index({ 1, 1, 0 })] = 0.9;
  ConversionOptions options = walls();
  options.automaticWallSpacing = true;
  options.boundaryWallSpacing = { NaN, 0.7 };
  options.wallSpacingPoints = { points.data(), nullptr, nullptr, nullptr };
  const Converted converted = convert(mesh.mesh(), options);
  EXPECT_NEAR(layerFractions(converted, 0, 0.01)[2 + (cells + 3) * 2], 0.1, 1e-14);
  EXPECT_NEAR(layerFractions(converted, 1, 0.01).back(), 0.3, 1e-14);
  const double matching = 1.0 / (3.0 + std::log(growth));
  EXPECT_NEAR(layerFractions(converted, 2, 0.01)[0], matching, 1e-14);
  // The growth of the converted layers at the wall is ln g per span.
  const bsv::BSplineVolume& volume = converted.volumes[2];
  const double slope = bsv::evaluate(volume, Vec3::Zero(), { 0, 0, 1 })[2];
  const double bend = bsv::evaluate(volume, Vec3::Zero(), { 0, 0, 2 })[2];
  EXPECT_NEAR(bend / slope, std::log(growth), 1e-12);

  points[mesh.blocks[0].index({ 1, 1, 0 })] = 1.0;
  EXPECT_THROW(convert(mesh.mesh(), options), bsv::Error);
}

TEST(WallSpacing, VaryingValuesKeepTheirBitsInAnyNumbering)
{
  // c from the growth of layers that differ from point to point, around extraordinary vertices.
  MeshCase mesh = sphereBody(4, { 1.0, 1.02, 1.05, 1.1 });
  for (MeshCase::Block& block : mesh.blocks)
  {
    for (Vec3& x : block.points)
    {
      const double r = x.norm();
      x *= 1.0 + 0.3 * (r - 1.0) * (r - 1.0) * std::sin(3.0 * x[0] / r + 2.0 * x[1] / r);
    }
    mesh.boundaries.push_back({ int(&block - mesh.blocks.data()), 4, { { 0, 0 }, { 4, 4 } }, 0 });
  }
  mesh.boundaryNames = { "wall" };
  ConversionOptions options;
  options.roles = { BoundaryRole::Body };
  options.automaticWallSpacing = true;
  const auto expected = canonicalNet(convert(mesh.mesh(), options));
  EXPECT_EQ(interfaceJumps(convert(mesh.mesh(), options)).openControlPoints, 0);
  for (unsigned seed = 1; seed <= 6; ++seed)
  {
    MeshCase other = mesh;
    shuffle(other, seed, seed % 2 == 0);
    EXPECT_TRUE(canonicalNet(convert(other.mesh(), options, {}, twoThreads())) == expected) << seed;
  }
}

//------------------------------------------------------------------------------
// From flow conditions to y+ measured on the sampled volume

struct Measured
{
  bsv::WallSpacingResult result;
  /// Largest relative error of y+ of the first sampled cell: of what the result says, and of the target where the
  /// growth allows it.
  double ofReport = 0.0;
  double ofTarget = 0.0;
  bsv::Index points = 0;
  bsv::Index allowed = 0;
};

/// Mesh -> wall spacing -> conversion -> sampler -> y+ of the cell at each wall vertex.
Measured endToEnd(MeshCase& mesh, const ConversionOptions& options, const bsv::WallSpacingOptions& wall)
{
  Measured measured;
  const bsv::BlockMesh view = mesh.mesh();
  const bsv::BlockComplex complex = bsv::buildBlockComplex(view);
  measured.result = bsv::wallSpacing(view, complex, options, wall);
  ConversionOptions with = options;
  for (const std::vector<double>& points : measured.result.spacingPoints)
  {
    with.wallSpacingPoints.push_back(points.empty() ? nullptr : points.data());
  }
  const Converted converted = convert(view, with);
  const int parts = 1 << wall.level;
  for (const bsv::WallSpacingResult::Side& side : measured.result.sides)
  {
    const bsv::BSplineVolume& volume = converted.volumes[side.block];
    const bsv::Ijk counts = bsv::sampleCounts(volume, wall.level, "");
    std::vector<double> samples(3 * bsv::Index(counts[0]) * counts[1] * counts[2]);
    bsv::sample(volume, wall.level, { 0, 0, 0 }, samples.data());
    const bsv::GridView grid(samples.data(), counts);
    const bsv::Ijk cells{ counts[0] - 1, counts[1] - 1, counts[2] - 1 };
    const int ns = cells[bsv::faceAxis(side.face, 0)] / parts + 1;
    for (std::size_t i = 0; i < side.vertices.size(); ++i)
    {
      const bsv::Index v = side.vertices[i];
      bsv::Ijk ijk = bsv::facePoint(cells, side.face, int(i) % ns * parts, int(i) / ns * parts);
      const Vec3 foot = grid(ijk);
      ijk[bsv::faceDirection(side.face)] += bsv::faceSide(side.face) ? -1 : 1;
      const double height = (grid(ijk) - foot).norm();
      const double y = bsv::yPlus(wall.flow, measured.result.layers[v].skinFriction, height);
      measured.ofReport = std::max(measured.ofReport, std::abs(y / measured.result.yPlus[v] - 1.0));
      ++measured.points;
      if (measured.result.allowed[v] != 0)
      {
        measured.ofTarget = std::max(measured.ofTarget, std::abs(y / wall.targetYPlus - 1.0));
        ++measured.allowed;
      }
    }
  }
  return measured;
}

void print(const char* name, int level, const Measured& measured)
{
  const std::vector<double>& c = measured.result.spacing;
  std::printf(
    "%s, level %d: growth allows the target at %lld of %lld wall points, y+ there off by at most %.1e; c %.3f "
    "to %.3f, growth up to %.3f\n%s\n",
    name, level, static_cast<long long>(measured.allowed), static_cast<long long>(measured.points), measured.ofTarget,
    *std::min_element(c.begin(), c.end()), *std::max_element(c.begin(), c.end()),
    *std::max_element(measured.result.growth.begin(), measured.result.growth.end()), measured.result.warning.c_str());
}

/// First cells are some 1e-5 of the coordinates, which are rounded to 1e-16.
constexpr double ReportTolerance = 1e-10;

TEST(WallSpacing, FirstSampledCellHasTheTargetOnAPlate)
{
  // A plate in the middle of a longer one (its leading edge is far), meshed for the y+ in its middle.
  for (const int level : { 0, 1, 2, 3 })
  {
    bsv::WallSpacingOptions wall;
    wall.flow.reynoldsNumber = 1e6;
    wall.flow.referenceLength = 4.0;
    wall.minimumDistance = 0.2;
    wall.level = level;
    const bsv::PlateLayer middle = bsv::plateLayer(wall.flow, 2.0);
    // The first sampled cell of layers with the growth g is about 2^-L g^(-1/2) of the first layer.
    const double first = bsv::heightOf(wall.flow, middle.skinFriction, 1.0) * (1 << level) * (level > 0 ? 1.05 : 1.0);
    MeshCase mesh = plate(8, geometric(first, 1.1, 12), [](const Vec3& x) {
      return Vec3(x[0], x[1], x[2] * (1.0 + 0.02 * std::sin(2.0 * x[0]) * std::cos(3.0 * x[1])));
    });
    const Measured measured = endToEnd(mesh, walls(), wall);
    print("plate", level, measured);
    EXPECT_LT(measured.ofReport, ReportTolerance);
    EXPECT_LT(measured.ofTarget, bsv::WallSpacingResult::Accuracy);
    // Large cells leave little room: the second one is half a span, or a whole one, away.
    EXPECT_GT(measured.allowed, level < 2 ? 0 : measured.points / 2);
    EXPECT_EQ(measured.result.warning.empty(), measured.result.reached == bsv::Index(measured.result.points.size()));
  }
}

TEST(WallSpacing, FirstSampledCellHasTheTargetOnASphere)
{
  for (const int level : { 1, 2 })
  {
    bsv::WallSpacingOptions wall;
    wall.flow.reynoldsNumber = 1e5;
    wall.flow.referenceLength = 2.0;
    wall.minimumDistance = 0.1;
    wall.level = level;
    const double target = bsv::heightOf(wall.flow, bsv::plateLayer(wall.flow, 1.0).skinFriction, 1.0);
    std::vector<double> radii = geometric(target * (1 << level), 1.2, 15);
    for (double& r : radii)
    {
      r += 1.0;
    }
    MeshCase mesh = sphereBody(8, radii);
    mesh.boundaryNames = { "wall" };
    for (int b = 0; b < 6; ++b)
    {
      mesh.boundaries.push_back({ b, 4, { { 0, 0 }, { 8, 8 } }, 0 });
    }
    ConversionOptions options;
    options.roles = { BoundaryRole::Body };
    const Measured measured = endToEnd(mesh, options, wall);
    print("sphere", level, measured);
    EXPECT_LT(measured.ofReport, ReportTolerance);
    EXPECT_LT(measured.ofTarget, bsv::WallSpacingResult::Accuracy);
    EXPECT_GT(measured.allowed, measured.points / 2);
  }
}

TEST(WallSpacing, CreasesAndTheSymmetryPlane)
{
  // Half an ellipsoid in front of its symmetry plane, with a far-field extension.
  bsv::WallSpacingOptions wall;
  wall.flow.reynoldsNumber = 1e6;
  wall.flow.referenceLength = 2.4;
  wall.minimumDistance = 0.2;
  wall.level = 2;
  MeshCase mesh = extendedCuboid(6, 24, 1.0, 1.2);
  ConversionOptions options;
  options.roles = { BoundaryRole::Body, BoundaryRole::Symmetry };
  wall.targetYPlus = 1.0;
  const bsv::BlockMesh view = mesh.mesh();
  const Measured trial = endToEnd(mesh, options, wall);
  // The mesh is not made for a certain y+: the target is what it has in the middle of its range.
  std::vector<double> yPlus = trial.result.yPlus;
  std::nth_element(yPlus.begin(), yPlus.begin() + yPlus.size() / 2, yPlus.end());
  wall.targetYPlus = yPlus[yPlus.size() / 2];
  const Measured measured = endToEnd(mesh, options, wall);
  print("half ellipsoid", wall.level, measured);
  EXPECT_LT(measured.ofReport, ReportTolerance);
  EXPECT_LT(measured.ofTarget, bsv::WallSpacingResult::Accuracy);
  EXPECT_FALSE(measured.result.warning.empty());
}

TEST(WallSpacing, SaysWhichLevelOrHowManyLayersWouldDo)
{
  // Twice and 40 times too coarse for level 1.
  bsv::WallSpacingOptions wall;
  wall.flow.reynoldsNumber = 1e6;
  wall.flow.referenceLength = 4.0;
  wall.minimumDistance = 1.0; // the same boundary layer everywhere
  const double target = bsv::heightOf(wall.flow, bsv::plateLayer(wall.flow, 4.0).skinFriction, 1.0);
  MeshCase coarse = plate(4, geometric(4.2 * target, 1.1, 12));
  wall.level = 1;
  const Measured failed = endToEnd(coarse, walls(), wall);
  EXPECT_EQ(failed.allowed, 0);
  EXPECT_EQ(failed.result.levelForAll, 2);
  EXPECT_NE(failed.result.warning.find("Level 2 would reach it everywhere"), std::string::npos)
    << failed.result.warning;
  wall.level = 2;
  const Measured reached = endToEnd(coarse, walls(), wall);
  EXPECT_EQ(reached.allowed, reached.points);
  EXPECT_TRUE(reached.result.warning.empty()) << reached.result.warning;
  EXPECT_EQ(reached.result.reachingLevel.front(), 2);

  // Layers that grow by 1.9 are never fine enough for cells that grow by a fifth; as many as are said are. Their cells
  // shall start with the target and grow by a constant ratio.
  const std::vector<double> heights = geometric(2.6 * target, 1.9, 8);
  MeshCase steep = plate(4, heights);
  wall.level = 1;
  const Measured few = endToEnd(steep, walls(), wall);
  EXPECT_EQ(few.allowed, 0);
  EXPECT_EQ(few.result.levelForAll, -1);
  const int layers = few.result.layersForAll;
  ASSERT_GT(layers, 8);
  std::printf("%s\n", few.result.warning.c_str());
  const auto total = [&](double ratio) { return target * (std::pow(ratio, 2 * layers) - 1.0) / (ratio - 1.0); };
  double low = 1.0001, high = 2.0;
  for (int step = 0; step < 60; ++step)
  {
    const double middle = 0.5 * (low + high);
    (total(middle) < heights.back() ? low : high) = middle;
  }
  MeshCase enough = plate(4, geometric(target * (1.0 + low), low * low, layers));
  const Measured now = endToEnd(enough, walls(), wall);
  EXPECT_EQ(now.allowed, now.points) << now.result.warning << " ratio " << low;
}

TEST(WallSpacing, CountsCellsInTheBoundaryLayer)
{
  bsv::WallSpacingOptions wall;
  wall.flow.reynoldsNumber = 1e4;
  wall.flow.referenceLength = 4.0;
  wall.minimumDistance = 1.0;
  wall.level = 1;
  wall.targetYPlus = 0.5;
  wall.maximumGrowth = 100.0;
  // Uniform layers, delta = 0.37 4 / 1e4^0.2 in 0.05: the cells away from the wall are half a layer high.
  const double delta = 0.37 * 4.0 / std::pow(1e4, 0.2);
  MeshCase mesh = plate(4, geometric(0.05, 1.0, 20));
  const Measured measured = endToEnd(mesh, walls(), wall);
  EXPECT_NEAR(measured.result.layers.front().thickness, delta, 1e-14);
  for (const double cells : measured.result.cells)
  {
    EXPECT_NEAR(cells, delta / 0.05 * 2.0, 0.05);
  }
}

TEST(WallSpacing, SameForAnyNumberingAndRefusesWhatIsWrong)
{
  bsv::WallSpacingOptions wall;
  wall.flow.reynoldsNumber = 1e5;
  wall.minimumDistance = 0.2;
  wall.targetYPlus = 30.0;
  MeshCase mesh = extendedCuboid(3, 4, 1.0, 1.2);
  ConversionOptions options;
  options.roles = { BoundaryRole::Body, BoundaryRole::Symmetry };
  const auto values = [&](MeshCase& which) {
    const bsv::BlockMesh view = which.mesh();
    const bsv::WallSpacingResult result =
      bsv::wallSpacing(view, bsv::buildBlockComplex(view), options, wall, twoThreads());
    std::vector<std::array<double, 5>> list;
    for (std::size_t v = 0; v < result.points.size(); ++v)
    {
      const Vec3& x = result.points[v];
      list.push_back({ x[0], x[1], x[2], result.spacing[v], result.cells[v] });
    }
    std::sort(list.begin(), list.end());
    return list;
  };
  const auto expected = values(mesh);
  for (unsigned seed = 1; seed <= 6; ++seed)
  {
    MeshCase other = mesh;
    shuffle(other, seed, seed % 2 == 0);
    EXPECT_TRUE(values(other) == expected) << seed;
  }

  const auto refused = [&](auto change) {
    bsv::WallSpacingOptions wrong = wall;
    change(wrong);
    const bsv::BlockMesh view = mesh.mesh();
    EXPECT_THROW(bsv::wallSpacing(view, bsv::buildBlockComplex(view), options, wrong), bsv::Error);
  };
  refused([](auto& wrong) { wrong.targetYPlus = 0.0; });
  refused([](auto& wrong) { wrong.maximumGrowth = 1.0; });
  refused([](auto& wrong) { wrong.level = 9; });
  refused([](auto& wrong) { wrong.direction.setZero(); });
  refused([](auto& wrong) { wrong.minimumDistance = 0.0; });
  refused([](auto& wrong) { wrong.flow.machNumber = NaN; });
  options.roles.clear();
  refused([](auto&) {});
}

//------------------------------------------------------------------------------
// Meshes on several ranks

/// A wavy plate under three storeys of blocks, the boundary layer reaching into the third.
MeshCase storeys()
{
  const int cells = 3;
  const std::vector<double> heights = geometric(2e-4, 1.25, 18);
  MeshCase mesh;
  mesh.boundaryNames = { "wall left", "wall right" };
  for (int b = 0; b < 12; ++b)
  {
    mesh.add({ cells, cells, 6 }, [&](const Ijk& p) {
      const double x = 2.0 * (b % 2) + 2.0 * p[0] / cells, y = 2.0 * (b / 2 % 2) + 2.0 * p[1] / cells;
      return Vec3(x, y, heights[6 * (b / 4) + p[2]] * (1.0 + 0.1 * std::sin(x + 2.0 * y)) + 0.02 * std::cos(x * y));
    });
    if (b < 4)
    {
      mesh.boundaries.push_back({ b, 4, { { 0, 0 }, { cells, cells } }, b % 2 });
    }
  }
  return mesh;
}

TEST(WallSpacing, SameBitsOnAnyRanks)
{
  const auto check = [](MeshCase& mesh, const ConversionOptions& options, const bsv::WallSpacingOptions& wall) {
    const bsv::BlockMesh whole = mesh.mesh();
    bsv::WallSpacingResult serial = bsv::wallSpacing(whole, bsv::buildBlockComplex(whole), options, wall);
    for (int size = 2; size <= 5; ++size)
    {
      std::mt19937 random(size);
      std::vector<int> rankOf;
      for (std::size_t b = 0; b < whole.blocks.size(); ++b)
      {
        rankOf.push_back(static_cast<int>(random() % (size == 4 ? 3 : size))); // of four ranks the last has nothing
      }
      std::vector<bsv::Index> counted(size, 0), sides(size, 0);
      const auto errors = bsvtest::onRanks(size, [&](const bsv::Execution& run) {
        const int rank = run.ranks->rank();
        const bsv::BlockMesh part = bsvtest::distributed(whole, rankOf, rank);
        const bsv::BlockComplex complex = bsv::buildBlockComplex(part, {}, run);
        const bsv::WallSpacingResult result = bsv::wallSpacing(part, complex, options, wall, run);
        EXPECT_EQ(result.wallPoints, serial.wallPoints);
        EXPECT_EQ(result.reached, serial.reached);
        EXPECT_EQ(result.levelForAll, serial.levelForAll);
        EXPECT_EQ(result.layersForAll, serial.layersForAll);
        EXPECT_EQ(result.warning, serial.warning);
        for (std::size_t b = 0; b < whole.blocks.size(); ++b)
        {
          const std::vector<double>& c = result.spacingPoints[b];
          const std::vector<double>& expected = serial.spacingPoints[b];
          ASSERT_EQ(c.size(), rankOf[b] == rank ? expected.size() : 0u);
          EXPECT_EQ(c.empty() ? 0 : std::memcmp(c.data(), expected.data(), c.size() * sizeof(double)), 0);
        }
        for (const bsv::WallSpacingResult::Side& side : result.sides)
        {
          const auto other = std::find_if(serial.sides.begin(), serial.sides.end(),
            [&](const auto& found) { return found.block == side.block && found.face == side.face; });
          ASSERT_NE(other, serial.sides.end());
          for (std::size_t i = 0; i < side.vertices.size(); ++i)
          {
            const bsv::Index v = side.vertices[i], w = other->vertices[i];
            EXPECT_EQ(result.points[v], serial.points[w]);
            EXPECT_EQ(result.layers[v].distance, serial.layers[w].distance);
            EXPECT_EQ(result.spacing[v], serial.spacing[w]);
            EXPECT_EQ(result.firstHeight[v], serial.firstHeight[w]);
            EXPECT_EQ(result.yPlus[v], serial.yPlus[w]);
            EXPECT_EQ(result.growth[v], serial.growth[w]);
            EXPECT_EQ(result.cells[v], serial.cells[w]);
            EXPECT_EQ(result.allowed[v], serial.allowed[w]);
            EXPECT_EQ(result.reachingLevel[v], serial.reachingLevel[w]);
          }
        }
        sides[rank] = static_cast<bsv::Index>(result.sides.size());
        counted[rank] = std::count(result.counted.begin(), result.counted.end(), 1);
      });
      EXPECT_EQ(errors, std::vector<std::string>(size));
      EXPECT_EQ(std::accumulate(sides.begin(), sides.end(), bsv::Index(0)), bsv::Index(serial.sides.size()));
      EXPECT_EQ(std::accumulate(counted.begin(), counted.end(), bsv::Index(0)), serial.wallPoints);
    }
    return serial;
  };
  bsv::WallSpacingOptions wall;
  wall.flow.reynoldsNumber = 1e6;
  wall.flow.referenceLength = 4.0;
  wall.minimumDistance = 0.2;
  MeshCase plates = storeys();
  const bsv::WallSpacingResult result = check(plates, walls(), wall);
  // The layer really reaches beyond the blocks at the wall.
  EXPECT_GT(*std::max_element(result.cells.begin(), result.cells.end()), 2.0 * 12.0);

  // Creases, a symmetry plane, extraordinary vertices.
  MeshCase body = extendedCuboid(4, 12, 1.0, 1.2);
  ConversionOptions options;
  options.roles = { BoundaryRole::Body, BoundaryRole::Symmetry };
  wall.targetYPlus = 15.0;
  check(body, options, wall);
}

TEST(WallSpacing, AllRanksEndTogether)
{
  MeshCase mesh = storeys();
  const bsv::BlockMesh whole = mesh.mesh();
  const std::vector<int> rankOf{ 0, 1, 0, 1, 2, 2, 2, 2, 0, 1, 2, 0 };
  for (int steps = 0; steps < 40; steps += 3)
  {
    const auto errors = bsvtest::onRanks(3, [&](bsv::Execution run) {
      const bsv::BlockMesh part = bsvtest::distributed(whole, rankOf, run.ranks->rank());
      const bsv::BlockComplex complex = bsv::buildBlockComplex(part, {}, run);
      int reports = 0;
      run.progress = [&](double) { return run.ranks->rank() != 1 || ++reports <= steps; };
      bsv::wallSpacing(part, complex, walls(), {}, run);
    });
    EXPECT_EQ(errors, std::vector<std::string>(3, errors[0]));
    EXPECT_TRUE(errors[0] == bsv::Aborted().what() || (steps > 0 && errors[0].empty())) << errors[0];
  }
  const auto errors = bsvtest::onRanks(3, [&](const bsv::Execution& run) {
    const bsv::BlockMesh part = bsvtest::distributed(whole, rankOf, run.ranks->rank());
    bsv::wallSpacing(part, bsv::buildBlockComplex(part, {}, run), {}, {}, run);
  });
  EXPECT_NE(errors[2].find("no wall"), std::string::npos);
  EXPECT_EQ(errors, std::vector<std::string>(3, errors[2]));
}

} // namespace
