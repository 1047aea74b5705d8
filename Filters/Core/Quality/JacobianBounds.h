// SPDX-License-Identifier: BSD-3-Clause
/// @file JacobianBounds.h
/// Certified bounds of the Jacobian determinant of every span of a B-spline volume, and with them its validity.
///
/// J is the derivative of x with respect to the parameters in [0, 1] of the span, not to those of the knots: its
/// determinant is of the size of the span's volume, and has the same sign.
///
/// On a span of degree p per direction det J is a polynomial of degree 3 p - 1 per direction, for rational volumes a
/// polynomial of degree 4 p - 1 divided by w^4. It lies between the smallest and the largest of its Bernstein
/// coefficients, of which those at the corners are values of it; halving the span brings them as close as wanted. All
/// rounding errors, from the control points on, are bounded a priori (derived in JacobianBounds.cpp) and count
/// against the verdict: `Valid` and `Invalid` are proofs about the volume that these very numbers define.
///
/// The results of a span depend only on its own control points, weights and knot differences: they are the same bits
/// for any orientation of the block, apart from a reflected one's sign and order of bounds, and for any Execution. Left
/// open is only a span that an exchange of directions maps to itself.
#pragma once

#include "Mesh/BlockTopology.h"
#include "Quality/JacobianKernel.h"
#include "Volume/BSplineVolume.h"

#include <cstdint>
#include <string>
#include <vector>

namespace bsv
{

enum class Validity : std::uint8_t
{
  Valid,    ///< det J > 0 everywhere on the closed span
  Invalid,  ///< det J <= 0 at a known point
  Undecided ///< neither is proven: det J is zero somewhere up to rounding, or the depth does not suffice
};

/// "valid", "invalid", "undecided": index is the code.
const std::vector<std::string>& validityNames();

constexpr int MaxJacobianDepth = 48;

struct JacobianOptions
{
  /// An undecided span is halved, across the direction in which det J varies most, at most so many times in a row; 0 to
  /// MaxJacobianDepth. A span is given up after some thousand parts.
  int maxDepth = 24;
  /// Witnesses that are kept: those of the first invalid spans.
  Index maxWitnesses = 1000000;
  /// det J is multiplied by -1: for blocks of a left-handed mesh, whose spans then count as valid where they are.
  bool leftHanded = false;
  /// Only these spans, numbers u fastest, ascending; arrays have one entry for each. Null: all spans. Control points
  /// that are not finite are not refused then, their spans are undecided.
  const std::vector<Index>* spans = nullptr;
  /// @name How the kernel runs; no result depends on it.
  ///@{
  InstructionSet instructions = instructionSets().back();
  bool specialised = true;
  ///@}
};

/// Where results go: one number per non-empty span, u fastest, or null.
struct JacobianArrays
{
  /// Codes of Validity.
  unsigned char* validity = nullptr;
  /// lower <= det J <= upper on the whole span.
  double* lower = nullptr;
  double* upper = nullptr;
  /// Smallest det J / (|x_u| |x_v| |x_w|) of the span's eight corners and its centre: -1 to 1, 1 where the parameter
  /// lines are at right angles. 0 where a derivative vanishes. (P. M. Knupp, Algebraic mesh quality metrics, SIAM J.
  /// Sci. Comput. 23, 2001, doi:10.1137/S1064827500371499, there for the corners of a hexahedron.)
  double* scaledJacobian = nullptr;
  /// Equiangle skew: largest |90 - angle| / 90 of the angles in degrees between any two of x_u, x_v, x_w at the same
  /// points; 0 to 1, 0 is best. (Verdict geometric quality library, SAND2007-1751: "equiangle skew", there of the
  /// angles between edges.)
  double* skewness = nullptr;
};

/// A point of an invalid span at which det J <= 0.
struct JacobianWitness
{
  /// Number of the span, u fastest, among the non-empty ones.
  Index span = 0;
  Ijk ijk{ 0, 0, 0 };
  /// The point in the span, 0 to 1; exact.
  Vec3 fraction = Vec3::Zero();
  /// The same in the knots' parameters, rounded.
  Vec3 uvw = Vec3::Zero();
  /// det J there is not larger than this.
  double value = 0.0;
};

struct JacobianReport
{
  Index valid = 0;
  Index invalid = 0;
  Index undecided = 0;
  /// Spans with upper < 0: all of them where a block is left-handed.
  Index negative = 0;
  /// The smallest lower bound, and its span.
  double lowest = 0.0;
  Index lowestSpan = -1;
  /// One per invalid span, ascending; at most JacobianOptions::maxWitnesses.
  std::vector<JacobianWitness> witnesses;
};

/// The volume must have passed checkBSplineVolume().
/// @throws Error, beginning with `name`, for control points or differences of knots that are not finite and for options
/// out of range; Aborted.
JacobianReport jacobianBounds(const BSplineVolume& volume, const std::string& name, const JacobianOptions& options = {},
  const JacobianArrays& arrays = {}, const Execution& run = {});

} // namespace bsv
