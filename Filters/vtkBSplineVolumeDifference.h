// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkBSplineVolumeDifference
 * @brief   what changed between two B-spline volumes of the same blocks
 *
 * For volumes that differ in a rule, an option or a mesh whose points moved: where the wall and the control points
 * went, and which joins became smoother or rougher.
 *
 * Input port 0: a B-spline volume (BSplineVolumeData.h). Input port 1 (`Before`): the volume to compare it with: as
 * many blocks, with as many control points and the same degrees and knots each, on the same ranks; anything else is an
 * error that names the first block that differs.
 *
 * Output ports:
 * 0. `Wall`: vtkPartitionedDataSetCollection, per block that has a part of the wall one vtkPolyData of quadrilaterals,
 *    SamplesPerSpan parts of every span. The wall is that of the input: the boundaries that its conversion took, or
 *    those with a wall's name or type; without any, all outer faces. Point arrays `Displacement` (double, 3: from the
 *    place before) and `Moved` (double: its length), in the length unit of the mesh; `Normals`.
 * 1. `Control Points`: the input with the point arrays `Displacement` and `Moved` of its control points; without them
 *    where a block has other degrees or knots than before, which the report says.
 * 2. `Joins`: vtkTable, one row per interface and wall border, the largest change first; on the first rank. Columns in
 *    reading order: `1 Change (degrees)` of the layer jump (vtkBSplineVolumeSmoothness.h; of creases the normal jump),
 *    negative where the join became smoother, `2 Before (degrees)`, `3 After (degrees)`, `4 Blocks`, `5 Class Before`,
 *    `6 Class After` (JoinClass.h). A wall border that only one of the volumes has (its wall is larger) is left out.
 * 3. `Verdict`: vtkTable with one row and the column `Text`, as ParaView shows it in the view.
 *
 * Active scalars: `Moved`.
 */
#ifndef vtkBSplineVolumeDifference_h
#define vtkBSplineVolumeDifference_h

#include "BSplineVolumeFiltersModule.h" // For export macro
#include "vtkPartitionedDataSetCollectionAlgorithm.h"

#include <string> // For the report

class BSPLINEVOLUMEFILTERS_EXPORT vtkBSplineVolumeDifference : public vtkPartitionedDataSetCollectionAlgorithm
{
public:
  static vtkBSplineVolumeDifference* New();
  vtkTypeMacro(vtkBSplineVolumeDifference, vtkPartitionedDataSetCollectionAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /**
   * Connects the volume to compare with.
   */
  void SetBeforeConnection(vtkAlgorithmOutput* output);

  ///@{
  /**
   * Every span of the wall and of the joins is cut into this many parts per direction. Range [1, 16], default 3.
   */
  vtkSetClampMacro(SamplesPerSpan, int, 1, 16);
  vtkGetMacro(SamplesPerSpan, int);
  ///@}

  ///@{
  /**
   * A join is called smoother or rougher if its jump changed by more than this. Degrees, at least 0, default 0.01.
   */
  vtkSetClampMacro(LeastChange, double, 0.0, 180.0);
  vtkGetMacro(LeastChange, double);
  ///@}

  ///@{
  /**
   * Of the last execution: how far the wall, and the control points, moved at most, in the length unit of the mesh; how
   * many joins became smoother, rougher; how many are defects in either volume; and a text of a few lines.
   */
  vtkGetMacro(MaximumWallDisplacement, double);
  vtkGetMacro(MaximumDisplacement, double);
  vtkGetMacro(NumberOfSmootherJoins, int);
  vtkGetMacro(NumberOfRougherJoins, int);
  vtkGetMacro(NumberOfDefectsBefore, int);
  vtkGetMacro(NumberOfDefects, int);
  const char* GetReport() const { return this->Report.c_str(); }
  ///@}

protected:
  vtkBSplineVolumeDifference();
  ~vtkBSplineVolumeDifference() override = default;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int FillOutputPortInformation(int port, vtkInformation* info) override;
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkBSplineVolumeDifference(const vtkBSplineVolumeDifference&) = delete;
  void operator=(const vtkBSplineVolumeDifference&) = delete;

  int SamplesPerSpan = 3;
  double LeastChange = 0.01;

  double MaximumWallDisplacement = 0.0;
  double MaximumDisplacement = 0.0;
  int NumberOfSmootherJoins = 0;
  int NumberOfRougherJoins = 0;
  int NumberOfDefectsBefore = 0;
  int NumberOfDefects = 0;
  std::string Report;
};

#endif
