// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/FacesInCells.h"

#include "Base/CanonicalOrder.h"
#include "Mesh/BlockSurface.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <memory>
#include <tuple>

namespace bsv
{
namespace
{

struct Ray
{
  Triple from{ 0, 0, 0 };
  Triple along{ 0, 0, 0 };
  Index quad = -1;
};

/// +1 if the ray leaves through the triangle, whose corners run counter-clockwise seen from outside, -1 if it enters.
int crossing(const Vec3& from, const Vec3& along, const Vec3& a, const Vec3& b, const Vec3& c)
{
  const Vec3 ab = b - a, ac = c - a;
  const Vec3 p = along.cross(ac);
  const double determinant = ab.dot(p);
  if (determinant == 0.0)
  {
    return 0;
  }
  const Vec3 t = from - a;
  const double u = t.dot(p) / determinant;
  const Vec3 q = t.cross(ab);
  const double v = along.dot(q) / determinant;
  if (!(u >= 0.0 && v >= 0.0 && u + v <= 1.0 && ac.dot(q) / determinant > 0.0))
  {
    return 0;
  }
  return determinant < 0.0 ? 1 : -1;
}

bool meetsRay(const Box& box, const Vec3& from, const Vec3& inverse)
{
  double first = 0.0, last = std::numeric_limits<double>::infinity();
  for (int d = 0; d < 3; ++d)
  {
    const double a = (box.min()[d] - from[d]) * inverse[d], b = (box.max()[d] - from[d]) * inverse[d];
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
  return first <= last;
}

/// Directions that no mesh is likely to have.
Vec3 rayDirection(const Vec3& normal, int attempt)
{
  static const Vec3 tilts[3] = { Vec3(0.31830988, -0.20787957, 0.27182818), Vec3(-0.26179938, 0.34657359, 0.11503837),
    Vec3(0.14142135, 0.23570226, -0.36787944) };
  return normal + tilts[attempt];
}

class OverlapSearch
{
public:
  OverlapSearch(const OuterSurface& surface, const OuterTiles& tiles, const Execution& run, MeshFindings& findings)
    : Surface(surface)
    , Tiles(tiles)
    , Run(run)
    , Others(*run.ranks)
    , Findings(findings)
  {
  }

  void operator()()
  {
    std::vector<Box> boxes;
    for (Index n = 0; n < this->Tiles.size(); ++n)
    {
      if (this->isHere(this->Tiles.tile(n).face))
      {
        this->OwnTiles.push_back(n);
        boxes.push_back(this->Tiles.shape(n).box());
      }
    }
    this->OwnTree = std::make_unique<BoxTree>(boxes);

    std::vector<Index> samples;
    for (const int face : this->Surface.faces())
    {
      if (!this->isHere(face) || !this->Surface.unnamed(face))
      {
        continue;
      }
      const auto positions = [&](int axis) {
        const int last = this->Surface.cells(face, axis) - 1;
        std::vector<int> result{ 0, last / 2, last - last / 2, last };
        std::sort(result.begin(), result.end());
        result.erase(std::unique(result.begin(), result.end()), result.end());
        return result;
      };
      for (const int t : positions(1))
      {
        for (const int s : positions(0))
        {
          this->appendFree({ face, s, t }, samples);
        }
      }
    }
    const std::vector<Index> hits = this->inside(samples);
    if (!this->Others.any(!hits.empty()))
    {
      return;
    }
    std::vector<int> faces;
    for (const Index quad : hits)
    {
      faces.push_back(this->Surface.quadAt(quad).face);
    }
    std::sort(faces.begin(), faces.end());
    faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
    std::vector<Index> quads;
    for (const int face : faces)
    {
      for (Index quad = this->Surface.firstQuad(face); quad < this->Surface.firstQuad(face + 1); ++quad)
      {
        this->appendFree(this->Surface.quadAt(quad), quads);
      }
    }
    std::vector<Ray> rays;
    for (const Index quad : this->inside(quads))
    {
      rays.push_back(this->rayFrom(this->Surface.quadAt(quad), 0));
    }
    rays = this->Others.size() == 1 ? rays : this->Others.gatherAll(rays);
    std::sort(rays.begin(), rays.end(), [](const Ray& a, const Ray& b) { return a.quad < b.quad; });
    // Of each face the first quadrilateral says in which block it lies.
    std::map<int, std::vector<const Ray*>> ofFace;
    for (const Ray& ray : rays)
    {
      ofFace[this->Surface.quadAt(ray.quad).face].push_back(&ray);
    }
    std::map<std::tuple<int, int, int>, MeshFinding> findings;
    std::map<std::tuple<int, int, int>, std::vector<Index>> concerned;
    for (const auto& [face, found] : ofFace)
    {
      const FaceUse& use = this->Surface.use(face);
      const std::tuple<int, int, int> key(
        this->Findings.parent(face), use.face, this->blockAround(*found.front(), use.block));
      MeshFinding& finding = findings[key];
      finding.kind = MeshFindingKind::Overlap;
      finding.blocks = { std::get<0>(key), std::get<2>(key) };
      finding.faces = { use.face, -1 };
      for (const Ray* ray : found)
      {
        const Vec3 place = vec3(ray->from);
        finding.place = finding.quads == 0 || comesBefore(place, finding.place) ? place : finding.place;
        ++finding.quads;
        concerned[key].push_back(ray->quad);
      }
    }
    for (const auto& [key, finding] : findings)
    {
      const int number = this->Findings.add(finding);
      for (const Index quad : concerned[key])
      {
        this->Findings.mark(quad, number);
      }
    }
  }

private:
  bool isHere(int face) const { return this->Surface.rankOf(face) == this->Others.rank(); }

  Ray rayFrom(const OuterQuad& at, int attempt) const
  {
    const OuterCell cell = this->Surface.cell(at);
    return { triple(cell.center()), triple(rayDirection(cell.area().stableNormalized(), attempt)),
      this->Surface.quad(at) };
  }

  /// How often more each ray leaves cells than it enters them.
  std::vector<int> windings(const std::vector<Ray>& rays) const
  {
    const Index count = static_cast<Index>(rays.size());
    std::vector<int> result(count, 0);
    this->Run.parallelFor(count, 16, [&](Index begin, Index end) {
      for (Index n = begin; n < end; ++n)
      {
        const Vec3 from = vec3(rays[n].from), along = vec3(rays[n].along);
        const Vec3 inverse = along.cwiseInverse();
        this->OwnTree->searchIf([&](const Box& box) { return meetsRay(box, from, inverse); },
          [&](Index tile) {
            if (meetsRay(this->Tiles.shape(this->OwnTiles[tile]).box(), from, inverse))
            {
              result[n] += this->crossings(this->Tiles.tile(this->OwnTiles[tile]), from, along, rays[n].quad);
            }
          });
      }
    });
    if (this->Others.size() > 1)
    {
      const std::vector<std::vector<int>> parts = this->Others.gather(result);
      std::fill(result.begin(), result.end(), 0);
      for (const std::vector<int>& part : parts)
      {
        for (Index n = 0; n < count; ++n)
        {
          result[n] += part[n];
        }
      }
    }
    return result;
  }

  int crossings(const Tile& tile, const Vec3& from, const Vec3& along, Index except) const
  {
    const FaceUse& use = this->Surface.use(tile.face);
    const ComplexBlock& block = this->Surface.complex().blocks[use.block];
    const int normal = faceDirection(use.face);
    const double sign = ((normal == 1) != (faceSide(use.face) == 1)) != block.leftHanded ? 1.0 : -1.0;
    const Ijk cells{ block.cells(0), block.cells(1), block.cells(2) };
    std::array<std::array<Vec3, TileSize + 1>, 2> rows;
    const auto read = [&](int t) {
      for (int s = tile.s0; s <= tile.s1; ++s)
      {
        rows[t & 1][s - tile.s0] = block.points(facePoint(cells, use.face, s, t));
      }
    };
    int sum = 0;
    read(tile.t0);
    for (int t = tile.t0; t < tile.t1; ++t)
    {
      read(t + 1);
      for (int s = tile.s0; s < tile.s1; ++s)
      {
        if (this->Surface.quad({ tile.face, s, t }) == except)
        {
          continue;
        }
        const Vec3 &p00 = rows[t & 1][s - tile.s0], &p10 = rows[t & 1][s - tile.s0 + 1];
        const Vec3 &p01 = rows[(t + 1) & 1][s - tile.s0], &p11 = rows[(t + 1) & 1][s - tile.s0 + 1];
        sum += crossing(from, along, p00, p10, p11) + crossing(from, along, p00, p11, p01);
      }
    }
    return sign > 0.0 ? sum : -sum;
  }

  /// Of these quadrilaterals those that lie in other cells: all three rays say so.
  std::vector<Index> inside(const std::vector<Index>& mine) const
  {
    std::vector<Index> open = mine;
    for (int attempt = 0; attempt < 3; ++attempt)
    {
      std::vector<Ray> rays;
      for (const Index quad : open)
      {
        rays.push_back(this->rayFrom(this->Surface.quadAt(quad), attempt));
      }
      const std::vector<Ray> all = this->Others.size() == 1 ? rays : this->Others.gatherAll(rays);
      const std::vector<int> counts = this->windings(all);
      open.clear();
      for (std::size_t n = 0; n < all.size(); ++n)
      {
        if (counts[n] > 0 && this->isHere(this->Surface.quadAt(all[n].quad).face))
        {
          open.push_back(all[n].quad);
        }
      }
    }
    return open;
  }

  void appendFree(const OuterQuad& at, std::vector<Index>& quads) const
  {
    if (collapsed(this->Surface.cell(at)))
    {
      return;
    }
    const Index quad = this->Surface.quad(at);
    if (!this->Findings.isSuspicious(quad))
    {
      quads.push_back(quad);
    }
  }

  /// The first input block, other than that of `own` if possible, in which a ray starts; -1 if none. Collective.
  int blockAround(const Ray& ray, int own) const
  {
    const Vec3 from = vec3(ray.from), along = vec3(ray.along);
    int found = -1;
    for (int b = 0; b < static_cast<int>(this->Surface.complex().blocks.size()) && found < 0; ++b)
    {
      if (b == own || this->Surface.complex().blocks[b].rank != this->Others.rank())
      {
        continue;
      }
      found = this->isInside(b, from, along) ? this->Surface.complex().blocks[b].parent : -1;
    }
    if (this->Others.size() > 1)
    {
      for (const int other : this->Others.gatherAll(std::vector<int>{ found }))
      {
        found = found < 0 || (other >= 0 && other < found) ? other : found;
      }
    }
    return found;
  }

  bool isInside(int b, const Vec3& from, const Vec3& along) const
  {
    const ComplexBlock& block = this->Surface.complex().blocks[b];
    const Ijk cells{ block.cells(0), block.cells(1), block.cells(2) };
    int sum = 0;
    for (int face = 0; face < 6; ++face)
    {
      const bool outwards = ((faceDirection(face) == 1) != (faceSide(face) == 1)) != block.leftHanded;
      int part = 0;
      for (int t = 0; t < cells[faceAxis(face, 1)]; ++t)
      {
        for (int s = 0; s < cells[faceAxis(face, 0)]; ++s)
        {
          const auto at = [&](int ds, int dt) { return block.points(facePoint(cells, face, s + ds, t + dt)); };
          part +=
            crossing(from, along, at(0, 0), at(1, 0), at(1, 1)) + crossing(from, along, at(0, 0), at(1, 1), at(0, 1));
        }
      }
      sum += outwards ? part : -part;
    }
    return sum > 0;
  }

  const OuterSurface& Surface;
  const OuterTiles& Tiles;
  const Execution& Run;
  const Ranks& Others;
  MeshFindings& Findings;
  std::vector<Index> OwnTiles;
  std::unique_ptr<BoxTree> OwnTree;
};

} // namespace

void findFacesInCells(
  const OuterSurface& surface, const OuterTiles& tiles, const Execution& run, MeshFindings& findings)
{
  OverlapSearch(surface, tiles, run, findings)();
}

} // namespace bsv
