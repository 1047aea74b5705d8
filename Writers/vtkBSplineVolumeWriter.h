// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkBSplineVolumeWriter
 * @brief   writes multi-block B-spline volumes exactly: for isogeometric programs, and as curved cells
 *
 * The extension of the file name decides:
 * - `mesh`: MFEM NURBS mesh v1.0;
 * - `xml`: G+Smo multi-patch with its interfaces and boundaries;
 * - `g2`: GoTools spline volumes (class 700); bodies of NURBS surfaces become spline surfaces (class 200), as by
 *   vtkNURBSSurfaceWriter;
 * - `msh`: Gmsh, text, curved hexahedra with physical names;
 * - `h5`: HOPR's mesh (FLEXI, PICLas, Trixi), curved hexahedra;
 * - `cgns`: unstructured CGNS with curved hexahedra.
 *
 * The first three hold any degrees and knots and rational volumes. The others have one hexahedron of CellOrder per knot
 * span, its nodes at equally spaced parameters: exact if no degree is higher than CellOrder and the volume is not
 * rational, else an interpolation, which a warning says. All cells are right-handed.
 *
 * What a format cannot hold is changed, and a warning says it: blocks that meet themselves are cut for MFEM,
 * left-handed blocks are written with u reversed for it, names are made legal. Names of boundaries are kept in all
 * formats but g2 (in MFEM's as comments that vtkBSplineVolumeReader reads), types in CGNS and HOPR.
 *
 * Input: a B-spline volume (BSplineVolumeData.h). Without the array `Interfaces`, faces of the same shape are the
 * interfaces.
 *
 * The file appears complete or not at all: after an error or an abort an old one is untouched, the error code is set
 * and Write() returns 0. Several ranks write text files together, each its blocks, at their places; to HDF5 files rank
 * 0 writes what the others send it, block by block.
 *
 * @sa vtkBSplineVolumeReader vtkQuadflowWriter
 */
#ifndef vtkBSplineVolumeWriter_h
#define vtkBSplineVolumeWriter_h

#include "BSplineVolumeWritersModule.h" // For export macro
#include "vtkWriter.h"

#include <string> // For the file name

class BSPLINEVOLUMEWRITERS_EXPORT vtkBSplineVolumeWriter : public vtkWriter
{
public:
  static vtkBSplineVolumeWriter* New();
  vtkTypeMacro(vtkBSplineVolumeWriter, vtkWriter);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  enum GmshVersionType
  {
    GMSH_2_2 = 0,
    GMSH_4_1
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
   * Order of curved hexahedra. Range [2, 3], default 3, which is exact for cubic volumes.
   */
  vtkSetClampMacro(CellOrder, int, 2, 3);
  vtkGetMacro(CellOrder, int);
  ///@}

  ///@{
  /**
   * Version of Gmsh's format; GMSH_4_1 by default. More programs read 2.2.
   */
  vtkSetClampMacro(GmshVersion, int, GMSH_2_2, GMSH_4_1);
  vtkGetMacro(GmshVersion, int);
  ///@}

  /**
   * As in vtkWriter. On several ranks an input that is missing on some of them is an error of all.
   */
  int Write() override;

protected:
  vtkBSplineVolumeWriter() = default;
  ~vtkBSplineVolumeWriter() override = default;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  void WriteData() override;

private:
  vtkBSplineVolumeWriter(const vtkBSplineVolumeWriter&) = delete;
  void operator=(const vtkBSplineVolumeWriter&) = delete;

  std::string FileName;
  int CellOrder = 3;
  int GmshVersion = GMSH_4_1;
};

#endif
