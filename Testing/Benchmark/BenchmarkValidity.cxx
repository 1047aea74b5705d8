// SPDX-License-Identifier: BSD-3-Clause
// Spans of a tricubic block certified valid per second: jacobianBounds() on every instruction set of the machine,
// against a plain scalar kernel for the same coefficients, without bounds of rounding errors. `points` counts spans.
#include "Quality/JacobianBounds.h"

#include "Volume/BezierSegments.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace
{

using bsv::Index;

/// A cube with points moved at random by a twentieth of their distance.
struct Block
{
  explicit Block(Index spans)
  {
    const int cells = static_cast<int>(std::lround(std::cbrt(static_cast<double>(spans))));
    for (std::vector<double>& knots : this->volume.knots)
    {
      knots = bsv::clampedIntegerKnots(cells);
    }
    std::mt19937 random(1);
    std::uniform_real_distribution<double> noise(-0.05, 0.05);
    const std::vector<double>& t = this->volume.knots[0];
    const int n = this->volume.count(0);
    for (int i = 0; i < n * n * n; ++i)
    {
      for (const int at : { i % n, i / n % n, i / n / n })
      {
        this->points.push_back((t[at + 1] + t[at + 2] + t[at + 3]) / 3.0 + noise(random));
      }
    }
    this->volume.points = this->points.data();
    this->spans = Index(cells) * cells * cells;
  }

  bsv::BSplineVolume volume;
  std::vector<double> points;
  Index spans = 0;
};

void count(benchmark::State& state, Index spans)
{
  state.counters["spans"] = benchmark::Counter(
    static_cast<double>(spans), benchmark::Counter::kIsIterationInvariantRate, benchmark::Counter::kIs1000);
}

void certified(benchmark::State& state, bsv::InstructionSet instructions)
{
  const std::vector<bsv::InstructionSet>& sets = bsv::instructionSets();
  if (std::find(sets.begin(), sets.end(), instructions) == sets.end())
  {
    state.SkipWithError("this machine does not have it");
    return;
  }
  const Block block(state.range(0));
  std::vector<unsigned char> validity(block.spans);
  std::vector<double> lower(block.spans), upper(block.spans);
  bsv::JacobianOptions options;
  options.instructions = instructions;
  bsv::JacobianArrays arrays;
  arrays.validity = validity.data();
  arrays.lower = lower.data();
  arrays.upper = upper.data();
  for (auto _ : state)
  {
    const bsv::JacobianReport report = bsv::jacobianBounds(block.volume, "block", options, arrays);
    if (report.valid != block.spans)
    {
      state.SkipWithError("spans are not valid");
    }
  }
  count(state, block.spans);
}

/// Polynomial of fixed size in scaled Bernstein form.
template <int A, int B, int C>
struct Polynomial
{
  double c[C][B][A] = {};
};

/// sum += sign * a * b
template <int A, int B, int C, int D, int E, int F>
void multiplyAdd(Polynomial<A + D - 1, B + E - 1, C + F - 1>& sum, double sign, const Polynomial<A, B, C>& a,
  const Polynomial<D, E, F>& b)
{
  for (int k = 0; k < C; ++k)
  {
    for (int j = 0; j < B; ++j)
    {
      for (int i = 0; i < A; ++i)
      {
        const double x = sign * a.c[k][j][i];
        for (int n = 0; n < F; ++n)
        {
          for (int m = 0; m < E; ++m)
          {
            for (int l = 0; l < D; ++l)
            {
              sum.c[k + n][j + m][i + l] += x * b.c[n][m][l];
            }
          }
        }
      }
    }
  }
}

double binomial(int n, int k)
{
  return k == 0 ? 1.0 : binomial(n - 1, k - 1) * n / k;
}

/// Bernstein coefficients of det J of one span after the other, one number after the other.
class ScalarKernel
{
public:
  explicit ScalarKernel(const Block& block)
    : Volume(block.volume)
  {
    for (int d = 0; d < 3; ++d)
    {
      const std::vector<int> spans = bsv::nonEmptySpans(3, this->Volume.knots[d]);
      this->Weights[d].resize(16 * spans.size());
      for (std::size_t s = 0; s < spans.size(); ++s)
      {
        bsv::bezierWeights(3, this->Volume.knots[d], spans[s], this->Weights[d].data() + 16 * s);
      }
    }
    for (int n = 0; n < 9; ++n)
    {
      this->Scale[n] = 1.0 / binomial(8, n);
    }
  }

  /// Smallest and largest coefficient of span (i, j, k).
  void operator()(int i, int j, int k, double& low, double& high)
  {
    Polynomial<4, 4, 4> b[3];
    const int n = this->Volume.count(0);
    for (int c = 0; c < 64; ++c)
    {
      const double* x = this->Volume.points +
        3 * (i + c % 4 + Index(n) * (j + c / 4 % 4 + Index(this->Volume.count(1)) * (k + c / 16)));
      for (int axis = 0; axis < 3; ++axis)
      {
        (&b[axis].c[0][0][0])[c] = x[axis];
      }
    }
    const double* weights[3] = { this->Weights[0].data() + 16 * i, this->Weights[1].data() + 16 * j,
      this->Weights[2].data() + 16 * k };
    for (Polynomial<4, 4, 4>& component : b)
    {
      for (int d = 0; d < 3; ++d)
      {
        const int stride = d == 0 ? 1 : d == 1 ? 4 : 16;
        double* values = &component.c[0][0][0];
        for (int row = 0; row < 16; ++row)
        {
          double* first = values + (d == 0 ? 4 * row : d == 1 ? row / 4 * 16 + row % 4 : row);
          double out[4];
          for (int m = 0; m < 4; ++m)
          {
            const double* w = weights[d] + 4 * m;
            out[m] = w[0] * first[0] + w[1] * first[stride] + w[2] * first[2 * stride] + w[3] * first[3 * stride];
          }
          for (int m = 0; m < 4; ++m)
          {
            first[m * stride] = out[m];
          }
        }
      }
    }
    Polynomial<3, 4, 4> u[3];
    Polynomial<4, 3, 4> v[3];
    Polynomial<4, 4, 3> w[3];
    constexpr double Two[3] = { 3, 6, 3 }; // degree times binomials of degree 2
    constexpr double Three[4] = { 1, 3, 3, 1 };
    for (int axis = 0; axis < 3; ++axis)
    {
      const auto& p = b[axis].c;
      for (int r = 0; r < 3; ++r)
      {
        for (int s = 0; s < 4; ++s)
        {
          for (int t = 0; t < 4; ++t)
          {
            const double scale = Two[r] * Three[s] * Three[t];
            u[axis].c[t][s][r] = scale * (p[t][s][r + 1] - p[t][s][r]);
            v[axis].c[t][r][s] = scale * (p[t][r + 1][s] - p[t][r][s]);
            w[axis].c[r][t][s] = scale * (p[r + 1][t][s] - p[r][t][s]);
          }
        }
      }
    }
    Polynomial<9, 9, 9> determinant;
    for (int axis = 0; axis < 3; ++axis)
    {
      const int second = (axis + 1) % 3;
      const int third = (axis + 2) % 3;
      Polynomial<6, 6, 7> minor;
      multiplyAdd(minor, 1.0, u[second], v[third]);
      multiplyAdd(minor, -1.0, u[third], v[second]);
      multiplyAdd(determinant, 1.0, minor, w[axis]);
    }
    low = high = determinant.c[0][0][0];
    for (int t = 0; t < 9; ++t)
    {
      for (int s = 0; s < 9; ++s)
      {
        for (int r = 0; r < 9; ++r)
        {
          const double value = determinant.c[t][s][r] * (this->Scale[r] * this->Scale[s] * this->Scale[t]);
          low = std::min(low, value);
          high = std::max(high, value);
        }
      }
    }
  }

private:
  const bsv::BSplineVolume& Volume;
  std::array<std::vector<double>, 3> Weights;
  std::array<double, 9> Scale;
};

void scalar(benchmark::State& state)
{
  const Block block(state.range(0));
  std::vector<double> lower(block.spans), upper(block.spans);
  const int cells = block.volume.count(0) - 3;
  for (auto _ : state)
  {
    ScalarKernel kernel(block);
    for (Index s = 0; s < block.spans; ++s)
    {
      kernel(static_cast<int>(s % cells), static_cast<int>(s / cells % cells), static_cast<int>(s / cells / cells),
        lower[s], upper[s]);
    }
  }
  // The same bounds, or it is no comparison.
  std::vector<double> certifiedLower(block.spans);
  bsv::JacobianArrays arrays;
  arrays.lower = certifiedLower.data();
  bsv::jacobianBounds(block.volume, "block", {}, arrays);
  for (Index s = 0; s < block.spans; ++s)
  {
    if (!(std::abs(lower[s] - certifiedLower[s]) < 1e-10))
    {
      state.SkipWithError("the kernels disagree");
    }
  }
  count(state, block.spans);
}

void sizes(benchmark::internal::Benchmark* benchmark)
{
  benchmark->ArgNames({ "points", "threads" })->Unit(benchmark::kMillisecond);
  benchmark->Args({ 10000, 1 })->Args({ 250000, 1 });
}

BENCHMARK(scalar)->Apply(sizes);
BENCHMARK_CAPTURE(certified, portable, bsv::InstructionSet::Portable)->Apply(sizes);
BENCHMARK_CAPTURE(certified, avx2, bsv::InstructionSet::Avx2)->Apply(sizes);
BENCHMARK_CAPTURE(certified, avx512, bsv::InstructionSet::Avx512)->Apply(sizes);

} // namespace

BENCHMARK_MAIN();
