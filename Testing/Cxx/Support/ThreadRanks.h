// SPDX-License-Identifier: BSD-3-Clause
/// @file ThreadRanks.h
/// Ranks in one process, each a thread, so that any number of them can be tested without MPI.
#pragma once

#include "Mesh/BlockMesh.h"
#include "Ranks/RankGroup.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace bsvtest
{

/// What the ranks of one run share.
class Exchange
{
public:
  explicit Exchange(int size)
    : Posts(size)
    , Mail(std::size_t(size) * size)
  {
  }
  int size() const { return static_cast<int>(this->Posts.size()); }

  /// Shows `mine` to all ranks, who look at what they want of the posts of all while they are there.
  template <typename Look>
  void show(int rank, const char* mine, const Look& look)
  {
    this->Posts[rank] = mine;
    this->meet();
    look(this->Posts);
    this->meet();
  }
  void send(int from, int to, const char* data, bsv::Index size)
  {
    const std::lock_guard<std::mutex> lock(this->Guard);
    this->Mail[from * this->size() + to].emplace_back(data, data + size);
    this->Arrival.notify_all();
  }
  void receive(int from, int to, char* data, bsv::Index size)
  {
    std::unique_lock<std::mutex> lock(this->Guard);
    std::deque<std::vector<char>>& box = this->Mail[from * this->size() + to];
    this->Arrival.wait_for(lock, Patience, [&] { return !box.empty() || this->Left; });
    if (box.empty() || static_cast<bsv::Index>(box.front().size()) != size)
    {
      throw bsv::Error("no message of this length comes from another rank");
    }
    std::copy(box.front().begin(), box.front().end(), data);
    box.pop_front();
  }
  /// Ends all ranks that wait for one that left.
  void leave()
  {
    const std::lock_guard<std::mutex> lock(this->Guard);
    this->Left = true;
    this->Arrival.notify_all();
  }

private:
  /// A rank that waits so long would wait for ever.
  static constexpr std::chrono::seconds Patience{ 300 };

  void meet()
  {
    std::unique_lock<std::mutex> lock(this->Guard);
    const int round = this->Round;
    if (++this->Waiting == this->size())
    {
      this->Waiting = 0;
      ++this->Round;
      this->Arrival.notify_all();
    }
    this->Arrival.wait_for(lock, Patience, [&] { return this->Round != round || this->Left; });
    if (this->Round == round)
    {
      throw bsv::Error("another rank does not communicate any more");
    }
  }

  std::vector<const char*> Posts;
  std::vector<std::deque<std::vector<char>>> Mail;
  std::mutex Guard;
  std::condition_variable Arrival;
  int Waiting = 0;
  int Round = 0;
  bool Left = false;
};

class ThreadRank : public bsv::RankGroup
{
public:
  ThreadRank(Exchange& exchange, int rank)
    : RankGroup(exchange.size())
    , Shared(exchange)
    , Rank(rank)
  {
  }
  int rank() const override { return this->Rank; }
  int size() const override { return this->Shared.size(); }

protected:
  void allGather(const char* mine, bsv::Index size, char* all) const override
  {
    this->allGather(mine, std::vector<bsv::Index>(this->size(), size), all);
  }
  void allGather(const char* mine, const std::vector<bsv::Index>& sizes, char* all) const override
  {
    this->Shared.show(this->Rank, mine, [&](const std::vector<const char*>& posts) {
      for (int r = 0; r < this->size(); ++r)
      {
        all = std::copy_n(posts[r], sizes[r], all);
      }
    });
  }
  void broadcast(char* data, bsv::Index size, int root) const override
  {
    this->Shared.show(this->Rank, data, [&](const std::vector<const char*>& posts) {
      if (root != this->Rank)
      {
        std::copy_n(posts[root], size, data);
      }
    });
  }
  void send(const char* data, bsv::Index size, int to) const override { this->Shared.send(this->Rank, to, data, size); }
  void receive(char* data, bsv::Index size, int from) const override
  {
    this->Shared.receive(from, this->Rank, data, size);
  }
  void abandon(const char*) const override { this->Shared.leave(); }

private:
  Exchange& Shared;
  int Rank;
};

/// Runs work(run) on `size` ranks at once, in one scope, `run.ranks` being each rank's own.
/// @return per rank the text of the exception that ended it, empty if none did.
template <typename Rank = ThreadRank, typename Work>
std::vector<std::string> onRanks(int size, const Work& work)
{
  Exchange exchange(size);
  std::vector<std::string> errors(size);
  std::vector<std::thread> threads;
  for (int rank = 0; rank < size; ++rank)
  {
    threads.emplace_back([&, rank] {
      try
      {
        bsv::Execution run;
        run.ranks = std::make_shared<Rank>(exchange, rank);
        run.ranks->together([&] { work(run); });
      }
      catch (const std::exception& error)
      {
        errors[rank] = error.what();
      }
    });
  }
  for (std::thread& thread : threads)
  {
    thread.join();
  }
  return errors;
}

/// What rank `rank` has of a mesh whose block b is on rank rankOf[b]. `mesh` must outlive it.
inline bsv::BlockMesh distributed(const bsv::BlockMesh& mesh, const std::vector<int>& rankOf, int rank)
{
  bsv::BlockMesh part = mesh;
  for (std::size_t b = 0; b < part.blocks.size(); ++b)
  {
    bsv::MeshBlock& block = part.blocks[b];
    block.rank = rankOf[b];
    if (block.rank != rank)
    {
      block.points = bsv::GridView::elsewhere(block.points.counts());
      block.creaseSharpness.clear();
    }
  }
  return part;
}

} // namespace bsvtest
