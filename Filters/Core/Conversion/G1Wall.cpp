// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/G1Wall.h"

#include "Body/ClosestPoint.h"
#include "Conversion/G1Fit.h"
#include "Conversion/NetPoints.h"
#include "Conversion/NetShifts.h"
#include "Ranks/OwnedValues.h"

#include <algorithm>
#include <array>
#include <set>

namespace bsv
{
namespace
{

/// Control points per direction that the fit needs: those of four spans.
constexpr int PatchSize = 8;

/// Points of the wall in sector k.
std::vector<double> wallPoints(const ConversionContext& context, const NetFans& fans, const FanEnd& at, int k)
{
  const NetFan& fan = fans.all[at.fan];
  const FanSector& sector = fan.sectors[k];
  const SectorPlaces places(context, sector);
  std::vector<double> list;
  for (int j = 0; j < PatchSize; ++j)
  {
    for (int i = 0; i < PatchSize; ++i)
    {
      const auto x = context.controlPoint(sector.block, places(fan.endLayer(at.end), i, j));
      list.insert(list.end(), x.data(), x.data() + 3);
    }
  }
  return list;
}

std::vector<Vec3> pointsOf(const double* coordinates, int count)
{
  std::vector<Vec3> points;
  for (int a = 0; a < count; ++a)
  {
    points.emplace_back(coordinates + 3 * a);
  }
  return points;
}

/// Per sector whether a vertex that is `fitted` is at the far end of one spoke, of the other, or of both, and near.
std::vector<std::array<bool, 3>> othersNear(const NetFans& fans, const FanEnd& at, const std::set<int>& fitted)
{
  const NetFan& fan = fans.all[at.fan];
  std::vector<std::array<bool, 3>> others(fan.shape.sectors);
  for (int k = 0; k < fan.shape.sectors; ++k)
  {
    const FanSector& sector = fan.sectors[k];
    for (int far = 1; far < 4; ++far)
    {
      const int first = far & 1, second = far >> 1;
      const bool near =
        (first == 0 || fan.cells[k] < PatchSize) && (second == 0 || fan.cells[(k + 1) % fan.spokeCount()] < PatchSize);
      const int corner = sector.corner(at.end) ^ (first << sector.first | second << sector.second);
      others[k][far - 1] = near && fitted.count(fans.complex.blocks[sector.block].vertices[corner]) > 0;
    }
  }
  return others;
}

/// The largest curvature of the body around: at the vertex alone it may be nearly flat.
double curvatureAround(const BodySurface& body, const WallPatch& patch, const Vec3& vertex)
{
  const auto curvatureAt = [&](const Vec3& x) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> curvatures(body.closestPoint(x).geometry.curvature);
    return curvatures.eigenvalues().cwiseAbs().maxCoeff();
  };
  double curvature = curvatureAt(vertex);
  for (const std::vector<Vec3>& sector : patch.sectors)
  {
    for (const int a : { NetReach, NetReach + PatchSize * NetReach })
    {
      curvature = std::max(curvature, curvatureAt(sector[a]));
    }
  }
  return curvature;
}

/// The reach of the fit, 0: none, then the changes of a net of that reach.
std::vector<double> fitVertex(const BodySurface& body, const WallPatch& patch)
{
  std::vector<double> changes{ 0.0 };
  const BodyPoint at = body.closestPoint(patch.sectors[0][0]);
  if (!(at.geometry.normal.norm() > 0.0))
  {
    return changes;
  }
  const std::function<FootPoint(const Vec3&)> closest = [&](const Vec3& x) {
    const BodyPoint found = body.closestPoint(x);
    return FootPoint{ found.geometry.point, found.geometry.normal };
  };
  const G1FitResult fit = fitToBody(
    patch, { patch.sectors[0][0], at.geometry.normal }, curvatureAround(body, patch, at.geometry.point), closest);
  if (fit.reach > 0)
  {
    changes[0] = fit.reach;
    changes.resize(1 + 3 * fit.net.size());
    fit.shape.forPoints([&](int a, int k, int i, int j) {
      Eigen::Map<Vec3>{ changes.data() + 1 + 3 * a } = fit.net[a] - patch.sectors[k][i + PatchSize * j];
    });
  }
  return changes;
}

/// The points of the wall around vertices.
SectorLists pointsAround(
  const ConversionContext& context, const NetFans& fans, const std::vector<FanEnd>& vertices, const Ranks& ranks)
{
  std::vector<int> around;
  for (const FanEnd& at : vertices)
  {
    around.push_back(at.fan);
  }
  return gatherSectors(fans, around, ranks, [&](int i, int k) { return wallPoints(context, fans, vertices[i], k); });
}

/// fitVertex() of vertices, each on one rank. @param again only of those with others near
/// @param before, now points of the wall around them, before any fit and as they are
std::vector<std::vector<double>> fitVertices(const ConversionContext& context, const NetFans& fans,
  const std::vector<FanEnd>& vertices, const SectorLists& before, const SectorLists& now, bool again,
  const Execution& run)
{
  const Ranks& ranks = *run.ranks;
  std::set<int> fitted;
  for (const FanEnd& at : vertices)
  {
    fitted.insert(fans.vertexOf(at));
  }
  std::vector<std::vector<double>> changes(vertices.size(), { 0.0 });
  const auto rankOf = [&](std::size_t i) { return static_cast<int>(i % ranks.size()); };
  run.parallelFor(static_cast<Index>(vertices.size()), 1, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i)
    {
      WallPatch patch{ PatchSize, fans.all[vertices[i].fan].cells, {}, {}, othersNear(fans, vertices[i], fitted) };
      if (rankOf(i) != ranks.rank() || (again && !patch.isNearOthers()))
      {
        continue;
      }
      for (std::size_t k = 0; k < now[i].size(); ++k)
      {
        patch.sectors.push_back(pointsOf(now[i][k].data(), PatchSize * PatchSize));
        patch.unfitted.push_back(pointsOf(before[i][k].data(), PatchSize * PatchSize));
      }
      changes[i] = fitVertex(*context.options.body, patch);
    }
  });
  return gatherListsFromOwners<double>(ranks, vertices.size(), rankOf, [&](std::size_t i) { return changes[i]; });
}

} // namespace

bool fitWall(const ConversionContext& context, const NetFans& fans, const NetLayers& layers, const Execution& run,
  G1Report& report)
{
  std::vector<FanEnd> vertices;
  for (const FanEnd& at : fans.wallVertices)
  {
    // Nets on fewer cells share points.
    const std::vector<int>& cells = fans.all[at.fan].cells;
    if (context.options.body && context.options.twist != Twist::PCCM &&
      *std::min_element(cells.begin(), cells.end()) >= NetReach)
    {
      vertices.push_back(at);
    }
  }
  report.linearVertices = static_cast<Index>(fans.wallVertices.size() - vertices.size());
  if (vertices.empty())
  {
    return false;
  }
  const SectorLists before = pointsAround(context, fans, vertices, *run.ranks);
  std::vector<int> reaches(vertices.size(), 0);
  // Neighbours that are near see what the others did, once.
  for (const bool again : { false, true })
  {
    const SectorLists now = again ? pointsAround(context, fans, vertices, *run.ranks) : before;
    const auto changes = fitVertices(context, fans, vertices, before, now, again, run);
    std::vector<std::vector<NetShift>> shifts;
    for (std::size_t i = 0; i < changes.size(); ++i)
    {
      LocalNetShape shape = fans.all[vertices[i].fan].shape;
      shape.reach = static_cast<int>(changes[i][0]);
      if (shape.reach > 0)
      {
        reaches[i] = shape.reach;
        const std::vector<Vec3> net = pointsOf(changes[i].data() + 1, shape.size());
        shifts.push_back(carriedShifts(context, fans, layers, vertices[i], shape, net));
      }
    }
    applyShifts(context, fans, shifts);
  }
  for (const int reach : reaches)
  {
    ++(reach == 0 ? report.linearVertices : report.fittedVertices);
    report.smallFits += reach == 3 ? 1 : 0;
  }
  return true;
}

} // namespace bsv
