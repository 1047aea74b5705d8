// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/G1Fit.h"

#include "Base/CanonicalOrder.h"
#include "Conversion/DoubleKnots.h"
#include "Volume/BSplineVolume.h"

#include <Eigen/SparseCore>

#include <algorithm>
#include <array>
#include <cmath>

namespace bsv
{
namespace
{

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

class Fit
{
public:
  Fit(const WallPatch& start, int reach, const FootPoint& foot, double curvature,
    const std::function<FootPoint(const Vec3&)>& closest)
    : Closest(closest)
    , Reach(reach)
  {
    const int n = static_cast<int>(start.sectors.size());
    this->Shape = { true, n, reach, {} };
    for (const int cells : start.cells)
    {
      this->Shape.kinds.push_back(spokeKind(cells));
    }
    // A frame in which the normal coordinate is one of its own.
    this->Frame.col(2) = foot.normal;
    const Vec3 first = at(start, 0, 1, 0) - at(start, 0, 0, 0);
    this->Frame.col(0) = (first - foot.normal * foot.normal.dot(first)).normalized();
    this->Frame.col(1) = foot.normal.cross(this->Frame.col(0));

    this->Start = this->netOf(start.sectors, start.size);
    this->Unfitted = this->netOf(start.unfitted, start.size);
    double length = 0.0;
    for (int k = 0; k < n; ++k)
    {
      length += (this->Unfitted[this->Shape.spoke(k, 1)] - this->Unfitted[0]).norm() / this->Shape.delta(k);
    }
    this->Size = 3.0 * length / n;
    const double bend = std::min(1.0, curvature * this->Size);
    this->Damping = 0.004 * bend * std::sqrt(bend);
    this->makeSamples(start);
    this->Norm = this->distanceNorm(start.isNearOthers() ? 0.3 : 0.15);
    this->makeUnknowns();
    this->First = this->linearize(this->Start);
    this->OnBody = this->isNearerThanControls(start);
    if (this->OnBody)
    {
      this->makePenalty();
    }
  }

  /// Nothing moves if the wall is not on the body.
  bool isOnBody() const { return this->OnBody; }

  /// Gauss-Newton rounds from the start on, the change being damped.
  G1FitResult run(double stiffness) const
  {
    constexpr int Rounds = 4;
    G1FitResult result;
    result.before = this->First.rms;
    const int n = this->Shape.size();
    const Eigen::Index dt = this->Tangential.cols(), dn = this->Normal.cols();
    const Eigen::MatrixXd penalty = (stiffness * stiffness * this->Damping * this->Damping) * this->Penalty;
    std::vector<Vec3> net = this->Start;
    Linearization at = this->First;
    double first = 0.0, last = 0.0;
    for (int round = 0; round <= Rounds; ++round)
    {
      if (round > 0)
      {
        at = this->linearize(net);
      }
      // What was moved so far, in coordinates of the null spaces.
      Eigen::MatrixXd move(n, 3);
      for (int a = 0; a < n; ++a)
      {
        move.row(a) = this->Frame.transpose() * (net[a] - this->Unfitted[a]);
      }
      Eigen::VectorXd moved(2 * dt + dn);
      moved << this->Tangential.transpose() * move.col(0), this->Tangential.transpose() * move.col(1),
        this->Normal.transpose() * move.col(2);
      const Eigen::VectorXd held = penalty * moved;
      const double before = last;
      last = at.value + moved.dot(held);
      first = round == 0 ? last : first;
      if (round == Rounds || (round > 0 && std::abs(before - last) < 0.03 * before))
      {
        break;
      }
      const Eigen::VectorXd step = (at.normal + penalty).ldlt().solve(-at.gradient - held);
      move.col(0) = this->Tangential * step.segment(0, dt);
      move.col(1) = this->Tangential * step.segment(dt, dt);
      move.col(2) = this->Normal * step.segment(2 * dt, dn);
      for (int a = 0; a < n; ++a)
      {
        net[a] += this->Frame * move.row(a).transpose();
      }
    }
    result.after = at.rms;
    double farthest = 0.0;
    for (int a = 0; a < n; ++a)
    {
      farthest = std::max(farthest, (net[a] - this->Unfitted[a]).norm());
    }
    if (farthest <= this->Size / (this->Reach == 4 ? 3.0 : 2.0) && last < first)
    {
      result.reach = this->Reach;
      result.shape = this->Shape;
      result.net = std::move(net);
    }
    return result;
  }

private:
  /// The squares of all distances and of their second differences, in spans, at a net: their sum, its gradient and
  /// Gauss-Newton matrix in coordinates of the null spaces.
  struct Linearization
  {
    double rms = 0.0;
    double value = 0.0;
    Eigen::VectorXd gradient;
    Eigen::MatrixXd normal;
  };

  Linearization linearize(const std::vector<Vec3>& net) const
  {
    constexpr double Area = 1.0 / 16.0; // of a sample
    const Eigen::Index dt = this->Tangential.cols(), dn = this->Normal.cols();
    Eigen::VectorXd residual(this->Samples.size());
    Eigen::MatrixXd jacobian(this->Samples.size(), 2 * dt + dn);
    for (std::size_t i = 0; i < this->Samples.size(); ++i)
    {
      const Vec3 x = this->evaluate(i, net);
      const FootPoint body = this->Closest(x);
      residual[i] = body.normal.dot(x - body.point);
      const Vec3 local = this->Frame.transpose() * body.normal;
      jacobian.row(i) << local[0] * this->BySampleTangential.row(i), local[1] * this->BySampleTangential.row(i),
        local[2] * this->BySampleNormal.row(i);
    }
    const Eigen::VectorXd weighted = this->Norm * residual;
    return { std::sqrt(residual.squaredNorm() / static_cast<double>(this->Samples.size())),
      Area * residual.dot(weighted), Area * (jacobian.transpose() * weighted),
      Area * (jacobian.transpose() * (this->Norm * jacobian)) };
  }

  /// Unknowns: the conditions' null spaces, of the coordinates in the tangent plane and of that along the normal.
  void makeUnknowns()
  {
    const int n = this->Shape.size();
    const std::vector<NetRow> rows = joinConditions(this->Shape);
    std::vector<int> fixed{ 0 };
    this->Tangential = nullSpace(rows, fixed, n);
    for (int k = 0; k < this->Shape.sectors; ++k)
    {
      fixed.push_back(this->Shape.spoke(k, 1));
    }
    this->Normal = nullSpace(rows, fixed, n);
    Eigen::MatrixXd weights(this->Samples.size(), n);
    for (std::size_t i = 0; i < this->Samples.size(); ++i)
    {
      weights.row(i) = this->Samples[i].weights;
    }
    this->BySampleTangential = weights * this->Tangential;
    this->BySampleNormal = weights * this->Normal;
  }

  /// Bending and tangential movement of the change.
  void makePenalty()
  {
    const int n = this->Shape.size();
    const Eigen::Index dt = this->Tangential.cols(), dn = this->Normal.cols();
    this->Penalty = Eigen::MatrixXd::Zero(2 * dt + dn, 2 * dt + dn);
    const Eigen::MatrixXd form = bendingForm(this->Shape, 2);
    const Eigen::MatrixXd formTangential = this->Tangential.transpose() * form * this->Tangential;
    this->Penalty.block(0, 0, dt, dt) += formTangential;
    this->Penalty.block(dt, dt, dt, dt) += formTangential;
    this->Penalty.block(2 * dt, 2 * dt, dn, dn) += this->Normal.transpose() * form * this->Normal;
    std::vector<Eigen::Matrix3d> projections(n);
    for (int a = 0; a < n; ++a)
    {
      const Vec3 local = this->Frame.transpose() * this->Closest(this->Unfitted[a]).normal;
      projections[a] = Eigen::Matrix3d::Identity() - local * local.transpose();
    }
    const auto basisOf = [&](int d) -> const Eigen::MatrixXd& { return d < 2 ? this->Tangential : this->Normal; };
    for (int d = 0; d < 3; ++d)
    {
      for (int e = 0; e < 3; ++e)
      {
        Eigen::VectorXd factors(n);
        for (int a = 0; a < n; ++a)
        {
          factors[a] = projections[a](d, e);
        }
        this->Penalty.block(d * dt, e * dt, basisOf(d).cols(), basisOf(e).cols()) +=
          basisOf(d).transpose() * factors.asDiagonal() * basisOf(e);
      }
    }
  }

  /// Whether the samples are nearer to the body than the control points next to the net, twice at least.
  bool isNearerThanControls(const WallPatch& start) const
  {
    double sum = 0.0;
    int count = 0;
    const int end = this->Reach + 1;
    const auto add = [&](const Vec3& x) {
      const FootPoint body = this->Closest(x);
      const double distance = body.normal.dot(x - body.point);
      sum += distance * distance;
      ++count;
    };
    for (int k = 0; k < this->Shape.sectors; ++k)
    {
      for (int i = 0; i <= end; ++i)
      {
        add(at(start, k, end, i));
      }
      for (int i = 1; i < end; ++i)
      {
        add(at(start, k, i, end));
      }
    }
    const double rounding = 1e-10 * this->Size + 1e-13 * this->Start[0].norm();
    return this->First.rms > rounding && this->First.rms <= 0.5 * std::sqrt(sum / count);
  }

  static const Vec3& at(const WallPatch& patch, int sector, int i, int j)
  {
    return patch.sectors[sector][i + patch.size * j];
  }

  std::vector<Vec3> netOf(const std::vector<std::vector<Vec3>>& sectors, int size) const
  {
    std::vector<Vec3> net(this->Shape.size());
    this->Shape.forPoints([&](int a, int k, int i, int j) { net[a] = sectors[k][i + size * j]; });
    return net;
  }

  void makeSamples(const WallPatch& start)
  {
    constexpr int PerSpan = 4;
    const int n = this->Shape.sectors;
    for (int k = 0; k < n; ++k)
    {
      const int cells[2] = { start.cells[k], start.cells[(k + 1) % n] };
      std::array<std::vector<double>, 2> parameters;
      std::array<std::vector<SplineBasis>, 2> bases;
      for (int d = 0; d < 2; ++d)
      {
        parameters[d].push_back(0.0);
        for (int q = 0; q < PerSpan * std::min(this->Reach, std::max(1, cells[d] - 1)); ++q)
        {
          parameters[d].push_back((q + 0.5) / PerSpan);
        }
        const std::vector<double> knots = volumeKnots(cells[d], true);
        for (const double u : parameters[d])
        {
          bases[d].emplace_back(knots, u);
        }
      }
      const int counts[2] = { static_cast<int>(bases[0].size()), static_cast<int>(bases[1].size()) };
      // Nearer to another vertex that is fitted, it is a sample of that.
      std::vector<int> places(counts[0] * counts[1], -1);
      for (int t = 0; t < counts[1]; ++t)
      {
        for (int s = 0; s < counts[0]; ++s)
        {
          const bool far[2] = { 2.0 * parameters[0][s] > cells[0], 2.0 * parameters[1][t] > cells[1] };
          const std::array<bool, 3>& others = start.others[k];
          if (!(far[0] && others[0]) && !(far[1] && others[1]) && !(far[0] && far[1] && others[2]))
          {
            places[s + counts[0] * t] = static_cast<int>(this->Samples.size());
            this->Samples.push_back(this->sample(start, k, bases[0][s], bases[1][t]));
          }
        }
      }
      this->addDifferences(places, parameters, PerSpan);
    }
  }

  Sample sample(const WallPatch& start, int k, const SplineBasis& first, const SplineBasis& second) const
  {
    Sample result{ Eigen::VectorXd::Zero(this->Shape.size()), Vec3::Zero() };
    for (int b = 0; b < 4; ++b)
    {
      for (int a = 0; a < 4; ++a)
      {
        const int i = first.first + a, j = second.first + b;
        const double weight = first.values[a] * second.values[b];
        if (weight == 0.0)
        {
          continue;
        }
        if (i <= this->Reach && j <= this->Reach)
        {
          result.weights[this->Shape.sector(k, i, j)] += weight;
        }
        else
        {
          result.outside += weight * at(start, k, i, j);
        }
      }
    }
    return result;
  }

  /// Second differences of a sector's samples, where all samples are: along both directions and mixed, as if all were
  /// one step apart.
  void addDifferences(const std::vector<int>& places, const std::array<std::vector<double>, 2>& parameters, int perSpan)
  {
    const int counts[2] = { static_cast<int>(parameters[0].size()), static_cast<int>(parameters[1].size()) };
    const double step = 1.0 / perSpan, square = step * step;
    const auto add = [&](std::initializer_list<std::pair<int, double>> terms) {
      if (std::all_of(terms.begin(), terms.end(), [](const auto& term) { return term.first >= 0; }))
      {
        for (const auto& [place, weight] : terms)
        {
          this->Differences.emplace_back(this->DifferenceCount, place, weight);
        }
        ++this->DifferenceCount;
      }
    };
    for (int t = 0; t < counts[1]; ++t)
    {
      for (int s = 0; s < counts[0]; ++s)
      {
        const int here = s + counts[0] * t;
        const int position[2] = { s, t }, strides[2] = { 1, counts[0] };
        for (int d = 0; d < 2; ++d)
        {
          if (position[d] > 0 && position[d] + 1 < counts[d])
          {
            const double* u = parameters[d].data() + position[d];
            const double low = square * 2.0 / ((u[0] - u[-1]) * (u[1] - u[-1]));
            const double high = square * 2.0 / ((u[1] - u[0]) * (u[1] - u[-1]));
            add({ { places[here - strides[d]], low }, { places[here], -low - high },
              { places[here + strides[d]], high } });
          }
        }
        if (s + 1 < counts[0] && t + 1 < counts[1])
        {
          const double both = std::sqrt(2.0) * square /
            ((parameters[0][s + 1] - parameters[0][s]) * (parameters[1][t + 1] - parameters[1][t]));
          add({ { places[here], both }, { places[here + 1], -both }, { places[here + counts[0]], -both },
            { places[here + counts[0] + 1], both } });
        }
      }
    }
  }

  /// Sum of the squares of all distances and of their weighted second differences.
  Eigen::SparseMatrix<double> distanceNorm(double weight) const
  {
    const auto samples = static_cast<Eigen::Index>(this->Samples.size());
    Eigen::SparseMatrix<double> differences(this->DifferenceCount, samples), norm(samples, samples);
    differences.setFromTriplets(this->Differences.begin(), this->Differences.end());
    norm.setIdentity();
    norm += weight * (Eigen::SparseMatrix<double>(differences.transpose()) * differences);
    return norm;
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
  LocalNetShape Shape;
  Eigen::Matrix3d Frame;
  std::vector<Vec3> Start, Unfitted;
  double Size = 0.0;
  double Damping = 0.0;
  std::vector<Sample> Samples;
  std::vector<Eigen::Triplet<double>> Differences;
  int DifferenceCount = 0;
  Eigen::SparseMatrix<double> Norm;
  Eigen::MatrixXd Tangential, Normal, BySampleTangential, BySampleNormal;
  Eigen::MatrixXd Penalty;
  Linearization First;
  bool OnBody = false;
};

/// The patch seen from another spoke on, in the same or the other sense.
WallPatch turned(const WallPatch& patch, const CycleOrder& order)
{
  const int n = static_cast<int>(patch.sectors.size());
  WallPatch result = patch;
  for (int k = 0; k < n; ++k)
  {
    const int own = order.gap(k);
    result.cells[k] = patch.cells[order.item(k)];
    result.others[k] = patch.others[own];
    if (order.backwards())
    {
      std::swap(result.others[k][0], result.others[k][1]);
    }
    const auto turn = [&](std::vector<Vec3>& to, const std::vector<Vec3>& from) {
      for (int j = 0; j < patch.size; ++j)
      {
        for (int i = 0; i < patch.size; ++i)
        {
          to[i + patch.size * j] = order.backwards() ? from[j + patch.size * i] : from[i + patch.size * j];
        }
      }
    };
    turn(result.sectors[k], patch.sectors[own]);
    turn(result.unfitted[k], patch.unfitted[own]);
  }
  return result;
}

} // namespace

bool WallPatch::isNearOthers() const
{
  return std::any_of(this->others.begin(), this->others.end(),
    [](const std::array<bool, 3>& ends) { return ends[0] || ends[1] || ends[2]; });
}

G1FitResult fitToBody(
  const WallPatch& start, const FootPoint& foot, double curvature, const std::function<FootPoint(const Vec3&)>& closest)
{
  // From the smallest first point on, towards the smaller of its neighbours.
  const int n = static_cast<int>(start.sectors.size());
  const CycleOrder order(n, [&](int a, int b) { return comesBefore(start.unfitted[a][1], start.unfitted[b][1]); });
  const WallPatch sorted = turned(start, order);
  const bool large = *std::min_element(start.cells.begin(), start.cells.end()) >= 8;
  const bool near = sorted.isNearOthers();
  // Where points slide too far, a stiffer one.
  G1FitResult result;
  for (int reach = large ? 4 : 3; reach >= 3 && result.reach == 0; --reach)
  {
    const Fit fit(sorted, reach, foot, curvature, closest);
    for (double stiffness = near ? 4.0 : 1.0; fit.isOnBody() && stiffness < 500.0 && result.reach == 0;
         stiffness *= 2.0)
    {
      result = fit.run(stiffness);
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
    shape.forPoints([&](int a, int k, int i, int j) {
      net[shape.sector(order.gap(k), order.backwards() ? j : i, order.backwards() ? i : j)] = result.net[a];
    });
    result.shape = shape;
    result.net = std::move(net);
  }
  return result;
}

} // namespace bsv
