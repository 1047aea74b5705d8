// SPDX-License-Identifier: BSD-3-Clause
#include "vtkBSplineVolumeSmoothness.h"

#include "Data/BSplineVolumeData.h"
#include "Data/BoundarySelection.h"
#include "Data/FaceBounds.h"
#include "Data/JoinOutput.h"
#include "Data/Verdict.h"
#include "Execution/FilterExecution.h"
#include "Quality/Smoothness.h"
#include "Volume/VolumeInterfaces.h"

#include "vtkDataObject.h"
#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkObjectFactory.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkPolyData.h"
#include "vtkStringArray.h"
#include "vtkTable.h"

#include <algorithm>

vtkStandardNewMacro(vtkBSplineVolumeSmoothness);

namespace
{

/// The ports.
struct Outputs
{
  vtkPartitionedDataSetCollection* interfaces;
  vtkPartitionedDataSetCollection* blocks;
  vtkTable* joins;
  vtkPolyData* curves;
  vtkPolyData* list;
  vtkTable* verdict;
};

/// Those of the input, or found where it has none.
std::vector<bsv::Interface> interfacesOf(
  const bsv::BSplineVolumeBlocks& input, double tolerance, const bsv::Execution& run)
{
  if (input.hasInterfaces)
  {
    return input.interfaces;
  }
  if (!(tolerance > 0.0 && tolerance < 0.5))
  {
    throw bsv::Error("MatchTolerance must lie between 0 and 0.5, not " + std::to_string(tolerance));
  }
  bsv::VolumeInterfaceOptions search;
  search.tolerance = tolerance;
  search.boundaries = input.boundaries;
  search.blockName = [&](int block) { return input.label(block); };
  return bsv::findVolumeInterfaces(input.volumes, search, run);
}

void requireSampleMemory(
  const bsv::BSplineVolumeBlocks& input, const std::vector<bsv::Interface>& interfaces, int samplesPerSpan)
{
  double samples = 0.0;
  for (const bsv::Interface& contact : interfaces)
  {
    const bsv::BSplineVolume& volume = input.volumes[contact.blockA];
    double product = input.isHere(contact.blockA) ? 1.0 : 0.0;
    for (int axis = 0; axis < 2; ++axis)
    {
      const int d = bsv::faceAxis(contact.faceA, axis);
      product *= static_cast<double>(samplesPerSpan) *
          static_cast<double>(bsv::nonEmptySpans(volume.degree[d], volume.knots[d]).size()) +
        1.0;
    }
    samples += product;
  }
  // Measured and as arrays: a point, the jumps, a quadrilateral.
  bsv::requireMemory(samples * (2 * (3 + bsv::JumpKinds) + 5) * sizeof(double),
    "Samples Per Span " + std::to_string(samplesPerSpan), "the samples");
}

/// One surface per interface, of which `count` come first among the joins; the samples go.
void fillInterfaces(vtkPartitionedDataSetCollection* output, bsv::SmoothnessResult& result, std::size_t count,
  const bsv::BSplineVolumeBlocks& input, int samplesPerSpan, const bsv::Execution& run)
{
  std::vector<vtkSmartPointer<vtkPolyData>> surfaces;
  std::vector<std::string> names;
  for (std::size_t n = 0; n < count; ++n)
  {
    run.report(static_cast<double>(n) / static_cast<double>(count));
    bsv::Join& join = result.joins[n];
    surfaces.push_back(
      input.isHere(join.sides[0].block) ? bsv::interfaceSurface(join, static_cast<int>(n), samplesPerSpan) : nullptr);
    names.push_back(input.names[join.sides[0].block] + "|" + input.names[join.sides[1].block]);
    // Not twice in memory.
    join.points = {};
    join.values = {};
    join.spanMaxima = {};
  }
  bsv::setParts(output, surfaces, names, "Interfaces");
}

/// One skin per block, or its edges.
void fillBlocks(vtkPartitionedDataSetCollection* output, const bsv::SmoothnessResult& result,
  const bsv::BSplineVolumeBlocks& input, bool skins, int samplesPerSpan, const bsv::Execution& run)
{
  std::vector<vtkSmartPointer<vtkPolyData>> surfaces;
  std::vector<int> rowOf(result.joins.size() + 1, -1);
  for (std::size_t row = 0; row < result.ranking.size(); ++row)
  {
    rowOf[result.ranking[row]] = static_cast<int>(row);
  }
  for (std::size_t b = 0; b < input.volumes.size(); ++b)
  {
    run.report(static_cast<double>(b) / input.volumes.size());
    const int worst = result.blocks[b].worstJoin;
    surfaces.push_back(nullptr);
    if (!input.isHere(b))
    {
      continue;
    }
    surfaces.back() = skins ? bsv::skin(input.volumes[b], samplesPerSpan) : bsv::wires(input.volumes[b], 2);
    bsv::setBlockJumps(surfaces.back(), result.blocks[b], worst < 0 ? -1 : rowOf[worst]);
  }
  bsv::setParts(output, surfaces, input.names, "Blocks");
}

} // namespace

//------------------------------------------------------------------------------
vtkBSplineVolumeSmoothness::vtkBSplineVolumeSmoothness()
  : JoinList(vtkSmartPointer<vtkStringArray>::New())
{
  this->SetNumberOfOutputPorts(6);
}

//------------------------------------------------------------------------------
vtkBSplineVolumeSmoothness::~vtkBSplineVolumeSmoothness() = default;

//------------------------------------------------------------------------------
vtkStringArray* vtkBSplineVolumeSmoothness::GetJoinList()
{
  return this->JoinList;
}

//------------------------------------------------------------------------------
void vtkBSplineVolumeSmoothness::AddBodyBoundary(const char* pattern)
{
  if (pattern && *pattern)
  {
    this->BodyBoundaries.emplace_back(pattern);
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkBSplineVolumeSmoothness::ClearBodyBoundaries()
{
  this->BodyBoundaries.clear();
  this->Modified();
}

//------------------------------------------------------------------------------
const char* vtkBSplineVolumeSmoothness::GetBodyBoundary(int index) const
{
  return index >= 0 && index < this->GetNumberOfBodyBoundaries() ? this->BodyBoundaries[index].c_str() : nullptr;
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeSmoothness::FillInputPortInformation(int, vtkInformation* info)
{
  bsv::acceptMissing(info);
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObjectTree");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkStructuredGrid");
  return 1;
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeSmoothness::FillOutputPortInformation(int port, vtkInformation* info)
{
  static constexpr const char* Types[6] = { "vtkPartitionedDataSetCollection", "vtkPartitionedDataSetCollection",
    "vtkTable", "vtkPolyData", "vtkPolyData", "vtkTable" };
  info->Set(vtkDataObject::DATA_TYPE_NAME(), Types[port]);
  return 1;
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeSmoothness::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  Outputs output{ vtkPartitionedDataSetCollection::GetData(outputVector, 0),
    vtkPartitionedDataSetCollection::GetData(outputVector, 1), vtkTable::GetData(outputVector, 2),
    vtkPolyData::GetData(outputVector, 3), vtkPolyData::GetData(outputVector, 4), vtkTable::GetData(outputVector, 5) };
  if (!output.interfaces || !output.blocks || !output.joins || !output.curves || !output.list || !output.verdict)
  {
    vtkErrorMacro("An output is missing.");
    return 0;
  }

  this->MaximumGap = this->MaximumNormalJump = this->MaximumLayerJump = this->MaximumKink = this->MaximumC1Jump =
    this->MaximumC2Jump = 0.0;
  this->NumberOfInterfaces = this->NumberOfWallBorders = this->NumberOfExtraordinaryCurves = 0;
  this->Report.clear();
  this->JoinList->Initialize();
  bsv::setText(output.verdict, "");

  return bsv::execute(this, [&] {
    const bsv::BSplineVolumeBlocks input =
      bsv::bsplineVolumeBlocks(bsv::requiredInput(inputVector, 0), *bsv::globalRanks());
    bsv::requireVolumes(input);
    const std::vector<bsv::Interface> interfaces =
      interfacesOf(input, this->MatchTolerance, bsv::filterExecution(this, 0.0, 0.1));

    bsv::warn(this,
      bsv::uselessPatterns("Body Boundaries", this->BodyBoundaries, bsv::defaultBodyBoundaries(), input.boundaryNames,
        input.boundaryTypes));
    const std::vector<bool> wall = bsv::facesOf(input,
      bsv::wallBoundaries(vtkDataObject::GetData(inputVector[0], 0), input.boundaryNames, input.boundaryTypes,
        this->BodyBoundaries, *bsv::globalRanks()));
    const bool all = this->AllOuterFaces || std::find(wall.begin(), wall.end(), true) == wall.end();
    bsv::SmoothnessOptions options;
    options.samplesPerSpan = this->SamplesPerSpan;
    requireSampleMemory(input, interfaces, this->SamplesPerSpan);
    options.creaseAngle = this->CreaseAngle;
    options.gapTolerance = this->GapTolerance;
    options.tolerance = this->Tolerance;
    options.isWall = [&](int block, int face) { return all || wall[6 * block + face]; };
    options.rules = input.rules;
    options.blockName = [&](int block) { return input.label(block); };
    bsv::SmoothnessResult result =
      bsv::measureSmoothness(input.volumes, interfaces, options, bsv::filterExecution(this, 0.1, 0.7));

    // The tables of all ranks are shown as one.
    bsv::fillJoinTable(output.joins, result, input.names, bsv::globalRanks()->rank() == 0);
    bsv::fillCurves(output.curves, result, input);
    bsv::fillJoinList(output.list, this->JoinList, result, input,
      all ? Eigen::AlignedBox3d() : bsv::faceBounds(input, wall, *bsv::globalRanks()), *bsv::globalRanks());
    const auto borders =
      std::find_if(result.joins.begin(), result.joins.end(), [](const bsv::Join& join) { return join.border(); });
    const std::size_t count = borders - result.joins.begin();
    fillInterfaces(output.interfaces, result, count, input, this->SamplesPerSpan, bsv::filterExecution(this, 0.7, 0.9));
    fillBlocks(
      output.blocks, result, input, this->BlockSkins, this->SamplesPerSpan, bsv::filterExecution(this, 0.9, 1.0));

    double* totals[] = { &this->MaximumGap, &this->MaximumNormalJump, &this->MaximumLayerJump, &this->MaximumKink,
      &this->MaximumC1Jump, &this->MaximumC2Jump };
    for (std::size_t m = 0; m < bsv::joinMeasures().size(); ++m)
    {
      const bsv::JoinMeasure& measure = bsv::joinMeasures()[m];
      *totals[m] = bsv::largest(measure, [&](int kind) { return result.worst[kind]; });
      output.interfaces->GetFieldData()->AddArray(
        bsv::filled<vtkDoubleArray>(std::string("Maximum") + measure.name, 1, *totals[m]));
    }
    this->NumberOfInterfaces = static_cast<int>(count);
    this->NumberOfWallBorders = static_cast<int>(result.joins.size() - count);
    this->NumberOfExtraordinaryCurves = static_cast<int>(result.curves.size());
    const std::string text = bsv::smoothnessVerdict(result, input.names);
    bsv::setText(output.verdict, text);
    this->Report = text + '\n' + bsv::smoothnessReport(result, input.names);
    this->UpdateProgress(1.0);
  });
}

//------------------------------------------------------------------------------
void vtkBSplineVolumeSmoothness::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "SamplesPerSpan: " << this->SamplesPerSpan << '\n';
  os << indent << "BodyBoundaries: " << bsv::quotedList(this->BodyBoundaries) << '\n';
  os << indent << "AllOuterFaces: " << (this->AllOuterFaces ? "On" : "Off") << '\n';
  os << indent << "CreaseAngle: " << this->CreaseAngle << '\n';
  os << indent << "GapTolerance: " << this->GapTolerance << '\n';
  os << indent << "Tolerance: " << this->Tolerance << '\n';
  os << indent << "MatchTolerance: " << this->MatchTolerance << '\n';
  os << indent << "BlockSkins: " << (this->BlockSkins ? "On" : "Off") << '\n';
  os << indent << "Report: " << this->Report << '\n';
}
