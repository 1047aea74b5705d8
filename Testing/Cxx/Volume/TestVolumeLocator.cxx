// SPDX-License-Identifier: BSD-3-Clause
// The inverse of evaluation: every point of a volume is found, also of folded and rational ones; points outside are
// not.
#include "Support/VolumeCases.h"
#include "Volume/VolumeLocator.h"

#include <gtest/gtest.h>

using namespace bsv;
using namespace bsvtest;

namespace
{

Vec3 randomParameters(std::mt19937& random, const BSplineVolume& volume)
{
  Vec3 uvw;
  for (int d = 0; d < 3; ++d)
  {
    const std::vector<double>& knots = volume.knots[d];
    uvw[d] = std::uniform_real_distribution<double>(knots[volume.degree[d]], knots[volume.count(d)])(random);
  }
  return uvw;
}

void expectFound(const std::vector<BSplineVolume>& volumes, int count)
{
  std::mt19937 random(11);
  const VolumeLocator locator(volumes);
  const double tolerance = 1e-12 * locator.bounds().diagonal().norm();
  for (int block = 0; block < static_cast<int>(volumes.size()); ++block)
  {
    for (int n = 0; n < count; ++n)
    {
      const Vec3 x = evaluate(volumes[block], randomParameters(random, volumes[block]));
      const VolumePlace place = locator.locate(x, tolerance);
      ASSERT_GE(place.block, 0) << "block " << block << ", point " << x.transpose();
      EXPECT_LE(place.block, block);
      EXPECT_LE((evaluate(volumes[place.block], place.uvw) - x).norm(), tolerance);
    }
  }
}

} // namespace

// Random control points fold the volume over and over: Newton's method alone does not find its way there.
TEST(VolumeLocator, FindsAllPointsOfFoldedVolumes)
{
  std::mt19937 random(3);
  const std::vector<double> quadratic{ 0, 0, 0, 1, 1, 2.25, 3, 3, 3 };
  const std::vector<double> uniform{ -3, -2, -1, 0, 1, 2, 3, 4, 5, 6, 7 };
  const std::vector<Block> blocks{ randomBlock(random, { 3, 3, 3 },
                                     { clampedIntegerKnots(5), clampedIntegerKnots(6), clampedIntegerKnots(3) }, false),
    randomBlock(random, { 2, 3, 3 }, { quadratic, uniform, clampedIntegerKnots(2) }, false) };
  std::vector<BSplineVolume> views;
  for (const Block& block : blocks)
  {
    views.push_back(block.view());
  }
  expectFound(views, 60);
}

// A quarter of a thick pipe, exact with weights: in it parameters follow from the radius, the angle and the height.
TEST(VolumeLocator, PipeAgreesWithItsFormula)
{
  Block pipe;
  pipe.volume.degree = { 1, 2, 1 };
  pipe.volume.knots = { std::vector<double>{ 0, 0, 1, 1 }, { 0, 0, 0, 1, 1, 1 }, { 0, 0, 5, 5 } };
  for (const double z : { 0.0, 5.0 })
  {
    const double corner[3][2] = { { 1, 0 }, { 1, 1 }, { 0, 1 } };
    for (int b = 0; b < 3; ++b)
    {
      for (const double radius : { 1.0, 1.001 })
      {
        pipe.points.insert(pipe.points.end(), { radius * corner[b][0], radius * corner[b][1], z });
        pipe.weights.push_back(b == 1 ? std::sqrt(0.5) : 1.0);
      }
    }
  }
  const std::vector<BSplineVolume> views{ pipe.view() };
  const VolumeLocator locator(views);
  std::mt19937 random(5);
  for (int n = 0; n < 200; ++n)
  {
    const double u = std::uniform_real_distribution<double>(0.0, 1.0)(random);
    const double angle = std::uniform_real_distribution<double>(0.0, std::acos(0.0))(random);
    const double w = std::uniform_real_distribution<double>(0.0, 5.0)(random);
    const double radius = 1.0 + 0.001 * u;
    const Vec3 x(radius * std::cos(angle), radius * std::sin(angle), w);
    const VolumePlace place = locator.locate(x, 1e-12);
    ASSERT_EQ(place.block, 0);
    // One part in 1000 of the radius: u loses three digits.
    EXPECT_NEAR(place.uvw[0], u, 1e-11);
    EXPECT_NEAR(place.uvw[2], w, 1e-13);
    EXPECT_EQ(locator.locate(Vec3((1.0 - 1e-6) * std::cos(angle), (1.0 - 1e-6) * std::sin(angle), w), 1e-12).block, -1);
    EXPECT_EQ(locator.locate(Vec3(1.001001 * std::cos(angle), 1.001001 * std::sin(angle), w), 1e-12).block, -1);
  }
}

TEST(VolumeLocator, SharedPointsBelongToTheLowestBlockThatIsHere)
{
  // Two cubes that meet at x = 1.
  std::vector<Block> cubes(2);
  for (int n = 0; n < 2; ++n)
  {
    cubes[n].volume.degree = { 1, 1, 1 };
    cubes[n].volume.knots = { std::vector<double>{ 0, 0, 1, 1 }, { 0, 0, 1, 1 }, { 0, 0, 1, 1 } };
    for (int corner = 0; corner < 8; ++corner)
    {
      cubes[n].points.insert(
        cubes[n].points.end(), { double(n + (corner & 1)), double(corner >> 1 & 1), double(corner >> 2) });
    }
  }
  std::vector<BSplineVolume> views{ cubes[0].view(), cubes[1].view() };
  const Vec3 shared(1.0, 0.25, 0.5);
  const VolumeLocator both(views);
  EXPECT_EQ(both.locate(shared, 1e-12).block, 0);
  EXPECT_EQ(both.locate(shared, 1e-12).uvw, Vec3(1.0, 0.25, 0.5));
  EXPECT_EQ(both.locate(Vec3(0.5, 0.5, std::nan("")), 1e-12).block, -1);
  views[0].points = nullptr;
  const VolumeLocator second(views);
  EXPECT_EQ(second.locate(shared, 1e-12).block, 1);
  EXPECT_EQ(second.locate(Vec3(0.5, 0.5, 0.5), 1e-12).block, -1);
  const std::vector<BSplineVolume> none;
  EXPECT_EQ(VolumeLocator(none).locate(shared, 1.0).block, -1);
}

// A point near a corner of what is within reach along the axes may be out of reach: then parts are excluded by their
// distance. By their boxes along the axes none was, and each point took millions of parts.
TEST(VolumeLocator, PointsAreFoundWithinALargeToleranceAndNotBeyond)
{
  Block box;
  box.volume.degree = { 1, 1, 1 };
  for (std::vector<double>& knots : box.volume.knots)
  {
    knots = { 0, 0, 1, 1 };
  }
  for (int n = 0; n < 8; ++n)
  {
    box.points.insert(box.points.end(), { double(n & 1), double(n >> 1 & 1), double(n >> 2) });
  }
  const std::vector<BSplineVolume> views{ box.view() };
  const VolumeLocator locator(views);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-3.0, 4.0);
  int found = 0;
  for (int n = 0; n < 200; ++n)
  {
    const Vec3 x(place(random), place(random), place(random));
    const double distance = (x - x.cwiseMax(0.0).cwiseMin(1.0)).norm();
    const bool within = locator.locate(x, 2.0).block == 0;
    EXPECT_EQ(within, distance <= 2.0) << x.transpose() << ", at " << distance;
    found += within ? 1 : 0;
  }
  EXPECT_GT(found, 20);
  EXPECT_LT(found, 180);
}
