// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/HexNumbering.h"

#include "Base/ParallelSort.h"

#include <algorithm>
#include <numeric>

namespace bsv
{

namespace
{

/// Spreads the lowest 21 bits to every third one.
std::uint64_t everyThird(std::uint64_t bits)
{
  bits &= 0x1fffff;
  bits = (bits | bits << 32) & 0x1f00000000ffff;
  bits = (bits | bits << 16) & 0x1f0000ff0000ff;
  bits = (bits | bits << 8) & 0x100f00f00f00f00f;
  bits = (bits | bits << 4) & 0x10c30c30c30c30c3;
  bits = (bits | bits << 2) & 0x1249249249249249;
  return bits;
}

struct PlacedCell
{
  std::uint64_t key;
  HexId cell;
  bool operator<(const PlacedCell& other) const
  {
    return this->key != other.key ? this->key < other.key : this->cell < other.cell;
  }
};

/// The cells along the Morton curve through the bounding box, 2^21 steps in every direction.
std::vector<PlacedCell> sortedByPlace(const HexMesh& mesh, const Execution& run)
{
  Vec3 lowest = mesh.points.atPlace(mesh.corners[0]);
  Vec3 highest = lowest;
  for (Index p = 0; p < mesh.pointCount(); ++p)
  {
    const Vec3 x = mesh.points.atPlace(p);
    lowest = lowest.cwiseMin(x);
    highest = highest.cwiseMax(x);
  }
  constexpr double Steps = (1 << 21) - 1;
  // Halves first: the size of the box may be more than a double holds. What is not finite is refused later.
  const Vec3 size = 0.5 * highest - 0.5 * lowest;
  const auto step = [&](double x, int d) {
    const double at = (0.5 * x - 0.5 * lowest[d]) / size[d] * Steps;
    return at > 0.0 ? static_cast<std::uint64_t>(std::min(at, Steps)) : std::uint64_t(0);
  };
  std::vector<PlacedCell> cells(mesh.cellCount());
  run.parallelFor(mesh.cellCount(), 1 << 14, [&](Index begin, Index end) {
    for (Index c = begin; c < end; ++c)
    {
      const HexId* corner = mesh.corners.data() + 8 * c;
      // Opposite corners say where it is.
      const Vec3 center = 0.5 * mesh.points.atPlace(corner[0]) + 0.5 * mesh.points.atPlace(corner[7]);
      cells[c] = { everyThird(step(center[0], 0)) | everyThird(step(center[1], 1)) << 1 |
          everyThird(step(center[2], 2)) << 2,
        static_cast<HexId>(c) };
    }
  });
  run.report(0.2);
  parallelSort(cells, run);
  return cells;
}

} // namespace

bool isScattered(const HexMesh& mesh)
{
  // Less than what caches hold.
  constexpr Index FewCells = 100000;
  constexpr Index Samples = 4096;
  const Index cells = mesh.cellCount();
  if (cells < FewCells)
  {
    return false;
  }
  // One layer of a mesh of many is still near.
  const Index near = mesh.pointCount() / 64;
  const auto smallest = [&](Index cell) -> Index {
    return *std::min_element(mesh.corners.begin() + 8 * cell, mesh.corners.begin() + 8 * cell + 8);
  };
  Index far = 0;
  for (Index n = 0; n < Samples; ++n)
  {
    const Index cell = (cells - 1) / Samples * n;
    far += std::abs(smallest(cell) - smallest(cell + 1)) > near;
  }
  return 2 * far > Samples;
}

HexNumbering::HexNumbering(HexMesh& original, const Execution& run)
{
  const Index cells = original.cellCount();
  const Index points = original.pointCount();
  {
    const std::vector<PlacedCell> sorted = sortedByPlace(original, run);
    this->CellOf.resize(cells);
    std::transform(sorted.begin(), sorted.end(), this->CellOf.begin(), [](const PlacedCell& c) { return c.cell; });
  }
  run.report(0.6);
  this->Mesh.corners.resize(original.corners.size());
  run.parallelFor(cells, 1 << 14, [&](Index begin, Index end) {
    for (Index c = begin; c < end; ++c)
    {
      std::copy_n(original.corners.begin() + 8 * Index(this->CellOf[c]), 8, this->Mesh.corners.begin() + 8 * c);
    }
  });
  std::vector<HexId>().swap(original.corners);
  run.report(0.7);

  std::vector<HexId> number(points, NoHexId);
  this->PointOf.reserve(points);
  const auto add = [&](HexId p) {
    if (number[p] == NoHexId)
    {
      number[p] = static_cast<HexId>(this->PointOf.size());
      this->PointOf.push_back(p);
    }
  };
  for (HexId& p : this->Mesh.corners)
  {
    add(p);
    p = number[p];
  }
  // Those of no cell.
  for (HexId p = 0; p < static_cast<HexId>(points); ++p)
  {
    add(p);
  }
  run.report(0.9);
  this->Points.resize(points);
  run.parallelFor(points, 1 << 14, [&](Index begin, Index end) {
    for (Index p = begin; p < end; ++p)
    {
      this->Points[p] = original.points.atPlace(this->PointOf[p]);
    }
  });
  this->Mesh.points = GridView(this->Points.data()->data(), original.points.counts());

  this->Mesh.quads = original.quads;
  for (NamedQuad& quad : this->Mesh.quads)
  {
    for (HexId& p : quad.points)
    {
      p = number[p];
    }
  }
  this->Mesh.boundaryNames = original.boundaryNames;
  this->Mesh.boundaryTypes = original.boundaryTypes;
  if (original.tagOf)
  {
    this->Mesh.tagOf = [this, &original](std::array<HexId, 4> face) {
      for (HexId& p : face)
      {
        p = this->PointOf[p];
      }
      return original.tagOf(face);
    };
  }
  this->Mesh.cellName = [this, &original](Index cell) { return original.cellName(this->CellOf[cell]); };
  this->Mesh.pointName = [this, &original](Index point) { return original.pointName(this->PointOf[point]); };
}

void HexNumbering::restore(std::vector<HexBlock>& blocks, const Execution& run) const
{
  const auto rename = [&](std::vector<HexId>& ids, const std::vector<HexId>& former) {
    run.parallelFor(static_cast<Index>(ids.size()), 1 << 16, [&](Index begin, Index end) {
      for (Index n = begin; n < end; ++n)
      {
        ids[n] = former[ids[n]];
      }
    });
  };
  for (HexBlock& block : blocks)
  {
    rename(block.cellIds, this->CellOf);
    rename(block.pointIds, this->PointOf);
  }
}

} // namespace bsv
