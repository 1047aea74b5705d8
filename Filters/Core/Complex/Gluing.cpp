// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/Gluing.h"

#include "Base/BoxTree.h"
#include "Base/UnionFind.h"
#include "Complex/GluingRanks.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>

namespace bsv
{

namespace
{

/// Found so far: hash table of items of which the first of equal ones is kept.
class FirstOccurrence
{
public:
  explicit FirstOccurrence(Index expected)
  {
    std::size_t size = 16;
    while (size < static_cast<std::size_t>(expected + expected / 2))
    {
      size *= 2;
    }
    this->Slots.assign(size, Empty);
  }

  /// The earlier item for which equal(earlier) holds, or `item` itself. At most `expected` items may differ.
  template <typename Equal>
  Index insert(std::uint64_t hash, Index item, const Equal& equal)
  {
    // The upper bits of the hash are kept beside the item, so that unequal items are rarely compared.
    const std::uint64_t mark = hash & ~ItemBits;
    const std::size_t mask = this->Slots.size() - 1;
    for (std::size_t at = hash & mask;; at = (at + 1) & mask)
    {
      std::uint64_t& slot = this->Slots[at];
      if (slot == Empty)
      {
        slot = mark | static_cast<std::uint64_t>(item);
        return item;
      }
      if ((slot & ~ItemBits) == mark && equal(static_cast<Index>(slot & ItemBits)))
      {
        return static_cast<Index>(slot & ItemBits);
      }
    }
  }

private:
  static constexpr std::uint64_t ItemBits = (std::uint64_t(1) << 40) - 1;
  static constexpr std::uint64_t Empty = ~std::uint64_t(0);
  std::vector<std::uint64_t> Slots;
};

/// Mixes one more word into a hash; the constants are those of the 64-bit finalizer of MurmurHash3.
std::uint64_t mix(std::uint64_t hash, std::uint64_t word)
{
  hash ^= word;
  hash ^= hash >> 33;
  hash *= 0xff51afd7ed558ccdULL;
  hash ^= hash >> 33;
  hash *= 0xc4ceb9fe1a85ec53ULL;
  hash ^= hash >> 33;
  return hash;
}

std::uint64_t hashOf(const Vec3& x)
{
  std::uint64_t hash = 0;
  for (int d = 0; d < 3; ++d)
  {
    // +0 and -0 are the same place.
    const double value = x[d] + 0.0;
    std::uint64_t word;
    std::memcpy(&word, &value, sizeof word);
    hash = mix(hash, word);
  }
  return hash;
}

using Key = std::array<Index, 4>;

class Gluer
{
public:
  Gluer(PartialMesh& mesh, const SurfaceNumbering& surface, const std::vector<bool>& leftHanded,
    const BlockComplexOptions& options, const Execution& run)
    : Part(mesh)
    , Mesh(mesh.mesh())
    , Surface(surface)
    , LeftHanded(leftHanded)
    , Options(options)
    , Run(run)
    , Ranks(*run.ranks)
    , Result(surface)
  {
  }

  Contacts glue()
  {
    this->takeInterfaces();
    for (std::size_t n = 0; n < this->Mesh.boundaries.size(); ++n)
    {
      this->takeBoundary(static_cast<int>(n));
    }
    this->report(0.2);
    // Collapsed quadrilaterals, where allowed, must be told from the others one by one.
    if (this->Options.findInterfaces && !this->Options.allowDegenerate)
    {
      this->takeWholeFaces();
    }
    this->report(0.4);
    if (this->Options.findInterfaces)
    {
      this->search();
    }
    this->Result.close();
    this->report(1.0);
    return std::move(this->Result);
  }

private:
  bool alone() const { return this->Ranks.size() == 1; }

  void report(double fraction) const
  {
    this->Ranks.together([&] { this->Run.report(fraction); });
  }

  /// Finds what the undecided quadrilaterals meet; those that meet nothing stay undecided.
  void search()
  {
    const std::vector<Index> known = this->alone()
      ? this->undecided()
      : fetchNearQuads(this->Part, this->Surface, this->Result, this->Options.matchTolerance, this->Run);
    if (!this->Ranks.any(!known.empty()))
    {
      return;
    }
    const Contacts before = this->Result;
    std::vector<Index> single;
    const auto pair = [&] {
      this->Ranks.together([&] { this->pairQuads(known); });
      shareContacts(this->Result, before, known, this->Surface, this->Part, this->Ranks);
      single = this->undecided(known);
    };
    this->Ranks.together([&] { this->mergeEqualPoints(known); });
    pair();
    this->report(0.6);
    bool merged = false;
    this->Ranks.together([&] { merged = this->mergeNearPoints(known, single); });
    if (this->Ranks.any(merged))
    {
      this->Result = before;
      pair();
    }
    this->report(0.8);
    this->refuseCoveredQuads(single);
  }

  double tolerance(int block, const Ijk& p) const
  {
    return matchDistance(this->Mesh.blocks[block].points, p, this->Options.matchTolerance);
  }

  Vec3 pointOf(Index point) const
  {
    const int block = this->Points->blockOfPoint(point);
    return this->Mesh.blocks[block].points(this->Points->pointAt(block, point));
  }

  Vec3 corner(const QuadAt& at, int cs, int ct) const
  {
    return this->Mesh.blocks[at.block].points(this->Surface.corner(at, cs, ct));
  }

  Vec3 center(const QuadAt& at) const
  {
    return 0.25 *
      ((this->corner(at, 0, 0) + this->corner(at, 1, 1)) + (this->corner(at, 1, 0) + this->corner(at, 0, 1)));
  }

  std::string where(const QuadAt& at) const
  {
    return blockLabel(this->Mesh, at.block) + " " + faceLabel(at.face) + " quadrilateral (" + std::to_string(at.s) +
      ", " + std::to_string(at.t) + ")";
  }

  std::string where(Index quad) const { return this->where(this->Surface.quadAt(quad)); }

  void checkRange(const std::string& what, int block, int face, const FaceRange& range) const
  {
    if (block < 0 || block >= this->Surface.blockCount())
    {
      throw Error(what + ": there is no block " + std::to_string(block));
    }
    if (face < 0 || face > 5)
    {
      throw Error(what + ": there is no face " + std::to_string(face));
    }
    for (int axis = 0; axis < 2; ++axis)
    {
      const int n = this->Surface.faceCells(block, face, axis);
      if (range.lo[axis] < 0 || range.lo[axis] >= range.hi[axis] || range.hi[axis] > n)
      {
        throw Error(what + ": range " + std::to_string(range.lo[axis]) + " to " + std::to_string(range.hi[axis]) +
          " of axis " + std::to_string(axis) + " is not inside 0 to " + std::to_string(n) + " of " +
          blockLabel(this->Mesh, block) + " " + faceLabel(face));
      }
    }
  }

  /// How the points of the two sides of a contact compare.
  struct Comparison
  {
    bool sameBits = true;
    /// First pair further apart than allowed, if distance > allowed.
    Ijk pointA{ 0, 0, 0 };
    Ijk pointB{ 0, 0, 0 };
    double distance = 0.0;
    double allowed = 0.0;
  };

  /// Compares the two sides; ends at the first difference in bits if only that is asked.
  Comparison compare(const Interface& contact, bool bitsOnly) const
  {
    const FaceRange& a = contact.rangeA;
    const int ns = a.hi[0] - a.lo[0];
    const int nt = a.hi[1] - a.lo[1];
    const GridView& pointsA = this->Mesh.blocks[contact.blockA].points;
    const GridView& pointsB = this->Mesh.blocks[contact.blockB].points;
    const auto onA = [&](int s, int t) {
      return facePoint(this->Surface.cells(contact.blockA), contact.faceA, a.lo[0] + s, a.lo[1] + t);
    };
    const auto onB = [&](int s, int t) {
      const auto st = mapFacePoint(contact.orientation, s, t, ns, nt);
      return facePoint(
        this->Surface.cells(contact.blockB), contact.faceB, contact.originB[0] + st[0], contact.originB[1] + st[1]);
    };
    const Index startA = pointsA.offset(onA(0, 0)), startB = pointsB.offset(onB(0, 0));
    const Index alongSA = pointsA.offset(onA(1, 0)) - startA, alongSB = pointsB.offset(onB(1, 0)) - startB;
    const Index alongTA = pointsA.offset(onA(0, 1)) - startA, alongTB = pointsB.offset(onB(0, 1)) - startB;
    Comparison result;
    for (int t = 0; t <= nt; ++t)
    {
      for (int s = 0; s <= ns; ++s)
      {
        const Vec3 x = pointsA.atOffset(startA + s * alongSA + t * alongTA);
        const Vec3 y = pointsB.atOffset(startB + s * alongSB + t * alongTB);
        if (sameBits(x, y))
        {
          continue;
        }
        result.sameBits = false;
        if (bitsOnly)
        {
          return result;
        }
        result.pointA = onA(s, t);
        result.pointB = onB(s, t);
        result.distance = (x - y).norm();
        result.allowed =
          std::min(this->tolerance(contact.blockA, result.pointA), this->tolerance(contact.blockB, result.pointB));
        if (result.distance > result.allowed)
        {
          return result;
        }
      }
    }
    return result;
  }

  /// Compares many contacts, in parallel; each on the rank of its first block.
  std::vector<Comparison> compare(const std::vector<Interface>& contacts, bool bitsOnly)
  {
    std::vector<PointBox> wanted;
    for (const Interface& contact : contacts)
    {
      if (this->Part.isHere(contact.blockA) && !this->Part.isHere(contact.blockB))
      {
        // Tolerances need the points next to those of the contact.
        wanted.push_back(pointsAtFace(
          this->Mesh, contact.blockB, contact.faceB, contact.rangeB(), bitsOnly ? 1 : 2, bitsOnly ? 0 : 1));
      }
    }
    this->Part.fetch(wanted);
    std::vector<Comparison> results(contacts.size());
    this->Ranks.together([&] {
      this->Run.parallelFor(static_cast<Index>(contacts.size()), 16, [&](Index begin, Index end) {
        for (Index n = begin; n < end; ++n)
        {
          if (this->Part.isHere(contacts[n].blockA))
          {
            results[n] = this->compare(contacts[n], bitsOnly);
          }
        }
      });
    });
    this->Ranks.share(results, [&](Index n) { return this->Part.rankOf(contacts[n].blockA); });
    return results;
  }

  /// Compares declared contacts. Mostly one layer of points, which are the same, is all that other ranks must send.
  std::vector<Comparison> compareDeclared()
  {
    const std::vector<Interface>& all = this->Mesh.interfaces;
    if (this->alone())
    {
      return this->compare(all, false);
    }
    std::vector<Comparison> results = this->compare(all, true);
    std::vector<Interface> different;
    for (std::size_t n = 0; n < all.size(); ++n)
    {
      if (!results[n].sameBits)
      {
        different.push_back(all[n]);
      }
    }
    const std::vector<Comparison> compared = this->compare(different, false);
    auto next = compared.begin();
    for (Comparison& result : results)
    {
      result = result.sameBits ? result : *next++;
    }
    return results;
  }

  void takeInterfaces()
  {
    for (std::size_t n = 0; n < this->Mesh.interfaces.size(); ++n)
    {
      const Interface& contact = this->Mesh.interfaces[n];
      const std::string what = "interface " + std::to_string(n);
      if (contact.orientation < 0 || contact.orientation > 7)
      {
        throw Error(what + ": there is no orientation " + std::to_string(contact.orientation));
      }
      this->checkRange(what, contact.blockA, contact.faceA, contact.rangeA);
      // The size of A is known to be sane now; the origin on B may be anything.
      for (int axis = 0; axis < 2; ++axis)
      {
        if (contact.originB[axis] < 0 || contact.originB[axis] > std::numeric_limits<int>::max() / 2)
        {
          throw Error(what + ": there is no point " + std::to_string(contact.originB[axis]) + " on its second face");
        }
      }
      this->checkRange(what, contact.blockB, contact.faceB, contact.rangeB());
    }
    const std::vector<Comparison> compared = this->compareDeclared();
    for (std::size_t n = 0; n < compared.size(); ++n)
    {
      const Interface& contact = this->Mesh.interfaces[n];
      const Comparison& c = compared[n];
      const std::string what = "interface " + std::to_string(n);
      if (c.distance > c.allowed)
      {
        throw Error(what + " does not match the coordinates: point " + text(c.pointA) + " of " +
          blockLabel(this->Mesh, contact.blockA) + " " + faceLabel(contact.faceA) + " and point " + text(c.pointB) +
          " of " + blockLabel(this->Mesh, contact.blockB) + " " + faceLabel(contact.faceB) + " are " +
          text(c.distance) + " apart, allowed is " + text(c.allowed));
      }
      this->take(contact, what);
      this->noteSameBits(contact, c);
    }
  }

  /// The faces of a contact that covers both are known to be equal, if they are.
  void noteSameBits(const Interface& contact, const Comparison& compared)
  {
    if (compared.sameBits && this->whole(contact))
    {
      this->Result.setSameBits(contact.blockA, contact.faceA);
      this->Result.setSameBits(contact.blockB, contact.faceB);
    }
  }

  bool whole(int block, int face, const FaceRange& range) const
  {
    return range.lo == std::array<int, 2>{ 0, 0 } && range.hi[0] == this->Surface.faceCells(block, face, 0) &&
      range.hi[1] == this->Surface.faceCells(block, face, 1);
  }
  bool whole(const Interface& contact) const
  {
    return this->whole(contact.blockA, contact.faceA, contact.rangeA) &&
      this->whole(contact.blockB, contact.faceB, contact.rangeB());
  }

  /// Enters the contact of all quadrilaterals of an interface.
  void take(const Interface& contact, const std::string& what)
  {
    const bool folded = contact.blockA == contact.blockB && contact.faceA == contact.faceB;
    if (this->whole(contact) && !folded && this->Result.undecided(contact.blockA, contact.faceA) &&
      this->Result.undecided(contact.blockB, contact.faceB))
    {
      this->Result.setContact(contact);
      return;
    }
    const FaceRange& a = contact.rangeA;
    const int ns = a.hi[0] - a.lo[0];
    const int nt = a.hi[1] - a.lo[1];
    for (int t = 0; t < nt; ++t)
    {
      for (int s = 0; s < ns; ++s)
      {
        // The quadrilateral (s, t) is the point (s, t) of a grid that has one point less per axis.
        const auto onB = mapFacePoint(contact.orientation, s, t, ns - 1, nt - 1);
        const QuadAt quadA{ contact.blockA, contact.faceA, a.lo[0] + s, a.lo[1] + t };
        const QuadAt quadB{ contact.blockB, contact.faceB, contact.originB[0] + onB[0], contact.originB[1] + onB[1] };
        if (folded && quadA.s == quadB.s && quadA.t == quadB.t)
        {
          throw Error(what + ": " + this->where(quadA) + " meets itself");
        }
        for (const QuadAt& quad : { quadA, quadB })
        {
          if (!this->Result.undecided(quad))
          {
            throw Error(what + ": " + this->where(quad) + " is in another interface already");
          }
        }
        this->Result.setContact(quadA, quadB, contact.orientation);
      }
    }
  }

  /// Takes pairs of faces, undecided as a whole, that are equal point by point and bit by bit: what most contacts are,
  /// found without a search for the single points.
  void takeWholeFaces()
  {
    this->gatherCorners();
    const Index faceCount = 6 * Index(this->Surface.blockCount());
    constexpr Index None = -1;
    constexpr Index Several = -2;
    std::vector<Index> partner(faceCount, None);
    std::vector<int> orientation(faceCount, 0);
    FirstOccurrence first(faceCount);
    for (Index face = 0; face < faceCount; ++face)
    {
      if (!this->Result.undecided(static_cast<int>(face / 6), static_cast<int>(face % 6)))
      {
        continue;
      }
      // Sums do not depend on the order of the corners.
      std::uint64_t hash = 0;
      for (int c = 0; c < 4; ++c)
      {
        hash += hashOf(this->faceCornerPoint(face, c & 1, c >> 1));
      }
      const Index other =
        first.insert(mix(0, hash), face, [&](Index a) { return this->faceOrientation(a, face) >= 0; });
      if (other == face)
      {
        continue;
      }
      partner[face] = other;
      partner[other] = partner[other] == None ? face : Several;
      orientation[other] = this->faceOrientation(other, face);
    }
    std::vector<Interface> candidates;
    for (Index face = 0; face < faceCount; ++face)
    {
      const Index other = partner[face];
      if (other > face && partner[other] == face)
      {
        const int block = static_cast<int>(face / 6);
        const int side = static_cast<int>(face % 6);
        Interface contact;
        contact.blockA = block;
        contact.faceA = side;
        contact.blockB = static_cast<int>(other / 6);
        contact.faceB = static_cast<int>(other % 6);
        contact.orientation = orientation[face];
        contact.rangeA.hi = { this->Surface.faceCells(block, side, 0), this->Surface.faceCells(block, side, 1) };
        candidates.push_back(contact);
      }
    }
    const std::vector<Comparison> compared = this->compare(candidates, true);
    for (std::size_t n = 0; n < compared.size(); ++n)
    {
      if (compared[n].sameBits)
      {
        this->take(candidates[n], "contact");
        this->noteSameBits(candidates[n], compared[n]);
      }
    }
  }

  /// Every rank gets the corners of all blocks.
  void gatherCorners()
  {
    if (this->alone())
    {
      return;
    }
    this->Corners.resize(this->Surface.blockCount());
    for (int b = 0; b < this->Surface.blockCount(); ++b)
    {
      for (int c = 0; c < 8 && this->Part.isHere(b); ++c)
      {
        const Ijk& n = this->Surface.cells(b);
        const Vec3 x =
          this->Mesh.blocks[b].points(cornerSide(c, 0) * n[0], cornerSide(c, 1) * n[1], cornerSide(c, 2) * n[2]);
        std::copy(x.data(), x.data() + 3, &this->Corners[b][3 * c]);
      }
    }
    this->Ranks.share(this->Corners, [this](Index b) { return this->Part.rankOf(static_cast<int>(b)); });
  }

  Vec3 faceCornerPoint(Index face, int cs, int ct) const
  {
    const int block = static_cast<int>(face / 6);
    const int side = static_cast<int>(face % 6);
    if (!this->Corners.empty())
    {
      return Vec3(&this->Corners[block][3 * faceCorner(side, cs, ct)]);
    }
    return this->Mesh.blocks[block].points(facePoint(this->Surface.cells(block), side,
      cs * this->Surface.faceCells(block, side, 0), ct * this->Surface.faceCells(block, side, 1)));
  }

  /// The one orientation code in which the corners of two faces are equal, or -1.
  int faceOrientation(Index a, Index b) const
  {
    int found = -1;
    for (int code = 0; code < 8; ++code)
    {
      bool fits = true;
      for (int axis = 0; axis < 2; ++axis)
      {
        fits = fits &&
          this->Surface.faceCells(static_cast<int>(a / 6), static_cast<int>(a % 6), axis) ==
            this->Surface.faceCells(
              static_cast<int>(b / 6), static_cast<int>(b % 6), swapsAxes(code) ? 1 - axis : axis);
      }
      for (int c = 0; c < 4 && fits; ++c)
      {
        const auto onB = mapFacePoint(code, c & 1, c >> 1, 1, 1);
        fits = this->faceCornerPoint(a, c & 1, c >> 1) == this->faceCornerPoint(b, onB[0], onB[1]);
      }
      if (fits)
      {
        if (found >= 0)
        {
          return -1;
        }
        found = code;
      }
    }
    return found;
  }

  void takeBoundary(int n)
  {
    const BoundaryPatch& patch = this->Mesh.boundaries[n];
    const std::string what = "boundary " + std::to_string(n);
    this->checkRange(what, patch.block, patch.face, patch.range);
    const int names = static_cast<int>(this->Mesh.boundaryNames.size());
    if (patch.tag < 0 || patch.tag >= names)
    {
      throw Error(what + ": there is no boundary name " + std::to_string(patch.tag) + ", " + std::to_string(names) +
        " are given");
    }
    if (this->whole(patch.block, patch.face, patch.range) && this->Result.undecided(patch.block, patch.face))
    {
      this->Result.setBoundary(patch.block, patch.face, patch.tag);
      return;
    }
    for (int t = patch.range.lo[1]; t < patch.range.hi[1]; ++t)
    {
      for (int s = patch.range.lo[0]; s < patch.range.hi[0]; ++s)
      {
        const QuadAt quad{ patch.block, patch.face, s, t };
        if (!this->Result.undecided(quad))
        {
          if (!this->Result.boundary(quad))
          {
            throw Error(what + ": " + this->where(quad) + " is in an interface already");
          }
          if (this->Result.tag(quad) != patch.tag)
          {
            throw Error(what + ": " + this->where(quad) + " belongs to boundary \"" +
              this->Mesh.boundaryNames[this->Result.tag(quad)] + "\" already");
          }
        }
        this->Result.setBoundary(quad, patch.tag);
      }
    }
  }

  std::vector<Index> undecided() const
  {
    std::vector<Index> quads;
    for (int block = 0; block < this->Surface.blockCount(); ++block)
    {
      for (int face = 0; face < 6; ++face)
      {
        appendUndecided(this->Surface, this->Result, block, face, nullptr, quads);
      }
    }
    return quads;
  }

  /// Those of a list.
  std::vector<Index> undecided(const std::vector<Index>& quads) const
  {
    std::vector<Index> result;
    QuadAt at;
    for (Index quad : quads)
    {
      at = this->Surface.quadAt(quad, at.block);
      if (this->Result.undecided(at))
      {
        result.push_back(quad);
      }
    }
    return result;
  }

  /// Calls visit(block, position, surface point) once for every corner of the quadrilaterals, in ascending order.
  template <typename Visit>
  void forEachPoint(const std::vector<Index>& quads, const Visit& visit) const
  {
    std::vector<bool> used;
    for (auto next = quads.begin(); next != quads.end();)
    {
      QuadAt at = this->Surface.quadAt(*next);
      const int block = at.block;
      const Index first = this->Points->firstPoint(block);
      const Index count = this->Points->firstPoint(block + 1) - first;
      used.assign(count, false);
      for (; next != quads.end() && *next < this->Surface.firstQuad(block + 1); ++next)
      {
        at = this->Surface.quadAt(*next, block);
        for (Index point : this->Points->corners(at))
        {
          used[point - first] = true;
        }
      }
      for (Index point = 0; point < count; ++point)
      {
        if (used[point])
        {
          visit(block, this->Points->pointAt(block, first + point), first + point);
        }
      }
    }
  }

  void mergeEqualPoints(const std::vector<Index>& quads)
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
    FirstOccurrence first(std::min(this->Points->pointCount(), 4 * static_cast<Index>(quads.size())));
    this->forEachPoint(quads, [&](int block, const Ijk& p, Index point) {
      const Vec3 x = this->Mesh.blocks[block].points(p);
      this->Class[point] = first.insert(hashOf(x), point, [&](Index other) { return this->pointOf(other) == x; });
    });
  }

  Key key(const QuadAt& at) const
  {
    Key classes = this->Points->corners(at);
    for (Index& c : classes)
    {
      c = this->Class[c];
    }
    return classes;
  }

  /// Pairs the quadrilaterals with equal classes.
  void pairQuads(const std::vector<Index>& quads)
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
          throw ErrorAt(
            quad, this->where(at) + " is collapsed: two of its points coincide near " + text(this->center(at)));
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

  /// Orientation code from quadrilateral `a` to `quadB` with the classes `b`, which are a's in another order.
  int orientation(const QuadAt& a, Index quadB, const Key& b) const
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
    throw ErrorAt(
      quadB, "ambiguous gluing: " + this->where(a) + " shares its four points with a twisted quadrilateral");
  }

  /// Merges classes of points that are near each other, around quadrilaterals without a partner. True if any were.
  ///
  /// Of classes with a point here all members and all near classes are known. Others may be known in part only; they
  /// are merged with those alone. If nothing is refused on any rank, all that are merged are near each other, so that
  /// this is enough to know all points of a class.
  bool mergeNearPoints(const std::vector<Index>& quads, const std::vector<Index>& single)
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
    std::vector<Box> boxes(count);
    for (Index n = 0; n < count; ++n)
    {
      x[n] = this->pointOf(points[n]);
      boxes[n] = Box(x[n]);
    }
    const BoxTree tree(boxes);
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

  /// Number of a point that is the same on all ranks.
  Index place(Index point) const
  {
    const int block = this->Points->blockOfPoint(point);
    return this->Surface.point(block, this->Points->pointAt(block, point));
  }

  /// All members of a class must be near each other: a chain of near points is not one point.
  void checkWidths(const std::vector<Index>& points, const std::vector<Vec3>& x, const std::vector<double>& tolerance,
    UnionFind& merged) const
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

  /// Refuses quadrilaterals without a partner that lie on one another face to face: an interface that does not match
  /// node to node. Walls that are merely close are further apart than the matching tolerance.
  void refuseCoveredQuads(const std::vector<Index>& single) const
  {
    std::vector<Index> cover;
    Index first = -1;
    Index covered = 0;
    this->Ranks.together([&] {
      cover = this->covers(single);
      for (Index n = static_cast<Index>(single.size()) - 1; n >= 0; --n)
      {
        if (cover[n] >= 0)
        {
          first = n;
          ++covered;
        }
      }
    });
    Index onAllRanks = 0;
    for (Index part : this->Ranks.gatherAll(std::vector<Index>{ covered }))
    {
      onAllRanks += part;
    }
    this->Ranks.together([&] {
      if (covered > 0)
      {
        const QuadAt a = this->Surface.quadAt(single[first]);
        const QuadAt b = this->Surface.quadAt(cover[first]);
        throw ErrorAt(single[first],
          "non-matching interface: " + this->where(a) + " and " + this->where(b) + " cover each other near " +
            text(this->center(a)) + " but do not share their points (" + std::to_string(onAllRanks) +
            " such quadrilaterals); declare them as boundaries if they are no contact");
      }
    });
  }

  /// Per quadrilateral the one that covers its center, or -1 if none does or it is not here.
  std::vector<Index> covers(const std::vector<Index>& single) const
  {
    const Index count = static_cast<Index>(single.size());
    std::vector<Box> boxes(count);
    std::vector<double> tolerance(count);
    std::vector<Vec3> normal(count);
    this->Run.parallelFor(count, Chunk, [&](Index begin, Index end) {
      for (Index n = begin; n < end; ++n)
      {
        const QuadAt at = this->Surface.quadAt(single[n]);
        normal[n] = outwardNormal(this->Mesh, this->Surface, at, this->LeftHanded[at.block]).stableNormalized();
        tolerance[n] = std::numeric_limits<double>::max();
        for (int c = 0; c < 4; ++c)
        {
          const Ijk p = this->Surface.corner(at, c & 1, c >> 1);
          boxes[n].extend(this->Mesh.blocks[at.block].points(p));
          tolerance[n] = std::min(tolerance[n], this->tolerance(at.block, p));
        }
        boxes[n] = inflated(boxes[n], tolerance[n]);
      }
    });
    const BoxTree tree(boxes);
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

  /// On curved faces the centers are apart. There at least a quadrilateral is covered whose corners are all shared with
  /// others that face it and have their centers before it: a coarse one that meets a refined face.
  void coverByCorners(
    const std::vector<Index>& single, const std::vector<Vec3>& normal, std::vector<Index>& cover) const
  {
    const Index count = static_cast<Index>(single.size());
    std::vector<std::pair<Index, Index>> atClass;
    for (Index n = 0; n < count; ++n)
    {
      for (Index c : this->key(this->Surface.quadAt(single[n])))
      {
        atClass.push_back({ c, n });
      }
    }
    std::sort(atClass.begin(), atClass.end());
    this->Run.parallelFor(count, Chunk, [&](Index begin, Index end) {
      for (Index n = begin; n < end; ++n)
      {
        Index shared = 0;
        Index other = -1;
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
        for (Index c : this->key(quad))
        {
          auto at = std::lower_bound(atClass.begin(), atClass.end(), std::make_pair(c, Index(0)));
          while (at != atClass.end() && at->first == c && !before(at->second))
          {
            ++at;
          }
          if (at != atClass.end() && at->first == c)
          {
            ++shared;
            other = at->second;
          }
        }
        if (shared == 4 && cover[n] < 0)
        {
          cover[n] = single[other];
        }
      }
    });
  }

  /// Opposite within 25 degrees.
  static bool facing(const Vec3& normalA, const Vec3& normalB) { return normalA.dot(normalB) < -0.9; }

  /// Whether the quadrilateral of unit normal `n` has `x` in its interior, up to `tolerance` along its normal.
  bool covers(const QuadAt& at, const Vec3& n, const Vec3& x, double tolerance) const
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

  static constexpr Index Chunk = 1024;
  /// More points than blocks of any sensible mesh meet.
  static constexpr int MostCopies = 1000;

  PartialMesh& Part;
  const BlockMesh& Mesh;
  const SurfaceNumbering& Surface;
  const std::vector<bool>& LeftHanded;
  const BlockComplexOptions& Options;
  const Execution& Run;
  const bsv::Ranks& Ranks;
  Contacts Result;
  /// Per block the coordinates of its corners, if there are other ranks.
  std::vector<std::array<double, 24>> Corners;
  /// The points of the blocks where something is searched.
  std::optional<SurfaceNumbering> Points;
  /// Per such point the one that stands for its class, or -1 where nothing is searched.
  std::vector<Index> Class;
};

} // namespace

Contacts glue(PartialMesh& mesh, const SurfaceNumbering& surface, const std::vector<bool>& leftHanded,
  const BlockComplexOptions& options, const Execution& run)
{
  return Gluer(mesh, surface, leftHanded, options, run).glue();
}

} // namespace bsv
