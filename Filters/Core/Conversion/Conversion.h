// SPDX-License-Identifier: BSD-3-Clause
/// @file Conversion.h
/// From a block complex to tricubic B-spline blocks with clamped integer knots, by double knot insertion where the
/// blocks are regular and by Catmull-Clark limit rules elsewhere.
#pragma once

#include "Complex/BlockComplex.h"
#include "Volume/ControlPointRule.h"

#include <cstdint>
#include <string>
#include <vector>

namespace bsv
{

/// Weight c of the nearer point in an inserted point, unless a spacing is given: that of uniform knots.
constexpr double KnotInsertion = 2.0 / 3.0;

class BodySurface;
struct EntityRules;

/// What a named boundary is.
enum class BoundaryRole : std::uint8_t
{
  Other,
  Body,
  Symmetry
};

/// Which planar block sides keep their points.
enum class PlanarSides : std::uint8_t
{
  /// Planar sides of the outer boundary that are neither body nor symmetry plane, and the sides to which a far-field
  /// extension is attached (FarField.h). A side of the boundary ends at sharp edges; the whole mesh lies behind it, and
  /// it borders on planar sides only.
  FarField,
  All, ///< every planar block side but the body's, inner ones too (these joins are then C0 only)
  None
};

/// How the inserted point diagonally between two edges is found at extraordinary edges and vertices (LayerRules.h).
enum class Twist : std::uint8_t
{
  SecondFundamentalForm, ///< from the curvature of the layer or surface
  Parallelogram,         ///< fourth point of a parallelogram
  Mask,                  ///< mask 4/9 2/9 2/9 1/9 of the mesh points
  /// The source's formulas (5.38)-(5.43), to reproduce it: neighbours projected onto the tangent plane, at body
  /// vertices the parallelogram plus x^_uv / 9, x^_uv being x_uv of the given surface scaled to a third of the distance
  /// from the vertex to the projected p_11 (5.40), none where x_uv = 0; in layers the parallelogram. The directions of
  /// the surface's parameters matter, their scale does not. Needs ConversionOptions::body.
  Literal,
  /// The patches of Loop and Schaefer 2008 (doi:10.1145/1330511.1330519): c1 and b11 from the masks
  /// (n p + 2 e_k + 2 e_(k+1) + f_k) / (n + 5).
  ACC,
  /// After Peters 2000 (PCCM): explicit and exactly G1. Needs Continuity::ExactG1, which then does not fit the wall.
  PCCM
};

/// How smooth blocks join at extraordinary edges and vertices.
enum class Continuity : std::uint8_t
{
  /// Single knots everywhere; kinks that halve with each refinement.
  SingleKnots,
  /// Double knots in the direction classes that touch an extraordinary edge or vertex, and no kinks (G1Joins.h).
  ExactG1
};

/// Where the first inserted layer of the far-field extension lies.
enum class FarFieldSpacing : std::uint8_t
{
  /// As everywhere: at a third of the extension's first cell.
  Off,
  /// At the distance between the last two layers of control points before the extension, p^K and p_{K-1/3}, averaged
  /// over the side of the cuboid. Blocks at edges and corners take the distance of each side whose plane they lie
  /// beyond.
  SideAverage,
  /// At that distance at each vertex. C1 where mesh lines cross the side straight on; SideAverage is so on average.
  PerVertex
};

/// Which spans are certified after the conversion (SpanRepair.h).
enum class CheckSpans : std::uint8_t
{
  None,
  /// Those with control points made by other rules than copying, knot insertion and its limits (extraordinary edges and
  /// vertices, creases, corners, a first layer elsewhere than at a third of its cell), or from moved mesh points.
  SpecialRules,
  All
};

struct ConversionOptions
{
  /// Role per entry of BlockComplex::boundaryNames; missing entries are Other.
  std::vector<BoundaryRole> roles;
  PlanarSides planarSides = PlanarSides::FarField;
  /// A side is planar if its points are closer to a plane than this fraction of its bounding box's diagonal; within a
  /// thousandth of the limit it is taken as curved, which the report says.
  double planarTolerance = 1e-6;
  Twist twist = Twist::SecondFundamentalForm;
  Continuity continuity = Continuity::SingleKnots;
  /// Changes to single knots; PCCM, which needs double ones, gives way to SecondFundamentalForm.
  void setSingleKnots()
  {
    this->continuity = Continuity::SingleKnots;
    this->twist = this->twist == Twist::PCCM ? Twist::SecondFundamentalForm : this->twist;
  }
  /// c of (5.44), p_1/3 = c p_0 + (1 - c) p_1 across the wall; range (0, 1). Larger moves the layer to the wall.
  double wallSpacing = KnotInsertion;
  /// Take c = (2 + ln g) / (3 + ln g) instead, g = |p_2 - p_1| / |p_1 - p_0| the growth of the layers at each wall
  /// vertex: the value with which the spacing of the converted layers starts with the growth ln g per span.
  bool automaticWallSpacing = false;
  /// c per entry of BlockComplex::boundaryNames instead of these, NaN where none is given.
  std::vector<double> boundaryWallSpacing;
  /// Per block of the mesh: c at every mesh point, i fastest, or null; only points of the wall count, NaN marks those
  /// without a value. It has precedence over all of these. A wall vertex has one c: where boundaries or blocks give
  /// different ones, their mean. This and the arrays below: null for blocks of other ranks.
  std::vector<const double*> wallSpacingPoints;
  FarFieldSpacing farFieldSpacing = FarFieldSpacing::SideAverage;
  /// Per block of the mesh, whether it belongs to the far-field extension; blocks attached to it by an edge or a corner
  /// are found through it. Empty: the extension is recognised (FarField.h).
  std::vector<bool> extensionBlocks;
  /// How far what the rules of the outer surface changed is carried into the layers, which would fold otherwise: above
  /// extraordinary body vertices in local edge lengths (BodyPropagation.cpp), above creases in halves of the depth by
  /// which the smooth rule would round them (CreaseColumns.h). At least 0, 0 is off.
  double propagationRange = 8.0;
  /// The body, or null. Its closest points to the limit points of extraordinary body vertices, with normal and second
  /// fundamental form, take the place of what is estimated from the mesh.
  const BodySurface* body = nullptr;
  /// Per block of the mesh (not of the complex): given projection point and unit normal of every mesh point, three
  /// doubles each, i fastest, or null. NaN marks points without a value. Used at extraordinary body vertices only,
  /// where they have precedence over `body`.
  std::vector<const double*> projectedPoints;
  std::vector<const double*> surfaceNormals;
  /// Compute only control points on faces, edges and vertices that touch blocks at the wall, and leave all others as
  /// they are; no far-field spacing, no counts.
  bool wallOnly = false;
  CheckSpans checkSpans = CheckSpans::SpecialRules;
  /// Mesh points near spans that come out invalid although their mesh cells are valid are moved until the spans are
  /// valid or nothing more can be done. Points of the body never move.
  bool repairSpans = true;
  /// The same for spans whose mesh cells are invalid as well; all spans are then checked.
  bool untangle = false;
};

/// Knots of the blocks that a conversion makes, per block and direction: {0,0,0,0,1,2,..,I-1,I,I,I,I}, with ExactG1
/// also those of DoubleKnots.h. The same on all ranks.
std::vector<std::array<std::vector<double>, 3>> conversionKnots(
  const BlockComplex& complex, const ConversionOptions& options);

/// Where the control net of one block goes: as many triples and rules as its knots say, (I+3)(J+3)(K+3) with single
/// ones, i fastest, allocated by the caller. Null for blocks of other ranks.
struct ControlNetStorage
{
  double* points = nullptr;
  std::uint8_t* rules = nullptr;
};

/// What ExactG1 did.
struct G1Report
{
  /// Extraordinary edges that were joined, and layers of control points around them; layers left out.
  Index edges = 0;
  Index layers = 0;
  Index skippedLayers = 0;
  /// Of the latter those next to spans that the joins would have made invalid.
  Index givenUpLayers = 0;
  /// Extraordinary vertices of the wall: fitted to the body, of these with the smaller net, and joined by the linear
  /// rule alone.
  Index fittedVertices = 0;
  Index smallFits = 0;
  Index linearVertices = 0;
};

/// What became of the checked spans. Places are a block of the complex and a cell of it. With ExactG1 the spans of the
/// joined nets are checked; what is repaired before and what the joins give up counts as repaired.
struct SpanReport
{
  struct Place
  {
    int block;
    Ijk cell;
  };
  Index checked = 0;
  /// Not proven valid although the mesh cell is, before the repair; and valid after it.
  Index failed = 0;
  Index repaired = 0;
  /// Left after the repair: proven invalid, or not decided; and where, by block and cell.
  Index invalid = 0;
  Index undecided = 0;
  std::vector<Place> left;
  /// Not proven valid, and the mesh cell is not valid either: left alone; and those of them that are not decided.
  Index invalidCells = 0;
  Index undecidedCells = 0;
  Index movedPoints = 0;
  /// Largest move, as a length and in cells.
  double largestMove = 0.0;
  double largestMoveInCells = 0.0;
  int sweeps = 0;
};

struct ConversionReport
{
  /// Counted once per block that holds them.
  RuleCounts controlPoints{};
  Index singularNodes = 0;
  Index planarFaces = 0;
  /// What was borderline, one line each.
  std::vector<std::string> notes;
  /// Distances of the first inserted layer per side with a far-field extension (PerVertex: their mean).
  std::vector<double> extensionDistances;
  /// Places where this distance would reach over 2/3 of the extension's first cell and was cut to that.
  Index limitedDistances = 0;
  /// Smallest and largest c at the wall.
  std::array<double, 2> wallSpacing{ KnotInsertion, KnotInsertion };
  G1Report g1;
  SpanReport spans;
};

/// Converts every block. `nets` has one entry per block of the complex. Collective: every rank converts its own blocks
/// and gets the report of all.
/// Shared control points are computed once, by the entity that owns them, from sums that do not depend on the order of
/// their terms: results are the same bits for any numbering and orientation of the blocks, any distribution of them
/// over ranks and any `run`.
///
/// @param rules the decisions of classify() for this complex, if they were needed before (its points may have been
/// moved since then), else null.
/// @throws Error for options out of range, Aborted if the caller stops it.
ConversionReport convertToBSplineVolume(const BlockComplex& complex, const ConversionOptions& options,
  const std::vector<ControlNetStorage>& nets, const Execution& run = {}, const EntityRules* rules = nullptr);

} // namespace bsv
