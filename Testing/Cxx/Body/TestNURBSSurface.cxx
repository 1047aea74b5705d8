// SPDX-License-Identifier: BSD-3-Clause
#include "Body/NURBSSurface.h"
#include "Body/TrimRegion.h"
#include "Support/BodyCases.h"

#include <Eigen/Geometry>

#include <gtest/gtest.h>

#include <functional>

using namespace bodycases;
using namespace bsv;

namespace
{

/// Derivative `order` of B-spline i at t, by the recursion from the definition.
double basisFunction(const std::vector<double>& knots, int i, int degree, int order, double t)
{
  if (degree == 0)
  {
    return order == 0 && knots[i] <= t && t < knots[i + 1] ? 1.0 : 0.0;
  }
  const double left = knots[i + degree] - knots[i];
  const double right = knots[i + degree + 1] - knots[i + 1];
  double value = 0.0;
  if (order > 0)
  {
    value += left > 0.0 ? degree / left * basisFunction(knots, i, degree - 1, order - 1, t) : 0.0;
    value -= right > 0.0 ? degree / right * basisFunction(knots, i + 1, degree - 1, order - 1, t) : 0.0;
    return value;
  }
  value += left > 0.0 ? (t - knots[i]) / left * basisFunction(knots, i, degree - 1, 0, t) : 0.0;
  value += right > 0.0 ? (knots[i + degree + 1] - t) / right * basisFunction(knots, i + 1, degree - 1, 0, t) : 0.0;
  return value;
}

/// Homogeneous derivative (a, b) by plain sums over all control points.
Eigen::Vector4d homogeneous(const NURBSSurface& s, int a, int b, double u, double v)
{
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  for (int j = 0; j < s.count(1); ++j)
  {
    const double nv = basisFunction(s.knots[1], j, s.degree[1], b, v);
    for (int i = 0; nv != 0.0 && i < s.count(0); ++i)
    {
      const double n = nv * basisFunction(s.knots[0], i, s.degree[0], a, u);
      const std::size_t at = std::size_t(j) * s.count(0) + i;
      const double w = s.rational() ? s.weights[at] : 1.0;
      sum += n * w * Eigen::Vector4d(s.points[at][0], s.points[at][1], s.points[at][2], 1.0);
    }
  }
  return sum;
}

void expectNear(const Vec3& a, const Vec3& b, double tolerance, const std::string& what)
{
  EXPECT_LE((a - b).norm(), tolerance) << what << ": " << a.transpose() << " instead of " << b.transpose();
}

void expectError(const std::function<void()>& action, const std::string& part)
{
  try
  {
    action();
    ADD_FAILURE() << "no error that says '" << part << "'";
  }
  catch (const Error& error)
  {
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

} // namespace

TEST(NURBSSurface, DerivativesFollowTheDefinition)
{
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (const std::array<int, 2> degree :
    { std::array<int, 2>{ 1, 1 }, { 1, 2 }, { 2, 1 }, { 3, 3 }, { 5, 4 }, { 9, 2 } })
  {
    for (const bool rational : { false, true })
    {
      const NURBSSurface s = bumpy(7, degree, { 3, 4 }, 0.3, rational);
      for (int n = 0; n < 20; ++n)
      {
        const double u = unit(random) * s.last(0);
        const double v = unit(random) * s.last(1);
        const SurfaceDerivatives at = evaluate(s, u, v);
        // x w = A: differentiated twice by the product rule and compared, so no quotient rule is repeated here.
        const auto A = [&](int a, int b) -> Vec3 { return homogeneous(s, a, b, u, v).head<3>(); };
        const auto w = [&](int a, int b) { return homogeneous(s, a, b, u, v)[3]; };
        const double scale = 1e-12 * (1.0 + A(2, 0).norm() + A(0, 2).norm() + A(1, 1).norm());
        expectNear(at.x * w(0, 0), A(0, 0), scale, "x");
        expectNear(at.u * w(0, 0) + at.x * w(1, 0), A(1, 0), scale, "u");
        expectNear(at.v * w(0, 0) + at.x * w(0, 1), A(0, 1), scale, "v");
        expectNear(at.uu * w(0, 0) + 2.0 * at.u * w(1, 0) + at.x * w(2, 0), A(2, 0), scale, "uu");
        expectNear(at.vv * w(0, 0) + 2.0 * at.v * w(0, 1) + at.x * w(0, 2), A(0, 2), scale, "vv");
        expectNear(at.uv * w(0, 0) + at.u * w(0, 1) + at.v * w(1, 0) + at.x * w(1, 1), A(1, 1), scale, "uv");
      }
    }
  }
}

TEST(NURBSSurface, HighestDegreeIsEvaluated)
{
  const NURBSSurface s = bumpy(3, { MaxSurfaceDegree, MaxSurfaceDegree }, { 1, 1 }, 0.0, false);
  // Control points on a lattice: a Bezier patch reproduces linear functions.
  for (const double t : { 0.0, 0.3, 0.99, 1.0 })
  {
    expectNear(evaluate(s, t, 1.0 - t).x, Vec3(t, 1.0 - t, 0.0), 1e-14, "x");
  }
}

TEST(NURBSSurface, SphereHasItsNormalAndCurvatureEverywhere)
{
  const double r = 2.5;
  const NURBSSurface s = sphere(r);
  for (int j = 0; j <= 16; ++j)
  {
    for (int i = 0; i <= 16; ++i)
    {
      const SurfaceGeometry at = surfaceGeometry(s, i / 4.0, j / 8.0);
      const bool pole = j == 0 || j == 16;
      EXPECT_EQ(at.degenerate, pole);
      const Vec3 n = at.point / r;
      EXPECT_NEAR(at.point.norm(), r, 1e-14);
      // At poles the limit is extrapolated.
      expectNear(at.normal, n, pole ? 1e-9 : 1e-13, "normal");
      const Eigen::Matrix3d expected = (Eigen::Matrix3d::Identity() - n * n.transpose()) / -r;
      EXPECT_LE((at.curvature - expected).norm(), pole ? 1e-4 : 1e-12);
      if (!pole)
      {
        EXPECT_NEAR(at.L * at.N - at.M * at.M, (at.E * at.G - at.F * at.F) / (r * r), 1e-11 * at.E * at.G);
        EXPECT_NEAR(at.L, -at.E / r, 1e-12 * at.E);
      }
      const SurfaceGeometry inward = surfaceGeometry(s, i / 4.0, j / 8.0, true);
      EXPECT_EQ(inward.normal, -at.normal);
      EXPECT_EQ(inward.curvature, -at.curvature);
      EXPECT_EQ(inward.L, -at.L);
    }
  }
}

TEST(NURBSSurface, CurvatureDoesNotDependOnParameters)
{
  const NURBSSurface s = bumpy(5, { 3, 4 }, { 3, 2 }, 0.5, true);
  // Parameters exchanged, and one of them stretched.
  NURBSSurface other;
  other.degree = { s.degree[1], s.degree[0] };
  other.knots = { s.knots[1], s.knots[0] };
  for (double& knot : other.knots[0])
  {
    knot = 3.0 * knot - 1.0;
  }
  for (int i = 0; i < s.count(0); ++i)
  {
    for (int j = 0; j < s.count(1); ++j)
    {
      other.points.push_back(s.points[std::size_t(j) * s.count(0) + i]);
      other.weights.push_back(s.weights[std::size_t(j) * s.count(0) + i]);
    }
  }
  for (int n = 1; n < 10; ++n)
  {
    const double u = 0.1 * n * s.last(0);
    const double v = 0.07 * n * s.last(1);
    const SurfaceGeometry a = surfaceGeometry(s, u, v);
    const SurfaceGeometry b = surfaceGeometry(other, 3.0 * v - 1.0, u, true);
    expectNear(a.point, b.point, 1e-14, "point");
    expectNear(a.normal, b.normal, 1e-12, "normal");
    EXPECT_LE((a.curvature - b.curvature).norm(), 1e-11 * a.curvature.norm());
    const SurfaceDerivatives d = evaluate(s, u, v);
    EXPECT_NEAR(d.u.dot(a.curvature * d.u), a.L, 1e-11 * (1.0 + std::abs(a.L)));
    EXPECT_NEAR(d.u.dot(a.curvature * d.v), a.M, 1e-11 * (1.0 + std::abs(a.M)));
  }
}

TEST(NURBSSurface, AreasAreThoseOfTheBodies)
{
  EXPECT_NEAR(patchArea({ "", sphere(2.0), {}, false }), 16.0 * Pi, 1e-8);
  EXPECT_NEAR(patchArea({ "", torus(3.0, 1.0), {}, false }), 12.0 * Pi * Pi, 1e-7);
  BodyPatch plate{ "", rectangle(10, 8), { circleLoop({ 5, 4 }, 3.0) }, false };
  EXPECT_NEAR(patchArea(plate), 9.0 * Pi, 1e-7);
  plate.loops.push_back(circleLoop({ 5, 4.5 }, 1.0));
  plate.loops.push_back(circleLoop({ 5, 4.5 }, 0.5));
  EXPECT_NEAR(patchArea(plate), (9.0 - 1.0 + 0.25) * Pi, 1e-7);
  std::reverse(plate.loops.begin(), plate.loops.end());
  EXPECT_NEAR(patchArea(plate), (9.0 - 1.0 + 0.25) * Pi, 1e-7);
  // The northern half of a sphere, cut by a line in its parameters.
  BodyPatch half{ "", sphere(1.0),
    { { { 1, { 0, 0, 1, 1 }, { { 0, 1 }, { 4, 1 } }, {} }, { 1, { 0, 0, 1, 1 }, { { 4, 2 }, { 0, 2 } }, {} } } },
    false };
  EXPECT_NEAR(patchArea(half), 2.0 * Pi, 1e-8);
}

TEST(NURBSSurface, TrimmingIsDecidedOnTheCurves)
{
  const TrimRegion ring({ circleLoop({ 0, 0 }, 2.0), circleLoop({ 0.5, 0 }, 1.0) });
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-2.2, 2.2);
  for (int n = 0; n < 20000; ++n)
  {
    // Every third point at the height of a joint of pieces, where a ray meets two of them.
    const Vec2 p(place(random), n % 3 == 0 ? double(n % 5 - 2) : place(random));
    EXPECT_EQ(ring.contains(p), p.norm() < 2.0 && (p - Vec2(0.5, 0)).norm() > 1.0) << p.transpose();
  }
  for (int n = 0; n < 400; ++n)
  {
    // Very close to the curve.
    const double angle = 0.1 + n;
    const Vec2 d(std::cos(angle), std::sin(angle));
    EXPECT_TRUE(ring.contains((2.0 - 1e-12) * d));
    EXPECT_FALSE(ring.contains((2.0 + 1e-12) * d));
  }
  EXPECT_TRUE(TrimRegion().contains({ 7, 7 }));
}

TEST(NURBSSurface, SmoothPiecesAreTheSurface)
{
  NURBSSurface s = bumpy(11, { 3, 2 }, { 4, 3 }, 0.4, true);
  // A kink in u: the third inner knot three times, with two control points more a row.
  const double kink = s.knots[0][5];
  NURBSSurface kinked = s;
  kinked.knots[0].insert(kinked.knots[0].begin() + 5, 2, kink);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  kinked.points.clear();
  kinked.weights.clear();
  for (int i = 0; i < kinked.count(0) * kinked.count(1); ++i)
  {
    kinked.points.push_back(Vec3(unit(random), unit(random), unit(random)));
    kinked.weights.push_back(0.5 + unit(random));
  }
  checkNURBSSurface(kinked, "kinked");
  const std::vector<NURBSSurface> pieces = smoothPieces(kinked);
  ASSERT_EQ(pieces.size(), 2u);
  EXPECT_EQ(smoothPieces(s).size(), 1u);
  for (const NURBSSurface& piece : pieces)
  {
    checkNURBSSurface(piece, "piece");
    for (int n = 0; n < 50; ++n)
    {
      const double u = piece.first(0) + unit(random) * (piece.last(0) - piece.first(0));
      const double v = unit(random) * piece.last(1);
      expectNear(evaluate(piece, u, v).x, evaluate(kinked, u, v).x, 1e-14, "point");
      expectNear(evaluate(piece, u, v).uu, evaluate(kinked, u, v).uu, 1e-10, "second derivative");
    }
  }
  EXPECT_EQ(pieces[0].last(0), kink);
  EXPECT_EQ(pieces[1].first(0), kink);
}

TEST(NURBSSurface, WrongPatchesAreRefusedByName)
{
  const NURBSSurface good = bumpy(1, { 2, 3 }, { 2, 2 }, 0.1, true);
  const auto broken = [&](const std::function<void(NURBSSurface&)>& damage, const std::string& part) {
    NURBSSurface s = good;
    damage(s);
    expectError([&] { checkNURBSSurface(s, "wing"); }, part);
    expectError([&] { checkNURBSSurface(s, "wing"); }, "wing");
  };
  broken([](NURBSSurface& s) { s.degree[0] = 0; }, "degree 0");
  broken([](NURBSSurface& s) { s.degree[1] = 26; }, "degree 26");
  broken([](NURBSSurface& s) { s.knots[0].clear(); }, "too few");
  broken([](NURBSSurface& s) { std::swap(s.knots[1][4], s.knots[1][5]); }, "smaller");
  broken([](NURBSSurface& s) { s.knots[1][4] = NAN; }, "not finite");
  broken([](NURBSSurface& s) { s.knots[0].assign(s.knots[0].size(), 1.0); }, "empty");
  broken([](NURBSSurface& s) { s.points.pop_back(); }, "control points instead of");
  broken([](NURBSSurface& s) { s.points[2][1] = INFINITY; }, "control point 2 is not finite");
  broken([](NURBSSurface& s) { s.weights.pop_back(); }, "weights instead of");
  broken([](NURBSSurface& s) { s.weights[3] = 0.0; }, "weight 3");
  BodyPatch patch{ "", good, { {} }, false };
  expectError([&] { checkBodyPatch(patch, "wing"); }, "trimming loop 0 is empty");
  patch.loops = { circleLoop({ 0, 0 }, 1.0) };
  patch.loops[0][0].points.pop_back();
  expectError([&] { checkBodyPatch(patch, "wing"); }, "curve 0 of trimming loop 0");
}
