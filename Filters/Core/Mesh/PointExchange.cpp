// SPDX-License-Identifier: BSD-3-Clause
#include "Mesh/PointExchange.h"

#include <algorithm>

namespace bsv
{
namespace
{

Index sizeOf(const PointBox& box)
{
  Index size = 1;
  for (int d = 0; d < 3; ++d)
  {
    size *= box.hi[d] - box.lo[d] + 1;
  }
  return size;
}

} // namespace

void PointBoxes::add(const std::array<int, 3>& lo, const std::array<int, 3>& hi, std::vector<double> xyz)
{
  this->Boxes.push_back({ lo, hi, std::move(xyz) });
}

const double* PointBoxes::find(Index offset) const
{
  const Index row = offset / this->Counts[0];
  const std::array<Index, 3> at{ offset % this->Counts[0], row % this->Counts[1], row / this->Counts[1] };
  for (const Box& box : this->Boxes)
  {
    Index inBox = 0;
    bool inside = true;
    for (int d = 2; d >= 0; --d)
    {
      inside = inside && at[d] >= box.lo[d] && at[d] <= box.hi[d];
      inBox = inBox * (box.hi[d] - box.lo[d] + 1) + (at[d] - box.lo[d]);
    }
    if (inside)
    {
      return box.points.data() + 3 * inBox;
    }
  }
  return nullptr;
}

std::vector<std::shared_ptr<PointBoxes>> fetchPoints(const std::vector<PointBox>& wanted, int blockCount,
  const std::function<int(int block)>& rankOf, const std::function<GridView&(int block)>& viewOf, const Ranks& ranks)
{
  std::vector<std::vector<PointBox>> requests(ranks.size());
  for (const PointBox& box : wanted)
  {
    if (rankOf(box.block) != ranks.rank())
    {
      requests[rankOf(box.block)].push_back(box);
    }
  }
  std::vector<std::vector<double>> replies(ranks.size());
  const std::vector<std::vector<PointBox>> asked = ranks.exchange(requests);
  for (int r = 0; r < ranks.size(); ++r)
  {
    Index size = 0;
    for (const PointBox& box : asked[r])
    {
      size += 3 * sizeOf(box);
    }
    replies[r].reserve(size);
    for (const PointBox& box : asked[r])
    {
      const GridView& view = viewOf(box.block);
      for (int k = box.lo[2]; k <= box.hi[2]; ++k)
      {
        for (int j = box.lo[1]; j <= box.hi[1]; ++j)
        {
          for (int i = box.lo[0]; i <= box.hi[0]; ++i)
          {
            const Vec3 x = view(i, j, k);
            replies[r].insert(replies[r].end(), x.data(), x.data() + 3);
          }
        }
      }
    }
  }
  std::vector<std::vector<double>> points = ranks.exchange(std::move(replies));

  std::vector<std::shared_ptr<PointBoxes>> memory(blockCount);
  for (int r = 0; r < ranks.size(); ++r)
  {
    std::size_t next = 0;
    for (const PointBox& box : requests[r])
    {
      std::shared_ptr<PointBoxes>& boxes = memory[box.block];
      boxes = boxes ? boxes : std::make_shared<PointBoxes>(viewOf(box.block).counts());
      const std::size_t end = next + 3 * sizeOf(box);
      boxes->add(box.lo, box.hi, { points[r].begin() + next, points[r].begin() + end });
      next = end;
    }
    std::vector<double>().swap(points[r]);
  }
  for (int b = 0; b < blockCount; ++b)
  {
    if (rankOf(b) != ranks.rank())
    {
      GridView& view = viewOf(b);
      view = GridView(memory[b] ? PointStorage(memory[b].get()) : PointStorage(), view.counts());
    }
  }
  memory.erase(std::remove(memory.begin(), memory.end(), nullptr), memory.end());
  return memory;
}

} // namespace bsv
