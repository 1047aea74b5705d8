// SPDX-License-Identifier: BSD-3-Clause
#include "vtkNURBSSurfaceWriter.h"

#include "Data/NURBSSurfaceData.h"
#include "Execution/FilterExecution.h"
#include "Formats/NURBSSurfaceFile.h"
#include "WriteTogether.h"

#include "vtkDataObject.h"
#include "vtkInformation.h"
#include "vtkObjectFactory.h"

vtkStandardNewMacro(vtkNURBSSurfaceWriter);

//------------------------------------------------------------------------------
void vtkNURBSSurfaceWriter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "FileName: " << this->FileName << "\n";
}

//------------------------------------------------------------------------------
int vtkNURBSSurfaceWriter::FillInputPortInformation(int, vtkInformation* info)
{
  info->Remove(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE());
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObjectTree");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkStructuredGrid");
  return 1;
}

//------------------------------------------------------------------------------
void vtkNURBSSurfaceWriter::WriteData()
{
  const bsv::Execution run = bsv::filterExecution(this);
  this->SetErrorCode(bsv::writeTogether(this, this->FileName, *run.ranks, [&] {
    // All ranks have the whole body then.
    const std::vector<bsv::BodyPatch> patches = bsv::bodyPatches(this->GetInput(), *run.ranks);
    if (run.ranks->rank() == 0)
    {
      bsv::writeNURBSSurfaceFile(patches, this->FileName);
    }
  }));
}
