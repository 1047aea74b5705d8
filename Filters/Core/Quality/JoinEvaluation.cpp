// SPDX-License-Identifier: BSD-3-Clause
#include "Quality/JoinEvaluation.h"

#include "Volume/BSplineVolume.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace bsv
{

TraceBasis basisAt(const Trace& trace, int k, const JoinSpan::Part& part, double x, double rest)
{
  // Only differences of knots are used: they are what blocks share.
  const int degree = trace.degree[k];
  const std::vector<double>& knots = trace.knots[k];
  double left[MaxDegree + 1];
  double right[MaxDegree + 1];
  for (int j = 1; j <= degree; ++j)
  {
    left[j] = part.before + x * part.width + (knots[part.span] - knots[part.span + 1 - j]);
    right[j] = part.after + rest * part.width + (knots[part.span + j] - knots[part.span + 1]);
  }
  TraceBasis basis;
  basis.first = part.span - degree;
  basis.length = part.before + part.width + part.after;
  basisFunctions(degree, 0, left, right, basis.values.data());
  basisFunctions(degree, 1, left, right, basis.slopes.data());
  return basis;
}

SideValues evaluateSide(const Trace& trace, const TraceBasis& s, const TraceBasis& t)
{
  Layers sum = Layers::Zero();
  Homogeneous ds = Homogeneous::Zero();
  Homogeneous dt = Homogeneous::Zero();
  for (int b = 0; b <= trace.degree[1]; ++b)
  {
    Layers row = Layers::Zero();
    Homogeneous slope = Homogeneous::Zero();
    const Layers* point = &trace.at(s.first, t.first + b);
    for (int a = 0; a <= trace.degree[0]; ++a, ++point)
    {
      row += s.values[a] * *point;
      slope += s.slopes[a] * point->head<4>();
    }
    sum += t.values[b] * row;
    ds += t.values[b] * slope;
    dt += t.slopes[b] * row.head<4>();
  }
  SideValues side;
  const auto vector = [](const auto& h) { return Vec3(h[0], h[1], h[2]); };
  side.x = vector(sum.segment<4>(0));
  side.s = vector(ds);
  side.t = vector(dt);
  side.n = vector(sum.segment<4>(4));
  side.n2 = vector(sum.segment<4>(8));
  if (trace.rational)
  {
    // Quotient rule, (4.8) of Piegl and Tiller.
    const double w = sum[3];
    side.x /= w;
    side.s = (side.s - ds[3] * side.x) / w;
    side.t = (side.t - dt[3] * side.x) / w;
    side.n = (side.n - sum[7] * side.x) / w;
    side.n2 = (side.n2 - 2.0 * sum[7] * side.n - sum[11] * side.x) / w;
  }
  const double zero = JumpRounding * trace.size;
  const auto cut = [zero](Vec3& v, double length) {
    if (v.norm() * length <= zero)
    {
      v.setZero();
    }
  };
  cut(side.s, s.length);
  cut(side.t, t.length);
  cut(side.n, trace.length);
  return side;
}

namespace
{

/// DegreesPerRadian; 0 if one of them is zero.
double angle(const Vec3& a, const Vec3& b)
{
  return angleBetween(a, b) * DegreesPerRadian;
}

/// Zero where the two are parallel up to rounding.
Vec3 normalOf(const Vec3& s, const Vec3& n)
{
  constexpr double Parallel = 1e-10;
  const Vec3 normal = s.cross(n);
  return normal.norm() > Parallel * s.norm() * n.norm() ? normal : Vec3::Zero();
}

} // namespace

Jumps jumpsOf(const SideValues& a, const SideValues& b, double length, const std::array<bool, 2>& boundToKink)
{
  const double scale = std::max(a.n.norm(), b.n.norm());
  const Vec3 inB = -b.n;
  Jumps jumps{};
  jumps[int(JumpKind::Gap)] = (a.x - b.x).norm();
  const double s = angle(normalOf(a.s, a.n), normalOf(b.s, inB));
  const double t = angle(normalOf(a.t, a.n), normalOf(b.t, inB));
  jumps[int(JumpKind::NormalS)] = s;
  jumps[int(JumpKind::NormalT)] = t;
  jumps[int(JumpKind::Layer)] = boundToKink[0] == boundToKink[1] ? (boundToKink[0] ? std::min(s, t) : std::max(s, t))
    : boundToKink[0]                                             ? t
                                                                 : s;
  jumps[int(JumpKind::Kink)] = angle(a.n, inB);
  if (scale > 0.0)
  {
    jumps[int(JumpKind::C1)] = (a.n - inB).norm() / scale;
    jumps[int(JumpKind::C2)] = length * (a.n2 - b.n2).norm() / scale;
  }
  return jumps;
}

FaceSamples sampleFace(const BSplineVolume& volume, int face, int parts)
{
  const Trace trace = makeTrace(volume, face, -1);
  std::array<std::vector<TraceBasis>, 2> stations;
  for (int k = 0; k < 2; ++k)
  {
    const std::vector<int> spans = nonEmptySpans(trace.degree[k], trace.knots[k]);
    for (const int span : spans)
    {
      JoinSpan::Part part;
      part.span = span;
      part.width = trace.knots[k][span + 1] - trace.knots[k][span];
      for (int j = 0; j < parts + (span == spans.back() ? 1 : 0); ++j)
      {
        stations[k].push_back(basisAt(trace, k, part, double(j) / parts, double(parts - j) / parts));
      }
    }
  }
  FaceSamples result;
  result.samples = { static_cast<int>(stations[0].size()), static_cast<int>(stations[1].size()) };
  result.points.reserve(stations[0].size() * stations[1].size());
  for (const TraceBasis& t : stations[1])
  {
    for (const TraceBasis& s : stations[0])
    {
      result.points.push_back(evaluateSide(trace, s, t).x);
    }
  }
  return result;
}

} // namespace bsv
