// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkBSplineVolumeSampler
 * @brief   samples of multi-block B-spline volumes
 *
 * Evaluates every block on a structured grid: at level L every non-empty knot span is cut into 2^L parts, so that n
 * spans give n 2^L + 1 samples. Points that blocks share are equal bit for bit, in any relative orientation; the points
 * of level L are contained bit for bit in level L + 1.
 *
 * Input: a B-spline volume, that is a tree of vtkStructuredGrid of control points, or one of them, with the field
 * arrays `Degree`, `KnotsU`, `KnotsV`, `KnotsW` (BSplineVolumeData.h). Any degree from 1 to 8 and any knots.
 *
 * Output: a vtkPartitionedDataSetCollection with the names of the blocks and a flat assembly, one vtkStructuredGrid in
 * double precision per block. Point data if ComputeDerivatives is on: `dXdU`, `dXdV`, `dXdW` (double, 3 components),
 * the first derivatives with respect to the knots' parameters (with integer knots: per span); where a derivative jumps
 * at a knot, the mean of its two sides. Field data of the collection: `Interfaces`, `Boundaries`, `BoundaryNames` of
 * the input.
 *
 * Several ranks each have the samples of their blocks, and the data sets, without partition, of all others.
 *
 * An empty input gives an empty output. A block that is no B-spline volume, or more samples than can be held, is an
 * error that names the block; the output is then empty.
 */
#ifndef vtkBSplineVolumeSampler_h
#define vtkBSplineVolumeSampler_h

#include "BSplineVolumeFiltersModule.h" // For export macro
#include "vtkPartitionedDataSetCollectionAlgorithm.h"

class BSPLINEVOLUMEFILTERS_EXPORT vtkBSplineVolumeSampler : public vtkPartitionedDataSetCollectionAlgorithm
{
public:
  static vtkBSplineVolumeSampler* New();
  vtkTypeMacro(vtkBSplineVolumeSampler, vtkPartitionedDataSetCollectionAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Every span is cut into 2^Level parts. Range [0, 8], default 1. Each level more needs eight times the memory.
   */
  vtkSetClampMacro(Level, int, 0, 8);
  vtkGetMacro(Level, int);
  ///@}

  ///@{
  /**
   * Add the point arrays `dXdU`, `dXdV`, `dXdW`. Default off.
   */
  vtkSetMacro(ComputeDerivatives, bool);
  vtkGetMacro(ComputeDerivatives, bool);
  vtkBooleanMacro(ComputeDerivatives, bool);
  ///@}

protected:
  vtkBSplineVolumeSampler() = default;
  ~vtkBSplineVolumeSampler() override = default;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkBSplineVolumeSampler(const vtkBSplineVolumeSampler&) = delete;
  void operator=(const vtkBSplineVolumeSampler&) = delete;

  int Level = 1;
  bool ComputeDerivatives = false;
};

#endif
