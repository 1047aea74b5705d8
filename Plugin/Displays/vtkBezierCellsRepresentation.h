// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkBezierCellsRepresentation
 * @brief   curved cells, drawn the more coarsely the more there are
 *
 * Bezier quadrilaterals are cut into degree 2^(level - 1) parts per direction, or one at level 0, with exact normals;
 * other curved cells by VTK's own subdivision. With LevelBySize the display's nonlinear subdivision level is lowered to
 * 1 above 3000 cells and to 0 above 20000, on all ranks alike.
 *
 * Offered as the representation "Bezier Cells".
 */
#ifndef vtkBezierCellsRepresentation_h
#define vtkBezierCellsRepresentation_h

#include "BSplineVolumeDisplaysModule.h" // For export macro
#include "vtkGeometryRepresentationWithFaces.h"

class BSPLINEVOLUMEDISPLAYS_EXPORT vtkBezierCellsRepresentation : public vtkGeometryRepresentationWithFaces
{
public:
  static vtkBezierCellsRepresentation* New();
  vtkTypeMacro(vtkBezierCellsRepresentation, vtkGeometryRepresentationWithFaces);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /**
   * Whether many cells lower the level. Default: on.
   */
  void SetLevelBySize(bool on);

  /**
   * Normals for the light. "None" (default): the exact ones of Bezier quadrilaterals.
   */
  void SetNormalArray(const char* name) override;

protected:
  vtkBezierCellsRepresentation();
  ~vtkBezierCellsRepresentation() override = default;

private:
  vtkBezierCellsRepresentation(const vtkBezierCellsRepresentation&) = delete;
  void operator=(const vtkBezierCellsRepresentation&) = delete;
};

#endif
