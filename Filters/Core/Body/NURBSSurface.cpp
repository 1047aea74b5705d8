// SPDX-License-Identifier: BSD-3-Clause
#include "Body/NURBSSurface.h"

#include "Body/TrimRegion.h"
#include "Volume/BSplineVolume.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace bsv
{

namespace
{

constexpr int MaxOrder = MaxSurfaceDegree + 1;

/// Sine of the angle between x_u and x_v below which their cross product says nothing.
constexpr double DegenerateSine = 1e-9;

struct Basis
{
  int first;
  /// [derivative][function]
  double values[3][MaxOrder];
};

/// Index s of the span [knots[s], knots[s + 1]) that holds u; at the end of the domain, the last one that is not empty.
int findSpan(int degree, const std::vector<double>& knots, double u)
{
  const auto begin = knots.begin() + degree;
  const auto end = knots.begin() + (knots.size() - degree - 1);
  const auto next = u < *end ? std::upper_bound(begin, end, u) : std::lower_bound(begin, end, *end);
  return static_cast<int>(next - knots.begin()) - 1;
}

/// Values and first two derivatives of the functions that are not zero at u: recurrence (2.5), which passes through the
/// functions of the two degrees below, and (2.7) applied to those. A basis without derivatives costs as much, so it is
/// not told apart.
void basisAt(int degree, const std::vector<double>& knots, double u, Basis& basis)
{
  const int span = findSpan(degree, knots, u);
  const double* t = knots.data() + span;
  basis.first = span - degree;
  double* n = basis.values[0];
  double* first = basis.values[1];
  double* second = basis.values[2];
  // inverse[r] = 1 / (t[r + 1] - t[r + 1 - k]), the support that function r of degree k - 1 shares with its neighbour.
  double inverse[MaxOrder];
  n[0] = 1.0;
  second[0] = 0.0;
  for (int k = 1; k <= degree; ++k)
  {
    const bool before = k == degree;
    for (int r = 0; r < k; ++r)
    {
      inverse[r] = 1.0 / (t[r + 1] - t[r + 1 - k]);
    }
    const auto differentiate = [&](const double* lower, double* upper) {
      double saved = 0.0;
      for (int r = 0; r < k; ++r)
      {
        const double slope = k * (lower[r] * inverse[r]);
        upper[r] = saved - slope;
        saved = slope;
      }
      upper[k] = saved;
    };
    if (before && k > 1)
    {
      // `second` holds the first derivatives of degree - 1.
      double slopes[MaxOrder];
      std::copy(second, second + k, slopes);
      differentiate(slopes, second);
    }
    else if (before)
    {
      std::fill(second, second + 2, 0.0);
    }
    if (before)
    {
      differentiate(n, first);
    }
    else if (k == degree - 1)
    {
      differentiate(n, second);
    }
    double saved = 0.0;
    for (int r = 0; r < k; ++r)
    {
      const double part = n[r] * inverse[r];
      n[r] = saved + (t[r + 1] - u) * part;
      saved = (u - t[r + 1 - k]) * part;
    }
    n[k] = saved;
  }
}

/// Sums of control points (times weights) and products of derivatives du and dv of the basis, du + dv <= 2.
template <typename Vector, typename At>
void tensorSums(const NURBSSurface& surface, const Basis (&basis)[2], const At& at, Vector (&sums)[3][3])
{
  for (auto& row : sums)
  {
    std::fill(row, row + 3, Vector::Zero());
  }
  const std::size_t rowLength = surface.count(0);
  for (int b = 0; b <= surface.degree[1]; ++b)
  {
    const std::size_t first = (basis[1].first + b) * rowLength + basis[0].first;
    Vector row[3] = { Vector::Zero(), Vector::Zero(), Vector::Zero() };
    for (int a = 0; a <= surface.degree[0]; ++a)
    {
      const Vector& point = at(first + a);
      for (int d = 0; d < 3; ++d)
      {
        row[d] += basis[0].values[d][a] * point;
      }
    }
    for (int du = 0; du < 3; ++du)
    {
      for (int dv = 0; du + dv < 3; ++dv)
      {
        sums[du][dv] += basis[1].values[dv][b] * row[du];
      }
    }
  }
}

SurfaceDerivatives polynomialDerivatives(const NURBSSurface& surface, const Basis (&basis)[2])
{
  Vec3 sums[3][3];
  tensorSums(
    surface, basis, [&](std::size_t i) -> const Vec3& { return surface.points[i]; }, sums);
  return { sums[0][0], sums[1][0], sums[0][1], sums[2][0], sums[1][1], sums[0][2] };
}

SurfaceDerivatives rationalDerivatives(const NURBSSurface& surface, const Basis (&basis)[2])
{
  using Vec4 = Eigen::Vector4d;
  Vec4 sums[3][3];
  tensorSums(
    surface, basis,
    [&](std::size_t i) -> Vec4 {
      const Vec3& p = surface.points[i];
      return surface.weights[i] * Vec4(p[0], p[1], p[2], 1.0);
    },
    sums);
  SurfaceDerivatives result{ sums[0][0].head<3>(), sums[1][0].head<3>(), sums[0][1].head<3>(), sums[2][0].head<3>(),
    sums[1][1].head<3>(), sums[0][2].head<3>() };
  const double scale = 1.0 / sums[0][0][3];
  const double wu = sums[1][0][3];
  const double wv = sums[0][1][3];
  result.x *= scale;
  result.u = (result.u - wu * result.x) * scale;
  result.v = (result.v - wv * result.x) * scale;
  result.uu = (result.uu - 2.0 * wu * result.u - sums[2][0][3] * result.x) * scale;
  result.uv = (result.uv - wu * result.v - wv * result.u - sums[1][1][3] * result.x) * scale;
  result.vv = (result.vv - 2.0 * wv * result.v - sums[0][2][3] * result.x) * scale;
  return result;
}

double clampTo(double value, double low, double high)
{
  return std::min(std::max(value, low), high);
}

void checkKnots(int degree, const std::vector<double>& knots, const std::string& name)
{
  if (degree < 1 || degree > MaxSurfaceDegree)
  {
    throw Error(name + ": degree " + std::to_string(degree) + " is not in 1.." + std::to_string(MaxSurfaceDegree));
  }
  if (knots.size() < 2 * static_cast<std::size_t>(degree + 1))
  {
    throw Error(name + ": " + std::to_string(knots.size()) + " knots are too few for degree " + std::to_string(degree));
  }
  for (std::size_t i = 0; i < knots.size(); ++i)
  {
    if (!std::isfinite(knots[i]))
    {
      throw Error(name + ": knot " + std::to_string(i) + " is not finite");
    }
    if (i > 0 && knots[i] < knots[i - 1])
    {
      throw Error(name + ": knot " + std::to_string(i) + " is smaller than the one before it");
    }
  }
  const std::size_t count = knots.size() - degree - 1;
  if (!(knots[degree] < knots[count]))
  {
    throw Error(name + ": the knots' range is empty");
  }
  for (std::size_t i = 0; i + degree < knots.size(); ++i)
  {
    if (knots[i] == knots[i + degree] && knots[i] > knots[degree] && knots[i] < knots[count])
    {
      throw Error(name + ": knot " + std::to_string(i) + " is repeated more than " + std::to_string(degree) + " times");
    }
  }
}

template <typename Points>
void checkPoints(
  const Points& points, const std::vector<double>& weights, std::size_t expected, const std::string& name)
{
  if (points.size() != expected)
  {
    throw Error(name + ": " + std::to_string(points.size()) + " control points instead of " + std::to_string(expected));
  }
  for (std::size_t i = 0; i < points.size(); ++i)
  {
    if (!points[i].allFinite())
    {
      throw Error(name + ": control point " + std::to_string(i) + " is not finite");
    }
  }
  if (!weights.empty() && weights.size() != expected)
  {
    throw Error(name + ": " + std::to_string(weights.size()) + " weights instead of " + std::to_string(expected));
  }
  for (std::size_t i = 0; i < weights.size(); ++i)
  {
    if (!(weights[i] > 0.0) || !std::isfinite(weights[i]))
    {
      throw Error(name + ": weight " + std::to_string(i) + " is " + std::to_string(weights[i]) + ", not positive");
    }
  }
}

/// Abscissae and weights of the Gauss-Legendre rule with 8 points on [-1, 1].
constexpr double GaussX[4] = { 0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363 };
constexpr double GaussW[4] = { 0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763 };

template <typename Function>
double gauss(double a, double b, const Function& f)
{
  const double middle = 0.5 * (a + b);
  const double half = 0.5 * (b - a);
  double sum = 0.0;
  for (int i = 0; i < 4; ++i)
  {
    sum += GaussW[i] * (f(middle - half * GaussX[i]) + f(middle + half * GaussX[i]));
  }
  return half * sum;
}

/// Halves intervals until two halves agree with the whole to `tolerance` (absolute).
template <typename Function>
double adaptiveGauss(double a, double b, double whole, double tolerance, int depth, const Function& f)
{
  const double middle = 0.5 * (a + b);
  const double low = gauss(a, middle, f);
  const double high = gauss(middle, b, f);
  if (depth == 0 || std::abs(low + high - whole) <= tolerance)
  {
    return low + high;
  }
  return adaptiveGauss(a, middle, low, 0.5 * tolerance, depth - 1, f) +
    adaptiveGauss(middle, b, high, 0.5 * tolerance, depth - 1, f);
}

/// Where a direction must be cut so that the pieces are smooth: the ends of the domain and its kinks.
std::vector<int> kinkSpans(int degree, const std::vector<double>& knots)
{
  // Entry s: the piece begins with knots[s + 1 - degree .. s], all equal.
  std::vector<int> starts;
  const int count = static_cast<int>(knots.size()) - degree - 1;
  for (int s = degree; s < count; ++s)
  {
    if (knots[s] < knots[s + 1] && (s == degree || knots[s + 1 - degree] == knots[s]))
    {
      starts.push_back(s);
    }
  }
  return starts;
}

} // namespace

void checkNURBSSurface(const NURBSSurface& surface, const std::string& name)
{
  for (int d = 0; d < 2; ++d)
  {
    checkKnots(surface.degree[d], surface.knots[d], name + ", direction " + "uv"[d]);
  }
  checkPoints(surface.points, surface.weights,
    static_cast<std::size_t>(surface.count(0)) * static_cast<std::size_t>(surface.count(1)), name);
}

void checkBodyPatch(const BodyPatch& patch, const std::string& name)
{
  checkNURBSSurface(patch.surface, name);
  for (std::size_t l = 0; l < patch.loops.size(); ++l)
  {
    if (patch.loops[l].empty())
    {
      throw Error(name + ": trimming loop " + std::to_string(l) + " is empty");
    }
    for (std::size_t c = 0; c < patch.loops[l].size(); ++c)
    {
      const ParameterCurve& curve = patch.loops[l][c];
      const std::string label = name + ", curve " + std::to_string(c) + " of trimming loop " + std::to_string(l);
      checkKnots(curve.degree, curve.knots, label);
      checkPoints(curve.points, curve.weights, curve.knots.size() - curve.degree - 1, label);
    }
  }
}

SurfaceDerivatives evaluate(const NURBSSurface& surface, double u, double v)
{
  Basis basis[2];
  basisAt(surface.degree[0], surface.knots[0], clampTo(u, surface.first(0), surface.last(0)), basis[0]);
  basisAt(surface.degree[1], surface.knots[1], clampTo(v, surface.first(1), surface.last(1)), basis[1]);

  return surface.rational() ? rationalDerivatives(surface, basis) : polynomialDerivatives(surface, basis);
}

std::array<Vec2, 3> evaluate(const ParameterCurve& curve, double t)
{
  Basis basis;
  basisAt(curve.degree, curve.knots, clampTo(t, curve.first(), curve.last()), basis);
  Eigen::Vector3d sums[3] = { Vec3::Zero(), Vec3::Zero(), Vec3::Zero() };
  for (int a = 0; a <= curve.degree; ++a)
  {
    const Vec2& p = curve.points[basis.first + a];
    const double w = curve.weights.empty() ? 1.0 : curve.weights[basis.first + a];
    for (int d = 0; d < 3; ++d)
    {
      sums[d] += basis.values[d][a] * w * Vec3(p[0], p[1], 1.0);
    }
  }
  const double w = curve.weights.empty() ? 1.0 : sums[0][2];
  const double w1 = curve.weights.empty() ? 0.0 : sums[1][2];
  const double w2 = curve.weights.empty() ? 0.0 : sums[2][2];
  std::array<Vec2, 3> result;
  result[0] = sums[0].head<2>() / w;
  result[1] = (sums[1].head<2>() - w1 * result[0]) / w;
  result[2] = (sums[2].head<2>() - 2.0 * w1 * result[1] - w2 * result[0]) / w;
  return result;
}

SurfaceGeometry surfaceGeometry(const NURBSSurface& surface, double u, double v, bool reversed)
{
  const SurfaceDerivatives at = evaluate(surface, u, v);
  SurfaceGeometry result;
  result.point = at.x;
  result.E = at.u.dot(at.u);
  result.F = at.u.dot(at.v);
  result.G = at.v.dot(at.v);

  // Vectors are compared with the size of the whole patch, so that a derivative that should vanish but is only rounded
  // to almost nothing counts as zero.
  const double rangeU = surface.last(0) - surface.first(0);
  const double rangeV = surface.last(1) - surface.first(1);
  const auto sizeSquared = [&](const SurfaceDerivatives& d) {
    return d.u.squaredNorm() * rangeU * rangeU + d.v.squaredNorm() * rangeV * rangeV;
  };
  const auto isDegenerate = [&](const SurfaceDerivatives& d) {
    return !(d.u.cross(d.v).norm() * rangeU * rangeV > DegenerateSine * sizeSquared(d));
  };
  const auto shapeOperator = [](const SurfaceDerivatives& d, const Vec3& n) -> Eigen::Matrix3d {
    // Rows of `dual` are the vectors dual to x_u and x_v in the tangent plane.
    Eigen::Matrix<double, 3, 2> tangents;
    tangents << d.u, d.v;
    const Eigen::Matrix2d first = tangents.transpose() * tangents;
    const Eigen::Matrix<double, 2, 3> dual = first.inverse() * tangents.transpose();
    Eigen::Matrix2d second;
    second << n.dot(d.uu), n.dot(d.uv), n.dot(d.uv), n.dot(d.vv);
    return dual.transpose() * second * dual;
  };

  result.degenerate = isDegenerate(at);
  if (!result.degenerate)
  {
    result.normal = at.u.cross(at.v).normalized();
    result.curvature = shapeOperator(at, result.normal);
  }
  else
  {
    // The limit from inside, extrapolated linearly from two points towards the middle of the domain. The steps are
    // small enough for the linear term and large enough for derivatives that are divided by the distance to the pole.
    const double middleU = 0.5 * (surface.first(0) + surface.last(0));
    const double middleV = 0.5 * (surface.first(1) + surface.last(1));
    const double cu = clampTo(u, surface.first(0), surface.last(0));
    const double cv = clampTo(v, surface.first(1), surface.last(1));
    Vec3 normals[2];
    Eigen::Matrix3d tensors[2];
    bool found = true;
    for (int i = 0; i < 2; ++i)
    {
      const double step = 1e-5 * (i + 1);
      const SurfaceDerivatives d = evaluate(surface, cu + step * (middleU - cu), cv + step * (middleV - cv));
      found = found && d.u.cross(d.v).norm() > 0.0;
      if (found)
      {
        normals[i] = d.u.cross(d.v).normalized();
        tensors[i] = shapeOperator(d, normals[i]);
      }
    }
    if (found)
    {
      result.normal = (2.0 * normals[0] - normals[1]).normalized();
      result.curvature = 2.0 * tensors[0] - tensors[1];
    }
  }
  result.L = result.normal.dot(at.uu);
  result.M = result.normal.dot(at.uv);
  result.N = result.normal.dot(at.vv);
  if (reversed)
  {
    result.normal = -result.normal;
    result.curvature = -result.curvature;
    result.L = -result.L;
    result.M = -result.M;
    result.N = -result.N;
  }
  return result;
}

double patchArea(const BodyPatch& patch, double tolerance)
{
  const NURBSSurface& surface = patch.surface;
  std::array<std::vector<double>, 2> breaks;
  for (int d = 0; d < 2; ++d)
  {
    for (const int s : nonEmptySpans(surface.degree[d], surface.knots[d]))
    {
      breaks[d].push_back(surface.knots[d][s]);
    }
    breaks[d].push_back(surface.last(d));
  }
  const auto density = [&](double u, double v) {
    const SurfaceDerivatives d = evaluate(surface, u, v);
    return d.u.cross(d.v).norm();
  };
  // Integral of the density from `a` to `b` at constant v, cut at knots.
  const auto along = [&](double a, double b, double v, double absolute) {
    double sum = 0.0;
    for (std::size_t i = 0; i + 1 < breaks[0].size(); ++i)
    {
      const double low = std::max(a, breaks[0][i]);
      const double high = std::min(b, breaks[0][i + 1]);
      if (low < high)
      {
        // Evaluation on a knot takes the span to its right; Gauss points lie inside.
        const auto f = [&](double u) { return density(u, v); };
        sum += adaptiveGauss(low, high, gauss(low, high, f), absolute, 12, f);
      }
    }
    return sum;
  };

  const double rangeV = breaks[1].back() - breaks[1].front();
  double rough = 0.0;
  for (std::size_t j = 0; j + 1 < breaks[1].size(); ++j)
  {
    rough += (breaks[1][j + 1] - breaks[1][j]) *
      along(breaks[0].front(), breaks[0].back(), 0.5 * (breaks[1][j] + breaks[1][j + 1]), 1e300);
  }
  const double absolute = std::max(tolerance * rough, 1e-300);
  const double inner = absolute / rangeV;

  if (patch.loops.empty())
  {
    double area = 0.0;
    for (std::size_t j = 0; j + 1 < breaks[1].size(); ++j)
    {
      const auto f = [&](double v) { return along(breaks[0].front(), breaks[0].back(), v, inner); };
      area += adaptiveGauss(breaks[1][j], breaks[1][j + 1], gauss(breaks[1][j], breaks[1][j + 1], f),
        absolute / static_cast<double>(breaks[1].size()), 12, f);
    }
    return area;
  }

  // Green's theorem: area = integral over the loops of A(u,v) dv, A being the integral of the density from the first u.
  // A loop inside an odd number of others is the border of a hole.
  double area = 0.0;
  for (std::size_t l = 0; l < patch.loops.size(); ++l)
  {
    const TrimLoop& loop = patch.loops[l];
    double sum = 0.0;
    for (std::size_t c = 0; c < loop.size(); ++c)
    {
      const ParameterCurve& curve = loop[c];
      for (const int s : nonEmptySpans(curve.degree, curve.knots))
      {
        const auto f = [&](double t) {
          const auto at = evaluate(curve, t);
          return at[1][1] == 0.0 ? 0.0 : at[1][1] * along(breaks[0].front(), at[0][0], at[0][1], inner);
        };
        const double a = curve.knots[s];
        const double b = curve.knots[s + 1];
        sum += adaptiveGauss(a, b, gauss(a, b, f), 0.01 * absolute, 10, f);
      }
      const Vec2 from = evaluate(curve, curve.last())[0];
      const Vec2 to = evaluate(loop[(c + 1) % loop.size()], loop[(c + 1) % loop.size()].first())[0];
      if (from[1] != to[1])
      {
        sum += gauss(0.0, 1.0, [&](double s) {
          const Vec2 p = (1.0 - s) * from + s * to;
          return (to[1] - from[1]) * along(breaks[0].front(), p[0], p[1], inner);
        });
      }
    }
    std::vector<TrimLoop> others = patch.loops;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(l));
    const bool hole = !others.empty() && TrimRegion(others).contains(evaluate(loop[0], loop[0].first())[0]);
    area += hole ? -std::abs(sum) : std::abs(sum);
  }
  return area;
}

std::vector<NURBSSurface> smoothPieces(const NURBSSurface& surface)
{
  std::array<std::vector<int>, 2> starts;
  for (int d = 0; d < 2; ++d)
  {
    starts[d] = kinkSpans(surface.degree[d], surface.knots[d]);
  }
  std::vector<NURBSSurface> pieces;
  for (std::size_t j = 0; j < starts[1].size(); ++j)
  {
    for (std::size_t i = 0; i < starts[0].size(); ++i)
    {
      const std::array<std::size_t, 2> part{ i, j };
      NURBSSurface piece;
      piece.degree = surface.degree;
      std::array<int, 2> begin{};
      std::array<int, 2> end{};
      for (int d = 0; d < 2; ++d)
      {
        const int p = surface.degree[d];
        const std::vector<double>& knots = surface.knots[d];
        const int start = starts[d][part[d]];
        const bool last = part[d] + 1 == starts[d].size();
        begin[d] = start - p;
        // The first basis function that a kink at the end leaves to the next piece alone.
        end[d] = last ? surface.count(d) : starts[d][part[d] + 1] - p + 1;
        piece.knots[d].assign(knots.begin() + begin[d], knots.begin() + end[d] + p + 1);
        if (part[d] > 0)
        {
          piece.knots[d].front() = knots[start];
        }
        if (!last)
        {
          piece.knots[d].back() = knots[starts[d][part[d] + 1]];
        }
      }
      for (int b = begin[1]; b < end[1]; ++b)
      {
        for (int a = begin[0]; a < end[0]; ++a)
        {
          const std::size_t at = static_cast<std::size_t>(b) * surface.count(0) + a;
          piece.points.push_back(surface.points[at]);
          if (surface.rational())
          {
            piece.weights.push_back(surface.weights[at]);
          }
        }
      }
      pieces.push_back(std::move(piece));
    }
  }
  return pieces;
}

TrimLoop domainLoop(const NURBSSurface& surface)
{
  const Vec2 corners[4] = { { surface.first(0), surface.first(1) }, { surface.last(0), surface.first(1) },
    { surface.last(0), surface.last(1) }, { surface.first(0), surface.last(1) } };
  TrimLoop loop;
  for (int c = 0; c < 4; ++c)
  {
    loop.push_back({ 1, { 0.0, 0.0, 1.0, 1.0 }, { corners[c], corners[(c + 1) % 4] }, {} });
  }
  return loop;
}

} // namespace bsv
