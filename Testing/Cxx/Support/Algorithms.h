// SPDX-License-Identifier: BSD-3-Clause
/// @file Algorithms.h
/// Every filter, reader and writer, each with a small input, for tests of what holds for all of them.
#pragma once

#include "vtkBSplineVolumeDifference.h"
#include "vtkBSplineVolumeIsoparametric.h"
#include "vtkBSplineVolumeProbe.h"
#include "vtkBSplineVolumeQuality.h"
#include "vtkBSplineVolumeReader.h"
#include "vtkBSplineVolumeSampler.h"
#include "vtkBSplineVolumeSmoothness.h"
#include "vtkBSplineVolumeToBezier.h"
#include "vtkBSplineVolumeWriter.h"
#include "vtkBodyDeviation.h"
#include "vtkCatmullClarkToBSplineVolume.h"
#include "vtkHexBlockMeshReader.h"
#include "vtkHexBlockMeshWriter.h"
#include "vtkHexBlockTopology.h"
#include "vtkHexMeshToBlocks.h"
#include "vtkMirrorHexBlocks.h"
#include "vtkNURBSSurfaceReader.h"
#include "vtkNURBSSurfaceWriter.h"
#include "vtkQuadflowReader.h"
#include "vtkQuadflowWriter.h"
#include "vtkWallSpacing.h"
#include "vtkWingFuselageSource.h"

#include <vtkCellType.h>
#include <vtkCommand.h>
#include <vtkDataArray.h>
#include <vtkExecutive.h>
#include <vtkFieldData.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPartitionedDataSetCollection.h>
#include <vtkPointSet.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>
#include <vtkTable.h>
#include <vtkUnstructuredGrid.h>
#include <vtkWriter.h>

#include <functional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace algorithms
{

/// Counts from 1 the calls in which something may be made to happen.
using Steps = std::function<void(int step, vtkAlgorithm* algorithm)>;

/// What an algorithm told while it ran.
struct Told
{
  std::vector<std::string> messages;
  std::vector<double> progress;
};

/// Runs `algorithm` for a piece: `atProgress` is called after each report of progress.
inline Told run(vtkAlgorithm* algorithm, const Steps& atProgress = {}, int piece = 0, int pieces = 1)
{
  struct Listener : vtkCommand
  {
    static Listener* New() { return new Listener; }
    Told told;
    Steps steps;
    void Execute(vtkObject* caller, unsigned long event, void* data) override
    {
      if (event != vtkCommand::ProgressEvent)
      {
        this->told.messages.emplace_back(static_cast<const char*>(data));
        return;
      }
      this->told.progress.push_back(static_cast<vtkAlgorithm*>(caller)->GetProgress());
      if (this->steps)
      {
        this->steps(static_cast<int>(this->told.progress.size()), static_cast<vtkAlgorithm*>(caller));
      }
    }
  };
  vtkNew<Listener> listener;
  listener->steps = atProgress;
  std::vector<std::pair<vtkObject*, unsigned long>> tags;
  for (vtkObject* object : { static_cast<vtkObject*>(algorithm), static_cast<vtkObject*>(algorithm->GetExecutive()) })
  {
    tags.emplace_back(object, object->AddObserver(vtkCommand::ErrorEvent, listener));
    tags.emplace_back(object, object->AddObserver(vtkCommand::WarningEvent, listener));
  }
  tags.emplace_back(algorithm, algorithm->AddObserver(vtkCommand::ProgressEvent, listener));
  algorithm->Modified();
  if (auto* writer = vtkWriter::SafeDownCast(algorithm))
  {
    writer->Write();
  }
  else
  {
    algorithm->UpdatePiece(piece, pieces, 0);
  }
  for (const auto& [object, tag] : tags)
  {
    object->RemoveObserver(tag);
  }
  return listener->told;
}

/// Elements of all kinds in all outputs, blocks of collections and columns of tables.
inline vtkIdType sizeOfOutputs(vtkAlgorithm* algorithm)
{
  vtkIdType size = 0;
  for (int port = 0; port < algorithm->GetNumberOfOutputPorts(); ++port)
  {
    vtkDataObject* output = algorithm->GetOutputDataObject(port);
    for (const int kind : { vtkDataObject::POINT, vtkDataObject::CELL, vtkDataObject::ROW })
    {
      size += output->GetNumberOfElements(kind);
    }
    if (auto* collection = vtkPartitionedDataSetCollection::SafeDownCast(output))
    {
      size += collection->GetNumberOfPartitionedDataSets();
    }
    if (auto* table = vtkTable::SafeDownCast(output))
    {
      size += table->GetNumberOfColumns();
    }
    size += output->GetFieldData()->GetNumberOfArrays();
  }
  return size;
}

/// The unit cube of n^3 hexahedra.
inline vtkSmartPointer<vtkUnstructuredGrid> hexahedra(int n)
{
  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  const auto at = [n](int i, int j, int k) { return static_cast<vtkIdType>(i + (n + 1) * (j + (n + 1) * k)); };
  for (int k = 0; k <= n; ++k)
  {
    for (int j = 0; j <= n; ++j)
    {
      for (int i = 0; i <= n; ++i)
      {
        points->InsertNextPoint(double(i) / n, double(j) / n, double(k) / n);
        if (i < n && j < n && k < n)
        {
          const vtkIdType corners[8] = { at(i, j, k), at(i + 1, j, k), at(i + 1, j + 1, k), at(i, j + 1, k),
            at(i, j, k + 1), at(i + 1, j, k + 1), at(i + 1, j + 1, k + 1), at(i, j + 1, k + 1) };
          grid->InsertNextCell(VTK_HEXAHEDRON, 8, corners);
        }
      }
    }
  }
  grid->SetPoints(points);
  return grid;
}

/// Data and files that the algorithms take: the wing and fuselage.
class Inputs
{
public:
  /// @param folder for files, ends with a slash. @param resolution of the wing and fuselage, at least 2.
  explicit Inputs(std::string folder, int resolution = 2)
    : Folder(std::move(folder))
    , Resolution(resolution)
  {
    vtkNew<vtkWingFuselageSource> source;
    source->SetResolution(resolution);
    source->Update();
    this->Mesh = copy(source->GetOutputDataObject(0));
    this->Body = copy(source->GetOutputDataObject(1));
    this->Hexahedra = hexahedra(2 * resolution);
    vtkNew<vtkCatmullClarkToBSplineVolume> convert;
    convert->SetInputDataObject(0, this->Mesh);
    convert->SetCheckJoins(false);
    convert->Update();
    this->Volume = copy(convert->GetOutputDataObject(0));
  }

  struct Case
  {
    std::string name;
    std::function<vtkSmartPointer<vtkAlgorithm>()> make;
    /// What a writer writes.
    std::string file;
    std::vector<vtkSmartPointer<vtkDataObject>> inputs;
  };

  static constexpr int Count = 4;
  /// Mesh, body, volume and hexahedra.
  vtkDataObject* input(int which) const { return this->*Members[which]; }

  /// The same, but for the last coordinate of the last point of one input's first or last block.
  Inputs withCoordinate(int which, bool first, double value) const
  {
    Inputs result = *this;
    vtkSmartPointer<vtkDataObject>& input = result.*Members[which];
    auto changed = vtkSmartPointer<vtkDataObject>::Take(input->NewInstance());
    changed->DeepCopy(input);
    input = changed;
    vtkPoints* points = nullptr;
    if (auto* tree = vtkPartitionedDataSetCollection::SafeDownCast(input))
    {
      const unsigned int block = first ? 0 : tree->GetNumberOfPartitionedDataSets() - 1;
      points = vtkPointSet::SafeDownCast(tree->GetPartitionAsDataObject(block, 0))->GetPoints();
    }
    else
    {
      points = vtkPointSet::SafeDownCast(input)->GetPoints();
    }
    points->GetData()->SetComponent(points->GetNumberOfPoints() - 1, 2, value);
    return result;
  }

  /// Applies `change` to a copy of each.
  void change(const std::function<void(vtkDataObject*)>& change)
  {
    for (vtkSmartPointer<vtkDataObject> Inputs::*member : Members)
    {
      auto changed = vtkSmartPointer<vtkDataObject>::Take((this->*member)->NewInstance());
      changed->DeepCopy(this->*member);
      change(changed);
      this->*member = changed;
    }
  }

  /// What rank `rank` of `size` has: every so many blocks and hexahedra, and copies of what all have.
  Inputs part(int rank, int size) const
  {
    Inputs result = *this;
    result.change([&](vtkDataObject* data) {
      if (auto* tree = vtkPartitionedDataSetCollection::SafeDownCast(data))
      {
        for (unsigned int b = 0; b < tree->GetNumberOfPartitionedDataSets(); ++b)
        {
          if (static_cast<int>(b) % size != rank)
          {
            tree->SetPartition(b, 0, nullptr);
          }
        }
      }
      else if (auto* grid = vtkUnstructuredGrid::SafeDownCast(data))
      {
        vtkNew<vtkUnstructuredGrid> whole;
        whole->DeepCopy(grid);
        grid->AllocateExact(whole->GetNumberOfCells(), 8);
        vtkNew<vtkIdList> corners;
        for (vtkIdType cell = rank; cell < whole->GetNumberOfCells(); cell += size)
        {
          whole->GetCellPoints(cell, corners);
          grid->InsertNextCell(whole->GetCellType(cell), corners);
        }
      }
    });
    return result;
  }

  /// Filters and the source.
  std::vector<Case> filters() const
  {
    std::vector<Case> cases;
    const auto add = [&](auto* type, const std::string& name, const std::vector<vtkSmartPointer<vtkDataObject>>& inputs,
                       const auto& configure) {
      using Algorithm = std::remove_pointer_t<decltype(type)>;
      cases.push_back({ name,
        [inputs, configure]() -> vtkSmartPointer<vtkAlgorithm> {
          auto algorithm = vtkSmartPointer<Algorithm>::New();
          for (std::size_t port = 0; port < inputs.size(); ++port)
          {
            algorithm->SetInputDataObject(static_cast<int>(port), inputs[port]);
          }
          configure(algorithm.Get());
          return algorithm;
        },
        "", inputs });
    };
    const auto asIs = [](auto*) {};
    const int resolution = this->Resolution;
    add(static_cast<vtkWingFuselageSource*>(nullptr), "WingFuselageSource", {},
      [resolution](auto* source) { source->SetResolution(resolution); });
    add(static_cast<vtkHexBlockTopology*>(nullptr), "HexBlockTopology", { this->Mesh, this->Body }, asIs);
    add(static_cast<vtkHexBlockTopology*>(nullptr), "HexBlockTopology of hexahedra", { this->Hexahedra }, asIs);
    add(static_cast<vtkHexMeshToBlocks*>(nullptr), "HexMeshToBlocks", { this->Hexahedra }, asIs);
    add(static_cast<vtkMirrorHexBlocks*>(nullptr), "MirrorHexBlocks", { this->Mesh }, asIs);
    add(static_cast<vtkWallSpacing*>(nullptr), "WallSpacing", { this->Mesh }, [](auto* filter) {
      filter->SetReynoldsNumber(1e6);
      // That of the mesh, so that nothing is warned of.
      filter->SetTargetYPlus(500.0);
    });
    add(static_cast<vtkCatmullClarkToBSplineVolume*>(nullptr), "CatmullClarkToBSplineVolume", { this->Mesh },
      [](auto* filter) { filter->SetCheckJoins(false); });
    add(static_cast<vtkCatmullClarkToBSplineVolume*>(nullptr), "CatmullClarkToBSplineVolume with body",
      { this->Mesh, this->Body }, asIs);
    add(static_cast<vtkBSplineVolumeSampler*>(nullptr), "BSplineVolumeSampler", { this->Volume }, asIs);
    add(static_cast<vtkBSplineVolumeQuality*>(nullptr), "BSplineVolumeQuality", { this->Volume }, asIs);
    add(static_cast<vtkBSplineVolumeSmoothness*>(nullptr), "BSplineVolumeSmoothness", { this->Volume }, asIs);
    add(static_cast<vtkBSplineVolumeDifference*>(nullptr), "BSplineVolumeDifference", { this->Volume, this->Volume },
      asIs);
    add(static_cast<vtkBSplineVolumeIsoparametric*>(nullptr), "BSplineVolumeIsoparametric", { this->Volume }, asIs);
    add(static_cast<vtkBSplineVolumeProbe*>(nullptr), "BSplineVolumeProbe", { this->Volume, this->Hexahedra }, asIs);
    add(static_cast<vtkBSplineVolumeToBezier*>(nullptr), "BSplineVolumeToBezier", { this->Volume }, asIs);
    add(static_cast<vtkBodyDeviation*>(nullptr), "BodyDeviation", { this->Volume, this->Body },
      [](auto* filter) { filter->SetLevel(0); });
    return cases;
  }

  /// One per format.
  std::vector<Case> writers() const
  {
    std::vector<Case> cases;
    const auto add = [&](auto* type, const vtkSmartPointer<vtkDataObject>& input, const std::string& file) {
      using Writer = std::remove_pointer_t<decltype(type)>;
      const std::string path = this->Folder + file;
      cases.push_back({ "writer of " + file,
        [input, path]() -> vtkSmartPointer<vtkAlgorithm> {
          auto writer = vtkSmartPointer<Writer>::New();
          writer->SetInputDataObject(0, input);
          writer->SetFileName(path.c_str());
          return writer;
        },
        path, { input } });
    };
    for (const char* file : { "mesh.xyz", "mesh.cgns", "mesh.foam" })
    {
      add(static_cast<vtkHexBlockMeshWriter*>(nullptr), this->Mesh, file);
    }
    add(static_cast<vtkHexBlockMeshWriter*>(nullptr), this->Mesh, "text.xyz");
    const auto makeBinary = cases.back().make;
    cases.back().make = [makeBinary] {
      vtkSmartPointer<vtkAlgorithm> writer = makeBinary();
      vtkHexBlockMeshWriter::SafeDownCast(writer)->SetEncoding(vtkHexBlockMeshWriter::ASCII);
      return writer;
    };
    for (const char* file : { "volume.mesh", "volume.xml", "volume.g2", "volume.msh", "volume.h5", "volume.cgns" })
    {
      add(static_cast<vtkBSplineVolumeWriter*>(nullptr), this->Volume, file);
    }
    for (const char* file : { "body.stp", "body.igs", "body.g2" })
    {
      add(static_cast<vtkNURBSSurfaceWriter*>(nullptr), this->Body, file);
    }
    add(static_cast<vtkQuadflowWriter*>(nullptr), this->Volume, "volume.qfmb");
    return cases;
  }

  /// One per format, of what the writers have written.
  std::vector<Case> readers() const
  {
    std::vector<Case> cases;
    const auto add = [&](auto* type, const std::string& file) {
      using Reader = std::remove_pointer_t<decltype(type)>;
      const std::string path = this->Folder + file;
      cases.push_back({ "reader of " + file,
        [path]() -> vtkSmartPointer<vtkAlgorithm> {
          auto reader = vtkSmartPointer<Reader>::New();
          reader->SetFileName(path.c_str());
          return reader;
        },
        "", {} });
    };
    add(static_cast<vtkHexBlockMeshReader*>(nullptr), "mesh.xyz");
    add(static_cast<vtkHexBlockMeshReader*>(nullptr), "text.xyz");
    add(static_cast<vtkHexBlockMeshReader*>(nullptr), "mesh.cgns");
    add(static_cast<vtkBSplineVolumeReader*>(nullptr), "volume.mesh");
    add(static_cast<vtkBSplineVolumeReader*>(nullptr), "volume.g2");
    add(static_cast<vtkNURBSSurfaceReader*>(nullptr), "body.g2");
    add(static_cast<vtkQuadflowReader*>(nullptr), "volume.qfmb");
    return cases;
  }

private:
  static vtkSmartPointer<vtkDataObject> copy(vtkDataObject* data)
  {
    auto result = vtkSmartPointer<vtkDataObject>::Take(data->NewInstance());
    result->ShallowCopy(data);
    return result;
  }

  std::string Folder;
  int Resolution;
  vtkSmartPointer<vtkDataObject> Mesh, Body, Volume, Hexahedra;
  static constexpr vtkSmartPointer<vtkDataObject> Inputs::*Members[Count] = { &Inputs::Mesh, &Inputs::Body,
    &Inputs::Volume, &Inputs::Hexahedra };
};

} // namespace algorithms
