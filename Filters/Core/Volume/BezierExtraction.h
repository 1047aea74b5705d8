// SPDX-License-Identifier: BSD-3-Clause
/// @file BezierExtraction.h
/// A multi-block B-spline volume as Bezier cells: the same polynomials, or rationals, span by span.
///
/// n non-empty spans of degree p give n p + 1 Bezier points in a direction, cells sharing those between them. Points at
/// which blocks meet are shared as well, so that the cells of the whole volume are connected.
///
/// With several ranks each has the cells of its blocks, or of the faces of its blocks, and their points. Points at the
/// borders between ranks are on all of these ranks, with the same bits; what is shared within a rank is what is shared
/// in the whole.
///
/// Points at which blocks meet have the same bits from either block under the conditions of TensorPasses.h; then no
/// numbering, orientation or number of threads matters.
#pragma once

#include "Mesh/BlockMesh.h"
#include "Mesh/BlockSurface.h"
#include "Volume/BSplineVolume.h"
#include "Volume/TensorPasses.h"

#include <map>

namespace bsv
{

class Ranks;
class UnionFind;

enum class BezierCells
{
  Volume,     ///< one cell per span: hexahedra
  OuterFaces, ///< one cell per span of the faces that meet no other: quadrilaterals
  AllFaces    ///< one cell per span of all faces, those at which blocks meet once: quadrilaterals
};

/// Bezier points of a block per direction.
/// @throws Error, beginning with `name`, if they are more than an int per direction or 2^63 bytes in all can hold.
Ijk bezierCounts(const BSplineVolume& volume, const std::string& name);

/// Face `face` of block `block`.
struct BlockFace
{
  int block = 0;
  int face = 0;
};

/// Numbers the Bezier points of all blocks, shared ones once, and computes them. The points on the surfaces of the
/// blocks are computed and kept from the start: whether they are shared depends on their values.
///
/// Source: M. J. Borden, M. A. Scott, J. A. Evans, T. J. R. Hughes, Isogeometric finite element data structures based
/// on Bezier extraction of NURBS, Int. J. Numer. Meth. Engng 87 (2011) 15-47, doi:10.1002/nme.2968.
class BezierExtraction
{
public:
  /// @param volumes must have passed checkBSplineVolume(); they, and what they view, must outlive the extraction.
  /// @param interfaces contacts of whole faces, ranges not used; if null, faces whose Bezier points are equal in some
  ///   orientation count as contacts. Points of a contact are shared if they are equal, and the faces have equal
  ///   numbers of them: a gap stays a gap. Equal means: up to 1e-14 of the largest coordinate, and of the weight.
  /// @throws Error, Aborted
  BezierExtraction(const std::vector<BSplineVolume>& volumes, const std::vector<Interface>* interfaces,
    BezierCells cells, const Execution& run = {});

  /// Whether any block is rational: then all points have weights.
  bool rational() const { return this->Rational; }
  /// Bezier points per direction, and spans per direction, of a block.
  const Ijk& counts(int block) const { return this->Counts[block]; }
  const Ijk& spans(int block) const { return this->Spans[block]; }

  /// All points of this rank, each counted once.
  Index pointCount() const { return this->PointCount; }
  /// Number of Bezier point `p` of a block on this rank, or -1 if it belongs to no cell.
  Index point(int block, const Ijk& p) const;

  /// The faces of blocks on this rank that are cells, in the order of blocks and faces; empty for BezierCells::Volume.
  const std::vector<BlockFace>& faces() const { return this->Faces; }

  /// @param[out] points pointCount() triples.
  /// @param[out] weights pointCount() numbers if rational(), else not used.
  /// Not collective.
  /// @throws Aborted
  void evaluate(double* points, double* weights, const Execution& run = {}) const;

private:
  /// Points of faces of blocks on other ranks, by 6 * block + face, first face axis fastest.
  using FaceValues = std::map<int, std::vector<double>>;

  bool isHere(int block) const { return this->Volumes[block].rank == this->Rank; }
  Index surfacePoint(int block, const Ijk& p) const;
  Index surfacePoint(const BlockFace& at, int s, int t) const;
  void evaluateBox(
    int block, const std::array<WeightTable, 3>& tables, double* homogeneous, const Execution& run) const;
  void evaluateSurfaces(const Execution& run);
  Ijk cornerOf(int block, int corner) const;
  bool equal(const double* x, int blockA, const double* y, int blockB) const;
  bool faceCountsFit(const Interface& contact) const;
  template <typename Visitor>
  void overContact(const Interface& contact, Visitor&& visit) const;
  FaceValues fetchFaces(const std::vector<std::array<BlockFace, 2>>& pairs, const Ranks& ranks) const;
  const double* valueAt(const BlockFace& at, int s, int t, const FaceValues& fetched) const;
  bool coincide(const Interface& contact, const FaceValues& fetched) const;
  std::vector<Interface> coincidentFaces(const Ranks& ranks) const;
  void shareGroups(const std::vector<Interface>& contacts, UnionFind& groups, const Ranks& ranks);
  void number(const std::vector<Interface>& contacts, BezierCells cells, const Ranks& ranks);

  const std::vector<BSplineVolume>& Volumes;
  int Rank = 0;
  bool Rational = false;
  std::vector<Ijk> Counts;
  std::vector<Ijk> Spans;
  std::vector<std::array<WeightTable, 3>> Tables;
  /// Bezier points on the surfaces of all blocks, before any are shared.
  SurfaceNumbering Surface;
  /// Those of the blocks on this rank, one block after the other, and their final numbers.
  Index SurfacePoints = 0;
  std::vector<Index> Start;          ///< per block
  std::vector<double> SurfaceValues; ///< x, y, z and, if rational, the weight
  std::vector<double> Tolerances;    ///< per block
  std::vector<Index> SurfaceNumbers;
  std::vector<BlockFace> Faces;
  std::vector<Index> InsideStart; ///< per block; empty unless cells are hexahedra
  Index PointCount = 0;
};

} // namespace bsv
