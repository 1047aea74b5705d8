// SPDX-License-Identifier: BSD-3-Clause
/// @file BlockComplex.h
/// The conforming block complex: blocks that meet whole face to whole face, and the global vertices, edges and faces
/// that they share.
#pragma once

#include "Mesh/BlockMesh.h"
#include "Mesh/GridView.h"

#include <memory>
#include <string>
#include <vector>

namespace bsv
{

struct BlockComplexOptions
{
  /// Two boundary points are one if they are closer than this fraction of the shortest mesh edge at either of them.
  /// Range (0, 0.5).
  double matchTolerance = 0.05;
  /// Look for contacts among the boundary quadrilaterals that are neither in a declared interface nor in a declared
  /// boundary.
  bool findInterfaces = true;
  /// Keep faces and cells of zero extent instead of refusing them; collapsed quadrilaterals are then boundaries.
  bool allowDegenerate = false;
  /// A mesh edge of the outer boundary can be a crease where the normals of its two quadrilaterals differ by more than
  /// this (CreaseEdges.h says which are). Degrees, range [0, 180]; 180 turns the search off.
  double creaseAngle = 180.0;
};

/// Corner `corner` of block `block`.
struct CornerUse
{
  int block;
  int corner;
};

/// Edge `edge` of block `block`; reversed if the block runs it from the global edge's second vertex to its first.
struct EdgeUse
{
  int block;
  int edge;
  bool reversed;
};

struct FaceUse
{
  int block;
  int face;
};

struct ComplexVertex
{
  /// All block corners that meet here.
  std::vector<CornerUse> corners;
  bool boundary = false;
};

struct ComplexEdge
{
  std::array<int, 2> vertices{ -1, -1 };
  /// Mesh cells along the edge.
  int cells = 0;
  /// All block edges that meet here; their number is the valence.
  std::vector<EdgeUse> uses;
  bool boundary = false;
  /// Tagged as crease, or sharp (CreaseEdges.h). Only boundary edges can be creases.
  bool crease = false;

  int valence() const { return static_cast<int>(this->uses.size()); }
  /// Interior edge at which other than four blocks meet.
  bool extraordinary() const { return !this->boundary && this->valence() != 4; }
};

struct ComplexFace
{
  /// One block face on the boundary, two inside.
  std::vector<FaceUse> uses;
  /// Orientation code from uses[0] to uses[1].
  int orientation = 0;
  /// Index into BlockComplex::boundaryNames, or -1: inside, or a boundary without a name.
  int tag = -1;
  /// Inside a block of the mesh that was cut here for creases alone: without them it would be whole (JoinedBlocks.h).
  bool creaseCut = false;

  bool boundary() const { return this->uses.size() == 1; }
};

/// One block of the complex: a whole block of the mesh, or a piece of one.
struct ComplexBlock
{
  GridView points;
  /// The rank that has them (MeshBlock::rank).
  int rank = 0;
  std::string name;
  /// Block of the mesh that this piece was cut from, and its first point there.
  int parent = 0;
  Ijk offset{ 0, 0, 0 };
  std::array<int, 8> vertices{};
  std::array<int, 12> edges{};
  /// Whether the block runs edge e against the global edge.
  std::array<bool, 12> edgeReversed{};
  std::array<int, 6> faces{};
  bool leftHanded = false;

  /// Cells per direction.
  int cells(int direction) const { return this->points.counts()[direction] - 1; }
};

struct BlockComplex
{
  std::vector<ComplexBlock> blocks;
  std::vector<ComplexVertex> vertices;
  std::vector<ComplexEdge> edges;
  std::vector<ComplexFace> faces;
  std::vector<std::string> boundaryNames;
  /// BlockMesh::boundaryTypes.
  std::vector<std::string> boundaryTypes;

  /// Cells whose corner Jacobians do not all have the sign of their block.
  Index tangledCells = 0;
  /// What may be wrong with the mesh, one sentence each: left-handed blocks, tangled cells.
  std::vector<std::string> warnings;
  /// What was done, one sentence each: blocks that were split along contacts and boundaries.
  std::vector<std::string> notes;
  /// The same of the blocks that were split along creases; empty if there are none.
  std::string creaseNote;

  /// Memory behind the views of the blocks whose points had to be welded. Empty if all copies of every shared point
  /// were equal bit for bit.
  std::vector<std::shared_ptr<std::vector<double>>> weldedPoints;
  /// Points that were moved (BodyFit.h), which the views of their blocks show.
  std::vector<std::shared_ptr<ChangedPoints>> changedPoints;
};

/// Builds the complex: glues, cuts blocks along partial contacts, boundary borders and creases until all contacts are
/// face to face, and numbers the shared entities.
///
/// Every shared point gets one value, the lexicographically smallest of its copies, so that nothing depends on the
/// order of the blocks. The views of the returned blocks point into `mesh` unless points had to be welded; `mesh` must
/// outlive them.
///
/// Collective: all ranks return the same complex, that of a process alone, each with the points of its own blocks.
///
/// @throws Error for non-finite points, zero cells, contacts that do not match, ambiguous or non-matching contacts,
/// collapsed faces or cells (unless allowed), semi-sharp creases.
BlockComplex buildBlockComplex(
  const BlockMesh& mesh, const BlockComplexOptions& options = {}, const Execution& run = {});

/// Numbers the vertices and edges of a complex whose blocks and faces are known, and marks those on the boundary. Edges
/// are no creases. @throws Error for edges that meet with different numbers of cells.
void numberVerticesAndEdges(BlockComplex& complex);

/// Point of a block of `cells` + 1 points per direction at mesh position (s, t) of a face.
Ijk facePoint(const Ijk& cells, int face, int s, int t);

} // namespace bsv
