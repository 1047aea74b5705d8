// SPDX-License-Identifier: BSD-3-Clause
#include "vtkBSplineVolumeSampler.h"

#include "Data/BSplineVolumeData.h"
#include "Data/HexBlockData.h"
#include "Execution/FilterExecution.h"
#include "Execution/MemoryCheck.h"
#include "Volume/Sampling.h"

#include "vtkDataObject.h"
#include "vtkDoubleArray.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkStructuredGrid.h"

#include <limits>

vtkStandardNewMacro(vtkBSplineVolumeSampler);

namespace
{

vtkSmartPointer<vtkDoubleArray> triples(vtkIdType count)
{
  auto array = vtkSmartPointer<vtkDoubleArray>::New();
  array->SetNumberOfComponents(3);
  array->SetNumberOfTuples(count);
  return array;
}

} // namespace

//------------------------------------------------------------------------------
void vtkBSplineVolumeSampler::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Level: " << this->Level << "\n";
  os << indent << "ComputeDerivatives: " << (this->ComputeDerivatives ? "On" : "Off") << "\n";
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeSampler::FillInputPortInformation(int, vtkInformation* info)
{
  info->Remove(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE());
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObjectTree");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkStructuredGrid");
  return 1;
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeSampler::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  auto* output = vtkPartitionedDataSetCollection::GetData(outputVector, 0);
  if (!output)
  {
    vtkErrorMacro("The output is missing.");
    return 0;
  }
  return bsv::execute(this, output, [&] {
    const bsv::BSplineVolumeBlocks input =
      bsv::bsplineVolumeBlocks(vtkDataObject::GetData(inputVector[0], 0), *bsv::globalRanks());
    const std::size_t blocks = input.volumes.size();
    if (blocks == 0)
    {
      return;
    }

    std::vector<bsv::Ijk> counts;
    double total = 0.0;
    for (std::size_t b = 0; b < blocks; ++b)
    {
      counts.push_back(bsv::sampleCounts(input.volumes[b], this->Level, input.label(b)));
      const double points = static_cast<double>(counts[b][0]) * counts[b][1] * counts[b][2];
      if (3.0 * points > static_cast<double>(std::numeric_limits<vtkIdType>::max()))
      {
        throw bsv::Error(input.label(b) + ": Level " + std::to_string(this->Level) + " has too many samples");
      }
      total += input.isHere(b) ? points : 0.0;
    }
    const int arrays = this->ComputeDerivatives ? 4 : 1;
    bsv::requireMemory(total * arrays * 3 * sizeof(double), "Level " + std::to_string(this->Level), "the samples");

    static constexpr std::array<std::array<int, 3>, 4> Orders{ { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } } };
    static constexpr const char* Names[4] = { "", "dXdU", "dXdV", "dXdW" };
    std::vector<vtkSmartPointer<vtkStructuredGrid>> grids(blocks);
    double done = 0.0;
    for (std::size_t b = 0; b < blocks; ++b)
    {
      if (!input.isHere(b))
      {
        continue;
      }
      vtkNew<vtkStructuredGrid> grid;
      grid->SetDimensions(counts[b].data());
      const vtkIdType size = vtkIdType(counts[b][0]) * counts[b][1] * counts[b][2];
      for (int a = 0; a < arrays; ++a)
      {
        const double share = static_cast<double>(size) / (total * arrays);
        vtkSmartPointer<vtkDoubleArray> values = triples(size);
        bsv::sample(input.volumes[b], this->Level, Orders[a], values->GetPointer(0),
          bsv::filterExecution(this, done, done + share));
        done += share;
        if (a == 0)
        {
          vtkNew<vtkPoints> points;
          points->SetData(values);
          grid->SetPoints(points);
        }
        else
        {
          values->SetName(Names[a]);
          grid->GetPointData()->AddArray(values);
        }
      }
      grids[b] = grid;
    }
    bsv::setBlocks(output, grids, input.names, "Samples");
    bsv::setWholeFaceContacts(output, input.interfaces, input.boundaries, input.boundaryNames, input.boundaryTypes);
  });
}
