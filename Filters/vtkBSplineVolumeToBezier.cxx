// SPDX-License-Identifier: BSD-3-Clause
#include "vtkBSplineVolumeToBezier.h"

#include "Base/MemoryCheck.h"
#include "Data/BSplineVolumeData.h"
#include "Data/BoundarySelection.h"
#include "Execution/FilterExecution.h"
#include "Volume/BezierExtraction.h"

#include "vtkBezierHexahedron.h"
#include "vtkBezierQuadrilateral.h"
#include "vtkCellArray.h"
#include "vtkCellData.h"
#include "vtkCellType.h"
#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkIntArray.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkStringArray.h"
#include "vtkTypeInt64Array.h"
#include "vtkUnstructuredGrid.h"

vtkStandardNewMacro(vtkBSplineVolumeToBezier);

namespace
{

/// The cells of one block or of one of its faces.
struct Patch
{
  int block;
  int face; ///< -1: the whole block
  /// Block direction of the cells' first, second and third axis (of a face: across it).
  bsv::Ijk axes;
  bsv::Ijk degree; ///< along the cells' axes; 0 across a face
  bsv::Ijk spans;  ///< along the cells' axes; 1 across a face
  vtkIdType firstCell;
  vtkIdType firstIndex; ///< in the connectivity

  vtkIdType cells() const { return vtkIdType(this->spans[0]) * this->spans[1] * this->spans[2]; }
  int cellPoints() const { return (this->degree[0] + 1) * (this->degree[1] + 1) * (this->degree[2] + 1); }
};

Patch patchOf(const bsv::BSplineVolume& volume, const bsv::Ijk& spans, int block, int face)
{
  Patch patch{};
  patch.block = block;
  patch.face = face;
  patch.axes = { 0, 1, 2 };
  if (face >= 0)
  {
    // (first axis) x (second axis) points in the direction of i, against that of j, in that of k.
    const bool outward = (bsv::faceDirection(face) == 1) != (bsv::faceSide(face) == 1);
    patch.axes = { bsv::faceAxis(face, outward ? 0 : 1), bsv::faceAxis(face, outward ? 1 : 0),
      bsv::faceDirection(face) };
  }
  for (int a = 0; a < 3; ++a)
  {
    const bool across = face >= 0 && a == 2;
    patch.degree[a] = across ? 0 : volume.degree[patch.axes[a]];
    patch.spans[a] = across ? 1 : spans[patch.axes[a]];
  }
  return patch;
}

template <typename Array>
vtkSmartPointer<Array> cellArray(const char* name, int components, vtkIdType cells)
{
  auto array = vtkSmartPointer<Array>::New();
  array->SetName(name);
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(cells);
  return array;
}

/// Offset, degrees, ids of block, span and face, type.
constexpr double BytesPerCell = 8 + 24 + 4 + 12 + 4 + 1;

void checkMemory(const std::vector<Patch>& patches, const bsv::BSplineVolumeBlocks& input)
{
  double bytes = 0.0;
  for (const Patch& patch : patches)
  {
    double points = 1.0;
    for (int a = 0; a < 3; ++a)
    {
      points *= static_cast<double>(patch.spans[a]) * patch.degree[a] + 1.0;
    }
    const double cells = static_cast<double>(patch.spans[0]) * patch.spans[1] * patch.spans[2];
    bytes += points * (input.firstRational() < 0 ? 3 : 4) * sizeof(double) +
      cells * (patch.cellPoints() * sizeof(vtkTypeInt64) + BytesPerCell);
  }
  bsv::requireMemory(bytes, "the volume", "its Bezier cells");
}

/// Whether each face of each block is part of the wall; empty if none is. Collective.
std::vector<bool> wallFaces(const bsv::BSplineVolumeBlocks& input, vtkDataObject* data, const bsv::Ranks& ranks)
{
  const std::vector<bool> wall =
    bsv::wallBoundaries(data, input.boundaryNames, input.boundaryTypes, bsv::defaultBodyBoundaries(), ranks);
  std::vector<bool> faces;
  for (const bsv::BoundaryPatch& patch : input.boundaries)
  {
    if (wall[patch.tag])
    {
      faces.resize(6 * input.volumes.size(), false);
      faces[6 * std::size_t(patch.block) + patch.face] = true;
    }
  }
  return faces;
}

/// Leaves out points that belong to no cell.
void compact(vtkPoints* points, vtkDoubleArray* weights, vtkTypeInt64Array* connectivity)
{
  std::vector<vtkIdType> place(static_cast<std::size_t>(points->GetNumberOfPoints()), -1);
  for (vtkIdType n = 0; n < connectivity->GetNumberOfValues(); ++n)
  {
    place[connectivity->GetValue(n)] = 0;
  }
  vtkIdType count = 0;
  for (std::size_t from = 0; from < place.size(); ++from)
  {
    if (place[from] == 0)
    {
      double x[3];
      points->GetPoint(static_cast<vtkIdType>(from), x);
      points->SetPoint(count, x);
      if (weights->GetNumberOfValues() > 0)
      {
        weights->SetValue(count, weights->GetValue(static_cast<vtkIdType>(from)));
      }
      place[from] = count++;
    }
  }
  for (vtkIdType n = 0; n < connectivity->GetNumberOfValues(); ++n)
  {
    connectivity->SetValue(n, place[connectivity->GetValue(n)]);
  }
  points->Resize(count);
  if (weights->GetNumberOfValues() > 0)
  {
    weights->Resize(count);
  }
}

} // namespace

//------------------------------------------------------------------------------
void vtkBSplineVolumeToBezier::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  static constexpr const char* Names[] = { "Volume", "Outer faces", "All faces", "Wall" };
  os << indent << "Cells: " << Names[this->Cells] << "\n";
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeToBezier::FillInputPortInformation(int, vtkInformation* info)
{
  bsv::acceptMissing(info);
  info->Remove(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE());
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObjectTree");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkStructuredGrid");
  return 1;
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeToBezier::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  auto* output = vtkUnstructuredGrid::GetData(outputVector, 0);
  if (!output)
  {
    vtkErrorMacro("The output is missing.");
    return 0;
  }
  return bsv::execute(this, [&] {
    const bsv::BSplineVolumeBlocks input =
      bsv::bsplineVolumeBlocks(bsv::requiredInput(inputVector, 0), *bsv::globalRanks());
    bsv::requireVolumes(input);
    const int blocks = static_cast<int>(input.volumes.size());
    const bool faces = this->Cells != VOLUME;
    const std::vector<bool> wall = this->Cells == WALL
      ? wallFaces(input, vtkDataObject::GetData(inputVector[0], 0), *bsv::globalRanks())
      : std::vector<bool>();
    const bsv::BezierCells made =
      this->Cells == WALL ? bsv::BezierCells::OuterFaces : static_cast<bsv::BezierCells>(this->Cells);

    // Before anything large is made, as if no point and no face were shared.
    std::vector<Patch> patches;
    for (int b = 0; b < blocks; ++b)
    {
      bsv::Ijk spans = bsv::bezierCounts(input.volumes[b], input.label(b));
      for (int d = 0; d < 3; ++d)
      {
        spans[d] = (spans[d] - 1) / input.volumes[b].degree[d];
      }
      for (int f = faces ? 0 : -1; input.isHere(b) && f < (faces ? 6 : 0); ++f)
      {
        patches.push_back(patchOf(input.volumes[b], spans, b, f));
      }
    }
    checkMemory(patches, input);

    const bsv::BezierExtraction extraction(
      input.volumes, input.hasInterfaces ? &input.interfaces : nullptr, made, bsv::filterExecution(this, 0.0, 0.2));
    if (faces)
    {
      patches.clear();
      for (const bsv::BlockFace& at : extraction.faces())
      {
        if (wall.empty() || wall[6 * std::size_t(at.block) + at.face])
        {
          patches.push_back(patchOf(input.volumes[at.block], extraction.spans(at.block), at.block, at.face));
        }
      }
    }
    vtkIdType cells = 0;
    vtkIdType indices = 0;
    for (Patch& patch : patches)
    {
      patch.firstCell = cells;
      patch.firstIndex = indices;
      cells += patch.cells();
      indices += patch.cells() * patch.cellPoints();
    }

    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    points->SetNumberOfPoints(extraction.pointCount());
    vtkNew<vtkDoubleArray> weights;
    weights->SetName("RationalWeights");
    weights->SetNumberOfValues(extraction.rational() ? extraction.pointCount() : 0);
    extraction.evaluate(vtkDoubleArray::SafeDownCast(points->GetData())->GetPointer(0), weights->GetPointer(0),
      bsv::filterExecution(this, 0.2, 0.7));

    vtkNew<vtkTypeInt64Array> offsets;
    offsets->SetNumberOfValues(cells + 1);
    offsets->SetValue(cells, indices);
    vtkNew<vtkTypeInt64Array> connectivity;
    connectivity->SetNumberOfValues(indices);
    const auto degrees = cellArray<vtkDoubleArray>("HigherOrderDegrees", 3, cells);
    const auto blockIds = cellArray<vtkIntArray>("BlockId", 1, cells);
    const auto spanIds = cellArray<vtkIntArray>("SpanId", 3, cells);
    const auto faceIds = cellArray<vtkIntArray>("FaceId", 1, faces ? cells : 0);

    const bsv::Execution run = bsv::filterExecution(this, 0.7, 1.0);
    for (const Patch& patch : patches)
    {
      run.report(static_cast<double>(patch.firstCell) / cells);
      const bsv::Ijk n = patch.degree;
      std::vector<int> places(patch.cellPoints());
      for (int c = 0, p = 0; c <= n[2]; ++c)
      {
        for (int b = 0; b <= n[1]; ++b)
        {
          for (int a = 0; a <= n[0]; ++a, ++p)
          {
            places[p] = faces ? vtkBezierQuadrilateral::PointIndexFromIJK(a, b, n.data())
                              : vtkBezierHexahedron::PointIndexFromIJK(a, b, c, n.data());
          }
        }
      }
      const bool last = faces && bsv::faceSide(patch.face) == 1;
      run.parallelFor(patch.cells(), 256, [&](bsv::Index begin, bsv::Index end) {
        for (bsv::Index local = begin; local < end; ++local)
        {
          const bsv::Ijk span{ static_cast<int>(local % patch.spans[0]),
            static_cast<int>(local / patch.spans[0] % patch.spans[1]),
            static_cast<int>(local / patch.spans[0] / patch.spans[1]) };
          const vtkIdType cell = patch.firstCell + local;
          const vtkIdType start = patch.firstIndex + local * patch.cellPoints();
          bsv::Ijk at{};
          if (last)
          {
            at[patch.axes[2]] = extraction.counts(patch.block)[patch.axes[2]] - 1;
          }
          for (int c = 0, p = 0; c <= n[2]; ++c)
          {
            for (int b = 0; b <= n[1]; ++b)
            {
              for (int a = 0; a <= n[0]; ++a, ++p)
              {
                at[patch.axes[0]] = span[0] * n[0] + a;
                at[patch.axes[1]] = span[1] * n[1] + b;
                if (!faces)
                {
                  at[patch.axes[2]] = span[2] * n[2] + c;
                }
                connectivity->SetValue(start + places[p], extraction.point(patch.block, at));
              }
            }
          }
          offsets->SetValue(cell, start);
          blockIds->SetValue(cell, patch.block);
          for (int a = 0; a < 3; ++a)
          {
            const int d = patch.axes[a];
            degrees->SetTypedComponent(cell, a, n[a]);
            spanIds->SetTypedComponent(
              cell, d, faces && a == 2 ? (last ? extraction.spans(patch.block)[d] - 1 : 0) : span[a]);
          }
          if (faces)
          {
            faceIds->SetValue(cell, patch.face);
          }
        }
      });
    }

    if (!wall.empty())
    {
      compact(points, weights, connectivity);
    }
    vtkNew<vtkCellArray> cellArray;
    cellArray->SetData(offsets, connectivity);
    output->SetPoints(points);
    output->SetCells(faces ? VTK_BEZIER_QUADRILATERAL : VTK_BEZIER_HEXAHEDRON, cellArray);
    output->GetCellData()->SetHigherOrderDegrees(degrees);
    output->GetCellData()->AddArray(blockIds);
    output->GetCellData()->AddArray(spanIds);
    if (faces)
    {
      output->GetCellData()->AddArray(faceIds);
    }
    if (extraction.rational())
    {
      output->GetPointData()->SetRationalWeights(weights);
    }
    vtkNew<vtkStringArray> names;
    names->SetName("BlockNames");
    for (const std::string& name : input.names)
    {
      names->InsertNextValue(name);
    }
    output->GetFieldData()->AddArray(names);
    run.report(1.0);
  });
}
