// SPDX-License-Identifier: BSD-3-Clause
/// @file FaceGeometry.h
/// The surface of a block face of a B-spline volume: points, exact unit normals and curvatures on a grid of samples.
///
/// With the tangents x_s, x_t of the face and its unit normal n, the first fundamental form E = x_s.x_s, F = x_s.x_t,
/// G = x_t.x_t and the second one L = x_ss.n, M = x_st.n, N = x_tt.n,
///
///   mean curvature     (E N - 2 F M + G L) / (2 (E G - F^2))     1 / length
///   Gaussian curvature (L N - M^2) / (E G - F^2)                 1 / length^2
///
/// Source: M. P. do Carmo, Differential Geometry of Curves and Surfaces, Prentice-Hall 1976, section 3.3.
#pragma once

#include "Volume/BSplineVolume.h"

#include <array>
#include <vector>

namespace bsv
{

struct FaceGeometry
{
  /// Samples along the first and the second axis of the face.
  std::array<int, 2> samples{ 0, 0 };
  /// Their parameters, ascending.
  std::array<std::vector<double>, 2> parameters;
  /// Per sample, first axis fastest.
  std::vector<Vec3> points;
  /// Unit length, into the block: out of a body that the volume surrounds. Where the tangents are parallel, as at a
  /// pole, that of a sample beside it.
  std::vector<Vec3> normals;
  /// Mean curvature, negative where the surface bends away from the normal, as that of a ball in the volume does.
  std::vector<double> mean;
  std::vector<double> gaussian;
};

/// Samples of face `face` (BlockTopology.h), every non-empty span cut into `parts` >= 1 equal parts per axis. At knots
/// the derivatives are those of the span to the right, at the last knot those of the last span.
/// @param bothSides two samples at knots where the face is only continuous (isRepeatedKnot()), one from either side
/// @param layer so many non-empty spans off the face, >= 0; at most at the opposite face
/// @param volume must have passed checkBSplineVolume(), its points must be here.
/// @throws Aborted
FaceGeometry faceGeometry(
  const BSplineVolume& volume, int face, int parts, const Execution& run = {}, int layer = 0, bool bothSides = false);

} // namespace bsv
