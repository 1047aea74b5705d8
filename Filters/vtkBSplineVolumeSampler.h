// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkBSplineVolumeSampler
 * @brief   samples of multi-block B-spline volumes
 *
 * Evaluates every block on a structured grid: at level L every non-empty knot span is cut into 2^L parts, so that n
 * spans give n 2^L + 1 samples. Points that blocks share are equal bit for bit, in any relative orientation; the points
 * of level L are contained bit for bit in level L + 1.
 *
 * Refinement where it is needed: spans that face each other across interfaces form a class, and all spans of a class
 * are cut alike, so that the samples stay conforming, one structured grid per block. WallLevel and WallLayers refine
 * the classes next to walls in the direction off them, TangentialLevel those along walls, BlockLevels those of any
 * block; targets choose these levels: FirstCellHeight or TargetYPlus, and ChordError. The level of a class is the
 * largest that is asked for, and at least Level. All samples are bit for bit among those of the uniform level that is
 * the largest one. Wall Spacing's Level then means the level off the wall.
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
#include "Data/BoundaryPatterns.h"      // For the names of walls
#include "vtkPartitionedDataSetCollectionAlgorithm.h"

#include <array>  // For levels of blocks
#include <string> // For the report
#include <vector> // For levels of blocks

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

  ///@{
  /**
   * Level of the spans next to walls, in the direction off them, in WallLayers layers. Below Level it does nothing.
   * Ranges [0, 8] and >= 1, defaults 0 and 1.
   */
  vtkSetClampMacro(WallLevel, int, 0, 8);
  vtkGetMacro(WallLevel, int);
  vtkSetClampMacro(WallLayers, int, 1, VTK_INT_MAX);
  vtkGetMacro(WallLayers, int);
  ///@}

  ///@{
  /**
   * Level of the spans along walls. Below Level it does nothing. Range [0, 8], default 0.
   */
  vtkSetClampMacro(TangentialLevel, int, 0, 8);
  vtkGetMacro(TangentialLevel, int);
  ///@}

  ///@{
  /**
   * Target in place of WallLevel: each wall face gets the smallest level with which its first cells, at the knots, are
   * at most this high, in the unit of the mesh. Range >= 0, default 0: none.
   */
  vtkSetClampMacro(FirstCellHeight, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(FirstCellHeight, double);
  ///@}

  ///@{
  /**
   * The same target as y+ of the first cell, for a turbulent flat plate at the distance ReferenceLength, in the unit of
   * the mesh, at ReynoldsNumber (FlowConditions.h). Ranges >= 0, > 0, > 0; defaults 0 (none), 1e6, 1. The smaller one
   * counts if FirstCellHeight is given, too.
   */
  vtkSetClampMacro(TargetYPlus, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(TargetYPlus, double);
  vtkSetMacro(ReynoldsNumber, double);
  vtkGetMacro(ReynoldsNumber, double);
  vtkSetMacro(ReferenceLength, double);
  vtkGetMacro(ReferenceLength, double);
  ///@}

  ///@{
  /**
   * Target in place of TangentialLevel: spans along walls get the smallest level with which no chord between
   * neighbouring samples on the knot lines of the wall is farther from it than this, in the unit of the mesh. Range >=
   * 0, default 0: none.
   */
  vtkSetClampMacro(ChordError, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(ChordError, double);
  ///@}

  ///@{
  /**
   * Level of all spans of a block in one direction (0 u, 1 v, 2 w), and so of all that they face. Default: none.
   */
  void AddBlockLevel(int block, int direction, int level);
  void ClearBlockLevels();
  int GetNumberOfBlockLevels() const { return static_cast<int>(this->BlockLevels.size()); }
  ///@}

  ///@{
  /**
   * Names of the boundaries that are walls. Case does not matter, `*` stands for any text and `?` for one character.
   * Default: wall*, bcwall*, body*, no*slip*, viscous*, solid*.
   */
  void AddBodyBoundary(const char* pattern);
  void ClearBodyBoundaries();
  int GetNumberOfBodyBoundaries() const { return static_cast<int>(this->BodyBoundaries.size()); }
  ///@}

  /**
   * What the last execution chose, as a text: levels, classes, cells, heights of first cells.
   */
  const char* GetReport() const { return this->Report.c_str(); }

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
  int WallLevel = 0;
  int WallLayers = 1;
  int TangentialLevel = 0;
  double FirstCellHeight = 0.0;
  double TargetYPlus = 0.0;
  double ReynoldsNumber = 1e6;
  double ReferenceLength = 1.0;
  double ChordError = 0.0;
  std::vector<std::array<int, 3>> BlockLevels;
  bsv::BoundaryPatterns BodyBoundaries = bsv::defaultBodyBoundaries();
  std::string Report;
};

#endif
