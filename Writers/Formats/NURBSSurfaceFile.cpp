// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/NURBSSurfaceFile.h"

#include "IO/AtomicFile.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <ctime>

namespace bsv
{
namespace
{

std::string number(double value)
{
  char text[32];
  return std::string(text, std::to_chars(text, text + sizeof(text), value).ptr);
}

/// The same surface with u running the other way.
NURBSSurface reversedSurface(const NURBSSurface& surface)
{
  NURBSSurface result = surface;
  const double sum = surface.knots[0].front() + surface.knots[0].back();
  std::transform(surface.knots[0].rbegin(), surface.knots[0].rend(), result.knots[0].begin(),
    [=](double knot) { return sum - knot; });
  const int count = surface.count(0);
  for (int j = 0; j < surface.count(1); ++j)
  {
    std::reverse(
      result.points.begin() + std::ptrdiff_t(j) * count, result.points.begin() + std::ptrdiff_t(j + 1) * count);
    if (result.rational())
    {
      std::reverse(
        result.weights.begin() + std::ptrdiff_t(j) * count, result.weights.begin() + std::ptrdiff_t(j + 1) * count);
    }
  }
  return result;
}

void writeG2(const std::vector<NURBSSurface>& surfaces, AtomicFile& file)
{
  for (const NURBSSurface& surface : surfaces)
  {
    std::string text = "200 1 0 0\n3 " + std::to_string(surface.rational() ? 1 : 0) + "\n";
    for (int d = 0; d < 2; ++d)
    {
      text += std::to_string(surface.count(d)) + " " + std::to_string(surface.degree[d] + 1) + "\n";
      for (std::size_t i = 0; i < surface.knots[d].size(); ++i)
      {
        text += (i == 0 ? "" : " ") + number(surface.knots[d][i]);
      }
      text += "\n";
    }
    for (std::size_t i = 0; i < surface.points.size(); ++i)
    {
      const double weight = surface.rational() ? surface.weights[i] : 1.0;
      for (int d = 0; d < 3; ++d)
      {
        text += (d == 0 ? "" : " ") + number(surface.points[i][d] * weight);
      }
      text += surface.rational() ? " " + number(weight) + "\n" : "\n";
    }
    file.write(text + "\n");
  }
}

/// A real number of IGES has a decimal point, and a capital letter before its exponent.
std::string igesReal(double value)
{
  std::string text = number(value);
  const std::size_t exponent = text.find('e');
  if (exponent != std::string::npos)
  {
    text[exponent] = 'E';
  }
  if (text.find('.') == std::string::npos)
  {
    text.insert(std::min(exponent, text.size()), ".");
  }
  return text;
}

std::string igesText(const std::string& text)
{
  return std::to_string(text.size()) + "H" + text;
}

/// The fields of a record, broken into lines of at most `width` characters between fields.
std::vector<std::string> igesLines(const std::vector<std::string>& fields, std::size_t width)
{
  std::vector<std::string> lines(1);
  for (std::size_t i = 0; i < fields.size(); ++i)
  {
    const std::string field = fields[i] + (i + 1 < fields.size() ? "," : ";");
    if (lines.back().size() + field.size() > width)
    {
      lines.emplace_back();
    }
    lines.back() += field;
  }
  return lines;
}

/// A line of 80 columns: text, letter of the section, number in it.
std::string igesLine(const std::string& text, char section, std::size_t sequence)
{
  char end[16];
  std::snprintf(end, sizeof(end), "%c%7zu\n", section, sequence);
  return text + std::string(72 - text.size(), ' ') + end;
}

std::vector<std::string> igesParameters(const NURBSSurface& surface)
{
  std::vector<std::string> fields{ "128" };
  for (const int value : { surface.count(0) - 1, surface.count(1) - 1, surface.degree[0], surface.degree[1], 0, 0,
         surface.rational() ? 0 : 1, 0, 0 })
  {
    fields.push_back(std::to_string(value));
  }
  for (const std::vector<double>& knots : surface.knots)
  {
    std::transform(knots.begin(), knots.end(), std::back_inserter(fields), igesReal);
  }
  for (std::size_t i = 0; i < surface.points.size(); ++i)
  {
    fields.push_back(igesReal(surface.rational() ? surface.weights[i] : 1.0));
  }
  for (const Vec3& point : surface.points)
  {
    std::transform(point.data(), point.data() + 3, std::back_inserter(fields), igesReal);
  }
  for (int d = 0; d < 2; ++d)
  {
    fields.push_back(igesReal(surface.first(d)));
    fields.push_back(igesReal(surface.last(d)));
  }
  return fields;
}

/// The time in the environment variable SOURCE_DATE_EPOCH, in seconds since 1970; without it none, so that equal
/// surfaces give equal files.
std::string igesDate()
{
  const char* epoch = std::getenv("SOURCE_DATE_EPOCH");
  char* end = nullptr;
  const std::time_t seconds = epoch ? static_cast<std::time_t>(std::strtoll(epoch, &end, 10)) : 0;
  char text[32] = "";
  std::tm utc{};
  if (epoch && end != epoch && *end == 0 && gmtime_r(&seconds, &utc))
  {
    std::strftime(text, sizeof(text), "%Y%m%d.%H%M%S", &utc);
  }
  return text[0] ? igesText(text) : "";
}

void writeIGES(const std::vector<NURBSSurface>& surfaces, const std::vector<std::string>& names, AtomicFile& file)
{
  file.write(igesLine("NURBS surfaces", 'S', 1));

  double largest = 0.0;
  for (const NURBSSurface& surface : surfaces)
  {
    for (const Vec3& point : surface.points)
    {
      largest = std::max(largest, point.cwiseAbs().maxCoeff());
    }
  }
  const std::string date = igesDate();
  // Delimiters, names, sizes of numbers, scale, unit (6: metres), line widths, date, resolution, largest coordinate,
  // author, version (11: IGES 5.3), drafting standard (none), date.
  const std::vector<std::string> global =
    igesLines({ "1H,", "1H;", igesText("body"), igesText("body.igs"), igesText("BSplineVolume"),
                igesText("BSplineVolume"), "32", "38", "6", "308", "15", igesText("body"), "1.", "6", igesText("M"),
                "1", "0.", date, "1.E-07", igesReal(largest), "", "", "11", "0", date },
      72);
  for (std::size_t i = 0; i < global.size(); ++i)
  {
    file.write(igesLine(global[i], 'G', i + 1));
  }

  // The directory comes first, so the lines of the parameters are counted before they are written.
  std::size_t first = 1;
  for (std::size_t s = 0; s < surfaces.size(); ++s)
  {
    const std::size_t lines = igesLines(igesParameters(surfaces[s]), 64).size();
    char text[80];
    std::snprintf(text, sizeof(text), "%8d%8zu%8d%8d%8d%8d%8d%8d%08d", 128, first, 0, 0, 0, 0, 0, 0, 0);
    file.write(igesLine(text, 'D', 2 * s + 1));
    std::snprintf(
      text, sizeof(text), "%8d%8d%8d%8zu%8d%8s%8s%8.8s%8d", 128, 0, 0, lines, 0, "", "", names[s].c_str(), 0);
    file.write(igesLine(text, 'D', 2 * s + 2));
    first += lines;
  }
  std::size_t sequence = 0;
  for (std::size_t s = 0; s < surfaces.size(); ++s)
  {
    for (const std::string& line : igesLines(igesParameters(surfaces[s]), 64))
    {
      char pointer[16];
      std::snprintf(pointer, sizeof(pointer), "%8zu", 2 * s + 1);
      file.write(igesLine(line + std::string(64 - line.size(), ' ') + pointer, 'P', ++sequence));
    }
  }
  char text[80];
  std::snprintf(text, sizeof(text), "S%7dG%7zuD%7zuP%7zu", 1, global.size(), 2 * surfaces.size(), sequence);
  file.write(igesLine(text, 'T', 1));
}

} // namespace

void writeNURBSSurfaceFile(const std::vector<BodyPatch>& patches, const std::string& fileName)
{
  std::string extension = fileName.substr(std::min(fileName.rfind('.'), fileName.size() - 1) + 1);
  std::transform(extension.begin(), extension.end(), extension.begin(),
    [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  const bool g2 = extension == "g2";
  if (!g2 && extension != "igs" && extension != "iges")
  {
    throw Error(fileName + ": the extension is none of g2, igs, iges");
  }
  std::vector<NURBSSurface> surfaces;
  std::vector<std::string> names;
  for (std::size_t p = 0; p < patches.size(); ++p)
  {
    if (!patches[p].loops.empty())
    {
      throw Error(fileName + ": patch " + std::to_string(p) + " '" + patches[p].name +
        "' is trimmed; only untrimmed patches can be written");
    }
    surfaces.push_back(patches[p].reversed ? reversedSurface(patches[p].surface) : patches[p].surface);
    names.push_back(patches[p].name);
  }
  AtomicFile file(fileName);
  if (g2)
  {
    writeG2(surfaces, file);
  }
  else
  {
    writeIGES(surfaces, names, file);
  }
  file.finish();
  file.publish();
}

} // namespace bsv
