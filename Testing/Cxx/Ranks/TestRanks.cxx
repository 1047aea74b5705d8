// SPDX-License-Identifier: BSD-3-Clause
#include "Mesh/PointExchange.h"
#include "Support/ThreadRanks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iostream>
#include <numeric>
#include <thread>

namespace
{

using bsv::Execution;
using bsv::GridView;
using bsvtest::onRanks;

TEST(Ranks, MessagesArriveInTheOrderOfTheRanks)
{
  const auto errors = onRanks(4, [](const Execution& run) {
    const int rank = run.ranks->rank();
    EXPECT_EQ(run.ranks->gatherAll(std::vector<int>(rank, rank)), (std::vector<int>{ 1, 2, 2, 3, 3, 3 }));
    std::vector<std::vector<int>> toRank;
    for (int other = 0; other < 4; ++other)
    {
      toRank.push_back({ 10 * rank + other });
    }
    const auto received = run.ranks->exchange(toRank);
    for (int other = 0; other < 4; ++other)
    {
      EXPECT_EQ(received[other], std::vector<int>{ 10 * other + rank });
    }
    EXPECT_TRUE(run.ranks->any(rank == 2));
    EXPECT_FALSE(run.ranks->any(false));
  });
  EXPECT_EQ(errors, std::vector<std::string>(4));
}

TEST(Ranks, FailureOfOneEndsAllWithItsText)
{
  const auto errors = onRanks(3, [](const Execution& run) {
    run.ranks->together([&] {
      if (run.ranks->rank() > 0)
      {
        throw bsv::Error("block " + std::to_string(run.ranks->rank()) + " is bad");
      }
    });
    ADD_FAILURE() << "nobody may go on";
  });
  EXPECT_EQ(errors, std::vector<std::string>(3, "block 1 is bad"));
}

TEST(Ranks, ErrorAtTheLowestPlaceIsThrown)
{
  const auto errors = onRanks(4, [](const Execution& run) {
    run.ranks->together([&] {
      const int place = (run.ranks->rank() + 2) % 4;
      if (place > 0)
      {
        throw bsv::ErrorAt(place, "place " + std::to_string(place));
      }
    });
  });
  EXPECT_EQ(errors, std::vector<std::string>(4, "place 1"));
}

TEST(Ranks, ErrorOfTheEarliestStepIsThrown)
{
  const auto errors = onRanks(3, [](const Execution& run) {
    const int rank = run.ranks->rank();
    for (int step = 0; step < 3; ++step)
    {
      run.ranks->nextStep();
      if (step == 2 - rank % 2)
      {
        throw bsv::ErrorAt(10 * step, "step " + std::to_string(step) + " of rank " + std::to_string(rank));
      }
    }
  });
  EXPECT_EQ(errors, std::vector<std::string>(3, "step 1 of rank 1"));
}

/// All that ranks can do together, in one scope and in a scope in it. Counts the places between.
template <typename Place>
void doEverything(const Execution& run, const Place& place)
{
  const bsv::Ranks& ranks = *run.ranks;
  place();
  ranks.gatherAll(std::vector<double>(ranks.rank(), 1.5));
  place();
  ranks.gather(std::vector<double>(100 * ranks.rank(), 1.5));
  place();
  ranks.gather(std::vector<double>(20000 * ranks.rank(), 1.5));
  place();
  std::vector<std::vector<char>> toRank(ranks.size());
  ranks.exchange(toRank);
  place();
  toRank[ranks.size() - 1].assign(100 + ranks.rank(), 'x');
  ranks.exchange(toRank);
  place();
  ranks.together([&] {
    place();
    ranks.any(true);
    place();
  });
  place();
  std::vector<std::vector<int>> questions(ranks.size(), std::vector<int>(ranks.rank(), 1));
  ranks.ask(questions, [&](int question) {
    place();
    return 2 * question;
  });
  place();
}

TEST(Ranks, FailureAnywhereEndsAllWithItsText)
{
  int tried = 0;
  for (const int size : { 2, 3 })
  {
    for (int thrower = 0; thrower < size; ++thrower)
    {
      bool reached = true;
      for (int at = 0; reached; ++at)
      {
        reached = false;
        const auto errors = onRanks(size, [&](const Execution& run) {
          int places = 0;
          doEverything(run, [&] {
            if (run.ranks->rank() == thrower && places++ == at)
            {
              reached = true;
              throw bsv::Error("here");
            }
          });
        });
        EXPECT_EQ(errors, std::vector<std::string>(size, reached ? "here" : ""));
        tried += reached ? 1 : 0;
      }
    }
  }
  std::cout << tried << " places tried\n";
}

TEST(Ranks, CaughtFailureOfAnInnerScopeIsOver)
{
  const auto errors = onRanks(3, [](const Execution& run) {
    const bsv::Ranks& ranks = *run.ranks;
    const auto inner = [&] {
      ranks.any(false);
      if (ranks.rank() == 1)
      {
        throw bsv::Error("inside");
      }
      ranks.any(false);
    };
    EXPECT_THROW(ranks.together(inner), bsv::Error);
    EXPECT_EQ(ranks.gatherAll(std::vector<int>{ ranks.rank() }), (std::vector<int>{ 0, 1, 2 }));
  });
  EXPECT_EQ(errors, std::vector<std::string>(3));
}

TEST(Ranks, SwallowedFailureEndsTheScopeAllTheSame)
{
  const auto errors = onRanks(2, [](const Execution& run) {
    if (run.ranks->rank() == 0)
    {
      throw bsv::Error("lost");
    }
    EXPECT_THROW(run.ranks->any(false), bsv::Error);
    EXPECT_THROW(run.ranks->any(false), bsv::Error);
  });
  EXPECT_EQ(errors, std::vector<std::string>(2, "lost"));
}

TEST(Ranks, DifferentStepsAreOneError)
{
  const auto different = [](const auto& work) {
    const auto errors = onRanks(3, work);
    EXPECT_EQ(errors[0].rfind("The ranks 0 and 2 do not take the same steps", 0), 0u) << errors[0];
    EXPECT_EQ(errors, std::vector<std::string>(3, errors[0]));
  };
  different([](const Execution& run) {
    if (run.ranks->rank() != 2)
    {
      run.ranks->any(true);
    }
  });
  different([](const Execution& run) {
    if (run.ranks->rank() == 2)
    {
      run.ranks->exchange(std::vector<std::vector<char>>(3));
    }
    run.ranks->any(true);
  });
  different([](const Execution& run) {
    if (run.ranks->rank() == 2)
    {
      run.ranks->gatherAll(std::vector<int>{ 1 });
    }
    run.ranks->any(true);
  });
}

TEST(Ranks, DifferentParametersAreOneError)
{
  const auto errors = onRanks(3, [](const Execution& run) { run.ranks->together([&] { run.ranks->any(true); }); });
  EXPECT_EQ(errors, std::vector<std::string>(3));

  bsvtest::Exchange exchange(3);
  std::vector<std::string> texts(3);
  std::vector<std::thread> threads;
  for (int rank = 0; rank < 3; ++rank)
  {
    threads.emplace_back([&, rank] {
      const bsvtest::ThreadRank ranks(exchange, rank);
      const auto parameters = [&] { return "Angle: 30\n  Limit: " + std::to_string(rank / 2) + "\nLast: 1\n"; };
      try
      {
        ranks.together([&] { ranks.any(true); }, parameters);
      }
      catch (const bsv::Error& error)
      {
        texts[rank] = error.what();
      }
      // It is over then.
      EXPECT_TRUE(ranks.any(rank == 1));
    });
  }
  for (std::thread& thread : threads)
  {
    thread.join();
  }
  EXPECT_EQ(texts,
    std::vector<std::string>(
      3, "The parameters are not the same on all ranks: rank 0 has 'Limit: 0', rank 2 has 'Limit: 1'."));
}

/// A transport that takes short messages only.
class ShortMessages : public bsvtest::ThreadRank
{
public:
  using ThreadRank::ThreadRank;

protected:
  bsv::Index longestMessage() const override { return 1000; }
  void broadcast(char* data, bsv::Index size, int root) const override
  {
    EXPECT_LE(size, 1000);
    ThreadRank::broadcast(data, size, root);
  }
  void send(const char* data, bsv::Index size, int to) const override
  {
    EXPECT_LE(size, 1000);
    ThreadRank::send(data, size, to);
  }
};

TEST(Ranks, LongMessagesAreSplit)
{
  const auto errors = onRanks<ShortMessages>(3, [](const Execution& run) {
    const int rank = run.ranks->rank();
    const auto values = [](int n, int count) {
      std::vector<int> list(count);
      std::iota(list.begin(), list.end(), n);
      return list;
    };
    std::vector<int> all;
    std::vector<std::vector<int>> toRank(3);
    for (int r = 0; r < 3; ++r)
    {
      const std::vector<int> part = values(r, 40000 * r + 1);
      all.insert(all.end(), part.begin(), part.end());
      toRank[r] = values(10 * rank + r, 777 * r + 1);
    }
    EXPECT_EQ(run.ranks->gatherAll(values(rank, 40000 * rank + 1)), all);
    const auto received = run.ranks->exchange(toRank);
    for (int r = 0; r < 3; ++r)
    {
      EXPECT_EQ(received[r], values(10 * r + rank, 777 * rank + 1));
    }
  });
  EXPECT_EQ(errors, std::vector<std::string>(3));
}

/// A transport whose call number `FailingCall` on rank 1 fails.
class BrokenTransport : public bsvtest::ThreadRank
{
public:
  using ThreadRank::ThreadRank;
  static int FailingCall;
  static std::atomic<bool> Failed;

protected:
  void allGather(const char* mine, bsv::Index size, char* all) const override
  {
    this->count();
    ThreadRank::allGather(mine, std::vector<bsv::Index>(this->size(), size), all);
  }
  void allGather(const char* mine, const std::vector<bsv::Index>& sizes, char* all) const override
  {
    this->count();
    ThreadRank::allGather(mine, sizes, all);
  }
  void broadcast(char* data, bsv::Index size, int root) const override
  {
    this->count();
    ThreadRank::broadcast(data, size, root);
  }
  void send(const char* data, bsv::Index size, int to) const override
  {
    this->count();
    ThreadRank::send(data, size, to);
  }
  void receive(char* data, bsv::Index size, int from) const override
  {
    this->count();
    ThreadRank::receive(data, size, from);
  }

private:
  void count() const
  {
    if (this->rank() == 1 && this->Calls++ == FailingCall)
    {
      Failed = true;
      throw bsv::Error("the cable is out");
    }
  }
  mutable int Calls = 0;
};
int BrokenTransport::FailingCall = 0;
std::atomic<bool> BrokenTransport::Failed{ false };

TEST(Ranks, FailingTransportEndsAll)
{
  do
  {
    BrokenTransport::Failed = false;
    const auto errors = onRanks<BrokenTransport>(3, [](const Execution& run) { doEverything(run, [] {}); });
    for (const std::string& error : errors)
    {
      EXPECT_EQ(!error.empty(), BrokenTransport::Failed);
    }
    ++BrokenTransport::FailingCall;
  } while (BrokenTransport::Failed);
  std::cout << BrokenTransport::FailingCall - 1 << " calls tried\n";
}

TEST(Ranks, ValuesAreSharedByTheirOwners)
{
  const auto errors = onRanks(3, [](const Execution& run) {
    const auto owner = [](bsv::Index n) { return static_cast<int>(n * n % 3); };
    std::vector<double> values(7, -1.0);
    for (bsv::Index n = 0; n < 7; ++n)
    {
      values[n] = owner(n) == run.ranks->rank() ? 0.5 * static_cast<double>(n) : -1.0;
    }
    run.ranks->share(values, owner);
    EXPECT_EQ(values, (std::vector<double>{ 0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0 }));
  });
  EXPECT_EQ(errors, std::vector<std::string>(3));
}

TEST(Ranks, AnswersComeInThePlacesOfTheirQuestions)
{
  const auto errors = onRanks(3, [](const Execution& run) {
    const int rank = run.ranks->rank();
    std::vector<std::vector<int>> questions(3);
    for (int other = 0; other < 3; ++other)
    {
      questions[other] = std::vector<int>(rank + 1, 10 * rank + other);
    }
    const auto answers = run.ranks->ask(questions, [&](int question) { return 0.25 * (100 * rank + question); });
    for (int other = 0; other < 3; ++other)
    {
      EXPECT_EQ(answers[other], std::vector<double>(rank + 1, 0.25 * (100 * other + 10 * rank + other)));
    }
  });
  EXPECT_EQ(errors, std::vector<std::string>(3));
}

TEST(Ranks, AbortOfOneEndsAll)
{
  const auto errors = onRanks(3, [](Execution run) {
    run.progress = [&](double) { return run.ranks->rank() != 1; };
    EXPECT_THROW(run.ranks->together([&] { run.report(0.5); }), bsv::Aborted);
  });
  EXPECT_EQ(errors, std::vector<std::string>(3));
}

TEST(Ranks, FetchedPointsAreThoseOfTheOwner)
{
  const std::array<int, 3> counts{ 4, 5, 6 };
  const auto errors = onRanks(3, [&](const Execution& run) {
    // Block b on rank b; block 2 in single precision. Values name block and place.
    std::vector<double> doubles(3 * 120);
    std::vector<float> floats(3 * 120);
    const int rank = run.ranks->rank();
    std::iota(doubles.begin(), doubles.end(), 1000.0 * rank);
    std::iota(floats.begin(), floats.end(), 1000.0f * rank);
    std::vector<GridView> views(3, GridView::elsewhere(counts));
    views[rank] = rank == 2 ? GridView(floats.data(), counts) : GridView(doubles.data(), counts);
    const int other = (rank + 1) % 3;
    const auto memory = bsv::fetchPoints(
      { { other, { 0, 0, 0 }, { 3, 4, 1 } }, { other, { 3, 2, 5 }, { 3, 3, 5 } }, { rank, { 0, 0, 0 }, { 1, 1, 1 } } },
      3, [](int block) { return block; }, [&](int block) -> GridView& { return views[block]; }, *run.ranks);
    EXPECT_EQ(memory.size(), 1u);
    EXPECT_TRUE(views[rank].isHere());
    EXPECT_FALSE(views[other].isHere());
    const GridView part = views[other].box({ 1, 1, 1 }, { 3, 4, 5 });
    for (const std::array<int, 3>& p : { std::array<int, 3>{ 2, 4, 1 }, { 3, 3, 5 } })
    {
      const double first = 1000.0 * other + 3 * (p[0] + 4 * (p[1] + 5 * p[2]));
      EXPECT_TRUE(views[other].has(p));
      EXPECT_EQ(views[other](p), bsv::Vec3(first, first + 1, first + 2));
      EXPECT_EQ(part(p[0] - 1, p[1] - 1, p[2] - 1), bsv::Vec3(first, first + 1, first + 2));
    }
    EXPECT_FALSE(views[other].has({ 0, 0, 2 }));
    EXPECT_THROW(views[other](0, 0, 2), bsv::Error);
    EXPECT_THROW(views[(rank + 2) % 3](0, 0, 0), bsv::Error);
    // The boxes of 2 x 4 x 5 and 2 points in double precision, and the requests for them.
    EXPECT_EQ(run.ranks->receivedBytes(), 42 * 3 * 8 + 2 * static_cast<bsv::Index>(sizeof(bsv::PointBox)));
  });
  EXPECT_EQ(errors, std::vector<std::string>(3));
}

TEST(Ranks, BlocksAreSharedOutEvenly)
{
  const std::vector<bsv::Index> points{ 10, 10, 10, 10, 5, 5, 5, 5, 40 };
  const std::vector<int> ranks = bsv::distributeBlocks(points, 3);
  EXPECT_TRUE(std::is_sorted(ranks.begin(), ranks.end()));
  std::vector<bsv::Index> load(3, 0);
  for (std::size_t b = 0; b < points.size(); ++b)
  {
    load[ranks[b]] += points[b];
  }
  // Nobody is off the mean, 33, by more than the largest block.
  for (const bsv::Index sum : load)
  {
    EXPECT_LE(std::abs(static_cast<double>(sum) - 100.0 / 3.0), 40.0);
  }
  EXPECT_EQ(bsv::distributeBlocks({ 7 }, 5).size(), 1u);
}

} // namespace
