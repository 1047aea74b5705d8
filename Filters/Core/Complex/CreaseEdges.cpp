// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/CreaseEdges.h"

#include "Base/Numbers.h"
#include "Ranks/Ranks.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace bsv
{

namespace
{

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

/// How much narrower than its neighbours the strip of one cell at a blunt edge is.
constexpr double StripWidth = 0.25;
/// Degrees by which both edges of a strip turn that is the base of a blunt edge however wide it is: that of a wedge of
/// up to 20 degrees. No round edge turns by twice as much in a single cell.
constexpr double BluntTurn = 80.0;

/// Angle between two normals, degrees.
double turnBetween(const Vec3& a, const Vec3& b)
{
  return DegreesPerRadian * angleBetween(a, b);
}

std::string edges(Index count)
{
  return std::to_string(count) + (count == 1 ? " mesh edge" : " mesh edges");
}

std::string figure(double value)
{
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.6g", value);
  return buffer;
}

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

  void operator()(double creaseAngle, const CreaseRules& rules)
  {
    this->markLines();
    for (int b = 0; b < this->Surface.blockCount(); ++b)
    {
      this->markSharpness(b);
    }
    if (creaseAngle < 180.0)
    {
      this->markSharp(creaseAngle, rules);
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
  /// An edge between two boundary quadrilaterals at which the surface turns.
  struct Candidate
  {
    QuadEdge edge;
    QuadEdge other;
    double angle;
    /// Largest turn at the next edges.
    double nearby;
  };

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

  /// The boundary quadrilateral on the other side of an edge of one.
  QuadEdge across(const QuadEdge& edge) const
  {
    QuadEdge other = this->Surface.across(edge);
    while (!this->Links.boundary(other.quad))
    {
      other = this->Surface.across(throughContact(this->Surface, this->Links, other));
    }
    return other;
  }

  /// Calls visit(edge of a boundary quadrilateral, the same edge of the other one) for all edges between two of which
  /// the first is here and has the lower number.
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
            const QuadEdge other = this->across({ at, axis, side });
            if (this->Surface.quad(other.quad) > quad)
            {
              visit(QuadEdge{ at, axis, side }, other);
            }
          }
        }
      });
    }
  }

  Vec3 ownNormal(const QuadAt& at) const
  {
    return outwardNormal(this->Mesh, this->Surface, at, this->LeftHanded[at.block]);
  }

  /// Asks for the normals of quadrilaterals on other ranks.
  void fetchNormals(std::vector<Index> wanted)
  {
    std::sort(wanted.begin(), wanted.end());
    wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
    this->Wanted.assign(this->Others.size(), {});
    QuadAt at;
    for (const Index quad : wanted)
    {
      at = this->Surface.quadAt(quad, at.block);
      const MeshBlock& block = this->Mesh.blocks[at.block];
      if (!block.points.isHere())
      {
        this->Wanted[block.rank].push_back(quad);
      }
    }
    this->Normals = this->Others.ask(
      this->Wanted, [this](Index quad) -> Triple { return triple(this->ownNormal(this->Surface.quadAt(quad))); });
  }

  /// The normal of a quadrilateral that is here or was asked for.
  Vec3 normal(const QuadAt& at) const
  {
    const MeshBlock& block = this->Mesh.blocks[at.block];
    if (block.points.isHere())
    {
      return this->ownNormal(at);
    }
    const std::vector<Index>& quads = this->Wanted[block.rank];
    const auto place = std::lower_bound(quads.begin(), quads.end(), this->Surface.quad(at)) - quads.begin();
    return vec3(this->Normals[block.rank][place]);
  }

  /// The next edge along the lines that cross an edge, on the side of its quadrilateral.
  QuadEdge next(QuadEdge edge) const
  {
    edge.side = 1 - edge.side;
    return this->across(edge);
  }

  /// Whether the quadrilateral is all that its block face has between the edge and the opposite one.
  bool oneCellWide(const QuadEdge& edge) const
  {
    return this->Surface.faceCells(edge.quad.block, edge.quad.face, 1 - edge.axis) == 1;
  }

  /// What is next to an edge on one side.
  struct Side
  {
    bool known = false;
    /// Turn at the next edge, and at the one beyond.
    double turn = 0.0;
    double beyond = 0.0;
    /// Whether the cell between the two is much smaller than those beyond them.
    bool narrow = false;
  };

  Side side(const QuadEdge& edge, const QuadEdge& other) const
  {
    Side result;
    result.known = !this->oneCellWide(edge);
    if (result.known)
    {
      const QuadEdge next = this->next(edge);
      const Vec3 here = this->normal(edge.quad), there = this->normal(next.quad);
      result.turn = turnBetween(here, there);
      result.beyond = turnBetween(there, this->normal(this->next(next).quad));
      result.narrow = here.norm() < StripWidth * std::min(there.norm(), this->normal(other.quad).norm());
    }
    return result;
  }

  std::vector<Candidate> candidates(double creaseAngle, double contrast)
  {
    std::vector<Index> wanted;
    if (this->Others.size() > 1)
    {
      this->forEachBoundaryEdge(
        [&](const QuadEdge&, const QuadEdge& other) { wanted.push_back(this->Surface.quad(other.quad)); });
      this->fetchNormals(wanted);
    }
    std::vector<Candidate> found;
    this->forEachBoundaryEdge([&](const QuadEdge& edge, const QuadEdge& other) {
      const double angle = turnBetween(this->normal(edge.quad), this->normal(other.quad));
      if (angle >= creaseAngle - CreaseAngleMargin)
      {
        found.push_back({ edge, other, angle, 0.0 });
      }
    });
    if (this->Others.size() > 1)
    {
      wanted.clear();
      for (const Candidate& candidate : found)
      {
        for (const QuadEdge& side : { candidate.edge, candidate.other })
        {
          wanted.push_back(this->Surface.quad(side.quad));
          const QuadEdge next = this->next(side);
          wanted.push_back(this->Surface.quad(next.quad));
          wanted.push_back(this->Surface.quad(this->next(next).quad));
        }
      }
      this->fetchNormals(wanted);
    }
    for (Candidate& candidate : found)
    {
      const std::array<Side, 2> sides{ this->side(candidate.edge, candidate.other),
        this->side(candidate.other, candidate.edge) };
      for (int n = 0; n < 2; ++n)
      {
        // Of a strip of one cell between two sharp edges, each is judged by its other side.
        const bool blunt = sides[n].narrow || std::min(candidate.angle, sides[n].turn) > BluntTurn;
        const bool strip = blunt && sides[n].turn > contrast * sides[n].beyond &&
          candidate.angle > contrast * sides[1 - n].turn && sides[n].known && sides[1 - n].known;
        if (sides[n].known && !strip)
        {
          candidate.nearby = std::max(candidate.nearby, sides[n].turn);
        }
      }
    }
    return found;
  }

  /// Degrees by which the body turns at an edge, or -1 if it is no edge of the body.
  double bodyTurn(const Candidate& candidate, const CreaseRules& rules, const std::array<Vec3, 2>& ends) const
  {
    const auto onBody = [&](const QuadAt& at) {
      const int tag = this->Links.tag(at);
      return tag >= 0 && tag < static_cast<int>(rules.bodyTags.size()) && rules.bodyTags[tag];
    };
    if (!rules.bodyTurn || !onBody(candidate.edge.quad) || !onBody(candidate.other.quad))
    {
      return -1.0;
    }
    // At a corner of the body more meets than at the edge, but not at both ends of most.
    const double length = (ends[1] - ends[0]).norm();
    return std::min(rules.bodyTurn(ends[0], length), rules.bodyTurn(ends[1], length));
  }

  void markSharp(double creaseAngle, const CreaseRules& rules)
  {
    enum Count
    {
      Turning,
      Creases,
      Smooth,
      AtAngle,
      AtContrast,
      ByBody,
      Counts
    };
    std::vector<Index> counts(Counts, 0);
    for (const Candidate& candidate : this->candidates(creaseAngle, rules.contrast))
    {
      TurningEdge edge;
      const QuadEdge& at = candidate.edge;
      const GridView& points = this->Mesh.blocks[at.quad.block].points;
      edge.ends = { points(this->Surface.corner(at.quad, at.axis == 0 ? 0 : at.side, at.axis == 0 ? at.side : 0)),
        points(this->Surface.corner(at.quad, at.axis == 0 ? 1 : at.side, at.axis == 0 ? at.side : 1)) };
      edge.angle = candidate.angle;
      edge.nearby = candidate.nearby;
      edge.bodyAngle = this->bodyTurn(candidate, rules, edge.ends);
      edge.tagged = this->Creases(at.quad, at.axis, at.side);
      edge.borderline = std::abs(edge.angle - creaseAngle) <= CreaseAngleMargin;
      if (edge.borderline)
      {
        ++counts[AtAngle];
      }
      else
      {
        ++counts[Turning];
        if (edge.bodyAngle >= 0.0)
        {
          ++counts[ByBody];
          edge.crease = edge.bodyAngle > creaseAngle + CreaseAngleMargin;
        }
        else
        {
          const double limit = rules.contrast * edge.nearby;
          edge.borderline = std::abs(edge.angle - limit) <= CreaseContrastMargin * limit && limit > 0.0;
          counts[AtContrast] += edge.borderline ? 1 : 0;
          edge.crease = edge.angle > limit && !edge.borderline;
        }
        ++counts[edge.crease || edge.tagged ? Creases : Smooth];
        if (edge.crease)
        {
          this->markOwn(at);
        }
      }
      edge.crease = edge.crease || edge.tagged;
      this->Creases.Turning.push_back(edge);
    }
    std::vector<Index> all(Counts, 0);
    const std::vector<std::vector<Index>> parts = this->Others.gather(counts);
    for (const std::vector<Index>& part : parts)
    {
      for (int n = 0; n < Counts; ++n)
      {
        all[n] += part[n];
      }
    }
    std::vector<std::string>& notes = this->Creases.Notes;
    if (all[Turning] > 0)
    {
      notes.push_back(edges(all[Turning]) + " of the outer boundary turn by more than " + figure(creaseAngle) +
        " degrees: " + std::to_string(all[Creases]) + " are creases, " + std::to_string(all[Smooth]) + " are smooth" +
        (rules.contrast > 0.0
            ? " because the next mesh edges turn by more than 1/" + figure(rules.contrast) + " of that"
            : std::string()) +
        (all[ByBody] > 0 ? " or the body is; the body decided at " + std::to_string(all[ByBody]) : std::string()) +
        ".");
    }
    if (all[AtAngle] > 0)
    {
      notes.push_back(edges(all[AtAngle]) + (all[AtAngle] == 1 ? " turns by " : " turn by ") + figure(creaseAngle) +
        " degrees, the limit, to " + figure(CreaseAngleMargin) + ": taken as smooth.");
    }
    if (all[AtContrast] > 0)
    {
      notes.push_back(edges(all[AtContrast]) + (all[AtContrast] == 1 ? " turns " : " turn ") + figure(rules.contrast) +
        " times as much as the next ones, the limit, to " + figure(CreaseContrastMargin) + ": taken as smooth.");
    }
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
  std::vector<std::vector<Triple>> Normals;
};

CreaseEdges::CreaseEdges(const BlockMesh& mesh, const SurfaceNumbering& surface, const Contacts& contacts,
  const std::vector<bool>& leftHanded, double creaseAngle, const CreaseRules& rules, const Ranks& ranks)
  : Surface(surface)
{
  Search(*this, mesh, contacts, leftHanded, ranks)(creaseAngle, rules);
}

} // namespace bsv
