// SPDX-License-Identifier: BSD-3-Clause
// Reading PLOT3D files of six blocks around a sphere: binary and text.
#include "FileComparison.h"
#include "MeshSizes.h"

#include "vtkHexBlockMeshReader.h"
#include "vtkNew.h"

#include <charconv>

namespace
{

void write(const meshcases::MeshCase& mesh, const std::string& path, bool text)
{
  std::ofstream file(path, std::ios::binary);
  const auto put = [&](auto value) {
    if (text)
    {
      char digits[32];
      char* end = std::to_chars(digits, digits + 31, value).ptr;
      *end++ = '\n';
      file.write(digits, end - digits);
    }
    else
    {
      file.write(reinterpret_cast<const char*>(&value), sizeof(value));
    }
  };
  put(static_cast<int>(mesh.blocks.size()));
  for (const meshcases::MeshCase::Block& block : mesh.blocks)
  {
    for (const int count : block.counts)
    {
      put(count);
    }
  }
  for (const meshcases::MeshCase::Block& block : mesh.blocks)
  {
    for (int d = 0; d < 3; ++d)
    {
      for (const bsv::Vec3& point : block.points)
      {
        put(point[d]);
      }
    }
  }
}

void plot3d(benchmark::State& state, bool text)
{
  const std::string path = bsvbench::folder() / "mesh.xyz";
  write(bsvbench::SphereCase(bsvbench::pointsOf(state), false).mesh, path, text);
  vtkNew<vtkHexBlockMeshReader> reader;
  reader->SetFileName(path.c_str());
  const auto read = [&] {
    reader->Modified();
    reader->Update();
  };
  const double seconds = bsvbench::fastest(state, read, bsvbench::Clock::Wall, [&] { bsvbench::evict(path); });
  bsvbench::reportFile(state, seconds, path, false);
}
BENCHMARK_CAPTURE(plot3d, read_text, true)->Apply(bsvbench::fileSizes);
BENCHMARK_CAPTURE(plot3d, read_binary, false)->Apply(bsvbench::fileSizes);

} // namespace

BENCHMARK_MAIN();
