// SPDX-License-Identifier: BSD-3-Clause
/// @file ConversionCases.h
/// A mesh with its conversion, and measurements on it by evaluation.
#pragma once

#include "Complex/BlockComplex.h"
#include "Conversion/Conversion.h"
#include "Volume/BSplineVolume.h"

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace conversioncases
{

struct Converted
{
  bsv::BlockComplex complex;
  std::vector<std::vector<double>> points;
  std::vector<std::vector<std::uint8_t>> rules;
  std::vector<bsv::BSplineVolume> volumes;
  bsv::ConversionReport report;

  Converted() = default;
  Converted(Converted&&) = default;
  Converted& operator=(Converted&&) = default;

  bsv::Vec3 controlPoint(int block, const bsv::Ijk& position) const;
  bsv::ControlPointRule rule(int block, const bsv::Ijk& position) const;
  std::size_t index(int block, const bsv::Ijk& position) const;
};

Converted convert(const bsv::BlockMesh& mesh, const bsv::ConversionOptions& options = {},
  const bsv::BlockComplexOptions& complexOptions = {}, const bsv::Execution& run = {});

/// The conversion of `result.complex`.
void convertComplex(Converted& result, const bsv::ConversionOptions& options, const bsv::Execution& run = {});

/// Runs loops on two threads, in small ranges.
bsv::Execution twoThreads();

/// Jumps across all interfaces, as multiples of what rounding explains: 1e-12 of the derivative's size plus 64 machine
/// epsilons of the size of the coordinates nearby. Index: total order of the derivative, 0 to 2.
struct Jumps
{
  std::array<double, 3> worst{ 0.0, 0.0, 0.0 };
  std::array<bool, 3> exceeds() const { return { worst[0] > 1.0, worst[1] > 1.0, worst[2] > 1.0 }; }
  /// Interface points looked at, and those of them that are regular in their neighbourhood.
  bsv::Index points = 0;
  bsv::Index regular = 0;
  /// Shared control points that differ in any bit.
  bsv::Index openControlPoints = 0;
};

/// Evaluates all partial derivatives up to second order on both sides of every interface, at a few points of every
/// span. Jumps are taken where all control points of the span are regular (`Regular`, `Copied` or smooth boundary
/// rules).
Jumps interfaceJumps(const Converted& converted);

/// Spans whose Jacobian determinant is proven to have the sign of the block's handedness, and the others. Only the
/// spans for which `consider(block, span)` holds.
struct ProvenSpans
{
  bsv::Index valid = 0;
  bsv::Index others = 0;
};
ProvenSpans provenValid(
  const Converted& converted, const std::function<bool(int block, const bsv::Ijk& span)>& consider);

/// All control points and rules as one list that does not depend on numbering and orientation of the blocks: sorted by
/// coordinates. Equal lists mean equal bits.
std::vector<std::array<double, 4>> canonicalNet(const Converted& converted);

} // namespace conversioncases
