// SPDX-License-Identifier: BSD-3-Clause
// What holds for every filter, reader and writer, whatever it does.
#include "Support/Algorithms.h"
#include "Support/MeshFiles.h"

#include <vtkErrorCode.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <stdexcept>

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

/// The first, the last, and some between.
std::vector<int> someOf(std::size_t steps)
{
  std::vector<int> some;
  const int count = static_cast<int>(std::min<std::size_t>(steps, 6));
  for (int i = 0; i < count; ++i)
  {
    some.push_back(1 + i * (static_cast<int>(steps) - 1) / std::max(1, count - 1));
  }
  return some;
}

TEST_F(EveryAlgorithm, ProgressNeverRunsBack)
{
  for (const Inputs::Case& which : filtersAndReaders())
  {
    const vtkSmartPointer<vtkAlgorithm> algorithm = which.make();
    const Told told = algorithms::run(algorithm);
    EXPECT_EQ(told.messages, std::vector<std::string>()) << which.name;
    EXPECT_GT(algorithms::sizeOfOutputs(algorithm), 0) << which.name;
    EXPECT_TRUE(std::is_sorted(told.progress.begin(), told.progress.end())) << which.name;
    EXPECT_EQ(told.progress.front(), 0.0) << which.name;
    EXPECT_EQ(told.progress.back(), 1.0) << which.name;
  }
}

TEST_F(EveryAlgorithm, AbortLeavesAllOutputsEmpty)
{
  for (const Inputs::Case& which : filtersAndReaders())
  {
    const vtkSmartPointer<vtkAlgorithm> algorithm = which.make();
    const std::size_t steps = algorithms::run(algorithm).progress.size();
    // The last report is the pipeline's own: all is done.
    for (const int when : someOf(steps - 1))
    {
      bool aborted = false;
      const Told told = algorithms::run(algorithm, [&](int step, vtkAlgorithm* caller) {
        aborted = aborted || (step == when && caller->GetProgress() < 1.0);
        caller->SetAbortExecute(aborted);
      });
      if (aborted)
      {
        EXPECT_EQ(told.messages, std::vector<std::string>()) << which.name << ", step " << when;
        EXPECT_EQ(algorithms::sizeOfOutputs(algorithm), 0) << which.name << ", step " << when;
      }
    }
  }
}

TEST_F(EveryAlgorithm, ErrorIsOneMessageAndLeavesAllOutputsEmpty)
{
  for (const Inputs::Case& which : filtersAndReaders())
  {
    const vtkSmartPointer<vtkAlgorithm> algorithm = which.make();
    const std::size_t steps = algorithms::run(algorithm).progress.size();
    // The first and the last report are the pipeline's own.
    for (const int when : someOf(steps - 2))
    {
      bool thrown = false;
      const Told told = algorithms::run(algorithm, [&](int step, vtkAlgorithm* caller) {
        if (step == when + 1 && caller->GetProgress() < 1.0)
        {
          thrown = true;
          throw std::runtime_error("something is wrong");
        }
      });
      if (thrown)
      {
        ASSERT_EQ(told.messages.size(), 1u) << which.name << ", step " << when;
        EXPECT_NE(told.messages[0].find("something is wrong"), std::string::npos) << told.messages[0];
        EXPECT_EQ(algorithms::sizeOfOutputs(algorithm), 0) << which.name << ", step " << when;
      }
    }
    // It is over then.
    EXPECT_EQ(algorithms::run(algorithm).messages, std::vector<std::string>()) << which.name;
    EXPECT_GT(algorithms::sizeOfOutputs(algorithm), 0) << which.name;
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

TEST_F(EveryAlgorithm, WritersThatFailOrAreStoppedLeaveTheOldFile)
{
  for (const Inputs::Case& which : All->writers())
  {
    const vtkSmartPointer<vtkAlgorithm> writer = which.make();
    const Told whole = algorithms::run(writer);
    EXPECT_TRUE(std::is_sorted(whole.progress.begin(), whole.progress.end())) << which.name;
    const std::string before = meshfiles::readFile(which.file);
    EXPECT_FALSE(before.empty()) << which.name;
    for (const int when : someOf(whole.progress.size() - 2))
    {
      for (const bool abort : { true, false })
      {
        bool done = false;
        const Told told = algorithms::run(writer, [&](int step, vtkAlgorithm* caller) {
          done = done || (step == when + 1 && caller->GetProgress() < 1.0);
          caller->SetAbortExecute(abort && done);
          if (done && !abort && step == when + 1)
          {
            throw std::runtime_error("something is wrong");
          }
        });
        EXPECT_EQ(told.messages.size(), done && !abort ? 1u : 0u) << which.name << ", step " << when;
        // Another file with the same name would do as well; that none is half written is what counts.
        EXPECT_EQ(meshfiles::readFile(which.file).size(), before.size()) << which.name << ", step " << when;
      }
    }
  }
  for (const auto& entry : std::filesystem::directory_iterator(Folder))
  {
    EXPECT_NE(entry.path().extension(), ".tmp") << entry.path();
  }
}

} // namespace
