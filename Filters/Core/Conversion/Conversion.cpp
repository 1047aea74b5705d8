// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/Conversion.h"

#include "Conversion/Converter.h"
#include "Mesh/BlockSurface.h"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <set>

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

void endStream()
{
#ifdef __SSE2__
  _mm_sfence();
#endif
}

/// Nets from this size on, bytes in all, are streamed: more than caches hold.
constexpr Index StreamedBytes = Index(32) << 20;

} // namespace

void Converter::convertBlock(int block, int slab, bool stream)
{
  const ComplexBlock& owner = this->Complex.blocks[block];
  const int ni = owner.cells(0), nj = owner.cells(1);
  for (int j = 1; j < nj && ni > 1; ++j)
  {
    const Index start = this->index(block, { innerPosition(1), innerPosition(j), innerPosition(slab) });
    double* target = this->Nets[block].points + 3 * start;
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
    std::memset(this->Nets[block].rules + start, static_cast<int>(ControlPointRule::Copied), ni - 1);
  }
}

void Converter::convertFace(int face)
{
  const ComplexFace& shared = this->Complex.faces[face];
  const FaceRule& faceRule = this->Rules.faces[face];
  const bool wall = this->isWall(face);

  // Positions in a block's mesh or net as start + s * alongS + t * alongT + depth * inwards, (s, t) on the face's first
  // block.
  struct Plane
  {
    Index start, alongS, alongT, inwards;
    Index operator()(int s, int t, int depth) const
    {
      return this->start + s * this->alongS + t * this->alongT + depth * this->inwards;
    }
  };
  struct Side
  {
    const GridView* points;
    const ControlNetStorage* net;
    bool here;
    FaceUse use;
    Plane mesh, control;

    Vec3 at(int s, int t, int depth) const { return this->points->atOffset(this->mesh(s, t, depth)); }
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
  std::vector<Side> sides;
  int ns = 0, nt = 0;
  for (const FaceUse& use : shared.uses)
  {
    const ComplexBlock& owner = this->Complex.blocks[use.block];
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
      return owner.points.offset(ijk);
    });
    const Plane control = plane([&](int s, int t, int fromEnd) {
      Ijk ijk;
      ijk[axes[0]] = innerPosition(s);
      ijk[axes[1]] = innerPosition(t);
      ijk[normal] = endPosition(faceSide(use.face), fromEnd, cells[normal]);
      return this->index(use.block, ijk);
    });
    sides.push_back({ &owner.points, &this->Nets[use.block], this->isHere(use.block), use, mesh, control });
  }

  const Side& first = sides.front();
  const Side& second = sides.back();
  // The first layer next to the face, into one of its blocks.
  const auto insert = [&](const Side& side, int s, int t, const Vec3& own, const Vec3& above) {
    Ijk at{ 0, 0, 0 };
    if (this->Layer.varies(side.use.block, side.use.face))
    {
      const std::array<int, 2> st =
        &side == &first ? std::array<int, 2>{ s, t } : mapFacePoint(shared.orientation, s, t, ns, nt);
      at[faceAxis(side.use.face, 0)] = st[0];
      at[faceAxis(side.use.face, 1)] = st[1];
    }
    const double near = this->Layer.weight(side.use.block, side.use.face, at);
    const bool regular = near == KnotInsertion && !wall;
    side.write(
      s, t, 1, insertMask(own, above, near), regular ? ControlPointRule::Regular : layerRule(faceRule.connection));
  };
  for (int t = 1; t < nt; ++t)
  {
    for (int s = 1; s < ns; ++s)
    {
      const Vec3 own = first.at(s, t, 0);
      const Vec3 inner = first.at(s, t, 1);
      insert(first, s, t, own, inner);
      if (shared.boundary())
      {
        first.write(s, t, 0, own, this->Rules.boundaryRule(face));
        continue;
      }
      const Vec3 across = second.at(s, t, 1);
      const double keep = faceRule.keep.empty() ? 0.0 : faceRule.keep[s + std::size_t(ns + 1) * t];
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

void Converter::placeExtension()
{
  if (this->Options.farFieldSpacing == FarFieldSpacing::Off)
  {
    return;
  }
  // What lies on the cuboid's side of a connection layer does not depend on the extension.
  std::set<int> faces, edges, vertices;
  for (const FarFieldSide& side : this->Rules.farField)
  {
    for (std::size_t i = 0; i < side.faces.size(); ++i)
    {
      const ComplexBlock& block = this->Complex.blocks[side.inner[i].block];
      const int face = side.inner[i].face;
      faces.insert(side.faces[i]);
      for (int n = 0; n < 4; ++n)
      {
        edges.insert(block.edges[faceEdge(face, n & 1, n >> 1)]);
        vertices.insert(block.vertices[faceCorner(face, n & 1, n >> 1)]);
      }
    }
  }
  const auto forEach = [&](const std::set<int>& set, const auto& isLocal, const auto& body) {
    std::vector<int> list;
    std::copy_if(set.begin(), set.end(), std::back_inserter(list), isLocal);
    this->Run.parallelFor(static_cast<Index>(list.size()), 4, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i)
      {
        body(list[i]);
      }
    });
  };
  this->Run.ranks->together([&] {
    forEach(
      faces, [&](int face) { return this->Stars.hasFace(face); }, [&](int face) { this->convertFace(face); });
    forEach(
      edges, [&](int edge) { return this->Stars.hasEdge(edge); }, [&](int edge) { this->convertEdge(edge); });
    forEach(
      vertices, [&](int vertex) { return this->Stars.hasVertex(vertex); },
      [&](int vertex) { this->convertVertex(vertex); });
  });
  this->SingularNodes = 0;

  const auto lastDistance = [&](const FaceUse& use, int s, int t, const Vec3& normal) {
    const ComplexBlock& owner = this->Complex.blocks[use.block];
    const int st[2] = { s, t };
    Ijk position;
    for (int axis = 0; axis < 2; ++axis)
    {
      const int d = faceAxis(use.face, axis);
      position[d] = st[axis] == 0 ? 0 : st[axis] == owner.cells(d) ? owner.cells(d) + 2 : innerPosition(st[axis]);
    }
    const int d = faceDirection(use.face);
    const auto point = [&](int fromEnd) {
      position[d] = endPosition(faceSide(use.face), fromEnd, owner.cells(d));
      return Vec3(Eigen::Map<const Vec3>(this->Nets[use.block].points + 3 * this->index(use.block, position)));
    };
    const Vec3 last = point(0);
    return normal.dot(last - point(1));
  };
  for (const FarFieldSide& side : this->Rules.farField)
  {
    this->Layer.setSide(side, this->Options.farFieldSpacing, lastDistance);
  }
}

RuleCounts Converter::countRules(int block) const
{
  const ComplexBlock& owner = this->Complex.blocks[block];
  const Ijk cells{ owner.cells(0), owner.cells(1), owner.cells(2) };
  const auto inside = [&](int d, int i) { return i >= innerPosition(1) && i <= innerPosition(cells[d] - 1); };
  RuleCounts counts{};
  // The interior is copied; only what lies around it is looked at.
  Index& copied = counts[static_cast<std::size_t>(ControlPointRule::Copied)];
  copied = Index(cells[0] - 1) * (cells[1] - 1) * (cells[2] - 1);
  for (int k = 0; k < cells[2] + 3; ++k)
  {
    for (int j = 0; j < cells[1] + 3; ++j)
    {
      const std::uint8_t* row = this->Nets[block].rules + this->index(block, { 0, j, k });
      const bool through = inside(2, k) && inside(1, j);
      for (int i = 0; i < cells[0] + 3; ++i)
      {
        if (through && i == innerPosition(1))
        {
          i = std::max(i, innerPosition(cells[0]));
        }
        ++counts[row[i]];
      }
    }
  }
  return counts;
}

ConversionReport Converter::convert()
{
  this->collectGiven();
  this->propagateFeet();
  if (!this->Options.wallOnly)
  {
    this->placeExtension();
  }

  Index controlPoints = 0;
  // Slabs of all blocks as one list, so that a few large blocks share the threads as well as many small ones.
  std::vector<Index> firstSlab{ 0 };
  for (const ComplexBlock& block : this->Complex.blocks)
  {
    const bool here = block.rank == this->Run.ranks->rank();
    controlPoints += here ? Index(block.cells(0) + 3) * (block.cells(1) + 3) * (block.cells(2) + 3) : 0;
    firstSlab.push_back(firstSlab.back() + (here ? std::max(0, block.cells(2) - 1) : 0));
  }
  const bool stream = controlPoints * Index(3 * sizeof(double)) >= StreamedBytes;

  std::vector<bool> atWall(this->Complex.vertices.size(), !this->Options.wallOnly);
  if (this->Options.wallOnly)
  {
    for (const ComplexFace& face : this->Complex.faces)
    {
      if (roleOf(this->Options, face) == BoundaryRole::Body)
      {
        for (const int vertex : this->Complex.blocks[face.uses.front().block].vertices)
        {
          atWall[vertex] = true;
        }
      }
    }
  }
  const auto touchesWall = [&](const ComplexFace& face) {
    const FaceUse& use = face.uses.front();
    bool touches = false;
    for (int corner = 0; corner < 4; ++corner)
    {
      touches =
        touches || atWall[this->Complex.blocks[use.block].vertices[faceCorner(use.face, corner & 1, corner >> 1)]];
    }
    return touches;
  };
  const auto forEach = [&](std::size_t count, Index grain, const auto& body) {
    this->Run.parallelFor(static_cast<Index>(count), grain, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i)
      {
        body(static_cast<int>(i));
      }
    });
  };
  // Large meshes are copied in portions, so that progress is told and an abort is heard.
  constexpr Index Portions = 20;
  const Index slabs = this->Options.wallOnly ? 0 : firstSlab.back();
  for (Index portion = 0; portion < Portions; ++portion)
  {
    this->Run.ranks->together([&] {
      const Index from = slabs * portion / Portions;
      const Index to = slabs * (portion + 1) / Portions;
      this->Run.report(0.5 * portion / Portions);
      this->Run.parallelFor(to - from, 4, [&](Index begin, Index end) {
        for (Index slab = from + begin; slab < from + end; ++slab)
        {
          const auto next = std::upper_bound(firstSlab.begin(), firstSlab.end(), slab);
          const int block = static_cast<int>(next - firstSlab.begin()) - 1;
          this->convertBlock(block, static_cast<int>(slab - firstSlab[block]) + 1, stream);
        }
        endStream();
      });
    });
  }
  this->Run.ranks->together([&] {
    this->Run.report(0.5);
    forEach(this->Complex.faces.size(), 4, [&](int face) {
      if (this->Stars.hasFace(face) && touchesWall(this->Complex.faces[face]))
      {
        this->convertFace(face);
      }
    });
  });
  this->Run.ranks->together([&] {
    this->Run.report(0.7);
    forEach(this->Complex.edges.size(), 4, [&](int edge) {
      const std::array<int, 2>& ends = this->Complex.edges[edge].vertices;
      if (this->Stars.hasEdge(edge) && (atWall[ends[0]] || atWall[ends[1]]))
      {
        this->convertEdge(edge);
      }
    });
  });
  this->Run.ranks->together([&] {
    this->Run.report(0.85);
    forEach(this->Complex.vertices.size(), 4, [&](int vertex) {
      if (this->Stars.hasVertex(vertex) && atWall[vertex])
      {
        this->convertVertex(vertex);
      }
    });
  });

  ConversionReport report;
  report.planarFaces = this->Rules.planarFaces;
  this->Layer.describe(report);
  std::vector<RuleCounts> counts(this->Options.wallOnly ? 0 : this->Complex.blocks.size());
  this->Run.ranks->together([&] {
    this->Run.report(0.95);
    forEach(counts.size(), 1, [&](int block) {
      if (this->isHere(block))
      {
        counts[block] = this->countRules(block);
      }
    });
    this->Run.report(1.0);
  });
  RuleCounts sums{};
  for (const RuleCounts& ofBlock : counts)
  {
    for (std::size_t rule = 0; rule < ofBlock.size(); ++rule)
    {
      sums[rule] += ofBlock[rule];
    }
  }
  for (const RuleCounts& ofRank : this->Run.ranks->gatherAll(std::vector<RuleCounts>{ sums }))
  {
    for (std::size_t rule = 0; rule < ofRank.size(); ++rule)
    {
      report.controlPoints[rule] += ofRank[rule];
    }
  }
  for (const Index nodes : this->Run.ranks->gatherAll(std::vector<Index>{ this->SingularNodes }))
  {
    report.singularNodes += nodes;
  }
  return report;
}

ConversionReport convertToBSplineVolume(const BlockComplex& complex, const ConversionOptions& options,
  const std::vector<ControlNetStorage>& nets, const Execution& run)
{
  run.ranks->together([&] {
    if (!(options.planarTolerance >= 0.0))
    {
      throw Error("Planar Tolerance " + text(options.planarTolerance) + " is not at least 0");
    }
    if (!(options.propagationRange >= 0.0))
    {
      throw Error("Propagation Range " + text(options.propagationRange) + " is not at least 0");
    }
    if (options.twist == Twist::Literal && !options.body)
    {
      throw Error("Twist Literal needs the parameters of a Body, and there is none");
    }
    if (nets.size() != complex.blocks.size())
    {
      throw Error("there are " + std::to_string(nets.size()) + " control nets for " +
        std::to_string(complex.blocks.size()) + " blocks");
    }
  });
  const LocalStars stars(complex, *run.ranks);
  return Converter(stars, options, nets, run).convert();
}

} // namespace bsv
