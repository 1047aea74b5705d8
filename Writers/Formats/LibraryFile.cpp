// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/LibraryFile.h"

#include "Base/UTF8.h"
#include "Execution/ReportPace.h"
#include "Formats/CADOutput.h"
#include "Formats/CGNSFile.h"
#include "Formats/HOPRFile.h"
#include "WriterProgram.h"

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <new>

namespace bsv
{

namespace
{

constexpr const char* ProgramName = "BSplineVolumeWriteFile";
constexpr const char* NoMemory = ": there is not enough memory to write it";

/// What the other process says at its end.
struct Outcome
{
  /// Empty, or an error.
  std::string error;
  bool isFileError = false;
  bool noRoom = false;
  std::string content;

  template <typename Archive>
  void exchange(Archive& archive)
  {
    archive(this->error);
    archive(this->isFileError);
    archive(this->noRoom);
    archive(this->content);
  }
};

/// Does all calls that come, up to an empty one.
Outcome serve(
  const std::string& library, const std::string& path, const std::string& target, const ChildChannel& channel)
{
  Outcome outcome;
  channel.progress(0.0);
  try
  {
    std::unique_ptr<LibraryCalls> calls = LibraryCalls::create(library, path, target);
    for (std::string record;;)
    {
      std::uint64_t length = 0;
      if (!channel.receive(reinterpret_cast<char*>(&length), sizeof(length)))
      {
        throw Error(target + ": writing was given up");
      }
      if (length == 0)
      {
        break;
      }
      record.resize(length);
      if (!channel.receive(record.data(), record.size()))
      {
        throw Error(target + ": writing was given up");
      }
      calls->call(record);
    }
    outcome.content = calls->close();
  }
  catch (const FileError& error)
  {
    outcome.error = error.what();
    outcome.isFileError = true;
    outcome.noRoom = error.noRoom();
  }
  catch (const std::bad_alloc&)
  {
    outcome.error = target + NoMemory;
  }
  catch (const std::exception& error)
  {
    outcome.error = validUTF8(error.what());
  }
  return outcome;
}

} // namespace

std::unique_ptr<LibraryCalls> LibraryCalls::create(
  const std::string& library, const std::string& path, const std::string& target)
{
  if (library == CGNSLibrary::Name)
  {
    return std::make_unique<CallsOf<CGNSLibrary>>(path, target);
  }
  if (library == HOPRLibrary::Name)
  {
    return std::make_unique<CallsOf<HOPRLibrary>>(path, target);
  }
  if (library == CADLibrary::Name)
  {
    return std::make_unique<CallsOf<CADLibrary>>(path, target);
  }
  throw Error("no library is called '" + library + "'");
}

LibraryProcess::LibraryProcess(const std::string& library, const std::string& path, const std::string& target,
  double seconds, const Execution& run, std::vector<std::string>& notes)
  : Run(run)
  , Target(target)
{
  const std::string program = programBeside(ProgramName);
  if (!program.empty())
  {
    ChildLimits limits;
    limits.writes = true;
    limits.processorSeconds = seconds;
    this->Child =
      std::make_unique<ChildProcess>(program, std::vector<std::string>{ library, path, target }, target, limits);
    if (this->Child->speaks(run))
    {
      return;
    }
    this->Child.reset();
  }
  notes.push_back(std::string("the program ") + ProgramName +
    " cannot be started beside the plugin's libraries; the file was written in this process, which a full disk can "
    "end");
  this->Here = LibraryCalls::create(library, path, target);
}

void LibraryProcess::call(const std::string& record)
{
  if (reportIsDue())
  {
    this->Run.report(0.0);
  }
  if (this->Here)
  {
    this->Here->call(record);
    return;
  }
  const std::uint64_t length = record.size();
  if (!this->Child->send(reinterpret_cast<const char*>(&length), sizeof(length), this->Run) ||
    !this->Child->send(record.data(), record.size(), this->Run))
  {
    this->end();
  }
}

std::string LibraryProcess::close()
{
  if (this->Here)
  {
    return this->Here->close();
  }
  const std::uint64_t last = 0;
  this->Child->send(reinterpret_cast<const char*>(&last), sizeof(last), this->Run);
  return this->end();
}

std::string LibraryProcess::end()
{
  const std::optional<ChildResult> result = this->Child->finish(this->Run);
  if (!result)
  {
    throw Error(this->Target + ": the program " + ProgramName + " has ended");
  }
  Outcome outcome;
  ArchiveReader archive(result->message);
  outcome.exchange(archive);
  if (outcome.isFileError)
  {
    throw FileError(outcome.error, outcome.noRoom);
  }
  if (!outcome.error.empty())
  {
    throw Error(outcome.error);
  }
  return outcome.content;
}

int writerProgram(int argumentCount, char** arguments)
{
  if (argumentCount != 4)
  {
    return 2;
  }
  const ChildChannel channel;
  channel.begin();
  Outcome outcome = serve(arguments[1], arguments[2], arguments[3], channel);
  ArchiveWriter archive;
  outcome.exchange(archive);
  channel.done(archive.take());
  // Without what the libraries do at the end of a process: they try to write again what failed.
  std::_Exit(0);
}

} // namespace bsv
