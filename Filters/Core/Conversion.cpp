// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion.h"

#include "EdgeFans.h"
#include "EntityRules.h"
#include "LayerRules.h"
#include "OrderFreeSum.h"
#include "SingularNode.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>

namespace bsv
{
namespace
{

constexpr double KnotInsertion = 2.0 / 3.0;

/// Where a mesh position goes in the control net: 0, 1, ... from either end are the end point and the inserted point,
/// mesh points keep their order between them.
int endPosition(int side, int fromEnd, int cells)
{
  return side == 0 ? fromEnd : cells + 2 - fromEnd;
}
int innerPosition(int meshIndex)
{
  return meshIndex + 1;
}

/// The conversion of one complex. Each method computes the control points owned by one kind of entity and writes them
/// into all blocks that share it.
class Converter
{
public:
  Converter(const BlockComplex& complex, const ConversionOptions& options, const std::vector<ControlNetStorage>& nets,
    const Execution& run)
    : Complex(complex)
    , Options(options)
    , Nets(nets)
    , Run(run)
    , Rules(classify(complex, options, run))
  {
  }

  ConversionReport convert();

private:
  /// @name Control points owned by the interior of a block, face, edge, and by a vertex
  ///@{
  void convertBlock(int block, int slab);
  void convertFace(int face);
  void convertEdge(int edge);
  void convertVertex(int vertex);
  ///@}

  /// @name Layers of quadrilaterals across an edge
  ///@{
  Fan meshFan(const EdgeFan& fan, int k) const;
  /// Control points of layer k, before the rule along the edge.
  Fan controlFan(int edge, const EdgeFan& fan, int k) const;
  std::vector<double> nearWeights(const EdgeFan& fan) const;
  /// How far the faces behind the spokes keep their points in layer k.
  std::vector<SpokeKeep> spokeKeeps(const EdgeFan& fan, int k) const;
  double keepAt(int block, int face, const Ijk& point) const;
  ///@}

  /// @name Vertex by vertex
  ///@{
  struct Star;
  Star makeStar(int vertex) const;
  /// The outer surface around a boundary vertex: centre, inserted points on boundary edges and faces.
  void convertSurface(Star& star) const;
  Fan smoothSurfaceFan(const Star& star, const Fan& fan, const std::vector<double>& weights,
    const std::vector<SpokeKeep>& keeps, bool body) const;
  bool convertRegular(Star& star) const;
  /// Blocks in two stacks (or one, at the boundary) around an axis: the rule across the layers after the rule in them.
  bool convertStacked(Star& star) const;
  bool areStacked(const Star& star, int up, int down) const;
  void convertAnchored(Star& star) const;
  Fan starLayer(const Star& star, int starEdge, int k) const;
  ///@}

  bool isWall(int face) const
  {
    return this->Complex.faces[face].boundary() && this->Rules.faces[face].role == BoundaryRole::Body;
  }
  Index index(int block, const Ijk& position) const
  {
    const ComplexBlock& owner = this->Complex.blocks[block];
    return position[0] + Index(owner.cells(0) + 3) * (position[1] + Index(owner.cells(1) + 3) * position[2]);
  }
  void write(int block, const Ijk& position, const Vec3& point, ControlPointRule rule) const
  {
    const Index i = this->index(block, position);
    std::copy_n(point.data(), 3, this->Nets[block].points + 3 * i);
    this->Nets[block].rules[i] = static_cast<std::uint8_t>(rule);
  }

  const BlockComplex& Complex;
  const ConversionOptions& Options;
  const std::vector<ControlNetStorage>& Nets;
  const Execution& Run;
  const EntityRules Rules;
  std::atomic<Index> SingularNodes{ 0 };
};

/// A vertex star with its results.
struct Converter::Star : VertexStar
{
  bool boundary = false;
  Vec3 center;
  ControlPointRule rule = ControlPointRule::Regular;
  /// Weight of the vertex in inserted points along each star edge.
  std::vector<double> near;
  /// Fan of each star edge; star-block index per sector and star-edge index per spoke.
  struct EdgeInfo
  {
    const EdgeFan* fan = nullptr;
    std::vector<int> spokes;
    std::vector<int> sectors;
    bool whole = true; ///< the edge has one fan only
  };
  std::vector<EdgeInfo> info;
  /// Inserted points: along star edges, in star faces, in star blocks.
  std::vector<Vec3> edgePoints, facePoints, blockPoints;
  std::vector<ControlPointRule> edgeRules, faceRules, blockRules;
  /// Whether the outer surface has no feature here that a rule across layers would have to respect.
  bool surfaceIsSmooth = false;
  /// The two star edges of a crease through the vertex, or -1.
  std::array<int, 2> crease{ -1, -1 };

  /// Star faces that keep points near the vertex (FaceRule::keep).
  std::vector<bool> keptFaces;
  /// The same at the face's point.
  std::vector<double> diagonalKeep;

  bool keepsPoints() const { return std::find(this->keptFaces.begin(), this->keptFaces.end(), true) != this->keptFaces.end(); }
  bool blockHas(int block, int edge) const
  {
    const auto& e = this->blocks[block].edges;
    return e[0] == edge || e[1] == edge || e[2] == edge;
  }
};

//----------------------------------------------------------------------------------------------------------------------
// Blocks and faces

void Converter::convertBlock(int block, int slab)
{
  const ComplexBlock& owner = this->Complex.blocks[block];
  const int ni = owner.cells(0), nj = owner.cells(1);
  for (int j = 1; j < nj; ++j)
  {
    if (ni < 2)
    {
      return;
    }
    const Index start = this->index(block, { innerPosition(1), innerPosition(j), innerPosition(slab) });
    double* target = this->Nets[block].points + 3 * start;
    const GridView& points = owner.points;
    if (!points.isFloat() && points.stride(0) == 1)
    {
      std::memcpy(target, points.address<double>(1, j, slab), 3 * sizeof(double) * (ni - 1));
    }
    else
    {
      for (int i = 1; i < ni; ++i)
      {
        const Vec3 point = points(i, j, slab);
        std::copy_n(point.data(), 3, target + 3 * (i - 1));
      }
    }
    std::memset(
      this->Nets[block].rules + start, static_cast<int>(ControlPointRule::Copied), static_cast<std::size_t>(ni - 1));
  }
}

void Converter::convertFace(int face)
{
  const ComplexFace& shared = this->Complex.faces[face];
  const FaceRule& faceRule = this->Rules.faces[face];
  const bool wall = this->isWall(face);
  const double near = wall ? this->Options.wallSpacing : KnotInsertion;

  struct Side
  {
    const ComplexBlock* owner;
    int block;
    int face;
    Ijk cells;
    int normal, first, second;

    Ijk mesh(int s, int t, int depth) const
    {
      Ijk ijk;
      ijk[this->first] = s;
      ijk[this->second] = t;
      ijk[this->normal] = faceSide(this->face) ? this->cells[this->normal] - depth : depth;
      return ijk;
    }
    Ijk net(int s, int t, int fromEnd) const
    {
      Ijk ijk;
      ijk[this->first] = innerPosition(s);
      ijk[this->second] = innerPosition(t);
      ijk[this->normal] = endPosition(faceSide(this->face), fromEnd, this->cells[this->normal]);
      return ijk;
    }
  };
  std::vector<Side> sides;
  for (const FaceUse& use : shared.uses)
  {
    const ComplexBlock& owner = this->Complex.blocks[use.block];
    sides.push_back({ &owner, use.block, use.face, { owner.cells(0), owner.cells(1), owner.cells(2) },
      faceDirection(use.face), faceAxis(use.face, 0), faceAxis(use.face, 1) });
  }

  const int ns = sides[0].cells[sides[0].first];
  const int nt = sides[0].cells[sides[0].second];
  for (int t = 1; t < nt; ++t)
  {
    for (int s = 1; s < ns; ++s)
    {
      const Vec3 own = sides[0].owner->points(sides[0].mesh(s, t, 0));
      const Vec3 inner = sides[0].owner->points(sides[0].mesh(s, t, 1));
      this->write(sides[0].block, sides[0].net(s, t, 1), insertMask(own, inner, near),
        wall ? ControlPointRule::WallLayer : ControlPointRule::Regular);
      if (shared.boundary())
      {
        this->write(sides[0].block, sides[0].net(s, t, 0), own, this->Rules.boundaryRule(face));
        continue;
      }
      const std::array<int, 2> st = mapFacePoint(shared.orientation, s, t, ns, nt);
      const Vec3 across = sides[1].owner->points(sides[1].mesh(st[0], st[1], 1));
      const double keep = faceRule.keep.empty() ? 0.0 : faceRule.keep[s + std::size_t(ns + 1) * t];
      const Vec3 middle = faceRule.planar() ? own : fadedMask(inner, own, across, keep);
      const ControlPointRule rule = faceRule.planar() ? ControlPointRule::PlanarSide
        : keep > 0.0                                  ? ControlPointRule::Crease
                                                      : ControlPointRule::Regular;
      this->write(sides[0].block, sides[0].net(s, t, 0), middle, rule);
      this->write(sides[1].block, sides[1].net(st[0], st[1], 0), middle, rule);
      this->write(
        sides[1].block, sides[1].net(st[0], st[1], 1), insertMask(own, across, near), ControlPointRule::Regular);
    }
  }
}

//----------------------------------------------------------------------------------------------------------------------
// Edges

Fan Converter::meshFan(const EdgeFan& fan, int k) const
{
  Fan result;
  result.closed = fan.closed;
  for (const FanSector& sector : fan.sectors)
  {
    const ComplexBlock& owner = this->Complex.blocks[sector.block];
    result.center = owner.points(sector.point(owner, k, 0, 0));
    result.spokes.push_back(owner.points(sector.point(owner, k, 1, 0)));
    result.sectors.push_back(owner.points(sector.point(owner, k, 1, 1)));
  }
  if (!fan.closed)
  {
    const ComplexBlock& owner = this->Complex.blocks[fan.sectors.back().block];
    result.spokes.push_back(owner.points(fan.sectors.back().point(owner, k, 0, 1)));
  }
  return result;
}

std::vector<double> Converter::nearWeights(const EdgeFan& fan) const
{
  // A spoke leaves a wall if it borders a sector whose other spoke lies in the wall.
  std::vector<double> weights(fan.spokeCount(), KnotInsertion);
  for (int i = 0; i < static_cast<int>(fan.sectors.size()); ++i)
  {
    const int next = (i + 1) % fan.spokeCount();
    if (this->isWall(fan.faceOf(this->Complex, i)))
    {
      weights[next] = this->Options.wallSpacing;
    }
    if (this->isWall(fan.faceOf(this->Complex, next)))
    {
      weights[i] = this->Options.wallSpacing;
    }
  }
  return weights;
}

double Converter::keepAt(int block, int face, const Ijk& point) const
{
  const std::vector<double>& keep = this->Rules.faces[this->Complex.blocks[block].faces[face]].keep;
  return keep.empty()
    ? 0.0
    : keep[keepIndex(this->Complex, block, face, point[faceAxis(face, 0)], point[faceAxis(face, 1)])];
}

std::vector<SpokeKeep> Converter::spokeKeeps(const EdgeFan& fan, int k) const
{
  std::vector<SpokeKeep> keeps(fan.spokeCount());
  for (int i = 0; i < fan.spokeCount(); ++i)
  {
    const auto [sector, which] = fan.spoke(i);
    const ComplexBlock& owner = this->Complex.blocks[sector->block];
    const int face = sector->spokeFace(which);
    keeps[i].center = this->keepAt(sector->block, face, sector->point(owner, k, 0, 0));
    keeps[i].step = this->keepAt(sector->block, face, sector->point(owner, k, which == 0 ? 1 : 0, which == 0 ? 0 : 1));
  }
  return keeps;
}

Fan Converter::controlFan(int edge, const EdgeFan& fan, int k) const
{
  const Fan points = this->meshFan(fan, k);
  const std::vector<double> weights = this->nearWeights(fan);
  const std::vector<SpokeKeep> keeps = this->spokeKeeps(fan, k);
  if (!this->Rules.edges[edge].anchored)
  {
    return fadedFan(points, this->Options.twist, weights, keeps);
  }
  std::vector<Vec3> along = points.spokes;
  const int sectors = points.sectorCount();
  for (int i = 0; i < points.spokeCount(); ++i)
  {
    const int face = fan.faceOf(this->Complex, i);
    if (!this->Complex.faces[face].boundary() && !this->Rules.faces[face].planar())
    {
      along[i] = fadedMask(
        points.sectors[(i + sectors - 1) % sectors], points.spokes[i], points.sectors[i % sectors], keeps[i].step);
    }
  }
  return anchoredFan(points, points.center, along, weights);
}

void Converter::convertEdge(int edge)
{
  const ComplexEdge& shared = this->Complex.edges[edge];
  const EdgeRule& edgeRule = this->Rules.edges[edge];
  for (const EdgeFan& fan : edgeRule.fans)
  {
    const std::vector<double> weights = this->nearWeights(fan);
    const bool ordinary = edgeRule.rule != ControlPointRule::ExtraordinaryEdge;
    const auto ruleOf = [&](double weightFirst, double weightSecond) {
      return ordinary && (weightFirst != KnotInsertion || weightSecond != KnotInsertion) ? ControlPointRule::WallLayer
                                                                                         : edgeRule.rule;
    };
    for (int k = 1; k < shared.cells; ++k)
    {
      const Fan values = this->controlFan(edge, fan, k);
      const std::vector<SpokeKeep> keeps = this->spokeKeeps(fan, k);
      const bool keepsAny = std::any_of(keeps.begin(), keeps.end(), [](const SpokeKeep& keep) { return keep.any(); });
      const auto spokeRule = [&](int i) {
        return keeps[i].any() ? ControlPointRule::Crease : ruleOf(weights[i], KnotInsertion);
      };
      for (int i = 0; i < static_cast<int>(fan.sectors.size()); ++i)
      {
        const FanSector& sector = fan.sectors[i];
        const ComplexBlock& owner = this->Complex.blocks[sector.block];
        const int next = (i + 1) % fan.spokeCount();
        const auto put = [&](int a, int b, const Vec3& point, ControlPointRule rule) {
          Ijk ijk;
          ijk[sector.along] = innerPosition(sector.reversed ? shared.cells - k : k);
          ijk[sector.first] = endPosition(sector.side(sector.first), a, owner.cells(sector.first));
          ijk[sector.second] = endPosition(sector.side(sector.second), b, owner.cells(sector.second));
          this->write(sector.block, ijk, point, rule);
        };
        put(0, 0, values.center, keepsAny ? ControlPointRule::Crease : edgeRule.rule);
        put(1, 0, values.spokes[i], spokeRule(i));
        put(0, 1, values.spokes[next], spokeRule(next));
        put(1, 1, values.sectors[i], ruleOf(weights[i], weights[next]));
      }
    }
  }
}

//----------------------------------------------------------------------------------------------------------------------
// Vertices

Converter::Star Converter::makeStar(int vertex) const
{
  Star star;
  static_cast<VertexStar&>(star) = vertexStar(this->Complex, vertex);
  star.boundary = this->Complex.vertices[vertex].boundary;
  star.center = star.point;
  const std::size_t edges = star.edges.size();
  star.near.assign(edges, KnotInsertion);
  star.info.resize(edges);
  star.edgePoints.resize(edges);
  star.edgeRules.resize(edges);
  star.facePoints.resize(star.faces.size());
  star.faceRules.resize(star.faces.size());
  star.blockPoints.resize(star.blocks.size());
  star.blockRules.resize(star.blocks.size());
  for (const VertexStar::Block& block : star.blocks)
  {
    for (int d = 0; d < 3; ++d)
    {
      if (this->isWall(star.faces[block.faces[d]].face))
      {
        star.near[block.edges[d]] = this->Options.wallSpacing;
      }
    }
  }
  star.keptFaces.assign(star.faces.size(), false);
  star.diagonalKeep.assign(star.faces.size(), 0.0);
  for (const VertexStar::Block& block : star.blocks)
  {
    const ComplexBlock& owner = this->Complex.blocks[block.block];
    for (int d = 0; d < 3; ++d)
    {
      const int face = 2 * d + cornerSide(block.corner, d);
      for (int steps = 0; steps < 8; ++steps)
      {
        Ijk point;
        for (int axis = 0; axis < 3; ++axis)
        {
          const int step = axis == d ? 0 : steps >> axis & 1;
          point[axis] = cornerSide(block.corner, axis) ? owner.cells(axis) - step : step;
        }
        const double keep = this->keepAt(block.block, face, point);
        star.keptFaces[block.faces[d]] = star.keptFaces[block.faces[d]] || keep > 0.0;
        if ((steps | 1 << d) == 7)
        {
          star.diagonalKeep[block.faces[d]] = keep;
        }
      }
    }
  }
  for (std::size_t e = 0; e < edges; ++e)
  {
    const std::vector<EdgeFan>& fans = this->Rules.edges[star.edges[e].edge].fans;
    Star::EdgeInfo& info = star.info[e];
    info.fan = &fans.front();
    info.whole = fans.size() == 1;
    for (const FanSector& sector : info.fan->sectors)
    {
      // The corner of the sector's block at this end of the edge.
      const int corner = edgeCorner(sector.edge, star.edges[e].end ^ (sector.reversed ? 1 : 0));
      int index = 0;
      while (star.blocks[index].block != sector.block || star.blocks[index].corner != corner)
      {
        ++index;
      }
      info.sectors.push_back(index);
      info.spokes.push_back(star.blocks[index].edges[sector.first]);
    }
    if (!info.fan->closed)
    {
      info.spokes.push_back(star.blocks[info.sectors.back()].edges[info.fan->sectors.back().second]);
    }
  }
  return star;
}

Fan Converter::starLayer(const Star& star, int starEdge, int k) const
{
  const VertexStar::Edge& edge = star.edges[starEdge];
  const int cells = this->Complex.edges[edge.edge].cells;
  return this->controlFan(edge.edge, *star.info[starEdge].fan, edge.end == 0 ? k : cells - k);
}

Fan Converter::smoothSurfaceFan(const Star& star, const Fan& fan, const std::vector<double>& weights,
  const std::vector<SpokeKeep>& keeps, bool body) const
{
  if (body && fan.sectorCount() != 4)
  {
    const auto givenAt = [&](const std::vector<const double*>& arrays, Vec3& value) {
      bool found = false;
      for (const VertexStar::Block& entry : star.blocks)
      {
        const ComplexBlock& owner = this->Complex.blocks[entry.block];
        const double* array = owner.parent < static_cast<int>(arrays.size()) ? arrays[owner.parent] : nullptr;
        if (!array)
        {
          continue;
        }
        // Strides of the parent's points are those of its arrays.
        Index at = 0;
        for (int d = 0; d < 3; ++d)
        {
          at += owner.points.stride(d) *
            (owner.offset[d] + (cornerSide(entry.corner, d) ? owner.cells(d) : 0));
        }
        const Vec3 given(array[3 * at], array[3 * at + 1], array[3 * at + 2]);
        // Copies may differ in the blocks: the smallest is as good as any and is the same in every order.
        if (given.allFinite() &&
          (!found || std::lexicographical_compare(given.data(), given.data() + 3, value.data(), value.data() + 3)))
        {
          value = given;
          found = true;
        }
      }
      return found;
    };
    Vec3 projection, normal;
    const bool hasPoint = givenAt(this->Options.projectedPoints, projection);
    const bool hasNormal = givenAt(this->Options.surfaceNormals, normal) && normal.norm() > 0.0;
    if (hasPoint || hasNormal)
    {
      if (!hasPoint)
      {
        projection = smoothFan(fan, this->Options.twist, weights).center;
      }
      return projectedFan(
        fan, projection, hasNormal ? Vec3(normal.normalized()) : limitNormal(fan), this->Options.twist);
    }
  }
  return fadedFan(fan, this->Options.twist, weights, keeps);
}

void Converter::convertSurface(Star& star) const
{
  // Boundary faces around the vertex in cyclic order: spoke i is a boundary edge, sector i lies between i and i + 1.
  std::vector<int> spokes, sectors;
  std::vector<int> boundaryFaces;
  std::vector<int> facesAtEdge(star.edges.size(), 0);
  for (int f = 0; f < static_cast<int>(star.faces.size()); ++f)
  {
    if (star.faces[f].boundary)
    {
      boundaryFaces.push_back(f);
      ++facesAtEdge[star.faces[f].edges[0]];
      ++facesAtEdge[star.faces[f].edges[1]];
    }
  }
  bool manifold = !boundaryFaces.empty();
  for (const int count : facesAtEdge)
  {
    manifold = manifold && (count == 0 || count == 2);
  }
  if (manifold)
  {
    int face = boundaryFaces.front();
    int spoke = star.faces[face].edges[0];
    do
    {
      spokes.push_back(spoke);
      sectors.push_back(face);
      const auto& ends = star.faces[face].edges;
      spoke = ends[0] == spoke ? ends[1] : ends[0];
      for (const int other : boundaryFaces)
      {
        if (other != face && (star.faces[other].edges[0] == spoke || star.faces[other].edges[1] == spoke))
        {
          face = other;
          break;
        }
      }
    } while (spoke != spokes.front() && spokes.size() <= boundaryFaces.size());
    manifold = sectors.size() == boundaryFaces.size();
  }

  if (!manifold)
  {
    // Surfaces touch at a point or along an edge: nothing is smooth here.
    star.rule = ControlPointRule::Corner;
    for (std::size_t e = 0; e < star.edges.size(); ++e)
    {
      if (star.edges[e].boundary)
      {
        star.edgePoints[e] = insertMask(star.center, star.edges[e].point, star.near[e]);
        star.edgeRules[e] = ControlPointRule::Corner;
      }
    }
    for (const int f : boundaryFaces)
    {
      const auto& ends = star.faces[f].edges;
      const Vec3 corners[4] = { star.center, star.edges[ends[0]].point, star.edges[ends[1]].point, star.faces[f].point };
      const double weights[2] = { star.near[ends[0]], star.near[ends[1]] };
      star.facePoints[f] = multilinear(corners, weights, 2);
      star.faceRules[f] = ControlPointRule::Corner;
    }
    return;
  }

  const int n = static_cast<int>(spokes.size());
  Fan fan;
  fan.center = star.point;
  std::vector<double> weights;
  std::vector<int> features;
  std::vector<bool> kept, planar;
  std::vector<SpokeKeep> keeps;
  bool body = true;
  for (int i = 0; i < n; ++i)
  {
    fan.spokes.push_back(star.edges[spokes[i]].point);
    fan.sectors.push_back(star.faces[sectors[i]].point);
    weights.push_back(star.near[spokes[i]]);
    const VertexStar::Edge& edge = star.edges[spokes[i]];
    const EdgeRule& edgeRule = this->Rules.edges[edge.edge];
    if (edgeRule.feature)
    {
      features.push_back(i);
    }
    kept.push_back(edgeRule.anchored);
    planar.push_back(this->Rules.faces[star.faces[sectors[i]].face].planar());
    // A face that rises from a crease and ends in this surface.
    keeps.emplace_back();
    const EdgeFan& edgeFan = edgeRule.fans.front();
    if (edgeRule.fans.size() == 1 && edgeFan.sectors.size() == 2)
    {
      const int cells = this->Complex.edges[edge.edge].cells;
      keeps.back().center = this->spokeKeeps(edgeFan, edge.end == 0 ? 0 : cells)[1].center;
      keeps.back().step = this->spokeKeeps(edgeFan, edge.end == 0 ? 1 : cells - 1)[1].center;
    }
    body = body && this->isWall(star.faces[sectors[i]].face);
  }

  Fan result = fan;
  if (planar == std::vector<bool>(n, true))
  {
    star.rule = ControlPointRule::PlanarSide;
    result = creasedFan(fan, {}, kept, planar, this->Options.twist, weights, keeps).points;
  }
  else if (features.size() < 2 && n >= 3)
  {
    // No feature, or one that ends here (a dart): smooth.
    star.surfaceIsSmooth = features.empty();
    result = this->smoothSurfaceFan(star, fan, weights, keeps, body);
    star.rule = n == 4 ? this->Rules.boundaryRule(star.faces[sectors[0]].face)
      : body           ? ControlPointRule::BodyExtraordinaryVertex
                       : ControlPointRule::Boundary;
  }
  else
  {
    const CreasedFan creased = creasedFan(fan, features, kept, planar, this->Options.twist, weights, keeps);
    result = creased.points;
    star.rule = creased.crease ? ControlPointRule::Crease : ControlPointRule::Corner;
    if (creased.crease)
    {
      star.crease = { spokes[features[0]], spokes[features[1]] };
    }
  }
  const bool crease = star.rule == ControlPointRule::Crease;
  const auto isFeature = [&](int i) { return std::find(features.begin(), features.end(), i) != features.end(); };
  std::vector<ControlPointRule> spokeRules(n, star.rule), sectorRules(n, star.rule);
  for (int i = 0; i < n; ++i)
  {
    if (planar[i])
    {
      sectorRules[i] = ControlPointRule::PlanarSide;
    }
    else if (crease)
    {
      sectorRules[i] = this->Rules.boundaryRule(star.faces[sectors[i]].face);
    }
    if (!isFeature(i) && crease)
    {
      spokeRules[i] = sectorRules[i];
    }
    if (keeps[i].any() && features.empty())
    {
      spokeRules[i] = star.rule = ControlPointRule::Crease;
    }
  }

  star.center = result.center;
  for (int i = 0; i < n; ++i)
  {
    star.edgePoints[spokes[i]] = result.spokes[i];
    star.edgeRules[spokes[i]] = spokeRules[i];
    star.facePoints[sectors[i]] = result.sectors[i];
    star.faceRules[sectors[i]] = sectorRules[i];
  }
}

bool Converter::convertRegular(Star& star) const
{
  const int edges = static_cast<int>(star.edges.size());
  if (edges != 6 || star.blocks.size() != 8 || star.faces.size() != 12 || star.keepsPoints())
  {
    return false;
  }
  // The axis of each star edge: opposite edges span no face.
  std::vector<int> opposite(6, -1);
  for (int e = 0; e < 6; ++e)
  {
    if (!this->Rules.edges[star.edges[e].edge].regular())
    {
      return false;
    }
    for (int other = 0; other < 6; ++other)
    {
      if (other != e && star.faceBetween(e, other) < 0)
      {
        if (opposite[e] >= 0)
        {
          return false;
        }
        opposite[e] = other;
      }
    }
    if (opposite[e] < 0)
    {
      return false;
    }
  }
  // Tensor product per axis: [1 4 1]/6 through the vertex, or [2 1]/3 towards star edge `e` of `inserted`.
  OrderFreeSum sum;
  const auto tensor = [&](const std::vector<int>& inserted) {
    const auto contains = [](const std::vector<int>& list, int e) {
      return std::find(list.begin(), list.end(), e) != list.end();
    };
    const auto weightOf = [&](const std::vector<int>& members) {
      double weight = 1.0;
      for (int e = 0; e < 6; ++e)
      {
        if (e > opposite[e])
        {
          continue;
        }
        const int o = opposite[e];
        const bool insertsHere = contains(inserted, e) || contains(inserted, o);
        const int near = contains(members, e) ? e : contains(members, o) ? o : -1;
        if (near < 0)
        {
          weight *= insertsHere ? 2.0 : 4.0;
        }
        else if (insertsHere && !contains(inserted, near))
        {
          weight = 0.0;
        }
      }
      return weight;
    };
    sum.clear();
    sum.add(weightOf({}), star.point);
    for (int e = 0; e < 6; ++e)
    {
      sum.add(weightOf({ e }), star.edges[e].point);
    }
    for (const VertexStar::Face& face : star.faces)
    {
      sum.add(weightOf({ face.edges[0], face.edges[1] }), face.point);
    }
    for (const VertexStar::Block& block : star.blocks)
    {
      sum.add(weightOf({ block.edges[0], block.edges[1], block.edges[2] }), block.point);
    }
    double denominator = 1.0;
    for (std::size_t d = 0; d < 3; ++d)
    {
      denominator *= d < inserted.size() ? 3.0 : 6.0;
    }
    return sum.result(denominator);
  };
  star.rule = ControlPointRule::Regular;
  star.center = tensor({});
  for (int e = 0; e < 6; ++e)
  {
    star.edgePoints[e] = tensor({ e });
    star.edgeRules[e] = star.rule;
  }
  for (std::size_t f = 0; f < star.faces.size(); ++f)
  {
    star.facePoints[f] = tensor({ star.faces[f].edges[0], star.faces[f].edges[1] });
    star.faceRules[f] = star.rule;
  }
  for (std::size_t b = 0; b < star.blocks.size(); ++b)
  {
    const auto& e = star.blocks[b].edges;
    star.blockPoints[b] = tensor({ e[0], e[1], e[2] });
    star.blockRules[b] = star.rule;
  }
  return true;
}

bool Converter::areStacked(const Star& star, int up, int down) const
{
  const EdgeRule& upRule = this->Rules.edges[star.edges[up].edge];
  const EdgeRule& downRule = this->Rules.edges[star.edges[down].edge];
  const Star::EdgeInfo& a = star.info[up];
  const Star::EdgeInfo& b = star.info[down];
  if (star.faceBetween(up, down) >= 0 || !a.whole || !b.whole || a.spokes.size() != b.spokes.size() ||
    a.sectors.size() + b.sectors.size() != star.blocks.size() || a.fan->closed != b.fan->closed ||
    upRule.anchored != downRule.anchored || upRule.rule != downRule.rule)
  {
    return false;
  }
  for (const int spoke : a.spokes)
  {
    if (std::find(b.spokes.begin(), b.spokes.end(), spoke) == b.spokes.end())
    {
      return false;
    }
  }
  for (std::size_t i = 0; i < a.sectors.size(); ++i)
  {
    // The face between the stacks: the mask across the layers must not be one that keeps points.
    const int ring = star.blocks[a.sectors[i]].faces[a.fan->sectors[i].along];
    const auto& pair = star.faces[ring].blocks;
    const int across = pair[0] == a.sectors[i] ? pair[1] : pair[0];
    if (star.keptFaces[ring] || std::find(b.sectors.begin(), b.sectors.end(), across) == b.sectors.end())
    {
      return false;
    }
  }
  // On the boundary the outer surface must agree: it is smooth, or its crease is the axis.
  const bool isCrease =
    (star.crease[0] == up && star.crease[1] == down) || (star.crease[0] == down && star.crease[1] == up);
  return !star.boundary || (upRule.feature ? isCrease : star.surfaceIsSmooth);
}

bool Converter::convertStacked(Star& star) const
{
  const int edges = static_cast<int>(star.edges.size());
  const int blocks = static_cast<int>(star.blocks.size());
  const auto edgeRule = [&](int e) -> const EdgeRule& { return this->Rules.edges[star.edges[e].edge]; };

  // At the boundary: one stack around an interior edge that all blocks share.
  int up = -1, down = -1;
  for (int e = 0; e < edges && up < 0; ++e)
  {
    const Star::EdgeInfo& info = star.info[e];
    if (star.boundary && !star.edges[e].boundary && info.whole &&
      static_cast<int>(info.sectors.size()) == blocks)
    {
      up = e;
    }
  }
  // Otherwise two stacks of the same blocks around two edges without a common face, of the same kind. Where several
  // axes will do, the one with the smallest point is taken, whatever the numbering.
  const auto before = [&](int a, int b) {
    const Vec3& p = star.edges[a].point;
    const Vec3& q = star.edges[b].point;
    return std::lexicographical_compare(p.data(), p.data() + 3, q.data(), q.data() + 3);
  };
  const bool single = up >= 0;
  for (int e = 0; e < edges && !single; ++e)
  {
    for (int other = 0; other < edges; ++other)
    {
      if (other != e && (up < 0 || before(e, up)) && this->areStacked(star, e, other))
      {
        up = e;
        down = other;
      }
    }
  }
  if (up < 0)
  {
    return false;
  }
  const bool anchored = edgeRule(up).anchored;
  if (!star.boundary && anchored)
  {
    return false;
  }

  // A stack is the layer one step along its axis, with the star faces through its spokes and the star blocks of its
  // sectors, all in the order of the fan around `up`.
  struct Stack
  {
    int axis;
    Fan layer;
    std::vector<int> faces;
    std::vector<int> blocks;
  };
  const auto makeStack = [&](int axis) {
    const Star::EdgeInfo& info = star.info[axis];
    Stack stack{ axis, this->starLayer(star, axis, 1), {}, info.sectors };
    for (int i = 0; i < info.fan->spokeCount(); ++i)
    {
      const auto [sector, which] = info.fan->spoke(i);
      const int block = info.sectors[sector - info.fan->sectors.data()];
      stack.faces.push_back(star.blocks[block].faces[faceDirection(sector->spokeFace(which))]);
    }
    return stack;
  };
  const Star::EdgeInfo& info = star.info[up];
  const int spokes = static_cast<int>(info.spokes.size());
  const int sectors = static_cast<int>(info.sectors.size());
  std::vector<int> ring; // star faces between the stacks, or on the boundary below the only one
  for (int i = 0; i < sectors; ++i)
  {
    ring.push_back(star.blocks[info.sectors[i]].faces[info.fan->sectors[i].along]);
  }
  Fan middle = this->starLayer(star, up, 0);
  std::vector<Stack> stacks{ makeStack(up) };
  if (down >= 0)
  {
    const Stack values = makeStack(down);
    Stack ordered = values;
    for (int i = 0; i < spokes; ++i)
    {
      const auto& list = star.info[down].spokes;
      const std::size_t from = std::find(list.begin(), list.end(), info.spokes[i]) - list.begin();
      ordered.layer.spokes[i] = values.layer.spokes[from];
      ordered.faces[i] = values.faces[from];
    }
    for (int i = 0; i < sectors; ++i)
    {
      // The block on the other side of the face between the stacks.
      const auto& pair = star.faces[ring[i]].blocks;
      const int block = pair[0] == stacks[0].blocks[i] ? pair[1] : pair[0];
      const std::size_t from = std::find(values.blocks.begin(), values.blocks.end(), block) - values.blocks.begin();
      ordered.layer.sectors[i] = values.layer.sectors[from];
      ordered.blocks[i] = block;
    }
    stacks.push_back(ordered);
  }
  else
  {
    // The converted outer surface is layer 0.
    middle.center = star.center;
    for (int i = 0; i < spokes; ++i)
    {
      middle.spokes[i] = star.edgePoints[info.spokes[i]];
    }
    for (int i = 0; i < sectors; ++i)
    {
      middle.sectors[i] = star.facePoints[ring[i]];
    }
  }

  // The outer surface keeps what it has: only what lies inside is set.
  const ControlPointRule inner =
    edgeRule(up).rule == ControlPointRule::Crease ? ControlPointRule::Boundary : edgeRule(up).rule;
  const auto setEdge = [&](int e, const Vec3& value, ControlPointRule rule) {
    if (!star.edges[e].boundary)
    {
      star.edgePoints[e] = value;
      star.edgeRules[e] = rule;
    }
  };
  const auto setFace = [&](int f, const Vec3& value, ControlPointRule rule) {
    if (!star.faces[f].boundary)
    {
      star.facePoints[f] = value;
      star.faceRules[f] = rule;
    }
  };
  for (const Stack& stack : stacks)
  {
    const double near = star.near[stack.axis];
    const ControlPointRule rule =
      near != KnotInsertion && inner != ControlPointRule::ExtraordinaryEdge ? ControlPointRule::WallLayer : inner;
    setEdge(stack.axis, insertMask(middle.center, stack.layer.center, near), rule);
    for (int i = 0; i < spokes; ++i)
    {
      setFace(stack.faces[i], insertMask(middle.spokes[i], stack.layer.spokes[i], near), rule);
    }
    for (int i = 0; i < sectors; ++i)
    {
      star.blockPoints[stack.blocks[i]] = insertMask(middle.sectors[i], stack.layer.sectors[i], near);
      star.blockRules[stack.blocks[i]] = rule;
    }
  }
  if (down >= 0)
  {
    const Fan& above = stacks[0].layer;
    const Fan& below = stacks[1].layer;
    if (!star.boundary)
    {
      star.rule = inner;
      star.center = smoothMask(above.center, middle.center, below.center);
    }
    for (int i = 0; i < spokes; ++i)
    {
      setEdge(info.spokes[i], smoothMask(above.spokes[i], middle.spokes[i], below.spokes[i]), inner);
    }
    for (int i = 0; i < sectors; ++i)
    {
      setFace(ring[i], smoothMask(above.sectors[i], middle.sectors[i], below.sectors[i]), inner);
    }
  }
  return true;
}

void Converter::convertAnchored(Star& star) const
{
  const ControlPointRule inner = star.boundary ? ControlPointRule::Boundary : star.rule;
  // Values one step away from the vertex, along edges and in faces.
  std::vector<Vec3> along(star.edges.size()), diagonal(star.faces.size());
  for (std::size_t e = 0; e < star.edges.size(); ++e)
  {
    along[e] = this->starLayer(star, static_cast<int>(e), 1).center;
    if (!star.edges[e].boundary)
    {
      star.edgePoints[e] = insertMask(star.center, along[e], star.near[e]);
      star.edgeRules[e] = inner;
    }
  }
  for (std::size_t f = 0; f < star.faces.size(); ++f)
  {
    const VertexStar::Face& face = star.faces[f];
    diagonal[f] = face.boundary || this->Rules.faces[face.face].planar()
      ? face.point
      : fadedMask(star.blocks[face.blocks[0]].point, face.point, star.blocks[face.blocks[1]].point, star.diagonalKeep[f]);
    if (!face.boundary)
    {
      const Vec3 corners[4] = { star.center, along[face.edges[0]], along[face.edges[1]], diagonal[f] };
      const double weights[2] = { star.near[face.edges[0]], star.near[face.edges[1]] };
      star.facePoints[f] = multilinear(corners, weights, 2);
      star.faceRules[f] = inner;
    }
  }
  for (std::size_t b = 0; b < star.blocks.size(); ++b)
  {
    const VertexStar::Block& block = star.blocks[b];
    Vec3 corners[8] = { star.point, star.edges[block.edges[0]].point, star.edges[block.edges[1]].point,
      star.faces[block.faces[2]].point, star.edges[block.edges[2]].point, star.faces[block.faces[1]].point,
      star.faces[block.faces[0]].point, block.point };
    if (star.rule == ControlPointRule::SingularNode)
    {
      // The centre has moved: interpolate between what lies around it.
      const Vec3 moved[7] = { star.center, along[block.edges[0]], along[block.edges[1]], diagonal[block.faces[2]],
        along[block.edges[2]], diagonal[block.faces[1]], diagonal[block.faces[0]] };
      std::copy_n(moved, 7, corners);
    }
    const double weights[3] = { star.near[block.edges[0]], star.near[block.edges[1]], star.near[block.edges[2]] };
    star.blockPoints[b] = multilinear(corners, weights, 3);
    star.blockRules[b] = inner;
  }
}

void Converter::convertVertex(int vertex)
{
  Star star = this->makeStar(vertex);
  if (star.boundary)
  {
    this->convertSurface(star);
    if (!this->convertStacked(star))
    {
      this->convertAnchored(star);
    }
  }
  else if (!this->convertRegular(star) && !this->convertStacked(star))
  {
    bool keeps = false;
    for (const VertexStar::Edge& edge : star.edges)
    {
      keeps = keeps || this->Rules.edges[edge.edge].anchored;
    }
    if (keeps)
    {
      star.rule = ControlPointRule::PlanarSide;
    }
    else
    {
      star.rule = ControlPointRule::SingularNode;
      star.center = solidLimitPoint(star);
      ++this->SingularNodes;
    }
    this->convertAnchored(star);
  }

  for (std::size_t f = 0; f < star.faces.size(); ++f)
  {
    if (star.keptFaces[f])
    {
      star.faceRules[f] = ControlPointRule::Crease;
      for (const int edge : star.faces[f].edges)
      {
        star.edgeRules[edge] = star.edges[edge].boundary ? star.edgeRules[edge] : ControlPointRule::Crease;
      }
      star.rule = star.boundary ? star.rule : ControlPointRule::Crease;
    }
  }

  for (std::size_t b = 0; b < star.blocks.size(); ++b)
  {
    const VertexStar::Block& entry = star.blocks[b];
    const ComplexBlock& owner = this->Complex.blocks[entry.block];
    for (int inserted = 0; inserted < 8; ++inserted)
    {
      // Bit d of `inserted`: one step in along direction d.
      Ijk position;
      for (int d = 0; d < 3; ++d)
      {
        position[d] = endPosition(cornerSide(entry.corner, d), inserted >> d & 1, owner.cells(d));
      }
      Vec3 point = star.center;
      ControlPointRule rule = star.rule;
      switch (inserted)
      {
        case 0:
          break;
        case 7:
          point = star.blockPoints[b];
          rule = star.blockRules[b];
          break;
        case 1:
        case 2:
        case 4:
        {
          const int edge = entry.edges[inserted / 2];
          point = star.edgePoints[edge];
          rule = star.edgeRules[edge];
          break;
        }
        default:
        {
          const int face = entry.faces[inserted == 6 ? 0 : inserted == 5 ? 1 : 2];
          point = star.facePoints[face];
          rule = star.faceRules[face];
        }
      }
      this->write(entry.block, position, point, rule);
    }
  }
}

//----------------------------------------------------------------------------------------------------------------------

ConversionReport Converter::convert()
{
  // Slabs of all blocks as one list, so that a few large blocks share the threads as well as many small ones.
  std::vector<Index> firstSlab{ 0 };
  for (const ComplexBlock& block : this->Complex.blocks)
  {
    firstSlab.push_back(firstSlab.back() + std::max(0, block.cells(2) - 1));
  }
  const auto forEach = [&](std::size_t count, Index grain, const auto& body) {
    this->Run.parallelFor(static_cast<Index>(count), grain, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i)
      {
        body(static_cast<int>(i));
      }
    });
  };
  // Large meshes are copied in portions, so that progress is told and an abort is heard.
  constexpr Index Portions = 20;
  const Index slabs = firstSlab.back();
  for (Index portion = 0; portion < Portions; ++portion)
  {
    const Index from = slabs * portion / Portions;
    const Index to = slabs * (portion + 1) / Portions;
    this->Run.report(0.5 * portion / Portions);
    this->Run.parallelFor(to - from, 4, [&](Index begin, Index end) {
      for (Index slab = from + begin; slab < from + end; ++slab)
      {
        const auto next = std::upper_bound(firstSlab.begin(), firstSlab.end(), slab);
        const int block = static_cast<int>(next - firstSlab.begin()) - 1;
        this->convertBlock(block, static_cast<int>(slab - firstSlab[block]) + 1);
      }
    });
  }
  this->Run.report(0.5);
  forEach(this->Complex.faces.size(), 4, [&](int face) { this->convertFace(face); });
  this->Run.report(0.7);
  forEach(this->Complex.edges.size(), 4, [&](int edge) { this->convertEdge(edge); });
  this->Run.report(0.85);
  forEach(this->Complex.vertices.size(), 4, [&](int vertex) { this->convertVertex(vertex); });
  this->Run.report(0.95);

  ConversionReport report;
  report.singularNodes = this->SingularNodes;
  report.planarFaces = this->Rules.planarFaces;
  for (std::size_t b = 0; b < this->Complex.blocks.size(); ++b)
  {
    const ComplexBlock& block = this->Complex.blocks[b];
    const Index count = Index(block.cells(0) + 3) * (block.cells(1) + 3) * (block.cells(2) + 3);
    for (Index i = 0; i < count; ++i)
    {
      ++report.controlPoints[this->Nets[b].rules[i]];
    }
  }
  this->Run.report(1.0);
  return report;
}

} // namespace

const std::vector<std::string>& controlPointRuleNames()
{
  static const std::vector<std::string> names{ "Copied", "Regular", "Boundary", "Symmetry", "PlanarSide", "Body",
    "BodyExtraordinaryVertex", "Crease", "Corner", "ExtraordinaryEdge", "SingularNode", "WallLayer" };
  return names;
}

ConversionReport convertToBSplineVolume(const BlockComplex& complex, const ConversionOptions& options,
  const std::vector<ControlNetStorage>& nets, const Execution& run)
{
  if (!(options.wallSpacing > 0.0 && options.wallSpacing < 1.0))
  {
    throw Error("wall spacing c must lie between 0 and 1, both excluded; it is " + std::to_string(options.wallSpacing));
  }
  if (!(options.planarTolerance >= 0.0))
  {
    throw Error("planar tolerance must not be negative; it is " + std::to_string(options.planarTolerance));
  }
  if (!(options.propagationRange >= 0.0))
  {
    throw Error("propagation range must not be negative; it is " + std::to_string(options.propagationRange));
  }
  if (nets.size() != complex.blocks.size())
  {
    throw Error("there are " + std::to_string(nets.size()) + " control nets for " +
      std::to_string(complex.blocks.size()) + " blocks");
  }
  return Converter(complex, options, nets, run).convert();
}

} // namespace bsv
