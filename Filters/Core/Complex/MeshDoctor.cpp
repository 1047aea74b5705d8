// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/MeshDoctor.h"

#include "Base/BoxTree.h"
#include "Base/CanonicalOrder.h"
#include "Base/Numbers.h"
#include "Base/UnionFind.h"
#include "Complex/OuterSurface.h"
#include "Mesh/BlockSurface.h"
#include "Ranks/OwnedValues.h"
#include "Ranks/Ranks.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <memory>
#include <tuple>
#include <utility>

namespace bsv
{

namespace
{

/// How near is a near miss, as a fraction of the cells: more than half a cell, or half cells would slip through.
constexpr double NearLimit = 0.6;
/// Cosine of the angle between normals from which two quadrilaterals face each other: 120 degrees.
constexpr double FacingCosine = -0.5;
/// Cosine of the turn up to which a surface is smooth: 40 degrees.
const double SmoothCosine = std::cos(40.0 / DegreesPerRadian);
/// A near part is one of walls if the surface goes on from at least this fraction of its border.
constexpr int BorderShare = 8;
/// Quadrilaterals across which an edge between two sides of a thin wall is looked for.
constexpr int WidestRim = 8;
/// Fraction of the shortest mesh edge within which two points are in one place.
constexpr double SamePlace = 0.05;
/// Quadrilaterals per direction of a tile.
constexpr int TileSize = 8;

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

/// Whether two neighbouring corners are one point.
bool collapsed(const OuterCell& cell)
{
  return cell.outer[0] == cell.outer[1] || cell.outer[0] == cell.outer[2] || cell.outer[3] == cell.outer[1] ||
    cell.outer[3] == cell.outer[2];
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

/// The corners and the points up to the near limit on both sides.
Box reach(const OuterCell& cell)
{
  Box box;
  for (int c = 0; c < 4; ++c)
  {
    const Vec3 depth = NearLimit * (cell.behind(c) - cell.corner(c));
    box.extend(Vec3(cell.corner(c) + depth));
    box.extend(Vec3(cell.corner(c) - depth));
  }
  return box;
}

/// A rectangle of quadrilaterals of a face, [s0, s1) x [t0, t1).
struct Tile
{
  int face;
  int s0, t0, s1, t1;
};

/// What all ranks know of a tile.
struct TileShape
{
  Triple lo{ 0, 0, 0 }, hi{ 0, 0, 0 };
  /// Cone of the normals.
  Triple axis{ 0, 0, 0 };
  double spread = 0.0;
  /// Lexicographically first center.
  Triple first{ 0, 0, 0 };
  /// Sums of area . center, and of area.
  double flux = 0.0;
  Triple area{ 0, 0, 0 };

  Box box() const { return Box(vec3(this->lo), vec3(this->hi)); }
};

/// Two quadrilaterals that nearly face each other.
struct NearPair
{
  Index a = -1, b = -1;
  double fraction = 0.0;
  double distance = 0.0;
  Triple place{ 0, 0, 0 };
  /// Corner of b for each corner of a, if they can be matched.
  std::array<int, 4> corners{ -1, -1, -1, -1 };
  std::array<double, 4> distances{ 0, 0, 0, 0 };
  bool matched = false;
  /// Whether it is near by the geometry, and not for sharing three points only.
  bool near = false;
  /// The one pair of corners that is not shared, if three are.
  Index u = -1, v = -1;

  bool operator<(const NearPair& other) const { return std::tie(this->a, this->b) < std::tie(other.a, other.b); }
};

struct Ray
{
  Triple from{ 0, 0, 0 };
  Triple along{ 0, 0, 0 };
  Index quad = -1;
};

/// Shape of a quadrilateral that was asked for.
struct QuadShape
{
  Triple normal{ 0, 0, 0 };
  Triple center{ 0, 0, 0 };
  /// Shortest mesh edge at each corner.
  std::array<double, 4> shortest{ 0, 0, 0, 0 };
};

/// +1 if the ray leaves through the triangle, whose corners run counter-clockwise seen from outside, -1 if it enters.
int crossing(const Vec3& from, const Vec3& along, const Vec3& a, const Vec3& b, const Vec3& c)
{
  const Vec3 ab = b - a, ac = c - a;
  const Vec3 p = along.cross(ac);
  const double determinant = ab.dot(p);
  if (determinant == 0.0)
  {
    return 0;
  }
  const Vec3 t = from - a;
  const double u = t.dot(p) / determinant;
  const Vec3 q = t.cross(ab);
  const double v = along.dot(q) / determinant;
  if (!(u >= 0.0 && v >= 0.0 && u + v <= 1.0 && ac.dot(q) / determinant > 0.0))
  {
    return 0;
  }
  return determinant < 0.0 ? 1 : -1;
}

bool meetsRay(const Box& box, const Vec3& from, const Vec3& inverse)
{
  double first = 0.0, last = std::numeric_limits<double>::infinity();
  for (int d = 0; d < 3; ++d)
  {
    const double a = (box.min()[d] - from[d]) * inverse[d], b = (box.max()[d] - from[d]) * inverse[d];
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
  return first <= last;
}

/// Directions that no mesh is likely to have.
Vec3 rayDirection(const Vec3& normal, int attempt)
{
  static const Vec3 tilts[3] = { Vec3(0.31830988, -0.20787957, 0.27182818), Vec3(-0.26179938, 0.34657359, 0.11503837),
    Vec3(0.14142135, 0.23570226, -0.36787944) };
  return normal + tilts[attempt];
}

class Doctor
{
public:
  Doctor(const BlockComplex& complex, const Execution& run)
    : Complex(complex)
    , Run(run)
    , Others(*run.ranks)
    , Surface(complex)
  {
  }

  MeshDiagnosis operator()()
  {
    this->Result.findingOfQuad.resize(this->Complex.faces.size());
    this->makeTiles();
    this->Run.report(0.4);
    this->findPairs();
    this->Run.report(0.6);
    this->judgePairs();
    this->Run.report(0.7);
    this->findOverlaps();
    this->Run.report(0.9);
    this->findInnerBoundaries();
    this->findComponents();
    this->sortFindings();
    this->Run.report(1.0);
    return std::move(this->Result);
  }

private:
  bool isHere(int face) const { return this->Surface.rankOf(face) == this->Others.rank(); }

  /// @name Tiles
  ///@{
  void makeTiles()
  {
    for (const int face : this->Surface.faces())
    {
      this->FirstTile.push_back(static_cast<Index>(this->Tiles.size()));
      const int ns = this->Surface.cells(face, 0), nt = this->Surface.cells(face, 1);
      for (int t = 0; t < nt; t += TileSize)
      {
        for (int s = 0; s < ns; s += TileSize)
        {
          this->Tiles.push_back({ face, s, t, std::min(s + TileSize, ns), std::min(t + TileSize, nt) });
        }
      }
    }
    this->FirstTile.push_back(static_cast<Index>(this->Tiles.size()));
    const Index count = static_cast<Index>(this->Tiles.size());
    this->Shapes.resize(count);
    this->Run.parallelFor(count, 64, [&](Index begin, Index end) {
      for (Index n = begin; n < end; ++n)
      {
        if (this->isHere(this->Tiles[n].face))
        {
          this->Shapes[n] = this->shapeOf(this->Tiles[n]);
        }
      }
    });
    this->Others.share(this->Shapes, [this](Index n) { return this->Surface.rankOf(this->Tiles[n].face); });
  }

  TileShape shapeOf(const Tile& tile) const
  {
    TileShape shape;
    Box box;
    Vec3 sum = Vec3::Zero(), area = Vec3::Zero();
    Vec3 first = Vec3::Constant(std::numeric_limits<double>::infinity());
    std::array<Vec3, TileSize * TileSize> normals;
    int count = 0;
    bool turned = false;
    this->Surface.forCells({ tile.face, tile.s0, tile.t0 }, { tile.face, tile.s1 - 1, tile.t1 - 1 },
      [&](const OuterQuad&, const OuterCell& cell) {
        box.extend(reach(cell));
        const Vec3 a = cell.area();
        const Vec3 center = cell.center();
        shape.flux += a.dot(center);
        area += a;
        normals[count] = a.stableNormalized();
        sum += normals[count];
        // Seen from a cell that a moved point turned over, its surface may look anywhere.
        turned = turned || !(a.dot(cell.frame()[2]) < 0.0);
        ++count;
        first = comesBefore(center, first) ? center : first;
      });
    const Vec3 axis = sum.stableNormalized();
    double least = 1.0;
    for (int n = 0; n < count; ++n)
    {
      least = std::min(least, normals[n].dot(axis));
    }
    shape.lo = triple(box.min());
    shape.hi = triple(box.max());
    shape.axis = triple(axis);
    shape.spread = turned ? Pi : std::acos(std::max(-1.0, least));
    shape.first = triple(first);
    shape.area = triple(area);
    return shape;
  }

  /// Whether quadrilaterals of two tiles can face each other.
  bool canFace(const TileShape& a, const TileShape& b) const
  {
    // A little more than the angle between them needs.
    const double angle = std::acos(std::min(1.0, std::max(-1.0, vec3(a.axis).dot(vec3(b.axis)))));
    return angle + a.spread + b.spread > 1.9;
  }
  ///@}

  /// @name Pairs that are near
  ///@{
  void findPairs()
  {
    const Index count = static_cast<Index>(this->Tiles.size());
    std::vector<Box> boxes;
    boxes.reserve(count);
    for (const TileShape& shape : this->Shapes)
    {
      boxes.push_back(shape.box());
    }
    const BoxTree tree(boxes);
    std::vector<std::vector<Index>> partners(count);
    this->Run.parallelFor(count, 64, [&](Index begin, Index end) {
      for (Index n = begin; n < end; ++n)
      {
        if (!this->isHere(this->Tiles[n].face) || !this->Surface.unnamed(this->Tiles[n].face))
        {
          continue;
        }
        tree.search(boxes[n], [&](Index m) {
          if (this->Surface.unnamed(this->Tiles[m].face) && boxes[n].intersects(boxes[m]) &&
            this->canFace(this->Shapes[n], this->Shapes[m]))
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
      const Tile& tile = this->Tiles[n];
      for (int t = tile.t0; t < tile.t1 && wanted[n]; ++t)
      {
        for (int s = tile.s0; s < tile.s1; ++s)
        {
          quads.push_back(this->Surface.quad({ tile.face, s, t }));
        }
      }
    }
    std::sort(quads.begin(), quads.end());
    const std::vector<OuterCell> cells =
      this->ask<OuterCell>(quads, [this](const OuterQuad& at) { return this->Surface.cell(at); });

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
    this->Pairs = this->Others.size() == 1 ? mine : this->Others.gatherAll(mine);
    std::sort(this->Pairs.begin(), this->Pairs.end());
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
    else if (areaA.dot(areaB) < FacingCosine * sizes)
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
  ///@}

  /// @name What the pairs mean
  ///@{
  Index slot(Index quad) const
  {
    const auto at = std::lower_bound(this->Near.begin(), this->Near.end(), quad);
    return at != this->Near.end() && *at == quad ? Index(at - this->Near.begin()) : Index(-1);
  }

  const QuadShape& shape(Index quad) const
  {
    return this
      ->Known[std::lower_bound(this->KnownQuads.begin(), this->KnownQuads.end(), quad) - this->KnownQuads.begin()];
  }

  template <typename Visit>
  void forEdges(const OuterQuad& at, const Visit& visit) const
  {
    for (int e = 0; e < 4; ++e)
    {
      visit(OuterEdge{ at, e / 2, e % 2 });
    }
  }

  /// The edge on the other side of the quadrilateral.
  static OuterEdge opposite(OuterEdge edge)
  {
    edge.side = 1 - edge.side;
    return edge;
  }

  void judgePairs()
  {
    if (this->Pairs.empty())
    {
      return;
    }
    for (const NearPair& pair : this->Pairs)
    {
      this->Near.push_back(pair.a);
      this->Near.push_back(pair.b);
    }
    std::sort(this->Near.begin(), this->Near.end());
    this->Near.erase(std::unique(this->Near.begin(), this->Near.end()), this->Near.end());
    this->KnownQuads = this->Near;
    for (const Index quad : this->Near)
    {
      this->forEdges(this->Surface.quadAt(quad), [&](const OuterEdge& edge) {
        this->KnownQuads.push_back(this->Surface.quad(this->Surface.across(edge).quad));
      });
    }
    std::sort(this->KnownQuads.begin(), this->KnownQuads.end());
    this->KnownQuads.erase(std::unique(this->KnownQuads.begin(), this->KnownQuads.end()), this->KnownQuads.end());
    this->Known = this->ask<QuadShape>(
      this->KnownQuads, [this](const OuterQuad& at) { return this->shapeOf(this->Surface.cell(at)); });

    const Walls walls = this->findWalls();
    std::vector<char> loose(this->Pairs.size(), false);
    this->findLoose(loose);
    this->groupPairs(walls, loose);
  }

  static QuadShape shapeOf(const OuterCell& cell)
  {
    QuadShape result;
    result.normal = triple(cell.area().stableNormalized());
    result.center = triple(cell.center());
    for (int c = 0; c < 4; ++c)
    {
      result.shortest[c] = std::numeric_limits<double>::max();
      for (const Vec3& other : { cell.corner(c ^ 1), cell.corner(c ^ 2), cell.behind(c) })
      {
        const double length = (other - cell.corner(c)).norm();
        result.shortest[c] = length > 0.0 ? std::min(result.shortest[c], length) : result.shortest[c];
      }
    }
    return result;
  }

  double cosine(Index a, Index b) const { return vec3(this->shape(a).normal).dot(vec3(this->shape(b).normal)); }

  /// The smooth parts of the surface that near quadrilaterals form, and whether each is seen to be one of a wall.
  struct Walls
  {
    std::vector<Index> part;
    std::vector<char> isWall;

    /// Walls on both sides, or one that goes smoothly around, as around a nose.
    bool between(Index a, Index b) const
    {
      return this->part[a] == this->part[b] || (this->isWall[this->part[a]] && this->isWall[this->part[b]]);
    }
  };

  Walls findWalls() const
  {
    const Index count = static_cast<Index>(this->Near.size());
    UnionFind parts(count);
    std::vector<int> border(count, 0), open(count, 0);
    for (Index n = 0; n < count; ++n)
    {
      this->forEdges(this->Surface.quadAt(this->Near[n]), [&](const OuterEdge& edge) {
        const OuterEdge there = this->Surface.across(edge);
        const Index other = this->Surface.quad(there.quad);
        const Index m = this->slot(other);
        const bool smooth = this->cosine(this->Near[n], other) > SmoothCosine;
        if (m >= 0 && smooth)
        {
          parts.unite(n, m);
          return;
        }
        ++border[n];
        if (m < 0 && ((smooth && this->Surface.unnamed(there.quad.face)) || this->bendsAround(n, there)))
        {
          ++open[n];
        }
      });
    }
    std::vector<int> borders(count, 0), opens(count, 0);
    for (Index n = 0; n < count; ++n)
    {
      borders[parts.find(n)] += border[n];
      opens[parts.find(n)] += open[n];
    }
    Walls walls{ std::vector<Index>(count), std::vector<char>(count, false) };
    for (Index n = 0; n < count; ++n)
    {
      walls.part[n] = parts.find(n);
      walls.isWall[n] = opens[n] > 0 && BorderShare * opens[n] >= borders[n];
    }
    return walls;
  }

  /// Whether the surface beyond a near quadrilateral leads around a thin edge to one that faces it across a hole.
  bool bendsAround(Index n, OuterEdge edge) const
  {
    for (int step = 0; step < WidestRim; ++step)
    {
      edge = this->Surface.across(opposite(edge));
      const Index m = this->slot(this->Surface.quad(edge.quad));
      if (m >= 0)
      {
        const QuadShape& from = this->shape(this->Near[n]);
        const QuadShape& to = this->shape(this->Near[m]);
        return vec3(from.normal).dot(vec3(to.normal)) < FacingCosine &&
          vec3(from.normal).dot(vec3(to.center) - vec3(from.center)) > 0.0;
      }
    }
    return false;
  }

  /// Pairs that share three points and would close the surface if the fourth were one, too. Where walls meet at a sharp
  /// edge of a body, the surface only goes on smoothly from there.
  void findLoose(std::vector<char>& loose) const
  {
    std::map<std::pair<Index, Index>, std::vector<std::size_t>> points;
    for (std::size_t p = 0; p < this->Pairs.size(); ++p)
    {
      if (this->Pairs[p].u >= 0)
      {
        points[{ this->Pairs[p].u, this->Pairs[p].v }].push_back(p);
      }
    }
    for (const auto& [ends, pairs] : points)
    {
      std::vector<Index> quads;
      for (const std::size_t p : pairs)
      {
        quads.push_back(this->Pairs[p].a);
        quads.push_back(this->Pairs[p].b);
      }
      bool closes = false;
      for (const Index quad : quads)
      {
        const OuterQuad at = this->Surface.quadAt(quad);
        const std::array<Index, 4> nodes = this->Surface.nodes(at);
        this->forEdges(at, [&](const OuterEdge& edge) {
          const int c = edge.axis == 0 ? 2 * edge.side : edge.side;
          const Index first = nodes[c], second = nodes[c + (edge.axis == 0 ? 1 : 2)];
          if (first != ends.first && first != ends.second && second != ends.first && second != ends.second)
          {
            return;
          }
          const OuterEdge there = this->Surface.across(edge);
          const Index other = this->Surface.quad(there.quad);
          closes = closes || std::find(quads.begin(), quads.end(), other) != quads.end() ||
            !this->Surface.unnamed(there.quad.face) || this->cosine(quad, other) <= SmoothCosine;
        });
      }
      for (const std::size_t p : pairs)
      {
        loose[p] = closes;
      }
    }
  }

  /// Pairs of which each is the nearest to the other and could be glued.
  std::vector<char> mutualPairs(const std::vector<MeshFindingKind>& kinds) const
  {
    std::vector<std::size_t> best(this->Near.size(), this->Pairs.size());
    const auto nearer = [&](std::size_t p, std::size_t q) {
      return q == this->Pairs.size() || this->Pairs[p].distance < this->Pairs[q].distance;
    };
    for (std::size_t p = 0; p < this->Pairs.size(); ++p)
    {
      if (kinds[p] != MeshFindingKind::None && this->Pairs[p].matched)
      {
        for (const Index quad : { this->Pairs[p].a, this->Pairs[p].b })
        {
          std::size_t& known = best[this->slot(quad)];
          known = nearer(p, known) ? p : known;
        }
      }
    }
    std::vector<char> result(this->Pairs.size(), false);
    for (std::size_t p = 0; p < this->Pairs.size(); ++p)
    {
      result[p] = best[this->slot(this->Pairs[p].a)] == p && best[this->slot(this->Pairs[p].b)] == p;
    }
    return result;
  }

  void groupPairs(const Walls& walls, const std::vector<char>& loose)
  {
    const Index count = static_cast<Index>(this->Near.size());
    std::vector<MeshFindingKind> kinds(this->Pairs.size(), MeshFindingKind::None);
    std::vector<char> suspicious(count, false), narrow(count, false);
    for (std::size_t p = 0; p < this->Pairs.size(); ++p)
    {
      const NearPair& pair = this->Pairs[p];
      const Index a = this->slot(pair.a), b = this->slot(pair.b);
      kinds[p] = loose[p]     ? MeshFindingKind::LoosePoint
        : !pair.near          ? MeshFindingKind::None
        : walls.between(a, b) ? MeshFindingKind::NarrowGap
                              : MeshFindingKind::NearMiss;
      if (kinds[p] == MeshFindingKind::NearMiss || kinds[p] == MeshFindingKind::LoosePoint)
      {
        suspicious[a] = suspicious[b] = true;
      }
    }
    UnionFind groups(count);
    for (std::size_t p = 0; p < this->Pairs.size(); ++p)
    {
      const Index a = this->slot(this->Pairs[p].a), b = this->slot(this->Pairs[p].b);
      if (kinds[p] == MeshFindingKind::NarrowGap)
      {
        if (suspicious[a] || suspicious[b])
        {
          kinds[p] = MeshFindingKind::None;
          continue;
        }
        narrow[a] = narrow[b] = true;
      }
      if (kinds[p] != MeshFindingKind::None)
      {
        groups.unite(a, b);
      }
    }
    for (Index n = 0; n < count; ++n)
    {
      this->forEdges(this->Surface.quadAt(this->Near[n]), [&](const OuterEdge& edge) {
        const Index m = this->slot(this->Surface.quad(this->Surface.across(edge).quad));
        if (m >= 0 && ((suspicious[n] && suspicious[m]) || (narrow[n] && narrow[m])))
        {
          groups.unite(n, m);
        }
      });
    }

    // The shortest mesh edge at each of their points, which is what the match tolerance is measured by.
    std::map<Index, double> shortest;
    for (const Index quad : this->Near)
    {
      const std::array<Index, 4> nodes = this->Surface.nodes(this->Surface.quadAt(quad));
      for (int c = 0; c < 4; ++c)
      {
        const auto at = shortest.emplace(nodes[c], std::numeric_limits<double>::max()).first;
        at->second = std::min(at->second, this->shape(quad).shortest[c]);
      }
    }
    const std::vector<char> mutual = this->mutualPairs(kinds);
    std::vector<char> matched(count, false), atLoosePoint(count, false);
    std::map<Index, Index> partners;
    std::map<Index, MeshFinding> findings;
    for (std::size_t p = 0; p < this->Pairs.size(); ++p)
    {
      const NearPair& pair = this->Pairs[p];
      if (kinds[p] == MeshFindingKind::None)
      {
        continue;
      }
      const Index a = this->slot(pair.a), b = this->slot(pair.b);
      const OuterQuad quadA = this->Surface.quadAt(pair.a), quadB = this->Surface.quadAt(pair.b);
      MeshFinding& finding = findings[groups.find(a)];
      const Vec3 place = vec3(pair.place);
      if (finding.kind == MeshFindingKind::None || pair.fraction > finding.fraction ||
        (pair.fraction == finding.fraction && comesBefore(place, finding.place)))
      {
        finding.place = place;
        finding.blocks = { this->parent(quadA.face), this->parent(quadB.face) };
        finding.faces = { this->Surface.use(quadA.face).face, this->Surface.use(quadB.face).face };
        finding.fraction = pair.fraction;
      }
      finding.distance = std::max(finding.distance, pair.distance);
      finding.kind = kinds[p] == MeshFindingKind::NarrowGap ? kinds[p] : MeshFindingKind::LoosePoint;
      if (loose[p])
      {
        atLoosePoint[a] = atLoosePoint[b] = true;
      }
      if (mutual[p])
      {
        matched[a] = matched[b] = true;
        const std::array<Index, 4> nodesA = this->Surface.nodes(quadA), nodesB = this->Surface.nodes(quadB);
        for (int c = 0; c < 4; ++c)
        {
          const Index there = nodesB[pair.corners[c]];
          const double edge = std::min(shortest.at(nodesA[c]), shortest.at(there));
          const bool only = nodesA[c] == there ||
            (partners.emplace(nodesA[c], there).first->second == there &&
              partners.emplace(there, nodesA[c]).first->second == nodesA[c]);
          finding.glueTolerance =
            only ? std::max(finding.glueTolerance, pair.distances[c] / edge) : std::numeric_limits<double>::infinity();
        }
      }
    }
    for (Index n = 0; n < count; ++n)
    {
      const auto at = findings.find(groups.find(n));
      if (at != findings.end())
      {
        ++at->second.quads;
        if (at->second.kind == MeshFindingKind::LoosePoint && !atLoosePoint[n])
        {
          at->second.kind = MeshFindingKind::NearMiss;
        }
        at->second.glueTolerance = matched[n] ? at->second.glueTolerance : std::numeric_limits<double>::infinity();
      }
    }
    std::map<Index, int> numbers;
    for (auto& [group, finding] : findings)
    {
      if (std::isinf(finding.glueTolerance) || finding.kind == MeshFindingKind::NarrowGap)
      {
        finding.glueTolerance = 0.0;
      }
      if (std::tie(finding.blocks[1], finding.faces[1]) < std::tie(finding.blocks[0], finding.faces[0]))
      {
        std::swap(finding.blocks[0], finding.blocks[1]);
        std::swap(finding.faces[0], finding.faces[1]);
      }
      numbers[group] = this->add(finding);
    }
    for (Index n = 0; n < count; ++n)
    {
      const auto at = numbers.find(groups.find(n));
      if (at != numbers.end())
      {
        this->mark(this->Near[n], at->second);
      }
    }
  }
  ///@}

  /// @name Faces in other cells
  ///@{
  Ray rayFrom(const OuterQuad& at, int attempt) const
  {
    const OuterCell cell = this->Surface.cell(at);
    return { triple(cell.center()), triple(rayDirection(cell.area().stableNormalized(), attempt)),
      this->Surface.quad(at) };
  }

  /// How often more each ray leaves cells than it enters them.
  std::vector<int> windings(const std::vector<Ray>& rays) const
  {
    const Index count = static_cast<Index>(rays.size());
    std::vector<int> result(count, 0);
    this->Run.parallelFor(count, 16, [&](Index begin, Index end) {
      for (Index n = begin; n < end; ++n)
      {
        const Vec3 from = vec3(rays[n].from), along = vec3(rays[n].along);
        const Vec3 inverse = along.cwiseInverse();
        this->OwnTree->searchIf([&](const Box& box) { return meetsRay(box, from, inverse); },
          [&](Index tile) {
            if (meetsRay(this->Shapes[this->OwnTiles[tile]].box(), from, inverse))
            {
              result[n] += this->crossings(this->Tiles[this->OwnTiles[tile]], from, along, rays[n].quad);
            }
          });
      }
    });
    if (this->Others.size() > 1)
    {
      const std::vector<std::vector<int>> parts = this->Others.gather(result);
      std::fill(result.begin(), result.end(), 0);
      for (const std::vector<int>& part : parts)
      {
        for (Index n = 0; n < count; ++n)
        {
          result[n] += part[n];
        }
      }
    }
    return result;
  }

  int crossings(const Tile& tile, const Vec3& from, const Vec3& along, Index except) const
  {
    const FaceUse& use = this->Surface.use(tile.face);
    const ComplexBlock& block = this->Complex.blocks[use.block];
    const int normal = faceDirection(use.face);
    const double sign = ((normal == 1) != (faceSide(use.face) == 1)) != block.leftHanded ? 1.0 : -1.0;
    const Ijk cells{ block.cells(0), block.cells(1), block.cells(2) };
    std::array<std::array<Vec3, TileSize + 1>, 2> rows;
    const auto read = [&](int t) {
      for (int s = tile.s0; s <= tile.s1; ++s)
      {
        rows[t & 1][s - tile.s0] = block.points(facePoint(cells, use.face, s, t));
      }
    };
    int sum = 0;
    read(tile.t0);
    for (int t = tile.t0; t < tile.t1; ++t)
    {
      read(t + 1);
      for (int s = tile.s0; s < tile.s1; ++s)
      {
        if (this->Surface.quad({ tile.face, s, t }) == except)
        {
          continue;
        }
        const Vec3 &p00 = rows[t & 1][s - tile.s0], &p10 = rows[t & 1][s - tile.s0 + 1];
        const Vec3 &p01 = rows[(t + 1) & 1][s - tile.s0], &p11 = rows[(t + 1) & 1][s - tile.s0 + 1];
        sum += crossing(from, along, p00, p10, p11) + crossing(from, along, p00, p11, p01);
      }
    }
    return sign > 0.0 ? sum : -sum;
  }

  /// Of these quadrilaterals those that lie in other cells: all three rays say so.
  std::vector<Index> inside(const std::vector<Index>& mine) const
  {
    std::vector<Index> open = mine;
    for (int attempt = 0; attempt < 3; ++attempt)
    {
      std::vector<Ray> rays;
      for (const Index quad : open)
      {
        rays.push_back(this->rayFrom(this->Surface.quadAt(quad), attempt));
      }
      const std::vector<Ray> all = this->Others.size() == 1 ? rays : this->Others.gatherAll(rays);
      const std::vector<int> counts = this->windings(all);
      open.clear();
      for (std::size_t n = 0; n < all.size(); ++n)
      {
        if (counts[n] > 0 && this->isHere(this->Surface.quadAt(all[n].quad).face))
        {
          open.push_back(all[n].quad);
        }
      }
    }
    return open;
  }

  void findOverlaps()
  {
    std::vector<Box> boxes;
    for (Index n = 0; n < static_cast<Index>(this->Tiles.size()); ++n)
    {
      if (this->isHere(this->Tiles[n].face))
      {
        this->OwnTiles.push_back(n);
        boxes.push_back(this->Shapes[n].box());
      }
    }
    this->OwnTree = std::make_unique<BoxTree>(boxes);

    std::vector<Index> samples;
    for (const int face : this->Surface.faces())
    {
      if (!this->isHere(face) || !this->Surface.unnamed(face))
      {
        continue;
      }
      const auto positions = [&](int axis) {
        const int last = this->Surface.cells(face, axis) - 1;
        std::vector<int> result{ 0, last / 2, last - last / 2, last };
        std::sort(result.begin(), result.end());
        result.erase(std::unique(result.begin(), result.end()), result.end());
        return result;
      };
      for (const int t : positions(1))
      {
        for (const int s : positions(0))
        {
          this->appendFree({ face, s, t }, samples);
        }
      }
    }
    const std::vector<Index> hits = this->inside(samples);
    if (!this->Others.any(!hits.empty()))
    {
      return;
    }
    std::vector<int> faces;
    for (const Index quad : hits)
    {
      faces.push_back(this->Surface.quadAt(quad).face);
    }
    std::sort(faces.begin(), faces.end());
    faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
    std::vector<Index> quads;
    for (const int face : faces)
    {
      for (Index quad = this->Surface.firstQuad(face); quad < this->Surface.firstQuad(face + 1); ++quad)
      {
        this->appendFree(this->Surface.quadAt(quad), quads);
      }
    }
    std::vector<Ray> rays;
    for (const Index quad : this->inside(quads))
    {
      rays.push_back(this->rayFrom(this->Surface.quadAt(quad), 0));
    }
    rays = this->Others.size() == 1 ? rays : this->Others.gatherAll(rays);
    std::sort(rays.begin(), rays.end(), [](const Ray& a, const Ray& b) { return a.quad < b.quad; });
    // Of each face the first quadrilateral says in which block it lies.
    std::map<int, std::vector<const Ray*>> ofFace;
    for (const Ray& ray : rays)
    {
      ofFace[this->Surface.quadAt(ray.quad).face].push_back(&ray);
    }
    std::map<std::tuple<int, int, int>, MeshFinding> findings;
    std::map<std::tuple<int, int, int>, std::vector<Index>> concerned;
    for (const auto& [face, found] : ofFace)
    {
      const FaceUse& use = this->Surface.use(face);
      const std::tuple<int, int, int> key(this->parent(face), use.face, this->blockAround(*found.front(), use.block));
      MeshFinding& finding = findings[key];
      finding.kind = MeshFindingKind::Overlap;
      finding.blocks = { std::get<0>(key), std::get<2>(key) };
      finding.faces = { use.face, -1 };
      for (const Ray* ray : found)
      {
        const Vec3 place = vec3(ray->from);
        finding.place = finding.quads == 0 || comesBefore(place, finding.place) ? place : finding.place;
        ++finding.quads;
        concerned[key].push_back(ray->quad);
      }
    }
    for (const auto& [key, finding] : findings)
    {
      const int number = this->add(finding);
      for (const Index quad : concerned[key])
      {
        this->mark(quad, number);
      }
    }
  }

  void appendFree(const OuterQuad& at, std::vector<Index>& quads) const
  {
    if (collapsed(this->Surface.cell(at)))
    {
      return;
    }
    const std::vector<int>& findings = this->Result.findingOfQuad[at.face];
    const Index quad = this->Surface.quad(at);
    if (findings.empty() || findings[quad - this->Surface.firstQuad(at.face)] < 0 ||
      !this->Result.findings[findings[quad - this->Surface.firstQuad(at.face)]].suspicious())
    {
      quads.push_back(quad);
    }
  }

  /// The first input block, other than that of `own` if possible, in which a ray starts; -1 if none. Collective.
  int blockAround(const Ray& ray, int own) const
  {
    const Vec3 from = vec3(ray.from), along = vec3(ray.along);
    int found = -1;
    for (int b = 0; b < static_cast<int>(this->Complex.blocks.size()) && found < 0; ++b)
    {
      if (b == own || this->Complex.blocks[b].rank != this->Others.rank())
      {
        continue;
      }
      found = this->isInside(b, from, along) ? this->Complex.blocks[b].parent : -1;
    }
    if (this->Others.size() > 1)
    {
      for (const int other : this->Others.gatherAll(std::vector<int>{ found }))
      {
        found = found < 0 || (other >= 0 && other < found) ? other : found;
      }
    }
    return found;
  }

  bool isInside(int b, const Vec3& from, const Vec3& along) const
  {
    const ComplexBlock& block = this->Complex.blocks[b];
    const Ijk cells{ block.cells(0), block.cells(1), block.cells(2) };
    int sum = 0;
    for (int face = 0; face < 6; ++face)
    {
      const bool outwards = ((faceDirection(face) == 1) != (faceSide(face) == 1)) != block.leftHanded;
      int part = 0;
      for (int t = 0; t < cells[faceAxis(face, 1)]; ++t)
      {
        for (int s = 0; s < cells[faceAxis(face, 0)]; ++s)
        {
          const auto at = [&](int ds, int dt) { return block.points(facePoint(cells, face, s + ds, t + dt)); };
          part +=
            crossing(from, along, at(0, 0), at(1, 0), at(1, 1)) + crossing(from, along, at(0, 0), at(1, 1), at(0, 1));
        }
      }
      sum += outwards ? part : -part;
    }
    return sum > 0;
  }
  ///@}

  /// Closed parts of the outer surface around a hole.
  void findInnerBoundaries()
  {
    const std::vector<int>& faces = this->Surface.faces();
    const Index count = static_cast<Index>(faces.size());
    std::vector<Index> slot(this->Complex.faces.size(), -1);
    for (Index n = 0; n < count; ++n)
    {
      slot[faces[n]] = n;
    }
    UnionFind parts(count);
    Box all;
    for (Index n = 0; n < count; ++n)
    {
      this->forEdges({ faces[n], 0, 0 }, [&](OuterEdge edge) {
        const int last = this->Surface.cells(faces[n], 1 - edge.axis) - 1;
        (edge.axis == 0 ? edge.quad.t : edge.quad.s) = edge.side ? last : 0;
        parts.unite(n, slot[this->Surface.across(edge).quad.face]);
      });
      for (Index tile = this->FirstTile[n]; tile < this->FirstTile[n + 1]; ++tile)
      {
        all.extend(this->Shapes[tile].box());
      }
    }
    struct Part
    {
      double volume = 0.0;
      MeshFinding finding;
    };
    std::vector<Part> sums(count);
    for (Index n = 0; n < count; ++n)
    {
      Part& part = sums[parts.find(n)];
      for (Index tile = this->FirstTile[n]; tile < this->FirstTile[n + 1]; ++tile)
      {
        const TileShape& shape = this->Shapes[tile];
        part.volume += shape.flux - all.center().dot(vec3(shape.area));
        if (this->Surface.unnamed(faces[n]))
        {
          const Vec3 place = vec3(shape.first);
          MeshFinding& finding = part.finding;
          if (finding.quads == 0 || comesBefore(place, finding.place))
          {
            finding.place = place;
            finding.blocks[0] = this->parent(faces[n]);
            finding.faces[0] = this->Surface.use(faces[n]).face;
          }
          const Tile& rectangle = this->Tiles[tile];
          finding.quads += Index(rectangle.s1 - rectangle.s0) * (rectangle.t1 - rectangle.t0);
        }
      }
    }
    std::vector<int> numbers(count, -1);
    for (Index n = 0; n < count; ++n)
    {
      // Outwards is into the hole. What is closed has no volume only by rounding.
      const double size = all.sizes().prod();
      if (parts.find(n) == n && sums[n].finding.quads > 0 && sums[n].volume < -1e-12 * size)
      {
        sums[n].finding.kind = MeshFindingKind::InnerBoundary;
        numbers[n] = this->add(sums[n].finding);
      }
    }
    for (Index n = 0; n < count; ++n)
    {
      const int number = numbers[parts.find(n)];
      for (Index quad = this->Surface.firstQuad(faces[n]);
           number >= 0 && this->Surface.unnamed(faces[n]) && quad < this->Surface.firstQuad(faces[n] + 1); ++quad)
      {
        this->mark(quad, number);
      }
    }
  }

  void findComponents()
  {
    const int count = static_cast<int>(this->Complex.blocks.size());
    UnionFind parts(count);
    for (const ComplexFace& face : this->Complex.faces)
    {
      parts.unite(face.uses.front().block, face.uses.back().block);
    }
    std::map<Index, MeshFinding> findings;
    std::map<Index, std::vector<int>> parents;
    for (int b = 0; b < count; ++b)
    {
      parents[parts.find(b)].push_back(this->Complex.blocks[b].parent);
    }
    this->Result.components = static_cast<int>(parents.size());
    for (auto& [part, blocks] : parents)
    {
      std::sort(blocks.begin(), blocks.end());
      blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
      MeshFinding finding;
      finding.kind = MeshFindingKind::Component;
      finding.blocks[0] = blocks.front();
      finding.quads = static_cast<Index>(blocks.size());
      if (parents.size() > 1)
      {
        this->add(finding);
      }
    }
  }

  int parent(int face) const { return this->Complex.blocks[this->Surface.use(face).block].parent; }

  int add(const MeshFinding& finding)
  {
    this->Result.findings.push_back(finding);
    return static_cast<int>(this->Result.findings.size()) - 1;
  }

  /// The first finding of a quadrilateral counts, a suspicious one before others.
  void mark(Index quad, int number)
  {
    const OuterQuad at = this->Surface.quadAt(quad);
    std::vector<int>& findings = this->Result.findingOfQuad[at.face];
    findings.resize(this->Surface.firstQuad(at.face + 1) - this->Surface.firstQuad(at.face), -1);
    int& known = findings[quad - this->Surface.firstQuad(at.face)];
    if (known < 0 || this->Result.findings[number].kind < this->Result.findings[known].kind)
    {
      known = number;
    }
  }

  void sortFindings()
  {
    std::vector<MeshFinding>& findings = this->Result.findings;
    std::vector<int> order(findings.size());
    for (std::size_t n = 0; n < order.size(); ++n)
    {
      order[n] = static_cast<int>(n);
    }
    std::sort(order.begin(), order.end(), [&](int a, int b) {
      const MeshFinding &x = findings[a], &y = findings[b];
      return std::tie(x.kind, x.blocks, x.faces, a) < std::tie(y.kind, y.blocks, y.faces, b);
    });
    std::vector<MeshFinding> sorted;
    std::vector<int> place(findings.size());
    for (const int n : order)
    {
      place[n] = static_cast<int>(sorted.size());
      sorted.push_back(findings[n]);
    }
    findings = std::move(sorted);
    for (std::vector<int>& face : this->Result.findingOfQuad)
    {
      for (int& number : face)
      {
        number = number < 0 ? number : place[number];
      }
    }
  }

  /// valueOf(quadrilateral) of all in an ascending list, computed by the ranks that have their points. Collective.
  template <typename T, typename ValueOf>
  std::vector<T> ask(const std::vector<Index>& quads, const ValueOf& valueOf) const
  {
    std::vector<T> result(quads.size());
    std::vector<std::vector<Index>> questions(this->Others.size());
    std::vector<int> rankOf(quads.size());
    for (std::size_t n = 0; n < quads.size(); ++n)
    {
      const OuterQuad at = this->Surface.quadAt(quads[n]);
      rankOf[n] = this->Surface.rankOf(at.face);
      if (rankOf[n] == this->Others.rank())
      {
        result[n] = valueOf(at);
      }
      else
      {
        questions[rankOf[n]].push_back(quads[n]);
      }
    }
    if (this->Others.size() > 1)
    {
      const std::vector<std::vector<T>> answers =
        this->Others.ask(questions, [&](Index quad) -> T { return valueOf(this->Surface.quadAt(quad)); });
      std::vector<std::size_t> next(answers.size(), 0);
      for (std::size_t n = 0; n < quads.size(); ++n)
      {
        if (rankOf[n] != this->Others.rank())
        {
          result[n] = answers[rankOf[n]][next[rankOf[n]]++];
        }
      }
    }
    return result;
  }

  static constexpr Index Chunk = 256;

  const BlockComplex& Complex;
  const Execution& Run;
  const Ranks& Others;
  const OuterSurface Surface;
  MeshDiagnosis Result;
  std::vector<Tile> Tiles;
  /// Per boundary face, in their order.
  std::vector<Index> FirstTile;
  std::vector<TileShape> Shapes;
  std::vector<Index> OwnTiles;
  std::unique_ptr<BoxTree> OwnTree;
  std::vector<NearPair> Pairs;
  /// The quadrilaterals of the pairs, and with those next to them; ascending.
  std::vector<Index> Near, KnownQuads;
  std::vector<QuadShape> Known;
};

std::string figure(double value)
{
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.3g", value);
  return buffer;
}

} // namespace

const std::vector<std::string>& meshFindingNames()
{
  static const std::vector<std::string> names{ "None", "NearMiss", "LoosePoint", "Overlap", "NarrowGap",
    "InnerBoundary", "Component" };
  return names;
}

MeshDiagnosis diagnose(const BlockComplex& complex, const Execution& run)
{
  return Doctor(complex, run)();
}

std::string describe(const BlockMesh& mesh, const MeshFinding& finding)
{
  const auto side = [&](int n) {
    return finding.blocks[n] < 0
      ? std::string("other cells")
      : blockLabel(mesh, finding.blocks[n]) + (finding.faces[n] < 0 ? "" : " " + faceLabel(finding.faces[n]));
  };
  const std::string quads =
    std::to_string(finding.quads) + (finding.quads == 1 ? " outer quadrilateral" : " outer quadrilaterals");
  const std::string place = " near " + text(finding.place);
  const std::string apart =
    "up to " + figure(finding.distance) + " apart (" + figure(finding.fraction) + " of the cells there)";
  std::string result;
  switch (finding.kind)
  {
    case MeshFindingKind::NearMiss:
      result = side(0) + " and " + side(1) + " nearly face each other, " + apart + place + ": " + quads;
      break;
    case MeshFindingKind::LoosePoint:
      result = side(0) + " and " + side(1) + " would meet but for one point, " + apart + place + ": " + quads;
      break;
    case MeshFindingKind::Overlap:
      result = side(0) + " lies in " + side(1) + place + ": " + quads;
      break;
    case MeshFindingKind::NarrowGap:
      return "walls come close to each other at " + side(0) + " and " + side(1) + ", " + apart + place + ": " + quads;
    case MeshFindingKind::InnerBoundary:
      return "inner boundary without a name at " + side(0) + place + ": " + quads;
    case MeshFindingKind::Component:
      return std::to_string(finding.quads) + (finding.quads == 1 ? " block" : " blocks") + " from " + side(0) +
        " on share no face with the others";
    default:
      return {};
  }
  if (finding.kind != MeshFindingKind::Overlap)
  {
    result += finding.glueTolerance > 0.0 && finding.glueTolerance < 0.5
      ? "; a Match Tolerance above " + figure(finding.glueTolerance) + " would glue them"
      : "; no Match Tolerance would glue them";
  }
  return result;
}

void refuseSuspicious(const BlockMesh& mesh, const MeshDiagnosis& diagnosis)
{
  Index count = 0;
  for (const MeshFinding& finding : diagnosis.findings)
  {
    count += finding.suspicious() ? 1 : 0;
  }
  if (count > 0)
  {
    throw Error("blocks do not meet where they seem to be meant to, at " + std::to_string(count) +
      (count == 1 ? " place: " : " places, the first: ") + describe(mesh, diagnosis.findings.front()) +
      ". Correct the mesh, name these faces as boundaries, or switch on Allow Open Interior");
  }
}

} // namespace bsv
