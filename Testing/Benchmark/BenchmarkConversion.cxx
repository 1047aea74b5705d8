// SPDX-License-Identifier: BSD-3-Clause
// The conversion alone, from a block complex to control nets: six blocks around a sphere, whose wall is a body, with
// eight extraordinary edges; points in double and in single precision.
#include "BenchmarkSupport.h"
#include "SphereCase.h"

#include "Conversion.h"

namespace
{

struct Conversion : bsvbench::SphereCase
{
  Conversion(bsv::Index points, bool isFloat)
    : SphereCase(points, isFloat)
    , complex(bsv::buildBlockComplex(this->blocks))
  {
    this->options.roles = { bsv::BoundaryRole::Body };
    for (const bsv::ComplexBlock& block : this->complex.blocks)
    {
      const bsv::Index size = bsv::Index(block.cells(0) + 3) * (block.cells(1) + 3) * (block.cells(2) + 3);
      this->points.emplace_back(3 * size);
      this->rules.emplace_back(size);
      this->nets.push_back({ this->points.back().data(), this->rules.back().data() });
      this->bytes += 25.0 * size;
      // Of a net as many bytes as the block's own: a copy of the input to the output.
      const bsv::GridView& view = block.points;
      this->copies.push_back({ this->points.back().data(),
        isFloat ? static_cast<const void*>(view.address<float>(0, 0, 0)) : view.address<double>(0, 0, 0),
        static_cast<std::size_t>(3 * view.size()) * (isFloat ? sizeof(float) : sizeof(double)) });
    }
  }

  bsv::BlockComplex complex;
  bsv::ConversionOptions options;
  std::vector<std::vector<double>> points;
  std::vector<std::vector<std::uint8_t>> rules;
  std::vector<bsv::ControlNetStorage> nets;
  std::vector<bsvbench::Copy> copies;
  double bytes = 0.0;
};

void conversion(benchmark::State& state, bool isFloat)
{
  Conversion& work = bsvbench::cached<Conversion>(
    2 * bsvbench::pointsOf(state) + isFloat, [&] { return Conversion(bsvbench::pointsOf(state), isFloat); });
  const bsv::Execution run = bsvbench::execution(bsvbench::threadsOf(state));
  const auto convert = [&] { bsv::convertToBSplineVolume(work.complex, work.options, work.nets, run); };
  bsvbench::reportMemory(state, convert);
  const double seconds = bsvbench::fastest(state, convert);
  bsvbench::report(state, seconds, work.bytes, work.copies);
}

void doubleSizes(benchmark::internal::Benchmark* benchmark)
{
  bsvbench::sizes(benchmark, 55.0);
}
BENCHMARK_CAPTURE(conversion, double, false)->Apply(doubleSizes);

void floatSizes(benchmark::internal::Benchmark* benchmark)
{
  bsvbench::sizes(benchmark, 65.0, 7);
}
BENCHMARK_CAPTURE(conversion, float, true)->Apply(floatSizes);

} // namespace

BENCHMARK_MAIN();
