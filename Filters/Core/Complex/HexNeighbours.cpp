// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/HexNeighbours.h"

#include "Base/BoxTree.h"
#include "Base/CanonicalOrder.h"
#include "Base/UnionFind.h"
#include "Mesh/BlockSurface.h"
#include "Mesh/BlockTopology.h"
#include "Ranks/Ranks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

namespace bsv
{

namespace
{

using Key = std::array<HexId, 4>;

class Finder
{
public:
  Finder(HexMesh& mesh, const HexNeighbourOptions& options, const Execution& run)
    : Mesh(mesh)
    , Options(options)
    , Run(run)
  {
  }

  HexNeighbours find()
  {
    const std::size_t faces = 6 * static_cast<std::size_t>(this->Mesh.cellCount());
    this->Result.next.assign(faces, NoHexId);
    this->Result.orientation.assign(faces, 0);
    this->checkCells();
    this->Run.report(0.1);
    this->pair([&](const auto& visit) {
      for (HexId face = 0; face < faces; ++face)
      {
        visit(face);
      }
    });
    this->Run.report(0.7);
    this->joinByPlace();
    this->Run.report(1.0);
    return std::move(this->Result);
  }

private:
  Vec3 point(HexId id) const { return this->Mesh.points.atPlace(id); }

  /// The corners of a face at (0, 0), (1, 0), (0, 1) and (1, 1) of its axes.
  Key corners(HexId face) const
  {
    const HexId* cell = this->Mesh.corners.data() + 8 * Index(face / 6);
    const int f = static_cast<int>(face % 6);
    return { cell[faceCorner(f, 0, 0)], cell[faceCorner(f, 1, 0)], cell[faceCorner(f, 0, 1)],
      cell[faceCorner(f, 1, 1)] };
  }

  Vec3 center(HexId face) const
  {
    const Key c = this->corners(face);
    return 0.25 * ((this->point(c[0]) + this->point(c[3])) + (this->point(c[1]) + this->point(c[2])));
  }

  std::string cell(Index cell) const { return this->Mesh.cellName(cell); }
  std::string cellOf(HexId face) const { return this->cell(face / 6); }
  std::string near(HexId face) const { return " near " + text(this->center(face)); }

  void checkCells() const
  {
    this->Run.parallelFor(this->Mesh.pointCount(), 1 << 16, [&](Index begin, Index end) {
      for (Index p = begin; p < end; ++p)
      {
        if (!this->Mesh.points.atPlace(p).allFinite())
        {
          throw Error(this->Mesh.pointName(p) + " is not finite: " + text(this->Mesh.points.atPlace(p)));
        }
      }
    });
    this->Run.parallelFor(this->Mesh.cellCount(), 1 << 14, [&](Index begin, Index end) {
      for (Index c = begin; c < end; ++c)
      {
        std::array<HexId, 8> sorted;
        std::copy_n(this->Mesh.corners.begin() + 8 * c, 8, sorted.begin());
        std::sort(sorted.begin(), sorted.end());
        const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
        if (twice != sorted.end())
        {
          throw Error(this->cell(c) + " has the " + this->Mesh.pointName(*twice) + " twice, near " +
            text(this->point(*twice)) + ": collapsed hexahedra cannot be part of a block");
        }
      }
    });
  }

  /// Orientation code between faces with the corners `a` and `b`, or -1 if they are not the same ones in a possible
  /// order.
  static int orientation(const Key& a, const Key& b)
  {
    for (int code = 0; code < 8; ++code)
    {
      bool fits = true;
      for (int c = 0; c < 4 && fits; ++c)
      {
        const std::array<int, 2> st = mapFacePoint(code, c & 1, c >> 1, 1, 1);
        fits = a[c] == b[st[0] + 2 * st[1]];
      }
      if (fits)
      {
        return code;
      }
    }
    return -1;
  }

  void setContact(HexId a, HexId b, int orientation)
  {
    this->Result.next[a] = b;
    this->Result.next[b] = a;
    this->Result.orientation[a] = static_cast<std::uint8_t>(orientation);
    this->Result.orientation[b] = static_cast<std::uint8_t>(inverseOrientation(orientation));
  }

  /// Lets those of the faces meet that have the same points. They are sorted into buckets by their smallest point.
  template <typename Faces>
  void pair(const Faces& forEachFace)
  {
    const auto smallest = [&](HexId face) {
      const Key c = this->corners(face);
      return std::min(std::min(c[0], c[1]), std::min(c[2], c[3]));
    };
    std::vector<HexId> start(this->Mesh.pointCount() + 1, 0);
    forEachFace([&](HexId face) { ++start[smallest(face)]; });
    HexId sum = 0;
    for (HexId& first : start)
    {
      sum += first;
      first = sum;
    }
    std::vector<HexId> bucket(sum);
    forEachFace([&](HexId face) { bucket[--start[smallest(face)]] = face; });
    this->Run.report(0.3);

    struct Entry
    {
      std::uint64_t middle;
      HexId largest;
      HexId face;
      bool operator<(const Entry& other) const
      {
        return this->middle != other.middle ? this->middle < other.middle
          : this->largest != other.largest  ? this->largest < other.largest
                                            : this->face < other.face;
      }
      bool sameAs(const Entry& other) const { return this->middle == other.middle && this->largest == other.largest; }
    };
    this->Run.parallelFor(this->Mesh.pointCount(), 1 << 13, [&](Index begin, Index end) {
      std::vector<Entry> entries;
      for (Index p = begin; p < end; ++p)
      {
        entries.clear();
        for (HexId n = start[p]; n < start[p + 1]; ++n)
        {
          Key c = this->corners(bucket[n]);
          std::sort(c.begin(), c.end());
          entries.push_back({ std::uint64_t(c[1]) << 32 | c[2], c[3], bucket[n] });
        }
        std::sort(entries.begin(), entries.end());
        for (std::size_t n = 0; n + 1 < entries.size(); ++n)
        {
          if (!entries[n].sameAs(entries[n + 1]))
          {
            continue;
          }
          const HexId a = entries[n].face;
          const HexId b = entries[n + 1].face;
          if (n + 2 < entries.size() && entries[n].sameAs(entries[n + 2]))
          {
            throw Error(this->cellOf(a) + ", " + this->cellOf(b) + " and " + this->cellOf(entries[n + 2].face) +
              " have the same face" + this->near(a));
          }
          const int code = orientation(this->corners(a), this->corners(b));
          if (code < 0)
          {
            throw Error(this->cellOf(a) + " and " + this->cellOf(b) +
              " have the four points of a face in another order" + this->near(a));
          }
          this->setContact(a, b, code);
          ++n;
        }
      }
    });
  }

  /// A point of the boundary, or of a named quadrilateral that has points of its own.
  struct Place
  {
    HexId point;
    Vec3 x;
    double tolerance;
    bool ofCell;
  };

  /// What happens by coordinates: contacts of faces without a partner, and names.
  void joinByPlace()
  {
    std::vector<HexId> open;
    for (HexId face = 0; face < this->Result.next.size(); ++face)
    {
      if (this->Result.next[face] == NoHexId)
      {
        open.push_back(face);
      }
    }
    this->collectPlaces(open);
    this->Run.report(0.75);
    std::vector<Group> groups = this->groups(open);
    if (this->Options.mergePoints && this->mergeNear(open, groups))
    {
      groups = this->groups(open);
    }
    this->Run.report(0.85);
    this->takeNames(groups);
    const std::vector<int> former = this->formerTags(open);
    if (this->Options.mergePoints)
    {
      this->join(open, groups);
    }
    this->takeTags(open, former);
    if (this->Options.mergePoints)
    {
      this->refuseCoveredFaces(open);
    }
  }

  std::vector<int> formerTags(const std::vector<HexId>& open) const
  {
    std::vector<int> tags;
    for (HexId face : open)
    {
      if (this->Mesh.tagOf)
      {
        tags.push_back(this->Mesh.tagOf(this->corners(face)));
      }
    }
    return tags;
  }

  /// Names those faces by HexMesh::tagOf that are still on the boundary and have no name.
  void takeTags(const std::vector<HexId>& open, const std::vector<int>& former)
  {
    std::vector<std::pair<HexId, int>>& tags = this->Result.tags;
    const std::size_t named = tags.size();
    for (std::size_t n = 0; n < former.size(); ++n)
    {
      const bool free = this->Result.next[open[n]] == NoHexId;
      const auto end = tags.begin() + static_cast<std::ptrdiff_t>(named);
      const auto known = std::lower_bound(tags.begin(), end, std::make_pair(open[n], -1));
      if (former[n] >= 0 && free && (known == end || known->first != open[n]))
      {
        tags.push_back({ open[n], former[n] });
      }
    }
    std::sort(tags.begin(), tags.end());
  }

  /// Gives all points of open faces and of quadrilaterals a place, and equal places one class.
  void collectPlaces(const std::vector<HexId>& open)
  {
    this->PlaceOf.assign(this->Mesh.pointCount(), NoHexId);
    const auto add = [&](HexId p, bool ofCell) {
      if (this->PlaceOf[p] == NoHexId)
      {
        this->PlaceOf[p] = static_cast<HexId>(this->Places.size());
        this->Places.push_back({ p, this->point(p), std::numeric_limits<double>::max(), ofCell });
      }
    };
    for (HexId face : open)
    {
      for (HexId p : this->corners(face))
      {
        add(p, true);
      }
    }
    // Points of quadrilaterals that belong to cells, but not on the boundary, have no place.
    if (!this->Mesh.quads.empty())
    {
      std::vector<char> ofCell(this->Mesh.pointCount(), false);
      for (HexId p : this->Mesh.corners)
      {
        ofCell[p] = true;
      }
      for (const NamedQuad& quad : this->Mesh.quads)
      {
        for (HexId p : quad.points)
        {
          if (!ofCell[p])
          {
            add(p, false);
          }
        }
      }
    }

    HexId last = NoHexId;
    for (HexId face : open)
    {
      if (face / 6 == last)
      {
        continue;
      }
      last = face / 6;
      const HexId* corner = this->Mesh.corners.data() + 8 * Index(last);
      for (int edge = 0; edge < 12; ++edge)
      {
        const HexId ends[2] = { corner[edgeCorner(edge, 0)], corner[edgeCorner(edge, 1)] };
        const double length = this->Options.matchTolerance * (this->point(ends[0]) - this->point(ends[1])).norm();
        for (HexId end : ends)
        {
          if (this->PlaceOf[end] != NoHexId)
          {
            double& tolerance = this->Places[this->PlaceOf[end]].tolerance;
            tolerance = std::min(tolerance, length);
          }
        }
      }
    }

    const HexId count = static_cast<HexId>(this->Places.size());
    std::vector<HexId> order(count);
    for (HexId n = 0; n < count; ++n)
    {
      order[n] = n;
    }
    std::sort(order.begin(), order.end(), [&](HexId a, HexId b) {
      const Vec3& x = this->Places[a].x;
      const Vec3& y = this->Places[b].x;
      for (int d = 0; d < 3; ++d)
      {
        if (x[d] != y[d])
        {
          return x[d] < y[d];
        }
      }
      return a < b;
    });
    this->Class.resize(count);
    for (HexId n = 0; n < count; ++n)
    {
      const bool same = n > 0 && this->Places[order[n]].x == this->Places[order[n - 1]].x;
      this->Class[order[n]] = same ? this->Class[order[n - 1]] : order[n];
    }
  }

  /// Sorted classes of four points; a first class of NoHexId if one of them has no place or two have the same.
  Key classes(const Key& points) const
  {
    Key key;
    for (int c = 0; c < 4; ++c)
    {
      const HexId place = this->PlaceOf[points[c]];
      if (place == NoHexId)
      {
        return { NoHexId, 0, 0, 0 };
      }
      key[c] = this->Class[place];
    }
    std::sort(key.begin(), key.end());
    return std::adjacent_find(key.begin(), key.end()) == key.end() ? key : Key{ NoHexId, 0, 0, 0 };
  }

  /// The faces and quadrilaterals at one place.
  struct Group
  {
    std::vector<HexId> faces;
    std::vector<HexId> quads;
    /// Two faces with a name each, which do not meet.
    bool apart = false;
  };

  std::vector<Group> groups(const std::vector<HexId>& open) const
  {
    struct Item
    {
      Key key;
      bool quad;
      HexId number;
      bool operator<(const Item& other) const
      {
        return std::tie(this->key, this->quad, this->number) < std::tie(other.key, other.quad, other.number);
      }
    };
    // Single faces without a name are of no interest: most of the boundary of most meshes.
    std::vector<char> crowded(this->Places.size(), !this->Mesh.quads.empty());
    std::vector<char> seen(this->Places.size(), false);
    for (std::size_t n = 0; n < this->Places.size(); ++n)
    {
      crowded[this->Class[n]] = crowded[this->Class[n]] || seen[this->Class[n]];
      seen[this->Class[n]] = true;
    }
    std::vector<Item> items;
    for (HexId face : open)
    {
      const Key key = this->classes(this->corners(face));
      if (key[0] != NoHexId && std::all_of(key.begin(), key.end(), [&](HexId c) { return crowded[c] != 0; }))
      {
        items.push_back({ key, false, face });
      }
    }
    for (HexId q = 0; q < this->Mesh.quads.size(); ++q)
    {
      const Key key = this->classes(this->Mesh.quads[q].points);
      if (key[0] != NoHexId)
      {
        items.push_back({ key, true, q });
      }
    }
    std::sort(items.begin(), items.end());
    std::vector<Group> result;
    for (std::size_t n = 0; n < items.size(); ++n)
    {
      if (n == 0 || items[n].key != items[n - 1].key)
      {
        result.emplace_back();
      }
      (items[n].quad ? result.back().quads : result.back().faces).push_back(items[n].number);
    }
    for (Group& group : result)
    {
      group.apart = group.faces.size() == 2 && group.quads.size() >= 2;
    }
    return result;
  }

  /// Merges classes of near places around faces without a partner. True if any were.
  bool mergeNear(const std::vector<HexId>& open, const std::vector<Group>& groups)
  {
    std::vector<HexId> done;
    for (const Group& group : groups)
    {
      if (group.faces.size() > 1 || (!group.faces.empty() && !group.quads.empty()))
      {
        done.insert(done.end(), group.faces.begin(), group.faces.end());
      }
    }
    std::sort(done.begin(), done.end());
    std::vector<char> wanted(this->Places.size(), false);
    for (HexId face : open)
    {
      if (!std::binary_search(done.begin(), done.end(), face))
      {
        for (HexId p : this->corners(face))
        {
          wanted[this->Class[this->PlaceOf[p]]] = true;
        }
      }
    }
    for (std::size_t n = 0; n < this->Places.size(); ++n)
    {
      if (!this->Places[n].ofCell)
      {
        wanted[this->Class[n]] = true;
      }
    }
    std::vector<HexId> slots;
    std::vector<HexId> slotOf(this->Places.size(), NoHexId);
    std::vector<Box> boxes;
    std::vector<double> tolerance;
    for (HexId n = 0; n < this->Places.size(); ++n)
    {
      const HexId c = this->Class[n];
      if (wanted[c] && slotOf[c] == NoHexId)
      {
        slotOf[c] = static_cast<HexId>(slots.size());
        slots.push_back(c);
        boxes.emplace_back(this->Places[c].x);
        tolerance.push_back(std::numeric_limits<double>::max());
      }
      if (wanted[c])
      {
        tolerance[slotOf[c]] = std::min(tolerance[slotOf[c]], this->Places[n].tolerance);
      }
    }
    const Index count = static_cast<Index>(slots.size());
    if (count < 2)
    {
      return false;
    }
    // A place that no cell has takes the tolerance of what it is near to.
    double largest = 0.0;
    for (double& t : tolerance)
    {
      largest = t < std::numeric_limits<double>::max() ? std::max(largest, t) : largest;
    }
    const BoxTree tree(boxes);
    constexpr Index Chunk = 1024;
    std::vector<std::vector<std::pair<Index, Index>>> chunks((count + Chunk - 1) / Chunk);
    this->Run.parallelFor(static_cast<Index>(chunks.size()), 1, [&](Index begin, Index end) {
      for (Index chunk = begin; chunk < end; ++chunk)
      {
        for (Index n = chunk * Chunk; n < std::min(count, (chunk + 1) * Chunk); ++n)
        {
          tree.search(inflated(boxes[n], std::min(tolerance[n], largest)), [&](Index m) {
            const double allowed = std::min(tolerance[m], tolerance[n]);
            const bool cells = allowed < std::numeric_limits<double>::max();
            if (m != n && cells && (m > n || tolerance[n] > tolerance[m]) &&
              (boxes[m].min() - boxes[n].min()).norm() <= allowed)
            {
              chunks[chunk].push_back({ n, m });
            }
          });
        }
      }
    });
    UnionFind merged(count);
    bool any = false;
    for (const auto& chunk : chunks)
    {
      for (const auto& near : chunk)
      {
        merged.unite(near.first, near.second);
        any = true;
      }
    }
    if (!any)
    {
      return false;
    }
    std::vector<Box> extent(count);
    std::vector<double> smallest(count, std::numeric_limits<double>::max());
    for (Index n = 0; n < count; ++n)
    {
      const Index root = merged.find(n);
      extent[root].extend(boxes[n].min());
      smallest[root] = std::min(smallest[root], tolerance[n]);
    }
    for (Index n = 0; n < count; ++n)
    {
      if (!extent[n].isEmpty() && extent[n].diagonal().norm() > 2.0 * smallest[n])
      {
        throw Error("ambiguous contact near " + text(boxes[n].min()) + ": points form a chain of width " +
          text(extent[n].diagonal().norm()) + ", allowed is " + text(2.0 * smallest[n]));
      }
    }
    for (HexId& c : this->Class)
    {
      if (slotOf[c] != NoHexId)
      {
        c = slots[merged.find(slotOf[c])];
      }
    }
    return true;
  }

  /// Takes the names of quadrilaterals that lie on the boundary.
  void takeNames(const std::vector<Group>& groups)
  {
    std::vector<char> used(this->Mesh.quads.size(), false);
    for (const Group& group : groups)
    {
      if (group.faces.empty() || (group.faces.size() > 1 && !group.apart))
      {
        continue;
      }
      std::vector<HexId> quads = group.quads;
      for (HexId face : group.faces)
      {
        // The one with the face's own points, else any.
        Key mine = this->corners(face);
        std::sort(mine.begin(), mine.end());
        const auto own = std::find_if(quads.begin(), quads.end(), [&](HexId q) {
          Key other = this->Mesh.quads[q].points;
          std::sort(other.begin(), other.end());
          return other == mine;
        });
        const auto taken = own == quads.end() ? quads.begin() : own;
        if (taken != quads.end())
        {
          this->Result.tags.push_back({ face, this->Mesh.quads[*taken].tag });
          used[*taken] = true;
          quads.erase(taken);
        }
      }
    }
    std::sort(this->Result.tags.begin(), this->Result.tags.end());
    const Index left = std::count(used.begin(), used.end(), false);
    if (left > 0)
    {
      const NamedQuad& first = this->Mesh.quads[std::find(used.begin(), used.end(), false) - used.begin()];
      this->Result.warnings.push_back(std::to_string(left) + " of " + std::to_string(used.size()) +
        " boundary quadrilaterals are left out: they lie inside the mesh, on no face of a cell, or on another one; " +
        "first one of '" + this->Mesh.boundaryNames[first.tag] + "' near " + text(this->point(first.points[0])) + ".");
    }
  }

  /// Gives the points of faces that meet the same numbers, and lets the faces meet.
  void join(const std::vector<HexId>& open, const std::vector<Group>& groups)
  {
    UnionFind copies(static_cast<Index>(this->Places.size()));
    std::vector<char> apart;
    Index contacts = 0;
    for (const Group& group : groups)
    {
      if (group.faces.size() > 2)
      {
        throw Error(this->cellOf(group.faces[0]) + ", " + this->cellOf(group.faces[1]) + " and " +
          this->cellOf(group.faces[2]) + " have a face at the same place" + this->near(group.faces[0]));
      }
      if (group.faces.size() == 2 && !group.apart)
      {
        ++contacts;
        for (HexId p : this->corners(group.faces[0]))
        {
          for (HexId q : this->corners(group.faces[1]))
          {
            if (this->Class[this->PlaceOf[p]] == this->Class[this->PlaceOf[q]])
            {
              copies.unite(this->PlaceOf[p], this->PlaceOf[q]);
            }
          }
        }
      }
    }
    if (contacts == 0)
    {
      return;
    }
    // Per class, at its representative, the copy that all become.
    std::vector<HexId> chosen(this->Places.size(), NoHexId);
    for (HexId n = 0; n < this->Places.size(); ++n)
    {
      HexId& best = chosen[copies.find(n)];
      if (best == NoHexId || comesBefore(this->Places[n].x, this->Places[best].x))
      {
        best = n;
      }
    }
    Index points = 0;
    std::vector<HexId> number(this->Places.size());
    for (HexId n = 0; n < this->Places.size(); ++n)
    {
      number[n] = this->Places[chosen[copies.find(n)]].point;
      points += number[n] != this->Places[n].point;
    }
    this->Run.parallelFor(static_cast<Index>(this->Mesh.corners.size()), 1 << 18, [&](Index begin, Index end) {
      for (Index n = begin; n < end; ++n)
      {
        HexId& p = this->Mesh.corners[n];
        p = this->PlaceOf[p] == NoHexId ? p : number[this->PlaceOf[p]];
      }
    });
    std::vector<HexId> named;
    for (const auto& tag : this->Result.tags)
    {
      named.push_back(tag.first);
    }
    this->pair([&](const auto& visit) {
      for (HexId face : open)
      {
        if (!std::binary_search(named.begin(), named.end(), face))
        {
          visit(face);
        }
      }
    });
    this->Result.notes.push_back(std::to_string(points) + " points and " + std::to_string(contacts) +
      " pairs of faces at the same places were merged.");
  }

  /// Refuses faces without partner and name that lie on one another: hanging nodes.
  void refuseCoveredFaces(const std::vector<HexId>& open) const
  {
    std::vector<HexId> single;
    for (HexId face : open)
    {
      if (this->Result.next[face] == NoHexId &&
        !std::binary_search(this->Result.tags.begin(), this->Result.tags.end(), std::make_pair(face, -1),
          [](const auto& a, const auto& b) { return a.first < b.first; }))
      {
        single.push_back(face);
      }
    }
    const Index count = static_cast<Index>(single.size());
    std::vector<Box> boxes(count);
    std::vector<Vec3> normal(count);
    std::vector<double> tolerance(count);
    constexpr Index Chunk = 1024;
    this->Run.parallelFor(count, Chunk, [&](Index begin, Index end) {
      for (Index n = begin; n < end; ++n)
      {
        const Key c = this->corners(single[n]);
        const Vec3 x[4] = { this->point(c[0]), this->point(c[1]), this->point(c[2]), this->point(c[3]) };
        normal[n] = (x[3] - x[0]).cross(x[2] - x[1]).stableNormalized();
        // Outwards: the opposite face lies behind.
        if (normal[n].dot(this->center(opposite(single[n])) - this->center(single[n])) > 0.0)
        {
          normal[n] = -normal[n];
        }
        tolerance[n] = std::numeric_limits<double>::max();
        for (int e = 0; e < 4; ++e)
        {
          const int order[5] = { 0, 1, 3, 2, 0 };
          const double length = (x[order[e]] - x[order[e + 1]]).norm();
          tolerance[n] = std::min(tolerance[n], std::max(this->Options.matchTolerance, 1e-9) * length);
          boxes[n].extend(x[e]);
        }
        boxes[n] = inflated(boxes[n], tolerance[n]);
      }
    });
    if (count < 2)
    {
      return;
    }
    const BoxTree tree(boxes);
    std::vector<Index> cover = this->quartered(single);
    this->Run.parallelFor(count, Chunk, [&](Index begin, Index end) {
      for (Index n = begin; n < end; ++n)
      {
        const Vec3 x = this->center(single[n]);
        tree.search(Box(x), [&](Index m) {
          if (normal[m].dot(normal[n]) < -0.9 && (cover[n] < 0 || m < cover[n]) &&
            this->covers(single[m], normal[m], x, std::min(tolerance[n], tolerance[m])))
          {
            cover[n] = m;
          }
        });
      }
    });
    const auto covered = [](Index m) { return m >= 0; };
    const auto first = std::find_if(cover.begin(), cover.end(), covered);
    if (first != cover.end())
    {
      const HexId face = single[first - cover.begin()];
      throw Error("hanging nodes: faces of " + this->cellOf(face) + " and " + this->cellOf(single[*first]) +
        " cover each other" + this->near(face) + " but do not share their points (" +
        std::to_string(std::count_if(cover.begin(), cover.end(), covered)) +
        " such faces); cells must meet face to face. Boundaries that touch need a name on both sides");
    }
  }

  /// Per face one of the four that have a corner of it each and meet in a point of their own, as where cells are
  /// refined, or -1. That holds on curved faces, too.
  std::vector<Index> quartered(const std::vector<HexId>& single) const
  {
    const Index count = static_cast<Index>(single.size());
    // Point, the point across the face, face.
    std::vector<std::tuple<HexId, HexId, Index>> diagonals;
    diagonals.reserve(4 * count);
    for (Index n = 0; n < count; ++n)
    {
      const Key c = this->corners(single[n]);
      for (int v = 0; v < 4; ++v)
      {
        diagonals.emplace_back(c[v], c[3 - v], n);
      }
    }
    std::sort(diagonals.begin(), diagonals.end());
    std::vector<Index> result(count, -1);
    this->Run.parallelFor(count, 1024, [&](Index begin, Index end) {
      const auto at = [&](HexId from, HexId to) {
        const auto found = std::lower_bound(diagonals.begin(), diagonals.end(), std::make_tuple(from, to, Index(0)));
        return found != diagonals.end() && std::get<0>(*found) == from && std::get<1>(*found) == to;
      };
      for (Index n = begin; n < end; ++n)
      {
        const Key c = this->corners(single[n]);
        for (auto d = std::lower_bound(diagonals.begin(), diagonals.end(), std::make_tuple(c[0], HexId(0), Index(0)));
             d != diagonals.end() && std::get<0>(*d) == c[0]; ++d)
        {
          const HexId middle = std::get<1>(*d);
          if (std::get<2>(*d) != n && at(c[1], middle) && at(c[2], middle) && at(c[3], middle))
          {
            result[n] = std::get<2>(*d);
          }
        }
      }
    });
    return result;
  }

  static HexId opposite(HexId face) { return face % 2 == 0 ? face + 1 : face - 1; }

  /// Whether the face of outward unit normal `n` has `x` in its interior, up to `tolerance` along its normal; behind
  /// it, where the other side of a thin mesh is no cover, also up to the match tolerance of its cell's depth.
  bool covers(HexId face, const Vec3& n, const Vec3& x, double tolerance) const
  {
    const Key c = this->corners(face);
    const Vec3 corner[4] = { this->point(c[0]), this->point(c[1]), this->point(c[3]), this->point(c[2]) };
    const Vec3 center = this->center(face);
    const double height = n.dot(x - center);
    const double depth = n.dot(center - this->center(opposite(face)));
    if (height > tolerance || -height > std::min(tolerance, std::max(this->Options.matchTolerance, 1e-9) * depth))
    {
      return false;
    }
    // A center on an edge counts, which is what half a cell of offset gives.
    constexpr double Margin = 1e-6;
    bool left = true;
    bool right = true;
    for (int e = 0; e < 4; ++e)
    {
      const Vec3 edge = corner[(e + 1) % 4] - corner[e];
      const double turn = n.dot(edge.cross(x - corner[e]));
      left = left && turn >= -Margin * edge.squaredNorm();
      right = right && turn <= Margin * edge.squaredNorm();
    }
    return left || right;
  }

  HexMesh& Mesh;
  const HexNeighbourOptions& Options;
  const Execution& Run;
  HexNeighbours Result;
  std::vector<Place> Places;
  /// Per point of the mesh, or NoHexId.
  std::vector<HexId> PlaceOf;
  /// Per place the one that stands for those at the same place.
  std::vector<HexId> Class;
};

} // namespace

HexNeighbours findNeighbours(HexMesh& mesh, const HexNeighbourOptions& options, const Execution& run)
{
  return Finder(mesh, options, run).find();
}

} // namespace bsv
