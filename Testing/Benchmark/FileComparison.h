// SPDX-License-Identifier: BSD-3-Clause
/// @file FileComparison.h
/// For the benchmarks of readers and writers: a folder for their files, and how long plain reading and writing take.
#pragma once

#include "BenchmarkSupport.h"

#include <filesystem>
#include <string>

#include <fcntl.h>
#include <unistd.h>

namespace bsvbench
{

/// A folder that is removed with everything in it.
class Folder
{
public:
  Folder()
    : Path(std::filesystem::temp_directory_path() / ("bsv-benchmark-" + std::to_string(::getpid())))
  {
    std::filesystem::create_directories(this->Path);
  }
  ~Folder() { std::filesystem::remove_all(this->Path); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string operator/(const std::string& name) const { return (this->Path / name).string(); }

private:
  std::filesystem::path Path;
};

inline const Folder& folder()
{
  static const Folder one;
  return one;
}

/// Makes the next reader of a file read the disk.
inline void evict(const std::string& path)
{
  const int file = ::open(path.c_str(), O_RDONLY);
  ::fsync(file);
  ::posix_fadvise(file, 0, 0, POSIX_FADV_DONTNEED);
  ::close(file);
}

/// Fastest of three readings of a file from the disk in pieces of 1 MB, or copies of it that end on the disk.
inline double plainSeconds(const std::string& path, bool write)
{
  std::vector<char> buffer(std::size_t(1) << 20);
  double best = std::numeric_limits<double>::max();
  for (int n = 0; n < 3; ++n)
  {
    const std::string copy = path + ".copy";
    if (!write)
    {
      evict(path);
    }
    best = std::min(best,
      secondsOf(
        [&] {
          const int in = ::open(path.c_str(), O_RDONLY);
          const int out = write ? ::open(copy.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600) : -1;
          for (ssize_t size = 1; size > 0;)
          {
            size = ::read(in, buffer.data(), buffer.size());
            if (write && size > 0 && ::write(out, buffer.data(), size) != size)
            {
              size = -1;
            }
          }
          if (write)
          {
            ::fsync(out);
            ::close(out);
          }
          ::close(in);
        },
        Clock::Wall));
    std::filesystem::remove(copy);
  }
  return best;
}

/// report() with the bytes of the file, and the counter `disk`: the time of plainSeconds() divided by `seconds`.
inline void reportFile(benchmark::State& state, double seconds, const std::string& path, bool write)
{
  const std::size_t bytes = std::filesystem::file_size(path);
  std::vector<double> buffer(std::min(bytes / 8, std::size_t(1) << 27));
  report(state, seconds, static_cast<double>(bytes), { half(buffer.data(), buffer.size()) });
  state.counters["disk"] = plainSeconds(path, write) / seconds;
}

/// 10^4 to 10^7 points, on one thread: files are read and written by one.
inline void fileSizes(benchmark::internal::Benchmark* benchmark)
{
  benchmark->ArgNames({ "points", "threads" })->UseRealTime()->Unit(benchmark::kMillisecond)->Iterations(5);
  for (const Index points : { 10000, 100000, 1000000, 10000000 })
  {
    benchmark->Args({ points, 1 });
  }
}

} // namespace bsvbench
