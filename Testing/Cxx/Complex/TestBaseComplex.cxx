// SPDX-License-Identifier: BSD-3-Clause
/// Blocks of unstructured hexahedra: structures known beforehand, independence of every numbering, regions that close
/// on themselves, merging, names and refusals.
#include "Complex/BaseComplex.h"
#include "Complex/BlockComplex.h"
#include "Complex/HexFrames.h"
#include "Complex/HexNumbering.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <tuple>

using namespace bsv;

namespace
{

/// Cells with the memory of their points.
struct Cells
{
  std::vector<Vec3> points;
  std::vector<std::array<HexId, 8>> corners;
  std::vector<NamedQuad> quads;
  std::vector<std::string> names;

  HexMesh mesh() const
  {
    HexMesh result;
    for (const auto& cell : this->corners)
    {
      result.corners.insert(result.corners.end(), cell.begin(), cell.end());
    }
    result.points = GridView(this->points.data()->data(), { static_cast<int>(this->points.size()), 1, 1 });
    result.quads = this->quads;
    result.boundaryNames = this->names;
    return result;
  }

  BaseComplex decompose(const BaseComplexOptions& options = {}) const
  {
    HexMesh input = this->mesh();
    return baseComplex(input, options);
  }

  /// Adds a grid of cells; points are shared with other grids where `map` gives the same bits.
  void add(const Ijk& n, const std::function<Vec3(int, int, int)>& map)
  {
    std::vector<HexId> ids;
    for (int k = 0; k <= n[2]; ++k)
    {
      for (int j = 0; j <= n[1]; ++j)
      {
        for (int i = 0; i <= n[0]; ++i)
        {
          ids.push_back(this->id(map(i, j, k)));
        }
      }
    }
    for (int k = 0; k < n[2]; ++k)
    {
      for (int j = 0; j < n[1]; ++j)
      {
        for (int i = 0; i < n[0]; ++i)
        {
          std::array<HexId, 8> cell{};
          for (int c = 0; c < 8; ++c)
          {
            cell[c] =
              ids[(i + cornerSide(c, 0)) + (n[0] + 1) * ((j + cornerSide(c, 1)) + (n[1] + 1) * (k + cornerSide(c, 2)))];
          }
          this->corners.push_back(cell);
        }
      }
    }
  }
  HexId id(const Vec3& x)
  {
    const auto found = this->known.try_emplace({ x[0], x[1], x[2] }, static_cast<HexId>(this->points.size()));
    if (found.second)
    {
      this->points.push_back(x);
    }
    return found.first->second;
  }
  /// Points added from now on are not shared with those before.
  void forget() { this->known.clear(); }

  std::map<std::array<double, 3>, HexId> known;
};

/// The same cells with other numbers and, each, another order of its corners.
Cells shuffled(const Cells& cells, unsigned int seed)
{
  std::mt19937 random(seed);
  std::vector<HexId> point(cells.points.size());
  std::iota(point.begin(), point.end(), HexId(0));
  std::shuffle(point.begin(), point.end(), random);
  Cells result;
  result.points.resize(cells.points.size());
  for (std::size_t p = 0; p < point.size(); ++p)
  {
    result.points[point[p]] = cells.points[p];
  }
  const HexFrames& frames = HexFrames::instance();
  for (const auto& cell : cells.corners)
  {
    const int frame = static_cast<int>(random() % HexFrames::Count);
    std::array<HexId, 8> corners{};
    for (int c = 0; c < 8; ++c)
    {
      corners[c] = point[cell[frames.cellCorner(frame, c)]];
    }
    result.corners.push_back(corners);
  }
  std::shuffle(result.corners.begin(), result.corners.end(), random);
  result.names = cells.names;
  for (NamedQuad quad : cells.quads)
  {
    for (HexId& p : quad.points)
    {
      p = point[p];
    }
    result.quads.push_back(quad);
  }
  std::shuffle(result.quads.begin(), result.quads.end(), random);
  return result;
}

/// All that a user sees but the numbers of points and cells.
using Seen = std::vector<double>;
Seen seen(const Cells& cells, const BaseComplex& complex)
{
  Seen result;
  for (const HexBlock& block : complex.blocks)
  {
    result.insert(result.end(), block.cells.begin(), block.cells.end());
    for (HexId p : block.pointIds)
    {
      result.insert(result.end(), cells.points[p].data(), cells.points[p].data() + 3);
    }
  }
  for (const Interface& c : complex.interfaces)
  {
    result.insert(result.end(),
      { double(c.blockA), double(c.faceA), double(c.blockB), double(c.faceB), double(c.orientation),
        double(c.rangeA.lo[0]), double(c.rangeA.hi[0]), double(c.rangeA.lo[1]), double(c.rangeA.hi[1]),
        double(c.originB[0]), double(c.originB[1]) });
  }
  for (const BoundaryPatch& b : complex.boundaries)
  {
    result.insert(result.end(),
      { double(b.block), double(b.face), double(b.tag), double(b.range.lo[0]), double(b.range.hi[0]),
        double(b.range.lo[1]), double(b.range.hi[1]) });
  }
  return result;
}

/// Every cell is in exactly one block with its own corners; contacts and boundaries cover every block face once, and
/// both sides of a contact have the same points.
void expectWhole(const Cells& cells, const BaseComplex& complex, bool mergedPoints = false)
{
  std::vector<int> uses(cells.corners.size(), 0);
  for (const HexBlock& block : complex.blocks)
  {
    ASSERT_EQ(block.cellIds.size(), std::size_t(block.cells[0]) * block.cells[1] * block.cells[2]);
    const auto at = [&](int i, int j, int k) {
      return block.pointIds[i + (block.cells[0] + 1) * (j + (block.cells[1] + 1) * k)];
    };
    std::size_t n = 0;
    for (int k = 0; k < block.cells[2]; ++k)
    {
      for (int j = 0; j < block.cells[1]; ++j)
      {
        for (int i = 0; i < block.cells[0]; ++i)
        {
          const HexId cell = block.cellIds[n++];
          ++uses[cell];
          std::set<HexId> mine(cells.corners[cell].begin(), cells.corners[cell].end());
          std::set<HexId> there;
          for (int c = 0; c < 8; ++c)
          {
            there.insert(at(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)));
          }
          EXPECT_TRUE(mergedPoints || mine == there);
        }
      }
    }
  }
  EXPECT_TRUE(std::all_of(uses.begin(), uses.end(), [](int n) { return n == 1; }));

  std::map<std::array<int, 4>, int> covered;
  const auto cover = [&](int block, int face, const FaceRange& range) {
    for (int t = range.lo[1]; t < range.hi[1]; ++t)
    {
      for (int s = range.lo[0]; s < range.hi[0]; ++s)
      {
        ++covered[{ block, face, s, t }];
      }
    }
  };
  const auto pointOn = [&](int b, int face, int s, int t) {
    const HexBlock& block = complex.blocks[b];
    const Ijk p = facePoint(block.cells, face, s, t);
    return block.pointIds[p[0] + (block.cells[0] + 1) * (p[1] + (block.cells[1] + 1) * p[2])];
  };
  for (const Interface& c : complex.interfaces)
  {
    cover(c.blockA, c.faceA, c.rangeA);
    cover(c.blockB, c.faceB, c.rangeB());
    const int ns = c.rangeA.hi[0] - c.rangeA.lo[0];
    const int nt = c.rangeA.hi[1] - c.rangeA.lo[1];
    for (int t = 0; t <= nt; ++t)
    {
      for (int s = 0; s <= ns; ++s)
      {
        const auto onB = mapFacePoint(c.orientation, s, t, ns, nt);
        EXPECT_EQ(pointOn(c.blockA, c.faceA, c.rangeA.lo[0] + s, c.rangeA.lo[1] + t),
          pointOn(c.blockB, c.faceB, c.originB[0] + onB[0], c.originB[1] + onB[1]));
      }
    }
  }
  for (const BoundaryPatch& patch : complex.boundaries)
  {
    cover(patch.block, patch.face, patch.range);
  }
  std::size_t faces = 0;
  for (const HexBlock& block : complex.blocks)
  {
    for (int face = 0; face < 6; ++face)
    {
      faces += std::size_t(block.cells[faceAxis(face, 0)]) * block.cells[faceAxis(face, 1)];
    }
  }
  EXPECT_TRUE(std::all_of(covered.begin(), covered.end(), [](const auto& entry) { return entry.second == 1; }));
  EXPECT_LE(covered.size(), faces);
  EXPECT_TRUE(covered.size() == faces || !cells.quads.empty());
}

void expectSameForAnyNumbering(const Cells& cells, const BaseComplexOptions& options = {})
{
  const Seen before = seen(cells, cells.decompose(options));
  for (unsigned int seed = 1; seed <= 3; ++seed)
  {
    const Cells other = shuffled(cells, seed);
    const BaseComplex complex = other.decompose(options);
    expectWhole(other, complex);
    EXPECT_EQ(seen(other, complex), before) << "numbering " << seed;
  }
}

/// Unit voxels of n^3 cells.
Cells voxels(const std::vector<Ijk>& places, int n, const std::function<Vec3(const Vec3&)>& map = {})
{
  Cells cells;
  for (const Ijk& place : places)
  {
    cells.add({ n, n, n }, [&](int i, int j, int k) {
      const Vec3 x(place[0] + double(i) / n, place[1] + double(j) / n, place[2] + double(k) / n);
      return map ? map(x) : x;
    });
  }
  return cells;
}

/// a x b x c voxels, with holes where all coordinates that can be are odd.
std::vector<Ijk> perforated(int a, int b, int c)
{
  std::vector<Ijk> places;
  for (int k = 0; k < c; ++k)
  {
    for (int j = 0; j < b; ++j)
    {
      for (int i = 0; i < a; ++i)
      {
        if (!(i % 2 == 1 && j % 2 == 1 && (c == 1 || k % 2 == 1)))
        {
          places.push_back({ i, j, k });
        }
      }
    }
  }
  return places;
}

/// Wedges of n^2 cells around an axis, 2 cells high.
Cells star(int sectors, int n)
{
  Cells cells;
  const auto rim = [&](int half) {
    const double angle = 3.14159265358979323846 * half / sectors;
    const double radius = half % 2 == 0 ? 1.0 : 1.3;
    return half % (2 * sectors) == 0 ? Vec3(1.0, 0.0, 0.0)
                                     : Vec3(radius * std::cos(angle), radius * std::sin(angle), 0.0);
  };
  for (int sector = 0; sector < sectors; ++sector)
  {
    const Vec3 a = rim(2 * sector), b = rim(2 * sector + 1), c = rim(2 * sector + 2);
    cells.add({ n, n, 2 }, [&](int i, int j, int k) {
      const double s = double(i) / n;
      const double t = double(j) / n;
      // On the spokes only one of the products is not zero, so that both sides give the same bits.
      Vec3 x = s * (1 - t) * a + t * (1 - s) * c + s * t * b;
      x = Vec3(std::round(x[0] * 1e9) * 1e-9 + 0.0, std::round(x[1] * 1e9) * 1e-9 + 0.0, 0.0);
      return Vec3(x[0], x[1], k);
    });
  }
  return cells;
}

/// A ring of `around` cells, whose section of n x n cells turns by `quarters` quarter turns on the way.
Cells ring(int around, int n, int quarters)
{
  Cells cells;
  std::vector<HexId> ids;
  const double pi = 3.14159265358979323846;
  for (int i = 0; i < around; ++i)
  {
    const double angle = 2.0 * pi * i / around;
    const double turn = 0.5 * pi * quarters * i / around;
    for (int k = 0; k <= n; ++k)
    {
      for (int j = 0; j <= n; ++j)
      {
        const double u = 2.0 * j / n - 1.0;
        const double v = 2.0 * k / n - 1.0;
        const double r = 5.0 + std::cos(turn) * u - std::sin(turn) * v;
        ids.push_back(cells.id({ r * std::cos(angle), r * std::sin(angle), std::sin(turn) * u + std::cos(turn) * v }));
      }
    }
  }
  const auto point = [&](int i, int j, int k) {
    for (int q = 0; i == around && q < quarters % 4; ++q)
    {
      const int before = j;
      j = n - k;
      k = before;
    }
    return ids[j + (n + 1) * (k + (n + 1) * (i % around))];
  };
  for (int i = 0; i < around; ++i)
  {
    for (int k = 0; k < n; ++k)
    {
      for (int j = 0; j < n; ++j)
      {
        std::array<HexId, 8> cell{};
        for (int c = 0; c < 8; ++c)
        {
          cell[c] = point(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2));
        }
        cells.corners.push_back(cell);
      }
    }
  }
  return cells;
}

/// The layer between two tori: closed in two directions.
Cells shell(int around, int across, int shift)
{
  Cells cells;
  const double pi = 3.14159265358979323846;
  std::vector<HexId> ids;
  for (int k = 0; k < 2; ++k)
  {
    for (int j = 0; j < across; ++j)
    {
      for (int i = 0; i < around; ++i)
      {
        const double a = 2.0 * pi * (i + double(shift) * j / across) / around;
        const double b = 2.0 * pi * j / across;
        const double r = 5.0 + (1.0 + k) * std::cos(b);
        ids.push_back(cells.id({ r * std::cos(a), r * std::sin(a), (1.0 + k) * std::sin(b) }));
      }
    }
  }
  const auto point = [&](int i, int j, int k) {
    i += j == across ? shift : 0;
    return ids[i % around + around * (j % across + across * k)];
  };
  for (int j = 0; j < across; ++j)
  {
    for (int i = 0; i < around; ++i)
    {
      std::array<HexId, 8> cell{};
      for (int c = 0; c < 8; ++c)
      {
        cell[c] = point(i + (c & 1), j + (c >> 1 & 1), c >> 2);
      }
      cells.corners.push_back(cell);
    }
  }
  return cells;
}

std::string refusal(const Cells& cells, const BaseComplexOptions& options = {})
{
  try
  {
    cells.decompose(options);
  }
  catch (const Error& error)
  {
    return error.what();
  }
  return {};
}

void expectRefused(const Cells& cells, const std::vector<std::string>& words, const BaseComplexOptions& options = {})
{
  const std::string text = refusal(cells, options);
  for (const std::string& word : words)
  {
    EXPECT_NE(text.find(word), std::string::npos) << "'" << word << "' in: " << text;
  }
}

TEST(BaseComplex, AGridIsOneBlock)
{
  Cells cells;
  cells.add({ 5, 4, 3 }, [](int i, int j, int k) { return Vec3(i, 2.0 * j, 3.0 * k); });
  const BaseComplex complex = cells.decompose();
  ASSERT_EQ(complex.blocks.size(), 1u);
  // Origin and directions of the grid itself: it starts at the smallest point and its first direction goes furthest.
  EXPECT_EQ(complex.blocks[0].cells, (Ijk{ 5, 4, 3 }));
  EXPECT_EQ(complex.blocks[0].pointIds[1], 1u);
  EXPECT_EQ(complex.boundaryNames.size(), 6u);
  EXPECT_EQ(complex.singularEdges, 0);
  expectWhole(cells, complex);
  expectSameForAnyNumbering(cells);
}

TEST(BaseComplex, VoxelsBetweenHolesAreBlocks)
{
  // Every plane between voxels is cut at some hole, so that all voxels are blocks.
  for (const auto& places : { perforated(3, 3, 1), perforated(5, 7, 1), perforated(3, 3, 3), perforated(5, 3, 5) })
  {
    const Cells cells = voxels(places, 2);
    const BaseComplex complex = cells.decompose();
    EXPECT_EQ(complex.blocks.size(), places.size());
    expectWhole(cells, complex);
    expectSameForAnyNumbering(cells);
  }
}

TEST(BaseComplex, CountsOfRandomVoxels)
{
  std::mt19937 random(7);
  int meshes = 0;
  for (int trial = 0; trial < 250; ++trial)
  {
    // The part connected by faces of a random set, if it is a manifold.
    std::set<Ijk> all;
    for (int k = 0; k < 4; ++k)
    {
      for (int j = 0; j < 4; ++j)
      {
        for (int i = 0; i < 4; ++i)
        {
          if (random() % 4 != 0)
          {
            all.insert({ i, j, k });
          }
        }
      }
    }
    const std::vector<Ijk> places(all.begin(), all.end());
    const Cells cells = voxels(places, 2);
    const std::string text = refusal(cells);
    if (!text.empty())
    {
      EXPECT_NE(text.find("manifold"), std::string::npos) << text;
      continue;
    }
    ++meshes;
    // An independent count: faces between voxels as (voxel, direction), cut from three-voxel edges on along planes.
    std::set<std::array<int, 4>> cut;
    const auto has = [&](Ijk p) { return all.count(p) > 0; };
    for (bool changed = true; changed;)
    {
      changed = false;
      for (int d = 0; d < 3; ++d)
      {
        const int a = (d + 1) % 3, b = (d + 2) % 3;
        Ijk p{};
        for (p[0] = 0; p[0] <= 4; ++p[0])
        {
          for (p[1] = 0; p[1] <= 4; ++p[1])
          {
            for (p[2] = 0; p[2] <= 4; ++p[2])
            {
              // The edge along d at the lower corner of p, with the voxels around it.
              Ijk q[4] = { p, p, p, p };
              --q[1][a];
              --q[2][a];
              --q[2][b];
              --q[3][b];
              int count = 0;
              for (const Ijk& v : q)
              {
                count += has(v);
              }
              if (count < 3)
              {
                continue;
              }
              // Faces: 0|1 and 3|2 are normal to a, 0|3 and 1|2 to b; a face belongs to its upper voxel.
              const std::array<int, 4> faces[4] = { { q[0][0], q[0][1], q[0][2], a }, { q[3][0], q[3][1], q[3][2], a },
                { q[0][0], q[0][1], q[0][2], b }, { q[1][0], q[1][1], q[1][2], b } };
              const bool inside[4] = { has(q[0]) && has(q[1]), has(q[3]) && has(q[2]), has(q[0]) && has(q[3]),
                has(q[1]) && has(q[2]) };
              for (int f = 0; f < 4; ++f)
              {
                const bool wanted = count == 3 || cut.count(faces[f ^ 1]) > 0;
                if (inside[f] && wanted && cut.insert(faces[f]).second)
                {
                  changed = true;
                }
              }
            }
          }
        }
      }
    }
    std::map<Ijk, int> part;
    int parts = 0;
    for (const Ijk& start : places)
    {
      if (part.count(start))
      {
        continue;
      }
      std::vector<Ijk> front{ start };
      part[start] = parts++;
      while (!front.empty())
      {
        const Ijk p = front.back();
        front.pop_back();
        for (int d = 0; d < 3; ++d)
        {
          Ijk up = p, down = p;
          ++up[d];
          --down[d];
          if (has(up) && !part.count(up) && !cut.count({ up[0], up[1], up[2], d }))
          {
            part[up] = part[p];
            front.push_back(up);
          }
          if (has(down) && !part.count(down) && !cut.count({ p[0], p[1], p[2], d }))
          {
            part[down] = part[p];
            front.push_back(down);
          }
        }
      }
    }
    const BaseComplex complex = cells.decompose();
    EXPECT_EQ(complex.blocks.size(), std::size_t(parts));
    expectWhole(cells, complex);
  }
  EXPECT_GT(meshes, 5);
}

TEST(BaseComplex, CellsInRandomOrderAreSortedByPlace)
{
  // More than caches hold.
  constexpr int Around = 105;
  Cells cells = star(5, Around);
  ASSERT_GT(cells.corners.size(), 100000u);
  cells.names = { "floor" };
  for (const auto& cell : cells.corners)
  {
    if (cells.points[cell[0]][2] == 0.0)
    {
      cells.quads.push_back({ { cell[0], cell[1], cell[3], cell[2] }, 0 });
    }
  }
  Cells mixed = shuffled(cells, 1);
  EXPECT_FALSE(isScattered(cells.mesh()));
  EXPECT_TRUE(isScattered(mixed.mesh()));
  const BaseComplex complex = mixed.decompose();
  expectWhole(mixed, complex);
  EXPECT_EQ(complex.blocks.size(), 5u);
  EXPECT_EQ(complex.boundaries.size(), 5u);
  EXPECT_EQ(seen(mixed, complex), seen(cells, cells.decompose()));
  // Names of faces that are asked for by their points.
  HexMesh asked = mixed.mesh();
  asked.quads.clear();
  asked.tagOf = [&](const std::array<HexId, 4>& face) {
    return std::all_of(face.begin(), face.end(), [&](HexId p) { return mixed.points[p][2] == 0.0; }) ? 0 : -1;
  };
  EXPECT_EQ(seen(mixed, baseComplex(asked)), seen(mixed, complex));

  // Messages have the numbers of the input.
  const HexId twice = mixed.corners[4321][0];
  mixed.corners[4321][7] = twice;
  expectRefused(mixed, { "cell 4321 has the point " + std::to_string(twice) + " twice" });
}

TEST(BaseComplex, StarsAreCutAtTheirAxis)
{
  for (int sectors : { 3, 5, 6, 8 })
  {
    const Cells cells = star(sectors, 3);
    const BaseComplex complex = cells.decompose();
    EXPECT_EQ(complex.blocks.size(), std::size_t(sectors));
    EXPECT_EQ(complex.singularEdges, 2);
    expectWhole(cells, complex);
    expectSameForAnyNumbering(cells);
  }
  EXPECT_EQ(star(4, 3).decompose().blocks.size(), 1u);
}

TEST(BaseComplex, RingsAreCutOnce)
{
  for (int quarters = 0; quarters < 4; ++quarters)
  {
    const Cells cells = ring(12, 3, quarters);
    const BaseComplex complex = cells.decompose();
    ASSERT_EQ(complex.blocks.size(), 1u);
    EXPECT_EQ(complex.closedRegions, 1);
    ASSERT_EQ(complex.interfaces.size(), 1u);
    EXPECT_EQ(complex.interfaces[0].blockA, complex.interfaces[0].blockB);
    expectWhole(cells, complex);
    expectSameForAnyNumbering(cells);
  }
}

TEST(BaseComplex, ShellsClosedInTwoDirections)
{
  BaseComplexOptions merge;
  merge.mergeBlocks = true;
  for (int shift : { 0, 2, 3 })
  {
    // A surface along the tube comes back `shift` cells further, and closes after 12 / gcd(12, shift) rounds.
    const Cells cells = shell(12, 8, shift);
    const BaseComplex complex = cells.decompose();
    EXPECT_EQ(complex.blocks.size(), std::size_t(12 / std::gcd(12, shift)));
    expectWhole(cells, complex);
    expectSameForAnyNumbering(cells);
    const BaseComplex merged = cells.decompose(merge);
    EXPECT_EQ(merged.blocks.size(), 1u);
    expectWhole(cells, merged);
  }
}

TEST(BaseComplex, MergedBlocksAreFewer)
{
  std::vector<Ijk> places;
  places.reserve(7);
  for (int c = 0; c < 7; ++c)
  {
    places.push_back({ c & 1, c >> 1 & 1, c >> 2 });
  }
  const Cells corner = voxels(places, 2);
  EXPECT_EQ(corner.decompose().blocks.size(), 7u);
  BaseComplexOptions options;
  options.mergeBlocks = true;
  const BaseComplex merged = corner.decompose(options);
  EXPECT_EQ(merged.blocks.size(), 3u);
  expectWhole(corner, merged);
  expectSameForAnyNumbering(corner, options);

  // The eight voxels around a hole: four bars.
  const Cells plate = voxels(perforated(3, 3, 1), 2);
  EXPECT_EQ(plate.decompose(options).blocks.size(), 4u);
  // Two of five wedges are one grid.
  EXPECT_EQ(star(5, 3).decompose(options).blocks.size(), 3u);
  EXPECT_EQ(ring(12, 3, 1).decompose(options).blocks.size(), 1u);
}

TEST(BaseComplex, BlocksFormAConformingComplex)
{
  const Cells cells = voxels(perforated(3, 3, 3), 2);
  const BaseComplex complex = cells.decompose();
  BlockMesh mesh;
  std::vector<std::vector<Vec3>> points;
  for (const HexBlock& block : complex.blocks)
  {
    points.emplace_back();
    for (HexId p : block.pointIds)
    {
      points.back().push_back(cells.points[p]);
    }
    MeshBlock meshBlock;
    meshBlock.points =
      GridView(points.back().data()->data(), { block.cells[0] + 1, block.cells[1] + 1, block.cells[2] + 1 });
    mesh.blocks.push_back(meshBlock);
  }
  mesh.interfaces = complex.interfaces;
  mesh.boundaries = complex.boundaries;
  mesh.boundaryNames = complex.boundaryNames;
  const BlockComplex result = buildBlockComplex(mesh);
  EXPECT_EQ(result.blocks.size(), mesh.blocks.size());
  EXPECT_TRUE(result.warnings.empty());
}

TEST(BaseComplex, ZonesWithPointsOfTheirOwnAreMerged)
{
  for (double gap : { 0.0, 1e-3 })
  {
    Cells cells;
    cells.add({ 2, 2, 2 }, [](int i, int j, int k) { return Vec3(i, j, k); });
    cells.forget();
    cells.add({ 3, 2, 2 }, [gap](int i, int j, int k) { return Vec3(2 + i + (i == 0 ? gap : 0.0), j, k); });
    const BaseComplex complex = cells.decompose();
    ASSERT_EQ(complex.blocks.size(), 1u);
    EXPECT_EQ(complex.blocks[0].cells, (Ijk{ 5, 2, 2 }));
    expectWhole(cells, complex, true);
    BaseComplexOptions apart;
    apart.neighbours.mergePoints = false;
    EXPECT_EQ(cells.decompose(apart).blocks.size(), 2u);
  }
}

TEST(BaseComplex, NamesOfQuadrilaterals)
{
  Cells cells;
  cells.add({ 4, 2, 2 }, [](int i, int j, int k) { return Vec3(i, j, k); });
  cells.names = { "floor", "inside" };
  const auto quad = [&](const Vec3& a, const Vec3& u, const Vec3& v, int tag) {
    cells.quads.push_back({ { cells.id(a), cells.id(a + u), cells.id(a + u + v), cells.id(a + v) }, tag });
  };
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
  for (int n = 0; n < 4; ++n)
  {
    quad(Vec3(n & 1, n >> 1, 0), x, y, 0); // half of the floor
  }
  quad(Vec3(1, 0, 0), y, z, 1);
  const BaseComplex complex = cells.decompose();
  ASSERT_EQ(complex.boundaries.size(), 1u);
  EXPECT_EQ(complex.boundaries[0].face, 4);
  EXPECT_EQ(complex.boundaries[0].tag, 0);
  EXPECT_EQ(complex.boundaries[0].range, (FaceRange{ { 0, 0 }, { 2, 2 } }));
  ASSERT_EQ(complex.warnings.size(), 1u);
  EXPECT_NE(complex.warnings[0].find("1 of 5"), std::string::npos) << complex.warnings[0];
  EXPECT_NE(complex.warnings[0].find("'inside'"), std::string::npos) << complex.warnings[0];
  expectSameForAnyNumbering(cells);

  // The same with points of their own.
  Cells own = cells;
  for (NamedQuad& q : own.quads)
  {
    for (HexId& p : q.points)
    {
      const Vec3 place = cells.points[p] + Vec3(0, 0, 1e-4);
      own.points.push_back(place);
      p = static_cast<HexId>(own.points.size()) - 1;
    }
  }
  const BaseComplex again = own.decompose();
  EXPECT_EQ(again.boundaries.size(), 1u);
  EXPECT_EQ(seen(own, again), seen(cells, complex));
}

TEST(BaseComplex, ThinWallsWithNamesOnBothSidesStayApart)
{
  // A plate at x = 2 in the lower half, whose upper rim is shared.
  Cells cells;
  cells.add({ 2, 2, 4 }, [](int i, int j, int k) { return Vec3(i, j, k); });
  std::map<HexId, HexId> other;
  const std::size_t firstRight = cells.corners.size();
  cells.add({ 2, 2, 4 }, [](int i, int j, int k) { return Vec3(2 + i, j, k); });
  for (int k = 0; k < 2; ++k)
  {
    for (int j = 0; j <= 2; ++j)
    {
      other[cells.id({ 2, double(j), double(k) })] = static_cast<HexId>(cells.points.size());
      cells.points.push_back(Vec3(2, j, k));
    }
  }
  for (std::size_t c = firstRight; c < cells.corners.size(); ++c)
  {
    for (HexId& p : cells.corners[c])
    {
      p = other.count(p) ? other[p] : p;
    }
  }
  EXPECT_EQ(cells.decompose().blocks.size(), 1u) << "without names it is no wall";
  cells.names = { "left", "right" };
  for (int k = 0; k < 2; ++k)
  {
    for (int j = 0; j < 2; ++j)
    {
      const auto point = [&](int b, int c, bool right) {
        const HexId p = cells.id({ 2, double(j + b), double(k + c) });
        return right && other.count(p) ? other[p] : p;
      };
      for (bool right : { false, true })
      {
        cells.quads.push_back(
          { { point(0, 0, right), point(1, 0, right), point(1, 1, right), point(0, 1, right) }, right ? 1 : 0 });
      }
    }
  }
  const BaseComplex complex = cells.decompose();
  EXPECT_EQ(complex.blocks.size(), 4u);
  EXPECT_EQ(complex.boundaries.size(), 2u);
  EXPECT_EQ(complex.interfaces.size(), 3u);
}

// Both sides of a plate are no hanging nodes of each other, however thin it is; those between thin cells are.
TEST(BaseComplex, ThinPlates)
{
  for (const double thickness : { 0.1, 1e-2, 1e-4, 1e-6 })
  {
    for (const int layers : { 1, 3 })
    {
      Cells plate;
      plate.add(
        { 5, 4, layers }, [&](int i, int j, int k) { return Vec3(i, j, 0.05 * i * i + thickness * k / layers); });
      EXPECT_EQ(plate.decompose().blocks.size(), 1u) << thickness << ", layers " << layers;
    }
    Cells hanging;
    hanging.add({ 1, 1, 1 }, [&](int i, int j, int k) { return Vec3(thickness * (i - 1), 2 * j, 2 * k); });
    hanging.add({ 1, 2, 2 }, [&](int i, int j, int k) { return Vec3(thickness * i, j, k); });
    expectRefused(hanging, { "hanging nodes", "cell 0", "near (0" });
  }
}

TEST(BaseComplex, WhatIsNoBlockStructureIsRefused)
{
  Cells collapsed = voxels({ { 0, 0, 0 } }, 1);
  collapsed.corners[0][7] = collapsed.corners[0][6];
  expectRefused(collapsed, { "cell 0", "twice", "(0, 1, 1)" });

  Cells three = voxels({ { 0, 0, 0 }, { 1, 0, 0 } }, 1);
  three.corners.push_back(three.corners[1]);
  for (int c : { 1, 3, 5, 7 })
  {
    three.corners[2][c] = three.id({ 5, double(c), 1 });
  }
  expectRefused(three, { "cell 0", "cell 1", "cell 2", "same face" });

  expectRefused(voxels({ { 0, 0, 0 }, { 1, 1, 1 } }, 2), { "manifold", "(1, 1, 1)" });
  expectRefused(voxels({ { 0, 0, 0 }, { 1, 1, 0 } }, 1), { "manifold", "(1, 1, 0)" });

  // One cell before four, flat and curved.
  for (double bend : { 0.0, 0.3 })
  {
    Cells hanging;
    const auto curve = [bend](const Vec3& x) { return Vec3(x[0] + bend * x[1] * (2.0 - x[1]), x[1], x[2]); };
    hanging.add({ 1, 1, 1 }, [&](int i, int j, int k) { return curve(2.0 * Vec3(i, j, k)); });
    hanging.add({ 2, 2, 2 }, [&](int i, int j, int k) { return curve(Vec3(2 + i, j, k)); });
    expectRefused(hanging, { "hanging nodes", "cell 0", "near (2" });
  }

  Cells infinite = voxels({ { 0, 0, 0 } }, 1);
  infinite.points[3][1] = std::nan("");
  expectRefused(infinite, { "point 3", "finite" });

  BaseComplexOptions few;
  few.maximumBlocks = 7;
  expectRefused(voxels(perforated(3, 3, 1), 2), { "8 blocks", "64 cells", "Maximum Number Of Blocks is 7" }, few);
}

TEST(BaseComplex, LittleStructureIsAWarning)
{
  const BaseComplex complex = voxels(perforated(3, 3, 1), 2).decompose();
  ASSERT_EQ(complex.warnings.size(), 1u);
  EXPECT_NE(complex.warnings[0].find("64 cells has 8 blocks, 8 cells each"), std::string::npos) << complex.warnings[0];
  EXPECT_TRUE(voxels(perforated(3, 3, 1), 4).decompose().warnings.empty());
}

} // namespace
