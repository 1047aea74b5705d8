// SPDX-License-Identifier: BSD-3-Clause
#include "vtkBSplineVolumeReader.h"

#include "Data/BSplineVolumeData.h"
#include "Data/HexBlockData.h"
#include "Execution/PieceRequest.h"
#include "Formats/BSplineVolumeFile.h"

#include "vtkDoubleArray.h"
#include "vtkErrorCode.h"
#include "vtkFieldData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkIntArray.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkStructuredGrid.h"

vtkStandardNewMacro(vtkBSplineVolumeReader);

namespace
{

vtkSmartPointer<vtkStructuredGrid> gridOf(const bsv::BSplineVolumeFileBlock& block, bool withAttribute)
{
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(static_cast<vtkIdType>(block.points.size()));
  for (std::size_t i = 0; i < block.points.size(); ++i)
  {
    points->SetPoint(static_cast<vtkIdType>(i), block.points[i].data());
  }
  auto grid = vtkSmartPointer<vtkStructuredGrid>::New();
  grid->SetDimensions(block.volume.count(0), block.volume.count(1), block.volume.count(2));
  grid->SetPoints(points);
  bsv::setDegreeAndKnots(grid, block.volume);
  if (!block.weights.empty())
  {
    vtkNew<vtkDoubleArray> weights;
    weights->SetName("Weights");
    weights->SetNumberOfValues(static_cast<vtkIdType>(block.weights.size()));
    std::copy(block.weights.begin(), block.weights.end(), weights->GetPointer(0));
    grid->GetPointData()->AddArray(weights);
  }
  if (withAttribute)
  {
    vtkNew<vtkIntArray> attribute;
    attribute->SetName("Attribute");
    attribute->InsertNextValue(block.attribute);
    grid->GetFieldData()->AddArray(attribute);
  }
  return grid;
}

} // namespace

//------------------------------------------------------------------------------
vtkBSplineVolumeReader::vtkBSplineVolumeReader() = default;

//------------------------------------------------------------------------------
void vtkBSplineVolumeReader::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Format: " << this->Format << "\n";
  os << indent << "NumberOfBlocks: " << this->NumberOfBlocks << "\n";
  os << indent << "NumberOfRationalBlocks: " << this->NumberOfRationalBlocks << "\n";
  os << indent << "NotRead: " << this->NotRead << "\n";
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeReader::CanReadFile(const char* fileName)
{
  return fileName && bsv::isBSplineVolumeFile(FirstFile(fileName)) ? 1 : 0;
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeReader::RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector)
{
  auto* output = vtkPartitionedDataSetCollection::GetData(outputVector);
  this->SetErrorCode(vtkErrorCode::NoError);
  this->Format.clear();
  this->NotRead.clear();
  this->NumberOfBlocks = this->NumberOfRationalBlocks = 0;
  const bsv::Piece piece = bsv::requestedPiece(outputVector->GetInformationObject(0));
  const bsv::Execution run = bsv::pieceExecution(this, piece);
  std::string fileName;
  const int success = bsv::execute(this, *run.ranks, [&] {
    const Step step = this->RequestedStep(outputVector);
    fileName = step.file;
    bsv::BSplineVolumeFileContent content;
    std::vector<vtkSmartPointer<vtkStructuredGrid>> grids;
    std::vector<std::string> names;
    run.report(0.0);
    content = bsv::readBSplineVolumeFile(fileName, bsv::pieceExecution(this, piece, 0.0, 0.8));
    std::vector<bsv::Ijk> counts;
    for (const bsv::BSplineVolumeFileBlock& block : content.blocks)
    {
      counts.push_back({ block.volume.count(0), block.volume.count(1), block.volume.count(2) });
      names.push_back(block.name);
    }
    const std::vector<int> owners = piece.owners(counts);
    for (std::size_t b = 0; b < owners.size(); ++b)
    {
      bsv::BSplineVolumeFileBlock& block = content.blocks[b];
      grids.push_back(owners[b] == piece.number ? gridOf(block, content.format == "MFEM NURBS mesh") : nullptr);
      // So that there are never two copies of all.
      block.points = {};
      block.weights = {};
    }
    bsv::setBlocks(output, grids, names, "Volumes");
    bsv::setWholeFaceContacts(output, content.interfaces, content.boundaries, content.boundaryNames);

    this->Format = content.format;
    this->NumberOfBlocks = static_cast<int>(content.blocks.size());
    for (const bsv::BSplineVolumeFileBlock& block : content.blocks)
    {
      this->NumberOfRationalBlocks += block.rational;
    }
    for (const auto& other : content.others)
    {
      this->NotRead += (this->NotRead.empty() ? "" : ", ") + std::to_string(other.second) + " " + other.first;
    }
    if (!this->NotRead.empty() && run.ranks->rank() == 0)
    {
      vtkWarningMacro(<< fileName << ": left out: " << this->NotRead);
    }
    run.report(1.0);
    SetTime(output, step);
  });
  if (!success)
  {
    this->SetFileError(fileName);
  }
  return success;
}
