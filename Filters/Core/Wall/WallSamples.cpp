// SPDX-License-Identifier: BSD-3-Clause
#include "Wall/WallSamples.h"

#include "Base/CanonicalOrder.h"
#include "Complex/EdgeFans.h"
#include "Volume/BSplineVolume.h"

#include <algorithm>
#include <cmath>

namespace bsv
{
namespace
{

constexpr int PerSpan = WallSamples::PerSpan;

/// Place of sample q in its span.
double samplePlace(int q)
{
  return (q + 0.5) / PerSpan;
}

/// Clamped integer knots: the four B-splines at sample q of a span, of control points span .. span + 3.
std::array<double, 4> clampedBasis(int cells, int span, int q)
{
  const double u = span + samplePlace(q);
  const auto knot = [cells](int i) { return static_cast<double>(std::min(std::max(i - 3, 0), cells)); };
  double left[4], right[4];
  for (int j = 1; j <= 3; ++j)
  {
    left[j] = u - knot(span + 4 - j);
    right[j] = knot(span + 3 + j) - u;
  }
  std::array<double, 4> values{};
  basisFunctions(3, 0, left, right, values.data());
  return values;
}

} // namespace

WallSamples::WallSamples(
  const BlockComplex& complex, const LimitRows& rows, const Wall& wall, const std::vector<Vec3>& given)
  : Rows(rows)
  , Free(wall.size(), false)
{
  for (const int f : wall.faces())
  {
    const FaceUse& use = complex.faces[f].uses.front();
    const ComplexBlock& owner = complex.blocks[use.block];
    const int cells[2] = { owner.cells(faceAxis(use.face, 0)), owner.cells(faceAxis(use.face, 1)) };
    // From the smallest corner on, first along the side with the smaller end. Corners of a face that meets itself are
    // in one place: then all points decide.
    struct Frame
    {
      int corner;
      bool swap;
    };
    const auto id = [&](const Frame& frame, int s, int t) {
      const int u = frame.swap ? t : s, v = frame.swap ? s : t;
      return wall.id(use.block, use.face, frame.corner & 1 ? cells[0] - u : u, frame.corner & 2 ? cells[1] - v : v);
    };
    const auto length = [&](const Frame& frame, int axis) { return cells[frame.swap ? 1 - axis : axis]; };
    const auto isBefore = [&](const Frame& a, const Frame& b) {
      const auto point = [&](const Frame& frame, int s, int t) { return given[id(frame, s, t)]; };
      for (int end = 0; end < 2; ++end)
      {
        const Vec3 x = point(a, end * length(a, 0), 0), y = point(b, end * length(b, 0), 0);
        if (x != y)
        {
          return comesBefore(x, y);
        }
      }
      for (int n = 0; n < (cells[0] + 1) * (cells[1] + 1); ++n)
      {
        const int na = length(a, 0) + 1, nb = length(b, 0) + 1;
        const Vec3 x = point(a, n % na, n / na), y = point(b, n % nb, n / nb);
        if (x != y)
        {
          return comesBefore(x, y);
        }
      }
      return false;
    };
    Frame frame{ 0, false };
    for (int n = 1; n < 8; ++n)
    {
      const Frame other{ n % 4, n >= 4 };
      frame = isBefore(other, frame) ? other : frame;
    }
    Face face;
    face.ns = length(frame, 0);
    face.nt = length(frame, 1);
    for (int d = 0; d < 2; ++d)
    {
      const int count = d == 0 ? face.ns : face.nt;
      face.basis[d].resize(count);
      for (int span = 0; span < count; ++span)
      {
        for (int q = 0; q < PerSpan; ++q)
        {
          face.basis[d][span][q] = clampedBasis(count, span, q);
        }
      }
    }
    for (int t = 0; t <= face.nt; ++t)
    {
      for (int s = 0; s <= face.ns; ++s)
      {
        face.ids.push_back(id(frame, s, t));
      }
    }
    this->Faces.push_back(std::move(face));
  }
  const auto key = [&](const Face& face, int n) {
    return given[face.ids[n == 0 ? 0 : n == 1 ? 1 : n == 2 ? face.ns + 1 : static_cast<int>(face.ids.size()) - 1]];
  };
  std::sort(this->Faces.begin(), this->Faces.end(), [&](const Face& a, const Face& b) {
    for (int n = 0; n < 4; ++n)
    {
      if (key(a, n) != key(b, n))
      {
        return comesBefore(key(a, n), key(b, n));
      }
    }
    return false;
  });
  std::vector<int> spans(wall.size(), 0);
  for (Face& face : this->Faces)
  {
    for (int t = 0; t < face.nt; ++t)
    {
      for (int s = 0; s < face.ns; ++s)
      {
        bool near = false;
        for (int c = 0; c < 4; ++c)
        {
          const int cs = c & 1 ? face.ns : 0, ct = c & 2 ? face.nt : 0;
          const int ds = c & 1 ? face.ns - 1 - s : s, dt = c & 2 ? face.nt - 1 - t : t;
          near = near || (ds < 2 && dt < 2 && !rows.ring(face.id(cs, ct)).empty());
        }
        face.first.push_back(near ? -1 : this->Count);
        this->Count += near ? 0 : PerSpan * PerSpan;
        for (int c = 0; c < 4 && !near; ++c)
        {
          ++spans[face.id(s + (c & 1), t + (c >> 1))];
        }
      }
    }
  }
  this->FirstOnCurves = this->Count;
  std::vector<bool> onCurve(wall.size(), false);
  for (Face& face : this->Faces)
  {
    for (int side = 0; side < 4; ++side)
    {
      const int cells = face.sideCells(side);
      if (cells < 2 || !rows.isCurve(face.sideId(side, 1)))
      {
        continue;
      }
      face.curves[side] = this->Count;
      this->Count += cells * PerSpan;
      for (int k = 0; k <= cells; ++k)
      {
        const Index id = face.sideId(side, k);
        onCurve[id] = rows.isCurve(id);
      }
    }
  }
  for (Index i = 0; i < wall.size(); ++i)
  {
    this->Free[i] = onCurve[i] || (!rows.onFeature(i) && spans[i] > 0);
  }
  for (Index i = 0; i < wall.size(); ++i)
  {
    for (const Index next : rows.ring(i))
    {
      this->Free[next] = false;
    }
  }
  std::vector<bool> seen(wall.size(), false);
  for (const Face& face : this->Faces)
  {
    for (const Index id : face.ids)
    {
      if (!seen[id])
      {
        this->Ordered.push_back(id);
      }
      seen[id] = true;
    }
  }
}

std::vector<Vec3> WallSamples::controlNet(const Face& face, const std::vector<Vec3>& x) const
{
  const int ns = face.ns, nt = face.nt;
  std::vector<Vec3> net(std::size_t(ns + 3) * (nt + 3));
  const auto put = [&](int s, int t) -> Vec3& { return net[s + std::size_t(ns + 3) * t]; };
  for (int t = 1; t < nt; ++t)
  {
    for (int s = 1; s < ns; ++s)
    {
      put(s + 1, t + 1) = x[face.id(s, t)];
    }
  }
  const auto insert = [](const Vec3& end, const Vec3& next) { return Vec3((2.0 * end + next) / 3.0); };
  // Along the sides: the mask across them, and the first point inside.
  for (int side = 0; side < 4; ++side)
  {
    const bool alongS = side < 2;
    const int n = alongS ? ns : nt, m = alongS ? nt : ns, across = side % 2 ? m : 0, inner = side % 2 ? m - 1 : 1;
    for (int k = 1; k < n; ++k)
    {
      const Index id = alongS ? face.id(k, across) : face.id(across, k);
      const Vec3 end = this->Rows.across(id, x);
      const Vec3& next = x[alongS ? face.id(k, inner) : face.id(inner, k)];
      const int last = side % 2 ? m + 2 : 0, second = side % 2 ? m + 1 : 1;
      (alongS ? put(k + 1, last) : put(last, k + 1)) = end;
      (alongS ? put(k + 1, second) : put(second, k + 1)) = insert(x[id], next);
    }
  }
  for (int c = 0; c < 4; ++c)
  {
    const int cs = c & 1 ? ns : 0, ct = c & 2 ? nt : 0, ds = c & 1 ? -1 : 1, dt = c & 2 ? -1 : 1;
    const int ps = c & 1 ? ns + 2 : 0, pt = c & 2 ? nt + 2 : 0;
    const Index v = face.id(cs, ct), alongS = face.id(cs + ds, ct), alongT = face.id(cs, ct + dt);
    put(ps, pt) = this->Rows.apply(v, x);
    put(ps + ds, pt) = insert(this->Rows.acrossSpoke(v, alongS, x), this->Rows.across(alongS, x));
    put(ps, pt + dt) = insert(this->Rows.acrossSpoke(v, alongT, x), this->Rows.across(alongT, x));
    put(ps + ds, pt + dt) = ((4.0 * x[v] + 2.0 * (x[alongS] + x[alongT])) + x[face.id(cs + ds, ct + dt)]) / 9.0;
  }
  return net;
}

template <typename Add>
void WallSamples::controlNetTransposed(const Face& face, const std::vector<Vec3>& net, const Add& add) const
{
  const int ns = face.ns, nt = face.nt;
  const auto at = [&](int s, int t) -> const Vec3& { return net[s + std::size_t(ns + 3) * t]; };
  for (int t = 1; t < nt; ++t)
  {
    for (int s = 1; s < ns; ++s)
    {
      add(face.id(s, t), at(s + 1, t + 1));
    }
  }
  const auto weighted = [&](const Vec3& value) {
    return [&add, value](Index point, double weight) { add(point, weight * value); };
  };
  for (int side = 0; side < 4; ++side)
  {
    const bool alongS = side < 2;
    const int n = alongS ? ns : nt, m = alongS ? nt : ns, across = side % 2 ? m : 0, inner = side % 2 ? m - 1 : 1;
    const int last = side % 2 ? m + 2 : 0, second = side % 2 ? m + 1 : 1;
    for (int k = 1; k < n; ++k)
    {
      const Index id = alongS ? face.id(k, across) : face.id(across, k);
      this->Rows.forWeightsAcross(id, weighted(alongS ? at(k + 1, last) : at(last, k + 1)));
      const Vec3& inserted = alongS ? at(k + 1, second) : at(second, k + 1);
      add(id, 2.0 / 3.0 * inserted);
      add(alongS ? face.id(k, inner) : face.id(inner, k), inserted / 3.0);
    }
  }
  for (int c = 0; c < 4; ++c)
  {
    const int cs = c & 1 ? ns : 0, ct = c & 2 ? nt : 0, ds = c & 1 ? -1 : 1, dt = c & 2 ? -1 : 1;
    const int ps = c & 1 ? ns + 2 : 0, pt = c & 2 ? nt + 2 : 0;
    const Index v = face.id(cs, ct), alongS = face.id(cs + ds, ct), alongT = face.id(cs, ct + dt);
    this->Rows.forWeights(v, weighted(at(ps, pt)));
    this->Rows.forWeightsAcrossSpoke(v, alongS, weighted(2.0 / 3.0 * at(ps + ds, pt)));
    this->Rows.forWeightsAcross(alongS, weighted(at(ps + ds, pt) / 3.0));
    this->Rows.forWeightsAcrossSpoke(v, alongT, weighted(2.0 / 3.0 * at(ps, pt + dt)));
    this->Rows.forWeightsAcross(alongT, weighted(at(ps, pt + dt) / 3.0));
    const Vec3 inner = at(ps + ds, pt + dt) / 9.0;
    add(v, 4.0 * inner);
    add(alongS, 2.0 * inner);
    add(alongT, 2.0 * inner);
    add(face.id(cs + ds, ct + dt), inner);
  }
}

void WallSamples::sample(const Face& face, const std::vector<Vec3>& net, std::vector<Vec3>& samples)
{
  // Along s on every row of control points, then along t.
  const std::size_t columns = std::size_t(PerSpan) * face.ns;
  std::vector<Vec3> rows(columns * (face.nt + 3));
  for (int t = 0; t < face.nt + 3; ++t)
  {
    for (std::size_t c = 0; c < columns; ++c)
    {
      const Vec3* x = &net[c / PerSpan + std::size_t(face.ns + 3) * t];
      const std::array<double, 4>& n = face.basis[0][c / PerSpan][c % PerSpan];
      rows[c + columns * t] = n[0] * x[0] + n[1] * x[1] + n[2] * x[2] + n[3] * x[3];
    }
  }
  for (int t = 0; t < face.nt; ++t)
  {
    for (std::size_t c = 0; c < columns; ++c)
    {
      const Index first = face.first[c / PerSpan + std::size_t(face.ns) * t];
      const Vec3* x = &rows[c + columns * t];
      for (int q = 0; q < PerSpan && first >= 0; ++q)
      {
        const std::array<double, 4>& n = face.basis[1][t][q];
        samples[first + static_cast<Index>(c % PerSpan) + PerSpan * q] =
          n[0] * x[0] + n[1] * x[columns] + n[2] * x[2 * columns] + n[3] * x[3 * columns];
      }
    }
  }
}

std::vector<Vec3> WallSamples::sampleTransposed(const Face& face, const std::vector<Vec3>& values)
{
  const std::size_t columns = std::size_t(PerSpan) * face.ns;
  std::vector<Vec3> rows(columns * (face.nt + 3), Vec3::Zero());
  for (int t = 0; t < face.nt; ++t)
  {
    for (std::size_t c = 0; c < columns; ++c)
    {
      const Index first = face.first[c / PerSpan + std::size_t(face.ns) * t];
      for (int q = 0; q < PerSpan && first >= 0; ++q)
      {
        const Vec3& value = values[first + static_cast<Index>(c % PerSpan) + PerSpan * q];
        for (int b = 0; b < 4; ++b)
        {
          rows[c + columns * (t + b)] += face.basis[1][t][q][b] * value;
        }
      }
    }
  }
  std::vector<Vec3> net(std::size_t(face.ns + 3) * (face.nt + 3), Vec3::Zero());
  for (int t = 0; t < face.nt + 3; ++t)
  {
    for (std::size_t c = 0; c < columns; ++c)
    {
      for (int a = 0; a < 4; ++a)
      {
        net[c / PerSpan + a + std::size_t(face.ns + 3) * t] +=
          face.basis[0][c / PerSpan][c % PerSpan][a] * rows[c + columns * t];
      }
    }
  }
  return net;
}

template <typename Visit>
void WallSamples::forCurveSamples(const Face& face, const Visit& visit)
{
  for (int side = 0; side < 4; ++side)
  {
    for (int i = 0; i < PerSpan * face.sideCells(side) && face.curves[side] >= 0; ++i)
    {
      const int span = i / PerSpan;
      for (int a = 0; a < 4; ++a)
      {
        const int s = side < 2 ? span + a : side == 2 ? 0 : face.ns + 2;
        const int t = side >= 2 ? span + a : side == 0 ? 0 : face.nt + 2;
        visit(
          face.curves[side] + i, s + std::size_t(face.ns + 3) * t, face.basis[side < 2 ? 0 : 1][span][i % PerSpan][a]);
      }
    }
  }
}

std::vector<Vec3> WallSamples::evaluate(const std::vector<Vec3>& x, const Execution& run) const
{
  std::vector<Vec3> samples(this->Count, Vec3::Zero());
  run.parallelFor(static_cast<Index>(this->Faces.size()), 1, [&](Index begin, Index end) {
    for (Index f = begin; f < end; ++f)
    {
      const Face& face = this->Faces[f];
      const std::vector<Vec3> net = this->controlNet(face, x);
      sample(face, net, samples);
      forCurveSamples(
        face, [&](Index sample, std::size_t place, double weight) { samples[sample] += weight * net[place]; });
    }
  });
  return samples;
}

std::vector<Vec3> WallSamples::transposed(const std::vector<Vec3>& values, const Execution& run) const
{
  // Each face by itself, then the faces in their order.
  std::vector<std::vector<std::pair<Index, Vec3>>> parts(this->Faces.size());
  run.parallelFor(static_cast<Index>(this->Faces.size()), 1, [&](Index begin, Index end) {
    for (Index f = begin; f < end; ++f)
    {
      const Face& face = this->Faces[f];
      std::vector<Vec3> net = sampleTransposed(face, values);
      forCurveSamples(
        face, [&](Index sample, std::size_t place, double weight) { net[place] += weight * values[sample]; });
      this->controlNetTransposed(
        face, net, [&](Index point, const Vec3& value) { parts[f].emplace_back(point, value); });
    }
  });
  std::vector<Vec3> sums(this->Ordered.size(), Vec3::Zero());
  for (const auto& part : parts)
  {
    for (const auto& [point, value] : part)
    {
      sums[point] += value;
    }
  }
  return sums;
}

} // namespace bsv
