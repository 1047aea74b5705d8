// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/LocalNet.h"

#include "Base/Numbers.h"
#include "Base/OrderFreeSum.h"
#include "Conversion/DoubleKnots.h"
#include "Volume/BSplineVolume.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace bsv
{
namespace
{

/// g of the conditions.
double joinCosine(const LocalNetShape& shape)
{
  // Exactly 0 in a regular fan.
  if (shape.sectors == (shape.closed ? 4 : 2))
  {
    return 0.0;
  }
  return 2.0 * std::cos((shape.closed ? 2.0 : 1.0) * Pi / shape.sectors);
}

/// Conditions in this order: for each joined spoke (a), then for each (b), (c), (d) 2 .. reach.
std::vector<JoinCondition> conditions(const LocalNetShape& shape, bool first)
{
  const double g = joinCosine(shape);
  const int n = shape.spokes();
  std::vector<JoinCondition> list;
  for (int k = 0; k < n; ++k)
  {
    if (!shape.isJoined(k))
    {
      continue;
    }
    const int before = (k + n - 1) % n, after = (k + 1) % n, sectorBefore = (k + shape.sectors - 1) % shape.sectors;
    const double wl = 1.0 / shape.delta(before), wr = 1.0 / shape.delta(after), w = 1.0 / shape.delta(k);
    if (first)
    {
      list.push_back({ shape.spoke(before, 1), shape.spoke(after, 1), 0, wl, wr,
        { { { shape.spoke(k, 1), -g * w }, { 0, g * w } } }, 2 });
      continue;
    }
    for (int i = 1; i <= shape.reach; ++i)
    {
      JoinCondition condition{ shape.sector(sectorBefore, 1, i), shape.sector(k, i, 1), shape.spoke(k, i), wl, wr, {},
        0 };
      if (i == 1)
      {
        // c_3' - c_2 = (c_3 - c_2) / 2: the first two spans are equal.
        condition.side = { { { shape.spoke(k, 3), -g * w / 6.0 }, { shape.spoke(k, 2), g * w / 6.0 } } };
        condition.sideTerms = g == 0.0 ? 0 : 2;
      }
      list.push_back(condition);
      if (i == 1)
      {
        list.push_back({ -1, -1, -1, 0.0, 0.0,
          { { { shape.spoke(k, 3), 0.5 }, { shape.spoke(k, 2), -2.5 }, { shape.spoke(k, 1), 3.0 }, { 0, -1.0 } } },
          4 });
      }
    }
  }
  return list;
}

NetRow rowOf(const JoinCondition& condition)
{
  std::map<int, double> row;
  if (condition.center >= 0)
  {
    row[condition.left] += condition.leftWeight;
    row[condition.right] += condition.rightWeight;
    row[condition.center] -= condition.leftWeight + condition.rightWeight;
  }
  for (int i = 0; i < condition.sideTerms; ++i)
  {
    row[condition.side[i].first] += condition.side[i].second;
  }
  return NetRow(row.begin(), row.end());
}

Eigen::MatrixXd matrixOf(const std::vector<JoinCondition>& list, const std::vector<int>& points, int size)
{
  std::vector<int> column(size, -1);
  for (std::size_t i = 0; i < points.size(); ++i)
  {
    column[points[i]] = static_cast<int>(i);
  }
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(list.size(), points.size());
  for (std::size_t r = 0; r < list.size(); ++r)
  {
    for (const auto& [point, coefficient] : rowOf(list[r]))
    {
      if (column[point] >= 0)
      {
        matrix(r, column[point]) += coefficient;
      }
    }
  }
  return matrix;
}

/// Integrals of products of the B-splines 0 .. reach and their derivatives of the orders a and b over all spans on
/// which they are not zero.
Eigen::MatrixXd gram(SpokeKind kind, int reach, int order)
{
  const std::vector<double> knots = spokeKnots(kind, reach + 6);
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(reach + 1, reach + 1);
  // Gauss points of order 4, exact for the degree 6 of the products.
  const double a = std::sqrt(3.0 / 7.0 - 2.0 / 7.0 * std::sqrt(6.0 / 5.0));
  const double b = std::sqrt(3.0 / 7.0 + 2.0 / 7.0 * std::sqrt(6.0 / 5.0));
  const double wa = (18.0 + std::sqrt(30.0)) / 36.0, wb = (18.0 - std::sqrt(30.0)) / 36.0;
  const double nodes[4] = { -b, -a, a, b }, weights[4] = { wb, wa, wa, wb };
  for (int s = 3; s <= reach + 3 && s + 1 < static_cast<int>(knots.size()); ++s)
  {
    const double width = knots[s + 1] - knots[s];
    for (int q = 0; q < 4 && width > 0.0; ++q)
    {
      const double u = knots[s] + 0.5 * (1.0 + nodes[q]) * width;
      double left[4], right[4], values[4];
      for (int j = 1; j <= 3; ++j)
      {
        left[j] = u - knots[s + 1 - j];
        right[j] = (s + j < static_cast<int>(knots.size()) ? knots[s + j] : knots.back()) - u;
      }
      basisFunctions(3, order, left, right, values);
      for (int i = 0; i < 4; ++i)
      {
        for (int j = 0; j < 4; ++j)
        {
          if (s - 3 + i <= reach && s - 3 + j <= reach)
          {
            matrix(s - 3 + i, s - 3 + j) += 0.5 * width * weights[q] * values[i] * values[j];
          }
        }
      }
    }
  }
  return matrix;
}

/// Pseudo-inverse of a symmetric matrix, without what is below 1e-10 of its largest eigenvalue.
Eigen::MatrixXd pseudoInverse(const Eigen::MatrixXd& matrix)
{
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix);
  const Eigen::VectorXd& values = solver.eigenvalues();
  const double least = 1e-10 * values.cwiseAbs().maxCoeff();
  Eigen::VectorXd inverse = values;
  for (Eigen::Index i = 0; i < values.size(); ++i)
  {
    inverse[i] = std::abs(values[i]) > least ? 1.0 / values[i] : 0.0;
  }
  return solver.eigenvectors() * inverse.asDiagonal() * solver.eigenvectors().transpose();
}

/// Point of the net that a turned and perhaps reflected fan has at the place of `point`, and spoke at the place of `k`.
struct Symmetry
{
  int turn;
  bool reflected;

  int spoke(const LocalNetShape& shape, int k) const
  {
    const int n = shape.spokes();
    return shape.closed ? ((this->reflected ? n - k : k) + this->turn) % n : this->reflected ? n - 1 - k : k;
  }
  int sector(const LocalNetShape& shape, int k) const
  {
    const int n = shape.sectors;
    return shape.closed ? ((this->reflected ? n - 1 - k : k) + this->turn) % n : this->reflected ? n - 1 - k : k;
  }
  std::vector<int> points(const LocalNetShape& shape) const
  {
    std::vector<int> map(shape.size(), 0);
    shape.forPoints([&](int a, int k, int i, int j) {
      map[a] = shape.sector(this->sector(shape, k), this->reflected ? j : i, this->reflected ? i : j);
    });
    return map;
  }
};

/// All turns and reflections of a fan with that many sectors, whatever its kinds.
std::vector<Symmetry> turnsAndReflections(const LocalNetShape& shape)
{
  std::vector<Symmetry> list;
  for (int turn = 0; turn < (shape.closed ? shape.sectors : 1); ++turn)
  {
    for (const bool reflected : { false, true })
    {
      list.push_back({ turn, reflected });
    }
  }
  return list;
}

/// The kinds of the spokes that a turn or reflection puts in the places of the given ones.
std::vector<SpokeKind> turnedKinds(const LocalNetShape& shape, const Symmetry& symmetry)
{
  std::vector<SpokeKind> kinds;
  for (int k = 0; k < shape.spokes(); ++k)
  {
    kinds.push_back(shape.kinds[symmetry.spoke(shape, k)]);
  }
  return kinds;
}

/// Those that leave the kinds as they are.
std::vector<Symmetry> symmetries(const LocalNetShape& shape)
{
  std::vector<Symmetry> list = turnsAndReflections(shape);
  list.erase(std::remove_if(list.begin(), list.end(),
               [&](const Symmetry& symmetry) { return turnedKinds(shape, symmetry) != shape.kinds; }),
    list.end());
  return list;
}

/// Gives all entries that a symmetry of the fan maps onto each other the mean of them, to the last bit. `rows` and
/// `columns`: per symmetry where a row or column goes.
void makeSymmetric(
  Eigen::MatrixXd& matrix, const std::vector<std::vector<int>>& rows, const std::vector<std::vector<int>>& columns)
{
  std::vector<bool> done(matrix.size(), false);
  for (int c = 0; c < matrix.cols(); ++c)
  {
    for (int r = 0; r < matrix.rows(); ++r)
    {
      if (done[r + matrix.rows() * c])
      {
        continue;
      }
      double sum = 0.0;
      for (std::size_t s = 0; s < rows.size(); ++s)
      {
        sum += matrix(rows[s][r], columns[s][c]);
      }
      const double mean = sum / static_cast<double>(rows.size());
      for (std::size_t s = 0; s < rows.size(); ++s)
      {
        matrix(rows[s][r], columns[s][c]) = std::abs(mean) < 1e-14 ? 0.0 : mean;
        done[rows[s][r] + matrix.rows() * columns[s][c]] = true;
      }
    }
  }
}

/// The least change of `points` in the form `weights` that takes the defects away: rows over the defects.
Eigen::MatrixXd leastChange(const LocalNetShape& shape, const std::vector<JoinCondition>& list,
  const std::vector<int>& points, const Eigen::MatrixXd& weights)
{
  const Eigen::MatrixXd A = matrixOf(list, points, shape.size());
  const Eigen::MatrixXd inverse = weights.ldlt().solve(A.transpose());
  Eigen::MatrixXd change = -inverse * pseudoInverse(A * inverse);

  const int perSpoke = static_cast<int>(list.size()) / (shape.closed ? shape.sectors : shape.sectors - 1);
  const int firstJoined = shape.closed ? 0 : 1;
  std::vector<std::vector<int>> rows, columns;
  std::map<int, int> place;
  for (std::size_t i = 0; i < points.size(); ++i)
  {
    place[points[i]] = static_cast<int>(i);
  }
  for (const Symmetry& symmetry : symmetries(shape))
  {
    const std::vector<int> map = symmetry.points(shape);
    rows.emplace_back();
    for (const int point : points)
    {
      rows.back().push_back(place.at(map[point]));
    }
    columns.emplace_back();
    for (std::size_t c = 0; c < list.size(); ++c)
    {
      const int k = symmetry.spoke(shape, firstJoined + static_cast<int>(c) / perSpoke) - firstJoined;
      columns.back().push_back(k * perSpoke + static_cast<int>(c) % perSpoke);
    }
  }
  makeSymmetric(change, rows, columns);
  return change;
}

void applyChange(const std::vector<JoinCondition>& list, const std::vector<int>& points, const Eigen::MatrixXd& change,
  std::vector<Vec3>& net)
{
  std::vector<Vec3> defects;
  defects.reserve(list.size());
  for (const JoinCondition& condition : list)
  {
    defects.push_back(condition.defect(net));
  }
  OrderFreeSum sum;
  for (std::size_t r = 0; r < points.size(); ++r)
  {
    sum.clear();
    sum.add(1.0, net[points[r]]);
    sum.add(1.0, Vec3::Zero()); // these are no affine combinations: not all terms may be equal
    for (std::size_t c = 0; c < defects.size(); ++c)
    {
      sum.add(change(r, c), defects[c]);
    }
    net[points[r]] = sum.result(1.0);
  }
}

} // namespace

std::vector<double> spokeKnots(SpokeKind kind, int count)
{
  if (kind < 3)
  {
    return volumeKnots(kind, true);
  }
  std::vector<double> knots{ 0.0, 0.0, 0.0, 0.0, 1.0, 1.0 };
  for (double next = 2.0; static_cast<int>(knots.size()) < count; ++next)
  {
    knots.push_back(next);
  }
  return knots;
}

Vec3 JoinCondition::defect(const std::vector<Vec3>& net) const
{
  Vec3 sum = Vec3::Zero();
  if (this->center >= 0)
  {
    const Vec3& c = net[this->center];
    sum = this->leftWeight * (net[this->left] - c) + this->rightWeight * (net[this->right] - c);
  }
  for (int i = 0; i < this->sideTerms; ++i)
  {
    sum += this->side[i].second * net[this->side[i].first];
  }
  return sum;
}

double LocalNetShape::delta(int k) const
{
  return this->kinds[k] == 1 ? 1.0 / 3.0 : this->kinds[k] == 2 ? 0.5 : 1.0;
}

bool LocalNetShape::operator<(const LocalNetShape& other) const
{
  return std::tie(this->closed, this->sectors, this->reach, this->kinds) <
    std::tie(other.closed, other.sectors, other.reach, other.kinds);
}

std::vector<NetRow> joinConditions(const LocalNetShape& shape)
{
  std::vector<NetRow> rows;
  for (const bool first : { true, false })
  {
    for (const JoinCondition& condition : conditions(shape, first))
    {
      rows.push_back(rowOf(condition));
    }
  }
  return rows;
}

Eigen::MatrixXd bendingForm(const LocalNetShape& shape, int order)
{
  Eigen::MatrixXd form = Eigen::MatrixXd::Zero(shape.size(), shape.size());
  const int m = shape.reach;
  for (int k = 0; k < shape.sectors; ++k)
  {
    std::array<Eigen::MatrixXd, 3> s, t;
    for (int d = 0; d <= order; ++d)
    {
      s[d] = gram(shape.kinds[k], m, d);
      t[d] = gram(shape.kinds[(k + 1) % shape.spokes()], m, d);
    }
    const auto term = [&](int ds, int dt, int i, int j, int a, int b) { return s[ds](i, a) * t[dt](j, b); };
    for (int j = 0; j <= m; ++j)
    {
      for (int i = 0; i <= m; ++i)
      {
        for (int b = 0; b <= m; ++b)
        {
          for (int a = 0; a <= m; ++a)
          {
            double& entry = form(shape.sector(k, i, j), shape.sector(k, a, b));
            entry += order == 1 ? term(1, 0, i, j, a, b) + term(0, 1, i, j, a, b)
                                : term(2, 0, i, j, a, b) + 2.0 * term(1, 1, i, j, a, b) + term(0, 2, i, j, a, b);
          }
        }
      }
    }
  }
  return form;
}

JoinRule::JoinRule(const LocalNetShape& given)
{
  // The same fan, begun at another spoke or in the other sense, must have the same matrix: that of the smallest kinds.
  LocalNetShape shape = given;
  Symmetry smallest{ 0, false };
  for (const Symmetry& symmetry : turnsAndReflections(given))
  {
    const std::vector<SpokeKind> kinds = turnedKinds(given, symmetry);
    if (kinds < shape.kinds)
    {
      shape.kinds = kinds;
      smallest = symmetry;
    }
  }
  if (shape.kinds != given.kinds)
  {
    this->Order = smallest.points(given);
  }
  this->Conditions = conditions(shape, false);
  this->FirstConditions = conditions(shape, true);
  for (int k = 0; k < shape.spokes(); ++k)
  {
    for (int i = 2; i <= shape.reach && shape.isJoined(k); ++i)
    {
      this->Points.push_back(shape.spoke(k, i));
    }
    if (shape.isJoined(k))
    {
      this->FirstPoints.push_back(shape.spoke(k, 1));
    }
  }
  shape.forPoints([&](int a, int, int i, int j) {
    if (i > 0 && j > 0)
    {
      this->Points.push_back(a);
    }
  });
  constexpr double LeastWeight = 0.01;
  const Eigen::MatrixXd form = bendingForm(shape, 1);
  Eigen::MatrixXd weights(this->Points.size(), this->Points.size());
  for (std::size_t r = 0; r < this->Points.size(); ++r)
  {
    for (std::size_t c = 0; c < this->Points.size(); ++c)
    {
      weights(r, c) = form(this->Points[r], this->Points[c]) + (r == c ? LeastWeight : 0.0);
    }
  }
  this->Change = leastChange(shape, this->Conditions, this->Points, weights);
  this->FirstChange = leastChange(shape, this->FirstConditions, this->FirstPoints,
    Eigen::MatrixXd::Identity(this->FirstPoints.size(), this->FirstPoints.size()));
}

void JoinRule::apply(std::vector<Vec3>& given, bool moveFirst) const
{
  if (this->Order.empty())
  {
    this->applyInOrder(given, moveFirst);
    return;
  }
  std::vector<Vec3> net(given.size());
  for (std::size_t i = 0; i < net.size(); ++i)
  {
    net[i] = given[this->Order[i]];
  }
  this->applyInOrder(net, moveFirst);
  for (std::size_t i = 0; i < net.size(); ++i)
  {
    given[this->Order[i]] = net[i];
  }
}

void JoinRule::applyInOrder(std::vector<Vec3>& net, bool moveFirst) const
{
  if (moveFirst)
  {
    applyChange(this->FirstConditions, this->FirstPoints, this->FirstChange, net);
  }
  applyChange(this->Conditions, this->Points, this->Change, net);
}

bool PccmRule::fits(const LocalNetShape& shape)
{
  return shape.closed && std::all_of(shape.kinds.begin(), shape.kinds.end(), [](SpokeKind kind) { return kind == 3; });
}

PccmRule::PccmRule(const LocalNetShape& shape)
  : Shape(shape)
  , First(conditions(shape, true))
{
  for (int k = 0; k < shape.sectors; ++k)
  {
    this->FirstPoints.push_back(shape.spoke(k, 1));
    this->DiagonalPoints.push_back(shape.sector(k, 1, 1));
  }
  // Per spoke (b), (c), then (d).
  const std::vector<JoinCondition> others = conditions(shape, false);
  const int perSpoke = static_cast<int>(others.size()) / shape.sectors;
  for (int c = 0; c < static_cast<int>(others.size()); ++c)
  {
    if (c % perSpoke == 0)
    {
      this->Diagonal.push_back(others[c]);
    }
    else if (c % perSpoke > 1)
    {
      this->Outer.push_back(others[c]);
    }
  }
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(shape.sectors, shape.sectors);
  this->FirstChange = leastChange(shape, this->First, this->FirstPoints, identity);
  this->DiagonalChange = leastChange(shape, this->Diagonal, this->DiagonalPoints, identity);
}

void PccmRule::apply(std::vector<Vec3>& net) const
{
  applyChange(this->First, this->FirstPoints, this->FirstChange, net);
  const int n = this->Shape.sectors;
  const Vec3 p = net[0];
  std::vector<Vec3> e, d;
  for (int k = 0; k < n; ++k)
  {
    e.push_back(net[this->Shape.spoke(k, 1)] - p);
    const Vec3 end = 0.5 * (net[this->Shape.spoke(k, 2)] + net[this->Shape.spoke(k, 3)]);
    d.push_back((end - p - 3.0 * e.back()) / 3.0);
  }
  if (n % 2 == 0)
  {
    OrderFreeSum even, odd;
    even.add(1.0, Vec3::Zero());
    odd.add(1.0, Vec3::Zero());
    for (int k = 0; k < n; ++k)
    {
      (k % 2 == 0 ? even : odd).add(1.0, d[k]);
    }
    const Vec3 alternating = (even.result(1.0) - odd.result(1.0)) / n;
    for (int k = 0; k < n; ++k)
    {
      d[k] -= k % 2 == 0 ? alternating : Vec3(-alternating);
    }
  }
  for (int k = 0; k < n; ++k)
  {
    net[this->Shape.spoke(k, 2)] = p + (2.0 * e[k] + d[k]);
    net[this->Shape.spoke(k, 3)] = p + (4.0 * e[k] + 5.0 * d[k]);
  }
  applyChange(this->Diagonal, this->DiagonalPoints, this->DiagonalChange, net);
  for (const JoinCondition& condition : this->Outer)
  {
    const Vec3 half = 0.5 * condition.defect(net);
    net[condition.left] -= half;
    net[condition.right] -= half;
  }
}

double joinDefect(const LocalNetShape& shape, const std::vector<Vec3>& net)
{
  double largest = 0.0, length = 0.0;
  for (const bool first : { true, false })
  {
    for (const JoinCondition& condition : conditions(shape, first))
    {
      largest = std::max(largest, condition.defect(net).norm());
    }
  }
  for (int k = 0; k < shape.spokes(); ++k)
  {
    length = std::max(length, (net[shape.spoke(k, 1)] - net[0]).norm());
  }
  return length > 0.0 ? largest / length : largest;
}

} // namespace bsv
