// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/Splitting.h"

#include <algorithm>
#include <cstdlib>

namespace bsv
{

namespace
{

constexpr Index MostPieces = 1000000;

/// Worklist of cuts.
class Splitter
{
public:
  Splitter(const SurfaceNumbering& surface, const Contacts& contacts, const CreaseEdges* creases)
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
      if (this->Links.onePiece(block, face) && !(this->Creases && this->Creases->any(block, face)) &&
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
        bool needed = this->isCrease({ at, 1 - axis, 0 });
        for (int side = 0; side < 2; ++side)
        {
          needed = needed ||
            (this->isCrease({ before, axis, side }) != this->isCrease({ at, axis, side }) &&
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

  bool isCrease(const QuadEdge& edge) const
  {
    return this->Creases && (*this->Creases)(edge.quad, edge.axis, edge.side);
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
  const CreaseEdges* Creases;
  /// Per block, direction and mesh position.
  std::vector<std::array<std::vector<char>, 3>> IsCut;
};

} // namespace

std::vector<CutPositions> cutPositions(const BlockMesh& mesh, const SurfaceNumbering& surface, const Contacts& contacts,
  const CreaseEdges* creases, const Execution& run)
{
  return Splitter(surface, contacts, creases)(mesh, run);
}

} // namespace bsv
