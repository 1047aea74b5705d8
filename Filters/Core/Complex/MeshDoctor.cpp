// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/MeshDoctor.h"

#include "Base/CanonicalOrder.h"
#include "Base/UnionFind.h"
#include "Complex/FacesInCells.h"
#include "Complex/NearPairs.h"
#include "Complex/OuterTiles.h"
#include "Mesh/BlockSurface.h"

#include <algorithm>
#include <cstdio>
#include <map>

namespace bsv
{
namespace
{

/// Closed parts of the outer surface around a hole.
void findInnerBoundaries(const OuterSurface& surface, const OuterTiles& tiles, MeshFindings& findings)
{
  const std::vector<int>& faces = surface.faces();
  const Index count = static_cast<Index>(faces.size());
  std::vector<Index> slot(surface.complex().faces.size(), -1);
  for (Index n = 0; n < count; ++n)
  {
    slot[faces[n]] = n;
  }
  UnionFind parts(count);
  Box all;
  for (Index n = 0; n < count; ++n)
  {
    forOuterEdges({ faces[n], 0, 0 }, [&](OuterEdge edge) {
      const int last = surface.cells(faces[n], 1 - edge.axis) - 1;
      (edge.axis == 0 ? edge.quad.t : edge.quad.s) = edge.side ? last : 0;
      parts.unite(n, slot[surface.across(edge).quad.face]);
    });
    for (Index tile = tiles.firstOf(n); tile < tiles.firstOf(n + 1); ++tile)
    {
      all.extend(tiles.shape(tile).box());
    }
  }
  struct Part
  {
    double volume = 0.0;
    MeshFinding finding;
  };
  std::vector<Part> sums(count);
  for (Index n = 0; n < count; ++n)
  {
    Part& part = sums[parts.find(n)];
    for (Index tile = tiles.firstOf(n); tile < tiles.firstOf(n + 1); ++tile)
    {
      const TileShape& shape = tiles.shape(tile);
      part.volume += shape.flux - all.center().dot(vec3(shape.area));
      if (surface.unnamed(faces[n]))
      {
        const Vec3 place = vec3(shape.first);
        MeshFinding& finding = part.finding;
        if (finding.quads == 0 || comesBefore(place, finding.place))
        {
          finding.place = place;
          finding.blocks[0] = findings.parent(faces[n]);
          finding.faces[0] = surface.use(faces[n]).face;
        }
        const Tile& rectangle = tiles.tile(tile);
        finding.quads += Index(rectangle.s1 - rectangle.s0) * (rectangle.t1 - rectangle.t0);
      }
    }
  }
  std::vector<int> numbers(count, -1);
  for (Index n = 0; n < count; ++n)
  {
    // Outwards is into the hole. What is closed has no volume only by rounding.
    const double size = all.sizes().prod();
    if (parts.find(n) == n && sums[n].finding.quads > 0 && sums[n].volume < -1e-12 * size)
    {
      sums[n].finding.kind = MeshFindingKind::InnerBoundary;
      numbers[n] = findings.add(sums[n].finding);
    }
  }
  for (Index n = 0; n < count; ++n)
  {
    const int number = numbers[parts.find(n)];
    for (Index quad = surface.firstQuad(faces[n]);
         number >= 0 && surface.unnamed(faces[n]) && quad < surface.firstQuad(faces[n] + 1); ++quad)
    {
      findings.mark(quad, number);
    }
  }
}

void findComponents(const BlockComplex& complex, MeshFindings& findings)
{
  const int count = static_cast<int>(complex.blocks.size());
  UnionFind parts(count);
  for (const ComplexFace& face : complex.faces)
  {
    parts.unite(face.uses.front().block, face.uses.back().block);
  }
  std::map<Index, std::vector<int>> parents;
  for (int b = 0; b < count; ++b)
  {
    parents[parts.find(b)].push_back(complex.blocks[b].parent);
  }
  findings.setComponents(static_cast<int>(parents.size()));
  for (auto& [part, blocks] : parents)
  {
    std::sort(blocks.begin(), blocks.end());
    blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
    MeshFinding finding;
    finding.kind = MeshFindingKind::Component;
    finding.blocks[0] = blocks.front();
    finding.quads = static_cast<Index>(blocks.size());
    if (parents.size() > 1)
    {
      findings.add(finding);
    }
  }
}

std::string figure(double value)
{
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.3g", value);
  return buffer;
}

} // namespace

MeshDiagnosis diagnose(const BlockComplex& complex, const Execution& run)
{
  const OuterSurface surface(complex);
  MeshFindings findings(surface);
  const OuterTiles tiles(surface, run);
  run.report(0.4);
  const std::vector<NearPair> pairs = findNearPairs(surface, tiles, run);
  run.report(0.6);
  judgeNearPairs(surface, pairs, *run.ranks, findings);
  run.report(0.7);
  findFacesInCells(surface, tiles, run, findings);
  run.report(0.9);
  findInnerBoundaries(surface, tiles, findings);
  findComponents(complex, findings);
  run.report(1.0);
  return findings.sorted();
}

std::string describe(const BlockMesh& mesh, const MeshFinding& finding)
{
  const auto side = [&](int n) {
    return finding.blocks[n] < 0
      ? std::string("other cells")
      : blockLabel(mesh, finding.blocks[n]) + (finding.faces[n] < 0 ? "" : " " + faceLabel(finding.faces[n]));
  };
  const std::string quads =
    std::to_string(finding.quads) + (finding.quads == 1 ? " outer quadrilateral" : " outer quadrilaterals");
  const std::string place = " near " + text(finding.place);
  const std::string apart =
    "up to " + figure(finding.distance) + " apart (" + figure(finding.fraction) + " of the cells there)";
  std::string result;
  switch (finding.kind)
  {
    case MeshFindingKind::NearMiss:
      result = side(0) + " and " + side(1) + " nearly face each other, " + apart + place + ": " + quads;
      break;
    case MeshFindingKind::LoosePoint:
      result = side(0) + " and " + side(1) + " would meet but for one point, " + apart + place + ": " + quads;
      break;
    case MeshFindingKind::Overlap:
      result = side(0) + " lies in " + side(1) + place + ": " + quads;
      break;
    case MeshFindingKind::NarrowGap:
      return "walls come close to each other at " + side(0) + " and " + side(1) + ", " + apart + place + ": " + quads;
    case MeshFindingKind::InnerBoundary:
      return "inner boundary without a name at " + side(0) + place + ": " + quads;
    case MeshFindingKind::Component:
      return std::to_string(finding.quads) + (finding.quads == 1 ? " block" : " blocks") + " from " + side(0) +
        " on share no face with the others";
    default:
      return {};
  }
  if (finding.kind != MeshFindingKind::Overlap)
  {
    result += finding.glueTolerance > 0.0 && finding.glueTolerance < 0.5
      ? "; a Match Tolerance above " + figure(finding.glueTolerance) + " would glue them"
      : "; no Match Tolerance would glue them";
  }
  return result;
}

void refuseSuspicious(const BlockMesh& mesh, const MeshDiagnosis& diagnosis)
{
  Index count = 0;
  for (const MeshFinding& finding : diagnosis.findings)
  {
    count += finding.suspicious() ? 1 : 0;
  }
  if (count > 0)
  {
    throw Error("blocks do not meet where they seem to be meant to, at " + std::to_string(count) +
      (count == 1 ? " place: " : " places, the first: ") + describe(mesh, diagnosis.findings.front()) +
      ". Correct the mesh, name these faces as boundaries, or switch on Allow Open Interior");
  }
}

} // namespace bsv
