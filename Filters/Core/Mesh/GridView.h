// SPDX-License-Identifier: BSD-3-Clause
/// @file GridView.h
/// View of the points of a structured grid.
#pragma once

#include "Mesh/PointStorage.h"

#include <array>

namespace bsv
{

/// View of the points of a structured grid, or of a box of one, i fastest in the grid: how they are walked. Where they
/// are knows PointStorage. It owns nothing.
class GridView
{
public:
  GridView() = default;

  /// Whole grid of nx * ny * nz points stored contiguously as x y z triples.
  template <typename Real>
  GridView(const Real* xyz, const std::array<int, 3>& pointCounts)
    : GridView(PointStorage(xyz), pointCounts)
  {
  }
  /// Whole grid.
  GridView(const PointStorage& points, const std::array<int, 3>& pointCounts)
    : Points(points)
    , Counts(pointCounts)
    , Strides{ 1, pointCounts[0], Index(pointCounts[0]) * pointCounts[1] }
  {
  }
  /// Grid whose points are on another rank.
  static GridView elsewhere(const std::array<int, 3>& pointCounts) { return { PointStorage(), pointCounts }; }

  /// Points per direction.
  const std::array<int, 3>& counts() const { return this->Counts; }
  Index size() const { return Index(this->Counts[0]) * this->Counts[1] * this->Counts[2]; }
  bool isFloat() const { return this->Points.isFloat(); }
  /// Whether all points are here, which address() needs.
  bool isHere() const { return this->Points.isHere(); }
  /// Whether none of the points is known here.
  bool isElsewhere() const { return this->Points.isElsewhere(); }
  /// Whether point (i, j, k) is known here.
  bool has(const std::array<int, 3>& ijk) const { return this->Points.has(this->place(ijk)); }

  /// The same view with these points in place of those stored, which it needs to be here.
  GridView changed(const ChangedPoints* points) const
  {
    GridView view = *this;
    view.Points.change(points);
    return view;
  }
  const ChangedPoints* changes() const { return this->Points.changes(); }

  /// Distance, in points, between neighbours of direction d in memory.
  Index stride(int d) const { return this->Strides[d]; }
  /// Place of point (i, j, k) in the grid, in points: linear in i, j and k.
  Index place(const std::array<int, 3>& ijk) const { return this->place(ijk[0], ijk[1], ijk[2]); }

  /// Address of point (i, j, k) as it was stored, and as the stored type.
  template <typename Real>
  const Real* address(int i, int j, int k) const
  {
    return this->Points.template address<Real>(this->place(i, j, k));
  }

  /// The point at a place, in double precision.
  /// @throws Error if it is on another rank and was not fetched.
  Vec3 atPlace(Index place) const { return this->Points.at(place); }
  /// Point (i, j, k), in double precision.
  Vec3 operator()(int i, int j, int k) const { return this->Points.at(this->place(i, j, k)); }
  Vec3 operator()(const std::array<int, 3>& ijk) const { return this->Points.at(this->place(ijk)); }

  /// PointStorage::forRuns() for the points (first..last, j, k).
  template <typename Copy>
  void forRuns(int first, int last, int j, int k, const Copy& copy) const
  {
    this->Points.forRuns(this->place(first, j, k), last - first + 1, copy);
  }

  /// The box of points [first, last], both included.
  GridView box(const std::array<int, 3>& first, const std::array<int, 3>& last) const
  {
    GridView view = *this;
    view.Start = this->place(first);
    for (int d = 0; d < 3; ++d)
    {
      view.Counts[d] = last[d] - first[d] + 1;
    }
    return view;
  }

private:
  Index place(int i, int j, int k) const
  {
    return this->Start + i * this->Strides[0] + j * this->Strides[1] + k * this->Strides[2];
  }

  PointStorage Points;
  std::array<int, 3> Counts{ 0, 0, 0 };
  std::array<Index, 3> Strides{ 0, 0, 0 };
  /// Place of the view's first point.
  Index Start = 0;
};

} // namespace bsv
