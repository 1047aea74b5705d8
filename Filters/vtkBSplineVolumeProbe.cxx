// SPDX-License-Identifier: BSD-3-Clause
#include "vtkBSplineVolumeProbe.h"

#include "Base/Numbers.h"
#include "Data/BSplineVolumeData.h"
#include "Data/FinitePoints.h"
#include "Execution/FilterExecution.h"
#include "Ranks/SharedBox.h"
#include "Volume/VolumeLocator.h"

#include "vtkDataSet.h"
#include "vtkDoubleArray.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkIntArray.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"
#include "vtkPolyData.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include <Eigen/LU>

#include <algorithm>

vtkStandardNewMacro(vtkBSplineVolumeProbe);

namespace
{

using bsv::Index;

/// Relative to the diagonal of the volumes: a smaller tolerance finds nothing.
constexpr double Rounding = 1e-14;

/// What the rank that has a block says of a point.
struct Answer
{
  int block;
  double distance;
  bsv::Triple uvw;
  std::array<bsv::Triple, 3> slopes;
};

Answer answerTo(const bsv::VolumeLocator& locator, const std::vector<bsv::BSplineVolume>& volumes,
  const bsv::Triple& point, double tolerance)
{
  const bsv::VolumePlace place = locator.locate(bsv::vec3(point), tolerance);
  Answer answer{ place.block, place.distance, bsv::triple(place.uvw), {} };
  for (int d = 0; place.block >= 0 && d < 3; ++d)
  {
    std::array<int, 3> order{};
    order[d] = 1;
    answer.slopes[d] = bsv::triple(bsv::evaluate(volumes[place.block], place.uvw, order));
  }
  return answer;
}

/// Of the volumes of all ranks; 0 without any.
double diagonal(const bsv::VolumeLocator& locator, const bsv::Ranks& ranks)
{
  const Eigen::AlignedBox3d box = bsv::sharedBox(locator.bounds(), ranks);
  return box.isEmpty() ? 0.0 : box.diagonal().norm();
}

vtkSmartPointer<vtkDoubleArray> doubles(vtkPointData* data, const char* name, vtkIdType count, int components)
{
  auto array = vtkSmartPointer<vtkDoubleArray>::New();
  array->SetName(name);
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(count);
  data->AddArray(array);
  return array;
}

} // namespace

//------------------------------------------------------------------------------
vtkBSplineVolumeProbe::vtkBSplineVolumeProbe()
{
  this->SetNumberOfInputPorts(2);
}

//------------------------------------------------------------------------------
void vtkBSplineVolumeProbe::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Tolerance: " << this->Tolerance << "\n";
  os << indent << "ComputeDerivatives: " << (this->ComputeDerivatives ? "On" : "Off") << "\n";
  os << indent << "NumberOfPoints: " << this->NumberOfPoints << "\n";
  os << indent << "NumberOfPointsInside: " << this->NumberOfPointsInside << "\n";
  os << indent << "Report: " << this->Report << "\n";
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeProbe::FillInputPortInformation(int port, vtkInformation* info)
{
  bsv::acceptMissing(info);
  if (port == 1)
  {
    info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataSet");
    return 1;
  }
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObjectTree");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkStructuredGrid");
  return 1;
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeProbe::RequestDataObject(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkDataSet* points = vtkDataSet::GetData(inputVector[1], 0);
  vtkDataSet* output = vtkDataSet::GetData(outputVector, 0);
  if (!output || (points && !output->IsA(points->GetClassName())))
  {
    const auto made = points ? vtkSmartPointer<vtkDataSet>::Take(points->NewInstance())
                             : vtkSmartPointer<vtkDataSet>(vtkSmartPointer<vtkPolyData>::New());
    outputVector->GetInformationObject(0)->Set(vtkDataObject::DATA_OBJECT(), made);
  }
  return 1;
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeProbe::RequestInformation(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  // Extents and pieces are those of the points.
  if (vtkInformation* points = inputVector[1]->GetInformationObject(0))
  {
    vtkInformation* output = outputVector->GetInformationObject(0);
    output->CopyEntry(points, vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT());
    output->CopyEntry(points, vtkDataObject::ORIGIN());
    output->CopyEntry(points, vtkDataObject::SPACING());
  }
  return 1;
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeProbe::RequestUpdateExtent(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  // Of the volume this rank's piece; of the points what is asked of the output.
  vtkInformation* output = outputVector->GetInformationObject(0);
  vtkInformation* points = inputVector[1]->GetInformationObject(0);
  if (points && output->Has(vtkStreamingDemandDrivenPipeline::UPDATE_EXTENT()))
  {
    points->CopyEntry(output, vtkStreamingDemandDrivenPipeline::UPDATE_EXTENT());
  }
  for (vtkInformation* input : { points, inputVector[0]->GetInformationObject(0) })
  {
    if (!input)
    {
      continue;
    }
    input->CopyEntry(output, vtkStreamingDemandDrivenPipeline::UPDATE_PIECE_NUMBER());
    input->CopyEntry(output, vtkStreamingDemandDrivenPipeline::UPDATE_NUMBER_OF_PIECES());
    input->CopyEntry(output, vtkStreamingDemandDrivenPipeline::UPDATE_NUMBER_OF_GHOST_LEVELS());
  }
  return 1;
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeProbe::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkDataSet* output = vtkDataSet::GetData(outputVector, 0);
  if (!output)
  {
    vtkErrorMacro("The output is missing.");
    return 0;
  }
  this->NumberOfPoints = this->NumberOfPointsInside = 0;
  this->Report.clear();
  return bsv::execute(this, [&] {
    const bsv::Execution run = bsv::filterExecution(this);
    const bsv::Ranks& ranks = *run.ranks;
    vtkDataSet* points = vtkDataSet::GetData(inputVector[1], 0);
    if (ranks.any(!points))
    {
      throw bsv::Error("Points: choose a data set whose points are to be found, such as the source Line");
    }
    bsv::requireFinitePoints(points, "Points", run);
    ranks.nextStep();
    const bsv::BSplineVolumeBlocks input = bsv::bsplineVolumeBlocks(bsv::requiredInput(inputVector, 0), ranks);
    bsv::requireVolumes(input);
    // On both sides of the question, and as arrays.
    bsv::requireMemory(static_cast<double>(points->GetNumberOfPoints()) *
        (2 * (sizeof(bsv::Triple) + sizeof(Answer)) + (this->ComputeDerivatives ? 14 : 5) * sizeof(double) +
          sizeof(int)),
      std::to_string(points->GetNumberOfPoints()) + " points", "what is found at them");
    const bsv::VolumeLocator locator(input.volumes, run);
    const double tolerance = std::max(this->Tolerance, Rounding) * diagonal(locator, ranks);

    // Every rank asks all ranks for its points.
    constexpr Index Grain = 1 << 12;
    const Index count = points->GetNumberOfPoints();
    std::vector<bsv::Triple> mine(count);
    run.parallelFor(count, Grain, [&](Index begin, Index end) {
      for (Index n = begin; n < end; ++n)
      {
        points->GetPoint(n, mine[n].data());
      }
    });
    const std::vector<std::vector<bsv::Triple>> asked =
      ranks.exchange(std::vector<std::vector<bsv::Triple>>(ranks.size(), mine));
    Index all = 0;
    for (const std::vector<bsv::Triple>& part : asked)
    {
      all += static_cast<Index>(part.size());
    }
    std::vector<std::vector<Answer>> answers;
    Index done = 0;
    for (const std::vector<bsv::Triple>& part : asked)
    {
      answers.emplace_back(part.size());
      constexpr Index Portion = 1 << 11; // between two reports: 50 microseconds each where cells are curved
      for (Index first = 0; first < static_cast<Index>(part.size()); first += Portion)
      {
        const Index last = std::min(static_cast<Index>(part.size()), first + Portion);
        run.parallelFor(last - first, 64, [&](Index begin, Index end) {
          for (Index n = first + begin; n < first + end; ++n)
          {
            answers.back()[n] = answerTo(locator, input.volumes, part[n], tolerance);
          }
        });
        done += last - first;
        run.report(static_cast<double>(done) / static_cast<double>(all));
      }
    }
    const std::vector<std::vector<Answer>> received = ranks.exchange(std::move(answers));

    output->ShallowCopy(points);
    vtkPointData* data = output->GetPointData();
    vtkNew<vtkIntArray> block;
    block->SetName("BlockId");
    block->SetNumberOfTuples(count);
    data->AddArray(block);
    const auto uvw = doubles(data, "UVW", count, 3);
    const auto distance = doubles(data, "Distance", count, 1);
    const auto jacobian = doubles(data, "Jacobian", count, 1);
    static constexpr const char* Names[3] = { "dXdU", "dXdV", "dXdW" };
    std::array<vtkSmartPointer<vtkDoubleArray>, 3> slopes;
    for (int d = 0; this->ComputeDerivatives && d < 3; ++d)
    {
      slopes[d] = doubles(data, Names[d], count, 3);
    }
    run.parallelFor(count, Grain, [&](Index begin, Index end) {
      for (Index n = begin; n < end; ++n)
      {
        Answer best{ -1, 0.0, {}, {} };
        for (const std::vector<Answer>& part : received)
        {
          if (part[n].block >= 0 && (best.block < 0 || part[n].block < best.block))
          {
            best = part[n];
          }
        }
        block->SetValue(n, best.block);
        uvw->SetTypedTuple(n, best.uvw.data());
        distance->SetValue(n, best.distance);
        jacobian->SetValue(
          n, bsv::vec3(best.slopes[0]).cross(bsv::vec3(best.slopes[1])).dot(bsv::vec3(best.slopes[2])));
        for (int d = 0; this->ComputeDerivatives && d < 3; ++d)
        {
          slopes[d]->SetTypedTuple(n, best.slopes[d].data());
        }
      }
    });
    const int* blocks = block->GetPointer(0);
    const Index inside = std::count_if(blocks, blocks + count, [](int b) { return b >= 0; });
    for (const std::array<Index, 2>& part : ranks.gatherAll(std::vector<std::array<Index, 2>>{ { count, inside } }))
    {
      this->NumberOfPoints += part[0];
      this->NumberOfPointsInside += part[1];
    }
    const vtkIdType outside = this->NumberOfPoints - this->NumberOfPointsInside;
    this->Report = std::to_string(this->NumberOfPointsInside) + " of " + std::to_string(this->NumberOfPoints) +
      " points lie in the volume" + (outside > 0 ? "\nBlockId of the others is -1" : "");
  });
}
