// SPDX-License-Identifier: BSD-3-Clause
/// @file MeshInput.h
/// What filters of meshes take: grids of hexahedra. They refuse B-spline volumes, whose control points are no points of
/// the mesh, and inputs without any block.
#pragma once

#include "Base/Types.h"
#include "Execution/FilterExecution.h"
#include "Mesh/BlockMesh.h"
#include "Ranks/Ranks.h"

#include "vtkFieldData.h"
#include "vtkSmartPointer.h"
#include "vtkStructuredGrid.h"

#include <algorithm>
#include <string>
#include <vector>

namespace bsv
{

/// For FillInputPortInformation().
inline void acceptMeshes(vtkInformation* port)
{
  port->Remove(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE());
  for (const char* type :
    { "vtkDataObjectTree", "vtkStructuredGrid", "vtkUnstructuredGrid", "vtkRectilinearGrid", "vtkImageData" })
  {
    port->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), type);
  }
}

/// @param any whether any rank has a block
/// @param notes, warnings what else is known of the input
/// @throws Error if not
inline void requireBlocks(bool any, const std::vector<std::string>& notes, const std::vector<std::string>& warnings)
{
  if (!any)
  {
    std::string text = "the input has no hexahedra";
    for (const std::vector<std::string>* sentences : { &notes, &warnings })
    {
      for (const std::string& sentence : *sentences)
      {
        text += "; " + sentence;
      }
    }
    throw Error(text);
  }
}

/// @param mesh as blockMesh() gives it
inline void requireBlocks(const BlockMesh& mesh)
{
  requireBlocks(!mesh.blocks.empty(), mesh.notes, mesh.warnings);
}

/// Collective.
/// @param grids the blocks of a mesh, null for those on other ranks
/// @param what the end of the sentence
/// @throws Error if any block has knots in three directions
inline void requireMesh(
  const std::vector<vtkSmartPointer<vtkStructuredGrid>>& grids, const Ranks& ranks, const std::string& what)
{
  if (ranks.any(std::any_of(grids.begin(), grids.end(), [](const vtkSmartPointer<vtkStructuredGrid>& grid) {
        return grid && grid->GetFieldData()->HasArray("KnotsW") != 0;
      })))
  {
    throw Error("Input is a B-spline volume already; " + what);
  }
}

} // namespace bsv
