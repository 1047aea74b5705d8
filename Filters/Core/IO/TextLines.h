// SPDX-License-Identifier: BSD-3-Clause
/// @file TextLines.h
/// Words and numbers of a text file, line by line, with messages that name file and line.
#pragma once

#include "Base/Types.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace bsv
{

/// Lines of a text file without comments (from `#` to the end of the line) and empty ones, and the words on them. Reads
/// the file in pieces, so that its size does not matter.
class TextLines
{
public:
  /// @throws Error if the file cannot be opened or is no regular file.
  explicit TextLines(const std::string& path);

  const std::string& path() const { return this->Path; }
  int line() const { return this->Line; }
  /// Bytes after the current line.
  Index remaining() const { return this->Remaining; }

  [[noreturn]] void fail(const std::string& what) const
  {
    throw Error(this->Path + ", line " + std::to_string(this->Line) + ": " + what);
  }

  /// Goes to the next line that holds anything; `expected` says in the message what should have come.
  void next(const char* expected);

  bool atEnd()
  {
    this->skipBlanks();
    return this->At == this->End;
  }

  /// Next word of the line, empty at its end.
  std::string_view word()
  {
    this->skipBlanks();
    const char* start = this->At;
    while (this->At != this->End && !isBlank(*this->At))
    {
      ++this->At;
    }
    return { start, static_cast<std::size_t>(this->At - start) };
  }

  /// The first word of the line without taking it.
  std::string_view peek()
  {
    const char* start = this->At;
    const std::string_view result = this->word();
    this->At = start;
    return result;
  }

  /// Takes the next word, which must be this one.
  void expect(std::string_view text);

  /// Nothing more may be on the line.
  void end();

  /// @name Numbers; `what` names them in messages
  ///@{
  int integer(const char* what, int first, int last) { return this->integer(this->word(), what, first, last); }

  int integer(std::string_view text, const char* what, int first, int last) const;

  double number(const char* what)
  {
    this->skipBlanks();
    double value = 0.0;
    const auto [stop, error] = std::from_chars(this->At, this->End, value);
    if (error != std::errc() || !std::isfinite(value) || (stop != this->End && !isBlank(*stop)))
    {
      this->fail(std::string(what) + ": finite number expected, '" + shown(this->word()) + "' found");
    }
    this->At = stop;
    return value;
  }
  ///@}

  /// The bytes that follow the current line.
  void raw(void* to, std::size_t size);

  /// Leaves out the bytes that follow the current line.
  void skipRaw(Index size);

  /// One word in which `%XX` stands for a byte, and "-" for an empty text.
  std::string name(const char* what);

private:
  static bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

  /// Text from the file as it can stand in a message.
  static std::string shown(std::string_view text);

  void skipBlanks()
  {
    while (this->At != this->End && isBlank(*this->At))
    {
      ++this->At;
    }
  }

  /// Of a byte order mark. @throws Error if the file is no plain text
  std::size_t markLength(const std::string& firstLine) const;

  /// Goes to the next line of the file; returns whether there is one.
  bool nextRaw();

  std::string Path;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> File;
  std::vector<char> Buffer;
  /// Bytes to read next: few where the next thing may be to leave out many.
  static constexpr std::size_t SmallestPortion = std::size_t(1) << 14;
  std::size_t Portion = SmallestPortion;
  std::size_t First = 0;
  std::size_t Last = 0;
  bool Finished = false;
  Index Remaining = 0;
  int Line = 0;
  const char* At = nullptr;
  const char* End = nullptr;
};

} // namespace bsv
