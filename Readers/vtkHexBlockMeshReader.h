// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkHexBlockMeshReader
 * @brief   reads hexahedral multi-block meshes from PLOT3D and CGNS files
 *
 * The kind of the file is found from its contents, never from its name:
 * - PLOT3D grids, three-dimensional, of one or many blocks: ASCII (Fortran list-directed, with repeats such as `2*65`
 *   and commas), raw binary and Fortran unformatted (record markers of 4 or 8 bytes), both byte orders, float or
 *   double, with or without iblank. The layout that explains the size of the file is taken; Format, ByteOrder,
 *   Precision and IBlank override what is found. A neutral map file (`.nmf`, also `.xyz.nmf`) of the same name beside
 *   it tells contacts and boundary conditions.
 * - CGNS (ADF and HDF5): all structured zones of cell dimension 3 with their 1-to-1 interfaces and boundary conditions,
 *   and unstructured zones of hexahedra, with the quadrilaterals of their boundary conditions.
 *
 * Output: a vtkPartitionedDataSetCollection, one vtkStructuredGrid per block, named like the CGNS zone or
 * `block 1`, `block 2`, .. in its meta data and in the data assembly. Points are float or double, as in the file
 * (ASCII: double). An unstructured zone is one vtkUnstructuredGrid of hexahedra, and one of quadrilaterals per boundary
 * with its name, and with its type in the field array `BoundaryType`; the filters make blocks of them
 * (vtkHexMeshToBlocks). Field data of the collection, each array only if the file tells it (exact layout:
 * HexBlockData.h):
 * - `Interfaces` (int, 12): contacts of block faces; their points were found to coincide;
 * - `Boundaries` (int, 3 or 7) and `BoundaryNames` (string): TYPE of the neutral map, or the CGNS family, else the
 *   condition's own name, or its type if the name is but a number. CGNS contacts marked periodic make the boundary
 *   `Periodic`;
 * - `BoundaryTypes` (string): the CGNS type of the condition or else of its family, or what the word of a neutral map
 *   stands for; `BCTypeUserDefined` where it is not known.
 *
 * Point data: `IBlank` (int) if a PLOT3D file has it; the cells of blanked points are hidden (`vtkGhostType`).
 *
 * What the mesh does not need and contradicts it is left out with a warning that names it: boundaries on interfaces, on
 * others, inside or outside of their block; CGNS bases of other dimensions. CGNS files are read in a process of their
 * own, so that no damaged file ends this one.
 *
 * Whatever else is wrong with a file ends in one error that names file, block, line or offset and value, sets the error
 * code and leaves the output empty. Sizes are checked against the file before memory is allocated.
 *
 * Several files are the steps of a series (vtkFileSeriesSource); a step of PLOT3D without a neutral map of its own has
 * that of the first. A CGNS file has the times of its BaseIterativeData_t; where ZoneIterativeData_t names
 * GridCoordinates_t per step, each step has its own coordinates. Names and contacts are those of the file in all steps.
 *
 * The blocks are shared out over the pieces that the pipeline asks for, which are the ranks of ParaView, by their
 * numbers of points (distributeBlocks() in Ranks.h). Every piece has all partitioned data sets, names and field data,
 * and the points of its own blocks; elsewhere a data set has no partition. Of a binary PLOT3D or a CGNS file a piece
 * reads only its own blocks; of an ASCII file it keeps only these. The points of contacts between pieces are compared
 * if each rank reads the piece of its own number; a process that asks for one piece alone compares what it has.
 *
 * Sources: PLOT3D User's Manual, NASA TM-101067 (1990); W. T. Jones, The Neutral Map File, NASA Langley GEOLAB; CGNS
 * Standard Interface Data Structures, https://cgns.github.io. Not read: two-dimensional and whole-plane PLOT3D files,
 * function and solution files, CGNS zones of other elements than hexahedra, general CGNS connectivity.
 *
 * @sa vtkHexBlockTopology vtkCatmullClarkToBSplineVolume
 */
#ifndef vtkHexBlockMeshReader_h
#define vtkHexBlockMeshReader_h

#include "BSplineVolumeReadersModule.h" // For export macro
#include "vtkFileSeriesSource.h"

#include <string> // For the file names

class BSPLINEVOLUMEREADERS_EXPORT vtkHexBlockMeshReader : public vtkFileSeriesSource
{
public:
  static vtkHexBlockMeshReader* New();
  vtkTypeMacro(vtkHexBlockMeshReader, vtkFileSeriesSource);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /// How a PLOT3D file is stored.
  enum FormatType
  {
    AUTOMATIC_FORMAT = 0,
    ASCII,
    RAW_BINARY,
    FORTRAN_UNFORMATTED,
    FORTRAN_UNFORMATTED_64 ///< record markers of 8 bytes
  };

  enum ByteOrderType
  {
    AUTOMATIC_BYTE_ORDER = 0,
    LITTLE_ENDIAN_ORDER,
    BIG_ENDIAN_ORDER
  };

  enum PrecisionType
  {
    AUTOMATIC_PRECISION = 0,
    FLOAT_PRECISION,
    DOUBLE_PRECISION
  };

  enum IBlankType
  {
    AUTOMATIC_IBLANK = 0,
    WITHOUT_IBLANK,
    WITH_IBLANK
  };

  ///@{
  /**
   * Whether a neutral map file is read beside a PLOT3D file: NeutralMapFile, or else the file with the name of the grid
   * file and the extension `nmf`, if there is one. On by default.
   */
  vtkSetMacro(UseNeutralMap, bool);
  vtkGetMacro(UseNeutralMap, bool);
  vtkBooleanMacro(UseNeutralMap, bool);
  ///@}

  ///@{
  /**
   * The neutral map file of a PLOT3D file. Empty by default: see UseNeutralMap.
   */
  vtkSetStdStringFromCharMacro(NeutralMapFile);
  vtkGetCharFromStdStringMacro(NeutralMapFile);
  ///@}

  ///@{
  /**
   * How a PLOT3D file is stored; AUTOMATIC_FORMAT by default.
   */
  vtkSetClampMacro(Format, int, AUTOMATIC_FORMAT, FORTRAN_UNFORMATTED_64);
  vtkGetMacro(Format, int);
  ///@}

  ///@{
  /**
   * Byte order of a binary PLOT3D file; AUTOMATIC_BYTE_ORDER by default.
   */
  vtkSetClampMacro(ByteOrder, int, AUTOMATIC_BYTE_ORDER, BIG_ENDIAN_ORDER);
  vtkGetMacro(ByteOrder, int);
  ///@}

  ///@{
  /**
   * Type of the coordinates of a binary PLOT3D file; AUTOMATIC_PRECISION by default.
   */
  vtkSetClampMacro(Precision, int, AUTOMATIC_PRECISION, DOUBLE_PRECISION);
  vtkGetMacro(Precision, int);
  ///@}

  ///@{
  /**
   * Whether a PLOT3D file holds iblank values; AUTOMATIC_IBLANK by default.
   */
  vtkSetClampMacro(IBlank, int, AUTOMATIC_IBLANK, WITH_IBLANK);
  vtkGetMacro(IBlank, int);
  ///@}

  /**
   * What the file was read as, for the user: such as "PLOT3D, Fortran unformatted, little-endian, double, without
   * iblank". Empty until a file was read.
   */
  vtkGetCharFromStdStringMacro(FileLayout);

  /**
   * 1 if the start of the file is that of a CGNS or PLOT3D file, else 0.
   */
  static int CanReadFile(const char* fileName);

protected:
  vtkHexBlockMeshReader();
  ~vtkHexBlockMeshReader() override = default;

  std::vector<double> TimesIn(const std::string& fileName) override;
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkHexBlockMeshReader(const vtkHexBlockMeshReader&) = delete;
  void operator=(const vtkHexBlockMeshReader&) = delete;

  bool UseNeutralMap = true;
  std::string NeutralMapFile;
  int Format = AUTOMATIC_FORMAT;
  int ByteOrder = AUTOMATIC_BYTE_ORDER;
  int Precision = AUTOMATIC_PRECISION;
  int IBlank = AUTOMATIC_IBLANK;
  std::string FileLayout;
};

#endif
