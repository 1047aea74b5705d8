// SPDX-License-Identifier: BSD-3-Clause
// The conversion alone, from a block complex to control nets: six blocks around a sphere, whose wall is a body, with
// eight extraordinary edges, points in double and in single precision; the same without the check of spans near special
// rules, and with double knots (exact G1); and a curved box in blocks of 17^3 points, and the same in one block.
#include "BenchmarkSupport.h"
#include "MeshSizes.h"

#include "Conversion/Conversion.h"

namespace
{

struct Conversion
{
  Conversion(const bsv::BlockMesh& mesh, bsv::Continuity continuity = bsv::Continuity::SingleKnots)
    : complex(bsv::buildBlockComplex(mesh))
  {
    this->options.roles.assign(this->complex.boundaryNames.size(), bsv::BoundaryRole::Body);
    this->options.continuity = continuity;
    const auto knots = bsv::conversionKnots(this->complex, this->options);
    for (std::size_t b = 0; b < knots.size(); ++b)
    {
      const bsv::ComplexBlock& block = this->complex.blocks[b];
      bsv::Index size = 1;
      for (int d = 0; d < 3; ++d)
      {
        size *= static_cast<bsv::Index>(knots[b][d].size()) - 4;
      }
      this->points.emplace_back(3 * size);
      this->rules.emplace_back(size);
      this->nets.push_back({ this->points.back().data(), this->rules.back().data() });
      this->bytes += 25.0 * size;
      // A copy of the input to the output.
      const bsv::GridView& view = block.points;
      this->meshPoints += view.size();
      this->copies.push_back({ this->points.back().data(),
        view.isFloat() ? static_cast<const void*>(view.address<float>(0, 0, 0)) : view.address<double>(0, 0, 0),
        static_cast<std::size_t>(3 * view.size()) * (view.isFloat() ? sizeof(float) : sizeof(double)) });
    }
  }

  bsv::BlockComplex complex;
  bsv::ConversionOptions options;
  std::vector<std::vector<double>> points;
  std::vector<std::vector<std::uint8_t>> rules;
  std::vector<bsv::ControlNetStorage> nets;
  std::vector<bsvbench::Copy> copies;
  double bytes = 0.0;
  bsv::Index meshPoints = 0;
};

void run(benchmark::State& state, Conversion& work)
{
  const bsv::Execution run = bsvbench::execution(bsvbench::threadsOf(state));
  const auto convert = [&] { bsv::convertToBSplineVolume(work.complex, work.options, work.nets, run); };
  bsvbench::reportMemory(state, convert);
  const double seconds = bsvbench::fastest(state, convert);
  state.counters["points"] = static_cast<double>(work.meshPoints);
  bsvbench::report(state, seconds, work.bytes, work.copies);
}

struct SphereConversion
  : bsvbench::SphereCase
  , Conversion
{
  SphereConversion(bsv::Index points, bool isFloat, bsv::Continuity continuity)
    : SphereCase(points, isFloat)
    , Conversion(this->blocks, continuity)
  {
  }
};

void conversion(benchmark::State& state, bool isFloat, bsv::CheckSpans check,
  bsv::Continuity continuity = bsv::Continuity::SingleKnots)
{
  const bsv::Index points = bsvbench::pointsOf(state);
  const bool exact = continuity == bsv::Continuity::ExactG1;
  SphereConversion& work = bsvbench::cached<SphereConversion>(
    4 * points + 2 * exact + isFloat, [&] { return SphereConversion(points, isFloat, continuity); });
  work.options.checkSpans = check;
  run(state, work);
}

struct BoxConversion
{
  BoxConversion(bsv::Index points, int cells)
    : mesh(bsvbench::boxOfBlocks(points, cells))
    , conversion(this->mesh.mesh())
  {
  }

  meshcases::MeshCase mesh;
  Conversion conversion;
};

/// @param cells per direction of a block; 0: one block.
void conversionOfBox(benchmark::State& state, int cells)
{
  const bsv::Index points = bsvbench::pointsOf(state);
  const int size = cells > 0 ? cells : static_cast<int>(std::lround(std::cbrt(double(points)))) - 1;
  run(state,
    bsvbench::cached<BoxConversion>(2 * points + (cells > 0), [&] { return BoxConversion(points, size); }).conversion);
}

void doubleSizes(benchmark::internal::Benchmark* benchmark)
{
  bsvbench::sizes(benchmark, 55.0);
}
BENCHMARK_CAPTURE(conversion, double, false, bsv::CheckSpans::SpecialRules)->Apply(doubleSizes);
BENCHMARK_CAPTURE(conversion, unchecked, false, bsv::CheckSpans::None)->Apply(doubleSizes);
BENCHMARK_CAPTURE(conversion, exactG1, false, bsv::CheckSpans::SpecialRules, bsv::Continuity::ExactG1)
  ->Apply(doubleSizes);

void floatSizes(benchmark::internal::Benchmark* benchmark)
{
  bsvbench::sizes(benchmark, 65.0, 7);
}
BENCHMARK_CAPTURE(conversion, float, true, bsv::CheckSpans::SpecialRules)->Apply(floatSizes);

BENCHMARK_CAPTURE(conversionOfBox, blocks of 17 ^ 3, 16)->Apply(doubleSizes);
BENCHMARK_CAPTURE(conversionOfBox, one block, 0)->Apply(doubleSizes);

} // namespace

BENCHMARK_MAIN();
