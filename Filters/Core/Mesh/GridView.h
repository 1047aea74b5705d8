// SPDX-License-Identifier: BSD-3-Clause
/// @file GridView.h
/// View of the points of a structured grid.
#pragma once

#include "Base/Types.h"

#include <array>
#include <type_traits>

namespace bsv
{

class PointBoxes;
template <typename T>
class SparseArray;
/// Points of a grid that took the place of others, by their place in it.
using ChangedPoints = SparseArray<Vec3>;

/// View of the points of a structured grid, or of a box of one: float or double triples, i fastest in the grid viewed.
/// It owns nothing.
///
/// Some points may have been changed without a copy of the others. Of a grid that another rank has it knows the size,
/// and boxes of points that were fetched (PointExchange.h).
class GridView
{
public:
  GridView() = default;

  /// Grid whose points are on another rank.
  static GridView elsewhere(const std::array<int, 3>& pointCounts)
  {
    return GridView(static_cast<const double*>(nullptr), pointCounts);
  }
  /// Grid of which only some boxes are known.
  explicit GridView(const PointBoxes* boxes);

  /// Whole grid of nx * ny * nz points stored contiguously as x y z triples.
  template <typename Real>
  GridView(const Real* xyz, std::array<int, 3> pointCounts)
    : Data(xyz)
    , IsFloat(sizeof(Real) == sizeof(float))
    , Counts(pointCounts)
    , Strides{ 1, pointCounts[0], Index(pointCounts[0]) * pointCounts[1] }
  {
    static_assert(std::is_same<Real, float>::value || std::is_same<Real, double>::value, "float or double");
  }

  /// Points per direction.
  const std::array<int, 3>& counts() const { return this->Counts; }
  Index size() const { return Index(this->Counts[0]) * this->Counts[1] * this->Counts[2]; }
  bool isFloat() const { return this->IsFloat; }
  /// Whether all points are here, which address() needs.
  bool isHere() const { return this->Data != nullptr; }
  /// Whether none of the points is known here.
  bool isElsewhere() const { return !this->Data && !this->Boxes; }
  /// The same view with these points in place of those stored, which it needs to be here.
  GridView changed(const ChangedPoints* points) const
  {
    GridView view = *this;
    view.Changes = points;
    return view;
  }
  const ChangedPoints* changes() const { return this->Changes; }
  /// Place of point (0, 0, 0) in the grid of which this is a box, in points.
  Index start() const { return this->Start; }
  /// Whether point (i, j, k) is known here.
  bool has(const std::array<int, 3>& ijk) const { return this->isHere() || this->fetched(this->offset(ijk)); }
  /// Distance, in points, between neighbours of direction d in memory.
  Index stride(int d) const { return this->Strides[d]; }

  /// Address of point (i, j, k) as it was stored, and as the stored type.
  template <typename Real>
  const Real* address(int i, int j, int k) const
  {
    return static_cast<const Real*>(this->Data) + 3 * this->offset(i, j, k);
  }

  /// Place of point (i, j, k) in memory, in points: linear in i, j and k.
  Index offset(const std::array<int, 3>& ijk) const { return this->offset(ijk[0], ijk[1], ijk[2]); }
  /// The point at an offset, in double precision.
  /// @throws Error if it is on another rank and was not fetched.
  Vec3 atOffset(Index offset) const
  {
    if (!this->Data)
    {
      return this->remote(offset);
    }
    if (this->Changes)
    {
      Index one = 1;
      if (const Vec3* x = this->change(offset, one))
      {
        return *x;
      }
    }
    const Index at = 3 * offset;
    if (this->IsFloat)
    {
      const float* x = static_cast<const float*>(this->Data) + at;
      return Vec3(x[0], x[1], x[2]);
    }
    const double* x = static_cast<const double*>(this->Data) + at;
    return Vec3(x[0], x[1], x[2]);
  }
  /// Point (i, j, k), in double precision.
  Vec3 operator()(int i, int j, int k) const { return this->atOffset(this->offset(i, j, k)); }
  Vec3 operator()(const std::array<int, 3>& ijk) const { return (*this)(ijk[0], ijk[1], ijk[2]); }

  /// Calls copy(address, count) for the coordinates of points (first..last, j, k), in runs that lie in one piece of
  /// memory: as doubles, or floats where they are stored. All points must be here.
  template <typename Copy>
  void forRuns(int first, int last, int j, int k, const Copy& copy) const
  {
    for (int i = first; i <= last;)
    {
      Index count = last - i + 1;
      const Vec3* x = this->Changes ? this->change(this->offset(i, j, k), count) : nullptr;
      if (x)
      {
        copy(x->data(), 3 * count);
      }
      else if (this->IsFloat)
      {
        copy(this->address<float>(i, j, k), 3 * count);
      }
      else
      {
        copy(this->address<double>(i, j, k), 3 * count);
      }
      i += static_cast<int>(count);
    }
  }

  /// The box of points [first, last], both included.
  GridView box(const std::array<int, 3>& first, const std::array<int, 3>& last) const
  {
    GridView view = *this;
    const Index at = this->offset(first[0], first[1], first[2]);
    view.Start += at;
    if (this->Data)
    {
      view.Data = this->IsFloat ? static_cast<const void*>(static_cast<const float*>(this->Data) + 3 * at)
                                : static_cast<const void*>(static_cast<const double*>(this->Data) + 3 * at);
    }
    for (int d = 0; d < 3; ++d)
    {
      view.Counts[d] = last[d] - first[d] + 1;
    }
    return view;
  }

private:
  Index offset(int i, int j, int k) const { return i * this->Strides[0] + j * this->Strides[1] + k * this->Strides[2]; }
  /// Address of a fetched point, or null.
  const double* fetched(Index offset) const;
  Vec3 remote(Index offset) const;
  /// The changed point at an offset, or null. Cuts `count` to how many from there on are changed and follow it in
  /// memory, or are not changed.
  const Vec3* change(Index offset, Index& count) const;

  const void* Data = nullptr;
  bool IsFloat = false;
  std::array<int, 3> Counts{ 0, 0, 0 };
  std::array<Index, 3> Strides{ 0, 0, 0 };
  /// If Data is null: what was fetched.
  const PointBoxes* Boxes = nullptr;
  const ChangedPoints* Changes = nullptr;
  /// The view's first point in its grid.
  Index Start = 0;
};

} // namespace bsv
