// SPDX-License-Identifier: BSD-3-Clause
/// @file MemoryCheck.h
/// Refuses what cannot fit into the machine before anything is allocated.
#pragma once

#include "Base/Types.h"

#include <vtksys/SystemInformation.hxx>

#include <sstream>
#include <string>

namespace bsv
{

/// A smaller request that does not fit into what is free is left to the operating system.
/// @param request what the user asked for. @param content what the memory is for.
/// @throws Error if `bytes` exceed the memory of this machine.
inline void requireMemory(double bytes, const std::string& request, const std::string& content)
{
  vtksys::SystemInformation machine;
  const double present = static_cast<double>(machine.GetHostMemoryTotal()) * 1024;
  if (bytes > present)
  {
    std::ostringstream text;
    text << request << " needs " << bytes / 1e9 << " GB for " << content << "; this machine has " << present / 1e9
         << " GB";
    throw Error(text.str());
  }
}

} // namespace bsv
