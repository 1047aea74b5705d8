// SPDX-License-Identifier: BSD-3-Clause
/// @file JoinEvaluation.h
/// Values and jumps at one point of a join.
#pragma once

#include "Base/Numbers.h"
#include "Quality/Join.h"
#include "Quality/SurfaceTrace.h"

#include <array>
#include <limits>

namespace bsv
{

/// What counts as rounding, relative to the size of the coordinates.
constexpr double JumpRounding = 64.0 * std::numeric_limits<double>::epsilon();

/// Basis functions of a trace along one axis, at one place.
struct TraceBasis
{
  int first = 0;
  std::array<double, MaxDegree + 1> values{};
  std::array<double, MaxDegree + 1> slopes{};
  double length = 0.0; ///< of the span
};

/// Span of a join along one axis: a part of one knot span of either side.
struct JoinSpan
{
  struct Part
  {
    int span = 0;
    double start = 0.0;               ///< parameter
    double before = 0.0, after = 0.0; ///< from the knot before and to the knot after it
    double width = 0.0;
  };
  std::array<Part, 2> parts;
  /// Derivatives along the join may be discontinuous at its end.
  bool breaksAfter = false;
};

/// The basis of a trace's axis k at the fraction x of a part of a span; rest = 1 - x.
TraceBasis basisAt(const Trace& trace, int k, const JoinSpan::Part& part, double x, double rest);

/// What one side says at a point. Vectors that are zero up to rounding are zero.
struct SideValues
{
  Vec3 x, s, t, n, n2;
};

SideValues evaluateSide(const Trace& trace, const TraceBasis& s, const TraceBasis& t);

/// @param boundToKink the layers through s and t
Jumps jumpsOf(const SideValues& a, const SideValues& b, double length, const std::array<bool, 2>& boundToKink);

/// Points of a block face: `parts` equal parts of every span per axis.
struct FaceSamples
{
  std::array<int, 2> samples{ 0, 0 };
  std::vector<Vec3> points; ///< first face axis fastest
};
FaceSamples sampleFace(const BSplineVolume& volume, int face, int parts);

} // namespace bsv
