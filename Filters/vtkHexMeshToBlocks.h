// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkHexMeshToBlocks
 * @brief   unstructured hexahedra to a multi-block mesh
 *
 * Finds the blocks of a mesh of hexahedra: its base complex. Inside the mesh four cells meet at a regular edge, on the
 * boundary up to two; the faces at all other edges start surfaces that go on, over regular edges to the opposite face,
 * until the boundary or a singular edge, and what they enclose is a grid. No tolerance is involved, and no numbering of
 * cells or points makes a difference: blocks, their order, origins and directions follow from the coordinates.
 *
 * Input (port 0): a vtkUnstructuredGrid of hexahedra or voxels, or a tree of them; structured grids count, too.
 * Hexahedra of higher order are used by their corners. Points at the same places are merged where faces meet. Vertices,
 * lines and triangles are ignored, other cells refused.
 *
 * Boundaries get names, in this order: `Boundaries` of structured grids; the cell array BoundaryArray of quadrilaterals
 * beside the hexahedra; the block names of leaves that hold quadrilaterals only, in the input or in the second input
 * (port 1, optional). Without any name boundaries are told apart by FeatureAngle.
 *
 * Output: one vtkStructuredGrid per block, with the point and cell arrays of the input, `OriginalPointIds` and
 * `OriginalCellIds`; field arrays `Interfaces`, `Boundaries` and `BoundaryNames` (HexBlockData.h).
 *
 * Refused, with the place: collapsed hexahedra, hanging nodes, points and edges at which cells meet without faces
 * between them, more than MaximumNumberOfBlocks blocks. A mesh without much block structure is a warning.
 *
 * On several ranks the first one makes the blocks and has them.
 *
 * @sa vtkCatmullClarkToBSplineVolume, which does the same with its defaults if its input is unstructured
 */
#ifndef vtkHexMeshToBlocks_h
#define vtkHexMeshToBlocks_h

#include "BSplineVolumeFiltersModule.h" // For export macro
#include "vtkPartitionedDataSetCollectionAlgorithm.h"

#include <string> // For the report

class BSPLINEVOLUMEFILTERS_EXPORT vtkHexMeshToBlocks : public vtkPartitionedDataSetCollectionAlgorithm
{
public:
  static vtkHexMeshToBlocks* New();
  vtkTypeMacro(vtkHexMeshToBlocks, vtkPartitionedDataSetCollectionAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /**
   * Optional surfaces whose block names become boundary names.
   */
  void SetBoundariesConnection(vtkAlgorithmOutput* output);

  ///@{
  /**
   * Cell array that names quadrilaterals of the input: its strings, or its name and its number. Default empty;
   * "None" is the same.
   */
  vtkSetMacro(BoundaryArray, std::string);
  vtkGetMacro(BoundaryArray, std::string);
  ///@}

  ///@{
  /**
   * Without names, block faces are one boundary where they turn by at most this at most of the mesh edges between
   * them. Degrees, range [0, 180], default 30.
   */
  vtkSetMacro(FeatureAngle, double);
  vtkGetMacro(FeatureAngle, double);
  ///@}

  ///@{
  /**
   * Let faces meet whose points have different numbers but lie at the same places. Default on.
   */
  vtkSetMacro(MergePoints, bool);
  vtkGetMacro(MergePoints, bool);
  vtkBooleanMacro(MergePoints, bool);
  ///@}

  ///@{
  /**
   * Points are at the same place if they are closer than this fraction of the shortest cell edge at either of them.
   * Range [0, 0.5), default 0.05.
   */
  vtkSetMacro(MatchTolerance, double);
  vtkGetMacro(MatchTolerance, double);
  ///@}

  ///@{
  /**
   * Join blocks to larger ones. A face may then meet parts of several others. Default off.
   */
  vtkSetMacro(MergeBlocks, bool);
  vtkGetMacro(MergeBlocks, bool);
  vtkBooleanMacro(MergeBlocks, bool);
  ///@}

  ///@{
  /**
   * More blocks are an error: a mesh made from tetrahedra has one block per cell. Range [1, ..), default 100000.
   */
  vtkSetMacro(MaximumNumberOfBlocks, int);
  vtkGetMacro(MaximumNumberOfBlocks, int);
  ///@}

  ///@{
  /**
   * What the last execution found.
   */
  vtkGetMacro(NumberOfHexahedra, vtkIdType);
  vtkGetMacro(NumberOfBlocks, int);
  vtkGetMacro(NumberOfSingularEdges, vtkIdType);
  ///@}

  /**
   * The same as a text of a few lines, with what was merged, left out and cut.
   */
  const char* GetReport() const { return this->Report.c_str(); }

protected:
  vtkHexMeshToBlocks();
  ~vtkHexMeshToBlocks() override = default;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkHexMeshToBlocks(const vtkHexMeshToBlocks&) = delete;
  void operator=(const vtkHexMeshToBlocks&) = delete;

  std::string BoundaryArray;
  double FeatureAngle = 30.0;
  bool MergePoints = true;
  double MatchTolerance = 0.05;
  bool MergeBlocks = false;
  int MaximumNumberOfBlocks = 100000;

  vtkIdType NumberOfHexahedra = 0;
  int NumberOfBlocks = 0;
  vtkIdType NumberOfSingularEdges = 0;
  std::string Report;
};

#endif
