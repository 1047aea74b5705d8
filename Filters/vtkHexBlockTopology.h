// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkHexBlockTopology
 * @brief   vertices, edges and faces of the complex that hexahedral blocks form
 *
 * Welds the blocks of a multi-block mesh to the conforming complex on which the conversion works, and shows it.
 *
 * Input: a tree of vtkStructuredGrid or one vtkStructuredGrid; field data `Interfaces`, `Boundaries`, `BoundaryNames`
 * and `CreaseEdges` and the point array `CreaseSharpness` are used if present (HexBlockData.h). Blocks are cut where an
 * interface covers only part of a face and where a crease or the border of a named boundary runs inside a face.
 *
 * Output: a vtkPartitionedDataSetCollection of three vtkPolyData,
 * - `Vertices`: one vertex cell per vertex of the complex;
 * - `Edges`: one poly line per edge, through its mesh points;
 * - `Faces`: one quadrilateral per mesh quadrilateral of every face, all cells of a face with the same data; seen
 *   from outside, boundary faces of right-handed blocks run counter-clockwise;
 *
 * with the cell arrays
 * - `GlobalId` (int): number of the entity in the complex;
 * - `Class` (unsigned char): 0 regular, 1 boundary, 2 extraordinary, 3 singular, 4 crease, 5 corner. An interior edge
 *   is extraordinary if other than four blocks meet there, and a singular vertex is one at which extraordinary edges of
 *   more than one direction meet. A vertex is extraordinary inside a curve of extraordinary edges, and on the boundary
 *   where other than four boundary faces meet away from creases and borders of named boundaries;
 * - `Valence` (int): number of block corners, block edges or block faces that meet there;
 * - `BlockIds` (int, as many components as any entity has blocks): the blocks, ascending, filled with -1.
 *   Blocks are those of the complex, after cutting;
 * - `BoundaryTag` (int): index into `BoundaryNames` of the boundary that the entity lies on, the lowest if there are
 *   several, -1 without one.
 *
 * Field data of the collection: string arrays `ClassNames` and `BoundaryNames`; int array `ExtraordinaryCurves` (2
 * components: valence, number of curves); int array `ParentBlock`: per block of the complex the input block that it is
 * a piece of.
 *
 * Second output, `OuterSurface`: a vtkPolyData of all quadrilaterals of the outer surface, seen from outside
 * counter-clockwise, with the cell arrays `Finding` (unsigned char, names in the field array `FindingNames`: 0 none,
 * 1 near miss, 2 loose point, 3 overlap, 4 narrow gap, 5 inner boundary), `FindingId` (int, row of the third output
 * or -1), `BlockId`, `FaceId` (int, of the input) and `BoundaryTag`.
 *
 * Third output, `Findings`: a vtkTable with one row per finding (MeshDoctor.h), the suspicious ones first: `Finding`
 * (name), `Suspicious` (0 or 1), `BlockA`, `FaceA`, `BlockB`, `FaceB` (input blocks, -1 for none), `Quads` (outer
 * quadrilaterals, of a component blocks), `Distance` (length), `Fraction` (of the cells there), `GlueTolerance` (the
 * least MatchTolerance that would glue it; 0 if none would), `X`, `Y`, `Z` (where), `Description`. Suspicious are
 * blocks that seem to be meant to meet and do not; a warning counts them. On several ranks the first has all rows.
 *
 * Fourth output, `Creases`: a vtkPolyData of the mesh edges of the outer surface, before cutting, that turn by
 * CreaseAngle or more (none if UseCreaseAngle is off), with the cell arrays `Crease` (unsigned char: 0 smooth, 1
 * crease, 2 tagged crease, 3 within rounding of a limit and therefore smooth), `Angle` (degrees between the normals),
 * `Nearby` (the largest at the next mesh edges on both sides) and `BodyAngle` (by which the body turns; -1 where it
 * does not decide). The report tells how many there are of each, and the numbers of blocks before and after cutting.
 *
 * Second input, optional: the body as a tree of NURBS surfaces (vtkNURBSSurfaceReader).
 *
 * On several ranks each gives the entities whose first block is one of its own, with the numbers that they have in the
 * whole complex; counts and field data are those of all.
 *
 * An empty input gives three empty parts. What cannot be welded is an error that names block and face.
 *
 * @sa vtkCatmullClarkToBSplineVolume
 */
#ifndef vtkHexBlockTopology_h
#define vtkHexBlockTopology_h

#include "BSplineVolumeFiltersModule.h" // For export macro
#include "Data/BoundaryPatterns.h"      // For BodyBoundaries
#include "vtkPartitionedDataSetCollectionAlgorithm.h"

#include <string> // For the report

class BSPLINEVOLUMEFILTERS_EXPORT vtkHexBlockTopology : public vtkPartitionedDataSetCollectionAlgorithm
{
public:
  static vtkHexBlockTopology* New();
  vtkTypeMacro(vtkHexBlockTopology, vtkPartitionedDataSetCollectionAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Boundary points are one point if they are closer than this fraction of the shortest mesh edge at either of them.
   * Range (0, 0.5), default 0.05.
   */
  vtkSetMacro(MatchTolerance, double);
  vtkGetMacro(MatchTolerance, double);
  ///@}

  ///@{
  /**
   * Accept collapsed faces and cells without volume instead of refusing the mesh. Default off.
   */
  vtkSetMacro(AllowDegenerate, bool);
  vtkGetMacro(AllowDegenerate, bool);
  vtkBooleanMacro(AllowDegenerate, bool);
  ///@}

  ///@{
  /**
   * Make every mesh edge of the outer boundary a crease at which the surface turns by more than CreaseAngle. Default
   * off: only tagged creases count.
   */
  vtkSetMacro(UseCreaseAngle, bool);
  vtkGetMacro(UseCreaseAngle, bool);
  vtkBooleanMacro(UseCreaseAngle, bool);
  ///@}

  ///@{
  /**
   * Angle between the normals of neighbouring boundary quadrilaterals. Degrees, range [0, 180], default 30.
   */
  vtkSetMacro(CreaseAngle, double);
  vtkGetMacro(CreaseAngle, double);
  ///@}

  ///@{
  /**
   * Of the edges that turn by more than CreaseAngle those are creases at which the surface turns this many times more
   * than at the next mesh edges on both sides (CreaseEdges.h); on the walls of a connected body, those at which the
   * body itself turns by more than CreaseAngle. At least 0, which takes all; default 7.
   */
  vtkSetMacro(CreaseContrast, double);
  vtkGetMacro(CreaseContrast, double);
  ///@}

  ///@{
  /**
   * Names of the boundaries that form the wall of the connected body; * and ? are wildcards, case does not matter.
   * Default: what solvers call walls (BoundaryPatterns.h).
   */
  void AddBodyBoundary(const char* pattern);
  void ClearBodyBoundaries();
  ///@}

  /**
   * The body, second input.
   */
  void SetBodyConnection(vtkAlgorithmOutput* output);

  ///@{
  /**
   * What the last execution found.
   */
  vtkGetMacro(NumberOfInputBlocks, int);
  vtkGetMacro(NumberOfBlocks, int);
  vtkGetMacro(NumberOfVertices, int);
  vtkGetMacro(NumberOfEdges, int);
  vtkGetMacro(NumberOfFaces, int);
  vtkGetMacro(NumberOfExtraordinaryEdges, int);
  vtkGetMacro(NumberOfSingularNodes, int);
  vtkGetMacro(NumberOfComponents, int);
  vtkGetMacro(NumberOfFindings, int);
  vtkGetMacro(NumberOfSuspiciousFindings, int);
  ///@}

  /**
   * The same as a text of a few lines, with the number of extraordinary curves per valence.
   */
  const char* GetReport() const { return this->Report.c_str(); }

protected:
  vtkHexBlockTopology();
  ~vtkHexBlockTopology() override = default;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int FillOutputPortInformation(int port, vtkInformation* info) override;
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkHexBlockTopology(const vtkHexBlockTopology&) = delete;
  void operator=(const vtkHexBlockTopology&) = delete;

  double MatchTolerance = 0.05;
  bool AllowDegenerate = false;
  bool UseCreaseAngle = false;
  double CreaseAngle = 30.0;
  double CreaseContrast = 7.0;
  bsv::BoundaryPatterns BodyBoundaries = bsv::defaultBodyBoundaries();

  int NumberOfInputBlocks = 0;
  int NumberOfBlocks = 0;
  int NumberOfVertices = 0;
  int NumberOfEdges = 0;
  int NumberOfFaces = 0;
  int NumberOfExtraordinaryEdges = 0;
  int NumberOfSingularNodes = 0;
  int NumberOfComponents = 0;
  int NumberOfFindings = 0;
  int NumberOfSuspiciousFindings = 0;
  std::string Report;
};

#endif
