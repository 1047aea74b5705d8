// SPDX-License-Identifier: BSD-3-Clause
// The parts of block complexes, the output of vtkHexBlockTopology.
#include "blockPartsModel.h"

#include "Complex/EntityClass.h"
#include "Data/BoundaryPatterns.h"
#include "Ranks/SharedBox.h"

#include "vtkCellData.h"
#include "vtkFieldData.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkStringArray.h"

namespace bsv
{

namespace
{

vtkPolyData* partOf(vtkDataObject* input, unsigned int part)
{
  auto* collection = vtkPartitionedDataSetCollection::SafeDownCast(input);
  return collection && part < collection->GetNumberOfPartitionedDataSets() &&
      collection->GetNumberOfPartitions(part) > 0
    ? vtkPolyData::SafeDownCast(collection->GetPartition(part, 0))
    : nullptr;
}

std::vector<std::string> fieldStrings(vtkDataObject* input, const char* name)
{
  std::vector<std::string> values;
  auto* array = vtkStringArray::SafeDownCast(input->GetFieldData()->GetAbstractArray(name));
  for (vtkIdType n = 0; array && n < array->GetNumberOfValues(); ++n)
  {
    values.push_back(array->GetValue(n));
  }
  return values;
}

/// Value of a cell array, or -1.
int cellValue(vtkPolyData* data, const char* name, vtkIdType cell)
{
  vtkDataArray* array = data->GetCellData()->GetArray(name);
  return array ? static_cast<int>(array->GetTuple1(cell)) : -1;
}

/// The outer faces, and those of them that the names choose as wall.
struct ChosenFaces
{
  std::vector<vtkIdType> outer, wall;
};

ChosenFaces chooseFaces(vtkDataObject* input, vtkPolyData* faces)
{
  const std::vector<std::string> names = fieldStrings(input, "BoundaryNames");
  std::vector<std::string> types = fieldStrings(input, "BoundaryTypes");
  types.resize(names.size());
  ChosenFaces chosen;
  for (vtkIdType cell = 0; faces && cell < faces->GetNumberOfCells(); ++cell)
  {
    const int tag = cellValue(faces, "BoundaryTag", cell);
    if (cellValue(faces, "Class", cell) == static_cast<int>(EntityClass::Boundary))
    {
      chosen.outer.push_back(cell);
      if (tag >= 0 && tag < static_cast<int>(names.size()) &&
        selectsBoundary(defaultBodyBoundaries(), defaultBodyBoundaries(), names, types, tag))
      {
        chosen.wall.push_back(cell);
      }
    }
  }
  return chosen;
}

std::vector<Vec3> pointsOf(vtkPolyData* data, vtkIdType cell)
{
  vtkIdType count = 0;
  const vtkIdType* ids = nullptr;
  data->GetCellPoints(cell, count, ids);
  std::vector<Vec3> points(static_cast<std::size_t>(count));
  for (vtkIdType n = 0; n < count; ++n)
  {
    data->GetPoint(ids[n], points[n].data());
  }
  return points;
}

/// @param shown whether the cells are wanted, not only their box
vtkSmartPointer<vtkPolyData> extractCells(
  vtkPolyData* faces, const std::vector<vtkIdType>& cells, bool shown, Eigen::AlignedBox3d& box)
{
  auto result = vtkSmartPointer<vtkPolyData>::New();
  if (!faces)
  {
    return result;
  }
  result->SetPoints(faces->GetPoints());
  vtkNew<vtkCellArray> quads;
  vtkNew<vtkIdTypeArray> source;
  source->SetName("SourceCell");
  result->GetCellData()->CopyAllocate(faces->GetCellData());
  for (const vtkIdType cell : cells)
  {
    for (const Vec3& x : pointsOf(faces, cell))
    {
      box.extend(x);
    }
    if (shown)
    {
      vtkIdType count = 0;
      const vtkIdType* ids = nullptr;
      faces->GetCellPoints(cell, count, ids);
      result->GetCellData()->CopyData(faces->GetCellData(), cell, quads->InsertNextCell(count, ids));
      source->InsertNextValue(cell);
    }
  }
  result->SetPolys(quads);
  result->GetCellData()->AddArray(source);
  return result;
}

} // namespace

bool isComplex(vtkDataObject* input, const Ranks& ranks)
{
  return ranks.any(input && input->GetFieldData()->HasArray("ClassNames") && partOf(input, 2));
}

void complexParts(BlockParts& parts, vtkDataObject* input, const BlockPartsOptions& options, const Execution& run)
{
  const Ranks& ranks = *run.ranks;
  BlockPartsModel model;
  model.ranks = &ranks;
  vtkPolyData* faces = partOf(input, 2);
  const ChosenFaces chosen = chooseFaces(input, faces);
  const bool named = ranks.any(!chosen.wall.empty());
  model.wallText = named ? "wall" : "outer faces";
  Eigen::AlignedBox3d box;
  const auto surface = extractCells(faces, named ? chosen.wall : chosen.outer, options.wall, box);
  box = sharedBox(box, ranks);
  parts.surfaces = withLeaves(vtkDataObjectTree::SafeDownCast(input),
    [&](vtkDataObject* leaf) { return leaf == faces ? surface : vtkSmartPointer<vtkPolyData>::New(); });

  LineBuilder nets(box, options.reach), curves(box, options.reach);
  std::vector<int> valences;
  vtkPolyData* edges = partOf(input, 1);
  for (vtkIdType cell = 0; edges && cell < edges->GetNumberOfCells(); ++cell)
  {
    const auto what = static_cast<EntityClass>(cellValue(edges, "Class", cell));
    const bool extraordinary = what == EntityClass::Extraordinary;
    const int valence = cellValue(edges, "Valence", cell);
    if (extraordinary ? options.extraordinaryCurves : what == EntityClass::Crease && options.creases)
    {
      curves.line(pointsOf(edges, cell), extraordinary ? valenceColor(valence) : CreaseColor);
    }
    else if (options.blockEdges)
    {
      nets.line(pointsOf(edges, cell), BlockEdgeColor);
    }
    if (extraordinary)
    {
      valences.push_back(valence);
    }
  }
  vtkPolyData* vertices = partOf(input, 0);
  for (vtkIdType cell = 0; vertices && cell < vertices->GetNumberOfCells(); ++cell)
  {
    if (options.extraordinaryCurves && cellValue(vertices, "Class", cell) == static_cast<int>(EntityClass::Singular))
    {
      curves.node(pointsOf(vertices, cell).front(), NodeColor);
    }
  }
  for (const int valence : ranks.gatherAll(valences))
  {
    ++model.valences[valence];
  }
  parts.nets = nets.build();
  parts.curves = curves.build();
  parts.legend = legendOf(model, curves.colors(), options);
  parts.wallText = model.wallText;
}

} // namespace bsv
