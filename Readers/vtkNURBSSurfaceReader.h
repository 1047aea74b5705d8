// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkNURBSSurfaceReader
 * @brief   reads trimmed NURBS surfaces from IGES, STEP, BREP and GoTools .g2 files
 *
 * IGES, STEP and BREP are read through OpenCASCADE, if the reader was built with it; `.g2` (spline surfaces, class 200)
 * always. B-spline surfaces keep their control points, weights and knots bit for bit, up to the scaling between units;
 * planes, cylinders, cones, spheres, tori, surfaces of revolution and of extrusion become NURBS exactly. Faces keep
 * their trimming curves. A curve in the parameters of a surface that had to be converted is carried over to the new
 * parameters, to 1e-12 of their range. A face bounded by the sides of its surface counts as untrimmed. Offset surfaces
 * have no exact NURBS form; they are approximated, which a warning says.
 *
 * Output: a vtkPartitionedDataSetCollection with the assembly `/body/patches/<name>` and `/body/surface`, in
 * the arrays of NURBSSurfaceData.h. Patches have the names of the file's faces, or `Face n` without one; IGES levels
 * and STEP layers become the field array `Layer` of a patch. Field data of the collection: the strings `Format`,
 * `DeclaredUnit`, `LengthUnit`, and `NotRead` with the names of what the file holds besides surfaces, beside the int
 * array `NotReadCount`; a warning says the same.
 *
 * OpenCASCADE runs in a process of its own, so that no damaged file ends this one. Surfaces that the file hides (IGES
 * blank status, STEP invisibility) are left out and counted, as are entities that cannot be read and on which no face
 * depends.
 *
 * A file that is damaged or holds no surface ends in one error that names the file (and the line, where the format has
 * lines), with the error code set and the output empty.
 *
 * With several ranks every rank reads the whole body: any part of a mesh may need any part of it.
 */
#ifndef vtkNURBSSurfaceReader_h
#define vtkNURBSSurfaceReader_h

#include "BSplineVolumeReadersModule.h" // For export macro
#include "vtkFileSeriesSource.h"

#include <string> // For the file name

class BSPLINEVOLUMEREADERS_EXPORT vtkNURBSSurfaceReader : public vtkFileSeriesSource
{
public:
  static vtkNURBSSurfaceReader* New();
  vtkTypeMacro(vtkNURBSSurfaceReader, vtkFileSeriesSource);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /**
   * Units of length. The first value means: the one the file declares.
   */
  enum LengthUnitType
  {
    AS_IN_FILE = 0,
    AS_DECLARED = AS_IN_FILE,
    METRE,
    CENTIMETRE,
    MILLIMETRE,
    MICROMETRE,
    KILOMETRE,
    INCH,
    FOOT
  };

  ///@{
  /**
   * Unit of the output, which should be that of the mesh. AS_IN_FILE keeps the numbers of the file as they are. Any
   * other unit is an error if the unit of the file is known neither from the file nor from FileUnit. Default:
   * AS_IN_FILE.
   */
  vtkSetClampMacro(LengthUnit, int, AS_IN_FILE, FOOT);
  vtkGetMacro(LengthUnit, int);
  ///@}

  ///@{
  /**
   * Unit of the numbers in the file, for files that declare none (BREP, .g2) or a wrong one. Counts only if LengthUnit
   * is not AS_IN_FILE. Default: AS_DECLARED, the one that the file declares.
   */
  vtkSetClampMacro(FileUnit, int, AS_DECLARED, FOOT);
  vtkGetMacro(FileUnit, int);
  ///@}

  ///@{
  /**
   * Largest distance of the tessellation from the surface as a fraction of the body's size. Greater than 0 and at most
   * 1, default 0.0005. The patches, on which all computations are done, do not depend on it.
   */
  vtkSetClampMacro(TessellationTolerance, double, 1e-8, 1.0);
  vtkGetMacro(TessellationTolerance, double);
  ///@}

  ///@{
  /**
   * What was found: format, unit that the file declares ("unknown" if none), numbers of patches, of trimmed and of
   * rational ones, and what was left out. Set by the last update.
   */
  vtkGetCharFromStdStringMacro(Format);
  vtkGetCharFromStdStringMacro(DeclaredUnit);
  vtkGetMacro(NumberOfPatches, int);
  vtkGetMacro(NumberOfTrimmedPatches, int);
  vtkGetMacro(NumberOfRationalPatches, int);
  vtkGetCharFromStdStringMacro(NotRead);
  ///@}

  /**
   * 1 if the file begins like one of the formats that this reader was built for, else 0.
   */
  static int CanReadFile(const char* fileName);

protected:
  vtkNURBSSurfaceReader();
  ~vtkNURBSSurfaceReader() override = default;

  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkNURBSSurfaceReader(const vtkNURBSSurfaceReader&) = delete;
  void operator=(const vtkNURBSSurfaceReader&) = delete;

  int LengthUnit = AS_IN_FILE;
  int FileUnit = AS_IN_FILE;
  double TessellationTolerance = 5e-4;

  std::string Format;
  std::string DeclaredUnit;
  int NumberOfPatches = 0;
  int NumberOfTrimmedPatches = 0;
  int NumberOfRationalPatches = 0;
  std::string NotRead;
};

#endif
