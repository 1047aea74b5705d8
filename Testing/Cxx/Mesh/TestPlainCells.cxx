// SPDX-License-Identifier: BSD-3-Clause
// The quick look at all cells of a grid, against corner Jacobians computed one by one.
#include "Mesh/PlainCells.h"

#include <Eigen/Geometry>

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

using namespace bsv;

namespace
{

/// A grid of unit cells whose points are moved at random by up to `amount` in every direction.
template <typename Real>
struct Grid
{
  Grid(std::array<int, 3> cells, double amount, unsigned int seed, bool mirror)
    : counts{ cells[0] + 1, cells[1] + 1, cells[2] + 1 }
  {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> move(-amount, amount);
    for (int k = 0; k < this->counts[2]; ++k)
    {
      for (int j = 0; j < this->counts[1]; ++j)
      {
        for (int i = 0; i < this->counts[0]; ++i)
        {
          const double x = i + move(random), y = j + move(random), z = k + move(random);
          this->xyz.insert(this->xyz.end(), { Real(mirror ? -x : x), Real(y), Real(z) });
        }
      }
    }
  }
  GridView view() const { return GridView(this->xyz.data(), this->counts); }

  std::array<int, 3> counts;
  std::vector<Real> xyz;
};

/// The sign that all corner Jacobians share, or 0; and their sum.
PlainCells oneByOne(const GridView& points, int begin, int end)
{
  const std::array<int, 3>& n = points.counts();
  Index positive = 0, negative = 0, all = 0;
  PlainCells result;
  for (int k = begin; k < end; ++k)
  {
    for (int j = 0; j + 1 < n[1]; ++j)
    {
      for (int i = 0; i + 1 < n[0]; ++i)
      {
        for (int c = 0; c < 8; ++c, ++all)
        {
          const int ci = c & 1, cj = c >> 1 & 1, ck = c >> 2;
          const Vec3 x = points(i + ci, j + cj, k + ck);
          const Vec3 a = (points(i + 1 - ci, j + cj, k + ck) - x) * (ci ? -1.0 : 1.0);
          const Vec3 b = (points(i + ci, j + 1 - cj, k + ck) - x) * (cj ? -1.0 : 1.0);
          const Vec3 d = (points(i + ci, j + cj, k + 1 - ck) - x) * (ck ? -1.0 : 1.0);
          const double jacobian = a.dot(b.cross(d));
          positive += jacobian > 0.0;
          negative += jacobian < 0.0;
          result.volume += jacobian;
        }
      }
    }
  }
  result.sign = positive == all ? 1 : negative == all ? -1 : 0;
  return result;
}

template <typename Real>
void compare()
{
  // Rows shorter and longer than any vector unit, and no multiples of it.
  int signs[3] = { 0, 0, 0 };
  for (unsigned int seed = 0; seed < 300; ++seed)
  {
    const std::array<int, 3> cells{ 1 + int(seed % 11), 1 + int(seed % 3), 2 + int(seed % 4) };
    const Grid<Real> grid(cells, 0.1 + 0.002 * seed, seed, seed % 2 != 0);
    const PlainCells expected = oneByOne(grid.view(), 1, cells[2]);
    const PlainCells found = plainCells(grid.view(), 1, cells[2], 0.0);
    EXPECT_EQ(found.sign, expected.sign) << seed;
    if (found.sign != 0)
    {
      EXPECT_NEAR(found.volume, expected.volume, 1e-12 * std::abs(expected.volume)) << seed;
    }
    ++signs[found.sign + 1];
  }
  // The cases are of all kinds.
  for (const int count : signs)
  {
    EXPECT_GT(count, 20);
  }
}

} // namespace

TEST(PlainCells, AgreeWithCornerJacobiansOneByOne)
{
  compare<double>();
  compare<float>();
}

TEST(PlainCells, OneBadPointAnywhereIsNoticed)
{
  const std::array<int, 3> cells{ 9, 2, 2 };
  const Grid<double> good(cells, 0.1, 1, false);
  ASSERT_EQ(plainCells(good.view(), 0, cells[2], 0.0).sign, 1);
  for (std::size_t value = 0; value < good.xyz.size(); ++value)
  {
    const double infinity = std::numeric_limits<double>::infinity();
    for (const double bad : { std::numeric_limits<double>::quiet_NaN(), infinity, -infinity, 1e300, 40.0 })
    {
      Grid<double> grid = good;
      grid.xyz[value] = bad;
      // Huge numbers, too, are left to the exact tests.
      const int expected = bad == 40.0 ? oneByOne(grid.view(), 0, cells[2]).sign : 0;
      EXPECT_EQ(plainCells(grid.view(), 0, cells[2], 0.0).sign, expected) << value << ' ' << bad;
    }
  }
}

TEST(PlainCells, ShortEdgesAndFlatCellsAreNotPlain)
{
  const std::array<int, 3> cells{ 5, 3, 3 };
  const Grid<double> good(cells, 0.0, 1, false);
  // All edges have length 1, which is as short as asked.
  EXPECT_EQ(plainCells(good.view(), 0, 3, 0.49).sign, 1);
  EXPECT_EQ(plainCells(good.view(), 0, 3, 1.0).sign, 0);
  // Thin layers are plain as long as their thickness is no rounding error.
  for (const double thickness : { 1e-8, 1e-14 })
  {
    Grid<double> grid = good;
    for (std::size_t i = 1; i < grid.xyz.size(); i += 3)
    {
      grid.xyz[i] *= thickness;
    }
    EXPECT_EQ(plainCells(grid.view(), 0, 3, 0.0).sign, thickness > 1e-12 ? 1 : 0) << thickness;
  }
}
