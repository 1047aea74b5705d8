// SPDX-License-Identifier: BSD-3-Clause
/// @file QuadflowCase.h
/// What a multi-block topology file `.qfmb` says, as structures: made from B-spline volumes, and checked.
#pragma once

#include "Mesh/BlockMesh.h"
#include "Volume/BSplineVolume.h"

#include <string>
#include <utility>
#include <vector>

namespace bsv
{

enum class QuadflowEdgeClass
{
  Regular, ///< inside, four blocks
  Boundary,
  Extraordinary, ///< inside, other than four blocks
  Crease,        ///< on the boundary, sharp
  Planar         ///< on a planar side whose points were kept
};

/// The `line`s of these structures are those of the text that was read, for messages; 0 if they were not read.

struct QuadflowVertex
{
  Vec3 position;
  int line = 0;
};

struct QuadflowEdge
{
  std::array<int, 2> vertices{ -1, -1 }; ///< lower id first
  int cells = 0;
  QuadflowEdgeClass kind = QuadflowEdgeClass::Regular;
  int valence = 0; ///< blocks that meet there, if extraordinary
  int line = 0;
};

struct QuadflowFace
{
  std::array<int, 4> vertices{}; ///< at (s, t) = (0,0), (1,0), (0,1), (1,1)
  std::array<int, 4> edges{};    ///< along s at t = 0 and 1, along t at s = 0 and 1
  std::array<int, 2> cells{};    ///< along s and t
  int blocks = 0;                ///< 1 on the boundary, 2 inside
  int boundary = 0;              ///< boundary id, or 0
  int line = 0;
};

struct QuadflowBlock
{
  std::string name;
  std::array<int, 3> cells{}; ///< knot spans
  std::array<int, 8> vertices{};
  std::array<int, 12> edges{};
  std::array<bool, 12> edgeReversed{};
  std::array<int, 6> faces{};
  std::array<int, 6> faceOrientations{}; ///< code from the global face to this block's
  BSplineVolume volume;
  int line = 0;
  int pointsLine = 0; ///< line of the first control point, in the file that holds the geometry
};

struct QuadflowInterface
{
  Interface contact;
  std::array<int, 3> transform{}; ///< cgnsTransform()
  int line = 0;
};

/// Every block face that is in no interface.
struct QuadflowBoundaryFace
{
  int block = 0;
  int face = 0;
  int boundary = 0; ///< id, or 0: no name
  int line = 0;
};

struct QuadflowBoundaryName
{
  int id = 0; ///< from 1
  std::string name;
  int line = 0;
};

/// A whole file. Ids are indices from 0 here, whatever the text has. Ranges of interfaces count control points.
struct QuadflowCase
{
  /// What follows # in the first line, a comment; empty: that of this version.
  std::string title;
  /// First id in the text that was read: messages name ids as they stand there.
  int indexBase = 0;
  int countsLine = 0;
  std::vector<QuadflowVertex> vertices;
  std::vector<QuadflowEdge> edges;
  std::vector<QuadflowFace> faces;
  std::vector<QuadflowBlock> blocks;
  std::vector<QuadflowInterface> interfaces;
  std::vector<QuadflowBoundaryFace> boundaryFaces;
  std::vector<QuadflowBoundaryName> boundaryNames;
};

/// Blocks to write.
struct QuadflowInput
{
  std::vector<BSplineVolume> volumes;
  std::vector<std::string> names;
  /// ControlPointRule per control point of every block, or null, also for blocks of other ranks: tells creases and
  /// planar sides.
  std::vector<const unsigned char*> rules;
  /// Per block the classes of its twelve edges, or null: where the rules do not tell creases and planar sides. May be
  /// empty.
  std::vector<const unsigned char*> edgeClasses;
  /// If false, faces with equal control points (bit for bit) are interfaces.
  bool hasInterfaces = false;
  std::vector<Interface> interfaces;
  std::vector<BoundaryPatch> boundaries; ///< whole faces
  std::vector<std::string> boundaryNames;
  /// Ids of boundary names; names that are not in it get the smallest free ones from 1, in order.
  std::vector<std::pair<std::string, int>> boundaryIds;
};

/// Numbers the global vertices, edges and faces. The control points stay where they are; between ranks go corners of
/// blocks, classes of edges and the faces of interfaces.
/// @throws Error for everything that checkQuadflowCase() finds, unclamped knots, faces in two interfaces or boundaries,
/// ambiguous contacts if they have to be found, boundary ids that are not positive or not unique.
QuadflowCase makeQuadflowCase(const QuadflowInput& input, const Execution& run = {});

/// All self-checks: every block face in exactly one interface or boundary; the two sides of an interface equal under
/// its orientation, control points bit for bit, knots up to rounding; vertices equal to the blocks' corners; all ids,
/// counts, classes and orientations consistent with the interfaces.
/// @param file names the file in messages, or is empty; `geometryFile` that with the control points.
/// @throws Error that names line, block and face.
void checkQuadflowCase(const QuadflowCase& all, const std::string& file = "", const std::string& geometryFile = "",
  const Execution& run = {});

} // namespace bsv
