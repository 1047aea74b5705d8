// SPDX-License-Identifier: BSD-3-Clause
// Samples of B-spline blocks: against evaluate(), watertight, nested, independent of orientation and threads.
#include "Support/VolumeCases.h"
#include "Volume/Sampling.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

using namespace bsv;
using namespace bsvtest;

namespace
{

struct Samples
{
  Ijk counts;
  std::vector<double> values;

  const double* at(const Ijk& i) const
  {
    return values.data() + 3 * (i[0] + Index(counts[0]) * (i[1] + Index(counts[1]) * i[2]));
  }
};

Samples samplesOf(
  const Block& block, int level, const std::array<int, 3>& derivative = { 0, 0, 0 }, const Execution& run = {})
{
  checkBSplineVolume(block.view(), "block");
  Samples samples{ sampleCounts(block.view(), level, "block"), {} };
  const Ijk n = samples.counts;
  samples.values.assign(static_cast<std::size_t>(3) * n[0] * n[1] * n[2], std::numeric_limits<double>::quiet_NaN());
  sample(block.view(), level, derivative, samples.values.data(), run);
  return samples;
}

bool sameBits(const double* a, const double* b)
{
  return std::memcmp(a, b, 3 * sizeof(double)) == 0;
}

const std::array<std::array<int, 3>, 4> Derivatives{ { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } } };

/// Degrees 1 to 5, repeated inner knots, one direction that is not clamped. All knot differences are exact in binary,
/// so that the reversed knots have the same ones.
std::vector<Block> mixedBlocks(std::mt19937& random)
{
  const std::vector<double> linear{ 0, 0, 0.5, 2, 2 };
  const std::vector<double> quadratic{ 0, 0, 0, 1, 1, 2.25, 3, 3, 3 };
  const std::vector<double> quintic{ 0, 0, 0, 0, 0, 0, 1, 2, 2, 2, 4, 4, 4, 4, 4, 4 };
  const std::vector<double> uniform{ -3, -2, -1, 0, 1, 2, 3, 4, 5, 6, 7 };
  return { randomBlock(random, { 1, 2, 5 }, { linear, quadratic, quintic }),
    randomBlock(random, { 3, 1, 3 }, { uniform, linear, clampedIntegerKnots(2) }),
    randomBlock(random, { 3, 3, 3 }, { clampedIntegerKnots(5), clampedIntegerKnots(5), clampedIntegerKnots(5) }),
    randomBlock(random, { 3, 3, 3 }, { clampedIntegerKnots(1), clampedIntegerKnots(1), clampedIntegerKnots(1) }) };
}

} // namespace

TEST(Sampling, EqualsEvaluation)
{
  std::mt19937 random(1);
  std::vector<Block> blocks = mixedBlocks(random);
  for (Block& block : blocks)
  {
    for (double& x : block.points)
    {
      x = std::uniform_real_distribution<double>(-1.0, 1.0)(random);
    }
  }
  const std::size_t polynomial = blocks.size();
  for (std::size_t b = 0; b < polynomial; ++b)
  {
    Block rational = blocks[b];
    for (std::size_t i = 0; i < rational.points.size() / 3; ++i)
    {
      rational.weights.push_back(std::uniform_real_distribution<double>(0.5, 2.0)(random));
    }
    blocks.push_back(rational);
  }
  for (const Block& block : blocks)
  {
    const int level = 2;
    std::array<std::vector<double>, 3> u;
    for (int d = 0; d < 3; ++d)
    {
      u[d] = sampleParameters(block.view(), d, level);
    }
    for (const auto& derivative : Derivatives)
    {
      const Samples samples = samplesOf(block, level, derivative);
      forEach(samples.counts, [&](const Ijk& i) {
        const Vec3 uvw(u[0][i[0]], u[1][i[1]], u[2][i[2]]);
        Vec3 expected = evaluate(block.view(), uvw, derivative);
        for (int d = 0; d < 3; ++d)
        {
          // Where a derivative jumps the samples hold the mean of the two sides.
          const auto& knots = block.volume.knots[d];
          const auto multiplicity = std::count(knots.begin(), knots.end(), uvw[d]);
          if (derivative[d] == 1 && multiplicity >= block.volume.degree[d] && i[d] > 0 && i[d] + 1 < samples.counts[d])
          {
            Vec3 before = uvw;
            before[d] -= 1e-9;
            expected = 0.5 * (expected + evaluate(block.view(), before, derivative));
          }
        }
        for (int c = 0; c < 3; ++c)
        {
          // 1e-8: the left limit above is taken 1e-9 away.
          ASSERT_NEAR(samples.at(i)[c], expected[c], derivative == Derivatives[0] ? 1e-14 : 1e-7);
        }
      });
    }
  }
}

TEST(Sampling, DerivativesOfCubicsEqualEvaluation)
{
  std::mt19937 random(2);
  const Block block =
    randomBlock(random, { 3, 3, 3 }, { clampedIntegerKnots(3), clampedIntegerKnots(4), clampedIntegerKnots(1) }, false);
  for (const auto& derivative : Derivatives)
  {
    const Samples samples = samplesOf(block, 3, derivative);
    forEach(samples.counts, [&](const Ijk& i) {
      const Vec3 x = evaluate(block.view(), { i[0] / 8.0, i[1] / 8.0, i[2] / 8.0 }, derivative);
      for (int c = 0; c < 3; ++c)
      {
        ASSERT_NEAR(samples.at(i)[c], x[c], 2e-14);
      }
    });
  }
}

TEST(Sampling, SharedFacesAreTheSameBitsInAllOrientations)
{
  std::mt19937 random(3);
  std::array<bool, 8> seen{};
  std::array<bool, 36> pairs{};
  for (int trial = 0; trial < 60; ++trial)
  {
    const Volumes volumes =
      cutLattice(random, { { { 1, 3 }, { 2, 4 }, { 3, 1, 2 } } }, { trial % 3 == 1, trial % 3 == 2, false });
    std::vector<Samples> samples;
    for (const Block& block : volumes.blocks)
    {
      samples.push_back(samplesOf(block, 1 + trial % 2));
    }
    for (const Interface& contact : volumes.interfaces)
    {
      seen[contact.orientation] = true;
      pairs[6 * contact.faceA + contact.faceB] = true;
      const Samples& a = samples[contact.blockA];
      const Samples& b = samples[contact.blockB];
      const int ns = a.counts[faceAxis(contact.faceA, 0)] - 1;
      const int nt = a.counts[faceAxis(contact.faceA, 1)] - 1;
      for (int s = 0; s <= ns; ++s)
      {
        for (int t = 0; t <= nt; ++t)
        {
          const auto m = mapFacePoint(contact.orientation, s, t, ns, nt);
          ASSERT_TRUE(sameBits(a.at(facePosition(a.counts, contact.faceA, s, t)),
            b.at(facePosition(b.counts, contact.faceB, m[0], m[1]))));
        }
      }
    }
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), true), 8);
  EXPECT_EQ(std::count(pairs.begin(), pairs.end(), true), 36);
}

// A face collapsed to a line or to a point has the same control net in several orientations; a neighbour may be glued
// in any of them.
TEST(Sampling, CollapsedFacesAreAsSymmetricAsTheirNets)
{
  std::mt19937 random(4);
  const std::vector<double> knots = clampedIntegerKnots(4);
  for (const bool toPoint : { false, true })
  {
    Block block = randomBlock(random, { 3, 3, 3 }, { knots, knots, knots });
    forEach(block.counts(), [&](const Ijk& i) {
      if (i[2] == 0)
      {
        const double* from = block.points.data() + 3 * block.at({ toPoint ? 0 : i[0], 0, 0 });
        std::copy(from, from + 3, block.points.data() + 3 * block.at(i));
      }
    });
    const Samples samples = samplesOf(block, 2);
    const int n = samples.counts[0] - 1;
    // Reversing the second axis keeps the net of the line, every orientation that of the point.
    for (int o = 0; o < 8; ++o)
    {
      if (toPoint || o == 4)
      {
        forEach({ n + 1, n + 1, 1 }, [&](const Ijk& i) {
          const auto m = mapFacePoint(o, i[0], i[1], n, n);
          ASSERT_TRUE(sameBits(samples.at(i), samples.at({ m[0], m[1], 0 })));
        });
      }
    }
  }
}

TEST(Sampling, LevelsAreNested)
{
  std::mt19937 random(5);
  for (const Block& block : mixedBlocks(random))
  {
    for (const auto& derivative : Derivatives)
    {
      Samples coarse = samplesOf(block, 0, derivative);
      for (int level = 1; level <= 4; ++level)
      {
        const Samples fine = samplesOf(block, level, derivative);
        forEach(coarse.counts, [&](const Ijk& i) {
          ASSERT_TRUE(sameBits(coarse.at(i), fine.at({ 2 * i[0], 2 * i[1], 2 * i[2] }))) << "level " << level;
        });
        coarse = fine;
      }
    }
  }
}

TEST(Sampling, DoesNotDependOnTheBlocksOrientation)
{
  std::mt19937 random(6);
  for (const Block& block : mixedBlocks(random))
  {
    for (const auto& derivative : Derivatives)
    {
      const Samples samples = samplesOf(block, 2, derivative);
      for (const Orientation& o : allOrientations())
      {
        std::array<int, 3> rotated{};
        bool negative = false;
        for (int d = 0; d < 3; ++d)
        {
          rotated[d] = derivative[o.order[d]];
          negative = negative || (rotated[d] == 1 && o.flip[d]);
        }
        const Samples other = samplesOf(reoriented(block, o), 2, rotated);
        forEach(other.counts, [&](const Ijk& i) {
          const double* x = samples.at(o.old(i, samples.counts));
          for (int c = 0; c < 3; ++c)
          {
            ASSERT_EQ(negative ? -x[c] : x[c], other.at(i)[c]);
          }
        });
      }
    }
  }
}

TEST(Sampling, DoesNotDependOnThreads)
{
  std::mt19937 random(7);
  for (const Block& block : mixedBlocks(random))
  {
    EXPECT_EQ(samplesOf(block, 3).values, samplesOf(block, 3, { 0, 0, 0 }, scrambledExecution()).values);
  }
}

TEST(Sampling, LinearDataIsExactAtControlAndKnots)
{
  // Control points at their Greville abscissae: x(u) = u.
  Block block;
  for (auto& knots : block.volume.knots)
  {
    knots = clampedIntegerKnots(4);
  }
  forEach(block.counts(), [&](const Ijk& i) {
    for (int d = 0; d < 3; ++d)
    {
      const auto& t = block.volume.knots[d];
      block.points.push_back((t[i[d] + 1] + t[i[d] + 2] + t[i[d] + 3]) / 3.0);
    }
  });
  const Samples samples = samplesOf(block, 3);
  forEach(samples.counts, [&](const Ijk& i) {
    for (int d = 0; d < 3; ++d)
    {
      ASSERT_NEAR(samples.at(i)[d], i[d] / 8.0, 2e-15);
    }
  });
}

TEST(Sampling, ReportsProgressAndAborts)
{
  std::mt19937 random(8);
  const Block block = mixedBlocks(random)[2];
  std::vector<double> fractions;
  Execution run;
  run.progress = [&](double fraction) {
    fractions.push_back(fraction);
    return true;
  };
  samplesOf(block, 1, { 0, 0, 0 }, run);
  EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
  EXPECT_EQ(fractions.back(), 1.0);
  run.progress = [](double) { return false; };
  EXPECT_THROW(samplesOf(block, 1, { 0, 0, 0 }, run), Aborted);
}

TEST(Sampling, RefusesLevelsAndCountsOutOfRange)
{
  std::mt19937 random(9);
  const Block block = mixedBlocks(random)[2];
  EXPECT_THROW(sampleCounts(block.view(), -1, "block"), Error);
  EXPECT_THROW(sampleCounts(block.view(), 9, "block"), Error);
  EXPECT_EQ(sampleCounts(block.view(), 8, "block"), (Ijk{ 1281, 1281, 1281 }));
  BSplineVolume wide;
  wide.knots = { clampedIntegerKnots(20000), clampedIntegerKnots(20000), clampedIntegerKnots(20000) };
  EXPECT_NO_THROW(sampleCounts(wide, 0, "block"));
  EXPECT_THROW(sampleCounts(wide, 8, "block"), Error);
}
