// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkNURBSSurfaceWriter
 * @brief   writes NURBS surfaces, or the wall of a B-spline volume, as STEP, IGES or GoTools .g2 files
 *
 * The extension of the file name decides: `step` or `stp` (AP214), `igs` or `iges` (IGES 5.3), both through
 * OpenCASCADE, or `g2` (spline surfaces, class 200; no names, units and joins).
 *
 * Input: NURBS surfaces (NURBSSurfaceData.h), untrimmed; a trimmed patch is an error that names it. Or a B-spline
 * volume (BSplineVolumeData.h), of which the faces are written whose boundaries fit BodyBoundaries: the wall, as
 * patches with the names of their boundaries and normals out of the body. Surfaces are exact, polynomial or rational,
 * one untrimmed face per patch. Outward normals are those of x_u x x_v; where they are not, u is reversed.
 *
 * Faces are sewn to shells, edge to edge: those of a wall where they meet around the volume, those of other bodies
 * where sides have the same control points up to 1e-9 of the size of the body. What looks like an edge and could not be
 * sewn is said in a warning.
 *
 * The same input gives the same bytes. Files say the time of the environment variable SOURCE_DATE_EPOCH (seconds since
 * 1970, UTC), or 1970-01-01 without it. Numbers read back to the same double.
 *
 * The file appears complete or not at all. After an error an old file is untouched; the error code is set and Write()
 * returns 0. With several ranks, the patches and blocks may be on any of them; rank 0 writes.
 */
#ifndef vtkNURBSSurfaceWriter_h
#define vtkNURBSSurfaceWriter_h

#include "BSplineVolumeWritersModule.h" // For export macro
#include "vtkWriter.h"

#include <string> // For the file name
#include <vector> // For the names of boundaries

class BSPLINEVOLUMEWRITERS_EXPORT vtkNURBSSurfaceWriter : public vtkWriter
{
public:
  static vtkNURBSSurfaceWriter* New();
  vtkTypeMacro(vtkNURBSSurfaceWriter, vtkWriter);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The file to write.
   */
  vtkSetStdStringFromCharMacro(FileName);
  vtkGetCharFromStdStringMacro(FileName);
  ///@}

  ///@{
  /**
   * Names of the boundaries of a volume that form its wall (BoundaryPatterns.h). Default: what flow solvers and mesh
   * generators call walls, or what the conversion took as the wall.
   */
  void AddBodyBoundary(const char* pattern);
  void ClearBodyBoundaries();
  int GetNumberOfBodyBoundaries() const { return static_cast<int>(this->BodyBoundaries.size()); }
  const char* GetBodyBoundary(int index) const;
  ///@}

  enum LengthUnitType
  {
    AS_IN_INPUT = 0, ///< that of a body that vtkNURBSSurfaceReader has read, else metres
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
   * Unit of length that STEP and IGES files declare; points are not scaled. Default: AS_IN_INPUT.
   */
  vtkSetClampMacro(LengthUnit, int, AS_IN_INPUT, FOOT);
  vtkGetMacro(LengthUnit, int);
  ///@}

  /**
   * As in vtkWriter. On several ranks an input that is missing on some of them is an error of all.
   */
  int Write() override;

protected:
  vtkNURBSSurfaceWriter();
  ~vtkNURBSSurfaceWriter() override = default;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  void WriteData() override;

private:
  vtkNURBSSurfaceWriter(const vtkNURBSSurfaceWriter&) = delete;
  void operator=(const vtkNURBSSurfaceWriter&) = delete;

  std::string FileName;
  std::vector<std::string> BodyBoundaries;
  int LengthUnit = AS_IN_INPUT;
};

#endif
