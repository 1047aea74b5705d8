// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/BlockComplex.h"

#include "Base/Numbers.h"
#include "Base/UnionFind.h"
#include "Complex/CreaseEdges.h"
#include "Complex/Gluing.h"
#include "Complex/Limits.h"
#include "Complex/Splitting.h"
#include "Mesh/BlockSurface.h"
#include "Mesh/MeshCheck.h"
#include "Mesh/SharedEntities.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

namespace bsv
{

namespace
{

/// Names listed in a message before "..".
constexpr std::size_t MostListed = 5;

std::string listed(const std::vector<std::string>& names)
{
  std::string result;
  for (std::size_t n = 0; n < names.size() && n < MostListed; ++n)
  {
    result += (n == 0 ? "" : ", ") + names[n];
  }
  return names.size() > MostListed ? result + ", .." : result;
}

std::string counted(Index count, const std::string& one, const std::string& many)
{
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

Index piecesOf(const CutPositions& cuts)
{
  return Index(cuts[0].size() - 1) * Index(cuts[1].size() - 1) * Index(cuts[2].size() - 1);
}

/// Lexicographic order of x, y, z; of equal ones, that with negative zeros first.
bool before(const Vec3& a, const Vec3& b)
{
  for (int d = 0; d < 3; ++d)
  {
    if (a[d] != b[d])
    {
      return a[d] < b[d];
    }
  }
  for (int d = 0; d < 3; ++d)
  {
    if (std::signbit(a[d]) != std::signbit(b[d]))
    {
      return std::signbit(a[d]);
    }
  }
  return false;
}

/// Coordinates of all copies of the points that are here; some of the copies are on other ranks.
class CopiedPoints
{
public:
  /// Collective. `numbering` numbers all copies of points that are here; `surface` is the same on all ranks.
  CopiedPoints(const BlockMesh& mesh, const SurfaceNumbering& surface, const SurfaceNumbering& numbering,
    UnionFind& copies, const Ranks& ranks)
    : Mesh(mesh)
    , Numbering(numbering)
    , Remote(ranks.size())
  {
    std::vector<std::vector<Index>> questions(ranks.size());
    if (ranks.size() > 1)
    {
      std::vector<bool> isHere(numbering.pointCount(), false);
      this->forEachPoint(true, [&](int, Index point) { isHere[copies.find(point)] = true; });
      this->forEachPoint(false, [&](int block, Index point) {
        if (isHere[copies.find(point)])
        {
          this->Remote[mesh.blocks[block].rank].push_back(point);
          questions[mesh.blocks[block].rank].push_back(surface.point(block, numbering.pointAt(block, point)));
        }
      });
    }
    this->Coordinates = ranks.ask(questions, [&](Index point) -> Triple {
      const int block = surface.blockOfPoint(point);
      return triple(mesh.blocks[block].points(surface.pointAt(block, point)));
    });
  }

  bool known(Index point) const
  {
    if (this->Remote.size() == 1)
    {
      return true;
    }
    const MeshBlock& block = this->Mesh.blocks[this->Numbering.blockOfPoint(point)];
    return block.points.isHere() ||
      std::binary_search(this->Remote[block.rank].begin(), this->Remote[block.rank].end(), point);
  }
  /// Of a known point.
  Vec3 operator()(Index point) const
  {
    const int b = this->Numbering.blockOfPoint(point);
    const MeshBlock& block = this->Mesh.blocks[b];
    if (block.points.isHere())
    {
      return block.points(this->Numbering.pointAt(b, point));
    }
    const std::vector<Index>& points = this->Remote[block.rank];
    const auto at = std::lower_bound(points.begin(), points.end(), point) - points.begin();
    return Vec3(this->Coordinates[block.rank][at].data());
  }

private:
  template <typename Visit>
  void forEachPoint(bool here, const Visit& visit) const
  {
    for (int b = 0; b < this->Numbering.blockCount(); ++b)
    {
      for (Index point = this->Numbering.firstPoint(b);
           point < this->Numbering.firstPoint(b + 1) && this->Mesh.blocks[b].points.isHere() == here; ++point)
      {
        visit(b, point);
      }
    }
  }

  const BlockMesh& Mesh;
  const SurfaceNumbering& Numbering;
  /// Per rank, ascending, and their coordinates.
  std::vector<std::vector<Index>> Remote;
  std::vector<std::vector<Triple>> Coordinates;
};

class Builder
{
public:
  Builder(const BlockMesh& mesh, const BlockComplexOptions& options, const CreaseRules& rules, const Execution& run)
    : Part(mesh, *run.ranks)
    , Mesh(this->Part.mesh())
    , Run(run)
    , Ranks(*run.ranks)
    , Check(checkMesh(mesh, options.allowDegenerate, this->part(0.0, 0.4)))
    , Surface(mesh)
    , Links(glue(this->Part, this->Surface, this->Check.leftHanded, options, this->part(0.4, 0.8)))
    , Creases(mesh, this->Surface, this->Links, this->Check.leftHanded, options.creaseAngle, rules, *run.ranks)
    , Cuts(cutPositions(mesh, this->Surface, this->Links, &this->Creases, run))
    , ContactCuts(this->Creases.empty() ? this->Cuts : cutPositions(mesh, this->Surface, this->Links, nullptr, run))
  {
    this->Run.report(0.85);
  }

  const std::vector<TurningEdge>& turning() const { return this->Creases.turning(); }

  BlockComplex build()
  {
    this->Result.boundaryNames = this->Mesh.boundaryNames;
    this->Result.notes = this->Mesh.notes;
    this->Result.warnings = this->Mesh.warnings;
    this->Result.boundaryTypes = this->Mesh.boundaryTypes;
    this->makePieces();
    this->makeFaces();
    this->makeVerticesAndEdges();
    this->refuseCrowds();
    this->Run.report(0.9);
    this->fetchContacts();
    this->refuseFoldedContacts();
    this->Ranks.nextStep();
    this->weld();
    this->tell();
    this->Run.report(1.0);
    return std::move(this->Result);
  }

private:
  /// The caller's execution with its progress in [0, 1] told as one of [from, to].
  Execution part(double from, double to) const
  {
    Execution result = this->Run;
    const auto progress = this->Run.progress;
    result.progress = [=](double fraction) { return progress(from + fraction * (to - from)); };
    return result;
  }

  int cutCount(int parent, int direction) const { return static_cast<int>(this->Cuts[parent][direction].size()) - 1; }

  int piece(int parent, const Ijk& at) const
  {
    return this->FirstPiece[parent] + at[0] + this->cutCount(parent, 0) * (at[1] + this->cutCount(parent, 1) * at[2]);
  }

  void makePieces()
  {
    for (int b = 0; b < this->Surface.blockCount(); ++b)
    {
      const MeshBlock& parent = this->Mesh.blocks[b];
      const CutPositions& cuts = this->Cuts[b];
      const std::string name = parent.name.empty() ? "Block " + std::to_string(b) : parent.name;
      const Ijk n{ this->cutCount(b, 0), this->cutCount(b, 1), this->cutCount(b, 2) };
      const bool whole = n[0] * n[1] * n[2] == 1;
      this->FirstPiece.push_back(static_cast<int>(this->Result.blocks.size()));
      for (int k = 0; k < n[2]; ++k)
      {
        for (int j = 0; j < n[1]; ++j)
        {
          for (int i = 0; i < n[0]; ++i)
          {
            ComplexBlock block;
            block.parent = b;
            block.rank = parent.rank;
            block.offset = { cuts[0][i], cuts[1][j], cuts[2][k] };
            block.points = parent.points.box(block.offset, { cuts[0][i + 1], cuts[1][j + 1], cuts[2][k + 1] });
            if (!block.points.isHere())
            {
              block.points = GridView::elsewhere(block.points.counts());
            }
            block.leftHanded = this->Check.leftHanded[b];
            block.faces.fill(-1);
            block.name = whole ? name : name + "." + std::to_string(i + n[0] * (j + n[1] * k));
            this->Result.blocks.push_back(std::move(block));
            this->PieceAt.push_back({ i, j, k });
          }
        }
      }
    }
  }

  /// Whether a face of a piece lies on the surface of its parent.
  bool onSurface(const FaceUse& use) const
  {
    const int d = faceDirection(use.face);
    const int last = this->cutCount(this->Result.blocks[use.block].parent, d) - 1;
    return this->PieceAt[use.block][d] == (faceSide(use.face) ? last : 0);
  }

  /// Surface quadrilateral of the parent at (s, t) of a piece's face, which must be on the surface.
  QuadAt quadOf(const FaceUse& use, int s, int t) const
  {
    const ComplexBlock& block = this->Result.blocks[use.block];
    return { block.parent, use.face, block.offset[faceAxis(use.face, 0)] + s, block.offset[faceAxis(use.face, 1)] + t };
  }

  /// Piece that has a surface quadrilateral.
  int pieceOf(const QuadAt& quad) const
  {
    const CutPositions& cuts = this->Cuts[quad.block];
    const auto slot = [&](int direction, int position) {
      const std::vector<int>& c = cuts[direction];
      return static_cast<int>(std::upper_bound(c.begin(), c.end(), position) - c.begin()) - 1;
    };
    Ijk at{};
    const int normal = faceDirection(quad.face);
    at[normal] = faceSide(quad.face) ? this->cutCount(quad.block, normal) - 1 : 0;
    at[faceAxis(quad.face, 0)] = slot(faceAxis(quad.face, 0), quad.s);
    at[faceAxis(quad.face, 1)] = slot(faceAxis(quad.face, 1), quad.t);
    return this->piece(quad.block, at);
  }

  void makeFaces()
  {
    for (int b = 0; b < static_cast<int>(this->Result.blocks.size()); ++b)
    {
      for (int face = 0; face < 6; ++face)
      {
        if (this->Result.blocks[b].faces[face] < 0)
        {
          this->makeFace({ b, face });
        }
      }
    }
  }

  void makeFace(const FaceUse& use)
  {
    const int id = static_cast<int>(this->Result.faces.size());
    const ComplexBlock& block = this->Result.blocks[use.block];
    ComplexFace result;
    result.uses = { use };
    if (!this->onSurface(use))
    {
      Ijk neighbor = this->PieceAt[use.block];
      const int d = faceDirection(use.face);
      neighbor[d] += faceSide(use.face) ? 1 : -1;
      result.uses.push_back({ this->piece(block.parent, neighbor), use.face ^ 1 });
      const std::vector<int>& forContacts = this->ContactCuts[block.parent][d];
      const int position = block.offset[d] + (faceSide(use.face) ? block.cells(d) : 0);
      result.creaseCut = !std::binary_search(forContacts.begin(), forContacts.end(), position);
    }
    else
    {
      const QuadAt at = this->quadOf(use, 0, 0);
      if (this->Links.boundary(at))
      {
        result.tag = this->Links.tag(at);
      }
      else
      {
        const QuadAt other = this->Surface.quadAt(this->Links.partner(at), at.block);
        result.orientation = this->Links.orientation(at);
        result.uses.push_back({ this->pieceOf(other), other.face });
      }
    }
    for (const FaceUse& side : result.uses)
    {
      int& slot = this->Result.blocks[side.block].faces[side.face];
      if (slot >= 0)
      {
        throw Error(
          "faces of " + this->Result.blocks[side.block].name + " and " + block.name + " do not meet one to one");
      }
      slot = id;
    }
    if (!result.boundary())
    {
      const FaceUse& b = result.uses[1];
      const int swap = swapsAxes(result.orientation) ? 1 : 0;
      for (int axis = 0; axis < 2; ++axis)
      {
        if (block.cells(faceAxis(use.face, axis)) != this->Result.blocks[b.block].cells(faceAxis(b.face, axis ^ swap)))
        {
          throw Error("faces of " + block.name + " and " + this->Result.blocks[b.block].name + " differ in size");
        }
      }
    }
    this->Result.faces.push_back(std::move(result));
  }

  void makeVerticesAndEdges()
  {
    numberVerticesAndEdges(this->Result);
    for (const ComplexFace& face : this->Result.faces)
    {
      if (face.boundary())
      {
        this->markCreases(face.uses[0]);
      }
    }
  }

  void refuseCrowds() const
  {
    const auto refuse = [&](const std::string& what, int block, const Ijk& at) {
      throw Error("more than " + std::to_string(MostBlocksAtEdge) + " " + what + " of " +
        this->Result.blocks[block].name + " at its point " + text(at));
    };
    const auto corner = [&](const CornerUse& use) {
      const ComplexBlock& block = this->Result.blocks[use.block];
      Ijk at;
      for (int d = 0; d < 3; ++d)
      {
        at[d] = cornerSide(use.corner, d) * block.cells(d);
      }
      return at;
    };
    for (const ComplexEdge& edge : this->Result.edges)
    {
      if (edge.valence() > MostBlocksAtEdge)
      {
        const EdgeUse& use = edge.uses.front();
        refuse("blocks meet at the edge", use.block, corner({ use.block, edgeCorner(use.edge, 0) }));
      }
    }
    std::vector<int> faces(this->Result.vertices.size(), 0);
    for (const ComplexFace& face : this->Result.faces)
    {
      const FaceUse& use = face.uses.front();
      for (int c = 0; c < 4 && face.boundary(); ++c)
      {
        const int vertex = this->Result.blocks[use.block].vertices[faceCorner(use.face, c & 1, c >> 1)];
        if (++faces[vertex] > MostBlocksAtEdge)
        {
          const CornerUse& at = this->Result.vertices[vertex].corners.front();
          refuse("boundary faces meet at the vertex", at.block, corner(at));
        }
      }
    }
  }

  void markCreases(const FaceUse& use)
  {
    const ComplexBlock& block = this->Result.blocks[use.block];
    const int last[2] = { block.cells(faceAxis(use.face, 0)) - 1, block.cells(faceAxis(use.face, 1)) - 1 };
    for (int axis = 0; axis < 2; ++axis)
    {
      for (int side = 0; side < 2; ++side)
      {
        ComplexEdge& edge = this->Result.edges[block.edges[faceEdge(use.face, axis, side)]];
        // Of an edge with other cells around it all mesh edges are creases, or none is; else any makes it one.
        const int across = side ? last[1 - axis] : 0;
        for (int along = 0; along <= last[axis] && !edge.crease; ++along)
        {
          edge.crease =
            this->Creases(axis == 0 ? this->quadOf(use, along, across) : this->quadOf(use, across, along), axis, side);
        }
      }
    }
  }

  /// Calls visit(point of A's parent, point of B's parent) for all points of a contact of two surfaces.
  template <typename Visit>
  void forEachSharedPoint(const ComplexFace& face, const Visit& visit) const
  {
    const FaceUse& a = face.uses[0];
    const FaceUse& b = face.uses[1];
    const ComplexBlock& blockA = this->Result.blocks[a.block];
    const ComplexBlock& blockB = this->Result.blocks[b.block];
    const int ns = blockA.cells(faceAxis(a.face, 0));
    const int nt = blockA.cells(faceAxis(a.face, 1));
    const Ijk cellsA{ blockA.cells(0), blockA.cells(1), blockA.cells(2) };
    const Ijk cellsB{ blockB.cells(0), blockB.cells(1), blockB.cells(2) };
    for (int t = 0; t <= nt; ++t)
    {
      for (int s = 0; s <= ns; ++s)
      {
        const auto onB = mapFacePoint(face.orientation, s, t, ns, nt);
        Ijk p = facePoint(cellsA, a.face, s, t);
        Ijk q = facePoint(cellsB, b.face, onB[0], onB[1]);
        for (int d = 0; d < 3; ++d)
        {
          p[d] += blockA.offset[d];
          q[d] += blockB.offset[d];
        }
        visit(p, q);
      }
    }
  }

  /// Whether the points of its first block are here: each contact is looked at by one rank.
  bool isHere(const ComplexFace& face) const { return this->Result.blocks[face.uses[0].block].points.isHere(); }

  /// Four quadrilaterals of a piece of a face, or fewer if it is small.
  template <typename Visit>
  void forEachSample(const FaceUse& use, const Visit& visit) const
  {
    const int ns = this->Result.blocks[use.block].cells(faceAxis(use.face, 0));
    const int nt = this->Result.blocks[use.block].cells(faceAxis(use.face, 1));
    for (int t : { 0, nt / 2 })
    {
      for (int s : { 0, ns / 2 })
      {
        const QuadAt at = this->quadOf(use, s, t);
        visit(at, this->Surface.quadAt(this->Links.partner(at), at.block));
      }
    }
  }

  /// Fetches what the contacts of blocks here with those of other ranks are compared with.
  void fetchContacts()
  {
    if (this->Ranks.size() == 1)
    {
      return;
    }
    std::vector<PointBox> wanted;
    for (const ComplexFace& face : this->Result.faces)
    {
      if (face.boundary() || !this->isHere(face) || this->Result.blocks[face.uses[1].block].points.isHere())
      {
        continue;
      }
      this->forEachSample(face.uses[0], [&](const QuadAt&, const QuadAt& other) {
        wanted.push_back(
          pointsAtFace(this->Mesh, other.block, other.face, { { other.s, other.t }, { other.s + 1, other.t + 1 } }, 2));
      });
      if (!this->sameBits(face))
      {
        const FaceUse& use = face.uses[1];
        const ComplexBlock& block = this->Result.blocks[use.block];
        const QuadAt first = this->quadOf(use, 0, 0);
        wanted.push_back(pointsAtFace(this->Mesh, block.parent, use.face,
          { { first.s, first.t },
            { first.s + block.cells(faceAxis(use.face, 0)), first.t + block.cells(faceAxis(use.face, 1)) } },
          1));
      }
    }
    this->Part.fetch(wanted);
  }

  /// Whether all points of a contact are known to be the same bits on both sides.
  bool sameBits(const ComplexFace& face) const
  {
    return this->Links.sameBits(this->Result.blocks[face.uses[0].block].parent, face.uses[0].face);
  }

  /// Two blocks on the same side of their contact lie in each other.
  void refuseFoldedContacts() const
  {
    const Index count = static_cast<Index>(this->Result.faces.size());
    std::vector<char> folded(count, false);
    this->Run.parallelFor(count, 256, [&](Index begin, Index end) {
      for (Index n = begin; n < end; ++n)
      {
        folded[n] = this->folded(this->Result.faces[n]);
      }
    });
    for (Index n = 0; n < count; ++n)
    {
      if (folded[n])
      {
        const QuadAt at = this->quadOf(this->Result.faces[n].uses[0], 0, 0);
        const QuadAt other = this->Surface.quadAt(this->Links.partner(at));
        throw ErrorAt(n,
          blockLabel(this->Mesh, at.block) + " " + faceLabel(at.face) + " and " + blockLabel(this->Mesh, other.block) +
            " " + faceLabel(other.face) + " meet, but both blocks lie on the same side of the contact (near " +
            text(this->Mesh.blocks[at.block].points(this->Surface.corner(at, 0, 0))) + ")");
      }
    }
  }

  /// Majority of up to four quadrilaterals, because single cells may be tangled.
  bool folded(const ComplexFace& face) const
  {
    const FaceUse& use = face.uses[0];
    if (face.boundary() || !this->onSurface(use) || !this->isHere(face))
    {
      return false;
    }
    int votes = 0;
    this->forEachSample(use, [&](const QuadAt& at, const QuadAt& other) {
      const Vec3 normal = outwardNormal(this->Mesh, this->Surface, at, false);
      const double sides = normal.dot(this->inwards(at)) * normal.dot(this->inwards(other));
      votes += sides > 0.0 ? 1 : sides < 0.0 ? -1 : 0;
    });
    return votes > 0;
  }

  /// From a surface quadrilateral to the one behind it, sum over their corners.
  Vec3 inwards(const QuadAt& at) const
  {
    const GridView& points = this->Mesh.blocks[at.block].points;
    Vec3 sum = Vec3::Zero();
    for (int c = 0; c < 4; ++c)
    {
      Ijk p = this->Surface.corner(at, c & 1, c >> 1);
      const Vec3 x = points(p);
      p[faceDirection(at.face)] += faceSide(at.face) ? -1 : 1;
      sum += points(p) - x;
    }
    return sum;
  }

  /// Gives all copies of a shared point the same bits.
  void weld()
  {
    std::vector<const ComplexFace*> contacts;
    for (const ComplexFace& face : this->Result.faces)
    {
      if (!face.boundary() && this->onSurface(face.uses[0]))
      {
        contacts.push_back(&face);
      }
    }
    std::atomic<bool> differ{ false };
    this->Run.parallelFor(static_cast<Index>(contacts.size()), 16, [&](Index begin, Index end) {
      for (Index n = begin; n < end && !differ; ++n)
      {
        if (!this->isHere(*contacts[n]) || this->sameBits(*contacts[n]))
        {
          continue;
        }
        const GridView& pointsA = this->parentOf(contacts[n]->uses[0]).points;
        const GridView& pointsB = this->parentOf(contacts[n]->uses[1]).points;
        bool same = true;
        this->forEachSharedPoint(
          *contacts[n], [&](const Ijk& p, const Ijk& q) { same = same && bsv::sameBits(pointsA(p), pointsB(q)); });
        if (!same)
        {
          differ = true;
        }
      }
    });
    if (!this->Ranks.any(differ))
    {
      return;
    }

    // A point here has all its copies in blocks that share a vertex with one here.
    const std::vector<char> near = this->blocksNear();
    const SurfaceNumbering numbering(this->Mesh, &near);
    const Index pointCount = numbering.pointCount();
    UnionFind copies(pointCount);
    for (const ComplexFace* face : contacts)
    {
      const int a = this->Result.blocks[face->uses[0].block].parent;
      const int b = this->Result.blocks[face->uses[1].block].parent;
      if (near[a] && near[b])
      {
        this->forEachSharedPoint(
          *face, [&](const Ijk& p, const Ijk& q) { copies.unite(numbering.point(a, p), numbering.point(b, q)); });
      }
    }
    const CopiedPoints coordinates(this->Mesh, this->Surface, numbering, copies, this->Ranks);
    // Per class, at its representative, the copy that all get.
    std::vector<Index> chosen(pointCount, -1);
    for (Index point = 0; point < pointCount; ++point)
    {
      Index& best = chosen[copies.find(point)];
      if (coordinates.known(point) && (best < 0 || before(coordinates(point), coordinates(best))))
      {
        best = point;
      }
    }
    std::vector<double*> welded(this->Surface.blockCount(), nullptr);
    for (Index point = 0; point < pointCount; ++point)
    {
      const Index best = chosen[copies.find(point)];
      if (best == point)
      {
        continue;
      }
      const int b = numbering.blockOfPoint(point);
      const GridView& points = this->Mesh.blocks[b].points;
      if (!points.isHere())
      {
        continue;
      }
      const Ijk at = numbering.pointAt(b, point);
      const Vec3 x = coordinates(best);
      if (!bsv::sameBits(points(at), x))
      {
        welded[b] = welded[b] ? welded[b] : this->copyPoints(b);
        const Ijk& n = points.counts();
        std::copy(x.data(), x.data() + 3, welded[b] + 3 * (at[0] + n[0] * (at[1] + Index(n[1]) * at[2])));
      }
    }
    for (ComplexBlock& block : this->Result.blocks)
    {
      if (welded[block.parent])
      {
        const Ijk last{ block.offset[0] + block.cells(0), block.offset[1] + block.cells(1),
          block.offset[2] + block.cells(2) };
        block.points =
          GridView(welded[block.parent], this->Mesh.blocks[block.parent].points.counts()).box(block.offset, last);
      }
    }
  }

  /// Whether the points of a block of the mesh, or of one that shares a vertex with it, are here.
  std::vector<char> blocksNear() const
  {
    std::vector<char> near(this->Surface.blockCount(), false);
    for (const ComplexVertex& vertex : this->Result.vertices)
    {
      const auto isHere = [this](const CornerUse& use) { return this->Result.blocks[use.block].points.isHere(); };
      if (std::any_of(vertex.corners.begin(), vertex.corners.end(), isHere))
      {
        for (const CornerUse& use : vertex.corners)
        {
          near[this->Result.blocks[use.block].parent] = true;
        }
      }
    }
    return near;
  }

  const MeshBlock& parentOf(const FaceUse& use) const
  {
    return this->Mesh.blocks[this->Result.blocks[use.block].parent];
  }

  double* copyPoints(int b)
  {
    const GridView& points = this->Mesh.blocks[b].points;
    const Ijk& n = points.counts();
    auto copy = std::make_shared<std::vector<double>>(3 * points.size());
    double* data = copy->data();
    this->Run.parallelFor(n[2], 1, [&](Index begin, Index end) {
      for (int k = static_cast<int>(begin); k < end; ++k)
      {
        double* to = data + 3 * Index(n[0]) * n[1] * k;
        for (int j = 0; j < n[1]; ++j)
        {
          for (int i = 0; i < n[0]; ++i, to += 3)
          {
            const Vec3 x = points(i, j, k);
            std::copy(x.data(), x.data() + 3, to);
          }
        }
      }
    });
    this->Result.weldedPoints.push_back(std::move(copy));
    return data;
  }

  void tell()
  {
    const std::vector<std::string>& found = this->Creases.notes();
    this->Result.notes.insert(this->Result.notes.end(), found.begin(), found.end());
    this->Result.tangledCells = this->Check.tangledCells;
    std::vector<std::string> leftHanded;
    std::vector<std::string> split;
    std::vector<std::string> alongCreases;
    for (int b = 0; b < this->Surface.blockCount(); ++b)
    {
      if (this->Check.leftHanded[b])
      {
        leftHanded.push_back(blockLabel(this->Mesh, b));
      }
      const Index pieces = piecesOf(this->Cuts[b]);
      const Index forContacts = piecesOf(this->ContactCuts[b]);
      if (forContacts > 1)
      {
        split.push_back(blockLabel(this->Mesh, b) + " into " + std::to_string(forContacts));
      }
      if (pieces > forContacts)
      {
        alongCreases.push_back(blockLabel(this->Mesh, b) + " into " + std::to_string(pieces));
      }
    }
    if (!leftHanded.empty())
    {
      this->Result.warnings.push_back(
        counted(leftHanded.size(), "block is", "blocks are") + " left-handed: " + listed(leftHanded) + ".");
    }
    if (this->Check.tangledCells > 0)
    {
      this->Result.warnings.push_back(counted(this->Check.tangledCells, "cell is", "cells are") +
        " tangled (a corner Jacobian is zero or of the wrong sign), first in " +
        blockLabel(this->Mesh, this->Check.tangledBlock) + " at cell " + text(this->Check.tangledCell) + ".");
    }
    if (!split.empty())
    {
      this->Result.notes.push_back(counted(split.size(), "block was", "blocks were") +
        " split along partial contacts or boundary borders: " + listed(split) + ".");
    }
    if (!alongCreases.empty())
    {
      this->Result.creaseNote = counted(alongCreases.size(), "block was", "blocks were") +
        " split along creases: " + listed(alongCreases) + ".";
    }
  }

  PartialMesh Part;
  const BlockMesh& Mesh;
  const Execution& Run;
  const bsv::Ranks& Ranks;
  const MeshCheck Check;
  const SurfaceNumbering Surface;
  const Contacts Links;
  const CreaseEdges Creases;
  const std::vector<CutPositions> Cuts;
  /// Those that would be there without creases.
  const std::vector<CutPositions> ContactCuts;
  std::vector<int> FirstPiece;
  std::vector<Ijk> PieceAt;
  BlockComplex Result;
};

} // namespace

void numberVerticesAndEdges(BlockComplex& complex)
{
  std::vector<Interface> contacts;
  for (const ComplexFace& face : complex.faces)
  {
    if (!face.boundary())
    {
      const FaceUse& a = face.uses[0];
      const FaceUse& b = face.uses[1];
      contacts.push_back({ a.block, a.face, b.block, b.face, face.orientation, {}, {} });
    }
  }
  const int blockCount = static_cast<int>(complex.blocks.size());
  const SharedEntities shared =
    sharedEntities(blockCount, contacts, [&](int block) { return complex.blocks[block].name; });

  complex.vertices.assign(shared.vertices, {});
  complex.edges.clear();
  for (const SharedEntities::Edge& entry : shared.edges)
  {
    ComplexEdge edge;
    edge.vertices = entry.vertices;
    edge.cells = complex.blocks[entry.block].cells(edgeDirection(entry.edge));
    edge.uses.reserve(entry.uses);
    complex.edges.push_back(std::move(edge));
  }
  for (int b = 0; b < blockCount; ++b)
  {
    ComplexBlock& block = complex.blocks[b];
    block.vertices = shared.blocks[b].vertices;
    block.edges = shared.blocks[b].edges;
    block.edgeReversed = shared.blocks[b].edgeReversed;
    for (int c = 0; c < 8; ++c)
    {
      complex.vertices[block.vertices[c]].corners.push_back({ b, c });
    }
    for (int e = 0; e < 12; ++e)
    {
      ComplexEdge& edge = complex.edges[block.edges[e]];
      const int cells = block.cells(edgeDirection(e));
      if (edge.cells != cells)
      {
        throw Error("edges of " + block.name + " and " + complex.blocks[edge.uses[0].block].name + " that meet have " +
          std::to_string(cells) + " and " + std::to_string(edge.cells) + " cells");
      }
      edge.uses.push_back({ b, e, block.edgeReversed[e] });
    }
  }
  for (const ComplexFace& face : complex.faces)
  {
    const FaceUse& use = face.uses.front();
    const ComplexBlock& block = complex.blocks[use.block];
    for (int n = 0; n < 4 && face.boundary(); ++n)
    {
      complex.vertices[block.vertices[faceCorner(use.face, n & 1, n >> 1)]].boundary = true;
      complex.edges[block.edges[faceEdge(use.face, n & 1, n >> 1)]].boundary = true;
    }
  }
}

BlockComplex buildBlockComplex(const BlockMesh& mesh, const BlockComplexOptions& options, const Execution& run)
{
  return buildBlockComplex(mesh, options, {}, nullptr, run);
}

BlockComplex buildBlockComplex(const BlockMesh& mesh, const BlockComplexOptions& options, const CreaseRules& rules,
  std::vector<TurningEdge>* turning, const Execution& run)
{
  if (!(options.matchTolerance > 0.0 && options.matchTolerance < 0.5))
  {
    throw Error("Match Tolerance " + text(options.matchTolerance) + " is not between 0 and 0.5");
  }
  if (!(options.creaseAngle >= 0.0 && options.creaseAngle <= 180.0))
  {
    throw Error("Crease Angle " + text(options.creaseAngle) + " is not between 0 and 180 degrees");
  }
  if (!(rules.contrast >= 0.0))
  {
    throw Error("Crease Contrast " + text(rules.contrast) + " is not 0 or more");
  }
  Builder builder(mesh, options, rules, run);
  if (turning)
  {
    *turning = builder.turning();
  }
  return builder.build();
}

Ijk facePoint(const Ijk& cells, int face, int s, int t)
{
  Ijk p{};
  p[faceDirection(face)] = faceSide(face) ? cells[faceDirection(face)] : 0;
  p[faceAxis(face, 0)] = s;
  p[faceAxis(face, 1)] = t;
  return p;
}

} // namespace bsv
