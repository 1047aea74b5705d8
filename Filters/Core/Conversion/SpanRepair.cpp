// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/SpanRepair.h"

#include "Base/CanonicalOrder.h"
#include "Base/SortedSum.h"
#include "Conversion/DoubleKnots.h"
#include "Conversion/PointFrame.h"
#include "Conversion/PointMap.h"
#include "Conversion/SpanCheck.h"
#include "Quality/JacobianPenalty.h"
#include "Ranks/OwnedValues.h"
#include "Volume/BezierSegments.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>

namespace bsv
{

namespace
{

/// Least ratio of det J to the cell's volume that a repaired span aims at.
constexpr double Aim = 0.05;
/// Spans that failed once are still looked after below these, while others fail and after that.
constexpr double Watched = 0.01, Finished = 0.02;
/// Longest step of a point in a sweep, in cells.
constexpr double LongestStep = 0.15;
/// Sweeps that a span fails before boundary points at its corners may move.
constexpr int Patience = 3;
/// Sweeps without progress after which there is none to be expected: fewer failing spans than ever, or a penalty of all
/// that is smaller than ever by a part of 1 / 64.
constexpr int MaxIdleSweeps = 12, MaxIdleUntanglingSweeps = 60;
constexpr int MaxSweeps = 60, MaxUntanglingSweeps = 300, MaxFinalSweeps = 15;

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
    for (const auto& [id, validity] : failing)
    {
      this->setValidity(id, validity);
    }
    for (auto& entry : this->Entries)
    {
      entry.second.failedFirst = true;
    }
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

  void setValidity(const SpanId& id, Validity validity)
  {
    if (validity == Validity::Valid)
    {
      this->InvalidCells.erase(id);
    }
    if (validity == Validity::Valid ? this->Entries.count(id) > 0 : this->addEntry(id))
    {
      this->Entries.at(id).validity = validity;
    }
    else if (validity != Validity::Valid)
    {
      this->InvalidCells[id] = validity;
    }
  }

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
    const std::array<Vec3, 8> corners = givenCorners(block, cell);
    const bool validCell = isValidCell(block, corners);
    if (!validCell && !this->Context.options.untangle)
    {
      return false;
    }
    // The frame: its origin is the smallest corner, its axes are sorted by their other ends.
    const auto before = [&](int a, int b) { return comesBefore(corners[a], corners[b]); };
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

  bool anyFails() const
  {
    return this->Group.any(std::any_of(
      this->Entries.begin(), this->Entries.end(), [](const auto& entry) { return entry.second.failing(); }));
  }

  struct Progress
  {
    Index failing = std::numeric_limits<Index>::max();
    double penalty = std::numeric_limits<double>::infinity();
  };
  /// On all ranks. Penalties are those before the last sweep.
  Progress progress() const
  {
    std::vector<double> penalties;
    for (const auto& entry : this->Entries)
    {
      if (entry.second.failing())
      {
        penalties.push_back(entry.second.penalty.value);
      }
    }
    penalties = this->Group.gatherAll(penalties);
    const Index failing = static_cast<Index>(penalties.size());
    return { failing, sortedSum(penalties) };
  }

  void sweepAll(SpanReport& report)
  {
    const int most = this->Context.options.untangle ? MaxUntanglingSweeps : MaxSweeps;
    Progress best;
    int idle = 0;
    const int mostIdle = this->Context.options.untangle ? MaxIdleUntanglingSweeps : MaxIdleSweeps;
    while (report.sweeps < most && this->anyFails())
    {
      this->Run.report(0.95);
      ++report.sweeps;
      const bool moved = this->sweep(Watched);
      const bool released = this->release();
      const Progress now = this->progress();
      idle = released || now.failing < best.failing || now.penalty < best.penalty * (1.0 - 0x1p-6) ? 0 : idle + 1;
      best = { std::min(best.failing, now.failing), std::min(best.penalty, now.penalty) };
      if ((!moved && !released && report.sweeps > Patience) || idle == mostIdle)
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
    this->Run.parallelFor(static_cast<Index>(entries.size()), 4, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i)
      {
        SpanControl control;
        for (int p = 0; p < 64; ++p)
        {
          control[p] = this->Context.controlPoint(blocks[i], entries[i]->control[p]);
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
    this->makeFrames(std::move(wanted));

    std::vector<Proposal> proposals;
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
        missing[i]->second = pointMap(this->Context, missing[i]->first);
      }
    });
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
    const std::map<SpanId, Validity> failing = failingSpans(CheckedNets(this->Context), lists, this->Run);
    for (const auto& [block, numbers] : lists)
    {
      for (const Index number : numbers)
      {
        const SpanId id{ block, number };
        const auto found = failing.find(id);
        this->setValidity(id, found != failing.end() ? found->second : Validity::Valid);
      }
    }
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
    std::array<Index, 4> counts{ 0, 0, static_cast<Index>(this->InvalidCells.size()), 0 };
    for (const auto& entry : this->InvalidCells)
    {
      counts[3] += entry.second == Validity::Undecided ? 1 : 0;
    }
    for (const auto& [id, entry] : this->Entries)
    {
      counts[0] += entry.failedFirst ? 1 : 0;
      counts[1] += entry.failedFirst && !entry.failing() ? 1 : 0;
      if (entry.failing())
      {
        left.push_back({ id.first, cellOf(this->Context.complex.blocks[id.first], id.second), entry.validity });
      }
    }
    for (const std::array<Index, 4>& part : this->Group.gatherAll(std::vector<std::array<Index, 4>>{ counts }))
    {
      report.failed += part[0];
      report.repaired += part[1];
      report.invalidCells += part[2];
      report.undecidedCells += part[3];
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
  /// Spans that are not proven valid, nor are their mesh cells.
  std::map<SpanId, Validity> InvalidCells;
  /// The same on all ranks.
  ///@{
  PointOffsets Offsets;
  std::map<MeshPointKey, PointFrame> Frames;
  std::set<MeshPointKey> Released;
  ///@}
  std::map<MeshPointKey, PointMap> Maps;
};

/// Calls action(cells, doubled, net) for the blocks of this rank.
template <typename Action>
void forBlocksHere(const ConversionContext& context, const Execution& run, const Action& action)
{
  run.parallelFor(static_cast<Index>(context.complex.blocks.size()), 1, [&](Index begin, Index end) {
    for (int b = static_cast<int>(begin); b < end; ++b)
    {
      const ComplexBlock& block = context.complex.blocks[b];
      if (context.isHere(b))
      {
        action(Ijk{ block.cells(0), block.cells(1), block.cells(2) }, (*context.doubled)[b], context.nets[b]);
      }
    }
  });
}

} // namespace

SpanReport checkSpans(const ConversionContext& context, const Execution& run)
{
  SpanReport report;
  if (context.options.checkSpans == CheckSpans::None && !context.options.untangle)
  {
    return report;
  }
  const std::map<SpanId, Validity> failing = failingSpans(CheckedNets(context), report.checked, run);
  if (run.ranks->any(!failing.empty()))
  {
    Repair(context, run)(failing, report);
  }
  return report;
}

G1Report joinAndCheck(
  const ConversionContext& context, const std::function<SpanReport()>& convert, SpanReport& spans, const Execution& run)
{
  // Round 0 is that of nets as they are converted; the others begin with repaired ones.
  constexpr int MaxRounds = 7;
  const bool check = context.options.checkSpans != CheckSpans::None || context.options.untangle;
  const CheckedNets nets(context);
  const Ranks& ranks = *run.ranks;
  std::vector<JoinedSpan> avoid;
  Index failedBefore = 0, failedFirst = 0;
  for (int round = 0;; ++round)
  {
    if (round > 0)
    {
      spans = convert();
      forBlocksHere(context, run, makeRoom);
    }
    if (round == 1)
    {
      failedBefore = static_cast<Index>(spans.left.size()) + spans.invalidCells;
    }
    forBlocksHere(context, run, insertDoubleKnots);
    const bool nothing = round == MaxRounds;
    const G1Report report = makeExactG1(context, avoid, nothing, run);
    if (!check)
    {
      return report;
    }
    struct Place
    {
      int block;
      Ijk cell, first;
      Validity validity;
      bool validCell;
    };
    std::vector<Place> left;
    Index checked = 0;
    const std::map<SpanId, Validity> failing = failingSpans(nets, checked, run);
    for (const auto& [id, validity] : failing)
    {
      const ComplexBlock& block = context.complex.blocks[id.first];
      const Ijk cell = nets.cellOf(id);
      const bool validCell = isValidCell(block, givenCorners(block, cell));
      left.push_back({ id.first, cell, nets.firstControlPoint(id), validity, validCell });
    }
    left = ranks.gatherAll(left);
    std::sort(left.begin(), left.end(), [](const Place& a, const Place& b) {
      return std::tie(a.block, a.cell, a.first) < std::tie(b.block, b.cell, b.first);
    });
    failedFirst = round <= 1 ? static_cast<Index>(left.size()) : failedFirst;
    // What no join has made invalid is not for the joins to cure.
    const bool again = !nothing && context.options.repairSpans && static_cast<Index>(left.size()) > failedBefore;
    if (!again)
    {
      spans.checked = checked;
      spans.left.clear();
      spans.invalid = spans.undecided = spans.invalidCells = spans.undecidedCells = 0;
      for (const Place& place : left)
      {
        const bool undecided = place.validity == Validity::Undecided;
        if (place.validCell)
        {
          ++(undecided ? spans.undecided : spans.invalid);
          spans.left.push_back({ place.block, place.cell });
        }
        else
        {
          ++spans.invalidCells;
          spans.undecidedCells += undecided ? 1 : 0;
        }
      }
      const Index cured = std::max<Index>(0, failedFirst - static_cast<Index>(left.size()));
      spans.failed = (round == 0 ? static_cast<Index>(spans.left.size()) : spans.failed) + cured;
      spans.repaired += cured;
      return report;
    }
    for (std::size_t i = 0; round > 0 && i < left.size(); ++i)
    {
      avoid.push_back({ left[i].block, left[i].first });
    }
  }
}

} // namespace bsv
