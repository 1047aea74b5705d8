// SPDX-License-Identifier: BSD-3-Clause
/// @file BlockSurface.h
/// The surfaces of the blocks as quadrilaterals: their numbering, what each of them meets, and steps around a mesh
/// edge.
#pragma once

#include "Mesh/BlockMesh.h"

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
  /// With `numbered`, only blocks for which it is true get numbers.
  explicit SurfaceNumbering(const BlockMesh& mesh, const std::vector<char>* numbered = nullptr);

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
///
/// Most faces are of one piece: all undecided, one boundary, or a contact with one face in one way. They take no memory
/// per quadrilateral.
class Contacts
{
public:
  /// `surface`, which must outlive it, numbers all blocks.
  explicit Contacts(const SurfaceNumbering& surface);

  bool undecided(const QuadAt& at) const { return this->link(at) == Undecided; }
  bool boundary(const QuadAt& at) const { return this->link(at) < 0; }
  /// Number of the quadrilateral that it meets.
  Index partner(const QuadAt& at) const { return this->link(at) >> 3; }
  int orientation(const QuadAt& at) const { return static_cast<int>(this->link(at) & 7); }
  /// Index of the boundary's name, or -1.
  int tag(const QuadAt& at) const { return static_cast<int>(Untagged - this->link(at)) - 1; }
  /// Equal for quadrilaterals of the same boundary.
  Index link(const QuadAt& at) const
  {
    const Face& face = this->Faces[6 * std::size_t(at.block) + at.face];
    return face.each.empty() ? face.first + at.s * face.stepS + at.t * face.stepT
                             : face.each[at.s + this->width(at) * at.t];
  }

  void setBoundary(const QuadAt& at, int tag) { this->set(at, Untagged - (tag + 1)); }
  void setContact(const QuadAt& a, const QuadAt& b, int orientation)
  {
    this->set(a, this->Surface->quad(b) << 3 | orientation);
    this->set(b, this->Surface->quad(a) << 3 | inverseOrientation(orientation));
  }

  /// @name Whole faces
  ///@{
  /// Whether it is known to be of one piece; after close() if it is.
  bool onePiece(int block, int face) const { return this->Faces[6 * std::size_t(block) + face].each.empty(); }
  bool undecided(int block, int face) const;
  void setBoundary(int block, int face, int tag) { this->setWhole(block, face, Untagged - (tag + 1), 0, 0); }
  /// A contact that covers both its faces, which must be two.
  void setContact(const Interface& contact);
  /// Makes all that is undecided a boundary without a name.
  void close();
  ///@}

  /// Whether all points of a face are known to be equal, bit for bit, to those of the face that it meets.
  bool sameBits(int block, int face) const { return this->Faces[6 * std::size_t(block) + face].sameBits; }
  void setSameBits(int block, int face) { this->Faces[6 * std::size_t(block) + face].sameBits = true; }

private:
  static constexpr Index Undecided = std::numeric_limits<Index>::min();
  static constexpr Index Untagged = -1;

  /// Links, which are partner and orientation code packed if >= 0: one for each quadrilateral, or, if that is empty,
  /// linear in s and t.
  struct Face
  {
    std::vector<Index> each;
    Index first = Undecided;
    Index stepS = 0;
    Index stepT = 0;
    bool sameBits = false;
  };

  Index width(const QuadAt& at) const { return this->Surface->faceCells(at.block, at.face, 0); }
  void set(const QuadAt& at, Index link);
  void setWhole(int block, int face, Index first, Index stepS, Index stepT);
  /// Steps of the links of a face that meets face `b` of block `blockB`.
  std::array<Index, 2> steps(int orientation, int blockB, int b) const;
  bool linear(int block, int face, std::array<Index, 2>& steps) const;

  const SurfaceNumbering* Surface;
  std::vector<Face> Faces;
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
