// SPDX-License-Identifier: BSD-3-Clause
/// @file ChildProcess.h
/// Runs what third-party libraries do with a file in a process of its own: whatever happens to them there, a crash, an
/// endless loop, a flood of memory or a full disk, is one error here, and they leave nothing open.
///
/// The result comes back in a file without a name that both processes map: large arrays are not copied.
#pragma once

#include "Base/Types.h"

#include "BSplineVolumeFiltersModule.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace bsv
{

struct ChildLimits
{
  /// What the library does with the file, for messages.
  bool writes = false;
  /// Seconds of processor time, and seconds without any.
  double processorSeconds = 600.0;
  double idleSeconds = 60.0;
  /// Bytes of address space; 0 takes what is free on the machine.
  double bytes = 0.0;
};

/// A file without a name that lives as long as this object and what is mapped from it.
class BSPLINEVOLUMEFILTERS_EXPORT SharedFile
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
BSPLINEVOLUMEFILTERS_EXPORT std::string programBeside(const std::string& name);

/// A program that works beside this process; it ends with this object. It gets the arguments, what is sent as standard
/// input, a file for its result as descriptor 3 and a pipe as descriptor 4 to which it writes through ChildChannel; its
/// console output is dropped.
class BSPLINEVOLUMEFILTERS_EXPORT ChildProcess
{
public:
  /// @param subject what it works on, for messages: the name of a file
  ChildProcess(const std::string& program, const std::vector<std::string>& arguments, const std::string& subject,
    const ChildLimits& limits);
  ~ChildProcess();

  /// Waits for the program's first word. @return false if it cannot be started here. @throws Error, Aborted
  bool speaks(const Execution& run);
  /// Sends some bytes, as soon as the child takes them. @return false if it takes no more: it ends, see finish().
  /// @throws Error if it does nothing any more; Aborted
  bool send(const char* data, std::size_t bytes, const Execution& run);
  /// Waits until it ends. @return nothing if the program could not be started. @throws Error, Aborted
  std::optional<ChildResult> finish(const Execution& run);

private:
  class Implementation;
  std::unique_ptr<Implementation> Self;
};

/// Starts `program` and waits until it ends.
/// @return nothing if the program cannot be started here.
/// @throws Error with the text that the child gives, or how it ended; Aborted, after which it has ended, too.
BSPLINEVOLUMEFILTERS_EXPORT std::optional<ChildResult> runChild(const std::string& program,
  const std::vector<std::string>& arguments, const std::string& subject, const ChildLimits& limits,
  const Execution& run);

/// The child's side.
class BSPLINEVOLUMEFILTERS_EXPORT ChildChannel
{
public:
  static constexpr int File = 3;
  static constexpr int Pipe = 4;

  /// To be called first: what the other process has open is no concern of this one.
  void begin() const;
  void progress(double fraction) const;
  /// The next bytes of what is sent. @return false if the other process sends nothing any more.
  bool receive(char* data, std::size_t bytes) const;
  void done(const std::string& message) const;
  void failed(const std::string& message) const;

private:
  void send(char kind, const void* data, std::size_t bytes) const;
};

} // namespace bsv
