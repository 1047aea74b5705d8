// SPDX-License-Identifier: BSD-3-Clause
// Interfaces and blocks as surfaces with their jumps.
#include "Data/JoinOutput.h"

#include "Data/HexBlockData.h"
#include "Quality/JoinEvaluation.h"

#include "vtkCellArray.h"
#include "vtkCellData.h"
#include "vtkCompositeDataSet.h"
#include "vtkDataAssembly.h"
#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkInformation.h"
#include "vtkIntArray.h"
#include "vtkNew.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"

namespace bsv
{

namespace
{

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

} // namespace

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

vtkSmartPointer<vtkPolyData> interfaceSurface(const Join& join, int id, int parts)
{
  auto surface = vtkSmartPointer<vtkPolyData>::New();
  surface->SetPoints(pointsOf(join.points));
  vtkNew<vtkCellArray> quads;
  addQuads(quads, 0, join.samples[0], join.samples[1]);
  surface->SetPolys(quads);

  const vtkIdType points = surface->GetNumberOfPoints();
  const vtkIdType cells = surface->GetNumberOfCells();
  for (const JoinMeasure& measure : joinMeasures())
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

vtkSmartPointer<vtkPolyData> skin(const BSplineVolume& volume, int parts)
{
  std::vector<Vec3> points;
  vtkNew<vtkCellArray> quads;
  for (int face = 0; face < 6; ++face)
  {
    const FaceSamples samples = sampleFace(volume, face, parts);
    addQuads(quads, static_cast<vtkIdType>(points.size()), samples.samples[0], samples.samples[1]);
    points.insert(points.end(), samples.points.begin(), samples.points.end());
  }
  auto surface = vtkSmartPointer<vtkPolyData>::New();
  surface->SetPoints(pointsOf(points));
  surface->SetPolys(quads);
  return surface;
}

vtkSmartPointer<vtkPolyData> wires(const BSplineVolume& volume, int parts)
{
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  vtkNew<vtkCellArray> lines;
  for (int edge = 0; edge < 12; ++edge)
  {
    const int along = edgeDirection(edge);
    Vec3 uvw;
    for (int d = 0; d < 3; ++d)
    {
      const std::vector<double>& knots = volume.knots[d];
      const int side = cornerSide(edgeCorner(edge, 0), d);
      uvw[d] = side == 0 ? knots[volume.degree[d]] : knots[knots.size() - 1 - volume.degree[d]];
    }
    const std::vector<double>& knots = volume.knots[along];
    const std::vector<int> spans = nonEmptySpans(volume.degree[along], knots);
    lines->InsertNextCell(static_cast<int>(spans.size()) * parts + 1);
    for (const int span : spans)
    {
      for (int j = span == spans.front() ? 0 : 1; j <= parts; ++j)
      {
        uvw[along] = knots[span] + (knots[span + 1] - knots[span]) * j / parts;
        lines->InsertCellPoint(points->InsertNextPoint(evaluate(volume, uvw).data()));
      }
    }
  }
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points);
  data->SetLines(lines);
  return data;
}

void setBlockJumps(vtkPolyData* surface, const BlockSmoothness& block, int row)
{
  const vtkIdType cells = surface->GetNumberOfCells();
  const auto both = [&](const auto& make) {
    surface->GetCellData()->AddArray(make(cells));
    surface->GetFieldData()->AddArray(make(1));
  };
  for (const JoinMeasure& measure : joinMeasures())
  {
    const double value = largest(measure, [&](int kind) { return block.worst[kind]; });
    both([&](vtkIdType n) { return filled<vtkDoubleArray>(measure.name, n, value); });
  }
  surface->GetCellData()->SetActiveScalars(ShownMeasure);
  both([&](vtkIdType n) { return filled<vtkIntArray>("Continuity", n, static_cast<int>(block.continuity)); });
  both([&](vtkIdType n) { return filled<vtkIntArray>("WorstJoin", n, row); });
}

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
    const int node = assembly->AddNode(nodeName(names[p]).c_str());
    assembly->AddDataSetIndex(node, p);
    assembly->SetAttribute(node, "label", names[p].c_str());
  }
  output->SetDataAssembly(assembly);
}

} // namespace bsv
