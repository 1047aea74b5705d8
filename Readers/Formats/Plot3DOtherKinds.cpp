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
  /// Whether an integer per point (iblank) may follow the reals of a block.
  bool mayBeBlanked = false;
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
      [](const Counts& n) { return Counts{ saturatingProduct(2, product(n, 2)) }; }, false, true },
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
  Index blanks = 0;
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
    blanks = saturatingSum(blanks, product(counts, 2));
  }
  return sum == values || (kind.mayBeBlanked && saturatingSum(sum, blanks) == values);
}

/// Whether the counts of each block stand before its points. @param bytes of the file: it has no more blocks
bool hasHeadersInBetween(ListReader& reader, bool multiBlock, Index values, Index bytes)
{
  const Index blocks = multiBlock ? reader.integer() : bytes;
  Index left = values - (multiBlock ? 1 : 0);
  Index found = 0;
  for (; found < std::min(blocks, bytes) && left > 0; ++found)
  {
    Index points = 1;
    for (int d = 0; d < 3; ++d)
    {
      points = saturatingProduct(points, std::max(0, reader.integer()));
    }
    left -= 3;
    if (points < 1 || saturatingProduct(3, points) > left)
    {
      return false;
    }
    reader.skip(3 * points);
    left -= 3 * points;
  }
  return left == 0 && found > 1 && (!multiBlock || found == blocks);
}

/// Whether the numbers of variables and of species follow the counts of all blocks, and each block is a record of flow
/// conditions, which depend on the version, and one of values.
bool isOverflowSolution(InputFile& file, const Plot3DLayout& layout)
{
  const Index marker = markerSize(layout);
  const Index size = layout.integerSize;
  const Index real = layout.realType == RealType::Float ? 4 : 8;
  Index offset = 0;
  const auto isRecordOf = [&](Index bytes) {
    return bytes > 0 && bytes <= file.size() - offset - 2 * marker && isRecord(file, layout, offset, bytes);
  };
  if (marker == 0 || (layout.multiBlock && !isRecordOf(size)))
  {
    return false;
  }
  const Index blocks = layout.multiBlock ? readIntegers(file, marker, 1, layout)[0] : 1;
  offset = layout.multiBlock ? size + 2 * marker : 0;
  if (blocks < 1 || blocks > file.size() / (3 * size) || !isRecordOf(size * (3 * blocks + 2)))
  {
    return false;
  }
  const std::vector<Index> header = readIntegers(file, offset + marker, 3 * blocks + 2, layout);
  const Index variables = header[3 * blocks];
  if (std::any_of(header.begin(), header.end() - 2, [](Index count) { return count < 1; }) || variables < 1)
  {
    return false;
  }
  offset += size * (3 * blocks + 2) + 2 * marker;
  for (Index b = 0; b < blocks; ++b)
  {
    constexpr Index MostConditions = 4096;
    const Index conditions = offset + marker > file.size() ? 0 : readMarker(file, offset, marker, layout.byteOrder);
    if (conditions > MostConditions || !isRecordOf(conditions))
    {
      return false;
    }
    offset += conditions + 2 * marker;
    const std::vector<Index> counts(header.begin() + 3 * b, header.begin() + 3 * b + 3);
    const Index bytes = saturatingProduct(saturatingProduct(product(counts, 3), variables), real);
    if (!isRecordOf(bytes))
    {
      return false;
    }
    offset += bytes + 2 * marker;
  }
  return offset == file.size();
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
  const auto holds = [&](const auto& explanation) {
    try
    {
      ListReader reader(file, run);
      return explanation(reader);
    }
    catch (const Aborted&)
    {
      throw;
    }
    catch (const Error&)
    {
      return false;
    }
  };
  for (const OtherKind& kind : otherKinds())
  {
    for (const bool multiBlock : { true, false })
    {
      if (!kind.onlyInRecords && holds([&](ListReader& reader) { return explains(kind, reader, multiBlock, values); }))
      {
        return std::string("the file is ") + kind.text;
      }
    }
  }
  for (const bool multiBlock : { true, false })
  {
    if (holds([&](ListReader& reader) { return hasHeadersInBetween(reader, multiBlock, values, file.size()); }))
    {
      return "the file has the counts of each block before its points; PLOT3D has those of all blocks before the first "
             "point";
    }
  }
  return {};
}

std::string otherKindOfBinary(InputFile& file, bool records)
{
  std::vector<Plot3DLayout> layouts;
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
      layouts.push_back(layout);
    }
  }
  // Records that fit are no coincidence, a size that fits may be one.
  if (std::any_of(
        layouts.begin(), layouts.end(), [&](const Plot3DLayout& layout) { return isOverflowSolution(file, layout); }))
  {
    return "the file is a solution file of OVERFLOW (the numbers of variables and species follow the counts of the "
           "blocks), not a grid";
  }
  for (const OtherKind& kind : otherKinds())
  {
    for (const Plot3DLayout& layout : layouts)
    {
      const bool seen = markerSize(layout) != 0 || !(records || kind.onlyInRecords);
      if (seen && explains(kind, file, layout))
      {
        return std::string("the file is ") + kind.text;
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
