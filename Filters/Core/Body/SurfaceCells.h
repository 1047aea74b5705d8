// SPDX-License-Identifier: BSD-3-Clause
/// @file SurfaceCells.h
/// The small cells into which patches and edges of a body are cut, once, for the search of closest points.
#pragma once

#include "Body/NURBSSurface.h"
#include "Body/TrimRegion.h"

#include <Eigen/Geometry>

#include <vector>

namespace bsv
{

/// Cells are not halved further when their radius is this fraction of the body's size.
constexpr double SmallestCell = 2e-4;
/// Distance, in units of a cell, at which one-sided derivatives at its ends are taken.
constexpr double EndShift = 1e-9;

/// Smooth part of a patch.
struct SurfacePiece
{
  int patch;
  NURBSSurface surface;
};

/// Small part of a piece, or of an edge (piece -1).
struct SurfaceCell
{
  Eigen::AlignedBox3d box;
  int piece = -1;
  int edge = -1;
  /// Parameter ranges; of an edge only the first.
  double u0 = 0.0, u1 = 0.0, v0 = 0.0, v1 = 0.0;
  bool crossed = false;
  /// Ball around all points, and cones around all tangents per whole cell.
  Vec3 center = Vec3::Zero();
  double radius = 0.0;
  Vec3 tangentU = Vec3::Zero();
  Vec3 tangentV = Vec3::Zero();
  double spreadU = 0.0, spreadV = 0.0;
};

struct SurfaceEdge
{
  int patch;
  ParameterCurve curve;
  /// Kinks count only inside the loops; trimming curves always.
  bool kink;
};

/// Point of an edge with its first two derivatives.
struct CurvePoint
{
  Vec2 uv;
  Vec3 x, d1, d2;
};

CurvePoint evaluateEdge(const NURBSSurface& surface, const ParameterCurve& curve, double t);

/// Appends the cells of one piece, by halving the Bezier nets of its spans until directions of tangents vary little.
/// @param smallest radius below which cells are not halved.
void pieceCells(
  const SurfacePiece& piece, int index, const TrimRegion& region, double smallest, std::vector<SurfaceCell>& cells);

/// Cells of one edge. Their boxes come from samples and are widened by twice the sag that the samples show.
void edgeCells(const NURBSSurface& surface, const ParameterCurve& curve, int index, double smallest,
  std::vector<SurfaceCell>& cells);

/// Kinks of a surface: its inner knots of multiplicity degree, as lines over the domain.
std::vector<ParameterCurve> kinkLines(const NURBSSurface& surface);

} // namespace bsv
