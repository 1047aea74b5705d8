// SPDX-License-Identifier: BSD-3-Clause
/// @file FilterExecution.h
/// Runs the core inside a VTK filter: loops on vtkSMPTools, progress and abort through the vtkAlgorithm, the other
/// ranks through VTK's global controller.
#pragma once

#include "Base/Types.h"
#include "Base/UTF8.h"
#include "Execution/ControllerRanks.h"
#include "Ranks/Ranks.h"

#include <vtkAlgorithm.h>
#include <vtkCallbackCommand.h>
#include <vtkDataObject.h>
#include <vtkExecutive.h>
#include <vtkNew.h>
#include <vtkSMPTools.h>
#include <vtkVersionMacros.h>

#include <exception>
#include <mutex>
#include <string>
#include <vector>

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

/// Execution::parallelFor by vtkSMPTools.
///
/// An exception in a loop is handed to the calling thread, the one of the lowest range if there are several: thrown in
/// a worker thread of vtkSMPTools it would end the process.
inline void threadedFor(Index count, Index grain, const Execution::Body& body)
{
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
}

/// Execution whose progress 0..1 fills the part [first, last] of the algorithm's progress bar. `algorithm` must outlive
/// it.
inline Execution filterExecution(vtkAlgorithm* algorithm, double first = 0.0, double last = 1.0)
{
  Execution run;
  run.parallelFor = threadedFor;
  run.ranks = globalRanks();
  run.progress = [algorithm, first, last](double fraction) {
    algorithm->UpdateProgress(first + fraction * (last - first));
    return !aborted(algorithm);
  };
  return run;
}

/// Suppresses the next message of the executive of `algorithm`: that RequestData failed.
inline void silenceFailure(vtkAlgorithm* algorithm)
{
  if (vtkObject::GetGlobalWarningDisplay())
  {
    vtkNew<vtkCallbackCommand> once;
    once->SetClientData(once);
    once->SetAbortFlagOnExecute(1);
    once->SetCallback([](vtkObject* executive, unsigned long, void* self, void*) {
      executive->RemoveObserver(static_cast<vtkCommand*>(self));
    });
    algorithm->GetExecutive()->AddObserver(vtkCommand::ErrorEvent, once, 1.0f);
  }
}

/// Nothing of what `algorithm` has made stays.
inline void clearOutputs(vtkAlgorithm* algorithm)
{
  for (int port = 0; port < algorithm->GetNumberOfOutputPorts(); ++port)
  {
    if (vtkDataObject* output = algorithm->GetOutputDataObject(port))
    {
      output->Initialize();
    }
  }
}

/// Runs the body of a filter's RequestData. It may communicate with the other ranks, and is over on all of them when it
/// is on one: an abort or an error, wherever it happens, leaves all outputs empty everywhere. An error is the text of
/// the exception, raised once: by `algorithm`, on the first rank.
/// @param ranks which take part
/// @return what RequestData returns: 0 after an error, else 1
template <typename Body>
int execute(vtkAlgorithm* algorithm, const Ranks& ranks, const Body& body)
{
  try
  {
    ranks.together([&] {
      body();
      if (aborted(algorithm))
      {
        throw Aborted();
      }
    });
  }
  catch (const Aborted&)
  {
    clearOutputs(algorithm);
  }
  catch (const std::exception& error)
  {
    clearOutputs(algorithm);
    if (ranks.rank() == 0)
    {
      vtkErrorWithObjectMacro(algorithm, << validUTF8(error.what()));
    }
    silenceFailure(algorithm);
    return 0;
  }
  return 1;
}

/// The same on all ranks of the global controller.
template <typename Body>
int execute(vtkAlgorithm* algorithm, const Body& body)
{
  return execute(algorithm, *globalRanks(), body);
}

/// Raises warnings of `algorithm` that all ranks have, once: on the first rank.
inline void warn(vtkAlgorithm* algorithm, const std::vector<std::string>& warnings)
{
  if (globalRanks()->rank() == 0)
  {
    for (const std::string& warning : warnings)
    {
      vtkWarningWithObjectMacro(algorithm, << warning);
    }
  }
}

} // namespace bsv
