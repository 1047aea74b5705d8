// SPDX-License-Identifier: BSD-3-Clause
// The parts of B-spline volumes.
#include "blockPartsModel.h"

#include "Data/BSplineVolumeData.h"
#include "Mesh/SharedEntities.h"
#include "Volume/ControlPointRule.h"
#include "Volume/FaceGeometry.h"
#include "Volume/VolumeInterfaces.h"
#include "Volume/VolumeParts.h"

#include <algorithm>
#include <cmath>

namespace bsv
{

namespace
{

using Face = BlockPartsModel::Face;

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

BlockPartsModel volumeModel(const BSplineVolumeBlocks& input, const SharedEntities& shared, const Ranks& ranks)
{
  BlockPartsModel model;
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

/// The parameters of a corner.
Vec3 cornerParameters(const BSplineVolume& volume, int corner)
{
  Vec3 uvw;
  for (int d = 0; d < 3; ++d)
  {
    const std::vector<double>& knots = volume.knots[d];
    uvw[d] = cornerSide(corner, d) == 0 ? knots[volume.degree[d]] : knots[knots.size() - 1 - volume.degree[d]];
  }
  return uvw;
}

std::vector<Vec3> edgeCurve(const BSplineVolume& volume, int edge)
{
  constexpr int Parts = 4; // per span
  const int along = edgeDirection(edge);
  Vec3 uvw = cornerParameters(volume, edgeCorner(edge, 0));
  std::vector<Vec3> points;
  const std::vector<double>& knots = volume.knots[along];
  for (const int span : nonEmptySpans(volume.degree[along], knots))
  {
    for (int j = points.empty() ? 0 : 1; j <= Parts; ++j)
    {
      uvw[along] = knots[span] + (knots[span + 1] - knots[span]) * j / Parts;
      points.push_back(evaluate(volume, uvw));
    }
  }
  return points;
}

/// Creases: edges between two faces of the wall, once the wall is known; repeated knots make edges inside blocks.
void addVolumeCreases(
  BlockPartsModel& model, const BSplineVolumeBlocks& input, const std::vector<Interface>& interfaces)
{
  const VolumeParts parts = cutAtRepeatedKnots(input.volumes, interfaces);
  const SharedEntities shared = sharedEntities(static_cast<int>(parts.volumes.size()), parts.interfaces);
  std::vector<char> isWall(6 * input.volumes.size(), 0);
  for (const BlockPartsModel::Face& face : model.faces)
  {
    isWall[6 * std::size_t(face.block) + face.face] = face.part == BlockPart::Wall;
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
      model.curves.push_back({ block, edge.edge, CreaseColor, edgeCurve(parts.volumes[edge.block], edge.edge) });
    }
  }
}

/// Parts per span that keep the surface small enough to be shown as fast as the mesh it came from.
int automaticSubdivision(Index spans)
{
  return spans > 60000 ? 1 : spans > 15000 ? 2 : 4;
}

int subdivisionOf(const BlockPartsModel& model, const std::vector<BSplineVolume>& volumes)
{
  Index spans = 0;
  for (const Face& face : model.faces)
  {
    const BSplineVolume& block = volumes[face.block];
    spans += face.part != BlockPart::Wall
      ? 0
      : Index(block.count(faceAxis(face.face, 0))) * block.count(faceAxis(face.face, 1));
  }
  return automaticSubdivision(spans);
}

CoarseFace coarseFace(const BSplineVolume& volume, int face)
{
  const FaceGeometry whole = faceGeometry(volume, face, 1);
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
}

/// The control point nearest to the sample (s, t) of a face, or the cell of the net between the nearest ones.
vtkIdType nearestInNet(
  const BSplineVolume& volume, int face, int layer, const std::array<int, 2>& samples, int s, int t, bool cell)
{
  const int less = cell ? 1 : 0;
  const int place[2] = { s, t };
  Ijk ijk{};
  for (int axis = 0; axis < 2; ++axis)
  {
    const int d = faceAxis(face, axis);
    const int last = samples[axis] - 1 - less;
    const int lastPoint = volume.count(d) - 1 - less;
    const double part = last > 0 ? double(place[axis]) / last : 0.0;
    ijk[d] = std::min(lastPoint, static_cast<int>(std::lround(part * lastPoint)));
  }
  const int across = faceDirection(face);
  const int deepest = volume.count(across) - 1 - less;
  // Layer 1 is nearest to the third control point.
  const int depth = std::min(layer == 0 ? 0 : layer + 1, deepest);
  ijk[across] = faceSide(face) == 0 ? depth : deepest - depth;
  return ijk[0] + vtkIdType(volume.count(0) - less) * (ijk[1] + vtkIdType(volume.count(1) - less) * ijk[2]);
}

} // namespace

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
  BlockPartsModel model = volumeModel(volume, shared, ranks);
  model.roles = rolesOf(input, ranks);
  model.choosePart([&](const Face& face) { return coarseFace(volume.volumes[face.block], face.face); }, run);
  addVolumeCreases(model, volume, interfaces);

  Execution here = run;
  here.ranks = aloneRank();
  here.progress = [](double) { return true; };
  const int subdivision = options.subdivision > 0 ? options.subdivision : subdivisionOf(model, volume.volumes);
  BlockPartsShape shape;
  shape.grids = volume.grids;
  for (const Face& face : model.faces)
  {
    if (!model.isWallHere(face))
    {
      continue;
    }
    const BSplineVolume& block = volume.volumes[face.block];
    const FaceGeometry geometry = faceGeometry(block, face.face, subdivision, here, options.layer, true);
    for (const Vec3& x : geometry.points)
    {
      shape.box.extend(x);
    }
    if (!options.wall)
    {
      continue;
    }
    SurfaceBuilder& builder = shape.wall[face.block];
    builder.surface({ geometry.samples, geometry.points }, geometry.normals, face.tag, [&](int s, int t, bool cell) {
      const auto& [u, v] = geometry.parameters;
      return cell && !(u[s] < u[s + 1] && v[t] < v[t + 1])
        ? -1
        : nearestInNet(block, face.face, options.layer, geometry.samples, s, t, cell);
    });
    builder.curvatures(geometry.mean, geometry.gaussian);
  }
  shape.net = [&](const Face& face) {
    const FaceGeometry geometry = faceGeometry(volume.volumes[face.block], face.face, 1, here);
    return FacePoints{ geometry.samples, geometry.points };
  };
  shape.edge = [&](int b, int edge) { return edgeCurve(volume.volumes[b], edge); };
  shape.corner = [&](const BlockPartsModel::Node& node) {
    const BSplineVolume& block = volume.volumes[node.block];
    return evaluate(block, cornerParameters(block, node.corner));
  };
  buildParts(parts, input, options, model, shape);
}

} // namespace bsv
