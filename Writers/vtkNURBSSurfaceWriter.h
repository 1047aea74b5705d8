// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkNURBSSurfaceWriter
 * @brief   writes NURBS surfaces as GoTools .g2 or IGES files
 *
 * The extension of the file name decides: `g2` (spline surfaces, class 200), `igs` or `iges` (IGES 5.3, entity 128,
 * which needs no CAD library). Numbers are the shortest that read back to the same double; in `.g2` the points of
 * rational patches are multiplied by their weights. IGES files declare metres.
 *
 * Input: NURBS surfaces (NURBSSurfaceData.h), untrimmed. A trimmed patch is an error that names it.
 *
 * The file appears complete or not at all. After an error an old file is untouched; the error code is set and Write()
 * returns 0. With several ranks, the patches may be on any of them; rank 0 writes.
 */
#ifndef vtkNURBSSurfaceWriter_h
#define vtkNURBSSurfaceWriter_h

#include "BSplineVolumeWritersModule.h" // For export macro
#include "vtkWriter.h"

#include <string> // For the file name

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

protected:
  vtkNURBSSurfaceWriter() = default;
  ~vtkNURBSSurfaceWriter() override = default;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  void WriteData() override;

private:
  vtkNURBSSurfaceWriter(const vtkNURBSSurfaceWriter&) = delete;
  void operator=(const vtkNURBSSurfaceWriter&) = delete;

  std::string FileName;
};

#endif
