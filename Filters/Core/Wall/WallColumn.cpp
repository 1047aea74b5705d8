// SPDX-License-Identifier: BSD-3-Clause
#include "Wall/WallColumn.h"

#include "Volume/BSplineVolume.h"

#include <algorithm>
#include <cmath>

namespace bsv
{

WallBasis::WallBasis(int cells, double u)
{
  const int span = std::min(static_cast<int>(u), cells - 1);
  const auto knot = [cells](int i) { return static_cast<double>(std::min(std::max(i - 3, 0), cells)); };
  double left[4], right[4];
  for (int j = 1; j <= 3; ++j)
  {
    left[j] = u - knot(span + 4 - j);
    right[j] = knot(span + 3 + j) - u;
  }
  basisFunctions(3, 0, left, right, this->values.data());
  this->first = span;
}

WallBasis basisAtKnot(int cells, int m)
{
  if (2 * m > cells)
  {
    WallBasis basis = basisAtKnot(cells, cells - m);
    std::reverse(basis.values.begin(), basis.values.end());
    basis.first = cells - 1 - basis.first;
    return basis;
  }
  WallBasis basis(cells, m);
  if (2 * m == cells)
  {
    basis.values[0] = basis.values[2] = 0.5 * (basis.values[0] + basis.values[2]);
  }
  return basis;
}

Vec3 WallColumn::at(double u) const
{
  const WallBasis basis(this->cells, u);
  Vec3 x = Vec3::Zero();
  for (int i = 0; i < 4; ++i)
  {
    x += basis.values[i] * this->points[basis.first + i];
  }
  return x;
}

double WallColumn::growth(int level) const
{
  const double step = std::ldexp(1.0, -level);
  const int last = std::min(2, this->cells) * (1 << level) + (this->cells > 2 ? 1 : 0);
  double largest = 1.0, before = 0.0;
  Vec3 x = this->points[0];
  for (int i = 1; i <= last; ++i)
  {
    const Vec3 next = this->at(i * step);
    const double cell = (next - x).norm();
    if (i > 1)
    {
      largest = std::max({ largest, cell / before, before / cell });
    }
    before = cell;
    x = next;
  }
  return largest;
}

WallColumn lineColumn(const std::vector<Vec3>& line, double e)
{
  WallColumn column;
  column.cells = static_cast<int>(line.size()) - 1;
  const int cells = column.cells;
  for (int a = 0; a < std::min(WallColumn::Depth, cells + 3); ++a)
  {
    column.points[a] = a == 0 ? line[0]
      : a == 1                ? Vec3(line[0] + e * (line[1] - line[0]))
      : a <= cells            ? line[a - 1]
      : a == cells + 1        ? Vec3((2.0 * line[cells] + line[cells - 1]) / 3.0)
                              : line[cells];
  }
  return column;
}

double neededFraction(const std::vector<Vec3>& line, double target, int level)
{
  const double near = lineColumn(line, 0.0).firstHeight(level);
  const double far = lineColumn(line, 1.0).firstHeight(level);
  return far > near ? (target - near) / (far - near) : -1.0;
}

double smoothFraction(const std::vector<Vec3>& line)
{
  const double first = (line[1] - line[0]).norm();
  const double second = line.size() > 2 ? (line[2] - line[1]).norm() : first;
  const double growth = first > 0.0 ? std::min(std::max(second / first, 0.2), 20.0) : 1.0;
  return 1.0 / (3.0 + std::log(growth));
}

} // namespace bsv
