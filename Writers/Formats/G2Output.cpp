// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/VolumeFormats.h"

#include "IO/TextOutput.h"

namespace bsv
{

namespace
{

void writeVolume(OutputBuffer& file, const BSplineVolume& volume, const PartReport& report)
{
  TextOutput out(file);
  out << "700 1 0 0\n3 " << (volume.weights ? 1 : 0) << "\n";
  for (int d = 0; d < 3; ++d)
  {
    out << volume.count(d) << " " << volume.degree[d] + 1 << "\n";
    for (std::size_t i = 0; i < volume.knots[d].size(); ++i)
    {
      out << (i > 0 ? " " : "") << volume.knots[d][i];
    }
    out << "\n";
  }
  const Index size = Index(volume.count(0)) * volume.count(1) * volume.count(2);
  for (Index i = 0; i < size; ++i)
  {
    if (i % 65536 == 0)
    {
      report(static_cast<double>(i));
    }
    if (!volume.weights)
    {
      out.point(volume.points + 3 * i);
      continue;
    }
    for (int c = 0; c < 3; ++c)
    {
      out << volume.points[3 * i + c] * volume.weights[i] << " ";
    }
    out << volume.weights[i] << "\n";
  }
  out << "\n";
}

} // namespace

void writeG2Volumes(const VolumeToWrite& volume, AtomicFile& file, const Execution& run)
{
  std::vector<FilePart> parts;
  for (const BSplineVolume& block : volume.volumes)
  {
    parts.push_back({ block.rank, double(block.count(0)) * block.count(1) * block.count(2),
      [&block](OutputBuffer& out, const PartReport& report) { writeVolume(out, block, report); } });
  }
  writeParts(file, parts, run);
}

} // namespace bsv
