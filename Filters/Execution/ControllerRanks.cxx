// SPDX-License-Identifier: BSD-3-Clause
#include "Execution/ControllerRanks.h"

#include "Ranks/RankGroup.h"

#include <vtkMultiProcessController.h>

#include <cstdlib>
#include <iostream>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace bsv
{
namespace
{

thread_local std::shared_ptr<const Ranks> ofThread;

class ControllerRanks : public RankGroup
{
public:
  explicit ControllerRanks(vtkMultiProcessController* controller)
    : RankGroup(controller->GetNumberOfProcesses())
    , Controller(controller)
    , Sizes(controller->GetNumberOfProcesses())
    , Offsets(controller->GetNumberOfProcesses())
  {
  }
  const vtkMultiProcessController* controller() const { return this->Controller; }
  int rank() const override { return this->Controller->GetLocalProcessId(); }
  int size() const override { return static_cast<int>(this->Sizes.size()); }

protected:
  void allGather(const char* mine, Index size, char* all) const override
  {
    check(this->Controller->AllGather(mine, all, size), "AllGather");
  }
  void allGather(const char* mine, const std::vector<Index>& sizes, char* all) const override
  {
    vtkIdType total = 0;
    for (std::size_t r = 0; r < sizes.size(); ++r)
    {
      this->Sizes[r] = sizes[r];
      this->Offsets[r] = total;
      total += sizes[r];
    }
    check(this->Controller->AllGatherV(mine, all, sizes[this->rank()], this->Sizes.data(), this->Offsets.data()),
      "AllGatherV");
  }
  void broadcast(char* data, Index size, int root) const override
  {
    check(this->Controller->Broadcast(data, size, root), "Broadcast");
  }
  void send(const char* data, Index size, int to) const override
  {
    check(this->Controller->Send(data, size, to, Tag), "Send");
  }
  void receive(char* data, Index size, int from) const override
  {
    check(this->Controller->Receive(data, size, from, Tag), "Receive");
  }
  void abandon(const char* why) const override
  {
    // The others wait for this process, and only its end tells them: what started the processes then ends them all.
    std::cerr << "Rank " << this->rank() << " of " << this->size() << " ends, as communication failed: " << why
              << std::endl;
    std::_Exit(EXIT_FAILURE);
  }

private:
  static constexpr int Tag = 7291;

  static void check(int success, const char* call)
  {
    if (!success)
    {
      throw Error(std::string("vtkMultiProcessController::") + call + " failed");
    }
  }

  vtkMultiProcessController* Controller;
  mutable std::vector<vtkIdType> Sizes, Offsets;
};

} // namespace

RanksOfThread::RanksOfThread(std::shared_ptr<const Ranks> ranks)
{
  ofThread = std::move(ranks);
}
RanksOfThread::~RanksOfThread()
{
  ofThread = nullptr;
}

std::shared_ptr<const Ranks> globalRanks()
{
  if (ofThread)
  {
    return ofThread;
  }
  vtkMultiProcessController* controller = vtkMultiProcessController::GetGlobalController();
  if (!controller || controller->GetNumberOfProcesses() == 1)
  {
    return aloneRank();
  }
  // One object for all filters: it knows which scopes are open.
  static std::mutex guard;
  static std::shared_ptr<const ControllerRanks> group;
  const std::lock_guard<std::mutex> lock(guard);
  if (!group || group->controller() != controller || group->size() != controller->GetNumberOfProcesses())
  {
    group = std::make_shared<ControllerRanks>(controller);
  }
  return group;
}

} // namespace bsv
