// SPDX-License-Identifier: BSD-3-Clause
// Grids of cells, seen from any numbering.
#include "Complex/HexDecomposition.h"

#include <Eigen/Geometry>

#include <algorithm>

namespace bsv
{

void HexDecomposition::makeBlocks()
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

class HexDecomposition::Grid
{
public:
  Grid(const HexDecomposition& all, const HexRegion& region)
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
    Ijk cellAt{};
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
  [[noreturn]] void refuse(const HexRegion& region) const
  {
    const HexId cell = this->All.Order[region.begin];
    throw Error("the " + std::to_string(region.end - region.begin) + " cells around " + this->All.cell(cell) +
      ", near " + text(this->All.point(this->All.corner(cell, 0))) + ", do not fill a grid");
  }

  const HexDecomposition& All;
  Ijk Lowest;
  Ijk Cells{ 0, 0, 0 };
  std::vector<HexId> Ids;
};

struct HexDecomposition::View
{
  const Grid& grid;
  const Frame& frame;

  int cells(int d) const { return this->grid.cells()[this->frame.axis[d]]; }
  Ijk place(const Ijk& at, int points) const
  {
    Ijk result{};
    for (int d = 0; d < 3; ++d)
    {
      result[this->frame.axis[d]] = this->frame.sign[d] > 0 ? at[d] : this->cells(d) - 1 + points - at[d];
    }
    return result;
  }
  HexId point(const Ijk& at) const { return this->grid.point(this->place(at, 1)); }
  HexId cell(const Ijk& at) const { return this->grid.cell(this->place(at, 0)); }
};

template <typename PointA, typename PointB>
int HexDecomposition::compare(const PointA& a, const Ijk& cellsA, const PointB& b, const Ijk& cellsB) const
{
  const auto at = [&](const Ijk& p) { return placeOrder(this->point(a(p)), this->point(b(p))); };
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

int HexDecomposition::compare(const View& a, const View& b) const
{
  return this->compare([&](const Ijk& p) { return a.point(p); }, { a.cells(0), a.cells(1), a.cells(2) },
    [&](const Ijk& p) { return b.point(p); }, { b.cells(0), b.cells(1), b.cells(2) });
}

int HexDecomposition::compare(const HexBlock& a, const HexBlock& b) const
{
  const auto point = [](const HexBlock& block) {
    return [&block](const Ijk& p) {
      return block.pointIds[p[0] + (block.cells[0] + 1) * (p[1] + Index(block.cells[1] + 1) * p[2])];
    };
  };
  return this->compare(point(a), a.cells, point(b), b.cells);
}

HexBlock HexDecomposition::makeBlock(const HexRegion& region)
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

int HexDecomposition::handedness(const Grid& grid) const
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

} // namespace bsv
