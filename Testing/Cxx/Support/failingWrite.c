// SPDX-License-Identifier: BSD-3-Clause
/* A disk that gets full, or a crash, while a program writes: preloaded (LD_PRELOAD), the write to a file whose number
   BSV_FAILING_WRITE names fails, and all after it; or the program ends there, if BSV_CRASHING_WRITE names it. Numbers
   count from 1, in the second case writes to pipes, too. */
#define _GNU_SOURCE /* NOLINT(bugprone-reserved-identifier): the C library asks for it */
#include <dlfcn.h>
#include <errno.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

static long number(const char* name)
{
  const char* text = getenv(name);
  return text ? atol(text) : 0;
}

static int fails(int file)
{
  static long writes = 0, files = 0;
  struct stat status;
  ++writes;
  if (writes == number("BSV_CRASHING_WRITE"))
  {
    abort();
  }
  if (fstat(file, &status) != 0 || !S_ISREG(status.st_mode))
  {
    return 0;
  }
  ++files;
  const long first = number("BSV_FAILING_WRITE");
  if (first > 0 && files >= first)
  {
    errno = ENOSPC;
    return 1;
  }
  return 0;
}

ssize_t write(int file, const void* data, size_t size)
{
  ssize_t (*next)(int, const void*, size_t) = (ssize_t(*)(int, const void*, size_t))dlsym(RTLD_NEXT, "write");
  return fails(file) ? -1 : next(file, data, size);
}

ssize_t pwrite64(int file, const void* data, size_t size, off64_t offset)
{
  ssize_t (*next)(int, const void*, size_t, off64_t) =
    (ssize_t(*)(int, const void*, size_t, off64_t))dlsym(RTLD_NEXT, "pwrite64");
  return fails(file) ? -1 : next(file, data, size, offset);
}

ssize_t pwrite(int file, const void* data, size_t size, off_t offset)
{
  return pwrite64(file, data, size, offset);
}
