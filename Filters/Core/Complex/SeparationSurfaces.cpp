// SPDX-License-Identifier: BSD-3-Clause
// Singular edges and the surfaces that start there.
#include "Complex/HexDecomposition.h"

#include <algorithm>

namespace bsv
{

void HexDecomposition::findSingularEdges()
{
  const Index points = this->Mesh.pointCount();
  std::vector<HexId> start(points + 1, 0);
  for (HexId p : this->Mesh.corners)
  {
    ++start[p];
  }
  HexId sum = 0;
  for (HexId& first : start)
  {
    sum += first;
    first = sum;
  }
  // Corners 8 * cell + corner at each point, ascending.
  std::vector<HexId> corners(sum);
  for (Index n = static_cast<Index>(this->Mesh.corners.size()) - 1; n >= 0; --n)
  {
    corners[--start[this->Mesh.corners[n]]] = static_cast<HexId>(n);
  }
  std::atomic<Index> singular{ 0 };
  this->Run.parallelFor(points, 1 << 13, [&](Index begin, Index end) {
    OneRing ring;
    Index found = 0;
    for (Index p = begin; p < end; ++p)
    {
      found += this->lookAround(static_cast<HexId>(p), corners.data() + start[p], start[p + 1] - start[p], ring);
    }
    singular += found;
  });
  this->Result.singularEdges = singular;
}

Index HexDecomposition::lookAround(HexId p, const HexId* corners, HexId count, OneRing& ring)
{
  ring.parent.resize(count);
  for (HexId n = 0; n < count; ++n)
  {
    ring.parent[n] = static_cast<int>(n);
  }
  const auto root = [&](int n) {
    while (ring.parent[n] != n)
    {
      n = ring.parent[n] = ring.parent[ring.parent[n]];
    }
    return n;
  };
  HexId parts = count;
  ring.edges.clear();
  for (HexId n = 0; n < count; ++n)
  {
    const HexId cell = corners[n] / 8;
    const int v = static_cast<int>(corners[n] % 8);
    for (int d = 0; d < 3; ++d)
    {
      const HexId other = this->corner(cell, v ^ (1 << d));
      if (other > p)
      {
        ring.edges.push_back({ other, 16 * std::uint64_t(cell) + this->Frames.cornerEdge(v, d) });
      }
      const HexId face = 6 * cell + 2 * d + cornerSide(v, d);
      const HexId behind = this->next(face);
      if (behind != NoHexId && behind > face)
      {
        const HexId wanted = 8 * (behind / 6) + this->cornerAcross(face, v);
        const int m = static_cast<int>(std::lower_bound(corners, corners + count, wanted) - corners);
        const int a = root(static_cast<int>(n));
        const int b = root(m);
        parts -= a != b;
        ring.parent[a] = b;
      }
    }
  }
  if (parts > 1 && count > 0)
  {
    const int first = root(0);
    HexId other = 1;
    while (root(static_cast<int>(other)) == first)
    {
      ++other;
    }
    throw Error(this->cell(corners[0] / 8) + " and " + this->cell(corners[other] / 8) + " meet at the " +
      this->Mesh.pointName(p) + ", near " + text(this->point(p)) +
      ", but no cells around it connect them: the mesh is not a manifold there");
  }

  std::sort(ring.edges.begin(), ring.edges.end());
  Index singular = 0;
  for (std::size_t begin = 0, end = 0; begin < ring.edges.size(); begin = end)
  {
    int contacts = 0; // each from both sides
    for (end = begin; end < ring.edges.size() && ring.edges[end].first == ring.edges[begin].first; ++end)
    {
      for (int side = 0; side < 2; ++side)
      {
        contacts += this->next(this->faceAt(ring.edges[end].second, side)) != NoHexId;
      }
    }
    const int cells = static_cast<int>(end - begin);
    const bool inside = contacts == 2 * cells;
    if (contacts < 2 * (cells - 1))
    {
      this->refuseEdge(p, ring, begin, end);
    }
    if (inside ? cells == 4 : cells <= 2)
    {
      continue;
    }
    ++singular;
    for (std::size_t n = begin; n < end; ++n)
    {
      for (int side = 0; side < 2; ++side)
      {
        const HexId face = this->faceAt(ring.edges[n].second, side);
        if (this->next(face) != NoHexId)
        {
          this->separate(face);
        }
      }
    }
  }
  return singular;
}

void HexDecomposition::refuseEdge(HexId p, const OneRing& ring, std::size_t begin, std::size_t end) const
{
  std::string cells;
  for (std::size_t n = begin; n < end; ++n)
  {
    cells += (n == begin        ? ""
                 : n + 1 == end ? " and "
                                : ", ") +
      this->cell(static_cast<Index>(ring.edges[n].second / 16));
  }
  throw Error(cells + " meet at the edge between the " + this->Mesh.pointName(p) + " and the " +
    this->Mesh.pointName(ring.edges[begin].first) + ", near " + text(this->point(p)) +
    ", but some share no face there: the mesh is not a manifold there");
}

void HexDecomposition::spread()
{
  while (!this->Front.empty())
  {
    const HexId face = this->Front.back();
    this->Front.pop_back();
    this->forEachContinuation(
      face, [](HexId) { return true; },
      [&](HexId opposite) {
        if (!this->separates(opposite))
        {
          this->separate(opposite);
          this->separate(this->next(opposite));
          this->Front.push_back(opposite);
        }
      });
  }
}

} // namespace bsv
