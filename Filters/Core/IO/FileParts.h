// SPDX-License-Identifier: BSD-3-Clause
/// @file FileParts.h
/// One file that several ranks write, and several files that appear together.
#pragma once

#include "IO/AtomicFile.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace bsv
{

/// Told the work done of a part, every now and then. @throws Aborted
using PartReport = std::function<void(double done)>;

/// Part of a file that one rank writes.
struct FilePart
{
  int rank = 0;
  /// How much there is to do, in any unit, for progress.
  double work = 1.0;
  std::function<void(OutputBuffer& out, const PartReport& report)> write;
  /// Its bytes, if they are known before, or -1.
  Index size = -1;
};

/// Writes the parts, in their order, behind what rank 0 has written so far; the file is then on rank 0 behind the last
/// one. All ranks write at once: sizes that are not known are counted first, by writing into nothing. Collective; all
/// ranks give the same parts.
/// @throws Error, Aborted
void writeParts(AtomicFile& file, const std::vector<FilePart>& parts, const Execution& run);

/// Files that appear together: all are written under temporary names, and get their own when all are complete.
class FileGroup
{
public:
  explicit FileGroup(const Execution& run)
    : Run(run)
  {
  }

  /// A new file, on all ranks. Collective. @throws Error
  AtomicFile& add(const std::string& path);
  /// Completes the files and gives them their names, in the order in which they were added. Collective.
  /// @throws Error
  void publish();

private:
  const Execution& Run;
  std::vector<std::unique_ptr<AtomicFile>> Files;
};

} // namespace bsv
