// SPDX-License-Identifier: BSD-3-Clause
#include "Base/SparseArray.h"
#include "Support/MeshCases.h"
#include "Wall/BodyFit.h"

#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <random>

using namespace bsv;

namespace
{

const std::array<int, 3> Counts{ 37, 5, 4 };

template <typename Real>
std::vector<Real> randomPoints(unsigned seed)
{
  std::mt19937 random(seed);
  std::vector<Real> values(3 * Counts[0] * Counts[1] * Counts[2]);
  for (Real& value : values)
  {
    value = static_cast<Real>(random()) / 1000;
  }
  return values;
}

/// A plate of n^3 cells with a wavy wall.
meshcases::MeshCase plate(int n, int face)
{
  meshcases::MeshCase mesh = meshcases::cutBox({ n, n, n });
  mesh.apply([&](const Vec3& x) {
    Vec3 y = x;
    y[faceDirection(face)] += std::sin(x[faceAxis(face, 0)] + 0.5 * x[faceAxis(face, 1)]);
    return y;
  });
  mesh.boundaryNames = { "wall" };
  mesh.boundaries.push_back({ 0, face, { { 0, 0 }, { n, n } }, 0 });
  return mesh;
}

ConversionOptions wallOptions()
{
  ConversionOptions options;
  options.roles = { BoundaryRole::Body };
  return options;
}

} // namespace

TEST(ChangedPoints, ViewsShowThemInPlaceOfTheStoredOnes)
{
  const std::vector<double> doubles = randomPoints<double>(1);
  const std::vector<float> floats = randomPoints<float>(2);
  for (const GridView& stored : { GridView(doubles.data(), Counts), GridView(floats.data(), Counts) })
  {
    const auto before = [&](Index i) { return stored.atPlace(i); };
    ChangedPoints changes(stored.size());
    std::map<Index, Vec3> expected;
    std::mt19937 random(3);
    for (int n = 0; n < 60; ++n)
    {
      const Index at = random() % stored.size();
      expected[at] = changes[changes.add(at, before)] = Vec3(n, 2 * n, 3 * n);
    }
    const GridView whole = stored.changed(&changes);
    const std::array<int, 3> first{ 2, 1, 1 }, last{ 35, 3, 3 };
    for (const auto& [view, origin] :
      { std::make_pair(whole, std::array<int, 3>{ 0, 0, 0 }), std::make_pair(whole.box(first, last), first) })
    {
      for (int k = 0; k < view.counts()[2]; ++k)
      {
        for (int j = 0; j < view.counts()[1]; ++j)
        {
          std::vector<double> row;
          view.forRuns(0, view.counts()[0] - 1, j, k,
            [&](const auto* from, Index count) { row.insert(row.end(), from, from + count); });
          ASSERT_EQ(row.size(), 3u * view.counts()[0]);
          for (int i = 0; i < view.counts()[0]; ++i)
          {
            const Index at = stored.place({ i + origin[0], j + origin[1], k + origin[2] });
            const auto found = expected.find(at);
            const Vec3 x = found == expected.end() ? stored.atPlace(at) : found->second;
            EXPECT_EQ(view(i, j, k), x);
            EXPECT_EQ(Vec3(row[3 * i], row[3 * i + 1], row[3 * i + 2]), x);
          }
        }
      }
    }
  }
}

// Points of a complex that was fitted already are moved on from where they are.
TEST(ChangedPoints, FittingAgainIsFittingTheMovedPoints)
{
  for (const double range : { 2.0, 0.0 })
  {
    meshcases::MeshCase mesh = plate(6, 4);
    BlockComplex twice = buildBlockComplex(mesh.mesh());
    fitBody(twice, wallOptions(), {});
    const GridView moved = twice.blocks[0].points;
    meshcases::MeshCase copy = mesh;
    for (int k = 0; k <= 6; ++k)
    {
      for (int j = 0; j <= 6; ++j)
      {
        for (int i = 0; i <= 6; ++i)
        {
          copy.blocks[0].at({ i, j, k }) = moved(i, j, k);
        }
      }
    }
    BlockComplex once = buildBlockComplex(copy.mesh());
    BodyFitOptions fit;
    fit.range = range;
    fitBody(twice, wallOptions(), fit);
    fitBody(once, wallOptions(), fit);
    for (Index i = 0; i < moved.size(); ++i)
    {
      EXPECT_EQ(twice.blocks[0].points.atPlace(i), once.blocks[0].points.atPlace(i)) << i;
    }
  }
}

// Whichever way the layers lie in memory.
TEST(ChangedPoints, AreAboutThoseThatMove)
{
  for (int face = 0; face < 6; ++face)
  {
    meshcases::MeshCase mesh = plate(40, face);
    const BlockComplex before = buildBlockComplex(mesh.mesh());
    BlockComplex after = before;
    BodyFitOptions fit;
    fit.range = 3.0;
    fitBody(after, wallOptions(), fit);
    Index moved = 0;
    for (Index i = 0; i < before.blocks[0].points.size(); ++i)
    {
      moved += after.blocks[0].points.atPlace(i) != before.blocks[0].points.atPlace(i) ? 1 : 0;
    }
    EXPECT_GE(moved, 2 * 41 * 41) << "face " << face;
    // Each run of moved points touches a page more than it fills.
    ASSERT_EQ(after.changedPoints.size(), 1u);
    const Index runs = faceDirection(face) == 0 ? 41 * 41 : 41;
    EXPECT_LE(after.changedPoints[0]->slots(), moved + 2 * runs * ChangedPoints::PageSize) << "face " << face;
  }
}
