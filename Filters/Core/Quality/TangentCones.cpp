// SPDX-License-Identifier: BSD-3-Clause
#include "Quality/TangentCones.h"

#include "Base/RowLoop.h"
#include "Volume/BezierSegments.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>

namespace bsv
{

namespace
{

constexpr int Points = 64, Layer = 16, Differences = 48, Lanes = 8;

/// Control points by component, with one direction slowest.
struct Net
{
  alignas(64) double x[3][Points];
};

/// Over all differences a along the slowest direction, by lanes: the least of (N a)_0 - |(N a)_1| - |(N a)_2|, and the
/// sum of |a|_1.
struct Cone
{
  alignas(64) double margin[Lanes];
  alignas(64) double size[Lanes];
};

BSV_ROW_LOOP void coneOf(const Net& net, const double (&n)[3][3], Cone& cone)
{
  for (int l = 0; l < Lanes; ++l)
  {
    cone.margin[l] = HUGE_VAL;
    cone.size[l] = 0.0;
  }
  for (int first = 0; first < Differences; first += Lanes)
  {
    const double* x = net.x[0] + first;
    const double* y = net.x[1] + first;
    const double* z = net.x[2] + first;
    for (int l = 0; l < Lanes; ++l)
    {
      const double a = x[l + Layer] - x[l];
      const double b = y[l + Layer] - y[l];
      const double c = z[l + Layer] - z[l];
      const double margin = (n[0][0] * a + n[0][1] * b + n[0][2] * c) -
        std::abs(n[1][0] * a + n[1][1] * b + n[1][2] * c) - std::abs(n[2][0] * a + n[2][1] * b + n[2][2] * c);
      cone.margin[l] = margin < cone.margin[l] ? margin : cone.margin[l];
      cone.size[l] += std::abs(a) + std::abs(b) + std::abs(c);
    }
  }
}

/// Mean direction of the differences along the slowest direction.
Vec3 meanDirection(const Net& net)
{
  Vec3 sum = Vec3::Zero();
  for (int c = 0; c < 3; ++c)
  {
    for (int i = 0; i < Layer; ++i)
    {
      sum[c] += net.x[c][3 * Layer + i] - net.x[c][i];
    }
  }
  return sum.normalized();
}

// Rounding. A component of a computed N a has at most 6 roundings per term, the margin 2 more, |N| <= 1 + 8 u: the
// margin is within 32 u |a|_1 of the exact one, u = 2^-53. N is what was computed, not exactly the adjugate; its
// determinant, about volume^2 > 2^-24, is wrong by less than 64 u.
bool isProven(const std::array<Net, 3>& nets, double sign)
{
  std::array<Vec3, 3> directions;
  for (int d = 0; d < 3; ++d)
  {
    directions[d] = meanDirection(nets[d]);
  }
  const double volume = sign * directions[0].dot(directions[1].cross(directions[2]));
  if (!(volume > 0x1p-12))
  {
    return false;
  }
  std::array<Vec3, 3> rows;
  for (int d = 0; d < 3; ++d)
  {
    rows[d] = sign * directions[(d + 1) % 3].cross(directions[(d + 2) % 3]);
  }
  double margins = 1.0, sizes = 1.0;
  for (int d = 0; d < 3; ++d)
  {
    double n[3][3];
    for (int r = 0; r < 3; ++r)
    {
      for (int c = 0; c < 3; ++c)
      {
        n[r][c] = rows[(d + r) % 3][c];
      }
    }
    Cone cone;
    coneOf(nets[d], n, cone);
    double margin = cone.margin[0], size = cone.size[0];
    for (int l = 1; l < Lanes; ++l)
    {
      margin = std::min(margin, cone.margin[l]);
      size += cone.size[l];
    }
    // Sizes at which nothing under- or overflows. Sums are not finite if any point is not.
    if (!(margin > 0x1p-46 * size && size > 0x1p-300 && size < 0x1p300))
    {
      return false;
    }
    margins *= margin;
    sizes *= size;
  }
  // |det| of a diagonally dominant matrix is at least the product of the margins, det N is volume^2; sizes are up to 48
  // times the largest difference.
  return margins > 0x1p-40 * volume * volume * sizes;
}

} // namespace

std::vector<bool> provenByTangentCones(const BSplineVolume& volume, const std::vector<Index>& spans, bool leftHanded)
{
  std::vector<bool> proven(spans.size(), false);
  if (volume.weights || volume.degree != std::array<int, 3>{ 3, 3, 3 })
  {
    return proven;
  }
  std::array<std::vector<int>, 3> along;
  for (int d = 0; d < 3; ++d)
  {
    along[d] = nonEmptySpans(3, volume.knots[d]);
  }
  const std::array<Index, 3> stride{ 3, 3 * Index(volume.count(0)), 3 * Index(volume.count(0)) * volume.count(1) };
  const Index n0 = static_cast<Index>(along[0].size()), n1 = static_cast<Index>(along[1].size());
  std::array<Net, 3> nets;
  for (std::size_t s = 0; s < spans.size(); ++s)
  {
    const Index span = spans[s];
    const double* first = volume.points + (along[0][span % n0] - 3) * stride[0] +
      (along[1][span / n0 % n1] - 3) * stride[1] + (along[2][span / n0 / n1] - 3) * stride[2];
    for (int k = 0; k < 4; ++k)
    {
      for (int j = 0; j < 4; ++j)
      {
        const double* from = first + j * stride[1] + k * stride[2];
        for (int i = 0; i < 4; ++i, from += 3)
        {
          for (int c = 0; c < 3; ++c)
          {
            nets[0].x[c][j + 4 * k + Layer * i] = from[c];
            nets[1].x[c][k + 4 * i + Layer * j] = from[c];
            nets[2].x[c][i + 4 * j + Layer * k] = from[c];
          }
        }
      }
    }
    proven[s] = isProven(nets, leftHanded ? -1.0 : 1.0);
  }
  return proven;
}

} // namespace bsv
