// SPDX-License-Identifier: BSD-3-Clause
// Writing and reading the topology file, text and binary: six blocks around a sphere.
#include "FileComparison.h"
#include "MeshSizes.h"

#include "Conversion/Conversion.h"
#include "Quadflow/QuadflowFormat.h"

namespace
{

/// A converted sphere, with its control points.
struct Volume
{
  explicit Volume(bsv::Index count)
  {
    const bsvbench::SphereCase sphere(count, false);
    const bsv::BlockComplex complex = bsv::buildBlockComplex(sphere.blocks);
    std::vector<bsv::ControlNetStorage> nets;
    bsv::QuadflowInput input;
    for (const bsv::ComplexBlock& block : complex.blocks)
    {
      bsv::BSplineVolume volume;
      std::size_t size = 1;
      for (int d = 0; d < 3; ++d)
      {
        volume.knots[d] = bsv::clampedIntegerKnots(block.cells(d));
        size *= volume.count(d);
      }
      this->points.emplace_back(3 * size);
      this->rules.emplace_back(size);
      nets.push_back({ this->points.back().data(), this->rules.back().data() });
      volume.points = this->points.back().data();
      input.volumes.push_back(volume);
      input.names.push_back(block.name);
      input.rules.push_back(this->rules.back().data());
    }
    bsv::ConversionOptions options;
    options.roles = { bsv::BoundaryRole::Body };
    bsv::convertToBSplineVolume(complex, options, nets);
    this->data = bsv::makeQuadflowCase(input);
  }

  std::vector<std::vector<double>> points;
  std::vector<std::vector<std::uint8_t>> rules;
  bsv::QuadflowCase data;
};

Volume& volume(const benchmark::State& state)
{
  const bsv::Index count = bsvbench::pointsOf(state);
  return bsvbench::cached<Volume>(count, [&] { return Volume(count); });
}

void writing(benchmark::State& state, const bsv::QuadflowOptions& options)
{
  const Volume& work = volume(state);
  const std::string path = bsvbench::folder() / "case.qfmb";
  const auto write = [&] { bsv::writeQuadflow(work.data, path, options); };
  const double seconds = bsvbench::fastest(state, write, bsvbench::Clock::Wall, [] {});
  bsvbench::reportFile(state, seconds, path, true);
}

void reading(benchmark::State& state, const bsv::QuadflowOptions& options)
{
  Volume& work = volume(state);
  const std::string path = bsvbench::folder() / "case.qfmb";
  bsv::writeQuadflow(work.data, path, options);
  const auto storage = [&](int block, const std::array<int, 3>&) { return work.points[block].data(); };
  const auto read = [&] { benchmark::DoNotOptimize(bsv::readQuadflow(path, storage).blocks.data()); };
  const double seconds = bsvbench::fastest(state, read, bsvbench::Clock::Wall, [&] { bsvbench::evict(path); });
  bsvbench::reportFile(state, seconds, path, false);
}

bsv::QuadflowOptions binaryOptions()
{
  bsv::QuadflowOptions options;
  options.binary = true;
  return options;
}
BENCHMARK_CAPTURE(writing, qfmb_text, bsv::QuadflowOptions())->Apply(bsvbench::fileSizes);
BENCHMARK_CAPTURE(reading, qfmb_text, bsv::QuadflowOptions())->Apply(bsvbench::fileSizes);
BENCHMARK_CAPTURE(writing, qfmb_binary, binaryOptions())->Apply(bsvbench::fileSizes);
BENCHMARK_CAPTURE(reading, qfmb_binary, binaryOptions())->Apply(bsvbench::fileSizes);

} // namespace

BENCHMARK_MAIN();
