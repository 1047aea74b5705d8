// SPDX-License-Identifier: BSD-3-Clause
/// @file Ranks.h
/// The processes that share a mesh. Each has the points of some of its blocks, and all know of all blocks.
///
/// Functions of the core that take an Execution are collective where its `ranks` are several: all ranks call them with
/// the same options, in the same order.
#pragma once

#include "Base/Types.h"

#include <cstring>
#include <type_traits>
#include <vector>

namespace bsv
{

/// An error at a numbered place. Of the errors that several ranks throw in Ranks::together(), the one at the lowest
/// place is thrown on all: the one that a process alone, which goes through all places in order, meets first.
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

/// One process of several. This class is the one of a process that is alone; others override the protected methods.
class Ranks
{
public:
  using Bytes = std::vector<char>;

  virtual ~Ranks() = default;
  /// This process, 0 <= rank() < size().
  virtual int rank() const { return 0; }
  virtual int size() const { return 1; }

  /// @name Collective: every rank calls them
  ///@{
  /// What every rank gave, in the order of the ranks.
  template <typename T>
  std::vector<std::vector<T>> gather(const std::vector<T>& mine) const
  {
    return this->unpacked<T>(this->counted(this->gatherBytes(packed(mine))));
  }
  /// The same as one list.
  template <typename T>
  std::vector<T> gatherAll(const std::vector<T>& mine) const
  {
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
    std::vector<Bytes> bytes;
    for (std::vector<T>& part : toRank)
    {
      bytes.push_back(packed(part));
      std::vector<T>().swap(part);
    }
    return this->unpacked<T>(this->counted(this->exchangeBytes(std::move(bytes))));
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
    return this->exchange(answers);
  }
  /// Whether it is true on any rank.
  bool any(bool mine) const;
  /// Runs `body`, which communicates with no other rank. If it throws on any of them, one of the exceptions is thrown
  /// on all, as Error or Aborted: that of the first rank, or of several ErrorAt the one at the lowest place.
  template <typename Body>
  void together(const Body& body) const
  {
    if (this->size() == 1)
    {
      body();
      return;
    }
    this->agree(body);
  }
  ///@}

  /// Bytes that came from other ranks so far.
  Index receivedBytes() const { return this->Received; }

protected:
  virtual std::vector<Bytes> gatherBytes(const Bytes& mine) const { return { mine }; }
  virtual std::vector<Bytes> exchangeBytes(std::vector<Bytes> toRank) const { return toRank; }

private:
  template <typename T>
  static Bytes packed(const std::vector<T>& values)
  {
    static_assert(std::is_trivially_copyable<T>::value, "only plain memory can be sent");
    Bytes bytes(values.size() * sizeof(T));
    if (!values.empty())
    {
      std::memcpy(bytes.data(), static_cast<const void*>(values.data()), bytes.size());
    }
    return bytes;
  }
  template <typename T>
  static std::vector<std::vector<T>> unpacked(std::vector<Bytes> parts)
  {
    std::vector<std::vector<T>> result;
    for (Bytes& bytes : parts)
    {
      result.emplace_back(bytes.size() / sizeof(T));
      if (!bytes.empty())
      {
        std::memcpy(static_cast<void*>(result.back().data()), bytes.data(), bytes.size());
      }
      Bytes().swap(bytes);
    }
    return result;
  }
  std::vector<Bytes> counted(std::vector<Bytes> parts) const;
  void agree(const std::function<void()>& body) const;

  mutable Index Received = 0;
};

/// A rank for every block: about as many points on each, and blocks that follow each other together.
/// @param points number of points per block. @param size number of ranks, at least 1; some may get no block.
std::vector<int> distributeBlocks(const std::vector<Index>& points, int size);

} // namespace bsv
