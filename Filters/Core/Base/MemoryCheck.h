// SPDX-License-Identifier: BSD-3-Clause
/// @file MemoryCheck.h
/// Refuses what cannot fit into the free memory before anything is allocated.
#pragma once

#include "Base/Types.h"

#include <string>
#include <utility>

namespace bsv
{

/// Bytes that tests pretend are free at most; infinite.
double& pretendedFreeMemory();

/// Bytes that this process can still get: what the machine has available, and no more than the limits of the control
/// groups (version 1 and 2) and of the address space (RLIMIT_AS) leave.
double freeMemory();

/// @param request what the user asked for. @param content what the memory is for.
/// @throws Error if `bytes` exceed freeMemory().
void requireMemory(double bytes, const std::string& request, const std::string& content);

/// requireMemory() for what is needed bit by bit, before it is filled. The machine is asked now and then, which takes
/// time.
class MemoryDemand
{
public:
  MemoryDemand(std::string request, std::string content)
    : Request(std::move(request))
    , Content(std::move(content))
  {
  }

  /// @throws Error
  void add(double bytes)
  {
    constexpr double Often = 6.4e7;
    this->Bytes += bytes;
    if (!this->Asked || this->Bytes > Often)
    {
      requireMemory(this->Bytes, this->Request, this->Content);
      this->Asked = true;
      this->Bytes = 0.0;
    }
  }

private:
  std::string Request;
  std::string Content;
  double Bytes = 0.0;
  bool Asked = false;
};

/// The text of the one error that std::bad_alloc becomes.
std::string outOfMemory();

} // namespace bsv
