// SPDX-License-Identifier: BSD-3-Clause
// The only file of the readers that includes OpenCASCADE.
#include "Formats/NURBSFile.h"

#ifndef BSPLINEVOLUME_WITH_OPENCASCADE

namespace bsv
{

bool canReadCADFiles()
{
  return false;
}

NURBSFileContent readCADFile(const std::string& fileName, const std::string& format, double, const Execution&)
{
  throw Error(fileName + ": " + format + " files need OpenCASCADE, without which this program was built");
}

} // namespace bsv

#else

#include "Body/ClosestPoint.h"
#include "Body/TrimRegion.h"
#include "Execution/OpenCASCADESession.h"
#include "Formats/CADText.h"
#include "Formats/TextScanner.h"

#include <BRepBndLib.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRepTools.hxx>
#include <BRepTools_WireExplorer.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <Geom2dConvert.hxx>
#include <Geom2d_BSplineCurve.hxx>
#include <Geom2d_TrimmedCurve.hxx>
#include <GeomConvert.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_BezierSurface.hxx>
#include <Geom_OffsetSurface.hxx>
#include <Geom_Plane.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <IGESControl_Reader.hxx>
#include <IGESData_GlobalSection.hxx>
#include <IGESData_IGESEntity.hxx>
#include <IGESData_IGESModel.hxx>
#include <IGESGeom_BSplineSurface.hxx>
#include <Interface_Check.hxx>
#include <Interface_EntityIterator.hxx>
#include <Interface_Graph.hxx>
#include <Interface_InterfaceModel.hxx>
#include <Interface_ReportEntity.hxx>
#include <Interface_Static.hxx>
#include <Poly_Triangulation.hxx>
#include <STEPControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <StepRepr_RepresentationItem.hxx>
#include <StepVisual_Invisibility.hxx>
#include <StepVisual_InvisibleItem.hxx>
#include <StepVisual_PresentationLayerAssignment.hxx>
#include <StepVisual_StyledItem.hxx>
#include <TColStd_HArray1OfReal.hxx>
#include <TColStd_HArray2OfReal.hxx>
#include <TColStd_SequenceOfAsciiString.hxx>
#include <TColgp_HArray2OfXYZ.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <unordered_set>

#include <unistd.h>

namespace bsv
{

namespace
{

/// A file for OpenCASCADE, which reads no text from memory; gone with this object.
class TemporaryText
{
public:
  TemporaryText() = default;
  TemporaryText(const TemporaryText&) = delete;
  TemporaryText& operator=(const TemporaryText&) = delete;
  ~TemporaryText()
  {
    if (!this->Name.empty())
    {
      ::unlink(this->Name.c_str());
    }
  }

  /// @param original for the error
  void write(const std::string& text, const std::string& original)
  {
    std::error_code failure;
    std::string name = (std::filesystem::temp_directory_path(failure) / "bsplinevolume-XXXXXX").string();
    const int file = failure ? -1 : ::mkstemp(name.data());
    if (file >= 0)
    {
      this->Name = name;
      ::close(file);
      std::ofstream stream(name, std::ios::binary);
      stream << text;
      stream.close();
      if (stream)
      {
        return;
      }
    }
    throw Error(original + ": a plain copy of it cannot be written to the folder of temporary files");
  }
  const std::string& name() const { return this->Name; }

private:
  std::string Name;
};

/// Fraction of a parameter range within which a trimming curve counts as a side of the domain.
constexpr double SideFraction = 1e-9;
/// Fraction of a face's size that a converted surface may differ from the original and still count as exact.
constexpr double ExactFraction = 1e-9;
/// Fraction of the parameter range to which trimming curves follow a change of parameters.
constexpr double CurveFraction = 1e-12;
/// Largest angle, in radians, between neighbouring chords of the tessellation.
constexpr double TessellationAngle = 0.35;
/// Mode in which OpenCASCADE looks for the entity of a shape: whichever way it came from it.
constexpr int AnyResult = -1;

/// Metres per unit of a name that OpenCASCADE or the STEP file gives; 0 if unknown.
double metres(std::string name)
{
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  static const std::map<std::string, double> units = { { "metre", 1.0 }, { "meter", 1.0 }, { "m", 1.0 },
    { "millimetre", 1e-3 }, { "millimeter", 1e-3 }, { "mm", 1e-3 }, { "centimetre", 1e-2 }, { "centimeter", 1e-2 },
    { "cm", 1e-2 }, { "kilometre", 1e3 }, { "kilometer", 1e3 }, { "km", 1e3 }, { "micrometre", 1e-6 },
    { "micrometer", 1e-6 }, { "micron", 1e-6 }, { "um", 1e-6 }, { "inch", 0.0254 }, { "in", 0.0254 },
    { "foot", 0.3048 }, { "feet", 0.3048 }, { "ft", 0.3048 }, { "mile", 1609.344 }, { "mi", 1609.344 },
    { "mil", 2.54e-5 }, { "microinch", 2.54e-8 }, { "uin", 2.54e-8 } };
  const auto found = units.find(name);
  return found == units.end() ? 0.0 : found->second;
}

/// Metres per unit of an IGES file; 0 if it names none that is known.
double igesUnit(const IGESData_GlobalSection& global)
{
  static const double byFlag[] = { 0.0, 0.0254, 1e-3, 0.0, 0.3048, 1609.344, 1.0, 1e3, 2.54e-5, 1e-6, 1e-2, 2.54e-8 };
  const int flag = global.UnitFlag();
  if (flag >= 1 && flag <= 11 && byFlag[flag] > 0.0)
  {
    return byFlag[flag];
  }
  return global.UnitName().IsNull() ? 0.0 : metres(global.UnitName()->ToCString());
}

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

struct Face
{
  BodyPatch patch;
  bool approximated = false;
};

/// The NURBS form of a face. @param[out] change from the parameters of the face's own surface.
Face convertFace(const TopoDS_Face& oriented, Reparametrisation& change)
{
  Face result;
  result.patch.reversed = oriented.Orientation() == TopAbs_REVERSED;
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
  double u0, u1, v0, v1;
  BRepTools::UVBounds(face, u0, u1, v0, v1);
  Handle(Geom_BSplineSurface) spline = Handle(Geom_BSplineSurface)::DownCast(original);
  bool sameParameters = true;
  if (!spline.IsNull())
  {
    if (spline->IsUPeriodic() || spline->IsVPeriodic())
    {
      spline = Handle(Geom_BSplineSurface)::DownCast(spline->Copy());
      double a, b, c, d;
      spline->Bounds(a, b, c, d);
      const double tinyU = SideFraction * (b - a);
      const double tinyV = SideFraction * (d - c);
      const bool inside = u0 >= a - tinyU && u1 <= b + tinyU && v0 >= c - tinyV && v1 <= d + tinyV;
      if (inside)
      {
        if (spline->IsUPeriodic())
        {
          spline->SetUNotPeriodic();
        }
        if (spline->IsVPeriodic())
        {
          spline->SetVNotPeriodic();
        }
      }
      else
      {
        // The face lies across the seam: cut out what it needs.
        spline->Segment(u0, std::min(u1, u0 + (b - a)), v0, std::min(v1, v0 + (d - c)));
        if (spline->IsUPeriodic())
        {
          spline->SetUNotPeriodic();
        }
        if (spline->IsVPeriodic())
        {
          spline->SetVNotPeriodic();
        }
      }
    }
  }
  else if (original->IsKind(STANDARD_TYPE(Geom_BezierSurface)))
  {
    spline = GeomConvert::SurfaceToBSplineSurface(original);
  }
  else
  {
    sameParameters = original->IsKind(STANDARD_TYPE(Geom_Plane));
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
    limit(u0, u1, original->IsUPeriodic(), original->IsUPeriodic() ? original->UPeriod() : 0.0, a, b);
    limit(v0, v1, original->IsVPeriodic(), original->IsVPeriodic() ? original->VPeriod() : 0.0, c, d);
    if (!(u0 < u1) || !(v0 < v1) || !std::isfinite(u1 - u0) || !std::isfinite(v1 - v0) || u1 - u0 > 1e50 ||
      v1 - v0 > 1e50)
    {
      throw Error("has an empty or infinite parameter domain");
    }
    const Handle(Geom_RectangularTrimmedSurface) part =
      new Geom_RectangularTrimmedSurface(original, u0, u1, v0, v1, Standard_True, Standard_True);
    spline = GeomConvert::SurfaceToBSplineSurface(part);
    if (!spline.IsNull() && spline->IsUPeriodic())
    {
      spline->SetUNotPeriodic();
    }
    if (!spline.IsNull() && spline->IsVPeriodic())
    {
      spline->SetVNotPeriodic();
    }
  }
  if (spline.IsNull())
  {
    throw Error("cannot be converted to a B-spline surface");
  }
  result.patch.surface = fromOpenCASCADE(spline);
  checkNURBSSurface(result.patch.surface, "surface");
  const NURBSSurface& surface = result.patch.surface;
  if (!sameParameters)
  {
    change = Reparametrisation(original, surface);
    Eigen::AlignedBox3d box;
    for (const Vec3& p : surface.points)
    {
      box.extend(p);
    }
    result.approximated = change.deviation() > ExactFraction * box.diagonal().norm();
  }

  const Vec2 range(surface.last(0) - surface.first(0), surface.last(1) - surface.first(1));
  double largest = 0.0;
  for (TopExp_Explorer wires(face, TopAbs_WIRE); wires.More(); wires.Next())
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
    for (BRepTools_WireExplorer edges(TopoDS::Wire(wires.Current()), face); edges.More(); edges.Next(), ++walked)
    {
      addEdge(edges.Current());
    }
    int all = 0;
    for (TopExp_Explorer edges(wires.Current(), TopAbs_EDGE); edges.More(); edges.Next())
    {
      ++all;
    }
    if (walked < all)
    {
      // The explorer stops where edges do not connect; then in the order in which they are stored.
      loop.clear();
      for (TopExp_Explorer edges(wires.Current(), TopAbs_EDGE); edges.More(); edges.Next())
      {
        addEdge(TopoDS::Edge(edges.Current()));
      }
    }
    if (!loop.empty())
    {
      const double area = signedArea(loop);
      largest = std::abs(area) > std::abs(largest) ? area : largest;
      result.patch.loops.push_back(std::move(loop));
    }
  }
  if (largest < 0.0)
  {
    // Holes only: their face is the whole surface around them.
    result.patch.loops.insert(result.patch.loops.begin(), domainLoop(surface));
  }
  if (isWholeDomain(result.patch.loops, surface))
  {
    result.patch.loops.clear();
  }
  return result;
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

std::string textOf(const Handle(TCollection_HAsciiString) & text)
{
  if (text.IsNull())
  {
    return {};
  }
  std::string result = text->ToCString();
  while (!result.empty() && result.back() == ' ')
  {
    result.pop_back();
  }
  return result.substr(std::min(result.find_first_not_of(' '), result.size()));
}

/// What a file says of its faces.
struct FaceNames
{
  std::function<std::string(const TopoDS_Face&)> name = [](const TopoDS_Face&) { return std::string(); };
  std::function<std::string(const TopoDS_Face&)> layer = [](const TopoDS_Face&) { return std::string(); };
  /// Whether the file hides the face.
  std::function<bool(const TopoDS_Face&)> hidden = [](const TopoDS_Face&) { return false; };
};

/// The text of a message, whose placeholders OpenCASCADE may have left empty.
std::string cleaned(std::string text)
{
  for (const char* placeholder : { "%d", "%s", "%f" })
  {
    for (std::size_t at = text.find(placeholder); at != std::string::npos; at = text.find(placeholder))
    {
      text.erase(at, text[at + 2] == ' ' ? 3 : 2);
    }
  }
  return text;
}

std::string labelOf(const Handle(Interface_InterfaceModel) & model, int number)
{
  const Handle(TCollection_HAsciiString) label = model->StringLabel(model->Value(number));
  return label.IsNull() ? std::to_string(number) : textOf(label);
}

/// "type 128 (IGESGeom_BSplineSurface)", "CURVE_STYLE".
std::string typeOf(const Handle(Interface_InterfaceModel) & model, int number)
{
  const Handle(Standard_Transient) entity = model->Value(number);
  const Handle(IGESData_IGESEntity) iges = Handle(IGESData_IGESEntity)::DownCast(entity);
  return iges.IsNull() ? entity->DynamicType()->Name()
                       : "type " + std::to_string(iges->TypeNumber()) + " (" + iges->DynamicType()->Name() + ")";
}

/// Types of IGES that a face can depend on: curves, surfaces, solids and their places, not notes, views and colours.
bool isIGESShape(int type)
{
  return (type >= 100 && type <= 199) || type == 430 || (type >= 500 && type <= 599);
}

/// Those that become faces, and those that hold others.
bool isIGESSurface(int type)
{
  return type == 114 || type == 118 || type == 120 || type == 122 || type == 128 || (type >= 140 && type <= 144) ||
    (type >= 184 && type <= 198) || type == 308 || type == 402 || type == 408 || type == 430 ||
    (type >= 502 && type <= 514);
}

/// Numbers of the entities that the shape and place of faces depend on.
std::unordered_set<int> neededEntities(const Handle(IGESData_IGESModel) & model)
{
  std::unordered_set<int> needed;
  const Interface_Graph graph(model, Standard_False);
  std::vector<int> open;
  for (int i = 1; i <= model->NbEntities(); ++i)
  {
    const Handle(IGESData_IGESEntity) entity = Handle(IGESData_IGESEntity)::DownCast(model->Value(i));
    if (!entity.IsNull() && isIGESSurface(entity->TypeNumber()) && needed.insert(i).second)
    {
      open.push_back(i);
    }
  }
  while (!open.empty())
  {
    const Handle(Standard_Transient) entity = model->Value(open.back());
    open.pop_back();
    const int type = Handle(IGESData_IGESEntity)::DownCast(entity)->TypeNumber();
    if (type == 308 || type == 402 || type == 408)
    {
      continue; // the items of a list count for themselves
    }
    for (Interface_EntityIterator shared = graph.Shareds(entity); shared.More(); shared.Next())
    {
      const Handle(IGESData_IGESEntity) used = Handle(IGESData_IGESEntity)::DownCast(shared.Value());
      const int number = used.IsNull() ? 0 : model->Number(used);
      if (number > 0 && isIGESShape(used->TypeNumber()) && needed.insert(number).second)
      {
        open.push_back(number);
      }
    }
  }
  return needed;
}

/// A B-spline surface without its four last numbers, the ends of its domain: the knots say the same.
bool completeDomain(const Handle(IGESGeom_BSplineSurface) & surface)
{
  if (surface.IsNull() || surface->NbPolesU() < 2 || surface->NbPolesV() < 2)
  {
    return false;
  }
  const int upper[2] = { surface->UpperIndexU(), surface->UpperIndexV() };
  const int degree[2] = { surface->DegreeU(), surface->DegreeV() };
  std::array<Handle(TColStd_HArray1OfReal), 2> knots;
  for (int d = 0; d < 2; ++d)
  {
    const int last = upper[d] + 1;
    if ((d == 0 ? surface->NbKnotsU() : surface->NbKnotsV()) != last + degree[d] + 1)
    {
      return false;
    }
    knots[d] = new TColStd_HArray1OfReal(-degree[d], last);
    for (int k = -degree[d]; k <= last; ++k)
    {
      knots[d]->SetValue(k, d == 0 ? surface->KnotU(k) : surface->KnotV(k));
    }
  }
  const Handle(TColStd_HArray2OfReal) weights = new TColStd_HArray2OfReal(0, upper[0], 0, upper[1]);
  const Handle(TColgp_HArray2OfXYZ) poles = new TColgp_HArray2OfXYZ(0, upper[0], 0, upper[1]);
  for (int j = 0; j <= upper[1]; ++j)
  {
    for (int i = 0; i <= upper[0]; ++i)
    {
      weights->SetValue(i, j, surface->Weight(i, j));
      poles->SetValue(i, j, surface->Pole(i, j).XYZ());
    }
  }
  surface->Init(upper[0], upper[1], degree[0], degree[1], surface->IsClosedU(), surface->IsClosedV(),
    surface->IsPolynomial(), surface->IsPeriodicU(), surface->IsPeriodicV(), knots[0], knots[1], weights, poles,
    knots[0]->Value(0), knots[0]->Value(upper[0] + 1 - degree[0]), knots[1]->Value(0),
    knots[1]->Value(upper[1] + 1 - degree[1]));
  return true;
}

/// @throws Error naming the surface whose knots decrease: OpenCASCADE leaves it out without a word.
void checkKnots(const Handle(IGESData_IGESModel) & model, const std::string& fileName)
{
  for (int e = 1; e <= model->NbEntities(); ++e)
  {
    const Handle(IGESGeom_BSplineSurface) surface = Handle(IGESGeom_BSplineSurface)::DownCast(model->Value(e));
    for (int d = 0; d < 2 && !surface.IsNull(); ++d)
    {
      const int first = -(d == 0 ? surface->DegreeU() : surface->DegreeV());
      const int count = d == 0 ? surface->NbKnotsU() : surface->NbKnotsV();
      const auto knot = [&](int k) { return d == 0 ? surface->KnotU(first + k) : surface->KnotV(first + k); };
      for (int k = 1; k < count; ++k)
      {
        if (!(knot(k) >= knot(k - 1)))
        {
          throw Error(fileName + ": surface " + labelOf(model, e) + ": the knots of " + "uv"[d] + " decrease from " +
            std::to_string(knot(k - 1)) + " to " + std::to_string(knot(k)) + " (knot " + std::to_string(k + 1) + ")");
        }
      }
    }
  }
}

/// Refuses files of which an entity could not be read as what it claims to be, if faces depend on it: what refers to it
/// would meet nothing, at which OpenCASCADE does not look. Other entities are counted.
/// @param needed(number, label) whether faces depend on an entity
template <typename Needed>
void checkEntities(const Handle(Interface_InterfaceModel) & model, const std::string& fileName, const Needed& needed,
  std::map<std::string, int>& broken)
{
  for (int i = 1; i <= model->NbEntities(); ++i)
  {
    if (!model->IsReportEntity(i))
    {
      continue;
    }
    const Handle(Interface_Check) check = model->ReportEntity(i)->Check();
    if (check.IsNull() || !check->HasFailed())
    {
      continue;
    }
    const std::string label = labelOf(model, i);
    if (!needed(i, label))
    {
      ++broken[typeOf(model, i) + " that could not be read"];
      continue;
    }
    bool onlyDomain = true;
    for (int f = 1; f <= check->NbFails(); ++f)
    {
      const std::string text = check->CFail(f);
      onlyDomain = onlyDomain &&
        (text.find("Starting Value") != std::string::npos || text.find("Ending Value") != std::string::npos);
    }
    if (onlyDomain && completeDomain(Handle(IGESGeom_BSplineSurface)::DownCast(model->Value(i))))
    {
      model->ClearReportEntity(i);
      continue;
    }
    throw Error(fileName + ": entity " + label + " (" + typeOf(model, i) + "): " + cleaned(check->CFail(1)));
  }
}

/// What is counted as left out because the file hides it.
constexpr const char* HiddenSurface = "hidden (blanked) surface";

int faceCount(const TopoDS_Shape& shape)
{
  TopTools_IndexedMapOfShape faces;
  if (!shape.IsNull())
  {
    TopExp::MapShapes(shape, TopAbs_FACE, faces);
  }
  return faces.Extent();
}

/// Wherever they are placed.
using HiddenFaces = std::unordered_set<const TopoDS_TShape*>;

/// Adds the faces of an item that a STEP file hides.
void addInvisible(STEPControl_Reader& reader, const StepVisual_InvisibleItem& item, HiddenFaces& hidden)
{
  const auto add = [&](const Handle(Standard_Transient) & entity) {
    const TopoDS_Shape shape = entity.IsNull() ? TopoDS_Shape() : reader.WS()->TransferReader()->ShapeResult(entity);
    for (TopExp_Explorer at(shape, TopAbs_FACE); !shape.IsNull() && at.More(); at.Next())
    {
      hidden.insert(at.Current().TShape().get());
    }
  };
  const Handle(StepVisual_StyledItem) styled = item.StyledItem();
  if (!styled.IsNull())
  {
    add(styled->Item());
  }
  const Handle(StepVisual_PresentationLayerAssignment) layer = item.PresentationLayerAssignment();
  for (int k = 1; !layer.IsNull() && k <= layer->NbAssignedItems(); ++k)
  {
    add(layer->AssignedItemsValue(k).Value());
  }
}

/// Shapes of all roots but the hidden ones, and the roots of which nothing came.
/// @param dropped counts of what is left out
TopoDS_Shape transfer(XSControl_Reader& reader, const std::string& fileName, std::map<std::string, int>& dropped)
{
  BRep_Builder builder;
  TopoDS_Compound all;
  builder.MakeCompound(all);
  const int roots = reader.NbRootsForTransfer();
  for (int i = 1; i <= roots; ++i)
  {
    const int before = reader.NbShapes();
    reader.TransferOneRoot(i);
    const Handle(Standard_Transient) root = reader.RootForTransfer(i);
    const Handle(IGESData_IGESEntity) iges = Handle(IGESData_IGESEntity)::DownCast(root);
    const bool hidden = !iges.IsNull() && iges->BlankStatus() == 1;
    for (int n = before + 1; n <= reader.NbShapes(); ++n)
    {
      if (!hidden && !reader.Shape(n).IsNull())
      {
        builder.Add(all, reader.Shape(n));
      }
      const int faces = hidden ? faceCount(reader.Shape(n)) : 0;
      if (faces > 0)
      {
        dropped[HiddenSurface] += faces;
      }
    }
    if (reader.NbShapes() == before && !hidden)
    {
      const int type = iges.IsNull() ? 0 : iges->TypeNumber();
      // A plane without bounds (190) is part of a face, and no face itself.
      if (isIGESSurface(type) && isIGESShape(type) && type != 190)
      {
        const Handle(Interface_InterfaceModel) model = reader.WS()->Model();
        throw Error(fileName + ": surface " + labelOf(model, model->Number(root)) + " (" +
          typeOf(model, model->Number(root)) + ") cannot be converted to a face");
      }
      ++dropped[iges.IsNull()
          ? std::string("STEP entity ") + root->DynamicType()->Name()
          : "IGES entity of type " + std::to_string(iges->TypeNumber()) + " (" + root->DynamicType()->Name() + ")"];
    }
  }
  return all;
}

} // namespace

bool canReadCADFiles()
{
  return true;
}

NURBSFileContent readCADFile(
  const std::string& fileName, const std::string& format, double tolerance, const Execution& run)
{
  NURBSFileContent content;
  content.format = format;
  STEPEntities entities;
  TemporaryText copy;
  {
    const std::string original = readTextFile(fileName);
    const std::string text = plainCADText(original, format);
    if (text != original)
    {
      copy.write(text, fileName);
    }
    if (format == "STEP")
    {
      entities = checkSTEPText(text, fileName);
    }
    else
    {
      format == "IGES" ? checkIGESText(text, fileName) : checkBREPText(text, fileName);
    }
  }
  const std::string opened = copy.name().empty() ? fileName : copy.name();
  std::map<std::string, int> dropped;
  OpenCASCADESession session;
  try
  {
    TopoDS_Shape shape;
    FaceNames names;
    IGESControl_Reader iges;
    STEPControl_Reader step;
    std::map<Standard_Transient*, std::string> stepLayers;
    HiddenFaces hiddenFaces;
    if (format == "IGES")
    {
      // Surfaces stay whole although their knots may be multiple, and numbers stay those of the file.
      session.set("read.iges.bspline.continuity", 0);
      if (iges.ReadFile(opened.c_str()) != IFSelect_RetDone || iges.IGESModel().IsNull())
      {
        throw Error(fileName + ": OpenCASCADE cannot read it as an IGES file");
      }
      const std::unordered_set<int> needed = neededEntities(iges.IGESModel());
      checkEntities(
        iges.IGESModel(), fileName, [&](int number, const std::string&) { return needed.count(number) > 0; }, dropped);
      checkKnots(iges.IGESModel(), fileName);
      content.unit = igesUnit(iges.IGESModel()->GlobalSection());
      if (content.unit > 0.0)
      {
        iges.IGESModel()->ChangeGlobalSection().SetCascadeUnit(content.unit * 1000.0); // in millimetres
      }
      shape = transfer(iges, fileName, dropped);
      const auto entity = [&iges](const TopoDS_Face& face) {
        return Handle(IGESData_IGESEntity)::DownCast(
          iges.WS()->TransferReader()->EntityFromShapeResult(face, AnyResult));
      };
      names.name = [entity](const TopoDS_Face& face) {
        const Handle(IGESData_IGESEntity) found = entity(face);
        return found.IsNull() || !found->HasName() ? std::string() : textOf(found->NameValue());
      };
      names.layer = [entity](const TopoDS_Face& face) {
        const Handle(IGESData_IGESEntity) found = entity(face);
        return found.IsNull() || found->Level() <= 0 ? std::string() : std::to_string(found->Level());
      };
      names.hidden = [entity](const TopoDS_Face& face) {
        // The untrimmed surface of a trimmed one is often hidden: the trimmed one counts.
        const Handle(IGESData_IGESEntity) found = entity(face);
        return !found.IsNull() && found->BlankStatus() == 1 &&
          (found->SubordinateStatus() == 0 || found->SubordinateStatus() == 2);
      };
    }
    else if (format == "STEP")
    {
      for (const auto& [keyword, count] : entities.broken)
      {
        dropped[keyword + " that refers to a missing entity"] += count;
      }
      if (step.ReadFile(opened.c_str()) != IFSelect_RetDone)
      {
        throw Error(fileName + ": OpenCASCADE cannot read it as a STEP file");
      }
      checkEntities(
        step.Model(), fileName,
        [&](int, const std::string& label) {
          // Labels are "#12".
          return label.size() < 2 || entities.needed.count(std::strtol(label.c_str() + 1, nullptr, 10)) > 0;
        },
        dropped);
      TColStd_SequenceOfAsciiString lengths, angles, solidAngles;
      step.FileUnits(lengths, angles, solidAngles);
      content.unit = lengths.IsEmpty() ? 0.0 : metres(lengths.First().ToCString());
      step.SetSystemLengthUnit(content.unit > 0.0 ? content.unit * 1000.0 : 1.0);
      shape = transfer(step, fileName, dropped);
      const Handle(Interface_InterfaceModel) model = step.Model();
      for (int i = 1; i <= model->NbEntities(); ++i)
      {
        const auto assignment = Handle(StepVisual_PresentationLayerAssignment)::DownCast(model->Value(i));
        for (int k = 1; !assignment.IsNull() && k <= assignment->NbAssignedItems(); ++k)
        {
          stepLayers[assignment->AssignedItemsValue(k).Value().get()] = textOf(assignment->Name());
        }
        const auto invisible = Handle(StepVisual_Invisibility)::DownCast(model->Value(i));
        for (int k = 1; !invisible.IsNull() && k <= invisible->NbInvisibleItems(); ++k)
        {
          addInvisible(step, invisible->InvisibleItemsValue(k), hiddenFaces);
        }
      }
      names.hidden = [&hiddenFaces](const TopoDS_Face& face) { return hiddenFaces.count(face.TShape().get()) > 0; };
      const auto entity = [&step](const TopoDS_Face& face) {
        return step.WS()->TransferReader()->EntityFromShapeResult(face, AnyResult);
      };
      names.name = [entity](const TopoDS_Face& face) {
        const auto item = Handle(StepRepr_RepresentationItem)::DownCast(entity(face));
        const std::string name = item.IsNull() ? std::string() : textOf(item->Name());
        return name == "NONE" ? std::string() : name;
      };
      names.layer = [entity, &stepLayers](const TopoDS_Face& face) {
        const auto found = stepLayers.find(entity(face).get());
        return found == stepLayers.end() ? std::string() : found->second;
      };
    }
    else
    {
      BRep_Builder builder;
      if (!BRepTools::Read(shape, opened.c_str(), builder) || shape.IsNull())
      {
        throw Error(fileName + ": OpenCASCADE cannot read it as a BREP file");
      }
    }
    run.report(0.3);

    TopTools_IndexedMapOfShape faces;
    TopExp::MapShapes(shape, TopAbs_FACE, faces);
    TopTools_IndexedMapOfShape freeShapes;
    const std::pair<TopAbs_ShapeEnum, const char*> loose[] = { { TopAbs_EDGE, "curve without a face" },
      { TopAbs_VERTEX, "point without a face" } };
    for (const auto& kind : loose)
    {
      freeShapes.Clear();
      for (TopExp_Explorer at(shape, kind.first, kind.first == TopAbs_EDGE ? TopAbs_FACE : TopAbs_EDGE); at.More();
           at.Next())
      {
        freeShapes.Add(at.Current());
      }
      if (!freeShapes.IsEmpty())
      {
        content.others.emplace_back(kind.second, freeShapes.Extent());
      }
    }
    const auto tellDropped = [&] { content.others.insert(content.others.begin(), dropped.begin(), dropped.end()); };
    if (faces.IsEmpty())
    {
      tellDropped();
      return content;
    }

    Bnd_Box box;
    BRepBndLib::Add(shape, box, Standard_False);
    const double size = box.IsVoid() ? 0.0 : std::sqrt(box.SquareExtent());
    if (size > 0.0 && !box.IsOpen())
    {
      BRepTools::Clean(shape);
      BRepMesh_IncrementalMesh(shape, tolerance * size, Standard_False, TessellationAngle, Standard_False);
    }
    run.report(0.6);

    for (int f = 1; f <= faces.Extent(); ++f)
    {
      const TopoDS_Face face = TopoDS::Face(faces(f));
      if (names.hidden(face))
      {
        ++dropped[HiddenSurface];
        continue;
      }
      std::string name = names.name(face);
      const std::string label = "face " + std::to_string(f) + (name.empty() ? "" : " '" + name + "'");
      Reparametrisation change;
      Face converted;
      try
      {
        converted = convertFace(face, change);
        checkBodyPatch(converted.patch, "");
      }
      catch (const Error& error)
      {
        throw Error(fileName + ": " + label + " " + error.what());
      }
      catch (const Standard_Failure& failure)
      {
        throw Error(fileName + ": " + label + " cannot be converted: " + failure.GetMessageString());
      }
      content.approximated += converted.approximated;
      addTriangles(face, change, static_cast<int>(content.patches.size()), content.tessellation);
      converted.patch.name = name.empty() ? "Face " + std::to_string(f) : name;
      content.patches.push_back(std::move(converted.patch));
      content.layers.push_back(names.layer(face));
      run.report(0.6 + 0.4 * f / faces.Extent());
    }
    tellDropped();
  }
  catch (const Standard_Failure& failure)
  {
    const std::string why = failure.GetMessageString();
    throw Error(fileName + ": OpenCASCADE cannot read it as a " + format + " file" + (why.empty() ? "" : ": " + why));
  }
  return content;
}

} // namespace bsv

#endif
