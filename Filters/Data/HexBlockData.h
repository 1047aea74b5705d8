// SPDX-License-Identifier: BSD-3-Clause
/// @file HexBlockData.h
/// Between VTK data objects and the core's view of a hexahedral block mesh.
///
/// A block mesh is any tree of vtkStructuredGrid (multi-block data sets, partitioned data set collections) or one
/// vtkStructuredGrid. Blocks are numbered by the flat order of the tree's leaves; a missing leaf keeps its number but
/// makes no block, and entries of the arrays below that name it are left out. What is known of the mesh is kept in
/// these field data arrays of the root, all optional:
///
/// - `Interfaces` (int, 12 components): blockA, faceA, blockB, faceB, orientation code, 1 if a range follows else 0,
///   sMin, sMax, tMin, tMax on face A, sMin, tMin on face B
/// - `Boundaries` (int, 3): block, face, tag; or 7, if any covers only part of its face: block, face, tag, sMin, sMax,
///   tMin, tMax
/// - `BoundaryNames` (string): the name of tag 0, 1, ..
/// - `BoundaryTypes` (string): what tag 0, 1, .. is, a type of CGNS such as BCWallViscous; one per name
/// - `CreaseEdges` (int, 7): block, i, j, k of the first and i, j, k of the last mesh point of a run along a grid line
///
/// Blocks bring the same with them (BlockTags.h), which is taken where these arrays do not count the blocks as they
/// are.
///
/// Faces, face axes and orientation codes are those of BlockTopology.h, ranges are mesh point indices from 0, both
/// ends included. The point array `CreaseSharpness` (1 component) becomes MeshBlock::creaseSharpness.
///
/// Of a mesh on several ranks each has the same tree, in which the leaves are missing that are on others; ranks without
/// any block may have an empty tree. A data set with several partitions may have them on different ranks.
#pragma once

#include "BSplineVolumeFiltersModule.h"

#include "Mesh/BlockMesh.h"
#include "Ranks/Ranks.h"

#include "vtkSmartPointer.h"

#include <string>
#include <vector>

class vtkDataObject;
class vtkDoubleArray;
class vtkFieldData;
class vtkPartitionedDataSetCollection;
class vtkStructuredGrid;

namespace bsv
{

/// A leaf of a tree of data sets; null if it is missing.
struct NamedLeaf
{
  vtkDataObject* data;
  /// Of the leaf or, if it has none, of the data set it is a partition of. May be empty.
  std::string name;
};

/// All leaves of a tree, or the one data set, in flat order.
BSPLINEVOLUMEFILTERS_EXPORT std::vector<NamedLeaf> namedLeaves(vtkDataObject* input);

/// The core's view of `input`. Surfaces beside blocks name their boundaries (SurfaceNames.h). Hexahedra that are not
/// structured, or partly hidden, become blocks first (HexMeshData.h); BlockMesh::notes and BlockMesh::warnings tell it.
/// Images and rectilinear grids are taken as structured grids, with points in double precision.
/// Points stored as x y z triples of float or double are not copied. Collective: the result has the blocks of all
/// ranks, with the points of those that are here.
///
/// A block that several ranks have belongs to the lowest of them. Field data are taken from the ranks that have them.
/// @param[out] grids the grid of every block of the result, in its order, null for those on other ranks. They own the
///   memory behind the result's views: keep them, and do not change their points, as long as the result is used. A grid
///   whose points had to be converted is a shallow copy of the input's.
/// @param run reports while hexahedra become blocks; its ranks share the mesh.
/// @throws Error for leaves that are no structured grids, blocks of fewer than 2 points in a direction, and arrays of
///   the wrong type or size or with entries out of range; for blocks and arrays that differ from rank to rank.
BSPLINEVOLUMEFILTERS_EXPORT BlockMesh blockMesh(
  vtkDataObject* input, std::vector<vtkSmartPointer<vtkStructuredGrid>>& grids, const Execution& run = {});

/// The same for structured grids only; hidden cells count as any others.
BSPLINEVOLUMEFILTERS_EXPORT BlockMesh structuredBlocks(
  vtkDataObject* input, std::vector<vtkSmartPointer<vtkStructuredGrid>>& grids, const Ranks& ranks = Ranks());

/// Point array `name` of a grid as doubles (not copied if it is a vtkDoubleArray), or null if there is none.
/// @throws Error naming `block` and the array if it is not numeric or has not that many components.
BSPLINEVOLUMEFILTERS_EXPORT vtkSmartPointer<vtkDoubleArray> doublePointArray(
  vtkStructuredGrid* grid, const char* name, int components, const std::string& block);

///@{
/// Write one array; an empty list removes it. `counts` are the mesh points per direction of every block, by which
/// partial ranges are told from whole faces.
BSPLINEVOLUMEFILTERS_EXPORT void setInterfaces(
  vtkFieldData* fields, const std::vector<Interface>& interfaces, const std::vector<Ijk>& counts);
BSPLINEVOLUMEFILTERS_EXPORT void setBoundaries(vtkFieldData* fields, const std::vector<BoundaryPatch>& boundaries,
  const std::vector<std::string>& names, const std::vector<Ijk>& counts, const std::vector<std::string>& types = {});
BSPLINEVOLUMEFILTERS_EXPORT void setCreases(vtkFieldData* fields, const std::vector<CreaseLine>& creases);
///@}

/// All of the above for a whole mesh.
BSPLINEVOLUMEFILTERS_EXPORT void setConnectivity(vtkFieldData* fields, const BlockMesh& mesh);

/// Grid of `counts` points per direction in double precision, not yet set.
/// @param[out] points their triples
BSPLINEVOLUMEFILTERS_EXPORT vtkSmartPointer<vtkStructuredGrid> blockGrid(const Ijk& counts, double*& points);

/// Name of an assembly node for a block, patch or part: what a node name cannot hold becomes an underscore.
BSPLINEVOLUMEFILTERS_EXPORT std::string nodeName(const std::string& name);

/// Makes `collection` hold one partitioned data set per block, named in its meta data and in a flat assembly with the
/// root node `root`. A null grid, of a block that is elsewhere, makes a data set without a partition.
BSPLINEVOLUMEFILTERS_EXPORT void setBlocks(vtkPartitionedDataSetCollection* collection,
  const std::vector<vtkSmartPointer<vtkStructuredGrid>>& grids, const std::vector<std::string>& names,
  const char* root);

} // namespace bsv
