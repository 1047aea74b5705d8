// SPDX-License-Identifier: BSD-3-Clause
// The far-field extension: which blocks are found, where the first inserted layer lies, and what it does to the cells.
#include "Conversion/FarField.h"
#include "Support/ConversionCases.h"
#include "Support/MeshCases.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace
{

using namespace conversioncases;
using namespace meshcases;
using bsv::BoundaryRole;
using bsv::ControlPointRule;
using bsv::ConversionOptions;
using bsv::FarFieldSide;
using bsv::FarFieldSpacing;

constexpr int Cells = 4;
constexpr int Layers = 4;
/// Block numbers of extendedCuboid().
constexpr int FirstExtension = 19, FirstTouching = 38, Blocks = 58;
const Vec3 Size(3.0, 1.0, 2.0);

ConversionOptions roles()
{
  ConversionOptions options;
  options.roles = { BoundaryRole::Body, BoundaryRole::Symmetry };
  return options;
}

ConversionOptions with(FarFieldSpacing spacing)
{
  ConversionOptions options = roles();
  options.farFieldSpacing = spacing;
  return options;
}

/// What was found, free of any numbering but that of the mesh's blocks.
struct Found
{
  std::set<int> attached;
  std::set<int> beyond;
  std::size_t sides = 0;
};

Found find(const bsv::BlockComplex& complex, const ConversionOptions& options)
{
  Found found;
  const std::vector<FarFieldSide> sides = bsv::farFieldSides(complex, options);
  found.sides = sides.size();
  for (const FarFieldSide& side : sides)
  {
    for (std::size_t i = 0; i < side.faces.size(); ++i)
    {
      const int parent = complex.blocks[side.outer[i].block].parent;
      found.beyond.insert(parent);
      if (side.onCuboid[i])
      {
        found.attached.insert(parent);
      }
    }
  }
  return found;
}

/// Heights of a column of samples off one side of the cuboid at the connection layer: the last cell before it and the
/// first behind it.
struct Ratio
{
  double largest = 0.0;
  double mean = 0.0;
  /// Largest away from the cuboid's edges where the first cell of the extension's mesh and the cells before it have at
  /// most a given ratio.
  double allowed = 0.0;
  int allowedColumns = 0;
  int columns = 0;
};

double ratioOf(double a, double b)
{
  return std::max(a / b, b / a);
}

/// Over all sides and the mesh lines through their faces at `level`.
Ratio cellRatio(const Converted& converted, int level, double most)
{
  Ratio ratio;
  const double step = std::ldexp(1.0, -level);
  for (const FarFieldSide& side : bsv::farFieldSides(converted.complex, roles()))
  {
    for (std::size_t i = 0; i < side.faces.size(); ++i)
    {
      if (!side.onCuboid[i])
      {
        continue;
      }
      const auto height = [&](const bsv::FaceUse& use, double s, double t) {
        const bsv::BSplineVolume& volume = converted.volumes[use.block];
        const int normal = bsv::faceDirection(use.face);
        const double end = volume.count(normal) - 3;
        Vec3 at;
        at[bsv::faceAxis(use.face, 0)] = s;
        at[bsv::faceAxis(use.face, 1)] = t;
        at[normal] = bsv::faceSide(use.face) ? end : 0.0;
        const Vec3 foot = bsv::evaluate(volume, at);
        at[normal] = bsv::faceSide(use.face) ? end - step : step;
        return std::abs(side.normal.dot(bsv::evaluate(volume, at) - foot));
      };
      const auto cell = [&](const bsv::FaceUse& use, int s, int t) {
        const bsv::ComplexBlock& owner = converted.complex.blocks[use.block];
        const Ijk cells{ owner.cells(0), owner.cells(1), owner.cells(2) };
        Ijk ijk = bsv::facePoint(cells, use.face, s, t);
        const Vec3 foot = owner.points(ijk);
        ijk[bsv::faceDirection(use.face)] += bsv::faceSide(use.face) ? -1 : 1;
        return std::abs(side.normal.dot(owner.points(ijk) - foot));
      };
      const bsv::ComplexFace& face = converted.complex.faces[side.faces[i]];
      const bool innerFirst = face.uses[0].block == side.inner[i].block && face.uses[0].face == side.inner[i].face;
      for (int t = 0; t <= Cells; ++t)
      {
        for (int s = 0; s <= Cells; ++s)
        {
          const auto st = bsv::mapFacePoint(face.orientation, s, t, Cells, Cells);
          const bsv::FaceUse& a = face.uses[0];
          const bsv::FaceUse& b = face.uses[1];
          const double r = ratioOf(height(a, s, t), height(b, st[0], st[1]));
          ratio.largest = std::max(ratio.largest, r);
          ratio.mean += r;
          ++ratio.columns;
          // The extension's own first cell against what the cells before it grow by.
          const double inner = (innerFirst ? height(a, s, t) : height(b, st[0], st[1])) / step;
          const double outer = innerFirst ? cell(b, st[0], st[1]) : cell(a, s, t);
          // At the edges of the cuboid, and next to them, its layers follow the rules of its extraordinary edges.
          const bsv::ComplexBlock& block = converted.complex.blocks[a.block];
          const Vec3 x = block.points(bsv::facePoint({ block.cells(0), block.cells(1), block.cells(2) }, a.face, s, t));
          int near = 0;
          for (int d = 0; d < 3; ++d)
          {
            near += Size[d] - std::abs(x[d]) < 1.01 * (d == 2 ? 1.0 : 2.0) / Cells ? 1 : 0;
          }
          if (near == 1 && ratioOf(inner, outer) <= most)
          {
            ratio.allowed = std::max(ratio.allowed, r);
            ++ratio.allowedColumns;
          }
        }
      }
    }
  }
  ratio.mean /= ratio.columns;
  return ratio;
}

TEST(FarField, FindsBlocksAtFacesEdgesAndCorners)
{
  MeshCase mesh = extendedCuboid(Cells, Layers, 1.3);
  const bsv::BlockComplex complex = bsv::buildBlockComplex(mesh.mesh());
  ASSERT_EQ(complex.blocks.size(), std::size_t(Blocks));
  EXPECT_TRUE(complex.warnings.empty()) << complex.warnings.front();
  std::set<int> attached, beyond;
  for (int b = FirstExtension; b < Blocks; ++b)
  {
    beyond.insert(b);
    if (b < FirstTouching)
    {
      attached.insert(b);
    }
  }
  EXPECT_EQ(attached.size(), 19u);

  const Found automatic = find(complex, roles());
  EXPECT_EQ(automatic.sides, 5u);
  EXPECT_EQ(automatic.attached, attached);
  EXPECT_EQ(automatic.beyond, beyond);

  // Named: those attached face to face, or all; with and without a body to tell the inside from the outside.
  for (const int last : { FirstTouching, Blocks })
  {
    ConversionOptions options = roles();
    options.extensionBlocks.assign(Blocks, false);
    std::fill(options.extensionBlocks.begin() + FirstExtension, options.extensionBlocks.begin() + last, true);
    for (const bool body : { true, false })
    {
      if (!body && last == FirstTouching)
      {
        continue;
      }
      options.roles[0] = body ? BoundaryRole::Body : BoundaryRole::Other;
      const Found named = find(complex, options);
      EXPECT_EQ(named.sides, 5u) << last << body;
      EXPECT_EQ(named.attached, attached) << last << body;
      EXPECT_EQ(named.beyond, beyond) << last << body;
    }
  }
}

TEST(FarField, OneSideAlone)
{
  // Blocks beyond x = 3 only: the others are left away.
  MeshCase mesh = extendedCuboid(Cells, Layers, 1.3);
  MeshCase wake;
  wake.boundaryNames = mesh.boundaryNames;
  std::vector<int> kept;
  for (int b = 0; b < Blocks; ++b)
  {
    double low = 1e9, across = 0.0;
    for (const Vec3& x : mesh.blocks[b].points)
    {
      low = std::min(low, x[0]);
      across = std::max({ across, std::abs(x[1]) - 1.0, x[2] - 2.0 });
    }
    if (b < FirstExtension || (low >= 3.0 && across < 1e-12))
    {
      wake.blocks.push_back(mesh.blocks[b]);
      kept.push_back(b);
    }
  }
  ASSERT_EQ(kept.size(), 21u);
  for (const bsv::BoundaryPatch& patch : mesh.boundaries)
  {
    const auto at = std::find(kept.begin(), kept.end(), patch.block);
    if (at != kept.end())
    {
      wake.boundaries.push_back({ int(at - kept.begin()), patch.face, patch.range, patch.tag });
    }
  }
  const bsv::BlockComplex complex = bsv::buildBlockComplex(wake.mesh());
  const Found found = find(complex, roles());
  EXPECT_EQ(found.sides, 1u);
  EXPECT_EQ(found.beyond, (std::set<int>{ 19, 20 }));
}

TEST(FarField, OrdinaryMeshesHaveNoExtension)
{
  // No body; a body with a curved far field; a grid around a box, whose inner planes touch the body; a grid over a
  // plate.
  MeshCase grid = cutBox({ 6, 6, 6 }, { { { 2, 4 }, { 2, 4 }, { 2, 4 } } });
  EXPECT_EQ(find(bsv::buildBlockComplex(grid.mesh()), roles()).sides, 0u);

  MeshCase sphere = sphereBody(3, { 1.0, 1.2, 1.5, 2.0 });
  declareAll(sphere);
  ConversionOptions body;
  body.roles.assign(sphere.boundaryNames.size(), BoundaryRole::Body);
  EXPECT_EQ(find(bsv::buildBlockComplex(sphere.mesh()), body).sides, 0u);

  MeshCase box = cutBox({ 6, 6, 6 }, { { { 2, 4 }, { 2, 4 }, { 2, 4 } } });
  box.blocks.erase(box.blocks.begin() + 13); // the middle one is the body
  box.boundaryNames = { "wall" };
  for (int face = 0; face < 6; ++face)
  {
    const int neighbour[6] = { 12, 13, 10, 15, 4, 21 };
    box.boundaries.push_back({ neighbour[face], face ^ 1, { { 0, 0 }, { 2, 2 } }, 0 });
  }
  EXPECT_EQ(find(bsv::buildBlockComplex(box.mesh()), roles()).sides, 0u);

  MeshCase plate = cutBox({ 6, 6, 4 }, { { { 2, 4 }, { 2, 4 }, { 2 } } });
  plate.boundaryNames = { "wall" };
  plate.boundaries.push_back({ 4, 4, { { 0, 0 }, { 2, 2 } }, 0 });
  plate.apply([](const Vec3& x) { return Vec3(x[0] * x[0], x[1], x[2] * x[2]); });
  EXPECT_EQ(find(bsv::buildBlockComplex(plate.mesh()), roles()).sides, 0u);

  MeshCase curved = cutBox({ 4, 2, 2 }, { { { 2 }, {}, {} } }, [](const Vec3& x) { return wavy(0.5 * x); });
  ConversionOptions named;
  named.extensionBlocks = { true, false };
  EXPECT_THROW(find(bsv::buildBlockComplex(curved.mesh()), named), bsv::Error);
}

TEST(FarField, FirstLayerLiesAtTheAverageDistancePerDirection)
{
  MeshCase mesh = extendedCuboid(Cells, Layers, 1.5, 1.1);
  const Converted converted = convert(mesh.mesh(), with(FarFieldSpacing::SideAverage));
  ASSERT_EQ(converted.report.extensionDistances.size(), 5u);
  EXPECT_EQ(converted.report.limitedDistances, 0);
  const std::vector<FarFieldSide> sides = bsv::farFieldSides(converted.complex, roles());
  for (std::size_t n = 0; n < sides.size(); ++n)
  {
    const FarFieldSide& side = sides[n];
    // The average over the side's control points, by trapezoids over the side's area.
    double sum = 0.0, area = 0.0;
    const double d = converted.report.extensionDistances[n];
    bsv::Index layer = 0;
    const auto positions = [&](const bsv::FaceUse& use, int a, int b, int depth) {
      const bsv::BSplineVolume& volume = converted.volumes[use.block];
      Ijk p;
      p[bsv::faceAxis(use.face, 0)] = a;
      p[bsv::faceAxis(use.face, 1)] = b;
      const int normal = bsv::faceDirection(use.face);
      p[normal] = bsv::faceSide(use.face) ? volume.count(normal) - 1 - depth : depth;
      return p;
    };
    for (std::size_t i = 0; i < side.faces.size(); ++i)
    {
      const bsv::FaceUse& outer = side.outer[i];
      const bsv::BSplineVolume& volume = converted.volumes[outer.block];
      for (int b = 0; b < volume.count(bsv::faceAxis(outer.face, 1)); ++b)
      {
        for (int a = 0; a < volume.count(bsv::faceAxis(outer.face, 0)); ++a)
        {
          const Vec3 on = converted.controlPoint(outer.block, positions(outer, a, b, 0));
          const Vec3 first = converted.controlPoint(outer.block, positions(outer, a, b, 1));
          EXPECT_NEAR(side.normal.dot(first - on), d, 1e-14);
          EXPECT_NEAR(on.cwiseAbs().dot(side.normal.cwiseAbs()), Size.dot(side.normal.cwiseAbs()), 1e-14);
          layer += converted.rule(outer.block, positions(outer, a, b, 1)) == ControlPointRule::FarFieldLayer ? 1 : 0;
        }
      }
      if (side.onCuboid[i])
      {
        const bsv::FaceUse& inner = side.inner[i];
        for (int b = 0; b <= Cells; ++b)
        {
          for (int a = 0; a <= Cells; ++a)
          {
            const double weight = (a % Cells == 0 ? 0.5 : 1.0) * (b % Cells == 0 ? 0.5 : 1.0);
            const auto net = [](int mesh) { return mesh == 0 ? 0 : mesh == Cells ? Cells + 2 : mesh + 1; };
            const Vec3 on = converted.controlPoint(inner.block, positions(inner, net(a), net(b), 0));
            const Vec3 last = converted.controlPoint(inner.block, positions(inner, net(a), net(b), 1));
            sum += weight * side.normal.dot(on - last);
            area += weight;
          }
        }
      }
    }
    EXPECT_GT(layer, 0);
    // The mean over vertices weighs the rim more, and block borders follow the rule of their layer: some percent.
    EXPECT_NEAR(sum / area, d, 0.05 * d);
  }
}

TEST(FarField, PerVertexMakesTheNormalDerivativeContinuous)
{
  MeshCase mesh = extendedCuboid(Cells, Layers, 1.5, 1.1);
  const Converted converted = convert(mesh.mesh(), with(FarFieldSpacing::PerVertex));
  double worst = 0.0;
  bsv::Index count = 0;
  for (const FarFieldSide& side : bsv::farFieldSides(converted.complex, roles()))
  {
    for (std::size_t i = 0; i < side.faces.size(); ++i)
    {
      if (!side.onCuboid[i])
      {
        continue;
      }
      const bsv::ComplexFace& face = converted.complex.faces[side.faces[i]];
      const auto slope = [&](const bsv::FaceUse& use, double s, double t) {
        const int normal = bsv::faceDirection(use.face);
        Vec3 at;
        at[bsv::faceAxis(use.face, 0)] = s;
        at[bsv::faceAxis(use.face, 1)] = t;
        at[normal] = bsv::faceSide(use.face) ? converted.volumes[use.block].count(normal) - 3 : 0.0;
        std::array<int, 3> order{ 0, 0, 0 };
        order[normal] = 1;
        return std::abs(side.normal.dot(bsv::evaluate(converted.volumes[use.block], at, order)));
      };
      // Away from block borders, where every layer follows a rule of its own.
      for (double t = 2.0; t <= Cells - 2.0; t += 0.25)
      {
        for (double s = 2.0; s <= Cells - 2.0; s += 0.25)
        {
          const auto st = bsv::mapFacePoint(face.orientation, int(4 * s), int(4 * t), 4 * Cells, 4 * Cells);
          const double a = slope(face.uses[0], s, t);
          worst = std::max(worst, std::abs(a - slope(face.uses[1], 0.25 * st[0], 0.25 * st[1])) / a);
          ++count;
        }
      }
    }
  }
  EXPECT_GT(count, 0);
  EXPECT_LT(worst, 0.02);
}

TEST(FarField, CellsGrowSmoothlyAcrossTheConnectionLayer)
{
  // With the cell sizes h before and R h behind the layer the sampled cells start with the slope h and the second
  // derivative 3 (R - 1) h per span: their ratio is about 1 + 3/2 (R - 1) / 2^L, without the rule R.
  for (const double step : { 1.0, 1.25, 1.5, 2.0 })
  {
    MeshCase mesh = extendedCuboid(Cells, Layers, step);
    const Converted off = convert(mesh.mesh(), with(FarFieldSpacing::Off));
    const Converted average = convert(mesh.mesh(), with(FarFieldSpacing::SideAverage));
    const Converted vertex = convert(mesh.mesh(), with(FarFieldSpacing::PerVertex));
    EXPECT_EQ(interfaceJumps(average).openControlPoints, 0);
    EXPECT_EQ(interfaceJumps(vertex).openControlPoints, 0);
    for (int level = 1; level <= 3; ++level)
    {
      // A tenth less for what is of higher order.
      const double most = 1.0 + 0.9 * 0.2 / 1.5 * std::ldexp(1.0, level);
      const Ratio without = cellRatio(off, level, most);
      const Ratio with = cellRatio(average, level, most);
      const Ratio each = cellRatio(vertex, level, most);
      std::printf("extension's first cell %.2f times the last, level %d: mean (largest) ratio Off %.3f (%.3f), "
                  "SideAverage %.3f (%.3f), PerVertex %.3f (%.3f); where R <= %.2f, %d of %d columns: Off %.3f, "
                  "SideAverage %.3f, PerVertex %.3f\n",
        step, level, without.mean, without.largest, with.mean, with.largest, each.mean, each.largest, most,
        each.allowedColumns, each.columns, without.allowed, with.allowed, each.allowed);
      EXPECT_LE(each.allowed, 1.2);
      EXPECT_LT(each.mean, without.mean);
      // One distance for a whole side helps where the jump is larger than what the side's own cells differ by.
      if (step >= 1.5)
      {
        EXPECT_LT(with.mean, without.mean);
        EXPECT_LT(with.largest, without.largest);
      }
    }
  }
}

TEST(FarField, NothingFoldsAtTheConnectionLayer)
{
  MeshCase mesh = extendedCuboid(Cells, Layers, 2.0);
  const Converted converted = convert(mesh.mesh(), with(FarFieldSpacing::SideAverage));
  EXPECT_EQ(provenValid(converted, [](int, const Ijk&) { return true; }).others, 0);
}

TEST(FarField, SameBitsForAnyNumberingOrientationAndThreads)
{
  for (const FarFieldSpacing spacing : { FarFieldSpacing::SideAverage, FarFieldSpacing::PerVertex })
  {
    // Lines that are not straight, in planes that stay as they are.
    const auto bend = [](const Vec3& x) {
      return Vec3(x + Vec3(0.02 * (x[0] * x[0] - 9.0) * x[1], 0.03 * (x[1] * x[1] - 1.0) * x[0], 0.0));
    };
    MeshCase mesh = extendedCuboid(3, 3, 1.5, 1.1);
    mesh.apply(bend);
    const Converted converted = convert(mesh.mesh(), with(spacing));
    EXPECT_EQ(converted.report.extensionDistances.size(), 5u);
    const auto expected = canonicalNet(converted);
    for (unsigned seed = 1; seed <= 6; ++seed)
    {
      MeshCase other = mesh;
      shuffle(other, seed, seed % 2 == 0);
      EXPECT_TRUE(canonicalNet(convert(other.mesh(), with(spacing), {}, twoThreads())) == expected) << seed;
    }
  }
}

} // namespace
