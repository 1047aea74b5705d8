// SPDX-License-Identifier: BSD-3-Clause
/// @file RankGroup.h
/// One of several ranks: how messages and failures travel between them.
#pragma once

#include "Ranks/Ranks.h"

#include <cstdint>
#include <string>
#include <vector>

namespace bsv
{

/// One of several ranks. Derived classes move bytes; here is what is sent, when.
///
/// Every collective function begins with one record of each rank to all: what it wants to do, or that it failed. A rank
/// that failed goes to the end of its scope and sends its record there; so the record of a failure meets the records of
/// whatever the others do next. All ranks see the same records, come to the same verdict, and only if all want to do
/// the same do data follow. Memory for data of others is there before they are sent. Between the record and the data
/// nothing can fail on one rank only, but the transport itself.
class RankGroup : public Ranks
{
public:
  explicit RankGroup(int size);
  RankGroup(const RankGroup&) = delete;
  RankGroup& operator=(const RankGroup&) = delete;

  void nextStep() const override { ++this->Steps; }
  Index receivedBytes() const override { return this->Received; }

protected:
  /// @name Transport. Collective, but for send() and receive(). What they throw ends the group: see abandon()
  ///@{
  /// `size` bytes of every rank, in their order, to all.
  virtual void allGather(const char* mine, Index size, char* all) const = 0;
  /// The same with sizes[r] bytes of rank r.
  virtual void allGather(const char* mine, const std::vector<Index>& sizes, char* all) const = 0;
  /// `size` bytes of `root` to all.
  virtual void broadcast(char* data, Index size, int root) const = 0;
  virtual void send(const char* data, Index size, int to) const = 0;
  virtual void receive(char* data, Index size, int from) const = 0;
  /// The transport failed here. Others may wait for this rank for ever if nobody ends them.
  virtual void abandon(const char* /*why*/) const {}
  /// No broadcast, send or receive has more bytes; longer messages are split.
  virtual Index longestMessage() const { return Index(1) << 26; }
  ///@}

  void gatherBytes(const Span& mine, std::size_t unit, const Room& room) const override;
  void exchangeBytes(const std::vector<Span>& toRank, std::size_t unit, const Room& room) const override;
  void runTogether(const std::function<void()>& body, const std::function<std::string()>& parameters) const override;

private:
  /// What a rank wants to do.
  enum class Wish : std::uint8_t
  {
    Gather,
    Exchange,
    Transfer,
    EndScope
  };
  enum class State : std::uint8_t
  {
    Well,
    Stopped,
    Failed
  };
  struct Record
  {
    Index step, place, bytes, textBytes, parameterBytes;
    std::uint64_t parameters;
    std::uint32_t unit;
    std::uint16_t depth;
    Wish wish;
    State state;
    char content[72];
  };
  struct Message
  {
    Index to, bytes;
  };

  void meet(Wish wish, const Span& content = { nullptr, 0 }, std::size_t unit = 0) const;
  void collect(Wish wish, const Span& mine, std::size_t unit, const Room& room) const;
  void transfer(const std::vector<Span>& toRank) const;
  template <typename Work>
  void ready(const Work& work) const;
  template <typename Work>
  void moved(const Work& work) const;
  template <typename Work>
  bool failed(const Work& work) const;
  void setText(const char* text) const;
  void judge() const;
  void judgeParameters(int other) const;
  [[noreturn]] void throwVerdict() const;

  // A collective function changes the state of the group, not the group.
  mutable Index Received = 0;
  mutable Index Steps = 0;
  mutable int Depth = 0;
  /// Own failure on its way to the others.
  mutable State Mine = State::Well;
  mutable Index Place = 0;
  mutable std::string Text;
  mutable std::string Parameters;
  mutable std::uint64_t ParametersHash = 0;
  /// The end of all scopes from OverDepth on, until they are left.
  mutable State Verdict = State::Well;
  mutable int OverDepth = 0;
  mutable std::string VerdictText;
  // What communication needs is allocated beforehand.
  mutable std::vector<Record> Records;
  mutable std::vector<Index> Sizes;
  mutable std::vector<char*> Rooms;
  mutable std::vector<char> Scratch;
};

} // namespace bsv
