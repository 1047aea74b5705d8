// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/BSplineVolumeFile.h"

#include "Formats/G2File.h"
#include "IO/Encodings.h"

#include <algorithm>
#include <limits>
#include <map>

namespace bsv
{

namespace
{

/// What tells of a file what it is.
constexpr std::size_t HeadBytes = std::size_t(1) << 20;

bool startsWith(const std::string& text, const char* head)
{
  return text.rfind(head, 0) == 0;
}

/// The text of a file behind a byte order mark.
std::string textOf(const std::string& fileName, std::size_t most, const Execution& run = {})
{
  std::string text = readTextFile(fileName, most, run);
  text.erase(0, startsWithMark(text) ? 3 : 0);
  return text;
}

/// Whether the text begins with a word of three digits, as the header of a g2 file does.
bool looksLikeG2(const std::string& text)
{
  const std::size_t start = text.find_first_not_of(" \t\r\n");
  if (start == std::string::npos)
  {
    return false;
  }
  const std::size_t end = std::min(text.find_first_not_of("0123456789", start), text.size());
  return end == start + 3 && end < text.size() && (text[end] == ' ' || text[end] == '\t');
}

} // namespace

bool isBSplineVolumeFile(const std::string& fileName)
{
  try
  {
    const std::string text = textOf(fileName, HeadBytes);
    return startsWith(text, "MFEM NURBS") || (looksLikeG2(text) && hasG2Class(text, G2Volume));
  }
  catch (const Error&)
  {
    return false;
  }
}

BSplineVolumeFileContent readBSplineVolumeFile(const std::string& fileName, const Execution& run)
{
  const std::string head = textOf(fileName, HeadBytes);
  const bool g2 = looksLikeG2(head);
  if (!g2 && !startsWith(head, "MFEM"))
  {
    throw Error(fileName + (head.empty() ? ": the file is empty" : ": neither a GoTools g2 file nor an MFEM mesh"));
  }
  const std::string text = textOf(fileName, std::numeric_limits<std::size_t>::max(), run);
  BSplineVolumeFileContent content = g2 ? parseG2Volumes(text, fileName, run) : parseMFEMMesh(text, fileName, run);
  if (content.blocks.empty())
  {
    std::string held;
    for (const auto& other : content.others)
    {
      held += (held.empty() ? "; it holds: " : ", ") + std::to_string(other.second) + " " + other.first;
    }
    throw Error(fileName + ": the " + content.format + " file holds no volume" + held);
  }
  // Faces that a rational and a polynomial block share get equal bits only by the same arithmetic.
  bool allOne = true;
  for (BSplineVolumeFileBlock& block : content.blocks)
  {
    for (const double weight : block.weights)
    {
      block.rational = block.rational || weight != block.weights.front();
      allOne = allOne && weight == 1.0;
    }
  }
  for (BSplineVolumeFileBlock& block : content.blocks)
  {
    block.weights.resize(allOne ? 0 : block.points.size(), 1.0);
  }
  return content;
}

BSplineVolumeFileContent parseG2Volumes(const std::string& text, const std::string& fileName, const Execution& run)
{
  BSplineVolumeFileContent content;
  content.format = "GoTools g2";
  TextScanner in(text, fileName);
  in.reportTo(run);
  std::map<int, int> others;
  while (!in.atEnd())
  {
    const int code = readG2Header(in);
    if (code != G2Volume)
    {
      if (nameOfG2Class(code) == "unknown")
      {
        in.fail("class " + std::to_string(code) + " is none of GoTools");
      }
      ++others[code];
      skipG2Object(in);
      continue;
    }
    const std::string label = "volume " + std::to_string(content.blocks.size() + 1);
    G2Spline spline = readG2Spline(in, code, MaxDegree);
    BSplineVolumeFileBlock block;
    block.name = "Volume " + std::to_string(content.blocks.size() + 1);
    block.volume.degree = spline.degree;
    block.volume.knots = std::move(spline.knots);
    block.points = std::move(spline.points);
    block.weights = std::move(spline.weights);
    try
    {
      checkBSplineVolume(block.volume, label);
    }
    catch (const Error& error)
    {
      in.fail(std::string("before this line: ") + error.what());
    }
    content.blocks.push_back(std::move(block));
  }
  for (const auto& other : others)
  {
    content.others.emplace_back(nameOfG2Class(other.first), other.second);
  }
  return content;
}

} // namespace bsv
