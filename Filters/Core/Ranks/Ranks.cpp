// SPDX-License-Identifier: BSD-3-Clause
#include "Ranks/Ranks.h"

#include <algorithm>
#include <limits>

namespace bsv
{

std::shared_ptr<const Ranks> aloneRank()
{
  static const std::shared_ptr<const Ranks> alone = std::make_shared<Ranks>();
  return alone;
}

bool Ranks::any(bool mine) const
{
  const std::vector<char> all = this->gatherAll(std::vector<char>{ static_cast<char>(mine) });
  return std::find(all.begin(), all.end(), 1) != all.end();
}

std::vector<Ranks::Bytes> Ranks::counted(std::vector<Bytes> parts) const
{
  for (int r = 0; r < static_cast<int>(parts.size()); ++r)
  {
    this->Received += r == this->rank() ? 0 : static_cast<Index>(parts[r].size());
  }
  return parts;
}

void Ranks::agree(const std::function<void()>& body) const
{
  struct Ending
  {
    enum
    {
      Done,
      Stopped,
      Failed
    } kind = Done;
    Index place = std::numeric_limits<Index>::max();
  };
  Ending ending;
  std::string text;
  try
  {
    body();
  }
  catch (const Aborted&)
  {
    ending = { Ending::Stopped, -1 };
  }
  catch (const ErrorAt& error)
  {
    ending = { Ending::Failed, error.place() };
    text = error.what();
  }
  catch (const std::exception& error)
  {
    ending = { Ending::Failed, -1 };
    text = error.what();
  }
  const std::vector<Ending> endings = this->gatherAll(std::vector<Ending>{ ending });
  const auto first = std::min_element(
    endings.begin(), endings.end(), [](const Ending& a, const Ending& b) { return a.place < b.place; });
  if (first->kind == Ending::Done)
  {
    return;
  }
  const std::vector<Bytes> texts = this->gather(Bytes(text.begin(), text.end()));
  if (first->kind == Ending::Stopped)
  {
    throw Aborted();
  }
  const Bytes& chosen = texts[first - endings.begin()];
  throw Error(std::string(chosen.begin(), chosen.end()));
}

std::vector<int> distributeBlocks(const std::vector<Index>& points, int size)
{
  Index total = 0;
  for (const Index count : points)
  {
    total += count;
  }
  std::vector<int> ranks;
  Index before = 0;
  for (const Index count : points)
  {
    // The rank in whose share of all points the middle of the block lies.
    const double middle = static_cast<double>(before) + 0.5 * static_cast<double>(count);
    ranks.push_back(total > 0 ? std::min(size - 1, static_cast<int>(size * middle / static_cast<double>(total))) : 0);
    before += count;
  }
  return ranks;
}

} // namespace bsv
