// SPDX-License-Identifier: BSD-3-Clause
// The properties of the filter; the work is in vtkCatmullClarkToBSplineVolumeRequest.cxx.
#include "vtkCatmullClarkToBSplineVolume.h"

#include "Conversion/Conversion.h"
#include "Data/MeshInput.h"
#include "Execution/FilterExecution.h"

#include "vtkDataObject.h"
#include "vtkIdTypeArray.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkObjectFactory.h"

vtkStandardNewMacro(vtkCatmullClarkToBSplineVolume);

//------------------------------------------------------------------------------
vtkCatmullClarkToBSplineVolume::vtkCatmullClarkToBSplineVolume()
  : ControlPointsPerRule(vtkSmartPointer<vtkIdTypeArray>::New())
{
  this->SetNumberOfInputPorts(2);
  this->SetNumberOfOutputPorts(2);
  this->ResetReport();
}

//------------------------------------------------------------------------------
vtkCatmullClarkToBSplineVolume::~vtkCatmullClarkToBSplineVolume() = default;

//------------------------------------------------------------------------------
void vtkCatmullClarkToBSplineVolume::ResetReport()
{
  this->NumberOfInputBlocks = this->NumberOfBlocks = 0;
  this->NumberOfExtraordinaryEdges = this->NumberOfSingularNodes = 0;
  this->NumberOfControlPoints = 0;
  this->NumberOfCheckedSpans = this->NumberOfRepairedSpans = 0;
  this->NumberOfInvalidSpans = this->NumberOfUndecidedSpans = 0;
  this->ReceivedBytes = 0;
  this->ControlPointsPerRule->SetNumberOfValues(static_cast<vtkIdType>(bsv::ControlPointRule::Count));
  this->ControlPointsPerRule->Fill(0);
  this->Report.clear();
}

//------------------------------------------------------------------------------
void vtkCatmullClarkToBSplineVolume::AddBodyBoundary(const char* pattern)
{
  if (pattern && *pattern)
  {
    this->BodyBoundaries.emplace_back(pattern);
    this->BodySelection.forget();
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkCatmullClarkToBSplineVolume::ClearBodyBoundaries()
{
  this->BodyBoundaries.clear();
  this->BodySelection.forget();
  this->Modified();
}

//------------------------------------------------------------------------------
const char* vtkCatmullClarkToBSplineVolume::GetBodyBoundary(int index) const
{
  return index >= 0 && index < this->GetNumberOfBodyBoundaries() ? this->BodyBoundaries[index].c_str() : nullptr;
}

//------------------------------------------------------------------------------
void vtkCatmullClarkToBSplineVolume::AddSymmetryBoundary(const char* pattern)
{
  if (pattern && *pattern)
  {
    this->SymmetryBoundaries.emplace_back(pattern);
    this->SymmetrySelection.forget();
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkCatmullClarkToBSplineVolume::ClearSymmetryBoundaries()
{
  this->SymmetryBoundaries.clear();
  this->SymmetrySelection.forget();
  this->Modified();
}

//------------------------------------------------------------------------------
const char* vtkCatmullClarkToBSplineVolume::GetSymmetryBoundary(int index) const
{
  return index >= 0 && index < this->GetNumberOfSymmetryBoundaries() ? this->SymmetryBoundaries[index].c_str()
                                                                     : nullptr;
}

//------------------------------------------------------------------------------
void vtkCatmullClarkToBSplineVolume::AddBoundaryWallSpacing(const char* pattern, double spacing)
{
  if (pattern && *pattern)
  {
    this->BoundaryWallSpacings.emplace_back(pattern, spacing);
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkCatmullClarkToBSplineVolume::ClearBoundaryWallSpacings()
{
  this->BoundaryWallSpacings.clear();
  this->Modified();
}

//------------------------------------------------------------------------------
void vtkCatmullClarkToBSplineVolume::AddExtensionBlock(const char* pattern)
{
  if (pattern && *pattern)
  {
    this->ExtensionBlocks.emplace_back(pattern);
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkCatmullClarkToBSplineVolume::ClearExtensionBlocks()
{
  this->ExtensionBlocks.clear();
  this->Modified();
}

//------------------------------------------------------------------------------
void vtkCatmullClarkToBSplineVolume::AddBodyFace(int block, int face)
{
  this->BodyFaces.push_back({ block, face });
  this->Modified();
}

//------------------------------------------------------------------------------
void vtkCatmullClarkToBSplineVolume::ClearBodyFaces()
{
  this->BodyFaces.clear();
  this->Modified();
}

//------------------------------------------------------------------------------
vtkDataArray* vtkCatmullClarkToBSplineVolume::GetControlPointsPerRule()
{
  return this->ControlPointsPerRule;
}

//------------------------------------------------------------------------------
void vtkCatmullClarkToBSplineVolume::SetBodyConnection(vtkAlgorithmOutput* output)
{
  this->SetInputConnection(1, output);
}

//------------------------------------------------------------------------------
int vtkCatmullClarkToBSplineVolume::FillInputPortInformation(int, vtkInformation* info)
{
  bsv::acceptMissing(info);
  bsv::acceptMeshes(info);
  return 1;
}

//------------------------------------------------------------------------------
int vtkCatmullClarkToBSplineVolume::FillOutputPortInformation(int port, vtkInformation* info)
{
  info->Set(vtkDataObject::DATA_TYPE_NAME(), port == 0 ? "vtkPartitionedDataSetCollection" : "vtkTable");
  return 1;
}

//------------------------------------------------------------------------------
int vtkCatmullClarkToBSplineVolume::RequestInformation(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector*)
{
  vtkDataObject* mesh = vtkDataObject::GetData(inputVector[0], 0);
  this->BodySelection.offer(mesh, this->BodyBoundaries, bsv::defaultBodyBoundaries());
  this->SymmetrySelection.offer(mesh, this->SymmetryBoundaries, bsv::defaultSymmetryBoundaries());
  return 1;
}

//------------------------------------------------------------------------------
void vtkCatmullClarkToBSplineVolume::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  const auto list = [&](const char* name, const std::vector<std::string>& values) {
    os << indent << name << ':';
    for (const std::string& value : values)
    {
      os << ' ' << value;
    }
    os << '\n';
  };
  list("BodyBoundaries", this->BodyBoundaries);
  list("SymmetryBoundaries", this->SymmetryBoundaries);
  os << indent << "BodyFaces:";
  for (const auto& [block, face] : this->BodyFaces)
  {
    os << " (" << block << ", " << face << ')';
  }
  os << '\n';
  os << indent << "UseCreaseAngle: " << (this->UseCreaseAngle ? "On" : "Off") << '\n';
  os << indent << "CreaseAngle: " << this->CreaseAngle << '\n';
  os << indent << "CreaseContrast: " << this->CreaseContrast << '\n';
  os << indent << "CreasesInsideBlocks: " << this->CreasesInsideBlocks << '\n';
  os << indent << "PlanarSides: " << this->PlanarSides << '\n';
  os << indent << "PlanarTolerance: " << this->PlanarTolerance << '\n';
  os << indent << "Twist: " << this->Twist << '\n';
  os << indent << "Continuity: " << this->Continuity << '\n';
  os << indent << "WallSpacing: " << this->WallSpacing << '\n';
  os << indent << "WallSpacingMode: " << this->WallSpacingMode << '\n';
  os << indent << "BoundaryWallSpacings:";
  for (const auto& [pattern, spacing] : this->BoundaryWallSpacings)
  {
    os << ' ' << pattern << '=' << spacing;
  }
  os << '\n';
  os << indent << "WallSpacingArray: " << this->WallSpacingArray << '\n';
  os << indent << "FarFieldSpacing: " << this->FarFieldSpacing << '\n';
  list("ExtensionBlocks", this->ExtensionBlocks);
  os << indent << "PropagationRange: " << this->PropagationRange << '\n';
  os << indent << "CheckSpans: " << this->CheckSpans << '\n';
  os << indent << "RepairSpans: " << (this->RepairSpans ? "On" : "Off") << '\n';
  os << indent << "Untangle: " << (this->Untangle ? "On" : "Off") << '\n';
  os << indent << "InputPoints: " << this->InputPoints << '\n';
  os << indent << "FitTolerance: " << this->FitTolerance << '\n';
  os << indent << "FitIterations: " << this->FitIterations << '\n';
  os << indent << "MatchTolerance: " << this->MatchTolerance << '\n';
  os << indent << "AllowDegenerate: " << (this->AllowDegenerate ? "On" : "Off") << '\n';
  os << indent << "CheckJoins: " << (this->CheckJoins ? "On" : "Off") << '\n';
  os << indent << "AllowOpenInterior: " << (this->AllowOpenInterior ? "On" : "Off") << '\n';
  os << indent << "ReceivedBytes: " << this->ReceivedBytes << '\n';
  os << indent << "Report: " << this->Report << '\n';
}
