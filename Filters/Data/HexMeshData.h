// SPDX-License-Identifier: BSD-3-Clause
/// @file HexMeshData.h
/// From unstructured hexahedra in VTK data objects to a multi-block mesh (BaseComplex.h).
#pragma once

#include "BSplineVolumeFiltersModule.h"

#include "Complex/BaseComplex.h"

#include <string>
#include <vector>

class vtkDataObject;
class vtkPartitionedDataSetCollection;

namespace bsv
{

struct HexMeshOptions
{
  BaseComplexOptions complex;
  /// Cell array that names quadrilaterals: its strings, or its name and number. Empty: leaves of quadrilaterals have
  /// their own name, quadrilaterals beside hexahedra none.
  std::string boundaryArray;
};

struct HexMeshReport
{
  Index cells = 0;
  Index points = 0;
  Index blocks = 0;
  Index singularEdges = 0;
  std::vector<std::string> notes;
  std::vector<std::string> warnings;
};

/// Whether an input is no multi-block mesh as it is: it has leaves that are not structured, or hidden cells.
/// Not collective: it says what this rank sees.
BSPLINEVOLUMEFILTERS_EXPORT bool needsBlocks(vtkDataObject* input);

/// Makes the blocks of `input`: unstructured and structured grids, one or a tree of them. Hexahedra of higher order
/// count by their corners. Hidden cells and copies of cells of other ranks (`vtkGhostType`) are left out. Names come
/// from `Boundaries` of structured grids and from quadrilaterals: in the grids, in leaves of their own, and in
/// `surfaces`, which may be null.
///
/// The blocks have the point and cell arrays of the input that all of its leaves have, and the arrays
/// `OriginalPointIds` and `OriginalCellIds`, which count through the leaves. Of several ranks the first one gets the
/// blocks, without those arrays of the input.
/// @throws Error for other cells, and what baseComplex() refuses.
BSPLINEVOLUMEFILTERS_EXPORT HexMeshReport hexMeshToBlocks(vtkDataObject* input, vtkDataObject* surfaces,
  const HexMeshOptions& options, vtkPartitionedDataSetCollection* output, const Execution& run);

} // namespace bsv
