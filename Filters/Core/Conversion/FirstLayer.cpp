// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/FirstLayer.h"

#include "Base/OrderFreeSum.h"
#include "Complex/EdgeFans.h"
#include "Complex/SurfacePointKey.h"
#include "Mesh/BlockSurface.h"
#include "Ranks/OwnedValues.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

namespace bsv
{
namespace
{

/// Values at points of the complex, whatever block they come from; a point that is given several different ones has
/// their mean.
class PointValues
{
public:
  void add(const SurfacePointKey& point, double value) { this->Values[point].push_back(value); }

  /// Adds what the other ranks have. Collective.
  void gather(const Ranks& ranks)
  {
    if (ranks.size() == 1)
    {
      return;
    }
    const std::vector<Entry> all = ranks.gatherAll(this->entries());
    this->Values.clear();
    for (const Entry& entry : all)
    {
      this->Values[entry.point].push_back(entry.value);
    }
  }

  /// Replaces the values by their means over all ranks, at its own points and at those of `more` that any rank has.
  /// Collective.
  void agree(const std::vector<SurfacePointKey>& more, const Ranks& ranks)
  {
    if (ranks.size() == 1)
    {
      return;
    }
    // Every point has a rank that all others tell their values, and ask.
    const auto keeper = [&](const SurfacePointKey& point) { return keeperOf(point, ranks.size()); };
    std::vector<std::vector<Entry>> told(ranks.size());
    std::vector<std::vector<SurfacePointKey>> questions(ranks.size());
    for (const Entry& entry : this->entries())
    {
      told[keeper(entry.point)].push_back(entry);
    }
    for (const auto& entry : this->Values)
    {
      questions[keeper(entry.first)].push_back(entry.first);
    }
    for (const SurfacePointKey& point : more)
    {
      questions[keeper(point)].push_back(point);
    }
    PointValues kept;
    for (const std::vector<Entry>& part : ranks.exchange(told))
    {
      for (const Entry& entry : part)
      {
        kept.Values[entry.point].push_back(entry.value);
      }
    }
    std::vector<std::vector<double>> answers(ranks.size());
    const std::vector<std::vector<SurfacePointKey>> asked = ranks.exchange(questions);
    for (int r = 0; r < ranks.size(); ++r)
    {
      for (const SurfacePointKey& point : asked[r])
      {
        const auto found = kept.Values.find(point);
        answers[r].push_back(
          found == kept.Values.end() ? std::numeric_limits<double>::quiet_NaN() : mean(found->second));
      }
    }
    const std::vector<std::vector<double>> means = ranks.exchange(answers);
    for (int r = 0; r < ranks.size(); ++r)
    {
      for (std::size_t i = 0; i < means[r].size(); ++i)
      {
        if (!std::isnan(means[r][i]))
        {
          this->Values[questions[r][i]] = { means[r][i] };
        }
      }
    }
  }

  /// Takes over the points of `other`, none of which it has.
  void take(PointValues& other) { this->Values.merge(other.Values); }

  bool has(const SurfacePointKey& point) const { return this->Values.count(point) > 0; }

  /// Values that are equal count once.
  double at(const SurfacePointKey& point) const { return mean(this->Values.at(point)); }

  /// Mean over the points; `none` if there are none.
  double average(double none) const
  {
    OrderFreeSum sum;
    for (const auto& entry : this->Values)
    {
      sum.add(1.0, Vec3(mean(entry.second), 0.0, 0.0));
    }
    return this->Values.empty() ? none : sum.result(static_cast<double>(this->Values.size()))[0];
  }

private:
  struct Entry
  {
    SurfacePointKey point;
    double value;
  };

  std::vector<Entry> entries() const
  {
    std::vector<Entry> result;
    for (const auto& [point, values] : this->Values)
    {
      for (const double value : values)
      {
        result.push_back({ point, value });
      }
    }
    return result;
  }

  static double mean(std::vector<double> values)
  {
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
    OrderFreeSum sum;
    for (const double value : values)
    {
      sum.add(1.0, Vec3(value, 0.0, 0.0));
    }
    return sum.result(static_cast<double>(values.size()))[0];
  }

  std::map<SurfacePointKey, std::vector<double>> Values;
};

/// A block face as seen from inside its block: mesh points above it.
class FaceLines
{
public:
  FaceLines(const BlockComplex& complex, const FaceUse& use)
    : Complex(complex)
    , Use(use)
    , Owner(complex.blocks[use.block])
    , Cells{ this->Owner.cells(0), this->Owner.cells(1), this->Owner.cells(2) }
  {
  }

  int ns() const { return this->Cells[faceAxis(this->Use.face, 0)]; }
  int nt() const { return this->Cells[faceAxis(this->Use.face, 1)]; }
  std::size_t size() const { return std::size_t(this->ns() + 1) * (this->nt() + 1); }
  std::size_t index(int s, int t) const { return s + std::size_t(this->ns() + 1) * t; }

  Ijk ijk(int s, int t, int depth) const
  {
    Ijk result = facePoint(this->Cells, this->Use.face, s, t);
    const int normal = faceDirection(this->Use.face);
    result[normal] = faceSide(this->Use.face) ? this->Cells[normal] - depth : depth;
    return result;
  }
  Vec3 point(int s, int t, int depth) const { return this->Owner.points(this->ijk(s, t, depth)); }
  SurfacePointKey key(int s, int t) const { return surfacePointKey(this->Complex, this->Use, s, t); }
  bool has(int s, int t, int depth) const { return this->Owner.points.has(this->ijk(s, t, depth)); }
  /// Whether all points are on this rank, and whether none is.
  bool isHere() const { return this->Owner.points.isHere(); }
  bool isElsewhere() const { return this->Owner.points.isElsewhere(); }

  /// Growth |p_2 - p_1| / |p_1 - p_0| of the line, on into the next block if need be; 1 if there is no second cell.
  double growth(int s, int t) const
  {
    const Vec3 p1 = this->point(s, t, 1);
    Vec3 p2;
    if (this->Cells[faceDirection(this->Use.face)] > 1)
    {
      p2 = this->point(s, t, 2);
    }
    else
    {
      const FaceContact next = contactOf(this->Complex, this->Use.block, this->Use.face ^ 1);
      if (next.block < 0)
      {
        return 1.0;
      }
      const auto st = mapFacePoint(next.orientation, s, t, this->ns(), this->nt());
      p2 = FaceLines(this->Complex, { next.block, next.face }).point(st[0], st[1], 1);
    }
    const double first = (p1 - this->point(s, t, 0)).norm();
    return first > 0.0 ? (p2 - p1).norm() / first : 1.0;
  }

  template <typename Body>
  void forAll(const Body& body) const
  {
    for (int t = 0; t <= this->nt(); ++t)
    {
      for (int s = 0; s <= this->ns(); ++s)
      {
        body(s, t);
      }
    }
  }

private:
  const BlockComplex& Complex;
  const FaceUse Use;
  const ComplexBlock& Owner;
  const Ijk Cells;
};

void checkSpacing(double c, const std::string& where)
{
  if (!(c > 0.0 && c < 1.0))
  {
    throw Error("Wall Spacing " + text(c) + where + " is not between 0 and 1, both excluded");
  }
}

/// (2 + ln g) / (3 + ln g), within what keeps layers apart.
double matchingSpacing(double growth)
{
  constexpr double Least = 0.2, Most = 20.0;
  const double ln = std::log(std::min(std::max(growth, Least), Most));
  return (2.0 + ln) / (3.0 + ln);
}

} // namespace

FirstLayer::FirstLayer(const BlockComplex& complex, const ConversionOptions& options, const Ranks& ranks)
  : Complex(complex)
  , Processes(ranks)
  , Weights(complex.blocks.size())
{
  this->setWalls(options);
}

void FirstLayer::setWalls(const ConversionOptions& options)
{
  const auto boundaryValue = [&](int tag) {
    return tag >= 0 && tag < static_cast<int>(options.boundaryWallSpacing.size())
      ? options.boundaryWallSpacing[tag]
      : std::numeric_limits<double>::quiet_NaN();
  };
  checkSpacing(options.wallSpacing, "");
  for (std::size_t tag = 0; tag < options.boundaryWallSpacing.size(); ++tag)
  {
    if (!std::isnan(boundaryValue(static_cast<int>(tag))))
    {
      checkSpacing(boundaryValue(static_cast<int>(tag)), " of boundary '" + this->Complex.boundaryNames[tag] + "'");
    }
  }
  std::vector<const ComplexFace*> walls;
  bool constant = !options.automaticWallSpacing;
  for (const ComplexFace& face : this->Complex.faces)
  {
    if (roleOf(options, face) != BoundaryRole::Body)
    {
      continue;
    }
    walls.push_back(&face);
    const int parent = this->Complex.blocks[face.uses[0].block].parent;
    constant = constant && std::isnan(boundaryValue(face.tag)) &&
      (parent >= static_cast<int>(options.wallSpacingPoints.size()) || !options.wallSpacingPoints[parent]);
  }
  this->WallRange = { options.wallSpacing, options.wallSpacing };
  if (!this->Processes.any(!constant))
  {
    for (const ComplexFace* face : walls)
    {
      this->Weights[face->uses[0].block][face->uses[0].face] = { options.wallSpacing };
    }
    return;
  }

  PointValues values;
  std::vector<SurfacePointKey> near;
  for (const ComplexFace* face : walls)
  {
    const FaceUse& use = face->uses[0];
    const ComplexBlock& owner = this->Complex.blocks[use.block];
    const FaceLines lines(this->Complex, use);
    if (!lines.isHere())
    {
      lines.forAll([&](int s, int t) {
        if (lines.has(s, t, 0))
        {
          near.push_back(lines.key(s, t));
        }
      });
      continue;
    }
    const double* given = owner.parent < static_cast<int>(options.wallSpacingPoints.size())
      ? options.wallSpacingPoints[owner.parent]
      : nullptr;
    const double ofBoundary = boundaryValue(face->tag);
    lines.forAll([&](int s, int t) {
      double c = options.wallSpacing;
      double own = std::numeric_limits<double>::quiet_NaN();
      if (given)
      {
        // Strides of the parent's points are those of its arrays.
        const Ijk ijk = lines.ijk(s, t, 0);
        Index at = 0;
        for (int d = 0; d < 3; ++d)
        {
          at += owner.points.stride(d) * (owner.offset[d] + ijk[d]);
        }
        own = given[at];
      }
      if (!std::isnan(own))
      {
        checkSpacing(own, " at a wall point of block '" + owner.name + "'");
        c = own;
      }
      else if (!std::isnan(ofBoundary))
      {
        c = ofBoundary;
      }
      else if (options.automaticWallSpacing)
      {
        c = matchingSpacing(lines.growth(s, t));
      }
      values.add(lines.key(s, t), c);
    });
  }
  values.agree(near, this->Processes);
  this->WallRange = { 1.0, 0.0 };
  for (const ComplexFace* face : walls)
  {
    const FaceUse& use = face->uses[0];
    const FaceLines lines(this->Complex, use);
    if (lines.isElsewhere())
    {
      continue;
    }
    std::vector<double>& weights = this->Weights[use.block][use.face];
    weights.resize(lines.size(), KnotInsertion);
    lines.forAll([&](int s, int t) {
      if (lines.has(s, t, 0))
      {
        const double c = values.at(lines.key(s, t));
        weights[lines.index(s, t)] = c;
        this->WallRange = { std::min(this->WallRange[0], c), std::max(this->WallRange[1], c) };
      }
    });
  }
  for (const auto& range : this->Processes.gatherAll(std::vector<std::array<double, 2>>{ this->WallRange }))
  {
    this->WallRange = { std::min(this->WallRange[0], range[0]), std::max(this->WallRange[1], range[1]) };
  }
}

void FirstLayer::setSide(const FarFieldSide& side, FarFieldSpacing spacing, const LastDistance& lastDistance)
{
  PointValues distances;
  for (std::size_t i = 0; i < side.faces.size(); ++i)
  {
    const FaceLines lines(this->Complex, side.inner[i]);
    if (side.onCuboid[i] && lines.isHere())
    {
      lines.forAll(
        [&](int s, int t) { distances.add(lines.key(s, t), lastDistance(side.inner[i], s, t, side.normal)); });
    }
  }
  distances.gather(this->Processes);
  const double average = distances.average(0.0);
  this->Distances.push_back(average);

  // Beyond the edges of the cuboid the distance goes on as it is there, face by face.
  std::vector<FaceUse> beyond;
  for (std::size_t i = 0; i < side.faces.size() && spacing == FarFieldSpacing::PerVertex; ++i)
  {
    if (!side.onCuboid[i])
    {
      beyond.push_back(side.outer[i]);
    }
  }
  std::vector<std::size_t> open(beyond.size());
  std::iota(open.begin(), open.end(), 0);
  while (!open.empty())
  {
    PointValues more;
    std::vector<std::size_t> left;
    for (const std::size_t i : open)
    {
      const FaceLines lines(this->Complex, beyond[i]);
      bool found = false;
      for (int edge = 0; edge < 4; ++edge)
      {
        const bool alongS = edge < 2;
        const int n = alongS ? lines.ns() : lines.nt();
        const int across = edge % 2 == 0 ? 0 : alongS ? lines.nt() : lines.ns();
        const auto onEdge = [&](int k) { return alongS ? lines.key(k, across) : lines.key(across, k); };
        bool known = true;
        for (int k = 0; k <= n; ++k)
        {
          known = known && distances.has(onEdge(k));
        }
        if (known)
        {
          found = true;
          lines.forAll([&](int s, int t) {
            const SurfacePointKey point = lines.key(s, t);
            if (!distances.has(point))
            {
              more.add(point, distances.at(onEdge(alongS ? s : t)));
            }
          });
        }
      }
      if (!found)
      {
        left.push_back(i);
      }
    }
    if (left.size() == open.size())
    {
      break;
    }
    open = left;
    distances.take(more);
  }

  // Over more than 2/3 of the first cell the next layers would come too close.
  constexpr double Least = 1.0 / 3.0;
  Index limited = 0;
  for (const FaceUse& use : side.outer)
  {
    const FaceLines lines(this->Complex, use);
    if (lines.isElsewhere())
    {
      continue;
    }
    std::vector<double>& weights = this->Weights[use.block][use.face];
    weights.assign(lines.size(), KnotInsertion);
    lines.forAll([&](int s, int t) {
      if (!lines.has(s, t, 0) || !lines.has(s, t, 1))
      {
        return;
      }
      const Vec3 point = lines.point(s, t, 0);
      const double first = side.normal.dot(lines.point(s, t, 1) - point);
      const double distance = spacing == FarFieldSpacing::PerVertex && distances.has(lines.key(s, t))
        ? distances.at(lines.key(s, t))
        : average;
      if (first > 0.0 && distance > 0.0)
      {
        const double c = 1.0 - distance / first;
        limited += lines.isHere() && c < Least ? 1 : 0;
        weights[lines.index(s, t)] = std::max(c, Least);
      }
    });
  }
  for (const Index count : this->Processes.gatherAll(std::vector<Index>{ limited }))
  {
    this->Limited += count;
  }
}

void FirstLayer::describe(ConversionReport& report) const
{
  report.extensionDistances = this->Distances;
  report.limitedDistances = this->Limited;
  report.wallSpacing = this->WallRange;
}

} // namespace bsv
