// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/RankGroup.h"

#include <algorithm>
#include <cstdio>
#include <new>
#include <tuple>

namespace bsv
{
namespace
{

/// Less than this is gathered without being asked for room first.
constexpr Index ScratchSize = Index(1) << 16;
/// Of the texts that are compared, two fit into the scratch.
constexpr Index LongestText = ScratchSize / 2;

/// FNV-1a; 0 is the hash of nothing.
std::uint64_t hashOf(const std::string& text)
{
  std::uint64_t hash = 14695981039346656037u;
  for (const char c : text)
  {
    hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211u;
  }
  return hash | 1;
}

/// The first line in which two texts differ, of each.
std::array<std::string, 2> firstDifference(const std::string& a, const std::string& b)
{
  std::size_t line = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()) && a[i] == b[i]; ++i)
  {
    line = a[i] == '\n' ? i + 1 : line;
  }
  const auto lineAt = [&](const std::string& text) {
    const std::size_t begin = text.find_first_not_of(' ', line);
    return begin == std::string::npos ? "nothing" : "'" + text.substr(begin, text.find('\n', begin) - begin) + "'";
  };
  return { lineAt(a), lineAt(b) };
}

} // namespace

//------------------------------------------------------------------------------
RankGroup::RankGroup(int size)
  : Records(size)
  , Sizes(size)
  , Rooms(size)
  , Scratch(ScratchSize)
{
  this->Text.reserve(LongestText);
  this->VerdictText.reserve(2 * LongestText + 256);
}

//------------------------------------------------------------------------------
void RankGroup::setText(const char* text) const
{
  this->Text.assign(text, std::min(std::strlen(text), static_cast<std::size_t>(LongestText)));
}

/// Whether `work` throws; if so, this rank's next record tells it.
template <typename Work>
bool RankGroup::failed(const Work& work) const
{
  const auto fail = [this](State state, Index place, const char* text) {
    // What a collective function threw is known to all ranks already.
    if (this->Verdict == State::Well)
    {
      this->Mine = state;
      this->Place = place;
      this->setText(text);
    }
  };
  try
  {
    work();
    return false;
  }
  catch (const Aborted& stop)
  {
    fail(State::Stopped, -1, stop.what());
  }
  catch (const ErrorAt& error)
  {
    fail(State::Failed, error.place(), error.what());
  }
  catch (const std::bad_alloc&)
  {
    char text[64];
    std::snprintf(text, sizeof text, "rank %d: there is not enough memory", this->rank());
    fail(State::Failed, -1, text);
  }
  catch (const std::exception& error)
  {
    fail(State::Failed, -1, error.what());
  }
  catch (...)
  {
    fail(State::Failed, -1, "unknown error");
  }
  return true;
}

/// Runs a part of the transport.
template <typename Work>
void RankGroup::moved(const Work& work) const
{
  const auto fail = [this](const char* why) {
    this->Verdict = State::Failed;
    this->OverDepth = 0;
    this->VerdictText.assign("The ranks do not reach each other any more: ").append(why, std::strlen(why));
    this->abandon(why);
    this->throwVerdict();
  };
  try
  {
    work();
  }
  catch (const std::exception& error)
  {
    fail(error.what());
  }
}

//------------------------------------------------------------------------------
void RankGroup::runTogether(const std::function<void()>& body, const std::function<std::string()>& parameters) const
{
  if (this->Verdict != State::Well)
  {
    this->throwVerdict();
  }
  const bool outermost = this->Depth++ == 0;
  this->failed([&] {
    if (outermost && parameters)
    {
      this->Parameters = parameters();
      this->ParametersHash = hashOf(this->Parameters);
    }
    body();
  });
  if (this->Verdict == State::Well)
  {
    try
    {
      this->meet(Wish::EndScope);
    }
    catch (const Error&)
    {
      // It is the verdict.
    }
  }
  this->Mine = State::Well;
  if (outermost)
  {
    this->Parameters.clear();
    this->ParametersHash = 0;
  }
  --this->Depth;
  if (this->Verdict != State::Well)
  {
    this->throwVerdict();
  }
}

/// Ends the scopes that it is for; those that are left are forgotten.
void RankGroup::throwVerdict() const
{
  const State verdict = this->Verdict;
  if (this->Depth == 0 || this->Depth < this->OverDepth)
  {
    this->Verdict = this->Mine = State::Well;
  }
  if (verdict == State::Stopped)
  {
    throw Aborted();
  }
  throw Error(this->VerdictText);
}

//------------------------------------------------------------------------------
/// Returns when all ranks wish the same.
void RankGroup::meet(Wish wish, const Span& content, std::size_t unit) const
{
  if (this->Verdict == State::Well)
  {
    Record mine = {};
    mine.step = this->Steps;
    mine.place = this->Place;
    mine.bytes = content.size;
    mine.textBytes = static_cast<Index>(this->Text.size());
    mine.parameterBytes = std::min(static_cast<Index>(this->Parameters.size()), LongestText);
    mine.parameters = this->ParametersHash;
    mine.unit = static_cast<std::uint32_t>(unit);
    mine.depth = static_cast<std::uint16_t>(this->Depth);
    mine.wish = wish;
    mine.state = this->Mine;
    if (content.size > 0 && content.size <= static_cast<Index>(sizeof mine.content))
    {
      std::memcpy(mine.content, content.data, content.size);
    }
    this->moved([&] {
      this->allGather(
        reinterpret_cast<const char*>(&mine), sizeof(Record), reinterpret_cast<char*>(this->Records.data()));
    });
    this->judge();
  }
  if (this->Verdict != State::Well)
  {
    this->throwVerdict();
  }
}

/// The same on all ranks, as it is made of the same records.
void RankGroup::judge() const
{
  const Record& one = this->Records[0];
  int depth = one.depth;
  int failure = -1;
  const auto key = [this](int r) { return std::make_tuple(this->Records[r].step, this->Records[r].place); };
  for (int r = 0; r < this->size(); ++r)
  {
    depth = std::min<int>(depth, this->Records[r].depth);
    this->Steps = std::max(this->Steps, this->Records[r].step);
    if (this->Records[r].state != State::Well && (failure < 0 || key(r) < key(failure)))
    {
      failure = r;
    }
  }
  ++this->Steps;
  const auto end = [&](State state) {
    this->Verdict = state;
    this->OverDepth = depth;
  };
  for (int r = 1; r < this->size(); ++r)
  {
    if (this->Records[r].parameters != one.parameters)
    {
      this->judgeParameters(r);
      end(State::Failed);
      return;
    }
  }
  if (failure >= 0)
  {
    const Index bytes = this->Records[failure].textBytes;
    if (failure == this->rank())
    {
      std::copy_n(this->Text.data(), bytes, this->Scratch.data());
    }
    this->moved([&] { this->broadcast(this->Scratch.data(), bytes, failure); });
    this->VerdictText.assign(this->Scratch.data(), bytes);
    end(this->Records[failure].state);
    return;
  }
  for (int r = 1; r < this->size(); ++r)
  {
    const Record& other = this->Records[r];
    if (std::tie(other.step, other.wish, other.unit, other.depth) != std::tie(one.step, one.wish, one.unit, one.depth))
    {
      this->VerdictText.assign("The ranks 0 and ")
        .append(std::to_string(r))
        .append(" do not take the same steps: they have different parameters or inputs.");
      end(State::Failed);
      return;
    }
  }
}

/// Names the first line in which the parameters of rank 0 and another differ.
void RankGroup::judgeParameters(int other) const
{
  std::array<std::string, 2> texts;
  int n = 0;
  for (const int r : { 0, other })
  {
    char* at = this->Scratch.data() + n * LongestText;
    const Index bytes = this->Records[r].parameterBytes;
    if (r == this->rank())
    {
      std::copy_n(this->Parameters.data(), bytes, at);
    }
    this->moved([&] { this->broadcast(at, bytes, r); });
    texts[n++].assign(at, bytes);
  }
  const std::array<std::string, 2> lines = firstDifference(texts[0], texts[1]);
  this->VerdictText.assign("The parameters are not the same on all ranks: rank 0 has ")
    .append(lines[0])
    .append(", rank ")
    .append(std::to_string(other))
    .append(" has ")
    .append(lines[1])
    .append(".");
}

//------------------------------------------------------------------------------
/// Agrees with the others that memory for data is there: without it nobody sends.
template <typename Work>
void RankGroup::ready(const Work& work) const
{
  this->failed(work);
  this->meet(Wish::Transfer);
}

void RankGroup::collect(Wish wish, const Span& mine, std::size_t unit, const Room& room) const
{
  this->meet(wish, mine, unit);
  Index total = 0;
  Index longest = 0;
  for (int r = 0; r < this->size(); ++r)
  {
    this->Sizes[r] = this->Records[r].bytes;
    total += this->Sizes[r];
    longest = std::max(longest, this->Sizes[r]);
  }
  if (longest <= static_cast<Index>(sizeof(Record::content)))
  {
    for (int r = 0; r < this->size(); ++r)
    {
      if (this->Sizes[r] > 0)
      {
        std::memcpy(room(r, this->Sizes[r]), this->Records[r].content, this->Sizes[r]);
      }
    }
  }
  else if (total <= ScratchSize)
  {
    this->moved([&] { this->allGather(mine.data, this->Sizes, this->Scratch.data()); });
    const char* from = this->Scratch.data();
    for (int r = 0; r < this->size(); ++r)
    {
      if (this->Sizes[r] > 0)
      {
        std::memcpy(room(r, this->Sizes[r]), from, this->Sizes[r]);
      }
      from += this->Sizes[r];
    }
  }
  else
  {
    this->ready([&] {
      for (int r = 0; r < this->size(); ++r)
      {
        this->Rooms[r] = this->Sizes[r] > 0 ? room(r, this->Sizes[r]) : nullptr;
      }
      std::copy_n(mine.data, mine.size, this->Rooms[this->rank()]);
    });
    const Index step = this->longestMessage();
    for (int r = 0; r < this->size(); ++r)
    {
      for (Index begin = 0; begin < this->Sizes[r]; begin += step)
      {
        this->moved([&] { this->broadcast(this->Rooms[r] + begin, std::min(step, this->Sizes[r] - begin), r); });
      }
    }
  }
}

void RankGroup::gatherBytes(const Span& mine, std::size_t unit, const Room& room) const
{
  this->collect(Wish::Gather, mine, unit, room);
  for (int r = 0; r < this->size(); ++r)
  {
    this->Received += r == this->rank() ? 0 : this->Sizes[r];
  }
}

void RankGroup::exchangeBytes(const std::vector<Span>& toRank, std::size_t unit, const Room& room) const
{
  // Who sends how much to whom; most pairs of ranks exchange nothing.
  std::vector<Message> mine;
  std::vector<std::vector<Message>> messages(this->size());
  for (int r = 0; r < this->size(); ++r)
  {
    if (r != this->rank() && toRank[r].size > 0)
    {
      mine.push_back({ r, toRank[r].size });
    }
  }
  const Span table{ reinterpret_cast<const char*>(mine.data()), static_cast<Index>(mine.size() * sizeof(Message)) };
  this->collect(Wish::Exchange, table, unit, [&](int r, Index bytes) {
    messages[r].resize(static_cast<std::size_t>(bytes) / sizeof(Message));
    return reinterpret_cast<char*>(messages[r].data());
  });
  if (std::all_of(messages.begin(), messages.end(), [](const auto& list) { return list.empty(); }))
  {
    return;
  }
  this->ready([&] {
    std::fill(this->Sizes.begin(), this->Sizes.end(), 0);
    for (int r = 0; r < this->size(); ++r)
    {
      for (const Message& message : messages[r])
      {
        if (message.to == this->rank())
        {
          this->Sizes[r] = message.bytes;
          this->Rooms[r] = room(r, message.bytes);
        }
      }
    }
  });
  this->moved([&] { this->transfer(toRank); });
}

/// Every pair in one order on all ranks, the lower rank first: no two wait for each other.
void RankGroup::transfer(const std::vector<Span>& toRank) const
{
  const Index step = this->longestMessage();
  const auto sendTo = [&](int other) {
    for (Index begin = 0; begin < toRank[other].size; begin += step)
    {
      this->send(toRank[other].data + begin, std::min(step, toRank[other].size - begin), other);
    }
  };
  const auto receiveFrom = [&](int other) {
    for (Index begin = 0; begin < this->Sizes[other]; begin += step)
    {
      this->receive(this->Rooms[other] + begin, std::min(step, this->Sizes[other] - begin), other);
    }
    this->Received += this->Sizes[other];
  };
  // Round r pairs the ranks whose numbers add up to r modulo the number of ranks.
  for (int round = 0; round < this->size(); ++round)
  {
    const int other = (round - this->rank() + this->size()) % this->size();
    if (other > this->rank())
    {
      sendTo(other);
      receiveFrom(other);
    }
    else if (other < this->rank())
    {
      receiveFrom(other);
      sendTo(other);
    }
  }
}

} // namespace bsv
