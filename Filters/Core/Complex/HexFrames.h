// SPDX-License-Identifier: BSD-3-Clause
/// @file HexFrames.h
/// Tables of the ways in which a hexahedron lies in a grid, and in which two of them meet.
#pragma once

#include "Mesh/BlockTopology.h"

#include <cstdint>

namespace bsv
{

/// Where the three directions of a cell point in a grid: direction d along +-axis[d].
struct Frame
{
  std::array<int, 3> axis{ 0, 1, 2 };
  std::array<int, 3> sign{ 1, 1, 1 };

  /// 1 for right-handed ones, -1 for mirrored ones.
  int parity() const
  {
    const bool even = (this->axis[1] - this->axis[0] + 3) % 3 == 1;
    return (even ? 1 : -1) * this->sign[0] * this->sign[1] * this->sign[2];
  }
};

/// The 48 frames by number, and what follows from them.
class HexFrames
{
public:
  static constexpr int Count = 48;
  static constexpr std::uint8_t None = 255;

  static const HexFrames& instance();

  const Frame& operator[](int number) const { return this->Frames[number]; }
  int number(const Frame& frame) const
  {
    const int order = 2 * frame.axis[0] + (frame.axis[1] > frame.axis[2] ? 1 : 0);
    return 8 * order + (frame.sign[0] < 0 ? 1 : 0) + (frame.sign[1] < 0 ? 2 : 0) + (frame.sign[2] < 0 ? 4 : 0);
  }
  /// The cell's corner or face that is the given one of the grid, and the other way round.
  int cellCorner(int frame, int gridCorner) const { return this->CellCorner[frame][gridCorner]; }
  int cellFace(int frame, int gridFace) const { return this->CellFace[frame][gridFace]; }
  int gridFace(int frame, int cellFace) const { return this->GridFace[frame][cellFace]; }
  /// Frame of the cell behind `face` of a cell in `frame`, which meets it with its face `other`.
  int across(int frame, int face, int other, int orientation) const
  {
    return this->Across[frame][this->Meeting[face][other][orientation]];
  }

  /// Corner, or edge, of the cell behind `face` that is the given one of this cell. None if it is not on the face.
  int cornerAcross(int face, int other, int orientation, int corner) const
  {
    return this->CornerAcross[face][other][orientation][corner];
  }
  int edgeAcross(int face, int other, int orientation, int edge) const
  {
    return this->EdgeAcross[face][other][orientation][edge];
  }
  /// The face at an edge that is not `face`; None if `face` is not at the edge.
  int otherFace(int edge, int face) const { return this->OtherFace[edge][face]; }
  /// One of the two faces at an edge.
  int edgeFace(int edge, int which) const { return this->EdgeFace[edge][which]; }
  /// The edge from a corner in a direction.
  int cornerEdge(int corner, int direction) const { return this->CornerEdge[corner][direction]; }

private:
  HexFrames();

  std::array<Frame, Count> Frames;
  std::uint8_t CellCorner[Count][8];
  std::uint8_t CellFace[Count][6];
  std::uint8_t GridFace[Count][6];
  std::uint8_t Across[Count][Count];
  std::uint8_t Meeting[6][6][8];
  std::uint8_t CornerAcross[6][6][8][8];
  std::uint8_t EdgeAcross[6][6][8][12];
  std::uint8_t OtherFace[12][6];
  std::uint8_t EdgeFace[12][2];
  std::uint8_t CornerEdge[8][3];
};

} // namespace bsv
