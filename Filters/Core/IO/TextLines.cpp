// SPDX-License-Identifier: BSD-3-Clause
#include "IO/TextLines.h"

#include "IO/Encodings.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>

#include <sys/stat.h>

namespace bsv
{

namespace
{

/// @throws Error if opening the file could wait, or reading it would never end.
const std::string& checked(const std::string& path)
{
  struct stat status;
  if (::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode))
  {
    throw Error("Cannot read '" + path + "': it is not a regular file");
  }
  return path;
}

} // namespace

TextLines::TextLines(const std::string& path)
  : Path(checked(path))
  , File(std::fopen(path.c_str(), "rb"), &std::fclose)
{
  struct stat status;
  if (!this->File || ::fstat(::fileno(this->File.get()), &status) != 0)
  {
    throw Error("Cannot open '" + path + "': " + std::strerror(errno));
  }
  this->Remaining = status.st_size;
  // One byte more, so that the end is seen without a larger buffer.
  constexpr Index LargestStart = Index(1) << 20;
  this->Buffer.resize(static_cast<std::size_t>(std::min<Index>(this->Remaining + 1, LargestStart)));
}

void TextLines::next(const char* expected)
{
  do
  {
    if (!this->nextRaw())
    {
      if (this->Line == 0)
      {
        throw Error(this->Path + ": the file is empty");
      }
      this->fail(std::string("the file ends, but ") + expected + " should follow");
    }
    this->skipBlanks();
  } while (this->At == this->End);
}

void TextLines::expect(std::string_view text)
{
  const std::string_view found = this->word();
  if (found != text)
  {
    this->fail("'" + std::string(text) + "' expected, '" + shown(found) + "' found");
  }
}

void TextLines::end()
{
  if (!this->atEnd())
  {
    this->fail("nothing more expected, '" + shown(this->word()) + "' found");
  }
}

int TextLines::integer(std::string_view text, const char* what, int first, int last) const
{
  int value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || stop != text.data() + text.size())
  {
    this->fail(std::string(what) + ": integer expected, '" + shown(text) + "' found");
  }
  if (value < first || value > last)
  {
    this->fail(std::string(what) + " " + std::to_string(value) +
      (last < first ? ": there are none" : " is not in " + std::to_string(first) + ".." + std::to_string(last)));
  }
  return value;
}

void TextLines::raw(void* to, std::size_t size)
{
  char* bytes = static_cast<char*>(to);
  const std::size_t buffered = std::min(size, this->Last - this->First);
  std::memcpy(bytes, this->Buffer.data() + this->First, buffered);
  this->First += buffered;
  if (std::fread(bytes + buffered, 1, size - buffered, this->File.get()) != size - buffered)
  {
    if (std::ferror(this->File.get()))
    {
      throw Error("Cannot read '" + this->Path + "': " + std::strerror(errno));
    }
    this->fail("the file ends within binary numbers");
  }
  this->Remaining -= static_cast<Index>(size);
  // What was read of the line may have moved.
  this->At = this->End = nullptr;
}

void TextLines::skipRaw(Index size)
{
  if (size > this->Remaining)
  {
    this->fail("the file ends within binary numbers");
  }
  const Index buffered = std::min(size, static_cast<Index>(this->Last - this->First));
  this->First += static_cast<std::size_t>(buffered);
  if (size > buffered)
  {
    if (::fseeko(this->File.get(), size - buffered, SEEK_CUR) != 0)
    {
      throw Error("Cannot read '" + this->Path + "': " + std::strerror(errno));
    }
    this->Portion = SmallestPortion;
  }
  this->Remaining -= size;
  this->At = this->End = nullptr;
}

std::string TextLines::name(const char* what)
{
  const std::string_view text = this->word();
  if (text.empty())
  {
    this->fail(std::string(what) + " expected");
  }
  if (text == "-")
  {
    return "";
  }
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i)
  {
    if (text[i] != '%')
    {
      result += text[i];
      continue;
    }
    int byte = 0;
    const char* digits = text.data() + i + 1;
    const std::size_t left = text.size() - i - 1;
    if (left < 2 || std::from_chars(digits, digits + 2, byte, 16).ptr != digits + 2 || byte < 0)
    {
      this->fail(std::string(what) + ": '" + shown(text) + "' has a % without two hexadecimal digits");
    }
    result += static_cast<char>(byte);
    i += 2;
  }
  return result;
}

std::string TextLines::shown(std::string_view text)
{
  std::string result(text.substr(0, 40));
  for (char& c : result)
  {
    c = std::isprint(static_cast<unsigned char>(c)) ? c : '?';
  }
  return result + (text.size() > 40 ? ".." : "");
}

std::size_t TextLines::markLength(const std::string& firstLine) const
{
  const std::string what = otherEncoding(firstLine);
  if (!what.empty())
  {
    throw Error(this->Path + ": the file is " + what);
  }
  return startsWithMark(firstLine) ? 3 : 0;
}

bool TextLines::nextRaw()
{
  const char* data = this->Buffer.data();
  const char* newline = nullptr;
  std::size_t searched = 0;
  while (true)
  {
    const char* start = data + this->First;
    newline = static_cast<const char*>(std::memchr(start + searched, '\n', this->Last - this->First - searched));
    if (newline || this->Finished)
    {
      break;
    }
    searched = this->Last - this->First;
    std::memmove(this->Buffer.data(), start, searched);
    this->First = 0;
    this->Last = searched;
    if (this->Last == this->Buffer.size())
    {
      constexpr std::size_t LongestLine = std::size_t(1) << 26;
      if (this->Last >= LongestLine)
      {
        ++this->Line;
        this->fail("the line is longer than " + std::to_string(LongestLine) + " bytes");
      }
      this->Buffer.resize(2 * this->Last);
    }
    data = this->Buffer.data();
    const std::size_t read = std::fread(
      this->Buffer.data() + this->Last, 1, std::min(this->Portion, this->Buffer.size() - this->Last), this->File.get());
    this->Portion = std::min(2 * this->Portion, this->Buffer.size());
    this->Last += read;
    this->Finished = read == 0;
    if (std::ferror(this->File.get()))
    {
      throw Error("Cannot read '" + this->Path + "': " + std::strerror(errno));
    }
  }
  const char* start = data + this->First;
  const char* stop = newline ? newline : data + this->Last;
  if (!newline && start == stop)
  {
    return false;
  }
  const std::size_t taken = static_cast<std::size_t>(stop - start) + (newline ? 1 : 0);
  this->First += taken;
  this->Remaining -= static_cast<Index>(taken);
  ++this->Line;
  if (this->Line == 1)
  {
    constexpr std::size_t Enough = 8;
    start += this->markLength({ start, std::min(taken, Enough) });
  }
  const char* comment = static_cast<const char*>(std::memchr(start, '#', stop - start));
  this->At = start;
  this->End = comment ? comment : stop;
  return true;
}

} // namespace bsv
