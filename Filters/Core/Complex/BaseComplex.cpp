// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/BaseComplex.h"

#include "Base/UnionFind.h"
#include "Complex/HexFrames.h"
#include "Mesh/BlockSurface.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <memory>

namespace bsv
{

namespace
{

/// Lexicographic order of places: negative, zero or positive.
int order(const Vec3& a, const Vec3& b)
{
  for (int d = 0; d < 3; ++d)
  {
    if (a[d] != b[d])
    {
      return a[d] < b[d] ? -1 : 1;
    }
  }
  return 0;
}

/// Cells that are connected without crossing a separation surface.
struct Region
{
  /// Its cells are Order[begin, end).
  Index begin = 0;
  Index end = 0;
  /// Their places, both ends included.
  Ijk lowest{ 0, 0, 0 };
  Ijk highest{ 0, 0, 0 };
  /// Whether it closes on itself: no places fit all contacts.
  bool closed = false;
};

class Decomposition
{
public:
  Decomposition(HexMesh& mesh, const BaseComplexOptions& options, const Execution& run)
    : Mesh(mesh)
    , Options(options)
    , Run(run)
    , Frames(HexFrames::instance())
  {
  }

  BaseComplex decompose()
  {
    this->Neighbours = findNeighbours(this->Mesh, this->Options.neighbours, this->part(0.0, 0.5));
    this->Result.notes = std::move(this->Neighbours.notes);
    this->Result.warnings = std::move(this->Neighbours.warnings);
    const std::size_t faces = 6 * static_cast<std::size_t>(this->Mesh.cellCount());
    this->Separating.reset(new std::atomic<std::uint8_t>[faces]);
    for (std::size_t face = 0; face < faces; ++face)
    {
      this->Separating[face].store(0, std::memory_order_relaxed);
    }
    this->findSingularEdges();
    this->Run.report(0.6);
    for (HexId face = 0; face < faces; ++face)
    {
      if (this->separates(face))
      {
        this->Front.push_back(face);
      }
    }
    this->spread();
    this->Run.report(0.65);
    this->flood();
    this->openClosedRegions();
    this->Run.report(0.75);
    this->makeBlocks();
    if (this->Options.mergeBlocks)
    {
      this->mergeBlocks();
    }
    this->Run.report(0.9);
    this->makeContacts();
    this->tell();
    this->Run.report(1.0);
    return std::move(this->Result);
  }

private:
  Execution part(double from, double to) const
  {
    Execution result = this->Run;
    const auto progress = this->Run.progress;
    result.progress = [=](double fraction) { return progress(from + fraction * (to - from)); };
    return result;
  }

  Vec3 point(HexId id) const { return this->Mesh.points.atOffset(id); }
  HexId corner(HexId cell, int corner) const { return this->Mesh.corners[8 * Index(cell) + corner]; }
  std::string cell(Index cell) const { return this->Mesh.cellName(cell); }
  HexId next(HexId face) const { return this->Neighbours.next[face]; }
  bool separates(HexId face) const { return this->Separating[face].load(std::memory_order_relaxed) != 0; }
  void separate(HexId face) const { this->Separating[face].store(1, std::memory_order_relaxed); }
  /// Whether the region of a cell ends at the face.
  bool ends(HexId face) const { return this->next(face) == NoHexId || this->separates(face); }

  int cornerAcross(HexId face, int corner) const
  {
    const HexId other = this->next(face);
    return this->Frames.cornerAcross(
      static_cast<int>(face % 6), static_cast<int>(other % 6), this->Neighbours.orientation[face], corner);
  }
  int edgeAcross(HexId face, int edge) const
  {
    const HexId other = this->next(face);
    return this->Frames.edgeAcross(
      static_cast<int>(face % 6), static_cast<int>(other % 6), this->Neighbours.orientation[face], edge);
  }
  int frameAcross(int frame, HexId face) const
  {
    return this->Frames.across(
      frame, static_cast<int>(face % 6), static_cast<int>(this->next(face) % 6), this->Neighbours.orientation[face]);
  }

  /// Looks at the cells around every point: refuses those that share no face there, and makes the faces at singular
  /// edges separating.
  void findSingularEdges()
  {
    const Index points = this->Mesh.pointCount();
    std::vector<HexId> start(points + 1, 0);
    for (HexId p : this->Mesh.corners)
    {
      ++start[p];
    }
    HexId sum = 0;
    for (HexId& first : start)
    {
      sum += first;
      first = sum;
    }
    // Corners 8 * cell + corner at each point, ascending.
    std::vector<HexId> corners(sum);
    for (Index n = static_cast<Index>(this->Mesh.corners.size()) - 1; n >= 0; --n)
    {
      corners[--start[this->Mesh.corners[n]]] = static_cast<HexId>(n);
    }
    std::atomic<Index> singular{ 0 };
    this->Run.parallelFor(points, 1 << 13, [&](Index begin, Index end) {
      OneRing ring;
      Index found = 0;
      for (Index p = begin; p < end; ++p)
      {
        found += this->lookAround(static_cast<HexId>(p), corners.data() + start[p], start[p + 1] - start[p], ring);
      }
      singular += found;
    });
    this->Result.singularEdges = singular;
  }

  struct OneRing
  {
    std::vector<int> parent;
    /// The other end of an edge, and 16 * cell + edge.
    std::vector<std::pair<HexId, std::uint64_t>> edges;
  };

  /// @return the number of singular edges to points of higher numbers
  Index lookAround(HexId p, const HexId* corners, HexId count, OneRing& ring)
  {
    ring.parent.resize(count);
    for (HexId n = 0; n < count; ++n)
    {
      ring.parent[n] = static_cast<int>(n);
    }
    const auto root = [&](int n) {
      while (ring.parent[n] != n)
      {
        n = ring.parent[n] = ring.parent[ring.parent[n]];
      }
      return n;
    };
    HexId parts = count;
    ring.edges.clear();
    for (HexId n = 0; n < count; ++n)
    {
      const HexId cell = corners[n] / 8;
      const int v = static_cast<int>(corners[n] % 8);
      for (int d = 0; d < 3; ++d)
      {
        const HexId other = this->corner(cell, v ^ (1 << d));
        if (other > p)
        {
          ring.edges.push_back({ other, 16 * std::uint64_t(cell) + this->Frames.cornerEdge(v, d) });
        }
        const HexId face = 6 * cell + 2 * d + cornerSide(v, d);
        const HexId behind = this->next(face);
        if (behind != NoHexId && behind > face)
        {
          const HexId wanted = 8 * (behind / 6) + this->cornerAcross(face, v);
          const int m = static_cast<int>(std::lower_bound(corners, corners + count, wanted) - corners);
          const int a = root(static_cast<int>(n));
          const int b = root(m);
          parts -= a != b;
          ring.parent[a] = b;
        }
      }
    }
    if (parts > 1 && count > 0)
    {
      const int first = root(0);
      HexId other = 1;
      while (root(static_cast<int>(other)) == first)
      {
        ++other;
      }
      throw Error(this->cell(corners[0] / 8) + " and " + this->cell(corners[other] / 8) + " meet at the point " +
        std::to_string(p) + ", near " + text(this->point(p)) +
        ", but no cells around it connect them: the mesh is not a manifold there");
    }

    std::sort(ring.edges.begin(), ring.edges.end());
    Index singular = 0;
    for (std::size_t begin = 0, end = 0; begin < ring.edges.size(); begin = end)
    {
      int contacts = 0; // each from both sides
      for (end = begin; end < ring.edges.size() && ring.edges[end].first == ring.edges[begin].first; ++end)
      {
        for (int side = 0; side < 2; ++side)
        {
          contacts += this->next(this->faceAt(ring.edges[end].second, side)) != NoHexId;
        }
      }
      const int cells = static_cast<int>(end - begin);
      const bool inside = contacts == 2 * cells;
      if (contacts < 2 * (cells - 1))
      {
        this->refuseEdge(p, ring, begin, end);
      }
      if (inside ? cells == 4 : cells <= 2)
      {
        continue;
      }
      ++singular;
      for (std::size_t n = begin; n < end; ++n)
      {
        for (int side = 0; side < 2; ++side)
        {
          const HexId face = this->faceAt(ring.edges[n].second, side);
          if (this->next(face) != NoHexId)
          {
            this->separate(face);
          }
        }
      }
    }
    return singular;
  }

  /// One of the two faces at an edge 16 * cell + edge.
  HexId faceAt(std::uint64_t edge, int side) const
  {
    return static_cast<HexId>(edge / 16) * 6 + this->Frames.edgeFace(static_cast<int>(edge % 16), side);
  }

  [[noreturn]] void refuseEdge(HexId p, const OneRing& ring, std::size_t begin, std::size_t end) const
  {
    std::string cells;
    for (std::size_t n = begin; n < end; ++n)
    {
      cells += (n == begin        ? ""
                   : n + 1 == end ? " and "
                                  : ", ") +
        this->cell(static_cast<Index>(ring.edges[n].second / 16));
    }
    throw Error(cells + " meet at the edge between the points " + std::to_string(p) + " and " +
      std::to_string(ring.edges[begin].first) + ", near " + text(this->point(p)) +
      ", but some share no face there: the mesh is not a manifold there");
  }

  /// Calls visit(face) for the faces that continue `face` over its four edges, `cross(face)` being faces on the way
  /// that may be crossed.
  template <typename MayCross, typename Visit>
  void forEachContinuation(HexId face, const MayCross& mayCross, const Visit& visit) const
  {
    const int f = static_cast<int>(face % 6);
    for (int axis = 0; axis < 2; ++axis)
    {
      for (int side = 0; side < 2; ++side)
      {
        const int edge = faceEdge(f, axis, side);
        const HexId between = face - f + this->Frames.otherFace(edge, f);
        if (this->next(between) == NoHexId || !mayCross(between))
        {
          continue;
        }
        const HexId behind = this->next(between);
        const int edgeBehind = this->edgeAcross(between, edge);
        const HexId opposite = behind - behind % 6 + this->Frames.otherFace(edgeBehind, static_cast<int>(behind % 6));
        if (this->next(opposite) != NoHexId)
        {
          visit(opposite);
        }
      }
    }
  }

  /// Continues the separation surfaces from Front. At a singular edge all faces are separating already.
  void spread()
  {
    while (!this->Front.empty())
    {
      const HexId face = this->Front.back();
      this->Front.pop_back();
      this->forEachContinuation(
        face, [](HexId) { return true; },
        [&](HexId opposite) {
          if (!this->separates(opposite))
          {
            this->separate(opposite);
            this->separate(this->next(opposite));
            this->Front.push_back(opposite);
          }
        });
    }
  }

  /// Gives all cells a region, a place and a frame.
  void flood()
  {
    const HexId cells = static_cast<HexId>(this->Mesh.cellCount());
    this->RegionOf.assign(cells, NoHexId);
    this->PlaceOf.resize(cells);
    this->FrameOf.resize(cells);
    this->Order.resize(cells);
    Index at = 0;
    for (HexId cell = 0; cell < cells; ++cell)
    {
      if (this->RegionOf[cell] == NoHexId)
      {
        at = this->flood(cell, at);
      }
    }
  }

  /// Floods one region from a cell; its cells become Order[at, result).
  Index flood(HexId seed, Index at)
  {
    const HexId number = static_cast<HexId>(this->Regions.size());
    Region region;
    region.begin = at;
    this->RegionOf[seed] = number;
    this->PlaceOf[seed] = { 0, 0, 0 };
    this->FrameOf[seed] = 0;
    this->Order[at] = seed;
    region.end = at + 1;
    for (Index n = at; n < region.end; ++n)
    {
      const HexId cell = this->Order[n];
      const Frame& frame = this->Frames[this->FrameOf[cell]];
      for (int f = 0; f < 6; ++f)
      {
        const HexId face = 6 * cell + f;
        if (this->ends(face))
        {
          continue;
        }
        const HexId behind = this->next(face) / 6;
        Ijk place = this->PlaceOf[cell];
        const int d = faceDirection(f);
        place[frame.axis[d]] += faceSide(f) ? frame.sign[d] : -frame.sign[d];
        const int frameBehind = this->frameAcross(this->FrameOf[cell], face);
        if (this->RegionOf[behind] == NoHexId)
        {
          this->RegionOf[behind] = number;
          this->PlaceOf[behind] = place;
          this->FrameOf[behind] = static_cast<std::uint8_t>(frameBehind);
          this->Order[region.end++] = behind;
          for (int axis = 0; axis < 3; ++axis)
          {
            region.lowest[axis] = std::min(region.lowest[axis], place[axis]);
            region.highest[axis] = std::max(region.highest[axis], place[axis]);
          }
        }
        else if (this->PlaceOf[behind] != place || this->FrameOf[behind] != frameBehind)
        {
          region.closed = true;
        }
      }
    }
    this->Regions.push_back(region);
    return region.end;
  }

  /// A face of a cell as seen from any numbering.
  struct FaceKey
  {
    std::array<Vec3, 4> points{ Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero() };

    int compare(const FaceKey& other) const
    {
      for (int c = 0; c < 4; ++c)
      {
        if (const int o = order(this->points[c], other.points[c]))
        {
          return o;
        }
      }
      return 0;
    }
  };

  FaceKey keyOf(HexId face) const
  {
    FaceKey key;
    const int f = static_cast<int>(face % 6);
    for (int c = 0; c < 4; ++c)
    {
      key.points[c] = this->point(this->corner(face / 6, faceCorner(f, c & 1, c >> 1)));
    }
    std::sort(key.points.begin(), key.points.end(), [](const Vec3& a, const Vec3& b) { return order(a, b) < 0; });
    return key;
  }

  /// A surface that would cut a closed region.
  struct Sheet
  {
    HexId region;
    HexId face = NoHexId;
    Index size = 0;
    FaceKey key;

    bool before(const Sheet& other) const
    {
      return this->size != other.size ? this->size < other.size : this->key.compare(other.key) < 0;
    }
  };

  /// Cuts regions that close on themselves until none does.
  void openClosedRegions()
  {
    for (bool first = true;; first = false)
    {
      std::vector<Sheet> sheets;
      for (HexId r = 0; r < this->Regions.size(); ++r)
      {
        if (this->Regions[r].closed)
        {
          sheets.push_back(this->bestSheet(r));
        }
      }
      this->Result.closedRegions += first ? static_cast<Index>(sheets.size()) : 0;
      if (sheets.empty())
      {
        return;
      }
      std::sort(sheets.begin(), sheets.end(), [](const Sheet& a, const Sheet& b) {
        const int o = a.key.compare(b.key);
        return o != 0 ? o < 0 : a.size < b.size;
      });
      std::vector<char> touched(this->Regions.size(), false);
      for (const Sheet& sheet : sheets)
      {
        // Surfaces that were cut for others may have cut this one.
        if (touched[sheet.region])
        {
          continue;
        }
        std::vector<HexId> faces{ sheet.face };
        this->separate(sheet.face);
        this->separate(this->next(sheet.face));
        for (std::size_t n = 0; n < faces.size(); ++n)
        {
          touched[this->RegionOf[faces[n] / 6]] = true;
          touched[this->RegionOf[this->next(faces[n]) / 6]] = true;
          this->forEachContinuation(
            faces[n], [](HexId) { return true; },
            [&](HexId opposite) {
              if (!this->separates(opposite))
              {
                this->separate(opposite);
                this->separate(this->next(opposite));
                faces.push_back(opposite);
              }
            });
        }
      }
      this->floodAgain(touched);
    }
  }

  /// Floods the cells of some regions once more.
  void floodAgain(const std::vector<char>& touched)
  {
    std::vector<Region> before;
    before.swap(this->Regions);
    const std::vector<HexId> cells = this->Order;
    for (std::size_t r = 0; r < before.size(); ++r)
    {
      const Region& region = before[r];
      if (!touched[r])
      {
        for (Index n = region.begin; n < region.end; ++n)
        {
          this->RegionOf[cells[n]] = static_cast<HexId>(this->Regions.size());
        }
        this->Regions.push_back(region);
        continue;
      }
      for (Index n = region.begin; n < region.end; ++n)
      {
        this->RegionOf[cells[n]] = NoHexId;
      }
      Index at = region.begin;
      for (Index n = region.begin; n < region.end; ++n)
      {
        if (this->RegionOf[cells[n]] == NoHexId)
        {
          at = this->flood(cells[n], at);
        }
      }
    }
  }

  /// Of the surfaces across a line of cells that closes on itself the one with the fewest faces.
  Sheet bestSheet(HexId r) const
  {
    const Region& region = this->Regions[r];
    // Lines that end: bit d of a cell for its direction d.
    std::vector<std::uint8_t> lineEnds(region.end - region.begin, 0);
    std::vector<HexId> cells(this->Order.begin() + region.begin, this->Order.begin() + region.end);
    std::sort(cells.begin(), cells.end());
    const auto slot = [&](HexId cell) { return std::lower_bound(cells.begin(), cells.end(), cell) - cells.begin(); };
    for (HexId cell : cells)
    {
      for (int f = 0; f < 6; ++f)
      {
        HexId face = 6 * cell + f;
        if (!this->ends(face))
        {
          continue;
        }
        for (;;)
        {
          std::uint8_t& ended = lineEnds[slot(face / 6)];
          const std::uint8_t bit = static_cast<std::uint8_t>(1 << faceDirection(static_cast<int>(face % 6)));
          if (ended & bit)
          {
            break;
          }
          ended |= bit;
          const HexId back = face % 2 == 0 ? face + 1 : face - 1;
          if (this->ends(back))
          {
            break;
          }
          face = this->next(back);
        }
      }
    }

    Sheet best;
    best.region = r;
    std::vector<std::uint8_t> seen(cells.size(), 0); // bit f of a cell for its face f
    for (std::size_t n = 0; n < cells.size(); ++n)
    {
      for (int f = 0; f < 6; ++f)
      {
        if ((lineEnds[n] >> faceDirection(f) & 1) || (seen[n] >> f & 1))
        {
          continue;
        }
        Sheet sheet;
        sheet.region = r;
        std::vector<HexId> faces{ 6 * cells[n] + f };
        const auto see = [&](HexId face) { seen[slot(face / 6)] |= static_cast<std::uint8_t>(1 << face % 6); };
        see(faces[0]);
        see(this->next(faces[0]));
        for (std::size_t m = 0; m < faces.size(); ++m)
        {
          const FaceKey key = this->keyOf(faces[m]);
          if (m == 0 || key.compare(sheet.key) < 0)
          {
            sheet.key = key;
            sheet.face = faces[m];
          }
          this->forEachContinuation(
            faces[m], [&](HexId between) { return !this->separates(between); },
            [&](HexId opposite) {
              if (!this->separates(opposite) && !(seen[slot(opposite / 6)] >> opposite % 6 & 1))
              {
                see(opposite);
                see(this->next(opposite));
                faces.push_back(opposite);
              }
            });
        }
        sheet.size = static_cast<Index>(faces.size());
        if (best.face == NoHexId || sheet.before(best))
        {
          best = sheet;
        }
      }
    }
    if (best.face == NoHexId)
    {
      throw Error("the cells around " + this->cell(cells[0]) + ", near " +
        text(this->point(this->corner(cells[0], 0))) + ", are no grid although all their edges are regular");
    }
    return best;
  }

  /// Makes a grid of every region.
  void makeBlocks()
  {
    const Index count = static_cast<Index>(this->Regions.size());
    if (count > this->Options.maximumBlocks)
    {
      throw Error("the mesh of " + std::to_string(this->Mesh.cellCount()) + " cells has " + std::to_string(count) +
        " blocks, " + text(static_cast<double>(this->Mesh.cellCount()) / count) +
        " cells each on average; Maximum Number Of Blocks is " + std::to_string(this->Options.maximumBlocks) +
        ". Such a mesh has no block structure");
    }
    std::vector<HexBlock> blocks(count);
    this->Run.parallelFor(count, 1, [&](Index begin, Index end) {
      for (Index n = begin; n < end; ++n)
      {
        blocks[n] = this->makeBlock(this->Regions[n]);
      }
    });
    std::vector<HexId> sorted(count);
    for (HexId n = 0; n < count; ++n)
    {
      sorted[n] = n;
    }
    std::sort(sorted.begin(), sorted.end(), [&](HexId a, HexId b) {
      const int o = this->compare(blocks[a], blocks[b]);
      return o != 0 ? o < 0 : a < b;
    });
    std::vector<HexId> rank(count);
    this->Result.blocks.clear();
    for (HexId n = 0; n < count; ++n)
    {
      rank[sorted[n]] = n;
      this->Result.blocks.push_back(std::move(blocks[sorted[n]]));
    }
    this->Run.parallelFor(this->Mesh.cellCount(), 1 << 18, [&](Index begin, Index end) {
      for (Index c = begin; c < end; ++c)
      {
        this->RegionOf[c] = rank[this->RegionOf[c]];
      }
    });
  }

  /// A grid of cells before its origin and directions are chosen.
  class Grid
  {
  public:
    Grid(const Decomposition& all, const Region& region)
      : All(all)
      , Lowest(region.lowest)
    {
      Index size = 1;
      for (int d = 0; d < 3; ++d)
      {
        this->Cells[d] = region.highest[d] - region.lowest[d] + 1;
        size *= this->Cells[d];
      }
      if (size != region.end - region.begin)
      {
        this->refuse(region);
      }
      this->Ids.assign(size, NoHexId);
      for (Index n = region.begin; n < region.end; ++n)
      {
        const HexId cell = all.Order[n];
        HexId& id = this->Ids[this->offset(all.PlaceOf[cell])];
        if (id != NoHexId)
        {
          this->refuse(region);
        }
        id = cell;
      }
    }

    const Ijk& cells() const { return this->Cells; }
    HexId cell(const Ijk& at) const
    {
      return this->Ids[at[0] + this->Cells[0] * (at[1] + Index(this->Cells[1]) * at[2])];
    }
    HexId point(const Ijk& at) const
    {
      Ijk cellAt;
      int corner = 0;
      for (int d = 0; d < 3; ++d)
      {
        cellAt[d] = std::min(at[d], this->Cells[d] - 1);
        corner |= (at[d] - cellAt[d]) << d;
      }
      const HexId id = this->cell(cellAt);
      return this->All.corner(id, this->All.Frames.cellCorner(this->All.FrameOf[id], corner));
    }

  private:
    Index offset(const Ijk& place) const
    {
      return (place[0] - this->Lowest[0]) +
        this->Cells[0] * ((place[1] - this->Lowest[1]) + Index(this->Cells[1]) * (place[2] - this->Lowest[2]));
    }
    [[noreturn]] void refuse(const Region& region) const
    {
      const HexId cell = this->All.Order[region.begin];
      throw Error("the " + std::to_string(region.end - region.begin) + " cells around " + this->All.cell(cell) +
        ", near " + text(this->All.point(this->All.corner(cell, 0))) + ", do not fill a grid");
    }

    const Decomposition& All;
    Ijk Lowest;
    Ijk Cells;
    std::vector<HexId> Ids;
  };

  /// A grid seen with another origin and directions: those of a frame.
  struct View
  {
    const Grid& grid;
    const Frame& frame;

    int cells(int d) const { return this->grid.cells()[this->frame.axis[d]]; }
    Ijk place(const Ijk& at, int points) const
    {
      Ijk result;
      for (int d = 0; d < 3; ++d)
      {
        result[this->frame.axis[d]] = this->frame.sign[d] > 0 ? at[d] : this->cells(d) - 1 + points - at[d];
      }
      return result;
    }
    HexId point(const Ijk& at) const { return this->grid.point(this->place(at, 1)); }
    HexId cell(const Ijk& at) const { return this->grid.cell(this->place(at, 0)); }
  };

  /// Order of two grids of points, `pointOf` giving the number of a point: the smallest origin, from which the
  /// directions run as far as they can.
  template <typename PointA, typename PointB>
  int compare(const PointA& a, const Ijk& cellsA, const PointB& b, const Ijk& cellsB) const
  {
    const auto at = [&](const Ijk& p) { return order(this->point(a(p)), this->point(b(p))); };
    if (const int o = at({ 0, 0, 0 }))
    {
      return o;
    }
    for (int d = 0; d < 3; ++d)
    {
      Ijk p{ 0, 0, 0 };
      p[d] = 1;
      if (const int o = at(p))
      {
        return -o;
      }
    }
    if (cellsA != cellsB)
    {
      return cellsA > cellsB ? -1 : 1;
    }
    for (int k = 0; k <= cellsA[2]; ++k)
    {
      for (int j = 0; j <= cellsA[1]; ++j)
      {
        for (int i = 0; i <= cellsA[0]; ++i)
        {
          if (const int o = at({ i, j, k }))
          {
            return -o;
          }
        }
      }
    }
    return 0;
  }
  int compare(const View& a, const View& b) const
  {
    return this->compare([&](const Ijk& p) { return a.point(p); }, { a.cells(0), a.cells(1), a.cells(2) },
      [&](const Ijk& p) { return b.point(p); }, { b.cells(0), b.cells(1), b.cells(2) });
  }
  int compare(const HexBlock& a, const HexBlock& b) const
  {
    const auto point = [](const HexBlock& block) {
      return [&block](const Ijk& p) {
        return block.pointIds[p[0] + (block.cells[0] + 1) * (p[1] + Index(block.cells[1] + 1) * p[2])];
      };
    };
    return this->compare(point(a), a.cells, point(b), b.cells);
  }

  HexBlock makeBlock(const Region& region)
  {
    const Grid grid(*this, region);
    const int handedness = this->handedness(grid);
    int best = -1;
    for (int n = 0; n < HexFrames::Count; ++n)
    {
      if (this->Frames[n].parity() == handedness &&
        (best < 0 || this->compare(View{ grid, this->Frames[n] }, View{ grid, this->Frames[best] }) < 0))
      {
        best = n;
      }
    }

    const View view{ grid, this->Frames[best] };
    HexBlock block;
    block.cells = { view.cells(0), view.cells(1), view.cells(2) };
    block.cellIds.reserve(region.end - region.begin);
    for (int k = 0; k < block.cells[2]; ++k)
    {
      for (int j = 0; j < block.cells[1]; ++j)
      {
        for (int i = 0; i < block.cells[0]; ++i)
        {
          const HexId cell = view.cell({ i, j, k });
          block.cellIds.push_back(cell);
        }
      }
    }
    block.pointIds.reserve(Index(block.cells[0] + 1) * (block.cells[1] + 1) * (block.cells[2] + 1));
    for (int k = 0; k <= block.cells[2]; ++k)
    {
      for (int j = 0; j <= block.cells[1]; ++j)
      {
        for (int i = 0; i <= block.cells[0]; ++i)
        {
          block.pointIds.push_back(view.point({ i, j, k }));
        }
      }
    }

    // Places and frames in the block, in place of those in the region.
    std::array<int, 3> axisOf{};
    for (int d = 0; d < 3; ++d)
    {
      axisOf[view.frame.axis[d]] = d;
    }
    Index n = 0;
    for (int k = 0; k < block.cells[2]; ++k)
    {
      for (int j = 0; j < block.cells[1]; ++j)
      {
        for (int i = 0; i < block.cells[0]; ++i)
        {
          const HexId cell = block.cellIds[n++];
          this->PlaceOf[cell] = { i, j, k };
          Frame frame = this->Frames[this->FrameOf[cell]];
          for (int d = 0; d < 3; ++d)
          {
            frame.axis[d] = axisOf[frame.axis[d]];
            frame.sign[d] *= view.frame.sign[frame.axis[d]];
          }
          this->FrameOf[cell] = static_cast<std::uint8_t>(this->Frames.number(frame));
        }
      }
    }
    return block;
  }

  /// 1 if most cells of the grid are right-handed in it, else -1.
  int handedness(const Grid& grid) const
  {
    Index votes = 0;
    const Ijk& n = grid.cells();
    for (int k = 0; k < n[2]; ++k)
    {
      for (int j = 0; j < n[1]; ++j)
      {
        for (int i = 0; i < n[0]; ++i)
        {
          const HexId cell = grid.cell({ i, j, k });
          const int frame = this->FrameOf[cell];
          Vec3 x[8];
          for (int c = 0; c < 8; ++c)
          {
            x[c] = this->point(this->corner(cell, this->Frames.cellCorner(frame, c)));
          }
          const Vec3 di = (x[1] - x[0]) + (x[3] - x[2]) + (x[5] - x[4]) + (x[7] - x[6]);
          const Vec3 dj = (x[2] - x[0]) + (x[3] - x[1]) + (x[6] - x[4]) + (x[7] - x[5]);
          const Vec3 dk = (x[4] - x[0]) + (x[5] - x[1]) + (x[6] - x[2]) + (x[7] - x[3]);
          const double volume = di.cross(dj).dot(dk);
          votes += volume > 0.0 ? 1 : volume < 0.0 ? -1 : 0;
        }
      }
    }
    return votes >= 0 ? 1 : -1;
  }

  /// What a quadrilateral of a block face meets.
  struct Contact
  {
    int block = -1;
    int face = 0;
    int orientation = 0;
    std::array<int, 2> at{ 0, 0 };
    /// Of a boundary.
    int tag = -1;
  };

  /// The face of a cell that lies at (s, t) of a block face.
  HexId faceOn(int block, int face, int s, int t) const
  {
    const HexBlock& b = this->Result.blocks[block];
    Ijk at{};
    at[faceDirection(face)] = faceSide(face) ? b.cells[faceDirection(face)] - 1 : 0;
    at[faceAxis(face, 0)] = s;
    at[faceAxis(face, 1)] = t;
    const HexId cell = b.cellIds[at[0] + b.cells[0] * (at[1] + Index(b.cells[1]) * at[2])];
    return 6 * cell + this->Frames.cellFace(this->FrameOf[cell], face);
  }

  Contact contact(HexId face, int blockFace) const
  {
    Contact result;
    const HexId behind = this->next(face);
    if (behind == NoHexId)
    {
      const auto tag =
        std::lower_bound(this->Neighbours.tags.begin(), this->Neighbours.tags.end(), std::make_pair(face, -1));
      result.tag = tag != this->Neighbours.tags.end() && tag->first == face ? tag->second : -1;
      return result;
    }
    const HexId cell = behind / 6;
    const int frame = this->FrameOf[cell];
    result.block = static_cast<int>(this->RegionOf[cell]);
    result.face = this->Frames.gridFace(frame, static_cast<int>(behind % 6));
    result.at = { this->PlaceOf[cell][faceAxis(result.face, 0)], this->PlaceOf[cell][faceAxis(result.face, 1)] };
    // The frame that this cell's block continues with, against the other's own.
    const Frame& mine = this->Frames[this->frameAcross(this->FrameOf[face / 6], face)];
    const Frame& other = this->Frames[frame];
    std::array<int, 3> axis{};
    std::array<int, 3> sign{};
    for (int d = 0; d < 3; ++d)
    {
      axis[mine.axis[d]] = other.axis[d];
      sign[mine.axis[d]] = mine.sign[d] * other.sign[d];
    }
    const int s = faceAxis(blockFace, 0);
    const int t = faceAxis(blockFace, 1);
    const bool swap = axis[s] != faceAxis(result.face, 0);
    const bool reversed[2] = { sign[swap ? t : s] < 0, sign[swap ? s : t] < 0 };
    result.orientation = (swap ? 1 : 0) | (reversed[0] ? 2 : 0) | (reversed[1] ? 4 : 0);
    return result;
  }

  /// Whether a quadrilateral `step` away along the face continues the contact of the first one.
  static bool continues(const Contact& first, const Contact& other, const std::array<int, 2>& step)
  {
    if (first.block < 0 || other.block < 0)
    {
      return first.block == other.block && first.tag == other.tag;
    }
    const bool swap = swapsAxes(first.orientation);
    const int u = (first.orientation & 2 ? -1 : 1) * step[swap ? 1 : 0];
    const int v = (first.orientation & 4 ? -1 : 1) * step[swap ? 0 : 1];
    return first.block == other.block && first.face == other.face && first.orientation == other.orientation &&
      other.at[0] == first.at[0] + u && other.at[1] == first.at[1] + v;
  }

  /// A block in a larger one, and how its directions lie there.
  struct Member
  {
    int block;
    Frame frame;
  };

  /// The member behind a face of a larger block at one of its members, or one with the block -1.
  Member memberBehind(const Member& member, int face) const
  {
    const int own = this->Frames.cellFace(this->Frames.number(member.frame), face);
    const HexId first = this->faceOn(member.block, own, 0, 0);
    const HexId behind = this->next(first);
    if (behind == NoHexId)
    {
      return { -1, {} };
    }
    const Frame& continued = this->Frames[this->frameAcross(this->FrameOf[first / 6], first)];
    const Frame& inOther = this->Frames[this->FrameOf[behind / 6]];
    Member result{ static_cast<int>(this->RegionOf[behind / 6]), {} };
    for (int d = 0; d < 3; ++d)
    {
      // Direction d of the cell behind lies along inOther.axis[d] of its block and along continued.axis[d] of ours.
      result.frame.axis[inOther.axis[d]] = member.frame.axis[continued.axis[d]];
      result.frame.sign[inOther.axis[d]] = inOther.sign[d] * continued.sign[d] * member.frame.sign[continued.axis[d]];
    }
    return result;
  }

  bool same(const Member& a, const Member& b) const
  {
    return a.block == b.block && this->Frames.number(a.frame) == this->Frames.number(b.frame);
  }

  /// Blocks that form a grid together.
  struct LargerBlock
  {
    Ijk counts{ 1, 1, 1 };
    std::vector<Member> members;

    const Member& at(const Ijk& p) const
    {
      return this->members[p[0] + this->counts[0] * (p[1] + std::size_t(this->counts[1]) * p[2])];
    }
  };

  /// The layer of blocks that continues a larger block over a face; empty if there is none.
  LargerBlock layerBehind(const LargerBlock& larger, int face, const std::vector<char>& used) const
  {
    const int d = faceDirection(face);
    LargerBlock layer;
    layer.counts = larger.counts;
    layer.counts[d] = 1;
    std::vector<int> blocks;
    Ijk p{};
    for (p[2] = 0; p[2] < layer.counts[2]; ++p[2])
    {
      for (p[1] = 0; p[1] < layer.counts[1]; ++p[1])
      {
        for (p[0] = 0; p[0] < layer.counts[0]; ++p[0])
        {
          Ijk on = p;
          on[d] = faceSide(face) ? larger.counts[d] - 1 : 0;
          const Member member = this->memberBehind(larger.at(on), face);
          if (member.block < 0 || used[member.block])
          {
            return {};
          }
          layer.members.push_back(member);
          blocks.push_back(member.block);
        }
      }
    }
    std::sort(blocks.begin(), blocks.end());
    bool fits = std::adjacent_find(blocks.begin(), blocks.end()) == blocks.end();
    for (int axis = 0; axis < 3; ++axis)
    {
      for (p[2] = 0; p[2] < layer.counts[2] && fits; ++p[2])
      {
        for (p[1] = 0; p[1] < layer.counts[1] && fits; ++p[1])
        {
          for (p[0] = 0; p[0] < layer.counts[0] && fits; ++p[0])
          {
            Ijk q = p;
            ++q[axis];
            fits =
              q[axis] >= layer.counts[axis] || this->same(this->memberBehind(layer.at(p), 2 * axis + 1), layer.at(q));
          }
        }
      }
    }
    return fits ? layer : LargerBlock{};
  }

  Index cellsIn(const LargerBlock& larger) const
  {
    Index cells = 0;
    for (const Member& member : larger.members)
    {
      cells += static_cast<Index>(this->Result.blocks[member.block].cellIds.size());
    }
    return cells;
  }

  /// Lets the largest blocks grow, one after another, each over the face behind which most cells lie.
  void mergeBlocks()
  {
    const int count = static_cast<int>(this->Result.blocks.size());
    std::vector<int> seeds(count);
    for (int b = 0; b < count; ++b)
    {
      seeds[b] = b;
    }
    std::stable_sort(seeds.begin(), seeds.end(),
      [&](int a, int b) { return this->Result.blocks[a].cellIds.size() > this->Result.blocks[b].cellIds.size(); });
    std::vector<char> used(count, false);
    // Bit f of a block: it is joined to the one behind its face f.
    std::vector<std::uint8_t> opened(count, 0);
    const auto open = [&](const Member& member, int face) {
      opened[member.block] |=
        static_cast<std::uint8_t>(1 << this->Frames.cellFace(this->Frames.number(member.frame), face));
    };
    for (int seed : seeds)
    {
      if (used[seed])
      {
        continue;
      }
      LargerBlock larger;
      larger.members.push_back({ seed, {} });
      used[seed] = true;
      for (;;)
      {
        LargerBlock best;
        int bestFace = -1;
        Index most = 0;
        for (int face = 0; face < 6; ++face)
        {
          LargerBlock layer = this->layerBehind(larger, face, used);
          const Index cells = this->cellsIn(layer);
          if (cells > most)
          {
            most = cells;
            best = std::move(layer);
            bestFace = face;
          }
        }
        if (bestFace < 0)
        {
          break;
        }
        larger = this->grown(larger, best, bestFace);
        for (const Member& member : best.members)
        {
          used[member.block] = true;
        }
      }
      Ijk p{};
      for (p[2] = 0; p[2] < larger.counts[2]; ++p[2])
      {
        for (p[1] = 0; p[1] < larger.counts[1]; ++p[1])
        {
          for (p[0] = 0; p[0] < larger.counts[0]; ++p[0])
          {
            for (int d = 0; d < 3; ++d)
            {
              if (p[d] > 0)
              {
                open(larger.at(p), 2 * d);
              }
              if (p[d] + 1 < larger.counts[d])
              {
                open(larger.at(p), 2 * d + 1);
              }
            }
          }
        }
      }
    }

    for (int b = 0; b < count; ++b)
    {
      for (int face = 0; face < 6; ++face)
      {
        if (!(opened[b] >> face & 1))
        {
          continue;
        }
        const Ijk& cells = this->Result.blocks[b].cells;
        for (int t = 0; t < cells[faceAxis(face, 1)]; ++t)
        {
          for (int s = 0; s < cells[faceAxis(face, 0)]; ++s)
          {
            this->Separating[this->faceOn(b, face, s, t)].store(0, std::memory_order_relaxed);
          }
        }
      }
    }
    this->Regions.clear();
    this->flood();
    this->makeBlocks();
    this->Result.notes.push_back(
      std::to_string(count) + " blocks were merged to " + std::to_string(this->Result.blocks.size()) + ".");
  }

  /// A larger block with one more layer behind a face.
  static LargerBlock grown(const LargerBlock& larger, const LargerBlock& layer, int face)
  {
    const int d = faceDirection(face);
    LargerBlock result;
    result.counts = larger.counts;
    ++result.counts[d];
    const int at = faceSide(face) ? larger.counts[d] : 0;
    Ijk p{};
    for (p[2] = 0; p[2] < result.counts[2]; ++p[2])
    {
      for (p[1] = 0; p[1] < result.counts[1]; ++p[1])
      {
        for (p[0] = 0; p[0] < result.counts[0]; ++p[0])
        {
          Ijk q = p;
          q[d] = p[d] == at ? 0 : faceSide(face) ? p[d] : p[d] - 1;
          result.members.push_back(p[d] == at ? layer.at(q) : larger.at(q));
        }
      }
    }
    return result;
  }

  /// Rectangles of quadrilaterals that meet one face, or have one name.
  void makeContacts()
  {
    for (int b = 0; b < static_cast<int>(this->Result.blocks.size()); ++b)
    {
      for (int face = 0; face < 6; ++face)
      {
        this->makeContacts(b, face);
      }
    }
    this->Separating.reset();
    this->nameBoundaries();
  }

  void makeContacts(int block, int face)
  {
    const Ijk& cells = this->Result.blocks[block].cells;
    const int ns = cells[faceAxis(face, 0)];
    const int nt = cells[faceAxis(face, 1)];
    constexpr std::uint8_t Done = 2;
    const auto isDone = [&](HexId f) { return this->Separating[f].load(std::memory_order_relaxed) == Done; };
    const auto done = [&](HexId f) { this->Separating[f].store(Done, std::memory_order_relaxed); };
    for (int t0 = 0; t0 < nt; ++t0)
    {
      for (int s0 = 0; s0 < ns; ++s0)
      {
        const HexId firstFace = this->faceOn(block, face, s0, t0);
        if (isDone(firstFace))
        {
          continue;
        }
        const Contact first = this->contact(firstFace, face);
        // A face that meets itself must not meet itself within one rectangle.
        const bool folded = first.block == block && first.face == face;
        const auto fits = [&](int s, int t) {
          const HexId f = this->faceOn(block, face, s, t);
          return !isDone(f) && continues(first, this->contact(f, face), { s - s0, t - t0 });
        };
        int s1 = s0 + 1;
        while (!folded && s1 < ns && fits(s1, t0))
        {
          ++s1;
        }
        int t1 = t0 + 1;
        for (bool whole = true; !folded && t1 < nt && whole; t1 += whole ? 1 : 0)
        {
          for (int s = s0; s < s1 && whole; ++s)
          {
            whole = fits(s, t1);
          }
        }
        for (int t = t0; t < t1; ++t)
        {
          for (int s = s0; s < s1; ++s)
          {
            const HexId f = this->faceOn(block, face, s, t);
            done(f);
            if (this->next(f) != NoHexId)
            {
              done(this->next(f));
            }
          }
        }
        const FaceRange range{ { s0, t0 }, { s1, t1 } };
        if (first.block < 0)
        {
          this->Result.boundaries.push_back({ block, face, range, first.tag });
          continue;
        }
        const HexId lastFace = this->faceOn(block, face, s1 - 1, t1 - 1);
        const Contact last = this->contact(lastFace, face);
        this->Result.interfaces.push_back({ block, face, first.block, first.face, first.orientation, range,
          { std::min(first.at[0], last.at[0]), std::min(first.at[1], last.at[1]) } });
      }
    }
  }

  /// Keeps the named patches or, if there are none, makes boundaries of the patches that are smooth together.
  void nameBoundaries()
  {
    std::vector<BoundaryPatch>& patches = this->Result.boundaries;
    if (!this->Neighbours.tags.empty())
    {
      this->Result.boundaryNames = this->Mesh.boundaryNames;
      const auto unnamed = [](const BoundaryPatch& patch) { return patch.tag < 0; };
      const Index left = std::count_if(patches.begin(), patches.end(), unnamed);
      if (left > 0)
      {
        this->Result.notes.push_back("Boundaries without a name: " + std::to_string(left) + " block faces or parts.");
      }
      patches.erase(std::remove_if(patches.begin(), patches.end(), unnamed), patches.end());
      return;
    }

    struct Side
    {
      std::pair<HexId, HexId> edge;
      Index patch;
      Vec3 normal;
    };
    std::vector<Side> sides;
    for (std::size_t n = 0; n < patches.size(); ++n)
    {
      const FaceRange& range = patches[n].range;
      for (int axis = 0; axis < 2; ++axis)
      {
        for (int side = 0; side < 2; ++side)
        {
          const int across = side ? range.hi[1 - axis] - 1 : range.lo[1 - axis];
          for (int along = range.lo[axis]; along < range.hi[axis]; ++along)
          {
            const int s = axis == 0 ? along : across;
            const int t = axis == 0 ? across : along;
            HexId p[2][2];
            this->quadPoints(patches[n].block, patches[n].face, s, t, p);
            HexId a = axis == 0 ? p[0][side] : p[side][0];
            HexId b = axis == 0 ? p[1][side] : p[side][1];
            const Vec3 normal =
              (this->point(p[1][1]) - this->point(p[0][0])).cross(this->point(p[0][1]) - this->point(p[1][0]));
            // Outwards in a right-handed block.
            const int f = patches[n].face;
            const bool outward = (faceDirection(f) == 1) != (faceSide(f) == 1);
            sides.push_back({ std::minmax(a, b), static_cast<Index>(n), outward ? normal : Vec3(-normal) });
          }
        }
      }
    }
    std::sort(sides.begin(), sides.end(),
      [](const Side& a, const Side& b) { return a.edge != b.edge ? a.edge < b.edge : a.patch < b.patch; });
    // Per pair of patches how many mesh edges turn, and all.
    std::map<std::pair<Index, Index>, std::array<Index, 2>> pairs;
    const double degree = 3.14159265358979323846 / 180.0;
    // At the limit an edge is smooth, whatever its last bits say.
    constexpr double Margin = 1e-6;
    const double limit = this->Options.featureAngle * degree + Margin;
    Index borderline = 0;
    for (std::size_t n = 0; n + 1 < sides.size(); ++n)
    {
      if (sides[n].edge != sides[n + 1].edge)
      {
        continue;
      }
      const Vec3& a = sides[n].normal;
      const Vec3& b = sides[n + 1].normal;
      const double turn = std::atan2(a.cross(b).norm(), a.dot(b));
      borderline += std::abs(turn - limit + Margin) <= Margin;
      std::array<Index, 2>& counts = pairs[{ sides[n].patch, sides[n + 1].patch }];
      counts[0] += turn > limit;
      ++counts[1];
    }
    UnionFind joined(static_cast<Index>(patches.size()));
    for (const auto& pair : pairs)
    {
      if (2 * pair.second[0] <= pair.second[1])
      {
        joined.unite(pair.first.first, pair.first.second);
      }
    }
    std::vector<int> tagOf(patches.size(), -1);
    for (std::size_t n = 0; n < patches.size(); ++n)
    {
      int& tag = tagOf[joined.find(static_cast<Index>(n))];
      if (tag < 0)
      {
        tag = static_cast<int>(this->Result.boundaryNames.size());
        this->Result.boundaryNames.push_back("boundary " + std::to_string(tag));
      }
      patches[n].tag = tag;
    }
    if (!patches.empty())
    {
      this->Result.notes.push_back("No boundary has a name: " + std::to_string(this->Result.boundaryNames.size()) +
        " boundaries were made of " + std::to_string(patches.size()) + " block faces by the angle of " +
        text(this->Options.featureAngle) + " degrees.");
    }
    if (borderline > 0)
    {
      this->Result.notes.push_back(std::to_string(borderline) + " mesh edges between block faces turn by " +
        text(this->Options.featureAngle) + " degrees, the limit: taken as smooth.");
    }
  }

  /// Points of a quadrilateral of a block face, [s][t].
  void quadPoints(int block, int face, int s, int t, HexId (&p)[2][2]) const
  {
    const HexBlock& b = this->Result.blocks[block];
    for (int a = 0; a < 2; ++a)
    {
      for (int c = 0; c < 2; ++c)
      {
        Ijk at{};
        at[faceDirection(face)] = faceSide(face) ? b.cells[faceDirection(face)] : 0;
        at[faceAxis(face, 0)] = s + a;
        at[faceAxis(face, 1)] = t + c;
        p[a][c] = b.pointIds[at[0] + (b.cells[0] + 1) * (at[1] + Index(b.cells[1] + 1) * at[2])];
      }
    }
  }

  void tell()
  {
    const Index blocks = static_cast<Index>(this->Result.blocks.size());
    const Index cells = this->Mesh.cellCount();
    // A block of a few cells per direction leaves little to a spline.
    constexpr Index FewCells = 64;
    if (blocks > 1 && cells < FewCells * blocks)
    {
      this->Result.warnings.push_back("The mesh of " + std::to_string(cells) + " cells has " + std::to_string(blocks) +
        " blocks, " + text(static_cast<double>(cells) / blocks) +
        " cells each on average: it has little block structure, and splines gain little from it.");
    }
    if (this->Result.closedRegions > 0)
    {
      this->Result.notes.push_back(
        std::to_string(this->Result.closedRegions) + " regions closed on themselves and were cut.");
    }
  }

  HexMesh& Mesh;
  const BaseComplexOptions& Options;
  const Execution& Run;
  const HexFrames& Frames;
  HexNeighbours Neighbours;
  /// Per face whether a separation surface runs there; both sides agree. Written by several threads.
  std::unique_ptr<std::atomic<std::uint8_t>[]> Separating;
  std::vector<HexId> Front;
  std::vector<Region> Regions;
  /// Cells, region by region.
  std::vector<HexId> Order;
  /// Per cell: first in its region, later in its block.
  std::vector<HexId> RegionOf;
  std::vector<Ijk> PlaceOf;
  std::vector<std::uint8_t> FrameOf;
  BaseComplex Result;
};

} // namespace

BaseComplex baseComplex(HexMesh& mesh, const BaseComplexOptions& options, const Execution& run)
{
  if (!(options.neighbours.matchTolerance >= 0.0 && options.neighbours.matchTolerance < 0.5))
  {
    throw Error("Match Tolerance " + text(options.neighbours.matchTolerance) + " is not in [0, 0.5)");
  }
  if (!(options.featureAngle >= 0.0 && options.featureAngle <= 180.0))
  {
    throw Error("Feature Angle " + text(options.featureAngle) + " is not between 0 and 180 degrees");
  }
  if (mesh.cellCount() > MostHexCells)
  {
    throw Error(
      "the mesh has " + std::to_string(mesh.cellCount()) + " cells, more than " + std::to_string(MostHexCells));
  }
  if (mesh.cellCount() == 0)
  {
    return {};
  }
  return Decomposition(mesh, options, run).decompose();
}

} // namespace bsv
