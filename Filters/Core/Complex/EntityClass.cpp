// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/EntityClass.h"

#include "Base/UnionFind.h"

#include <algorithm>
#include <set>
#include <utility>

namespace bsv
{

namespace
{

/// Directions (block, corner) of the octants around one end of an edge.
std::set<std::pair<int, int>> cornersAt(const ComplexEdge& edge, int end)
{
  std::set<std::pair<int, int>> corners;
  for (const EdgeUse& use : edge.uses)
  {
    corners.emplace(use.block, edgeCorner(use.edge, use.reversed ? 1 - end : end));
  }
  return corners;
}

struct EdgeEnd
{
  int edge;
  int end;
};

/// Whether exactly one curve of extraordinary edges runs through the vertex at which these edges end.
bool runsThrough(const BlockComplex& complex, const std::vector<EdgeEnd>& ends)
{
  if (ends.size() != 2)
  {
    return false;
  }
  // Edges that leave in opposite directions share no octant.
  const auto first = cornersAt(complex.edges[ends[0].edge], ends[0].end);
  const auto second = cornersAt(complex.edges[ends[1].edge], ends[1].end);
  return std::none_of(first.begin(), first.end(), [&](const auto& corner) { return second.count(corner) > 0; });
}

/// What is known of the outer boundary around a vertex.
struct BoundaryStar
{
  int faces = 0;
  int creases = 0;
  std::set<int> tags;
};

std::vector<BoundaryStar> boundaryStars(const BlockComplex& complex)
{
  std::vector<BoundaryStar> stars(complex.vertices.size());
  for (const ComplexFace& face : complex.faces)
  {
    if (face.boundary())
    {
      const FaceUse& use = face.uses.front();
      for (int corner = 0; corner < 4; ++corner)
      {
        BoundaryStar& star = stars[complex.blocks[use.block].vertices[faceCorner(use.face, corner & 1, corner >> 1)]];
        ++star.faces;
        star.tags.insert(face.tag);
      }
    }
  }
  for (const ComplexEdge& edge : complex.edges)
  {
    if (edge.crease)
    {
      ++stars[edge.vertices[0]].creases;
      ++stars[edge.vertices[1]].creases;
    }
  }
  return stars;
}

} // namespace

const std::vector<std::string>& entityClassNames()
{
  static const std::vector<std::string> names{ "Regular", "Boundary", "Extraordinary", "Singular", "Crease", "Corner" };
  return names;
}

EntityClasses classifyEntities(const BlockComplex& complex)
{
  EntityClasses classes;

  for (const ComplexFace& face : complex.faces)
  {
    classes.faces.push_back(face.boundary() ? EntityClass::Boundary : EntityClass::Regular);
  }

  std::vector<std::vector<EdgeEnd>> ends(complex.vertices.size());
  for (std::size_t e = 0; e < complex.edges.size(); ++e)
  {
    const ComplexEdge& edge = complex.edges[e];
    EntityClass what = EntityClass::Regular;
    if (edge.extraordinary())
    {
      what = EntityClass::Extraordinary;
      ++classes.extraordinaryEdges;
      for (int end = 0; end < 2; ++end)
      {
        ends[edge.vertices[end]].push_back({ static_cast<int>(e), end });
      }
    }
    else if (edge.boundary)
    {
      what = edge.crease ? EntityClass::Crease : EntityClass::Boundary;
    }
    classes.edges.push_back(what);
  }

  UnionFind curves(static_cast<Index>(complex.edges.size()));
  const std::vector<BoundaryStar> stars = boundaryStars(complex);
  for (std::size_t v = 0; v < complex.vertices.size(); ++v)
  {
    EntityClass what = EntityClass::Regular;
    if (complex.vertices[v].boundary)
    {
      const BoundaryStar& star = stars[v];
      const bool smooth = star.tags.size() == 1;
      what = star.creases > 2       ? EntityClass::Corner
        : star.creases > 0          ? EntityClass::Crease
        : smooth && star.faces != 4 ? EntityClass::Extraordinary
                                    : EntityClass::Boundary;
    }
    else if (!ends[v].empty())
    {
      if (runsThrough(complex, ends[v]))
      {
        what = EntityClass::Extraordinary;
        curves.unite(ends[v][0].edge, ends[v][1].edge);
      }
      else
      {
        what = EntityClass::Singular;
        ++classes.singularNodes;
      }
    }
    classes.vertices.push_back(what);
  }

  for (Index e = 0; e < static_cast<Index>(complex.edges.size()); ++e)
  {
    if (complex.edges[e].extraordinary() && curves.find(e) == e)
    {
      ++classes.extraordinaryCurves[complex.edges[e].valence()];
    }
  }
  return classes;
}

} // namespace bsv
