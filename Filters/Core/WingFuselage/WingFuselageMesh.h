// SPDX-License-Identifier: BSD-3-Clause
/// @file WingFuselageMesh.h
/// A mesh of 79 hexahedral blocks around the half model of WingFuselageBody.h.
///
/// - 0..35: from each of the nine patches p of the body four blocks outwards to the surface of a box, 4 p .. 4 p + 3.
///   The first three hold the layers that grow at the wall, the fourth goes on to the box. i and j run along a and b of
///   the patch, k away from the body.
/// - 36..39: ahead of and behind the box, each two in span. With them the box becomes a cuboid that is divided into
///   three along x, two along y and one along z.
/// - 40..58: the extension to the far field on the 19 faces of the cuboid that are not in the symmetry plane.
/// - 59..78: the blocks of the extension that touch the cuboid by an edge or a corner only.
///
/// i, j, k of blocks 36..78 run along x, y, z. All blocks are right-handed, and meet whole face to whole face.
///
/// The wall is a Catmull-Clark control mesh whose B-spline surface passes through points of the body (fitBody()). A
/// line from the wall point W to the point H of the box is the cubic with the end derivatives r D and e E, where D . n
/// = 1 for every normal n of the body at W (bisecting at creases), and E is likewise normal to the box.
#pragma once

#include "Mesh/BlockMesh.h"
#include "WingFuselage/WingFuselageBody.h"

#include <string>
#include <vector>

namespace bsv
{

struct WingFuselageOptions
{
  WingFuselageShape shape;
  /// Cells n across the leading edge and the nose; twice as many along the chord and the fuselage, three times along
  /// the span. All that is not in the growing layers at the wall is refined with it. Range [2, 96]: 10 thousand to 89
  /// million points with the other defaults.
  int resolution = 8;
  /// From the cuboid to the outer boundary. Range [2, 1000].
  double farFieldDistance = 15.0;
  /// Height of the first cells at the wall. Range [1e-7, 0.1].
  double firstLayerHeight = 0.01;
  /// Largest ratio of the heights of successive layers at the wall. Range [1.02, 2].
  double growthRatio = 1.2;
};

/// What is known of the mesh before its points.
struct WingFuselageLayout
{
  /// Points per direction and block, and names.
  std::vector<Ijk> counts;
  std::vector<std::string> names;
  std::vector<Interface> interfaces;
  /// Boundaries `wall_fuselage`, `wall_wing`, `symmetry`, `farfield`.
  std::vector<BoundaryPatch> boundaries;
  std::vector<std::string> boundaryNames;
  /// Junction, trailing edge and the rim of the tip.
  std::vector<CreaseLine> creases;

  /// Of all blocks.
  Index points() const;
};

/// Work and memory of nothing but the lists. @throws Error for options out of range, or that do not go together.
WingFuselageLayout wingFuselageLayout(const WingFuselageOptions& options);

/// Writes the points of every block, x y z triples, i fastest, to `blocks`, one address per block, or null for a block
/// that is not wanted. Points that blocks share are equal bit for bit, whatever the number of threads. Any block needs
/// the whole surface of the body, which is computed here: the ranks are not asked.
/// @param body wingFuselageBody(options.shape)
void wingFuselagePoints(const WingFuselageOptions& options, const std::vector<BodyPatch>& body,
  const std::vector<double*>& blocks, const Execution& run = {});

} // namespace bsv
