// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkHexBlockMeshWriter
 * @brief   writes hexahedral multi-block meshes for flow solvers: structured CGNS, PLOT3D, OpenFOAM
 *
 * The extension of the file name decides:
 * - `cgns`: structured CGNS (HDF5): zones, 1-to-1 interfaces from both sides, boundary conditions with families and
 *   their types, the unit of length if it is known; it declares version 3.4 of the library, which older programs read;
 * - `xyz`, `x`, `p3d`: a multi-block PLOT3D grid, binary, text or Fortran unformatted, with or without iblank, and the
 *   interfaces and boundaries in a neutral map of the same name with the extension `nmf`;
 * - `foam`: an OpenFOAM case: constant/polyMesh in the folder of the file, and the file itself, which is empty and by
 *   which ParaView opens the case. Points that interfaces join are one point; a patch per boundary.
 *
 * Input: a block mesh (HexBlockData.h), such as the samples of a B-spline volume, or one vtkStructuredGrid. Interfaces
 * that are not in the array `Interfaces` are found from coincident points. Types of boundaries are those of the array
 * `BoundaryTypes`, else they follow from the names (typeOfBoundary() in Formats/MeshToWrite.h); what is in no interface
 * and no boundary is said in a warning. Points keep their precision: float or double. The point array `IBlank` of the
 * blocks (int) is written if the format holds it.
 *
 * Nested families: with Levels = n > 1 the mesh of every 2^(n-1)-th point, .., every second point, and the mesh itself
 * are written as NAME_level0, NAME_level1, .. (OpenFOAM: folders of these names), and a table NAME_levels.csv of their
 * numbers of blocks, points, cells, and first cell heights at boundaries of type BCWall*. Since samples of a level are
 * bit for bit among those of the next, the family of a volume is that of its samples. With ReynoldsNumber > 0 the table
 * has y+ of these heights, for a turbulent flat plate at the distance ReferenceLength (FlowConditions.h).
 *
 * All files appear complete or not at all: after an error or an abort old ones are untouched, the error code is set and
 * Write() returns 0. Several ranks write together, each its blocks, in PLOT3D and OpenFOAM files at their places; to
 * CGNS files rank 0 writes what the others send it, some layers at a time. The mesh is not copied.
 *
 * @sa vtkHexBlockMeshReader vtkBSplineVolumeSampler
 */
#ifndef vtkHexBlockMeshWriter_h
#define vtkHexBlockMeshWriter_h

#include "BSplineVolumeWritersModule.h" // For export macro
#include "vtkWriter.h"

#include <string> // For the file name

class BSPLINEVOLUMEWRITERS_EXPORT vtkHexBlockMeshWriter : public vtkWriter
{
public:
  static vtkHexBlockMeshWriter* New();
  vtkTypeMacro(vtkHexBlockMeshWriter, vtkWriter);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  enum EncodingType
  {
    ASCII = 0,
    BINARY,
    FORTRAN_UNFORMATTED ///< records between marks of 4 bytes; PLOT3D only
  };

  enum ByteOrderType
  {
    LITTLE_ENDIAN_ORDER = 0,
    BIG_ENDIAN_ORDER
  };

  enum IBlankType
  {
    AUTOMATIC_IBLANK = 0, ///< if all blocks have the point array `IBlank`
    WITHOUT_IBLANK,
    WITH_IBLANK ///< 1 where there is no array
  };

  enum LengthUnitType
  {
    UNKNOWN_UNIT = 0,
    METRE,
    CENTIMETRE,
    MILLIMETRE,
    INCH,
    FOOT
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
   * How PLOT3D and OpenFOAM files hold numbers: ASCII, BINARY (default) or FORTRAN_UNFORMATTED, which for OpenFOAM is
   * an error. Text has the shortest digits that read back to the same double.
   */
  vtkSetClampMacro(Encoding, int, ASCII, FORTRAN_UNFORMATTED);
  vtkGetMacro(Encoding, int);
  ///@}

  ///@{
  /**
   * Byte order of binary PLOT3D files; LITTLE_ENDIAN_ORDER by default.
   */
  vtkSetClampMacro(ByteOrder, int, LITTLE_ENDIAN_ORDER, BIG_ENDIAN_ORDER);
  vtkGetMacro(ByteOrder, int);
  ///@}

  ///@{
  /**
   * Whether PLOT3D files hold iblank values; AUTOMATIC_IBLANK by default.
   */
  vtkSetClampMacro(IBlank, int, AUTOMATIC_IBLANK, WITH_IBLANK);
  vtkGetMacro(IBlank, int);
  ///@}

  ///@{
  /**
   * Write a neutral map beside a PLOT3D file. Default on.
   */
  vtkSetMacro(NeutralMap, bool);
  vtkGetMacro(NeutralMap, bool);
  vtkBooleanMacro(NeutralMap, bool);
  ///@}

  ///@{
  /**
   * Number of nested meshes to write. Range [1, 10], default 1: the input alone.
   */
  vtkSetClampMacro(Levels, int, 1, 10);
  vtkGetMacro(Levels, int);
  ///@}

  ///@{
  /**
   * Unit of length that CGNS files declare; UNKNOWN_UNIT by default: none.
   */
  vtkSetClampMacro(LengthUnit, int, UNKNOWN_UNIT, FOOT);
  vtkGetMacro(LengthUnit, int);
  ///@}

  ///@{
  /**
   * Reynolds number of the free stream and the length that it refers to, in the unit of the mesh: for y+ in the table
   * of levels. Ranges >= 0 and > 0; defaults 0 (no y+) and 1.
   */
  vtkSetClampMacro(ReynoldsNumber, double, 0.0, VTK_DOUBLE_MAX);
  vtkGetMacro(ReynoldsNumber, double);
  vtkSetMacro(ReferenceLength, double);
  vtkGetMacro(ReferenceLength, double);
  ///@}

  /**
   * The table of levels that was written last, comma-separated; empty before, and with one level.
   */
  vtkGetCharFromStdStringMacro(LevelTable);

  /**
   * As in vtkWriter. On several ranks an input that is missing on some of them is an error of all.
   */
  int Write() override;

protected:
  vtkHexBlockMeshWriter() = default;
  ~vtkHexBlockMeshWriter() override = default;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  void WriteData() override;

private:
  vtkHexBlockMeshWriter(const vtkHexBlockMeshWriter&) = delete;
  void operator=(const vtkHexBlockMeshWriter&) = delete;

  std::string FileName;
  int Encoding = BINARY;
  int ByteOrder = LITTLE_ENDIAN_ORDER;
  int IBlank = AUTOMATIC_IBLANK;
  bool NeutralMap = true;
  int Levels = 1;
  int LengthUnit = UNKNOWN_UNIT;
  double ReynoldsNumber = 0.0;
  double ReferenceLength = 1.0;
  std::string LevelTable;
};

#endif
