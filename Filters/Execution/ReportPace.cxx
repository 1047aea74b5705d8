// SPDX-License-Identifier: BSD-3-Clause
#include "Execution/ReportPace.h"

#include <vtkSMPTools.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <mutex>

namespace bsv
{
namespace
{

double secondsOfWallClock()
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

thread_local double lastReport = 0.0;

/// The ranges [begin, end) of a loop, concurrently.
void rangesFor(Index begin, Index end, Index grain, const Execution::Body& body)
{
  std::exception_ptr failure;
  Index failedAt = end;
  std::mutex guard;
  const ReportPace& pace = reportPace();
  vtkSMPTools::For(begin, end, grain, [&](vtkIdType first, vtkIdType last) {
    try
    {
      body(first, last);
      if (pace.ranRange)
      {
        pace.ranRange(first, last);
      }
    }
    catch (...)
    {
      const std::lock_guard<std::mutex> lock(guard);
      if (first < failedAt)
      {
        failedAt = first;
        failure = std::current_exception();
      }
    }
  });
  if (failure)
  {
    std::rethrow_exception(failure);
  }
}

} // namespace

ReportPace& reportPace()
{
  static ReportPace pace{ 0.03, secondsOfWallClock, {} };
  return pace;
}

void reportedNow()
{
  lastReport = reportPace().now();
}

bool reportIsDue()
{
  return reportPace().now() - lastReport >= reportPace().interval;
}

void pausedFor(Index count, Index grain, const Execution::Body& body, const std::function<void()>& pause)
{
  grain = std::max<Index>(grain, 1);
  const ReportPace& pace = reportPace();
  // A range for every thread; then as many as fill the time between two reports.
  const Index least = grain * std::max(1, vtkSMPTools::GetEstimatedNumberOfThreads());
  Index part = least;
  for (Index begin = 0; begin < count;)
  {
    const Index end = count - begin <= part ? count : begin + part;
    const double start = pace.now();
    rangesFor(begin, end, grain, body);
    // Not much more than before: the next ranges may cost more.
    const double factor = std::min(4.0, pace.interval / std::max(pace.now() - start, pace.interval / 16.0));
    const Index done = (end - begin) / grain * grain;
    const double wanted = factor * static_cast<double>(done);
    part = wanted >= static_cast<double>(count) ? count : std::max(least, static_cast<Index>(wanted) / least * least);
    begin = end;
    if (reportIsDue())
    {
      pause();
    }
  }
}

} // namespace bsv
