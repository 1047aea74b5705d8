// SPDX-License-Identifier: BSD-3-Clause
#include "blockPartsModel.h"

#include "Data/BoundaryPatterns.h"
#include "Ranks/SharedBox.h"

#include "vtkCellData.h"
#include "vtkFieldData.h"
#include "vtkIdList.h"
#include "vtkPointData.h"

#include <algorithm>
#include <numeric>

namespace bsv
{

namespace
{

/// Nets get theirs from the representation.
constexpr Color NoColor{ 0, 0, 0 };

/// Of a net with many lines not all: about this many cells per axis are enough to see it.
constexpr int NetLines = 48;
std::vector<int> netIndices(int count)
{
  std::vector<int> indices;
  const int step = 1 + (count - 2) / NetLines;
  for (int n = 0; n < count - 1; n += step)
  {
    indices.push_back(n);
  }
  indices.push_back(count - 1);
  return indices;
}

/// Of all outer faces on all ranks.
std::vector<CoarseFace> gatherCoarse(
  const BlockPartsModel& model, const std::function<CoarseFace(const BlockPartsModel::Face&)>& coarse)
{
  std::vector<std::array<double, 3>> points;
  std::vector<std::array<int, 3>> sizes;
  for (const BlockPartsModel::Face& face : model.faces)
  {
    if (model.isHere(face.block))
    {
      const CoarseFace mine = coarse(face);
      sizes.push_back({ mine.counts[0], mine.counts[1], mine.outward ? 1 : 0 });
      for (const Vec3& x : mine.points)
      {
        points.push_back({ x[0], x[1], x[2] });
      }
    }
  }
  const auto allSizes = model.ranks->gather(sizes);
  const auto allPoints = model.ranks->gather(points);
  std::vector<std::size_t> nextSize(allSizes.size(), 0), nextPoint(allSizes.size(), 0);
  std::vector<CoarseFace> faces;
  for (const BlockPartsModel::Face& face : model.faces)
  {
    const int rank = model.rankOfBlock[face.block];
    const std::array<int, 3>& size = allSizes[rank][nextSize[rank]++];
    faces.push_back({ { size[0], size[1] }, {}, size[2] == 1 });
    for (int n = 0; n < size[0] * size[1]; ++n)
    {
      const std::array<double, 3>& x = allPoints[rank][nextPoint[rank]++];
      faces.back().points.emplace_back(x[0], x[1], x[2]);
    }
  }
  return faces;
}

/// Lines of a face along both directions.
void addNet(LineBuilder& nets, const FacePoints& face, bool all)
{
  for (int axis = 0; axis < 2; ++axis)
  {
    const int across = face.counts[1 - axis];
    std::vector<int> lines = netIndices(across);
    if (all)
    {
      lines.resize(across);
      std::iota(lines.begin(), lines.end(), 0);
    }
    for (const int n : lines)
    {
      std::vector<Vec3> line;
      for (int m = 0; m < face.counts[axis]; ++m)
      {
        const int s = axis == 0 ? m : n;
        const int t = axis == 0 ? n : m;
        line.push_back(face.points[s + std::size_t(face.counts[0]) * t]);
      }
      nets.line(line, NoColor);
    }
  }
}

} // namespace

vtkSmartPointer<vtkDataObject> treeOf(vtkDataObject* input,
  const std::vector<vtkSmartPointer<vtkStructuredGrid>>& grids,
  const std::vector<vtkSmartPointer<vtkPolyData>>& surfaces)
{
  std::map<vtkPoints*, vtkPolyData*> byPoints;
  std::vector<vtkPolyData*> inOrder;
  for (std::size_t b = 0; b < grids.size(); ++b)
  {
    if (grids[b])
    {
      byPoints[grids[b]->GetPoints()] = surfaces[b];
      inOrder.push_back(surfaces[b]);
    }
  }
  auto* tree = vtkDataObjectTree::SafeDownCast(input);
  if (!tree)
  {
    return inOrder.empty() || !inOrder[0] ? vtkSmartPointer<vtkPolyData>::New()
                                          : vtkSmartPointer<vtkPolyData>(inOrder[0]);
  }
  // Points that had to be converted are not those of the leaf: then the order tells.
  std::size_t next = 0;
  return withLeaves(tree, [&](vtkDataObject* leaf) -> vtkSmartPointer<vtkPolyData> {
    auto* grid = vtkStructuredGrid::SafeDownCast(leaf);
    if (!grid || grid->GetNumberOfPoints() == 0)
    {
      return nullptr;
    }
    const auto found = byPoints.find(grid->GetPoints());
    vtkPolyData* surface = found != byPoints.end() ? found->second : next < inOrder.size() ? inOrder[next] : nullptr;
    ++next;
    return surface ? vtkSmartPointer<vtkPolyData>(surface) : vtkSmartPointer<vtkPolyData>::New();
  });
}

/// Told apart also by those who do not see red and green alike, and from the yellow to red of jumps.
Color valenceColor(int valence)
{
  switch (valence)
  {
    case 3:
      return { 0.58, 0.2, 0.75 };
    case 5:
      return { 0.0, 0.45, 0.7 };
    case 6:
      return { 0.8, 0.47, 0.65 };
    default:
      return valence < 3 ? Color{ 0.9, 0.62, 0.0 } : Color{ 0.0, 0.62, 0.45 };
  }
}

void BlockPartsModel::choosePart(const std::function<CoarseFace(const Face&)>& coarse, const Execution& run)
{
  bool wall = false;
  for (Face& face : this->faces)
  {
    const int role = face.tag < 0 || face.tag >= static_cast<int>(this->roles.size()) ? -1 : this->roles[face.tag];
    const auto chosen = [&](const BoundaryPatterns& patterns) {
      return face.tag >= 0 && selectsBoundary(patterns, patterns, this->boundaryNames, this->boundaryTypes, face.tag);
    };
    const bool isWall = role >= 0 ? role == 1 : chosen(defaultBodyBoundaries());
    const bool isSymmetry = role >= 0 ? role == 2 : chosen(defaultSymmetryBoundaries());
    face.part = isWall ? BlockPart::Wall : isSymmetry ? BlockPart::Symmetry : BlockPart::FarField;
    wall = wall || isWall;
  }
  this->wallText = "wall";
  if (wall)
  {
    return;
  }
  // Without names: what surrounds a hole.
  Execution alone = run;
  alone.ranks = aloneRank();
  const std::vector<double> share = enclosure(gatherCoarse(*this, coarse), alone);
  for (std::size_t f = 0; f < this->faces.size(); ++f)
  {
    if (share[f] >= EnclosedShare && this->faces[f].part != BlockPart::Symmetry)
    {
      this->faces[f].part = BlockPart::Wall;
      wall = true;
    }
  }
  this->wallText = "outer faces around a hole";
  if (!wall)
  {
    this->wallText = "outer faces";
    for (Face& face : this->faces)
    {
      face.part = face.part == BlockPart::Symmetry ? BlockPart::Symmetry : BlockPart::Wall;
    }
  }
}

std::vector<int> coarseIndices(int count)
{
  std::vector<int> indices;
  const int parts = std::min(count, CoarseFacePoints) - 1;
  for (int n = 0; n <= parts; ++n)
  {
    indices.push_back(n * (count - 1) / parts);
  }
  return indices;
}

Ijk cornerPoint(const Ijk& last, int corner)
{
  Ijk ijk{};
  for (int d = 0; d < 3; ++d)
  {
    ijk[d] = cornerSide(corner, d) * last[d];
  }
  return ijk;
}

std::vector<int> rolesOf(vtkDataObject* input, const Ranks& ranks)
{
  auto* array = input && input->GetFieldData()
    ? vtkDataArray::SafeDownCast(input->GetFieldData()->GetAbstractArray("BoundaryRoles"))
    : nullptr;
  std::vector<int> mine;
  for (vtkIdType n = 0; array && n < array->GetNumberOfTuples(); ++n)
  {
    mine.push_back(static_cast<int>(array->GetComponent(n, 0)));
  }
  for (const std::vector<int>& list : ranks.gather(mine))
  {
    if (!list.empty())
    {
      return list;
    }
  }
  return {};
}

LineBuilder::LineBuilder(const Eigen::AlignedBox3d& box, double reach)
{
  if (!box.isEmpty() && reach > 0.0)
  {
    this->Center = box.center();
    this->Radius = (0.5 + reach) * box.diagonal().norm();
  }
}

void LineBuilder::line(const std::vector<Vec3>& points, const Color& color)
{
  std::vector<vtkIdType> run;
  const auto end = [&] {
    if (run.size() > 1)
    {
      this->Lines->InsertNextCell(static_cast<vtkIdType>(run.size()), run.data());
      this->LineColors.push_back(color);
    }
    run.clear();
  };
  for (const Vec3& x : points)
  {
    if (this->isFar(x))
    {
      end();
      continue;
    }
    run.push_back(this->Points->InsertNextPoint(x.data()));
  }
  end();
}

void LineBuilder::node(const Vec3& x, const Color& color)
{
  if (!this->isFar(x))
  {
    this->Verts->InsertNextCell({ this->Points->InsertNextPoint(x.data()) });
    this->NodeColors.push_back(color);
  }
}

std::vector<Color> LineBuilder::colors() const
{
  // Cells of a vtkPolyData: vertices first.
  std::vector<Color> all = this->NodeColors;
  all.insert(all.end(), this->LineColors.begin(), this->LineColors.end());
  return all;
}

vtkSmartPointer<vtkPolyData> LineBuilder::build()
{
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(this->Points);
  data->SetVerts(this->Verts);
  data->SetLines(this->Lines);
  vtkNew<vtkUnsignedCharArray> colors;
  colors->SetName("Colors");
  colors->SetNumberOfComponents(3);
  for (const Color& color : this->colors())
  {
    colors->InsertNextTuple3(255 * color[0], 255 * color[1], 255 * color[2]);
  }
  data->GetCellData()->AddArray(colors);
  return data;
}

SurfaceBuilder::SurfaceBuilder()
{
  this->Points->SetDataTypeToDouble();
  this->Normals->SetName("Normals");
  this->Normals->SetNumberOfComponents(3);
  this->Mean->SetName("MeanCurvature");
  this->Gaussian->SetName("GaussianCurvature");
  this->Boundary->SetName("Boundary");
  this->SourcePoint->SetName("SourcePoint");
  this->SourceCell->SetName("SourceCell");
}

void SurfaceBuilder::surface(const FacePoints& face, const std::vector<Vec3>& normals, int tag,
  const std::function<vtkIdType(int s, int t, bool cell)>& source)
{
  const auto [ns, nt] = face.counts;
  const vtkIdType first = this->Points->GetNumberOfPoints();
  for (int t = 0; t < nt; ++t)
  {
    for (int s = 0; s < ns; ++s)
    {
      const std::size_t n = s + std::size_t(ns) * t;
      this->Points->InsertNextPoint(face.points[n].data());
      this->Normals->InsertNextTuple(normals[n].data());
      this->SourcePoint->InsertNextValue(source(s, t, false));
    }
  }
  const bool against = this->windsAgainstNormals(first, ns, nt);
  for (int t = 0; t + 1 < nt; ++t)
  {
    for (int s = 0; s + 1 < ns; ++s)
    {
      const vtkIdType cell = source(s, t, true);
      if (cell < 0)
      {
        continue;
      }
      const vtkIdType p = first + s + vtkIdType(ns) * t;
      const vtkIdType second = against ? p + ns : p + 1;
      const vtkIdType fourth = against ? p + 1 : p + ns;
      this->Quads->InsertNextCell({ p, second, p + 1 + ns, fourth });
      this->Boundary->InsertNextValue(tag);
      this->SourceCell->InsertNextValue(cell);
    }
  }
}

void SurfaceBuilder::curvatures(const std::vector<double>& mean, const std::vector<double>& gaussian)
{
  for (std::size_t n = 0; n < mean.size(); ++n)
  {
    this->Mean->InsertNextValue(static_cast<float>(mean[n]));
    this->Gaussian->InsertNextValue(static_cast<float>(gaussian[n]));
  }
}

vtkSmartPointer<vtkPolyData> SurfaceBuilder::build(vtkStructuredGrid* grid, bool normals)
{
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(this->Points);
  data->SetPolys(this->Quads);
  const auto takeAlong = [](vtkDataSetAttributes* from, vtkIdTypeArray* ids, vtkDataSetAttributes* to) {
    to->CopyAllOn();
    to->CopyAllocate(from, ids->GetNumberOfValues());
    vtkNew<vtkIdList> source, place;
    source->SetNumberOfIds(ids->GetNumberOfValues());
    place->SetNumberOfIds(ids->GetNumberOfValues());
    for (vtkIdType n = 0; n < ids->GetNumberOfValues(); ++n)
    {
      source->SetId(n, ids->GetValue(n));
      place->SetId(n, n);
    }
    to->CopyData(from, source, place);
  };
  takeAlong(grid->GetPointData(), this->SourcePoint, data->GetPointData());
  takeAlong(grid->GetCellData(), this->SourceCell, data->GetCellData());
  if (normals)
  {
    data->GetPointData()->SetNormals(this->Normals);
  }
  data->GetPointData()->AddArray(this->SourcePoint);
  if (this->Mean->GetNumberOfValues() > 0)
  {
    data->GetPointData()->AddArray(this->Mean);
    data->GetPointData()->AddArray(this->Gaussian);
  }
  data->GetCellData()->AddArray(this->Boundary);
  data->GetCellData()->AddArray(this->SourceCell);
  return data;
}

/// The sign of most of the structured surface's area along the normals.
bool SurfaceBuilder::windsAgainstNormals(vtkIdType first, int ns, int nt) const
{
  const auto point = [&](vtkIdType id) {
    Vec3 x;
    this->Points->GetPoint(id, x.data());
    return x;
  };
  double along = 0.0;
  for (int t = 0; t + 1 < nt; ++t)
  {
    for (int s = 0; s + 1 < ns; ++s)
    {
      const vtkIdType p = first + s + vtkIdType(ns) * t;
      Vec3 normal;
      this->Normals->GetTuple(p, normal.data());
      along += (point(p + 1 + ns) - point(p)).cross(point(p + ns) - point(p + 1)).dot(normal);
    }
  }
  return along < 0.0;
}

void buildParts(BlockParts& parts, vtkDataObject* input, const BlockPartsOptions& options, const BlockPartsModel& model,
  BlockPartsShape& shape)
{
  std::vector<vtkSmartPointer<vtkPolyData>> surfaces(shape.grids.size());
  for (auto& [block, builder] : shape.wall)
  {
    surfaces[block] = builder.build(shape.grids[block], shape.wallNormals);
  }
  const Eigen::AlignedBox3d box = sharedBox(shape.box, *model.ranks);
  parts.surfaces = treeOf(input, shape.grids, surfaces);

  LineBuilder nets(box, options.reach), curves(box, options.reach);
  for (const BlockPartsModel::Face& face : model.faces)
  {
    const bool shown = face.part == BlockPart::Wall ? options.wallNet && parts.isVolume
      : face.part == BlockPart::Symmetry            ? options.symmetryNet
                                                    : options.farFieldNet;
    if (shown && model.isHere(face.block))
    {
      addNet(nets, shape.net(face), face.part == BlockPart::Wall);
    }
  }
  for (const auto& [block, edge] : model.innerEdges)
  {
    if (options.blockEdges && model.isHere(block))
    {
      nets.line(shape.edge(block, edge), NoColor);
    }
  }
  for (const BlockPartsModel::Curve& curve : model.curves)
  {
    if (model.isHere(curve.block) && (curve.color == CreaseColor ? options.creases : options.extraordinaryCurves))
    {
      curves.line(curve.points.empty() ? shape.edge(curve.block, curve.edge) : curve.points, curve.color);
    }
  }
  for (const BlockPartsModel::Node& node : model.nodes)
  {
    if (model.isHere(node.block) && options.extraordinaryCurves)
    {
      curves.node(shape.corner(node), NodeColor);
    }
  }
  parts.nets = nets.build();
  parts.curves = curves.build();
  parts.legend = legendOf(model, curves.colors(), options);
  parts.wallText = model.wallText;
}

std::vector<BlockParts::Entry> legendOf(
  const BlockPartsModel& model, const std::vector<Color>& drawn, const BlockPartsOptions& options)
{
  std::vector<BlockParts::Entry> all, legend;
  for (const auto& [valence, count] : model.valences)
  {
    all.push_back({ std::to_string(valence) + " blocks meet", valenceColor(valence) });
  }
  all.push_back({ "singular node", NodeColor });
  all.push_back({ "crease", CreaseColor });
  if (options.blockEdges)
  {
    legend.push_back({ "block edge", BlockEdgeColor });
  }
  for (const BlockParts::Entry& entry : all)
  {
    if (model.ranks->any(std::find(drawn.begin(), drawn.end(), entry.color) != drawn.end()))
    {
      legend.push_back(entry);
    }
  }
  return legend;
}

} // namespace bsv
