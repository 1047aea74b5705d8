// SPDX-License-Identifier: BSD-3-Clause
/// @file NURBSSurfaceData.h
/// Between VTK data objects and the core's view of a body of trimmed NURBS patches.
///
/// A body is a vtkPartitionedDataSetCollection with the assembly nodes `/body/patches/<name>`, one per patch, and
/// `/body/surface`. A patch is a vtkStructuredGrid of its control points (nu x nv x 1), u fastest, in double precision:
///
/// | array          | where | type   | values |
/// |----------------|-------|--------|--------|
/// | `Degree`       | field | int    | 2: degree in u and v, 1..25 |
/// | `KnotsU`, `KnotsV` | field | double | dimension + degree + 1, non-decreasing |
/// | `Weights`      | point | double | 1: weight, positive; the points are not multiplied by it. Optional: all 1 |
/// | `Reversed`     | field | int    | 1: not 0 if the outward normal is -(x_u x x_v). Optional: 0 |
/// | `TrimCurves`   | field | int    | 3 per curve: index of its loop, degree, number of control points. Optional:
/// untrimmed | | `TrimKnots`    | field | double | knots of all trimming curves, one after the other | | `TrimPoints`
/// | field | double | 3 per control point of all trimming curves: u, v, weight | | `Layer`        | field | string | 1:
/// layer of the file. Optional |
///
/// The curves of a loop follow each other and close it; the patch is what lies inside an odd number of loops. The
/// surface is a vtkPolyData of triangles with the point arrays
///
/// | array     | type   | values |
/// |-----------|--------|--------|
/// | `PatchId` | int    | index of the patch among the patches |
/// | `UV`      | double | 2: parameters on it |
/// | `Normals` | double | 3: unit normal, outward |
#pragma once

#include "BSplineVolumeFiltersModule.h"

#include "Body/NURBSSurface.h"
#include "Ranks/Ranks.h"

#include "vtkSmartPointer.h"

#include <array>
#include <string>
#include <vector>

class vtkDataObject;
class vtkPartitionedDataSetCollection;
class vtkPolyData;
class vtkStructuredGrid;

namespace bsv
{

/// The patches of a body: all structured grids of the input (a collection, a tree or one grid) that have the array
/// `Degree`, in their order; other data sets are passed over, but points of surfaces must be finite. Collective:
/// patches that only some ranks have are sent to the others; all have the same tree, or none.
/// @param ranks who shares the body; by default nobody.
/// @throws Error for arrays of the wrong type or size, what checkBodyPatch() refuses, and an input without patches.
BSPLINEVOLUMEFILTERS_EXPORT std::vector<BodyPatch> bodyPatches(vtkDataObject* input, const Ranks& ranks = Ranks());

/// A patch as a structured grid. An empty `layer` makes no array.
BSPLINEVOLUMEFILTERS_EXPORT vtkSmartPointer<vtkStructuredGrid> patchGrid(
  const BodyPatch& patch, const std::string& layer = {});

/// The tessellation as poly data: points, normals and arrays are evaluated on the patches.
/// @param vertexPatches,vertexParameters patch, and u and v, of every point.
/// @param triangles indices of points.
BSPLINEVOLUMEFILTERS_EXPORT vtkSmartPointer<vtkPolyData> bodySurface(const std::vector<BodyPatch>& patches,
  const std::vector<int>& vertexPatches, const std::vector<Vec2>& vertexParameters,
  const std::vector<std::array<int, 3>>& triangles, const Execution& run = {});

/// Fills `collection` with the patches and the surface, named and with the assembly. Names of assembly nodes are made
/// valid and unique; the true name is the node's attribute `label` and the name in the block's meta data.
BSPLINEVOLUMEFILTERS_EXPORT void setBody(vtkPartitionedDataSetCollection* collection,
  const std::vector<BodyPatch>& patches, const std::vector<std::string>& layers, vtkPolyData* surface);

} // namespace bsv
