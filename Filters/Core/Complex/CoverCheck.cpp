// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/CoverCheck.h"

#include "Base/BoxTree.h"
#include "Complex/BlockComplex.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace bsv
{

namespace
{

/// Opposite within 25 degrees.
bool facing(const Vec3& normalA, const Vec3& normalB)
{
  return normalA.dot(normalB) < -0.9;
}

} // namespace

void CoverCheck::operator()(const std::vector<Index>& single) const
{
  std::vector<Index> cover;
  Index first = -1;
  Index covered = 0;
  cover = this->covers(single);
  for (Index n = static_cast<Index>(single.size()) - 1; n >= 0; --n)
  {
    if (cover[n] >= 0)
    {
      first = n;
      ++covered;
    }
  }
  Index onAllRanks = 0;
  for (Index part : this->Ranks.gatherAll(std::vector<Index>{ covered }))
  {
    onAllRanks += part;
  }
  if (covered > 0)
  {
    const QuadAt a = this->Surface.quadAt(single[first]);
    const QuadAt b = this->Surface.quadAt(cover[first]);
    throw ErrorAt(single[first],
      "non-matching interface: " + this->where(a) + " and " + this->where(b) + " cover each other near " +
        text(this->center(a)) + " but do not share their points (" + std::to_string(onAllRanks) +
        " such quadrilaterals); declare them as boundaries if they are no contact");
  }
  this->Ranks.nextStep();
}

std::vector<Index> CoverCheck::covers(const std::vector<Index>& single) const
{
  const Index count = static_cast<Index>(single.size());
  const Index together = BoxTree::itemsPerBox(count);
  std::vector<Box> boxes((count + together - 1) / together);
  std::vector<double> tolerance(count);
  std::vector<Vec3> normal(count);
  this->Run.parallelFor(static_cast<Index>(boxes.size()), Chunk / together, [&](Index begin, Index end) {
    for (Index n = begin * together; n < std::min(count, end * together); ++n)
    {
      const QuadAt at = this->Surface.quadAt(single[n]);
      normal[n] = outwardNormal(this->Mesh, this->Surface, at, this->LeftHanded[at.block]).stableNormalized();
      tolerance[n] = std::numeric_limits<double>::max();
      Box box;
      for (int c = 0; c < 4; ++c)
      {
        const Ijk p = this->Surface.corner(at, c & 1, c >> 1);
        box.extend(this->Mesh.blocks[at.block].points(p));
        tolerance[n] = std::min(tolerance[n], this->tolerance(at.block, p));
      }
      boxes[n / together].extend(inflated(box, tolerance[n]));
    }
  });
  const BoxTree tree(boxes, count, together);
  std::vector<Index> cover(count, -1);
  const auto search = [&](Index begin, Index end) {
    for (Index n = begin; n < end; ++n)
    {
      const QuadAt at = this->Surface.quadAt(single[n]);
      if (!this->Part.isHere(at.block))
      {
        continue;
      }
      const Vec3 x = this->center(at);
      tree.search(Box(x), [&](Index m) {
        if (facing(normal[m], normal[n]) && (cover[n] < 0 || single[m] < cover[n]) &&
          this->covers(this->Surface.quadAt(single[m], at.block), normal[m], x, std::min(tolerance[n], tolerance[m])))
        {
          cover[n] = single[m];
        }
      });
    }
  };
  constexpr Index PerReport = 64 * Chunk;
  for (Index start = 0; start < count; start += PerReport)
  {
    this->Run.parallelFor(
      std::min(PerReport, count - start), Chunk, [&](Index begin, Index end) { search(start + begin, start + end); });
    this->Run.report(0.8 + 0.2 * start / count);
  }
  this->coverByCorners(single, normal, cover);
  return cover;
}

void CoverCheck::coverByCorners(
  const std::vector<Index>& single, const std::vector<Vec3>& normal, std::vector<Index>& cover) const
{
  const Index count = static_cast<Index>(single.size());
  // How many corners of a quadrilateral are shared, and with which one the last.
  std::vector<char> shared(count, 0);
  std::vector<Index> other(count, -1);
  std::vector<std::pair<Index, Index>> atClass;
  Index parts = 1;
  while (parts < 8 && parts * QuadsPerPart < count)
  {
    parts *= 2;
  }
  for (Index part = 0; part < parts; ++part)
  {
    atClass.clear();
    for (Index n = 0; n < count; ++n)
    {
      for (Index c : this->Classes.key(this->Surface.quadAt(single[n])))
      {
        if ((c & (parts - 1)) == part)
        {
          atClass.push_back({ c, n });
        }
      }
    }
    std::sort(atClass.begin(), atClass.end());
    this->Run.parallelFor(count, Chunk, [&](Index begin, Index end) {
      for (Index n = begin; n < end; ++n)
      {
        const QuadAt quad = this->Surface.quadAt(single[n]);
        if (!this->Part.isHere(quad.block))
        {
          continue;
        }
        const double size = (this->corner(quad, 0, 0) - this->corner(quad, 1, 1)).norm();
        const auto before = [&](Index m) {
          return facing(normal[m], normal[n]) &&
            this->covers(quad, normal[n], this->center(this->Surface.quadAt(single[m])), size);
        };
        const PointClasses::Key key = this->Classes.key(quad);
        for (int corner = 0; corner < 4; ++corner)
        {
          const Index c = key[corner];
          if ((c & (parts - 1)) != part)
          {
            continue;
          }
          auto at = std::lower_bound(atClass.begin(), atClass.end(), std::make_pair(c, Index(0)));
          while (at != atClass.end() && at->first == c && !before(at->second))
          {
            ++at;
          }
          if (at != atClass.end() && at->first == c)
          {
            ++shared[n];
            other[n] = corner == 3 ? at->second : other[n];
          }
        }
      }
    });
  }
  for (Index n = 0; n < count; ++n)
  {
    if (shared[n] == 4 && cover[n] < 0)
    {
      cover[n] = single[other[n]];
    }
  }
}

bool CoverCheck::covers(const QuadAt& at, const Vec3& n, const Vec3& x, double tolerance) const
{
  const std::array<Vec3, 4> corners{ this->corner(at, 0, 0), this->corner(at, 1, 0), this->corner(at, 1, 1),
    this->corner(at, 0, 1) };
  if (std::abs(n.dot(x - this->center(at))) > tolerance)
  {
    return false;
  }
  // A center on an edge counts, which is what half a cell of offset gives.
  constexpr double Margin = 1e-6;
  bool left = true;
  bool right = true;
  for (int c = 0; c < 4; ++c)
  {
    const Vec3 edge = corners[(c + 1) % 4] - corners[c];
    const double turn = n.dot(edge.cross(x - corners[c]));
    left = left && turn >= -Margin * edge.squaredNorm();
    right = right && turn <= Margin * edge.squaredNorm();
  }
  return left || right;
}

} // namespace bsv
