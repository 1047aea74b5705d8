// SPDX-License-Identifier: BSD-3-Clause
/// Blocks that should meet and do not are found, whatever their numbering and ranks; valid meshes are left in peace.
#include "Complex/MeshDoctor.h"
#include "Support/MeshCases.h"
#include "Support/ThreadRanks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

using namespace bsv;
using namespace meshcases;

namespace
{

MeshDiagnosis diagnosed(MeshCase& mesh, const BlockComplexOptions& options = {})
{
  const BlockMesh view = mesh.mesh();
  return diagnose(buildBlockComplex(view, options));
}

Index count(const MeshDiagnosis& diagnosis, MeshFindingKind kind)
{
  return std::count_if(diagnosis.findings.begin(), diagnosis.findings.end(),
    [kind](const MeshFinding& finding) { return finding.kind == kind; });
}

std::string list(MeshCase& mesh, const MeshDiagnosis& diagnosis)
{
  std::string result;
  for (const MeshFinding& finding : diagnosis.findings)
  {
    result += meshFindingNames()[static_cast<int>(finding.kind)] + ": " + describe(mesh.mesh(), finding) + "\n";
  }
  return result;
}

/// Whether the mesh is suspicious, or refused by the gluing itself, which sees contacts that do not match.
bool isFound(MeshCase& mesh, const BlockComplexOptions& options = {})
{
  try
  {
    return diagnosed(mesh, options).suspicious();
  }
  catch (const Error&)
  {
    return true;
  }
}

/// Two boxes of 4^3 cells that meet in i = 4, the second one moved.
MeshCase twoBoxes(const Vec3& shift, const Map& map = {})
{
  MeshCase mesh = latticeBlocks({ { { 0, 0, 0 }, { 4, 4, 4 } }, { { 4, 0, 0 }, { 8, 4, 4 } } });
  for (Vec3& x : mesh.blocks[1].points)
  {
    x += shift;
  }
  return map ? mesh.apply(map) : mesh;
}

/// Kind, size and place of the findings, which must not depend on numbers.
struct Summary
{
  MeshFindingKind kind;
  Index quads;
  double distance, fraction, glueTolerance;
  Vec3 place;

  bool operator==(const Summary& o) const
  {
    return this->kind == o.kind && this->quads == o.quads && this->distance == o.distance &&
      this->fraction == o.fraction && this->glueTolerance == o.glueTolerance && this->place == o.place;
  }
};

std::vector<Summary> summary(const MeshDiagnosis& diagnosis)
{
  std::vector<Summary> result;
  for (const MeshFinding& f : diagnosis.findings)
  {
    const bool place = f.kind != MeshFindingKind::Component;
    result.push_back({ f.kind, f.quads, f.distance, f.fraction, f.glueTolerance, place ? f.place : Vec3::Zero() });
  }
  std::sort(result.begin(), result.end(), [](const Summary& a, const Summary& b) {
    return std::make_tuple(a.kind, a.quads, a.place[0], a.place[1], a.place[2]) <
      std::make_tuple(b.kind, b.quads, b.place[0], b.place[1], b.place[2]);
  });
  return result;
}

void expectSameEverywhere(const MeshCase& mesh, const std::string& what)
{
  SCOPED_TRACE(what);
  MeshCase original = mesh;
  const MeshDiagnosis alone = diagnosed(original);
  const std::vector<Summary> expected = summary(alone);
  for (unsigned seed = 1; seed < 5; ++seed)
  {
    MeshCase other = mesh;
    shuffle(other, seed, seed % 2 == 0);
    const MeshDiagnosis found = diagnosed(other);
    EXPECT_TRUE(summary(found) == expected) << list(original, alone) << "--- shuffled ---\n" << list(other, found);
    EXPECT_EQ(found.components, alone.components);
  }
  std::mt19937 random(7);
  const BlockMesh view = original.mesh();
  for (int size = 2; size < 5; ++size)
  {
    std::vector<int> rankOf(view.blocks.size());
    for (int& rank : rankOf)
    {
      rank = std::uniform_int_distribution<int>(0, size - 1)(random);
    }
    const std::vector<std::string> errors = bsvtest::onRanks(size, [&](const Execution& run) {
      const BlockMesh part = bsvtest::distributed(view, rankOf, run.ranks->rank());
      const MeshDiagnosis found = diagnose(buildBlockComplex(part, {}, run), run);
      EXPECT_TRUE(summary(found) == expected);
      EXPECT_EQ(found.findingOfQuad, alone.findingOfQuad);
      ASSERT_EQ(found.findings.size(), alone.findings.size());
      for (std::size_t n = 0; n < found.findings.size(); ++n)
      {
        EXPECT_EQ(found.findings[n].blocks, alone.findings[n].blocks);
        EXPECT_EQ(found.findings[n].faces, alone.findings[n].faces);
      }
    });
    EXPECT_EQ(errors, std::vector<std::string>(size));
  }
}

} // namespace

TEST(MeshDoctor, BlocksApart)
{
  for (const double gap : { 0.06, 0.1, 0.3, 0.5, -0.06, -0.3, -0.5 })
  {
    for (const Vec3& slide : { Vec3(0, 0, 0), Vec3(0, 0.2, 0), Vec3(0, 0.3, 0.4) })
    {
      SCOPED_TRACE(gap);
      MeshCase mesh = twoBoxes(Vec3(gap, 0, 0) + slide);
      const MeshDiagnosis found = diagnosed(mesh);
      ASSERT_EQ(count(found, MeshFindingKind::NearMiss), 1) << list(mesh, found);
      const MeshFinding& finding = found.findings.front();
      EXPECT_EQ(finding.blocks, (std::array<int, 2>{ 0, 1 }));
      EXPECT_EQ(finding.faces, (std::array<int, 2>{ 1, 0 }));
      EXPECT_EQ(finding.quads, 32);
      EXPECT_NEAR(finding.distance, (Vec3(gap, 0, 0) + slide).norm(), 1e-12);
      EXPECT_EQ(found.components, 2);
      EXPECT_THROW(refuseSuspicious(mesh.mesh(), found), Error);

      // The boxes become one at the tolerance told, and not before.
      ASSERT_NEAR(finding.glueTolerance, finding.distance, 1e-12);
      if (finding.glueTolerance < 0.49)
      {
        BlockComplexOptions options;
        options.matchTolerance = 1.001 * finding.glueTolerance;
        EXPECT_EQ(buildBlockComplex(mesh.mesh(), options).faces.size(), 11u);
        options.matchTolerance = 0.999 * finding.glueTolerance;
        EXPECT_TRUE(isFound(mesh, options));
      }
    }
  }
}

TEST(MeshDoctor, BlocksApartThatDoNotMatch)
{
  // Other cells on both sides, and only a part of the face.
  MeshCase mesh = latticeBlocks({ { { 0, 0, 0 }, { 8, 8, 8 } } });
  mesh.add({ 3, 4, 6 }, [](const Ijk& p) { return Vec3(8.3 + p[0], 2.1 + 0.8 * p[1], 1.2 + 0.77 * p[2]); });
  const MeshDiagnosis found = diagnosed(mesh);
  EXPECT_EQ(count(found, MeshFindingKind::NearMiss), 1) << list(mesh, found);
  EXPECT_EQ(found.findings.front().glueTolerance, 0.0);
}

TEST(MeshDoctor, NamedBoundariesAreMeant)
{
  MeshCase mesh = twoBoxes(Vec3(0.2, 0, 0));
  declareAll(mesh);
  EXPECT_FALSE(diagnosed(mesh).suspicious());
}

TEST(MeshDoctor, OneMovedPoint)
{
  // Every point of the shared face, inside, at its rim and its corners, in all directions.
  for (int k = 0; k <= 4; ++k)
  {
    for (int j = 0; j <= 4; ++j)
    {
      for (const Vec3& move : { Vec3(0.3, 0, 0), Vec3(-0.3, 0, 0), Vec3(0.3, 0.2, -0.2), Vec3(-0.5, 0, 0.1) })
      {
        MeshCase mesh = twoBoxes(Vec3::Zero(), wavy);
        mesh.blocks[1].at({ 0, j, k }) += move;
        MeshCase nearer = twoBoxes(Vec3::Zero(), wavy);
        nearer.blocks[1].at({ 0, j, k }) += 0.3 * move;
        EXPECT_TRUE(isFound(nearer)) << j << ' ' << k << ' ' << move.transpose();
        const MeshDiagnosis found = diagnosed(mesh);
        EXPECT_TRUE(found.suspicious()) << j << ' ' << k << ' ' << move.transpose();
        ASSERT_FALSE(found.findings.empty());
        EXPECT_EQ(found.findings.front().kind, MeshFindingKind::LoosePoint) << list(mesh, found);
        EXPECT_EQ(found.findings.front().quads, (j % 4 ? 4 : 2) * (k % 4 ? 2 : 1));
      }
    }
  }
}

TEST(MeshDoctor, MovedPointsOfOtherMeshes)
{
  const auto cases = [] {
    return std::vector<MeshCase>{ ring(5, 3, { { 0, 1, 2, 3 }, { 3, 4, 5 } }), ball(4, 4), torus(4, 3),
      sphereBody(4, { 1.0, 1.01, 1.03, 1.1, 1.5 }), cutBox({ 6, 6, 6 }, { { { 3 }, { 3 }, { 3 } } }, wavy) };
  };
  std::mt19937 random(3);
  int silent = 0, tried = 0;
  for (std::size_t n = 0; n < cases().size(); ++n)
  {
    for (int trial = 0; trial < 12; ++trial)
    {
      MeshCase mesh = cases()[n];
      const BlockComplex complex = buildBlockComplex(mesh.mesh());
      // A point of an inner face, of one of its two blocks.
      std::vector<int> inner;
      for (int f = 0; f < static_cast<int>(complex.faces.size()); ++f)
      {
        if (!complex.faces[f].boundary())
        {
          inner.push_back(f);
        }
      }
      const auto pick = [&](int last) { return std::uniform_int_distribution<int>(0, last)(random); };
      const ComplexFace& face = complex.faces[inner[pick(static_cast<int>(inner.size()) - 1)]];
      const FaceUse& use = face.uses[pick(1)];
      MeshCase::Block& block = mesh.blocks[use.block];
      const Ijk cells = block.cells();
      const Ijk p = facePoint(cells, use.face, pick(cells[faceAxis(use.face, 0)]), pick(cells[faceAxis(use.face, 1)]));
      Ijk q = p;
      q[faceDirection(use.face)] += faceSide(use.face) ? -1 : 1;
      block.at(p) += (pick(1) ? 0.3 : -0.3) * (block.at(q) - block.at(p));
      ++tried;
      silent += isFound(mesh) ? 0 : 1;
    }
  }
  EXPECT_EQ(silent, 0) << "of " << tried;
}

TEST(MeshDoctor, Overlaps)
{
  // Two boxes that share cells and no points; a box within another; a cross.
  std::vector<MeshCase> meshes(3);
  const auto box = [](const Vec3& from, const Ijk& cells, double h) {
    MeshCase result;
    result.add(cells, [=](const Ijk& p) { return Vec3(from + h * Vec3(p[0], p[1], p[2])); });
    return result.blocks.front();
  };
  meshes[0].blocks = { box({ 0, 0, 0 }, { 4, 4, 4 }, 1.0), box({ 2.3, 1.1, 0.7 }, { 4, 4, 4 }, 1.0) };
  meshes[1].blocks = { box({ 0, 0, 0 }, { 9, 9, 9 }, 1.0), box({ 3.3, 3.4, 3.45 }, { 3, 3, 3 }, 0.7) };
  meshes[2].blocks = { box({ 0, 0, 0 }, { 9, 3, 3 }, 1.0), box({ 3.2, -3.6, 0.3 }, { 3, 9, 2 }, 1.0) };
  for (MeshCase& mesh : meshes)
  {
    const MeshDiagnosis found = diagnosed(mesh);
    EXPECT_GE(count(found, MeshFindingKind::Overlap), 1) << list(mesh, found);
    EXPECT_EQ(count(found, MeshFindingKind::Component), 2);
  }
}

TEST(MeshDoctor, ValidMeshes)
{
  std::vector<std::pair<std::string, MeshCase>> cases{ { "box", cutBox({ 6, 5, 4 }, { { { 2, 3 }, { 2 }, {} } }) },
    { "wavy box", cutBox({ 20, 17, 9 }, { { { 2, 3 }, { 2 }, {} } }, wavy) }, { "L", lShape(3) },
    { "ring 3", ring(3, 3, { { 0, 1, 2 } }) }, { "ring 6", ring(6, 4, { { 0, 1, 2 }, { 2, 2.001, 2.01 } }) },
    { "sphere body", sphereBody(6, { 1.0, 1.001, 1.01, 1.1, 2.0 }) },
    { "polycube body", polycubeBody({ { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, 4, { 1.0, 1.1, 1.3 }) },
    { "ball", ball(4, 3) }, { "torus", torus(5, 3) }, { "O-grid", oGrid({ 24, 5, 3 }) },
    { "narrow O-grid", oGrid({ 24, 5, 3 }, 0.02) }, { "shell", closedShell({ 12, 10, 2 }) },
    { "C-grid", cGrid(8, 24, 40, 3) }, { "extended cuboid", extendedCuboid(3, 3, 1.0) } };
  for (unsigned seed = 0; seed < 20; ++seed)
  {
    cases.emplace_back("boxes " + std::to_string(seed), randomBoxes(seed));
  }
  for (auto& [name, mesh] : cases)
  {
    const MeshDiagnosis found = diagnosed(mesh);
    EXPECT_FALSE(found.suspicious()) << name << '\n' << list(mesh, found);
  }
}

TEST(MeshDoctor, ThinWallsAreNoNearMisses)
{
  // A fluid gap of one cell, and a sector around an axis, whose sides face away from each other.
  MeshCase slot = latticeBlocks({ { { 0, 0, 0 }, { 6, 4, 4 } } });
  slot.apply([](const Vec3& x) { return Vec3(x[0], x[1], x[2] < 2.0 ? x[2] : 2.0 + 0.01 * (x[2] - 2.0)); });
  EXPECT_TRUE(diagnosed(slot).findings.empty());
  MeshCase sector;
  sector.add({ 6, 1, 4 }, [](const Ijk& p) {
    const double radius = 0.1 + p[0], angle = 0.05 * p[1];
    return Vec3(radius * std::cos(angle), radius * std::sin(angle), p[2]);
  });
  EXPECT_TRUE(diagnosed(sector).findings.empty());
  // A plate thinner than half a cell, with cells at its edge: walls, as the edge shows.
  std::vector<std::pair<Ijk, Ijk>> boxes;
  for (int k = 0; k < 3; ++k)
  {
    for (int i = 0; i < 3; ++i)
    {
      if (i != 1 || k != 1)
      {
        boxes.push_back({ { 3 * i, 0, 3 * k }, { 3 * i + 3, 3, 3 * k + 3 } });
      }
    }
  }
  MeshCase plate = latticeBlocks(boxes);
  plate.apply([](const Vec3& x) {
    const double z = x[2] < 3.0 ? x[2] - 3.0 : x[2] > 6.0 ? x[2] - 6.0 + 0.3 : 0.1 * (x[2] - 3.0);
    return Vec3(x[0], x[1], z);
  });
  const MeshDiagnosis found = diagnosed(plate);
  EXPECT_FALSE(found.suspicious()) << list(plate, found);
  EXPECT_EQ(count(found, MeshFindingKind::NarrowGap), 1) << list(plate, found);
}

// Outer faces that meet at an edge at any angle through the mesh, and at angles across which nobody would glue.
TEST(MeshDoctor, TapersAndNotchesAreMeant)
{
  // One block, two that share the taper, and stairs, whose notches are as wide as the shear leaves them.
  const std::vector<std::vector<std::pair<Ijk, Ijk>>> shapes{ { { { 0, 0, 0 }, { 4, 4, 4 } } },
    { { { 0, 0, 0 }, { 4, 4, 4 } }, { { 4, 0, 0 }, { 8, 4, 4 } } },
    { { { 0, 0, 0 }, { 2, 2, 2 } }, { { 2, 0, 0 }, { 4, 2, 2 } }, { { 0, 2, 0 }, { 2, 4, 2 } } },
    { { { 0, 0, 0 }, { 1, 1, 2 } }, { { 1, 0, 0 }, { 2, 1, 2 } }, { { 0, 1, 0 }, { 1, 2, 2 } },
      { { 2, 0, 0 }, { 3, 1, 2 } }, { { 1, 1, 0 }, { 2, 2, 2 } }, { { 0, 2, 0 }, { 1, 3, 2 } } } };
  for (const auto& boxes : shapes)
  {
    for (const double degrees : { 75.0, 60.0, 55.0, 45.0, 36.0 })
    {
      SCOPED_TRACE(std::to_string(boxes.size()) + " blocks, " + std::to_string(degrees));
      const double angle = degrees / DegreesPerRadian;
      MeshCase mesh = latticeBlocks(boxes);
      mesh.apply([=](const Vec3& x) { return Vec3(x[0] + std::cos(angle) * x[1], std::sin(angle) * x[1], x[2]); });
      const MeshDiagnosis found = diagnosed(mesh);
      EXPECT_FALSE(found.suspicious()) << list(mesh, found);
      EXPECT_TRUE(boxes.size() > 2 || found.findings.empty()) << list(mesh, found);
    }
  }
  // Two blocks taper to one edge.
  const double c = std::cos(25.0 / DegreesPerRadian), d = std::sin(25.0 / DegreesPerRadian);
  MeshCase tip;
  tip.add({ 3, 3, 2 }, [=](const Ijk& p) { return Vec3(p[0] + c * p[1], d * p[1], p[2]); });
  tip.add({ 3, 3, 2 }, [=](const Ijk& p) { return Vec3(p[1] + c * p[0], -d * p[0], p[2]); });
  const MeshDiagnosis found = diagnosed(tip);
  EXPECT_TRUE(found.findings.empty()) << list(tip, found);
}

// Blocks that meet at an edge and turn away from, or into, each other from there; wide slits are those of sharp bodies.
TEST(MeshDoctor, SlitsThatBeginAtACommonEdge)
{
  for (const double angle : { 0.06, 0.12, -0.06, -0.12, -0.2, -0.5 })
  {
    MeshCase mesh = twoBoxes(Vec3::Zero());
    for (Vec3& x : mesh.blocks[1].points)
    {
      const Vec3 r = x - Vec3(4, 0, 0);
      x = Vec3(
        4 + std::cos(angle) * r[0] + std::sin(angle) * r[1], std::cos(angle) * r[1] - std::sin(angle) * r[0], r[2]);
    }
    EXPECT_TRUE(isFound(mesh)) << angle;
  }
}

TEST(MeshDoctor, HolesAndComponents)
{
  MeshCase body = sphereBody(4, { 1.0, 1.2, 1.5 });
  MeshDiagnosis found = diagnosed(body);
  ASSERT_EQ(found.findings.size(), 1u);
  EXPECT_EQ(found.findings.front().kind, MeshFindingKind::InnerBoundary);
  EXPECT_EQ(found.findings.front().quads, 6 * 16);
  EXPECT_NEAR(found.findings.front().place.norm(), 1.0, 0.1);
  EXPECT_EQ(found.components, 1);
  declareAll(body);
  EXPECT_TRUE(diagnosed(body).findings.empty());

  MeshCase apart = twoBoxes(Vec3(5, 0, 0));
  found = diagnosed(apart);
  EXPECT_EQ(found.components, 2);
  EXPECT_EQ(count(found, MeshFindingKind::Component), 2);
  EXPECT_FALSE(found.suspicious());
}

TEST(MeshDoctor, NumberingAndRanks)
{
  expectSameEverywhere(twoBoxes(Vec3(0.2, 0.1, 0), wavy), "apart");
  MeshCase moved = cutBox({ 6, 6, 6 }, { { { 3 }, { 3 }, { 3 } } }, wavy);
  moved.blocks[1].at({ 0, 2, 1 }) += Vec3(0.3, 0.1, 0.05);
  expectSameEverywhere(moved, "moved");
  moved.blocks[6].at({ 3, 0, 3 }) += Vec3(0.2, 0.3, -0.3);
  expectSameEverywhere(moved, "moved at a corner");
  expectSameEverywhere(sphereBody(3, { 1.0, 1.2, 1.5 }), "body");
  MeshCase overlap = twoBoxes(Vec3(-1.7, 0.3, 0.2));
  expectSameEverywhere(overlap, "overlap");
}
