// SPDX-License-Identifier: BSD-3-Clause
/// @file MovedPoints.h
/// Mesh points that the rules see in other places than the mesh has them.
#pragma once

#include "Complex/MeshPoints.h"

#include <map>
#include <utility>
#include <vector>

namespace bsv
{

using PointOffsets = std::map<MeshPointKey, Vec3>;

struct MovedPoints
{
  const BlockComplex& complex;
  const PointOffsets& offsets;
  /// Added to these: a few points that are tried elsewhere.
  std::vector<std::pair<MeshPointKey, Vec3>> trials = {};

  /// Where mesh point ijk of a block is, which the mesh has at x.
  Vec3 at(int block, const Ijk& ijk, const Vec3& x) const
  {
    const MeshPointKey key = meshPointKey(this->complex, block, ijk);
    Vec3 result = x;
    const auto found = this->offsets.find(key);
    if (found != this->offsets.end())
    {
      result += found->second;
    }
    for (const auto& [point, offset] : this->trials)
    {
      if (point == key)
      {
        result += offset;
      }
    }
    return result;
  }
};

} // namespace bsv
