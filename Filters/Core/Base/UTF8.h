// SPDX-License-Identifier: BSD-3-Clause
/// @file UTF8.h
/// Texts that come out of files and go to users.
#pragma once

#include <cstddef>
#include <string>

namespace bsv
{

/// The text with a question mark for every byte that is not part of valid UTF-8, and for control characters.
inline std::string validUTF8(std::string text)
{
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  for (std::size_t i = 0; i < text.size();)
  {
    const unsigned char first = byte(i);
    const std::size_t length = first < 0x80 ? 1
      : first < 0xc2                        ? 0
      : first < 0xe0                        ? 2
      : first < 0xf0                        ? 3
      : first < 0xf5                        ? 4
                                            : 0;
    bool valid = length > 0 && i + length <= text.size();
    for (std::size_t k = 1; valid && k < length; ++k)
    {
      valid = (byte(i + k) & 0xc0) == 0x80;
    }
    // Overlong forms, surrogates and what lies beyond Unicode.
    valid = valid && !(first == 0xe0 && byte(i + 1) < 0xa0) && !(first == 0xed && byte(i + 1) > 0x9f) &&
      !(first == 0xf0 && byte(i + 1) < 0x90) && !(first == 0xf4 && byte(i + 1) > 0x8f);
    if (!valid || (length == 1 && ((first < ' ' && first != '\n' && first != '\t') || first == 0x7f)))
    {
      text[i] = '?';
      ++i;
      continue;
    }
    i += length;
  }
  return text;
}

} // namespace bsv
