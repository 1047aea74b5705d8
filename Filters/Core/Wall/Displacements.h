// SPDX-License-Identifier: BSD-3-Clause
/// @file Displacements.h
/// Displacements of wall points, carried along mesh lines into the layers of all blocks and ranks.
#pragma once

#include "Base/CanonicalOrder.h"
#include "Base/Numbers.h"
#include "Base/SparseArray.h"
#include "Complex/BlockComplex.h"
#include "Mesh/GridView.h"
#include "Wall/WallPoints.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <vector>

namespace bsv
{

/// Displacement of one mesh point. Where several reach it the one with the largest weight counts, or the mean of those
/// whose weights are as large up to rounding, as in the middle between two walls.
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
    return comesBefore(this->offset, other.offset);
  }
  /// Whether it counts beside one of a weight that is as large or larger. Wall points have their own alone.
  bool equals(const Displacement& largest) const
  {
    constexpr double Rounding = 0x1p-20;
    return largest.weight < 1.0 && this->weight > 0.0 && largest.weight - this->weight <= Rounding;
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
  Displacements(const BlockComplex& complex, const Ranks& ranks);

  bool isHere(int block) const { return this->Complex.blocks[block].rank == this->Group.rank(); }
  /// One more displacement that reaches a point; in any order.
  void raise(const PointAt& point, const Displacement& displacement);

  /// Gives all copies of every shared point, on all ranks, all of their displacements that count.
  void share();

  /// Moves the points. The offsets become the moved points, which takes no more memory.
  void apply(BlockComplex& complex);

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
    /// Of few slots: others that count beside the largest.
    std::map<Index, std::set<Displacement>> others;

    std::vector<Displacement> counting(Index slot) const;
  };
  /// Offset of points that share a page with others and do not move: not zero, which would change the sign of zeros.
  static Vec3 unmoved() { return Vec3::Constant(std::numeric_limits<double>::quiet_NaN()); }
  static bool isUnmoved(const Vec3& offset) { return std::isnan(offset[0]); }

  Index place(const PointAt& point) const;
  bool reaches(int block) const { return !this->Grids[this->Complex.blocks[block].parent].weights.empty(); }
  template <typename Use>
  bool reachesAny(const std::vector<Use>& uses) const
  {
    return std::any_of(uses.begin(), uses.end(), [&](const Use& use) { return this->reaches(use.block); });
  }

  std::vector<PointAt> copies(const SharedPoint& point) const;

  /// Gives the copies on this rank all of their displacements that count, and tells them to the ranks that have others.
  void unite(const SharedPoint& point, std::vector<std::vector<Message>>& toRank);

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
  /// Number of the wall point.
  Index wallPoint;
};

/// Follows mesh lines that start on this rank, from block to block and from rank to rank, as far as they reach: calls
/// visit(point, weight, line) for every mesh point on the rank that has it.
using VisitLine = std::function<void(const PointAt& point, double weight, const MeshLine& line)>;
void follow(const BlockComplex& complex, std::vector<MeshLine> lines, const VisitLine& visit, const Ranks& ranks);

/// Carries displacements along mesh lines.
void carry(const BlockComplex& complex, std::vector<MeshLine> lines, Displacements& displacements, const Ranks& ranks);

} // namespace bsv
