// SPDX-License-Identifier: BSD-3-Clause
/// @file OuterTiles.h
/// The outer surface of a complex in tiles of a few quadrilaterals: what all ranks know of all of it.
#pragma once

#include "Base/BoxTree.h"
#include "Base/Numbers.h"
#include "Complex/OuterSurface.h"
#include "Ranks/Ranks.h"

#include <array>
#include <vector>

namespace bsv
{

/// How near is a near miss, as a fraction of the cells: more than half a cell, or half cells would slip through.
constexpr double NearLimit = 0.6;
/// Quadrilaterals per direction of a tile.
constexpr int TileSize = 8;

/// Whether two neighbouring corners are one point.
bool collapsed(const OuterCell& cell);
/// The corners and the points up to the near limit on both sides.
Box reach(const OuterCell& cell);

/// A rectangle of quadrilaterals of a face, [s0, s1) x [t0, t1).
struct Tile
{
  int face;
  int s0, t0, s1, t1;
};

/// What all ranks know of a tile.
struct TileShape
{
  Triple lo{ 0, 0, 0 }, hi{ 0, 0, 0 };
  /// Cone of the normals: its axis and half its angle, radians.
  Triple axis{ 0, 0, 0 };
  double spread = 0.0;
  /// Lexicographically first center.
  Triple first{ 0, 0, 0 };
  /// Sums of area . center, and of area.
  double flux = 0.0;
  Triple area{ 0, 0, 0 };

  Box box() const { return Box(vec3(this->lo), vec3(this->hi)); }
};

class OuterTiles
{
public:
  /// Collective. @param surface must outlive it.
  OuterTiles(const OuterSurface& surface, const Execution& run);

  Index size() const { return static_cast<Index>(this->Tiles.size()); }
  const Tile& tile(Index n) const { return this->Tiles[n]; }
  const TileShape& shape(Index n) const { return this->Shapes[n]; }
  /// The first tile of the n-th of OuterSurface::faces(), or one past the last tile.
  Index firstOf(Index n) const { return this->FirstTile[n]; }

private:
  std::vector<Tile> Tiles;
  /// Per boundary face, in their order.
  std::vector<Index> FirstTile;
  std::vector<TileShape> Shapes;
};

/// valueOf(quadrilateral) of all in an ascending list, computed by the ranks that have their points. Collective.
template <typename T, typename ValueOf>
std::vector<T> ofQuads(
  const OuterSurface& surface, const Ranks& ranks, const std::vector<Index>& quads, const ValueOf& valueOf)
{
  std::vector<T> result(quads.size());
  std::vector<std::vector<Index>> questions(ranks.size());
  std::vector<int> rankOf(quads.size());
  for (std::size_t n = 0; n < quads.size(); ++n)
  {
    const OuterQuad at = surface.quadAt(quads[n]);
    rankOf[n] = surface.rankOf(at.face);
    if (rankOf[n] == ranks.rank())
    {
      result[n] = valueOf(at);
    }
    else
    {
      questions[rankOf[n]].push_back(quads[n]);
    }
  }
  if (ranks.size() > 1)
  {
    const std::vector<std::vector<T>> answers =
      ranks.ask(questions, [&](Index quad) -> T { return valueOf(surface.quadAt(quad)); });
    std::vector<std::size_t> next(answers.size(), 0);
    for (std::size_t n = 0; n < quads.size(); ++n)
    {
      if (rankOf[n] != ranks.rank())
      {
        result[n] = answers[rankOf[n]][next[rankOf[n]]++];
      }
    }
  }
  return result;
}

} // namespace bsv
