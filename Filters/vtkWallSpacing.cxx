// SPDX-License-Identifier: BSD-3-Clause
#include "vtkWallSpacing.h"

#include "Complex/BlockComplex.h"
#include "Data/BlockTags.h"
#include "Data/BoundarySelection.h"
#include "Data/HexBlockData.h"
#include "Data/MeshInput.h"
#include "Data/Verdict.h"
#include "Execution/FilterExecution.h"
#include "Ranks/Ranks.h"
#include "Wall/WallSpacing.h"

#include "vtkCellArray.h"
#include "vtkDataObject.h"
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
#include "vtkStructuredGrid.h"
#include "vtkTable.h"
#include "vtkUnsignedCharArray.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <numeric>
#include <sstream>
#include <utility>

vtkStandardNewMacro(vtkWallSpacing);

namespace
{

using NamedValues = std::vector<std::pair<const char*, std::vector<double>>>;

/// What both outputs have, per wall vertex.
NamedValues wallArrays(const bsv::WallSpacingResult& wall)
{
  std::vector<double> thickness;
  for (const bsv::PlateLayer& layer : wall.layers)
  {
    thickness.push_back(layer.thickness);
  }
  return { { "WallSpacing", wall.spacing }, { "BoundaryLayerThickness", thickness },
    { "FirstCellHeight", wall.firstHeight }, { "YPlus", wall.yPlus }, { "CellsInBoundaryLayer", wall.cells } };
}

template <typename Array, typename Values>
vtkSmartPointer<Array> namedArray(const char* name, const Values& values)
{
  auto array = vtkSmartPointer<Array>::New();
  array->SetName(name);
  array->SetNumberOfValues(static_cast<vtkIdType>(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i)
  {
    array->SetValue(static_cast<vtkIdType>(i), values[i]);
  }
  return array;
}

void addReferenceState(vtkFieldData* fields, const bsv::ReferenceState& state)
{
  const std::pair<const char*, double> values[] = { { "ReferenceSoundSpeed", state.soundSpeed },
    { "ReferenceVelocity", state.velocity }, { "ReferenceViscosity", state.viscosity },
    { "ReferenceDensity", state.density }, { "ReferencePressure", state.pressure },
    { "ReferenceConductivity", state.conductivity }, { "ReferenceTime", state.time },
    { "ViscousCoefficient", state.viscousCoefficient }, { "HeatCoefficient", state.heatCoefficient },
    { "PressureCoefficient", state.pressureCoefficient } };
  for (const auto& [name, value] : values)
  {
    fields->AddArray(namedArray<vtkDoubleArray>(name, std::vector<double>{ value }));
  }
}

/// The wall as quadrilaterals.
void setSurface(vtkPolyData* surface, const bsv::BlockComplex& complex, const bsv::WallSpacingResult& wall)
{
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(static_cast<vtkIdType>(wall.points.size()));
  for (std::size_t v = 0; v < wall.points.size(); ++v)
  {
    points->SetPoint(static_cast<vtkIdType>(v), wall.points[v].data());
  }
  vtkNew<vtkCellArray> quads;
  for (const bsv::WallSpacingResult::Side& side : wall.sides)
  {
    const int row = complex.blocks[side.block].cells(bsv::faceAxis(side.face, 0)) + 1;
    const int rows = static_cast<int>(side.vertices.size()) / row;
    for (int t = 0; t + 1 < rows; ++t)
    {
      for (int s = 0; s + 1 < row; ++s)
      {
        const bsv::Index* at = side.vertices.data() + s + std::size_t(row) * t;
        quads->InsertNextCell({ at[0], at[1], at[row + 1], at[row] });
      }
    }
  }
  surface->SetPoints(points);
  surface->SetPolys(quads);
  vtkPointData* data = surface->GetPointData();
  for (const auto& [name, values] : wallArrays(wall))
  {
    data->AddArray(namedArray<vtkDoubleArray>(name, values));
  }
  std::vector<double> distances, friction;
  for (const bsv::PlateLayer& layer : wall.layers)
  {
    distances.push_back(layer.distance);
    friction.push_back(layer.skinFriction);
  }
  data->AddArray(namedArray<vtkDoubleArray>("StreamwiseDistance", distances));
  data->AddArray(namedArray<vtkDoubleArray>("SkinFriction", friction));
  data->AddArray(namedArray<vtkDoubleArray>("CellGrowth", wall.growth));
  data->AddArray(namedArray<vtkIntArray>("ReachingLevel", wall.reachingLevel));
  data->AddArray(namedArray<vtkUnsignedCharArray>("TargetAllowed", wall.allowed));
  data->SetActiveScalars("YPlus");
}

/// Adds the wall's arrays to copies of the blocks that have a wall.
void addToBlocks(std::vector<vtkSmartPointer<vtkStructuredGrid>>& grids, const bsv::BlockComplex& complex,
  const bsv::WallSpacingResult& wall)
{
  const NamedValues arrays = wallArrays(wall);
  std::vector<std::vector<vtkDoubleArray*>> added(grids.size());
  for (const bsv::WallSpacingResult::Side& side : wall.sides)
  {
    const bsv::ComplexBlock& block = complex.blocks[side.block];
    vtkStructuredGrid* grid = grids[block.parent];
    std::vector<vtkDoubleArray*>& own = added[block.parent];
    for (std::size_t a = own.size(); a < arrays.size(); ++a)
    {
      vtkNew<vtkDoubleArray> array;
      array->SetName(arrays[a].first);
      array->SetNumberOfValues(grid->GetNumberOfPoints());
      array->Fill(std::numeric_limits<double>::quiet_NaN());
      grid->GetPointData()->AddArray(array);
      own.push_back(array);
    }
    const bsv::Ijk cells{ block.cells(0), block.cells(1), block.cells(2) };
    int counts[3];
    grid->GetDimensions(counts);
    const int row = cells[bsv::faceAxis(side.face, 0)] + 1;
    for (std::size_t i = 0; i < side.vertices.size(); ++i)
    {
      const bsv::Ijk ijk = bsv::facePoint(cells, side.face, static_cast<int>(i) % row, static_cast<int>(i) / row);
      const vtkIdType at = ijk[0] + block.offset[0] +
        counts[0] * (ijk[1] + block.offset[1] + vtkIdType(counts[1]) * (ijk[2] + block.offset[2]));
      for (std::size_t a = 0; a < arrays.size(); ++a)
      {
        own[a]->SetValue(at, arrays[a].second[side.vertices[i]]);
      }
    }
  }
}

/// Smallest and largest value of all ranks.
void range(const std::vector<double>& values, double* result, const bsv::Ranks& ranks)
{
  std::vector<double> mine;
  if (!values.empty())
  {
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    mine = { *low, *high };
  }
  const std::vector<double> all = ranks.gatherAll(mine);
  const auto [low, high] = std::minmax_element(all.begin(), all.end());
  result[0] = *low;
  result[1] = *high;
}

std::string reportText(const bsv::FlowConditions& flow, const bsv::WallSpacingResult& wall, const bsv::Ranks& ranks)
{
  const bsv::ReferenceState state = bsv::referenceState(flow);
  std::ostringstream text;
  text << "free stream: velocity " << state.velocity << " m/s, speed of sound " << state.soundSpeed << " m/s, density "
       << state.density << " kg/m^3, pressure " << state.pressure << " Pa, viscosity " << state.viscosity
       << " Pa s, heat conductivity " << state.conductivity << " W/(m K)\n"
       << "dimensionless: 1/Re " << state.viscousCoefficient << ", 1/((gamma-1) M^2 Re Pr) " << state.heatCoefficient
       << ", 1/(gamma M^2) " << state.pressureCoefficient << '\n';
  bsv::Index outside = 0;
  for (std::size_t v = 0; v < wall.layers.size(); ++v)
  {
    const bsv::PlateLayer& layer = wall.layers[v];
    const bool inRange =
      layer.turbulent ? layer.reynolds > 5e5 && layer.reynolds < 1e7 : layer.reynolds > 1e3 && layer.reynolds < 5e5;
    outside += inRange ? 0 : wall.counted[v];
  }
  const std::vector<bsv::Index> outsides = ranks.gatherAll(std::vector<bsv::Index>{ outside });
  outside = std::accumulate(outsides.begin(), outsides.end(), bsv::Index(0));
  const auto line = [&](const char* name, const std::vector<double>& values) {
    double bounds[2];
    range(values, bounds, ranks);
    text << name << ": " << bounds[0] << " to " << bounds[1] << '\n';
  };
  text << wall.wallPoints << " wall points, " << wall.reached << " of them with the target within 1 %\n";
  for (const auto& [name, values] : wallArrays(wall))
  {
    line(name, values);
  }
  line("CellGrowth", wall.growth);
  if (outside > 0)
  {
    text << outside << " wall points have a Re_x outside the range of the formulas\n";
  }
  text << wall.warning << (wall.warning.empty() ? "" : "\n");
  return text.str();
}

} // namespace

//------------------------------------------------------------------------------
vtkWallSpacing::vtkWallSpacing()
{
  this->SetNumberOfOutputPorts(3);
}

//------------------------------------------------------------------------------
void vtkWallSpacing::AddBodyBoundary(const char* pattern)
{
  if (pattern && *pattern)
  {
    this->BodyBoundaries.emplace_back(pattern);
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkWallSpacing::ClearBodyBoundaries()
{
  this->BodyBoundaries.clear();
  this->Modified();
}

//------------------------------------------------------------------------------
void vtkWallSpacing::AddSymmetryBoundary(const char* pattern)
{
  if (pattern && *pattern)
  {
    this->SymmetryBoundaries.emplace_back(pattern);
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkWallSpacing::ClearSymmetryBoundaries()
{
  this->SymmetryBoundaries.clear();
  this->Modified();
}

//------------------------------------------------------------------------------
int vtkWallSpacing::FillInputPortInformation(int, vtkInformation* info)
{
  bsv::acceptMissing(info);
  bsv::acceptMeshes(info);
  return 1;
}

//------------------------------------------------------------------------------
int vtkWallSpacing::FillOutputPortInformation(int port, vtkInformation* info)
{
  static const char* const types[] = { "vtkPartitionedDataSetCollection", "vtkPolyData", "vtkTable" };
  info->Set(vtkDataObject::DATA_TYPE_NAME(), types[port]);
  return 1;
}

//------------------------------------------------------------------------------
int vtkWallSpacing::RequestData(vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkDataObject* input = vtkDataObject::GetData(inputVector[0], 0);
  auto* output = vtkPartitionedDataSetCollection::GetData(outputVector, 0);
  auto* surface = vtkPolyData::GetData(outputVector, 1);
  auto* verdict = vtkTable::GetData(outputVector, 2);
  if (!output || !surface || !verdict)
  {
    vtkErrorMacro("An output is missing.");
    return 0;
  }
  bsv::setText(verdict, "");
  this->NumberOfWallPoints = this->NumberOfPointsOnTarget = 0;
  std::fill_n(this->YPlusRange, 2, 0.0);
  std::fill_n(this->WallSpacingRange, 2, 0.0);
  this->Report.clear();

  return bsv::execute(this, [&] {
    bsv::requiredInput(inputVector, 0);
    const std::shared_ptr<const bsv::Ranks> shared = bsv::globalRanks();
    const bsv::Ranks& ranks = *shared;
    std::vector<vtkSmartPointer<vtkStructuredGrid>> meshGrids;
    const bsv::BlockMesh mesh = bsv::blockMesh(input, meshGrids, bsv::filterExecution(this, 0.0, 0.3));
    bsv::requireBlocks(mesh);
    bsv::requireMesh(meshGrids, ranks, "give Wall Spacing the mesh that the conversion gets");
    bsv::BlockComplexOptions complexOptions;
    complexOptions.creaseAngle = this->UseCreaseAngle ? this->CreaseAngle : 180.0;
    const bsv::BlockComplex complex =
      bsv::buildBlockComplex(mesh, complexOptions, bsv::filterExecution(this, 0.0, 0.3));
    bsv::ConversionOptions conversion;
    conversion.roles = bsv::boundaryRoles(complex, this->BodyBoundaries, this->SymmetryBoundaries);
    if (std::find(conversion.roles.begin(), conversion.roles.end(), bsv::BoundaryRole::Body) == conversion.roles.end())
    {
      throw bsv::Error("no boundary of the mesh is a wall: Body Boundaries are " +
        bsv::quotedList(this->BodyBoundaries) + ", the mesh has the boundaries " +
        bsv::quotedList(complex.boundaryNames));
    }

    bsv::warn(this,
      bsv::uselessPatterns("Body Boundaries", this->BodyBoundaries, bsv::defaultBodyBoundaries(), complex.boundaryNames,
        complex.boundaryTypes));
    bsv::warn(this,
      bsv::uselessPatterns("Symmetry Boundaries", this->SymmetryBoundaries, bsv::defaultSymmetryBoundaries(),
        complex.boundaryNames, complex.boundaryTypes));

    bsv::WallSpacingOptions options;
    options.flow.reynoldsNumber = this->ReynoldsNumber;
    options.flow.machNumber = this->MachNumber;
    options.flow.referenceLength = this->ReferenceLength;
    options.flow.lengthUnit = this->LengthUnit;
    options.flow.temperature = this->Temperature;
    options.flow.viscosity = this->Viscosity;
    options.flow.prandtlNumber = this->PrandtlNumber;
    options.flow.transition = this->TransitionLocation;
    options.direction = bsv::Vec3(this->FlowDirection);
    options.minimumDistance = this->MinimumDistance;
    options.targetYPlus = this->TargetYPlus;
    options.level = this->Level;
    options.maximumGrowth = this->MaximumGrowth;
    const bsv::WallSpacingResult wall =
      bsv::wallSpacing(mesh, complex, conversion, options, bsv::filterExecution(this, 0.3, 1.0));

    range(wall.yPlus, this->YPlusRange, ranks);
    range(wall.spacing, this->WallSpacingRange, ranks);
    this->Report = reportText(options.flow, wall, ranks);

    // From here on the ranks do not communicate.
    std::vector<vtkSmartPointer<vtkStructuredGrid>> grids;
    std::vector<std::string> names;
    for (std::size_t b = 0; b < meshGrids.size(); ++b)
    {
      grids.push_back(meshGrids[b] ? vtkSmartPointer<vtkStructuredGrid>::New() : nullptr);
      if (meshGrids[b])
      {
        grids.back()->ShallowCopy(meshGrids[b]);
      }
      names.push_back(mesh.blocks[b].name);
    }
    addToBlocks(grids, complex, wall);
    bsv::setBlocks(output, grids, names, "HexBlockMesh");
    output->GetFieldData()->ShallowCopy(input->GetFieldData());
    bsv::setConnectivity(output->GetFieldData(), mesh);
    bsv::tagBlocks(output, mesh, "wall spacing");
    setSurface(surface, complex, wall);
    const bsv::ReferenceState state = bsv::referenceState(options.flow);
    addReferenceState(output->GetFieldData(), state);
    addReferenceState(surface->GetFieldData(), state);

    this->NumberOfWallPoints = static_cast<vtkIdType>(wall.wallPoints);
    this->NumberOfPointsOnTarget = static_cast<vtkIdType>(wall.reached);
    const std::string text = "First cells off the wall: y+ " + bsv::shortNumber(this->YPlusRange[0]) + " to " +
      bsv::shortNumber(this->YPlusRange[1]) + " at Level " + std::to_string(this->Level) + "\nTarget y+ " +
      bsv::shortNumber(this->TargetYPlus) + ": reached within 1 % at " + std::to_string(wall.reached) + " of " +
      std::to_string(wall.wallPoints) + " points of the wall";
    bsv::setText(verdict, text + (wall.warning.empty() ? "" : ", see the report"));
    this->Report = text + '\n' + this->Report;
  });
}

//------------------------------------------------------------------------------
void vtkWallSpacing::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "ReynoldsNumber: " << this->ReynoldsNumber << '\n';
  os << indent << "MachNumber: " << this->MachNumber << '\n';
  os << indent << "ReferenceLength: " << this->ReferenceLength << '\n';
  os << indent << "LengthUnit: " << this->LengthUnit << '\n';
  os << indent << "Temperature: " << this->Temperature << '\n';
  os << indent << "Viscosity: " << this->Viscosity << '\n';
  os << indent << "PrandtlNumber: " << this->PrandtlNumber << '\n';
  os << indent << "FlowDirection: " << this->FlowDirection[0] << ' ' << this->FlowDirection[1] << ' '
     << this->FlowDirection[2] << '\n';
  os << indent << "TransitionLocation: " << this->TransitionLocation << '\n';
  os << indent << "MinimumDistance: " << this->MinimumDistance << '\n';
  os << indent << "TargetYPlus: " << this->TargetYPlus << '\n';
  os << indent << "Level: " << this->Level << '\n';
  os << indent << "MaximumGrowth: " << this->MaximumGrowth << '\n';
  os << indent << "BodyBoundaries: " << bsv::quotedList(this->BodyBoundaries) << '\n';
  os << indent << "SymmetryBoundaries: " << bsv::quotedList(this->SymmetryBoundaries) << '\n';
  os << indent << "UseCreaseAngle: " << (this->UseCreaseAngle ? "On" : "Off") << '\n';
  os << indent << "CreaseAngle: " << this->CreaseAngle << '\n';
  os << indent << "Report: " << this->Report << '\n';
}
