// SPDX-License-Identifier: BSD-3-Clause
/// @file SurfacePointKey.h
/// The mesh points of block faces as points of the complex: two surfaces in one place, such as the sides of a baffle,
/// have different ones.
#pragma once

#include "Complex/EdgeFans.h"
#include "Mesh/BlockSurface.h"

#include <array>
#include <cstddef>

namespace bsv
{

/// A vertex of the complex (0, vertex, 0, 0), a point of an edge (1, edge, steps from its first vertex, 0) or of a face
/// (2, face, s, t of its first block's face). The same on all ranks.
using SurfacePointKey = std::array<int, 4>;

/// The key of mesh point (s, t) of a block's face.
inline SurfacePointKey surfacePointKey(const BlockComplex& complex, const FaceUse& use, int s, int t)
{
  const ComplexBlock& block = complex.blocks[use.block];
  const int ns = block.cells(faceAxis(use.face, 0));
  const int nt = block.cells(faceAxis(use.face, 1));
  const bool endS = s == 0 || s == ns;
  const bool endT = t == 0 || t == nt;
  if (endS && endT)
  {
    return { 0, block.vertices[faceCorner(use.face, s == 0 ? 0 : 1, t == 0 ? 0 : 1)], 0, 0 };
  }
  if (endS || endT)
  {
    const int edge = faceEdge(use.face, endS ? 1 : 0, endS ? (s == 0 ? 0 : 1) : (t == 0 ? 0 : 1));
    const int along = endS ? t : s;
    return { 1, block.edges[edge], block.edgeReversed[edge] ? (endS ? nt : ns) - along : along, 0 };
  }
  const ComplexFace& face = complex.faces[block.faces[use.face]];
  if (face.uses.front().block == use.block && face.uses.front().face == use.face)
  {
    return { 2, block.faces[use.face], s, t };
  }
  const auto st = mapFacePoint(contactOf(complex, use.block, use.face).orientation, s, t, ns, nt);
  return { 2, block.faces[use.face], st[0], st[1] };
}

/// The one of `ranks` that all others tell what they know of a point.
inline std::size_t keeperOf(const SurfacePointKey& key, int ranks)
{
  std::size_t hash = 0;
  for (const int x : key)
  {
    hash = 31 * hash + static_cast<std::size_t>(x);
  }
  return hash % static_cast<std::size_t>(ranks);
}

} // namespace bsv
