// SPDX-License-Identifier: BSD-3-Clause
/**
 * What meshes, volumes and complexes have in common when their parts are shown: faces, edges and corners, told apart,
 * and what lines and surfaces are made of (blockPartsModel.cxx). blockPartsOfMesh.cxx, blockPartsOfVolume.cxx and
 * blockPartsOfComplex.cxx fill them.
 */
#ifndef blockPartsModel_h
#define blockPartsModel_h

#include "blockParts.h"

#include "Mesh/BlockTopology.h"
#include "Mesh/Enclosure.h"
#include "Ranks/Ranks.h"

#include "vtkCellArray.h"
#include "vtkFloatArray.h"
#include "vtkIdTypeArray.h"
#include "vtkIntArray.h"
#include "vtkNew.h"
#include "vtkPoints.h"
#include "vtkStructuredGrid.h"
#include "vtkUnsignedCharArray.h"

#include <Eigen/Geometry>

#include <map>

namespace bsv
{

using Color = std::array<double, 3>;
constexpr Color CreaseColor{ 0.05, 0.05, 0.05 };
constexpr Color NodeColor{ 0.95, 0.85, 0.1 };
/// That of all nets: vtkBlockPartsRepresentation.cxx.
constexpr Color BlockEdgeColor{ 0.52, 0.55, 0.62 };
/// Of extraordinary curves.
Color valenceColor(int valence);

enum class BlockPart
{
  Inner,
  Wall,
  Symmetry,
  FarField
};

/// What is shown of a mesh or volume, before it is known where it lies.
struct BlockPartsModel
{
  /// An outer face of a block.
  struct Face
  {
    int block;
    int face;
    /// Index into the boundary names, or -1.
    int tag;
    BlockPart part = BlockPart::FarField;
  };
  struct Curve
  {
    int block;
    int edge;
    Color color;
    /// Empty: those of the edge.
    std::vector<Vec3> points;
  };
  struct Node
  {
    int block;
    int corner;
  };

  const Ranks* ranks = nullptr;
  std::vector<int> rankOfBlock;
  std::vector<Face> faces;
  std::vector<std::array<int, 2>> innerEdges; ///< block and edge
  std::vector<Curve> curves;
  std::vector<Node> nodes;
  std::vector<std::string> boundaryNames;
  std::vector<std::string> boundaryTypes;
  /// Roles of the boundaries as a conversion took them (BSplineVolumeData.h), or empty.
  std::vector<int> roles;
  std::map<int, int> valences; ///< extraordinary edges per valence
  std::string wallText;

  bool isHere(int block) const { return this->rankOfBlock[block] == this->ranks->rank(); }
  bool isWallHere(const Face& face) const { return face.part == BlockPart::Wall && this->isHere(face.block); }

  /// Chooses the wall. @param coarse a face as few points; only called for those that are here
  void choosePart(const std::function<CoarseFace(const Face&)>& coarse, const Execution& run);
};

/// At most CoarseFacePoints of `count` indices 0..count - 1, the ends among them.
std::vector<int> coarseIndices(int count);

/// `last` times 0 or 1 per direction.
Ijk cornerPoint(const Ijk& last, int corner);

/// Field data BoundaryRoles, from whatever rank has it.
std::vector<int> rolesOf(vtkDataObject* input, const Ranks& ranks);

/// Lines within a distance of the wall.
class LineBuilder
{
public:
  /// @param box of the wall
  LineBuilder(const Eigen::AlignedBox3d& box, double reach);

  void line(const std::vector<Vec3>& points, const Color& color);
  void node(const Vec3& x, const Color& color);

  /// Of all that is in reach.
  std::vector<Color> colors() const;
  vtkSmartPointer<vtkPolyData> build();

private:
  bool isFar(const Vec3& x) const { return this->Radius > 0.0 && (x - this->Center).norm() > this->Radius; }

  Vec3 Center = Vec3::Zero();
  double Radius = 0.0;
  vtkNew<vtkPoints> Points;
  vtkNew<vtkCellArray> Verts, Lines;
  std::vector<Color> LineColors, NodeColors;
};

/// Points of a face, ns x nt of them.
struct FacePoints
{
  std::array<int, 2> counts;
  std::vector<Vec3> points;
};

/// The surfaces of one block.
class SurfaceBuilder
{
public:
  SurfaceBuilder();

  /// Quadrilaterals, counterclockwise around the normals: else the light comes from behind.
  /// @param source(s, t, cell) the point, or the cell, of the input's block; of cells that are left out -1
  void surface(const FacePoints& face, const std::vector<Vec3>& normals, int tag,
    const std::function<vtkIdType(int s, int t, bool cell)>& source);
  /// Of the points of the surfaces in their order; for all points or for none.
  void curvatures(const std::vector<double>& mean, const std::vector<double>& gaussian);

  /// @param grid whose arrays are taken along
  vtkSmartPointer<vtkPolyData> build(vtkStructuredGrid* grid, bool normals);

private:
  bool windsAgainstNormals(vtkIdType first, int ns, int nt) const;

  vtkNew<vtkPoints> Points;
  vtkNew<vtkFloatArray> Normals, Mean, Gaussian;
  vtkNew<vtkCellArray> Quads;
  vtkNew<vtkIntArray> Boundary;
  vtkNew<vtkIdTypeArray> SourcePoint, SourceCell;
};

/// A tree like the input's with surfaces in place of blocks. @param grids per block, null for those elsewhere
vtkSmartPointer<vtkDataObject> treeOf(vtkDataObject* input,
  const std::vector<vtkSmartPointer<vtkStructuredGrid>>& grids,
  const std::vector<vtkSmartPointer<vtkPolyData>>& surfaces);

/// Where the parts of a model lie.
struct BlockPartsShape
{
  /// Per block, null for those elsewhere.
  std::vector<vtkSmartPointer<vtkStructuredGrid>> grids;
  /// The wall, per block of `grids` that has some of it.
  std::map<int, SurfaceBuilder> wall;
  bool wallNormals = true;
  /// Of the wall here.
  Eigen::AlignedBox3d box;
  /// Nets of faces, edges of blocks and their corners.
  std::function<FacePoints(const BlockPartsModel::Face&)> net;
  std::function<std::vector<Vec3>(int block, int edge)> edge;
  std::function<Vec3(const BlockPartsModel::Node&)> corner;
};
/// Collective.
void buildParts(BlockParts& parts, vtkDataObject* input, const BlockPartsOptions& options, const BlockPartsModel& model,
  BlockPartsShape& shape);

/// What of the curves is in reach. Collective.
std::vector<BlockParts::Entry> legendOf(
  const BlockPartsModel& model, const std::vector<Color>& drawn, const BlockPartsOptions& options);

// By kind of input. Collective; they leave `surfaces` null if there is nothing to show.
bool isComplex(vtkDataObject* input, const Ranks& ranks);
void complexParts(BlockParts& parts, vtkDataObject* input, const BlockPartsOptions& options, const Execution& run);
void meshParts(BlockParts& parts, vtkDataObject* input, const BlockPartsOptions& options, const Execution& run);
void volumeParts(BlockParts& parts, vtkDataObject* input, const BlockPartsOptions& options, const Execution& run);

} // namespace bsv

#endif
