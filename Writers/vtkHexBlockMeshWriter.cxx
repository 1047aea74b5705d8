// SPDX-License-Identifier: BSD-3-Clause
#include "vtkHexBlockMeshWriter.h"

#include "Data/HexBlockData.h"
#include "Data/MeshInput.h"
#include "Execution/FilterExecution.h"
#include "Formats/CGNSOutput.h"
#include "Formats/MeshToWrite.h"
#include "Formats/OpenFOAMOutput.h"
#include "Formats/Plot3DOutput.h"
#include "IO/FileParts.h"
#include "IO/TextOutput.h"
#include "Mesh/MeshCheck.h"
#include "Wall/FlowConditions.h"
#include "WriteTogether.h"

#include "vtkDataObject.h"
#include "vtkFieldData.h"
#include "vtkInformation.h"
#include "vtkIntArray.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"
#include "vtkStructuredGrid.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <sstream>

vtkStandardNewMacro(vtkHexBlockMeshWriter);

namespace
{

/// Metres, in the order of vtkHexBlockMeshWriter::LengthUnitType; 0: not known.
constexpr double Metres[] = { 0.0, 1.0, 0.01, 0.001, 0.0254, 0.3048 };

std::string lowerExtension(const std::string& fileName)
{
  std::string extension = std::filesystem::path(fileName).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
    [](char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); });
  return extension;
}

enum class MeshFormat
{
  CGNS,
  Plot3D,
  OpenFOAM
};

MeshFormat formatOf(const std::string& fileName)
{
  const std::string extension = lowerExtension(fileName);
  if (extension == ".cgns")
  {
    return MeshFormat::CGNS;
  }
  if (extension == ".foam")
  {
    return MeshFormat::OpenFOAM;
  }
  if (extension == ".xyz" || extension == ".x" || extension == ".p3d")
  {
    return MeshFormat::Plot3D;
  }
  throw bsv::Error("File Name '" + fileName + "': the extension must be cgns, xyz, x, p3d or foam");
}

/// The file of a level of several.
std::string levelFile(const std::string& fileName, MeshFormat format, int level)
{
  std::filesystem::path path(fileName);
  const std::string name = path.stem().string() + "_level" + std::to_string(level);
  const std::filesystem::path folder = format == MeshFormat::OpenFOAM ? path.parent_path() / name : path.parent_path();
  return (folder / (name + path.extension().string())).string();
}

/// The array `IBlank` of every block, null where it is missing.
std::vector<const int*> blankArrays(const std::vector<vtkSmartPointer<vtkStructuredGrid>>& grids)
{
  std::vector<const int*> arrays;
  for (const auto& grid : grids)
  {
    auto* array = grid ? vtkIntArray::SafeDownCast(grid->GetPointData()->GetArray("IBlank")) : nullptr;
    arrays.push_back(array && array->GetNumberOfComponents() == 1 ? array->GetPointer(0) : nullptr);
  }
  return arrays;
}

} // namespace

//------------------------------------------------------------------------------
void vtkHexBlockMeshWriter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "FileName: " << this->FileName << "\n";
  os << indent << "Encoding: " << this->Encoding << "\n";
  os << indent << "ByteOrder: " << this->ByteOrder << "\n";
  os << indent << "IBlank: " << this->IBlank << "\n";
  os << indent << "NeutralMap: " << (this->NeutralMap ? "On" : "Off") << "\n";
  os << indent << "Levels: " << this->Levels << "\n";
  os << indent << "LengthUnit: " << this->LengthUnit << "\n";
  os << indent << "ReynoldsNumber: " << this->ReynoldsNumber << "\n";
  os << indent << "ReferenceLength: " << this->ReferenceLength << "\n";
  os << indent << "LevelTable: " << this->LevelTable << "\n";
}

//------------------------------------------------------------------------------
int vtkHexBlockMeshWriter::FillInputPortInformation(int, vtkInformation* info)
{
  bsv::acceptMeshes(info);
  return 1;
}

//------------------------------------------------------------------------------
int vtkHexBlockMeshWriter::Write()
{
  this->SetErrorCode(
    bsv::writeOnAllRanks(this, this->FileName, this->WriteTime, [this] { return this->Superclass::Write(); }));
  return this->GetErrorCode() == vtkErrorCode::NoError ? 1 : 0;
}

//------------------------------------------------------------------------------
void vtkHexBlockMeshWriter::WriteData()
{
  const bsv::Execution run = bsv::filterExecution(this);
  std::vector<std::string> notes;
  this->LevelTable.clear();
  this->SetErrorCode(bsv::writeTogether(this, this->FileName, *run.ranks, [&] {
    const MeshFormat format = formatOf(this->FileName);
    if (format == MeshFormat::OpenFOAM && this->Encoding == FORTRAN_UNFORMATTED)
    {
      throw bsv::Error("Encoding: OpenFOAM has no Fortran unformatted files; use ASCII or Binary");
    }
    if (this->Levels > 1 && this->ReynoldsNumber > 0.0 && !(this->ReferenceLength > 0.0))
    {
      throw bsv::Error("Reference Length must be positive");
    }
    std::vector<vtkSmartPointer<vtkStructuredGrid>> grids;
    const bsv::BlockMesh mesh = bsv::blockMesh(this->GetInput(), grids, bsv::filterExecution(this, 0.0, 0.3));
    bsv::requireBlocks(mesh);
    bsv::checkFinitePoints(mesh, run);
    for (std::size_t b = 0; b < grids.size(); ++b)
    {
      if (grids[b] && grids[b]->GetFieldData()->HasArray("KnotsW"))
      {
        throw bsv::Error("block " + std::to_string(b) + " '" + mesh.blocks[b].name +
          "' is a B-spline volume, whose points are control points: sample it first (BSpline Volume Sampler), or write "
          "it with the BSpline Volume Writer");
      }
    }
    const std::vector<const int*> blanks = blankArrays(grids);
    bool allBlanked = true;
    for (std::size_t b = 0; b < blanks.size(); ++b)
    {
      allBlanked = allBlanked && (!grids[b] || blanks[b]);
    }
    bsv::Plot3DOutputOptions options;
    options.encoding = static_cast<bsv::MeshEncoding>(this->Encoding);
    options.bigEndian = this->ByteOrder == BIG_ENDIAN_ORDER;
    options.iblank = this->IBlank == WITH_IBLANK || (this->IBlank == AUTOMATIC_IBLANK && !run.ranks->any(!allBlanked));

    bsv::MeshToWrite finest = bsv::meshToWrite(mesh, blanks, run);
    finest.lengthUnit = Metres[this->LengthUnit];
    notes = finest.notes;
    bsv::FileGroup files(run);
    std::ostringstream table;
    table.precision(9);
    table << "level,file,blocks,points,cells,first_cell_smallest,first_cell_mean,first_cell_largest";
    table << (this->ReynoldsNumber > 0.0 ? ",yplus_smallest,yplus_mean,yplus_largest\n" : "\n");
    double total = 0.0;
    for (int level = 0; level < this->Levels; ++level)
    {
      total += std::pow(8.0, level - this->Levels + 1);
    }
    double done = 0.0;
    for (int level = 0; level < this->Levels; ++level)
    {
      const bool family = this->Levels > 1;
      const bsv::MeshToWrite coarse = bsv::coarsened(finest, 1 << (this->Levels - 1 - level));
      const std::string path = family ? levelFile(this->FileName, format, level) : this->FileName;
      const double share = std::pow(8.0, level - this->Levels + 1) / total;
      const bsv::Execution part = bsv::filterExecution(this, done, done + share);
      done += share;
      // The same for every level.
      std::vector<std::string> said;
      if (format == MeshFormat::CGNS)
      {
        bsv::writeCGNS(coarse, files.add(path), part, said);
      }
      else if (format == MeshFormat::OpenFOAM)
      {
        bsv::writeOpenFOAM(coarse, files, path, this->Encoding == BINARY, part, said);
        const std::string turned = bsv::turnedCellsNote(coarse, part);
        if (!turned.empty())
        {
          notes.push_back((family ? "level " + std::to_string(level) + ": " : "") + turned);
        }
      }
      else
      {
        if (this->NeutralMap)
        {
          const std::string map = std::filesystem::path(path).replace_extension(".nmf").string();
          bsv::writeNeutralMap(coarse, files.add(map), part, said);
        }
        bsv::writePlot3D(coarse, files.add(path), options, part);
      }
      if (level == 0)
      {
        notes.insert(notes.end(), said.begin(), said.end());
      }
      const bsv::FirstCells heights = bsv::firstCells(coarse, run);
      table << level << "," << std::filesystem::path(path).filename().string() << "," << coarse.blocks.size() << ","
            << coarse.pointCount() << "," << coarse.cellCount() << "," << heights.smallest << "," << heights.mean << ","
            << heights.largest;
      if (this->ReynoldsNumber > 0.0)
      {
        bsv::FlowConditions flow;
        flow.reynoldsNumber = this->ReynoldsNumber;
        flow.referenceLength = this->ReferenceLength;
        const double friction = bsv::plateLayer(flow, this->ReferenceLength).skinFriction;
        for (const double height : { heights.smallest, heights.mean, heights.largest })
        {
          table << "," << bsv::yPlus(flow, friction, height);
        }
      }
      table << "\n";
    }
    if (this->Levels > 1)
    {
      const std::filesystem::path path(this->FileName);
      bsv::AtomicFile& file = files.add((path.parent_path() / (path.stem().string() + "_levels.csv")).string());
      if (run.ranks->rank() == 0)
      {
        file.write(table.str());
      }
      this->LevelTable = table.str();
    }
    files.publish();
  }));
  if (this->GetErrorCode() == 0)
  {
    bsv::warn(this, notes);
  }
}
