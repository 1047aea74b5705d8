// SPDX-License-Identifier: BSD-3-Clause
/// @file WriteTogether.h
/// How the writers begin and end: on all ranks together, with one message.
#pragma once

#include "Execution/FilterExecution.h"
#include "IO/AtomicFile.h"
#include "Ranks/Ranks.h"

#include <vtkErrorCode.h>
#include <vtkTimeStamp.h>
#include <vtkWriter.h>

#include <exception>
#include <memory>
#include <string>

namespace bsv
{

/// Runs the body of a writer's WriteData, which may communicate with the other ranks. An error on any of them is the
/// error of all, raised by `algorithm` on the first rank.
/// @return what the writer's error code becomes: OutOfDiskSpaceError where there was no room for the file,
/// CannotOpenFileError where it could not be made for another reason, FileFormatError where the format cannot hold the
/// data, UserError after an abort.
template <typename Body>
unsigned long writeTogether(vtkAlgorithm* algorithm, const std::string& fileName, const Ranks& ranks, const Body& body)
{
  bool noRoom = false;
  bool noFile = false;
  try
  {
    onAllRanks(algorithm, ranks, [&] {
      if (fileName.empty())
      {
        throw Error("File Name is empty.");
      }
      try
      {
        body();
      }
      catch (const FileError& error)
      {
        noRoom = error.noRoom();
        noFile = true;
        throw;
      }
    });
  }
  catch (const Aborted&)
  {
    return vtkErrorCode::UserError;
  }
  catch (const std::exception& error)
  {
    if (ranks.rank() == 0)
    {
      vtkErrorWithObjectMacro(algorithm, << validUTF8(error.what()));
    }
    return ranks.any(noRoom)        ? vtkErrorCode::OutOfDiskSpaceError
      : ranks.any(noFile)           ? vtkErrorCode::CannotOpenFileError
      : ranks.any(fileName.empty()) ? vtkErrorCode::NoFileNameError
                                    : vtkErrorCode::FileFormatError;
  }
  return vtkErrorCode::NoError;
}

/// The body of a writer's Write(). VTK does not come to WriteData() on a rank where the input is missing or could not
/// be made, while the others wait for it there: such a rank joins them with an error.
/// @param written when WriteData() was over last
/// @param superclass runs vtkWriter::Write()
/// @return what the writer's error code becomes
template <typename Superclass>
unsigned long writeOnAllRanks(
  vtkWriter* writer, const std::string& fileName, const vtkTimeStamp& written, const Superclass& superclass)
{
  const std::shared_ptr<const Ranks> ranks = globalRanks();
  const vtkMTimeType before = written.GetMTime();
  if (ranks->size() == 1 || writer->GetNumberOfInputConnections(0) > 0)
  {
    const bool good = superclass() != 0;
    if (ranks->size() == 1 || written.GetMTime() != before)
    {
      const unsigned long code = writer->GetErrorCode();
      return good || code != vtkErrorCode::NoError ? code : static_cast<unsigned long>(vtkErrorCode::UserError);
    }
  }
  return writeTogether(writer, fileName, *ranks, [&] {
    throw Error("rank " + std::to_string(ranks->rank()) + ": the input is missing there, or could not be made");
  });
}

} // namespace bsv
