// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/Conversion.h"

#include "Conversion/BodyPropagation.h"
#include "Conversion/DoubleKnots.h"
#include "Conversion/EdgeConversion.h"
#include "Conversion/FaceConversion.h"
#include "Conversion/SpanRepair.h"
#include "Conversion/SurfaceConversion.h"
#include "Conversion/VertexConversion.h"
#include "Mesh/BlockSurface.h"

#include <algorithm>
#include <atomic>
#include <iterator>
#include <set>

namespace bsv
{

namespace
{

/// Nets from this size on, bytes in all, are streamed: more than caches hold.
constexpr Index StreamedBytes = Index(32) << 20;

/// Converts the sides to which a far-field extension is attached, and places the extension's first layer after them.
void placeExtension(const ConversionContext& context, const LocalStars& stars, FirstLayer& layer, const Execution& run)
{
  if (context.options.farFieldSpacing == FarFieldSpacing::Off)
  {
    return;
  }
  // What lies on the cuboid's side of a connection layer does not depend on the extension.
  std::set<int> faces, edges, vertices;
  for (const FarFieldSide& side : context.rules.farField)
  {
    for (std::size_t i = 0; i < side.faces.size(); ++i)
    {
      const ComplexBlock& block = context.complex.blocks[side.inner[i].block];
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
    run.parallelFor(static_cast<Index>(list.size()), 4, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i)
      {
        body(list[i]);
      }
    });
  };
  forEach(
    faces, [&](int face) { return stars.hasFace(face); }, [&](int face) { convertFace(context, face); });
  forEach(
    edges, [&](int edge) { return stars.hasEdge(edge); }, [&](int edge) { convertEdge(context, edge); });
  forEach(
    vertices, [&](int vertex) { return stars.hasVertex(vertex); }, [&](int vertex) { convertVertex(context, vertex); });

  const auto lastDistance = [&](const FaceUse& use, int s, int t, const Vec3& normal) {
    const ComplexBlock& owner = context.complex.blocks[use.block];
    const int st[2] = { s, t };
    Ijk position;
    for (int axis = 0; axis < 2; ++axis)
    {
      const int d = faceAxis(use.face, axis);
      position[d] = st[axis] == 0    ? 0
        : st[axis] == owner.cells(d) ? context.count(use.block, d) - 1
                                     : context.innerPosition(use.block, d, st[axis]);
    }
    const int d = faceDirection(use.face);
    const auto point = [&](int fromEnd) {
      position[d] = context.endPosition(use.block, d, faceSide(use.face), fromEnd);
      return Vec3(Eigen::Map<const Vec3>(context.nets[use.block].points + 3 * context.index(use.block, position)));
    };
    const Vec3 last = point(0);
    return normal.dot(last - point(1));
  };
  for (const FarFieldSide& side : context.rules.farField)
  {
    layer.setSide(side, context.options.farFieldSpacing, lastDistance);
  }
}

RuleCounts countRules(const ConversionContext& context, int block)
{
  RuleCounts counts{};
  Index& copied = counts[static_cast<std::size_t>(ControlPointRule::Copied)];
  const Ijk count{ context.count(block, 0), context.count(block, 1), context.count(block, 2) };
  for (int k = 0; k < count[2]; ++k)
  {
    for (int j = 0; j < count[1]; ++j)
    {
      const std::uint8_t* row = context.nets[block].rules + context.index(block, { 0, j, k });
      const std::array<int, 2> copies = context.copiesInRow(block, j, k);
      copied += copies[1] - copies[0];
      for (int i = 0; i < count[0]; ++i)
      {
        i = i == copies[0] ? copies[1] : i;
        ++counts[row[i]];
      }
    }
  }
  return counts;
}

/// Converts everything. @return the number of singular nodes of this rank.
Index convertAll(const ConversionContext& context, const LocalStars& stars, const Execution& run)
{
  std::atomic<Index> singularNodes{ 0 };
  Index controlPoints = 0;
  // Slabs of all blocks as one list, so that a few large blocks share the threads as well as many small ones.
  std::vector<Index> firstSlab{ 0 };
  for (const ComplexBlock& block : context.complex.blocks)
  {
    const bool here = block.rank == run.ranks->rank();
    controlPoints += here ? Index(block.cells(0) + 3) * (block.cells(1) + 3) * (block.cells(2) + 3) : 0;
    firstSlab.push_back(firstSlab.back() + (here ? std::max(0, block.cells(2) - 1) : 0));
  }
  const bool stream = controlPoints * Index(3 * sizeof(double)) >= StreamedBytes;

  std::vector<bool> atWall(context.complex.vertices.size(), !context.options.wallOnly);
  if (context.options.wallOnly)
  {
    for (const ComplexFace& face : context.complex.faces)
    {
      if (roleOf(context.options, face) == BoundaryRole::Body)
      {
        for (const int vertex : context.complex.blocks[face.uses.front().block].vertices)
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
        touches || atWall[context.complex.blocks[use.block].vertices[faceCorner(use.face, corner & 1, corner >> 1)]];
    }
    return touches;
  };
  const auto forEach = [&](std::size_t count, Index grain, const auto& body) {
    run.parallelFor(static_cast<Index>(count), grain, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i)
      {
        body(static_cast<int>(i));
      }
    });
  };
  // Large meshes are copied in portions, so that progress is told and an abort is heard.
  constexpr Index Portions = 20;
  const Index slabs = context.options.wallOnly ? 0 : firstSlab.back();
  for (Index portion = 0; portion < Portions; ++portion)
  {
    const Index from = slabs * portion / Portions;
    const Index to = slabs * (portion + 1) / Portions;
    run.report(0.5 * portion / Portions);
    run.parallelFor(to - from, 4, [&](Index begin, Index end) {
      for (Index slab = from + begin; slab < from + end; ++slab)
      {
        const auto next = std::upper_bound(firstSlab.begin(), firstSlab.end(), slab);
        const int block = static_cast<int>(next - firstSlab.begin()) - 1;
        convertBlock(context, block, static_cast<int>(slab - firstSlab[block]) + 1, stream);
      }
      endStream();
    });
  }
  run.report(0.5);
  forEach(context.complex.faces.size(), 4, [&](int face) {
    if (stars.hasFace(face) && touchesWall(context.complex.faces[face]))
    {
      convertFace(context, face);
    }
  });
  run.report(0.7);
  forEach(context.complex.edges.size(), 4, [&](int edge) {
    const std::array<int, 2>& ends = context.complex.edges[edge].vertices;
    if (stars.hasEdge(edge) && (atWall[ends[0]] || atWall[ends[1]]))
    {
      convertEdge(context, edge);
    }
  });
  run.report(0.85);
  forEach(context.complex.vertices.size(), 4, [&](int vertex) {
    if (stars.hasVertex(vertex) && atWall[vertex])
    {
      const bool singular = convertVertex(context, vertex);
      singularNodes += singular && context.isHere(context.complex.vertices[vertex].corners.front().block) ? 1 : 0;
    }
  });
  return singularNodes;
}

/// Adds up what the ranks have.
void countAll(const ConversionContext& context, Index singularNodes, const Execution& run, ConversionReport& report)
{
  std::vector<RuleCounts> counts(context.options.wallOnly ? 0 : context.complex.blocks.size());
  run.report(0.95);
  run.parallelFor(static_cast<Index>(counts.size()), 1, [&](Index begin, Index end) {
    for (int block = static_cast<int>(begin); block < end; ++block)
    {
      if (context.isHere(block))
      {
        counts[block] = countRules(context, block);
      }
    }
  });
  run.report(1.0);
  RuleCounts sums{};
  for (const RuleCounts& ofBlock : counts)
  {
    for (std::size_t rule = 0; rule < ofBlock.size(); ++rule)
    {
      sums[rule] += ofBlock[rule];
    }
  }
  for (const RuleCounts& ofRank : run.ranks->gatherAll(std::vector<RuleCounts>{ sums }))
  {
    for (std::size_t rule = 0; rule < ofRank.size(); ++rule)
    {
      report.controlPoints[rule] += ofRank[rule];
    }
  }
  for (const Index nodes : run.ranks->gatherAll(std::vector<Index>{ singularNodes }))
  {
    report.singularNodes += nodes;
  }
}

} // namespace

std::vector<std::array<std::vector<double>, 3>> conversionKnots(
  const BlockComplex& complex, const ConversionOptions& options)
{
  DoubledDirections doubled(complex.blocks.size(), std::array<bool, 3>{ false, false, false });
  if (options.continuity == Continuity::ExactG1)
  {
    doubled = doubleKnotDirections(complex, options);
  }
  std::vector<std::array<std::vector<double>, 3>> knots(complex.blocks.size());
  for (std::size_t b = 0; b < knots.size(); ++b)
  {
    for (int d = 0; d < 3; ++d)
    {
      knots[b][d] = volumeKnots(complex.blocks[b].cells(d), doubled[b][d]);
    }
  }
  return knots;
}

ConversionReport convertToBSplineVolume(const BlockComplex& complex, const ConversionOptions& options,
  const std::vector<ControlNetStorage>& nets, const Execution& run, const EntityRules* known)
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
  if (options.twist == Twist::PCCM && options.continuity != Continuity::ExactG1)
  {
    throw Error("Twist PCCM needs double knots: Continuity must be ExactG1");
  }
  if (options.continuity == Continuity::ExactG1 && options.wallOnly)
  {
    throw Error("the wall alone is converted with single knots only");
  }
  if (nets.size() != complex.blocks.size())
  {
    throw Error("there are " + std::to_string(nets.size()) + " control nets for " +
      std::to_string(complex.blocks.size()) + " blocks");
  }
  const LocalStars stars(complex, *run.ranks);
  const EntityRules own = known ? EntityRules{} : classify(stars, options, run);
  const EntityRules& rules = known ? *known : own;
  const FaceKeeps keeps = creaseColumns(stars.complex(), options.propagationRange, rules, *run.ranks);
  FirstLayer layer(stars.complex(), options, *run.ranks);
  const GivenFeet given = givenFeet(stars.complex(), options, *run.ranks);
  const auto contextWith = [&](const LayerCorrections& corrections) {
    return ConversionContext{ stars.complex(), options, nets, run.ranks->rank(), rules, keeps, layer, given,
      corrections };
  };
  // The layer rule must not see corrections.
  const LayerCorrections none;
  const LayerCorrections corrections = bodyCorrections(contextWith(none), *run.ranks);
  const ConversionContext withSingleKnots = contextWith(corrections);
  ConversionContext context = withSingleKnots;
  const bool exact = options.continuity == Continuity::ExactG1;
  const DoubledDirections doubled = exact ? doubleKnotDirections(stars.complex(), options) : DoubledDirections{};
  context.doubled = exact ? &doubled : nullptr;
  if (!options.wallOnly)
  {
    placeExtension(context, stars, layer, run);
  }
  ConversionReport report;
  Index singularNodes = convertAll(context, stars, run);
  if (exact)
  {
    const auto convert = [&] {
      singularNodes = convertAll(withSingleKnots, stars, run);
      return checkSpans(withSingleKnots, run);
    };
    report.g1 = joinAndCheck(context, convert, report.spans, run);
  }
  else if (!options.wallOnly)
  {
    report.spans = checkSpans(context, run);
  }
  report.planarFaces = rules.planarFaces;
  report.notes = rules.notes;
  layer.describe(report);
  countAll(context, singularNodes, run, report);
  return report;
}

} // namespace bsv
