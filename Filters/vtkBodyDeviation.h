// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkBodyDeviation
 * @brief   distance and normal deviation between the wall of a B-spline volume and its body, both ways
 *
 * Input port 0 (`Input`): a B-spline volume (BSplineVolumeData.h) with `Boundaries` and `BoundaryNames`. Its wall are
 * the block faces whose boundary names fit BodyBoundaries.
 * Input port 1 (`Body`): NURBS surfaces (NURBSSurfaceData.h) in the same length unit, trimmed or not, with or without
 * their tessellation. Optional if the volume comes from a vtkCatmullClarkToBSplineVolume that has a body: then that.
 *
 * Output: a vtkPartitionedDataSetCollection with the two parts `Wall` and `Body`, both vtkPolyData.
 *
 * `Wall`: samples of the wall, one grid of quadrilaterals per block face. `Body`: points and triangles of the body's
 * tessellation; empty if the input has none. Distances are those to the closest point of the exact other surface, the
 * NURBS patches within their trimming or the B-spline faces of the wall, never to triangles or quadrilaterals.
 * Point arrays of both:
 * - `Distance` (double): to the other surface, >= 0, in the length unit of the mesh;
 * - `NormalDeviation` (double): angle between the normals here and at the closest point, 0..90 degrees: orientations do
 *   not count. Where several patches share the closest point (within 1e-6 of the other surface's size) the smallest
 *   angle, so that points on an edge are compared with their own side; 0 where a surface has no normal.
 *
 * of `Wall` also `BlockId` (int) and the closest point on the body: `PatchUV` (patch, u, v), `ProjectedPoint`,
 * `SurfaceNormal` (unit, outward) and `SecondFundamentalForm` (L, M, N with respect to u, v and that normal), three
 * doubles each; of `Body` `Covered` (unsigned char): 0 where the body goes on beyond the border of
 * the wall, as behind a symmetry plane or if the mesh covers a part only; the closest point then lies on the wall's
 * outer border and is seen at more than 45 degrees from the normal there. Their `Distance` and `NormalDeviation` are
 * not a number, they count in no total, and their cells are hidden (`vtkGhostType`).
 *
 * Field data of both parts: `MaximumDistance`, `RMSDistance` (root of the mean square, by area) and
 * `MaximumNormalDeviation` (degrees). Field data of the collection: the same three of the wall, and
 * `HausdorffDistance`, the larger of the two parts' `MaximumDistance`: an estimate from below, since both are taken
 * over samples.
 *
 * Output port 1 (`Verdict`): a vtkTable with one row and the column `Text`, as ParaView shows it in the view.
 * Output port 2 (`Farthest`), on the first rank: a point where the wall is farthest from the body, and cross hairs,
 * three lines through it. Field data: `MaximumDistance`.
 *
 * On several ranks each gives the wall of its own blocks, and the rank that has the tessellation (the lowest, if
 * several have it) the body; totals are those of all, the same bits for any distribution. The body's patches may be on
 * any ranks.
 *
 * An empty input gives an empty output. A volume without a wall is an error that names its boundaries.
 */
#ifndef vtkBodyDeviation_h
#define vtkBodyDeviation_h

#include "BSplineVolumeFiltersModule.h" // For export macro
#include "Data/BoundaryPatterns.h"      // For the names of the body
#include "vtkPartitionedDataSetCollectionAlgorithm.h"

#include <string> // For the report

class BSPLINEVOLUMEFILTERS_EXPORT vtkBodyDeviation : public vtkPartitionedDataSetCollectionAlgorithm
{
public:
  static vtkBodyDeviation* New();
  vtkTypeMacro(vtkBodyDeviation, vtkPartitionedDataSetCollectionAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  /**
   * Connects the body.
   */
  void SetBodyConnection(vtkAlgorithmOutput* output);

  ///@{
  /**
   * Names of the boundaries that form the wall. Case does not matter, `*` stands for any text and `?` for one
   * character. Default: wall*, bcwall*, body*, no*slip*, viscous*, solid*.
   */
  void AddBodyBoundary(const char* pattern);
  void ClearBodyBoundaries();
  int GetNumberOfBodyBoundaries() const { return static_cast<int>(this->BodyBoundaries.size()); }
  const char* GetBodyBoundary(int index) const;
  ///@}

  ///@{
  /**
   * Every span of the wall is cut into 2^Level parts per direction. Range [0, 8], default 2. Each level more needs four
   * times the memory.
   */
  vtkSetClampMacro(Level, int, 0, 8);
  vtkGetMacro(Level, int);
  ///@}

  ///@{
  /**
   * The totals of the last update, as in the field data of the output.
   */
  vtkGetMacro(MaximumDistance, double);
  vtkGetMacro(RMSDistance, double);
  vtkGetMacro(MaximumNormalDeviation, double);
  vtkGetMacro(HausdorffDistance, double);
  ///@}

  /**
   * The same as a text, with the place where the wall is farthest from the body.
   */
  const char* GetReport() const { return this->Report.c_str(); }

protected:
  vtkBodyDeviation();
  ~vtkBodyDeviation() override = default;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int FillOutputPortInformation(int port, vtkInformation* info) override;
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkBodyDeviation(const vtkBodyDeviation&) = delete;
  void operator=(const vtkBodyDeviation&) = delete;

  bsv::BoundaryPatterns BodyBoundaries = bsv::defaultBodyBoundaries();
  int Level = 2;

  double MaximumDistance = 0.0;
  double RMSDistance = 0.0;
  double MaximumNormalDeviation = 0.0;
  double HausdorffDistance = 0.0;
  std::string Report;
};

#endif
