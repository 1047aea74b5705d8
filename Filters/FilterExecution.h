// SPDX-License-Identifier: BSD-3-Clause
/// @file FilterExecution.h
/// Runs the core inside a VTK filter: loops on vtkSMPTools, progress and abort through the vtkAlgorithm, the other ranks
/// through VTK's global controller.
#pragma once

#include "ControllerRanks.h"
#include "Types.h"

#include <vtkAlgorithm.h>
#include <vtkSMPTools.h>
#include <vtkVersionMacros.h>

#include <exception>
#include <mutex>

namespace bsv
{

/// Whether the user asked to stop `algorithm`, or a filter that it feeds from.
inline bool aborted(vtkAlgorithm* algorithm)
{
#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 2, 20230101)
  return algorithm->CheckAbort();
#else
  return algorithm->GetAbortExecute() != 0;
#endif
}

/// Execution whose progress 0..1 fills the part [first, last] of the algorithm's progress bar. `algorithm` must outlive
/// it.
///
/// An exception in a loop is handed to the calling thread, the one of the lowest range if there are several: thrown in
/// a worker thread of vtkSMPTools it would end the process.
inline Execution filterExecution(vtkAlgorithm* algorithm, double first = 0.0, double last = 1.0)
{
  Execution run;
  run.parallelFor = [](Index count, Index grain, const Execution::Body& body) {
    if (count <= 0)
    {
      return;
    }
    std::exception_ptr failure;
    Index failedAt = count;
    std::mutex guard;
    vtkSMPTools::For(0, count, grain, [&](vtkIdType begin, vtkIdType end) {
      try
      {
        body(begin, end);
      }
      catch (...)
      {
        const std::lock_guard<std::mutex> lock(guard);
        if (begin < failedAt)
        {
          failedAt = begin;
          failure = std::current_exception();
        }
      }
    });
    if (failure)
    {
      std::rethrow_exception(failure);
    }
  };
  run.ranks = globalRanks();
  run.progress = [algorithm, first, last](double fraction) {
    algorithm->UpdateProgress(first + fraction * (last - first));
    return !aborted(algorithm);
  };
  return run;
}

/// Runs the body of a filter's RequestData. An abort or an error leaves an empty output; an error is raised by
/// `algorithm` with the text of the exception.
/// @return what RequestData returns: 0 after an error, else 1
template <typename Output, typename Body>
int execute(vtkAlgorithm* algorithm, Output* output, const Body& body)
{
  try
  {
    body();
  }
  catch (const Aborted&)
  {
    output->Initialize();
  }
  catch (const std::exception& error)
  {
    output->Initialize();
    vtkErrorWithObjectMacro(algorithm, << error.what());
    return 0;
  }
  return 1;
}

} // namespace bsv
