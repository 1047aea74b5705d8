// SPDX-License-Identifier: BSD-3-Clause
#include "Execution/ControllerRanks.h"

#include <vtkMultiProcessController.h>

#include <algorithm>

namespace bsv
{
namespace
{

class ControllerRanks : public Ranks
{
public:
  explicit ControllerRanks(vtkMultiProcessController* controller)
    : Controller(controller)
  {
  }
  int rank() const override { return this->Controller->GetLocalProcessId(); }
  int size() const override { return this->Controller->GetNumberOfProcesses(); }

protected:
  std::vector<Bytes> gatherBytes(const Bytes& mine) const override
  {
    const vtkIdType length = static_cast<vtkIdType>(mine.size());
    std::vector<vtkIdType> lengths(this->size()), offsets(this->size());
    this->Controller->AllGather(&length, lengths.data(), 1);
    vtkIdType total = 0;
    for (int r = 0; r < this->size(); ++r)
    {
      offsets[r] = total;
      total += lengths[r];
    }
    Bytes all(total);
    this->Controller->AllGatherV(mine.data(), all.data(), length, lengths.data(), offsets.data());
    std::vector<Bytes> parts;
    for (int r = 0; r < this->size(); ++r)
    {
      parts.emplace_back(all.begin() + offsets[r], all.begin() + offsets[r] + lengths[r]);
    }
    return parts;
  }

  std::vector<Bytes> exchangeBytes(std::vector<Bytes> toRank) const override
  {
    // Who sends how much to whom; most pairs of ranks exchange nothing.
    struct Message
    {
      vtkIdType to, length;
    };
    std::vector<Message> mine;
    for (int r = 0; r < this->size(); ++r)
    {
      if (r != this->rank() && !toRank[r].empty())
      {
        mine.push_back({ r, static_cast<vtkIdType>(toRank[r].size()) });
      }
    }
    Bytes packed(mine.size() * sizeof(Message));
    std::copy_n(reinterpret_cast<const char*>(mine.data()), packed.size(), packed.begin());
    const std::vector<Bytes> all = this->gatherBytes(packed);

    // Every pair in one order on all ranks, the lower rank first: no two wait for each other.
    std::vector<Bytes> received(this->size());
    received[this->rank()] = std::move(toRank[this->rank()]);
    const auto lengthOf = [&](int from, int to) {
      const Message* messages = reinterpret_cast<const Message*>(all[from].data());
      for (std::size_t m = 0; m < all[from].size() / sizeof(Message); ++m)
      {
        if (messages[m].to == to)
        {
          return messages[m].length;
        }
      }
      return vtkIdType(0);
    };
    constexpr int Tag = 7291;
    const auto send = [&](int to) {
      if (!toRank[to].empty())
      {
        this->Controller->Send(toRank[to].data(), static_cast<vtkIdType>(toRank[to].size()), to, Tag);
      }
    };
    const auto receive = [&](int from) {
      received[from].resize(lengthOf(from, this->rank()));
      if (!received[from].empty())
      {
        this->Controller->Receive(received[from].data(), static_cast<vtkIdType>(received[from].size()), from, Tag);
      }
    };
    // Round r pairs the ranks whose numbers add up to r modulo the number of ranks.
    for (int round = 0; round < this->size(); ++round)
    {
      const int other = (round - this->rank() + this->size()) % this->size();
      if (other > this->rank())
      {
        send(other);
        receive(other);
      }
      else if (other < this->rank())
      {
        receive(other);
        send(other);
      }
    }
    return received;
  }

private:
  vtkMultiProcessController* Controller;
};

} // namespace

std::shared_ptr<const Ranks> globalRanks()
{
  vtkMultiProcessController* controller = vtkMultiProcessController::GetGlobalController();
  return controller && controller->GetNumberOfProcesses() > 1 ? std::make_shared<ControllerRanks>(controller)
                                                              : aloneRank();
}

} // namespace bsv
