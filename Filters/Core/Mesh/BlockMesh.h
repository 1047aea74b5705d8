// SPDX-License-Identifier: BSD-3-Clause
/// @file BlockMesh.h
/// The input of everything: hexahedral blocks as structured grids, with what is known of their contacts, boundaries
/// and creases. All of it but the points is optional.
#pragma once

#include "Base/Types.h"
#include "Mesh/BlockTopology.h"
#include "Mesh/GridView.h"

#include <string>
#include <vector>

namespace bsv
{

/// Sharpness from which an edge counts as infinitely sharp (OpenSubdiv's Sdc::Crease::SHARPNESS_INFINITE).
constexpr double SharpnessInfinite = 10.0;

/// Rectangle of mesh points on a face, in the face's axes: [lo[0], hi[0]] x [lo[1], hi[1]], both included.
struct FaceRange
{
  std::array<int, 2> lo{ 0, 0 };
  std::array<int, 2> hi{ 0, 0 };

  bool operator==(const FaceRange& other) const { return this->lo == other.lo && this->hi == other.hi; }
  bool operator!=(const FaceRange& other) const { return !(*this == other); }
};

/// Contact of two faces, node to node: rangeA on faceA meets the rectangle on faceB that starts at originB (its lowest
/// corner) and has rangeA's size, axes exchanged if the orientation says so. A block may meet itself.
struct Interface
{
  int blockA = 0;
  int faceA = 0;
  int blockB = 0;
  int faceB = 0;
  int orientation = 0;
  FaceRange rangeA;
  std::array<int, 2> originB{ 0, 0 };

  /// The rectangle covered on faceB.
  FaceRange rangeB() const
  {
    const int n[2] = { this->rangeA.hi[0] - this->rangeA.lo[0], this->rangeA.hi[1] - this->rangeA.lo[1] };
    const bool swap = swapsAxes(this->orientation);
    return { this->originB, { this->originB[0] + n[swap ? 1 : 0], this->originB[1] + n[swap ? 0 : 1] } };
  }
};

/// Part of a face that belongs to the named boundary `tag` (index into BlockMesh::boundaryNames).
struct BoundaryPatch
{
  int block = 0;
  int face = 0;
  FaceRange range;
  int tag = 0;
};

/// Run of mesh edges along one grid line, from one point to another that differs from it in one direction only.
struct CreaseLine
{
  int block = 0;
  Ijk from{ 0, 0, 0 };
  Ijk to{ 0, 0, 0 };
};

struct MeshBlock
{
  /// (I+1) x (J+1) x (K+1) points, every count >= 2.
  GridView points;
  /// The rank that has them; all other ranks have GridView::elsewhere().
  int rank = 0;
  std::string name;
  /// Sharpness per mesh point, i fastest, or empty. An edge on the outer boundary of the mesh is a crease where both
  /// of its points are infinitely sharp. Allowed: 0 (smooth) and values >= SharpnessInfinite.
  std::vector<double> creaseSharpness;
};

struct BlockMesh
{
  std::vector<MeshBlock> blocks;
  std::vector<Interface> interfaces;
  std::vector<BoundaryPatch> boundaries;
  std::vector<std::string> boundaryNames;
  /// What each boundary is, as CGNS calls it: "BCWallViscous", "BCSymmetryPlane", .., or "BCTypeUserDefined" where it
  /// is not known. Empty, or as many as there are names.
  std::vector<std::string> boundaryTypes;
  std::vector<CreaseLine> creases;
  /// How the mesh came about and what may be wrong with it, one sentence each.
  std::vector<std::string> notes;
  std::vector<std::string> warnings;
};

} // namespace bsv
