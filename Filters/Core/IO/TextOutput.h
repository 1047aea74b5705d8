// SPDX-License-Identifier: BSD-3-Clause
/// @file TextOutput.h
/// Text on its way to a file.
#pragma once

#include "IO/AtomicFile.h"

#include <charconv>
#include <string>

namespace bsv
{

/// Writes words and numbers to a file, in the C locale. Numbers are the shortest that read back to the same value.
class TextOutput
{
public:
  explicit TextOutput(OutputBuffer& file)
    : File(file)
  {
  }

  TextOutput& operator<<(const std::string& text)
  {
    this->File.write(text);
    return *this;
  }
  TextOutput& operator<<(Index value)
  {
    char* to = this->File.room(24);
    this->File.advance(std::to_chars(to, to + 24, value).ptr);
    return *this;
  }
  TextOutput& operator<<(int value)
  {
    char* to = this->File.room(16);
    this->File.advance(std::to_chars(to, to + 16, value).ptr);
    return *this;
  }
  /// Shortest digits that read back to the same value.
  TextOutput& operator<<(double value)
  {
    char* to = this->File.room(32);
    this->File.advance(std::to_chars(to, to + 32, value).ptr);
    return *this;
  }
  /// "x y z" and the end of the line.
  void point(const double* x)
  {
    char* to = this->File.room(100);
    for (int c = 0; c < 3; ++c)
    {
      to = std::to_chars(to, to + 32, x[c]).ptr;
      *to++ = c < 2 ? ' ' : '\n';
    }
    this->File.advance(to);
  }
  /// As they are in memory.
  void raw(const double* values, Index count)
  {
    this->File.write(reinterpret_cast<const char*>(values), sizeof(double) * static_cast<std::size_t>(count));
  }

private:
  OutputBuffer& File;
};

} // namespace bsv
