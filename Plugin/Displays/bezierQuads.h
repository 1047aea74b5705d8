// SPDX-License-Identifier: BSD-3-Clause
/**
 * Bezier quadrilaterals as flat ones, with exact normals: VTK's own subdivision takes ten times as long and has none.
 */
#ifndef bezierQuads_h
#define bezierQuads_h

#include "Base/Types.h"

#include "vtkSmartPointer.h"

class vtkPolyData;
class vtkUnstructuredGrid;

namespace bsv
{

struct BezierKinds
{
  Index others = 0; ///< cells that are no Bezier quadrilaterals
  int degree = 1;   ///< the largest of the quadrilaterals
};

BezierKinds bezierKinds(vtkUnstructuredGrid* grid);

/// `parts` x `parts` quadrilaterals per cell, parts >= 1. Point and cell arrays are those of the grid, interpolated as
/// the shape is; `Normals` go with the orientation of the cells; `SourcePoint` (the nearest Bezier point) and
/// `SourceCell` are ids of the grid, and edge flags mark the borders of the cells.
/// @param grid of Bezier quadrilaterals alone
/// @throws Aborted
vtkSmartPointer<vtkPolyData> bezierQuads(vtkUnstructuredGrid* grid, int parts, const Execution& run);

} // namespace bsv

#endif
