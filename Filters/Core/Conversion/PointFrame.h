// SPDX-License-Identifier: BSD-3-Clause
/// @file PointFrame.h
/// How a mesh point may move, and in which steps.
#pragma once

#include "Conversion/ConversionContext.h"

#include <Eigen/Core>

namespace bsv
{

/// How a mesh point may move.
enum class Freedom : std::uint8_t
{
  Inner,
  Surface, ///< on the outer surface; in its plane, where it is one
  Curve,   ///< on a crease or border of it
  Fixed
};

Freedom freedomOf(const ConversionContext& context, const MeshPointKey& key);

/// What a step in units of cells is in space, and back.
struct PointFrame
{
  /// By columns.
  std::array<double, 9> step;
  std::array<double, 9> cells;

  Eigen::Matrix3d stepMatrix() const { return Eigen::Map<const Eigen::Matrix3d>(this->step.data()); }
  Eigen::Matrix3d cellMatrix() const { return Eigen::Map<const Eigen::Matrix3d>(this->cells.data()); }
};

/// The square root of the mean of e e^T over the cells' edges at a point, projected onto what it may move on. All
/// points around must be known on this rank.
PointFrame pointFrame(const ConversionContext& context, const MeshPointKey& key);

} // namespace bsv
