// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkWingFuselageSource
 * @brief   half model of a wing and a fuselage: a mesh of 79 blocks and the NURBS body inside
 *
 * x points downstream, y along the span, z up; the symmetry plane is y = 0. The fuselage is 6 long, 1 in diameter.
 *
 * Output port 0 (`Mesh`): a hexahedral block mesh (HexBlockData.h) in double precision. Blocks 0..39 are the mesh
 * around the body, four from each of its nine patches, and the blocks ahead and behind, which complete a cuboid; 40..58
 * are attached to the faces of the cuboid and extend it to the far field; 59..78 touch the cuboid by an edge or a
 * corner only (WingFuselageMesh.h). The wall is a Catmull-Clark control mesh whose B-spline surface passes through
 * points of the body. Field data: `Interfaces`, `Boundaries`, `BoundaryNames` (`wall_fuselage`, `wall_wing`,
 * `symmetry`, `farfield`) and `CreaseEdges`: the junction of wing and fuselage, the two edges of the trailing edge, and
 * the rim of the tip but for its leading edge.
 *
 * Output port 1 (`Body`): the body as nine bicubic B-spline patches and their tessellation (NURBSSurfaceData.h).
 *
 * All scaled Jacobians are positive in the ranges below, but for Resolution 2, which is too low for long and highly
 * swept wings: an error. With n = Resolution the wall has 26 n^2 cells; time and memory are proportional to the points.
 *
 * The blocks are shared out over the pieces that the pipeline asks for, which are the ranks of ParaView, by their
 * numbers of points (distributeBlocks() in Ranks.h). Every piece has all partitioned data sets, names and field data,
 * and the points of its own blocks; elsewhere a data set has no partition. The surface of the body is computed for
 * every piece, and every piece has the whole body.
 *
 * Properties that do not go together, or more points than the machine can hold, are an error; the outputs are then
 * empty.
 */
#ifndef vtkWingFuselageSource_h
#define vtkWingFuselageSource_h

#include "BSplineVolumeFiltersModule.h" // For export macro
#include "vtkPartitionedDataSetCollectionAlgorithm.h"

class BSPLINEVOLUMEFILTERS_EXPORT vtkWingFuselageSource : public vtkPartitionedDataSetCollectionAlgorithm
{
public:
  static vtkWingFuselageSource* New();
  vtkTypeMacro(vtkWingFuselageSource, vtkPartitionedDataSetCollectionAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Cells across the leading edge and the nose; twice as many along the chord and the fuselage, three times along the
   * span. Range [2, 96], default 8. With the other defaults 2 gives 10 thousand points, 8 114 thousand, 20 one million,
   * 44 ten million and 76 fifty million.
   */
  vtkSetMacro(Resolution, int);
  vtkGetMacro(Resolution, int);
  ///@}

  ///@{
  /**
   * Distance of the wing tip from the symmetry plane. Range [2, 6], default 3.5.
   */
  vtkSetMacro(Span, double);
  vtkGetMacro(Span, double);
  ///@}

  ///@{
  /**
   * Sweep of the line through the quarter chords, in degrees. Range [0, 45], default 25.
   */
  vtkSetMacro(SweepAngle, double);
  vtkGetMacro(SweepAngle, double);
  ///@}

  ///@{
  /**
   * Distance of the outer boundary from the cuboid around the body. Range [2, 1000], default 15.
   */
  vtkSetMacro(FarFieldDistance, double);
  vtkGetMacro(FarFieldDistance, double);
  ///@}

  ///@{
  /**
   * Height of the first layer of cells at the wall. Range [1e-7, 0.1], and at most 2 / Resolution; default 0.01.
   */
  vtkSetMacro(FirstLayerHeight, double);
  vtkGetMacro(FirstLayerHeight, double);
  ///@}

  ///@{
  /**
   * Largest ratio of the heights of successive layers at the wall. Range [1.02, 2], default 1.2.
   */
  vtkSetMacro(GrowthRatio, double);
  vtkGetMacro(GrowthRatio, double);
  ///@}

  ///@{
  /**
   * Of the last mesh that was made: points of all blocks, and the smallest scaled Jacobian over all corners of all
   * cells (of a piece that one process asked for alone: of its own blocks).
   */
  vtkGetMacro(NumberOfMeshPoints, vtkIdType);
  vtkGetMacro(MinimumScaledJacobian, double);
  ///@}

protected:
  vtkWingFuselageSource();
  ~vtkWingFuselageSource() override = default;

  int RequestInformation(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;
  int RequestUpdateExtent(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkWingFuselageSource(const vtkWingFuselageSource&) = delete;
  void operator=(const vtkWingFuselageSource&) = delete;

  int Resolution = 8;
  double Span = 3.5;
  double SweepAngle = 25.0;
  double FarFieldDistance = 15.0;
  double FirstLayerHeight = 0.01;
  double GrowthRatio = 1.2;
  vtkIdType NumberOfMeshPoints = 0;
  double MinimumScaledJacobian = 0.0;
};

#endif
