// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkQuadflowWriter
 * @brief   writes multi-block B-spline volumes as a topology file (.qfmb)
 *
 * Text with the global vertices, edges and faces of the blocks, their interfaces, boundaries, knots and control points,
 * in the dialect that Writers/quadflow_format.md describes. It is a dialect of this project: no public sample of the
 * solver's own file was available, and compatibility with it is not claimed. Numbers are the shortest that read back to
 * the same double, or binary; vtkQuadflowReader gives back the same bits.
 *
 * Input: a B-spline volume with clamped knots (BSplineVolumeData.h): blocks with `Degree`, `KnotsU`, `KnotsV`,
 * `KnotsW`, optionally `ControlPointRule`, which tells crease and planar edges, and the root's field data `Interfaces`,
 * `Boundaries`, `BoundaryNames`. Without `Interfaces`, faces whose control points are equal bit for bit are the
 * interfaces.
 *
 * The file appears complete or not at all: it is written under a temporary name in the same folder and renamed at the
 * end. After an error (a volume that is not conforming, a full disk) or an abort an old file is untouched; the error
 * code is set and Write() returns 0.
 *
 * Several ranks write one file, the same as one rank would: each its own blocks, at their places in the file. All of
 * them must see the folder. An error of any is reported by the first, and all set the error code.
 */
#ifndef vtkQuadflowWriter_h
#define vtkQuadflowWriter_h

#include "BSplineVolumeWritersModule.h" // For export macro
#include "vtkWriter.h"

#include <string>  // For the file name
#include <utility> // For boundary ids
#include <vector>  // For boundary ids

class BSPLINEVOLUMEWRITERS_EXPORT vtkQuadflowWriter : public vtkWriter
{
public:
  static vtkQuadflowWriter* New();
  vtkTypeMacro(vtkQuadflowWriter, vtkWriter);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// How knots are written.
  enum KnotScalingType
  {
    INTEGER_KNOTS = 0, ///< as they are
    UNIT_KNOTS         ///< divided by their range
  };

  ///@{
  /**
   * The file to write.
   */
  vtkSetStdStringFromCharMacro(FileName);
  vtkGetCharFromStdStringMacro(FileName);
  ///@}

  ///@{
  /**
   * First id of vertices, edges, faces and blocks: 0 (default) or 1.
   */
  vtkSetClampMacro(IndexBase, int, 0, 1);
  vtkGetMacro(IndexBase, int);
  ///@}

  ///@{
  /**
   * How knots are written: INTEGER_KNOTS (default) as they are, UNIT_KNOTS divided by their range. Reading unit knots
   * multiplies them by the number of spans.
   */
  vtkSetClampMacro(KnotScaling, int, INTEGER_KNOTS, UNIT_KNOTS);
  vtkGetMacro(KnotScaling, int);
  ///@}

  ///@{
  /**
   * Write knots and control points to a second file, with the extension `bsp`. Default off.
   */
  vtkSetMacro(SeparateGeometry, bool);
  vtkGetMacro(SeparateGeometry, bool);
  vtkBooleanMacro(SeparateGeometry, bool);
  ///@}

  ///@{
  /**
   * Write control points as binary numbers, of this machine's byte order, between the lines of text: faster, and
   * smaller. Default off.
   */
  vtkSetMacro(Binary, bool);
  vtkGetMacro(Binary, bool);
  vtkBooleanMacro(Binary, bool);
  ///@}

  ///@{
  /**
   * Id of a boundary name, from 1. Names without one get the smallest free ids, in their order. Default: none.
   */
  void SetBoundaryId(const char* name, int id);
  void ClearBoundaryIds();
  int GetNumberOfBoundaryIds() const { return static_cast<int>(this->BoundaryIds.size()); }
  ///@}

  /**
   * As in vtkWriter. On several ranks an input that is missing on some of them is an error of all.
   */
  int Write() override;

protected:
  vtkQuadflowWriter() = default;
  ~vtkQuadflowWriter() override = default;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  void WriteData() override;

private:
  vtkQuadflowWriter(const vtkQuadflowWriter&) = delete;
  void operator=(const vtkQuadflowWriter&) = delete;

  std::string FileName;
  int IndexBase = 0;
  int KnotScaling = INTEGER_KNOTS;
  bool SeparateGeometry = false;
  bool Binary = false;
  std::vector<std::pair<std::string, int>> BoundaryIds;
};

#endif
