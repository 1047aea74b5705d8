// SPDX-License-Identifier: BSD-3-Clause
/// @file SpanCheck.h
/// Which spans of converted nets are looked at, and which of these are not proven valid.
#pragma once

#include "Conversion/ConversionContext.h"
#include "Quality/JacobianBounds.h"
#include "Volume/BSplineVolume.h"

#include <array>
#include <map>
#include <utility>
#include <vector>

namespace bsv
{

/// Block and number of the span, u fastest.
using SpanId = std::pair<int, Index>;
/// Numbers of spans per block, ascending.
using SpanLists = std::map<int, std::vector<Index>>;

/// The converted nets, with single knots or with those of ConversionContext::doubled.
class CheckedNets
{
public:
  explicit CheckedNets(const ConversionContext& context)
    : Context(context)
  {
  }

  const ConversionContext& context() const { return this->Context; }
  BSplineVolume volume(int block) const;
  /// The mesh cell that a span is a part of: the span itself where knots are single.
  Ijk cellOf(const SpanId& id) const;
  /// First control point of a span, per direction.
  Ijk firstControlPoint(const SpanId& id) const;
  /// The spans of a block that ConversionOptions::checkSpans asks for.
  std::vector<Index> chosenSpans(int block) const;

private:
  /// Per span of a direction that is not empty: the knot before it.
  std::vector<int> spansAlong(int block, int d) const;
  std::vector<double> knots(int block, int d) const;
  std::vector<Index> specialSpans(int block) const;

  const ConversionContext& Context;
};

/// The mesh cell of a span with single knots, and the other way round.
///@{
Ijk cellOf(const ComplexBlock& block, Index span);
Index spanOf(const ComplexBlock& block, const Ijk& cell);
///@}

/// Corners of a cell of the mesh as it was given, before its wall was moved onto a body.
std::array<Vec3, 8> givenCorners(const ComplexBlock& block, const Ijk& cell);
/// Whether the trilinear cell is proven to have a positive Jacobian determinant.
bool isValidCell(const ComplexBlock& block, const std::array<Vec3, 8>& corners);

/// Spans for which no proof of det J > 0 was found, with the codes of Validity.
std::map<SpanId, Validity> failingSpans(const CheckedNets& nets, const SpanLists& lists, const Execution& run);

/// Those of all spans that ConversionOptions::checkSpans asks for. Collective.
/// @param[out] checked their number, on all ranks.
std::map<SpanId, Validity> failingSpans(const CheckedNets& nets, Index& checked, const Execution& run);

} // namespace bsv
