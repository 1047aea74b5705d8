// SPDX-License-Identifier: BSD-3-Clause
/// @file ControllerRanks.h
/// The ranks of a vtkMultiProcessController, for the core.
#pragma once

#include "Ranks/Ranks.h"

#include <memory>

namespace bsv
{

/// The processes of vtkMultiProcessController::GetGlobalController(): those of a pvserver or of pvbatch, or this one
/// alone.
std::shared_ptr<const Ranks> globalRanks();

} // namespace bsv
