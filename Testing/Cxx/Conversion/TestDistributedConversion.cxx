// SPDX-License-Identifier: BSD-3-Clause
// The conversion on several ranks gives the bits of the conversion on one.
#include "Body/ClosestPoint.h"
#include "Conversion/EntityRules.h"
#include "Ranks/Ranks.h"
#include "Support/BodyCases.h"
#include "Support/ConversionCases.h"
#include "Support/MeshCases.h"
#include "Support/ThreadRanks.h"
#include "Wall/BodyFit.h"
#include "WingFuselage/WingFuselageBody.h"
#include "WingFuselage/WingFuselageMesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <random>

namespace
{

using namespace bsv;
using conversioncases::Converted;
using meshcases::MeshCase;

constexpr double NaN = std::numeric_limits<double>::quiet_NaN();

struct Case
{
  std::string name;
  MeshCase mesh;
  ConversionOptions options;
  BlockComplexOptions complexOptions;
  /// Behind the pointers of the options.
  std::vector<std::vector<double>> spacing, projected, normals;
  std::shared_ptr<BodySurface> body;
  /// Wall points are fitted to the body before.
  bool onBody = false;

  Case(std::string theName, MeshCase theMesh, ConversionOptions theOptions = {})
    : name(std::move(theName))
    , mesh(std::move(theMesh))
    , options(std::move(theOptions))
  {
  }

  /// The options of a rank that has some blocks of the mesh.
  ConversionOptions optionsOf(const std::vector<bool>& here) const
  {
    ConversionOptions result = this->options;
    const auto point = [&](const std::vector<std::vector<double>>& arrays, std::vector<const double*>& pointers) {
      for (std::size_t b = 0; b < arrays.size(); ++b)
      {
        pointers.push_back(here[b] && !arrays[b].empty() ? arrays[b].data() : nullptr);
      }
    };
    point(this->spacing, result.wallSpacingPoints);
    point(this->projected, result.projectedPoints);
    point(this->normals, result.surfaceNormals);
    result.body = this->body ? this->body.get() : result.body;
    return result;
  }
  ConversionOptions optionsOfAll() const { return this->optionsOf(std::vector<bool>(this->mesh.blocks.size(), true)); }
};

/// The complex as a rank has it.
BlockComplex complexOf(const BlockComplex& whole, const std::vector<int>& rankOf, int rank)
{
  BlockComplex result = whole;
  for (ComplexBlock& block : result.blocks)
  {
    block.rank = rankOf[block.parent];
    block.points = block.rank == rank ? block.points : GridView::elsewhere(block.points.counts());
  }
  return result;
}

/// Control nets of the blocks that a rank has.
struct Nets
{
  std::vector<std::vector<double>> points;
  std::vector<std::vector<std::uint8_t>> rules;
  std::vector<ControlNetStorage> storage;

  Nets(const BlockComplex& complex, const ConversionOptions& options, int rank)
    : points(complex.blocks.size())
    , rules(complex.blocks.size())
    , storage(complex.blocks.size())
  {
    const auto knots = conversionKnots(complex, options);
    for (std::size_t b = 0; b < complex.blocks.size(); ++b)
    {
      const ComplexBlock& block = complex.blocks[b];
      if (block.rank == rank)
      {
        std::size_t count = 1;
        for (const std::vector<double>& along : knots[b])
        {
          count *= along.size() - 4;
        }
        this->points[b].assign(3 * count, NaN);
        this->rules[b].assign(count, 255);
        this->storage[b] = { this->points[b].data(), this->rules[b].data() };
      }
    }
  }
};

bool sameBits(const std::vector<double>& a, const std::vector<double>& b)
{
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

std::vector<bool> blocksOf(const std::vector<int>& rankOf, int rank)
{
  std::vector<bool> here;
  for (const int owner : rankOf)
  {
    here.push_back(owner == rank);
  }
  return here;
}

void expectSame(const ConversionReport& a, const ConversionReport& b)
{
  EXPECT_EQ(a.controlPoints, b.controlPoints);
  EXPECT_EQ(a.singularNodes, b.singularNodes);
  EXPECT_EQ(a.planarFaces, b.planarFaces);
  EXPECT_EQ(a.extensionDistances, b.extensionDistances);
  EXPECT_EQ(a.limitedDistances, b.limitedDistances);
  EXPECT_EQ(a.wallSpacing, b.wallSpacing);
  EXPECT_EQ(a.g1.layers, b.g1.layers);
  EXPECT_EQ(a.g1.fittedVertices, b.g1.fittedVertices);
  EXPECT_EQ(a.g1.givenUpLayers, b.g1.givenUpLayers);
  EXPECT_EQ(a.spans.checked, b.spans.checked);
  EXPECT_EQ(a.spans.repaired, b.spans.repaired);
  EXPECT_EQ(a.spans.left.size(), b.spans.left.size());
  EXPECT_EQ(a.spans.movedPoints, b.spans.movedPoints);
  EXPECT_EQ(a.spans.largestMove, b.spans.largestMove);
}

/// Converts the case on several ranks, block b on rankOf[b], and compares with the serial result.
void expectSerialBits(const Case& test, const Converted& serial, const std::vector<int>& rankOf, int ranks)
{
  const auto errors = bsvtest::onRanks(ranks, [&](const Execution& run) {
    const int rank = run.ranks->rank();
    const BlockComplex complex = complexOf(serial.complex, rankOf, rank);
    const Nets nets(complex, test.options, rank);
    const ConversionReport report =
      convertToBSplineVolume(complex, test.optionsOf(blocksOf(rankOf, rank)), nets.storage, run);
    expectSame(report, serial.report);
    for (std::size_t b = 0; b < complex.blocks.size(); ++b)
    {
      if (complex.blocks[b].rank == rank)
      {
        EXPECT_TRUE(sameBits(nets.points[b], serial.points[b])) << "block " << b;
        EXPECT_EQ(nets.rules[b], serial.rules[b]) << "block " << b;
      }
    }
  });
  EXPECT_EQ(errors, std::vector<std::string>(ranks));
}

/// Random distributions over 2 to 5 ranks, each block on its own rank where that is not too many, and one where the
/// first rank has none.
/// @return the serial result.
Converted expectSerialBits(Case test, unsigned distributions)
{
  SCOPED_TRACE(test.name);
  Converted serial;
  const BlockMesh mesh = test.mesh.mesh();
  serial.complex = buildBlockComplex(mesh, test.complexOptions);
  if (test.onBody)
  {
    BodyFitOptions fit;
    fit.body = test.options.body;
    fitBody(serial.complex, test.optionsOfAll(), fit);
  }
  conversioncases::convertComplex(serial, test.optionsOfAll());
  const int blocks = static_cast<int>(mesh.blocks.size());
  std::vector<int> rankOf(blocks);
  for (unsigned seed = 0; seed < distributions; ++seed)
  {
    SCOPED_TRACE("distribution " + std::to_string(seed));
    std::mt19937 random(seed);
    const int ranks = 2 + static_cast<int>(seed % 4);
    std::generate(rankOf.begin(), rankOf.end(), [&] { return static_cast<int>(random() % ranks); });
    expectSerialBits(test, serial, rankOf, ranks);
  }
  if (blocks <= 6)
  {
    SCOPED_TRACE("more ranks than blocks");
    for (int b = 0; b < blocks; ++b)
    {
      rankOf[b] = blocks - b;
    }
    expectSerialBits(test, serial, rankOf, blocks + 2);
  }
  SCOPED_TRACE("first rank without a block");
  expectSerialBits(test, serial, std::vector<int>(blocks, 1), 2);
  return serial;
}

Index pointsWith(const Converted& converted, int parent, ControlPointRule rule)
{
  Index count = 0;
  for (std::size_t b = 0; b < converted.rules.size(); ++b)
  {
    const auto& rules = converted.rules[b];
    count += converted.complex.blocks[b].parent == parent
      ? std::count(rules.begin(), rules.end(), static_cast<std::uint8_t>(rule))
      : 0;
  }
  return count;
}

ConversionOptions withRoles(std::vector<BoundaryRole> roles)
{
  ConversionOptions options;
  options.roles = std::move(roles);
  return options;
}

/// Names the faces `face` of all blocks.
MeshCase named(MeshCase mesh, int face, const std::string& name)
{
  const int tag = static_cast<int>(mesh.boundaryNames.size());
  mesh.boundaryNames.push_back(name);
  for (int b = 0; b < static_cast<int>(mesh.blocks.size()); ++b)
  {
    const Ijk cells = mesh.blocks[b].cells();
    mesh.boundaries.push_back({ b, face, { { 0, 0 }, { cells[faceAxis(face, 0)], cells[faceAxis(face, 1)] } }, tag });
  }
  return mesh;
}

MeshCase wavy(MeshCase mesh)
{
  mesh.apply(meshcases::wavy);
  return mesh;
}

/// Shells of blocks around a body, whose faces k = 0 are named "wall".
template <typename Shell>
MeshCase shells(const Shell& shell, const std::vector<std::vector<double>>& radii)
{
  MeshCase mesh = named(shell(radii.front()), 4, "wall");
  for (std::size_t n = 1; n < radii.size(); ++n)
  {
    for (const MeshCase::Block& block : shell(radii[n]).blocks)
    {
      mesh.blocks.push_back(block);
    }
  }
  return mesh;
}

MeshCase sphereShells(int cells, const std::vector<std::vector<double>>& radii)
{
  return shells([&](const std::vector<double>& r) { return meshcases::sphereBody(cells, r); }, radii);
}

/// Blocks over a plate z = 0 in two halves that are named "left" and "right", in layers of blocks.
MeshCase plate(int cells, const std::vector<int>& cutsInK)
{
  const auto map = [](const Vec3& x) {
    return Vec3(x[0] + 0.05 * std::sin(x[1] + x[2]), x[1] + 0.04 * x[0] * x[2],
      0.1 * (std::exp((0.3 + 0.02 * x[0] + 0.01 * x[1]) * x[2]) - 1.0));
  };
  MeshCase mesh = meshcases::cutBox({ 2 * cells, 2 * cells, 6 }, { { { cells }, { cells }, cutsInK } }, map);
  mesh.boundaryNames = { "left", "right" };
  for (int b = 0; b < 4; ++b)
  {
    mesh.boundaries.push_back({ b, 4, { { 0, 0 }, { cells, cells } }, b % 2 });
  }
  return mesh;
}

/// A box, cut at i = 3 and at the given k, on whose top a crease runs over both blocks, with thin layers below it.
MeshCase ridge(const std::vector<int>& cutsInK)
{
  MeshCase mesh = meshcases::cutBox({ 6, 4, 6 }, { { { 3 }, {}, cutsInK } }, [](const Vec3& x) {
    const double lift = x[2] * (0.3 * std::abs(x[1] - 2.0) + 0.05 * std::sin(x[0]));
    return Vec3(x[0] + 0.1 * std::sin(x[0] + x[2]), x[1] + 0.03 * x[0] * x[0] * (x[2] / 3.0), 0.5 * x[2] - 0.3 * lift);
  });
  for (std::size_t b = mesh.blocks.size() - 2; b < mesh.blocks.size(); ++b)
  {
    const int top = mesh.blocks[b].cells()[2];
    mesh.creases.push_back({ static_cast<int>(b), { 0, 2, top }, { 3, 2, top } });
  }
  return mesh;
}

TEST(DistributedConversion, RegularAndExtraordinary)
{
  const std::vector<std::vector<double>> stacks{ { 0.0, 0.2, 0.45 }, { 0.45, 0.7, 1.0, 1.3 } };
  const std::vector<Case> cases{
    { "box", wavy(meshcases::cutBox({ 9, 8, 10 }, { { { 5 }, { 1, 3 }, { 4 } } })) },
    { "oneCellBlocks", wavy(meshcases::cutBox({ 3, 3, 3 }, { { { 1, 2 }, { 1, 2 }, { 1, 2 } } })) },
    { "ring3", wavy(meshcases::ring(3, 3, stacks)) },
    { "ring5", wavy(meshcases::ring(5, 3, stacks)) },
    { "ring6OneCell", wavy(meshcases::ring(6, 1, stacks)) },
    { "ring8", meshcases::ring(8, 2, stacks) },
    { "sphereBody", meshcases::sphereBody(5, { 1.0, 1.1, 1.25, 1.5 }) },
    { "ball", meshcases::ball(4, 3) },
    { "torus", meshcases::torus(3, 4) },
    { "oGrid", wavy(meshcases::oGrid({ 8, 3, 2 })) },
    { "closedShell", wavy(meshcases::closedShell({ 7, 8, 3 })) },
    { "cGrid", meshcases::cGrid(4, 12, 3, 2) },
    { "lShape", wavy(meshcases::lShape(3)) },
  };
  for (const Case& test : cases)
  {
    expectSerialBits(test, 8);
  }
}

TEST(DistributedConversion, SinglePrecision)
{
  Case test("float ring", wavy(meshcases::ring(5, 3, { { 0.0, 0.2, 0.45 }, { 0.45, 0.7 } })));
  for (std::size_t b = 0; b < test.mesh.blocks.size(); ++b)
  {
    for (Vec3& x : test.mesh.blocks[b].points)
    {
      x = x.cast<float>().cast<double>();
    }
    test.mesh.blocks[b].isFloat = b % 3 != 0;
  }
  expectSerialBits(test, 8);
}

TEST(DistributedConversion, PlanarSides)
{
  const auto bulge = [](const Vec3& x) {
    const double bump = x[0] * (4 - x[0]) * x[1] * (4 - x[1]) * x[2] * (4 - x[2]) / 64.0;
    return Vec3(x[0] + 0.02 * x[0] * x[0] + 0.1 * bump, x[1] + 0.03 * x[1] * x[1] - 0.1 * bump, x[2] + 0.05 * bump);
  };
  for (const PlanarSides mode : { PlanarSides::FarField, PlanarSides::All, PlanarSides::None })
  {
    ConversionOptions options;
    options.planarSides = mode;
    expectSerialBits({ "bulge", meshcases::cutBox({ 4, 4, 4 }, { { { 2 }, { 1, 3 }, { 2 } } }, bulge), options }, 8);
    expectSerialBits({ "ring", meshcases::ring(5, 3, { { 0.0, 0.2, 0.45 }, { 0.45, 0.7 } }), options }, 8);
  }
}

TEST(DistributedConversion, CreasesRiseThroughSeveralBlocks)
{
  for (const PlanarSides mode : { PlanarSides::FarField, PlanarSides::None })
  {
    for (const std::vector<int>& cuts : { std::vector<int>{}, { 5 }, { 1, 2, 3, 4, 5 } })
    {
      ConversionOptions options;
      options.planarSides = mode;
      Case test("ridge", ridge(cuts), options);
      const Converted serial = expectSerialBits(test, 8);
      if (cuts.size() == 5)
      {
        // The crease is on top of the last two blocks, and reaches on into those below them.
        EXPECT_GT(pointsWith(serial, static_cast<int>(test.mesh.blocks.size()) - 4, ControlPointRule::Crease),
          pointsWith(serial, 0, ControlPointRule::Crease));
      }
      meshcases::shuffle(test.mesh, 3, true);
      expectSerialBits(test, 8);
    }
  }
  Case angled("angled", ridge({ 2, 4 }));
  angled.mesh.creases.clear();
  angled.complexOptions.creaseAngle = 10.0;
  expectSerialBits(angled, 8);
}

// Columns from creases of three blocks, and those that rise where others meet.
TEST(DistributedConversion, CreasesMeetAtCorners)
{
  Case test("cube", meshcases::aroundCube(1, 0.2, false));
  test.complexOptions.creaseAngle = 30.0;
  expectSerialBits(test, 3);
}

TEST(DistributedConversion, WallSpacing)
{
  const ConversionOptions walls = withRoles({ BoundaryRole::Body, BoundaryRole::Body });
  for (const std::vector<int>& cutsInK : { std::vector<int>{}, { 1 }, { 1, 2, 4 } })
  {
    Case constant("constant", plate(3, cutsInK), walls);
    constant.options.wallSpacing = 0.8;
    expectSerialBits(constant, 6);

    Case automatic("automatic", plate(3, cutsInK), walls);
    automatic.options.automaticWallSpacing = true;
    expectSerialBits(automatic, 6);

    Case boundaries("boundaries", plate(3, cutsInK), walls);
    boundaries.options.boundaryWallSpacing = { 0.5, 0.85 };
    expectSerialBits(boundaries, 6);

    Case points("points", plate(3, cutsInK), walls);
    points.options.automaticWallSpacing = true;
    points.options.boundaryWallSpacing = { NaN, 0.6 };
    for (std::size_t b = 0; b < points.mesh.blocks.size(); ++b)
    {
      points.spacing.emplace_back();
      for (const Vec3& x : points.mesh.blocks[b].points)
      {
        // Blocks disagree on what they share.
        const double value = 0.5 + 0.1 * std::sin(3.0 * x[0]) * std::cos(2.0 * x[1]) + 0.01 * double(b % 4);
        points.spacing.back().push_back(x[0] < 2.0 ? value : NaN);
      }
    }
    points.spacing[1].clear();
    expectSerialBits(points, 6);
  }
  Case sphere("sphere", sphereShells(3, { { 1.0, 1.1 }, { 1.1, 1.3 }, { 1.3, 1.5, 2.0 } }), walls);
  sphere.options.automaticWallSpacing = true;
  expectSerialBits(sphere, 8);
}

TEST(DistributedConversion, TwoWallsInOnePlace)
{
  // Both sides of a plate without thickness: no block shares their points, so each side keeps its own spacing.
  Case test("thin plate",
    meshcases::latticeBlocks({ { { 0, 0, 0 }, { 3, 3, 2 } }, { { 0, 0, 2 }, { 3, 3, 5 } } },
      [](const Vec3& x) { return Vec3(x[0], x[1] + 0.1 * x[0] * x[2], 0.3 * x[2]); }));
  test.mesh.boundaryNames = { "below", "above" };
  test.mesh.boundaries = { { 0, 5, { { 0, 0 }, { 3, 3 } }, 0 }, { 1, 4, { { 0, 0 }, { 3, 3 } }, 1 } };
  test.options = withRoles({ BoundaryRole::Body, BoundaryRole::Body });
  test.options.boundaryWallSpacing = { 0.5, 0.9 };
  EXPECT_EQ(expectSerialBits(test, 4).report.wallSpacing, (std::array<double, 2>{ 0.5, 0.9 }));
}

TEST(DistributedConversion, RepairOfSpans)
{
  Index repaired = 0;
  for (unsigned seed = 1; seed <= 24; ++seed)
  {
    ConversionOptions options;
    options.planarSides = PlanarSides::None;
    repaired += expectSerialBits({ "boxes " + std::to_string(seed), meshcases::randomBoxes(seed), options }, 2)
                  .report.spans.repaired;
  }
  EXPECT_GT(repaired, 0);
}

TEST(DistributedConversion, ExactG1)
{
  Case stack("stack", wavy(meshcases::ring(5, 3, { { 0.0, 0.2, 0.45 }, { 0.45, 0.7, 0.9 } })));
  Case short1("short", wavy(meshcases::ring(3, 1, { { 0.0, 0.3 }, { 0.3, 0.6 } })));
  Case nodes("ball", wavy(meshcases::ball(3, 3)));
  Case body("body", meshcases::polycubeBody({ { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, 5, { 1.0, 1.1, 1.3 }));
  body.mesh.apply([](const Vec3& x) { return Vec3(bodycases::starRadius(x.normalized()) * x); });
  body.mesh.boundaryNames = { "wall" };
  for (int b = 0; b < static_cast<int>(body.mesh.blocks.size()); ++b)
  {
    body.mesh.boundaries.push_back({ b, 4, { { 0, 0 }, { 5, 5 } }, 0 });
  }
  body.onBody = true;
  body.options = withRoles({ BoundaryRole::Body });
  body.body = std::make_shared<BodySurface>(bodycases::starPatches(Eigen::Matrix3d::Identity()));
  for (Case* test : { &stack, &short1, &nodes, &body })
  {
    test->options.continuity = Continuity::ExactG1;
    const Converted serial = expectSerialBits(*test, 6);
    EXPECT_EQ(serial.report.g1.fittedVertices > 0, test->onBody);
  }
  for (unsigned seed = 9; seed <= 13; ++seed)
  {
    Case boxes("boxes " + std::to_string(seed), meshcases::randomBoxes(seed));
    boxes.options.planarSides = PlanarSides::None;
    boxes.options.continuity = Continuity::ExactG1;
    expectSerialBits(boxes, 3);
  }
}

TEST(DistributedConversion, WallOnly)
{
  // Blocks at the wall alone are written.
  Case test("wall only", plate(3, { 2, 4 }), withRoles({ BoundaryRole::Body, BoundaryRole::Body }));
  test.options.automaticWallSpacing = true;
  test.options.wallOnly = true;
  expectSerialBits(test, 8);
}

TEST(DistributedConversion, FarFieldExtension)
{
  const auto bend = [](const Vec3& x) {
    return Vec3(x + Vec3(0.02 * (x[0] * x[0] - 9.0) * x[1], 0.03 * (x[1] * x[1] - 1.0) * x[0], 0.0));
  };
  MeshCase mesh = meshcases::extendedCuboid(3, 3, 1.5, 1.1);
  mesh.apply(bend);
  for (const FarFieldSpacing spacing :
    { FarFieldSpacing::Off, FarFieldSpacing::SideAverage, FarFieldSpacing::PerVertex })
  {
    const ConversionOptions options = withRoles({ BoundaryRole::Body, BoundaryRole::Symmetry });
    Case test("extension", mesh, options);
    test.options.farFieldSpacing = spacing;
    test.options.automaticWallSpacing = true;
    EXPECT_EQ(expectSerialBits(test, 4).report.extensionDistances.size(), spacing == FarFieldSpacing::Off ? 0u : 5u);

    // Blocks 19 to 37 are attached to the sides.
    test.name = "named";
    test.options.extensionBlocks.assign(mesh.blocks.size(), false);
    std::fill(test.options.extensionBlocks.begin() + 19, test.options.extensionBlocks.begin() + 38, true);
    expectSerialBits(test, 2);

    // A first cell that is too small for the distance: places are counted.
    Case close("close", meshcases::extendedCuboid(2, 2, 0.2), options);
    close.options.farFieldSpacing = spacing;
    EXPECT_EQ(expectSerialBits(close, 2).report.limitedDistances > 0, spacing != FarFieldSpacing::Off);
  }
}

TEST(DistributedConversion, BodiesWithFeet)
{
  const ConversionOptions walls = withRoles({ BoundaryRole::Body });
  // Thin blocks: what is carried on reaches over several of them.
  const std::vector<std::vector<double>> radii{ { 1.0, 1.05, 1.1 }, { 1.1, 1.2 }, { 1.2, 1.3, 1.5 }, { 1.5, 2.0 } };
  const auto polycube = [](const std::vector<double>& r) {
    return meshcases::polycubeBody({ { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, 2, r);
  };
  for (const bool onlyNormals : { false, true })
  {
    Case given("given", shells(polycube, radii), walls);
    for (std::size_t b = 0; b < given.mesh.blocks.size(); ++b)
    {
      given.projected.emplace_back();
      given.normals.emplace_back();
      for (const Vec3& x : given.mesh.blocks[b].points)
      {
        const Vec3 normal = Vec3(x[0], x[1], 1.1 * x[2]).normalized();
        const Vec3 projection = (0.97 + 0.001 * double(b)) * x;
        given.projected.back().insert(given.projected.back().end(), projection.data(), projection.data() + 3);
        given.normals.back().insert(given.normals.back().end(), normal.data(), normal.data() + 3);
      }
      if (onlyNormals || b % 5 == 1)
      {
        given.projected.back().clear();
      }
    }
    expectSerialBits(given, 4);
  }
  for (const Twist twist : { Twist::SecondFundamentalForm, Twist::Parallelogram, Twist::Mask, Twist::Literal })
  {
    Case onBody("body", sphereShells(3, radii), walls);
    onBody.options.twist = twist;
    onBody.body = std::make_shared<BodySurface>(bodycases::starPatches(Eigen::Matrix3d::Identity()));
    onBody.mesh.apply([](const Vec3& x) { return Vec3(x.norm() * bodycases::starPoint(x)); });
    const Converted carried = expectSerialBits(onBody, 4);
    onBody.options.propagationRange = 0.0;
    const Converted plain = expectSerialBits(onBody, 1);
    // The body changes the blocks of the second and third shell, which do not touch it.
    for (const int block : { 6, 12 })
    {
      EXPECT_FALSE(sameBits(carried.points[block], plain.points[block])) << block;
    }
  }
}

TEST(DistributedConversion, WingFuselage)
{
  WingFuselageOptions options;
  options.resolution = 2;
  const WingFuselageLayout layout = wingFuselageLayout(options);
  const std::vector<BodyPatch> patches = wingFuselageBody(options.shape);
  const BodySurface body(patches);
  std::vector<std::vector<double>> points;
  std::vector<double*> addresses;
  for (const Ijk& counts : layout.counts)
  {
    points.emplace_back(3 * std::size_t(counts[0]) * counts[1] * counts[2]);
    addresses.push_back(points.back().data());
  }
  wingFuselagePoints(options, patches, addresses);
  BlockMesh mesh;
  std::vector<Index> sizes;
  for (std::size_t b = 0; b < points.size(); ++b)
  {
    mesh.blocks.emplace_back();
    mesh.blocks.back().points = GridView(points[b].data(), layout.counts[b]);
    sizes.push_back(mesh.blocks.back().points.size());
  }
  mesh.interfaces = layout.interfaces;
  mesh.boundaries = layout.boundaries;
  mesh.boundaryNames = layout.boundaryNames;
  mesh.creases = layout.creases;

  Case test("wing", {});
  for (const std::string& name : layout.boundaryNames)
  {
    test.options.roles.push_back(name.compare(0, 4, "wall") == 0 ? BoundaryRole::Body
        : name == "symmetry"                                     ? BoundaryRole::Symmetry
                                                                 : BoundaryRole::Other);
  }
  test.options.body = &body;
  test.options.automaticWallSpacing = true;
  test.options.farFieldSpacing = FarFieldSpacing::PerVertex;
  Converted serial;
  serial.complex = buildBlockComplex(mesh);
  conversioncases::convertComplex(serial, test.options);
  EXPECT_FALSE(serial.report.extensionDistances.empty());
  for (const int ranks : { 2, 5 })
  {
    expectSerialBits(test, serial, distributeBlocks(sizes, ranks), ranks);
  }
}

TEST(DistributedConversion, RandomComplexes)
{
  for (unsigned seed = 1; seed <= 60; ++seed)
  {
    SCOPED_TRACE(seed);
    Case test("random", meshcases::randomBoxes(seed));
    test.options.planarSides = static_cast<PlanarSides>(seed % 3);
    if (seed % 2 == 0)
    {
      // All boundaries are walls.
      meshcases::declareAll(test.mesh, seed);
      test.options.roles = { BoundaryRole::Body };
      test.options.automaticWallSpacing = true;
    }
    expectSerialBits(test, 3);
  }
}

// Classes of faces and edges are known on all ranks.
TEST(DistributedConversion, RulesAreKnownOnAllRanks)
{
  MeshCase mesh = meshcases::extendedCuboid(3, 2, 1.5);
  const BlockMesh view = mesh.mesh();
  const BlockComplex whole = buildBlockComplex(view);
  const ConversionOptions options = withRoles({ BoundaryRole::Body, BoundaryRole::Symmetry });
  const EntityRules serial = classify(whole, options, {});
  std::vector<int> rankOf;
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b)
  {
    rankOf.push_back(static_cast<int>(b % 3));
  }
  const auto errors = bsvtest::onRanks(3, [&](const Execution& run) {
    const EntityRules rules = classify(complexOf(whole, rankOf, run.ranks->rank()), options, run);
    EXPECT_EQ(rules.planarFaces, serial.planarFaces);
    ASSERT_EQ(rules.farField.size(), serial.farField.size());
    for (std::size_t i = 0; i < rules.farField.size(); ++i)
    {
      EXPECT_EQ(rules.farField[i].normal, serial.farField[i].normal);
      EXPECT_EQ(rules.farField[i].faces, serial.farField[i].faces);
    }
    for (std::size_t f = 0; f < rules.faces.size(); ++f)
    {
      EXPECT_EQ(rules.faces[f].planarSide, serial.faces[f].planarSide);
      EXPECT_EQ(rules.faces[f].connection, serial.faces[f].connection);
    }
    for (std::size_t e = 0; e < rules.edges.size(); ++e)
    {
      EXPECT_EQ(rules.edges[e].rule, serial.edges[e].rule);
      EXPECT_EQ(rules.edges[e].feature, serial.edges[e].feature);
      EXPECT_EQ(rules.edges[e].anchored, serial.edges[e].anchored);
    }
  });
  EXPECT_EQ(errors, std::vector<std::string>(3));
}

/// What ends each rank of a conversion of a box in three blocks, one on each of the first three of four ranks.
std::vector<std::string> errorsOf(const std::function<void(ConversionOptions&, Execution&)>& change)
{
  MeshCase mesh = named(meshcases::cutBox({ 6, 3, 3 }, { { { 2, 4 }, {}, {} } }), 4, "wall");
  const BlockMesh view = mesh.mesh();
  const BlockComplex whole = buildBlockComplex(view);
  return bsvtest::onRanks(4, [&](Execution run) {
    const BlockComplex complex = complexOf(whole, { 0, 1, 2 }, run.ranks->rank());
    const Nets nets(complex, ConversionOptions{}, run.ranks->rank());
    ConversionOptions options = withRoles({ BoundaryRole::Body });
    change(options, run);
    convertToBSplineVolume(complex, options, nets.storage, run);
  });
}

TEST(DistributedConversion, ErrorOnOneRankEndsAllWithOneText)
{
  EXPECT_EQ(errorsOf([](ConversionOptions&, Execution&) {}), std::vector<std::string>(4));

  const std::vector<double> spacing(3 * 4 * 4, 1.5);
  const auto bad = errorsOf([&](ConversionOptions& options, Execution& run) {
    options.wallSpacingPoints.assign(3, nullptr);
    options.wallSpacingPoints[2] = run.ranks->rank() == 2 ? spacing.data() : nullptr;
  });
  EXPECT_NE(bad.front().find("Wall Spacing 1.5 at a wall point of block 'Block 2'"), std::string::npos) << bad.front();
  EXPECT_EQ(bad, std::vector<std::string>(4, bad.front()));

  const auto range = errorsOf([](ConversionOptions& options, Execution&) { options.propagationRange = -1.0; });
  EXPECT_NE(range.front().find("Propagation Range"), std::string::npos);
  EXPECT_EQ(range, std::vector<std::string>(4, range.front()));
}

TEST(DistributedConversion, AbortOnOneRankEndsAll)
{
  for (const double last : { 0.0, 0.3, 0.6, 0.9 })
  {
    for (const int rank : { 1, 3 })
    {
      const auto errors = errorsOf([&](ConversionOptions&, Execution& run) {
        const bool stops = run.ranks->rank() == rank;
        run.progress = [=](double fraction) { return !stops || fraction <= last; };
      });
      EXPECT_EQ(errors, std::vector<std::string>(4, Aborted().what())) << last;
    }
  }
}

// Two cubes of n^3 cells share a face: n^2 points, in two layers, and some lines of the surface around them.
TEST(DistributedConversion, TrafficGrowsLikeTheSharedSurface)
{
  const auto received = [](int n) {
    MeshCase mesh = meshcases::cutBox({ 2 * n, n, n }, { { { n }, {}, {} } }, meshcases::wavy);
    const BlockMesh view = mesh.mesh();
    const BlockComplex whole = buildBlockComplex(view);
    Index bytes = 0;
    const auto errors = bsvtest::onRanks(2, [&](const Execution& run) {
      const BlockComplex complex = complexOf(whole, { 0, 1 }, run.ranks->rank());
      const Nets nets(complex, ConversionOptions{}, run.ranks->rank());
      convertToBSplineVolume(complex, {}, nets.storage, run);
      if (run.ranks->rank() == 0)
      {
        bytes = run.ranks->receivedBytes();
      }
    });
    EXPECT_EQ(errors, std::vector<std::string>(2));
    return static_cast<double>(bytes);
  };
  for (const int n : { 8, 16, 32, 64 })
  {
    const double layers = 2.0 * 24.0 * (n + 1) * (n + 1);
    const double bytes = received(n);
    std::printf("two cubes of %d^3 cells: a rank received %.0f bytes, two layers are %.0f\n", n, bytes, layers);
    EXPECT_GE(bytes, layers);
    // What comes on top does not grow with the surface: numbers per vertex (12), edge (20) and face (11).
    EXPECT_LE(bytes, layers + 4096.0);
  }
}

} // namespace
