// SPDX-License-Identifier: BSD-3-Clause
// The parts of block meshes.
#include "blockPartsModel.h"

#include "Complex/BlockComplex.h"
#include "Complex/EntityClass.h"
#include "Data/HexBlockData.h"

#include <algorithm>

namespace bsv
{

namespace
{

using Face = BlockPartsModel::Face;

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

/// The blocks glued, or loose if they do not fit together.
BlockComplex glued(const BlockMesh& mesh, const Execution& run)
{
  BlockComplex complex;
  try
  {
    BlockComplexOptions gluing;
    gluing.allowDegenerate = true;
    run.ranks->together([&] { complex = buildBlockComplex(mesh, gluing, run); });
  }
  catch (const Aborted&)
  {
    throw;
  }
  catch (const Error&)
  {
    complex = looseBlocks(mesh);
  }
  return complex;
}

BlockPartsModel meshModel(const BlockComplex& complex, const Ranks& ranks)
{
  BlockPartsModel model;
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

Ijk cellsOf(const ComplexBlock& block)
{
  return { block.cells(0), block.cells(1), block.cells(2) };
}

bool isOutward(const ComplexBlock& block, int face)
{
  return ((faceDirection(face) == 1) != (faceSide(face) == 1)) != block.leftHanded;
}

/// The point (s, t) of a face, or that below it in a layer.
Ijk layerPoint(const Ijk& cells, int face, int s, int t, int layer)
{
  Ijk ijk = facePoint(cells, face, s, t);
  const int across = faceDirection(face);
  const int depth = std::min(layer, cells[across]);
  ijk[across] += faceSide(face) == 0 ? depth : -depth;
  return ijk;
}

FacePoints pointsOf(const ComplexBlock& block, int face, int layer)
{
  const Ijk cells = cellsOf(block);
  FacePoints result{ { cells[faceAxis(face, 0)] + 1, cells[faceAxis(face, 1)] + 1 }, {} };
  result.points.reserve(std::size_t(result.counts[0]) * result.counts[1]);
  for (int t = 0; t < result.counts[1]; ++t)
  {
    for (int s = 0; s < result.counts[0]; ++s)
    {
      result.points.push_back(block.points(layerPoint(cells, face, s, t, layer)));
    }
  }
  return result;
}

CoarseFace coarseFace(const ComplexBlock& block, int face)
{
  const Ijk cells = cellsOf(block);
  const std::vector<int> is = coarseIndices(cells[faceAxis(face, 0)] + 1);
  const std::vector<int> it = coarseIndices(cells[faceAxis(face, 1)] + 1);
  CoarseFace coarse{ { int(is.size()), int(it.size()) }, {}, isOutward(block, face) };
  for (const int t : it)
  {
    for (const int s : is)
    {
      coarse.points.push_back(block.points(layerPoint(cells, face, s, t, 0)));
    }
  }
  return coarse;
}

/// @param whole points of the block in the mesh that `block` is a part of
void addSurface(SurfaceBuilder& builder, const ComplexBlock& block, const Ijk& whole, const Face& face,
  const FacePoints& points, int layer)
{
  const Ijk cells = cellsOf(block);
  const std::vector<Vec3> normals =
    meshNormals(points.points, points.counts[0], points.counts[1], isOutward(block, face.face));
  builder.surface(points, normals, face.tag, [&](int s, int t, bool cell) {
    Ijk ijk = layerPoint(cells, face.face, s, t, layer);
    for (int d = 0; d < 3; ++d)
    {
      ijk[d] = block.offset[d] + (cell ? std::min(ijk[d], cells[d] - 1) : ijk[d]);
    }
    const int less = cell ? 1 : 0;
    return ijk[0] + vtkIdType(whole[0] - less) * (ijk[1] + vtkIdType(whole[1] - less) * ijk[2]);
  });
}

} // namespace

void meshParts(BlockParts& parts, vtkDataObject* input, const BlockPartsOptions& options, const Execution& run)
{
  BlockPartsShape shape;
  const BlockMesh mesh = blockMesh(input, shape.grids, run);
  if (mesh.blocks.empty())
  {
    return;
  }
  const BlockComplex complex = glued(mesh, run);
  BlockPartsModel model = meshModel(complex, *run.ranks);
  model.roles = rolesOf(input, *run.ranks);
  model.choosePart([&](const Face& face) { return coarseFace(complex.blocks[face.block], face.face); }, run);

  shape.wallNormals = options.meshNormals;
  for (const Face& face : model.faces)
  {
    if (!model.isWallHere(face))
    {
      continue;
    }
    const ComplexBlock& block = complex.blocks[face.block];
    const FacePoints points = pointsOf(block, face.face, options.layer);
    for (const Vec3& x : points.points)
    {
      shape.box.extend(x);
    }
    if (options.wall)
    {
      addSurface(
        shape.wall[block.parent], block, mesh.blocks[block.parent].points.counts(), face, points, options.layer);
    }
  }
  shape.net = [&](const Face& face) { return pointsOf(complex.blocks[face.block], face.face, 0); };
  shape.edge = [&](int b, int edge) {
    const ComplexBlock& block = complex.blocks[b];
    std::vector<Vec3> points;
    Ijk ijk = cornerPoint(cellsOf(block), edgeCorner(edge, 0));
    for (int n = 0; n <= block.cells(edgeDirection(edge)); ++n)
    {
      ijk[edgeDirection(edge)] = n;
      points.push_back(block.points(ijk));
    }
    return points;
  };
  shape.corner = [&](const BlockPartsModel::Node& node) {
    const ComplexBlock& block = complex.blocks[node.block];
    return block.points(cornerPoint(cellsOf(block), node.corner));
  };
  buildParts(parts, input, options, model, shape);
}

} // namespace bsv
