// SPDX-License-Identifier: BSD-3-Clause
// What holds for every filter, reader and writer, whatever it does.
#include "Support/Algorithms.h"
#include "Support/MeshFiles.h"

#include "Base/MemoryCheck.h"
#include "Execution/ReportPace.h"

#include <vtkErrorCode.h>
#include <vtkFieldData.h>
#include <vtkIntArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPartitionedDataSetCollection.h>
#include <vtkPoints.h>
#include <vtkSMPTools.h>
#include <vtkStructuredGrid.h>
#include <vtk_hdf5.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <sys/resource.h>

using algorithms::Inputs;
using algorithms::Told;

namespace
{

/// The inputs, with all files written.
class EveryAlgorithm : public testing::Test
{
protected:
  static void SetUpTestSuite()
  {
    char name[] = "/tmp/bsv-EveryAlgorithm-XXXXXX";
    Folder = std::string(::mkdtemp(name)) + "/";
    All = std::make_unique<Inputs>(Folder);
    for (const Inputs::Case& writer : All->writers())
    {
      EXPECT_EQ(algorithms::run(writer.make()).messages, std::vector<std::string>()) << writer.name;
    }
  }
  static void TearDownTestSuite()
  {
    All.reset();
    std::filesystem::remove_all(Folder);
  }

  static std::vector<Inputs::Case> filtersAndReaders()
  {
    std::vector<Inputs::Case> cases = All->filters();
    for (const Inputs::Case& reader : All->readers())
    {
      cases.push_back(reader);
    }
    return cases;
  }

  static std::string Folder;
  static std::unique_ptr<Inputs> All;
};
std::string EveryAlgorithm::Folder;
std::unique_ptr<Inputs> EveryAlgorithm::All;

/// Some of the reports of a run: an early one and the last one before the pipeline's own.
std::set<int> someOf(std::size_t reports)
{
  return { 2, std::max(2, static_cast<int>(reports) - 1) };
}

/// What tells of something else than success.
std::vector<std::string> errors(const Told& told)
{
  std::vector<std::string> result;
  for (const std::string& message : told.messages)
  {
    if (message.rfind("ERROR", 0) == 0)
    {
      result.push_back(message);
    }
  }
  return result;
}

TEST_F(EveryAlgorithm, ErrorsAndAbortsLeaveAllOutputsEmpty)
{
  for (const Inputs::Case& which : filtersAndReaders())
  {
    const vtkSmartPointer<vtkAlgorithm> algorithm = which.make();
    const Told whole = algorithms::run(algorithm);
    EXPECT_EQ(errors(whole), std::vector<std::string>()) << which.name;
    EXPECT_GT(algorithms::sizeOfOutputs(algorithm), 0) << which.name;
    EXPECT_TRUE(std::is_sorted(whole.progress.begin(), whole.progress.end())) << which.name;
    EXPECT_EQ(whole.progress.front(), 0.0) << which.name;
    EXPECT_EQ(whole.progress.back(), 1.0) << which.name;
    for (const int when : someOf(whole.progress.size()))
    {
      const std::string place = which.name + ", report " + std::to_string(when);
      bool reached = false;
      const Told stopped = algorithms::run(algorithm, [&](int step, vtkAlgorithm* caller) {
        // The pipeline's own report, of a filter that is done, comes too late.
        reached = reached || (step == when && caller->GetProgress() < 1.0);
        caller->SetAbortExecute(reached);
      });
      EXPECT_EQ(stopped.messages, std::vector<std::string>()) << place;
      EXPECT_TRUE(!reached || algorithms::sizeOfOutputs(algorithm) == 0) << place;

      reached = false;
      const Told failed = algorithms::run(algorithm, [&](int step, vtkAlgorithm* caller) {
        if (step == when && caller->GetProgress() < 1.0)
        {
          reached = true;
          throw std::runtime_error("something is wrong");
        }
      });
      if (reached)
      {
        ASSERT_EQ(failed.messages.size(), 1u) << place;
        EXPECT_NE(failed.messages[0].find("something is wrong"), std::string::npos) << failed.messages[0];
        EXPECT_EQ(algorithms::sizeOfOutputs(algorithm), 0) << place;
      }
    }
  }
}

TEST_F(EveryAlgorithm, PointsThatAreNotFiniteAreRefusedWithTheirPlace)
{
  // Blocks, control points, patches and the triangles of the body, which is its last block.
  int refused = 0;
  for (int n = 0; n < 3 * 2 * Inputs::Count; ++n)
  {
    const int input = n / 6;
    const bool first = n / 3 % 2 == 0;
    const double value = std::array<double, 3>{ std::nan(""), HUGE_VAL, -HUGE_VAL }[n % 3];
    const Inputs broken = All->withCoordinate(input, first, value);
    std::vector<Inputs::Case> cases = broken.filters();
    for (const Inputs::Case& writer : broken.writers())
    {
      cases.push_back(writer);
    }
    for (const Inputs::Case& which : cases)
    {
      if (std::find(which.inputs.begin(), which.inputs.end(), broken.input(input)) == which.inputs.end())
      {
        continue;
      }
      const std::string place = which.name + ", input " + std::to_string(input) +
        (first ? ", first block, " : ", last block, ") + std::to_string(value);
      const vtkSmartPointer<vtkAlgorithm> algorithm = which.make();
      const std::vector<std::string> messages = algorithms::run(algorithm).messages;
      EXPECT_EQ(messages.size(), 1u) << place;
      const std::string message = messages.empty() ? "" : messages[0];
      EXPECT_NE(message.find("not finite"), std::string::npos) << place << ": " << message;
      EXPECT_NE(message.find("point "), std::string::npos) << place << ": " << message;
      EXPECT_EQ(algorithms::sizeOfOutputs(algorithm), 0) << place;
      refused += messages.size() == 1 ? 1 : 0;
    }
  }
  std::cout << refused << " refusals\n";
}

TEST_F(EveryAlgorithm, WhatDoesNotFitIsRefusedBeforeItIsAllocated)
{
  std::vector<Inputs::Case> cases = filtersAndReaders();
  for (const Inputs::Case& writer : All->writers())
  {
    cases.push_back(writer);
  }
  for (const Inputs::Case& which : cases)
  {
    // Another process, which has other memory, reads and asks.
    if (which.name == "reader of mesh.cgns")
    {
      continue;
    }
    const vtkSmartPointer<vtkAlgorithm> algorithm = which.make();
    // Less than any output here.
    bsv::pretendedFreeMemory() = 1000.0;
    const std::vector<std::string> messages = errors(algorithms::run(algorithm));
    bsv::pretendedFreeMemory() = HUGE_VAL;
    EXPECT_EQ(messages.size(), 1u) << which.name;
    if (messages.size() != 1)
    {
      continue;
    }
    EXPECT_NE(messages[0].find(" needs "), std::string::npos) << which.name << ": " << messages[0];
    EXPECT_NE(messages[0].find(" GB are free"), std::string::npos) << which.name << ": " << messages[0];
    EXPECT_EQ(algorithms::sizeOfOutputs(algorithm), 0) << which.name;
  }
}

// A block that stays whole is made of its pieces: room for those alone is not enough.
TEST_F(EveryAlgorithm, BlocksThatDoNotFitAsAWholeAreRefused)
{
  constexpr int Cells[3] = { 12, 12, 4 };
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (int k = 0; k <= Cells[2]; ++k)
  {
    for (int j = 0; j <= Cells[1]; ++j)
    {
      for (int i = 0; i <= Cells[0]; ++i)
      {
        points->InsertNextPoint(i, j, k - 0.5 * std::abs(j - Cells[1] / 2)); // a ridge
      }
    }
  }
  vtkNew<vtkStructuredGrid> block;
  block->SetDimensions(Cells[0] + 1, Cells[1] + 1, Cells[2] + 1);
  block->SetPoints(points);
  vtkNew<vtkPartitionedDataSetCollection> mesh;
  mesh->SetPartition(0, 0, block);
  vtkNew<vtkIntArray> creases;
  creases->SetName("CreaseEdges");
  creases->SetNumberOfComponents(7);
  const int ridge[7] = { 0, 0, Cells[1] / 2, 0, Cells[0], Cells[1] / 2, 0 };
  creases->InsertNextTypedTuple(ridge);
  mesh->GetFieldData()->AddArray(creases);

  vtkNew<vtkCatmullClarkToBSplineVolume> filter;
  filter->SetInputDataObject(0, mesh);
  filter->SetCreasesInsideBlocks(vtkCatmullClarkToBSplineVolume::REPEATED_KNOTS);
  ASSERT_EQ(errors(algorithms::run(filter)), std::vector<std::string>());
  ASSERT_EQ(
    vtkPartitionedDataSetCollection::SafeDownCast(filter->GetOutputDataObject(0))->GetNumberOfPartitionedDataSets(),
    1u);
  // The pieces have as many spans, and the whole has more knots than a block without a crease.
  bsv::pretendedFreeMemory() = (Cells[0] + 3.0) * (Cells[1] + 3.0) * (Cells[2] + 3.0) * (3 * sizeof(double) + 1);
  const std::vector<std::string> messages = errors(algorithms::run(filter));
  bsv::pretendedFreeMemory() = HUGE_VAL;
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_NE(messages[0].find("block 0 as a whole"), std::string::npos) << messages[0];
  EXPECT_NE(messages[0].find(" GB are free"), std::string::npos) << messages[0];
  EXPECT_EQ(algorithms::sizeOfOutputs(filter), 0);
}

/// Counts ranges of loops in place of seconds, one thread doing all.
class WorkClock
{
public:
  explicit WorkClock(double interval)
    : Before(bsv::reportPace())
    , Backend(vtkSMPTools::GetBackend())
  {
    vtkSMPTools::SetBackend("Sequential");
    bsv::reportPace() = { interval, [this] { return this->Ranges; },
      [this](bsv::Index, bsv::Index) { ++this->Ranges; } };
    // The last report was at the time of another clock.
    bsv::reportedNow();
  }
  ~WorkClock()
  {
    bsv::reportPace() = this->Before;
    vtkSMPTools::SetBackend(this->Backend.c_str());
  }
  double ranges() const { return this->Ranges; }

private:
  bsv::ReportPace Before;
  std::string Backend;
  double Ranges = 0.0;
};

TEST_F(EveryAlgorithm, ReportsComeWithinLoopsAndAbortsEndThem)
{
  constexpr double Interval = 4.0;
  for (const Inputs::Case& which : filtersAndReaders())
  {
    const vtkSmartPointer<vtkAlgorithm> algorithm = which.make();
    const WorkClock work(Interval);
    double last = 0.0;
    double most = 0.0;
    const Told told = algorithms::run(algorithm, [&](int, vtkAlgorithm*) {
      most = std::max(most, work.ranges() - last);
      last = work.ranges();
    });
    const double all = work.ranges();
    // A part of a loop, no longer than Interval, begins when a report is not yet due.
    EXPECT_LT(most, 2.0 * Interval) << which.name << ", of " << all << " ranges";

    double stop = -1.0;
    algorithms::run(algorithm, [&](int, vtkAlgorithm* caller) {
      if (stop < 0.0 && work.ranges() > 1.5 * all)
      {
        stop = work.ranges();
        caller->SetAbortExecute(1);
      }
    });
    EXPECT_LE(stop < 0.0 ? 0.0 : work.ranges() - stop, 0.0) << which.name;
    std::cout << which.name << ": " << all << " ranges, at most " << most << " between two of " << told.progress.size()
              << " reports\n";
  }
}

TEST_F(EveryAlgorithm, TableOfTimes)
{
  const char* resolution = std::getenv("BSV_REPORTS_RESOLUTION");
  if (!resolution)
  {
    GTEST_SKIP() << "BSV_REPORTS_RESOLUTION is not set: resolution of the wing and fuselage, 36 for 6 million points";
  }
  const char* only = std::getenv("BSV_REPORTS_ONLY");
  const Inputs large(Folder, std::atoi(resolution));
  const auto now = [] { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; };
  std::vector<Inputs::Case> cases = large.filters();
  for (const auto& more : { large.writers(), large.readers() })
  {
    cases.insert(cases.end(), more.begin(), more.end());
  }
  std::printf("%-40s %8s %8s %8s %8s %8s\n", "CPU seconds", "all", "reports", "longest", "share", "to stop");
  for (const Inputs::Case& which : cases)
  {
    if (only && which.name.find(only) == std::string::npos)
    {
      continue;
    }
    const vtkSmartPointer<vtkAlgorithm> algorithm = which.make();
    const double start = now();
    double last = start;
    double longest = 0.0;
    double where = 0.0;
    const Told told = algorithms::run(algorithm, [&](int, vtkAlgorithm* caller) {
      if (now() - last > longest)
      {
        longest = now() - last;
        where = caller->GetProgress();
      }
      last = now();
    });
    const double all = now() - start;
    const double middle = now() + 0.5 * all;
    double stop = -1.0;
    algorithms::run(algorithm, [&](int, vtkAlgorithm* caller) {
      if (stop < 0.0 && now() > middle)
      {
        stop = now();
        caller->SetAbortExecute(1);
      }
    });
    std::printf("%-40s %8.2f %8zu %8.3f %7.1f%% %8.3f   (longest before %.3f)\n", which.name.c_str(), all,
      told.progress.size(), longest, 100.0 * longest / all, stop < 0.0 ? -1.0 : now() - stop, where);
    std::fflush(stdout);
  }
}

TEST_F(EveryAlgorithm, FilesHoldNoTimeOfDay)
{
  std::map<std::string, std::string> before;
  for (const Inputs::Case& which : All->writers())
  {
    algorithms::run(which.make());
    before[which.name] = meshfiles::readFile(which.file);
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  for (const Inputs::Case& which : All->writers())
  {
    algorithms::run(which.make());
    // The CGNS library stores the time in its objects.
    EXPECT_TRUE(which.file.find(".cgns") != std::string::npos || meshfiles::readFile(which.file) == before[which.name])
      << which.name;
  }
}

TEST_F(EveryAlgorithm, WritersWithoutRoomLeaveTheOldFile)
{
  std::signal(SIGXFSZ, SIG_IGN);
  struct rlimit unlimited;
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &unlimited), 0);
  for (const Inputs::Case& which : All->writers())
  {
    const vtkSmartPointer<vtkAlgorithm> algorithm = which.make();
    auto* writer = vtkWriter::SafeDownCast(algorithm);
    algorithms::run(writer);
    const rlim_t size = std::filesystem::file_size(which.file);
    for (const rlim_t limit : std::set<rlim_t>{ 0, size / 2, size > 0 ? size - 1 : 0 })
    {
      meshfiles::writeFile(which.file, "old");
      const struct rlimit little = { limit, unlimited.rlim_max };
      ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &little), 0);
      const Told told = algorithms::run(writer);
      ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &unlimited), 0);
      const std::string place = which.name + ", " + std::to_string(limit) + " of " + std::to_string(size) + " bytes";
      EXPECT_EQ(errors(told).size(), 1u) << place;
      EXPECT_EQ(writer->GetErrorCode(), static_cast<unsigned long>(vtkErrorCode::OutOfDiskSpaceError)) << place;
      EXPECT_EQ(meshfiles::readFile(which.file), "old") << place;
    }
    EXPECT_EQ(errors(algorithms::run(writer)), std::vector<std::string>()) << which.name;
    EXPECT_EQ(std::filesystem::file_size(which.file), size) << which.name;
  }
}

/// Sets variables of the environment that child processes get, and removes them again.
class Environment
{
public:
  explicit Environment(std::map<std::string, std::string> variables)
    : Variables(std::move(variables))
  {
    for (const auto& [name, value] : this->Variables)
    {
      ::setenv(name.c_str(), value.c_str(), 1);
    }
  }
  ~Environment()
  {
    for (const auto& [name, value] : this->Variables)
    {
      ::unsetenv(name.c_str());
    }
  }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

private:
  std::map<std::string, std::string> Variables;
};

// Third-party libraries, in their own process: a disk that gets full at any write, or a crash there.
TEST_F(EveryAlgorithm, LibrariesThatFailWhileTheyWriteLeaveTheOldFile)
{
  const char* all = std::getenv("BSV_ALL_WRITES");
  for (const Inputs::Case& which : All->writers())
  {
    const std::string extension = std::filesystem::path(which.file).extension();
    if (extension != ".cgns" && extension != ".h5" && extension != ".igs" && extension != ".stp")
    {
      continue;
    }
    const vtkSmartPointer<vtkAlgorithm> algorithm = which.make();
    auto* writer = vtkWriter::SafeDownCast(algorithm);
    for (const char* kind : { "BSV_FAILING_WRITE", "BSV_CRASHING_WRITE" })
    {
      const bool full = std::string(kind) == "BSV_FAILING_WRITE";
      int failures = 0;
      for (int n = 1;; n = all ? n + 1 : 4 * n)
      {
        meshfiles::writeFile(which.file, "old");
        Told told;
        {
          const Environment environment({ { "LD_PRELOAD", BSV_FAILING_WRITE }, { kind, std::to_string(n) } });
          told = algorithms::run(writer);
        }
        if (errors(told).empty())
        {
          // There are fewer writes.
          EXPECT_NE(meshfiles::readFile(which.file), "old") << which.name;
          break;
        }
        ++failures;
        const std::string place = which.name + ", " + kind + " " + std::to_string(n) + ": " + errors(told)[0];
        EXPECT_EQ(errors(told).size(), 1u) << place;
        EXPECT_NE(errors(told)[0].find(which.file), std::string::npos) << place;
        const bool aborts = errors(told)[0].find("abort; the disk is full or damaged") != std::string::npos;
#if H5_VERSION_GE(2, 0, 0)
        // Where this HDF5 cannot write it aborts, and the reason is lost.
        const bool reasonLost = aborts && (extension == ".cgns" || extension == ".h5");
#else
        const bool reasonLost = false;
#endif
        if (full && !reasonLost)
        {
          EXPECT_NE(errors(told)[0].find("No space left"), std::string::npos) << place;
          EXPECT_EQ(writer->GetErrorCode(), vtkErrorCode::OutOfDiskSpaceError) << place;
        }
        EXPECT_TRUE(full || aborts) << place;
        EXPECT_EQ(meshfiles::readFile(which.file), "old") << place;
      }
      std::cout << which.name << ", " << kind << ": " << failures << " failures\n";
      // OpenCASCADE writes no file itself.
      EXPECT_TRUE(failures > 1 || extension == ".igs" || extension == ".stp") << which.name;
    }
    EXPECT_EQ(errors(algorithms::run(writer)), std::vector<std::string>()) << which.name;
  }
  for (const auto& entry : std::filesystem::directory_iterator(Folder))
  {
    EXPECT_NE(entry.path().extension(), ".tmp") << entry.path();
  }
}

template <typename Reader>
void expectOneMessageWithoutFileName()
{
  vtkNew<Reader> reader;
  const Told told = algorithms::run(reader);
  ASSERT_EQ(told.messages.size(), 1u) << reader->GetClassName();
  EXPECT_NE(told.messages[0].find("File Name is empty"), std::string::npos) << told.messages[0];
  EXPECT_EQ(reader->GetErrorCode(), static_cast<unsigned long>(vtkErrorCode::NoFileNameError));
  EXPECT_EQ(algorithms::sizeOfOutputs(reader), 0) << reader->GetClassName();
}

TEST(Readers, WithoutAFileNameRaiseOneMessage)
{
  expectOneMessageWithoutFileName<vtkHexBlockMeshReader>();
  expectOneMessageWithoutFileName<vtkBSplineVolumeReader>();
  expectOneMessageWithoutFileName<vtkNURBSSurfaceReader>();
  expectOneMessageWithoutFileName<vtkQuadflowReader>();
}

TEST_F(EveryAlgorithm, OtherFilesOfTheSameLibraryAreNamed)
{
  vtkNew<vtkHexBlockMeshReader> reader;
  reader->SetFileName((Folder + "volume.h5").c_str());
  const Told told = algorithms::run(reader);
  ASSERT_EQ(told.messages.size(), 1u);
  EXPECT_NE(told.messages[0].find("volume.h5: the file cannot be read as CGNS"), std::string::npos) << told.messages[0];
}

TEST_F(EveryAlgorithm, InputsWithoutBlocksAreOneError)
{
  vtkNew<vtkPartitionedDataSetCollection> tree;
  vtkNew<vtkMultiBlockDataSet> blocks;
  vtkNew<vtkStructuredGrid> grid;
  for (const Inputs::Case& which : All->filters())
  {
    for (vtkDataObject* empty :
      { static_cast<vtkDataObject*>(tree), static_cast<vtkDataObject*>(blocks), static_cast<vtkDataObject*>(grid) })
    {
      const vtkSmartPointer<vtkAlgorithm> filter = which.make();
      if (filter->GetNumberOfInputPorts() == 0)
      {
        continue;
      }
      filter->SetInputDataObject(0, empty);
      const std::vector<std::string> messages = algorithms::run(filter).messages;
      ASSERT_EQ(messages.size(), 1u) << which.name << ", " << empty->GetClassName();
      EXPECT_TRUE(messages[0].find("has no hexahedra") != std::string::npos ||
        messages[0].find("has no B-spline volume") != std::string::npos)
        << which.name << ": " << messages[0];
      EXPECT_EQ(algorithms::sizeOfOutputs(filter), 0) << which.name;
    }
  }
}

TEST_F(EveryAlgorithm, WritersWriteNoFileOfNothing)
{
  vtkNew<vtkPartitionedDataSetCollection> nothing;
  for (const Inputs::Case& which : All->writers())
  {
    meshfiles::writeFile(which.file, "old");
    const vtkSmartPointer<vtkAlgorithm> writer = which.make();
    writer->SetInputDataObject(0, nothing);
    EXPECT_EQ(errors(algorithms::run(writer)).size(), 1u) << which.name;
    EXPECT_EQ(meshfiles::readFile(which.file), "old") << which.name;
    algorithms::run(which.make());
  }
}

TEST_F(EveryAlgorithm, WritersThatFailOrAreStoppedLeaveTheOldFile)
{
  for (const Inputs::Case& which : All->writers())
  {
    const vtkSmartPointer<vtkAlgorithm> writer = which.make();
    const Told whole = algorithms::run(writer);
    EXPECT_TRUE(std::is_sorted(whole.progress.begin(), whole.progress.end())) << which.name;
    // Any other content would be replaced by a writer that comes to its end.
    meshfiles::writeFile(which.file, "old");
    for (const int when : someOf(whole.progress.size()))
    {
      for (const bool abort : { true, false })
      {
        bool reached = false;
        const Told told = algorithms::run(writer, [&](int step, vtkAlgorithm* caller) {
          const bool here = step == when && caller->GetProgress() < 1.0;
          reached = reached || here;
          caller->SetAbortExecute(abort && reached);
          if (here && !abort)
          {
            throw std::runtime_error("something is wrong");
          }
        });
        EXPECT_EQ(errors(told).size(), reached && !abort ? 1u : 0u) << which.name << ", report " << when;
        EXPECT_EQ(meshfiles::readFile(which.file) == "old", reached) << which.name << ", report " << when;
        meshfiles::writeFile(which.file, "old");
      }
    }
    algorithms::run(writer);
  }
  for (const auto& entry : std::filesystem::directory_iterator(Folder))
  {
    EXPECT_NE(entry.path().extension(), ".tmp") << entry.path();
  }
}

} // namespace
