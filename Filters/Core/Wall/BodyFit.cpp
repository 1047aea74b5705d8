// SPDX-License-Identifier: BSD-3-Clause
#include "Wall/BodyFit.h"

#include "Base/OrderFreeSum.h"
#include "Base/SparseArray.h"
#include "Complex/EdgeFans.h"
#include "Conversion/EntityRules.h"
#include "Conversion/LayerRules.h"
#include "Mesh/BlockSurface.h"
#include "Ranks/OwnedValues.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <sstream>

namespace bsv
{
namespace
{

/// A block and a mesh point of it.
struct PointAt
{
  int block;
  Ijk ijk;
};

/// What ranks send of a point or vector.
using Triple = std::array<double, 3>;

Triple triple(const Vec3& x)
{
  return { x[0], x[1], x[2] };
}
Vec3 vec3(const Triple& x)
{
  return Vec3(x[0], x[1], x[2]);
}

/// Mesh points of the wall, numbered once each: the same on all ranks.
class Wall
{
public:
  Wall(const BlockComplex& complex, const EntityRules& rules)
    : Complex(complex)
    , Rules(rules)
    , FaceOffset(complex.faces.size(), -1)
    , EdgeOffset(complex.edges.size(), -1)
    , VertexId(complex.vertices.size(), -1)
  {
    for (int f = 0; f < static_cast<int>(complex.faces.size()); ++f)
    {
      if (this->isWall(f))
      {
        this->Faces.push_back(f);
        this->numberFace(f);
      }
    }
  }

  bool isWall(int face) const
  {
    return this->Complex.faces[face].boundary() && this->Rules.faces[face].role == BoundaryRole::Body;
  }
  const std::vector<int>& faces() const { return this->Faces; }
  Index size() const { return static_cast<Index>(this->Places.size()); }
  /// All points, each from the rank that has it.
  std::vector<Vec3> points(const Ranks& ranks) const
  {
    const std::vector<ComplexBlock>& blocks = this->Complex.blocks;
    const std::vector<Triple> all = gatherFromOwners<Triple>(
      ranks, this->Places.size(), [&](std::size_t i) { return blocks[this->Places[i].block].rank; },
      [&](std::size_t i) { return triple(blocks[this->Places[i].block].points(this->Places[i].ijk)); });
    std::vector<Vec3> points(all.size());
    std::transform(all.begin(), all.end(), points.begin(), vec3);
    return points;
  }

  /// Number of mesh point (s, t) of a block's wall face.
  Index id(int block, int face, int s, int t) const
  {
    const ComplexBlock& owner = this->Complex.blocks[block];
    const int ns = owner.cells(faceAxis(face, 0));
    const int nt = owner.cells(faceAxis(face, 1));
    const bool endS = s == 0 || s == ns;
    const bool endT = t == 0 || t == nt;
    if (endS && endT)
    {
      return this->VertexId[owner.vertices[faceCorner(face, s == 0 ? 0 : 1, t == 0 ? 0 : 1)]];
    }
    if (endS || endT)
    {
      const int edge = faceEdge(face, endS ? 1 : 0, endS ? (s == 0 ? 0 : 1) : (t == 0 ? 0 : 1));
      const int along = endS ? t : s;
      return this->edgeId(owner.edges[edge], owner.edgeReversed[edge] ? (endS ? nt : ns) - along : along);
    }
    return this->FaceOffset[owner.faces[face]] + (s - 1) + Index(ns - 1) * (t - 1);
  }
  Index id(int block, int face, const Ijk& ijk) const
  {
    return this->id(block, face, ijk[faceAxis(face, 0)], ijk[faceAxis(face, 1)]);
  }
  /// Number of point k of a wall edge.
  Index edgeId(int edge, int k) const
  {
    const ComplexEdge& shared = this->Complex.edges[edge];
    return k == 0         ? this->VertexId[shared.vertices[0]]
      : k == shared.cells ? this->VertexId[shared.vertices[1]]
                          : this->EdgeOffset[edge] + k - 1;
  }
  Index vertexId(int vertex) const { return this->VertexId[vertex]; }
  bool hasEdge(int edge) const
  {
    return this->VertexId[this->Complex.edges[edge].vertices[0]] >= 0 && this->HasEdge.count(edge) > 0;
  }
  const std::set<int>& edges() const { return this->HasEdge; }

private:
  void numberFace(int f)
  {
    const FaceUse& use = this->Complex.faces[f].uses.front();
    const ComplexBlock& owner = this->Complex.blocks[use.block];
    const Ijk cells{ owner.cells(0), owner.cells(1), owner.cells(2) };
    const int ns = cells[faceAxis(use.face, 0)];
    const int nt = cells[faceAxis(use.face, 1)];
    for (int corner = 0; corner < 4; ++corner)
    {
      Index& id = this->VertexId[owner.vertices[faceCorner(use.face, corner & 1, corner >> 1)]];
      if (id < 0)
      {
        id = this->size();
        this->Places.push_back({ use.block, facePoint(cells, use.face, (corner & 1) * ns, (corner >> 1) * nt) });
      }
    }
    for (int axis = 0; axis < 2; ++axis)
    {
      for (int side = 0; side < 2; ++side)
      {
        const int edge = faceEdge(use.face, axis, side);
        const int global = owner.edges[edge];
        if (!this->HasEdge.insert(global).second)
        {
          continue;
        }
        this->EdgeOffset[global] = this->size();
        const int n = axis == 0 ? ns : nt;
        for (int k = 1; k < n; ++k)
        {
          const int along = owner.edgeReversed[edge] ? n - k : k;
          const int across = side * (axis == 0 ? nt : ns);
          this->Places.push_back(
            { use.block, facePoint(cells, use.face, axis == 0 ? along : across, axis == 0 ? across : along) });
        }
      }
    }
    this->FaceOffset[f] = this->size();
    for (int t = 1; t < nt; ++t)
    {
      for (int s = 1; s < ns; ++s)
      {
        this->Places.push_back({ use.block, facePoint(cells, use.face, s, t) });
      }
    }
  }

  const BlockComplex& Complex;
  const EntityRules& Rules;
  std::vector<int> Faces;
  std::vector<Index> FaceOffset, EdgeOffset, VertexId;
  std::set<int> HasEdge;
  std::vector<PointAt> Places;
};

/// The limit masks of all wall points as rows over the wall points: where the converted wall passes at its mesh points,
/// but for what the rules at extraordinary vertices change at the points around them (ExtraordinaryFans).
class LimitRows
{
public:
  LimitRows(const BlockComplex& complex, const EntityRules& rules, const Wall& wall)
    : Rows(wall.size())
  {
    for (const int f : wall.faces())
    {
      this->addFace(complex, wall, f);
    }
    for (const int e : wall.edges())
    {
      this->addEdge(complex, rules, wall, e);
    }
    for (int v = 0; v < static_cast<int>(complex.vertices.size()); ++v)
    {
      if (wall.vertexId(v) >= 0)
      {
        this->addVertex(complex, rules, wall, v);
      }
    }
  }

  /// Whether the point lies on a crease, a border of the wall or at a corner.
  bool onFeature(Index id) const { return this->Rows[id].kind != Kind::Tensor && this->Rows[id].kind != Kind::Ring; }

  /// The points around an extraordinary vertex, inside the wall: next ones, then diagonals. Empty at all other points.
  const std::vector<Index>& ring(Index id) const
  {
    static const std::vector<Index> none;
    const Row& row = this->Rows[id];
    return row.kind == Kind::Ring && row.next != 4 ? row.points : none;
  }
  /// Whether the wall is regular there.
  bool isTensor(Index id) const { return this->Rows[id].kind == Kind::Tensor; }

  Vec3 apply(Index id, const std::vector<Vec3>& x) const
  {
    const Row& row = this->Rows[id];
    const auto at = [&](std::size_t i) -> const Vec3& { return x[row.points[i]]; };
    switch (row.kind)
    {
      case Kind::Kept:
        return x[id];
      case Kind::Curve:
        return ((at(0) + at(1)) + 4.0 * x[id]) / 6.0;
      case Kind::Tensor:
        // Opposite points are added first: turning or reflecting the rectangle changes no bit.
        return (16.0 * x[id] + (4.0 * ((at(0) + at(1)) + (at(2) + at(3))) + ((at(4) + at(5)) + (at(6) + at(7))))) /
          36.0;
      default: {
        const double n = 0.5 * static_cast<double>(row.points.size());
        OrderFreeSum sum;
        sum.add(n * n, x[id]);
        for (std::size_t i = 0; i < row.points.size(); ++i)
        {
          sum.add(2 * i < row.points.size() ? 4.0 : 1.0, at(i));
        }
        return sum.result(n * (n + 5.0));
      }
    }
  }

  /// Mean distance to the next points, the local edge length.
  double spacing(Index id, const std::vector<Vec3>& x) const
  {
    const Row& row = this->Rows[id];
    std::vector<double> lengths;
    for (std::size_t i = 0; i < row.next; ++i)
    {
      lengths.push_back((x[row.points[i]] - x[id]).norm());
    }
    std::sort(lengths.begin(), lengths.end());
    double sum = 0.0;
    for (const double length : lengths)
    {
      sum += length;
    }
    return sum / static_cast<double>(row.next);
  }

private:
  enum class Kind : std::uint8_t
  {
    Kept,   ///< corner; the points are its neighbours
    Curve,  ///< two neighbours along the crease
    Tensor, ///< two opposite neighbours, the two others, then two pairs of opposite diagonals
    Ring    ///< n neighbours, then n diagonals
  };
  struct Row
  {
    Kind kind = Kind::Kept;
    /// How many of the points are next to the own one.
    std::size_t next = 0;
    std::vector<Index> points;
  };

  void addFace(const BlockComplex& complex, const Wall& wall, int f)
  {
    const FaceUse& use = complex.faces[f].uses.front();
    const ComplexBlock& owner = complex.blocks[use.block];
    const auto id = [&](int s, int t) { return wall.id(use.block, use.face, s, t); };
    for (int t = 1; t < owner.cells(faceAxis(use.face, 1)); ++t)
    {
      for (int s = 1; s < owner.cells(faceAxis(use.face, 0)); ++s)
      {
        this->Rows[id(s, t)] = { Kind::Tensor, 4,
          { id(s - 1, t), id(s + 1, t), id(s, t - 1), id(s, t + 1), id(s - 1, t - 1), id(s + 1, t + 1),
            id(s - 1, t + 1), id(s + 1, t - 1) } };
      }
    }
  }

  void addEdge(const BlockComplex& complex, const EntityRules& rules, const Wall& wall, int e)
  {
    const ComplexEdge& edge = complex.edges[e];
    const EdgeRule& rule = rules.edges[e];
    for (int k = 1; k < edge.cells; ++k)
    {
      Row& row = this->Rows[wall.edgeId(e, k)];
      const Index before = wall.edgeId(e, k - 1), after = wall.edgeId(e, k + 1);
      if (rule.feature)
      {
        row = { Kind::Curve, 2, { before, after } };
        continue;
      }
      // Smooth: the wall goes on at both ends of the fan of blocks.
      const EdgeFan& fan = rule.fans.front();
      const auto beside = [&](int spoke, int layer) {
        const auto [sector, which] = fan.spoke(spoke);
        const ComplexBlock& owner = complex.blocks[sector->block];
        const Ijk ijk = sector->point(owner, layer, which == 0 ? 1 : 0, which == 0 ? 0 : 1);
        return wall.id(sector->block, sector->spokeFace(which), ijk);
      };
      const int last = fan.spokeCount() - 1;
      row = { Kind::Tensor, 4,
        { before, after, beside(0, k), beside(last, k), beside(0, k - 1), beside(last, k + 1), beside(0, k + 1),
          beside(last, k - 1) } };
    }
  }

  void addVertex(const BlockComplex& complex, const EntityRules& rules, const Wall& wall, int v)
  {
    Row& row = this->Rows[wall.vertexId(v)];
    const VertexStar star = vertexStar(complex, v);
    const BoundaryRing ring = boundaryRing(star);
    const int n = static_cast<int>(ring.edges.size());
    const auto next = [&](int starEdge) {
      const VertexStar::Edge& edge = star.edges[starEdge];
      return wall.edgeId(edge.edge, edge.end == 0 ? 1 : complex.edges[edge.edge].cells - 1);
    };
    std::vector<int> features;
    bool all = n > 0;
    for (int i = 0; i < n; ++i)
    {
      if (rules.edges[star.edges[ring.edges[i]].edge].feature)
      {
        features.push_back(i);
      }
      all = all && wall.isWall(star.faces[ring.faces[i]].face);
    }
    const int gap = features.size() == 2 ? features[1] - features[0] : 0;
    if (all && features.size() < 2 && n >= 3)
    {
      row.kind = Kind::Ring;
      row.next = n;
      for (const int edge : ring.edges)
      {
        row.points.push_back(next(edge));
      }
      for (const int f : ring.faces)
      {
        const FaceUse& use = complex.faces[star.faces[f].face].uses.front();
        const ComplexBlock& owner = complex.blocks[use.block];
        const int corner = star.faces[f].corner;
        row.points.push_back(wall.id(use.block, use.face, corner & 1 ? owner.cells(faceAxis(use.face, 0)) - 1 : 1,
          corner >> 1 ? owner.cells(faceAxis(use.face, 1)) - 1 : 1));
      }
      return;
    }
    const bool onWall = features.size() == 2 && wall.hasEdge(star.edges[ring.edges[features[0]]].edge) &&
      wall.hasEdge(star.edges[ring.edges[features[1]]].edge);
    if (onWall && gap > 1 && gap < n - 1)
    {
      row = { Kind::Curve, 2, { next(ring.edges[features[0]]), next(ring.edges[features[1]]) } };
      return;
    }
    row.kind = Kind::Kept;
    for (std::size_t e = 0; e < star.edges.size(); ++e)
    {
      if (star.edges[e].boundary && wall.hasEdge(star.edges[e].edge))
      {
        row.points.push_back(next(static_cast<int>(e)));
      }
    }
    row.next = row.points.size();
  }

  std::vector<Row> Rows;
};

/// What the rules at extraordinary vertices change in where the wall passes at the mesh points around them.
///
/// At knot 1 of a clamped direction the values have the weights 1/4, 7/12, 1/6 of the inserted point and of the next
/// two. With the inserted points of the regular rule that is the limit mask; with those of the fan,
/// - at the next point e_i along an edge, whose mask has the part ((e_(i-1) + 4 p + e_(i+1)) / 6) / 6 at the vertex p:
///   one quarter of the inserted point, less one twelfth of (f_(i-1) + 4 e_i + f_i) / 6, in place of that part;
/// - at the diagonal point: 1/16 of what the inserted point of the sector is off the regular one.
class ExtraordinaryFans
{
public:
  ExtraordinaryFans(const LimitRows& rows, Index points, Twist twist)
    : Rule(twist)
  {
    for (Index id = 0; id < points; ++id)
    {
      const std::vector<Index>& ring = rows.ring(id);
      if (!ring.empty())
      {
        this->Centers.push_back(id);
        this->Rings.push_back(ring);
        this->Feet.emplace_back();
        this->HasFoot.push_back(false);
        for (const Index at : ring)
        {
          if (rows.isTensor(at))
          {
            this->Slots[at]; // creates it
          }
        }
      }
    }
  }

  std::size_t size() const { return this->Centers.size(); }
  Index center(std::size_t fan) const { return this->Centers[fan]; }
  void setFoot(std::size_t fan, const SurfaceGeometry& geometry)
  {
    this->HasFoot[fan] = geometry.normal.norm() > 0.0;
    this->Feet[fan] = { geometry.point, geometry.normal, geometry.curvature, true, Vec3::Zero() };
  }

  /// Adds the changes to `values`, the limit masks' values for the wall points `x`.
  void correct(const std::vector<Vec3>& x, std::vector<Vec3>& values)
  {
    for (std::size_t c = 0; c < this->Centers.size(); ++c)
    {
      const std::vector<Index>& ring = this->Rings[c];
      const int n = static_cast<int>(ring.size() / 2);
      Fan fan;
      fan.center = x[this->Centers[c]];
      for (int i = 0; i < n; ++i)
      {
        fan.spokes.push_back(x[ring[i]]);
        fan.sectors.push_back(x[ring[n + i]]);
      }
      const Fan points = this->HasFoot[c] ? projectedFan(fan, this->Feet[c], this->Rule)
                                          : smoothFan(fan, this->Rule, std::vector<double>(n, 2.0 / 3.0));
      for (int i = 0; i < n; ++i)
      {
        const int before = (i + n - 1) % n, after = (i + 1) % n;
        this->add(ring[i],
          0.25 * points.spokes[i] - smoothMask(fan.sectors[before], fan.spokes[i], fan.sectors[i]) / 12.0 -
            smoothMask(fan.spokes[before], fan.center, fan.spokes[after]) / 6.0);
        this->add(ring[n + i],
          (points.sectors[i] - (4.0 * fan.center + 2.0 * (fan.spokes[i] + fan.spokes[after]) + fan.sectors[i]) / 9.0) /
            16.0);
      }
    }
    for (auto& slot : this->Slots)
    {
      values[slot.first] += slot.second.result(1.0);
      slot.second.clear();
    }
  }

private:
  /// A point can lie next to several vertices.
  void add(Index id, const Vec3& change)
  {
    const auto slot = this->Slots.find(id);
    if (slot != this->Slots.end())
    {
      slot->second.add(1.0, change);
    }
  }

  Twist Rule;
  std::vector<Index> Centers;
  std::vector<std::vector<Index>> Rings;
  std::vector<BodyFoot> Feet;
  std::vector<bool> HasFoot;
  std::map<Index, OrderFreeSum> Slots;
};

/// Displacement of one mesh point; the one with the larger weight counts where several reach it.
struct Displacement
{
  double weight = 0.0;
  Vec3 offset = Vec3::Zero();

  bool operator<(const Displacement& other) const
  {
    if (this->weight != other.weight)
    {
      return this->weight < other.weight;
    }
    return std::lexicographical_compare(
      this->offset.data(), this->offset.data() + 3, other.offset.data(), other.offset.data() + 3);
  }
};

/// A mesh point that blocks share: of a face at (s, t) of its first block's face, of an edge s steps from its first
/// vertex, or a vertex.
struct SharedPoint
{
  enum Kind
  {
    Face,
    Edge,
    Vertex
  };
  Kind kind;
  int entity;
  int s, t;
};

/// Displacements of the blocks of this rank.
class Displacements
{
public:
  Displacements(const BlockComplex& complex, const Ranks& ranks)
    : Complex(complex)
    , Group(ranks)
  {
    for (int b = 0; b < static_cast<int>(complex.blocks.size()); ++b)
    {
      const ComplexBlock& block = complex.blocks[b];
      this->Grids.resize(std::max<std::size_t>(this->Grids.size(), block.parent + 1));
      Index& size = this->Grids[block.parent].size;
      size = std::max(size, this->place({ b, { block.cells(0), block.cells(1), block.cells(2) } }) + 1);
    }
    for (Grid& grid : this->Grids)
    {
      grid.offsets = std::make_shared<ChangedPoints>(grid.size);
    }
  }

  bool isHere(int block) const { return this->Complex.blocks[block].rank == this->Group.rank(); }
  /// Makes the displacement of a point at least so large.
  void raise(const PointAt& point, const Displacement& displacement)
  {
    Grid& grid = this->Grids[this->Complex.blocks[point.block].parent];
    const Index slot = grid.offsets->add(this->place(point), [](Index) { return unmoved(); });
    if (slot >= static_cast<Index>(grid.weights.size()))
    {
      grid.weights.resize(grid.offsets->slots(), 0.0);
    }
    if (Displacement{ grid.weights[slot], (*grid.offsets)[slot] } < displacement)
    {
      grid.weights[slot] = displacement.weight;
      (*grid.offsets)[slot] = displacement.offset;
    }
  }

  /// Gives all copies of every shared point, on all ranks, the largest of their displacements.
  void share()
  {
    std::vector<std::vector<Message>> toRank(this->Group.size());
    this->Group.together([&] {
      for (int f = 0; f < static_cast<int>(this->Complex.faces.size()); ++f)
      {
        const ComplexFace& face = this->Complex.faces[f];
        if (!face.boundary() && this->reachesAny(face.uses))
        {
          const FaceUse& use = face.uses.front();
          const ComplexBlock& block = this->Complex.blocks[use.block];
          for (int t = 1; t < block.cells(faceAxis(use.face, 1)); ++t)
          {
            for (int s = 1; s < block.cells(faceAxis(use.face, 0)); ++s)
            {
              this->unite({ SharedPoint::Face, f, s, t }, toRank);
            }
          }
        }
      }
      for (int e = 0; e < static_cast<int>(this->Complex.edges.size()); ++e)
      {
        const ComplexEdge& edge = this->Complex.edges[e];
        for (int k = 1; k < edge.cells && this->reachesAny(edge.uses); ++k)
        {
          this->unite({ SharedPoint::Edge, e, k, 0 }, toRank);
        }
      }
      for (int v = 0; v < static_cast<int>(this->Complex.vertices.size()); ++v)
      {
        if (this->reachesAny(this->Complex.vertices[v].corners))
        {
          this->unite({ SharedPoint::Vertex, v, 0, 0 }, toRank);
        }
      }
    });
    const std::vector<std::vector<Message>> received = this->Group.exchange(toRank);
    this->Group.together([&] {
      for (const std::vector<Message>& messages : received)
      {
        for (const Message& message : messages)
        {
          for (const PointAt& copy : this->copies(message.point))
          {
            if (this->isHere(copy.block))
            {
              this->raise(copy, { message.weight, vec3(message.offset) });
            }
          }
        }
      }
    });
  }

  /// Moves the points. The offsets become the moved points, which takes no more memory.
  void apply(BlockComplex& complex)
  {
    std::map<int, std::vector<ComplexBlock*>> piecesOf;
    for (int b = 0; b < static_cast<int>(complex.blocks.size()); ++b)
    {
      if (this->reaches(b))
      {
        piecesOf[complex.blocks[b].parent].push_back(&complex.blocks[b]);
      }
    }
    for (const auto& [parent, pieces] : piecesOf)
    {
      const Grid& grid = this->Grids[parent];
      ChangedPoints& points = *grid.offsets;
      const GridView before = pieces.front()->points;
      const auto given = [&](Index i) { return before.atOffset(i - before.start()); };
      points.forEach([&](Index i, Index slot) {
        const Vec3 x = given(i);
        points[slot] = isUnmoved(points[slot]) ? x : Vec3(x + points[slot]);
      });
      for (Index i = 0; before.changes() && i < grid.size; ++i)
      {
        if (before.changes()->find(i))
        {
          points.add(i, given);
        }
      }
      for (ComplexBlock* piece : pieces)
      {
        piece->points = piece->points.changed(&points);
      }
      complex.changedPoints.push_back(grid.offsets);
    }
  }

private:
  struct Message
  {
    SharedPoint point;
    double weight;
    Triple offset;
  };

  /// Displacements of a block of the mesh, of which blocks of the complex are pieces, by the points' places in memory.
  struct Grid
  {
    Index size = 0;
    std::shared_ptr<ChangedPoints> offsets;
    /// Per slot of `offsets`; 0 for points that do not move.
    std::vector<double> weights;
  };
  /// Offset of points that share a page with others and do not move: not zero, which would change the sign of zeros.
  static Vec3 unmoved() { return Vec3::Constant(std::numeric_limits<double>::quiet_NaN()); }
  static bool isUnmoved(const Vec3& offset) { return std::isnan(offset[0]); }

  Index place(const PointAt& point) const
  {
    const GridView& points = this->Complex.blocks[point.block].points;
    return points.start() + points.offset(point.ijk);
  }
  bool reaches(int block) const { return !this->Grids[this->Complex.blocks[block].parent].weights.empty(); }
  template <typename Use>
  bool reachesAny(const std::vector<Use>& uses) const
  {
    return std::any_of(uses.begin(), uses.end(), [&](const Use& use) { return this->reaches(use.block); });
  }

  std::vector<PointAt> copies(const SharedPoint& point) const
  {
    std::vector<PointAt> copies;
    switch (point.kind)
    {
      case SharedPoint::Face: {
        const ComplexFace& face = this->Complex.faces[point.entity];
        std::array<int, 2> st{ point.s, point.t }, cells{ 0, 0 };
        for (const FaceUse& use : face.uses)
        {
          const ComplexBlock& block = this->Complex.blocks[use.block];
          if (!copies.empty())
          {
            st = mapFacePoint(face.orientation, point.s, point.t, cells[0], cells[1]);
          }
          cells = { block.cells(faceAxis(use.face, 0)), block.cells(faceAxis(use.face, 1)) };
          copies.push_back(
            { use.block, facePoint({ block.cells(0), block.cells(1), block.cells(2) }, use.face, st[0], st[1]) });
        }
        break;
      }
      case SharedPoint::Edge: {
        const ComplexEdge& edge = this->Complex.edges[point.entity];
        for (const EdgeUse& use : edge.uses)
        {
          const ComplexBlock& block = this->Complex.blocks[use.block];
          const int along = edgeDirection(use.edge);
          Ijk ijk;
          ijk[along] = use.reversed ? edge.cells - point.s : point.s;
          for (int axis = 0; axis < 2; ++axis)
          {
            const int d = faceAxis(2 * along, axis);
            ijk[d] = edgeSide(use.edge, axis) ? block.cells(d) : 0;
          }
          copies.push_back({ use.block, ijk });
        }
        break;
      }
      case SharedPoint::Vertex:
        for (const CornerUse& use : this->Complex.vertices[point.entity].corners)
        {
          const ComplexBlock& block = this->Complex.blocks[use.block];
          Ijk ijk;
          for (int d = 0; d < 3; ++d)
          {
            ijk[d] = cornerSide(use.corner, d) ? block.cells(d) : 0;
          }
          copies.push_back({ use.block, ijk });
        }
        break;
    }
    return copies;
  }

  /// Gives the copies on this rank the largest of their displacements, and tells it to the ranks that have others.
  void unite(const SharedPoint& point, std::vector<std::vector<Message>>& toRank)
  {
    const std::vector<PointAt> copies = this->copies(point);
    Displacement largest;
    for (const PointAt& copy : copies)
    {
      const Grid& grid = this->Grids[this->Complex.blocks[copy.block].parent];
      const Index slot = grid.offsets->slot(this->place(copy));
      if (slot >= 0)
      {
        largest = std::max(largest, { grid.weights[slot], (*grid.offsets)[slot] });
      }
    }
    if (largest.weight == 0.0)
    {
      return;
    }
    std::set<int> told;
    for (const PointAt& copy : copies)
    {
      const int rank = this->Complex.blocks[copy.block].rank;
      if (rank == this->Group.rank())
      {
        this->raise(copy, largest);
      }
      else if (told.insert(rank).second)
      {
        toRank[rank].push_back({ point, largest.weight, triple(largest.offset) });
      }
    }
  }

  const BlockComplex& Complex;
  const Ranks& Group;
  std::vector<Grid> Grids;
};

/// The mesh line of a wall point, where it enters a block.
struct MeshLine
{
  int block, face, s, t;
  /// Blocks that it came through, and its length there.
  int passed;
  double distance;
  /// Displacement of the wall point, and how far it is carried.
  Triple offset;
  double reach;
};

/// Carries the displacement through a block.
/// @return whether it goes on into another one: `line` then enters that.
bool passBlock(const BlockComplex& complex, MeshLine& line, Displacements& displacements)
{
  const ComplexBlock& owner = complex.blocks[line.block];
  const Ijk cells{ owner.cells(0), owner.cells(1), owner.cells(2) };
  const int normal = faceDirection(line.face);
  const Vec3 offset = vec3(line.offset);
  Ijk ijk = facePoint(cells, line.face, line.s, line.t);
  Vec3 below = owner.points(ijk);
  for (int k = 0; k <= cells[normal]; ++k)
  {
    ijk[normal] = faceSide(line.face) ? cells[normal] - k : k;
    const Vec3 here = owner.points(ijk);
    line.distance += (here - below).norm();
    below = here;
    const double weight = line.distance == 0.0 ? 1.0
      : line.distance < line.reach             ? 1.0 - line.distance / line.reach
                                               : 0.0;
    if (weight == 0.0)
    {
      return false;
    }
    displacements.raise({ line.block, ijk }, { weight, weight * offset });
  }
  const FaceContact contact = contactOf(complex, line.block, line.face ^ 1);
  if (contact.block < 0 || ++line.passed > static_cast<int>(complex.blocks.size()))
  {
    return false;
  }
  const auto st =
    mapFacePoint(contact.orientation, line.s, line.t, cells[faceAxis(line.face, 0)], cells[faceAxis(line.face, 1)]);
  line.block = contact.block;
  line.face = contact.face;
  line.s = st[0];
  line.t = st[1];
  return true;
}

/// Carries displacements along mesh lines that start on this rank, from block to block and from rank to rank.
void carry(const BlockComplex& complex, std::vector<MeshLine> lines, Displacements& displacements, const Ranks& ranks)
{
  do
  {
    std::vector<std::vector<MeshLine>> toRank(ranks.size());
    ranks.together([&] {
      for (MeshLine& line : lines)
      {
        while (passBlock(complex, line, displacements))
        {
          if (!displacements.isHere(line.block))
          {
            toRank[complex.blocks[line.block].rank].push_back(line);
            break;
          }
        }
      }
    });
    lines.clear();
    for (const std::vector<MeshLine>& part : ranks.exchange(toRank))
    {
      lines.insert(lines.end(), part.begin(), part.end());
    }
  } while (ranks.any(!lines.empty()));
}

} // namespace

WallDistances wallDistances(
  const BlockComplex& complex, const ConversionOptions& conversion, const BodySurface& body, const Execution& run)
{
  const EntityRules rules = classify(complex, conversion, run);
  const Wall wall(complex, rules);
  WallDistances result;
  result.wallPoints = wall.size();
  if (wall.size() == 0)
  {
    return result;
  }
  const LimitRows rows(complex, rules, wall);
  const std::vector<Vec3> points = wall.points(*run.ranks);
  Eigen::AlignedBox3d box;
  for (const Vec3& point : points)
  {
    box.extend(point);
  }
  using Distances = std::array<double, 2>;
  const std::vector<Distances> distances = sharedOut<Distances>(wall.size(), 64, run, [&](Index i) {
    return Distances{ body.closestPoint(points[i]).distance, body.closestPoint(rows.apply(i, points)).distance };
  });
  for (const Distances& distance : distances)
  {
    result.inputPoints = std::max(result.inputPoints, distance[0]);
    result.limitPoints = std::max(result.limitPoints, distance[1]);
  }
  const double size = box.diagonal().norm();
  if (!(result.inputPoints <= 0.2 * size))
  {
    const auto boxText = [](const Eigen::AlignedBox3d& b) {
      std::ostringstream text;
      text << '[' << b.min().transpose() << "] to [" << b.max().transpose() << ']';
      return text.str();
    };
    std::ostringstream text;
    text << "the body is far from the wall, up to " << result.inputPoints << ": the wall lies in " << boxText(box)
         << ", the body in " << boxText(body.bounds());
    // Units that CAD files and meshes come in, as powers of their ratio.
    const double ratio = body.size() / size;
    for (const double unit : { 1000.0, 100.0, 10.0, 25.4, 2.54, 12.0, 39.37, 3.2808 })
    {
      for (const double factor : { unit, 1.0 / unit })
      {
        // A mesh of half a body, or of a part of it, is smaller than the body.
        if (ratio > 0.7 * factor && ratio < 3.0 * factor)
        {
          text << "; the body is about " << factor << " times as large: is its unit another one?";
          throw Error(text.str());
        }
      }
    }
    throw Error(text.str());
  }
  return result;
}

BodyFitReport fitBody(
  BlockComplex& complex, const ConversionOptions& conversion, const BodyFitOptions& options, const Execution& run)
{
  if (!(options.tolerance > 0.0 && options.tolerance < 1.0))
  {
    throw Error("Fit Tolerance " + text(options.tolerance) + " is not between 0 and 1, both excluded");
  }
  if (options.iterations < 1)
  {
    throw Error("Fit Iterations " + std::to_string(options.iterations) + " is not at least 1");
  }
  if (!(options.range >= 0.0))
  {
    throw Error("Propagation Range " + text(options.range) + " is not at least 0");
  }
  if (options.edgesOnly && !options.body)
  {
    throw Error("limit points can be moved to the edges of a body only if there is one");
  }
  const EntityRules rules = classify(complex, conversion, run);
  const Wall wall(complex, rules);
  BodyFitReport report;
  report.wallPoints = wall.size();
  if (wall.size() == 0)
  {
    return report;
  }
  const LimitRows rows(complex, rules, wall);
  ExtraordinaryFans fans(rows, wall.size(), conversion.twist);
  const auto isFixed = [&](Index i) { return options.edgesOnly && !rows.onFeature(i); };
  const auto limit = [&](Index i, const std::vector<Vec3>& points) {
    return isFixed(i) ? points[i] : rows.apply(i, points);
  };
  const auto forAll = [&](const auto& body) {
    run.parallelFor(wall.size(), 256, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i)
      {
        body(i);
      }
    });
  };

  const std::vector<Vec3> given = wall.points(*run.ranks);
  std::vector<Vec3> target = given;
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  for (const Vec3& point : given)
  {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  const double size = (high - low).norm();
  if (options.body)
  {
    const std::vector<Triple> targets = sharedOut<Triple>(wall.size(), 256, run, [&](Index i) {
      if (isFixed(i))
      {
        return triple(given[i]);
      }
      const Vec3 point = options.edgesOnly ? limit(i, given) : given[i];
      const BodyPoint closest = options.body->closestPoint(point);
      if (rows.onFeature(i))
      {
        // Where the mesh follows an edge of the body, so do its limit points.
        constexpr double Near = 0.05;
        const BodyPoint edge = options.body->closestEdgePoint(point);
        if (edge.patch >= 0 && edge.distance <= closest.distance + Near * rows.spacing(i, given))
        {
          return triple(edge.geometry.point);
        }
      }
      return triple(options.edgesOnly ? point : closest.geometry.point);
    });
    std::transform(targets.begin(), targets.end(), target.begin(), vec3);
  }

  if (options.body)
  {
    for (std::size_t fan = 0; fan < fans.size(); ++fan)
    {
      fans.setFoot(fan, options.body->closestPoint(target[fans.center(fan)]).geometry);
    }
  }

  // Chebyshev iteration for eigenvalues of L in [Least, 1]; regular masks have 1/9 at least.
  constexpr double Least = 0.05;
  constexpr double Center = 0.5 * (1.0 + Least), HalfWidth = 0.5 * (1.0 - Least);
  std::vector<Vec3> x = given, residual(wall.size()), step(wall.size(), Vec3::Zero());
  const auto measure = [&] {
    forAll([&](Index i) { residual[i] = limit(i, x); });
    if (!options.edgesOnly && conversion.twist != Twist::Literal)
    {
      fans.correct(x, residual);
    }
    forAll([&](Index i) { residual[i] = target[i] - residual[i]; });
    double largest = 0.0;
    for (const Vec3& r : residual)
    {
      largest = std::max(largest, r.norm());
    }
    return largest;
  };
  report.initialResidual = report.residual = measure();
  double rho = HalfWidth / Center;
  while (report.residual > options.tolerance * size)
  {
    if (report.iterations == options.iterations)
    {
      throw Error("the wall's control points were not found in " + std::to_string(options.iterations) +
        " iterations (Fit Iterations): a limit point is still " + text(report.residual) + " away from its target");
    }
    run.ranks->together([&] { run.report(std::min(0.9, report.iterations / 80.0)); });
    if (report.iterations == 0)
    {
      forAll([&](Index i) { step[i] = residual[i] / Center; });
    }
    else
    {
      const double next = 1.0 / (2.0 * Center / HalfWidth - rho);
      forAll([&](Index i) { step[i] = next * rho * step[i] + 2.0 * next / HalfWidth * residual[i]; });
      rho = next;
    }
    forAll([&](Index i) { x[i] += step[i]; });
    ++report.iterations;
    report.residual = measure();
  }

  Displacements displacements(complex, *run.ranks);
  std::vector<MeshLine> lines;
  for (const int f : wall.faces())
  {
    const FaceUse& use = complex.faces[f].uses.front();
    const ComplexBlock& owner = complex.blocks[use.block];
    for (int t = 0; t <= owner.cells(faceAxis(use.face, 1)) && displacements.isHere(use.block); ++t)
    {
      for (int s = 0; s <= owner.cells(faceAxis(use.face, 0)); ++s)
      {
        const Index i = wall.id(use.block, use.face, s, t);
        lines.push_back(
          { use.block, use.face, s, t, 0, 0.0, triple(x[i] - given[i]), options.range * rows.spacing(i, given) });
      }
    }
  }
  carry(complex, std::move(lines), displacements, *run.ranks);
  displacements.share();
  for (Index i = 0; i < wall.size(); ++i)
  {
    report.displacement = std::max(report.displacement, (x[i] - given[i]).norm());
  }
  run.ranks->together([&] {
    displacements.apply(complex);
    run.report(1.0);
  });
  return report;
}

} // namespace bsv
