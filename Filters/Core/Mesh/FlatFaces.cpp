// SPDX-License-Identifier: BSD-3-Clause
#include "Mesh/FlatFaces.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <vector>

namespace bsv
{

namespace
{

/// Corners (i + 2 j + 4 k) of the faces i min, i max, .., around them, outward in right-handed cells.
constexpr int Around[6][4] = { { 0, 4, 6, 2 }, { 1, 3, 7, 5 }, { 0, 1, 5, 4 }, { 2, 6, 7, 3 }, { 0, 2, 3, 1 },
  { 4, 5, 7, 6 } };

struct FlatFace
{
  Vec3 area = Vec3::Zero();
  Vec3 centre = Vec3::Zero();
};

FlatFace flatFace(const std::array<Vec3, 8>& corners, int face)
{
  const auto corner = [&](int c) { return corners[Around[face][c % 4]]; };
  const Vec3 mean = 0.25 * (corner(0) + corner(1) + corner(2) + corner(3));
  FlatFace result;
  double sum = 0.0;
  for (int c = 0; c < 4; ++c)
  {
    const Vec3 area = 0.5 * (corner(c + 1) - corner(c)).cross(mean - corner(c));
    const double size = area.norm();
    result.area += area;
    result.centre += size / 3.0 * (corner(c) + corner(c + 1) + mean);
    sum += size;
  }
  result.centre = sum > 0.0 ? Vec3(result.centre / sum) : mean;
  return result;
}

/// Volume of a cell, and the smallest and largest of its pyramids, all positive in right-handed ones.
struct CellVolumes
{
  double volume = 0.0;
  double smallest = 0.0;
  double largest = 0.0;
};

CellVolumes cellVolumes(const std::array<Vec3, 8>& corners)
{
  std::array<FlatFace, 6> faces;
  Vec3 middle = Vec3::Zero();
  for (int f = 0; f < 6; ++f)
  {
    faces[f] = flatFace(corners, f);
    middle += faces[f].centre / 6.0;
  }
  CellVolumes result;
  Vec3 centroid = Vec3::Zero();
  for (const FlatFace& face : faces)
  {
    const double pyramid = face.area.dot(face.centre - middle) / 3.0;
    result.volume += pyramid;
    centroid += pyramid * (0.75 * face.centre + 0.25 * middle);
  }
  centroid = result.volume != 0.0 ? Vec3(centroid / result.volume) : middle;
  for (int f = 0; f < 6; ++f)
  {
    const double pyramid = faces[f].area.dot(faces[f].centre - centroid) / 3.0;
    result.smallest = f == 0 ? pyramid : std::min(result.smallest, pyramid);
    result.largest = f == 0 ? pyramid : std::max(result.largest, pyramid);
  }
  return result;
}

/// A layer of cells, for either handedness of the block: right-handed, left-handed.
struct Layer
{
  double volume = 0.0;
  std::array<TurnedCells, 2> turned;
};

} // namespace

TurnedCells turnedCells(const GridView& points, int step, const Execution& run)
{
  Ijk cells{};
  for (int d = 0; d < 3; ++d)
  {
    cells[d] = (points.counts()[d] - 1) / step;
  }
  std::vector<Layer> layers(static_cast<std::size_t>(cells[2]));
  run.parallelFor(cells[2], 1, [&](Index begin, Index end) {
    for (int k = static_cast<int>(begin); k < end; ++k)
    {
      Layer& layer = layers[k];
      for (int j = 0; j < cells[1]; ++j)
      {
        for (int i = 0; i < cells[0]; ++i)
        {
          std::array<Vec3, 8> corners;
          for (int c = 0; c < 8; ++c)
          {
            corners[c] = points((i + (c & 1)) * step, (j + (c >> 1 & 1)) * step, (k + (c >> 2)) * step);
          }
          const CellVolumes cell = cellVolumes(corners);
          layer.volume += cell.volume;
          for (int left = 0; left < 2; ++left)
          {
            TurnedCells& turned = layer.turned[left];
            if (left ? !(cell.largest < 0.0) : !(cell.smallest > 0.0))
            {
              turned.first = turned.count == 0 ? Ijk{ i, j, k } : turned.first;
              ++turned.count;
            }
          }
        }
      }
    }
  });
  double volume = 0.0;
  for (const Layer& layer : layers)
  {
    volume += layer.volume;
  }
  TurnedCells result;
  for (const Layer& layer : layers)
  {
    const TurnedCells& turned = layer.turned[volume < 0.0 ? 1 : 0];
    result.first = result.count == 0 ? turned.first : result.first;
    result.count += turned.count;
  }
  return result;
}

std::string turnedCellsNote(
  const std::vector<TurnedCells>& blocks, const std::function<std::string(std::size_t block)>& blockName)
{
  Index count = 0;
  std::string where;
  for (std::size_t b = 0; b < blocks.size(); ++b)
  {
    const Ijk& cell = blocks[b].first;
    if (count == 0 && blocks[b].count > 0)
    {
      where = "in " + blockName(b) + " at cell (" + std::to_string(cell[0]) + ", " + std::to_string(cell[1]) + ", " +
        std::to_string(cell[2]) + ")";
    }
    count += blocks[b].count;
  }
  if (count == 0)
  {
    return "";
  }
  return std::to_string(count) + (count == 1 ? " cell is" : " cells are") +
    " turned over in programs that take faces as flat (checkMesh: face pyramids), first " + where +
    ": thinner than its faces are warped, or collapsed. Where BSpline Volume Quality finds the volume valid, "
    "refinement "
    "along the wall (Tangential Level) mends that";
}

} // namespace bsv
