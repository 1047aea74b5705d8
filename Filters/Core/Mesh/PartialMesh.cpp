// SPDX-License-Identifier: BSD-3-Clause
#include "Mesh/PartialMesh.h"

#include <algorithm>

namespace bsv
{

PartialMesh::PartialMesh(const BlockMesh& mesh, const Ranks& ranks)
  : Whole(mesh)
  , Others(ranks)
{
  if (ranks.size() == 1)
  {
    return;
  }
  for (const MeshBlock& block : mesh.blocks)
  {
    this->Known.blocks.push_back({ block.points, block.rank, block.name, {} });
  }
  this->Known.interfaces = mesh.interfaces;
  this->Known.boundaries = mesh.boundaries;
  this->Known.boundaryNames = mesh.boundaryNames;
  this->Known.boundaryTypes = mesh.boundaryTypes;
  this->Known.notes = mesh.notes;
  this->Known.warnings = mesh.warnings;
  this->Known.creases = mesh.creases;
}

void PartialMesh::fetch(const std::vector<PointBox>& wanted)
{
  if (this->Others.size() == 1)
  {
    return;
  }
  this->Fetched = fetchPoints(
    wanted, static_cast<int>(this->Known.blocks.size()), [this](int block) { return this->rankOf(block); },
    [this](int block) -> GridView& { return this->Known.blocks[block].points; }, this->Others);
}

PointBox pointsAtFace(const BlockMesh& mesh, int block, int face, const FaceRange& range, int layers, int margin)
{
  const Ijk& counts = mesh.blocks[block].points.counts();
  PointBox box;
  box.block = block;
  const int normal = faceDirection(face);
  const int inwards = std::min(layers, counts[normal]) - 1;
  box.lo[normal] = faceSide(face) ? counts[normal] - 1 - inwards : 0;
  box.hi[normal] = box.lo[normal] + inwards;
  for (int axis = 0; axis < 2; ++axis)
  {
    const int d = faceAxis(face, axis);
    box.lo[d] = std::max(range.lo[axis] - margin, 0);
    box.hi[d] = std::min(range.hi[axis] + margin, counts[d] - 1);
  }
  return box;
}

} // namespace bsv
