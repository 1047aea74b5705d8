// SPDX-License-Identifier: BSD-3-Clause
// Evaluation of one block against a second implementation, against polynomials and against its own derivatives.
#include "Support/VolumeCases.h"
#include "Volume/BezierSegments.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

using namespace bsv;
using namespace bsvtest;

namespace
{

/// The textbook recursion (Piegl and Tiller (2.5), (2.9)), one basis function at a time, in extended precision. The
/// span is given because on a knot the side matters.
long double basisByRecursion(const std::vector<double>& t, int i, int p, int order, int span, long double u)
{
  const auto over = [](long double a, long double b) { return b == 0.0L ? 0.0L : a / b; };
  const long double t0 = t[i];
  const long double t1 = t[i + p + 1];
  if (p == 0)
  {
    return order == 0 && i == span ? 1.0L : 0.0L;
  }
  if (order > 0)
  {
    return p *
      (over(basisByRecursion(t, i, p - 1, order - 1, span, u), t[i + p] - t0) -
        over(basisByRecursion(t, i + 1, p - 1, order - 1, span, u), t1 - t[i + 1]));
  }
  return over(u - t0, t[i + p] - t0) * basisByRecursion(t, i, p - 1, 0, span, u) +
    over(t1 - u, t1 - t[i + 1]) * basisByRecursion(t, i + 1, p - 1, 0, span, u);
}

std::vector<double> randomKnots(std::mt19937& random, int degree, bool clamped)
{
  std::uniform_real_distribution<double> step(0.1, 1.0);
  std::uniform_int_distribution<int> multiplicity(1, degree);
  std::vector<double> knots;
  double at = step(random);
  const auto add = [&](int times) {
    knots.insert(knots.end(), times, at);
    at += step(random);
  };
  const auto end = [&]() {
    for (int i = 0; i < (clamped ? 1 : degree + 1); ++i)
    {
      add(clamped ? degree + 1 : 1);
    }
  };
  end();
  for (int i = 0; i < 3; ++i)
  {
    add(multiplicity(random));
  }
  end();
  return knots;
}

double randomIn(std::mt19937& random, double a, double b)
{
  return std::uniform_real_distribution<double>(a, b)(random);
}

} // namespace

TEST(BSplineVolume, ClampedIntegerKnots)
{
  EXPECT_EQ(clampedIntegerKnots(1), (std::vector<double>{ 0, 0, 0, 0, 1, 1, 1, 1 }));
  EXPECT_EQ(clampedIntegerKnots(3), (std::vector<double>{ 0, 0, 0, 0, 1, 2, 3, 3, 3, 3 }));
  EXPECT_THROW(clampedIntegerKnots(0), Error);
}

TEST(BSplineVolume, MatchesTheRecursionForAllDegreesAndDerivatives)
{
  std::mt19937 random(1);
  for (int degree = 1; degree <= MaxDegree; ++degree)
  {
    for (const bool clamped : { true, false })
    {
      const std::array<int, 3> degrees{ degree, 1 + degree % MaxDegree, 1 + (degree + 3) % 4 };
      std::array<std::vector<double>, 3> knots;
      for (int d = 0; d < 3; ++d)
      {
        knots[d] = randomKnots(random, degrees[d], clamped);
      }
      const Block block = randomBlock(random, degrees, knots, false);
      checkBSplineVolume(block.view(), "block");
      const Ijk n = block.counts();
      for (int trial = 0; trial < 12; ++trial)
      {
        std::array<int, 3> span{};
        std::array<int, 3> order{};
        Vec3 uvw;
        for (int d = 0; d < 3; ++d)
        {
          const std::vector<int> spans = nonEmptySpans(degrees[d], knots[d]);
          span[d] = spans[std::uniform_int_distribution<std::size_t>(0, spans.size() - 1)(random)];
          const double a = knots[d][span[d]];
          const double b = knots[d][span[d] + 1];
          // On the first knot, at the end of the domain, or inside the span.
          uvw[d] = trial % 3 == 0 ? a : trial % 3 == 1 && span[d] == spans.back() ? b : randomIn(random, a, b);
          order[d] = std::uniform_int_distribution<int>(0, degrees[d] + 1)(random);
        }
        std::array<std::vector<long double>, 3> basis;
        for (int d = 0; d < 3; ++d)
        {
          for (int i = 0; i < n[d]; ++i)
          {
            basis[d].push_back(basisByRecursion(knots[d], i, degrees[d], order[d], span[d], uvw[d]));
          }
        }
        std::array<long double, 3> expected{};
        long double size = 0;
        forEach(n, [&](const Ijk& i) {
          const long double weight = basis[0][i[0]] * basis[1][i[1]] * basis[2][i[2]];
          size += std::abs(weight);
          for (int c = 0; c < 3; ++c)
          {
            expected[c] += weight * block.points[3 * block.at(i) + c];
          }
        });
        const Vec3 x = evaluate(block.view(), uvw, order);
        for (int c = 0; c < 3; ++c)
        {
          // Points are in [-1, 1], so the sum of the weights' sizes bounds the terms.
          EXPECT_NEAR(x[c], static_cast<double>(expected[c]), 1e-14 * (1.0 + static_cast<double>(size)))
            << "degree " << degree << " trial " << trial;
        }
      }
    }
  }
}

// Marsden: control points that are blossoms of a polynomial give that polynomial. For u^p the blossom is the product of
// the p inner knots.
TEST(BSplineVolume, ReproducesPolynomials)
{
  std::mt19937 random(2);
  for (int degree = 1; degree <= MaxDegree; ++degree)
  {
    std::array<std::vector<double>, 3> knots;
    for (auto& k : knots)
    {
      k = randomKnots(random, degree, true);
      for (double& t : k)
      {
        t /= k.back();
      }
    }
    Block block = randomBlock(random, { degree, degree, degree }, knots);
    forEach(block.counts(), [&](const Ijk& i) {
      std::array<double, 3> power{ 1.0, 1.0, 1.0 };
      for (int d = 0; d < 3; ++d)
      {
        for (int j = 1; j <= degree; ++j)
        {
          power[d] *= knots[d][i[d] + j];
        }
      }
      double* x = block.points.data() + 3 * block.at(i);
      x[0] = power[0];
      x[1] = power[1] * power[2];
      x[2] = power[0] * power[1] * power[2];
    });
    const auto value = [&](double u, int order) {
      double result = order <= degree ? std::pow(u, degree - order) : 0.0;
      for (int j = 0; j < order; ++j)
      {
        result *= degree - j;
      }
      return result;
    };
    for (int trial = 0; trial < 20; ++trial)
    {
      const Vec3 u(
        randomIn(random, knots[0][0], 1), randomIn(random, knots[1][0], 1), randomIn(random, knots[2][0], 1));
      const int a = trial % 3, b = trial / 3 % 3, c = trial / 9 % 2;
      const Vec3 x = evaluate(block.view(), u, { a, b, c });
      const double uFactor = value(u[0], a), vFactor = value(u[1], b), wFactor = value(u[2], c);
      // Second derivatives divide by products of two knot distances, which are >= 0.1 / 15 here.
      const double tolerance = 1e-13 * std::pow(150.0, a + b + c);
      EXPECT_NEAR(x[0], b == 0 && c == 0 ? uFactor : 0.0, tolerance);
      EXPECT_NEAR(x[1], a == 0 ? vFactor * wFactor : 0.0, tolerance);
      EXPECT_NEAR(x[2], uFactor * vFactor * wFactor, tolerance);
    }
  }
}

TEST(BSplineVolume, ClampedEndsInterpolate)
{
  std::mt19937 random(3);
  for (int degree = 1; degree <= MaxDegree; ++degree)
  {
    const std::vector<double> knots = randomKnots(random, degree, true);
    const Block block = randomBlock(random, { degree, degree, degree }, { knots, knots, knots });
    const Ijk n = block.counts();
    for (int corner = 0; corner < 8; ++corner)
    {
      Vec3 u;
      Ijk i;
      for (int d = 0; d < 3; ++d)
      {
        u[d] = cornerSide(corner, d) ? knots.back() : knots.front();
        i[d] = cornerSide(corner, d) ? n[d] - 1 : 0;
      }
      EXPECT_EQ(evaluate(block.view(), u), Vec3(Eigen::Map<const Vec3>(block.points.data() + 3 * block.at(i))));
    }
  }
}

TEST(BSplineVolume, RefusesWhatIsOutside)
{
  std::mt19937 random(4);
  const std::vector<double> knots = clampedIntegerKnots(2);
  const Block block = randomBlock(random, { 3, 3, 3 }, { knots, knots, knots });
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(evaluate(block.view(), { -0.1, 0, 0 }), Error);
  EXPECT_THROW(evaluate(block.view(), { 0, 2.1, 0 }), Error);
  EXPECT_THROW(evaluate(block.view(), { 0, 0, nan }), Error);
  EXPECT_THROW(evaluate(block.view(), { 0, 0, 0 }, { 0, -1, 0 }), Error);
}

TEST(BSplineVolume, CheckFindsBadKnots)
{
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> good = clampedIntegerKnots(2);
  const auto message = [&](int degree, const std::vector<double>& knots) {
    BSplineVolume volume;
    volume.degree[1] = degree;
    volume.knots = { good, knots, good };
    try
    {
      checkBSplineVolume(volume, "block 'a'");
      return std::string();
    }
    catch (const Error& error)
    {
      return std::string(error.what());
    }
  };
  EXPECT_EQ(message(3, good), "");
  EXPECT_EQ(message(0, good), "block 'a': degree 0 is not in 1..8 in direction v");
  EXPECT_EQ(message(9, good), "block 'a': degree 9 is not in 1..8 in direction v");
  EXPECT_EQ(message(3, { 0, 0, 0, 1, 1, 1, 1 }), "block 'a': 7 knots are too few for degree 3 in direction v");
  EXPECT_EQ(message(1, { 0, 0, nan, 1 }), "block 'a': knot 2 is not finite in direction v");
  EXPECT_EQ(message(1, { 0, 0, 2, 1 }), "block 'a': knot 3 is smaller than the one before it in direction v");
  EXPECT_EQ(message(1, { 0, 1, 1, 2 }), "block 'a': the knots' range is empty in direction v");
  EXPECT_EQ(message(1, { 0, 0, 1, 1, 2, 2 }), "block 'a': knot 2 is repeated more than 1 times in direction v");
}

TEST(BSplineVolume, RationalArcsLieOnTheirCircle)
{
  // Quarter of a thick pipe: quadratic in the angle with middle weight 1/sqrt(2), radius 1 + v, height w.
  Block pipe;
  pipe.volume.degree = { 2, 1, 1 };
  pipe.volume.knots = { std::vector<double>{ 0, 0, 0, 1, 1, 1 }, { 0, 0, 1, 1 }, { 0, 0, 1, 1 } };
  forEach(pipe.counts(), [&](const Ijk& i) {
    const double r = 1.0 + i[1];
    pipe.points.insert(pipe.points.end(), { i[0] < 2 ? r : 0.0, i[0] > 0 ? r : 0.0, double(i[2]) });
    pipe.weights.push_back(i[0] == 1 ? std::sqrt(0.5) : 1.0);
  });
  checkBSplineVolume(pipe.view(), "pipe");
  std::mt19937 random(11);
  for (int n = 0; n < 100; ++n)
  {
    const Vec3 uvw(randomIn(random, 0, 1), randomIn(random, 0, 1), randomIn(random, 0, 1));
    const auto at = [&](int a, int b, int c) { return evaluate(pipe.view(), uvw, { a, b, c }); };
    const auto flat = [](const Vec3& x) { return Vec3(x[0], x[1], 0.0); };
    const double r = 1.0 + uvw[1];
    const Vec3 x = flat(at(0, 0, 0));
    EXPECT_NEAR(x.norm(), r, 1e-15 * 8);
    EXPECT_NEAR(at(0, 0, 0)[2], uvw[2], 1e-15);
    // Derivatives of x.x = (1 + v)^2.
    EXPECT_NEAR(x.dot(at(1, 0, 0)), 0.0, 1e-14);
    EXPECT_NEAR(at(1, 0, 0).squaredNorm() + x.dot(at(2, 0, 0)), 0.0, 1e-13);
    EXPECT_NEAR(3.0 * at(1, 0, 0).dot(at(2, 0, 0)) + x.dot(at(3, 0, 0)), 0.0, 1e-12);
    EXPECT_NEAR(x.dot(at(0, 1, 0)), r, 1e-14);
    EXPECT_NEAR(at(1, 0, 0).dot(at(0, 1, 0)) + x.dot(at(1, 1, 0)), 0.0, 1e-13);
    EXPECT_NEAR(at(1, 1, 1).norm(), 0.0, 1e-13);
  }

  pipe.weights[5] = 0.0;
  EXPECT_THROW(checkBSplineVolume(pipe.view(), "pipe"), Error);
}

TEST(BSplineVolume, BezierWeightsGiveTheSameCurveAndMirrorExactly)
{
  std::mt19937 random(12);
  for (int degree = 1; degree <= MaxDegree; ++degree)
  {
    for (const bool clamped : { true, false })
    {
      const std::vector<double> knots = randomKnots(random, degree, clamped);
      std::vector<double> mirrored;
      for (auto k = knots.rbegin(); k != knots.rend(); ++k)
      {
        mirrored.push_back(-*k);
      }
      const int size = degree + 1;
      std::vector<double> weights(size * size);
      std::vector<double> other(size * size);
      for (const int span : nonEmptySpans(degree, knots))
      {
        bezierWeights(degree, knots, span, weights.data());
        bezierWeights(degree, mirrored, static_cast<int>(knots.size()) - 2 - span, other.data());
        for (int n = 0; n < size * size; ++n)
        {
          ASSERT_EQ(weights[n], other[size * size - 1 - n]);
        }
        // Bernstein polynomials times the weights are the basis functions.
        const double s = randomIn(random, 0.0, 1.0);
        const double u = knots[span] + s * (knots[span + 1] - knots[span]);
        for (int i = 0; i < size; ++i)
        {
          double sum = 0.0;
          double binomial = 1.0;
          for (int j = 0; j < size; ++j)
          {
            sum += binomial * std::pow(s, j) * std::pow(1.0 - s, degree - j) * weights[j * size + i];
            binomial = binomial * (degree - j) / (j + 1);
          }
          ASSERT_NEAR(sum, double(basisByRecursion(knots, span - degree + i, degree, 0, span, u)), 1e-12);
        }
      }
    }
  }
}
