// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/SurfaceConversion.h"

#include "Base/CanonicalOrder.h"
#include "Base/Numbers.h"
#include "Body/ClosestPoint.h"
#include "Conversion/EdgeConversion.h"
#include "Ranks/OwnedValues.h"

#include <algorithm>
#include <limits>
#include <set>

namespace bsv
{

namespace
{

/// x_uv / |x_uv| of the body at a point; 0 where x_uv is nothing but rounding, whatever the scale of the parameters.
Vec3 mixedDirection(const BodySurface& body, const BodyPoint& at)
{
  constexpr double Rounding = 1e-10;
  const SurfaceDerivatives x = evaluate(body.patches()[at.patch].surface, at.u, at.v);
  const double length = x.uv.norm();
  return length * body.size() > Rounding * x.u.norm() * x.v.norm() ? Vec3(x.uv / length) : Vec3(Vec3::Zero());
}

bool bodyFoot(const ConversionContext& context, const Star& star, const Fan& fan, BodyFoot& foot)
{
  const auto givenAt = [&](const std::map<int, Vec3>& given, Vec3& value) {
    const auto found = given.find(star.vertex);
    value = found == given.end() ? value : found->second;
    return found != given.end();
  };
  const bool hasPoint = givenAt(context.given.points, foot.point);
  const bool hasNormal = givenAt(context.given.normals, foot.normal) && foot.normal.norm() > 0.0;
  if (!hasPoint && !hasNormal && !context.options.body)
  {
    return false;
  }
  const Vec3 limit = smoothFan(fan, context.options.twist, std::vector<double>(fan.spokeCount(), KnotInsertion)).center;
  if (context.options.body && !hasPoint && !hasNormal)
  {
    const BodyPoint closest = context.options.body->closestPoint(limit);
    const SurfaceGeometry& geometry = closest.geometry;
    foot = { geometry.point, geometry.normal, geometry.curvature, true, Vec3::Zero() };
    if (context.options.twist == Twist::Literal)
    {
      foot.mixedDirection = mixedDirection(*context.options.body, closest);
    }
    return geometry.normal.norm() > 0.0;
  }
  if (!hasPoint)
  {
    foot.point = limit;
  }
  foot.normal = hasNormal ? Vec3(foot.normal.normalized()) : limitNormal(fan);
  return true;
}

/// The closest point to the centre of `points` on the body's patch whose normal is nearest to that of `size` sectors of
/// `points` from `first` on.
bool sectorFoot(const ConversionContext& context, const Fan& points, int first, int size, BodyFoot& foot)
{
  if (!context.options.body)
  {
    return false;
  }
  const int n = points.sectorCount();
  Vec3 normal = Vec3::Zero();
  double length = 0.0;
  for (int i = 0; i < size; ++i)
  {
    const Vec3 a = points.spokes[(first + i) % n] - points.center;
    const Vec3 b = points.spokes[(first + i + 1) % n] - points.center;
    normal += a.cross(b);
    length = std::max({ length, a.norm(), b.norm() });
  }
  // Patches that meet at the crease; a crease that no edge of the body explains has one foot for both sides.
  double best = 0.0;
  for (const BodyPoint& point : context.options.body->closestPointPerPatch(points.center, 1e-3 * length))
  {
    // Of equals the first: rounding must not decide.
    const double fits = std::abs(point.geometry.normal.dot(normal)) / normal.norm();
    if (fits > best + 1e-9)
    {
      best = fits;
      const SurfaceGeometry& geometry = point.geometry;
      foot = { geometry.point, geometry.normal, geometry.curvature, true, Vec3::Zero() };
      if (context.options.twist == Twist::Literal)
      {
        foot.mixedDirection = mixedDirection(*context.options.body, point);
      }
    }
  }
  return best > 0.0;
}

/// Smooth fan; on the body with the closest point and normal of an extraordinary vertex, if they are known.
Fan smoothSurfaceFan(const ConversionContext& context, Star& star, const Fan& fan, const std::vector<double>& weights,
  const std::vector<SpokeKeep>& keeps, bool body)
{
  BodyFoot foot{ Vec3::Zero(), Vec3::Zero() };
  // The patches of others keep the limit point.
  const bool keepsLimit = context.options.twist == Twist::ACC || context.options.twist == Twist::PCCM;
  star.hasFoot = body && !keepsLimit && fan.sectorCount() != 4 && bodyFoot(context, star, fan, foot);
  foot.regularOffsets = context.options.continuity == Continuity::ExactG1;
  return star.hasFoot ? projectedFan(fan, foot, context.options.twist)
                      : fadedFan(fan, context.options.twist, weights, keeps);
}

void convertTouchingSurfaces(Star& star)
{
  // Surfaces touch at a point or along an edge: nothing is smooth here.
  star.rule = ControlPointRule::Corner;
  for (std::size_t e = 0; e < star.edges.size(); ++e)
  {
    if (star.edges[e].boundary)
    {
      star.edgePoints[e] = insertMask(star.center, star.edges[e].point, star.near[e]);
      star.edgeRules[e] = ControlPointRule::Corner;
    }
  }
  for (std::size_t f = 0; f < star.faces.size(); ++f)
  {
    if (!star.faces[f].boundary)
    {
      continue;
    }
    const auto& ends = star.faces[f].edges;
    const Vec3 corners[4] = { star.center, star.edges[ends[0]].point, star.edges[ends[1]].point, star.faces[f].point };
    const double weights[2] = { star.near[ends[0]], star.near[ends[1]] };
    star.facePoints[f] = multilinear(corners, weights, 2);
    star.faceRules[f] = ControlPointRule::Corner;
  }
}

} // namespace

void convertSurface(const ConversionContext& context, Star& star)
{
  const auto [spokes, sectors] = boundaryRing(star);
  if (sectors.empty())
  {
    convertTouchingSurfaces(star);
    return;
  }
  const int n = static_cast<int>(spokes.size());
  Fan fan;
  fan.center = star.point;
  std::vector<double> weights;
  std::vector<int> features;
  std::vector<bool> kept, planar;
  std::vector<SpokeKeep> keeps;
  bool body = true, wall = false, convexEdge = false;
  for (int i = 0; i < n; ++i)
  {
    fan.spokes.push_back(star.edges[spokes[i]].point);
    fan.sectors.push_back(star.faces[sectors[i]].point);
    weights.push_back(star.near[spokes[i]]);
    const VertexStar::Edge& edge = star.edges[spokes[i]];
    const EdgeRule& edgeRule = context.rules.edges[edge.edge];
    if (edgeRule.feature)
    {
      features.push_back(i);
      convexEdge = convexEdge || edgeRule.oneBlock();
    }
    kept.push_back(edgeRule.anchored);
    planar.push_back(context.rules.faces[star.faces[sectors[i]].face].planar());
    // A face that rises from a crease and ends in this surface.
    keeps.emplace_back();
    const EdgeFan& edgeFan = edgeRule.fans.front();
    if (edgeRule.fans.size() == 1 && edgeFan.sectors.size() == 2)
    {
      const int cells = context.complex.edges[edge.edge].cells;
      keeps.back().center = spokeKeeps(context, edgeFan, edge.end == 0 ? 0 : cells)[1].center;
      keeps.back().step = spokeKeeps(context, edgeFan, edge.end == 0 ? 1 : cells - 1)[1].center;
    }
    body = body && context.isWall(star.faces[sectors[i]].face);
    wall = wall || context.isWall(star.faces[sectors[i]].face);
  }

  // Where the side of a far-field extension ends in a symmetry plane or another boundary, it keeps its points.
  Fan result = fan;
  if ((star.connection && !wall) || planar == std::vector<bool>(n, true))
  {
    star.rule = ControlPointRule::PlanarSide;
    result = creasedFan(fan, {}, kept, planar, context.options.twist, weights, keeps).points;
  }
  else if (n >= 3 && (features.empty() || (features.size() == 1 && !convexEdge)))
  {
    // No feature, or a crease that ends here (a dart): smooth. Where the edge of a single block ends, its three edges
    // would lie in one plane: a corner.
    star.surfaceIsSmooth = features.empty();
    result = smoothSurfaceFan(context, star, fan, weights, keeps, body);
    star.rule = n == 4 ? context.rules.boundaryRule(star.faces[sectors[0]].face)
      : body           ? ControlPointRule::BodyExtraordinaryVertex
                       : ControlPointRule::Boundary;
  }
  else
  {
    const CreasedFan creased = creasedFan(fan, features, kept, planar, context.options.twist, weights, keeps);
    result = creased.points;
    star.rule = creased.crease ? ControlPointRule::Crease : ControlPointRule::Corner;
    if (creased.crease)
    {
      star.crease = { spokes[features[0]], spokes[features[1]] };
      for (int c = 0; c < 2; ++c)
      {
        // Groups of two sectors are regular: there the rule is exact.
        const int size = (features[1 - c] - features[c] + n) % n;
        const bool anyPlanar = std::find(planar.begin(), planar.end(), true) != planar.end();
        BodyFoot foot;
        if (body && !anyPlanar && size > 2 && sectorFoot(context, result, features[c], size, foot))
        {
          projectGroup(result, fan, features[c], size, foot, context.options.twist);
          star.hasFoot = true;
        }
      }
    }
  }
  const bool crease = star.rule == ControlPointRule::Crease;
  const auto isFeature = [&](int i) { return std::find(features.begin(), features.end(), i) != features.end(); };
  std::vector<ControlPointRule> spokeRules(n, star.rule), sectorRules(n, star.rule);
  for (int i = 0; i < n; ++i)
  {
    if (planar[i])
    {
      sectorRules[i] = ControlPointRule::PlanarSide;
    }
    else if (crease)
    {
      sectorRules[i] = context.rules.boundaryRule(star.faces[sectors[i]].face);
    }
    if (!isFeature(i) && crease)
    {
      spokeRules[i] = sectorRules[i];
    }
    if (keeps[i].any() && features.empty())
    {
      spokeRules[i] = star.rule = ControlPointRule::Crease;
    }
  }
  std::vector<bool> keptSpokes;
  for (const SpokeKeep& keep : keeps)
  {
    keptSpokes.push_back(features.empty() && keep.any());
  }
  if (keptLinesMeet(true, keptSpokes))
  {
    spokeRules.assign(n, ControlPointRule::Crease);
    sectorRules.assign(n, ControlPointRule::Crease);
  }

  star.center = result.center;
  for (int i = 0; i < n; ++i)
  {
    star.edgePoints[spokes[i]] = result.spokes[i];
    star.edgeRules[spokes[i]] = spokeRules[i];
    star.facePoints[sectors[i]] = result.sectors[i];
    star.faceRules[sectors[i]] = sectorRules[i];
  }
}

GivenFeet givenFeet(const BlockComplex& complex, const ConversionOptions& options, const Ranks& ranks)
{
  GivenFeet given;
  const auto isGiven = [&](const std::vector<const double*>& arrays) {
    return ranks.any(std::any_of(arrays.begin(), arrays.end(), [](const double* array) { return array != nullptr; }));
  };
  const bool points = isGiven(options.projectedPoints);
  const bool normals = isGiven(options.surfaceNormals);
  if (!points && !normals)
  {
    return given;
  }
  std::set<int> vertices;
  for (std::size_t face = 0; face < complex.faces.size(); ++face)
  {
    if (roleOf(options, complex.faces[face]) == BoundaryRole::Body)
    {
      const FaceUse& use = complex.faces[face].uses.front();
      for (int corner = 0; corner < 4; ++corner)
      {
        vertices.insert(complex.blocks[use.block].vertices[faceCorner(use.face, corner & 1, corner >> 1)]);
      }
    }
  }
  struct Copy
  {
    int vertex;
    CornerUse corner;
  };
  std::vector<Copy> copies;
  for (const int vertex : vertices)
  {
    for (const CornerUse& corner : complex.vertices[vertex].corners)
    {
      copies.push_back({ vertex, corner });
    }
  }
  const auto collect = [&](const std::vector<const double*>& arrays, std::map<int, Vec3>& result) {
    const auto values = gatherFromOwners<Triple>(
      ranks, copies.size(), [&](std::size_t i) { return complex.blocks[copies[i].corner.block].rank; },
      [&](std::size_t i) {
        const ComplexBlock& owner = complex.blocks[copies[i].corner.block];
        const double* array = owner.parent < static_cast<int>(arrays.size()) ? arrays[owner.parent] : nullptr;
        if (!array)
        {
          constexpr double NaN = std::numeric_limits<double>::quiet_NaN();
          return Triple{ NaN, NaN, NaN };
        }
        // Strides of the parent's points are those of its arrays.
        Index at = 0;
        for (int d = 0; d < 3; ++d)
        {
          at +=
            owner.points.stride(d) * (owner.offset[d] + (cornerSide(copies[i].corner.corner, d) ? owner.cells(d) : 0));
        }
        return Triple{ array[3 * at], array[3 * at + 1], array[3 * at + 2] };
      });
    for (std::size_t i = 0; i < copies.size(); ++i)
    {
      // Copies may differ in the blocks: the smallest is as good as any and is the same in every order.
      const Vec3 given(values[i].data());
      const auto found = result.find(copies[i].vertex);
      if (given.allFinite() && (found == result.end() || comesBefore(given, found->second)))
      {
        result[copies[i].vertex] = given;
      }
    }
  };
  if (points)
  {
    collect(options.projectedPoints, given.points);
  }
  if (normals)
  {
    collect(options.surfaceNormals, given.normals);
  }
  return given;
}

} // namespace bsv
