// SPDX-License-Identifier: BSD-3-Clause
#include "BodyFit.h"

#include "BlockSurface.h"
#include "EdgeFans.h"
#include "EntityRules.h"
#include "LayerRules.h"
#include "OrderFreeSum.h"

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

/// Mesh points of the wall, numbered once each.
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
  Vec3 point(Index id) const { return this->Complex.blocks[this->Places[id].block].points(this->Places[id].ijk); }

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
    return k == 0           ? this->VertexId[shared.vertices[0]]
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
        this->Places.push_back(
          { use.block, facePoint(cells, use.face, (corner & 1) * ns, (corner >> 1) * nt) });
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
          this->Places.push_back({ use.block,
            facePoint(cells, use.face, axis == 0 ? along : across, axis == 0 ? across : along) });
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
        return (16.0 * x[id] + (4.0 * ((at(0) + at(1)) + (at(2) + at(3))) + ((at(4) + at(5)) + (at(6) + at(7))))) / 36.0;
      default:
      {
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
          { id(s - 1, t), id(s + 1, t), id(s, t - 1), id(s, t + 1), id(s - 1, t - 1), id(s + 1, t + 1), id(s - 1, t + 1),
            id(s + 1, t - 1) } };
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

/// Displacements of all blocks that are reached; a block's array is empty until then.
class Displacements
{
public:
  explicit Displacements(const BlockComplex& complex)
    : Complex(complex)
    , Values(complex.blocks.size())
  {
  }

  Displacement& at(int block, const Ijk& ijk)
  {
    const auto& counts = this->Complex.blocks[block].points.counts();
    if (this->Values[block].empty())
    {
      this->Values[block].resize(this->Complex.blocks[block].points.size());
    }
    return this->Values[block][ijk[0] + Index(counts[0]) * (ijk[1] + Index(counts[1]) * ijk[2])];
  }
  bool reaches(int block) const { return !this->Values[block].empty(); }

  /// Gives all copies of every shared point the largest of their displacements.
  void share()
  {
    for (const ComplexFace& face : this->Complex.faces)
    {
      if (face.uses.size() != 2 || (!this->reaches(face.uses[0].block) && !this->reaches(face.uses[1].block)))
      {
        continue;
      }
      const auto cells = [&](const FaceUse& use) {
        const ComplexBlock& block = this->Complex.blocks[use.block];
        return Ijk{ block.cells(0), block.cells(1), block.cells(2) };
      };
      const Ijk cellsA = cells(face.uses[0]), cellsB = cells(face.uses[1]);
      const int ns = cellsA[faceAxis(face.uses[0].face, 0)];
      const int nt = cellsA[faceAxis(face.uses[0].face, 1)];
      for (int t = 1; t < nt; ++t)
      {
        for (int s = 1; s < ns; ++s)
        {
          const auto st = mapFacePoint(face.orientation, s, t, ns, nt);
          this->unite({ { face.uses[0].block, facePoint(cellsA, face.uses[0].face, s, t) },
            { face.uses[1].block, facePoint(cellsB, face.uses[1].face, st[0], st[1]) } });
        }
      }
    }
    for (const ComplexEdge& edge : this->Complex.edges)
    {
      for (int k = 1; k < edge.cells; ++k)
      {
        std::vector<PointAt> copies;
        for (const EdgeUse& use : edge.uses)
        {
          const ComplexBlock& block = this->Complex.blocks[use.block];
          const int along = edgeDirection(use.edge);
          Ijk ijk;
          ijk[along] = use.reversed ? edge.cells - k : k;
          for (int axis = 0; axis < 2; ++axis)
          {
            const int d = faceAxis(2 * along, axis);
            ijk[d] = edgeSide(use.edge, axis) ? block.cells(d) : 0;
          }
          copies.push_back({ use.block, ijk });
        }
        this->unite(copies);
      }
    }
    for (const ComplexVertex& vertex : this->Complex.vertices)
    {
      std::vector<PointAt> copies;
      for (const CornerUse& use : vertex.corners)
      {
        const ComplexBlock& block = this->Complex.blocks[use.block];
        Ijk ijk;
        for (int d = 0; d < 3; ++d)
        {
          ijk[d] = cornerSide(use.corner, d) ? block.cells(d) : 0;
        }
        copies.push_back({ use.block, ijk });
      }
      this->unite(copies);
    }
  }

private:
  void unite(const std::vector<PointAt>& copies)
  {
    Displacement largest;
    for (const PointAt& copy : copies)
    {
      if (this->reaches(copy.block))
      {
        largest = std::max(largest, this->at(copy.block, copy.ijk));
      }
    }
    if (largest.weight > 0.0)
    {
      for (const PointAt& copy : copies)
      {
        this->at(copy.block, copy.ijk) = largest;
      }
    }
  }

  const BlockComplex& Complex;
  std::vector<std::vector<Displacement>> Values;
};

/// Carries the displacement of one wall point along its mesh line, from block to block.
void carry(const BlockComplex& complex, int block, int face, int s, int t, const Vec3& offset, double reach,
  Displacements& displacements)
{
  double distance = 0.0;
  for (std::size_t steps = 0; steps <= complex.blocks.size(); ++steps)
  {
    const ComplexBlock& owner = complex.blocks[block];
    const Ijk cells{ owner.cells(0), owner.cells(1), owner.cells(2) };
    const int normal = faceDirection(face);
    Ijk ijk = facePoint(cells, face, s, t);
    Vec3 below = owner.points(ijk);
    for (int k = 0; k <= cells[normal]; ++k)
    {
      ijk[normal] = faceSide(face) ? cells[normal] - k : k;
      const Vec3 here = owner.points(ijk);
      distance += (here - below).norm();
      below = here;
      const double weight = distance == 0.0 ? 1.0 : distance < reach ? 1.0 - distance / reach : 0.0;
      if (weight == 0.0)
      {
        return;
      }
      Displacement& target = displacements.at(block, ijk);
      target = std::max(target, Displacement{ weight, weight * offset });
    }
    const FaceContact contact = contactOf(complex, block, face ^ 1);
    if (contact.block < 0)
    {
      return;
    }
    const auto st =
      mapFacePoint(contact.orientation, s, t, cells[faceAxis(face, 0)], cells[faceAxis(face, 1)]);
    block = contact.block;
    face = contact.face;
    s = st[0];
    t = st[1];
  }
}

/// Replaces the points of the blocks that moved by copies in `complex`. All pieces of one block of the mesh share one
/// array, as their views did.
void movePoints(BlockComplex& complex, Displacements& displacements)
{
  std::map<int, std::vector<int>> piecesOf;
  for (int b = 0; b < static_cast<int>(complex.blocks.size()); ++b)
  {
    piecesOf[complex.blocks[b].parent].push_back(b);
  }
  for (const auto& [parent, pieces] : piecesOf)
  {
    if (std::none_of(pieces.begin(), pieces.end(), [&](int b) { return displacements.reaches(b); }))
    {
      continue;
    }
    std::array<int, 3> counts{ 0, 0, 0 };
    for (const int b : pieces)
    {
      for (int d = 0; d < 3; ++d)
      {
        counts[d] = std::max(counts[d], complex.blocks[b].offset[d] + complex.blocks[b].cells(d) + 1);
      }
    }
    const auto memory = std::make_shared<std::vector<double>>(3 * Index(counts[0]) * counts[1] * counts[2]);
    const GridView whole(memory->data(), counts);
    for (const int b : pieces)
    {
      ComplexBlock& block = complex.blocks[b];
      const Ijk cells{ block.cells(0), block.cells(1), block.cells(2) };
      for (int k = 0; k <= cells[2]; ++k)
      {
        for (int j = 0; j <= cells[1]; ++j)
        {
          for (int i = 0; i <= cells[0]; ++i)
          {
            Vec3 point = block.points(i, j, k);
            if (displacements.reaches(b))
            {
              const Displacement& displacement = displacements.at(b, { i, j, k });
              if (displacement.weight > 0.0)
              {
                point += displacement.offset;
              }
            }
            const Index at =
              i + block.offset[0] + counts[0] * (j + block.offset[1] + Index(counts[1]) * (k + block.offset[2]));
            std::copy_n(point.data(), 3, memory->data() + 3 * at);
          }
        }
      }
    }
    for (const int b : pieces)
    {
      ComplexBlock& block = complex.blocks[b];
      Ijk last;
      for (int d = 0; d < 3; ++d)
      {
        last[d] = block.offset[d] + block.cells(d);
      }
      block.points = whole.box(block.offset, last);
    }
    complex.weldedPoints.push_back(memory);
  }
}

} // namespace

WallDistances wallDistances(const BlockComplex& complex, const ConversionOptions& conversion, const BodySurface& body,
  const Execution& run)
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
  std::vector<Vec3> points(wall.size());
  Eigen::AlignedBox3d box;
  for (Index i = 0; i < wall.size(); ++i)
  {
    points[i] = wall.point(i);
    box.extend(points[i]);
  }
  std::vector<double> inputDistances(wall.size()), limitDistances(wall.size());
  run.parallelFor(wall.size(), 64, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i)
    {
      inputDistances[i] = body.closestPoint(points[i]).distance;
      limitDistances[i] = body.closestPoint(rows.apply(i, points)).distance;
    }
  });
  result.inputPoints = *std::max_element(inputDistances.begin(), inputDistances.end());
  result.limitPoints = *std::max_element(limitDistances.begin(), limitDistances.end());
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

BodyFitReport fitBody(BlockComplex& complex, const ConversionOptions& conversion, const BodyFitOptions& options,
  const Execution& run)
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

  std::vector<Vec3> given(wall.size()), target(wall.size());
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  for (Index i = 0; i < wall.size(); ++i)
  {
    given[i] = target[i] = wall.point(i);
    low = low.cwiseMin(given[i]);
    high = high.cwiseMax(given[i]);
  }
  const double size = (high - low).norm();
  if (options.body)
  {
    forAll([&](Index i) {
      if (isFixed(i))
      {
        return;
      }
      const Vec3 point = options.edgesOnly ? limit(i, given) : given[i];
      const BodyPoint closest = options.body->closestPoint(point);
      target[i] = options.edgesOnly ? point : closest.geometry.point;
      if (rows.onFeature(i))
      {
        // Where the mesh follows an edge of the body, so do its limit points.
        constexpr double Near = 0.05;
        const BodyPoint edge = options.body->closestEdgePoint(point);
        if (edge.patch >= 0 && edge.distance <= closest.distance + Near * rows.spacing(i, given))
        {
          target[i] = edge.geometry.point;
        }
      }
    });
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
    run.report(std::min(0.9, report.iterations / 80.0));
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

  Displacements displacements(complex);
  for (const int f : wall.faces())
  {
    const FaceUse& use = complex.faces[f].uses.front();
    const ComplexBlock& owner = complex.blocks[use.block];
    for (int t = 0; t <= owner.cells(faceAxis(use.face, 1)); ++t)
    {
      for (int s = 0; s <= owner.cells(faceAxis(use.face, 0)); ++s)
      {
        const Index i = wall.id(use.block, use.face, s, t);
        carry(complex, use.block, use.face, s, t, x[i] - given[i], options.range * rows.spacing(i, given),
          displacements);
      }
    }
  }
  displacements.share();
  for (Index i = 0; i < wall.size(); ++i)
  {
    report.displacement = std::max(report.displacement, (x[i] - given[i]).norm());
  }
  movePoints(complex, displacements);
  run.report(1.0);
  return report;
}

} // namespace bsv
