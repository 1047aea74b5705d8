// SPDX-License-Identifier: BSD-3-Clause
/// @file BodyFit.h
/// Makes the mesh of a body its Catmull-Clark control mesh: moves the wall's points so that their limit points lie
/// where the wall's points were, or on the given body.
///
/// Points of ordinary flow meshes lie on the body. Taken as control points they would shrink it by about curvature h^2
/// / 6.
#pragma once

#include "Body/ClosestPoint.h"
#include "Conversion/EntityRules.h"
#include "Mesh/GridView.h"

#include <array>

namespace bsv
{

/// How far the wall is from the body, on all ranks.
struct WallDistances
{
  Index wallPoints = 0;
  /// Largest distance of a mesh point of the wall, and of a limit point of the wall as a Catmull-Clark control mesh.
  double inputPoints = 0.0;
  double limitPoints = 0.0;
};

/// @throws Error that names both bounding boxes and the likely scale factor if a wall point is farther from the body
/// than a fifth of the wall's bounding-box diagonal: another unit, or another body.
/// @param rules those of classify(); the second form calls it.
///@{
WallDistances wallDistances(
  const BlockComplex& complex, const EntityRules& rules, const BodySurface& body, const Execution& run = {});
WallDistances wallDistances(
  const BlockComplex& complex, const ConversionOptions& conversion, const BodySurface& body, const Execution& run = {});
///@}

struct BodyFitOptions
{
  /// The body, or null: limit points then lie on the given points.
  const BodySurface* body = nullptr;
  /// The given points are control points and stay so, except on creases, borders and corners: where these follow an
  /// edge of the body, their limit points are moved to it. Needs `body`.
  bool edgesOnly = false;
  /// After that the wall is fitted to the body between its mesh points: least squares of the distances at 4 x 4 samples
  /// a span, then with more weight where they are large. Mesh points are then approximated, not interpolated; creases,
  /// borders, corners and the points around extraordinary vertices stay as they were found. Needs `body`, not with
  /// `edgesOnly`.
  bool leastSquares = false;
  /// The iteration stops when no limit point is farther from its target than this fraction of the wall's bounding-box
  /// diagonal. Range (0, 1).
  double tolerance = 1e-13;
  /// At most so many steps; at least 1.
  int iterations = 200;
  /// The displacement of a wall point is carried along its mesh line into the layers by the weight
  /// max(0, 1 - d / (range h)), d the distance from the wall, h the local edge length on it (thin layers would
  /// fold). At least 0.
  double range = 8.0;
};

/// The same on all ranks.
struct BodyFitReport
{
  Index wallPoints = 0;
  int iterations = 0;
  /// Largest distance of a limit point from its target, before and after.
  double initialResidual = 0.0;
  double residual = 0.0;
  /// Largest displacement of a wall point.
  double displacement = 0.0;
  /// With leastSquares: largest distance of a sample from the body, and root mean square, before and after.
  std::array<double, 2> sampleDistance{ 0.0, 0.0 };
  std::array<double, 2> sampleRms{ 0.0, 0.0 };
};

/// The solution: how every wall point moves, and how far that is carried. The same on all ranks.
struct WallFit
{
  BodyFitReport report;
  /// Per wall point the displacement, its reach into the layers, and where its limit point should lie.
  std::vector<Vec3> displacements;
  std::vector<double> reaches;
  std::vector<Vec3> targets;
};

/// Solves L p = t, where L p are the points through which the converted wall passes: the limit masks (3.31), creases
/// and corners as in the conversion, and around extraordinary and creased vertices what their rules make of them. By
/// Chebyshev iteration (Golub, Varga 1961) without scalar products, so that results are the same bits for any numbering
/// and orientation of the blocks. Collective: every rank knows the whole wall and computes a part of the closest
/// points.
/// @throws Error if it does not converge (a cube of six quadrilaterals cannot take any eight limit points), or for
/// options out of range; Aborted.
WallFit solveFit(const BlockComplex& complex, const ConversionOptions& conversion, const EntityRules& rules,
  const BodyFitOptions& options, const Execution& run = {});

/// Moves the points of the wall by the share of each of its displacement, and with them the layers above it: of the
/// blocks on this rank. Their views show the moved points in place of the stored ones afterwards (GridView::changed,
/// BlockComplex::changedPoints); memory is needed for the moved points, not for the blocks. Collective: displacements
/// are sent on along mesh lines to the ranks of the next blocks. What a rank receives grows with the wall, not with the
/// volume.
/// @param shares per wall point, 0 to 1; empty: all 1.
void applyFit(BlockComplex& complex, const EntityRules& rules, const WallFit& fit, const std::vector<double>& shares,
  const Execution& run = {});

/// Multiplies the shares of wall points by `factor` whose mesh lines, within reach, touch one of the cells `places`.
/// Collective. @return whether there are any.
bool lowerShares(const BlockComplex& complex, const EntityRules& rules, const WallFit& fit,
  const std::vector<SpanReport::Place>& places, double factor, std::vector<double>& shares, const Ranks& ranks);

/// solveFit() and applyFit() with all shares 1.
/// @param rules those of classify(), which hold for the moved points as well; the second form calls it.
///@{
BodyFitReport fitBody(BlockComplex& complex, const ConversionOptions& conversion, const EntityRules& rules,
  const BodyFitOptions& options, const Execution& run = {});
BodyFitReport fitBody(
  BlockComplex& complex, const ConversionOptions& conversion, const BodyFitOptions& options, const Execution& run = {});
///@}

/// How far the converted wall is from the wall's mesh points: its limit points from these. The same on all ranks.
struct WallMotion
{
  Index wallPoints = 0;
  /// Largest and median, as lengths and in heights of the first cell above the point.
  double largest = 0.0, median = 0.0;
  double largestInCells = 0.0, medianInCells = 0.0;
  /// The mesh point with the largest distance; of several the smallest.
  Vec3 where = Vec3::Zero();
};

/// @param given the mesh, @param fitted the same or with its wall moved. Collective.
WallMotion wallMotion(const BlockComplex& given, const BlockComplex& fitted, const ConversionOptions& conversion,
  const EntityRules& rules, const Execution& run = {});

/// Wall points, not on creases, at which the wall's cells differ by more than 4 : 1 across a bend of more than 45
/// degrees: there interpolation overshoots. Collective.
Index bluntPoints(const BlockComplex& complex, const EntityRules& rules, const Ranks& ranks);

} // namespace bsv
