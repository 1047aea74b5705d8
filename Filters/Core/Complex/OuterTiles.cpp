// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/OuterTiles.h"

#include "Base/CanonicalOrder.h"
#include "Ranks/OwnedValues.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bsv
{

/// Whether two neighbouring corners are one point.
bool collapsed(const OuterCell& cell)
{
  return cell.outer[0] == cell.outer[1] || cell.outer[0] == cell.outer[2] || cell.outer[3] == cell.outer[1] ||
    cell.outer[3] == cell.outer[2];
}

/// The corners and the points up to the near limit on both sides.
Box reach(const OuterCell& cell)
{
  Box box;
  for (int c = 0; c < 4; ++c)
  {
    const Vec3 depth = NearLimit * (cell.behind(c) - cell.corner(c));
    box.extend(Vec3(cell.corner(c) + depth));
    box.extend(Vec3(cell.corner(c) - depth));
  }
  return box;
}

namespace
{

TileShape shapeOf(const OuterSurface& surface, const Tile& tile)
{
  TileShape shape;
  Box box;
  Vec3 sum = Vec3::Zero(), area = Vec3::Zero();
  Vec3 first = Vec3::Constant(std::numeric_limits<double>::infinity());
  std::array<Vec3, TileSize * TileSize> normals;
  int count = 0;
  bool turned = false;
  surface.forCells({ tile.face, tile.s0, tile.t0 }, { tile.face, tile.s1 - 1, tile.t1 - 1 },
    [&](const OuterQuad&, const OuterCell& cell) {
      box.extend(reach(cell));
      const Vec3 a = cell.area();
      const Vec3 center = cell.center();
      shape.flux += a.dot(center);
      area += a;
      normals[count] = a.stableNormalized();
      sum += normals[count];
      // Seen from a cell that a moved point turned over, its surface may look anywhere.
      turned = turned || !(a.dot(cell.frame()[2]) < 0.0);
      ++count;
      first = comesBefore(center, first) ? center : first;
    });
  const Vec3 axis = sum.stableNormalized();
  double least = 1.0;
  for (int n = 0; n < count; ++n)
  {
    least = std::min(least, normals[n].dot(axis));
  }
  shape.lo = triple(box.min());
  shape.hi = triple(box.max());
  shape.axis = triple(axis);
  shape.spread = turned ? Pi : std::acos(std::max(-1.0, least));
  shape.first = triple(first);
  shape.area = triple(area);
  return shape;
}

} // namespace

OuterTiles::OuterTiles(const OuterSurface& surface, const Execution& run)
{
  for (const int face : surface.faces())
  {
    this->FirstTile.push_back(static_cast<Index>(this->Tiles.size()));
    const int ns = surface.cells(face, 0), nt = surface.cells(face, 1);
    for (int t = 0; t < nt; t += TileSize)
    {
      for (int s = 0; s < ns; s += TileSize)
      {
        this->Tiles.push_back({ face, s, t, std::min(s + TileSize, ns), std::min(t + TileSize, nt) });
      }
    }
  }
  this->FirstTile.push_back(static_cast<Index>(this->Tiles.size()));
  const Index count = static_cast<Index>(this->Tiles.size());
  this->Shapes.resize(count);
  run.parallelFor(count, 64, [&](Index begin, Index end) {
    for (Index n = begin; n < end; ++n)
    {
      if (surface.rankOf(this->Tiles[n].face) == run.ranks->rank())
      {
        this->Shapes[n] = shapeOf(surface, this->Tiles[n]);
      }
    }
  });
  run.ranks->share(this->Shapes, [&](Index n) { return surface.rankOf(this->Tiles[n].face); });
}

} // namespace bsv
