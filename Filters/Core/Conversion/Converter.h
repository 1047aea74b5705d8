// SPDX-License-Identifier: BSD-3-Clause
/// @file Converter.h
/// The conversion of one block complex, entity by entity: behind convertToBSplineVolume().
///
/// The control points of a block are those of its interior, copied, and those near its faces, edges and vertices, which
/// other blocks may share. Where the rules of each kind are:
/// - Conversion.cpp: blocks and faces, the regular rule across one face;
/// - EdgeConversion.cpp: the layers of quadrilaterals across an edge;
/// - VertexConversion.cpp: the star of a vertex, where layers of several directions meet;
/// - SurfaceConversion.cpp: the outer surface around a boundary vertex;
/// - BodyPropagation.cpp: what known points of the body change in the layers above.
#pragma once

#include "Complex/EdgeFans.h"
#include "Complex/LocalStars.h"
#include "Conversion/Conversion.h"
#include "Conversion/EntityRules.h"
#include "Conversion/FirstLayer.h"
#include "Conversion/LayerRules.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace bsv
{

/// @name Positions in the control net of a direction with `cells` mesh cells
/// From either end 0, 1, .. are the end point and the inserted point; mesh points keep their order between them.
///@{
constexpr int endPosition(int side, int fromEnd, int cells)
{
  return side == 0 ? fromEnd : cells + 2 - fromEnd;
}
constexpr int innerPosition(int meshIndex)
{
  return meshIndex + 1;
}
///@}

/// Each method computes the control points owned by one kind of entity and writes them into all blocks of this rank
/// that share it. Other ranks do the same for theirs. Different entities may be converted at the same time.
class Converter
{
public:
  /// The constructor and convert() are collective.
  Converter(const LocalStars& stars, const ConversionOptions& options, const std::vector<ControlNetStorage>& nets,
    const Execution& run)
    : Stars(stars)
    , Complex(stars.complex())
    , Options(options)
    , Nets(nets)
    , Run(run)
    , Rules(classify(stars, options, run))
    , Layer(stars.complex(), options, *run.ranks)
  {
  }

  ConversionReport convert();

private:
  bool isHere(int block) const { return this->Complex.blocks[block].rank == this->Run.ranks->rank(); }
  /// Converts the sides to which a far-field extension is attached, and places the extension's first layer after them.
  void placeExtension();

  struct Star;
  struct StackAxes;

  /// @name Control points owned by the interior of a block, face, edge, and by a vertex
  ///@{
  /// One layer of a block's interior. If `stream`, the memory is in order only after endStream().
  void convertBlock(int block, int slab, bool stream);
  void convertFace(int face);
  void convertEdge(int edge);
  void convertVertex(int vertex);
  ///@}
  RuleCounts countRules(int block) const;

  /// @name Layers of quadrilaterals across an edge
  ///@{
  /// Mesh points of layer k.
  Fan meshFan(const EdgeFan& fan, int k) const;
  /// Control points of layer k, before the rule along the edge. `base`: the layer next to it, if k is seen from there
  /// as the first layer off a wall or connection layer; where its c varies, points are put where the c of the edge has
  /// the effect of their own.
  Fan controlFan(int edge, const EdgeFan& fan, int k, int base = -1) const;
  /// Weight of the edge in the inserted points along each spoke of layer k.
  std::vector<double> nearWeights(const EdgeFan& fan, int k) const;
  /// Moves points as controlFan() says: those above the layer `base`, and sectors whose spokes leave a wall or
  /// connection layer.
  void adjustLayer(Fan& points, const EdgeFan& fan, int base) const;
  void adjustSectors(Fan& points, const EdgeFan& fan, int k) const;
  /// (1 - c) at one mesh point of a block's face over (1 - c) at another.
  double layerRatio(int block, int face, const Ijk& point, const Ijk& reference) const;
  /// How far the faces behind the spokes keep their points in layer k.
  std::vector<SpokeKeep> spokeKeeps(const EdgeFan& fan, int k) const;
  /// FaceRule::keep of a block's face at a mesh point.
  double keepAt(int block, int face, const Ijk& point) const;
  ///@}

  /// @name Star of a vertex: the results go into the star
  ///@{
  Star makeStar(int vertex) const;
  /// Moves points of faces and blocks in the same way.
  void adjustStar(Star& star) const;
  /// Control points of the layer k steps away from the vertex, across a star edge.
  Fan starLayer(const Star& star, int starEdge, int k) const;
  /// Tensor product of the masks, if all around the vertex is regular; otherwise does nothing and returns false.
  bool convertRegular(Star& star) const;
  /// Blocks in two stacks (or one, at the boundary) around an axis: the rule across the layers after the rule in them.
  /// Returns false, with the star unchanged, if the blocks do not lie so.
  bool convertStacked(Star& star) const;
  StackAxes stackAxes(const Star& star) const;
  bool areStacked(const Star& star, int up, int down) const;
  /// Everything else: inserted points between the centre, which is given, and the layers around it.
  void convertAnchored(Star& star) const;
  void writeStar(const Star& star) const;
  ///@}

  /// @name The outer surface around a boundary vertex: centre, inserted points on boundary edges and faces
  ///@{
  void convertSurface(Star& star) const;
  void convertTouchingSurfaces(Star& star) const;
  /// Smooth fan; on the body with the foot point and normal of an extraordinary vertex, if they are known.
  Fan smoothSurfaceFan(Star& star, const Fan& fan, const std::vector<double>& weights,
    const std::vector<SpokeKeep>& keeps, bool body) const;
  bool bodyFoot(const Star& star, const Fan& fan, BodyFoot& foot) const;
  /// The foot of the centre of `points` on the body's patch whose normal is nearest to that of `size` sectors of
  /// `points` from `first` on.
  bool sectorFoot(const Fan& points, int first, int size, BodyFoot& foot) const;
  /// Fills GivenPoints and GivenNormals.
  void collectGiven();
  /// Fills Corrections: carries what a known foot changed at extraordinary body vertices into the layers above them.
  void propagateFeet();
  /// A run of layers across one edge above an extraordinary body vertex, from one end of the edge to the other.
  struct Link;
  /// The first above a boundary vertex, or nothing, and the range of what is carried along it.
  std::optional<std::pair<Link, double>> firstLink(int vertex) const;
  /// Fills the link's distances, which start at `distance`; the link that continues it, if there is one.
  std::optional<Link> measure(Link& link, double distance, double range) const;
  /// Whether the boundary where the link ends may move with the layers below it.
  bool endMoves(const Link& link) const;
  /// Moves the outer surface at the end of layers that have not faded out there.
  void moveEnd(Star& star) const;
  ///@}

  /// Rule of inserted points off a connection layer, or else off a wall.
  static ControlPointRule layerRule(bool connection)
  {
    return connection ? ControlPointRule::FarFieldLayer : ControlPointRule::WallLayer;
  }
  bool isWall(int face) const
  {
    return this->Complex.faces[face].boundary() && this->Rules.faces[face].role == BoundaryRole::Body;
  }
  Index index(int block, const Ijk& position) const
  {
    const ComplexBlock& owner = this->Complex.blocks[block];
    return position[0] + Index(owner.cells(0) + 3) * (position[1] + Index(owner.cells(1) + 3) * position[2]);
  }
  void write(int block, const Ijk& position, const Vec3& point, ControlPointRule rule) const
  {
    if (!this->isHere(block))
    {
      return;
    }
    const Index i = this->index(block, position);
    std::copy_n(point.data(), 3, this->Nets[block].points + 3 * i);
    this->Nets[block].rules[i] = static_cast<std::uint8_t>(rule);
  }

  const LocalStars& Stars;
  const BlockComplex& Complex;
  const ConversionOptions& Options;
  const std::vector<ControlNetStorage>& Nets;
  const Execution& Run;
  const EntityRules Rules;
  FirstLayer Layer;
  /// Added to the control points of the layers across an edge: `delta`, in the order of the edge's fan, by a weight per
  /// layer.
  struct Correction
  {
    Fan delta;
    std::vector<double> weights;
    /// End of the edge where the outer surface moves with the layers, or -1.
    int movedEnd = -1;
  };
  std::map<int, std::vector<Correction>> Corrections;
  /// Per vertex of the body: ConversionOptions::projectedPoints and surfaceNormals.
  std::map<int, Vec3> GivenPoints, GivenNormals;
  std::atomic<Index> SingularNodes{ 0 };
};

/// A vertex star, what the rules must know of it, and the control points that they make.
struct Converter::Star : VertexStar
{
  /// Fan of a star edge; star-block index per sector and star-edge index per spoke.
  struct EdgeInfo
  {
    const EdgeFan* fan = nullptr;
    std::vector<int> spokes;
    std::vector<int> sectors;
    bool whole = true; ///< the edge has one fan only
  };

  int vertex = -1;
  bool boundary = false;
  /// Whether it lies in the connection layer of a far-field extension.
  bool connection = false;
  std::vector<EdgeInfo> info;
  /// Weight of the vertex in the inserted point along each star edge.
  std::vector<double> near;
  /// Star faces that keep points near the vertex (FaceRule::keep), and how far at the face's point.
  std::vector<bool> keptFaces;
  std::vector<double> diagonalKeep;

  /// Control points: the centre, and inserted ones along star edges, in star faces, in star blocks.
  Vec3 center;
  std::vector<Vec3> edgePoints, facePoints, blockPoints;
  ControlPointRule rule = ControlPointRule::Regular;
  std::vector<ControlPointRule> edgeRules, faceRules, blockRules;

  /// Whether the outer surface, once converted, has no feature here that a rule across layers would have to respect.
  bool surfaceIsSmooth = false;
  /// Whether it follows a foot point on the body.
  bool hasFoot = false;
  /// The two star edges of a crease through the vertex, or -1.
  std::array<int, 2> crease{ -1, -1 };

  /// Whether kept faces meet at one of the edges so that nothing around it is regular (keptLinesMeet()).
  bool keptFacesMeet() const;
  bool keepsPoints() const
  {
    return std::find(this->keptFaces.begin(), this->keptFaces.end(), true) != this->keptFaces.end();
  }
};

/// Star edges in opposite directions around which the blocks are stacked; -1: none.
struct Converter::StackAxes
{
  int up = -1;
  int down = -1;
};

} // namespace bsv
