// SPDX-License-Identifier: BSD-3-Clause
#include "vtkQuadflowReader.h"

#include "Data/BSplineVolumeData.h"
#include "Data/HexBlockData.h"
#include "Execution/PieceRequest.h"
#include "Quadflow/QuadflowFormat.h"

#include "vtkErrorCode.h"
#include "vtkFieldData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkSmartPointer.h"
#include "vtkStringArray.h"
#include "vtkStructuredGrid.h"
#include "vtkUnsignedCharArray.h"

#include <map>

vtkStandardNewMacro(vtkQuadflowReader);

//------------------------------------------------------------------------------
vtkQuadflowReader::vtkQuadflowReader() = default;

//------------------------------------------------------------------------------
void vtkQuadflowReader::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
}

//------------------------------------------------------------------------------
int vtkQuadflowReader::CanReadFile(const char* fileName)
{
  return fileName && bsv::looksLikeQuadflow(FirstFile(fileName)) ? 1 : 0;
}

//------------------------------------------------------------------------------
int vtkQuadflowReader::RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector)
{
  auto* output = vtkPartitionedDataSetCollection::GetData(outputVector);
  this->SetErrorCode(vtkErrorCode::NoError);
  const bsv::Piece piece = bsv::requestedPiece(outputVector->GetInformationObject(0));
  const bsv::Execution run = bsv::pieceExecution(this, piece);
  std::string fileName;
  const int success = bsv::execute(this, *run.ranks, [&] {
    const Step step = this->RequestedStep(outputVector);
    fileName = step.file;
    std::vector<vtkSmartPointer<vtkStructuredGrid>> grids;
    bsv::MemoryDemand demand(fileName, "its control points");
    const bsv::QuadflowStorage storage = [&](int block, const std::array<int, 3>& counts) {
      demand.add(24.0 * counts[0] * counts[1] * counts[2]);
      double* points = nullptr;
      grids.resize(block);
      grids.push_back(bsv::blockGrid(counts, points));
      return points;
    };
    const bsv::QuadflowCase all = bsv::readQuadflow(fileName, storage, run, piece);
    grids.resize(all.blocks.size());

    std::vector<std::string> names;
    for (std::size_t b = 0; b < all.blocks.size(); ++b)
    {
      if (grids[b])
      {
        bsv::setDegreeAndKnots(grids[b], all.blocks[b].volume);
        // Which edges are creases or planar the writer cannot find from the points.
        vtkNew<vtkUnsignedCharArray> classes;
        classes->SetName("EdgeClasses");
        for (const int edge : all.blocks[b].edges)
        {
          classes->InsertNextValue(static_cast<unsigned char>(all.edges[edge].kind));
        }
        grids[b]->GetFieldData()->AddArray(classes);
      }
      names.push_back(all.blocks[b].name.empty() ? "block " + std::to_string(b) : all.blocks[b].name);
    }
    std::vector<bsv::Interface> interfaces;
    for (const bsv::QuadflowInterface& entry : all.interfaces)
    {
      interfaces.push_back(entry.contact);
    }
    std::map<int, int> tags;
    std::vector<std::string> boundaryNames;
    for (const bsv::QuadflowBoundaryName& boundary : all.boundaryNames)
    {
      tags[boundary.id] = static_cast<int>(boundaryNames.size());
      boundaryNames.push_back(boundary.name);
    }
    std::vector<bsv::BoundaryPatch> boundaries;
    for (const bsv::QuadflowBoundaryFace& face : all.boundaryFaces)
    {
      if (face.boundary != 0)
      {
        boundaries.push_back({ face.block, face.face, {}, tags[face.boundary] });
      }
    }
    bsv::setBlocks(output, grids, names, "BSplineVolume");
    bsv::setWholeFaceContacts(output, interfaces, boundaries, boundaryNames);
    if (!all.title.empty())
    {
      vtkNew<vtkStringArray> title;
      title->SetName("QuadflowTitle");
      title->InsertNextValue(bsv::validUTF8(all.title));
      output->GetFieldData()->AddArray(title);
    }
    SetTime(output, step);
  });
  if (!success)
  {
    this->SetFileError(fileName);
  }
  return success;
}
