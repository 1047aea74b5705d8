// SPDX-License-Identifier: BSD-3-Clause
#include "Data/NURBSSurfaceData.h"

#include "Data/FinitePoints.h"
#include "Data/HexBlockData.h"

#include <vtkCellArray.h>
#include <vtkCompositeDataSet.h>
#include <vtkDataAssembly.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkInformation.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPartitionedDataSet.h>
#include <vtkPartitionedDataSetCollection.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkStringArray.h>
#include <vtkStructuredGrid.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace bsv
{

namespace
{

/// All numbers of a field array; an array that is missing is empty unless it is `required`.
std::vector<double> fieldNumbers(
  vtkFieldData* fields, const char* name, int components, bool required, const std::string& label)
{
  vtkAbstractArray* any = fields->GetAbstractArray(name);
  auto* array = vtkDataArray::SafeDownCast(any);
  if (!array && (required || any))
  {
    throw Error(label + " has no field data array '" + name + "' of numbers; it is no NURBS patch");
  }
  std::vector<double> values;
  if (!array)
  {
    return values;
  }
  if (array->GetNumberOfValues() % components != 0)
  {
    throw Error(label + ": field data array '" + name + "' has " + std::to_string(array->GetNumberOfValues()) +
      " values, no multiple of " + std::to_string(components));
  }
  for (vtkIdType i = 0; i < array->GetNumberOfTuples(); ++i)
  {
    for (int c = 0; c < array->GetNumberOfComponents(); ++c)
    {
      values.push_back(array->GetComponent(i, c));
    }
  }
  return values;
}

/// A value that must be a whole number in low..high.
int whole(double value, int low, int high, const char* name, const std::string& label)
{
  if (!(value >= low && value <= high) || value != std::floor(value))
  {
    throw Error(label + ": field data array '" + name + "' holds " + std::to_string(value) + ", no whole number in " +
      std::to_string(low) + ".." + std::to_string(high));
  }
  return static_cast<int>(value);
}

void readLoops(vtkFieldData* fields, const std::string& label, std::vector<TrimLoop>& loops)
{
  const std::vector<double> curves = fieldNumbers(fields, "TrimCurves", 3, false, label);
  const std::vector<double> knots = fieldNumbers(fields, "TrimKnots", 1, !curves.empty(), label);
  const std::vector<double> points = fieldNumbers(fields, "TrimPoints", 3, !curves.empty(), label);
  std::size_t knot = 0;
  std::size_t point = 0;
  for (std::size_t i = 0; i < curves.size(); i += 3)
  {
    const int last = static_cast<int>(loops.size());
    const int loop = whole(curves[i], std::max(last - 1, 0), last, "TrimCurves", label);
    if (loop == last)
    {
      loops.emplace_back();
    }
    ParameterCurve curve;
    curve.degree = whole(curves[i + 1], 1, MaxSurfaceDegree, "TrimCurves", label);
    const std::size_t count = whole(curves[i + 2], 2, static_cast<int>(points.size() / 3), "TrimCurves", label);
    if (knot + count + curve.degree + 1 > knots.size() || 3 * (point + count) > points.size())
    {
      throw Error(
        label + ": field data arrays 'TrimKnots' and 'TrimPoints' end before trimming curve " + std::to_string(i / 3));
    }
    curve.knots.assign(knots.begin() + knot, knots.begin() + knot + count + curve.degree + 1);
    bool rational = false;
    for (std::size_t p = point; p < point + count; ++p)
    {
      curve.points.emplace_back(points[3 * p], points[3 * p + 1]);
      curve.weights.push_back(points[3 * p + 2]);
      rational = rational || points[3 * p + 2] != 1.0;
    }
    if (!rational)
    {
      curve.weights.clear();
    }
    knot += count + curve.degree + 1;
    point += count;
    loops[loop].push_back(std::move(curve));
  }
  if (knot != knots.size() || 3 * point != points.size())
  {
    throw Error(label + ": field data arrays 'TrimKnots' and 'TrimPoints' hold more than the curves of 'TrimCurves'");
  }
}

BodyPatch readPatch(vtkStructuredGrid* grid, const std::string& name, const std::string& label)
{
  BodyPatch patch;
  patch.name = name;
  vtkFieldData* fields = grid->GetFieldData();
  if (fields->HasArray("KnotsW"))
  {
    throw Error(label + ": the Body is a B-spline volume, not a NURBS surface");
  }
  const std::vector<double> degree = fieldNumbers(fields, "Degree", 1, true, label);
  if (degree.size() != 2)
  {
    throw Error(label + ": field data array 'Degree' has " + std::to_string(degree.size()) + " values instead of 2");
  }
  NURBSSurface& surface = patch.surface;
  for (int d = 0; d < 2; ++d)
  {
    surface.degree[d] = whole(degree[d], 1, MaxSurfaceDegree, "Degree", label);
    surface.knots[d] = fieldNumbers(fields, d == 0 ? "KnotsU" : "KnotsV", 1, true, label);
  }
  int dims[3];
  grid->GetDimensions(dims);
  for (int d = 0; d < 2; ++d)
  {
    if (static_cast<Index>(surface.knots[d].size()) != Index(dims[d]) + surface.degree[d] + 1 || dims[2] != 1)
    {
      throw Error(label + ": the dimensions " + std::to_string(dims[0]) + " x " + std::to_string(dims[1]) + " x " +
        std::to_string(dims[2]) + ", degree " + std::to_string(surface.degree[d]) + " and " +
        std::to_string(surface.knots[d].size()) + " knots in direction " + "uv"[d] + " do not fit together");
    }
  }
  for (vtkIdType i = 0; i < grid->GetNumberOfPoints(); ++i)
  {
    double x[3];
    grid->GetPoint(i, x);
    surface.points.emplace_back(x[0], x[1], x[2]);
  }
  if (vtkAbstractArray* any = grid->GetPointData()->GetAbstractArray("Weights"))
  {
    auto* weights = vtkDataArray::SafeDownCast(any);
    if (!weights || weights->GetNumberOfComponents() != 1 || weights->GetNumberOfTuples() != grid->GetNumberOfPoints())
    {
      throw Error(label + ": point data array 'Weights' must hold one number a point");
    }
    bool rational = false;
    for (vtkIdType i = 0; i < weights->GetNumberOfTuples(); ++i)
    {
      surface.weights.push_back(weights->GetComponent(i, 0));
      rational = rational || surface.weights.back() != 1.0;
    }
    if (!rational)
    {
      surface.weights.clear();
    }
  }
  const std::vector<double> reversed = fieldNumbers(fields, "Reversed", 1, false, label);
  patch.reversed = !reversed.empty() && reversed[0] != 0.0;
  readLoops(fields, label, patch.loops);
  checkBodyPatch(patch, label);
  return patch;
}

template <typename Array, typename Values>
void addField(vtkFieldData* fields, const char* name, int components, const Values& values)
{
  vtkNew<Array> array;
  array->SetName(name);
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(static_cast<vtkIdType>(values.size()) / components);
  std::copy(values.begin(), values.end(), array->GetPointer(0));
  fields->AddArray(array);
}

/// Patches as a row of numbers.
class PatchMessage
{
public:
  std::vector<double> numbers;

  template <typename Values>
  void add(const Values& values)
  {
    this->numbers.push_back(static_cast<double>(values.size()));
    this->numbers.insert(this->numbers.end(), values.begin(), values.end());
  }
  void add(const BodyPatch& patch)
  {
    this->add(patch.name);
    this->add(std::array<int, 3>{ patch.surface.degree[0], patch.surface.degree[1], patch.reversed ? 1 : 0 });
    this->add(patch.surface.knots[0]);
    this->add(patch.surface.knots[1]);
    this->addPoints(patch.surface.points);
    this->add(patch.surface.weights);
    this->numbers.push_back(static_cast<double>(patch.loops.size()));
    for (const TrimLoop& loop : patch.loops)
    {
      this->numbers.push_back(static_cast<double>(loop.size()));
      for (const ParameterCurve& curve : loop)
      {
        this->numbers.push_back(curve.degree);
        this->add(curve.knots);
        this->addPoints(curve.points);
        this->add(curve.weights);
      }
    }
  }

  bool atEnd() const { return this->Next == this->numbers.size(); }
  int integer() { return static_cast<int>(this->numbers[this->Next++]); }
  template <typename Values>
  void take(Values& values)
  {
    const std::size_t size = static_cast<std::size_t>(this->numbers[this->Next++]);
    values = Values(this->numbers.begin() + this->Next, this->numbers.begin() + this->Next + size);
    this->Next += size;
  }
  BodyPatch patch()
  {
    BodyPatch patch;
    this->take(patch.name);
    std::vector<int> kind;
    this->take(kind);
    patch.surface.degree = { kind[0], kind[1] };
    patch.reversed = kind[2] != 0;
    this->take(patch.surface.knots[0]);
    this->take(patch.surface.knots[1]);
    this->takePoints(patch.surface.points);
    this->take(patch.surface.weights);
    patch.loops.resize(this->integer());
    for (TrimLoop& loop : patch.loops)
    {
      loop.resize(this->integer());
      for (ParameterCurve& curve : loop)
      {
        curve.degree = this->integer();
        this->take(curve.knots);
        this->takePoints(curve.points);
        this->take(curve.weights);
      }
    }
    return patch;
  }

private:
  template <typename Point>
  void addPoints(const std::vector<Point>& points)
  {
    this->numbers.push_back(static_cast<double>(points.size()));
    for (const Point& point : points)
    {
      this->numbers.insert(this->numbers.end(), point.data(), point.data() + point.size());
    }
  }
  template <typename Point>
  void takePoints(std::vector<Point>& points)
  {
    points.resize(static_cast<std::size_t>(this->numbers[this->Next++]));
    for (Point& point : points)
    {
      std::copy_n(this->numbers.begin() + this->Next, point.size(), point.data());
      this->Next += point.size();
    }
  }

  std::size_t Next = 0;
};

/// Data set and partition of a patch in the tree, the same on all ranks.
using PatchPlace = std::array<int, 2>;

/// Gives every rank the patches that only others have. Collective.
void sharePatches(std::map<PatchPlace, BodyPatch>& patches, const Ranks& ranks)
{
  std::vector<PatchPlace> mine;
  for (const auto& entry : patches)
  {
    mine.push_back(entry.first);
  }
  const std::vector<std::vector<PatchPlace>> all = ranks.gather(mine);
  std::map<PatchPlace, int> owner; // lowest rank with a patch
  for (int r = 0; r < ranks.size(); ++r)
  {
    for (const PatchPlace& place : all[r])
    {
      owner.emplace(place, r);
    }
  }
  if (std::all_of(all.begin(), all.end(), [&](const auto& places) { return places.size() == owner.size(); }))
  {
    return;
  }
  std::vector<PatchMessage> messages(ranks.size());
  for (const auto& [place, rank] : owner)
  {
    for (int r = 0; rank == ranks.rank() && r < ranks.size(); ++r)
    {
      if (!std::binary_search(all[r].begin(), all[r].end(), place))
      {
        messages[r].numbers.insert(messages[r].numbers.end(), place.begin(), place.end());
        messages[r].add(patches.at(place));
      }
    }
  }
  std::vector<std::vector<double>> toRank;
  for (PatchMessage& message : messages)
  {
    toRank.push_back(std::move(message.numbers));
  }
  for (std::vector<double>& numbers : ranks.exchange(toRank))
  {
    PatchMessage message;
    message.numbers = std::move(numbers);
    while (!message.atEnd())
    {
      const int dataSet = message.integer();
      const int partition = message.integer();
      patches.emplace(PatchPlace{ dataSet, partition }, message.patch());
    }
  }
}

} // namespace

std::vector<BodyPatch> bodyPatches(vtkDataObject* input, const Ranks& ranks)
{
  std::map<PatchPlace, BodyPatch> patches;
  const auto take = [&](vtkDataObject* data, const char* name, PatchPlace place) {
    auto* grid = vtkStructuredGrid::SafeDownCast(data);
    if (grid && grid->GetFieldData() && grid->GetFieldData()->GetAbstractArray("Degree"))
    {
      const std::string text = name ? name : "";
      const std::string label = "patch " + std::to_string(patches.size()) + (text.empty() ? "" : " '" + text + "'");
      patches.emplace(place, readPatch(grid, text, label));
    }
    else if (auto* surface = vtkPolyData::SafeDownCast(data))
    {
      requireFinitePoints(surface, "body, " + std::string(name ? "'" + std::string(name) + "'" : "surface"));
    }
  };
  if (auto* collection = vtkPartitionedDataSetCollection::SafeDownCast(input))
  {
    for (unsigned int i = 0; i < collection->GetNumberOfPartitionedDataSets(); ++i)
    {
      const char* name =
        collection->HasMetaData(i) ? collection->GetMetaData(i)->Get(vtkCompositeDataSet::NAME()) : nullptr;
      for (unsigned int p = 0; p < collection->GetNumberOfPartitions(i); ++p)
      {
        take(collection->GetPartitionAsDataObject(i, p), name, { static_cast<int>(i), static_cast<int>(p) });
      }
    }
  }
  else if (auto* tree = vtkDataObjectTree::SafeDownCast(input))
  {
    auto iterator = vtkSmartPointer<vtkDataObjectTreeIterator>::Take(tree->NewTreeIterator());
    iterator->VisitOnlyLeavesOn();
    iterator->TraverseSubTreeOn();
    for (iterator->InitTraversal(); !iterator->IsDoneWithTraversal(); iterator->GoToNextItem())
    {
      take(iterator->GetCurrentDataObject(),
        iterator->HasCurrentMetaData() ? iterator->GetCurrentMetaData()->Get(vtkCompositeDataSet::NAME()) : nullptr,
        { static_cast<int>(iterator->GetCurrentFlatIndex()), 0 });
    }
  }
  else
  {
    take(input, nullptr, { 0, 0 });
  }
  sharePatches(patches, ranks);
  if (patches.empty())
  {
    throw Error("the body holds no NURBS patch: no structured grid with the field data array 'Degree', as those of the "
                "NURBS Surface Reader have");
  }
  std::vector<BodyPatch> result;
  for (auto& entry : patches)
  {
    result.push_back(std::move(entry.second));
  }
  return result;
}

vtkSmartPointer<vtkStructuredGrid> patchGrid(const BodyPatch& patch, const std::string& layer)
{
  const NURBSSurface& surface = patch.surface;
  auto grid = vtkSmartPointer<vtkStructuredGrid>::New();
  grid->SetDimensions(surface.count(0), surface.count(1), 1);
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(static_cast<vtkIdType>(surface.points.size()));
  vtkNew<vtkDoubleArray> weights;
  weights->SetName("Weights");
  weights->SetNumberOfValues(points->GetNumberOfPoints());
  for (vtkIdType i = 0; i < points->GetNumberOfPoints(); ++i)
  {
    points->SetPoint(i, surface.points[i].data());
    weights->SetValue(i, surface.rational() ? surface.weights[i] : 1.0);
  }
  grid->SetPoints(points);
  grid->GetPointData()->AddArray(weights);

  vtkFieldData* fields = grid->GetFieldData();
  addField<vtkIntArray>(fields, "Degree", 1, surface.degree);
  addField<vtkDoubleArray>(fields, "KnotsU", 1, surface.knots[0]);
  addField<vtkDoubleArray>(fields, "KnotsV", 1, surface.knots[1]);
  addField<vtkIntArray>(fields, "Reversed", 1, std::vector<int>{ patch.reversed ? 1 : 0 });
  if (!patch.loops.empty())
  {
    std::vector<int> curves;
    std::vector<double> knots;
    std::vector<double> controls;
    for (std::size_t l = 0; l < patch.loops.size(); ++l)
    {
      for (const ParameterCurve& curve : patch.loops[l])
      {
        curves.insert(curves.end(), { static_cast<int>(l), curve.degree, static_cast<int>(curve.points.size()) });
        knots.insert(knots.end(), curve.knots.begin(), curve.knots.end());
        for (std::size_t p = 0; p < curve.points.size(); ++p)
        {
          controls.insert(
            controls.end(), { curve.points[p][0], curve.points[p][1], curve.weights.empty() ? 1.0 : curve.weights[p] });
        }
      }
    }
    addField<vtkIntArray>(fields, "TrimCurves", 3, curves);
    addField<vtkDoubleArray>(fields, "TrimKnots", 1, knots);
    addField<vtkDoubleArray>(fields, "TrimPoints", 3, controls);
  }
  if (!layer.empty())
  {
    vtkNew<vtkStringArray> names;
    names->SetName("Layer");
    names->InsertNextValue(layer);
    fields->AddArray(names);
  }
  return grid;
}

vtkSmartPointer<vtkPolyData> bodySurface(const std::vector<BodyPatch>& patches, const std::vector<int>& vertexPatches,
  const std::vector<Vec2>& vertexParameters, const std::vector<std::array<int, 3>>& triangles, const Execution& run)
{
  const Index count = static_cast<Index>(vertexPatches.size());
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(count);
  vtkNew<vtkIntArray> ids;
  ids->SetName("PatchId");
  ids->SetNumberOfValues(count);
  vtkNew<vtkDoubleArray> parameters;
  parameters->SetName("UV");
  parameters->SetNumberOfComponents(2);
  parameters->SetNumberOfTuples(count);
  vtkNew<vtkDoubleArray> normals;
  normals->SetName("Normals");
  normals->SetNumberOfComponents(3);
  normals->SetNumberOfTuples(count);
  auto* coordinates = vtkDoubleArray::SafeDownCast(points->GetData());
  run.parallelFor(count, 256, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i)
    {
      const BodyPatch& patch = patches[vertexPatches[i]];
      const Vec2& uv = vertexParameters[i];
      const SurfaceGeometry at = surfaceGeometry(patch.surface, uv[0], uv[1], patch.reversed);
      std::copy_n(at.point.data(), 3, coordinates->GetPointer(3 * i));
      ids->SetValue(i, vertexPatches[i]);
      std::copy_n(uv.data(), 2, parameters->GetPointer(2 * i));
      std::copy_n(at.normal.data(), 3, normals->GetPointer(3 * i));
    }
  });
  vtkNew<vtkCellArray> cells;
  cells->AllocateExact(static_cast<vtkIdType>(triangles.size()), 3 * static_cast<vtkIdType>(triangles.size()));
  for (const std::array<int, 3>& triangle : triangles)
  {
    cells->InsertNextCell({ triangle[0], triangle[1], triangle[2] });
  }
  auto surface = vtkSmartPointer<vtkPolyData>::New();
  surface->SetPoints(points);
  surface->SetPolys(cells);
  surface->GetPointData()->AddArray(ids);
  surface->GetPointData()->AddArray(parameters);
  surface->GetPointData()->SetNormals(normals);
  return surface;
}

void setBody(vtkPartitionedDataSetCollection* collection, const std::vector<BodyPatch>& patches,
  const std::vector<std::string>& layers, vtkPolyData* surface)
{
  collection->Initialize();
  const unsigned int count = static_cast<unsigned int>(patches.size());
  collection->SetNumberOfPartitionedDataSets(count + (surface ? 1 : 0));
  vtkNew<vtkDataAssembly> assembly;
  assembly->SetRootNodeName("body");
  const int parent = assembly->AddNode("patches");
  std::set<std::string> used;
  for (unsigned int i = 0; i < count; ++i)
  {
    const std::string& name = patches[i].name;
    const std::string base = nodeName(name.empty() ? "Patch " + std::to_string(i) : name);
    std::string unique = base;
    for (int n = 2; !used.insert(unique).second; ++n)
    {
      unique = base + "_" + std::to_string(n);
    }
    collection->SetPartition(i, 0, patchGrid(patches[i], i < layers.size() ? layers[i] : std::string()));
    collection->GetMetaData(i)->Set(vtkCompositeDataSet::NAME(), name.empty() ? unique.c_str() : name.c_str());
    const int node = assembly->AddNode(unique.c_str(), parent);
    assembly->AddDataSetIndex(node, i);
    assembly->SetAttribute(node, "label", name.c_str());
  }
  if (surface)
  {
    collection->SetPartition(count, 0, surface);
    collection->GetMetaData(count)->Set(vtkCompositeDataSet::NAME(), "surface");
    assembly->AddDataSetIndex(assembly->AddNode("surface"), count);
  }
  collection->SetDataAssembly(assembly);
}

} // namespace bsv
