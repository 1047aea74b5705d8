// SPDX-License-Identifier: BSD-3-Clause
#include "vtkNURBSSurfaceReader.h"

#include "Data/NURBSSurfaceData.h"
#include "Execution/PieceRequest.h"
#include "Formats/NURBSFile.h"

#include "vtkErrorCode.h"
#include "vtkFieldData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkIntArray.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkPolyData.h"
#include "vtkStringArray.h"

#include <cmath>
#include <sstream>

vtkStandardNewMacro(vtkNURBSSurfaceReader);

namespace
{

struct UnitEntry
{
  const char* name;
  double metres;
};

/// In the order of vtkNURBSSurfaceReader::LengthUnitType.
constexpr UnitEntry Units[] = { { "as in file", 0.0 }, { "metre", 1.0 }, { "centimetre", 1e-2 }, { "millimetre", 1e-3 },
  { "micrometre", 1e-6 }, { "kilometre", 1e3 }, { "inch", 0.0254 }, { "foot", 0.3048 } };

std::string unitName(double metres)
{
  if (!(metres > 0.0))
  {
    return "unknown";
  }
  for (const UnitEntry& unit : Units)
  {
    if (std::abs(unit.metres - metres) <= 1e-9 * metres)
    {
      return unit.name;
    }
  }
  std::ostringstream text;
  text << metres << " metre";
  return text.str();
}

void addString(vtkFieldData* fields, const char* name, const std::string& value)
{
  vtkNew<vtkStringArray> array;
  array->SetName(name);
  array->InsertNextValue(value);
  fields->AddArray(array);
}

} // namespace

//------------------------------------------------------------------------------
vtkNURBSSurfaceReader::vtkNURBSSurfaceReader() = default;

//------------------------------------------------------------------------------
void vtkNURBSSurfaceReader::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "LengthUnit: " << this->LengthUnit << "\n";
  os << indent << "FileUnit: " << this->FileUnit << "\n";
  os << indent << "TessellationTolerance: " << this->TessellationTolerance << "\n";
  os << indent << "Format: " << this->Format << "\n";
  os << indent << "DeclaredUnit: " << this->DeclaredUnit << "\n";
  os << indent << "NumberOfPatches: " << this->NumberOfPatches << "\n";
  os << indent << "NumberOfTrimmedPatches: " << this->NumberOfTrimmedPatches << "\n";
  os << indent << "NumberOfRationalPatches: " << this->NumberOfRationalPatches << "\n";
  os << indent << "NotRead: " << this->NotRead << "\n";
}

//------------------------------------------------------------------------------
int vtkNURBSSurfaceReader::CanReadFile(const char* fileName)
{
  const std::string format = fileName ? bsv::formatOfNURBSFile(FirstFile(fileName)) : std::string();
  return !format.empty() && (format == "GoTools g2" || bsv::canReadCADFiles()) ? 1 : 0;
}

//------------------------------------------------------------------------------
int vtkNURBSSurfaceReader::RequestData(vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector)
{
  auto* output = vtkPartitionedDataSetCollection::GetData(outputVector);
  this->SetErrorCode(vtkErrorCode::NoError);
  this->Format.clear();
  this->DeclaredUnit.clear();
  this->NotRead.clear();
  this->NumberOfPatches = this->NumberOfTrimmedPatches = this->NumberOfRationalPatches = 0;
  // Every rank has the whole body.
  const bsv::Piece piece = bsv::requestedPiece(outputVector->GetInformationObject(0));
  const bsv::Execution run = bsv::pieceExecution(this, piece, 0.0, 0.9);
  std::string fileName;
  const int success = bsv::execute(this, *run.ranks, [&] {
    const Step step = this->RequestedStep(outputVector);
    fileName = step.file;
    bsv::NURBSFileContent content = bsv::readNURBSFile(fileName, this->TessellationTolerance, run);

    const double fileUnit = this->FileUnit == AS_IN_FILE ? content.unit : Units[this->FileUnit].metres;
    double targetUnit = content.unit;
    if (this->LengthUnit != AS_IN_FILE)
    {
      if (!(fileUnit > 0.0))
      {
        throw bsv::Error(fileName + ": the file declares no unit of length that is known, so LengthUnit = " +
          Units[this->LengthUnit].name + " needs FileUnit to be set");
      }
      targetUnit = Units[this->LengthUnit].metres;
      // Units have short ratios; with them, a metre is a thousand millimetres to the last bit.
      const bool grows = fileUnit >= targetUnit;
      const double ratio = std::round((grows ? fileUnit / targetUnit : targetUnit / fileUnit) * 1e9) / 1e9;
      for (bsv::BodyPatch& patch : content.patches)
      {
        for (bsv::Vec3& point : patch.surface.points)
        {
          point = grows ? bsv::Vec3(point * ratio) : bsv::Vec3(point / ratio);
        }
      }
    }

    std::vector<int> vertexPatches;
    std::vector<bsv::Vec2> vertexParameters;
    for (const bsv::BodyTessellation::Vertex& vertex : content.tessellation.vertices)
    {
      vertexPatches.push_back(vertex.patch);
      vertexParameters.emplace_back(vertex.u, vertex.v);
    }
    const vtkSmartPointer<vtkPolyData> surface = bsv::bodySurface(content.patches, vertexPatches, vertexParameters,
      content.tessellation.triangles, bsv::filterExecution(this, 0.9, 1.0));
    bsv::setBody(output, content.patches, content.layers, surface);

    this->Format = content.format;
    this->DeclaredUnit = unitName(content.unit);
    this->NumberOfPatches = static_cast<int>(content.patches.size());
    for (const bsv::BodyPatch& patch : content.patches)
    {
      this->NumberOfTrimmedPatches += !patch.loops.empty();
      this->NumberOfRationalPatches += patch.surface.rational();
    }
    vtkNew<vtkStringArray> notRead;
    notRead->SetName("NotRead");
    vtkNew<vtkIntArray> notReadCount;
    notReadCount->SetName("NotReadCount");
    for (const auto& other : content.others)
    {
      notRead->InsertNextValue(other.first);
      notReadCount->InsertNextValue(other.second);
      this->NotRead += (this->NotRead.empty() ? "" : ", ") + std::to_string(other.second) + " " + other.first;
    }
    vtkFieldData* fields = output->GetFieldData();
    addString(fields, "Format", this->Format);
    addString(fields, "DeclaredUnit", this->DeclaredUnit);
    addString(fields, "LengthUnit", unitName(targetUnit));
    fields->AddArray(notRead);
    fields->AddArray(notReadCount);
    if (!this->NotRead.empty() && run.ranks->rank() == 0)
    {
      vtkWarningMacro(<< fileName << ": left out: " << this->NotRead);
    }
    for (const std::string& warning : content.warnings)
    {
      if (run.ranks->rank() == 0)
      {
        vtkWarningMacro(<< fileName << ": " << warning);
      }
    }
    if (content.approximated > 0 && run.ranks->rank() == 0)
    {
      vtkWarningMacro(<< fileName << ": " << content.approximated
                      << " faces have no exact NURBS form and were approximated");
    }
    SetTime(output, step);
  });
  if (!success)
  {
    this->SetFileError(fileName);
  }
  return success;
}
