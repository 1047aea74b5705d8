// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/NeutralMapFile.h"

#include "Formats/FaceContact.h"
#include "Ranks/Ranks.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <fstream>

namespace bsv
{

namespace
{

/// Words of one line; a word in quotation marks may hold blanks.
std::vector<std::string> words(const std::string& line)
{
  const auto isBlank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == ','; };
  std::vector<std::string> found;
  const std::string text = line.substr(0, line.find('#'));
  for (std::size_t at = 0; at < text.size();)
  {
    if (isBlank(text[at]))
    {
      ++at;
      continue;
    }
    const bool quoted = text[at] == '\'' || text[at] == '"';
    std::size_t end = quoted ? text.find(text[at], at + 1) : at;
    while (!quoted && end < text.size() && !isBlank(text[end]))
    {
      ++end;
    }
    end = std::min(end, text.size());
    found.push_back(text.substr(at + quoted, end - at - quoted));
    at = end + quoted;
  }
  return found;
}

std::string upper(std::string text)
{
  std::transform(
    text.begin(), text.end(), text.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  std::replace(text.begin(), text.end(), '-', '_');
  return text;
}

/// Our face number per that of the file less one.
constexpr int Face[6] = { 4, 5, 0, 1, 2, 3 };

/// Our face axis that is the file's primary direction: j faces run through k first.
constexpr int primaryAxis(int face)
{
  return faceDirection(face) == 1 ? 1 : 0;
}

class NeutralMapReader
{
public:
  NeutralMapReader(const std::string& fileName, BlockMesh& mesh)
    : FileName(fileName)
    , Stream(fileName)
    , Mesh(mesh)
  {
    if (!this->Stream)
    {
      throw Error(fileName + ": cannot be opened for reading");
    }
  }

  /// @return the contacts, whose points are not checked yet.
  std::vector<DeclaredContact> read()
  {
    this->readBlocks();
    while (this->nextLine())
    {
      this->readTopology();
    }
    if (this->Stream.bad())
    {
      this->fail("reading failed");
    }
    return std::move(this->Contacts);
  }

private:
  std::string where() const { return this->FileName + ", line " + std::to_string(this->Line); }
  [[noreturn]] void fail(const std::string& what) const { throw Error(this->where() + ": " + what); }

  /// Adds file and line to the errors of `check`.
  template <typename Check>
  void located(const Check& check) const
  {
    try
    {
      check();
    }
    catch (const Error& error)
    {
      this->fail(error.what());
    }
  }

  /// Goes to the next line with words.
  bool nextLine()
  {
    std::string line;
    this->Words.clear();
    while (this->Words.empty() && std::getline(this->Stream, line))
    {
      ++this->Line;
      this->Words = words(line);
    }
    return !this->Words.empty();
  }

  int integer(std::size_t word, const char* what) const
  {
    if (word >= this->Words.size())
    {
      this->fail(std::string(what) + " is missing");
    }
    const std::string& text = this->Words[word];
    int value = 0;
    const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (failure != std::errc() || end != text.data() + text.size())
    {
      this->fail(std::string(what) + " '" + text.substr(0, 40) + "' is not an integer");
    }
    return value;
  }

  int integer(std::size_t word, const char* what, int last) const
  {
    const int value = this->integer(word, what);
    if (value < 1 || value > last)
    {
      this->fail(std::string(what) + " " + std::to_string(value) + " is out of range 1.." + std::to_string(last));
    }
    return value;
  }

  void readBlocks()
  {
    const int expected = static_cast<int>(this->Mesh.blocks.size());
    if (!this->nextLine())
    {
      this->fail("the number of blocks is missing");
    }
    const int blocks = this->integer(0, "number of blocks");
    if (blocks != expected)
    {
      this->fail(
        "the number of blocks is " + std::to_string(blocks) + ", but the grid has " + std::to_string(expected));
    }
    for (int b = 0; b < blocks; ++b)
    {
      if (!this->nextLine())
      {
        this->fail("the file ends before the size of block " + std::to_string(b + 1));
      }
      const MeshBlock& block = this->Mesh.blocks[this->integer(0, "block", blocks) - 1];
      for (int d = 0; d < 3; ++d)
      {
        const int count = this->integer(1 + d, "number of points");
        if (count != block.points.counts()[d])
        {
          this->fail("block " + this->Words[0] + " has " + std::to_string(count) + " points along " + "ijk"[d] +
            ", but the grid's has " + std::to_string(block.points.counts()[d]));
        }
      }
    }
  }

  /// Range from the six words B F S1 E1 S2 E2.
  DirectedRange readRange(std::size_t word) const
  {
    DirectedRange range;
    range.block = this->integer(word, "block", static_cast<int>(this->Mesh.blocks.size())) - 1;
    range.face = Face[this->integer(word + 1, "face", 6) - 1];
    for (int direction = 0; direction < 2; ++direction)
    {
      const int axis = direction == 0 ? primaryAxis(range.face) : 1 - primaryAxis(range.face);
      const int last = this->Mesh.blocks[range.block].points.counts()[faceAxis(range.face, axis)];
      range.begin[axis] = this->integer(word + 2 + 2 * direction, "start of the range", last) - 1;
      range.end[axis] = this->integer(word + 3 + 2 * direction, "end of the range", last) - 1;
    }
    this->located([&] { checkRange(this->Mesh, range); });
    return range;
  }

  bool readSwap(std::size_t word) const
  {
    const std::string text = word < this->Words.size() ? upper(this->Words[word]) : "";
    const bool swap = text == "TRUE" || text == "T" || text == ".TRUE.";
    if (!swap && text != "FALSE" && text != "F" && text != ".FALSE.")
    {
      this->fail("the swap flag must be TRUE or FALSE, not '" +
        (word < this->Words.size() ? this->Words[word].substr(0, 40) : "") + "'");
    }
    return swap;
  }

  void readTopology()
  {
    const std::string type = upper(this->Words[0]);
    if (type == "PATCHED" || type == "UNPROCESSED")
    {
      return;
    }
    const DirectedRange a = this->readRange(1);
    if (type != "ONE_TO_ONE")
    {
      const int tag = nameIndex(this->Mesh.boundaryNames, this->Words[0]);
      this->Mesh.boundaries.push_back({ a.block, a.face, a.range(), tag });
      return;
    }
    const DirectedRange b = this->readRange(7);
    // The flag speaks of primary directions; if that is our first axis on one side only, it turns round.
    const bool swapped = this->readSwap(13) != (primaryAxis(a.face) != primaryAxis(b.face));
    this->located([&] { this->Contacts.push_back({ faceContact(a, b, swapped), this->where() }); });
    this->Mesh.interfaces.push_back(this->Contacts.back().contact);
  }

  std::string FileName;
  std::ifstream Stream;
  BlockMesh& Mesh;
  std::vector<DeclaredContact> Contacts;
  int Line = 0;
  std::vector<std::string> Words;
};

} // namespace

void readNeutralMap(const std::string& fileName, BlockMesh& mesh, const Execution& run)
{
  std::vector<DeclaredContact> contacts;
  run.ranks->together([&] { contacts = NeutralMapReader(fileName, mesh).read(); });
  checkContacts(mesh, contacts, *run.ranks);
}

} // namespace bsv
