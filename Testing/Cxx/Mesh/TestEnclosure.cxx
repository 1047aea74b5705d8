// SPDX-License-Identifier: BSD-3-Clause
/// Outer faces around a hole and outer faces that bound a mesh from outside.
#include "Mesh/Enclosure.h"

#include <gtest/gtest.h>

using namespace bsv;

namespace
{

/// The six sides of a cube around the origin. @param outward whether the mesh is inside the cube
void addCube(std::vector<CoarseFace>& faces, double half, bool meshInside)
{
  for (int d = 0; d < 3; ++d)
  {
    for (const double side : { -half, half })
    {
      CoarseFace face;
      face.counts = { 4, 5 };
      for (int t = 0; t < 5; ++t)
      {
        for (int s = 0; s < 4; ++s)
        {
          Vec3 x;
          x[d] = side;
          x[(d + 1) % 3] = half * (2.0 * s / 3.0 - 1.0);
          x[(d + 2) % 3] = half * (2.0 * t / 4.0 - 1.0);
          face.points.push_back(x);
        }
      }
      // Here first x second points to +d.
      face.outward = (side > 0.0) == meshInside;
      faces.push_back(face);
    }
  }
}

} // namespace

TEST(Enclosure, WallOfAHoleIsHiddenAndTheHullIsNot)
{
  std::vector<CoarseFace> faces;
  addCube(faces, 10.0, true);
  addCube(faces, 1.0, false);
  const std::vector<double> share = enclosure(faces);
  for (int f = 0; f < 12; ++f)
  {
    EXPECT_EQ(share[f], f < 6 ? 0.0 : 1.0) << f;
  }
}

TEST(Enclosure, OpenHoleStillCounts)
{
  // A body cut off by a plane, as half of an aircraft is by the symmetry plane.
  std::vector<CoarseFace> faces;
  addCube(faces, 1.0, false);
  faces.erase(faces.begin());
  for (const double share : enclosure(faces))
  {
    EXPECT_GT(share, EnclosedShare);
    EXPECT_LE(share, 1.0);
  }
}

TEST(Enclosure, SolidAloneHidesNothing)
{
  std::vector<CoarseFace> faces;
  addCube(faces, 1.0, true);
  for (const double share : enclosure(faces))
  {
    EXPECT_EQ(share, 0.0);
  }
}
