// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/SeriesList.h"

#include "Base/Types.h"
#include "IO/RegularFile.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

namespace bsv
{

namespace
{

/// Goes through the text of a `.series` file, which is JSON. No recursion, whatever the file holds.
class ListScanner
{
public:
  ListScanner(const std::string& text, std::string where)
    : Text(text)
    , Where(std::move(where))
  {
  }

  [[noreturn]] void fail(const std::string& what) const
  {
    const auto at = this->Text.begin() + static_cast<std::ptrdiff_t>(std::min(this->At, this->Text.size()));
    throw Error(this->Where + ", line " + std::to_string(1 + std::count(this->Text.begin(), at, '\n')) + ": " + what);
  }

  /// Goes behind `word`. @return whether it is there
  bool find(const std::string& word)
  {
    const std::size_t found = this->Text.find(word, this->At);
    this->At = found == std::string::npos ? this->Text.size() : found + word.size();
    return found != std::string::npos;
  }
  /// The next character that is no blank, 0 at the end.
  char next()
  {
    while (this->At < this->Text.size() && std::strchr(" \t\r\n", this->Text[this->At]))
    {
      ++this->At;
    }
    return this->At < this->Text.size() ? this->Text[this->At] : '\0';
  }
  /// Whether `sign` is next, which is then passed.
  bool take(char sign)
  {
    const bool here = this->next() == sign;
    this->At += here ? 1 : 0;
    return here;
  }
  void expect(char sign)
  {
    if (!this->take(sign))
    {
      this->fail(std::string("here should be ") + sign);
    }
  }

  /// A text in quotes.
  std::string text()
  {
    this->expect('"');
    std::string result;
    for (; this->At < this->Text.size() && this->Text[this->At] != '"'; ++this->At)
    {
      if (this->Text[this->At] == '\0')
      {
        this->fail("a byte of 0 is no character of a file name");
      }
      if (this->Text[this->At] != '\\')
      {
        result += this->Text[this->At];
        continue;
      }
      const char sign = ++this->At < this->Text.size() ? this->Text[this->At] : '\0';
      static constexpr char Escapes[][2] = { { 'n', '\n' }, { 't', '\t' }, { 'r', '\r' }, { 'b', '\b' },
        { 'f', '\f' } };
      const auto* found =
        std::find_if(std::begin(Escapes), std::end(Escapes), [&](const auto& escape) { return escape[0] == sign; });
      if (sign == 'u')
      {
        this->appendCode(result);
      }
      else
      {
        result += found != std::end(Escapes) ? (*found)[1] : sign;
      }
    }
    this->expect('"');
    return result;
  }
  /// A number, true, false or null.
  std::string word()
  {
    this->next();
    const std::size_t end = std::min(this->Text.find_first_of(" \t\r\n,:[]{}\"", this->At), this->Text.size());
    std::string result = this->Text.substr(this->At, end - this->At);
    this->At = end;
    return result;
  }

private:
  /// UTF-8 of four hexadecimal digits behind the current place, or of two such codes.
  void appendCode(std::string& result)
  {
    const auto digits = [this] {
      const std::string four = this->Text.substr(this->At + 1, 4);
      if (four.size() != 4 || four.find_first_not_of("0123456789abcdefABCDEF") != std::string::npos)
      {
        this->fail("\\u" + four + " is no character");
      }
      this->At += 4;
      return static_cast<unsigned>(std::stoul(four, nullptr, 16));
    };
    unsigned code = digits();
    if (code >= 0xd800 && code < 0xdc00 && this->Text.compare(this->At + 1, 2, "\\u") == 0)
    {
      this->At += 2;
      const unsigned second = digits();
      code = second >= 0xdc00 && second < 0xe000 ? 0x10000 + ((code - 0xd800) << 10) + (second - 0xdc00) : code;
    }
    if (code == 0 || (code >= 0xd800 && code < 0xe000))
    {
      this->fail("the code behind \\u is no character of a file name");
    }
    const int rest = code < 0x80 ? 0 : code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
    static constexpr unsigned First[] = { 0, 0xc0, 0xe0, 0xf0 };
    result += static_cast<char>(First[rest] | (code >> (6 * rest)));
    for (int n = rest - 1; n >= 0; --n)
    {
      result += static_cast<char>(0x80 | ((code >> (6 * n)) & 0x3f));
    }
  }

  const std::string& Text;
  std::string Where;
  std::size_t At = 0;
};

} // namespace

bool isSeriesList(const std::string& fileName)
{
  std::string ending = std::filesystem::path(fileName).extension().string();
  std::transform(
    ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending == ".series";
}

std::vector<SeriesFile> readSeriesList(const std::string& fileName)
{
  // A line per step is far below this.
  constexpr std::uintmax_t MostBytes = 1 << 24;
  std::error_code failure;
  std::ifstream stream;
  if (isRegularFile(fileName) && std::filesystem::file_size(fileName, failure) <= MostBytes)
  {
    stream.open(fileName, std::ios::binary);
  }
  if (!stream.is_open())
  {
    throw Error(fileName + ": cannot open the list of a series");
  }
  const std::string text{ std::istreambuf_iterator<char>(stream), {} };
  const std::filesystem::path folder = std::filesystem::path(fileName).parent_path();
  std::vector<SeriesFile> files;
  ListScanner in(text, fileName);
  if (in.find("\"files\""))
  {
    in.expect(':');
    in.expect('[');
    while (in.take(',') || in.next() == '{')
    {
      in.expect('{');
      const std::string entry = "entry " + std::to_string(files.size()) + " of the list";
      SeriesFile listed{ "", static_cast<double>(files.size()) };
      while (!in.take('}'))
      {
        const std::string key = in.text();
        in.expect(':');
        const bool quoted = in.next() == '"';
        const std::string value = quoted ? in.text() : in.word();
        if (key == "time")
        {
          // Some programs write numbers in quotation marks.
          const char* stop = value.data() + value.size();
          const auto [end, error] = std::from_chars(value.data(), stop, listed.time);
          if (error != std::errc() || end != stop || !std::isfinite(listed.time))
          {
            in.fail(entry + ": the time '" + value.substr(0, 40) + "' is no finite number");
          }
        }
        listed.name = key == "name" && quoted ? value : listed.name;
        if (!in.take(',') && in.next() != '}')
        {
          in.fail(entry + ": here should be , or }");
        }
      }
      if (listed.name.empty())
      {
        in.fail(entry + " has no \"name\"");
      }
      listed.name = (folder / listed.name).string();
      if (isSeriesList(listed.name))
      {
        in.fail(entry + " is a list itself, '" + listed.name + "'");
      }
      if (!files.empty() && !(listed.time > files.back().time))
      {
        in.fail(entry + ", '" + listed.name + "', is not later than the one before it");
      }
      files.push_back(listed);
    }
  }
  if (files.empty())
  {
    throw Error(fileName + ": the list names no files; expected is {\"files\": [{\"name\": .., \"time\": ..}, ..]}");
  }
  in.expect(']');
  return files;
}

} // namespace bsv
