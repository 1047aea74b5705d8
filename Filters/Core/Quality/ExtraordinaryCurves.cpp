// SPDX-License-Identifier: BSD-3-Clause
#include "Quality/ExtraordinaryCurves.h"

#include "Mesh/BlockTopology.h"
#include "Ranks/Ranks.h"

#include <algorithm>

namespace bsv
{

namespace
{

/// The samples of an interface along one of its sides, in the direction of the shared edge there.
struct SideRow
{
  std::vector<Vec3> points;
  std::vector<double> normalJump; ///< of the layers that the side pierces

  /// From another rank.
  SideRow(const double*& packed, int count)
    : normalJump(packed, packed + count)
  {
    for (packed += count; count > 0; --count, packed += 3)
    {
      this->points.emplace_back(packed);
    }
  }
  void pack(std::vector<double>& to) const
  {
    to.insert(to.end(), this->normalJump.begin(), this->normalJump.end());
    for (const Vec3& point : this->points)
    {
      to.insert(to.end(), point.data(), point.data() + 3);
    }
  }
  SideRow(const Join& join, int axis, int side, bool reversed)
  {
    const int count = join.samples[axis];
    const std::vector<double>& jumps = join.values[int(axis == 0 ? JumpKind::NormalT : JumpKind::NormalS)];
    for (int n = 0; n < count; ++n)
    {
      const int along = reversed ? count - 1 - n : n;
      const int fixed = side ? join.samples[1 - axis] - 1 : 0;
      const std::size_t place =
        axis == 0 ? along + std::size_t(join.samples[0]) * fixed : fixed + std::size_t(join.samples[0]) * along;
      this->points.push_back(join.points[place]);
      this->normalJump.push_back(jumps[place]);
    }
  }

  /// Jump at sample n of `count`: this row's own one if it has as many, else interpolated.
  double at(std::size_t n, std::size_t count) const
  {
    const std::size_t own = this->normalJump.size();
    const std::size_t numerator = n * (own - 1);
    const std::size_t low = numerator / (count - 1);
    const std::size_t rest = numerator % (count - 1);
    if (rest == 0)
    {
      return this->normalJump[low];
    }
    const double f = double(rest) / (count - 1);
    return (1.0 - f) * this->normalJump[low] + f * this->normalJump[low + 1];
  }
};

} // namespace

bool isExtraordinary(const SharedEntities::Edge& edge)
{
  return !edge.boundary && edge.uses != 4;
}

int rankOf(const std::vector<BSplineVolume>& volumes, const Join& join)
{
  return volumes[join.sides[0].block].rank;
}

std::vector<ExtraordinaryCurve> extraordinaryCurves(const std::vector<BSplineVolume>& volumes,
  const SharedEntities& shared, const std::vector<Join>& joins, const Ranks& ranks)
{
  // visit(join, axis, side, edge, reversed) for the sides of interfaces at extraordinary edges, in one order on all
  // ranks. A row goes from the rank of the join to that of the curve.
  const auto overSides = [&](const auto& visit) {
    for (const Join& join : joins)
    {
      for (int n = 0; n < 4 && !join.border(); ++n)
      {
        const int axis = n < 2 ? 1 : 0;
        const int own = faceEdge(join.sides[0].face, axis, n % 2);
        const SharedEntities::Block& block = shared.blocks[join.sides[0].block];
        if (isExtraordinary(shared.edges[block.edges[own]]))
        {
          visit(join, axis, n % 2, block.edges[own], block.edgeReversed[own]);
        }
      }
    }
  };
  const auto rankOfEdge = [&](int edge) { return volumes[shared.edges[edge].block].rank; };
  const int rank = ranks.rank();
  std::vector<std::vector<double>> toRank(ranks.size());
  overSides([&](const Join& join, int axis, int side, int edge, bool reversed) {
    if (rankOf(volumes, join) == rank && rankOfEdge(edge) != rank)
    {
      SideRow(join, axis, side, reversed).pack(toRank[rankOfEdge(edge)]);
    }
  });
  const std::vector<std::vector<double>> received = ranks.exchange(toRank);
  std::vector<const double*> next;
  next.reserve(received.size());
  for (const std::vector<double>& part : received)
  {
    next.push_back(part.data());
  }
  std::vector<std::vector<SideRow>> rows(shared.edges.size());
  overSides([&](const Join& join, int axis, int side, int edge, bool reversed) {
    const int from = rankOf(volumes, join);
    if (rankOfEdge(edge) == rank)
    {
      rows[edge].push_back(
        from == rank ? SideRow(join, axis, side, reversed) : SideRow(next[from], join.samples[axis]));
    }
  });

  std::vector<ExtraordinaryCurve> curves;
  for (int e = 0; e < static_cast<int>(shared.edges.size()); ++e)
  {
    if (!isExtraordinary(shared.edges[e]))
    {
      continue;
    }
    ExtraordinaryCurve curve;
    curve.valence = shared.edges[e].uses;
    curve.block = shared.edges[e].block;
    curve.edge = shared.edges[e].edge;
    const auto longest = std::max_element(rows[e].begin(), rows[e].end(),
      [](const SideRow& a, const SideRow& b) { return a.points.size() < b.points.size(); });
    if (longest != rows[e].end())
    {
      curve.points = longest->points;
    }
    curve.normalJump.assign(curve.points.size(), 0.0);
    for (const SideRow& row : rows[e])
    {
      for (std::size_t n = 0; n < curve.normalJump.size(); ++n)
      {
        curve.normalJump[n] = std::max(curve.normalJump[n], row.at(n, curve.normalJump.size()));
      }
    }
    curves.push_back(std::move(curve));
  }
  return curves;
}

} // namespace bsv
