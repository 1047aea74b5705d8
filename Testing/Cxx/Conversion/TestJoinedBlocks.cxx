// SPDX-License-Identifier: BSD-3-Clause
// Blocks that were cut for creases, joined again with repeated knots.
#include "Conversion/JoinedBlocks.h"
#include "Support/ConversionCases.h"
#include "Support/DistributedComplex.h"
#include "Support/MeshCases.h"

#include <gtest/gtest.h>

#include <random>

using namespace bsv;
using conversioncases::convert;
using conversioncases::Converted;
using meshcases::MeshCase;

namespace
{

/// Meshes with creases that run inside blocks, from several sides; the last three with extraordinary edges.
std::vector<MeshCase> cases()
{
  std::vector<MeshCase> result;
  for (unsigned seed = 0; result.size() < 12; ++seed)
  {
    MeshCase mesh = meshcases::randomBoxes(seed);
    if (!mesh.creases.empty())
    {
      result.push_back(std::move(mesh));
    }
  }
  for (const int valence : { 3, 5, 4 })
  {
    MeshCase mesh = meshcases::ring(valence, 6, { { 0.0, 1.0, 2.0, 3.0, 4.0, 5.0 }, { 5.0, 6.0 } });
    mesh.apply(meshcases::wavy);
    mesh.creases.push_back({ 0, { 2, 1, 0 }, { 2, 5, 0 } });
    mesh.creases.push_back({ 1, { 0, 3, 0 }, { 6, 3, 0 } });
    result.push_back(std::move(mesh));
  }
  return result;
}

/// The pieces of `cut` joined, as a conversion of its own.
Converted joined(const Converted& cut)
{
  JoinedBlocks blocks = joinPieces(cut.complex);
  std::vector<std::array<std::vector<double>, 3>> knots;
  std::vector<ControlNetStorage> nets;
  for (std::size_t b = 0; b < cut.volumes.size(); ++b)
  {
    knots.push_back(cut.volumes[b].knots);
    nets.push_back({ const_cast<double*>(cut.points[b].data()), const_cast<std::uint8_t*>(cut.rules[b].data()) });
  }
  Converted result;
  for (const JoinedBlock& block : blocks.blocks)
  {
    BSplineVolume volume;
    std::size_t count = 1;
    for (int d = 0; d < 3; ++d)
    {
      volume.knots[d] = joinedKnots(block, d, knots);
      count *= volume.count(d);
    }
    result.points.emplace_back(3 * count, std::numeric_limits<double>::quiet_NaN());
    result.rules.emplace_back(count, std::uint8_t(255));
    volume.points = result.points.back().data();
    result.volumes.push_back(volume);
    joinNets(block, knots, nets, { result.points.back().data(), result.rules.back().data() });
  }
  result.complex = std::move(blocks.complex);
  return result;
}

} // namespace

// Joined, the complex is that of the mesh without its creases.
TEST(JoinedBlocks, AreTheBlocksWithoutCreases)
{
  std::size_t cuts = 0;
  for (MeshCase& mesh : cases())
  {
    const BlockComplex cut = buildBlockComplex(mesh.mesh());
    mesh.creases.clear();
    BlockComplex expected = buildBlockComplex(mesh.mesh());
    BlockComplex found = joinPieces(cut).complex;
    cuts += cut.blocks.size() - found.blocks.size();
    EXPECT_EQ(found.creaseNote.empty(), found.blocks.size() == cut.blocks.size());
    expected.creaseNote = found.creaseNote;
    for (ComplexEdge& edge : found.edges)
    {
      edge.crease = false;
    }
    bsvtest::expectSameTopology(found, expected);
  }
  EXPECT_GT(cuts, 50u);
}

// Every point of every piece is where it was, at the parameters of the whole block.
TEST(JoinedBlocks, KeepTheShapeOfTheirPieces)
{
  std::mt19937 random(1);
  std::uniform_real_distribution<double> part(0.0, 1.0);
  for (const Continuity continuity : { Continuity::SingleKnots, Continuity::ExactG1 })
  {
    for (MeshCase& mesh : cases())
    {
      ConversionOptions options;
      options.continuity = continuity;
      const Converted cut = convert(mesh.mesh(), options);
      const Converted whole = joined(cut);
      EXPECT_EQ(conversioncases::interfaceJumps(whole).openControlPoints, 0);
      const JoinedBlocks blocks = joinPieces(cut.complex);
      for (std::size_t b = 0; b < whole.volumes.size(); ++b)
      {
        checkBSplineVolume(whole.volumes[b], whole.complex.blocks[b].name);
      }
      double difference = 0.0, size = 0.0;
      for (std::size_t piece = 0; piece < cut.volumes.size(); ++piece)
      {
        const int block = blocks.blockOf[piece];
        for (int n = 0; n < 20; ++n)
        {
          Vec3 uvw, there;
          for (int d = 0; d < 3; ++d)
          {
            // Ends of pieces, too.
            uvw[d] = cut.complex.blocks[piece].cells(d) * (n < 8 ? n >> d & 1 : part(random));
            there[d] = uvw[d] + cut.complex.blocks[piece].offset[d] - whole.complex.blocks[block].offset[d];
          }
          const Vec3 x = evaluate(cut.volumes[piece], uvw);
          difference = std::max(difference, (evaluate(whole.volumes[block], there) - x).norm());
          size = std::max(size, x.norm());
        }
      }
      EXPECT_LT(difference, 1e-14 * size);
    }
  }
}

TEST(JoinedBlocks, AreTheSameBitsInAnyNumberingAndOrientation)
{
  for (MeshCase& mesh : cases())
  {
    const auto expected = conversioncases::canonicalNet(joined(convert(mesh.mesh())));
    for (unsigned seed = 1; seed < 3; ++seed)
    {
      MeshCase other = mesh;
      meshcases::shuffle(other, seed, true);
      EXPECT_TRUE(conversioncases::canonicalNet(joined(convert(other.mesh()))) == expected);
    }
  }
}
