// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/PointClasses.h"

#include "Base/BoxTree.h"
#include "Base/FirstOccurrence.h"
#include "Complex/BlockComplex.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace bsv
{

Vec3 PointClasses::pointOf(Index point) const
{
  const int block = this->Points->blockOfPoint(point);
  return this->Mesh.blocks[block].points(this->Points->pointAt(block, point));
}

void PointClasses::mergeEqualPoints(const std::vector<Index>& quads)
{
  std::vector<char> blocks(this->Surface.blockCount(), false);
  QuadAt at;
  for (Index quad : quads)
  {
    at = this->Surface.quadAt(quad, at.block);
    blocks[at.block] = true;
  }
  this->Points.emplace(this->Mesh, &blocks);
  this->Class.assign(this->Points->pointCount(), -1);
  Index count = 0;
  this->forEachPoint(quads, [&](int, const Ijk&, Index) { ++count; });
  FirstOccurrence first(count);
  this->forEachPoint(quads, [&](int block, const Ijk& p, Index point) {
    const Vec3 x = this->Mesh.blocks[block].points(p);
    this->Class[point] = first.insert(hashOf(x), point, [&](Index other) { return this->pointOf(other) == x; });
  });
}

PointClasses::Key PointClasses::key(const QuadAt& at) const
{
  Key classes = this->Points->corners(at);
  for (Index& c : classes)
  {
    c = this->Class[c];
  }
  return classes;
}

void PointClasses::pairQuads(const std::vector<Index>& quads)
{
  FirstOccurrence first(static_cast<Index>(quads.size()));
  int hint = 0;
  for (Index quad : quads)
  {
    const QuadAt at = this->Surface.quadAt(quad, hint);
    hint = at.block;
    const Key classes = this->key(at);
    Key sorted = classes;
    std::sort(sorted.begin(), sorted.end());
    if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end())
    {
      if (!this->Options.allowDegenerate)
      {
        throw ErrorAt(quad,
          this->where(at) + " is collapsed: two of its points coincide near " + text(this->center(at)) +
            "; Allow Degenerate accepts it");
      }
      this->Result.setBoundary(at, -1);
      continue;
    }
    std::uint64_t hash = 0;
    for (Index c : sorted)
    {
      hash = mix(hash, static_cast<std::uint64_t>(c));
    }
    const Index earlier = first.insert(hash, quad, [&](Index other) {
      Key others = this->key(this->Surface.quadAt(other, at.block));
      std::sort(others.begin(), others.end());
      return others == sorted;
    });
    if (earlier == quad)
    {
      continue;
    }
    const QuadAt partner = this->Surface.quadAt(earlier, at.block);
    if (!this->Result.undecided(partner))
    {
      throw ErrorAt(quad,
        "ambiguous gluing: " + this->where(partner) + ", " + this->where(this->Result.partner(partner)) + " and " +
          this->where(at) + " are at the same place near " + text(this->center(at)));
    }
    this->Result.setContact(partner, at, this->orientation(partner, quad, classes));
  }
}

int PointClasses::orientation(const QuadAt& a, Index quadB, const Key& b) const
{
  const Key classes = this->key(a);
  for (int code = 0; code < 8; ++code)
  {
    bool fits = true;
    for (int c = 0; c < 4; ++c)
    {
      const auto onB = mapFacePoint(code, c & 1, c >> 1, 1, 1);
      fits = fits && classes[c] == b[onB[0] + 2 * onB[1]];
    }
    if (fits)
    {
      return code;
    }
  }
  throw ErrorAt(quadB, "ambiguous gluing: " + this->where(a) + " shares its four points with a twisted quadrilateral");
}

bool PointClasses::mergeNearPoints(const std::vector<Index>& quads, const std::vector<Index>& single)
{
  std::vector<Index> points;
  this->forEachPoint(single, [&](int, const Ijk&, Index point) { points.push_back(this->Class[point]); });
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  const Index count = static_cast<Index>(points.size());
  const auto slotOf = [&](Index representative) {
    const auto at = std::lower_bound(points.begin(), points.end(), representative);
    return at != points.end() && *at == representative ? Index(at - points.begin()) : Index(-1);
  };

  // The tolerance of a class is that of its most finely spaced member, wherever that is.
  std::vector<double> tolerance(count, std::numeric_limits<double>::max());
  std::vector<bool> wanted(this->Points->pointCount());
  for (Index point : points)
  {
    wanted[point] = true;
  }
  std::vector<char> here(count, false);
  this->forEachPoint(quads, [&](int block, const Ijk& p, Index point) {
    if (wanted[this->Class[point]])
    {
      const Index slot = slotOf(this->Class[point]);
      tolerance[slot] = std::min(tolerance[slot], this->tolerance(block, p));
      here[slot] |= this->Part.isHere(block);
    }
  });

  std::vector<Vec3> x(count);
  const Index together = BoxTree::itemsPerBox(count);
  std::vector<Box> boxes((count + together - 1) / together);
  for (Index n = 0; n < count; ++n)
  {
    x[n] = this->pointOf(points[n]);
    boxes[n / together].extend(x[n]);
  }
  const BoxTree tree(boxes, count, together);
  std::vector<std::vector<std::pair<Index, Index>>> chunks((count + Chunk - 1) / Chunk);
  std::vector<char> crowded(count, false);
  this->Run.parallelFor(static_cast<Index>(chunks.size()), 1, [&](Index begin, Index end) {
    for (Index chunk = begin; chunk < end; ++chunk)
    {
      for (Index n = chunk * Chunk; n < std::min(count, (chunk + 1) * Chunk); ++n)
      {
        int found = 0;
        tree.search(inflated(Box(x[n]), tolerance[n]), [&](Index m) {
          if (m > n && (here[m] || here[n]) && (x[m] - x[n]).norm() <= std::min(tolerance[m], tolerance[n]) &&
            found < MostCopies)
          {
            chunks[chunk].push_back({ n, m });
            ++found;
          }
        });
        crowded[n] = found == MostCopies;
      }
    }
  });

  for (Index n = 0; n < count; ++n)
  {
    if (crowded[n])
    {
      throw ErrorAt(this->place(points[n]),
        "ambiguous gluing near " + text(x[n]) + ": more than " + std::to_string(MostCopies) + " points within " +
          text(tolerance[n]) + " of a point of " + blockLabel(this->Mesh, this->Points->blockOfPoint(points[n])));
    }
  }

  UnionFind merged(count);
  bool any = false;
  for (const auto& pairs : chunks)
  {
    for (const auto& pair : pairs)
    {
      merged.unite(pair.first, pair.second);
      any = true;
    }
  }
  if (any)
  {
    this->checkWidths(points, x, tolerance, merged);
    for (Index& c : this->Class)
    {
      if (c >= 0 && wanted[c])
      {
        c = points[merged.find(slotOf(c))];
      }
    }
  }
  return any;
}

Index PointClasses::place(Index point) const
{
  const int block = this->Points->blockOfPoint(point);
  return this->Surface.point(block, this->Points->pointAt(block, point));
}

void PointClasses::checkWidths(const std::vector<Index>& points, const std::vector<Vec3>& x,
  const std::vector<double>& tolerance, UnionFind& merged) const
{
  const Index count = static_cast<Index>(points.size());
  std::vector<Box> extent(count);
  std::vector<double> smallest(count, std::numeric_limits<double>::max());
  for (Index n = 0; n < count; ++n)
  {
    const Index root = merged.find(n);
    extent[root].extend(x[n]);
    smallest[root] = std::min(smallest[root], tolerance[n]);
  }
  for (Index n = 0; n < count; ++n)
  {
    const Index root = merged.find(n);
    if (root != n && extent[root].diagonal().norm() > smallest[root])
    {
      throw ErrorAt(this->place(points[n]),
        "ambiguous gluing near " + text(x[n]) + ": points of " +
          blockLabel(this->Mesh, this->Points->blockOfPoint(points[root])) + " and " +
          blockLabel(this->Mesh, this->Points->blockOfPoint(points[n])) + " form a chain of width " +
          text(extent[root].diagonal().norm()) + ", allowed is " + text(smallest[root]));
    }
  }
}

} // namespace bsv
