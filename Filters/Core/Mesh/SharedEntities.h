// SPDX-License-Identifier: BSD-3-Clause
/// @file SharedEntities.h
/// Global numbers of the corners, edges and faces that blocks share, from their whole-face interfaces alone.
#pragma once

#include "Mesh/BlockMesh.h"

#include <functional>
#include <string>
#include <vector>

namespace bsv
{

/// The entities of all blocks after gluing. Ids count from 0, in the order in which the blocks' own corners, edges and
/// faces first name them. An edge runs as the first block edge that has it, a face has the axes of the first block face
/// that has it.
struct SharedEntities
{
  struct Block
  {
    std::array<int, 8> vertices;
    std::array<int, 12> edges;
    /// Whether the block runs edge e against the global edge.
    std::array<bool, 12> edgeReversed;
    std::array<int, 6> faces;
    /// Orientation code from the global face's axes to those of the block's face; 0 for its owner.
    std::array<int, 6> faceOrientations;
  };
  struct Edge
  {
    std::array<int, 2> vertices;
    int uses = 0; ///< block edges that meet here
    bool boundary = false;
    /// First block edge that has it.
    int block = -1, edge = -1;
  };
  struct Face
  {
    int uses = 0; ///< 1 on the boundary, 2 inside
    /// First block face that has it.
    int block = -1, face = -1;
  };

  int vertices = 0;
  std::vector<Edge> edges;
  std::vector<Face> faces;
  std::vector<Block> blocks;
};

/// Only the blocks, faces and orientation codes of the interfaces are used, not their ranges. Blocks may meet
/// themselves and each other more than once.
/// @param blockName how errors call a block
/// @throws Error if a block face is in two interfaces or meets itself, or an edge meets itself reversed.
SharedEntities sharedEntities(
  int blocks, const std::vector<Interface>& interfaces,
  const std::function<std::string(int block)>& blockName = [](int block) { return "block " + std::to_string(block); });

} // namespace bsv
