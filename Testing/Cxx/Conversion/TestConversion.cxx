// SPDX-License-Identifier: BSD-3-Clause
#include "Support/ConversionCases.h"
#include "Support/MeshCases.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>

using namespace bsv;
using conversioncases::convert;
using conversioncases::Converted;
using meshcases::MeshCase;

namespace
{

/// The cases that the general properties are tested on.
struct NamedCase
{
  std::string name;
  std::function<MeshCase()> make;
};

/// Blocks, cut at i = 3 and at the given k, whose top (k = K) has a ridge along j = 2; the layers below it are thin.
MeshCase ridge(const std::vector<int>& cutsInK = {})
{
  return meshcases::cutBox({ 6, 4, 3 }, { { { 3 }, {}, cutsInK } }, [](const Vec3& x) {
    const double lift = x[2] * (0.3 * std::abs(x[1] - 2.0) + 0.05 * std::sin(x[0]));
    return Vec3(x[0] + 0.1 * std::sin(x[0] + x[2]), x[1] + 0.03 * x[0] * x[0] * (x[2] / 3.0), x[2] - lift);
  });
}

MeshCase taggedRidge(const std::vector<int>& cutsInK = {})
{
  MeshCase mesh = ridge(cutsInK);
  for (int b = 0; b < static_cast<int>(mesh.blocks.size()); ++b)
  {
    const Ijk cells = mesh.blocks[b].cells();
    if (b >= static_cast<int>(mesh.blocks.size()) - 2)
    {
      mesh.creases.push_back({ b, { 0, 2, cells[2] }, { 3, 2, cells[2] } });
    }
  }
  return mesh;
}

std::vector<NamedCase> cases()
{
  const auto wavy = [](MeshCase mesh) {
    mesh.apply(meshcases::wavy);
    return mesh;
  };
  const std::vector<std::vector<double>> stacks{ { 0.0, 0.2, 0.45 }, { 0.45, 0.7, 1.0, 1.3 } };
  return {
    { "box",
      [=] {
        return wavy(meshcases::cutBox({ 9, 8, 10 }, { { { 5 }, { 1, 3 }, { 4 } } }));
      } },
    { "oneCellBlocks",
      [=] {
        return wavy(meshcases::cutBox({ 3, 3, 3 }, { { { 1, 2 }, { 1, 2 }, { 1, 2 } } }));
      } },
    { "ring3", [=] { return wavy(meshcases::ring(3, 3, stacks)); } },
    { "ring5", [=] { return wavy(meshcases::ring(5, 3, stacks)); } },
    { "ring6OneCell", [=] { return wavy(meshcases::ring(6, 1, stacks)); } },
    { "ring8", [=] { return meshcases::ring(8, 2, stacks); } },
    { "sphereBody",
      [=] {
        return meshcases::sphereBody(8, { 1.0, 1.1, 1.25, 1.5, 2.0, 2.7, 3.5 });
      } },
    { "ball", [=] { return meshcases::ball(6, 5); } },
    { "torus", [=] { return meshcases::torus(3, 7); } },
    { "oGrid",
      [=] {
        return wavy(meshcases::oGrid({ 8, 3, 2 }));
      } },
    { "closedShell",
      [=] {
        return wavy(meshcases::closedShell({ 7, 8, 3 }));
      } },
    { "cGrid", [=] { return meshcases::cGrid(4, 12, 3, 2); } },
    { "ridge",
      [=] {
        return taggedRidge({ 1, 2 });
      } },
    { "lShape", [=] { return wavy(meshcases::lShape(3)); } },
  };
}

/// Uniform cubic B-spline basis (derivative order d) of the four control points around span coordinate u in [0, 1].
std::array<double, 4> uniformBasis(double u, int d)
{
  switch (d)
  {
    case 0:
      return { (1 - u) * (1 - u) * (1 - u) / 6, (4 - 6 * u * u + 3 * u * u * u) / 6,
        (1 + 3 * u + 3 * u * u - 3 * u * u * u) / 6, u * u * u / 6 };
    case 1:
      return { -(1 - u) * (1 - u) / 2, (-12 * u + 9 * u * u) / 6, (3 + 6 * u - 9 * u * u) / 6, u * u / 2 };
    default:
      return { 1 - u, 3 * u - 2, 1 - 3 * u, u };
  }
}

} // namespace

// The B-spline of the uncut grid is computed here from the uniform basis, with the control net continued linearly
// beyond its border, which is what an end point that is interpolated with zero second derivative means.
TEST(Conversion, CutGridEqualsTheSplineOfTheUncutGrid)
{
  const Ijk cells{ 6, 5, 7 };
  MeshCase mesh = meshcases::cutBox(cells, { { { 1, 4 }, { 2 }, { 3, 6 } } }, meshcases::wavy);
  std::map<std::array<int, 3>, Vec3> lattice;
  for (int k = -1; k <= cells[2] + 1; ++k)
    for (int j = -1; j <= cells[1] + 1; ++j)
      for (int i = -1; i <= cells[0] + 1; ++i)
      {
        Vec3 x = Vec3::Zero();
        // Linear continuation per direction: f(-1) = 2 f(0) - f(1).
        const std::array<int, 3> at{ i, j, k };
        for (int corner = 0; corner < 8; ++corner)
        {
          std::array<int, 3> from = at;
          double weight = 1.0;
          for (int d = 0; d < 3; ++d)
          {
            const bool second = (corner >> d & 1) != 0;
            if (at[d] < 0 || at[d] > cells[d])
            {
              from[d] = at[d] < 0 ? (second ? 1 : 0) : cells[d] - (second ? 1 : 0);
              weight *= second ? -1.0 : 2.0;
            }
            else
            {
              weight *= second ? 0.0 : 1.0;
            }
          }
          if (weight != 0.0)
          {
            x += weight * meshcases::wavy(Vec3(from[0], from[1], from[2]));
          }
        }
        lattice[at] = x;
      }
  // Where each block sits in the lattice, found from its corner points before anything is renumbered.
  meshcases::shuffle(mesh, 7, true);
  const Converted converted = convert(mesh.mesh());
  ASSERT_EQ(converted.volumes.size(), 3u * 2 * 3);
  double worst[3] = { 0, 0, 0 };
  double size[3] = { 0, 0, 0 };
  for (std::size_t b = 0; b < converted.volumes.size(); ++b)
  {
    const ComplexBlock& block = converted.complex.blocks[b];
    const auto latticeAt = [&](const Ijk& p) {
      const Vec3 x = block.points(p);
      for (const auto& [at, value] : lattice)
      {
        if (value == x)
        {
          return Eigen::Vector3i(at[0], at[1], at[2]);
        }
      }
      ADD_FAILURE() << "point of block " << b << " is not in the lattice";
      return Eigen::Vector3i(0, 0, 0);
    };
    const Eigen::Vector3i origin = latticeAt({ 0, 0, 0 });
    Eigen::Matrix3i axes;
    axes.col(0) = latticeAt({ 1, 0, 0 }) - origin;
    axes.col(1) = latticeAt({ 0, 1, 0 }) - origin;
    axes.col(2) = latticeAt({ 0, 0, 1 }) - origin;
    for (double w = 0.0; w <= block.cells(2); w += 0.5)
      for (double v = 0.0; v <= block.cells(1); v += 0.25)
        for (double u = 0.0; u <= block.cells(0); u += 0.375)
          for (const std::array<int, 3>& d : std::vector<std::array<int, 3>>{
                 { 0, 0, 0 }, { 1, 0, 0 }, { 0, 0, 1 }, { 0, 2, 0 }, { 1, 1, 0 }, { 0, 1, 1 }, { 2, 0, 0 } })
          {
            const Vec3 value = evaluate(converted.volumes[b], Vec3(u, v, w), d);
            const Vec3 where = origin.cast<double>() + axes.cast<double>() * Vec3(u, v, w);
            std::array<std::array<double, 4>, 3> basis;
            std::array<int, 3> span;
            double sign = 1.0;
            for (int g = 0; g < 3; ++g)
            {
              int order = 0;
              for (int l = 0; l < 3; ++l)
              {
                if (axes(g, l) != 0)
                {
                  order = d[l];
                  sign *= axes(g, l) < 0 && d[l] % 2 == 1 ? -1.0 : 1.0;
                }
              }
              span[g] = std::min(static_cast<int>(std::floor(where[g])), cells[g] - 1);
              basis[g] = uniformBasis(where[g] - span[g], order);
            }
            Vec3 expected = Vec3::Zero();
            for (int c = 0; c < 4; ++c)
              for (int bb = 0; bb < 4; ++bb)
                for (int a = 0; a < 4; ++a)
                  expected += basis[0][a] * basis[1][bb] * basis[2][c] *
                    lattice.at({ span[0] + a - 1, span[1] + bb - 1, span[2] + c - 1 });
            const int order = d[0] + d[1] + d[2];
            worst[order] = std::max(worst[order], (value - sign * expected).norm());
            size[order] = std::max(size[order], value.norm());
          }
  }
  for (int order = 0; order < 3; ++order)
  {
    // Derivatives are differences of coordinates: their rounding is relative to the coordinates as well.
    EXPECT_LE(worst[order], 1e-13 * std::max(size[order], size[0])) << "order " << order;
    std::printf(
      "cut against uncut grid, derivatives of order %d: %.1e of the coordinates\n", order, worst[order] / size[0]);
  }
}

TEST(Conversion, EveryControlPointIsWrittenAndSharedOnesAreEqual)
{
  for (const NamedCase& named : cases())
  {
    SCOPED_TRACE(named.name);
    MeshCase mesh = named.make();
    const Converted converted = convert(mesh.mesh());
    Index count = 0;
    for (std::size_t b = 0; b < converted.points.size(); ++b)
    {
      for (const double x : converted.points[b])
      {
        ASSERT_TRUE(std::isfinite(x)) << "block " << b;
      }
      for (const std::uint8_t rule : converted.rules[b])
      {
        ASSERT_LT(rule, controlPointRuleNames().size());
        ++count;
      }
    }
    Index reported = 0;
    for (const Index n : converted.report.controlPoints)
    {
      reported += n;
    }
    EXPECT_EQ(reported, count);
    EXPECT_EQ(conversioncases::interfaceJumps(converted).openControlPoints, 0);
  }
}

TEST(Conversion, RegularInterfacesAreC2)
{
  Index regular = 0;
  for (const NamedCase& named : cases())
  {
    SCOPED_TRACE(named.name);
    MeshCase mesh = named.make();
    ConversionOptions options;
    options.planarSides = PlanarSides::None;
    const auto jumps = conversioncases::interfaceJumps(convert(mesh.mesh(), options));
    EXPECT_LE(jumps.worst[0], 1.0);
    EXPECT_LE(jumps.worst[1], 1.0);
    EXPECT_LE(jumps.worst[2], 1.0);
    regular += jumps.regular;
  }
  EXPECT_GT(regular, 4000); // the property was looked at
}

TEST(Conversion, SameBitsForAnyNumberingOrientationAndThreads)
{
  for (const NamedCase& named : cases())
  {
    SCOPED_TRACE(named.name);
    MeshCase mesh = named.make();
    const auto reference = conversioncases::canonicalNet(convert(mesh.mesh()));
    for (unsigned seed = 1; seed <= 4; ++seed)
    {
      MeshCase other = named.make();
      meshcases::shuffle(other, seed, seed % 2 == 0);
      const auto net = conversioncases::canonicalNet(
        convert(other.mesh(), {}, {}, seed > 2 ? conversioncases::twoThreads() : Execution{}));
      ASSERT_EQ(net.size(), reference.size());
      EXPECT_TRUE(net == reference) << "seed " << seed;
    }
  }
}

TEST(Conversion, SameBitsForEachOfThe24OrientationsOfEachBlock)
{
  for (const NamedCase& named : cases())
  {
    SCOPED_TRACE(named.name);
    MeshCase mesh = named.make();
    const auto reference = conversioncases::canonicalNet(convert(mesh.mesh()));
    for (int orientation = 1; orientation < meshcases::OrientationCount; ++orientation)
    {
      MeshCase other = named.make();
      for (int block = 0; block < static_cast<int>(other.blocks.size()); ++block)
      {
        meshcases::reorient(other, block, (orientation + 5 * block) % meshcases::OrientationCount);
      }
      EXPECT_TRUE(conversioncases::canonicalNet(convert(other.mesh())) == reference) << "orientation " << orientation;
    }
  }
}

TEST(Conversion, RandomComplexesAreWatertightAndKeepTheirBits)
{
  for (unsigned seed = 1; seed <= 300; ++seed)
  {
    SCOPED_TRACE(seed);
    MeshCase mesh = meshcases::randomBoxes(seed);
    ConversionOptions options;
    options.planarSides = static_cast<PlanarSides>(seed % 3);
    const Converted converted = convert(mesh.mesh(), options);
    for (const auto& points : converted.points)
    {
      ASSERT_TRUE(std::all_of(points.begin(), points.end(), [](double x) { return std::isfinite(x); }));
    }
    const auto jumps = conversioncases::interfaceJumps(converted);
    EXPECT_EQ(jumps.openControlPoints, 0);
    if (options.planarSides == PlanarSides::None)
    {
      // What carries the name of a smooth rule is smooth.
      EXPECT_LE(*std::max_element(jumps.worst.begin(), jumps.worst.end()), 1.0);
    }
    MeshCase other = mesh;
    meshcases::shuffle(other, seed, seed % 2 == 0);
    EXPECT_TRUE(
      conversioncases::canonicalNet(convert(other.mesh(), options)) == conversioncases::canonicalNet(converted));
  }
}

// The border between two stacks of blocks crosses the extraordinary edge; the curve of the edge and the surfaces around
// it must pass it with one derivative along the edge.
TEST(Conversion, ExtraordinaryEdgeCrossesStackedBlocksC1)
{
  for (const int valence : { 3, 5, 6, 7, 8 })
  {
    for (const double ratio : { 1.0, 1.2, 1.5, 2.0 })
    {
      MeshCase mesh = meshcases::ring(valence, 3, { { 0.0, 0.5, 1.0 }, { 1.0, 1.0 + 0.5 * ratio, 1.0 + ratio } });
      mesh.apply(meshcases::wavy);
      meshcases::shuffle(mesh, 3);
      const Converted converted = convert(mesh.mesh());
      double worst = 0.0;
      int points = 0;
      for (const ComplexFace& face : converted.complex.faces)
      {
        if (face.boundary())
        {
          continue;
        }
        // Only the faces between the stacks: their points all have the height of the border before the map.
        const FaceUse a = face.uses[0], b = face.uses[1];
        const int na = faceDirection(a.face), nb = faceDirection(b.face);
        bool between = true;
        const ComplexBlock& owner = converted.complex.blocks[a.block];
        for (int corner = 0; corner < 4; ++corner)
        {
          const Ijk cells{ owner.cells(0), owner.cells(1), owner.cells(2) };
          const Vec3 x = owner.points(facePoint(
            cells, a.face, (corner & 1) * cells[faceAxis(a.face, 0)], (corner >> 1) * cells[faceAxis(a.face, 1)]));
          bool found = false;
          MeshCase plain = meshcases::ring(valence, 3, { { 0.0, 0.5, 1.0 }, { 1.0, 1.0 + 0.5 * ratio, 1.0 + ratio } });
          for (const auto& block : plain.blocks)
          {
            for (const Vec3& p : block.points)
            {
              found = found || (p[2] == 1.0 && meshcases::wavy(p) == x);
            }
          }
          between = between && found;
        }
        if (!between)
        {
          continue;
        }
        const BSplineVolume &va = converted.volumes[a.block], &vb = converted.volumes[b.block];
        for (double t = 0.0; t <= va.count(faceAxis(a.face, 1)) - 3; t += 0.25)
        {
          for (double s = 0.0; s <= va.count(faceAxis(a.face, 0)) - 3; s += 0.25)
          {
            Vec3 ua, ub;
            ua[faceAxis(a.face, 0)] = s;
            ua[faceAxis(a.face, 1)] = t;
            ua[na] = faceSide(a.face) ? va.count(na) - 3 : 0;
            const bool swap = swapsAxes(face.orientation);
            const double u = swap ? t : s, v = swap ? s : t;
            const int sb = faceAxis(b.face, 0), tb = faceAxis(b.face, 1);
            ub[sb] = (face.orientation & 2) ? vb.count(sb) - 3 - u : u;
            ub[tb] = (face.orientation & 4) ? vb.count(tb) - 3 - v : v;
            ub[nb] = faceSide(b.face) ? vb.count(nb) - 3 : 0;
            std::array<int, 3> da{}, db{};
            da[na] = db[nb] = 1;
            const double sign = faceSide(a.face) != faceSide(b.face) ? 1.0 : -1.0;
            const Vec3 x = evaluate(va, ua, da), y = sign * evaluate(vb, ub, db);
            worst = std::max(worst, (x - y).norm() / x.norm());
            ++points;
          }
        }
      }
      EXPECT_GT(points, 100 * valence);
      EXPECT_LE(worst, 1e-12) << "valence " << valence << ", spacing ratio " << ratio;
    }
  }
}

TEST(Conversion, CommutesWithAffineMaps)
{
  Eigen::Matrix3d matrix;
  matrix << 1.5, 0.3, -0.2, 0.1, 0.8, 0.4, -0.35, 0.2, 1.1;
  const Vec3 shift(0.7, -1.3, 0.4);
  for (const NamedCase& named : cases())
  {
    SCOPED_TRACE(named.name);
    MeshCase mesh = named.make();
    MeshCase mapped = named.make();
    mapped.apply([&](const Vec3& x) { return Vec3(matrix * x + shift); });
    const Converted a = convert(mesh.mesh());
    const Converted b = convert(mapped.mesh());
    ASSERT_EQ(a.points.size(), b.points.size());
    double worst = 0.0, size = 0.0;
    for (std::size_t block = 0; block < a.points.size(); ++block)
    {
      ASSERT_EQ(a.points[block].size(), b.points[block].size());
      for (std::size_t i = 0; i < a.points[block].size(); i += 3)
      {
        const Vec3 expected = matrix * Vec3(a.points[block].data() + i) + shift;
        worst = std::max(worst, (expected - Vec3(b.points[block].data() + i)).norm());
        size = std::max(size, expected.norm());
      }
    }
    EXPECT_LE(worst, 1e-13 * size);
  }
}

// A mesh that is an affine image of the integer lattice is reproduced: the volume is that affine map of its parameters.
TEST(Conversion, ReproducesLinearData)
{
  Eigen::Matrix3d matrix;
  matrix << 1.5, 0.3, -0.2, 0.1, 0.8, 0.4, -0.35, 0.2, 1.1;
  MeshCase mesh = meshcases::cutBox(
    { 4, 5, 3 }, { { { 1 }, { 3 }, { 2 } } }, [&](const Vec3& x) { return Vec3(matrix * x + Vec3(1, 2, 3)); });
  const Converted converted = convert(mesh.mesh());
  for (std::size_t b = 0; b < converted.volumes.size(); ++b)
  {
    const ComplexBlock& block = converted.complex.blocks[b];
    for (double w = 0; w <= block.cells(2); w += 0.5)
      for (double v = 0; v <= block.cells(1); v += 0.5)
        for (double u = 0; u <= block.cells(0); u += 0.5)
        {
          const Vec3 origin = block.points(0, 0, 0);
          const Vec3 expected = origin + u * (block.points(1, 0, 0) - origin) + v * (block.points(0, 1, 0) - origin) +
            w * (block.points(0, 0, 1) - origin);
          EXPECT_LE((evaluate(converted.volumes[b], Vec3(u, v, w)) - expected).norm(), 1e-13 * expected.norm());
        }
  }
}

TEST(Conversion, CountsSingularNodes)
{
  MeshCase ball = meshcases::ball(3, 2);
  EXPECT_EQ(convert(ball.mesh()).report.singularNodes, 8);
  MeshCase ring = meshcases::ring(5, 2, { { 0, 1, 2 }, { 2, 3, 4 } });
  EXPECT_EQ(convert(ring.mesh()).report.singularNodes, 0);
}

// Around a node where four blocks meet as in a tetrahedron one linear map takes its four corners to the edges: their
// sum is 0, whatever the mesh.
TEST(Conversion, SingularNodesAreAffineStars)
{
  for (const double amplitude : { 0.0, 0.06 })
  {
    MeshCase ball = meshcases::ball(4, 3);
    ball.apply([amplitude](const Vec3& x) {
      return Vec3(x + amplitude * Vec3(std::sin(3.0 * x[1] + 1.0), std::sin(2.0 * x[2]), std::cos(2.0 * x[0] + x[1])));
    });
    const Converted converted = convert(ball.mesh());
    int nodes = 0;
    for (const ComplexVertex& vertex : converted.complex.vertices)
    {
      if (vertex.boundary || vertex.corners.size() != 4)
      {
        continue;
      }
      ++nodes;
      std::vector<Vec3> edges;
      double shape = 1.0;
      for (const CornerUse& use : vertex.corners)
      {
        const BSplineVolume& volume = converted.volumes[use.block];
        const GridView points(volume.points, { volume.count(0), volume.count(1), volume.count(2) });
        Ijk corner;
        for (int d = 0; d < 3; ++d)
        {
          corner[d] = cornerSide(use.corner, d) ? volume.count(d) - 1 : 0;
        }
        Eigen::Matrix3d frame;
        for (int d = 0; d < 3; ++d)
        {
          Ijk next = corner;
          next[d] += corner[d] > 0 ? -1 : 1;
          const Vec3 edge = points(next) - points(corner);
          frame.col(d) = edge.normalized();
          if (std::find(edges.begin(), edges.end(), edge) == edges.end())
          {
            edges.push_back(edge);
          }
        }
        shape = std::min(shape, std::abs(frame.determinant()));
      }
      ASSERT_EQ(edges.size(), 4u);
      const Vec3 sum = edges[0] + edges[1] + edges[2] + edges[3];
      const double mean = (edges[0].norm() + edges[1].norm() + edges[2].norm() + edges[3].norm()) / 4.0;
      EXPECT_LE(sum.norm(), 1e-12 * mean);
      // Of a regular tetrahedron's edges: 16 / (3 sqrt(27)) = 0.77.
      EXPECT_GT(shape, 0.6);
    }
    EXPECT_EQ(nodes, 8);
  }
}

TEST(Conversion, WallSpacingMovesTheFirstLayerOnly)
{
  for (const double c : { 0.3, 0.9 })
  {
    MeshCase mesh = meshcases::sphereBody(4, { 1.0, 1.1, 1.25, 1.5 });
    // Name the body: the faces k = 0.
    mesh.boundaryNames = { "wall" };
    for (int b = 0; b < static_cast<int>(mesh.blocks.size()); ++b)
    {
      mesh.boundaries.push_back({ b, 4, { { 0, 0 }, { 4, 4 } }, 0 });
    }
    ConversionOptions options;
    options.roles = { BoundaryRole::Body };
    const Converted regular = convert(mesh.mesh(), options);
    options.wallSpacing = c;
    const Converted moved = convert(mesh.mesh(), options);
    for (std::size_t b = 0; b < regular.volumes.size(); ++b)
    {
      for (int k = 0; k < regular.volumes[b].count(2); ++k)
        for (int j = 0; j < regular.volumes[b].count(1); ++j)
          for (int i = 0; i < regular.volumes[b].count(0); ++i)
          {
            const int block = static_cast<int>(b);
            const Vec3 before = regular.controlPoint(block, { i, j, k });
            const Vec3 after = moved.controlPoint(block, { i, j, k });
            if (k != 1)
            {
              EXPECT_EQ(before, after);
            }
            else
            {
              // p_1/3 = c p_0 + (1 - c) p_1 with p_0 on the converted wall (5.44): offsets scale with 3 (1 - c).
              const Vec3 wall = regular.controlPoint(block, { i, j, 0 });
              EXPECT_LE((after - wall - 3.0 * (1.0 - c) * (before - wall)).norm(), 1e-14);
            }
          }
    }
    const auto jumps = conversioncases::interfaceJumps(moved);
    EXPECT_LE(jumps.worst[2], 1.0);
    EXPECT_EQ(jumps.openControlPoints, 0);
  }
}

TEST(Conversion, PlanarSidesKeepTheirPoints)
{
  // A box with curved inside and plane outside.
  const auto map = [](const Vec3& x) {
    const double bump = x[0] * (4 - x[0]) * x[1] * (4 - x[1]) * x[2] * (4 - x[2]) / 64.0;
    return Vec3(x[0] + 0.02 * x[0] * x[0] + 0.1 * bump, x[1] + 0.03 * x[1] * x[1] - 0.1 * bump, x[2] + 0.05 * bump);
  };
  MeshCase mesh = meshcases::cutBox({ 4, 4, 4 }, { { { 2 }, { 2 }, { 2 } } }, map);
  for (const PlanarSides mode : { PlanarSides::FarField, PlanarSides::None })
  {
    ConversionOptions options;
    options.planarSides = mode;
    const Converted converted = convert(mesh.mesh(), options);
    int moved = 0, kept = 0;
    for (std::size_t v = 0; v < converted.complex.vertices.size(); ++v)
    {
      const ComplexVertex& vertex = converted.complex.vertices[v];
      if (!vertex.boundary || vertex.corners.size() != 4)
      {
        continue; // inside of a planar side: four blocks
      }
      const CornerUse use = vertex.corners.front();
      const ComplexBlock& block = converted.complex.blocks[use.block];
      Ijk mesh, net;
      for (int d = 0; d < 3; ++d)
      {
        mesh[d] = cornerSide(use.corner, d) ? block.cells(d) : 0;
        net[d] = cornerSide(use.corner, d) ? block.cells(d) + 2 : 0;
      }
      (block.points(mesh) == converted.controlPoint(use.block, net) ? kept : moved) += 1;
    }
    EXPECT_EQ(mode == PlanarSides::FarField ? moved : kept, 0);
    EXPECT_EQ(kept + moved, 6);
    EXPECT_EQ(converted.report.planarFaces, mode == PlanarSides::FarField ? 24 : 0);
  }
}

// At the limit a side is curved in every numbering, and the report says so; beside it, it does not.
TEST(Conversion, PlanarSidesHaveAMargin)
{
  const auto map = [](const Vec3& x) {
    return Vec3(x[0], x[1], x[2] + 1e-4 * x[2] * std::sin(1.0 + 2.0 * x[0] + 3.0 * x[1]));
  };
  MeshCase mesh = meshcases::cutBox({ 4, 3, 4 }, {}, map);
  const auto converted = [&](MeshCase& some, double tolerance) {
    ConversionOptions options;
    options.planarSides = PlanarSides::All;
    options.planarTolerance = tolerance;
    return convert(some.mesh(), options).report;
  };
  // Every tolerance at which one side more is planar.
  std::vector<double> limits;
  for (double below = 1e-9; limits.size() < 5;)
  {
    const Index planar = converted(mesh, below).planarFaces;
    double least = below, most = 1.0;
    while (most > least * (1.0 + 1e-12))
    {
      const double middle = std::sqrt(least * most);
      (converted(mesh, middle).planarFaces > planar ? most : least) = middle;
    }
    if (most >= 0.5)
    {
      break;
    }
    limits.push_back(most);
    below = most * 1.01;
  }
  ASSERT_FALSE(limits.empty());
  for (const double limit : limits)
  {
    EXPECT_TRUE(converted(mesh, 0.99 * limit).notes.empty());
    EXPECT_TRUE(converted(mesh, 1.01 * limit).notes.empty());
    // The margin is a thousandth: exactly at the limit a side's deviation is as far from it as it can be taken.
    const double exact = limit * (1.0 - 1e-3);
    const ConversionReport report = converted(mesh, exact);
    EXPECT_EQ(report.notes.size(), 1);
    for (int orientation = 0; orientation < 48; ++orientation)
    {
      MeshCase turned = mesh;
      meshcases::reorient(turned, 0, orientation);
      const ConversionReport other = converted(turned, exact);
      EXPECT_EQ(other.planarFaces, report.planarFaces);
      EXPECT_EQ(other.notes, report.notes);
    }
  }
}

// Along a crease the surface is the cubic B-spline curve of the crease's own points, whatever lies beside it.
TEST(Conversion, CreaseIsTheSplineOfItsOwnPoints)
{
  MeshCase mesh = taggedRidge();
  std::vector<Vec3> line;
  for (int b = 0; b < 2; ++b)
  {
    for (int i = b == 0 ? 0 : 1; i <= 3; ++i)
    {
      line.push_back(mesh.blocks[b].at({ i, 2, 3 }));
    }
  }
  line.insert(line.begin(), 2.0 * line[0] - line[1]);
  line.push_back(2.0 * line.back() - line[line.size() - 2]);
  const Converted converted = convert(mesh.mesh());
  ASSERT_EQ(converted.volumes.size(), 4u); // the line runs inside the faces: both blocks are cut
  int curves = 0;
  for (const ComplexEdge& edge : converted.complex.edges)
  {
    if (!edge.crease)
    {
      continue;
    }
    ++curves;
    for (const EdgeUse& use : edge.uses)
    {
      const BSplineVolume& volume = converted.volumes[use.block];
      const int along = edgeDirection(use.edge);
      const Vec3 start =
        converted.complex.blocks[use.block].points(facePoint({ 3, 2, 3 }, 5, 0, edgeSide(use.edge, 0) ? 2 : 0));
      const int first = start == line[1] ? 0 : 3;
      for (double u = 0.0; u <= 3.0; u += 0.125)
      {
        Vec3 parameter;
        parameter[along] = u;
        for (int axis = 0; axis < 2; ++axis)
        {
          const int d = faceAxis(2 * along, axis);
          parameter[d] = edgeSide(use.edge, axis) ? volume.count(d) - 3 : 0;
        }
        const int span = std::min(static_cast<int>(u), 2);
        const auto basis = uniformBasis(u - span, 0);
        Vec3 expected = Vec3::Zero();
        for (int a = 0; a < 4; ++a)
        {
          expected += basis[a] * line[first + span + a];
        }
        EXPECT_LE((evaluate(volume, parameter) - expected).norm(), 1e-14 * expected.norm());
      }
    }
  }
  EXPECT_EQ(curves, 2);
}

// Above a crease the volume keeps a fading edge; along it everything stays C2, also where blocks end.
TEST(Conversion, CreaseFadesIntoTheVolumeAndStaysC2Along)
{
  MeshCase mesh = taggedRidge({ 1, 2 });
  ConversionOptions options;
  options.planarSides = PlanarSides::None;
  const Converted converted = convert(mesh.mesh(), options);
  double worst = 0.0, kink = 0.0;
  Index points = 0;
  for (const ComplexFace& face : converted.complex.faces)
  {
    const FaceUse a = face.uses.front();
    if (face.boundary() || faceDirection(a.face) == 2)
    {
      continue;
    }
    const FaceUse b = face.uses.back();
    ASSERT_EQ(face.orientation, 0);
    const int n = faceDirection(a.face);
    const BSplineVolume &va = converted.volumes[a.block], &vb = converted.volumes[b.block];
    for (double t = 0.0; t <= va.count(faceAxis(a.face, 1)) - 3; t += 0.25)
    {
      for (double s = 0.0; s <= va.count(faceAxis(a.face, 0)) - 3; s += 0.25)
      {
        Vec3 ua, ub;
        ua[faceAxis(a.face, 0)] = ub[faceAxis(a.face, 0)] = s;
        ua[faceAxis(a.face, 1)] = ub[faceAxis(a.face, 1)] = t;
        ua[n] = faceSide(a.face) ? va.count(n) - 3 : 0;
        ub[n] = faceSide(b.face) ? vb.count(n) - 3 : 0;
        std::array<int, 3> first{}, second{};
        first[n] = 1;
        second[n] = 2;
        const double jump = (evaluate(va, ua, first) - evaluate(vb, ub, first)).norm();
        if (n == 0) // across i, along the crease
        {
          worst = std::max({ worst, jump, (evaluate(va, ua, second) - evaluate(vb, ub, second)).norm() });
          ++points;
        }
        else
        {
          kink = std::max(kink, jump);
        }
      }
    }
  }
  EXPECT_GT(points, 250);
  EXPECT_LE(worst, 64 * std::numeric_limits<double>::epsilon() * 6.0);
  EXPECT_GT(kink, 0.1);
}

TEST(Conversion, TagsSharpnessAndAngleFindTheSameCrease)
{
  MeshCase tagged = taggedRidge();
  MeshCase sharp = ridge();
  for (int b = 0; b < 2; ++b)
  {
    auto& block = sharp.blocks[b];
    block.creaseSharpness.assign(block.points.size(), 0.0);
    for (int i = 0; i <= 3; ++i)
    {
      block.creaseSharpness[block.index({ i, 2, 3 })] = SharpnessInfinite;
    }
  }
  MeshCase angled = ridge();
  BlockComplexOptions angle;
  angle.creaseAngle = 25.0;
  // The box's own edges are sharper than that, but a single block's edge is a crease anyway.
  const auto reference = conversioncases::canonicalNet(convert(tagged.mesh()));
  EXPECT_TRUE(conversioncases::canonicalNet(convert(sharp.mesh())) == reference);
  EXPECT_TRUE(conversioncases::canonicalNet(convert(angled.mesh(), {}, angle)) == reference);
  MeshCase smooth = ridge();
  EXPECT_EQ(convert(smooth.mesh()).volumes.size(), 2u);
}

// Given points and normals at the extraordinary vertices of the body are met exactly.
TEST(Conversion, ExtraordinaryBodyVerticesTakeTheGivenPointAndNormal)
{
  MeshCase mesh = meshcases::sphereBody(3, { 1.0, 1.2, 1.5 });
  mesh.boundaryNames = { "wall" };
  std::vector<std::vector<double>> points, normals;
  for (int b = 0; b < static_cast<int>(mesh.blocks.size()); ++b)
  {
    mesh.boundaries.push_back({ b, 4, { { 0, 0 }, { 3, 3 } }, 0 });
    points.emplace_back();
    normals.emplace_back();
    for (const Vec3& x : mesh.blocks[b].points)
    {
      const Vec3 normal = Vec3(x[0], x[1], 1.1 * x[2]).normalized(); // not the sphere's, so that it cannot be a chance
      const Vec3 projection = 0.97 * x;
      points.back().insert(points.back().end(), projection.data(), projection.data() + 3);
      normals.back().insert(normals.back().end(), normal.data(), normal.data() + 3);
    }
  }
  ConversionOptions options;
  options.roles = { BoundaryRole::Body };
  for (std::size_t b = 0; b < points.size(); ++b)
  {
    options.projectedPoints.push_back(points[b].data());
    options.surfaceNormals.push_back(normals[b].data());
  }
  const Converted converted = convert(mesh.mesh(), options);
  int corners = 0;
  for (int b = 0; b < 6; ++b)
  {
    for (int corner = 0; corner < 4; ++corner)
    {
      const int si = corner & 1, sj = corner >> 1;
      const int i = si ? 5 : 0, j = sj ? 5 : 0;
      const Vec3 x = mesh.blocks[b].at({ 3 * si, 3 * sj, 0 });
      EXPECT_EQ(converted.controlPoint(b, { i, j, 0 }), Vec3(0.97 * x));
      const Vec3 normal = Vec3(x[0], x[1], 1.1 * x[2]).normalized();
      for (const Ijk& next : { Ijk{ si ? 4 : 1, j, 0 }, Ijk{ i, sj ? 4 : 1, 0 } })
      {
        EXPECT_LE(std::abs(normal.dot(converted.controlPoint(b, next) - 0.97 * x)), 1e-15);
        EXPECT_EQ(converted.rule(b, next), ControlPointRule::BodyExtraordinaryVertex);
      }
      ++corners;
    }
  }
  EXPECT_EQ(corners, 24);
  EXPECT_EQ(conversioncases::interfaceJumps(converted).openControlPoints, 0);
}

TEST(Conversion, StopsWhenAsked)
{
  MeshCase mesh = meshcases::cutBox({ 4, 4, 4 });
  Execution run;
  run.progress = [](double fraction) { return fraction < 0.6; };
  EXPECT_THROW(convert(mesh.mesh(), {}, {}, run), Aborted);
}

TEST(Conversion, RefusesOptionsOutOfRange)
{
  MeshCase mesh = meshcases::cutBox({ 2, 2, 2 });
  for (const double c : { 0.0, 1.0, -1.0, std::nan("") })
  {
    ConversionOptions options;
    options.wallSpacing = c;
    EXPECT_THROW(convert(mesh.mesh(), options), Error);
  }
}
