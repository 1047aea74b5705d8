// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkBSplineVolumeToBezier
 * @brief   multi-block B-spline volumes as exact Bezier cells
 *
 * Every non-empty knot span becomes one VTK_BEZIER_HEXAHEDRON with the degrees of its block, rational if the volume is:
 * the same polynomial or rational, not an approximation. Or only faces are written, as VTK_BEZIER_QUADRILATERAL. Points
 * are shared between the cells of a block and between blocks, so that the grid is connected: a viewer then draws the
 * outer skin only. Blocks share the points of a face that the input's array `Interfaces` declares, or, without that
 * array, of faces that are equal; points further apart than rounding (1e-14 of the largest coordinate) stay apart, so
 * that a gap is seen.
 *
 * ParaView draws the cells as flat quadrilaterals unless the display property "Nonlinear Subdivision Level" is raised.
 *
 * Input: a B-spline volume, that is a tree of vtkStructuredGrid of control points, or one of them, in the arrays of
 * BSplineVolumeData.h. Any degree from 1 to 8 per direction and any knots, also repeated and unclamped ones.
 *
 * Output: one vtkUnstructuredGrid in double precision.
 * - cell data `HigherOrderDegrees` (double, 3: degrees along the cell's own axes; 0 is the third of a quadrilateral),
 *   which the cells need; `BlockId` (int); `SpanId` (int, 3: number of the non-empty span in i, j, k of the block);
 *   with faces also `FaceId` (int, 0..5: i=0, i=I, j=0, ..)
 * - point data `RationalWeights` (double), which the cells need, if any block is rational
 * - field data `BlockNames` (string): the name of block 0, 1, ..
 *
 * Hexahedra have the axes of their block. Quadrilaterals of right-handed blocks face outward.
 *
 * Several ranks each have the cells of their blocks, or of the faces of their blocks. Points at the borders between
 * ranks are on all of these, with the same bits as on one rank.
 *
 * An empty input gives an empty output. A block that is no B-spline volume, or more than this machine can hold, is an
 * error; the output is then empty.
 *
 * The method and its source: BezierExtraction.h.
 */
#ifndef vtkBSplineVolumeToBezier_h
#define vtkBSplineVolumeToBezier_h

#include "BSplineVolumeFiltersModule.h" // For export macro
#include "vtkUnstructuredGridAlgorithm.h"

class BSPLINEVOLUMEFILTERS_EXPORT vtkBSplineVolumeToBezier : public vtkUnstructuredGridAlgorithm
{
public:
  static vtkBSplineVolumeToBezier* New();
  vtkTypeMacro(vtkBSplineVolumeToBezier, vtkUnstructuredGridAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  enum CellsType
  {
    VOLUME = 0,
    OUTER_FACES,
    ALL_FACES,
    WALL
  };

  ///@{
  /**
   * Which cells are made: hexahedra of all spans (VOLUME), quadrilaterals of the faces that meet no other
   * (OUTER_FACES), of all block faces, those at which two blocks meet once, from the first of them (ALL_FACES), or of
   * the faces of the wall (WALL): as the conversion took it, else by the usual names of walls; OUTER_FACES if there is
   * none. Default: VOLUME.
   */
  vtkSetClampMacro(Cells, int, VOLUME, WALL);
  vtkGetMacro(Cells, int);
  ///@}

protected:
  vtkBSplineVolumeToBezier() = default;
  ~vtkBSplineVolumeToBezier() override = default;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkBSplineVolumeToBezier(const vtkBSplineVolumeToBezier&) = delete;
  void operator=(const vtkBSplineVolumeToBezier&) = delete;

  int Cells = VOLUME;
};

#endif
