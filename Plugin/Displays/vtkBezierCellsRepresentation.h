// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkBezierCellsRepresentation
 * @brief   curved cells, drawn the more coarsely the more there are
 *
 * The time to draw nonlinear cells is that of their subdivision, four times as long per level. With LevelBySize the
 * display's nonlinear subdivision level is lowered to 1 above 3000 cells and to 0 above 20000, on all ranks alike.
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

protected:
  vtkBezierCellsRepresentation();
  ~vtkBezierCellsRepresentation() override = default;

private:
  vtkBezierCellsRepresentation(const vtkBezierCellsRepresentation&) = delete;
  void operator=(const vtkBezierCellsRepresentation&) = delete;
};

#endif
