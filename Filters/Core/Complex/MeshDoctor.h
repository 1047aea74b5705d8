// SPDX-License-Identifier: BSD-3-Clause
/// @file MeshDoctor.h
/// Looks for blocks that should meet and do not, and for other surprises of the outer surface of a complex.
#pragma once

#include "Complex/BlockComplex.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace bsv
{

/// Values are the codes of the array `Finding` of vtkHexBlockTopology.
enum class MeshFindingKind : std::uint8_t
{
  None,
  NearMiss,      ///< outer faces that nearly face each other, as if two blocks had been meant to meet
  LoosePoint,    ///< outer faces that would meet if one pair of points were one
  Overlap,       ///< outer faces inside other cells
  NarrowGap,     ///< walls that come close to each other, as at a sharp edge of a body
  InnerBoundary, ///< closed surface around a hole in the mesh that has no name, as a body has without boundaries
  Component,     ///< blocks that share no face with the others
  Count
};

/// Names of the codes, in order.
const std::vector<std::string>& meshFindingNames();

/// One thing found. Blocks and faces are those of the input mesh.
struct MeshFinding
{
  MeshFindingKind kind = MeshFindingKind::None;
  /// The side that has the lower number, and what it faces or lies in; -1 if that is nothing.
  std::array<int, 2> blocks{ -1, -1 };
  std::array<int, 2> faces{ -1, -1 };
  /// Outer quadrilaterals concerned, on both sides; of a component the number of its blocks.
  Index quads = 0;
  /// Largest distance between the two sides, in lengths and as a fraction of the cells there; 0 if it means nothing.
  double distance = 0.0;
  double fraction = 0.0;
  /// The least BlockComplexOptions::matchTolerance with which all of it would be glued; 0 if none would.
  double glueTolerance = 0.0;
  /// Where the distance is largest; else the middle of a quadrilateral.
  Vec3 place = Vec3::Zero();

  /// Whether it is hardly meant: near misses, loose points and overlaps of outer faces without a name.
  bool suspicious() const { return this->kind != MeshFindingKind::None && this->kind < MeshFindingKind::NarrowGap; }
};

struct MeshDiagnosis
{
  /// Suspicious ones first, then by kind and blocks.
  std::vector<MeshFinding> findings;
  /// By face of the complex and quadrilateral, s fastest, the number of its finding or -1; empty where there is none.
  std::vector<std::vector<int>> findingOfQuad;
  /// Parts of the mesh that share no face.
  int components = 0;

  bool suspicious() const { return !this->findings.empty() && this->findings.front().suspicious(); }
};

/// Examines the boundary faces of a complex that belong to no named boundary.
///
/// Two such faces nearly face each other where the center of a quadrilateral lies before another one that faces it, or
/// all its corners lie near those of the other, closer than 0.6 of the cells there in their own directions. Walls do
/// that, too, where a body is thin: there the surface goes on smoothly beyond the near part, or bends around the edge
/// of the body from one side to the other. If neither side does, it is a near miss.
///
/// An outer face lies in other cells if a ray from it leaves cells more often than it enters them; up to 25
/// quadrilaterals of each face are tried, and all of a face where one does.
///
/// Takes time in proportion to the outer surface. Nothing depends on the numbering of the blocks but the numbers.
/// Collective; all ranks return the same.
MeshDiagnosis diagnose(const BlockComplex& complex, const Execution& run = {});

/// One sentence with block, face, place and figures. @param mesh from which the complex was built, for its names.
std::string describe(const BlockMesh& mesh, const MeshFinding& finding);

/// @throws Error with the number of suspicious findings and the description of the first, if there are any.
void refuseSuspicious(const BlockMesh& mesh, const MeshDiagnosis& diagnosis);

} // namespace bsv
