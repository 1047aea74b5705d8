// SPDX-License-Identifier: BSD-3-Clause
/// @file Types.h
/// Vocabulary shared by the whole core: points, errors and the execution environment.
///
/// The core is C++17 and Eigen; it includes no VTK header. Callers (the VTK filters, the tests, the
/// benchmarks) hand in views of their own memory and an Execution that says how loops are run.
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>

/// @name Version of Eigen
/// The library and what uses its headers must be compiled with the same version of Eigen: two in one process would give
/// wrong results silently. Every file that includes this refers to a symbol that is named after its version, and the
/// library has the one of its own, so a mixture does not link: "undefined reference to BSplineVolume_uses_Eigen_3_4".
///@{
#define BSV_EIGEN_NAME(world, major) BSplineVolume_uses_Eigen_##world##_##major
#define BSV_EIGEN_NAME_OF(world, major) BSV_EIGEN_NAME(world, major)
#define BSV_EIGEN_SYMBOL BSV_EIGEN_NAME_OF(EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION)
extern "C" const char BSV_EIGEN_SYMBOL;
#ifdef __GNUC__
[[gnu::used]] static const char* const bsvEigenVersion = &BSV_EIGEN_SYMBOL;
#endif
///@}

namespace bsv
{

using Vec3 = Eigen::Vector3d;

/// Number of points, cells or control points; 64 bits everywhere.
using Index = std::int64_t;

/// The only exception thrown by the core. The text names what is wrong, where (file, line, block, face) and the value.
class Error : public std::runtime_error
{
public:
  using std::runtime_error::runtime_error;
};

/// Thrown by Execution::report when the caller asked to stop.
class Aborted : public Error
{
public:
  Aborted()
    : Error("aborted by the user")
  {
  }
};

class Ranks;
/// The one of a process that is alone.
std::shared_ptr<const Ranks> aloneRank();

/// How loops are run, progress is told, and who else takes part. Default: sequential, silent and alone.
/// No result of the core depends on it.
struct Execution
{
  /// Runs body(begin, end) over a partition of [0, count) into ranges of about `grain`; may run them concurrently.
  using Body = std::function<void(Index begin, Index end)>;
  std::function<void(Index count, Index grain, const Body& body)> parallelFor = [](Index count, Index,
                                                                                  const Body& body) {
    if (count > 0)
    {
      body(0, count);
    }
  };

  /// Told the fraction done in [0, 1], from the calling thread only; returns false to abort.
  std::function<bool(double)> progress = [](double) { return true; };

  /// The processes that share the mesh (Ranks.h).
  std::shared_ptr<const Ranks> ranks = aloneRank();

  /// @throws Aborted if the caller wants to stop.
  void report(double fraction) const
  {
    if (!this->progress(fraction))
    {
      throw Aborted();
    }
  }
};

} // namespace bsv
