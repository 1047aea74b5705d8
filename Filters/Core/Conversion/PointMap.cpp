// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/PointMap.h"

#include "Conversion/EdgeConversion.h"
#include "Conversion/FaceConversion.h"
#include "Conversion/PointFrame.h"
#include "Conversion/VertexConversion.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace bsv
{

void convertPoint(const ConversionContext& context, const MeshPointKey& key)
{
  switch (key[0])
  {
    case 0:
      convertVertex(context, key[1]);
      break;
    case 1:
      convertEdgeLayers(context, key[1], key[2], key[2] + 1);
      break;
    case 2:
      convertFacePoints(context, key[1], { key[2], key[3] }, { key[2] + 1, key[3] + 1 });
      break;
    default: {
      const Ijk ijk{ key[2], key[3], key[4] };
      Ijk position;
      for (int d = 0; d < 3; ++d)
      {
        position[d] = context.innerPosition(key[1], d, ijk[d]);
      }
      context.write(key[1], position, context.point(key[1], ijk), ControlPointRule::Copied);
    }
  }
}

std::array<int, 2> positionsOf(int i, int cells)
{
  return i == 0  ? std::array<int, 2>{ 0, 1 }
    : i == cells ? std::array<int, 2>{ cells + 1, cells + 2 }
                 : std::array<int, 2>{ i + 1, i + 1 };
}

int meshIndexOf(int position, int cells)
{
  return std::clamp(position - 1, 0, cells);
}

namespace
{

/// Where the mesh has a point, if it is known here.
std::optional<Vec3> find(const ConversionContext& context, const MeshPointKey& key)
{
  for (const MeshPointCopy& copy : copiesOf(context.complex, key))
  {
    const GridView& points = context.complex.blocks[copy.block].points;
    if (points.has(copy.ijk))
    {
      return points(copy.ijk);
    }
  }
  return {};
}

template <typename Visit>
void forControlPoints(const ConversionContext& context, const MeshPointCopy& copy, const Visit& visit)
{
  const ComplexBlock& block = context.complex.blocks[copy.block];
  std::array<std::array<int, 2>, 3> range;
  for (int d = 0; d < 3; ++d)
  {
    range[d] = positionsOf(copy.ijk[d], block.cells(d));
  }
  for (int k = range[2][0]; k <= range[2][1]; ++k)
  {
    for (int j = range[1][0]; j <= range[1][1]; ++j)
    {
      for (int i = range[0][0]; i <= range[0][1]; ++i)
      {
        visit(Ijk{ i, j, k });
      }
    }
  }
}

} // namespace

PointMap pointMap(const ConversionContext& context, const MeshPointKey& owner)
{
  PointMap map;
  // By their places: rounding must not depend on the numbering.
  std::vector<std::pair<std::array<double, 3>, MeshPointKey>> inputs;
  for (const MeshPointKey& key : neighboursOf(context.complex, owner))
  {
    const std::optional<Vec3> x = find(context, key);
    if (x && freedomOf(context, key) != Freedom::Fixed)
    {
      inputs.push_back({ { (*x)[0], (*x)[1], (*x)[2] }, key });
    }
  }
  std::sort(inputs.begin(), inputs.end());
  for (const auto& input : inputs)
  {
    map.inputs.push_back(input.second);
  }
  for (const MeshPointCopy& copy : copiesOf(context.complex, owner))
  {
    if (context.isHere(copy.block))
    {
      forControlPoints(context, copy,
        [&](const Ijk& position) { map.outputs.emplace_back(copy.block, context.index(copy.block, position)); });
    }
  }
  std::sort(map.outputs.begin(), map.outputs.end());
  map.outputs.erase(std::unique(map.outputs.begin(), map.outputs.end()), map.outputs.end());
  const auto read = [&] {
    std::vector<Vec3> values;
    for (const auto& [block, at] : map.outputs)
    {
      values.emplace_back(context.controlPoint(block, at));
    }
    return values;
  };

  // The rules are linear: differences, with three points moved at a time, each along an axis of its own.
  const std::vector<Vec3> now = read();
  const PointOffsets none;
  MovedPoints moved{ context.complex, none };
  ConversionContext trial = context;
  trial.moved = &moved;
  convertPoint(trial, owner);
  const std::vector<Vec3> base = read();
  const Vec3 center = *find(context, owner);
  double length = 0.0;
  for (const MeshPointKey& key : map.inputs)
  {
    length = std::max(length, (*find(context, key) - center).norm());
  }
  map.weights.assign(map.outputs.size() * map.inputs.size(), 0.0);
  for (std::size_t first = 0; first < map.inputs.size() && length > 0.0; first += 3)
  {
    moved.trials.clear();
    for (std::size_t i = first; i < std::min(first + 3, map.inputs.size()); ++i)
    {
      moved.trials.emplace_back(map.inputs[i], length * Vec3::Unit(i - first));
    }
    convertPoint(trial, owner);
    const std::vector<Vec3> values = read();
    for (std::size_t o = 0; o < values.size(); ++o)
    {
      for (std::size_t i = first; i < std::min(first + 3, map.inputs.size()); ++i)
      {
        const double weight = (values[o] - base[o])[i - first] / length;
        map.weights[o * map.inputs.size() + i] = std::abs(weight) > 1e-9 ? weight : 0.0;
      }
    }
  }
  for (std::size_t o = 0; o < map.outputs.size(); ++o)
  {
    std::copy_n(now[o].data(), 3, context.nets[map.outputs[o].first].points + 3 * map.outputs[o].second);
  }
  return map;
}

} // namespace bsv
