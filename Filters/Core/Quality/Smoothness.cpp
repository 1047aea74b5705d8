// SPDX-License-Identifier: BSD-3-Clause
#include "Quality/Smoothness.h"

#include "Mesh/SharedEntities.h"
#include "Ranks/Ranks.h"
#include "Volume/ControlPointRule.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

namespace bsv
{

namespace
{

/// Homogeneous value, first and second outward derivative: 3 x (x y z w). w is not used for polynomial volumes.
using Layers = Eigen::Array<double, 12, 1>;
using Homogeneous = Eigen::Array<double, 4, 1>;

constexpr double Rounding = 64.0 * std::numeric_limits<double>::epsilon();
constexpr double Degrees = 57.295779513082320877;

//------------------------------------------------------------------------------
// Traces: what a join needs to know of one block
//------------------------------------------------------------------------------

/// Weights of the control points next to a face, from the face inwards, for the value and the outward derivatives
/// there.
struct EndWeights
{
  int first; ///< control point on the face
  int step;  ///< +-1, inwards
  int count;
  double at;     ///< parameter of the face
  double length; ///< of the first span
  std::array<std::array<double, MaxDegree + 1>, 3> values;

  EndWeights(const BSplineVolume& volume, int face)
  {
    const int d = faceDirection(face);
    const int degree = volume.degree[d];
    const std::vector<double>& knots = volume.knots[d];
    const bool end = faceSide(face) != 0;
    const std::vector<int> spans = nonEmptySpans(degree, knots);
    const int span = end ? spans.back() : spans.front();
    this->first = end ? span : span - degree;
    this->step = end ? -1 : 1;
    this->count = degree + 1;
    this->at = knots[span + (end ? 1 : 0)];
    this->length = knots[span + 1] - knots[span];
    double left[MaxDegree + 1];
    double right[MaxDegree + 1];
    for (int j = 1; j <= degree; ++j)
    {
      left[j] = this->at - knots[span + 1 - j];
      right[j] = knots[span + j] - this->at;
    }
    for (int order = 0; order < 3; ++order)
    {
      basisFunctions(degree, order, left, right, this->values[order].data());
      if (end)
      {
        std::reverse(this->values[order].begin(), this->values[order].begin() + degree + 1);
      }
      else if (order == 1)
      {
        for (double& value : this->values[order])
        {
          value = -value;
        }
      }
    }
    while (this->count > 1 && this->values[0][this->count - 1] == 0.0 && this->values[1][this->count - 1] == 0.0 &&
      this->values[2][this->count - 1] == 0.0)
    {
      --this->count;
    }
  }
};

/// B-spline surface, or curve with a second axis of degree 0, of Layers.
struct Trace
{
  std::array<int, 2> degree{ 0, 0 };
  std::array<int, 2> count{ 1, 1 };
  std::array<std::vector<double>, 2> knots{ { { 0.0, 1.0 }, { 0.0, 1.0 } } };
  std::vector<Layers> net;
  bool rational = false;
  double length = 0.0; ///< of the first span across
  double size = 0.0;   ///< largest coordinate

  std::size_t points() const { return std::size_t(this->count[0]) * this->count[1]; }
  const Layers& at(int i, int j) const { return this->net[i + std::size_t(this->count[0]) * j]; }
};

/// Block directions along the axes of a trace.
std::array<int, 2> traceAxes(int face, int within)
{
  const std::array<int, 2> axes{ faceAxis(face, 0), faceAxis(face, 1) };
  return within >= 0 && axes[0] == faceDirection(within) ? std::array<int, 2>{ axes[1], axes[0] } : axes;
}

/// A trace without its net, which needs no control points.
Trace emptyTrace(const BSplineVolume& volume, int face, int within)
{
  const std::array<int, 2> axes = traceAxes(face, within);
  Trace trace;
  trace.length = EndWeights(volume, face).length;
  for (int k = 0; k < (within < 0 ? 2 : 1); ++k)
  {
    trace.degree[k] = volume.degree[axes[k]];
    trace.count[k] = volume.count(axes[k]);
    trace.knots[k] = volume.knots[axes[k]];
  }
  return trace;
}

/// The block face `face`; or, with `within` >= 0, its edge in the boundary face `within`.
Trace makeTrace(const BSplineVolume& volume, int face, int within)
{
  const EndWeights across(volume, face);
  const std::array<int, 2> axes = traceAxes(face, within);
  Trace trace = emptyTrace(volume, face, within);
  trace.rational = volume.weights != nullptr;
  trace.net.reserve(trace.points());
  const std::array<Index, 3> stride{ 1, volume.count(0), Index(volume.count(0)) * volume.count(1) };
  const auto layers = [&](int i, int j) {
    Layers sum = Layers::Zero();
    Index place = i * stride[axes[0]] + j * stride[axes[1]] + across.first * stride[faceDirection(face)];
    for (int q = 0; q < across.count; ++q, place += across.step * stride[faceDirection(face)])
    {
      const double w = trace.rational ? volume.weights[place] : 1.0;
      const double* x = volume.points + 3 * place;
      const Homogeneous point(w * x[0], w * x[1], w * x[2], w);
      for (int order = 0; order < 3; ++order)
      {
        sum.segment<4>(4 * order) += across.values[order][q] * point;
      }
      for (int d = 0; d < 3; ++d)
      {
        // A NaN stays.
        trace.size = std::isnan(x[d]) || std::abs(x[d]) > trace.size ? std::abs(x[d]) : trace.size;
      }
    }
    return sum;
  };
  if (within < 0)
  {
    for (int j = 0; j < trace.count[1]; ++j)
    {
      for (int i = 0; i < trace.count[0]; ++i)
      {
        trace.net.push_back(layers(i, j));
      }
    }
    return trace;
  }
  const EndWeights side(volume, within);
  for (int i = 0; i < trace.count[0]; ++i)
  {
    Layers sum = Layers::Zero();
    for (int q = 0; q < side.count; ++q)
    {
      if (side.values[0][q] != 0.0)
      {
        sum += side.values[0][q] * layers(i, side.first + q * side.step);
      }
    }
    trace.net.push_back(sum);
  }
  return trace;
}

/// A trace as numbers for another rank. The weights of a polynomial one are the same at all its points.
std::vector<double> packedTrace(const Trace& trace)
{
  std::vector<double> numbers{ trace.rational ? 1.0 : 0.0, trace.size };
  numbers.reserve(5 + 12 * trace.points());
  for (int layer = 0; layer < 3; ++layer)
  {
    numbers.push_back(trace.net[0][4 * layer + 3]);
  }
  for (const Layers& point : trace.net)
  {
    for (int layer = 0; layer < 3; ++layer)
    {
      numbers.insert(numbers.end(), point.data() + 4 * layer, point.data() + 4 * layer + (trace.rational ? 4 : 3));
    }
  }
  return numbers;
}

/// Completes an emptyTrace(). @return what follows in the numbers.
const double* unpackTrace(const double* numbers, Trace& trace)
{
  trace.rational = *numbers++ != 0.0;
  trace.size = *numbers++;
  const double* weights = numbers;
  numbers += 3;
  trace.net.resize(trace.points());
  for (Layers& point : trace.net)
  {
    for (int layer = 0; layer < 3; ++layer)
    {
      const int size = trace.rational ? 4 : 3;
      point[4 * layer + 3] = weights[layer];
      std::copy_n(numbers, size, point.data() + 4 * layer);
      numbers += size;
    }
  }
  return numbers;
}

//------------------------------------------------------------------------------
// Frames: in which order and sense a join is evaluated, so that its bits do not depend on how blocks are stored
//------------------------------------------------------------------------------

/// Axis k of the frame runs along the trace's axis axis[k], backwards if flip[k].
struct Frame
{
  std::array<int, 2> axis{ 0, 1 };
  std::array<bool, 2> flip{ false, false };

  /// The same frame seen from the other side of a contact.
  Frame across(int orientation) const
  {
    Frame other;
    for (int k = 0; k < 2; ++k)
    {
      other.axis[k] = swapsAxes(orientation) ? 1 - this->axis[k] : this->axis[k];
      other.flip[k] = this->flip[k] != ((orientation & (other.axis[k] == 0 ? 2 : 4)) != 0);
    }
    return other;
  }
};

/// View of a trace in a frame. Reversed knots change their sign, which keeps the bits of all differences.
struct FramedTrace
{
  const Trace* trace;
  Frame frame;

  int count(int k) const { return this->trace->count[this->frame.axis[k]]; }
  int degree(int k) const { return this->trace->degree[this->frame.axis[k]]; }
  double knot(int k, int i) const
  {
    const std::vector<double>& knots = this->trace->knots[this->frame.axis[k]];
    return this->frame.flip[k] ? -knots[knots.size() - 1 - i] : knots[i];
  }
  const Layers& at(int i, int j) const
  {
    const std::array<int, 2> in{ this->frame.flip[0] ? this->count(0) - 1 - i : i,
      this->frame.flip[1] ? this->count(1) - 1 - j : j };
    return this->trace->at(in[this->frame.axis[0] == 0 ? 0 : 1], in[this->frame.axis[0] == 0 ? 1 : 0]);
  }

  Trace copy() const
  {
    Trace result;
    result.rational = this->trace->rational;
    result.length = this->trace->length;
    result.size = this->trace->size;
    for (int k = 0; k < 2; ++k)
    {
      result.degree[k] = this->degree(k);
      result.count[k] = this->count(k);
      result.knots[k].clear();
      for (int i = 0; i < this->count(k) + this->degree(k) + 1; ++i)
      {
        result.knots[k].push_back(this->knot(k, i));
      }
    }
    result.net.reserve(this->trace->net.size());
    for (int j = 0; j < this->count(1); ++j)
    {
      for (int i = 0; i < this->count(0); ++i)
      {
        result.net.push_back(this->at(i, j));
      }
    }
    return result;
  }
};

/// Lexicographic order of two framed traces: -1, 0, 1.
int compare(const FramedTrace& a, const FramedTrace& b)
{
  const auto sign = [](double x, double y) { return x < y ? -1 : x > y ? 1 : 0; };
  for (int k = 0; k < 2; ++k)
  {
    if (const int c = sign(a.count(k), b.count(k)))
    {
      return c;
    }
    if (const int c = sign(a.degree(k), b.degree(k)))
    {
      return c;
    }
  }
  for (int j = 0; j < a.count(1); ++j)
  {
    for (int i = 0; i < a.count(0); ++i)
    {
      const Layers& x = a.at(i, j);
      const Layers& y = b.at(i, j);
      for (int n = 0; n < 12; ++n)
      {
        if (const int c = sign(x[n], y[n]))
        {
          return c;
        }
      }
    }
  }
  for (int k = 0; k < 2; ++k)
  {
    for (int i = 0; i < a.count(k) + a.degree(k); ++i)
    {
      if (const int c = sign(a.knot(k, i + 1) - a.knot(k, i), b.knot(k, i + 1) - b.knot(k, i)))
      {
        return c;
      }
    }
  }
  return 0;
}

//------------------------------------------------------------------------------
// Evaluation
//------------------------------------------------------------------------------

struct Basis
{
  int first = 0;
  std::array<double, MaxDegree + 1> values{};
  std::array<double, MaxDegree + 1> slopes{};
  double length = 0.0; ///< of the span
};

/// Span of a join along one axis: a part of one knot span of either side.
struct Cell
{
  struct Part
  {
    int span = 0;
    double start = 0.0;               ///< parameter
    double before = 0.0, after = 0.0; ///< from the knot before and to the knot after it
    double width = 0.0;
  };
  std::array<Part, 2> parts;
  /// Derivatives along the join may be discontinuous at its end.
  bool breaksAfter = false;
};

Basis basisAt(const Trace& trace, int k, const Cell::Part& part, double x, double rest)
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
  Basis basis;
  basis.first = part.span - degree;
  basis.length = part.before + part.width + part.after;
  basisFunctions(degree, 0, left, right, basis.values.data());
  basisFunctions(degree, 1, left, right, basis.slopes.data());
  return basis;
}

/// One-sided sample position along an axis, for both sides of the join.
using Station = std::array<Basis, 2>;

/// What one side says at a point. Vectors that are zero up to rounding are zero.
struct SideValues
{
  Vec3 x, s, t, n, n2;
};

SideValues evaluateSide(const Trace& trace, const Basis& s, const Basis& t)
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
  const double zero = Rounding * trace.size;
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

/// Degrees; 0 if one of them is zero.
double angle(const Vec3& a, const Vec3& b)
{
  return std::atan2(a.cross(b).norm(), a.dot(b)) * Degrees;
}

/// Zero where the two are parallel up to rounding.
Vec3 normalOf(const Vec3& s, const Vec3& n)
{
  constexpr double Parallel = 1e-10;
  const Vec3 normal = s.cross(n);
  return normal.norm() > Parallel * s.norm() * n.norm() ? normal : Vec3::Zero();
}

/// @param boundToKink the layers through s and t
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

/// Follows f over the unit square from a sample to a local maximum: the largest of 3 x 3 points and of the quadratic
/// through them becomes the middle of the next, smaller 3 x 3, as long as this gains something. The step starts at that
/// of the samples.
template <typename Function>
void climb(const Function& f, double step, double& x, double& y, double& best)
{
  constexpr int Rounds = 12;
  constexpr double Shrink = 0.2;
  constexpr double Fine = 1e-2;
  const auto offer = [&](double u, double v) {
    const double value = f(u, v);
    if (value > best)
    {
      best = value;
      x = u;
      y = v;
    }
    return value;
  };
  // Vertex of the parabola through three values at -1, 0, 1, or the best of them.
  const auto vertex = [](double low, double middle, double high) {
    const double curvature = low + high - 2.0 * middle;
    const double slope = 0.5 * (high - low);
    return curvature < 0.0 ? std::min(std::max(-slope / curvature, -1.0), 1.0) : slope > 0.0 ? 1.0 : -1.0;
  };
  for (int round = 0; round < Rounds; ++round)
  {
    step = std::min(step, 0.5);
    const double before = best;
    const double cx = std::min(std::max(x, step), 1.0 - step);
    const double cy = std::min(std::max(y, step), 1.0 - step);
    double v[3][3];
    for (int j = 0; j < 3; ++j)
    {
      for (int i = 0; i < 3; ++i)
      {
        // Not beyond the borders, up to the last bit.
        v[j][i] =
          offer(std::min(std::max(cx + (i - 1) * step, 0.0), 1.0), std::min(std::max(cy + (j - 1) * step, 0.0), 1.0));
      }
    }
    const auto tryOffset = [&](double dx, double dy) {
      offer(std::min(std::max(cx + dx * step, 0.0), 1.0), std::min(std::max(cy + dy * step, 0.0), 1.0));
    };
    const double gx = 0.5 * (v[1][2] - v[1][0]);
    const double gy = 0.5 * (v[2][1] - v[0][1]);
    const double hxx = v[1][2] + v[1][0] - 2.0 * v[1][1];
    const double hyy = v[2][1] + v[0][1] - 2.0 * v[1][1];
    const double hxy = 0.25 * (v[2][2] + v[0][0] - v[0][2] - v[2][0]);
    const double determinant = hxx * hyy - hxy * hxy;
    if (hxx < 0.0 && determinant > 0.0)
    {
      const double dx = -(hyy * gx - hxy * gy) / determinant;
      const double dy = -(hxx * gy - hxy * gx) / determinant;
      if (std::abs(dx) <= 1.0 && std::abs(dy) <= 1.0)
      {
        tryOffset(dx, dy);
      }
    }
    for (int side = 0; side < 3; side += 2)
    {
      tryOffset(vertex(v[side][0], v[side][1], v[side][2]), side - 1);
      tryOffset(side - 1, vertex(v[0][side], v[1][side], v[2][side]));
    }
    if (best == before && step < Fine)
    {
      return;
    }
    // A maximum on the border of the 3 x 3 may lie beyond it.
    const auto outside = [step](double u, double centre) {
      return u > 0.0 && u < 1.0 && std::abs(u - centre) >= (1.0 - Fine) * step;
    };
    step *= outside(x, cx) || outside(y, cy) ? 1.0 : Shrink;
  }
}

/// By how much the parabola through three equally spaced values rises between them above the largest.
double rise(double low, double middle, double high)
{
  const double curvature = low + high - 2.0 * middle;
  const double slope = 0.5 * (high - low);
  return std::abs(slope) < -curvature ? middle - 0.5 * slope * slope / curvature - std::max({ low, middle, high })
                                      : 0.0;
}

//------------------------------------------------------------------------------
// One join
//------------------------------------------------------------------------------

/// The boundary face of a wall border, else -1.
int withinFace(const Join& join, int side)
{
  return join.border() ? join.sides[side].face : -1;
}

/// The face across which derivatives are taken: on a wall border the other one at the edge.
int acrossFace(const Join& join, int k)
{
  const Join::Side& side = join.sides[k];
  if (!join.border())
  {
    return side.face;
  }
  const int direction = edgeDirection(side.edge);
  const int axis = faceAxis(2 * direction, 0) == faceDirection(side.face) ? 1 : 0;
  return 2 * faceAxis(2 * direction, axis) + edgeSide(side.edge, axis);
}

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
  bool prepare()
  {
    std::array<Trace, 2> traces;
    for (int k = 0; k < 2; ++k)
    {
      traces[k] = k == 1 && this->FetchedB
        ? std::move(*this->FetchedB)
        : makeTrace(this->volume(k), acrossFace(this->Result, k), withinFace(this->Result, k));
      if (!std::isfinite(traces[k].size))
      {
        return false;
      }
    }
    this->chooseFrame(traces);
    for (int k = 0; k < 2; ++k)
    {
      this->findCells(k);
      this->placeStations(k);
    }
    const std::array<int, 2>& axis = this->frameOfA().axis;
    this->BoundToKink = { this->Result.boundToKink[axis[0]], this->Result.boundToKink[axis[1]] };
    for (int k = 0; k < 2; ++k)
    {
      this->Result.spans[axis[k]] = static_cast<int>(this->Cells[k].size());
      this->Result.samples[axis[k]] = static_cast<int>(this->Stations[k].size());
    }
    const std::size_t size = std::size_t(this->Result.samples[0]) * this->Result.samples[1];
    const std::size_t spans = std::size_t(this->Result.spans[0]) * this->Result.spans[1];
    this->Result.points.resize(size);
    for (int kind = 0; kind < JumpKinds; ++kind)
    {
      this->Result.values[kind].assign(size, 0.0);
      this->Result.spanMaxima[kind].assign(spans, 0.0);
    }
    return true;
  }

  Index rows() const { return static_cast<Index>(this->Stations[1].size()); }

  void evaluateRow(Index row)
  {
    for (std::size_t i = 0; i < this->Stations[0].size(); ++i)
    {
      const std::size_t place = this->inA(this->Result.samples, static_cast<int>(i), static_cast<int>(row));
      bool first = true;
      for (const Station& t : this->Stations[1][row])
      {
        for (const Station& s : this->Stations[0][i])
        {
          Vec3 point;
          const Jumps jumps = this->evaluate(s, t, &point);
          if (first)
          {
            this->Result.points[place] = point;
            first = false;
          }
          for (int kind = 0; kind < JumpKinds; ++kind)
          {
            double& value = this->Result.values[this->kindInA(kind)][place];
            value = std::max(value, jumps[kind]);
          }
        }
      }
    }
  }

  void finish()
  {
    for (int kind = 0; kind < JumpKinds; ++kind)
    {
      if (kind != static_cast<int>(JumpKind::Layer) || (this->BoundToKink[0] && this->BoundToKink[1]))
      {
        this->findMaximum(kind);
      }
    }
    this->takeLayerMaximum();
    // The memory is needed for the next ones.
    this->Traces = {};
    this->Cells = {};
    this->Stations = {};
  }

private:
  const BSplineVolume& volume(int k) const { return this->Volumes[this->Result.sides[k].block]; }

  /// The smallest of the 16 ways to look at the join. Ways that compare equal give the same bits.
  void chooseFrame(const std::array<Trace, 2>& traces)
  {
    std::array<FramedTrace, 2> best;
    for (int way = 0; way < 16; ++way)
    {
      Frame frame;
      frame.axis = { way & 1, 1 - (way & 1) };
      frame.flip = { (way & 2) != 0, (way & 4) != 0 };
      std::array<FramedTrace, 2> sides{ { { &traces[0], frame },
        { &traces[1], frame.across(this->Result.orientation) } } };
      const bool exchange = (way & 8) != 0;
      if (exchange)
      {
        std::swap(sides[0], sides[1]);
      }
      int order = way == 0 ? -1 : compare(sides[0], best[0]);
      order = order == 0 ? compare(sides[1], best[1]) : order;
      if (order < 0)
      {
        best = sides;
        this->Exchange = exchange;
      }
    }
    for (int side = 0; side < 2; ++side)
    {
      this->Frames[side] = best[side].frame;
      this->Traces[side] = best[side].copy();
    }
    this->Length = std::min(traces[0].length, traces[1].length);
  }

  const Frame& frameOfA() const { return this->Frames[this->Exchange ? 1 : 0]; }

  void findCells(int k)
  {
    struct Side
    {
      std::vector<int> spans;
      std::vector<double> breaks, fractions;
    };
    // Breaks of the two sides closer than this part of the whole range are one.
    constexpr double Same = 1e-12;
    std::array<Side, 2> sides;
    for (int side = 0; side < 2; ++side)
    {
      const Trace& trace = this->Traces[side];
      const std::vector<double>& knots = trace.knots[k];
      const double start = knots[trace.degree[k]];
      const double end = knots[trace.count[k]];
      sides[side].spans = nonEmptySpans(trace.degree[k], knots);
      for (const int s : sides[side].spans)
      {
        sides[side].breaks.push_back(knots[s]);
      }
      sides[side].breaks.push_back(end);
      for (const double at : sides[side].breaks)
      {
        sides[side].fractions.push_back((at - start) / (end - start));
      }
    }
    std::array<std::size_t, 2> at{ 0, 0 };
    std::array<double, 2> start{ sides[0].breaks[0], sides[1].breaks[0] };
    while (at[0] < sides[0].spans.size() && at[1] < sides[1].spans.size())
    {
      const std::array<double, 2> next{ sides[0].fractions[at[0] + 1], sides[1].fractions[at[1] + 1] };
      Cell cell;
      for (int side = 0; side < 2; ++side)
      {
        const Side& me = sides[side];
        const std::size_t n = at[side];
        const bool ends = next[side] <= next[1 - side] + Same;
        double end = me.breaks[n + 1];
        if (!ends)
        {
          end = me.breaks.front() + next[1 - side] * (me.breaks.back() - me.breaks.front());
          end = std::min(std::max(end, start[side]), me.breaks[n + 1]);
        }
        Cell::Part& part = cell.parts[side];
        part.span = me.spans[n];
        part.start = start[side];
        part.before = start[side] - me.breaks[n];
        part.after = me.breaks[n + 1] - end;
        part.width = end - start[side];
        start[side] = end;
        if (ends)
        {
          ++at[side];
          cell.breaksAfter = cell.breaksAfter ||
            (at[side] < me.spans.size() && me.spans[at[side]] - me.spans[at[side] - 1] >= this->Traces[side].degree[k]);
        }
      }
      this->Cells[k].push_back(cell);
    }
  }

  Station station(int k, int cell, double x, double rest) const
  {
    Station result;
    for (int side = 0; side < 2; ++side)
    {
      result[side] = basisAt(this->Traces[side], k, this->Cells[k][cell].parts[side], x, rest);
    }
    return result;
  }

  /// Sample positions along an axis, each with one version, or two where one-sided values differ.
  void placeStations(int k)
  {
    const int cells = static_cast<int>(this->Cells[k].size());
    std::vector<std::vector<Station>>& stations = this->Stations[k];
    if (this->trivial(k))
    {
      stations.push_back({ this->station(k, 0, 0.0, 1.0) });
      return;
    }
    stations.resize(std::size_t(cells) * this->Parts + 1);
    for (int c = 0; c < cells; ++c)
    {
      const bool closed = c + 1 == cells || this->Cells[k][c].breaksAfter;
      for (int j = 0; j < this->Parts + (closed ? 1 : 0); ++j)
      {
        stations[std::size_t(c) * this->Parts + j].push_back(
          this->station(k, c, double(j) / this->Parts, double(this->Parts - j) / this->Parts));
      }
    }
  }

  /// The missing axis of a wall border.
  bool trivial(int k) const { return this->Traces[0].degree[k] == 0; }

  /// Place in an array of the result, which has the axes of side A, of item (i, j) of the frame.
  std::size_t inA(const std::array<int, 2>& counts, int i, int j) const
  {
    const Frame& frame = this->frameOfA();
    std::array<int, 2> place{ i, j };
    for (int k = 0; k < 2; ++k)
    {
      place[k] = frame.flip[k] ? counts[frame.axis[k]] - 1 - place[k] : place[k];
    }
    return frame.axis[0] == 0 ? place[0] + std::size_t(counts[0]) * place[1]
                              : place[1] + std::size_t(counts[0]) * place[0];
  }

  int kindInA(int kind) const
  {
    const int first = static_cast<int>(JumpKind::NormalS);
    const int second = static_cast<int>(JumpKind::NormalT);
    const bool swapped = this->frameOfA().axis[0] == 1;
    return swapped && (kind == first || kind == second) ? first + second - kind : kind;
  }

  Jumps evaluate(const Station& s, const Station& t, Vec3* point = nullptr) const
  {
    const SideValues a = evaluateSide(this->Traces[0], s[0], t[0]);
    const SideValues b = evaluateSide(this->Traces[1], s[1], t[1]);
    if (point)
    {
      *point = 0.5 * (a.x + b.x);
    }
    return jumpsOf(a, b, this->Length, this->BoundToKink);
  }

  /// Best sample of a cell.
  struct Best
  {
    double value;
    double hope; ///< what parabolas through the samples promise, generously
    std::array<int, 2> cell;
    double x, y;
  };

  Best bestSample(const std::vector<double>& values, const std::array<int, 2>& cell) const
  {
    const auto at = [&](int i, int j) {
      return values[this->inA(this->Result.samples, cell[0] * this->Parts + i, cell[1] * this->Parts + j)];
    };
    const std::array<int, 2> last{ this->trivial(0) ? 0 : this->Parts, this->trivial(1) ? 0 : this->Parts };
    int bi = 0;
    int bj = 0;
    for (int j = 0; j <= last[1]; ++j)
    {
      for (int i = 0; i <= last[0]; ++i)
      {
        if (at(i, j) > at(bi, bj))
        {
          bi = i;
          bj = j;
        }
      }
    }
    Best best{ at(bi, bj), 0.0, cell, double(bi) / this->Parts, double(bj) / this->Parts };
    constexpr double Generous = 2.0;
    best.hope = best.value;
    if (this->Parts < 2)
    {
      best.hope = std::numeric_limits<double>::infinity();
      return best;
    }
    const int i = std::min(std::max(bi - 1, 0), this->Parts - 2);
    const int j = std::min(std::max(bj - 1, 0), this->Parts - 2);
    best.hope += last[0] > 0 ? Generous * rise(at(i, bj), at(i + 1, bj), at(i + 2, bj)) : 0.0;
    best.hope += last[1] > 0 ? Generous * rise(at(bi, j), at(bi, j + 1), at(bi, j + 2)) : 0.0;
    return best;
  }

  /// Layer is one of the normal jumps, or the larger one.
  void takeLayerMaximum()
  {
    const int s = static_cast<int>(JumpKind::NormalS);
    const int t = static_cast<int>(JumpKind::NormalT);
    const int layer = static_cast<int>(JumpKind::Layer);
    const std::array<bool, 2>& bound = this->Result.boundToKink;
    if (bound[0] && bound[1])
    {
      return;
    }
    auto& worst = this->Result.worst;
    auto& maxima = this->Result.spanMaxima;
    worst[layer] = bound[0] || (!bound[1] && worst[t].value > worst[s].value) ? worst[t] : worst[s];
    for (std::size_t n = 0; n < maxima[layer].size(); ++n)
    {
      maxima[layer][n] = std::max(bound[0] ? 0.0 : maxima[s][n], bound[1] ? 0.0 : maxima[t][n]);
    }
  }

  void findMaximum(int kind)
  {
    const std::vector<double>& values = this->Result.values[this->kindInA(kind)];
    std::vector<double>& maxima = this->Result.spanMaxima[this->kindInA(kind)];
    const std::array<int, 2> cells{ static_cast<int>(this->Cells[0].size()), static_cast<int>(this->Cells[1].size()) };
    std::vector<Best> best;
    for (int cj = 0; cj < cells[1]; ++cj)
    {
      for (int ci = 0; ci < cells[0]; ++ci)
      {
        const Best here = this->bestSample(values, { ci, cj });
        maxima[this->inA(this->Result.spans, ci, cj)] = here.value;
        best.push_back(here);
      }
    }
    constexpr double Close = 0.8;
    constexpr std::size_t Most = 8;
    const std::size_t some = std::min(Most, best.size());
    std::partial_sort(best.begin(), best.begin() + some, best.end(), [](const Best& a, const Best& b) {
      return a.value != b.value ? a.value > b.value : a.cell[1] != b.cell[1] ? a.cell[1] < b.cell[1] : a.cell < b.cell;
    });
    const double highest = best.front().value;
    Best winner = best.front();
    for (std::size_t n = 0; n < some && highest > 0.0 && best[n].value >= Close * highest; ++n)
    {
      Best here = best[n];
      if (here.hope >= winner.value && this->worthClimbing(kind, highest))
      {
        const auto f = [&](double x, double y) {
          const Station s = this->station(0, here.cell[0], x, 1.0 - x);
          const Station t = this->station(1, here.cell[1], y, 1.0 - y);
          return this->evaluate(s, t)[kind];
        };
        climb(f, 1.0 / this->Parts, here.x, here.y, here.value);
        maxima[this->inA(this->Result.spans, here.cell[0], here.cell[1])] = here.value;
      }
      winner = here.value > winner.value ? here : winner;
    }

    JumpMaximum& worst = this->Result.worst[this->kindInA(kind)];
    worst.value = winner.value;
    const Station s = this->station(0, winner.cell[0], winner.x, 1.0 - winner.x);
    const Station t = this->station(1, winner.cell[1], winner.y, 1.0 - winner.y);
    this->evaluate(s, t, &worst.point);
    for (int side = 0; side < 2; ++side)
    {
      worst.uvw[this->Exchange ? 1 - side : side] = this->parameters(side, winner);
    }
  }

  /// What is rounding only has many maxima, and none of them matters.
  bool worthClimbing(int kind, double value) const
  {
    constexpr double Gap = 64.0 * Rounding;
    constexpr double Part = 1e-3;
    switch (static_cast<JumpKind>(kind))
    {
      case JumpKind::Gap:
        return value > Gap * std::max(this->Traces[0].size, this->Traces[1].size);
      case JumpKind::C1:
      case JumpKind::C2:
        return value > Part * this->Options.tolerance;
      default:
        return value > Part * this->Options.tolerance * Degrees;
    }
  }

  /// Parameters in the block of the frame's side `side`.
  Vec3 parameters(int side, const Best& best) const
  {
    const int k = this->Exchange ? 1 - side : side;
    const BSplineVolume& v = this->volume(k);
    const int face = acrossFace(this->Result, k);
    const int within = withinFace(this->Result, k);
    std::array<int, 2> axes{ faceAxis(face, 0), faceAxis(face, 1) };
    Vec3 uvw;
    uvw[faceDirection(face)] = EndWeights(v, face).at;
    if (within >= 0)
    {
      axes[0] = axes[0] == faceDirection(within) ? axes[1] : axes[0];
      uvw[faceDirection(within)] = EndWeights(v, within).at;
    }
    const Frame& frame = this->Frames[side];
    for (int n = 0; n < 2; ++n)
    {
      if (within >= 0 && frame.axis[n] == 1)
      {
        continue;
      }
      const Cell::Part& part = this->Cells[n][best.cell[n]].parts[side];
      const double u = part.start + (n == 0 ? best.x : best.y) * part.width;
      const int d = axes[frame.axis[n]];
      // No negative zero.
      uvw[d] = std::min(std::max(frame.flip[n] ? 0.0 - u : u, v.knots[d][v.degree[d]]), v.knots[d][v.count(d)]);
    }
    return uvw;
  }

  const std::vector<BSplineVolume>& Volumes;
  const SmoothnessOptions& Options;
  Trace* FetchedB;
  int Parts;
  Join& Result;
  /// In the frame; B first if Exchange.
  std::array<Trace, 2> Traces;
  std::array<Frame, 2> Frames;
  bool Exchange = false;
  double Length = 0.0;
  /// Per axis of the frame.
  std::array<bool, 2> BoundToKink{ false, false };
  std::array<std::vector<Cell>, 2> Cells;
  std::array<std::vector<std::vector<Station>>, 2> Stations;
};

//------------------------------------------------------------------------------
// All joins
//------------------------------------------------------------------------------

/// The rank that measures a join.
int rankOf(const std::vector<BSplineVolume>& volumes, const Join& join)
{
  return volumes[join.sides[0].block].rank;
}

/// The pairs of outer faces that meet along a block edge.
std::vector<Join> outerBorders(const SharedEntities& shared)
{
  struct Use
  {
    int block, face, edge;
    bool reversed;
  };
  std::vector<std::vector<Use>> uses(shared.edges.size());
  for (int b = 0; b < static_cast<int>(shared.blocks.size()); ++b)
  {
    const SharedEntities::Block& block = shared.blocks[b];
    for (int e = 0; e < 12; ++e)
    {
      for (int axis = 0; axis < 2; ++axis)
      {
        const int face = 2 * faceAxis(2 * edgeDirection(e), axis) + edgeSide(e, axis);
        if (shared.faces[block.faces[face]].uses == 1)
        {
          uses[block.edges[e]].push_back({ b, face, e, block.edgeReversed[e] });
        }
      }
    }
  }
  std::vector<Join> borders;
  for (const std::vector<Use>& pair : uses)
  {
    if (pair.size() == 2)
    {
      Join join;
      for (int k = 0; k < 2; ++k)
      {
        join.sides[k] = { pair[k].block, pair[k].face, pair[k].edge };
      }
      join.orientation = pair[0].reversed != pair[1].reversed ? 2 : 0;
      join.valences[0] = -shared.edges[shared.blocks[pair[0].block].edges[pair[0].edge]].uses;
      borders.push_back(join);
    }
  }
  return borders;
}

/// Whether the control points of a border, without its ends, are all made by crease or corner rules.
bool taggedCrease(const Join& join, const BSplineVolume& volume, const unsigned char* rules)
{
  if (!rules)
  {
    return false;
  }
  const int edge = join.sides[0].edge;
  const int d = edgeDirection(edge);
  for (int n = 1; n + 1 < volume.count(d); ++n)
  {
    Ijk p;
    p[d] = n;
    for (int axis = 0; axis < 2; ++axis)
    {
      const int other = faceAxis(2 * d, axis);
      p[other] = edgeSide(edge, axis) ? volume.count(other) - 1 : 0;
    }
    const auto rule =
      static_cast<ControlPointRule>(rules[p[0] + Index(volume.count(0)) * (p[1] + Index(volume.count(1)) * p[2])]);
    if (rule != ControlPointRule::Crease && rule != ControlPointRule::Corner)
    {
      return false;
    }
  }
  return volume.count(d) > 2;
}

bool isSharp(const Join& join, double angle)
{
  std::vector<double> turns = join.values[int(JumpKind::NormalS)];
  const auto middle = turns.begin() + turns.size() / 2;
  std::nth_element(turns.begin(), middle, turns.end());
  return *middle > angle;
}

Continuity continuityOf(const Join& join, double gapTolerance, double tolerance)
{
  const auto worst = [&](JumpKind kind) { return join.worst[int(kind)].value; };
  const double kink = join.border()
    ? worst(JumpKind::NormalS)
    : std::min({ worst(JumpKind::NormalS), worst(JumpKind::NormalT), worst(JumpKind::Layer) });
  return worst(JumpKind::Gap) > gapTolerance ? Continuity::Open
    : kink > tolerance * Degrees             ? Continuity::C0
    : worst(JumpKind::C1) > tolerance        ? Continuity::G1
    : worst(JumpKind::C2) > tolerance        ? Continuity::C1
                                             : Continuity::C2;
}

/// Interior edge at which other than four blocks meet.
bool isExtraordinary(const SharedEntities::Edge& edge)
{
  return !edge.boundary && edge.uses != 4;
}

/// What the edges of an interface say about it.
void describeInterface(const SharedEntities& shared, const std::vector<bool>& crease, Join& join)
{
  for (int n = 0; n < 4; ++n)
  {
    // Side n is s = 0, s = end, t = 0, t = end; its edge runs along the other axis.
    const int axis = n < 2 ? 1 : 0;
    const int edge = shared.blocks[join.sides[0].block].edges[faceEdge(join.sides[0].face, axis, n % 2)];
    const SharedEntities::Edge& entity = shared.edges[edge];
    join.valences[n] = entity.uses * (entity.boundary ? -1 : 1);
    join.atCrease = join.atCrease || crease[edge];
    join.boundToKink[axis] = join.boundToKink[axis] || crease[edge] || isExtraordinary(entity);
  }
}

/// The samples of an interface along one of its sides, in the direction of the shared edge there.
struct SideRow
{
  std::vector<Vec3> points;
  std::vector<double> normalJump; ///< of the layers that the side pierces

  /// From another rank.
  SideRow(const double*& packed, int count)
    : normalJump(packed, packed + count)
  {
    for (packed += count; count > 0; --count, packed += 3)
    {
      this->points.emplace_back(packed);
    }
  }
  void pack(std::vector<double>& to) const
  {
    to.insert(to.end(), this->normalJump.begin(), this->normalJump.end());
    for (const Vec3& point : this->points)
    {
      to.insert(to.end(), point.data(), point.data() + 3);
    }
  }
  SideRow(const Join& join, int axis, int side, bool reversed)
  {
    const int count = join.samples[axis];
    const std::vector<double>& jumps = join.values[int(axis == 0 ? JumpKind::NormalT : JumpKind::NormalS)];
    for (int n = 0; n < count; ++n)
    {
      const int along = reversed ? count - 1 - n : n;
      const int fixed = side ? join.samples[1 - axis] - 1 : 0;
      const std::size_t place =
        axis == 0 ? along + std::size_t(join.samples[0]) * fixed : fixed + std::size_t(join.samples[0]) * along;
      this->points.push_back(join.points[place]);
      this->normalJump.push_back(jumps[place]);
    }
  }

  /// Jump at sample n of `count`: this row's own one if it has as many, else interpolated.
  double at(std::size_t n, std::size_t count) const
  {
    const std::size_t own = this->normalJump.size();
    const std::size_t numerator = n * (own - 1);
    const std::size_t low = numerator / (count - 1);
    const std::size_t rest = numerator % (count - 1);
    if (rest == 0)
    {
      return this->normalJump[low];
    }
    const double f = double(rest) / (count - 1);
    return (1.0 - f) * this->normalJump[low] + f * this->normalJump[low + 1];
  }
};

std::vector<ExtraordinaryCurve> extraordinaryCurves(const std::vector<BSplineVolume>& volumes,
  const SharedEntities& shared, const std::vector<Join>& joins, const Ranks& ranks)
{
  // visit(join, axis, side, edge, reversed) for the sides of interfaces at extraordinary edges, in one order on all
  // ranks. A row goes from the rank of the join to that of the curve.
  const auto overSides = [&](const auto& visit) {
    for (const Join& join : joins)
    {
      for (int n = 0; n < 4 && !join.border(); ++n)
      {
        const int axis = n < 2 ? 1 : 0;
        const int own = faceEdge(join.sides[0].face, axis, n % 2);
        const SharedEntities::Block& block = shared.blocks[join.sides[0].block];
        if (isExtraordinary(shared.edges[block.edges[own]]))
        {
          visit(join, axis, n % 2, block.edges[own], block.edgeReversed[own]);
        }
      }
    }
  };
  const auto rankOfEdge = [&](int edge) { return volumes[shared.edges[edge].block].rank; };
  const int rank = ranks.rank();
  std::vector<std::vector<double>> toRank(ranks.size());
  overSides([&](const Join& join, int axis, int side, int edge, bool reversed) {
    if (rankOf(volumes, join) == rank && rankOfEdge(edge) != rank)
    {
      SideRow(join, axis, side, reversed).pack(toRank[rankOfEdge(edge)]);
    }
  });
  const std::vector<std::vector<double>> received = ranks.exchange(toRank);
  std::vector<const double*> next;
  for (const std::vector<double>& part : received)
  {
    next.push_back(part.data());
  }
  std::vector<std::vector<SideRow>> rows(shared.edges.size());
  overSides([&](const Join& join, int axis, int side, int edge, bool reversed) {
    const int from = rankOf(volumes, join);
    if (rankOfEdge(edge) == rank)
    {
      rows[edge].push_back(
        from == rank ? SideRow(join, axis, side, reversed) : SideRow(next[from], join.samples[axis]));
    }
  });

  std::vector<ExtraordinaryCurve> curves;
  for (int e = 0; e < static_cast<int>(shared.edges.size()); ++e)
  {
    if (!isExtraordinary(shared.edges[e]))
    {
      continue;
    }
    ExtraordinaryCurve curve;
    curve.valence = shared.edges[e].uses;
    curve.block = shared.edges[e].block;
    curve.edge = shared.edges[e].edge;
    const auto longest = std::max_element(rows[e].begin(), rows[e].end(),
      [](const SideRow& a, const SideRow& b) { return a.points.size() < b.points.size(); });
    if (longest != rows[e].end())
    {
      curve.points = longest->points;
    }
    curve.normalJump.assign(curve.points.size(), 0.0);
    for (const SideRow& row : rows[e])
    {
      for (std::size_t n = 0; n < curve.normalJump.size(); ++n)
      {
        curve.normalJump[n] = std::max(curve.normalJump[n], row.at(n, curve.normalJump.size()));
      }
    }
    curves.push_back(std::move(curve));
  }
  return curves;
}

void checkOptions(const SmoothnessOptions& options)
{
  const auto check = [](bool good, const char* name, double value) {
    if (!good)
    {
      throw Error("smoothness: " + std::string(name) + " is out of range: " + std::to_string(value));
    }
  };
  check(
    options.samplesPerSpan >= 1 && options.samplesPerSpan <= 16, "samples per span (1..16)", options.samplesPerSpan);
  check(options.creaseAngle >= 0.0 && options.creaseAngle <= 180.0, "crease angle (0..180)", options.creaseAngle);
  check(
    options.gapTolerance >= 0.0 && std::isfinite(options.gapTolerance), "gap tolerance (>= 0)", options.gapTolerance);
  check(options.tolerance >= 0.0 && std::isfinite(options.tolerance), "tolerance (>= 0)", options.tolerance);
}

/// Control points of side A.
double controlPoints(const BSplineVolume& volume, const Join& join)
{
  const Join::Side& side = join.sides[0];
  return join.border() ? double(volume.count(edgeDirection(side.edge)))
                       : double(volume.count(faceAxis(side.face, 0))) * volume.count(faceAxis(side.face, 1));
}

/// The traces of sides B that are on other ranks than sides A, for the joins measured here; the others are empty.
std::vector<Trace> fetchTraces(
  const std::vector<BSplineVolume>& volumes, const std::vector<Join>& joins, const Execution& run)
{
  const Ranks& ranks = *run.ranks;
  std::vector<Trace> traces;
  if (ranks.size() == 1)
  {
    return traces;
  }
  // All ranks know who needs what, in one order.
  std::vector<const Join*> wanted;
  for (const Join& join : joins)
  {
    const int rankB = volumes[join.sides[1].block].rank;
    if (rankB == ranks.rank() && rankOf(volumes, join) != rankB)
    {
      wanted.push_back(&join);
    }
  }
  std::vector<std::vector<double>> packed(wanted.size());
  std::vector<std::vector<double>> toRank(ranks.size());
  ranks.together([&] {
    run.parallelFor(static_cast<Index>(wanted.size()), 1, [&](Index begin, Index end) {
      for (Index n = begin; n < end; ++n)
      {
        const Join& join = *wanted[n];
        packed[n] = packedTrace(makeTrace(volumes[join.sides[1].block], acrossFace(join, 1), withinFace(join, 1)));
      }
    });
    for (std::size_t n = 0; n < wanted.size(); ++n)
    {
      std::vector<double>& to = toRank[rankOf(volumes, *wanted[n])];
      to.insert(to.end(), packed[n].begin(), packed[n].end());
    }
  });
  const std::vector<std::vector<double>> received = ranks.exchange(toRank);
  std::vector<const double*> next;
  for (const std::vector<double>& part : received)
  {
    next.push_back(part.data());
  }
  traces.resize(joins.size());
  for (std::size_t n = 0; n < joins.size(); ++n)
  {
    const BSplineVolume& volume = volumes[joins[n].sides[1].block];
    if (volume.rank != ranks.rank() && rankOf(volumes, joins[n]) == ranks.rank())
    {
      traces[n] = emptyTrace(volume, acrossFace(joins[n], 1), withinFace(joins[n], 1));
      next[volume.rank] = unpackTrace(next[volume.rank], traces[n]);
    }
  }
  return traces;
}

/// Measures the joins of this rank in batches: their traces need more memory than their results. `done` counts the
/// control points of all its joins, `total` is their number.
void measureJoins(const std::vector<BSplineVolume>& volumes, const SmoothnessOptions& options, std::vector<Join>& joins,
  double& done, double total, const Execution& run)
{
  constexpr double BatchSize = 1e5; // control points
  std::vector<Trace> fetched = fetchTraces(volumes, joins, run);
  std::vector<std::size_t> own;
  for (std::size_t n = 0; n < joins.size(); ++n)
  {
    if (rankOf(volumes, joins[n]) == run.ranks->rank())
    {
      own.push_back(n);
    }
  }
  run.ranks->together([&] {
    for (std::size_t first = 0; first < own.size();)
    {
      run.report(done / total);
      std::vector<JoinMeasurement> batch;
      double size = 0.0;
      while (first + batch.size() < own.size() && size < BatchSize)
      {
        const std::size_t n = own[first + batch.size()];
        const auto& sides = joins[n].sides;
        const bool remote = volumes[sides[1].block].rank != volumes[sides[0].block].rank;
        size += controlPoints(volumes[sides[0].block], joins[n]);
        batch.emplace_back(volumes, options, remote ? &fetched[n] : nullptr, joins[n]);
      }
      const Index count = static_cast<Index>(batch.size());
      std::vector<char> finite(batch.size(), 1);
      run.parallelFor(count, 1, [&](Index begin, Index end) {
        for (Index n = begin; n < end; ++n)
        {
          finite[n] = batch[n].prepare() ? 1 : 0;
        }
      });
      std::vector<Index> rows{ 0 };
      for (Index n = 0; n < count; ++n)
      {
        if (!finite[n])
        {
          const auto& sides = joins[own[first + n]].sides;
          throw ErrorAt(static_cast<Index>(own[first + n]),
            "control points at the join of " + options.blockName(sides[0].block) + " face " +
              std::to_string(sides[0].face) + " and " + options.blockName(sides[1].block) + " face " +
              std::to_string(sides[1].face) + " are not finite");
        }
        rows.push_back(rows.back() + batch[n].rows());
      }
      run.parallelFor(rows.back(), 4, [&](Index begin, Index end) {
        Index n = std::upper_bound(rows.begin(), rows.end(), begin) - rows.begin() - 1;
        for (Index row = begin; row < end; ++row)
        {
          n += row == rows[n + 1] ? 1 : 0;
          batch[n].evaluateRow(row - rows[n]);
        }
      });
      run.parallelFor(count, 1, [&](Index begin, Index end) {
        for (Index n = begin; n < end; ++n)
        {
          batch[n].finish();
        }
      });
      first += batch.size();
      done += size;
    }
  });
}

/// Tells all ranks what they need to know of the joins that this one measured.
void shareResults(const std::vector<BSplineVolume>& volumes, std::vector<Join>& joins, const Ranks& ranks)
{
  struct Summary
  {
    std::array<int, 2> spans, samples;
    bool crease;
    std::array<std::array<double, 10>, JumpKinds> worst;
  };
  if (ranks.size() == 1)
  {
    return;
  }
  std::vector<Summary> all(joins.size());
  for (std::size_t n = 0; n < joins.size(); ++n)
  {
    const Join& join = joins[n];
    all[n] = { join.spans, join.samples, join.crease, {} };
    for (int kind = 0; kind < JumpKinds; ++kind)
    {
      double* to = all[n].worst[kind].data();
      *to++ = join.worst[kind].value;
      for (const Vec3& x : { join.worst[kind].point, join.worst[kind].uvw[0], join.worst[kind].uvw[1] })
      {
        to = std::copy_n(x.data(), 3, to);
      }
    }
  }
  ranks.share(all, [&](Index n) { return rankOf(volumes, joins[n]); });
  for (std::size_t n = 0; n < joins.size(); ++n)
  {
    const Summary& summary = all[n];
    Join& join = joins[n];
    join.spans = summary.spans;
    join.samples = summary.samples;
    join.crease = summary.crease;
    for (int kind = 0; kind < JumpKinds; ++kind)
    {
      const double* from = summary.worst[kind].data();
      join.worst[kind].value = from[0];
      join.worst[kind].point = Eigen::Map<const Vec3>(from + 1);
      join.worst[kind].uvw = { Eigen::Map<const Vec3>(from + 4), Eigen::Map<const Vec3>(from + 7) };
    }
  }
}

/// Diagonal of the bounding box of the points of all joins.
double extent(const std::vector<Join>& joins, const Ranks& ranks)
{
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  for (const Join& join : joins)
  {
    for (const Vec3& point : join.points)
    {
      low = low.cwiseMin(point);
      high = high.cwiseMax(point);
    }
  }
  using Box = std::array<double, 6>;
  for (const Box& box : ranks.gatherAll<Box>({ { low[0], low[1], low[2], high[0], high[1], high[2] } }))
  {
    low = low.cwiseMin(Eigen::Map<const Vec3>(box.data()));
    high = high.cwiseMax(Eigen::Map<const Vec3>(box.data() + 3));
  }
  return joins.empty() ? 0.0 : (high - low).norm();
}

} // namespace

const char* continuityName(Continuity continuity)
{
  static constexpr const char* Names[] = { "open", "C0", "G1", "C1", "C2" };
  return Names[static_cast<int>(continuity)];
}

JumpKind Join::rankedBy() const
{
  switch (this->continuity)
  {
    case Continuity::Open:
      return JumpKind::Gap;
    case Continuity::C0:
      return JumpKind::Layer;
    case Continuity::G1:
      return JumpKind::C1;
    default:
      return JumpKind::C2;
  }
}

SmoothnessResult measureSmoothness(const std::vector<BSplineVolume>& volumes, const std::vector<Interface>& interfaces,
  const SmoothnessOptions& options, const Execution& run)
{
  checkOptions(options);
  const SharedEntities shared = sharedEntities(static_cast<int>(volumes.size()), interfaces, options.blockName);
  SmoothnessResult result;
  for (const Interface& contact : interfaces)
  {
    Join join;
    join.sides[0] = { contact.blockA, contact.faceA, -1 };
    join.sides[1] = { contact.blockB, contact.faceB, -1 };
    join.orientation = contact.orientation;
    result.joins.push_back(join);
  }
  std::vector<Join> borders = outerBorders(shared);
  double total = 0.0;
  for (const std::vector<Join>* joins : { &result.joins, &borders })
  {
    for (const Join& join : *joins)
    {
      total += rankOf(volumes, join) == run.ranks->rank() ? controlPoints(volumes[join.sides[0].block], join) : 0.0;
    }
  }

  // The borders first, also those that are not on the wall: creases tell which layers of the interfaces are bound to
  // kink.
  double done = 0.0;
  measureJoins(volumes, options, borders, done, total, run);
  for (Join& join : borders)
  {
    const int block = join.sides[0].block;
    if (volumes[block].rank == run.ranks->rank())
    {
      const unsigned char* rules = options.rules.empty() ? nullptr : options.rules[block];
      join.crease = taggedCrease(join, volumes[block], rules) || isSharp(join, options.creaseAngle);
    }
  }
  shareResults(volumes, borders, *run.ranks);
  std::vector<bool> crease(shared.edges.size(), false);
  for (const Join& join : borders)
  {
    crease[shared.blocks[join.sides[0].block].edges[join.sides[0].edge]] = join.crease;
  }
  for (Join& join : result.joins)
  {
    describeInterface(shared, crease, join);
  }
  measureJoins(volumes, options, result.joins, done, total, run);
  shareResults(volumes, result.joins, *run.ranks);
  std::copy_if(borders.begin(), borders.end(), std::back_inserter(result.joins), [&](const Join& join) {
    return std::all_of(join.sides.begin(), join.sides.end(),
      [&](const Join::Side& side) { return options.isWall(side.block, side.face); });
  });

  const double gapTolerance = options.gapTolerance * extent(result.joins, *run.ranks);
  for (Join& join : result.joins)
  {
    join.continuity = continuityOf(join, gapTolerance, options.tolerance);
  }
  result.curves = extraordinaryCurves(volumes, shared, result.joins, *run.ranks);

  result.ranking.resize(result.joins.size());
  std::iota(result.ranking.begin(), result.ranking.end(), 0);
  std::stable_sort(result.ranking.begin(), result.ranking.end(), [&](int a, int b) {
    const Join& x = result.joins[a];
    const Join& y = result.joins[b];
    const auto severity = [](const Join& join) { return join.worst[int(join.rankedBy())].value; };
    return x.crease != y.crease      ? y.crease
      : x.continuity != y.continuity ? x.continuity < y.continuity
                                     : severity(x) > severity(y);
  });
  result.blocks.resize(volumes.size());
  for (const int j : result.ranking)
  {
    const Join& join = result.joins[j];
    if (join.crease)
    {
      continue;
    }
    for (const Join::Side& side : join.sides)
    {
      BlockSmoothness& block = result.blocks[side.block];
      if (block.worstJoin < 0)
      {
        block.worstJoin = j;
        block.continuity = join.continuity;
      }
      for (int kind = 0; kind < JumpKinds; ++kind)
      {
        block.worst[kind] = std::max(block.worst[kind], join.worst[kind].value);
        result.worst[kind] = std::max(result.worst[kind], join.worst[kind].value);
      }
    }
  }
  return result;
}

FaceSamples sampleFace(const BSplineVolume& volume, int face, int parts)
{
  const Trace trace = makeTrace(volume, face, -1);
  std::array<std::vector<Basis>, 2> stations;
  for (int k = 0; k < 2; ++k)
  {
    const std::vector<int> spans = nonEmptySpans(trace.degree[k], trace.knots[k]);
    for (const int span : spans)
    {
      Cell::Part part;
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
  for (const Basis& t : stations[1])
  {
    for (const Basis& s : stations[0])
    {
      result.points.push_back(evaluateSide(trace, s, t).x);
    }
  }
  return result;
}

} // namespace bsv
