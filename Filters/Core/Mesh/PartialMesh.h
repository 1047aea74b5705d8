// SPDX-License-Identifier: BSD-3-Clause
/// @file PartialMesh.h
/// What one rank knows of a mesh.
#pragma once

#include "Mesh/BlockMesh.h"
#include "Mesh/PointExchange.h"

#include <memory>
#include <vector>

namespace bsv
{

/// A mesh of several ranks, with boxes of points of the other ranks' blocks.
class PartialMesh
{
public:
  /// Both must outlive it.
  PartialMesh(const BlockMesh& mesh, const Ranks& ranks);
  PartialMesh(const PartialMesh&) = delete;
  PartialMesh& operator=(const PartialMesh&) = delete;

  /// The mesh itself if there is one rank only. Else views of its blocks that know what was fetched, without sharpness.
  const BlockMesh& mesh() const { return this->Others.size() == 1 ? this->Whole : this->Known; }
  /// Whether all points of a block are here.
  bool isHere(int block) const { return this->mesh().blocks[block].points.isHere(); }
  int rankOf(int block) const { return this->mesh().blocks[block].rank; }

  /// Fetches boxes and forgets those fetched before. Collective.
  void fetch(const std::vector<PointBox>& wanted);

private:
  const BlockMesh& Whole;
  const Ranks& Others;
  BlockMesh Known;
  std::vector<std::shared_ptr<PointBoxes>> Fetched;
};

/// The points of a face in `range`, extended by `margin` points on the face, in `layers` layers from the face inwards.
PointBox pointsAtFace(const BlockMesh& mesh, int block, int face, const FaceRange& range, int layers, int margin = 0);

} // namespace bsv
