// SPDX-License-Identifier: BSD-3-Clause
/// @file MeshCases.h
/// Small multi-block meshes for the tests, made by code, and the changes that must not matter to any result: numbering
/// and orientation of the blocks.
///
/// Points that blocks share are equal bit for bit in every case made here.
#pragma once

#include "Complex/BlockComplex.h"

#include <functional>
#include <utility>

namespace meshcases
{

using bsv::Ijk;
using bsv::Vec3;
using Map = std::function<Vec3(const Vec3&)>;

/// A mesh that owns its points.
struct MeshCase
{
  struct Block
  {
    std::string name;
    /// Points per direction.
    Ijk counts{ 0, 0, 0 };
    std::vector<Vec3> points;
    /// Hand the points out in single precision.
    bool isFloat = false;
    std::vector<float> floats;
    std::vector<double> creaseSharpness;

    std::size_t index(const Ijk& p) const
    {
      return p[0] + std::size_t(this->counts[0]) * (p[1] + std::size_t(this->counts[1]) * p[2]);
    }
    Vec3& at(const Ijk& p) { return this->points[this->index(p)]; }
    const Vec3& at(const Ijk& p) const { return this->points[this->index(p)]; }
    Ijk cells() const { return { this->counts[0] - 1, this->counts[1] - 1, this->counts[2] - 1 }; }
  };

  std::vector<Block> blocks;
  std::vector<bsv::Interface> interfaces;
  std::vector<bsv::BoundaryPatch> boundaries;
  std::vector<std::string> boundaryNames;
  std::vector<bsv::CreaseLine> creases;

  /// View of this case, which must outlive it and stay unchanged.
  bsv::BlockMesh mesh();

  /// Appends a block of `cells` whose point (i, j, k) is point(i, j, k).
  Block& add(const Ijk& cells, const std::function<Vec3(const Ijk&)>& point, const std::string& name = "");

  /// Moves every point.
  MeshCase& apply(const Map& map);
};

///@{
/// Cases. `cells` are mesh cells, all at least 1.

/// Blocks that are boxes of one integer lattice: from first to last point each. Contacts may be partial.
MeshCase latticeBlocks(const std::vector<std::pair<Ijk, Ijk>>& boxes, const Map& map = {});

/// The box of `cells` lattice cells, cut at the given inner positions of each direction.
MeshCase cutBox(const Ijk& cells, const std::array<std::vector<int>, 3>& cuts = {}, const Map& map = {});

/// Random boxes of a small lattice that do not overlap: partial contacts, one-cell blocks, re-entrant edges, blocks
/// that touch along an edge or at a corner only, and some creases.
MeshCase randomBoxes(unsigned seed);

/// Three boxes of cells^3 around a re-entrant edge, meeting in two faces.
MeshCase lShape(int cells);

/// `valence` sectors around the z axis (each a parallelogram of cells x cells, so valence 4 is the square of edge 2),
/// one stack of blocks per entry of `heights`, which lists its z values; the last of a stack is the first of the next.
/// For valence != 4 the axis is an extraordinary edge. Directions: two in the sector, then z.
MeshCase ring(int valence, int cells, const std::vector<std::vector<double>>& heights);

/// Six blocks around the unit sphere, of cells x cells x (radii - 1); k runs outwards along `radii`. Eight
/// extraordinary edges of valence 3 from the body (k = 0) to the outer boundary.
MeshCase sphereBody(int cells, const std::vector<double>& radii);

/// One block on every outer square of `cubes`, unit cubes of the integer lattice that can all be seen from the middle
/// of the first: seen from there they make a mesh of the unit sphere, whose directions are evened out by a few
/// Laplacian steps. Layers as in sphereBody(). One cube has extraordinary edges of valence 3, an L of three 5 too.
MeshCase polycubeBody(const std::vector<Ijk>& cubes, int cells, const std::vector<double>& radii);

/// 26 blocks around the cube [-1, 1]^3 with `cells` cells along its edges, in a larger cube; layers from `firstLayer`
/// on grow by the factor 1.7. `bar`: 8 blocks around a square bar that ends at both sides. Boundary "wall".
MeshCase aroundCube(int cells, double firstLayer, bool bar);

/// Unit ball: a cube and six blocks around it. 20 extraordinary edges of valence 3, 8 singular nodes.
MeshCase ball(int cells, int radialCells);

/// Solid torus about z of radii 2 and 1 whose cross-section is a square and four blocks around it, `sections` >= 3
/// times `cells` long cells around. Four closed rings of extraordinary edges of valence 3.
MeshCase torus(int sections, int cells);

/// One block whose face i = 0 meets its face i = I: ring around z, j outwards from innerRadius to 1, k along z.
/// innerRadius 0 collapses face j = 0.
MeshCase oGrid(const Ijk& cells, double innerRadius = 0.5);

/// One block closed on itself in i and in j: the shell between two tori.
MeshCase closedShell(const Ijk& cells);

/// One block around a thin profile with a sharp trailing edge: wake, lower side, upper side, wake along i, so that
/// both ends of face j = 0 meet; j outwards; k along the span. bodyCells (over both sides) may be 0: the face is then
/// folded in its middle.
MeshCase cGrid(int wakeCells, int bodyCells, int j, int k);
///@}

/// Half a body in front of its symmetry plane z = 0, in a cuboid [-3, 3] x [-1, 1] x [0, 2] with a far-field extension.
///
/// Blocks 0-18 lie between the body (an ellipsoid) and the sides of the cuboid, `layers` cells each, stretched by the
/// factor `growth` from one to the next; 19-37 are attached to the sides face to face, the cuboid being divided into 3
/// x 1 x 2; 38-57 touch it by an edge or a corner only. The extension has `layers` cells; the first is `step` times as
/// large as the cuboid's layers are in the middle of its sides without stretching, the next grow by 1.2. Boundaries:
/// "wall", "symmetry"; those of the far field have no name.
MeshCase extendedCuboid(int cells, int layers, double step, double growth = 1.0);

/// A smooth, invertible, curved map of about [-3, 3]^3.
Vec3 wavy(const Vec3& x);

///@{
/// Changes of numbering and orientation. Interfaces, boundaries, creases and point data follow.

/// The 48 orientations of a block: 0 is none, 0-23 keep the handedness, 24-47 are mirrored.
constexpr int OrientationCount = 24;
constexpr int MirroredOrientationCount = 48;

void reorient(MeshCase& mesh, int block, int orientation);
/// New block n is old block order[n].
void renumber(MeshCase& mesh, const std::vector<int>& order);
/// Random order and orientations, reproducible by `seed`; mirrors about half of the blocks if `mirror`.
void shuffle(MeshCase& mesh, unsigned seed, bool mirror = false);
///@}

/// Declares all contacts that the search for coincident points finds, in random direction by `seed`, and all the rest
/// as boundaries named after the existing tags or "boundary".
void declareAll(MeshCase& mesh, unsigned seed = 0);

} // namespace meshcases
