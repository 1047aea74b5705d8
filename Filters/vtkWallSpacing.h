// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkWallSpacing
 * @brief   flow conditions to boundary-layer thickness, y+ and the wall spacing c that reaches it
 *
 * Estimates the boundary layer along the wall of a hexahedral block mesh as that of a flat plate, and finds the wall
 * spacing c (p_1/3 = c p_0 + (1 - c) p_1) of each wall vertex with which the first cell of the converted and sampled
 * volume has a wanted height y+. vtkCatmullClarkToBSplineVolume takes c from the output.
 *
 * Input: a block mesh as for vtkCatmullClarkToBSplineVolume, with its wall and symmetry plane named.
 *
 * Output port 0: the mesh, a vtkPartitionedDataSetCollection. Blocks at the wall have the point arrays (double, NaN off
 * the wall) `WallSpacing`, `BoundaryLayerThickness`, `FirstCellHeight`, `YPlus`, `CellsInBoundaryLayer`.
 *
 * Output port 1: the wall as vtkPolyData, with these point arrays and
 * - `StreamwiseDistance`: x, along FlowDirection from the foremost point of the same boundary, at least MinimumDistance
 *   reference lengths;
 * - `SkinFriction`: c_f, no unit;
 * - `CellGrowth`: largest ratio of neighbouring sampled cells in the first two spans off the wall;
 * - `ReachingLevel` (int): smallest sampling level at which a c reaches the target within MaximumGrowth, or -1;
 * - `TargetAllowed` (unsigned char): 1 where that is so at Level.
 *
 * Formulas (Re_x = Re x / L; `Core/FlowConditions.h` names the books):
 *
 * | quantity | laminar | turbulent |
 * |---|---|---|
 * | thickness delta | 5 x / sqrt(Re_x) | 0.37 (x - x_0) / Re_x^0.2, x_0 the transition |
 * | skin friction c_f | 0.664 / sqrt(Re_x) | 0.0592 / Re_x^0.2 |
 * | range | 1e3 < Re_x < 5e5 | 5e5 < Re_x < 1e7 |
 *
 * y+ = y Re sqrt(c_f / 2) / L. `FirstCellHeight` is y, the length of the cell's edge off the wall;
 * `CellsInBoundaryLayer` counts sampled cells up to delta, the last one in part. Lengths are in the unit of the mesh.
 *
 * Output port 2: the verdict, a vtkTable with one row and the column `Text`, as ParaView shows it in the view.
 *
 * Field data of the first two outputs, one value each. Free stream of a perfect gas with gamma = 1.4, in SI units:
 * `ReferenceSoundSpeed` (m/s), `ReferenceVelocity` (m/s), `ReferenceViscosity` (Pa s), `ReferenceDensity` (kg/m^3),
 * `ReferencePressure` (Pa), `ReferenceConductivity` (W/(m K)), `ReferenceTime` (s). Coefficients of the Navier-Stokes
 * equations made dimensionless with density, velocity, length, temperature and viscosity of the free stream:
 * `ViscousCoefficient` 1/Re of the stresses, `HeatCoefficient` 1/((gamma - 1) M^2 Re Pr) of the heat flux,
 * `PressureCoefficient` p / (rho U^2) = 1/(gamma M^2).
 *
 * On several ranks each gives the blocks that it was given, and their part of the wall; counts, ranges and the report
 * are those of all.
 *
 * Where the target would need cells that grow faster than MaximumGrowth, c goes as far as they allow, and the report
 * says which level or how many layers would reach it. An empty input gives empty outputs; a mesh without a wall is an
 * error.
 *
 * @sa vtkCatmullClarkToBSplineVolume
 */
#ifndef vtkWallSpacing_h
#define vtkWallSpacing_h

#include "BSplineVolumeFiltersModule.h" // For export macro
#include "Data/BoundaryPatterns.h"      // For the names of the body
#include "vtkPartitionedDataSetCollectionAlgorithm.h"

#include <string> // For the report

class BSPLINEVOLUMEFILTERS_EXPORT vtkWallSpacing : public vtkPartitionedDataSetCollectionAlgorithm
{
public:
  static vtkWallSpacing* New();
  vtkTypeMacro(vtkWallSpacing, vtkPartitionedDataSetCollectionAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Re = rho U L / mu of the free stream. Range > 0, default 1e6.
   */
  vtkSetMacro(ReynoldsNumber, double);
  vtkGetMacro(ReynoldsNumber, double);
  ///@}

  ///@{
  /**
   * M = U / a of the free stream. Range > 0, default 0.2. The flat-plate formulas are those of incompressible flow.
   */
  vtkSetMacro(MachNumber, double);
  vtkGetMacro(MachNumber, double);
  ///@}

  ///@{
  /**
   * L of the Reynolds number, in the length unit of the mesh. Range > 0, default 1.
   */
  vtkSetMacro(ReferenceLength, double);
  vtkGetMacro(ReferenceLength, double);
  ///@}

  ///@{
  /**
   * Metres per length unit of the mesh; for the reference quantities alone. Range > 0, default 1.
   */
  vtkSetMacro(LengthUnit, double);
  vtkGetMacro(LengthUnit, double);
  ///@}

  ///@{
  /**
   * Static temperature of the free stream. Kelvin, > 0, default 288.15.
   */
  vtkSetMacro(Temperature, double);
  vtkGetMacro(Temperature, double);
  ///@}

  ///@{
  /**
   * Dynamic viscosity of the free stream. Pa s, >= 0, default 0: that of air by Sutherland's formula, valid from 100 K
   * to 1900 K.
   */
  vtkSetMacro(Viscosity, double);
  vtkGetMacro(Viscosity, double);
  ///@}

  ///@{
  /**
   * Pr = mu c_p / k. Range > 0, default 0.72 (air).
   */
  vtkSetMacro(PrandtlNumber, double);
  vtkGetMacro(PrandtlNumber, double);
  ///@}

  ///@{
  /**
   * Direction of the free stream, of any length but 0. Default (1, 0, 0).
   */
  vtkSetVector3Macro(FlowDirection, double);
  vtkGetVector3Macro(FlowDirection, double);
  ///@}

  ///@{
  /**
   * Distance from the foremost point at which the boundary layer turns turbulent, in the length unit of the mesh. Range
   * >= 0, default 0: turbulent everywhere.
   */
  vtkSetMacro(TransitionLocation, double);
  vtkGetMacro(TransitionLocation, double);
  ///@}

  ///@{
  /**
   * Nearer to the foremost point than this, in reference lengths, the formulas are taken at this distance: at 0 they
   * give no thickness and infinite friction. Range > 0, default 0.01.
   */
  vtkSetMacro(MinimumDistance, double);
  vtkGetMacro(MinimumDistance, double);
  ///@}

  ///@{
  /**
   * Wanted y+ of the first sampled cell. Range > 0, default 1.
   */
  vtkSetMacro(TargetYPlus, double);
  vtkGetMacro(TargetYPlus, double);
  ///@}

  ///@{
  /**
   * Sampling level at which the first cell shall have it. Range [0, 8], default 1.
   */
  vtkSetClampMacro(Level, int, 0, 8);
  vtkGetMacro(Level, int);
  ///@}

  ///@{
  /**
   * Largest ratio of neighbouring sampled cells off the wall. Range > 1, default 1.2.
   */
  vtkSetMacro(MaximumGrowth, double);
  vtkGetMacro(MaximumGrowth, double);
  ///@}

  ///@{
  /**
   * Names of the boundaries that form the wall. Case does not matter, `*` stands for any text and `?` for one
   * character. Default: wall*, bcwall*, body*, no*slip*, viscous*, solid*.
   */
  void AddBodyBoundary(const char* pattern);
  void ClearBodyBoundaries();
  int GetNumberOfBodyBoundaries() const { return static_cast<int>(this->BodyBoundaries.size()); }
  ///@}

  ///@{
  /**
   * Names of the boundaries that are symmetry planes, in the same way. Default: sym*, bcsym*.
   */
  void AddSymmetryBoundary(const char* pattern);
  void ClearSymmetryBoundaries();
  int GetNumberOfSymmetryBoundaries() const { return static_cast<int>(this->SymmetryBoundaries.size()); }
  ///@}

  ///@{
  /**
   * As in the conversion that follows: find creases by the angle (degrees, range [0, 180], default 30) at which the
   * outer boundary turns. Default off.
   */
  vtkSetMacro(UseCreaseAngle, bool);
  vtkGetMacro(UseCreaseAngle, bool);
  vtkBooleanMacro(UseCreaseAngle, bool);
  vtkSetMacro(CreaseAngle, double);
  vtkGetMacro(CreaseAngle, double);
  ///@}

  ///@{
  /**
   * What the last execution found.
   */
  vtkGetMacro(NumberOfWallPoints, vtkIdType);
  vtkGetMacro(NumberOfPointsOnTarget, vtkIdType);
  vtkGetVector2Macro(YPlusRange, double);
  vtkGetVector2Macro(WallSpacingRange, double);
  ///@}

  /**
   * All of it as a text: reference quantities, ranges on the wall, what lies outside the formulas' range.
   */
  const char* GetReport() const { return this->Report.c_str(); }

protected:
  vtkWallSpacing();
  ~vtkWallSpacing() override = default;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int FillOutputPortInformation(int port, vtkInformation* info) override;
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkWallSpacing(const vtkWallSpacing&) = delete;
  void operator=(const vtkWallSpacing&) = delete;

  double ReynoldsNumber = 1e6;
  double MachNumber = 0.2;
  double ReferenceLength = 1.0;
  double LengthUnit = 1.0;
  double Temperature = 288.15;
  double Viscosity = 0.0;
  double PrandtlNumber = 0.72;
  double FlowDirection[3] = { 1.0, 0.0, 0.0 };
  double TransitionLocation = 0.0;
  double MinimumDistance = 0.01;
  double TargetYPlus = 1.0;
  int Level = 1;
  double MaximumGrowth = 1.2;
  bsv::BoundaryPatterns BodyBoundaries = bsv::defaultBodyBoundaries();
  bsv::BoundaryPatterns SymmetryBoundaries = bsv::defaultSymmetryBoundaries();
  bool UseCreaseAngle = false;
  double CreaseAngle = 30.0;

  vtkIdType NumberOfWallPoints = 0;
  vtkIdType NumberOfPointsOnTarget = 0;
  double YPlusRange[2] = { 0.0, 0.0 };
  double WallSpacingRange[2] = { 0.0, 0.0 };
  std::string Report;
};

#endif
