// SPDX-License-Identifier: BSD-3-Clause
// Joins as lists, tables, lines and texts.
#include "Data/JoinOutput.h"

#include "Data/Verdict.h"
#include "Quality/JoinEvaluation.h"
#include "Ranks/Ranks.h"

#include "vtkCellArray.h"
#include "vtkCellData.h"
#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkIntArray.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkStringArray.h"
#include "vtkTable.h"

#include <array>
#include <map>
#include <sstream>

namespace bsv
{

namespace
{

/// Name of a jump as a maximum.
const char* measureName(JumpKind kind)
{
  for (const JoinMeasure& measure : joinMeasures())
  {
    if (std::find(measure.kinds.begin(), measure.kinds.end(), kind) != measure.kinds.end())
    {
      return measure.name;
    }
  }
  return "";
}

const char* kindOf(const Join& join)
{
  return !join.border() ? (join.inner() ? "repeated knot" : "interface") : join.crease ? "crease" : "wall border";
}

/// What a row of a list says of a join.
struct Row
{
  std::string of, what, blocks, jump, measure;
};

Row rowOf(const Join& join, const std::vector<std::string>& names)
{
  const ClassifiedJoin classified = classifyJoin(join);
  const JumpKind kind = join.crease ? JumpKind::NormalS : join.rankedBy();
  const bool angle = kind == JumpKind::Layer || kind == JumpKind::NormalS;
  const std::string what = kindOf(join);
  return { joinClassName(classified.of), what == classified.reason ? what : what + ", " + classified.reason,
    blocksText(join, names), shortNumber(join.worst[int(kind)].value) + (angle ? " degrees" : ""), measureName(kind) };
}

/// A point of a line with the jump that is shown.
struct LinePoint
{
  double x, y, z, jump;
};

/// The border of an interface, or the line of a wall border.
std::vector<LinePoint> outline(const Join& join)
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

} // namespace

const std::vector<JoinMeasure>& joinMeasures()
{
  static const std::vector<JoinMeasure> all{ { "Gap", { JumpKind::Gap } },
    { "NormalJump", { JumpKind::NormalS, JumpKind::NormalT } }, { "LayerJump", { JumpKind::Layer } },
    { "Kink", { JumpKind::Kink } }, { "C1Jump", { JumpKind::C1 } }, { "C2Jump", { JumpKind::C2 } } };
  return all;
}

void fillJoinList(vtkPolyData* output, vtkStringArray* entries, const SmoothnessResult& result,
  const BSplineVolumeBlocks& input, const Eigen::AlignedBox3d& wall, const Ranks& ranks)
{
  std::vector<LinePoint> mine;
  std::vector<Index> counts;
  const std::vector<int> order = rankedByClass(result);
  for (const int n : order)
  {
    const Join& join = result.joins[n];
    if (input.isHere(join.sides[0].block))
    {
      const std::vector<LinePoint> line = outline(join);
      counts.push_back(static_cast<Index>(line.size()));
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
  static constexpr const char* Names[5] = { "2 Class", "3 What", "4 Blocks", "5 Jump", "6 JoinMeasure" };
  for (int n = 0; n < 5; ++n)
  {
    texts[n]->SetName(Names[n]);
  }
  std::vector<std::size_t> nextCount(allCounts.size(), 0), nextPoint(allCounts.size(), 0);
  for (std::size_t row = 0; row < order.size() && ranks.rank() == 0; ++row)
  {
    const Join& join = result.joins[order[row]];
    const int from = input.ranks[join.sides[0].block];
    const Index count = allCounts[from][nextCount[from]++];
    lines->InsertNextCell(static_cast<int>(count));
    Eigen::AlignedBox3d box;
    for (Index n = 0; n < count; ++n)
    {
      const LinePoint& point = allPoints[from][nextPoint[from]++];
      lines->InsertCellPoint(points->InsertNextPoint(point.x, point.y, point.z));
      jumpHere->InsertNextValue(point.jump);
      box.extend(Vec3(point.x, point.y, point.z));
    }
    const Row entry = rowOf(join, input.names);
    rank->InsertNextValue(static_cast<int>(row) + 1);
    joinClass->InsertNextValue(static_cast<int>(classifyJoin(join).of));
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

void fillJoinTable(vtkTable* table, const SmoothnessResult& result, const std::vector<std::string>& names, bool rows)
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
      [&](vtkStringArray* array, vtkIdType row, const Join& join) { array->SetValue(row, get(join)); });
  };
  const auto integer = [&](const std::string& name, const auto& get) {
    column(vtkSmartPointer<vtkIntArray>::New(), name, 1,
      [&](vtkIntArray* array, vtkIdType row, const Join& join) { array->SetValue(row, get(join)); });
  };
  const auto number = [&](const std::string& name, const auto& get) {
    column(vtkSmartPointer<vtkDoubleArray>::New(), name, 1,
      [&](vtkDoubleArray* array, vtkIdType row, const Join& join) { array->SetValue(row, get(join)); });
  };
  const auto triple = [&](const std::string& name, const auto& get) {
    column(
      vtkSmartPointer<vtkDoubleArray>::New(), name, 3, [&](vtkDoubleArray* array, vtkIdType row, const Join& join) {
        array->SetTypedTuple(row, get(join.worst[int(join.rankedBy())]).data());
      });
  };

  text("Class", [](const Join& join) { return joinClassName(classifyJoin(join).of); });
  text("Continuity", [](const Join& join) { return continuityName(join.continuity); });
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
  for (const JoinMeasure& measure : joinMeasures())
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

void fillCurves(vtkPolyData* output, const SmoothnessResult& result, const BSplineVolumeBlocks& input)
{
  CurveBuilder builder;
  for (const ExtraordinaryCurve& curve : result.curves)
  {
    if (input.isHere(curve.block))
    {
      builder.add(curve.points, curve.normalJump, { 0, curve.valence, -1, -1, -1 });
    }
  }
  for (const Join& join : result.joins)
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

std::string smoothnessVerdict(const SmoothnessResult& result, const std::vector<std::string>& names)
{
  std::array<int, JoinClasses> counts{};
  for (const Join& join : result.joins)
  {
    ++counts[int(classifyJoin(join).of)];
  }
  std::ostringstream text;
  text << result.joins.size() << " joins: " << counts[int(JoinClass::Defect)] << " defects, "
       << counts[int(JoinClass::Expected)] << " expected, " << counts[int(JoinClass::Deliberate)] << " deliberate, "
       << counts[int(JoinClass::Smooth)] << " smooth";
  if (counts[int(JoinClass::Defect)] > 0)
  {
    const Join& join = result.joins[rankedByClass(result).front()];
    const Vec3& at = join.worst[int(join.rankedBy())].point;
    const Row row = rowOf(join, names);
    text << "\nWorst defect: " << row.jump << ' ' << row.measure << " at " << shortNumber(at[0]) << ' '
         << shortNumber(at[1]) << ' ' << shortNumber(at[2]) << ", " << row.blocks;
  }
  return text.str();
}

std::string smoothnessReport(const SmoothnessResult& result, const std::vector<std::string>& names)
{
  std::ostringstream text;
  for (const bool border : { false, true })
  {
    std::map<JoinContinuity, int> counts;
    int joins = 0;
    int inner = 0;
    int creases = 0;
    for (const Join& join : result.joins)
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
        text << separator << count << ' ' << continuityName(continuity);
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
  for (const ExtraordinaryCurve& curve : result.curves)
  {
    ++curves[curve.valence];
  }
  for (const auto& [valence, count] : curves)
  {
    text << count << " extraordinary block edges of valence " << valence << '\n';
  }
  if (!result.ranking.empty() && !result.joins[result.ranking.front()].crease)
  {
    const Join& join = result.joins[result.ranking.front()];
    const JumpMaximum& jump = join.worst[int(join.rankedBy())];
    text << "worst of all, expected or not: " << kindOf(join) << ' ' << blocksText(join, names) << ", "
         << continuityName(join.continuity) << ", " << measureName(join.rankedBy()) << ' ' << jump.value << " at "
         << jump.point[0] << ' ' << jump.point[1] << ' ' << jump.point[2] << '\n';
  }
  return text.str();
}

} // namespace bsv
