// SPDX-License-Identifier: BSD-3-Clause
#include "Data/BoundaryPatterns.h"

#include "Conversion/Conversion.h"

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

const BoundaryPatterns& defaultSymmetryBoundaries()
{
  static const BoundaryPatterns patterns{ "sym*", "bcsym*" };
  return patterns;
}

bool matchesAny(const BoundaryPatterns& patterns, const std::string& name)
{
  return std::any_of(
    patterns.begin(), patterns.end(), [&name](const std::string& pattern) { return matches(pattern, name); });
}

bool selectsBoundary(const BoundaryPatterns& patterns, const BoundaryPatterns& defaults,
  const std::vector<std::string>& names, const std::vector<std::string>& types, int tag)
{
  const std::string type = tag < static_cast<int>(types.size()) ? types[tag] : "";
  const bool typed = !type.empty() && type != "BCTypeUserDefined" && type != "BCTypeNull" && type != "BCGeneral" &&
    type != "FamilySpecified";
  const auto isIn = [](const BoundaryPatterns& list, const std::string& pattern) {
    return std::find(list.begin(), list.end(), pattern) != list.end();
  };
  // A list without some of them was not extended but written: its patterns are meant as they are.
  const bool extended =
    std::all_of(defaults.begin(), defaults.end(), [&](const std::string& pattern) { return isIn(patterns, pattern); });
  return std::any_of(patterns.begin(), patterns.end(), [&](const std::string& pattern) {
    const bool byType = typed && extended && isIn(defaults, pattern);
    return (!byType && matches(pattern, names[tag])) || (typed && matches(pattern, type));
  });
}

bool isBodyBoundary(const BoundaryPatterns& patterns, const std::vector<std::string>& names,
  const std::vector<std::string>& types, int tag)
{
  return selectsBoundary(patterns, defaultBodyBoundaries(), names, types, tag);
}

std::vector<BoundaryRole> boundaryRoles(
  const BlockComplex& complex, const BoundaryPatterns& body, const BoundaryPatterns& symmetry)
{
  const std::vector<std::string>& names = complex.boundaryNames;
  std::vector<BoundaryRole> roles;
  for (int tag = 0; tag < static_cast<int>(names.size()); ++tag)
  {
    roles.push_back(isBodyBoundary(body, names, complex.boundaryTypes, tag) ? BoundaryRole::Body
        : selectsBoundary(symmetry, defaultSymmetryBoundaries(), names, complex.boundaryTypes, tag)
        ? BoundaryRole::Symmetry
        : BoundaryRole::Other);
  }
  return roles;
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
