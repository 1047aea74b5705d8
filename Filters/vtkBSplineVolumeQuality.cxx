// SPDX-License-Identifier: BSD-3-Clause
#include "vtkBSplineVolumeQuality.h"

#include "Data/BSplineVolumeData.h"
#include "Data/BoundarySelection.h"
#include "Data/HexBlockData.h"
#include "Data/Verdict.h"
#include "Execution/FilterExecution.h"
#include "Quality/JacobianBounds.h"
#include "Quality/SpanShape.h"
#include "Volume/Sampling.h"
#include "Volume/VolumeInterfaces.h"

#include "vtkCellArray.h"
#include "vtkCellData.h"
#include "vtkDataObject.h"
#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkIdTypeArray.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkIntArray.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkStringArray.h"
#include "vtkStructuredGrid.h"
#include "vtkTable.h"
#include "vtkUnsignedCharArray.h"

#include <algorithm>

vtkStandardNewMacro(vtkBSplineVolumeQuality);

namespace
{

using bsv::Ijk;
using bsv::Index;

template <typename Array>
vtkSmartPointer<Array> namedArray(const char* name, vtkIdType tuples, int components = 1)
{
  auto array = vtkSmartPointer<Array>::New();
  array->SetName(name);
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(tuples);
  return array;
}

/// Corners of the spans of a block, and the arrays that belong to its spans.
struct BlockSpans
{
  Ijk corners;
  Ijk spans;
  vtkNew<vtkStructuredGrid> grid;
  const double* points = nullptr;

  vtkIdType count() const { return vtkIdType(this->spans[0]) * this->spans[1] * this->spans[2]; }
  Index number(const Ijk& span) const { return span[0] + this->spans[0] * (span[1] + Index(this->spans[1]) * span[2]); }
  Ijk span(Index number) const
  {
    const Index row = number / this->spans[0];
    return { static_cast<int>(number % this->spans[0]), static_cast<int>(row % this->spans[1]),
      static_cast<int>(row / this->spans[1]) };
  }
  double size(const Ijk& span, int direction) const
  {
    return bsv::spanSize(this->points, this->corners, span, direction);
  }
  /// Adds a cell array.
  double* add(const char* name, int components = 1)
  {
    auto array = namedArray<vtkDoubleArray>(name, this->count(), components);
    this->grid->GetCellData()->AddArray(array);
    return array->GetPointer(0);
  }
};

/// What all ranks know of a block.
struct BlockSummary
{
  Index valid, invalid, undecided;
  double lowest, lowestScaled;
  bool leftHanded;
};

/// Where the spans of one face go on: the spans of the other face.
struct Neighbour
{
  int block = -1;
  int face = 0;
  int orientation = 0;
};

/// Span (s, t) of a face, in its axes.
Ijk faceSpan(const Ijk& spans, int face, int s, int t)
{
  Ijk ijk{};
  ijk[bsv::faceDirection(face)] = bsv::faceSide(face) ? spans[bsv::faceDirection(face)] - 1 : 0;
  ijk[bsv::faceAxis(face, 0)] = s;
  ijk[bsv::faceAxis(face, 1)] = t;
  return ijk;
}

/// The neighbour at every face of every block.
std::vector<std::array<Neighbour, 6>> neighbours(
  const std::vector<bsv::Interface>& interfaces, const std::vector<BlockSpans>& blocks)
{
  std::vector<std::array<Neighbour, 6>> result(blocks.size());
  for (const bsv::Interface& contact : interfaces)
  {
    const BlockSpans& a = blocks[contact.blockA];
    const BlockSpans& b = blocks[contact.blockB];
    const int swap = bsv::swapsAxes(contact.orientation) ? 1 : 0;
    if (a.spans[bsv::faceAxis(contact.faceA, 0)] == b.spans[bsv::faceAxis(contact.faceB, swap)] &&
      a.spans[bsv::faceAxis(contact.faceA, 1)] == b.spans[bsv::faceAxis(contact.faceB, 1 - swap)])
    {
      result[contact.blockA][contact.faceA] = { contact.blockB, contact.faceB, contact.orientation };
      result[contact.blockB][contact.faceB] = { contact.blockA, contact.faceA,
        bsv::inverseOrientation(contact.orientation) };
    }
  }
  return result;
}

/// Per face of a block the sizes, across it, of the spans of the face that it meets, first axis there fastest.
using SizesBeyond = std::array<std::vector<double>, 6>;

/// Of every block on this rank. Collective.
std::vector<SizesBeyond> sizesBeyond(const std::vector<BlockSpans>& blocks,
  const std::vector<std::array<Neighbour, 6>>& around, const bsv::BSplineVolumeBlocks& input, const bsv::Ranks& ranks)
{
  std::vector<SizesBeyond> sizes(blocks.size());
  // All ranks go over all pairs in one order: nobody needs to ask.
  const auto overContacts = [&](const auto& visit) {
    for (std::size_t b = 0; b < blocks.size(); ++b)
    {
      for (int face = 0; face < 6; ++face)
      {
        if (around[b][face].block >= 0)
        {
          visit(static_cast<int>(b), face, around[b][face]);
        }
      }
    }
  };
  std::vector<std::vector<double>> toRank(ranks.size());
  overContacts([&](int b, int face, const Neighbour& other) {
    if (!input.isHere(other.block))
    {
      return;
    }
    const BlockSpans& block = blocks[other.block];
    std::vector<double>& to = input.isHere(b) ? sizes[b][face] : toRank[input.ranks[b]];
    for (int t = 0; t < block.spans[bsv::faceAxis(other.face, 1)]; ++t)
    {
      for (int s = 0; s < block.spans[bsv::faceAxis(other.face, 0)]; ++s)
      {
        to.push_back(block.size(faceSpan(block.spans, other.face, s, t), bsv::faceDirection(other.face)));
      }
    }
  });
  const std::vector<std::vector<double>> received = ranks.exchange(toRank);
  std::vector<std::size_t> next(ranks.size(), 0);
  overContacts([&](int b, int face, const Neighbour& other) {
    if (input.isHere(b) && !input.isHere(other.block))
    {
      const Ijk& spans = blocks[other.block].spans;
      const int from = input.ranks[other.block];
      const auto begin = received[from].begin() + next[from];
      next[from] += std::size_t(spans[bsv::faceAxis(other.face, 0)]) * spans[bsv::faceAxis(other.face, 1)];
      sizes[b][face].assign(begin, received[from].begin() + next[from]);
    }
  });
  return sizes;
}

/// `AspectRatio` and `GrowthRatio`.
void addSizes(
  BlockSpans& block, const std::array<Neighbour, 6>& around, const SizesBeyond& beyond, const bsv::Execution& run)
{
  // Size, across the interface, of the span that `span` meets at `face`.
  const auto sizeBeyond = [&](const Ijk& span, int face) {
    const int orientation = around[face].orientation;
    const int axes[2] = { bsv::faceAxis(face, 0), bsv::faceAxis(face, 1) };
    const int last[2] = { block.spans[axes[0]] - 1, block.spans[axes[1]] - 1 };
    const std::array<int, 2> st = bsv::mapFacePoint(orientation, span[axes[0]], span[axes[1]], last[0], last[1]);
    const Index row = last[bsv::swapsAxes(orientation) ? 1 : 0] + 1;
    return beyond[face][st[0] + row * st[1]];
  };
  double* aspect = block.add("AspectRatio");
  double* growth = block.add("GrowthRatio", 3);
  run.parallelFor(block.count(), 1024, [&](Index begin, Index end) {
    for (Index n = begin; n < end; ++n)
    {
      const Ijk span = block.span(n);
      aspect[n] = bsv::spanAspectRatio(block.points, block.corners, span);
      for (int d = 0; d < 3; ++d)
      {
        const double size = block.size(span, d);
        double worst = 1.0;
        for (int side = 0; side < 2 && worst > 0.0; ++side)
        {
          Ijk next = span;
          next[d] += side == 0 ? -1 : 1;
          const int face = 2 * d + side;
          double ratio = 1.0;
          if (next[d] >= 0 && next[d] < block.spans[d])
          {
            ratio = bsv::sizeRatio(size, block.size(next, d));
          }
          else if (around[face].block >= 0)
          {
            ratio = bsv::sizeRatio(size, sizeBeyond(span, face));
          }
          worst = ratio > 0.0 ? std::max(worst, ratio) : 0.0;
        }
        growth[3 * n + d] = worst;
      }
    }
  });
}

/// `FirstCellHeight` at the faces of a block that are walls.
void addHeights(BlockSpans& block, const std::vector<int>& wallFaces)
{
  double* height = block.add("FirstCellHeight");
  std::fill(height, height + block.count(), 0.0);
  for (const int face : wallFaces)
  {
    for (int t = 0; t < block.spans[bsv::faceAxis(face, 1)]; ++t)
    {
      for (int s = 0; s < block.spans[bsv::faceAxis(face, 0)]; ++s)
      {
        const Ijk span = faceSpan(block.spans, face, s, t);
        const double found = bsv::spanHeight(block.points, block.corners, span, face);
        double& kept = height[block.number(span)];
        kept = kept > 0.0 ? std::min(kept, found) : found;
      }
    }
  }
}

/// Points of all witnesses with their arrays.
void addWitnesses(
  const bsv::BSplineVolumeBlocks& input, const std::vector<bsv::JacobianReport>& reports, vtkPolyData* data)
{
  vtkIdType count = 0;
  for (const bsv::JacobianReport& report : reports)
  {
    count += static_cast<vtkIdType>(report.witnesses.size());
  }
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(count);
  vtkNew<vtkCellArray> vertices;
  const auto block = namedArray<vtkIntArray>("BlockId", count);
  const auto span = namedArray<vtkIntArray>("Span", count, 3);
  const auto uvw = namedArray<vtkDoubleArray>("UVW", count, 3);
  const auto jacobian = namedArray<vtkDoubleArray>("Jacobian", count);
  vtkIdType at = 0;
  for (std::size_t b = 0; b < reports.size(); ++b)
  {
    for (const bsv::JacobianWitness& witness : reports[b].witnesses)
    {
      points->SetPoint(at, bsv::evaluate(input.volumes[b], witness.uvw).data());
      vertices->InsertNextCell({ at });
      block->SetValue(at, static_cast<int>(b));
      span->SetTypedTuple(at, witness.ijk.data());
      uvw->SetTypedTuple(at, witness.uvw.data());
      jacobian->SetValue(at, witness.value);
      ++at;
    }
  }
  data->SetPoints(points);
  data->SetVerts(vertices);
  for (vtkDataArray* array : std::initializer_list<vtkDataArray*>{ block, span, uvw, jacobian })
  {
    data->GetPointData()->AddArray(array);
  }
}

/// The six sides of every span that is not proven valid, between straight edges.
void addFindings(const std::vector<vtkSmartPointer<vtkStructuredGrid>>& grids, vtkPolyData* data)
{
  // Corners of a cell in the order of vtkStructuredGrid, side by side.
  static constexpr int Sides[6][4] = { { 0, 3, 7, 4 }, { 1, 2, 6, 5 }, { 0, 1, 5, 4 }, { 3, 2, 6, 7 }, { 0, 1, 2, 3 },
    { 4, 5, 6, 7 } };
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  vtkNew<vtkCellArray> quads;
  const auto validity = namedArray<vtkUnsignedCharArray>("Validity", 0);
  const auto block = namedArray<vtkIntArray>("BlockId", 0);
  const auto span = namedArray<vtkIntArray>("Span", 0, 3);
  for (std::size_t b = 0; b < grids.size(); ++b)
  {
    if (!grids[b])
    {
      continue;
    }
    auto* values = vtkUnsignedCharArray::SafeDownCast(grids[b]->GetCellData()->GetArray("Validity"));
    int size[3];
    grids[b]->GetDimensions(size);
    const vtkIdType row = size[0], layer = vtkIdType(size[0]) * size[1];
    for (vtkIdType cell = 0; cell < values->GetNumberOfValues(); ++cell)
    {
      if (values->GetValue(cell) == 0)
      {
        continue;
      }
      const int ijk[3] = { static_cast<int>(cell % (size[0] - 1)),
        static_cast<int>(cell / (size[0] - 1) % (size[1] - 1)),
        static_cast<int>(cell / (size[0] - 1) / (size[1] - 1)) };
      const vtkIdType corner = ijk[0] + row * ijk[1] + layer * ijk[2];
      const vtkIdType corners[8] = { corner, corner + 1, corner + 1 + row, corner + row, corner + layer,
        corner + 1 + layer, corner + 1 + row + layer, corner + row + layer };
      vtkIdType ids[8];
      for (int n = 0; n < 8; ++n)
      {
        double x[3];
        grids[b]->GetPoint(corners[n], x);
        ids[n] = points->InsertNextPoint(x);
      }
      for (const auto& side : Sides)
      {
        quads->InsertNextCell({ ids[side[0]], ids[side[1]], ids[side[2]], ids[side[3]] });
        validity->InsertNextValue(values->GetValue(cell));
        block->InsertNextValue(static_cast<int>(b));
        span->InsertNextTypedTuple(ijk);
      }
    }
  }
  data->SetPoints(points);
  data->SetPolys(quads);
  for (vtkDataArray* array : std::initializer_list<vtkDataArray*>{ validity, block, span })
  {
    data->GetCellData()->AddArray(array);
  }
  data->GetCellData()->SetActiveScalars("Validity");
}

std::string verdictText(vtkIdType spans, vtkIdType invalid, vtkIdType undecided)
{
  if (invalid + undecided == 0)
  {
    return "All " + std::to_string(spans) + " spans are valid";
  }
  std::string text = std::to_string(invalid) + " of " + std::to_string(spans) + " spans are invalid";
  return undecided > 0 ? text + ", " + std::to_string(undecided) + " undecided" : text;
}

} // namespace

//------------------------------------------------------------------------------
vtkBSplineVolumeQuality::vtkBSplineVolumeQuality()
{
  this->SetNumberOfOutputPorts(4);
}

//------------------------------------------------------------------------------
void vtkBSplineVolumeQuality::AddBodyBoundary(const char* pattern)
{
  if (pattern && *pattern)
  {
    this->BodyBoundaries.emplace_back(pattern);
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkBSplineVolumeQuality::ClearBodyBoundaries()
{
  this->BodyBoundaries.clear();
  this->Modified();
}

//------------------------------------------------------------------------------
const char* vtkBSplineVolumeQuality::GetBodyBoundary(int index) const
{
  return index >= 0 && index < this->GetNumberOfBodyBoundaries() ? this->BodyBoundaries[index].c_str() : nullptr;
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeQuality::FillInputPortInformation(int, vtkInformation* info)
{
  bsv::acceptMissing(info);
  info->Remove(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE());
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObjectTree");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkStructuredGrid");
  return 1;
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeQuality::FillOutputPortInformation(int port, vtkInformation* info)
{
  static constexpr const char* Types[4] = { "vtkPartitionedDataSetCollection", "vtkPolyData", "vtkPolyData",
    "vtkTable" };
  info->Set(vtkDataObject::DATA_TYPE_NAME(), Types[port]);
  return 1;
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeQuality::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  auto* output = vtkPartitionedDataSetCollection::GetData(outputVector, 0);
  auto* witnesses = vtkPolyData::GetData(outputVector, 1);
  auto* findings = vtkPolyData::GetData(outputVector, 2);
  auto* verdict = vtkTable::GetData(outputVector, 3);
  if (!output || !witnesses || !findings || !verdict)
  {
    vtkErrorMacro("An output is missing.");
    return 0;
  }
  this->NumberOfSpans = this->NumberOfValidSpans = this->NumberOfInvalidSpans = this->NumberOfUndecidedSpans = 0;
  this->MinimumJacobian = this->MinimumScaledJacobian = 0.0;
  this->WorstBlock = -1;
  this->NumberOfLeftHandedBlocks = 0;
  this->Report.clear();
  bsv::setText(verdict, "");
  return bsv::execute(this, [&] {
    const bsv::Execution shared = bsv::filterExecution(this);
    const bsv::Ranks& ranks = *shared.ranks;
    const bsv::BSplineVolumeBlocks input = bsv::bsplineVolumeBlocks(bsv::requiredInput(inputVector, 0), ranks);
    bsv::requireVolumes(input);
    const std::size_t count = input.volumes.size();
    std::vector<BlockSpans> blocks(count);
    double total = 0.0;
    for (std::size_t b = 0; b < count; ++b)
    {
      blocks[b].corners = bsv::sampleCounts(input.volumes[b], 0, input.label(b));
      for (int d = 0; d < 3; ++d)
      {
        blocks[b].spans[d] = blocks[b].corners[d] - 1;
      }
      total += input.isHere(b) ? static_cast<double>(blocks[b].count()) : 0.0;
    }
    // A point, four numbers and the verdict.
    bsv::requireMemory(total * (7 * sizeof(double) + 1), "the volume", "the measures of its spans");

    bsv::warn(this,
      bsv::uselessPatterns("Body Boundaries", this->BodyBoundaries, bsv::defaultBodyBoundaries(), input.boundaryNames,
        input.boundaryTypes));
    std::vector<std::vector<int>> walls(count);
    const std::vector<bool> isWall = bsv::wallBoundaries(
      vtkDataObject::GetData(inputVector[0], 0), input.boundaryNames, input.boundaryTypes, this->BodyBoundaries, ranks);
    for (const bsv::BoundaryPatch& patch : input.boundaries)
    {
      if (isWall[patch.tag])
      {
        walls[patch.block].push_back(patch.face);
      }
    }

    const auto validSpans = namedArray<vtkIdTypeArray>("ValidSpans", static_cast<vtkIdType>(count));
    const auto invalidSpans = namedArray<vtkIdTypeArray>("InvalidSpans", static_cast<vtkIdType>(count));
    const auto undecidedSpans = namedArray<vtkIdTypeArray>("UndecidedSpans", static_cast<vtkIdType>(count));
    const auto minimum = namedArray<vtkDoubleArray>("MinimumJacobian", static_cast<vtkIdType>(count));
    const auto minimumScaled = namedArray<vtkDoubleArray>("MinimumScaledJacobian", static_cast<vtkIdType>(count));
    std::vector<bsv::JacobianReport> reports(count);
    bsv::JacobianOptions options;
    options.maxDepth = this->MaximumDepth;
    std::vector<BlockSummary> summaries(count);
    double done = 0.0;
    for (std::size_t b = 0; b < count; ++b)
    {
      if (!input.isHere(b))
      {
        continue;
      }
      BlockSpans& block = blocks[b];
      const vtkIdType spans = block.count();
      const double start = 0.9 * done / total;
      done += static_cast<double>(spans);
      const double end = 0.9 * done / total;

      vtkNew<vtkPoints> points;
      points->SetDataTypeToDouble();
      points->SetNumberOfPoints(vtkIdType(block.corners[0]) * block.corners[1] * block.corners[2]);
      auto* coordinates = vtkDoubleArray::SafeDownCast(points->GetData());
      bsv::sample(input.volumes[b], 0, { 0, 0, 0 }, coordinates->GetPointer(0),
        bsv::filterExecution(this, start, start + 0.1 * (end - start)));
      block.points = coordinates->GetPointer(0);
      block.grid->SetDimensions(block.corners.data());
      block.grid->SetPoints(points);

      const auto validity = namedArray<vtkUnsignedCharArray>("Validity", spans);
      block.grid->GetCellData()->SetScalars(validity);
      bsv::JacobianArrays arrays;
      arrays.validity = validity->GetPointer(0);
      arrays.lower = block.add("MinJacobian");
      arrays.upper = block.add("MaxJacobian");
      arrays.scaledJacobian = block.add("ScaledJacobian");
      arrays.skewness = block.add("Skewness");
      reports[b] = bsv::jacobianBounds(input.volumes[b], input.label(b), options, arrays,
        bsv::filterExecution(this, start + 0.1 * (end - start), end));
      // A block with most spans of negative volume is left-handed, and judged by its own sign.
      const bool leftHanded = 2 * reports[b].negative > spans;
      if (leftHanded)
      {
        bsv::JacobianOptions mirrored = options;
        mirrored.leftHanded = true;
        reports[b] =
          bsv::jacobianBounds(input.volumes[b], input.label(b), mirrored, arrays, bsv::filterExecution(this, end, end));
      }
      const bsv::JacobianReport& report = reports[b];
      summaries[b] = { report.valid, report.invalid, report.undecided, report.lowest,
        *std::min_element(arrays.scaledJacobian, arrays.scaledJacobian + spans), leftHanded };
    }
    ranks.share(summaries, [&](Index b) { return input.ranks[b]; });
    std::string leftHanded;
    for (std::size_t b = 0; b < count; ++b)
    {
      const BlockSummary& summary = summaries[b];
      const vtkIdType at = static_cast<vtkIdType>(b);
      const vtkIdType spans = blocks[at].count();
      validSpans->SetValue(at, summary.valid);
      invalidSpans->SetValue(at, summary.invalid);
      undecidedSpans->SetValue(at, summary.undecided);
      minimum->SetValue(at, summary.lowest);
      minimumScaled->SetValue(at, summary.lowestScaled);
      this->NumberOfSpans += spans;
      this->NumberOfValidSpans += summary.valid;
      this->NumberOfInvalidSpans += summary.invalid;
      this->NumberOfUndecidedSpans += summary.undecided;
      if (this->WorstBlock < 0 || summary.lowest < this->MinimumJacobian)
      {
        this->MinimumJacobian = summary.lowest;
        this->WorstBlock = static_cast<int>(at);
      }
      this->MinimumScaledJacobian =
        at == 0 ? summary.lowestScaled : std::min(this->MinimumScaledJacobian, summary.lowestScaled);
      if (summary.leftHanded)
      {
        constexpr int Listed = 5;
        ++this->NumberOfLeftHandedBlocks;
        leftHanded += this->NumberOfLeftHandedBlocks > Listed ? ""
          : leftHanded.empty()                                ? input.label(b)
                                                              : ", " + input.label(b);
      }
    }
    if (this->NumberOfLeftHandedBlocks > 0)
    {
      bsv::warn(this,
        { "Left-handed, and judged by their own sign: " + std::to_string(this->NumberOfLeftHandedBlocks) + " of " +
          std::to_string(count) + " blocks, " + leftHanded + (this->NumberOfLeftHandedBlocks > 5 ? ", ..." : "") +
          "." });
    }

    std::vector<bsv::Interface> interfaces = input.interfaces;
    if (!input.hasInterfaces)
    {
      bsv::VolumeInterfaceOptions search;
      search.boundaries = input.boundaries;
      search.blockName = [&input](int block) { return input.label(block); };
      try
      {
        ranks.together([&] {
          interfaces = bsv::findVolumeInterfaces(input.volumes, search, bsv::filterExecution(this, 0.9, 0.95));
        });
      }
      catch (const bsv::Aborted&)
      {
        throw;
      }
      catch (const bsv::Error& error)
      {
        // Everything but GrowthRatio does without them.
        bsv::warn(this, { std::string("No interfaces are found: ") + error.what() });
      }
    }

    const bsv::Execution run = bsv::filterExecution(this, 0.95, 1.0);
    const std::vector<std::array<Neighbour, 6>> around = neighbours(interfaces, blocks);
    const std::vector<SizesBeyond> beyond = sizesBeyond(blocks, around, input, ranks);
    std::vector<vtkSmartPointer<vtkStructuredGrid>> grids(count);
    for (std::size_t b = 0; b < count; ++b)
    {
      run.report(static_cast<double>(b) / static_cast<double>(count));
      if (input.isHere(b))
      {
        addSizes(blocks[b], around[b], beyond[b], run);
        addHeights(blocks[b], walls[b]);
        grids[b] = blocks[b].grid;
      }
    }
    bsv::setBlocks(output, grids, input.names, "Quality");
    bsv::setWholeFaceContacts(output, interfaces, input.boundaries, input.boundaryNames, input.boundaryTypes);
    vtkNew<vtkStringArray> names;
    names->SetName("ValidityNames");
    for (const std::string& name : bsv::validityNames())
    {
      names->InsertNextValue(name);
    }
    for (vtkAbstractArray* array : std::initializer_list<vtkAbstractArray*>{
           names, validSpans, invalidSpans, undecidedSpans, minimum, minimumScaled })
    {
      output->GetFieldData()->AddArray(array);
    }
    run.report(1.0);
    addWitnesses(input, reports, witnesses);
    addFindings(grids, findings);
    const std::string text = verdictText(this->NumberOfSpans, this->NumberOfInvalidSpans, this->NumberOfUndecidedSpans);
    bsv::setText(verdict, text);
    this->Report = text + '\n' + std::to_string(this->NumberOfSpans) +
      " spans: " + std::to_string(this->NumberOfValidSpans) + " proven valid, " +
      std::to_string(this->NumberOfInvalidSpans) + " proven invalid, " + std::to_string(this->NumberOfUndecidedSpans) +
      " undecided\n" + "smallest scaled Jacobian " + bsv::shortNumber(this->MinimumScaledJacobian) +
      "\nsmallest bound of det J " + bsv::shortNumber(this->MinimumJacobian) + " (cubed length unit), in " +
      input.label(static_cast<std::size_t>(this->WorstBlock)) + '\n';
  });
}

//------------------------------------------------------------------------------
void vtkBSplineVolumeQuality::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "MaximumDepth: " << this->MaximumDepth << '\n';
  os << indent << "BodyBoundaries: " << bsv::quotedList(this->BodyBoundaries) << '\n';
  os << indent << "NumberOfSpans: " << this->NumberOfSpans << '\n';
  os << indent << "NumberOfValidSpans: " << this->NumberOfValidSpans << '\n';
  os << indent << "NumberOfInvalidSpans: " << this->NumberOfInvalidSpans << '\n';
  os << indent << "NumberOfUndecidedSpans: " << this->NumberOfUndecidedSpans << '\n';
  os << indent << "NumberOfLeftHandedBlocks: " << this->NumberOfLeftHandedBlocks << '\n';
  os << indent << "MinimumJacobian: " << this->MinimumJacobian << '\n';
  os << indent << "MinimumScaledJacobian: " << this->MinimumScaledJacobian << '\n';
  os << indent << "WorstBlock: " << this->WorstBlock << '\n';
  os << indent << "Report: " << this->Report << '\n';
}
