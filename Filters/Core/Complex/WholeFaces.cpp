// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/WholeFaces.h"

#include "Base/FirstOccurrence.h"
#include "Complex/BlockComplex.h"

#include <algorithm>

namespace bsv
{

void WholeFaces::operator()()
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
    const Index other = first.insert(mix(0, hash), face, [&](Index a) { return this->faceOrientation(a, face) >= 0; });
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
  if (this->Options.allowDegenerate)
  {
    this->withoutCollapsed(candidates);
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

void WholeFaces::withoutCollapsed(std::vector<Interface>& contacts) const
{
  std::vector<char> collapsed(contacts.size(), 0);
  this->Run.parallelFor(static_cast<Index>(contacts.size()), 16, [&](Index begin, Index end) {
    for (Index n = begin; n < end; ++n)
    {
      collapsed[n] = this->Part.isHere(contacts[n].blockA) && this->hasCollapsed(contacts[n].blockA, contacts[n].faceA);
    }
  });
  this->Ranks.share(collapsed, [&](Index n) { return this->Part.rankOf(contacts[n].blockA); });
  std::vector<Interface> kept;
  for (std::size_t n = 0; n < contacts.size(); ++n)
  {
    if (!collapsed[n])
    {
      kept.push_back(contacts[n]);
    }
  }
  contacts = kept;
}

bool WholeFaces::hasCollapsed(int block, int face) const
{
  for (int t = 0; t < this->Surface.faceCells(block, face, 1); ++t)
  {
    for (int s = 0; s < this->Surface.faceCells(block, face, 0); ++s)
    {
      const QuadAt at{ block, face, s, t };
      const std::array<Vec3, 4> x{ this->corner(at, 0, 0), this->corner(at, 1, 0), this->corner(at, 0, 1),
        this->corner(at, 1, 1) };
      for (int a = 0; a < 4; ++a)
      {
        for (int b = a + 1; b < 4; ++b)
        {
          if (x[a] == x[b])
          {
            return true;
          }
        }
      }
    }
  }
  return false;
}

void WholeFaces::gatherCorners()
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

Vec3 WholeFaces::faceCornerPoint(Index face, int cs, int ct) const
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

int WholeFaces::faceOrientation(Index a, Index b) const
{
  int found = -1;
  for (int code = 0; code < 8; ++code)
  {
    bool fits = true;
    for (int axis = 0; axis < 2; ++axis)
    {
      fits = fits &&
        this->Surface.faceCells(static_cast<int>(a / 6), static_cast<int>(a % 6), axis) ==
          this->Surface.faceCells(static_cast<int>(b / 6), static_cast<int>(b % 6), swapsAxes(code) ? 1 - axis : axis);
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

} // namespace bsv
