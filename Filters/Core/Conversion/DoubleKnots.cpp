// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/DoubleKnots.h"

#include "Base/OrderFreeSum.h"
#include "Base/UnionFind.h"
#include "Complex/EdgeFans.h"
#include "Conversion/FarField.h"
#include "Volume/BSplineVolume.h"

#include <algorithm>
#include <cstring>

#ifdef __SSE2__
#include <xmmintrin.h>
#endif

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

DoubledDirections doubleKnotDirections(const BlockComplex& complex, const ConversionOptions& options)
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

  DoubledDirections directions(complex.blocks.size(), std::array<bool, 3>{ false, false, false });
  for (std::size_t b = 0; b < complex.blocks.size(); ++b)
  {
    for (int e = 0; e < 12; ++e)
    {
      directions[b][edgeDirection(e)] = doubled[classes.find(complex.blocks[b].edges[e])];
    }
  }
  return directions;
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

namespace
{

/// Where a net with room for double knots has the old point i.
int placeWithRoom(int i, int cells, bool doubled)
{
  return !doubled || i < 2 ? i : i <= cells ? i + 1 : i + controlPointCount(cells, true) - (cells + 3);
}

/// New points of a direction: a run of copies, or all that are not.
struct NewPoints
{
  bool copies;
  std::vector<int> places;
};

std::vector<NewPoints> copiesAndOthers(const std::vector<KnotInsertionStencil>& stencils)
{
  std::vector<NewPoints> list{ { false, {} } };
  for (std::size_t i = 0; i < stencils.size(); ++i)
  {
    const bool copies = stencils[i].copies();
    if (copies && (i == 0 || !stencils[i - 1].copies()))
    {
      list.push_back({ true, {} });
    }
    (copies ? list.back() : list.front()).places.push_back(static_cast<int>(i));
  }
  return list;
}

/// One new point, from old ones at places relative to each other.
struct InsertedPoint
{
  struct Term
  {
    Index place;
    double weight;
  };
  Index place = 0, nearest = 0;
  std::vector<Term> terms;
  double denominator = 1.0;

  void evaluate(const double* points, OrderFreeSum& sum, double* to) const
  {
    if (this->terms.size() == 2)
    {
      const double *a = points + 3 * this->terms[0].place, *b = points + 3 * this->terms[1].place;
      for (int d = 0; d < 3; ++d)
      {
        to[d] = a[d] == b[d] ? a[d] : (this->terms[0].weight * a[d] + this->terms[1].weight * b[d]) / this->denominator;
      }
      return;
    }
    sum.clear();
    for (const Term& term : this->terms)
    {
      sum.add(term.weight, Vec3(points + 3 * term.place));
    }
    const Vec3 point = sum.result(this->denominator);
    std::copy_n(point.data(), 3, to);
  }
};

} // namespace

void makeRoom(const Ijk& cells, const std::array<bool, 3>& doubled, const ControlNetStorage& storage)
{
  const auto place = [&](int d, int i) { return placeWithRoom(i, cells[d], doubled[d]); };
  const auto count = [&](int d) { return Index(controlPointCount(cells[d], doubled[d])); };
  // From the last point to the first: none moves to a smaller place.
  for (int k = cells[2] + 2; k >= 0; --k)
  {
    for (int j = cells[1] + 2; j >= 0; --j)
    {
      const Index from = Index(cells[0] + 3) * (j + Index(cells[1] + 3) * k);
      const Index to = count(0) * (place(1, j) + count(1) * place(2, k));
      const auto move = [&](int first, int end) {
        std::memmove(
          storage.points + 3 * (to + place(0, first)), storage.points + 3 * (from + first), 24 * (end - first));
        std::memmove(storage.rules + to + place(0, first), storage.rules + from + first, end - first);
      };
      move(cells[0] + 1, cells[0] + 3);
      move(2, cells[0] + 1);
      move(0, 2);
    }
  }
}

void insertDoubleKnots(const Ijk& cells, const std::array<bool, 3>& doubled, const ControlNetStorage& storage)
{
  std::array<std::vector<KnotInsertionStencil>, 3> stencils;
  std::array<std::vector<NewPoints>, 3> parts;
  std::array<Index, 4> stride{ 1, 0, 0, 0 };
  for (int d = 0; d < 3; ++d)
  {
    stencils[d] = knotInsertion(cells[d], doubled[d]);
    parts[d] = copiesAndOthers(stencils[d]);
    stride[d + 1] = stride[d] * static_cast<Index>(stencils[d].size());
  }
  const auto place = [&](int d, int i) { return stride[d] * placeWithRoom(i, cells[d], doubled[d]); };
  const auto insert = [&](const std::array<const NewPoints*, 3>& box) {
    // The new points of all directions that are not copied, relative to the copied ones.
    std::array<int, 3> count, copies;
    for (int d = 0; d < 3; ++d)
    {
      const int size = static_cast<int>(box[d]->places.size());
      count[d] = box[d]->copies ? 1 : size;
      copies[d] = box[d]->copies ? size : 1;
    }
    std::vector<InsertedPoint> points;
    for (int n = 0; n < count[0] * count[1] * count[2]; ++n)
    {
      const Ijk at{ n % count[0], n / count[0] % count[1], n / count[0] / count[1] };
      InsertedPoint point;
      point.terms = { { 0, 1.0 } };
      for (int d = 0; d < 3; ++d)
      {
        const int i = box[d]->places[at[d]];
        const KnotInsertionStencil& stencil = stencils[d][i];
        std::vector<InsertedPoint::Term> terms;
        for (int a = 0; a < stencil.terms; ++a)
        {
          for (const InsertedPoint::Term& term : point.terms)
          {
            terms.push_back({ term.place + place(d, stencil.first + a), term.weight * stencil.weights[a] });
          }
        }
        point.terms = std::move(terms);
        point.denominator *= stencil.denominator;
        point.place += stride[d] * i;
        point.nearest += place(d, stencil.nearest);
      }
      points.push_back(std::move(point));
    }
    std::vector<double> values(3 * points.size());
    std::vector<std::uint8_t> rules(points.size());
    OrderFreeSum sum;
    for (int k = 0; k < copies[2]; ++k)
    {
      for (int j = 0; j < copies[1]; ++j)
      {
        for (int i = 0; i < copies[0]; ++i)
        {
          const Index start = i + stride[1] * j + stride[2] * k;
#ifdef __SSE2__
          // Points that lie in rows far apart are not read ahead by the processor itself.
          constexpr Index Ahead = 8;
          for (std::size_t n = 0; copies[0] == 1 && j + Ahead < copies[1] && n < points.size(); ++n)
          {
            _mm_prefetch(
              reinterpret_cast<const char*>(storage.points + 3 * (start + Ahead * stride[1] + points[n].place)),
              _MM_HINT_T0);
          }
#endif
          for (std::size_t n = 0; n < points.size(); ++n)
          {
            points[n].evaluate(storage.points + 3 * start, sum, values.data() + 3 * n);
            rules[n] = storage.rules[start + points[n].nearest];
          }
          for (std::size_t n = 0; n < points.size(); ++n)
          {
            double* to = storage.points + 3 * (start + points[n].place);
            for (int d = 0; d < 3; ++d)
            {
              to[d] = values[3 * n + d];
            }
            storage.rules[start + points[n].place] = rules[n];
          }
        }
      }
    }
  };
  // An old point that is overwritten where fewer directions are inserted is needed where more are, but not the other
  // way round.
  for (int wide = 3; wide > 0; --wide)
  {
    for (const NewPoints& alongK : parts[2])
    {
      for (const NewPoints& alongJ : parts[1])
      {
        for (const NewPoints& alongI : parts[0])
        {
          if ((alongI.copies ? 0 : 1) + (alongJ.copies ? 0 : 1) + (alongK.copies ? 0 : 1) == wide)
          {
            insert({ &alongI, &alongJ, &alongK });
          }
        }
      }
    }
  }
}

} // namespace bsv
