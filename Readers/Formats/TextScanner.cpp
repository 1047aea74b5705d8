// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/TextScanner.h"

#include "Base/MemoryCheck.h"
#include "IO/Encodings.h"
#include "IO/RegularFile.h"

#include <filesystem>
#include <fstream>
#include <vector>

namespace bsv
{

std::string readTextFile(const std::string& fileName, std::size_t most, const Execution& run)
{
  requireRegularFile(fileName);
  std::ifstream stream(fileName, std::ios::binary);
  if (!stream)
  {
    throw Error(fileName + ": cannot be opened");
  }
  std::error_code failure;
  const double size = static_cast<double>(std::filesystem::file_size(fileName, failure));
  requireMemory(failure ? 0.0 : std::min(size, static_cast<double>(most)), fileName, "its text");
  std::string text;
  constexpr double LargestPart = 1 << 20;
  std::vector<char> part(static_cast<std::size_t>(failure ? LargestPart : std::min(size + 1.0, LargestPart)));
  while (stream && text.size() < most)
  {
    stream.read(part.data(), static_cast<std::streamsize>(part.size()));
    const auto end = part.begin() + stream.gcount();
    const std::string what = text.empty() ? otherEncoding({ part.begin(), end }) : std::string();
    if (!what.empty())
    {
      throw Error(fileName + ": the file is " + what);
    }
    // Not to fill the memory with a file that is none.
    if (std::find(part.begin(), end, '\0') != end)
    {
      throw Error(fileName + ": the file holds bytes that are 0; it is no text");
    }
    text.append(part.begin(), end);
    text.resize(std::min(text.size(), most));
    run.report(0.0);
  }
  if (stream.bad())
  {
    throw Error(fileName + ": cannot be read");
  }
  return text;
}

bool TextScanner::atEnd()
{
  for (; this->At != this->End; ++this->At)
  {
    if (*this->At == '\n')
    {
      ++this->Line;
    }
    else if (this->Comment != '\0' && *this->At == this->Comment)
    {
      this->At = std::find(this->At, this->End, '\n') - 1;
    }
    else if (*this->At != ' ' && !(*this->At >= '\t' && *this->At <= '\r'))
    {
      return false;
    }
  }
  return true;
}

void TextScanner::report()
{
  // What takes about a hundredth of a second.
  constexpr std::ptrdiff_t Characters = std::ptrdiff_t(1) << 19;
  this->Run->report(static_cast<double>(this->At - this->Start) / static_cast<double>(this->End - this->Start));
  this->NextReport = this->End - this->At > Characters ? this->At + Characters : this->End;
}

void TextScanner::need(const char* what)
{
  if (this->Run && this->At >= this->NextReport)
  {
    this->report();
  }
  if (this->atEnd())
  {
    this->fail(std::string("the file ends where ") + what + " should follow");
  }
}

std::string TextScanner::restOfLine()
{
  const char* end = std::find(this->At, this->End, '\n');
  std::string rest(this->At, end);
  this->At = end;
  const std::size_t first = rest.find_first_not_of(" \t\r");
  return first == std::string::npos ? std::string() : rest.substr(first, rest.find_last_not_of(" \t\r") + 1 - first);
}

std::string TextScanner::word(const char* what)
{
  this->need(what);
  std::string word = this->peek();
  this->At = this->wordEnd();
  return word;
}

std::string TextScanner::peek()
{
  return this->atEnd() ? std::string()
                       : std::string(this->At, std::min<std::ptrdiff_t>(this->wordEnd() - this->At, 40));
}

int TextScanner::integer(const char* what, int low, int high)
{
  const long long value = this->next<long long>(what);
  if (value < low || value > high)
  {
    this->fail(std::string(what) + " is " + std::to_string(value) + ", not in " + std::to_string(low) + ".." +
      std::to_string(high));
  }
  return static_cast<int>(value);
}

void TextScanner::expect(double numbers, const char* what) const
{
  // A number takes one character and a blank.
  if (numbers > static_cast<double>(this->End - this->At) / 2.0 + 1.0)
  {
    this->fail(std::string("the file is too short for the number of ") + what + " that is given here");
  }
}

} // namespace bsv
