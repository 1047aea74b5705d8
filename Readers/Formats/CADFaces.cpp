// SPDX-License-Identifier: BSD-3-Clause
// Faces of OpenCASCADE as trimmed B-spline surfaces.
#include "Formats/CADShape.h"

#include "Body/ClosestPoint.h"
#include "Body/TrimRegion.h"

#include <BRepTools.hxx>
#include <BRepTools_WireExplorer.hxx>
#include <BRep_Tool.hxx>
#include <Geom2dConvert.hxx>
#include <Geom2d_BSplineCurve.hxx>
#include <Geom2d_TrimmedCurve.hxx>
#include <GeomConvert.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_BezierSurface.hxx>
#include <Geom_Plane.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <Poly_Triangulation.hxx>
#include <TColStd_HArray1OfReal.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

namespace bsv::cad
{

namespace
{

/// Fraction of a parameter range within which a trimming curve counts as a side of the domain.
constexpr double SideFraction = 1e-9;
/// Fraction of a face's size that a converted surface may differ from the original and still count as exact.
constexpr double ExactFraction = 1e-9;
/// Fraction of the parameter range to which trimming curves follow a change of parameters.
constexpr double CurveFraction = 1e-12;

NURBSSurface fromOpenCASCADE(const Handle(Geom_BSplineSurface) & source)
{
  NURBSSurface surface;
  surface.degree = { source->UDegree(), source->VDegree() };
  for (int d = 0; d < 2; ++d)
  {
    const TColStd_Array1OfReal& knots = d == 0 ? source->UKnotSequence() : source->VKnotSequence();
    surface.knots[d].assign(knots.begin(), knots.end());
  }
  const bool rational = source->IsURational() || source->IsVRational();
  for (int j = 1; j <= source->NbVPoles(); ++j)
  {
    for (int i = 1; i <= source->NbUPoles(); ++i)
    {
      const gp_Pnt& p = source->Pole(i, j);
      surface.points.emplace_back(p.X(), p.Y(), p.Z());
      if (rational)
      {
        surface.weights.push_back(source->Weight(i, j));
      }
    }
  }
  return surface;
}

ParameterCurve fromOpenCASCADE(const Handle(Geom2d_BSplineCurve) & source)
{
  ParameterCurve curve;
  curve.degree = source->Degree();
  const TColStd_Array1OfReal& knots = source->KnotSequence();
  curve.knots.assign(knots.begin(), knots.end());
  for (int i = 1; i <= source->NbPoles(); ++i)
  {
    curve.points.emplace_back(source->Pole(i).X(), source->Pole(i).Y());
    if (source->IsRational())
    {
      curve.weights.push_back(source->Weight(i));
    }
  }
  return curve;
}

/// From the parameters of an original surface to those of its NURBS form, where they differ: arcs are rational in
/// the one and run by angle in the other. Both parameters change by themselves.
class Reparametrisation
{
public:
  /// No change.
  Reparametrisation() = default;
  Reparametrisation(const Handle(Geom_Surface) & original, const NURBSSurface& converted)
    : Original(original)
    , Converted(std::make_shared<const NURBSSurface>(converted))
  {
    // Each parameter is matched along a line on which the surface moves most with it.
    const BodySurface whole({ BodyPatch{ "", converted, {}, false } });
    for (int d = 0; d < 2; ++d)
    {
      const int o = 1 - d;
      double longest = -1.0;
      for (const double s : { 0.0, 0.5, 1.0 })
      {
        const double other = (1.0 - s) * converted.first(o) + s * converted.last(o);
        double speed = 0.0;
        for (const double t : { 0.25, 0.5, 0.75 })
        {
          const double own = (1.0 - t) * converted.first(d) + t * converted.last(d);
          gp_Pnt p;
          gp_Vec du, dv;
          d == 0 ? original->D1(own, other, p, du, dv) : original->D1(other, own, p, du, dv);
          speed += d == 0 ? du.Magnitude() : dv.Magnitude();
        }
        if (speed > 1.01 * longest)
        {
          longest = speed;
          this->From[o] = this->To[o] = other;
          if (s == 0.5)
          {
            const double own = 0.5 * (converted.first(d) + converted.last(d));
            const Vec3 point = d == 0 ? this->point(own, other) : this->point(other, own);
            const BodyPoint found = whole.closestPoint(point);
            this->To[o] = o == 0 ? found.u : found.v;
          }
        }
      }
    }
  }

  bool identity() const { return !this->Converted; }

  Vec2 operator()(const Vec2& uv) const
  {
    return this->identity() ? uv : Vec2(this->map(0, uv[0]).first, this->map(1, uv[1]).first);
  }

  /// Image of a point and of a direction there.
  std::pair<Vec2, Vec2> operator()(const Vec2& uv, const Vec2& direction) const
  {
    const auto u = this->map(0, uv[0]);
    const auto v = this->map(1, uv[1]);
    return { Vec2(u.first, v.first), Vec2(u.second * direction[0], v.second * direction[1]) };
  }

  /// Largest distance of the two surfaces at matching parameters.
  double deviation() const
  {
    double largest = 0.0;
    for (int j = 0; j <= 8; ++j)
    {
      for (int i = 0; i <= 8; ++i)
      {
        const Vec2 uv(this->at(0, i / 8.0), this->at(1, j / 8.0));
        const Vec2 image = (*this)(uv);
        largest =
          std::max(largest, (evaluate(*this->Converted, image[0], image[1]).x - this->point(uv[0], uv[1])).norm());
      }
    }
    return largest;
  }

private:
  double at(int d, double s) const { return (1.0 - s) * this->Converted->first(d) + s * this->Converted->last(d); }
  Vec3 point(double u, double v) const
  {
    const gp_Pnt p = this->Original->Value(u, v);
    return { p.X(), p.Y(), p.Z() };
  }

  /// Parameter d of the converted surface for parameter t of the original, and its derivative.
  std::pair<double, double> map(int d, double t) const
  {
    const double first = this->Converted->first(d);
    const double last = this->Converted->last(d);
    t = std::min(std::max(t, first), last);
    gp_Pnt p;
    gp_Vec du, dv;
    d == 0 ? this->Original->D1(t, this->From[1], p, du, dv) : this->Original->D1(this->From[0], t, p, du, dv);
    const Vec3 target(p.X(), p.Y(), p.Z());
    const double speed = d == 0 ? du.Magnitude() : dv.Magnitude();
    double s = t;
    double own = 0.0;
    for (int i = 0; i < 30; ++i)
    {
      const SurfaceDerivatives x =
        d == 0 ? evaluate(*this->Converted, s, this->To[1]) : evaluate(*this->Converted, this->To[0], s);
      const Vec3& tangent = d == 0 ? x.u : x.v;
      own = tangent.norm();
      const double next = std::min(std::max(s + (target - x.x).dot(tangent) / (own * own), first), last);
      if (!(own > 0.0) || std::abs(next - s) <= 1e-16 * (last - first))
      {
        break;
      }
      s = next;
    }
    if (t == first || t == last)
    {
      s = t;
    }
    return { s, own > 0.0 ? speed / own : 1.0 };
  }

  Handle(Geom_Surface) Original;
  std::shared_ptr<const NURBSSurface> Converted;
  /// Parameters at which the other one is matched, of the original and of the converted surface.
  std::array<double, 2> From{};
  std::array<double, 2> To{};
};

/// A curve in the parameters of the converted surface: a straight one along a parameter stays straight; others become
/// cubic Hermite segments, halved until their middles agree.
ParameterCurve mapped(const ParameterCurve& curve, const Reparametrisation& change, const Vec2& range)
{
  if (change.identity())
  {
    return curve;
  }
  const Vec2 start = evaluate(curve, curve.first())[0];
  const Vec2 end = evaluate(curve, curve.last())[0];
  for (int d = 0; d < 2; ++d)
  {
    const bool straight = std::all_of(curve.points.begin(), curve.points.end(),
      [&](const Vec2& p) { return std::abs(p[d] - curve.points[0][d]) <= SideFraction * range[d]; });
    if (straight)
    {
      return { 1, { 0.0, 0.0, 1.0, 1.0 }, { change(start), change(end) }, {} };
    }
  }
  ParameterCurve result;
  result.degree = 3;
  const auto image = [&](double t) {
    const auto at = evaluate(curve, t);
    return change(at[0], at[1]);
  };
  result.points.push_back(image(curve.first()).first);
  result.knots = { curve.first(), curve.first(), curve.first(), curve.first() };
  using Image = std::pair<Vec2, Vec2>;
  const auto halve = [&](const auto& self, double a, const Image& at, double b, const Image& to, int left) -> void {
    const double h = b - a;
    const Vec2 inner[2] = { at.first + h / 3.0 * at.second, to.first - h / 3.0 * to.second };
    const double middle = 0.5 * (a + b);
    const Image exact = image(middle);
    const Vec2 guess = 0.125 * (at.first + to.first) + 0.375 * (inner[0] + inner[1]);
    if (left == 0 || (left < 14 && ((guess - exact.first).cwiseQuotient(range)).norm() <= CurveFraction))
    {
      result.points.insert(result.points.end(), { inner[0], inner[1], to.first });
      result.knots.insert(result.knots.end(), { b, b, b });
      return;
    }
    self(self, a, at, middle, exact, left - 1);
    self(self, middle, exact, b, to, left - 1);
  };
  for (std::size_t i = curve.degree; i < curve.points.size(); ++i)
  {
    const double a = curve.knots[i];
    const double b = curve.knots[i + 1];
    if (a < b)
    {
      // Derivatives at knots are those to the right: a little inside the end.
      Image to = image(b);
      to.second = image(b - 1e-9 * (b - a)).second;
      halve(halve, a, image(a), b, to, 16);
    }
  }
  result.knots.push_back(result.knots.back());
  return result;
}

/// Whether the loops are no more than the sides of the domain.
bool isWholeDomain(const std::vector<TrimLoop>& loops, const NURBSSurface& surface)
{
  if (loops.size() != 1)
  {
    return false;
  }
  double area = 0.0;
  const Vec2 first(surface.first(0), surface.first(1));
  const Vec2 last(surface.last(0), surface.last(1));
  for (const ParameterCurve& curve : loops[0])
  {
    bool onSide = false;
    for (int d = 0; d < 2; ++d)
    {
      for (const double side : { first[d], last[d] })
      {
        onSide = onSide || std::all_of(curve.points.begin(), curve.points.end(), [&](const Vec2& p) {
          return std::abs(p[d] - side) <= SideFraction * (last[d] - first[d]);
        });
      }
    }
    if (!onSide)
    {
      return false;
    }
    const Vec2 a = (evaluate(curve, curve.first())[0] - first).cwiseQuotient(last - first);
    const Vec2 b = (evaluate(curve, curve.last())[0] - first).cwiseQuotient(last - first);
    area += 0.5 * (a[0] * b[1] - a[1] * b[0]);
  }
  return std::abs(std::abs(area) - 1.0) <= 1e-6;
}

double signedArea(const TrimLoop& loop)
{
  double area = 0.0;
  Vec2 first = Vec2::Zero();
  Vec2 last = Vec2::Zero();
  bool started = false;
  const auto step = [&](const Vec2& p) {
    if (started)
    {
      area += 0.5 * (last[0] * p[1] - last[1] * p[0]);
    }
    else
    {
      first = p;
      started = true;
    }
    last = p;
  };
  for (const ParameterCurve& curve : loop)
  {
    for (std::size_t i = curve.degree; i < curve.points.size(); ++i)
    {
      for (int k = 0; k <= 16; ++k)
      {
        step(evaluate(curve, curve.knots[i] + (curve.knots[i + 1] - curve.knots[i]) * k / 16.0)[0]);
      }
    }
  }
  step(first);
  return area;
}

/// The part of a B-spline surface that has ends.
Handle(Geom_BSplineSurface) unrolled(Handle(Geom_BSplineSurface) spline, const Vec2& lower, const Vec2& upper)
{
  if (!spline->IsUPeriodic() && !spline->IsVPeriodic())
  {
    return spline;
  }
  spline = Handle(Geom_BSplineSurface)::DownCast(spline->Copy());
  double a, b, c, d;
  spline->Bounds(a, b, c, d);
  const double tinyU = SideFraction * (b - a);
  const double tinyV = SideFraction * (d - c);
  const bool inside = lower[0] >= a - tinyU && upper[0] <= b + tinyU && lower[1] >= c - tinyV && upper[1] <= d + tinyV;
  if (!inside)
  {
    // The face lies across the seam: cut out what it needs.
    spline->Segment(lower[0], std::min(upper[0], lower[0] + (b - a)), lower[1], std::min(upper[1], lower[1] + (d - c)));
  }
  return spline;
}

/// The B-spline form of the part of a surface that a face with these bounds needs; null if there is none.
Handle(Geom_BSplineSurface) converted(const Handle(Geom_Surface) & original, Vec2 lower, Vec2 upper)
{
  double a, b, c, d;
  original->Bounds(a, b, c, d);
  // A curved trimming edge touches its box: a plane reaches a little beyond, other surfaces end where they end.
  const auto limit = [&](double& low, double& high, bool periodic, double period, double least, double most) {
    if (periodic)
    {
      if (high - low >= period * (1.0 - SideFraction))
      {
        high = low + period;
      }
    }
    else
    {
      low = std::max(low, least);
      high = std::min(high, most);
    }
    // Curves are rational on whole parts of the circle: snap what is but rounding away from it.
    for (double* end : { &low, &high })
    {
      for (const double target : { least, most })
      {
        if (std::abs(*end - target) <= SideFraction * std::max(1.0, high - low))
        {
          *end = target;
        }
      }
    }
  };
  limit(lower[0], upper[0], original->IsUPeriodic(), original->IsUPeriodic() ? original->UPeriod() : 0.0, a, b);
  limit(lower[1], upper[1], original->IsVPeriodic(), original->IsVPeriodic() ? original->VPeriod() : 0.0, c, d);
  const Vec2 size = upper - lower;
  if (!(lower[0] < upper[0]) || !(lower[1] < upper[1]) || !size.allFinite() || size[0] > 1e50 || size[1] > 1e50)
  {
    throw Error("has an empty or infinite parameter domain");
  }
  return GeomConvert::SurfaceToBSplineSurface(
    new Geom_RectangularTrimmedSurface(original, lower[0], upper[0], lower[1], upper[1], Standard_True, Standard_True));
}

/// The loop of a wire, in the parameters of the converted surface.
TrimLoop loopOf(const TopoDS_Shape& wire, const TopoDS_Face& face, const Reparametrisation& change, const Vec2& range)
{
  TrimLoop loop;
  const auto addEdge = [&](const TopoDS_Edge& edge) {
    double first, last;
    const Handle(Geom2d_Curve) curve = BRep_Tool::CurveOnSurface(edge, face, first, last);
    if (curve.IsNull() || !(first < last))
    {
      return;
    }
    Handle(Geom2d_BSplineCurve) bspline = Handle(Geom2d_BSplineCurve)::DownCast(curve);
    if (!bspline.IsNull() && !bspline->IsPeriodic() && bspline->FirstParameter() == first &&
      bspline->LastParameter() == last)
    {
      bspline = Handle(Geom2d_BSplineCurve)::DownCast(bspline->Copy());
    }
    else
    {
      bspline = Geom2dConvert::CurveToBSplineCurve(new Geom2d_TrimmedCurve(curve, first, last));
      if (bspline->IsPeriodic())
      {
        bspline->SetNotPeriodic();
      }
    }
    if (edge.Orientation() == TopAbs_REVERSED)
    {
      bspline->Reverse();
    }
    loop.push_back(mapped(fromOpenCASCADE(bspline), change, range));
  };
  int walked = 0;
  for (BRepTools_WireExplorer edges(TopoDS::Wire(wire), face); edges.More(); edges.Next(), ++walked)
  {
    addEdge(edges.Current());
  }
  int all = 0;
  for (TopExp_Explorer edges(wire, TopAbs_EDGE); edges.More(); edges.Next())
  {
    ++all;
  }
  if (walked < all)
  {
    // The explorer stops where edges do not connect; then in the order in which they are stored.
    loop.clear();
    for (TopExp_Explorer edges(wire, TopAbs_EDGE); edges.More(); edges.Next())
    {
      addEdge(TopoDS::Edge(edges.Current()));
    }
  }
  return loop;
}

/// None if the face is the whole surface.
std::vector<TrimLoop> loopsOf(const TopoDS_Face& face, const NURBSSurface& surface, const Reparametrisation& change)
{
  const Vec2 range(surface.last(0) - surface.first(0), surface.last(1) - surface.first(1));
  std::vector<TrimLoop> loops;
  double largest = 0.0;
  for (TopExp_Explorer wires(face, TopAbs_WIRE); wires.More(); wires.Next())
  {
    TrimLoop loop = loopOf(wires.Current(), face, change, range);
    if (!loop.empty())
    {
      const double area = signedArea(loop);
      largest = std::abs(area) > std::abs(largest) ? area : largest;
      loops.push_back(std::move(loop));
    }
  }
  if (largest < 0.0)
  {
    // Holes only: their face is the whole surface around them.
    loops.insert(loops.begin(), domainLoop(surface));
  }
  if (isWholeDomain(loops, surface))
  {
    loops.clear();
  }
  return loops;
}

void addTriangles(const TopoDS_Face& face, const Reparametrisation& change, int patch, BodyTessellation& tessellation)
{
  TopLoc_Location location;
  const Handle(Poly_Triangulation) mesh = BRep_Tool::Triangulation(face, location);
  if (mesh.IsNull() || !mesh->HasUVNodes())
  {
    return;
  }
  const int first = static_cast<int>(tessellation.vertices.size());
  for (int i = 1; i <= mesh->NbNodes(); ++i)
  {
    const gp_Pnt2d p = mesh->UVNode(i);
    const Vec2 uv = change(Vec2(p.X(), p.Y()));
    tessellation.vertices.push_back({ patch, uv[0], uv[1] });
  }
  for (int i = 1; i <= mesh->NbTriangles(); ++i)
  {
    int a, b, c;
    mesh->Triangle(i).Get(a, b, c);
    if (face.Orientation() == TopAbs_REVERSED)
    {
      std::swap(b, c);
    }
    tessellation.triangles.push_back({ first + a - 1, first + b - 1, first + c - 1 });
  }
}

} // namespace

BodyPatch convertFace(const TopoDS_Face& oriented, int patch, BodyTessellation& tessellation, bool& approximated)
{
  BodyPatch result;
  result.reversed = oriented.Orientation() == TopAbs_REVERSED;
  const TopoDS_Face face = TopoDS::Face(oriented.Oriented(TopAbs_FORWARD));
  Handle(Geom_Surface) original = BRep_Tool::Surface(face);
  if (original.IsNull())
  {
    throw Error("has no surface");
  }
  while (original->IsKind(STANDARD_TYPE(Geom_RectangularTrimmedSurface)))
  {
    original = Handle(Geom_RectangularTrimmedSurface)::DownCast(original)->BasisSurface();
  }
  Vec2 lower, upper;
  BRepTools::UVBounds(face, lower[0], upper[0], lower[1], upper[1]);
  Handle(Geom_BSplineSurface) spline = Handle(Geom_BSplineSurface)::DownCast(original);
  bool sameParameters = true;
  if (!spline.IsNull())
  {
    spline = unrolled(spline, lower, upper);
  }
  else if (original->IsKind(STANDARD_TYPE(Geom_BezierSurface)))
  {
    spline = GeomConvert::SurfaceToBSplineSurface(original);
  }
  else
  {
    sameParameters = original->IsKind(STANDARD_TYPE(Geom_Plane));
    spline = converted(original, lower, upper);
  }
  if (spline.IsNull())
  {
    throw Error("cannot be converted to a B-spline surface");
  }
  if (spline->IsUPeriodic())
  {
    spline->SetUNotPeriodic();
  }
  if (spline->IsVPeriodic())
  {
    spline->SetVNotPeriodic();
  }
  result.surface = fromOpenCASCADE(spline);
  checkNURBSSurface(result.surface, "surface");
  Reparametrisation change;
  approximated = false;
  if (!sameParameters)
  {
    change = Reparametrisation(original, result.surface);
    Eigen::AlignedBox3d box;
    for (const Vec3& p : result.surface.points)
    {
      box.extend(p);
    }
    approximated = change.deviation() > ExactFraction * box.diagonal().norm();
  }
  result.loops = loopsOf(face, result.surface, change);
  checkBodyPatch(result, "");
  addTriangles(oriented, change, patch, tessellation);
  return result;
}

} // namespace bsv::cad
