// SPDX-License-Identifier: BSD-3-Clause
/// @file CreaseEdges.h
/// Which mesh edges of the outer boundary are creases: tagged ones, and those at which the surface is sharp.
#pragma once

#include "Complex/BlockComplex.h"
#include "Mesh/BlockSurface.h"

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace bsv
{

class Ranks;

/// How edges that turn by more than BlockComplexOptions::creaseAngle are told from round ones.
struct CreaseRules
{
  /// An edge is a crease if its normals differ this many times more than those at the next mesh edges on both sides,
  /// along the lines that cross it: so round noses are told from sharp edges. At least 0, which accepts all.
  double contrast = 7.0;
  /// Degrees by which the body turns near a point of it, within a small part of `length`; may be empty. At edges
  /// between two quadrilaterals of the body it decides in place of the contrast.
  std::function<double(const Vec3& point, double length)> bodyTurn;
  /// Per boundary name, whether it is part of the body.
  std::vector<bool> bodyTags;
};

/// Edges whose turn is within this of BlockComplexOptions::creaseAngle are borderline: smooth. Degrees; rounding of
/// coordinates, even of seven digits, turns the surface by less.
constexpr double CreaseAngleMargin = 0.01;
/// The same for the contrast, relative.
constexpr double CreaseContrastMargin = 1e-3;

/// A mesh edge of the outer boundary, before cutting, that turns by BlockComplexOptions::creaseAngle or more.
struct TurningEdge
{
  std::array<Vec3, 2> ends;
  /// Between the normals, degrees, and the largest at the next mesh edges on both sides.
  double angle = 0.0;
  double nearby = 0.0;
  /// Of the body, degrees; -1 if it did not decide.
  double bodyAngle = -1.0;
  /// Whether it is a crease; tagged ones are in any case.
  bool crease = false;
  bool tagged = false;
  /// Too near a limit to be called one.
  bool borderline = false;
};

/// buildBlockComplex() with these rules; the other takes the default ones.
/// @param[out] turning what creases were chosen from: the edges of this rank's blocks. May be null.
/// @throws Error for a negative contrast, too.
BlockComplex buildBlockComplex(const BlockMesh& mesh, const BlockComplexOptions& options, const CreaseRules& rules,
  std::vector<TurningEdge>* turning, const Execution& run = {});

/// The mesh edges on the outer boundary that are creases. Collective: every rank looks at its own blocks.
///
/// Tagged edges are (BlockMesh::creases, MeshBlock::creaseSharpness). Of the others, an edge at which the surface turns
/// by more than BlockComplexOptions::creaseAngle is one
/// - on the body, if CreaseRules::bodyTurn is given: where the body itself turns by more than that;
/// - elsewhere where the surface turns CreaseRules::contrast times as much as at the next mesh edges on
///   both sides, along the mesh lines that cross the edge. A side that is a block face of one cell says nothing, nor
///   does a strip of one cell between two edges that are sharp seen from their other sides, if it is less than a
///   quarter as wide as its neighbours or both edges turn by more than 80 degrees: the base of a blunt edge.
/// Edges within CreaseAngleMargin of the angle, or within CreaseContrastMargin of the contrast, are smooth, and
/// counted.
class CreaseEdges
{
public:
  CreaseEdges(const BlockMesh& mesh, const SurfaceNumbering& surface, const Contacts& contacts,
    const std::vector<bool>& leftHanded, double creaseAngle, const CreaseRules& rules, const Ranks& ranks);

  /// The same for all quadrilaterals, of all blocks, at one mesh edge.
  bool operator()(const QuadAt& quad, int axis, int side) const
  {
    return this->any(quad.block, quad.face) &&
      (this->Bits[6 * std::size_t(quad.block) + quad.face][this->place(quad)] >> (2 * axis + side) & 1) != 0;
  }
  /// Whether there are none.
  bool empty() const { return this->Bits.empty(); }
  /// Whether any edge of a quadrilateral of the face is one.
  bool any(int block, int face) const
  {
    return !this->Bits.empty() && !this->Bits[6 * std::size_t(block) + face].empty();
  }

  /// The edges of this rank's blocks that turn by more than the angle, up to the margin.
  const std::vector<TurningEdge>& turning() const { return this->Turning; }
  /// What was decided, one sentence each; the same on all ranks.
  const std::vector<std::string>& notes() const { return this->Notes; }

private:
  class Search;

  Index place(const QuadAt& quad) const
  {
    return quad.s + Index(this->Surface.faceCells(quad.block, quad.face, 0)) * quad.t;
  }

  const SurfaceNumbering& Surface;
  /// Per face and quadrilateral one bit per edge; empty while there are no creases.
  std::vector<std::vector<std::uint8_t>> Bits;
  std::vector<TurningEdge> Turning;
  std::vector<std::string> Notes;
};

} // namespace bsv
