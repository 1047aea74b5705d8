// SPDX-License-Identifier: BSD-3-Clause
/// @file BlockTopology.h
/// Numbering of the corners, edges and faces of one block, and the eight ways in which two faces meet.
///
/// - corner  v = ci + 2 cj + 4 ck, each c in {0, 1}
/// - face    f = 2 * direction + side: 0 i=0, 1 i=I, 2 j=0, 3 j=J, 4 k=0, 5 k=K;
///           its axes (s, t) are the two remaining directions, ascending
/// - edge    0-3 along i at (cj,ck) = (0,0),(1,0),(0,1),(1,1); 4-7 along j at (ci,ck); 8-11 along k at (ci,cj)
/// - orientation code o = 0..7 from face A to face B: bit 0 exchanges (s, t), then bit 1 reverses B's first axis,
///   bit 2 its second
#pragma once

#include <array>

namespace bsv
{

/// Position of a mesh point, or of a cell, in a block.
using Ijk = std::array<int, 3>;

constexpr int faceDirection(int face)
{
  return face / 2;
}
constexpr int faceSide(int face)
{
  return face % 2;
}
/// Direction of the block in which the first (axis = 0) or second (axis = 1) face axis runs.
constexpr int faceAxis(int face, int axis)
{
  return axis == 0 ? (face / 2 == 0 ? 1 : 0) : (face / 2 == 2 ? 1 : 2);
}

constexpr int edgeDirection(int edge)
{
  return edge / 4;
}
/// The two directions across an edge, ascending, are those of faceAxis(2 * edgeDirection(edge), 0 and 1);
/// an edge sits at side edgeSide(edge, 0 and 1) of them.
constexpr int edgeSide(int edge, int axis)
{
  return (edge % 4) >> axis & 1;
}
/// Edge that runs in `direction` at the sides a, b of the two other directions, ascending.
constexpr int edgeIndex(int direction, int a, int b)
{
  return 4 * direction + a + 2 * b;
}

constexpr int cornerSide(int corner, int direction)
{
  return corner >> direction & 1;
}
/// Corner at the start (end = 0) or end (end = 1) of an edge.
constexpr int edgeCorner(int edge, int end)
{
  return end << edgeDirection(edge) | edgeSide(edge, 0) << faceAxis(2 * edgeDirection(edge), 0) |
    edgeSide(edge, 1) << faceAxis(2 * edgeDirection(edge), 1);
}
/// Corner of a face at the sides cs, ct of its axes.
constexpr int faceCorner(int face, int cs, int ct)
{
  return faceSide(face) << faceDirection(face) | cs << faceAxis(face, 0) | ct << faceAxis(face, 1);
}
/// Edge of a face that runs along its axis `axis` at the side `side` of its other axis.
constexpr int faceEdge(int face, int axis, int side)
{
  const int along = faceAxis(face, axis);
  const int other = faceAxis(face, 1 - axis);
  const int normal = faceDirection(face);
  return normal < other ? edgeIndex(along, faceSide(face), side) : edgeIndex(along, side, faceSide(face));
}

constexpr bool swapsAxes(int orientation)
{
  return (orientation & 1) != 0;
}
/// Code of the same contact seen from B.
constexpr int inverseOrientation(int o)
{
  return swapsAxes(o) ? (o & 1) | (o & 2) << 1 | (o & 4) >> 1 : o;
}

/// Maps (s, t) of face A, in a contact patch of ns x nt steps, to (s, t) of face B, both relative to the
/// lowest corner of the patch on either side.
constexpr std::array<int, 2> mapFacePoint(int orientation, int s, int t, int ns, int nt)
{
  const int u = swapsAxes(orientation) ? t : s;
  const int v = swapsAxes(orientation) ? s : t;
  const int nu = swapsAxes(orientation) ? nt : ns;
  const int nv = swapsAxes(orientation) ? ns : nt;
  return { (orientation & 2) ? nu - u : u, (orientation & 4) ? nv - v : v };
}

/// CGNS transform of an interface: entry d is +-(direction of B + 1) of A's direction d; along the normals + if a
/// maximum side meets a minimum side.
inline std::array<int, 3> cgnsTransform(int faceA, int faceB, int orientation)
{
  std::array<int, 3> transform{};
  for (int axis = 0; axis < 2; ++axis)
  {
    const int axisB = swapsAxes(orientation) ? 1 - axis : axis;
    const bool reversed = (orientation & (axisB == 0 ? 2 : 4)) != 0;
    transform[faceAxis(faceA, axis)] = (reversed ? -1 : 1) * (faceAxis(faceB, axisB) + 1);
  }
  transform[faceDirection(faceA)] = (faceSide(faceA) != faceSide(faceB) ? 1 : -1) * (faceDirection(faceB) + 1);
  return transform;
}

} // namespace bsv
