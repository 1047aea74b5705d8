// SPDX-License-Identifier: BSD-3-Clause
// Reading the points of PLOT3D files whose layout is known.
#include "Formats/Plot3DSyntax.h"

#include "Base/MemoryCheck.h"

#include <algorithm>

namespace bsv
{

using namespace plot3d;

namespace
{

void readAscii(
  InputFile& file, const Plot3DLayout& layout, std::vector<GridBlock>& blocks, const Piece& piece, const Execution& run)
{
  ListReader reader(file);
  reader.header(layout.multiBlock);
  const Index total = pointCount(layout.counts) * (layout.iblank == IBlank::Present ? 4 : 3);
  Index done = 0;
  // store(point) reads a value, if the block is one of the piece.
  const auto read = [&](const std::string& what, const GridBlock& block, const auto& store) {
    reader.Context = block.name + ", " + what;
    constexpr Index Grain = 1 << 16;
    const Index size = block.size();
    for (Index begin = 0; begin < size; begin += Grain)
    {
      const Index end = std::min(size, begin + Grain);
      if (block.piece != piece.number)
      {
        reader.skip(end - begin);
      }
      else
      {
        for (Index p = begin; p < end; ++p)
        {
          store(p);
        }
      }
      done += end - begin;
      run.report(double(done) / double(total));
    }
  };
  for (GridBlock& block : blocks)
  {
    const bool own = block.piece == piece.number;
    if (own)
    {
      block.allocate(false);
    }
    for (int axis = 0; axis < 3; ++axis)
    {
      double* values = own ? block.doubles.get() + axis : nullptr;
      read(std::string(1, "xyz"[axis]), block, [&](Index p) { values[3 * p] = reader.real(); });
    }
    if (layout.iblank == IBlank::Present)
    {
      reader.switchType();
      block.iblank = own ? BlockMemory().array<int>(block.size()) : nullptr;
      read("iblank", block, [&](Index p) { block.iblank[p] = reader.integer(); });
      reader.switchType();
    }
  }
}

void readBinary(
  InputFile& file, const Plot3DLayout& layout, std::vector<GridBlock>& blocks, const Piece& piece, const Execution& run)
{
  Index total = 0;
  for (const GridBlock& block : blocks)
  {
    total += block.piece == piece.number ? block.size() * (layout.iblank == IBlank::Present ? 4 : 3) : 0;
  }
  Index done = 0;
  const auto report = [&](Index count) {
    done += count;
    run.report(double(done) / double(total));
  };
  const Index marker = markerSize(layout);
  Index next = headerSize(layout);
  for (GridBlock& block : blocks)
  {
    const Index offset = next;
    next += blockSize(layout, block.counts) + 2 * marker;
    if (block.piece != piece.number)
    {
      continue;
    }
    const bool isFloat = layout.realType == RealType::Float;
    const Index size = block.size();
    block.allocate(isFloat);
    Index at = offset + marker;
    for (int axis = 0; axis < 3; ++axis)
    {
      const auto read = [&](auto* values) {
        using Real = std::remove_pointer_t<decltype(values)>;
        readArray<Real>(
          file, at, size, layout.byteOrder, [&](Index p, Real x) { values[3 * p + axis] = x; }, report);
        at += size * Index(sizeof(Real));
      };
      isFloat ? read(block.floats.get()) : read(block.doubles.get());
    }
    if (layout.iblank == IBlank::Present)
    {
      block.iblank = BlockMemory().array<int>(size);
      readIntegers(
        file, at, size, layout, [&](Index p, Index value) { block.iblank[p] = static_cast<int>(value); }, report);
    }
    checkFinite(file.name(), block);
  }
}

} // namespace

std::vector<GridBlock> readPlot3D(
  const std::string& fileName, const Plot3DLayout& layout, const Execution& run, const Piece& piece)
{
  InputFile file(fileName);
  if (layout.joined && !file.joinRecords(layout.format, layout.byteOrder, run))
  {
    throw Error(fileName + ": the file has changed while it was read");
  }
  const std::vector<int> owners = piece.owners(layout.counts);
  std::vector<GridBlock> blocks(layout.counts.size());
  double points = 0.0;
  for (std::size_t b = 0; b < blocks.size(); ++b)
  {
    blocks[b].name = blockName(b);
    blocks[b].counts = layout.counts[b];
    blocks[b].piece = owners[b];
    points += owners[b] == piece.number ? static_cast<double>(blocks[b].size()) : 0.0;
  }
  requireMemory(
    points * ((layout.realType == RealType::Float ? 12.0 : 24.0) + (layout.iblank == IBlank::Present ? 4.0 : 0.0)),
    fileName, "its points");
  try
  {
    layout.format == Plot3DFormat::Ascii ? readAscii(file, layout, blocks, piece, run)
                                         : readBinary(file, layout, blocks, piece, run);
    if (layout.format == Plot3DFormat::Ascii || layout.format == Plot3DFormat::Binary || layout.joined)
    {
      const auto own =
        std::find_if(blocks.begin(), blocks.end(), [](const GridBlock& block) { return block.isHere(); });
      if (own != blocks.end())
      {
        refuseOtherOrders(fileName, *own);
      }
    }
  }
  catch (const std::bad_alloc&)
  {
    throw Error(fileName + ": not enough memory for " + number(pointCount(layout.counts)) + " points");
  }
  return blocks;
}

} // namespace bsv
