// SPDX-License-Identifier: BSD-3-Clause
/// The block complex: topology known from the geometry, independence of numbering, orientation and distribution over
/// ranks, cuts, welding and refusals.
#include "Base/Numbers.h"
#include "Complex/BlockComplex.h"
#include "Complex/CreaseEdges.h"
#include "Complex/EntityClass.h"
#include "Complex/Limits.h"
#include "Support/DistributedComplex.h"
#include "Support/MeshCases.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

using namespace bsv;
using namespace meshcases;

namespace
{

int eulerCharacteristic(const BlockComplex& c)
{
  return static_cast<int>(c.vertices.size()) - static_cast<int>(c.edges.size()) + static_cast<int>(c.faces.size()) -
    static_cast<int>(c.blocks.size());
}

Ijk cellsOf(const ComplexBlock& block)
{
  return { block.cells(0), block.cells(1), block.cells(2) };
}

/// Point n along an edge of a block.
Vec3 edgePoint(const ComplexBlock& block, int edge, int n)
{
  Ijk p{};
  for (int d = 0; d < 3; ++d)
  {
    p[d] = cornerSide(edgeCorner(edge, 0), d) * block.cells(d);
  }
  p[edgeDirection(edge)] = n;
  return block.points(p);
}

Vec3 cornerPoint(const ComplexBlock& block, int corner)
{
  return block.points(cornerSide(corner, 0) * block.cells(0), cornerSide(corner, 1) * block.cells(1),
    cornerSide(corner, 2) * block.cells(2));
}

bool sameBits(const Vec3& a, const Vec3& b)
{
  return std::memcmp(a.data(), b.data(), sizeof(double) * 3) == 0;
}

/// Everything that must hold in any complex: uses and ids refer to each other, and all copies of a shared point are
/// equal bit for bit.
void expectConsistent(const BlockComplex& c)
{
  std::size_t corners = 0, edgeUses = 0, faceUses = 0;
  for (std::size_t v = 0; v < c.vertices.size(); ++v)
  {
    const ComplexVertex& vertex = c.vertices[v];
    corners += vertex.corners.size();
    for (const CornerUse& use : vertex.corners)
    {
      ASSERT_EQ(c.blocks[use.block].vertices[use.corner], int(v));
      ASSERT_TRUE(sameBits(cornerPoint(c.blocks[use.block], use.corner),
        cornerPoint(c.blocks[vertex.corners[0].block], vertex.corners[0].corner)));
    }
  }
  std::vector<bool> boundaryVertex(c.vertices.size()), boundaryEdge(c.edges.size());
  for (std::size_t f = 0; f < c.faces.size(); ++f)
  {
    const ComplexFace& face = c.faces[f];
    faceUses += face.uses.size();
    ASSERT_TRUE(face.uses.size() == 1 || face.uses.size() == 2);
    for (const FaceUse& use : face.uses)
    {
      ASSERT_EQ(c.blocks[use.block].faces[use.face], int(f));
    }
    const FaceUse a = face.uses[0];
    const ComplexBlock& blockA = c.blocks[a.block];
    if (face.boundary())
    {
      for (int n = 0; n < 4; ++n)
      {
        boundaryVertex[blockA.vertices[faceCorner(a.face, n & 1, n >> 1)]] = true;
        boundaryEdge[blockA.edges[faceEdge(a.face, n & 1, n >> 1)]] = true;
      }
      continue;
    }
    const FaceUse b = face.uses[1];
    const ComplexBlock& blockB = c.blocks[b.block];
    const int ns = blockA.cells(faceAxis(a.face, 0)), nt = blockA.cells(faceAxis(a.face, 1));
    for (int t = 0; t <= nt; ++t)
    {
      for (int s = 0; s <= ns; ++s)
      {
        const auto onB = mapFacePoint(face.orientation, s, t, ns, nt);
        ASSERT_TRUE(sameBits(blockA.points(facePoint(cellsOf(blockA), a.face, s, t)),
          blockB.points(facePoint(cellsOf(blockB), b.face, onB[0], onB[1]))));
      }
    }
    for (int n = 0; n < 4; ++n)
    {
      const auto onB = mapFacePoint(face.orientation, n & 1, n >> 1, 1, 1);
      ASSERT_EQ(
        blockA.vertices[faceCorner(a.face, n & 1, n >> 1)], blockB.vertices[faceCorner(b.face, onB[0], onB[1])]);
    }
  }
  for (std::size_t e = 0; e < c.edges.size(); ++e)
  {
    const ComplexEdge& edge = c.edges[e];
    edgeUses += edge.uses.size();
    for (const EdgeUse& use : edge.uses)
    {
      const ComplexBlock& block = c.blocks[use.block];
      ASSERT_EQ(block.edges[use.edge], int(e));
      ASSERT_EQ(block.edgeReversed[use.edge], use.reversed);
      ASSERT_EQ(block.cells(edgeDirection(use.edge)), edge.cells);
      for (int end = 0; end < 2; ++end)
      {
        ASSERT_EQ(block.vertices[edgeCorner(use.edge, use.reversed ? 1 - end : end)], edge.vertices[end]);
      }
      const EdgeUse& first = edge.uses[0];
      for (int n = 0; n <= edge.cells; ++n)
      {
        ASSERT_TRUE(sameBits(edgePoint(block, use.edge, use.reversed ? edge.cells - n : n),
          edgePoint(c.blocks[first.block], first.edge, first.reversed ? edge.cells - n : n)));
      }
    }
    EXPECT_EQ(edge.boundary, boundaryEdge[e]);
    EXPECT_TRUE(edge.boundary || !edge.crease);
  }
  for (std::size_t v = 0; v < c.vertices.size(); ++v)
  {
    EXPECT_EQ(c.vertices[v].boundary, boundaryVertex[v]);
  }
  EXPECT_EQ(corners, 8 * c.blocks.size());
  EXPECT_EQ(edgeUses, 12 * c.blocks.size());
  EXPECT_EQ(faceUses, 6 * c.blocks.size());
}

using Bits = std::array<std::uint64_t, 3>;

Bits bits(const Vec3& x)
{
  Bits result;
  std::memcpy(result.data(), x.data(), sizeof result);
  return result;
}

/// A complex without numbers and orientations: every entity by its points and properties, sorted.
std::vector<std::vector<std::uint64_t>> signature(const BlockComplex& c)
{
  std::vector<std::vector<std::uint64_t>> result;
  const auto entity = [&](std::vector<std::uint64_t> properties, std::vector<Bits> points) {
    std::sort(points.begin(), points.end());
    for (const Bits& x : points)
    {
      properties.insert(properties.end(), x.begin(), x.end());
    }
    result.push_back(std::move(properties));
  };
  for (const ComplexBlock& block : c.blocks)
  {
    std::vector<Bits> points;
    for (int k = 0; k <= block.cells(2); ++k)
    {
      for (int j = 0; j <= block.cells(1); ++j)
      {
        for (int i = 0; i <= block.cells(0); ++i)
        {
          points.push_back(bits(block.points(i, j, k)));
        }
      }
    }
    entity({ 3 }, points);
  }
  for (const ComplexFace& face : c.faces)
  {
    const ComplexBlock& block = c.blocks[face.uses[0].block];
    const int f = face.uses[0].face;
    std::vector<Bits> points;
    for (int t = 0; t <= block.cells(faceAxis(f, 1)); ++t)
    {
      for (int s = 0; s <= block.cells(faceAxis(f, 0)); ++s)
      {
        points.push_back(bits(block.points(facePoint(cellsOf(block), f, s, t))));
      }
    }
    const std::string name = face.tag < 0 ? "" : c.boundaryNames[face.tag];
    entity({ 2, face.uses.size(), std::hash<std::string>()(name) }, points);
  }
  for (const ComplexEdge& edge : c.edges)
  {
    std::vector<Bits> points;
    for (int n = 0; n <= edge.cells; ++n)
    {
      points.push_back(bits(edgePoint(c.blocks[edge.uses[0].block], edge.uses[0].edge, n)));
    }
    entity({ 1, edge.uses.size(), edge.boundary, edge.crease }, points);
  }
  for (const ComplexVertex& vertex : c.vertices)
  {
    entity({ 0, vertex.corners.size(), vertex.boundary },
      { bits(cornerPoint(c.blocks[vertex.corners[0].block], vertex.corners[0].corner)) });
  }
  std::sort(result.begin(), result.end());
  return result;
}

/// Everything that is built here, or refused, is so on several ranks too.
BlockComplex build(MeshCase& mesh, const BlockComplexOptions& options = {})
{
  bsvtest::expectSameOnRanks(mesh.mesh(), options);
  // The views must not outlive their mesh; the tests keep the points alive.
  return buildBlockComplex(mesh.mesh(), options);
}

std::string errorOf(MeshCase mesh, const BlockComplexOptions& options = {})
{
  try
  {
    build(mesh, options);
  }
  catch (const Error& error)
  {
    return error.what();
  }
  return "no error";
}

void expectMessage(const std::string& message, const std::vector<std::string>& parts)
{
  for (const std::string& part : parts)
  {
    EXPECT_NE(message.find(part), std::string::npos) << "\"" << part << "\" is not in: " << message;
  }
}

std::vector<double> range(int first, int last)
{
  std::vector<double> values;
  for (int n = first; n <= last; ++n)
  {
    values.push_back(n);
  }
  return values;
}

struct Named
{
  std::string name;
  MeshCase mesh;
  std::map<int, Index> curves;
  int singular;
  int euler;
};

/// Cases with the topology that their geometry has.
std::vector<Named> cases()
{
  std::vector<Named> result;
  result.push_back({ "one cell", cutBox({ 1, 1, 1 }), {}, 0, 1 });
  result.push_back({ "cut box", cutBox({ 6, 5, 4 }, { { { 2, 5 }, { 3 }, { 1, 2 } } }, wavy), {}, 0, 1 });
  result.push_back({ "one-cell blocks", cutBox({ 3, 3, 3 }, { { { 1, 2 }, { 1, 2 }, { 1, 2 } } }), {}, 0, 1 });
  result.push_back({ "L-shape", lShape(2), {}, 0, 1 });
  for (int valence : { 3, 4, 5, 6, 7, 8 })
  {
    std::map<int, Index> curves;
    if (valence != 4)
    {
      curves[valence] = 1;
    }
    result.push_back({ "ring " + std::to_string(valence),
      ring(valence, 3, { { 0.0, 1.0, 2.0 }, { 2.0, 2.5 }, { 2.5, 3.0, 4.0 } }), curves, 0, 1 });
  }
  result.push_back({ "sphere body", sphereBody(3, { 1.0, 1.5, 2.5 }), { { 3, 8 } }, 0, 2 });
  result.push_back({ "ball", ball(3, 2), { { 3, 20 } }, 8, 1 });
  result.push_back({ "torus", torus(4, 2), { { 3, 4 } }, 0, 0 });
  result.push_back({ "O-grid", oGrid({ 8, 2, 1 }), {}, 0, 0 });
  result.push_back({ "closed shell", closedShell({ 6, 5, 2 }), {}, 0, 0 });
  result.push_back({ "C-grid", cGrid(3, 6, 3, 1), {}, 0, 0 });
  result.push_back({ "partial interface",
    latticeBlocks({ { { 0, 0, 0 }, { 4, 4, 2 } }, { { 1, 1, 2 }, { 5, 3, 4 } }, { { 4, 0, 0 }, { 6, 4, 2 } } }, wavy),
    {}, 0, 1 });
  return result;
}

} // namespace

TEST(BlockComplex, EmptyMeshIsEmpty)
{
  MeshCase mesh;
  const BlockComplex c = build(mesh);
  EXPECT_TRUE(c.blocks.empty());
  EXPECT_TRUE(c.vertices.empty());
}

TEST(BlockComplex, HasTheTopologyOfTheGeometry)
{
  for (Named& named : cases())
  {
    SCOPED_TRACE(named.name);
    const BlockComplex c = build(named.mesh);
    expectConsistent(c);
    const EntityClasses classes = classifyEntities(c);
    EXPECT_EQ(classes.extraordinaryCurves, named.curves);
    EXPECT_EQ(classes.singularNodes, named.singular);
    EXPECT_EQ(eulerCharacteristic(c), named.euler);
    EXPECT_EQ(c.tangledCells, 0);
    EXPECT_TRUE(c.weldedPoints.empty());
    for (const ComplexBlock& block : c.blocks)
    {
      EXPECT_FALSE(block.leftHanded);
    }
  }
}

TEST(BlockComplex, CutBoxHasTheEntitiesOfItsLattice)
{
  MeshCase mesh = cutBox({ 6, 5, 4 }, { { { 2, 5 }, { 3 }, { 1, 2 } } });
  const BlockComplex c = build(mesh);
  const int n[3] = { 3, 2, 3 };
  EXPECT_EQ(int(c.blocks.size()), n[0] * n[1] * n[2]);
  EXPECT_EQ(int(c.vertices.size()), (n[0] + 1) * (n[1] + 1) * (n[2] + 1));
  EXPECT_EQ(int(c.edges.size()),
    n[0] * (n[1] + 1) * (n[2] + 1) + (n[0] + 1) * n[1] * (n[2] + 1) + (n[0] + 1) * (n[1] + 1) * n[2]);
  EXPECT_EQ(int(c.faces.size()), n[0] * n[1] * (n[2] + 1) + n[0] * (n[1] + 1) * n[2] + (n[0] + 1) * n[1] * n[2]);
  const auto inner = [](const ComplexVertex& v) { return !v.boundary; };
  EXPECT_EQ(std::count_if(c.vertices.begin(), c.vertices.end(), inner), (n[0] - 1) * (n[1] - 1) * (n[2] - 1));
}

TEST(BlockComplex, RingHasOneEdgePerStack)
{
  MeshCase mesh = ring(5, 2, { range(0, 2), range(2, 3), range(3, 6) });
  const BlockComplex c = build(mesh);
  std::vector<int> cells;
  for (const ComplexEdge& edge : c.edges)
  {
    if (edge.extraordinary())
    {
      EXPECT_EQ(edge.valence(), 5);
      cells.push_back(edge.cells);
    }
  }
  std::sort(cells.begin(), cells.end());
  EXPECT_EQ(cells, std::vector<int>({ 1, 2, 3 }));
}

TEST(BlockComplex, BlocksMeetThemselves)
{
  MeshCase shell = closedShell({ 6, 5, 2 });
  const BlockComplex c = build(shell);
  // Each closed direction identifies opposite sides.
  EXPECT_EQ(c.blocks.size(), 1u);
  EXPECT_EQ(c.vertices.size(), 2u);
  EXPECT_EQ(c.edges.size(), 5u);
  EXPECT_EQ(c.faces.size(), 4u);

  MeshCase flat = oGrid({ 8, 2, 1 });
  EXPECT_EQ(build(flat).faces.size(), 5u);

  // A wake cut glues the two ends of one face, which must be told from its middle: the body.
  MeshCase wake = cGrid(3, 6, 3, 2);
  const BlockComplex w = build(wake);
  ASSERT_EQ(w.blocks.size(), 3u);
  EXPECT_FALSE(w.faces[w.blocks[0].faces[2]].boundary());
  EXPECT_TRUE(w.faces[w.blocks[1].faces[2]].boundary());
  EXPECT_EQ(w.blocks[0].faces[2], w.blocks[2].faces[2]);
  EXPECT_EQ(w.blocks[1].name, "Block 0.1");
  EXPECT_EQ(w.blocks[1].offset, (Ijk{ 3, 0, 0 }));

  // Without a body the face is folded onto itself, and cut at the fold.
  MeshCase folded = cGrid(3, 0, 2, 1);
  const BlockComplex f = build(folded);
  ASSERT_EQ(f.blocks.size(), 2u);
  EXPECT_EQ(f.blocks[0].faces[2], f.blocks[1].faces[2]);
  expectConsistent(f);
}

TEST(BlockComplex, DoesNotDependOnNumberingAndOrientation)
{
  for (Named& named : cases())
  {
    SCOPED_TRACE(named.name);
    const auto expected = signature(build(named.mesh));
    for (unsigned seed = 1; seed <= 6; ++seed)
    {
      SCOPED_TRACE(seed);
      MeshCase shuffled = named.mesh;
      shuffle(shuffled, seed, seed % 2 == 0);
      const BlockComplex c = build(shuffled);
      expectConsistent(c);
      EXPECT_EQ(signature(c), expected);
    }
  }
}

TEST(BlockComplex, KnowsAllOrientationsOfABlock)
{
  const MeshCase original = ring(3, 2, { range(0, 2), range(2, 3) });
  MeshCase mesh = original;
  const auto expected = signature(build(mesh));
  for (int orientation = 0; orientation < MirroredOrientationCount; ++orientation)
  {
    SCOPED_TRACE(orientation);
    mesh = original;
    reorient(mesh, 1, orientation);
    const BlockComplex c = build(mesh);
    EXPECT_EQ(signature(c), expected);
    EXPECT_EQ(c.blocks[1].leftHanded, orientation >= OrientationCount);
    EXPECT_EQ(c.warnings.size(), orientation >= OrientationCount ? 1u : 0u);
    EXPECT_TRUE(c.notes.empty());
    EXPECT_EQ(c.tangledCells, 0);
  }
}

TEST(BlockComplex, DeclaredContactsGiveTheSameAsFoundOnes)
{
  BlockComplexOptions declaredOnly;
  declaredOnly.findInterfaces = false;
  for (Named& named : cases())
  {
    SCOPED_TRACE(named.name);
    MeshCase declared = named.mesh;
    declareAll(declared, 7);
    const BlockComplex c = build(declared, declaredOnly);
    expectConsistent(c);
    for (const ComplexFace& face : c.faces)
    {
      EXPECT_EQ(face.boundary(), face.tag >= 0);
    }
    const auto expected = signature(c);
    EXPECT_EQ(signature(build(declared)), expected);
    shuffle(declared, 5, true);
    EXPECT_EQ(signature(build(declared, declaredOnly)), expected);
    // The same without names is the same as found.
    declared.boundaries.clear();
    EXPECT_EQ(signature(build(declared, declaredOnly)), signature(build(named.mesh)));
    declared.interfaces.clear();
    EXPECT_EQ(build(declared, declaredOnly).faces.size(), 6 * named.mesh.blocks.size());
  }
}

TEST(BlockComplex, DoesNotDependOnTheOrderOfExecution)
{
  Execution backwards;
  backwards.parallelFor = [](Index count, Index, const Execution::Body& body) {
    for (Index n = count; n-- > 0;)
    {
      body(n, n + 1);
    }
  };
  for (Named& named : cases())
  {
    SCOPED_TRACE(named.name);
    const BlockComplex a = build(named.mesh);
    const BlockComplex b = buildBlockComplex(named.mesh.mesh(), {}, backwards);
    EXPECT_EQ(signature(a), signature(b));
    for (std::size_t n = 0; n < a.blocks.size(); ++n)
    {
      EXPECT_EQ(a.blocks[n].vertices, b.blocks[n].vertices);
      EXPECT_EQ(a.blocks[n].edges, b.blocks[n].edges);
      EXPECT_EQ(a.blocks[n].faces, b.blocks[n].faces);
    }
  }
}

TEST(BlockComplex, ReportsProgressAndStops)
{
  MeshCase mesh = cutBox({ 6, 5, 4 }, { { { 2, 5 }, { 3 }, { 1, 2 } } });
  Execution run;
  std::vector<double> told;
  run.progress = [&](double fraction) {
    told.push_back(fraction);
    return true;
  };
  buildBlockComplex(mesh.mesh(), {}, run);
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_GE(told.front(), 0.0);
  EXPECT_EQ(told.back(), 1.0);
  for (std::size_t stop = 0; stop < told.size(); ++stop)
  {
    std::size_t calls = 0;
    run.progress = [&](double) { return calls++ < stop; };
    EXPECT_THROW(buildBlockComplex(mesh.mesh(), {}, run), Aborted);
  }
}

TEST(BlockComplex, CutsPartialContactsAndCarriesTheCutsOn)
{
  // Two blocks of unequal extent over one, and a third behind the latter that only meets its far side.
  MeshCase mesh = latticeBlocks({ { { 0, 0, 0 }, { 4, 4, 2 } }, { { 0, 0, 2 }, { 1, 4, 4 } },
    { { 1, 0, 2 }, { 4, 4, 4 } }, { { 0, 0, -3 }, { 4, 4, 0 } } });
  mesh.blocks[0].name = "wing";
  const BlockComplex c = build(mesh);
  expectConsistent(c);
  ASSERT_EQ(c.blocks.size(), 6u);
  EXPECT_EQ(c.blocks[0].name, "wing.0");
  EXPECT_EQ(c.blocks[1].name, "wing.1");
  EXPECT_EQ(c.blocks[1].parent, 0);
  EXPECT_EQ(c.blocks[1].offset, (Ijk{ 1, 0, 0 }));
  EXPECT_EQ(c.blocks[2].name, "Block 1");
  EXPECT_EQ(c.blocks[4].name, "Block 3.0");
  EXPECT_TRUE(c.warnings.empty());
  ASSERT_EQ(c.notes.size(), 1u);
  expectMessage(c.notes[0], { "2 blocks were split", "\"wing\" into 2", "block 3 into 2" });
  // The pieces are windows on the points of the mesh.
  EXPECT_EQ(c.blocks[1].points.address<double>(0, 0, 0), mesh.blocks[0].at({ 1, 0, 0 }).data());
}

TEST(BlockComplex, CutsFacesAtBoundaryBorders)
{
  MeshCase mesh = cutBox({ 4, 4, 4 }, { { { 2 }, {}, {} } });
  mesh.boundaryNames = { "wall", "outflow" };
  mesh.boundaries.push_back({ 0, 2, { { 0, 0 }, { 2, 3 } }, 1 });
  mesh.boundaries.push_back({ 0, 2, { { 0, 3 }, { 2, 4 } }, 0 });
  const BlockComplex c = build(mesh);
  expectConsistent(c);
  ASSERT_EQ(c.blocks.size(), 4u);
  EXPECT_EQ(c.faces[c.blocks[0].faces[2]].tag, 1);
  EXPECT_EQ(c.faces[c.blocks[1].faces[2]].tag, 0);
  EXPECT_EQ(c.faces[c.blocks[0].faces[0]].tag, -1);
  EXPECT_EQ(c.blocks[1].offset, (Ijk{ 0, 0, 3 }));
}

TEST(BlockComplex, CreaseLinesCutTheirFace)
{
  MeshCase mesh = cutBox({ 4, 4, 4 }, { { { 2 }, {}, {} } });
  // Along k on the face j = 0 of block 0, from the middle to the end.
  mesh.creases.push_back({ 0, { 1, 0, 4 }, { 1, 0, 2 } });
  const BlockComplex c = build(mesh);
  expectConsistent(c);
  // Block 0 is cut across i at 1 and across k at 2; the latter goes on into block 1.
  EXPECT_EQ(c.blocks.size(), 6u);
  const auto isCrease = [](const ComplexEdge& edge) { return edge.crease; };
  ASSERT_EQ(std::count_if(c.edges.begin(), c.edges.end(), isCrease), 1);
  const ComplexEdge& crease = *std::find_if(c.edges.begin(), c.edges.end(), isCrease);
  EXPECT_EQ(crease.cells, 2);
  EXPECT_EQ(crease.valence(), 2);

  // The same by sharpness of points, infinite as OpenSubdiv has it.
  MeshCase sharp = cutBox({ 4, 4, 4 }, { { { 2 }, {}, {} } });
  MeshCase::Block& block = sharp.blocks[0];
  block.creaseSharpness.assign(block.points.size(), 0.0);
  for (int k = 2; k <= 4; ++k)
  {
    block.creaseSharpness[block.index({ 1, 0, k })] = SharpnessInfinite;
  }
  const auto expected = signature(c);
  EXPECT_EQ(signature(build(sharp)), expected);
  shuffle(sharp, 3, true);
  EXPECT_EQ(signature(build(sharp)), expected);
  shuffle(mesh, 4, true);
  EXPECT_EQ(signature(build(mesh)), expected);
}

TEST(BlockComplex, CreasesCountOnTheOuterBoundaryOnly)
{
  MeshCase mesh = cutBox({ 4, 4, 4 }, { { { 2 }, {}, {} } });
  const auto expected = signature(build(mesh));
  mesh.creases.push_back({ 0, { 1, 2, 0 }, { 1, 2, 4 } }); // inside the block
  mesh.creases.push_back({ 1, { 0, 2, 0 }, { 0, 2, 4 } }); // inside the contact
  EXPECT_EQ(signature(build(mesh)), expected);
}

/// Where a block has an edge of the boundary to itself, a crease may end anywhere without a cut.
TEST(BlockComplex, CreasesInPartOfAnOutlineNeedNoCut)
{
  MeshCase mesh = cutBox({ 4, 4, 4 });
  mesh.creases.push_back({ 0, { 0, 4, 1 }, { 0, 4, 2 } });
  const BlockComplex c = build(mesh);
  EXPECT_EQ(c.blocks.size(), 1u);
  EXPECT_EQ(std::count_if(c.edges.begin(), c.edges.end(), [](const ComplexEdge& e) { return e.crease; }), 1);
  const auto expected = signature(c);
  for (int orientation = 1; orientation < MirroredOrientationCount; ++orientation)
  {
    MeshCase turned = mesh;
    reorient(turned, 0, orientation);
    EXPECT_EQ(signature(build(turned)), expected);
  }
}

/// The tag sits on the block in the re-entrant corner, which has no boundary face at that edge.
TEST(BlockComplex, CreasesReachAllBlocksAtTheEdge)
{
  MeshCase mesh = lShape(3);
  mesh.creases.push_back({ 0, { 3, 3, 1 }, { 3, 3, 3 } });
  const BlockComplex c = build(mesh);
  expectConsistent(c);
  // All three blocks are cut at k = 1.
  EXPECT_EQ(c.blocks.size(), 6u);
  int creases = 0;
  for (const ComplexEdge& edge : c.edges)
  {
    if (edge.crease)
    {
      ++creases;
      EXPECT_EQ(edge.valence(), 3);
      EXPECT_EQ(edge.cells, 2);
    }
  }
  EXPECT_EQ(creases, 1);
}

TEST(BlockComplex, FindsSharpEdges)
{
  BlockComplexOptions options;
  options.creaseAngle = 89.0;
  MeshCase box = cutBox({ 4, 4, 4 }, { { { 2 }, {}, {} } });
  const BlockComplex c = build(box, options);
  int creases = 0;
  for (const ComplexEdge& edge : c.edges)
  {
    creases += edge.crease;
    // Where the blocks meet, the boundary is flat.
    EXPECT_EQ(edge.crease, edge.valence() == 1);
  }
  EXPECT_EQ(c.blocks.size(), 2u);
  // Twelve edges of the box, of which the four along i consist of two.
  EXPECT_EQ(creases, 16);
  options.creaseAngle = 91.0;
  for (const ComplexEdge& edge : build(box, options).edges)
  {
    EXPECT_FALSE(edge.crease);
  }

  // The re-entrant edge of the L is a crease for its three blocks.
  MeshCase bent = lShape(2);
  options.creaseAngle = 60.0;
  int reentrant = 0;
  for (const ComplexEdge& edge : build(bent, options).edges)
  {
    reentrant += edge.crease && edge.valence() == 3;
  }
  EXPECT_EQ(reentrant, 1);

  // A kink inside a face cuts the block.
  MeshCase kinked =
    cutBox({ 5, 4, 2 }, {}, [](const Vec3& x) { return Vec3(x[0], x[1], x[2] + std::abs(x[0] - 2.0)); });
  for (unsigned seed = 0; seed < 4; ++seed)
  {
    MeshCase turned = kinked;
    shuffle(turned, seed, true);
    const BlockComplex k = build(turned, options);
    EXPECT_EQ(k.blocks.size(), 2u);
    expectConsistent(k);
  }
}

namespace
{

/// A cylinder of `cells` cells around, and 3 x 2 along it and across it; the wall is k = 0, or k = K if `outside`. Its
/// points are computed one by one, each with its own rounding, starting anywhere.
MeshCase cylinder(int cells, double start, bool outside)
{
  MeshCase mesh;
  mesh.add({ cells, 3, 2 }, [=](const Ijk& p) {
    const double angle = start + 2.0 * std::acos(-1.0) * (p[0] % cells) / cells;
    const double radius = outside ? 2.0 - 0.5 * p[2] : 1.0 + 0.5 * p[2];
    return Vec3(radius * std::cos(angle), radius * std::sin(angle), p[1]);
  });
  return mesh;
}

struct Creased
{
  BlockComplex complex;
  std::vector<TurningEdge> turning;
};

Creased creased(const BlockMesh& mesh, double angle, const CreaseRules& rules = {})
{
  Creased result;
  BlockComplexOptions options;
  options.creaseAngle = angle;
  result.complex = buildBlockComplex(mesh, options, rules, &result.turning);
  return result;
}

/// Creases of the complex among the edges that run along z.
int creasesAlong(const Creased& found)
{
  int count = 0;
  for (const TurningEdge& edge : found.turning)
  {
    count += edge.crease && std::abs(edge.ends[0][2] - edge.ends[1][2]) > 0.5;
  }
  return count;
}

bool notesContain(const Creased& found, const std::string& text)
{
  return std::any_of(found.complex.notes.begin(), found.complex.notes.end(),
    [&](const std::string& note) { return note.find(text) != std::string::npos; });
}

} // namespace

/// A circle that turns by exactly the limit at every point gets no creases, or the same everywhere.
TEST(BlockComplex, CreasesOfACircleAreSymmetric)
{
  for (const int cells : { 12, 24 })
  {
    for (int n = 0; n < 40; ++n)
    {
      MeshCase mesh = cylinder(cells, 0.17 * n, n % 2 == 1);
      CreaseRules all;
      all.contrast = 0.0;
      const double limit = 360.0 / cells;
      const Creased found = creased(mesh.mesh(), limit, all);
      EXPECT_EQ(creasesAlong(found), 0);
      // Both walls, three edges along z each.
      EXPECT_TRUE(notesContain(found, std::to_string(6 * cells) + " mesh edges turn by "));
      EXPECT_TRUE(notesContain(found, "the limit"));
      EXPECT_EQ(creasesAlong(creased(mesh.mesh(), limit - 0.1, all)), 6 * cells);
      const Creased above = creased(mesh.mesh(), limit + 0.1, all);
      EXPECT_EQ(creasesAlong(above), 0);
      EXPECT_FALSE(notesContain(above, "the limit"));
    }
  }
}

/// Sharp edges are told from round noses by how much the surface turns nearby.
TEST(BlockComplex, CreasesStandOut)
{
  // An O-grid around a profile with a sharp end at x = 1 and a round one at x = 0, coarse to fine, or blunt at x = 1.
  for (const int half : { 4, 8, 16 })
  {
    for (const double base : { 0.0, 0.01 })
    {
      MeshCase mesh;
      const int around = 2 * half + (base > 0.0 ? 1 : 0);
      mesh.add({ around, 4, 3 }, [=](const Ijk& p) {
        // From the end along the lower side to the nose and back; a base closes it.
        const int i = p[0] % around;
        const double t = i <= half ? 1.0 - double(i) / half : double(i - half) / half;
        const double side = i <= half ? -1.0 : 1.0;
        const double x = t * t, y = side * (0.15 * (t - x) + base * x * (i <= half || base > 0.0 ? 1.0 : 0.0));
        const double angle = -std::acos(-1.0) * 2.0 * i / around;
        const double w = p[1] / 4.0;
        return Vec3((1.0 - w) * x + w * (0.5 + 3.0 * std::cos(angle)), (1.0 - w) * y + w * 3.0 * std::sin(angle), p[2]);
      });
      for (unsigned seed = 0; seed < 3; ++seed)
      {
        shuffle(mesh, seed, true);
        const Creased found = creased(mesh.mesh(), 30.0);
        int sharp = 0, nose = 0;
        for (const TurningEdge& edge : found.turning)
        {
          const Vec3 middle = 0.5 * (edge.ends[0] + edge.ends[1]);
          const bool along = std::abs(edge.ends[0][2] - edge.ends[1][2]) > 0.5;
          sharp += along && edge.crease && middle[0] > 0.99 && middle[0] < 1.01;
          nose += along && edge.crease && middle[0] < 0.9 && middle[0] > -0.1;
        }
        EXPECT_EQ(sharp, base > 0.0 ? 6 : 3) << half << ' ' << base;
        EXPECT_EQ(nose, 0) << half << ' ' << base;
      }
    }
  }
}

/// Wings with 8 to 32 cells around the nose: the edges of the nose are no creases, those of a trailing edge are, if it
/// is sharp or blunt. One that is rounded by a half circle of a few cells is round.
TEST(BlockComplex, NosesAndTrailingEdges)
{
  struct End
  {
    const char* name;
    double base; ///< half its thickness
    int cells;   ///< across it
    int creases; ///< mesh lines along the span
  };
  const End ends[] = { { "sharp", 0.0, 0, 1 }, { "blunt", 0.01, 1, 2 }, { "blunt, four cells", 0.01, 4, 2 },
    { "rounded by two cells", 0.01, 2, 0 }, { "rounded by four cells", 0.01, 4, 0 },
    { "rounded by eight cells", 0.01, 8, 0 } };
  for (const int nose : { 8, 16, 32 })
  {
    for (const End& end : ends)
    {
      // From the upper end to the nose, around it in steps of the same parameter, to the lower end, and back across it.
      constexpr int Side = 10;
      constexpr double NoseLength = 0.03;
      const auto thickness = [&](double x) { return 0.15 * (std::sqrt(x) - x) + end.base * x; };
      std::vector<std::array<double, 2>> profile;
      for (int i = 0; i <= 2 * Side + nose; ++i)
      {
        const int k = i < Side ? Side - i : i > Side + nose ? i - Side - nose : 0;
        const double s = k > 0 ? 0.0 : 2.0 * (i - Side) / nose - 1.0;
        const double x =
          k > 0 ? NoseLength + (1.0 - NoseLength) * 0.5 * (1.0 - std::cos(Pi * k / Side)) : NoseLength * s * s;
        const bool upper = i < Side || (k == 0 && s < 0.0);
        profile.push_back({ x, (upper ? 1.0 : -1.0) * thickness(x) });
      }
      const bool rounded = std::string(end.name).find("rounded") == 0;
      for (int i = 1; i < end.cells; ++i)
      {
        const double angle = Pi * (double(i) / end.cells - 0.5);
        profile.push_back({ rounded ? 1.0 + end.base * std::cos(angle) : 1.0,
          end.base * (rounded ? std::sin(angle) : 2.0 * i / end.cells - 1.0) });
      }
      if (end.cells == 0)
      {
        profile.pop_back();
      }
      const int around = static_cast<int>(profile.size());
      MeshCase mesh;
      mesh.add({ around, 4, 3 }, [&](const Ijk& p) {
        const std::array<double, 2>& foot = profile[p[0] % around];
        const double angle = 2.0 * Pi * (p[0] % around) / around, w = p[1] / 4.0;
        return Vec3((1.0 - w) * foot[0] + w * (0.5 + 3.0 * std::cos(angle)),
          (1.0 - w) * foot[1] + w * 3.0 * std::sin(angle), p[2]);
      });
      const Creased found = creased(mesh.mesh(), 30.0);
      int sharp = 0, others = 0;
      for (const TurningEdge& edge : found.turning)
      {
        const Vec3 middle = 0.5 * (edge.ends[0] + edge.ends[1]);
        if (edge.crease && std::abs(edge.ends[0][2] - edge.ends[1][2]) > 0.5 && middle.head<2>().norm() < 1.5)
        {
          ++(middle[0] > 0.99 ? sharp : others);
        }
      }
      EXPECT_EQ(sharp, 3 * end.creases) << nose << " cells, " << end.name;
      EXPECT_EQ(others, 0) << nose << " cells, " << end.name;
    }
  }
}

/// Where a body is given, it decides alone.
TEST(BlockComplex, TheBodySaysWhatIsSharp)
{
  MeshCase box = cutBox({ 4, 4, 4 });
  box.boundaryNames = { "wall" };
  for (int face = 0; face < 6; ++face)
  {
    box.boundaries.push_back({ 0, face, { { 0, 0 }, { 4, 4 } }, 0 });
  }
  CreaseRules rules;
  rules.bodyTags = { true };
  rules.bodyTurn = [](const Vec3& x, double) { return x[0] < 2.0 ? 90.0 : 0.0; };
  for (const TurningEdge& edge : creased(box.mesh(), 30.0, rules).turning)
  {
    EXPECT_EQ(edge.crease, edge.ends[0][0] < 2.0 && edge.ends[1][0] < 2.0);
  }
  rules.bodyTags = { false };
  for (const TurningEdge& edge : creased(box.mesh(), 30.0, rules).turning)
  {
    EXPECT_TRUE(edge.crease);
    EXPECT_EQ(edge.bodyAngle, -1.0);
  }
}

/// More blocks around an edge than there are rules for are refused with block and point.
TEST(BlockComplex, RefusesCrowdedEdges)
{
  // Sectors whose outer corner lies hardly further out than the others.
  const auto fan = [](int blocks) {
    MeshCase mesh;
    for (int b = 0; b < blocks; ++b)
    {
      mesh.add({ 1, 1, 1 }, [=](const Ijk& p) {
        const double angle =
          Vec3(2 * (b % blocks), 2 * b + 1, 2 * ((b + 1) % blocks))[p[1] - p[0] + 1] * std::acos(-1.0) / blocks;
        const double radius = p[0] + p[1] == 0 ? 0.0 : p[0] + p[1] == 1 ? 1.0 : 1.01;
        return Vec3(radius * std::cos(angle), radius * std::sin(angle), p[2]);
      });
    }
    return mesh;
  };
  MeshCase most = fan(MostBlocksAtEdge);
  EXPECT_EQ(buildBlockComplex(most.mesh()).blocks.size(), std::size_t(MostBlocksAtEdge));
  MeshCase more = fan(MostBlocksAtEdge + 1);
  try
  {
    buildBlockComplex(more.mesh());
    FAIL() << "not refused";
  }
  catch (const Error& error)
  {
    EXPECT_NE(std::string(error.what()).find("more than 100 blocks meet at the edge of Block 0"), std::string::npos)
      << error.what();
  }
}

/// Points that differ by less than the tolerance are one: the smallest copy, whatever the numbering.
TEST(BlockComplex, WeldsNearPoints)
{
  for (const MeshCase& original : { cutBox({ 6, 5, 4 }, { { { 2, 5 }, { 3 }, { 1, 2 } } }, wavy), ball(3, 2),
         ring(5, 2, { range(0, 2), range(2, 3) }), cGrid(3, 6, 3, 1) })
  {
    MeshCase exact = original;
    const BlockComplex expected = build(exact);
    MeshCase mesh = original;
    std::mt19937 random(11);
    std::uniform_real_distribution<double> jitter(-1e-4, 1e-4);
    for (MeshCase::Block& block : mesh.blocks)
    {
      for (Vec3& x : block.points)
      {
        x += Vec3(jitter(random), jitter(random), jitter(random));
      }
    }
    const BlockComplex c = build(mesh);
    expectConsistent(c);
    EXPECT_FALSE(c.weldedPoints.empty());
    EXPECT_EQ(c.vertices.size(), expected.vertices.size());
    EXPECT_EQ(c.edges.size(), expected.edges.size());
    EXPECT_EQ(c.faces.size(), expected.faces.size());
    for (unsigned seed = 1; seed <= 3; ++seed)
    {
      MeshCase shuffled = mesh;
      shuffle(shuffled, seed, true);
      EXPECT_EQ(signature(build(shuffled)), signature(c));
    }
  }
}

TEST(BlockComplex, WeldsSinglePrecisionToDouble)
{
  MeshCase mesh = cutBox({ 4, 4, 4 }, { { { 2 }, { 1 }, {} } }, wavy);
  mesh.blocks[1].isFloat = mesh.blocks[2].isFloat = true;
  const BlockComplex c = build(mesh);
  expectConsistent(c);
  EXPECT_EQ(c.vertices.size(), 18u);
  EXPECT_FALSE(c.weldedPoints.empty());

  // All in single precision nothing differs, and nothing is copied.
  for (MeshCase::Block& block : mesh.blocks)
  {
    block.isFloat = true;
  }
  const BlockComplex f = build(mesh);
  expectConsistent(f);
  EXPECT_TRUE(f.weldedPoints.empty());
  EXPECT_TRUE(f.blocks[0].points.isFloat());
}

TEST(BlockComplex, WeldsTheSignsOfZeros)
{
  MeshCase mesh =
    cutBox({ 2, 2, 2 }, { { { 1 }, {}, {} } }, [](const Vec3& x) { return Vec3(x[0] - 1.0, x[1], x[2]); });
  for (int k = 0; k <= 2; ++k)
  {
    mesh.blocks[1].at({ 0, 1, k })[0] = -0.0;
  }
  const BlockComplex c = build(mesh);
  EXPECT_EQ(c.faces.size(), 11u);
  expectConsistent(c);
}

TEST(BlockComplex, RefusesAmbiguousGluing)
{
  // The same block three times.
  MeshCase thrice =
    latticeBlocks({ { { 0, 0, 0 }, { 2, 2, 2 } }, { { 2, 0, 0 }, { 4, 2, 2 } }, { { 2, 0, 0 }, { 4, 2, 2 } } });
  expectMessage(errorOf(thrice), { "ambiguous gluing", "block 0 face 1 (i=I)", "block 1", "block 2" });
  // Twice: every face finds its copy, on the wrong side.
  MeshCase twice = latticeBlocks({ { { 0, 0, 0 }, { 2, 2, 2 } }, { { 0, 0, 0 }, { 2, 2, 2 } } });
  expectMessage(errorOf(twice), { "block 0", "block 1", "same side" });
  // A chain of near points.
  MeshCase chain = ring(3, 2, { range(0, 1) });
  for (int n = 0; n < 3; ++n)
  {
    chain.blocks[n].at({ 0, 0, 0 })[0] += 0.02 * n;
  }
  expectMessage(errorOf(chain), { "ambiguous gluing", "chain", "allowed is" });
}

TEST(BlockComplex, RefusesContactsThatDoNotMatch)
{
  // Twice as fine on one side.
  MeshCase mesh = latticeBlocks({ { { 0, 0, 0 }, { 4, 4, 4 } } });
  mesh.blocks[0].name = "coarse";
  mesh.add(
    { 8, 8, 4 }, [](const Ijk& p) { return Vec3(p[0] / 2.0, p[1] / 2.0, 4.0 + p[2]); }, "fine");
  expectMessage(errorOf(mesh), { "non-matching", "\"coarse\" face 5 (k=K)", "\"fine\" face 4 (k=0)", "near (" });
  for (unsigned seed = 1; seed <= 5; ++seed)
  {
    MeshCase shuffled = mesh;
    shuffle(shuffled, seed, true);
    expectMessage(errorOf(shuffled), { "non-matching", "\"coarse\"", "\"fine\"" });
  }
  // Half a cell aside, also where one side is skewed.
  MeshCase shifted = latticeBlocks({ { { 0, 0, 0 }, { 4, 4, 4 } } });
  shifted.add({ 4, 4, 4 }, [](const Ijk& p) { return Vec3(p[0] + 0.5, p[1] + 0.3 + 0.1 * p[0], 4.0 + p[2]); });
  expectMessage(errorOf(shifted), { "non-matching", "block 0", "block 1" });
  // Curved: the fine points lie off the coarse faces, but half of them are shared.
  MeshCase spheres = sphereBody(3, { 1.0, 1.5, 2.0 });
  for (const MeshCase::Block& outer : sphereBody(6, { 2.0, 2.5, 3.0 }).blocks)
  {
    spheres.blocks.push_back(outer);
  }
  expectMessage(errorOf(spheres), { "non-matching" });
  shuffle(spheres, 2, true);
  expectMessage(errorOf(spheres), { "non-matching" });
  // Declared as boundaries they are none of our business.
  shifted.boundaryNames = { "wall" };
  shifted.boundaries.push_back({ 0, 5, { { 0, 0 }, { 4, 4 } }, 0 });
  shifted.boundaries.push_back({ 1, 4, { { 0, 0 }, { 4, 4 } }, 0 });
  EXPECT_EQ(errorOf(shifted), "no error");
  BlockComplexOptions asDeclared;
  asDeclared.findInterfaces = false;
  EXPECT_EQ(errorOf(mesh, asDeclared), "no error");
}

TEST(BlockComplex, AcceptsGapsAndThinWalls)
{
  // A solid plate between two blocks, a tenth of a cell thin, with points that face each other and with others.
  for (double shift : { 0.0, 0.3 })
  {
    MeshCase plate = latticeBlocks({ { { 0, 0, 0 }, { 4, 4, 4 } } });
    plate.add({ 4, 4, 4 }, [&](const Ijk& p) { return Vec3(p[0] + shift, p[1], 4.1 + p[2]); });
    const BlockComplex c = build(plate);
    EXPECT_EQ(c.faces.size(), 12u);
  }
  // A thin block between thick ones.
  MeshCase thin = cutBox({ 4, 4, 3 }, { { {}, {}, { 1, 2 } } },
    [](const Vec3& x) { return Vec3(x[0], x[1], x[2] < 2 ? x[2] * 1e-6 : x[2]); });
  EXPECT_EQ(build(thin).vertices.size(), 16u);
  // Steeply graded towards a corner: the tolerance follows the spacing.
  MeshCase graded = cutBox({ 12, 12, 12 }, { { { 6 }, { 6 }, { 6 } } }, [](const Vec3& x) {
    return Vec3(std::pow(0.2, 12.0 - x[0]), std::pow(0.2, 12.0 - x[1]), std::pow(0.2, 12.0 - x[2]));
  });
  EXPECT_EQ(build(graded).vertices.size(), 27u);
}

TEST(BlockComplex, RefusesBadPoints)
{
  for (const double bad : { std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity() })
  {
    MeshCase mesh = cutBox({ 4, 3, 2 }, { { { 2 }, {}, {} } });
    mesh.blocks[1].name = "tail";
    mesh.blocks[1].at({ 1, 2, 1 })[1] = bad;
    expectMessage(errorOf(mesh), { "block 1 \"tail\"", "(1, 2, 1)", std::isnan(bad) ? "nan" : "inf", "not finite" });
  }
  MeshCase flat = cutBox({ 2, 2, 2 });
  flat.blocks[0].counts[2] = 1;
  expectMessage(errorOf(flat), { "block 0", "1 points in direction k", "at least 2" });
}

TEST(BlockComplex, RefusesZeroExtentUnlessAllowed)
{
  BlockComplexOptions allowed;
  allowed.allowDegenerate = true;

  MeshCase axis = oGrid({ 8, 3, 2 }, 0.0);
  expectMessage(errorOf(axis), { "block 0", "cell (0, 0, 0)", "edge of no length" });
  const BlockComplex c = build(axis, allowed);
  EXPECT_FALSE(c.blocks.empty());
  EXPECT_GT(c.tangledCells, 0);

  // Two wedges that meet in a face whose quadrilaterals at the edge are collapsed: these are no contact, the others
  // are, and the blocks are cut between them.
  MeshCase wedges =
    cutBox({ 2, 3, 4 }, { { {}, {}, { 2 } } }, [](const Vec3& x) { return Vec3(x[0] * x[1], x[1], x[2]); });
  EXPECT_EQ(build(wedges, allowed).blocks.size(), 4u);

  MeshCase sheet = cutBox({ 2, 2, 2 }, {}, [](const Vec3& x) { return Vec3(x[0], x[1], x[0] + x[2] * (x[1] - 1.0)); });
  EXPECT_NE(errorOf(sheet), "no error");
  EXPECT_EQ(errorOf(sheet, allowed), "no error");

  MeshCase flat = cutBox({ 1, 1, 1 }, {}, [](const Vec3& x) { return Vec3(x[0] + x[2], x[1] + 0.5 * x[2], 0.0); });
  expectMessage(errorOf(flat), { "block 0", "cell (0, 0, 0)", "no volume" });

  MeshCase line = cutBox({ 1, 1, 1 });
  line.blocks[0].at({ 0, 1, 0 }) = Vec3(1.0 / 3.0, 0.0, 0.0);
  line.blocks[0].at({ 1, 1, 0 }) = Vec3(2.0 / 3.0, 0.0, 0.0);
  expectMessage(errorOf(line), { "block 0", "cell (0, 0, 0)", "face of no area" });
}

TEST(BlockComplex, CountsTangledCells)
{
  MeshCase mesh = cutBox({ 4, 4, 4 });
  // Pulled beyond its neighbours in both i: the eight cells around it.
  mesh.blocks[0].at({ 2, 2, 2 })[0] += 1.3;
  for (int orientation : { 0, 5, 30 })
  {
    MeshCase turned = mesh;
    reorient(turned, 0, orientation);
    const BlockComplex c = build(turned);
    EXPECT_EQ(c.tangledCells, 4);
    ASSERT_EQ(c.warnings.size(), orientation >= OrientationCount ? 2u : 1u);
    expectMessage(c.warnings.back(), { "4 cells are tangled", "block 0 at cell (" });
  }
}

TEST(BlockComplex, RefusesBadDeclarations)
{
  const MeshCase box = cutBox({ 4, 4, 4 }, { { { 2 }, {}, {} } });
  Interface good;
  good.faceA = 1;
  good.blockB = 1;
  good.faceB = 0;
  good.rangeA.hi = { 4, 4 };
  const auto with = [&](const std::function<void(Interface&)>& change) {
    MeshCase mesh = box;
    Interface contact = good;
    change(contact);
    mesh.interfaces.push_back(contact);
    return errorOf(mesh);
  };
  EXPECT_EQ(with([](Interface&) {}), "no error");
  expectMessage(with([](Interface& i) { i.blockB = 2; }), { "interface 0", "no block 2" });
  expectMessage(with([](Interface& i) { i.blockA = -1; }), { "interface 0", "no block -1" });
  expectMessage(with([](Interface& i) { i.faceA = 6; }), { "interface 0", "no face 6" });
  expectMessage(with([](Interface& i) { i.orientation = 8; }), { "interface 0", "no orientation 8" });
  expectMessage(with([](Interface& i) { i.rangeA.hi[1] = 5; }), { "interface 0", "0 to 5", "block 0 face 1" });
  expectMessage(with([](Interface& i) { i.rangeA.lo[0] = 4; }), { "interface 0", "4 to 4" });
  expectMessage(with([](Interface& i) { i.originB[0] = 1; }), { "interface 0", "1 to 5", "block 1 face 0" });
  expectMessage(with([](Interface& i) { i.originB[0] = std::numeric_limits<int>::max(); }), { "interface 0" });
  expectMessage(with([](Interface& i) { i.orientation = 2; }),
    { "interface 0", "does not match the coordinates", "(2, 0, 0) of block 0", "(0, 4, 0) of block 1", "are 4 apart" });
  expectMessage(with([](Interface& i) { i.blockB = 0, i.faceB = 1; }), { "interface 0", "meets itself" });

  MeshCase twice = box;
  twice.interfaces = { good, good };
  expectMessage(errorOf(twice), { "interface 1", "block 0 face 1", "already" });

  MeshCase both = box;
  both.interfaces = { good };
  both.boundaryNames = { "wall", "tip" };
  both.boundaries.push_back({ 0, 1, { { 0, 0 }, { 1, 1 } }, 0 });
  expectMessage(errorOf(both), { "boundary 0", "in an interface already" });
  both.boundaries = { { 0, 0, { { 0, 0 }, { 4, 4 } }, 0 }, { 0, 0, { { 3, 3 }, { 4, 4 } }, 1 } };
  expectMessage(errorOf(both), { "boundary 1", "(3, 3)", "\"wall\"" });
  both.boundaries = { { 0, 0, { { 0, 0 }, { 4, 5 } }, 0 } };
  expectMessage(errorOf(both), { "boundary 0", "0 to 5" });
  both.boundaries = { { 0, 0, { { 0, 0 }, { 4, 4 } }, 2 } };
  expectMessage(errorOf(both), { "boundary 0", "no boundary name 2" });
}

TEST(BlockComplex, RefusesBadCreases)
{
  const auto withLine = [](const CreaseLine& line) {
    MeshCase mesh = cutBox({ 4, 4, 4 });
    mesh.creases.push_back(line);
    return errorOf(mesh);
  };
  expectMessage(withLine({ 1, { 0, 0, 0 }, { 1, 0, 0 } }), { "crease line 0", "no block 1" });
  expectMessage(withLine({ 0, { 0, 0, 0 }, { 5, 0, 0 } }), { "crease line 0", "(5, 0, 0)" });
  expectMessage(withLine({ 0, { 0, 0, -1 }, { 0, 0, 2 } }), { "crease line 0", "(0, 0, -1)" });
  expectMessage(withLine({ 0, { 0, 0, 0 }, { 1, 1, 0 } }), { "crease line 0", "exactly one direction" });
  expectMessage(withLine({ 0, { 0, 1, 0 }, { 0, 1, 0 } }), { "crease line 0", "exactly one direction" });

  const auto withSharpness = [](double value) {
    MeshCase mesh = cutBox({ 4, 4, 4 }, { { { 2 }, {}, {} } });
    mesh.blocks[1].creaseSharpness.assign(mesh.blocks[1].points.size(), 0.0);
    mesh.blocks[1].creaseSharpness[mesh.blocks[1].index({ 1, 2, 3 })] = value;
    return errorOf(mesh);
  };
  for (double value : { 0.5, 3.0, 9.99, -1.0, std::numeric_limits<double>::quiet_NaN() })
  {
    expectMessage(withSharpness(value), { "block 1", "(1, 2, 3)", "sharpness", "neither 0 nor infinite" });
  }
  EXPECT_EQ(withSharpness(std::numeric_limits<double>::infinity()), "no error");
  MeshCase wrong = cutBox({ 4, 4, 4 });
  wrong.blocks[0].creaseSharpness.assign(7, 0.0);
  expectMessage(errorOf(wrong), { "block 0", "7 values", "125 points" });
}

TEST(BlockComplex, RefusesOptionsOutOfRange)
{
  const MeshCase box = cutBox({ 1, 1, 1 });
  BlockComplexOptions options;
  options.matchTolerance = 0.5;
  expectMessage(errorOf(box, options), { "Match Tolerance 0.5 is not between 0 and 0.5" });
  options.matchTolerance = std::numeric_limits<double>::quiet_NaN();
  expectMessage(errorOf(box, options), { "Match Tolerance nan" });
  options = {};
  options.creaseAngle = -1.0;
  expectMessage(errorOf(box, options), { "Crease Angle -1" });
}

TEST(BlockComplex, RefusesMoreThanAMillionPieces)
{
  MeshCase mesh = cutBox({ 101, 101, 101 });
  mesh.blocks[0].creaseSharpness.assign(mesh.blocks[0].points.size(), SharpnessInfinite);
  expectMessage(errorOf(mesh), { "more than 1000000 pieces", "block 0" });
}
