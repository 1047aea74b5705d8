// SPDX-License-Identifier: BSD-3-Clause
/// @file MemoryCheck.h
/// Refuses what cannot fit into the free memory before anything is allocated.
#pragma once

#include "Base/Types.h"

#include "BSplineVolumeFiltersModule.h"

#include <string>

namespace bsv
{

/// Bytes that this process can still get: what the machine has available, and no more than the limits of the control
/// groups (version 1 and 2) and of the address space (RLIMIT_AS) leave.
BSPLINEVOLUMEFILTERS_EXPORT double freeMemory();

/// @param request what the user asked for. @param content what the memory is for.
/// @throws Error if `bytes` exceed freeMemory().
BSPLINEVOLUMEFILTERS_EXPORT void requireMemory(double bytes, const std::string& request, const std::string& content);

/// The text of the one error that std::bad_alloc becomes.
BSPLINEVOLUMEFILTERS_EXPORT std::string outOfMemory();

} // namespace bsv
