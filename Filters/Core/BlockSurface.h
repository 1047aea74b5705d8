// SPDX-License-Identifier: BSD-3-Clause
/// @file BlockSurface.h
/// The surfaces of the blocks as quadrilaterals: their numbering, what each of them meets, and steps around a mesh
/// edge.
#pragma once

#include "BlockMesh.h"

#include <array>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

namespace bsv
{

/// Quadrilateral of a block face with the mesh points (s, t) to (s + 1, t + 1).
struct QuadAt
{
  int block = 0;
  int face = 0;
  int s = 0;
  int t = 0;
};

/// Edge of a quadrilateral, along face axis `axis` at side `side` of the other face axis.
struct QuadEdge
{
  QuadAt quad;
  int axis = 0;
  int side = 0;
};

/// Numbers the quadrilaterals and the points on the surfaces of all blocks, block by block; a point on the border of
/// several faces has one number.
class SurfaceNumbering
{
public:
  explicit SurfaceNumbering(const BlockMesh& mesh);

  Index quadCount() const { return this->QuadStart.back(); }
  Index pointCount() const { return this->PointStart.back(); }
  int blockCount() const { return static_cast<int>(this->Cells.size()); }
  const Ijk& cells(int block) const { return this->Cells[block]; }
  int faceCells(int block, int face, int axis) const { return this->Cells[block][faceAxis(face, axis)]; }

  Index quad(const QuadAt& at) const
  {
    return this->FaceStart[6 * at.block + at.face] + at.s + Index(this->faceCells(at.block, at.face, 0)) * at.t;
  }
  Index firstQuad(int block) const { return this->QuadStart[block]; }
  /// Inverse of quad(); fastest if `hint` is the block.
  QuadAt quadAt(Index quad, int hint = 0) const;

  /// Number of a point on the surface of a block.
  Index point(int block, const Ijk& p) const;
  Index firstPoint(int block) const { return this->PointStart[block]; }
  int blockOfPoint(Index point) const;
  /// Inverse of point().
  Ijk pointAt(int block, Index point) const;

  /// Position in the block of corner (cs, ct) of a quadrilateral.
  Ijk corner(const QuadAt& at, int cs, int ct) const;
  /// Numbers of the corners (0,0), (1,0), (0,1), (1,1).
  std::array<Index, 4> corners(const QuadAt& at) const;

  /// The other surface quadrilateral of the same block at the same mesh edge.
  QuadEdge across(const QuadEdge& edge) const;

private:
  std::vector<Ijk> Cells;
  std::vector<Index> FaceStart;
  std::vector<Index> QuadStart;
  std::vector<Index> PointStart;
};

/// What every surface quadrilateral meets: another one, the outer boundary, or nothing known yet.
class Contacts
{
public:
  explicit Contacts(const SurfaceNumbering& surface)
    : Links(static_cast<std::size_t>(surface.quadCount()), Undecided)
    , SameBits(6 * static_cast<std::size_t>(surface.blockCount()), false)
  {
  }

  bool undecided(Index quad) const { return this->Links[quad] == Undecided; }
  bool boundary(Index quad) const { return this->Links[quad] < 0; }
  Index partner(Index quad) const { return this->Links[quad] >> 3; }
  int orientation(Index quad) const { return static_cast<int>(this->Links[quad] & 7); }
  /// Index of the boundary's name, or -1.
  int tag(Index quad) const { return static_cast<int>(Untagged - this->Links[quad]) - 1; }
  /// Equal for quadrilaterals of the same boundary.
  Index link(Index quad) const { return this->Links[quad]; }

  void setBoundary(Index quad, int tag) { this->Links[quad] = Untagged - (tag + 1); }
  void setContact(Index a, Index b, int orientation)
  {
    this->Links[a] = b << 3 | orientation;
    this->Links[b] = a << 3 | inverseOrientation(orientation);
  }
  void reset(Index quad) { this->Links[quad] = Undecided; }

  /// Whether all points of a face are known to be equal, bit for bit, to those of the face that it meets.
  bool sameBits(int block, int face) const { return this->SameBits[6 * std::size_t(block) + face]; }
  void setSameBits(int block, int face) { this->SameBits[6 * std::size_t(block) + face] = true; }

private:
  static constexpr Index Undecided = std::numeric_limits<Index>::min();
  static constexpr Index Untagged = -1;
  /// Partner and orientation code packed if >= 0.
  std::vector<Index> Links;
  std::vector<bool> SameBits;
};

/// Same values and same signs of zeros.
inline bool sameBits(const Vec3& a, const Vec3& b)
{
  return std::memcmp(a.data(), b.data(), 3 * sizeof(double)) == 0;
}

/// The same mesh edge on the quadrilateral that `edge.quad`, which must be in contact, meets.
QuadEdge throughContact(const SurfaceNumbering& surface, const Contacts& contacts, const QuadEdge& edge);

/// Normal of a quadrilateral that points out of its block, not normalized: the cross product of the diagonals.
Vec3 outwardNormal(const BlockMesh& mesh, const SurfaceNumbering& surface, const QuadAt& quad, bool leftHanded);

///@{
/// Texts of messages.
std::string blockLabel(const BlockMesh& mesh, int block);
std::string faceLabel(int face);
std::string text(double value);
std::string text(const Vec3& x);
std::string text(const Ijk& p);
///@}

} // namespace bsv
