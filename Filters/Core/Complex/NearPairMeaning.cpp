// SPDX-License-Identifier: BSD-3-Clause
#include "Base/CanonicalOrder.h"
#include "Base/UnionFind.h"
#include "Complex/NearPairs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace bsv
{
namespace
{

/// Cosine of the turn up to which a surface is smooth: 40 degrees.
const double SmoothCosine = std::cos(40.0 / DegreesPerRadian);
/// A near part is one of walls if the surface goes on from at least this fraction of its border.
constexpr int BorderShare = 8;
/// Quadrilaterals across which an edge between two sides of a thin wall is looked for.
constexpr int WidestRim = 8;

/// Shape of a quadrilateral that was asked for.
struct QuadShape
{
  Triple normal{ 0, 0, 0 };
  Triple center{ 0, 0, 0 };
  /// Shortest mesh edge at each corner.
  std::array<double, 4> shortest{ 0, 0, 0, 0 };
};

class PairJudge
{
public:
  PairJudge(const OuterSurface& surface, const std::vector<NearPair>& pairs, const Ranks& ranks, MeshFindings& findings)
    : Surface(surface)
    , Pairs(pairs)
    , Others(ranks)
    , Findings(findings)
  {
  }

  void operator()()
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
      forOuterEdges(this->Surface.quadAt(quad), [&](const OuterEdge& edge) {
        this->KnownQuads.push_back(this->Surface.quad(this->Surface.across(edge).quad));
      });
    }
    std::sort(this->KnownQuads.begin(), this->KnownQuads.end());
    this->KnownQuads.erase(std::unique(this->KnownQuads.begin(), this->KnownQuads.end()), this->KnownQuads.end());
    this->Known = ofQuads<QuadShape>(this->Surface, this->Others, this->KnownQuads,
      [this](const OuterQuad& at) { return this->shapeOf(this->Surface.cell(at)); });

    const Walls walls = this->findWalls();
    std::vector<char> loose(this->Pairs.size(), false);
    this->findLoose(loose);
    this->groupPairs(walls, loose);
  }

private:
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

  /// The edge on the other side of the quadrilateral.
  static OuterEdge opposite(OuterEdge edge)
  {
    edge.side = 1 - edge.side;
    return edge;
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
      forOuterEdges(this->Surface.quadAt(this->Near[n]), [&](const OuterEdge& edge) {
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
    for (const auto& point : points)
    {
      const auto& ends = point.first;
      std::vector<Index> quads;
      for (const std::size_t p : point.second)
      {
        quads.push_back(this->Pairs[p].a);
        quads.push_back(this->Pairs[p].b);
      }
      bool closes = false;
      for (const Index quad : quads)
      {
        const OuterQuad at = this->Surface.quadAt(quad);
        const std::array<Index, 4> nodes = this->Surface.nodes(at);
        forOuterEdges(at, [&](const OuterEdge& edge) {
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
      for (const std::size_t p : point.second)
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
      forOuterEdges(this->Surface.quadAt(this->Near[n]), [&](const OuterEdge& edge) {
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
        finding.blocks = { this->Findings.parent(quadA.face), this->Findings.parent(quadB.face) };
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
      numbers[group] = this->Findings.add(finding);
    }
    for (Index n = 0; n < count; ++n)
    {
      const auto at = numbers.find(groups.find(n));
      if (at != numbers.end())
      {
        this->Findings.mark(this->Near[n], at->second);
      }
    }
  }

  const OuterSurface& Surface;
  const std::vector<NearPair>& Pairs;
  const Ranks& Others;
  MeshFindings& Findings;
  /// The quadrilaterals of the pairs, and with those next to them; ascending.
  std::vector<Index> Near, KnownQuads;
  std::vector<QuadShape> Known;
};

} // namespace

void judgeNearPairs(
  const OuterSurface& surface, const std::vector<NearPair>& pairs, const Ranks& ranks, MeshFindings& findings)
{
  PairJudge(surface, pairs, ranks, findings)();
}

} // namespace bsv
