// SPDX-License-Identifier: BSD-3-Clause
// Sizes, aspect ratio and height of spans: known hexahedra, any orientation.
#include "Quality/SpanShape.h"
#include "Support/VolumeCases.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

using namespace bsv;
using namespace bsvtest;

namespace
{

/// Corners of one span: an image of the unit cube.
template <typename Map>
std::vector<double> hexahedron(const Map& map)
{
  std::vector<double> corners;
  forEach({ 2, 2, 2 }, [&](const Ijk& i) {
    const Vec3 x = map(Vec3(i[0], i[1], i[2]));
    corners.insert(corners.end(), x.data(), x.data() + 3);
  });
  return corners;
}

constexpr Ijk Two{ 2, 2, 2 };
constexpr Ijk First{ 0, 0, 0 };

} // namespace

TEST(SpanShape, KnownHexahedra)
{
  const Eigen::AngleAxisd turn(0.7, Vec3(1, 2, -1).normalized());
  const auto box = hexahedron([&](const Vec3& u) { return turn * Vec3(3 * u[0], 0.5 * u[1], 2 * u[2]); });
  EXPECT_NEAR(spanSize(box.data(), Two, First, 0), 3.0, 1e-15);
  EXPECT_NEAR(spanSize(box.data(), Two, First, 1), 0.5, 1e-15);
  EXPECT_NEAR(spanSize(box.data(), Two, First, 2), 2.0, 1e-15);
  EXPECT_NEAR(spanAspectRatio(box.data(), Two, First), 6.0, 1e-14);
  const std::array<double, 3> sizes{ 3.0, 0.5, 2.0 };
  for (int face = 0; face < 6; ++face)
  {
    EXPECT_NEAR(spanHeight(box.data(), Two, First, face), sizes[face / 2], 1e-15);
  }
  // Shear leaves the height over the wall, not the length of the edges.
  const auto sheared = hexahedron([](const Vec3& u) { return Vec3(u[0] + 5 * u[2], u[1] - u[2], 0.01 * u[2]); });
  EXPECT_NEAR(spanHeight(sheared.data(), Two, First, 4), 0.01, 1e-15);
  EXPECT_NEAR(spanHeight(sheared.data(), Two, First, 5), 0.01, 1e-15);
  EXPECT_NEAR(spanSize(sheared.data(), Two, First, 2), std::sqrt(26.0001), 1e-14);
  const auto collapsed = hexahedron([](const Vec3& u) { return Vec3(u[0], u[1], 0); });
  EXPECT_EQ(spanAspectRatio(collapsed.data(), Two, First), 0.0);
  EXPECT_EQ(spanHeight(collapsed.data(), Two, First, 4), 0.0);
  EXPECT_EQ(spanHeight(collapsed.data(), Two, First, 0), 0.0); // that face is a line
  EXPECT_EQ(sizeRatio(0.5, 2.0), 4.0);
  EXPECT_EQ(sizeRatio(2.0, 0.0), 0.0);
}

TEST(SpanShape, SameBitsForAnyOrientation)
{
  std::mt19937 random(1);
  Block block;
  block.volume.degree = { 1, 1, 1 };
  block.volume.knots = { { { 0, 0, 1, 2, 2 }, { 0, 0, 1, 2, 3, 3 }, { 0, 0, 1, 1 } } };
  forEach(block.counts(), [&](const Ijk&) {
    for (int c = 0; c < 3; ++c)
    {
      block.points.push_back(randomCoordinate(random));
    }
  });
  const Ijk counts = block.counts();
  const Ijk spans{ counts[0] - 1, counts[1] - 1, counts[2] - 1 };
  for (const Orientation& o : allOrientations())
  {
    const Block other = reoriented(block, o);
    const Ijk otherCounts = other.counts();
    forEach({ otherCounts[0] - 1, otherCounts[1] - 1, otherCounts[2] - 1 }, [&](const Ijk& i) {
      const Ijk old = o.old(i, spans);
      EXPECT_EQ(
        spanAspectRatio(block.points.data(), counts, old), spanAspectRatio(other.points.data(), otherCounts, i));
      for (int d = 0; d < 3; ++d)
      {
        EXPECT_EQ(
          spanSize(block.points.data(), counts, old, o.order[d]), spanSize(other.points.data(), otherCounts, i, d));
        for (int side = 0; side < 2; ++side)
        {
          EXPECT_EQ(spanHeight(block.points.data(), counts, old, 2 * o.order[d] + (o.flip[d] ? 1 - side : side)),
            spanHeight(other.points.data(), otherCounts, i, 2 * d + side));
        }
      }
    });
  }
}
