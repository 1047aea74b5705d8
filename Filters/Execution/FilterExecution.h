// SPDX-License-Identifier: BSD-3-Clause
/// @file FilterExecution.h
/// Runs the core inside a VTK filter: loops on vtkSMPTools, progress and abort through the vtkAlgorithm, the other
/// ranks through VTK's global controller.
#pragma once

#include "Base/MemoryCheck.h"
#include "Base/Types.h"
#include "Base/UTF8.h"
#include "Execution/ControllerRanks.h"
#include "Execution/Parameters.h"
#include "Execution/ReportPace.h"
#include "Ranks/Ranks.h"

#include <vtkAlgorithm.h>
#include <vtkCallbackCommand.h>
#include <vtkDataObject.h>
#include <vtkExecutive.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkVersionMacros.h>

#include <algorithm>
#include <exception>
#include <new>
#include <string>
#include <thread>
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

/// Execution whose progress 0..1 fills the part [first, last] of the algorithm's progress bar, which never runs back.
/// Long loops report in between. `algorithm` must outlive it.
inline Execution filterExecution(vtkAlgorithm* algorithm, double first = 0.0, double last = 1.0)
{
  Execution run;
  run.ranks = globalRanks();
  run.progress = [algorithm, first, last](double fraction) {
    algorithm->UpdateProgress(std::max(algorithm->GetProgress(), first + fraction * (last - first)));
    reportedNow();
    return !aborted(algorithm);
  };
  // Only the thread of the algorithm reports.
  const auto pause = [algorithm, owner = std::this_thread::get_id()] {
    if (std::this_thread::get_id() == owner && reportIsDue())
    {
      algorithm->UpdateProgress(algorithm->GetProgress());
      reportedNow();
      if (aborted(algorithm))
      {
        throw Aborted();
      }
    }
  };
  run.parallelFor = [pause](
                      Index count, Index grain, const Execution::Body& body) { pausedFor(count, grain, body, pause); };
  return run;
}

/// For FillInputPortInformation(): VTK runs the algorithm also on a rank where the input is not connected. VTK would
/// refuse it there alone, and the others would wait for ever.
inline void acceptMissing(vtkInformation* port)
{
  port->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1);
}

/// The data of an input port that must be connected. @throws Error unless it is
inline vtkDataObject* requiredInput(
  vtkInformationVector** inputs, int port, const char* message = "The input is missing.")
{
  vtkDataObject* data = vtkDataObject::GetData(inputs[port], 0);
  if (!data)
  {
    throw Error(message);
  }
  return data;
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

/// Runs `body`, all that `algorithm` does with the other ranks, in the one scope that it needs. Properties and inputs
/// that are not the same on all ranks are an error, with the property and both values. So is memory that is missing,
/// with the rank and what is free.
template <typename Body>
void onAllRanks(vtkAlgorithm* algorithm, const Ranks& ranks, const Body& body)
{
  ranks.together(
    [&] {
      try
      {
        requireFiniteParameters(algorithm);
        body();
      }
      catch (const std::bad_alloc&)
      {
        throw Error((ranks.size() > 1 ? "rank " + std::to_string(ranks.rank()) + ": " : std::string()) + outOfMemory());
      }
    },
    [&] { return parametersOf(algorithm); });
}

/// Runs the body of a filter's RequestData. It may communicate with the other ranks, and is over on all of them when it
/// is on one: an abort or an error, wherever it happens, leaves all outputs empty everywhere. An error is the text of
/// the exception, raised once: by `algorithm`, on the first rank.
/// @param ranks which take part
/// @return what RequestData returns: 0 after an error, else 1
template <typename Body>
int execute(vtkAlgorithm* algorithm, const Ranks& ranks, const Body& body)
{
  std::string message;
  try
  {
    onAllRanks(algorithm, ranks, [&] {
      body();
      if (aborted(algorithm))
      {
        throw Aborted();
      }
    });
    return 1;
  }
  catch (const Aborted&)
  {
    clearOutputs(algorithm);
    return 1;
  }
  catch (const std::exception& error)
  {
    message = validUTF8(error.what());
  }
  clearOutputs(algorithm);
  if (ranks.rank() == 0)
  {
    vtkErrorWithObjectMacro(algorithm, << message);
  }
  silenceFailure(algorithm);
  return 0;
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
