// SPDX-License-Identifier: BSD-3-Clause
#include "IO/FileParts.h"

#include "Ranks/OwnedValues.h"

#include <algorithm>
#include <numeric>

namespace bsv
{

void writeParts(AtomicFile& file, const std::vector<FilePart>& parts, const Execution& run)
{
  const Ranks& ranks = *run.ranks;
  const auto isOwn = [&](const FilePart& part) { return part.rank == ranks.rank(); };
  double total = 1.0;
  for (const FilePart& part : parts)
  {
    total += isOwn(part) ? part.work : 0.0;
  }
  const auto overOwn = [&](double from, double to, const auto& visit) {
    double done = 0.0;
    for (std::size_t p = 0; p < parts.size(); ++p)
    {
      if (isOwn(parts[p]))
      {
        visit(p, [&](double work) { run.report(from + (to - from) * (done + work) / total); });
        done += parts[p].work;
      }
    }
  };

  // A process alone writes one part behind the other and needs no sizes.
  std::vector<Index> start;
  const bool several = ranks.size() > 1;
  const bool counting =
    several && std::any_of(parts.begin(), parts.end(), [](const FilePart& part) { return part.size < 0; });
  if (several)
  {
    std::vector<Index> sizes;
    for (const FilePart& part : parts)
    {
      sizes.push_back(part.size);
    }
    const Index position = ranks.rank() == 0 ? file.position() : 0;
    CharacterCount written;
    overOwn(0.0, counting ? 0.5 : 0.0, [&](std::size_t p, const PartReport& report) {
      if (sizes[p] < 0)
      {
        const Index before = written.count();
        parts[p].write(written, report);
        sizes[p] = written.count() - before;
      }
    });
    ranks.share(sizes, [&](Index p) { return parts[p].rank; });
    start.assign(parts.size() + 1, 0);
    std::copy(sizes.begin(), sizes.end(), start.begin() + 1);
    start[0] = ranks.gatherAll(std::vector<Index>{ position }).front();
    std::partial_sum(start.begin(), start.end(), start.begin());
  }
  overOwn(counting ? 0.5 : 0.0, 1.0, [&](std::size_t p, const PartReport& report) {
    if (several)
    {
      file.seek(start[p]);
    }
    parts[p].write(file, report);
  });
  if (several && ranks.rank() == 0)
  {
    file.seek(start.back());
  }
}

//------------------------------------------------------------------------------
AtomicFile& FileGroup::add(const std::string& path)
{
  this->Files.push_back(std::make_unique<AtomicFile>(path, *this->Run.ranks));
  return *this->Files.back();
}

void FileGroup::publish()
{
  const Ranks& ranks = *this->Run.ranks;
  for (const auto& file : this->Files)
  {
    file->finish();
  }
  this->Run.report(1.0);
  // No file gets its name before all are complete on all ranks.
  ranks.together([] {});
  if (ranks.rank() == 0)
  {
    for (const auto& file : this->Files)
    {
      file->publish();
    }
  }
  this->Files.clear();
}

} // namespace bsv
