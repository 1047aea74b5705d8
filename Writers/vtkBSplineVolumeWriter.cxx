// SPDX-License-Identifier: BSD-3-Clause
#include "vtkBSplineVolumeWriter.h"

#include "Data/BSplineVolumeData.h"
#include "Data/NURBSSurfaceData.h"
#include "Execution/FilterExecution.h"
#include "Formats/CellFormats.h"
#include "Formats/NURBSSurfaceFile.h"
#include "Formats/VolumeFormats.h"
#include "IO/FileParts.h"
#include "VolumeInput.h"
#include "WriteTogether.h"

#include "vtkDataObject.h"
#include "vtkInformation.h"
#include "vtkObjectFactory.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

vtkStandardNewMacro(vtkBSplineVolumeWriter);

//------------------------------------------------------------------------------
void vtkBSplineVolumeWriter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "FileName: " << this->FileName << "\n";
  os << indent << "CellOrder: " << this->CellOrder << "\n";
  os << indent << "GmshVersion: " << (this->GmshVersion == GMSH_2_2 ? "2.2" : "4.1") << "\n";
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeWriter::FillInputPortInformation(int, vtkInformation* info)
{
  info->Remove(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE());
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObjectTree");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkStructuredGrid");
  return 1;
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeWriter::Write()
{
  this->SetErrorCode(
    bsv::writeOnAllRanks(this, this->FileName, this->WriteTime, [this] { return this->Superclass::Write(); }));
  return this->GetErrorCode() == vtkErrorCode::NoError ? 1 : 0;
}

//------------------------------------------------------------------------------
void vtkBSplineVolumeWriter::WriteData()
{
  const bsv::Execution run = bsv::filterExecution(this);
  std::vector<std::string> notes;
  this->SetErrorCode(bsv::writeTogether(this, this->FileName, *run.ranks, [&] {
    std::string extension = std::filesystem::path(this->FileName).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
      [](char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); });
    const bool cells = extension == ".msh" || extension == ".h5" || extension == ".cgns";
    if (!cells && extension != ".mesh" && extension != ".xml" && extension != ".g2")
    {
      throw bsv::Error("File Name '" + this->FileName + "': the extension must be mesh, xml, g2, msh, h5 or cgns");
    }
    if (extension == ".g2" && run.ranks->any(bsv::isSurface(this->GetInput())))
    {
      bsv::SurfacesToWrite surfaces;
      run.ranks->together([&] { surfaces = bsv::bodyToWrite(bsv::bodyPatches(this->GetInput(), *run.ranks)); });
      if (run.ranks->rank() == 0)
      {
        bsv::writeNURBSSurfaceFile(surfaces, this->FileName, 1.0, run, notes);
      }
      return;
    }
    const bsv::BSplineVolumeBlocks blocks = bsv::bsplineVolumeBlocks(this->GetInput(), *run.ranks);
    bsv::requireVolumes(blocks);
    const bsv::VolumeToWrite volume = bsv::volumeToWrite(blocks, run);
    if (extension != ".g2")
    {
      // GoTools files have no topology; in all others a contact that is not joined would be a wall inside the volume.
      if (!blocks.hasInterfaces)
      {
        bsv::requireWholeContacts(blocks.volumes, volume.interfaces, bsv::contactSearch(blocks), run);
      }
      notes = volume.notes;
    }
    bsv::FileGroup files(run);
    bsv::AtomicFile& file = files.add(this->FileName);
    if (extension == ".mesh")
    {
      bsv::writeMFEM(volume, file, run, notes);
    }
    else if (extension == ".xml")
    {
      bsv::writeGismo(volume, file, run);
    }
    else if (extension == ".g2")
    {
      bsv::writeG2Volumes(volume, file, run);
    }
    else
    {
      const bsv::CurvedCells curved(volume, this->CellOrder, run);
      if (!curved.exact(*run.ranks))
      {
        notes.push_back("cells of order " + std::to_string(this->CellOrder) +
          " interpolate the volume, which has higher degrees or weights; they are not exact");
      }
      if (extension == ".msh")
      {
        bsv::writeGmsh(curved, file, this->GmshVersion == GMSH_2_2 ? bsv::GmshVersion::V2 : bsv::GmshVersion::V4, run);
      }
      else if (extension == ".h5")
      {
        bsv::writeHOPR(curved, file, run, notes);
      }
      else
      {
        bsv::writeCGNSCells(curved, file, 0.0, run, notes);
      }
    }
    files.publish();
  }));
  if (this->GetErrorCode() == 0)
  {
    bsv::warn(this, notes);
  }
}
