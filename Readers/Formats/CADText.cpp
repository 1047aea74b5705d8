// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/CADText.h"

#include "IO/Encodings.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <utility>
#include <vector>

namespace bsv
{

namespace
{

[[noreturn]] void failAt(const std::string& fileName, std::size_t line, const std::string& what)
{
  throw Error(fileName + ", line " + std::to_string(line) + ": " + what);
}

std::size_t lineCount(const std::string& text)
{
  return 1 + static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

/// An instance of a STEP file: `#12 = KEYWORD(.. #13 ..);`, or several keywords for a complex one.
struct Instance
{
  long id = 0;
  std::vector<std::string> keywords;
  /// The entities that it refers to, and the lines where.
  std::vector<std::pair<long, std::size_t>> uses;
};

bool contains(const std::string& text, const char* part)
{
  return text.find(part) != std::string::npos;
}

bool endsWith(const std::string& text, const std::string& end)
{
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

/// Lists of items, some of which may be of no use: they count if one of their items does.
bool isList(const std::string& keyword)
{
  return endsWith(keyword, "REPRESENTATION") || endsWith(keyword, "GEOMETRIC_SET") ||
    endsWith(keyword, "GEOMETRIC_CURVE_SET");
}

/// What faces are made of, together with all that it refers to; and what says where they are and in which unit.
bool isShape(const std::string& keyword)
{
  if (contains(keyword, "STYLE") || contains(keyword, "RENDERING"))
  {
    return false;
  }
  for (const char* part : { "FACE", "SHELL", "_BREP", "_SURFACE", "SURFACE_", "PLANE", "REPRESENTATION_CONTEXT",
         "_UNIT", "TRANSFORMATION", "MAPPED_ITEM", "REPRESENTATION_MAP", "SURFACE_MODEL", "SOLID" })
  {
    if (contains(keyword, part))
    {
      return !isList(keyword);
    }
  }
  return false;
}

/// Cuts the text into its instances.
/// @throws Error for a string or comment without an end.
std::vector<Instance> instancesOf(const std::string& text, const std::string& fileName)
{
  std::vector<Instance> instances;
  Instance current;
  bool inStatement = false;
  std::size_t line = 1;
  for (std::size_t i = 0; i < text.size(); ++i)
  {
    const char c = text[i];
    if (c == '\n')
    {
      ++line;
    }
    else if (c == '\'' || text.compare(i, 2, "/*") == 0)
    {
      // Strings and comments say nothing.
      const std::size_t end = c == '\'' ? text.find('\'', i + 1) : text.find("*/", i + 2);
      if (end == std::string::npos)
      {
        failAt(fileName, line, "a string or comment does not end; the file is truncated or corrupt");
      }
      line += static_cast<std::size_t>(std::count(text.begin() + i, text.begin() + end, '\n'));
      i = end + (c == '\'' ? 0 : 1);
    }
    else if (c == ';')
    {
      instances.push_back(std::move(current));
      current = {};
      inStatement = false;
    }
    else if (c == '#')
    {
      char* end = nullptr;
      const long id = std::strtol(text.c_str() + i + 1, &end, 10);
      if (inStatement)
      {
        current.uses.emplace_back(id, line);
      }
      else
      {
        current.id = id;
        inStatement = true;
      }
      i = static_cast<std::size_t>(end - text.c_str()) - 1;
    }
    else if (std::isalpha(static_cast<unsigned char>(c)))
    {
      std::size_t end = i;
      while (end < text.size() && (std::isalnum(static_cast<unsigned char>(text[end])) || text[end] == '_'))
      {
        ++end;
      }
      // An enumeration value stands between dots.
      if (i == 0 || text[i - 1] != '.')
      {
        current.keywords.push_back(text.substr(i, end - i));
        for (char& letter : current.keywords.back())
        {
          letter = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
        }
      }
      i = end - 1;
      inStatement = true;
    }
    else if (!std::isspace(static_cast<unsigned char>(c)))
    {
      inStatement = true;
    }
  }
  if (!current.uses.empty())
  {
    instances.push_back(std::move(current));
  }
  return instances;
}

constexpr std::size_t CardSize = 80;
constexpr std::size_t SectionColumn = 72;

std::string upperCase(std::string text)
{
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

/// Where the text begins behind a byte order mark and, if there may be any, comments.
std::size_t beginOf(const std::string& text, bool comments)
{
  std::size_t at = startsWithMark(text) ? 3 : 0;
  for (;;)
  {
    at = std::min(text.find_first_not_of(" \t\r\n", at), text.size());
    if (!comments || text.compare(at, 2, "/*") != 0)
    {
      return at;
    }
    const std::size_t end = text.find("*/", at + 2);
    at = end == std::string::npos ? text.size() : end + 2;
  }
}

/// The first card begins at the first line that is not empty; blanks may be a part of it.
std::size_t beginOfCards(const std::string& text)
{
  const std::size_t first = beginOf(text, false);
  const std::size_t lineEnd = text.find_last_of("\r\n", first);
  const std::size_t mark = startsWithMark(text) ? 3 : 0;
  return first == 0 || lineEnd == std::string::npos || lineEnd > first ? mark : std::max(lineEnd + 1, mark);
}

std::string plainIGES(const std::string& text)
{
  std::string cards;
  cards.reserve(text.size());
  for (std::size_t at = beginOfCards(text); at < text.size();)
  {
    std::size_t end = std::min(text.find_first_of("\r\n", at), text.size());
    // Some programs write cards without line ends.
    const auto isCard = [&](std::size_t first) {
      return first + CardSize <= end && std::strchr("SGDPTsgdpt", text[first + SectionColumn]) != nullptr;
    };
    const bool glued = isCard(at) && isCard(at + CardSize);
    end = glued ? at + CardSize : end;
    std::string card = text.substr(at, end - at);
    if (card.size() > SectionColumn)
    {
      card[SectionColumn] = static_cast<char>(std::toupper(static_cast<unsigned char>(card[SectionColumn])));
    }
    cards += card + "\n";
    at = end;
    if (!glued && at < text.size())
    {
      at += text.compare(at, 2, "\r\n") == 0 ? 2 : 1;
    }
  }
  return cards;
}

std::string plainSTEP(const std::string& text)
{
  std::string plain = text.substr(beginOf(text, true));
  bool inString = false;
  for (char& c : plain)
  {
    inString = inString != (c == '\'');
    if (!inString)
    {
      c = c == '\t' ? ' ' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    }
  }
  return plain;
}

} // namespace

std::string formatOfCADText(const std::string& start)
{
  const std::string begin = upperCase(start.substr(beginOf(start, true), 32));
  const auto starts = [&](const char* word) { return begin.rfind(word, 0) == 0; };
  if (starts("ISO-10303-21"))
  {
    return "STEP";
  }
  if (starts("DBREP_DRAWABLESHAPE") || starts("CASCADE TOPOLOGY"))
  {
    return "BREP";
  }
  // The first card of an IGES file says S and 1 in its columns 73 to 80; C or B, and that is all, in other forms.
  const std::string card = start.substr(std::min(beginOfCards(start), start.size()), CardSize);
  const std::size_t number = card.find_first_not_of(" 0", SectionColumn + 1);
  if (card.size() == CardSize && number == CardSize - 1 && card[number] == '1')
  {
    const char section = static_cast<char>(std::toupper(static_cast<unsigned char>(card[SectionColumn])));
    if (section == 'S')
    {
      return "IGES";
    }
    if (section == 'C' || section == 'B')
    {
      throw Error(std::string("an IGES file in ") + (section == 'C' ? "compressed" : "binary") +
        " form; export it in the usual one (ASCII)");
    }
  }
  return {};
}

std::string plainCADText(const std::string& text, const std::string& format)
{
  return format == "IGES" ? plainIGES(text) : format == "STEP" ? plainSTEP(text) : text.substr(beginOf(text, true));
}

void checkIGESText(const std::string& content, const std::string& fileName)
{
  std::istringstream stream(content);
  const std::string order = "SGDPT";
  std::map<char, long> counts;
  std::string text;
  std::string terminate;
  std::size_t line = 0;
  char last = 'S';
  while (std::getline(stream, text))
  {
    ++line;
    if (!text.empty() && text.back() == '\r')
    {
      text.pop_back();
    }
    if (text.empty() && stream.peek() == std::istringstream::traits_type::eof())
    {
      break;
    }
    if (text.size() < 80 || order.find(text[72]) == std::string::npos)
    {
      failAt(fileName, line,
        "not a card of 80 columns with its section (S, G, D, P or T) in column 73; the file is "
        "truncated or corrupt");
    }
    if (order.find(text[72]) < order.find(last))
    {
      failAt(fileName, line, std::string("section ") + text[72] + " follows section " + last);
    }
    last = text[72];
    const long number = std::strtol(text.substr(73, 7).c_str(), nullptr, 10);
    if (number != ++counts[last])
    {
      failAt(fileName, line,
        std::string("card ") + std::to_string(number) + " of section " + last + " stands where card " +
          std::to_string(counts[last]) + " should");
    }
    if (last == 'P')
    {
      const long entity = std::strtol(text.substr(65, 7).c_str(), nullptr, 10);
      if (entity < 1 || entity % 2 == 0 || entity > counts['D'])
      {
        failAt(
          fileName, line, "the card refers to directory entry " + std::to_string(entity) + ", which does not exist");
      }
    }
    if (last == 'T')
    {
      terminate = text;
      break;
    }
  }
  if (terminate.empty())
  {
    failAt(fileName, line, "the file ends without its terminate section; it is truncated");
  }
  for (int i = 0; i < 4; ++i)
  {
    const long number = std::strtol(terminate.substr(8 * i + 1, 7).c_str(), nullptr, 10);
    if (terminate[8 * i] != order[i] || number != counts[order[i]])
    {
      failAt(fileName, line,
        std::string("the terminate section promises ") + terminate.substr(8 * i, 8) + ", but the file has " +
          std::to_string(counts[order[i]]) + " cards of section " + order[i]);
    }
  }
}

STEPEntities checkSTEPText(const std::string& text, const std::string& fileName)
{
  const std::size_t end = text.find_last_not_of(" \t\r\n");
  const std::string mark = "END-ISO-10303-21;";
  if (end == std::string::npos || end + 1 < mark.size() || text.compare(end + 1 - mark.size(), mark.size(), mark) != 0)
  {
    failAt(fileName, lineCount(text), "the file does not end with '" + mark + "'; it is truncated or corrupt");
  }
  const std::vector<Instance> instances = instancesOf(text, fileName);
  std::map<long, const Instance*> byId;
  for (const Instance& instance : instances)
  {
    if (instance.id > 0)
    {
      byId.emplace(instance.id, &instance);
    }
  }

  // What faces depend on: they themselves and all behind them.
  STEPEntities entities;
  std::vector<const Instance*> open;
  const auto need = [&](const Instance& instance) {
    if (entities.needed.insert(instance.id).second)
    {
      open.push_back(&instance);
    }
  };
  for (const auto& [id, instance] : byId)
  {
    if (std::any_of(instance->keywords.begin(), instance->keywords.end(), isShape))
    {
      need(*instance);
    }
  }
  while (!open.empty())
  {
    const Instance& instance = *open.back();
    open.pop_back();
    for (const auto& [id, line] : instance.uses)
    {
      const auto used = byId.find(id);
      if (used != byId.end() && !std::any_of(used->second->keywords.begin(), used->second->keywords.end(), isList))
      {
        need(*used->second);
      }
    }
  }
  // Lists that hold some of it; lists may hold lists.
  for (int pass = 0; pass < 2; ++pass)
  {
    for (const auto& [id, instance] : byId)
    {
      if (std::any_of(instance->keywords.begin(), instance->keywords.end(), isList) &&
        std::any_of(instance->uses.begin(), instance->uses.end(), [&](const auto& use) {
          const auto used = byId.find(use.first);
          return used != byId.end() && entities.needed.count(use.first) > 0 &&
            std::none_of(used->second->keywords.begin(), used->second->keywords.end(),
              [](const std::string& keyword) { return contains(keyword, "REPRESENTATION_CONTEXT"); });
        }))
      {
        entities.needed.insert(id);
      }
    }
  }

  for (const Instance& instance : instances)
  {
    for (const auto& [id, line] : instance.uses)
    {
      if (byId.count(id) > 0)
      {
        continue;
      }
      // Outside of an instance with a number nothing tells what it is for.
      if (instance.id <= 0 || entities.needed.count(instance.id) > 0)
      {
        failAt(fileName, line, "entity #" + std::to_string(id) + " is used but nowhere defined");
      }
      ++entities.broken[instance.keywords.empty() ? "entity" : instance.keywords.front()];
      break;
    }
  }
  return entities;
}

void checkBREPText(const std::string& text, const std::string& fileName)
{
  const std::size_t line = lineCount(text);
  for (const char* section : { "\nLocations ", "\nCurve2ds ", "\nCurves ", "\nPolygon3D ", "\nPolygonOnTriangulations ",
         "\nSurfaces ", "\nTriangulations ", "\nTShapes " })
  {
    if (text.find(section) == std::string::npos)
    {
      failAt(
        fileName, line, std::string("the file has no section '") + (section + 1) + "'; it is truncated or corrupt");
    }
  }
  // The last shapes are: "*" (no more parts of the last one), then an orientation, an index and a location.
  const std::size_t star = text.rfind('*');
  std::istringstream rest(star == std::string::npos ? "" : text.substr(star + 1));
  char sign = 0;
  long index = -1;
  long location = -1;
  std::string more;
  if (!(rest >> sign >> index >> location) || std::string("+-ie").find(sign) == std::string::npos || (rest >> more))
  {
    failAt(fileName, line, "the file does not end with the reference of its shape; it is truncated or corrupt");
  }
}

} // namespace bsv
