// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkControlPointsRepresentation
 * @brief   control points of a B-spline volume that special rules made, near the wall
 *
 * Without the points that were copied, or made by the rule of regular faces and edges, and without those far from the
 * wall: what is left is how the conversion treated the body. Selected points, and those under the mouse, are the
 * volume's. A volume without a wall or without the array `ControlPointRule` shows all its points.
 *
 * Offered as the representation "Control Points".
 */
#ifndef vtkControlPointsRepresentation_h
#define vtkControlPointsRepresentation_h

#include "BSplineVolumeDisplaysModule.h" // For export macro
#include "vtkGeometryRepresentationWithFaces.h"

class BSPLINEVOLUMEDISPLAYS_EXPORT vtkControlPointsRepresentation : public vtkGeometryRepresentationWithFaces
{
public:
  static vtkControlPointsRepresentation* New();
  vtkTypeMacro(vtkControlPointsRepresentation, vtkGeometryRepresentationWithFaces);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /**
   * Show also copied and regular points. Default off.
   */
  void SetOrdinaryPoints(bool on);

  /**
   * Points are shown up to this distance from the wall's bounding box, as a fraction of its diagonal. Default 0.05; 0:
   * all.
   */
  void SetReach(double reach);

protected:
  vtkControlPointsRepresentation();
  ~vtkControlPointsRepresentation() override = default;

private:
  vtkControlPointsRepresentation(const vtkControlPointsRepresentation&) = delete;
  void operator=(const vtkControlPointsRepresentation&) = delete;
};

#endif
