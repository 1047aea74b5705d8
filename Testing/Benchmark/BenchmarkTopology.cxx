// SPDX-License-Identifier: BSD-3-Clause
// Checking, gluing and numbering a mesh: few large blocks around a sphere, and 10,000 blocks of 4^3 cells.
#include "BenchmarkSupport.h"
#include "SphereCase.h"

namespace
{

/// The time is compared with that of a copy of the mesh's points.
void run(benchmark::State& state, const bsv::BlockMesh& mesh)
{
  const bsv::Execution run = bsvbench::execution(bsvbench::threadsOf(state));
  const auto build = [&] { benchmark::DoNotOptimize(bsv::buildBlockComplex(mesh, {}, run).blocks.data()); };
  bsvbench::reportMemory(state, build);
  const double seconds = bsvbench::fastest(state, build);

  std::size_t values = 0;
  for (const bsv::MeshBlock& block : mesh.blocks)
  {
    values += 3 * static_cast<std::size_t>(block.points.size());
  }
  std::vector<double> buffer(std::min(values, std::size_t(1) << 27));
  bsvbench::report(state, seconds, 8.0 * values, { bsvbench::half(buffer.data(), buffer.size()) });
}

void topology(benchmark::State& state)
{
  using bsvbench::SphereCase;
  const bsv::Index points = bsvbench::pointsOf(state);
  run(state, bsvbench::cached<SphereCase>(points, [&] { return SphereCase(points, false); }).blocks);
}

void topologySizes(benchmark::internal::Benchmark* benchmark)
{
  bsvbench::sizes(benchmark, 40.0);
}
BENCHMARK(topology)->Apply(topologySizes);

/// 25 x 20 x 20 blocks, shuffled; contacts found from coincident points or declared.
void topologyOfBlocks(benchmark::State& state, bool declared)
{
  struct Case
  {
    meshcases::MeshCase mesh;
    bsv::BlockMesh blocks;
  };
  const Case& work = bsvbench::cached<Case>(declared, [&] {
    const auto cuts = [](int blocks) {
      std::vector<int> result;
      for (int n = 1; n < blocks; ++n)
      {
        result.push_back(4 * n);
      }
      return result;
    };
    Case made;
    made.mesh = meshcases::cutBox({ 100, 80, 80 }, { cuts(25), cuts(20), cuts(20) }, [](const bsv::Vec3& x) {
      return meshcases::wavy(0.03 * x - bsv::Vec3::Constant(1.5));
    });
    meshcases::shuffle(made.mesh, 1);
    if (declared)
    {
      meshcases::declareAll(made.mesh);
    }
    made.blocks = made.mesh.mesh();
    return made;
  });
  run(state, work.blocks);
}
void blockSizes(benchmark::internal::Benchmark* benchmark)
{
  // 10,000 blocks of 5^3 points
  benchmark->ArgNames({ "points", "threads" })->UseRealTime()->Unit(benchmark::kMillisecond);
  benchmark->Args({ 1250000, 1 })->Args({ 1250000, 2 });
}
BENCHMARK_CAPTURE(topologyOfBlocks, found, false)->Apply(blockSizes);
BENCHMARK_CAPTURE(topologyOfBlocks, declared, true)->Apply(blockSizes);

} // namespace

BENCHMARK_MAIN();
