// SPDX-License-Identifier: BSD-3-Clause
#include "EntityRules.h"

#include "CreaseColumns.h"

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
  const Index start = block.points.offset(facePoint(cells, use.face, 0, 0));
  const Index alongS = block.points.offset(facePoint(cells, use.face, 1, 0)) - start;
  const Index alongT = block.points.offset(facePoint(cells, use.face, 0, 1)) - start;
  for (int t = 0; t <= cells[faceAxis(use.face, 1)]; ++t)
  {
    for (int s = 0; s <= cells[faceAxis(use.face, 0)]; ++s)
    {
      body(block.points.atOffset(start + s * alongS + t * alongT));
    }
  }
}

struct Plane
{
  Vec3 origin;
  Vec3 normal;
  /// Largest distance of a point, and the diagonal of the points' bounding box.
  double deviation = 0.0;
  double diagonal = 0.0;
};

/// The plane through the centroid of the faces' points with the normal of least variance.
Plane fitPlane(const BlockComplex& complex, const std::vector<int>& faces)
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
  Plane plane;
  plane.diagonal = (high - low).norm();
  const Vec3 middle = 0.5 * (low + high);
  plane.origin.setZero();
  double count = 0.0;
  forAll([&](const Vec3& x) {
    plane.origin += x - middle;
    count += 1.0;
  });
  plane.origin = middle + plane.origin / count;
  Eigen::Matrix3d variance = Eigen::Matrix3d::Zero();
  forAll([&](const Vec3& x) {
    const Vec3 offset = (x - plane.origin) / plane.diagonal;
    variance += offset * offset.transpose();
  });
  plane.normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(variance).eigenvectors().col(0);
  forAll([&](const Vec3& x) {
    plane.deviation = std::max(plane.deviation, std::abs(plane.normal.dot(x - plane.origin)));
  });
  return plane;
}

/// Whether no point of the mesh's boundary lies beyond the plane: the mesh is on one side of it.
bool supportsMesh(const BlockComplex& complex, const Plane& plane, double tolerance)
{
  double below = 0.0, above = 0.0;
  for (std::size_t f = 0; f < complex.faces.size(); ++f)
  {
    if (complex.faces[f].boundary())
    {
      forAllPoints(complex, static_cast<int>(f), [&](const Vec3& x) {
        const double height = plane.normal.dot(x - plane.origin);
        below = std::min(below, height);
        above = std::max(above, height);
      });
      if (-below > tolerance && above > tolerance)
      {
        return false;
      }
    }
  }
  return true;
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

/// Planar side of every face, or -1: the far field.
///
/// A side is all faces that continue each other without a sharp edge; a small piece of a curved boundary may be flat, but
/// is no planar side. A planar side keeps its points only if the whole mesh lies behind it (else it belongs to a body
/// inside) and if it borders on planar sides alone: next to a curved one, whose border is smoothed, kept points would
/// fold thin layers.
std::vector<int> planarBoundaryFaces(
  const BlockComplex& complex, const EntityRules& rules, double tolerance)
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
  for (std::size_t e = 0; e < complex.edges.size(); ++e)
  {
    const std::vector<EdgeFan>& fans = rules.edges[e].fans;
    const EdgeFan& fan = fans.front();
    if (fans.size() != 1 || fan.closed)
    {
      continue;
    }
    const int a = fan.faceOf(complex, 0);
    const int b = fan.faceOf(complex, fan.spokeCount() - 1);
    const bool sameSide = fan.sectors.size() > 1 && !complex.edges[e].crease &&
      rules.faces[a].role == rules.faces[b].role &&
      turningAngle(complex, static_cast<int>(e), fan) <= SideAngle;
    neighbours[a].push_back({ b, sameSide });
    neighbours[b].push_back({ a, sameSide });
  }

  std::vector<int> sideOf(count, -1);
  std::vector<std::vector<int>> sides;
  std::vector<Plane> planes;
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
    planes.push_back(fitPlane(complex, side));
    sides.push_back(std::move(side));
  }

  const auto isPlanar = [&](int side) { return planes[side].deviation <= tolerance * planes[side].diagonal; };
  std::vector<int> planar(count, -1);
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
    if (keeps && supportsMesh(complex, planes[side], tolerance * planes[side].diagonal))
    {
      for (const int face : sides[side])
      {
        planar[face] = static_cast<int>(side);
      }
    }
  }
  return planar;
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
      planar = planar || faces[fan.faceOf(complex, i)].planar();
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

std::size_t keepIndex(const BlockComplex& complex, int block, int face, int s, int t)
{
  const ComplexFace& shared = complex.faces[complex.blocks[block].faces[face]];
  const FaceUse& first = shared.uses.front();
  const ComplexBlock& owner = complex.blocks[block];
  int ns = owner.cells(faceAxis(face, 0));
  if (first.block != block || first.face != face)
  {
    const int orientation = inverseOrientation(shared.orientation);
    const std::array<int, 2> st = mapFacePoint(orientation, s, t, ns, owner.cells(faceAxis(face, 1)));
    s = st[0];
    t = st[1];
    ns = complex.blocks[first.block].cells(faceAxis(first.face, 0));
  }
  return s + std::size_t(ns + 1) * t;
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
    rules.faces[f].role = roleOf(options, complex.faces[f]);
  }
  std::vector<int> planar(complex.faces.size(), -1);
  if (options.planarSides == PlanarSides::FarField)
  {
    planar = planarBoundaryFaces(complex, rules, options.planarTolerance);
  }
  else if (options.planarSides == PlanarSides::All)
  {
    for (int f = 0; f < static_cast<int>(complex.faces.size()); ++f)
    {
      const Plane plane = fitPlane(complex, { f });
      const bool keeps = rules.faces[f].role != BoundaryRole::Body &&
        plane.deviation <= options.planarTolerance * plane.diagonal;
      planar[f] = keeps ? f : -1;
    }
  }
  if (options.planarSides != PlanarSides::None)
  {
    rules.farField = farFieldSides(complex, options);
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
  markCreaseColumns(complex, options.propagationRange, rules);
  return rules;
}

} // namespace bsv
