// SPDX-License-Identifier: BSD-3-Clause
/// @file LimitRows.h
/// Where the converted wall passes at its mesh points, as a linear function of them.
#pragma once

#include "Base/OrderFreeSum.h"
#include "Body/NURBSSurface.h"
#include "Conversion/LayerRules.h"
#include "Wall/WallPoints.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <vector>

namespace bsv
{

/// The limit masks of all wall points as rows over the wall points: where the converted wall passes at its mesh points,
/// but for what the rules at extraordinary vertices change at the points around them (ExtraordinaryFans).
class LimitRows
{
public:
  LimitRows(const BlockComplex& complex, const EntityRules& rules, const Wall& wall);

  /// Whether the point lies on a crease, a border of the wall or at a corner.
  bool onFeature(Index id) const { return this->Rows[id].kind != Kind::Tensor && this->Rows[id].kind != Kind::Ring; }

  /// Whether a crease or border passes through the point as a smooth curve.
  bool isCurve(Index id) const { return this->Rows[id].kind == Kind::Curve; }

  /// The points around an extraordinary vertex, inside the wall: next ones, then diagonals. Empty at all other points.
  const std::vector<Index>& ring(Index id) const;
  /// Where creases or borders meet inside the wall so that points beside them do not follow the regular rule: the same,
  /// and which of the next points lie on the features.
  struct CreasedRing
  {
    std::vector<Index> points;
    std::vector<int> features;
  };
  const std::map<Index, CreasedRing>& creasedRings() const { return this->Creased; }
  /// Whether the wall is regular there.
  bool isTensor(Index id) const { return this->Rows[id].kind == Kind::Tensor; }

  Vec3 apply(Index id, const std::vector<Vec3>& x) const;
  /// Calls visit(point, weight) for the points of apply() and their weights.
  using VisitWeight = std::function<void(Index point, double weight)>;
  void forWeights(Index id, const VisitWeight& visit) const;

  /// The mask across the wall's edge that a point lies on, inside the edge: the point itself on creases and borders.
  Vec3 across(Index id, const std::vector<Vec3>& x) const;
  void forWeightsAcross(Index id, const VisitWeight& visit) const;
  /// The mask across the edge that leaves vertex `id` towards its next point `spoke`, at the vertex.
  Vec3 acrossSpoke(Index id, Index spoke, const std::vector<Vec3>& x) const;
  void forWeightsAcrossSpoke(Index id, Index spoke, const VisitWeight& visit) const;

  /// Calls visit(next) for the points one mesh edge away that the row knows: of a curve along it, else all around.
  template <typename Visit>
  void forNext(Index id, const Visit& visit) const
  {
    const Row& row = this->Rows[id];
    std::for_each_n(row.points.begin(), row.next, visit);
  }

  /// Mean distance to the next points, the local edge length.
  double spacing(Index id, const std::vector<Vec3>& x) const;

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

  void addFace(const BlockComplex& complex, const Wall& wall, int f);

  void addEdge(const BlockComplex& complex, const EntityRules& rules, const Wall& wall, int e);

  void addVertex(const BlockComplex& complex, const EntityRules& rules, const Wall& wall, int v);

  /// Whether a vertex on a crease or border has none of its lines along the edge towards `spoke`.
  static bool leavesCrease(const Row& row, Index spoke);
  /// The points beside vertex `id` in the fan inside the wall, around its next point `spoke`.
  static std::array<Index, 2> beside(const Row& row, Index spoke);

  std::vector<Row> Rows;
  std::map<Index, CreasedRing> Creased;
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
  ExtraordinaryFans(const LimitRows& rows, Index points, Twist twist);

  /// Those of smooth vertices, which can follow a point of the body.
  std::size_t size() const { return this->Centers.size(); }
  Index center(std::size_t fan) const { return this->Centers[fan]; }
  void setFoot(std::size_t fan, const SurfaceGeometry& geometry);

  /// Adds the changes to `values`, the limit masks' values for the wall points `x`.
  void correct(const std::vector<Vec3>& x, std::vector<Vec3>& values);

private:
  /// Adds what the rule's result `points` changes around the fan of `ring`.
  void addChanges(const std::vector<Index>& ring, const Fan& fan, const Fan& points);
  /// A point can lie next to several vertices.
  void add(Index id, const Vec3& change);

  Twist Rule;
  std::map<Index, LimitRows::CreasedRing> Creased;
  std::vector<Index> Centers;
  std::vector<std::vector<Index>> Rings;
  std::vector<BodyFoot> Feet;
  std::vector<bool> HasFoot;
  std::map<Index, OrderFreeSum> Slots;
};

} // namespace bsv
