// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion.h"

#include "BlockSurface.h"
#include "Converter.h"

#include <algorithm>
#include <cstring>
#include <set>

namespace bsv
{

void Converter::convertBlock(int block, int slab)
{
  const ComplexBlock& owner = this->Complex.blocks[block];
  const int ni = owner.cells(0), nj = owner.cells(1);
  for (int j = 1; j < nj; ++j)
  {
    if (ni < 2)
    {
      return;
    }
    const Index start = this->index(block, { innerPosition(1), innerPosition(j), innerPosition(slab) });
    double* target = this->Nets[block].points + 3 * start;
    const GridView& points = owner.points;
    if (!points.isFloat() && points.stride(0) == 1)
    {
      std::memcpy(target, points.address<double>(1, j, slab), 3 * sizeof(double) * (ni - 1));
    }
    else
    {
      for (int i = 1; i < ni; ++i)
      {
        const Vec3 point = points(i, j, slab);
        std::copy_n(point.data(), 3, target + 3 * (i - 1));
      }
    }
    std::memset(
      this->Nets[block].rules + start, static_cast<int>(ControlPointRule::Copied), static_cast<std::size_t>(ni - 1));
  }
}

void Converter::convertFace(int face)
{
  const ComplexFace& shared = this->Complex.faces[face];
  const FaceRule& faceRule = this->Rules.faces[face];

  struct Side
  {
    const ComplexBlock* owner;
    int block;
    int face;
    Ijk cells;
    int normal, first, second;

    Ijk mesh(int s, int t, int depth) const
    {
      Ijk ijk;
      ijk[this->first] = s;
      ijk[this->second] = t;
      ijk[this->normal] = faceSide(this->face) ? this->cells[this->normal] - depth : depth;
      return ijk;
    }
    Ijk net(int s, int t, int fromEnd) const
    {
      Ijk ijk;
      ijk[this->first] = innerPosition(s);
      ijk[this->second] = innerPosition(t);
      ijk[this->normal] = endPosition(faceSide(this->face), fromEnd, this->cells[this->normal]);
      return ijk;
    }
  };
  std::vector<Side> sides;
  for (const FaceUse& use : shared.uses)
  {
    const ComplexBlock& owner = this->Complex.blocks[use.block];
    sides.push_back({ &owner, use.block, use.face, { owner.cells(0), owner.cells(1), owner.cells(2) },
      faceDirection(use.face), faceAxis(use.face, 0), faceAxis(use.face, 1) });
  }

  const int ns = sides[0].cells[sides[0].first];
  const int nt = sides[0].cells[sides[0].second];
  for (int t = 1; t < nt; ++t)
  {
    for (int s = 1; s < ns; ++s)
    {
      const Vec3 own = sides[0].owner->points(sides[0].mesh(s, t, 0));
      const Vec3 inner = sides[0].owner->points(sides[0].mesh(s, t, 1));
      const auto insert = [&](const Side& side, const std::array<int, 2>& st, const Vec3& above) {
        const double near = this->Layer.weight(side.block, side.face, side.mesh(st[0], st[1], 0));
        const bool regular = near == KnotInsertion && !this->isWall(face);
        const ControlPointRule rule = regular ? ControlPointRule::Regular : layerRule(faceRule.connection);
        this->write(side.block, side.net(st[0], st[1], 1), insertMask(own, above, near), rule);
      };
      insert(sides[0], { s, t }, inner);
      if (shared.boundary())
      {
        this->write(sides[0].block, sides[0].net(s, t, 0), own, this->Rules.boundaryRule(face));
        continue;
      }
      const std::array<int, 2> st = mapFacePoint(shared.orientation, s, t, ns, nt);
      const Vec3 across = sides[1].owner->points(sides[1].mesh(st[0], st[1], 1));
      const double keep = faceRule.keep.empty() ? 0.0 : faceRule.keep[s + std::size_t(ns + 1) * t];
      const Vec3 middle = faceRule.planar() ? own : fadedMask(inner, own, across, keep);
      const ControlPointRule rule = faceRule.planar() ? ControlPointRule::PlanarSide
        : keep > 0.0                                  ? ControlPointRule::Crease
                                                      : ControlPointRule::Regular;
      this->write(sides[0].block, sides[0].net(s, t, 0), middle, rule);
      this->write(sides[1].block, sides[1].net(st[0], st[1], 0), middle, rule);
      insert(sides[1], st, across);
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
  const auto forEach = [&](const std::set<int>& set, const auto& body) {
    const std::vector<int> list(set.begin(), set.end());
    this->Run.parallelFor(static_cast<Index>(list.size()), 4, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i)
      {
        body(list[i]);
      }
    });
  };
  forEach(faces, [&](int face) { this->convertFace(face); });
  forEach(edges, [&](int edge) { this->convertEdge(edge); });
  forEach(vertices, [&](int vertex) { this->convertVertex(vertex); });
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

ConversionReport Converter::convert()
{
  this->propagateFeet();
  if (!this->Options.wallOnly)
  {
    this->placeExtension();
  }

  // Slabs of all blocks as one list, so that a few large blocks share the threads as well as many small ones.
  std::vector<Index> firstSlab{ 0 };
  for (const ComplexBlock& block : this->Complex.blocks)
  {
    firstSlab.push_back(firstSlab.back() + std::max(0, block.cells(2) - 1));
  }
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
    const Index from = slabs * portion / Portions;
    const Index to = slabs * (portion + 1) / Portions;
    this->Run.report(0.5 * portion / Portions);
    this->Run.parallelFor(to - from, 4, [&](Index begin, Index end) {
      for (Index slab = from + begin; slab < from + end; ++slab)
      {
        const auto next = std::upper_bound(firstSlab.begin(), firstSlab.end(), slab);
        const int block = static_cast<int>(next - firstSlab.begin()) - 1;
        this->convertBlock(block, static_cast<int>(slab - firstSlab[block]) + 1);
      }
    });
  }
  this->Run.report(0.5);
  forEach(this->Complex.faces.size(), 4, [&](int face) {
    if (touchesWall(this->Complex.faces[face]))
    {
      this->convertFace(face);
    }
  });
  this->Run.report(0.7);
  forEach(this->Complex.edges.size(), 4, [&](int edge) {
    const std::array<int, 2>& ends = this->Complex.edges[edge].vertices;
    if (atWall[ends[0]] || atWall[ends[1]])
    {
      this->convertEdge(edge);
    }
  });
  this->Run.report(0.85);
  forEach(this->Complex.vertices.size(), 4, [&](int vertex) {
    if (atWall[vertex])
    {
      this->convertVertex(vertex);
    }
  });
  this->Run.report(0.95);

  ConversionReport report;
  report.singularNodes = this->SingularNodes;
  report.planarFaces = this->Rules.planarFaces;
  this->Layer.describe(report);
  for (std::size_t b = 0; b < this->Complex.blocks.size() && !this->Options.wallOnly; ++b)
  {
    const ComplexBlock& block = this->Complex.blocks[b];
    const Index count = Index(block.cells(0) + 3) * (block.cells(1) + 3) * (block.cells(2) + 3);
    for (Index i = 0; i < count; ++i)
    {
      ++report.controlPoints[this->Nets[b].rules[i]];
    }
  }
  this->Run.report(1.0);
  return report;
}

const std::vector<std::string>& controlPointRuleNames()
{
  static const std::vector<std::string> names{ "Copied", "Regular", "Boundary", "Symmetry", "PlanarSide", "Body",
    "BodyExtraordinaryVertex", "Crease", "Corner", "ExtraordinaryEdge", "SingularNode", "WallLayer", "FarFieldLayer" };
  return names;
}

ConversionReport convertToBSplineVolume(const BlockComplex& complex, const ConversionOptions& options,
  const std::vector<ControlNetStorage>& nets, const Execution& run)
{
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
  return Converter(complex, options, nets, run).convert();
}

} // namespace bsv
