// SPDX-License-Identifier: BSD-3-Clause
#include "vtkNURBSSurfaceWriter.h"

#include "FilterExecution.h"
#include "NURBSSurfaceData.h"
#include "NURBSSurfaceFile.h"

#include "vtkDataObject.h"
#include "vtkErrorCode.h"
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
  const bool first = run.ranks->rank() == 0;
  if (this->FileName.empty())
  {
    if (first)
    {
      vtkErrorMacro("File Name is empty.");
    }
    this->SetErrorCode(vtkErrorCode::NoFileNameError);
    return;
  }
  try
  {
    // All ranks have the whole body then.
    run.ranks->together([&] {
      const std::vector<bsv::BodyPatch> patches = bsv::bodyPatches(this->GetInput(), *run.ranks);
      if (first)
      {
        bsv::writeNURBSSurfaceFile(patches, this->FileName);
      }
    });
  }
  catch (const std::exception& error)
  {
    if (first)
    {
      vtkErrorMacro(<< error.what());
    }
    this->SetErrorCode(vtkErrorCode::CannotOpenFileError);
  }
}
