// SPDX-License-Identifier: BSD-3-Clause
#include "Base/MemoryCheck.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

#ifdef __unix__
#include <sys/resource.h>
#include <unistd.h>
#endif

namespace bsv
{

namespace
{

constexpr double Unlimited = std::numeric_limits<double>::infinity();

/// The number in a file; `missing` if there is none.
double numberIn(const std::string& file, double missing)
{
  std::ifstream stream(file);
  double number = 0.0;
  return stream >> number ? number : missing;
}

/// The number behind a word that begins a line.
double numberBehind(const std::string& file, const std::string& word, double missing)
{
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);)
  {
    std::istringstream words(line);
    std::string first;
    double number = 0.0;
    if (words >> first >> number && first == word)
    {
      return number;
    }
  }
  return missing;
}

/// What the control groups leave, from the process's own up to the root: their limit, less what is used and not only
/// kept of files.
double leftByGroups(const std::string& root, std::string group, const char* limit, const char* usage, const char* files)
{
  double least = Unlimited;
  while (true)
  {
    const std::string folder = root + group + "/";
    const double most = numberIn(folder + limit, Unlimited);
    const double used = numberIn(folder + usage, 0.0) - numberBehind(folder + "memory.stat", files, 0.0);
    least = std::min(least, std::max(0.0, most - used));
    if (group.empty())
    {
      return least;
    }
    group.resize(std::min(group.rfind('/'), group.size() - 1));
  }
}

double leftByControlGroups()
{
  double least = Unlimited;
  std::ifstream stream("/proc/self/cgroup");
  // number:controllers:group
  for (std::string line; std::getline(stream, line);)
  {
    const std::size_t first = line.find(':');
    const std::size_t second = first == std::string::npos ? first : line.find(':', first + 1);
    if (second == std::string::npos)
    {
      continue;
    }
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    std::string group = line.substr(second + 1);
    group = group == "/" ? "" : group;
    if (controllers == ",,")
    {
      least = std::min(least, leftByGroups("/sys/fs/cgroup", group, "memory.max", "memory.current", "inactive_file"));
    }
    else if (controllers.find(",memory,") != std::string::npos)
    {
      least = std::min(least,
        leftByGroups(
          "/sys/fs/cgroup/memory", group, "memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"));
    }
  }
  return least;
}

double leftOfAddressSpace()
{
#ifdef __unix__
  struct rlimit limit;
  if (::getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
  {
    const double used = numberIn("/proc/self/statm", 0.0) * static_cast<double>(::sysconf(_SC_PAGESIZE));
    return std::max(0.0, static_cast<double>(limit.rlim_cur) - used);
  }
#endif
  return Unlimited;
}

} // namespace

double& pretendedFreeMemory()
{
  static double bytes = Unlimited;
  return bytes;
}

double freeMemory()
{
  double machine = numberBehind("/proc/meminfo", "MemAvailable:", -1.0) * 1024.0;
  if (machine < 0.0)
  {
#ifdef __unix__
    machine = static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
#else
    machine = Unlimited;
#endif
  }
  return std::min({ machine, leftByControlGroups(), leftOfAddressSpace(), pretendedFreeMemory() });
}

void requireMemory(double bytes, const std::string& request, const std::string& content)
{
  const double present = freeMemory();
  if (bytes > present)
  {
    std::ostringstream text;
    text << request << " needs " << bytes / 1e9 << " GB for " << content << "; " << present / 1e9 << " GB are free";
    throw Error(text.str());
  }
}

std::string outOfMemory()
{
  std::ostringstream text;
  text << "there is not enough memory; " << freeMemory() / 1e9 << " GB are free";
  return text.str();
}

} // namespace bsv
