// SPDX-License-Identifier: BSD-3-Clause
#include "vtkBSplineVolumeSampler.h"

#include "Base/MemoryCheck.h"
#include "Data/BSplineVolumeData.h"
#include "Data/BoundarySelection.h"
#include "Data/HexBlockData.h"
#include "Execution/FilterExecution.h"
#include "Mesh/FlatFaces.h"
#include "Ranks/OwnedValues.h"
#include "Volume/Sampling.h"
#include "Volume/SpanClasses.h"
#include "Volume/VolumeInterfaces.h"
#include "Wall/FlowConditions.h"

#include "vtkDataObject.h"
#include "vtkDoubleArray.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkStructuredGrid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

vtkStandardNewMacro(vtkBSplineVolumeSampler);

namespace
{

vtkSmartPointer<vtkDoubleArray> triples(vtkIdType count)
{
  auto array = vtkSmartPointer<vtkDoubleArray>::New();
  array->SetNumberOfComponents(3);
  array->SetNumberOfTuples(count);
  return array;
}

/// Faces whose boundary is a wall.
std::vector<std::array<int, 2>> wallFaces(const bsv::BSplineVolumeBlocks& input, const bsv::BoundaryPatterns& patterns)
{
  std::vector<std::array<int, 2>> faces;
  for (const bsv::BoundaryPatch& patch : input.boundaries)
  {
    if (bsv::isBodyBoundary(patterns, input.boundaryNames, input.boundaryTypes, patch.tag))
    {
      faces.push_back({ patch.block, patch.face });
    }
  }
  return faces;
}

} // namespace

//------------------------------------------------------------------------------
void vtkBSplineVolumeSampler::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Level: " << this->Level << "\n";
  os << indent << "ComputeDerivatives: " << (this->ComputeDerivatives ? "On" : "Off") << "\n";
  os << indent << "WallLevel: " << this->WallLevel << "\n";
  os << indent << "WallLayers: " << this->WallLayers << "\n";
  os << indent << "TangentialLevel: " << this->TangentialLevel << "\n";
  os << indent << "FirstCellHeight: " << this->FirstCellHeight << "\n";
  os << indent << "TargetYPlus: " << this->TargetYPlus << "\n";
  os << indent << "ReynoldsNumber: " << this->ReynoldsNumber << "\n";
  os << indent << "ReferenceLength: " << this->ReferenceLength << "\n";
  os << indent << "ChordError: " << this->ChordError << "\n";
  os << indent << "BlockLevels:";
  for (const std::array<int, 3>& entry : this->BlockLevels)
  {
    os << " " << entry[0] << "," << entry[1] << "=" << entry[2];
  }
  os << "\n";
  os << indent << "BodyBoundaries: " << bsv::quotedList(this->BodyBoundaries) << "\n";
  os << indent << "Report: " << this->Report << "\n";
}

//------------------------------------------------------------------------------
void vtkBSplineVolumeSampler::AddBlockLevel(int block, int direction, int level)
{
  this->BlockLevels.push_back({ block, direction, level });
  this->Modified();
}

//------------------------------------------------------------------------------
void vtkBSplineVolumeSampler::ClearBlockLevels()
{
  if (!this->BlockLevels.empty())
  {
    this->BlockLevels.clear();
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkBSplineVolumeSampler::AddBodyBoundary(const char* pattern)
{
  if (pattern && *pattern)
  {
    this->BodyBoundaries.emplace_back(pattern);
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkBSplineVolumeSampler::ClearBodyBoundaries()
{
  this->BodyBoundaries.clear();
  this->Modified();
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeSampler::FillInputPortInformation(int, vtkInformation* info)
{
  bsv::acceptMissing(info);
  info->Remove(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE());
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObjectTree");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkStructuredGrid");
  return 1;
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeSampler::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  auto* output = vtkPartitionedDataSetCollection::GetData(outputVector, 0);
  if (!output)
  {
    vtkErrorMacro("The output is missing.");
    return 0;
  }
  this->Report.clear();
  std::vector<std::string> warnings;
  const int success = bsv::execute(this, [&] {
    const bsv::BSplineVolumeBlocks input =
      bsv::bsplineVolumeBlocks(bsv::requiredInput(inputVector, 0), *bsv::globalRanks());
    bsv::requireVolumes(input);
    const std::size_t blocks = input.volumes.size();

    warnings = bsv::uselessPatterns(
      "Body Boundaries", this->BodyBoundaries, bsv::defaultBodyBoundaries(), input.boundaryNames, input.boundaryTypes);

    // Levels, and the interfaces that join them.
    bsv::LevelRequest request;
    request.level = this->Level;
    request.walls = wallFaces(input, this->BodyBoundaries);
    request.wallLevel = this->WallLevel;
    request.wallLayers = this->WallLayers;
    request.tangentialLevel = this->TangentialLevel;
    request.firstCellHeight = this->FirstCellHeight;
    request.chordError = this->ChordError;
    for (const std::array<int, 3>& entry : this->BlockLevels)
    {
      request.blockLevels.push_back({ entry[0], entry[1], entry[2] });
    }
    if (this->TargetYPlus > 0.0)
    {
      bsv::FlowConditions flow;
      flow.reynoldsNumber = this->ReynoldsNumber;
      flow.referenceLength = this->ReferenceLength;
      bsv::referenceState(flow); // checks the ranges
      const double height =
        bsv::heightOf(flow, bsv::plateLayer(flow, this->ReferenceLength).skinFriction, this->TargetYPlus);
      request.firstCellHeight = request.firstCellHeight > 0.0 ? std::min(request.firstCellHeight, height) : height;
    }
    const bool byWall = this->WallLevel > this->Level || this->TangentialLevel > this->Level ||
      request.firstCellHeight > 0.0 || request.chordError > 0.0;
    const bool adaptive = byWall || !request.blockLevels.empty();
    std::vector<bsv::SpanLevels> levels;
    if (adaptive)
    {
      const bsv::Execution run = bsv::filterExecution(this, 0.0, 0.0);
      if (byWall && request.walls.empty() && warnings.empty())
      {
        warnings.push_back("Body Boundaries: none of " + bsv::quotedList(this->BodyBoundaries) +
          " is a boundary of the volume, which has " + bsv::quotedList(input.boundaryNames) +
          "; no span is refined at a wall");
      }
      const auto name = [&](int block) { return input.label(block); };
      std::vector<bsv::Interface> interfaces = input.interfaces;
      if (!input.hasInterfaces)
      {
        bsv::VolumeInterfaceOptions options;
        options.boundaries = input.boundaries;
        options.blockName = name;
        interfaces = bsv::findVolumeInterfaces(input.volumes, options, run);
      }
      bsv::ChosenLevels chosen = bsv::chooseLevels(input.volumes, interfaces, request, name, run);
      levels = std::move(chosen.levels);
      const std::array<double, 2> heights = bsv::firstCellHeights(input.volumes, levels, request.walls, run);
      std::ostringstream report;
      report.precision(4);
      for (const std::string& note : chosen.notes)
      {
        report << note << ".\n";
      }
      report << chosen.classes << " classes of parallel spans:";
      for (std::size_t level = 0; level < chosen.classesOfLevel.size(); ++level)
      {
        if (chosen.classesOfLevel[level] > 0)
        {
          report << " " << chosen.classesOfLevel[level] << " at level " << level << ";";
        }
      }
      double cells = 0.0;
      double uniform = 0.0;
      int highest = 0;
      for (const bsv::SpanLevels& block : levels)
      {
        for (const std::vector<int>& direction : block)
        {
          highest = std::max(highest, *std::max_element(direction.begin(), direction.end()));
        }
      }
      for (const bsv::SpanLevels& block : levels)
      {
        const bsv::Ijk counts = bsv::sampleCounts(block, "the volume");
        cells += (counts[0] - 1.0) * (counts[1] - 1.0) * (counts[2] - 1.0);
        uniform += std::ldexp(double(block[0].size()) * double(block[1].size()) * double(block[2].size()), 3 * highest);
      }
      report.precision(12);
      report << " " << cells << " cells; " << uniform << " at the uniform level " << highest << ".\n";
      if (!request.walls.empty())
      {
        report.precision(4);
        report << "First cells off the wall: " << heights[0] << " to " << heights[1] << " high.\n";
      }
      this->Report = report.str();
    }
    else
    {
      for (std::size_t b = 0; b < blocks; ++b)
      {
        levels.push_back(bsv::uniformLevels(input.volumes[b], this->Level, input.label(b)));
      }
    }

    std::vector<bsv::Ijk> counts;
    double total = 0.0;
    bsv::Index allPoints = 0, allCells = 0;
    for (std::size_t b = 0; b < blocks; ++b)
    {
      counts.push_back(bsv::sampleCounts(levels[b], input.label(b)));
      const double points = static_cast<double>(counts[b][0]) * counts[b][1] * counts[b][2];
      if (3.0 * points > static_cast<double>(std::numeric_limits<vtkIdType>::max()))
      {
        throw bsv::Error(input.label(b) + ": Level " + std::to_string(this->Level) + " has too many samples");
      }
      total += input.isHere(b) ? points : 0.0;
      allPoints += bsv::Index(counts[b][0]) * counts[b][1] * counts[b][2];
      allCells += bsv::Index(counts[b][0] - 1) * (counts[b][1] - 1) * (counts[b][2] - 1);
    }
    if (!adaptive)
    {
      this->Report = "Level " + std::to_string(this->Level) + ": " + std::to_string(allCells) + " cells in " +
        std::to_string(blocks) + " blocks, " + std::to_string(allPoints) + " points\n";
    }
    const int arrays = this->ComputeDerivatives ? 4 : 1;
    bsv::requireMemory(total * arrays * 3 * sizeof(double), "Level " + std::to_string(this->Level), "the samples");

    static constexpr std::array<std::array<int, 3>, 4> Orders{ { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } } };
    static constexpr const char* Names[4] = { "", "dXdU", "dXdV", "dXdW" };
    std::vector<vtkSmartPointer<vtkStructuredGrid>> grids(blocks);
    double done = 0.0;
    for (std::size_t b = 0; b < blocks; ++b)
    {
      if (!input.isHere(b))
      {
        continue;
      }
      vtkNew<vtkStructuredGrid> grid;
      grid->SetDimensions(counts[b].data());
      const vtkIdType size = vtkIdType(counts[b][0]) * counts[b][1] * counts[b][2];
      for (int a = 0; a < arrays; ++a)
      {
        const double share = static_cast<double>(size) / (total * arrays);
        vtkSmartPointer<vtkDoubleArray> values = triples(size);
        bsv::sample(input.volumes[b], levels[b], Orders[a], values->GetPointer(0),
          bsv::filterExecution(this, done, done + share));
        done += share;
        if (a == 0)
        {
          vtkNew<vtkPoints> points;
          points->SetData(values);
          grid->SetPoints(points);
        }
        else
        {
          values->SetName(Names[a]);
          grid->GetPointData()->AddArray(values);
        }
      }
      grids[b] = grid;
    }
    if (adaptive)
    {
      const bsv::Execution run = bsv::filterExecution(this, 1.0, 1.0);
      const std::vector<bsv::TurnedCells> turned = bsv::gatherFromOwners<bsv::TurnedCells>(
        *run.ranks, blocks, [&](std::size_t b) { return input.volumes[b].rank; },
        [&](std::size_t b) {
          auto* samples = vtkDoubleArray::SafeDownCast(grids[b]->GetPoints()->GetData());
          return bsv::turnedCells(bsv::GridView(samples->GetPointer(0), counts[b]), 1, run);
        });
      const std::string note = bsv::turnedCellsNote(turned, [&](std::size_t b) { return input.label(b); });
      if (!note.empty())
      {
        warnings.push_back(note);
        this->Report += note + ".\n";
      }
    }
    bsv::setBlocks(output, grids, input.names, "Samples");
    bsv::setWholeFaceContacts(output, input.interfaces, input.boundaries, input.boundaryNames, input.boundaryTypes);
  });
  bsv::warn(this, warnings);
  return success;
}
