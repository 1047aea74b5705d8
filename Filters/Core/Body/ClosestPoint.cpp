// SPDX-License-Identifier: BSD-3-Clause
#include "Body/ClosestPoint.h"

#include "Body/SurfaceCells.h"
#include "Body/TrimRegion.h"
#include "Volume/BSplineVolume.h"
#include "Volume/BezierSegments.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <tuple>

namespace bsv
{

namespace
{

using Box3 = Eigen::AlignedBox3d;

/// Two points closer than this fraction of the body's size are one.
constexpr double CoincidentFraction = 1e-12;
/// How often a cell is halved, in both directions, where the distance may have several minima on it.
constexpr int HollowHalvings = 2;
/// Part of its own size by which an iteration may leave its cell.
constexpr double CellMargin = 0.25;
/// Steps along the border of its cell after which an iteration that wants to leave is given up.
constexpr int MaxBorderSteps = 6;
constexpr Index CellsPerNode = 4;

struct Candidate
{
  double distance;
  int patch;
  double u, v;
  int piece;
  bool onEdge;
  Vec3 point;
};

struct Node
{
  Box3 box;
  /// Inner: the two children; leaf (count > 0): its cells.
  Index first = 0;
  Index second = 0;
  Index count = 0;
};

/// Whether a part of a surface or, without `v`, of an edge may hold a foot point within `limit` of q. The part has its
/// centre at r + q and lies in a ball of that radius around it; its points are r + q + a u + b v up to half of the sum
/// of the spreads, a and b at most 1/2, and its tangents u and v up to their spreads.
bool mayHoldFootPoint(
  const Vec3& r, double radius, const Vec3& u, double spreadU, const Vec3& v, double spreadV, double limit)
{
  const double distance = r.norm(), bend = 0.5 * (spreadU + spreadV), product = std::abs(u.dot(v));
  const double farthest = std::min(distance + radius, limit);
  // (x - q) . x_u has no zero if its value in the middle exceeds what the part's extent, with a margin for rounding,
  // and cone can take from it.
  const auto never = [&](const Vec3& tangent, double spread) {
    const double length = tangent.norm();
    const double reach = std::min(radius * length, 0.51 * (length * length + product) + bend * length);
    return std::abs(r.dot(tangent)) > reach + farthest * spread;
  };
  return distance - radius <= limit && !never(u, spreadU) && !never(v, spreadV);
}

bool mayHoldFootPoint(const SurfaceCell& cell, const Vec3& query, double limit)
{
  return cell.u0 == cell.u1 ||
    mayHoldFootPoint(cell.center - query, cell.radius, cell.tangentU, cell.spreadU, cell.tangentV, cell.spreadV, limit);
}

/// Near enough |x_uu|, at most about twice the change of the tangent from the middle of the cell, cannot matter. But on
/// the hollow side, beyond the centres of curvature, the distance may have several minima on a cell.
bool mayHaveMoreMinima(const SurfaceCell& cell, const Vec3& query)
{
  const double reach = (cell.center - query).norm() + cell.radius;
  return !(6.0 * reach * cell.spreadU < cell.tangentU.squaredNorm() &&
    6.0 * reach * cell.spreadV < cell.tangentV.squaredNorm() &&
    6.0 * reach * std::max(cell.spreadU, cell.spreadV) < cell.tangentU.norm() * cell.tangentV.norm());
}

double boxDistance(const Box3& box, const Vec3& query)
{
  return (query - query.cwiseMax(box.min()).cwiseMin(box.max())).norm();
}

} // namespace

struct BodySurface::Locator
{
  std::vector<BodyPatch> patches;
  std::vector<TrimRegion> regions;
  std::vector<SurfacePiece> pieces;
  std::vector<SurfaceEdge> edges;
  std::vector<SurfaceCell> cells;
  std::vector<Node> nodes;
  std::vector<Node> edgeNodes;
  std::vector<Index> cellOrder;
  std::vector<Index> edgeCellOrder;
  Box3 bounds;
  double size = 0.0;

  void build(const Execution& run);
  Index buildTree(std::vector<Node>& tree, std::vector<Index>& order, Index begin, Index end) const;
  /// Calls body(cell) for the cells in the order of their least distance until that exceeds `limit`.
  template <typename Body>
  void visit(const std::vector<Node>& tree, const std::vector<Index>& order, const Vec3& query, const double& limit,
    const Body& body) const;
  /// Foot points within `limit` in a part of a cell where one descent may miss some. `submit` lowers the limit.
  template <typename Submit>
  void searchPart(const SurfaceCell& cell, const Box2& range, int halvings, const Vec3& query, const double& limit,
    const Submit& submit) const;
  /// Foot point near a part of a cell, if the distance has a minimum there.
  bool descend(const SurfaceCell& cell, const Box2& range, const Vec3& query, Candidate& found) const;
  /// Foot point or end of the part of an edge, unless it is a kink's and trimmed away.
  bool searchEdge(const SurfaceCell& cell, const Vec3& query, Candidate& found) const;
  void polish(const Vec3& query, Candidate& candidate) const;
  /// All candidates that are closer than the least distance plus `tolerance`.
  std::vector<Candidate> candidates(const Vec3& query, double tolerance, bool edgesOnly) const;
  BodyPoint bodyPoint(const Candidate& candidate) const;
  BodyPoint closest(const Vec3& query, bool edgesOnly) const;
};

void BodySurface::Locator::build(const Execution& run)
{
  Box3 controlBox;
  for (std::size_t i = 0; i < this->patches.size(); ++i)
  {
    const std::string& name = this->patches[i].name;
    checkBodyPatch(this->patches[i], "patch " + std::to_string(i) + (name.empty() ? "" : " '" + name + "'"));
    for (const Vec3& point : this->patches[i].surface.points)
    {
      controlBox.extend(point);
    }
  }
  if (this->patches.empty())
  {
    return;
  }
  const double smallest = SmallestCell * controlBox.diagonal().norm();

  struct Parts
  {
    std::vector<SurfacePiece> pieces;
    std::vector<SurfaceEdge> edges;
    std::vector<SurfaceCell> cells;
  };
  const Index count = static_cast<Index>(this->patches.size());
  std::vector<Parts> parts(count);
  this->regions.resize(count);
  run.parallelFor(count, 1, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i)
    {
      const BodyPatch& patch = this->patches[i];
      const int index = static_cast<int>(i);
      Parts& part = parts[i];
      this->regions[i] = TrimRegion(patch.loops);
      for (NURBSSurface& piece : smoothPieces(patch.surface))
      {
        part.pieces.push_back({ index, std::move(piece) });
      }
      for (std::size_t k = 0; k < part.pieces.size(); ++k)
      {
        pieceCells(part.pieces[k], static_cast<int>(k), this->regions[i], smallest, part.cells);
      }
      for (const TrimLoop& loop :
        patch.loops.empty() ? std::vector<TrimLoop>{ domainLoop(patch.surface) } : patch.loops)
      {
        for (const ParameterCurve& curve : loop)
        {
          part.edges.push_back({ index, curve, false });
        }
      }
      for (ParameterCurve& line : kinkLines(patch.surface))
      {
        part.edges.push_back({ index, std::move(line), true });
      }
      for (std::size_t e = 0; e < part.edges.size(); ++e)
      {
        edgeCells(patch.surface, part.edges[e].curve, static_cast<int>(e), smallest, part.cells);
      }
    }
  });
  for (Parts& part : parts)
  {
    const int firstPiece = static_cast<int>(this->pieces.size());
    const int firstEdge = static_cast<int>(this->edges.size());
    for (SurfaceCell& cell : part.cells)
    {
      cell.piece < 0 ? cell.edge += firstEdge : cell.piece += firstPiece;
      this->bounds.extend(cell.box);
      this->cells.push_back(cell);
    }
    std::move(part.pieces.begin(), part.pieces.end(), std::back_inserter(this->pieces));
    std::move(part.edges.begin(), part.edges.end(), std::back_inserter(this->edges));
  }
  this->size = this->bounds.diagonal().norm();
  for (std::size_t c = 0; c < this->cells.size(); ++c)
  {
    this->cellOrder.push_back(static_cast<Index>(c));
    if (this->cells[c].piece < 0)
    {
      this->edgeCellOrder.push_back(static_cast<Index>(c));
    }
  }
  this->buildTree(this->nodes, this->cellOrder, 0, static_cast<Index>(this->cellOrder.size()));
  this->buildTree(this->edgeNodes, this->edgeCellOrder, 0, static_cast<Index>(this->edgeCellOrder.size()));
}

Index BodySurface::Locator::buildTree(std::vector<Node>& tree, std::vector<Index>& order, Index begin, Index end) const
{
  const Index self = static_cast<Index>(tree.size());
  Node node;
  Box3 centers;
  for (Index i = begin; i < end; ++i)
  {
    node.box.extend(this->cells[order[i]].box);
    centers.extend(this->cells[order[i]].box.center());
  }
  tree.push_back(node);
  if (end - begin <= CellsPerNode)
  {
    tree[self].first = begin;
    tree[self].count = end - begin;
    return self;
  }
  int axis = 0;
  centers.diagonal().maxCoeff(&axis);
  const Index middle = begin + (end - begin) / 2;
  std::nth_element(order.begin() + begin, order.begin() + middle, order.begin() + end, [&](Index a, Index b) {
    const double x = this->cells[a].box.min()[axis] + this->cells[a].box.max()[axis];
    const double y = this->cells[b].box.min()[axis] + this->cells[b].box.max()[axis];
    return x != y ? x < y : a < b;
  });
  const Index first = this->buildTree(tree, order, begin, middle);
  const Index second = this->buildTree(tree, order, middle, end);
  tree[self].first = first;
  tree[self].second = second;
  return self;
}

template <typename Body>
void BodySurface::Locator::visit(const std::vector<Node>& tree, const std::vector<Index>& order, const Vec3& query,
  const double& limit, const Body& body) const
{
  if (order.empty())
  {
    return;
  }
  // Nodes are entered by 2 * index, cells by 2 * index + 1.
  using Entry = std::pair<double, Index>;
  static thread_local std::vector<Entry> heap;
  heap.clear();
  const auto push = [&](const Box3& box, Index id) {
    const double distance = boxDistance(box, query);
    if (distance <= limit)
    {
      heap.emplace_back(distance, id);
      std::push_heap(heap.begin(), heap.end(), std::greater<Entry>());
    }
  };
  push(tree[0].box, 0);
  while (!heap.empty() && heap.front().first <= limit)
  {
    const Index id = heap.front().second;
    std::pop_heap(heap.begin(), heap.end(), std::greater<Entry>());
    heap.pop_back();
    if (id % 2 == 1)
    {
      if (mayHoldFootPoint(this->cells[id / 2], query, limit))
      {
        body(this->cells[id / 2]);
      }
      continue;
    }
    const Node& node = tree[id / 2];
    if (node.count > 0)
    {
      for (Index i = node.first; i < node.first + node.count; ++i)
      {
        if (mayHoldFootPoint(this->cells[order[i]], query, limit))
        {
          push(this->cells[order[i]].box, 2 * order[i] + 1);
        }
      }
    }
    else
    {
      push(tree[node.first].box, 2 * node.first);
      push(tree[node.second].box, 2 * node.second);
    }
  }
}

template <typename Submit>
void BodySurface::Locator::searchPart(const SurfaceCell& cell, const Box2& range, int halvings, const Vec3& query,
  const double& limit, const Submit& submit) const
{
  const NURBSSurface& surface = this->pieces[cell.piece].surface;
  const Vec2 middle = range.center(), extent = range.diagonal();
  const Vec2& low = range.min();
  const Vec2& high = range.max();
  const SurfaceDerivatives center = evaluate(surface, middle[0], middle[1]);
  // Beside the middle of the cell, not the part, tangents vary by twice as much.
  const double part = std::ldexp(1.0, halvings - HollowHalvings), spread = 2.0 * part * part;
  if (!mayHoldFootPoint(center.x - query, 1.25 * part * cell.radius, extent[0] * center.u, spread * cell.spreadU,
        extent[1] * center.v, spread * cell.spreadV, limit))
  {
    return;
  }
  const auto convex = [&](const SurfaceDerivatives& at) {
    const Vec3 r = at.x - query;
    const double E = at.u.squaredNorm();
    const double G = at.v.squaredNorm();
    const double F = at.u.dot(at.v);
    const double huu = E + r.dot(at.uu);
    const double huv = F + r.dot(at.uv);
    const double hvv = G + r.dot(at.vv);
    return huu > 0.5 * E && hvv > 0.5 * G && huu * hvv - huv * huv > 0.25 * (E * G - F * F);
  };
  const auto convexAt = [&](double u, double v) { return convex(evaluate(surface, u, v)); };
  if (halvings == 0 ||
    (convex(center) && convexAt(low[0], low[1]) && convexAt(high[0], high[1]) && convexAt(low[0], high[1]) &&
      convexAt(high[0], low[1])))
  {
    Candidate candidate;
    // The descent from the middle of the whole cell was made.
    if (halvings < HollowHalvings && this->descend(cell, range, query, candidate))
    {
      submit(candidate);
    }
    return;
  }
  for (int quarter = 0; quarter < 4; ++quarter)
  {
    const Vec2 corner(quarter % 2 == 0 ? low[0] : high[0], quarter / 2 == 0 ? low[1] : high[1]);
    this->searchPart(cell, Box2(corner.cwiseMin(middle), corner.cwiseMax(middle)), halvings - 1, query, limit, submit);
  }
}

bool BodySurface::Locator::descend(
  const SurfaceCell& cell, const Box2& range, const Vec3& query, Candidate& found) const
{
  const SurfacePiece& piece = this->pieces[cell.piece];
  const NURBSSurface& surface = piece.surface;
  const Vec2 margin = CellMargin * range.diagonal();
  const Vec2 low = (range.min() - margin).cwiseMax(Vec2(surface.first(0), surface.first(1)));
  const Vec2 high = (range.max() + margin).cwiseMin(Vec2(surface.last(0), surface.last(1)));

  Vec2 uv = range.center();
  SurfaceDerivatives at = evaluate(surface, uv[0], uv[1]);
  Vec3 r = at.x - query;
  double value = r.squaredNorm();
  int atBorder = 0;
  // Of a point.
  const double rounding = 1e-15 * (this->size + query.cwiseAbs().maxCoeff());
  for (int iteration = 0; iteration < 50; ++iteration)
  {
    Vec2 gradient(r.dot(at.u), r.dot(at.v));
    Eigen::Matrix2d first;
    first << at.u.dot(at.u), at.u.dot(at.v), at.u.dot(at.v), at.v.dot(at.v);
    Eigen::Matrix2d hessian = first;
    hessian(0, 0) += r.dot(at.uu);
    hessian(0, 1) += r.dot(at.uv);
    hessian(1, 0) = hessian(0, 1);
    hessian(1, 1) += r.dot(at.vv);
    const auto positive = [](const Eigen::Matrix2d& m) {
      return m(0, 0) > 0.0 && m(1, 1) > 0.0 && m.determinant() > 1e-10 * m(0, 0) * m(1, 1);
    };
    if (!positive(hessian))
    {
      hessian = first;
      hessian.diagonal() += 1e-9 * first.diagonal();
    }
    // A parameter on its bound that wants to leave is held.
    std::array<bool, 2> held{};
    for (int d = 0; d < 2; ++d)
    {
      held[d] = (uv[d] <= low[d] && gradient[d] > 0.0) || (uv[d] >= high[d] && gradient[d] < 0.0);
    }
    Vec2 step = Vec2::Zero();
    if (held[0] && held[1])
    {
      return false;
    }
    if (held[0] || held[1])
    {
      if (++atBorder > MaxBorderSteps)
      {
        return false;
      }
      const int d = held[0] ? 1 : 0;
      step[d] = -gradient[d] / hessian(d, d);
    }
    else if (positive(hessian))
    {
      step = -hessian.inverse() * gradient;
    }
    else
    {
      // A tangent vanishes: each parameter for itself.
      for (int d = 0; d < 2; ++d)
      {
        step[d] = first(d, d) > 0.0 ? -gradient[d] / first(d, d) : 0.0;
      }
    }
    if (!step.allFinite())
    {
      break;
    }
    // Descent: halved until the distance does not grow by more than rounding.
    const double growth = 1e-14 * value + rounding * (2.0 * std::sqrt(value) + rounding);
    bool moved = false;
    for (int halving = 0; halving < 12; ++halving, step *= 0.5)
    {
      const Vec2 next = (uv + step).cwiseMax(low).cwiseMin(high);
      if (next == uv)
      {
        break;
      }
      const SurfaceDerivatives there = evaluate(surface, next[0], next[1]);
      const Vec3 nextR = there.x - query;
      const double nextValue = nextR.squaredNorm();
      if (nextValue < value || (halving == 0 && nextValue <= value + growth))
      {
        moved = nextValue < value;
        uv = next;
        at = there;
        r = nextR;
        value = nextValue;
        break;
      }
    }
    const double travelled = (at.u * step[0]).norm() + (at.v * step[1]).norm();
    if (!moved || travelled <= 1e-16 * this->size)
    {
      break;
    }
  }
  // Stopped, but by the border: no foot point here.
  const Vec2 gradient(r.dot(at.u), r.dot(at.v));
  for (int d = 0; d < 2; ++d)
  {
    if ((uv[d] <= low[d] && gradient[d] > 0.0) || (uv[d] >= high[d] && gradient[d] < 0.0))
    {
      return false;
    }
  }
  if (cell.crossed && !this->regions[piece.patch].contains(uv))
  {
    return false;
  }
  // The margin may reach over a trimming curve though the cell does not.
  if (!cell.crossed && !this->regions[piece.patch].empty() &&
    (uv[0] < cell.u0 || uv[0] > cell.u1 || uv[1] < cell.v0 || uv[1] > cell.v1) &&
    !this->regions[piece.patch].contains(uv))
  {
    return false;
  }
  found = { std::sqrt(value), piece.patch, uv[0], uv[1], cell.piece, false, at.x };
  return true;
}

bool BodySurface::Locator::searchEdge(const SurfaceCell& cell, const Vec3& query, Candidate& found) const
{
  const SurfaceEdge& edge = this->edges[cell.edge];
  const NURBSSurface& surface = this->patches[edge.patch].surface;
  const auto result = [&](const CurvePoint& at) {
    const Vec2 uv(std::min(std::max(at.uv[0], surface.first(0)), surface.last(0)),
      std::min(std::max(at.uv[1], surface.first(1)), surface.last(1)));
    found = { (at.x - query).norm(), edge.patch, uv[0], uv[1], -1, true, at.x };
    return !edge.kink || this->regions[edge.patch].contains(at.uv);
  };
  double low = cell.u0;
  double high = cell.u1;
  if (low == high)
  {
    return result(evaluateEdge(surface, edge.curve, low));
  }
  // On a knot derivatives are those to its right.
  high -= EndShift * (high - low);
  const CurvePoint atLow = evaluateEdge(surface, edge.curve, low);
  const CurvePoint atHigh = evaluateEdge(surface, edge.curve, high);
  if (!((atLow.x - query).dot(atLow.d1) < 0.0))
  {
    return result(atLow);
  }
  if (!((atHigh.x - query).dot(atHigh.d1) > 0.0))
  {
    return result(atHigh);
  }
  // The derivative of the distance changes its sign from - to +: Newton inside the shrinking bracket, else halving.
  double t = 0.5 * (low + high);
  CurvePoint at = evaluateEdge(surface, edge.curve, t);
  for (int i = 0; i < 120; ++i)
  {
    const Vec3 r = at.x - query;
    const double slope = r.dot(at.d1);
    if (slope == 0.0)
    {
      break;
    }
    (slope < 0.0 ? low : high) = t;
    const double curvature = at.d1.squaredNorm() + r.dot(at.d2);
    double next = t - slope / curvature;
    if (!(curvature > 0.0) || !(next > low && next < high) || i % 8 == 7)
    {
      next = 0.5 * (low + high);
    }
    if (next == t || next <= low || next >= high)
    {
      break;
    }
    const bool done = at.d1.norm() * std::abs(next - t) <= 1e-16 * this->size;
    t = next;
    at = evaluateEdge(surface, edge.curve, t);
    if (done)
    {
      break;
    }
  }
  return result(at);
}

void BodySurface::Locator::polish(const Vec3& query, Candidate& candidate) const
{
  if (candidate.onEdge)
  {
    return;
  }
  // The distance no longer changes; the last Newton steps are judged by the residual instead.
  const NURBSSurface& surface = this->pieces[candidate.piece].surface;
  const auto residual = [&](const SurfaceDerivatives& at) {
    const Vec3 r = at.x - query;
    const double a = at.u.norm();
    const double b = at.v.norm();
    return std::max(a > 0.0 ? std::abs(r.dot(at.u)) / a : 0.0, b > 0.0 ? std::abs(r.dot(at.v)) / b : 0.0);
  };
  SurfaceDerivatives at = evaluate(surface, candidate.u, candidate.v);
  double now = residual(at);
  for (int i = 0; i < 6 && now > 1e-16 * this->size; ++i)
  {
    const Vec3 r = at.x - query;
    Eigen::Matrix2d hessian;
    hessian << at.u.dot(at.u) + r.dot(at.uu), at.u.dot(at.v) + r.dot(at.uv), at.u.dot(at.v) + r.dot(at.uv),
      at.v.dot(at.v) + r.dot(at.vv);
    const Vec2 step = -hessian.inverse() * Vec2(r.dot(at.u), r.dot(at.v));
    const Vec2 next(candidate.u + step[0], candidate.v + step[1]);
    if (!next.allFinite() || next[0] < surface.first(0) || next[0] > surface.last(0) || next[1] < surface.first(1) ||
      next[1] > surface.last(1) || (at.u * step[0] + at.v * step[1]).norm() > 1e-5 * this->size)
    {
      return;
    }
    const SurfaceDerivatives there = evaluate(surface, next[0], next[1]);
    const double then = residual(there);
    if (!(then < now) || !this->regions[candidate.patch].contains(next))
    {
      return;
    }
    candidate.u = next[0];
    candidate.v = next[1];
    candidate.point = there.x;
    candidate.distance = (there.x - query).norm();
    at = there;
    now = then;
  }
}

std::vector<Candidate> BodySurface::Locator::candidates(const Vec3& query, double tolerance, bool edgesOnly) const
{
  std::vector<Candidate> found;
  // Cells where the distance may have more minima than the one found, if any.
  std::vector<const SurfaceCell*> left;
  double limit = std::numeric_limits<double>::infinity();
  const auto submit = [&](const Candidate& candidate) {
    if (candidate.distance <= limit)
    {
      found.push_back(candidate);
      limit = std::min(limit, candidate.distance + tolerance);
    }
  };
  this->visit(edgesOnly ? this->edgeNodes : this->nodes, edgesOnly ? this->edgeCellOrder : this->cellOrder, query,
    limit, [&](const SurfaceCell& cell) {
      Candidate candidate;
      if (cell.piece < 0 ? this->searchEdge(cell, query, candidate)
                         : this->descend(cell, Box2(Vec2(cell.u0, cell.v0), Vec2(cell.u1, cell.v1)), query, candidate))
      {
        submit(candidate);
      }
      if (cell.piece >= 0 && mayHaveMoreMinima(cell, query))
      {
        left.push_back(&cell);
      }
    });
  // Now that little is near enough.
  for (const SurfaceCell* cell : left)
  {
    this->searchPart(
      *cell, Box2(Vec2(cell->u0, cell->v0), Vec2(cell->u1, cell->v1)), HollowHalvings, query, limit, submit);
  }
  found.erase(
    std::remove_if(found.begin(), found.end(), [&](const Candidate& c) { return c.distance > limit; }), found.end());
  for (Candidate& candidate : found)
  {
    this->polish(query, candidate);
  }
  return found;
}

BodyPoint BodySurface::Locator::bodyPoint(const Candidate& candidate) const
{
  const BodyPatch& patch = this->patches[candidate.patch];
  BodyPoint result;
  result.patch = candidate.patch;
  result.u = candidate.u;
  result.v = candidate.v;
  result.distance = candidate.distance;
  result.onEdge = candidate.onEdge;
  result.geometry = surfaceGeometry(patch.surface, candidate.u, candidate.v, patch.reversed);
  return result;
}

namespace
{

/// Lower: the owner of a point that several candidates share.
bool owns(const Candidate& a, const Candidate& b)
{
  return std::make_tuple(a.patch, a.onEdge, a.u, a.v) < std::make_tuple(b.patch, b.onEdge, b.u, b.v);
}

} // namespace

BodyPoint BodySurface::Locator::closest(const Vec3& query, bool edgesOnly) const
{
  const double coincident = CoincidentFraction * this->size;
  const std::vector<Candidate> found = this->candidates(query, coincident, edgesOnly);
  if (found.empty())
  {
    return {};
  }
  // Around a foot point distances differ by less than rounding. There the connecting vector decides: the one that is
  // most nearly normal to the surface. (At poles, where parameters say little, this is the pole itself.)
  double least = std::numeric_limits<double>::infinity();
  for (const Candidate& candidate : found)
  {
    least = std::min(least, candidate.distance);
  }
  const double rounding = 1e-15 * (this->size + least);
  const Candidate* best = nullptr;
  double bestResidual = 0.0;
  for (const Candidate& candidate : found)
  {
    if (candidate.distance <= least + rounding)
    {
      const Vec3 normal = surfaceGeometry(this->patches[candidate.patch].surface, candidate.u, candidate.v).normal;
      const double residual = normal.cross(query - candidate.point).norm();
      if (!best || residual < bestResidual || (residual == bestResidual && owns(candidate, *best)))
      {
        best = &candidate;
        bestResidual = residual;
      }
    }
  }
  const Candidate* owner = best;
  for (const Candidate& candidate : found)
  {
    if ((candidate.point - best->point).norm() <= coincident && owns(candidate, *owner))
    {
      owner = &candidate;
    }
  }
  return this->bodyPoint(*owner);
}

BodySurface::BodySurface(std::vector<BodyPatch> patches, const Execution& run)
{
  auto locator = std::make_unique<Locator>();
  locator->patches = std::move(patches);
  locator->build(run);
  this->Data = std::move(locator);
}

BodySurface::~BodySurface() = default;
BodySurface::BodySurface(BodySurface&&) noexcept = default;
BodySurface& BodySurface::operator=(BodySurface&&) noexcept = default;

const std::vector<BodyPatch>& BodySurface::patches() const
{
  return this->Data->patches;
}

const Eigen::AlignedBox3d& BodySurface::bounds() const
{
  return this->Data->bounds;
}

double BodySurface::size() const
{
  return this->Data->size;
}

BodyPoint BodySurface::closestPoint(const Vec3& query) const
{
  return this->Data->closest(query, false);
}

std::vector<BodyPoint> BodySurface::closestPoints(const std::vector<Vec3>& queries, const Execution& run) const
{
  std::vector<BodyPoint> results(queries.size());
  const Index count = static_cast<Index>(queries.size());
  // In parts, so that progress can be told from this thread.
  constexpr Index Part = 65536;
  for (Index begin = 0; begin < count; begin += Part)
  {
    run.report(static_cast<double>(begin) / static_cast<double>(count));
    const Index end = std::min(begin + Part, count);
    run.parallelFor(end - begin, 64, [&](Index from, Index to) {
      for (Index i = begin + from; i < begin + to; ++i)
      {
        results[i] = this->Data->closest(queries[i], false);
      }
    });
  }
  return results;
}

std::vector<BodyPoint> BodySurface::closestPointPerPatch(const Vec3& query, double tolerance) const
{
  std::vector<Candidate> found = this->Data->candidates(query, tolerance, false);
  // Neighbouring cells find the same point, one of them best; sides of a seam are far apart in the domain.
  std::sort(found.begin(), found.end(), [](const Candidate& a, const Candidate& b) {
    return a.distance != b.distance ? a.distance < b.distance : owns(a, b);
  });
  std::vector<Candidate> kept;
  for (const Candidate& candidate : found)
  {
    const NURBSSurface& surface = this->Data->patches[candidate.patch].surface;
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const Candidate& other) {
      return other.patch == candidate.patch &&
        std::abs(other.u - candidate.u) <= 1e-3 * (surface.last(0) - surface.first(0)) &&
        std::abs(other.v - candidate.v) <= 1e-3 * (surface.last(1) - surface.first(1));
    });
    if (!known)
    {
      kept.push_back(candidate);
    }
  }
  std::sort(kept.begin(), kept.end(), owns);
  std::vector<BodyPoint> results;
  results.reserve(kept.size());
  for (const Candidate& candidate : kept)
  {
    results.push_back(this->Data->bodyPoint(candidate));
  }
  return results;
}

BodyPoint BodySurface::closestEdgePoint(const Vec3& query) const
{
  return this->Data->closest(query, true);
}

} // namespace bsv
