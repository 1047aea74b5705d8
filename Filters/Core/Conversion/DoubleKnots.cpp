// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/DoubleKnots.h"

#include "Base/OrderFreeSum.h"
#include "Base/UnionFind.h"
#include "Complex/EdgeFans.h"
#include "Conversion/FarField.h"
#include "Volume/BSplineVolume.h"

#include <algorithm>
#include <cstring>

namespace bsv
{
namespace
{

/// Stencils of the first half of a direction; the others are their mirror images.
KnotInsertionStencil stencil(int first, std::initializer_list<double> weights, double denominator)
{
  KnotInsertionStencil result;
  result.first = first;
  result.terms = static_cast<int>(weights.size());
  std::copy(weights.begin(), weights.end(), result.weights.begin());
  result.denominator = denominator;
  result.nearest = first +
    static_cast<int>(
      std::max_element(result.weights.begin(), result.weights.begin() + result.terms) - result.weights.begin());
  return result;
}

} // namespace

std::vector<std::array<bool, 3>> doubleKnotDirections(const BlockComplex& complex, const ConversionOptions& options)
{
  UnionFind classes(complex.edges.size());
  for (const ComplexFace& face : complex.faces)
  {
    const FaceUse& use = face.uses.front();
    const ComplexBlock& block = complex.blocks[use.block];
    for (int axis = 0; axis < 2; ++axis)
    {
      classes.unite(block.edges[faceEdge(use.face, axis, 0)], block.edges[faceEdge(use.face, axis, 1)]);
    }
  }
  std::vector<bool> doubled(complex.edges.size(), false);
  for (const ComplexEdge& edge : complex.edges)
  {
    // Two blocks at a smooth boundary are regular, one is a corner.
    if (edge.boundary ? edge.valence() < 3 : edge.valence() == 4)
    {
      continue;
    }
    for (const EdgeUse& use : edge.uses)
    {
      const ComplexBlock& block = complex.blocks[use.block];
      const int along = edgeDirection(use.edge);
      for (int axis = 0; axis < 2; ++axis)
      {
        const int d = faceAxis(2 * along, axis);
        const int corner = edgeCorner(use.edge, 0);
        // The block edge along d from that corner.
        for (int e = 0; e < 12; ++e)
        {
          if (edgeDirection(e) == d && (edgeCorner(e, 0) == corner || edgeCorner(e, 1) == corner))
          {
            doubled[classes.find(block.edges[e])] = true;
          }
        }
      }
    }
  }
  for (int v = 0; v < static_cast<int>(complex.vertices.size()); ++v)
  {
    if (!complex.vertices[v].boundary)
    {
      continue;
    }
    const VertexStar star = vertexStar(complex, v);
    const BoundaryRing ring = boundaryRing(star);
    const bool wall = std::all_of(ring.faces.begin(), ring.faces.end(),
      [&](int f) { return roleOf(options, complex.faces[star.faces[f].face]) == BoundaryRole::Body; });
    if (wall && ring.edges.size() >= 3 && ring.edges.size() != 4)
    {
      for (const int e : ring.edges)
      {
        doubled[classes.find(star.edges[e].edge)] = true;
      }
    }
  }

  std::vector<std::array<bool, 3>> directions(complex.blocks.size(), std::array<bool, 3>{ false, false, false });
  for (std::size_t b = 0; b < complex.blocks.size(); ++b)
  {
    for (int e = 0; e < 12; ++e)
    {
      directions[b][edgeDirection(e)] = doubled[classes.find(complex.blocks[b].edges[e])];
    }
  }
  return directions;
}

int controlPointCount(int cells, bool doubled)
{
  return !doubled ? cells + 3 : cells == 1 ? 8 : cells == 2 ? 9 : cells + 5;
}

std::vector<double> volumeKnots(int cells, bool doubled)
{
  std::vector<double> knots = clampedIntegerKnots(cells);
  if (doubled && cells < 3)
  {
    const std::vector<double> first = cells == 1 ? std::vector<double>{ 1.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0 }
                                                 : std::vector<double>{ 0.5, 0.5, 1.0, 1.5, 1.5 };
    knots.assign(4, 0.0);
    knots.insert(knots.end(), first.begin(), first.end());
    knots.insert(knots.end(), 4, static_cast<double>(cells));
  }
  else if (doubled)
  {
    knots.insert(knots.begin() + 4, 1.0);
    knots.insert(knots.end() - 4, static_cast<double>(cells - 1));
  }
  return knots;
}

std::vector<KnotInsertionStencil> knotInsertion(int cells, bool doubled)
{
  const int before = cells + 3;
  std::vector<KnotInsertionStencil> stencils;
  if (!doubled)
  {
    for (int i = 0; i < before; ++i)
    {
      stencils.push_back(stencil(i, { 1.0 }, 1.0));
    }
    return stencils;
  }
  const auto add = [&](int first, std::initializer_list<double> weights, double denominator) {
    stencils.push_back(stencil(first, weights, denominator));
  };
  add(0, { 1.0 }, 1.0);
  if (cells == 1)
  {
    add(0, { 2.0, 1.0 }, 3.0);
    add(0, { 4.0, 4.0, 1.0 }, 9.0);
    add(0, { 4.0, 12.0, 9.0, 2.0 }, 27.0);
  }
  else if (cells == 2)
  {
    add(0, { 1.0, 1.0 }, 2.0);
    add(0, { 2.0, 5.0, 1.0 }, 8.0);
    add(1, { 9.0, 6.0, 1.0 }, 16.0);
    add(1, { 3.0, 10.0, 3.0 }, 16.0);
  }
  else
  {
    add(1, { 1.0 }, 1.0);
    add(1, { 1.0, 1.0 }, 2.0);
    add(2, { 2.0, 1.0 }, 3.0);
    // Of equally near points the same one from both ends.
    stencils[2].nearest = 2;
    for (int i = 3; i <= cells - 1; ++i)
    {
      add(i, { 1.0 }, 1.0);
    }
  }
  const int count = controlPointCount(cells, true);
  const std::vector<KnotInsertionStencil> half(stencils.begin(), stencils.begin() + std::min(4, count / 2));
  for (int i = static_cast<int>(half.size()) - 1; i >= 0; --i)
  {
    KnotInsertionStencil mirror = half[i];
    std::reverse(mirror.weights.begin(), mirror.weights.begin() + mirror.terms);
    mirror.first = before - half[i].first - mirror.terms;
    mirror.nearest = before - 1 - half[i].nearest;
    stencils.push_back(mirror);
  }
  return stencils;
}

void insertDoubleKnots(const Ijk& cells, const std::array<bool, 3>& doubled, const ControlNetStorage& storage)
{
  if (!doubled[0] && !doubled[1] && !doubled[2])
  {
    return;
  }
  std::array<std::vector<KnotInsertionStencil>, 3> stencils;
  std::array<Index, 3> stride{ 1, 0, 0 };
  for (int d = 0; d < 3; ++d)
  {
    stencils[d] = knotInsertion(cells[d], doubled[d]);
  }
  stride[1] = cells[0] + 3;
  stride[2] = stride[1] * (cells[1] + 3);
  const int ni = static_cast<int>(stencils[0].size());
  const int nj = static_cast<int>(stencils[1].size());
  const int nk = static_cast<int>(stencils[2].size());
  OrderFreeSum sum;
  // From the last point to the first: an old point lies at no larger place than each new one that needs it.
  for (int k = nk - 1; k >= 0; --k)
  {
    for (int j = nj - 1; j >= 0; --j)
    {
      const KnotInsertionStencil& alongJ = stencils[1][j];
      const KnotInsertionStencil& alongK = stencils[2][k];
      const bool rowCopies = alongJ.copies() && alongK.copies();
      const Index row = Index(ni) * (j + Index(nj) * k);
      const Index nearestRow = stride[1] * alongJ.nearest + stride[2] * alongK.nearest;
      for (int i = ni - 1; i >= 0; --i)
      {
        const KnotInsertionStencil& alongI = stencils[0][i];
        const std::uint8_t rule = storage.rules[nearestRow + alongI.nearest];
        double* to = storage.points + 3 * (row + i);
        const int wide = (alongI.copies() ? 0 : 1) + (alongJ.copies() ? 0 : 1) + (alongK.copies() ? 0 : 1);
        const KnotInsertionStencil& only = !alongI.copies() ? alongI : !alongJ.copies() ? alongJ : alongK;
        const Index first = alongI.first + stride[1] * alongJ.first + stride[2] * alongK.first;
        if (rowCopies && wide == 0)
        {
          // A run of copies at once.
          int start = i;
          while (start > 0 && stencils[0][start - 1].copies() &&
            stencils[0][start - 1].first == stencils[0][start].first - 1)
          {
            --start;
          }
          const Index from = first - (i - start);
          std::memmove(storage.points + 3 * (row + start), storage.points + 3 * from, 24 * (i - start + 1));
          std::memmove(storage.rules + row + start, storage.rules + from, i - start + 1);
          i = start;
          continue;
        }
        if (wide == 1 && only.terms == 2)
        {
          const Index step = !alongI.copies() ? stride[0] : !alongJ.copies() ? stride[1] : stride[2];
          const double* a = storage.points + 3 * first;
          const double* b = storage.points + 3 * (first + step);
          double point[3];
          for (int d = 0; d < 3; ++d)
          {
            point[d] = a[d] == b[d] ? a[d] : (only.weights[0] * a[d] + only.weights[1] * b[d]) / only.denominator;
          }
          std::copy_n(point, 3, to);
        }
        else
        {
          sum.clear();
          for (int c = 0; c < alongK.terms; ++c)
          {
            for (int b = 0; b < alongJ.terms; ++b)
            {
              for (int a = 0; a < alongI.terms; ++a)
              {
                sum.add(alongI.weights[a] * alongJ.weights[b] * alongK.weights[c],
                  Vec3(Eigen::Map<const Vec3>(storage.points + 3 * (first + a + stride[1] * b + stride[2] * c))));
              }
            }
          }
          const Vec3 point = sum.result(alongI.denominator * alongJ.denominator * alongK.denominator);
          std::copy_n(point.data(), 3, to);
        }
        storage.rules[row + i] = rule;
      }
    }
  }
}

} // namespace bsv
