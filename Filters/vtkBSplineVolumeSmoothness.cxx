// SPDX-License-Identifier: BSD-3-Clause
#include "vtkBSplineVolumeSmoothness.h"

#include "Data/BSplineVolumeData.h"
#include "Data/BoundarySelection.h"
#include "Data/FaceBounds.h"
#include "Data/HexBlockData.h"
#include "Data/Verdict.h"
#include "Execution/FilterExecution.h"
#include "Quality/JoinClass.h"
#include "Quality/JoinEvaluation.h"
#include "Quality/Smoothness.h"
#include "Volume/VolumeInterfaces.h"

#include "vtkCellArray.h"
#include "vtkCellData.h"
#include "vtkCompositeDataSet.h"
#include "vtkDataAssembly.h"
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
#include "vtkStringArray.h"
#include "vtkTable.h"

#include <algorithm>
#include <initializer_list>
#include <map>
#include <sstream>

vtkStandardNewMacro(vtkBSplineVolumeSmoothness);

namespace
{

using bsv::JumpKind;
using bsv::Vec3;

/// The ports.
struct Outputs
{
  vtkPartitionedDataSetCollection* interfaces;
  vtkPartitionedDataSetCollection* blocks;
  vtkTable* joins;
  vtkPolyData* curves;
  vtkPolyData* list;
  vtkTable* verdict;
};

/// A jump as users see it: the two normal jumps are one.
struct Measure
{
  const char* name;
  std::vector<JumpKind> kinds;
};
const std::vector<Measure>& measures()
{
  static const std::vector<Measure> all{ { "Gap", { JumpKind::Gap } },
    { "NormalJump", { JumpKind::NormalS, JumpKind::NormalT } }, { "LayerJump", { JumpKind::Layer } },
    { "Kink", { JumpKind::Kink } }, { "C1Jump", { JumpKind::C1 } }, { "C2Jump", { JumpKind::C2 } } };
  return all;
}

/// The jump that is shown first: the only one that is small wherever it can be.
constexpr const char* ShownMeasure = "LayerJump";
constexpr const char* ShownTitle = "Layer jump (degrees)";

/// Name of a jump as a maximum.
const char* measureName(JumpKind kind)
{
  for (const Measure& measure : measures())
  {
    if (std::find(measure.kinds.begin(), measure.kinds.end(), kind) != measure.kinds.end())
    {
      return measure.name;
    }
  }
  return "";
}

/// The largest of the kinds of a measure; at(kind) gives one.
template <typename At>
double largest(const Measure& measure, const At& at)
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

vtkSmartPointer<vtkPoints> pointsOf(const std::vector<Vec3>& list)
{
  auto points = vtkSmartPointer<vtkPoints>::New();
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(static_cast<vtkIdType>(list.size()));
  for (std::size_t n = 0; n < list.size(); ++n)
  {
    points->SetPoint(static_cast<vtkIdType>(n), list[n].data());
  }
  return points;
}

/// The quadrilaterals of a grid of ns x nt points that starts at point `first`.
void addQuads(vtkCellArray* cells, vtkIdType first, vtkIdType ns, vtkIdType nt)
{
  for (vtkIdType t = 0; t + 1 < nt; ++t)
  {
    for (vtkIdType s = 0; s + 1 < ns; ++s)
    {
      const vtkIdType p = first + s + ns * t;
      cells->InsertNextCell({ p, p + 1, p + 1 + ns, p + ns });
    }
  }
}

vtkSmartPointer<vtkPolyData> interfaceSurface(const bsv::Join& join, int id, int parts)
{
  auto surface = vtkSmartPointer<vtkPolyData>::New();
  surface->SetPoints(pointsOf(join.points));
  vtkNew<vtkCellArray> quads;
  addQuads(quads, 0, join.samples[0], join.samples[1]);
  surface->SetPolys(quads);

  const vtkIdType points = surface->GetNumberOfPoints();
  const vtkIdType cells = surface->GetNumberOfCells();
  for (const Measure& measure : measures())
  {
    const int components = static_cast<int>(measure.kinds.size());
    vtkNew<vtkDoubleArray> values;
    values->SetName(measure.name);
    values->SetNumberOfComponents(components);
    values->SetNumberOfTuples(points);
    for (int c = 0; c < components; ++c)
    {
      const std::vector<double>& list = join.values[int(measure.kinds[c])];
      for (vtkIdType n = 0; n < points; ++n)
      {
        values->SetTypedComponent(n, c, list[n]);
      }
    }
    surface->GetPointData()->AddArray(values);
    if (components > 1)
    {
      values->SetComponentName(0, "S");
      values->SetComponentName(1, "T");
      const auto worst = filled<vtkDoubleArray>("WorstNormalJump", points, 0.0);
      for (vtkIdType n = 0; n < points; ++n)
      {
        worst->SetValue(n, largest(measure, [&](int kind) { return join.values[kind][n]; }));
      }
      surface->GetPointData()->AddArray(worst);
    }

    const auto spans = filled<vtkDoubleArray>(std::string("Span") + measure.name, cells, 0.0);
    const vtkIdType row = join.samples[0] - 1;
    for (vtkIdType n = 0; n < cells; ++n)
    {
      const std::size_t span = n % row / parts + std::size_t(join.spans[0]) * (n / row / parts);
      spans->SetValue(n, largest(measure, [&](int kind) { return join.spanMaxima[kind][span]; }));
    }
    surface->GetCellData()->AddArray(spans);
    const double maximum = largest(measure, [&](int kind) { return join.worst[kind].value; });
    surface->GetFieldData()->AddArray(filled<vtkDoubleArray>(std::string("Maximum") + measure.name, 1, maximum));
  }
  // The same memory under a name that is a title.
  auto titled = vtkSmartPointer<vtkDataArray>::Take(surface->GetPointData()->GetArray(ShownMeasure)->NewInstance());
  titled->ShallowCopy(surface->GetPointData()->GetArray(ShownMeasure));
  titled->SetName(ShownTitle);
  surface->GetPointData()->AddArray(titled);
  surface->GetPointData()->SetActiveScalars(ShownTitle);
  const int continuity = static_cast<int>(join.continuity);
  surface->GetCellData()->AddArray(filled<vtkIntArray>("Continuity", cells, continuity));
  const auto& sides = join.sides;
  const auto& v = join.valences;
  for (const auto& array :
    { listed<vtkIntArray>("InterfaceId", { id }), listed<vtkIntArray>("Blocks", { sides[0].block, sides[1].block }),
      listed<vtkIntArray>("Faces", { sides[0].face, sides[1].face }),
      listed<vtkIntArray>("Orientation", { join.orientation }),
      listed<vtkIntArray>("AtCrease", { join.atCrease ? 1 : 0 }), listed<vtkIntArray>("Continuity", { continuity }),
      listed<vtkIntArray>("Valences", { v[0], v[1], v[2], v[3] }) })
  {
    surface->GetFieldData()->AddArray(array);
  }
  return surface;
}

/// The six faces of a block.
vtkSmartPointer<vtkPolyData> skin(const bsv::BSplineVolume& volume, int parts)
{
  std::vector<Vec3> points;
  vtkNew<vtkCellArray> quads;
  for (int face = 0; face < 6; ++face)
  {
    const bsv::FaceSamples samples = bsv::sampleFace(volume, face, parts);
    addQuads(quads, static_cast<vtkIdType>(points.size()), samples.samples[0], samples.samples[1]);
    points.insert(points.end(), samples.points.begin(), samples.points.end());
  }
  auto surface = vtkSmartPointer<vtkPolyData>::New();
  surface->SetPoints(pointsOf(points));
  surface->SetPolys(quads);
  return surface;
}

/// The twelve edges of a block.
vtkSmartPointer<vtkPolyData> wires(const bsv::BSplineVolume& volume, int parts)
{
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  vtkNew<vtkCellArray> lines;
  for (int edge = 0; edge < 12; ++edge)
  {
    const int along = bsv::edgeDirection(edge);
    Vec3 uvw;
    for (int d = 0; d < 3; ++d)
    {
      const std::vector<double>& knots = volume.knots[d];
      const int side = bsv::cornerSide(bsv::edgeCorner(edge, 0), d);
      uvw[d] = side == 0 ? knots[volume.degree[d]] : knots[knots.size() - 1 - volume.degree[d]];
    }
    const std::vector<double>& knots = volume.knots[along];
    const std::vector<int> spans = bsv::nonEmptySpans(volume.degree[along], knots);
    lines->InsertNextCell(static_cast<int>(spans.size()) * parts + 1);
    for (const int span : spans)
    {
      for (int j = span == spans.front() ? 0 : 1; j <= parts; ++j)
      {
        uvw[along] = knots[span] + (knots[span + 1] - knots[span]) * j / parts;
        lines->InsertCellPoint(points->InsertNextPoint(bsv::evaluate(volume, uvw).data()));
      }
    }
  }
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points);
  data->SetLines(lines);
  return data;
}

/// @param row row of the table, or -1
void setBlockJumps(vtkPolyData* surface, const bsv::BlockSmoothness& block, int row)
{
  const vtkIdType cells = surface->GetNumberOfCells();
  const auto both = [&](const auto& make) {
    surface->GetCellData()->AddArray(make(cells));
    surface->GetFieldData()->AddArray(make(1));
  };
  for (const Measure& measure : measures())
  {
    const double value = largest(measure, [&](int kind) { return block.worst[kind]; });
    both([&](vtkIdType n) { return filled<vtkDoubleArray>(measure.name, n, value); });
  }
  surface->GetCellData()->SetActiveScalars(ShownMeasure);
  both([&](vtkIdType n) { return filled<vtkIntArray>("Continuity", n, static_cast<int>(block.continuity)); });
  both([&](vtkIdType n) { return filled<vtkIntArray>("WorstJoin", n, row); });
}

/// Parts on other ranks are null: data sets without a partition.
void setParts(vtkPartitionedDataSetCollection* output, const std::vector<vtkSmartPointer<vtkPolyData>>& parts,
  const std::vector<std::string>& names, const char* root)
{
  output->SetNumberOfPartitionedDataSets(static_cast<unsigned int>(parts.size()));
  vtkNew<vtkDataAssembly> assembly;
  assembly->SetRootNodeName(root);
  for (unsigned int p = 0; p < parts.size(); ++p)
  {
    if (parts[p])
    {
      output->SetPartition(p, 0, parts[p]);
    }
    output->GetMetaData(p)->Set(vtkCompositeDataSet::NAME(), names[p].c_str());
    const int node = assembly->AddNode(bsv::nodeName(names[p]).c_str());
    assembly->AddDataSetIndex(node, p);
    assembly->SetAttribute(node, "label", names[p].c_str());
  }
  output->SetDataAssembly(assembly);
}

const char* kindOf(const bsv::Join& join)
{
  return !join.border() ? (join.inner() ? "repeated knot" : "interface") : join.crease ? "crease" : "wall border";
}

/// What a row of a list says of a join.
struct Row
{
  std::string of, what, blocks, jump, measure;
};

Row rowOf(const bsv::Join& join, const std::vector<std::string>& names)
{
  const bsv::ClassifiedJoin classified = bsv::classifyJoin(join);
  const JumpKind kind = join.crease ? JumpKind::NormalS : join.rankedBy();
  const bool angle = kind == JumpKind::Layer || kind == JumpKind::NormalS;
  const std::string what = kindOf(join);
  return { bsv::joinClassName(classified.of), what == classified.reason ? what : what + ", " + classified.reason,
    bsv::blocksText(join, names), bsv::shortNumber(join.worst[int(kind)].value) + (angle ? " degrees" : ""),
    measureName(kind) };
}

/// A point of a line with the jump that is shown.
struct LinePoint
{
  double x, y, z, jump;
};

/// The border of an interface, or the line of a wall border.
std::vector<LinePoint> outline(const bsv::Join& join)
{
  const std::vector<double>& jumps = join.values[int(JumpKind::Layer)];
  std::vector<LinePoint> line;
  const int ns = join.samples[0], nt = join.samples[1];
  const auto add = [&](int s, int t) {
    const std::size_t n = s + std::size_t(ns) * t;
    const Vec3& x = join.points[n];
    line.push_back({ x[0], x[1], x[2], jumps[n] });
  };
  if (join.border())
  {
    for (int s = 0; s < ns; ++s)
    {
      add(s, 0);
    }
    return line;
  }
  for (int s = 0; s + 1 < ns; ++s)
  {
    add(s, 0);
  }
  for (int t = 0; t + 1 < nt; ++t)
  {
    add(ns - 1, t);
  }
  for (int s = ns - 1; s > 0; --s)
  {
    add(s, nt - 1);
  }
  for (int t = nt - 1; t >= 0; --t)
  {
    add(0, t);
  }
  return line;
}

/// What to look at to see a join: around the place where it is worst, an eighth of the wall, or of the join if that is
/// smaller or there is no wall.
Eigen::AlignedBox3d closeUp(const Vec3& at, const Eigen::AlignedBox3d& line, const Eigen::AlignedBox3d& wall)
{
  double size = line.diagonal().norm();
  if (!wall.isEmpty())
  {
    size = std::min(size, wall.diagonal().norm());
  }
  const Vec3 half = Vec3::Constant(size / 16.0);
  return { at - half, at + half };
}

/// One line per join, in the order of the list: on the first rank, which gets them from the others. Collective.
/// @param entries class, what, blocks, jump, measure, six bounds of what to look at and the direction in which the wall
/// lies seen from there (0 0 0: there is none), between tabulators
void fillList(vtkPolyData* output, vtkStringArray* entries, const bsv::SmoothnessResult& result,
  const bsv::BSplineVolumeBlocks& input, const Eigen::AlignedBox3d& wall, const bsv::Ranks& ranks)
{
  std::vector<LinePoint> mine;
  std::vector<bsv::Index> counts;
  const std::vector<int> order = bsv::rankedByClass(result);
  for (const int n : order)
  {
    const bsv::Join& join = result.joins[n];
    if (input.isHere(join.sides[0].block))
    {
      const std::vector<LinePoint> line = outline(join);
      counts.push_back(static_cast<bsv::Index>(line.size()));
      mine.insert(mine.end(), line.begin(), line.end());
    }
  }
  const auto allCounts = ranks.gather(counts);
  const auto allPoints = ranks.gather(mine);
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  vtkNew<vtkCellArray> lines;
  // The spreadsheet sorts columns by their names.
  const auto rank = filled<vtkIntArray>("1 Rank", 0, 0);
  const auto joinClass = filled<vtkIntArray>("JoinClass", 0, 0);
  const auto layerJump = filled<vtkDoubleArray>(ShownTitle, 0, 0.0);
  const auto jumpHere = filled<vtkDoubleArray>(ShownTitle, 0, 0.0);
  vtkNew<vtkDoubleArray> where;
  where->SetName("Where");
  where->SetNumberOfComponents(3);
  std::array<vtkNew<vtkStringArray>, 5> texts;
  static constexpr const char* Names[5] = { "2 Class", "3 What", "4 Blocks", "5 Jump", "6 Measure" };
  for (int n = 0; n < 5; ++n)
  {
    texts[n]->SetName(Names[n]);
  }
  std::vector<std::size_t> nextCount(allCounts.size(), 0), nextPoint(allCounts.size(), 0);
  for (std::size_t row = 0; row < order.size() && ranks.rank() == 0; ++row)
  {
    const bsv::Join& join = result.joins[order[row]];
    const int from = input.ranks[join.sides[0].block];
    const bsv::Index count = allCounts[from][nextCount[from]++];
    lines->InsertNextCell(static_cast<int>(count));
    Eigen::AlignedBox3d box;
    for (bsv::Index n = 0; n < count; ++n)
    {
      const LinePoint& point = allPoints[from][nextPoint[from]++];
      lines->InsertCellPoint(points->InsertNextPoint(point.x, point.y, point.z));
      jumpHere->InsertNextValue(point.jump);
      box.extend(Vec3(point.x, point.y, point.z));
    }
    const Row entry = rowOf(join, input.names);
    rank->InsertNextValue(static_cast<int>(row) + 1);
    joinClass->InsertNextValue(static_cast<int>(bsv::classifyJoin(join).of));
    layerJump->InsertNextValue(join.worst[int(JumpKind::Layer)].value);
    const Vec3& worst = join.worst[int(join.crease ? JumpKind::NormalS : join.rankedBy())].point;
    where->InsertNextTuple(worst.data());
    const std::array<const std::string*, 5> columns{ &entry.of, &entry.what, &entry.blocks, &entry.jump,
      &entry.measure };
    std::string text;
    for (int n = 0; n < 5; ++n)
    {
      texts[n]->InsertNextValue(*columns[n]);
      text += *columns[n] + '\t';
    }
    const Eigen::AlignedBox3d look = closeUp(worst, box, wall);
    const Vec3 inwards = wall.isEmpty() ? Vec3(Vec3::Zero()) : Vec3(wall.center() - worst);
    for (const double value : { look.min()[0], look.max()[0], look.min()[1], look.max()[1], look.min()[2],
           look.max()[2], inwards[0], inwards[1], inwards[2] })
    {
      std::ostringstream number;
      number.precision(17);
      number << value;
      text += number.str() + '\t';
    }
    text.pop_back();
    entries->InsertNextValue(text);
  }
  output->SetPoints(points);
  output->SetLines(lines);
  output->GetPointData()->AddArray(jumpHere);
  output->GetPointData()->SetActiveScalars(ShownTitle);
  output->GetCellData()->AddArray(rank);
  for (const auto& array : texts)
  {
    output->GetCellData()->AddArray(array);
  }
  output->GetCellData()->AddArray(joinClass);
  output->GetCellData()->AddArray(layerJump);
  output->GetCellData()->AddArray(where);
  if (!wall.isEmpty())
  {
    output->GetFieldData()->AddArray(listed<vtkDoubleArray>(
      "WallBox", { wall.min()[0], wall.max()[0], wall.min()[1], wall.max()[1], wall.min()[2], wall.max()[2] }));
  }
}

/// @param rows false: only the columns
void fillTable(vtkTable* table, const bsv::SmoothnessResult& result, const std::vector<std::string>& names, bool rows)
{
  const std::size_t count = rows ? result.ranking.size() : 0;
  const auto column = [&](auto array, const std::string& name, int components, const auto& fill) {
    array->SetName(name.c_str());
    array->SetNumberOfComponents(components);
    array->SetNumberOfTuples(static_cast<vtkIdType>(count));
    for (std::size_t row = 0; row < count; ++row)
    {
      fill(array.Get(), static_cast<vtkIdType>(row), result.joins[result.ranking[row]]);
    }
    table->AddColumn(array);
  };
  const auto text = [&](const std::string& name, const auto& get) {
    column(vtkSmartPointer<vtkStringArray>::New(), name, 1,
      [&](vtkStringArray* array, vtkIdType row, const bsv::Join& join) { array->SetValue(row, get(join)); });
  };
  const auto integer = [&](const std::string& name, const auto& get) {
    column(vtkSmartPointer<vtkIntArray>::New(), name, 1,
      [&](vtkIntArray* array, vtkIdType row, const bsv::Join& join) { array->SetValue(row, get(join)); });
  };
  const auto number = [&](const std::string& name, const auto& get) {
    column(vtkSmartPointer<vtkDoubleArray>::New(), name, 1,
      [&](vtkDoubleArray* array, vtkIdType row, const bsv::Join& join) { array->SetValue(row, get(join)); });
  };
  const auto triple = [&](const std::string& name, const auto& get) {
    column(vtkSmartPointer<vtkDoubleArray>::New(), name, 3,
      [&](vtkDoubleArray* array, vtkIdType row, const bsv::Join& join) {
        array->SetTypedTuple(row, get(join.worst[int(join.rankedBy())]).data());
      });
  };
  using bsv::Join;
  using bsv::JumpMaximum;

  text("Class", [](const Join& join) { return bsv::joinClassName(bsv::classifyJoin(join).of); });
  text("Continuity", [](const Join& join) { return bsv::continuityName(join.continuity); });
  text("Kind", [](const Join& join) { return kindOf(join); });
  for (int side = 0; side < 2; ++side)
  {
    text(side ? "NameB" : "NameA", [&](const Join& join) { return names[join.sides[side].block]; });
  }
  for (int side = 0; side < 2; ++side)
  {
    const std::string letter = side ? "B" : "A";
    integer("Block" + letter, [&](const Join& join) { return join.sides[side].block; });
    integer("Face" + letter, [&](const Join& join) { return join.sides[side].face; });
    integer("Edge" + letter, [&](const Join& join) { return join.sides[side].edge; });
  }
  integer("Orientation", [](const Join& join) { return join.orientation; });
  integer("AtCrease", [](const Join& join) { return join.crease || join.atCrease ? 1 : 0; });
  for (const Measure& measure : measures())
  {
    const std::string name = std::string("Maximum") + measure.name;
    number(name, [&](const Join& join) { return largest(measure, [&](int kind) { return join.worst[kind].value; }); });
    for (std::size_t c = 0; measure.kinds.size() > 1 && c < measure.kinds.size(); ++c)
    {
      number(name + (c ? "T" : "S"), [&](const Join& join) { return join.worst[int(measure.kinds[c])].value; });
    }
  }
  text("RankedBy", [](const Join& join) { return measureName(join.rankedBy()); });
  triple("Where", [](const JumpMaximum& jump) { return jump.point; });
  triple("UVWA", [](const JumpMaximum& jump) { return jump.uvw[0]; });
  triple("UVWB", [](const JumpMaximum& jump) { return jump.uvw[1]; });
}

/// Lines with one value of each array per line, and a jump per point.
class CurveBuilder
{
public:
  CurveBuilder()
  {
    for (std::size_t n = 0; n < this->PerCell.size(); ++n)
    {
      this->PerCell[n]->SetName(Names[n]);
    }
    this->Valence->SetName("Valence");
    this->NormalJump->SetName("NormalJump");
    this->Points->SetDataTypeToDouble();
  }

  /// @param perCell kind, valence, continuity, block A, block B
  void add(const std::vector<Vec3>& points, const std::vector<double>& jumps, const std::array<int, 5>& perCell)
  {
    this->Lines->InsertNextCell(static_cast<int>(points.size()));
    for (std::size_t n = 0; n < points.size(); ++n)
    {
      this->Lines->InsertCellPoint(this->Points->InsertNextPoint(points[n].data()));
      this->NormalJump->InsertNextValue(jumps[n]);
      this->Valence->InsertNextValue(perCell[1]);
    }
    for (std::size_t n = 0; n < perCell.size(); ++n)
    {
      this->PerCell[n]->InsertNextValue(perCell[n]);
    }
  }

  void build(vtkPolyData* output)
  {
    output->SetPoints(this->Points);
    output->SetLines(this->Lines);
    output->GetPointData()->AddArray(this->Valence);
    output->GetPointData()->AddArray(this->NormalJump);
    output->GetPointData()->SetActiveScalars("NormalJump");
    for (const auto& array : this->PerCell)
    {
      output->GetCellData()->AddArray(array);
    }
  }

private:
  static constexpr const char* Names[5] = { "Kind", "Valence", "Continuity", "BlockA", "BlockB" };
  vtkNew<vtkPoints> Points;
  vtkNew<vtkCellArray> Lines;
  vtkNew<vtkIntArray> Valence;
  vtkNew<vtkDoubleArray> NormalJump;
  std::array<vtkNew<vtkIntArray>, 5> PerCell;
};

/// Those that were measured on this rank.
void fillCurves(vtkPolyData* output, const bsv::SmoothnessResult& result, const bsv::BSplineVolumeBlocks& input)
{
  CurveBuilder builder;
  for (const bsv::ExtraordinaryCurve& curve : result.curves)
  {
    if (input.isHere(curve.block))
    {
      builder.add(curve.points, curve.normalJump, { 0, curve.valence, -1, -1, -1 });
    }
  }
  for (const bsv::Join& join : result.joins)
  {
    if (join.border() && input.isHere(join.sides[0].block))
    {
      builder.add(join.points, join.values[int(JumpKind::NormalS)],
        { join.crease ? 2 : 1, std::abs(join.valences[0]), static_cast<int>(join.continuity), join.sides[0].block,
          join.sides[1].block });
    }
  }
  builder.build(output);
}

std::string verdictText(const bsv::SmoothnessResult& result, const std::vector<std::string>& names)
{
  std::array<int, bsv::JoinClasses> counts{};
  for (const bsv::Join& join : result.joins)
  {
    ++counts[int(bsv::classifyJoin(join).of)];
  }
  std::ostringstream text;
  text << result.joins.size() << " joins: " << counts[int(bsv::JoinClass::Defect)] << " defects, "
       << counts[int(bsv::JoinClass::Expected)] << " expected, " << counts[int(bsv::JoinClass::Deliberate)]
       << " deliberate, " << counts[int(bsv::JoinClass::Smooth)] << " smooth";
  if (counts[int(bsv::JoinClass::Defect)] > 0)
  {
    const bsv::Join& join = result.joins[bsv::rankedByClass(result).front()];
    const Vec3& at = join.worst[int(join.rankedBy())].point;
    const Row row = rowOf(join, names);
    text << "\nWorst defect: " << row.jump << ' ' << row.measure << " at " << bsv::shortNumber(at[0]) << ' '
         << bsv::shortNumber(at[1]) << ' ' << bsv::shortNumber(at[2]) << ", " << row.blocks;
  }
  return text.str();
}

std::string reportOf(const bsv::SmoothnessResult& result, const std::vector<std::string>& names)
{
  std::ostringstream text;
  for (const bool border : { false, true })
  {
    std::map<bsv::JoinContinuity, int> counts;
    int joins = 0;
    int inner = 0;
    int creases = 0;
    for (const bsv::Join& join : result.joins)
    {
      if (join.border() == border)
      {
        ++joins;
        inner += join.inner() ? 1 : 0;
        creases += join.crease ? 1 : 0;
        counts[join.continuity] += join.crease ? 0 : 1;
      }
    }
    text << joins << (border ? " wall borders" : " interfaces");
    if (inner > 0)
    {
      text << " (" << inner << " inside blocks, at repeated knots)";
    }
    const char* separator = ": ";
    for (const auto& [continuity, count] : counts)
    {
      if (count > 0)
      {
        text << separator << count << ' ' << bsv::continuityName(continuity);
        separator = ", ";
      }
    }
    if (creases > 0)
    {
      text << separator << creases << " creases";
    }
    text << '\n';
  }
  std::map<int, int> curves;
  for (const bsv::ExtraordinaryCurve& curve : result.curves)
  {
    ++curves[curve.valence];
  }
  for (const auto& [valence, count] : curves)
  {
    text << count << " extraordinary block edges of valence " << valence << '\n';
  }
  if (!result.ranking.empty() && !result.joins[result.ranking.front()].crease)
  {
    const bsv::Join& join = result.joins[result.ranking.front()];
    const bsv::JumpMaximum& jump = join.worst[int(join.rankedBy())];
    text << "worst of all, expected or not: " << kindOf(join) << ' ' << bsv::blocksText(join, names) << ", "
         << bsv::continuityName(join.continuity) << ", " << measureName(join.rankedBy()) << ' ' << jump.value << " at "
         << jump.point[0] << ' ' << jump.point[1] << ' ' << jump.point[2] << '\n';
  }
  return text.str();
}

} // namespace

//------------------------------------------------------------------------------
vtkBSplineVolumeSmoothness::vtkBSplineVolumeSmoothness()
  : JoinList(vtkSmartPointer<vtkStringArray>::New())
{
  this->SetNumberOfOutputPorts(6);
}

//------------------------------------------------------------------------------
vtkBSplineVolumeSmoothness::~vtkBSplineVolumeSmoothness() = default;

//------------------------------------------------------------------------------
vtkStringArray* vtkBSplineVolumeSmoothness::GetJoinList()
{
  return this->JoinList;
}

//------------------------------------------------------------------------------
void vtkBSplineVolumeSmoothness::AddBodyBoundary(const char* pattern)
{
  if (pattern && *pattern)
  {
    this->BodyBoundaries.emplace_back(pattern);
    this->Modified();
  }
}

//------------------------------------------------------------------------------
void vtkBSplineVolumeSmoothness::ClearBodyBoundaries()
{
  this->BodyBoundaries.clear();
  this->Modified();
}

//------------------------------------------------------------------------------
const char* vtkBSplineVolumeSmoothness::GetBodyBoundary(int index) const
{
  return index >= 0 && index < this->GetNumberOfBodyBoundaries() ? this->BodyBoundaries[index].c_str() : nullptr;
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeSmoothness::FillInputPortInformation(int, vtkInformation* info)
{
  bsv::acceptMissing(info);
  info->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkDataObjectTree");
  info->Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkStructuredGrid");
  return 1;
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeSmoothness::FillOutputPortInformation(int port, vtkInformation* info)
{
  static constexpr const char* Types[6] = { "vtkPartitionedDataSetCollection", "vtkPartitionedDataSetCollection",
    "vtkTable", "vtkPolyData", "vtkPolyData", "vtkTable" };
  info->Set(vtkDataObject::DATA_TYPE_NAME(), Types[port]);
  return 1;
}

//------------------------------------------------------------------------------
int vtkBSplineVolumeSmoothness::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  Outputs output{ vtkPartitionedDataSetCollection::GetData(outputVector, 0),
    vtkPartitionedDataSetCollection::GetData(outputVector, 1), vtkTable::GetData(outputVector, 2),
    vtkPolyData::GetData(outputVector, 3), vtkPolyData::GetData(outputVector, 4), vtkTable::GetData(outputVector, 5) };
  if (!output.interfaces || !output.blocks || !output.joins || !output.curves || !output.list || !output.verdict)
  {
    vtkErrorMacro("An output is missing.");
    return 0;
  }

  this->MaximumGap = this->MaximumNormalJump = this->MaximumLayerJump = this->MaximumKink = this->MaximumC1Jump =
    this->MaximumC2Jump = 0.0;
  this->NumberOfInterfaces = this->NumberOfWallBorders = this->NumberOfExtraordinaryCurves = 0;
  this->Report.clear();
  this->JoinList->Initialize();
  bsv::setText(output.verdict, "");

  return bsv::execute(this, [&] {
    const bsv::BSplineVolumeBlocks input =
      bsv::bsplineVolumeBlocks(bsv::requiredInput(inputVector, 0), *bsv::globalRanks());
    if (input.volumes.empty())
    {
      return;
    }
    const auto blockName = [&](int block) { return input.label(block); };
    std::vector<bsv::Interface> interfaces = input.interfaces;
    if (!input.hasInterfaces)
    {
      if (!(this->MatchTolerance > 0.0 && this->MatchTolerance < 0.5))
      {
        throw bsv::Error("MatchTolerance must lie between 0 and 0.5, not " + std::to_string(this->MatchTolerance));
      }
      bsv::VolumeInterfaceOptions search;
      search.tolerance = this->MatchTolerance;
      search.boundaries = input.boundaries;
      search.blockName = blockName;
      interfaces = bsv::findVolumeInterfaces(input.volumes, search, bsv::filterExecution(this, 0.0, 0.1));
    }

    bsv::warn(this,
      bsv::uselessPatterns("Body Boundaries", this->BodyBoundaries, bsv::defaultBodyBoundaries(), input.boundaryNames,
        input.boundaryTypes));
    const std::vector<bool> wall = bsv::facesOf(input,
      bsv::wallBoundaries(vtkDataObject::GetData(inputVector[0], 0), input.boundaryNames, input.boundaryTypes,
        this->BodyBoundaries, *bsv::globalRanks()));
    const bool all = this->AllOuterFaces || std::find(wall.begin(), wall.end(), true) == wall.end();
    bsv::SmoothnessOptions options;
    options.samplesPerSpan = this->SamplesPerSpan;
    double samples = 0.0;
    for (const bsv::Interface& contact : interfaces)
    {
      const bsv::BSplineVolume& volume = input.volumes[contact.blockA];
      double product = input.isHere(contact.blockA) ? 1.0 : 0.0;
      for (int axis = 0; axis < 2; ++axis)
      {
        const int d = bsv::faceAxis(contact.faceA, axis);
        product *= static_cast<double>(this->SamplesPerSpan) *
            static_cast<double>(bsv::nonEmptySpans(volume.degree[d], volume.knots[d]).size()) +
          1.0;
      }
      samples += product;
    }
    // Measured and as arrays: a point, the jumps, a quadrilateral.
    bsv::requireMemory(samples * (2 * (3 + bsv::JumpKinds) + 5) * sizeof(double),
      "Samples Per Span " + std::to_string(this->SamplesPerSpan), "the samples");
    options.creaseAngle = this->CreaseAngle;
    options.gapTolerance = this->GapTolerance;
    options.tolerance = this->Tolerance;
    options.isWall = [&](int block, int face) { return all || wall[6 * block + face]; };
    options.rules = input.rules;
    options.blockName = blockName;
    bsv::SmoothnessResult result =
      bsv::measureSmoothness(input.volumes, interfaces, options, bsv::filterExecution(this, 0.1, 0.7));

    std::vector<vtkSmartPointer<vtkPolyData>> surfaces;
    std::vector<std::string> names;
    // The tables of all ranks are shown as one.
    fillTable(output.joins, result, input.names, bsv::globalRanks()->rank() == 0);
    fillCurves(output.curves, result, input);
    fillList(output.list, this->JoinList, result, input,
      all ? Eigen::AlignedBox3d() : bsv::faceBounds(input, wall, *bsv::globalRanks()), *bsv::globalRanks());
    const bsv::Execution sides = bsv::filterExecution(this, 0.7, 0.9);
    const auto borders =
      std::find_if(result.joins.begin(), result.joins.end(), [](const bsv::Join& join) { return join.border(); });
    const std::size_t count = borders - result.joins.begin();
    for (std::size_t n = 0; n < count; ++n)
    {
      sides.report(static_cast<double>(n) / static_cast<double>(count));
      bsv::Join& join = result.joins[n];
      surfaces.push_back(input.isHere(join.sides[0].block)
          ? interfaceSurface(join, static_cast<int>(n), this->SamplesPerSpan)
          : nullptr);
      names.push_back(input.names[join.sides[0].block] + "|" + input.names[join.sides[1].block]);
      // Not twice in memory.
      join.points = {};
      join.values = {};
      join.spanMaxima = {};
    }
    setParts(output.interfaces, surfaces, names, "Interfaces");

    const bsv::Execution run = bsv::filterExecution(this, 0.9, 1.0);
    std::vector<int> rowOf(result.joins.size() + 1, -1);
    for (std::size_t row = 0; row < result.ranking.size(); ++row)
    {
      rowOf[result.ranking[row]] = static_cast<int>(row);
    }
    surfaces.clear();
    for (std::size_t b = 0; b < input.volumes.size(); ++b)
    {
      run.report(static_cast<double>(b) / input.volumes.size());
      const int worst = result.blocks[b].worstJoin;
      surfaces.push_back(nullptr);
      if (!input.isHere(b))
      {
        continue;
      }
      surfaces.back() = this->BlockSkins ? skin(input.volumes[b], this->SamplesPerSpan) : wires(input.volumes[b], 2);
      setBlockJumps(surfaces.back(), result.blocks[b], worst < 0 ? -1 : rowOf[worst]);
    }
    setParts(output.blocks, surfaces, input.names, "Blocks");

    double* totals[] = { &this->MaximumGap, &this->MaximumNormalJump, &this->MaximumLayerJump, &this->MaximumKink,
      &this->MaximumC1Jump, &this->MaximumC2Jump };
    for (std::size_t m = 0; m < measures().size(); ++m)
    {
      const Measure& measure = measures()[m];
      *totals[m] = largest(measure, [&](int kind) { return result.worst[kind]; });
      output.interfaces->GetFieldData()->AddArray(
        filled<vtkDoubleArray>(std::string("Maximum") + measure.name, 1, *totals[m]));
    }
    this->NumberOfInterfaces = static_cast<int>(count);
    this->NumberOfWallBorders = static_cast<int>(result.joins.size() - count);
    this->NumberOfExtraordinaryCurves = static_cast<int>(result.curves.size());
    const std::string text = verdictText(result, input.names);
    bsv::setText(output.verdict, text);
    this->Report = text + '\n' + reportOf(result, input.names);
    this->UpdateProgress(1.0);
  });
}

//------------------------------------------------------------------------------
void vtkBSplineVolumeSmoothness::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "SamplesPerSpan: " << this->SamplesPerSpan << '\n';
  os << indent << "BodyBoundaries: " << bsv::quotedList(this->BodyBoundaries) << '\n';
  os << indent << "AllOuterFaces: " << (this->AllOuterFaces ? "On" : "Off") << '\n';
  os << indent << "CreaseAngle: " << this->CreaseAngle << '\n';
  os << indent << "GapTolerance: " << this->GapTolerance << '\n';
  os << indent << "Tolerance: " << this->Tolerance << '\n';
  os << indent << "MatchTolerance: " << this->MatchTolerance << '\n';
  os << indent << "BlockSkins: " << (this->BlockSkins ? "On" : "Off") << '\n';
  os << indent << "Report: " << this->Report << '\n';
}
