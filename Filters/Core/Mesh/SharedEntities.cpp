// SPDX-License-Identifier: BSD-3-Clause
#include "Mesh/SharedEntities.h"

#include "Base/UnionFind.h"

namespace bsv
{

namespace
{

/// Whether a face at the edge is a boundary.
bool atBoundary(const SharedEntities& all, int block, int edge)
{
  for (int axis = 0; axis < 2; ++axis)
  {
    const int face = 2 * faceAxis(2 * edgeDirection(edge), axis) + edgeSide(edge, axis);
    if (all.faces[all.blocks[block].faces[face]].uses == 1)
    {
      return true;
    }
  }
  return false;
}

} // namespace

SharedEntities sharedEntities(
  int blocks, const std::vector<Interface>& interfaces, const std::function<std::string(int block)>& blockName)
{
  UnionFind corners(8 * Index(blocks));
  // Item 2 e is edge e in its own direction, 2 e + 1 the same edge reversed.
  UnionFind edges(24 * Index(blocks));
  std::vector<int> partner(6 * static_cast<std::size_t>(blocks), -1);
  std::vector<int> code(partner.size(), 0);

  for (const Interface& contact : interfaces)
  {
    const int a = 6 * contact.blockA + contact.faceA;
    const int b = 6 * contact.blockB + contact.faceB;
    const int o = contact.orientation;
    for (const int face : { a, b })
    {
      if (partner[face] != -1 || a == b)
      {
        throw Error(blockName(face / 6) + " face " + std::to_string(face % 6) +
          (a == b ? " meets itself" : " is in two interfaces"));
      }
    }
    partner[a] = b;
    partner[b] = a;
    code[a] = o;
    code[b] = inverseOrientation(o);

    for (int s = 0; s < 2; ++s)
    {
      for (int t = 0; t < 2; ++t)
      {
        const auto m = mapFacePoint(o, s, t, 1, 1);
        corners.unite(8 * contact.blockA + faceCorner(contact.faceA, s, t),
          8 * contact.blockB + faceCorner(contact.faceB, m[0], m[1]));
      }
    }
    for (int axis = 0; axis < 2; ++axis)
    {
      const int axisB = swapsAxes(o) ? 1 - axis : axis;
      for (int side = 0; side < 2; ++side)
      {
        const auto start = mapFacePoint(o, axis == 0 ? 0 : side, axis == 0 ? side : 0, 1, 1);
        const bool turned = start[axisB] == 1;
        const Index one = 12 * Index(contact.blockA) + faceEdge(contact.faceA, axis, side);
        const Index two = 12 * Index(contact.blockB) + faceEdge(contact.faceB, axisB, start[1 - axisB]);
        edges.unite(2 * one, 2 * two + (turned ? 1 : 0));
        edges.unite(2 * one + 1, 2 * two + (turned ? 0 : 1));
        if (edges.find(2 * one) == edges.find(2 * one + 1))
        {
          throw Error("the contact of " + blockName(contact.blockA) + " face " + std::to_string(contact.faceA) +
            " and " + blockName(contact.blockB) + " face " + std::to_string(contact.faceB) +
            " joins an edge to itself in reverse");
        }
      }
    }
  }

  SharedEntities all;
  all.blocks.resize(blocks);
  std::vector<int> ids(8 * static_cast<std::size_t>(blocks), -1);
  for (int i = 0; i < 8 * blocks; ++i)
  {
    int& id = ids[corners.find(i)];
    id = id < 0 ? all.vertices++ : id;
    all.blocks[i / 8].vertices[i % 8] = id;
  }

  for (int i = 0; i < 6 * blocks; ++i)
  {
    SharedEntities::Block& block = all.blocks[i / 6];
    const bool first = partner[i] < 0 || partner[i] > i;
    if (first)
    {
      block.faces[i % 6] = static_cast<int>(all.faces.size());
      block.faceOrientations[i % 6] = 0;
      all.faces.push_back({ partner[i] < 0 ? 1 : 2, i / 6, i % 6 });
    }
    else
    {
      block.faces[i % 6] = all.blocks[partner[i] / 6].faces[partner[i] % 6];
      block.faceOrientations[i % 6] = code[partner[i]];
    }
  }

  ids.assign(12 * static_cast<std::size_t>(blocks), -1);
  for (int i = 0; i < 12 * blocks; ++i)
  {
    SharedEntities::Block& block = all.blocks[i / 12];
    // The smallest item of a class is its first block edge in its own direction.
    const Index item = edges.find(2 * Index(i));
    const Index root = item / 2;
    if (root == i)
    {
      ids[root] = static_cast<int>(all.edges.size());
      SharedEntities::Edge edge;
      edge.block = i / 12;
      edge.edge = i % 12;
      edge.vertices = { block.vertices[edgeCorner(i % 12, 0)], block.vertices[edgeCorner(i % 12, 1)] };
      all.edges.push_back(edge);
    }
    SharedEntities::Edge& edge = all.edges[ids[root]];
    block.edges[i % 12] = ids[root];
    block.edgeReversed[i % 12] = item % 2 != 0;
    ++edge.uses;
    edge.boundary = edge.boundary || atBoundary(all, i / 12, i % 12);
  }
  return all;
}

} // namespace bsv
