// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkMirrorHexBlocks
 * @brief   makes a whole multi-block mesh of half a one
 *
 * Adds the mirror image of every block at the plane of the symmetry boundaries. The points on the plane are put onto it
 * and are the same bits on both sides, and the faces there become interfaces instead of boundaries. Mirrored blocks run
 * backwards in i, so that they stay right-handed. They have the names, contacts, boundaries and creases of the
 * originals; of their point arrays, `ProjectedPoint` and `SurfaceNormal` are mirrored, too, and all others copied.
 *
 * Input: as of vtkCatmullClarkToBSplineVolume, also unstructured. Output: a vtkPartitionedDataSetCollection of the
 * blocks and, after them, their images.
 *
 * Refused: no symmetry boundary, one that is not in one plane.
 *
 * @sa vtkHexMeshToBlocks
 */
#ifndef vtkMirrorHexBlocks_h
#define vtkMirrorHexBlocks_h

#include "BSplineVolumeFiltersModule.h" // For export macro
#include "Data/BoundaryPatterns.h"      // For the boundaries
#include "vtkPartitionedDataSetCollectionAlgorithm.h"

#include <string> // For the report

class BSPLINEVOLUMEFILTERS_EXPORT vtkMirrorHexBlocks : public vtkPartitionedDataSetCollectionAlgorithm
{
public:
  static vtkMirrorHexBlocks* New();
  vtkTypeMacro(vtkMirrorHexBlocks, vtkPartitionedDataSetCollectionAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Boundaries on the plane: patterns of names, as of vtkCatmullClarkToBSplineVolume; those with the type
   * BCSymmetryPlane while the patterns are the default ones.
   */
  void AddSymmetryBoundary(const char* pattern);
  void ClearSymmetryBoundaries();
  int GetNumberOfSymmetryBoundaries() const { return static_cast<int>(this->SymmetryBoundaries.size()); }
  const char* GetSymmetryBoundary(int index) const;
  ///@}

  ///@{
  /**
   * Points of the symmetry boundaries may be this far from their plane, as a fraction of the size of the boundaries.
   * Range [0, 0.1], default 1e-5.
   */
  vtkSetMacro(PlaneTolerance, double);
  vtkGetMacro(PlaneTolerance, double);
  ///@}

  /**
   * The plane found, and how far points were moved onto it.
   */
  const char* GetReport() const { return this->Report.c_str(); }

protected:
  vtkMirrorHexBlocks() = default;
  ~vtkMirrorHexBlocks() override = default;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkMirrorHexBlocks(const vtkMirrorHexBlocks&) = delete;
  void operator=(const vtkMirrorHexBlocks&) = delete;

  bsv::BoundaryPatterns SymmetryBoundaries = bsv::defaultSymmetryBoundaries();
  double PlaneTolerance = 1e-5;
  std::string Report;
};

#endif
