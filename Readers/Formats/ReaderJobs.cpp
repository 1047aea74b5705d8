// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/ReaderJobs.h"

#include "Base/UTF8.h"
#include "Execution/Archive.h"
#include "Execution/ChildProcess.h"

#include "ReaderProgram.h"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <new>
#include <utility>

namespace bsv
{

namespace
{

constexpr const char* ProgramName = "BSplineVolumeReadFile";

double sizeOf(const std::string& fileName)
{
  std::error_code failure;
  const auto size = std::filesystem::file_size(fileName, failure);
  return failure ? 0.0 : double(size);
}

std::string missingProgram()
{
  return std::string("the program ") + ProgramName +
    " cannot be started beside the plugin's libraries; the file was read in this process, which a damaged file can end";
}

std::optional<ChildResult> runReader(
  const std::vector<std::string>& arguments, const std::string& fileName, double seconds, const Execution& run)
{
  const std::string program = programBeside(ProgramName);
  if (program.empty())
  {
    return std::nullopt;
  }
  ChildLimits limits;
  limits.processorSeconds = seconds;
  return runChild(program, arguments, fileName, limits, run);
}

// One function per type walks over its parts, in either direction.

template <typename Archive, typename Contact>
void exchangeContact(Archive& archive, Contact& declared)
{
  archive(declared.contact);
  archive(declared.where);
}

template <typename Archive, typename Curve>
void exchangeCurve(Archive& archive, Curve& curve)
{
  archive(curve.degree);
  archive(curve.knots);
  archive(curve.points);
  archive(curve.weights);
}

/// A list whose items need a function of their own.
template <typename Archive, typename List, typename Item>
void exchangeList(Archive& archive, List& list, const Item& item)
{
  if constexpr (Archive::IsReading)
  {
    list.resize(archive.count(8));
  }
  else
  {
    archive(static_cast<std::uint64_t>(list.size()));
  }
  for (auto& entry : list)
  {
    item(entry);
  }
}

/// All but the points. @param offsets where the points of each block are in the file, -1 for those of other pieces
template <typename Archive, typename Zones, typename Offsets>
void exchangeZones(Archive& archive, Zones& zones, Offsets& offsets)
{
  exchangeList(archive, zones.blocks, [&](auto& block) {
    archive(block.name);
    archive(block.counts);
    archive(block.piece);
  });
  archive(offsets);
  exchangeList(archive, zones.hexZones, [&](auto& zone) {
    archive(zone.name);
    archive(zone.points);
    archive(zone.hexahedra);
    exchangeList(archive, zone.boundaries, [&](auto& boundary) {
      archive(boundary.name);
      archive(boundary.type);
      archive(boundary.quadrilaterals);
    });
  });
  archive(zones.interfaces);
  archive(zones.boundaries);
  archive(zones.boundaryNames);
  archive(zones.boundaryTypes);
  archive(zones.warnings);
  exchangeList(archive, zones.contacts, [&](auto& contact) { exchangeContact(archive, contact); });
}

template <typename Archive, typename Content>
void exchangeContent(Archive& archive, Content& content)
{
  archive(content.format);
  archive(content.unit);
  exchangeList(archive, content.patches, [&](auto& patch) {
    archive(patch.name);
    archive(patch.reversed);
    archive(patch.surface.degree);
    archive(patch.surface.knots[0]);
    archive(patch.surface.knots[1]);
    archive(patch.surface.points);
    archive(patch.surface.weights);
    exchangeList(archive, patch.loops,
      [&](auto& loop) { exchangeList(archive, loop, [&](auto& curve) { exchangeCurve(archive, curve); }); });
  });
  archive(content.layers);
  archive(content.tessellation.vertices);
  archive(content.tessellation.triangles);
  exchangeList(archive, content.others, [&](auto& other) {
    archive(other.first);
    archive(other.second);
  });
  archive(content.approximated);
  archive(content.warnings);
}

/// Where the points of a block are in the file, and how they are stored.
struct PointPlace
{
  Index offset = -1;
  bool isFloat = false;
};

Index pointBytes(const GridBlock& block, bool isFloat)
{
  return 3 * block.size() * (isFloat ? 4 : 8);
}

void cgnsJob(
  const std::string& fileName, const Piece& piece, int step, const Execution& run, const ChildChannel& channel)
{
  // The descriptor stays open to the end of the process.
  static const SharedFile file(ChildChannel::File);
  std::map<const void*, Index> offsets;
  BlockMemory memory;
  memory.allocate = [&](std::size_t bytes) {
    Index offset = 0;
    void* room = file.append(static_cast<Index>(bytes), offset);
    offsets[room] = offset;
    return room;
  };
  memory.release = SharedFile::release;
  const CGNSZones zones = loadCGNS(fileName, run, piece, memory, step);
  std::vector<PointPlace> places;
  for (const GridBlock& block : zones.blocks)
  {
    PointPlace place;
    place.isFloat = block.floats != nullptr;
    if (block.isHere())
    {
      place.offset = offsets.at(place.isFloat ? static_cast<const void*>(block.floats.get()) : block.doubles.get());
    }
    places.push_back(place);
  }
  ArchiveWriter archive;
  exchangeZones(archive, zones, places);
  channel.done(archive.take());
}

void timesJob(const std::string& fileName, const ChildChannel& channel)
{
  ArchiveWriter archive;
  archive(loadCGNSTimes(fileName));
  channel.done(archive.take());
}

void cadJob(const std::string& fileName, const std::string& format, double tolerance, const Execution& run,
  const ChildChannel& channel)
{
  const NURBSFileContent content = readCADFile(fileName, format, tolerance, run);
  ArchiveWriter archive;
  exchangeContent(archive, content);
  channel.done(archive.take());
}

} // namespace

CGNSZones loadCGNSApart(const std::string& fileName, const Execution& run, const Piece& piece, int step)
{
  // Reading takes no longer than unpacking 2 MB a second.
  const auto result =
    runReader({ "CGNS", fileName, std::to_string(piece.number), std::to_string(piece.count), std::to_string(step) },
      fileName, 20.0 + sizeOf(fileName) / 2e6, run);
  if (!result)
  {
    CGNSZones zones = loadCGNS(fileName, run, piece, {}, step);
    zones.warnings.push_back(missingProgram());
    return zones;
  }
  CGNSZones zones;
  std::vector<PointPlace> places;
  ArchiveReader archive(result->message);
  exchangeZones(archive, zones, places);
  for (std::size_t b = 0; b < zones.blocks.size() && b < places.size(); ++b)
  {
    GridBlock& block = zones.blocks[b];
    const PointPlace& place = places[b];
    if (place.offset < 0)
    {
      continue;
    }
    void* points = result->file.section(place.offset, pointBytes(block, place.isFloat));
    if (place.isFloat)
    {
      block.floats = BlockArray<float>(static_cast<float*>(points), { SharedFile::release });
    }
    else
    {
      block.doubles = BlockArray<double>(static_cast<double*>(points), { SharedFile::release });
    }
  }
  return zones;
}

std::vector<double> loadCGNSTimesApart(const std::string& fileName)
{
  const auto result = runReader({ "CGNSTimes", fileName, "" }, fileName, 20.0 + sizeOf(fileName) / 2e6, {});
  if (!result)
  {
    return loadCGNSTimes(fileName);
  }
  std::vector<double> times;
  ArchiveReader archive(result->message);
  archive(times);
  return times;
}

NURBSFileContent readCADFileApart(
  const std::string& fileName, const std::string& format, double tolerance, const Execution& run)
{
  char number[40];
  std::snprintf(number, sizeof(number), "%a", tolerance);
  // Faces that OpenCASCADE mends and cuts into triangles take up to a minute a megabyte.
  const auto result = canReadCADFiles()
    ? runReader({ format, fileName, number }, fileName, 60.0 + sizeOf(fileName) / 1e6 * 60.0, run)
    : std::nullopt;
  if (!result)
  {
    NURBSFileContent content = readCADFile(fileName, format, tolerance, run);
    content.warnings.push_back(missingProgram());
    return content;
  }
  NURBSFileContent content;
  ArchiveReader archive(result->message);
  exchangeContent(archive, content);
  return content;
}

int readerProgram(int argumentCount, char** arguments)
{
  const ChildChannel channel;
  if (argumentCount < 4)
  {
    return 2;
  }
  channel.begin();
  Execution run;
  run.progress = [&](double fraction) {
    channel.progress(fraction);
    return true;
  };
  const std::string job = arguments[1];
  const std::string fileName = arguments[2];
  try
  {
    if (job == "CGNS")
    {
      const Piece piece{ std::atoi(arguments[3]), argumentCount > 4 ? std::atoi(arguments[4]) : 1 };
      cgnsJob(fileName, piece, argumentCount > 5 ? std::atoi(arguments[5]) : 0, run, channel);
    }
    else if (job == "CGNSTimes")
    {
      timesJob(fileName, channel);
    }
    else
    {
      cadJob(fileName, job, std::strtod(arguments[3], nullptr), run, channel);
    }
  }
  catch (const std::bad_alloc&)
  {
    channel.failed(fileName + ": there is not enough memory to read it; the file is damaged or too large");
  }
  catch (const std::exception& error)
  {
    channel.failed(validUTF8(error.what()));
  }
  return 0;
}

} // namespace bsv
