// SPDX-License-Identifier: BSD-3-Clause
#include "Support/BodyCases.h"
#include "Support/DistributedComplex.h"
#include "Support/MeshCases.h"
#include "Wall/BodyFit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

using namespace bsv;
using bsvtest::distributed;
using bsvtest::onRanks;
using bsvtest::randomRanks;
using meshcases::MeshCase;

namespace
{

/// A mesh with a wall, and how it is fitted.
struct FitCase
{
  std::string name;
  std::shared_ptr<MeshCase> mesh = std::make_shared<MeshCase>();
  std::shared_ptr<BodySurface> body;
  BodyFitOptions fit;
  ConversionOptions conversion;

  FitCase(const std::string& caseName, MeshCase blocks, std::shared_ptr<BodySurface> surface = nullptr)
    : name(caseName)
    , body(std::move(surface))
  {
    *this->mesh = std::move(blocks);
    this->mesh->boundaryNames = { "wall" };
    this->conversion.roles = { BoundaryRole::Body };
    this->conversion.body = this->fit.body = this->body.get();
  }
  FitCase& addWall(int block, int face)
  {
    const Ijk cells = this->mesh->blocks[block].cells();
    this->mesh->boundaries.push_back(
      { block, face, { { 0, 0 }, { cells[faceAxis(face, 0)], cells[faceAxis(face, 1)] } }, 0 });
    return *this;
  }
};

void append(MeshCase& mesh, const MeshCase& other)
{
  mesh.blocks.insert(mesh.blocks.end(), other.blocks.begin(), other.blocks.end());
}

/// The star around three cubes (vertices of valence 3 and 5): blocks of one, one and `layers` cells above each other.
MeshCase starStacks(int cells, int layers)
{
  std::vector<double> radii{ 1.0 };
  for (int k = 0; k < layers + 2; ++k)
  {
    radii.push_back(radii.back() + 0.3 / cells);
  }
  MeshCase mesh;
  for (const auto& [first, last] : { std::make_pair(0, 1), std::make_pair(1, 2), std::make_pair(2, layers + 2) })
  {
    append(mesh,
      meshcases::polycubeBody(
        { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, cells, { radii.begin() + first, radii.begin() + last + 1 }));
  }
  mesh.apply([](const Vec3& x) { return Vec3(bodycases::starRadius(x.normalized()) * x); });
  return mesh;
}

std::shared_ptr<BodySurface> starBody()
{
  static const auto body = std::make_shared<BodySurface>(bodycases::starPatches(Eigen::Matrix3d::Identity()));
  return body;
}

FitCase star(int cells, int layers, bool withBody)
{
  FitCase result(withBody ? "star on its body" : "star", starStacks(cells, layers), withBody ? starBody() : nullptr);
  for (int b = 0; b < static_cast<int>(result.mesh->blocks.size()) / 3; ++b)
  {
    result.addWall(b, 4);
  }
  result.mesh->blocks[3].isFloat = true;
  return result;
}

/// Height of a roof with its ridge at y = 0.
double roof(double y)
{
  return (y > 0.0 ? -0.3 : 0.4) * y;
}

/// Blocks of one and of three cells above each other around the z axis, near the roof; its ridge is tagged as crease.
FitCase creased(bool edgesOnly)
{
  const int cells = 3;
  std::vector<BodyPatch> patches;
  for (const double side : { 1.0, -1.0 })
  {
    BodyPatch patch{ side > 0.0 ? "left" : "right", bodycases::rectangle(6.0, 3.0), {}, side < 0.0 };
    for (Vec3& x : patch.surface.points)
    {
      x = Vec3(x[0] - 3.0, side * x[1], roof(side * x[1]));
    }
    patches.push_back(patch);
  }
  FitCase result(edgesOnly ? "creases along the body" : "creases",
    meshcases::ring(6, cells, { { 0.0, 0.3 }, { 0.3, 0.6, 0.9, 1.2 } }), std::make_shared<BodySurface>(patches));
  result.fit.edgesOnly = edgesOnly;
  for (int b = 0; b < static_cast<int>(result.mesh->blocks.size()); ++b)
  {
    const auto& block = result.mesh->blocks[b];
    if (block.at({ 0, 0, 0 })[2] != 0.0)
    {
      continue;
    }
    result.addWall(b, 4);
    for (int d = 0; d < 2; ++d)
    {
      Ijk end{ 0, 0, 0 };
      end[d] = cells;
      if (std::abs(block.at(end)[1]) < 1e-9)
      {
        result.mesh->creases.push_back({ b, { 0, 0, 0 }, end });
      }
    }
  }
  result.mesh->apply(
    [](const Vec3& x) { return Vec3(x[0], x[1], x[2] + roof(x[1]) + 0.01 * std::sin(3.0 * x[0] + x[1])); });
  return result;
}

/// A low block on the wall, cut by the two above it.
FitCase cut()
{
  FitCase result("cut blocks",
    meshcases::latticeBlocks(
      { { { 0, 0, 0 }, { 6, 4, 2 } }, { { 0, 0, 2 }, { 2, 4, 6 } }, { { 2, 0, 2 }, { 6, 4, 6 } } },
      [](const Vec3& x) { return Vec3(x[0], x[1], x[2] + 0.3 * std::sin(x[0] + 0.5 * x[1])); }));
  result.mesh->blocks[0].isFloat = true;
  return result.addWall(0, 4);
}

/// Eight blocks around a point, one of them on the wall: the others share a face, an edge or a vertex with it.
FitCase corner()
{
  FitCase result("wall of one block of eight",
    meshcases::cutBox(
      { 6, 6, 6 }, { { { 3 }, { 3 }, { 3 } } }, [](const Vec3& x) { return meshcases::wavy(0.5 * x); }));
  for (int b = 0; b < 8; ++b)
  {
    if (result.mesh->blocks[b].at({ 0, 0, 0 }) == meshcases::wavy(Vec3::Zero()))
    {
      result.addWall(b, 4);
    }
  }
  return result;
}

/// One block that meets itself, its inner side the wall.
FitCase ringBlock()
{
  return FitCase("block that meets itself", meshcases::oGrid({ 12, 5, 4 })).addWall(0, 2);
}

/// In the middle of a ball lines from all sides are as long.
FitCase ball()
{
  FitCase result("ball", meshcases::ball(4, 3));
  for (int b = 1; b < static_cast<int>(result.mesh->blocks.size()); ++b)
  {
    result.addWall(b, 5);
  }
  return result;
}

std::vector<FitCase> cases()
{
  std::vector<FitCase> all{ star(3, 3, false), star(2, 2, true), creased(false), creased(true), cut(), corner(),
    ringBlock(), ball() };
  all.push_back(star(3, 3, false));
  all.back().name = "shuffled star";
  meshcases::shuffle(*all.back().mesh, 7, true);
  for (FitCase test : { star(5, 1, true), creased(false) })
  {
    test.name += ", least squares";
    test.fit.leastSquares = true;
    all.push_back(std::move(test));
  }
  return all;
}

/// Mesh points whose bits differ.
Index different(const GridView& a, const GridView& b)
{
  Index count = 0;
  for (int k = 0; k < a.counts()[2]; ++k)
  {
    for (int j = 0; j < a.counts()[1]; ++j)
    {
      for (int i = 0; i < a.counts()[0]; ++i)
      {
        const Vec3 x = a(i, j, k), y = b(i, j, k);
        count += std::memcmp(x.data(), y.data(), 3 * sizeof(double)) != 0;
      }
    }
  }
  return count;
}

} // namespace

TEST(DistributedBodyFit, SameBitsForAnyDistribution)
{
  std::mt19937 random(1);
  for (const FitCase& test : cases())
  {
    const BlockMesh mesh = test.mesh->mesh();
    BlockComplex serial = buildBlockComplex(mesh);
    WallDistances distances;
    if (test.body)
    {
      distances = wallDistances(serial, test.conversion, *test.body);
    }
    const BodyFitReport expected = fitBody(serial, test.conversion, test.fit);
    EXPECT_GT(expected.displacement, 1e-3) << test.name;
    // Every rank iterates on the whole wall, which takes its time.
    for (int n = test.fit.leastSquares ? 8 : 0; n < 10; ++n)
    {
      const int size = 1 + n % 5;
      const std::vector<int> rankOf = randomRanks(mesh.blocks.size(), size, random);
      const auto errors = onRanks(size, [&](const Execution& run) {
        const int rank = run.ranks->rank();
        const BlockMesh part = distributed(mesh, rankOf, rank);
        BlockComplex complex = buildBlockComplex(part, {}, run);
        const std::string where = test.name + ", rank " + std::to_string(rank) + " of " + std::to_string(size);
        if (test.body)
        {
          const WallDistances found = wallDistances(complex, test.conversion, *test.body, run);
          EXPECT_EQ(found.wallPoints, distances.wallPoints) << where;
          EXPECT_EQ(found.inputPoints, distances.inputPoints) << where;
          EXPECT_EQ(found.limitPoints, distances.limitPoints) << where;
        }
        const BodyFitReport report = fitBody(complex, test.conversion, test.fit, run);
        EXPECT_EQ(report.wallPoints, expected.wallPoints) << where;
        EXPECT_EQ(report.iterations, expected.iterations) << where;
        EXPECT_EQ(report.initialResidual, expected.initialResidual) << where;
        EXPECT_EQ(report.residual, expected.residual) << where;
        EXPECT_EQ(report.displacement, expected.displacement) << where;
        EXPECT_EQ(report.sampleRms, expected.sampleRms) << where;
        for (std::size_t b = 0; b < complex.blocks.size(); ++b)
        {
          const ComplexBlock& block = complex.blocks[b];
          ASSERT_EQ(block.points.isHere(), block.rank == rank) << where;
          if (block.points.isHere())
          {
            EXPECT_EQ(different(block.points, serial.blocks[b].points), 0) << where << ", block " << b;
          }
        }
      });
      EXPECT_EQ(errors, std::vector<std::string>(size)) << test.name;
    }
  }
}

// The wall is fitted in the lowest blocks; points of those above them move only if lines go on across ranks.
TEST(DistributedBodyFit, DisplacementsCrossBlocks)
{
  const FitCase test = star(3, 3, false);
  const BlockComplex whole = buildBlockComplex(test.mesh->mesh());
  BlockComplex moved = whole;
  fitBody(moved, test.conversion, test.fit);
  for (std::size_t b = 0; b < whole.blocks.size(); ++b)
  {
    EXPECT_GT(different(moved.blocks[b].points, whole.blocks[b].points), 0) << b;
  }
}

TEST(DistributedBodyFit, ErrorsAreThoseOfOneRankEverywhere)
{
  FitCase limited = star(2, 1, false);
  limited.fit.iterations = 2;
  FitCase nowhere = star(2, 1, true);
  for (auto& block : nowhere.mesh->blocks)
  {
    for (Vec3& x : block.points)
    {
      x = 1000.0 * x;
    }
  }
  FitCase invalid = star(2, 1, false);
  invalid.fit.edgesOnly = true;
  std::mt19937 random(1);
  for (const FitCase* test : { &limited, &nowhere, &invalid })
  {
    const BlockMesh mesh = test->mesh->mesh();
    const std::vector<int> rankOf = randomRanks(mesh.blocks.size(), 3, random);
    const auto attempt = [&](BlockComplex& complex, const Execution& run) {
      if (test->body)
      {
        wallDistances(complex, test->conversion, *test->body, run);
      }
      fitBody(complex, test->conversion, test->fit, run);
    };
    std::string text;
    try
    {
      BlockComplex complex = buildBlockComplex(mesh);
      attempt(complex, {});
    }
    catch (const Error& error)
    {
      text = error.what();
    }
    EXPECT_FALSE(text.empty());
    const auto errors = onRanks(3, [&](const Execution& run) {
      const BlockMesh part = distributed(mesh, rankOf, run.ranks->rank());
      BlockComplex complex = buildBlockComplex(part, {}, run);
      attempt(complex, run);
    });
    EXPECT_EQ(errors, std::vector<std::string>(3, text));
  }
}

TEST(DistributedBodyFit, AbortOfOneEndsAll)
{
  const FitCase test = star(2, 1, false);
  const BlockMesh mesh = test.mesh->mesh();
  std::mt19937 random(1);
  const std::vector<int> rankOf = randomRanks(mesh.blocks.size(), 3, random);
  const auto errors = onRanks(3, [&](Execution run) {
    const BlockMesh part = distributed(mesh, rankOf, run.ranks->rank());
    BlockComplex complex = buildBlockComplex(part, {}, run);
    run.progress = [&](double) { return run.ranks->rank() != 1; };
    EXPECT_THROW(run.ranks->together([&] { fitBody(complex, test.conversion, test.fit, run); }), Aborted);
  });
  EXPECT_EQ(errors, std::vector<std::string>(3));
}

// Twice as many cells in each direction: four times as many of the wall, eight times as many in all.
TEST(DistributedBodyFit, TrafficGrowsWithTheWall)
{
  std::array<Index, 2> received{ 0, 0 }, points{ 0, 0 }, wallPoints{ 0, 0 };
  for (int n = 0; n < 2; ++n)
  {
    const FitCase test = star(6 << n, (14 << n) - 2, false);
    const BlockMesh mesh = test.mesh->mesh();
    for (const MeshBlock& block : mesh.blocks)
    {
      points[n] += block.points.size();
    }
    const int size = 3;
    std::array<Index, 3> perRank{};
    std::mt19937 random(1);
    const std::vector<int> rankOf = randomRanks(mesh.blocks.size(), size, random);
    const auto errors = onRanks(size, [&](const Execution& run) {
      const BlockMesh part = distributed(mesh, rankOf, run.ranks->rank());
      BlockComplex complex = buildBlockComplex(part, {}, run);
      const Index before = run.ranks->receivedBytes();
      const BodyFitReport report = fitBody(complex, test.conversion, test.fit, run);
      perRank[run.ranks->rank()] = run.ranks->receivedBytes() - before;
      if (run.ranks->rank() == 0)
      {
        wallPoints[n] = report.wallPoints;
      }
    });
    EXPECT_EQ(errors, std::vector<std::string>(size));
    for (const Index bytes : perRank)
    {
      received[n] = std::max(received[n], bytes);
    }
  }
  std::printf("most bytes received by a rank: %lld for %lld points, %lld of them of the wall; %lld for %lld, %lld\n",
    static_cast<long long>(received[0]), static_cast<long long>(points[0]), static_cast<long long>(wallPoints[0]),
    static_cast<long long>(received[1]), static_cast<long long>(points[1]), static_cast<long long>(wallPoints[1]));
  EXPECT_LE(received[1], 4 * received[0]);
}
