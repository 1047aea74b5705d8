// SPDX-License-Identifier: BSD-3-Clause
/// @file BodyEdges.h
/// Where a body has sharp edges.
#pragma once

#include "Body/ClosestPoint.h"

namespace bsv
{

/// The largest angle between the normals of the parts of a body that meet near a point: patches, both sides of a kink
/// or seam, that are at most 1/50 of `length` further away than the nearest.
/// @param length of the mesh edges at the point.
/// @return degrees, 0 to 180.
double bodyTurn(const BodySurface& body, const Vec3& point, double length);

/// Whether an edge of the body (BodySurface::closestEdgePoint) is one of its shape: sharp, or where the body ends.
/// Edges along which it goes on with the same normal are seams of its description.
/// @param edge a point on it, @param length of the mesh edges at the point.
bool isShapeEdge(const BodySurface& body, const Vec3& edge, double length);

} // namespace bsv
