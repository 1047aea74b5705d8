// SPDX-License-Identifier: BSD-3-Clause
#include "vtkQuadflowWriter.h"

#include "BSplineVolumeData.h"
#include "FilterExecution.h"
#include "QuadflowFormat.h"

#include "vtkCommunicator.h"
#include "vtkDataObject.h"
#include "vtkDataSet.h"
#include "vtkErrorCode.h"
#include "vtkInformation.h"
#include "vtkMultiProcessController.h"
#include "vtkObjectFactory.h"
#include "vtkPartitionedDataSet.h"
#include "vtkPartitionedDataSetCollection.h"

#include <algorithm>

vtkStandardNewMacro(vtkQuadflowWriter);

namespace
{

/// Whether block i of a collection is on this rank.
std::vector<int> presentBlocks(vtkDataObject* input)
{
  std::vector<int> present;
  if (auto* collection = vtkPartitionedDataSetCollection::SafeDownCast(input))
  {
    for (unsigned int i = 0; i < collection->GetNumberOfPartitionedDataSets(); ++i)
    {
      vtkPartitionedDataSet* parts = collection->GetPartitionedDataSet(i);
      bool any = false;
      for (unsigned int p = 0; parts && p < parts->GetNumberOfPartitions(); ++p)
      {
        any = any || (parts->GetPartition(p) && parts->GetPartition(p)->GetNumberOfPoints() > 0);
      }
      present.push_back(any);
    }
  }
  else
  {
    present.push_back(input && input->GetNumberOfElements(vtkDataObject::POINT) > 0);
  }
  return present;
}

/// Whether another rank holds a block that rank 0 does not hold.
bool blocksElsewhere(vtkDataObject* input, vtkMultiProcessController* controller)
{
  std::vector<int> here = presentBlocks(input);
  int size = static_cast<int>(here.size());
  int largest = 0;
  controller->AllReduce(&size, &largest, 1, vtkCommunicator::MAX_OP);
  here.resize(largest, 0);
  std::vector<int> anywhere(largest, 0);
  controller->AllReduce(here.data(), anywhere.data(), largest, vtkCommunicator::MAX_OP);
  return controller->GetLocalProcessId() == 0 && here != anywhere;
}

} // namespace

//------------------------------------------------------------------------------
void vtkQuadflowWriter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "FileName: " << this->FileName << "\n";
  os << indent << "IndexBase: " << this->IndexBase << "\n";
  os << indent << "KnotScaling: " << (this->KnotScaling == UNIT_KNOTS ? "Unit" : "Integer") << "\n";
  os << indent << "SeparateGeometry: " << (this->SeparateGeometry ? "On" : "Off") << "\n";
  os << indent << "Binary: " << (this->Binary ? "On" : "Off") << "\n";
  os << indent << "BoundaryIds:";
  for (const auto& [name, id] : this->BoundaryIds)
  {
    os << " " << name << "=" << id;
  }
  os << "\n";
}

//------------------------------------------------------------------------------
void vtkQuadflowWriter::SetBoundaryId(const char* name, int id)
{
  // A line of the property's list that was not filled in.
  if (name && name[0] != '\0')
  {
    this->BoundaryIds.emplace_back(name, id);
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkQuadflowWriter::ClearBoundaryIds()
{
  if (!this->BoundaryIds.empty())
  {
    this->BoundaryIds.clear();
    this->Modified();
  }
}

//------------------------------------------------------------------------------
int vtkQuadflowWriter::FillInputPortInformation(int, vtkInformation* info)
{
  info->Remove(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE());
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObjectTree");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkStructuredGrid");
  return 1;
}

//------------------------------------------------------------------------------
void vtkQuadflowWriter::WriteData()
{
  vtkMultiProcessController* controller = vtkMultiProcessController::GetGlobalController();
  const bool parallel = controller && controller->GetNumberOfProcesses() > 1;
  const bool distributed = parallel && blocksElsewhere(this->GetInput(), controller);
  if (parallel && controller->GetLocalProcessId() != 0)
  {
    return;
  }
  if (this->FileName.empty())
  {
    vtkErrorMacro("File Name is empty.");
    this->SetErrorCode(vtkErrorCode::NoFileNameError);
    return;
  }
  try
  {
    if (distributed)
    {
      throw bsv::Error("The blocks are distributed over several ranks; rank 0 must hold all of them.");
    }
    bsv::BSplineVolumeBlocks blocks = bsv::bsplineVolumeBlocks(this->GetInput());
    if (const int rational = blocks.firstRational(); rational >= 0)
    {
      throw bsv::Error(
        blocks.label(rational) + " is rational (point data array 'Weights'), and .qfmb holds polynomials only");
    }
    bsv::QuadflowInput input;
    input.volumes = std::move(blocks.volumes);
    input.names = std::move(blocks.names);
    input.rules = std::move(blocks.rules);
    input.hasInterfaces = blocks.hasInterfaces;
    input.interfaces = std::move(blocks.interfaces);
    input.boundaries = std::move(blocks.boundaries);
    input.boundaryNames = std::move(blocks.boundaryNames);
    input.boundaryIds = this->BoundaryIds;
    bsv::QuadflowOptions options;
    options.indexBase = this->IndexBase;
    options.unitKnots = this->KnotScaling == UNIT_KNOTS;
    options.separateGeometry = this->SeparateGeometry;
    options.binary = this->Binary;
    bsv::writeQuadflow(bsv::makeQuadflowCase(input), this->FileName, options, bsv::filterExecution(this));
  }
  catch (const bsv::Aborted&)
  {
    this->SetErrorCode(vtkErrorCode::UserError);
  }
  catch (const std::exception& error)
  {
    vtkErrorMacro(<< error.what());
    this->SetErrorCode(vtkErrorCode::CannotOpenFileError);
  }
}
