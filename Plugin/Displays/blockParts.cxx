// SPDX-License-Identifier: BSD-3-Clause
#include "blockParts.h"

#include "Complex/BlockComplex.h"
#include "Complex/EntityClass.h"
#include "Data/BSplineVolumeData.h"
#include "Data/BoundaryPatterns.h"
#include "Data/HexBlockData.h"
#include "Mesh/Enclosure.h"
#include "Mesh/SharedEntities.h"
#include "Ranks/Ranks.h"
#include "Ranks/SharedBox.h"
#include "Volume/ControlPointRule.h"
#include "Volume/FaceGeometry.h"
#include "Volume/VolumeInterfaces.h"
#include "Volume/VolumeParts.h"

#include "vtkCellArray.h"
#include "vtkCellData.h"
#include "vtkDataObjectTree.h"
#include "vtkDataObjectTreeIterator.h"
#include "vtkFieldData.h"
#include "vtkFloatArray.h"
#include "vtkIdList.h"
#include "vtkIdTypeArray.h"
#include "vtkIntArray.h"
#include "vtkNew.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"
#include "vtkStringArray.h"
#include "vtkStructuredGrid.h"
#include "vtkUnsignedCharArray.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace bsv
{

namespace
{

constexpr std::array<double, 3> CreaseColor{ 0.05, 0.05, 0.05 };
constexpr std::array<double, 3> NodeColor{ 0.95, 0.85, 0.1 };
/// That of all nets: vtkBlockPartsRepresentation.cxx.
constexpr std::array<double, 3> BlockEdgeColor{ 0.52, 0.55, 0.62 };

/// Told apart also by those who do not see red and green alike, and from the yellow to red of jumps.
std::array<double, 3> valenceColor(int valence)
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
      return valence < 3 ? std::array<double, 3>{ 0.9, 0.62, 0.0 } : std::array<double, 3>{ 0.0, 0.62, 0.45 };
  }
}

enum class Part
{
  Inner,
  Wall,
  Symmetry,
  FarField
};

/// A block face of a mesh or volume, whichever it is.
struct Face
{
  int block;
  int face;
  /// Index into the boundary names, or -1.
  int tag;
  Part part = Part::FarField;
};

struct Curve
{
  int block;
  int edge;
  std::array<double, 3> color;
  /// Empty: those of the edge.
  std::vector<Vec3> points;
};

struct Node
{
  int block;
  int corner;
};

/// What meshes and volumes have in common.
struct Model
{
  const Ranks* ranks = nullptr;
  std::vector<int> rankOfBlock;
  std::vector<Face> faces;
  std::vector<std::array<int, 2>> innerEdges; ///< block and edge
  std::vector<Curve> curves;
  std::vector<Node> nodes;
  std::vector<std::string> boundaryNames;
  std::vector<std::string> boundaryTypes;
  /// Roles of the boundaries as a conversion took them (BSplineVolumeData.h), or empty.
  std::vector<int> roles;
  std::map<int, int> valences; ///< extraordinary edges per valence
  std::string wallText;

  bool isHere(int block) const { return this->rankOfBlock[block] == this->ranks->rank(); }
};

/// Chooses the wall. @param coarse a face as few points; only called for those that are here
template <typename Coarse>
void choosePart(Model& model, const Coarse& coarse, const Execution& run)
{
  bool wall = false;
  for (Face& face : model.faces)
  {
    const int role = face.tag < 0 || face.tag >= static_cast<int>(model.roles.size()) ? -1 : model.roles[face.tag];
    const auto chosen = [&](const BoundaryPatterns& patterns) {
      return face.tag >= 0 && selectsBoundary(patterns, patterns, model.boundaryNames, model.boundaryTypes, face.tag);
    };
    const bool isWall = role >= 0 ? role == 1 : chosen(defaultBodyBoundaries());
    const bool isSymmetry = role >= 0 ? role == 2 : chosen(defaultSymmetryBoundaries());
    face.part = isWall ? Part::Wall : isSymmetry ? Part::Symmetry : Part::FarField;
    wall = wall || isWall;
  }
  model.wallText = "wall";
  if (wall)
  {
    return;
  }
  // Without names: what surrounds a hole.
  std::vector<std::array<double, 3>> points;
  std::vector<std::array<int, 3>> sizes;
  for (const Face& face : model.faces)
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
  for (const Face& face : model.faces)
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
  std::vector<double> share;
  Execution alone = run;
  alone.ranks = aloneRank();
  share = enclosure(faces, alone);
  for (std::size_t f = 0; f < faces.size(); ++f)
  {
    if (share[f] >= EnclosedShare && model.faces[f].part != Part::Symmetry)
    {
      model.faces[f].part = Part::Wall;
      wall = true;
    }
  }
  model.wallText = "outer faces around a hole";
  if (!wall)
  {
    model.wallText = "outer faces";
    for (Face& face : model.faces)
    {
      face.part = face.part == Part::Symmetry ? Part::Symmetry : Part::Wall;
    }
  }
}

/// At most CoarseFacePoints of `count` indices 0..count - 1, the ends among them.
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

/// Lines within a distance of the wall.
class LineBuilder
{
public:
  LineBuilder() { this->Colors->SetNumberOfComponents(3); }

  void limit(const Eigen::AlignedBox3d& box, double reach)
  {
    if (!box.isEmpty() && reach > 0.0)
    {
      this->Center = box.center();
      this->Radius = (0.5 + reach) * box.diagonal().norm();
    }
  }

  void line(const std::vector<Vec3>& points, const std::array<double, 3>& color)
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
      if (this->Radius > 0.0 && (x - this->Center).norm() > this->Radius)
      {
        end();
        continue;
      }
      run.push_back(this->Points->InsertNextPoint(x.data()));
    }
    end();
  }

  void node(const Vec3& x, const std::array<double, 3>& color)
  {
    if (this->Radius > 0.0 && (x - this->Center).norm() > this->Radius)
    {
      return;
    }
    this->Verts->InsertNextCell({ this->Points->InsertNextPoint(x.data()) });
    this->NodeColors.push_back(color);
  }

  /// Of all that is in reach.
  std::vector<std::array<double, 3>> colors() const
  {
    std::vector<std::array<double, 3>> all = this->NodeColors;
    all.insert(all.end(), this->LineColors.begin(), this->LineColors.end());
    return all;
  }

  vtkSmartPointer<vtkPolyData> build()
  {
    auto data = vtkSmartPointer<vtkPolyData>::New();
    data->SetPoints(this->Points);
    data->SetVerts(this->Verts);
    data->SetLines(this->Lines);
    this->Colors->SetName("Colors");
    // Cells of a vtkPolyData: vertices first.
    for (const auto* list : { &this->NodeColors, &this->LineColors })
    {
      for (const std::array<double, 3>& color : *list)
      {
        this->Colors->InsertNextTuple3(255 * color[0], 255 * color[1], 255 * color[2]);
      }
    }
    data->GetCellData()->AddArray(this->Colors);
    return data;
  }

private:
  Vec3 Center = Vec3::Zero();
  double Radius = 0.0;
  vtkNew<vtkPoints> Points;
  vtkNew<vtkCellArray> Verts, Lines;
  vtkNew<vtkUnsignedCharArray> Colors;
  std::vector<std::array<double, 3>> LineColors, NodeColors;
};

/// The surfaces of one block.
class SurfaceBuilder
{
public:
  SurfaceBuilder()
  {
    this->Points->SetDataTypeToDouble();
    this->Normals->SetName("Normals");
    this->Normals->SetNumberOfComponents(3);
    this->Boundary->SetName("Boundary");
    this->SourcePoint->SetName("SourcePoint");
    this->SourceCell->SetName("SourceCell");
  }

  void curvatures()
  {
    this->Mean = vtkSmartPointer<vtkFloatArray>::New();
    this->Mean->SetName("MeanCurvature");
    this->Gaussian = vtkSmartPointer<vtkFloatArray>::New();
    this->Gaussian->SetName("GaussianCurvature");
  }

  void point(const Vec3& x, const Vec3& normal, vtkIdType source)
  {
    this->Points->InsertNextPoint(x.data());
    this->Normals->InsertNextTuple(normal.data());
    this->SourcePoint->InsertNextValue(source);
  }
  void curvature(double mean, double gaussian)
  {
    this->Mean->InsertNextValue(static_cast<float>(mean));
    this->Gaussian->InsertNextValue(static_cast<float>(gaussian));
  }

  /// Quadrilaterals of the last ns x nt points, counterclockwise around the normals: else the light comes from behind.
  /// @param cell cell of the input at (s, t)
  template <typename Cell>
  void quads(int ns, int nt, int tag, const Cell& cell)
  {
    const vtkIdType first = this->Points->GetNumberOfPoints() - vtkIdType(ns) * nt;
    const bool against = this->windsAgainstNormals(first, ns, nt);
    for (int t = 0; t + 1 < nt; ++t)
    {
      for (int s = 0; s + 1 < ns; ++s)
      {
        const vtkIdType source = cell(s, t);
        if (source < 0)
        {
          continue;
        }
        const vtkIdType p = first + s + vtkIdType(ns) * t;
        if (against)
        {
          this->Quads->InsertNextCell({ p, p + ns, p + 1 + ns, p + 1 });
        }
        else
        {
          this->Quads->InsertNextCell({ p, p + 1, p + 1 + ns, p + ns });
        }
        this->Boundary->InsertNextValue(tag);
        this->SourceCell->InsertNextValue(source);
      }
    }
  }

  /// @param grid whose arrays are taken along
  vtkSmartPointer<vtkPolyData> build(vtkStructuredGrid* grid, bool normals)
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
    if (this->Mean)
    {
      data->GetPointData()->AddArray(this->Mean);
      data->GetPointData()->AddArray(this->Gaussian);
    }
    data->GetCellData()->AddArray(this->Boundary);
    data->GetCellData()->AddArray(this->SourceCell);
    return data;
  }

private:
  /// The sign of most of the structured surface's area along the normals.
  bool windsAgainstNormals(vtkIdType first, int ns, int nt) const
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

  vtkNew<vtkPoints> Points;
  vtkNew<vtkFloatArray> Normals;
  vtkNew<vtkCellArray> Quads;
  vtkNew<vtkIntArray> Boundary;
  vtkNew<vtkIdTypeArray> SourcePoint, SourceCell;
  vtkSmartPointer<vtkFloatArray> Mean, Gaussian;
};

/// Normals of a structured surface, into the block: differences over two points, at borders parabolas through three.
std::vector<Vec3> meshNormals(const std::vector<Vec3>& x, int ns, int nt, bool outward)
{
  const auto tangent = [&](int at, int count, Index place, Index step) -> Vec3 {
    if (count < 3)
    {
      return at == 0 ? x[place + step] - x[place] : x[place] - x[place - step];
    }
    if (at == 0)
    {
      return -3.0 * x[place] + 4.0 * x[place + step] - x[place + 2 * step];
    }
    if (at == count - 1)
    {
      return 3.0 * x[place] - 4.0 * x[place - step] + x[place - 2 * step];
    }
    return x[place + step] - x[place - step];
  };
  std::vector<Vec3> normals(x.size());
  Vec3 any = Vec3::UnitZ();
  for (int t = 0; t < nt; ++t)
  {
    for (int s = 0; s < ns; ++s)
    {
      const Index place = s + Index(ns) * t;
      const Vec3 normal = tangent(s, ns, place, 1).cross(tangent(t, nt, place, ns));
      const double length = normal.norm();
      if (length > 0.0)
      {
        any = normal / (outward ? -length : length);
      }
      normals[place] = any;
    }
  }
  return normals;
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

/// Whether the first block that is here has knots; on all ranks.
bool isVolume(vtkDataObject* input, const Ranks& ranks)
{
  bool here = false;
  const auto look = [&](vtkDataObject* leaf) {
    here = here || (leaf && leaf->GetFieldData()->HasArray("KnotsU") && leaf->GetFieldData()->HasArray("KnotsW"));
  };
  if (auto* tree = vtkDataObjectTree::SafeDownCast(input))
  {
    auto leaves = vtkSmartPointer<vtkDataObjectTreeIterator>::Take(tree->NewTreeIterator());
    leaves->VisitOnlyLeavesOn();
    leaves->TraverseSubTreeOn();
    for (leaves->InitTraversal(); !leaves->IsDoneWithTraversal() && !here; leaves->GoToNextItem())
    {
      look(leaves->GetCurrentDataObject());
    }
  }
  else
  {
    look(input);
  }
  return ranks.any(here);
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

/// A tree like the input's with surfaces in place of blocks. @param grids per block, null for those elsewhere
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

//------------------------------------------------------------------------------
// Meshes
//------------------------------------------------------------------------------

/// Every block whole, and every face that is in no interface outside: of a mesh that does not fit together.
BlockComplex looseBlocks(const BlockMesh& mesh)
{
  BlockComplex complex;
  complex.boundaryNames = mesh.boundaryNames;
  complex.boundaryTypes = mesh.boundaryTypes;
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b)
  {
    ComplexBlock block;
    block.points = mesh.blocks[b].points;
    block.rank = mesh.blocks[b].rank;
    block.parent = static_cast<int>(b);
    complex.blocks.push_back(block);
    for (int face = 0; face < 6; ++face)
    {
      const auto meets = [&](const Interface& contact) {
        return (contact.blockA == int(b) && contact.faceA == face) ||
          (contact.blockB == int(b) && contact.faceB == face);
      };
      if (std::any_of(mesh.interfaces.begin(), mesh.interfaces.end(), meets))
      {
        continue;
      }
      ComplexFace one;
      one.uses = { { int(b), face } };
      for (const BoundaryPatch& patch : mesh.boundaries)
      {
        one.tag = patch.block == int(b) && patch.face == face ? patch.tag : one.tag;
      }
      complex.faces.push_back(one);
    }
  }
  return complex;
}

Model meshModel(const BlockComplex& complex, const Ranks& ranks)
{
  Model model;
  model.ranks = &ranks;
  for (const ComplexBlock& block : complex.blocks)
  {
    model.rankOfBlock.push_back(block.rank);
  }
  model.boundaryNames = complex.boundaryNames;
  model.boundaryTypes = complex.boundaryTypes;
  for (const ComplexFace& face : complex.faces)
  {
    if (face.boundary())
    {
      model.faces.push_back({ face.uses.front().block, face.uses.front().face, face.tag });
    }
  }
  for (const ComplexEdge& edge : complex.edges)
  {
    const EdgeUse& use = edge.uses.front();
    model.innerEdges.push_back({ use.block, use.edge });
    if (edge.extraordinary())
    {
      model.curves.push_back({ use.block, use.edge, valenceColor(edge.valence()), {} });
      ++model.valences[edge.valence()];
    }
    else if (edge.crease)
    {
      model.curves.push_back({ use.block, use.edge, CreaseColor, {} });
    }
  }
  const EntityClasses classes = classifyEntities(complex);
  for (std::size_t v = 0; v < complex.vertices.size(); ++v)
  {
    if (classes.vertices[v] == EntityClass::Singular)
    {
      const CornerUse& use = complex.vertices[v].corners.front();
      model.nodes.push_back({ use.block, use.corner });
    }
  }
  return model;
}

//------------------------------------------------------------------------------
// Volumes
//------------------------------------------------------------------------------

/// Whether the control points of an edge of a part of a block, without its ends, are all made by crease or corner
/// rules.
bool taggedCrease(const BSplineVolumeBlocks& input, const VolumeParts& parts, int part, int edge)
{
  const unsigned char* rules = input.rules[parts.blocks[part]];
  if (!rules)
  {
    return false;
  }
  const BSplineVolume &volume = parts.volumes[part], &whole = input.volumes[parts.blocks[part]];
  const Ijk& first = parts.first[part];
  const int along = edgeDirection(edge);
  Ijk ijk = cornerPoint({ volume.count(0) - 1, volume.count(1) - 1, volume.count(2) - 1 }, edgeCorner(edge, 0));
  for (int n = 1; n + 1 < volume.count(along); ++n)
  {
    ijk[along] = n;
    const unsigned char rule = rules[first[0] + ijk[0] +
      Index(whole.count(0)) * (first[1] + ijk[1] + Index(whole.count(1)) * (first[2] + ijk[2]))];
    if (rule != static_cast<unsigned char>(ControlPointRule::Crease) &&
      rule != static_cast<unsigned char>(ControlPointRule::Corner))
    {
      return false;
    }
  }
  return true;
}

Model volumeModel(const BSplineVolumeBlocks& input, const SharedEntities& shared, const Ranks& ranks)
{
  Model model;
  model.ranks = &ranks;
  model.rankOfBlock = input.ranks;
  model.boundaryNames = input.boundaryNames;
  model.boundaryTypes = input.boundaryTypes;
  std::vector<int> tags(6 * input.volumes.size(), -1);
  for (const BoundaryPatch& patch : input.boundaries)
  {
    tags[6 * std::size_t(patch.block) + patch.face] = patch.tag;
  }
  for (const SharedEntities::Face& face : shared.faces)
  {
    if (face.uses == 1)
    {
      model.faces.push_back({ face.block, face.face, tags[6 * std::size_t(face.block) + face.face] });
    }
  }
  std::vector<int> curvesAt(shared.vertices, 0);
  std::vector<char> outer(shared.vertices, 0);
  for (const SharedEntities::Edge& edge : shared.edges)
  {
    model.innerEdges.push_back({ edge.block, edge.edge });
    for (const int vertex : edge.vertices)
    {
      outer[vertex] = outer[vertex] || edge.boundary;
    }
    if (!edge.boundary && edge.uses != 4)
    {
      model.curves.push_back({ edge.block, edge.edge, valenceColor(edge.uses), {} });
      ++model.valences[edge.uses];
      ++curvesAt[edge.vertices[0]];
      ++curvesAt[edge.vertices[1]];
    }
  }
  for (std::size_t b = 0; b < shared.blocks.size(); ++b)
  {
    for (int corner = 0; corner < 8; ++corner)
    {
      const int vertex = shared.blocks[b].vertices[corner];
      if (!outer[vertex] && curvesAt[vertex] > 2)
      {
        model.nodes.push_back({ static_cast<int>(b), corner });
        curvesAt[vertex] = 0;
      }
    }
  }
  return model;
}

std::vector<Vec3> edgeCurve(const BSplineVolume& volume, int edge, int parts)
{
  const int along = edgeDirection(edge);
  Vec3 uvw;
  for (int d = 0; d < 3; ++d)
  {
    const std::vector<double>& knots = volume.knots[d];
    const int side = cornerSide(edgeCorner(edge, 0), d);
    uvw[d] = side == 0 ? knots[volume.degree[d]] : knots[knots.size() - 1 - volume.degree[d]];
  }
  std::vector<Vec3> points;
  const std::vector<double>& knots = volume.knots[along];
  for (const int span : nonEmptySpans(volume.degree[along], knots))
  {
    for (int j = points.empty() ? 0 : 1; j <= parts; ++j)
    {
      uvw[along] = knots[span] + (knots[span + 1] - knots[span]) * j / parts;
      points.push_back(evaluate(volume, uvw));
    }
  }
  return points;
}

/// Creases: edges between two faces of the wall, once the wall is known; repeated knots make edges inside blocks.
void addVolumeCreases(Model& model, const BSplineVolumeBlocks& input, const std::vector<Interface>& interfaces)
{
  const VolumeParts parts = cutAtRepeatedKnots(input.volumes, interfaces);
  const SharedEntities shared = sharedEntities(static_cast<int>(parts.volumes.size()), parts.interfaces);
  std::vector<char> isWall(6 * input.volumes.size(), 0);
  for (const Face& face : model.faces)
  {
    isWall[6 * std::size_t(face.block) + face.face] = face.part == Part::Wall;
  }
  std::vector<int> wallFaces(shared.edges.size(), 0);
  for (const SharedEntities::Face& face : shared.faces)
  {
    for (int n = 0; n < 4 && face.uses == 1 && isWall[6 * std::size_t(parts.blocks[face.block]) + face.face]; ++n)
    {
      ++wallFaces[shared.blocks[face.block].edges[faceEdge(face.face, n & 1, n >> 1)]];
    }
  }
  for (std::size_t e = 0; e < shared.edges.size(); ++e)
  {
    const SharedEntities::Edge& edge = shared.edges[e];
    const int block = parts.blocks[edge.block];
    if (edge.boundary && wallFaces[e] > 1 && model.isHere(block) && taggedCrease(input, parts, edge.block, edge.edge))
    {
      model.curves.push_back({ block, edge.edge, CreaseColor, edgeCurve(parts.volumes[edge.block], edge.edge, 4) });
    }
  }
}

/// Parts per span that keep the surface small enough to be shown as fast as the mesh it came from.
int automaticSubdivision(Index spans)
{
  return spans > 60000 ? 1 : spans > 15000 ? 2 : 4;
}

/// What of the curves is in reach. Collective.
std::vector<BlockParts::Entry> legendOf(
  const Model& model, const std::vector<std::array<double, 3>>& drawn, const BlockPartsOptions& options)
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

/// Everything but the surfaces. @param grid points of a face that is here, at its net; @param curve points of an edge
template <typename FacePoints, typename EdgePoints, typename CornerAt>
std::vector<std::array<double, 3>> buildLines(BlockParts& parts, const Model& model, const BlockPartsOptions& options,
  const Eigen::AlignedBox3d& wallBox, bool wallNet, const FacePoints& facePoints, const EdgePoints& edgePoints,
  const CornerAt& cornerAt)
{
  LineBuilder nets, curves;
  nets.limit(wallBox, options.reach);
  curves.limit(wallBox, options.reach);
  constexpr std::array<double, 3> none{ 0, 0, 0 };
  for (const Face& face : model.faces)
  {
    const bool shown = face.part == Part::Wall ? options.wallNet && wallNet
      : face.part == Part::Symmetry            ? options.symmetryNet
                                               : options.farFieldNet;
    if (!shown || !model.isHere(face.block))
    {
      continue;
    }
    std::array<int, 2> counts;
    const std::vector<Vec3> points = facePoints(face, counts);
    const bool all = face.part == Part::Wall;
    for (int axis = 0; axis < 2; ++axis)
    {
      const int across = counts[1 - axis];
      std::vector<int> lines = netIndices(across);
      if (all)
      {
        lines.resize(across);
        std::iota(lines.begin(), lines.end(), 0);
      }
      for (const int n : lines)
      {
        std::vector<Vec3> line;
        for (int m = 0; m < counts[axis]; ++m)
        {
          const int s = axis == 0 ? m : n;
          const int t = axis == 0 ? n : m;
          line.push_back(points[s + std::size_t(counts[0]) * t]);
        }
        nets.line(line, none);
      }
    }
  }
  for (const auto& [block, edge] : model.innerEdges)
  {
    if (options.blockEdges && model.isHere(block))
    {
      nets.line(edgePoints(block, edge), none);
    }
  }
  for (const Curve& curve : model.curves)
  {
    if (model.isHere(curve.block) && (curve.color == CreaseColor ? options.creases : options.extraordinaryCurves))
    {
      curves.line(curve.points.empty() ? edgePoints(curve.block, curve.edge) : curve.points, curve.color);
    }
  }
  for (const Node& node : model.nodes)
  {
    if (model.isHere(node.block) && options.extraordinaryCurves)
    {
      curves.node(cornerAt(node), NodeColor);
    }
  }
  parts.nets = nets.build();
  parts.curves = curves.build();
  return curves.colors();
}

void meshParts(BlockParts& parts, vtkDataObject* input, const BlockPartsOptions& options, const Execution& run)
{
  const Ranks& ranks = *run.ranks;
  std::vector<vtkSmartPointer<vtkStructuredGrid>> grids;
  const BlockMesh mesh = blockMesh(input, grids, run);
  if (mesh.blocks.empty())
  {
    return;
  }
  BlockComplex complex;
  try
  {
    BlockComplexOptions gluing;
    gluing.allowDegenerate = true;
    ranks.together([&] { complex = buildBlockComplex(mesh, gluing, run); });
  }
  catch (const Aborted&)
  {
    throw;
  }
  catch (const Error&)
  {
    complex = looseBlocks(mesh);
  }
  Model model = meshModel(complex, ranks);
  model.roles = rolesOf(input, ranks);
  const auto cellsOf = [&](int b) {
    const ComplexBlock& block = complex.blocks[b];
    return Ijk{ block.cells(0), block.cells(1), block.cells(2) };
  };
  const auto isOutward = [&](const Face& face) {
    return ((faceDirection(face.face) == 1) != (faceSide(face.face) == 1)) != complex.blocks[face.block].leftHanded;
  };
  const auto layerPoint = [&](const Face& face, int s, int t, int layer) {
    const Ijk cells = cellsOf(face.block);
    Ijk ijk = facePoint(cells, face.face, s, t);
    const int across = faceDirection(face.face);
    const int depth = std::min(layer, cells[across]);
    ijk[across] += faceSide(face.face) == 0 ? depth : -depth;
    return ijk;
  };
  const auto at = [&](const Face& face, int s, int t) {
    return complex.blocks[face.block].points(layerPoint(face, s, t, 0));
  };
  choosePart(
    model,
    [&](const Face& face) {
      const Ijk cells = cellsOf(face.block);
      const std::vector<int> is = coarseIndices(cells[faceAxis(face.face, 0)] + 1);
      const std::vector<int> it = coarseIndices(cells[faceAxis(face.face, 1)] + 1);
      CoarseFace coarse{ { int(is.size()), int(it.size()) }, {}, isOutward(face) };
      for (const int t : it)
      {
        for (const int s : is)
        {
          coarse.points.push_back(at(face, s, t));
        }
      }
      return coarse;
    },
    run);

  std::vector<vtkSmartPointer<vtkPolyData>> surfaces(grids.size());
  Eigen::AlignedBox3d box;
  std::map<int, SurfaceBuilder> builders;
  for (const Face& face : model.faces)
  {
    const ComplexBlock& block = complex.blocks[face.block];
    if (face.part != Part::Wall || !model.isHere(face.block))
    {
      continue;
    }
    const Ijk cells = cellsOf(face.block);
    const int ns = cells[faceAxis(face.face, 0)] + 1, nt = cells[faceAxis(face.face, 1)] + 1;
    std::vector<Vec3> points;
    points.reserve(std::size_t(ns) * nt);
    for (int t = 0; t < nt; ++t)
    {
      for (int s = 0; s < ns; ++s)
      {
        points.push_back(block.points(layerPoint(face, s, t, options.layer)));
        box.extend(points.back());
      }
    }
    if (!options.wall)
    {
      continue;
    }
    const std::vector<Vec3> normals = meshNormals(points, ns, nt, isOutward(face));
    SurfaceBuilder& builder = builders[block.parent];
    const std::array<int, 3>& whole = mesh.blocks[block.parent].points.counts();
    const auto source = [&](int s, int t, bool cell) {
      Ijk ijk = layerPoint(face, s, t, options.layer);
      for (int d = 0; d < 3; ++d)
      {
        ijk[d] = block.offset[d] + (cell ? std::min(ijk[d], cells[d] - 1) : ijk[d]);
      }
      const int less = cell ? 1 : 0;
      return ijk[0] + vtkIdType(whole[0] - less) * (ijk[1] + vtkIdType(whole[1] - less) * ijk[2]);
    };
    for (int t = 0; t < nt; ++t)
    {
      for (int s = 0; s < ns; ++s)
      {
        const std::size_t n = s + std::size_t(ns) * t;
        builder.point(points[n], normals[n], source(s, t, false));
      }
    }
    builder.quads(ns, nt, face.tag, [&](int s, int t) { return source(s, t, true); });
  }
  for (auto& [block, builder] : builders)
  {
    surfaces[block] = builder.build(grids[block], options.meshNormals);
  }
  box = sharedBox(box, ranks);
  parts.surfaces = treeOf(input, grids, surfaces);
  std::vector<std::array<double, 3>> drawn;
  drawn = buildLines(
    parts, model, options, box, false,
    [&](const Face& face, std::array<int, 2>& counts) {
      const Ijk cells = cellsOf(face.block);
      counts = { cells[faceAxis(face.face, 0)] + 1, cells[faceAxis(face.face, 1)] + 1 };
      std::vector<Vec3> points;
      for (int t = 0; t < counts[1]; ++t)
      {
        for (int s = 0; s < counts[0]; ++s)
        {
          points.push_back(at(face, s, t));
        }
      }
      return points;
    },
    [&](int b, int edge) {
      std::vector<Vec3> points;
      Ijk ijk = cornerPoint(cellsOf(b), edgeCorner(edge, 0));
      for (int n = 0; n <= cellsOf(b)[edgeDirection(edge)]; ++n)
      {
        ijk[edgeDirection(edge)] = n;
        points.push_back(complex.blocks[b].points(ijk));
      }
      return points;
    },
    [&](const Node& node) { return complex.blocks[node.block].points(cornerPoint(cellsOf(node.block), node.corner)); });
  parts.legend = legendOf(model, drawn, options);
  parts.wallText = model.wallText;
}

void volumeParts(BlockParts& parts, vtkDataObject* input, const BlockPartsOptions& options, const Execution& run)
{
  const Ranks& ranks = *run.ranks;
  const BSplineVolumeBlocks volume = bsplineVolumeBlocks(input, ranks);
  if (volume.volumes.empty())
  {
    return;
  }
  std::vector<Interface> interfaces = volume.interfaces;
  if (!volume.hasInterfaces)
  {
    VolumeInterfaceOptions contacts;
    contacts.boundaries = volume.boundaries;
    interfaces = findVolumeInterfaces(volume.volumes, contacts, run);
  }
  const SharedEntities shared = sharedEntities(static_cast<int>(volume.volumes.size()), interfaces);
  Model model = volumeModel(volume, shared, ranks);
  model.roles = rolesOf(input, ranks);
  Execution here = run;
  here.ranks = aloneRank();
  here.progress = [](double) { return true; };
  choosePart(
    model,
    [&](const Face& face) {
      const FaceGeometry whole = faceGeometry(volume.volumes[face.block], face.face, 1);
      const std::vector<int> is = coarseIndices(whole.samples[0]), it = coarseIndices(whole.samples[1]);
      CoarseFace coarse{ { int(is.size()), int(it.size()) }, {}, true };
      for (const int t : it)
      {
        for (const int s : is)
        {
          coarse.points.push_back(whole.points[s + std::size_t(whole.samples[0]) * t]);
        }
      }
      // Normals point into the block.
      const std::size_t middle = is[is.size() / 2] + std::size_t(whole.samples[0]) * it[it.size() / 2];
      const Vec3* x = coarse.points.data() + is.size() / 2 - 1 + is.size() * (it.size() / 2 - 1);
      const Vec3 cross = (x[is.size() + 1] - x[0]).cross(x[is.size()] - x[1]);
      coarse.outward = cross.dot(whole.normals[middle]) < 0.0;
      return coarse;
    },
    run);
  addVolumeCreases(model, volume, interfaces);

  Index spans = 0;
  for (const Face& face : model.faces)
  {
    const BSplineVolume& block = volume.volumes[face.block];
    if (face.part == Part::Wall)
    {
      Index count = 1;
      for (int axis = 0; axis < 2; ++axis)
      {
        count *= block.count(faceAxis(face.face, axis));
      }
      spans += count;
    }
  }
  const int subdivision = options.subdivision > 0 ? options.subdivision : automaticSubdivision(spans);

  std::vector<vtkSmartPointer<vtkPolyData>> surfaces(volume.volumes.size());
  Eigen::AlignedBox3d box;
  std::map<int, SurfaceBuilder> builders;
  for (const Face& face : model.faces)
  {
    if (face.part != Part::Wall || !model.isHere(face.block))
    {
      continue;
    }
    const BSplineVolume& block = volume.volumes[face.block];
    const FaceGeometry geometry = faceGeometry(block, face.face, subdivision, here, options.layer, true);
    for (const Vec3& x : geometry.points)
    {
      box.extend(x);
    }
    if (!options.wall)
    {
      continue;
    }
    const auto found = builders.find(face.block);
    SurfaceBuilder& builder = builders[face.block];
    if (found == builders.end())
    {
      builder.curvatures();
    }
    const int ns = geometry.samples[0], nt = geometry.samples[1];
    // The nearest control point, or the cell of the net between the nearest ones.
    const auto source = [&](int s, int t, bool cell) {
      Ijk ijk{};
      const int last[2] = { ns - 1, nt - 1 };
      const int here2[2] = { s, t };
      for (int axis = 0; axis < 2; ++axis)
      {
        const int d = faceAxis(face.face, axis);
        const int count = block.count(d) - (cell ? 1 : 0);
        const double part = last[axis] - (cell ? 1 : 0) > 0 ? double(here2[axis]) / (last[axis] - (cell ? 1 : 0)) : 0.0;
        ijk[d] = std::min(count - 1, static_cast<int>(std::lround(part * (count - 1))));
      }
      const int across = faceDirection(face.face);
      const int less = cell ? 1 : 0;
      const int deepest = block.count(across) - 1 - less;
      // Layer 1 is nearest to the third control point.
      const int depth = std::min(options.layer == 0 ? 0 : options.layer + 1, deepest);
      ijk[across] = faceSide(face.face) == 0 ? depth : deepest - depth;
      return ijk[0] + vtkIdType(block.count(0) - less) * (ijk[1] + vtkIdType(block.count(1) - less) * ijk[2]);
    };
    for (int t = 0; t < nt; ++t)
    {
      for (int s = 0; s < ns; ++s)
      {
        const std::size_t n = s + std::size_t(ns) * t;
        builder.point(geometry.points[n], geometry.normals[n], source(s, t, false));
        builder.curvature(geometry.mean[n], geometry.gaussian[n]);
      }
    }
    const auto& [u, v] = geometry.parameters;
    builder.quads(ns, nt, face.tag,
      [&, &u = u, &v = v](int s, int t) { return u[s] < u[s + 1] && v[t] < v[t + 1] ? source(s, t, true) : -1; });
  }
  for (auto& [block, builder] : builders)
  {
    surfaces[block] = builder.build(volume.grids[block], true);
  }
  box = sharedBox(box, ranks);
  parts.surfaces = treeOf(input, volume.grids, surfaces);
  std::vector<std::array<double, 3>> drawn;
  drawn = buildLines(
    parts, model, options, box, true,
    [&](const Face& face, std::array<int, 2>& counts) {
      const FaceGeometry geometry = faceGeometry(volume.volumes[face.block], face.face, 1, here);
      counts = geometry.samples;
      return geometry.points;
    },
    [&](int b, int edge) { return edgeCurve(volume.volumes[b], edge, 4); },
    [&](const Node& node) {
      const BSplineVolume& block = volume.volumes[node.block];
      Vec3 uvw;
      for (int d = 0; d < 3; ++d)
      {
        const std::vector<double>& knots = block.knots[d];
        uvw[d] = cornerSide(node.corner, d) == 0 ? knots[block.degree[d]] : knots[knots.size() - 1 - block.degree[d]];
      }
      return evaluate(block, uvw);
    });
  parts.legend = legendOf(model, drawn, options);
  parts.wallText = model.wallText;
}

//------------------------------------------------------------------------------
// Block complexes: the output of vtkHexBlockTopology
//------------------------------------------------------------------------------

vtkPolyData* partOf(vtkDataObject* input, unsigned int part)
{
  auto* collection = vtkPartitionedDataSetCollection::SafeDownCast(input);
  return collection && part < collection->GetNumberOfPartitionedDataSets() &&
      collection->GetNumberOfPartitions(part) > 0
    ? vtkPolyData::SafeDownCast(collection->GetPartition(part, 0))
    : nullptr;
}

std::vector<std::string> fieldStrings(vtkDataObject* input, const char* name)
{
  std::vector<std::string> values;
  auto* array = vtkStringArray::SafeDownCast(input->GetFieldData()->GetAbstractArray(name));
  for (vtkIdType n = 0; array && n < array->GetNumberOfValues(); ++n)
  {
    values.push_back(array->GetValue(n));
  }
  return values;
}

bool isComplex(vtkDataObject* input, const Ranks& ranks)
{
  return ranks.any(input && input->GetFieldData()->HasArray("ClassNames") && partOf(input, 2));
}

/// Value of a cell array, or -1.
int cellValue(vtkPolyData* data, const char* name, vtkIdType cell)
{
  vtkDataArray* array = data->GetCellData()->GetArray(name);
  return array ? static_cast<int>(array->GetTuple1(cell)) : -1;
}

void complexParts(BlockParts& parts, vtkDataObject* input, const BlockPartsOptions& options, const Execution& run)
{
  const Ranks& ranks = *run.ranks;
  Model model;
  model.ranks = &ranks;
  const std::vector<std::string> names = fieldStrings(input, "BoundaryNames");
  std::vector<std::string> types = fieldStrings(input, "BoundaryTypes");
  types.resize(names.size());
  vtkPolyData* faces = partOf(input, 2);
  std::vector<vtkIdType> outer, wall;
  for (vtkIdType cell = 0; faces && cell < faces->GetNumberOfCells(); ++cell)
  {
    const int tag = cellValue(faces, "BoundaryTag", cell);
    if (cellValue(faces, "Class", cell) == static_cast<int>(EntityClass::Boundary))
    {
      outer.push_back(cell);
      if (tag >= 0 && tag < static_cast<int>(names.size()) &&
        selectsBoundary(defaultBodyBoundaries(), defaultBodyBoundaries(), names, types, tag))
      {
        wall.push_back(cell);
      }
    }
  }
  const bool named = ranks.any(!wall.empty());
  model.wallText = named ? "wall" : "outer faces";
  vtkNew<vtkPolyData> chosen;
  Eigen::AlignedBox3d box;
  if (faces)
  {
    chosen->SetPoints(faces->GetPoints());
    vtkNew<vtkCellArray> quads;
    vtkNew<vtkIdTypeArray> source;
    source->SetName("SourceCell");
    chosen->GetCellData()->CopyAllocate(faces->GetCellData());
    for (const vtkIdType cell : named ? wall : outer)
    {
      vtkIdType count = 0;
      const vtkIdType* ids = nullptr;
      faces->GetCellPoints(cell, count, ids);
      for (vtkIdType n = 0; n < count; ++n)
      {
        Vec3 x;
        faces->GetPoint(ids[n], x.data());
        box.extend(x);
      }
      if (options.wall)
      {
        chosen->GetCellData()->CopyData(faces->GetCellData(), cell, quads->InsertNextCell(count, ids));
        source->InsertNextValue(cell);
      }
    }
    chosen->SetPolys(quads);
    chosen->GetCellData()->AddArray(source);
  }
  box = sharedBox(box, ranks);
  parts.surfaces = withLeaves(vtkDataObjectTree::SafeDownCast(input), [&](vtkDataObject* leaf) {
    return leaf == faces ? vtkSmartPointer<vtkPolyData>(chosen) : vtkSmartPointer<vtkPolyData>::New();
  });

  LineBuilder nets, curves;
  nets.limit(box, options.reach);
  curves.limit(box, options.reach);
  const auto visit = [&](vtkPolyData* data, const auto& each) {
    for (vtkIdType cell = 0; data && cell < data->GetNumberOfCells(); ++cell)
    {
      vtkIdType count = 0;
      const vtkIdType* ids = nullptr;
      data->GetCellPoints(cell, count, ids);
      std::vector<Vec3> points(static_cast<std::size_t>(count));
      for (vtkIdType n = 0; n < count; ++n)
      {
        data->GetPoint(ids[n], points[n].data());
      }
      each(static_cast<EntityClass>(cellValue(data, "Class", cell)), cellValue(data, "Valence", cell), points);
    }
  };
  std::vector<int> valences;
  visit(partOf(input, 1), [&](EntityClass what, int valence, const std::vector<Vec3>& points) {
    const bool extraordinary = what == EntityClass::Extraordinary;
    if (extraordinary ? options.extraordinaryCurves : what == EntityClass::Crease && options.creases)
    {
      curves.line(points, extraordinary ? valenceColor(valence) : CreaseColor);
    }
    else if (options.blockEdges)
    {
      nets.line(points, BlockEdgeColor);
    }
    if (extraordinary)
    {
      valences.push_back(valence);
    }
  });
  visit(partOf(input, 0), [&](EntityClass what, int, const std::vector<Vec3>& points) {
    if (what == EntityClass::Singular && options.extraordinaryCurves)
    {
      curves.node(points.front(), NodeColor);
    }
  });
  for (const int valence : ranks.gatherAll(valences))
  {
    ++model.valences[valence];
  }
  parts.nets = nets.build();
  parts.curves = curves.build();
  parts.legend = legendOf(model, curves.colors(), options);
  parts.wallText = model.wallText;
}

} // namespace

vtkSmartPointer<vtkDataObjectTree> withLeaves(
  vtkDataObjectTree* tree, const std::function<vtkSmartPointer<vtkPolyData>(vtkDataObject*)>& surfaceOf)
{
  auto result = vtkSmartPointer<vtkDataObjectTree>::Take(tree->NewInstance());
  result->CopyStructure(tree);
  auto leaves = vtkSmartPointer<vtkDataObjectTreeIterator>::Take(tree->NewTreeIterator());
  leaves->VisitOnlyLeavesOn();
  leaves->TraverseSubTreeOn();
  for (leaves->InitTraversal(); !leaves->IsDoneWithTraversal(); leaves->GoToNextItem())
  {
    if (const vtkSmartPointer<vtkPolyData> surface = surfaceOf(leaves->GetCurrentDataObject()))
    {
      result->SetDataSetFrom(leaves, surface);
    }
  }
  return result;
}

BlockParts blockParts(vtkDataObject* input, const BlockPartsOptions& options, const Execution& run)
{
  BlockParts parts;
  try
  {
    run.ranks->together([&] {
      parts.isVolume = isVolume(input, *run.ranks);
      if (isComplex(input, *run.ranks))
      {
        complexParts(parts, input, options, run);
      }
      else if (parts.isVolume)
      {
        volumeParts(parts, input, options, run);
      }
      else
      {
        meshParts(parts, input, options, run);
      }
    });
  }
  catch (const Error&)
  {
    // Said by those who read or convert it.
    parts.surfaces = nullptr;
  }
  if (!parts.surfaces)
  {
    parts.surfaces = treeOf(input, {}, {});
  }
  for (auto* lines : { &parts.nets, &parts.curves })
  {
    if (!*lines)
    {
      *lines = vtkSmartPointer<vtkPolyData>::New();
    }
  }
  return parts;
}

} // namespace bsv
