// SPDX-License-Identifier: BSD-3-Clause
// Finding out how a PLOT3D file is stored: the layout that explains its size.
#include "Formats/Plot3DSyntax.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

namespace bsv
{

using namespace plot3d;

namespace
{

/// Why an interpretation was given up; those that got farthest explain the file best.
struct Failure
{
  Progress progress = Nothing;
  std::string text;
};

/// The values of an option to try.
template <typename Option>
std::vector<Option> choices(Option given, std::vector<Option> all)
{
  if (given != Option::Automatic)
  {
    all = { given };
  }
  return all;
}

Plot3DLayout asciiLayout(InputFile& file, const Plot3DOptions& options, const Execution& run)
{
  ListReader all(file, run);
  const Index values = all.countValues();
  const Index lines = all.line();
  const TextStart start = file.textStart();
  const std::size_t firstLine = file.start(1 << 10, start.offset).find('\n');
  const bool threeFirst =
    firstLine != std::string::npos && ListReader(file, static_cast<Index>(firstLine)).countValues() == 3;

  Plot3DLayout layout;
  static_cast<Plot3DOptions&>(layout) = options;
  layout.format = Plot3DFormat::Ascii;
  layout.realType = RealType::Double;
  layout.byteOrder = ByteOrder::LittleEndian;
  layout.comments = start.comments;
  std::string failure;
  for (const bool multiBlock : { true, false })
  {
    // Of the two failures, tell the one that the first line suggests: users write three numbers there or one.
    const bool expected = multiBlock != threeFirst;
    layout.multiBlock = multiBlock;
    try
    {
      layout.counts = ListReader(file).header(multiBlock);
    }
    catch (const Error& error)
    {
      failure = expected ? error.what() : failure;
      continue;
    }
    const Index points = pointCount(layout.counts);
    const Index header = (multiBlock ? 1 : 0) + 3 * static_cast<Index>(layout.counts.size());
    std::string needs;
    for (const IBlank iblank : choices(options.iblank, { IBlank::Absent, IBlank::Present }))
    {
      layout.iblank = iblank;
      const Index needed = saturatingSum(header, saturatingProduct(iblank == IBlank::Present ? 4 : 3, points));
      if (needed == values)
      {
        // Neighbours differ in a coordinate, so that repeats alone cannot make a mesh; they could make a huge array.
        if (points > file.size())
        {
          throw Error(file.name() + ": the header promises " + number(points) + " points, more than the " +
            std::to_string(file.size()) + " bytes of the file");
        }
        return layout;
      }
      needs += (needs.empty() ? "" : " or ") + number(needed) +
        (iblank == IBlank::Present ? " with iblank" : " without iblank");
    }
    const std::string mismatch = file.name() + ": the header promises " + describe(layout.counts) + ", that is " +
      needs + " numbers, but the file has " + number(values) + ", down to line " + std::to_string(lines) +
      (values == saturatingSum(header, saturatingProduct(6, points))
          ? ", as if its numbers had decimal commas; write them with points"
          : "");
    failure = expected ? mismatch : failure;
  }
  // A word instead of a number, or a missing blank, is the better explanation.
  ListReader(file, run).checkNumbers();
  const std::string other = otherKindOfText(file, values, run);
  throw Error(other.empty() ? failure : file.name() + ": " + other);
}

/// Whether the first coordinates look like numbers that someone wrote: neither NaN nor of absurd size.
bool believable(InputFile& file, const Plot3DLayout& layout)
{
  const Index offset = headerSize(layout) + markerSize(layout);
  const bool isFloat = layout.realType == RealType::Float;
  const Index count = std::min<Index>(1000, 3 * pointCount(layout.counts[0]));
  for (Index i = 0; i < count; ++i)
  {
    const double x = std::abs(isFloat ? readValue<float>(file, offset + 4 * i, layout.byteOrder)
                                      : readValue<double>(file, offset + 8 * i, layout.byteOrder));
    if (!(x == 0.0 || (x > 1e-30 && x < 1e30)))
    {
      return false;
    }
  }
  return true;
}

/// The first 8 bytes of the file.
std::string hexadecimal(InputFile& file)
{
  std::string text;
  for (const char c : file.start(8))
  {
    char byte[4];
    std::snprintf(byte, sizeof(byte), "%02x ", static_cast<unsigned char>(c));
    text += byte;
  }
  text.pop_back();
  return text;
}

/// Calls visit(layout, progress, what is wrong) for every header that the options allow.
template <typename Visit>
void forEachBinaryHeader(InputFile& file, const Plot3DOptions& options, const Visit& visit)
{
  for (const Plot3DFormat format :
    choices(options.format, { Plot3DFormat::Binary, Plot3DFormat::Fortran, Plot3DFormat::Fortran64 }))
  {
    for (const ByteOrder order : choices(options.byteOrder, { ByteOrder::LittleEndian, ByteOrder::BigEndian }))
    {
      for (const int kind : { 0, 1, 2, 3 })
      {
        Plot3DLayout layout;
        static_cast<Plot3DOptions&>(layout) = options;
        layout.format = format;
        layout.byteOrder = order;
        layout.multiBlock = kind % 2 == 0;
        layout.integerSize = kind < 2 ? 4 : 8;
        Progress progress = Nothing;
        const std::string fault = readHeader(file, layout, progress);
        visit(layout, progress, fault);
      }
    }
  }
}

/// What binary layouts explain.
struct Candidates
{
  std::vector<Plot3DLayout> fitting;
  std::vector<Failure> failures;
  Progress farthest = Nothing;
};

Candidates tryBinaryLayouts(InputFile& file, const Plot3DOptions& options)
{
  Candidates found;
  forEachBinaryHeader(file, options, [&](Plot3DLayout& layout, Progress progress, std::string fault) {
    found.farthest = std::max(found.farthest, progress);
    if (fault.empty())
    {
      std::string reasons;
      for (const RealType real : choices(options.realType, { RealType::Float, RealType::Double }))
      {
        for (const IBlank iblank : choices(options.iblank, { IBlank::Absent, IBlank::Present }))
        {
          layout.realType = real;
          layout.iblank = iblank;
          const std::string reason = blocksFault(file, layout);
          if (reason.empty())
          {
            found.fitting.push_back(layout);
          }
          else
          {
            reasons += std::string(reasons.empty() ? "" : "; ") + (real == RealType::Float ? "float" : "double") +
              (iblank == IBlank::Present ? " with" : " without") + " iblank: " + reason;
          }
        }
      }
      fault = describe(layout.counts) + ": " + reasons;
    }
    found.failures.push_back(
      { progress, layoutName(layout) + (layout.multiBlock ? "" : ", without a number of blocks") + ": " + fault });
  });
  return found;
}

/// The layout of a file whose records are others than usual, such as one per coordinate, or parts of a long one.
std::optional<Plot3DLayout> joinedLayout(
  const std::string& fileName, const Plot3DOptions& options, const Execution& run)
{
  for (const Plot3DFormat format : choices(options.format, { Plot3DFormat::Fortran, Plot3DFormat::Fortran64 }))
  {
    for (const ByteOrder order : choices(options.byteOrder, { ByteOrder::LittleEndian, ByteOrder::BigEndian }))
    {
      InputFile file(fileName);
      if (format == Plot3DFormat::Binary || !file.joinRecords(format, order, run))
      {
        continue;
      }
      Plot3DOptions content = options;
      content.format = Plot3DFormat::Binary;
      content.byteOrder = order;
      for (Plot3DLayout& layout : tryBinaryLayouts(file, content).fitting)
      {
        if (believable(file, layout))
        {
          layout.format = format;
          layout.joined = true;
          return layout;
        }
      }
    }
  }
  return {};
}

/// Says what was tried and where that failed.
[[noreturn]] void failBinary(InputFile& file, const Candidates& tried)
{
  std::string text = file.name() + ": no PLOT3D layout explains the file of " + std::to_string(file.size()) +
    " bytes. Tried were all combinations of format, byte order, precision and iblank that the properties leave open. ";
  if (tried.farthest == Nothing)
  {
    throw Error(text + "In none of them does the header make sense; the first 8 bytes are " + hexadecimal(file));
  }
  text += "The best explanations failed so:";
  for (const Failure& failure : tried.failures)
  {
    text += failure.progress >= (tried.farthest >= Marker ? Marker : BlockCount) ? " [" + failure.text + "]" : "";
  }
  throw Error(text);
}

Plot3DLayout binaryLayout(InputFile& file, const Plot3DOptions& options, const Execution& run)
{
  Candidates found = tryBinaryLayouts(file, options);
  std::vector<Plot3DLayout>& fitting = found.fitting;
  const auto isBelievable = [&](const Plot3DLayout& layout) { return believable(file, layout); };
  const bool records = found.farthest >= Marker;
  if (options.format == Plot3DFormat::Automatic && records)
  {
    // Record markers are hardly a coincidence, a size that fits may be one.
    fitting.erase(std::remove_if(fitting.begin(), fitting.end(),
                    [&](const Plot3DLayout& layout) {
                      return layout.format == Plot3DFormat::Binary &&
                        (found.farthest == HeaderInMarkers || !isBelievable(layout));
                    }),
      fitting.end());
  }
  if (!fitting.empty())
  {
    const auto best =
      fitting.size() == 1 ? fitting.begin() : std::find_if(fitting.begin(), fitting.end(), isBelievable);
    return best != fitting.end() ? *best : fitting.front();
  }
  const std::string other = otherKindOfBinary(file, records);
  if (!other.empty())
  {
    throw Error(file.name() + ": " + other);
  }
  const std::optional<Plot3DLayout> joined = joinedLayout(file.name(), options, run);
  if (!joined)
  {
    failBinary(file, found);
  }
  return *joined;
}

} // namespace

std::string Plot3DLayout::description() const
{
  std::string text = layoutName(*this);
  if (this->format != Plot3DFormat::Ascii)
  {
    text += this->realType == RealType::Float ? ", float" : ", double";
  }
  return text + (this->iblank == IBlank::Present ? ", with iblank" : ", without iblank");
}

Plot3DLayout plot3DLayout(const std::string& fileName, const Plot3DOptions& options, const Execution& run)
{
  InputFile file(fileName);
  refuseEncodings(file);
  const bool ascii = options.format == Plot3DFormat::Automatic ? isText(file) : options.format == Plot3DFormat::Ascii;
  Plot3DLayout layout = ascii ? asciiLayout(file, options, run) : binaryLayout(file, options, run);
  for (std::size_t b = 0; b < layout.counts.size(); ++b)
  {
    const Ijk& counts = layout.counts[b];
    if (*std::min_element(counts.begin(), counts.end()) < 2)
    {
      throw Error(fileName + ": " + blockName(b) + " is a surface (a two-dimensional grid) of " + toString(counts) +
        " points; hexahedra need at least 2 points in each direction");
    }
  }
  return layout;
}

bool looksLikePlot3D(const std::string& fileName)
{
  try
  {
    InputFile file(fileName);
    if (isText(file))
    {
      // Enough for the header of any number of blocks that people have.
      for (const bool multiBlock : { true, false })
      {
        try
        {
          ListReader(file, std::min<Index>(file.size() - file.textStart().offset, 1 << 20)).header(multiBlock);
          return true;
        }
        catch (const Error&)
        {
        }
      }
      return false;
    }
    bool found = false;
    forEachBinaryHeader(file, {}, [&](const Plot3DLayout& layout, Progress progress, const std::string&) {
      found = found || progress >= Marker || (progress == Header && pointCount(layout.counts) <= file.size() / 3);
    });
    return found;
  }
  catch (const std::exception&)
  {
    return false;
  }
}

} // namespace bsv
