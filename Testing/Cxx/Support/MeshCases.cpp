// SPDX-License-Identifier: BSD-3-Clause
#include "Support/MeshCases.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <set>

namespace meshcases
{

namespace
{

const double Pi = std::acos(-1.0);

/// Adding +0 turns -0 into +0, so that points computed in different ways are equal bit for bit.
Vec3 positiveZeros(const Vec3& x)
{
  return x + Vec3::Zero();
}

/// Signed permutation: new direction d is old direction `from[d]`, reversed if flip[d].
struct Reorientation
{
  Ijk from;
  std::array<bool, 3> flip;
};

Reorientation reorientation(int code)
{
  static const std::vector<Reorientation> all = [] {
    std::vector<Reorientation> proper, mirrored;
    Ijk from{ 0, 1, 2 };
    do
    {
      const bool odd = (from[0] > from[1]) ^ (from[0] > from[2]) ^ (from[1] > from[2]);
      for (int bits = 0; bits < 8; ++bits)
      {
        const Reorientation r{ from, { (bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0 } };
        ((r.flip[0] ^ r.flip[1] ^ r.flip[2] ^ odd) ? mirrored : proper).push_back(r);
      }
    } while (std::next_permutation(from.begin(), from.end()));
    proper.insert(proper.end(), mirrored.begin(), mirrored.end());
    return proper;
  }();
  return all.at(code);
}

Ijk moved(const Reorientation& r, const Ijk& oldCells, const Ijk& p)
{
  Ijk result{};
  for (int d = 0; d < 3; ++d)
  {
    result[d] = r.flip[d] ? oldCells[r.from[d]] - p[r.from[d]] : p[r.from[d]];
  }
  return result;
}

int movedFace(const Reorientation& r, int face)
{
  for (int d = 0; d < 3; ++d)
  {
    if (r.from[d] == bsv::faceDirection(face))
    {
      return 2 * d + (bsv::faceSide(face) ^ int(r.flip[d]));
    }
  }
  return -1;
}

bsv::FaceRange movedRange(const Reorientation& r, const Ijk& oldCells, int face, const bsv::FaceRange& range)
{
  const Ijk a = moved(r, oldCells, bsv::facePoint(oldCells, face, range.lo[0], range.lo[1]));
  const Ijk b = moved(r, oldCells, bsv::facePoint(oldCells, face, range.hi[0], range.hi[1]));
  bsv::FaceRange result;
  for (int axis = 0; axis < 2; ++axis)
  {
    const int d = bsv::faceAxis(movedFace(r, face), axis);
    result.lo[axis] = std::min(a[d], b[d]);
    result.hi[axis] = std::max(a[d], b[d]);
  }
  return result;
}

std::array<int, 2> onFace(int face, const Ijk& p)
{
  return { p[bsv::faceAxis(face, 0)], p[bsv::faceAxis(face, 1)] };
}

/// The interface with block A's and B's indices passed through `a` and `b`.
bsv::Interface movedInterface(
  const bsv::Interface& old, const Reorientation& a, const Ijk& cellsA, const Reorientation& b, const Ijk& cellsB)
{
  bsv::Interface result = old;
  result.faceA = movedFace(a, old.faceA);
  result.faceB = movedFace(b, old.faceB);
  result.rangeA = movedRange(a, cellsA, old.faceA, old.rangeA);
  const bsv::FaceRange rangeB = movedRange(b, cellsB, old.faceB, old.rangeB());
  result.originB = rangeB.lo;
  // The code is the one that maps three corners of the rectangle as the old contact does.
  const int n[2] = { old.rangeA.hi[0] - old.rangeA.lo[0], old.rangeA.hi[1] - old.rangeA.lo[1] };
  const int m[2] = { result.rangeA.hi[0] - result.rangeA.lo[0], result.rangeA.hi[1] - result.rangeA.lo[1] };
  for (result.orientation = 0; result.orientation < 8; ++result.orientation)
  {
    bool fits = result.rangeB() == rangeB;
    for (const auto& st : { std::array<int, 2>{ 0, 0 }, { n[0], 0 }, { 0, n[1] } })
    {
      const auto uv = bsv::mapFacePoint(old.orientation, st[0], st[1], n[0], n[1]);
      const auto newA = onFace(result.faceA,
        moved(a, cellsA, bsv::facePoint(cellsA, old.faceA, old.rangeA.lo[0] + st[0], old.rangeA.lo[1] + st[1])));
      const auto newB = onFace(result.faceB,
        moved(b, cellsB, bsv::facePoint(cellsB, old.faceB, old.originB[0] + uv[0], old.originB[1] + uv[1])));
      const auto mapped =
        bsv::mapFacePoint(result.orientation, newA[0] - result.rangeA.lo[0], newA[1] - result.rangeA.lo[1], m[0], m[1]);
      fits = fits && mapped[0] == newB[0] - rangeB.lo[0] && mapped[1] == newB[1] - rangeB.lo[1];
    }
    if (fits)
    {
      break;
    }
  }
  return result;
}

double lattice(int s, int n)
{
  return -1.0 + 2.0 * s / n;
}

/// Point (a, b) of side `side` of the cube [-1,1]^3; the six sides come out right-handed with the third direction
/// outwards.
Vec3 cubePoint(int side, double a, double b)
{
  const int d = side / 2;
  const double sign = side % 2 ? 1.0 : -1.0;
  Vec3 x;
  x[d] = sign;
  x[(d + 1) % 3] = sign > 0 ? a : b;
  x[(d + 2) % 3] = sign > 0 ? b : a;
  return x;
}

Vec3 normalized(const Vec3& x)
{
  return x / std::sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
}

} // namespace

bsv::BlockMesh MeshCase::mesh()
{
  bsv::BlockMesh result;
  for (Block& block : this->blocks)
  {
    bsv::MeshBlock view;
    if (block.isFloat)
    {
      block.floats.clear();
      for (const Vec3& x : block.points)
      {
        block.floats.insert(block.floats.end(), { float(x[0]), float(x[1]), float(x[2]) });
      }
      view.points = bsv::GridView(block.floats.data(), block.counts);
    }
    else
    {
      view.points = bsv::GridView(block.points.data()->data(), block.counts);
    }
    view.name = block.name;
    view.creaseSharpness = block.creaseSharpness;
    result.blocks.push_back(view);
  }
  result.interfaces = this->interfaces;
  result.boundaries = this->boundaries;
  result.boundaryNames = this->boundaryNames;
  result.creases = this->creases;
  return result;
}

MeshCase::Block& MeshCase::add(const Ijk& cells, const std::function<Vec3(const Ijk&)>& point, const std::string& name)
{
  Block block;
  block.name = name;
  block.counts = { cells[0] + 1, cells[1] + 1, cells[2] + 1 };
  block.points.reserve(std::size_t(block.counts[0]) * block.counts[1] * block.counts[2]);
  for (int k = 0; k <= cells[2]; ++k)
  {
    for (int j = 0; j <= cells[1]; ++j)
    {
      for (int i = 0; i <= cells[0]; ++i)
      {
        block.points.push_back(positiveZeros(point({ i, j, k })));
      }
    }
  }
  this->blocks.push_back(std::move(block));
  return this->blocks.back();
}

MeshCase& MeshCase::apply(const Map& map)
{
  for (Block& block : this->blocks)
  {
    for (Vec3& x : block.points)
    {
      x = map(x);
    }
  }
  return *this;
}

MeshCase latticeBlocks(const std::vector<std::pair<Ijk, Ijk>>& boxes, const Map& map)
{
  MeshCase result;
  for (const auto& box : boxes)
  {
    const Ijk a = box.first, b = box.second;
    result.add({ b[0] - a[0], b[1] - a[1], b[2] - a[2] }, [&](const Ijk& p) {
      const Vec3 x(a[0] + p[0], a[1] + p[1], a[2] + p[2]);
      return map ? map(x) : x;
    });
  }
  return result;
}

MeshCase cutBox(const Ijk& cells, const std::array<std::vector<int>, 3>& cuts, const Map& map)
{
  std::array<std::vector<int>, 3> planes;
  for (int d = 0; d < 3; ++d)
  {
    planes[d] = { 0, cells[d] };
    planes[d].insert(planes[d].end(), cuts[d].begin(), cuts[d].end());
    std::sort(planes[d].begin(), planes[d].end());
  }
  std::vector<std::pair<Ijk, Ijk>> boxes;
  for (std::size_t k = 1; k < planes[2].size(); ++k)
  {
    for (std::size_t j = 1; j < planes[1].size(); ++j)
    {
      for (std::size_t i = 1; i < planes[0].size(); ++i)
      {
        boxes.push_back(
          { { planes[0][i - 1], planes[1][j - 1], planes[2][k - 1] }, { planes[0][i], planes[1][j], planes[2][k] } });
      }
    }
  }
  return latticeBlocks(boxes, map);
}

MeshCase lShape(int n)
{
  return latticeBlocks(
    { { { 0, 0, 0 }, { n, n, n } }, { { n, 0, 0 }, { 2 * n, n, n } }, { { 0, n, 0 }, { n, 2 * n, n } } });
}

MeshCase ring(int valence, int cells, const std::vector<std::vector<double>>& heights)
{
  std::vector<Vec3> spoke;
  for (int n = 0; n <= valence; ++n)
  {
    const double angle = 2.0 * Pi * (n % valence) / valence;
    spoke.push_back(Vec3(std::cos(angle), std::sin(angle), 0.0));
  }
  MeshCase result;
  for (const std::vector<double>& z : heights)
  {
    for (int n = 0; n < valence; ++n)
    {
      result.add({ cells, cells, int(z.size()) - 1 }, [&](const Ijk& p) {
        const Vec3 a = spoke[n] * (double(p[0]) / cells);
        const Vec3 b = spoke[n + 1] * (double(p[1]) / cells);
        return Vec3(a[0] + b[0], a[1] + b[1], z[p[2]]);
      });
    }
  }
  return result;
}

MeshCase sphereBody(int cells, const std::vector<double>& radii)
{
  MeshCase result;
  for (int side = 0; side < 6; ++side)
  {
    result.add({ cells, cells, int(radii.size()) - 1 }, [&](const Ijk& p) -> Vec3 {
      return normalized(cubePoint(side, lattice(p[0], cells), lattice(p[1], cells))) * radii[p[2]];
    });
  }
  return result;
}

MeshCase polycubeBody(const std::vector<Ijk>& cubes, int cells, const std::vector<double>& radii)
{
  // Points of the surface by their lattice position, `cells` steps per cube.
  std::map<Ijk, Vec3> directions;
  std::map<Ijk, std::set<Ijk>> neighbours;
  std::vector<std::function<Ijk(int, int)>> squares;
  for (const Ijk& cube : cubes)
  {
    for (int side = 0; side < 6; ++side)
    {
      Ijk beyond = cube;
      beyond[side / 2] += side % 2 ? 1 : -1;
      if (std::find(cubes.begin(), cubes.end(), beyond) != cubes.end())
      {
        continue;
      }
      squares.emplace_back([=](int i, int j) {
        const Vec3 x = cubePoint(side, lattice(i, cells), lattice(j, cells));
        Ijk at;
        for (int d = 0; d < 3; ++d)
        {
          at[d] = cube[d] * cells + static_cast<int>(std::lround(0.5 * cells * (1.0 + x[d])));
        }
        return at;
      });
      const auto& square = squares.back();
      const auto join = [&](const Ijk& a, const Ijk& b) {
        neighbours[a].insert(b);
        neighbours[b].insert(a);
      };
      for (int j = 0; j <= cells; ++j)
      {
        for (int i = 0; i < cells; ++i)
        {
          join(square(i, j), square(i + 1, j));
          join(square(j, i), square(j, i + 1));
        }
      }
    }
  }
  for (const auto& entry : neighbours)
  {
    Vec3 x;
    for (int d = 0; d < 3; ++d)
    {
      x[d] = static_cast<double>(entry.first[d]) / cells - cubes.front()[d] - 0.5;
    }
    directions[entry.first] = normalized(x);
  }
  for (int step = 0; step < 20; ++step)
  {
    std::map<Ijk, Vec3> next;
    for (const auto& entry : neighbours)
    {
      Vec3 mean = Vec3::Zero();
      for (const Ijk& other : entry.second)
      {
        mean += directions[other] / static_cast<double>(entry.second.size());
      }
      next[entry.first] = normalized(directions[entry.first] + mean);
    }
    directions = std::move(next);
  }

  MeshCase result;
  for (const auto& square : squares)
  {
    result.add({ cells, cells, int(radii.size()) - 1 },
      [&](const Ijk& p) -> Vec3 { return directions[square(p[0], p[1])] * radii[p[2]]; });
  }
  return result;
}

MeshCase aroundCube(int cells, double firstLayer, bool bar)
{
  std::vector<double> layers{ 0.0 };
  for (double h = firstLayer; layers.back() < 2.0; h *= 1.7)
  {
    layers.push_back(layers.back() + h);
  }
  // Below, along and above the cube.
  std::array<std::vector<double>, 3> pieces;
  for (const double z : layers)
  {
    pieces[0].insert(pieces[0].begin(), -1.0 - z);
    pieces[2].push_back(1.0 + z);
  }
  for (int i = 0; i <= cells; ++i)
  {
    pieces[1].push_back(2.0 * i / cells - 1.0);
  }
  MeshCase mesh;
  mesh.boundaryNames = { "wall" };
  for (int place = 0; place < 27; ++place)
  {
    const Ijk at{ place % 3, place / 3 % 3, place / 9 };
    const int middle = (at[0] == 1) + (at[1] == 1) + (at[2] == 1);
    if (middle == 3 || (bar && (at[2] != 1)))
    {
      continue;
    }
    const auto cellsOf = [&](int d) { return static_cast<int>(pieces[at[d]].size()) - 1; };
    mesh.add({ cellsOf(0), cellsOf(1), cellsOf(2) },
      [&](const Ijk& p) { return Vec3(pieces[at[0]][p[0]], pieces[at[1]][p[1]], pieces[at[2]][p[2]]); });
    for (int d = 0; d < 3; ++d)
    {
      if (middle == 2 && at[d] != 1)
      {
        const int face = 2 * d + (at[d] == 0 ? 1 : 0);
        mesh.boundaries.push_back({ static_cast<int>(mesh.blocks.size()) - 1, face,
          { { 0, 0 }, { cellsOf(d == 0 ? 1 : 0), cellsOf(d == 2 ? 1 : 2) } }, 0 });
      }
    }
  }
  return mesh;
}

MeshCase ball(int cells, int radialCells)
{
  const double core = 0.4;
  MeshCase result;
  result.add({ cells, cells, cells }, [&](const Ijk& p) -> Vec3 {
    return Vec3(lattice(p[0], cells), lattice(p[1], cells), lattice(p[2], cells)) * core;
  });
  for (int side = 0; side < 6; ++side)
  {
    result.add({ cells, cells, radialCells }, [&](const Ijk& p) -> Vec3 {
      const Vec3 x = cubePoint(side, lattice(p[0], cells), lattice(p[1], cells));
      const double w = double(p[2]) / radialCells;
      return x * core * (1.0 - w) + normalized(x) * w;
    });
  }
  return result;
}

MeshCase torus(int sections, int cells)
{
  const double core = 0.4;
  const int around = sections * cells;
  MeshCase result;
  const auto revolved = [&](int index, double x, double y) {
    const double angle = 2.0 * Pi * (index % around) / around;
    return Vec3((2.0 + x) * std::cos(angle), -(2.0 + x) * std::sin(angle), y);
  };
  for (int section = 0; section < sections; ++section)
  {
    result.add({ cells, cells, cells }, [&](const Ijk& p) {
      return revolved(section * cells + p[2], lattice(p[0], cells) * core, lattice(p[1], cells) * core);
    });
    for (int side = 0; side < 4; ++side)
    {
      result.add({ cells, cells, cells }, [&](const Ijk& p) {
        const double a = lattice(p[0], cells);
        const double x[4] = { -a, 1.0, a, -1.0 };
        const double y[4] = { -1.0, -a, 1.0, a };
        const double w = double(p[1]) / cells;
        const double length = std::sqrt(x[side] * x[side] + y[side] * y[side]);
        return revolved(section * cells + p[2], x[side] * core * (1.0 - w) + x[side] / length * w,
          y[side] * core * (1.0 - w) + y[side] / length * w);
      });
    }
  }
  return result;
}

MeshCase oGrid(const Ijk& cells, double innerRadius)
{
  MeshCase result;
  result.add(cells, [&](const Ijk& p) {
    const double angle = 2.0 * Pi * (p[0] % cells[0]) / cells[0];
    const double r = innerRadius + (1.0 - innerRadius) * p[1] / cells[1];
    return Vec3(r * std::cos(angle), -r * std::sin(angle), double(p[2]) / cells[2]);
  });
  return result;
}

MeshCase closedShell(const Ijk& cells)
{
  MeshCase result;
  result.add(cells, [&](const Ijk& p) {
    const double a = 2.0 * Pi * (p[0] % cells[0]) / cells[0];
    const double b = 2.0 * Pi * (p[1] % cells[1]) / cells[1];
    const double r = 0.5 + 0.5 * p[2] / cells[2];
    const double x = 2.0 + r * std::cos(b);
    return Vec3(x * std::cos(a), x * std::sin(a), r * std::sin(b));
  });
  return result;
}

MeshCase cGrid(int wakeCells, int bodyCells, int jCells, int kCells)
{
  const int count = 2 * wakeCells + bodyCells;
  MeshCase result;
  result.add({ count, jCells, kCells }, [&](const Ijk& p) {
    // Lower half for the first i, upper half mirrored; the middle lies on y = 0.
    const int i = std::min(p[0], count - p[0]);
    const double side = 2 * p[0] == count ? 0.0 : 2 * p[0] < count ? -1.0 : 1.0;
    double x = 1.0 + 2.0 * (wakeCells - i) / wakeCells;
    double y = 0.0;
    if (i > wakeCells)
    {
      x = 1.0 - 2.0 * (i - wakeCells) / bodyCells;
      y = 0.3 * x * (1.0 - x);
    }
    const double bend = std::min(1.0, 2.0 * i / count);
    const double angle = 0.5 * Pi * bend;
    const double outerX = 4.0 * std::cos(angle) - 2.0 * bend;
    const double outerY = 2.0 * std::cos(angle) + 2.0 * std::sin(2.0 * angle);
    const double w = double(p[1]) / jCells;
    return Vec3(x + w * (outerX - x), side * (y + w * (outerY - y)), double(p[2]) / kCells);
  });
  return result;
}

MeshCase extendedCuboid(int cells, int layers, double step, double growth)
{
  const Vec3 size(3.0, 1.0, 2.0);
  const std::array<int, 3> pieces{ 3, 1, 2 };
  // Lattice coordinates, extension included; inner ones start at index `layers` except at the symmetry plane.
  std::array<std::vector<double>, 3> lattice;
  std::array<std::vector<int>, 3> cuts;
  for (int d = 0; d < 3; ++d)
  {
    std::vector<double> beyond;
    double x = 0.0, cell = step * 0.6 * size[d] / layers;
    for (int k = 0; k < layers; ++k, cell *= 1.2)
    {
      beyond.push_back(x += cell);
    }
    const double low = d == 2 ? 0.0 : -size[d];
    if (d < 2)
    {
      cuts[d].push_back(0);
      for (int k = layers; k-- > 0;)
      {
        lattice[d].push_back(low - beyond[k]);
      }
    }
    const int inner = pieces[d] * cells;
    for (int i = 0; i <= inner; ++i)
    {
      if (i % cells == 0)
      {
        cuts[d].push_back(static_cast<int>(lattice[d].size()));
      }
      lattice[d].push_back(low + (size[d] - low) * i / inner);
    }
    for (int k = 0; k < layers; ++k)
    {
      lattice[d].push_back(size[d] + beyond[k]);
    }
    cuts[d].push_back(static_cast<int>(lattice[d].size()) - 1);
  }
  const auto at = [&](int i, int j, int k) { return Vec3(lattice[0][i], lattice[1][j], lattice[2][k]); };
  const auto isInner = [&](int d, int piece) { return d == 2 ? piece < 2 : piece > 0 && piece <= pieces[d]; };

  std::vector<double> depth{ 0.0 };
  double thickness = 1.0;
  for (int k = 0; k < layers; ++k, thickness *= growth)
  {
    depth.push_back(depth.back() + thickness);
  }
  const auto between = [&](const Vec3& hull, int k) -> Vec3 {
    const Vec3 body = 0.4 * size.cwiseProduct(normalized(hull.cwiseQuotient(size)));
    const double w = depth[k] / depth.back();
    return k == layers ? hull : Vec3(body + w * (hull - body));
  };

  MeshCase result;
  result.boundaryNames = { "wall", "symmetry" };
  // The sides of the cuboid: its direction, side, and the directions of the blocks' first two axes.
  const int sides[5][4] = { { 0, 1, 1, 2 }, { 0, 0, 2, 1 }, { 1, 1, 2, 0 }, { 1, 0, 0, 2 }, { 2, 1, 0, 1 } };
  const auto firstPiece = [](int d) { return d == 2 ? 0 : 1; };
  for (const auto& [d, side, first, second] : sides)
  {
    for (int q = 0; q < pieces[second]; ++q)
    {
      for (int p = 0; p < pieces[first]; ++p)
      {
        result.add({ cells, cells, layers }, [&, d = d, side = side, first = first, second = second](const Ijk& ijk) {
          Ijk index;
          index[first] = cuts[first][p + firstPiece(first)] + ijk[0];
          index[second] = cuts[second][q + firstPiece(second)] + ijk[1];
          index[d] = side ? cuts[d][firstPiece(d) + pieces[d]] : cuts[d][1];
          return between(at(index[0], index[1], index[2]), ijk[2]);
        });
        result.boundaries.push_back(
          { static_cast<int>(result.blocks.size()) - 1, 4, { { 0, 0 }, { cells, cells } }, 0 });
      }
    }
  }
  // First the blocks that are attached face to face: one direction is beyond the cuboid.
  for (const bool faceToFace : { true, false })
  {
    for (std::size_t k = 0; k + 1 < cuts[2].size(); ++k)
    {
      for (std::size_t j = 0; j + 1 < cuts[1].size(); ++j)
      {
        for (std::size_t i = 0; i + 1 < cuts[0].size(); ++i)
        {
          const Ijk piece{ int(i), int(j), int(k) };
          int inner = 0;
          for (int d = 0; d < 3; ++d)
          {
            inner += isInner(d, piece[d]) ? 1 : 0;
          }
          if (inner == 3 || (inner == 2) != faceToFace)
          {
            continue;
          }
          const Ijk start{ cuts[0][i], cuts[1][j], cuts[2][k] };
          result.add({ cuts[0][i + 1] - start[0], cuts[1][j + 1] - start[1], cuts[2][k + 1] - start[2] },
            [&](const Ijk& ijk) { return at(start[0] + ijk[0], start[1] + ijk[1], start[2] + ijk[2]); });
        }
      }
    }
  }
  for (std::size_t b = 0; b < result.blocks.size(); ++b)
  {
    const MeshCase::Block& block = result.blocks[b];
    for (int face = 0; face < 6; ++face)
    {
      const Ijk n = block.cells();
      const bsv::FaceRange whole{ { 0, 0 }, { n[bsv::faceAxis(face, 0)], n[bsv::faceAxis(face, 1)] } };
      bool flat = true;
      for (int corner = 0; corner < 4; ++corner)
      {
        const Ijk at = bsv::facePoint(n, face, corner & 1 ? whole.hi[0] : 0, corner >> 1 ? whole.hi[1] : 0);
        flat = flat && block.at(at)[2] == 0.0;
      }
      if (flat)
      {
        result.boundaries.push_back({ static_cast<int>(b), face, whole, 1 });
      }
    }
  }
  return result;
}

MeshCase randomBoxes(unsigned seed)
{
  std::mt19937 random(seed);
  const auto below = [&](int n) { return static_cast<int>(random() % n); };
  const int size = 2 + below(4);
  std::vector<std::pair<Ijk, Ijk>> boxes;
  for (int attempt = 3 + below(12); attempt > 0; --attempt)
  {
    Ijk first, last;
    for (int d = 0; d < 3; ++d)
    {
      first[d] = below(size);
      last[d] = first[d] + 1 + below(size - first[d]);
    }
    const bool overlaps = std::any_of(boxes.begin(), boxes.end(), [&](const std::pair<Ijk, Ijk>& box) {
      bool common = true;
      for (int d = 0; d < 3; ++d)
      {
        common = common && first[d] < box.second[d] && box.first[d] < last[d];
      }
      return common;
    });
    if (!overlaps)
    {
      boxes.emplace_back(first, last);
    }
  }
  MeshCase mesh = latticeBlocks(boxes, [](const Vec3& x) { return wavy(Vec3(0.4 * x)); });
  for (int n = below(3); n > 0; --n)
  {
    const int block = below(static_cast<int>(mesh.blocks.size()));
    const Ijk cells = mesh.blocks[block].cells();
    bsv::CreaseLine line;
    line.block = block;
    for (int d = 0; d < 3; ++d)
    {
      line.from[d] = line.to[d] = below(cells[d] + 1);
    }
    const int along = below(3);
    line.from[along] = 0;
    line.to[along] = cells[along];
    mesh.creases.push_back(line);
  }
  return mesh;
}

Vec3 wavy(const Vec3& x)
{
  return Vec3(x[0] + 0.11 * std::sin(1.1 * x[1]) + 0.07 * std::cos(0.9 * x[2]),
    x[1] + 0.09 * std::sin(0.8 * x[2] + 0.3) + 0.08 * std::cos(1.2 * x[0]),
    x[2] + 0.1 * std::sin(x[0] - 0.2) + 0.06 * std::sin(0.7 * x[1]));
}

void reorient(MeshCase& mesh, int block, int orientation)
{
  const Reorientation r = reorientation(orientation);
  const Reorientation none = reorientation(0);
  MeshCase::Block& b = mesh.blocks[block];
  const Ijk oldCells = b.cells();
  MeshCase::Block old = b;
  b.counts = { old.counts[r.from[0]], old.counts[r.from[1]], old.counts[r.from[2]] };
  for (int k = 0; k < old.counts[2]; ++k)
  {
    for (int j = 0; j < old.counts[1]; ++j)
    {
      for (int i = 0; i < old.counts[0]; ++i)
      {
        const Ijk p{ i, j, k };
        const Ijk q = moved(r, oldCells, p);
        b.at(q) = old.at(p);
        if (!b.creaseSharpness.empty())
        {
          b.creaseSharpness[b.index(q)] = old.creaseSharpness[old.index(p)];
        }
      }
    }
  }
  for (bsv::Interface& contact : mesh.interfaces)
  {
    const bool a = contact.blockA == block, bb = contact.blockB == block;
    if (a || bb)
    {
      contact = movedInterface(contact, a ? r : none, a ? oldCells : mesh.blocks[contact.blockA].cells(), bb ? r : none,
        bb ? oldCells : mesh.blocks[contact.blockB].cells());
    }
  }
  for (bsv::BoundaryPatch& patch : mesh.boundaries)
  {
    if (patch.block == block)
    {
      patch.range = movedRange(r, oldCells, patch.face, patch.range);
      patch.face = movedFace(r, patch.face);
    }
  }
  for (bsv::CreaseLine& line : mesh.creases)
  {
    if (line.block == block)
    {
      line.from = moved(r, oldCells, line.from);
      line.to = moved(r, oldCells, line.to);
    }
  }
}

void renumber(MeshCase& mesh, const std::vector<int>& order)
{
  std::vector<MeshCase::Block> blocks;
  std::vector<int> newId(order.size());
  for (std::size_t n = 0; n < order.size(); ++n)
  {
    blocks.push_back(mesh.blocks[order[n]]);
    newId[order[n]] = int(n);
  }
  mesh.blocks = std::move(blocks);
  for (bsv::Interface& contact : mesh.interfaces)
  {
    contact.blockA = newId[contact.blockA];
    contact.blockB = newId[contact.blockB];
  }
  for (bsv::BoundaryPatch& patch : mesh.boundaries)
  {
    patch.block = newId[patch.block];
  }
  for (bsv::CreaseLine& line : mesh.creases)
  {
    line.block = newId[line.block];
  }
}

void shuffle(MeshCase& mesh, unsigned seed, bool mirror)
{
  std::mt19937 random(seed);
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b)
  {
    reorient(mesh, int(b), int(random() % (mirror ? MirroredOrientationCount : OrientationCount)));
  }
  std::vector<int> order(mesh.blocks.size());
  std::iota(order.begin(), order.end(), 0);
  for (std::size_t n = order.size(); n > 1; --n)
  {
    std::swap(order[n - 1], order[random() % n]);
  }
  renumber(mesh, order);
}

void declareAll(MeshCase& mesh, unsigned seed)
{
  std::mt19937 random(seed);
  const bsv::BlockMesh view = mesh.mesh();
  const bsv::BlockComplex complex = bsv::buildBlockComplex(view);
  mesh.interfaces.clear();
  mesh.boundaries.clear();
  mesh.boundaryNames = complex.boundaryNames;
  const int unnamed = int(mesh.boundaryNames.size());
  mesh.boundaryNames.push_back("boundary");
  const auto rangeOf = [&](const bsv::FaceUse& use) {
    const bsv::ComplexBlock& block = complex.blocks[use.block];
    bsv::FaceRange range;
    for (int axis = 0; axis < 2; ++axis)
    {
      const int d = bsv::faceAxis(use.face, axis);
      range.lo[axis] = block.offset[d];
      range.hi[axis] = block.offset[d] + block.cells(d);
    }
    return range;
  };
  const auto onParentSurface = [&](const bsv::FaceUse& use) {
    const bsv::ComplexBlock& block = complex.blocks[use.block];
    const int d = bsv::faceDirection(use.face);
    const int at = block.offset[d] + (bsv::faceSide(use.face) ? block.cells(d) : 0);
    return bsv::faceSide(use.face) ? at == mesh.blocks[block.parent].counts[d] - 1 : at == 0;
  };
  for (const bsv::ComplexFace& face : complex.faces)
  {
    const bsv::FaceUse a = face.uses[0];
    if (face.boundary())
    {
      mesh.boundaries.push_back(
        { complex.blocks[a.block].parent, a.face, rangeOf(a), face.tag < 0 ? unnamed : face.tag });
    }
    else if (onParentSurface(a))
    {
      const bsv::FaceUse b = face.uses[1];
      const bool forward = random() % 2 == 0;
      const bsv::FaceUse from = forward ? a : b, to = forward ? b : a;
      bsv::Interface contact;
      contact.blockA = complex.blocks[from.block].parent;
      contact.faceA = from.face;
      contact.blockB = complex.blocks[to.block].parent;
      contact.faceB = to.face;
      contact.orientation = forward ? face.orientation : bsv::inverseOrientation(face.orientation);
      contact.rangeA = rangeOf(from);
      contact.originB = rangeOf(to).lo;
      mesh.interfaces.push_back(contact);
    }
  }
}

} // namespace meshcases
