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

std::vector<std::vector<Vec3>> sectorsOf(const std::vector<std::vector<double>>& lists)
{
  std::vector<std::vector<Vec3>> sectors;
  for (const std::vector<double>& list : lists)
  {
    sectors.push_back(pointsOf(list.data(), PatchSize * PatchSize));
  }
  return sectors;
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

/// The patches before any fit, on all ranks.
std::vector<WallPatch> wallPatches(
  const ConversionContext& context, const NetFans& fans, const std::vector<FanEnd>& vertices, const Ranks& ranks)
{
  std::set<int> fitted;
  for (const FanEnd& at : vertices)
  {
    fitted.insert(fans.vertexOf(at));
  }
  const SectorLists lists = pointsAround(context, fans, vertices, ranks);
  std::vector<WallPatch> patches;
  for (std::size_t i = 0; i < vertices.size(); ++i)
  {
    const std::vector<std::vector<Vec3>> sectors = sectorsOf(lists[i]);
    patches.push_back(
      { PatchSize, fans.all[vertices[i].fan].cells, sectors, sectors, othersNear(fans, vertices[i], fitted) });
  }
  return patches;
}

/// fitVertex() of all patches, each on one rank. @param onlyNear only of those with others near
std::vector<std::vector<double>> fitVertices(
  const BodySurface& body, const std::vector<WallPatch>& patches, bool onlyNear, const Execution& run)
{
  const Ranks& ranks = *run.ranks;
  std::vector<std::vector<double>> changes(patches.size(), { 0.0 });
  const auto rankOf = [&](std::size_t i) { return static_cast<int>(i % ranks.size()); };
  run.parallelFor(static_cast<Index>(patches.size()), 1, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i)
    {
      if (rankOf(i) == ranks.rank() && (!onlyNear || patches[i].isNearOthers()))
      {
        changes[i] = fitVertex(body, patches[i]);
      }
    }
  });
  return gatherListsFromOwners<double>(ranks, patches.size(), rankOf, [&](std::size_t i) { return changes[i]; });
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
  std::vector<WallPatch> patches = wallPatches(context, fans, vertices, *run.ranks);
  const bool anyNear =
    std::any_of(patches.begin(), patches.end(), [](const auto& patch) { return patch.isNearOthers(); });
  std::vector<int> reaches(vertices.size(), 0);
  // Neighbours that are near see what the others did, once.
  for (int sweep = 0; sweep < (anyNear ? 2 : 1); ++sweep)
  {
    if (sweep > 0)
    {
      const SectorLists now = pointsAround(context, fans, vertices, *run.ranks);
      for (std::size_t i = 0; i < patches.size(); ++i)
      {
        patches[i].sectors = sectorsOf(now[i]);
      }
    }
    const auto changes = fitVertices(*context.options.body, patches, sweep > 0, run);
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
