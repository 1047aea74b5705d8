// SPDX-License-Identifier: BSD-3-Clause
/// Cells that are turned over if their faces are flat.
#include "Mesh/FlatFaces.h"
#include "Support/MeshCases.h"

#include <gtest/gtest.h>

using namespace bsv;
using meshcases::MeshCase;

namespace
{

TurnedCells turned(MeshCase& mesh, int step = 1)
{
  return turnedCells(mesh.mesh().blocks[0].points, step, {});
}

/// Layers of this height, which grows along the wall, on a warped surface.
MeshCase layers(double height)
{
  return meshcases::cutBox({ 4, 3, 5 }, {},
    [=](const Vec3& x) { return Vec3(x[0], x[1], 0.3 * x[0] * x[1] + height * x[2] * (1.0 + x[0]) * (1.0 + x[1])); });
}

} // namespace

TEST(FlatFaces, ThinCellsOnACurvedWallAreTurned)
{
  MeshCase thick = layers(0.1);
  EXPECT_EQ(turned(thick).count, 0);
  MeshCase thin = layers(1e-6);
  EXPECT_EQ(turned(thin).count, 60);
  // Cells of the same height on a plane are not.
  MeshCase plane = meshcases::cutBox({ 4, 3, 5 }, {}, [](const Vec3& x) { return Vec3(x[0], x[1], 1e-6 * x[2]); });
  EXPECT_EQ(turned(plane).count, 0);
}

TEST(FlatFaces, OrientationAndHandednessDoNotMatter)
{
  for (int orientation = 0; orientation < meshcases::MirroredOrientationCount; ++orientation)
  {
    MeshCase thin = layers(1e-6);
    MeshCase thick = layers(0.1);
    for (MeshCase* mesh : { &thin, &thick })
    {
      meshcases::reorient(*mesh, 0, orientation);
    }
    EXPECT_EQ(turned(thin).count, 60) << orientation;
    EXPECT_EQ(turned(thick).count, 0) << orientation;
  }
}

TEST(FlatFaces, CollapsedAndFoldedCellsCount)
{
  // The cells at the axis have a face without area.
  MeshCase axis = meshcases::oGrid({ 12, 3, 2 }, 0.0);
  EXPECT_EQ(turned(axis).count, 24);
  MeshCase ring = meshcases::oGrid({ 12, 3, 2 });
  EXPECT_EQ(turned(ring).count, 0);
  // A layer that runs back.
  MeshCase folded = meshcases::cutBox({ 4, 4, 4 });
  for (int j = 0; j <= 4; ++j)
  {
    for (int i = 0; i <= 4; ++i)
    {
      folded.blocks[0].at({ i, j, 2 })[2] = 0.5;
    }
  }
  const TurnedCells found = turned(folded);
  EXPECT_EQ(found.count, 16);
  EXPECT_EQ(found.first, (Ijk{ 0, 0, 1 }));
  // Every second point is a plain box.
  folded.blocks[0].at({ 1, 1, 1 })[0] = -7.0;
  EXPECT_EQ(turned(folded, 4).count, 0);
}

TEST(FlatFaces, TheNoteNamesTheFirst)
{
  const auto name = [](std::size_t b) { return "block " + std::to_string(b); };
  EXPECT_EQ(turnedCellsNote({ {}, {} }, name), "");
  const std::string note = turnedCellsNote({ {}, { 2, { 3, 0, 1 } }, { 5, { 0, 0, 0 } } }, name);
  EXPECT_EQ(note.find("7 cells are turned over"), 0u) << note;
  EXPECT_NE(note.find("first in block 1 at cell (3, 0, 1)"), std::string::npos) << note;
}
