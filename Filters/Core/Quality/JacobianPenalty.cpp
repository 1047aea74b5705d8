// SPDX-License-Identifier: BSD-3-Clause
#include "Quality/JacobianPenalty.h"

#include "Base/Numbers.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace bsv
{

namespace
{

/// det J has the degree 8 per direction: as many nodes determine it.
constexpr int Nodes = 9;

/// A matrix of `rows` x Columns, by rows.
template <int Rows, int Columns>
using Matrix = std::array<std::array<double, Columns>, Rows>;

double binomial(int n, int k)
{
  double result = 1.0;
  for (int i = 1; i <= k; ++i)
  {
    result = result * (n - k + i) / i;
  }
  return result;
}

double bernstein(int degree, int i, double t)
{
  return binomial(degree, i) * std::pow(t, i) * std::pow(1.0 - t, degree - i);
}

struct Tables
{
  /// Of the cubic Bernstein polynomials at the nodes.
  Matrix<Nodes, 4> values, slopes;
  /// From values at the nodes to coefficients of degree 8.
  Matrix<Nodes, Nodes> interpolation;

  Tables()
  {
    Eigen::Matrix<double, Nodes, Nodes> matrix;
    for (int q = 0; q < Nodes; ++q)
    {
      const double t = 0.5 * (1.0 - std::cos((q + 0.5) * Pi / Nodes));
      for (int i = 0; i < 4; ++i)
      {
        this->values[q][i] = bernstein(3, i, t);
        this->slopes[q][i] = 3.0 * ((i > 0 ? bernstein(2, i - 1, t) : 0.0) - (i < 3 ? bernstein(2, i, t) : 0.0));
      }
      for (int c = 0; c < Nodes; ++c)
      {
        matrix(q, c) = bernstein(Nodes - 1, c, t);
      }
    }
    const Eigen::Matrix<double, Nodes, Nodes> inverse = matrix.inverse();
    for (int c = 0; c < Nodes; ++c)
    {
      for (int q = 0; q < Nodes; ++q)
      {
        this->interpolation[c][q] = inverse(c, q);
      }
    }
  }
};

/// Applies one matrix per direction to an array of In^3 values, first direction fastest.
template <int Out, int In>
std::vector<double> tensor(const std::vector<double>& from, const std::array<const Matrix<Out, In>*, 3>& matrices)
{
  std::vector<double> values = from;
  std::array<int, 3> counts{ In, In, In };
  for (int d = 0; d < 3; ++d)
  {
    const int inner = d == 0 ? 1 : d == 1 ? counts[0] : counts[0] * counts[1];
    const int outer = static_cast<int>(values.size()) / (inner * In);
    std::vector<double> next(static_cast<std::size_t>(inner) * Out * outer, 0.0);
    for (int o = 0; o < outer; ++o)
    {
      for (int r = 0; r < Out; ++r)
      {
        double* const to = next.data() + static_cast<std::size_t>(inner) * (r + Out * o);
        for (int c = 0; c < In; ++c)
        {
          const double weight = (*matrices[d])[r][c];
          const double* const row = values.data() + static_cast<std::size_t>(inner) * (c + In * o);
          for (int i = 0; i < inner; ++i)
          {
            to[i] += weight * row[i];
          }
        }
      }
    }
    counts[d] = Out;
    values = std::move(next);
  }
  return values;
}

template <std::size_t Rows, std::size_t Columns>
std::array<std::array<double, Rows>, Columns> transposed(const std::array<std::array<double, Columns>, Rows>& matrix)
{
  std::array<std::array<double, Rows>, Columns> result;
  for (std::size_t r = 0; r < Rows; ++r)
  {
    for (std::size_t c = 0; c < Columns; ++c)
    {
      result[c][r] = matrix[r][c];
    }
  }
  return result;
}

Matrix<Nodes, 4> product(const Matrix<Nodes, 4>& a, const std::array<double, 16>& b)
{
  Matrix<Nodes, 4> result{};
  for (int q = 0; q < Nodes; ++q)
  {
    for (int i = 0; i < 4; ++i)
    {
      for (int k = 0; k < 4; ++k)
      {
        result[q][i] += a[q][k] * b[4 * k + i];
      }
    }
  }
  return result;
}

} // namespace

SpanPenalty spanPenalty(
  const SpanControl& control, const std::array<std::array<double, 16>, 3>& bezier, double scale, double threshold)
{
  static const Tables tables;
  constexpr int Count = Nodes * Nodes * Nodes;
  std::array<Matrix<Nodes, 4>, 3> values, slopes;
  for (int d = 0; d < 3; ++d)
  {
    values[d] = product(tables.values, bezier[d]);
    slopes[d] = product(tables.slopes, bezier[d]);
  }

  // Derivatives at the nodes: row = direction, column = component.
  std::array<std::array<std::vector<double>, 3>, 3> derivatives;
  for (int c = 0; c < 3; ++c)
  {
    std::vector<double> component(64);
    for (int p = 0; p < 64; ++p)
    {
      component[p] = control[p][c] - control[0][c];
    }
    for (int d = 0; d < 3; ++d)
    {
      std::array<const Matrix<Nodes, 4>*, 3> matrices{ &values[0], &values[1], &values[2] };
      matrices[d] = &slopes[d];
      derivatives[d][c] = tensor<Nodes, 4>(component, matrices);
    }
  }
  const auto at = [&](int d, int q) { return Vec3(derivatives[d][0][q], derivatives[d][1][q], derivatives[d][2][q]); };
  std::vector<double> determinants(Count);
  for (int q = 0; q < Count; ++q)
  {
    determinants[q] = at(0, q).dot(at(1, q).cross(at(2, q)));
  }
  const Matrix<Nodes, Nodes>& inverse = tables.interpolation;
  std::vector<double> coefficients = tensor<Nodes, Nodes>(determinants, { &inverse, &inverse, &inverse });

  SpanPenalty result;
  result.least = coefficients[0] / scale;
  for (double& coefficient : coefficients)
  {
    const double ratio = coefficient / scale;
    result.least = std::min(result.least, ratio);
    const double lack = std::max(0.0, threshold - ratio);
    result.value += lack * lack;
    coefficient = -2.0 * lack / scale;
  }

  const Matrix<Nodes, Nodes> adjoint = transposed(inverse);
  const std::vector<double> weights = tensor<Nodes, Nodes>(coefficients, { &adjoint, &adjoint, &adjoint });
  result.gradient.fill(Vec3::Zero());
  for (int d = 0; d < 3; ++d)
  {
    std::array<std::vector<double>, 3> terms;
    terms.fill(std::vector<double>(Count));
    for (int q = 0; q < Count; ++q)
    {
      const Vec3 term = weights[q] * at((d + 1) % 3, q).cross(at((d + 2) % 3, q));
      for (int c = 0; c < 3; ++c)
      {
        terms[c][q] = term[c];
      }
    }
    std::array<Matrix<4, Nodes>, 3> matrices;
    for (int other = 0; other < 3; ++other)
    {
      matrices[other] = transposed(other == d ? slopes[other] : values[other]);
    }
    for (int c = 0; c < 3; ++c)
    {
      const std::vector<double> part = tensor<4, Nodes>(terms[c], { &matrices[0], &matrices[1], &matrices[2] });
      for (int p = 0; p < 64; ++p)
      {
        result.gradient[p][c] += part[p];
      }
    }
  }
  return result;
}

} // namespace bsv
