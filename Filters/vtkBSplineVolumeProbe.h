// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkBSplineVolumeProbe
 * @brief   block and parameters of given points in B-spline volumes, and what the volume is there
 *
 * Input 0: B-spline volumes (BSplineVolumeData.h) of any degrees and knots, rational or not. Input 1: a vtkDataSet
 * whose points are probed.
 *
 * Output: input 1 with point arrays
 * - `BlockId` (int): block that holds the point, the lowest where several do; -1 if none does;
 * - `UVW` (double, 3): parameters of its knots; 0 if no block holds it;
 * - `Distance` (double): of the volume at `UVW` from the point, in units of length; 0 if no block holds it;
 * - `Jacobian` (double): det(x_u, x_v, x_w) there, in cubed units of length per unit of the knots; 0 if no block does;
 * - with ComputeDerivatives `dXdU`, `dXdV`, `dXdW` (double, 3) there.
 *
 * VolumeLocator.h says how points are found. Each rank has the arrays of its own points; the volume is that of all
 * ranks. Arrays of input 1 of the same names are replaced. An empty volume holds no point. An input 1 that is missing
 * is an error.
 */
#ifndef vtkBSplineVolumeProbe_h
#define vtkBSplineVolumeProbe_h

#include "BSplineVolumeFiltersModule.h" // For export macro
#include "vtkDataSetAlgorithm.h"

#include <string> // For the report

class BSPLINEVOLUMEFILTERS_EXPORT vtkBSplineVolumeProbe : public vtkDataSetAlgorithm
{
public:
  static vtkBSplineVolumeProbe* New();
  vtkTypeMacro(vtkBSplineVolumeProbe, vtkDataSetAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /**
   * The points to probe: input port 1.
   */
  void SetPointsConnection(vtkAlgorithmOutput* output) { this->SetInputConnection(1, output); }

  ///@{
  /**
   * Largest distance at which a point counts as held, as a fraction of the diagonal of the volume; less than 1e-14 is
   * rounding, and taken as that. Range [0, 1], default 1e-12.
   */
  vtkSetClampMacro(Tolerance, double, 0.0, 1.0);
  vtkGetMacro(Tolerance, double);
  ///@}

  ///@{
  /**
   * Whether the arrays of first derivatives are made. Default off.
   */
  vtkSetMacro(ComputeDerivatives, vtkTypeBool);
  vtkGetMacro(ComputeDerivatives, vtkTypeBool);
  vtkBooleanMacro(ComputeDerivatives, vtkTypeBool);
  ///@}

  ///@{
  /**
   * What the last update found, over all ranks.
   */
  vtkGetMacro(NumberOfPoints, vtkIdType);
  vtkGetMacro(NumberOfPointsInside, vtkIdType);
  const char* GetReport() const { return this->Report.c_str(); }
  ///@}

protected:
  vtkBSplineVolumeProbe();
  ~vtkBSplineVolumeProbe() override = default;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestDataObject(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;
  int RequestInformation(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;
  int RequestUpdateExtent(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkBSplineVolumeProbe(const vtkBSplineVolumeProbe&) = delete;
  void operator=(const vtkBSplineVolumeProbe&) = delete;

  double Tolerance = 1e-12;
  vtkTypeBool ComputeDerivatives = 0;
  vtkIdType NumberOfPoints = 0;
  vtkIdType NumberOfPointsInside = 0;
  std::string Report;
};

#endif
