// SPDX-License-Identifier: BSD-3-Clause
/// @file MeshSizes.h
/// Meshes of any size for several benchmarks.
#pragma once

#include "Support/MeshCases.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace bsvbench
{

/// Six blocks around a sphere, the larger the more points.
struct SphereCase
{
  /// About `points` points in all; the faces on the sphere are the boundary "wall".
  SphereCase(bsv::Index points, bool isFloat)
    : SphereCase(static_cast<int>(std::lround(std::cbrt(points / 6.0))) - 1, isFloat)
  {
  }

  meshcases::MeshCase mesh;
  bsv::BlockMesh blocks;

private:
  SphereCase(int cells, bool isFloat)
  {
    std::vector<double> radii{ 1.0 };
    for (int k = 0; k < cells; ++k)
    {
      radii.push_back(radii.back() * (1.0 + 1.5 / cells)); // cells about as thick as wide
    }
    this->mesh = meshcases::sphereBody(cells, radii);
    this->mesh.boundaryNames = { "wall" };
    for (int b = 0; b < 6; ++b)
    {
      this->mesh.boundaries.push_back({ b, 4, { { 0, 0 }, { cells, cells } }, 0 });
      this->mesh.blocks[b].isFloat = isFloat;
    }
    this->blocks = this->mesh.mesh();
    if (isFloat)
    {
      for (meshcases::MeshCase::Block& block : this->mesh.blocks)
      {
        std::vector<bsv::Vec3>().swap(block.points);
      }
    }
  }
};

/// A curved box of as many blocks of `cells`^3 cells as give about `points` points, the same number in every direction.
inline meshcases::MeshCase boxOfBlocks(bsv::Index points, int cells)
{
  const int blocks = std::max(1, static_cast<int>(std::lround(std::cbrt(double(points)) / (cells + 1))));
  std::vector<int> cuts;
  for (int n = 1; n < blocks; ++n)
  {
    cuts.push_back(n * cells);
  }
  const int size = blocks * cells;
  return meshcases::cutBox({ size, size, size }, { cuts, cuts, cuts },
    [size](const bsv::Vec3& x) { return meshcases::wavy(x * (3.0 / size) - bsv::Vec3::Constant(1.5)); });
}

} // namespace bsvbench
