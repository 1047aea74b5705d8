// SPDX-License-Identifier: BSD-3-Clause
#include "bezierQuads.h"

#include "vtkBezierQuadrilateral.h"
#include "vtkCellArray.h"
#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkFloatArray.h"
#include "vtkIdList.h"
#include "vtkIdTypeArray.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkUnsignedCharArray.h"
#include "vtkUnstructuredGrid.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

namespace bsv
{

namespace
{

/// Bernstein polynomials of one degree and their derivatives at a parameter.
struct Basis
{
  Basis(int degree, double t)
    : value(degree + 1, 0.0)
    , slope(degree + 1, 0.0)
  {
    this->value[0] = 1.0;
    for (int n = 1; n <= degree; ++n)
    {
      if (n == degree)
      {
        for (int i = 0; i <= degree; ++i)
        {
          this->slope[i] = degree * ((i > 0 ? this->value[i - 1] : 0.0) - (i < degree ? this->value[i] : 0.0));
        }
      }
      for (int i = n; i >= 0; --i)
      {
        this->value[i] = (1.0 - t) * this->value[i] + (i > 0 ? t * this->value[i - 1] : 0.0);
      }
    }
  }

  std::vector<double> value, slope;
};

struct Cell
{
  std::array<int, 2> degree;
  /// Points of the grid, first direction fastest.
  std::vector<vtkIdType> ids;
};

std::array<int, 2> degreesOf(vtkUnstructuredGrid* grid, vtkIdType cell, vtkIdType points)
{
  if (vtkDataArray* degrees = grid->GetCellData()->GetHigherOrderDegrees())
  {
    return { static_cast<int>(degrees->GetComponent(cell, 0)), static_cast<int>(degrees->GetComponent(cell, 1)) };
  }
  const int degree = static_cast<int>(std::lround(std::sqrt(static_cast<double>(points)))) - 1;
  return { degree, degree };
}

Cell cellOf(vtkUnstructuredGrid* grid, vtkIdType id)
{
  vtkNew<vtkIdList> points;
  grid->GetCellPoints(id, points);
  Cell cell{ degreesOf(grid, id, points->GetNumberOfIds()), {} };
  const int order[3] = { cell.degree[0], cell.degree[1], 0 };
  for (int b = 0; b <= order[1]; ++b)
  {
    for (int a = 0; a <= order[0]; ++a)
    {
      cell.ids.push_back(points->GetId(vtkBezierQuadrilateral::PointIndexFromIJK(a, b, order)));
    }
  }
  return cell;
}

/// The place and the two tangents, not of unit length.
std::array<Vec3, 3> surfaceAt(const std::vector<Eigen::Vector4d>& net, const Basis& s, const Basis& t)
{
  Eigen::Vector4d x = Eigen::Vector4d::Zero(), xs = x, xt = x;
  std::size_t n = 0;
  for (std::size_t b = 0; b < t.value.size(); ++b)
  {
    for (std::size_t a = 0; a < s.value.size(); ++a, ++n)
    {
      x += s.value[a] * t.value[b] * net[n];
      xs += s.slope[a] * t.value[b] * net[n];
      xt += s.value[a] * t.slope[b] * net[n];
    }
  }
  const Vec3 place = x.head<3>() / x[3];
  return { place, (xs.head<3>() - xs[3] * place) / x[3], (xt.head<3>() - xt[3] * place) / x[3] };
}

} // namespace

BezierKinds bezierKinds(vtkUnstructuredGrid* grid)
{
  BezierKinds kinds;
  for (vtkIdType cell = 0; cell < grid->GetNumberOfCells(); ++cell)
  {
    if (grid->GetCellType(cell) != VTK_BEZIER_QUADRILATERAL)
    {
      ++kinds.others;
      continue;
    }
    const std::array<int, 2> degree = degreesOf(grid, cell, grid->GetCellSize(cell));
    kinds.degree = std::max({ kinds.degree, degree[0], degree[1] });
  }
  return kinds;
}

vtkSmartPointer<vtkPolyData> bezierQuads(vtkUnstructuredGrid* grid, int parts, const Execution& run)
{
  // Quadrilaterals share no points, since an edge flag belongs to a point and one of its quadrilaterals.
  const vtkIdType cells = grid->GetNumberOfCells();
  const vtkIdType quads = cells * parts * parts;
  vtkNew<vtkPoints> points;
  points->SetNumberOfPoints(4 * quads);
  auto* place = static_cast<float*>(points->GetVoidPointer(0));
  const auto array = [&](auto&& made, const char* name, int components, vtkIdType count) {
    made->SetName(name);
    made->SetNumberOfComponents(components);
    made->SetNumberOfTuples(count);
    return made->GetPointer(0);
  };
  vtkNew<vtkFloatArray> normals;
  vtkNew<vtkUnsignedCharArray> flags;
  vtkNew<vtkIdTypeArray> sourcePoint, sourceCell;
  float* normal = array(normals, "Normals", 3, 4 * quads);
  unsigned char* flag = array(flags, "vtkEdgeFlags", 1, 4 * quads);
  vtkIdType* fromPoint = array(sourcePoint, "SourcePoint", 1, 4 * quads);
  vtkIdType* fromCell = array(sourceCell, "SourceCell", 1, quads);

  vtkDataArray* weights = grid->GetPointData()->GetRationalWeights();
  // Made for all degrees before threads read them.
  std::map<int, std::vector<Basis>> tables;
  for (vtkIdType c = 0; c < cells; ++c)
  {
    for (const int degree : degreesOf(grid, c, grid->GetCellSize(c)))
    {
      std::vector<Basis>& table = tables[degree];
      for (int n = static_cast<int>(table.size()); n <= parts; ++n)
      {
        table.emplace_back(degree, static_cast<double>(n) / parts);
      }
    }
  }
  const auto corner = [&](int quad, int n) {
    return std::array<int, 2>{ quad % parts + (n == 1 || n == 2 ? 1 : 0), quad / parts + (n >= 2 ? 1 : 0) };
  };
  run.parallelFor(cells, 64, [&](Index begin, Index end) {
    std::vector<Eigen::Vector4d> net;
    std::vector<std::array<Vec3, 2>> samples(std::size_t(parts + 1) * (parts + 1));
    for (Index c = begin; c < end; ++c)
    {
      const Cell cell = cellOf(grid, c);
      net.clear();
      for (const vtkIdType id : cell.ids)
      {
        Vec3 x;
        grid->GetPoint(id, x.data());
        const double w = weights ? weights->GetTuple1(id) : 1.0;
        net.emplace_back(w * x[0], w * x[1], w * x[2], w);
      }
      const auto unit = [](const std::array<Vec3, 3>& at) -> Vec3 { return at[1].cross(at[2]).normalized(); };
      for (int t = 0; t <= parts; ++t)
      {
        for (int s = 0; s <= parts; ++s)
        {
          const std::array<Vec3, 3> at = surfaceAt(net, tables.at(cell.degree[0])[s], tables.at(cell.degree[1])[t]);
          Vec3 n = unit(at);
          if (at[1].cross(at[2]).norm() <= 1e-9 * at[1].norm() * at[2].norm() || !(n.norm() > 0.5))
          {
            // A pole: the normal beside it.
            const auto inward = [&](int place) { return 0.999 * place / parts + 0.0005; };
            n = unit(surfaceAt(net, Basis(cell.degree[0], inward(s)), Basis(cell.degree[1], inward(t))));
          }
          samples[s + std::size_t(parts + 1) * t] = { at[0], n };
        }
      }
      for (int quad = 0; quad < parts * parts; ++quad)
      {
        const vtkIdType q = c * parts * parts + quad;
        fromCell[q] = c;
        for (int n = 0; n < 4; ++n)
        {
          const vtkIdType p = 4 * q + n;
          const auto [s, t] = corner(quad, n);
          for (int d = 0; d < 3; ++d)
          {
            place[3 * p + d] = static_cast<float>(samples[s + std::size_t(parts + 1) * t][0][d]);
            normal[3 * p + d] = static_cast<float>(samples[s + std::size_t(parts + 1) * t][1][d]);
          }
          const auto nearest = [&](int at, int degree) { return (2 * at * degree + parts) / (2 * parts); };
          fromPoint[p] = cell.ids[nearest(s, cell.degree[0]) + (cell.degree[0] + 1) * nearest(t, cell.degree[1])];
          // Of the edge that begins there.
          flag[p] = (n == 0 && t == 0) || (n == 1 && s == parts) || (n == 2 && t == parts) || (n == 3 && s == 0);
        }
      }
    }
  });

  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points);
  vtkNew<vtkCellArray> polys;
  vtkNew<vtkIdTypeArray> offsets, connectivity;
  vtkIdType* offset = array(offsets, "", 1, quads + 1);
  vtkIdType* index = array(connectivity, "", 1, 4 * quads);
  for (vtkIdType q = 0; q <= quads; ++q)
  {
    offset[q] = 4 * q;
  }
  for (vtkIdType p = 0; p < 4 * quads; ++p)
  {
    index[p] = p;
  }
  polys->SetData(offsets, connectivity);
  data->SetPolys(polys);

  vtkNew<vtkIdList> from, to;
  from->SetNumberOfIds(quads);
  to->SetNumberOfIds(quads);
  for (vtkIdType q = 0; q < quads; ++q)
  {
    from->SetId(q, fromCell[q]);
    to->SetId(q, q);
  }
  data->GetCellData()->CopyAllocate(grid->GetCellData(), quads);
  data->GetCellData()->CopyData(grid->GetCellData(), from, to);
  data->GetCellData()->AddArray(sourceCell);

  vtkPointData* values = data->GetPointData();
  if (grid->GetPointData()->GetNumberOfArrays() > (weights ? 1 : 0))
  {
    values->InterpolateAllocate(grid->GetPointData(), 4 * quads);
    vtkNew<vtkIdList> ids;
    std::vector<double> share;
    for (vtkIdType p = 0; p < 4 * quads; ++p)
    {
      const vtkIdType c = fromCell[p / 4];
      const Cell cell = cellOf(grid, c);
      const auto [s, t] = corner(static_cast<int>(p / 4 % (parts * parts)), static_cast<int>(p % 4));
      share.clear();
      double sum = 0.0;
      ids->Reset();
      for (const vtkIdType id : cell.ids)
      {
        const std::size_t n = share.size(), row = cell.degree[0] + 1;
        const double w = weights ? weights->GetTuple1(id) : 1.0;
        share.push_back(w * tables.at(cell.degree[0])[s].value[n % row] * tables.at(cell.degree[1])[t].value[n / row]);
        sum += share.back();
        ids->InsertNextId(id);
      }
      for (double& one : share)
      {
        one /= sum;
      }
      values->InterpolatePoint(grid->GetPointData(), p, ids, share.data());
    }
    if (weights)
    {
      values->RemoveArray(weights->GetName());
    }
  }
  values->SetNormals(normals);
  values->AddArray(sourcePoint);
  values->SetAttribute(flags, vtkDataSetAttributes::EDGEFLAG);
  return data;
}

} // namespace bsv
