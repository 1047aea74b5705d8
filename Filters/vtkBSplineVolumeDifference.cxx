// SPDX-License-Identifier: BSD-3-Clause
#include "vtkBSplineVolumeDifference.h"

#include "Data/BSplineVolumeData.h"
#include "Data/BoundarySelection.h"
#include "Data/FaceBounds.h"
#include "Data/HexBlockData.h"
#include "Data/Verdict.h"
#include "Execution/FilterExecution.h"
#include "Quality/JoinClass.h"
#include "Quality/Smoothness.h"
#include "Volume/FaceGeometry.h"
#include "Volume/VolumeInterfaces.h"

#include "vtkCellArray.h"
#include "vtkCompositeDataSet.h"
#include "vtkDataAssembly.h"
#include "vtkDataObject.h"
#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkFloatArray.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkSmartPointer.h"
#include "vtkStringArray.h"
#include "vtkStructuredGrid.h"
#include "vtkTable.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

vtkStandardNewMacro(vtkBSplineVolumeDifference);

namespace
{

using bsv::Index;
using bsv::Vec3;

/// First and last parameter.
std::array<double, 2> range(const bsv::BSplineVolume& volume, int direction)
{
  const std::vector<double>& knots = volume.knots[direction];
  return { knots[volume.degree[direction]], knots[knots.size() - 1 - volume.degree[direction]] };
}

/// Points of both volumes at equal parameters of a face, after and before; the first axis of the face fastest.
std::array<std::vector<Vec3>, 2> facePoints(const bsv::BSplineVolume& after, const bsv::BSplineVolume& before, int face,
  const std::array<std::vector<double>, 2>& parameters, const bsv::Execution& run)
{
  const int along[2] = { bsv::faceAxis(face, 0), bsv::faceAxis(face, 1) };
  const std::vector<double>& s = parameters[0];
  const std::vector<double>& t = parameters[1];
  std::array<std::vector<Vec3>, 2> points;
  points[0].resize(s.size() * t.size());
  points[1].resize(s.size() * t.size());
  run.parallelFor(static_cast<Index>(t.size()), 4, [&](Index begin, Index end) {
    Vec3 uvw;
    uvw[bsv::faceDirection(face)] = range(after, bsv::faceDirection(face))[bsv::faceSide(face)];
    for (Index row = begin; row < end; ++row)
    {
      uvw[along[1]] = t[row];
      for (std::size_t column = 0; column < s.size(); ++column)
      {
        uvw[along[0]] = s[column];
        points[0][column + s.size() * row] = bsv::evaluate(after, uvw);
        points[1][column + s.size() * row] = bsv::evaluate(before, uvw);
      }
    }
  });
  return points;
}

/// Throws where the two volumes cannot be compared at equal parameters.
void checkAlike(const bsv::BSplineVolumeBlocks& after, const bsv::BSplineVolumeBlocks& before)
{
  if (after.volumes.size() != before.volumes.size())
  {
    throw bsv::Error("the volumes have " + std::to_string(after.volumes.size()) + " and " +
      std::to_string(before.volumes.size()) + " blocks: only volumes of the same blocks can be compared");
  }
  for (std::size_t b = 0; b < after.volumes.size(); ++b)
  {
    for (int d = 0; d < 3; ++d)
    {
      const auto [low, high] = range(after.volumes[b], d);
      const auto [lowBefore, highBefore] = range(before.volumes[b], d);
      if (low != lowBefore || high != highBefore)
      {
        throw bsv::Error(after.label(b) + " goes from " + bsv::shortNumber(low) + " to " + bsv::shortNumber(high) +
          " in direction " + "uvw"[d] + ", before from " + bsv::shortNumber(lowBefore) + " to " +
          bsv::shortNumber(highBefore) + ": not the same blocks");
      }
    }
    if (after.ranks[b] != before.ranks[b])
    {
      throw bsv::Error(after.label(b) + " is on another rank than before");
    }
  }
}

/// Whether control points correspond.
bool sameKnots(const bsv::BSplineVolume& one, const bsv::BSplineVolume& other)
{
  return one.degree == other.degree && one.knots == other.knots;
}

/// Point arrays of displacements.
class Displacements
{
public:
  Displacements()
  {
    this->Vectors->SetName("Displacement");
    this->Vectors->SetNumberOfComponents(3);
    this->Lengths->SetName("Moved");
  }

  void add(const Vec3& after, const Vec3& before)
  {
    const Vec3 moved = after - before;
    this->Vectors->InsertNextTuple(moved.data());
    this->Lengths->InsertNextValue(moved.norm());
  }

  void attach(vtkDataSet* data)
  {
    data->GetPointData()->AddArray(this->Vectors);
    data->GetPointData()->AddArray(this->Lengths);
    data->GetPointData()->SetActiveScalars("Moved");
  }

private:
  vtkNew<vtkDoubleArray> Vectors, Lengths;
};

/// The largest displacement, and where it is: the same for any order.
struct Farthest
{
  double length = -1.0;
  std::array<double, 3> point{};
  int block = -1;

  void add(const Vec3& after, const Vec3& before, int where)
  {
    const Farthest here{ (after - before).norm(), { after[0], after[1], after[2] }, where };
    *this = std::max(*this, here);
  }
  bool operator<(const Farthest& other) const
  {
    return std::tie(this->length, this->point, this->block) < std::tie(other.length, other.point, other.block);
  }
  /// Collective.
  Farthest ofAll(const bsv::Ranks& ranks) const
  {
    const std::vector<Farthest> all = ranks.gatherAll(std::vector<Farthest>{ *this });
    return *std::max_element(all.begin(), all.end());
  }
};

std::vector<bsv::Interface> interfacesOf(const bsv::BSplineVolumeBlocks& volume, const bsv::Execution& run)
{
  if (volume.hasInterfaces)
  {
    return volume.interfaces;
  }
  bsv::VolumeInterfaceOptions search;
  search.boundaries = volume.boundaries;
  search.blockName = [&](int block) { return volume.label(block); };
  return bsv::findVolumeInterfaces(volume.volumes, search, run);
}

/// The faces of the wall, or all outer faces. @param wall per boundary
std::vector<bool> wallFaces(
  const bsv::BSplineVolumeBlocks& volume, const std::vector<bsv::Interface>& interfaces, const std::vector<bool>& wall)
{
  std::vector<bool> faces = bsv::facesOf(volume, wall);
  if (std::find(faces.begin(), faces.end(), true) == faces.end())
  {
    faces.assign(faces.size(), true);
    for (const bsv::Interface& contact : interfaces)
    {
      faces[6 * std::size_t(contact.blockA) + contact.faceA] = false;
      faces[6 * std::size_t(contact.blockB) + contact.faceB] = false;
    }
  }
  return faces;
}

bsv::SmoothnessResult joinsOf(const bsv::BSplineVolumeBlocks& volume, const std::vector<bsv::Interface>& interfaces,
  const std::vector<bool>& wall, int samples, const bsv::Execution& run)
{
  bsv::SmoothnessOptions options;
  options.samplesPerSpan = samples;
  options.isWall = [&](int block, int face) { return wall[6 * std::size_t(block) + face]; };
  options.rules = volume.rules;
  options.blockName = [&](int block) { return volume.label(block); };
  return bsv::measureSmoothness(volume.volumes, interfaces, options, run);
}

/// Blocks, faces and edges of both sides, and whether it is inside a block.
using JoinKey = std::array<int, 7>;

JoinKey keyOf(const bsv::Join& join)
{
  const auto& [a, b] = join.sides;
  const int inner = join.inner() ? 1 : 0;
  const JoinKey key{ a.block, a.face, a.edge, b.block, b.face, b.edge, inner };
  const JoinKey turned{ b.block, b.face, b.edge, a.block, a.face, a.edge, inner };
  return std::min(key, turned);
}

/// A join in both volumes, with all its parts.
struct Change
{
  double before, after;
  std::string blocks;
  bsv::JoinClass classBefore, classAfter;

  double change() const { return this->after - this->before; }
};

double jumpOf(const bsv::Join& join)
{
  return join.worst[static_cast<int>(join.crease ? bsv::JumpKind::NormalS : bsv::JumpKind::Layer)].value;
}

/// The largest changes first.
std::vector<Change> changes(
  const bsv::SmoothnessResult& after, const bsv::SmoothnessResult& before, const std::vector<std::string>& names)
{
  const auto worstOf = [](const bsv::SmoothnessResult& result) {
    std::map<JoinKey, std::pair<double, bsv::JoinClass>> worst;
    for (const bsv::Join& join : result.joins)
    {
      const auto [found, isNew] = worst.emplace(keyOf(join), std::pair(jumpOf(join), bsv::classifyJoin(join).of));
      if (!isNew)
      {
        found->second.first = std::max(found->second.first, jumpOf(join));
        found->second.second = std::min(found->second.second, bsv::classifyJoin(join).of);
      }
    }
    return worst;
  };
  const auto old = worstOf(before);
  auto now = worstOf(after);
  std::vector<Change> list;
  for (const bsv::Join& join : after.joins)
  {
    const auto found = old.find(keyOf(join));
    const auto here = now.find(keyOf(join));
    if (found != old.end() && here != now.end())
    {
      list.push_back({ found->second.first, here->second.first, bsv::blocksText(join, names), found->second.second,
        here->second.second });
      now.erase(here);
    }
  }
  std::stable_sort(list.begin(), list.end(),
    [](const Change& a, const Change& b) { return std::abs(a.change()) > std::abs(b.change()); });
  return list;
}

void fillTable(vtkTable* table, const std::vector<Change>& list)
{
  const auto numbers = [&](const char* name, const auto& get) {
    vtkNew<vtkDoubleArray> column;
    column->SetName(name);
    for (const Change& change : list)
    {
      column->InsertNextValue(get(change));
    }
    table->AddColumn(column);
  };
  const auto texts = [&](const char* name, const auto& get) {
    vtkNew<vtkStringArray> column;
    column->SetName(name);
    for (const Change& change : list)
    {
      column->InsertNextValue(get(change));
    }
    table->AddColumn(column);
  };
  numbers("1 Change (degrees)", [](const Change& change) { return change.change(); });
  numbers("2 Before (degrees)", [](const Change& change) { return change.before; });
  numbers("3 After (degrees)", [](const Change& change) { return change.after; });
  texts("4 Blocks", [](const Change& change) { return change.blocks; });
  texts("5 Class Before", [](const Change& change) { return std::string(bsv::joinClassName(change.classBefore)); });
  texts("6 Class After", [](const Change& change) { return std::string(bsv::joinClassName(change.classAfter)); });
}

/// The wall of one block.
class WallBuilder
{
public:
  WallBuilder()
  {
    this->Points->SetDataTypeToDouble();
    this->Normals->SetName("Normals");
    this->Normals->SetNumberOfComponents(3);
  }

  /// @param points after and before
  void add(const bsv::FaceGeometry& after, const std::array<std::vector<Vec3>, 2>& points)
  {
    const vtkIdType first = this->Points->GetNumberOfPoints();
    const vtkIdType ns = after.samples[0], nt = after.samples[1];
    for (std::size_t n = 0; n < after.points.size(); ++n)
    {
      this->Points->InsertNextPoint(points[0][n].data());
      this->Normals->InsertNextTuple(after.normals[n].data());
      this->Moved.add(points[0][n], points[1][n]);
    }
    for (vtkIdType t = 0; t + 1 < nt; ++t)
    {
      for (vtkIdType s = 0; s + 1 < ns; ++s)
      {
        if (after.parameters[0][s] == after.parameters[0][s + 1] ||
          after.parameters[1][t] == after.parameters[1][t + 1])
        {
          continue;
        }
        const vtkIdType p = first + s + ns * t;
        this->Quads->InsertNextCell({ p, p + 1, p + 1 + ns, p + ns });
      }
    }
  }

  vtkSmartPointer<vtkPolyData> build()
  {
    auto data = vtkSmartPointer<vtkPolyData>::New();
    data->SetPoints(this->Points);
    data->SetPolys(this->Quads);
    data->GetPointData()->SetNormals(this->Normals);
    this->Moved.attach(data);
    return data;
  }

private:
  vtkNew<vtkPoints> Points;
  vtkNew<vtkFloatArray> Normals;
  vtkNew<vtkCellArray> Quads;
  Displacements Moved;
};

/// Data sets of other ranks are null. Only blocks for which `has` says so, which is the same on all ranks, are listed.
template <typename Data>
void setBlocks(vtkPartitionedDataSetCollection* output, const std::vector<vtkSmartPointer<Data>>& blocks,
  const std::vector<bool>& has, const std::vector<std::string>& names, const char* root)
{
  vtkNew<vtkDataAssembly> assembly;
  assembly->SetRootNodeName(root);
  unsigned int part = 0;
  for (std::size_t b = 0; b < blocks.size(); ++b)
  {
    if (!has[b])
    {
      continue;
    }
    output->SetNumberOfPartitionedDataSets(part + 1);
    if (blocks[b])
    {
      output->SetPartition(part, 0, blocks[b]);
    }
    output->GetMetaData(part)->Set(vtkCompositeDataSet::NAME(), names[b].c_str());
    const int node = assembly->AddNode(bsv::nodeName(names[b]).c_str());
    assembly->AddDataSetIndex(node, part);
    assembly->SetAttribute(node, "label", names[b].c_str());
    ++part;
  }
  output->SetDataAssembly(assembly);
}

std::string placeText(const Farthest& place)
{
  return bsv::shortNumber(place.point[0]) + ' ' + bsv::shortNumber(place.point[1]) + ' ' +
    bsv::shortNumber(place.point[2]);
}

} // namespace

//------------------------------------------------------------------------------
vtkBSplineVolumeDifference::vtkBSplineVolumeDifference()
{
  this->SetNumberOfInputPorts(2);
  this->SetNumberOfOutputPorts(4);
}

//------------------------------------------------------------------------------
void vtkBSplineVolumeDifference::SetBeforeConnection(vtkAlgorithmOutput* output)
{
  this->SetInputConnection(1, output);
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeDifference::FillInputPortInformation(int, vtkInformation* info)
{
  bsv::acceptMissing(info);
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObjectTree");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkStructuredGrid");
  return 1;
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeDifference::FillOutputPortInformation(int port, vtkInformation* info)
{
  static constexpr const char* Types[] = { "vtkPartitionedDataSetCollection", "vtkPartitionedDataSetCollection",
    "vtkTable", "vtkTable" };
  info->Set(vtkDataObject::DATA_TYPE_NAME(), Types[port]);
  return 1;
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeDifference::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  auto* wallOutput = vtkPartitionedDataSetCollection::GetData(outputVector, 0);
  auto* netOutput = vtkPartitionedDataSetCollection::GetData(outputVector, 1);
  auto* table = vtkTable::GetData(outputVector, 2);
  auto* verdict = vtkTable::GetData(outputVector, 3);
  if (!wallOutput || !netOutput || !table || !verdict)
  {
    vtkErrorMacro("An output is missing.");
    return 0;
  }
  this->MaximumWallDisplacement = this->MaximumDisplacement = 0.0;
  this->NumberOfSmootherJoins = this->NumberOfRougherJoins = 0;
  this->NumberOfDefectsBefore = this->NumberOfDefects = 0;
  this->Report.clear();
  bsv::setText(verdict, "");

  return bsv::execute(this, [&] {
    const bsv::Execution run = bsv::filterExecution(this, 0.0, 0.1);
    const bsv::Ranks& ranks = *run.ranks;
    vtkDataObject* input = bsv::requiredInput(inputVector, 0);
    const bsv::BSplineVolumeBlocks after = bsv::bsplineVolumeBlocks(input, ranks);
    const bsv::BSplineVolumeBlocks before = bsv::bsplineVolumeBlocks(
      bsv::requiredInput(inputVector, 1, "Before: choose the B-spline volume to compare with"), ranks);
    bsv::requireVolumes(after);
    bsv::requireVolumes(before, "Before");
    checkAlike(after, before);
    double controlPoints = 0.0;
    for (std::size_t b = 0; b < after.volumes.size(); ++b)
    {
      controlPoints += after.isHere(b) ? static_cast<double>(after.grids[b]->GetNumberOfPoints()) : 0.0;
    }
    bsv::requireMemory(controlPoints * 4 * sizeof(double), "the volume", "the displacements of its control points");
    const std::vector<bsv::Interface> interfaces = interfacesOf(after, run);
    std::size_t otherKnots = 0;
    for (std::size_t b = 0; b < after.volumes.size(); ++b)
    {
      otherKnots += sameKnots(after.volumes[b], before.volumes[b]) ? 0 : 1;
    }
    const std::vector<bool> wall = wallFaces(after, interfaces,
      bsv::wallBoundaries(input, after.boundaryNames, after.boundaryTypes, bsv::defaultBodyBoundaries(), ranks));

    // The wall and the control points.
    Farthest onWall, anywhere;
    std::vector<vtkSmartPointer<vtkPolyData>> walls(after.volumes.size());
    std::vector<vtkSmartPointer<vtkStructuredGrid>> nets(after.volumes.size());
    std::vector<bool> hasWall(after.volumes.size(), false);
    Index moved = 0, all = 0;
    bsv::Execution here = bsv::filterExecution(this, 0.1, 0.4);
    const auto progress = here.progress;
    here.ranks = bsv::aloneRank();
    for (std::size_t b = 0; b < after.volumes.size(); ++b)
    {
      // Every face would begin anew.
      here.progress = [&](double) {
        return progress(static_cast<double>(b) / static_cast<double>(after.volumes.size()));
      };
      here.report(0.0);
      WallBuilder builder;
      for (int face = 0; face < 6; ++face)
      {
        if (!wall[6 * b + face])
        {
          continue;
        }
        hasWall[b] = true;
        if (after.isHere(b))
        {
          const auto geometry = bsv::faceGeometry(after.volumes[b], face, this->SamplesPerSpan, here, 0, true);
          const auto points = facePoints(after.volumes[b], before.volumes[b], face, geometry.parameters, here);
          builder.add(geometry, points);
          for (std::size_t n = 0; n < points[0].size(); ++n)
          {
            onWall.add(points[0][n], points[1][n], static_cast<int>(b));
          }
        }
      }
      if (!after.isHere(b))
      {
        continue;
      }
      walls[b] = hasWall[b] ? builder.build() : nullptr;
      nets[b] = vtkSmartPointer<vtkStructuredGrid>::New();
      nets[b]->ShallowCopy(after.grids[b]);
      if (!sameKnots(after.volumes[b], before.volumes[b]))
      {
        continue;
      }
      Displacements displacements;
      const double *x = after.volumes[b].points, *y = before.volumes[b].points;
      for (vtkIdType n = 0; n < nets[b]->GetNumberOfPoints(); ++n)
      {
        const Vec3 now(x + 3 * n), then(y + 3 * n);
        displacements.add(now, then);
        anywhere.add(now, then, static_cast<int>(b));
        moved += now == then ? 0 : 1;
        ++all;
      }
      displacements.attach(nets[b]);
    }
    setBlocks(wallOutput, walls, hasWall, after.names, "Wall");
    setBlocks(netOutput, nets, std::vector<bool>(after.volumes.size(), true), after.names, "ControlPoints");
    netOutput->GetFieldData()->ShallowCopy(input->GetFieldData());
    onWall = onWall.ofAll(ranks);
    anywhere = anywhere.ofAll(ranks);
    Index totalMoved = 0, total = 0;
    for (const std::array<Index, 2>& mine : ranks.gatherAll(std::vector<std::array<Index, 2>>{ { moved, all } }))
    {
      totalMoved += mine[0];
      total += mine[1];
    }
    this->MaximumWallDisplacement = std::max(onWall.length, 0.0);
    this->MaximumDisplacement = std::max(anywhere.length, 0.0);

    // The joins.
    const bsv::SmoothnessResult now =
      joinsOf(after, interfaces, wall, this->SamplesPerSpan, bsv::filterExecution(this, 0.4, 0.7));
    const bsv::SmoothnessResult then =
      joinsOf(before, interfaces, wall, this->SamplesPerSpan, bsv::filterExecution(this, 0.7, 1.0));
    const std::vector<Change> list = changes(now, then, after.names);
    fillTable(table, ranks.rank() == 0 ? list : std::vector<Change>());
    for (const Change& change : list)
    {
      this->NumberOfSmootherJoins += change.change() < -this->LeastChange ? 1 : 0;
      this->NumberOfRougherJoins += change.change() > this->LeastChange ? 1 : 0;
      this->NumberOfDefectsBefore += change.classBefore == bsv::JoinClass::Defect ? 1 : 0;
      this->NumberOfDefects += change.classAfter == bsv::JoinClass::Defect ? 1 : 0;
    }
    const int asBefore = static_cast<int>(list.size()) - this->NumberOfSmootherJoins - this->NumberOfRougherJoins;
    const bool same = totalMoved == 0 && otherKnots == 0;
    const std::string text = (same ? std::string("Control points: all the same, bit for bit")
                                   : "Wall: moved by at most " + bsv::shortNumber(this->MaximumWallDisplacement) +
                                   ", at " + placeText(onWall)) +
      "\nJoins: " + std::to_string(this->NumberOfSmootherJoins) + " smoother, " +
      std::to_string(this->NumberOfRougherJoins) + " rougher, " + std::to_string(asBefore) +
      " as before\nDefects: " + std::to_string(this->NumberOfDefectsBefore) + " before, " +
      std::to_string(this->NumberOfDefects) + " after";
    bsv::setText(verdict, text);
    this->Report = text + '\n';
    if (onWall.block >= 0)
    {
      this->Report += "the wall moved most in " + after.names[onWall.block] + "; lengths are in the unit of the mesh\n";
    }
    if (totalMoved > 0)
    {
      this->Report += std::to_string(totalMoved) + " of " + std::to_string(total) +
        " control points moved, at most by " + bsv::shortNumber(this->MaximumDisplacement) + " at " +
        placeText(anywhere) + ", " + after.names[anywhere.block] + '\n';
    }
    if (otherKnots > 0)
    {
      this->Report += std::to_string(otherKnots) + " of " + std::to_string(after.volumes.size()) +
        " blocks have other degrees or knots: their control points are not compared\n";
    }
    this->Report += "joins within " + bsv::shortNumber(this->LeastChange) + " degrees are as before\n";
    const auto most = [&](const char* what, double sign) {
      const auto found = std::find_if(
        list.begin(), list.end(), [&](const Change& change) { return sign * change.change() > this->LeastChange; });
      if (found != list.end())
      {
        this->Report += std::string(what) + ": " + found->blocks + ", " + bsv::shortNumber(found->before) +
          " degrees before, " + bsv::shortNumber(found->after) + " after\n";
      }
    };
    most("most of all smoother", -1.0);
    most("most of all rougher", 1.0);
    this->UpdateProgress(1.0);
  });
}

//------------------------------------------------------------------------------
void vtkBSplineVolumeDifference::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "SamplesPerSpan: " << this->SamplesPerSpan << '\n';
  os << indent << "LeastChange: " << this->LeastChange << '\n';
  os << indent << "Report: " << this->Report << '\n';
}
