// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkQuadflowReader
 * @brief   reads the multi-block B-spline volumes that vtkQuadflowWriter writes (.qfmb)
 *
 * Reads the dialect that Writers/quadflow_format.md describes, from one file or from a topology file and the geometry
 * file that it names, and makes all its self-checks: every block face in exactly one interface or boundary, both sides
 * of an interface equal bit for bit, all ids, counts, classes and orientations consistent. Whatever is wrong ends in
 * one error that names file, line, block and face, sets the error code and leaves the output empty. Counts are compared
 * with the size of the file before memory is allocated.
 *
 * Output: a vtkPartitionedDataSetCollection with the names of the blocks and a flat assembly, one vtkStructuredGrid of
 * control points in double precision per block with the field data `Degree`, `KnotsU`, `KnotsV`, `KnotsW`; field data
 * of the collection: `Interfaces`, `Boundaries`, `BoundaryNames` (BSplineVolumeData.h). Points, knots, names,
 * interfaces and boundaries are those that were written, bit for bit.
 *
 * The blocks are shared out over the pieces that the pipeline asks for, which are the ranks of ParaView, by their
 * numbers of cells. Every piece has all partitioned data sets, names and field data of the collection, and its own
 * blocks; elsewhere a data set has no partition. Text of other pieces is passed over, binary numbers are not even read.
 * Control points of different pieces are compared if each rank reads the piece of its own number; a process that asks
 * for one piece alone compares what it has.
 */
#ifndef vtkQuadflowReader_h
#define vtkQuadflowReader_h

#include "BSplineVolumeReadersModule.h" // For export macro
#include "vtkFileSeriesSource.h"

#include <string> // For the file name

class BSPLINEVOLUMEREADERS_EXPORT vtkQuadflowReader : public vtkFileSeriesSource
{
public:
  static vtkQuadflowReader* New();
  vtkTypeMacro(vtkQuadflowReader, vtkFileSeriesSource);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /**
   * 1 if the file begins as a topology file, else 0.
   */
  static int CanReadFile(const char* fileName);

protected:
  vtkQuadflowReader();
  ~vtkQuadflowReader() override = default;

  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkQuadflowReader(const vtkQuadflowReader&) = delete;
  void operator=(const vtkQuadflowReader&) = delete;
};

#endif
