// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkControlNetRepresentation
 * @brief   the lines of a control net together with its points
 *
 * ParaView draws either lines or points. Here the vertices are drawn over the lines, in one colour and larger than the
 * display's point size by the factor PointScale, so that they stand out of the lines where both have default sizes.
 *
 * Offered as the representation "Control Net" of structured grids.
 */
#ifndef vtkControlNetRepresentation_h
#define vtkControlNetRepresentation_h

#include "BSplineVolumeDisplaysModule.h" // For export macro
#include "vtkGeometryRepresentationWithFaces.h"

class BSPLINEVOLUMEDISPLAYS_EXPORT vtkControlNetRepresentation : public vtkGeometryRepresentationWithFaces
{
public:
  static vtkControlNetRepresentation* New();
  vtkTypeMacro(vtkControlNetRepresentation, vtkGeometryRepresentationWithFaces);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  static constexpr double PointScale = 2.5;

  /// Pixels; 2 is ParaView's default.
  void SetPointSize(double size) override;

protected:
  vtkControlNetRepresentation();
  ~vtkControlNetRepresentation() override = default;

private:
  vtkControlNetRepresentation(const vtkControlNetRepresentation&) = delete;
  void operator=(const vtkControlNetRepresentation&) = delete;
};

#endif
