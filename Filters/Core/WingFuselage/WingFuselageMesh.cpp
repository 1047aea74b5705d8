// SPDX-License-Identifier: BSD-3-Clause
#include "WingFuselage/WingFuselageMesh.h"

#include "Base/Numbers.h"
#include "Base/UnionFind.h"
#include "Wall/BodyFit.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

namespace bsv
{
namespace
{

enum Tag
{
  WallFuselage,
  WallWing,
  Symmetry,
  FarField
};

constexpr int LayersPerPatch = 4;
constexpr int Columns = WingFuselagePatches * LayersPerPatch;

/// Coefficients r and e of the end derivatives of the lines from the body to the box.
constexpr double WallReach = 2.0;
constexpr double BoxReach = 2.0;

/// Distances 0 = s_0 < s_1 < .. < s_n = length.
using Steps = std::vector<double>;

/// Steps that start with `first`, grow `growing` times by one ratio and stay the same then.
Steps growingSteps(double first, int growing, int equal, double length)
{
  const auto steps = [&](double ratio) {
    Steps result{ 0.0 };
    double step = first;
    for (int i = 0; i < growing + equal; ++i)
    {
      result.push_back(result.back() + step);
      step *= i < growing ? ratio : 1.0;
    }
    return result;
  };
  double low = 0.0, high = 16.0;
  for (int i = 0; i < 100; ++i)
  {
    const double middle = 0.5 * (low + high);
    (steps(middle).back() < length ? low : high) = middle;
  }
  Steps result = steps(high);
  result.back() = length;
  return result;
}

/// Steps that grow from both ends, where they are `end` long, to the middle; by not more than 1.35 times each.
Steps gradedSteps(double end, int cells, double length)
{
  constexpr double MaximumGrowth = 1.35;
  const auto at = [&](double ratio) {
    Steps result{ 0.0 };
    for (int i = 0; i < cells; ++i)
    {
      result.push_back(result.back() + std::pow(ratio, std::min(i, cells - 1 - i)));
    }
    return result;
  };
  double low = 1.0, high = MaximumGrowth;
  for (int i = 0; i < 100; ++i)
  {
    const double middle = 0.5 * (low + high);
    (length / at(middle).back() > end ? low : high) = middle;
  }
  Steps result = at(high);
  const double scale = length / result.back();
  for (double& step : result)
  {
    step *= scale;
  }
  result.back() = length;
  return result;
}

/// Sizes of everything.
struct Plan
{
  explicit Plan(const WingFuselageOptions& options)
  {
    checkWingFuselageShape(options.shape);
    checkRange("Resolution", options.resolution, 2, 96);
    checkRange("Far Field Distance", options.farFieldDistance, 2.0, 1000.0);
    checkRange("First Layer Height", options.firstLayerHeight, 1e-7, 0.1);
    checkRange("Growth Ratio", options.growthRatio, 1.02, 2.0);
    const int n = options.resolution;
    const double ratio = options.growthRatio;

    // Where the layers stop to grow.
    const double outer = WallReach / n;
    const double first = options.firstLayerHeight;
    if (first > outer)
    {
      std::ostringstream text;
      text << "First Layer Height " << first << " is larger than the outer cells, " << outer
           << " high at the Resolution " << n << "; lower one of them";
      throw Error(text.str());
    }
    const int third = std::max(1, static_cast<int>(std::ceil(std::log(outer / first) / std::log(ratio) / 3.0)));
    const int growing = 3 * third;
    const double grown = first * (std::pow(ratio, growing) - 1.0) / (ratio - 1.0);
    const double last = first * std::pow(ratio, growing);
    const int equal = std::max(2, static_cast<int>(std::ceil((WallReach - grown) / last)));
    this->layers = growingSteps(first, growing, equal, WallReach);
    this->layerStart = { 0, third, 2 * third, growing, growing + equal };

    // The derivative of the lines to the box, at the box, is BoxReach.
    const double atBox = BoxReach / WallReach * (WallReach - this->layers[growing + equal - 1]);
    // The extension is refined like the rest: cells grow 1.37 times at a resolution of 8, 1.17 times at 16.
    const double extensionGrowth = 2.5 / n;
    const auto extension = [&](double step) {
      const double distance = options.farFieldDistance;
      const double count = std::log1p(distance / step * std::expm1(extensionGrowth)) / extensionGrowth;
      return growingSteps(step, std::max(2, static_cast<int>(std::ceil(count))), 0, distance);
    };
    // The fuselage ends at x = -3 and 3; the trailing edge of the tip is near quarter chord + 0.6.
    const double sweep = std::tan(options.shape.sweepAngle * Pi / 180.0);
    const double tip = -0.4 + options.shape.span * sweep + 0.6;
    const double margin = 3.0;
    const double ends[2] = { -3.0 - margin, std::max(3.0, tip) + margin };
    const int ahead = std::max(1, n / 2);
    const double aheadLength = 1.0;

    this->append(0, ends[0] - aheadLength, extension(aheadLength / ahead), -1.0);
    this->append(0, ends[0] - aheadLength, ahead, aheadLength);
    this->append(0, ends[0], 2 * n, ends[1] - ends[0]);
    this->append(0, ends[1], ahead, aheadLength);
    this->append(0, ends[1] + aheadLength, extension(aheadLength / ahead), 1.0);
    const double width = options.shape.span + margin;
    const double inner = 0.35 * width;
    this->append(1, 0.0, n, inner);
    this->append(1, inner, 3 * n, width - inner);
    this->append(1, width, extension(atBox), 1.0);
    const double height = 3.0;
    this->append(2, -height, extension(atBox), -1.0);
    // So that the extension finds cells of one height, above the body and beside it.
    this->append(2, -height, gradedSteps(atBox, n, 2.0 * height), 1.0);
    this->append(2, height, extension(atBox), 1.0);
  }

  int cells(int direction, int part) const { return this->start[direction][part + 1] - this->start[direction][part]; }

  /// Cells of a patch along a and b.
  std::array<int, 2> patchCells(int patch) const
  {
    const int a = this->cells(patch % 2 == 0 ? 2 : 0, patch % 2 == 0 ? 1 : 2);
    return { a, patch == 8 ? this->cells(0, 2) : this->cells(1, patch / 4) };
  }

  /// Point of the box above a point of a patch.
  Vec3 boxPoint(int patch, int i, int j) const
  {
    const int last = this->patchCells(patch)[0];
    const Steps& x = this->coordinates[0];
    const Steps& y = this->coordinates[1];
    const Steps& z = this->coordinates[2];
    const int front = this->start[0][2], rear = this->start[0][3], bottom = this->start[2][1], top = this->start[2][2];
    if (patch == 8)
    {
      return { x[front + j], y[this->start[1][2]], z[bottom + i] };
    }
    const double span = y[this->start[1][patch / 4] + j];
    switch (patch % 4)
    {
      case 0:
        return { x[front], span, z[bottom + i] };
      case 1:
        return { x[front + i], span, z[top] };
      case 2:
        return { x[rear], span, z[bottom + last - i] };
      default:
        return { x[front + last - i], span, z[bottom] };
    }
  }

  /// Sum of the normals of the sides of the box at a point of it, those of the others fading out with the distance.
  Vec3 boxNormal(const Vec3& point) const
  {
    const auto cube = [](double t) { return t * t * t; };
    const auto position = [&](int d, int first, int last) {
      const double low = this->coordinates[d][first], high = this->coordinates[d][last];
      return (2.0 * point[d] - low - high) / (high - low);
    };
    return { cube(position(0, this->start[0][2], this->start[0][3])),
      cube(point[1] / this->coordinates[1][this->start[1][2]]),
      cube(position(2, this->start[2][1], this->start[2][2])) };
  }

  /// Of the lines from the body to the box, as the distance from the wall that they would have without bending.
  Steps layers;
  std::array<int, LayersPerPatch + 1> layerStart{};
  /// Coordinates along x, y, z of all that is not between body and box, and where the parts start: along x extension,
  /// ahead, box, behind, extension; along y two parts of the cuboid, extension; along z extension, cuboid, extension.
  std::array<Steps, 3> coordinates;
  std::array<std::vector<int>, 3> start{ std::vector<int>{ 0 }, std::vector<int>{ 0 }, std::vector<int>{ 0 } };

private:
  void append(int direction, double first, int cells, double length)
  {
    Steps steps;
    for (int i = 0; i <= cells; ++i)
    {
      steps.push_back(length * i / cells);
    }
    this->append(direction, first, steps, 1.0);
  }

  void append(int direction, double first, Steps steps, double sign)
  {
    Steps& all = this->coordinates[direction];
    if (sign < 0.0)
    {
      std::reverse(steps.begin(), steps.end());
    }
    for (std::size_t i = all.empty() ? 0 : 1; i < steps.size(); ++i)
    {
      all.push_back(first + sign * steps[i]);
    }
    this->start[direction].push_back(static_cast<int>(all.size()) - 1);
  }
};

/// Blocks 36..78, in their order, as the parts of the coordinates along x, y, z that they cover.
std::vector<Ijk> latticeBlocks()
{
  std::vector<std::vector<Ijk>> byContact(4);
  for (int c = 0; c < 3; ++c)
  {
    for (int b = 0; b < 3; ++b)
    {
      for (int a = 0; a < 5; ++a)
      {
        // Directions in which the block is outside the cuboid.
        const int outside = (a == 0 || a == 4) + (b == 2) + (c != 1);
        if (outside > 0 || a != 2)
        {
          byContact[outside].push_back({ a, b, c });
        }
      }
    }
  }
  std::vector<Ijk> blocks;
  for (const auto& some : byContact)
  {
    blocks.insert(blocks.end(), some.begin(), some.end());
  }
  return blocks;
}

/// Number of a corner of the block structure: of the lattice, or of layer 0..3 between body and box.
int latticeVertex(int a, int b, int c)
{
  return a + 6 * (b + 4 * c);
}
int columnVertex(int patch, int i, int j, int layer)
{
  const int b = patch == 8 ? 2 : patch / 4 + j;
  int a = 2, c = 1;
  switch (patch == 8 ? 4 : patch % 4)
  {
    case 0:
      c += i;
      break;
    case 1:
      a += i;
      c += 1;
      break;
    case 2:
      a += 1;
      c += 1 - i;
      break;
    case 3:
      a += 1 - i;
      break;
    default:
      a += j;
      c += i;
  }
  return layer == LayersPerPatch ? latticeVertex(a, b, c) : 96 * (layer + 1) + latticeVertex(a, b, c);
}

/// The eight corners of every block.
std::vector<std::array<int, 8>> blockCorners()
{
  std::vector<std::array<int, 8>> corners;
  for (int p = 0; p < WingFuselagePatches; ++p)
  {
    for (int layer = 0; layer < LayersPerPatch; ++layer)
    {
      std::array<int, 8> own;
      for (int v = 0; v < 8; ++v)
      {
        own[v] = columnVertex(p, v & 1, v >> 1 & 1, layer + (v >> 2));
      }
      corners.push_back(own);
    }
  }
  for (const Ijk& part : latticeBlocks())
  {
    std::array<int, 8> own;
    for (int v = 0; v < 8; ++v)
    {
      own[v] = latticeVertex(part[0] + (v & 1), part[1] + (v >> 1 & 1), part[2] + (v >> 2));
    }
    corners.push_back(own);
  }
  return corners;
}

FaceRange wholeFace(const Ijk& counts, int face)
{
  return { { 0, 0 }, { counts[faceAxis(face, 0)] - 1, counts[faceAxis(face, 1)] - 1 } };
}

/// Contacts of blocks whose faces have the same corners; `open` is called for the faces that meet no other.
template <typename Open>
std::vector<Interface> contacts(
  const std::vector<std::array<int, 8>>& corners, const std::vector<Ijk>& counts, const Open& open)
{
  std::map<std::array<int, 4>, std::array<int, 2>> waiting;
  std::vector<Interface> found;
  const auto faceCorners = [&](int block, int face) {
    std::array<int, 4> own;
    for (int v = 0; v < 4; ++v)
    {
      own[v] = corners[block][faceCorner(face, v & 1, v >> 1)];
    }
    return own;
  };
  for (int block = 0; block < static_cast<int>(corners.size()); ++block)
  {
    for (int face = 0; face < 6; ++face)
    {
      const std::array<int, 4> own = faceCorners(block, face);
      std::array<int, 4> key = own;
      std::sort(key.begin(), key.end());
      const auto other = waiting.find(key);
      if (other == waiting.end())
      {
        waiting[key] = { block, face };
        continue;
      }
      Interface contact;
      contact.blockA = other->second[0];
      contact.faceA = other->second[1];
      contact.blockB = block;
      contact.faceB = face;
      contact.rangeA = wholeFace(counts[contact.blockA], contact.faceA);
      const std::array<int, 4> first = faceCorners(contact.blockA, contact.faceA);
      for (contact.orientation = 0; contact.orientation < 8; ++contact.orientation)
      {
        bool same = true;
        for (int v = 0; v < 4; ++v)
        {
          const auto st = mapFacePoint(contact.orientation, v & 1, v >> 1, 1, 1);
          same = same && first[v] == own[st[0] + 2 * st[1]];
        }
        if (same)
        {
          break;
        }
      }
      found.push_back(contact);
      waiting.erase(other);
    }
  }
  std::vector<std::array<int, 2>> rest;
  for (const auto& entry : waiting)
  {
    rest.push_back(entry.second);
  }
  std::sort(rest.begin(), rest.end());
  for (const auto& face : rest)
  {
    open(face[0], face[1]);
  }
  return found;
}

/// Creases of the blocks `blockOfPatch(p)`, whose faces k=0 are the patches.
template <typename BlockOfPatch>
std::vector<CreaseLine> creaseLines(const Plan& plan, const BlockOfPatch& blockOfPatch)
{
  std::vector<CreaseLine> lines;
  for (const PatchSeam& seam : wingFuselageSeams())
  {
    if (seam.crease)
    {
      const auto cells = plan.patchCells(seam.first.patch);
      const int direction = seam.first.side / 2;
      CreaseLine line;
      line.block = blockOfPatch(seam.first.patch);
      line.from[direction] = line.to[direction] = seam.first.side % 2 * cells[direction];
      line.to[1 - direction] = cells[1 - direction];
      lines.push_back(line);
    }
  }
  return lines;
}

WingFuselageLayout layoutOf(const Plan& plan)
{
  static constexpr const char* PatchNames[WingFuselagePatches] = { "nose", "top", "tail", "bottom", "leading_edge",
    "upper", "trailing_edge", "lower", "tip" };
  WingFuselageLayout layout;
  for (int p = 0; p < WingFuselagePatches; ++p)
  {
    const auto cells = plan.patchCells(p);
    for (int layer = 0; layer < LayersPerPatch; ++layer)
    {
      layout.counts.push_back({ cells[0] + 1, cells[1] + 1, plan.layerStart[layer + 1] - plan.layerStart[layer] + 1 });
      layout.names.push_back(std::string(PatchNames[p]) + "_" + std::to_string(layer));
    }
  }
  for (const Ijk& part : latticeBlocks())
  {
    Ijk counts;
    std::string name = layout.counts.size() < 40 ? "box" : "extension";
    for (int d = 0; d < 3; ++d)
    {
      counts[d] = plan.cells(d, part[d]) + 1;
      name += "_" + std::to_string(part[d]);
    }
    layout.counts.push_back(counts);
    layout.names.push_back(name);
  }

  layout.boundaryNames = { "wall_fuselage", "wall_wing", "symmetry", "farfield" };
  layout.interfaces = contacts(blockCorners(), layout.counts, [&](int block, int face) {
    const bool wall = block < Columns && face == 4;
    const int tag = wall ? (block / LayersPerPatch < 4 ? WallFuselage : WallWing) : face == 2 ? Symmetry : FarField;
    layout.boundaries.push_back({ block, face, wholeFace(layout.counts[block], face), tag });
  });
  layout.creases = creaseLines(plan, [](int patch) { return LayersPerPatch * patch; });
  return layout;
}

/// The body's control mesh: points and directions of the lines that start there.
class Wall
{
public:
  Wall(const Plan& plan, const std::vector<BodyPatch>& body, const Execution& run)
    : Layout(plan)
  {
    Index count = 0;
    for (int p = 0; p < WingFuselagePatches; ++p)
    {
      this->Offset[p] = count;
      const auto cells = plan.patchCells(p);
      count += Index(cells[0] + 1) * (cells[1] + 1);
    }
    this->Points.resize(count);
    this->Directions.resize(count);
    std::vector<Vec3> normals(count);
    for (int p = 0; p < WingFuselagePatches; ++p)
    {
      const auto cells = plan.patchCells(p);
      run.parallelFor(cells[1] + 1, 4, [&](Index begin, Index end) {
        for (int j = static_cast<int>(begin); j < end; ++j)
        {
          for (int i = 0; i <= cells[0]; ++i)
          {
            const SurfaceGeometry at =
              surfaceGeometry(body[p].surface, double(i) / cells[0], double(j) / cells[1], body[p].reversed);
            this->Points[this->index(p, i, j)] = at.point;
            normals[this->index(p, i, j)] = at.normal;
          }
        }
      });
    }
    this->joinSeams(count);
    this->makeDirections(normals);
    this->fit(run);
  }

  Index index(int patch, int i, int j) const
  {
    return this->Offset[patch] + i + Index(this->Layout.patchCells(patch)[0] + 1) * j;
  }
  const Vec3& point(int patch, int i, int j) const { return this->Points[this->index(patch, i, j)]; }
  const Vec3& direction(int patch, int i, int j) const { return this->Directions[this->index(patch, i, j)]; }

private:
  /// Point n of a side.
  Index sideIndex(const PatchSide& side, int n) const
  {
    const auto cells = this->Layout.patchCells(side.patch);
    const int fixed = side.side % 2 * cells[side.side / 2];
    return side.side < 2 ? this->index(side.patch, fixed, n) : this->index(side.patch, n, fixed);
  }

  /// Points that patches share become one.
  void joinSeams(Index count)
  {
    UnionFind sets(count);
    for (const PatchSeam& seam : wingFuselageSeams())
    {
      const int last = this->Layout.patchCells(seam.first.patch)[1 - seam.first.side / 2];
      for (int n = 0; n <= last; ++n)
      {
        sets.unite(this->sideIndex(seam.first, n), this->sideIndex(seam.second, seam.reversed ? last - n : n));
      }
    }
    this->Shared.resize(count);
    for (Index i = 0; i < count; ++i)
    {
      this->Shared[i] = sets.find(i);
      this->Points[i] = this->Points[this->Shared[i]];
    }
  }

  /// D at a point of the normals given: D . n = 1 for all of them, in the least-squares sense. Normals that differ by
  /// rounding only count as one.
  static Vec3 mitre(const std::vector<Vec3>& normals)
  {
    Eigen::Matrix3d products = 1e-4 * Eigen::Matrix3d::Identity();
    Vec3 sum = Vec3::Zero();
    for (const Vec3& n : normals)
    {
      products += n * n.transpose();
      sum += n;
    }
    return products.inverse() * sum;
  }

  /// First at the corners of the patches, then along their seams, then inside: what a corner or a seam adds to the
  /// normals of the next larger entity fades out along it.
  void makeDirections(const std::vector<Vec3>& normals)
  {
    const auto fade = [](double t) { return (1.0 - t) * (1.0 - t); };
    const auto tangential = [](const Vec3& x, const Vec3& n) -> Vec3 { return x - x.dot(n) * n; };

    std::map<Index, std::vector<Vec3>> atCorner;
    for (int p = 0; p < WingFuselagePatches; ++p)
    {
      const auto cells = this->Layout.patchCells(p);
      for (int v = 0; v < 4; ++v)
      {
        const Index i = this->index(p, (v & 1) * cells[0], (v >> 1) * cells[1]);
        atCorner[this->Shared[i]].push_back(normals[i]);
      }
    }
    for (const auto& corner : atCorner)
    {
      this->Directions[corner.first] = mitre(corner.second);
    }

    for (const PatchSeam& seam : wingFuselageSeams())
    {
      const int last = this->Layout.patchCells(seam.first.patch)[1 - seam.first.side / 2];
      const auto at = [&](int n) { return this->sideIndex(seam.first, n); };
      const auto own = [&](int n) {
        return mitre({ normals[at(n)], normals[this->sideIndex(seam.second, seam.reversed ? last - n : n)] });
      };
      const Vec3 first = this->Directions[this->Shared[at(0)]] - own(0);
      const Vec3 final = this->Directions[this->Shared[at(last)]] - own(last);
      for (int n = 1; n < last; ++n)
      {
        const double t = double(n) / last;
        Vec3 added = fade(t) * first + fade(1.0 - t) * final;
        if (seam.crease)
        {
          const Vec3 along = (this->Points[at(n + 1)] - this->Points[at(n - 1)]).normalized();
          added = along.dot(added) * along;
        }
        else
        {
          added = tangential(added, normals[at(n)]);
        }
        this->Directions[this->Shared[at(n)]] = own(n) + added;
      }
    }
    for (int p = 0; p < 4; ++p)
    {
      for (int i = 0; i <= this->Layout.patchCells(p)[0]; ++i)
      {
        Vec3& direction = this->Directions[this->Shared[this->index(p, i, 0)]];
        direction = normals[this->index(p, i, 0)];
        direction[1] = 0.0;
      }
    }

    for (int p = 0; p < WingFuselagePatches; ++p)
    {
      const auto cells = this->Layout.patchCells(p);
      std::array<std::vector<Vec3>, 4> sides;
      for (int side = 0; side < 4; ++side)
      {
        for (int n = 0; n <= cells[1 - side / 2]; ++n)
        {
          const Index i = this->sideIndex({ p, side }, n);
          sides[side].push_back(tangential(this->Directions[this->Shared[i]], normals[i]));
        }
      }
      for (int j = 1; j < cells[1]; ++j)
      {
        const double g0 = fade(double(j) / cells[1]), g1 = fade(1.0 - double(j) / cells[1]);
        for (int i = 1; i < cells[0]; ++i)
        {
          const double f0 = fade(double(i) / cells[0]), f1 = fade(1.0 - double(i) / cells[0]);
          const Vec3 added = f0 * sides[0][j] + f1 * sides[1][j] + g0 * sides[2][i] + g1 * sides[3][i] -
            f0 * (g0 * sides[0].front() + g1 * sides[0].back()) - f1 * (g0 * sides[1].front() + g1 * sides[1].back());
          const Index at = this->index(p, i, j);
          this->Directions[at] = normals[at] + tangential(added, normals[at]);
        }
      }
    }
    for (std::size_t i = 0; i < this->Directions.size(); ++i)
    {
      this->Directions[i] = this->Directions[this->Shared[i]];
    }
  }

  /// Makes the points the control mesh of a surface through them: on a shell of one layer of cells.
  void fit(const Execution& run)
  {
    // Thin, as its cells must be valid at the trailing edge too.
    const double thickness = 0.01 / this->Layout.patchCells(0)[0];
    BlockMesh shell;
    std::vector<std::vector<double>> memory(WingFuselagePatches);
    std::vector<std::array<int, 8>> corners;
    std::vector<Ijk> counts;
    for (int p = 0; p < WingFuselagePatches; ++p)
    {
      const auto cells = this->Layout.patchCells(p);
      counts.push_back({ cells[0] + 1, cells[1] + 1, 2 });
      for (int k = 0; k < 2; ++k)
      {
        for (int j = 0; j <= cells[1]; ++j)
        {
          for (int i = 0; i <= cells[0]; ++i)
          {
            const Vec3 x = this->point(p, i, j) + k * thickness * this->direction(p, i, j);
            memory[p].insert(memory[p].end(), x.data(), x.data() + 3);
          }
        }
      }
      MeshBlock block;
      block.points = GridView(memory[p].data(), counts.back());
      block.name = "patch " + std::to_string(p);
      shell.blocks.push_back(block);
      corners.push_back(blockCorners()[LayersPerPatch * p]);
    }
    shell.boundaryNames = { "wall", "symmetry", "outside" };
    shell.interfaces = contacts(corners, counts, [&](int block, int face) {
      shell.boundaries.push_back({ block, face, wholeFace(counts[block], face), face == 4 ? 0 : face == 2 ? 1 : 2 });
    });
    shell.creases = creaseLines(this->Layout, [](int patch) { return patch; });

    BlockComplexOptions options;
    options.findInterfaces = false;
    BlockComplex complex = buildBlockComplex(shell, options, run);
    ConversionOptions conversion;
    conversion.roles = { BoundaryRole::Body, BoundaryRole::Symmetry, BoundaryRole::Other };
    fitBody(complex, conversion, {}, run);
    for (const ComplexBlock& block : complex.blocks)
    {
      const int p = block.parent;
      for (int j = 0; j <= block.cells(1); ++j)
      {
        for (int i = 0; i <= block.cells(0); ++i)
        {
          this->Points[this->index(p, i, j)] = block.points(i, j, 0);
        }
      }
    }
  }

  const Plan& Layout;
  std::array<Index, WingFuselagePatches> Offset{};
  std::vector<Index> Shared;
  std::vector<Vec3> Points;
  std::vector<Vec3> Directions;
};

/// Writes layers layerStart[layer].. of the lines above a patch.
void columnPoints(const Plan& plan, const Wall& wall, int patch, int layer, double* points, const Execution& run)
{
  const auto cells = plan.patchCells(patch);
  const int first = plan.layerStart[layer];
  const int rows = cells[1] + 1;
  const int count = plan.layerStart[layer + 1] - first + 1;
  run.parallelFor(Index(rows) * count, 8, [&](Index begin, Index end) {
    for (Index row = begin; row < end; ++row)
    {
      const int j = static_cast<int>(row % rows);
      const int k = first + static_cast<int>(row / rows);
      const double t = plan.layers[k] / plan.layers.back();
      for (int i = 0; i <= cells[0]; ++i)
      {
        const Vec3 box = plan.boxPoint(patch, i, j);
        const Vec3& start = wall.point(patch, i, j);
        Vec3 x = start;
        if (k + 1 == static_cast<int>(plan.layers.size()))
        {
          x = box;
        }
        else if (k > 0)
        {
          x += WallReach * t * (1.0 - t) * (1.0 - t) * wall.direction(patch, i, j) +
            t * t * (3.0 - 2.0 * t) * (box - start) - BoxReach * t * t * (1.0 - t) * plan.boxNormal(box);
        }
        std::copy_n(x.data(), 3, points + 3 * (i + (cells[0] + 1) * row));
      }
    }
  });
}

} // namespace

Index WingFuselageLayout::points() const
{
  Index sum = 0;
  for (const Ijk& count : this->counts)
  {
    sum += Index(count[0]) * count[1] * count[2];
  }
  return sum;
}

WingFuselageLayout wingFuselageLayout(const WingFuselageOptions& options)
{
  return layoutOf(Plan(options));
}

void wingFuselagePoints(const WingFuselageOptions& options, const std::vector<BodyPatch>& body,
  const std::vector<double*>& blocks, const Execution& run)
{
  const Plan plan(options);
  if (std::any_of(blocks.begin(), blocks.begin() + Columns, [](const double* points) { return points; }))
  {
    Execution alone = run;
    alone.ranks = aloneRank();
    const Wall wall(plan, body, alone);
    for (int block = 0; block < Columns; ++block)
    {
      run.report(double(block) / static_cast<double>(blocks.size()));
      if (blocks[block])
      {
        columnPoints(plan, wall, block / LayersPerPatch, block % LayersPerPatch, blocks[block], run);
      }
    }
  }
  int block = Columns;
  for (const Ijk& part : latticeBlocks())
  {
    run.report(double(block) / static_cast<double>(blocks.size()));
    double* points = blocks[block++];
    if (!points)
    {
      continue;
    }
    Ijk start, counts;
    for (int d = 0; d < 3; ++d)
    {
      start[d] = plan.start[d][part[d]];
      counts[d] = plan.cells(d, part[d]) + 1;
    }
    run.parallelFor(Index(counts[1]) * counts[2], 8, [&](Index begin, Index end) {
      for (Index row = begin; row < end; ++row)
      {
        for (int i = 0; i < counts[0]; ++i)
        {
          double* x = points + 3 * (i + counts[0] * row);
          x[0] = plan.coordinates[0][start[0] + i];
          x[1] = plan.coordinates[1][start[1] + row % counts[1]];
          x[2] = plan.coordinates[2][start[2] + row / counts[1]];
        }
      }
    });
  }
}

} // namespace bsv
