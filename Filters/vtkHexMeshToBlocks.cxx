// SPDX-License-Identifier: BSD-3-Clause
#include "vtkHexMeshToBlocks.h"

#include "Data/HexMeshData.h"
#include "Data/MeshInput.h"
#include "Execution/FilterExecution.h"

#include "vtkDataObject.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkObjectFactory.h"
#include "vtkPartitionedDataSetCollection.h"

#include <sstream>

vtkStandardNewMacro(vtkHexMeshToBlocks);

//------------------------------------------------------------------------------
vtkHexMeshToBlocks::vtkHexMeshToBlocks()
{
  this->SetNumberOfInputPorts(2);
}

//------------------------------------------------------------------------------
void vtkHexMeshToBlocks::SetBoundariesConnection(vtkAlgorithmOutput* output)
{
  this->SetInputConnection(1, output);
}

//------------------------------------------------------------------------------
int vtkHexMeshToBlocks::FillInputPortInformation(int port, vtkInformation* info)
{
  bsv::acceptMissing(info);
  if (port == 0)
  {
    bsv::acceptMeshes(info);
    return 1;
  }
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObjectTree");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkUnstructuredGrid");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkPolyData");
  return 1;
}

//------------------------------------------------------------------------------
int vtkHexMeshToBlocks::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkDataObject* input = vtkDataObject::GetData(inputVector[0], 0);
  vtkDataObject* boundaries = vtkDataObject::GetData(inputVector[1], 0);
  auto* output = vtkPartitionedDataSetCollection::GetData(outputVector, 0);
  if (!output)
  {
    vtkErrorMacro("The output is missing.");
    return 0;
  }

  this->NumberOfHexahedra = this->NumberOfSingularEdges = 0;
  this->NumberOfBlocks = 0;
  this->Report.clear();

  return bsv::execute(this, [&] {
    bsv::requiredInput(inputVector, 0);
    bsv::HexMeshOptions options;
    // What ParaView's list of arrays has for no array.
    options.boundaryArray = this->BoundaryArray == "None" ? std::string() : this->BoundaryArray;
    options.complex.featureAngle = this->FeatureAngle;
    options.complex.mergeBlocks = this->MergeBlocks;
    options.complex.maximumBlocks = this->MaximumNumberOfBlocks;
    options.complex.neighbours.mergePoints = this->MergePoints;
    options.complex.neighbours.matchTolerance = this->MatchTolerance;
    const bsv::Execution run = bsv::filterExecution(this);
    const bsv::HexMeshReport report = bsv::hexMeshToBlocks(input, boundaries, options, output, run);
    bsv::requireBlocks(run.ranks->any(report.blocks > 0), report.notes, report.warnings);

    std::ostringstream text;
    text << report.cells << " hexahedra, " << report.blocks << " blocks, " << report.singularEdges
         << " singular mesh edges\n";
    for (const std::string& note : report.notes)
    {
      text << note << '\n';
    }
    this->NumberOfHexahedra = report.cells;
    this->NumberOfBlocks = static_cast<int>(report.blocks);
    this->NumberOfSingularEdges = report.singularEdges;
    this->Report = text.str();
    bsv::warn(this, report.warnings);
  });
}

//------------------------------------------------------------------------------
void vtkHexMeshToBlocks::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "BoundaryArray: " << this->BoundaryArray << '\n';
  os << indent << "FeatureAngle: " << this->FeatureAngle << '\n';
  os << indent << "MergePoints: " << (this->MergePoints ? "On" : "Off") << '\n';
  os << indent << "MatchTolerance: " << this->MatchTolerance << '\n';
  os << indent << "MergeBlocks: " << (this->MergeBlocks ? "On" : "Off") << '\n';
  os << indent << "MaximumNumberOfBlocks: " << this->MaximumNumberOfBlocks << '\n';
  os << indent << "Report: " << this->Report << '\n';
}
