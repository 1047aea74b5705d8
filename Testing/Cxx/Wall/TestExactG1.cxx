// SPDX-License-Identifier: BSD-3-Clause
// Exact G1 at extraordinary edges and vertices: the algebra on local nets, and converted meshes by evaluation.
#include "Body/ClosestPoint.h"
#include "Complex/EdgeFans.h"
#include "Conversion/DoubleKnots.h"
#include "Conversion/LocalNet.h"
#include "Mesh/BlockSurface.h"
#include "Ranks/Ranks.h"
#include "Support/BodyCases.h"
#include "Support/ConversionCases.h"
#include "Support/MeshCases.h"
#include "Wall/BodyFit.h"
#include "Wall/WallSamples.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

using namespace bsv;
using conversioncases::Converted;
using meshcases::MeshCase;

namespace
{

const std::vector<Ijk> Cube{ { 0, 0, 0 } };
const std::vector<Ijk> Tromino{ { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } };

/// Layers around the star-shaped body; the faces k = 0 are the wall.
MeshCase starMesh(const std::vector<Ijk>& cubes, int cells, const std::vector<double>& radii)
{
  MeshCase mesh = meshcases::polycubeBody(cubes, cells, radii);
  mesh.apply([](const Vec3& x) { return Vec3(bodycases::starRadius(x.normalized()) * x); });
  mesh.boundaryNames = { "wall" };
  for (int b = 0; b < static_cast<int>(mesh.blocks.size()); ++b)
  {
    mesh.boundaries.push_back({ b, 4, { { 0, 0 }, { cells, cells } }, 0 });
  }
  return mesh;
}

/// A body of 72 patches with vertices of valences 3 to 8: the triangles between the corners of an octahedron and the
/// middles of its faces, some edges flipped, each cut into three quadrilaterals.
MeshCase mixedMesh(int cells, const std::vector<double>& radii)
{
  std::vector<Vec3> corners;
  for (int d = 0; d < 3; ++d)
  {
    corners.push_back(Vec3::Unit(d));
    corners.push_back(-Vec3::Unit(d));
  }
  std::vector<std::array<int, 3>> triangles;
  for (int octant = 0; octant < 8; ++octant)
  {
    const std::array<int, 3> face{ octant & 1, 2 + (octant >> 1 & 1), 4 + (octant >> 2) };
    const bool odd = ((octant & 1) + (octant >> 1 & 1) + (octant >> 2)) % 2 != 0;
    const int middle = static_cast<int>(corners.size());
    corners.push_back((corners[face[0]] + corners[face[1]] + corners[face[2]]).normalized());
    for (int i = 0; i < 3; ++i)
    {
      const int a = face[i], b = face[(i + 1) % 3];
      triangles.push_back({ odd ? b : a, odd ? a : b, middle });
    }
  }
  for (const auto& [a, b] : { std::pair<int, int>{ 0, 2 }, { 0, 4 }, { 0, 3 }, { 1, 2 } })
  {
    std::vector<std::size_t> both;
    for (std::size_t t = 0; t < triangles.size(); ++t)
    {
      const auto has = [&](int v) { return std::count(triangles[t].begin(), triangles[t].end(), v) > 0; };
      if (has(a) && has(b))
      {
        both.push_back(t);
      }
    }
    // (p, q, m) and (q, p, n) become (p, n, m) and (n, q, m).
    const std::array<int, 3> first = triangles[both[0]], second = triangles[both[1]];
    triangles[both[0]] = { first[0], second[2], first[2] };
    triangles[both[1]] = { second[2], first[1], first[2] };
  }
  MeshCase mesh;
  mesh.boundaryNames = { "wall" };
  for (const std::array<int, 3>& t : triangles)
  {
    const auto corner = [&](int i) { return corners[t[i % 3]]; };
    const Vec3 middle = (corner(0) + corner(1) + corner(2)).normalized();
    for (int i = 0; i < 3; ++i)
    {
      const Vec3 quad[4] = { corner(i), (corner(i) + corner(i + 1)).normalized(),
        (corner(i + 2) + corner(i)).normalized(), middle };
      mesh.add({ cells, cells, static_cast<int>(radii.size()) - 1 }, [&](const Ijk& p) {
        const double u = double(p[0]) / cells, v = double(p[1]) / cells;
        const Vec3 x = (1 - v) * ((1 - u) * quad[0] + u * quad[1]) + v * ((1 - u) * quad[2] + u * quad[3]);
        return Vec3(radii[p[2]] * bodycases::starRadius(x.normalized()) * x.normalized());
      });
      mesh.boundaries.push_back({ int(mesh.blocks.size()) - 1, 4, { { 0, 0 }, { cells, cells } }, 0 });
    }
  }
  return mesh;
}

/// 8 layers that grow by 1.4, the first one of the given height.
std::vector<double> growing(double first)
{
  std::vector<double> radii{ 1.0 };
  for (int k = 0; k < 8; ++k, first *= 1.4)
  {
    radii.push_back(radii.back() + first);
  }
  return radii;
}

ConversionOptions exact(const BodySurface* body = nullptr)
{
  ConversionOptions options;
  options.roles = { BoundaryRole::Body };
  options.body = body;
  options.continuity = Continuity::ExactG1;
  return options;
}

double degrees(const Vec3& a, const Vec3& b)
{
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b))) * 180.0 / bodycases::Pi;
}

/// Parameters of a block at a place of one of its faces, and derivatives there.
struct FaceAt
{
  const BSplineVolume& volume;
  FaceUse use;

  double length(int axis) const { return this->volume.knots[faceAxis(this->use.face, axis)].back(); }
  Vec3 at(double s, double t) const
  {
    const int n = faceDirection(this->use.face);
    Vec3 uvw;
    uvw[faceAxis(this->use.face, 0)] = s;
    uvw[faceAxis(this->use.face, 1)] = t;
    uvw[n] = faceSide(this->use.face) ? this->volume.knots[n].back() : 0.0;
    return uvw;
  }
  /// Derivative along a direction of the block.
  Vec3 along(const Vec3& uvw, int direction) const
  {
    std::array<int, 3> order{ 0, 0, 0 };
    order[direction] = 1;
    return evaluate(this->volume, uvw, order);
  }
  /// Derivative into the block.
  Vec3 inwards(const Vec3& uvw) const
  {
    const int n = faceDirection(this->use.face);
    return (faceSide(this->use.face) ? -1.0 : 1.0) * this->along(uvw, n);
  }
};

struct Joins
{
  /// Largest angle between the two sides' normals of a layer, degrees, by layer parameter class: on the wall,
  /// elsewhere.
  double wall = 0.0, layers = 0.0;
  /// |F_s(left) + F_s(right) - gamma F_t| / |F_t|.
  double gluing = 0.0;
};

/// Along all faces behind the spokes of extraordinary edges, up to their middle, but for spokes that are creases.
Joins measureJoins(const Converted& converted)
{
  Joins joins;
  const BlockComplex& complex = converted.complex;
  for (const ComplexFace& face : complex.faces)
  {
    if (face.boundary())
    {
      continue;
    }
    const FaceAt a{ converted.volumes[face.uses[0].block], face.uses[0] };
    const FaceAt b{ converted.volumes[face.uses[1].block], face.uses[1] };
    const double ns = a.length(0), nt = a.length(1);
    for (int edge = 0; edge < 4; ++edge)
    {
      const int axis = edge / 2; // the edge's axis; t runs along the other one
      const ComplexEdge& shared =
        complex.edges[complex.blocks[a.use.block].edges[faceEdge(a.use.face, axis, edge % 2)]];
      const ComplexBlock& block = complex.blocks[a.use.block];
      if (!shared.extraordinary() || complex.edges[block.edges[faceEdge(a.use.face, 1 - axis, 0)]].crease)
      {
        continue;
      }
      const double g = 2.0 * std::cos(2.0 * bodycases::Pi / shared.valence());
      const double length = axis == 0 ? nt : ns, height = axis == 0 ? ns : nt;
      const double first = length == 1.0 ? 1.0 / 3.0 : length == 2.0 ? 0.5 : 1.0;
      for (int iw = 0; iw <= 4; ++iw)
      {
        const double w = height * iw / 4.0;
        for (int it = 0; it <= 24; ++it)
        {
          const double t = 0.5 * length * it / 24.0;
          const double own = edge % 2 ? length - t : t;
          const double s0 = axis == 0 ? w : own, t0 = axis == 0 ? own : w;
          const Vec3 ua = a.at(s0, t0);
          double u = swapsAxes(face.orientation) ? t0 : s0, v = swapsAxes(face.orientation) ? s0 : t0;
          u = (face.orientation & 2) ? b.length(0) - u : u;
          v = (face.orientation & 4) ? b.length(1) - v : v;
          const Vec3 ub = b.at(u, v);
          EXPECT_LE((evaluate(a.volume, ua) - evaluate(b.volume, ub)).norm(), 1e-13);
          const int alongBorder = faceAxis(a.use.face, 1 - axis);
          const Vec3 ft = (edge % 2 ? -1.0 : 1.0) * a.along(ua, alongBorder);
          const Vec3 left = a.inwards(ua), right = b.inwards(ub);
          const double rest = std::max(0.0, 1.0 - t / first);
          joins.gluing = std::max(joins.gluing, (left + right - g * rest * rest * ft).norm() / ft.norm());
          const double jump = degrees(left.cross(ft), right.cross(ft));
          double& worst = iw == 0 ? joins.wall : joins.layers;
          worst = std::max(worst, jump);
        }
      }
    }
  }
  return joins;
}

struct WallFigures
{
  double distance = 0.0;
  double lowest = 1e9, highest = -1e9; ///< mean curvature
};

WallFigures measureWall(const Converted& converted)
{
  WallFigures wall;
  for (const BSplineVolume& volume : converted.volumes)
  {
    const double nu = volume.knots[0].back(), nv = volume.knots[1].back();
    const int fu = static_cast<int>(4 * nu), fv = static_cast<int>(4 * nv);
    for (int j = 0; j <= fv; ++j)
    {
      for (int i = 0; i <= fu; ++i)
      {
        const Vec3 at(nu * i / fu, nv * j / fv, 0.0);
        const auto d = [&](int a, int b) { return evaluate(volume, at, { a, b, 0 }); };
        const Vec3 x = d(0, 0), u = d(1, 0), v = d(0, 1);
        wall.distance = std::max(
          wall.distance, (x - bodycases::starPoint(x)).norm() * std::abs(bodycases::starNormal(x).dot(x.normalized())));
        Vec3 normal = u.cross(v).normalized();
        normal *= normal.dot(x) > 0.0 ? 1.0 : -1.0;
        const double E = u.dot(u), F = u.dot(v), G = v.dot(v);
        const double L = d(2, 0).dot(normal), M = d(1, 1).dot(normal), N = d(0, 2).dot(normal);
        const double mean = (E * N - 2.0 * F * M + G * L) / (2.0 * (E * G - F * F));
        wall.lowest = std::min(wall.lowest, mean);
        wall.highest = std::max(wall.highest, mean);
      }
    }
  }
  return wall;
}

} // namespace

TEST(ExactG1, LocalNetsFulfilTheConditions)
{
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto any = [&] { return Vec3(unit(random), unit(random), unit(random)); };
  for (const bool closed : { true, false })
  {
    for (int n = closed ? 3 : 2; n <= 8; ++n)
    {
      for (const bool mixed : { false, true })
      {
        LocalNetShape shape;
        shape.closed = closed;
        shape.sectors = n;
        for (int k = 0; k < shape.spokes(); ++k)
        {
          shape.kinds.push_back(static_cast<SpokeKind>(mixed ? 1 + (7 * k + k * k) % 3 : 3));
        }
        std::vector<Vec3> net(shape.size());
        std::generate(net.begin(), net.end(), any);
        const Vec3 a = any(), b = any();
        for (int k = 0; k < shape.spokes(); ++k)
        {
          const double angle = (closed ? 2.0 : 1.0) * bodycases::Pi * k / n;
          net[shape.spoke(k, 1)] = net[0] + shape.delta(k) * (std::cos(angle) * a + std::sin(angle) * b);
        }
        const JoinRule rule(shape);
        std::vector<Vec3> joined = net;
        rule.apply(joined);
        EXPECT_LE(joinDefect(shape, joined), 1e-11) << n;
        EXPECT_EQ(joined[0], net[0]);
        EXPECT_EQ(joined[shape.spoke(0, 1)], net[shape.spoke(0, 1)]);
        // Nothing that fulfils them changes, and c_1 that do not are moved.
        std::vector<Vec3> again = joined;
        rule.apply(again);
        for (std::size_t i = 0; i < net.size(); ++i)
        {
          EXPECT_LE((again[i] - joined[i]).norm(), 1e-10);
        }
        for (int k = 0; k < shape.spokes(); ++k)
        {
          again[shape.spoke(k, 1)] += shape.isJoined(k) ? Vec3(0.1 * any()) : Vec3(Vec3::Zero());
        }
        rule.apply(again, true);
        EXPECT_LE(joinDefect(shape, again), 1e-11) << n;
        // The same bits from any spoke on, in either sense.
        if (!mixed)
        {
          const int turn = closed ? n / 2 : 0;
          std::vector<Vec3> other(net.size());
          const auto spoke = [&](int k) { return closed ? (turn - k + n) % n : n - k; };
          const auto sector = [&](int k) { return closed ? (turn - k - 1 + n) % n : n - 1 - k; };
          const auto turned = [&](const std::vector<Vec3>& from) {
            std::vector<Vec3> to(from.size());
            to[0] = from[0];
            for (int k = 0; k < shape.spokes(); ++k)
            {
              for (int i = 1; i <= 3; ++i)
              {
                to[shape.spoke(k, i)] = from[shape.spoke(spoke(k), i)];
              }
            }
            for (int k = 0; k < n; ++k)
            {
              for (int j = 1; j <= 3; ++j)
              {
                for (int i = 1; i <= 3; ++i)
                {
                  to[shape.sector(k, i, j)] = from[shape.sector(sector(k), j, i)];
                }
              }
            }
            return to;
          };
          other = turned(net);
          rule.apply(other);
          EXPECT_TRUE(other == turned(joined)) << n;
        }
      }
    }
  }
}

TEST(ExactG1, DoubleKnotsAreInsertedExactly)
{
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (const Ijk& cells : { Ijk{ 1, 2, 3 }, Ijk{ 4, 1, 2 }, Ijk{ 5, 7, 1 }, Ijk{ 4, 3, 6 } })
  {
    for (int mask = 1; mask < 8; ++mask)
    {
      const std::array<bool, 3> doubled{ (mask & 1) != 0, (mask & 2) != 0, (mask & 4) != 0 };
      BSplineVolume before, after;
      Index old = 1, count = 1;
      for (int d = 0; d < 3; ++d)
      {
        before.knots[d] = volumeKnots(cells[d], false);
        after.knots[d] = volumeKnots(cells[d], doubled[d]);
        old *= before.count(d);
        count *= after.count(d);
        EXPECT_EQ(after.count(d), controlPointCount(cells[d], doubled[d]));
      }
      std::vector<double> single(3 * old);
      std::generate(single.begin(), single.end(), [&] { return unit(random); });
      std::vector<double> points(3 * count);
      std::copy(single.begin(), single.end(), points.begin());
      std::vector<std::uint8_t> rules(count, 0);
      makeRoom(cells, doubled, { points.data(), rules.data() });
      insertDoubleKnots(cells, doubled, { points.data(), rules.data() });
      before.points = single.data();
      after.points = points.data();
      for (int i = 0; i < 40; ++i)
      {
        Vec3 at;
        for (int d = 0; d < 3; ++d)
        {
          at[d] = 0.5 * (1.0 + unit(random)) * cells[d];
        }
        EXPECT_LE((evaluate(before, at) - evaluate(after, at)).norm(), 1e-13);
      }
    }
  }
}

// The jumps are rounding, the wall is as close to the body as its knots allow, the curvature is that of the body:
// bounds are what a prototype of the rule in numpy reaches on like bodies or, where this is better, what was reached
// here.
TEST(ExactG1, TableOfTheBodies)
{
  const BodySurface body(bodycases::starPatches(Eigen::Matrix3d::Identity()));
  double low = 0.0, high = -9.0;
  for (int i = 0; i < 4000; ++i)
  {
    // The body's own mean curvature, by differences of its normal: half the divergence.
    const double z = 1.0 - 2.0 * (i + 0.5) / 4000, angle = 2.399963229728653 * i, r = std::sqrt(1.0 - z * z);
    const Vec3 d(r * std::cos(angle), r * std::sin(angle), z);
    const SurfaceGeometry at = body.closestPoint(bodycases::starPoint(d)).geometry;
    const double sign = at.normal.dot(d) > 0.0 ? 0.5 : -0.5;
    const double mean = sign * at.curvature.trace();
    low = std::min(low, mean);
    high = std::max(high, mean);
  }
  std::printf("mean curvature of the body: %.3f..%.3f\n", low, high);
  struct Row
  {
    const char* name;
    int cells;
    double distance; ///< to be reached
    /// Mean curvature, to be reached on coarse meshes.
    double lowest, highest;
  };
  for (const Row& row :
    { Row{ "cube", 1, 1.0, -9.0, 9.0 }, Row{ "cube", 2, 1.0, -9.0, 9.0 }, Row{ "cube", 4, 1e-3, -1.52, -0.24 },
      Row{ "cube", 8, 1.9e-4, -1.27, -0.29 }, Row{ "cube", 16, 2e-5, -1.255, -0.29 },
      Row{ "L", 4, 1.5e-3, -1.52, -0.22 }, Row{ "L", 8, 1.9e-4, -1.285, -0.28 }, Row{ "L", 16, 2e-5, -1.285, -0.29 },
      Row{ "mix", 4, 1.6e-3, -3.2, 1.0 } })
  {
    const std::vector<double> radii{ 1.0, 1.1, 1.25 };
    MeshCase mesh = row.name[0] == 'm' ? mixedMesh(row.cells, radii)
                                       : starMesh(row.name[0] == 'c' ? Cube : Tromino, row.cells, radii);
    const ConversionOptions options = exact(&body);
    BodyFitOptions fit;
    fit.body = &body;
    Converted converted;
    converted.complex = buildBlockComplex(mesh.mesh());
    if (row.cells > 2)
    {
      fitBody(converted.complex, options, fit);
    }
    conversioncases::convertComplex(converted, options);
    EXPECT_EQ(conversioncases::interfaceJumps(converted).openControlPoints, 0);
    const Joins joins = measureJoins(converted);
    const WallFigures wall = measureWall(converted);
    std::printf("%-4s %2d: jump %.1e wall, %.1e layers, gluing %.1e, distance %.2e, mean curvature %.3f..%.3f, "
                "fitted %d (%d small) linear %d\n",
      row.name, row.cells, joins.wall, joins.layers, joins.gluing, wall.distance, wall.lowest, wall.highest,
      int(converted.report.g1.fittedVertices), int(converted.report.g1.smallFits),
      int(converted.report.g1.linearVertices));
    EXPECT_LE(joins.wall, 1e-8);
    EXPECT_LE(joins.layers, 1e-8);
    EXPECT_LE(joins.gluing, 1e-12);
    EXPECT_LE(wall.distance, row.distance);
    if (row.cells >= 8)
    {
      // 5 % of the body's range; a single-knot wall is 13 to 19 % off at every resolution.
      EXPECT_NEAR(wall.lowest, low, 0.05 * (high - low));
      EXPECT_NEAR(wall.highest, high, 0.05 * (high - low));
    }
    EXPECT_GE(wall.lowest, row.lowest);
    EXPECT_LE(wall.highest, row.highest);
    EXPECT_EQ(converted.report.g1.linearVertices > 0, row.cells < 3);
  }
}

// Volumes stay valid over thin first layers, by proof.
TEST(ExactG1, SpansStayValid)
{
  const BodySurface body(bodycases::starPatches(Eigen::Matrix3d::Identity()));
  for (const double first : { 1e-1, 1e-3, 1e-5 })
  {
    for (int shape = 0; shape < 3; ++shape)
    {
      const int cells = shape == 2 ? 4 : 8;
      const std::vector<double> radii = growing(first / cells);
      MeshCase mesh = shape == 2 ? mixedMesh(cells, radii) : starMesh(shape == 0 ? Cube : Tromino, cells, radii);
      const ConversionOptions options = exact(&body);
      BodyFitOptions fit;
      fit.body = &body;
      Converted converted;
      converted.complex = buildBlockComplex(mesh.mesh());
      fitBody(converted.complex, options, fit);
      conversioncases::convertComplex(converted, options);
      const auto spans = conversioncases::provenValid(converted, [](int, const Ijk&) { return true; });
      std::printf("%s, first layer %.0e h: %d of %d spans valid\n",
        shape == 0     ? "cube"
          : shape == 1 ? "L"
                       : "mix",
        first, int(spans.valid), int(spans.valid + spans.others));
      EXPECT_EQ(spans.others, 0);
    }
  }
}

// The same bits for any numbering, orientation and number of threads: with a body, nodes, short spokes, creases.
TEST(ExactG1, SameBitsForAnyNumberingOrientationAndThreads)
{
  const BodySurface body(bodycases::starPatches(Eigen::Matrix3d::Identity()));
  const MeshCase meshes[] = { starMesh(Tromino, 4, { 1.0, 1.1, 1.25 }), meshcases::ball(3, 3),
    meshcases::ring(5, 1, { { 0.0, 0.2, 0.45 }, { 0.45, 0.7 } }), meshcases::torus(3, 3),
    meshcases::extendedCuboid(3, 3, 1.5, 1.1) };
  for (std::size_t m = 0; m < std::size(meshes); ++m)
  {
    MeshCase mesh = meshes[m];
    if (m != 0 && m != 4)
    {
      mesh.apply(meshcases::wavy);
    }
    const ConversionOptions options = exact(m == 0 ? &body : nullptr);
    const auto convert = [&](MeshCase& of, const Execution& run) {
      Converted result;
      result.complex = buildBlockComplex(of.mesh());
      if (m == 0)
      {
        BodyFitOptions fit;
        fit.body = &body;
        fitBody(result.complex, options, fit);
      }
      conversioncases::convertComplex(result, options, run);
      return result;
    };
    const Converted converted = convert(mesh, {});
    EXPECT_EQ(converted.report.g1.fittedVertices > 0, m == 0) << m;
    EXPECT_EQ(conversioncases::interfaceJumps(converted).openControlPoints, 0) << m;
    EXPECT_GT(converted.report.g1.layers, 0) << m;
    const auto expected = conversioncases::canonicalNet(converted);
    for (int orientation = 1; orientation < meshcases::OrientationCount; orientation += m == 0 ? 7 : 1)
    {
      MeshCase other = mesh;
      for (int block = 0; block < static_cast<int>(other.blocks.size()); ++block)
      {
        meshcases::reorient(other, block, (orientation + 5 * block) % meshcases::OrientationCount);
      }
      EXPECT_TRUE(conversioncases::canonicalNet(convert(other, {})) == expected) << m << " orientation " << orientation;
    }
    for (unsigned seed = 1; seed <= 3; ++seed)
    {
      MeshCase other = mesh;
      meshcases::shuffle(other, seed, seed % 2 == 0);
      EXPECT_TRUE(conversioncases::canonicalNet(convert(other, conversioncases::twoThreads())) == expected)
        << m << " seed " << seed;
    }
  }
}

// Blocks share every control point of their faces, edges and vertices, and the bits are the same for any numbering,
// orientation and threads: where extraordinary edges meet or end in the middle of others' blocks, spokes have one or
// two cells, creases end, and layers keep their points.
TEST(ExactG1, WatertightOnRandomComplexes)
{
  const BodySurface body(bodycases::starPatches(Eigen::Matrix3d::Identity()));
  Index layers = 0, skipped = 0;
  for (unsigned seed = 1; seed <= 48; ++seed)
  {
    SCOPED_TRACE(seed);
    MeshCase mesh = meshcases::randomBoxes(seed);
    ConversionOptions options;
    options.continuity = Continuity::ExactG1;
    options.planarSides = static_cast<PlanarSides>(seed % 3);
    options.checkSpans = seed % 4 < 2 ? CheckSpans::None : CheckSpans::All;
    if (seed % 2 == 0)
    {
      // All boundaries are walls.
      meshcases::declareAll(mesh, seed);
      options.roles = { BoundaryRole::Body };
      options.body = seed % 8 == 0 ? &body : nullptr;
    }
    const Converted converted = conversioncases::convert(mesh.mesh(), options);
    layers += converted.report.g1.layers;
    skipped += converted.report.g1.skippedLayers;
    EXPECT_EQ(conversioncases::interfaceJumps(converted).openControlPoints, 0);
    MeshCase other = mesh;
    meshcases::shuffle(other, seed, seed % 4 == 3);
    EXPECT_TRUE(conversioncases::canonicalNet(conversioncases::convert(other.mesh(), options, {},
                  conversioncases::twoThreads())) == conversioncases::canonicalNet(converted));
  }
  EXPECT_GT(layers, 0);
  EXPECT_GT(skipped, 0);
}

// Through extraordinary vertices of the wall runs a crease: either side of it is smooth up to the vertex, also where
// all points of a spoke depend on its ends, and the change is carried into the layers. (At one cell an edge, layers
// next to those above creases keep their points.)
TEST(ExactG1, SmoothOnEitherSideOfACrease)
{
  Index groups = 0;
  for (const int cells : { 2, 3, 4, 8 })
  {
    MeshCase mesh = mixedMesh(cells, { 1.0, 1.1, 1.25 });
    Converted converted, single;
    for (Converted* each : { &converted, &single })
    {
      BlockComplex& complex = each->complex;
      complex = buildBlockComplex(mesh.mesh());
      for (int v = 0; v < static_cast<int>(complex.vertices.size()); ++v)
      {
        const VertexStar star = vertexStar(complex, v);
        const std::vector<int> spokes = boundaryRing(star).edges;
        const bool wall = complex.vertices[v].boundary && star.point.norm() < 1.2;
        for (const std::size_t k : { std::size_t(0), spokes.size() / 2 })
        {
          if (wall && spokes.size() > 5)
          {
            complex.edges[star.edges[spokes[k]].edge].crease = true;
            ++groups;
          }
        }
      }
    }
    conversioncases::convertComplex(converted, exact());
    ConversionOptions options = exact();
    options.setSingleKnots();
    conversioncases::convertComplex(single, options);
    EXPECT_EQ(conversioncases::interfaceJumps(converted).openControlPoints, 0);
    const double kinks[2] = { measureJoins(single).wall, measureJoins(converted).wall };
    std::printf("%d cells: jump %.1e, with single knots %.1e\n", cells, kinks[1], kinks[0]);
    EXPECT_GT(kinks[0], 1e-3);
    EXPECT_LE(kinks[1], 1e-8);
  }
  EXPECT_GT(groups, 0);
}

// What the fit changes on the wall is carried through all blocks within its range, not twice where two of them meet.
TEST(ExactG1, StacksOfBlocksOverAFittedWall)
{
  const BodySurface body(bodycases::starPatches(Eigen::Matrix3d::Identity()));
  for (const int cells : { 4, 8 })
  {
    MeshCase mesh = starMesh(Tromino, cells, { 1.0, 1.01, 1.025 });
    const MeshCase above = starMesh(Tromino, cells, { 1.025, 1.05, 1.1, 1.25 });
    mesh.blocks.insert(mesh.blocks.end(), above.blocks.begin(), above.blocks.end());
    const ConversionOptions options = exact(&body);
    BodyFitOptions fit;
    fit.body = &body;
    Converted converted;
    converted.complex = buildBlockComplex(mesh.mesh());
    fitBody(converted.complex, options, fit);
    conversioncases::convertComplex(converted, options);
    EXPECT_EQ(conversioncases::interfaceJumps(converted).openControlPoints, 0);
    EXPECT_GT(converted.report.g1.fittedVertices, 0);
    const Joins joins = measureJoins(converted);
    EXPECT_LE(joins.wall, 1e-8);
    EXPECT_LE(joins.layers, 1e-8);
    EXPECT_LE(joins.gluing, 1e-12);
  }
}

// Without extraordinary edges nothing changes.
TEST(ExactG1, RegularMeshesKeepTheirKnots)
{
  MeshCase mesh = meshcases::cutBox({ 4, 4, 4 }, { { { 2 }, { 2 }, {} } }, meshcases::wavy);
  const Converted converted = conversioncases::convert(mesh.mesh(), exact());
  const Converted single = conversioncases::convert(mesh.mesh());
  EXPECT_TRUE(conversioncases::canonicalNet(converted) == conversioncases::canonicalNet(single));
}

// Fitted between its mesh points the wall is closer to the body than through them, and as smooth.
TEST(ExactG1, LeastSquaresIsCloserThanInterpolation)
{
  const BodySurface body(bodycases::starPatches(Eigen::Matrix3d::Identity()));
  double rms = 1.0;
  for (const int cells : { 6, 12 })
  {
    for (const bool cut : { false, true })
    {
      MeshCase mesh = starMesh(Cube, cells, { 1.0, 1.1, 1.25 });
      const ConversionOptions options = exact(&body);
      BodyFitOptions fit;
      fit.body = &body;
      fit.leastSquares = true;
      if (cut)
      {
        meshcases::shuffle(mesh, 3);
      }
      Converted converted;
      converted.complex = buildBlockComplex(mesh.mesh());
      const BodyFitReport report = fitBody(converted.complex, options, fit);
      conversioncases::convertComplex(converted, options);
      const Joins joins = measureJoins(converted);
      std::printf("%2d spans: samples off by %.2e, RMS %.2e; before %.2e, RMS %.2e\n", cells, report.sampleDistance[1],
        report.sampleRms[1], report.sampleDistance[0], report.sampleRms[0]);
      EXPECT_LT(report.sampleRms[1], 0.75 * report.sampleRms[0]);
      EXPECT_LE(joins.layers, 1e-8);
      // The same bits for any numbering and orientation.
      EXPECT_TRUE(!cut || report.sampleRms[1] == rms);
      rms = report.sampleRms[1];
    }
  }
}

// Borders of the wall are fitted between their mesh points, too: as curves, whatever the numbering.
TEST(ExactG1, LeastSquaresFitsBorders)
{
  const BodySurface body(bodycases::starPatches(Eigen::Matrix3d::Identity()));
  const auto largestOnBorders = [&](unsigned seed, bool leastSquares) {
    MeshCase mesh = starMesh(Cube, 8, { 1.0, 1.1, 1.25 });
    mesh.blocks.resize(1);
    mesh.boundaries.resize(1);
    if (seed > 0)
    {
      meshcases::shuffle(mesh, seed);
    }
    const ConversionOptions options = exact(&body);
    BodyFitOptions fit;
    fit.body = &body;
    fit.leastSquares = leastSquares;
    Converted converted;
    converted.complex = buildBlockComplex(mesh.mesh());
    fitBody(converted.complex, options, fit);
    conversioncases::convertComplex(converted, options);
    double largest = 0.0;
    for (const ComplexFace& face : converted.complex.faces)
    {
      if (face.uses.front().block != 0 || face.tag != 0)
      {
        continue;
      }
      const FaceAt at{ converted.volumes[0], face.uses.front() };
      for (int side = 0; side < 4; ++side)
      {
        const int axis = side / 2;
        // At corners the curve ends with curvature 0.
        for (int i = 20; i <= 60; ++i)
        {
          const double along = at.length(axis) * i / 80.0, across = side % 2 ? at.length(1 - axis) : 0.0;
          const Vec3 x = evaluate(at.volume, axis == 0 ? at.at(along, across) : at.at(across, along));
          largest = std::max(largest, body.closestPoint(x).distance);
        }
      }
    }
    return largest;
  };
  const double through = largestOnBorders(0, false), between = largestOnBorders(0, true);
  EXPECT_GT(through, 0.0);
  EXPECT_LT(between, 0.6 * through);
  EXPECT_NEAR(largestOnBorders(2, true), between, 1e-12);
  std::printf("borders off by %.2e through their mesh points, %.2e between them\n", through, between);
}

// The samples that the fit sees are those of the converted wall.
TEST(ExactG1, SamplesAreThoseOfTheConvertedWall)
{
  MeshCase mesh = starMesh(Cube, 5, { 1.0, 1.1, 1.25 });
  // With borders.
  mesh.blocks.resize(3);
  mesh.boundaries.resize(3);
  ConversionOptions options = exact();
  options.continuity = Continuity::SingleKnots;
  const Converted converted = conversioncases::convert(mesh.mesh(), options);
  const EntityRules rules = classify(converted.complex, options, {});
  const Wall wall(converted.complex, rules);
  const LimitRows rows(converted.complex, rules, wall);
  const std::vector<Vec3> given = wall.points(*aloneRank());
  const WallSamples samples(converted.complex, rows, wall, given);
  std::vector<Vec3> places;
  for (const BSplineVolume& volume : converted.volumes)
  {
    for (int j = 0; j < 5 * WallSamples::PerSpan; ++j)
    {
      for (int i = 0; i < 5 * WallSamples::PerSpan; ++i)
      {
        places.push_back(
          evaluate(volume, Vec3((i + 0.5) / WallSamples::PerSpan, (j + 0.5) / WallSamples::PerSpan, 0.0)));
      }
      for (const double side : { 0.0, 5.0 })
      {
        const double along = (j + 0.5) / WallSamples::PerSpan;
        places.push_back(evaluate(volume, Vec3(along, side, 0.0)));
        places.push_back(evaluate(volume, Vec3(side, along, 0.0)));
      }
    }
  }
  double worst = 0.0;
  for (const Vec3& sample : samples.evaluate(given, {}))
  {
    double nearest = 1.0;
    for (const Vec3& place : places)
    {
      nearest = std::min(nearest, (place - sample).norm());
    }
    worst = std::max(worst, nearest);
  }
  EXPECT_GT(samples.firstOnCurves(), 0);
  EXPECT_GT(samples.size(), samples.firstOnCurves());
  EXPECT_LE(worst, 1e-13);
}
