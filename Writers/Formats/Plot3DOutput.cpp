// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/Plot3DOutput.h"

#include "IO/TextOutput.h"
#include "Ranks/Ranks.h"

#include <algorithm>
#include <cstring>
#include <limits>

namespace bsv
{

namespace
{

bool isLittleEndianMachine()
{
  const std::uint16_t two = 2;
  unsigned char first;
  std::memcpy(&first, &two, 1);
  return first == 2;
}

/// Numbers in one of the encodings.
class NumberOutput
{
public:
  NumberOutput(OutputBuffer& file, const Plot3DOutputOptions& options, bool isFloat)
    : File(file)
    , Options(options)
    , IsFloat(isFloat)
    , Swap(options.bigEndian == isLittleEndianMachine())
  {
  }

  void integers(const int* values, int count)
  {
    if (this->Options.encoding == MeshEncoding::Text)
    {
      TextOutput out(this->File);
      for (int n = 0; n < count; ++n)
      {
        out << values[n];
        this->File.write(n + 1 < count ? " " : "\n", 1);
      }
      return;
    }
    this->mark(count * sizeof(int));
    this->put(values, count);
    this->mark(count * sizeof(int));
  }

  /// Mark before and after a record.
  void mark(std::size_t bytes)
  {
    if (this->Options.encoding == MeshEncoding::Unformatted)
    {
      const std::int32_t size = static_cast<std::int32_t>(bytes);
      this->put(&size, 1);
    }
  }

  template <typename Real>
  void row(const Real* first, Index stride, int count)
  {
    if (this->Options.encoding != MeshEncoding::Text)
    {
      this->IsFloat ? this->converted<float>(first, stride, count) : this->converted<double>(first, stride, count);
      return;
    }
    char* to = this->File.room(static_cast<std::size_t>(count) * 26);
    for (int n = 0; n < count; ++n)
    {
      to = std::to_chars(to, to + 25, static_cast<double>(first[n * stride])).ptr;
      *to++ = n % 4 == 3 || n + 1 == count ? '\n' : ' ';
    }
    this->File.advance(to);
  }

  void blanks(const std::vector<int>& row)
  {
    this->Options.encoding == MeshEncoding::Text ? this->integers(row.data(), static_cast<int>(row.size()))
                                                 : this->put(row.data(), static_cast<int>(row.size()));
  }

private:
  template <typename To, typename Real>
  void converted(const Real* first, Index stride, int count)
  {
    char* to = this->File.room(static_cast<std::size_t>(count) * sizeof(To));
    for (int n = 0; n < count; ++n)
    {
      const To value = static_cast<To>(first[n * stride]);
      std::memcpy(to + n * sizeof(To), &value, sizeof(To));
    }
    this->swapped<sizeof(To)>(to, count);
    this->File.advance(to + static_cast<std::size_t>(count) * sizeof(To));
  }

  void put(const std::int32_t* values, int count)
  {
    char* to = this->File.room(static_cast<std::size_t>(count) * sizeof(std::int32_t));
    std::memcpy(to, values, count * sizeof(std::int32_t));
    this->swapped<sizeof(std::int32_t)>(to, count);
    this->File.advance(to + count * sizeof(std::int32_t));
  }

  template <std::size_t Size>
  void swapped(char* bytes, int count) const
  {
    for (int n = 0; this->Swap && n < count; ++n)
    {
      std::reverse(bytes + n * Size, bytes + (n + 1) * Size);
    }
  }

  OutputBuffer& File;
  const Plot3DOutputOptions& Options;
  bool IsFloat;
  bool Swap;
};

void writeBlock(OutputBuffer& file, const BlockToWrite& block, const Plot3DOutputOptions& options, bool isFloat,
  std::size_t bytes, const PartReport& report)
{
  NumberOutput out(file, options, isFloat);
  out.mark(bytes);
  const Index rows = Index(block.counts[1]) * block.counts[2];
  const int arrays = options.iblank ? 4 : 3;
  // Rows between two reports.
  const Index step = std::max<Index>(1, (Index(1) << 16) / block.counts[0]);
  std::vector<int> blanks(static_cast<std::size_t>(block.counts[0]));
  for (int a = 0; a < arrays; ++a)
  {
    for (Index r = 0; r < rows; ++r)
    {
      if (r % step == 0)
      {
        report(
          static_cast<double>(a * rows + r) / static_cast<double>(arrays * rows) * static_cast<double>(block.size()));
      }
      const int j = static_cast<int>(r % block.counts[1]);
      const int k = static_cast<int>(r / block.counts[1]);
      if (a < 3)
      {
        block.row(j, k, [&](const auto* x, Index stride) { out.row(x + a, stride, block.counts[0]); });
      }
      else
      {
        for (int i = 0; i < block.counts[0]; ++i)
        {
          blanks[i] = block.blank(i, j, k);
        }
        out.blanks(blanks);
      }
    }
  }
  out.mark(bytes);
}

/// The file's face number per our face.
constexpr int Face[6] = { 3, 4, 5, 6, 1, 2 };

/// Our face axis that is the file's primary direction: j faces run through k first.
constexpr int primaryAxis(int face)
{
  return faceDirection(face) == 1 ? 1 : 0;
}

/// " B F S1 E1 S2 E2" of the points from `begin` to `end`.
std::string mapRange(int block, int face, const std::array<int, 2>& begin, const std::array<int, 2>& end)
{
  std::string text = " " + std::to_string(block + 1) + " " + std::to_string(Face[face]);
  for (const int axis : { primaryAxis(face), 1 - primaryAxis(face) })
  {
    text += " " + std::to_string(begin[axis] + 1) + " " + std::to_string(end[axis] + 1);
  }
  return text;
}

} // namespace

void writePlot3D(const MeshToWrite& mesh, AtomicFile& file, const Plot3DOutputOptions& options, const Execution& run)
{
  const bool isFloat = mesh.isFloat();
  std::vector<FilePart> parts;
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b)
  {
    const BlockToWrite& block = mesh.blocks[b];
    const std::size_t bytes =
      static_cast<std::size_t>(block.size()) * (3 * (isFloat ? 4 : 8) + (options.iblank ? 4 : 0));
    const bool marked = options.encoding == MeshEncoding::Unformatted;
    if (marked && bytes > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
    {
      throw Error(mesh.label(b) + " makes a Fortran record of " + std::to_string(bytes) +
        " bytes, and their marks count up to 2147483647; use the encoding Binary, or smaller blocks");
    }
    const Index size = options.encoding == MeshEncoding::Text ? -1 : static_cast<Index>(bytes + (marked ? 8 : 0));
    parts.push_back({ block.rank, static_cast<double>(block.size()),
      [&block, &options, isFloat, bytes](
        OutputBuffer& out, const PartReport& report) { writeBlock(out, block, options, isFloat, bytes, report); },
      size });
  }
  if (run.ranks->rank() == 0)
  {
    NumberOutput out(file, options, isFloat);
    const int blocks = static_cast<int>(mesh.blocks.size());
    out.integers(&blocks, 1);
    if (options.encoding == MeshEncoding::Text)
    {
      for (const BlockToWrite& block : mesh.blocks)
      {
        out.integers(block.counts.data(), 3);
      }
    }
    else
    {
      std::vector<int> counts;
      for (const BlockToWrite& block : mesh.blocks)
      {
        counts.insert(counts.end(), block.counts.begin(), block.counts.end());
      }
      out.integers(counts.data(), static_cast<int>(counts.size()));
    }
  }
  writeParts(file, parts, run);
}

void writeNeutralMap(const MeshToWrite& mesh, AtomicFile& file, const Execution& run, std::vector<std::string>& notes)
{
  // What is allowed within quotation marks, except for what ends a line or begins a comment.
  std::vector<std::string> names = mesh.boundaryNames;
  for (std::string& name : names)
  {
    const std::string before = name;
    for (char& c : name)
    {
      c = static_cast<unsigned char>(c) < ' ' || c == '#' || c == '\'' || c == '"' ? '_' : c;
    }
    std::string upper = name;
    std::transform(upper.begin(), upper.end(), upper.begin(),
      [](char c) { return c == '-' ? '_' : static_cast<char>(std::toupper(static_cast<unsigned char>(c))); });
    if (upper.empty() || upper == "ONE_TO_ONE" || upper == "PATCHED" || upper == "UNPROCESSED")
    {
      name += "_";
    }
    if (name != before)
    {
      notes.push_back("boundary '" + before + "' is '" + name + "' in the neutral map");
    }
    if (name.find_first_of(" ,") != std::string::npos)
    {
      name = "'" + name + "'";
    }
  }
  if (run.ranks->rank() == 0)
  {
    TextOutput out(file);
    out << "# Neutral map: blocks, then contacts and boundaries.\n"
        << "# Faces 1 k min, 2 k max, 3 i min, 4 i max, 5 j min, 6 j max.\n"
        << static_cast<int>(mesh.blocks.size()) << "\n";
    for (std::size_t b = 0; b < mesh.blocks.size(); ++b)
    {
      const Ijk& counts = mesh.blocks[b].counts;
      out << static_cast<int>(b + 1) << " " << counts[0] << " " << counts[1] << " " << counts[2] << "\n";
    }
    out << "# TYPE B1 F1 S1 E1 S2 E2 B2 F2 S1 E1 S2 E2 SWAP\n";
    for (const Interface& c : mesh.interfaces)
    {
      const FaceRange& a = c.rangeA;
      const int ns = a.hi[0] - a.lo[0];
      const int nt = a.hi[1] - a.lo[1];
      std::array<int, 2> begin = mapFacePoint(c.orientation, 0, 0, ns, nt);
      std::array<int, 2> end = mapFacePoint(c.orientation, ns, nt, ns, nt);
      for (int axis = 0; axis < 2; ++axis)
      {
        begin[axis] += c.originB[axis];
        end[axis] += c.originB[axis];
      }
      const bool swap = swapsAxes(c.orientation) != (primaryAxis(c.faceA) != primaryAxis(c.faceB));
      out << "ONE_TO_ONE" << mapRange(c.blockA, c.faceA, a.lo, a.hi) << mapRange(c.blockB, c.faceB, begin, end)
          << (swap ? " TRUE\n" : " FALSE\n");
    }
    for (const BoundaryPatch& patch : mesh.boundaries)
    {
      if (patch.tag >= 0)
      {
        out << names[patch.tag] << mapRange(patch.block, patch.face, patch.range.lo, patch.range.hi) << "\n";
      }
    }
  }
}

} // namespace bsv
