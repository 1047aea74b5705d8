// SPDX-License-Identifier: BSD-3-Clause
#include "Quality/Smoothness.h"

#include "Mesh/SharedEntities.h"
#include "Quality/ExtraordinaryCurves.h"
#include "Quality/JoinMeasurement.h"
#include "Ranks/Ranks.h"
#include "Volume/ControlPointRule.h"
#include "Volume/VolumeParts.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

namespace bsv
{

namespace
{

/// Blocks around an edge, negative on the outer boundary.
int signedValence(const SharedEntities& shared, int block, int edge)
{
  const SharedEntities::Edge& entity = shared.edges[shared.blocks[block].edges[edge]];
  return entity.uses * (entity.boundary ? -1 : 1);
}

/// Join::valences of a wall border.
void describeBorder(const SharedEntities& shared, Join& join)
{
  const int block = join.sides[0].block, wall = join.sides[0].face, edge = join.sides[0].edge;
  join.valences[0] = signedValence(shared, block, edge);
  const int direction = edgeDirection(edge);
  // The face that goes off the wall there.
  const int faces[2] = { 2 * faceAxis(2 * direction, 0) + edgeSide(edge, 0),
    2 * faceAxis(2 * direction, 1) + edgeSide(edge, 1) };
  const int face = faces[faces[0] == wall ? 1 : 0];
  const int across = faceAxis(face, 0) == direction ? 1 : 0;
  for (int end = 0; end < 2; ++end)
  {
    join.valences[2 + end] = signedValence(shared, block, faceEdge(face, across, end));
  }
}

/// The pairs of outer faces that meet along a block edge.
std::vector<Join> outerBorders(const SharedEntities& shared)
{
  struct Use
  {
    int block, face, edge;
    bool reversed;
  };
  std::vector<std::vector<Use>> uses(shared.edges.size());
  for (int b = 0; b < static_cast<int>(shared.blocks.size()); ++b)
  {
    const SharedEntities::Block& block = shared.blocks[b];
    for (int e = 0; e < 12; ++e)
    {
      for (int axis = 0; axis < 2; ++axis)
      {
        const int face = 2 * faceAxis(2 * edgeDirection(e), axis) + edgeSide(e, axis);
        if (shared.faces[block.faces[face]].uses == 1)
        {
          uses[block.edges[e]].push_back({ b, face, e, block.edgeReversed[e] });
        }
      }
    }
  }
  std::vector<Join> borders;
  for (const std::vector<Use>& pair : uses)
  {
    if (pair.size() == 2)
    {
      Join join;
      for (int k = 0; k < 2; ++k)
      {
        join.sides[k] = { pair[k].block, pair[k].face, pair[k].edge };
      }
      join.orientation = pair[0].reversed != pair[1].reversed ? 2 : 0;
      describeBorder(shared, join);
      borders.push_back(join);
    }
  }
  return borders;
}

/// Whether the control points of the middle third of a border are all made by crease or corner rules: near its ends
/// those of the vertices may hold, as where a crease ends at an extraordinary one.
/// @param rules of the block `whole`, whose part from control point `first` on `volume` is
bool taggedCrease(const Join& join, const BSplineVolume& volume, const BSplineVolume& whole, const Ijk& first,
  const unsigned char* rules)
{
  if (!rules)
  {
    return false;
  }
  const int edge = join.sides[0].edge;
  const int d = edgeDirection(edge);
  const int last = volume.count(d) - 1, begin = std::min((last + 3) / 3, last / 2);
  for (int n = begin; n <= last - begin; ++n)
  {
    Ijk p;
    p[d] = n;
    for (int axis = 0; axis < 2; ++axis)
    {
      const int other = faceAxis(2 * d, axis);
      p[other] = edgeSide(edge, axis) ? volume.count(other) - 1 : 0;
    }
    const auto rule = static_cast<ControlPointRule>(
      rules[first[0] + p[0] + Index(whole.count(0)) * (first[1] + p[1] + Index(whole.count(1)) * (first[2] + p[2]))]);
    if (rule != ControlPointRule::Crease && rule != ControlPointRule::Corner)
    {
      return false;
    }
  }
  return volume.count(d) > 2;
}

bool isSharp(const Join& join, double angle)
{
  std::vector<double> turns = join.values[int(JumpKind::NormalS)];
  const auto middle = turns.begin() + turns.size() / 2;
  std::nth_element(turns.begin(), middle, turns.end());
  return *middle > angle;
}

JoinContinuity continuityOf(const Join& join, double gapTolerance, double tolerance)
{
  const auto worst = [&](JumpKind kind) { return join.worst[int(kind)].value; };
  const double kink = join.border()
    ? worst(JumpKind::NormalS)
    : std::min({ worst(JumpKind::NormalS), worst(JumpKind::NormalT), worst(JumpKind::Layer) });
  return worst(JumpKind::Gap) > gapTolerance ? JoinContinuity::Open
    : kink > tolerance * DegreesPerRadian    ? JoinContinuity::C0
    : worst(JumpKind::C1) > tolerance        ? JoinContinuity::G1
    : worst(JumpKind::C2) > tolerance        ? JoinContinuity::C1
                                             : JoinContinuity::C2;
}

/// What the edges of an interface say about it.
void describeInterface(const SharedEntities& shared, const std::vector<bool>& crease, Join& join)
{
  for (int n = 0; n < 4; ++n)
  {
    // Side n is s = 0, s = end, t = 0, t = end; its edge runs along the other axis.
    const int axis = n < 2 ? 1 : 0;
    const int edge = shared.blocks[join.sides[0].block].edges[faceEdge(join.sides[0].face, axis, n % 2)];
    const SharedEntities::Edge& entity = shared.edges[edge];
    join.valences[n] = signedValence(shared, join.sides[0].block, faceEdge(join.sides[0].face, axis, n % 2));
    join.atCrease = join.atCrease || crease[edge];
    join.boundToKink[axis] = join.boundToKink[axis] || crease[edge] || isExtraordinary(entity);
  }
}

/// Per vertex, whether a crease or a reentrant edge of the outer boundary ends there.
std::vector<bool> kinkedVertices(const SharedEntities& shared, const std::vector<bool>& crease)
{
  std::vector<bool> result(shared.vertices, false);
  for (std::size_t e = 0; e < shared.edges.size(); ++e)
  {
    const SharedEntities::Edge& edge = shared.edges[e];
    for (const int vertex : edge.vertices)
    {
      result[vertex] = result[vertex] || crease[e] || (edge.boundary && edge.uses >= 3);
    }
  }
  return result;
}

/// Join::atKinkedVertex, and on the rank that measures it Join::layerJumpAway.
void describeCorners(const SharedEntities& shared, const std::vector<bool>& kinked, Join& join)
{
  const Join::Side& side = join.sides[0];
  const SharedEntities::Block& block = shared.blocks[side.block];
  const std::vector<double>& jumps = join.spanMaxima[int(JumpKind::Layer)];
  const int ns = join.spans[0], nt = join.spans[1];
  // Samples between spans.
  const auto at = [&](int s, int t) {
    const int perS = (join.samples[0] - 1) / ns, perT = (join.samples[1] - 1) / nt;
    return join.points[perS * s + std::size_t(join.samples[0]) * (perT * t)];
  };
  std::vector<bool> isAway(jumps.size(), true);
  for (int c = 0; c < (join.border() ? 2 : 4); ++c)
  {
    const int s = c & 1, t = c >> 1;
    if (!kinked[block.vertices[join.border() ? edgeCorner(side.edge, s) : faceCorner(side.face, s, t)]])
    {
      continue;
    }
    join.atKinkedVertex = true;
    if (jumps.empty())
    {
      continue;
    }
    // The corner's rule makes the first two control points, which shape two spans; layers may be thinner.
    const auto from = [](int end, int steps, int count) { return end ? count - steps : steps; };
    const Vec3 corner = at(from(s, 0, ns), from(t, 0, nt));
    const double reach = std::max((at(from(s, std::min(2, ns), ns), from(t, 0, nt)) - corner).norm(),
      (at(from(s, 0, ns), from(t, std::min(2, nt), nt)) - corner).norm());
    for (std::size_t n = 0; n < jumps.size(); ++n)
    {
      const int i = static_cast<int>(n) % ns, j = static_cast<int>(n) / ns;
      const Vec3 nearest = at(s ? i + 1 : i, t ? j + 1 : j);
      isAway[n] = isAway[n] && !((nearest - corner).norm() < reach);
    }
  }
  for (std::size_t n = 0; n < jumps.size(); ++n)
  {
    join.layerJumpAway = std::max(join.layerJumpAway, isAway[n] ? jumps[n] : 0.0);
  }
}

void checkOptions(const SmoothnessOptions& options)
{
  const auto check = [](bool good, const char* name, double value) {
    if (!good)
    {
      throw Error("smoothness: " + std::string(name) + " is out of range: " + std::to_string(value));
    }
  };
  check(
    options.samplesPerSpan >= 1 && options.samplesPerSpan <= 16, "samples per span (1..16)", options.samplesPerSpan);
  check(options.creaseAngle >= 0.0 && options.creaseAngle <= 180.0, "crease angle (0..180)", options.creaseAngle);
  check(
    options.gapTolerance >= 0.0 && std::isfinite(options.gapTolerance), "gap tolerance (>= 0)", options.gapTolerance);
  check(options.tolerance >= 0.0 && std::isfinite(options.tolerance), "tolerance (>= 0)", options.tolerance);
}

/// Control points of side A.
double controlPoints(const BSplineVolume& volume, const Join& join)
{
  const Join::Side& side = join.sides[0];
  return join.border() ? double(volume.count(edgeDirection(side.edge)))
                       : double(volume.count(faceAxis(side.face, 0))) * volume.count(faceAxis(side.face, 1));
}

/// The traces of sides B that are on other ranks than sides A, for the joins measured here; the others are empty.
std::vector<Trace> fetchTraces(
  const std::vector<BSplineVolume>& volumes, const std::vector<Join>& joins, const Execution& run)
{
  const Ranks& ranks = *run.ranks;
  std::vector<Trace> traces;
  if (ranks.size() == 1)
  {
    return traces;
  }
  // All ranks know who needs what, in one order.
  std::vector<const Join*> wanted;
  for (const Join& join : joins)
  {
    const int rankB = volumes[join.sides[1].block].rank;
    if (rankB == ranks.rank() && rankOf(volumes, join) != rankB)
    {
      wanted.push_back(&join);
    }
  }
  std::vector<std::vector<double>> packed(wanted.size());
  std::vector<std::vector<double>> toRank(ranks.size());
  run.parallelFor(static_cast<Index>(wanted.size()), 1, [&](Index begin, Index end) {
    for (Index n = begin; n < end; ++n)
    {
      const Join& join = *wanted[n];
      packed[n] = packedTrace(makeTrace(volumes[join.sides[1].block], acrossFace(join, 1), withinFace(join, 1)));
    }
  });
  for (std::size_t n = 0; n < wanted.size(); ++n)
  {
    std::vector<double>& to = toRank[rankOf(volumes, *wanted[n])];
    to.insert(to.end(), packed[n].begin(), packed[n].end());
  }
  const std::vector<std::vector<double>> received = ranks.exchange(toRank);
  std::vector<const double*> next;
  for (const std::vector<double>& part : received)
  {
    next.push_back(part.data());
  }
  traces.resize(joins.size());
  for (std::size_t n = 0; n < joins.size(); ++n)
  {
    const BSplineVolume& volume = volumes[joins[n].sides[1].block];
    if (volume.rank != ranks.rank() && rankOf(volumes, joins[n]) == ranks.rank())
    {
      traces[n] = emptyTrace(volume, acrossFace(joins[n], 1), withinFace(joins[n], 1));
      next[volume.rank] = unpackTrace(next[volume.rank], traces[n]);
    }
  }
  return traces;
}

/// Measures the joins of this rank in batches: their traces need more memory than their results. `done` counts the
/// control points of all its joins, `total` is their number.
void measureJoins(const std::vector<BSplineVolume>& volumes, const SmoothnessOptions& options, std::vector<Join>& joins,
  double& done, double total, const Execution& run)
{
  constexpr double BatchSize = 1e5; // control points
  std::vector<Trace> fetched = fetchTraces(volumes, joins, run);
  std::vector<std::size_t> own;
  for (std::size_t n = 0; n < joins.size(); ++n)
  {
    if (rankOf(volumes, joins[n]) == run.ranks->rank())
    {
      own.push_back(n);
    }
  }
  for (std::size_t first = 0; first < own.size();)
  {
    run.report(done / total);
    std::vector<JoinMeasurement> batch;
    double size = 0.0;
    while (first + batch.size() < own.size() && size < BatchSize)
    {
      const std::size_t n = own[first + batch.size()];
      const auto& sides = joins[n].sides;
      const bool remote = volumes[sides[1].block].rank != volumes[sides[0].block].rank;
      size += controlPoints(volumes[sides[0].block], joins[n]);
      batch.emplace_back(volumes, options, remote ? &fetched[n] : nullptr, joins[n]);
    }
    const Index count = static_cast<Index>(batch.size());
    std::vector<char> finite(batch.size(), 1);
    run.parallelFor(count, 1, [&](Index begin, Index end) {
      for (Index n = begin; n < end; ++n)
      {
        finite[n] = batch[n].prepare() ? 1 : 0;
      }
    });
    std::vector<Index> rows{ 0 };
    for (Index n = 0; n < count; ++n)
    {
      if (!finite[n])
      {
        const auto& sides = joins[own[first + n]].sides;
        throw ErrorAt(static_cast<Index>(own[first + n]),
          "control points at the join of " + options.blockName(sides[0].block) + " face " +
            std::to_string(sides[0].face) + " and " + options.blockName(sides[1].block) + " face " +
            std::to_string(sides[1].face) + " are not finite");
      }
      rows.push_back(rows.back() + batch[n].rows());
    }
    run.parallelFor(rows.back(), 4, [&](Index begin, Index end) {
      Index n = std::upper_bound(rows.begin(), rows.end(), begin) - rows.begin() - 1;
      for (Index row = begin; row < end; ++row)
      {
        n += row == rows[n + 1] ? 1 : 0;
        batch[n].evaluateRow(row - rows[n]);
      }
    });
    run.parallelFor(count, 1, [&](Index begin, Index end) {
      for (Index n = begin; n < end; ++n)
      {
        batch[n].finish();
      }
    });
    first += batch.size();
    done += size;
  }
}

/// Tells all ranks what they need to know of the joins that this one measured.
void shareResults(const std::vector<BSplineVolume>& volumes, std::vector<Join>& joins, const Ranks& ranks)
{
  struct Summary
  {
    std::array<int, 2> spans, samples;
    bool crease;
    std::array<std::array<double, 10>, JumpKinds> worst;
  };
  if (ranks.size() == 1)
  {
    return;
  }
  std::vector<Summary> all(joins.size());
  for (std::size_t n = 0; n < joins.size(); ++n)
  {
    const Join& join = joins[n];
    all[n] = { join.spans, join.samples, join.crease, {} };
    for (int kind = 0; kind < JumpKinds; ++kind)
    {
      double* to = all[n].worst[kind].data();
      *to++ = join.worst[kind].value;
      for (const Vec3& x : { join.worst[kind].point, join.worst[kind].uvw[0], join.worst[kind].uvw[1] })
      {
        to = std::copy_n(x.data(), 3, to);
      }
    }
  }
  ranks.share(all, [&](Index n) { return rankOf(volumes, joins[n]); });
  for (std::size_t n = 0; n < joins.size(); ++n)
  {
    const Summary& summary = all[n];
    Join& join = joins[n];
    join.spans = summary.spans;
    join.samples = summary.samples;
    join.crease = summary.crease;
    for (int kind = 0; kind < JumpKinds; ++kind)
    {
      const double* from = summary.worst[kind].data();
      join.worst[kind].value = from[0];
      join.worst[kind].point = Eigen::Map<const Vec3>(from + 1);
      join.worst[kind].uvw = { Eigen::Map<const Vec3>(from + 4), Eigen::Map<const Vec3>(from + 7) };
    }
  }
}

/// Diagonal of the bounding box of the points of all joins.
double extent(const std::vector<Join>& joins, const Ranks& ranks)
{
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  for (const Join& join : joins)
  {
    for (const Vec3& point : join.points)
    {
      low = low.cwiseMin(point);
      high = high.cwiseMax(point);
    }
  }
  using Box = std::array<double, 6>;
  for (const Box& box : ranks.gatherAll<Box>({ { low[0], low[1], low[2], high[0], high[1], high[2] } }))
  {
    low = low.cwiseMin(Eigen::Map<const Vec3>(box.data()));
    high = high.cwiseMax(Eigen::Map<const Vec3>(box.data() + 3));
  }
  return joins.empty() ? 0.0 : (high - low).norm();
}

} // namespace

const char* continuityName(JoinContinuity continuity)
{
  static constexpr const char* Names[] = { "open", "C0", "G1", "C1", "C2" };
  return Names[static_cast<int>(continuity)];
}

JumpKind Join::rankedBy() const
{
  switch (this->continuity)
  {
    case JoinContinuity::Open:
      return JumpKind::Gap;
    case JoinContinuity::C0:
      return JumpKind::Layer;
    case JoinContinuity::G1:
      return JumpKind::C1;
    default:
      return JumpKind::C2;
  }
}

SmoothnessResult measureSmoothness(const std::vector<BSplineVolume>& whole,
  const std::vector<Interface>& wholeInterfaces, const SmoothnessOptions& given, const Execution& run)
{
  checkOptions(given);
  const VolumeParts parts = cutAtRepeatedKnots(whole, wholeInterfaces);
  const std::vector<BSplineVolume>& volumes = parts.volumes;
  const std::vector<Interface>& interfaces = parts.interfaces;
  SmoothnessOptions options = given;
  options.isWall = [&](int part, int face) { return given.isWall(parts.blocks[part], face); };
  options.blockName = [&](int part) { return given.blockName(parts.blocks[part]); };
  const SharedEntities shared = sharedEntities(static_cast<int>(volumes.size()), interfaces, options.blockName);
  SmoothnessResult result;
  for (const Interface& contact : interfaces)
  {
    Join join;
    join.sides[0] = { contact.blockA, contact.faceA, -1 };
    join.sides[1] = { contact.blockB, contact.faceB, -1 };
    join.orientation = contact.orientation;
    result.joins.push_back(join);
  }
  std::vector<Join> borders = outerBorders(shared);
  double total = 0.0;
  for (const std::vector<Join>* joins : { &result.joins, &borders })
  {
    for (const Join& join : *joins)
    {
      total += rankOf(volumes, join) == run.ranks->rank() ? controlPoints(volumes[join.sides[0].block], join) : 0.0;
    }
  }

  // The borders first, also those that are not on the wall: creases tell which layers of the interfaces are bound to
  // kink.
  double done = 0.0;
  measureJoins(volumes, options, borders, done, total, run);
  for (Join& join : borders)
  {
    const int block = join.sides[0].block;
    if (volumes[block].rank == run.ranks->rank())
    {
      const int owner = parts.blocks[block];
      join.crease = taggedCrease(join, volumes[block], whole[owner], parts.first[block],
                      options.rules.empty() ? nullptr : options.rules[owner]) ||
        isSharp(join, options.creaseAngle);
    }
  }
  shareResults(volumes, borders, *run.ranks);
  std::vector<bool> crease(shared.edges.size(), false);
  for (const Join& join : borders)
  {
    crease[shared.blocks[join.sides[0].block].edges[join.sides[0].edge]] = join.crease;
  }
  for (Join& join : result.joins)
  {
    describeInterface(shared, crease, join);
  }
  measureJoins(volumes, options, result.joins, done, total, run);
  shareResults(volumes, result.joins, *run.ranks);
  std::copy_if(borders.begin(), borders.end(), std::back_inserter(result.joins), [&](const Join& join) {
    return std::all_of(join.sides.begin(), join.sides.end(),
      [&](const Join::Side& side) { return options.isWall(side.block, side.face); });
  });

  const std::vector<bool> kinked = kinkedVertices(shared, crease);
  std::vector<double> away;
  for (Join& join : result.joins)
  {
    describeCorners(shared, kinked, join);
    away.push_back(join.layerJumpAway);
  }
  run.ranks->share(away, [&](Index n) { return rankOf(volumes, result.joins[n]); });
  for (std::size_t n = 0; n < away.size(); ++n)
  {
    result.joins[n].layerJumpAway = away[n];
  }

  const double gapTolerance = options.gapTolerance * extent(result.joins, *run.ranks);
  for (Join& join : result.joins)
  {
    join.continuity = continuityOf(join, gapTolerance, options.tolerance);
  }
  result.curves = extraordinaryCurves(volumes, shared, result.joins, *run.ranks);

  // From here on blocks are those that were given.
  for (Join& join : result.joins)
  {
    for (Join::Side& side : join.sides)
    {
      side.part = parts.numbers[side.block];
      side.block = parts.blocks[side.block];
    }
  }
  for (ExtraordinaryCurve& curve : result.curves)
  {
    curve.block = parts.blocks[curve.block];
  }

  result.ranking.resize(result.joins.size());
  std::iota(result.ranking.begin(), result.ranking.end(), 0);
  std::stable_sort(result.ranking.begin(), result.ranking.end(), [&](int a, int b) {
    const Join& x = result.joins[a];
    const Join& y = result.joins[b];
    const auto severity = [](const Join& join) { return join.worst[int(join.rankedBy())].value; };
    return x.crease != y.crease      ? y.crease
      : x.continuity != y.continuity ? x.continuity < y.continuity
                                     : severity(x) > severity(y);
  });
  result.blocks.resize(whole.size());
  for (const int j : result.ranking)
  {
    const Join& join = result.joins[j];
    if (join.crease)
    {
      continue;
    }
    for (const Join::Side& side : join.sides)
    {
      BlockSmoothness& block = result.blocks[side.block];
      if (block.worstJoin < 0)
      {
        block.worstJoin = j;
        block.continuity = join.continuity;
      }
      for (int kind = 0; kind < JumpKinds; ++kind)
      {
        block.worst[kind] = std::max(block.worst[kind], join.worst[kind].value);
        result.worst[kind] = std::max(result.worst[kind], join.worst[kind].value);
      }
    }
  }
  return result;
}

} // namespace bsv
