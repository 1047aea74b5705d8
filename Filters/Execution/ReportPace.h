// SPDX-License-Identifier: BSD-3-Clause
/// @file ReportPace.h
/// How often a filter says how far it is, and asks whether to go on: loops are run in parts, with a report between two
/// of them when it is time for one.
#pragma once

#include "Base/Types.h"

#include <functional>

namespace bsv
{

/// When it is time for a report. One for the process; only tests change it, to count work in place of time.
struct ReportPace
{
  /// Seconds of the wall clock between two reports, and about as long as a part of a loop.
  double interval = 0.03;
  /// Seconds.
  std::function<double()> now;
  /// Told every range of a loop that has been run, by the thread that ran it; may be empty.
  std::function<void(Index begin, Index end)> ranRange;
};
ReportPace& reportPace();

/// The calling thread has just reported.
void reportedNow();
/// Whether the last report of the calling thread is long enough ago.
bool reportIsDue();

/// Execution::parallelFor by vtkSMPTools, in parts. Ranges are the same as without parts: whole multiples of `grain`.
///
/// An exception in a loop is handed to the calling thread, the one of the lowest range if there are several: thrown in
/// a worker thread of vtkSMPTools it would end the process.
/// @param pause called by the calling thread when a report is due; ends the loop by an exception.
void pausedFor(Index count, Index grain, const Execution::Body& body, const std::function<void()>& pause);

} // namespace bsv
