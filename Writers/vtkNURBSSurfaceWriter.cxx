// SPDX-License-Identifier: BSD-3-Clause
#include "vtkNURBSSurfaceWriter.h"

#include "Data/BoundarySelection.h"
#include "Data/NURBSSurfaceData.h"
#include "Execution/FilterExecution.h"
#include "Formats/NURBSSurfaceFile.h"
#include "VolumeInput.h"
#include "WriteTogether.h"

#include "vtkDataObject.h"
#include "vtkFieldData.h"
#include "vtkInformation.h"
#include "vtkObjectFactory.h"
#include "vtkStringArray.h"

#include <array>
#include <utility>

vtkStandardNewMacro(vtkNURBSSurfaceWriter);

namespace
{

/// Names and metres, in the order of vtkNURBSSurfaceWriter::LengthUnitType; the names are those of the reader.
constexpr std::array<std::pair<const char*, double>, 8> Units{ { { "as in input", 0.0 }, { "metre", 1.0 },
  { "centimetre", 1e-2 }, { "millimetre", 1e-3 }, { "micrometre", 1e-6 }, { "kilometre", 1e3 }, { "inch", 0.0254 },
  { "foot", 0.3048 } } };

/// Metres per unit of the input; metres if it does not say.
double unitOf(vtkDataObject* input)
{
  vtkFieldData* fields = input ? input->GetFieldData() : nullptr;
  auto* unit = fields ? vtkStringArray::SafeDownCast(fields->GetAbstractArray("LengthUnit")) : nullptr;
  for (std::size_t n = 1; unit && unit->GetNumberOfValues() == 1 && n < Units.size(); ++n)
  {
    if (unit->GetValue(0) == Units[n].first)
    {
      return Units[n].second;
    }
  }
  return 1.0;
}

bsv::SurfacesToWrite wallOf(vtkDataObject* input, const bsv::BoundaryPatterns& patterns, const bsv::Execution& run)
{
  const bsv::BSplineVolumeBlocks blocks = bsv::bsplineVolumeBlocks(input, *run.ranks);
  bsv::requireVolumes(blocks);
  const bsv::VolumeToWrite volume = bsv::volumeToWrite(blocks, run);
  bsv::SurfacesToWrite surfaces = bsv::wallToWrite(
    volume, bsv::wallBoundaries(input, blocks.boundaryNames, blocks.boundaryTypes, patterns, *run.ranks), run);
  if (surfaces.patches.empty())
  {
    throw bsv::Error("no boundary of the volume is part of the wall: Body Boundaries are " + bsv::quotedList(patterns) +
      ", the volume has the boundaries " + bsv::quotedList(blocks.boundaryNames));
  }
  const std::vector<std::string> useless = bsv::uselessPatterns(
    "Body Boundaries", patterns, bsv::defaultBodyBoundaries(), blocks.boundaryNames, blocks.boundaryTypes);
  surfaces.notes.insert(surfaces.notes.end(), useless.begin(), useless.end());
  return surfaces;
}

} // namespace

//------------------------------------------------------------------------------
vtkNURBSSurfaceWriter::vtkNURBSSurfaceWriter()
  : BodyBoundaries(bsv::defaultBodyBoundaries())
{
}

//------------------------------------------------------------------------------
void vtkNURBSSurfaceWriter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "FileName: " << this->FileName << "\n";
  os << indent << "BodyBoundaries: " << bsv::quotedList(this->BodyBoundaries) << "\n";
  os << indent << "LengthUnit: " << Units[this->LengthUnit].first << "\n";
}

//------------------------------------------------------------------------------
void vtkNURBSSurfaceWriter::AddBodyBoundary(const char* pattern)
{
  if (pattern && *pattern)
  {
    this->BodyBoundaries.emplace_back(pattern);
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkNURBSSurfaceWriter::ClearBodyBoundaries()
{
  this->BodyBoundaries.clear();
  this->Modified();
}

//------------------------------------------------------------------------------
const char* vtkNURBSSurfaceWriter::GetBodyBoundary(int index) const
{
  return index >= 0 && index < this->GetNumberOfBodyBoundaries() ? this->BodyBoundaries[index].c_str() : nullptr;
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
int vtkNURBSSurfaceWriter::Write()
{
  this->SetErrorCode(
    bsv::writeOnAllRanks(this, this->FileName, this->WriteTime, [this] { return this->Superclass::Write(); }));
  return this->GetErrorCode() == vtkErrorCode::NoError ? 1 : 0;
}

//------------------------------------------------------------------------------
void vtkNURBSSurfaceWriter::WriteData()
{
  const bsv::Execution run = bsv::filterExecution(this);
  std::vector<std::string> notes;
  this->SetErrorCode(bsv::writeTogether(this, this->FileName, *run.ranks, [&] {
    vtkDataObject* input = this->GetInput();
    // All ranks have the whole body or wall then, or none writes.
    bsv::SurfacesToWrite surfaces;
    run.ranks->together([&] {
      surfaces = run.ranks->any(bsv::isVolume(input)) ? wallOf(input, this->BodyBoundaries, run)
                                                      : bsv::bodyToWrite(bsv::bodyPatches(input, *run.ranks));
    });
    if (run.ranks->rank() == 0)
    {
      const double metres = this->LengthUnit == AS_IN_INPUT ? unitOf(input) : Units[this->LengthUnit].second;
      bsv::writeNURBSSurfaceFile(surfaces, this->FileName, metres, run, notes);
    }
  }));
  if (this->GetErrorCode() == 0)
  {
    bsv::warn(this, notes);
  }
}
