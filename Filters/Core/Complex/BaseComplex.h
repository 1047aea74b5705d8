// SPDX-License-Identifier: BSD-3-Clause
/// @file BaseComplex.h
/// The blocks of an unstructured hexahedral mesh.
///
/// Inside the mesh four cells meet at a regular edge; on the boundary up to two. At all other, singular edges the faces
/// start separation surfaces: each goes on over a regular inner edge to the opposite face, until it meets the boundary
/// or a singular edge. What they enclose are the blocks: grids of cells, each face of which meets one face of another
/// block or lies on the boundary. This is the base complex (Bommer, Lempe, Kobbelt 2011). Regions that close on
/// themselves, like a ring, are cut by further surfaces of the same kind, the smallest that do. It takes no tolerance.
///
/// Origin, directions and order of the blocks follow from the coordinates alone: no numbering of cells and points, and
/// no order of the corners of a cell, makes a difference.
#pragma once

#include "Complex/HexMesh.h"
#include "Complex/HexNeighbours.h"
#include "Mesh/BlockMesh.h"

namespace bsv
{

struct BaseComplexOptions
{
  HexNeighbourOptions neighbours;
  /// Without any named boundary: block faces on the boundary are one boundary where they turn by at most this. Degrees,
  /// range [0, 180].
  double featureAngle = 30.0;
  /// Join blocks to larger ones, whose faces may then meet parts of several others.
  bool mergeBlocks = false;
  /// More blocks are an error, not a mesh.
  Index maximumBlocks = 100000;
};

/// A grid of cells.
struct HexBlock
{
  /// Cells per direction.
  Ijk cells{ 0, 0, 0 };
  /// Its cells and points, i fastest.
  std::vector<HexId> cellIds;
  std::vector<HexId> pointIds;
};

struct BaseComplex
{
  std::vector<HexBlock> blocks;
  std::vector<Interface> interfaces;
  std::vector<BoundaryPatch> boundaries;
  std::vector<std::string> boundaryNames;
  /// Mesh edges at which the cells do not form a grid.
  Index singularEdges = 0;
  /// Regions that closed on themselves.
  Index closedRegions = 0;
  /// What was done and what may be wrong, one sentence each.
  std::vector<std::string> notes;
  std::vector<std::string> warnings;
};

/// Finds the blocks. The corners of `mesh` are used up.
///
/// Right-handed blocks where the cells' volumes say so.
///
/// @throws Error that names cells and place: what findNeighbours() refuses, points and edges at which cells meet that
/// share no face there, and more blocks than allowed.
BaseComplex baseComplex(HexMesh& mesh, const BaseComplexOptions& options = {}, const Execution& run = {});

} // namespace bsv
