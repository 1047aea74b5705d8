// SPDX-License-Identifier: BSD-3-Clause
// The topology file: numbering, round trips, malformed files, and writing that leaves nothing half done.
#include "Quadflow/QuadflowFormat.h"

#include "Conversion/Conversion.h"
#include "Mesh/SharedEntities.h"
#include "Support/Files.h"
#include "Support/ThreadRanks.h"
#include "Support/VolumeCases.h"

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <set>
#include <sstream>

#include <sched.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

using namespace bsv;
using namespace bsvtest;
namespace fs = std::filesystem;

namespace
{

QuadflowInput inputOf(const Volumes& volumes)
{
  QuadflowInput input;
  for (std::size_t b = 0; b < volumes.blocks.size(); ++b)
  {
    input.volumes.push_back(volumes.blocks[b].view());
    input.names.push_back("block " + std::to_string(b));
  }
  input.hasInterfaces = true;
  input.interfaces = volumes.interfaces;
  return input;
}

/// A case that owns the control points that were read.
struct ReadCase
{
  QuadflowCase data;
  std::vector<std::vector<double>> points;
};

ReadCase readCase(const std::string& path, const Execution& run = {})
{
  ReadCase result;
  result.data = readQuadflow(
    path,
    [&](int block, const std::array<int, 3>& counts) {
      result.points.resize(std::max<std::size_t>(result.points.size(), block + 1));
      result.points[block].resize(static_cast<std::size_t>(3) * counts[0] * counts[1] * counts[2]);
      return result.points[block].data();
    },
    run);
  return result;
}

std::string contents(const std::string& path)
{
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

void put(const std::string& path, const std::string& text)
{
  std::ofstream(path, std::ios::binary) << text;
}

std::string errorOf(const std::string& path)
{
  try
  {
    readCase(path);
  }
  catch (const Error& error)
  {
    return error.what();
  }
  return "";
}

void expectSame(const QuadflowCase& a, const QuadflowCase& b)
{
  ASSERT_EQ(a.blocks.size(), b.blocks.size());
  for (std::size_t i = 0; i < a.blocks.size(); ++i)
  {
    const BSplineVolume& va = a.blocks[i].volume;
    const BSplineVolume& vb = b.blocks[i].volume;
    EXPECT_EQ(a.blocks[i].name, b.blocks[i].name);
    EXPECT_EQ(va.degree, vb.degree);
    ASSERT_EQ(va.knots, vb.knots);
    EXPECT_EQ(std::memcmp(va.points, vb.points, 3 * sizeof(double) * va.count(0) * va.count(1) * va.count(2)), 0);
  }
  ASSERT_EQ(a.interfaces.size(), b.interfaces.size());
  for (std::size_t i = 0; i < a.interfaces.size(); ++i)
  {
    const Interface& ia = a.interfaces[i].contact;
    const Interface& ib = b.interfaces[i].contact;
    EXPECT_EQ(std::tie(ia.blockA, ia.faceA, ia.blockB, ia.faceB, ia.orientation),
      std::tie(ib.blockA, ib.faceA, ib.blockB, ib.faceB, ib.orientation));
    EXPECT_EQ(ia.rangeA, ib.rangeA);
  }
  ASSERT_EQ(a.boundaryFaces.size(), b.boundaryFaces.size());
  for (std::size_t i = 0; i < a.boundaryFaces.size(); ++i)
  {
    EXPECT_EQ(std::tie(a.boundaryFaces[i].block, a.boundaryFaces[i].face, a.boundaryFaces[i].boundary),
      std::tie(b.boundaryFaces[i].block, b.boundaryFaces[i].face, b.boundaryFaces[i].boundary));
  }
  ASSERT_EQ(a.boundaryNames.size(), b.boundaryNames.size());
  for (std::size_t i = 0; i < a.boundaryNames.size(); ++i)
  {
    EXPECT_EQ(std::tie(a.boundaryNames[i].id, a.boundaryNames[i].name),
      std::tie(b.boundaryNames[i].id, b.boundaryNames[i].name));
  }
}

/// `n` blocks of one cell around a common edge, which runs along w.
Volumes fan(int n)
{
  Volumes volumes;
  const auto between = [](const Vec3& a, const Vec3& b, int t) { return Vec3(a + (b - a) * (t / 3.0)); };
  const Vec3 center(0.1, 0.2, 0.0);
  const auto rim = [&](int i) {
    const double angle = 2.0 * M_PI * (i % n) / n;
    return Vec3(std::cos(angle), std::sin(angle), 0.0);
  };
  for (int i = 0; i < n; ++i)
  {
    Block block;
    for (auto& knots : block.volume.knots)
    {
      knots = clampedIntegerKnots(1);
    }
    const Vec3 far = 1.5 * (rim(i) + rim(i + 1));
    forEach(block.counts(), [&](const Ijk& at) {
      Vec3 x = at[1] == 0 ? between(center, rim(i), at[0])
        : at[0] == 0      ? between(center, rim(i + 1), at[1])
                          : between(between(center, rim(i), at[0]), between(rim(i + 1), far, at[0]), at[1]);
      x[2] = at[2];
      block.points.insert(block.points.end(), x.data(), x.data() + 3);
    });
    volumes.blocks.push_back(block);
    volumes.interfaces.push_back({ i, 0, (i + 1) % n, 2, 0, { { 0, 0 }, { 3, 3 } }, { 0, 0 } });
  }
  return volumes;
}

std::vector<Volumes> cases(std::mt19937& random)
{
  std::vector<Volumes> result;
  result.push_back(cutLattice(random, { { { 2 }, { 1 }, { 3 } } }));
  result.push_back(cutLattice(random, { { { 1, 2 }, { 3, 1, 2 }, { 2, 1 } } }));
  result.push_back(cutLattice(random, { { { 2 }, { 1 }, { 1, 2 } } }, { true, false, false })); // meets itself
  result.push_back(cutLattice(random, { { { 2, 1 }, { 2 }, { 1 } } }, { true, false, false })); // meet twice
  result.push_back(cutLattice(random, { { { 3 }, { 2 }, { 1 } } }, { true, true, true }));
  result.push_back(fan(3));
  result.push_back(fan(5));
  result.push_back(Volumes());
  return result;
}

} // namespace

TEST(SharedEntities, EqualTheDistinctPointsOfTheLattice)
{
  std::mt19937 random(1);
  using Bits = std::array<double, 3>;
  for (int trial = 0; trial < 20; ++trial)
  {
    const Volumes volumes =
      cutLattice(random, { { { 1, 2 }, { 2, 1, 1 }, { 3, 1 } } }, { trial % 4 == 1, trial % 4 == 2, trial % 4 == 3 });
    const SharedEntities all = sharedEntities(static_cast<int>(volumes.blocks.size()), volumes.interfaces);
    // A random control point in the middle tells entities apart.
    std::map<Bits, std::set<int>> vertices, edges, faces;
    std::map<int, std::set<Bits>> starts;
    std::map<int, int> uses;
    for (std::size_t b = 0; b < volumes.blocks.size(); ++b)
    {
      const Block& block = volumes.blocks[b];
      const Ijk n = block.counts();
      const auto bits = [&](const Ijk& i) {
        const double* x = block.points.data() + 3 * block.at(i);
        return Bits{ x[0], x[1], x[2] };
      };
      const auto corner = [&](int c) {
        return Ijk{ cornerSide(c, 0) * (n[0] - 1), cornerSide(c, 1) * (n[1] - 1), cornerSide(c, 2) * (n[2] - 1) };
      };
      for (int c = 0; c < 8; ++c)
      {
        vertices[bits(corner(c))].insert(all.blocks[b].vertices[c]);
      }
      for (int e = 0; e < 12; ++e)
      {
        const int id = all.blocks[b].edges[e];
        Ijk second = corner(edgeCorner(e, 0));
        second[edgeDirection(e)] = 1;
        Ijk last = corner(edgeCorner(e, 1));
        last[edgeDirection(e)] -= 1;
        edges[std::min(bits(second), bits(last))].insert(id);
        starts[id].insert(bits(all.blocks[b].edgeReversed[e] ? last : second));
        ++uses[id];
      }
      for (int f = 0; f < 6; ++f)
      {
        std::array<Bits, 4> corners;
        for (int c = 0; c < 4; ++c)
        {
          Ijk i = facePosition(n, f, (c & 1) ? n[faceAxis(f, 0)] - 2 : 1, (c >> 1) ? n[faceAxis(f, 1)] - 2 : 1);
          corners[c] = bits(i);
        }
        faces[*std::min_element(corners.begin(), corners.end())].insert(all.blocks[b].faces[f]);
      }
    }
    EXPECT_EQ(static_cast<int>(vertices.size()), all.vertices);
    EXPECT_EQ(edges.size(), all.edges.size());
    EXPECT_EQ(faces.size(), all.faces.size());
    for (const auto* ids : { &vertices, &edges, &faces })
    {
      for (const auto& entry : *ids)
      {
        EXPECT_EQ(entry.second.size(), 1u);
      }
    }
    for (std::size_t e = 0; e < all.edges.size(); ++e)
    {
      EXPECT_EQ(uses[static_cast<int>(e)], all.edges[e].uses);
      EXPECT_EQ(starts[static_cast<int>(e)].size(), 1u) << "uses run in different directions";
    }
  }
}

TEST(SharedEntities, RefusesContactsThatCannotBe)
{
  EXPECT_THROW(sharedEntities(2, { { 0, 1, 1, 0, 0, {}, {} }, { 0, 1, 1, 2, 0, {}, {} } }), Error);
  EXPECT_THROW(sharedEntities(1, { { 0, 1, 0, 1, 2, {}, {} } }), Error);
  // Two neighbouring faces folded together so that their common edge meets itself reversed.
  EXPECT_THROW(sharedEntities(1, { { 0, 0, 0, 2, 4, {}, {} } }), Error);
}

TEST(Quadflow, RoundTripIsBitForBit)
{
  TemporaryFolder folder;
  std::mt19937 random(2);
  for (const Volumes& volumes : cases(random))
  {
    QuadflowInput input = inputOf(volumes);
    if (!input.names.empty())
    {
      input.names[0] = "a name # with 100% odd\tsigns \xc3\xa4";
      input.boundaryNames = { "wall", "", "-", "far field" };
      input.boundaryIds = { { "far field", 1 }, { "wall", 7 }, { "unknown", 3 } };
      const SharedEntities all = sharedEntities(static_cast<int>(volumes.blocks.size()), volumes.interfaces);
      int tag = 0;
      for (const auto& face : all.faces)
      {
        if (face.uses == 1 && tag % 5 != 4)
        {
          input.boundaries.push_back({ face.block, face.face, {}, tag % 4 });
        }
        ++tag;
      }
      std::shuffle(input.boundaries.begin(), input.boundaries.end(), random);
    }
    const QuadflowCase written = makeQuadflowCase(input);
    for (int variant = 0; variant < 16; ++variant)
    {
      QuadflowOptions options;
      options.binary = (variant & 8) != 0;
      options.indexBase = variant & 1;
      options.unitKnots = (variant & 2) != 0;
      options.separateGeometry = (variant & 4) != 0;
      const std::string path = folder / ("case" + std::to_string(variant) + ".qfmb");
      writeQuadflow(written, path, options);
      const ReadCase read = readCase(path);
      expectSame(written, read.data);

      // And the file again.
      const std::string text = contents(path);
      const std::string geometry = contents(folder / ("case" + std::to_string(variant) + ".bsp"));
      writeQuadflow(read.data, path, options);
      EXPECT_EQ(contents(path), text);
      EXPECT_EQ(contents(folder / ("case" + std::to_string(variant) + ".bsp")), geometry);
    }
    if (!input.names.empty())
    {
      EXPECT_EQ(written.boundaryNames[0].id, 7);
      EXPECT_EQ(written.boundaryNames[1].id, 2);
      EXPECT_EQ(written.boundaryNames[2].id, 4);
      EXPECT_EQ(written.boundaryNames[3].id, 1);
    }
  }
  EXPECT_EQ(folder.files(), 24u); // 16 topologies, 8 geometries, nothing temporary
}

TEST(Quadflow, RoundTripOfHardNumbersAndGeneralKnots)
{
  TemporaryFolder folder;
  std::mt19937 random(3);
  Volumes volumes;
  const std::vector<double> linear{ 0.1, 0.1, 0.3, 7.7, 7.7 };
  const std::vector<double> quadratic{ -1, -1, -1, 0, 0, 1e-3, 1, 1, 1 };
  const std::vector<double> quintic{ 0, 0, 0, 0, 0, 0, 1.0 / 3.0, 0.7, 0.7, 0.7, 4, 4, 4, 4, 4, 4 };
  volumes.blocks.push_back(randomBlock(random, { 1, 2, 5 }, { linear, quadratic, quintic }));
  const double hard[] = { -0.0, std::numeric_limits<double>::denorm_min(), std::numeric_limits<double>::max(),
    -std::numeric_limits<double>::min(), 0.1, 1.0 / 3.0, 1e22, 1e23, 123456789012345678.0, 5e-324 };
  std::copy(std::begin(hard), std::end(hard), volumes.blocks[0].points.begin());
  const QuadflowCase written = makeQuadflowCase(inputOf(volumes));
  QuadflowOptions options;
  for (const bool binary : { false, true })
  {
    options.binary = binary;
    writeQuadflow(written, folder / "a.qfmb", options);
    expectSame(written, readCase(folder / "a.qfmb").data);
  }
}

TEST(Quadflow, UnitKnotsComeBackAsIntegers)
{
  TemporaryFolder folder;
  std::mt19937 random(4);
  QuadflowOptions unit;
  unit.unitKnots = true;
  for (const int cells : { 1, 3, 49, 1000, 12345 })
  {
    Volumes volumes;
    const std::vector<double> linear{ 0, 0, 1, 1 };
    volumes.blocks.push_back(randomBlock(random, { 3, 1, 1 }, { clampedIntegerKnots(cells), linear, linear }));
    const QuadflowCase written = makeQuadflowCase(inputOf(volumes));
    writeQuadflow(written, folder / "a.qfmb", unit);
    EXPECT_EQ(readCase(folder / "a.qfmb").data.blocks[0].volume.knots[0], clampedIntegerKnots(cells));
  }
}

TEST(Quadflow, FindsTheInterfaces)
{
  std::mt19937 random(5);
  for (const Volumes& volumes : cases(random))
  {
    QuadflowInput input = inputOf(volumes);
    const auto normalized = [](const QuadflowCase& all) {
      std::set<std::array<int, 5>> result;
      for (const QuadflowInterface& entry : all.interfaces)
      {
        const Interface& c = entry.contact;
        const bool forward = std::make_pair(c.blockA, c.faceA) < std::make_pair(c.blockB, c.faceB);
        result.insert(forward
            ? std::array<int, 5>{ c.blockA, c.faceA, c.blockB, c.faceB, c.orientation }
            : std::array<int, 5>{ c.blockB, c.faceB, c.blockA, c.faceA, inverseOrientation(c.orientation) });
      }
      return result;
    };
    const auto given = normalized(makeQuadflowCase(input));
    input.hasInterfaces = false;
    input.interfaces.clear();
    EXPECT_EQ(normalized(makeQuadflowCase(input)), given);
  }
}

TEST(Quadflow, RefusesAmbiguousContacts)
{
  Volumes volumes = fan(3);
  volumes.blocks.push_back(volumes.blocks[0]); // three faces at one place
  QuadflowInput input = inputOf(volumes);
  input.hasInterfaces = false;
  EXPECT_THROW(makeQuadflowCase(input), Error);
}

TEST(Quadflow, ClassesOfEdges)
{
  for (const int n : { 3, 4, 5, 8 })
  {
    const Volumes volumes = fan(n);
    QuadflowInput input = inputOf(volumes);
    const QuadflowEdge& axis = [&]() {
      const QuadflowCase all = makeQuadflowCase(input);
      int interior = 0;
      for (const QuadflowEdge& edge : all.edges)
      {
        interior += edge.kind != QuadflowEdgeClass::Boundary;
      }
      EXPECT_EQ(interior, 1);
      return all.edges[all.blocks[0].edges[8]];
    }();
    EXPECT_EQ(axis.kind, n == 4 ? QuadflowEdgeClass::Regular : QuadflowEdgeClass::Extraordinary);
    EXPECT_EQ(axis.valence, n == 4 ? 0 : n);

    // Rules of the inner control points decide; edge 3 of block 0 runs along i at j = J, k = K.
    std::vector<unsigned char> rules(64, static_cast<unsigned char>(ControlPointRule::Body));
    input.rules.assign(n, nullptr);
    input.rules[0] = rules.data();
    const auto classOf = [&](ControlPointRule a, ControlPointRule b) {
      rules[1 + 4 * (3 + 4 * 3)] = static_cast<unsigned char>(a);
      rules[2 + 4 * (3 + 4 * 3)] = static_cast<unsigned char>(b);
      const QuadflowCase all = makeQuadflowCase(input);
      return all.edges[all.blocks[0].edges[3]].kind;
    };
    EXPECT_EQ(classOf(ControlPointRule::Body, ControlPointRule::Body), QuadflowEdgeClass::Boundary);
    EXPECT_EQ(classOf(ControlPointRule::Crease, ControlPointRule::Corner), QuadflowEdgeClass::Crease);
    EXPECT_EQ(classOf(ControlPointRule::PlanarSide, ControlPointRule::Corner), QuadflowEdgeClass::Planar);
    EXPECT_EQ(classOf(ControlPointRule::PlanarSide, ControlPointRule::Body), QuadflowEdgeClass::Boundary);
  }
}

TEST(Quadflow, RefusesVolumesThatAreNotConforming)
{
  std::mt19937 random(6);
  const Volumes good = cutLattice(random, { { { 1, 2 }, { 2 }, { 1 } } });
  const auto message = [](const QuadflowInput& input) {
    try
    {
      makeQuadflowCase(input);
    }
    catch (const Error& error)
    {
      return std::string(error.what());
    }
    return std::string();
  };
  const auto contains = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_EQ(message(inputOf(good)), "");

  Volumes moved = good;
  const Interface contact = good.interfaces[0];
  Block& block = moved.blocks[contact.blockA];
  const Ijk inner = facePosition(block.counts(), contact.faceA, 1, 1);
  double& x = block.points[3 * block.at(inner)];
  x = std::nextafter(x, 1e300);
  EXPECT_TRUE(contains(message(inputOf(moved)), "control points")) << message(inputOf(moved));
  x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(contains(message(inputOf(moved)), "not finite"));

  Volumes turned = good;
  turned.interfaces[0].orientation ^= 2;
  EXPECT_TRUE(contains(message(inputOf(turned)), "differ")) << message(inputOf(turned));

  QuadflowInput tagged = inputOf(good);
  tagged.boundaryNames = { "wall" };
  tagged.boundaries = { { contact.blockA, contact.faceA, {}, 0 } };
  EXPECT_TRUE(contains(message(tagged), "already in another interface or boundary")) << message(tagged);

  QuadflowInput ids = inputOf(good);
  ids.boundaryIds = { { "a", 1 }, { "b", 1 } };
  EXPECT_TRUE(contains(message(ids), "given twice"));
  ids.boundaryIds = { { "a", 0 } };
  EXPECT_TRUE(contains(message(ids), "not positive"));

  Volumes open = good;
  for (Block& b : open.blocks)
  {
    b.volume.knots[0].front() = -1.0;
  }
  EXPECT_TRUE(contains(message(inputOf(open)), "not clamped")) << message(inputOf(open));
}

TEST(Quadflow, MalformedFilesAreRefusedByLine)
{
  TemporaryFolder folder;
  QuadflowInput input = inputOf(fan(3));
  const Volumes volumes = fan(3);
  for (std::size_t b = 0; b < 3; ++b)
  {
    input.volumes[b] = volumes.blocks[b].view();
    input.names[b] = "b" + std::to_string(b);
  }
  input.boundaryNames = { "wall" };
  input.boundaries = { { 0, 4, {}, 0 } };
  const std::string path = folder / "a.qfmb";
  writeQuadflow(makeQuadflowCase(input), path);
  std::vector<std::string> good;
  {
    std::istringstream text(contents(path));
    for (std::string line; std::getline(text, line);)
    {
      good.push_back(line);
    }
  }
  ASSERT_EQ(errorOf(path), "");

  // First line that begins so, after another one; counted from 0.
  const auto find = [&](const std::string& start, const std::string& after = "") {
    std::size_t i = 0;
    while (!after.empty() && good[i].rfind(after, 0) != 0)
    {
      ++i;
    }
    while (good[i].rfind(start, 0) != 0)
    {
      ++i;
    }
    return i;
  };
  const std::size_t vertex = find("VERTICES") + 1;
  const std::size_t edge = find("EDGES") + 1;
  const std::size_t face = find("FACES") + 1;
  const std::size_t block = find("BLOCKS") + 1;
  const std::size_t contact = find("CONNECTIVITY") + 1;
  const std::size_t boundary = find("BOUNDARY") + 1;
  const std::size_t geometry = find("GEOMETRY");
  const std::size_t points = find(" points", "GEOMETRY");

  struct Mistake
  {
    const char* what;
    std::size_t line;
    std::string from, to; ///< an empty `from` replaces the line
    std::string message;
    long reportedAt = -1; ///< another line, counted from 0
  };
  const std::vector<Mistake> mistakes{
    { "magic", 1, "QFMB", "QFMX", "'QFMB' expected" },
    { "version", 1, "1.0", "2.0", "'1.0' expected" },
    { "dimension", 2, "3", "2", "'3' expected" },
    { "index base", 3, "0", "2", "index base 2 is not in 0..1" },
    { "other index base", 3, "0", "1", "id 0 is not in 1..1", long(vertex) },
    { "knots", 4, "integer", "real", "'integer' or 'unit' expected" },
    { "order", 5, "ijk", "kji", "'ijk' expected" },
    { "negative count", 6, "vertices 14", "vertices -1", "vertices -1 is not in" },
    { "huge count", 6, "vertices 14", "vertices 2000000000", "bytes that follow" },
    { "too large a count", 6, "vertices 14", "vertices 99999999999", "integer expected" },
    { "one vertex more", 6, "vertices 14", "vertices 15", "integer expected, 'EDGES' found", long(edge) - 1 },
    { "one edge less", 6, "edges 25", "edges 24", "'FACES' expected", long(face) - 2 },
    { "text", vertex, "0 ", "zero ", "integer expected, 'zero' found" },
    { "infinite vertex", vertex, "", "0 0.1 0.2 inf", "finite number expected" },
    { "missing coordinate", vertex, "", "0 0.1 0.2", "finite number expected" },
    { "extra coordinate", vertex, "", "0 0.1 0.2 0 7", "nothing more expected" },
    { "moved vertex", vertex, "", "0 0.1 0.2 1e-9", "is not the control point at corner 0 of block 0" },
    { "edge class", edge, "boundary", "sharp", "is no class of an edge" },
    { "edge without valence", edge, "boundary", "extraordinary", "is no class of an edge" },
    { "wrong class", edge, "boundary", "regular", "its class is wrong" },
    { "wrong valence", find("8 ", "EDGES"), "extraordinary:3", "extraordinary:5", "3 blocks meet there inside" },
    { "edge of other vertices", edge, "0 0 1", "0 0 2", "edge 0: its corners are not the vertices", long(block) },
    { "edge of other cells", edge, "1 boundary", "2 boundary", "edge 0 has 2", long(block) },
    { "vertex out of range", edge, "0 0 1", "0 0 99", "vertex 99 is not in 0..13" },
    { "face boundary", find("4 ", "FACES"), " 1 1 1 1", " 1 1 1 0", "is not that of the list" },
    { "face blocks", find("4 ", "FACES"), " 1 1 1 1", " 1 1 2 1", "wrong number of blocks" },
    { "face of other vertices", face, "0 0 2", "0 1 2", "are not those of face 0", long(block) },
    { "block type", block, "BSPLINE", "NURBS", "'BSPLINE' expected" },
    { "block cells", block, "cells 1 1 1", "cells 2 1 1", "2 cells but 1 knot spans", long(points) + 1 },
    { "bad escape", block, "zone b0", "zone b%0", "two hexadecimal digits" },
    { "sign", block + 2, ":+1", ":-1", "sign is wrong", long(block) },
    { "bad sign", block + 2, ":+1", ":1", "+1 or -1 expected" },
    { "no orientation", block + 3, "0:0", "0", "face:orientation expected" },
    { "orientation", block + 3, "0:0", "0:8", "orientation 8 is not in 0..7" },
    { "other orientation", block + 3, "0:0", "0:3", "in orientation 3", long(block) },
    { "interface orientation", contact, "", "0 0 1 2 2 -2 -1 3",
      "block 0, face 0 and block 1, face 2 in orientation 2: control points" },
    { "interface transform", contact, "", "0 0 1 2 0 2 -1 3", "the transform does not belong" },
    { "interface twice", contact + 1, "", good[contact], "already in another interface or boundary, line" },
    { "interface missing", contact, "", "", "block 0, face 0 is in no interface and no boundary", long(block) },
    { "unknown block", contact, "0 0 1", "0 0 7", "block 7 is not in 0..2" },
    { "unknown face", boundary, "0 4", "0 6", "face 6 is not in 0..5" },
    { "boundary on an interface", boundary, "0 4", "0 0", "block 0, face 0 is already" },
    { "unknown boundary", boundary, "0 4 1", "0 4 5", "there is no boundary 5" },
    { "degree", geometry + 2, "3 3 3", "3 9 3", "degree 9 is not in 1..8" },
    { "too many control points", geometry + 3, "4 4 4", "4 2000000000 2000000000", "bytes that follow" },
    { "too few control points", geometry + 3, "4 4 4", "4 3 4", "control points 3 is not in 4" },
    { "knot count", geometry + 4, " 1 1 1 1", " 1 1 1", "7 knots instead of 8" },
    { "decreasing knots", geometry + 4, " 1 1 1 1", " 1 1 1 0", "smaller than the one before it", long(points) + 1 },
    { "unclamped knots", geometry + 4, " 0 0 0 0", " -1 0 0 0", "are not clamped", long(points) + 1 },
    { "overflow", points + 1, "", "1e999 0 0", "finite number expected" },
    { "moved control point", points + 1 + 4, "", "7 7 7", "control points (0, 1, 0) and (1, 0, 0) differ",
      long(contact) },
    { "early end", points + 1, "", "end", "finite number expected, 'end' found" },
    { "text after the points", good.size() - 1, "", "0 0 0", "'end' expected" },
    { "outside geometry", geometry, "", "GEOMETRY file ../a.bsp", "same folder" },
    { "missing geometry", geometry, "", "GEOMETRY file b.bsp", "Cannot open" },
    { "binary", vertex, "", std::string("\0\x01\xff", 3),
      "integer expected, '??"
      "?' found" },
  };
  for (const Mistake& mistake : mistakes)
  {
    std::vector<std::string> lines = good;
    std::string& line = lines[mistake.line];
    if (mistake.from.empty())
    {
      line = mistake.to;
    }
    else
    {
      const std::size_t at = line.find(mistake.from);
      ASSERT_NE(at, std::string::npos) << mistake.what << ": " << line;
      line.replace(at, mistake.from.size(), mistake.to);
    }
    std::string text;
    for (const std::string& l : lines)
    {
      text += l + "\n";
    }
    put(path, text);
    const std::string error = errorOf(path);
    EXPECT_NE(error.find(mistake.message), std::string::npos) << mistake.what << ": " << error;
    const std::size_t at = mistake.reportedAt < 0 ? mistake.line : static_cast<std::size_t>(mistake.reportedAt);
    if (mistake.message != "Cannot open")
    {
      EXPECT_NE(error.find("a.qfmb, line " + std::to_string(at + 1) + ":"), std::string::npos)
        << mistake.what << ": " << error;
    }
  }
  EXPECT_NE(errorOf(folder / "none.qfmb").find("Cannot open"), std::string::npos);
  EXPECT_NE(errorOf(folder.path()).find("not a regular file"), std::string::npos);
  put(path, "");
  EXPECT_NE(errorOf(path).find("the file is empty"), std::string::npos);
}

// Whatever is cut off or changed, the result is an error or a case that passes its checks; never a crash.
TEST(Quadflow, DamagedFilesAreErrorsOrValid)
{
  TemporaryFolder folder;
  std::mt19937 random(7);
  const Volumes volumes = fan(3);
  const std::string path = folder / "a.qfmb";
  for (const bool binary : { false, true })
  {
    QuadflowOptions options;
    options.binary = binary;
    writeQuadflow(makeQuadflowCase(inputOf(volumes)), path, options);
    const std::string text = contents(path);
    for (std::size_t length = 0; length + 1 < text.size(); length += 1 + length / 200)
    {
      put(path, text.substr(0, length));
      EXPECT_NE(errorOf(path), "") << length;
    }
    put(path, text.substr(0, text.size() - 1)); // only the last line end is missing
    EXPECT_EQ(errorOf(path), "");
    for (int trial = 0; trial < 600; ++trial)
    {
      std::string damaged = text;
      for (int i = 0; i <= trial % 3; ++i)
      {
        // Mostly in the topology, which is the smaller part of the text.
        const std::size_t range = trial % 4 == 0 ? text.size() : text.find("GEOMETRY") + 60;
        damaged[std::uniform_int_distribution<std::size_t>(0, range - 1)(random)] =
          "0123456789 -+.:#%e\n\tA\0\xff"[std::uniform_int_distribution<int>(0, 22)(random)];
      }
      put(path, damaged);
      try
      {
        const ReadCase read = readCase(path);
        checkQuadflowCase(read.data);
      }
      catch (const Error&)
      {
      }
    }
  }
}

/// The bytes of a binary file up to and including those of the first block's control points, and those behind.
struct BinaryParts
{
  std::string before; ///< up to the number that precedes the control points
  std::string raw;
  std::string behind;
};

BinaryParts binaryParts(const std::string& file, std::size_t controlPoints)
{
  const std::string line = "\n points\n";
  const std::size_t raw = file.find(line) + line.size();
  const std::size_t size = 8 + 24 * controlPoints;
  return { file.substr(0, raw), file.substr(raw, size), file.substr(raw + size) };
}

TEST(Quadflow, ReadsBinaryNumbersOfTheOtherByteOrder)
{
  TemporaryFolder folder;
  std::mt19937 random(10);
  Volumes volumes;
  const std::vector<double> knots = clampedIntegerKnots(3);
  volumes.blocks.push_back(randomBlock(random, { 3, 3, 3 }, { knots, knots, knots }));
  const QuadflowCase written = makeQuadflowCase(inputOf(volumes));
  QuadflowOptions options;
  options.binary = true;
  const std::string path = folder / "a.qfmb";
  writeQuadflow(written, path, options);
  BinaryParts parts = binaryParts(contents(path), 6 * 6 * 6);
  for (std::size_t i = 0; i < parts.raw.size(); i += 8)
  {
    std::reverse(parts.raw.begin() + i, parts.raw.begin() + i + 8);
  }
  const bool little = parts.before.find("little_endian") != std::string::npos;
  const std::string own = little ? "little" : "big", other = little ? "big" : "little";
  parts.before.replace(parts.before.find(own), own.size(), other);
  put(path, parts.before + parts.raw + parts.behind);
  expectSame(written, readCase(path).data);
}

TEST(Quadflow, MalformedBinaryFilesAreRefusedByLine)
{
  TemporaryFolder folder;
  std::mt19937 random(11);
  Volumes volumes;
  const std::vector<double> knots = clampedIntegerKnots(3);
  volumes.blocks.push_back(randomBlock(random, { 3, 3, 3 }, { knots, knots, knots }));
  const std::string path = folder / "a.qfmb";
  QuadflowOptions options;
  options.binary = true;
  writeQuadflow(makeQuadflowCase(inputOf(volumes)), path, options);
  const BinaryParts good = binaryParts(contents(path), 6 * 6 * 6);
  const auto linesOf = [](const std::string& text) { return std::count(text.begin(), text.end(), '\n'); };

  const auto expectError = [&](const std::string& file, long line, const std::string& message) {
    put(path, file);
    const std::string error = errorOf(path);
    EXPECT_NE(error.find("a.qfmb, line " + std::to_string(line) + ": "), std::string::npos) << error;
    EXPECT_NE(error.find(message), std::string::npos) << error;
  };
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string text = good.before;
    return text.replace(text.find(from), from.size(), to) + good.raw + good.behind;
  };
  const long points = linesOf(good.before);
  const long geometry = linesOf(good.before.substr(0, good.before.find("GEOMETRY"))) + 1;
  const std::string order = good.before.find("little_endian") != std::string::npos ? "little_endian" : "big_endian";
  const std::string otherOrder = order == "little_endian" ? "big_endian" : "little_endian";

  expectError(replaced("binary", "packed"), geometry, "'binary', 'file' or nothing expected, 'packed' found");
  expectError(replaced(order, "middle_endian"), geometry, "'little_endian' or 'big_endian' expected");
  expectError(replaced(" " + order, ""), geometry, "'little_endian' or 'big_endian' expected");
  expectError(replaced(order, order + " 64"), geometry, "nothing more expected, '64' found");
  expectError(replaced(order, otherOrder), points, "block 0: the binary numbers do not begin with 1");
  // The same words, but text behind them, and the other way round.
  expectError(replaced(" binary " + order, ""), points + 1, "finite number expected");
  expectError(good.before + "1 2 3\n" + good.behind, geometry + 3, "bytes that follow in the file");
  // A number of control points that does not fit is refused before memory is asked for.
  expectError(replaced("ncp 6 6 6", "ncp 600 600 600"), geometry + 3, "bytes that follow in the file");
  expectError(good.before + good.raw.substr(0, 40), geometry + 3, "bytes that follow in the file");
  expectError(good.before + good.raw.substr(0, good.raw.size() - 1), points, "the file ends within");
  expectError(good.before + good.raw, points, "the file ends, but end should follow");
  // One byte too many, or too few.
  expectError(good.before + good.raw + "?" + good.behind, points + 1, "'end' expected, '?' found");
  // Then the line end is part of the last number, which is that of vertex 7.
  const long vertices = linesOf(good.before.substr(0, good.before.find("VERTICES"))) + 2;
  expectError(good.before + good.raw.substr(0, good.raw.size() - 1) + good.behind, vertices + 7,
    "is not the control point at corner 7 of block 0");

  for (const double value : { std::nan(""), HUGE_VAL, -HUGE_VAL })
  {
    std::string raw = good.raw;
    std::memcpy(&raw[8 + 24 * 100 + 8], &value, sizeof value);
    expectError(good.before + raw + good.behind, points, "block 0: coordinate 1 of control point 100 is not finite");
  }
  // A corner that is not its vertex.
  std::string raw = good.raw;
  const double value = 0.25;
  std::memcpy(&raw[8], &value, sizeof value);
  expectError(good.before + raw + good.behind, vertices, "is not the control point at corner 0 of block 0");
}

TEST(Quadflow, ReadsBlanksCommentsAndForeignLineEnds)
{
  TemporaryFolder folder;
  const Volumes volumes = fan(4);
  const QuadflowCase written = makeQuadflowCase(inputOf(volumes));
  const std::string path = folder / "a.qfmb";
  writeQuadflow(written, path);
  std::string text;
  for (const char c : contents(path))
  {
    text += c == '\n' ? std::string("\t # comment\r\n\n  # another\r\n")
      : c == ' '      ? std::string(" \t ")
                      : std::string(1, c);
  }
  for (const char* mark : { "", "\xef\xbb\xbf" })
  {
    put(path, mark + text);
    EXPECT_TRUE(looksLikeQuadflow(path));
    expectSame(written, readCase(path).data);
  }
  put(path, "");
  EXPECT_NE(errorOf(path).find("a.qfmb: the file is empty"), std::string::npos);
  put(path, std::string("\xff\xfe") + "Q");
  EXPECT_NE(errorOf(path).find("UTF-16"), std::string::npos);
}

TEST(Quadflow, FailuresLeaveTheOldFile)
{
  TemporaryFolder folder;
  std::mt19937 random(8);
  Volumes volumes;
  const std::vector<double> knots = clampedIntegerKnots(40);
  volumes.blocks.push_back(randomBlock(random, { 3, 3, 3 }, { knots, knots, knots }));
  const QuadflowCase all = makeQuadflowCase(inputOf(volumes));
  const std::string path = folder / "a.qfmb";
  put(path, "old");
  for (int variant = 0; variant < 4; ++variant)
  {
    const bool separate = variant >= 2;
    QuadflowOptions options;
    options.binary = variant % 2 != 0;
    options.separateGeometry = separate;
    if (separate)
    {
      put(folder / "a.bsp", "old geometry");
    }
    const std::size_t files = separate ? 2 : 1;
    const auto untouched = [&]() {
      EXPECT_EQ(folder.files(), files);
      EXPECT_EQ(contents(path), "old");
      EXPECT_TRUE(!separate || contents(folder / "a.bsp") == "old geometry");
    };

    // No room: a limit on the size of files stands for a full disk.
    rlimit limit;
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &limit), 0);
    const rlimit small{ 300000, limit.rlim_max };
    std::signal(SIGXFSZ, SIG_IGN);
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    EXPECT_THROW(writeQuadflow(all, path, options), Error);
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
    std::signal(SIGXFSZ, SIG_DFL);
    untouched();

    // Abort, early and at the very end.
    for (const double when : { 0.0, 0.5, 1.0 })
    {
      Execution run;
      run.progress = [when](double fraction) { return fraction < when; };
      EXPECT_THROW(writeQuadflow(all, path, options, run), Aborted);
      untouched();
    }
  }

  EXPECT_THROW(writeQuadflow(all, folder / "no/such/folder.qfmb"), Error);
  EXPECT_THROW(writeQuadflow(all, folder.path()), Error);
  EXPECT_THROW(writeQuadflow(all, "/dev/full"), Error);
  QuadflowOptions wrong;
  wrong.indexBase = 2;
  EXPECT_THROW(writeQuadflow(all, path, wrong), Error);
  wrong.indexBase = 0;
  wrong.separateGeometry = true;
  EXPECT_THROW(writeQuadflow(all, folder / "a.bsp", wrong), Error);
  EXPECT_EQ(contents(path), "old");

  // Reading can be aborted too.
  writeQuadflow(all, path);
  Execution run;
  run.progress = [](double fraction) { return fraction < 0.5; };
  EXPECT_THROW(readCase(path, run), Aborted);
}

namespace
{

/// What one rank has of an input.
QuadflowInput partOf(const QuadflowInput& input, const std::vector<int>& owners, int rank)
{
  QuadflowInput part = input;
  part.volumes = bsvtest::partOf(input.volumes, owners, rank);
  for (std::size_t b = 0; b < part.rules.size(); ++b)
  {
    part.rules[b] = owners[b] == rank ? part.rules[b] : nullptr;
  }
  return part;
}

} // namespace

TEST(Quadflow, SameFileFromAnyRanks)
{
  std::mt19937 random(21);
  std::vector<QuadflowInput> inputs;
  const Volumes lattice = cutLattice(random, { { { 1, 2 }, { 3, 1, 2 }, { 2, 1 } } });
  const Volumes loop = cutLattice(random, { { { 2, 1 }, { 2 }, { 1 } } }, { true, false, false }); // meet twice
  const Volumes star = fan(5);
  for (const Volumes* volumes : { &lattice, &loop, &star })
  {
    inputs.push_back(inputOf(*volumes));
    inputs.push_back(inputs.back());
    inputs.back().hasInterfaces = false;
    inputs.back().interfaces.clear();
  }
  // Creases and planar sides.
  std::vector<std::vector<unsigned char>> rules;
  for (const Block& block : lattice.blocks)
  {
    const Ijk n = block.counts();
    rules.emplace_back(std::size_t(n[0]) * n[1] * n[2]);
    for (unsigned char& rule : rules.back())
    {
      rule = static_cast<unsigned char>(std::uniform_int_distribution<int>(0, 3)(random) == 0
          ? ControlPointRule::Crease
          : ControlPointRule::PlanarSide);
    }
    inputs.front().rules.push_back(rules.back().data());
  }
  TemporaryFolder folder;
  for (const QuadflowInput& input : inputs)
  {
    for (int variant = 0; variant < 4; ++variant)
    {
      QuadflowOptions options;
      options.binary = variant % 2 != 0;
      options.separateGeometry = variant >= 2;
      options.indexBase = variant % 2;
      options.unitKnots = variant == 3;
      const std::string path = folder / "a.qfmb";
      const auto files = [&] { return contents(path) + (options.separateGeometry ? contents(folder / "a.bsp") : ""); };
      writeQuadflow(makeQuadflowCase(input), path, options);
      const std::string serial = files();
      for (int size = 1; size <= 5; ++size)
      {
        if (&input != &inputs.front() && size != 2 + variant)
        {
          continue; // every file is flushed to the disk
        }
        for (const std::vector<int>& owners : distributions(random, input.volumes.size(), size))
        {
          put(path, "old");
          const auto errors = onRanks(size, [&](const Execution& run) {
            writeQuadflow(makeQuadflowCase(partOf(input, owners, run.ranks->rank()), run), path, options, run);
          });
          EXPECT_EQ(errors, std::vector<std::string>(size));
          EXPECT_TRUE(files() == serial) << "variant " << variant << ", " << size << " ranks";
        }
      }
      EXPECT_EQ(folder.files(), options.separateGeometry ? 2u : 1u);
      fs::remove(folder / "a.bsp");
    }
  }
}

TEST(Quadflow, OnlyFacesTravel)
{
  TemporaryFolder folder;
  std::mt19937 random(23);
  for (const int cells : { 8, 16 })
  {
    const Volumes lattice = cutLattice(random, { { { cells, cells }, { cells }, { cells } } });
    const QuadflowInput input = inputOf(lattice);
    const auto errors = onRanks(2, [&](const Execution& run) {
      const QuadflowCase all = makeQuadflowCase(partOf(input, { 0, 1 }, run.ranks->rank()), run);
      writeQuadflow(all, folder / "a.qfmb", {}, run);
      EXPECT_LT(run.ranks->receivedBytes(), 24 * (cells + 3) * (cells + 3) + 4000);
    });
    EXPECT_EQ(errors, std::vector<std::string>(2));
  }
}

TEST(Quadflow, FailureOfOneRankIsThatOfAll)
{
  TemporaryFolder folder;
  std::mt19937 random(22);
  const Volumes lattice = cutLattice(random, { { { 20, 20 }, { 20, 20 }, { 20 } } });
  const QuadflowInput input = inputOf(lattice);
  const std::vector<int> owners{ 3, 1, 1, 2 };
  const std::string path = folder / "a.qfmb";
  put(path, "old");
  const auto write = [&](const QuadflowInput& what, const std::string& to, const Execution& run) {
    writeQuadflow(makeQuadflowCase(partOf(what, owners, run.ranks->rank()), run), to, {}, run);
  };
  const auto expectOneError = [&](const std::vector<std::string>& errors, const std::string& part) {
    EXPECT_NE(errors[0].find(part), std::string::npos) << errors[0];
    EXPECT_EQ(errors, std::vector<std::string>(errors.size(), errors[0]));
    EXPECT_EQ(folder.files(), 1u);
    EXPECT_EQ(contents(path), "old");
  };

  // Each rank in turn stops: while it counts, while it writes, at the very end.
  for (int bad = 0; bad < 4; ++bad)
  {
    for (const double when : { 0.0, 0.5, 1.0 })
    {
      const auto errors = onRanks(4, [&](Execution run) {
        run.progress = [&](double fraction) { return run.ranks->rank() != bad || fraction < when; };
        write(input, path, run);
      });
      // Rank 0 has no block and is asked at the end only.
      expectOneError(errors, Aborted().what());
    }
  }

  // A block that is not finite, and blocks that do not fit their neighbours, on one rank.
  std::vector<double> points = lattice.blocks[3].points;
  QuadflowInput broken = input;
  broken.volumes[3].points = points.data();
  points[5000] = std::numeric_limits<double>::infinity();
  expectOneError(onRanks(4, [&](const Execution& run) { write(broken, path, run); }), "block 3 'block 3'");
  const Block& block = lattice.blocks[3];
  points = block.points;
  const Interface* contact = nullptr;
  for (const Interface& candidate : lattice.interfaces)
  {
    contact = candidate.blockA == 3 || candidate.blockB == 3 ? &candidate : contact;
  }
  ASSERT_NE(contact, nullptr);
  const int face = contact->blockA == 3 ? contact->faceA : contact->faceB;
  points[3 * block.at(facePosition(block.counts(), face, 7, 9))] += 1.0;
  expectOneError(onRanks(4, [&](const Execution& run) { write(broken, path, run); }), "differ");

  // No room, no folder.
  rlimit limit;
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &limit), 0);
  const rlimit small{ 300000, limit.rlim_max };
  std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const auto full = onRanks(4, [&](const Execution& run) { write(input, path, run); });
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
  std::signal(SIGXFSZ, SIG_DFL);
  expectOneError(full, "Cannot write");
  expectOneError(
    onRanks(4, [&](const Execution& run) { write(input, folder / "no/such/folder.qfmb", run); }), "Cannot create");

  // Rank 2 does not see the folder: its thread has a working folder of its own.
  const fs::path before = fs::current_path();
  fs::current_path(folder.path());
  const auto blind = onRanks(4, [&](const Execution& run) {
    if (run.ranks->rank() == 2)
    {
      ASSERT_EQ(::unshare(CLONE_FS), 0);
      ASSERT_EQ(::chdir("/"), 0);
    }
    write(input, "b.qfmb", run);
  });
  fs::current_path(before);
  expectOneError(blind, "on rank 2");
}

TEST(Quadflow, KeepsLinksAndPermissions)
{
  TemporaryFolder folder;
  const Volumes volumes = fan(3);
  const QuadflowCase all = makeQuadflowCase(inputOf(volumes));
  put(folder / "real.qfmb", "old");
  ASSERT_EQ(::chmod((folder / "real.qfmb").c_str(), 0640), 0);
  fs::create_symlink("real.qfmb", folder / "link.qfmb");
  writeQuadflow(all, folder / "link.qfmb");
  EXPECT_TRUE(fs::is_symlink(folder / "link.qfmb"));
  EXPECT_EQ(errorOf(folder / "real.qfmb"), "");
  EXPECT_EQ(fs::status(folder / "real.qfmb").permissions(), fs::perms(0640));
  EXPECT_EQ(folder.files(), 2u);
}

TEST(Quadflow, Speed)
{
  TemporaryFolder folder;
  std::mt19937 random(9);
  Volumes volumes;
  const std::vector<double> knots = clampedIntegerKnots(90);
  volumes.blocks.push_back(randomBlock(random, { 3, 3, 3 }, { knots, knots, knots }));
  const QuadflowCase all = makeQuadflowCase(inputOf(volumes));
  const std::string path = folder / "a.qfmb";
  const auto seconds = [](auto&& action) {
    const auto start = std::chrono::steady_clock::now();
    action();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  const double write = seconds([&]() { writeQuadflow(all, path); });
  const double read = seconds([&]() { expectSame(all, readCase(path).data); });
  const double megabytes = static_cast<double>(fs::file_size(path)) / 1e6;
  std::cout << megabytes << " MB written at " << megabytes / write << " MB/s, read at " << megabytes / read
            << " MB/s\n";
}
