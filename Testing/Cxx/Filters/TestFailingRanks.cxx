// SPDX-License-Identifier: BSD-3-Clause
// However a rank fails, wherever that is, all ranks end with one and the same message: nobody waits for ever, and the
// ranks can go on together. Several ranks in one process, each a thread.
#include "Support/Algorithms.h"
#include "Support/MeshFiles.h"
#include "Support/ThreadRanks.h"

#include "Execution/ControllerRanks.h"

#include <vtkDataSetAttributes.h>
#include <vtkDemandDrivenPipeline.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPartitionedDataSetCollection.h>
#include <vtkSMPTools.h>

#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

using algorithms::Inputs;

namespace
{

const std::string Text = "this rank fails here";

/// Every so many places are tried, 1: all. Not set: one of each rank.
const char* allCollectives()
{
  return std::getenv("BSV_ALL_COLLECTIVES");
}

/// How a rank fails.
enum class Kind
{
  Error,
  Memory,
  Abort,
  Other
};

void fail(Kind kind)
{
  switch (kind)
  {
    case Kind::Error:
      throw bsv::Error(Text);
    case Kind::Memory:
      throw std::bad_alloc();
    case Kind::Abort:
      throw bsv::Aborted();
    default:
      throw std::runtime_error(Text);
  }
}

/// A rank that fails at a place: where it begins to communicate, where it gets room for what comes from others, and
/// where the work of a scope begins and ends.
class FailingRank : public bsvtest::ThreadRank
{
public:
  using ThreadRank::ThreadRank;

  /// The number of the place from 0, or -1: nowhere.
  mutable int failsAt = -1;
  mutable Kind kind = Kind::Error;
  /// Of the last outermost scope.
  mutable int places = 0;
  mutable std::string verdict;

protected:
  void gatherBytes(const Span& mine, std::size_t unit, const Room& room) const override
  {
    this->place();
    ThreadRank::gatherBytes(mine, unit, this->counted(room));
  }
  void exchangeBytes(const std::vector<Span>& toRank, std::size_t unit, const Room& room) const override
  {
    this->place();
    ThreadRank::exchangeBytes(toRank, unit, this->counted(room));
  }
  void runTogether(const std::function<void()>& body, const std::function<std::string()>& parameters) const override
  {
    const bool outermost = this->Depth == 0;
    if (outermost)
    {
      this->places = 0;
      this->verdict.clear();
    }
    else
    {
      this->place();
    }
    ++this->Depth;
    try
    {
      ThreadRank::runTogether(
        [&] {
          this->place();
          body();
          // What an algorithm does last cannot fail any more.
          if (!outermost)
          {
            this->place();
          }
        },
        parameters);
    }
    catch (const std::exception& error)
    {
      --this->Depth;
      this->verdict = outermost ? error.what() : this->verdict;
      throw;
    }
    --this->Depth;
  }

private:
  void place() const
  {
    // Outside of all scopes a rank may not fail.
    if (this->Depth > 0 && this->places++ == this->failsAt)
    {
      fail(this->kind);
    }
  }
  Room counted(const Room& room) const
  {
    return [&, room](int rank, bsv::Index bytes) {
      this->place();
      return room(rank, bytes);
    };
  }

  mutable int Depth = 0;
};

/// How an algorithm ended on one rank.
struct End
{
  int places = 0;
  /// The exception that ended the scope.
  std::string verdict;
  std::vector<std::string> messages;
  vtkIdType outputs = 0;
};

/// Runs an algorithm on several ranks.
class Runs
{
public:
  explicit Runs(const std::vector<vtkSmartPointer<vtkAlgorithm>>& algorithms)
    : Algorithms(algorithms)
  {
  }
  int size() const { return static_cast<int>(this->Algorithms.size()); }

  /// @param thrower the rank that fails at a place, -1: none
  std::vector<End> operator()(int thrower = -1, int place = -1, Kind kind = Kind::Error) const
  {
    bsvtest::Exchange exchange(this->size());
    std::vector<End> ends(this->size());
    std::vector<std::thread> threads;
    threads.reserve(this->size());
    for (int r = 0; r < this->size(); ++r)
    {
      threads.emplace_back([&, r] {
        const auto rank = std::make_shared<FailingRank>(exchange, r);
        rank->failsAt = r == thrower ? place : -1;
        rank->kind = kind;
        const bsv::RanksOfThread scope(rank);
        vtkAlgorithm* algorithm = this->Algorithms[r];
        const algorithms::Told told = algorithms::run(algorithm, {}, r, this->size());
        ends[r] = { rank->places, rank->verdict, told.messages, algorithms::sizeOfOutputs(algorithm) };
        // Who waits for this rank from now on waits for ever.
        exchange.leave();
      });
    }
    for (std::thread& thread : threads)
    {
      thread.join();
    }
    return ends;
  }

private:
  std::vector<vtkSmartPointer<vtkAlgorithm>> Algorithms;
};

/// Expects the same end on all ranks: an error that only the first rank tells, an abort, or none of both.
void expectOneEnd(const std::vector<End>& ends, const std::string& place)
{
  for (const End& end : ends)
  {
    EXPECT_EQ(end.verdict, ends[0].verdict) << place;
    const bool first = &end == &ends[0];
    const bool tells = first && !end.verdict.empty() && end.verdict != bsv::Aborted().what();
    if (!end.verdict.empty() || !first)
    {
      EXPECT_EQ(end.messages.size(), tells ? 1u : 0u) << place << ": " << (end.messages.empty() ? "" : end.messages[0]);
    }
    if (tells && !end.messages.empty())
    {
      EXPECT_NE(end.messages[0].find(end.verdict), std::string::npos) << place << ": " << end.messages[0];
    }
    EXPECT_TRUE(end.verdict.empty() || end.outputs == 0) << place;
  }
}

class FailingRanks : public testing::Test
{
protected:
  static void SetUpTestSuite()
  {
    // Threads are ranks here.
    vtkSMPTools::SetBackend("Sequential");
    char name[] = "/tmp/bsv-FailingRanks-XXXXXX";
    Folder = std::string(::mkdtemp(name)) + "/";
    All = std::make_unique<Inputs>(Folder);
    for (const Inputs::Case& writer : All->writers())
    {
      algorithms::run(writer.make());
    }
  }
  static void TearDownTestSuite()
  {
    All.reset();
    std::filesystem::remove_all(Folder);
  }

  /// All algorithms with what each rank has of their inputs.
  static std::vector<std::vector<Inputs::Case>> casesOfRanks(int size)
  {
    std::vector<std::vector<Inputs::Case>> all(size);
    for (int r = 0; r < size; ++r)
    {
      const Inputs part = All->part(r, size);
      for (const auto& some : { part.filters(), part.writers(), part.readers() })
      {
        all[r].insert(all[r].end(), some.begin(), some.end());
      }
    }
    return all;
  }
  static Runs runs(const std::vector<std::vector<Inputs::Case>>& cases, std::size_t n)
  {
    std::vector<vtkSmartPointer<vtkAlgorithm>> algorithms;
    algorithms.reserve(cases.size());
    for (const std::vector<Inputs::Case>& ofRank : cases)
    {
      algorithms.push_back(ofRank[n].make());
    }
    return Runs(algorithms);
  }

  static std::string Folder;
  static std::unique_ptr<Inputs> All;
};
std::string FailingRanks::Folder;
std::unique_ptr<Inputs> FailingRanks::All;

TEST_F(FailingRanks, EndAllWithOneMessageWhereverTheyFail)
{
  const char* all = allCollectives();
  const char* only = std::getenv("BSV_COLLECTIVES_ONLY");
  constexpr std::array<Kind, 4> Kinds{ Kind::Error, Kind::Memory, Kind::Abort, Kind::Other };
  int tried = 0;
  for (const int size : { 2, 3 })
  {
    const auto cases = casesOfRanks(size);
    for (std::size_t n = 0; n < cases[0].size(); ++n)
    {
      const Inputs::Case& which = cases[0][n];
      if ((only && which.name.find(only) == std::string::npos) || (!all && static_cast<int>(n % 2) != size - 2))
      {
        continue;
      }
      const Runs run = runs(cases, n);
      const std::vector<End> whole = run();
      const std::string label = which.name + " on " + std::to_string(size) + " ranks";
      expectOneEnd(whole, label);
      ASSERT_EQ(whole[0].verdict, "") << label;
      int places = 0;
      for (int thrower = 0; thrower < size; ++thrower)
      {
        const int count = whole[thrower].places;
        places += count;
        const int step = all ? std::max(1, std::atoi(all)) : std::max(1, count);
        // Another one in every case.
        for (int at = all ? 0 : 7919 * tried % std::max(1, count); at < count; at += step)
        {
          const Kind kind = Kinds[tried % Kinds.size()];
          const std::string place = label + ", place " + std::to_string(at) + " of rank " + std::to_string(thrower) +
            ", kind " + std::to_string(static_cast<int>(kind));
          if (!which.file.empty())
          {
            meshfiles::writeFile(which.file, "old");
          }
          const std::vector<End> ends = run(thrower, at, kind);
          expectOneEnd(ends, place);
          const std::string expected = kind == Kind::Memory
            ? "rank " + std::to_string(thrower) + ": there is not enough memory"
            : kind == Kind::Abort ? bsv::Aborted().what()
                                  : Text;
          EXPECT_EQ(ends[0].verdict.rfind(expected, 0), 0u) << place << ": " << ends[0].verdict;
          if (!which.file.empty())
          {
            EXPECT_TRUE(meshfiles::readFile(which.file) == "old") << place;
          }
          ++tried;
          ASSERT_FALSE(HasFailure());
        }
      }
      // It is over then.
      const std::vector<End> again = run();
      for (int r = 0; r < size; ++r)
      {
        EXPECT_EQ(again[r].verdict, "") << label;
        EXPECT_EQ(again[r].outputs, whole[r].outputs) << label;
        EXPECT_EQ(again[r].places, whole[r].places) << label;
      }
      std::cout << label << ": " << places << " places\n";
    }
  }
  std::cout << tried << " places tried\n";
}

/// A property of the algorithm that has another value then.
void changeProperty(vtkAlgorithm* algorithm)
{
  const auto change = [&](auto* type, const auto& set) {
    if (auto* known = std::remove_pointer_t<decltype(type)>::SafeDownCast(algorithm))
    {
      set(known);
    }
  };
  change(static_cast<vtkWingFuselageSource*>(nullptr), [](auto* a) { a->SetSpan(a->GetSpan() + 1e-9); });
  change(static_cast<vtkHexBlockTopology*>(nullptr), [](auto* a) { a->SetCreaseAngle(31.0); });
  change(static_cast<vtkHexMeshToBlocks*>(nullptr), [](auto* a) { a->SetMergeBlocks(!a->GetMergeBlocks()); });
  change(static_cast<vtkMirrorHexBlocks*>(nullptr), [](auto* a) { a->AddSymmetryBoundary("other"); });
  change(static_cast<vtkWallSpacing*>(nullptr), [](auto* a) { a->SetTargetYPlus(1.5); });
  change(static_cast<vtkCatmullClarkToBSplineVolume*>(nullptr), [](auto* a) { a->AddBodyFace(0, 1); });
  change(static_cast<vtkBSplineVolumeSampler*>(nullptr), [](auto* a) { a->SetLevel(a->GetLevel() + 1); });
  change(static_cast<vtkBSplineVolumeQuality*>(nullptr), [](auto* a) { a->SetMaximumDepth(3); });
  change(static_cast<vtkBSplineVolumeSmoothness*>(nullptr), [](auto* a) { a->SetGapTolerance(0.25); });
  change(static_cast<vtkBSplineVolumeDifference*>(nullptr),
    [](auto* a) { a->SetSamplesPerSpan(a->GetSamplesPerSpan() + 1); });
  change(static_cast<vtkBSplineVolumeIsoparametric*>(nullptr), [](auto* a) { a->SetLevel(a->GetLevel() + 1); });
  change(static_cast<vtkBSplineVolumeProbe*>(nullptr), [](auto* a) { a->SetTolerance(0.5); });
  change(static_cast<vtkBSplineVolumeToBezier*>(nullptr), [](auto* a) { a->SetCells(a->GetCells() == 0 ? 1 : 0); });
  change(static_cast<vtkBodyDeviation*>(nullptr), [](auto* a) { a->SetLevel(a->GetLevel() + 1); });
  change(static_cast<vtkHexBlockMeshReader*>(nullptr), [](auto* a) { a->SetUseNeutralMap(!a->GetUseNeutralMap()); });
  change(static_cast<vtkBSplineVolumeReader*>(nullptr), [](auto* a) { a->SetFileName("other"); });
  change(static_cast<vtkNURBSSurfaceReader*>(nullptr), [](auto* a) { a->SetTessellationTolerance(0.125); });
  change(static_cast<vtkQuadflowReader*>(nullptr), [](auto* a) { a->SetFileName("other"); });
  change(static_cast<vtkHexBlockMeshWriter*>(nullptr), [](auto* a) { a->SetFileName(""); });
  change(
    static_cast<vtkBSplineVolumeWriter*>(nullptr), [](auto* a) { a->SetCellOrder(a->GetCellOrder() == 2 ? 3 : 2); });
  change(static_cast<vtkNURBSSurfaceWriter*>(nullptr), [](auto* a) { a->AddBodyBoundary("other"); });
  change(static_cast<vtkQuadflowWriter*>(nullptr), [](auto* a) { a->SetBoundaryId("other", 7); });
}

TEST_F(FailingRanks, DifferentPropertiesAreOneErrorWithBothValues)
{
  for (const int size : { 2, 3 })
  {
    const auto cases = casesOfRanks(size);
    for (std::size_t n = 0; n < cases[0].size(); ++n)
    {
      std::vector<vtkSmartPointer<vtkAlgorithm>> algorithms;
      auto changed = cases;
      const auto make = cases[size - 1][n].make;
      changed[size - 1][n].make = [&] {
        vtkSmartPointer<vtkAlgorithm> algorithm = make();
        changeProperty(algorithm);
        return algorithm;
      };
      const std::vector<End> ends = runs(changed, n)();
      const std::string label = cases[0][n].name + " on " + std::to_string(size) + " ranks";
      expectOneEnd(ends, label);
      EXPECT_EQ(ends[0].verdict.rfind("The parameters are not the same on all ranks: rank 0 has '", 0), 0u)
        << label << ": " << ends[0].verdict;
      EXPECT_NE(ends[0].verdict.find("', rank " + std::to_string(size - 1) + " has '"), std::string::npos)
        << label << ": " << ends[0].verdict;
      if (size == 2)
      {
        std::cout << label << ": " << ends[0].verdict << '\n';
      }
    }
  }
}

/// What may differ between the inputs of two ranks.
const std::vector<std::pair<std::string, std::function<void(Inputs&)>>>& differences()
{
  static const std::vector<std::pair<std::string, std::function<void(Inputs&)>>> all{
    { "nothing at all", [](Inputs& inputs) { inputs.change([](vtkDataObject* data) { data->Initialize(); }); } },
    { "no field data",
      [](Inputs& inputs) { inputs.change([](vtkDataObject* data) { data->GetFieldData()->Initialize(); }); } },
    { "fewer blocks",
      [](Inputs& inputs) {
        inputs.change([](vtkDataObject* data) {
          if (auto* tree = vtkPartitionedDataSetCollection::SafeDownCast(data))
          {
            tree->SetNumberOfPartitionedDataSets(tree->GetNumberOfPartitionedDataSets() - 3);
          }
        });
      } },
    { "more blocks",
      [](Inputs& inputs) {
        inputs.change([](vtkDataObject* data) {
          if (auto* tree = vtkPartitionedDataSetCollection::SafeDownCast(data))
          {
            tree->SetNumberOfPartitionedDataSets(tree->GetNumberOfPartitionedDataSets() + 2);
          }
        });
      } },
    { "other names",
      [](Inputs& inputs) {
        inputs.change([](vtkDataObject* data) {
          auto* tree = vtkPartitionedDataSetCollection::SafeDownCast(data);
          for (unsigned int b = 0; tree && b < tree->GetNumberOfPartitionedDataSets(); ++b)
          {
            tree->GetMetaData(b)->Set(vtkCompositeDataSet::NAME(), ("other " + std::to_string(b)).c_str());
          }
        });
      } },
    { "no arrays in the blocks",
      [](Inputs& inputs) {
        inputs.change([](vtkDataObject* data) {
          auto* tree = vtkPartitionedDataSetCollection::SafeDownCast(data);
          for (unsigned int b = 0; tree && b < tree->GetNumberOfPartitionedDataSets(); ++b)
          {
            if (vtkDataObject* block = tree->GetPartitionAsDataObject(b, 0))
            {
              block->GetFieldData()->Initialize();
              block->GetAttributes(vtkDataObject::POINT)->Initialize();
              block->GetAttributes(vtkDataObject::CELL)->Initialize();
            }
          }
        });
      } },
    { "the first point where the last one is",
      [](Inputs& inputs) {
        inputs.change([](vtkDataObject* data) {
          auto* tree = vtkPartitionedDataSetCollection::SafeDownCast(data);
          for (unsigned int b = 0; tree && b < tree->GetNumberOfPartitionedDataSets(); ++b)
          {
            if (auto* block = vtkPointSet::SafeDownCast(tree->GetPartitionAsDataObject(b, 0)))
            {
              double x[3];
              block->GetPoint(block->GetNumberOfPoints() - 1, x);
              block->GetPoints()->SetPoint(0, x);
            }
          }
        });
      } },
  };
  return all;
}

TEST_F(FailingRanks, InputsThatOneRankDoesNotHaveAreOneError)
{
  const auto cases = casesOfRanks(2);
  int ports = 0;
  for (std::size_t n = 0; n < cases[0].size(); ++n)
  {
    for (int port = 0; port < cases[0][n].make()->GetNumberOfInputPorts(); ++port)
    {
      std::vector<vtkSmartPointer<vtkAlgorithm>> algorithms{ cases[0][n].make(), cases[1][n].make() };
      if (algorithms[0]->GetNumberOfInputConnections(port) == 0)
      {
        continue;
      }
      algorithms[1]->RemoveAllInputConnections(port);
      const std::string place = cases[0][n].name + ", input " + std::to_string(port);
      const std::vector<End> ends = Runs(algorithms)();
      expectOneEnd(ends, place);
      // A body is data that all ranks have, or one.
      const bool optional = port == 1 && place.rfind("BSplineVolume", 0) != 0;
      EXPECT_TRUE(optional || !ends[0].verdict.empty()) << place;
      ++ports;
    }
  }
  EXPECT_GT(ports, 10);
}

/// A filter of another program that fails on one rank only.
class FailingSource : public vtkAlgorithm
{
public:
  static FailingSource* New();
  vtkTypeMacro(FailingSource, vtkAlgorithm);

protected:
  FailingSource()
  {
    this->SetNumberOfInputPorts(0);
    this->SetNumberOfOutputPorts(1);
  }
  int FillOutputPortInformation(int, vtkInformation* info) override
  {
    info->Set(vtkDataObject::DATA_TYPE_NAME(), "vtkPartitionedDataSetCollection");
    return 1;
  }
  vtkTypeBool ProcessRequest(vtkInformation* request, vtkInformationVector**, vtkInformationVector* outputs) override
  {
    if (request->Has(vtkDemandDrivenPipeline::REQUEST_DATA_OBJECT()))
    {
      vtkNew<vtkPartitionedDataSetCollection> data;
      outputs->GetInformationObject(0)->Set(vtkDataObject::DATA_OBJECT(), data);
    }
    return request->Has(vtkDemandDrivenPipeline::REQUEST_DATA()) ? 0 : 1;
  }
};
vtkStandardNewMacro(FailingSource);

TEST_F(FailingRanks, WritersWhoseInputFailsOnOneRankEndOnAll)
{
  const auto cases = casesOfRanks(2);
  int writers = 0;
  for (std::size_t n = 0; n < cases[0].size(); ++n)
  {
    std::vector<vtkSmartPointer<vtkAlgorithm>> algorithms{ cases[0][n].make(), cases[1][n].make() };
    if (!vtkWriter::SafeDownCast(algorithms[0]))
    {
      continue;
    }
    vtkNew<FailingSource> source;
    algorithms[writers % 2]->SetInputConnection(source->GetOutputPort());
    meshfiles::writeFile(cases[0][n].file, "old");
    const std::vector<End> ends = Runs(algorithms)();
    expectOneEnd(ends, cases[0][n].name);
    EXPECT_NE(ends[0].verdict.find("rank " + std::to_string(writers % 2) + ": the input"), std::string::npos)
      << ends[0].verdict;
    EXPECT_EQ(meshfiles::readFile(cases[0][n].file), "old");
    ++writers;
  }
  EXPECT_GT(writers, 5);
}

TEST_F(FailingRanks, DifferentInputsEndAlikeOnAllRanks)
{
  const bool all = allCollectives() != nullptr;
  int tried = 0;
  int refused = 0;
  for (int size = 2; size <= (all ? 3 : 2); ++size)
  {
    for (std::size_t d = 0; d < differences().size(); ++d)
    {
      const auto& [what, change] = differences()[d];
      for (int other = all ? 0 : static_cast<int>(d % 2); other < (all ? size : static_cast<int>(d % 2) + 1); ++other)
      {
        auto cases = casesOfRanks(size);
        Inputs part = All->part(other, size);
        change(part);
        cases[other] = part.filters();
        for (const Inputs::Case& writer : part.writers())
        {
          cases[other].push_back(writer);
        }
        for (std::size_t n = all ? 0 : d % 3; n < cases[other].size(); n += all ? 1 : 3)
        {
          const std::vector<End> ends = runs(cases, n)();
          expectOneEnd(ends,
            cases[0][n].name + ", rank " + std::to_string(other) + " of " + std::to_string(size) + " with " + what);
          ++tried;
          refused += ends[0].verdict.empty() ? 0 : 1;
        }
        ASSERT_FALSE(HasFailure());
      }
    }
  }
  std::cout << tried << " runs, " << refused << " refused\n";
}

} // namespace
