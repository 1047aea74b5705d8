// SPDX-License-Identifier: BSD-3-Clause
#include "Wall/BodyFit.h"

#include "Base/CanonicalOrder.h"
#include "Base/Numbers.h"
#include "Body/BodyEdges.h"
#include "Mesh/BlockSurface.h"
#include "Ranks/OwnedValues.h"
#include "Wall/Displacements.h"
#include "Wall/LimitRows.h"
#include "Wall/WallPoints.h"
#include "Wall/WallSamples.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

namespace bsv
{

WallDistances wallDistances(
  const BlockComplex& complex, const EntityRules& rules, const BodySurface& body, const Execution& run)
{
  const Wall wall(complex, rules);
  WallDistances result;
  result.wallPoints = wall.size();
  if (wall.size() == 0)
  {
    return result;
  }
  const LimitRows rows(complex, rules, wall);
  const std::vector<Vec3> points = wall.points(*run.ranks);
  Eigen::AlignedBox3d box;
  for (const Vec3& point : points)
  {
    box.extend(point);
  }
  using Distances = std::array<double, 2>;
  const std::vector<Distances> distances = sharedOut<Distances>(wall.size(), 64, run, [&](Index i) {
    return Distances{ body.closestPoint(points[i]).distance, body.closestPoint(rows.apply(i, points)).distance };
  });
  for (const Distances& distance : distances)
  {
    result.inputPoints = std::max(result.inputPoints, distance[0]);
    result.limitPoints = std::max(result.limitPoints, distance[1]);
  }
  const double size = box.diagonal().norm();
  // In a unit that is some times as large, the body may still be near enough to be taken.
  const bool isFar = !(result.inputPoints <= 0.2 * size);
  if (isFar || result.inputPoints > 0.05 * size)
  {
    const auto boxText = [](const Eigen::AlignedBox3d& b) {
      std::ostringstream text;
      text << '[' << b.min().transpose() << "] to [" << b.max().transpose() << ']';
      return text.str();
    };
    std::ostringstream text;
    text << "the body is far from the wall, up to " << result.inputPoints << ": the wall lies in " << boxText(box)
         << ", the body in " << boxText(body.bounds());
    constexpr double Near = 0.05;
    // Of some of the points, as a fraction of the size; more than Near may be less than it is.
    const auto farthest = [&](const auto& map, double factor) {
      const Index step = 1 + static_cast<Index>(points.size()) / 100;
      double most = 0.0;
      for (Index i = 0; i < static_cast<Index>(points.size()) && most <= Near; i += step)
      {
        const double distance = body.closestPoint(map(points[i])).distance / (factor * size);
        most = distance <= Near ? std::max(most, distance) : std::numeric_limits<double>::infinity();
      }
      return most;
    };
    const auto liesOn = [&](const auto& map) { return farthest(map, 1.0) <= Near; };
    // Units that CAD files and meshes come in, as powers of their ratio.
    const double ratio = body.size() / size;
    double best = Near, bestFactor = 0.0;
    for (const double unit : { 1000.0, 100.0, 10.0, 25.4, 2.54, 12.0, 39.37, 3.2808 })
    {
      for (const double factor : { unit, 1.0 / unit })
      {
        // A mesh of half a body, or of a part of it, is smaller than the body. In the right unit its wall lies on it.
        const double distance = ratio > 0.7 * factor && ratio < 3.0 * factor
          ? farthest([factor](const Vec3& x) { return Vec3(factor * x); }, factor)
          : std::numeric_limits<double>::infinity();
        if (distance < best)
        {
          best = distance;
          bestFactor = factor;
        }
      }
    }
    if (bestFactor > 0.0)
    {
      text << "; the body is about " << bestFactor
           << " times as large: is its unit another one? Length Unit of its reader converts it";
      throw Error(text.str());
    }
    if (!isFar)
    {
      return result;
    }
    // The other half of a model, or a program with left-handed axes.
    for (int d = 0; d < 3; ++d)
    {
      const auto image = [d](Vec3 x) {
        x[d] = -x[d];
        return x;
      };
      if (liesOn(image))
      {
        text << "; the mirror image of the wall at "
             << "xyz"[d] << " = 0 lies on it: is one of them mirrored, or the other half?";
        throw Error(text.str());
      }
    }
    const Vec3 move = body.bounds().center() - box.center();
    if (liesOn([&move](const Vec3& x) { return Vec3(x + move); }))
    {
      // Bounds of surfaces are as loose as their control points.
      text.precision(2);
      text << "; moved by about "
           << move.unaryExpr([size](double m) { return std::abs(m) < 1e-2 * size ? 0.0 : m; }).transpose()
           << " the wall lies on it";
    }
    throw Error(text.str());
  }
  return result;
}

namespace
{

/// The point of the nearest edge of the body, if a crease or border of the wall may follow it: its place is hardly
/// farther from that than from the surface, and the edge is no mere seam. `spacing`: the local edge length.
std::optional<Vec3> edgeToFollow(const BodySurface& body, const Vec3& point, const BodyPoint& closest, double spacing)
{
  constexpr double Near = 0.05;
  const BodyPoint edge = body.closestEdgePoint(point);
  return edge.patch >= 0 && edge.distance <= closest.distance + Near * spacing &&
      isShapeEdge(body, edge.geometry.point, spacing)
    ? std::optional<Vec3>(edge.geometry.point)
    : std::nullopt;
}

/// Where a sample of the wall should go: to a point, along a normal, or across an edge of the body with that direction.
struct SampleTarget
{
  Triple point;
  Triple direction;
  bool onEdge;

  /// The part of a difference that counts.
  Vec3 across(const Vec3& difference) const
  {
    const Vec3 along = vec3(this->direction).dot(difference) * vec3(this->direction);
    return this->onEdge ? Vec3(difference - along) : along;
  }
};

std::vector<SampleTarget> sampleTargets(
  const WallSamples& samples, const std::vector<Vec3>& at, const BodySurface& body, const Execution& run)
{
  // Sample i of a curve lies between the first and the last one of its span.
  const auto firstOf = [&](Index i) { return i - (i - samples.firstOnCurves()) % WallSamples::PerSpan; };
  const auto tangentAt = [&](Index i) { return Vec3(at[firstOf(i) + WallSamples::PerSpan - 1] - at[firstOf(i)]); };
  struct Foot
  {
    SampleTarget surface;
    Triple edge;
    bool nearEdge;
  };
  const std::vector<Foot> feet = sharedOut<Foot>(samples.size(), 256, run, [&](Index i) {
    const BodyPoint closest = body.closestPoint(at[i]);
    Foot foot{ { triple(closest.geometry.point), triple(closest.geometry.normal), false }, {}, false };
    if (i >= samples.firstOnCurves())
    {
      const double spacing = tangentAt(i).norm() * WallSamples::PerSpan / (WallSamples::PerSpan - 1);
      const std::optional<Vec3> edge = edgeToFollow(body, at[i], closest, spacing);
      foot.nearEdge = edge.has_value();
      foot.edge = triple(edge.value_or(Vec3::Zero()));
    }
    return foot;
  });
  std::vector<SampleTarget> targets;
  for (const Foot& foot : feet)
  {
    targets.push_back(foot.surface);
  }
  // Along an edge that is followed its points advance with the samples: not where a curve crosses it.
  for (Index first = samples.firstOnCurves(); first < samples.size(); first += WallSamples::PerSpan)
  {
    const Vec3 tangent = tangentAt(first);
    bool follows = (vec3(feet[first + WallSamples::PerSpan - 1].edge) - vec3(feet[first].edge)).dot(tangent) >
      0.5 * tangent.squaredNorm();
    for (Index i = first; i < first + WallSamples::PerSpan; ++i)
    {
      follows = follows && feet[i].nearEdge;
    }
    for (Index i = first; follows && i < first + WallSamples::PerSpan; ++i)
    {
      targets[i] = { feet[i].edge, triple(tangent.normalized()), true };
    }
  }
  return targets;
}

/// Conjugate gradients (Hestenes, Stiefel 1952): adds the solution d of A d = `residual` to x, A symmetric and positive
/// definite, until its residual is `tolerance` of the given one. @param apply A d of a d. @param dot scalar product.
template <typename Apply, typename Dot>
void addSolution(
  const Apply& apply, const Dot& dot, std::vector<Vec3> residual, int steps, double tolerance, std::vector<Vec3>& x)
{
  std::vector<Vec3> direction = residual;
  const double first = dot(residual, residual);
  double square = first;
  for (int k = 0; k < steps && square > tolerance * tolerance * first; ++k)
  {
    const std::vector<Vec3> image = apply(direction);
    const double length = square / dot(direction, image);
    for (std::size_t i = 0; i < x.size(); ++i)
    {
      x[i] += length * direction[i];
      residual[i] -= length * image[i];
    }
    const double before = square;
    square = dot(residual, residual);
    for (std::size_t i = 0; i < x.size(); ++i)
    {
      direction[i] = residual[i] + square / before * direction[i];
    }
  }
}

/// Least squares between the mesh points: of the distances of the samples from the body along its normals, by
/// Gauss-Newton rounds, in each of which closest points are found anew. Creases and borders are fitted as curves, too:
/// to an edge of the body that they follow, in both directions across it, else along the normals. Later rounds weight
/// samples by 1 + (d / RMS)^2, d their distance: so the largest distances fall, too.
void fitBetween(const BlockComplex& complex, const LimitRows& rows, const Wall& wall, const std::vector<Vec3>& given,
  const BodySurface& body, const std::vector<Vec3>& target, const Execution& run, std::vector<Vec3>& x,
  BodyFitReport& report)
{
  constexpr int Rounds = 12, UnweightedRounds = 4, Steps = 400;
  // What is left of the gradient.
  constexpr double Tolerance = 1e-3;
  // Of the limit points of what is not free, against samples. Movement counts so much, along the body and across it.
  constexpr double FixedWeight = WallSamples::PerSpan * WallSamples::PerSpan, Damping = 5e-4;
  // Of samples on curves: a span of them counts as much as three spans of the wall.
  constexpr double CurveWeight = 3.0 * WallSamples::PerSpan;
  const WallSamples samples(complex, rows, wall, given);
  const Index count = wall.size();
  std::vector<Vec3> best = x;
  std::vector<double> weights(samples.size(), 1.0);
  double least = 0.0, before = 0.0;
  for (int round = 0; round <= Rounds; ++round)
  {
    const std::vector<Vec3> at = samples.evaluate(x, run);
    const std::vector<SampleTarget> targets = sampleTargets(samples, at, body, run);
    std::vector<Vec3> off(samples.size());
    for (Index i = 0; i < samples.size(); ++i)
    {
      off[i] = targets[i].across(vec3(targets[i].point) - at[i]);
    }
    double largest = 0.0, squares = 0.0;
    for (const Vec3& difference : off)
    {
      const double distance = difference.norm();
      largest = std::max(largest, distance);
      squares += distance * distance;
    }
    const double rms = samples.size() > 0 ? std::sqrt(squares / static_cast<double>(samples.size())) : 0.0;
    if (round == 0)
    {
      report.sampleRms[0] = rms;
      report.sampleDistance[0] = largest;
    }
    // A mean near the largest one tells better than that whether a round was one to the good.
    double powers = 0.0;
    for (const Vec3& difference : off)
    {
      const double square = largest > 0.0 ? difference.squaredNorm() / (largest * largest) : 0.0;
      powers += square * square * square * square;
    }
    const double high = samples.size() > 0
      ? largest * std::sqrt(std::sqrt(std::sqrt(powers / static_cast<double>(samples.size()))))
      : 0.0;
    if (round == 0 || high < least)
    {
      best = x;
      least = high;
      report.sampleRms[1] = rms;
      report.sampleDistance[1] = largest;
    }
    // Where hardly anything changes any more, no further round.
    const bool settled = round > UnweightedRounds && std::abs(high - before) <= 0.01 * before;
    before = high;
    if (round == Rounds || settled || !(rms > 0.0))
    {
      break;
    }
    for (Index i = 0; i < samples.size() && round >= UnweightedRounds; ++i)
    {
      // The mean with the weight of the round before keeps rounds from taking turns between two states.
      weights[i] = std::sqrt(weights[i] * (1.0 + off[i].squaredNorm() / (rms * rms)));
    }
    // Normal equations of the movement d, at the points in the samples' order.
    const auto gradient = [&](std::vector<Vec3> off, const std::vector<Vec3>& fixedOff) {
      for (Index i = 0; i < samples.size(); ++i)
      {
        off[i] *= i < samples.firstOnCurves() ? weights[i] : CurveWeight * weights[i];
      }
      std::vector<Vec3> sum = samples.transposed(off, run);
      for (const Index i : samples.ordered())
      {
        if (!samples.isFree(i))
        {
          rows.forWeights(i, [&](Index point, double weight) { sum[point] += FixedWeight * weight * fixedOff[i]; });
        }
      }
      return sum;
    };
    const auto dot = [&](const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
      double sum = 0.0;
      for (const Index i : samples.ordered())
      {
        sum += a[i].dot(b[i]);
      }
      return sum;
    };
    std::vector<Vec3> fixedOff(count);
    for (Index i = 0; i < count; ++i)
    {
      fixedOff[i] = target[i] - rows.apply(i, x);
    }
    const auto apply = [&](const std::vector<Vec3>& direction) {
      run.report(0.9);
      std::vector<Vec3> moved = samples.evaluate(direction, run), fixedMoved(count);
      for (Index i = 0; i < samples.size(); ++i)
      {
        moved[i] = targets[i].across(moved[i]);
      }
      for (Index i = 0; i < count; ++i)
      {
        fixedMoved[i] = rows.apply(i, direction);
      }
      std::vector<Vec3> image = gradient(std::move(moved), fixedMoved);
      for (Index i = 0; i < count; ++i)
      {
        image[i] += Damping * direction[i];
      }
      return image;
    };
    addSolution(apply, dot, gradient(std::move(off), fixedOff), Steps, Tolerance, x);
  }
  x = best;
}

} // namespace

WallFit solveFit(const BlockComplex& complex, const ConversionOptions& conversion, const EntityRules& rules,
  const BodyFitOptions& options, const Execution& run)
{
  if (!(options.tolerance > 0.0 && options.tolerance < 1.0))
  {
    throw Error("Fit Tolerance " + text(options.tolerance) + " is not between 0 and 1, both excluded");
  }
  if (options.iterations < 1)
  {
    throw Error("Fit Iterations " + std::to_string(options.iterations) + " is not at least 1");
  }
  if (!(options.range >= 0.0))
  {
    throw Error("Propagation Range " + text(options.range) + " is not at least 0");
  }
  if (options.leastSquares && (!options.body || options.edgesOnly))
  {
    throw Error("Input Points LeastSquares needs a Body to fit the wall to");
  }
  if (options.edgesOnly && !options.body)
  {
    throw Error("limit points can be moved to the edges of a body only if there is one");
  }
  const Wall wall(complex, rules);
  WallFit result;
  BodyFitReport& report = result.report;
  report.wallPoints = wall.size();
  if (wall.size() == 0)
  {
    return result;
  }
  const LimitRows rows(complex, rules, wall);
  ExtraordinaryFans fans(rows, wall.size(), conversion.twist);
  const auto isFixed = [&](Index i) { return options.edgesOnly && !rows.onFeature(i); };
  const auto limit = [&](Index i, const std::vector<Vec3>& points) {
    return isFixed(i) ? points[i] : rows.apply(i, points);
  };
  const auto forAll = [&](const auto& body) {
    run.parallelFor(wall.size(), 256, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i)
      {
        body(i);
      }
    });
  };

  const std::vector<Vec3> given = wall.points(*run.ranks);
  std::vector<Vec3> target = given;
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  for (const Vec3& point : given)
  {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  const double size = (high - low).norm();
  // Far from the origin no limit point comes as close to its target as the tolerance says.
  const double rounding =
    16.0 * std::numeric_limits<double>::epsilon() * std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
  if (options.body)
  {
    struct Foot
    {
      Triple surface;
      Triple edge;
      bool nearEdge;
    };
    const std::vector<Foot> feet = sharedOut<Foot>(wall.size(), 256, run, [&](Index i) {
      if (isFixed(i))
      {
        return Foot{ triple(given[i]), {}, false };
      }
      const Vec3 point = options.edgesOnly ? limit(i, given) : given[i];
      const BodyPoint closest = options.body->closestPoint(point);
      const auto edge =
        rows.onFeature(i) ? edgeToFollow(*options.body, point, closest, rows.spacing(i, given)) : std::nullopt;
      return Foot{ triple(options.edgesOnly ? point : closest.geometry.point), triple(edge.value_or(Vec3::Zero())),
        edge.has_value() };
    });
    // Where the mesh follows an edge of the body, so do its limit points: not where a border crosses one.
    forAll([&](Index i) {
      bool follows = false;
      rows.forNext(i, [&](Index next) {
        const Vec3 along = given[next] - given[i];
        follows = follows ||
          (feet[i].nearEdge && feet[next].nearEdge &&
            (vec3(feet[next].edge) - vec3(feet[i].edge)).dot(along) > 0.5 * along.squaredNorm());
      });
      target[i] = vec3(follows ? feet[i].edge : feet[i].surface);
    });
  }

  if (options.body)
  {
    for (std::size_t fan = 0; fan < fans.size(); ++fan)
    {
      fans.setFoot(fan, options.body->closestPoint(target[fans.center(fan)]).geometry);
    }
  }

  // Chebyshev iteration for eigenvalues of L in [Least, 1]; regular masks have 1/9 at least.
  constexpr double Least = 0.05;
  constexpr double Center = 0.5 * (1.0 + Least), HalfWidth = 0.5 * (1.0 - Least);
  std::vector<Vec3> x = given, residual(wall.size()), step(wall.size(), Vec3::Zero());
  const auto measure = [&] {
    forAll([&](Index i) { residual[i] = limit(i, x); });
    if (!options.edgesOnly && conversion.twist != Twist::Literal)
    {
      fans.correct(x, residual);
    }
    forAll([&](Index i) { residual[i] = target[i] - residual[i]; });
    double largest = 0.0;
    for (const Vec3& r : residual)
    {
      largest = std::max(largest, r.norm());
    }
    return largest;
  };
  report.initialResidual = report.residual = measure();
  double rho = HalfWidth / Center;
  bool falling = true;
  while (report.residual > options.tolerance * size && (falling || report.residual > rounding))
  {
    if (report.iterations == options.iterations)
    {
      throw Error("the wall's control points were not found in " + std::to_string(options.iterations) +
        " iterations (Fit Iterations): a limit point is still " + text(report.residual) + " away from its target");
    }
    run.report(std::min(0.9, report.iterations / 80.0));
    if (report.iterations == 0)
    {
      forAll([&](Index i) { step[i] = residual[i] / Center; });
    }
    else
    {
      const double next = 1.0 / (2.0 * Center / HalfWidth - rho);
      forAll([&](Index i) { step[i] = next * rho * step[i] + 2.0 * next / HalfWidth * residual[i]; });
      rho = next;
    }
    forAll([&](Index i) { x[i] += step[i]; });
    ++report.iterations;
    const double before = std::exchange(report.residual, measure());
    falling = report.residual < before;
  }

  if (options.leastSquares)
  {
    fitBetween(complex, rows, wall, given, *options.body, target, run, x, report);
  }

  for (Index i = 0; i < wall.size(); ++i)
  {
    result.displacements.push_back(x[i] - given[i]);
    result.reaches.push_back(options.range * rows.spacing(i, given));
    report.displacement = std::max(report.displacement, result.displacements.back().norm());
  }
  result.targets = std::move(target);
  return result;
}

namespace
{

/// The mesh lines of the wall points of this rank's blocks.
std::vector<MeshLine> wallLines(
  const BlockComplex& complex, const Wall& wall, const WallFit& fit, const std::vector<double>& shares, int rank)
{
  std::vector<MeshLine> lines;
  for (const int f : wall.faces())
  {
    const FaceUse& use = complex.faces[f].uses.front();
    const ComplexBlock& owner = complex.blocks[use.block];
    for (int t = 0; t <= owner.cells(faceAxis(use.face, 1)) && owner.rank == rank; ++t)
    {
      for (int s = 0; s <= owner.cells(faceAxis(use.face, 0)); ++s)
      {
        const Index i = wall.id(use.block, use.face, s, t);
        const double share = shares.empty() ? 1.0 : shares[i];
        lines.push_back({ use.block, use.face, s, t, 0, 0.0, triple(share * fit.displacements[i]), fit.reaches[i], i });
      }
    }
  }
  return lines;
}

} // namespace

void applyFit(BlockComplex& complex, const EntityRules& rules, const WallFit& fit, const std::vector<double>& shares,
  const Execution& run)
{
  const Wall wall(complex, rules);
  if (wall.size() == 0)
  {
    return;
  }
  Displacements displacements(complex, *run.ranks);
  carry(complex, wallLines(complex, wall, fit, shares, run.ranks->rank()), displacements, *run.ranks);
  displacements.share();
  displacements.apply(complex);
  run.report(1.0);
}

bool lowerShares(const BlockComplex& complex, const EntityRules& rules, const WallFit& fit,
  const std::vector<SpanReport::Place>& places, double factor, std::vector<double>& shares, const Ranks& ranks)
{
  const Wall wall(complex, rules);
  shares.resize(wall.size(), 1.0);
  std::set<std::pair<int, Index>> corners;
  for (const SpanReport::Place& place : places)
  {
    const GridView& points = complex.blocks[place.block].points;
    for (int c = 0; c < 8; ++c)
    {
      corners.emplace(place.block,
        points.place(
          { place.cell[0] + cornerSide(c, 0), place.cell[1] + cornerSide(c, 1), place.cell[2] + cornerSide(c, 2) }));
    }
  }
  std::vector<Index> touched;
  follow(
    complex, wallLines(complex, wall, fit, shares, ranks.rank()),
    [&](const PointAt& point, double, const MeshLine& line) {
      if (corners.count({ point.block, complex.blocks[point.block].points.place(point.ijk) }) > 0)
      {
        touched.push_back(line.wallPoint);
      }
    },
    ranks);
  touched = ranks.gatherAll(touched);
  const std::set<Index> wallPoints(touched.begin(), touched.end());
  bool any = false;
  for (const Index i : wallPoints)
  {
    any = any || shares[i] > 0.0;
    shares[i] *= factor;
  }
  return any;
}

BodyFitReport fitBody(BlockComplex& complex, const ConversionOptions& conversion, const EntityRules& rules,
  const BodyFitOptions& options, const Execution& run)
{
  const WallFit fit = solveFit(complex, conversion, rules, options, run);
  applyFit(complex, rules, fit, {}, run);
  return fit.report;
}

WallMotion wallMotion(const BlockComplex& given, const BlockComplex& fitted, const ConversionOptions& conversion,
  const EntityRules& rules, const Execution& run)
{
  const Wall wall(given, rules);
  WallMotion motion;
  motion.wallPoints = wall.size();
  if (wall.size() == 0)
  {
    return motion;
  }
  const LimitRows rows(given, rules, wall);
  const std::vector<Vec3> points = wall.points(*run.ranks);
  const std::vector<Vec3> moved = Wall(fitted, rules).points(*run.ranks);
  std::vector<Vec3> limits(wall.size());
  for (Index i = 0; i < wall.size(); ++i)
  {
    limits[i] = rows.apply(i, moved);
  }
  ExtraordinaryFans(rows, wall.size(), conversion.twist).correct(moved, limits);

  struct Height
  {
    Index point;
    double value;
  };
  std::vector<Height> heights;
  for (const int f : wall.faces())
  {
    const FaceUse& use = given.faces[f].uses.front();
    const ComplexBlock& owner = given.blocks[use.block];
    if (owner.rank != run.ranks->rank())
    {
      continue;
    }
    const Ijk cells{ owner.cells(0), owner.cells(1), owner.cells(2) };
    for (int t = 0; t <= cells[faceAxis(use.face, 1)]; ++t)
    {
      for (int s = 0; s <= cells[faceAxis(use.face, 0)]; ++s)
      {
        Ijk above = facePoint(cells, use.face, s, t);
        const Vec3 x = owner.points(above);
        above[faceDirection(use.face)] += faceSide(use.face) ? -1 : 1;
        heights.push_back({ wall.id(use.block, use.face, s, t), (owner.points(above) - x).norm() });
      }
    }
  }
  std::vector<double> first(wall.size(), std::numeric_limits<double>::infinity());
  for (const Height& height : run.ranks->gatherAll(heights))
  {
    first[height.point] = std::min(first[height.point], height.value);
  }
  std::vector<double> lengths, inCells;
  for (Index i = 0; i < wall.size(); ++i)
  {
    const double length = (limits[i] - points[i]).norm();
    lengths.push_back(length);
    inCells.push_back(first[i] > 0.0 ? length / first[i] : 0.0);
    const Vec3& x = points[i];
    if (length > motion.largest || (length == motion.largest && (i == 0 || comesBefore(x, motion.where))))
    {
      motion.largest = length;
      motion.where = x;
    }
  }
  const auto median = [](std::vector<double>& values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  };
  motion.largestInCells = *std::max_element(inCells.begin(), inCells.end());
  motion.median = median(lengths);
  motion.medianInCells = median(inCells);
  return motion;
}

Index bluntPoints(const BlockComplex& complex, const EntityRules& rules, const Ranks& ranks)
{
  constexpr double Ratio = 4.0;
  const double bend = std::sqrt(0.5); // 45 degrees
  const Wall wall(complex, rules);
  const std::vector<Vec3> points = wall.points(ranks);
  const auto isBlunt = [&](Index before, Index at, Index after) {
    const Vec3 a = points[before] - points[at], b = points[after] - points[at];
    const double na = a.norm(), nb = b.norm();
    return std::max(na, nb) > Ratio * std::min(na, nb) && -a.dot(b) < bend * na * nb;
  };
  Index count = 0;
  for (const int f : wall.faces())
  {
    const FaceUse& use = complex.faces[f].uses.front();
    const ComplexBlock& owner = complex.blocks[use.block];
    const auto id = [&](int s, int t) { return wall.id(use.block, use.face, s, t); };
    for (int t = 1; t < owner.cells(faceAxis(use.face, 1)); ++t)
    {
      for (int s = 1; s < owner.cells(faceAxis(use.face, 0)); ++s)
      {
        count += isBlunt(id(s - 1, t), id(s, t), id(s + 1, t)) || isBlunt(id(s, t - 1), id(s, t), id(s, t + 1)) ? 1 : 0;
      }
    }
  }
  for (const int e : wall.edges())
  {
    const EdgeRule& rule = rules.edges[e];
    if (rule.feature || rule.fans.size() != 1 || rule.fans.front().closed)
    {
      continue;
    }
    const EdgeFan& fan = rule.fans.front();
    const auto beside = [&](int spoke, int k) {
      const auto [sector, which] = fan.spoke(spoke);
      const Ijk ijk = sector->point(complex.blocks[sector->block], k, which == 0 ? 1 : 0, which == 0 ? 0 : 1);
      return wall.id(sector->block, sector->spokeFace(which), ijk);
    };
    for (int k = 1; k < complex.edges[e].cells; ++k)
    {
      count += isBlunt(beside(0, k), wall.edgeId(e, k), beside(fan.spokeCount() - 1, k)) ? 1 : 0;
    }
  }
  return count;
}

WallDistances wallDistances(
  const BlockComplex& complex, const ConversionOptions& conversion, const BodySurface& body, const Execution& run)
{
  return wallDistances(complex, classify(complex, conversion, run), body, run);
}

BodyFitReport fitBody(
  BlockComplex& complex, const ConversionOptions& conversion, const BodyFitOptions& options, const Execution& run)
{
  return fitBody(complex, conversion, classify(complex, conversion, run), options, run);
}

} // namespace bsv
