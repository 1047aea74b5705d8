// SPDX-License-Identifier: BSD-3-Clause
#include "vtkBSplineVolumeIsoparametric.h"

#include "Base/MemoryCheck.h"
#include "Data/BSplineVolumeData.h"
#include "Execution/FilterExecution.h"

#include "vtkCellArray.h"
#include "vtkCellData.h"
#include "vtkDoubleArray.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkIntArray.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"

#include <algorithm>
#include <sstream>

vtkStandardNewMacro(vtkBSplineVolumeIsoparametric);

namespace
{

using bsv::Index;
using bsv::Vec3;

/// Parameters at which a direction is sampled: the knots, and every span cut into `parts`.
std::vector<double> samplesOf(const bsv::BSplineVolume& volume, int direction, int parts)
{
  const std::vector<double>& knots = volume.knots[direction];
  std::vector<double> samples;
  double end = 0.0;
  for (const int span : bsv::nonEmptySpans(volume.degree[direction], knots))
  {
    for (int n = 0; n < parts; ++n)
    {
      samples.push_back(knots[span] + (knots[span + 1] - knots[span]) * n / parts);
    }
    end = knots[span + 1];
  }
  samples.push_back(end);
  return samples;
}

double parameterAt(const bsv::BSplineVolume& volume, int direction, double position)
{
  const std::vector<double>& knots = volume.knots[direction];
  const double low = knots[volume.degree[direction]], high = knots[volume.count(direction)];
  return std::min(high, low + position * (high - low));
}

/// A surface or curve: the parameters of its points, first direction fastest, and its size in points.
struct Piece
{
  int block;
  std::array<std::vector<double>, 3> samples;
  std::array<double, 2> position;

  Index size() const
  {
    return Index(this->samples[0].size()) * Index(this->samples[1].size()) * Index(this->samples[2].size());
  }
  Vec3 uvw(Index n) const
  {
    const Index u = static_cast<Index>(this->samples[0].size()), v = static_cast<Index>(this->samples[1].size());
    return { this->samples[0][n % u], this->samples[1][n / u % v], this->samples[2][n / u / v] };
  }
};

} // namespace

//------------------------------------------------------------------------------
void vtkBSplineVolumeIsoparametric::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Shape: " << (this->Shape == SURFACES ? "Surfaces" : "Curves") << "\n";
  os << indent << "Direction: " << this->Direction << "\n";
  os << indent << "Positions:";
  for (const double position : this->Positions)
  {
    os << " " << position;
  }
  os << "\n" << indent << "Level: " << this->Level << "\n";
}

//------------------------------------------------------------------------------
void vtkBSplineVolumeIsoparametric::SetNumberOfPositions(int count)
{
  if (count >= 0 && count != this->GetNumberOfPositions())
  {
    this->Positions.resize(count, 0.0);
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkBSplineVolumeIsoparametric::SetPosition(int index, double value)
{
  if (index >= 0 && index < this->GetNumberOfPositions() && this->Positions[index] != value)
  {
    this->Positions[index] = value;
    this->Modified();
  }
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeIsoparametric::FillInputPortInformation(int, vtkInformation* info)
{
  bsv::acceptMissing(info);
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObjectTree");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkStructuredGrid");
  return 1;
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeIsoparametric::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkPolyData* output = vtkPolyData::GetData(outputVector, 0);
  if (!output)
  {
    vtkErrorMacro("The output is missing.");
    return 0;
  }
  return bsv::execute(this, [&] {
    const bsv::Execution run = bsv::filterExecution(this);
    for (const double position : this->Positions)
    {
      if (!(position >= 0.0 && position <= 1.0))
      {
        std::ostringstream text;
        text << "Positions: " << position << " is not between 0 and 1";
        throw bsv::Error(text.str());
      }
    }
    const bsv::BSplineVolumeBlocks input = bsv::bsplineVolumeBlocks(bsv::requiredInput(inputVector, 0), *run.ranks);
    bsv::requireVolumes(input);

    // Which directions are constant, and how many components a position has.
    const bool surfaces = this->Shape == SURFACES;
    std::vector<int> constant;
    for (int d = 0; d < 3; ++d)
    {
      if (surfaces == (d == this->Direction))
      {
        constant.push_back(d);
      }
    }
    std::vector<Piece> pieces;
    Index total = 0;
    for (std::size_t block = 0; block < input.volumes.size(); ++block)
    {
      if (!input.isHere(block))
      {
        continue;
      }
      const bsv::BSplineVolume& volume = input.volumes[block];
      Piece piece{ static_cast<int>(block), {}, {} };
      for (int d = 0; d < 3; ++d)
      {
        piece.samples[d] = samplesOf(volume, d, 1 << this->Level);
      }
      for (const double first : this->Positions)
      {
        piece.position[0] = first;
        piece.samples[constant[0]] = { parameterAt(volume, constant[0], first) };
        for (const double second : surfaces ? std::vector<double>{ 0.0 } : this->Positions)
        {
          if (!surfaces)
          {
            piece.position[1] = second;
            piece.samples[constant[1]] = { parameterAt(volume, constant[1], second) };
          }
          pieces.push_back(piece);
          total += piece.size();
        }
      }
    }
    bsv::requireMemory(total * 6.0 * sizeof(double), "Level " + std::to_string(this->Level), "the points");

    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    points->SetNumberOfPoints(total);
    vtkNew<vtkDoubleArray> parameters;
    parameters->SetName("UVW");
    parameters->SetNumberOfComponents(3);
    parameters->SetNumberOfTuples(total);
    vtkNew<vtkIntArray> blockIds;
    blockIds->SetName("BlockId");
    vtkNew<vtkDoubleArray> positions;
    positions->SetName("Position");
    positions->SetNumberOfComponents(static_cast<int>(constant.size()));
    vtkNew<vtkCellArray> cells;
    double* xyz = static_cast<double*>(points->GetVoidPointer(0));
    Index start = 0;
    for (const Piece& piece : pieces)
    {
      run.parallelFor(piece.size(), 256, [&](Index begin, Index end) {
        for (Index n = begin; n < end; ++n)
        {
          const Vec3 uvw = piece.uvw(n);
          const Vec3 x = bsv::evaluate(input.volumes[piece.block], uvw);
          std::copy_n(x.data(), 3, xyz + 3 * (start + n));
          std::copy_n(uvw.data(), 3, parameters->GetPointer(3 * (start + n)));
        }
      });
      Index made = 1;
      if (surfaces)
      {
        const int along = this->Direction == 0 ? 1 : 0, across = this->Direction == 2 ? 1 : 2;
        const Index columns = static_cast<Index>(piece.samples[along].size());
        const Index rows = static_cast<Index>(piece.samples[across].size());
        for (Index t = 0; t + 1 < rows; ++t)
        {
          for (Index s = 0; s + 1 < columns; ++s)
          {
            const vtkIdType corner = start + s + columns * t;
            cells->InsertNextCell({ corner, corner + 1, corner + 1 + columns, corner + columns });
          }
        }
        made = (rows - 1) * (columns - 1);
      }
      else
      {
        cells->InsertNextCell(static_cast<int>(piece.size()));
        for (Index n = 0; n < piece.size(); ++n)
        {
          cells->InsertCellPoint(start + n);
        }
      }
      for (Index cell = 0; cell < made; ++cell)
      {
        blockIds->InsertNextValue(piece.block);
        positions->InsertNextTypedTuple(piece.position.data());
      }
      start += piece.size();
      run.report(static_cast<double>(start) / static_cast<double>(total));
    }
    output->SetPoints(points);
    output->GetPointData()->AddArray(parameters);
    if (surfaces)
    {
      output->SetPolys(cells);
    }
    else
    {
      output->SetLines(cells);
    }
    output->GetCellData()->AddArray(blockIds);
    output->GetCellData()->AddArray(positions);
  });
}
