// SPDX-License-Identifier: BSD-3-Clause
/// @file Sampling.h
/// A B-spline block, or one of its first derivatives, on a structured grid of samples.
///
/// At level L every non-empty knot span is cut into 2^L equal parts, so that n spans give n 2^L + 1 samples. Sums are
/// factorised: three one-dimensional passes instead of one sum over (degree + 1)^3 terms.
///
/// The result is the same bits
/// - on both sides of a face at which two blocks meet, in any of the eight orientations, if both have the same control
///   points, degrees and knot spacings there and clamped knots across it (and so on shared edges and corners);
/// - at the samples that two levels have in common;
/// - for any orientation of the block (derivatives change their sign with the direction) and for any Execution.
///
/// How: basis values are functions of the span, the fraction j / 2^L in it and the knot differences around it, and
/// reversing the direction mirrors them exactly; on a knot the mean of the two sides is taken, which are equal up to
/// rounding where the volume is smooth and symmetric where it is not. The sums are those of TensorPasses.h.
#pragma once

#include "Volume/BSplineVolume.h"

namespace bsv
{

constexpr int MaxSamplingLevel = 8;

/// Per direction the level of every non-empty span, each 0..MaxSamplingLevel. Samples of unequal levels are among those
/// of the highest one, bit for bit.
using SpanLevels = std::array<std::vector<int>, 3>;

/// The same level for all spans. @throws Error, beginning with `name`, if it is not in 0..MaxSamplingLevel.
SpanLevels uniformLevels(const BSplineVolume& volume, int level, const std::string& name);

/// Samples per direction at `level`.
/// @throws Error, beginning with `name`, if the level is not in 0..MaxSamplingLevel or there are more samples than an
/// int per direction or 2^63 bytes in all can hold.
std::array<int, 3> sampleCounts(const BSplineVolume& volume, int level, const std::string& name);
std::array<int, 3> sampleCounts(const SpanLevels& levels, const std::string& name);

/// The parameters of the samples in one direction.
std::vector<double> sampleParameters(const BSplineVolume& volume, int direction, int level);
std::vector<double> sampleParameters(const BSplineVolume& volume, int direction, const std::vector<int>& levels);

/// Values (derivative {0,0,0}) or derivatives, with orders 0 or 1 per direction, at all samples.
/// The volume must have passed checkBSplineVolume().
/// @param[out] samples triples, i fastest, for sampleCounts() points.
/// @throws Error for other orders, Aborted.
void sample(const BSplineVolume& volume, int level, const std::array<int, 3>& derivative, double* samples,
  const Execution& run = {});

/// The same with a level per span.
void sample(const BSplineVolume& volume, const SpanLevels& levels, const std::array<int, 3>& derivative,
  double* samples, const Execution& run = {});

/// Values with every non-empty span cut into `parts` equal parts, any number from 1: n spans give n parts + 1 samples.
void sampleEqually(const BSplineVolume& volume, int parts, double* samples, const Execution& run = {});

} // namespace bsv
