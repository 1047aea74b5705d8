// SPDX-License-Identifier: BSD-3-Clause
#include "Body/SurfaceCells.h"

#include "Volume/BezierSegments.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace bsv
{
namespace
{

using Vec4 = Eigen::Vector4d;

/// Cells are halved until tangents vary by less than this fraction of their mean ...
constexpr double TangentVariation = 0.1;
/// Cells that trimming curves cross are halved until their radius is this many times the smallest one.
constexpr double CrossedCells = 100.0;
/// ... or they were halved so often.
constexpr int MaxHalvings = 40;
/// Rational tangents are not in the hull of the control net's differences: their variation is taken larger.
constexpr double RationalSafety = 1.5;

/// Cells of one piece, by halving the Bezier nets of its spans.
class CellMaker
{
public:
  CellMaker(
    const SurfacePiece& piece, int index, const TrimRegion& region, double smallest, std::vector<SurfaceCell>& cells)
    : Surface(piece.surface)
    , Region(region)
    , PieceIndex(index)
    , Smallest(smallest)
    , Cells(cells)
  {
  }

  void run()
  {
    const int p = this->Surface.degree[0];
    const int q = this->Surface.degree[1];
    const int rowLength = this->Surface.count(0);
    std::vector<Vec4> rows(static_cast<std::size_t>(p + 1) * (q + 1));
    std::vector<Vec4> line(std::max(p, q) + 1);
    for (const int sv : nonEmptySpans(q, this->Surface.knots[1]))
    {
      for (const int su : nonEmptySpans(p, this->Surface.knots[0]))
      {
        for (int b = 0; b <= q; ++b)
        {
          bezierOfSpan<Vec4>(
            p, this->Surface.knots[0], su,
            [&](int a) -> Vec4 {
              const std::size_t at = static_cast<std::size_t>(sv - q + b) * rowLength + (su - p + a);
              const Vec3& x = this->Surface.points[at];
              const double w = this->Surface.rational() ? this->Surface.weights[at] : 1.0;
              return w * Vec4(x[0], x[1], x[2], 1.0);
            },
            rows.data() + static_cast<std::size_t>(b) * (p + 1));
        }
        std::vector<Vec4> net(rows.size());
        for (int a = 0; a <= p; ++a)
        {
          bezierOfSpan<Vec4>(
            q, this->Surface.knots[1], sv, [&](int b) { return rows[static_cast<std::size_t>(b) * (p + 1) + a]; },
            line.data());
          for (int b = 0; b <= q; ++b)
          {
            net[static_cast<std::size_t>(b) * (p + 1) + a] = line[b];
          }
        }
        this->halve(net, this->Surface.knots[0][su], this->Surface.knots[0][su + 1], this->Surface.knots[1][sv],
          this->Surface.knots[1][sv + 1], MaxHalvings);
      }
    }
  }

private:
  void halve(std::vector<Vec4>& net, double u0, double u1, double v0, double v1, int left)
  {
    const TrimRegion::Place place =
      this->Region.empty() ? TrimRegion::Place::Inside : this->Region.classify(Box2(Vec2(u0, v0), Vec2(u1, v1)));
    if (place == TrimRegion::Place::Outside)
    {
      return;
    }
    const int p = this->Surface.degree[0];
    const int q = this->Surface.degree[1];
    this->Net.resize(net.size());
    SurfaceCell cell;
    for (std::size_t i = 0; i < net.size(); ++i)
    {
      this->Net[i] = net[i].head<3>() / net[i][3];
      cell.box.extend(this->Net[i]);
    }
    const auto at = [&](int a, int b) -> const Vec3& { return this->Net[static_cast<std::size_t>(b) * (p + 1) + a]; };
    cell.center = 0.25 * (at(0, 0) + at(p, 0) + at(0, q) + at(p, q));
    for (const Vec3& x : this->Net)
    {
      cell.radius = std::max(cell.radius, (x - cell.center).norm());
    }
    cell.tangentU = 0.5 * (at(p, 0) + at(p, q) - at(0, 0) - at(0, q));
    cell.tangentV = 0.5 * (at(0, q) + at(p, q) - at(0, 0) - at(p, 0));
    // Differences along both directions bound both tangents; how much they change along each says where to halve.
    double bendU = 0.0;
    double bendV = 0.0;
    double twist = 0.0;
    for (int b = 0; b <= q; ++b)
    {
      for (int a = 0; a <= p; ++a)
      {
        if (a < p)
        {
          cell.spreadU = std::max(cell.spreadU, (p * (at(a + 1, b) - at(a, b)) - cell.tangentU).norm());
        }
        if (b < q)
        {
          cell.spreadV = std::max(cell.spreadV, (q * (at(a, b + 1) - at(a, b)) - cell.tangentV).norm());
        }
        if (a < p && b < q)
        {
          twist = std::max(twist, p * q * (at(a + 1, b + 1) - at(a + 1, b) - at(a, b + 1) + at(a, b)).norm());
        }
        if (a > 0 && a < p)
        {
          bendU = std::max(bendU, p * p * (at(a + 1, b) - 2.0 * at(a, b) + at(a - 1, b)).norm());
        }
        if (b > 0 && b < q)
        {
          bendV = std::max(bendV, q * q * (at(a, b + 1) - 2.0 * at(a, b) + at(a, b - 1)).norm());
        }
      }
    }
    if (this->Surface.rational())
    {
      cell.spreadU *= RationalSafety;
      cell.spreadV *= RationalSafety;
    }
    const double lengthU = cell.tangentU.norm();
    const double lengthV = cell.tangentV.norm();
    // How much each tangent is too curved, if at all; the smallest size keeps rounding from counting.
    const double excessU = cell.spreadU / (TangentVariation * lengthU + this->Smallest);
    const double excessV = cell.spreadV / (TangentVariation * lengthV + this->Smallest);
    const bool flat = excessU <= 1.0 && excessV <= 1.0;
    const bool fine = place == TrimRegion::Place::Inside || cell.radius <= CrossedCells * this->Smallest;
    if ((flat && fine) || left == 0 || cell.radius <= this->Smallest)
    {
      cell.piece = this->PieceIndex;
      cell.u0 = u0;
      cell.u1 = u1;
      cell.v0 = v0;
      cell.v1 = v1;
      cell.crossed = place == TrimRegion::Place::Crossed;
      this->Cells.push_back(cell);
      return;
    }
    // The worse tangent changes along its own direction (bend) or along the other one (twist), as it does at poles.
    const bool alongU = flat ? lengthU >= lengthV : excessU >= excessV ? bendU >= twist : bendV < twist;
    std::vector<Vec4> other(net.size());
    if (alongU)
    {
      for (int b = 0; b <= q; ++b)
      {
        halveBezier(p, 1, net.data() + static_cast<std::size_t>(b) * (p + 1),
          other.data() + static_cast<std::size_t>(b) * (p + 1));
      }
      const double middle = 0.5 * (u0 + u1);
      this->halve(net, u0, middle, v0, v1, left - 1);
      this->halve(other, middle, u1, v0, v1, left - 1);
    }
    else
    {
      for (int a = 0; a <= p; ++a)
      {
        halveBezier(q, p + 1, net.data() + a, other.data() + a);
      }
      const double middle = 0.5 * (v0 + v1);
      this->halve(net, u0, u1, v0, middle, left - 1);
      this->halve(other, u0, u1, middle, v1, left - 1);
    }
  }

  const NURBSSurface& Surface;
  const TrimRegion& Region;
  int PieceIndex;
  double Smallest;
  std::vector<SurfaceCell>& Cells;
  std::vector<Vec3> Net;
};

} // namespace

CurvePoint evaluateEdge(const NURBSSurface& surface, const ParameterCurve& curve, double t)
{
  const auto c = evaluate(curve, t);
  const SurfaceDerivatives s = evaluate(surface, c[0][0], c[0][1]);
  CurvePoint result;
  result.uv = c[0];
  result.x = s.x;
  result.d1 = c[1][0] * s.u + c[1][1] * s.v;
  result.d2 = c[1][0] * c[1][0] * s.uu + 2.0 * c[1][0] * c[1][1] * s.uv + c[1][1] * c[1][1] * s.vv + c[2][0] * s.u +
    c[2][1] * s.v;
  return result;
}

void pieceCells(
  const SurfacePiece& piece, int index, const TrimRegion& region, double smallest, std::vector<SurfaceCell>& cells)
{
  CellMaker(piece, index, region, smallest, cells).run();
}

void edgeCells(
  const NURBSSurface& surface, const ParameterCurve& curve, int index, double smallest, std::vector<SurfaceCell>& cells)
{
  std::array<std::vector<double>, 2> knots;
  for (int d = 0; d < 2; ++d)
  {
    std::unique_copy(surface.knots[d].begin(), surface.knots[d].end(), std::back_inserter(knots[d]));
  }
  const auto halve = [&](const auto& self, double a, double b, int left) -> void {
    constexpr int Samples = 4;
    Vec3 points[Samples + 1];
    Vec3 tangents[Samples + 1];
    Box2 domain;
    SurfaceCell cell;
    double tangentLength = 0.0;
    for (int i = 0; i <= Samples; ++i)
    {
      // The ends a little outside: both cells at a kink of the surface see both tangents.
      const double part = i == 0 ? -EndShift : i == Samples ? 1.0 + EndShift : double(i) / Samples;
      const CurvePoint at = evaluateEdge(surface, curve, a + part * (b - a));
      points[i] = at.x;
      tangents[i] = at.d1 * (b - a);
      tangentLength = std::max(tangentLength, tangents[i].norm());
      cell.box.extend(at.x);
      domain.extend(at.uv);
    }
    // Samples say little about a curve that passes many spans of the surface.
    bool fewSpans = true;
    for (int d = 0; d < 2; ++d)
    {
      fewSpans = fewSpans &&
        std::lower_bound(knots[d].begin(), knots[d].end(), domain.max()[d]) -
            std::upper_bound(knots[d].begin(), knots[d].end(), domain.min()[d]) <=
          1;
    }
    cell.center = 0.5 * (points[0] + points[Samples]);
    cell.tangentU = points[Samples] - points[0];
    double sag = 0.0;
    for (int i = 0; i <= Samples; ++i)
    {
      const double s = double(i) / Samples;
      sag = std::max(sag, (points[i] - (1.0 - s) * points[0] - s * points[Samples]).norm());
      cell.spreadU = std::max(cell.spreadU, (tangents[i] - cell.tangentU).norm());
      cell.radius = std::max(cell.radius, (points[i] - cell.center).norm());
    }
    const bool flat = fewSpans && cell.spreadU <= TangentVariation * cell.tangentU.norm() + smallest;
    if (flat || left == 0 || (cell.radius <= smallest && tangentLength <= 4.0 * smallest))
    {
      cell.radius += 2.0 * sag;
      cell.spreadU *= RationalSafety;
      cell.box.min().array() -= 2.0 * sag;
      cell.box.max().array() += 2.0 * sag;
      cell.edge = index;
      cell.u0 = a;
      cell.u1 = b;
      cells.push_back(cell);
      return;
    }
    const double middle = 0.5 * (a + b);
    self(self, a, middle, left - 1);
    self(self, middle, b, left - 1);
  };
  // Ends of spans are cells of their own: there the curve may end or have a kink.
  const auto addPoint = [&](double t) {
    SurfaceCell cell;
    cell.center = evaluateEdge(surface, curve, t).x;
    cell.box.extend(cell.center);
    cell.edge = index;
    cell.u0 = cell.u1 = t;
    cells.push_back(cell);
  };
  addPoint(curve.first());
  for (const int span : nonEmptySpans(curve.degree, curve.knots))
  {
    halve(halve, curve.knots[span], curve.knots[span + 1], MaxHalvings);
    addPoint(curve.knots[span + 1]);
  }
}

std::vector<ParameterCurve> kinkLines(const NURBSSurface& surface)
{
  std::vector<ParameterCurve> lines;
  for (int d = 0; d < 2; ++d)
  {
    const std::vector<double>& knots = surface.knots[d];
    const int p = surface.degree[d];
    for (int s = p + 1; s < surface.count(d); ++s)
    {
      if (knots[s] < knots[s + 1] && knots[s + 1 - p] == knots[s] && knots[s] > surface.first(d))
      {
        Vec2 from;
        Vec2 to;
        from[d] = to[d] = knots[s];
        from[1 - d] = surface.first(1 - d);
        to[1 - d] = surface.last(1 - d);
        // Knots of the other direction are those of the line: it is smooth between them only.
        ParameterCurve line;
        line.knots = { 0.0 };
        for (const int span : nonEmptySpans(surface.degree[1 - d], surface.knots[1 - d]))
        {
          const double s0 = (surface.knots[1 - d][span] - from[1 - d]) / (to[1 - d] - from[1 - d]);
          line.knots.push_back(s0);
          line.points.push_back((1.0 - s0) * from + s0 * to);
        }
        line.knots.push_back(1.0);
        line.knots.push_back(1.0);
        line.points.push_back(to);
        lines.push_back(line);
      }
    }
  }
  return lines;
}

} // namespace bsv
