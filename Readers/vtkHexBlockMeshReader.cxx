// SPDX-License-Identifier: BSD-3-Clause
#include "vtkHexBlockMeshReader.h"

#include "Data/BlockTags.h"
#include "Data/HexBlockData.h"
#include "Execution/PieceRequest.h"
#include "Formats/CGNSZones.h"
#include "Formats/NeutralMapFile.h"
#include "Formats/Plot3DFile.h"

#include "vtkCellArray.h"
#include "vtkCellData.h"
#include "vtkCellType.h"
#include "vtkDataAssembly.h"
#include "vtkDataSetAttributes.h"
#include "vtkDoubleArray.h"
#include "vtkErrorCode.h"
#include "vtkFieldData.h"
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
#include "vtkStringArray.h"
#include "vtkStructuredGrid.h"
#include "vtkUnsignedCharArray.h"
#include "vtkUnstructuredGrid.h"
#include "vtksys/SystemTools.hxx"

#include <algorithm>
#include <array>
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
vtkSmartPointer<Array> adopt(bsv::BlockArray<Value>& values, int components, bsv::Index tuples)
{
  auto array = vtkSmartPointer<Array>::New();
  array->SetNumberOfComponents(components);
  array->SetArray(values.get(), components * tuples, 0, Array::VTK_DATA_ARRAY_USER_DEFINED);
  array->SetArrayFreeFunction(values.get_deleter().function);
  values.release();
  return array;
}

/// Cells of blanked points are hidden, as ParaView's own PLOT3D reader hides them.
void hideBlankedCells(vtkStructuredGrid* grid, vtkIntArray* iblank)
{
  const int* values = iblank->GetPointer(0);
  if (std::find(values, values + iblank->GetNumberOfValues(), 0) == values + iblank->GetNumberOfValues())
  {
    return;
  }
  vtkNew<vtkUnsignedCharArray> ghosts;
  ghosts->SetName(vtkDataSetAttributes::GhostArrayName());
  ghosts->SetNumberOfValues(grid->GetNumberOfCells());
  int dimensions[3];
  grid->GetDimensions(dimensions);
  const vtkIdType row = dimensions[0];
  const vtkIdType layer = row * dimensions[1];
  vtkIdType cell = 0;
  for (int k = 0; k + 1 < dimensions[2]; ++k)
  {
    for (int j = 0; j + 1 < dimensions[1]; ++j)
    {
      for (int i = 0; i + 1 < dimensions[0]; ++i, ++cell)
      {
        bool hidden = false;
        for (int corner = 0; corner < 8; ++corner)
        {
          hidden =
            hidden || values[i + (corner & 1) + row * (j + (corner >> 1 & 1)) + layer * (k + (corner >> 2))] == 0;
        }
        ghosts->SetValue(cell, hidden ? vtkDataSetAttributes::HIDDENCELL : 0);
      }
    }
  }
  grid->GetCellData()->AddArray(ghosts);
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
    hideBlankedCells(grid, array);
  }
  return grid;
}

/// Grid of cells of one type with these points of a zone, each of which it has once.
vtkSmartPointer<vtkUnstructuredGrid> gridOf(
  const bsv::HexZone& zone, const std::vector<bsv::Index>& corners, int type, int size, bool allPoints)
{
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  std::vector<vtkIdType> number(zone.points.size() / 3, -1);
  const auto add = [&](bsv::Index p) {
    if (number[p] < 0)
    {
      number[p] = points->InsertNextPoint(zone.points.data() + 3 * p);
    }
    return number[p];
  };
  for (std::size_t p = 0; allPoints && p < number.size(); ++p)
  {
    add(static_cast<bsv::Index>(p));
  }
  vtkNew<vtkCellArray> cells;
  cells->AllocateExact(static_cast<vtkIdType>(corners.size()) / size, static_cast<vtkIdType>(corners.size()));
  for (std::size_t c = 0; c < corners.size(); c += size)
  {
    cells->InsertNextCell(size);
    for (int n = 0; n < size; ++n)
    {
      cells->InsertCellPoint(add(corners[c + n]));
    }
  }
  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  grid->SetPoints(points);
  grid->SetCells(type, cells);
  return grid;
}

/// Adds the cells of a zone, and a data set per boundary, which its name names.
void addHexZone(vtkPartitionedDataSetCollection* collection, const bsv::HexZone& zone)
{
  const auto add = [&](vtkUnstructuredGrid* grid, const std::string& name) {
    const unsigned int at = collection->GetNumberOfPartitionedDataSets();
    collection->SetNumberOfPartitionedDataSets(at + 1);
    if (grid)
    {
      collection->SetPartition(at, 0, grid);
    }
    collection->GetMetaData(at)->Set(vtkCompositeDataSet::NAME(), name.c_str());
    vtkDataAssembly* assembly = collection->GetDataAssembly();
    const int node = assembly->AddNode(bsv::nodeName(name).c_str());
    assembly->AddDataSetIndex(node, at);
    assembly->SetAttribute(node, "label", name.c_str());
  };
  const bool here = !zone.points.empty();
  constexpr int HexahedronSize = 8;
  constexpr int QuadSize = 4;
  add(here ? gridOf(zone, zone.hexahedra, VTK_HEXAHEDRON, HexahedronSize, true).Get() : nullptr, zone.name);
  for (const bsv::HexZone::Boundary& boundary : zone.boundaries)
  {
    vtkSmartPointer<vtkUnstructuredGrid> grid;
    if (here)
    {
      grid = gridOf(zone, boundary.quadrilaterals, VTK_QUAD, QuadSize, false);
      vtkNew<vtkStringArray> type;
      type->SetName("BoundaryType");
      type->InsertNextValue(boundary.type);
      grid->GetFieldData()->AddArray(type);
    }
    add(grid, boundary.name);
  }
}

/// Says how many points the file blanks or takes from other grids. Collective.
void tellBlanked(const std::vector<bsv::GridBlock>& blocks, const bsv::Ranks& ranks, std::vector<std::string>& warnings)
{
  // Blanked, interpolated, blocks with such points.
  std::array<bsv::Index, 3> counts{};
  for (const bsv::GridBlock& block : blocks)
  {
    const int* values = block.isHere() ? block.iblank.get() : nullptr;
    const bsv::Index size = values ? block.size() : 0;
    const bsv::Index blanked = std::count(values, values + size, 0);
    const bsv::Index interpolated = std::count_if(values, values + size, [](int value) { return value < 0; });
    counts[0] += blanked;
    counts[1] += interpolated;
    counts[2] += blanked + interpolated > 0;
  }
  std::array<bsv::Index, 3> all{};
  for (const std::array<bsv::Index, 3>& other : ranks.gatherAll(std::vector<std::array<bsv::Index, 3>>{ counts }))
  {
    for (int n = 0; n < 3; ++n)
    {
      all[n] += other[n];
    }
  }
  if (all[2] > 0)
  {
    warnings.push_back("iblank marks " + std::to_string(all[0]) + " points as blanked (0) and " +
      std::to_string(all[1]) + " as interpolated from other grids (negative), in " + std::to_string(all[2]) +
      " of the blocks; the cells of blanked points are hidden, which the filters of this plugin leave out");
  }
}

} // namespace

//------------------------------------------------------------------------------
vtkHexBlockMeshReader::vtkHexBlockMeshReader() = default;

//------------------------------------------------------------------------------
int vtkHexBlockMeshReader::CanReadFile(const char* fileName)
{
  const std::string first = FirstFile(fileName);
  return bsv::looksLikeCGNS(first) || bsv::looksLikePlot3D(first) ? 1 : 0;
}

//------------------------------------------------------------------------------
std::vector<double> vtkHexBlockMeshReader::TimesIn(const std::string& fileName)
{
  return bsv::looksLikeCGNS(fileName) ? bsv::cgnsTimes(fileName) : std::vector<double>();
}

//------------------------------------------------------------------------------
int vtkHexBlockMeshReader::RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector)
{
  auto* output = vtkPartitionedDataSetCollection::GetData(outputVector);
  this->SetErrorCode(vtkErrorCode::NoError);
  this->FileLayout.clear();
  const bsv::Piece piece = bsv::requestedPiece(outputVector->GetInformationObject(0));
  const bsv::Execution run = bsv::pieceExecution(this, piece, 0.0, 0.95);
  std::string fileName;
  const int success = bsv::execute(this, *run.ranks, [&] {
    const Step step = this->RequestedStep(outputVector);
    fileName = step.file;
    std::string layoutName;
    std::vector<bsv::GridBlock> blocks;
    std::vector<bsv::HexZone> hexZones;
    bsv::BlockMesh mesh;
    std::vector<std::string> warnings;
    if (bsv::looksLikeCGNS(fileName))
    {
      bsv::CGNSZones zones = bsv::readCGNS(fileName, run, piece, step.number);
      blocks = std::move(zones.blocks);
      hexZones = std::move(zones.hexZones);
      mesh.interfaces = std::move(zones.interfaces);
      mesh.boundaries = std::move(zones.boundaries);
      mesh.boundaryNames = std::move(zones.boundaryNames);
      mesh.boundaryTypes = std::move(zones.boundaryTypes);
      warnings = std::move(zones.warnings);
      layoutName = "CGNS";
    }
    else
    {
      bsv::Plot3DOptions options;
      options.format = static_cast<bsv::Plot3DFormat>(this->Format);
      options.byteOrder = static_cast<bsv::ByteOrder>(this->ByteOrder);
      options.realType = static_cast<bsv::RealType>(this->Precision);
      options.iblank = static_cast<bsv::IBlank>(this->IBlank);
      const bsv::Plot3DLayout layout = bsv::plot3DLayout(fileName, options, run);
      blocks = bsv::readPlot3D(fileName, layout, run, piece);
      layoutName = "PLOT3D, " + layout.description();
      if (layout.comments > 0)
      {
        warnings.push_back("comments at its beginning are left out (" + std::to_string(layout.comments) +
          (layout.comments == 1 ? " line" : " lines") + "); PLOT3D has none, and other programs may refuse the file");
      }
    }
    tellBlanked(blocks, *run.ranks, warnings);
    for (const bsv::GridBlock& block : blocks)
    {
      mesh.blocks.push_back(bsv::meshBlock(block));
    }
    if (this->UseNeutralMap && layoutName != "CGNS")
    {
      // Steps of a series without one of their own have that of the first.
      std::string map = this->NeutralMapFile;
      for (const std::string& grid : { fileName, FirstFile(this->GetFileName()) })
      {
        const std::string extension = vtksys::SystemTools::GetFilenameLastExtension(grid);
        for (const std::string& stem : { grid.substr(0, grid.size() - extension.size()), grid })
        {
          for (const char* ending : { ".nmf", ".NMF", ".Nmf" })
          {
            const bool here = map.empty() && vtksys::SystemTools::FileExists(stem + ending, true);
            map = run.ranks->any(here) ? stem + ending : map;
          }
        }
      }
      if (!map.empty())
      {
        bsv::readNeutralMap(map, mesh, warnings, run);
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
    // The same blocks in all steps.
    bsv::tagBlocks(result, mesh, this->GetFileName());
    for (const bsv::HexZone& zone : hexZones)
    {
      addHexZone(result, zone);
    }
    output->ShallowCopy(result);
    this->FileLayout = layoutName;
    for (const std::string& warning : warnings)
    {
      if (run.ranks->rank() == 0)
      {
        vtkWarningMacro(<< fileName << ": " << warning);
      }
    }
    this->UpdateProgress(1.0);
    SetTime(output, step);
  });
  if (!success)
  {
    this->SetFileError(fileName);
  }
  return success;
}

//------------------------------------------------------------------------------
void vtkHexBlockMeshReader::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "UseNeutralMap: " << this->UseNeutralMap << "\n";
  os << indent << "NeutralMapFile: " << this->NeutralMapFile << "\n";
  os << indent << "Format: " << this->Format << "\n";
  os << indent << "ByteOrder: " << this->ByteOrder << "\n";
  os << indent << "Precision: " << this->Precision << "\n";
  os << indent << "IBlank: " << this->IBlank << "\n";
  os << indent << "FileLayout: " << this->FileLayout << "\n";
}
