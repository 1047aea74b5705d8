// SPDX-License-Identifier: BSD-3-Clause
/// @file WriteTogether.h
/// How the writers end: on all ranks together, with one message.
#pragma once

#include "Ranks/Ranks.h"

#include <vtkAlgorithm.h>
#include <vtkErrorCode.h>

#include <exception>
#include <string>

namespace bsv
{

/// Runs the body of a writer's WriteData, which may communicate with the other ranks. An error on any of them is the
/// error of all, raised by `algorithm` on the first rank.
/// @return what the writer's error code becomes
template <typename Body>
unsigned long writeTogether(vtkAlgorithm* algorithm, const std::string& fileName, const Ranks& ranks, const Body& body)
{
  const auto raise = [&](const char* text) {
    if (ranks.rank() == 0)
    {
      vtkErrorWithObjectMacro(algorithm, << text);
    }
  };
  if (fileName.empty())
  {
    raise("File Name is empty.");
    return vtkErrorCode::NoFileNameError;
  }
  try
  {
    ranks.together(body);
  }
  catch (const Aborted&)
  {
    return vtkErrorCode::UserError;
  }
  catch (const std::exception& error)
  {
    raise(error.what());
    return vtkErrorCode::CannotOpenFileError;
  }
  return vtkErrorCode::NoError;
}

} // namespace bsv
