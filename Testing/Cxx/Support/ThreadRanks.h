// SPDX-License-Identifier: BSD-3-Clause
/// @file ThreadRanks.h
/// Ranks in one process, each a thread, so that any number of them can be tested without MPI.
#pragma once

#include "Mesh/BlockMesh.h"
#include "Ranks/Ranks.h"

#include <condition_variable>
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
  using Bytes = bsv::Ranks::Bytes;

  explicit Exchange(int size)
    : Posts(size)
  {
  }
  int size() const { return static_cast<int>(this->Posts.size()); }

  /// Posts one message per rank and waits for those to `rank`.
  std::vector<Bytes> pass(int rank, std::vector<Bytes> toRank)
  {
    this->Posts[rank] = std::move(toRank);
    this->meet();
    std::vector<Bytes> received;
    for (const std::vector<Bytes>& post : this->Posts)
    {
      received.push_back(post[rank]);
    }
    this->meet();
    return received;
  }
  /// Ends all ranks that wait for one that left.
  void leave()
  {
    const std::lock_guard<std::mutex> lock(this->Guard);
    this->Left = true;
    this->Arrival.notify_all();
  }

private:
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
    this->Arrival.wait(lock, [&] { return this->Round != round || this->Left; });
    if (this->Round == round)
    {
      throw bsv::Error("another rank does not communicate any more");
    }
  }

  std::vector<std::vector<Bytes>> Posts;
  std::mutex Guard;
  std::condition_variable Arrival;
  int Waiting = 0;
  int Round = 0;
  bool Left = false;
};

class ThreadRank : public bsv::Ranks
{
public:
  ThreadRank(Exchange& exchange, int rank)
    : Shared(exchange)
    , Rank(rank)
  {
  }
  int rank() const override { return this->Rank; }
  int size() const override { return this->Shared.size(); }

protected:
  std::vector<Bytes> gatherBytes(const Bytes& mine) const override
  {
    return this->Shared.pass(this->Rank, std::vector<Bytes>(this->size(), mine));
  }
  std::vector<Bytes> exchangeBytes(std::vector<Bytes> toRank) const override
  {
    return this->Shared.pass(this->Rank, std::move(toRank));
  }

private:
  Exchange& Shared;
  int Rank;
};

/// Runs work(run) on `size` ranks at once, `run.ranks` being each rank's own.
/// @return per rank the text of the exception that ended it, empty if none did.
template <typename Work>
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
        run.ranks = std::make_shared<ThreadRank>(exchange, rank);
        work(run);
      }
      catch (const std::exception& error)
      {
        errors[rank] = error.what();
      }
      if (!errors[rank].empty())
      {
        exchange.leave();
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
