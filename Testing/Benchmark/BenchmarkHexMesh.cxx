// SPDX-License-Identifier: BSD-3-Clause
// Blocks of unstructured hexahedra: five blocks around an edge, numbered as a mesh generator does, or at random.
#include "BenchmarkSupport.h"

#include "Complex/BaseComplex.h"

#include <numeric>
#include <random>

namespace
{

using bsv::Index;

struct HexCase
{
  /// `points` in all, about.
  HexCase(Index wanted, bool random)
  {
    constexpr int Sectors = 5;
    // Sectors * n^2 + Sectors * n + 1 points in each of 2 n layers.
    const Index n = std::max<Index>(2, std::lround(std::cbrt(double(wanted) / (2 * Sectors))));
    const Index layer = Sectors * n * (n + 1) + 1;
    const double angle = 2.0 * std::acos(-1.0) / Sectors;
    // Points (i > 0, j >= 0) of a sector; those of i = 0 belong to the sector before, (0, 0) to all.
    const auto number = [&](int s, Index i, Index j, Index k) {
      if (i == 0)
      {
        std::swap(i, j);
        s = (s + Sectors - 1) % Sectors;
      }
      return static_cast<bsv::HexId>(k * layer + (i == 0 ? 0 : 1 + (s * n + i - 1) * (n + 1) + j));
    };
    this->points.resize(layer * 2 * n);
    for (Index k = 0; k < 2 * n; ++k)
    {
      for (int s = 0; s < Sectors; ++s)
      {
        for (Index i = 0; i <= n; ++i)
        {
          for (Index j = 0; j <= n; ++j)
          {
            const double u = double(i) / n;
            const double v = double(j) / n;
            this->points[number(s, i, j, k)] = bsv::Vec3(u * std::cos((s + 1) * angle) + v * std::cos(s * angle),
              u * std::sin((s + 1) * angle) + v * std::sin(s * angle), double(k) / n);
          }
        }
      }
    }
    for (Index k = 0; k + 1 < 2 * n; ++k)
    {
      for (int s = 0; s < Sectors; ++s)
      {
        for (Index i = 0; i < n; ++i)
        {
          for (Index j = 0; j < n; ++j)
          {
            for (int c = 0; c < 8; ++c)
            {
              this->corners.push_back(number(s, i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)));
            }
          }
        }
      }
    }
    if (random)
    {
      this->shuffle();
    }
  }

  void shuffle()
  {
    std::mt19937 engine(1);
    std::vector<bsv::HexId> order(this->points.size());
    std::iota(order.begin(), order.end(), bsv::HexId(0));
    std::shuffle(order.begin(), order.end(), engine);
    std::vector<bsv::Vec3> places(this->points.size());
    for (std::size_t p = 0; p < order.size(); ++p)
    {
      places[order[p]] = this->points[p];
    }
    this->points.swap(places);
    std::vector<bsv::HexId> cells(this->corners.size() / 8);
    std::iota(cells.begin(), cells.end(), bsv::HexId(0));
    std::shuffle(cells.begin(), cells.end(), engine);
    std::vector<bsv::HexId> moved;
    moved.reserve(this->corners.size());
    for (bsv::HexId cell : cells)
    {
      for (int c = 0; c < 8; ++c)
      {
        moved.push_back(order[this->corners[8 * Index(cell) + c]]);
      }
    }
    this->corners.swap(moved);
  }

  std::vector<bsv::Vec3> points;
  std::vector<bsv::HexId> corners;
};

/// The time is compared with that of a copy of the points and cells.
void hexMesh(benchmark::State& state, bool random)
{
  const Index points = bsvbench::pointsOf(state);
  const HexCase& work = bsvbench::cached<HexCase>(2 * points + random, [&] { return HexCase(points, random); });
  const bsv::Execution run = bsvbench::execution(bsvbench::threadsOf(state));
  bsv::HexMesh mesh;
  const auto prepare = [&] {
    mesh.corners = work.corners;
    mesh.points = bsv::GridView(work.points.data()->data(), { static_cast<int>(work.points.size()), 1, 1 });
  };
  const auto build = [&] {
    const bsv::BaseComplex complex = bsv::baseComplex(mesh, {}, run);
    if (complex.blocks.size() != 5)
    {
      state.SkipWithError("there are 5 blocks");
    }
  };
  prepare();
  bsvbench::reportMemory(state, build);
  const double seconds = bsvbench::fastest(state, build, bsvbench::clockFor(bsvbench::threadsOf(state)), prepare);
  std::vector<double> buffer(3 * work.points.size() + work.corners.size() / 2);
  bsvbench::report(state, seconds, 8.0 * buffer.size(), { bsvbench::half(buffer.data(), buffer.size()) });
}

void hexMeshSizes(benchmark::internal::Benchmark* benchmark)
{
  bsvbench::sizes(benchmark, 300.0, 7);
}
BENCHMARK_CAPTURE(hexMesh, natural, false)->Apply(hexMeshSizes);
BENCHMARK_CAPTURE(hexMesh, random, true)->Apply(hexMeshSizes);

} // namespace

BENCHMARK_MAIN();
