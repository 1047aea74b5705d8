// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/HexFrames.h"

#include <algorithm>
#include <cmath>

namespace bsv
{

const HexFrames& HexFrames::instance()
{
  static const HexFrames frames;
  return frames;
}

HexFrames::HexFrames()
{
  for (int n = 0; n < Count; ++n)
  {
    Frame& frame = this->Frames[n];
    const int first = n / 16;
    frame.axis = { first, first == 0 ? 1 : 0, first == 2 ? 1 : 2 };
    if (n / 8 % 2 == 1)
    {
      std::swap(frame.axis[1], frame.axis[2]);
    }
    for (int d = 0; d < 3; ++d)
    {
      frame.sign[d] = n >> d & 1 ? -1 : 1;
    }
    for (int corner = 0; corner < 8; ++corner)
    {
      int inGrid = 0;
      for (int d = 0; d < 3; ++d)
      {
        inGrid |= (frame.sign[d] > 0 ? cornerSide(corner, d) : 1 - cornerSide(corner, d)) << frame.axis[d];
      }
      this->CellCorner[n][inGrid] = static_cast<std::uint8_t>(corner);
    }
    for (int face = 0; face < 6; ++face)
    {
      const int d = faceDirection(face);
      const int inGrid = 2 * frame.axis[d] + (frame.sign[d] > 0 ? faceSide(face) : 1 - faceSide(face));
      this->CellFace[n][inGrid] = static_cast<std::uint8_t>(face);
      this->GridFace[n][face] = static_cast<std::uint8_t>(inGrid);
    }
  }
  for (int n = 0; n < Count; ++n)
  {
    for (int m = 0; m < Count; ++m)
    {
      // Frame m takes the directions of one cell to those of the other.
      Frame result;
      for (int d = 0; d < 3; ++d)
      {
        result.axis[this->Frames[m].axis[d]] = this->Frames[n].axis[d];
        result.sign[this->Frames[m].axis[d]] = this->Frames[n].sign[d] * this->Frames[m].sign[d];
      }
      this->Across[n][m] = static_cast<std::uint8_t>(this->number(result));
    }
  }

  for (int edge = 0; edge < 12; ++edge)
  {
    std::fill_n(this->OtherFace[edge], 6, None);
    const int along = edgeDirection(edge);
    for (int side = 0; side < 2; ++side)
    {
      this->EdgeFace[edge][side] = static_cast<std::uint8_t>(2 * faceAxis(2 * along, side) + edgeSide(edge, side));
    }
    this->OtherFace[edge][this->EdgeFace[edge][0]] = this->EdgeFace[edge][1];
    this->OtherFace[edge][this->EdgeFace[edge][1]] = this->EdgeFace[edge][0];
    this->CornerEdge[edgeCorner(edge, 0)][along] = static_cast<std::uint8_t>(edge);
    this->CornerEdge[edgeCorner(edge, 1)][along] = static_cast<std::uint8_t>(edge);
  }

  for (int face = 0; face < 6; ++face)
  {
    for (int other = 0; other < 6; ++other)
    {
      for (int orientation = 0; orientation < 8; ++orientation)
      {
        Frame meeting;
        const std::array<int, 3> transform = cgnsTransform(face, other, orientation);
        for (int d = 0; d < 3; ++d)
        {
          meeting.axis[d] = std::abs(transform[d]) - 1;
          meeting.sign[d] = transform[d] > 0 ? 1 : -1;
        }
        this->Meeting[face][other][orientation] = static_cast<std::uint8_t>(this->number(meeting));

        std::uint8_t* corners = this->CornerAcross[face][other][orientation];
        std::fill_n(corners, 8, None);
        for (int c = 0; c < 4; ++c)
        {
          const std::array<int, 2> st = mapFacePoint(orientation, c & 1, c >> 1, 1, 1);
          corners[faceCorner(face, c & 1, c >> 1)] = static_cast<std::uint8_t>(faceCorner(other, st[0], st[1]));
        }
        for (int edge = 0; edge < 12; ++edge)
        {
          const int a = corners[edgeCorner(edge, 0)];
          const int b = corners[edgeCorner(edge, 1)];
          const int direction = a == None || b == None ? 0 : (a ^ b) == 1 ? 0 : (a ^ b) == 2 ? 1 : 2;
          this->EdgeAcross[face][other][orientation][edge] =
            a == None || b == None ? None : this->CornerEdge[a][direction];
        }
      }
    }
  }
}

} // namespace bsv
