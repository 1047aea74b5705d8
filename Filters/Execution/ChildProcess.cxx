// SPDX-License-Identifier: BSD-3-Clause
#include "Execution/ChildProcess.h"

#include "Base/MemoryCheck.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <new>

#ifdef __unix__
#include <cerrno>
#include <csignal>
#include <ctime>
#include <dlfcn.h>
#include <fcntl.h>
#ifdef __linux__
#include <link.h>
#endif
#include <poll.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;
#endif

namespace bsv
{

#ifndef __unix__

SharedFile::~SharedFile() = default;

SharedFile SharedFile::create()
{
  return {};
}

Index SharedFile::size() const
{
  return 0;
}

void* SharedFile::append(Index, Index&) const
{
  throw std::bad_alloc();
}

void* SharedFile::section(Index, Index) const
{
  throw std::bad_alloc();
}

void SharedFile::release(void*) {}

std::string programBeside(const std::string&)
{
  return {};
}

class ChildProcess::Implementation
{
};

ChildProcess::ChildProcess(const std::string&, const std::vector<std::string>&, const std::string&, const ChildLimits&)
{
}

ChildProcess::~ChildProcess() = default;

bool ChildProcess::speaks(const Execution&)
{
  return false;
}

bool ChildProcess::send(const char*, std::size_t, const Execution&)
{
  return false;
}

std::optional<ChildResult> ChildProcess::finish(const Execution&)
{
  return std::nullopt;
}

void ChildChannel::begin() const {}

bool ChildChannel::receive(char*, std::size_t) const
{
  return false;
}

void ChildChannel::send(char, const void*, std::size_t) const {}

#else

namespace
{

/// In front of a section: its length with this, so that it can be unmapped by its address alone. Keeps alignment.
constexpr Index SectionHeader = 64;

Index pageSize()
{
  return static_cast<Index>(sysconf(_SC_PAGESIZE));
}

Index roundedUp(Index bytes)
{
  const Index page = pageSize();
  return (bytes + page - 1) / page * page;
}

void* mapped(int descriptor, Index offset, Index bytes, int flags)
{
  void* start = mmap(nullptr, static_cast<std::size_t>(bytes), PROT_READ | PROT_WRITE, flags, descriptor, offset);
  if (start == MAP_FAILED)
  {
    throw std::bad_alloc();
  }
  return start;
}

/// Descriptors that are closed at the end of the scope.
class Descriptor
{
public:
  explicit Descriptor(int number = -1)
    : Number(number)
  {
  }
  ~Descriptor() { this->close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return this->Number; }
  void set(int number)
  {
    this->close();
    this->Number = number;
  }
  void close()
  {
    if (this->Number >= 0)
    {
      ::close(this->Number);
      this->Number = -1;
    }
  }

private:
  int Number;
};

/// Above those that the child gets, so that none of them is overwritten when these are passed on.
int aboveStandard(int descriptor)
{
  const int high = fcntl(descriptor, F_DUPFD_CLOEXEC, 10);
  ::close(descriptor);
  return high;
}

double processorSeconds(pid_t child)
{
  clockid_t clock;
  timespec time{};
  if (clock_getcpuclockid(child, &clock) != 0 || clock_gettime(clock, &time) != 0)
  {
    return 0.0;
  }
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

std::string signalText(int signal)
{
  switch (signal)
  {
    case SIGSEGV:
      return "a segmentation fault";
    case SIGABRT:
      return "an abort";
    case SIGFPE:
      return "an arithmetic error";
    case SIGBUS:
      return "a bus error";
    case SIGILL:
      return "an illegal instruction";
    case SIGXCPU:
      return "the time limit";
    default:
      return "signal " + std::to_string(signal);
  }
}

/// Whether these are not the first bytes of what ChildChannel sends.
bool isNonsense(const std::string& received)
{
  std::uint64_t length = 0;
  if (received.size() >= 9)
  {
    std::memcpy(&length, received.data() + 1, sizeof(length));
  }
  return !received.empty() &&
    (std::string("PDE").find(received[0]) == std::string::npos ||
      (received.size() >= 9 && received.size() > 9 + length));
}

/// A child that is ended and waited for, whatever happens.
class Child
{
public:
  Child() = default;
  ~Child()
  {
    if (this->Id > 0)
    {
      kill(this->Id, SIGKILL);
      this->wait();
    }
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// @return false if the program cannot be started.
  bool start(const std::string& program, const std::vector<std::string>& arguments, int input, int file, int pipe)
  {
    std::vector<char*> words{ const_cast<char*>(program.c_str()) };
    for (const std::string& argument : arguments)
    {
      words.push_back(const_cast<char*>(argument.c_str()));
    }
    words.push_back(nullptr);

    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    posix_spawn_file_actions_init(&actions);
    posix_spawnattr_init(&attributes);
    posix_spawn_file_actions_adddup2(&actions, input, 0);
    posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, file, ChildChannel::File);
    posix_spawn_file_actions_adddup2(&actions, pipe, ChildChannel::Pipe);
    sigset_t signals;
    sigemptyset(&signals);
    posix_spawnattr_setsigmask(&attributes, &signals);
    sigfillset(&signals);
    posix_spawnattr_setsigdefault(&attributes, &signals);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    const std::vector<std::string> variables = environment();
    std::vector<char*> pointers;
    for (const std::string& variable : variables)
    {
      pointers.push_back(const_cast<char*>(variable.c_str()));
    }
    pointers.push_back(nullptr);
    const int failure = posix_spawn(&this->Id, program.c_str(), &actions, &attributes, words.data(), pointers.data());
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
    this->Id = failure != 0 ? 0 : this->Id;
    return failure == 0;
  }

  void limit(const ChildLimits& limits) const
  {
#ifdef __linux__
    const auto set = [this](__rlimit_resource resource, double value) {
      if (value > 0.0)
      {
        rlimit bound{};
        bound.rlim_cur = bound.rlim_max = static_cast<rlim_t>(value);
        prlimit(this->Id, resource, &bound, nullptr);
      }
    };
    // Libraries take address space, but hardly memory.
    constexpr double Libraries = 2e9;
    set(RLIMIT_AS, limits.bytes > 0.0 ? limits.bytes : freeMemory() + Libraries);
    set(RLIMIT_CPU, std::max(1.0, limits.processorSeconds));
    rlimit none{};
    prlimit(this->Id, RLIMIT_CORE, &none, nullptr);
#else
    (void)limits;
#endif
  }

  double seconds() const
  {
    return processorSeconds(this->Id);
  }

  /// How it ended, for a message; empty if it ended by itself without an error.
  std::string wait()
  {
    if (this->Id == 0)
    {
      return this->End;
    }
    int status = 0;
    pid_t found = 0;
    do
    {
      found = waitpid(this->Id, &status, 0);
    } while (found < 0 && errno == EINTR);
    this->Id = 0;
    if (found < 0)
    {
      return {}; // someone else has waited for it
    }
    this->ExitCode = WIFEXITED(status) ? WEXITSTATUS(status) : 0;
    this->End = WIFSIGNALED(status) ? "it ended with " + signalText(WTERMSIG(status))
      : this->ExitCode == 0         ? ""
                                    : "it ended with code " + std::to_string(this->ExitCode);
    return this->End;
  }

  /// Whether it has ended as the system's loader ends a program without its libraries.
  bool lacksLibraries()
  {
    constexpr int NotLoaded = 127;
    this->wait();
    return this->ExitCode == NotLoaded;
  }

private:
  /// That of this process. The program finds the libraries that this one has loaded, wherever they are.
  static std::vector<std::string> environment()
  {
    std::string path;
#ifdef __linux__
    dl_iterate_phdr(
      [](dl_phdr_info* library, std::size_t, void* folders) {
        const std::string name = library->dlpi_name ? library->dlpi_name : "";
        const std::size_t slash = name.rfind('/');
        auto& list = *static_cast<std::string*>(folders);
        if (slash != std::string::npos && slash > 0)
        {
          const std::string folder = name.substr(0, slash) + ":";
          list += (":" + list).find(":" + folder) == std::string::npos ? folder : "";
        }
        return 0;
      },
      &path);
#endif
    std::vector<std::string> variables;
    for (char** at = environ; at && *at; ++at)
    {
      const std::string variable = *at;
      if (variable.rfind("LD_LIBRARY_PATH=", 0) == 0)
      {
        path += variable.substr(16);
      }
      else
      {
        variables.push_back(variable);
      }
    }
    if (!path.empty())
    {
      variables.push_back("LD_LIBRARY_PATH=" + path);
    }
    return variables;
  }

  pid_t Id = 0;
  int ExitCode = 0;
  std::string End;
};

} // namespace

SharedFile::~SharedFile()
{
  if (this->Descriptor >= 0)
  {
    ::close(this->Descriptor);
  }
}

SharedFile SharedFile::create()
{
#ifdef __linux__
  const int descriptor = memfd_create("BSplineVolume", MFD_CLOEXEC);
#else
  std::string path = (std::filesystem::temp_directory_path() / "BSplineVolume-XXXXXX").string();
  const int descriptor = mkstemp(path.data());
  if (descriptor >= 0)
  {
    unlink(path.c_str());
  }
#endif
  const int high = descriptor < 0 ? -1 : aboveStandard(descriptor);
  if (high < 0)
  {
    throw Error(std::string("no file for the result of another process: ") + std::strerror(errno));
  }
  return SharedFile(high);
}

Index SharedFile::size() const
{
  return static_cast<Index>(lseek(this->Descriptor, 0, SEEK_END));
}

void* SharedFile::append(Index bytes, Index& offset) const
{
  offset = roundedUp(this->size());
  const Index length = roundedUp(bytes + SectionHeader);
  if (ftruncate(this->Descriptor, offset + length) != 0)
  {
    throw std::bad_alloc();
  }
  auto* start = static_cast<char*>(mapped(this->Descriptor, offset, length, MAP_SHARED));
  std::memcpy(start, &length, sizeof(length));
  return start + SectionHeader;
}

void* SharedFile::section(Index offset, Index bytes) const
{
  const Index length = roundedUp(bytes + SectionHeader);
  if (offset < 0 || offset % pageSize() != 0 || bytes < 0 || offset + length > this->size())
  {
    throw Error("another process has promised " + std::to_string(bytes) + " bytes at offset " + std::to_string(offset) +
      ", but not given them");
  }
  auto* start = static_cast<char*>(mapped(this->Descriptor, offset, length, MAP_PRIVATE));
  std::memcpy(start, &length, sizeof(length));
  return start + SectionHeader;
}

void SharedFile::release(void* section)
{
  if (section)
  {
    char* start = static_cast<char*>(section) - SectionHeader;
    Index length = 0;
    std::memcpy(&length, start, sizeof(length));
    munmap(start, static_cast<std::size_t>(length));
  }
}

std::string programBeside(const std::string& name)
{
  Dl_info information{};
  if (dladdr(reinterpret_cast<void*>(&programBeside), &information) == 0 || !information.dli_fname)
  {
    return {};
  }
  std::error_code failure;
  const std::filesystem::path library = std::filesystem::weakly_canonical(information.dli_fname, failure);
  const std::filesystem::path program = (failure ? information.dli_fname : library).parent_path() / name;
  return access(program.c_str(), X_OK) == 0 ? program.string() : std::string();
}

class ChildProcess::Implementation
{
public:
  Implementation(const std::string& program, const std::vector<std::string>& arguments, const std::string& subject,
    const ChildLimits& limits)
    : Subject(subject)
    , Limits(limits)
    , Library(std::string(": the library that ") + (limits.writes ? "writes" : "reads") + " it ")
    , Result{ SharedFile::create(), {} }
  {
    int from[2];
    int to[2];
    if (pipe(from) != 0)
    {
      throw Error(subject + ": no pipe to another process: " + std::strerror(errno));
    }
    this->Reading.set(aboveStandard(from[0]));
    Descriptor writing(aboveStandard(from[1]));
    if (socketpair(AF_UNIX, SOCK_STREAM, 0, to) != 0)
    {
      throw Error(subject + ": no socket to another process: " + std::strerror(errno));
    }
    this->Input.set(aboveStandard(to[0]));
    Descriptor input(aboveStandard(to[1]));
    this->Started = this->Reading.get() >= 0 && writing.get() >= 0 && this->Input.get() >= 0 && input.get() >= 0 &&
      this->Process.start(program, arguments, input.get(), this->Result.file.descriptor(), writing.get());
    if (this->Started)
    {
      this->Process.limit(limits);
    }
  }

  bool speaks(const Execution& run)
  {
    this->startWaiting();
    while (this->Started && this->Open && !this->HasSpoken)
    {
      this->wait(false, run);
    }
    return this->Started && (this->HasSpoken || !this->Process.lacksLibraries());
  }

  bool send(const char* data, std::size_t bytes, const Execution& run)
  {
    this->startWaiting();
    for (std::size_t sent = 0; sent < bytes && this->Open;)
    {
      const ssize_t count = ::send(this->Input.get(), data + sent, bytes - sent, MSG_NOSIGNAL | MSG_DONTWAIT);
      if (count < 0 && errno != EAGAIN && errno != EINTR)
      {
        return false;
      }
      sent += static_cast<std::size_t>(std::max<ssize_t>(count, 0));
      if (sent < bytes)
      {
        this->wait(true, run);
      }
    }
    return this->Open;
  }

  std::optional<ChildResult> finish(const Execution& run)
  {
    if (!this->Started)
    {
      return std::nullopt;
    }
    this->Input.close();
    this->startWaiting();
    while (this->Open)
    {
      this->wait(false, run);
    }
    const char* object = this->Limits.writes ? "disk" : "file";
    const double used = this->Process.seconds();
    if (isNonsense(this->Received))
    {
      throw Error(
        this->Subject + this->Library + "failed: its result is damaged; so is the " + object + ", or memory is short");
    }
    const std::string end = this->Process.wait();
    std::uint64_t length = 0;
    if (this->Received.size() >= 9)
    {
      std::memcpy(&length, this->Received.data() + 1, sizeof(length));
    }
    const bool whole = this->Received.size() >= 9 && this->Received.size() == 9 + length;
    if (whole && this->Received[0] == 'E')
    {
      throw Error(this->Received.substr(9));
    }
    if (whole && this->Received[0] == 'D' && end.empty())
    {
      this->Result.message = this->Received.substr(9);
      return std::move(this->Result);
    }
    if (this->Process.lacksLibraries())
    {
      return std::nullopt;
    }
    if (std::max(used, this->Seconds) >= this->Limits.processorSeconds - 0.5)
    {
      throw Error(this->Subject + ": " + this->verb() + " was stopped after " +
        std::to_string(static_cast<int>(this->Limits.processorSeconds)) +
        " seconds of computation in the library; the " + object + " is damaged or " +
        (this->Limits.writes ? "slow" : "too large"));
    }
    throw Error(this->Subject + this->Library + "failed" + (end.empty() ? "" : ": " + end) + "; the " + object +
      (this->Limits.writes ? " is full or damaged" : " is damaged") + ", or memory is short");
  }

private:
  using Clock = std::chrono::steady_clock;

  const char* verb() const { return this->Limits.writes ? "writing" : "reading"; }

  void startWaiting() { this->Busy = Clock::now(); }

  /// Waits a moment for what the child says, or until it takes more.
  void wait(bool sends, const Execution& run)
  {
    pollfd waiting[2] = { { this->Reading.get(), POLLIN, 0 }, { this->Input.get(), POLLOUT, 0 } };
    const int ready = poll(waiting, sends ? 2 : 1, 100);
    if (waiting[0].revents != 0)
    {
      char buffer[1 << 16];
      const ssize_t count = read(this->Reading.get(), buffer, sizeof(buffer));
      this->Open = count > 0 || (count < 0 && errno == EINTR);
      this->HasSpoken = this->HasSpoken || count > 0;
      this->Received.append(buffer, static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
      // What is more than a report of progress is the last that the child says.
      while (this->Received.size() >= 9 && this->Received[0] == 'P')
      {
        double value = 0.0;
        std::memcpy(&value, this->Received.data() + 1, sizeof(value));
        this->Fraction = value >= this->Fraction && value <= 1.0 ? value : this->Fraction;
        this->Received.erase(0, 9);
      }
      // Anything else than its last text, or more, is none of its words.
      this->Open = this->Open && !isNonsense(this->Received);
    }
    run.report(this->Fraction);
    const double now = this->Process.seconds();
    if (now != this->Seconds || ready > 0)
    {
      this->Seconds = now;
      this->startWaiting();
    }
    else if (this->Open && std::chrono::duration<double>(Clock::now() - this->Busy).count() > this->Limits.idleSeconds)
    {
      throw Error(this->Subject + ": " + this->verb() + " has stopped" + this->Library + "has done nothing for " +
        std::to_string(static_cast<int>(this->Limits.idleSeconds)) + " seconds");
    }
  }

  std::string Subject;
  ChildLimits Limits;
  std::string Library;
  ChildResult Result;
  Descriptor Reading, Input;
  Child Process;
  bool Started = false;
  bool Open = true;
  bool HasSpoken = false;
  std::string Received;
  double Fraction = 0.0;
  double Seconds = 0.0;
  Clock::time_point Busy;
};

ChildProcess::ChildProcess(const std::string& program, const std::vector<std::string>& arguments,
  const std::string& subject, const ChildLimits& limits)
  : Self(std::make_unique<Implementation>(program, arguments, subject, limits))
{
}

ChildProcess::~ChildProcess() = default;

bool ChildProcess::speaks(const Execution& run)
{
  return this->Self->speaks(run);
}

bool ChildProcess::send(const char* data, std::size_t bytes, const Execution& run)
{
  return this->Self->send(data, bytes, run);
}

std::optional<ChildResult> ChildProcess::finish(const Execution& run)
{
  return this->Self->finish(run);
}

void ChildChannel::begin() const
{
  for (int descriptor = Pipe + 1; descriptor < 1024; ++descriptor)
  {
    close(descriptor);
  }
  // A limit on the size of files is an error like any other, which the libraries can tell.
  std::signal(SIGXFSZ, SIG_IGN);
}

bool ChildChannel::receive(char* data, std::size_t bytes) const
{
  for (std::size_t got = 0; got < bytes;)
  {
    const ssize_t count = read(0, data + got, bytes - got);
    if (count == 0 || (count < 0 && errno != EINTR))
    {
      return false;
    }
    got += static_cast<std::size_t>(std::max<ssize_t>(count, 0));
  }
  return true;
}

void ChildChannel::send(char kind, const void* data, std::size_t bytes) const
{
  std::string message(1, kind);
  message.append(static_cast<const char*>(data), bytes);
  for (std::size_t sent = 0; sent < message.size();)
  {
    const ssize_t count = write(Pipe, message.data() + sent, message.size() - sent);
    if (count < 0 && errno != EINTR)
    {
      _exit(1); // nobody listens any more
    }
    sent += static_cast<std::size_t>(std::max<ssize_t>(count, 0));
  }
}

#endif

std::optional<ChildResult> runChild(const std::string& program, const std::vector<std::string>& arguments,
  const std::string& subject, const ChildLimits& limits, const Execution& run)
{
  return ChildProcess(program, arguments, subject, limits).finish(run);
}

void ChildChannel::progress(double fraction) const
{
  this->send('P', &fraction, sizeof(fraction));
}

namespace
{

std::string withLength(const std::string& text)
{
  const std::uint64_t length = text.size();
  std::string message(sizeof(length), '\0');
  std::memcpy(message.data(), &length, sizeof(length));
  return message + text;
}

} // namespace

void ChildChannel::done(const std::string& message) const
{
  const std::string text = withLength(message);
  this->send('D', text.data(), text.size());
}

void ChildChannel::failed(const std::string& message) const
{
  const std::string text = withLength(message);
  this->send('E', text.data(), text.size());
}

} // namespace bsv
