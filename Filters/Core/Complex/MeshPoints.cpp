// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/MeshPoints.h"

#include "Complex/SurfacePointKey.h"

#include <algorithm>

namespace bsv
{

MeshPointKey meshPointKey(const BlockComplex& complex, int block, const Ijk& ijk)
{
  const ComplexBlock& owner = complex.blocks[block];
  for (int d = 0; d < 3; ++d)
  {
    if (ijk[d] == 0 || ijk[d] == owner.cells(d))
    {
      const int face = 2 * d + (ijk[d] == 0 ? 0 : 1);
      const SurfacePointKey key =
        surfacePointKey(complex, { block, face }, ijk[faceAxis(face, 0)], ijk[faceAxis(face, 1)]);
      return { key[0], key[1], key[2], key[3], 0 };
    }
  }
  return { 3, block, ijk[0], ijk[1], ijk[2] };
}

std::vector<MeshPointCopy> copiesOf(const BlockComplex& complex, const MeshPointKey& key)
{
  std::vector<MeshPointCopy> copies;
  switch (key[0])
  {
    case 0:
      for (const CornerUse& use : complex.vertices[key[1]].corners)
      {
        const ComplexBlock& block = complex.blocks[use.block];
        Ijk ijk;
        for (int d = 0; d < 3; ++d)
        {
          ijk[d] = cornerSide(use.corner, d) ? block.cells(d) : 0;
        }
        copies.push_back({ use.block, ijk });
      }
      break;
    case 1: {
      const ComplexEdge& edge = complex.edges[key[1]];
      for (const EdgeUse& use : edge.uses)
      {
        const ComplexBlock& block = complex.blocks[use.block];
        const int along = edgeDirection(use.edge);
        Ijk ijk;
        ijk[along] = use.reversed ? edge.cells - key[2] : key[2];
        for (int axis = 0; axis < 2; ++axis)
        {
          const int d = faceAxis(2 * along, axis);
          ijk[d] = edgeSide(use.edge, axis) ? block.cells(d) : 0;
        }
        copies.push_back({ use.block, ijk });
      }
      break;
    }
    case 2: {
      const ComplexFace& face = complex.faces[key[1]];
      std::array<int, 2> st{ key[2], key[3] };
      for (const FaceUse& use : face.uses)
      {
        const ComplexBlock& block = complex.blocks[use.block];
        if (!copies.empty())
        {
          const FaceUse& first = face.uses.front();
          const ComplexBlock& firstBlock = complex.blocks[first.block];
          st = mapFacePoint(face.orientation, key[2], key[3], firstBlock.cells(faceAxis(first.face, 0)),
            firstBlock.cells(faceAxis(first.face, 1)));
        }
        const Ijk cells{ block.cells(0), block.cells(1), block.cells(2) };
        copies.push_back({ use.block, facePoint(cells, use.face, st[0], st[1]) });
      }
      break;
    }
    default:
      copies.push_back({ key[1], { key[2], key[3], key[4] } });
  }
  return copies;
}

std::vector<MeshPointKey> neighboursOf(const BlockComplex& complex, const MeshPointKey& key)
{
  std::vector<MeshPointKey> keys;
  for (const MeshPointCopy& copy : copiesOf(complex, key))
  {
    const ComplexBlock& block = complex.blocks[copy.block];
    Ijk low, high;
    for (int d = 0; d < 3; ++d)
    {
      low[d] = std::max(0, copy.ijk[d] - 1);
      high[d] = std::min(block.cells(d), copy.ijk[d] + 1);
    }
    for (int k = low[2]; k <= high[2]; ++k)
    {
      for (int j = low[1]; j <= high[1]; ++j)
      {
        for (int i = low[0]; i <= high[0]; ++i)
        {
          keys.push_back(meshPointKey(complex, copy.block, { i, j, k }));
        }
      }
    }
  }
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  return keys;
}

} // namespace bsv
