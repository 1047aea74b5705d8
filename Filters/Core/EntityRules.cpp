// SPDX-License-Identifier: BSD-3-Clause
#include "EntityRules.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <cmath>
#include <limits>

namespace bsv
{
namespace
{

/// Calls body(point) for every mesh point of a face.
template <typename Body>
void forAllPoints(const BlockComplex& complex, int face, const Body& body)
{
  const FaceUse& use = complex.faces[face].uses.front();
  const ComplexBlock& block = complex.blocks[use.block];
  const Ijk cells{ block.cells(0), block.cells(1), block.cells(2) };
  for (int t = 0; t <= cells[faceAxis(use.face, 1)]; ++t)
  {
    for (int s = 0; s <= cells[faceAxis(use.face, 0)]; ++s)
    {
      body(block.points(facePoint(cells, use.face, s, t)));
    }
  }
}

/// Whether all points of the faces lie within `tolerance` bounding-box diagonals of one plane: the plane through the
/// centroid with the normal of least variance.
bool arePlanar(const BlockComplex& complex, const std::vector<int>& faces, double tolerance)
{
  const auto forAll = [&](const auto& body) {
    for (const int face : faces)
    {
      forAllPoints(complex, face, body);
    }
  };
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  forAll([&](const Vec3& x) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  });
  const Vec3 middle = 0.5 * (low + high);
  const double diagonal = (high - low).norm();
  Vec3 mean = Vec3::Zero();
  double count = 0.0;
  forAll([&](const Vec3& x) {
    mean += x - middle;
    count += 1.0;
  });
  mean = middle + mean / count;
  Eigen::Matrix3d variance = Eigen::Matrix3d::Zero();
  forAll([&](const Vec3& x) { variance += (x - mean) / diagonal * ((x - mean) / diagonal).transpose(); });
  const Vec3 normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(variance).eigenvectors().col(0);
  double distance = 0.0;
  forAll([&](const Vec3& x) { distance = std::max(distance, std::abs(normal.dot(x - mean))); });
  return distance <= tolerance * diagonal;
}

/// Angle in degrees by which the outer surface turns at a boundary edge: between the mean normals of the quadrilaterals
/// on its two sides.
double turningAngle(const BlockComplex& complex, int edge, const EdgeFan& fan)
{
  const auto pointAt = [&](int spoke, int k, int step) {
    const auto [sector, which] = fan.spoke(spoke);
    const ComplexBlock& owner = complex.blocks[sector->block];
    return owner.points(sector->point(owner, k, which == 0 ? step : 0, which == 0 ? 0 : step));
  };
  const int last = fan.spokeCount() - 1;
  Vec3 first = Vec3::Zero(), second = Vec3::Zero();
  for (int k = 0; k < complex.edges[edge].cells; ++k)
  {
    const Vec3 origin = pointAt(0, k, 0);
    const Vec3 along = pointAt(0, k + 1, 0) - origin;
    first += (pointAt(0, k, 1) - origin).cross(along).normalized();
    second += along.cross(pointAt(last, k, 1) - origin).normalized();
  }
  return std::atan2(first.cross(second).norm(), first.dot(second)) * 180.0 / std::acos(-1.0);
}

/// Outer boundary faces that are planar sides. A side is all faces that continue each other without a sharp edge: a
/// small piece of a curved boundary may be flat, but is no planar side.
std::vector<bool> planarBoundaryFaces(
  const BlockComplex& complex, const EntityRules& rules, double tolerance)
{
  // Sharper turns separate sides.
  constexpr double SideAngle = 30.0;
  const int count = static_cast<int>(complex.faces.size());
  const auto candidate = [&](int f) {
    return complex.faces[f].boundary() && rules.faces[f].role == BoundaryRole::Other;
  };
  std::vector<std::vector<int>> neighbours(count);
  for (std::size_t e = 0; e < complex.edges.size(); ++e)
  {
    const std::vector<EdgeFan>& fans = rules.edges[e].fans;
    const EdgeFan& fan = fans.front();
    if (fans.size() != 1 || fan.closed || fan.sectors.size() < 2 || complex.edges[e].crease)
    {
      continue;
    }
    const int a = fan.faceOf(complex, 0);
    const int b = fan.faceOf(complex, fan.spokeCount() - 1);
    if (candidate(a) && candidate(b) && turningAngle(complex, static_cast<int>(e), fan) <= SideAngle)
    {
      neighbours[a].push_back(b);
      neighbours[b].push_back(a);
    }
  }
  std::vector<bool> planar(count, false), visited(count, false);
  for (int f = 0; f < count; ++f)
  {
    if (!candidate(f) || visited[f])
    {
      continue;
    }
    std::vector<int> side{ f };
    visited[f] = true;
    for (std::size_t i = 0; i < side.size(); ++i)
    {
      for (const int next : neighbours[side[i]])
      {
        if (!visited[next])
        {
          visited[next] = true;
          side.push_back(next);
        }
      }
    }
    const bool flat = arePlanar(complex, side, tolerance);
    for (const int member : side)
    {
      planar[member] = flat;
    }
  }
  return planar;
}

/// What must not change across a smooth border of two boundary faces.
int smoothClass(const FaceRule& rule)
{
  return 2 * static_cast<int>(rule.role) + (rule.planar ? 1 : 0);
}

EdgeRule edgeRule(
  const BlockComplex& complex, const std::vector<FaceRule>& faces, int edge, std::vector<EdgeFan> fans)
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
      planar = planar || faces[fan.faceOf(complex, i)].planar;
    }
    result.anchored = planar || fan.sectors.size() < 3 || result.fans.size() > 1;
    result.rule = planar ? ControlPointRule::PlanarSide
      : result.anchored  ? ControlPointRule::Corner
      : shared.extraordinary() ? ControlPointRule::ExtraordinaryEdge
                               : ControlPointRule::Regular;
    return result;
  }

  // The two boundary faces, if the surface is a manifold here.
  const bool manifold = result.fans.size() == 1 && !fan.closed;
  const FaceRule& first = faces[fan.faceOf(complex, 0)];
  const FaceRule& last = faces[fan.faceOf(complex, fan.spokeCount() - 1)];
  const bool bothPlanar = manifold && first.planar && last.planar;
  result.feature = !bothPlanar &&
    (!manifold || fan.sectors.size() == 1 || shared.crease || smoothClass(first) != smoothClass(last));
  bool innerPlanar = false;
  for (int i = 1; i + 1 < fan.spokeCount(); ++i)
  {
    innerPlanar = innerPlanar || faces[fan.faceOf(complex, i)].planar;
  }
  result.anchored = result.feature || bothPlanar || innerPlanar;
  if (result.feature)
  {
    result.rule = ControlPointRule::Crease;
  }
  else if (bothPlanar || innerPlanar)
  {
    result.rule = ControlPointRule::PlanarSide;
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
      return rule.planar ? ControlPointRule::PlanarSide : ControlPointRule::Boundary;
  }
}

EntityRules classify(const BlockComplex& complex, const ConversionOptions& options, const Execution& run)
{
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
    const int tag = complex.faces[f].tag;
    if (complex.faces[f].boundary() && tag >= 0 && tag < static_cast<int>(options.roles.size()))
    {
      rules.faces[f].role = options.roles[tag];
    }
  }
  std::vector<bool> planar(complex.faces.size(), false);
  if (options.planarSides == PlanarSides::FarField)
  {
    planar = planarBoundaryFaces(complex, rules, options.planarTolerance);
  }
  else if (options.planarSides == PlanarSides::All)
  {
    for (std::size_t f = 0; f < complex.faces.size(); ++f)
    {
      planar[f] = rules.faces[f].role != BoundaryRole::Body &&
        arePlanar(complex, { static_cast<int>(f) }, options.planarTolerance);
    }
  }
  for (std::size_t f = 0; f < complex.faces.size(); ++f)
  {
    rules.faces[f].planar = planar[f];
    rules.planarFaces += planar[f] ? 1 : 0;
  }
  forEachEdge([&](int e) {
    EdgeRule& rule = rules.edges[e];
    rule = edgeRule(complex, rules.faces, e, std::move(rule.fans));
  });
  return rules;
}

} // namespace bsv
