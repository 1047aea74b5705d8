// SPDX-License-Identifier: BSD-3-Clause
/// @file LibraryFile.h
/// Files that third-party libraries write: CGNS, HDF5 and OpenCASCADE work in a process of their own (ChildProcess.h),
/// the program `BSplineVolumeWriteFile` beside this library, which is told call by call what to write. A crash there,
/// or a disk that gets full, is one error here. Where the program is missing, the same is done here, and a note says
/// so.
///
/// What works there is a class with a constructor from the path to write to and the name that messages have, a static
/// `Name`, a tuple `Methods` of pointers to the member functions that can be called, without results, and `close()`,
/// which gives back a text. Everything throws Error.
#pragma once

#include "Execution/Archive.h"
#include "Execution/ChildProcess.h"
#include "IO/AtomicFile.h"

#include <memory>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

namespace bsv
{

/// A library's class, called by records of bytes.
class LibraryCalls
{
public:
  virtual ~LibraryCalls() = default;
  virtual void call(const std::string& record) = 0;
  virtual std::string close() = 0;

  /// @param library its name. @throws Error if there is none of this name.
  static std::unique_ptr<LibraryCalls> create(
    const std::string& library, const std::string& path, const std::string& target);
};

template <typename Library>
class CallsOf : public LibraryCalls
{
public:
  CallsOf(const std::string& path, const std::string& target)
    : Object(path, target)
  {
  }

  template <auto Method, typename... Values>
  static std::string record(const Values&... values)
  {
    ArchiveWriter archive;
    archive(numberOf<Method>(std::make_index_sequence<Count>()));
    encode(archive, Method, values...);
    return archive.take();
  }

  void call(const std::string& record) override
  {
    ArchiveReader archive(record);
    int number = 0;
    archive(number);
    this->dispatch(number, archive, std::make_index_sequence<Count>());
  }

  std::string close() override { return this->Object.close(); }

private:
  static constexpr std::size_t Count = std::tuple_size_v<std::decay_t<decltype(Library::methods())>>;

  template <auto Method, std::size_t N>
  static constexpr bool isNumber()
  {
    constexpr auto candidate = std::get<N>(Library::methods());
    if constexpr (std::is_same_v<std::decay_t<decltype(candidate)>, decltype(Method)>)
    {
      return candidate == Method;
    }
    return false;
  }
  template <auto Method, std::size_t... N>
  static constexpr int numberOf(std::index_sequence<N...>)
  {
    return ((isNumber<Method, N>() ? static_cast<int>(N) : 0) + ...);
  }

  /// The values become what the method takes before their bytes are written.
  template <typename... Arguments>
  static void encode(
    ArchiveWriter& archive, void (Library::*)(Arguments...), const std::decay_t<Arguments>&... arguments)
  {
    (archive(arguments), ...);
  }

  template <std::size_t... N>
  void dispatch(int number, ArchiveReader& archive, std::index_sequence<N...>)
  {
    ((number == static_cast<int>(N) ? this->decode(archive, std::get<N>(Library::methods())) : void()), ...);
  }
  template <typename... Arguments>
  void decode(ArchiveReader& archive, void (Library::*method)(Arguments...))
  {
    std::tuple<std::decay_t<Arguments>...> values;
    std::apply(
      [&](auto&... value) {
        (archive(value), ...);
        (this->Object.*method)(value...);
      },
      values);
  }

  Library Object;
};

/// Seconds of computation that are more than enough to write so many bytes.
constexpr double writingSeconds(double bytes)
{
  return 20.0 + bytes / 2e6;
}

/// Where the calls go: into the other process.
class LibraryProcess
{
public:
  /// @param seconds of computation that the library may take
  LibraryProcess(const std::string& library, const std::string& path, const std::string& target, double seconds,
    const Execution& run, std::vector<std::string>& notes);

  /// @throws Error of the library, also for a call before; FileError if it could not write; Aborted
  void call(const std::string& record);
  /// @return the text that the library gives back.
  std::string close();

private:
  std::string end();

  Execution Run;
  std::string Target;
  std::unique_ptr<ChildProcess> Child;
  /// In place of the other process, where there is no program.
  std::unique_ptr<LibraryCalls> Here;
};

template <typename Library>
class LibraryFile
{
public:
  /// @param file whose temporary path the library writes to; takeOver() is for the caller, after close().
  LibraryFile(AtomicFile& file, double seconds, const Execution& run, std::vector<std::string>& notes)
    : Process(Library::Name, file.temporaryPath(), file.target(), seconds, run, notes)
  {
  }

  /// Calls a method of the library's class.
  template <auto Method, typename... Values>
  void call(const Values&... values)
  {
    this->Process.call(CallsOf<Library>::template record<Method>(values...));
  }

  std::string close() { return this->Process.close(); }

private:
  LibraryProcess Process;
};

} // namespace bsv
