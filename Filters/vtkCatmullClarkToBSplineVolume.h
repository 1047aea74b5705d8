// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkCatmullClarkToBSplineVolume
 * @brief   hexahedral multi-block mesh to smooth tricubic B-spline volumes
 *
 * Takes the mesh as a Catmull-Clark control net and gives one tricubic B-spline volume per block: exactly the uniform
 * B-spline of the mesh where the blocks meet like one structured grid (double knot insertion), and by Catmull-Clark
 * limit rules at extraordinary edges, boundaries, creases and on the body. Shared control points are equal bit for bit,
 * for any order and orientation of the blocks and any number of threads.
 *
 * Input port 0 (`Input`): a tree of vtkStructuredGrid or one vtkStructuredGrid, (I+1) x (J+1) x (K+1) points per
 * block. Optional field data of the root: `Interfaces`, `Boundaries`, `BoundaryNames`, `CreaseEdges`
 * (HexBlockData.h); what is not there is found from coincident points. Optional point arrays of a block:
 * `CreaseSharpness` (0 or >= 10), `ProjectedPoint` (3) and `SurfaceNormal` (3, unit length): foot point and normal on
 * the true body, used at extraordinary body vertices; WallSpacingArray: c at the points of the wall. NaN marks points
 * without a value.
 *
 * Input port 1 (`Body`, optional): NURBS surfaces (NURBSSurfaceData.h), such as vtkNURBSSurfaceReader gives, in the
 * length unit of the mesh. Extraordinary body vertices are projected to it, and with InputPoints OnBody the whole wall
 * follows it.
 *
 * Output: a vtkPartitionedDataSetCollection with a flat assembly, per block one vtkStructuredGrid of
 * (I+3) x (J+3) x (K+3) control points in double precision. Blocks are cut where an interface covers part of a face or
 * a crease runs inside one (unless CreasesInsideBlocks puts repeated knots there), so there can be more blocks than in
 * the input. Of every block:
 * - field data `Degree` (int: 3, 3, 3), `KnotsU`, `KnotsV`, `KnotsW` (double, {0,0,0,0,1,..,I-1,I,I,I,I}),
 *   `ParentBlock` (int: input block) and `ParentOffset` (int, 3 values: mesh point of the input block at which the
 *   piece starts);
 * - point data `ControlPointRule` (unsigned char), how the control point was made: 0 copied, 1 regular, 2 boundary,
 *   3 symmetry plane, 4 planar side, 5 body, 6 extraordinary vertex of the body, 7 crease, 8 corner, 9 extraordinary
 *   edge, 10 singular node, 11 wall layer, 12 first layer of the far-field extension.
 *
 * Field data of the collection: `ControlPointRuleNames` (string), `BoundaryRoles` (int, one per name of a boundary: 0
 * far field or other, 1 body, 2 symmetry plane), and `Interfaces`, `Boundaries`, `BoundaryNames` of
 * the blocks of the output.
 *
 * On several ranks each gives the blocks whose points it was given, and pieces of them; both inputs may be distributed
 * in any way (HexBlockData.h). The result is the same bits as on one rank, the counts are those of all.
 *
 * Output port 1 (`Verdict`): a vtkTable with one row and the column `Text`, the first lines of the report, as ParaView
 * shows it in the view.
 *
 * An empty input gives an empty output. What cannot be converted is an error that names block and value; the output is
 * then empty. A body whose wall is not in the mesh, or that is far from it, is such an error.
 *
 * @sa vtkHexBlockTopology
 */
#ifndef vtkCatmullClarkToBSplineVolume_h
#define vtkCatmullClarkToBSplineVolume_h

#include "BSplineVolumeFiltersModule.h" // For export macro
#include "vtkPartitionedDataSetCollectionAlgorithm.h"
#include "vtkSmartPointer.h" // For the counts

#include "Data/BoundaryPatterns.h"  // For the names of the body
#include "Data/BoundarySelection.h" // For the same as a list

#include <array>   // For the selected faces
#include <string>  // For names
#include <utility> // For names with values
#include <vector>  // For names and faces

class vtkDataArray;
class vtkIdTypeArray;

class BSPLINEVOLUMEFILTERS_EXPORT vtkCatmullClarkToBSplineVolume : public vtkPartitionedDataSetCollectionAlgorithm
{
public:
  static vtkCatmullClarkToBSplineVolume* New();
  vtkTypeMacro(vtkCatmullClarkToBSplineVolume, vtkPartitionedDataSetCollectionAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  enum InputPointsType
  {
    AUTOMATIC = 0,
    CONTROL_NET = 1,
    ON_BODY = 2,
    LEAST_SQUARES = 3
  };

  enum PlanarSidesType
  {
    FAR_FIELD = 0,
    ALL = 1,
    NONE = 2
  };

  enum WallSpacingModeType
  {
    CONSTANT = 0,
    AUTOMATIC_MODE = 1
  };
  /// The old name of AUTOMATIC_MODE.
  static constexpr int GROWTH = 1;

  enum FarFieldSpacingType
  {
    OFF = 0,
    SIDE_AVERAGE = 1,
    PER_VERTEX = 2
  };

  enum TwistType
  {
    SECOND_FUNDAMENTAL_FORM = 0,
    PARALLELOGRAM = 1,
    MASK = 2,
    LITERAL = 3,
    ACC = 4,
    PCCM = 5
  };

  enum ContinuityType
  {
    SINGLE_KNOTS = 0,
    EXACT_G1 = 1
  };

  /**
   * Connects the body, or disconnects it with null.
   */
  void SetBodyConnection(vtkAlgorithmOutput* output);

  ///@{
  /**
   * What the wall's mesh points are: Catmull-Clark control points of it (CONTROL_NET), which shrink a convex body by
   * about curvature h^2 / 6; or points of the body (ON_BODY), as in ordinary flow meshes. The wall's control mesh is
   * then solved for, so that its limit points are the mesh points, or with a body connected their closest points on
   * it. The converted wall interpolates them, except next to extraordinary vertices, where it is close only.
   * PropagationRange says how far all this reaches into the layers. LEAST_SQUARES starts like ON_BODY and
   * then fits the wall to the Body between its mesh points, which are approximated. AUTOMATIC (default) takes the
   * control net without a body, and with one whichever of the mesh points and their limit points lie closer to it; the
   * report says what was chosen and both distances.
   */
  vtkSetClampMacro(InputPoints, int, AUTOMATIC, LEAST_SQUARES);
  vtkGetMacro(InputPoints, int);
  ///@}

  ///@{
  /**
   * ON_BODY: the solution is found when no limit point of the wall is farther from its target than this fraction of the
   * wall's bounding-box diagonal. Range (0, 1), default 1e-13.
   */
  vtkSetMacro(FitTolerance, double);
  vtkGetMacro(FitTolerance, double);
  ///@}

  ///@{
  /**
   * ON_BODY: more iterations than this are an error. At least 1, default 200.
   */
  vtkSetMacro(FitIterations, int);
  vtkGetMacro(FitIterations, int);
  ///@}

  ///@{
  /**
   * Names of the boundaries that form the body. Case does not matter, `*` stands for any text and `?` for one
   * character. Default: wall*, bcwall*, body*, no*slip*, viscous*, solid*.
   */
  void AddBodyBoundary(const char* pattern);
  void ClearBodyBoundaries();
  int GetNumberOfBodyBoundaries() const { return static_cast<int>(this->BodyBoundaries.size()); }
  const char* GetBodyBoundary(int index) const;
  ///@}

  ///@{
  /**
   * Names of the boundaries that are symmetry planes, in the same way. A name that is in both lists belongs to the
   * body. Default: sym*, bcsym*.
   */
  void AddSymmetryBoundary(const char* pattern);
  void ClearSymmetryBoundaries();
  int GetNumberOfSymmetryBoundaries() const { return static_cast<int>(this->SymmetryBoundaries.size()); }
  const char* GetSymmetryBoundary(int index) const;
  ///@}

  ///@{
  /**
   * The boundaries of the mesh by name, each switched on or off as part of the body, or as a symmetry plane. They are
   * known when the input was updated; until then, and for names that are not listed, the patterns above say it, and
   * they say how a name begins. A change of the patterns makes them begin again.
   */
  vtkDataArraySelection* GetBodySelection() { return this->BodySelection.list(); }
  vtkDataArraySelection* GetSymmetrySelection() { return this->SymmetrySelection.list(); }
  ///@}

  ///@{
  /**
   * Whole faces of input blocks that belong to the body, for meshes without boundary names: block number from 0, face
   * 0 i=0, 1 i=I, 2 j=0, 3 j=J, 4 k=0, 5 k=K. A face given here loses the name that it has. Default: none.
   */
  void AddBodyFace(int block, int face);
  void ClearBodyFaces();
  int GetNumberOfBodyFaces() const { return static_cast<int>(this->BodyFaces.size()); }
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
   * than at the next mesh edges on both sides, so that the round nose of a coarse mesh is none (CreaseEdges.h). On the
   * walls, if there is a Body, its own edges decide instead: creases are where it turns by more than CreaseAngle
   * itself. At least 0, which takes all; default 7.
   */
  vtkSetMacro(CreaseContrast, double);
  vtkGetMacro(CreaseContrast, double);
  ///@}

  enum CreasesInsideBlocksType
  {
    CUT_BLOCKS,
    REPEATED_KNOTS
  };

  ///@{
  /**
   * What becomes of a block inside which a crease runs: it is cut there, and so are its neighbours (CUT_BLOCKS,
   * default), or it stays whole, with a knot of multiplicity 3 in the place of each cut (REPEATED_KNOTS). The shape is
   * the same. Contacts and borders of named boundaries that cover part of a face cut blocks in any case.
   */
  vtkSetClampMacro(CreasesInsideBlocks, int, CUT_BLOCKS, REPEATED_KNOTS);
  vtkGetMacro(CreasesInsideBlocks, int);
  ///@}

  ///@{
  /**
   * Planar sides that keep their mesh points: those of the far field (default), that is planar sides of the outer
   * boundary that are neither body nor symmetry plane, where a side ends at sharp edges, has the whole mesh behind it
   * and borders on planar sides only, and the sides to which a far-field extension is attached; every planar block side
   * but the body's, where inner joins are then C0 only; or none.
   */
  vtkSetClampMacro(PlanarSides, int, FAR_FIELD, NONE);
  vtkGetMacro(PlanarSides, int);
  ///@}

  ///@{
  /**
   * A side is planar if its points are closer to a plane than this fraction of its bounding box's diagonal. Range
   * >= 0, default 1e-6.
   */
  vtkSetMacro(PlanarTolerance, double);
  vtkGetMacro(PlanarTolerance, double);
  ///@}

  ///@{
  /**
   * How the control point diagonally between two edges is found at extraordinary edges and extraordinary vertices of
   * the boundary: from the second fundamental form of the layer or surface (default), as the fourth point of a
   * parallelogram, by the mask 4/9 2/9 2/9 1/9, or by the thesis formulas (5.38)-(5.43), which need a Body and depend
   * on the directions of its parameters, not on their scale. ACC: the patches of Loop and Schaefer 2008; PCCM: those of
   * Peters 2000, exactly G1, with EXACT_G1 only. Both keep the limit points and do not see the Body.
   */
  vtkSetClampMacro(Twist, int, SECOND_FUNDAMENTAL_FORM, PCCM);
  vtkGetMacro(Twist, int);
  ///@}

  ///@{
  /**
   * How smooth blocks join at extraordinary edges and vertices. SINGLE_KNOTS (default): knots 0, 0, 0, 0, 1, 2, .. in
   * all blocks; normals jump there by degrees that halve with each refinement. EXACT_G1: no jumps, through all layers,
   * by double knots next to both ends of the directions that touch an extraordinary edge or vertex; with a Body and
   * wall points on it (ON_BODY) the wall is fitted to it there (Filters/Core/Conversion/G1Joins.h). Near singular nodes
   * and creases kinks remain.
   */
  vtkSetClampMacro(Continuity, int, SINGLE_KNOTS, EXACT_G1);
  vtkGetMacro(Continuity, int);
  ///@}

  ///@{
  /**
   * c in p_1/3 = c p_0 + (1 - c) p_1, the first inserted layer above the body. Range (0, 1), default 2/3; larger moves
   * the layer to the wall. For layers that grow by the ratio g the matching value is (2 + ln g) / (3 + ln g).
   */
  vtkSetMacro(WallSpacing, double);
  vtkGetMacro(WallSpacing, double);
  ///@}

  ///@{
  /**
   * CONSTANT (default): WallSpacing everywhere. AUTOMATIC_MODE: the matching value of each wall vertex, g being
   * |p_2 - p_1| / |p_1 - p_0| on the mesh line that rises there.
   */
  vtkSetClampMacro(WallSpacingMode, int, CONSTANT, AUTOMATIC_MODE);
  vtkGetMacro(WallSpacingMode, int);
  ///@}

  ///@{
  /**
   * c of single boundaries of the body, by patterns of their names as in BodyBoundaries; the first that fits counts. It
   * has precedence over WallSpacingMode. Where boundaries with different values meet, a vertex has their mean. Default:
   * none.
   */
  void AddBoundaryWallSpacing(const char* pattern, double spacing);
  void ClearBoundaryWallSpacings();
  int GetNumberOfBoundaryWallSpacings() const { return static_cast<int>(this->BoundaryWallSpacings.size()); }
  ///@}

  ///@{
  /**
   * Point array (1 component) of the input with c at the points of the wall, such as vtkWallSpacing gives; NaN where
   * there is no value. It has precedence over all others. Blocks without the array are no error. Default: WallSpacing.
   */
  vtkSetStdStringFromCharMacro(WallSpacingArray);
  vtkGetCharFromStdStringMacro(WallSpacingArray);
  ///@}

  ///@{
  /**
   * Where the first inserted layer of a far-field extension lies: at a third of its first cell (OFF); at the distance
   * between the last two layers of control points before it, averaged over the side of the cuboid (SIDE_AVERAGE,
   * default), or vertex by vertex (PER_VERTEX, C1 where mesh lines go straight through). Sides are planar; blocks that
   * touch the cuboid by an edge or a corner take the distances of its sides. No effect with PlanarSides NONE.
   */
  vtkSetClampMacro(FarFieldSpacing, int, OFF, PER_VERTEX);
  vtkGetMacro(FarFieldSpacing, int);
  ///@}

  ///@{
  /**
   * Names of input blocks that extend the far field, as patterns like BodyBoundaries: those attached face to face are
   * enough. Default: none, that is, they are recognised: the layer of blocks beyond planes that bound a cuboid around
   * the body (Core/FarField.h).
   */
  void AddExtensionBlock(const char* pattern);
  void ClearExtensionBlocks();
  int GetNumberOfExtensionBlocks() const { return static_cast<int>(this->ExtensionBlocks.size()); }
  ///@}

  ///@{
  /**
   * How far what changes at the outer boundary reaches into the volume, fading out, so that thin layers do not fold:
   * creases, in halves of the depth by which the smooth rule would round them; the corrections at extraordinary
   * body vertices and of ON_BODY, in local edge lengths of the wall. No unit, range >= 0, default 8; 0 turns it off.
   */
  vtkSetMacro(PropagationRange, double);
  vtkGetMacro(PropagationRange, double);
  ///@}

  enum CheckSpansType
  {
    CHECK_NONE,
    CHECK_SPECIAL_RULES,
    CHECK_ALL
  };

  ///@{
  /**
   * Which spans are certified after the conversion, by Bernstein bounds of their Jacobian determinant as in
   * vtkBSplineVolumeQuality: none, those near points made by special rules (CHECK_SPECIAL_RULES, default: extraordinary
   * edges and vertices, creases, corners, first layers elsewhere than at a third of the cell, points that the fit to
   * the body moved), or all. What was found is in the report and in the numbers below.
   */
  vtkSetClampMacro(CheckSpans, int, CHECK_NONE, CHECK_ALL);
  vtkGetMacro(CheckSpans, int);
  ///@}

  ///@{
  /**
   * Move mesh points near checked spans that came out invalid although their mesh cells are valid, until the spans are
   * valid or nothing more can be done. Points of the body stay where they are; points of planar sides, symmetry planes
   * and creases stay on them. Results are unchanged where no checked span is invalid. Default on.
   */
  vtkSetMacro(RepairSpans, bool);
  vtkGetMacro(RepairSpans, bool);
  vtkBooleanMacro(RepairSpans, bool);
  ///@}

  ///@{
  /**
   * Repair spans whose mesh cells are invalid as well: all spans are checked, and mesh points are moved as by
   * RepairSpans. Spans that are valid stay so. Default off.
   */
  vtkSetMacro(Untangle, bool);
  vtkGetMacro(Untangle, bool);
  vtkBooleanMacro(Untangle, bool);
  ///@}

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
   * Convert although outer faces without a name nearly face each other or lie in other cells (MeshDoctor.h), as where
   * blocks were meant to meet. What was found is then a warning. Default off: such a mesh is refused.
   */
  vtkSetMacro(AllowOpenInterior, bool);
  vtkGetMacro(AllowOpenInterior, bool);
  vtkBooleanMacro(AllowOpenInterior, bool);
  ///@}

  ///@{
  /**
   * Measure how smoothly the blocks join, for the verdict. It takes a few times as long as the conversion. Default off.
   */
  vtkSetMacro(CheckJoins, bool);
  vtkGetMacro(CheckJoins, bool);
  vtkBooleanMacro(CheckJoins, bool);
  ///@}

  ///@{
  /**
   * What the last execution did, on all ranks together.
   */
  vtkGetMacro(NumberOfInputBlocks, int);
  vtkGetMacro(NumberOfBlocks, int);
  vtkGetMacro(NumberOfExtraordinaryEdges, int);
  vtkGetMacro(NumberOfSingularNodes, int);
  vtkGetMacro(NumberOfControlPoints, vtkIdType);
  /// Spans that were checked; of those, with valid mesh cells, that came out invalid or undecided and were repaired;
  /// that are left invalid; that are left undecided.
  vtkGetMacro(NumberOfCheckedSpans, vtkIdType);
  vtkGetMacro(NumberOfRepairedSpans, vtkIdType);
  vtkGetMacro(NumberOfInvalidSpans, vtkIdType);
  vtkGetMacro(NumberOfUndecidedSpans, vtkIdType);
  ///@}

  /**
   * Bytes that this rank received from others in the last execution.
   */
  vtkGetMacro(ReceivedBytes, vtkTypeInt64);

  /**
   * Control points per code of `ControlPointRule`; a shared one counts in every block that holds it.
   */
  vtkDataArray* GetControlPointsPerRule();

  /**
   * All of it as a text: the verdict in a few lines, totals, how the wall's points were taken, extraordinary curves per
   * valence, boundaries with their roles, one line per block and, if there are several, per rank.
   */
  const char* GetReport() const { return this->Report.c_str(); }

protected:
  vtkCatmullClarkToBSplineVolume();
  ~vtkCatmullClarkToBSplineVolume() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int FillOutputPortInformation(int port, vtkInformation* info) override;
  int RequestInformation(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkCatmullClarkToBSplineVolume(const vtkCatmullClarkToBSplineVolume&) = delete;
  void operator=(const vtkCatmullClarkToBSplineVolume&) = delete;

  void ResetReport();

  class Request;

  int InputPoints = AUTOMATIC;
  double FitTolerance = 1e-13;
  int FitIterations = 200;
  bsv::BoundaryPatterns BodyBoundaries = bsv::defaultBodyBoundaries();
  bsv::BoundaryPatterns SymmetryBoundaries = bsv::defaultSymmetryBoundaries();
  bsv::BoundarySelection BodySelection{ this };
  bsv::BoundarySelection SymmetrySelection{ this };
  std::vector<std::array<int, 2>> BodyFaces;
  bool UseCreaseAngle = false;
  double CreaseAngle = 30.0;
  double CreaseContrast = 7.0;
  int CreasesInsideBlocks = CUT_BLOCKS;
  int PlanarSides = FAR_FIELD;
  double PlanarTolerance = 1e-6;
  int Twist = SECOND_FUNDAMENTAL_FORM;
  int Continuity = SINGLE_KNOTS;
  double WallSpacing = 2.0 / 3.0;
  int WallSpacingMode = CONSTANT;
  std::vector<std::pair<std::string, double>> BoundaryWallSpacings;
  std::string WallSpacingArray = "WallSpacing";
  int FarFieldSpacing = SIDE_AVERAGE;
  bsv::BoundaryPatterns ExtensionBlocks;
  double PropagationRange = 8.0;
  int CheckSpans = CHECK_SPECIAL_RULES;
  bool RepairSpans = true;
  bool Untangle = false;
  double MatchTolerance = 0.05;
  bool AllowDegenerate = false;
  bool CheckJoins = false;
  bool AllowOpenInterior = false;

  int NumberOfInputBlocks = 0;
  int NumberOfBlocks = 0;
  int NumberOfExtraordinaryEdges = 0;
  int NumberOfSingularNodes = 0;
  vtkIdType NumberOfControlPoints = 0;
  vtkIdType NumberOfCheckedSpans = 0;
  vtkIdType NumberOfRepairedSpans = 0;
  vtkIdType NumberOfInvalidSpans = 0;
  vtkIdType NumberOfUndecidedSpans = 0;
  vtkTypeInt64 ReceivedBytes = 0;
  vtkSmartPointer<vtkIdTypeArray> ControlPointsPerRule;
  std::string Report;
};

#endif
