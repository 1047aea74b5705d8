// SPDX-License-Identifier: BSD-3-Clause
/// @file FuzzSupport.h
/// What the fuzzers share: input as a file, and mutations of words and lines, which get behind the first check of a
/// text more often than those of bytes.
#pragma once

#include "Base/Types.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include <sys/mman.h>
#include <unistd.h>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

/// Freed memory that is kept to notice its use, in megabytes, and callers that are kept of each allocation: the
/// defaults, 256 and 30, are half of a short run.
extern "C" inline const char* __asan_default_options()
{
  return "quarantine_size_mb=16:malloc_context_size=8";
}

namespace fuzz
{

/// A regular file in memory with this content; one per process.
inline const std::string& fileWith(const std::uint8_t* data, std::size_t size)
{
  static const int descriptor = memfd_create("input", 0);
  static const std::string name = "/proc/self/fd/" + std::to_string(descriptor);
  if (ftruncate(descriptor, 0) != 0 || pwrite(descriptor, data, size, 0) != static_cast<ssize_t>(size))
  {
    std::abort();
  }
  return name;
}

/// Whatever a parser does not take must end in an Error; anything else ends the run.
template <typename Parse>
void parse(const Parse& parse)
{
  try
  {
    parse();
  }
  catch (const bsv::Error&)
  {
  }
}

/// Changes one word or line, or falls back to bytes.
inline std::size_t mutateText(
  std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed, const std::vector<std::string>& vocabulary)
{
  std::minstd_rand random(seed);
  const auto below = [&](std::size_t bound) { return bound == 0 ? 0 : random() % bound; };
  if (below(4) == 0 || size == 0)
  {
    return LLVMFuzzerMutate(data, size, most);
  }
  std::string text(reinterpret_cast<const char*>(data), size);
  const auto range = [&](const char* ends) {
    const std::size_t at = below(text.size());
    const std::size_t before = text.find_last_of(ends, at);
    const std::size_t begin = before == std::string::npos ? 0 : std::min(before + 1, text.size());
    return std::pair(begin, std::min(text.find_first_of(ends, begin), text.size()));
  };
  static const char* const numbers[] = { "0", "1", "2", "-1", "3", "4", "8", "1000000000", "2147483647", "-2147483648",
    "4294967296", "9223372036854775807", "1e308", "-1e-320", "nan", "inf", "0.5", "1.5", "1e-9", "" };
  switch (below(6))
  {
    case 0: // another word
    case 1: {
      const auto [begin, end] = range(" \t\n,;()=");
      const bool number = vocabulary.empty() || below(2) == 0;
      text.replace(begin, end - begin,
        number ? std::string(numbers[below(std::size(numbers))]) : vocabulary[below(vocabulary.size())]);
      break;
    }
    case 2: // a word of elsewhere
    {
      const auto [begin, end] = range(" \t\n,;()=");
      const auto [from, to] = range(" \t\n,;()=");
      text.replace(begin, end - begin, text.substr(from, to - from));
      break;
    }
    case 3: // a line less
    {
      const auto [begin, end] = range("\n");
      text.erase(begin, end - begin + 1);
      break;
    }
    case 4: // a line twice
    {
      const auto [begin, end] = range("\n");
      text.insert(begin, text.substr(begin, end - begin) + "\n");
      break;
    }
    default: // cut
      text.resize(below(text.size() + 1));
  }
  size = std::min(text.size(), most);
  std::copy_n(text.begin(), size, data);
  return size;
}

} // namespace fuzz

/// Defines the mutator of a text format with words of its own.
#define BSV_FUZZ_WORDS(...)                                                                                            \
  extern "C" std::size_t LLVMFuzzerCustomMutator(                                                                      \
    std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed)                                             \
  {                                                                                                                    \
    static const std::vector<std::string> words{ __VA_ARGS__ };                                                        \
    return fuzz::mutateText(data, size, most, seed, words);                                                            \
  }
