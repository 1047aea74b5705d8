// SPDX-License-Identifier: BSD-3-Clause
/// @file WingFuselageBody.h
/// Half model of a wing and a fuselage as nine NURBS patches.
///
/// x points downstream, y along the span, z up; the symmetry plane is y = 0. The fuselage has the length 6 and the
/// radius 0.5 in the middle. The wing is swept, tapered and twisted, with a symmetric section of square-root leading
/// edge (class function of B. M. Kulfan, J. Aircraft 45(1), 2008, doi:10.2514/1.29958), 14 % thick, with a blunt
/// trailing edge. The tip is round at the leading edge and becomes sharp-rimmed towards the trailing edge.
///
/// Patch p has the parameters a, b in [0, 1] and the outward normal x_a x x_b:
///
/// | p | patch                          | a from .. to   | b from .. to |
/// |---|--------------------------------|----------------|--------------|
/// | 0 | fuselage, front with the nose  | lower .. upper | symmetry plane .. junction |
/// | 1 | fuselage, top                  | front .. rear  | the same |
/// | 2 | fuselage, rear with the tail   | upper .. lower | the same |
/// | 3 | fuselage, bottom               | rear .. front  | the same |
/// | 4 .. 7 | wing: leading edge, upper side, trailing edge, lower side | as 0 .. 3 | junction .. tip |
/// | 8 | wing tip                       | lower .. upper | leading .. trailing edge |
#pragma once

#include "Body/NURBSSurface.h"

#include <array>
#include <vector>

namespace bsv
{

struct WingFuselageShape
{
  /// From the symmetry plane to the wing tip. Range [2, 6].
  double span = 3.5;
  /// Of the line through the quarter chords, degrees. Range [0, 45].
  double sweepAngle = 25.0;
};

/// @throws Error that names the property unless low <= value <= high.
void checkRange(const char* name, double value, double low, double high);

/// @throws Error for a shape out of range.
void checkWingFuselageShape(const WingFuselageShape& shape);

constexpr int WingFuselagePatches = 9;

/// Side of a patch: 0 a=0, 1 a=1, 2 b=0, 3 b=1.
struct PatchSide
{
  int patch;
  int side;
};

/// Two sides that are one curve.
struct PatchSeam
{
  PatchSide first;
  PatchSide second;
  /// Whether the second side runs against the first.
  bool reversed;
  /// Whether the surface has a crease there.
  bool crease;
};

/// All seams: every side is in one, but those of patches 0..3 at b=0, which lie in the symmetry plane.
const std::vector<PatchSeam>& wingFuselageSeams();

/// The patches: bicubic, non-rational, with the same uniform knots, interpolating the shape. Control points of sides
/// that are one curve are equal bit for bit, so the body has no gaps; those in the symmetry plane have y = 0.
/// @throws Error for a shape out of range.
std::vector<BodyPatch> wingFuselageBody(const WingFuselageShape& shape);

} // namespace bsv
