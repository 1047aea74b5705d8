// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkBSplineVolumeSmoothness
 * @brief   gaps, kinks and derivative jumps where the blocks of a B-spline volume join
 *
 * Input: a B-spline volume (BSplineVolumeData.h) of any degree from 1 to 8, with any knots, rational or not. Interfaces
 * are taken from `Interfaces`; without that array they are found from the shape of the faces (VolumeInterfaces.h), but
 * for the faces in `Boundaries`. Measured are all interfaces and the *wall borders*: block edges at which two outer
 * faces of the wall meet; knots repeated as often as the degree, and at least twice, part a block, and its parts are
 * joined in the same way (Join.h). The wall are the outer faces whose boundary names fit BodyBoundaries; all outer
 * faces if AllOuterFaces is on or no name fits.
 *
 * The jumps are defined in Smoothness.h. Derivatives are those with respect to the knots' own parameters:
 * - `Gap` (length): distance of the two sides at equal parameters;
 * - `NormalJump` (degrees): angle between the normals of the layers on both sides. Two families of layers cross an
 *   interface, those through its first and those through its second axis (component 0 and 1 where there are two);
 *   without components the larger one;
 * - `LayerJump` (degrees): the normal jump that counts: without layers along which an extraordinary edge or a crease of
 *   the interface runs, which are bound to kink there (by 60 degrees where three blocks meet);
 * - `Kink` (degrees): angle between the parameter lines that cross;
 * - `C1Jump` (relative): |n_A + n_B| / max(|n_A|, |n_B|) of the outward first derivatives n;
 * - `C2Jump` (relative): h |n2_A - n2_B| / max(|n_A|, |n_B|) with the second derivatives n2 and the shorter span h.
 *
 * `Continuity` (int): 0 open (wider than GapTolerance), 1 C0 (layers kink that need not), 2 G1 (one family of layers,
 * or all that need not kink, are smooth all along), 3 C1, 4 C2; jumps up to Tolerance count as smooth. A wall border
 * that is meant to be sharp is a *crease* (CreaseAngle): it is listed, last, but counts in no total.
 *
 * Output ports:
 * 0. `Interfaces`: vtkPartitionedDataSetCollection, one vtkPolyData per interface (of parts), named "A|B" after its
 * blocks. Point arrays `Gap`, `NormalJump` (2), `WorstNormalJump`, `LayerJump`, `Kink`, `C1Jump`, `C2Jump` at
 * SamplesPerSpan parts of every span. Cell arrays `SpanGap`, `SpanNormalJump`, `SpanLayerJump`, `SpanKink`,
 * `SpanC1Jump`, `SpanC2Jump`, the maxima over the control span that the cell lies in, and `Continuity`. Field data
 * `MaximumGap`, `MaximumNormalJump`, `MaximumLayerJump`, `MaximumKink`, `MaximumC1Jump`, `MaximumC2Jump` (double),
 * `InterfaceId`, `Blocks` (2), `Faces` (2), `Orientation`, `AtCrease`, `Continuity` (int), `Valences` (int, 4: blocks
 * around the edges at s = 0, s = end, t = 0, t = end of face A; negative on the outer boundary). The collection's field
 * data hold the maxima of all joins that are no creases.
 * 1. `Blocks`: vtkPartitionedDataSetCollection with the blocks' names: the edges of each block as vtkPolyData, or with
 *    BlockSkins its faces. Cell and
 *    field arrays `Gap`, `NormalJump`, `LayerJump`, `Kink`, `C1Jump`, `C2Jump`, `Continuity`: the worst of the block's
 *    joins; `WorstJoin` (int): row of the table, or -1.
 * 2. `Joins`: vtkTable, one row per interface and wall border, the worst first: by continuity, then by the jump that
 *    breaks it (`RankedBy`), creases last. Columns: `Class` (string: defect, expected, deliberate, smooth;
 * JoinClass.h), `Continuity` (string: open, C0, G1, C1, C2), `Kind` (string: interface, repeated
 * knot, wall border, crease), `NameA`, `NameB`, `BlockA`, `FaceA`, `EdgeA`, `BlockB`, `FaceB`, `EdgeB` (block edges of
 * a wall border, else -1), `Orientation`, `AtCrease` (int: 1 for creases and for interfaces that end at one),
 * `MaximumGap`, `MaximumNormalJump`, `MaximumNormalJumpS`, `MaximumNormalJumpT`, `MaximumLayerJump`, `MaximumKink`,
 * `MaximumC1Jump`, `MaximumC2Jump`, `RankedBy` (string), and where the jump of that name is largest: `Where` (3:
 * point), `UVWA` (3), `UVWB` (3: parameters in either block).
 * 3. `Curves`: vtkPolyData, lines: extraordinary curves (interior block edges at which other than four blocks meet) and
 *    wall borders. Point arrays `Valence` (int: blocks around), `NormalJump` (of the layers that an extraordinary curve
 *    pierces, the largest around it; of the wall); cell arrays `Kind` (int: 0 extraordinary curve, 1 wall border, 2
 *    crease), `Valence`, `Continuity` (-1 for extraordinary curves), `BlockA`, `BlockB` (-1 for extraordinary curves).
 *
 * 4. `Join List`: vtkPolyData, one line per join, defects first, then deliberate ones (JoinClass.h): the border of an
 * interface, or the wall border itself. Cell arrays in reading order: `1 Rank`, `2 Class`, `3 What`, `4 Blocks`, `5
 * Jump` (string, with its unit), `6 Measure`; `JoinClass` (int: 0 defect, 1 expected, 2 deliberate, 3 smooth); `Layer
 * jump (degrees)`, the largest; `Where` (3), the place of the jump by which the join is ranked. Point array `Layer jump
 *    (degrees)`, the jump there. Field data `WallBox` (6: bounds of the wall's control points), if there is a wall. All
 *    on the first rank.
 * 5. `Verdict`: vtkTable with one row and the column `Text`, as ParaView shows it in the view.
 *
 * Active scalars, by which ParaView colours first: `LayerJump`, of the curves `NormalJump`, of the list `Layer
 * jump (degrees)` at its points.
 *
 * Several ranks: the interfaces and wall borders are on the rank of their block A, skins on that of the block,
 * extraordinary curves on that of one of their blocks, the table on the first rank. All know the maxima and the report.
 *
 * An empty input gives empty outputs. An error names block and face, and leaves all outputs empty.
 */
#ifndef vtkBSplineVolumeSmoothness_h
#define vtkBSplineVolumeSmoothness_h

#include "BSplineVolumeFiltersModule.h" // For export macro
#include "Data/BoundaryPatterns.h"      // For the names of the body
#include "vtkPartitionedDataSetCollectionAlgorithm.h"
#include "vtkSmartPointer.h" // For the list

#include <string> // For the report

class vtkStringArray;

class BSPLINEVOLUMEFILTERS_EXPORT vtkBSplineVolumeSmoothness : public vtkPartitionedDataSetCollectionAlgorithm
{
public:
  static vtkBSplineVolumeSmoothness* New();
  vtkTypeMacro(vtkBSplineVolumeSmoothness, vtkPartitionedDataSetCollectionAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Every span of a join is cut into this many parts per direction; maxima are then refined from the best samples.
   * Range [1, 16], default 3. With as many parts as the degree no polynomial jump can hide between the samples.
   */
  vtkSetClampMacro(SamplesPerSpan, int, 1, 16);
  vtkGetMacro(SamplesPerSpan, int);
  ///@}

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
   * Measure the borders of all outer faces, not only of the body. Default off.
   */
  vtkSetMacro(AllOuterFaces, bool);
  vtkGetMacro(AllOuterFaces, bool);
  vtkBooleanMacro(AllOuterFaces, bool);
  ///@}

  ///@{
  /**
   * A wall border is a crease where more than half of its samples turn by more than this, or where `ControlPointRule`
   * says so. Degrees, range [0, 180], default 30.
   */
  vtkSetClampMacro(CreaseAngle, double, 0.0, 180.0);
  vtkGetMacro(CreaseAngle, double);
  ///@}

  ///@{
  /**
   * A join is open if it has a gap wider than this fraction of the volume's diagonal. At least 0, default 1e-10.
   */
  vtkSetMacro(GapTolerance, double);
  vtkGetMacro(GapTolerance, double);
  ///@}

  ///@{
  /**
   * Relative jumps, and angles in radians, up to this count as smooth in `Continuity`. At least 0, default 1e-6.
   */
  vtkSetMacro(Tolerance, double);
  vtkGetMacro(Tolerance, double);
  ///@}

  ///@{
  /**
   * Used only where the input has no `Interfaces`: faces meet if they are closer than this fraction of the shortest
   * distance between points in and under them. Range (0, 0.5), default 0.05.
   */
  vtkSetMacro(MatchTolerance, double);
  vtkGetMacro(MatchTolerance, double);
  ///@}

  ///@{
  /**
   * Of the last execution: maxima over all joins that are no creases, numbers of joins, and a text of a few lines.
   */
  vtkGetMacro(MaximumGap, double);
  vtkGetMacro(MaximumNormalJump, double);
  vtkGetMacro(MaximumLayerJump, double);
  vtkGetMacro(MaximumKink, double);
  vtkGetMacro(MaximumC1Jump, double);
  vtkGetMacro(MaximumC2Jump, double);
  vtkGetMacro(NumberOfInterfaces, int);
  vtkGetMacro(NumberOfWallBorders, int);
  vtkGetMacro(NumberOfExtraordinaryCurves, int);
  const char* GetReport() const { return this->Report.c_str(); }
  ///@}

  /**
   * The join list as texts, one per line of it: class, what, blocks, jump, measure, six bounds of what to look at,
   * around the place where the join is worst, and three numbers, the way from there to the middle of the wall (0 0 0 if
   * there is no wall), between tabulators. For clients that do not have the data.
   */
  vtkStringArray* GetJoinList();

  ///@{
  /**
   * Make output 1 the surfaces of all six faces of every block, not only its twelve edges: much more memory. Default
   * off.
   */
  vtkSetMacro(BlockSkins, bool);
  vtkGetMacro(BlockSkins, bool);
  vtkBooleanMacro(BlockSkins, bool);
  ///@}

protected:
  vtkBSplineVolumeSmoothness();
  ~vtkBSplineVolumeSmoothness() override;

  int FillInputPortInformation(int port, vtkInformation* info) override;
  int FillOutputPortInformation(int port, vtkInformation* info) override;
  int RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector*) override;

private:
  vtkBSplineVolumeSmoothness(const vtkBSplineVolumeSmoothness&) = delete;
  void operator=(const vtkBSplineVolumeSmoothness&) = delete;

  int SamplesPerSpan = 3;
  bsv::BoundaryPatterns BodyBoundaries = bsv::defaultBodyBoundaries();
  bool AllOuterFaces = false;
  double CreaseAngle = 30.0;
  double GapTolerance = 1e-10;
  double Tolerance = 1e-6;
  double MatchTolerance = 0.05;

  double MaximumGap = 0.0;
  double MaximumNormalJump = 0.0;
  double MaximumLayerJump = 0.0;
  double MaximumKink = 0.0;
  double MaximumC1Jump = 0.0;
  double MaximumC2Jump = 0.0;
  int NumberOfInterfaces = 0;
  int NumberOfWallBorders = 0;
  int NumberOfExtraordinaryCurves = 0;
  std::string Report;
  bool BlockSkins = false;
  vtkSmartPointer<vtkStringArray> JoinList;
};

#endif
