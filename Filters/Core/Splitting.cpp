// SPDX-License-Identifier: BSD-3-Clause
#include "Splitting.h"

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
    throw Error(what + ": points " + text(line.from) + " and " + text(line.to) + " of " +
      blockLabel(mesh, line.block) + " do not differ in exactly one direction");
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
      Index before = this->Surface.quad(at);
      QuadAt partner = this->partnerOf(before, block);
      this->seedFold(at, axis, partner, before);
      for (position = 1; position < n; ++position)
      {
        const Index quad = this->Surface.quad(at);
        const QuadAt next = this->partnerOf(quad, partner.block);
        bool needed = this->Creases(quad, 1 - axis, 0);
        for (int side = 0; side < 2; ++side)
        {
          needed = needed ||
            (this->Creases(before, axis, side) != this->Creases(quad, axis, side) &&
              !this->isOutline({ at, axis, side }));
        }
        if (needed || !this->continues(before, partner, quad, next, axis))
        {
          cut[position] = true;
        }
        this->seedFold(at, axis, next, quad);
        before = quad;
        partner = next;
      }
    }
  }

  /// Whether only one cell lies at the edge: sharp in any case, so that it does not matter where a crease on it ends.
  bool isOutline(const QuadEdge& edge) const
  {
    const QuadAt other = this->Surface.across(edge).quad;
    return other.face != edge.quad.face && this->Links.boundary(this->Surface.quad(edge.quad)) &&
      this->Links.boundary(this->Surface.quad(other));
  }

  QuadAt partnerOf(Index quad, int hint) const
  {
    return this->Links.boundary(quad) ? QuadAt{ hint, -1, 0, 0 }
                                      : this->Surface.quadAt(this->Links.partner(quad), hint);
  }

  /// Whether two neighbours along `axis` belong to the same boundary, or meet neighbours of one face in the same way.
  bool continues(Index a, const QuadAt& meetsA, Index b, const QuadAt& meetsB, int axis) const
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
  void seedFold(const QuadAt& at, int axis, const QuadAt& partner, Index quad)
  {
    if (this->Links.boundary(quad) || partner.block != at.block || partner.face != at.face ||
      std::abs(partner.s - at.s) > 1 || std::abs(partner.t - at.t) > 1)
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
        if (this->Links.boundary(this->Surface.quad(edge.quad)))
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
        throw Error("contacts and creases cut the mesh into more than " + std::to_string(MostPieces) +
          " pieces (at " + blockLabel(mesh, b) + ")");
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

CreaseEdges::CreaseEdges(const BlockMesh& mesh, const SurfaceNumbering& surface, const Contacts& contacts,
  const std::vector<bool>& leftHanded, double creaseAngle)
{
  this->markTagged(mesh, surface, contacts);
  if (creaseAngle < 180.0)
  {
    this->markSharp(mesh, surface, contacts, leftHanded, creaseAngle);
  }
}

void CreaseEdges::markTagged(const BlockMesh& mesh, const SurfaceNumbering& surface, const Contacts& contacts)
{
  std::vector<std::vector<CreaseLine>> lines(mesh.blocks.size());
  for (int n = 0; n < static_cast<int>(mesh.creases.size()); ++n)
  {
    checkCreaseLine(mesh, n);
    CreaseLine line = mesh.creases[n];
    for (int d = 0; d < 3; ++d)
    {
      if (line.from[d] > line.to[d])
      {
        std::swap(line.from, line.to);
      }
    }
    lines[line.block].push_back(line);
  }
  for (int b = 0; b < static_cast<int>(mesh.blocks.size()); ++b)
  {
    for (const CreaseLine& line : lines[b])
    {
      int direction = 0;
      while (line.from[direction] == line.to[direction])
      {
        ++direction;
      }
      // Every face that the line lies on.
      for (int face = 0; face < 6; ++face)
      {
        const int normal = faceDirection(face);
        if (normal == direction || line.from[normal] != (faceSide(face) ? surface.cells(b)[normal] : 0))
        {
          continue;
        }
        QuadEdge edge;
        edge.axis = faceAxis(face, 0) == direction ? 0 : 1;
        const int across = line.from[faceAxis(face, 1 - edge.axis)];
        edge.side = across == 0 ? 0 : 1;
        for (int along = line.from[direction]; along < line.to[direction]; ++along)
        {
          edge.quad = { b, face, edge.axis == 0 ? along : across - edge.side,
            edge.axis == 0 ? across - edge.side : along };
          this->mark(surface, contacts, edge);
        }
      }
    }
    const std::vector<double>& sharpness = mesh.blocks[b].creaseSharpness;
    if (sharpness.empty())
    {
      continue;
    }
    const Ijk& counts = mesh.blocks[b].points.counts();
    const auto sharp = [&](const QuadAt& at, int cs, int ct) {
      const Ijk p = surface.corner(at, cs, ct);
      return sharpness[p[0] + Index(counts[0]) * (p[1] + Index(counts[1]) * p[2])] >= SharpnessInfinite;
    };
    forEachQuad(surface, b, [&](const QuadAt& at, Index) {
      for (int axis = 0; axis < 2; ++axis)
      {
        for (int side = 0; side < 2; ++side)
        {
          if (axis == 0 ? sharp(at, 0, side) && sharp(at, 1, side) : sharp(at, side, 0) && sharp(at, side, 1))
          {
            this->mark(surface, contacts, { at, axis, side });
          }
        }
      }
    });
  }
}

void CreaseEdges::markSharp(const BlockMesh& mesh, const SurfaceNumbering& surface, const Contacts& contacts,
  const std::vector<bool>& leftHanded, double creaseAngle)
{
  const double limit = std::cos(creaseAngle * std::acos(-1.0) / 180.0);
  for (int b = 0; b < surface.blockCount(); ++b)
  {
    forEachQuad(surface, b, [&](const QuadAt& at, Index quad) {
      if (!contacts.boundary(quad))
      {
        return;
      }
      const Vec3 normal = outwardNormal(mesh, surface, at, leftHanded[b]);
      for (int axis = 0; axis < 2; ++axis)
      {
        for (int side = 0; side < 2; ++side)
        {
          QuadEdge other = surface.across({ at, axis, side });
          Index otherQuad = surface.quad(other.quad);
          while (!contacts.boundary(otherQuad))
          {
            other = surface.across(throughContact(surface, contacts, other));
            otherQuad = surface.quad(other.quad);
          }
          const Vec3 otherNormal = outwardNormal(mesh, surface, other.quad, leftHanded[other.quad.block]);
          if (otherQuad > quad && normal.dot(otherNormal) < limit * (normal.norm() * otherNormal.norm()))
          {
            this->mark(surface, contacts, { at, axis, side });
          }
        }
      }
    });
  }
}

void CreaseEdges::mark(const SurfaceNumbering& surface, const Contacts& contacts, const QuadEdge& edge)
{
  // All quadrilaterals at the edge: from one boundary to the other, or back to the start if it is inside.
  std::vector<QuadEdge> around{ edge };
  const auto isStart = [&](const QuadEdge& e) {
    return surface.quad(e.quad) == surface.quad(edge.quad) && e.axis == edge.axis && e.side == edge.side;
  };
  // Forwards the walk leaves `edge` through its block, backwards through its contact.
  for (int backwards = 0; backwards < 2; ++backwards)
  {
    QuadEdge at = edge;
    for (bool throughBlock = !backwards;; throughBlock = !throughBlock)
    {
      if (!throughBlock && contacts.boundary(surface.quad(at.quad)))
      {
        break;
      }
      at = throughBlock ? surface.across(at) : throughContact(surface, contacts, at);
      if (isStart(at))
      {
        return;
      }
      around.push_back(at);
    }
  }
  if (this->Bits.empty())
  {
    this->Bits.assign(surface.quadCount(), 0);
  }
  for (const QuadEdge& e : around)
  {
    this->Bits[surface.quad(e.quad)] |= static_cast<std::uint8_t>(1 << (2 * e.axis + e.side));
  }
}

std::vector<CutPositions> cutPositions(const BlockMesh& mesh, const SurfaceNumbering& surface,
  const Contacts& contacts, const CreaseEdges& creases, const Execution& run)
{
  return Splitter(surface, contacts, creases)(mesh, run);
}

} // namespace bsv
