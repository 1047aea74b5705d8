// SPDX-License-Identifier: BSD-3-Clause
// The wall's distance from the body between its mesh points.
#include "Support/BodyCases.h"
#include "Support/ThreadRanks.h"
#include "Wall/BodyDistance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

using namespace bsv;
using bsvtest::onRanks;

namespace
{

/// Two unit cubes of one cubic span each, side by side in x, over the plane z = 0; the four control points inside the
/// bottom of the second are raised, by `first` the two nearer to the first cube.
struct Cubes
{
  explicit Cubes(double raised)
    : Cubes(raised, raised)
  {
  }
  Cubes(double first, double second)
  {
    for (int b = 0; b < 2; ++b)
    {
      for (int k = 0; k < 4; ++k)
      {
        for (int j = 0; j < 4; ++j)
        {
          for (int i = 0; i < 4; ++i)
          {
            const bool inside = b == 1 && k == 0 && (i == 1 || i == 2) && (j == 1 || j == 2);
            for (const double x : { b + i / 3.0, j / 3.0, inside ? (i == 1 ? first : second) : k / 3.0 })
            {
              this->Points[b].push_back(x);
            }
          }
        }
      }
      for (std::vector<double>& knots : this->Volumes[b].knots)
      {
        knots = clampedIntegerKnots(1);
      }
      this->Volumes[b].points = this->Points[b].data();
    }
  }

  /// The bottom of a block.
  VolumeFace bottom(int block) const { return { &this->Volumes[block], 4 }; }

private:
  std::vector<double> Points[2];
  BSplineVolume Volumes[2];
};

const BodySurface& plane()
{
  static const BodySurface body({ { "plane", bodycases::rectangle(2.0, 1.0), {}, false } });
  return body;
}

} // namespace

// The corners lie on the plane. At its centre the bottom is as high as the B-splines of the raised points add up to.
TEST(BodyDistance, OfTheCentre)
{
  const Cubes cubes(0.1);
  const BodyDistance found = bodyDistance({ cubes.bottom(0), cubes.bottom(1) }, plane());
  // 2 * 3 t (1 - t)^2 at t = 1/2 in both directions.
  const double height = 0.1 * 0.75 * 0.75;
  EXPECT_NEAR(found.largest, height, 1e-15);
  EXPECT_LE((found.where - Vec3(1.5, 0.5, height)).norm(), 1e-15);
  EXPECT_NEAR(found.inEdges, height, 1e-15) << "edges have length 1";
}

// No sample of a span need be where it is farthest: the corners and the centre of this one lie on the plane.
TEST(BodyDistance, BetweenCornersAndCentre)
{
  const Cubes cubes(0.1, -0.1);
  const BodyDistance found = bodyDistance({ cubes.bottom(0), cubes.bottom(1) }, plane());
  // 3 t (1 - t)^2 - 3 t^2 (1 - t) = 3 t (1 - t) (1 - 2 t), times 3 t (1 - t) at 1/2 in the other direction; largest
  // where 1 - 6 t + 6 t^2 = 0.
  const auto height = [](double t) { return 0.1 * 3.0 * t * (1.0 - t) * (1.0 - 2.0 * t) * 0.75; };
  EXPECT_LE(found.largest, height(0.5 - std::sqrt(1.0 / 12.0)) + 1e-15);
  for (int part = 1; part < 4; ++part)
  {
    EXPECT_GE(found.largest, height(part / 8.0) - 1e-15);
  }
}

TEST(BodyDistance, IsTheSameOnAllRanks)
{
  const Cubes cubes(0.1, -0.07);
  const BodyDistance serial = bodyDistance({ cubes.bottom(0), cubes.bottom(1) }, plane());
  // The last rank has no face.
  std::vector<BodyDistance> found(3);
  const std::vector<std::string> errors = onRanks(3, [&](const Execution& run) {
    std::vector<VolumeFace> mine;
    if (run.ranks->rank() < 2)
    {
      mine.push_back(cubes.bottom(run.ranks->rank()));
    }
    found[run.ranks->rank()] = bodyDistance(mine, plane(), run);
  });
  for (int rank = 0; rank < 3; ++rank)
  {
    EXPECT_EQ(errors[rank], "");
    EXPECT_EQ(found[rank].largest, serial.largest);
    EXPECT_EQ(found[rank].where, serial.where);
    EXPECT_EQ(found[rank].inEdges, serial.inEdges);
  }
}
