// SPDX-License-Identifier: BSD-3-Clause
/// @file MeshInput.h
/// Filters of meshes refuse B-spline volumes: control points are no points of the mesh.
#pragma once

#include "Base/Types.h"
#include "Ranks/Ranks.h"

#include "vtkFieldData.h"
#include "vtkSmartPointer.h"
#include "vtkStructuredGrid.h"

#include <algorithm>
#include <string>
#include <vector>

namespace bsv
{

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
