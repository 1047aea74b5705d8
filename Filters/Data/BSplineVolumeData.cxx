// SPDX-License-Identifier: BSD-3-Clause
#include "Data/BSplineVolumeData.h"

#include "Data/BlockTags.h"
#include "Data/HexBlockData.h"

#include <vtkCompositeDataSet.h>
#include <vtkDataArray.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkInformation.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPartitionedDataSetCollection.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkStructuredGrid.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>

namespace bsv
{

namespace
{

constexpr const char* KnotNames[3] = { "KnotsU", "KnotsV", "KnotsW" };

/// All numbers of a field data array.
std::vector<double> fieldValues(
  vtkStructuredGrid* grid, const char* name, std::size_t expected, const std::string& label)
{
  auto* array = vtkDataArray::SafeDownCast(grid->GetFieldData()->GetAbstractArray(name));
  const std::string what = "field data array '" + std::string(name) + "'";
  if (!array)
  {
    throw Error(label + " has no " + what +
      " of numbers; it is no B-spline volume: CatmullClark To BSpline Volume makes one of a mesh");
  }
  if (static_cast<std::size_t>(array->GetNumberOfValues()) != expected)
  {
    throw Error(label + ": " + what + " has " + std::to_string(array->GetNumberOfValues()) + " values instead of " +
      std::to_string(expected));
  }
  std::vector<double> values;
  values.reserve(expected);
  for (vtkIdType i = 0; i < array->GetNumberOfTuples(); ++i)
  {
    for (int c = 0; c < array->GetNumberOfComponents(); ++c)
    {
      values.push_back(array->GetComponent(i, c));
    }
  }
  return values;
}

const double* doublePoints(vtkSmartPointer<vtkStructuredGrid>& grid)
{
  auto* doubles = vtkDoubleArray::SafeDownCast(grid->GetPoints()->GetData());
  if (!doubles)
  {
    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    points->DeepCopy(grid->GetPoints());
    vtkNew<vtkStructuredGrid> copy;
    copy->ShallowCopy(grid);
    copy->SetPoints(points);
    grid = copy;
    doubles = vtkDoubleArray::SafeDownCast(points->GetData());
  }
  return doubles->GetPointer(0);
}

const unsigned char* rulesOf(vtkStructuredGrid* grid, const std::string& label)
{
  vtkAbstractArray* any = grid->GetPointData()->GetAbstractArray("ControlPointRule");
  if (!any)
  {
    return nullptr;
  }
  auto* array = vtkUnsignedCharArray::SafeDownCast(any);
  if (!array || array->GetNumberOfValues() != grid->GetNumberOfPoints())
  {
    throw Error(label + ": point data array 'ControlPointRule' must hold one unsigned char a point, but is " +
      any->GetClassName() + " with " + std::to_string(any->GetNumberOfValues()) + " values");
  }
  return array->GetPointer(0);
}

} // namespace

int BSplineVolumeBlocks::firstRational() const
{
  const auto found = std::find(this->rational.begin(), this->rational.end(), 1);
  return found == this->rational.end() ? -1 : static_cast<int>(found - this->rational.begin());
}

BSplineVolumeBlocks bsplineVolumeBlocks(vtkDataObject* input, const Ranks& ranks)
{
  BSplineVolumeBlocks result;
  BlockMesh mesh = structuredBlocks(input, result.grids, ranks);
  const std::size_t count = mesh.blocks.size();
  for (const MeshBlock& block : mesh.blocks)
  {
    result.ranks.push_back(block.rank);
    result.names.push_back(block.name);
  }
  result.volumes.resize(count);
  for (std::size_t b = 0; b < count; ++b)
  {
    result.volumes[b].rank = result.ranks[b];
  }
  result.rational.resize(count, 0);
  result.weights.resize(count);
  result.rules.resize(count, nullptr);
  result.edgeClasses.resize(count, nullptr);

  // Block, degree and whether it is rational, then the knots.
  std::vector<double> mine;
  for (std::size_t b = 0; b < count; ++b)
  {
    if (!result.isHere(b))
    {
      continue;
    }
    const std::string label = result.label(b);
    vtkSmartPointer<vtkStructuredGrid>& grid = result.grids[b];
    BSplineVolume& volume = result.volumes[b];
    const std::vector<double> degree = fieldValues(grid, "Degree", 3, label);
    for (int d = 0; d < 3; ++d)
    {
      if (!(degree[d] >= 1.0 && degree[d] <= MaxDegree) || degree[d] != static_cast<int>(degree[d]))
      {
        throw Error(label + ": field data array 'Degree' has the value " + std::to_string(degree[d]) +
          "; degrees are 1.." + std::to_string(MaxDegree));
      }
      volume.degree[d] = static_cast<int>(degree[d]);
      const int points = mesh.blocks[b].points.counts()[d];
      volume.knots[d] = fieldValues(grid, KnotNames[d], static_cast<std::size_t>(points) + volume.degree[d] + 1, label);
    }
    result.weights[b] = doublePointArray(grid, "Weights", 1, result.names[b]);
    volume.weights = result.weights[b] ? result.weights[b]->GetPointer(0) : nullptr;
    volume.points = doublePoints(grid);
    checkBSplineVolume(volume, label);
    result.rational[b] = volume.weights ? 1 : 0;
    result.rules[b] = rulesOf(grid, label);
    auto* classes = vtkUnsignedCharArray::SafeDownCast(grid->GetFieldData()->GetAbstractArray("EdgeClasses"));
    result.edgeClasses[b] = classes && classes->GetNumberOfValues() == 12 ? classes->GetPointer(0) : nullptr;

    mine.push_back(static_cast<double>(b));
    mine.insert(mine.end(), degree.begin(), degree.end());
    mine.push_back(result.rational[b]);
    for (const std::vector<double>& knots : volume.knots)
    {
      mine.insert(mine.end(), knots.begin(), knots.end());
    }
  }
  if (ranks.size() > 1)
  {
    const std::vector<double> all = ranks.gatherAll(mine);
    for (auto at = all.begin(); at != all.end();)
    {
      const std::size_t b = static_cast<std::size_t>(*at++);
      BSplineVolume& volume = result.volumes[b];
      std::transform(at, at + 3, volume.degree.begin(), [](double degree) { return static_cast<int>(degree); });
      result.rational[b] = static_cast<char>(at[3]);
      at += 4;
      for (int d = 0; d < 3; ++d)
      {
        const auto end = at + mesh.blocks[b].points.counts()[d] + volume.degree[d] + 1;
        volume.knots[d].assign(at, end);
        at = end;
      }
    }
  }

  const auto whole = [&](const FaceRange& range, int block, int face) {
    const Ijk& counts = mesh.blocks[block].points.counts();
    return range == FaceRange{ { 0, 0 }, { counts[faceAxis(face, 0)] - 1, counts[faceAxis(face, 1)] - 1 } };
  };
  const auto refuse = [&](const char* array, int block, int face) {
    throw Error(std::string("field data array '") + array + "': an entry covers only part of face " +
      std::to_string(face) + " of " + result.label(block));
  };
  for (const Interface& contact : mesh.interfaces)
  {
    if (!whole(contact.rangeA, contact.blockA, contact.faceA))
    {
      refuse("Interfaces", contact.blockA, contact.faceA);
    }
    if (!whole(contact.rangeB(), contact.blockB, contact.faceB))
    {
      refuse("Interfaces", contact.blockB, contact.faceB);
    }
  }
  for (const BoundaryPatch& patch : mesh.boundaries)
  {
    if (!whole(patch.range, patch.block, patch.face))
    {
      refuse("Boundaries", patch.block, patch.face);
    }
  }
  result.hasInterfaces =
    ranks.any(input && input->GetFieldData() && input->GetFieldData()->GetAbstractArray("Interfaces"));
  result.interfaces = std::move(mesh.interfaces);
  result.boundaries = std::move(mesh.boundaries);
  result.boundaryNames = std::move(mesh.boundaryNames);
  result.boundaryTypes = std::move(mesh.boundaryTypes);
  return result;
}

void setDegreeAndKnots(vtkStructuredGrid* grid, const BSplineVolume& volume)
{
  vtkNew<vtkIntArray> degree;
  degree->SetName("Degree");
  for (int d = 0; d < 3; ++d)
  {
    degree->InsertNextValue(volume.degree[d]);
    vtkNew<vtkDoubleArray> knots;
    knots->SetName(KnotNames[d]);
    knots->SetNumberOfValues(static_cast<vtkIdType>(volume.knots[d].size()));
    std::copy(volume.knots[d].begin(), volume.knots[d].end(), knots->GetPointer(0));
    grid->GetFieldData()->AddArray(knots);
  }
  grid->GetFieldData()->AddArray(degree);
}

void setWholeFaceContacts(vtkPartitionedDataSetCollection* collection, const std::vector<Interface>& interfaces,
  const std::vector<BoundaryPatch>& boundaries, const std::vector<std::string>& boundaryNames,
  const std::vector<std::string>& boundaryTypes)
{
  // The arrays say "whole" without numbers: any counts do, if the ranges fit them.
  const std::vector<Ijk> counts(collection->GetNumberOfPartitionedDataSets(), Ijk{ 2, 2, 2 });
  const FaceRange whole{ { 0, 0 }, { 1, 1 } };
  std::vector<Interface> contacts = interfaces;
  for (Interface& contact : contacts)
  {
    contact.rangeA = whole;
    contact.originB = { 0, 0 };
  }
  std::vector<BoundaryPatch> patches = boundaries;
  for (BoundaryPatch& patch : patches)
  {
    patch.range = whole;
  }
  setInterfaces(collection->GetFieldData(), contacts, counts);
  setBoundaries(collection->GetFieldData(), patches, boundaryNames, counts, boundaryTypes);

  // What blocks bring with them when they are extracted. Only those here are asked for their size.
  BlockMesh mesh;
  for (unsigned int b = 0; b < collection->GetNumberOfPartitionedDataSets(); ++b)
  {
    MeshBlock block;
    Ijk size{ 0, 0, 0 };
    if (auto* grid = vtkStructuredGrid::SafeDownCast(collection->GetPartitionAsDataObject(b, 0)))
    {
      grid->GetDimensions(size.data());
    }
    block.points = GridView::elsewhere(size);
    const char* name = collection->HasMetaData(b) && collection->GetMetaData(b)->Has(vtkCompositeDataSet::NAME())
      ? collection->GetMetaData(b)->Get(vtkCompositeDataSet::NAME())
      : nullptr;
    block.name = name ? name : "";
    mesh.blocks.push_back(block);
  }
  const auto wholeFace = [&](int block, int face) -> FaceRange {
    const Ijk& size = mesh.blocks[block].points.counts();
    return { { 0, 0 }, { size[faceAxis(face, 0)] - 1, size[faceAxis(face, 1)] - 1 } };
  };
  for (Interface& contact : contacts)
  {
    contact.rangeA = wholeFace(contact.blockA, contact.faceA);
  }
  for (BoundaryPatch& patch : patches)
  {
    patch.range = wholeFace(patch.block, patch.face);
  }
  mesh.interfaces = std::move(contacts);
  mesh.boundaries = std::move(patches);
  mesh.boundaryNames = boundaryNames;
  mesh.boundaryTypes = boundaryTypes;
  tagBlocks(collection, mesh, "volume", false);
}

} // namespace bsv
