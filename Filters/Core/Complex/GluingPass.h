// SPDX-License-Identifier: BSD-3-Clause
/// @file GluingPass.h
/// What the passes of gluing have in common: the mesh, what was decided so far, and how two faces are compared.
#pragma once

#include "Complex/GluingRanks.h"
#include "Mesh/BlockSurface.h"
#include "Mesh/PartialMesh.h"
#include "Ranks/Ranks.h"

#include <string>
#include <vector>

namespace bsv
{

struct BlockComplexOptions;

class GluingPass
{
public:
  /// All must outlive the pass. @param result what was decided so far, to which the pass adds.
  GluingPass(PartialMesh& mesh, const SurfaceNumbering& surface, const std::vector<bool>& leftHanded,
    const BlockComplexOptions& options, const Execution& run, Contacts& result);

protected:
  /// How the points of the two sides of a contact compare.
  struct Comparison
  {
    bool sameBits = true;
    /// First pair further apart than allowed, if distance > allowed.
    Ijk pointA{ 0, 0, 0 };
    Ijk pointB{ 0, 0, 0 };
    double distance = 0.0;
    double allowed = 0.0;
  };

  bool alone() const { return this->Ranks.size() == 1; }
  /// Match distance of a mesh point.
  double tolerance(int block, const Ijk& p) const;
  Vec3 corner(const QuadAt& at, int cs, int ct) const;
  Vec3 center(const QuadAt& at) const;
  /// Texts of messages.
  std::string where(const QuadAt& at) const;
  std::string where(Index quad) const;
  /// Compares many contacts, in parallel, each on the rank of its first block; ends at the first difference in bits if
  /// only that is asked. Collective.
  std::vector<Comparison> compare(const std::vector<Interface>& contacts, bool bitsOnly);
  /// The faces of a contact that covers both are known to be equal, if they are.
  void noteSameBits(const Interface& contact, const Comparison& compared);
  /// Whether a range is the whole face; whether a contact covers both its faces.
  bool whole(int block, int face, const FaceRange& range) const;
  bool whole(const Interface& contact) const;
  /// Enters the contact of all quadrilaterals of an interface, which errors call `what`.
  void take(const Interface& contact, const std::string& what);

  PartialMesh& Part;
  const BlockMesh& Mesh;
  const SurfaceNumbering& Surface;
  const std::vector<bool>& LeftHanded;
  const BlockComplexOptions& Options;
  const Execution& Run;
  const bsv::Ranks& Ranks;
  /// What was decided so far.
  Contacts& Result;

private:
  Comparison compare(const Interface& contact, bool bitsOnly) const;
};

} // namespace bsv
