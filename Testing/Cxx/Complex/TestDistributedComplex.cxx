// SPDX-License-Identifier: BSD-3-Clause
/// The block complex of meshes that several ranks share: the one that a process alone makes, for few points of others.
/// TestBlockComplex builds all its meshes on several ranks too.
#include "Support/DistributedComplex.h"
#include "Support/MeshCases.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

using namespace bsv;
using namespace meshcases;

namespace
{

using Random = std::mt19937;

int pick(int first, int last, Random& random)
{
  return std::uniform_int_distribution<int>(first, last)(random);
}

/// Boxes that fill a box of the lattice and meet in parts of their faces.
std::vector<std::pair<Ijk, Ijk>> randomBoxes(Random& random)
{
  std::vector<std::pair<Ijk, Ijk>> boxes{ { { 0, 0, 0 },
    { pick(2, 6, random), pick(2, 6, random), pick(2, 6, random) } } };
  for (int n = pick(1, 8, random); n > 0; --n)
  {
    const std::size_t box = pick(0, static_cast<int>(boxes.size()) - 1, random);
    const int d = pick(0, 2, random);
    if (boxes[box].second[d] - boxes[box].first[d] > 1)
    {
      boxes.push_back(boxes[box]);
      boxes[box].second[d] = boxes.back().first[d] = pick(boxes[box].first[d] + 1, boxes[box].second[d] - 1, random);
    }
  }
  return boxes;
}

MeshCase randomMesh(Random& random)
{
  MeshCase mesh;
  switch (pick(0, 5, random))
  {
    case 0:
      mesh = ring(pick(3, 6, random), 2, { { 0.0, 1.0, 2.0 }, { 2.0, 2.5 } });
      break;
    case 1:
      mesh = pick(0, 1, random) ? cGrid(3, pick(0, 2, random) * 2, 2, 2) : closedShell({ 6, 5, 2 });
      break;
    default: {
      auto boxes = randomBoxes(random);
      // Sometimes with holes.
      boxes.resize(boxes.size() - (boxes.size() > 2 ? pick(0, 1, random) : 0));
      mesh = latticeBlocks(boxes, pick(0, 1, random) ? Map(wavy) : Map());
    }
  }
  if (pick(0, 2, random) == 0)
  {
    declareAll(mesh, static_cast<unsigned>(random()));
    // What is no longer declared must be found.
    std::shuffle(mesh.interfaces.begin(), mesh.interfaces.end(), random);
    mesh.interfaces.resize(pick(0, static_cast<int>(mesh.interfaces.size()), random));
    std::shuffle(mesh.boundaries.begin(), mesh.boundaries.end(), random);
    mesh.boundaries.resize(pick(0, static_cast<int>(mesh.boundaries.size()), random));
  }
  const double jitter = std::array<double, 4>{ 0.0, 0.0, 1e-15, 1e-3 }[pick(0, 3, random)];
  for (MeshCase::Block& block : mesh.blocks)
  {
    block.isFloat = pick(0, 7, random) == 0;
    for (Vec3& x : block.points)
    {
      for (int d = 0; d < 3; ++d)
      {
        x[d] += jitter * std::uniform_real_distribution<double>(-1.0, 1.0)(random);
      }
    }
    if (pick(0, 5, random) == 0)
    {
      block.creaseSharpness.assign(block.points.size(), 0.0);
      std::fill_n(block.creaseSharpness.begin(), block.counts[0], SharpnessInfinite);
    }
  }
  if (pick(0, 3, random) == 0)
  {
    const int b = pick(0, static_cast<int>(mesh.blocks.size()) - 1, random);
    mesh.creases.push_back({ b, { 0, 0, 0 }, { 0, pick(1, mesh.blocks[b].cells()[1], random), 0 } });
  }
  shuffle(mesh, static_cast<unsigned>(random()), true);
  return mesh;
}

/// Something that is refused, most of the time.
void spoil(MeshCase& mesh, Random& random)
{
  MeshCase::Block& block = mesh.blocks[pick(0, static_cast<int>(mesh.blocks.size()) - 1, random)];
  Vec3& x = block.points[pick(0, static_cast<int>(block.points.size()) - 1, random)];
  switch (pick(0, 4, random))
  {
    case 0:
      x[1] = std::numeric_limits<double>::quiet_NaN();
      break;
    case 1:
      x = block.points[pick(0, static_cast<int>(block.points.size()) - 1, random)];
      break;
    case 2:
      for (Vec3& point : block.points)
      {
        point += Vec3(0.5, 0.25, 0.0);
      }
      break;
    case 3:
      mesh.blocks.push_back(block);
      break;
    default:
      x += Vec3(0.2, 0.1, 0.0);
  }
}

TEST(DistributedComplex, IsTheOneMadeAlone)
{
  for (unsigned seed = 0; seed < 300 && !HasFailure(); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    MeshCase mesh = randomMesh(random);
    BlockComplexOptions options;
    options.creaseAngle = pick(0, 1, random) ? 180.0 : 60.0;
    options.allowDegenerate = pick(0, 4, random) == 0;
    const int size = pick(1, 5, random);
    bsvtest::expectSameOnRanks(mesh.mesh(), options, bsvtest::randomRanks(mesh.blocks.size(), size, random), size);
  }
}

TEST(DistributedComplex, RefusesWhatIsRefusedAlone)
{
  for (unsigned seed = 0; seed < 300 && !HasFailure(); ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    MeshCase mesh = randomMesh(random);
    spoil(mesh, random);
    const int size = pick(1, 5, random);
    bsvtest::expectSameOnRanks(mesh.mesh(), {}, bsvtest::randomRanks(mesh.blocks.size(), size, random), size);
  }
}

/// Corners of A, B and C are a row of near points, of which B's is one with A's. It is not one with C's, because D,
/// which is too far from A to be known on its rank, has a copy of that and is fine.
TEST(DistributedComplex, KnowsWhatIsNotNearAPointOfAnotherRank)
{
  MeshCase mesh;
  const auto cube = [&](const Vec3& corner, const Vec3& size) {
    mesh.add({ 1, 1, 1 }, [&](const Ijk& p) -> Vec3 { return corner + size.cwiseProduct(Vec3(p[0], p[1], p[2])); });
  };
  cube({ 0.0, 0.0, 0.0 }, { 1.0, 0.97, 1.0 });
  cube({ 1.0, 1.0, 1.0 }, { 1.0, 1.0, 1.0 });
  cube({ 0.0, 1.04, 0.0 }, { 1.0, 1.0, 1.0 });
  cube({ 1.0, 1.04, 1.0 }, { 0.2, 0.2, 0.2 });
  // A and B have a corner in common, C and D another one.
  EXPECT_NO_THROW(buildBlockComplex(mesh.mesh()));
  for (int ranks = 0; ranks < 16; ++ranks)
  {
    bsvtest::expectSameOnRanks(mesh.mesh(), {}, { ranks & 1, ranks >> 1 & 1, ranks >> 2 & 1, ranks >> 3 }, 2);
  }
}

TEST(DistributedComplex, LeavesRanksWithoutBlocks)
{
  MeshCase mesh = ball(2, 2);
  bsvtest::expectSameOnRanks(mesh.mesh(), {}, std::vector<int>(mesh.blocks.size(), 2), 4);
  std::vector<int> each(mesh.blocks.size());
  std::iota(each.begin(), each.end(), 0);
  bsvtest::expectSameOnRanks(mesh.mesh(), {}, each, static_cast<int>(each.size()) + 3);
  MeshCase none;
  bsvtest::expectSameOnRanks(none.mesh(), {}, {}, 3);
}

TEST(DistributedComplex, RefusesBlocksOnNoRank)
{
  MeshCase mesh = cutBox({ 2, 2, 2 }, { { { 1 }, {}, {} } });
  const BlockMesh view = mesh.mesh();
  for (const std::vector<int>& rankOf : { std::vector<int>{ 0, 2 }, std::vector<int>{ -1, 0 } })
  {
    for (const std::string& error : bsvtest::onRanks(2, [&](const Execution& run) {
           buildBlockComplex(bsvtest::distributed(view, rankOf, run.ranks->rank()), {}, run);
         }))
    {
      EXPECT_NE(error.find("where its points are not"), std::string::npos) << error;
    }
  }
}

TEST(DistributedComplex, StopsOnAllRanks)
{
  MeshCase mesh = cutBox({ 4, 4, 4 }, { { { 2 }, {}, {} } });
  const BlockMesh view = mesh.mesh();
  bool stopped = true;
  for (int stop = 0; stopped; ++stop)
  {
    const std::vector<std::string> errors = bsvtest::onRanks(3, [&](Execution run) {
      int calls = 0;
      const bool stops = run.ranks->rank() == 1;
      run.progress = [&](double) { return !stops || calls++ < stop; };
      buildBlockComplex(bsvtest::distributed(view, { 2, 1 }, run.ranks->rank()), {}, run);
    });
    EXPECT_EQ(errors, std::vector<std::string>(3, errors[0]));
    stopped = !errors[0].empty();
    EXPECT_TRUE(!stopped || errors[0] == Aborted().what());
    EXPECT_LT(stop, 100);
  }
}

/// Bytes that a rank receives for two blocks of n x n x n / 2 cells, side by side, on one rank each.
Index traffic(int n, double jitter)
{
  MeshCase mesh = cutBox({ n, n, n }, { { {}, {}, { n / 2 } } });
  mesh.blocks[1].at({ n / 2, n / 2, 0 })[0] += jitter;
  const BlockMesh view = mesh.mesh();
  std::array<Index, 2> received{};
  bsvtest::onRanks(2, [&](const Execution& run) {
    const int rank = run.ranks->rank();
    EXPECT_EQ(buildBlockComplex(bsvtest::distributed(view, { 0, 1 }, rank), {}, run).vertices.size(), 12u);
    received[rank] = run.ranks->receivedBytes();
  });
  return std::max(received[0], received[1]);
}

TEST(DistributedComplex, FetchesOnlyLayersOfPoints)
{
  // Corners, boxes, counts and verdicts.
  constexpr Index Fixed = 4096;
  for (int n : { 8, 16, 32, 64 })
  {
    const Index point = 24;
    const Index layer = point * (n + 1) * (n + 1);
    // On the four sides: the quadrilaterals at the contact and the points next to them, in two layers.
    const Index sides = 4 * 3 * 2 * point * (n + 1);
    // One layer is compared.
    EXPECT_LT(traffic(n, 0.0), layer + sides + Fixed);
    // If a bit differs: two layers to find near points, one to compare, and the number and place of each shared point.
    EXPECT_LT(traffic(n, 1e-9), 3 * layer + (layer + layer / 3) * 2 + sides + Fixed);
  }
}

} // namespace
