// SPDX-License-Identifier: BSD-3-Clause
// Checking, gluing and numbering a mesh: few large blocks around a sphere, and up to 10,648 blocks of 4^3 cells.
#include "BenchmarkSupport.h"
#include "MeshSizes.h"

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

/// Shuffled blocks; contacts found from coincident points or declared.
void topologyOfBlocks(benchmark::State& state, bool declared)
{
  struct Case
  {
    meshcases::MeshCase mesh;
    bsv::BlockMesh blocks;
  };
  const bsv::Index points = bsvbench::pointsOf(state);
  const Case& work = bsvbench::cached<Case>(2 * points + declared, [&] {
    Case made;
    made.mesh = bsvbench::boxOfBlocks(points, 4);
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
  // The last has 22^3 = 10,648 blocks.
  benchmark->ArgNames({ "points", "threads" })->UseRealTime()->Unit(benchmark::kMillisecond);
  for (const bsv::Index points : { 10000, 100000, 1331000 })
  {
    benchmark->Args({ points, 1 })->Args({ points, 2 });
  }
}
BENCHMARK_CAPTURE(topologyOfBlocks, found, false)->Apply(blockSizes);
BENCHMARK_CAPTURE(topologyOfBlocks, declared, true)->Apply(blockSizes);

} // namespace

BENCHMARK_MAIN();
