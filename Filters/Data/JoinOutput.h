// SPDX-License-Identifier: BSD-3-Clause
/// @file JoinOutput.h
/// Joins of volumes as vtkBSplineVolumeSmoothness shows them: surfaces of interfaces and blocks (JoinSurfaces.cxx);
/// lists, tables and texts (JoinTables.cxx).
#pragma once

#include "Data/BSplineVolumeData.h"
#include "Quality/JoinClass.h"
#include "Quality/Smoothness.h"

#include "vtkPolyData.h"
#include "vtkSmartPointer.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <initializer_list>
#include <string>
#include <vector>

class vtkPartitionedDataSetCollection;
class vtkPoints;
class vtkStringArray;
class vtkTable;

namespace bsv
{

/// A jump as users see it: the two normal jumps are one.
struct JoinMeasure
{
  const char* name;
  std::vector<JumpKind> kinds;
};
const std::vector<JoinMeasure>& joinMeasures();

/// The jump that is shown first: the only one that is small wherever it can be.
inline constexpr const char* ShownMeasure = "LayerJump";
inline constexpr const char* ShownTitle = "Layer jump (degrees)";

/// The largest of the kinds of a measure; at(kind) gives one.
template <typename At>
double largest(const JoinMeasure& measure, const At& at)
{
  double value = 0.0;
  for (const JumpKind kind : measure.kinds)
  {
    value = std::max<double>(value, at(static_cast<int>(kind)));
  }
  return value;
}

template <typename Array, typename Value>
vtkSmartPointer<Array> filled(const std::string& name, vtkIdType count, Value value)
{
  auto array = vtkSmartPointer<Array>::New();
  array->SetName(name.c_str());
  array->SetNumberOfValues(count);
  array->FillValue(value);
  return array;
}

template <typename Array, typename Value>
vtkSmartPointer<Array> listed(const char* name, std::initializer_list<Value> values)
{
  auto array = vtkSmartPointer<Array>::New();
  array->SetName(name);
  for (const Value value : values)
  {
    array->InsertNextValue(value);
  }
  return array;
}

vtkSmartPointer<vtkPoints> pointsOf(const std::vector<Vec3>& list);

/// @param parts samples per span
vtkSmartPointer<vtkPolyData> interfaceSurface(const Join& join, int id, int parts);
/// The six faces of a block.
vtkSmartPointer<vtkPolyData> skin(const BSplineVolume& volume, int parts);
/// The twelve edges of a block.
vtkSmartPointer<vtkPolyData> wires(const BSplineVolume& volume, int parts);
/// @param row row of the table, or -1
void setBlockJumps(vtkPolyData* surface, const BlockSmoothness& block, int row);
/// Parts on other ranks are null: data sets without a partition.
void setParts(vtkPartitionedDataSetCollection* output, const std::vector<vtkSmartPointer<vtkPolyData>>& parts,
  const std::vector<std::string>& names, const char* root);

/// One line per join, in the order of the list: on the first rank, which gets them from the others. Collective.
/// @param entries class, what, blocks, jump, measure, six bounds of what to look at and the direction in which the wall
/// lies seen from there (0 0 0: there is none), between tabulators
void fillJoinList(vtkPolyData* output, vtkStringArray* entries, const SmoothnessResult& result,
  const BSplineVolumeBlocks& input, const Eigen::AlignedBox3d& wall, const Ranks& ranks);
/// @param rows false: only the columns
void fillJoinTable(vtkTable* table, const SmoothnessResult& result, const std::vector<std::string>& names, bool rows);
/// Those that were measured on this rank.
void fillCurves(vtkPolyData* output, const SmoothnessResult& result, const BSplineVolumeBlocks& input);
std::string smoothnessVerdict(const SmoothnessResult& result, const std::vector<std::string>& names);
std::string smoothnessReport(const SmoothnessResult& result, const std::vector<std::string>& names);

} // namespace bsv
