// SPDX-License-Identifier: BSD-3-Clause
#include "Wall/WallSpacing.h"

#include "Base/OrderFreeSum.h"
#include "Complex/EdgeFans.h"
#include "Complex/SurfacePointKey.h"
#include "Conversion/FarField.h"
#include "Mesh/BlockSurface.h"
#include "Ranks/Ranks.h"
#include "Volume/BSplineVolume.h"
#include "Volume/Sampling.h"
#include "Wall/WallColumn.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <sstream>
#include <tuple>

namespace bsv
{
namespace
{

constexpr double NaN = std::numeric_limits<double>::quiet_NaN();
constexpr double Infinity = std::numeric_limits<double>::infinity();

/// c from what keeps cells apart to what keeps the layer off the wall, as 1 - c.
constexpr double Least = 0.02, Most = 0.98;

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
    const int rank = run.ranks->rank();
    result.spacingPoints.resize(mesh.blocks.size());
    this->Nets.resize(complex.blocks.size());
    std::map<SurfacePointKey, Index> numbers;
    bool wall = false;
    for (std::size_t f = 0; f < complex.faces.size(); ++f)
    {
      const ComplexFace& face = complex.faces[f];
      if (roleOf(conversion, face) != BoundaryRole::Body)
      {
        continue;
      }
      wall = true;
      const FaceUse& use = face.uses.front();
      if (complex.blocks[use.block].rank != rank)
      {
        continue;
      }
      WallSpacingResult::Side side{ use.block, use.face, {} };
      for (int t = 0; t <= this->cells(use, 1); ++t)
      {
        for (int s = 0; s <= this->cells(use, 0); ++s)
        {
          const Vec3 x = this->point(use, s, t, 0);
          const SurfacePointKey key = surfacePointKey(complex, use, s, t);
          const auto found = numbers.emplace(key, result.points.size());
          if (found.second)
          {
            result.points.push_back(x);
            this->Keys.push_back(key);
          }
          side.vertices.push_back(found.first->second);
        }
      }
      this->Faces.push_back(static_cast<int>(f));
      result.sides.push_back(std::move(side));
      const int parent = complex.blocks[use.block].parent;
      result.spacingPoints[parent].assign(mesh.blocks[parent].points.size(), NaN);
    }
    for (std::size_t b = 0; b < complex.blocks.size(); ++b)
    {
      const ComplexBlock& block = complex.blocks[b];
      if (block.rank == rank)
      {
        // Not initialised: only what lies near the wall is ever touched.
        const Index count = Index(block.cells(0) + 3) * (block.cells(1) + 3) * (block.cells(2) + 3);
        this->Points.emplace_back(new double[3 * count]);
        this->Codes.emplace_back(new std::uint8_t[count]);
        this->Nets[b] = { this->Points.back().get(), this->Codes.back().get() };
      }
    }
    if (!wall)
    {
      throw Error("the mesh has no wall: none of its boundaries is part of the body");
    }
    this->findShared();
    this->Conversion.wallOnly = true;
    this->Conversion.setSingleKnots();
    this->Conversion.wallSpacingPoints.clear();
    for (const std::vector<double>& points : result.spacingPoints)
    {
      this->Conversion.wallSpacingPoints.push_back(points.empty() ? nullptr : points.data());
    }
  }

  /// Boundary layers by the distance from the foremost point of each boundary.
  void measureLayers()
  {
    const Vec3 direction = this->Options.direction.normalized();
    struct Foremost
    {
      int tag;
      double along;
    };
    std::map<int, double> foremost;
    const auto toTheFront = [&](int tag, double along) {
      const auto entry = foremost.emplace(tag, along).first;
      entry->second = std::min(entry->second, along);
    };
    for (std::size_t i = 0; i < this->Result.sides.size(); ++i)
    {
      for (const Index v : this->Result.sides[i].vertices)
      {
        toTheFront(this->tag(i), direction.dot(this->Result.points[v]));
      }
    }
    std::vector<Foremost> mine;
    mine.reserve(foremost.size());
    for (const auto& [tag, along] : foremost)
    {
      mine.push_back({ tag, along });
    }
    for (const Foremost& entry : this->Run.ranks->gatherAll(mine))
    {
      toTheFront(entry.tag, entry.along);
    }
    const double least = this->Options.minimumDistance * this->Options.flow.referenceLength;
    std::vector<double> distances(this->Result.points.size(), Infinity);
    for (std::size_t i = 0; i < this->Result.sides.size(); ++i)
    {
      for (const Index v : this->Result.sides[i].vertices)
      {
        const double along = direction.dot(this->Result.points[v]) - foremost.at(this->tag(i));
        distances[v] = std::min(distances[v], std::max(along, least));
      }
    }
    this->agree(distances, std::less<double>());
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
    this->Result.reachingLevel.assign(count, -1);
    // A vertex lies on lines of several blocks at edges of the body: the largest c counts there, then the smallest
    // cell.
    struct Choice
    {
      double spacing = 0.0;
      double firstCell = 0.0;
      int allowed = 1;

      bool operator<(const Choice& other) const
      {
        return std::make_tuple(-this->spacing, this->firstCell, this->allowed) <
          std::make_tuple(-other.spacing, other.firstCell, other.allowed);
      }
    };
    std::vector<Choice> choices(count);
    // What all lines say: the levels that reach the target on none of them, and the line that needs the most layers.
    struct Verdict
    {
      std::array<bool, MaxSamplingLevel + 1> fails{};
      double height = 0.0;
      double target = 1.0;
      int face = -1;
      int layers = 0;
    };
    Verdict worst;
    const auto needsMore = [](const Verdict& a, const Verdict& b) { return a.height / a.target > b.height / b.target; };
    for (std::size_t w = 0; w < this->Result.sides.size(); ++w)
    {
      const WallSpacingResult::Side& side = this->Result.sides[w];
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
          worst.fails[level] = worst.fails[level] || !guess.reaches[level];
        }
        this->Result.reachingLevel[v] = std::max(this->Result.reachingLevel[v], reaching);
        const Verdict line{ worst.fails, guess.height, this->target(v), this->Faces[w], this->rise(use) };
        worst = guess.fixed && needsMore(line, worst) ? line : worst;
        const Choice choice{ guess.spacing, guess.firstCell, guess.fixed ? 0 : 1 };
        choices[v] = choice < choices[v] ? choice : choices[v];
      }
    }
    this->agree(choices, std::less<Choice>());
    this->agree(this->Result.reachingLevel, std::greater<int>());
    for (const Choice& choice : choices)
    {
      this->Result.spacing.push_back(choice.spacing);
      this->Result.allowed.push_back(static_cast<char>(choice.allowed));
      this->FirstCell.push_back(choice.firstCell);
    }

    const std::vector<Verdict> verdicts = this->Run.ranks->gatherAll(std::vector<Verdict>{ worst });
    worst = {};
    std::array<bool, MaxSamplingLevel + 1> fails{};
    for (const Verdict& verdict : verdicts)
    {
      for (int level = 0; level <= MaxSamplingLevel; ++level)
      {
        fails[level] = fails[level] || verdict.fails[level];
      }
      // Of equal ones that of the first face, as if all faces were here.
      const bool first = verdict.face < worst.face && !needsMore(worst, verdict);
      worst = needsMore(verdict, worst) || first ? verdict : worst;
    }
    for (int level = MaxSamplingLevel; level >= 0; --level)
    {
      this->Result.levelForAll = fails[level] ? this->Result.levelForAll : level;
    }
    this->PresentLayers = worst.layers;
    if (worst.height > 0.0)
    {
      this->Result.layersForAll = this->layersFor(worst.height, worst.target);
    }
  }

  /// Converts the wall and measures it.
  void measure()
  {
    this->writeSpacing();
    convertToBSplineVolume(this->Complex, this->Conversion, this->Nets, this->quiet());
    const std::size_t count = this->Result.points.size();
    this->Result.firstHeight.assign(count, Infinity);
    this->Result.growth.assign(count, 1.0);
    // A vertex of several faces is measured in each of them, equal up to rounding.
    for (const WallSpacingResult::Side& side : this->Result.sides)
    {
      const int ns = this->cells({ side.block, side.face }, 0) + 1;
      std::vector<std::array<double, 2>> values(side.vertices.size());
      this->Run.parallelFor(static_cast<Index>(values.size()), 64, [&](Index begin, Index end) {
        for (Index i = begin; i < end; ++i)
        {
          const WallColumn column = this->column({ side.block, side.face }, int(i % ns), int(i / ns));
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
    this->agree(this->Result.firstHeight, std::less<double>());
    this->agree(this->Result.growth, std::greater<double>());
  }

  /// Improves c where it is free. Returns the largest relative error of the height there.
  double improve()
  {
    // Height per 1 - c in first cells, if the neighbours do the same: that of a straight line.
    const std::vector<Vec3> unit{ Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0), Vec3(3, 0, 0) };
    const double effect =
      lineColumn(unit, 1.0).firstHeight(this->Options.level) - lineColumn(unit, 0.0).firstHeight(this->Options.level);
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
    return this->largest(worst);
  }

  void finish()
  {
    WallSpacingResult& result = this->Result;
    double low = Infinity, high = 0.0;
    std::array<Index, 2> counts{ 0, 0 };
    for (std::size_t v = 0; v < result.points.size(); ++v)
    {
      result.yPlus.push_back(yPlus(this->Options.flow, result.layers[v].skinFriction, result.firstHeight[v]));
      low = std::min(low, result.yPlus[v]);
      high = std::max(high, result.yPlus[v]);
      const double error = std::abs(result.yPlus[v] / this->Options.targetYPlus - 1.0);
      counts[0] += result.counted[v];
      counts[1] += result.counted[v] && error <= WallSpacingResult::Accuracy ? 1 : 0;
    }
    low = -this->largest(-low);
    high = this->largest(high);
    for (const std::array<Index, 2>& part : this->Run.ranks->gatherAll(std::vector<std::array<Index, 2>>{ counts }))
    {
      result.wallPoints += part[0];
      result.reached += part[1];
    }
    this->countCells();
    if (result.reached < result.wallPoints)
    {
      std::ostringstream text;
      text << "the first cell has the y+ " << this->Options.targetYPlus << " within 1 % at " << result.reached << " of "
           << result.wallPoints << " wall points at Level " << this->Options.level << " with a growth of at most "
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

  /// The first points of the mesh line that rises at (s, t), as many as a WallColumn needs.
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
    const Index at = position[0] + Index(owner.cells(0) + 3) * (position[1] + Index(owner.cells(1) + 3) * position[2]);
    return Vec3(Eigen::Map<const Vec3>(this->Nets[block].points + 3 * at));
  }

  /// The curve of the volume that rises at (s, t).
  WallColumn column(const FaceUse& use, int s, int t) const
  {
    const ComplexBlock& owner = this->Complex.blocks[use.block];
    const int first = faceAxis(use.face, 0), second = faceAxis(use.face, 1), normal = faceDirection(use.face);
    const WallBasis alongS = basisAtKnot(owner.cells(first), s), alongT = basisAtKnot(owner.cells(second), t);
    WallColumn column;
    column.cells = owner.cells(normal);
    OrderFreeSum sum;
    for (int a = 0; a < std::min(WallColumn::Depth, column.cells + 3); ++a)
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

  /// Counts the sampled cells up to a distance from the wall, along a mesh line and on into the next blocks, which may
  /// be on other ranks: it travels there, and back to where it started.
  struct Counter
  {
    int rank;
    Index vertex;
    double distance;
    FaceUse use; ///< the block where it is, entered by this face at (s, t)
    int s, t;
    int depth;  ///< mesh points behind it there
    int blocks; ///< entered so far
    double height;
    double cells;
    bool done;
  };

  /// A counter behind the first two spans, which are measured on the curve.
  Counter counterAt(FaceUse use, int s, int t, Index vertex) const
  {
    const double distance = this->Result.layers[vertex].thickness;
    const double perSpan = std::ldexp(1.0, this->Options.level);
    const WallColumn column = this->column(use, s, t);
    const int own = std::min(2, column.cells);
    Counter counter{ this->Run.ranks->rank(), vertex, distance, use, s, t, own, 0, 0.0, own * perSpan, false };
    const double step = 1.0 / perSpan;
    Vec3 x = column.points[0];
    for (int i = 1; i <= own * (1 << this->Options.level); ++i)
    {
      const Vec3 next = column.at(i * step);
      const double cell = (next - x).norm();
      if (counter.height + cell > distance)
      {
        counter.cells = i - 1 + (distance - counter.height) / cell;
        counter.done = true;
        break;
      }
      counter.height += cell;
      x = next;
    }
    return counter;
  }

  /// Goes on, as far as the blocks of this rank.
  void advance(Counter& counter) const
  {
    const double perSpan = std::ldexp(1.0, this->Options.level);
    while (!counter.done && this->Complex.blocks[counter.use.block].rank == this->Run.ranks->rank())
    {
      for (int k = counter.depth; k < this->rise(counter.use); ++k)
      {
        const Vec3 below = this->point(counter.use, counter.s, counter.t, k);
        const double span = (this->point(counter.use, counter.s, counter.t, k + 1) - below).norm();
        if (counter.height + span > counter.distance)
        {
          counter.cells += perSpan * (counter.distance - counter.height) / span;
          counter.done = true;
          return;
        }
        counter.height += span;
        counter.cells += perSpan;
      }
      const FaceContact next = contactOf(this->Complex, counter.use.block, counter.use.face ^ 1);
      // Around a ring it would never end.
      if (next.block < 0 || ++counter.blocks > static_cast<int>(this->Complex.blocks.size()))
      {
        counter.done = true;
        return;
      }
      const auto st =
        mapFacePoint(next.orientation, counter.s, counter.t, this->cells(counter.use, 0), this->cells(counter.use, 1));
      counter.use = { next.block, next.face };
      counter.s = st[0];
      counter.t = st[1];
      counter.depth = 0;
    }
  }

  void countCells()
  {
    const Ranks& ranks = *this->Run.ranks;
    WallSpacingResult& result = this->Result;
    result.cells.assign(result.points.size(), Infinity);
    std::vector<std::vector<Counter>> toRank(ranks.size());
    const auto move = [&](Counter counter) {
      this->advance(counter);
      const int next = counter.done ? counter.rank : this->Complex.blocks[counter.use.block].rank;
      if (next == ranks.rank())
      {
        result.cells[counter.vertex] = std::min(result.cells[counter.vertex], counter.cells);
      }
      else
      {
        toRank[next].push_back(counter);
      }
    };
    for (const WallSpacingResult::Side& side : result.sides)
    {
      const FaceUse use{ side.block, side.face };
      const int ns = this->cells(use, 0) + 1;
      for (std::size_t i = 0; i < side.vertices.size(); ++i)
      {
        move(this->counterAt(use, int(i) % ns, int(i) / ns, side.vertices[i]));
      }
    }
    while (ranks.any(std::any_of(toRank.begin(), toRank.end(), [](const auto& list) { return !list.empty(); })))
    {
      const std::vector<std::vector<Counter>> received = ranks.exchange(toRank);
      toRank.assign(ranks.size(), {});
      for (const std::vector<Counter>& list : received)
      {
        std::for_each(list.begin(), list.end(), move);
      }
    }
    this->agree(result.cells, std::less<double>());
  }

  int tag(std::size_t side) const { return this->Complex.faces[this->Faces[side]].tag; }

  /// Finds the vertices that other ranks have, too.
  void findShared()
  {
    const Ranks& ranks = *this->Run.ranks;
    const std::vector<Vec3>& points = this->Result.points;
    this->Result.counted.assign(points.size(), 1);
    this->Shared.resize(ranks.size());
    if (ranks.size() == 1)
    {
      return;
    }
    // Equal ones meet on a rank that their keys say, which tells the ranks that have them of each other.
    struct Vertex
    {
      SurfacePointKey key;
      Index number;
    };
    std::vector<std::vector<Vertex>> toRank(ranks.size());
    for (std::size_t v = 0; v < points.size(); ++v)
    {
      toRank[keeperOf(this->Keys[v], ranks.size())].push_back({ this->Keys[v], static_cast<Index>(v) });
    }
    const std::vector<std::vector<Vertex>> met = ranks.exchange(toRank);
    struct Owner
    {
      int rank;
      Index number;
    };
    std::map<SurfacePointKey, std::vector<Owner>> owners;
    for (int r = 0; r < ranks.size(); ++r)
    {
      for (const Vertex& vertex : met[r])
      {
        owners[vertex.key].push_back({ r, vertex.number });
      }
    }
    // In the order of the keys, which is the same for both of them.
    std::vector<std::vector<Owner>> pairs(ranks.size());
    for (const auto& entry : owners)
    {
      for (const Owner& a : entry.second)
      {
        for (const Owner& b : entry.second)
        {
          if (a.rank != b.rank)
          {
            pairs[a.rank].push_back({ b.rank, a.number });
          }
        }
      }
    }
    for (const std::vector<Owner>& part : ranks.exchange(pairs))
    {
      for (const Owner& pair : part)
      {
        this->Shared[pair.rank].push_back(pair.number);
        this->Result.counted[pair.number] = this->Result.counted[pair.number] && ranks.rank() < pair.rank ? 1 : 0;
      }
    }
  }

  /// Gives a vertex the best of the values that the ranks have for it.
  template <typename T, typename Better>
  void agree(std::vector<T>& values, const Better& better) const
  {
    const Ranks& ranks = *this->Run.ranks;
    if (ranks.size() == 1)
    {
      return;
    }
    std::vector<std::vector<T>> toRank(ranks.size());
    for (int r = 0; r < ranks.size(); ++r)
    {
      for (const Index v : this->Shared[r])
      {
        toRank[r].push_back(values[v]);
      }
    }
    const std::vector<std::vector<T>> received = ranks.exchange(toRank);
    for (int r = 0; r < ranks.size(); ++r)
    {
      for (std::size_t i = 0; i < received[r].size(); ++i)
      {
        T& value = values[this->Shared[r][i]];
        value = better(received[r][i], value) ? received[r][i] : value;
      }
    }
  }

  double largest(double mine) const
  {
    const std::vector<double> all = this->Run.ranks->gatherAll(std::vector<double>{ mine });
    return *std::max_element(all.begin(), all.end());
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
  /// Face of the complex per side.
  std::vector<int> Faces;
  /// Per other rank the vertices that it has, too, in an order that both know.
  std::vector<std::vector<Index>> Shared;
  std::vector<SurfacePointKey> Keys;
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
  check(
    options.targetYPlus > 0.0 && std::isfinite(options.targetYPlus), "Target Y Plus", options.targetYPlus, "above 0");
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
