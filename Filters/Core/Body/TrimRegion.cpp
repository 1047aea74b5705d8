// SPDX-License-Identifier: BSD-3-Clause
#include "Body/TrimRegion.h"

#include "Volume/BSplineVolume.h"
#include "Volume/BezierSegments.h"

#include <algorithm>
#include <cmath>

namespace bsv
{

namespace
{

constexpr int MaxHalvings = 48;

Vec2 euclidean(const Vec3& h)
{
  return h.head<2>() / h[2];
}

} // namespace

TrimRegion::TrimRegion(const std::vector<TrimLoop>& loops)
{
  for (const TrimLoop& loop : loops)
  {
    const std::size_t firstPiece = this->Pieces.size();
    const auto add = [&](const Vec2& from, const Vec2& to, const Box2& box, int curve, double a, double b) {
      this->Pieces.push_back({ from, to, box, curve, a, b });
    };
    for (const ParameterCurve& curve : loop)
    {
      const int index = static_cast<int>(this->Curves.size());
      this->Curves.push_back(curve);
      // A straight join from the end of the curve before; both pieces then share the very same point.
      const Vec2 start = evaluate(curve, curve.first())[0];
      if (this->Pieces.size() > firstPiece && this->Pieces.back().to != start)
      {
        const Vec2 from = this->Pieces.back().to;
        add(from, start, Box2(from).extend(start), -1, 0.0, 0.0);
      }
      Vec2 at = start;
      const auto split = [&](const auto& self, std::vector<Vec3>& bezier, double a, double b, int depth) -> void {
        const int degree = curve.degree;
        Box2 box;
        int signs = 0;
        for (int i = 0; i <= degree; ++i)
        {
          box.extend(euclidean(bezier[i]));
          if (i > 0)
          {
            const double rise = euclidean(bezier[i])[1] - euclidean(bezier[i - 1])[1];
            signs |= rise > 0.0 ? 1 : rise < 0.0 ? 2 : 0;
          }
        }
        if (signs != 3 || depth == 0)
        {
          // Variation diminishing: a curve with a monotone control polygon is monotone.
          const Vec2 to = euclidean(bezier[degree]);
          add(at, to, box.extend(at), signs == 3 ? -1 : index, a, b);
          at = to;
          return;
        }
        std::vector<Vec3> right(bezier.size());
        halveBezier(degree, 1, bezier.data(), right.data());
        const double middle = 0.5 * (a + b);
        self(self, bezier, a, middle, depth - 1);
        self(self, right, middle, b, depth - 1);
      };
      std::vector<Vec3> bezier(curve.degree + 1);
      for (const int span : nonEmptySpans(curve.degree, curve.knots))
      {
        bezierOfSpan<Vec3>(
          curve.degree, curve.knots, span,
          [&](int i) -> Vec3 {
            const std::size_t p = span - curve.degree + i;
            const double w = curve.weights.empty() ? 1.0 : curve.weights[p];
            return w * Vec3(curve.points[p][0], curve.points[p][1], 1.0);
          },
          bezier.data());
        std::vector<Vec3> copy = bezier;
        split(split, copy, curve.knots[span], curve.knots[span + 1], MaxHalvings);
      }
    }
    if (this->Pieces.size() > firstPiece && this->Pieces.back().to != this->Pieces[firstPiece].from)
    {
      const Vec2 from = this->Pieces.back().to;
      const Vec2 to = this->Pieces[firstPiece].from;
      add(from, to, Box2(from).extend(to), -1, 0.0, 0.0);
    }
  }
}

double TrimRegion::crossing(const Piece& piece, double v) const
{
  if (piece.curve < 0)
  {
    const double s = (v - piece.from[1]) / (piece.to[1] - piece.from[1]);
    return piece.from[0] + s * (piece.to[0] - piece.from[0]);
  }
  // The only root of v(t) = v on the piece: Newton, with halving when it leaves the bracket or is slow.
  const ParameterCurve& curve = this->Curves[piece.curve];
  const bool rising = piece.from[1] < piece.to[1];
  double low = piece.first;
  double high = piece.last;
  double t = low + (high - low) * (v - piece.from[1]) / (piece.to[1] - piece.from[1]);
  double width = high - low;
  Vec2 at = piece.from;
  for (int i = 0; i < 200; ++i)
  {
    const auto d = evaluate(curve, t);
    at = d[0];
    const double excess = at[1] - v;
    if (excess == 0.0)
    {
      break;
    }
    (excess > 0.0) == rising ? high = t : low = t;
    double next = t - excess / d[1][1];
    if (!(next > low && next < high) || high - low > 0.5 * width)
    {
      next = i % 3 == 2 || !(next > low && next < high) ? 0.5 * (low + high) : next;
    }
    width = high - low;
    if (next == t || next == low || next == high)
    {
      break;
    }
    t = next;
  }
  return at[0];
}

bool TrimRegion::contains(const Vec2& point) const
{
  if (this->Pieces.empty())
  {
    return true;
  }
  bool inside = false;
  for (const Piece& piece : this->Pieces)
  {
    // Half-open: a joint of two pieces counts once if the ray passes it and not, or twice, if it touches.
    if ((piece.from[1] <= point[1]) == (piece.to[1] <= point[1]) || point[0] >= piece.box.max()[0])
    {
      continue;
    }
    if (point[0] < piece.box.min()[0] || point[0] < this->crossing(piece, point[1]))
    {
      inside = !inside;
    }
  }
  return inside;
}

TrimRegion::Place TrimRegion::classify(const Box2& box) const
{
  for (const Piece& piece : this->Pieces)
  {
    if (piece.box.intersects(box))
    {
      return Place::Crossed;
    }
  }
  return this->contains(box.center()) ? Place::Inside : Place::Outside;
}

} // namespace bsv
