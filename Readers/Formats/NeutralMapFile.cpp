// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/NeutralMapFile.h"

#include "Formats/DeclaredConnectivity.h"
#include "IO/RegularFile.h"
#include "Ranks/Ranks.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>

namespace bsv
{

namespace
{

/// Words of one line before a comment; a word in quotation marks may hold blanks and what starts comments.
std::vector<std::string> words(const std::string& text)
{
  const auto isBlank = [&](std::size_t at) { return std::strchr(" \t,", text[at]) != nullptr; };
  const auto isComment = [&](std::size_t at) {
    return text[at] == '#' || text[at] == '!' || text.compare(at, 2, "//") == 0;
  };
  std::vector<std::string> found;
  for (std::size_t at = 0; at < text.size() && !isComment(at);)
  {
    if (isBlank(at))
    {
      ++at;
      continue;
    }
    const bool quoted = text[at] == '\'' || text[at] == '"';
    std::size_t end = quoted ? text.find(text[at], at + 1) : at;
    while (!quoted && end < text.size() && !isBlank(end) && !isComment(end))
    {
      ++end;
    }
    end = std::min(end, text.size());
    found.push_back(text.substr(at + quoted, end - at - quoted));
    at = end + quoted;
  }
  return found;
}

std::string trimmed(const std::string& text)
{
  const std::size_t first = text.find_first_not_of(" \t");
  return first == std::string::npos ? text : text.substr(first, text.find_last_not_of(" \t") + 1 - first);
}

/// The letters and digits of a word, in lower case: how it is spelt otherwise does not matter.
std::string kind(const std::string& type)
{
  std::string letters;
  for (const char c : type)
  {
    const auto letter = static_cast<unsigned char>(c);
    if (std::isalnum(letter))
    {
      letters += static_cast<char>(std::tolower(letter));
    }
  }
  return letters;
}

bool isOneToOne(const std::string& kind)
{
  const char* const spellings[] = { "onetoone", "one2one", "1to1", "11", "121", "pointtopoint", "pointmatched",
    "abutting1to1" };
  return std::find(std::begin(spellings), std::end(spellings), kind) != std::end(spellings);
}

/// Sides that a period maps onto each other, of which the mesh has both.
bool isPeriodic(const std::string& kind)
{
  return kind.find("periodic") != std::string::npos || kind.find("cyclic") != std::string::npos;
}

bool isInteger(const std::string& word)
{
  int value = 0;
  const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
  return failure == std::errc() && end == word.data() + word.size();
}

bool isFlag(const std::string& word)
{
  const char* const flags[] = { "true", "t", "yes", "y", "false", "f", "no", "n" };
  return std::find(std::begin(flags), std::end(flags), kind(word)) != std::end(flags);
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
    : FileName(regular(fileName))
    , Stream(fileName)
    , Mesh(mesh)
  {
    if (!this->Stream)
    {
      throw Error(fileName + ": cannot be opened for reading");
    }
  }

  /// @return the contacts, whose points are not checked yet.
  std::vector<DeclaredContact> read(std::vector<std::string>& warnings)
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
    this->Declared.finish(this->Mesh, this->Left);
    const std::vector<std::string> sentences = this->Left.sentences();
    warnings.insert(warnings.end(), sentences.begin(), sentences.end());
    return this->Declared.contacts();
  }

private:
  static const std::string& regular(const std::string& fileName)
  {
    requireRegularFile(fileName);
    return fileName;
  }
  std::string where() const { return this->FileName + ", line " + std::to_string(this->Line); }
  std::string here() const { return "line " + std::to_string(this->Line) + " of the neutral map"; }
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

  /// A line that ends as those of any system do: with a line feed, a carriage return, or both.
  bool getLine(std::string& line)
  {
    line.clear();
    char c = '\0';
    bool any = false;
    while (this->Stream.get(c) && c != '\n' && c != '\r')
    {
      line += c;
      any = true;
    }
    if (this->Stream && c == '\r' && this->Stream.peek() == '\n')
    {
      this->Stream.get();
    }
    return any || this->Stream;
  }

  /// Goes to the next line with words.
  bool nextLine()
  {
    std::string line;
    this->Words.clear();
    while (this->Words.empty() && this->getLine(line))
    {
      if (++this->Line == 1)
      {
        this->skipMark(line);
      }
      this->Words = words(line);
    }
    return !this->Words.empty();
  }

  /// The byte order mark that some editors write.
  void skipMark(std::string& line) const
  {
    if (line.rfind("\xef\xbb\xbf", 0) == 0)
    {
      line.erase(0, 3);
    }
    if (line.rfind("\xff\xfe", 0) == 0 || line.rfind("\xfe\xff", 0) == 0)
    {
      this->fail("the file is a text in UTF-16; save it as plain ASCII or UTF-8");
    }
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
      throw Error(this->FileName +
        (this->Line == 0 ? ": the file is empty" : ": the file holds nothing but blanks and comments") +
        "; a neutral map starts with the number of blocks");
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

  bool readSwap(const std::string& word) const
  {
    const std::string text = kind(word);
    const bool swap = text == "true" || text == "t" || text == "1" || text == "yes" || text == "y";
    if (!swap && text != "false" && text != "f" && text != "0" && text != "no" && text != "n")
    {
      this->fail("the swap flag must be TRUE or FALSE, not '" + word.substr(0, 40) + "'");
    }
    return swap;
  }

  /// Numbers of cells along both axes.
  static std::array<int, 2> lengths(const DirectedRange& range)
  {
    return { std::abs(range.end[0] - range.begin[0]), std::abs(range.end[1] - range.begin[1]) };
  }

  void readTopology()
  {
    this->joinType();
    const std::string type = kind(this->Words[0]);
    if (type == "patched" || type == "unprocessed")
    {
      this->Left.add("faces that are patched or unprocessed have no name; where their points match, blocks are joined",
        this->here() + " (" + this->Words[0] + ")");
      return;
    }
    if (!isOneToOne(type))
    {
      // A side is a block, a face and two ranges.
      const bool twoSides = this->Words.size() > 12;
      if (twoSides && !isPeriodic(type))
      {
        this->fail("the type '" + this->Words[0].substr(0, 40) +
          "' is followed by two sides; only ONE_TO_ONE and PERIODIC have two of them");
      }
      this->readBoundary(this->boundaryName(), 1);
      if (twoSides)
      {
        this->readBoundary(trimmed(this->Words[0]), 7);
        this->Left.add("periodic sides are not joined: both are boundaries", this->here());
      }
      return;
    }
    const DirectedRange a = this->readRange(1);
    const DirectedRange b = this->readRange(7);
    constexpr std::size_t Flag = 13;
    bool swapped = lengths(a) != lengths(b);
    if (this->Words.size() > Flag)
    {
      // It speaks of primary directions; if that is our first axis on one side only, it turns round.
      swapped = this->readSwap(this->Words[Flag]) != (primaryAxis(a.face) != primaryAxis(b.face));
    }
    else if (!swapped && lengths(a)[0] == lengths(a)[1])
    {
      this->Left.add(
        "contacts of squares have no swap flag and are left to the points, which say how blocks meet", this->here());
      return;
    }
    this->located([&] { this->Declared.addContact(faceContact(a, b, swapped), this->where()); });
  }

  /// What stands behind the range of a boundary names it, unless it is a flag or a number; else its type does.
  std::string boundaryName() const
  {
    constexpr std::size_t Behind = 7;
    std::string name;
    for (std::size_t word = Behind; word < this->Words.size(); ++word)
    {
      name += (name.empty() ? "" : " ") + this->Words[word];
    }
    name = trimmed(name);
    return name.empty() || isInteger(this->Words[Behind]) || isFlag(name) ? trimmed(this->Words[0]) : name;
  }

  /// Makes one word of a type of several words without quotation marks.
  void joinType()
  {
    std::vector<std::string>& words = this->Words;
    std::size_t count = words.size() > 2 && isInteger(words[0]) && kind(words[1]) == "to" ? 3 : 1;
    for (std::size_t w = count; w < std::min<std::size_t>(words.size(), 3); ++w)
    {
      count = isInteger(words[w]) ? count : w + 1;
    }
    for (std::size_t w = 1; w < count; ++w)
    {
      words[0] += " " + words[w];
    }
    words.erase(words.begin() + 1, words.begin() + static_cast<std::ptrdiff_t>(count));
  }

  /// A boundary that does not fit is left out, as long as it is one.
  void readBoundary(const std::string& name, std::size_t first)
  {
    for (std::size_t word = first; word < first + 6; ++word)
    {
      this->integer(word, "number of a boundary");
    }
    DirectedRange range;
    try
    {
      range = this->readRange(first);
    }
    catch (const Error& error)
    {
      this->Left.add("boundaries left out", error.what());
      return;
    }
    this->Declared.addBoundary(range, name, boundaryTypeOfName(trimmed(this->Words[0])), this->here());
  }

  std::string FileName;
  std::ifstream Stream;
  BlockMesh& Mesh;
  DeclaredConnectivity Declared;
  Leftovers Left;
  int Line = 0;
  std::vector<std::string> Words;
};

} // namespace

void readNeutralMap(
  const std::string& fileName, BlockMesh& mesh, std::vector<std::string>& warnings, const Execution& run)
{
  std::vector<DeclaredContact> contacts;
  contacts = NeutralMapReader(fileName, mesh).read(warnings);
  checkContacts(mesh, contacts, *run.ranks);
}

} // namespace bsv
