// SPDX-License-Identifier: BSD-3-Clause
/// @file ControllerRanks.h
/// The ranks of a vtkMultiProcessController, for the core.
#pragma once

#include "Ranks/Ranks.h"

#include "BSplineVolumeFiltersModule.h"

#include <memory>

namespace bsv
{

/// The processes of vtkMultiProcessController::GetGlobalController(): those of a pvserver or of pvbatch, or this one
/// alone.
BSPLINEVOLUMEFILTERS_EXPORT std::shared_ptr<const Ranks> globalRanks();

/// While it lives, globalRanks() of the calling thread returns `ranks`: so tests run several ranks in one process.
class BSPLINEVOLUMEFILTERS_EXPORT RanksOfThread
{
public:
  explicit RanksOfThread(std::shared_ptr<const Ranks> ranks);
  ~RanksOfThread();
  RanksOfThread(const RanksOfThread&) = delete;
  RanksOfThread& operator=(const RanksOfThread&) = delete;
};

} // namespace bsv
