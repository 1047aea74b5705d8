// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/G1Joins.h"

#include "Base/SortedSum.h"
#include "Body/ClosestPoint.h"
#include "Conversion/DoubleKnots.h"
#include "Conversion/FarField.h"
#include "Conversion/G1Fit.h"
#include "Conversion/LocalNet.h"
#include "Ranks/OwnedValues.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

namespace bsv
{
namespace
{

constexpr int Reach = 3;
/// Control points per direction that the fit needs: those of four spans.
constexpr int PatchSize = 8;
/// Control layers next to a singular node that stay as they are.
constexpr int NodeLayers = 4;

/// One sector of the layers of control points around an edge, or of the wall around a vertex: where they are in a
/// block.
struct NetSector
{
  int block;
  int along; ///< direction across the layers
  bool alongFromEnd;
  int first, second; ///< directions of the sector's spokes
  bool firstFromEnd, secondFromEnd;
};

/// The layers around one edge, or one layer of the wall around a vertex.
struct NetFan
{
  int edge = -1;
  int vertex = -1;
  /// The wall's smooth group from this spoke of the ring on, if it is one (else the fan is its own).
  std::vector<NetSector> sectors;
  LocalNetShape shape;
  int layers = 1;
  /// Cells along every spoke.
  std::vector<int> cells;
  /// Layers that stay at either end.
  std::array<int, 2> skipped{ 0, 0 };
};

/// What is added to the layers of a fan: `net` on the wall, with the weights of the layers.
struct Shift
{
  int fan;
  LocalNetShape shape;
  std::vector<Vec3> net;
  std::vector<double> weights;
};

class Joiner
{
public:
  Joiner(const ConversionContext& context, const std::vector<JoinedSpan>& avoid, bool joinNothing, const Execution& run)
    : Context(context)
    , Complex(context.complex)
    , Rules(context.rules)
    , Options(context.options)
    , Avoid(avoid)
    , JoinNothing(joinNothing)
    , Run(run)
    , FanOfEdge(context.complex.edges.size(), -1)
  {
  }

  G1Report join()
  {
    this->findFans();
    this->giveUp();
    for (const NetFan& fan : this->Fans)
    {
      this->JoinRuleOf.prepare(fan.shape);
      if (this->Options.twist == Twist::PCCM && PccmRule::fits(fan.shape))
      {
        this->PccmOf.emplace(fan.shape, fan.shape);
      }
    }
    for (const Group& group : this->Groups)
    {
      this->JoinRuleOf.prepare(group.shape);
    }
    this->gatherLayers();
    this->decideLayers();
    std::vector<std::vector<std::vector<Vec3>>> joined(this->Fans.size());
    this->shiftForGroups();
    this->forAllLayers(
      [&](int fan, int layer) {
        if (joined[fan].empty())
        {
          return;
        }
        std::vector<Vec3>& net = joined[fan][layer];
        net = this->netOf(fan, layer);
        if (this->isJoined(fan, layer))
        {
          const auto pccm = this->PccmOf.find(this->Fans[fan].shape);
          if (pccm != this->PccmOf.end())
          {
            pccm->second.apply(net);
          }
          else
          {
            this->JoinRuleOf.at(this->Fans[fan].shape).apply(net, true);
          }
        }
      },
      joined);
    for (std::size_t f = 0; f < this->Fans.size(); ++f)
    {
      for (std::size_t layer = 0; layer < joined[f].size(); ++layer)
      {
        this->write(this->Fans[f], static_cast<int>(layer), this->Fans[f].shape, joined[f][layer]);
      }
      for (int layer = 0; layer < this->Fans[f].layers; ++layer)
      {
        ++(this->isJoined(static_cast<int>(f), layer) ? this->Report.layers : this->Report.skippedLayers);
        this->Report.givenUpLayers += this->isGivenUp(static_cast<int>(f), layer) ? 1 : 0;
      }
      this->Report.edges += this->Fans[f].edge >= 0 ? 1 : 0;
    }
    this->evenShortSpokes();
    this->fitWall();
    return this->Report;
  }

private:
  bool isHere(int block) const { return this->Context.isHere(block); }
  int count(int block, int d) const { return this->Context.count(block, d); }
  bool isWall(int face) const { return this->Context.isWall(face); }
  static SpokeKind kindOf(int cells) { return static_cast<SpokeKind>(std::min(cells, 3)); }

  Ijk place(const NetSector& sector, int layer, int i, int j) const
  {
    Ijk position;
    const auto at = [&](
                      int d, bool fromEnd, int n) { position[d] = fromEnd ? this->count(sector.block, d) - 1 - n : n; };
    at(sector.along, sector.alongFromEnd, layer);
    at(sector.first, sector.firstFromEnd, i);
    at(sector.second, sector.secondFromEnd, j);
    return position;
  }
  Index index(int block, const Ijk& position) const { return this->Context.index(block, position); }
  Eigen::Map<Vec3> point(int block, const Ijk& position) const
  {
    return Eigen::Map<Vec3>(this->Context.nets[block].points + 3 * this->index(block, position));
  }

  /// The block's edge that runs along a spoke of the sector at the first (or last) layer.
  int spokeEdge(const NetSector& sector, bool second, bool lastLayer) const
  {
    const int d = second ? sector.second : sector.first;
    Ijk side{ 0, 0, 0 };
    side[sector.along] = sector.alongFromEnd != lastLayer ? 1 : 0;
    side[second ? sector.first : sector.second] = (second ? sector.firstFromEnd : sector.secondFromEnd) ? 1 : 0;
    return 4 * d + side[faceAxis(2 * d, 0)] + 2 * side[faceAxis(2 * d, 1)];
  }
  int endFace(const NetSector& sector, bool lastLayer) const
  {
    return 2 * sector.along + (sector.alongFromEnd != lastLayer ? 1 : 0);
  }
  /// Global edge of spoke k on the first or last layer.
  int edgeOfSpoke(const NetFan& fan, int k, bool lastLayer) const
  {
    const bool last = k == static_cast<int>(fan.sectors.size());
    const NetSector& sector = fan.sectors[last ? k - 1 : k];
    return this->Complex.blocks[sector.block].edges[this->spokeEdge(sector, last, lastLayer)];
  }

  //----------------------------------------------------------------------------
  // What is joined

  /// A smooth group of the wall's sectors between two creases, at an end of a closed fan.
  struct Group
  {
    int fan;
    bool lastLayer;
    int first; ///< spoke of the fan
    LocalNetShape shape;
  };
  /// An extraordinary vertex that is fitted: the first or last layer of a closed fan.
  struct WallVertex
  {
    int fan;
    bool lastLayer;
  };

  void findFans()
  {
    for (int e = 0; e < static_cast<int>(this->Complex.edges.size()); ++e)
    {
      this->addEdge(e);
    }
    for (std::size_t f = 0; f < this->Fans.size(); ++f)
    {
      this->setEnds(static_cast<int>(f));
    }
    for (int v = 0; v < static_cast<int>(this->Complex.vertices.size()); ++v)
    {
      this->addVertex(v);
    }
  }

  /// Marks the layers next to spans to avoid, and leaves out what is carried into these.
  void giveUp()
  {
    this->GivenUp.resize(this->Fans.size());
    for (std::size_t f = 0; f < this->Fans.size(); ++f)
    {
      const NetFan& fan = this->Fans[f];
      std::vector<bool>& given = this->GivenUp[f];
      given.assign(this->JoinNothing ? fan.layers : 0, true);
      for (const JoinedSpan& span : this->Avoid)
      {
        for (const NetSector& sector : fan.sectors)
        {
          // Nearest and farthest of the span's four control points from the edge or its first layer.
          const auto nearest = [&](int d, bool fromEnd) {
            return fromEnd ? this->count(span.block, d) - 4 - span.first[d] : span.first[d];
          };
          if (sector.block != span.block || nearest(sector.first, sector.firstFromEnd) > Reach + 1 ||
            nearest(sector.second, sector.secondFromEnd) > Reach + 1)
          {
            continue;
          }
          given.resize(fan.layers, false);
          const int first = fan.layers > 1 ? nearest(sector.along, sector.alongFromEnd) : 0;
          for (int layer = first; layer < std::min(first + 4, fan.layers); ++layer)
          {
            given[layer] = true;
          }
        }
      }
    }
    const auto touched = [&](const auto& end) { return !this->GivenUp[end.fan].empty(); };
    this->WallVertices.erase(
      std::remove_if(this->WallVertices.begin(), this->WallVertices.end(), touched), this->WallVertices.end());
    this->Groups.erase(std::remove_if(this->Groups.begin(), this->Groups.end(), touched), this->Groups.end());
  }

  bool isGivenUp(int f, int layer) const { return !this->GivenUp[f].empty() && this->GivenUp[f][layer]; }

  void addEdge(int e)
  {
    const EdgeRule& rule = this->Rules.edges[e];
    if (rule.anchored || rule.feature || rule.fans.size() != 1)
    {
      return;
    }
    const EdgeFan& around = rule.fans.front();
    const int n = static_cast<int>(around.sectors.size());
    if (n < 3 || (around.closed && n == 4))
    {
      return;
    }
    NetFan fan;
    fan.edge = e;
    fan.shape.closed = around.closed;
    fan.shape.sectors = n;
    fan.shape.reach = Reach;
    for (const FanSector& sector : around.sectors)
    {
      fan.sectors.push_back({ sector.block, sector.along, sector.reversed, sector.first, sector.second,
        sector.side(sector.first) != 0, sector.side(sector.second) != 0 });
    }
    for (int k = 0; k < fan.shape.spokes(); ++k)
    {
      fan.cells.push_back(this->Complex.edges[this->edgeOfSpoke(fan, k, false)].cells);
      fan.shape.kinds.push_back(kindOf(fan.cells.back()));
    }
    fan.layers = this->count(fan.sectors.front().block, fan.sectors.front().along);
    this->FanOfEdge[e] = static_cast<int>(this->Fans.size());
    this->Fans.push_back(std::move(fan));
  }

  /// An end of a fan.
  struct FanEnd
  {
    /// -1: none.
    int fan = -1;
    bool lastLayer = false;
  };

  /// The end at which the fan of the next edge continues one, with the blocks across the ends of all its sectors.
  FanEnd nextEnd(const NetFan& fan, bool lastLayer) const
  {
    const auto acrossOf = [&](const NetSector& sector) {
      return contactOf(this->Complex, sector.block, this->endFace(sector, lastLayer));
    };
    const FaceContact contact = acrossOf(fan.sectors.front());
    if (contact.block < 0)
    {
      return {};
    }
    const int vertex = this->vertexOf(fan, lastLayer);
    const ComplexBlock& above = this->Complex.blocks[contact.block];
    for (int e = 0; e < 12; ++e)
    {
      // The edge that rises from the contact at the vertex.
      if (edgeDirection(e) != faceDirection(contact.face) ||
        above.vertices[edgeCorner(e, faceSide(contact.face))] != vertex || this->FanOfEdge[above.edges[e]] < 0)
      {
        continue;
      }
      const int f = this->FanOfEdge[above.edges[e]];
      const NetFan& next = this->Fans[f];
      for (const bool last : { false, true })
      {
        const auto continues = [&](const NetSector& sector) {
          const FaceContact across = acrossOf(sector);
          return std::any_of(next.sectors.begin(), next.sectors.end(), [&](const NetSector& other) {
            return other.block == across.block && this->endFace(other, last) == across.face;
          });
        };
        if (next.shape.closed == fan.shape.closed && next.sectors.size() == fan.sectors.size() &&
          std::all_of(fan.sectors.begin(), fan.sectors.end(), continues))
        {
          return { f, last };
        }
      }
    }
    return {};
  }
  int vertexOf(const NetFan& fan, bool lastLayer) const
  {
    return fan.vertex >= 0 ? fan.vertex : this->Complex.edges[fan.edge].vertices[lastLayer ? 1 : 0];
  }

  /// Which layers at the ends of an edge stay, and where the wall at an end is fitted or has creases.
  void setEnds(int f)
  {
    NetFan& fan = this->Fans[f];
    const std::size_t n = fan.sectors.size();
    for (const bool lastLayer : { false, true })
    {
      const ComplexVertex& vertex = this->Complex.vertices[this->vertexOf(fan, lastLayer)];
      int& skipped = fan.skipped[lastLayer ? 1 : 0];
      if (vertex.corners.size() == 2 * n && this->nextEnd(fan, lastLayer).fan >= 0)
      {
        continue;
      }
      if (vertex.corners.size() != n || !vertex.boundary)
      {
        skipped = std::min(NodeLayers, fan.layers);
        continue;
      }
      // All blocks at the vertex are around the edge: the boundary is their first layer.
      std::vector<int> features;
      bool wall = true;
      for (int k = 0; k < fan.shape.spokes(); ++k)
      {
        if (this->Rules.edges[this->edgeOfSpoke(fan, k, lastLayer)].feature)
        {
          features.push_back(k);
        }
      }
      for (const NetSector& sector : fan.sectors)
      {
        wall = wall && this->isWall(this->Complex.blocks[sector.block].faces[this->endFace(sector, lastLayer)]);
      }
      if (!fan.shape.closed)
      {
        // Smooth up to its borders.
        const bool inside =
          std::any_of(features.begin(), features.end(), [&](int k) { return k > 0 && k < static_cast<int>(n); });
        skipped = inside ? 1 : 0;
        continue;
      }
      if (features.size() < 2)
      {
        if (wall)
        {
          this->WallVertices.push_back({ f, lastLayer });
        }
        continue;
      }
      skipped = 1;
      if (wall && features.size() == 2)
      {
        const int sizes[2] = { features[1] - features[0], static_cast<int>(n) - features[1] + features[0] };
        for (int c = 0; c < 2; ++c)
        {
          if (sizes[0] >= 2 && sizes[1] >= 2 && sizes[c] > 2)
          {
            this->Groups.push_back({ f, lastLayer, features[c], this->groupShape(fan, features[c], sizes[c]) });
          }
        }
      }
    }
  }

  static LocalNetShape groupShape(const NetFan& fan, int first, int size)
  {
    LocalNetShape shape;
    shape.closed = false;
    shape.sectors = size;
    shape.reach = Reach;
    for (int k = 0; k <= size; ++k)
    {
      shape.kinds.push_back(fan.shape.kinds[(first + k) % fan.shape.spokes()]);
    }
    return shape;
  }

  /// Wall around a boundary vertex that is no end of a single extraordinary edge.
  void addVertex(int v)
  {
    if (!this->Complex.vertices[v].boundary)
    {
      return;
    }
    const VertexStar star = vertexStar(this->Complex, v);
    const BoundaryRing ring = boundaryRing(star);
    const int n = static_cast<int>(ring.edges.size());
    int features = 0;
    bool wall = n >= 3 && n != 4;
    for (int i = 0; i < n && wall; ++i)
    {
      features += this->Rules.edges[star.edges[ring.edges[i]].edge].feature ? 1 : 0;
      wall = this->isWall(star.faces[ring.faces[i]].face);
    }
    const bool done = std::any_of(this->WallVertices.begin(), this->WallVertices.end(),
      [&](const WallVertex& other) { return this->vertexOf(this->Fans[other.fan], other.lastLayer) == v; });
    if (!wall || features >= 2 || done)
    {
      return;
    }
    NetFan fan;
    fan.vertex = v;
    fan.shape.sectors = n;
    fan.shape.reach = Reach;
    for (int i = 0; i < n; ++i)
    {
      const VertexStar::Face& face = star.faces[ring.faces[i]];
      const FaceUse& use = this->Complex.faces[face.face].uses.front();
      const ComplexBlock& block = this->Complex.blocks[use.block];
      const int axes[2] = { faceAxis(use.face, 0), faceAxis(use.face, 1) };
      const bool ends[2] = { (face.corner & 1) != 0, (face.corner >> 1) != 0 };
      NetSector sector{ use.block, faceDirection(use.face), faceSide(use.face) != 0, axes[0], axes[1], ends[0],
        ends[1] };
      const VertexStar::Edge& from = star.edges[ring.edges[i]];
      const int edge = this->spokeEdge(sector, false, false);
      const int end = (ends[0] ? 1 : 0) ^ (block.edgeReversed[edge] ? 1 : 0);
      if (block.edges[edge] != from.edge || end != from.end)
      {
        std::swap(sector.first, sector.second);
        std::swap(sector.firstFromEnd, sector.secondFromEnd);
      }
      fan.sectors.push_back(sector);
      fan.cells.push_back(this->Complex.edges[from.edge].cells);
      fan.shape.kinds.push_back(kindOf(fan.cells.back()));
    }
    this->WallVertices.push_back({ static_cast<int>(this->Fans.size()), false });
    this->Fans.push_back(std::move(fan));
  }

  //----------------------------------------------------------------------------
  // Reading

  /// Lists of numbers of all sectors, on all ranks.
  template <typename ListOf>
  std::vector<std::vector<std::vector<double>>> gatherSectors(const std::vector<int>& fans, const ListOf& listOf) const
  {
    std::vector<std::pair<int, int>> sectors;
    for (std::size_t i = 0; i < fans.size(); ++i)
    {
      for (std::size_t k = 0; k < this->Fans[fans[i]].sectors.size(); ++k)
      {
        sectors.emplace_back(static_cast<int>(i), static_cast<int>(k));
      }
    }
    auto lists = gatherListsFromOwners<double>(
      *this->Run.ranks, sectors.size(),
      [&](std::size_t s) {
        return this->Complex.blocks[this->Fans[fans[sectors[s].first]].sectors[sectors[s].second].block].rank;
      },
      [&](std::size_t s) { return listOf(sectors[s].first, sectors[s].second); });
    std::vector<std::vector<std::vector<double>>> result(fans.size());
    for (std::size_t s = 0; s < sectors.size(); ++s)
    {
      result[sectors[s].first].push_back(std::move(lists[s]));
    }
    return result;
  }

  /// Points of all layers of all fans: per sector and layer whether it is kept, then its 4 x 4 points.
  void gatherLayers()
  {
    std::vector<int> all(this->Fans.size());
    for (std::size_t f = 0; f < all.size(); ++f)
    {
      all[f] = static_cast<int>(f);
    }
    this->Layers = this->gatherSectors(all, [&](int f, int k) {
      const NetFan& fan = this->Fans[f];
      const NetSector& sector = fan.sectors[k];
      std::vector<double> list(LayerSize * fan.layers);
      double* to = list.data();
      for (int layer = 0; layer < fan.layers; ++layer)
      {
        *to++ = this->keeps(fan, sector, layer) ? 1.0 : 0.0;
        for (int j = 0; j <= Reach; ++j)
        {
          for (int i = 0; i <= Reach; ++i, to += 3)
          {
            Eigen::Map<Vec3>{ to } = this->point(sector.block, this->place(sector, layer, i, j));
          }
        }
      }
      return list;
    });
  }
  static constexpr std::size_t LayerSize = 1 + 3 * (Reach + 1) * (Reach + 1);

  /// Whether a face behind a spoke keeps its points, in the mesh layers that the control layer depends on.
  bool keeps(const NetFan& fan, const NetSector& sector, int layer) const
  {
    if (fan.edge < 0)
    {
      return false;
    }
    const ComplexBlock& block = this->Complex.blocks[sector.block];
    bool any = false;
    for (const bool second : { false, true })
    {
      // The face spanned by the edge and the spoke.
      const int normal = second ? sector.first : sector.second;
      const int face = 2 * normal + ((second ? sector.firstFromEnd : sector.secondFromEnd) ? 1 : 0);
      const std::vector<double>& keep = this->Context.keeps[block.faces[face]];
      if (keep.empty())
      {
        continue;
      }
      const int cells = block.cells(sector.along);
      const auto stencils = knotInsertion(cells, this->Context.isDoubled(sector.block, sector.along));
      const KnotInsertionStencil& stencil = stencils[layer];
      for (int old = stencil.first; old < stencil.first + stencil.terms; ++old)
      {
        // Ends and inserted points depend on the first two mesh layers.
        const int low = old <= 1 ? 0 : old > cells ? cells - 1 : old - 1;
        const int high = old <= 1 ? std::min(1, cells) : old > cells ? cells : old - 1;
        for (int k = low; k <= high; ++k)
        {
          for (int step = 0; step < 2; ++step)
          {
            Ijk ijk{ 0, 0, 0 };
            const int d = second ? sector.second : sector.first;
            const bool fromEnd = second ? sector.secondFromEnd : sector.firstFromEnd;
            ijk[sector.along] = sector.alongFromEnd ? cells - k : k;
            ijk[d] = fromEnd ? block.cells(d) - step : step;
            any = any ||
              keep[keepIndex(this->Complex, sector.block, face, ijk[faceAxis(face, 0)], ijk[faceAxis(face, 1)])] > 0.0;
          }
        }
      }
    }
    return any;
  }

  Vec3 gathered(int f, int layer, int sector, int i, int j) const
  {
    return Vec3(this->Layers[f][sector].data() + LayerSize * layer + 1 + 3 * (i + (Reach + 1) * j));
  }

  bool isJoined(int f, int layer) const { return this->Joined[f][layer]; }

  /// Which layers are joined: one that ends at the next fan is a layer of that, too, and both must agree.
  void decideLayers()
  {
    for (std::size_t f = 0; f < this->Fans.size(); ++f)
    {
      this->Joined.emplace_back();
      for (int layer = 0; layer < this->Fans[f].layers; ++layer)
      {
        this->Joined[f].push_back(this->canJoin(static_cast<int>(f), layer));
      }
    }
    for (std::size_t f = 0; f < this->Fans.size(); ++f)
    {
      const NetFan& fan = this->Fans[f];
      for (const bool lastLayer : { false, true })
      {
        const FanEnd next = fan.edge >= 0 ? this->nextEnd(fan, lastLayer) : FanEnd{};
        const int layer = lastLayer ? fan.layers - 1 : 0;
        if (next.fan >= 0 && !this->canJoin(next.fan, next.lastLayer ? this->Fans[next.fan].layers - 1 : 0))
        {
          this->Joined[f][layer] = false;
        }
      }
    }
  }

  bool canJoin(int f, int layer) const
  {
    const NetFan& fan = this->Fans[f];
    if (layer < fan.skipped[0] || layer >= fan.layers - fan.skipped[1] || this->isGivenUp(f, layer))
    {
      return false;
    }
    return std::none_of(this->Layers[f].begin(), this->Layers[f].end(),
      [&](const std::vector<double>& list) { return list[LayerSize * layer] != 0.0; });
  }

  /// The local net of a layer, with what creases shift.
  std::vector<Vec3> netOf(int f, int layer) const
  {
    const NetFan& fan = this->Fans[f];
    std::vector<Vec3> net(fan.shape.size());
    for (int k = 0; k < fan.shape.sectors; ++k)
    {
      for (int j = 0; j <= Reach; ++j)
      {
        for (int i = 0; i <= Reach; ++i)
        {
          net[fan.shape.sector(k, i, j)] = this->gathered(f, layer, k, i, j);
        }
      }
    }
    const auto shifts = this->GroupShifts.find(f);
    if (shifts != this->GroupShifts.end())
    {
      for (std::size_t a = 0; a < net.size(); ++a)
      {
        std::vector<Vec3> changes;
        for (const Shift& shift : shifts->second)
        {
          changes.push_back(shift.weights[layer] * shift.net[a]);
        }
        net[a] += sortedSum(changes);
      }
    }
    return net;
  }

  template <typename Body>
  void forAllLayers(const Body& body, std::vector<std::vector<std::vector<Vec3>>>& results)
  {
    std::vector<std::pair<int, int>> layers;
    for (std::size_t f = 0; f < this->Fans.size(); ++f)
    {
      if (!this->concerns(this->Fans[f]))
      {
        continue;
      }
      results[f].resize(this->Fans[f].layers);
      for (int layer = 0; layer < this->Fans[f].layers; ++layer)
      {
        layers.emplace_back(static_cast<int>(f), layer);
      }
    }
    this->Run.parallelFor(static_cast<Index>(layers.size()), 8, [&](Index begin, Index end) {
      for (Index i = begin; i < end; ++i)
      {
        body(layers[i].first, layers[i].second);
      }
    });
  }

  /// Whether this rank has points of the fan, or copies of them.
  bool concerns(const NetFan& fan) const
  {
    bool any = false;
    for (const NetSector& sector : fan.sectors)
    {
      any = any || this->isHere(sector.block);
    }
    for (int k = 0; k < fan.shape.spokes() && !any; ++k)
    {
      for (const bool lastLayer : { false, true })
      {
        for (const EdgeUse& use : this->Complex.edges[this->edgeOfSpoke(fan, k, lastLayer)].uses)
        {
          any = any || this->isHere(use.block);
        }
      }
    }
    return any;
  }

  //----------------------------------------------------------------------------
  // Writing

  /// Calls body(block, position) for all copies on this rank of point i of spoke k in a layer.
  template <typename Body>
  void forSpokeCopies(const NetFan& fan, int layer, int k, int i, const Body& body) const
  {
    const bool first = layer == 0, last = layer == fan.layers - 1 && fan.layers > 1;
    if (!first && !last)
    {
      return;
    }
    const bool end = k == static_cast<int>(fan.sectors.size());
    const NetSector& sector = fan.sectors[end ? k - 1 : k];
    const ComplexBlock& block = this->Complex.blocks[sector.block];
    const int edge = this->spokeEdge(sector, end, last);
    const int d = edgeDirection(edge);
    const bool fromEnd = (end ? sector.secondFromEnd : sector.firstFromEnd);
    const int count = this->count(sector.block, d);
    const int own = fromEnd ? count - 1 - i : i;
    const int global = block.edgeReversed[edge] ? count - 1 - own : own;
    for (const EdgeUse& use : this->Complex.edges[block.edges[edge]].uses)
    {
      if (!this->isHere(use.block))
      {
        continue;
      }
      Ijk position;
      position[edgeDirection(use.edge)] = use.reversed ? count - 1 - global : global;
      for (int axis = 0; axis < 2; ++axis)
      {
        const int across = faceAxis(2 * edgeDirection(use.edge), axis);
        position[across] = edgeSide(use.edge, axis) ? this->count(use.block, across) - 1 : 0;
      }
      body(use.block, position);
    }
  }

  /// Calls body(point of the net, block, position) for all copies on this rank of the points of a layer, but for its
  /// centre. A copy of a spoke can come twice.
  template <typename Body>
  void forCopies(const NetFan& fan, int layer, const LocalNetShape& shape, const Body& body) const
  {
    for (int k = 0; k < shape.sectors; ++k)
    {
      const NetSector& sector = fan.sectors[k];
      if (!this->isHere(sector.block))
      {
        continue;
      }
      for (int j = 0; j <= shape.reach; ++j)
      {
        for (int i = 0; i <= shape.reach; ++i)
        {
          if (i + j > 0)
          {
            body(shape.sector(k, i, j), sector.block, this->place(sector, layer, i, j));
          }
        }
      }
    }
    for (int k = 0; k < shape.spokes(); ++k)
    {
      for (int i = 1; i <= shape.reach; ++i)
      {
        this->forSpokeCopies(
          fan, layer, k, i, [&](int block, const Ijk& position) { body(shape.spoke(k, i), block, position); });
      }
    }
  }

  /// The rule of a control point that was changed.
  void mark(int block, Index place) const
  {
    std::uint8_t& rule = this->Context.nets[block].rules[place];
    if (rule == static_cast<std::uint8_t>(ControlPointRule::Copied) ||
      rule == static_cast<std::uint8_t>(ControlPointRule::Regular))
    {
      rule = static_cast<std::uint8_t>(ControlPointRule::ExtraordinaryEdge);
    }
  }

  void write(const NetFan& fan, int layer, const LocalNetShape& shape, const std::vector<Vec3>& net) const
  {
    if (net.empty())
    {
      return;
    }
    this->forCopies(fan, layer, shape, [&](int a, int block, const Ijk& position) {
      auto to = this->point(block, position);
      if (to != net[a])
      {
        to = net[a];
        this->mark(block, this->index(block, position));
      }
    });
  }

  //----------------------------------------------------------------------------
  // What is carried into the layers

  /// The weights of a shift on the layers of a fan and of those that continue it, from an end of the fan on.
  std::vector<Shift> chain(int start, bool lastLayer, const LocalNetShape& shape, const std::vector<Vec3>& net) const
  {
    const NetFan& first = this->Fans[start];
    if (first.edge < 0)
    {
      return { { start, shape, net, { 1.0 } } };
    }
    const int wallLayer = lastLayer ? first.layers - 1 : 0;
    std::vector<double> lengths;
    for (int k = 0; k < first.shape.sectors; ++k)
    {
      const Vec3 p = this->gathered(start, wallLayer, k, 0, 0);
      lengths.push_back(3.0 * (this->gathered(start, wallLayer, k, 1, 0) - p).norm() / first.shape.delta(k));
    }
    std::sort(lengths.begin(), lengths.end());
    double range = 0.0;
    for (const double length : lengths)
    {
      range += this->Options.propagationRange * length / static_cast<double>(lengths.size());
    }

    std::vector<Shift> shifts;
    std::vector<std::vector<double>> distances;
    Shift current{ start, shape, net, {} };
    bool fromLast = lastLayer;
    double distance = 0.0, cut = -1.0;
    while (cut < 0.0)
    {
      const NetFan& fan = this->Fans[current.fan];
      distances.emplace_back(fan.layers);
      Vec3 before = this->gathered(current.fan, fromLast ? fan.layers - 1 : 0, 0, 0, 0);
      for (int step = 0; step < fan.layers; ++step)
      {
        const int layer = fromLast ? fan.layers - 1 - step : step;
        const Vec3 here = this->gathered(current.fan, layer, 0, 0, 0);
        distance += (here - before).norm();
        distances.back()[layer] = distance;
        before = here;
      }
      const int left = fan.skipped[fromLast ? 0 : 1];
      const bool toLast = !fromLast;
      shifts.push_back(current);
      const ComplexVertex& top = this->Complex.vertices[this->vertexOf(fan, toLast)];
      const FanEnd next = this->nextEnd(fan, toLast);
      if (distance >= range)
      {
        cut = range;
      }
      else if (left >= NodeLayers)
      {
        const int layer = std::max(0, std::min(fan.layers - 1, toLast ? fan.layers - left : left - 1));
        cut = distances.back()[layer];
      }
      else if (next.fan < 0 || top.boundary || shifts.size() > this->Complex.edges.size())
      {
        // A thin stack moves with the wall; what must stay where it is does not.
        bool stays = left > 0;
        for (const NetSector& sector : fan.sectors)
        {
          const FaceRule& face =
            this->Rules.faces[this->Complex.blocks[sector.block].faces[this->endFace(sector, toLast)]];
          stays = stays || face.planar() || face.role != BoundaryRole::Other;
        }
        cut = stays ? std::min(range, distance) : range;
      }
      else
      {
        current = this->continued(current, toLast, next);
        fromLast = next.lastLayer;
      }
    }
    for (std::size_t i = 0; i < shifts.size(); ++i)
    {
      for (const double d : distances[i])
      {
        shifts[i].weights.push_back(d == 0.0 ? 1.0 : d < cut ? 1.0 - d / cut : 0.0);
      }
    }
    return shifts;
  }

  /// The same shift in the order of the next fan.
  Shift continued(const Shift& shift, bool toLast, const FanEnd& next) const
  {
    const NetFan& fan = this->Fans[shift.fan];
    const NetFan& above = this->Fans[next.fan];
    const int n = static_cast<int>(fan.sectors.size());
    const auto placeOf = [&](int k) {
      const NetSector& sector = fan.sectors[k];
      const FaceContact contact = contactOf(this->Complex, sector.block, this->endFace(sector, toLast));
      return static_cast<int>(std::find_if(above.sectors.begin(), above.sectors.end(),
                                [&](const NetSector& other) {
                                  return other.block == contact.block &&
                                    this->endFace(other, next.lastLayer) == contact.face;
                                }) -
        above.sectors.begin());
    };
    const int zero = placeOf(0), one = placeOf(1);
    const bool same = one == zero + 1 || (fan.shape.closed && one == (zero + 1) % n);
    Shift result = shift;
    result.fan = next.fan;
    result.shape.kinds = above.shape.kinds;
    for (int k = 0; k < n; ++k)
    {
      const int own = ((same ? zero + k : zero - k) % n + n) % n;
      for (int j = 0; j <= shift.shape.reach; ++j)
      {
        for (int i = 0; i <= shift.shape.reach; ++i)
        {
          result.net[same ? shift.shape.sector(own, i, j) : shift.shape.sector(own, j, i)] =
            shift.net[shift.shape.sector(k, i, j)];
        }
      }
    }
    return result;
  }

  /// Groups of the wall between two creases are joined on the wall, and the change is carried into the layers before
  /// they are joined.
  void shiftForGroups()
  {
    for (const Group& group : this->Groups)
    {
      const NetFan& fan = this->Fans[group.fan];
      const int layer = group.lastLayer ? fan.layers - 1 : 0;
      std::vector<Vec3> net(group.shape.size());
      const auto forGroup = [&](const auto& body) {
        for (int k = 0; k < group.shape.sectors; ++k)
        {
          const int own = (group.first + k) % fan.shape.sectors;
          for (int j = 0; j <= Reach; ++j)
          {
            for (int i = 0; i <= Reach; ++i)
            {
              body(group.shape.sector(k, i, j), fan.shape.sector(own, i, j), own, i, j);
            }
          }
        }
      };
      forGroup([&](int a, int, int sector, int i, int j) { net[a] = this->gathered(group.fan, layer, sector, i, j); });
      const std::vector<Vec3> before = net;
      this->JoinRuleOf.at(group.shape).apply(net, true);
      std::vector<Vec3> change(fan.shape.size(), Vec3::Zero());
      forGroup([&](int a, int b, int, int, int) { change[b] = net[a] - before[a]; });
      for (Shift& shift : this->chain(group.fan, group.lastLayer, fan.shape, change))
      {
        this->GroupShifts[shift.fan].push_back(std::move(shift));
      }
    }
  }

  //----------------------------------------------------------------------------
  // Spokes of less than three cells

  /// Condition (d) for the points between the ends: there all points depend on the extraordinary ones.
  void evenShortSpokes()
  {
    std::vector<int> fans;
    for (std::size_t f = 0; f < this->Fans.size(); ++f)
    {
      const std::vector<SpokeKind>& kinds = this->Fans[f].shape.kinds;
      if (std::any_of(kinds.begin(), kinds.end(), [](SpokeKind kind) { return kind < 3; }))
      {
        fans.push_back(static_cast<int>(f));
      }
    }
    // Points 4 .. along both spokes of each sector, on them and next to them, in all layers.
    const auto lengthOf = [&](const NetFan& fan, int k) {
      return fan.shape.kinds[k] < 3 ? controlPointCount(fan.cells[k], true) : 0;
    };
    const auto lists = this->gatherSectors(fans, [&](int i, int k) {
      const NetFan& fan = this->Fans[fans[i]];
      std::vector<double> list;
      for (int layer = 0; layer < fan.layers; ++layer)
      {
        for (const bool second : { false, true })
        {
          const int length = lengthOf(fan, (k + (second ? 1 : 0)) % fan.shape.spokes());
          for (int across = 0; across < 2; ++across)
          {
            for (int at = 0; at < length; ++at)
            {
              const Vec3 x = this->point(fan.sectors[k].block,
                second ? this->place(fan.sectors[k], layer, across, at)
                       : this->place(fan.sectors[k], layer, at, across));
              list.insert(list.end(), x.data(), x.data() + 3);
            }
          }
        }
      }
      return list;
    });
    for (std::size_t i = 0; i < fans.size(); ++i)
    {
      this->evenShortSpokes(fans[i], lists[i], lengthOf);
    }
  }

  template <typename LengthOf>
  void evenShortSpokes(int f, const std::vector<std::vector<double>>& lists, const LengthOf& lengthOf) const
  {
    const NetFan& fan = this->Fans[f];
    const LocalNetShape& shape = fan.shape;
    for (int k = 0; k < shape.spokes(); ++k)
    {
      if (!shape.isJoined(k) || shape.kinds[k] > 2)
      {
        continue;
      }
      const int n = shape.spokes();
      const int before = (k + shape.sectors - 1) % shape.sectors;
      const int length = lengthOf(fan, k);
      const double wl = 1.0 / shape.delta((k + n - 1) % n), wr = 1.0 / shape.delta((k + 1) % n);
      const auto listed = [&](int sector, int layer, bool second, int across, int at) {
        const int lengths[2] = { lengthOf(fan, sector), lengthOf(fan, (sector + 1) % n) };
        const std::size_t perLayer = 2 * (lengths[0] + lengths[1]);
        return Vec3(lists[sector].data() +
          3 * (perLayer * layer + (second ? 2 * lengths[0] : 0) + across * lengths[second ? 1 : 0] + at));
      };
      for (int layer = 0; layer < fan.layers; ++layer)
      {
        const int last = !this->isJoined(f, layer) ? 0 : this->isJoinedBeyond(fan, k, layer) ? length - 5 : length - 3;
        for (int i = 4; i <= last; ++i)
        {
          const Vec3 c = listed(k % shape.sectors, layer, k == shape.sectors, 0, i);
          const Vec3 l = listed(before, layer, true, 1, i), r = listed(k, layer, false, 1, i);
          const Vec3 defect = wl * (l - c) + wr * (r - c);
          const auto put = [&](const NetSector& sector, const Ijk& position, const Vec3& x) {
            if (this->isHere(sector.block))
            {
              this->point(sector.block, position) = x;
              this->mark(sector.block, this->index(sector.block, position));
            }
          };
          put(fan.sectors[before], this->place(fan.sectors[before], layer, 1, i), l - defect / (2.0 * wl));
          put(fan.sectors[k], this->place(fan.sectors[k], layer, i, 1), r - defect / (2.0 * wr));
        }
      }
    }
  }

  /// Whether a layer is joined at the other end of a spoke, too.
  bool isJoinedBeyond(const NetFan& fan, int k, int layer) const
  {
    const bool end = k == static_cast<int>(fan.sectors.size());
    const NetSector& sector = fan.sectors[end ? k - 1 : k];
    if (layer == 0 || layer == fan.layers - 1)
    {
      const bool lastLayer = layer > 0;
      const ComplexEdge& edge = this->Complex.edges[this->edgeOfSpoke(fan, k, lastLayer)];
      const int vertex = this->vertexOf(fan, lastLayer);
      for (const WallVertex& other : this->WallVertices)
      {
        const int v = this->vertexOf(this->Fans[other.fan], other.lastLayer);
        if (v != vertex && (v == edge.vertices[0] || v == edge.vertices[1]))
        {
          return true;
        }
      }
    }
    if (fan.edge < 0)
    {
      return false;
    }
    const int d = end ? sector.second : sector.first;
    const bool fromEnd = end ? sector.secondFromEnd : sector.firstFromEnd;
    Ijk side{ 0, 0, 0 };
    side[d] = fromEnd ? 0 : 1;
    const int across = end ? sector.first : sector.second;
    side[across] = (end ? sector.firstFromEnd : sector.secondFromEnd) ? 1 : 0;
    const int edge = 4 * sector.along + side[faceAxis(2 * sector.along, 0)] + 2 * side[faceAxis(2 * sector.along, 1)];
    const ComplexBlock& block = this->Complex.blocks[sector.block];
    const int beyond = this->FanOfEdge[block.edges[edge]];
    return beyond >= 0 &&
      this->isJoined(beyond, sector.alongFromEnd != block.edgeReversed[edge] ? fan.layers - 1 - layer : layer);
  }

  //----------------------------------------------------------------------------
  // The wall

  void fitWall()
  {
    const BodySurface* body = this->Options.twist == Twist::PCCM ? nullptr : this->Options.body;
    std::vector<WallVertex> vertices;
    std::vector<int> fans;
    std::set<int> fitted;
    for (const WallVertex& vertex : this->WallVertices)
    {
      // Nets on fewer cells share points.
      const std::vector<int>& cells = this->Fans[vertex.fan].cells;
      if (body && *std::min_element(cells.begin(), cells.end()) >= Reach)
      {
        vertices.push_back(vertex);
        fans.push_back(vertex.fan);
        fitted.insert(this->vertexOf(this->Fans[vertex.fan], vertex.lastLayer));
      }
    }
    this->Report.linearVertices = static_cast<Index>(this->WallVertices.size() - vertices.size());
    if (vertices.empty())
    {
      return;
    }
    // Neighbours that are near see what the others did, once.
    std::vector<std::vector<std::vector<double>>> unfitted;
    std::vector<int> reaches(fans.size(), 0);
    for (int sweep = 0; sweep < 2; ++sweep)
    {
      const auto lists = this->wallPoints(vertices, fans);
      if (sweep == 0)
      {
        unfitted = lists;
      }
      // Reach, then the changes of a net of that reach.
      std::vector<std::vector<double>> changes(fans.size(), { 0.0 });
      const Ranks& ranks = *this->Run.ranks;
      this->Run.parallelFor(static_cast<Index>(fans.size()), 1, [&](Index begin, Index end) {
        for (Index i = begin; i < end; ++i)
        {
          const WallPatch patch = this->wallPatch(vertices[i], fitted, lists[i], unfitted[i]);
          const bool alone = std::all_of(patch.others.begin(), patch.others.end(),
            [](const std::array<bool, 3>& others) { return !others[0] && !others[1] && !others[2]; });
          if (static_cast<int>(i % ranks.size()) == ranks.rank() && !(alone && sweep > 0))
          {
            changes[i] = this->fitVertex(patch);
          }
        }
      });
      changes = gatherListsFromOwners<double>(
        ranks, fans.size(), [&](std::size_t i) { return static_cast<int>(i % ranks.size()); },
        [&](std::size_t i) { return changes[i]; });
      std::vector<Change> onRank;
      for (std::size_t i = 0; i < fans.size(); ++i)
      {
        LocalNetShape shape = this->Fans[fans[i]].shape;
        shape.reach = static_cast<int>(changes[i][0]);
        if (shape.reach == 0)
        {
          continue;
        }
        reaches[i] = shape.reach;
        std::vector<Vec3> net(shape.size());
        for (std::size_t a = 0; a < net.size(); ++a)
        {
          net[a] = Vec3(changes[i].data() + 1 + 3 * a);
        }
        this->listChanges(this->chain(fans[i], vertices[i].lastLayer, shape, net), onRank);
      }
      this->apply(std::move(onRank));
    }
    for (const int reach : reaches)
    {
      ++(reach == 0 ? this->Report.linearVertices : this->Report.fittedVertices);
      this->Report.smallFits += reach == 3 ? 1 : 0;
    }
    this->evenShortSpokes();
  }

  std::vector<std::vector<std::vector<double>>> wallPoints(
    const std::vector<WallVertex>& vertices, const std::vector<int>& fans) const
  {
    return this->gatherSectors(fans, [&](int i, int k) {
      const NetFan& fan = this->Fans[fans[i]];
      const int layer = vertices[i].lastLayer ? fan.layers - 1 : 0;
      std::vector<double> list;
      for (int b = 0; b < PatchSize; ++b)
      {
        for (int a = 0; a < PatchSize; ++a)
        {
          const Vec3 x = this->point(fan.sectors[k].block, this->place(fan.sectors[k], layer, a, b));
          list.insert(list.end(), x.data(), x.data() + 3);
        }
      }
      return list;
    });
  }

  WallPatch wallPatch(const WallVertex& vertex, const std::set<int>& fitted,
    const std::vector<std::vector<double>>& lists, const std::vector<std::vector<double>>& unfitted) const
  {
    const NetFan& fan = this->Fans[vertex.fan];
    WallPatch patch;
    patch.size = PatchSize;
    patch.cells = fan.cells;
    for (int k = 0; k < fan.shape.sectors; ++k)
    {
      const NetSector& sector = fan.sectors[k];
      patch.others.emplace_back();
      // The vertices at the far end of one spoke, of the other, and of both.
      for (int far = 1; far < 4; ++far)
      {
        const bool isFar[2] = { (far & 1) != 0, (far & 2) != 0 };
        Ijk side{ 0, 0, 0 };
        side[sector.along] = faceSide(this->endFace(sector, vertex.lastLayer));
        side[sector.first] = sector.firstFromEnd != isFar[0] ? 1 : 0;
        side[sector.second] = sector.secondFromEnd != isFar[1] ? 1 : 0;
        const bool near =
          (!isFar[0] || fan.cells[k] < PatchSize) && (!isFar[1] || fan.cells[(k + 1) % fan.shape.spokes()] < PatchSize);
        const int corner = side[0] + 2 * side[1] + 4 * side[2];
        patch.others.back()[far - 1] = near && fitted.count(this->Complex.blocks[sector.block].vertices[corner]) > 0;
      }
      for (const bool before : { false, true })
      {
        std::vector<Vec3>& points = (before ? patch.unfitted : patch.sectors).emplace_back();
        for (int a = 0; a < PatchSize * PatchSize; ++a)
        {
          points.emplace_back((before ? unfitted : lists)[k].data() + 3 * a);
        }
      }
    }
    return patch;
  }

  std::vector<double> fitVertex(const WallPatch& patch) const
  {
    const BodySurface& body = *this->Options.body;
    const BodyPoint at = body.closestPoint(patch.sectors[0][0]);
    const std::function<FootPoint(const Vec3&)> closest = [&](const Vec3& x) {
      const BodyPoint found = body.closestPoint(x);
      return FootPoint{ found.geometry.point, found.geometry.normal };
    };
    std::vector<double> changes{ 0.0 };
    if (!(at.geometry.normal.norm() > 0.0))
    {
      return changes;
    }
    // The largest curvature around: at the vertex alone the body may be nearly flat.
    const auto curvatureAt = [&](const Vec3& x) {
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> curvatures(body.closestPoint(x).geometry.curvature);
      return curvatures.eigenvalues().cwiseAbs().maxCoeff();
    };
    double curvature = curvatureAt(at.geometry.point);
    for (const std::vector<Vec3>& sector : patch.sectors)
    {
      for (const int a : { Reach, Reach + PatchSize * Reach })
      {
        curvature = std::max(curvature, curvatureAt(sector[a]));
      }
    }
    const G1FitResult fit = fitToBody(patch, { patch.sectors[0][0], at.geometry.normal }, curvature, closest);
    changes[0] = fit.reach;
    if (fit.reach > 0)
    {
      changes.resize(1 + 3 * fit.net.size());
      for (int k = 0; k < fit.shape.sectors; ++k)
      {
        for (int j = 0; j <= fit.reach; ++j)
        {
          for (int i = 0; i <= fit.reach; ++i)
          {
            const int a = fit.shape.sector(k, i, j);
            const Vec3 change = fit.net[a] - patch.sectors[k][i + PatchSize * j];
            std::copy_n(change.data(), 3, changes.data() + 1 + 3 * a);
          }
        }
      }
    }
    return changes;
  }

  struct Change
  {
    int block;
    Index place;
    Vec3 by;
  };

  /// What a chain of shifts changes on this rank: each place once, also where two of its fans meet.
  void listChanges(const std::vector<Shift>& chain, std::vector<Change>& changes) const
  {
    std::map<std::pair<int, Index>, Vec3> places;
    for (const Shift& shift : chain)
    {
      const NetFan& fan = this->Fans[shift.fan];
      for (int layer = 0; layer < fan.layers; ++layer)
      {
        if (shift.weights[layer] != 0.0)
        {
          this->forCopies(fan, layer, shift.shape, [&](int a, int block, const Ijk& position) {
            places.emplace(
              std::make_pair(block, this->index(block, position)), Vec3(shift.weights[layer] * shift.net[a]));
          });
        }
      }
    }
    for (const auto& [place, by] : places)
    {
      changes.push_back({ place.first, place.second, by });
    }
  }

  void apply(std::vector<Change> changes) const
  {
    std::stable_sort(changes.begin(), changes.end(),
      [](const Change& a, const Change& b) { return std::tie(a.block, a.place) < std::tie(b.block, b.place); });
    for (std::size_t first = 0, last; first < changes.size(); first = last)
    {
      std::vector<Vec3> by;
      for (last = first; last < changes.size() && changes[last].block == changes[first].block &&
           changes[last].place == changes[first].place;
           ++last)
      {
        by.push_back(changes[last].by);
      }
      const Change& at = changes[first];
      Eigen::Map<Vec3>(this->Context.nets[at.block].points + 3 * at.place) += sortedSum(by);
      this->mark(at.block, at.place);
    }
  }

  const ConversionContext& Context;
  const BlockComplex& Complex;
  const EntityRules& Rules;
  const ConversionOptions& Options;
  const std::vector<JoinedSpan>& Avoid;
  const bool JoinNothing;
  const Execution& Run;
  std::vector<NetFan> Fans;
  /// Per fan and layer, whether it is next to a span to avoid; empty: none is.
  std::vector<std::vector<bool>> GivenUp;
  std::vector<std::vector<bool>> Joined;
  std::vector<int> FanOfEdge;
  std::vector<Group> Groups;
  std::vector<WallVertex> WallVertices;
  JoinRules JoinRuleOf;
  std::map<LocalNetShape, PccmRule> PccmOf;
  /// Per fan and sector.
  std::vector<std::vector<std::vector<double>>> Layers;
  std::map<int, std::vector<Shift>> GroupShifts;
  G1Report Report;
};

} // namespace

G1Report makeExactG1(
  const ConversionContext& context, const std::vector<JoinedSpan>& avoid, bool joinNothing, const Execution& run)
{
  return Joiner(context, avoid, joinNothing, run).join();
}

} // namespace bsv
