// SPDX-License-Identifier: BSD-3-Clause
// Closest points on a body: a torus and a bumpy bicubic surface of 400 spans, queries in and around them.
#include "BenchmarkSupport.h"

#include "Body/ClosestPoint.h"
#include "Support/BodyCases.h"

namespace
{

struct Queries
{
  bsv::BodySurface body;
  std::vector<bsv::Vec3> points;
};

Queries makeQueries(bsv::Index count)
{
  bsv::BodyPatch torus, bumpy;
  torus.surface = bodycases::torus(2.0, 0.5);
  bumpy.surface = bodycases::bumpy(1, { 3, 3 }, { 20, 20 }, 0.1, true);
  Queries queries{ bsv::BodySurface({ torus, bumpy }), {} };
  std::mt19937 random(1);
  std::uniform_real_distribution<double> coordinate(-3.0, 3.0);
  for (bsv::Index i = 0; i < count; ++i)
  {
    const double x = coordinate(random), y = coordinate(random);
    queries.points.emplace_back(x, y, 0.3 * coordinate(random));
  }
  return queries;
}

void closestPoints(benchmark::State& state)
{
  const bsv::Index count = bsvbench::pointsOf(state);
  const Queries& queries = bsvbench::cached<Queries>(count, [&] { return makeQueries(count); });
  const bsv::Execution run = bsvbench::execution(bsvbench::threadsOf(state));
  const double seconds =
    bsvbench::fastest(state, [&] { benchmark::DoNotOptimize(queries.body.closestPoints(queries.points, run).data()); });
  std::vector<double> buffer(3 * queries.points.size());
  bsvbench::report(state, seconds, 8.0 * buffer.size(), { bsvbench::half(buffer.data(), buffer.size()) });
}

void querySizes(benchmark::internal::Benchmark* benchmark)
{
  bsvbench::sizes(benchmark, 400.0, 6);
}
BENCHMARK(closestPoints)->Apply(querySizes);

} // namespace

BENCHMARK_MAIN();
