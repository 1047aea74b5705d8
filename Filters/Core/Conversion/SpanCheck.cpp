// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/SpanCheck.h"

#include "Base/SparseArray.h"
#include "Conversion/DoubleKnots.h"
#include "Quality/TangentCones.h"

#include <algorithm>
#include <numeric>

namespace bsv
{

Ijk cellOf(const ComplexBlock& block, Index span)
{
  const Index n0 = block.cells(0), n1 = block.cells(1);
  return { static_cast<int>(span % n0), static_cast<int>(span / n0 % n1), static_cast<int>(span / n0 / n1) };
}

Index spanOf(const ComplexBlock& block, const Ijk& cell)
{
  return cell[0] + Index(block.cells(0)) * (cell[1] + Index(block.cells(1)) * cell[2]);
}

BSplineVolume CheckedNets::volume(int block) const
{
  BSplineVolume volume;
  for (int d = 0; d < 3; ++d)
  {
    volume.knots[d] = this->knots(block, d);
  }
  volume.points = this->Context.nets[block].points;
  return volume;
}

std::vector<double> CheckedNets::knots(int block, int d) const
{
  return volumeKnots(this->Context.complex.blocks[block].cells(d), this->Context.isDoubled(block, d));
}

std::vector<int> CheckedNets::spansAlong(int block, int d) const
{
  const std::vector<double> t = this->knots(block, d);
  std::vector<int> spans;
  for (int i = 3; i + 4 < static_cast<int>(t.size()); ++i)
  {
    if (t[i] < t[i + 1])
    {
      spans.push_back(i);
    }
  }
  return spans;
}

Ijk CheckedNets::firstControlPoint(const SpanId& id) const
{
  Ijk first;
  Index rest = id.second;
  for (int d = 0; d < 3; ++d)
  {
    const std::vector<int> spans = this->spansAlong(id.first, d);
    first[d] = spans[rest % spans.size()] - 3;
    rest /= static_cast<Index>(spans.size());
  }
  return first;
}

Ijk CheckedNets::cellOf(const SpanId& id) const
{
  Ijk cell = this->firstControlPoint(id);
  for (int d = 0; d < 3; ++d)
  {
    cell[d] = static_cast<int>(this->knots(id.first, d)[cell[d] + 3]);
  }
  return cell;
}

std::vector<Index> CheckedNets::chosenSpans(int block) const
{
  const ConversionOptions& options = this->Context.options;
  if (options.checkSpans == CheckSpans::SpecialRules && !options.untangle)
  {
    return this->specialSpans(block);
  }
  Index count = 1;
  for (int d = 0; d < 3; ++d)
  {
    count *= static_cast<Index>(this->spansAlong(block, d).size());
  }
  std::vector<Index> spans(count);
  std::iota(spans.begin(), spans.end(), Index(0));
  return spans;
}

/// The spans that a control point made by a special rule belongs to, or a mesh point that was moved before.
std::vector<Index> CheckedNets::specialSpans(int block) const
{
  const ConversionContext& context = this->Context;
  const ComplexBlock& owner = context.complex.blocks[block];
  const bool single = !context.doubled;
  // Per control point of a direction its first and last span.
  std::array<std::vector<std::array<int, 2>>, 3> reach;
  Ijk spans, count;
  for (int d = 0; d < 3; ++d)
  {
    const std::vector<int> along = this->spansAlong(block, d);
    spans[d] = static_cast<int>(along.size());
    count[d] = along.back() + 1;
    reach[d].assign(count[d], { spans[d], -1 });
    for (int s = 0; s < spans[d]; ++s)
    {
      for (int i = along[s] - 3; i <= along[s]; ++i)
      {
        reach[d][i] = { std::min(reach[d][i][0], s), s };
      }
    }
  }
  const Index perLayer = Index(spans[0]) * spans[1];
  // 1 for those chosen; empty as long as there are none.
  std::vector<std::uint8_t> chosen;
  const auto inside = [&](int d, std::array<int, 2> range) {
    return std::array<int, 2>{ std::max(0, range[0]), std::min(range[1], spans[d] - 1) };
  };
  // Adds `row`, a 1 or 0 per span along i, to all rows of these j and k.
  const auto choose = [&](const std::vector<std::uint8_t>& row, std::array<int, 2> js, std::array<int, 2> ks) {
    chosen.resize(perLayer * spans[2], 0);
    js = inside(1, js);
    ks = inside(2, ks);
    for (int k = ks[0]; k <= ks[1]; ++k)
    {
      for (int j = js[0]; j <= js[1]; ++j)
      {
        std::uint8_t* target = chosen.data() + spans[0] * Index(j) + perLayer * k;
        for (int i = 0; i < spans[0]; ++i)
        {
          target[i] |= row[i];
        }
      }
    }
  };
  std::vector<std::uint8_t> chosenInRow(spans[0]);
  bool anyInRow = false;
  const auto startRow = [&] {
    if (anyInRow)
    {
      std::fill(chosenInRow.begin(), chosenInRow.end(), 0);
    }
    anyInRow = false;
  };
  const auto chooseInRow = [&](std::array<int, 2> range) {
    range = inside(0, range);
    std::fill(chosenInRow.begin() + range[0], chosenInRow.begin() + std::max(range[0], range[1] + 1), 1);
    anyInRow = true;
  };
  // Knot insertion is no special rule.
  bool spacing = false;
  for (int face = 0; face < 6; ++face)
  {
    spacing =
      spacing || context.layer.varies(block, face) || context.layer.weight(block, face, { 0, 0, 0 }) != KnotInsertion;
  }
  std::array<bool, static_cast<std::size_t>(ControlPointRule::Count)> isSpecial{};
  for (const ControlPointRule rule : { ControlPointRule::BodyExtraordinaryVertex, ControlPointRule::Crease,
         ControlPointRule::Corner, ControlPointRule::ExtraordinaryEdge, ControlPointRule::SingularNode })
  {
    isSpecial[static_cast<std::size_t>(rule)] = true;
  }
  for (const ControlPointRule rule : { ControlPointRule::WallLayer, ControlPointRule::FarFieldLayer })
  {
    isSpecial[static_cast<std::size_t>(rule)] = spacing;
  }
  // Inside the mesh they stand in the way of the rules on both sides.
  isSpecial[static_cast<std::size_t>(ControlPointRule::PlanarSide)] = context.options.planarSides == PlanarSides::All;
  for (int k = 0; k < count[2]; ++k)
  {
    for (int j = 0; j < count[1]; ++j)
    {
      const std::uint8_t* row = context.nets[block].rules + Index(count[0]) * (j + Index(count[1]) * k);
      // The interior is copied.
      const std::array<int, 2> copies = context.copiesInRow(block, j, k);
      startRow();
      for (int i = 0; i < count[0]; ++i)
      {
        i = i == copies[0] ? copies[1] : i;
        if (isSpecial[row[i]])
        {
          chooseInRow(reach[0][i]);
        }
      }
      if (anyInRow)
      {
        choose(chosenInRow, reach[1][j], reach[2][k]);
      }
    }
  }
  if (owner.points.changes())
  {
    // Of mesh point i, those of the spans of cells i - 2 to i + 1.
    const auto range = [&](int d, int i) {
      const auto end = [&](int side) {
        return reach[d][std::clamp(i + 1 + (side == 0 ? -1 : 1), 0, count[d] - 1)][side];
      };
      return single ? std::array<int, 2>{ i - 2, i + 1 } : std::array<int, 2>{ end(0), end(1) };
    };
    for (int k = 0; k <= owner.cells(2); ++k)
    {
      for (int j = 0; j <= owner.cells(1); ++j)
      {
        startRow();
        for (int i = 0; i <= owner.cells(0); ++i)
        {
          if (owner.points.changes()->find(owner.points.place({ i, j, k })))
          {
            chooseInRow(range(0, i));
          }
        }
        if (anyInRow)
        {
          choose(chosenInRow, range(1, j), range(2, k));
        }
      }
    }
  }
  std::vector<Index> list;
  for (auto next = chosen.begin(); (next = std::find(next, chosen.end(), std::uint8_t(1))) != chosen.end(); ++next)
  {
    list.push_back(next - chosen.begin());
  }
  return list;
}

std::array<Vec3, 8> givenCorners(const ComplexBlock& block, const Ijk& cell)
{
  const GridView given = block.points.changed(nullptr);
  std::array<Vec3, 8> corners;
  for (int c = 0; c < 8; ++c)
  {
    corners[c] = given({ cell[0] + cornerSide(c, 0), cell[1] + cornerSide(c, 1), cell[2] + cornerSide(c, 2) });
  }
  return corners;
}

bool isValidCell(const ComplexBlock& block, const std::array<Vec3, 8>& corners)
{
  BSplineVolume trilinear;
  trilinear.degree = { 1, 1, 1 };
  trilinear.knots.fill({ 0.0, 0.0, 1.0, 1.0 });
  trilinear.points = corners[0].data();
  JacobianOptions options;
  options.leftHanded = block.leftHanded;
  return jacobianBounds(trilinear, block.name, options).valid == 1;
}

std::map<SpanId, Validity> failingSpans(const CheckedNets& nets, const SpanLists& lists, const Execution& run)
{
  const BlockComplex& complex = nets.context().complex;
  struct Task
  {
    int block;
    const std::vector<Index>* spans;
    std::size_t first, last;
  };
  constexpr std::size_t Piece = 512;
  std::vector<Task> tasks;
  for (const auto& [block, spans] : lists)
  {
    for (std::size_t first = 0; first < spans.size(); first += Piece)
    {
      tasks.push_back({ block, &spans, first, std::min(spans.size(), first + Piece) });
    }
  }
  std::vector<std::vector<unsigned char>> codes(tasks.size());
  run.parallelFor(static_cast<Index>(tasks.size()), 1, [&](Index begin, Index end) {
    for (Index t = begin; t < end; ++t)
    {
      const Task& task = tasks[t];
      const std::vector<Index> spans(task.spans->begin() + task.first, task.spans->begin() + task.last);
      codes[t].assign(spans.size(), static_cast<unsigned char>(Validity::Valid));
      const BSplineVolume volume = nets.volume(task.block);
      JacobianOptions options;
      options.leftHanded = complex.blocks[task.block].leftHanded;
      const std::vector<bool> proven = provenByTangentCones(volume, spans, options.leftHanded);
      std::vector<Index> others;
      for (std::size_t i = 0; i < spans.size(); ++i)
      {
        if (!proven[i])
        {
          others.push_back(spans[i]);
        }
      }
      if (others.empty())
      {
        continue;
      }
      std::vector<unsigned char> validity(others.size());
      options.spans = &others;
      options.maxWitnesses = 0;
      JacobianArrays arrays;
      arrays.validity = validity.data();
      jacobianBounds(volume, complex.blocks[task.block].name, options, arrays);
      for (std::size_t i = 0, next = 0; i < spans.size(); ++i)
      {
        if (!proven[i])
        {
          codes[t][i] = validity[next++];
        }
      }
    }
  });
  std::map<SpanId, Validity> failing;
  for (std::size_t t = 0; t < tasks.size(); ++t)
  {
    for (std::size_t i = 0; i < codes[t].size(); ++i)
    {
      const Validity validity = static_cast<Validity>(codes[t][i]);
      if (validity != Validity::Valid)
      {
        failing[{ tasks[t].block, (*tasks[t].spans)[tasks[t].first + i] }] = validity;
      }
    }
  }
  return failing;
}

std::map<SpanId, Validity> failingSpans(const CheckedNets& nets, Index& checked, const Execution& run)
{
  const ConversionContext& context = nets.context();
  std::map<SpanId, Validity> failing;
  Index count = 0;
  std::vector<std::vector<Index>> spans(context.complex.blocks.size());
  run.parallelFor(static_cast<Index>(spans.size()), 1, [&](Index begin, Index end) {
    for (int block = static_cast<int>(begin); block < end; ++block)
    {
      if (context.isHere(block))
      {
        spans[block] = nets.chosenSpans(block);
      }
    }
  });
  SpanLists lists;
  for (std::size_t block = 0; block < spans.size(); ++block)
  {
    if (!spans[block].empty())
    {
      count += static_cast<Index>(spans[block].size());
      lists[static_cast<int>(block)] = std::move(spans[block]);
    }
  }
  failing = failingSpans(nets, lists, run);
  checked = 0;
  for (const Index part : run.ranks->gatherAll(std::vector<Index>{ count }))
  {
    checked += part;
  }
  return failing;
}

} // namespace bsv
