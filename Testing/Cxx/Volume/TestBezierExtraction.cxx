// SPDX-License-Identifier: BSD-3-Clause
// Bezier cells of B-spline volumes: exact, connected, independent of orientation, order of blocks and threads.
#include "Support/ThreadRanks.h"
#include "Support/VolumeCases.h"
#include "Volume/BezierExtraction.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <map>
#include <numeric>
#include <set>

using namespace bsv;
using namespace bsvtest;

namespace
{

struct Extracted
{
  std::vector<double> points;
  std::vector<double> weights;
};

Extracted evaluated(const BezierExtraction& extraction, const Execution& run = {})
{
  const double unset = std::numeric_limits<double>::quiet_NaN();
  Extracted result;
  result.points.assign(3 * extraction.pointCount(), unset);
  result.weights.assign(extraction.rational() ? extraction.pointCount() : 0, unset);
  extraction.evaluate(result.points.data(), result.weights.data(), run);
  return result;
}

std::vector<BSplineVolume> views(const std::vector<Block>& blocks)
{
  std::vector<BSplineVolume> result;
  for (const Block& block : blocks)
  {
    result.push_back(block.view());
    checkBSplineVolume(result.back(), "block");
  }
  return result;
}

double bernstein(int n, int i, double t)
{
  double binomial = 1.0;
  for (int k = 1; k <= i; ++k)
  {
    binomial = binomial * (n - i + k) / k;
  }
  return binomial * std::pow(t, i) * std::pow(1.0 - t, n - i);
}

/// Value of the cell of span `span` at `t` in [0, 1]^3, from the definition of a rational Bezier volume.
Vec3 bezierValue(const BezierExtraction& extraction, const Extracted& extracted, const BSplineVolume& volume, int block,
  const Ijk& span, const Vec3& t)
{
  const Ijk p = volume.degree;
  Vec3 numerator = Vec3::Zero();
  double denominator = 0.0;
  forEach({ p[0] + 1, p[1] + 1, p[2] + 1 }, [&](const Ijk& i) {
    const Index point =
      extraction.point(block, { span[0] * p[0] + i[0], span[1] * p[1] + i[1], span[2] * p[2] + i[2] });
    const double b = bernstein(p[0], i[0], t[0]) * bernstein(p[1], i[1], t[1]) * bernstein(p[2], i[2], t[2]) *
      (extracted.weights.empty() ? 1.0 : extracted.weights[point]);
    numerator += b * Eigen::Map<const Vec3>(extracted.points.data() + 3 * point);
    denominator += b;
  });
  return numerator / denominator;
}

/// Random non-decreasing knots: inner ones repeated up to `degree` times; clamped or not.
std::vector<double> randomKnots(std::mt19937& random, int degree, bool clamped)
{
  const auto dice = [&](int low, int high) { return std::uniform_int_distribution<int>(low, high)(random); };
  std::vector<double> knots(degree + 1, 0.0);
  double at = 0.0;
  if (!clamped)
  {
    for (int i = degree - 1; i >= 0; --i)
    {
      knots[i] = knots[i + 1] - dice(0, 3) / 4.0;
    }
  }
  const int inner = dice(0, 3);
  for (int i = 0; i < inner; ++i)
  {
    at += dice(1, 8) / 4.0;
    knots.insert(knots.end(), dice(1, degree), at);
  }
  at += dice(1, 8) / 4.0;
  knots.push_back(at);
  for (int i = 0; i < degree; ++i)
  {
    knots.push_back(knots.back() + (clamped ? 0.0 : dice(0, 3) / 4.0));
  }
  return knots;
}

void makeRational(std::mt19937& random, Block& block)
{
  block.weights.resize(block.points.size() / 3);
  for (double& weight : block.weights)
  {
    weight = std::uniform_real_distribution<double>(0.2, 3.0)(random);
  }
}

Block randomVolume(std::mt19937& random, bool rational)
{
  std::array<int, 3> degree;
  std::array<std::vector<double>, 3> knots;
  for (int d = 0; d < 3; ++d)
  {
    degree[d] = std::uniform_int_distribution<int>(1, MaxDegree)(random);
    knots[d] = randomKnots(random, degree[d], random() % 3 != 0);
  }
  Block block = randomBlock(random, degree, knots, false);
  if (rational)
  {
    makeRational(random, block);
  }
  return block;
}

} // namespace

TEST(BezierExtraction, CellsEqualEvaluation)
{
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::set<int> degrees;
  double worst = 0.0;
  for (int trial = 0; trial < 300; ++trial)
  {
    const std::vector<Block> blocks{ randomVolume(random, trial % 2 == 1) };
    const std::vector<BSplineVolume> volumes = views(blocks);
    const BezierExtraction extraction(volumes, nullptr, BezierCells::Volume);
    const Extracted extracted = evaluated(extraction);
    const BSplineVolume& volume = volumes[0];
    std::array<std::vector<int>, 3> spans;
    for (int d = 0; d < 3; ++d)
    {
      degrees.insert(volume.degree[d]);
      spans[d] = nonEmptySpans(volume.degree[d], volume.knots[d]);
      ASSERT_EQ(extraction.spans(0)[d], static_cast<int>(spans[d].size()));
    }
    const Ijk counts = extraction.counts(0);
    ASSERT_EQ(extraction.pointCount(), Index(counts[0]) * counts[1] * counts[2]);
    forEach(extraction.spans(0), [&](const Ijk& span) {
      const Vec3 t(unit(random), unit(random), unit(random));
      Vec3 u;
      for (int d = 0; d < 3; ++d)
      {
        const double a = volume.knots[d][spans[d][span[d]]];
        const double b = volume.knots[d][spans[d][span[d]] + 1];
        u[d] = a + t[d] * (b - a);
      }
      const Vec3 x = bezierValue(extraction, extracted, volume, 0, span, t);
      worst = std::max(worst, (x - evaluate(volume, u)).lpNorm<Eigen::Infinity>());
    });
  }
  // Coordinates lie in [-1, 1].
  EXPECT_LT(worst, 1e-14);
  EXPECT_EQ(degrees.size(), std::size_t(MaxDegree));
  RecordProperty("worst", std::to_string(worst * 1e16) + "e-16");
}

TEST(BezierExtraction, SharedFacesHaveTheSameBitsAndPointsInAllOrientations)
{
  std::mt19937 random(2);
  std::array<bool, 8> seen{};
  for (int trial = 0; trial < 40; ++trial)
  {
    const bool rational = trial % 2 == 1;
    const std::array<bool, 3> periodic{ trial % 3 == 1, trial % 3 == 2, false };
    const std::array<std::vector<int>, 3> cells{ { { 1, 3 }, { 2, 4 }, { 3, 1, 2 } } };
    Volumes lattice = cutLattice(random, cells, periodic);
    if (rational)
    {
      // A function of the point, so that blocks agree.
      for (Block& block : lattice.blocks)
      {
        for (std::size_t p = 0; p < block.points.size(); p += 3)
        {
          block.weights.push_back(1.5 + std::tanh(block.points[p]) * std::tanh(block.points[p + 1]));
        }
      }
    }
    const std::vector<BSplineVolume> volumes = views(lattice.blocks);

    // Every block by itself: the same bits on both sides.
    std::vector<std::vector<BSplineVolume>> alone;
    for (const BSplineVolume& volume : volumes)
    {
      alone.push_back({ volume });
    }
    std::vector<BezierExtraction> extractions;
    std::vector<Extracted> values;
    for (const auto& one : alone)
    {
      const std::vector<Interface> none;
      extractions.emplace_back(one, &none, BezierCells::Volume);
      values.push_back(evaluated(extractions.back()));
    }
    const BezierExtraction all(volumes, &lattice.interfaces, BezierCells::Volume);
    const Extracted together = evaluated(all);
    for (const Interface& contact : lattice.interfaces)
    {
      seen[contact.orientation] = true;
      const Ijk& na = all.counts(contact.blockA);
      const Ijk& nb = all.counts(contact.blockB);
      const int ns = na[faceAxis(contact.faceA, 0)] - 1;
      const int nt = na[faceAxis(contact.faceA, 1)] - 1;
      for (int s = 0; s <= ns; ++s)
      {
        for (int t = 0; t <= nt; ++t)
        {
          const auto m = mapFacePoint(contact.orientation, s, t, ns, nt);
          const Ijk i = facePosition(na, contact.faceA, s, t);
          const Ijk j = facePosition(nb, contact.faceB, m[0], m[1]);
          const Index a = extractions[contact.blockA].point(0, i);
          const Index b = extractions[contact.blockB].point(0, j);
          const Extracted& va = values[contact.blockA];
          const Extracted& vb = values[contact.blockB];
          ASSERT_EQ(std::memcmp(&va.points[3 * a], &vb.points[3 * b], 3 * sizeof(double)), 0);
          if (rational)
          {
            ASSERT_EQ(va.weights[a], vb.weights[b]);
          }
          const Index shared = all.point(contact.blockA, i);
          ASSERT_EQ(shared, all.point(contact.blockB, j));
          ASSERT_EQ(std::memcmp(&va.points[3 * a], &together.points[3 * shared], 3 * sizeof(double)), 0);
        }
      }
    }

    // The lattice knows how many points and faces there are, with declared contacts and with found ones.
    std::array<Index, 3> bezier{};
    std::array<Index, 3> faces{};
    for (int d = 0; d < 3; ++d)
    {
      for (const int n : cells[d])
      {
        bezier[d] += 3 * n;
      }
      bezier[d] += periodic[d] ? 0 : 1;
      faces[d] = static_cast<Index>(cells[d].size());
    }
    Index outer = 0;
    Index every = 0;
    for (int d = 0; d < 3; ++d)
    {
      const Index across = faces[(d + 1) % 3] * faces[(d + 2) % 3];
      outer += periodic[d] ? 0 : 2 * across;
      every += across * (faces[d] + (periodic[d] ? 0 : 1));
    }
    for (const std::vector<Interface>* contacts :
      { &lattice.interfaces, static_cast<std::vector<Interface>*>(nullptr) })
    {
      EXPECT_EQ(
        BezierExtraction(volumes, contacts, BezierCells::Volume).pointCount(), bezier[0] * bezier[1] * bezier[2]);
      EXPECT_EQ(Index(BezierExtraction(volumes, contacts, BezierCells::OuterFaces).faces().size()), outer);
      EXPECT_EQ(Index(BezierExtraction(volumes, contacts, BezierCells::AllFaces).faces().size()), every);
    }
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), true), 8);
}

// Any block stored another way gives the same set of points.
TEST(BezierExtraction, OrientationAndThreadsDoNotMatter)
{
  std::mt19937 random(3);
  for (int trial = 0; trial < 6; ++trial)
  {
    const Block block = randomVolume(random, trial % 2 == 1);
    const std::vector<Block> plain{ block };
    const std::vector<BSplineVolume> plainView = views(plain);
    const BezierExtraction extraction(plainView, nullptr, BezierCells::Volume);
    const Extracted expected = evaluated(extraction);
    const Extracted threaded = evaluated(extraction, scrambledExecution());
    ASSERT_EQ(expected.points, threaded.points);
    ASSERT_EQ(expected.weights, threaded.weights);
    for (const Orientation& o : allOrientations())
    {
      Block turned = reoriented(block, o);
      if (!block.weights.empty())
      {
        forEach(turned.counts(),
          [&](const Ijk& i) { turned.weights.push_back(block.weights[block.at(o.old(i, block.counts()))]); });
      }
      const std::vector<Block> blocks{ turned };
      const std::vector<BSplineVolume> volumes = views(blocks);
      const BezierExtraction other(volumes, nullptr, BezierCells::Volume);
      const Extracted values = evaluated(other);
      forEach(other.counts(0), [&](const Ijk& i) {
        const Index a = extraction.point(0, o.old(i, extraction.counts(0)));
        const Index b = other.point(0, i);
        ASSERT_EQ(std::memcmp(&expected.points[3 * a], &values.points[3 * b], 3 * sizeof(double)), 0);
        if (!block.weights.empty())
        {
          ASSERT_EQ(expected.weights[a], values.weights[b]);
        }
      });
    }
  }
}

TEST(BezierExtraction, FacesHaveThePointsOfTheVolume)
{
  std::mt19937 random(4);
  const Volumes lattice = cutLattice(random, { { { 2, 1 }, { 2 }, { 1, 1 } } });
  const std::vector<BSplineVolume> volumes = views(lattice.blocks);
  const BezierExtraction whole(volumes, &lattice.interfaces, BezierCells::Volume);
  const Extracted expected = evaluated(whole);
  for (const BezierCells cells : { BezierCells::OuterFaces, BezierCells::AllFaces })
  {
    const BezierExtraction skin(volumes, &lattice.interfaces, cells);
    const Extracted values = evaluated(skin);
    std::set<Index> used;
    for (const BlockFace& at : skin.faces())
    {
      const Ijk& n = skin.counts(at.block);
      for (int s = 0; s < n[faceAxis(at.face, 0)]; ++s)
      {
        for (int t = 0; t < n[faceAxis(at.face, 1)]; ++t)
        {
          const Ijk i = facePosition(n, at.face, s, t);
          const Index a = whole.point(at.block, i);
          const Index b = skin.point(at.block, i);
          ASSERT_GE(b, 0);
          used.insert(b);
          ASSERT_EQ(std::memcmp(&expected.points[3 * a], &values.points[3 * b], 3 * sizeof(double)), 0);
        }
      }
    }
    // No point without a cell.
    EXPECT_EQ(static_cast<Index>(used.size()), skin.pointCount());
  }
}

TEST(BezierExtraction, RoundingIsWeldedAndAGapIsNot)
{
  std::mt19937 random(5);
  Volumes lattice = cutLattice(random, { { { 2, 3 }, { 2 }, { 2 } } }, { false, false, false }, false);
  ASSERT_EQ(lattice.interfaces.size(), 1u);
  const Index welded = 16 * 7 * 7;
  const auto count = [&](double shift, bool declared) {
    std::vector<Block> blocks = lattice.blocks;
    for (double& x : blocks[1].points)
    {
      x += shift;
    }
    const std::vector<BSplineVolume> volumes = views(blocks);
    return BezierExtraction(volumes, declared ? &lattice.interfaces : nullptr, BezierCells::Volume).pointCount();
  };
  EXPECT_EQ(count(0.0, true), welded);
  EXPECT_EQ(count(0.0, false), welded);
  EXPECT_EQ(count(4e-16, true), welded);
  EXPECT_EQ(count(4e-16, false), welded);
  EXPECT_EQ(count(1e-9, true), welded + 49);
  EXPECT_EQ(count(1e-9, false), welded + 49);
}

// Points that differ by rounding from block to block, zeros of both signs among them, are the same on all ranks, and
// those that are one in the whole are one on a rank, although some are so only through blocks on other ranks.
TEST(BezierExtraction, SameBitsOnAnyRanks)
{
  std::mt19937 random(8);
  for (int trial = 0; trial < 6; ++trial)
  {
    Volumes lattice =
      cutLattice(random, { { { 2, 1 }, { 1, 2 }, { 2, 1 } } }, { trial % 3 == 1, trial % 3 == 2, false }, false);
    for (Block& block : lattice.blocks)
    {
      for (double& x : block.points)
      {
        x = std::abs(x) < 0.1 ? (random() % 2 ? 0.0 : -0.0) : x + int(random() % 5) * 2e-16;
      }
    }
    if (trial >= 3)
    {
      makeRational(random, lattice.blocks[5]);
    }
    const std::vector<BSplineVolume> volumes = views(lattice.blocks);
    for (const bool declared : { true, false })
    {
      const std::vector<Interface>* contacts = declared ? &lattice.interfaces : nullptr;
      for (const BezierCells cells : { BezierCells::Volume, BezierCells::OuterFaces, BezierCells::AllFaces })
      {
        const BezierExtraction whole(volumes, contacts, cells);
        const Extracted expected = evaluated(whole);
        for (int size = 2; size <= 5; ++size)
        {
          for (const std::vector<int>& owners : distributions(random, volumes.size(), size))
          {
            std::vector<Index> faces(size);
            const auto errors = onRanks(size, [&](const Execution& run) {
              const int rank = run.ranks->rank();
              const std::vector<BSplineVolume> mine = bsvtest::partOf(volumes, owners, rank);
              const BezierExtraction part(mine, contacts, cells, run);
              const Extracted values = evaluated(part, run);
              ASSERT_EQ(part.rational(), whole.rational());
              std::map<Index, Index> toWhole, toPart;
              const auto check = [&](int block, const Ijk& i) {
                const Index a = whole.point(block, i);
                const Index b = part.point(block, i);
                ASSERT_GE(b, 0);
                ASSERT_EQ(std::memcmp(&expected.points[3 * a], &values.points[3 * b], 3 * sizeof(double)), 0);
                ASSERT_TRUE(!whole.rational() || expected.weights[a] == values.weights[b]);
                ASSERT_EQ(toWhole.emplace(b, a).first->second, a);
                ASSERT_EQ(toPart.emplace(a, b).first->second, b);
              };
              for (int block = 0; cells == BezierCells::Volume && block < int(volumes.size()); ++block)
              {
                if (owners[block] == rank)
                {
                  forEach(part.counts(block), [&](const Ijk& i) { check(block, i); });
                }
              }
              for (const BlockFace& at : part.faces())
              {
                ASSERT_EQ(owners[at.block], rank);
                const Ijk& n = part.counts(at.block);
                for (int s = 0; s < n[faceAxis(at.face, 0)]; ++s)
                {
                  for (int t = 0; t < n[faceAxis(at.face, 1)]; ++t)
                  {
                    check(at.block, facePosition(n, at.face, s, t));
                  }
                }
              }
              EXPECT_EQ(static_cast<Index>(toWhole.size()), part.pointCount());
              faces[rank] = static_cast<Index>(part.faces().size());
            });
            EXPECT_EQ(errors, std::vector<std::string>(size));
            EXPECT_EQ(std::accumulate(faces.begin(), faces.end(), Index(0)), Index(whole.faces().size()));
          }
        }
      }
    }
  }
}

TEST(BezierExtraction, OnlyFacesTravel)
{
  std::mt19937 random(9);
  for (const int cells : { 5, 10 })
  {
    const Volumes lattice =
      cutLattice(random, { { { cells, cells }, { cells }, { cells } } }, { false, false, false }, false);
    const std::vector<BSplineVolume> volumes = views(lattice.blocks);
    const auto errors = onRanks(2, [&](const Execution& run) {
      const std::vector<BSplineVolume> mine = bsvtest::partOf(volumes, { 0, 1 }, run.ranks->rank());
      const BezierExtraction part(mine, &lattice.interfaces, BezierCells::Volume, run);
      evaluated(part, run);
      // Points once, then what is known of them: at first, and again because something was new.
      const double points = (3.0 * cells + 1) * (3.0 * cells + 1);
      EXPECT_LT(run.ranks->receivedBytes(), points * (24 + 2 * 48) + 1000);
    });
    EXPECT_EQ(errors, std::vector<std::string>(2));
  }
}

// A declared contact of faces with unequal degrees has no common Bezier points.
TEST(BezierExtraction, UnequalDegreesAreNotWelded)
{
  std::mt19937 random(6);
  std::vector<double> quadratic{ 0, 0, 0, 1, 2, 2, 2 };
  std::vector<double> cubic{ 0, 0, 0, 0, 1, 1, 1, 1 };
  const std::vector<Block> blocks{ randomBlock(random, { 3, 3, 3 }, { cubic, cubic, cubic }, false),
    randomBlock(random, { 2, 2, 2 }, { quadratic, quadratic, quadratic }, false) };
  const std::vector<BSplineVolume> volumes = views(blocks);
  const std::vector<Interface> contacts{ { 0, 1, 1, 0, 0, {}, { 0, 0 } } };
  EXPECT_EQ(BezierExtraction(volumes, &contacts, BezierCells::Volume).pointCount(), 64 + 125);
  EXPECT_EQ(BezierExtraction(volumes, &contacts, BezierCells::OuterFaces).faces().size(), 10u);
}

TEST(BezierExtraction, NothingInNothingOutAndBadPointsAreRefused)
{
  const std::vector<BSplineVolume> none;
  const BezierExtraction empty(none, nullptr, BezierCells::Volume);
  EXPECT_EQ(empty.pointCount(), 0);
  evaluated(empty);

  std::mt19937 random(7);
  Volumes lattice = cutLattice(random, { { { 1, 1 }, { 1 }, { 1 } } });
  std::fill(lattice.blocks[0].points.begin(), lattice.blocks[0].points.end(), std::numeric_limits<double>::quiet_NaN());
  EXPECT_THROW(views(lattice.blocks), Error);
}
