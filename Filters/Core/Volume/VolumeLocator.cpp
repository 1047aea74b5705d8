// SPDX-License-Identifier: BSD-3-Clause
#include "Volume/VolumeLocator.h"

#include "Base/BoxTree.h"
#include "Mesh/BlockTopology.h"
#include "Volume/BezierSegments.h"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <tuple>

namespace bsv
{

namespace
{

/// Spans per direction that share a box of the tree.
constexpr int BrickSize = 2;
constexpr int MaximumSteps = 20;

using Homogeneous = Eigen::Vector4d;

/// The spans of a direction, with the matrices that give their Bezier points.
struct DirectionSpans
{
  std::vector<int> spans;
  std::vector<std::array<double, (MaxDegree + 1) * (MaxDegree + 1)>> weights;
};

struct Brick
{
  int block;
  Ijk first; ///< places in DirectionSpans::spans
};

/// A part of a span: its Bezier points w x, w y, w z, w, and the parameters that it covers.
struct Part
{
  std::vector<Homogeneous> net;
  Vec3 low;
  Vec3 high;
};

Box boxOf(const std::vector<Homogeneous>& net)
{
  Box box;
  for (const Homogeneous& x : net)
  {
    box.extend(Vec3(x.head<3>() / x[3]));
  }
  return box;
}

/// Whether the box is farther from the point than the tolerance.
bool isBeyond(const Box& box, const Vec3& point, double tolerance)
{
  return (box.min() - point).cwiseMax(point - box.max()).cwiseMax(0.0).stableNorm() > tolerance;
}

/// Whether the point is farther than the tolerance from a part, by two boxes of its Bezier points: along the axes, and
/// along the part's own directions, where thin and curved cells fill their box. Both are proofs: a part lies in the
/// convex hull of its points, and so does any affine image of it.
bool isExcluded(const Part& part, const std::array<int, 3>& degree, const Vec3& point, double tolerance)
{
  if (isBeyond(boxOf(part.net), point, tolerance))
  {
    return true;
  }
  // Mean of the edges in each direction.
  const int size[3] = { degree[0] + 1, degree[1] + 1, degree[2] + 1 };
  const auto corner = [&](int a, int b, int c) -> Vec3 {
    const Homogeneous& x = part.net[a * degree[0] + size[0] * (b * degree[1] + size[1] * (c * degree[2]))];
    return x.head<3>() / x[3];
  };
  Eigen::Matrix3d edges = Eigen::Matrix3d::Zero();
  for (int n = 0; n < 4; ++n)
  {
    const int a = n % 2;
    const int b = n / 2;
    edges.col(0) += 0.25 * (corner(1, a, b) - corner(0, a, b));
    edges.col(1) += 0.25 * (corner(a, 1, b) - corner(a, 0, b));
    edges.col(2) += 0.25 * (corner(a, b, 1) - corner(a, b, 0));
  }
  const Eigen::Matrix3d own = edges.inverse();
  if (!own.allFinite())
  {
    return false;
  }
  Box box;
  for (const Homogeneous& x : part.net)
  {
    box.extend(Vec3(own * (x.head<3>() / x[3] - point)));
  }
  const Vec3 reach = tolerance * own.rowwise().norm();
  return (box.min().array() > reach.array()).any() || (box.max().array() < -reach.array()).any();
}

/// Both halves of a part in one direction.
std::array<Part, 2> halved(const Part& part, const std::array<int, 3>& degree, int direction)
{
  const int size[3] = { degree[0] + 1, degree[1] + 1, degree[2] + 1 };
  const int stride = direction == 0 ? 1 : direction == 1 ? size[0] : size[0] * size[1];
  std::array<Part, 2> halves{ part, part };
  for (int c = 0; c < size[2]; ++c)
  {
    for (int b = 0; b < size[1]; ++b)
    {
      for (int a = 0; a < size[0]; ++a)
      {
        const int ijk[3] = { a, b, c };
        if (ijk[direction] == 0)
        {
          const int at = a + size[0] * (b + size[1] * c);
          halveBezier(degree[direction], stride, &halves[0].net[at], &halves[1].net[at]);
        }
      }
    }
  }
  const double middle = 0.5 * (part.low[direction] + part.high[direction]);
  halves[0].high[direction] = middle;
  halves[1].low[direction] = middle;
  return halves;
}

} // namespace

struct VolumeLocator::Spans
{
  const std::vector<BSplineVolume>* volumes = nullptr;
  std::vector<std::array<DirectionSpans, 3>> directions;
  std::vector<Brick> bricks;
  std::unique_ptr<const BoxTree> tree;
  Box box;

  const BSplineVolume& volume(int block) const { return (*this->volumes)[block]; }
  /// Control points that a brick's spans depend on: first and last per direction.
  std::array<Ijk, 2> pointsOf(const Brick& brick) const;
  Box boxOfPoints(int block, const Ijk& first, const Ijk& last) const;
  Part bezierOf(int block, const Ijk& span) const;
  /// The place in one span, if the point is there.
  std::optional<VolumePlace> search(int block, const Part& part, const Vec3& low, const Vec3& high, const Vec3& point,
    double tolerance, int depth) const;
  /// Newton's method from the middle of a part, in the range low..high of its span.
  std::optional<VolumePlace> iterate(
    int block, const Part& part, const Vec3& low, const Vec3& high, const Vec3& point, double tolerance) const;
};

std::array<Ijk, 2> VolumeLocator::Spans::pointsOf(const Brick& brick) const
{
  std::array<Ijk, 2> result{};
  for (int d = 0; d < 3; ++d)
  {
    const std::vector<int>& spans = this->directions[brick.block][d].spans;
    const int last = std::min<int>(brick.first[d] + BrickSize, static_cast<int>(spans.size())) - 1;
    result[0][d] = spans[brick.first[d]] - this->volume(brick.block).degree[d];
    result[1][d] = spans[last];
  }
  return result;
}

Box VolumeLocator::Spans::boxOfPoints(int block, const Ijk& first, const Ijk& last) const
{
  const BSplineVolume& volume = this->volume(block);
  Box result;
  for (int k = first[2]; k <= last[2]; ++k)
  {
    for (int j = first[1]; j <= last[1]; ++j)
    {
      const double* row = volume.points + 3 * (Index(volume.count(0)) * (j + Index(volume.count(1)) * k));
      for (int i = first[0]; i <= last[0]; ++i)
      {
        result.extend(Vec3(row[3 * i], row[3 * i + 1], row[3 * i + 2]));
      }
    }
  }
  return result;
}

Part VolumeLocator::Spans::bezierOf(int block, const Ijk& span) const
{
  const BSplineVolume& volume = this->volume(block);
  const int size[3] = { volume.degree[0] + 1, volume.degree[1] + 1, volume.degree[2] + 1 };
  Part part;
  Ijk first{};
  for (int d = 0; d < 3; ++d)
  {
    const int s = this->directions[block][d].spans[span[d]];
    first[d] = s - volume.degree[d];
    part.low[d] = volume.knots[d][s];
    part.high[d] = volume.knots[d][s + 1];
  }
  part.net.reserve(size[0] * size[1] * size[2]);
  for (int c = 0; c < size[2]; ++c)
  {
    for (int b = 0; b < size[1]; ++b)
    {
      const Index row = first[0] + Index(volume.count(0)) * (first[1] + b + Index(volume.count(1)) * (first[2] + c));
      for (int a = 0; a < size[0]; ++a)
      {
        const double* x = volume.points + 3 * (row + a);
        const double weight = volume.weights ? volume.weights[row + a] : 1.0;
        part.net.emplace_back(weight * x[0], weight * x[1], weight * x[2], weight);
      }
    }
  }
  // One direction after the other.
  std::vector<Homogeneous> line;
  for (int d = 0, stride = 1; d < 3; stride *= size[d], ++d)
  {
    const auto& weights = this->directions[block][d].weights[span[d]];
    for (int start = 0; start < static_cast<int>(part.net.size()); ++start)
    {
      if (start / stride % size[d] != 0)
      {
        continue;
      }
      line.assign(size[d], Homogeneous::Zero());
      for (int j = 0; j < size[d]; ++j)
      {
        for (int i = 0; i < size[d]; ++i)
        {
          line[j] += weights[j * size[d] + i] * part.net[start + i * stride];
        }
      }
      for (int j = 0; j < size[d]; ++j)
      {
        part.net[start + j * stride] = line[j];
      }
    }
  }
  return part;
}

std::optional<VolumePlace> VolumeLocator::Spans::iterate(
  int block, const Part& part, const Vec3& low, const Vec3& high, const Vec3& point, double tolerance) const
{
  const BSplineVolume& volume = this->volume(block);
  VolumePlace best{ block, 0.5 * (part.low + part.high), 0.0 };
  Vec3 at = best.uvw;
  Vec3 residual = point - evaluate(volume, at);
  best.distance = residual.stableNorm();
  for (int step = 0; step < MaximumSteps; ++step)
  {
    Eigen::Matrix3d jacobian;
    jacobian.col(0) = evaluate(volume, at, { 1, 0, 0 });
    jacobian.col(1) = evaluate(volume, at, { 0, 1, 0 });
    jacobian.col(2) = evaluate(volume, at, { 0, 0, 1 });
    if (!(std::abs(jacobian.determinant()) > 0.0))
    {
      break;
    }
    const Vec3 moved = (at + jacobian.partialPivLu().solve(residual)).cwiseMax(low).cwiseMin(high);
    if (!moved.allFinite() || moved == at)
    {
      break;
    }
    at = moved;
    residual = point - evaluate(volume, at);
    const double distance = residual.stableNorm();
    // Once the point is found, until rounding ends the improvement.
    if (distance >= best.distance && best.distance <= tolerance)
    {
      break;
    }
    if (distance < best.distance)
    {
      best.uvw = at;
      best.distance = distance;
    }
  }
  return best.distance <= tolerance ? std::optional<VolumePlace>(best) : std::nullopt;
}

std::optional<VolumePlace> VolumeLocator::Spans::search(
  int block, const Part& part, const Vec3& low, const Vec3& high, const Vec3& point, double tolerance, int depth) const
{
  const std::array<int, 3>& degree = this->volume(block).degree;
  if (isExcluded(part, degree, point, tolerance))
  {
    return std::nullopt;
  }
  if (auto found = this->iterate(block, part, low, high, point, tolerance))
  {
    return found;
  }
  if (depth == MaximumHalvings)
  {
    return std::nullopt;
  }
  for (const Part& w : halved(part, degree, 2))
  {
    for (const Part& v : halved(w, degree, 1))
    {
      for (const Part& u : halved(v, degree, 0))
      {
        if (auto found = this->search(block, u, low, high, point, tolerance, depth + 1))
        {
          return found;
        }
      }
    }
  }
  return std::nullopt;
}

VolumeLocator::VolumeLocator(const std::vector<BSplineVolume>& volumes, const Execution& run)
{
  auto data = std::make_unique<Spans>();
  data->volumes = &volumes;
  data->directions.resize(volumes.size());
  for (int block = 0; block < static_cast<int>(volumes.size()); ++block)
  {
    const BSplineVolume& volume = volumes[block];
    if (!volume.points)
    {
      continue;
    }
    Ijk counts{};
    for (int d = 0; d < 3; ++d)
    {
      DirectionSpans& direction = data->directions[block][d];
      direction.spans = nonEmptySpans(volume.degree[d], volume.knots[d]);
      direction.weights.resize(direction.spans.size());
      for (std::size_t s = 0; s < direction.spans.size(); ++s)
      {
        bezierWeights(volume.degree[d], volume.knots[d], direction.spans[s], direction.weights[s].data());
      }
      counts[d] = static_cast<int>(direction.spans.size());
    }
    for (int k = 0; k < counts[2]; k += BrickSize)
    {
      for (int j = 0; j < counts[1]; j += BrickSize)
      {
        for (int i = 0; i < counts[0]; i += BrickSize)
        {
          data->bricks.push_back({ block, { i, j, k } });
        }
      }
    }
  }
  std::vector<Box> boxes(data->bricks.size());
  run.parallelFor(static_cast<Index>(boxes.size()), 64, [&](Index begin, Index end) {
    for (Index n = begin; n < end; ++n)
    {
      const Brick& brick = data->bricks[n];
      const std::array<Ijk, 2> points = data->pointsOf(brick);
      boxes[n] = data->boxOfPoints(brick.block, points[0], points[1]);
    }
  });
  for (const Box& box : boxes)
  {
    data->box.extend(box);
  }
  data->tree = std::make_unique<const BoxTree>(boxes);
  this->Data = std::move(data);
}

VolumeLocator::~VolumeLocator() = default;
VolumeLocator::VolumeLocator(VolumeLocator&&) noexcept = default;
VolumeLocator& VolumeLocator::operator=(VolumeLocator&&) noexcept = default;

const Eigen::AlignedBox3d& VolumeLocator::bounds() const
{
  return this->Data->box;
}

VolumePlace VolumeLocator::locate(const Vec3& point, double tolerance) const
{
  const Spans& data = *this->Data;
  if (data.bricks.empty() || !point.allFinite())
  {
    return {};
  }
  std::vector<Index> candidates;
  data.tree->search(inflated(Box(point, point), tolerance), [&](Index brick) { candidates.push_back(brick); });
  std::sort(candidates.begin(), candidates.end());
  // All spans of the lowest block, in the order of their numbers, before those of the next.
  struct Candidate
  {
    int block;
    Ijk span;
    bool operator<(const Candidate& other) const
    {
      return std::tie(this->block, this->span[2], this->span[1], this->span[0]) <
        std::tie(other.block, other.span[2], other.span[1], other.span[0]);
    }
  };
  std::vector<Candidate> spans;
  for (const Index number : candidates)
  {
    const Brick& brick = data.bricks[number];
    const auto& directions = data.directions[brick.block];
    const std::array<int, 3>& degree = data.volume(brick.block).degree;
    Ijk end{};
    for (int d = 0; d < 3; ++d)
    {
      end[d] = std::min<int>(brick.first[d] + BrickSize, static_cast<int>(directions[d].spans.size()));
    }
    for (int k = brick.first[2]; k < end[2]; ++k)
    {
      for (int j = brick.first[1]; j < end[1]; ++j)
      {
        for (int i = brick.first[0]; i < end[0]; ++i)
        {
          const Ijk last{ directions[0].spans[i], directions[1].spans[j], directions[2].spans[k] };
          const Ijk first{ last[0] - degree[0], last[1] - degree[1], last[2] - degree[2] };
          if (!isBeyond(data.boxOfPoints(brick.block, first, last), point, tolerance))
          {
            spans.push_back({ brick.block, { i, j, k } });
          }
        }
      }
    }
  }
  std::sort(spans.begin(), spans.end());
  for (const Candidate& candidate : spans)
  {
    const Part part = data.bezierOf(candidate.block, candidate.span);
    if (const auto found = data.search(candidate.block, part, part.low, part.high, point, tolerance, 0))
    {
      return *found;
    }
  }
  return {};
}

} // namespace bsv
