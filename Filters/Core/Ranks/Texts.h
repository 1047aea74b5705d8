// SPDX-License-Identifier: BSD-3-Clause
/// @file Texts.h
/// Texts as letters, which ranks can send each other.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace bsv
{

/// Texts, none of which holds a zero, each with a zero behind it.
inline std::vector<char> lettersOf(const std::vector<std::string>& texts)
{
  std::vector<char> letters;
  for (const std::string& text : texts)
  {
    letters.insert(letters.end(), text.c_str(), text.c_str() + text.size() + 1);
  }
  return letters;
}

/// The texts of lettersOf(), also of several joined together.
inline std::vector<std::string> textsOf(const std::vector<char>& letters)
{
  std::vector<std::string> texts;
  for (auto at = letters.begin(); at != letters.end();)
  {
    const auto end = std::find(at, letters.end(), '\0');
    texts.emplace_back(at, end);
    at = end == letters.end() ? end : end + 1;
  }
  return texts;
}

} // namespace bsv
