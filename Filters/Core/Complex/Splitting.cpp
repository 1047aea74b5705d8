// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/Splitting.h"

#include "Ranks/Ranks.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace bsv
{

namespace
{

constexpr Index MostPieces = 1000000;

/// Calls visit(quadrilateral, number) for all of one block.
template <typename Visit>
void forEachQuad(const SurfaceNumbering& surface, int block, const Visit& visit)
{
  Index quad = surface.firstQuad(block);
  for (int face = 0; face < 6; ++face)
  {
    const int ns = surface.faceCells(block, face, 0);
    const int nt = surface.faceCells(block, face, 1);
    for (int t = 0; t < nt; ++t)
    {
      for (int s = 0; s < ns; ++s)
      {
        visit(QuadAt{ block, face, s, t }, quad++);
      }
    }
  }
}

void checkCreaseLine(const BlockMesh& mesh, int n)
{
  const CreaseLine& line = mesh.creases[n];
  const std::string what = "crease line " + std::to_string(n);
  if (line.block < 0 || line.block >= static_cast<int>(mesh.blocks.size()))
  {
    throw Error(what + ": there is no block " + std::to_string(line.block));
  }
  const Ijk& counts = mesh.blocks[line.block].points.counts();
  int directions = 0;
  for (int d = 0; d < 3; ++d)
  {
    for (int at : { line.from[d], line.to[d] })
    {
      if (at < 0 || at >= counts[d])
      {
        throw Error(what + ": there is no point " + text(at == line.from[d] ? line.from : line.to) + " in " +
          blockLabel(mesh, line.block));
      }
    }
    directions += line.from[d] != line.to[d];
  }
  if (directions != 1)
  {
    throw Error(what + ": points " + text(line.from) + " and " + text(line.to) + " of " + blockLabel(mesh, line.block) +
      " do not differ in exactly one direction");
  }
}

/// Worklist of cuts.
class Splitter
{
public:
  Splitter(const SurfaceNumbering& surface, const Contacts& contacts, const CreaseEdges& creases)
    : Surface(surface)
    , Links(contacts)
    , Creases(creases)
    , IsCut(surface.blockCount())
  {
    for (int b = 0; b < surface.blockCount(); ++b)
    {
      for (int d = 0; d < 3; ++d)
      {
        this->IsCut[b][d].assign(surface.cells(b)[d] + 1, false);
        this->IsCut[b][d].front() = this->IsCut[b][d].back() = true;
      }
    }
  }

  std::vector<CutPositions> operator()(const BlockMesh& mesh, const Execution& run)
  {
    run.parallelFor(this->Surface.blockCount(), 1, [&](Index begin, Index end) {
      for (Index b = begin; b < end; ++b)
      {
        this->seed(static_cast<int>(b));
      }
    });
    this->spread();
    return this->positions(mesh);
  }

private:
  struct Cut
  {
    int block;
    int direction;
    int position;
  };

  /// Cuts that a block needs by itself.
  void seed(int block)
  {
    for (int face = 0; face < 6; ++face)
    {
      const QuadAt first{ block, face, 0, 0 };
      const QuadAt partner = this->partnerOf(first);
      if (this->Links.onePiece(block, face) && !this->Creases.any(block, face) &&
        (partner.block != block || partner.face != face))
      {
        continue;
      }
      for (int axis = 0; axis < 2; ++axis)
      {
        this->seedFace(block, face, axis);
      }
    }
  }

  /// Cuts across one axis of a face.
  void seedFace(int block, int face, int axis)
  {
    std::vector<char>& cut = this->IsCut[block][faceAxis(face, axis)];
    const int n = this->Surface.faceCells(block, face, axis);
    const int lines = this->Surface.faceCells(block, face, 1 - axis);
    for (int line = 0; line < lines; ++line)
    {
      QuadAt at{ block, face, 0, 0 };
      (axis == 0 ? at.t : at.s) = line;
      int& position = axis == 0 ? at.s : at.t;
      QuadAt before = at;
      QuadAt partner = this->partnerOf(at);
      this->seedFold(at, axis, partner);
      for (position = 1; position < n; ++position)
      {
        const QuadAt next = this->partnerOf(at, partner.block);
        bool needed = this->Creases(at, 1 - axis, 0);
        for (int side = 0; side < 2; ++side)
        {
          needed = needed ||
            (this->Creases(before, axis, side) != this->Creases(at, axis, side) &&
              !this->isOutline({ at, axis, side }));
        }
        if (needed || !this->continues(before, partner, at, next, axis))
        {
          cut[position] = true;
        }
        this->seedFold(at, axis, next);
        before = at;
        partner = next;
      }
    }
  }

  /// Whether only one cell lies at the edge: sharp in any case, so that it does not matter where a crease on it ends.
  bool isOutline(const QuadEdge& edge) const
  {
    const QuadAt other = this->Surface.across(edge).quad;
    return other.face != edge.quad.face && this->Links.boundary(edge.quad) && this->Links.boundary(other);
  }

  /// The quadrilateral that one meets, of face -1 if it meets none; found fastest if it is of block `hint`.
  QuadAt partnerOf(const QuadAt& quad, int hint) const
  {
    return this->Links.boundary(quad) ? QuadAt{ hint, -1, 0, 0 }
                                      : this->Surface.quadAt(this->Links.partner(quad), hint);
  }
  QuadAt partnerOf(const QuadAt& quad) const { return this->partnerOf(quad, quad.block); }

  /// Whether two neighbours along `axis` belong to the same boundary, or meet neighbours of one face in the same way.
  bool continues(const QuadAt& a, const QuadAt& meetsA, const QuadAt& b, const QuadAt& meetsB, int axis) const
  {
    if (this->Links.boundary(a) || this->Links.boundary(b))
    {
      return this->Links.link(a) == this->Links.link(b);
    }
    const int orientation = this->Links.orientation(a);
    const int axisB = swapsAxes(orientation) ? 1 - axis : axis;
    const int step = (orientation & (axisB == 0 ? 2 : 4)) != 0 ? -1 : 1;
    return orientation == this->Links.orientation(b) && meetsA.block == meetsB.block && meetsA.face == meetsB.face &&
      meetsB.s - meetsA.s == (axisB == 0 ? step : 0) && meetsB.t - meetsA.t == (axisB == 1 ? step : 0);
  }

  /// A face that is folded onto itself is cut along the fold, so that no piece of a face meets itself.
  void seedFold(const QuadAt& at, int axis, const QuadAt& partner)
  {
    if (partner.block != at.block || partner.face != at.face || std::abs(partner.s - at.s) > 1 ||
      std::abs(partner.t - at.t) > 1)
    {
      return;
    }
    const int here = axis == 0 ? at.s : at.t;
    const int there = axis == 0 ? partner.s : partner.t;
    if (here != there)
    {
      this->IsCut[at.block][faceAxis(at.face, axis)][std::max(here, there)] = true;
    }
  }

  void spread()
  {
    std::vector<Cut> open;
    for (int b = 0; b < this->Surface.blockCount(); ++b)
    {
      for (int d = 0; d < 3; ++d)
      {
        for (int position = 1; position < this->Surface.cells(b)[d]; ++position)
        {
          if (this->IsCut[b][d][position])
          {
            open.push_back({ b, d, position });
          }
        }
      }
    }
    while (!open.empty())
    {
      const Cut cut = open.back();
      open.pop_back();
      for (int face = 0; face < 6; ++face)
      {
        if (faceDirection(face) != cut.direction)
        {
          this->spreadAcross(cut, face, open);
        }
      }
    }
  }

  /// Carries a cut through the contacts along its line on one face.
  void spreadAcross(const Cut& cut, int face, std::vector<Cut>& open)
  {
    const int axis = faceAxis(face, 0) == cut.direction ? 0 : 1;
    const int lines = this->Surface.faceCells(cut.block, face, 1 - axis);
    for (int line = 0; line < lines; ++line)
    {
      for (int side = 0; side < 2; ++side)
      {
        // The quadrilaterals on both sides of the cut; it is the edge along the other axis between them.
        QuadEdge edge;
        edge.quad = { cut.block, face, axis == 0 ? cut.position - 1 + side : line,
          axis == 0 ? line : cut.position - 1 + side };
        edge.axis = 1 - axis;
        edge.side = 1 - side;
        if (this->Links.boundary(edge.quad))
        {
          continue;
        }
        const QuadEdge there = throughContact(this->Surface, this->Links, edge);
        const int direction = faceAxis(there.quad.face, 1 - there.axis);
        const int position = (there.axis == 0 ? there.quad.t : there.quad.s) + there.side;
        char& isCut = this->IsCut[there.quad.block][direction][position];
        if (!isCut)
        {
          isCut = true;
          open.push_back({ there.quad.block, direction, position });
        }
      }
    }
  }

  std::vector<CutPositions> positions(const BlockMesh& mesh) const
  {
    std::vector<CutPositions> result(this->Surface.blockCount());
    Index pieces = 0;
    for (int b = 0; b < this->Surface.blockCount(); ++b)
    {
      Index inBlock = 1;
      for (int d = 0; d < 3; ++d)
      {
        for (int position = 0; position <= this->Surface.cells(b)[d]; ++position)
        {
          if (this->IsCut[b][d][position])
          {
            result[b][d].push_back(position);
          }
        }
        inBlock *= static_cast<Index>(result[b][d].size()) - 1;
        // Three factors below 2^31 could overflow; two cannot.
        if (inBlock > MostPieces)
        {
          break;
        }
      }
      pieces += inBlock;
      if (pieces > MostPieces)
      {
        throw Error("contacts and creases cut the mesh into more than " + std::to_string(MostPieces) + " pieces (at " +
          blockLabel(mesh, b) + ")");
      }
    }
    return result;
  }

  const SurfaceNumbering& Surface;
  const Contacts& Links;
  const CreaseEdges& Creases;
  /// Per block, direction and mesh position.
  std::vector<std::array<std::vector<char>, 3>> IsCut;
};

} // namespace

/// Marks the edges in the bits of a CreaseEdges.
class CreaseEdges::Search
{
public:
  Search(CreaseEdges& creases, const BlockMesh& mesh, const Contacts& contacts, const std::vector<bool>& leftHanded,
    const Ranks& ranks)
    : Creases(creases)
    , Mesh(mesh)
    , Surface(creases.Surface)
    , Links(contacts)
    , LeftHanded(leftHanded)
    , Others(ranks)
  {
  }

  void operator()(double creaseAngle)
  {
    this->markLines();
    for (int b = 0; b < this->Surface.blockCount(); ++b)
    {
      this->markSharpness(b);
    }
    if (creaseAngle < 180.0)
    {
      this->fetchNormals();
      this->markSharp(creaseAngle);
    }
    if (this->Others.size() > 1)
    {
      for (const QuadEdge& edge : this->Others.gatherAll(this->New))
      {
        this->mark(edge);
      }
    }
  }

private:
  using Normal = std::array<double, 3>;

  void markLines()
  {
    for (int n = 0; n < static_cast<int>(this->Mesh.creases.size()); ++n)
    {
      checkCreaseLine(this->Mesh, n);
    }
    for (CreaseLine line : this->Mesh.creases)
    {
      int direction = 0;
      while (line.from[direction] == line.to[direction])
      {
        ++direction;
      }
      if (line.from[direction] > line.to[direction])
      {
        std::swap(line.from, line.to);
      }
      // Every face that the line lies on.
      for (int face = 0; face < 6; ++face)
      {
        const int normal = faceDirection(face);
        if (normal == direction || line.from[normal] != (faceSide(face) ? this->Surface.cells(line.block)[normal] : 0))
        {
          continue;
        }
        QuadEdge edge;
        edge.axis = faceAxis(face, 0) == direction ? 0 : 1;
        const int across = line.from[faceAxis(face, 1 - edge.axis)];
        edge.side = across == 0 ? 0 : 1;
        for (int along = line.from[direction]; along < line.to[direction]; ++along)
        {
          edge.quad = { line.block, face, edge.axis == 0 ? along : across - edge.side,
            edge.axis == 0 ? across - edge.side : along };
          this->mark(edge);
        }
      }
    }
  }

  void markSharpness(int b)
  {
    const std::vector<double>& sharpness = this->Mesh.blocks[b].creaseSharpness;
    if (sharpness.empty())
    {
      return;
    }
    const Ijk& counts = this->Mesh.blocks[b].points.counts();
    const auto sharp = [&](const QuadAt& at, int cs, int ct) {
      const Ijk p = this->Surface.corner(at, cs, ct);
      return sharpness[p[0] + Index(counts[0]) * (p[1] + Index(counts[1]) * p[2])] >= SharpnessInfinite;
    };
    forEachQuad(this->Surface, b, [&](const QuadAt& at, Index) {
      for (int axis = 0; axis < 2; ++axis)
      {
        for (int side = 0; side < 2; ++side)
        {
          if (axis == 0 ? sharp(at, 0, side) && sharp(at, 1, side) : sharp(at, side, 0) && sharp(at, side, 1))
          {
            this->markOwn({ at, axis, side });
          }
        }
      }
    });
  }

  /// Calls visit(edge of a boundary quadrilateral, the other one, the other's number) for all edges between two of
  /// which the first is here and has the lower number.
  template <typename Visit>
  void forEachBoundaryEdge(const Visit& visit) const
  {
    for (int b = 0; b < this->Surface.blockCount(); ++b)
    {
      if (!this->Mesh.blocks[b].points.isHere())
      {
        continue;
      }
      forEachQuad(this->Surface, b, [&](const QuadAt& at, Index quad) {
        if (!this->Links.boundary(at))
        {
          return;
        }
        for (int axis = 0; axis < 2; ++axis)
        {
          for (int side = 0; side < 2; ++side)
          {
            QuadEdge other = this->Surface.across({ at, axis, side });
            while (!this->Links.boundary(other.quad))
            {
              other = this->Surface.across(throughContact(this->Surface, this->Links, other));
            }
            const Index otherQuad = this->Surface.quad(other.quad);
            if (otherQuad > quad)
            {
              visit(QuadEdge{ at, axis, side }, other.quad, otherQuad);
            }
          }
        }
      });
    }
  }

  Vec3 normal(const QuadAt& at) const
  {
    return outwardNormal(this->Mesh, this->Surface, at, this->LeftHanded[at.block]);
  }

  /// Asks for the normals of the quadrilaterals on other ranks that share an edge with one here.
  void fetchNormals()
  {
    if (this->Others.size() == 1)
    {
      return;
    }
    this->Wanted.resize(this->Others.size());
    this->forEachBoundaryEdge([&](const QuadEdge&, const QuadAt& other, Index otherQuad) {
      const MeshBlock& block = this->Mesh.blocks[other.block];
      if (!block.points.isHere())
      {
        this->Wanted[block.rank].push_back(otherQuad);
      }
    });
    for (std::vector<Index>& quads : this->Wanted)
    {
      std::sort(quads.begin(), quads.end());
      quads.erase(std::unique(quads.begin(), quads.end()), quads.end());
    }
    this->Normals = this->Others.ask(this->Wanted, [this](Index quad) -> Normal {
      const Vec3 n = this->normal(this->Surface.quadAt(quad));
      return { n[0], n[1], n[2] };
    });
  }

  Vec3 normalOf(const QuadAt& at, Index quad) const
  {
    const MeshBlock& block = this->Mesh.blocks[at.block];
    if (block.points.isHere())
    {
      return this->normal(at);
    }
    const std::vector<Index>& quads = this->Wanted[block.rank];
    const Normal& n = this->Normals[block.rank][std::lower_bound(quads.begin(), quads.end(), quad) - quads.begin()];
    return Vec3(n[0], n[1], n[2]);
  }

  void markSharp(double creaseAngle)
  {
    const double limit = std::cos(creaseAngle * std::acos(-1.0) / 180.0);
    this->forEachBoundaryEdge([&](const QuadEdge& edge, const QuadAt& other, Index otherQuad) {
      const Vec3 a = this->normal(edge.quad);
      const Vec3 b = this->normalOf(other, otherQuad);
      if (a.dot(b) < limit * (a.norm() * b.norm()))
      {
        this->markOwn(edge);
      }
    });
  }

  /// Marks an edge of which the other ranks do not know.
  void markOwn(const QuadEdge& edge)
  {
    if (this->mark(edge) && this->Others.size() > 1)
    {
      this->New.push_back(edge);
    }
  }

  /// Marks an edge on all quadrilaterals at it, if it is on the outer boundary. False if nothing changed.
  bool mark(const QuadEdge& edge)
  {
    if (this->Creases(edge.quad, edge.axis, edge.side))
    {
      return false;
    }
    // From one boundary to the other, or back to the start if it is inside.
    std::vector<QuadEdge> around{ edge };
    const auto isStart = [&](const QuadEdge& e) {
      return this->Surface.quad(e.quad) == this->Surface.quad(edge.quad) && e.axis == edge.axis && e.side == edge.side;
    };
    // Forwards the walk leaves `edge` through its block, backwards through its contact.
    for (int backwards = 0; backwards < 2; ++backwards)
    {
      QuadEdge at = edge;
      for (bool throughBlock = !backwards;; throughBlock = !throughBlock)
      {
        if (!throughBlock && this->Links.boundary(at.quad))
        {
          break;
        }
        at = throughBlock ? this->Surface.across(at) : throughContact(this->Surface, this->Links, at);
        if (isStart(at))
        {
          return false;
        }
        around.push_back(at);
      }
    }
    std::vector<std::vector<std::uint8_t>>& bits = this->Creases.Bits;
    bits.resize(6 * static_cast<std::size_t>(this->Surface.blockCount()));
    for (const QuadEdge& e : around)
    {
      std::vector<std::uint8_t>& face = bits[6 * std::size_t(e.quad.block) + e.quad.face];
      face.resize(Index(this->Surface.faceCells(e.quad.block, e.quad.face, 0)) *
        this->Surface.faceCells(e.quad.block, e.quad.face, 1));
      face[this->Creases.place(e.quad)] |= static_cast<std::uint8_t>(1 << (2 * e.axis + e.side));
    }
    return true;
  }

  CreaseEdges& Creases;
  const BlockMesh& Mesh;
  const SurfaceNumbering& Surface;
  const Contacts& Links;
  const std::vector<bool>& LeftHanded;
  const Ranks& Others;
  std::vector<QuadEdge> New;
  /// Per rank the quadrilaterals asked for, ascending, and their normals.
  std::vector<std::vector<Index>> Wanted;
  std::vector<std::vector<Normal>> Normals;
};

CreaseEdges::CreaseEdges(const BlockMesh& mesh, const SurfaceNumbering& surface, const Contacts& contacts,
  const std::vector<bool>& leftHanded, double creaseAngle, const Ranks& ranks)
  : Surface(surface)
{
  Search(*this, mesh, contacts, leftHanded, ranks)(creaseAngle);
}

std::vector<CutPositions> cutPositions(const BlockMesh& mesh, const SurfaceNumbering& surface, const Contacts& contacts,
  const CreaseEdges& creases, const Execution& run)
{
  return Splitter(surface, contacts, creases)(mesh, run);
}

} // namespace bsv
