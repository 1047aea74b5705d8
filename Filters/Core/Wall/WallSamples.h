// SPDX-License-Identifier: BSD-3-Clause
/// @file WallSamples.h
/// The converted wall between its mesh points, as a linear function of them: for the least-squares fit to the body.
#pragma once

#include "Body/ClosestPoint.h"
#include "Wall/LimitRows.h"
#include "Wall/WallPoints.h"

#include <array>
#include <vector>

namespace bsv
{

/// 4 x 4 samples in every span of the wall's faces, but for those nearer than two spans to an extraordinary vertex,
/// then 4 in every span of its creases and borders. The points of these are weighted means of the latter alone. Faces
/// are looked at in an order and from corners that their points decide, so that results are the same bits for any
/// numbering and orientation of the blocks.
class WallSamples
{
public:
  WallSamples(const BlockComplex& complex, const LimitRows& rows, const Wall& wall, const std::vector<Vec3>& given);

  /// The curvature of real bodies can change several times in a span: 3 miss what is between them.
  static constexpr int PerSpan = 4;

  Index size() const { return this->Count; }
  /// The first of the samples on creases and borders: those of one span follow each other along the curve.
  Index firstOnCurves() const { return this->FirstOnCurves; }
  /// The samples of the wall with the mesh points `x`.
  std::vector<Vec3> evaluate(const std::vector<Vec3>& x, const Execution& run) const;
  /// The transposed map: per wall point the sum of the values at the samples, each times how far the sample moves with
  /// the point.
  std::vector<Vec3> transposed(const std::vector<Vec3>& values, const Execution& run) const;
  /// Whether a wall point has samples enough of its own: of others the limit point is fitted.
  bool isFree(Index id) const { return this->Free[id]; }
  /// All wall points in the order of the faces: for sums over them.
  const std::vector<Index>& ordered() const { return this->Ordered; }

private:
  /// Of a span, per sample: the four B-splines that are not zero there.
  using SpanBasis = std::array<std::array<double, 4>, PerSpan>;
  struct Face
  {
    int ns = 0, nt = 0;
    /// Along both directions, per span.
    std::array<std::vector<SpanBasis>, 2> basis;
    /// Numbers of its mesh points, s fastest.
    std::vector<Index> ids;
    /// First sample of each span, or -1.
    std::vector<Index> first;
    /// First sample of its sides t = 0, t = nt, s = 0, s = ns, or -1 for those inside the wall.
    std::array<Index, 4> curves{ -1, -1, -1, -1 };

    int sideCells(int side) const { return side < 2 ? this->ns : this->nt; }
    Index sideId(int side, int k) const
    {
      return side < 2 ? this->id(k, side == 0 ? 0 : this->nt) : this->id(side == 2 ? 0 : this->ns, k);
    }
    Index id(int s, int t) const { return this->ids[s + std::size_t(this->ns + 1) * t]; }
  };

  std::vector<Vec3> controlNet(const Face& face, const std::vector<Vec3>& x) const;
  /// Calls add(point, value) with what controlNet() makes of each point, transposed.
  template <typename Add>
  void controlNetTransposed(const Face& face, const std::vector<Vec3>& net, const Add& add) const;
  /// The samples of a face from its control net, direction by direction.
  static void sample(const Face& face, const std::vector<Vec3>& net, std::vector<Vec3>& samples);
  /// sample(), transposed: the net.
  static std::vector<Vec3> sampleTransposed(const Face& face, const std::vector<Vec3>& values);
  /// Calls visit(sample, place in the net, weight) for the samples on curves of a face.
  template <typename Visit>
  static void forCurveSamples(const Face& face, const Visit& visit);

  const LimitRows& Rows;
  std::vector<Face> Faces;
  std::vector<bool> Free;
  std::vector<Index> Ordered;
  Index Count = 0, FirstOnCurves = 0;
};

} // namespace bsv
