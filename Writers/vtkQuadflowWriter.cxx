// SPDX-License-Identifier: BSD-3-Clause
#include "vtkQuadflowWriter.h"

#include "Data/BSplineVolumeData.h"
#include "Execution/FilterExecution.h"
#include "Quadflow/QuadflowFormat.h"
#include "WriteTogether.h"

#include "vtkDataObject.h"
#include "vtkFieldData.h"
#include "vtkInformation.h"
#include "vtkObjectFactory.h"
#include "vtkStringArray.h"

vtkStandardNewMacro(vtkQuadflowWriter);

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
int vtkQuadflowWriter::Write()
{
  this->SetErrorCode(
    bsv::writeOnAllRanks(this, this->FileName, this->WriteTime, [this] { return this->Superclass::Write(); }));
  return this->GetErrorCode() == vtkErrorCode::NoError ? 1 : 0;
}

//------------------------------------------------------------------------------
void vtkQuadflowWriter::WriteData()
{
  const bsv::Execution run = bsv::filterExecution(this);
  this->SetErrorCode(bsv::writeTogether(this, this->FileName, *run.ranks, [&] {
    bsv::BSplineVolumeBlocks blocks = bsv::bsplineVolumeBlocks(this->GetInput(), *run.ranks);
    bsv::requireVolumes(blocks);
    if (const int rational = blocks.firstRational(); rational >= 0)
    {
      throw bsv::Error(
        blocks.label(rational) + " is rational (point data array 'Weights'), and .qfmb holds polynomials only");
    }
    bsv::QuadflowInput input;
    input.volumes = std::move(blocks.volumes);
    input.names = std::move(blocks.names);
    input.rules = std::move(blocks.rules);
    input.edgeClasses = std::move(blocks.edgeClasses);
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
    bsv::QuadflowCase all = bsv::makeQuadflowCase(input, run);
    if (auto* title = vtkStringArray::SafeDownCast(this->GetInput()->GetFieldData()->GetAbstractArray("QuadflowTitle"));
        title && title->GetNumberOfValues() > 0)
    {
      const std::string text = title->GetValue(0);
      all.title = text.substr(0, text.find_first_of("\r\n"));
    }
    bsv::writeQuadflow(all, this->FileName, options, run);
  }));
}
