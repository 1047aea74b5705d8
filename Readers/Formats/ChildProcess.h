// SPDX-License-Identifier: BSD-3-Clause
/// @file ChildProcess.h
/// Runs what third-party libraries do with a file in a process of its own: whatever happens to them there, a crash, an
/// endless loop or a flood of memory, is one error here, and they leave nothing open.
///
/// The result comes back in a file without a name that both processes map: large arrays are not copied.
#pragma once

#include "Base/Types.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace bsv
{

struct ChildLimits
{
  /// Seconds of processor time, and seconds without any.
  double processorSeconds = 600.0;
  double idleSeconds = 60.0;
  /// Bytes of address space; 0 takes what is free on the machine.
  double bytes = 0.0;
};

/// A file without a name that lives as long as this object and what is mapped from it.
class SharedFile
{
public:
  SharedFile() = default;
  explicit SharedFile(int descriptor)
    : Descriptor(descriptor)
  {
  }
  ~SharedFile();
  SharedFile(SharedFile&& other) noexcept
    : Descriptor(other.Descriptor)
  {
    other.Descriptor = -1;
  }
  SharedFile& operator=(SharedFile&&) = delete;

  /// @throws Error if there is no memory.
  static SharedFile create();

  int descriptor() const { return this->Descriptor; }
  Index size() const;

  /// Room for `bytes` bytes at the end of the file, mapped. @param[out] offset where it is.
  /// @return what releaseSection() gives back. @throws std::bad_alloc
  void* append(Index bytes, Index& offset) const;
  /// Maps what append() made; writing to it changes this process's copy only. @throws Error if it is not there.
  void* section(Index offset, Index bytes) const;
  /// Unmaps a section.
  static void release(void* section);

private:
  int Descriptor = -1;
};

/// What a child has said at its end.
struct ChildResult
{
  SharedFile file;
  /// The text that it gave.
  std::string message;
};

/// Full path of a program beside the library that this function is in; empty if it is not there.
std::string programBeside(const std::string& name);

/// Starts `program` and waits until it ends. It gets the arguments, a file for its result as descriptor 3 and a pipe
/// as descriptor 4 to which it writes through ChildChannel; its console output is dropped.
/// @param subject what it works on, for messages: the name of a file
/// @return nothing if the program cannot be started here.
/// @throws Error with the text that the child gives, or how it ended; Aborted, after which it has ended, too.
std::optional<ChildResult> runChild(const std::string& program, const std::vector<std::string>& arguments,
  const std::string& subject, const ChildLimits& limits, const Execution& run);

/// The child's side of the pipe.
class ChildChannel
{
public:
  static constexpr int File = 3;
  static constexpr int Pipe = 4;

  void progress(double fraction) const;
  void done(const std::string& message) const;
  void failed(const std::string& message) const;

private:
  void send(char kind, const void* data, std::size_t bytes) const;
};

} // namespace bsv
