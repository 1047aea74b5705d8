// SPDX-License-Identifier: BSD-3-Clause
/// @file HexDecomposition.h
/// The steps of baseComplex(), in the order of their files: SeparationSurfaces, HexRegions, HexGrids, HexBlockMerging,
/// HexContacts. Only these include it.
#pragma once

#include "Complex/BaseComplex.h"
#include "Complex/HexFrames.h"
#include "Mesh/BlockSurface.h"

#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace bsv
{

/// Lexicographic order of places: negative, zero or positive.
inline int placeOrder(const Vec3& a, const Vec3& b)
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
struct HexRegion
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

/// What the parts of baseComplex() share.
class HexDecomposition
{
public:
  HexDecomposition(HexMesh& mesh, const BaseComplexOptions& options, const Execution& run)
    : Mesh(mesh)
    , Options(options)
    , Run(run)
    , Frames(HexFrames::instance())
  {
  }

  BaseComplex decompose();

private:
  Vec3 point(HexId id) const { return this->Mesh.points.atPlace(id); }
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

  // SeparationSurfaces

  /// Looks at the cells around every point: refuses those that share no face there, and makes the faces at singular
  /// edges separating.
  void findSingularEdges();

  struct OneRing
  {
    std::vector<int> parent;
    /// The other end of an edge, and 16 * cell + edge.
    std::vector<std::pair<HexId, std::uint64_t>> edges;
  };

  /// @return the number of singular edges to points of higher numbers
  Index lookAround(HexId p, const HexId* corners, HexId count, OneRing& ring);
  /// One of the two faces at an edge 16 * cell + edge.
  HexId faceAt(std::uint64_t edge, int side) const
  {
    return static_cast<HexId>(edge / 16) * 6 + this->Frames.edgeFace(static_cast<int>(edge % 16), side);
  }

  [[noreturn]] void refuseEdge(HexId p, const OneRing& ring, std::size_t begin, std::size_t end) const;
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
  void spread();

  // HexRegions

  /// Gives all cells a region, a place and a frame.
  void flood();
  /// Floods one region from a cell; its cells become Order[at, result).
  Index flood(HexId seed, Index at);
  /// A face of a cell as seen from any numbering.
  struct FaceKey
  {
    std::array<Vec3, 4> points{ Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero() };

    int compare(const FaceKey& other) const
    {
      for (int c = 0; c < 4; ++c)
      {
        if (const int o = placeOrder(this->points[c], other.points[c]))
        {
          return o;
        }
      }
      return 0;
    }
  };

  FaceKey keyOf(HexId face) const;
  /// A surface that would cut a closed region.
  struct Sheet
  {
    HexId region = NoHexId;
    HexId face = NoHexId;
    Index size = 0;
    FaceKey key;

    bool before(const Sheet& other) const
    {
      return this->size != other.size ? this->size < other.size : this->key.compare(other.key) < 0;
    }
  };

  /// Cuts regions that close on themselves until none does.
  void openClosedRegions();
  /// Floods the cells of some regions once more.
  void floodAgain(const std::vector<char>& touched);
  /// Of the surfaces across a line of cells that closes on itself the one with the fewest faces.
  Sheet bestSheet(HexId r) const;

  // HexGrids

  /// Makes a grid of every region.
  void makeBlocks();
  /// A grid of cells before its origin and directions are chosen.
  class Grid;
  /// A grid seen with another origin and directions: those of a frame.
  struct View;
  /// Order of two grids of points, `pointOf` giving the number of a point: the smallest origin, from which the
  /// directions run as far as they can.
  template <typename PointA, typename PointB>
  int compare(const PointA& a, const Ijk& cellsA, const PointB& b, const Ijk& cellsB) const;
  int compare(const View& a, const View& b) const;
  int compare(const HexBlock& a, const HexBlock& b) const;
  HexBlock makeBlock(const HexRegion& region);
  /// 1 if most cells of the grid are right-handed in it, else -1.
  int handedness(const Grid& grid) const;

  // HexContacts and the merging: what lies on a block face

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

  Contact contact(HexId face, int blockFace) const;
  /// Whether a quadrilateral `step` away along the face continues the contact of the first one.
  static bool continues(const Contact& first, const Contact& other, const std::array<int, 2>& step);

  // HexBlockMerging

  /// A block in a larger one, and how its directions lie there.
  struct Member
  {
    int block;
    Frame frame;
  };

  /// The member behind a face of a larger block at one of its members, or one with the block -1.
  Member memberBehind(const Member& member, int face) const;
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
  LargerBlock layerBehind(const LargerBlock& larger, int face, const std::vector<char>& used) const;
  Index cellsIn(const LargerBlock& larger) const;
  /// Lets the largest blocks grow, one after another, each over the face behind which most cells lie.
  void mergeBlocks();
  /// A larger block with one more layer behind a face.
  static LargerBlock grown(const LargerBlock& larger, const LargerBlock& layer, int face);

  // HexContacts

  /// Rectangles of quadrilaterals that meet one face, or have one name.
  void makeContacts();
  void makeContacts(int block, int face);
  /// Keeps the named patches or, if there are none, makes boundaries of the patches that are smooth together.
  void nameBoundaries();
  /// Points of a quadrilateral of a block face, [s][t].
  void quadPoints(int block, int face, int s, int t, HexId (&p)[2][2]) const;

  // BaseComplex

  void tell();

  HexMesh& Mesh;
  const BaseComplexOptions& Options;
  const Execution& Run;
  const HexFrames& Frames;
  HexNeighbours Neighbours;
  /// Per face whether a separation surface runs there; both sides agree. Written by several threads.
  std::unique_ptr<std::atomic<std::uint8_t>[]> Separating;
  std::vector<HexId> Front;
  std::vector<HexRegion> Regions;
  /// Cells, region by region.
  std::vector<HexId> Order;
  /// Per cell: first in its region, later in its block.
  std::vector<HexId> RegionOf;
  std::vector<Ijk> PlaceOf;
  std::vector<std::uint8_t> FrameOf;
  BaseComplex Result;
};

} // namespace bsv
