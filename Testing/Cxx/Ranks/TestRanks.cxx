// SPDX-License-Identifier: BSD-3-Clause
#include "Mesh/PointExchange.h"
#include "Support/ThreadRanks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

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
