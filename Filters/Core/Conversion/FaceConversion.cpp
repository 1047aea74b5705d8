// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/FaceConversion.h"

#include "Base/RowLoop.h"

#include <algorithm>
#include <array>
#include <cstring>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace bsv
{

namespace
{

/// Copies doubles past the caches, which a large net does not fit into: an ordinary copy would first read what it
/// overwrites. Ends with endStream().
template <typename Real>
void streamCopy(double* to, const Real* from, Index count)
{
  Index i = 0;
#ifdef __SSE2__
  for (; i < count && reinterpret_cast<std::uintptr_t>(to + i) % 64 != 0; ++i)
  {
    to[i] = from[i];
  }
  for (; i + 8 <= count; i += 8)
  {
    for (int pair = 0; pair < 8; pair += 2)
    {
      _mm_stream_pd(to + i + pair, _mm_set_pd(from[i + pair + 1], from[i + pair]));
    }
  }
#endif
  for (; i < count; ++i)
  {
    to[i] = from[i];
  }
}

/// (a + 4 p + b) / 6 and, towards both sides, (2 p + a) / 3: smoothMask() and insertMask() for a row of numbers.
BSV_ROW_LOOP void regularRow(const double* a, const double* p, const double* b, Index count, double* __restrict middle,
  double* __restrict towardsA, double* __restrict towardsB)
{
  for (Index i = 0; i < count; ++i)
  {
    middle[i] = ((a[i] + b[i]) + 4.0 * p[i]) / 6.0;
    towardsA[i] = (2.0 * p[i] + a[i]) / 3.0;
    towardsB[i] = (2.0 * p[i] + b[i]) / 3.0;
  }
}

} // namespace

void endStream()
{
#ifdef __SSE2__
  _mm_sfence();
#endif
}

void convertBlock(const ConversionContext& context, int block, int slab, bool stream)
{
  const ComplexBlock& owner = context.complex.blocks[block];
  const int ni = owner.cells(0), nj = owner.cells(1);
  for (int j = 1; j < nj && ni > 1; ++j)
  {
    const Index start = context.index(block,
      { context.innerPosition(block, 0, 1), context.innerPosition(block, 1, j),
        context.innerPosition(block, 2, slab) });
    double* target = context.nets[block].points + 3 * start;
    owner.points.forRuns(1, ni - 1, j, slab, [&](const auto* source, Index count) {
      if (stream)
      {
        streamCopy(target, source, count);
      }
      else
      {
        std::copy_n(source, count, target);
      }
      target += count;
    });
    std::memset(context.nets[block].rules + start, static_cast<int>(ControlPointRule::Copied), ni - 1);
  }
}

void convertFace(const ConversionContext& context, int face)
{
  const FaceUse& use = context.complex.faces[face].uses.front();
  const ComplexBlock& owner = context.complex.blocks[use.block];
  convertFacePoints(
    context, face, { 1, 1 }, { owner.cells(faceAxis(use.face, 0)), owner.cells(faceAxis(use.face, 1)) });
}

namespace
{

/// Positions in a block's mesh or net as start + s * alongS + t * alongT + depth * inwards, (s, t) on the face's first
/// block.
struct Plane
{
  Index start, alongS, alongT, inwards;
  Index operator()(int s, int t, int depth) const
  {
    return this->start + s * this->alongS + t * this->alongT + depth * this->inwards;
  }
};

/// A block at the face.
struct Side
{
  const GridView* points;
  const ControlNetStorage* net;
  bool here;
  FaceUse use;
  Plane mesh, control;

  const MovedPoints* moved;
  /// Of (s, t), from the face's first block.
  int orientation;
  std::array<int, 2> ends;

  /// (s, t) in the axes of this block's face.
  std::array<int, 2> own(int s, int t) const
  {
    return mapFacePoint(this->orientation, s, t, this->ends[0], this->ends[1]);
  }
  Vec3 at(int s, int t, int depth) const
  {
    Vec3 x = this->points->atPlace(this->mesh(s, t, depth));
    if (!this->moved)
    {
      return x;
    }
    const std::array<int, 2> st = this->own(s, t);
    const ComplexBlock& owner = this->moved->complex.blocks[this->use.block];
    Ijk ijk = facePoint({ owner.cells(0), owner.cells(1), owner.cells(2) }, this->use.face, st[0], st[1]);
    ijk[faceDirection(this->use.face)] += faceSide(this->use.face) ? -depth : depth;
    return this->moved->at(this->use.block, ijk, x);
  }
  void write(int s, int t, int fromEnd, const Vec3& point, ControlPointRule rule) const
  {
    if (!this->here)
    {
      return;
    }
    const Index i = this->control(s, t, fromEnd);
    std::copy_n(point.data(), 3, this->net->points + 3 * i);
    this->net->rules[i] = static_cast<std::uint8_t>(rule);
  }
};

std::vector<Side> sidesOf(const ConversionContext& context, int face)
{
  const ComplexFace& shared = context.complex.faces[face];
  std::vector<Side> sides;
  int ns = 0, nt = 0;
  for (const FaceUse& use : shared.uses)
  {
    const ComplexBlock& owner = context.complex.blocks[use.block];
    const Ijk cells{ owner.cells(0), owner.cells(1), owner.cells(2) };
    const int axes[2] = { faceAxis(use.face, 0), faceAxis(use.face, 1) };
    const int normal = faceDirection(use.face);
    int orientation = 0;
    if (sides.empty())
    {
      ns = cells[axes[0]];
      nt = cells[axes[1]];
    }
    else
    {
      orientation = shared.orientation;
    }
    const auto plane = [&](const auto& offset) {
      const auto at = [&](int s, int t, int depth) {
        const std::array<int, 2> st = mapFacePoint(orientation, s, t, ns, nt);
        return offset(st[0], st[1], depth);
      };
      const Index start = at(0, 0, 0);
      return Plane{ start, at(1, 0, 0) - start, at(0, 1, 0) - start, at(0, 0, 1) - start };
    };
    const Plane mesh = plane([&](int s, int t, int depth) {
      Ijk ijk;
      ijk[axes[0]] = s;
      ijk[axes[1]] = t;
      ijk[normal] = faceSide(use.face) ? cells[normal] - depth : depth;
      return owner.points.place(ijk);
    });
    const Plane control = plane([&](int s, int t, int fromEnd) {
      Ijk ijk;
      ijk[axes[0]] = context.innerPosition(use.block, axes[0], s);
      ijk[axes[1]] = context.innerPosition(use.block, axes[1], t);
      ijk[normal] = context.endPosition(use.block, normal, faceSide(use.face), fromEnd);
      return context.index(use.block, ijk);
    });
    sides.push_back({ &owner.points, &context.nets[use.block], context.isHere(use.block), use, mesh, control,
      context.moved, orientation, { ns, nt } });
  }
  return sides;
}

/// Points of a face between two blocks without any special rule, rows of them at once.
void convertRegularPoints(
  const Side& first, const Side& second, const std::array<int, 2>& begin, const std::array<int, 2>& end)
{
  constexpr int Most = 64;
  using Row = std::array<Vec3, Most>;
  Row own, inner, across, middle, towardsFirst, towardsSecond;
  for (int t = begin[1]; t < end[1]; ++t)
  {
    for (int s = begin[0]; s < end[0]; s += Most)
    {
      const int count = std::min(Most, end[0] - s);
      const auto read = [&](const Side& side, int depth, Row& row) {
        for (int i = 0; i < count; ++i)
        {
          row[i] = side.points->atPlace(side.mesh(s + i, t, depth));
        }
      };
      const auto write = [&](const Side& side, int fromEnd, const Row& row) {
        for (int i = 0; i < count; ++i)
        {
          side.write(s + i, t, fromEnd, row[i], ControlPointRule::Regular);
        }
      };
      read(first, 0, own);
      read(first, 1, inner);
      read(second, 1, across);
      regularRow(inner[0].data(), own[0].data(), across[0].data(), Index(3) * count, middle[0].data(),
        towardsFirst[0].data(), towardsSecond[0].data());
      write(first, 1, towardsFirst);
      write(first, 0, middle);
      write(second, 0, middle);
      write(second, 1, towardsSecond);
    }
  }
}

} // namespace

void convertFacePoints(
  const ConversionContext& context, int face, const std::array<int, 2>& begin, const std::array<int, 2>& end)
{
  const ComplexFace& shared = context.complex.faces[face];
  const FaceRule& faceRule = context.rules.faces[face];
  const std::vector<double>& keeps = context.keeps[face];
  const bool wall = context.isWall(face);
  const std::vector<Side> sides = sidesOf(context, face);
  const Side& first = sides.front();
  const Side& second = sides.back();
  // The first layer next to the face, into one of its blocks.
  const auto insert = [&](const Side& side, int s, int t, const Vec3& own, const Vec3& above) {
    Ijk at{ 0, 0, 0 };
    if (context.layer.varies(side.use.block, side.use.face))
    {
      const std::array<int, 2> st = side.own(s, t);
      at[faceAxis(side.use.face, 0)] = st[0];
      at[faceAxis(side.use.face, 1)] = st[1];
    }
    const double near = context.layer.weight(side.use.block, side.use.face, at);
    const bool regular = near == KnotInsertion && !wall;
    side.write(
      s, t, 1, insertMask(own, above, near), regular ? ControlPointRule::Regular : layerRule(faceRule.connection));
  };
  const bool regular = !context.moved && !shared.boundary() && !faceRule.planar() && keeps.empty() &&
    context.layer.isKnotInsertion(first.use.block, first.use.face) &&
    context.layer.isKnotInsertion(second.use.block, second.use.face);
  if (regular)
  {
    convertRegularPoints(first, second, begin, end);
    return;
  }
  for (int t = begin[1]; t < end[1]; ++t)
  {
    for (int s = begin[0]; s < end[0]; ++s)
    {
      const Vec3 own = first.at(s, t, 0);
      const Vec3 inner = first.at(s, t, 1);
      insert(first, s, t, own, inner);
      if (shared.boundary())
      {
        first.write(s, t, 0, own, context.rules.boundaryRule(face));
        continue;
      }
      const Vec3 across = second.at(s, t, 1);
      const double keep = keeps.empty() ? 0.0 : keeps[s + std::size_t(first.ends[0] + 1) * t];
      const Vec3 middle = faceRule.planar() ? own : fadedMask(inner, own, across, keep);
      const ControlPointRule rule = faceRule.planar() ? ControlPointRule::PlanarSide
        : keep > 0.0                                  ? ControlPointRule::Crease
                                                      : ControlPointRule::Regular;
      first.write(s, t, 0, middle, rule);
      second.write(s, t, 0, middle, rule);
      insert(second, s, t, own, across);
    }
  }
}

} // namespace bsv
