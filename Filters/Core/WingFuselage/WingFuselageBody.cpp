// SPDX-License-Identifier: BSD-3-Clause
#include "WingFuselage/WingFuselageBody.h"

#include "Base/Numbers.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace bsv
{
namespace
{

/// From 0 to 1 with the slopes s0 and s1 at the ends.
double stretch(double t, double s0, double s1)
{
  return t * (s0 + t * ((3.0 - 2.0 * s0 - s1) + t * (s0 + s1 - 2.0)));
}

/// From 0 to 1 with the slopes s0 and s1 at the ends, and almost equal steps near 1.
double stretchEvenly(double t, double s0, double s1)
{
  // The derivative is s1 + (1-t)^2 (a + b t).
  const double a = s0 - s1;
  const double b = 12.0 * (1.0 - s1) - 4.0 * a;
  return t * (s1 + a + t * (0.5 * (b - 2.0 * a) + t * ((a - 2.0 * b) / 3.0 + t * 0.25 * b)));
}

/// The fuselage: an image of the half sphere n_y >= 0, and that of the unit disc (stereographic projection), which has
/// no poles.
class Fuselage
{
public:
  static constexpr double HalfLength = 3.0;

  static Vec3 point(const Vec2& disc)
  {
    const double r2 = disc.squaredNorm();
    const Vec3 n = Vec3(2.0 * disc[0], std::max(1.0 - r2, 0.0), 2.0 * disc[1]) / (1.0 + r2);
    const double g = scale(n[0]);
    return { HalfLength * n[0], g * n[1], g * n[2] + axis(n[0]) };
  }

  static Vec2 disc(const Vec3& x)
  {
    const double nx = x[0] / HalfLength;
    const double g = scale(nx);
    return Vec2(nx, (x[2] - axis(nx)) / g) / (1.0 + x[1] / g);
  }

  /// Negative inside.
  static double side(const Vec3& x)
  {
    const double nx = x[0] / HalfLength;
    const double g = scale(nx);
    return x[1] * x[1] + std::pow(x[2] - axis(nx), 2) - g * g * (1.0 - nx * nx);
  }

private:
  /// The radius is scale(n_x) sqrt(1 - n_x^2) = 0.5 sqrt(1 - n_x^4) but for a slight taper.
  static double scale(double nx) { return 0.5 * std::sqrt(1.0 + nx * nx) * (1.0 - 0.1 * nx); }
  /// The tail sweeps up.
  static double axis(double nx) { return 0.06 * (1.0 + nx) * (1.0 + nx); }
};

class Wing
{
public:
  explicit Wing(const WingFuselageShape& shape)
    : Span(shape.span)
    , Sweep(std::tan(shape.sweepAngle * Pi / 180.0))
  {
  }

  /// Patch 4..7 at (a, b).
  Vec3 side(int patch, double a, double b) const
  {
    const Vec2 root = this->section(patch, a);
    const double first = this->rootStation(root);
    // The steps at the tip do not depend on the span.
    const double last = this->lastStation(patch, a);
    const double station = first + (last - first) * stretchEvenly(b, 0.6, TipStep / ((last - first) * this->Span));
    if (patch == 4 && station > 1.0)
    {
      // Beyond the tip station lines of constant height go on over the round end.
      const double w = widthAt(std::hypot(this->beyond(station), root[1]));
      return this->place({ w * w, root[1] }, station);
    }
    return this->place(root, station);
  }

  /// Patch 8: arcs across the tip, from rim to rim; those near the leading edge bend forward over it.
  Vec3 tip(double a, double b) const
  {
    const double across = 2.0 * a - 1.0;
    const double height = halfThickness(LeadingWidth * across);
    const double out = leadingReach(height);
    const double fade = std::pow(1.0 - b, 3);
    const double w = chordwise(b) - (LeadingWidth - widthAt(std::hypot(out, height))) * fade;
    const double angle = across + (std::atan2(height, out) / (0.5 * Pi) - across) * fade;
    const Vec2 arc = endArc(w, angle);
    return this->place({ w * w, arc[1] }, this->stationBeyond(arc[0]));
  }

private:
  static constexpr double RootChord = 1.8, TipChord = 0.9, QuarterChordAtRoot = -0.4;
  static constexpr double EdgeHalfThickness = 0.01;
  /// Square root of the chord fraction where the leading-edge patch ends.
  static constexpr double LeadingWidth = 0.22;
  /// Derivative of the distance along the span with respect to b, at the tip.
  static constexpr double TipStep = 0.54;
  /// Depth of the round end over the thickness of the section.
  static constexpr double TipDepth = 2.5;

  /// Half thickness over the chord at the chord fraction w^2; odd in w, so that the section is smooth at w = 0.
  static double halfThickness(double w)
  {
    const double x = w * w;
    return w * ((1.0 - x) * (0.19 - 0.02 * x) + x * EdgeHalfThickness);
  }

  /// The w in 0..LeadingWidth of a half thickness.
  static double widthAt(double height)
  {
    double low = 0.0, high = LeadingWidth;
    for (int i = 0; i < 60; ++i)
    {
      const double middle = 0.5 * (low + high);
      (halfThickness(middle) < height ? low : high) = middle;
    }
    return 0.5 * (low + high);
  }

  /// w along the upper side: small steps at both ends.
  static double chordwise(double a) { return LeadingWidth + (1.0 - LeadingWidth) * stretch(a, 1.0, 0.06); }

  /// How far the leading-edge patch reaches over the round end, at a height; both over the chord.
  static double leadingReach(double height)
  {
    const double last = halfThickness(LeadingWidth);
    return 0.5 * last * (1.0 - std::pow(height / last, 2));
  }

  /// Section of the round end at w across the chord: an arc from the lower (angle = -1) to the upper (angle = 1) rim,
  /// as (reach, height). A half circle at the leading edge, almost flat at the trailing edge.
  static Vec2 endArc(double w, double angle)
  {
    const double t = std::clamp((w - LeadingWidth) / (1.0 - LeadingWidth), 0.0, 1.0);
    const double opening = 0.5 * Pi + (0.2 - 0.5 * Pi) * t * t * (3.0 - 2.0 * t);
    return halfThickness(w) / std::sin(opening) *
      Vec2(std::cos(opening * angle) - std::cos(opening), std::sin(opening * angle));
  }

  /// Point of the section (chord fraction, height over chord) where the lines of a patch start.
  Vec2 section(int patch, double a) const
  {
    double w = 0.0;
    switch (patch)
    {
      case 4:
        w = LeadingWidth * (2.0 * a - 1.0);
        break;
      case 5:
        w = chordwise(a);
        break;
      case 6:
        return { 1.0, EdgeHalfThickness * (1.0 - 2.0 * a) };
      default:
        w = -chordwise(1.0 - a);
    }
    return { w * w, halfThickness(w) };
  }

  double lastStation(int patch, double a) const
  {
    if (patch == 4)
    {
      return this->stationBeyond(leadingReach(this->section(4, a)[1]));
    }
    return patch == 6 ? this->stationBeyond(endArc(1.0, 1.0 - 2.0 * a)[0]) : 1.0;
  }

  double stationBeyond(double reach) const { return 1.0 + reach * TipDepth * TipChord / this->Span; }
  double beyond(double station) const { return (station - 1.0) * this->Span / (TipDepth * TipChord); }

  /// Where a point of the section is at a station: 0 on the symmetry plane, 1 at the tip.
  Vec3 place(const Vec2& section, double station) const
  {
    const double chord = RootChord + station * (TipChord - RootChord);
    const double incidence = (2.0 - 4.0 * station) * Pi / 180.0;
    const double x = chord * (section[0] - 0.25);
    const double z = chord * section[1];
    const double y = station * this->Span;
    constexpr double Dihedral = 0.07;
    return { QuarterChordAtRoot + y * this->Sweep + std::cos(incidence) * x + std::sin(incidence) * z, y,
      y * Dihedral + std::cos(incidence) * z - std::sin(incidence) * x };
  }

  /// Station where a line of the wing leaves the fuselage.
  double rootStation(const Vec2& section) const
  {
    double low = 0.0, high = 0.8 / this->Span;
    for (int i = 0; i < 60; ++i)
    {
      const double middle = 0.5 * (low + high);
      (Fuselage::side(this->place(section, middle)) < 0.0 ? low : high) = middle;
    }
    return 0.5 * (low + high);
  }

  double Span;
  double Sweep;
};

/// Patch 0..3 at (a, b): in the disc, straight lines from the symmetry plane to the junction.
Vec3 fuselageSide(const Wing& wing, int patch, double a, double b)
{
  const Vec2 inner = Fuselage::disc(wing.side(patch + 4, a, 0.0));
  const double angle = (2.5 - (patch + a)) * 0.5 * Pi;
  const Vec2 rim(std::cos(angle), std::sin(angle));
  Vec3 x = Fuselage::point(rim + (inner - rim) * stretch(b, 1.0, 0.3));
  if (b == 0.0)
  {
    x[1] = 0.0;
  }
  return x;
}

/// Bicubic interpolation at the Greville abscissae of clamped uniform knots.
class Interpolation
{
public:
  explicit Interpolation(int spans)
    : Count(spans + 3)
    , Knots(spans + 7)
  {
    for (int i = 0; i < spans + 7; ++i)
    {
      this->Knots[i] = std::clamp(i - 3, 0, spans) / double(spans);
    }
    Eigen::MatrixXd values = Eigen::MatrixXd::Zero(this->Count, this->Count);
    for (int i = 0; i < this->Count; ++i)
    {
      this->Sites.push_back((this->Knots[i + 1] + this->Knots[i + 2] + this->Knots[i + 3]) / 3.0);
      for (int j = 0; j < this->Count; ++j)
      {
        values(i, j) = this->basis(j, 3, this->Sites[i]);
      }
    }
    this->Inverse = values.inverse();
  }

  template <typename Point>
  NURBSSurface surface(const Point& point) const
  {
    NURBSSurface result;
    result.knots = { this->Knots, this->Knots };
    result.points.resize(std::size_t(this->Count) * this->Count);
    std::array<Eigen::MatrixXd, 3> data;
    data.fill(Eigen::MatrixXd(this->Count, this->Count));
    for (int j = 0; j < this->Count; ++j)
    {
      for (int i = 0; i < this->Count; ++i)
      {
        const Vec3 x = point(this->Sites[i], this->Sites[j]);
        for (int d = 0; d < 3; ++d)
        {
          data[d](i, j) = x[d];
        }
      }
    }
    for (int d = 0; d < 3; ++d)
    {
      const Eigen::MatrixXd control = this->Inverse * data[d] * this->Inverse.transpose();
      for (int j = 0; j < this->Count; ++j)
      {
        for (int i = 0; i < this->Count; ++i)
        {
          result.points[i + std::size_t(this->Count) * j][d] = control(i, j);
        }
      }
    }
    return result;
  }

private:
  /// Cox-de Boor recursion; the last function is 1 at the end.
  double basis(int i, int degree, double t) const
  {
    if (degree == 0)
    {
      const bool last = t == this->Knots.back() && this->Knots[i + 1] == t;
      return (this->Knots[i] <= t && t < this->Knots[i + 1]) || (last && this->Knots[i] < t) ? 1.0 : 0.0;
    }
    const double left = this->Knots[i + degree] - this->Knots[i];
    const double right = this->Knots[i + degree + 1] - this->Knots[i + 1];
    return (left > 0.0 ? (t - this->Knots[i]) / left * this->basis(i, degree - 1, t) : 0.0) +
      (right > 0.0 ? (this->Knots[i + degree + 1] - t) / right * this->basis(i + 1, degree - 1, t) : 0.0);
  }

  int Count;
  std::vector<double> Knots;
  std::vector<double> Sites;
  Eigen::MatrixXd Inverse;
};

/// Control point n of a side.
Vec3& sidePoint(NURBSSurface& surface, int side, int n)
{
  const int counts[2] = { surface.count(0), surface.count(1) };
  const int fixed = side % 2 == 0 ? 0 : counts[side / 2] - 1;
  return side < 2 ? surface.points[fixed + std::size_t(counts[0]) * n]
                  : surface.points[n + std::size_t(counts[0]) * fixed];
}

} // namespace

void checkRange(const char* name, double value, double low, double high)
{
  if (!(value >= low && value <= high))
  {
    std::ostringstream text;
    text << name << " " << value << " is not between " << low << " and " << high;
    throw Error(text.str());
  }
}

void checkWingFuselageShape(const WingFuselageShape& shape)
{
  checkRange("Span", shape.span, 2.0, 6.0);
  checkRange("Sweep Angle", shape.sweepAngle, 0.0, 45.0);
}

const std::vector<PatchSeam>& wingFuselageSeams()
{
  static const std::vector<PatchSeam> seams = [] {
    std::vector<PatchSeam> made;
    for (int p = 0; p < 4; ++p)
    {
      made.push_back({ { p, 1 }, { (p + 1) % 4, 0 }, false, false });
      made.push_back({ { p + 4, 1 }, { (p + 1) % 4 + 4, 0 }, false, p == 1 || p == 2 });
      made.push_back({ { p + 4, 2 }, { p, 3 }, false, true });
    }
    made.push_back({ { 4, 3 }, { 8, 2 }, false, false });
    made.push_back({ { 5, 3 }, { 8, 1 }, false, true });
    made.push_back({ { 6, 3 }, { 8, 3 }, true, true });
    made.push_back({ { 7, 3 }, { 8, 0 }, true, true });
    return made;
  }();
  return seams;
}

std::vector<BodyPatch> wingFuselageBody(const WingFuselageShape& shape)
{
  checkWingFuselageShape(shape);
  static constexpr const char* Names[WingFuselagePatches] = { "fuselage_front", "fuselage_top", "fuselage_rear",
    "fuselage_bottom", "wing_leading_edge", "wing_upper", "wing_trailing_edge", "wing_lower", "wing_tip" };
  // Enough for the round end at the leading edge, the smallest feature.
  constexpr int Spans = 32;
  const Interpolation interpolation(Spans);
  const Wing wing(shape);
  std::vector<BodyPatch> patches(WingFuselagePatches);
  for (int p = 0; p < WingFuselagePatches; ++p)
  {
    patches[p].name = Names[p];
    patches[p].surface = interpolation.surface([&](double a, double b) {
      return p < 4 ? fuselageSide(wing, p, a, b) : p < 8 ? wing.side(p, a, b) : wing.tip(a, b);
    });
  }

  // Two rounds, as corners belong to several sides.
  for (int round = 0; round < 2; ++round)
  {
    for (const PatchSeam& seam : wingFuselageSeams())
    {
      const int last = Spans + 2;
      for (int n = 0; n <= last; ++n)
      {
        sidePoint(patches[seam.second.patch].surface, seam.second.side, seam.reversed ? last - n : n) =
          sidePoint(patches[seam.first.patch].surface, seam.first.side, n);
      }
    }
  }
  for (int p = 0; p < 4; ++p)
  {
    for (int n = 0; n < patches[p].surface.count(0); ++n)
    {
      sidePoint(patches[p].surface, 2, n)[1] = 0.0;
    }
  }
  return patches;
}

} // namespace bsv
