// SPDX-License-Identifier: BSD-3-Clause
// PLOT3D files in ASCII: Fortran list-directed text.
#include "Formats/Plot3DSyntax.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace bsv::plot3d
{

namespace
{

/// Longest text of a number.
constexpr int MaxValue = 1000;

bool isBlank(char c)
{
  return c == ' ' || c == '\n' || c == '\r' || c == '\t';
}

bool isSign(char c)
{
  return c == '+' || c == '-';
}

bool isExponentLetter(char c)
{
  return c == 'd' || c == 'D' || c == 'q' || c == 'Q';
}

bool isDigit(char c)
{
  return c >= '0' && c <= '9';
}

/// Where the next number begins in `begin` .. `end`, a text without blanks: numbers of a fixed width, such as E15.8,
/// run into each other where they are negative. A sign between digits begins a number unless an exponent without a
/// letter begins there, which has no decimal point and ends its number.
const char* nextNumber(const char* begin, const char* end)
{
  const auto isLetter = [](char c) { return c == 'e' || c == 'E' || isExponentLetter(c); };
  for (const char* at = begin; at != end && ++at != end;)
  {
    if (!isSign(*at) || at + 1 == end || !(isDigit(at[-1]) || at[-1] == '.') || !(isDigit(at[1]) || at[1] == '.'))
    {
      continue;
    }
    const char* stop = std::find_if_not(at + 1, end, isDigit);
    if (std::any_of(begin, at, isLetter) || (stop != end && !isSign(*stop)))
    {
      return at;
    }
  }
  return end;
}

/// Without that no number runs into another one. Compilers vectorise the loop: some percent of the time of reading.
bool hasSignAfterDigit(const char* begin, const char* end)
{
  unsigned char found = 0;
  for (std::ptrdiff_t n = 1; n < end - begin; ++n)
  {
    const char before = begin[n - 1], c = begin[n];
    found |=
      static_cast<unsigned char>(((c == '+') | (c == '-')) & (((before >= '0') & (before <= '9')) | (before == '.')));
  }
  return found != 0;
}

} // namespace

/// A binary file starts with counts of 4 or 8 bytes below 2^24 or with such a record marker: there is a zero byte
/// among them.
bool isText(InputFile& file)
{
  const std::string start = file.start(8, file.textStart().offset);
  return std::all_of(
    start.begin(), start.end(), [](char c) { return (c >= ' ' && c <= '~') || c == '\t' || c == '\n' || c == '\r'; });
}

namespace
{

/// Bytes of the text, without the mark with which DOS programs end one.
Index textBytes(InputFile& file)
{
  const Index size = file.size();
  const bool isMarked = size > 0 && file.start(1, size - 1) == "\x1a";
  return size - file.textStart().offset - (isMarked ? 1 : 0);
}

} // namespace

ListReader::ListReader(InputFile& file, const Execution& run)
  : ListReader(file, textBytes(file), run)
{
}

ListReader::ListReader(InputFile& file, Index bytes, const Execution& run)
  : File(file)
  , Run(run)
  , Offset(file.textStart().offset)
  , Remaining(bytes)
  , Buffer(static_cast<std::size_t>(std::min(bytes, Index(1) << 20)))
  , LinesBefore(file.textStart().lines)
  , At(Buffer.data())
  , End(At)
{
  this->refill();
}

Index ListReader::countValues()
{
  this->Context.clear();
  Index count = 0;
  while (this->fetch())
  {
    count = saturatingSum(count, this->Repeat);
  }
  return count;
}

void ListReader::checkNumbers()
{
  this->Context.clear();
  while (this->fetch())
  {
    this->parseReal();
  }
}

double ListReader::real()
{
  if (this->isNew())
  {
    this->Real = this->parseReal();
  }
  --this->Repeat;
  return this->Real;
}

int ListReader::integer()
{
  if (this->isNew())
  {
    const char* begin = this->Value + (*this->Value == '+');
    const auto [end, failure] = std::from_chars(begin, this->ValueEnd, this->Integer);
    if (failure != std::errc() || end != this->ValueEnd)
    {
      this->refuse("is not an integer of 4 bytes");
    }
  }
  --this->Repeat;
  return this->Integer;
}

void ListReader::skip(Index count)
{
  while (count > 0)
  {
    this->isNew();
    const Index taken = std::min(count, this->Repeat);
    count -= taken;
    this->Repeat -= taken;
  }
  if (this->Repeat > 0)
  {
    // A repeat that the next block begins with.
    this->Real = this->parseReal();
  }
}

void ListReader::switchType()
{
  if (this->Repeat != 0)
  {
    this->fail("the repeat of '" + this->shown() + "' runs on into values of another kind");
  }
}

std::vector<Ijk> ListReader::header(bool multiBlock)
{
  this->Context = "header";
  const int blocks = multiBlock ? this->integer() : 1;
  if (blocks < 1 || blocks > this->File.size())
  {
    this->fail("the number of blocks is " + std::to_string(blocks));
  }
  std::vector<Ijk> counts;
  for (int b = 0; b < blocks; ++b)
  {
    this->Context = "header, " + blockName(b);
    Ijk block;
    for (int& count : block)
    {
      count = this->integer();
    }
    if (!positive(block))
    {
      this->fail(blockName(b) + " has " + toString(block) + " points");
    }
    counts.push_back(block);
  }
  this->switchType();
  this->Context.clear();
  return counts;
}

void ListReader::fail(const std::string& what) const
{
  throw Error(this->File.name() + ", line " + std::to_string(this->line()) +
    (this->Context.empty() ? "" : " (" + this->Context + ")") + ": " + what);
}

Index ListReader::line() const
{
  const char* begin = this->Buffer.data();
  const char* last = this->Value == this->End && this->End != begin ? this->End - 1 : this->Value;
  return 1 + this->LinesBefore + std::count(begin, last, '\n');
}

std::string ListReader::shown() const
{
  std::string text(this->Value, std::min<std::size_t>(this->ValueEnd - this->Value, 40));
  std::replace_if(
    text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return text;
}

void ListReader::refuse(const char* why) const
{
  const std::string text = this->shown();
  // How some libraries of Windows write what is not finite: 1.#INF, -1.#IND, 1.#QNAN.
  const std::size_t sharp = text.find('#');
  const bool finite = sharp == std::string::npos || sharp == 0 || text[sharp - 1] != '.';
  const bool comment = text.find_first_of("#!") != std::string::npos || text[0] == '/' || text[0] == '%';
  this->fail(
    "'" + text + "' " + (finite ? why : "is not finite") + (finite && comment ? "; PLOT3D has no comments" : ""));
}

bool ListReader::isNew()
{
  if (this->Repeat > 0)
  {
    return false;
  }
  if (!this->fetch())
  {
    this->fail("the file ends too early");
  }
  return true;
}

void ListReader::refill()
{
  this->Run.report(0.0);
  this->LinesBefore += std::count(static_cast<const char*>(this->Buffer.data()), this->At, '\n');
  const Index kept = std::copy(this->At, this->End, this->Buffer.data()) - this->Buffer.data();
  const Index added = std::min(this->Remaining, static_cast<Index>(this->Buffer.size()) - kept);
  this->File.read(this->Offset, this->Buffer.data() + kept, added);
  this->Offset += added;
  this->Remaining -= added;
  this->At = this->Buffer.data();
  this->End = this->At + kept + added;
  this->MayJoin = hasSignAfterDigit(this->At, this->End);
}

bool ListReader::atEnd()
{
  if (this->At == this->End && this->Remaining > 0)
  {
    this->refill();
  }
  return this->At == this->End;
}

bool ListReader::fetch()
{
  bool comma = false;
  for (; !this->atEnd() && (isBlank(*this->At) || *this->At == ','); ++this->At)
  {
    if (*this->At == ',' && comma)
    {
      this->Value = this->At;
      this->fail("a value is missing between two commas");
    }
    comma = comma || *this->At == ',';
  }
  this->Value = this->At;
  if (this->At == this->End)
  {
    return false;
  }
  const auto inValue = [&] { return this->At != this->End && !isBlank(*this->At) && *this->At != ','; };
  while (inValue())
  {
    ++this->At;
  }
  if (this->At == this->End && this->Remaining > 0)
  {
    // Longer than the buffer is no number.
    this->At = this->Value;
    this->refill();
    for (this->Value = this->At; inValue();)
    {
      ++this->At;
    }
  }
  if (this->MayJoin)
  {
    this->At = nextNumber(this->Value, this->At);
  }
  this->ValueEnd = this->At;
  if (this->ValueEnd - this->Value > MaxValue)
  {
    this->fail(
      "'" + this->shown() + "' goes on for more than " + std::to_string(MaxValue) + " characters; no number does");
  }
  const char* star = std::find(this->Value, this->ValueEnd, '*');
  star = star == this->ValueEnd ? nullptr : star;
  this->Repeat = 1;
  if (star)
  {
    const auto [end, failure] = std::from_chars(this->Value, star, this->Repeat);
    if (failure != std::errc() || end != star || this->Repeat < 1 || star + 1 == this->ValueEnd)
    {
      this->fail("'" + this->shown() + "' is not a repeat count of at least 1, '*' and a value" +
        (this->shown()[0] == '*' ? "; Fortran writes stars for a number that does not fit its format" : ""));
    }
    this->Value = star + 1;
  }
  return true;
}

double ListReader::parseReal() const
{
  const char* begin = this->Value + (*this->Value == '+');
  double value = 0.0;
  auto [end, failure] = std::from_chars(begin, this->ValueEnd, value);
  if (failure == std::errc() && end != this->ValueEnd && (isExponentLetter(*end) || isSign(*end)))
  {
    // Fortran's exponents: d or q for e, or no letter at all.
    std::string text(begin, end);
    text += 'e';
    text.append(*end == '+' || *end == '-' ? end : end + 1, this->ValueEnd);
    const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
    failure = result.ec;
    end = result.ptr == text.data() + text.size() ? this->ValueEnd : end;
  }
  if (failure == std::errc::result_out_of_range && end == this->ValueEnd)
  {
    if (std::find(begin + 1, this->ValueEnd, '-') != this->ValueEnd)
    {
      return 0.0; // below the smallest double
    }
    this->refuse("is out of the range of a double");
  }
  if (failure != std::errc() || end != this->ValueEnd)
  {
    this->refuse("is not a number");
  }
  if (!std::isfinite(value))
  {
    this->refuse("is not finite");
  }
  return value;
}

} // namespace bsv::plot3d
