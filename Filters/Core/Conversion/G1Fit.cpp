// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/G1Fit.h"

#include "Base/CanonicalOrder.h"
#include "Volume/BSplineVolume.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace bsv
{
namespace
{

SpokeKind kindOf(int cells)
{
  return static_cast<SpokeKind>(std::min(cells, 3));
}

/// Knots along a spoke of so many cells, as far as `count` control points need them.
std::vector<double> knotsAlong(int cells, int count)
{
  std::vector<double> knots = spokeKnots(kindOf(cells), count + 4);
  if (cells >= 3)
  {
    // {0^4,1,1,2,..,I-1,I-1,I^4}
    knots.assign({ 0.0, 0.0, 0.0, 0.0, 1.0 });
    for (int i = 1; i < cells; ++i)
    {
      knots.push_back(i);
    }
    knots.push_back(cells - 1.0);
    knots.insert(knots.end(), 4, cells);
  }
  return knots;
}

/// The B-splines at one parameter: of control points first .. first + 3.
struct SplineBasis
{
  int first = 0;
  std::array<double, 4> values{};

  SplineBasis(const std::vector<double>& knots, double u)
  {
    int s = 3;
    while (s + 5 < static_cast<int>(knots.size()) && u >= knots[s + 1])
    {
      ++s;
    }
    double left[4], right[4];
    for (int j = 1; j <= 3; ++j)
    {
      left[j] = u - knots[s + 1 - j];
      right[j] = knots[s + j] - u;
    }
    basisFunctions(3, 0, left, right, this->values.data());
    this->first = s - 3;
  }
};

/// A sample of the wall: what the net's points give it, and what the points around do.
struct Sample
{
  Eigen::VectorXd weights;
  Vec3 outside;
};

/// Coordinates of the points beside the constraints' null space.
Eigen::MatrixXd nullSpace(const std::vector<NetRow>& rows, const std::vector<int>& fixed, int size)
{
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(rows.size() + fixed.size(), size);
  for (std::size_t r = 0; r < rows.size(); ++r)
  {
    for (const auto& [point, coefficient] : rows[r])
    {
      matrix(r, point) = coefficient;
    }
  }
  for (std::size_t i = 0; i < fixed.size(); ++i)
  {
    matrix(rows.size() + i, fixed[i]) = 1.0;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix.transpose() * matrix);
  const double least = 1e-12 * solver.eigenvalues().maxCoeff();
  int dimension = 0;
  while (dimension < size && solver.eigenvalues()[dimension] < least)
  {
    ++dimension;
  }
  // Of double precision on the constraints, not of its square.
  Eigen::MatrixXd basis = solver.eigenvectors().leftCols(dimension);
  const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> inverse(matrix);
  for (int pass = 0; pass < 2; ++pass)
  {
    basis -= inverse.solve(matrix * basis);
  }
  return basis;
}

/// Spans along a spoke that are sampled: all that a net of that reach moves, as far as no other fit looks at them.
int sampledSpans(const WallPatch& patch, int spoke, int reach)
{
  const int cells = patch.cells[spoke];
  return std::min(reach, std::max(1, patch.alone ? cells - 1 : cells / 2));
}

class Fit
{
public:
  Fit(const WallPatch& start, int reach, const FootPoint& foot, double curvature, double stiffness,
    const std::function<FootPoint(const Vec3&)>& closest)
    : Closest(closest)
    , Reach(reach)
  {
    const int n = static_cast<int>(start.sectors.size());
    this->Shape.closed = true;
    this->Shape.sectors = n;
    this->Shape.reach = reach;
    for (const int cells : start.cells)
    {
      this->Shape.kinds.push_back(kindOf(cells));
    }
    this->Least = *std::min_element(start.cells.begin(), start.cells.end());
    // A frame in which the normal coordinate is one of its own.
    this->Frame.col(2) = foot.normal;
    const Vec3 first = at(start, 0, 1, 0) - at(start, 0, 0, 0);
    this->Frame.col(0) = (first - foot.normal * foot.normal.dot(first)).normalized();
    this->Frame.col(1) = foot.normal.cross(this->Frame.col(0));

    this->Start.resize(this->Shape.size());
    for (int k = 0; k < n; ++k)
    {
      for (int j = 0; j <= reach; ++j)
      {
        for (int i = 0; i <= reach; ++i)
        {
          this->Start[this->Shape.sector(k, i, j)] = at(start, k, i, j);
        }
      }
    }
    double length = 0.0;
    for (int k = 0; k < n; ++k)
    {
      length += (this->Start[this->Shape.spoke(k, 1)] - this->Start[0]).norm() / this->Shape.delta(k);
    }
    this->Size = 3.0 * length / n;
    const double bend = curvature * this->Size;
    this->Damping = stiffness * 0.03 * std::min(1.0, bend * bend);
    this->Far = 0.03 * curvature * this->Size * this->Size;
    this->makeSamples(start);
  }

  G1FitResult run()
  {
    G1FitResult result;
    const int n = this->Shape.size();
    const std::vector<NetRow> rows = joinConditions(this->Shape);
    std::vector<int> fixed{ 0 };
    const Eigen::MatrixXd tangential = nullSpace(rows, fixed, n);
    for (int k = 0; k < this->Shape.sectors; ++k)
    {
      fixed.push_back(this->Shape.spoke(k, 1));
    }
    const Eigen::MatrixXd normal = nullSpace(rows, fixed, n);
    const Eigen::Index dt = tangential.cols(), dn = normal.cols();
    const Eigen::Index unknowns = 2 * dt + dn;

    Eigen::MatrixXd weights(this->Samples.size(), n);
    for (std::size_t i = 0; i < this->Samples.size(); ++i)
    {
      weights.row(i) = this->Samples[i].weights;
    }
    const Eigen::MatrixXd bySampleTangential = weights * tangential, bySampleNormal = weights * normal;
    const double damping = this->Damping * this->Damping;

    // Bending and tangential movement of the change.
    Eigen::MatrixXd penalty = Eigen::MatrixXd::Zero(unknowns, unknowns);
    const Eigen::MatrixXd form = bendingForm(this->Shape, 2);
    const Eigen::MatrixXd formTangential = tangential.transpose() * form * tangential;
    penalty.block(0, 0, dt, dt) += formTangential;
    penalty.block(dt, dt, dt, dt) += formTangential;
    penalty.block(2 * dt, 2 * dt, dn, dn) += normal.transpose() * form * normal;
    std::vector<Eigen::Matrix3d> projections(n);
    for (int a = 0; a < n; ++a)
    {
      const Vec3 local = this->Frame.transpose() * this->Closest(this->Start[a]).normal;
      projections[a] = Eigen::Matrix3d::Identity() - local * local.transpose();
    }
    const auto basisOf = [&](int d) -> const Eigen::MatrixXd& { return d < 2 ? tangential : normal; };
    const auto offsetOf = [&](int d) { return d * dt; };
    for (int d = 0; d < 3; ++d)
    {
      for (int e = 0; e < 3; ++e)
      {
        Eigen::VectorXd factors(n);
        for (int a = 0; a < n; ++a)
        {
          factors[a] = projections[a](d, e);
        }
        penalty.block(offsetOf(d), offsetOf(e), basisOf(d).cols(), basisOf(e).cols()) +=
          basisOf(d).transpose() * factors.asDiagonal() * basisOf(e);
      }
    }
    penalty *= damping;

    constexpr double Area = 1.0 / 16.0; // of a sample, in spans
    std::vector<Vec3> net = this->Start;
    const bool fine = this->Least >= 8;
    Eigen::VectorXd total = Eigen::VectorXd::Zero(unknowns);
    Eigen::VectorXd residual(this->Samples.size());
    Eigen::MatrixXd jacobian(this->Samples.size(), unknowns);
    for (int iteration = 0; iteration <= (fine ? 4 : 3); ++iteration)
    {
      for (std::size_t i = 0; i < this->Samples.size(); ++i)
      {
        const Vec3 x = this->evaluate(i, net);
        const FootPoint body = this->Closest(x);
        residual[i] = body.normal.dot(x - body.point);
        const Vec3 local = this->Frame.transpose() * body.normal;
        jacobian.row(i).segment(0, dt) = local[0] * bySampleTangential.row(i);
        jacobian.row(i).segment(dt, dt) = local[1] * bySampleTangential.row(i);
        jacobian.row(i).segment(2 * dt, dn) = local[2] * bySampleNormal.row(i);
      }
      const double rms = std::sqrt(residual.squaredNorm() / static_cast<double>(this->Samples.size()));
      (iteration == 0 ? result.before : result.after) = rms;
      if (iteration == 0 && !(rms <= this->Far))
      {
        return result;
      }
      if (iteration == (fine ? 4 : 3))
      {
        break;
      }
      const Eigen::MatrixXd left = Area * (jacobian.transpose() * jacobian) + penalty;
      Eigen::VectorXd right = -Area * (jacobian.transpose() * residual);
      if (!fine)
      {
        right -= penalty * total; // the start is what must not be left
      }
      const Eigen::VectorXd step = left.ldlt().solve(right);
      total += step;
      const Eigen::MatrixXd move = (tangential * step.segment(0, dt)) * this->Frame.col(0).transpose() +
        (tangential * step.segment(dt, dt)) * this->Frame.col(1).transpose() +
        (normal * step.segment(2 * dt, dn)) * this->Frame.col(2).transpose();
      for (int a = 0; a < n; ++a)
      {
        net[a] += Vec3(move.row(a));
      }
    }
    double moved = 0.0;
    for (int a = 0; a < n; ++a)
    {
      moved = std::max(moved, (net[a] - this->Start[a]).norm());
    }
    if (moved <= 0.5 * this->Size && result.after < result.before)
    {
      result.reach = this->Reach;
      result.shape = this->Shape;
      result.net = std::move(net);
    }
    return result;
  }

private:
  static const Vec3& at(const WallPatch& patch, int sector, int i, int j)
  {
    return patch.sectors[sector][i + patch.size * j];
  }

  void makeSamples(const WallPatch& start)
  {
    constexpr int PerSpan = 4;
    const int n = this->Shape.sectors;
    for (int k = 0; k < n; ++k)
    {
      const int cells[2] = { start.cells[k], start.cells[(k + 1) % n] };
      std::array<std::vector<SplineBasis>, 2> bases;
      for (int d = 0; d < 2; ++d)
      {
        const std::vector<double> knots = knotsAlong(cells[d], start.size);
        const int spans = sampledSpans(start, (k + d) % n, this->Reach);
        bases[d].emplace_back(knots, 0.0);
        for (int q = 0; q < PerSpan * spans; ++q)
        {
          bases[d].emplace_back(knots, (q + 0.5) / PerSpan);
        }
      }
      for (std::size_t t = 0; t < bases[1].size(); ++t)
      {
        for (std::size_t s = 0; s < bases[0].size(); ++s)
        {
          if (s + t == 0)
          {
            continue; // P, which is fixed
          }
          Sample sample{ Eigen::VectorXd::Zero(this->Shape.size()), Vec3::Zero() };
          for (int b = 0; b < 4; ++b)
          {
            for (int a = 0; a < 4; ++a)
            {
              const int i = bases[0][s].first + a, j = bases[1][t].first + b;
              const double weight = bases[0][s].values[a] * bases[1][t].values[b];
              if (weight == 0.0)
              {
                continue;
              }
              if (i <= this->Reach && j <= this->Reach)
              {
                sample.weights[this->Shape.sector(k, i, j)] += weight;
              }
              else
              {
                sample.outside += weight * at(start, k, i, j);
              }
            }
          }
          this->Samples.push_back(std::move(sample));
        }
      }
    }
  }

  Vec3 evaluate(std::size_t i, const std::vector<Vec3>& net) const
  {
    Vec3 x = this->Samples[i].outside;
    for (int a = 0; a < this->Shape.size(); ++a)
    {
      if (this->Samples[i].weights[a] != 0.0)
      {
        x += this->Samples[i].weights[a] * net[a];
      }
    }
    return x;
  }

  const std::function<FootPoint(const Vec3&)>& Closest;
  int Reach;
  int Least = 0;
  LocalNetShape Shape;
  Eigen::Matrix3d Frame;
  std::vector<Vec3> Start;
  double Size = 0.0;
  double Damping = 0.0;
  /// Beyond this distance the wall around is not on the body.
  double Far = 0.0;
  std::vector<Sample> Samples;
};

/// The patch seen from another spoke on, in the same or the other sense.
WallPatch turned(const WallPatch& patch, const CycleOrder& order)
{
  const int n = static_cast<int>(patch.sectors.size());
  WallPatch result = patch;
  for (int k = 0; k < n; ++k)
  {
    result.cells[k] = patch.cells[order.item(k)];
    const std::vector<Vec3>& from = patch.sectors[order.gap(k)];
    for (int j = 0; j < patch.size; ++j)
    {
      for (int i = 0; i < patch.size; ++i)
      {
        result.sectors[k][i + patch.size * j] = order.backwards() ? from[j + patch.size * i] : from[i + patch.size * j];
      }
    }
  }
  return result;
}

} // namespace

G1FitResult fitToBody(
  const WallPatch& start, const FootPoint& foot, double curvature, const std::function<FootPoint(const Vec3&)>& closest)
{
  // From the smallest first point on, towards the smaller of its neighbours.
  const int n = static_cast<int>(start.sectors.size());
  const CycleOrder order(n, [&](int a, int b) { return comesBefore(start.sectors[a][1], start.sectors[b][1]); });
  const WallPatch sorted = turned(start, order);
  const bool large = *std::min_element(start.cells.begin(), start.cells.end()) >= 8;
  // The softest fit is the closest to the body; where points slide too far, as on a nearly flat one, a stiffer one.
  // What no sample sees is held by stiffness alone.
  const auto softest = [&](int reach) {
    for (int k = 0; k < n; ++k)
    {
      if (sampledSpans(sorted, k, reach) < reach)
      {
        return 1.0;
      }
    }
    return 0.25;
  };
  G1FitResult result;
  for (int reach = large ? 4 : 3; reach >= 3 && result.reach == 0; --reach)
  {
    for (double stiffness = softest(reach); stiffness < 100.0 && result.reach == 0; stiffness *= 4.0)
    {
      result = Fit(sorted, reach, foot, curvature, stiffness, closest).run();
    }
  }
  if (result.reach > 0)
  {
    // Back into the order of the start.
    std::vector<Vec3> net = result.net;
    LocalNetShape shape = result.shape;
    for (int k = 0; k < n; ++k)
    {
      shape.kinds[order.item(k)] = result.shape.kinds[k];
    }
    for (int k = 0; k < n; ++k)
    {
      const int own = order.gap(k);
      for (int j = 0; j <= shape.reach; ++j)
      {
        for (int i = 0; i <= shape.reach; ++i)
        {
          net[order.backwards() ? shape.sector(own, j, i) : shape.sector(own, i, j)] =
            result.net[result.shape.sector(k, i, j)];
        }
      }
    }
    result.shape = shape;
    result.net = std::move(net);
  }
  return result;
}

} // namespace bsv
