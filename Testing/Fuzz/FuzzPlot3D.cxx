// SPDX-License-Identifier: BSD-3-Clause
// PLOT3D grids: finding the layout, and reading what was found. The first byte chooses the options.
#include "FuzzSupport.h"

#include "Formats/Plot3DFile.h"

#include <cstring>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  if (size == 0)
  {
    return 0;
  }
  bsv::Plot3DOptions options;
  // Mostly automatic, as users have it.
  if (data[0] & 1)
  {
    options.format = static_cast<bsv::Plot3DFormat>(data[0] / 2 % 5);
    options.byteOrder = static_cast<bsv::ByteOrder>(data[0] / 16 % 3);
    options.iblank = static_cast<bsv::IBlank>(data[0] / 64 % 3);
  }
  const std::string& name = fuzz::fileWith(data + 1, size - 1);
  bsv::looksLikePlot3D(name);
  fuzz::parse([&] {
    const bsv::Plot3DLayout layout = bsv::plot3DLayout(name, options);
    bsv::readPlot3D(name, layout);
  });
  return 0;
}

/// Makes a file of random form that is right, and spoils some of them: bytes alone hardly ever fit together.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed)
{
  std::minstd_rand random(seed);
  const auto below = [&](unsigned bound) { return random() % bound; };
  if (below(4) != 0 || most < 600)
  {
    const bool text = size > 1 && std::all_of(data + 1, data + std::min<std::size_t>(size, 9), [](std::uint8_t c) {
      return (c >= ' ' && c < 127) || c == '\n';
    });
    return text && size > 1
      ? 1 + fuzz::mutateText(data + 1, size - 1, most - 1, seed, { "2*0.5", "3*2", "1.5D0", ",", "1-3", "2 2 2" })
      : LLVMFuzzerMutate(data, size, most);
  }
  const int integerSize = below(4) == 0 ? 8 : 4;
  const int realSize = below(2) == 0 ? 8 : 4;
  const int marker = 4 * static_cast<int>(below(3));
  const bool bigEndian = below(2) == 0;
  const bool iblank = below(2) == 0;
  const int dimensions = below(5) == 0 ? 2 : 3;
  const int blocks = 1 + static_cast<int>(below(2));
  std::string file(1, static_cast<char>(data[0] & ~1));
  const auto put = [&](auto value, int bytes, std::string& out) {
    char raw[8];
    std::memcpy(raw, &value, sizeof(value));
    bigEndian ? std::reverse(raw, raw + bytes) : void();
    out.append(raw, static_cast<std::size_t>(bytes));
  };
  const auto integer = [&](std::int64_t value, int bytes, std::string& out) {
    bytes == 8 ? put(value, 8, out) : put(static_cast<std::int32_t>(value), 4, out);
  };
  const auto record = [&](const std::string& content) {
    std::string mark;
    if (marker != 0)
    {
      integer(static_cast<std::int64_t>(content.size()), marker, mark);
    }
    file += mark + content + mark;
  };
  std::string content;
  if (blocks > 1 || below(2) == 0)
  {
    integer(blocks, integerSize, content);
    record(content);
  }
  content.clear();
  std::vector<int> points;
  for (int b = 0; b < blocks; ++b)
  {
    points.push_back(1);
    for (int d = 0; d < dimensions; ++d)
    {
      const int count = 1 + static_cast<int>(below(3));
      points.back() *= count;
      integer(count, integerSize, content);
    }
  }
  record(content);
  for (const int count : points)
  {
    content.clear();
    for (int v = 0; v < dimensions * count; ++v)
    {
      realSize == 8 ? put(double(below(9)), 8, content) : put(float(below(9)), 4, content);
    }
    for (int v = 0; iblank && v < count; ++v)
    {
      integer(static_cast<int>(below(3)) - 1, integerSize, content);
    }
    record(content);
  }
  size = std::min(file.size(), most);
  std::copy_n(file.begin(), size, data);
  return below(2) == 0 ? size : LLVMFuzzerMutate(data, size, most);
}
