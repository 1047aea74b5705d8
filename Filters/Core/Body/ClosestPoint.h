// SPDX-License-Identifier: BSD-3-Clause
/// @file ClosestPoint.h
/// Closest points on a body of trimmed rational B-spline patches.
///
/// The closest point of a patch is a foot point inside its trimming loops, or lies on one of its edges: trimming
/// curves, sides of an untrimmed domain, and kinks (inner knots of multiplicity degree). Patches and edges are cut,
/// once, into small cells on which directions of tangents vary by less than about 10 degrees, with boxes from their
/// Bezier points. A query visits the cells of a bounding volume tree in the order of their least possible distance,
/// skips those that cannot hold a foot point because a tangent direction never becomes normal to the connecting vector,
/// and runs a safeguarded Newton iteration on the exact surface or edge in the others, until no cell can be closer.
/// Then it looks at parts of the cells where the distance may have several minima, as far as these can be closer than
/// what was found.
///
/// A result depends on the query and the body alone: not on threads, nor on other queries.
#pragma once

#include "Body/NURBSSurface.h"

#include <Eigen/Geometry>

#include <memory>
#include <vector>

namespace bsv
{

/// A point of a body.
struct BodyPoint
{
  /// Index of the patch; -1: the body is empty.
  int patch = -1;
  /// Parameters on the patch.
  double u = 0.0;
  double v = 0.0;
  /// From the query.
  double distance = 0.0;
  /// Whether it lies on an edge: the connecting vector need not be normal to the surface then.
  bool onEdge = false;
  /// Point, normal and fundamental forms of the patch at (u,v), the normal outward (BodyPatch::reversed).
  SurfaceGeometry geometry;
};

class BodySurface
{
public:
  /// @throws Error for what checkBodyPatch() refuses; patches without a name are called by their index.
  explicit BodySurface(std::vector<BodyPatch> patches, const Execution& run = {});
  ~BodySurface();
  BodySurface(BodySurface&&) noexcept;
  BodySurface& operator=(BodySurface&&) noexcept;

  const std::vector<BodyPatch>& patches() const;
  /// Box of all control points of cells that are not trimmed away; empty for an empty body.
  const Eigen::AlignedBox3d& bounds() const;
  /// Diagonal of bounds(), the length that tolerances refer to.
  double size() const;

  /// Closest point. Where several patches, or both sides of a seam, share it (to 1e-12 of the size), the owner is the
  /// patch of the lowest index, and on it the lowest u, then v.
  /// The foot point's residual |(query - point) . x_u| / |x_u| is at most about 1e-14 of size and distance.
  BodyPoint closestPoint(const Vec3& query) const;

  /// closestPoint() of every query.
  std::vector<BodyPoint> closestPoints(const std::vector<Vec3>& queries, const Execution& run = {}) const;

  /// The closest point of every patch whose distance exceeds the least by at most `tolerance` (a length): the patches
  /// that meet at a seam, an edge or a corner, by their index. A patch can appear more than once, at a seam of its own.
  std::vector<BodyPoint> closestPointPerPatch(const Vec3& query, double tolerance) const;

  /// Closest point on an edge: trimming curves, sides of untrimmed domains, kinks. Owner as for closestPoint().
  BodyPoint closestEdgePoint(const Vec3& query) const;

private:
  struct Locator;
  std::unique_ptr<const Locator> Data;
};

} // namespace bsv
