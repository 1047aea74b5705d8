// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkBlockPartsRepresentation
 * @brief   the wall of a block mesh or B-spline volume, with its nets, extraordinary curves and creases
 *
 * Draws the parts that blockParts.h chooses: the wall as a lit surface (of a volume evaluated from the B-spline with
 * exact normals), the symmetry plane's net as faint lines, extraordinary curves as tubes coloured by the number of
 * blocks that meet, creases black. The camera is set by the wall alone. A legend says which colour is what.
 *
 * Offered as the representation "Wall And Curves".
 */
#ifndef vtkBlockPartsRepresentation_h
#define vtkBlockPartsRepresentation_h

#include "BSplineVolumeDisplaysModule.h" // For export macro
#include "vtkGeometryRepresentationWithFaces.h"

#include <memory> // For what is behind

class BSPLINEVOLUMEDISPLAYS_EXPORT vtkBlockPartsRepresentation : public vtkGeometryRepresentationWithFaces
{
public:
  static vtkBlockPartsRepresentation* New();
  vtkTypeMacro(vtkBlockPartsRepresentation, vtkGeometryRepresentationWithFaces);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Which parts are shown. Defaults: all but the nets of wall and far field and the edges of blocks.
   */
  void SetShowWall(bool on);
  void SetShowWallNet(bool on);
  void SetShowSymmetryNet(bool on);
  void SetShowFarFieldNet(bool on);
  void SetShowBlockEdges(bool on);
  void SetShowExtraordinaryCurves(bool on);
  void SetShowCreases(bool on);
  void SetShowPartsLegend(bool on);
  ///@}

  /**
   * The surface is so many cells off the wall, at most at the opposite side of each block. Default 0: the wall.
   */
  void SetLayer(int layer);

  /**
   * Parts into which every span of a volume's wall is cut per direction; 0 (default): as many as keep it small.
   */
  void SetSubdivision(int parts);

  /**
   * Lines end at this distance from the wall, as a fraction of the diagonal of the wall's box. Default 0.3; 0: they do
   * not end.
   */
  void SetReach(double reach);

  /**
   * Width of extraordinary curves and creases in pixels. Default 5.
   */
  void SetCurveWidth(double width);

  ///@{
  /**
   * Stripes of light as they are reflected by the wall: where they break, the normal jumps (G1 is missing); where they
   * have a corner, the curvature does. Number of stripes over 180 degrees, default 24.
   */
  void SetReflectionLines(bool on);
  void SetNumberOfReflectionLines(int count);
  ///@}

  int ProcessViewRequest(vtkInformationRequestKey* request, vtkInformation* inInfo, vtkInformation* outInfo) override;
  void SetVisibility(bool visible) override;

  /**
   * Normals for the light. "None" (default): of volumes the exact ones; a mesh has facets, unless there are reflection
   * lines on it.
   */
  void SetNormalArray(const char* name) override;

protected:
  vtkBlockPartsRepresentation();
  ~vtkBlockPartsRepresentation() override;

  bool AddToView(vtkView* view) override;
  bool RemoveFromView(vtkView* view) override;
  void UpdateColoringParameters() override;

private:
  vtkBlockPartsRepresentation(const vtkBlockPartsRepresentation&) = delete;
  void operator=(const vtkBlockPartsRepresentation&) = delete;

  void SetPart(bool& part, bool on);
  void UpdateReflectionLines();
  void UpdateLegend();
  /// Keeps its size in pixels, at the upper right.
  void PlaceLegend();
  void UpdateVisibility();

  struct Internals;
  std::unique_ptr<Internals> Internal;
};

#endif
