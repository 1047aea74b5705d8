// SPDX-License-Identifier: BSD-3-Clause
// Smoothness of joins: pairs of blocks with known jumps, in all orientations; converted meshes; found interfaces.
#include "Quality/Smoothness.h"
#include "Support/ConversionCases.h"
#include "Support/MeshCases.h"
#include "Support/ThreadRanks.h"
#include "Support/VolumeCases.h"
#include "Volume/VolumeInterfaces.h"

#include <Eigen/Dense>

#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <tuple>

using namespace bsv;
using namespace bsvtest;

namespace
{

constexpr double Pi = 3.14159265358979323846;

double worst(const Join& join, JumpKind kind)
{
  return join.worst[int(kind)].value;
}

//------------------------------------------------------------------------------
// Blocks
//------------------------------------------------------------------------------

/// Bezier block of a polynomial map of [0, 1]^3, by interpolation; exact up to rounding if the degrees suffice.
Block bezierBlock(const std::array<int, 3>& degree, const std::function<Vec3(const Vec3&)>& map)
{
  Block block;
  block.volume.degree = degree;
  std::array<Eigen::MatrixXd, 3> inverse;
  for (int d = 0; d < 3; ++d)
  {
    const int p = degree[d];
    block.volume.knots[d].assign(p + 1, 0.0);
    block.volume.knots[d].insert(block.volume.knots[d].end(), p + 1, 1.0);
    Eigen::MatrixXd basis(p + 1, p + 1);
    for (int i = 0; i <= p; ++i)
    {
      double binomial = 1.0;
      for (int j = 0; j <= p; ++j)
      {
        basis(i, j) = binomial * std::pow(double(i) / p, j) * std::pow(1.0 - double(i) / p, p - j);
        binomial *= double(p - j) / (j + 1);
      }
    }
    inverse[d] = basis.inverse();
  }
  const Ijk n = block.counts();
  block.points.resize(std::size_t(3) * n[0] * n[1] * n[2]);
  forEach(n, [&](const Ijk& i) {
    Vec3 sum = Vec3::Zero();
    forEach(n, [&](const Ijk& j) {
      const Vec3 x = map(Vec3(double(j[0]) / degree[0], double(j[1]) / degree[1], double(j[2]) / degree[2]));
      sum += inverse[0](i[0], j[0]) * inverse[1](i[1], j[1]) * inverse[2](i[2], j[2]) * x;
    });
    Eigen::Map<Vec3>(block.points.data() + 3 * block.at(i)) = sum;
  });
  return block;
}

/// Inserts a knot (Boehm 1980). Polynomial blocks only.
Block insertKnot(const Block& block, int d, double u)
{
  const int p = block.volume.degree[d];
  const std::vector<double>& t = block.volume.knots[d];
  const int span = int(std::upper_bound(t.begin(), t.end(), u) - t.begin()) - 1;
  Block result;
  result.volume = block.volume;
  result.volume.knots[d].insert(result.volume.knots[d].begin() + span + 1, u);
  const Ijk n = result.counts();
  result.points.resize(std::size_t(3) * n[0] * n[1] * n[2]);
  forEach(n, [&](const Ijk& i) {
    const auto old = [&](int k) {
      Ijk at = i;
      at[d] = std::min(std::max(k, 0), block.counts()[d] - 1);
      return Vec3(block.points.data() + 3 * block.at(at));
    };
    const int k = i[d];
    const double f = k <= span - p ? 1.0 : k > span ? 0.0 : (u - t[k]) / (t[k + p] - t[k]);
    // The shared points of two pieces come from here: exact copies where nothing is mixed.
    Eigen::Map<Vec3>(result.points.data() + 3 * result.at(i)) = f == 1.0 ? old(k)
      : f == 0.0                                                         ? old(k - 1)
                                                                         : Vec3(f * old(k) + (1.0 - f) * old(k - 1));
  });
  return result;
}

/// Control points [first, last] of direction d, with their knots.
Block piece(const Block& block, int d, int first, int last)
{
  Block result;
  result.volume = block.volume;
  const std::vector<double>& t = block.volume.knots[d];
  result.volume.knots[d].assign(t.begin() + first, t.begin() + last + block.volume.degree[d] + 2);
  forEach(result.counts(), [&](Ijk i) {
    i[d] += first;
    const double* x = block.points.data() + 3 * block.at(i);
    result.points.insert(result.points.end(), x, x + 3);
  });
  return result;
}

/// Two blocks; face 1 of the first meets face 0 of the second with code 0.
struct Pair
{
  Block a, b;
};

/// Cuts a block at the inner parameter u of direction 0 into two that are clamped there.
Pair cut(Block block, double u)
{
  const int p = block.volume.degree[0];
  const auto multiplicity = [&] { return std::count(block.volume.knots[0].begin(), block.volume.knots[0].end(), u); };
  while (multiplicity() < p)
  {
    block = insertKnot(block, 0, u);
  }
  const std::vector<double>& t = block.volume.knots[0];
  const int first = int(std::lower_bound(t.begin(), t.end(), u) - t.begin()) - 1;
  Pair pair{ piece(block, 0, 0, first), piece(block, 0, first, block.counts()[0] - 1) };
  // Both ends had p equal knots and one that belongs to the other piece.
  pair.a.volume.knots[0].back() = u;
  pair.b.volume.knots[0].front() = u;
  return pair;
}

/// Control points near the Greville points of the knots, so that layers are not degenerate.
Block wavyBlock(std::mt19937& random, const std::array<int, 3>& degree, const std::array<std::vector<double>, 3>& knots)
{
  Block block;
  block.volume.degree = degree;
  block.volume.knots = knots;
  std::uniform_real_distribution<double> noise(-0.15, 0.15);
  forEach(block.counts(), [&](const Ijk& i) {
    for (int d = 0; d < 3; ++d)
    {
      double sum = 0.0;
      for (int j = 1; j <= degree[d]; ++j)
      {
        sum += knots[d][i[d] + j];
      }
      block.points.push_back(sum / degree[d] + noise(random));
    }
  });
  return block;
}

/// Non-uniform, linear in v, with a line across which derivatives in v are discontinuous. All differences are exact in
/// binary.
Block mixedBlock(unsigned seed)
{
  std::mt19937 random(seed);
  return wavyBlock(random, { 3, 1, 4 },
    { { { 0, 0, 0, 0, 1, 2.5, 3, 3, 3, 3 }, { 0, 0, 1, 2.5, 2.5 }, { 0, 0, 0, 0, 0, 1, 1, 3, 3, 3, 3, 3 } } });
}

void moveLayer(Block& block, int layer, const Vec3& by)
{
  forEach(block.counts(), [&](const Ijk& i) {
    if (i[0] == layer)
    {
      Eigen::Map<Vec3>(block.points.data() + 3 * block.at(i)) += by;
    }
  });
}

void scaleKnots(Block& block, int d, double factor)
{
  for (double& t : block.volume.knots[d])
  {
    t *= factor;
  }
}

//------------------------------------------------------------------------------
// Measuring
//------------------------------------------------------------------------------

struct Turned
{
  std::vector<Block> blocks;
  Interface contact;

  std::vector<BSplineVolume> volumes() const
  {
    std::vector<BSplineVolume> views;
    for (const Block& block : blocks)
    {
      views.push_back(block.view());
      checkBSplineVolume(views.back(), "block");
    }
    return views;
  }
};

/// The pair with both blocks stored in other orientations; the contact follows from the corners.
Turned turned(const Pair& pair, const Orientation& oa, const Orientation& ob)
{
  Turned result{ { reoriented(pair.a, oa), reoriented(pair.b, ob) }, {} };
  const Ijk ones{ 2, 2, 2 };
  const auto face = [](const Orientation& o, int side) {
    const int d = int(std::find(o.order.begin(), o.order.end(), 0) - o.order.begin());
    return 2 * d + (o.flip[d] ? 1 - side : side);
  };
  Interface& contact = result.contact;
  contact.blockA = 0;
  contact.blockB = 1;
  contact.faceA = face(oa, 1);
  contact.faceB = face(ob, 0);
  for (int code = 0; code < 8; ++code)
  {
    bool same = true;
    for (int c = 0; c < 4; ++c)
    {
      const auto m = mapFacePoint(code, c % 2, c / 2, 1, 1);
      const Ijk x = oa.old(facePosition(ones, contact.faceA, c % 2, c / 2), ones);
      const Ijk y = ob.old(facePosition(ones, contact.faceB, m[0], m[1]), ones);
      same = same && x[1] == y[1] && x[2] == y[2];
    }
    contact.orientation = same ? code : contact.orientation;
  }
  return result;
}

SmoothnessOptions noWall()
{
  SmoothnessOptions options;
  options.isWall = [](int, int) { return false; };
  return options;
}

Join measured(const Turned& pair, const SmoothnessOptions& options = noWall())
{
  return measureSmoothness(pair.volumes(), { pair.contact }, options).joins.at(0);
}

Join measured(const Pair& pair, const SmoothnessOptions& options = noWall())
{
  return measured(turned(pair, {}, {}), options);
}

double angleOf(const Vec3& a, const Vec3& b)
{
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180.0 / Pi;
}

/// The jumps at relative position (s, t) of the untwisted pair, by evaluate().
Jumps evaluated(const Pair& pair, double s, double t)
{
  const std::array<BSplineVolume, 2> v{ pair.a.view(), pair.b.view() };
  std::array<Vec3, 2> uvw;
  std::array<double, 2> length;
  for (int side = 0; side < 2; ++side)
  {
    const auto at = [&](int d, double f) {
      const std::vector<double>& knots = v[side].knots[d];
      const double low = knots[v[side].degree[d]], high = knots[v[side].count(d)];
      return f == 1.0 ? high : low + f * (high - low);
    };
    uvw[side] = Vec3(at(0, side == 0 ? 1.0 : 0.0), at(1, s), at(2, t));
    const std::vector<int> spans = nonEmptySpans(v[side].degree[0], v[side].knots[0]);
    const int span = side == 0 ? spans.back() : spans.front();
    length[side] = v[side].knots[0][span + 1] - v[side].knots[0][span];
  }
  const auto derivative = [&](
                            int side, const std::array<int, 3>& order) { return evaluate(v[side], uvw[side], order); };
  const Vec3 n[2] = { derivative(0, { 1, 0, 0 }), derivative(1, { 1, 0, 0 }) };
  const double scale = std::max(n[0].norm(), n[1].norm());
  Jumps jumps;
  jumps[int(JumpKind::Gap)] = (derivative(0, { 0, 0, 0 }) - derivative(1, { 0, 0, 0 })).norm();
  jumps[int(JumpKind::NormalS)] =
    angleOf(derivative(0, { 0, 1, 0 }).cross(n[0]), derivative(1, { 0, 1, 0 }).cross(n[1]));
  jumps[int(JumpKind::NormalT)] =
    angleOf(derivative(0, { 0, 0, 1 }).cross(n[0]), derivative(1, { 0, 0, 1 }).cross(n[1]));
  jumps[int(JumpKind::Layer)] = std::max(jumps[int(JumpKind::NormalS)], jumps[int(JumpKind::NormalT)]);
  jumps[int(JumpKind::Kink)] = angleOf(n[0], n[1]);
  jumps[int(JumpKind::C1)] = (n[0] - n[1]).norm() / scale;
  jumps[int(JumpKind::C2)] =
    std::min(length[0], length[1]) * (derivative(0, { 2, 0, 0 }) - derivative(1, { 2, 0, 0 })).norm() / scale;
  return jumps;
}

/// The maxima are not exceeded by any of many points, and hardly undershot by the best of them.
void expectMaxima(const Pair& pair, const Join& join)
{
  constexpr int N = 75;
  // evaluate() looks to the right of knots; this looks to their left, too.
  std::vector<double> places;
  for (int i = 0; i <= N; ++i)
  {
    places.push_back(double(i) / N);
    places.push_back(std::max(double(i) / N - 1e-9, 0.0));
  }
  Jumps dense{};
  for (const double t : places)
  {
    for (const double s : places)
    {
      const Jumps here = evaluated(pair, s, t);
      for (int kind = 0; kind < JumpKinds; ++kind)
      {
        dense[kind] = std::max(dense[kind], here[kind]);
      }
    }
  }
  for (int kind = 0; kind < JumpKinds; ++kind)
  {
    const double rounding = 1e-11;
    EXPECT_GE(join.worst[kind].value, dense[kind] * (1.0 - 1e-9) - rounding) << "kind " << kind;
    // Spans are sampled at 1/30 of their length or finer: the samples miss (1/60)^2 / 2 times the relative second
    // derivative, for which 60 is ample.
    EXPECT_LE(join.worst[kind].value, dense[kind] * (1.0 + 1e-2) + rounding) << "kind " << kind;
  }
}

/// All that is measured, without what depends on numbering and orientation; the normal jumps in ascending order.
std::vector<std::vector<double>> canonical(const std::vector<Join>& joins)
{
  std::vector<std::vector<double>> all;
  for (const Join& join : joins)
  {
    const auto tuple = [](const Jumps& v) {
      const auto normals = std::minmax({ v[int(JumpKind::NormalS)], v[int(JumpKind::NormalT)] });
      std::vector<double> list(v.begin(), v.end());
      list[int(JumpKind::NormalS)] = normals.first;
      list[int(JumpKind::NormalT)] = normals.second;
      return list;
    };
    Jumps maxima;
    for (int kind = 0; kind < JumpKinds; ++kind)
    {
      maxima[kind] = join.worst[kind].value;
    }
    std::vector<std::vector<double>> samples;
    for (std::size_t n = 0; n < join.points.size(); ++n)
    {
      Jumps jumps;
      for (int kind = 0; kind < JumpKinds; ++kind)
      {
        jumps[kind] = join.values[kind][n];
      }
      samples.push_back({ join.points[n][0], join.points[n][1], join.points[n][2] });
      const auto rest = tuple(jumps);
      samples.back().insert(samples.back().end(), rest.begin(), rest.end());
    }
    std::sort(samples.begin(), samples.end());
    std::vector<double> line = tuple(maxima);
    line.push_back(double(join.continuity) + (join.crease ? 10 : 0));
    for (const auto& sample : samples)
    {
      line.insert(line.end(), sample.begin(), sample.end());
    }
    all.push_back(line);
  }
  std::sort(all.begin(), all.end());
  return all;
}

/// A quadratic map of space, far from affine on the unit cube.
Vec3 curved(const Vec3& x)
{
  return Vec3(x[0] + 0.2 * x[1] * x[2] - 0.15 * x[0] * x[0], x[1] + 0.3 * x[0] * x[0] - 0.1 * x[2],
    x[2] + 0.25 * x[0] * x[1] + 0.1 * x[1] * x[1]);
}

/// Blocks of `map` over x in [-1, 0], and over [0, 1] after the change `join` of the parameters.
Pair joined(const std::function<Vec3(const Vec3&)>& map, const std::function<Vec3(const Vec3&)>& change,
  const std::array<int, 3>& degree)
{
  return { bezierBlock(degree, [&](const Vec3& u) { return map(Vec3(u[0] - 1.0, u[1], u[2])); }),
    bezierBlock(degree, [&](const Vec3& u) { return map(change(u)); }) };
}

/// Some turns of both blocks in which every pair of faces and every code occurs.
template <typename Check>
void inAllOrientations(const Pair& pair, Check&& check)
{
  std::set<std::tuple<int, int, int>> seen;
  for (const Orientation& oa : allOrientations())
  {
    for (const Orientation& ob : allOrientations())
    {
      const Turned t = turned(pair, oa, ob);
      if (seen.emplace(t.contact.faceA, t.contact.faceB, t.contact.orientation).second)
      {
        check(t);
      }
    }
  }
  EXPECT_EQ(seen.size(), 6u * 6u * 8u);
}

} // namespace

//------------------------------------------------------------------------------
// Pairs with known jumps
//------------------------------------------------------------------------------

TEST(Smoothness, CutVolumeIsC2InAllOrientations)
{
  // Inside a span, and on a simple knot of a cubic.
  for (const double u : { 1.5, 2.5 })
  {
    const Pair pair = cut(mixedBlock(3), u);
    const auto reference = canonical({ measured(pair) });
    inAllOrientations(pair, [&](const Turned& t) {
      const Join join = measured(t);
      EXPECT_EQ(worst(join, JumpKind::Gap), 0.0);
      EXPECT_LT(worst(join, JumpKind::Layer), 1e-12);
      EXPECT_LT(worst(join, JumpKind::Kink), 1e-12);
      EXPECT_LT(worst(join, JumpKind::C1), 1e-13);
      EXPECT_LT(worst(join, JumpKind::C2), 1e-12);
      EXPECT_EQ(join.continuity, JoinContinuity::C2);
      EXPECT_EQ(canonical({ join }), reference);
    });
  }
}

TEST(Smoothness, C1Only)
{
  Pair pair = cut(mixedBlock(4), 1.5);
  const Vec3 by(0.03, -0.02, 0.01);
  moveLayer(pair.b, 2, by);
  const Join plain = measured(pair);
  expectMaxima(pair, plain);
  // The second derivative at a clamped end weighs the third layer by p (p - 1) / (h1 (h1 + h2)); spans are 0.5 | 1,
  // 0.5.
  const JumpMaximum& place = plain.worst[int(JumpKind::C2)];
  const double n = evaluate(pair.a.view(), place.uvw[0], { 1, 0, 0 }).norm();
  EXPECT_NEAR(place.value, 0.5 * (3 * 2 / (1.0 * 1.5)) * by.norm() / n, 1e-11);
  const auto reference = canonical({ plain });
  inAllOrientations(pair, [&](const Turned& t) {
    const Join join = measured(t);
    EXPECT_LT(worst(join, JumpKind::C1), 1e-13);
    EXPECT_LT(worst(join, JumpKind::Layer), 1e-12);
    EXPECT_EQ(join.continuity, JoinContinuity::C1);
    EXPECT_EQ(canonical({ join }), reference);
  });
}

TEST(Smoothness, G1WithPrescribedReparametrisation)
{
  // n_B = -(a n_A + b s): smooth for the layers through s only.
  const double a = 2.0;
  const double b = 1.0;
  const auto change = [&](const Vec3& u) { return Vec3(a * u[0], u[1] + b * u[0], u[2]); };
  const Pair flat = joined([](const Vec3& x) { return x; }, change, { 1, 1, 1 });
  const Join join = measured(flat);
  EXPECT_LT(worst(join, JumpKind::NormalS), 1e-12);
  EXPECT_NEAR(worst(join, JumpKind::NormalT), std::atan(0.5) * 180.0 / Pi, 1e-12);
  EXPECT_NEAR(worst(join, JumpKind::Kink), std::atan(0.5) * 180.0 / Pi, 1e-12);
  EXPECT_NEAR(worst(join, JumpKind::C1), std::sqrt(2.0 / 5.0), 1e-14);

  const Pair pair = joined(curved, change, { 4, 2, 2 });
  const Join plain = measured(pair);
  expectMaxima(pair, plain);
  const auto reference = canonical({ plain });
  inAllOrientations(pair, [&](const Turned& t) {
    const Join turnedJoin = measured(t);
    const double s = worst(turnedJoin, JumpKind::NormalS), n = worst(turnedJoin, JumpKind::NormalT);
    // The direction that was v, along which the layers are smooth, may be either axis of face A.
    const int faceA = t.contact.faceA;
    const Vec3 along = evaluate(t.blocks[0].view(), turnedJoin.worst[0].uvw[0],
      { faceAxis(faceA, 0) == 0 ? 1 : 0, faceAxis(faceA, 0) == 1 ? 1 : 0, faceAxis(faceA, 0) == 2 ? 1 : 0 });
    const bool first = std::abs(along[1]) > std::abs(along[2]);
    EXPECT_LT(first ? s : n, 1e-11);
    EXPECT_GT(first ? n : s, 10.0);
    EXPECT_GT(worst(turnedJoin, JumpKind::C1), 0.5);
    EXPECT_EQ(turnedJoin.continuity, JoinContinuity::G1);
    EXPECT_EQ(canonical({ turnedJoin }), reference);
  });

  // Stretched only: both families are smooth, derivatives are not.
  const Pair stretched =
    joined(curved, [](const Vec3& u) { return Vec3((1.0 + u[1]) * u[0], u[1], u[2]); }, { 2, 4, 2 });
  const Join both = measured(stretched);
  EXPECT_LT(worst(both, JumpKind::Layer), 1e-11);
  EXPECT_NEAR(worst(both, JumpKind::C1), 0.5, 1e-12);
  EXPECT_EQ(both.continuity, JoinContinuity::G1);
}

TEST(Smoothness, KinkOfSevenDegrees)
{
  const double angle = 7.0 * Pi / 180.0;
  const Eigen::Matrix3d turn =
    (Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()) * Eigen::AngleAxisd(0.4, Vec3::UnitY())).toRotationMatrix();
  const Pair pair = joined([&](const Vec3& x) { return Vec3(turn * x); },
    [&](const Vec3& u) { return Vec3(std::cos(angle) * u[0], u[1] + std::sin(angle) * u[0], u[2]); }, { 3, 2, 1 });
  inAllOrientations(pair, [&](const Turned& t) {
    const Join join = measured(t);
    const auto normals = std::minmax({ worst(join, JumpKind::NormalS), worst(join, JumpKind::NormalT) });
    EXPECT_LT(normals.first, 1e-12);
    EXPECT_NEAR(normals.second, 7.0, 1e-12);
    EXPECT_NEAR(worst(join, JumpKind::Kink), 7.0, 1e-12);
    EXPECT_NEAR(worst(join, JumpKind::C1), 2.0 * std::sin(angle / 2.0), 1e-14);
    EXPECT_LT(worst(join, JumpKind::Gap), 1e-15);
  });
  // Both families kink if the other side is turned about the diagonal of the interface.
  const Eigen::AngleAxisd hinge(angle, Vec3(0, 1, 1).normalized());
  const Pair hinged = joined([](const Vec3& x) { return x; },
    [&](const Vec3& u) { return Vec3(u[0] * (hinge * Vec3::UnitX()) + Vec3(0, u[1], u[2])); }, { 1, 1, 1 });
  const Join join = measured(hinged);
  EXPECT_EQ(join.continuity, JoinContinuity::C0);
  EXPECT_NEAR(worst(join, JumpKind::Kink), 7.0, 1e-12);
  // s x n with n turned out of the plane: tan is that of 7 degrees over sqrt 2.
  EXPECT_NEAR(worst(join, JumpKind::NormalS), std::atan(std::tan(angle) / std::sqrt(2.0)) * 180.0 / Pi, 1e-12);
  EXPECT_NEAR(worst(join, JumpKind::NormalT), worst(join, JumpKind::NormalS), 1e-12);
}

TEST(Smoothness, GapOfOneBillionth)
{
  Pair pair = cut(mixedBlock(5), 1.5);
  const Vec3 by = 1e-9 * Vec3(2, -1, 2) / 3.0;
  for (int layer = 0; layer < pair.b.counts()[0]; ++layer)
  {
    moveLayer(pair.b, layer, by);
  }
  inAllOrientations(pair, [&](const Turned& t) {
    const Join join = measured(t);
    // Coordinates are at most 3.
    EXPECT_NEAR(worst(join, JumpKind::Gap), 1e-9, 8 * 3 * std::numeric_limits<double>::epsilon());
    EXPECT_EQ(join.continuity, JoinContinuity::Open);
    EXPECT_LT(worst(join, JumpKind::C1), 1e-13);
  });
  EXPECT_EQ(turned(pair, {}, {}).contact.orientation, 0);
  // The gap does not keep the faces from being found.
  EXPECT_EQ(findVolumeInterfaces(turned(pair, {}, {}).volumes()).size(), 1u);
}

TEST(Smoothness, MaximaAreRefined)
{
  // One control point of the interface moves: the gap is the product of two basis functions.
  Pair pair = cut(mixedBlock(6), 1.5);
  const Ijk moved{ 0, 1, 3 };
  Eigen::Map<Vec3>(pair.b.points.data() + 3 * pair.b.at(moved)) += Vec3(0, 0, 1e-3);
  double expected = 1e-3;
  for (int d = 1; d < 3; ++d)
  {
    // The basis function as a curve, its maximum by nested grids.
    Block curve;
    curve.volume.degree = { pair.b.volume.degree[d], 1, 1 };
    curve.volume.knots = { pair.b.volume.knots[d], { 0, 0, 1, 1 }, { 0, 0, 1, 1 } };
    forEach(curve.counts(), [&](const Ijk& i) {
      curve.points.insert(curve.points.end(), { i[0] == moved[d] ? 1.0 : 0.0, 0.0, 0.0 });
    });
    double low = curve.volume.knots[0].front(), high = curve.volume.knots[0].back(), best = 0.0;
    for (int round = 0; round < 12; ++round)
    {
      double at = low;
      const double step = (high - low) / 100;
      for (int n = 0; n <= 100; ++n)
      {
        const double u = std::min(low + n * step, high);
        const double value = evaluate(curve.view(), Vec3(u, 0, 0))[0];
        at = value > best ? u : at;
        best = std::max(best, value);
      }
      low = std::max(low, at - step);
      high = std::min(high, at + step);
    }
    expected *= best;
  }
  for (const int parts : { 2, 3, 5 })
  {
    SmoothnessOptions options = noWall();
    options.samplesPerSpan = parts;
    const Join join = measured(pair, options);
    const JumpMaximum& gap = join.worst[int(JumpKind::Gap)];
    EXPECT_NEAR(gap.value, expected, 1e-10 * expected + 1e-15) << parts;
    const Vec3 x = evaluate(pair.a.view(), gap.uvw[0]), y = evaluate(pair.b.view(), gap.uvw[1]);
    EXPECT_NEAR((x - y).norm(), gap.value, 1e-14);
    EXPECT_LT((0.5 * (x + y) - gap.point).norm(), 1e-14);
    EXPECT_EQ(*std::max_element(join.spanMaxima[0].begin(), join.spanMaxima[0].end()), gap.value);
  }
  expectMaxima(pair, measured(pair));
}

TEST(Smoothness, UnequalDegreesAndKnots)
{
  // The same map in other degrees, other in-face scales of the knots, and more spans on one side.
  const auto left = [](const Vec3& u) { return curved(Vec3(u[0] - 1.0, u[1], u[2])); };
  Pair pair{ bezierBlock({ 2, 2, 2 }, left), bezierBlock({ 3, 4, 2 }, curved) };
  pair.a = insertKnot(insertKnot(pair.a, 1, 0.375), 2, 0.5);
  pair.b = insertKnot(insertKnot(pair.b, 1, 0.7), 1, 0.375);
  scaleKnots(pair.b, 1, 4.0);
  scaleKnots(pair.b, 2, 0.3);
  Join join = measured(pair);
  EXPECT_EQ(join.spans, (std::array<int, 2>{ 3, 2 }));
  EXPECT_LT(worst(join, JumpKind::Gap), 1e-14);
  EXPECT_LT(worst(join, JumpKind::C2), 1e-11);
  EXPECT_EQ(join.continuity, JoinContinuity::C2);

  // A factor common to both sides changes nothing; wider knots on one side halve its derivatives.
  Pair bent = pair;
  moveLayer(bent.b, 2, Vec3(0.1, 0, 0.05));
  const double c2 = worst(measured(bent), JumpKind::C2);
  EXPECT_GT(c2, 0.1);
  scaleKnots(bent.a, 0, 8.0);
  scaleKnots(bent.b, 0, 8.0);
  EXPECT_NEAR(worst(measured(bent), JumpKind::C2), c2, 1e-12);
  scaleKnots(pair.b, 0, 2.0);
  join = measured(pair);
  EXPECT_NEAR(worst(join, JumpKind::C1), 0.5, 1e-12);
  EXPECT_EQ(join.continuity, JoinContinuity::G1);
  expectMaxima(pair, join);
}

TEST(Smoothness, UnclampedKnots)
{
  std::mt19937 random(7);
  const std::vector<double> uniform{ -3, -2, -1, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9 };
  const Block whole = wavyBlock(random, { 3, 3, 1 }, { { uniform, uniform, { 0, 0, 1, 1 } } });
  // Domain 0..6 cut at 3: each piece keeps the control points of its spans.
  const Pair pair{ piece(whole, 0, 0, 5), piece(whole, 0, 3, 8) };
  const Turned t = turned(pair, {}, {});
  const Join join = measured(t);
  EXPECT_LT(worst(join, JumpKind::Gap), 1e-14);
  EXPECT_LT(worst(join, JumpKind::C2), 1e-13);
  EXPECT_EQ(join.continuity, JoinContinuity::C2);
  const auto found = findVolumeInterfaces(t.volumes());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].faceA, 1);
  EXPECT_EQ(found[0].faceB, 0);
  const auto reference = canonical({ join });
  for (const Orientation& o : allOrientations())
  {
    EXPECT_EQ(canonical({ measured(turned(pair, o, {})) }), reference);
  }
}

TEST(Smoothness, RationalQuarters)
{
  // Two quarters of a cylinder shell. Each quarter circle (1,0) (1,1) (0,1) with weights 1, sqrt(1/2), 1 has the speed
  // sqrt 2 at both ends, so they join C1. There the angle phi has phi'' = 2 sqrt 2 - 2 at the start and, by symmetry,
  // the opposite at the end: C2 is 2 (2 sqrt 2 - 2) / sqrt 2.
  const auto quarter = [](const Vec3& from, const Vec3& to) {
    Block block;
    block.volume.degree = { 2, 1, 1 };
    block.volume.knots = { { { 0, 0, 0, 1, 1, 1 }, { 0, 0, 1, 1 }, { 0, 0, 1, 1 } } };
    forEach(block.counts(), [&](const Ijk& i) {
      const Vec3 x = (i[0] == 0 ? from : i[0] == 2 ? to : Vec3(from + to)) * (1.0 + i[1]) + Vec3(0, 0, i[2]);
      block.points.insert(block.points.end(), x.data(), x.data() + 3);
      block.weights.push_back(i[0] == 1 ? std::sqrt(0.5) : 1.0);
    });
    return block;
  };
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY();
  const Pair pair{ quarter(x, y), quarter(y, -x) };
  const Join plain = measured(pair);
  EXPECT_NEAR(worst(plain, JumpKind::C2), 4.0 - 2.0 * std::sqrt(2.0), 1e-13);
  expectMaxima(pair, plain);
  const auto reference = canonical({ plain });
  inAllOrientations(pair, [&](const Turned& t) {
    const Join join = measured(t);
    EXPECT_LT(worst(join, JumpKind::C1), 1e-14);
    EXPECT_LT(worst(join, JumpKind::Layer), 1e-13);
    EXPECT_EQ(join.continuity, JoinContinuity::C1);
    EXPECT_EQ(canonical({ join }), reference);
  });
  // The same nets without weights are parabolas, with speed 2 instead of sqrt 2; a rational volume taken as one would
  // pass for this.
  Pair polynomial = pair;
  polynomial.a.weights.clear();
  EXPECT_NEAR(worst(measured(polynomial), JumpKind::C1), 1.0 - std::sqrt(0.5), 1e-14);
}

//------------------------------------------------------------------------------
// Multi-block volumes
//------------------------------------------------------------------------------

TEST(Smoothness, ConvertedMeshes)
{
  // Regular: C2 everywhere; the edges of the box are creases and nothing else is worth a word.
  const auto box =
    conversioncases::convert(meshcases::cutBox({ 6, 5, 4 }, { { { 3 }, { 2 }, { 2 } } }, meshcases::wavy).mesh());
  auto interfaces = [](const conversioncases::Converted& converted) { return findVolumeInterfaces(converted.volumes); };
  const SmoothnessResult boxed = measureSmoothness(box.volumes, interfaces(box));
  ASSERT_EQ(boxed.joins.size(), 12u + 24u + 24u); // interfaces, borders in the six sides, edges of the box
  for (const Join& join : boxed.joins)
  {
    EXPECT_TRUE(join.crease || join.continuity == JoinContinuity::C2) << worst(join, JumpKind::C2);
  }
  EXPECT_TRUE(boxed.curves.empty());
  for (const BlockSmoothness& block : boxed.blocks)
  {
    EXPECT_EQ(block.continuity, JoinContinuity::C2);
  }

  for (const int valence : { 3, 5, 6 })
  {
    constexpr int Cells = 5;
    auto mesh = meshcases::ring(valence, Cells, { { 0, 1, 2, 3 }, { 3, 4, 5 } }).apply(meshcases::wavy);
    const auto ring = conversioncases::convert(mesh.mesh());
    const SmoothnessResult result = measureSmoothness(ring.volumes, interfaces(ring));
    ASSERT_EQ(result.curves.size(), 2u);
    EXPECT_EQ(result.curves[0].valence, valence);
    int atAxis = 0;
    for (const Join& join : result.joins)
    {
      for (int side = 0; side < 4 && !join.border(); ++side)
      {
        if (join.valences[side] != valence)
        {
          continue;
        }
        ++atAxis;
        // From the third span on all control points are regular.
        for (int t = 0; t < join.spans[1]; ++t)
        {
          for (int s = 0; s < join.spans[0]; ++s)
          {
            const int away = side == 0 ? s : side == 1 ? join.spans[0] - 1 - s : side == 2 ? t : join.spans[1] - 1 - t;
            const double c2 = join.spanMaxima[int(JumpKind::C2)][s + join.spans[0] * t];
            if (away >= 3)
            {
              EXPECT_LT(c2, 1e-9);
            }
            else if (away == 0)
            {
              EXPECT_GT(c2, 1e-3);
            }
          }
        }
        EXPECT_LT(join.continuity, JoinContinuity::C2);
        // The layers along the axis turn by |180 - 720 / valence| degrees if the map did not distort them; those that
        // it pierces are nearly smooth.
        const double turn = std::abs(180.0 - 720.0 / valence);
        EXPECT_GT(std::max(worst(join, JumpKind::NormalS), worst(join, JumpKind::NormalT)), 0.5 * turn);
        EXPECT_LT(worst(join, JumpKind::Layer), 0.1 * turn);
        EXPECT_EQ(join.boundToKink, (std::array<bool, 2>{ side >= 2, side < 2 }));
      }
    }
    EXPECT_EQ(atAxis, 2 * valence);
    // The worst is at the axis, and the curve says so.
    double onCurves = 0.0;
    for (const ExtraordinaryCurve& curve : result.curves)
    {
      ASSERT_EQ(curve.points.size(), curve.normalJump.size());
      onCurves = std::max(onCurves, *std::max_element(curve.normalJump.begin(), curve.normalJump.end()));
    }
    EXPECT_LE(onCurves, std::max(result.worst[int(JumpKind::NormalS)], result.worst[int(JumpKind::NormalT)]));
  }

  const auto ball = conversioncases::convert(meshcases::ball(3, 3).mesh());
  const SmoothnessResult balls = measureSmoothness(ball.volumes, interfaces(ball));
  EXPECT_EQ(balls.curves.size(), 20u);
  for (const ExtraordinaryCurve& curve : balls.curves)
  {
    EXPECT_EQ(curve.valence, 3);
  }
}

// A knot repeated as often as the degree parts its block: what is measured is what blocks of their own would give.
TEST(Smoothness, RepeatedKnotsJoinParts)
{
  // Cut in u, then in v at a knot that both halves have: the quarters, a kink between those of A.
  const std::vector<double> u{ 0, 0, 0, 0, 1, 2, 2, 2, 3, 3, 3, 3 }, v{ 0, 0, 0, 1, 1, 2.5, 4, 4, 4 };
  std::mt19937 random(11);
  const Block whole = wavyBlock(random, { 3, 2, 2 }, { { u, v, { 0, 0, 0, 1, 1, 1 } } });
  const auto parts = [](const Block& block, int d, int knot) {
    const int degree = block.volume.degree[d], last = block.counts()[d] - 1;
    std::array<Block, 2> halves{ piece(block, d, 0, knot - 1), piece(block, d, knot - 1, last) };
    // Clamped there.
    halves[0].volume.knots[d].back() = halves[1].volume.knots[d].front() = block.volume.knots[d][knot];
    EXPECT_EQ(
      halves[0].volume.knots[d].size() + halves[1].volume.knots[d].size(), block.volume.knots[d].size() + degree + 2);
    return halves;
  };
  const auto [a, b] = parts(whole, 0, 5);
  const auto [a0, a1] = parts(a, 1, 3);
  const auto [b0, b1] = parts(b, 1, 3);
  const std::vector<BSplineVolume> quarters{ a0.view(), a1.view(), b0.view(), b1.view() };
  const std::vector<Interface> between{ { 0, 1, 2, 0, 0, {}, {} }, { 1, 1, 3, 0, 0, {}, {} }, { 0, 3, 1, 2, 0, {}, {} },
    { 2, 3, 3, 2, 0, {}, {} } };
  SmoothnessOptions options;
  const SmoothnessResult expected = measureSmoothness(quarters, between, options);
  const auto reference = canonical(expected.joins);
  ASSERT_GT(reference.size(), 4u);

  const SmoothnessResult one = measureSmoothness({ whole.view() }, {}, options);
  EXPECT_EQ(canonical(one.joins), reference);
  EXPECT_EQ(one.worst, expected.worst);
  EXPECT_TRUE(one.joins.front().inner());
  const JumpMaximum& kink = one.joins.front().worst[int(JumpKind::Kink)];
  EXPECT_LT((evaluate(whole.view(), kink.uvw[0]) - kink.point).norm(), 1e-14);

  // Two halves, the second with v reversed, in any numbering.
  for (const bool exchanged : { false, true })
  {
    const Block turned = reoriented(b, { { 0, 1, 2 }, { false, true, false } });
    const std::vector<BSplineVolume> halves = exchanged ? std::vector<BSplineVolume>{ turned.view(), a.view() }
                                                        : std::vector<BSplineVolume>{ a.view(), turned.view() };
    const Interface contact{ exchanged ? 1 : 0, 1, exchanged ? 0 : 1, 0, 2, {}, {} };
    EXPECT_EQ(canonical(measureSmoothness(halves, { contact }, options).joins), reference);
  }

  // A neighbour without the knot: both stay whole.
  const Block other =
    wavyBlock(random, { 3, 2, 2 }, { { { 0, 0, 0, 0, 1, 1, 1, 1 }, { 0, 0, 0, 4, 4, 4 }, { 0, 0, 0, 1, 1, 1 } } });
  const SmoothnessResult unequal =
    measureSmoothness({ b.view(), other.view() }, { { 0, 1, 1, 0, 0, {}, {} } }, noWall());
  EXPECT_EQ(unequal.joins.size(), 1u);
}

TEST(Smoothness, BlocksThatMeetThemselves)
{
  // A ring of one block is C2 where it closes; its inner face may be collapsed to the axis.
  for (const double radius : { 0.5, 0.0 })
  {
    BlockComplexOptions options;
    options.allowDegenerate = true;
    const auto ring = conversioncases::convert(meshcases::oGrid({ 9, 4, 3 }, radius).mesh(), {}, options);
    const auto interfaces = findVolumeInterfaces(ring.volumes);
    ASSERT_FALSE(interfaces.empty());
    const SmoothnessResult result = measureSmoothness(ring.volumes, interfaces);
    for (const Join& join : result.joins)
    {
      for (const JumpMaximum& jump : join.worst)
      {
        EXPECT_TRUE(std::isfinite(jump.value) && jump.point.allFinite());
      }
    }
    for (std::size_t n = 0; n < interfaces.size(); ++n)
    {
      EXPECT_EQ(interfaces[n].blockA, interfaces[n].blockB);
      if (radius > 0.0)
      {
        EXPECT_EQ(result.joins[n].continuity, JoinContinuity::C2);
      }
    }
  }
}

TEST(Smoothness, RankingAndTotals)
{
  auto mesh = meshcases::ring(5, 3, { { 0, 1, 2 }, { 2, 3, 4 } }).apply(meshcases::wavy);
  const auto ring = conversioncases::convert(mesh.mesh());
  const SmoothnessResult result = measureSmoothness(ring.volumes, findVolumeInterfaces(ring.volumes));
  ASSERT_EQ(result.ranking.size(), result.joins.size());
  EXPECT_EQ(std::set<int>(result.ranking.begin(), result.ranking.end()).size(), result.joins.size());
  for (std::size_t n = 1; n < result.ranking.size(); ++n)
  {
    const Join& before = result.joins[result.ranking[n - 1]];
    const Join& after = result.joins[result.ranking[n]];
    EXPECT_LE(before.crease, after.crease);
    if (before.crease == after.crease)
    {
      EXPECT_LE(before.continuity, after.continuity);
      if (before.continuity == JoinContinuity::C0 && after.continuity == JoinContinuity::C0)
      {
        EXPECT_GE(worst(before, JumpKind::Layer), worst(after, JumpKind::Layer));
      }
    }
  }
  for (std::size_t b = 0; b < result.blocks.size(); ++b)
  {
    Jumps expected{};
    for (const Join& join : result.joins)
    {
      for (int kind = 0; kind < JumpKinds; ++kind)
      {
        const bool mine = join.sides[0].block == int(b) || join.sides[1].block == int(b);
        expected[kind] = mine && !join.crease ? std::max(expected[kind], join.worst[kind].value) : expected[kind];
      }
    }
    EXPECT_EQ(result.blocks[b].worst, expected);
    for (int kind = 0; kind < JumpKinds; ++kind)
    {
      EXPECT_LE(expected[kind], result.worst[kind]);
    }
  }
}

TEST(Smoothness, WallBorders)
{
  // A cube around which the wall k = 0 of six blocks goes, and its conversion: no creases, small jumps.
  const auto body = conversioncases::convert(meshcases::sphereBody(4, { 1.0, 1.3, 1.7 }).mesh());
  SmoothnessOptions options;
  options.isWall = [](int, int face) { return face == 4; };
  const auto interfaces = findVolumeInterfaces(body.volumes);
  const SmoothnessResult result = measureSmoothness(body.volumes, interfaces, options);
  ASSERT_EQ(interfaces.size(), 12u);
  ASSERT_EQ(result.joins.size(), 24u);
  for (std::size_t j = 12; j < 24; ++j)
  {
    const Join& join = result.joins[j];
    ASSERT_TRUE(join.border());
    EXPECT_FALSE(join.crease);
    EXPECT_EQ(worst(join, JumpKind::Gap), 0.0);
    EXPECT_EQ(worst(join, JumpKind::NormalT), 0.0);
    EXPECT_EQ(join.samples[1], 1);
    // The normals of the two faces at the worst place, from their derivatives.
    const JumpMaximum& place = join.worst[int(JumpKind::NormalS)];
    std::array<Vec3, 2> normals;
    for (int side = 0; side < 2; ++side)
    {
      const BSplineVolume& v = body.volumes[join.sides[side].block];
      normals[side] = evaluate(v, place.uvw[side], { 1, 0, 0 }).cross(evaluate(v, place.uvw[side], { 0, 1, 0 }));
      EXPECT_LT((evaluate(v, place.uvw[side]) - place.point).norm(), 1e-14);
    }
    EXPECT_NEAR(angleOf(normals[0], normals[1]), place.value, 1e-10);
    EXPECT_GT(place.value, 0.0);
  }

  // A bent plate of two blocks: 40 degrees are a crease, or one that is reported, or one that the net says.
  const double turn = 40.0 * Pi / 180.0;
  const Pair plate = joined([](const Vec3& x) { return x; },
    [&](const Vec3& u) { return Vec3(std::cos(turn) * u[0], std::sin(turn) * u[0] + u[1], u[2]); }, { 3, 3, 3 });
  const Turned t = turned(plate, {}, {});
  SmoothnessOptions onFloor;
  onFloor.isWall = [](int, int face) { return face == 2; };
  const auto border = [&](const SmoothnessOptions& o) {
    return measureSmoothness(t.volumes(), { t.contact }, o).joins.at(1);
  };
  EXPECT_NEAR(worst(border(onFloor), JumpKind::NormalS), 40.0, 1e-11);
  EXPECT_NEAR(worst(border(onFloor), JumpKind::Kink), 40.0, 1e-11);
  EXPECT_TRUE(border(onFloor).crease);
  EXPECT_TRUE(measureSmoothness(t.volumes(), { t.contact }, onFloor).joins.at(0).atCrease);
  onFloor.creaseAngle = 41.0;
  EXPECT_FALSE(measureSmoothness(t.volumes(), { t.contact }, onFloor).joins.at(0).atCrease);
  EXPECT_FALSE(border(onFloor).crease);
  std::vector<unsigned char> rules(64, static_cast<unsigned char>(ControlPointRule::Crease));
  onFloor.rules = { rules.data(), rules.data() };
  EXPECT_TRUE(border(onFloor).crease);
  rules.assign(64, static_cast<unsigned char>(ControlPointRule::Regular));
  EXPECT_FALSE(border(onFloor).crease);
}

TEST(Smoothness, SameBitsForAnyNumberingOrientationAndThreads)
{
  meshcases::MeshCase mesh = meshcases::ball(3, 2).apply(meshcases::wavy);
  meshcases::declareAll(mesh);
  const auto all = [](meshcases::MeshCase& m, const Execution& run) {
    const auto converted = conversioncases::convert(m.mesh());
    return canonical(measureSmoothness(converted.volumes, findVolumeInterfaces(converted.volumes), {}, run).joins);
  };
  const auto reference = all(mesh, {});
  EXPECT_EQ(all(mesh, conversioncases::twoThreads()), reference);
  for (unsigned seed = 1; seed <= 4; ++seed)
  {
    meshcases::MeshCase other = mesh;
    meshcases::shuffle(other, seed, seed % 2 == 0);
    EXPECT_EQ(all(other, {}), reference) << "seed " << seed;
  }
}

/// A maximum, exactly.
std::vector<double> numbers(const JumpMaximum& jump)
{
  std::vector<double> list{ jump.value };
  for (const Vec3& x : { jump.point, jump.uvw[0], jump.uvw[1] })
  {
    list.insert(list.end(), x.data(), x.data() + 3);
  }
  return list;
}

/// The part of `all` that a rank should have.
void expectPart(const SmoothnessResult& part, const SmoothnessResult& all, const std::vector<int>& owners, int rank)
{
  EXPECT_EQ(part.ranking, all.ranking);
  EXPECT_EQ(part.worst, all.worst);
  ASSERT_EQ(part.blocks.size(), all.blocks.size());
  for (std::size_t b = 0; b < all.blocks.size(); ++b)
  {
    EXPECT_EQ(part.blocks[b].worst, all.blocks[b].worst);
    EXPECT_EQ(part.blocks[b].worstJoin, all.blocks[b].worstJoin);
    EXPECT_EQ(part.blocks[b].continuity, all.blocks[b].continuity);
  }
  ASSERT_EQ(part.joins.size(), all.joins.size());
  for (std::size_t j = 0; j < all.joins.size(); ++j)
  {
    const Join& mine = part.joins[j];
    const Join& join = all.joins[j];
    const bool own = owners[join.sides[0].block] == rank;
    EXPECT_EQ(
      std::tie(mine.crease, mine.atCrease, mine.continuity, mine.boundToKink, mine.valences, mine.spans, mine.samples),
      std::tie(join.crease, join.atCrease, join.continuity, join.boundToKink, join.valences, join.spans, join.samples));
    EXPECT_EQ(mine.points, own ? join.points : std::vector<Vec3>());
    for (int kind = 0; kind < JumpKinds; ++kind)
    {
      EXPECT_EQ(numbers(mine.worst[kind]), numbers(join.worst[kind]));
      EXPECT_EQ(mine.values[kind], own ? join.values[kind] : std::vector<double>());
      EXPECT_EQ(mine.spanMaxima[kind], own ? join.spanMaxima[kind] : std::vector<double>());
    }
  }
  ASSERT_EQ(part.curves.size(), all.curves.size());
  for (std::size_t c = 0; c < all.curves.size(); ++c)
  {
    const ExtraordinaryCurve& curve = all.curves[c];
    const bool own = owners[curve.block] == rank;
    EXPECT_EQ(part.curves[c].valence, curve.valence);
    EXPECT_EQ(part.curves[c].points, own ? curve.points : std::vector<Vec3>());
    EXPECT_EQ(part.curves[c].normalJump, own ? curve.normalJump : std::vector<double>());
  }
}

TEST(Smoothness, SameBitsOnAnyRanks)
{
  std::mt19937 random(5);
  const auto ring =
    conversioncases::convert(meshcases::ring(5, 3, { { 0, 1, 2, 3 }, { 3, 4, 5 } }).apply(meshcases::wavy).mesh());
  const auto body = conversioncases::convert(meshcases::sphereBody(3, { 1.0, 1.3, 1.7 }).mesh());
  for (const auto* converted : { &ring, &body })
  {
    std::vector<BSplineVolume> volumes = converted->volumes;
    // A rational block, which no longer fits its neighbours.
    const BSplineVolume& last = volumes.back();
    std::vector<double> weights(std::size_t(last.count(0)) * last.count(1) * last.count(2));
    std::generate(
      weights.begin(), weights.end(), [&] { return std::uniform_real_distribution<double>(0.5, 2.0)(random); });
    volumes.back().weights = weights.data();
    SmoothnessOptions options;
    options.isWall = [&](int block, int face) { return face >= 4 && block != 1; };
    const auto interfaces = findVolumeInterfaces(converted->volumes);
    const SmoothnessResult all = measureSmoothness(volumes, interfaces, options);
    ASSERT_FALSE(all.curves.empty());
    ASSERT_GT(all.joins.size(), interfaces.size());
    for (int size = 1; size <= 5; ++size)
    {
      for (const std::vector<int>& owners : distributions(random, volumes.size(), size))
      {
        const auto errors = onRanks(size, [&](const Execution& run) {
          const int rank = run.ranks->rank();
          const auto found = findVolumeInterfaces(partOf(converted->volumes, owners, rank), {}, run);
          ASSERT_EQ(found.size(), interfaces.size());
          for (std::size_t n = 0; n < found.size(); ++n)
          {
            EXPECT_EQ(std::tie(found[n].blockA, found[n].faceA, found[n].blockB, found[n].faceB, found[n].orientation),
              std::tie(interfaces[n].blockA, interfaces[n].faceA, interfaces[n].blockB, interfaces[n].faceB,
                interfaces[n].orientation));
          }
          expectPart(measureSmoothness(partOf(volumes, owners, rank), found, options, run), all, owners, rank);
        });
        EXPECT_EQ(errors, std::vector<std::string>(size));
      }
    }
  }
}

TEST(Smoothness, OnlyLayersAtTheJoinsTravel)
{
  std::mt19937 random(4);
  for (const int cells : { 15, 30 })
  {
    const Volumes lattice =
      cutLattice(random, { { { cells, cells }, { cells }, { cells } } }, { false, false, false }, false);
    const std::vector<BSplineVolume> volumes{ lattice.blocks[0].view(), lattice.blocks[1].view() };
    const auto errors = onRanks(2, [&](const Execution& run) {
      measureSmoothness(partOf(volumes, { 0, 1 }, run.ranks->rank()), lattice.interfaces, {}, run);
      // Three layers of points of the interface and of the four borders at it, and what is said of all 21 joins.
      const double points = (cells + 3.0) * (cells + 3.0) + 4 * (cells + 3.0);
      EXPECT_LT(run.ranks->receivedBytes(), 3 * 24 * points + 21 * 1000);
    });
    EXPECT_EQ(errors, std::vector<std::string>(2));
  }
}

TEST(Smoothness, ErrorsAndAbortsOfOneRankAreThoseOfAll)
{
  const Volumes lattice = [] {
    std::mt19937 random(3);
    return cutLattice(random, { { { 2, 1 }, { 1, 3 }, { 2 } } }, { false, false, false }, false);
  }();
  std::vector<BSplineVolume> volumes;
  for (const Block& block : lattice.blocks)
  {
    volumes.push_back(block.view());
  }
  std::vector<double> broken = lattice.blocks[3].points;
  broken[7] = std::numeric_limits<double>::infinity();
  const std::vector<int> owners{ 2, 0, 2, 1 };
  const auto measure = [&](const Execution& run) {
    measureSmoothness(partOf(volumes, owners, run.ranks->rank()), lattice.interfaces, {}, run);
  };
  const auto stopped = onRanks(3, [&](Execution run) {
    run.progress = [&](double) { return run.ranks->rank() != 2; };
    EXPECT_THROW(run.ranks->together([&] { measure(run); }), Aborted);
  });
  EXPECT_EQ(stopped, std::vector<std::string>(3));
  volumes[3].points = broken.data();
  std::string serial;
  try
  {
    measureSmoothness(volumes, lattice.interfaces);
  }
  catch (const Error& error)
  {
    serial = error.what();
  }
  EXPECT_NE(serial.find("are not finite"), std::string::npos) << serial;
  EXPECT_EQ(onRanks(3, measure), std::vector<std::string>(3, serial));
}

//------------------------------------------------------------------------------
// Found interfaces
//------------------------------------------------------------------------------

TEST(VolumeInterfaces, AreThoseOfTheLattice)
{
  using Key = std::array<int, 5>;
  const auto keys = [](const std::vector<Interface>& interfaces) {
    std::set<Key> result;
    for (const Interface& i : interfaces)
    {
      const Key key{ i.blockA, i.faceA, i.blockB, i.faceB, i.orientation };
      const Key other{ i.blockB, i.faceB, i.blockA, i.faceA, inverseOrientation(i.orientation) };
      result.insert(std::min(key, other));
    }
    return result;
  };
  std::mt19937 random(11);
  for (int n = 0; n < 20; ++n)
  {
    const Volumes lattice =
      cutLattice(random, { { { 2, 1 }, { 1, 3 }, { 2, 2 } } }, { n % 2 == 1, n % 3 == 1, false }, false);
    std::vector<BSplineVolume> views;
    for (const Block& block : lattice.blocks)
    {
      views.push_back(block.view());
    }
    EXPECT_EQ(keys(findVolumeInterfaces(views)), keys(lattice.interfaces));
  }
}

TEST(VolumeInterfaces, TellThinLayersFromContacts)
{
  // A block whose opposite faces are 1e-6 apart, on another one.
  const Block thin = bezierBlock({ 1, 1, 1 }, [](const Vec3& u) { return Vec3(u[0] * 1e-6, u[1], u[2]); });
  const Block thick = bezierBlock({ 1, 1, 1 }, [](const Vec3& u) { return Vec3(1e-6 + u[0], u[1], u[2]); });
  const auto found = findVolumeInterfaces({ thin.view(), thick.view() });
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].faceA, 1);
  EXPECT_EQ(found[0].faceB, 0);

  VolumeInterfaceOptions options;
  options.boundaries = { { 0, 1, {}, 0 } };
  EXPECT_TRUE(findVolumeInterfaces({ thin.view(), thick.view() }, options).empty());

  try
  {
    findVolumeInterfaces({ thin.view(), thick.view(), thick.view() });
    FAIL();
  }
  catch (const Error& error)
  {
    EXPECT_NE(std::string(error.what()).find("meets both"), std::string::npos) << error.what();
  }
  // A wedge: its face u = 0 is collapsed to a line.
  const Block wedge = bezierBlock({ 1, 1, 1 }, [](const Vec3& u) { return Vec3(u[0], u[0] * u[1], u[2]); });
  EXPECT_TRUE(findVolumeInterfaces({ wedge.view() }).empty());
}

TEST(VolumeInterfaces, ContactsOfPartsOfFacesAreRefused)
{
  // Two spans along u on a block that has one, which meets the second; layers of 1e-6 over both.
  const auto block = [](double from, double to, double bottom, double top) {
    Block result;
    result.volume.degree = { 1, 1, 1 };
    result.volume.knots = { { { 0, 0, 1, 1 }, { 0, 0, 1, 1 }, { 0, 0, 1, 1 } } };
    if (to - from > 1.0)
    {
      result.volume.knots[0] = { 0, 0, 1, 2, 2 };
    }
    bsvtest::forEach(result.counts(), [&](const Ijk& i) {
      const std::initializer_list<double> x{ from + i[0], i[1] ? top : bottom, double(i[2]) };
      result.points.insert(result.points.end(), x);
    });
    return result;
  };
  const Block longBlock = block(0.0, 2.0, 0.0, 1e-6);
  const Block shortBlock = block(1.0, 2.0, 1e-6, 2e-6);
  const std::vector<BSplineVolume> both{ longBlock.view(), shortBlock.view() };
  EXPECT_TRUE(findVolumeInterfaces(both).empty());
  try
  {
    requireWholeContacts(both, {});
    FAIL();
  }
  catch (const Error& error)
  {
    const std::string text = error.what();
    EXPECT_NE(text.find("block 0, face 3, span (1, 0) and block 1, face 2, span (0, 0) are the same (1 such pair)"),
      std::string::npos)
      << text;
  }
  VolumeInterfaceOptions options;
  options.boundaries = { { 0, 3, {}, 0 } };
  EXPECT_NO_THROW(requireWholeContacts(both, {}, options));
  // The two sides of a layer are no contact, and whole contacts are known.
  EXPECT_NO_THROW(requireWholeContacts({ longBlock.view() }, {}));
  const Block below = block(1.0, 2.0, 0.0, 1e-6);
  const std::vector<BSplineVolume> stack{ shortBlock.view(), below.view() };
  EXPECT_NO_THROW(requireWholeContacts(stack, findVolumeInterfaces(stack)));
  EXPECT_THROW(requireWholeContacts(stack, {}), Error);
}

//------------------------------------------------------------------------------
// Bad input
//------------------------------------------------------------------------------

TEST(Smoothness, BadInput)
{
  EXPECT_TRUE(measureSmoothness({}, {}).joins.empty());
  EXPECT_TRUE(findVolumeInterfaces({}).empty());

  Pair pair = cut(mixedBlock(8), 1.5);
  const Turned good = turned(pair, {}, {});
  const auto message = [](const Turned& t, const std::vector<Interface>& interfaces, const SmoothnessOptions& options) {
    try
    {
      measureSmoothness(t.volumes(), interfaces, options);
    }
    catch (const Error& error)
    {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(message(good, { good.contact, good.contact }, {}).find("is in two interfaces"), std::string::npos);
  SmoothnessOptions options;
  options.samplesPerSpan = 0;
  EXPECT_NE(message(good, {}, options).find("samples per span"), std::string::npos);
  options = {};
  options.tolerance = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(message(good, {}, options).find("tolerance"), std::string::npos);
  options = {};
  options.creaseAngle = 181.0;
  EXPECT_NE(message(good, {}, options).find("crease angle"), std::string::npos);

  for (const double bad : { std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity() })
  {
    Pair broken = pair;
    broken.b.points[4] = bad;
    const Turned t = turned(broken, {}, {});
    const std::string text = message(t, { t.contact }, {});
    EXPECT_NE(text.find("control point (1, 0, 0) is not finite"), std::string::npos) << text;
    EXPECT_THROW(findVolumeInterfaces(t.volumes()), Error);
  }

  Execution stop;
  stop.progress = [](double) { return false; };
  EXPECT_THROW(measureSmoothness(good.volumes(), { good.contact }, {}, stop), Aborted);

  // Faces that do not belong together are measured, not trusted.
  Interface wrong = good.contact;
  wrong.faceB = 5;
  wrong.orientation = 3;
  EXPECT_EQ(measureSmoothness(good.volumes(), { wrong }).joins.at(0).continuity, JoinContinuity::Open);
}
