// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Plot3DFile.h"

#include "Base/MemoryCheck.h"
#include "Formats/Encodings.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>

namespace bsv
{

namespace
{

constexpr Index Huge = std::numeric_limits<Index>::max();

/// Product that stays at Huge instead of overflowing; factors >= 0.
Index saturatingProduct(Index a, Index b)
{
  return b != 0 && a > Huge / b ? Huge : a * b;
}

Index saturatingSum(Index a, Index b)
{
  return a > Huge - b ? Huge : a + b;
}

std::string number(Index value)
{
  return value == Huge ? "more than 9e18" : std::to_string(value);
}

Index pointCount(const Ijk& counts)
{
  return saturatingProduct(saturatingProduct(counts[0], counts[1]), counts[2]);
}

Index pointCount(const std::vector<Ijk>& counts)
{
  Index sum = 0;
  for (const Ijk& block : counts)
  {
    sum = saturatingSum(sum, pointCount(block));
  }
  return sum;
}

bool positive(const Ijk& counts)
{
  return std::all_of(counts.begin(), counts.end(), [](int n) { return n >= 1; });
}

std::string blockName(std::size_t block)
{
  return "block " + std::to_string(block + 1);
}

/// "12 blocks (5 x 5 x 31, 5 x 5 x 31, 25 x 17 x 31, .. points)".
std::string describe(const std::vector<Ijk>& counts)
{
  std::string text = std::to_string(counts.size()) + (counts.size() == 1 ? " block (" : " blocks (");
  for (std::size_t b = 0; b < std::min<std::size_t>(counts.size(), 3); ++b)
  {
    text += (b == 0 ? "" : ", ") + toString(counts[b]);
  }
  return text + (counts.size() > 3 ? ", .. points)" : " points)");
}

//----------------------------------------------------------------------------------------------------------------------
// Files

/// @throws Error if there is no such regular file.
Index fileSize(const std::string& fileName)
{
  std::error_code failure;
  const auto status = std::filesystem::status(fileName, failure);
  if (!std::filesystem::exists(status))
  {
    throw Error(fileName + ": no such file");
  }
  if (!std::filesystem::is_regular_file(status))
  {
    throw Error(fileName + ": not a regular file");
  }
  const auto size = std::filesystem::file_size(fileName, failure);
  if (failure)
  {
    throw Error(fileName + ": " + failure.message());
  }
  if (size == 0)
  {
    throw Error(fileName + ": the file is empty (0 bytes)");
  }
  return static_cast<Index>(size);
}

class InputFile
{
public:
  explicit InputFile(const std::string& fileName)
    : Name(fileName)
    , Size(fileSize(fileName))
  {
    // What is read comes from all over the file, in pieces that fit.
    this->Stream.rdbuf()->pubsetbuf(nullptr, 0);
    this->Stream.open(fileName, std::ios::binary);
    if (!this->Stream)
    {
      throw Error(fileName + ": cannot be opened for reading");
    }
    // What most layouts are found by.
    constexpr Index HeadBytes = 1 << 12;
    std::string head(static_cast<std::size_t>(std::min(this->Size, HeadBytes)), '\0');
    this->readPlain(0, head.data(), static_cast<Index>(head.size()));
    this->Head = std::move(head);
  }

  const std::string& name() const { return this->Name; }
  Index size() const { return this->Size; }

  void read(Index offset, void* target, Index bytes)
  {
    if (this->Records.empty())
    {
      this->readPlain(offset, target, bytes);
      return;
    }
    auto record = std::upper_bound(
      this->Records.begin(), this->Records.end(), offset, [](Index value, const Record& r) { return value < r.start; });
    auto* to = static_cast<char*>(target);
    for (--record; bytes > 0; ++record)
    {
      const Index skipped = offset - record->start;
      const Index part = record + 1 == this->Records.end() ? bytes : std::min(bytes, record[1].start - offset);
      this->readPlain(record->place + skipped, to, part);
      to += part;
      offset += part;
      bytes -= part;
    }
  }

  /// Makes one stream of the contents of all records, whatever their number, if the whole file is a chain of them: from
  /// then on there are no markers. Of a record that is too long for its marker there are several, whose markers are
  /// negative where others follow or precede. @param valueAt(offset) a marker
  template <typename ValueAt>
  bool joinRecords(Index marker, const ValueAt& valueAt, const Execution& run)
  {
    // A file of zeros is a chain of nothing.
    constexpr Index MostEmpty = 1000;
    constexpr Index Often = 1 << 12;
    std::vector<Record> records;
    Index content = 0;
    Index empty = 0;
    for (Index at = 0; at < this->Size;)
    {
      if (records.size() % Often == 0)
      {
        run.report(0.0);
      }
      if (this->Size - at < 2 * marker)
      {
        return false;
      }
      const Index bytes = std::abs(valueAt(at));
      if (bytes > this->Size - at - 2 * marker || std::abs(valueAt(at + marker + bytes)) != bytes)
      {
        return false;
      }
      if (bytes > 0)
      {
        records.push_back({ content, at + marker });
      }
      else if (++empty > MostEmpty)
      {
        return false;
      }
      content += bytes;
      at += bytes + 2 * marker;
    }
    if (records.empty())
    {
      return false;
    }
    this->Records = std::move(records);
    this->Size = content;
    return true;
  }

private:
  void readPlain(Index offset, void* target, Index bytes)
  {
    if (offset >= 0 && offset + bytes <= static_cast<Index>(this->Head.size()))
    {
      this->Head.copy(static_cast<char*>(target), static_cast<std::size_t>(bytes), static_cast<std::size_t>(offset));
      return;
    }
    this->Stream.seekg(offset);
    this->Stream.read(static_cast<char*>(target), bytes);
    if (this->Stream.gcount() != bytes || !this->Stream)
    {
      this->Stream.clear();
      throw Error(this->Name + ": reading " + std::to_string(bytes) + " bytes at offset " + std::to_string(offset) +
        " failed, the file has " + std::to_string(this->Size));
    }
  }

public:
  /// The first bytes, or all if there are fewer.
  std::string start(Index bytes, Index from = 0)
  {
    std::string content(static_cast<std::size_t>(std::min(bytes, this->Size - from)), '\0');
    this->read(from, content.data(), static_cast<Index>(content.size()));
    return content;
  }

  /// Where the text of an ASCII file starts: behind a byte order mark.
  Index textStart() { return this->start(3) == "\xef\xbb\xbf" ? 3 : 0; }

private:
  struct Record
  {
    /// Of its content, in that of all records and in the file.
    Index start;
    Index place;
  };

  std::string Name;
  Index Size;
  std::ifstream Stream;
  /// The first bytes of the file.
  std::string Head;
  std::vector<Record> Records;
};

/// A binary file starts with counts of 4 or 8 bytes below 2^24 or with such a record marker: there is a zero byte
/// among them.
bool isText(InputFile& file)
{
  const std::string start = file.start(8, file.textStart());
  return std::all_of(
    start.begin(), start.end(), [](char c) { return (c >= ' ' && c <= '~') || c == '\t' || c == '\n' || c == '\r'; });
}

//----------------------------------------------------------------------------------------------------------------------
// ASCII

/// Values of Fortran list-directed text: a whole file, read part by part, or its first bytes.
class ListReader
{
public:
  explicit ListReader(InputFile& file, const Execution& run = {})
    : ListReader(file, file.size() - file.textStart(), run)
  {
  }
  /// @param run is asked whether to stop after each part
  ListReader(InputFile& file, Index bytes, const Execution& run = {})
    : File(file)
    , Run(run)
    , Offset(file.textStart())
    , Remaining(bytes)
    , Buffer(static_cast<std::size_t>(std::min(bytes, Index(1) << 20)))
    , At(Buffer.data())
    , End(At)
  {
    this->refill();
  }
  ListReader(const ListReader&) = delete;
  ListReader& operator=(const ListReader&) = delete;

  /// How many values there are from here to the end, repeats multiplied out.
  Index countValues()
  {
    Index count = 0;
    while (this->fetch())
    {
      count = saturatingSum(count, this->Repeat);
    }
    return count;
  }

  /// Checks that all values from here to the end are numbers.
  void checkNumbers()
  {
    this->Context.clear();
    while (this->fetch())
    {
      this->parseReal();
    }
  }

  double real()
  {
    if (this->Repeat == 0)
    {
      this->require();
      this->Real = this->parseReal();
    }
    --this->Repeat;
    return this->Real;
  }

  /// Leaves out values, which need not be numbers.
  void skip(Index count)
  {
    while (count > 0)
    {
      if (this->Repeat == 0)
      {
        this->require();
      }
      const Index taken = std::min(count, this->Repeat);
      count -= taken;
      this->Repeat -= taken;
    }
    if (this->Repeat > 0)
    {
      // A repeat that the next block begins with.
      this->Real = this->parseReal();
    }
  }

  int integer()
  {
    if (this->Repeat == 0)
    {
      this->require();
      const char* begin = this->Value + (*this->Value == '+');
      const auto [end, failure] = std::from_chars(begin, this->ValueEnd, this->Integer);
      if (failure != std::errc() || end != this->ValueEnd)
      {
        this->fail("'" + this->shown() + "' is not an integer of 4 bytes");
      }
    }
    --this->Repeat;
    return this->Integer;
  }

  /// The next value is of the other type: a repeat may not run across.
  void switchType()
  {
    if (this->Repeat != 0)
    {
      this->fail("the repeat of '" + this->shown() + "' runs on into values of another kind");
    }
  }

  /// Names the line of the value read last.
  [[noreturn]] void fail(const std::string& what) const
  {
    throw Error(this->File.name() + ", line " + std::to_string(this->line()) +
      (this->Context.empty() ? "" : " (" + this->Context + ")") + ": " + what);
  }

  /// Line of the value read last, from 1.
  Index line() const
  {
    const char* begin = this->Buffer.data();
    const char* last = this->Value == this->End && this->End != begin ? this->End - 1 : this->Value;
    return 1 + this->LinesBefore + std::count(begin, last, '\n');
  }

  /// What is being read, for error messages.
  std::string Context = "header";

private:
  /// Longest text of a number.
  static constexpr int MaxValue = 1000;

  static bool isBlank(char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; }
  static bool isExponent(char c) { return c == 'd' || c == 'D' || c == 'q' || c == 'Q' || c == '+' || c == '-'; }

  /// The value as it stands in the file, cut to a readable length.
  std::string shown() const
  {
    std::string text(this->Value, std::min<std::size_t>(this->ValueEnd - this->Value, 40));
    std::replace_if(
      text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
    return text;
  }

  void require()
  {
    if (!this->fetch())
    {
      this->fail("the file ends too early");
    }
  }

  /// Reads on, and drops what lies before At.
  void refill()
  {
    this->Run.report(0.0);
    this->LinesBefore += std::count(static_cast<const char*>(this->Buffer.data()), this->At, '\n');
    const Index kept = std::copy(this->At, this->End, this->Buffer.data()) - this->Buffer.data();
    const Index added = std::min(this->Remaining, static_cast<Index>(this->Buffer.size()) - kept);
    this->File.read(this->Offset, this->Buffer.data() + kept, added);
    this->Offset += added;
    this->Remaining -= added;
    this->At = this->Buffer.data();
    this->End = this->At + kept + added;
  }
  /// Whether At is at the end of the text.
  bool atEnd()
  {
    if (this->At == this->End && this->Remaining > 0)
    {
      this->refill();
    }
    return this->At == this->End;
  }

  /// Finds the next value and its repeat count; false at the end of the text.
  bool fetch()
  {
    bool comma = false;
    for (; !this->atEnd() && (isBlank(*this->At) || *this->At == ','); ++this->At)
    {
      if (*this->At == ',' && comma)
      {
        this->Value = this->At;
        this->fail("a value is missing between two commas");
      }
      comma = comma || *this->At == ',';
    }
    this->Value = this->At;
    if (this->At == this->End)
    {
      return false;
    }
    const auto inValue = [&] { return this->At != this->End && !isBlank(*this->At) && *this->At != ','; };
    while (inValue())
    {
      ++this->At;
    }
    if (this->At == this->End && this->Remaining > 0)
    {
      // Longer than the buffer is no number.
      this->At = this->Value;
      this->refill();
      for (this->Value = this->At; inValue();)
      {
        ++this->At;
      }
    }
    this->ValueEnd = this->At;
    if (this->ValueEnd - this->Value > MaxValue)
    {
      this->fail(
        "'" + this->shown() + "' goes on for more than " + std::to_string(MaxValue) + " characters; no number does");
    }
    const char* star = std::find(this->Value, this->ValueEnd, '*');
    star = star == this->ValueEnd ? nullptr : star;
    this->Repeat = 1;
    if (star)
    {
      const auto [end, failure] = std::from_chars(this->Value, star, this->Repeat);
      if (failure != std::errc() || end != star || this->Repeat < 1 || star + 1 == this->ValueEnd)
      {
        this->fail("'" + this->shown() + "' is not a repeat count of at least 1, '*' and a value" +
          (this->shown()[0] == '*' ? "; Fortran writes stars for a number that does not fit its format" : ""));
      }
      this->Value = star + 1;
    }
    return true;
  }

  double parseReal() const
  {
    const char* begin = this->Value + (*this->Value == '+');
    double value = 0.0;
    auto [end, failure] = std::from_chars(begin, this->ValueEnd, value);
    if (failure == std::errc() && end != this->ValueEnd && isExponent(*end))
    {
      // Fortran's exponents: d or q for e, or no letter at all.
      std::string text(begin, end);
      text += 'e';
      text.append(*end == '+' || *end == '-' ? end : end + 1, this->ValueEnd);
      const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
      failure = result.ec;
      end = result.ptr == text.data() + text.size() ? this->ValueEnd : end;
    }
    if (failure == std::errc::result_out_of_range && end == this->ValueEnd)
    {
      if (std::find(begin + 1, this->ValueEnd, '-') != this->ValueEnd)
      {
        return 0.0; // below the smallest double
      }
      this->fail("'" + this->shown() + "' is out of the range of a double");
    }
    if (failure != std::errc() || end != this->ValueEnd)
    {
      this->fail("'" + this->shown() + "' is not a number");
    }
    if (!std::isfinite(value))
    {
      this->fail("'" + this->shown() + "' is not finite");
    }
    return value;
  }

  InputFile& File;
  const Execution Run;
  /// Where the text goes on that is not in the buffer, and how many bytes there are.
  Index Offset;
  Index Remaining;
  std::vector<char> Buffer;
  /// Line ends before the buffer.
  Index LinesBefore = 0;
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

/// Reads the header behind which `reader` stands at the first coordinate then.
std::vector<Ijk> readHeader(ListReader& reader, bool multiBlock, Index bytes)
{
  reader.Context = "header";
  const int blocks = multiBlock ? reader.integer() : 1;
  if (blocks < 1 || blocks > bytes)
  {
    reader.fail("the number of blocks is " + std::to_string(blocks));
  }
  std::vector<Ijk> counts;
  for (int b = 0; b < blocks; ++b)
  {
    reader.Context = "header, " + blockName(b);
    Ijk block;
    for (int& count : block)
    {
      count = reader.integer();
    }
    if (!positive(block))
    {
      reader.fail(blockName(b) + " has " + toString(block) + " points");
    }
    counts.push_back(block);
  }
  reader.switchType();
  reader.Context.clear();
  return counts;
}

//----------------------------------------------------------------------------------------------------------------------
// Other kinds of PLOT3D files

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

/// All but the second to last dimensions, which a function file follows with the number of variables.
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

/// What an ASCII file of `values` numbers is that is no grid; empty if no kind explains their number.
std::string otherKindOfText(InputFile& file, Index values, const Execution& run)
{
  for (const OtherKind& kind : otherKinds())
  {
    for (const bool multiBlock : { true, false })
    {
      if (kind.onlyInRecords)
      {
        continue;
      }
      try
      {
        ListReader reader(file, run);
        const int blocks = multiBlock ? reader.integer() : 1;
        Index needed = saturatingSum(multiBlock ? 1 : 0, saturatingProduct(kind.counts, blocks));
        bool possible = blocks >= 1 && needed < values;
        for (int b = 0; possible && b < blocks; ++b)
        {
          std::vector<Index> counts;
          for (int d = 0; d < kind.counts; ++d)
          {
            counts.push_back(reader.integer());
            possible = possible && counts.back() >= 1;
          }
          for (const Index record : possible ? kind.records(counts) : std::vector<Index>())
          {
            needed = saturatingSum(needed, record);
          }
        }
        if (possible && needed == values)
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

/// The file has not been read as what it is: says so if it is packed, or a text in an encoding of its own.
void refuseEncodings(InputFile& file)
{
  const std::string what = otherEncoding(file.start(6));
  if (!what.empty())
  {
    throw Error(file.name() + ": the file is " + what);
  }
}

Plot3DLayout asciiLayout(InputFile& file, const Plot3DOptions& options, const Execution& run)
{
  ListReader all(file, run);
  const Index values = all.countValues();
  const Index lines = all.line();
  const std::size_t firstLine = file.start(1 << 10, file.textStart()).find('\n');
  const bool threeFirst =
    firstLine != std::string::npos && ListReader(file, static_cast<Index>(firstLine)).countValues() == 3;

  Plot3DLayout layout;
  static_cast<Plot3DOptions&>(layout) = options;
  layout.format = Plot3DFormat::Ascii;
  layout.realType = RealType::Double;
  layout.byteOrder = ByteOrder::LittleEndian;
  std::string failure;
  for (const bool multiBlock : { true, false })
  {
    // Of the two failures, tell the one that the first line suggests: users write three numbers there or one.
    const bool expected = multiBlock != threeFirst;
    layout.multiBlock = multiBlock;
    try
    {
      ListReader reader(file);
      layout.counts = readHeader(reader, multiBlock, file.size());
    }
    catch (const Error& error)
    {
      failure = expected ? error.what() : failure;
      continue;
    }
    const Index points = pointCount(layout.counts);
    const Index header = (multiBlock ? 1 : 0) + 3 * static_cast<Index>(layout.counts.size());
    std::string needs;
    for (const IBlank iblank : { IBlank::Absent, IBlank::Present })
    {
      if (options.iblank != IBlank::Automatic && options.iblank != iblank)
      {
        continue;
      }
      layout.iblank = iblank;
      const Index needed = saturatingSum(header, saturatingProduct(iblank == IBlank::Present ? 4 : 3, points));
      if (needed == values)
      {
        // Neighbours differ in a coordinate, so that repeats alone cannot make a mesh; they could make a huge array.
        if (points > file.size())
        {
          throw Error(file.name() + ": the header promises " + number(points) + " points, more than the " +
            std::to_string(file.size()) + " bytes of the file");
        }
        return layout;
      }
      needs += (needs.empty() ? "" : " or ") + number(needed) +
        (iblank == IBlank::Present ? " with iblank" : " without iblank");
    }
    const std::string mismatch = file.name() + ": the header promises " + describe(layout.counts) + ", that is " +
      needs + " numbers, but the file has " + number(values) + ", down to line " + std::to_string(lines);
    failure = expected ? mismatch : failure;
  }
  // A word instead of a number, or a missing blank, is the better explanation.
  ListReader(file, run).checkNumbers();
  const std::string other = otherKindOfText(file, values, run);
  throw Error(other.empty() ? failure : file.name() + ": " + other);
}

void readAscii(
  InputFile& file, const Plot3DLayout& layout, std::vector<GridBlock>& blocks, const Piece& piece, const Execution& run)
{
  ListReader reader(file);
  readHeader(reader, layout.multiBlock, file.size());
  const Index total = pointCount(layout.counts) * (layout.iblank == IBlank::Present ? 4 : 3);
  Index done = 0;
  // next(begin, end) reads these values.
  const auto read = [&](const std::string& what, const GridBlock& block, const auto& next) {
    reader.Context = block.name + ", " + what;
    constexpr Index Grain = 1 << 16;
    const Index size = block.size();
    for (Index begin = 0; begin < size; begin += Grain)
    {
      const Index end = std::min(size, begin + Grain);
      next(begin, end);
      done += end - begin;
      run.report(double(done) / double(total));
    }
  };
  const auto skip = [&](Index begin, Index end) { reader.skip(end - begin); };
  for (GridBlock& block : blocks)
  {
    const bool own = block.piece == piece.number;
    if (own)
    {
      block.allocate(false);
    }
    for (int axis = 0; axis < 3; ++axis)
    {
      const std::string what(1, "xyz"[axis]);
      double* values = own ? block.doubles.get() + axis : nullptr;
      own ? read(what, block,
              [&](Index begin, Index end) {
                for (Index p = begin; p < end; ++p)
                {
                  values[3 * p] = reader.real();
                }
              })
          : read(what, block, skip);
    }
    if (layout.iblank == IBlank::Present)
    {
      reader.switchType();
      block.iblank = own ? BlockMemory().array<int>(block.size()) : nullptr;
      own ? read("iblank", block,
              [&](Index begin, Index end) {
                for (Index p = begin; p < end; ++p)
                {
                  block.iblank[p] = reader.integer();
                }
              })
          : read("iblank", block, skip);
      reader.switchType();
    }
  }
}

//----------------------------------------------------------------------------------------------------------------------
// Binary

template <typename Value>
Value swapBytes(Value value)
{
  static_assert(sizeof(Value) == 4 || sizeof(Value) == 8, "4 or 8 bytes");
  if constexpr (sizeof(Value) == 4)
  {
    std::uint32_t bits;
    std::memcpy(&bits, &value, 4);
    bits = __builtin_bswap32(bits);
    std::memcpy(&value, &bits, 4);
  }
  else
  {
    std::uint64_t bits;
    std::memcpy(&bits, &value, 8);
    bits = __builtin_bswap64(bits);
    std::memcpy(&value, &bits, 8);
  }
  return value;
}

bool isForeign(ByteOrder order)
{
  const std::uint16_t one = 1;
  unsigned char first;
  std::memcpy(&first, &one, 1);
  return (order == ByteOrder::LittleEndian) != (first == 1);
}

template <typename Value>
Value readValue(InputFile& file, Index offset, ByteOrder order)
{
  Value value;
  file.read(offset, &value, sizeof(Value));
  return isForeign(order) ? swapBytes(value) : value;
}

/// Of the markers that are seen.
Index markerSize(const Plot3DLayout& layout)
{
  return layout.joined                         ? 0
    : layout.format == Plot3DFormat::Fortran   ? 4
    : layout.format == Plot3DFormat::Fortran64 ? 8
                                               : 0;
}

bool joinRecords(InputFile& file, Plot3DFormat format, ByteOrder order, const Execution& run)
{
  const Index marker = format == Plot3DFormat::Fortran ? 4 : 8;
  return file.joinRecords(
    marker,
    [&](Index at) {
      return marker == 4 ? Index(readValue<std::int32_t>(file, at, order)) : readValue<std::int64_t>(file, at, order);
    },
    run);
}

/// Bytes of a block's values.
Index blockSize(const Plot3DLayout& layout, const Ijk& counts)
{
  return saturatingProduct(pointCount(counts),
    (layout.realType == RealType::Float ? 12 : 24) + (layout.iblank == IBlank::Present ? layout.integerSize : 0));
}

/// Where the first block's values (or the marker before them) start.
Index headerSize(const Plot3DLayout& layout)
{
  const Index marker = markerSize(layout);
  return (layout.multiBlock ? layout.integerSize + 2 * marker : 0) +
    3 * layout.integerSize * static_cast<Index>(layout.counts.size()) + 2 * marker;
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

std::vector<Index> readIntegers(InputFile& file, Index offset, Index count, const Plot3DLayout& layout)
{
  std::vector<Index> values(static_cast<std::size_t>(count));
  const bool swap = isForeign(layout.byteOrder);
  if (layout.integerSize == 8)
  {
    file.read(offset, values.data(), 8 * count);
    for (Index& value : values)
    {
      value = swap ? swapBytes(value) : value;
    }
    return values;
  }
  std::vector<std::int32_t> words(values.size());
  file.read(offset, words.data(), 4 * count);
  std::transform(words.begin(), words.end(), values.begin(),
    [swap](std::int32_t word) { return Index(swap ? swapBytes(word) : word); });
  return values;
}

Index readInteger(InputFile& file, Index offset, const Plot3DLayout& layout)
{
  return readIntegers(file, offset, 1, layout)[0];
}

/// How far an interpretation of the header got.
enum Progress
{
  Nothing,
  BlockCount,      ///< the number of blocks could be right
  Header,          ///< all numbers could be right
  Marker,          ///< a pair of record markers is right
  HeaderInMarkers, ///< all numbers could be right and all record markers are
};

/// Why an interpretation was given up; those that got farthest explain the file best.
struct Failure
{
  Progress progress = Nothing;
  std::string text;
};

/// Whether the markers around a record of `bytes`, which starts at `offset`, say so. @param[out] at, found the one that
/// does not, unless it lies behind the end of the file
bool isRecord(InputFile& file, const Plot3DLayout& layout, Index offset, Index bytes, Index& at, Index& found)
{
  const Index marker = markerSize(layout);
  for (const Index place : { offset, offset + marker + bytes })
  {
    at = place;
    if (at + marker > file.size())
    {
      return false;
    }
    found = marker == 4 ? Index(readValue<std::int32_t>(file, at, layout.byteOrder))
                        : readValue<std::int64_t>(file, at, layout.byteOrder);
    if (found != bytes)
    {
      return false;
    }
  }
  return true;
}

bool isRecord(InputFile& file, const Plot3DLayout& layout, Index offset, Index bytes)
{
  Index at = 0;
  Index found = 0;
  return isRecord(file, layout, offset, bytes, at, found);
}

/// What is wrong with the markers around a record; empty if nothing is.
std::string recordFault(InputFile& file, const Plot3DLayout& layout, Index offset, Index bytes, const std::string& what)
{
  Index at = 0;
  Index found = 0;
  if (isRecord(file, layout, offset, bytes, at, found))
  {
    return {};
  }
  if (at + markerSize(layout) > file.size())
  {
    return "the record marker of the " + what + " at offset " + std::to_string(at) +
      " lies behind the end of the file (" + std::to_string(file.size()) + " bytes)";
  }
  return "the record marker at offset " + std::to_string(at) + " is " + std::to_string(found) + ", not the " +
    std::to_string(bytes) + " bytes of the " + what;
}

/// Reads the points per direction of the blocks for the format, order and multiBlock given. Most of the layouts that
/// are tried are wrong, so that this is told by the result.
/// @param[out] progress how much of the header was believable.
/// @return what is wrong, without the file's name; empty if nothing is
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
    blocks = readInteger(file, marker, layout);
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

/// What is wrong if the blocks do not fill the file, for a complete layout; without the file's name.
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
    if (marker != 0 && !isRecord(file, layout, offset, bytes))
    {
      return recordFault(file, layout, offset, bytes, "coordinates of " + blockName(b));
    }
    offset += bytes + 2 * marker;
  }
  return offset == file.size()
    ? std::string()
    : std::to_string(file.size() - offset) + " bytes follow the last block, from offset " + std::to_string(offset);
}

/// Whether the first coordinates look like numbers that someone wrote: neither NaN nor of absurd size.
bool believable(InputFile& file, const Plot3DLayout& layout)
{
  const Index offset = headerSize(layout) + markerSize(layout);
  const bool isFloat = layout.realType == RealType::Float;
  const Index count = std::min<Index>(1000, 3 * pointCount(layout.counts[0]));
  for (Index i = 0; i < count; ++i)
  {
    const double x = std::abs(isFloat ? readValue<float>(file, offset + 4 * i, layout.byteOrder)
                                      : readValue<double>(file, offset + 8 * i, layout.byteOrder));
    if (!(x == 0.0 || (x > 1e-30 && x < 1e30)))
    {
      return false;
    }
  }
  return true;
}

/// The first 8 bytes of the file.
std::string hexadecimal(InputFile& file)
{
  std::string text;
  for (const char c : file.start(8))
  {
    char byte[4];
    std::snprintf(byte, sizeof(byte), "%02x ", static_cast<unsigned char>(c));
    text += byte;
  }
  text.pop_back();
  return text;
}

/// The values of an option to try.
template <typename Option>
std::vector<Option> choices(Option given, std::vector<Option> all)
{
  return given == Option::Automatic ? all : std::vector<Option>{ given };
}

/// Calls visit(layout, progress, what is wrong) for every header that the options allow.
template <typename Visit>
void forEachBinaryHeader(InputFile& file, const Plot3DOptions& options, const Visit& visit)
{
  for (const Plot3DFormat format :
    choices(options.format, { Plot3DFormat::Binary, Plot3DFormat::Fortran, Plot3DFormat::Fortran64 }))
  {
    for (const ByteOrder order : choices(options.byteOrder, { ByteOrder::LittleEndian, ByteOrder::BigEndian }))
    {
      for (const int kind : { 0, 1, 2, 3 })
      {
        Plot3DLayout layout;
        static_cast<Plot3DOptions&>(layout) = options;
        layout.format = format;
        layout.byteOrder = order;
        layout.multiBlock = kind % 2 == 0;
        layout.integerSize = kind < 2 ? 4 : 8;
        Progress progress = Nothing;
        const std::string fault = readHeader(file, layout, progress);
        visit(layout, progress, fault);
      }
    }
  }
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
    if (marker != 0 && !isRecord(file, layout, offset, bytes))
    {
      return false;
    }
    offset += bytes + 2 * marker;
  }
  return offset == file.size();
}

/// What a binary file is that is no grid; empty if no kind explains its size.
/// @param records whether it has record markers: then a size that fits without them is a coincidence
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
        const Index marker = markerSize(layout);
        const Index size = layout.integerSize;
        if (marker == 0 && (records || kind.onlyInRecords))
        {
          continue;
        }
        if (layout.multiBlock && marker + size > file.size())
        {
          continue;
        }
        const Index blocks = layout.multiBlock ? readInteger(file, marker, layout) : 1;
        const Index offset = layout.multiBlock ? size + 2 * marker : 0;
        if (blocks < 1 || blocks > file.size() / (size * kind.counts))
        {
          continue;
        }
        const Index bytes = size * kind.counts * blocks;
        if (offset + marker + bytes > file.size() || (marker != 0 && !isRecord(file, layout, offset, bytes)))
        {
          continue;
        }
        const std::vector<Index> header = readIntegers(file, offset + marker, kind.counts * blocks, layout);
        std::vector<Index> lengths;
        bool possible = std::all_of(header.begin(), header.end(), [](Index count) { return count >= 1; });
        // Three planes look like three coordinates.
        bool told = !kind.onlyInRecords;
        for (std::size_t at = 2; at < header.size(); at += kind.counts)
        {
          told = told || header[at] != 3;
        }
        possible = possible && told;
        for (auto at = header.begin(); possible && at != header.end(); at += kind.counts)
        {
          const std::vector<Index> counts(at, at + kind.counts);
          // Each kind has a value of 4 bytes or more for each.
          possible = product(counts, counts.size()) <= file.size() / 4;
          const std::vector<Index> own = possible ? kind.records(counts) : std::vector<Index>();
          lengths.insert(lengths.end(), own.begin(), own.end());
          possible = possible && static_cast<Index>(lengths.size()) <= file.size() / 4;
        }
        const int dims = kind.counts == 2 ? 2 : 3;
        for (const bool iblank : { false, true })
        {
          if (possible && fillFile(file, layout, offset + bytes + 2 * marker, lengths, iblank, dims))
          {
            return std::string("the file is ") + kind.text;
          }
        }
      }
    }
  }
  return {};
}

/// The layout of a file whose records are others than usual, such as one per coordinate, or parts of a long one.
std::optional<Plot3DLayout> joinedLayout(
  const std::string& fileName, const Plot3DOptions& options, const Execution& run)
{
  for (const Plot3DFormat format : choices(options.format, { Plot3DFormat::Fortran, Plot3DFormat::Fortran64 }))
  {
    for (const ByteOrder order : choices(options.byteOrder, { ByteOrder::LittleEndian, ByteOrder::BigEndian }))
    {
      InputFile file(fileName);
      if (format == Plot3DFormat::Binary || format == Plot3DFormat::Ascii || !joinRecords(file, format, order, run))
      {
        continue;
      }
      Plot3DOptions content = options;
      content.format = Plot3DFormat::Binary;
      content.byteOrder = order;
      std::optional<Plot3DLayout> found;
      forEachBinaryHeader(file, content, [&](Plot3DLayout& layout, Progress, const std::string& fault) {
        for (const RealType real : choices(options.realType, { RealType::Float, RealType::Double }))
        {
          for (const IBlank iblank : choices(options.iblank, { IBlank::Absent, IBlank::Present }))
          {
            layout.realType = real;
            layout.iblank = iblank;
            if (fault.empty() && !found && blocksFault(file, layout).empty() && believable(file, layout))
            {
              found = layout;
            }
          }
        }
      });
      if (found)
      {
        found->format = format;
        found->joined = true;
        return found;
      }
    }
  }
  return {};
}

Plot3DLayout binaryLayout(InputFile& file, const Plot3DOptions& options, const Execution& run)
{
  std::vector<Plot3DLayout> fitting;
  std::vector<Failure> failures;
  const auto fail = [&](const Plot3DLayout& layout, Progress progress, const std::string& text) {
    failures.push_back(
      { progress, layoutName(layout) + (layout.multiBlock ? "" : ", without a number of blocks") + ": " + text });
  };
  forEachBinaryHeader(file, options, [&](Plot3DLayout& layout, Progress progress, const std::string& fault) {
    if (!fault.empty())
    {
      fail(layout, progress, fault);
      return;
    }
    std::string reasons;
    for (const RealType real : choices(options.realType, { RealType::Float, RealType::Double }))
    {
      for (const IBlank iblank : choices(options.iblank, { IBlank::Absent, IBlank::Present }))
      {
        layout.realType = real;
        layout.iblank = iblank;
        const std::string reason = blocksFault(file, layout);
        if (reason.empty())
        {
          fitting.push_back(layout);
        }
        else
        {
          reasons += std::string(reasons.empty() ? "" : "; ") + (real == RealType::Float ? "float" : "double") +
            (iblank == IBlank::Present ? " with" : " without") + " iblank: " + reason;
        }
      }
    }
    fail(layout, progress, describe(layout.counts) + ": " + reasons);
  });

  int farthest = Nothing;
  for (const Failure& failure : failures)
  {
    farthest = std::max<int>(farthest, failure.progress);
  }
  if (options.format == Plot3DFormat::Automatic && farthest >= Marker)
  {
    // Record markers are hardly a coincidence, a size that fits may be one.
    fitting.erase(std::remove_if(fitting.begin(), fitting.end(),
                    [&](const Plot3DLayout& layout) {
                      return layout.format == Plot3DFormat::Binary &&
                        (farthest == HeaderInMarkers || !believable(file, layout));
                    }),
      fitting.end());
  }
  if (!fitting.empty())
  {
    const auto best = std::find_if(fitting.begin(), fitting.end(),
      [&](const Plot3DLayout& layout) { return fitting.size() == 1 || believable(file, layout); });
    return best != fitting.end() ? *best : fitting.front();
  }
  const std::string other = otherKindOfBinary(file, farthest >= Marker);
  if (!other.empty())
  {
    throw Error(file.name() + ": " + other);
  }
  const std::optional<Plot3DLayout> joined = joinedLayout(file.name(), options, run);
  if (joined)
  {
    return *joined;
  }
  std::string text = file.name() + ": no PLOT3D layout explains the file of " + std::to_string(file.size()) +
    " bytes. Tried were all combinations of format, byte order, precision and iblank that the properties leave open. ";
  if (farthest == Nothing)
  {
    throw Error(text + "In none of them does the header make sense; the first 8 bytes are " + hexadecimal(file));
  }
  text += "The best explanations failed so:";
  for (const Failure& failure : failures)
  {
    text += failure.progress >= (farthest >= Marker ? Marker : BlockCount) ? " [" + failure.text + "]" : "";
  }
  throw Error(text);
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
      const auto store = [&](Index p, Index value) { block.iblank[p] = static_cast<int>(value); };
      layout.integerSize == 8 ? readArray<Index>(file, at, size, layout.byteOrder, store, report)
                              : readArray<int>(file, at, size, layout.byteOrder, store, report);
    }
    checkFinite(file.name(), block);
  }
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

/// Planes format has the size of whole format: it shows in a mesh that is tangled one way and sound the other way.
void refusePlanes(const std::string& fileName, const GridBlock& block)
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
  if (minorityOfSigns(counts, whole) > 0.1 && minorityOfSigns(counts, planes) < 0.01)
  {
    throw Error(fileName + ": the file is " + otherKinds().back().text);
  }
}

} // namespace

std::string Plot3DLayout::description() const
{
  std::string text = layoutName(*this);
  if (this->format != Plot3DFormat::Ascii)
  {
    text += this->realType == RealType::Float ? ", float" : ", double";
  }
  return text + (this->iblank == IBlank::Present ? ", with iblank" : ", without iblank");
}

Plot3DLayout plot3DLayout(const std::string& fileName, const Plot3DOptions& options, const Execution& run)
{
  InputFile file(fileName);
  refuseEncodings(file);
  const bool ascii = options.format == Plot3DFormat::Automatic ? isText(file) : options.format == Plot3DFormat::Ascii;
  Plot3DLayout layout = ascii ? asciiLayout(file, options, run) : binaryLayout(file, options, run);
  for (std::size_t b = 0; b < layout.counts.size(); ++b)
  {
    const Ijk& counts = layout.counts[b];
    if (*std::min_element(counts.begin(), counts.end()) < 2)
    {
      throw Error(fileName + ": " + blockName(b) + " is a surface (a two-dimensional grid) of " + toString(counts) +
        " points; hexahedra need at least 2 points in each direction");
    }
  }
  return layout;
}

bool looksLikePlot3D(const std::string& fileName)
{
  try
  {
    InputFile file(fileName);
    if (isText(file))
    {
      // Enough for the header of any number of blocks that people have.
      for (const bool multiBlock : { true, false })
      {
        try
        {
          ListReader reader(file, std::min<Index>(file.size() - file.textStart(), 1 << 20));
          readHeader(reader, multiBlock, file.size());
          return true;
        }
        catch (const Error&)
        {
        }
      }
      return false;
    }
    bool found = false;
    forEachBinaryHeader(file, {}, [&](const Plot3DLayout& layout, Progress progress, const std::string&) {
      found = found || progress >= Marker || (progress == Header && pointCount(layout.counts) <= file.size() / 3);
    });
    return found;
  }
  catch (const std::exception&)
  {
    return false;
  }
}

std::vector<GridBlock> readPlot3D(
  const std::string& fileName, const Plot3DLayout& layout, const Execution& run, const Piece& piece)
{
  InputFile file(fileName);
  if (layout.joined && !joinRecords(file, layout.format, layout.byteOrder, run))
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
        refusePlanes(fileName, *own);
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
