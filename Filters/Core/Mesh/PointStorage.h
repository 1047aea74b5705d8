// SPDX-License-Identifier: BSD-3-Clause
/// @file PointStorage.h
/// Where the points of a structured grid are.
#pragma once

#include "Base/Types.h"

namespace bsv
{

class PointBoxes;
template <typename T>
class SparseArray;
/// Points of a grid that took the place of others, by their place in it.
using ChangedPoints = SparseArray<Vec3>;

/// Where the points of a grid are: in memory, as x y z triples of float or double of which some may have been changed
/// without a copy of the others; or on another rank, and here at most boxes that were fetched (PointExchange.h). It
/// owns nothing. A place is the number of a point in the grid, i fastest.
class PointStorage
{
public:
  /// All points are on another rank.
  PointStorage() = default;
  explicit PointStorage(const double* xyz)
    : Data(xyz)
  {
  }
  explicit PointStorage(const float* xyz)
    : Data(xyz)
    , IsFloat(true)
  {
  }
  explicit PointStorage(const PointBoxes* boxes)
    : Boxes(boxes)
  {
  }

  /// Whether all points are here.
  bool isHere() const { return this->Data != nullptr; }
  /// Whether none of the points is known here.
  bool isElsewhere() const { return !this->Data && !this->Boxes; }
  bool isFloat() const { return this->IsFloat; }
  /// Whether a point is known here.
  bool has(Index place) const { return this->isHere() || this->fetched(place); }

  /// Takes these points in place of those stored, which must be here; null: those stored.
  void change(const ChangedPoints* points) { this->Changes = points; }
  const ChangedPoints* changes() const { return this->Changes; }

  /// Address of a point as it was stored, and as the stored type. All points must be here.
  template <typename Real>
  const Real* address(Index place) const
  {
    return static_cast<const Real*>(this->Data) + 3 * place;
  }

  /// A point in double precision.
  /// @throws Error if it is on another rank and was not fetched.
  Vec3 at(Index place) const
  {
    if (!this->Data)
    {
      return this->remote(place);
    }
    if (this->Changes)
    {
      Index one = 1;
      if (const Vec3* x = this->changed(place, one))
      {
        return *x;
      }
    }
    if (this->IsFloat)
    {
      const float* x = this->address<float>(place);
      return Vec3(x[0], x[1], x[2]);
    }
    const double* x = this->address<double>(place);
    return Vec3(x[0], x[1], x[2]);
  }

  /// Calls copy(address, count) for the coordinates of `count` points from a place on, in runs that lie in one piece of
  /// memory: as doubles, or floats where they are stored. All points must be here.
  template <typename Copy>
  void forRuns(Index place, Index count, const Copy& copy) const
  {
    for (const Index end = place + count; place < end;)
    {
      Index run = end - place;
      const Vec3* x = this->Changes ? this->changed(place, run) : nullptr;
      if (x)
      {
        copy(x->data(), 3 * run);
      }
      else if (this->IsFloat)
      {
        copy(this->address<float>(place), 3 * run);
      }
      else
      {
        copy(this->address<double>(place), 3 * run);
      }
      place += run;
    }
  }

private:
  /// Address of a fetched point, or null.
  const double* fetched(Index place) const;
  Vec3 remote(Index place) const;
  /// The changed point at a place, or null. Cuts `count` to how many from there on are changed and follow it in memory,
  /// or are not changed.
  const Vec3* changed(Index place, Index& count) const;

  const void* Data = nullptr;
  bool IsFloat = false;
  /// If Data is null: what was fetched.
  const PointBoxes* Boxes = nullptr;
  const ChangedPoints* Changes = nullptr;
};

} // namespace bsv
