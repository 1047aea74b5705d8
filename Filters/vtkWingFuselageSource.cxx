// SPDX-License-Identifier: BSD-3-Clause
#include "vtkWingFuselageSource.h"

#include "Data/BlockTags.h"
#include "Data/HexBlockData.h"
#include "Data/NURBSSurfaceData.h"
#include "Execution/PieceRequest.h"
#include "Mesh/MeshCheck.h"
#include "WingFuselage/WingFuselageMesh.h"

#include "vtkExecutive.h"
#include "vtkInformationVector.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkPolyData.h"
#include "vtkStructuredGrid.h"

#include <algorithm>
#include <sstream>

vtkStandardNewMacro(vtkWingFuselageSource);

namespace
{

/// The mesh without its points.
bsv::BlockMesh blockMesh(const bsv::WingFuselageLayout& layout)
{
  bsv::BlockMesh mesh;
  for (std::size_t b = 0; b < layout.counts.size(); ++b)
  {
    bsv::MeshBlock block;
    block.points = bsv::GridView::elsewhere(layout.counts[b]);
    block.name = layout.names[b];
    mesh.blocks.push_back(block);
  }
  mesh.interfaces = layout.interfaces;
  mesh.boundaries = layout.boundaries;
  mesh.boundaryNames = layout.boundaryNames;
  mesh.creases = layout.creases;
  return mesh;
}

/// Every patch as a grid of triangles.
vtkSmartPointer<vtkPolyData> tessellation(const std::vector<bsv::BodyPatch>& body, const bsv::Execution& run)
{
  constexpr int Cells = 64;
  std::vector<int> patches;
  std::vector<bsv::Vec2> parameters;
  std::vector<std::array<int, 3>> triangles;
  for (int p = 0; p < static_cast<int>(body.size()); ++p)
  {
    const int first = static_cast<int>(patches.size());
    for (int j = 0; j <= Cells; ++j)
    {
      for (int i = 0; i <= Cells; ++i)
      {
        patches.push_back(p);
        parameters.emplace_back(double(i) / Cells, double(j) / Cells);
        if (i < Cells && j < Cells)
        {
          const int corner = first + i + (Cells + 1) * j;
          triangles.push_back({ corner, corner + 1, corner + Cells + 2 });
          triangles.push_back({ corner, corner + Cells + 2, corner + Cells + 1 });
        }
      }
    }
  }
  return bsv::bodySurface(body, patches, parameters, triangles, run);
}

} // namespace

//------------------------------------------------------------------------------
vtkWingFuselageSource::vtkWingFuselageSource()
{
  this->SetNumberOfInputPorts(0);
  this->SetNumberOfOutputPorts(2);
}

//------------------------------------------------------------------------------
void vtkWingFuselageSource::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Resolution: " << this->Resolution << "\n";
  os << indent << "Span: " << this->Span << "\n";
  os << indent << "SweepAngle: " << this->SweepAngle << "\n";
  os << indent << "FarFieldDistance: " << this->FarFieldDistance << "\n";
  os << indent << "FirstLayerHeight: " << this->FirstLayerHeight << "\n";
  os << indent << "GrowthRatio: " << this->GrowthRatio << "\n";
  os << indent << "NumberOfMeshPoints: " << this->NumberOfMeshPoints << "\n";
  os << indent << "MinimumScaledJacobian: " << this->MinimumScaledJacobian << "\n";
}

//------------------------------------------------------------------------------
int vtkWingFuselageSource::RequestInformation(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector)
{
  for (int port = 0; port < this->GetNumberOfOutputPorts(); ++port)
  {
    outputVector->GetInformationObject(port)->Set(CAN_HANDLE_PIECE_REQUEST(), 1);
  }
  return 1;
}

//------------------------------------------------------------------------------
int vtkWingFuselageSource::RequestUpdateExtent(
  vtkInformation* request, vtkInformationVector**, vtkInformationVector* outputVector)
{
  // Both outputs are made at once: who asks for a piece of one shall not get all of the other.
  vtkInformation* asked = outputVector->GetInformationObject(request->Get(vtkExecutive::FROM_OUTPUT_PORT()));
  for (int port = 0; asked && port < this->GetNumberOfOutputPorts(); ++port)
  {
    vtkInformation* output = outputVector->GetInformationObject(port);
    output->CopyEntry(asked, vtkStreamingDemandDrivenPipeline::UPDATE_PIECE_NUMBER());
    output->CopyEntry(asked, vtkStreamingDemandDrivenPipeline::UPDATE_NUMBER_OF_PIECES());
  }
  return 1;
}

//------------------------------------------------------------------------------
int vtkWingFuselageSource::RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector)
{
  auto* mesh = vtkPartitionedDataSetCollection::GetData(outputVector, 0);
  auto* body = vtkPartitionedDataSetCollection::GetData(outputVector, 1);
  if (!mesh || !body)
  {
    vtkErrorMacro("An output is missing.");
    return 0;
  }
  this->NumberOfMeshPoints = 0;
  this->MinimumScaledJacobian = 0.0;
  const bsv::Piece piece = bsv::requestedPiece(outputVector->GetInformationObject(0));
  const bsv::Execution firstHalf = bsv::pieceExecution(this, piece, 0.0, 0.5);
  const bsv::Execution run = bsv::pieceExecution(this, piece, 0.5, 1.0);
  return bsv::execute(this, *run.ranks, [&] {
    bsv::WingFuselageOptions options;
    options.shape.span = this->Span;
    options.shape.sweepAngle = this->SweepAngle;
    options.resolution = this->Resolution;
    options.farFieldDistance = this->FarFieldDistance;
    options.firstLayerHeight = this->FirstLayerHeight;
    options.growthRatio = this->GrowthRatio;
    const bsv::WingFuselageLayout layout = bsv::wingFuselageLayout(options);

    const std::vector<int> owners = piece.owners(layout.counts);
    std::vector<bsv::BodyPatch> patches;
    std::vector<vtkSmartPointer<vtkStructuredGrid>> grids(layout.counts.size());
    std::vector<double*> addresses(layout.counts.size(), nullptr);
    double minimum = 1.0;
    bsv::Index points = 0;
    for (std::size_t b = 0; b < owners.size(); ++b)
    {
      const bsv::Ijk& counts = layout.counts[b];
      points += owners[b] == piece.number ? bsv::Index(counts[0]) * counts[1] * counts[2] : 0;
    }
    bsv::requireMemory(
      static_cast<double>(points) * 3 * sizeof(double), "Resolution " + std::to_string(this->Resolution), "the points");

    patches = bsv::wingFuselageBody(options.shape);
    for (std::size_t b = 0; b < owners.size(); ++b)
    {
      if (owners[b] == piece.number)
      {
        grids[b] = bsv::blockGrid(layout.counts[b], addresses[b]);
      }
    }
    bsv::wingFuselagePoints(options, patches, addresses, firstHalf);

    bsv::Execution alone = run;
    alone.ranks = bsv::aloneRank();
    for (std::size_t b = 0; b < addresses.size(); ++b)
    {
      run.report(static_cast<double>(b) / static_cast<double>(addresses.size()));
      if (addresses[b])
      {
        const bsv::GridView view(addresses[b], layout.counts[b]);
        minimum = std::min(minimum, bsv::minimumScaledJacobian(view, alone));
      }
    }
    const std::vector<double> minima = run.ranks->gatherAll(std::vector<double>{ minimum });
    minimum = *std::min_element(minima.begin(), minima.end());
    if (!(minimum > 0.0))
    {
      std::ostringstream text;
      text << "Resolution " << options.resolution << " is too low for Span " << options.shape.span
           << " and Sweep Angle " << options.shape.sweepAngle << ": the smallest scaled Jacobian of the cells would be "
           << minimum;
      throw bsv::Error(text.str());
    }

    bsv::setBlocks(mesh, grids, layout.names, "Mesh");
    bsv::setInterfaces(mesh->GetFieldData(), layout.interfaces, layout.counts);
    bsv::setBoundaries(mesh->GetFieldData(), layout.boundaries, layout.boundaryNames, layout.counts);
    bsv::setCreases(mesh->GetFieldData(), layout.creases);
    bsv::tagBlocks(mesh, blockMesh(layout), "wing and fuselage");
    bsv::setBody(body, patches, std::vector<std::string>(patches.size()), tessellation(patches, run));
    this->NumberOfMeshPoints = layout.points();
    this->MinimumScaledJacobian = minimum;
  });
}
