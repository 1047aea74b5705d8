// SPDX-License-Identifier: BSD-3-Clause
#include "Base/OrderFreeSum.h"
#include "Base/OrderFreeSums.h"
#include "Complex/EdgeFans.h"
#include "Conversion/LayerRules.h"
#include "Conversion/LimitMasks.h"
#include "Conversion/SingularNode.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <random>

using namespace bsv;

namespace
{

namespace Far = OpenSubdiv::Far;

struct RefinedPoint
{
  Vec3 x = Vec3::Zero();
  void Clear() { this->x.setZero(); }
  void AddWithWeight(const RefinedPoint& other, double weight) { this->x += weight * other.x; }
};

struct Limit
{
  Vec3 position, tangent1, tangent2;
  /// The fan around the centre after the refinement.
  Fan fan;
};

/// Limit at the centre of a fan by OpenSubdiv's own refinement: the fan is refined `levels` times and the limit is
/// taken there, from other points than those that the masks under test see.
Limit refinedLimit(const Fan& fan, bool corner, int levels)
{
  const int spokes = fan.spokeCount(), sectors = fan.sectorCount();
  std::vector<int> counts(sectors, 4), indices;
  for (int i = 0; i < sectors; ++i)
  {
    for (const int index : { 0, 1 + i, 1 + spokes + i, 1 + fan.nextSpoke(i) })
    {
      indices.push_back(index);
    }
  }
  Far::TopologyDescriptor descriptor;
  descriptor.numVertices = 1 + spokes + sectors;
  descriptor.numFaces = sectors;
  descriptor.numVertsPerFace = counts.data();
  descriptor.vertIndicesPerFace = indices.data();
  const int cornerVertex = 0;
  const float sharp = 10.0f;
  if (corner)
  {
    descriptor.numCorners = 1;
    descriptor.cornerVertexIndices = &cornerVertex;
    descriptor.cornerWeights = &sharp;
  }
  OpenSubdiv::Sdc::Options options;
  options.SetVtxBoundaryInterpolation(OpenSubdiv::Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  std::unique_ptr<Far::TopologyRefiner> refiner(
    Factory::Create(descriptor, Factory::Options(OpenSubdiv::Sdc::SCHEME_CATMARK, options)));
  Far::TopologyRefiner::UniformOptions uniform(levels);
  uniform.fullTopologyInLastLevel = true;
  refiner->RefineUniform(uniform);

  std::vector<RefinedPoint> points(refiner->GetLevel(0).GetNumVertices());
  points[0].x = fan.center;
  for (int i = 0; i < spokes; ++i)
  {
    points[1 + i].x = fan.spokes[i];
  }
  for (int i = 0; i < sectors; ++i)
  {
    points[1 + spokes + i].x = fan.sectors[i];
  }
  Far::PrimvarRefinerReal<double> primvar(*refiner);
  // The centre's neighbours of the next level are the children of its edges and faces.
  int vertex = 0;
  std::vector<int> spokeVertices, sectorVertices;
  for (int i = 0; i < spokes; ++i)
  {
    spokeVertices.push_back(1 + i);
  }
  for (int i = 0; i < sectors; ++i)
  {
    sectorVertices.push_back(1 + spokes + i);
  }
  for (int level = 1; level <= levels; ++level)
  {
    const Far::TopologyLevel& coarse = refiner->GetLevel(level - 1);
    std::vector<RefinedPoint> finer(refiner->GetLevel(level).GetNumVertices());
    primvar.Interpolate(level, points, finer);
    for (int& sector : sectorVertices)
    {
      for (const int face : coarse.GetVertexFaces(vertex))
      {
        const auto corners = coarse.GetFaceVertices(face);
        if (std::find(corners.begin(), corners.end(), sector) != corners.end())
        {
          const int child = coarse.GetFaceChildVertex(face);
          sector = child;
          break;
        }
      }
    }
    for (int& spoke : spokeVertices)
    {
      spoke = coarse.GetEdgeChildVertex(coarse.FindEdge(vertex, spoke));
    }
    vertex = coarse.GetVertexChildVertex(vertex);
    points = finer;
  }
  std::vector<RefinedPoint> position(points.size()), tangent1(points.size()), tangent2(points.size());
  primvar.Limit(points, position, tangent1, tangent2);
  Limit limit{ position[vertex].x, tangent1[vertex].x, tangent2[vertex].x, fan };
  limit.fan.center = points[vertex].x;
  for (int i = 0; i < spokes; ++i)
  {
    limit.fan.spokes[i] = points[spokeVertices[i]].x;
  }
  for (int i = 0; i < sectors; ++i)
  {
    limit.fan.sectors[i] = points[sectorVertices[i]].x;
  }
  return limit;
}

/// A bumpy fan, about regular in shape.
Fan bumpyFan(bool closed, int sectors, unsigned seed)
{
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> noise(-0.1, 0.1);
  const auto bump = [&](const Vec3& x) { return Vec3(x + Vec3(noise(random), noise(random), noise(random))); };
  Fan fan;
  fan.closed = closed;
  fan.center = bump(Vec3(0, 0, 0.3));
  const double angle = (closed ? 2.0 : 1.0) * std::acos(-1.0) / sectors;
  const auto direction = [&](int i) { return Vec3(std::cos(i * angle), std::sin(i * angle), 0); };
  for (int i = 0; i < (closed ? sectors : sectors + 1); ++i)
  {
    fan.spokes.push_back(bump(direction(i)));
  }
  for (int i = 0; i < sectors; ++i)
  {
    fan.sectors.push_back(bump(direction(i) + direction(i + 1)));
  }
  return fan;
}

Vec3 apply(const FanMask& mask, const Fan& fan)
{
  Vec3 value = mask.center * fan.center;
  for (int i = 0; i < fan.spokeCount(); ++i)
  {
    value += mask.spokes[i] * fan.spokes[i];
  }
  for (int i = 0; i < fan.sectorCount(); ++i)
  {
    value += mask.sectors[i] * fan.sectors[i];
  }
  return value;
}

Vec3 unitNormal(const Vec3& a, const Vec3& b)
{
  return a.cross(b).normalized();
}

std::vector<double> regularWeights(const Fan& fan)
{
  return std::vector<double>(fan.spokeCount(), 2.0 / 3.0);
}

/// The fan read from another spoke, in the same or the opposite sense.
Fan reread(const Fan& fan, int first, bool backwards)
{
  Fan result = fan;
  const int n = fan.sectorCount();
  for (int i = 0; i < fan.spokeCount(); ++i)
  {
    const int from = fan.closed ? (backwards ? first - i + n : first + i) % n : (backwards ? n - i : i);
    result.spokes[i] = fan.spokes[from];
  }
  for (int i = 0; i < n; ++i)
  {
    const int from = fan.closed ? (backwards ? first - i - 1 + n : first + i) % n : (backwards ? n - 1 - i : i);
    result.sectors[i] = fan.sectors[from];
  }
  return result;
}

} // namespace

TEST(LimitMasks, AgreeWithOpenSubdivsRefinement)
{
  for (int valence = 3; valence <= 8; ++valence)
  {
    for (unsigned seed = 1; seed <= 3; ++seed)
    {
      const Fan fan = bumpyFan(true, valence, seed);
      const Limit limit = refinedLimit(fan, false, 4);
      const Fan rule = smoothFan(fan, Twist::SecondFundamentalForm, regularWeights(fan));
      EXPECT_LE((rule.center - limit.position).norm(), 1e-12);
      const Vec3 normal = unitNormal(limit.tangent1, limit.tangent2);
      EXPECT_LE((limitNormal(fan) - normal).norm(), 1e-12) << "valence " << valence;
      // The neighbours lie in the tangent plane, each ahead along its own spoke.
      for (int i = 0; i < valence; ++i)
      {
        EXPECT_LE(std::abs(normal.dot(rule.spokes[i] - rule.center)), 1e-12);
        EXPECT_GT((rule.spokes[i] - rule.center).dot(fan.spokes[i] - fan.center), 0.0);
      }
    }
  }
}

TEST(LimitMasks, AgreeWithOpenSubdivsRefinementOnCreasesAndCorners)
{
  for (int sectors = 2; sectors <= 7; ++sectors)
  {
    const Fan fan = bumpyFan(false, sectors, sectors);
    const Limit crease = refinedLimit(fan, false, 4);
    const LimitMasks masks = openFanLimitMasks(sectors);
    EXPECT_LE((apply(masks.position, fan) - crease.position).norm(), 1e-12);
    // The limit does not change under refinement, so the refined points must give the same normal. (OpenSubdiv's own
    // tangents fail this test for more than two sectors; they approach the normal found here with every level.)
    const Vec3 normal = unitNormal(apply(masks.tangent1, fan), apply(masks.tangent2, fan));
    const Vec3 refined = unitNormal(apply(masks.tangent1, crease.fan), apply(masks.tangent2, crease.fan));
    EXPECT_LE((normal - refined).norm(), 1e-12) << sectors << " sectors";
    const Limit finer = refinedLimit(fan, false, 8);
    const double error = (unitNormal(crease.tangent1, crease.tangent2) - normal).norm();
    const double finerError = (unitNormal(finer.tangent1, finer.tangent2) - normal).norm();
    EXPECT_LE(finerError, sectors == 2 ? 1e-12 : 0.5 * error);
    const Fan rule = smoothFan(fan, Twist::SecondFundamentalForm, regularWeights(fan));
    EXPECT_LE((rule.center - crease.position).norm(), 1e-12);
    for (int i = 0; i <= sectors; ++i)
    {
      EXPECT_LE(std::abs(normal.dot(rule.spokes[i] - rule.center)), 1e-12);
    }
    const Limit corner = refinedLimit(fan, true, 4);
    EXPECT_LE((fan.center - corner.position).norm(), 1e-12);
  }
}

// The general formulas are written down once more for the fan of four, from the masks of one dimension.
TEST(LayerRules, FanOfFourIsTheTensorProduct)
{
  const Fan fan = bumpyFan(true, 4, 11);
  Vec3 grid[3][3];
  grid[1][1] = fan.center;
  const int spokeAt[4][2] = { { 2, 1 }, { 1, 2 }, { 0, 1 }, { 1, 0 } };
  const int sectorAt[4][2] = { { 2, 2 }, { 0, 2 }, { 0, 0 }, { 2, 0 } };
  for (int i = 0; i < 4; ++i)
  {
    grid[spokeAt[i][0]][spokeAt[i][1]] = fan.spokes[i];
    grid[sectorAt[i][0]][sectorAt[i][1]] = fan.sectors[i];
  }
  const double M[3] = { 1.0 / 6, 2.0 / 3, 1.0 / 6 };
  const double m[3] = { 0.0, 2.0 / 3, 1.0 / 3 };
  const auto tensor = [&](const double* a, const double* b) {
    Vec3 sum = Vec3::Zero();
    for (int i = 0; i < 3; ++i)
    {
      for (int j = 0; j < 3; ++j)
      {
        sum += a[i] * b[j] * grid[i][j];
      }
    }
    return sum;
  };
  const Fan rule = smoothFan(fan, Twist::SecondFundamentalForm, regularWeights(fan));
  EXPECT_LE((rule.center - tensor(M, M)).norm(), 1e-15);
  EXPECT_LE((rule.spokes[0] - tensor(m, M)).norm(), 1e-15);
  EXPECT_LE((rule.spokes[1] - tensor(M, m)).norm(), 1e-15);
  EXPECT_LE((rule.sectors[0] - tensor(m, m)).norm(), 1e-15);
}

TEST(LayerRules, SameBitsWhereverTheFanStarts)
{
  for (const bool closed : { true, false })
  {
    for (int sectors = closed ? 3 : 2; sectors <= 8; ++sectors)
    {
      const Fan fan = bumpyFan(closed, sectors, 40 + sectors);
      std::vector<double> weights = regularWeights(fan);
      for (const Twist twist : { Twist::SecondFundamentalForm, Twist::Parallelogram, Twist::Mask })
      {
        const Fan rule = smoothFan(fan, twist, weights);
        const Vec3 normal = Vec3(0.1, -0.2, 1.0).normalized();
        const Vec3 projection(0.01, 0.02, 0.25);
        for (int first = 0; first < (closed ? sectors : 1); ++first)
        {
          for (const bool backwards : { false, true })
          {
            const Fan expected = reread(rule, first, backwards);
            const Fan actual = smoothFan(reread(fan, first, backwards), twist, weights);
            EXPECT_TRUE(actual.center == expected.center && actual.spokes == expected.spokes &&
              actual.sectors == expected.sectors)
              << sectors << " sectors, first " << first;
            if (closed)
            {
              const Fan body = reread(projectedFan(fan, { projection, normal }, twist), first, backwards);
              const Fan other = projectedFan(reread(fan, first, backwards), { projection, -normal }, twist);
              EXPECT_TRUE(body.spokes == other.spokes && body.sectors == other.sectors);
            }
          }
        }
      }
    }
  }
}

// II(a, b) of a graph over its tangent plane, known in closed form, on the affine regular fan.
TEST(LayerRules, TwistFollowsTheSecondFundamentalForm)
{
  const double L = 0.3, M = -0.2, N = 0.5;
  const auto height = [&](const Vec3& x) {
    return Vec3(x[0], x[1], 0.5 * (L * x[0] * x[0] + 2 * M * x[0] * x[1] + N * x[1] * x[1]));
  };
  for (int valence = 3; valence <= 8; ++valence)
  {
    Fan fan;
    const double angle = 2.0 * std::acos(-1.0) / valence;
    const auto direction = [&](int i) { return Vec3(std::cos(i * angle), std::sin(i * angle), 0); };
    for (int i = 0; i < valence; ++i)
    {
      fan.spokes.push_back(height(direction(i)));
      fan.sectors.push_back(height(direction(i) + direction(i + 1)));
    }
    const Vec3 normal(0, 0, 1);
    const Fan rule = projectedFan(fan, { Vec3::Zero(), normal }, Twist::SecondFundamentalForm);
    for (int i = 0; i < valence; ++i)
    {
      const Vec3 a = rule.spokes[i], b = rule.spokes[fan.nextSpoke(i)];
      const double form = L * a[0] * b[0] + M * (a[0] * b[1] + a[1] * b[0]) + N * a[1] * b[1];
      EXPECT_NEAR(rule.sectors[i][2], form, 1e-14) << "valence " << valence;
    }
  }
}

TEST(LayerRules, ProjectedFanTouchesTheGivenSurface)
{
  const Fan fan = bumpyFan(true, 5, 3);
  const Vec3 normal = Vec3(0.2, 0.1, 1.0).normalized();
  const Vec3 projection(0.02, -0.01, 0.2);
  const Fan rule = projectedFan(fan, { projection, normal }, Twist::SecondFundamentalForm);
  EXPECT_EQ(rule.center, projection);
  for (const Vec3& x : rule.spokes)
  {
    EXPECT_LE(std::abs(normal.dot(x - projection)), 1e-15);
  }
}

TEST(OrderFreeSum, ManySumsAtOnceHaveTheSameBits)
{
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::uniform_int_distribution<int> integer(1, 16);
  constexpr int Count = 37; // no multiple of any vector's length
  for (const int termCount : { 2, 3, 4, 6, 8, 9, 12, 18, 27 })
  {
    std::vector<double> weights;
    std::vector<std::vector<Vec3>> terms(termCount, std::vector<Vec3>(Count));
    std::vector<const double*> addresses;
    double denominator = 0.0;
    for (std::vector<Vec3>& term : terms)
    {
      weights.push_back(integer(random));
      denominator += weights.back();
      for (int i = 0; i < Count; ++i)
      {
        // Sizes that lose digits of each other, coordinates that all share, zeros of both signs.
        const Vec3 any = Vec3(uniform(random), uniform(random), uniform(random)) * std::pow(10.0, integer(random) - 8);
        term[i] = i % 5 == 0 ? Vec3(terms[0][i][0], any[1], terms[0][i][2]) : any;
        term[i] = i % 7 == 0 ? Vec3(uniform(random) < 0.0 ? 0.0 : -0.0, any[1], any[2]) : term[i];
      }
      addresses.push_back(term[0].data());
    }
    std::vector<Vec3> sums(Count);
    orderFreeSums(weights.data(), addresses.data(), termCount, denominator, 3 * Count, sums[0].data());
    for (int i = 0; i < Count; ++i)
    {
      OrderFreeSum sum;
      for (int t = 0; t < termCount; ++t)
      {
        sum.add(weights[t], terms[t][i]);
      }
      const Vec3 expected = sum.result(denominator);
      EXPECT_EQ(std::memcmp(sums[i].data(), expected.data(), sizeof(Vec3)), 0) << termCount << " terms, sum " << i;
    }
  }
}

TEST(LayerRules, ManyRegularFansAtOnceHaveTheBitsOfEach)
{
  std::mt19937 random(6);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  constexpr int Count = 11;
  for (const bool closed : { true, false })
  {
    const int spokes = closed ? 4 : 3, sectors = closed ? 4 : 2;
    std::vector<std::vector<Vec3>> points(1 + spokes + sectors, std::vector<Vec3>(Count)), values = points;
    std::vector<const Vec3*> from;
    std::vector<Vec3*> to;
    for (std::size_t i = 0; i < points.size(); ++i)
    {
      for (Vec3& x : points[i])
      {
        x = Vec3(uniform(random), uniform(random), uniform(random));
      }
      from.push_back(points[i].data());
      to.push_back(values[i].data());
    }
    smoothRegularFans(closed, from, Count, to);
    for (int k = 0; k < Count; ++k)
    {
      Fan fan;
      fan.closed = closed;
      fan.center = points[0][k];
      for (int i = 0; i < spokes + sectors; ++i)
      {
        (i < spokes ? fan.spokes : fan.sectors).push_back(points[1 + i][k]);
      }
      const Fan expected = smoothFan(fan, Twist::Mask, std::vector<double>(spokes, KnotInsertion));
      EXPECT_EQ(values[0][k], expected.center);
      for (int i = 0; i < spokes; ++i)
      {
        EXPECT_EQ(values[1 + i][k], expected.spokes[i]);
      }
      for (int i = 0; i < sectors; ++i)
      {
        EXPECT_EQ(values[1 + spokes + i][k], expected.sectors[i]);
      }
    }
  }
}

TEST(OrderFreeSum, DoesNotDependOnTheOrder)
{
  std::mt19937 random(5);
  std::uniform_real_distribution<double> value(-1.0, 1.0);
  std::uniform_int_distribution<int> exponent(-40, 40);
  for (int trial = 0; trial < 200; ++trial)
  {
    std::vector<std::pair<double, Vec3>> terms;
    for (int i = 0; i < 27; ++i)
    {
      terms.emplace_back(value(random),
        Vec3(std::ldexp(value(random), exponent(random)), value(random), std::ldexp(value(random), exponent(random))));
    }
    Vec3 reference;
    for (int order = 0; order < 10; ++order)
    {
      OrderFreeSum sum;
      for (const auto& [weight, point] : terms)
      {
        sum.add(weight, point);
      }
      const Vec3 result = sum.result(3.0);
      if (order == 0)
      {
        reference = result;
      }
      EXPECT_EQ(result, reference);
      std::shuffle(terms.begin(), terms.end(), random);
    }
  }
}

namespace
{

/// Star of the origin in the integer lattice.
VertexStar latticeStar(std::mt19937& random)
{
  std::uniform_real_distribution<double> value(-1.0, 1.0);
  const auto point = [&] { return Vec3(value(random), value(random), value(random)); };
  VertexStar star;
  star.point = point();
  for (int e = 0; e < 6; ++e)
  {
    star.edges.push_back({ e, 0, point(), false });
  }
  // Star edge 2 d + side runs along direction d.
  for (int d = 0; d < 3; ++d)
  {
    for (int corner = 0; corner < 4; ++corner)
    {
      const int s = faceAxis(2 * d, 0), t = faceAxis(2 * d, 1);
      star.faces.push_back(
        { 4 * d + corner, 0, { 2 * s + (corner & 1), 2 * t + (corner >> 1) }, { -1, -1 }, point(), false });
    }
  }
  for (int corner = 0; corner < 8; ++corner)
  {
    VertexStar::Block block{ corner, 0, {}, {}, point() };
    for (int d = 0; d < 3; ++d)
    {
      block.edges[d] = 2 * d + cornerSide(corner, d);
      const int face = 4 * d + cornerSide(corner, faceAxis(2 * d, 0)) + 2 * cornerSide(corner, faceAxis(2 * d, 1));
      block.faces[d] = face;
      auto& sides = star.faces[face].blocks;
      sides[sides[0] < 0 ? 0 : 1] = corner;
    }
    star.blocks.push_back(block);
  }
  return star;
}

} // namespace

TEST(SingularNode, RegularStarGivesTheTricubicLimit)
{
  std::mt19937 random(9);
  VertexStar star = latticeStar(random);
  // Not too far from a lattice, or its blocks have no shape.
  const auto lattice = [](const auto& edges) {
    Vec3 sum = Vec3::Zero();
    for (const int edge : edges)
    {
      sum[edge / 2] += edge % 2 ? 4.0 : -4.0;
    }
    return sum;
  };
  for (int e = 0; e < 6; ++e)
  {
    star.edges[e].point += lattice(std::array<int, 1>{ e });
  }
  for (auto& face : star.faces)
  {
    face.point += lattice(face.edges);
  }
  for (auto& block : star.blocks)
  {
    block.point += lattice(block.edges);
  }
  Vec3 expected = 64.0 * star.point;
  for (const auto& edge : star.edges)
  {
    expected += 16.0 * edge.point;
  }
  for (const auto& face : star.faces)
  {
    expected += 4.0 * face.point;
  }
  for (const auto& block : star.blocks)
  {
    expected += block.point;
  }
  const SolidLimit limit = solidLimit(star);
  EXPECT_LE((limit.point - expected / 216.0).norm(), 1e-14);

  // Derivatives of the tricubic B-spline at a knot: half the central difference, [1/6 2/3 1/6] in the other directions.
  ASSERT_EQ(limit.slopes.size(), 6u);
  const auto weight = [](int chosen) { return chosen == 0 ? 16.0 : chosen == 1 ? 4.0 : 1.0; };
  for (int d = 0; d < 3; ++d)
  {
    Vec3 derivative = Vec3::Zero();
    const auto add = [&](const Vec3& point, const std::vector<int>& along) {
      for (const int edge : along)
      {
        if (edge / 2 == d)
        {
          derivative += (edge % 2 ? 1.0 : -1.0) * weight(static_cast<int>(along.size()) - 1) / 72.0 * point;
        }
      }
    };
    for (int e = 0; e < 6; ++e)
    {
      add(star.edges[e].point, { e });
    }
    for (const auto& face : star.faces)
    {
      add(face.point, { face.edges[0], face.edges[1] });
    }
    for (const auto& block : star.blocks)
    {
      add(block.point, { block.edges[0], block.edges[1], block.edges[2] });
    }
    EXPECT_LE((limit.slopes[2 * d + 1] - derivative).norm(), 1e-13);
    EXPECT_LE((limit.slopes[2 * d] + derivative).norm(), 1e-13);
  }
}
