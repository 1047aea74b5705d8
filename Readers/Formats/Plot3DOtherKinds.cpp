// SPDX-License-Identifier: BSD-3-Clause
// What a file is that is no PLOT3D grid in whole format.
#include "Formats/Plot3DSyntax.h"

#include "IO/Encodings.h"

#include <Eigen/Geometry>

#include <algorithm>

namespace bsv::plot3d
{

namespace
{

/// A kind of file that is no three-dimensional grid in whole format.
struct OtherKind
{
  /// Integers per block in the header.
  int counts;
  const char* text;
  /// Numbers of reals in the records of a block.
  std::vector<Index> (*records)(const std::vector<Index>& counts);
  /// Whether it has the size of a grid in whole format, so that only its records tell.
  bool onlyInRecords = false;
};

/// Of the first counts.
Index product(const std::vector<Index>& counts, std::size_t end)
{
  Index all = 1;
  for (std::size_t d = 0; d < end; ++d)
  {
    all = saturatingProduct(all, counts[d]);
  }
  return all;
}

const std::vector<OtherKind>& otherKinds()
{
  using Counts = std::vector<Index>;
  static const std::vector<OtherKind> kinds = {
    { 2, "a two-dimensional grid (2 counts per block); hexahedra need a three-dimensional one",
      [](const Counts& n) { return Counts{ saturatingProduct(2, product(n, 2)) }; } },
    { 3, "a PLOT3D solution file (4 flow conditions and 5 values a point), not a grid",
      [](const Counts& n) {
        return Counts{ 4, saturatingProduct(5, product(n, 3)) };
      } },
    { 2, "a two-dimensional PLOT3D solution file, not a grid",
      [](const Counts& n) {
        return Counts{ 4, saturatingProduct(4, product(n, 2)) };
      } },
    { 4, "a PLOT3D function file (the number of variables follows the counts of a block), not a grid",
      [](const Counts& n) { return Counts{ product(n, 4) }; } },
    { 3, "a two-dimensional PLOT3D function file, not a grid",
      [](const Counts& n) { return Counts{ product(n, 3) }; } },
    { 3, "a grid in planes format (x, y and z of one k plane after the other); write it in whole format",
      [](const Counts& n) {
        return Counts(static_cast<std::size_t>(std::min<Index>(n[2], 1 << 20)), saturatingProduct(3, product(n, 2)));
      },
      true },
  };
  return kinds;
}

/// Whether records of these numbers of reals, `iblank` integers behind the first, are what is left from `offset`.
bool fillFile(
  InputFile& file, const Plot3DLayout& layout, Index offset, const std::vector<Index>& records, bool iblank, int dims)
{
  const Index marker = markerSize(layout);
  const Index real = layout.realType == RealType::Float ? 4 : 8;
  for (const Index values : records)
  {
    const Index bytes =
      saturatingSum(saturatingProduct(values, real), iblank ? saturatingProduct(values / dims, layout.integerSize) : 0);
    if (bytes > file.size() - offset - 2 * marker)
    {
      return false;
    }
    if (!isRecord(file, layout, offset, bytes))
    {
      return false;
    }
    offset += bytes + 2 * marker;
  }
  return offset == file.size();
}

/// Whether the counts of the blocks, which `reader` gives, promise as many numbers as the file has.
bool explains(const OtherKind& kind, ListReader& reader, bool multiBlock, Index values)
{
  const int blocks = multiBlock ? reader.integer() : 1;
  Index sum = saturatingSum(multiBlock ? 1 : 0, saturatingProduct(kind.counts, blocks));
  if (blocks < 1 || sum >= values)
  {
    return false;
  }
  for (int b = 0; b < blocks; ++b)
  {
    std::vector<Index> counts;
    for (int d = 0; d < kind.counts; ++d)
    {
      counts.push_back(reader.integer());
      if (counts.back() < 1)
      {
        return false;
      }
    }
    for (const Index record : kind.records(counts))
    {
      sum = saturatingSum(sum, record);
    }
    if (sum > values)
    {
      return false;
    }
  }
  return sum == values;
}

/// Whether the counts of the blocks and the records that they promise explain the file.
bool explains(const OtherKind& kind, InputFile& file, const Plot3DLayout& layout)
{
  const Index marker = markerSize(layout);
  const Index size = layout.integerSize;
  if (layout.multiBlock && marker + size > file.size())
  {
    return false;
  }
  const Index blocks = layout.multiBlock ? readIntegers(file, marker, 1, layout)[0] : 1;
  const Index offset = layout.multiBlock ? size + 2 * marker : 0;
  if (blocks < 1 || blocks > file.size() / (size * kind.counts))
  {
    return false;
  }
  const Index bytes = size * kind.counts * blocks;
  if (offset + marker + bytes > file.size() || !isRecord(file, layout, offset, bytes))
  {
    return false;
  }
  const std::vector<Index> header = readIntegers(file, offset + marker, kind.counts * blocks, layout);
  if (std::any_of(header.begin(), header.end(), [](Index count) { return count < 1; }))
  {
    return false;
  }
  // Three planes look like three coordinates.
  bool told = !kind.onlyInRecords;
  std::vector<Index> lengths;
  for (auto at = header.begin(); at != header.end(); at += kind.counts)
  {
    const std::vector<Index> counts(at, at + kind.counts);
    // Each kind has a value of 4 bytes or more for each.
    if (product(counts, counts.size()) > file.size() / 4)
    {
      return false;
    }
    const std::vector<Index> own = kind.records(counts);
    lengths.insert(lengths.end(), own.begin(), own.end());
    if (static_cast<Index>(lengths.size()) > file.size() / 4)
    {
      return false;
    }
    told = told || counts.back() != 3;
  }
  const int dims = kind.counts == 2 ? 2 : 3;
  const Index begin = offset + bytes + 2 * marker;
  return told &&
    (fillFile(file, layout, begin, lengths, false, dims) || fillFile(file, layout, begin, lengths, true, dims));
}

/// The share of cells whose corner Jacobian has not the sign of the most. @param value(point, axis) coordinates
template <typename Value>
double minorityOfSigns(const Ijk& counts, const Value& value)
{
  const Index row = counts[0];
  const Index layer = row * counts[1];
  Index positive = 0;
  Index negative = 0;
  Index all = 0;
  for (int k = 0; k + 1 < counts[2]; ++k)
  {
    for (int j = 0; j + 1 < counts[1]; ++j)
    {
      for (int i = 0; i + 1 < counts[0]; ++i)
      {
        const Index p = i + row * j + layer * k;
        const auto edge = [&](Index q) {
          return Vec3(value(q, 0) - value(p, 0), value(q, 1) - value(p, 1), value(q, 2) - value(p, 2));
        };
        const double volume = edge(p + 1).cross(edge(p + row)).dot(edge(p + layer));
        positive += volume > 0.0;
        negative += volume < 0.0;
        ++all;
      }
    }
  }
  return 1.0 - double(std::max(positive, negative)) / double(all);
}

} // namespace

void refuseEncodings(InputFile& file)
{
  const std::string what = otherEncoding(file.start(6));
  if (!what.empty())
  {
    throw Error(file.name() + ": the file is " + what);
  }
}

std::string otherKindOfText(InputFile& file, Index values, const Execution& run)
{
  for (const OtherKind& kind : otherKinds())
  {
    for (const bool multiBlock : { true, false })
    {
      try
      {
        ListReader reader(file, run);
        if (!kind.onlyInRecords && explains(kind, reader, multiBlock, values))
        {
          return std::string("the file is ") + kind.text;
        }
      }
      catch (const Aborted&)
      {
        throw;
      }
      catch (const Error&)
      {
        // Not this one.
      }
    }
  }
  return {};
}

std::string otherKindOfBinary(InputFile& file, bool records)
{
  for (const OtherKind& kind : otherKinds())
  {
    for (const Plot3DFormat format : { Plot3DFormat::Fortran, Plot3DFormat::Fortran64, Plot3DFormat::Binary })
    {
      for (int bits = 0; bits < 16; ++bits)
      {
        Plot3DLayout layout;
        layout.format = format;
        layout.byteOrder = bits & 1 ? ByteOrder::BigEndian : ByteOrder::LittleEndian;
        layout.multiBlock = (bits & 2) == 0;
        layout.integerSize = bits & 4 ? 8 : 4;
        layout.realType = bits & 8 ? RealType::Double : RealType::Float;
        const bool seen = markerSize(layout) != 0 || !(records || kind.onlyInRecords);
        if (seen && explains(kind, file, layout))
        {
          return std::string("the file is ") + kind.text;
        }
      }
    }
  }
  return {};
}

void refuseOtherOrders(const std::string& fileName, const GridBlock& block)
{
  const Ijk& counts = block.counts;
  const Index size = block.size();
  const Index layer = Index(counts[0]) * counts[1];
  // Values in the order of the file.
  const auto stored = [&](Index v) -> double {
    const Index at = 3 * (v % size) + v / size;
    return block.floats ? double(block.floats[at]) : block.doubles[at];
  };
  const auto whole = [&](Index p, int axis) { return stored(axis * size + p); };
  const auto planes = [&](Index p, int axis) { return stored((3 * (p / layer) + axis) * layer + p % layer); };
  const auto onePoint = [&](Index p, int axis) { return stored(3 * p + axis); };
  // Few cells are sound by chance.
  constexpr Index FewestCells = 8;
  const Index cells = Index(counts[0] - 1) * (counts[1] - 1) * (counts[2] - 1);
  if (cells < FewestCells || minorityOfSigns(counts, whole) <= 0.1)
  {
    return;
  }
  if (minorityOfSigns(counts, planes) < 0.01)
  {
    throw Error(fileName + ": the file is " + otherKinds().back().text);
  }
  if (minorityOfSigns(counts, onePoint) < 0.01)
  {
    throw Error(fileName +
      ": the file has x, y and z of one point after the other; a grid in whole format has x of all points of a block, "
      "then "
      "y, then z");
  }
}

} // namespace bsv::plot3d
