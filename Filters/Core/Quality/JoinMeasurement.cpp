// SPDX-License-Identifier: BSD-3-Clause
#include "Quality/JoinMeasurement.h"

#include "Mesh/BlockTopology.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bsv
{

namespace
{

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

} // namespace

int withinFace(const Join& join, int side)
{
  return join.border() ? join.sides[side].face : -1;
}

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

bool JoinMeasurement::prepare()
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

void JoinMeasurement::evaluateRow(Index row)
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

void JoinMeasurement::finish()
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

void JoinMeasurement::chooseFrame(const std::array<Trace, 2>& traces)
{
  std::array<FramedTrace, 2> best;
  for (int way = 0; way < 16; ++way)
  {
    TraceFrame frame;
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

void JoinMeasurement::findCells(int k)
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
    JoinSpan cell;
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
      JoinSpan::Part& part = cell.parts[side];
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

JoinMeasurement::Station JoinMeasurement::station(int k, int cell, double x, double rest) const
{
  Station result;
  for (int side = 0; side < 2; ++side)
  {
    result[side] = basisAt(this->Traces[side], k, this->Cells[k][cell].parts[side], x, rest);
  }
  return result;
}

void JoinMeasurement::placeStations(int k)
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

std::size_t JoinMeasurement::inA(const std::array<int, 2>& counts, int i, int j) const
{
  const TraceFrame& frame = this->frameOfA();
  std::array<int, 2> place{ i, j };
  for (int k = 0; k < 2; ++k)
  {
    place[k] = frame.flip[k] ? counts[frame.axis[k]] - 1 - place[k] : place[k];
  }
  return frame.axis[0] == 0 ? place[0] + std::size_t(counts[0]) * place[1]
                            : place[1] + std::size_t(counts[0]) * place[0];
}

int JoinMeasurement::kindInA(int kind) const
{
  const int first = static_cast<int>(JumpKind::NormalS);
  const int second = static_cast<int>(JumpKind::NormalT);
  const bool swapped = this->frameOfA().axis[0] == 1;
  return swapped && (kind == first || kind == second) ? first + second - kind : kind;
}

Jumps JoinMeasurement::evaluate(const Station& s, const Station& t, Vec3* point) const
{
  const SideValues a = evaluateSide(this->Traces[0], s[0], t[0]);
  const SideValues b = evaluateSide(this->Traces[1], s[1], t[1]);
  if (point)
  {
    *point = 0.5 * (a.x + b.x);
  }
  return jumpsOf(a, b, this->Length, this->BoundToKink);
}

JoinMeasurement::Best JoinMeasurement::bestSample(
  const std::vector<double>& values, const std::array<int, 2>& cell) const
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

void JoinMeasurement::takeLayerMaximum()
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

void JoinMeasurement::findMaximum(int kind)
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

bool JoinMeasurement::worthClimbing(int kind, double value) const
{
  constexpr double Gap = 64.0 * JumpRounding;
  constexpr double Part = 1e-3;
  switch (static_cast<JumpKind>(kind))
  {
    case JumpKind::Gap:
      return value > Gap * std::max(this->Traces[0].size, this->Traces[1].size);
    case JumpKind::C1:
    case JumpKind::C2:
      return value > Part * this->Options.tolerance;
    default:
      return value > Part * this->Options.tolerance * DegreesPerRadian;
  }
}

Vec3 JoinMeasurement::parameters(int side, const Best& best) const
{
  const int k = this->Exchange ? 1 - side : side;
  const BSplineVolume& v = this->volume(k);
  const int face = acrossFace(this->Result, k);
  const int within = withinFace(this->Result, k);
  std::array<int, 2> axes{ faceAxis(face, 0), faceAxis(face, 1) };
  Vec3 uvw;
  uvw[faceDirection(face)] = faceParameter(v, face);
  if (within >= 0)
  {
    axes[0] = axes[0] == faceDirection(within) ? axes[1] : axes[0];
    uvw[faceDirection(within)] = faceParameter(v, within);
  }
  const TraceFrame& frame = this->Frames[side];
  for (int n = 0; n < 2; ++n)
  {
    if (within >= 0 && frame.axis[n] == 1)
    {
      continue;
    }
    const JoinSpan::Part& part = this->Cells[n][best.cell[n]].parts[side];
    const double u = part.start + (n == 0 ? best.x : best.y) * part.width;
    const int d = axes[frame.axis[n]];
    // No negative zero.
    uvw[d] = std::min(std::max(frame.flip[n] ? 0.0 - u : u, v.knots[d][v.degree[d]]), v.knots[d][v.count(d)]);
  }
  return uvw;
}

} // namespace bsv
