// SPDX-License-Identifier: BSD-3-Clause
#include "vtkNURBSSurfaceWriter.h"

#include "NURBSSurfaceData.h"
#include "NURBSSurfaceFile.h"

#include "vtkDataObject.h"
#include "vtkErrorCode.h"
#include "vtkInformation.h"
#include "vtkMultiProcessController.h"
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
  vtkMultiProcessController* controller = vtkMultiProcessController::GetGlobalController();
  if (controller && controller->GetLocalProcessId() != 0)
  {
    return;
  }
  if (this->FileName.empty())
  {
    vtkErrorMacro("File Name is empty.");
    this->SetErrorCode(vtkErrorCode::NoFileNameError);
    return;
  }
  try
  {
    bsv::writeNURBSSurfaceFile(bsv::bodyPatches(this->GetInput()), this->FileName);
  }
  catch (const std::exception& error)
  {
    vtkErrorMacro(<< error.what());
    this->SetErrorCode(vtkErrorCode::CannotOpenFileError);
  }
}
