// SPDX-License-Identifier: BSD-3-Clause
#include "Volume/KnotInsertion.h"

#include <algorithm>

namespace bsv
{

namespace
{

/// The matrix of all knot insertions that give `knot` the multiplicity `degree`: rows of new control points over old
/// ones, from equation (5.15) applied once per knot.
struct Insertion
{
  std::vector<double> knots;
  /// Per new control point the old ones it is made of: first one and weights.
  std::vector<std::vector<double>> rows;
};

Insertion insertFully(int degree, const std::vector<double>& knots, double knot)
{
  Insertion result;
  result.knots = knots;
  const std::size_t count = knots.size() - degree - 1;
  result.rows.assign(count, std::vector<double>(count, 0.0));
  for (std::size_t i = 0; i < count; ++i)
  {
    result.rows[i][i] = 1.0;
  }
  while (std::count(result.knots.begin(), result.knots.end(), knot) < degree)
  {
    const std::vector<double>& t = result.knots;
    const int span = static_cast<int>(std::upper_bound(t.begin(), t.end(), knot) - t.begin()) - 1;
    const int multiplicity = static_cast<int>(std::count(t.begin(), t.end(), knot));
    std::vector<std::vector<double>> rows;
    for (int i = 0; i <= static_cast<int>(result.rows.size()); ++i)
    {
      if (i <= span - degree)
      {
        rows.push_back(result.rows[i]);
      }
      else if (i > span - multiplicity)
      {
        rows.push_back(result.rows[i - 1]);
      }
      else
      {
        const double a = (knot - t[i]) / (t[i + degree] - t[i]);
        std::vector<double> row(count);
        for (std::size_t n = 0; n < count; ++n)
        {
          row[n] = a * result.rows[i][n] + (1.0 - a) * result.rows[i - 1][n];
        }
        rows.push_back(row);
      }
    }
    result.rows = std::move(rows);
    result.knots.insert(result.knots.begin() + span + 1, knot);
  }
  return result;
}

} // namespace

std::array<OwnedVolume, 2> cutVolume(const BSplineVolume& volume, int direction, double knot)
{
  const int degree = volume.degree[direction];
  const std::vector<double>& old = volume.knots[direction];
  if (!(knot > old[degree] && knot < old[old.size() - degree - 1]))
  {
    throw Error("a block cannot be cut at " + std::to_string(knot) + ", which is not inside its knots");
  }
  const Insertion insertion = insertFully(degree, old, knot);
  const std::vector<double>& knots = insertion.knots;
  // The first of the `degree` knots at the cut; the control point before them lies on it.
  const int first = static_cast<int>(std::lower_bound(knots.begin(), knots.end(), knot) - knots.begin());
  std::array<OwnedVolume, 2> parts;
  const std::array<int, 3> counts{ volume.count(0), volume.count(1), volume.count(2) };
  for (int p = 0; p < 2; ++p)
  {
    OwnedVolume& part = parts[p];
    part.view = volume;
    part.view.points = nullptr;
    part.view.weights = nullptr;
    std::vector<double>& own = part.view.knots[direction];
    if (p == 0)
    {
      own.assign(knots.begin(), knots.begin() + first + degree);
      own.push_back(knot);
    }
    else
    {
      own.assign(knots.begin() + first, knots.end());
      own.insert(own.begin(), knot);
    }
    if (!volume.points)
    {
      continue;
    }
    const int begin = p == 0 ? 0 : first - 1;
    std::array<int, 3> size = counts;
    size[direction] = part.view.count(direction);
    const std::size_t total = static_cast<std::size_t>(size[0]) * size[1] * size[2];
    part.points.resize(3 * total);
    part.weights.resize(volume.weights ? total : 0);
    std::size_t at = 0;
    for (int k = 0; k < size[2]; ++k)
    {
      for (int j = 0; j < size[1]; ++j)
      {
        for (int i = 0; i < size[0]; ++i, ++at)
        {
          std::array<int, 3> q{ i, j, k };
          const std::vector<double>& row = insertion.rows[begin + q[direction]];
          double sum[4] = { 0.0, 0.0, 0.0, 0.0 };
          for (int n = 0; n < counts[direction]; ++n)
          {
            if (row[n] == 0.0)
            {
              continue;
            }
            q[direction] = n;
            const std::size_t source = q[0] + std::size_t(counts[0]) * (q[1] + std::size_t(counts[1]) * q[2]);
            const double weight = row[n] * (volume.weights ? volume.weights[source] : 1.0);
            for (int c = 0; c < 3; ++c)
            {
              sum[c] += weight * volume.points[3 * source + c];
            }
            sum[3] += weight;
          }
          for (int c = 0; c < 3; ++c)
          {
            part.points[3 * at + c] = volume.weights ? sum[c] / sum[3] : sum[c];
          }
          if (volume.weights)
          {
            part.weights[at] = sum[3];
          }
        }
      }
    }
    part.view.points = part.points.data();
    part.view.weights = volume.weights ? part.weights.data() : nullptr;
  }
  return parts;
}

} // namespace bsv
