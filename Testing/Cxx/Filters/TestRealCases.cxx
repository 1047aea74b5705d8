// SPDX-License-Identifier: BSD-3-Clause
// Third-party meshes of the folder in the environment variable BSV_SHARED_DATA; skipped where it is not present.
#include "Complex/EntityClass.h"
#include "Data/HexBlockData.h"
#include "Support/ConversionCases.h"
#include "Support/MeshCases.h"

#include "vtkHexBlockMeshReader.h"

#include <vtkNew.h>
#include <vtkPartitionedDataSetCollection.h>
#include <vtkStructuredGrid.h>

#include <gtest/gtest.h>

#include <cctype>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>

using namespace bsv;
using conversioncases::convert;
using conversioncases::Converted;
using meshcases::MeshCase;

namespace
{

/// Curves of interior extraordinary edges by valence and singular nodes as listed in the folder's own manifest.
struct RealCase
{
  const char* file;
  std::map<int, Index> curves;
  Index singularNodes;
};

const std::vector<RealCase> Cases{
  { "near_tip_vol.xyz", { { 3, 4 } }, 0 },
  { "bwb_vol.xyz", { { 3, 4 } }, 0 },
  { "717_wl_L2.cgns", { { 3, 4 } }, 0 },
  { "t_joint.xyz", { { 3, 6 }, { 6, 1 } }, 0 },
  { "torus.xyz", { { 3, 4 } }, 0 },
  { "sphere7ProjectedEdges.xyz", { { 3, 20 } }, 8 },
  { "even_sphere_vol.xyz", { { 3, 8 } }, 0 },
  { "n0012.cgns", {}, 0 },
  { "mixer.xyz", {}, 0 },
  { "multi-bin.xyz", {}, 0 },
  { "multi-ascii.xyz", {}, 0 },
};

MeshCase load(const std::filesystem::path& file)
{
  vtkNew<vtkHexBlockMeshReader> reader;
  reader->SetFileName(file.c_str());
  reader->Update();
  std::vector<vtkSmartPointer<vtkStructuredGrid>> grids;
  const BlockMesh mesh = blockMesh(reader->GetOutputDataObject(0), grids);
  MeshCase result;
  for (const MeshBlock& block : mesh.blocks)
  {
    const auto& counts = block.points.counts();
    result.add(
      { counts[0] - 1, counts[1] - 1, counts[2] - 1 }, [&](const Ijk& p) { return block.points(p); }, block.name);
  }
  result.interfaces = mesh.interfaces;
  result.boundaries = mesh.boundaries;
  result.boundaryNames = mesh.boundaryNames;
  result.creases = mesh.creases;
  return result;
}

/// What the files' own boundary names say.
ConversionOptions optionsOf(const MeshCase& mesh)
{
  ConversionOptions options;
  for (std::string name : mesh.boundaryNames)
  {
    for (char& c : name)
    {
      c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
    options.roles.push_back(name.find("wall") != std::string::npos ? BoundaryRole::Body
        : name.find("sym") != std::string::npos                    ? BoundaryRole::Symmetry
                                                                   : BoundaryRole::Other);
  }
  return options;
}

} // namespace

class RealCases : public testing::TestWithParam<RealCase>
{
protected:
  void SetUp() override
  {
    const char* folder = std::getenv("BSV_SHARED_DATA");
    this->File = std::filesystem::path(folder ? folder : "") / "structured" / this->GetParam().file;
    if (!folder || !std::filesystem::exists(this->File))
    {
      GTEST_SKIP() << "no third-party data";
    }
  }
  std::filesystem::path File;
};

TEST_P(RealCases, AreWatertightAndC2WhereRegular)
{
  MeshCase mesh = load(this->File);
  ASSERT_FALSE(mesh.blocks.empty());
  const auto start = std::chrono::steady_clock::now();
  const Converted converted = convert(mesh.mesh(), optionsOf(mesh));
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const EntityClasses classes = classifyEntities(converted.complex);
  EXPECT_EQ(classes.extraordinaryCurves, this->GetParam().curves);
  EXPECT_EQ(classes.singularNodes, this->GetParam().singularNodes);
  EXPECT_EQ(converted.report.singularNodes, this->GetParam().singularNodes);
  const auto jumps = conversioncases::interfaceJumps(converted);
  EXPECT_EQ(jumps.openControlPoints, 0);
  for (int order = 0; order < 3; ++order)
  {
    EXPECT_LE(jumps.worst[order], 1.0) << "derivatives of order " << order;
  }
  Index points = 0;
  for (const auto& rules : converted.rules)
  {
    points += static_cast<Index>(rules.size());
  }
  std::string curves;
  for (const auto& [valence, count] : classes.extraordinaryCurves)
  {
    curves += (curves.empty() ? "" : ", ") + std::to_string(valence) + ": " + std::to_string(count);
  }
  std::printf("| %s | %zu -> %zu blocks | %lld control points | curves {%s} | %lld singular | %.3f s | regular %lld of "
              "%lld points, jumps / allowed %.3f %.3f %.3f |\n",
    this->GetParam().file, mesh.blocks.size(), converted.volumes.size(), static_cast<long long>(points), curves.c_str(),
    static_cast<long long>(converted.report.singularNodes), seconds, static_cast<long long>(jumps.regular),
    static_cast<long long>(jumps.points), jumps.worst[0], jumps.worst[1], jumps.worst[2]);
}

TEST_P(RealCases, SameBitsForAnyNumberingOrientationAndThreads)
{
  MeshCase mesh = load(this->File);
  ASSERT_FALSE(mesh.blocks.empty());
  const auto reference = conversioncases::canonicalNet(convert(mesh.mesh(), optionsOf(mesh)));
  for (unsigned seed = 1; seed <= 2; ++seed)
  {
    MeshCase other = mesh;
    meshcases::shuffle(other, seed, seed == 2);
    const auto run = seed == 1 ? conversioncases::twoThreads() : Execution{};
    EXPECT_TRUE(conversioncases::canonicalNet(convert(other.mesh(), optionsOf(mesh), {}, run)) == reference)
      << "seed " << seed;
  }
}

TEST_P(RealCases, SameBitsForEachOfThe24Orientations)
{
  MeshCase mesh = load(this->File);
  ASSERT_FALSE(mesh.blocks.empty());
  const auto reference = conversioncases::canonicalNet(convert(mesh.mesh(), optionsOf(mesh)));
  for (int orientation = 1; orientation < meshcases::OrientationCount; ++orientation)
  {
    MeshCase other = mesh;
    for (int block = 0; block < static_cast<int>(other.blocks.size()); ++block)
    {
      meshcases::reorient(other, block, (orientation + 7 * block) % meshcases::OrientationCount);
    }
    EXPECT_TRUE(conversioncases::canonicalNet(convert(other.mesh(), optionsOf(mesh))) == reference)
      << "orientation " << orientation;
  }
}

INSTANTIATE_TEST_SUITE_P(Structured, RealCases, testing::ValuesIn(Cases), [](const auto& info) {
  std::string name = info.param.file;
  for (char& c : name)
  {
    c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  }
  return name;
});
