// SPDX-License-Identifier: BSD-3-Clause
// What the separation surfaces enclose.
#include "Complex/HexDecomposition.h"

#include <algorithm>

namespace bsv
{

void HexDecomposition::flood()
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

Index HexDecomposition::flood(HexId seed, Index at)
{
  const HexId number = static_cast<HexId>(this->Regions.size());
  HexRegion region;
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

HexDecomposition::FaceKey HexDecomposition::keyOf(HexId face) const
{
  FaceKey key;
  const int f = static_cast<int>(face % 6);
  for (int c = 0; c < 4; ++c)
  {
    key.points[c] = this->point(this->corner(face / 6, faceCorner(f, c & 1, c >> 1)));
  }
  std::sort(key.points.begin(), key.points.end(), [](const Vec3& a, const Vec3& b) { return placeOrder(a, b) < 0; });
  return key;
}

void HexDecomposition::openClosedRegions()
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

void HexDecomposition::floodAgain(const std::vector<char>& touched)
{
  std::vector<HexRegion> before;
  before.swap(this->Regions);
  const std::vector<HexId> cells = this->Order;
  for (std::size_t r = 0; r < before.size(); ++r)
  {
    const HexRegion& region = before[r];
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

HexDecomposition::Sheet HexDecomposition::bestSheet(HexId r) const
{
  const HexRegion& region = this->Regions[r];
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
    throw Error("the cells around " + this->cell(cells[0]) + ", near " + text(this->point(this->corner(cells[0], 0))) +
      ", are no grid although all their edges are regular");
  }
  return best;
}

} // namespace bsv
