// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/NearPairs.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bsv
{
namespace
{

/// Fraction of the shortest mesh edge within which two points are in one place.
constexpr double SamePlace = 0.05;

/// The same as FacingCosine for quadrilaterals with a common edge: of a notch that is wider, the ends are not near.
constexpr double NotchCosine = 0.5 * NearLimit * NearLimit - 1.0;

/// The coordinates of `d` in a frame, largest absolute value; infinite if the frame is flat.
class Frame
{
public:
  explicit Frame(const std::array<Vec3, 3>& edges)
    : Edges(edges)
  {
    this->Normal = edges[0].cross(edges[1]);
    this->Determinant = edges[2].dot(this->Normal);
    this->Flat = !(std::abs(this->Determinant) > 1e-9 * edges[0].norm() * edges[1].norm() * edges[2].norm());
  }
  /// The same bits for any order and sense of the first two edges, but for the order and the signs.
  Vec3 coordinates(const Vec3& d) const
  {
    if (this->Flat)
    {
      return Vec3::Constant(std::numeric_limits<double>::infinity());
    }
    return Vec3(d.dot(this->Edges[1].cross(this->Edges[2])), d.dot(this->Edges[2].cross(this->Edges[0])),
             d.dot(this->Normal)) /
      this->Determinant;
  }
  double longest() const { return std::max({ this->Edges[0].norm(), this->Edges[1].norm(), this->Edges[2].norm() }); }

private:
  std::array<Vec3, 3> Edges;
  Vec3 Normal;
  double Determinant;
  bool Flat;
};

double largest(const Vec3& x)
{
  return x.cwiseAbs().maxCoeff();
}

double shortestEdge(const OuterCell& cell)
{
  double shortest = std::numeric_limits<double>::max();
  for (int c = 0; c < 4; ++c)
  {
    for (const Vec3& other : { cell.corner(c ^ 1), cell.corner(c ^ 2), cell.behind(c) })
    {
      shortest = std::min(shortest, (other - cell.corner(c)).norm());
    }
  }
  return shortest;
}

/// Whether two quadrilaterals with a common edge are the sides of cells that taper to it: they face each other through
/// the mesh, and what lies behind them at the edge lies between them. @param shared corners of b for those of a, or -1
bool taper(const OuterCell& a, const OuterCell& b, const std::array<int, 4>& shared)
{
  const Vec3 normalA = a.area().stableNormalized(), normalB = b.area().stableNormalized();
  const Vec3 gap = b.center() - a.center();
  bool between = gap.dot(normalA) < 0.0 && gap.dot(normalB) > 0.0;
  // Of sides that overlap, each has its cells on the side of the other.
  constexpr double Beyond = 0.5;
  for (int c = 0; c < 4 && between; ++c)
  {
    if (shared[c] >= 0)
    {
      const Vec3 inA = a.behind(c) - a.corner(c), inB = b.behind(shared[c]) - b.corner(shared[c]);
      between = inA.dot(normalB) < Beyond * inA.norm() && inB.dot(normalA) < Beyond * inB.norm();
    }
  }
  return between;
}

class PairSearch
{
public:
  PairSearch(const OuterSurface& surface, const OuterTiles& tiles, const Execution& run)
    : Surface(surface)
    , Tiles(tiles)
    , Run(run)
    , Others(*run.ranks)
  {
  }

  std::vector<NearPair> operator()() const
  {
    const Index count = this->Tiles.size();
    std::vector<Box> boxes;
    boxes.reserve(count);
    for (Index n = 0; n < count; ++n)
    {
      boxes.push_back(this->Tiles.shape(n).box());
    }
    const BoxTree tree(boxes);
    std::vector<std::vector<Index>> partners(count);
    this->Run.parallelFor(count, 64, [&](Index begin, Index end) {
      for (Index n = begin; n < end; ++n)
      {
        if (!this->isHere(this->Tiles.tile(n).face) || !this->Surface.unnamed(this->Tiles.tile(n).face))
        {
          continue;
        }
        tree.search(boxes[n], [&](Index m) {
          if (this->Surface.unnamed(this->Tiles.tile(m).face) && boxes[n].intersects(boxes[m]) &&
            this->canFace(this->Tiles.shape(n), this->Tiles.shape(m)))
          {
            partners[n].push_back(m);
          }
        });
      }
    });
    // The quadrilaterals of all tiles that may be near one here.
    std::vector<char> wanted(count, false);
    for (Index n = 0; n < count; ++n)
    {
      for (const Index m : partners[n])
      {
        wanted[n] = wanted[m] = true;
      }
    }
    std::vector<Index> quads;
    for (Index n = 0; n < count; ++n)
    {
      const Tile& tile = this->Tiles.tile(n);
      for (int t = tile.t0; t < tile.t1 && wanted[n]; ++t)
      {
        for (int s = tile.s0; s < tile.s1; ++s)
        {
          quads.push_back(this->Surface.quad({ tile.face, s, t }));
        }
      }
    }
    std::sort(quads.begin(), quads.end());
    const std::vector<OuterCell> cells = ofQuads<OuterCell>(
      this->Surface, this->Others, quads, [this](const OuterQuad& at) { return this->Surface.cell(at); });

    const Index quadCount = static_cast<Index>(quads.size());
    std::vector<Box> reaches(quadCount);
    this->Run.parallelFor(quadCount, 256, [&](Index begin, Index end) {
      for (Index n = begin; n < end; ++n)
      {
        reaches[n] = reach(cells[n]);
      }
    });
    const BoxTree near(reaches);
    std::vector<std::vector<NearPair>> chunks((quadCount + Chunk - 1) / Chunk);
    this->Run.parallelFor(static_cast<Index>(chunks.size()), 1, [&](Index begin, Index end) {
      for (Index chunk = begin; chunk < end; ++chunk)
      {
        for (Index n = chunk * Chunk; n < std::min(quadCount, (chunk + 1) * Chunk); ++n)
        {
          const OuterQuad a = this->Surface.quadAt(quads[n]);
          if (!this->isHere(a.face))
          {
            continue;
          }
          // The owner of the lower number of each pair judges it.
          near.search(reaches[n], [&](Index m) {
            NearPair pair;
            if (m > n && reaches[n].intersects(reaches[m]) &&
              this->isNear(a, cells[n], this->Surface.quadAt(quads[m]), cells[m], pair))
            {
              pair.a = quads[n];
              pair.b = quads[m];
              chunks[chunk].push_back(pair);
            }
          });
        }
      }
    });
    std::vector<NearPair> mine;
    for (const std::vector<NearPair>& chunk : chunks)
    {
      mine.insert(mine.end(), chunk.begin(), chunk.end());
    }
    std::vector<NearPair> pairs = this->Others.size() == 1 ? mine : this->Others.gatherAll(mine);
    std::sort(pairs.begin(), pairs.end());
    return pairs;
  }

private:
  bool isHere(int face) const { return this->Surface.rankOf(face) == this->Others.rank(); }

  /// Whether quadrilaterals of two tiles can face each other.
  bool canFace(const TileShape& a, const TileShape& b) const
  {
    // A little more than the angle between them needs.
    const double angle = std::acos(std::min(1.0, std::max(-1.0, vec3(a.axis).dot(vec3(b.axis)))));
    return angle + a.spread + b.spread > 1.9;
  }
  /// Judges two quadrilaterals and fills in the pair.
  bool isNear(
    const OuterQuad& quadA, const OuterCell& a, const OuterQuad& quadB, const OuterCell& b, NearPair& pair) const
  {
    const Vec3 areaA = a.area(), areaB = b.area();
    const double sizes = areaA.norm() * areaB.norm();
    // Collapsed quadrilaterals, where allowed, are boundaries.
    if (!(sizes > 0.0) || collapsed(a) || collapsed(b))
    {
      return false;
    }
    const Frame frameA(a.frame()), frameB(b.frame());
    const std::array<Index, 4> nodesA = this->Surface.nodes(quadA), nodesB = this->Surface.nodes(quadB);

    // Points in one place count as one, although at a corner there may be no other face that makes them one.
    const double tolerance = SamePlace * std::min(shortestEdge(a), shortestEdge(b));
    const auto same = [&](int onA, int onB) {
      return nodesA[onA] == nodesB[onB] || (a.corner(onA) - b.corner(onB)).norm() <= tolerance;
    };

    // The corners of b that face those of a: of the four ways the one that shares most points, then the nearest.
    static const int ring[4] = { 0, 1, 3, 2 };
    int best = -1;
    int shared = 0;
    double distance = 0.0;
    std::array<int, 4> corners{};
    for (int start = 0; start < 4; ++start)
    {
      std::array<int, 4> to{};
      int alike = 0;
      double widest = 0.0;
      for (int c = 0; c < 4; ++c)
      {
        to[ring[c]] = ring[(a.sign == b.sign ? start + 4 - c : start + c) % 4];
        const int onB = to[ring[c]];
        alike += same(ring[c], onB) ? 1 : 0;
        widest = std::max(widest, (a.corner(ring[c]) - b.corner(onB)).norm());
      }
      if (best < 0 || alike > shared || (alike == shared && widest < distance))
      {
        best = start;
        shared = alike;
        distance = widest;
        corners = to;
      }
    }
    std::array<int, 4> common{};
    for (int c = 0; c < 4; ++c)
    {
      common[c] = same(c, corners[c]) ? corners[c] : -1;
    }
    if (shared == 2 && taper(a, b, common))
    {
      return false;
    }
    double inA = 0.0, inB = 0.0;
    for (int c = 0; c < 4; ++c)
    {
      if (nodesA[c] != nodesB[corners[c]])
      {
        const Vec3 gap = b.corner(corners[c]) - a.corner(c);
        inA = std::max(inA, largest(frameA.coordinates(gap)));
        inB = std::max(inB, largest(frameB.coordinates(gap)));
        pair.distances[c] = gap.norm();
      }
    }
    pair.matched = std::min(inA, inB) <= NearLimit;
    pair.corners = corners;
    pair.place = triple(0.5 * (a.center() + b.center()));
    if (pair.matched)
    {
      pair.near = true;
      pair.fraction = std::min(inA, inB);
      pair.distance = distance;
    }
    else if (areaA.dot(areaB) < (shared == 2 ? NotchCosine : FacingCosine) * sizes)
    {
      const auto depth = [](const Frame& frame, const Vec3& d) {
        const Vec3 x = frame.coordinates(d);
        return std::max(std::abs(x[0]), std::abs(x[1])) <= 0.5 + 1e-6 ? std::abs(x[2])
                                                                      : std::numeric_limits<double>::infinity();
      };
      const Vec3 gap = b.center() - a.center();
      const double fraction = std::min(depth(frameB, gap), depth(frameA, gap));
      if (fraction <= NearLimit)
      {
        pair.near = true;
        pair.fraction = fraction;
        pair.distance = gap.norm();
      }
    }
    if (shared == 3 && distance <= NearLimit * std::max(frameA.longest(), frameB.longest()))
    {
      for (int c = 0; c < 4; ++c)
      {
        if (!same(c, corners[c]))
        {
          pair.u = std::min(nodesA[c], nodesB[corners[c]]);
          pair.v = std::max(nodesA[c], nodesB[corners[c]]);
        }
      }
      pair.fraction = pair.matched ? pair.fraction : distance / std::max(frameA.longest(), frameB.longest());
      pair.matched = true;
      pair.distance = distance;
    }
    return pair.near || pair.u >= 0;
  }

  static constexpr Index Chunk = 256;

  const OuterSurface& Surface;
  const OuterTiles& Tiles;
  const Execution& Run;
  const Ranks& Others;
};

} // namespace

std::vector<NearPair> findNearPairs(const OuterSurface& surface, const OuterTiles& tiles, const Execution& run)
{
  return PairSearch(surface, tiles, run)();
}

} // namespace bsv
