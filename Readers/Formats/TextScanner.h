// SPDX-License-Identifier: BSD-3-Clause
/// @file TextScanner.h
/// Words and numbers of a text file, with line numbers for messages.
#pragma once

#include "Base/Types.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>

namespace bsv
{

/// The whole of a file, or its first bytes.
/// @throws Error if it cannot be read, is no regular file, or holds bytes that are 0, which no text does; Aborted
std::string readTextFile(
  const std::string& fileName, std::size_t most = std::numeric_limits<std::size_t>::max(), const Execution& run = {});

class TextScanner
{
public:
  /// @param comment a word that starts with it ends the line; 0: there are no comments.
  TextScanner(const std::string& text, const std::string& fileName, char comment = '\0')
    : At(text.data())
    , End(text.data() + text.size())
    , Comment(comment)
    , FileName(fileName)
  {
  }

  /// Reports the part of the text that was read, now and then. `run` must outlive the scanner.
  void reportTo(const Execution& run)
  {
    this->Run = &run;
    this->Start = this->NextReport = this->At;
  }

  /// Line, from 1, of what was read last.
  int line() const { return this->Line; }

  [[noreturn]] void failAt(int line, const std::string& what) const
  {
    throw Error(this->FileName + ", line " + std::to_string(line) + ": " + what);
  }
  [[noreturn]] void fail(const std::string& what) const { this->failAt(this->Line, what); }

  /// Moves to the next word. Returns whether there is none.
  bool atEnd();

  /// The rest of the current line without blanks at its ends, or the next line if nothing was read of it.
  std::string restOfLine();

  /// The next word, at most 40 characters of it. @param what it should be, for the message.
  std::string word(const char* what);
  /// The next word without reading it; empty at the end.
  std::string peek();

  template <typename Number>
  Number next(const char* what)
  {
    this->need(what);
    const char* end = this->wordEnd();
    Number value{};
    // from_chars knows no plus sign.
    const char* begin = *this->At == '+' ? this->At + 1 : this->At;
    const auto result = std::from_chars(begin, end, value);
    if (result.ec != std::errc() || result.ptr != end || !std::isfinite(static_cast<double>(value)))
    {
      this->fail("'" + this->peek() + "' is no " +
        (std::is_integral<Number>::value ? "whole number" : "finite number") + " (" + what + ")");
    }
    this->At = end;
    return value;
  }

  int integer(const char* what, int low, int high);

  /// @throws Error naming `what` if the rest of the file cannot hold so many numbers.
  void expect(double numbers, const char* what) const;

private:
  const char* wordEnd() const
  {
    return std::find_if(this->At, this->End, [](char c) { return c == ' ' || (c >= '\t' && c <= '\r'); });
  }
  void need(const char* what);
  void report();

  const char* At;
  const char* End;
  const Execution* Run = nullptr;
  const char* Start = nullptr;
  const char* NextReport = nullptr;
  int Line = 1;
  char Comment;
  std::string FileName;
};

} // namespace bsv
