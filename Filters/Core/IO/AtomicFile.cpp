// SPDX-License-Identifier: BSD-3-Clause
#include "IO/AtomicFile.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

namespace bsv
{

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
    ranks.together([&] {
      if (this->Owner)
      {
        this->create();
      }
    });
    const std::vector<char> name =
      ranks.gather(std::vector<char>(this->Temporary.begin(), this->Temporary.end())).front();
    ranks.together([&] {
      if (!this->Owner)
      {
        this->Temporary.assign(name.begin(), name.end());
        this->Descriptor = ::open(this->Temporary.c_str(), O_WRONLY | O_CLOEXEC);
        if (this->Descriptor < 0)
        {
          this->fail("find, on rank " + std::to_string(ranks.rank()) + ", what rank 0 writes for");
        }
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
  if (char* resolved = ::realpath(path.c_str(), nullptr))
  {
    this->Target = resolved;
    std::free(resolved);
    struct stat status;
    if (::stat(this->Target.c_str(), &status) != 0)
    {
      this->fail("read the status of");
    }
    if (!S_ISREG(status.st_mode))
    {
      throw Error("Cannot write '" + path + "': it is not a regular file");
    }
    this->Mode = status.st_mode & 07777;
  }
  for (int attempt = 0; this->Descriptor < 0; ++attempt)
  {
    const std::string name = this->Target + "." + std::to_string(::getpid()) + "-" + std::to_string(attempt) + ".tmp";
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
  this->keepPermissions();
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
  struct rlimit limit;
  if (::getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY &&
    bytes > static_cast<double>(limit.rlim_cur))
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
