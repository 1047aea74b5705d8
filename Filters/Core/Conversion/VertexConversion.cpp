// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/VertexConversion.h"

#include "Base/OrderFreeSum.h"
#include "Base/OrderFreeSums.h"
#include "Conversion/BodyPropagation.h"
#include "Conversion/SingularNode.h"
#include "Conversion/Star.h"
#include "Conversion/SurfaceConversion.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>
#include <vector>

namespace bsv
{

namespace
{

/// The points of a grid around its middle, and their number from steps of -1, 0 or 1 along three axes.
using RegularGrid = std::array<Vec3, 27>;
int gridPlace(const std::array<int, 3>& steps)
{
  return 13 + steps[0] + 3 * steps[1] + 9 * steps[2];
}

/// Tensor products of [1 4 1]/6 along some axes and [2 1]/3, towards the point that is made, along the `inserted`
/// others: all such points of the grid have the same weights.
struct RegularRule
{
  explicit RegularRule(int inserted)
  {
    for (int target = 0; target < 27; ++target)
    {
      const std::array<int, 3> steps{ target % 3 - 1, target / 3 % 3 - 1, target / 9 - 1 };
      std::array<int, 3> axes{ 0, 1, 2 };
      const auto others = std::stable_partition(axes.begin(), axes.end(), [&](int axis) { return steps[axis] != 0; });
      if (others - axes.begin() != inserted)
      {
        continue;
      }
      std::vector<double> products{ 1.0 };
      std::vector<std::array<int, 3>> members{ { 0, 0, 0 } };
      for (const int axis : axes)
      {
        const std::vector<std::pair<int, double>> mask = steps[axis] != 0
          ? std::vector<std::pair<int, double>>{ { 0, 2.0 }, { steps[axis], 1.0 } }
          : std::vector<std::pair<int, double>>{ { -1, 1.0 }, { 0, 4.0 }, { 1, 1.0 } };
        const std::vector<double> before = std::move(products);
        const std::vector<std::array<int, 3>> shorter = std::move(members);
        products.clear();
        members.clear();
        for (std::size_t i = 0; i < before.size(); ++i)
        {
          for (const auto& [step, weight] : mask)
          {
            products.push_back(before[i] * weight);
            members.push_back(shorter[i]);
            members.back()[axis] = step;
          }
        }
      }
      this->targets.push_back(target);
      this->weights = products;
      this->sources.resize(members.size());
      for (std::size_t term = 0; term < members.size(); ++term)
      {
        this->sources[term].push_back(gridPlace(members[term]));
      }
    }
    this->denominator = std::accumulate(this->weights.begin(), this->weights.end(), 0.0);
  }

  void apply(const RegularGrid& points, RegularGrid& results) const
  {
    constexpr std::size_t MostTargets = 12;
    std::array<std::array<Vec3, MostTargets>, MostOrderFreeTerms> terms;
    std::array<const double*, MostOrderFreeTerms> addresses;
    for (std::size_t term = 0; term < this->weights.size(); ++term)
    {
      for (std::size_t i = 0; i < this->targets.size(); ++i)
      {
        terms[term][i] = points[this->sources[term][i]];
      }
      addresses[term] = terms[term][0].data();
    }
    std::array<Vec3, MostTargets> sums;
    orderFreeSums(this->weights.data(), addresses.data(), static_cast<int>(this->weights.size()), this->denominator,
      3 * static_cast<Index>(this->targets.size()), sums[0].data());
    for (std::size_t i = 0; i < this->targets.size(); ++i)
    {
      results[this->targets[i]] = sums[i];
    }
  }

  std::vector<int> targets;
  std::vector<double> weights;
  /// Per weight, for each target, the point that it belongs to.
  std::vector<std::vector<int>> sources;
  double denominator = 0.0;
};

/// Tensor product of the masks, if all around the vertex is regular; otherwise does nothing and returns false.
bool convertRegular(const ConversionContext& context, Star& star)
{
  const int edges = static_cast<int>(star.edges.size());
  if (edges != 6 || star.blocks.size() != 8 || star.faces.size() != 12 || star.keepsPoints())
  {
    return false;
  }
  // The axis of each star edge, and its sense: opposite edges span no face.
  std::array<int, 6> opposite;
  opposite.fill(-1);
  for (int e = 0; e < 6; ++e)
  {
    if (!context.rules.edges[star.edges[e].edge].regular())
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
  std::array<std::array<int, 3>, 6> steps{};
  int axis = 0;
  for (int e = 0; e < 6; ++e)
  {
    if (e < opposite[e])
    {
      steps[e][axis] = 1;
      steps[opposite[e]][axis] = -1;
      ++axis;
    }
  }
  const auto placeOf = [&](const auto& members) {
    std::array<int, 3> sum{};
    for (const int e : members)
    {
      for (int d = 0; d < 3; ++d)
      {
        sum[d] += steps[e][d];
      }
    }
    return gridPlace(sum);
  };
  RegularGrid points, results;
  points[placeOf(std::array<int, 0>{})] = star.point;
  for (int e = 0; e < 6; ++e)
  {
    points[placeOf(std::array<int, 1>{ e })] = star.edges[e].point;
  }
  for (const VertexStar::Face& face : star.faces)
  {
    points[placeOf(face.edges)] = face.point;
  }
  for (const VertexStar::Block& block : star.blocks)
  {
    points[placeOf(block.edges)] = block.point;
  }
  static const std::array<RegularRule, 4> rules{ RegularRule(0), RegularRule(1), RegularRule(2), RegularRule(3) };
  for (const RegularRule& rule : rules)
  {
    rule.apply(points, results);
  }
  star.rule = ControlPointRule::Regular;
  star.center = results[placeOf(std::array<int, 0>{})];
  for (int e = 0; e < 6; ++e)
  {
    star.edgePoints[e] = results[placeOf(std::array<int, 1>{ e })];
    star.edgeRules[e] = star.rule;
  }
  for (std::size_t f = 0; f < star.faces.size(); ++f)
  {
    star.facePoints[f] = results[placeOf(star.faces[f].edges)];
    star.faceRules[f] = star.rule;
  }
  for (std::size_t b = 0; b < star.blocks.size(); ++b)
  {
    star.blockPoints[b] = results[placeOf(star.blocks[b].edges)];
    star.blockRules[b] = star.rule;
  }
  return true;
}

/// Blocks in two stacks (or one, at the boundary) around an axis: the rule across the layers after the rule in them.
/// Returns false, with the star unchanged, if the blocks do not lie so.
bool convertStacked(const ConversionContext& context, Star& star)
{
  const auto [up, down] = stackAxes(context, star);
  if (up < 0)
  {
    return false;
  }
  const EdgeRule& axisRule = context.rules.edges[star.edges[up].edge];
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
    Stack stack{ axis, starLayer(context, star, axis, 1), {}, info.sectors };
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
  Fan middle = starLayer(context, star, up, 0);
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

/// Everything else: inserted points between the centre, which is given, and the layers around it.
void convertAnchored(const ConversionContext& context, Star& star)
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
    along[e] = starLayer(context, star, static_cast<int>(e), 1).center;
    if (!star.edges[e].boundary)
    {
      star.edgePoints[e] = insertMask(star.center, along[e], star.near[e]);
      star.edgeRules[e] = ruleOf(std::array<int, 1>{ static_cast<int>(e) });
    }
  }
  for (std::size_t f = 0; f < star.faces.size(); ++f)
  {
    const VertexStar::Face& face = star.faces[f];
    diagonal[f] = face.boundary || context.rules.faces[face.face].planar()
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

/// Turns the edges of a singular node into an affine star: face and block points move with the edges that span them.
void makeAffine(Star& star, const std::vector<Vec3>& slopes)
{
  const std::vector<Vec3> before = star.edgePoints;
  for (std::size_t e = 0; e < star.edges.size(); ++e)
  {
    star.edgePoints[e] = insertMask(star.center, star.center + slopes[e], star.near[e]);
  }
  OrderFreeSum sum;
  const auto moved = [&](const Vec3& point, const auto& edges) {
    sum.clear();
    sum.add(1.0, point);
    for (const int e : edges)
    {
      sum.add(1.0, star.edgePoints[e]);
      sum.add(-1.0, before[e]);
    }
    return sum.result(1.0);
  };
  for (std::size_t f = 0; f < star.faces.size(); ++f)
  {
    star.facePoints[f] = moved(star.facePoints[f], star.faces[f].edges);
  }
  for (std::size_t b = 0; b < star.blocks.size(); ++b)
  {
    star.blockPoints[b] = moved(star.blockPoints[b], star.blocks[b].edges);
  }
}

void writeStar(const ConversionContext& context, const Star& star)
{
  for (std::size_t b = 0; b < star.blocks.size(); ++b)
  {
    const VertexStar::Block& entry = star.blocks[b];
    for (int inserted = 0; inserted < 8; ++inserted)
    {
      // Bit d of `inserted`: one step in along direction d.
      Ijk position;
      for (int d = 0; d < 3; ++d)
      {
        position[d] = context.endPosition(entry.block, d, cornerSide(entry.corner, d), inserted >> d & 1);
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
      context.write(entry.block, position, point, rule);
    }
  }
}

} // namespace

bool convertVertex(const ConversionContext& context, int vertex)
{
  bool singular = false;
  std::vector<Vec3> slopes;
  Star star = makeStar(context, vertex);
  if (star.boundary)
  {
    convertSurface(context, star);
    moveEnd(context, star);
    if (!convertStacked(context, star))
    {
      convertAnchored(context, star);
    }
  }
  else if (!convertRegular(context, star) && !convertStacked(context, star))
  {
    bool keeps = false;
    for (const VertexStar::Edge& edge : star.edges)
    {
      keeps = keeps || context.rules.edges[edge.edge].anchored;
    }
    if (keeps)
    {
      star.rule = ControlPointRule::PlanarSide;
    }
    else
    {
      singular = true;
      star.rule = ControlPointRule::SingularNode;
      SolidLimit limit = solidLimit(star);
      star.center = limit.point;
      slopes = std::move(limit.slopes);
    }
    convertAnchored(context, star);
    const bool keepsFaces = std::find(star.keptFaces.begin(), star.keptFaces.end(), true) != star.keptFaces.end();
    if (!slopes.empty() && !keepsFaces)
    {
      makeAffine(star, slopes);
    }
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

  writeStar(context, star);
  return singular;
}

} // namespace bsv
