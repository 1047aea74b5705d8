// SPDX-License-Identifier: BSD-3-Clause
#include "vtkBodyDeviation.h"

#include "vtkCatmullClarkToBSplineVolume.h"

#include "Base/Numbers.h"
#include "Body/ClosestPoint.h"
#include "Body/FaceSurface.h"
#include "Data/BSplineVolumeData.h"
#include "Data/BoundarySelection.h"
#include "Data/NURBSSurfaceData.h"
#include "Data/Verdict.h"
#include "Execution/FilterExecution.h"
#include "Ranks/OwnedValues.h"
#include "Volume/Sampling.h"

#include "vtkCellArray.h"
#include "vtkCellData.h"
#include "vtkCompositeDataSet.h"
#include "vtkDataAssembly.h"
#include "vtkDataObject.h"
#include "vtkDataObjectTree.h"
#include "vtkDataObjectTreeIterator.h"
#include "vtkDataSetAttributes.h"
#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkIntArray.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkTable.h"
#include "vtkUnsignedCharArray.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <set>

vtkStandardNewMacro(vtkBodyDeviation);

namespace
{

using bsv::Index;
using bsv::Vec3;

/// One block face of the wall.
struct WallFace
{
  int block;
  /// Of the volume: the parameters of the surface.
  std::array<int, 2> axes;
  bsv::BodyPatch patch;
};

/// The wall, on all ranks.
std::vector<WallFace> wallFaces(
  const bsv::BSplineVolumeBlocks& input, const std::vector<bool>& isWall, const bsv::Ranks& ranks)
{
  std::vector<bsv::BoundaryPatch> patches;
  for (const bsv::BoundaryPatch& patch : input.boundaries)
  {
    if (isWall[patch.tag])
    {
      patches.push_back(patch);
    }
  }
  std::vector<bsv::NURBSSurface> surfaces = bsv::faceSurfaces(input.volumes, patches, ranks);
  std::vector<WallFace> faces;
  for (std::size_t f = 0; f < patches.size(); ++f)
  {
    const bsv::BoundaryPatch& patch = patches[f];
    bsv::BodyPatch face;
    face.name = "face " + std::to_string(patch.face) + " of " + input.label(patch.block);
    face.surface = std::move(surfaces[f]);
    faces.push_back({ patch.block, { bsv::faceAxis(patch.face, 0), bsv::faceAxis(patch.face, 1) }, std::move(face) });
  }
  return faces;
}

/// Control points of a side of a surface: 0 u first, 1 u last, 2 v first, 3 v last.
std::vector<std::array<double, 3>> sidePoints(const bsv::NURBSSurface& surface, int side)
{
  const int along = side < 2 ? 1 : 0;
  const int fixed = side % 2 ? surface.count(1 - along) - 1 : 0;
  std::vector<std::array<double, 3>> points;
  for (int i = 0; i < surface.count(along); ++i)
  {
    const Index row = surface.count(0);
    const Vec3& x = surface.points[along == 1 ? fixed + row * i : i + row * fixed];
    points.push_back({ x[0], x[1], x[2] });
  }
  return points;
}

/// The outer border of the wall: sides of faces that no other face, nor another side, shares bit for bit.
class WallBorder
{
public:
  explicit WallBorder(const std::vector<WallFace>& faces)
    : Open(faces.size())
  {
    std::map<std::vector<std::array<double, 3>>, int> uses;
    const auto key = [&](std::size_t f, int side) {
      auto points = sidePoints(faces[f].patch.surface, side);
      auto reversed = points;
      std::reverse(reversed.begin(), reversed.end());
      return std::min(points, reversed);
    };
    for (std::size_t f = 0; f < faces.size(); ++f)
    {
      for (int side = 0; side < 4; ++side)
      {
        ++uses[key(f, side)];
      }
    }
    for (std::size_t f = 0; f < faces.size(); ++f)
    {
      for (int side = 0; side < 4; ++side)
      {
        const auto points = key(f, side);
        this->Open[f][side] = uses[points] == 1;
        if (this->Open[f][side])
        {
          this->Ends.insert(points.front());
          this->Ends.insert(points.back());
        }
      }
    }
  }

  bool contains(const bsv::BodyPoint& at, const bsv::NURBSSurface& surface) const
  {
    const std::array<bool, 4> on{ at.u == surface.first(0), at.u == surface.last(0), at.v == surface.first(1),
      at.v == surface.last(1) };
    const std::array<bool, 4>& open = this->Open[at.patch];
    for (int side = 0; side < 4; ++side)
    {
      if (on[side] && open[side])
      {
        return true;
      }
    }
    // A corner can lie on the border although both sides of its face there are shared.
    const Vec3& x = at.geometry.point;
    return (on[0] || on[1]) && (on[2] || on[3]) && this->Ends.count({ x[0], x[1], x[2] }) > 0;
  }

private:
  std::vector<std::array<bool, 4>> Open;
  std::set<std::array<double, 3>> Ends;
};

/// Unsigned angle of two directions in degrees, 0..90; 0 if one of them is zero.
double angle(const Vec3& a, const Vec3& b)
{
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b))) * bsv::DegreesPerRadian;
}

/// A surface against another at one point.
struct Deviation
{
  double distance;
  double angle;
  /// The closest point.
  bsv::BodyPoint foot;
};

Deviation deviation(const Vec3& x, const Vec3& normal, const bsv::BodySurface& other)
{
  const bsv::BodyPoint closest = other.closestPoint(x);
  double smallest = angle(normal, closest.geometry.normal);
  constexpr double Shared = 1e-6;
  for (const bsv::BodyPoint& neighbour : other.closestPointPerPatch(x, Shared * other.size()))
  {
    smallest = std::min(smallest, angle(normal, neighbour.geometry.normal));
  }
  return { closest.distance, smallest, closest };
}

/// Of samples of a surface, or of a part of it.
struct Totals
{
  double maximum = 0.0;
  double maximumAngle = 0.0;
  /// Over the area, of which both have the same multiple.
  double squares = 0.0;
  double area = 0.0;

  void add(const Totals& part)
  {
    this->maximum = std::max(this->maximum, part.maximum);
    this->maximumAngle = std::max(this->maximumAngle, part.maximumAngle);
    this->squares += part.squares;
    this->area += part.area;
  }
  double rms() const { return this->area > 0.0 ? std::sqrt(this->squares / this->area) : 0.0; }
};

/// The point arrays of the samples of a surface.
struct Samples
{
  explicit Samples(vtkPolyData* data)
    : Data(data)
  {
    for (vtkDoubleArray* array : { this->Distance.Get(), this->NormalDeviation.Get() })
    {
      array->SetNumberOfValues(data->GetNumberOfPoints());
      array->Fill(0.0);
      data->GetPointData()->AddArray(array);
    }
    this->Distance->SetName("Distance");
    this->NormalDeviation->SetName("NormalDeviation");
    data->GetPointData()->SetActiveScalars("Distance");
  }

  void set(vtkIdType i, double distance, double normalDeviation)
  {
    this->Distance->SetValue(i, distance);
    this->NormalDeviation->SetValue(i, normalDeviation);
  }

  /// From the first of `points` and `cells` to before the second; only of points for which `counts` is not 0, or of
  /// all. Sequential: its sums must not depend on the threads.
  Totals total(
    std::array<vtkIdType, 2> points, std::array<vtkIdType, 2> cells, vtkUnsignedCharArray* counts = nullptr) const
  {
    const auto has = [&](vtkIdType i) { return !counts || counts->GetValue(i) != 0; };
    Totals totals;
    for (vtkIdType i = points[0]; i < points[1]; ++i)
    {
      if (has(i))
      {
        totals.maximum = std::max(totals.maximum, this->Distance->GetValue(i));
        totals.maximumAngle = std::max(totals.maximumAngle, this->NormalDeviation->GetValue(i));
      }
    }
    for (vtkIdType c = cells[0]; c < cells[1]; ++c)
    {
      vtkIdType size = 0;
      const vtkIdType* ids = nullptr;
      this->Data->GetPolys()->GetCellAtId(c, size, ids);
      if (size < 3 || !std::all_of(ids, ids + size, has))
      {
        continue;
      }
      std::array<Vec3, 3> x;
      const vtkIdType end = ids[size - 1];
      Vec3 twice = Vec3::Zero();
      double mean = 0.0;
      this->Data->GetPoint(end, x[0].data());
      for (vtkIdType v = 0; v < size; ++v)
      {
        mean += this->Distance->GetValue(ids[v]) * this->Distance->GetValue(ids[v]) / static_cast<double>(size);
        if (v + 2 < size)
        {
          this->Data->GetPoint(ids[v], x[1].data());
          this->Data->GetPoint(ids[v + 1], x[2].data());
          twice += (x[1] - x[0]).cross(x[2] - x[0]);
        }
      }
      totals.area += twice.norm();
      totals.squares += twice.norm() * mean;
    }
    return totals;
  }

  vtkPolyData* Data;
  vtkNew<vtkDoubleArray> Distance;
  vtkNew<vtkDoubleArray> NormalDeviation;
};

void setNumber(vtkDataObject* data, const char* name, double value)
{
  vtkNew<vtkDoubleArray> array;
  array->SetName(name);
  array->InsertNextValue(value);
  data->GetFieldData()->AddArray(array);
}

void setTotals(vtkDataObject* data, const Totals& totals)
{
  setNumber(data, "MaximumDistance", totals.maximum);
  setNumber(data, "RMSDistance", totals.rms());
  setNumber(data, "MaximumNormalDeviation", totals.maximumAngle);
}

/// Samples of the wall on this rank: points, quadrilaterals, `BlockId`, the deviation from the body and the feet on it.
/// @return totals of every face that is on this rank.
std::vector<Totals> wallSamples(const std::vector<WallFace>& faces, const bsv::BSplineVolumeBlocks& input, int level,
  const bsv::BodySurface& body, vtkPolyData* wall, const bsv::Execution& run)
{
  struct Grid
  {
    std::size_t face;
    std::array<std::vector<double>, 2> parameters;
    vtkIdType start;
    vtkIdType firstCell;
  };
  double size = 0.0;
  for (const WallFace& face : faces)
  {
    if (input.isHere(face.block))
    {
      const bsv::Ijk counts = bsv::sampleCounts(input.volumes[face.block], level, input.label(face.block));
      size += static_cast<double>(counts[face.axes[0]]) * counts[face.axes[1]];
    }
  }
  // Five triples, distance and angle, the block and a quadrilateral.
  constexpr double BytesPerSample = 5 * 24 + 2 * 8 + 4 + 5 * 8;
  bsv::requireMemory(BytesPerSample * size, "Level " + std::to_string(level), "the samples");
  std::vector<Grid> grids;
  vtkIdType count = 0;
  vtkNew<vtkCellArray> quads;
  for (std::size_t f = 0; f < faces.size(); ++f)
  {
    const WallFace& face = faces[f];
    if (!input.isHere(face.block))
    {
      continue;
    }
    Grid grid;
    grid.face = f;
    for (int d = 0; d < 2; ++d)
    {
      grid.parameters[d] = bsv::sampleParameters(input.volumes[face.block], face.axes[d], level);
    }
    grid.start = count;
    grid.firstCell = quads->GetNumberOfCells();
    const vtkIdType ns = static_cast<vtkIdType>(grid.parameters[0].size());
    const vtkIdType nt = static_cast<vtkIdType>(grid.parameters[1].size());
    for (vtkIdType t = 0; t + 1 < nt; ++t)
    {
      for (vtkIdType s = 0; s + 1 < ns; ++s)
      {
        const vtkIdType first = count + s + ns * t;
        quads->InsertNextCell({ first, first + 1, first + 1 + ns, first + ns });
      }
    }
    count += ns * nt;
    grids.push_back(grid);
  }
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(count);
  vtkNew<vtkIntArray> blocks;
  blocks->SetName("BlockId");
  blocks->SetNumberOfValues(count);
  wall->SetPoints(points);
  wall->SetPolys(quads);
  wall->GetPointData()->AddArray(blocks);
  const auto addTriples = [&](const char* name) {
    vtkNew<vtkDoubleArray> array;
    array->SetName(name);
    array->SetNumberOfComponents(3);
    array->SetNumberOfTuples(count);
    wall->GetPointData()->AddArray(array);
    return array->GetPointer(0);
  };
  double* patchUV = addTriples("PatchUV");
  double* projected = addTriples("ProjectedPoint");
  double* normals = addTriples("SurfaceNormal");
  double* forms = addTriples("SecondFundamentalForm");
  Samples samples(wall);
  std::vector<Totals> totals(faces.size());
  for (const Grid& grid : grids)
  {
    const WallFace& face = faces[grid.face];
    const Index ns = static_cast<Index>(grid.parameters[0].size());
    const Index nt = static_cast<Index>(grid.parameters[1].size());
    run.report(static_cast<double>(&grid - grids.data()) / grids.size());
    run.parallelFor(ns * nt, 64, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i)
      {
        const bsv::SurfaceGeometry at =
          bsv::surfaceGeometry(face.patch.surface, grid.parameters[0][i % ns], grid.parameters[1][i / ns]);
        points->SetPoint(grid.start + i, at.point.data());
        blocks->SetValue(grid.start + i, face.block);
        const Deviation found = deviation(at.point, at.normal, body);
        samples.set(grid.start + i, found.distance, found.angle);
        const bsv::BodyPoint& foot = found.foot;
        const Index to = 3 * (grid.start + i);
        const double parameters[3] = { static_cast<double>(foot.patch), foot.u, foot.v };
        const double form[3] = { foot.geometry.L, foot.geometry.M, foot.geometry.N };
        std::copy_n(parameters, 3, patchUV + to);
        std::copy_n(foot.geometry.point.data(), 3, projected + to);
        std::copy_n(foot.geometry.normal.data(), 3, normals + to);
        std::copy_n(form, 3, forms + to);
      }
    });
    totals[grid.face] =
      samples.total({ grid.start, grid.start + ns * nt }, { grid.firstCell, grid.firstCell + (ns - 1) * (nt - 1) });
  }
  return totals;
}

/// The first tessellation among the leaves of the body, with points in double precision, or null.
vtkSmartPointer<vtkPolyData> tessellation(vtkDataObject* body)
{
  auto* tree = vtkDataObjectTree::SafeDownCast(body);
  if (!tree)
  {
    return nullptr;
  }
  auto iterator = vtkSmartPointer<vtkDataObjectTreeIterator>::Take(tree->NewTreeIterator());
  iterator->VisitOnlyLeavesOn();
  iterator->TraverseSubTreeOn();
  for (iterator->InitTraversal(); !iterator->IsDoneWithTraversal(); iterator->GoToNextItem())
  {
    auto* data = vtkPolyData::SafeDownCast(iterator->GetCurrentDataObject());
    if (data && data->GetNumberOfPoints() > 0)
    {
      auto copy = vtkSmartPointer<vtkPolyData>::New();
      copy->SetPoints(data->GetPoints());
      copy->SetPolys(data->GetPolys());
      copy->GetPointData()->ShallowCopy(data->GetPointData());
      return copy;
    }
  }
  return nullptr;
}

/// Deviation of the body's tessellation, which one rank has, from the wall, and where the wall covers it. Collective.
Totals bodySamples(vtkPolyData* surface, int owner, const bsv::BodySurface& body, const bsv::BodySurface& wall,
  const WallBorder& border, const bsv::Execution& run)
{
  const bsv::Ranks& ranks = *run.ranks;
  const bool isOwner = ranks.rank() == owner;
  using Triple = std::array<double, 3>;
  std::vector<Triple> points, normals;
  run.report(0.0);
  vtkDataArray* array = isOwner ? surface->GetPointData()->GetArray("Normals") : nullptr;
  if (array && (array->GetNumberOfComponents() != 3 || array->GetNumberOfTuples() < surface->GetNumberOfPoints()))
  {
    throw bsv::Error("the body's tessellation: point data array 'Normals' must have 3 components a point");
  }
  for (vtkIdType i = 0; isOwner && i < surface->GetNumberOfPoints(); ++i)
  {
    points.emplace_back();
    surface->GetPoints()->GetPoint(i, points.back().data());
    if (array)
    {
      normals.emplace_back();
      array->GetTuple(i, normals.back().data());
    }
  }
  points = ranks.gatherAll(points);
  normals = ranks.gatherAll(normals);

  struct Answer
  {
    double distance, angle;
    bool covered;
  };
  const auto answers = bsv::sharedOut<Answer>(static_cast<Index>(points.size()), 64, run, [&](Index i) {
    const Vec3 x(points[i].data());
    const Vec3 normal = normals.empty() ? body.closestPoint(x).geometry.normal : Vec3(normals[i].data());
    const Deviation found = deviation(x, normal, wall);
    const bool beyond = border.contains(found.foot, wall.patches()[found.foot.patch].surface) &&
      angle(x - found.foot.geometry.point, found.foot.geometry.normal) > 45.0;
    return Answer{ found.distance, found.angle, !beyond };
  });

  std::vector<Totals> totals(1);
  if (isOwner)
  {
    Samples samples(surface);
    vtkNew<vtkUnsignedCharArray> covered;
    covered->SetName("Covered");
    covered->SetNumberOfValues(surface->GetNumberOfPoints());
    for (vtkIdType i = 0; i < surface->GetNumberOfPoints(); ++i)
    {
      samples.set(i, answers[i].distance, answers[i].angle);
      covered->SetValue(i, answers[i].covered ? 1 : 0);
    }
    totals[0] =
      samples.total({ 0, surface->GetNumberOfPoints() }, { 0, surface->GetPolys()->GetNumberOfCells() }, covered);
    surface->GetPointData()->AddArray(covered);
    // Where the body goes on beyond the wall its distance says nothing: not shown, and not in the range of the colours.
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    for (vtkIdType i = 0; i < surface->GetNumberOfPoints(); ++i)
    {
      if (!answers[i].covered)
      {
        samples.set(i, none, none);
      }
    }
    vtkNew<vtkUnsignedCharArray> hidden;
    hidden->SetName(vtkDataSetAttributes::GhostArrayName());
    hidden->SetNumberOfValues(surface->GetNumberOfPolys());
    for (vtkIdType c = 0; c < surface->GetNumberOfPolys(); ++c)
    {
      vtkIdType size = 0;
      const vtkIdType* ids = nullptr;
      surface->GetPolys()->GetCellAtId(c, size, ids);
      const bool shown = std::all_of(ids, ids + size, [&](vtkIdType i) { return covered->GetValue(i) != 0; });
      hidden->SetValue(c, shown ? 0 : vtkDataSetAttributes::HIDDENCELL);
    }
    surface->GetCellData()->AddArray(hidden);
  }
  ranks.share(totals, [&](Index) { return owner; });
  return totals[0];
}

/// The body of the conversion from which the input of `filter` comes, through any filters between, or null.
vtkDataObject* bodyOfConversion(vtkAlgorithm* filter)
{
  for (vtkAlgorithm* from = filter;
       from && from->GetNumberOfInputPorts() > 0 && from->GetNumberOfInputConnections(0) > 0;)
  {
    from = from->GetInputAlgorithm(0, 0);
    if (vtkCatmullClarkToBSplineVolume::SafeDownCast(from))
    {
      return from->GetNumberOfInputConnections(1) > 0 ? from->GetInputDataObject(1, 0) : nullptr;
    }
  }
  return nullptr;
}

struct Place
{
  double distance;
  Vec3 point;
};

/// Where the wall is farthest from the body. Collective.
Place placeOfMaximum(vtkPolyData* wall, const bsv::Ranks& ranks)
{
  vtkDataArray* distances = wall->GetPointData()->GetArray("Distance");
  using Four = std::array<double, 4>;
  Four worst{ -1.0, 0.0, 0.0, 0.0 };
  for (vtkIdType n = 0; distances && n < distances->GetNumberOfTuples(); ++n)
  {
    Four here{ distances->GetTuple1(n), 0.0, 0.0, 0.0 };
    wall->GetPoint(n, here.data() + 1);
    worst = std::max(worst, here);
  }
  for (const Four& other : ranks.gatherAll(std::vector<Four>{ worst }))
  {
    worst = std::max(worst, other);
  }
  return { worst[0], Vec3(worst.data() + 1) };
}

/// Cross hairs at the place: a point, and lines along the axes, which stand out of the body wherever one looks from.
void setCrossHairs(vtkPolyData* output, const Place& place, const bsv::BodySurface& wall)
{
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  vtkNew<vtkCellArray> verts, lines;
  verts->InsertNextCell({ points->InsertNextPoint(place.point.data()) });
  for (int d = 0; d < 3; ++d)
  {
    const Vec3 half = 0.15 * wall.size() * Vec3::Unit(d);
    lines->InsertNextCell({ points->InsertNextPoint(Vec3(place.point - half).data()),
      points->InsertNextPoint(Vec3(place.point + half).data()) });
  }
  output->SetPoints(points);
  output->SetVerts(verts);
  output->SetLines(lines);
  setNumber(output, "MaximumDistance", place.distance);
}

/// Null parts are on other ranks.
void setParts(vtkPartitionedDataSetCollection* output, vtkPolyData* wall, vtkPolyData* body)
{
  output->SetNumberOfPartitionedDataSets(2);
  vtkNew<vtkDataAssembly> assembly;
  assembly->SetRootNodeName("BodyDeviation");
  unsigned int part = 0;
  for (const auto& [name, data] : { std::make_pair("Wall", wall), std::make_pair("Body", body) })
  {
    if (data)
    {
      output->SetPartition(part, 0, data);
    }
    output->GetMetaData(part)->Set(vtkCompositeDataSet::NAME(), name);
    assembly->AddDataSetIndex(assembly->AddNode(name), part);
    ++part;
  }
  output->SetDataAssembly(assembly);
}

} // namespace

//------------------------------------------------------------------------------
vtkBodyDeviation::vtkBodyDeviation()
{
  this->SetNumberOfInputPorts(2);
  this->SetNumberOfOutputPorts(3);
}

//------------------------------------------------------------------------------
void vtkBodyDeviation::SetBodyConnection(vtkAlgorithmOutput* output)
{
  this->SetInputConnection(1, output);
}

//------------------------------------------------------------------------------
void vtkBodyDeviation::AddBodyBoundary(const char* pattern)
{
  if (pattern && *pattern)
  {
    this->BodyBoundaries.emplace_back(pattern);
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkBodyDeviation::ClearBodyBoundaries()
{
  this->BodyBoundaries.clear();
  this->Modified();
}

//------------------------------------------------------------------------------
const char* vtkBodyDeviation::GetBodyBoundary(int index) const
{
  return index >= 0 && index < this->GetNumberOfBodyBoundaries() ? this->BodyBoundaries[index].c_str() : nullptr;
}

//------------------------------------------------------------------------------
int vtkBodyDeviation::FillInputPortInformation(int, vtkInformation* info)
{
  bsv::acceptMissing(info);
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObjectTree");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkStructuredGrid");
  return 1;
}

//------------------------------------------------------------------------------
int vtkBodyDeviation::FillOutputPortInformation(int port, vtkInformation* info)
{
  static const char* const types[] = { "vtkPartitionedDataSetCollection", "vtkTable", "vtkPolyData" };
  info->Set(vtkDataObject::DATA_TYPE_NAME(), types[port]);
  return 1;
}

//------------------------------------------------------------------------------
int vtkBodyDeviation::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  auto* output = vtkPartitionedDataSetCollection::GetData(outputVector, 0);
  vtkDataObject* given = vtkDataObject::GetData(inputVector[1], 0);
  vtkDataObject* bodyData = given ? given : bodyOfConversion(this);
  auto* verdict = vtkTable::GetData(outputVector, 1);
  auto* crossHairs = vtkPolyData::GetData(outputVector, 2);
  if (!output || !verdict || !crossHairs)
  {
    vtkErrorMacro("Output is missing.");
    return 0;
  }
  crossHairs->Initialize();
  this->Report.clear();
  bsv::setText(verdict, "");
  this->MaximumDistance = this->RMSDistance = this->MaximumNormalDeviation = this->HausdorffDistance = 0.0;
  return bsv::execute(this, [&] {
    const bsv::Execution run = bsv::filterExecution(this, 0.0, 0.1);
    const bsv::Ranks& ranks = *run.ranks;
    if (!ranks.any(bodyData != nullptr))
    {
      throw bsv::Error("Body is missing: choose a NURBS surface, or give one to the conversion");
    }
    const bsv::BSplineVolumeBlocks input = bsv::bsplineVolumeBlocks(bsv::requiredInput(inputVector, 0), ranks);
    bsv::requireVolumes(input);
    const std::vector<WallFace> faces = wallFaces(input,
      bsv::wallBoundaries(vtkDataObject::GetData(inputVector[0], 0), input.boundaryNames, input.boundaryTypes,
        this->BodyBoundaries, ranks),
      ranks);
    if (faces.empty())
    {
      throw bsv::Error("no boundary of the volume is part of the body: Body Boundaries are " +
        bsv::quotedList(this->BodyBoundaries) + ", the volume has the boundaries " +
        bsv::quotedList(input.boundaryNames));
    }

    bsv::warn(this,
      bsv::uselessPatterns("Body Boundaries", this->BodyBoundaries, bsv::defaultBodyBoundaries(), input.boundaryNames,
        input.boundaryTypes));
    // Every rank has both surfaces.
    const std::vector<bsv::BodyPatch> bodyPatches = bsv::bodyPatches(bodyData, ranks);
    std::vector<bsv::BodyPatch> wallPatches;
    for (const WallFace& face : faces)
    {
      wallPatches.push_back(face.patch);
    }
    const bsv::BodySurface body(bodyPatches, run);
    const bsv::BodySurface wall(wallPatches, bsv::filterExecution(this, 0.1, 0.2));

    vtkNew<vtkPolyData> wallData;
    std::vector<Totals> perFace =
      wallSamples(faces, input, this->Level, body, wallData, bsv::filterExecution(this, 0.2, 0.7));
    ranks.share(perFace, [&](Index f) { return input.ranks[faces[f].block]; });
    Totals ofWall;
    for (const Totals& face : perFace)
    {
      ofWall.add(face);
    }
    setTotals(wallData, ofWall);
    this->MaximumDistance = ofWall.maximum;
    this->RMSDistance = ofWall.rms();
    this->MaximumNormalDeviation = ofWall.maximumAngle;
    this->HausdorffDistance = ofWall.maximum;

    // The tessellation may be on some ranks only, or the same on several.
    vtkSmartPointer<vtkPolyData> surface = tessellation(bodyData);
    const std::vector<int> found = ranks.gatherAll(std::vector<int>{ surface ? 1 : 0 });
    const auto first = std::find(found.begin(), found.end(), 1);
    const int owner = first == found.end() ? 0 : static_cast<int>(first - found.begin());
    if (first != found.end())
    {
      const Totals ofBody =
        bodySamples(surface, owner, body, wall, WallBorder(faces), bsv::filterExecution(this, 0.7, 1.0));
      this->HausdorffDistance = std::max(ofWall.maximum, ofBody.maximum);
      if (ranks.rank() == owner)
      {
        setTotals(surface, ofBody);
      }
    }
    else
    {
      surface = vtkSmartPointer<vtkPolyData>::New();
    }

    setParts(output, wallData->GetNumberOfPoints() > 0 ? wallData.Get() : nullptr,
      ranks.rank() == owner ? surface.Get() : nullptr);
    setTotals(output, ofWall);
    setNumber(output, "HausdorffDistance", this->HausdorffDistance);
    const std::string text = "Wall and body: at most " + bsv::shortNumber(this->MaximumDistance) +
      " apart (length unit of the mesh), " + bsv::shortNumber(this->RMSDistance) + " in the mean square\n" +
      "Normals: at most " + bsv::shortNumber(this->MaximumNormalDeviation) + " degrees apart";
    bsv::setText(verdict, text);
    const Place farthest = placeOfMaximum(wallData, ranks);
    if (ranks.rank() == 0)
    {
      setCrossHairs(crossHairs, farthest, wall);
    }
    this->Report = text + "\nHausdorff distance, over the samples: " + bsv::shortNumber(this->HausdorffDistance) +
      "\nfarthest at " + bsv::shortNumber(farthest.point[0]) + ' ' + bsv::shortNumber(farthest.point[1]) + ' ' +
      bsv::shortNumber(farthest.point[2]) + '\n' + std::to_string(faces.size()) + " faces of the wall, " +
      std::to_string(bodyPatches.size()) + " patches of the body\n";
  });
}

//------------------------------------------------------------------------------
void vtkBodyDeviation::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "BodyBoundaries: " << bsv::quotedList(this->BodyBoundaries) << '\n';
  os << indent << "Level: " << this->Level << '\n';
  os << indent << "MaximumDistance: " << this->MaximumDistance << '\n';
  os << indent << "RMSDistance: " << this->RMSDistance << '\n';
  os << indent << "MaximumNormalDeviation: " << this->MaximumNormalDeviation << '\n';
  os << indent << "HausdorffDistance: " << this->HausdorffDistance << '\n';
}
