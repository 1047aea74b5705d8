// SPDX-License-Identifier: BSD-3-Clause
/// @file GridBlock.h
/// One block as it comes out of a file: it owns its points, so that they can be handed on without a copy. Of a block
/// that belongs to another piece only name and size are known.
#pragma once

#include "Mesh/BlockMesh.h"

#include <functional>
#include <memory>
#include <new>
#include <string>
#include <vector>

namespace bsv
{

/// Gives back memory the way it was taken.
struct BlockRelease
{
  void (*function)(void*) = [](void* memory) { ::operator delete(memory); };
  void operator()(void* memory) const { this->function(memory); }
};

template <typename Value>
using BlockArray = std::unique_ptr<Value[], BlockRelease>;

/// Where the points of blocks are put. Values are not initialised.
struct BlockMemory
{
  /// @throws std::bad_alloc
  std::function<void*(std::size_t bytes)> allocate = [](std::size_t bytes) { return ::operator new(bytes); };
  void (*release)(void*) = BlockRelease().function;

  template <typename Value>
  BlockArray<Value> array(Index count) const
  {
    void* memory = this->allocate(static_cast<std::size_t>(count) * sizeof(Value));
    return BlockArray<Value>(static_cast<Value*>(memory), { this->release });
  }
};

struct GridBlock
{
  std::string name;
  /// Points per direction.
  Ijk counts{ 0, 0, 0 };
  /// The piece that the block belongs to (Piece.h).
  int piece = 0;
  /// size() triples x y z, i fastest: exactly one of the two, in the precision of the file, or none of another piece.
  BlockArray<float> floats;
  BlockArray<double> doubles;
  /// size() values, or null if the file has none.
  BlockArray<int> iblank;

  Index size() const { return Index(this->counts[0]) * this->counts[1] * this->counts[2]; }
  bool isHere() const { return this->floats || this->doubles; }
  GridView view() const
  {
    return this->floats ? GridView(this->floats.get(), this->counts) : GridView(this->doubles.get(), this->counts);
  }

  /// Makes room for the points, not initialised.
  /// @throws std::bad_alloc
  void allocate(bool isFloat, const BlockMemory& memory = {})
  {
    if (isFloat)
    {
      this->floats = memory.array<float>(3 * this->size());
    }
    else
    {
      this->doubles = memory.array<double>(3 * this->size());
    }
  }
};

/// Block as part of a mesh; its view is valid as long as `block` is.
inline MeshBlock meshBlock(const GridBlock& block)
{
  MeshBlock mesh;
  mesh.points = block.view();
  mesh.rank = block.piece;
  mesh.name = block.name;
  return mesh;
}

/// "I x J x K".
inline std::string toString(const Ijk& counts)
{
  return std::to_string(counts[0]) + " x " + std::to_string(counts[1]) + " x " + std::to_string(counts[2]);
}

/// Checks that all coordinates are finite.
/// @throws Error that starts with `where` and names block, point (from 0), axis and value.
void checkFinite(const std::string& where, const GridBlock& block);

} // namespace bsv
