// SPDX-License-Identifier: BSD-3-Clause
/// @file JoinMeasurement.h
/// The jumps along one join: samples, and their maxima followed between them.
#pragma once

#include "Quality/JoinEvaluation.h"
#include "Quality/Smoothness.h"
#include "Quality/TraceFrame.h"

#include <array>
#include <vector>

namespace bsv
{

/// The boundary face of a wall border, else -1.
int withinFace(const Join& join, int side);

/// The face across which derivatives are taken: on a wall border the other one at the edge.
int acrossFace(const Join& join, int side);

/// Measures one join: prepare(), then evaluateRow() for every row in any order, then finish().
class JoinMeasurement
{
public:
  /// @param fetchedB trace of side B if it came from another rank, else null; prepare() takes it.
  JoinMeasurement(
    const std::vector<BSplineVolume>& volumes, const SmoothnessOptions& options, Trace* fetchedB, Join& join)
    : Volumes(volumes)
    , Options(options)
    , FetchedB(fetchedB)
    , Parts(options.samplesPerSpan)
    , Result(join)
  {
  }

  /// The traces; false if they are not finite.
  bool prepare();

  Index rows() const { return static_cast<Index>(this->Stations[1].size()); }

  void evaluateRow(Index row);

  void finish();

private:
  /// One-sided sample position along an axis, for both sides of the join.
  using Station = std::array<TraceBasis, 2>;

  const BSplineVolume& volume(int k) const { return this->Volumes[this->Result.sides[k].block]; }

  /// The smallest of the 16 ways to look at the join. Ways that compare equal give the same bits.
  void chooseFrame(const std::array<Trace, 2>& traces);

  const TraceFrame& frameOfA() const { return this->Frames[this->Exchange ? 1 : 0]; }

  void findCells(int k);

  Station station(int k, int cell, double x, double rest) const;

  /// Sample positions along an axis, each with one version, or two where one-sided values differ.
  void placeStations(int k);

  /// The missing axis of a wall border.
  bool trivial(int k) const { return this->Traces[0].degree[k] == 0; }

  /// Place in an array of the result, which has the axes of side A, of item (i, j) of the frame.
  std::size_t inA(const std::array<int, 2>& counts, int i, int j) const;

  int kindInA(int kind) const;

  Jumps evaluate(const Station& s, const Station& t, Vec3* point = nullptr) const;

  /// Best sample of a cell.
  struct Best
  {
    double value;
    double hope; ///< what parabolas through the samples promise, generously
    std::array<int, 2> cell;
    double x, y;
  };

  Best bestSample(const std::vector<double>& values, const std::array<int, 2>& cell) const;

  /// Layer is one of the normal jumps, or the larger one.
  void takeLayerMaximum();

  void findMaximum(int kind);

  /// What is rounding only has many maxima, and none of them matters.
  bool worthClimbing(int kind, double value) const;

  /// Parameters in the block of the frame's side `side`.
  Vec3 parameters(int side, const Best& best) const;

  const std::vector<BSplineVolume>& Volumes;
  const SmoothnessOptions& Options;
  Trace* FetchedB;
  int Parts;
  Join& Result;
  /// In the frame; B first if Exchange.
  std::array<Trace, 2> Traces;
  std::array<TraceFrame, 2> Frames;
  bool Exchange = false;
  double Length = 0.0;
  /// Per axis of the frame.
  std::array<bool, 2> BoundToKink{ false, false };
  std::array<std::vector<JoinSpan>, 2> Cells;
  std::array<std::vector<std::vector<Station>>, 2> Stations;
};

} // namespace bsv
