// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/EntityRules.h"

#include "Base/Numbers.h"
#include "Complex/CreaseEdges.h"
#include "Complex/FacePoints.h"
#include "Mesh/BlockSurface.h"
#include "Ranks/OwnedValues.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <cmath>
#include <limits>
#include <type_traits>

namespace bsv
{
namespace
{

/// By how much of the planar tolerance a side must be within it: sums over its points round another way in another
/// numbering, by far less.
constexpr double PlanarMargin = 1e-3;

struct Plane
{
  Vec3 origin;
  Vec3 normal;
  /// Largest distance of a point, and the diagonal of the points' bounding box.
  double deviation = 0.0;
  double diagonal = 0.0;
};

int ownerOfFace(const BlockComplex& complex, int face)
{
  return complex.blocks[complex.faces[face].uses.front().block].rank;
}

/// Per side the plane through the centroid of its faces' points with the normal of least variance.
std::vector<Plane> fitPlanes(
  const BlockComplex& complex, const std::vector<std::vector<int>>& sides, const Ranks& ranks)
{
  struct Part
  {
    int side;
    int face;
  };
  std::vector<Part> parts;
  for (std::size_t side = 0; side < sides.size(); ++side)
  {
    for (const int face : sides[side])
    {
      parts.push_back({ static_cast<int>(side), face });
    }
  }
  // What each face adds, put together in the same order on all ranks: `start` for each point of the face, by
  // add(value, plane, point), and then join(plane, value).
  std::vector<Plane> planes(sides.size());
  const auto reduce = [&](const auto& start, const auto& add, const auto& join) {
    const auto values = gatherFromOwners<std::decay_t<decltype(start)>>(
      ranks, parts.size(), [&](std::size_t i) { return ownerOfFace(complex, parts[i].face); },
      [&](std::size_t i) {
        auto value = start;
        const FaceUse& use = complex.faces[parts[i].face].uses.front();
        forFacePoints(complex, use, [&](const Vec3& x) { add(value, parts[i].side, x); });
        return value;
      });
    for (std::size_t i = 0; i < parts.size(); ++i)
    {
      join(parts[i].side, values[i]);
    }
  };

  struct Bounds
  {
    Triple low, high;
  };
  Bounds nothing;
  nothing.low.fill(std::numeric_limits<double>::infinity());
  nothing.high.fill(-std::numeric_limits<double>::infinity());
  const auto extend = [](Bounds& bounds, const auto& low, const auto& high) {
    Eigen::Map<Vec3> least(bounds.low.data()), most(bounds.high.data());
    least = least.cwiseMin(low);
    most = most.cwiseMax(high);
  };
  std::vector<Bounds> bounds(sides.size(), nothing);
  reduce(
    nothing, [&](Bounds& part, int, const Vec3& x) { extend(part, x, x); },
    [&](int side, const Bounds& part) { extend(bounds[side], vec3(part.low), vec3(part.high)); });

  struct Sum
  {
    Triple offset{ 0.0, 0.0, 0.0 };
    double count = 0.0;
  };
  std::vector<Sum> sums(sides.size());
  std::vector<Vec3> middles;
  for (const Bounds& box : bounds)
  {
    middles.push_back(0.5 * (vec3(box.low) + vec3(box.high)));
  }
  const auto enlargeSum = [](Sum& sum, const Vec3& offset, double count) {
    Eigen::Map<Vec3>(sum.offset.data()) += offset;
    sum.count += count;
  };
  reduce(
    Sum{}, [&](Sum& part, int side, const Vec3& x) { enlargeSum(part, x - middles[side], 1.0); },
    [&](int side, const Sum& part) { enlargeSum(sums[side], vec3(part.offset), part.count); });
  for (std::size_t side = 0; side < sides.size(); ++side)
  {
    planes[side].diagonal = (vec3(bounds[side].high) - vec3(bounds[side].low)).norm();
    planes[side].origin = middles[side] + vec3(sums[side].offset) / sums[side].count;
  }

  using Numbers9 = std::array<double, 9>;
  std::vector<Eigen::Matrix3d> variances(sides.size(), Eigen::Matrix3d::Zero());
  reduce(
    Numbers9{},
    [&](Numbers9& sum, int side, const Vec3& x) {
      const Vec3 offset = (x - planes[side].origin) / planes[side].diagonal;
      Eigen::Map<Eigen::Matrix3d>(sum.data()) += offset * offset.transpose();
    },
    [&](int side, const Numbers9& part) { variances[side] += Eigen::Map<const Eigen::Matrix3d>(part.data()); });
  for (std::size_t side = 0; side < sides.size(); ++side)
  {
    planes[side].normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(variances[side]).eigenvectors().col(0);
  }

  const auto enlarge = [](double& deviation, double other) { deviation = std::max(deviation, other); };
  reduce(
    0.0,
    [&](double& deviation, int side, const Vec3& x) {
      enlarge(deviation, std::abs(planes[side].normal.dot(x - planes[side].origin)));
    },
    [&](int side, double deviation) { enlarge(planes[side].deviation, deviation); });
  return planes;
}

/// Per plane, whether no point of the mesh's boundary lies beyond it: the mesh is on one side of it.
std::vector<bool> supportMesh(const BlockComplex& complex, const std::vector<Plane>& planes,
  const std::vector<double>& tolerances, const Ranks& ranks)
{
  std::vector<std::array<double, 2>> heights(planes.size(), { 0.0, 0.0 });
  const auto crosses = [&](std::size_t i) { return -heights[i][0] > tolerances[i] && heights[i][1] > tolerances[i]; };
  for (std::size_t i = 0; i < planes.size(); ++i)
  {
    for (int f = 0; f < static_cast<int>(complex.faces.size()) && !crosses(i); ++f)
    {
      if (complex.faces[f].boundary() && ownerOfFace(complex, f) == ranks.rank())
      {
        forFacePoints(complex, complex.faces[f].uses.front(), [&](const Vec3& x) {
          const double height = planes[i].normal.dot(x - planes[i].origin);
          heights[i] = { std::min(heights[i][0], height), std::max(heights[i][1], height) };
        });
      }
    }
  }
  for (const auto& others : ranks.gather(heights))
  {
    for (std::size_t i = 0; i < planes.size(); ++i)
    {
      heights[i] = { std::min(heights[i][0], others[i][0]), std::max(heights[i][1], others[i][1]) };
    }
  }
  std::vector<bool> result;
  for (std::size_t i = 0; i < planes.size(); ++i)
  {
    result.push_back(!crosses(i));
  }
  return result;
}

/// Per edge the angle in degrees by which the outer surface turns there: between the mean normals of the quadrilaterals
/// on its two sides. Each side has its own block.
std::vector<double> turningAngles(
  const BlockComplex& complex, const EntityRules& rules, const std::vector<int>& edges, const Ranks& ranks)
{
  const auto sectorOf = [&](std::size_t i) -> const FanSector& {
    const std::vector<FanSector>& sectors = rules.edges[edges[i / 2]].fans.front().sectors;
    return i % 2 == 0 ? sectors.front() : sectors.back();
  };
  const std::vector<Triple> normals = gatherFromOwners<Triple>(
    ranks, 2 * edges.size(), [&](std::size_t i) { return complex.blocks[sectorOf(i).block].rank; },
    [&](std::size_t i) {
      const FanSector& sector = sectorOf(i);
      const ComplexBlock& owner = complex.blocks[sector.block];
      Vec3 normal = Vec3::Zero();
      for (int k = 0; k < complex.edges[edges[i / 2]].cells; ++k)
      {
        const Vec3 origin = owner.points(sector.point(owner, k, 0, 0));
        const Vec3 along = owner.points(sector.point(owner, k + 1, 0, 0)) - origin;
        const Vec3 across = owner.points(sector.point(owner, k, i % 2 == 0 ? 1 : 0, i % 2)) - origin;
        normal += (i % 2 == 0 ? across.cross(along) : along.cross(across)).normalized();
      }
      return triple(normal);
    });
  std::vector<double> angles;
  for (std::size_t i = 0; i < edges.size(); ++i)
  {
    angles.push_back(angleBetween(vec3(normals[2 * i]), vec3(normals[2 * i + 1])) * DegreesPerRadian);
  }
  return angles;
}

/// Planar side of every face, or -1: the far field.
///
/// A side is all faces that continue each other without a sharp edge; a small piece of a curved boundary may be flat,
/// but is no planar side. A planar side keeps its points only if the whole mesh lies behind it (else it belongs to a
/// body inside) and if it borders on planar sides alone: next to a curved one, whose border is smoothed, kept points
/// would fold thin layers.
std::vector<int> planarBoundaryFaces(
  const BlockComplex& complex, EntityRules& rules, double tolerance, const Ranks& ranks)
{
  // Sharper turns, in degrees, separate sides.
  constexpr double SideAngle = 30.0;
  const int count = static_cast<int>(complex.faces.size());
  struct Neighbour
  {
    int face;
    bool sameSide;
  };
  std::vector<std::vector<Neighbour>> neighbours(count);
  std::vector<int> joins;
  const auto facesAt = [&](int edge) {
    const EdgeFan& fan = rules.edges[edge].fans.front();
    return std::array<int, 2>{ fan.faceOf(complex, 0), fan.faceOf(complex, fan.spokeCount() - 1) };
  };
  for (int e = 0; e < static_cast<int>(complex.edges.size()); ++e)
  {
    const std::vector<EdgeFan>& fans = rules.edges[e].fans;
    if (fans.size() != 1 || fans.front().closed)
    {
      continue;
    }
    const auto [a, b] = facesAt(e);
    if (fans.front().sectors.size() > 1 && !complex.edges[e].crease && rules.faces[a].role == rules.faces[b].role)
    {
      joins.push_back(e);
    }
    else
    {
      neighbours[a].push_back({ b, false });
      neighbours[b].push_back({ a, false });
    }
  }
  const std::vector<double> angles = turningAngles(complex, rules, joins, ranks);
  std::size_t atLimit = 0;
  for (std::size_t i = 0; i < joins.size(); ++i)
  {
    const auto [a, b] = facesAt(joins[i]);
    const bool sameSide = angles[i] <= SideAngle + CreaseAngleMargin;
    neighbours[a].push_back({ b, sameSide });
    neighbours[b].push_back({ a, sameSide });
    atLimit += std::abs(angles[i] - SideAngle) <= CreaseAngleMargin ? 1 : 0;
  }
  if (atLimit > 0)
  {
    rules.notes.push_back(std::to_string(atLimit) +
      (atLimit == 1 ? " edge between outer faces turns by " : " edges between outer faces turn by ") + text(SideAngle) +
      " degrees, the limit between sides, to " + text(CreaseAngleMargin) + ": taken as within one side.");
  }

  std::vector<int> sideOf(count, -1);
  std::vector<std::vector<int>> sides;
  for (int f = 0; f < count; ++f)
  {
    if (!complex.faces[f].boundary() || sideOf[f] >= 0)
    {
      continue;
    }
    const int number = static_cast<int>(sides.size());
    std::vector<int> side{ f };
    sideOf[f] = number;
    for (std::size_t i = 0; i < side.size(); ++i)
    {
      for (const Neighbour& next : neighbours[side[i]])
      {
        if (next.sameSide && sideOf[next.face] < 0)
        {
          sideOf[next.face] = number;
          side.push_back(next.face);
        }
      }
    }
    sides.push_back(std::move(side));
  }
  const std::vector<Plane> planes = fitPlanes(complex, sides, ranks);

  // The sides that keep their points if planes are that thick, in diagonals.
  const auto keptSides = [&](double thickness) {
    const auto isPlanar = [&](int side) { return planes[side].deviation <= thickness * planes[side].diagonal; };
    std::vector<int> candidates;
    std::vector<Plane> candidatePlanes;
    std::vector<double> tolerances;
    for (std::size_t side = 0; side < sides.size(); ++side)
    {
      bool keeps = rules.faces[sides[side].front()].role == BoundaryRole::Other && isPlanar(static_cast<int>(side));
      for (const int face : sides[side])
      {
        for (const Neighbour& next : neighbours[face])
        {
          keeps = keeps && rules.faces[next.face].role != BoundaryRole::Body && isPlanar(sideOf[next.face]);
        }
      }
      if (keeps)
      {
        candidates.push_back(static_cast<int>(side));
        candidatePlanes.push_back(planes[side]);
        tolerances.push_back(thickness * planes[side].diagonal);
      }
    }
    const std::vector<bool> support = supportMesh(complex, candidatePlanes, tolerances, ranks);
    std::vector<char> kept(sides.size(), 0);
    for (std::size_t i = 0; i < candidates.size(); ++i)
    {
      kept[candidates[i]] = support[i] ? 1 : 0;
    }
    return kept;
  };
  const std::vector<char> kept = keptSides(tolerance * (1.0 - PlanarMargin));
  rules.notePlanarLimit(kept, keptSides(tolerance * (1.0 + PlanarMargin)), tolerance);
  std::vector<int> planar(count, -1);
  for (std::size_t side = 0; side < sides.size(); ++side)
  {
    for (const int face : sides[side])
    {
      planar[face] = kept[side] ? static_cast<int>(side) : -1;
    }
  }
  return planar;
}

EdgeRule edgeRule(const BlockComplex& complex, const std::vector<FaceRule>& faces, int edge, std::vector<EdgeFan> fans)
{
  EdgeRule result;
  result.fans = std::move(fans);
  const ComplexEdge& shared = complex.edges[edge];
  const EdgeFan& fan = result.fans.front();
  if (!shared.boundary)
  {
    bool planar = false;
    for (int i = 0; i < fan.spokeCount(); ++i)
    {
      planar = planar || faces[fan.faceOf(complex, i)].planar();
    }
    result.anchored = planar || fan.sectors.size() < 3 || result.fans.size() > 1;
    result.rule = planar       ? ControlPointRule::PlanarSide
      : result.anchored        ? ControlPointRule::Corner
      : shared.extraordinary() ? ControlPointRule::ExtraordinaryEdge
                               : ControlPointRule::Regular;
    return result;
  }

  // The two boundary faces, if the surface is a manifold here.
  const bool manifold = result.fans.size() == 1 && !fan.closed;
  const FaceRule& first = faces[fan.faceOf(complex, 0)];
  const FaceRule& last = faces[fan.faceOf(complex, fan.spokeCount() - 1)];
  result.feature = !manifold || fan.sectors.size() == 1 || shared.crease || first.role != last.role ||
    first.planarSide != last.planarSide;
  bool innerPlanar = false;
  for (int i = 1; i + 1 < fan.spokeCount(); ++i)
  {
    innerPlanar = innerPlanar || faces[fan.faceOf(complex, i)].planar();
  }
  const bool planar = (first.planar() && last.planar()) || innerPlanar;
  result.anchored = result.feature || planar;
  if (planar)
  {
    result.rule = ControlPointRule::PlanarSide;
  }
  else if (result.feature)
  {
    result.rule = ControlPointRule::Crease;
  }
  else if (fan.sectors.size() != 2)
  {
    result.rule = ControlPointRule::ExtraordinaryEdge;
  }
  else
  {
    result.rule = first.role == BoundaryRole::Body ? ControlPointRule::Body
      : first.role == BoundaryRole::Symmetry       ? ControlPointRule::Symmetry
                                                   : ControlPointRule::Boundary;
  }
  return result;
}

} // namespace

void EntityRules::notePlanarLimit(const std::vector<char>& kept, const std::vector<char>& thicker, double tolerance)
{
  Index count = 0;
  for (std::size_t i = 0; i < kept.size(); ++i)
  {
    count += kept[i] != thicker[i] ? 1 : 0;
  }
  if (count > 0)
  {
    this->notes.push_back(std::to_string(count) +
      (count == 1 ? " block side differs from a plane by " : " block sides differ from a plane by ") + text(tolerance) +
      " of the diagonal, Planar Tolerance, to a thousandth of that: taken as curved.");
  }
}

ControlPointRule EntityRules::boundaryRule(int face) const
{
  const FaceRule& rule = this->faces[face];
  switch (rule.role)
  {
    case BoundaryRole::Body:
      return ControlPointRule::Body;
    case BoundaryRole::Symmetry:
      return ControlPointRule::Symmetry;
    default:
      return rule.planar() ? ControlPointRule::PlanarSide : ControlPointRule::Boundary;
  }
}

EntityRules classify(const BlockComplex& complex, const ConversionOptions& options, const Execution& run)
{
  return classify(LocalStars(complex, *run.ranks), options, run);
}

EntityRules classify(const LocalStars& stars, const ConversionOptions& options, const Execution& run)
{
  const BlockComplex& complex = stars.complex();
  EntityRules rules;
  rules.faces.resize(complex.faces.size());
  rules.edges.resize(complex.edges.size());
  const auto forEachEdge = [&](const auto& body) {
    run.parallelFor(static_cast<Index>(complex.edges.size()), 16, [&](Index begin, Index end) {
      for (Index e = begin; e < end; ++e)
      {
        body(static_cast<int>(e));
      }
    });
  };
  forEachEdge([&](int e) { rules.edges[e].fans = edgeFans(complex, e); });
  for (std::size_t f = 0; f < complex.faces.size(); ++f)
  {
    rules.faces[f].role = roleOf(options, complex.faces[f]);
  }
  std::vector<int> planar(complex.faces.size(), -1);
  if (options.planarSides == PlanarSides::FarField)
  {
    planar = planarBoundaryFaces(complex, rules, options.planarTolerance, *run.ranks);
  }
  else if (options.planarSides == PlanarSides::All)
  {
    std::vector<std::vector<int>> sides;
    for (int f = 0; f < static_cast<int>(complex.faces.size()); ++f)
    {
      sides.push_back({ f });
    }
    const std::vector<Plane> planes = fitPlanes(complex, sides, *run.ranks);
    const auto keptFaces = [&](double thickness) {
      std::vector<char> kept;
      for (std::size_t f = 0; f < planes.size(); ++f)
      {
        kept.push_back(
          rules.faces[f].role != BoundaryRole::Body && planes[f].deviation <= thickness * planes[f].diagonal);
      }
      return kept;
    };
    const std::vector<char> kept = keptFaces(options.planarTolerance * (1.0 - PlanarMargin));
    rules.notePlanarLimit(kept, keptFaces(options.planarTolerance * (1.0 + PlanarMargin)), options.planarTolerance);
    for (std::size_t f = 0; f < planes.size(); ++f)
    {
      planar[f] = kept[f] ? static_cast<int>(f) : -1;
    }
  }
  if (options.planarSides != PlanarSides::None)
  {
    const auto found = [&](double factor) {
      ConversionOptions changed = options;
      changed.planarTolerance *= factor;
      return farFieldSides(complex, changed, run);
    };
    rules.farField = found(1.0 - PlanarMargin);
    const auto marked = [&](const std::vector<FarFieldSide>& sides) {
      std::vector<char> faces(complex.faces.size(), 0);
      for (const FarFieldSide& side : sides)
      {
        for (const int face : side.faces)
        {
          faces[face] = 1;
        }
      }
      return faces;
    };
    rules.notePlanarLimit(marked(rules.farField), marked(found(1.0 + PlanarMargin)), options.planarTolerance);
  }
  for (const FarFieldSide& side : rules.farField)
  {
    for (const int face : side.faces)
    {
      rules.faces[face].connection = true;
      planar[face] = face;
    }
  }
  for (std::size_t f = 0; f < complex.faces.size(); ++f)
  {
    rules.faces[f].planarSide = planar[f];
    rules.planarFaces += planar[f] >= 0 ? 1 : 0;
  }
  forEachEdge([&](int e) {
    EdgeRule& rule = rules.edges[e];
    rule = edgeRule(complex, rules.faces, e, std::move(rule.fans));
  });
  return rules;
}

} // namespace bsv
