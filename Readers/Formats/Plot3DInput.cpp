// SPDX-License-Identifier: BSD-3-Clause
// A PLOT3D file as a sequence of bytes: plain, or the joined contents of Fortran records.
#include "Formats/Plot3DSyntax.h"

#include "IO/Encodings.h"
#include "IO/RegularFile.h"

#include <algorithm>
#include <limits>

namespace bsv::plot3d
{

namespace
{

constexpr Index Huge = std::numeric_limits<Index>::max();

Index fileSize(const std::string& fileName)
{
  requireRegularFile(fileName);
  std::error_code failure;
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

} // namespace

Index saturatingProduct(Index a, Index b)
{
  return b != 0 && a > Huge / b ? Huge : a * b;
}

Index saturatingSum(Index a, Index b)
{
  return a > Huge - b ? Huge : a + b;
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

std::string number(Index value)
{
  return value == Huge ? "more than 9e18" : std::to_string(value);
}

std::string blockName(std::size_t block)
{
  return "block " + std::to_string(block + 1);
}

std::string describe(const std::vector<Ijk>& counts)
{
  std::string text = std::to_string(counts.size()) + (counts.size() == 1 ? " block (" : " blocks (");
  for (std::size_t b = 0; b < std::min<std::size_t>(counts.size(), 3); ++b)
  {
    text += (b == 0 ? "" : ", ") + toString(counts[b]);
  }
  return text + (counts.size() > 3 ? ", .. points)" : " points)");
}

bool positive(const Ijk& counts)
{
  return std::all_of(counts.begin(), counts.end(), [](int n) { return n >= 1; });
}

InputFile::InputFile(const std::string& fileName)
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
  constexpr Index HeadBytes = 1 << 12;
  this->Head = this->start(HeadBytes);
}

void InputFile::read(Index offset, void* target, Index bytes)
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

bool InputFile::joinRecords(Plot3DFormat format, ByteOrder order, const Execution& run)
{
  const Index marker = format == Plot3DFormat::Fortran ? 4 : 8;
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
    // Negative in a part that another one follows; compared before its sign is dropped, which the lowest number has no
    // room for.
    const Index first = readMarker(*this, at, marker, order);
    const Index most = this->Size - at - 2 * marker;
    if (first > most || first < -most)
    {
      return false;
    }
    const Index bytes = std::abs(first);
    const Index last = readMarker(*this, at + marker + bytes, marker, order);
    if (last != bytes && last != -bytes)
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

std::string InputFile::start(Index bytes, Index from)
{
  std::string content(static_cast<std::size_t>(std::min(bytes, this->Size - from)), '\0');
  this->read(from, content.data(), static_cast<Index>(content.size()));
  return content;
}

TextStart InputFile::textStart()
{
  TextStart found;
  found.offset = startsWithMark(this->start(3)) ? 3 : 0;
  // No number begins so, and of a binary file one of the first bytes is zero, which no line of text has.
  constexpr Index LongestLine = 1 << 10;
  // So many are looked at, since whoever asks what a file is must not read all of it.
  constexpr Index MostComments = 1000;
  constexpr const char* Blanks = " \t\r\n";
  while (found.comments < MostComments)
  {
    const std::string text = this->start(LongestLine, found.offset);
    const std::size_t first = std::min(text.find_first_not_of(Blanks), text.size());
    const std::size_t end = std::min(text.find_first_of("\r\n", first), text.size());
    const auto isText = [](unsigned char c) { return c >= ' ' || c == '\t'; };
    if (first == text.size() || std::strchr("#!/%", text[first]) == nullptr || end == text.size() ||
      !std::all_of(
        text.begin() + static_cast<std::ptrdiff_t>(first), text.begin() + static_cast<std::ptrdiff_t>(end), isText))
    {
      break;
    }
    const std::size_t next = std::min(text.find_first_not_of(Blanks, end), text.size());
    found.offset += static_cast<Index>(next);
    found.lines += std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(next), '\n');
    ++found.comments;
  }
  return found;
}

void InputFile::readPlain(Index offset, void* target, Index bytes)
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

} // namespace bsv::plot3d
