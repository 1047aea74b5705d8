// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/Converter.h"

#include "Base/OrderFreeSum.h"
#include "Conversion/SingularNode.h"

#include <algorithm>

namespace bsv
{

namespace
{

/// Mesh point of a block next to its corner: a step along each direction whose bit is set in `steps`.
Ijk cornerPoint(const ComplexBlock& owner, int corner, int steps)
{
  Ijk point;
  for (int d = 0; d < 3; ++d)
  {
    const int step = steps >> d & 1;
    point[d] = cornerSide(corner, d) ? owner.cells(d) - step : step;
  }
  return point;
}

} // namespace

bool Converter::Star::keptFacesMeet() const
{
  for (std::size_t e = 0; e < this->edges.size(); ++e)
  {
    std::vector<bool> kept;
    for (const int spoke : this->info[e].spokes)
    {
      kept.push_back(false);
      for (std::size_t f = 0; f < this->faces.size(); ++f)
      {
        const auto& ends = this->faces[f].edges;
        kept.back() =
          kept.back() || (this->keptFaces[f] && std::minmax(ends[0], ends[1]) == std::minmax<int>(e, spoke));
      }
    }
    if (keptLinesMeet(this->info[e].fan->closed, kept))
    {
      return true;
    }
  }
  return false;
}

void Converter::convertVertex(int vertex)
{
  Star star = this->makeStar(vertex);
  if (star.boundary)
  {
    this->convertSurface(star);
    this->moveEnd(star);
    if (!this->convertStacked(star))
    {
      this->convertAnchored(star);
    }
  }
  else if (!this->convertRegular(star) && !this->convertStacked(star))
  {
    bool keeps = false;
    for (const VertexStar::Edge& edge : star.edges)
    {
      keeps = keeps || this->Rules.edges[edge.edge].anchored;
    }
    if (keeps)
    {
      star.rule = ControlPointRule::PlanarSide;
    }
    else
    {
      star.rule = ControlPointRule::SingularNode;
      star.center = solidLimitPoint(star);
      this->SingularNodes += this->isHere(this->Complex.vertices[vertex].corners.front().block) ? 1 : 0;
    }
    this->convertAnchored(star);
  }

  for (std::size_t f = 0; f < star.faces.size(); ++f)
  {
    if (star.keptFaces[f])
    {
      star.faceRules[f] = ControlPointRule::Crease;
      for (const int edge : star.faces[f].edges)
      {
        star.edgeRules[edge] = star.edges[edge].boundary ? star.edgeRules[edge] : ControlPointRule::Crease;
      }
      star.rule = star.boundary ? star.rule : ControlPointRule::Crease;
    }
  }
  if (star.keptFacesMeet())
  {
    for (std::size_t e = 0; e < star.edges.size(); ++e)
    {
      star.edgeRules[e] = star.edges[e].boundary ? star.edgeRules[e] : ControlPointRule::Crease;
    }
    for (std::size_t f = 0; f < star.faces.size(); ++f)
    {
      star.faceRules[f] = star.faces[f].boundary ? star.faceRules[f] : ControlPointRule::Crease;
    }
    star.blockRules.assign(star.blocks.size(), ControlPointRule::Crease);
  }

  this->writeStar(star);
}

Converter::Star Converter::makeStar(int vertex) const
{
  Star star;
  static_cast<VertexStar&>(star) = vertexStar(this->Complex, vertex);
  star.vertex = vertex;
  star.boundary = this->Complex.vertices[vertex].boundary;
  star.center = star.point;
  const std::size_t edges = star.edges.size();
  star.near.assign(edges, KnotInsertion);
  star.info.resize(edges);
  star.edgePoints.resize(edges);
  star.edgeRules.resize(edges);
  star.facePoints.resize(star.faces.size());
  star.faceRules.resize(star.faces.size());
  star.blockPoints.resize(star.blocks.size());
  star.blockRules.resize(star.blocks.size());
  for (const VertexStar::Block& block : star.blocks)
  {
    for (int d = 0; d < 3; ++d)
    {
      // The line along d leaves the block's face normal to d.
      const ComplexBlock& owner = this->Complex.blocks[block.block];
      const Ijk corner = cornerPoint(owner, block.corner, 0);
      const double own = this->Layer.weight(block.block, 2 * d + cornerSide(block.corner, d), corner);
      double& near = star.near[block.edges[d]];
      near = own == KnotInsertion ? near : near == KnotInsertion ? own : std::max(near, own);
    }
  }
  this->adjustStar(star);
  star.connection = std::any_of(star.faces.begin(), star.faces.end(),
    [&](const VertexStar::Face& face) { return this->Rules.faces[face.face].connection; });
  star.keptFaces.assign(star.faces.size(), false);
  star.diagonalKeep.assign(star.faces.size(), 0.0);
  for (const VertexStar::Block& block : star.blocks)
  {
    const ComplexBlock& owner = this->Complex.blocks[block.block];
    for (int d = 0; d < 3; ++d)
    {
      const int face = 2 * d + cornerSide(block.corner, d);
      for (int steps = 0; steps < 8; ++steps)
      {
        const double keep = this->keepAt(block.block, face, cornerPoint(owner, block.corner, steps & ~(1 << d)));
        star.keptFaces[block.faces[d]] = star.keptFaces[block.faces[d]] || keep > 0.0;
        if ((steps | 1 << d) == 7)
        {
          star.diagonalKeep[block.faces[d]] = keep;
        }
      }
    }
  }
  for (std::size_t e = 0; e < edges; ++e)
  {
    const std::vector<EdgeFan>& fans = this->Rules.edges[star.edges[e].edge].fans;
    Star::EdgeInfo& info = star.info[e];
    info.fan = &fans.front();
    info.whole = fans.size() == 1;
    for (const FanSector& sector : info.fan->sectors)
    {
      // The corner of the sector's block at this end of the edge.
      const int corner = edgeCorner(sector.edge, star.edges[e].end ^ (sector.reversed ? 1 : 0));
      int index = 0;
      while (star.blocks[index].block != sector.block || star.blocks[index].corner != corner)
      {
        ++index;
      }
      info.sectors.push_back(index);
      info.spokes.push_back(star.blocks[index].edges[sector.first]);
    }
    if (!info.fan->closed)
    {
      info.spokes.push_back(star.blocks[info.sectors.back()].edges[info.fan->sectors.back().second]);
    }
  }
  return star;
}

void Converter::adjustStar(Star& star) const
{
  // The points as they are: those of faces and blocks are moved by what they have to others.
  const std::vector<VertexStar::Face> faces = star.faces;
  for (VertexStar::Block& block : star.blocks)
  {
    const ComplexBlock& owner = this->Complex.blocks[block.block];
    const Ijk center = cornerPoint(owner, block.corner, 0);
    // Ratio of (1 - c) of the line along d, `steps` away from the vertex in the other directions.
    const auto ratio = [&](int d, int steps) {
      return this->layerRatio(
        block.block, 2 * d + cornerSide(block.corner, d), cornerPoint(owner, block.corner, steps), center);
    };
    std::array<Vec3, 3> offsets;
    for (int d = 0; d < 3; ++d)
    {
      offsets[d] = (ratio(d, 7 & ~(1 << d)) - 1.0) * (block.point - faces[block.faces[d]].point);
      const int a = (d + 1) % 3, b = (d + 2) % 3;
      const double ra = ratio(a, 1 << b), rb = ratio(b, 1 << a);
      if (ra != 1.0 || rb != 1.0)
      {
        const Vec3& point = faces[block.faces[d]].point;
        const Vec3 offset = (ra - 1.0) * (point - star.edges[block.edges[b]].point) +
          (rb - 1.0) * (point - star.edges[block.edges[a]].point);
        star.faces[block.faces[d]].point = point + offset;
      }
    }
    OrderFreeSum sum;
    for (const Vec3& offset : offsets)
    {
      sum.add(1.0, offset);
    }
    block.point += 3.0 * sum.result(3.0);
  }
}

Fan Converter::starLayer(const Star& star, int starEdge, int k) const
{
  const VertexStar::Edge& edge = star.edges[starEdge];
  const int cells = this->Complex.edges[edge.edge].cells;
  return edge.end == 0 ? this->controlFan(edge.edge, *star.info[starEdge].fan, k, k - 1)
                       : this->controlFan(edge.edge, *star.info[starEdge].fan, cells - k, k > 0 ? cells - k + 1 : -1);
}

bool Converter::convertRegular(Star& star) const
{
  const int edges = static_cast<int>(star.edges.size());
  if (edges != 6 || star.blocks.size() != 8 || star.faces.size() != 12 || star.keepsPoints())
  {
    return false;
  }
  // The axis of each star edge: opposite edges span no face.
  std::vector<int> opposite(6, -1);
  for (int e = 0; e < 6; ++e)
  {
    if (!this->Rules.edges[star.edges[e].edge].regular())
    {
      return false;
    }
    for (int other = 0; other < 6; ++other)
    {
      if (other != e && star.faceBetween(e, other) < 0)
      {
        if (opposite[e] >= 0)
        {
          return false;
        }
        opposite[e] = other;
      }
    }
    if (opposite[e] < 0)
    {
      return false;
    }
  }
  // Tensor product per axis: [1 4 1]/6 through the vertex, or [2 1]/3 towards star edge `e` of `inserted`.
  OrderFreeSum sum;
  const auto tensor = [&](const std::vector<int>& inserted) {
    const auto contains = [](const std::vector<int>& list, int e) {
      return std::find(list.begin(), list.end(), e) != list.end();
    };
    const auto weightOf = [&](const std::vector<int>& members) {
      double weight = 1.0;
      for (int e = 0; e < 6; ++e)
      {
        if (e > opposite[e])
        {
          continue;
        }
        const int o = opposite[e];
        const bool insertsHere = contains(inserted, e) || contains(inserted, o);
        const int near = contains(members, e) ? e : contains(members, o) ? o : -1;
        if (near < 0)
        {
          weight *= insertsHere ? 2.0 : 4.0;
        }
        else if (insertsHere && !contains(inserted, near))
        {
          weight = 0.0;
        }
      }
      return weight;
    };
    sum.clear();
    sum.add(weightOf({}), star.point);
    for (int e = 0; e < 6; ++e)
    {
      sum.add(weightOf({ e }), star.edges[e].point);
    }
    for (const VertexStar::Face& face : star.faces)
    {
      sum.add(weightOf({ face.edges[0], face.edges[1] }), face.point);
    }
    for (const VertexStar::Block& block : star.blocks)
    {
      sum.add(weightOf({ block.edges[0], block.edges[1], block.edges[2] }), block.point);
    }
    double denominator = 1.0;
    for (std::size_t d = 0; d < 3; ++d)
    {
      denominator *= d < inserted.size() ? 3.0 : 6.0;
    }
    return sum.result(denominator);
  };
  star.rule = ControlPointRule::Regular;
  star.center = tensor({});
  for (int e = 0; e < 6; ++e)
  {
    star.edgePoints[e] = tensor({ e });
    star.edgeRules[e] = star.rule;
  }
  for (std::size_t f = 0; f < star.faces.size(); ++f)
  {
    star.facePoints[f] = tensor({ star.faces[f].edges[0], star.faces[f].edges[1] });
    star.faceRules[f] = star.rule;
  }
  for (std::size_t b = 0; b < star.blocks.size(); ++b)
  {
    const auto& e = star.blocks[b].edges;
    star.blockPoints[b] = tensor({ e[0], e[1], e[2] });
    star.blockRules[b] = star.rule;
  }
  return true;
}

Converter::StackAxes Converter::stackAxes(const Star& star) const
{
  StackAxes axes;
  const int edges = static_cast<int>(star.edges.size());
  const int blocks = static_cast<int>(star.blocks.size());
  // At the boundary: one stack around an interior edge that all blocks share.
  for (int e = 0; e < edges && axes.up < 0; ++e)
  {
    const Star::EdgeInfo& info = star.info[e];
    if (star.boundary && !star.edges[e].boundary && info.whole && static_cast<int>(info.sectors.size()) == blocks)
    {
      axes.up = e;
    }
  }
  // Otherwise two stacks of the same blocks around two edges without a common face, of the same kind. Where several
  // axes will do, the one with the smallest point is taken, whatever the numbering.
  const auto before = [&](int a, int b) {
    const Vec3& p = star.edges[a].point;
    const Vec3& q = star.edges[b].point;
    return std::lexicographical_compare(p.data(), p.data() + 3, q.data(), q.data() + 3);
  };
  const bool single = axes.up >= 0;
  for (int e = 0; e < edges && !single; ++e)
  {
    for (int other = 0; other < edges; ++other)
    {
      if (other != e && (axes.up < 0 || before(e, axes.up)) && this->areStacked(star, e, other))
      {
        axes = { e, other };
      }
    }
  }
  return axes;
}

bool Converter::areStacked(const Star& star, int up, int down) const
{
  const EdgeRule& upRule = this->Rules.edges[star.edges[up].edge];
  const EdgeRule& downRule = this->Rules.edges[star.edges[down].edge];
  const Star::EdgeInfo& a = star.info[up];
  const Star::EdgeInfo& b = star.info[down];
  if (star.faceBetween(up, down) >= 0 || !a.whole || !b.whole || a.spokes.size() != b.spokes.size() ||
    a.sectors.size() + b.sectors.size() != star.blocks.size() || a.fan->closed != b.fan->closed ||
    upRule.anchored != downRule.anchored || upRule.rule != downRule.rule)
  {
    return false;
  }
  for (const int spoke : a.spokes)
  {
    if (std::find(b.spokes.begin(), b.spokes.end(), spoke) == b.spokes.end())
    {
      return false;
    }
  }
  for (std::size_t i = 0; i < a.sectors.size(); ++i)
  {
    // The face between the stacks: the mask across the layers must not be one that keeps points.
    const int ring = star.blocks[a.sectors[i]].faces[a.fan->sectors[i].along];
    const auto& pair = star.faces[ring].blocks;
    const int across = pair[0] == a.sectors[i] ? pair[1] : pair[0];
    if (star.keptFaces[ring] || this->Rules.faces[star.faces[ring].face].connection ||
      std::find(b.sectors.begin(), b.sectors.end(), across) == b.sectors.end())
    {
      return false;
    }
  }
  // On the boundary the outer surface must agree: it is smooth, or its crease is the axis.
  const bool isCrease =
    (star.crease[0] == up && star.crease[1] == down) || (star.crease[0] == down && star.crease[1] == up);
  return !star.boundary || (upRule.feature ? isCrease : star.surfaceIsSmooth);
}

bool Converter::convertStacked(Star& star) const
{
  const auto [up, down] = this->stackAxes(star);
  if (up < 0)
  {
    return false;
  }
  const EdgeRule& axisRule = this->Rules.edges[star.edges[up].edge];
  if (!star.boundary && axisRule.anchored)
  {
    return false;
  }

  // A stack is the layer one step along its axis, with the star faces through its spokes and the star blocks of its
  // sectors, all in the order of the fan around `up`.
  struct Stack
  {
    int axis;
    Fan layer;
    std::vector<int> faces;
    std::vector<int> blocks;
  };
  const auto makeStack = [&](int axis) {
    const Star::EdgeInfo& info = star.info[axis];
    Stack stack{ axis, this->starLayer(star, axis, 1), {}, info.sectors };
    for (int i = 0; i < info.fan->spokeCount(); ++i)
    {
      const auto [sector, which] = info.fan->spoke(i);
      const int block = info.sectors[sector - info.fan->sectors.data()];
      stack.faces.push_back(star.blocks[block].faces[faceDirection(sector->spokeFace(which))]);
    }
    return stack;
  };
  const Star::EdgeInfo& info = star.info[up];
  const int spokes = static_cast<int>(info.spokes.size());
  const int sectors = static_cast<int>(info.sectors.size());
  std::vector<int> ring; // star faces between the stacks, or on the boundary below the only one
  for (int i = 0; i < sectors; ++i)
  {
    ring.push_back(star.blocks[info.sectors[i]].faces[info.fan->sectors[i].along]);
  }
  Fan middle = this->starLayer(star, up, 0);
  std::vector<Stack> stacks{ makeStack(up) };
  if (down >= 0)
  {
    const Stack values = makeStack(down);
    Stack ordered = values;
    for (int i = 0; i < spokes; ++i)
    {
      const auto& list = star.info[down].spokes;
      const std::size_t from = std::find(list.begin(), list.end(), info.spokes[i]) - list.begin();
      ordered.layer.spokes[i] = values.layer.spokes[from];
      ordered.faces[i] = values.faces[from];
    }
    for (int i = 0; i < sectors; ++i)
    {
      // The block on the other side of the face between the stacks.
      const auto& pair = star.faces[ring[i]].blocks;
      const int block = pair[0] == stacks[0].blocks[i] ? pair[1] : pair[0];
      const std::size_t from = std::find(values.blocks.begin(), values.blocks.end(), block) - values.blocks.begin();
      ordered.layer.sectors[i] = values.layer.sectors[from];
      ordered.blocks[i] = block;
    }
    stacks.push_back(ordered);
  }
  else
  {
    // The converted outer surface is layer 0.
    middle.center = star.center;
    for (int i = 0; i < spokes; ++i)
    {
      middle.spokes[i] = star.edgePoints[info.spokes[i]];
    }
    for (int i = 0; i < sectors; ++i)
    {
      middle.sectors[i] = star.facePoints[ring[i]];
    }
  }

  // The outer surface keeps what it has: only what lies inside is set.
  // Beside the edge of a single block the masks are the regular ones, between the blocks at a crease they are not.
  const bool outline = axisRule.rule == ControlPointRule::Crease && sectors == 1;
  const ControlPointRule inner = outline ? ControlPointRule::Boundary : axisRule.rule;
  const auto setEdge = [&](int e, const Vec3& value, ControlPointRule rule) {
    if (!star.edges[e].boundary)
    {
      star.edgePoints[e] = value;
      star.edgeRules[e] = rule;
    }
  };
  const auto setFace = [&](int f, const Vec3& value, ControlPointRule rule) {
    if (!star.faces[f].boundary)
    {
      star.facePoints[f] = value;
      star.faceRules[f] = rule;
    }
  };
  for (const Stack& stack : stacks)
  {
    const double near = star.near[stack.axis];
    const ControlPointRule rule =
      near != KnotInsertion && inner != ControlPointRule::ExtraordinaryEdge ? layerRule(star.connection) : inner;
    setEdge(stack.axis, insertMask(middle.center, stack.layer.center, near), rule);
    for (int i = 0; i < spokes; ++i)
    {
      setFace(stack.faces[i], insertMask(middle.spokes[i], stack.layer.spokes[i], near), rule);
    }
    for (int i = 0; i < sectors; ++i)
    {
      star.blockPoints[stack.blocks[i]] = insertMask(middle.sectors[i], stack.layer.sectors[i], near);
      star.blockRules[stack.blocks[i]] = rule;
    }
  }
  if (down >= 0)
  {
    const Fan& above = stacks[0].layer;
    const Fan& below = stacks[1].layer;
    if (!star.boundary)
    {
      star.rule = inner;
      star.center = smoothMask(above.center, middle.center, below.center);
    }
    for (int i = 0; i < spokes; ++i)
    {
      setEdge(info.spokes[i], smoothMask(above.spokes[i], middle.spokes[i], below.spokes[i]), inner);
    }
    for (int i = 0; i < sectors; ++i)
    {
      setFace(ring[i], smoothMask(above.sectors[i], middle.sectors[i], below.sectors[i]), inner);
    }
  }
  return true;
}

void Converter::convertAnchored(Star& star) const
{
  // At the boundary blocks do not lie as in a grid here: what is inserted is not smooth.
  const ControlPointRule inner = star.boundary ? ControlPointRule::Corner : star.rule;
  const auto ruleOf = [&](const auto& edges) {
    const bool near = std::any_of(edges.begin(), edges.end(), [&](int e) { return star.near[e] != KnotInsertion; });
    return near && inner == ControlPointRule::PlanarSide ? layerRule(star.connection) : inner;
  };
  // Values one step away from the vertex, along edges and in faces.
  std::vector<Vec3> along(star.edges.size()), diagonal(star.faces.size());
  for (std::size_t e = 0; e < star.edges.size(); ++e)
  {
    along[e] = this->starLayer(star, static_cast<int>(e), 1).center;
    if (!star.edges[e].boundary)
    {
      star.edgePoints[e] = insertMask(star.center, along[e], star.near[e]);
      star.edgeRules[e] = ruleOf(std::array<int, 1>{ static_cast<int>(e) });
    }
  }
  for (std::size_t f = 0; f < star.faces.size(); ++f)
  {
    const VertexStar::Face& face = star.faces[f];
    diagonal[f] = face.boundary || this->Rules.faces[face.face].planar()
      ? face.point
      : fadedMask(
          star.blocks[face.blocks[0]].point, face.point, star.blocks[face.blocks[1]].point, star.diagonalKeep[f]);
    if (!face.boundary)
    {
      const Vec3 corners[4] = { star.center, along[face.edges[0]], along[face.edges[1]], diagonal[f] };
      const double weights[2] = { star.near[face.edges[0]], star.near[face.edges[1]] };
      star.facePoints[f] = multilinear(corners, weights, 2);
      star.faceRules[f] = ruleOf(face.edges);
    }
  }
  for (std::size_t b = 0; b < star.blocks.size(); ++b)
  {
    const VertexStar::Block& block = star.blocks[b];
    Vec3 corners[8] = { star.point, star.edges[block.edges[0]].point, star.edges[block.edges[1]].point,
      star.faces[block.faces[2]].point, star.edges[block.edges[2]].point, star.faces[block.faces[1]].point,
      star.faces[block.faces[0]].point, block.point };
    if (star.rule == ControlPointRule::SingularNode)
    {
      // The centre has moved: interpolate between what lies around it.
      const Vec3 moved[7] = { star.center, along[block.edges[0]], along[block.edges[1]], diagonal[block.faces[2]],
        along[block.edges[2]], diagonal[block.faces[1]], diagonal[block.faces[0]] };
      std::copy_n(moved, 7, corners);
    }
    const double weights[3] = { star.near[block.edges[0]], star.near[block.edges[1]], star.near[block.edges[2]] };
    star.blockPoints[b] = multilinear(corners, weights, 3);
    star.blockRules[b] = ruleOf(block.edges);
  }
}

void Converter::writeStar(const Star& star) const
{
  for (std::size_t b = 0; b < star.blocks.size(); ++b)
  {
    const VertexStar::Block& entry = star.blocks[b];
    const ComplexBlock& owner = this->Complex.blocks[entry.block];
    for (int inserted = 0; inserted < 8; ++inserted)
    {
      // Bit d of `inserted`: one step in along direction d.
      Ijk position;
      for (int d = 0; d < 3; ++d)
      {
        position[d] = endPosition(cornerSide(entry.corner, d), inserted >> d & 1, owner.cells(d));
      }
      Vec3 point = star.center;
      ControlPointRule rule = star.rule;
      switch (inserted)
      {
        case 0:
          break;
        case 7:
          point = star.blockPoints[b];
          rule = star.blockRules[b];
          break;
        case 1:
        case 2:
        case 4: {
          const int edge = entry.edges[inserted / 2];
          point = star.edgePoints[edge];
          rule = star.edgeRules[edge];
          break;
        }
        default: {
          const int face = entry.faces[inserted == 6 ? 0 : inserted == 5 ? 1 : 2];
          point = star.facePoints[face];
          rule = star.faceRules[face];
        }
      }
      this->write(entry.block, position, point, rule);
    }
  }
}

} // namespace bsv
