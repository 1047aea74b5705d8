// SPDX-License-Identifier: BSD-3-Clause
/// @file TreeLeaves.h
/// The blocks of a tree that ranks share, and the arrays of the mesh beside them: what HexBlockData.cxx is made of.
#pragma once

#include "Data/HexBlockData.h"

class vtkDataObject;
class vtkFieldData;

namespace bsv
{

/// Place of a block in the tree, the same on all ranks: the partitions of a data set can be on several of them.
struct Leaf
{
  vtkDataObject* data;
  std::string name;
  /// Number of the data set, and of the partition in it.
  int dataSet;
  int partition;
};

/// A block of the mesh, on all ranks.
struct SharedLeaf
{
  Ijk counts{ 0, 0, 0 };
  /// The lowest rank that has it, or -1 if it is missing everywhere.
  int rank = -1;
  /// May be empty.
  std::string name;
  /// The leaf of this rank's own tree, or null.
  const Leaf* own = nullptr;
};

/// Leaves in flat order, missing ones included. A leaf without a name has that of its parent: partitions have none.
std::vector<Leaf> leavesOf(vtkDataObject* input);

/// The same tree with images and rectilinear grids as structured grids, or `input` itself if it has none. May be null.
vtkSmartPointer<vtkDataObject> withExplicitPoints(vtkDataObject* input);

/// The name of a leaf, or one made of its place.
std::string blockName(const std::string& name, std::size_t leaf);

/// All leaves in flat order, from what every rank has. Collective.
std::vector<SharedLeaf> shareLeaves(const std::vector<Leaf>& leaves, const Ranks& ranks);

/// Contacts, boundaries and creases out of the arrays that any rank has in its field data. Collective.
/// @param mine may be null
/// @param blockOfLeaf block of the mesh per leaf, -1 if it is missing
void readConnectivity(vtkFieldData* mine, const std::vector<int>& blockOfLeaf, BlockMesh& mesh, const Ranks& ranks);

} // namespace bsv
