// SPDX-License-Identifier: BSD-3-Clause
/// @file TensorPasses.h
/// Weighted sums over the control points of a B-spline block, one direction after the other: samples, Bezier points and
/// whatever else is linear in the control points and a product of the three directions.
///
/// The result is the same bits
/// - on both sides of a face at which two blocks meet, in any of the eight orientations, if both have the same control
///   points, and weight tables that mirror exactly, there and copy the face across (and so on shared edges and
///   corners);
/// - for any orientation of the block and for any Execution.
///
/// How: (1) Terms are added from both ends of the window inwards, in pairs: reversing changes nothing. (2) What remains
/// is which direction is summed first. On a face whose row copies it the weight across is exactly 1, so that only its
/// own net enters; both orders are computed and their mean is taken, which is symmetric. On an edge there is only one
/// order. Inside, the order of the directions follows from comparing the control nets, not from how the block happens
/// to be stored; only a block folded onto itself (a net that an exchange of directions maps to itself) leaves that
/// choice open.
#pragma once

#include "Base/Types.h"

#include <array>
#include <functional>
#include <vector>

namespace bsv
{

/// Weights of the control points of one direction, one row per result. Zeros at the ends of a row are left out.
struct WeightTable
{
  struct Window
  {
    int first; ///< control point of the first weight
    int count;
  };

  std::vector<Window> windows;
  std::vector<double> weights;
  std::size_t width = 0; ///< room per row in `weights`

  int rows() const { return static_cast<int>(this->windows.size()); }
  const double* at(int row) const { return this->weights.data() + row * this->width; }
  /// Whether the row is the first or last and copies one plane of control points.
  bool copiesEnd(int row) const
  {
    return (row == 0 || row + 1 == this->rows()) && this->windows[row].count == 1 && this->at(row)[0] == 1.0;
  }
  /// The rows [begin, end).
  WeightTable slice(int begin, int end) const;
};

/// Weights of point j = 0..parts of a span: degree + 1 values for the control points span - degree, ..
using SpanWeights = std::function<void(int span, int j, double* values)>;

/// Table with the rows 0..parts of every non-empty span, the last row of a span and the first of the next one being one
/// row, for which the mean of both is taken: equal up to rounding where they are the same, and symmetric.
WeightTable weightTable(int degree, const std::vector<double>& knots, int parts, const SpanWeights& weights);
/// The same with the rows 0..parts[n] of non-empty span n.
WeightTable weightTable(
  int degree, const std::vector<double>& knots, const std::vector<int>& parts, const SpanWeights& weights);

/// Control points, or anything else that there is one of per control point: i fastest.
struct ControlNet
{
  std::array<int, 3> counts{ 0, 0, 0 };
  int components = 3;
  const double* values = nullptr;
};

/// @param tables per direction, for the net's control points.
/// @param[out] results rows(0) * rows(1) * rows(2) times the net's components, i fastest.
/// @throws Aborted
void tensorPasses(
  const ControlNet& net, const std::array<WeightTable, 3>& tables, double* results, const Execution& run = {});

} // namespace bsv
