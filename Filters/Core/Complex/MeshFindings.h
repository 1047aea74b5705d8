// SPDX-License-Identifier: BSD-3-Clause
/// @file MeshFindings.h
/// What is found on the outer surface of a complex.
#pragma once

#include "Complex/OuterSurface.h"

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

/// Collects findings.
class MeshFindings
{
public:
  /// @param surface must outlive it.
  explicit MeshFindings(const OuterSurface& surface);

  /// The input block of a face.
  int parent(int face) const { return this->Surface.complex().blocks[this->Surface.use(face).block].parent; }
  /// @return its number.
  int add(const MeshFinding& finding);
  /// Says that a quadrilateral is part of a finding. Its first one counts, a suspicious one before others.
  void mark(Index quad, int number);
  bool isSuspicious(Index quad) const;
  void setComponents(int count) { this->Diagnosis.components = count; }

  /// All of them in their order; leaves nothing here.
  MeshDiagnosis sorted();

private:
  const OuterSurface& Surface;
  MeshDiagnosis Diagnosis;
};

} // namespace bsv
