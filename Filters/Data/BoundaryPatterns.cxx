// SPDX-License-Identifier: BSD-3-Clause
#include "Data/BoundaryPatterns.h"

#include <algorithm>
#include <cctype>

namespace bsv
{

namespace
{

/// Linear memory, no recursion.
bool matches(const std::string& pattern, const std::string& name)
{
  const auto same = [](char p, char c) {
    return p == '?' || std::tolower(static_cast<unsigned char>(p)) == std::tolower(static_cast<unsigned char>(c));
  };
  std::size_t p = 0;
  std::size_t n = 0;
  std::size_t star = std::string::npos;
  std::size_t resume = 0;
  while (n < name.size())
  {
    if (p < pattern.size() && pattern[p] == '*')
    {
      star = p++;
      resume = n;
    }
    else if (p < pattern.size() && same(pattern[p], name[n]))
    {
      ++p;
      ++n;
    }
    else if (star != std::string::npos)
    {
      p = star + 1;
      n = ++resume;
    }
    else
    {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == std::string::npos;
}

} // namespace

const BoundaryPatterns& defaultBodyBoundaries()
{
  static const BoundaryPatterns patterns{ "wall*", "bcwall*", "body*", "no*slip*", "viscous*", "solid*" };
  return patterns;
}

bool matchesAny(const BoundaryPatterns& patterns, const std::string& name)
{
  return std::any_of(
    patterns.begin(), patterns.end(), [&name](const std::string& pattern) { return matches(pattern, name); });
}

std::string quotedList(const std::vector<std::string>& names)
{
  std::string text;
  for (const std::string& name : names)
  {
    text += (text.empty() ? "'" : ", '") + name + "'";
  }
  return text.empty() ? "none" : text;
}

} // namespace bsv
