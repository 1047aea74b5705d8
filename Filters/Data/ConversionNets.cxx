// SPDX-License-Identifier: BSD-3-Clause
// Control nets of a conversion as grids.
#include "Data/ConversionResult.h"

#include "Base/MemoryCheck.h"
#include "Conversion/JoinedBlocks.h"
#include "Data/BSplineVolumeData.h"
#include "Ranks/Ranks.h"

#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkIntArray.h"
#include "vtkNew.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkUnsignedCharArray.h"

#include <algorithm>
#include <tuple>

namespace bsv
{

namespace
{

/// The control point nearest to mesh point i of a direction, at knot i: point i + 1 with single knots.
int controlPointAt(const std::vector<double>& knots, int cells, int i)
{
  const auto [first, last] = std::equal_range(knots.begin(), knots.end(), static_cast<double>(i));
  const int multiplicity = static_cast<int>(last - first);
  return i == 0  ? 0
    : i == cells ? static_cast<int>(knots.size()) - 5
                 : static_cast<int>(first - knots.begin()) - 3 + (multiplicity + 2) / 2;
}

void addInts(vtkFieldData* fields, const char* name, const std::vector<int>& values)
{
  vtkNew<vtkIntArray> array;
  array->SetName(name);
  for (const int value : values)
  {
    array->InsertNextValue(value);
  }
  fields->AddArray(array);
}

} // namespace

std::vector<CreaseLine> creasesOfNets(const std::vector<CreaseLine>& creases, const BlockComplex& complex,
  const std::vector<std::array<std::vector<double>, 3>>& knots)
{
  std::vector<CreaseLine> result;
  for (std::size_t b = 0; b < complex.blocks.size(); ++b)
  {
    const ComplexBlock& block = complex.blocks[b];
    for (const CreaseLine& crease : creases)
    {
      if (crease.block != block.parent)
      {
        continue;
      }
      CreaseLine line;
      line.block = static_cast<int>(b);
      bool inside = true;
      bool isLine = false;
      for (int d = 0; d < 3; ++d)
      {
        const int cells = block.cells(d);
        const auto [lower, upper] = std::minmax(crease.from[d], crease.to[d]);
        const int first = std::max(lower - block.offset[d], 0);
        const int last = std::min(upper - block.offset[d], cells);
        inside = inside && first <= last;
        isLine = isLine || first < last;
        line.from[d] = controlPointAt(knots[b][d], cells, first);
        line.to[d] = controlPointAt(knots[b][d], cells, last);
      }
      if (inside && isLine)
      {
        result.push_back(line);
      }
    }
  }
  return result;
}

vtkSmartPointer<vtkStructuredGrid> controlNet(
  const ComplexBlock& block, const std::array<std::vector<double>, 3>& knots, ControlNetStorage& storage)
{
  auto grid = vtkSmartPointer<vtkStructuredGrid>::New();
  std::array<int, 3> counts{};
  BSplineVolume volume;
  for (int d = 0; d < 3; ++d)
  {
    volume.knots[d] = knots[d];
    counts[d] = volume.count(d);
  }
  setDegreeAndKnots(grid, volume);
  addInts(grid->GetFieldData(), "ParentBlock", { block.parent });
  addInts(grid->GetFieldData(), "ParentOffset", { block.offset.begin(), block.offset.end() });

  const vtkIdType size = vtkIdType(counts[0]) * counts[1] * counts[2];
  vtkNew<vtkDoubleArray> coordinates;
  coordinates->SetNumberOfComponents(3);
  coordinates->SetNumberOfTuples(size);
  vtkNew<vtkPoints> points;
  points->SetData(coordinates);
  vtkNew<vtkUnsignedCharArray> rules;
  rules->SetName("ControlPointRule");
  rules->SetNumberOfValues(size);
  grid->SetDimensions(counts.data());
  grid->SetPoints(points);
  grid->GetPointData()->AddArray(rules);
  storage = { coordinates->GetPointer(0), rules->GetPointer(0) };
  return grid;
}

void setContacts(vtkPartitionedDataSetCollection* volume, const BlockComplex& complex)
{
  std::vector<Interface> interfaces;
  std::vector<BoundaryPatch> boundaries;
  for (const ComplexFace& face : complex.faces)
  {
    const FaceUse& a = face.uses.front();
    if (!face.boundary())
    {
      const FaceUse& b = face.uses.back();
      interfaces.push_back({ a.block, a.face, b.block, b.face, face.orientation, {}, {} });
    }
    else if (face.tag >= 0)
    {
      boundaries.push_back({ a.block, a.face, {}, face.tag });
    }
  }
  setWholeFaceContacts(volume, interfaces, boundaries, complex.boundaryNames, complex.boundaryTypes);
}

void joinBlocks(ConvertedMesh& conversion, const std::vector<ControlNetStorage>& storage, const Execution& run)
{
  JoinedBlocks joined = joinPieces(conversion.complex);
  std::vector<std::array<std::vector<double>, 3>> knots(joined.blocks.size());
  std::vector<vtkSmartPointer<vtkStructuredGrid>> nets(joined.blocks.size());
  RuleCounts counts{};
  for (std::size_t b = 0; b < nets.size(); ++b)
  {
    run.report(static_cast<double>(b) / static_cast<double>(nets.size()));
    const JoinedBlock& block = joined.blocks[b];
    for (int d = 0; d < 3; ++d)
    {
      knots[b][d] = joinedKnots(block, d, conversion.knots);
    }
    if (!conversion.nets[block.pieces[0]])
    {
      continue;
    }
    ControlNetStorage net = storage[block.pieces[0]];
    if (block.pieces.size() == 1)
    {
      nets[b] = conversion.nets[block.pieces[0]];
    }
    else
    {
      BSplineVolume volume;
      volume.knots = knots[b];
      const double points = double(volume.count(0)) * volume.count(1) * volume.count(2);
      // Its pieces are there until it is complete.
      requireMemory(points * BytesPerControlPoint, "the volume", "block " + std::to_string(b) + " as a whole");
      nets[b] = controlNet(joined.complex.blocks[b], knots[b], net);
      joinNets(block, conversion.knots, storage, net, run);
      for (const int piece : block.pieces)
      {
        conversion.nets[piece] = nullptr;
      }
    }
    for (vtkIdType n = 0; n < nets[b]->GetNumberOfPoints(); ++n)
    {
      ++counts[net.rules[n]];
    }
  }
  conversion.counts.controlPoints = {};
  for (const RuleCounts& ofRank : run.ranks->gatherAll(std::vector<RuleCounts>{ counts }))
  {
    for (std::size_t rule = 0; rule < ofRank.size(); ++rule)
    {
      conversion.counts.controlPoints[rule] += ofRank[rule];
    }
  }
  auto& left = conversion.counts.spans.left;
  for (SpanReport::Place& place : left)
  {
    const Ijk& offset = conversion.complex.blocks[place.block].offset;
    place.block = joined.blockOf[place.block];
    for (int d = 0; d < 3; ++d)
    {
      place.cell[d] += offset[d] - joined.complex.blocks[place.block].offset[d];
    }
  }
  std::sort(left.begin(), left.end(), [](const SpanReport::Place& a, const SpanReport::Place& b) {
    return std::tie(a.block, a.cell[2], a.cell[1], a.cell[0]) < std::tie(b.block, b.cell[2], b.cell[1], b.cell[0]);
  });
  conversion.complex = std::move(joined.complex);
  conversion.nets = std::move(nets);
  conversion.knots = std::move(knots);
}

} // namespace bsv
