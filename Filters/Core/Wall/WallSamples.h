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

/// 3 x 3 samples in every span of the wall's faces, but for those nearer than two spans to an extraordinary vertex,
/// then 3 in every span of its creases and borders. The points of these are weighted means of the latter alone. Faces
/// are looked at in an order and from corners that their points decide, so that results are the same bits for any
/// numbering and orientation of the blocks.
class WallSamples
{
public:
  WallSamples(const BlockComplex& complex, const LimitRows& rows, const Wall& wall, const std::vector<Vec3>& given);

  static constexpr int PerSpan = 3;

  Index size() const { return this->Count; }
  /// The first of the samples on creases and borders: those of one span follow each other along the curve.
  Index firstOnCurves() const { return this->FirstOnCurves; }
  /// The samples of the wall with the mesh points `x`.
  std::vector<Vec3> evaluate(const std::vector<Vec3>& x, const Execution& run) const;
  /// Means of values at the samples, weighted by the B-spline of each wall point; points without samples: zero.
  std::vector<Vec3> average(const std::vector<Vec3>& values, Index points, const Execution& run) const;
  /// Whether a wall point has samples enough of its own: of others the limit point is fitted.
  bool isFree(Index id) const { return this->Free[id]; }

private:
  struct Face
  {
    int ns = 0, nt = 0;
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

  const LimitRows& Rows;
  std::vector<Face> Faces;
  std::vector<bool> Free;
  Index Count = 0, FirstOnCurves = 0;
  /// Per wall point, whether its mean is that of samples on curves.
  std::vector<bool> OnCurve;
};

} // namespace bsv
