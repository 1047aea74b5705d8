// SPDX-License-Identifier: BSD-3-Clause
/// @file BlockTags.h
/// Connectivity that travels with its blocks.
///
/// The arrays of a mesh (HexBlockData.h) count its blocks, but ParaView's filters extract, reorder, cut and group
/// blocks and pass these arrays on as they were. So every block keeps what belongs to it in field arrays of its own:
///
/// - `BlockKey` (string): the same for no other block of any mesh; `BlockDimensions` (int, 3): its points per direction
/// - `BlockInterfaces` (int, 9): face, range sMin, sMax, tMin, tMax, the other block's face, sMin, tMin there, and the
///   orientation code; `BlockInterfaceKeys` (string): the other blocks. Each contact is with one of its two blocks.
/// - `BlockBoundaries` (int, 5): face, range; `BlockBoundaryNames`, `BlockBoundaryTypes` (strings)
/// - `BlockCreases` (int, 6): i, j, k of the first and of the last mesh point
/// - `BlockFirstPoint`: number of its first point, and the point array `MeshPointIds` from there on: where in the block
///   each point was, through Extract Subset with or without sampling, Reflect, and what makes it unstructured
///
/// and the mesh has `MeshBlockKeys` (string) and, unless it is a volume, `MeshBlockDimensions` (int, 3), which tell
/// whether its blocks are still those that its arrays count. If so the arrays of the mesh are taken, else those of the
/// blocks.
#pragma once

#include "BSplineVolumeFiltersModule.h"

#include "Mesh/BlockMesh.h"
#include "Ranks/Ranks.h"

#include "vtkSmartPointer.h"

#include <string>
#include <vector>

class vtkDataSet;
class vtkFieldData;
class vtkPartitionedDataSetCollection;
class vtkStructuredGrid;

namespace bsv
{

/// Gives every block of `collection`, which are those of `mesh`, its own connectivity. Not collective.
/// @param source what makes the mesh different from others of the same structure: a file, or a name.
/// @param numberPoints whether blocks get `MeshPointIds`; without, only whole blocks keep their connectivity.
BSPLINEVOLUMEFILTERS_EXPORT void tagBlocks(vtkPartitionedDataSetCollection* collection, const BlockMesh& mesh,
  const std::string& source, bool numberPoints = true);

/// Removes what tells that the blocks of a mesh are those that its arrays count: of arrays that are written anew.
BSPLINEVOLUMEFILTERS_EXPORT void removeMeshKeys(vtkFieldData* fields);

/// Whether the arrays of a mesh, as far as it has them, count its blocks as they are. Collective.
/// @param grids per block of `mesh`, null on other ranks
BSPLINEVOLUMEFILTERS_EXPORT bool arraysFitBlocks(vtkFieldData* fields, const BlockMesh& mesh,
  const std::vector<vtkSmartPointer<vtkStructuredGrid>>& grids, const Ranks& ranks);

/// Gives `mesh`, which has blocks only, the contacts, boundaries and creases that its blocks bring with them, and a
/// note that says what was kept and what was not. Collective.
BSPLINEVOLUMEFILTERS_EXPORT void takeTags(
  BlockMesh& mesh, const std::vector<vtkSmartPointer<vtkStructuredGrid>>& grids, const Ranks& ranks);

/// The named boundaries of blocks that became unstructured, found by `MeshPointIds`.
class BSPLINEVOLUMEFILTERS_EXPORT FormerBoundaries
{
public:
  /// @param mesh fields of the whole mesh. @param grid one of its grids, which may have fields of its own.
  FormerBoundaries(vtkFieldData* mesh, vtkDataSet* grid);

  bool empty() const { return this->Patches.empty(); }
  /// Name and type of the boundary that a quadrilateral lay on; null if on none.
  struct Name
  {
    std::string name;
    std::string type;
  };
  /// One per part of a boundary.
  const std::vector<Name>& names() const { return this->Patches; }
  const Name* find(const std::array<Index, 4>& meshPointIds) const;

private:
  void addPatch(int block, int face, const FaceRange& range, const std::string& name, const std::string& type);
  void addContacts(vtkFieldData* mesh);
  void addMergedPoints(vtkDataSet* grid);
  const Name* findIn(int block, const std::array<Index, 4>& meshPointIds) const;
  /// Block and place of a point; the block -1 if there is none.
  std::pair<int, Ijk> placeOf(Index meshPointId) const;
  Index idAt(int block, const Ijk& p) const;
  /// All numbers that a point has in the blocks that meet there.
  std::vector<Index> copies(Index meshPointId) const;

  struct Patch
  {
    int face;
    FaceRange range;
    std::size_t name;
  };
  /// Number of the first point, and points per direction, of each block.
  std::vector<Index> First;
  std::vector<Ijk> Counts;
  std::vector<std::vector<Patch>> OfBlock;
  /// The contacts of each block, seen from it.
  std::vector<std::vector<Interface>> Contacts;
  /// Numbers of one point in two blocks, from both sides, ascending: of contacts that nobody declared.
  std::vector<std::pair<Index, Index>> Merged;
  std::vector<Name> Patches;
};

} // namespace bsv
