// SPDX-License-Identifier: BSD-3-Clause
// Samples of one cubic block at levels 0 to 3, of its derivative along i at level 3, and its Bezier points. `points`
// counts what is computed.
#include "BenchmarkSupport.h"

#include "Volume/BezierExtraction.h"
#include "Volume/Sampling.h"

namespace
{

struct Block
{
  explicit Block(const std::array<int, 3>& cells)
  {
    for (int d = 0; d < 3; ++d)
    {
      this->volume.knots[d] = bsv::clampedIntegerKnots(cells[d]);
    }
    const int counts[3] = { this->volume.count(0), this->volume.count(1), this->volume.count(2) };
    this->net.reserve(std::size_t(3) * counts[0] * counts[1] * counts[2]);
    for (int k = 0; k < counts[2]; ++k)
    {
      for (int j = 0; j < counts[1]; ++j)
      {
        for (int i = 0; i < counts[0]; ++i)
        {
          this->net.insert(this->net.end(), { i + 0.1 * j, j + 0.2 * k, k + 0.3 * i });
        }
      }
    }
    this->volume.points = this->net.data();
  }

  bsv::BSplineVolume volume;
  std::vector<double> net;
};

void sampling(benchmark::State& state, int level, std::array<int, 3> derivative)
{
  // As many samples as asked for, with whole spans in every direction.
  const int cells = std::max(1, static_cast<int>(std::lround(std::cbrt(double(bsvbench::pointsOf(state))))) >> level);
  const Block block({ cells, cells, cells });
  const std::array<int, 3> counts = bsv::sampleCounts(block.volume, level, "block");
  const std::size_t values = std::size_t(3) * counts[0] * counts[1] * counts[2];
  std::vector<double> samples(values);
  const bsv::Execution run = bsvbench::execution(bsvbench::threadsOf(state));
  const auto sample = [&] { bsv::sample(block.volume, level, derivative, samples.data(), run); };
  bsvbench::reportMemory(state, sample);
  const double seconds = bsvbench::fastest(state, sample);
  state.counters["points"] = static_cast<double>(values) / 3.0;
  bsvbench::report(state, seconds, 8.0 * values, { bsvbench::half(samples.data(), values) });
}

void bezierPoints(benchmark::State& state)
{
  const int cells = std::max(1, static_cast<int>(std::lround(std::cbrt(double(bsvbench::pointsOf(state))))) / 3);
  const Block block({ cells, cells, cells });
  const std::vector<bsv::BSplineVolume> volumes{ block.volume };
  const std::vector<bsv::Interface> none;
  const bsv::Execution run = bsvbench::execution(bsvbench::threadsOf(state));
  const bsv::Ijk counts = bsv::bezierCounts(block.volume, "block");
  const std::size_t values = std::size_t(3) * counts[0] * counts[1] * counts[2];
  std::vector<double> points(values);
  const auto extract = [&] {
    const bsv::BezierExtraction extraction(volumes, &none, bsv::BezierCells::Volume, run);
    extraction.evaluate(points.data(), nullptr, run);
  };
  bsvbench::reportMemory(state, extract);
  const double seconds = bsvbench::fastest(state, extract);
  state.counters["points"] = static_cast<double>(values) / 3.0;
  bsvbench::report(state, seconds, 8.0 * values, { bsvbench::half(points.data(), values) });
}

void sampleSizes(benchmark::internal::Benchmark* benchmark)
{
  bsvbench::sizes(benchmark, 50.0);
}
BENCHMARK_CAPTURE(sampling, level0, 0, { 0, 0, 0 })->Apply(sampleSizes);
BENCHMARK_CAPTURE(sampling, level1, 1, { 0, 0, 0 })->Apply(sampleSizes);
BENCHMARK_CAPTURE(sampling, level2, 2, { 0, 0, 0 })->Apply(sampleSizes);
BENCHMARK_CAPTURE(sampling, level3, 3, { 0, 0, 0 })->Apply(sampleSizes);
BENCHMARK_CAPTURE(sampling, level3derivative, 3, { 1, 0, 0 })->Apply(sampleSizes);
BENCHMARK(bezierPoints)->Apply(sampleSizes);

} // namespace

BENCHMARK_MAIN();
