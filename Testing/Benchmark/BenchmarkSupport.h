// SPDX-License-Identifier: BSD-3-Clause
/// @file BenchmarkSupport.h
/// What all benchmarks share: sizes, threads, and the comparison with memcpy.
///
/// Every benchmark has the arguments `points` and `threads` and reports, besides Google Benchmark's own times,
/// | counter       | meaning |
/// |---------------|---------|
/// | `seconds`     | the fastest iteration, which other processes on the machine disturb least; of what runs on one
///                 thread and waits for no disk, the processor time |
/// | `bytes`       | bytes of the result |
/// | `memcpy`      | time of a memcpy of as many bytes, on as many threads, in this run, divided by `seconds` |
/// | `extra_bytes` | optional: peak memory beyond input and output |
/// table.py reads them.
#pragma once

#include "Base/Types.h"

#include <benchmark/benchmark.h>
#include <vtkSMPTools.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <malloc.h>
#include <time.h>

namespace bsvbench
{

using bsv::Index;

inline Index pointsOf(const benchmark::State& state)
{
  return state.range(0);
}
inline int threadsOf(const benchmark::State& state)
{
  return static_cast<int>(state.range(1));
}

/// A value of /proc/<file> in bytes, such as "MemAvailable:" of meminfo; 0 if there is none.
inline double procBytes(const char* file, const std::string& key)
{
  std::ifstream in(std::string("/proc/") + file);
  std::string word;
  double kilobytes = 0.0;
  while (in >> word)
  {
    if (word == key && in >> kilobytes)
    {
      break;
    }
  }
  return 1024.0 * kilobytes;
}

/// 10^4 to 10^`decades` points, as far as memory goes, each on one and on two threads.
inline void sizes(benchmark::internal::Benchmark* benchmark, double bytesPerPoint, int decades = 8)
{
  benchmark->ArgNames({ "points", "threads" })->UseRealTime()->Unit(benchmark::kMillisecond);
  for (int decade = 4; decade <= decades; ++decade)
  {
    const double points = std::pow(10.0, decade);
    if (points * bytesPerPoint < 0.8 * procBytes("meminfo", "MemAvailable:"))
    {
      benchmark->Args({ Index(points), 1 })->Args({ Index(points), 2 });
    }
  }
}

/// Loops on vtkSMPTools, as the filters run them.
inline bsv::Execution execution(int threads)
{
  bsv::Execution run;
  if (threads > 1)
  {
    vtkSMPTools::SetBackend("STDThread");
    vtkSMPTools::Initialize(threads);
    run.parallelFor = [](Index count, Index grain, const bsv::Execution::Body& body) {
      vtkSMPTools::For(0, count, grain, [&](vtkIdType begin, vtkIdType end) { body(begin, end); });
    };
  }
  return run;
}

/// What a benchmark was last asked for: Google Benchmark calls it several times with the same arguments.
template <typename Case, typename Make>
Case& cached(Index key, const Make& make)
{
  static std::unique_ptr<Case> last;
  static Index lastKey = -1;
  if (lastKey != key)
  {
    last.reset();
    last = std::make_unique<Case>(make());
    lastKey = key;
  }
  return *last;
}

/// Wall time, or processor time of the process, which other processes on the machine change little.
enum class Clock
{
  Wall,
  Processor
};

inline double now(Clock clock)
{
  timespec time;
  ::clock_gettime(clock == Clock::Wall ? CLOCK_MONOTONIC : CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

template <typename Body>
double secondsOf(const Body& body, Clock clock)
{
  const double start = now(clock);
  body();
  return now(clock) - start;
}

inline Clock clockFor(int threads)
{
  return threads == 1 ? Clock::Processor : Clock::Wall;
}

/// The benchmark's loop. Returns the time of its fastest iteration; `prepare` is called before each and not timed.
template <typename Body, typename Prepare>
double fastest(benchmark::State& state, const Body& body, Clock clock, const Prepare& prepare)
{
  double seconds = std::numeric_limits<double>::max();
  for (auto _ : state)
  {
    prepare();
    seconds = std::min(seconds, secondsOf(body, clock));
  }
  return seconds;
}
template <typename Body>
double fastest(benchmark::State& state, const Body& body)
{
  return fastest(state, body, clockFor(threadsOf(state)), [] {});
}

struct Copy
{
  void* to;
  const void* from;
  std::size_t bytes;
};

/// The lower half of a buffer onto its upper half: half of the bytes.
inline Copy half(double* values, std::size_t count)
{
  return { values + count / 2, values, count / 2 * sizeof(double) };
}

/// Fastest of several runs of all copies, cut among the threads.
inline double memcpySeconds(const std::vector<Copy>& copies, int threads)
{
  const bsv::Execution run = execution(threads);
  const auto once = [&] {
    run.parallelFor(threads, 1, [&](Index begin, Index end) {
      for (Index t = begin; t < end; ++t)
      {
        for (const Copy& copy : copies)
        {
          const std::size_t from = copy.bytes * t / threads, to = copy.bytes * (t + 1) / threads;
          std::memcpy(static_cast<char*>(copy.to) + from, static_cast<const char*>(copy.from) + from, to - from);
        }
      }
    });
    benchmark::ClobberMemory();
  };
  double seconds = std::numeric_limits<double>::max();
  double total = 0.0;
  for (int n = 0; n < 3 || (total < 0.2 && n < 1000); ++n)
  {
    const double one = secondsOf(once, clockFor(threads));
    seconds = std::min(seconds, one);
    total += one;
  }
  return seconds;
}

/// Reports a benchmark whose result has `bytes`; `copies` copy as many or fewer of them.
inline void report(benchmark::State& state, double seconds, double bytes, const std::vector<Copy>& copies)
{
  double copied = 0.0;
  for (const Copy& copy : copies)
  {
    copied += static_cast<double>(copy.bytes);
  }
  state.counters["seconds"] = seconds;
  state.counters["bytes"] = bytes;
  state.counters["memcpy"] = memcpySeconds(copies, threadsOf(state)) * (bytes / copied) / seconds;
}

/// Reports the peak of the memory that `body` takes beyond what is there before.
template <typename Body>
void reportMemory(benchmark::State& state, const Body& body)
{
  ::malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << "5"; // resets the peak
  const double before = procBytes("self/status", "VmHWM:");
  body();
  state.counters["extra_bytes"] = procBytes("self/status", "VmHWM:") - before;
}

} // namespace bsvbench
