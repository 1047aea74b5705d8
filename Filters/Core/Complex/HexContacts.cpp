// SPDX-License-Identifier: BSD-3-Clause
// What block faces meet, and the names of boundaries.
#include "Base/UnionFind.h"

#include "Complex/HexDecomposition.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>

namespace bsv
{

HexDecomposition::Contact HexDecomposition::contact(HexId face, int blockFace) const
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

bool HexDecomposition::continues(const Contact& first, const Contact& other, const std::array<int, 2>& step)
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

void HexDecomposition::makeContacts()
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

void HexDecomposition::makeContacts(int block, int face)
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

void HexDecomposition::nameBoundaries()
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

void HexDecomposition::quadPoints(int block, int face, int s, int t, HexId (&p)[2][2]) const
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

} // namespace bsv
