// SPDX-License-Identifier: BSD-3-Clause
// Validity of spans: against dense samples and exact rational arithmetic, on volumes of known sign, and independent of
// orientation, threads and instruction set.
#include "Quality/JacobianBounds.h"
#include "Quality/TangentCones.h"
#include "Support/VolumeCases.h"
#include "Volume/Sampling.h"

#if defined(__GNUC__) && !defined(__clang__)
// False alarms of GCC 12 inside Boost.
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <boost/multiprecision/cpp_int.hpp>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <cstdlib>
#include <limits>
#include <numeric>

using namespace bsv;
using namespace bsvtest;

namespace
{

using Rational = boost::multiprecision::cpp_rational;

/// Results of all spans of a block.
struct Measured
{
  JacobianReport report;
  std::vector<unsigned char> validity;
  std::vector<double> lower, upper, scaledJacobian, skewness;

  Validity at(Index span) const { return static_cast<Validity>(this->validity[span]); }
};

Ijk spanCounts(const BSplineVolume& volume)
{
  Ijk n{};
  for (int d = 0; d < 3; ++d)
  {
    n[d] = static_cast<int>(nonEmptySpans(volume.degree[d], volume.knots[d]).size());
  }
  return n;
}

Measured measure(const Block& block, const JacobianOptions& options = {}, const Execution& run = {})
{
  const BSplineVolume volume = block.view();
  checkBSplineVolume(volume, "block");
  const Ijk n = spanCounts(volume);
  const std::size_t size = static_cast<std::size_t>(n[0]) * n[1] * n[2];
  Measured result;
  result.validity.assign(size, 255);
  for (std::vector<double>* array : { &result.lower, &result.upper, &result.scaledJacobian, &result.skewness })
  {
    array->assign(size, std::numeric_limits<double>::quiet_NaN());
  }
  result.report = jacobianBounds(volume, "block", options,
    { result.validity.data(), result.lower.data(), result.upper.data(), result.scaledJacobian.data(),
      result.skewness.data() },
    run);
  const auto count = [&](Validity v) {
    return std::count(result.validity.begin(), result.validity.end(), static_cast<unsigned char>(v));
  };
  EXPECT_EQ(result.report.valid, count(Validity::Valid));
  EXPECT_EQ(result.report.invalid, count(Validity::Invalid));
  EXPECT_EQ(result.report.undecided, count(Validity::Undecided));
  EXPECT_EQ(result.report.valid + result.report.invalid + result.report.undecided, static_cast<Index>(size));
  EXPECT_EQ(result.report.witnesses.size(), static_cast<std::size_t>(result.report.invalid));
  EXPECT_EQ(result.report.lowest, *std::min_element(result.lower.begin(), result.lower.end()));
  return result;
}

/// Basis function i of `degree` and its derivative at u in span s, by the definition of de Boor and Cox.
Rational basis(int degree, const std::vector<double>& knots, int i, int s, const Rational& u)
{
  if (degree == 0)
  {
    return i == s ? 1 : 0;
  }
  Rational sum = 0;
  if (knots[i + degree] > knots[i])
  {
    sum +=
      (u - Rational(knots[i])) / (Rational(knots[i + degree]) - Rational(knots[i])) * basis(degree - 1, knots, i, s, u);
  }
  if (knots[i + degree + 1] > knots[i + 1])
  {
    sum += (Rational(knots[i + degree + 1]) - u) / (Rational(knots[i + degree + 1]) - Rational(knots[i + 1])) *
      basis(degree - 1, knots, i + 1, s, u);
  }
  return sum;
}

Rational basisDerivative(int degree, const std::vector<double>& knots, int i, int s, const Rational& u)
{
  Rational sum = 0;
  if (knots[i + degree] > knots[i])
  {
    sum += basis(degree - 1, knots, i, s, u) / (Rational(knots[i + degree]) - Rational(knots[i]));
  }
  if (knots[i + degree + 1] > knots[i + 1])
  {
    sum -= basis(degree - 1, knots, i + 1, s, u) / (Rational(knots[i + degree + 1]) - Rational(knots[i + 1]));
  }
  return degree * sum;
}

/// det J at a point of a span, with respect to the span's parameters, without any rounding.
Rational exactDeterminant(const BSplineVolume& volume, const Ijk& span, const Vec3& fraction)
{
  std::array<std::array<std::vector<Rational>, 2>, 3> values; // direction, derivative, function
  std::array<int, 3> first{};
  for (int d = 0; d < 3; ++d)
  {
    const std::vector<double>& knots = volume.knots[d];
    const int p = volume.degree[d];
    const int s = nonEmptySpans(p, knots)[span[d]];
    const Rational length = Rational(knots[s + 1]) - Rational(knots[s]);
    const Rational u = Rational(knots[s]) + Rational(fraction[d]) * length;
    first[d] = s - p;
    for (int i = s - p; i <= s; ++i)
    {
      values[d][0].push_back(basis(p, knots, i, s, u));
      values[d][1].push_back(basisDerivative(p, knots, i, s, u) * length);
    }
  }
  // (w x, w) and its derivatives; x_u = ((w x)_u - x w_u) / w.
  std::array<std::array<Rational, 4>, 4> h;
  for (int c = 0; c <= volume.degree[2]; ++c)
  {
    for (int b = 0; b <= volume.degree[1]; ++b)
    {
      for (int a = 0; a <= volume.degree[0]; ++a)
      {
        const Index at =
          first[0] + a + Index(volume.count(0)) * (first[1] + b + Index(volume.count(1)) * (first[2] + c));
        const Rational w = volume.weights ? Rational(volume.weights[at]) : Rational(1);
        for (int row = 0; row < 4; ++row)
        {
          const Rational n = values[0][row == 1][a] * values[1][row == 2][b] * values[2][row == 3][c] * w;
          for (int x = 0; x < 3; ++x)
          {
            h[row][x] += n * Rational(volume.points[3 * at + x]);
          }
          h[row][3] += n;
        }
      }
    }
  }
  std::array<std::array<Rational, 3>, 3> j;
  for (int row = 0; row < 3; ++row)
  {
    for (int x = 0; x < 3; ++x)
    {
      j[row][x] = (h[row + 1][x] - h[0][x] / h[0][3] * h[row + 1][3]) / h[0][3];
    }
  }
  return j[0][0] * (j[1][1] * j[2][2] - j[1][2] * j[2][1]) - j[0][1] * (j[1][0] * j[2][2] - j[1][2] * j[2][0]) +
    j[0][2] * (j[1][0] * j[2][1] - j[1][1] * j[2][0]);
}

/// Points at their Greville abscissae (x = u), moved at random by up to `amplitude`.
Block gridBlock(std::mt19937& random, const std::array<int, 3>& degree, const std::array<std::vector<double>, 3>& knots,
  double amplitude)
{
  Block block;
  block.volume.degree = degree;
  block.volume.knots = knots;
  std::uniform_real_distribution<double> noise(-amplitude, amplitude);
  forEach(block.counts(), [&](const Ijk& i) {
    for (int d = 0; d < 3; ++d)
    {
      const auto begin = knots[d].begin() + i[d] + 1;
      block.points.push_back(std::accumulate(begin, begin + degree[d], 0.0) / degree[d] + noise(random));
    }
  });
  return block;
}

Block cubicBlock(std::mt19937& random, const Ijk& cells, double amplitude)
{
  return gridBlock(random, { 3, 3, 3 },
    { clampedIntegerKnots(cells[0]), clampedIntegerKnots(cells[1]), clampedIntegerKnots(cells[2]) }, amplitude);
}

/// x -> a + m x for all points.
void transform(Block& block, const Eigen::Matrix3d& m, const Vec3& a = Vec3::Zero())
{
  for (std::size_t i = 0; i < block.points.size(); i += 3)
  {
    Eigen::Map<Vec3> x(block.points.data() + i);
    x = (a + m * x).eval();
  }
}

/// Smallest and largest det J of every span over a grid of samples; intervals in the parameters of the span.
struct SampledRange
{
  std::vector<double> lowest, highest;
};

SampledRange sampledRange(const Block& block, int level)
{
  const BSplineVolume volume = block.view();
  const Ijk n = spanCounts(volume);
  const Ijk counts = sampleCounts(volume, level, "block");
  std::array<std::vector<double>, 3> x;
  for (int d = 0; d < 3; ++d)
  {
    x[d].resize(static_cast<std::size_t>(3) * counts[0] * counts[1] * counts[2]);
    std::array<int, 3> order{};
    order[d] = 1;
    sample(volume, level, order, x[d].data());
  }
  SampledRange range;
  const int parts = 1 << level;
  forEach(n, [&](const Ijk& span) {
    double length = 1.0;
    for (int d = 0; d < 3; ++d)
    {
      const int s = nonEmptySpans(volume.degree[d], volume.knots[d])[span[d]];
      length *= volume.knots[d][s + 1] - volume.knots[d][s];
    }
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    // Inner samples only: on knots the samples are means of both sides where the volume is only C0.
    forEach({ parts - 1, parts - 1, parts - 1 }, [&](const Ijk& i) {
      const Index at = span[0] * parts + i[0] + 1 +
        Index(counts[0]) * (span[1] * parts + i[1] + 1 + Index(counts[1]) * (span[2] * parts + i[2] + 1));
      Eigen::Matrix3d j;
      for (int d = 0; d < 3; ++d)
      {
        j.row(d) = Eigen::Map<const Vec3>(x[d].data() + 3 * at);
      }
      low = std::min(low, length * j.determinant());
      high = std::max(high, length * j.determinant());
    });
    range.lowest.push_back(low);
    range.highest.push_back(high);
  });
  return range;
}

/// Bounds hold at all samples, and no verdict contradicts them. `size`: of det J, for the rounding of the samples. In
/// rational arithmetic: `exact` witnesses, and the corners and a point of the `exact` / 5 valid spans closest to zero.
/// @return how many values were computed exactly.
Index expectTrue(const Block& block, const Measured& measured, int level, double size, std::size_t exact)
{
  const SampledRange range = sampledRange(block, level);
  const double rounding = 1e-12 * size;
  std::vector<Index> valid;
  for (std::size_t s = 0; s < range.lowest.size(); ++s)
  {
    EXPECT_LE(measured.lower[s], range.lowest[s] + rounding) << "span " << s;
    EXPECT_GE(measured.upper[s], range.highest[s] - rounding) << "span " << s;
    if (measured.at(s) == Validity::Valid)
    {
      EXPECT_GT(range.lowest[s], -rounding) << "span " << s;
      EXPECT_GE(measured.lower[s], 0.0) << "span " << s;
      valid.push_back(static_cast<Index>(s));
    }
    if (measured.at(s) == Validity::Invalid)
    {
      EXPECT_LE(measured.lower[s], 0.0) << "span " << s;
    }
  }
  const BSplineVolume volume = block.view();
  const Ijk n = spanCounts(volume);
  Index count = 0;
  const auto& witnesses = measured.report.witnesses;
  const std::size_t step = std::max<std::size_t>(1, witnesses.size() / std::max<std::size_t>(1, exact));
  for (std::size_t w = 0; w < witnesses.size(); w += step, ++count)
  {
    const JacobianWitness& witness = witnesses[w];
    EXPECT_EQ(measured.at(witness.span), Validity::Invalid);
    EXPECT_EQ(witness.span, witness.ijk[0] + n[0] * (witness.ijk[1] + Index(n[1]) * witness.ijk[2]));
    const Rational value = exactDeterminant(volume, witness.ijk, witness.fraction);
    EXPECT_TRUE(value <= Rational(witness.value)) << "span " << witness.span;
    EXPECT_LE(witness.value, 0.0);
    for (int d = 0; d < 3; ++d)
    {
      const int s = nonEmptySpans(volume.degree[d], volume.knots[d])[witness.ijk[d]];
      EXPECT_GE(witness.uvw[d], volume.knots[d][s]);
      EXPECT_LE(witness.uvw[d], volume.knots[d][s + 1]);
    }
  }
  const std::size_t closest = std::min(valid.size(), exact / 5);
  std::partial_sort(valid.begin(), valid.begin() + closest, valid.end(),
    [&](Index a, Index b) { return measured.lower[a] < measured.lower[b]; });
  for (std::size_t v = 0; v < closest; ++v)
  {
    const Index s = valid[v];
    const Index row = s / n[0];
    const Ijk ijk{ static_cast<int>(s % n[0]), static_cast<int>(row % n[1]), static_cast<int>(row / n[1]) };
    for (int point = 0; point < 9; ++point, ++count)
    {
      const Vec3 fraction =
        point < 8 ? Vec3(point & 1, point >> 1 & 1, point >> 2) : Vec3(0.3, 0.0390625 * (s % 25), 0.7);
      const Rational value = exactDeterminant(volume, ijk, fraction);
      EXPECT_TRUE(value > 0 && value >= Rational(measured.lower[s]) && value <= Rational(measured.upper[s]))
        << "span " << s << " point " << point;
    }
  }
  return count;
}

const std::vector<double> Linear{ 0, 0, 0.5, 2, 2 };
const std::vector<double> Quadratic{ 0, 0, 0, 1, 1, 2.25, 3, 3, 3 };
const std::vector<double> Quintic{ 0, 0, 0, 0, 0, 0, 1, 2, 2, 2, 4, 4, 4, 4, 4, 4 };
const std::vector<double> Uniform{ -3, -2, -1, 0, 1, 2, 3, 4, 5, 6, 7 };
const std::vector<double> Octic{ 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 3, 3, 3, 3, 3, 3, 3, 3, 3 };

/// Degrees 1 to 5, rational or not, on the border of validity.
std::vector<Block> mixedBlocks(std::mt19937& random)
{
  std::vector<Block> blocks{ gridBlock(random, { 1, 2, 5 }, { Linear, Quadratic, Quintic }, 0.3),
    gridBlock(random, { 3, 1, 3 }, { Uniform, Linear, clampedIntegerKnots(2) }, 0.3),
    gridBlock(random, { 2, 2, 2 }, { Quadratic, Quadratic, Quadratic }, 0.2), cubicBlock(random, { 4, 3, 5 }, 0.4) };
  const std::size_t polynomial = blocks.size();
  for (std::size_t b = 0; b < polynomial; ++b)
  {
    Block rational = blocks[b];
    for (std::size_t i = 0; i < rational.points.size() / 3; ++i)
    {
      rational.weights.push_back(std::ldexp(std::uniform_int_distribution<int>(64, 160)(random), -7));
    }
    blocks.push_back(rational);
  }
  return blocks;
}

} // namespace

// The number of spans is BSV_RANDOM_SPANS, or 64000.
TEST(JacobianBounds, RandomSpansHaveNoFalseVerdict)
{
  const char* wanted = std::getenv("BSV_RANDOM_SPANS");
  const Index spans = wanted ? std::atoll(wanted) : 64000;
  Index done = 0;
  Index undecided = 0;
  Index invalid = 0;
  Index exactValues = 0;
  std::mt19937 random(1);
  for (int trial = 0; done < spans; ++trial)
  {
    // From hardly any to mostly inverted spans.
    const double amplitude = 0.3 + 0.1 * (trial % 5);
    Block block = cubicBlock(random, { 20, 20, 20 }, amplitude);
    const Measured measured = measure(block);
    exactValues += expectTrue(block, measured, 2, 10.0, 100);
    done += 8000;
    undecided += measured.report.undecided;
    invalid += measured.report.invalid;
  }
  EXPECT_GT(invalid, done / 20);
  EXPECT_LT(invalid, done / 2);
  EXPECT_LT(undecided, done / 1000);
  std::printf("%lld spans, %lld invalid, %lld undecided, %lld exact values\n", static_cast<long long>(done),
    static_cast<long long>(invalid), static_cast<long long>(undecided), static_cast<long long>(exactValues));
}

// x(u) with derivative (u - a)^2 + e, on a sheared span: the smallest determinant is that of e.
TEST(JacobianBounds, DecidesMinimaInsideTheSpan)
{
  Eigen::Matrix3d m;
  m << 1, 0.5, 0.25, -0.5, 2, 0.125, 0.25, 0, 1;
  std::mt19937 random(2);
  for (const double a : { 0.5, 0.3, 0.7125 })
  {
    for (const double e : { 1e-3, 1e-6, 1e-10, -1e-10, -1e-6, -1e-3 })
    {
      const std::vector<double> single = clampedIntegerKnots(1);
      Block block = gridBlock(random, { 3, 3, 3 }, { single, single, single }, 0.0);
      // Bezier points of the integral from those of the derivative: a^2 + e, a^2 - a + e, (1 - a)^2 + e.
      const double x1 = (a * a + e) / 3.0;
      const double x2 = x1 + (a * a - a + e) / 3.0;
      const double x3 = x2 + ((1.0 - a) * (1.0 - a) + e) / 3.0;
      forEach(block.counts(), [&](const Ijk& i) {
        block.points[3 * block.at(i)] = i[0] == 0 ? 0.0 : i[0] == 1 ? x1 : i[0] == 2 ? x2 : x3;
      });
      transform(block, m, { 3, -1, 2 });
      const Measured measured = measure(block);
      EXPECT_EQ(measured.at(0), e > 0.0 ? Validity::Valid : Validity::Invalid) << a << " " << e;
      EXPECT_LE(measured.lower[0], e * m.determinant());
      for (const JacobianWitness& witness : measured.report.witnesses)
      {
        EXPECT_LE(exactDeterminant(block.view(), witness.ijk, witness.fraction), 0);
        EXPECT_NEAR(witness.fraction[0], a, std::sqrt(-e));
      }
    }
  }
}

TEST(JacobianBounds, OneInvertedSpanInAMillionIsFound)
{
  std::mt19937 random(3);
  Block block = cubicBlock(random, { 100, 100, 100 }, 0.05);
  const Ijk place{ 37, 71, 58 };
  // A copy of the surroundings: how far may the control point move until the first span is inverted?
  Block part = cubicBlock(random, { 9, 9, 9 }, 0.0);
  const Ijk origin{ place[0] - 6, place[1] - 6, place[2] - 6 };
  for (std::vector<double>& knots : part.volume.knots)
  {
    knots = Uniform; // as inside the block
    knots.insert(knots.end(), { 8, 9, 10, 11, 12 });
    knots.resize(16);
  }
  forEach(part.counts(), [&](const Ijk& i) {
    const double* from = block.points.data() + 3 * block.at({ origin[0] + i[0], origin[1] + i[1], origin[2] + i[2] });
    std::copy(from, from + 3, part.points.data() + 3 * part.at(i));
  });
  const double before = block.points[3 * block.at(place)];
  double low = 0.0;
  double high = 8.0;
  Index inverted = 0;
  while (inverted != 1)
  {
    const double middle = 0.5 * (low + high);
    part.points[3 * part.at({ 6, 6, 6 })] = before + middle;
    inverted = measure(part).report.invalid;
    (inverted == 0 ? low : high) = middle;
    ASSERT_GT(high - low, 1e-9);
  }
  const Measured alone = measure(part);
  block.points[3 * block.at(place)] = part.points[3 * part.at({ 6, 6, 6 })];
  const Measured measured = measure(block);
  ASSERT_EQ(measured.report.invalid, 1);
  EXPECT_EQ(measured.report.undecided, 0);
  EXPECT_EQ(measured.report.valid, 999999);
  const JacobianWitness& witness = measured.report.witnesses.front();
  for (int d = 0; d < 3; ++d)
  {
    EXPECT_EQ(witness.ijk[d], alone.report.witnesses.front().ijk[d] + origin[d]);
  }
  EXPECT_LE(exactDeterminant(block.view(), witness.ijk, witness.fraction), 0);
}

TEST(JacobianBounds, AllDegreesRationalOrNot)
{
  std::mt19937 random(4);
  Index decided[2] = { 0, 0 };
  for (int trial = 0; trial < 6; ++trial)
  {
    for (const Block& block : mixedBlocks(random))
    {
      const Measured measured = measure(block);
      expectTrue(block, measured, 3, 100.0, 5);
      decided[0] += measured.report.valid;
      decided[1] += measured.report.invalid;
    }
  }
  const std::vector<double> septic{ 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1 };
  const Block high = gridBlock(random, { 8, 3, 7 }, { Octic, Uniform, septic }, 0.05);
  expectTrue(high, measure(high), 2, 10.0, 2);
  EXPECT_GT(decided[0], 100);
  EXPECT_GT(decided[1], 100);
}

// A quarter of a tube: det J = 1 x r x angle, positive; bounds shrink around the range by halving.
TEST(JacobianBounds, RationalTube)
{
  const std::vector<double> arc{ 0, 0, 0, 1, 1, 1 };
  const std::vector<double> line{ 0, 0, 1, 1 };
  Block block;
  block.volume.degree = { 1, 2, 1 };
  block.volume.knots = { line, arc, line };
  const Vec3 ends[3]{ { 1, 0, 0 }, { 1, 1, 0 }, { 0, 1, 0 } };
  forEach(block.counts(), [&](const Ijk& i) {
    const Vec3 x = (1.0 + i[0]) * ends[i[1]] + Vec3(0, 0, i[2]);
    block.points.insert(block.points.end(), x.data(), x.data() + 3);
    block.weights.push_back(i[1] == 1 ? std::sqrt(0.5) : 1.0);
  });
  const Measured measured = measure(block);
  EXPECT_EQ(measured.at(0), Validity::Valid);
  EXPECT_NEAR(measured.scaledJacobian[0], 1.0, 1e-15);
  EXPECT_NEAR(measured.skewness[0], 0.0, 1e-15);
  expectTrue(block, measured, 4, 1.0, 0);
}

TEST(JacobianBounds, ConstantWeightsChangeNothing)
{
  std::mt19937 random(5);
  for (const double w : { 1.0, 0.3, 1e200 })
  {
    Block block = cubicBlock(random, { 4, 4, 4 }, 0.4);
    JacobianOptions whole;
    whole.maxDepth = 0;
    const Measured polynomial = measure(block, whole);
    const Validity decided = measure(block).at(0);
    block.weights.assign(block.points.size() / 3, w);
    const Measured rational = measure(block, whole);
    EXPECT_EQ(measure(block).at(0), decided);
    for (std::size_t s = 0; s < polynomial.lower.size(); ++s)
    {
      if (polynomial.lower[s] > 0.0)
      {
        // Degree 11 instead of 8: elevation only tightens.
        EXPECT_GE(rational.lower[s], polynomial.lower[s] - 1e-11);
        EXPECT_LE(rational.upper[s], polynomial.upper[s] + 1e-11);
      }
      EXPECT_NEAR(rational.scaledJacobian[s], polynomial.scaledJacobian[s], 1e-12);
    }
  }
}

TEST(JacobianBounds, SameBitsForAnyOrientation)
{
  std::mt19937 random(6);
  for (const Block& block : mixedBlocks(random))
  {
    const Measured measured = measure(block);
    const Ijk n = spanCounts(block.view());
    for (const Orientation& o : allOrientations())
    {
      const Measured other = measure(reoriented(block, o));
      const int inversions = (o.order[0] > o.order[1]) + (o.order[0] > o.order[2]) + (o.order[1] > o.order[2]) +
        o.flip[0] + o.flip[1] + o.flip[2];
      const bool reflected = inversions % 2 != 0;
      const Ijk m{ n[o.order[0]], n[o.order[1]], n[o.order[2]] };
      forEach(m, [&](const Ijk& i) {
        const Ijk old = o.old(i, n);
        const Index a = old[0] + n[0] * (old[1] + Index(n[1]) * old[2]);
        const Index b = i[0] + m[0] * (i[1] + Index(m[1]) * i[2]);
        ASSERT_EQ(measured.skewness[a], other.skewness[b]);
        if (!reflected)
        {
          ASSERT_EQ(measured.validity[a], other.validity[b]);
          ASSERT_EQ(measured.lower[a], other.lower[b]);
          ASSERT_EQ(measured.upper[a], other.upper[b]);
          ASSERT_EQ(measured.scaledJacobian[a], other.scaledJacobian[b]);
        }
        else if (measured.at(a) == Validity::Valid && other.at(b) == Validity::Invalid)
        {
          ASSERT_LE(measured.lower[a], -other.lower[b]);
        }
        else
        {
          ASSERT_NE(measured.at(a), Validity::Valid);
        }
      });
    }
  }
}

TEST(JacobianBounds, SameBitsForAnyThreadsAndInstructions)
{
  std::mt19937 random(7);
  std::vector<Block> blocks = mixedBlocks(random);
  blocks.push_back(cubicBlock(random, { 11, 10, 9 }, 0.45));
  for (const Block& block : blocks)
  {
    const Measured reference = measure(block);
    const auto expectSame = [&](const Measured& other) {
      EXPECT_EQ(reference.validity, other.validity);
      EXPECT_EQ(reference.lower, other.lower);
      EXPECT_EQ(reference.upper, other.upper);
      EXPECT_EQ(reference.scaledJacobian, other.scaledJacobian);
      EXPECT_EQ(reference.skewness, other.skewness);
      ASSERT_EQ(reference.report.witnesses.size(), other.report.witnesses.size());
      for (std::size_t w = 0; w < reference.report.witnesses.size(); ++w)
      {
        EXPECT_EQ(reference.report.witnesses[w].uvw, other.report.witnesses[w].uvw);
        EXPECT_EQ(reference.report.witnesses[w].value, other.report.witnesses[w].value);
      }
    };
    expectSame(measure(block, {}, scrambledExecution(37)));
    for (const InstructionSet set : instructionSets())
    {
      for (const bool specialised : { false, true })
      {
        JacobianOptions options;
        options.instructions = set;
        options.specialised = specialised;
        expectSame(measure(block, options));
      }
    }
  }
}

// The same map with degree elevated from (1,1,1) to higher ones: another kernel, the same verdict and range.
TEST(JacobianBounds, KernelsOfDifferentDegreesAgree)
{
  std::mt19937 random(8);
  std::uniform_real_distribution<double> noise(-0.45, 0.45);
  for (int trial = 0; trial < 50; ++trial)
  {
    Block linear;
    linear.volume.degree = { 1, 1, 1 };
    linear.volume.knots = { { { 0, 0, 1, 1 }, { 0, 0, 1, 1 }, { 0, 0, 1, 1 } } };
    forEach({ 2, 2, 2 }, [&](const Ijk& i) {
      for (int d = 0; d < 3; ++d)
      {
        linear.points.push_back(i[d] + noise(random));
      }
    });
    const Measured expected = measure(linear);
    for (const std::array<int, 3>& degree :
      { std::array<int, 3>{ 3, 3, 3 }, std::array<int, 3>{ 2, 2, 2 }, std::array<int, 3>{ 4, 1, 2 } })
    {
      Block elevated;
      elevated.volume.degree = degree;
      for (int d = 0; d < 3; ++d)
      {
        elevated.volume.knots[d].assign(degree[d] + 1, 0.0);
        elevated.volume.knots[d].insert(elevated.volume.knots[d].end(), degree[d] + 1, 1.0);
      }
      forEach(elevated.counts(), [&](const Ijk& i) {
        // Trilinear blossoms are values at the Greville abscissae.
        const Vec3 x =
          evaluate(linear.view(), { double(i[0]) / degree[0], double(i[1]) / degree[1], double(i[2]) / degree[2] });
        elevated.points.insert(elevated.points.end(), x.data(), x.data() + 3);
      });
      const Measured found = measure(elevated);
      EXPECT_EQ(found.validity, expected.validity);
      EXPECT_NEAR(found.scaledJacobian[0], expected.scaledJacobian[0], 1e-12);
      if (expected.at(0) == Validity::Valid && expected.lower[0] > 1e-6 && found.lower[0] > 1e-6)
      {
        // More roundings are accounted for: up to 1e-11 of determinants of size 1 to 10.
        EXPECT_GE(found.lower[0], expected.lower[0] - 1e-11);
        EXPECT_LE(found.upper[0], expected.upper[0] + 1e-11);
      }
    }
  }
}

TEST(JacobianBounds, AffineMapsHaveTightBounds)
{
  std::mt19937 random(9);
  Eigen::Matrix3d m;
  m << 1, 0, 0, 0.5, std::sqrt(0.75), 0, 0, 0, 2; // columns u, v, w
  m.transposeInPlace();
  Block block = cubicBlock(random, { 3, 2, 4 }, 0.0);
  transform(block, m);
  const Measured measured = measure(block);
  EXPECT_EQ(measured.report.valid, 24);
  for (int s = 0; s < 24; ++s)
  {
    EXPECT_NEAR(measured.lower[s], std::sqrt(3.0), 1e-11);
    EXPECT_NEAR(measured.upper[s], std::sqrt(3.0), 1e-11);
    EXPECT_NEAR(measured.scaledJacobian[s], std::sqrt(0.75), 1e-13);
    EXPECT_NEAR(measured.skewness[s], 1.0 / 3.0, 1e-13); // 60 degrees
  }
  Eigen::Matrix3d mirror = Eigen::Matrix3d::Identity();
  mirror(1, 1) = -1.0;
  transform(block, mirror);
  const Measured left = measure(block);
  EXPECT_EQ(left.report.invalid, 24);
  EXPECT_EQ(left.report.negative, 24);
}

// Where a derivative vanishes but for rounding, the shape is as bad as it can be, and not of any sign.
TEST(JacobianBounds, DirectionsOfNoLengthHaveNoAngle)
{
  std::mt19937 random(12);
  std::uniform_real_distribution<double> rounding(-1e-16, 1e-16);
  for (int sample = 0; sample < 20; ++sample)
  {
    // A wedge around the edge v = 0.
    Block block = cubicBlock(random, { 3, 3, 2 }, 0.0);
    for (std::size_t i = 0; i < block.points.size(); i += 3)
    {
      const double u = block.points[i], v = block.points[i + 1];
      block.points[i] = v * std::sin(0.3 * u) + rounding(random);
      block.points[i + 1] = v * std::cos(0.3 * u) + rounding(random);
    }
    const Measured measured = measure(block);
    for (int s = 0; s < 18; ++s)
    {
      const bool atEdge = s / 3 % 3 == 0;
      EXPECT_EQ(measured.scaledJacobian[s] == 0.0, atEdge) << s << ' ' << measured.scaledJacobian[s];
      EXPECT_EQ(measured.skewness[s] == 1.0, atEdge) << s << ' ' << measured.skewness[s];
    }
  }
}

// Boundary layers of any thinness, far from the origin of coordinates.
TEST(JacobianBounds, ThinLayersAreDecided)
{
  std::mt19937 random(10);
  for (const double thickness : { 1e-2, 1e-5, 1e-8 })
  {
    Block block = cubicBlock(random, { 6, 6, 6 }, 0.1);
    Eigen::Matrix3d m;
    m << 1, 0.3, 0, -0.3, 1, 0, 0, 0, thickness;
    transform(block, m, { 100, 0, 0 });
    const Measured measured = measure(block);
    EXPECT_EQ(measured.report.valid, 216) << thickness;
  }
}

// What the cones of the tangents prove, the bounds prove as well; they need no more than lines that turn little,
// however thin or sheared the cells are. Mirrored control points change the sense that is proven.
TEST(JacobianBounds, TangentConesProveNothingElse)
{
  std::mt19937 random(21);
  std::vector<Index> spans(216);
  std::iota(spans.begin(), spans.end(), Index(0));
  for (int trial = 0; trial < 60; ++trial)
  {
    const double amplitude = 0.05 * (trial % 10);
    Block block = cubicBlock(random, { 6, 6, 6 }, amplitude);
    Eigen::Matrix3d m;
    const double thickness = std::pow(10.0, -(trial % 7));
    m << 1, trial % 3, 0, -0.3, 1, 0.5 * thickness, 0, 0, thickness;
    const bool mirrored = trial % 4 == 3;
    transform(block, mirrored ? Eigen::Matrix3d(-m) : m, { 100, 0, 0 });
    JacobianOptions options;
    options.leftHanded = mirrored;
    const Measured measured = measure(block, options);
    const std::vector<bool> proven = provenByTangentCones(block.view(), spans, mirrored);
    for (const Index span : spans)
    {
      EXPECT_TRUE(!proven[span] || measured.at(span) == Validity::Valid) << "trial " << trial << " span " << span;
    }
    const auto other = provenByTangentCones(block.view(), spans, !mirrored);
    EXPECT_EQ(std::count(other.begin(), other.end(), true), 0);
    if (amplitude == 0.0 || (amplitude < 0.07 && thickness == 1.0))
    {
      EXPECT_EQ(std::count(proven.begin(), proven.end(), true), 216) << "trial " << trial;
    }
    block.points[3 * 100] = std::numeric_limits<double>::quiet_NaN();
    const auto broken = provenByTangentCones(block.view(), spans, mirrored);
    // The point is (1, 2, 1) of 9 x 9 x 9.
    EXPECT_FALSE(broken[0] || broken[1] || broken[6]);
  }
}

// So thin that rounding on the way to the Bezier points decides: no verdict may rest on it.
TEST(JacobianBounds, LayersOfTheSizeOfRoundingHaveNoFalseVerdict)
{
  std::mt19937 random(15);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.0, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  // One span around the origin: its points are rounded as little as possible.
  const std::vector<double> knots{ -3.1, -2.2, -0.7, 0.0, 1.0, 1.9, 3.3, 4.1 };
  Index undecided = 0;
  Index decided = 0;
  for (int trial = 0; trial < 70; ++trial)
  {
    const double thickness = std::pow(10.0, -9 - trial % 7);
    Block block = gridBlock(random, { 3, 3, 3 }, { knots, knots, knots }, 0.3);
    transform(block, Eigen::Matrix3d::Identity(), { -0.5, -0.5, -0.5 });
    transform(block, turn * Eigen::Vector3d(1.0, 1.0, thickness).asDiagonal());
    const Measured measured = measure(block);
    expectTrue(block, measured, 1, 10.0, 5);
    (measured.at(0) == Validity::Undecided ? undecided : decided) += 1;
  }
  EXPECT_GT(undecided, 0);
  EXPECT_GT(decided, 0);
}

TEST(JacobianBounds, ScaleDoesNotMatter)
{
  std::mt19937 random(11);
  const Block block = cubicBlock(random, { 4, 4, 4 }, 0.4);
  const Measured expected = measure(block);
  ASSERT_GT(expected.report.invalid, 0);
  for (const int exponent : { -900, -300, -120, 120, 300, 900 })
  {
    Block scaled = block;
    for (double& x : scaled.points)
    {
      x = std::ldexp(x, exponent);
    }
    const Measured found = measure(scaled);
    EXPECT_EQ(found.validity, expected.validity) << exponent;
    for (std::size_t s = 0; s < expected.lower.size() && std::abs(exponent) <= 300; ++s)
    {
      EXPECT_EQ(std::ldexp(found.lower[s], -3 * exponent), expected.lower[s]);
    }
  }
}

TEST(JacobianBounds, DegenerateSpansAreNeverValid)
{
  std::mt19937 random(12);
  const Block block = cubicBlock(random, { 3, 3, 3 }, 0.1);
  const auto changed = [&](auto&& change) {
    Block other = block;
    forEach(block.counts(), [&](const Ijk& i) { change(i, other, other.points.data() + 3 * block.at(i)); });
    return measure(other);
  };
  // An edge, a face, everything to a point; a flat volume.
  const auto copyOf = [&](double* x, const Ijk& i) {
    const double* from = block.points.data() + 3 * block.at(i);
    std::copy(from, from + 3, x);
  };
  const Measured edge = changed([&](const Ijk& i, Block&, double* x) {
    if (i[1] == 0)
    {
      copyOf(x, { 0, 0, i[2] });
    }
  });
  forEach({ 3, 1, 3 }, [&](const Ijk& i) { EXPECT_NE(edge.at(i[0] + 9 * i[2]), Validity::Valid); });
  const Measured face = changed([&](const Ijk& i, Block&, double* x) {
    if (i[1] == 0)
    {
      copyOf(x, { 0, 0, 0 });
    }
  });
  forEach({ 3, 1, 3 }, [&](const Ijk& i) { EXPECT_NE(face.at(i[0] + 9 * i[2]), Validity::Valid); });
  EXPECT_EQ(changed([&](const Ijk&, Block&, double* x) { copyOf(x, { 0, 0, 0 }); }).report.invalid, 27);
  EXPECT_EQ(changed([&](const Ijk&, Block&, double* x) { x[1] = 0.75; }).report.invalid, 27);
  // Only numbers that underflow make it flat: that is no proof.
  const Measured thin = changed([&](const Ijk&, Block&, double* x) {
    x[0] = std::ldexp(x[0], 200);
    x[1] = std::ldexp(x[1], 200);
    x[2] = std::ldexp(x[2], -1000);
  });
  EXPECT_EQ(thin.report.invalid, 0);
}

TEST(JacobianBounds, DepthOnlyDecidesMore)
{
  std::mt19937 random(13);
  const Block block = cubicBlock(random, { 12, 12, 12 }, 0.35);
  Index before = std::numeric_limits<Index>::max();
  for (const int depth : { 0, 2, 6, 24 })
  {
    JacobianOptions options;
    options.maxDepth = depth;
    const Measured measured = measure(block, options);
    EXPECT_LE(measured.report.undecided, before);
    before = measured.report.undecided;
    if (depth == 0)
    {
      EXPECT_GT(before, 0);
    }
  }
  EXPECT_EQ(before, 0);
}

TEST(JacobianBounds, KeepsTheFirstWitnesses)
{
  std::mt19937 random(16);
  const Block block = cubicBlock(random, { 12, 12, 12 }, 0.6);
  const Measured all = measure(block);
  ASSERT_GT(all.report.invalid, 20);
  JacobianOptions options;
  options.maxWitnesses = 10;
  const JacobianReport some = jacobianBounds(block.view(), "block", options, {}, scrambledExecution(37));
  EXPECT_EQ(some.invalid, all.report.invalid);
  ASSERT_EQ(some.witnesses.size(), 10U);
  for (std::size_t w = 0; w < some.witnesses.size(); ++w)
  {
    EXPECT_EQ(some.witnesses[w].span, all.report.witnesses[w].span);
  }
}

TEST(JacobianBounds, RefusesWhatItCannotMeasure)
{
  std::mt19937 random(14);
  Block block = cubicBlock(random, { 2, 2, 2 }, 0.1);
  JacobianOptions options;
  options.maxDepth = MaxJacobianDepth + 1;
  EXPECT_THROW(jacobianBounds(block.view(), "block", options), Error);
  Execution run;
  run.progress = [](double) { return false; };
  EXPECT_THROW(jacobianBounds(block.view(), "block", {}, {}, run), Aborted);
  block.points[3 * block.at({ 1, 2, 3 }) + 1] = std::numeric_limits<double>::quiet_NaN();
  try
  {
    jacobianBounds(block.view(), "block 7", {});
    FAIL();
  }
  catch (const Error& error)
  {
    EXPECT_STREQ(error.what(), "block 7: control point (1, 2, 3) is not finite");
  }
  // Differences that overflow are no crash and no verdict.
  Block huge = cubicBlock(random, { 2, 2, 2 }, 0.1);
  for (double& x : huge.points)
  {
    x = x > 1.0 ? 1.7e308 : -1.7e308;
  }
  EXPECT_EQ(measure(huge).report.undecided, 8);
}
