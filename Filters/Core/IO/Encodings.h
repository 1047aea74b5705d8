// SPDX-License-Identifier: BSD-3-Clause
/// @file Encodings.h
/// What files are instead of what they should be.
#pragma once

#include <string>
#include <utility>

namespace bsv
{

/// What a file is that starts like this, and what to do: packed, or a text in an encoding of its own. Empty for others.
/// Six bytes are enough.
inline std::string otherEncoding(const std::string& start)
{
  static const std::pair<std::string, const char*> encodings[] = {
    { "\xff\xfe", "a text in UTF-16; save it as plain ASCII or UTF-8" },
    { "\xfe\xff", "a text in UTF-16; save it as plain ASCII or UTF-8" },
    { "\x1f\x8b", "compressed (gzip); unpack it first" },
    { "BZh", "compressed (bzip2); unpack it first" },
    { std::string("\xfd"
                  "7zXZ"),
      "compressed (xz); unpack it first" },
    { "\x28\xb5\x2f\xfd", "compressed (zstd); unpack it first" },
    { "PK\x03\x04", "a zip archive; unpack it first" },
    { "7z\xbc\xaf\x27\x1c", "a 7-Zip archive; unpack it first" },
  };
  for (const auto& [mark, what] : encodings)
  {
    if (start.compare(0, mark.size(), mark) == 0)
    {
      return what;
    }
  }
  return {};
}

/// Whether a text starts with the byte order mark of UTF-8, three bytes that some editors write.
inline bool startsWithMark(const std::string& text)
{
  return text.rfind("\xef\xbb\xbf", 0) == 0;
}

} // namespace bsv
