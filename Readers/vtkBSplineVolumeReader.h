// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkBSplineVolumeReader
 * @brief   reads B-spline volumes from GoTools .g2 files and MFEM NURBS meshes
 *
 * - GoTools `.g2`: all spline volumes (class 700), polynomial and rational. Objects of other classes are left out; a
 *   warning names and counts them.
 * - `MFEM NURBS mesh v1.0` of hexahedral patches, in both of its forms: with control points per patch (`patches`), and
 *   with knot vectors on the edges and control points numbered over the mesh (`knotvectors`). Other versions,
 *   non-conforming patches (`NC-patch mesh`), curves and surfaces are refused.
 *
 * Degrees are 1 to 8 and may differ between directions and blocks; knots are those of the file, inner ones repeated up
 * to `degree` times.
 *
 * Output: a vtkPartitionedDataSetCollection with a flat assembly, one vtkStructuredGrid of control points in double
 * precision per volume (`Volume n`) or patch (`Patch n`), in the arrays of BSplineVolumeData.h: `Degree`, `KnotsU`,
 * `KnotsV`, `KnotsW` and, if any weight of the file is not 1, `Weights` on all blocks. From an MFEM mesh also the int
 * field array `Attribute` (1 value: MFEM's attribute of the patch) on each block, and on the collection `Interfaces`
 * (patches with a common face), `Boundaries` and `BoundaryNames` (`boundary <attribute>`).
 *
 * A file that is damaged or holds no volume ends in one error that names the file and the line, with the error code set
 * and the output empty.
 *
 * The blocks are shared out over the pieces that the pipeline asks for, which are the ranks of ParaView, by their
 * numbers of control points (distributeBlocks() in Ranks.h). Every piece has all partitioned data sets, names and field
 * data of the collection, and its own blocks; elsewhere a data set has no partition. The whole text is read for every
 * piece: where a block begins in it is not known before.
 */
#ifndef vtkBSplineVolumeReader_h
#define vtkBSplineVolumeReader_h

#include "BSplineVolumeReadersModule.h" // For export macro
#include "vtkFileSeriesSource.h"

#include <string> // For the file name

class BSPLINEVOLUMEREADERS_EXPORT vtkBSplineVolumeReader : public vtkFileSeriesSource
{
public:
  static vtkBSplineVolumeReader* New();
  vtkTypeMacro(vtkBSplineVolumeReader, vtkFileSeriesSource);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * What was found: format, numbers of blocks and of those with unequal weights, and what was left out. Set by the last
   * update.
   */
  vtkGetCharFromStdStringMacro(Format);
  vtkGetMacro(NumberOfBlocks, int);
  vtkGetMacro(NumberOfRationalBlocks, int);
  vtkGetCharFromStdStringMacro(NotRead);
  ///@}

  /**
   * 1 if the file is a .g2 file with a spline volume or an MFEM NURBS mesh (of any kind, also one that is refused when
   * it is read), else 0.
   */
  static int CanReadFile(const char* fileName);

protected:
  vtkBSplineVolumeReader();
  ~vtkBSplineVolumeReader() override = default;

  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkBSplineVolumeReader(const vtkBSplineVolumeReader&) = delete;
  void operator=(const vtkBSplineVolumeReader&) = delete;

  std::string Format;
  int NumberOfBlocks = 0;
  int NumberOfRationalBlocks = 0;
  std::string NotRead;
};

#endif
