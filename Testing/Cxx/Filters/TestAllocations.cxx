// SPDX-License-Identifier: BSD-3-Clause
// An allocation that fails, whichever it is, ends in one error and empty outputs, and the algorithm can run again.
// A program of its own: it replaces operator new for all libraries. Those of the core, the readers and the writers
// fail; VTK does not survive its own, of a few bytes each, and shares its vectors with the filters.
#include "Support/Algorithms.h"

#include "Base/MemoryCheck.h"

#include <vtkSMPTools.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <new>
#include <string>
#include <vector>

#include <dlfcn.h>
#include <link.h>
#include <sys/resource.h>
#include <unistd.h>
#include <unwind.h>

namespace
{

std::atomic<bool> counting{ false };
std::atomic<long> allocations{ 0 };
/// The number of the one that fails, from 1; 0: none.
std::atomic<long> failing{ 0 };

struct Range
{
  std::uintptr_t begin, end;
  /// Whether VTK takes templates from there.
  bool shared;
};
/// Where our code is loaded.
std::array<Range, 64> ranges;
std::size_t rangeCount = 0;

/// Templates of the standard library that VTK has taken from our libraries: VTK does not survive their failures.
bool isForVTK()
{
  struct Walk
  {
    int frames = 0;
    bool inVTK = false;
  } walk;
  _Unwind_Backtrace(
    [](_Unwind_Context* context, void* data) {
      // This function, allocate(), operator new and its caller, which is ours, come first.
      constexpr int First = 3;
      constexpr int Last = First + 2;
      auto& state = *static_cast<Walk*>(data);
      Dl_info library{};
      state.inVTK = state.frames > First && dladdr(reinterpret_cast<void*>(_Unwind_GetIP(context)), &library) != 0 &&
        std::strstr(library.dli_fname, "libvtk");
      return state.inVTK || ++state.frames > Last ? _URC_END_OF_STACK : _URC_NO_REASON;
    },
    &walk);
  return walk.inVTK;
}

bool isOurs(const void* caller)
{
  const auto address = reinterpret_cast<std::uintptr_t>(caller);
  const auto found = std::find_if(ranges.begin(), ranges.begin() + rangeCount,
    [&](const Range& range) { return address >= range.begin && address < range.end; });
  return found != ranges.begin() + rangeCount && !(found->shared && isForVTK());
}

void* allocate(std::size_t bytes, std::size_t alignment, const void* caller)
{
  if (counting && isOurs(caller) && ++allocations == failing)
  {
    throw std::bad_alloc();
  }
  bytes = std::max<std::size_t>(bytes, 1);
  void* room = alignment > alignof(std::max_align_t)
    ? std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment)
    : std::malloc(bytes);
  if (!room)
  {
    throw std::bad_alloc();
  }
  return room;
}

/// Never inlined: compilers would see free() for what they know to come from `new`, and warn.
[[gnu::noinline]] void release(void* room)
{
  std::free(room);
}

} // namespace

void* operator new(std::size_t bytes)
{
  return allocate(bytes, 0, __builtin_return_address(0));
}
void* operator new[](std::size_t bytes)
{
  return allocate(bytes, 0, __builtin_return_address(0));
}
void* operator new(std::size_t bytes, std::align_val_t alignment)
{
  return allocate(bytes, static_cast<std::size_t>(alignment), __builtin_return_address(0));
}
void* operator new[](std::size_t bytes, std::align_val_t alignment)
{
  return allocate(bytes, static_cast<std::size_t>(alignment), __builtin_return_address(0));
}
void operator delete(void* room) noexcept
{
  release(room);
}
void operator delete[](void* room) noexcept
{
  release(room);
}
void operator delete(void* room, std::size_t) noexcept
{
  release(room);
}
void operator delete[](void* room, std::size_t) noexcept
{
  release(room);
}
void operator delete(void* room, std::align_val_t) noexcept
{
  release(room);
}
void operator delete[](void* room, std::align_val_t) noexcept
{
  release(room);
}
void operator delete(void* room, std::size_t, std::align_val_t) noexcept
{
  release(room);
}
void operator delete[](void* room, std::size_t, std::align_val_t) noexcept
{
  release(room);
}

namespace
{

void findRanges()
{
  dl_iterate_phdr(
    [](dl_phdr_info* library, std::size_t, void*) {
      for (int n = 0; n < library->dlpi_phnum && rangeCount < ranges.size(); ++n)
      {
        const auto& part = library->dlpi_phdr[n];
        const bool isCore = std::strstr(library->dlpi_name, "libBSplineVolumeCore");
        const bool isIO = std::strstr(library->dlpi_name, "libBSplineVolumeReaders") ||
          std::strstr(library->dlpi_name, "libBSplineVolumeWriters");
        if ((isCore || isIO) && part.p_type == PT_LOAD && (part.p_flags & PF_X))
        {
          const std::uintptr_t begin = library->dlpi_addr + part.p_vaddr;
          ranges[rangeCount++] = { begin, begin + part.p_memsz, isIO };
        }
      }
      return 0;
    },
    nullptr);
}

/// Runs `algorithm`, whose allocation of number `which` fails.
algorithms::Told runCounted(vtkAlgorithm* algorithm, long which)
{
  allocations = 0;
  failing = which;
  counting = true;
  auto told = algorithms::run(algorithm);
  counting = false;
  failing = 0;
  return told;
}

TEST(Allocations, OneThatFailsIsOneError)
{
  findRanges();
  ASSERT_GT(rangeCount, 0u);
  // One thread: an exception in another one of VTK's is VTK's affair.
  vtkSMPTools::SetBackend("Sequential");
  char name[] = "/tmp/bsv-Allocations-XXXXXX";
  const std::string folder = std::string(::mkdtemp(name)) + "/";
  const algorithms::Inputs inputs(folder);
  // Every so many of them; 1 tries all, which takes hours.
  const char* all = std::getenv("BSV_ALL_ALLOCATIONS");
  const char* only = std::getenv("BSV_ALLOCATIONS_ONLY");
  long tried = 0;
  std::vector<algorithms::Inputs::Case> cases = inputs.filters();
  for (const algorithms::Inputs::Case& writer : inputs.writers())
  {
    algorithms::run(writer.make()); // what the readers read
  }
  for (const auto& more : { inputs.writers(), inputs.readers() })
  {
    cases.insert(cases.end(), more.begin(), more.end());
  }
  for (const algorithms::Inputs::Case& which : cases)
  {
    if (only && which.name.find(only) == std::string::npos)
    {
      continue;
    }
    vtkSmartPointer<vtkAlgorithm> algorithm = which.make();
    runCounted(algorithm, 0);
    const long count = allocations;
    const vtkIdType size = algorithms::sizeOfOutputs(algorithm);
    long errors = 0;
    long outside = 0;
    // All numbers, or some from the first to the last.
    for (long n = 1; n <= count; n += all ? std::max(1L, std::atol(all)) : std::max(1L, (count + 4) / 5))
    {
      const std::string place = which.name + ", allocation " + std::to_string(n) + " of " + std::to_string(count);
      SCOPED_TRACE(place);
      algorithms::Told told;
      ++tried;
      try
      {
        told = runCounted(algorithm, n);
      }
      catch (const std::bad_alloc&)
      {
        // Of VTK's pipeline around the work of the algorithm.
        counting = false;
        ++outside;
        algorithm = which.make();
        continue;
      }
      ASSERT_LE(told.messages.size(), 1u);
      if (!told.messages.empty())
      {
        ++errors;
        EXPECT_NE(told.messages[0].find("memory"), std::string::npos) << told.messages[0];
        EXPECT_NE(told.messages[0].find(algorithm->GetClassName()), std::string::npos) << told.messages[0];
        EXPECT_EQ(algorithms::sizeOfOutputs(algorithm), 0);
      }
      else
      {
        // The standard library does without memory that only saves time.
        EXPECT_EQ(algorithms::sizeOfOutputs(algorithm), size);
      }
    }
    EXPECT_EQ(algorithms::run(algorithm).messages, std::vector<std::string>()) << which.name;
    EXPECT_EQ(algorithms::sizeOfOutputs(algorithm), size) << which.name;
    std::cout << which.name << ": " << count << " allocations, " << errors << " errors, " << outside << " outside\n";
  }
  std::cout << tried << " allocations failed\n";
  std::filesystem::remove_all(folder);
}

TEST(Memory, WhatIsNotFreeIsRefusedWithBothFigures)
{
  struct rlimit unlimited;
  ASSERT_EQ(::getrlimit(RLIMIT_AS, &unlimited), 0);
  const double before = bsv::freeMemory();
  EXPECT_GT(before, 1e6);
  std::ifstream pages("/proc/self/statm");
  rlim_t used = 0;
  pages >> used;
  used *= static_cast<rlim_t>(::sysconf(_SC_PAGESIZE));
  const struct rlimit little = { used + 500000000, unlimited.rlim_max };
  ASSERT_EQ(::setrlimit(RLIMIT_AS, &little), 0);
  const double left = bsv::freeMemory();
  std::string text;
  try
  {
    bsv::requireMemory(2e9, "Level 9", "the samples");
  }
  catch (const bsv::Error& error)
  {
    text = error.what();
  }
  ASSERT_EQ(::setrlimit(RLIMIT_AS, &unlimited), 0);
  EXPECT_LE(left, 500000000.0);
  EXPECT_LE(left, before);
  EXPECT_EQ(text.rfind("Level 9 needs 2 GB for the samples; 0.", 0), 0u) << text;
  EXPECT_NE(text.find(" GB are free"), std::string::npos) << text;
}

} // namespace
