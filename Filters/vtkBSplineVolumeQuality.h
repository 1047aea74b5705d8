// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkBSplineVolumeQuality
 * @brief   validity of every span of B-spline volumes, proven, and measures of its shape
 *
 * Input: B-spline volumes (BSplineVolumeData.h) of any degrees and knots, rational or not.
 *
 * Output 0: a vtkPartitionedDataSetCollection with one vtkStructuredGrid per block, the points at the knots: its cells
 * are the block's non-empty spans. Cell arrays:
 * - `Validity` (unsigned char): 0 valid, det J > 0 on the whole span; 1 invalid, det J <= 0 at a known point of it; 2
 *   undecided, because det J is zero somewhere up to rounding or MaximumDepth does not suffice. 0 and 1 are proofs: all
 *   rounding errors are bounded. J is the derivative with respect to the span's parameters in [0, 1];
 * - `MinJacobian`, `MaxJacobian` (double): certified bounds of det J on the span, in cubed length units;
 * - `ScaledJacobian` (double): smallest det J / (|x_u| |x_v| |x_w|) at the span's corners and centre, -1 to 1, best 1;
 * - `Skewness` (double): equiangle skew there, 0 to 1, best 0;
 * - `AspectRatio` (double): longest through shortest of the span's three sizes, best 1; 0 if a size is 0;
 * - `GrowthRatio` (double, 3 components u, v, w): size of the span in that direction against its two neighbours there,
 *   larger through smaller, the worse of both; inside the block and across interfaces whose two faces have the same
 *   spans. Interfaces are those of the field data, or are found by the shape of the faces if there are none. 1 without
 *   neighbours, 0 if a size is 0;
 * - `FirstCellHeight` (double): thickness of spans on a wall, normal to it, in length units: the wall distance of the
 *   first sampled point. Walls are the block faces whose boundary names fit BodyBoundaries; 0 elsewhere.
 *
 * JacobianBounds.h and SpanShape.h give formulas and sources. For given control points all arrays are the same for any
 * numbering of the blocks, orientation and number of threads, apart from the sign of what a reflection turns over.
 *
 * Field data of the collection: `ValidityNames` (string), `ValidSpans`, `InvalidSpans`, `UndecidedSpans` (vtkIdType,
 * one value per block), `MinimumJacobian`, `MinimumScaledJacobian` (double, one value per block), the
 * `Interfaces`, and `Boundaries` and `BoundaryNames` of the input.
 *
 * Output 1: a vtkPolyData, one vertex per invalid span (at most a million per block) at a point where det J <= 0. Point
 * arrays: `BlockId` (int), `Span` (int, 3: the cell of output 0), `UVW` (double, 3: parameters of the knots) and
 * `Jacobian` (double), a certified upper bound of det J there.
 *
 * Output 2 (`Findings`): a vtkPolyData, the six sides of every span that is not proven valid, between straight edges.
 * Cell arrays: `Validity`, `BlockId`, `Span`.
 * Output 3 (`Verdict`): a vtkTable with one row and the column `Text`, as ParaView shows it in the view.
 *
 * Several ranks each have the spans, findings and witnesses of their blocks; all have the field data and the totals of
 * all.
 *
 * A block with det J < 0 in more than half of its spans is left-handed. It is judged by its own sign: det J and the
 * scaled Jacobian are multiplied by -1. One warning counts and names such blocks. An empty input gives empty outputs.
 */
#ifndef vtkBSplineVolumeQuality_h
#define vtkBSplineVolumeQuality_h

#include "BSplineVolumeFiltersModule.h" // For export macro
#include "Data/BoundaryPatterns.h"      // For the names of the walls
#include "vtkPartitionedDataSetCollectionAlgorithm.h"

#include <string> // For the report

class BSPLINEVOLUMEFILTERS_EXPORT vtkBSplineVolumeQuality : public vtkPartitionedDataSetCollectionAlgorithm
{
public:
  static vtkBSplineVolumeQuality* New();
  vtkTypeMacro(vtkBSplineVolumeQuality, vtkPartitionedDataSetCollectionAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Undecided spans are halved, in one direction at a time, at most so many times in a row. Range [0, 48], default 24.
   */
  vtkSetClampMacro(MaximumDepth, int, 0, 48);
  vtkGetMacro(MaximumDepth, int);
  ///@}

  ///@{
  /**
   * Names of the boundaries that are walls, for FirstCellHeight. Case does not matter, `*` stands for any text and `?`
   * for one character. Default: wall*, bcwall*, body*, no*slip*, viscous*, solid*.
   */
  void AddBodyBoundary(const char* pattern);
  void ClearBodyBoundaries();
  int GetNumberOfBodyBoundaries() const { return static_cast<int>(this->BodyBoundaries.size()); }
  const char* GetBodyBoundary(int index) const;
  ///@}

  ///@{
  /**
   * What the last update found, over all blocks. WorstBlock is the number of the block with the smallest MinJacobian,
   * -1 without any; the minima are 0 without any.
   */
  vtkGetMacro(NumberOfSpans, vtkIdType);
  vtkGetMacro(NumberOfValidSpans, vtkIdType);
  vtkGetMacro(NumberOfInvalidSpans, vtkIdType);
  vtkGetMacro(NumberOfUndecidedSpans, vtkIdType);
  vtkGetMacro(NumberOfLeftHandedBlocks, int);
  vtkGetMacro(MinimumJacobian, double);
  vtkGetMacro(MinimumScaledJacobian, double);
  vtkGetMacro(WorstBlock, int);
  const char* GetReport() const { return this->Report.c_str(); }
  ///@}

protected:
  vtkBSplineVolumeQuality();
  ~vtkBSplineVolumeQuality() override = default;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int FillOutputPortInformation(int port, vtkInformation* info) override;
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkBSplineVolumeQuality(const vtkBSplineVolumeQuality&) = delete;
  void operator=(const vtkBSplineVolumeQuality&) = delete;

  bsv::BoundaryPatterns BodyBoundaries = bsv::defaultBodyBoundaries();
  int MaximumDepth = 24;

  vtkIdType NumberOfSpans = 0;
  vtkIdType NumberOfValidSpans = 0;
  vtkIdType NumberOfInvalidSpans = 0;
  vtkIdType NumberOfUndecidedSpans = 0;
  int NumberOfLeftHandedBlocks = 0;
  double MinimumJacobian = 0.0;
  double MinimumScaledJacobian = 0.0;
  int WorstBlock = -1;
  std::string Report;
};

#endif
