// SPDX-License-Identifier: BSD-3-Clause
#include "vtkHexBlockMeshReader.h"

#include "Data/HexBlockData.h"
#include "Execution/PieceRequest.h"
#include "Formats/CGNSZones.h"
#include "Formats/NeutralMapFile.h"
#include "Formats/Plot3DFile.h"

#include "vtkDoubleArray.h"
#include "vtkErrorCode.h"
#include "vtkFloatArray.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkIntArray.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkSmartPointer.h"
#include "vtkStructuredGrid.h"
#include "vtksys/SystemTools.hxx"

#include <new>

vtkStandardNewMacro(vtkHexBlockMeshReader);

namespace
{

static_assert(int(vtkHexBlockMeshReader::FORTRAN_UNFORMATTED_64) == int(bsv::Plot3DFormat::Fortran64), "same order");
static_assert(int(vtkHexBlockMeshReader::BIG_ENDIAN_ORDER) == int(bsv::ByteOrder::BigEndian), "same order");
static_assert(int(vtkHexBlockMeshReader::DOUBLE_PRECISION) == int(bsv::RealType::Double), "same order");
static_assert(int(vtkHexBlockMeshReader::WITH_IBLANK) == int(bsv::IBlank::Present), "same order");

/// Array that takes over the values, without a copy.
template <typename Array, typename Value>
vtkSmartPointer<Array> adopt(std::unique_ptr<Value[]>& values, int components, bsv::Index tuples)
{
  auto array = vtkSmartPointer<Array>::New();
  array->SetNumberOfComponents(components);
  array->SetArray(values.release(), components * tuples, 0, Array::VTK_DATA_ARRAY_DELETE);
  return array;
}

/// Grid that takes over the points of the block; null if they are not here.
vtkSmartPointer<vtkStructuredGrid> adopt(bsv::GridBlock& block)
{
  if (!block.isHere())
  {
    return nullptr;
  }
  vtkNew<vtkPoints> points;
  if (block.floats)
  {
    points->SetData(adopt<vtkFloatArray>(block.floats, 3, block.size()));
  }
  else
  {
    points->SetData(adopt<vtkDoubleArray>(block.doubles, 3, block.size()));
  }
  auto grid = vtkSmartPointer<vtkStructuredGrid>::New();
  grid->SetDimensions(block.counts.data());
  grid->SetPoints(points);
  if (block.iblank)
  {
    const auto array = adopt<vtkIntArray>(block.iblank, 1, block.size());
    array->SetName("IBlank");
    grid->GetPointData()->AddArray(array);
  }
  return grid;
}

} // namespace

//------------------------------------------------------------------------------
vtkHexBlockMeshReader::vtkHexBlockMeshReader()
{
  this->SetNumberOfInputPorts(0);
}

//------------------------------------------------------------------------------
int vtkHexBlockMeshReader::CanReadFile(const char* fileName)
{
  return fileName && (bsv::looksLikeCGNS(fileName) || bsv::looksLikePlot3D(fileName)) ? 1 : 0;
}

//------------------------------------------------------------------------------
int vtkHexBlockMeshReader::RequestInformation(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector)
{
  outputVector->GetInformationObject(0)->Set(CAN_HANDLE_PIECE_REQUEST(), 1);
  return 1;
}

//------------------------------------------------------------------------------
int vtkHexBlockMeshReader::RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector)
{
  auto* output = vtkPartitionedDataSetCollection::GetData(outputVector);
  this->SetErrorCode(vtkErrorCode::NoError);
  this->FileLayout.clear();
  if (this->FileName.empty())
  {
    vtkErrorMacro("File Name is empty.");
    this->SetErrorCode(vtkErrorCode::NoFileNameError);
    return 0;
  }
  const bsv::Piece piece = bsv::requestedPiece(outputVector->GetInformationObject(0));
  const bsv::Execution run = bsv::pieceExecution(this, piece, 0.0, 0.95);
  const int success = bsv::execute(this, output, *run.ranks, [&] {
    std::string layoutName;
    std::vector<bsv::GridBlock> blocks;
    bsv::BlockMesh mesh;
    if (bsv::looksLikeCGNS(this->FileName))
    {
      bsv::CGNSZones zones = bsv::readCGNS(this->FileName, run, piece);
      blocks = std::move(zones.blocks);
      mesh.interfaces = std::move(zones.interfaces);
      mesh.boundaries = std::move(zones.boundaries);
      mesh.boundaryNames = std::move(zones.boundaryNames);
      layoutName = "CGNS";
    }
    else
    {
      bsv::Plot3DOptions options;
      options.format = static_cast<bsv::Plot3DFormat>(this->Format);
      options.byteOrder = static_cast<bsv::ByteOrder>(this->ByteOrder);
      options.realType = static_cast<bsv::RealType>(this->Precision);
      options.iblank = static_cast<bsv::IBlank>(this->IBlank);
      run.ranks->together([&] {
        const bsv::Plot3DLayout layout = bsv::plot3DLayout(this->FileName, options);
        blocks = bsv::readPlot3D(this->FileName, layout, run, piece);
        layoutName = "PLOT3D, " + layout.description();
      });
    }
    for (const bsv::GridBlock& block : blocks)
    {
      mesh.blocks.push_back(bsv::meshBlock(block));
    }
    if (this->UseNeutralMap && layoutName != "CGNS")
    {
      const std::string extension = vtksys::SystemTools::GetFilenameLastExtension(this->FileName);
      const std::string beside = this->FileName.substr(0, this->FileName.size() - extension.size()) + ".nmf";
      if (!this->NeutralMapFile.empty())
      {
        bsv::readNeutralMap(this->NeutralMapFile, mesh, run);
      }
      else if (run.ranks->any(vtksys::SystemTools::FileExists(beside, true)))
      {
        bsv::readNeutralMap(beside, mesh, run);
      }
    }

    vtkNew<vtkPartitionedDataSetCollection> result;
    std::vector<vtkSmartPointer<vtkStructuredGrid>> grids;
    std::vector<std::string> names;
    for (bsv::GridBlock& block : blocks)
    {
      grids.push_back(adopt(block));
      names.push_back(block.name);
    }
    bsv::setBlocks(result, grids, names, "mesh");
    bsv::setConnectivity(result->GetFieldData(), mesh);
    output->ShallowCopy(result);
    this->FileLayout = layoutName;
    this->UpdateProgress(1.0);
  });
  if (!success)
  {
    this->SetErrorCode(vtksys::SystemTools::FileExists(this->FileName) ? vtkErrorCode::FileFormatError
                                                                       : vtkErrorCode::FileNotFoundError);
  }
  return success;
}

//------------------------------------------------------------------------------
void vtkHexBlockMeshReader::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "FileName: " << this->FileName << "\n";
  os << indent << "UseNeutralMap: " << this->UseNeutralMap << "\n";
  os << indent << "NeutralMapFile: " << this->NeutralMapFile << "\n";
  os << indent << "Format: " << this->Format << "\n";
  os << indent << "ByteOrder: " << this->ByteOrder << "\n";
  os << indent << "Precision: " << this->Precision << "\n";
  os << indent << "IBlank: " << this->IBlank << "\n";
  os << indent << "FileLayout: " << this->FileLayout << "\n";
}
