// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/SpanRepair.h"

#include "Base/SparseArray.h"
#include "Complex/MeshPoints.h"
#include "Conversion/EdgeConversion.h"
#include "Conversion/FaceConversion.h"
#include "Conversion/VertexConversion.h"
#include "Quality/JacobianBounds.h"
#include "Quality/JacobianPenalty.h"
#include "Ranks/OwnedValues.h"
#include "Volume/BezierSegments.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <set>

namespace bsv
{

namespace
{

/// Block and number of the span, u fastest.
using SpanId = std::pair<int, Index>;
/// Numbers of spans per block, ascending.
using SpanLists = std::map<int, std::vector<Index>>;

/// Least ratio of det J to the cell's volume that a repaired span aims at.
constexpr double Aim = 0.05;
/// Spans that failed once are still looked after below these, while others fail and after that.
constexpr double Watched = 0.01, Finished = 0.02;
/// Longest step of a point in a sweep, in cells.
constexpr double LongestStep = 0.15;
/// Sweeps that a span fails before boundary points at its corners may move.
constexpr int Patience = 3;
constexpr int MaxSweeps = 60, MaxUntanglingSweeps = 300, MaxFinalSweeps = 15;

Ijk cellOf(const ComplexBlock& block, Index span)
{
  const Index n0 = block.cells(0), n1 = block.cells(1);
  return { static_cast<int>(span % n0), static_cast<int>(span / n0 % n1), static_cast<int>(span / n0 / n1) };
}

Index spanOf(const ComplexBlock& block, const Ijk& cell)
{
  return cell[0] + Index(block.cells(0)) * (cell[1] + Index(block.cells(1)) * cell[2]);
}

/// Sums whose bits do not depend on the order of the terms.
///@{
double sortedSum(std::vector<double> terms)
{
  std::sort(terms.begin(), terms.end());
  return std::accumulate(terms.begin(), terms.end(), 0.0);
}

Vec3 sortedSum(const std::vector<Vec3>& terms)
{
  Vec3 sum;
  std::vector<double> component(terms.size());
  for (int d = 0; d < 3; ++d)
  {
    std::transform(terms.begin(), terms.end(), component.begin(), [d](const Vec3& term) { return term[d]; });
    sum[d] = sortedSum(component);
  }
  return sum;
}
///@}

/// The sum of v v^T.
Eigen::Matrix3d sumOfSquares(const std::vector<Vec3>& vectors)
{
  std::vector<Vec3> diagonal, mixed;
  for (const Vec3& v : vectors)
  {
    diagonal.push_back(v.cwiseProduct(v));
    mixed.emplace_back(v[1] * v[2], v[2] * v[0], v[0] * v[1]);
  }
  const Vec3 d = sortedSum(diagonal), m = sortedSum(mixed);
  Eigen::Matrix3d result;
  result << d[0], m[2], m[1], m[2], d[1], m[0], m[1], m[0], d[2];
  return result;
}

BSplineVolume volumeOf(const ConversionContext& context, int block)
{
  BSplineVolume volume;
  for (int d = 0; d < 3; ++d)
  {
    volume.knots[d] = clampedIntegerKnots(context.complex.blocks[block].cells(d));
  }
  volume.points = context.nets[block].points;
  return volume;
}

/// Spans for which no proof of det J > 0 was found, with the codes of Validity.
std::map<SpanId, Validity> failingSpans(const ConversionContext& context, const SpanLists& lists, const Execution& run)
{
  struct Task
  {
    int block;
    const std::vector<Index>* spans;
    std::size_t first, last;
  };
  constexpr std::size_t Piece = 512;
  std::vector<Task> tasks;
  for (const auto& [block, spans] : lists)
  {
    for (std::size_t first = 0; first < spans.size(); first += Piece)
    {
      tasks.push_back({ block, &spans, first, std::min(spans.size(), first + Piece) });
    }
  }
  std::vector<std::vector<unsigned char>> codes(tasks.size());
  run.parallelFor(static_cast<Index>(tasks.size()), 1, [&](Index begin, Index end) {
    for (Index t = begin; t < end; ++t)
    {
      const Task& task = tasks[t];
      const std::vector<Index> spans(task.spans->begin() + task.first, task.spans->begin() + task.last);
      codes[t].resize(spans.size());
      JacobianOptions options;
      options.leftHanded = context.complex.blocks[task.block].leftHanded;
      options.spans = &spans;
      options.maxWitnesses = 0;
      JacobianArrays arrays;
      arrays.validity = codes[t].data();
      jacobianBounds(volumeOf(context, task.block), context.complex.blocks[task.block].name, options, arrays);
    }
  });
  std::map<SpanId, Validity> failing;
  for (std::size_t t = 0; t < tasks.size(); ++t)
  {
    for (std::size_t i = 0; i < codes[t].size(); ++i)
    {
      const Validity validity = static_cast<Validity>(codes[t][i]);
      if (validity != Validity::Valid)
      {
        failing[{ tasks[t].block, (*tasks[t].spans)[tasks[t].first + i] }] = validity;
      }
    }
  }
  return failing;
}

/// The spans that a control point made by a special rule belongs to, or a mesh point that was moved before.
std::vector<Index> specialSpans(const ConversionContext& context, int block)
{
  const ComplexBlock& owner = context.complex.blocks[block];
  const Ijk cells{ owner.cells(0), owner.cells(1), owner.cells(2) };
  std::vector<bool> chosen;
  const auto choose = [&](const Ijk& first, const Ijk& last) {
    chosen.resize(std::size_t(cells[0]) * cells[1] * cells[2], false);
    for (int k = std::max(0, first[2]); k <= std::min(last[2], cells[2] - 1); ++k)
    {
      for (int j = std::max(0, first[1]); j <= std::min(last[1], cells[1] - 1); ++j)
      {
        for (int i = std::max(0, first[0]); i <= std::min(last[0], cells[0] - 1); ++i)
        {
          chosen[spanOf(owner, { i, j, k })] = true;
        }
      }
    }
  };
  // Knot insertion is no special rule.
  bool spacing = false;
  for (int face = 0; face < 6; ++face)
  {
    spacing =
      spacing || context.layer.varies(block, face) || context.layer.weight(block, face, { 0, 0, 0 }) != KnotInsertion;
  }
  const auto isSpecial = [&](std::uint8_t code) {
    switch (static_cast<ControlPointRule>(code))
    {
      case ControlPointRule::BodyExtraordinaryVertex:
      case ControlPointRule::Crease:
      case ControlPointRule::Corner:
      case ControlPointRule::ExtraordinaryEdge:
      case ControlPointRule::SingularNode:
        return true;
      case ControlPointRule::WallLayer:
      case ControlPointRule::FarFieldLayer:
        return spacing;
      default:
        return false;
    }
  };
  for (int k = 0; k < cells[2] + 3; ++k)
  {
    for (int j = 0; j < cells[1] + 3; ++j)
    {
      const std::uint8_t* row = context.nets[block].rules + context.index(block, { 0, j, k });
      const bool through = j > 1 && j < cells[1] + 1 && k > 1 && k < cells[2] + 1;
      for (int i = 0; i < cells[0] + 3; ++i)
      {
        if (through && i == 2)
        {
          i = std::max(i, cells[0] + 1);
        }
        if (isSpecial(row[i]))
        {
          choose({ i - 3, j - 3, k - 3 }, { i, j, k });
        }
      }
    }
  }
  if (owner.points.changes())
  {
    for (int k = 0; k <= cells[2]; ++k)
    {
      for (int j = 0; j <= cells[1]; ++j)
      {
        for (int i = 0; i <= cells[0]; ++i)
        {
          if (owner.points.changes()->find(owner.points.start() + owner.points.offset({ i, j, k })))
          {
            choose({ i - 2, j - 2, k - 2 }, { i + 1, j + 1, k + 1 });
          }
        }
      }
    }
  }
  std::vector<Index> spans;
  for (std::size_t span = 0; span < chosen.size(); ++span)
  {
    if (chosen[span])
    {
      spans.push_back(static_cast<Index>(span));
    }
  }
  return spans;
}

/// Writes the control points owned by a mesh point.
void convertPoint(const ConversionContext& context, const MeshPointKey& key)
{
  switch (key[0])
  {
    case 0:
      convertVertex(context, key[1]);
      break;
    case 1:
      convertEdgeLayers(context, key[1], key[2], key[2] + 1);
      break;
    case 2:
      convertFacePoints(context, key[1], { key[2], key[3] }, { key[2] + 1, key[3] + 1 });
      break;
    default: {
      const Ijk ijk{ key[2], key[3], key[4] };
      context.write(key[1], { innerPosition(ijk[0]), innerPosition(ijk[1]), innerPosition(ijk[2]) },
        context.point(key[1], ijk), ControlPointRule::Copied);
    }
  }
}

/// First and last position in a control net of the control points owned by mesh point i of a direction.
std::array<int, 2> positionsOf(int i, int cells)
{
  return i == 0  ? std::array<int, 2>{ 0, 1 }
    : i == cells ? std::array<int, 2>{ cells + 1, cells + 2 }
                 : std::array<int, 2>{ innerPosition(i), innerPosition(i) };
}

int meshIndexOf(int position, int cells)
{
  return std::clamp(position - 1, 0, cells);
}

/// How a mesh point may move.
enum class Freedom : std::uint8_t
{
  Inner,
  Surface, ///< on the outer surface; in its plane, where it is one
  Curve,   ///< on a crease or border of it
  Fixed
};

Freedom freedomOf(const ConversionContext& context, const MeshPointKey& key)
{
  bool boundary = false;
  std::set<std::pair<int, int>> features;
  for (const MeshPointCopy& copy : copiesOf(context.complex, key))
  {
    const ComplexBlock& block = context.complex.blocks[copy.block];
    std::array<bool, 3> atEnd;
    std::array<int, 3> side;
    for (int d = 0; d < 3; ++d)
    {
      side[d] = copy.ijk[d] == 0 ? 0 : 1;
      atEnd[d] = copy.ijk[d] == 0 || copy.ijk[d] == block.cells(d);
      if (!atEnd[d])
      {
        continue;
      }
      const int face = block.faces[2 * d + side[d]];
      const FaceRule& rule = context.rules.faces[face];
      if (rule.connection || context.isWall(face))
      {
        return Freedom::Fixed;
      }
      boundary = boundary || context.complex.faces[face].boundary();
    }
    for (int along = 0; along < 3; ++along)
    {
      const int a = faceAxis(2 * along, 0), b = faceAxis(2 * along, 1);
      if (atEnd[a] && atEnd[b])
      {
        const int blockEdge = edgeIndex(along, side[a], side[b]);
        const int edge = block.edges[blockEdge];
        if (context.rules.edges[edge].feature)
        {
          const bool second = atEnd[along] && (side[along] == 1) != block.edgeReversed[blockEdge];
          features.insert({ edge, atEnd[along] ? (second ? 1 : 0) : 0 });
        }
      }
    }
  }
  if (!boundary)
  {
    return Freedom::Inner;
  }
  if (features.empty())
  {
    return Freedom::Surface;
  }
  return key[0] == 1 || features.size() == 2 ? Freedom::Curve : Freedom::Fixed;
}

/// What a step in units of cells is in space, and back.
struct PointFrame
{
  /// By columns.
  std::array<double, 9> step;
  std::array<double, 9> cells;

  Eigen::Matrix3d stepMatrix() const { return Eigen::Map<const Eigen::Matrix3d>(this->step.data()); }
  Eigen::Matrix3d cellMatrix() const { return Eigen::Map<const Eigen::Matrix3d>(this->cells.data()); }
};

/// All points around must be known on this rank.
PointFrame pointFrame(const ConversionContext& context, const MeshPointKey& key)
{
  const Freedom freedom = freedomOf(context, key);
  std::vector<Vec3> edges, normals, along;
  double cells = 0.0;
  for (const MeshPointCopy& copy : copiesOf(context.complex, key))
  {
    const ComplexBlock& block = context.complex.blocks[copy.block];
    const Vec3 x = block.points(copy.ijk);
    const auto edge = [&](int d, int way) {
      Ijk other = copy.ijk;
      other[d] += way;
      return Vec3(block.points(other) - x);
    };
    const auto inside = [&](int d, int way) { return copy.ijk[d] + way >= 0 && copy.ijk[d] + way <= block.cells(d); };
    for (int corner = 0; corner < 8; ++corner)
    {
      const std::array<int, 3> way{ corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1 };
      if (!inside(0, way[0]) || !inside(1, way[1]) || !inside(2, way[2]))
      {
        continue;
      }
      cells += 1.0;
      for (int d = 0; d < 3; ++d)
      {
        edges.push_back(edge(d, way[d]));
        // A cell's face on a plane of the outer surface.
        const bool atEnd = copy.ijk[d] == (way[d] > 0 ? 0 : block.cells(d));
        const int face = block.faces[2 * d + (way[d] > 0 ? 0 : 1)];
        const FaceRule& rule = context.rules.faces[face];
        if (atEnd && context.complex.faces[face].boundary() && (rule.planar() || rule.role == BoundaryRole::Symmetry))
        {
          const int a = faceAxis(2 * d, 0), b = faceAxis(2 * d, 1);
          normals.push_back(edge(a, way[a]).cross(edge(b, way[b])).normalized());
        }
      }
    }
    for (int d = 0; d < 3 && freedom == Freedom::Curve; ++d)
    {
      // Edges of the block with a feature through the point.
      const int a = faceAxis(2 * d, 0), b = faceAxis(2 * d, 1);
      const auto isEnd = [&](int axis) { return copy.ijk[axis] == 0 || copy.ijk[axis] == block.cells(axis); };
      if (isEnd(a) && isEnd(b) &&
        context.rules.edges[block.edges[edgeIndex(d, copy.ijk[a] == 0 ? 0 : 1, copy.ijk[b] == 0 ? 0 : 1)]].feature)
      {
        for (const int way : { -1, 1 })
        {
          if (inside(d, way))
          {
            along.push_back(edge(d, way).normalized());
          }
        }
      }
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(sumOfSquares(edges) / cells);
  Eigen::Matrix3d matrix = solver.operatorSqrt();
  const Eigen::Matrix3d inverse = solver.operatorInverseSqrt();
  if (freedom == Freedom::Curve)
  {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> lines(sumOfSquares(along));
    const Vec3 tangent = lines.eigenvectors().col(2);
    matrix = (tangent * (tangent.transpose() * matrix)).eval();
  }
  else if (!normals.empty())
  {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> planes(sumOfSquares(normals));
    Eigen::Matrix3d projection = Eigen::Matrix3d::Zero();
    for (int i = 0; i < 3; ++i)
    {
      if (planes.eigenvalues()[i] < 0.01 * planes.eigenvalues()[2])
      {
        projection += planes.eigenvectors().col(i) * planes.eigenvectors().col(i).transpose();
      }
    }
    matrix = (projection * matrix).eval();
  }
  PointFrame frame;
  Eigen::Map<Eigen::Matrix3d>(frame.step.data()) = matrix;
  Eigen::Map<Eigen::Matrix3d>(frame.cells.data()) = inverse;
  return frame;
}

/// Control points owned by a mesh point, in blocks of this rank, as combinations of mesh points that may move.
struct PointMap
{
  std::vector<MeshPointKey> inputs;
  /// Block and place in its net.
  std::vector<std::pair<int, Index>> outputs;
  /// Of input i in output o at [o * inputs.size() + i].
  std::vector<double> weights;
};

class Repair
{
public:
  Repair(const ConversionContext& context, const Execution& run)
    : Context(context)
    , Run(run)
    , Group(*run.ranks)
  {
  }

  /// @param failing spans of this rank that are not proven valid.
  void operator()(const std::map<SpanId, Validity>& failing, SpanReport& report)
  {
    this->Group.together([&] {
      for (const auto& entry : failing)
      {
        if (this->addEntry(entry.first))
        {
          Entry& added = this->Entries.at(entry.first);
          added.failedFirst = true;
          added.validity = entry.second;
        }
      }
    });
    if (this->Context.options.repairSpans || this->Context.options.untangle)
    {
      this->sweepAll(report);
    }
    this->describe(report);
  }

private:
  struct Entry
  {
    /// Volume of the mesh cell, Bezier weights and control points in the cell's canonical frame.
    double scale = 0.0;
    std::array<std::array<double, 16>, 3> bezier;
    std::array<Index, 64> control;
    std::array<MeshPointKey, 64> owners;
    std::array<MeshPointKey, 8> corners;
    Validity validity = Validity::Undecided;
    bool failedFirst = false;
    int failures = 0; ///< in a row
    SpanPenalty penalty;

    bool failing() const { return this->validity != Validity::Valid; }
  };

  /// @return false if the mesh cell itself is not valid.
  bool addEntry(const SpanId& id)
  {
    if (this->Entries.count(id) > 0)
    {
      return true;
    }
    if (this->InvalidCells.count(id) > 0)
    {
      return false;
    }
    const ComplexBlock& block = this->Context.complex.blocks[id.first];
    const Ijk cell = cellOf(block, id.second);
    std::array<Vec3, 8> corners;
    for (int c = 0; c < 8; ++c)
    {
      corners[c] = block.points({ cell[0] + cornerSide(c, 0), cell[1] + cornerSide(c, 1), cell[2] + cornerSide(c, 2) });
    }
    const bool validCell = this->isValidCell(block, corners);
    if (!validCell && !this->Context.options.untangle)
    {
      this->InvalidCells.insert(id);
      return false;
    }
    // The frame: its origin is the smallest corner, its axes are sorted by their other ends.
    const auto before = [&](int a, int b) {
      return std::lexicographical_compare(
        corners[a].data(), corners[a].data() + 3, corners[b].data(), corners[b].data() + 3);
    };
    int origin = 0;
    for (int c = 1; c < 8; ++c)
    {
      origin = before(c, origin) ? c : origin;
    }
    std::array<int, 3> axes{ 0, 1, 2 };
    std::sort(axes.begin(), axes.end(), [&](int a, int b) { return before(origin ^ (1 << a), origin ^ (1 << b)); });
    Entry& entry = this->Entries[id];
    for (int d = 0; d < 3; ++d)
    {
      double weights[16];
      bezierWeights(3, clampedIntegerKnots(block.cells(axes[d])), 3 + cell[axes[d]], weights);
      for (int q = 0; q < 16; ++q)
      {
        entry.bezier[d][q] = weights[cornerSide(origin, axes[d]) ? 15 - q : q];
      }
    }
    const Ijk cells{ block.cells(0), block.cells(1), block.cells(2) };
    for (int p = 0; p < 64; ++p)
    {
      Ijk position, ijk;
      for (int d = 0; d < 3; ++d)
      {
        const int step = p >> (2 * d) & 3;
        const int axis = axes[d];
        position[axis] = cell[axis] + (cornerSide(origin, axis) ? 3 - step : step);
        ijk[axis] = meshIndexOf(position[axis], cells[axis]);
      }
      entry.control[p] = this->Context.index(id.first, position);
      entry.owners[p] = meshPointKey(this->Context.complex, id.first, ijk);
    }
    for (int c = 0; c < 8; ++c)
    {
      entry.corners[c] = meshPointKey(this->Context.complex, id.first,
        { cell[0] + cornerSide(c, 0), cell[1] + cornerSide(c, 1), cell[2] + cornerSide(c, 2) });
    }
    // The mean of the cell's det J, of degree 2 per direction: two Gauss points each.
    const double gauss = 0.5 - 0.5 / std::sqrt(3.0);
    for (int g = 0; g < 8; ++g)
    {
      std::array<Vec3, 3> derivatives;
      derivatives.fill(Vec3::Zero());
      for (int c = 0; c < 8; ++c)
      {
        int corner = origin;
        for (int d = 0; d < 3; ++d)
        {
          corner ^= (c >> d & 1) << axes[d];
        }
        for (int d = 0; d < 3; ++d)
        {
          double weight = 1.0;
          for (int e = 0; e < 3; ++e)
          {
            const double t = g >> e & 1 ? 1.0 - gauss : gauss;
            weight *= e == d ? (c >> e & 1 ? 1.0 : -1.0) : (c >> e & 1 ? t : 1.0 - t);
          }
          derivatives[d] += weight * (corners[corner] - corners[origin]);
        }
      }
      entry.scale += derivatives[0].dot(derivatives[1].cross(derivatives[2])) / 8.0;
    }
    if (!validCell)
    {
      // The volume of a cell with the mean edges around, in the sense of the block.
      std::vector<double> volumes;
      for (const MeshPointKey& corner : entry.corners)
      {
        volumes.push_back(1.0 / pointFrame(this->Context, corner).cellMatrix().determinant());
      }
      const int flips = cornerSide(origin, 0) + cornerSide(origin, 1) + cornerSide(origin, 2) + (axes[0] > axes[1]) +
        (axes[0] > axes[2]) + (axes[1] > axes[2]) + (block.leftHanded ? 1 : 0);
      entry.scale = (flips % 2 ? -1.0 : 1.0) * sortedSum(volumes) / 8.0;
    }
    return true;
  }

  static bool isValidCell(const ComplexBlock& block, const std::array<Vec3, 8>& corners)
  {
    BSplineVolume trilinear;
    trilinear.degree = { 1, 1, 1 };
    trilinear.knots.fill({ 0.0, 0.0, 1.0, 1.0 });
    trilinear.points = corners[0].data();
    JacobianOptions options;
    options.leftHanded = block.leftHanded;
    return jacobianBounds(trilinear, block.name, options).valid == 1;
  }

  bool anyFails() const
  {
    return this->Group.any(std::any_of(
      this->Entries.begin(), this->Entries.end(), [](const auto& entry) { return entry.second.failing(); }));
  }

  void sweepAll(SpanReport& report)
  {
    const int most = this->Context.options.untangle ? MaxUntanglingSweeps : MaxSweeps;
    while (report.sweeps < most && this->anyFails())
    {
      this->Group.together([&] { this->Run.report(0.95); });
      ++report.sweeps;
      const bool moved = this->sweep(Watched);
      const bool released = this->release();
      if (!moved && !released && report.sweeps > Patience)
      {
        break;
      }
    }
    if (this->anyFails())
    {
      this->takeBackFailures();
      return;
    }
    for (int i = 0; i < MaxFinalSweeps; ++i)
    {
      const PointOffsets before = this->Offsets;
      if (!this->sweep(Finished))
      {
        break;
      }
      if (this->anyFails())
      {
        this->restore(before);
        break;
      }
      ++report.sweeps;
    }
  }

  /// One sweep over the spans that fail, and those that did and have a least ratio below `watched`.
  /// @return whether any point moved on any rank.
  bool sweep(double watched)
  {
    std::vector<Entry*> entries, active;
    for (auto& entry : this->Entries)
    {
      entries.push_back(&entry.second);
    }
    std::vector<int> blocks;
    for (const auto& entry : this->Entries)
    {
      blocks.push_back(entry.first.first);
    }
    std::vector<MeshPointKey> wanted;
    this->Group.together([&] {
      this->Run.parallelFor(static_cast<Index>(entries.size()), 4, [&](Index begin, Index end) {
        for (Index i = begin; i < end; ++i)
        {
          SpanControl control;
          for (int p = 0; p < 64; ++p)
          {
            control[p] = Eigen::Map<const Vec3>(this->Context.nets[blocks[i]].points + 3 * entries[i]->control[p]);
          }
          entries[i]->penalty = spanPenalty(control, entries[i]->bezier, entries[i]->scale, Aim);
        }
      });
      std::copy_if(entries.begin(), entries.end(), std::back_inserter(active),
        [&](const Entry* entry) { return entry->failing() || entry->penalty.least < watched; });
      this->makeMaps(active);
      for (const Entry* entry : active)
      {
        for (const MeshPointKey& owner : entry->owners)
        {
          const std::vector<MeshPointKey>& inputs = this->Maps.at(owner).inputs;
          std::copy_if(inputs.begin(), inputs.end(), std::back_inserter(wanted),
            [&](const MeshPointKey& key) { return this->Frames.count(key) == 0; });
        }
      }
    });
    this->makeFrames(std::move(wanted));

    std::vector<Proposal> proposals;
    this->Group.together([&] {
      std::vector<std::vector<Proposal>> parts(active.size());
      std::map<const Entry*, int> blockOf;
      for (std::size_t i = 0; i < entries.size(); ++i)
      {
        blockOf[entries[i]] = blocks[i];
      }
      this->Run.parallelFor(static_cast<Index>(active.size()), 4, [&](Index begin, Index end) {
        for (Index i = begin; i < end; ++i)
        {
          parts[i] = this->propose(*active[i], blockOf.at(active[i]));
        }
      });
      for (const std::vector<Proposal>& part : parts)
      {
        proposals.insert(proposals.end(), part.begin(), part.end());
      }
    });
    proposals = this->Group.gatherAll(proposals);
    std::stable_sort(
      proposals.begin(), proposals.end(), [](const Proposal& a, const Proposal& b) { return a.point < b.point; });
    std::vector<MeshPointKey> moved;
    for (std::size_t first = 0; first < proposals.size();)
    {
      std::size_t last = first;
      std::vector<Vec3> steps;
      std::vector<double> shares;
      for (; last < proposals.size() && proposals[last].point == proposals[first].point; ++last)
      {
        steps.emplace_back(proposals[last].step.data());
        shares.push_back(proposals[last].share);
      }
      const MeshPointKey& point = proposals[first].point;
      const Vec3 step = sortedSum(steps) / std::max(1.0, sortedSum(shares));
      const Vec3 offset = this->Frames.at(point).stepMatrix() * step;
      if (offset != Vec3::Zero())
      {
        this->Offsets.emplace(point, Vec3::Zero()).first->second += offset;
        moved.push_back(point);
      }
      first = last;
    }
    this->update(moved);
    for (auto& entry : this->Entries)
    {
      entry.second.failures = entry.second.failing() ? entry.second.failures + 1 : 0;
    }
    return !moved.empty();
  }

  struct Proposal
  {
    MeshPointKey point;
    std::array<double, 3> step;
    double share;
  };

  /// The step of one span.
  std::vector<Proposal> propose(const Entry& entry, int block) const
  {
    std::map<MeshPointKey, Vec3> gradient;
    for (int p = 0; p < 64; ++p)
    {
      const PointMap& map = this->Maps.at(entry.owners[p]);
      const auto at = std::lower_bound(map.outputs.begin(), map.outputs.end(), std::make_pair(block, entry.control[p]));
      const std::size_t row = (at - map.outputs.begin()) * map.inputs.size();
      for (std::size_t i = 0; i < map.inputs.size(); ++i)
      {
        if (map.weights[row + i] != 0.0)
        {
          gradient.emplace(map.inputs[i], Vec3::Zero()).first->second +=
            map.weights[row + i] * entry.penalty.gradient[p];
        }
      }
    }
    std::vector<Proposal> result;
    std::vector<double> squares;
    double longest = 0.0;
    for (auto& [point, g] : gradient)
    {
      if (freedomOf(this->Context, point) != Freedom::Inner && this->Released.count(point) == 0)
      {
        continue;
      }
      g = this->Frames.at(point).stepMatrix().transpose() * g;
      const double square = g.squaredNorm();
      if (square > 0.0)
      {
        result.push_back({ point, { g[0], g[1], g[2] }, std::sqrt(square) });
        squares.push_back(square);
        longest = std::max(longest, std::sqrt(square));
      }
    }
    if (result.empty())
    {
      return result;
    }
    const double square = sortedSum(squares);
    double scale = 2.0 * entry.penalty.value / square;
    scale = std::min(scale, LongestStep / longest);
    for (Proposal& proposal : result)
    {
      for (double& x : proposal.step)
      {
        x *= -scale;
      }
      proposal.share /= std::sqrt(square);
    }
    return result;
  }

  /// Lets boundary points at the corners of spans move that keep failing. @return whether any is new on any rank.
  bool release()
  {
    std::vector<MeshPointKey> points;
    for (const auto& entry : this->Entries)
    {
      for (const MeshPointKey& corner : entry.second.corners)
      {
        const Freedom freedom = freedomOf(this->Context, corner);
        if (entry.second.failures >= Patience && (freedom == Freedom::Surface || freedom == Freedom::Curve) &&
          this->Released.count(corner) == 0)
        {
          points.push_back(corner);
        }
      }
    }
    points = this->Group.gatherAll(points);
    this->Released.insert(points.begin(), points.end());
    return !points.empty();
  }

  /// Makes the maps of all owners of control points of these spans.
  void makeMaps(const std::vector<Entry*>& entries)
  {
    std::vector<std::pair<const MeshPointKey, PointMap>*> missing;
    for (const Entry* entry : entries)
    {
      for (const MeshPointKey& owner : entry->owners)
      {
        const auto [at, isNew] = this->Maps.emplace(owner, PointMap{});
        if (isNew)
        {
          missing.push_back(&*at);
        }
      }
    }
    this->Run.parallelFor(static_cast<Index>(missing.size()), 4, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i)
      {
        missing[i]->second = this->pointMap(missing[i]->first);
      }
    });
  }

  PointMap pointMap(const MeshPointKey& owner) const
  {
    PointMap map;
    // By their places: rounding must not depend on the numbering.
    std::vector<std::pair<std::array<double, 3>, MeshPointKey>> inputs;
    for (const MeshPointKey& key : neighboursOf(this->Context.complex, owner))
    {
      const std::optional<Vec3> x = this->find(key);
      if (x && freedomOf(this->Context, key) != Freedom::Fixed)
      {
        inputs.push_back({ { (*x)[0], (*x)[1], (*x)[2] }, key });
      }
    }
    std::sort(inputs.begin(), inputs.end());
    for (const auto& input : inputs)
    {
      map.inputs.push_back(input.second);
    }
    for (const MeshPointCopy& copy : copiesOf(this->Context.complex, owner))
    {
      if (this->Context.isHere(copy.block))
      {
        this->forControlPoints(copy, [&](const Ijk& position) {
          map.outputs.emplace_back(copy.block, this->Context.index(copy.block, position));
        });
      }
    }
    std::sort(map.outputs.begin(), map.outputs.end());
    map.outputs.erase(std::unique(map.outputs.begin(), map.outputs.end()), map.outputs.end());
    const auto read = [&] {
      std::vector<Vec3> values;
      for (const auto& [block, at] : map.outputs)
      {
        values.emplace_back(this->Context.nets[block].points + 3 * at);
      }
      return values;
    };

    // The rules are linear: differences, with three points moved at a time, each along an axis of its own.
    const std::vector<Vec3> now = read();
    const PointOffsets none;
    MovedPoints moved{ this->Context.complex, none };
    ConversionContext context = this->Context;
    context.moved = &moved;
    convertPoint(context, owner);
    const std::vector<Vec3> base = read();
    const Vec3 center = *this->find(owner);
    double length = 0.0;
    for (const MeshPointKey& key : map.inputs)
    {
      length = std::max(length, (*this->find(key) - center).norm());
    }
    map.weights.assign(map.outputs.size() * map.inputs.size(), 0.0);
    for (std::size_t first = 0; first < map.inputs.size() && length > 0.0; first += 3)
    {
      moved.trials.clear();
      for (std::size_t i = first; i < std::min(first + 3, map.inputs.size()); ++i)
      {
        moved.trials.emplace_back(map.inputs[i], length * Vec3::Unit(i - first));
      }
      convertPoint(context, owner);
      const std::vector<Vec3> values = read();
      for (std::size_t o = 0; o < values.size(); ++o)
      {
        for (std::size_t i = first; i < std::min(first + 3, map.inputs.size()); ++i)
        {
          const double weight = (values[o] - base[o])[i - first] / length;
          map.weights[o * map.inputs.size() + i] = std::abs(weight) > 1e-9 ? weight : 0.0;
        }
      }
    }
    for (std::size_t o = 0; o < map.outputs.size(); ++o)
    {
      std::copy_n(now[o].data(), 3, this->Context.nets[map.outputs[o].first].points + 3 * map.outputs[o].second);
    }
    return map;
  }

  /// Where the mesh has a point, if it is known here.
  std::optional<Vec3> find(const MeshPointKey& key) const
  {
    for (const MeshPointCopy& copy : copiesOf(this->Context.complex, key))
    {
      const GridView& points = this->Context.complex.blocks[copy.block].points;
      if (points.has(copy.ijk))
      {
        return points(copy.ijk);
      }
    }
    return {};
  }

  template <typename Visit>
  void forControlPoints(const MeshPointCopy& copy, const Visit& visit) const
  {
    const ComplexBlock& block = this->Context.complex.blocks[copy.block];
    std::array<std::array<int, 2>, 3> range;
    for (int d = 0; d < 3; ++d)
    {
      range[d] = positionsOf(copy.ijk[d], block.cells(d));
    }
    for (int k = range[2][0]; k <= range[2][1]; ++k)
    {
      for (int j = range[1][0]; j <= range[1][1]; ++j)
      {
        for (int i = range[0][0]; i <= range[0][1]; ++i)
        {
          visit(Ijk{ i, j, k });
        }
      }
    }
  }

  /// The frames of these points and those that other ranks want.
  void makeFrames(std::vector<MeshPointKey> wanted)
  {
    const auto sort = [&] {
      std::sort(wanted.begin(), wanted.end());
      wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
    };
    sort();
    wanted = this->Group.gatherAll(wanted);
    sort();
    const std::vector<PointFrame> frames = gatherFromOwners<PointFrame>(
      this->Group, wanted.size(),
      [&](std::size_t i) {
        return this->Context.complex.blocks[copiesOf(this->Context.complex, wanted[i]).front().block].rank;
      },
      [&](std::size_t i) { return pointFrame(this->Context, wanted[i]); });
    for (std::size_t i = 0; i < wanted.size(); ++i)
    {
      this->Frames.emplace(wanted[i], frames[i]);
    }
  }

  /// Converts and judges again what depends on points that have moved.
  void update(const std::vector<MeshPointKey>& moved)
  {
    this->Group.together([&] {
      std::set<MeshPointKey> owners;
      for (const MeshPointKey& key : moved)
      {
        for (const MeshPointKey& owner : neighboursOf(this->Context.complex, key))
        {
          owners.insert(owner);
        }
      }
      std::vector<MeshPointKey> here;
      std::map<int, std::set<Index>> spans;
      for (const MeshPointKey& owner : owners)
      {
        bool isHere = false;
        for (const MeshPointCopy& copy : copiesOf(this->Context.complex, owner))
        {
          if (!this->Context.isHere(copy.block))
          {
            continue;
          }
          isHere = true;
          const ComplexBlock& block = this->Context.complex.blocks[copy.block];
          Ijk low, high;
          for (int d = 0; d < 3; ++d)
          {
            const auto range = positionsOf(copy.ijk[d], block.cells(d));
            low[d] = std::max(0, range[0] - 3);
            high[d] = std::min(range[1], block.cells(d) - 1);
          }
          for (int k = low[2]; k <= high[2]; ++k)
          {
            for (int j = low[1]; j <= high[1]; ++j)
            {
              for (int i = low[0]; i <= high[0]; ++i)
              {
                spans[copy.block].insert(spanOf(block, { i, j, k }));
              }
            }
          }
        }
        if (isHere)
        {
          here.push_back(owner);
        }
      }
      const MovedPoints points{ this->Context.complex, this->Offsets };
      ConversionContext context = this->Context;
      context.moved = &points;
      this->Run.parallelFor(static_cast<Index>(here.size()), 8, [&](Index begin, Index end) {
        for (Index i = begin; i < end; ++i)
        {
          convertPoint(context, here[i]);
        }
      });
      SpanLists lists;
      for (const auto& [block, numbers] : spans)
      {
        lists[block].assign(numbers.begin(), numbers.end());
      }
      const std::map<SpanId, Validity> failing = failingSpans(this->Context, lists, this->Run);
      for (const auto& [block, numbers] : lists)
      {
        for (const Index number : numbers)
        {
          const SpanId id{ block, number };
          const auto found = failing.find(id);
          if (found != failing.end() ? this->addEntry(id) : this->Entries.count(id) > 0)
          {
            this->Entries.at(id).validity = found != failing.end() ? found->second : Validity::Valid;
          }
        }
      }
    });
  }

  void restore(const PointOffsets& before)
  {
    std::vector<MeshPointKey> changed;
    for (const auto& [point, offset] : this->Offsets)
    {
      const auto found = before.find(point);
      if (found == before.end() || found->second != offset)
      {
        changed.push_back(point);
      }
    }
    this->Offsets = before;
    this->update(changed);
  }

  /// Puts points back where spans that failed are linked by them and fewer of them did not become valid, or others
  /// failed.
  void takeBackFailures()
  {
    struct Link
    {
      MeshPointKey first, second;
      int failed, fails;
    };
    std::vector<Link> links;
    for (const auto& entry : this->Entries)
    {
      std::set<MeshPointKey> points;
      for (const MeshPointKey& owner : entry.second.owners)
      {
        const auto map = this->Maps.find(owner);
        const std::vector<MeshPointKey> inputs =
          map == this->Maps.end() ? neighboursOf(this->Context.complex, owner) : map->second.inputs;
        std::copy_if(inputs.begin(), inputs.end(), std::inserter(points, points.end()),
          [&](const MeshPointKey& key) { return this->Offsets.count(key) > 0; });
      }
      for (const MeshPointKey& point : points)
      {
        const bool first = point == *points.begin();
        links.push_back({ *points.begin(), point, first && entry.second.failedFirst, first && entry.second.failing() });
        if (first && entry.second.failing() && !entry.second.failedFirst)
        {
          links.back().fails = 1 << 20;
        }
      }
    }
    links = this->Group.gatherAll(links);
    std::map<MeshPointKey, MeshPointKey> parent;
    const auto rootOf = [&](MeshPointKey key) {
      parent.emplace(key, key);
      while (parent.at(key) != key)
      {
        key = parent.at(key);
      }
      return key;
    };
    for (const Link& link : links)
    {
      const MeshPointKey a = rootOf(link.first), b = rootOf(link.second);
      parent[std::max(a, b)] = std::min(a, b);
    }
    std::map<MeshPointKey, std::array<Index, 2>> counts;
    for (const Link& link : links)
    {
      std::array<Index, 2>& count = counts[rootOf(link.first)];
      count[0] += link.failed;
      count[1] += link.fails;
    }
    PointOffsets kept;
    for (const auto& offset : this->Offsets)
    {
      const auto count = counts.find(rootOf(offset.first));
      if (count == counts.end() || count->second[1] < std::max<Index>(1, count->second[0]))
      {
        kept.insert(offset);
      }
    }
    this->restore(kept);
  }

  void describe(SpanReport& report) const
  {
    struct Place
    {
      int block;
      Ijk cell;
      Validity validity;
    };
    std::vector<Place> left;
    std::array<Index, 3> counts{ 0, 0, static_cast<Index>(this->InvalidCells.size()) };
    for (const auto& [id, entry] : this->Entries)
    {
      counts[0] += entry.failedFirst ? 1 : 0;
      counts[1] += entry.failedFirst && !entry.failing() ? 1 : 0;
      if (entry.failing())
      {
        left.push_back({ id.first, cellOf(this->Context.complex.blocks[id.first], id.second), entry.validity });
      }
    }
    for (const std::array<Index, 3>& part : this->Group.gatherAll(std::vector<std::array<Index, 3>>{ counts }))
    {
      report.failed += part[0];
      report.repaired += part[1];
      report.invalidCells += part[2];
    }
    for (const std::vector<Place>& part : this->Group.gather(left))
    {
      for (const Place& place : part)
      {
        (place.validity == Validity::Invalid ? report.invalid : report.undecided) += 1;
        report.left.push_back({ place.block, place.cell });
      }
    }
    for (const auto& [point, offset] : this->Offsets)
    {
      if (offset != Vec3::Zero())
      {
        ++report.movedPoints;
        report.largestMove = std::max(report.largestMove, offset.norm());
        report.largestMoveInCells =
          std::max(report.largestMoveInCells, (this->Frames.at(point).cellMatrix() * offset).norm());
      }
    }
  }

  const ConversionContext& Context;
  const Execution& Run;
  const Ranks& Group;
  std::map<SpanId, Entry> Entries;
  std::set<SpanId> InvalidCells;
  /// The same on all ranks.
  ///@{
  PointOffsets Offsets;
  std::map<MeshPointKey, PointFrame> Frames;
  std::set<MeshPointKey> Released;
  ///@}
  std::map<MeshPointKey, PointMap> Maps;
};

} // namespace

SpanReport checkSpans(const ConversionContext& context, const Execution& run)
{
  SpanReport report;
  const bool all = context.options.checkSpans == CheckSpans::All || context.options.untangle;
  if (context.options.checkSpans == CheckSpans::None && !all)
  {
    return report;
  }
  std::map<SpanId, Validity> failing;
  Index checked = 0;
  run.ranks->together([&] {
    std::vector<std::vector<Index>> spans(context.complex.blocks.size());
    run.parallelFor(static_cast<Index>(spans.size()), 1, [&](Index begin, Index end) {
      for (int block = static_cast<int>(begin); block < end; ++block)
      {
        if (!context.isHere(block))
        {
          continue;
        }
        if (!all)
        {
          spans[block] = specialSpans(context, block);
          continue;
        }
        const ComplexBlock& owner = context.complex.blocks[block];
        spans[block].resize(std::size_t(owner.cells(0)) * owner.cells(1) * owner.cells(2));
        std::iota(spans[block].begin(), spans[block].end(), Index(0));
      }
    });
    SpanLists lists;
    for (std::size_t block = 0; block < spans.size(); ++block)
    {
      if (!spans[block].empty())
      {
        checked += static_cast<Index>(spans[block].size());
        lists[static_cast<int>(block)] = std::move(spans[block]);
      }
    }
    failing = failingSpans(context, lists, run);
  });
  for (const Index part : run.ranks->gatherAll(std::vector<Index>{ checked }))
  {
    report.checked += part;
  }
  if (run.ranks->any(!failing.empty()))
  {
    Repair(context, run)(failing, report);
  }
  return report;
}

} // namespace bsv
