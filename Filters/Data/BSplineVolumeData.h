// SPDX-License-Identifier: BSD-3-Clause
/// @file BSplineVolumeData.h
/// Between VTK data objects and the core's view of a multi-block B-spline volume.
///
/// A volume is a tree of vtkStructuredGrid, or one vtkStructuredGrid, whose points are the control points of a block, i
/// fastest. Blocks are numbered and named as in HexBlockData.h. Arrays of a block:
///
/// | array              | where | type    | values |
/// |--------------------|-------|---------|--------|
/// | `Degree`           | field | int     | 3: degree per direction, 1..MaxDegree |
/// | `KnotsU`, `KnotsV`, `KnotsW` | field | double | dimension + degree + 1, non-decreasing |
/// | `Weights`          | point | double  | optional: one positive weight, rational volume |
/// | `ControlPointRule` | point | unsigned char | optional: bsv::ControlPointRule |
///
/// The root's field data holds `Interfaces`, `Boundaries` and `BoundaryNames` as in HexBlockData.h; every entry must
/// span whole faces. Of a volume on several ranks each has the same tree, as there.
#pragma once

#include "BSplineVolumeFiltersModule.h"

#include "Mesh/BlockMesh.h"
#include "Ranks/Ranks.h"
#include "Volume/BSplineVolume.h"

#include "vtkSmartPointer.h"

#include <string>
#include <vector>

class vtkDataObject;
class vtkDoubleArray;
class vtkPartitionedDataSetCollection;
class vtkStructuredGrid;

namespace bsv
{

/// The core's view of a volume: all blocks, with the points of those that are on this rank. It may point into the
/// grids: keep them, and do not change their points.
struct BSplineVolumeBlocks
{
  /// Null for blocks on other ranks.
  std::vector<vtkSmartPointer<vtkStructuredGrid>> grids;
  /// The rank that has a block.
  std::vector<int> ranks;
  std::vector<std::string> names;
  /// Degree and knots of all blocks; points and weights are null for blocks on other ranks.
  std::vector<BSplineVolume> volumes;
  /// Whether a block has weights.
  std::vector<char> rational;
  /// The memory behind weights that had to be converted; null otherwise.
  std::vector<vtkSmartPointer<vtkDoubleArray>> weights;
  /// One code per control point, or null; null for blocks on other ranks.
  std::vector<const unsigned char*> rules;

  /// Classes of the twelve edges of a block (QuadflowEdgeClass), or null: field array `EdgeClasses` (unsigned char).
  std::vector<const unsigned char*> edgeClasses;

  /// Whether the input of any rank has the array `Interfaces`. Ranges count control points.
  bool hasInterfaces = false;
  std::vector<Interface> interfaces;
  std::vector<BoundaryPatch> boundaries;
  std::vector<std::string> boundaryNames;
  /// BlockMesh::boundaryTypes.
  std::vector<std::string> boundaryTypes;

  /// Whether the points of a block are on this rank.
  bool isHere(std::size_t block) const { return this->grids[block] != nullptr; }

  /// The first block that is rational, or -1.
  int firstRational() const;

  /// Where a message is about this block: "block 3 'wing'".
  std::string label(std::size_t block) const
  {
    return "block " + std::to_string(block) + " '" + this->names[block] + "'";
  }
};

/// Points in double precision are not copied. Collective; by default nobody shares the volume.
/// @throws Error for what blockMesh() refuses, missing arrays, arrays of the wrong type or size, knots that
/// checkBSplineVolume() refuses, and interfaces or boundaries that cover only part of a face.
BSPLINEVOLUMEFILTERS_EXPORT BSplineVolumeBlocks bsplineVolumeBlocks(vtkDataObject* input, const Ranks& ranks = Ranks());

/// @throws Error if there is no block on any rank
inline void requireVolumes(const BSplineVolumeBlocks& blocks, const char* input = "the input")
{
  if (blocks.volumes.empty())
  {
    throw Error(std::string(input) + " is empty: it has no B-spline volume");
  }
}

/// Writes degree and knots of a block to its field data.
BSPLINEVOLUMEFILTERS_EXPORT void setDegreeAndKnots(vtkStructuredGrid* grid, const BSplineVolume& volume);

/// Writes the whole-face interfaces and boundaries to the collection's field data.
BSPLINEVOLUMEFILTERS_EXPORT void setWholeFaceContacts(vtkPartitionedDataSetCollection* collection,
  const std::vector<Interface>& interfaces, const std::vector<BoundaryPatch>& boundaries,
  const std::vector<std::string>& boundaryNames, const std::vector<std::string>& boundaryTypes = {});

} // namespace bsv
