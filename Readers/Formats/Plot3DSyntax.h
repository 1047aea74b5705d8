// SPDX-License-Identifier: BSD-3-Clause
/// @file Plot3DSyntax.h
/// What the parts of the PLOT3D reader share: the file as a sequence of bytes (Plot3DInput.cpp), as Fortran text
/// (Plot3DText.cpp), as integers, reals and records (Plot3DBinary.cpp), and what else it may be (Plot3DOtherKinds.cpp).
#pragma once

#include "Formats/Plot3DFile.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <functional>
#include <string>
#include <type_traits>
#include <vector>

namespace bsv::plot3d
{

//----------------------------------------------------------------------------------------------------------------------
// Numbers of points, which a file that is something else may claim to be huge: they stay at Huge instead of
// overflowing.

/// Factors >= 0.
Index saturatingProduct(Index a, Index b);
Index saturatingSum(Index a, Index b);
Index pointCount(const Ijk& counts);
Index pointCount(const std::vector<Ijk>& counts);

/// "more than 9e18" for Huge.
std::string number(Index value);
std::string blockName(std::size_t block);
/// "12 blocks (5 x 5 x 31, 5 x 5 x 31, 25 x 17 x 31, .. points)".
std::string describe(const std::vector<Ijk>& counts);

bool positive(const Ijk& counts);

//----------------------------------------------------------------------------------------------------------------------
// Bytes

/// Where the text of an ASCII file starts: behind a byte order mark, and comments before the first number.
struct TextStart
{
  Index offset = 0;
  /// Line ends before it.
  Index lines = 0;
  Index comments = 0;
};

class InputFile
{
public:
  /// @throws Error if there is no such regular file, or if it is empty
  explicit InputFile(const std::string& fileName);

  const std::string& name() const { return this->Name; }
  Index size() const { return this->Size; }

  void read(Index offset, void* target, Index bytes);

  /// Makes one stream of the contents of all records, whatever their number, if the whole file is a chain of them: from
  /// then on there are no markers. Of a record that is too long for its marker there are several, whose markers are
  /// negative where others follow or precede.
  bool joinRecords(Plot3DFormat format, ByteOrder order, const Execution& run);

  /// The first bytes, or all if there are fewer.
  std::string start(Index bytes, Index from = 0);
  TextStart textStart();

private:
  struct Record
  {
    /// Of its content, in that of all records and in the file.
    Index start;
    Index place;
  };
  void readPlain(Index offset, void* target, Index bytes);

  std::string Name;
  Index Size;
  std::ifstream Stream;
  /// The first bytes of the file, by which most layouts are found.
  std::string Head;
  std::vector<Record> Records;
};

//----------------------------------------------------------------------------------------------------------------------
// Text

bool isText(InputFile& file);

/// Values of Fortran list-directed text: a whole file, read part by part, or its first bytes.
class ListReader
{
public:
  explicit ListReader(InputFile& file, const Execution& run = {});
  /// @param run is asked whether to stop after each part
  ListReader(InputFile& file, Index bytes, const Execution& run = {});
  ListReader(const ListReader&) = delete;
  ListReader& operator=(const ListReader&) = delete;

  /// How many values there are from here to the end, repeats multiplied out.
  Index countValues();
  /// Checks that all values from here to the end are numbers.
  void checkNumbers();

  double real();
  int integer();
  /// Leaves out values, which need not be numbers.
  void skip(Index count);
  /// The next value is of the other type: a repeat may not run across.
  void switchType();
  /// Behind the header `reader` stands at the first coordinate. @return points per direction of the blocks
  std::vector<Ijk> header(bool multiBlock);

  /// Names the line of the value read last.
  [[noreturn]] void fail(const std::string& what) const;
  /// Line of the value read last, from 1.
  Index line() const;

  /// What is being read, for error messages.
  std::string Context = "header";

private:
  /// The value as it stands in the file, cut to a readable length.
  std::string shown() const;
  /// Says why the value read last is no number that can be, and what it may be instead.
  [[noreturn]] void refuse(const char* why) const;
  /// Finds the next value unless the last one repeats; whether it did.
  bool isNew();
  /// Reads on, and drops what lies before At.
  void refill();
  /// Whether At is at the end of the text.
  bool atEnd();
  /// Finds the next value and its repeat count; false at the end of the text.
  bool fetch();
  double parseReal() const;

  InputFile& File;
  const Execution Run;
  /// Where the text goes on that is not in the buffer, and how many bytes there are.
  Index Offset;
  Index Remaining;
  std::vector<char> Buffer;
  /// Whether numbers in the buffer may run into each other.
  bool MayJoin = false;
  /// Line ends before the buffer.
  Index LinesBefore;
  /// What is left of the buffer.
  const char* At;
  const char* End;
  /// The value read last, without its repeat count, and how often it is still to be given.
  const char* Value = At;
  const char* ValueEnd = At;
  Index Repeat = 0;
  double Real = 0.0;
  int Integer = 0;
};

//----------------------------------------------------------------------------------------------------------------------
// Integers, reals and records

constexpr bool isForeign(ByteOrder order)
{
  return (order == ByteOrder::LittleEndian) != (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__);
}

template <typename Value>
Value swapBytes(Value value)
{
  static_assert(sizeof(Value) == 4 || sizeof(Value) == 8, "4 or 8 bytes");
  using Bits = std::conditional_t<sizeof(Value) == 4, std::uint32_t, std::uint64_t>;
  Bits bits;
  std::memcpy(&bits, &value, sizeof(bits));
  if constexpr (sizeof(Value) == 4)
  {
    bits = __builtin_bswap32(bits);
  }
  else
  {
    bits = __builtin_bswap64(bits);
  }
  std::memcpy(&value, &bits, sizeof(bits));
  return value;
}

template <typename Value>
Value readValue(InputFile& file, Index offset, ByteOrder order)
{
  Value value;
  file.read(offset, &value, sizeof(Value));
  return isForeign(order) ? swapBytes(value) : value;
}

/// Reads `count` values from `offset` and hands them on: store(index, value).
template <typename Value, typename Store>
void readArray(InputFile& file, Index offset, Index count, ByteOrder order, const Store& store,
  const std::function<void(Index)>& report)
{
  constexpr Index Grain = 1 << 16;
  std::vector<Value> buffer(static_cast<std::size_t>(std::min(count, Grain)));
  const bool swap = isForeign(order);
  for (Index begin = 0; begin < count; begin += Grain)
  {
    const Index n = std::min(Grain, count - begin);
    file.read(offset + begin * Index(sizeof(Value)), buffer.data(), n * Index(sizeof(Value)));
    for (Index i = 0; i < n; ++i)
    {
      store(begin + i, swap ? swapBytes(buffer[i]) : buffer[i]);
    }
    report(n);
  }
}

/// Integers of the size of the layout.
template <typename Store>
void readIntegers(InputFile& file, Index offset, Index count, const Plot3DLayout& layout, const Store& store,
  const std::function<void(Index)>& report)
{
  layout.integerSize == 8 ? readArray<std::int64_t>(file, offset, count, layout.byteOrder, store, report)
                          : readArray<std::int32_t>(file, offset, count, layout.byteOrder, store, report);
}

std::vector<Index> readIntegers(InputFile& file, Index offset, Index count, const Plot3DLayout& layout);

/// Of the markers that are seen: 0, 4 or 8 bytes.
Index markerSize(const Plot3DLayout& layout);
Index readMarker(InputFile& file, Index offset, Index size, ByteOrder order);

/// Whether there are no markers, or those around a record of `bytes`, which starts at `offset`, say so.
bool isRecord(InputFile& file, const Plot3DLayout& layout, Index offset, Index bytes);

/// Bytes of a block's values.
Index blockSize(const Plot3DLayout& layout, const Ijk& counts);
/// Where the first block's values (or the marker before them) start.
Index headerSize(const Plot3DLayout& layout);

/// How far an interpretation of the header got.
enum Progress
{
  Nothing,
  BlockCount,      ///< the number of blocks could be right
  Header,          ///< all numbers could be right
  Marker,          ///< a pair of record markers is right
  HeaderInMarkers, ///< all numbers could be right and all record markers are
};

/// Reads the points per direction of the blocks for the format, order and multiBlock given. Most of the layouts that
/// are tried are wrong, so that this is told by the result.
/// @param[out] progress how much of the header was believable.
/// @return what is wrong, without the file's name; empty if nothing is
std::string readHeader(InputFile& file, Plot3DLayout& layout, Progress& progress);

/// What is wrong if the blocks do not fill the file, for a complete layout; without the file's name.
std::string blocksFault(InputFile& file, const Plot3DLayout& layout);

/// For the user: format, byte order and what is unusual of the integers and records.
std::string layoutName(const Plot3DLayout& layout);

//----------------------------------------------------------------------------------------------------------------------
// What is no three-dimensional grid in whole format

/// The file has not been read as what it is: says so if it is packed, or a text in an encoding of its own.
void refuseEncodings(InputFile& file);

/// What an ASCII file of `values` numbers is that is no grid; empty if no kind explains their number.
std::string otherKindOfText(InputFile& file, Index values, const Execution& run);

/// What a binary file is that is no grid; empty if no kind explains its size.
/// @param records whether it has record markers: then a size that fits without them is a coincidence
std::string otherKindOfBinary(InputFile& file, bool records);

/// Planes format, or point after point, has the size of whole format: it shows in a mesh that is tangled one way and
/// sound the other way.
void refuseOtherOrders(const std::string& fileName, const GridBlock& block);

} // namespace bsv::plot3d
