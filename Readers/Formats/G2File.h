// SPDX-License-Identifier: BSD-3-Clause
/// @file G2File.h
/// Objects of a GoTools `.g2` file: a header line (class, version, auxiliary data), then the data of the class.
///
/// Source: the read functions of the classes in SINTEF's GoTools, gotools-core and trivariate
/// (https://github.com/SINTEF-Geometry/GoTools).
#pragma once

#include "Formats/TextScanner.h"

#include <array>
#include <vector>

namespace bsv
{

///@{
/// Classes that readG2Spline() knows.
constexpr int G2Curve = 100;
constexpr int G2Surface = 200;
constexpr int G2Volume = 700;
///@}

/// "spline volume" for 700; "unknown" for classes that GoTools has not.
std::string nameOfG2Class(int code);

/// Spline curve, surface or volume; unused directions keep degree 0 and no knots.
struct G2Spline
{
  std::array<int, 3> degree{ 0, 0, 0 };
  std::array<std::vector<double>, 3> knots;
  /// First direction fastest. The points of rational objects, which the format stores multiplied by their weights, are
  /// divided by them.
  std::vector<Vec3> points;
  /// One per point, positive; empty if the object is polynomial.
  std::vector<double> weights;
};

/// Reads the header of an object and returns its class.
int readG2Header(TextScanner& in);

/// Reads what follows the header of an object of class G2Curve, G2Surface or G2Volume.
/// @throws Error unless degrees are 1..maxDegree, knots do not decrease, weights are positive, and surfaces and volumes
/// are three-dimensional.
G2Spline readG2Spline(TextScanner& in, int code, int maxDegree);

/// Moves behind the data of an object of any other class: to the next line that is the header of a class of GoTools, or
/// to the end. The data of no class holds such a line.
void skipG2Object(TextScanner& in);

/// Whether a text has a header of this class.
bool hasG2Class(const std::string& text, int code);

} // namespace bsv
