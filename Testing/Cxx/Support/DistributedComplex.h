// SPDX-License-Identifier: BSD-3-Clause
/// @file DistributedComplex.h
/// The complex of a mesh that is shared out over ranks must be that of a process alone.
#pragma once

#include "Complex/BlockComplex.h"
#include "Support/ThreadRanks.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <string>
#include <vector>

namespace bsvtest
{

/// Blocks on any ranks, also with ranks that have none.
inline std::vector<int> randomRanks(std::size_t blocks, int size, std::mt19937& random)
{
  std::vector<int> rankOf(blocks);
  for (int& rank : rankOf)
  {
    rank = std::uniform_int_distribution<int>(0, size - 1)(random);
  }
  return rankOf;
}

/// Everything but the points.
inline void expectSameTopology(const bsv::BlockComplex& a, const bsv::BlockComplex& b)
{
  ASSERT_EQ(a.blocks.size(), b.blocks.size());
  ASSERT_EQ(a.vertices.size(), b.vertices.size());
  ASSERT_EQ(a.edges.size(), b.edges.size());
  ASSERT_EQ(a.faces.size(), b.faces.size());
  for (std::size_t n = 0; n < a.blocks.size(); ++n)
  {
    const bsv::ComplexBlock &x = a.blocks[n], &y = b.blocks[n];
    EXPECT_EQ(x.points.counts(), y.points.counts());
    EXPECT_EQ(x.name, y.name);
    EXPECT_EQ(x.parent, y.parent);
    EXPECT_EQ(x.offset, y.offset);
    EXPECT_EQ(x.vertices, y.vertices);
    EXPECT_EQ(x.edges, y.edges);
    EXPECT_EQ(x.edgeReversed, y.edgeReversed);
    EXPECT_EQ(x.faces, y.faces);
    EXPECT_EQ(x.leftHanded, y.leftHanded);
  }
  for (std::size_t n = 0; n < a.vertices.size(); ++n)
  {
    const bsv::ComplexVertex &x = a.vertices[n], &y = b.vertices[n];
    EXPECT_EQ(x.boundary, y.boundary);
    ASSERT_EQ(x.corners.size(), y.corners.size());
    for (std::size_t use = 0; use < x.corners.size(); ++use)
    {
      EXPECT_EQ(x.corners[use].block, y.corners[use].block);
      EXPECT_EQ(x.corners[use].corner, y.corners[use].corner);
    }
  }
  for (std::size_t n = 0; n < a.edges.size(); ++n)
  {
    const bsv::ComplexEdge &x = a.edges[n], &y = b.edges[n];
    EXPECT_EQ(x.vertices, y.vertices);
    EXPECT_EQ(x.cells, y.cells);
    EXPECT_EQ(x.boundary, y.boundary);
    EXPECT_EQ(x.crease, y.crease);
    ASSERT_EQ(x.uses.size(), y.uses.size());
    for (std::size_t use = 0; use < x.uses.size(); ++use)
    {
      EXPECT_EQ(x.uses[use].block, y.uses[use].block);
      EXPECT_EQ(x.uses[use].edge, y.uses[use].edge);
      EXPECT_EQ(x.uses[use].reversed, y.uses[use].reversed);
    }
  }
  for (std::size_t n = 0; n < a.faces.size(); ++n)
  {
    const bsv::ComplexFace &x = a.faces[n], &y = b.faces[n];
    EXPECT_EQ(x.orientation, y.orientation);
    EXPECT_EQ(x.tag, y.tag);
    EXPECT_EQ(x.creaseCut, y.creaseCut);
    ASSERT_EQ(x.uses.size(), y.uses.size());
    for (std::size_t use = 0; use < x.uses.size(); ++use)
    {
      EXPECT_EQ(x.uses[use].block, y.uses[use].block);
      EXPECT_EQ(x.uses[use].face, y.uses[use].face);
    }
  }
  EXPECT_EQ(a.boundaryNames, b.boundaryNames);
  EXPECT_EQ(a.tangledCells, b.tangledCells);
  EXPECT_EQ(a.warnings, b.warnings);
  EXPECT_EQ(a.notes, b.notes);
  EXPECT_EQ(a.creaseNote, b.creaseNote);
}

/// The points of the rank's own blocks are those of the complex made alone, and as few are copied; there are no others.
inline void expectOwnPoints(
  const bsv::BlockMesh& mesh, const bsv::BlockComplex& alone, const bsv::BlockComplex& part, int rank)
{
  for (std::size_t n = 0; n < part.blocks.size(); ++n)
  {
    const bsv::ComplexBlock& expected = alone.blocks[n];
    const bsv::ComplexBlock& block = part.blocks[n];
    EXPECT_EQ(block.points.isHere(), block.rank == rank);
    if (block.rank != rank)
    {
      EXPECT_FALSE(block.points.has({ 0, 0, 0 }));
      continue;
    }
    const void* direct = mesh.blocks[block.parent].points.box(block.offset, block.offset).address<double>(0, 0, 0);
    EXPECT_EQ(expected.points.address<double>(0, 0, 0) == direct, block.points.address<double>(0, 0, 0) == direct);
    EXPECT_EQ(expected.points.isFloat(), block.points.isFloat());
    bool same = true;
    for (int k = 0; k <= block.cells(2); ++k)
    {
      for (int j = 0; j <= block.cells(1); ++j)
      {
        for (int i = 0; i <= block.cells(0); ++i)
        {
          const bsv::Vec3 a = expected.points(i, j, k), b = block.points(i, j, k);
          same = same && std::memcmp(a.data(), b.data(), 3 * sizeof(double)) == 0;
        }
      }
    }
    EXPECT_TRUE(same) << "points of " << block.name;
  }
}

/// On every rank the complex is the one made alone, or the error is.
inline void expectSameOnRanks(
  const bsv::BlockMesh& mesh, const bsv::BlockComplexOptions& options, const std::vector<int>& rankOf, int size)
{
  std::string error;
  bsv::BlockComplex alone;
  try
  {
    alone = bsv::buildBlockComplex(mesh, options);
  }
  catch (const bsv::Error& e)
  {
    error = e.what();
  }
  const std::vector<std::string> errors = onRanks(size, [&](const bsv::Execution& run) {
    const bsv::BlockMesh part = distributed(mesh, rankOf, run.ranks->rank());
    const bsv::BlockComplex complex = bsv::buildBlockComplex(part, options, run);
    for (const bsv::ComplexBlock& block : complex.blocks)
    {
      EXPECT_EQ(block.rank, rankOf[block.parent]);
    }
    expectSameTopology(alone, complex);
    if (alone.blocks.size() == complex.blocks.size())
    {
      expectOwnPoints(mesh, alone, complex, run.ranks->rank());
    }
  });
  EXPECT_EQ(errors, std::vector<std::string>(size, error));
}

/// The same for some random distributions.
inline void expectSameOnRanks(const bsv::BlockMesh& mesh, const bsv::BlockComplexOptions& options = {}, int trials = 3)
{
  std::mt19937 random(static_cast<unsigned>(mesh.blocks.size()));
  for (int trial = 0; trial < trials && !::testing::Test::HasFailure(); ++trial)
  {
    const int size = 2 + (trial + static_cast<int>(mesh.blocks.size())) % 4;
    const std::vector<int> rankOf = randomRanks(mesh.blocks.size(), size, random);
    SCOPED_TRACE("blocks on ranks " + ::testing::PrintToString(rankOf));
    expectSameOnRanks(mesh, options, rankOf, size);
  }
}

} // namespace bsvtest
