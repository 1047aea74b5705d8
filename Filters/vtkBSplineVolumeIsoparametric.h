// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkBSplineVolumeIsoparametric
 * @brief   surfaces and curves of constant parameters in B-spline volumes
 *
 * Input: B-spline volumes (BSplineVolumeData.h) of any degrees and knots, rational or not.
 *
 * Output: a vtkPolyData with, for every block on this rank,
 * - Surfaces: one surface per position, on which the parameter of Direction is constant, as quadrilaterals;
 * - Curves: one curve along Direction for every pair of positions of the two other directions, as polylines.
 * Every span is cut into 2^Level parts per direction; points lie on the volume exactly. Point array `UVW` (double, 3:
 * parameters of the knots); cell arrays `BlockId` (int), `Position` (double, 1 component, or 2 of curves, in the order
 * of the directions).
 *
 * An empty input gives an empty output.
 */
#ifndef vtkBSplineVolumeIsoparametric_h
#define vtkBSplineVolumeIsoparametric_h

#include "BSplineVolumeFiltersModule.h" // For export macro
#include "vtkPolyDataAlgorithm.h"

#include <vector> // For the positions

class BSPLINEVOLUMEFILTERS_EXPORT vtkBSplineVolumeIsoparametric : public vtkPolyDataAlgorithm
{
public:
  static vtkBSplineVolumeIsoparametric* New();
  vtkTypeMacro(vtkBSplineVolumeIsoparametric, vtkPolyDataAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  enum ShapeType
  {
    SURFACES = 0,
    CURVES = 1
  };

  enum DirectionType
  {
    U = 0,
    V = 1,
    W = 2
  };

  ///@{
  /**
   * What is made. Default SURFACES.
   */
  vtkSetClampMacro(Shape, int, SURFACES, CURVES);
  vtkGetMacro(Shape, int);
  ///@}

  ///@{
  /**
   * The direction that is constant on surfaces, along which curves run. Default W.
   */
  vtkSetClampMacro(Direction, int, U, W);
  vtkGetMacro(Direction, int);
  ///@}

  ///@{
  /**
   * Where, as fractions of the knots' range of each block: 0 its first face, 1 its last. Values outside 0..1 are an
   * error. Default: 0, 0.5 and 1.
   */
  void SetNumberOfPositions(int count);
  void SetPosition(int index, double value);
  int GetNumberOfPositions() const { return static_cast<int>(this->Positions.size()); }
  double GetPosition(int index) const { return this->Positions.at(index); }
  ///@}

  ///@{
  /**
   * Every span is cut into 2^Level parts. Range [0, 8], default 2.
   */
  vtkSetClampMacro(Level, int, 0, 8);
  vtkGetMacro(Level, int);
  ///@}

protected:
  vtkBSplineVolumeIsoparametric() = default;
  ~vtkBSplineVolumeIsoparametric() override = default;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkBSplineVolumeIsoparametric(const vtkBSplineVolumeIsoparametric&) = delete;
  void operator=(const vtkBSplineVolumeIsoparametric&) = delete;

  int Shape = SURFACES;
  int Direction = 2;
  std::vector<double> Positions{ 0.0, 0.5, 1.0 };
  int Level = 2;
};

#endif
