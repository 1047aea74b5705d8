// SPDX-License-Identifier: BSD-3-Clause
/// Numbering of corners, edges and faces, and the orientation codes, against geometry.
#include "Complex/BlockComplex.h"
#include "Support/MeshCases.h"

#include <gtest/gtest.h>

#include <set>

using namespace bsv;

namespace
{

Ijk cornerPoint(const Ijk& cells, int corner)
{
  return { cornerSide(corner, 0) * cells[0], cornerSide(corner, 1) * cells[1], cornerSide(corner, 2) * cells[2] };
}

int determinant(const std::array<int, 3>& t)
{
  int m[3][3] = {};
  for (int d = 0; d < 3; ++d)
  {
    m[d][std::abs(t[d]) - 1] = t[d] > 0 ? 1 : -1;
  }
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
    m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

} // namespace

TEST(BlockTopology, EdgesConnectCornersThatDifferInTheirDirection)
{
  std::set<std::pair<int, int>> seen;
  for (int edge = 0; edge < 12; ++edge)
  {
    const int a = edgeCorner(edge, 0);
    const int b = edgeCorner(edge, 1);
    EXPECT_EQ(b - a, 1 << edgeDirection(edge));
    EXPECT_EQ(edgeIndex(edgeDirection(edge), edgeSide(edge, 0), edgeSide(edge, 1)), edge);
    seen.insert({ a, b });
  }
  EXPECT_EQ(seen.size(), 12u);
}

TEST(BlockTopology, EdgesAreNumberedAsDocumented)
{
  // 0-3 along i at (cj,ck), 4-7 along j at (ci,ck), 8-11 along k at (ci,cj).
  for (int n = 0; n < 4; ++n)
  {
    const int a = n & 1, b = n >> 1;
    EXPECT_EQ(edgeCorner(n, 0), 2 * a + 4 * b);
    EXPECT_EQ(edgeCorner(4 + n, 0), a + 4 * b);
    EXPECT_EQ(edgeCorner(8 + n, 0), a + 2 * b);
  }
}

TEST(BlockTopology, FacesHaveTheirCornersAndEdges)
{
  const Ijk cells{ 2, 3, 4 };
  for (int face = 0; face < 6; ++face)
  {
    EXPECT_LT(faceAxis(face, 0), faceAxis(face, 1));
    EXPECT_NE(faceAxis(face, 0), faceDirection(face));
    EXPECT_NE(faceAxis(face, 1), faceDirection(face));
    for (int c = 0; c < 4; ++c)
    {
      const Ijk p = facePoint(cells, face, (c & 1) * cells[faceAxis(face, 0)], (c >> 1) * cells[faceAxis(face, 1)]);
      EXPECT_EQ(p, cornerPoint(cells, faceCorner(face, c & 1, c >> 1)));
      EXPECT_EQ(p[faceDirection(face)], faceSide(face) ? cells[faceDirection(face)] : 0);
    }
    for (int axis = 0; axis < 2; ++axis)
    {
      for (int side = 0; side < 2; ++side)
      {
        const int edge = faceEdge(face, axis, side);
        EXPECT_EQ(edgeDirection(edge), faceAxis(face, axis));
        for (int end = 0; end < 2; ++end)
        {
          EXPECT_EQ(edgeCorner(edge, end), axis == 0 ? faceCorner(face, end, side) : faceCorner(face, side, end));
        }
      }
    }
  }
}

TEST(BlockTopology, OrientationsAreInvertedByTheirInverse)
{
  for (int o = 0; o < 8; ++o)
  {
    EXPECT_EQ(inverseOrientation(inverseOrientation(o)), o);
    const int ns = 3, nt = 5;
    const int nu = swapsAxes(o) ? nt : ns, nv = swapsAxes(o) ? ns : nt;
    for (int t = 0; t <= nt; ++t)
    {
      for (int s = 0; s <= ns; ++s)
      {
        const auto b = mapFacePoint(o, s, t, ns, nt);
        EXPECT_GE(b[0], 0);
        EXPECT_LE(b[0], nu);
        EXPECT_GE(b[1], 0);
        EXPECT_LE(b[1], nv);
        const auto a = mapFacePoint(inverseOrientation(o), b[0], b[1], nu, nv);
        EXPECT_EQ(a[0], s);
        EXPECT_EQ(a[1], t);
      }
    }
  }
}

/// For each of the 288 pairs of faces and codes, a second block is laid beside the first by its CGNS transform. The
/// search for contacts, which knows only the points, must find these faces and this code, and the second block is
/// left-handed exactly where the transform's determinant is -1.
TEST(BlockTopology, AllContactsAgreeWithTheirCgnsTransform)
{
  const Ijk cells{ 2, 3, 4 };
  int pairs = 0;
  for (int faceA = 0; faceA < 6; ++faceA)
  {
    for (int faceB = 0; faceB < 6; ++faceB)
    {
      for (int o = 0; o < 8; ++o, ++pairs)
      {
        SCOPED_TRACE(testing::Message() << "faces " << faceA << " " << faceB << " code " << o);
        const std::array<int, 3> transform = cgnsTransform(faceA, faceB, o);
        Ijk cellsB{};
        for (int d = 0; d < 3; ++d)
        {
          cellsB[std::abs(transform[d]) - 1] = d == faceDirection(faceA) ? 2 : cells[d];
        }
        const int ns = cells[faceAxis(faceA, 0)], nt = cells[faceAxis(faceA, 1)];
        const auto corner = mapFacePoint(o, 0, 0, ns, nt);
        const Ijk beginA = facePoint(cells, faceA, 0, 0);
        const Ijk beginB = facePoint(cellsB, faceB, corner[0], corner[1]);

        meshcases::MeshCase mesh;
        mesh.add(cells, [](const Ijk& p) { return Vec3(p[0], p[1], p[2]); });
        mesh.add(cellsB, [&](const Ijk& q) {
          Vec3 x;
          for (int d = 0; d < 3; ++d)
          {
            const int target = std::abs(transform[d]) - 1;
            x[d] = beginA[d] + (transform[d] > 0 ? 1 : -1) * (q[target] - beginB[target]);
          }
          return x;
        });
        const BlockMesh view = mesh.mesh();
        const BlockComplex complex = buildBlockComplex(view);
        ASSERT_EQ(complex.blocks.size(), 2u);
        EXPECT_EQ(complex.blocks[1].leftHanded, determinant(transform) < 0);
        const ComplexFace& contact = complex.faces[complex.blocks[0].faces[faceA]];
        ASSERT_EQ(contact.uses.size(), 2u);
        EXPECT_EQ(contact.uses[0].block, 0);
        EXPECT_EQ(contact.uses[1].block, 1);
        EXPECT_EQ(contact.uses[1].face, faceB);
        EXPECT_EQ(contact.orientation, o);

        // And declared: the same contact passes the check against the coordinates.
        meshcases::MeshCase declared = mesh;
        Interface interface;
        interface.blockB = 1;
        interface.faceA = faceA;
        interface.faceB = faceB;
        interface.orientation = o;
        interface.rangeA.hi = { ns, nt };
        declared.interfaces.push_back(interface);
        const BlockMesh declaredView = declared.mesh();
        BlockComplexOptions options;
        options.findInterfaces = false;
        EXPECT_EQ(buildBlockComplex(declaredView, options).faces.size(), 11u);
      }
    }
  }
  EXPECT_EQ(pairs, 288);
}
