// SPDX-License-Identifier: BSD-3-Clause
// Larger blocks.
#include "Complex/HexDecomposition.h"

#include <algorithm>

namespace bsv
{

HexDecomposition::Member HexDecomposition::memberBehind(const Member& member, int face) const
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

HexDecomposition::LargerBlock HexDecomposition::layerBehind(
  const LargerBlock& larger, int face, const std::vector<char>& used) const
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

Index HexDecomposition::cellsIn(const LargerBlock& larger) const
{
  Index cells = 0;
  for (const Member& member : larger.members)
  {
    cells += static_cast<Index>(this->Result.blocks[member.block].cellIds.size());
  }
  return cells;
}

void HexDecomposition::mergeBlocks()
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

HexDecomposition::LargerBlock HexDecomposition::grown(const LargerBlock& larger, const LargerBlock& layer, int face)
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

} // namespace bsv
