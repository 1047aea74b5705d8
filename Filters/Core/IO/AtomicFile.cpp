// SPDX-License-Identifier: BSD-3-Clause
#include "IO/AtomicFile.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <string_view>
#include <system_error>

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

namespace bsv
{

namespace
{

/// The names of temporary files beside a target: the start of its name, a hash of all of it, the machine and the
/// process that write. No longer than the file system takes.
class TemporaryNames
{
public:
  explicit TemporaryNames(const std::string& target)
  {
    const std::filesystem::path path(target);
    this->Folder = path.parent_path();
    const std::string name = path.filename().string();
    char machine[256] = "";
    ::gethostname(machine, sizeof machine - 1);
    this->Machine = hex(machine);
    const long longest = ::pathconf(this->Folder.empty() ? "." : this->Folder.c_str(), _PC_NAME_MAX);
    // Beside what is below: the machine and the process, see own().
    constexpr std::size_t Rest = 2 + 8 + 1 + 8 + 1 + 10 + 1 + 4 + 4;
    const std::size_t room = static_cast<std::size_t>(std::max(64L, longest)) - Rest;
    this->Start = name.substr(0, room) + "." + hex(name) + ".";
  }

  /// A name for this process. @param attempt distinguishes files that it writes at the same time, at most 9999
  std::string own(int attempt) const
  {
    const std::string number = std::to_string(::getpid()) + "-" + std::to_string(attempt);
    return (this->Folder / (this->Start + this->Machine + "-" + number + std::string(Suffix))).string();
  }

  /// Removes what writers have left that were killed: processes of this machine that are gone. Others, whose processes
  /// cannot be seen from here, are gone if their files have not been touched for a day.
  void removeLeftovers() const
  {
    std::error_code failure;
    const std::filesystem::directory_iterator files(this->Folder.empty() ? "." : this->Folder, failure);
    if (failure)
    {
      return;
    }
    for (auto file = begin(files); file != end(files) && !failure; file.increment(failure))
    {
      const std::string name = file->path().filename().string();
      if (name.size() > this->Start.size() + Suffix.size() && name.compare(0, this->Start.size(), this->Start) == 0 &&
        name.compare(name.size() - Suffix.size(), Suffix.size(), Suffix) == 0 && this->isLeft(name))
      {
        ::unlink((this->Folder / name).c_str());
      }
    }
  }

private:
  static constexpr std::string_view Suffix = ".tmp";

  static std::string hex(const std::string& text)
  {
    std::uint32_t hash = 2166136261u; // FNV-1a
    for (const char c : text)
    {
      hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
    }
    char digits[9];
    std::snprintf(digits, sizeof digits, "%08x", hash);
    return digits;
  }

  bool isLeft(const std::string& name) const
  {
    const std::string machine = this->Machine + "-";
    if (name.compare(this->Start.size(), machine.size(), machine) == 0)
    {
      const long process = std::strtol(name.c_str() + this->Start.size() + machine.size(), nullptr, 10);
      if (process > 0 && ::kill(static_cast<pid_t>(process), 0) != 0 && errno == ESRCH)
      {
        return true;
      }
    }
    struct stat status;
    constexpr std::time_t Day = 86400;
    return ::stat((this->Folder / name).c_str(), &status) == 0 && std::time(nullptr) - status.st_mtime > Day;
  }

  std::filesystem::path Folder;
  std::string Start, Machine;
};

} // namespace

//------------------------------------------------------------------------------
FileError::FileError(const std::string& text, int code)
  : Error(text + ": " + std::strerror(code))
  , NoRoom(code == ENOSPC || code == EDQUOT || code == EFBIG)
{
}

//------------------------------------------------------------------------------
char* OutputBuffer::room(std::size_t size)
{
  if (this->Used + size > this->Buffer.size())
  {
    this->flush();
    if (size > this->Buffer.size())
    {
      this->Buffer.resize(size);
    }
  }
  return this->Buffer.data() + this->Used;
}

void OutputBuffer::write(const char* data, std::size_t size)
{
  if (size > this->Buffer.size())
  {
    this->flush();
    this->put(data, size);
    return;
  }
  char* to = this->room(size);
  std::memcpy(to, data, size);
  this->advance(to + size);
}

void OutputBuffer::flush()
{
  this->put(this->Buffer.data(), this->Used);
  this->Used = 0;
}

//------------------------------------------------------------------------------
AtomicFile::AtomicFile(const std::string& path, const Ranks& ranks)
  : Target(path)
  , Owner(ranks.rank() == 0)
{
  // An error in a constructor calls no destructor.
  try
  {
    if (this->Owner)
    {
      this->create();
    }
    const std::vector<char> name =
      ranks.gather(std::vector<char>(this->Temporary.begin(), this->Temporary.end())).front();
    // Rank 0 does nothing with the file before all have opened it.
    ranks.together([&] {
      if (!this->Owner)
      {
        this->Temporary.assign(name.begin(), name.end());
        this->Descriptor = ::open(this->Temporary.c_str(), O_WRONLY | O_CLOEXEC);
        if (this->Descriptor < 0)
        {
          this->fail("find, on rank " + std::to_string(ranks.rank()) + ", what rank 0 writes for");
        }
        this->limitSize();
      }
    });
  }
  catch (...)
  {
    this->discard();
    throw;
  }
}

void AtomicFile::create()
{
  const std::string path = this->Target;
  this->Target = this->withLinksFollowed(path);
  struct stat status;
  if (::stat(this->Target.c_str(), &status) == 0)
  {
    if (!S_ISREG(status.st_mode))
    {
      throw Error("Cannot write '" + path + "': it is not a regular file");
    }
    this->Mode = status.st_mode & 07777;
  }
  else if (errno != ENOENT)
  {
    // Such as a name that is too long, which only the end would find.
    this->fail("create");
  }
  const TemporaryNames names(this->Target);
  names.removeLeftovers();
  for (int attempt = 0; this->Descriptor < 0; ++attempt)
  {
    const std::string name = names.own(attempt);
    this->Descriptor = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (this->Descriptor >= 0)
    {
      this->Temporary = name;
    }
    else if (errno != EEXIST || attempt == 1000)
    {
      this->fail("create");
    }
  }
  this->limitSize();
  this->keepPermissions();
}

void AtomicFile::limitSize()
{
  struct rlimit limit;
  if (::getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
  {
    this->Largest = static_cast<Index>(limit.rlim_cur);
  }
}

/// The file that a chain of symbolic links ends at, which need not exist.
std::string AtomicFile::withLinksFollowed(const std::string& path) const
{
  constexpr int LongestChain = 40;
  std::filesystem::path result = path;
  for (int links = 0;; ++links)
  {
    std::error_code failure;
    if (!std::filesystem::is_symlink(result, failure))
    {
      return result.string();
    }
    if (links == LongestChain)
    {
      errno = ELOOP;
      this->fail("follow the symbolic links of");
    }
    result = result.parent_path() / std::filesystem::read_symlink(result, failure);
  }
}

void AtomicFile::keepPermissions()
{
  if (this->Mode != 0)
  {
    // Some file systems have no permissions; the file is as good without.
    (void)!::fchmod(this->Descriptor, static_cast<mode_t>(this->Mode));
  }
}

void AtomicFile::requireRoom(double bytes) const
{
  if (this->Largest >= 0 && bytes > static_cast<double>(this->Largest))
  {
    errno = EFBIG;
    this->fail("write");
  }
  struct statvfs system;
  if (::fstatvfs(this->Descriptor, &system) == 0 &&
    bytes > static_cast<double>(system.f_bavail) * static_cast<double>(system.f_frsize))
  {
    errno = ENOSPC;
    this->fail("write");
  }
}

void AtomicFile::takeOver()
{
  ::close(this->Descriptor);
  this->Descriptor = ::open(this->Temporary.c_str(), O_WRONLY | O_CLOEXEC);
  if (this->Descriptor < 0)
  {
    this->fail("find what was written for");
  }
  this->keepPermissions();
}

AtomicFile::~AtomicFile()
{
  this->discard();
}

void AtomicFile::discard()
{
  if (this->Descriptor >= 0)
  {
    ::close(this->Descriptor);
  }
  if (this->Owner && !this->Temporary.empty())
  {
    ::unlink(this->Temporary.c_str());
  }
}

void AtomicFile::seek(Index offset)
{
  this->flush();
  if (::lseek(this->Descriptor, static_cast<off_t>(offset), SEEK_SET) < 0)
  {
    this->fail("write");
  }
}

Index AtomicFile::position()
{
  this->flush();
  return static_cast<Index>(::lseek(this->Descriptor, 0, SEEK_CUR));
}

void AtomicFile::put(const char* data, std::size_t size)
{
  // The system would end the process.
  if (this->Largest >= 0 &&
    static_cast<Index>(::lseek(this->Descriptor, 0, SEEK_CUR)) + static_cast<Index>(size) > this->Largest)
  {
    errno = EFBIG;
    this->fail("write");
  }
  for (std::size_t done = 0; done < size;)
  {
    const ssize_t written = ::write(this->Descriptor, data + done, size - done);
    if (written < 0 && errno != EINTR)
    {
      this->fail("write");
    }
    done += written > 0 ? static_cast<std::size_t>(written) : 0;
  }
}

void AtomicFile::finish()
{
  this->flush();
  if (::fsync(this->Descriptor) != 0)
  {
    this->fail("write");
  }
  const int closed = ::close(this->Descriptor);
  this->Descriptor = -1;
  if (closed != 0)
  {
    this->fail("write");
  }
}

void AtomicFile::publish()
{
  if (::rename(this->Temporary.c_str(), this->Target.c_str()) != 0)
  {
    this->fail("replace");
  }
  this->Temporary.clear();
  // Best effort: without it a crash of the machine may bring the old file back, but never half a file.
  const std::size_t slash = this->Target.rfind('/');
  const std::string folder = slash == std::string::npos ? "." : this->Target.substr(0, slash + 1);
  const int descriptor = ::open(folder.c_str(), O_RDONLY);
  if (descriptor >= 0)
  {
    ::fsync(descriptor);
    ::close(descriptor);
  }
}

void AtomicFile::fail(const std::string& what) const
{
  throw FileError("Cannot " + what + " '" + this->Target + "'", errno);
}

} // namespace bsv
