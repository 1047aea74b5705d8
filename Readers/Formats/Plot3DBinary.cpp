// SPDX-License-Identifier: BSD-3-Clause
// PLOT3D files in binary: integers, reals and Fortran records.
#include "Formats/Plot3DSyntax.h"

#include <algorithm>
#include <limits>
#include <optional>

namespace bsv::plot3d
{

namespace
{

/// One that does not tell the length of its record, or that would lie behind the end of the file.
struct BadMarker
{
  Index at;
  std::optional<Index> value;
};

/// Of a record of `bytes`, which starts at `offset`.
std::optional<BadMarker> badMarker(InputFile& file, const Plot3DLayout& layout, Index offset, Index bytes)
{
  const Index marker = markerSize(layout);
  if (marker == 0)
  {
    return {};
  }
  for (const Index at : { offset, offset + marker + bytes })
  {
    if (at + marker > file.size())
    {
      return BadMarker{ at, {} };
    }
    const Index value = readMarker(file, at, marker, layout.byteOrder);
    if (value != bytes)
    {
      return BadMarker{ at, value };
    }
  }
  return {};
}

/// What is wrong with the markers around a record; empty if nothing is.
std::string recordFault(InputFile& file, const Plot3DLayout& layout, Index offset, Index bytes, const std::string& what)
{
  const std::optional<BadMarker> bad = badMarker(file, layout, offset, bytes);
  if (!bad)
  {
    return {};
  }
  if (!bad->value)
  {
    return "the record marker of the " + what + " at offset " + std::to_string(bad->at) +
      " lies behind the end of the file (" + std::to_string(file.size()) + " bytes)";
  }
  return "the record marker at offset " + std::to_string(bad->at) + " is " + std::to_string(*bad->value) +
    ", not the " + std::to_string(bytes) + " bytes of the " + what;
}

} // namespace

std::vector<Index> readIntegers(InputFile& file, Index offset, Index count, const Plot3DLayout& layout)
{
  std::vector<Index> values(static_cast<std::size_t>(count));
  readIntegers(
    file, offset, count, layout, [&](Index i, Index value) { values[i] = value; }, [](Index) {});
  return values;
}

Index markerSize(const Plot3DLayout& layout)
{
  return layout.joined                         ? 0
    : layout.format == Plot3DFormat::Fortran   ? 4
    : layout.format == Plot3DFormat::Fortran64 ? 8
                                               : 0;
}

Index readMarker(InputFile& file, Index offset, Index size, ByteOrder order)
{
  return size == 4 ? Index(readValue<std::int32_t>(file, offset, order)) : readValue<std::int64_t>(file, offset, order);
}

bool isRecord(InputFile& file, const Plot3DLayout& layout, Index offset, Index bytes)
{
  return !badMarker(file, layout, offset, bytes);
}

Index blockSize(const Plot3DLayout& layout, const Ijk& counts)
{
  return saturatingProduct(pointCount(counts),
    (layout.realType == RealType::Float ? 12 : 24) + (layout.iblank == IBlank::Present ? layout.integerSize : 0));
}

Index headerSize(const Plot3DLayout& layout)
{
  const Index marker = markerSize(layout);
  return (layout.multiBlock ? layout.integerSize + 2 * marker : 0) +
    3 * layout.integerSize * static_cast<Index>(layout.counts.size()) + 2 * marker;
}

std::string readHeader(InputFile& file, Plot3DLayout& layout, Progress& progress)
{
  const Index marker = markerSize(layout);
  Index offset = 0;
  Index blocks = 1;
  const Index size = layout.integerSize;
  const auto tooShort = [&](Index bytes) {
    return "the header needs " + number(bytes) + " bytes, the file has " + std::to_string(file.size());
  };
  progress = Nothing;
  if (layout.multiBlock)
  {
    if (size + 2 * marker > file.size())
    {
      return tooShort(size + 2 * marker);
    }
    if (marker != 0)
    {
      std::string fault = recordFault(file, layout, 0, size, "number of blocks");
      if (!fault.empty())
      {
        return fault;
      }
      progress = Marker;
    }
    blocks = readIntegers(file, marker, 1, layout)[0];
    if (blocks < 1 || blocks > std::numeric_limits<int>::max())
    {
      return "the number of blocks at offset " + std::to_string(marker) + " is " + std::to_string(blocks);
    }
    offset = size + 2 * marker;
  }
  const Index bytes = 3 * size * blocks;
  if (layout.multiBlock && bytes < file.size())
  {
    progress = std::max(progress, BlockCount);
  }
  if (offset + bytes + 2 * marker > file.size())
  {
    return tooShort(offset + bytes + 2 * marker);
  }
  if (marker != 0)
  {
    std::string fault = recordFault(file, layout, offset, bytes, "points per direction");
    if (!fault.empty())
    {
      return fault;
    }
    progress = Marker;
  }
  const std::vector<Index> counts = readIntegers(file, offset + marker, 3 * blocks, layout);
  layout.counts.resize(static_cast<std::size_t>(blocks));
  for (std::size_t b = 0; b < layout.counts.size(); ++b)
  {
    for (int d = 0; d < 3; ++d)
    {
      layout.counts[b][d] = static_cast<int>(
        std::clamp<Index>(counts[3 * b + d], std::numeric_limits<int>::min(), std::numeric_limits<int>::max()));
    }
    if (!positive(layout.counts[b]))
    {
      return blockName(b) + " has " + toString(layout.counts[b]) + " points (at offset " +
        std::to_string(offset + marker + 3 * size * static_cast<Index>(b)) + ")";
    }
  }
  // Without a number of blocks any three positive numbers would do.
  const bool absurd = !layout.multiBlock && pointCount(layout.counts) > 100 * file.size();
  progress = marker != 0 ? HeaderInMarkers : absurd ? Nothing : Header;
  return {};
}

std::string blocksFault(InputFile& file, const Plot3DLayout& layout)
{
  const Index marker = markerSize(layout);
  Index offset = headerSize(layout);
  for (std::size_t b = 0; b < layout.counts.size(); ++b)
  {
    const Index bytes = blockSize(layout, layout.counts[b]);
    if (bytes > file.size() - offset)
    {
      return blockName(b) + " of " + toString(layout.counts[b]) + " points at offset " + std::to_string(offset) +
        " needs " + number(bytes) + " bytes, " + std::to_string(file.size() - offset) + " are left";
    }
    if (!isRecord(file, layout, offset, bytes))
    {
      return recordFault(file, layout, offset, bytes, "coordinates of " + blockName(b));
    }
    offset += bytes + 2 * marker;
  }
  return offset == file.size()
    ? std::string()
    : std::to_string(file.size() - offset) + " bytes follow the last block, from offset " + std::to_string(offset);
}

std::string layoutName(const Plot3DLayout& layout)
{
  const char* formats[] = { "", "ASCII", "raw binary", "Fortran unformatted", "Fortran unformatted (8-byte markers)" };
  std::string text = formats[static_cast<int>(layout.format)];
  if (layout.format != Plot3DFormat::Ascii)
  {
    text += layout.byteOrder == ByteOrder::LittleEndian ? ", little-endian" : ", big-endian";
    text += layout.integerSize == 8 ? ", integers of 8 bytes" : "";
    text += layout.joined ? ", in records of its own" : "";
  }
  return text;
}

} // namespace bsv::plot3d
