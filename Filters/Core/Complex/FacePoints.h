// SPDX-License-Identifier: BSD-3-Clause
/// @file FacePoints.h
/// The mesh points of a block face.
#pragma once

#include "Complex/BlockComplex.h"

namespace bsv
{

/// Calls body(point) for every mesh point of a block's face, s fastest.
template <typename Body>
void forFacePoints(const BlockComplex& complex, const FaceUse& use, const Body& body)
{
  const ComplexBlock& block = complex.blocks[use.block];
  const Ijk cells{ block.cells(0), block.cells(1), block.cells(2) };
  const Index start = block.points.place(facePoint(cells, use.face, 0, 0));
  const Index alongS = block.points.place(facePoint(cells, use.face, 1, 0)) - start;
  const Index alongT = block.points.place(facePoint(cells, use.face, 0, 1)) - start;
  for (int t = 0; t <= cells[faceAxis(use.face, 1)]; ++t)
  {
    for (int s = 0; s <= cells[faceAxis(use.face, 0)]; ++s)
    {
      body(block.points.atPlace(start + s * alongS + t * alongT));
    }
  }
}

} // namespace bsv
