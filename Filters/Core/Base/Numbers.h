// SPDX-License-Identifier: BSD-3-Clause
/// @file Numbers.h
/// Three numbers as what ranks send of a point or vector; pi, degrees and angles.
#pragma once

#include "Base/Types.h"

#include <Eigen/Geometry>

#include <array>
#include <cmath>

namespace bsv
{

constexpr double Pi = 3.14159265358979323846;
constexpr double DegreesPerRadian = 180.0 / Pi;

/// A point or vector as plain numbers: ranks send it, and it can be a key of a map.
using Triple = std::array<double, 3>;

inline Triple triple(const Vec3& x)
{
  return { x[0], x[1], x[2] };
}
inline Vec3 vec3(const Triple& x)
{
  return Vec3(x[0], x[1], x[2]);
}

/// Unsigned angle between two vectors, radians, 0 to pi; 0 if one of them is zero.
inline double angleBetween(const Vec3& a, const Vec3& b)
{
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

} // namespace bsv
