// SPDX-License-Identifier: BSD-3-Clause
/// @file Ranks.h
/// The processes that share a mesh. Each has the points of some of its blocks, and all know of all blocks.
///
/// Functions of the core that take an Execution are collective where its `ranks` are several: all ranks call them with
/// the same options, in the same order.
///
/// An error needs no care: a rank that throws leaves its scope (Ranks::together(), opened once per filter, reader or
/// writer), and the others throw the same error from the next function in which they communicate.
#pragma once

#include "Base/Types.h"

#include <cstring>
#include <type_traits>
#include <vector>

namespace bsv
{

/// An error at a numbered place, such as a block. If several ranks fail in one step, all throw the error with the
/// lowest place, the first one that a serial run would report.
class ErrorAt : public Error
{
public:
  ErrorAt(Index place, const std::string& text)
    : Error(text)
    , Place(place)
  {
  }
  Index place() const { return this->Place; }

private:
  Index Place;
};

/// One process of several. This class is the one of a process that is alone; RankGroup is one of several.
class Ranks
{
public:
  virtual ~Ranks() = default;
  /// This process, 0 <= rank() < size().
  virtual int rank() const { return 0; }
  virtual int size() const { return 1; }

  /// @name Collective: every rank calls them
  /// They throw if another rank failed before it got to them.
  ///@{
  /// What every rank gave, in the order of the ranks.
  template <typename T>
  std::vector<std::vector<T>> gather(const std::vector<T>& mine) const
  {
    static_assert(std::is_trivially_copyable<T>::value, "only plain memory can be sent");
    if (this->size() == 1)
    {
      return { mine };
    }
    std::vector<std::vector<T>> all(this->size());
    this->gatherBytes(bytesOf(mine), sizeof(T), roomIn(all));
    return all;
  }
  /// The same as one list.
  template <typename T>
  std::vector<T> gatherAll(const std::vector<T>& mine) const
  {
    if (this->size() == 1)
    {
      return mine;
    }
    std::vector<T> all;
    for (const std::vector<T>& part : this->gather(mine))
    {
      all.insert(all.end(), part.begin(), part.end());
    }
    return all;
  }
  /// toRank[r] goes to rank r; returns what came from each.
  template <typename T>
  std::vector<std::vector<T>> exchange(std::vector<std::vector<T>> toRank) const
  {
    static_assert(std::is_trivially_copyable<T>::value, "only plain memory can be sent");
    if (this->size() == 1)
    {
      return toRank;
    }
    std::vector<Span> messages;
    messages.reserve(toRank.size());
    for (const std::vector<T>& part : toRank)
    {
      messages.push_back(bytesOf(part));
    }
    std::vector<std::vector<T>> received(this->size());
    this->exchangeBytes(messages, sizeof(T), roomIn(received));
    received[this->rank()] = std::move(toRank[this->rank()]);
    return received;
  }
  /// Gives all ranks the value n of the rank ownerOf(n), for all n.
  template <typename T, typename OwnerOf>
  void share(std::vector<T>& values, const OwnerOf& ownerOf) const
  {
    if (this->size() == 1)
    {
      return;
    }
    std::vector<T> mine;
    for (Index n = 0; n < static_cast<Index>(values.size()); ++n)
    {
      if (ownerOf(n) == this->rank())
      {
        mine.push_back(values[n]);
      }
    }
    const std::vector<std::vector<T>> parts = this->gather(mine);
    std::vector<std::size_t> next(parts.size(), 0);
    for (Index n = 0; n < static_cast<Index>(values.size()); ++n)
    {
      values[n] = parts[ownerOf(n)][next[ownerOf(n)]++];
    }
  }
  /// questions[r] go to rank r, which answers each with answer(question); returns the answers in the same places.
  template <typename Question, typename Answer>
  auto ask(const std::vector<std::vector<Question>>& questions, const Answer& answer) const
  {
    std::vector<std::vector<decltype(answer(questions[0][0]))>> answers;
    for (const std::vector<Question>& part : this->exchange(questions))
    {
      answers.emplace_back();
      answers.back().reserve(part.size());
      for (const Question& question : part)
      {
        answers.back().push_back(answer(question));
      }
    }
    return this->exchange(std::move(answers));
  }
  /// Whether it is true on any rank.
  bool any(bool mine) const;
  /// Runs `body`, which may communicate. If it throws on any rank, all ranks throw one error, as Error or Aborted: of
  /// those of the earliest step the one at the lowest ErrorAt::place(); without a place before all places, from the
  /// first rank first.
  ///
  /// One such scope around all that a filter does is enough. A scope in a scope is for errors that are caught on all
  /// ranks, who then go on together.
  /// @param parameters what must be the same on all ranks, a line for each; else that is the error.
  template <typename Body>
  void together(const Body& body, const std::function<std::string()>& parameters = nullptr) const
  {
    if (this->size() == 1)
    {
      body();
      return;
    }
    this->runTogether(body, parameters);
  }
  /// A new step begins: its errors come after those of the steps before it, at whatever place. Sends nothing. Every
  /// other collective function begins a step, too.
  virtual void nextStep() const {}
  ///@}

  /// Bytes that came from other ranks so far.
  virtual Index receivedBytes() const { return 0; }

protected:
  struct Span
  {
    const char* data;
    Index size;
  };
  /// Room for what comes from a rank; called once for every rank that sends something. May throw.
  using Room = std::function<char*(int rank, Index bytes)>;

  /// @name The second argument is the size of a value, the same on all ranks
  ///@{
  virtual void gatherBytes(const Span&, std::size_t, const Room&) const {}
  virtual void exchangeBytes(const std::vector<Span>&, std::size_t, const Room&) const {}
  ///@}
  virtual void runTogether(const std::function<void()>& body, const std::function<std::string()>&) const { body(); }

private:
  template <typename T>
  static Span bytesOf(const std::vector<T>& values)
  {
    return { reinterpret_cast<const char*>(values.data()), static_cast<Index>(values.size() * sizeof(T)) };
  }
  template <typename T>
  static Room roomIn(std::vector<std::vector<T>>& parts)
  {
    return [&parts](int rank, Index bytes) {
      parts[rank].resize(static_cast<std::size_t>(bytes) / sizeof(T));
      return reinterpret_cast<char*>(parts[rank].data());
    };
  }
};

/// A rank for every block: about as many points on each, and blocks that follow each other together.
/// @param points number of points per block. @param size number of ranks, at least 1; some may get no block.
std::vector<int> distributeBlocks(const std::vector<Index>& points, int size);

} // namespace bsv
