// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkJoinsRepresentation
 * @brief   of the joins of a volume those lines that matter
 *
 * Draws the output `Join List` of vtkBSplineVolumeSmoothness: of the lines of the chosen classes the parts where the
 * jump is at least LeastJump and that are near the wall, and a ball where a defect is worst. Selected cells are those
 * of the list, whole.
 *
 * Offered as the representation "Joins That Matter".
 */
#ifndef vtkJoinsRepresentation_h
#define vtkJoinsRepresentation_h

#include "BSplineVolumeDisplaysModule.h" // For export macro
#include "vtkGeometryRepresentationWithFaces.h"

class BSPLINEVOLUMEDISPLAYS_EXPORT vtkJoinsRepresentation : public vtkGeometryRepresentationWithFaces
{
public:
  static vtkJoinsRepresentation* New();
  vtkTypeMacro(vtkJoinsRepresentation, vtkGeometryRepresentationWithFaces);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  enum Classes
  {
    DEFECTS,
    UNEXPECTED, ///< defects and deliberate kinks
    ALL         ///< also what is bound to kink
  };

  /**
   * Which joins are drawn. Default DEFECTS.
   */
  void SetClasses(int classes);

  /**
   * Smaller jumps are not drawn. Degrees, default 0.01; 0: all are drawn.
   */
  void SetLeastJump(double jump);

  /**
   * Lines end at this distance from the wall, as a fraction of the diagonal of the wall's box. Default 0.3; 0: they do
   * not end.
   */
  void SetReach(double reach);

  /**
   * A ball where each defect is worst. Default on.
   */
  void SetShowWorstPlaces(bool on);

protected:
  vtkJoinsRepresentation();
  ~vtkJoinsRepresentation() override = default;

private:
  vtkJoinsRepresentation(const vtkJoinsRepresentation&) = delete;
  void operator=(const vtkJoinsRepresentation&) = delete;

  template <typename Value>
  void Set(Value& member, Value value);
};

#endif
