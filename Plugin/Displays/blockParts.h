// SPDX-License-Identifier: BSD-3-Clause
/**
 * What is worth seeing of a block mesh, a B-spline volume or a block complex: the wall as a surface, nets of other
 * boundaries as lines, extraordinary curves, creases and singular nodes. Everything else, the skins of the blocks among
 * it, is left out, so that the cost of drawing is that of the wall.
 */
#ifndef blockParts_h
#define blockParts_h

#include "Base/Types.h"

#include "vtkDataObjectTree.h"
#include "vtkPolyData.h"
#include "vtkSmartPointer.h"

#include <array>
#include <functional>
#include <string>
#include <vector>

class vtkDataObject;
class vtkPolyData;

namespace bsv
{

struct BlockPartsOptions
{
  bool wall = true;
  /// So many cells off the wall is the surface; where a block is thinner, at its opposite side.
  int layer = 0;
  /// Lines along the knots of a volume's wall; the net of a mesh is drawn as the edges of its surface.
  bool wallNet = false;
  bool symmetryNet = true;
  bool farFieldNet = false;
  bool blockEdges = false;
  bool extraordinaryCurves = true;
  bool creases = true;
  /// Whether meshes, too, get normals, so that they seem smooth.
  bool meshNormals = false;
  /// Parts per span of a volume, or 0: as many as keep the surface small.
  int subdivision = 0;
  /// Lines end at this distance from the wall, as a fraction of the diagonal of the wall's box; 0: they do not end.
  double reach = 0.3;
};

struct BlockParts
{
  /// The surfaces: a tree like that of the input, the same on all ranks, with a vtkPolyData for every block that has
  /// any. Point arrays are those of the input (of volumes those of the nearest control point), `Normals` (of volumes,
  /// exact, and with meshNormals of meshes) and, of volumes, `MeanCurvature` and `GaussianCurvature`; cell array
  /// `Boundary`, an index into BoundaryNames or -1. `SourcePoint` and `SourceCell` are the points and cells of the
  /// input's block.
  vtkSmartPointer<vtkDataObject> surfaces;
  /// Nets and edges of blocks, all in one colour.
  vtkSmartPointer<vtkPolyData> nets;
  /// Extraordinary curves and creases as lines, singular nodes as vertices, with the cell array `Colors` (RGB).
  vtkSmartPointer<vtkPolyData> curves;
  /// What the colours of the curves mean, the same on all ranks.
  struct Entry
  {
    std::string text;
    std::array<double, 3> color;
  };
  std::vector<Entry> legend;
  bool isVolume = false;
  /// How the surfaces were chosen: the walls by their names, the outer faces around a hole, or all outer faces.
  std::string wallText;
};

/// A tree of the same structure and names with surfaceOf(leaf) in place of each leaf; null leaves the place empty.
vtkSmartPointer<vtkDataObjectTree> withLeaves(
  vtkDataObjectTree* tree, const std::function<vtkSmartPointer<vtkPolyData>(vtkDataObject*)>& surfaceOf);

/// Collective. What is wrong with the input is not told here but by the filters: of blocks that do not fit together all
/// faces are shown that are not known to meet another one, without curves; of anything else, nothing.
BlockParts blockParts(vtkDataObject* input, const BlockPartsOptions& options, const Execution& run);

} // namespace bsv

#endif
