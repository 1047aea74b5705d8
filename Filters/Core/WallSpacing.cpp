// SPDX-License-Identifier: BSD-3-Clause
#include "WallSpacing.h"

#include "BSplineVolume.h"
#include "BlockSurface.h"
#include "EdgeFans.h"
#include "FarField.h"
#include "OrderFreeSum.h"
#include "Sampling.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <sstream>

namespace bsv
{
namespace
{

constexpr double NaN = std::numeric_limits<double>::quiet_NaN();

/// Control points of one direction at the wall that the first two spans and the first cell behind them depend on.
constexpr int Depth = 6;

/// The cubic basis on clamped integer knots at u in [0, cells]: four values, that of control point `first` first.
struct Basis
{
  int first;
  std::array<double, 4> values;

  Basis(int cells, double u)
  {
    const int span = std::min(static_cast<int>(u), cells - 1);
    const auto knot = [cells](int i) { return static_cast<double>(std::min(std::max(i - 3, 0), cells)); };
    double left[4], right[4];
    for (int j = 1; j <= 3; ++j)
    {
      left[j] = u - knot(span + 4 - j);
      right[j] = knot(span + 3 + j) - u;
    }
    basisFunctions(3, 0, left, right, this->values.data());
    this->first = span;
  }
};

/// The basis at knot u = m: what the reversed direction has at cells - m, mirrored bit for bit.
Basis basisAtKnot(int cells, int m)
{
  if (2 * m > cells)
  {
    Basis basis = basisAtKnot(cells, cells - m);
    std::reverse(basis.values.begin(), basis.values.end());
    basis.first = cells - 1 - basis.first;
    return basis;
  }
  Basis basis(cells, m);
  if (2 * m == cells)
  {
    basis.values[0] = basis.values[2] = 0.5 * (basis.values[0] + basis.values[2]);
  }
  return basis;
}

/// The curve that rises from a wall vertex: its first control points.
struct Column
{
  int cells = 0;
  std::array<Vec3, Depth> points;

  Vec3 at(double u) const
  {
    const Basis basis(this->cells, u);
    Vec3 x = Vec3::Zero();
    for (int i = 0; i < 4; ++i)
    {
      x += basis.values[i] * this->points[basis.first + i];
    }
    return x;
  }
  double firstHeight(int level) const { return (this->at(std::ldexp(1.0, -level)) - this->points[0]).norm(); }

  /// Largest ratio, or its inverse, of neighbouring cells up to the first one behind the second span.
  double growth(int level) const
  {
    const double step = std::ldexp(1.0, -level);
    const int last = std::min(2, this->cells) * (1 << level) + (this->cells > 2 ? 1 : 0);
    double largest = 1.0, before = 0.0;
    Vec3 x = this->points[0];
    for (int i = 1; i <= last; ++i)
    {
      const Vec3 next = this->at(i * step);
      const double cell = (next - x).norm();
      if (i > 1)
      {
        largest = std::max({ largest, cell / before, before / cell });
      }
      before = cell;
      x = next;
    }
    return largest;
  }
};

/// A mesh line as a curve: the column of its points, with the inserted one at the fraction `e` = 1 - c.
Column lineColumn(const std::vector<Vec3>& line, double e)
{
  Column column;
  column.cells = static_cast<int>(line.size()) - 1;
  const int cells = column.cells;
  for (int a = 0; a < std::min(Depth, cells + 3); ++a)
  {
    column.points[a] = a == 0 ? line[0]
      : a == 1                ? Vec3(line[0] + e * (line[1] - line[0]))
      : a <= cells            ? line[a - 1]
      : a == cells + 1        ? Vec3((2.0 * line[cells] + line[cells - 1]) / 3.0)
                              : line[cells];
  }
  return column;
}

/// c from what keeps cells apart to what keeps the layer off the wall, as 1 - c.
constexpr double Least = 0.02, Most = 0.98;

/// 1 - c of the line that makes the first cell as high as `target`, not limited.
double neededFraction(const std::vector<Vec3>& line, double target, int level)
{
  const double near = lineColumn(line, 0.0).firstHeight(level);
  const double far = lineColumn(line, 1.0).firstHeight(level);
  return far > near ? (target - near) / (far - near) : -1.0;
}

/// 1 - c that matches the growth of the layers, as in FirstLayer.h.
double smoothFraction(const std::vector<Vec3>& line)
{
  const double first = (line[1] - line[0]).norm();
  const double second = line.size() > 2 ? (line[2] - line[1]).norm() : first;
  const double growth = first > 0.0 ? std::min(std::max(second / first, 0.2), 20.0) : 1.0;
  return 1.0 / (3.0 + std::log(growth));
}

class WallModel
{
public:
  WallModel(const BlockMesh& mesh, const BlockComplex& complex, const ConversionOptions& conversion,
    const WallSpacingOptions& options, const Execution& run, WallSpacingResult& result)
    : Complex(complex)
    , Conversion(conversion)
    , Options(options)
    , Run(run)
    , Result(result)
  {
    result.spacingPoints.resize(mesh.blocks.size());
    std::map<std::array<double, 3>, Index> numbers;
    for (const ComplexFace& face : complex.faces)
    {
      if (roleOf(conversion, face) != BoundaryRole::Body)
      {
        continue;
      }
      const FaceUse& use = face.uses.front();
      WallSpacingResult::Side side{ use.block, use.face, {} };
      for (int t = 0; t <= this->cells(use, 1); ++t)
      {
        for (int s = 0; s <= this->cells(use, 0); ++s)
        {
          const Vec3 x = this->point(use, s, t, 0);
          const auto found = numbers.emplace(std::array<double, 3>{ x[0], x[1], x[2] }, result.points.size());
          if (found.second)
          {
            result.points.push_back(x);
          }
          side.vertices.push_back(found.first->second);
        }
      }
      this->Tags.push_back(face.tag);
      result.sides.push_back(std::move(side));
      const int parent = complex.blocks[use.block].parent;
      result.spacingPoints[parent].assign(mesh.blocks[parent].points.size(), NaN);
    }
    if (result.sides.empty())
    {
      throw Error("the mesh has no wall: none of its boundaries is part of the body");
    }
    this->Conversion.wallOnly = true;
    this->Conversion.wallSpacingPoints.clear();
    for (const std::vector<double>& points : result.spacingPoints)
    {
      this->Conversion.wallSpacingPoints.push_back(points.empty() ? nullptr : points.data());
    }
    for (const ComplexBlock& block : complex.blocks)
    {
      // Not initialised: only what lies near the wall is ever touched.
      const Index count = Index(block.cells(0) + 3) * (block.cells(1) + 3) * (block.cells(2) + 3);
      this->Points.emplace_back(new double[3 * count]);
      this->Codes.emplace_back(new std::uint8_t[count]);
      this->Nets.push_back({ this->Points.back().get(), this->Codes.back().get() });
    }
  }

  /// Boundary layers by the distance from the foremost point of each boundary.
  void measureLayers()
  {
    const Vec3 direction = this->Options.direction.normalized();
    std::map<int, double> foremost;
    for (std::size_t i = 0; i < this->Tags.size(); ++i)
    {
      for (const Index v : this->Result.sides[i].vertices)
      {
        const double along = direction.dot(this->Result.points[v]);
        const auto entry = foremost.emplace(this->Tags[i], along).first;
        entry->second = std::min(entry->second, along);
      }
    }
    const double least = this->Options.minimumDistance * this->Options.flow.referenceLength;
    std::vector<double> distances(this->Result.points.size(), std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < this->Tags.size(); ++i)
    {
      for (const Index v : this->Result.sides[i].vertices)
      {
        const double along = direction.dot(this->Result.points[v]) - foremost.at(this->Tags[i]);
        distances[v] = std::min(distances[v], std::max(along, least));
      }
    }
    for (const double distance : distances)
    {
      this->Result.layers.push_back(plateLayer(this->Options.flow, distance));
    }
  }

  double target(Index vertex) const
  {
    return heightOf(this->Options.flow, this->Result.layers[vertex].skinFriction, this->Options.targetYPlus);
  }

  /// First guess of c from each mesh line alone; where cells would grow too fast, what the growth allows, for good.
  void guess()
  {
    const std::size_t count = this->Result.points.size();
    this->Result.spacing.assign(count, 0.0);
    this->Result.reachingLevel.assign(count, -1);
    this->Result.allowed.assign(count, 1);
    this->FirstCell.assign(count, 0.0);
    std::array<bool, MaxSamplingLevel + 1> all;
    all.fill(true);
    std::array<double, 2> worst{ 0.0, 1.0 }; // height of a line and target
    // A vertex lies on lines of several blocks at edges of the body: the largest c counts there.
    for (const WallSpacingResult::Side& side : this->Result.sides)
    {
      const FaceUse use{ side.block, side.face };
      const int ns = this->cells(use, 0) + 1;
      std::vector<Guess> guesses(side.vertices.size());
      this->Run.parallelFor(static_cast<Index>(guesses.size()), 16, [&](Index begin, Index end) {
        for (Index i = begin; i < end; ++i)
        {
          guesses[i] = this->guessAt(this->line(use, int(i % ns), int(i / ns)), this->target(side.vertices[i]));
        }
      });
      for (std::size_t i = 0; i < guesses.size(); ++i)
      {
        const Index v = side.vertices[i];
        const Guess& guess = guesses[i];
        int reaching = -1;
        for (int level = MaxSamplingLevel; level >= 0; --level)
        {
          reaching = guess.reaches[level] ? level : reaching;
          all[level] = all[level] && guess.reaches[level];
        }
        this->Result.reachingLevel[v] = std::max(this->Result.reachingLevel[v], reaching);
        if (guess.fixed && guess.height / this->target(v) > worst[0] / worst[1])
        {
          worst = { guess.height, this->target(v) };
          this->PresentLayers = this->rise(use);
        }
        if (guess.spacing > this->Result.spacing[v] ||
          (guess.spacing == this->Result.spacing[v] && guess.firstCell < this->FirstCell[v]))
        {
          this->Result.spacing[v] = guess.spacing;
          this->Result.allowed[v] = guess.fixed ? 0 : 1;
          this->FirstCell[v] = guess.firstCell;
        }
      }
    }
    for (int level = MaxSamplingLevel; level >= 0; --level)
    {
      this->Result.levelForAll = all[level] ? level : this->Result.levelForAll;
    }
    if (worst[0] > 0.0)
    {
      this->Result.layersForAll = this->layersFor(worst[0], worst[1]);
    }
  }

  /// Converts the wall and measures it.
  void measure()
  {
    this->writeSpacing();
    convertToBSplineVolume(this->Complex, this->Conversion, this->Nets, this->quiet());
    const std::size_t count = this->Result.points.size();
    this->Result.firstHeight.assign(count, std::numeric_limits<double>::infinity());
    this->Result.growth.assign(count, 1.0);
    // A vertex of several faces is measured in each of them, equal up to rounding.
    for (const WallSpacingResult::Side& side : this->Result.sides)
    {
      const int ns = this->cells({ side.block, side.face }, 0) + 1;
      std::vector<std::array<double, 2>> values(side.vertices.size());
      this->Run.parallelFor(static_cast<Index>(values.size()), 64, [&](Index begin, Index end) {
        for (Index i = begin; i < end; ++i)
        {
          const Column column = this->column({ side.block, side.face }, int(i % ns), int(i / ns));
          values[i] = { column.firstHeight(this->Options.level), column.growth(this->Options.level) };
        }
      });
      for (std::size_t i = 0; i < values.size(); ++i)
      {
        double& height = this->Result.firstHeight[side.vertices[i]];
        double& growth = this->Result.growth[side.vertices[i]];
        height = std::min(height, values[i][0]);
        growth = std::max(growth, values[i][1]);
      }
    }
  }

  /// Improves c where it is free. Returns the largest relative error of the height there.
  double improve()
  {
    // Height per 1 - c in first cells, if the neighbours do the same: that of a straight line.
    const std::vector<Vec3> unit{ Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0), Vec3(3, 0, 0) };
    const double effect = lineColumn(unit, 1.0).firstHeight(this->Options.level) -
      lineColumn(unit, 0.0).firstHeight(this->Options.level);
    double worst = 0.0;
    for (std::size_t v = 0; v < this->Result.points.size(); ++v)
    {
      if (this->Result.allowed[v] == 0 || !(this->FirstCell[v] > 0.0))
      {
        continue;
      }
      const double error = this->target(v) - this->Result.firstHeight[v];
      worst = std::max(worst, std::abs(error) / this->target(v));
      const double e = 1.0 - this->Result.spacing[v] + error / (effect * this->FirstCell[v]);
      this->Result.spacing[v] = 1.0 - std::min(std::max(e, Least), Most);
    }
    return worst;
  }

  void finish()
  {
    WallSpacingResult& result = this->Result;
    const std::size_t count = result.points.size();
    double low = std::numeric_limits<double>::infinity(), high = 0.0;
    for (std::size_t v = 0; v < count; ++v)
    {
      result.yPlus.push_back(yPlus(this->Options.flow, result.layers[v].skinFriction, result.firstHeight[v]));
      low = std::min(low, result.yPlus[v]);
      high = std::max(high, result.yPlus[v]);
      const double error = std::abs(result.yPlus[v] / this->Options.targetYPlus - 1.0);
      result.reached += error <= WallSpacingResult::Accuracy ? 1 : 0;
    }
    result.cells.assign(count, std::numeric_limits<double>::infinity());
    for (const WallSpacingResult::Side& side : result.sides)
    {
      const int ns = this->cells({ side.block, side.face }, 0) + 1;
      for (std::size_t i = 0; i < side.vertices.size(); ++i)
      {
        const Index v = side.vertices[i];
        result.cells[v] = std::min(result.cells[v],
          this->cellsWithin({ side.block, side.face }, int(i) % ns, int(i) / ns, result.layers[v].thickness));
      }
    }
    if (result.reached < static_cast<Index>(count))
    {
      std::ostringstream text;
      text << "the first cell has the y+ " << this->Options.targetYPlus << " within 1 % at " << result.reached << " of "
           << count << " wall points at Level " << this->Options.level << " with a growth of at most "
           << this->Options.maximumGrowth << "; it is " << low << " to " << high << ". ";
      if (this->Result.levelForAll >= 0 && this->Result.levelForAll != this->Options.level)
      {
        text << "Level " << this->Result.levelForAll << " would reach it everywhere";
      }
      else if (this->Result.layersForAll > 0)
      {
        text << "No level up to " << MaxSamplingLevel << " would reach it everywhere; " << this->Result.layersForAll
             << " layers of constant growth instead of " << this->PresentLayers
             << " in the blocks at the wall would, at Level " << this->Options.level;
      }
      else
      {
        text << "What changes from point to point on the wall is too rough there";
      }
      result.warning = text.str();
    }
  }

private:
  int cells(const FaceUse& use, int axis) const
  {
    return this->Complex.blocks[use.block].cells(faceAxis(use.face, axis));
  }
  int rise(const FaceUse& use) const { return this->Complex.blocks[use.block].cells(faceDirection(use.face)); }

  Vec3 point(const FaceUse& use, int s, int t, int depth) const
  {
    const ComplexBlock& owner = this->Complex.blocks[use.block];
    const Ijk cells{ owner.cells(0), owner.cells(1), owner.cells(2) };
    Ijk ijk = facePoint(cells, use.face, s, t);
    const int normal = faceDirection(use.face);
    ijk[normal] = faceSide(use.face) ? cells[normal] - depth : depth;
    return owner.points(ijk);
  }

  /// The first points of the mesh line that rises at (s, t), as many as a Column needs.
  std::vector<Vec3> line(const FaceUse& use, int s, int t) const
  {
    std::vector<Vec3> line;
    for (int k = 0; k <= this->rise(use); ++k)
    {
      line.push_back(this->point(use, s, t, k));
    }
    return line;
  }

  void writeSpacing()
  {
    for (const WallSpacingResult::Side& side : this->Result.sides)
    {
      const ComplexBlock& owner = this->Complex.blocks[side.block];
      const Ijk cells{ owner.cells(0), owner.cells(1), owner.cells(2) };
      const int ns = cells[faceAxis(side.face, 0)] + 1;
      std::vector<double>& values = this->Result.spacingPoints[owner.parent];
      for (std::size_t i = 0; i < side.vertices.size(); ++i)
      {
        const Ijk ijk = facePoint(cells, side.face, int(i) % ns, int(i) / ns);
        Index at = 0;
        for (int d = 0; d < 3; ++d)
        {
          at += owner.points.stride(d) * (owner.offset[d] + ijk[d]);
        }
        values[at] = this->Result.spacing[side.vertices[i]];
      }
    }
  }

  /// Control point of a block; inside, where it is a copy of a mesh point, the mesh point.
  Vec3 controlPoint(int block, const Ijk& position) const
  {
    const ComplexBlock& owner = this->Complex.blocks[block];
    bool inside = true;
    Ijk ijk;
    for (int d = 0; d < 3; ++d)
    {
      inside = inside && position[d] >= 2 && position[d] <= owner.cells(d);
      ijk[d] = position[d] - 1;
    }
    if (inside)
    {
      return owner.points(ijk);
    }
    const Index at =
      position[0] + Index(owner.cells(0) + 3) * (position[1] + Index(owner.cells(1) + 3) * position[2]);
    return Vec3(Eigen::Map<const Vec3>(this->Nets[block].points + 3 * at));
  }

  /// The curve of the volume that rises at (s, t).
  Column column(const FaceUse& use, int s, int t) const
  {
    const ComplexBlock& owner = this->Complex.blocks[use.block];
    const int first = faceAxis(use.face, 0), second = faceAxis(use.face, 1), normal = faceDirection(use.face);
    const Basis alongS = basisAtKnot(owner.cells(first), s), alongT = basisAtKnot(owner.cells(second), t);
    Column column;
    column.cells = owner.cells(normal);
    OrderFreeSum sum;
    for (int a = 0; a < std::min(Depth, column.cells + 3); ++a)
    {
      sum.clear();
      for (int j = 0; j < 4; ++j)
      {
        for (int i = 0; i < 4; ++i)
        {
          const double weight = alongS.values[i] * alongT.values[j];
          if (weight != 0.0)
          {
            Ijk position;
            position[first] = alongS.first + i;
            position[second] = alongT.first + j;
            position[normal] = faceSide(use.face) ? column.cells + 2 - a : a;
            sum.add(weight, this->controlPoint(use.block, position));
          }
        }
      }
      column.points[a] = sum.result(1.0);
    }
    return column;
  }

  /// Sampled cells up to a distance from the wall, along the mesh line and on into the next blocks.
  double cellsWithin(FaceUse use, int s, int t, double distance) const
  {
    const double perSpan = std::ldexp(1.0, this->Options.level);
    const Column column = this->column(use, s, t);
    const int own = std::min(2, column.cells);
    const double step = 1.0 / perSpan;
    double height = 0.0;
    Vec3 x = column.points[0];
    for (int i = 1; i <= own * (1 << this->Options.level); ++i)
    {
      const Vec3 next = column.at(i * step);
      const double cell = (next - x).norm();
      if (height + cell > distance)
      {
        return i - 1 + (distance - height) / cell;
      }
      height += cell;
      x = next;
    }
    double count = own * perSpan;
    for (std::size_t steps = 0; steps <= this->Complex.blocks.size(); ++steps)
    {
      for (int k = steps == 0 ? own : 0; k < this->rise(use); ++k)
      {
        const double span = (this->point(use, s, t, k + 1) - this->point(use, s, t, k)).norm();
        if (height + span > distance)
        {
          return count + perSpan * (distance - height) / span;
        }
        height += span;
        count += perSpan;
      }
      const FaceContact next = contactOf(this->Complex, use.block, use.face ^ 1);
      if (next.block < 0)
      {
        break;
      }
      const auto st = mapFacePoint(next.orientation, s, t, this->cells(use, 0), this->cells(use, 1));
      use = { next.block, next.face };
      s = st[0];
      t = st[1];
    }
    return count;
  }

  /// What one mesh line tells.
  struct Guess
  {
    double spacing = 0.0;
    double firstCell = 0.0;
    /// The growth does not allow the target.
    bool fixed = false;
    /// Length of the line, if so.
    double height = 0.0;
    std::array<bool, MaxSamplingLevel + 1> reaches{};
  };

  bool allows(const std::vector<Vec3>& line, double e, int level) const
  {
    return e > Least && e < Most && lineColumn(line, e).growth(level) <= this->Options.maximumGrowth;
  }

  /// How many layers of constant growth, the first sampled cell being the target, fill a height as the growth allows.
  /// 0 if there are too many to count.
  int layersFor(double height, double target) const
  {
    constexpr int TooMany = 2000;
    const int level = this->Options.level;
    const double g = std::pow(this->Options.maximumGrowth, std::ldexp(1.0, level));
    // Sum of the layers that grow by `ratio`, over their first sampled cell.
    const auto total = [&](double ratio, int layers) {
      const double root = std::pow(ratio, std::ldexp(1.0, -level));
      return std::expm1(layers * std::log(ratio)) / (root - 1.0);
    };
    for (int layers = 1; layers < TooMany; ++layers)
    {
      double low = 1.0 + 1e-9, high = g;
      if (total(high, layers) * target < height)
      {
        continue;
      }
      for (int step = 0; step < 60; ++step)
      {
        const double middle = 0.5 * (low + high);
        (total(middle, layers) * target < height ? low : high) = middle;
      }
      std::vector<Vec3> line{ Vec3::Zero() };
      for (int k = 1; k <= layers; ++k)
      {
        line.push_back(Vec3(total(low, k) * target, 0.0, 0.0));
      }
      if (this->allows(line, neededFraction(line, target, level), level))
      {
        return layers;
      }
    }
    return 0;
  }

  Guess guessAt(const std::vector<Vec3>& line, double target) const
  {
    const auto allows = [&](double e, int level) { return this->allows(line, e, level); };
    Guess guess;
    for (int level = 0; level <= MaxSamplingLevel; ++level)
    {
      guess.reaches[level] = allows(neededFraction(line, target, level), level);
    }
    const int level = this->Options.level;
    const double needed = neededFraction(line, target, level);
    double e = needed;
    guess.fixed = !guess.reaches[level];
    if (guess.fixed)
    {
      e = std::min(std::max(smoothFraction(line), Least), Most);
      double bad = std::min(std::max(needed, Least), Most);
      for (int step = 0; step < 40 && allows(e, level); ++step)
      {
        const double middle = 0.5 * (e + bad);
        (allows(middle, level) ? e : bad) = middle;
      }
      for (std::size_t k = 1; k < line.size(); ++k)
      {
        guess.height += (line[k] - line[k - 1]).norm();
      }
    }
    guess.spacing = 1.0 - e;
    guess.firstCell = (line[1] - line[0]).norm();
    return guess;
  }

  Execution quiet() const
  {
    Execution run = this->Run;
    run.progress = [this](double) { return this->Run.progress(this->Progress); };
    return run;
  }

public:
  double Progress = 0.0;

private:
  const BlockComplex& Complex;
  ConversionOptions Conversion;
  const WallSpacingOptions& Options;
  const Execution& Run;
  WallSpacingResult& Result;
  std::vector<int> Tags;
  std::vector<double> FirstCell;
  std::vector<std::unique_ptr<double[]>> Points;
  std::vector<std::unique_ptr<std::uint8_t[]>> Codes;
  std::vector<ControlNetStorage> Nets;
  int PresentLayers = 0;
};

} // namespace

WallSpacingResult wallSpacing(const BlockMesh& mesh, const BlockComplex& complex, const ConversionOptions& conversion,
  const WallSpacingOptions& options, const Execution& run)
{
  referenceState(options.flow); // checks it
  const auto check = [](bool right, const char* name, double value, const char* what) {
    if (!right)
    {
      throw Error(std::string(name) + " " + text(value) + " is not " + what);
    }
  };
  check(options.targetYPlus > 0.0 && std::isfinite(options.targetYPlus), "Target Y Plus", options.targetYPlus,
    "above 0");
  check(options.minimumDistance > 0.0 && std::isfinite(options.minimumDistance), "Minimum Distance",
    options.minimumDistance, "above 0");
  check(options.maximumGrowth > 1.0 && std::isfinite(options.maximumGrowth), "Maximum Growth", options.maximumGrowth,
    "above 1");
  check(options.level >= 0 && options.level <= MaxSamplingLevel, "Level", options.level, "in 0..8");
  check(options.direction.allFinite() && options.direction.norm() > 0.0, "Flow Direction", options.direction.norm(),
    "a direction");

  WallSpacingResult result;
  WallModel wall(mesh, complex, conversion, options, run, result);
  wall.measureLayers();
  wall.guess();
  // Each step leaves about 8/9 of the roughest errors and next to nothing of smooth ones.
  constexpr int Steps = 40;
  constexpr double Enough = 0.1 * WallSpacingResult::Accuracy;
  wall.measure();
  for (int step = 0; step < Steps && wall.improve() > Enough; ++step)
  {
    wall.Progress = static_cast<double>(step + 1) / Steps;
    wall.measure();
  }
  wall.finish();
  run.report(1.0);
  return result;
}

} // namespace bsv
