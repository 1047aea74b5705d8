// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/JoinedBlocks.h"

#include "Base/UnionFind.h"

#include <algorithm>
#include <map>

namespace bsv
{

namespace
{

/// Names listed in a note before "..".
constexpr int MostListed = 5;

/// Piece number n of a block along a direction.
int pieceAlong(const JoinedBlock& block, int direction, int n)
{
  const int stride = direction == 0 ? 1 : direction == 1 ? block.counts[0] : block.counts[0] * block.counts[1];
  return block.pieces[n * stride];
}

int controlPoints(const std::vector<double>& knots)
{
  return static_cast<int>(knots.size()) - 4;
}

/// Control point, per direction, at which each piece along it begins.
std::array<std::vector<int>, 3> firstControlPoints(
  const JoinedBlock& block, const std::vector<std::array<std::vector<double>, 3>>& knots)
{
  std::array<std::vector<int>, 3> first;
  for (int d = 0; d < 3; ++d)
  {
    first[d].push_back(0);
    for (int n = 0; n + 1 < block.counts[d]; ++n)
    {
      first[d].push_back(first[d].back() + controlPoints(knots[pieceAlong(block, d, n)][d]) - 1);
    }
  }
  return first;
}

/// The boxes of pieces, in the order of their first ones, and which box each piece is in.
void collectPieces(const BlockComplex& cut, JoinedBlocks& result)
{
  UnionFind joined(cut.blocks.size());
  for (const ComplexFace& face : cut.faces)
  {
    if (face.creaseCut)
    {
      joined.unite(face.uses[0].block, face.uses[1].block);
    }
  }
  std::map<Index, int> numbers;
  for (int piece = 0; piece < static_cast<int>(cut.blocks.size()); ++piece)
  {
    const auto [found, isNew] = numbers.emplace(joined.find(piece), static_cast<int>(result.blocks.size()));
    if (isNew)
    {
      result.blocks.emplace_back();
    }
    result.blockOf.push_back(found->second);
    result.blocks[found->second].pieces.push_back(piece);
  }
  // Pieces of a block of the mesh are numbered i fastest, and so are those of a box of them.
  for (JoinedBlock& block : result.blocks)
  {
    for (int d = 0; d < 3; ++d)
    {
      const auto inRow = [&](int piece) {
        const Ijk &a = cut.blocks[piece].offset, &b = cut.blocks[block.pieces[0]].offset;
        return a[(d + 1) % 3] == b[(d + 1) % 3] && a[(d + 2) % 3] == b[(d + 2) % 3];
      };
      block.counts[d] = static_cast<int>(std::count_if(block.pieces.begin(), block.pieces.end(), inRow));
    }
  }
}

void makeBlocks(const BlockComplex& cut, JoinedBlocks& result)
{
  std::map<int, std::array<int, 2>> perParent; // pieces, and blocks joined of them
  for (const JoinedBlock& block : result.blocks)
  {
    std::array<int, 2>& count = perParent[cut.blocks[block.pieces[0]].parent];
    count[0] += static_cast<int>(block.pieces.size());
    ++count[1];
  }
  std::map<int, int> next;
  for (const JoinedBlock& joined : result.blocks)
  {
    ComplexBlock block = cut.blocks[joined.pieces[0]];
    Ijk points;
    for (int d = 0; d < 3; ++d)
    {
      points[d] = 1;
      for (int n = 0; n < joined.counts[d]; ++n)
      {
        points[d] += cut.blocks[pieceAlong(joined, d, n)].cells(d);
      }
    }
    block.points = GridView::elsewhere(points);
    block.faces.fill(-1);
    const auto [pieces, blocks] = perParent[block.parent];
    const int number = next[block.parent]++;
    if (pieces > 1)
    {
      block.name.erase(block.name.rfind('.'));
      block.name += blocks > 1 ? "." + std::to_string(number) : "";
    }
    result.complex.blocks.push_back(std::move(block));
  }
}

/// In the order in which they would be numbered without creases. All parts of a face meet the same other one in the
/// same way: that of the first piece tells.
void makeFaces(const BlockComplex& cut, JoinedBlocks& result)
{
  for (int b = 0; b < static_cast<int>(result.blocks.size()); ++b)
  {
    for (int face = 0; face < 6; ++face)
    {
      if (result.complex.blocks[b].faces[face] >= 0)
      {
        continue;
      }
      const int d = faceDirection(face);
      const int piece = pieceAlong(result.blocks[b], d, faceSide(face) ? result.blocks[b].counts[d] - 1 : 0);
      ComplexFace whole = cut.faces[cut.blocks[piece].faces[face]];
      if (whole.uses.front().block != piece || whole.uses.front().face != face)
      {
        std::swap(whole.uses[0], whole.uses[1]);
        whole.orientation = inverseOrientation(whole.orientation);
      }
      for (FaceUse& use : whole.uses)
      {
        use.block = result.blockOf[use.block];
        result.complex.blocks[use.block].faces[use.face] = static_cast<int>(result.complex.faces.size());
      }
      result.complex.faces.push_back(std::move(whole));
    }
  }
}

void markCreases(const BlockComplex& cut, JoinedBlocks& result)
{
  for (ComplexEdge& edge : result.complex.edges)
  {
    edge.crease = edge.boundary;
  }
  for (std::size_t b = 0; b < result.blocks.size(); ++b)
  {
    const JoinedBlock& block = result.blocks[b];
    for (int e = 0; e < 12; ++e)
    {
      const int along = edgeDirection(e);
      const int axes[2] = { faceAxis(2 * along, 0), faceAxis(2 * along, 1) };
      Ijk at;
      at[axes[0]] = edgeSide(e, 0) ? block.counts[axes[0]] - 1 : 0;
      at[axes[1]] = edgeSide(e, 1) ? block.counts[axes[1]] - 1 : 0;
      for (at[along] = 0; at[along] < block.counts[along]; ++at[along])
      {
        const int piece = block.pieces[at[0] + block.counts[0] * (at[1] + block.counts[1] * at[2])];
        if (!cut.edges[cut.blocks[piece].edges[e]].crease)
        {
          result.complex.edges[result.complex.blocks[b].edges[e]].crease = false;
        }
      }
    }
  }
}

} // namespace

JoinedBlocks joinPieces(const BlockComplex& cut)
{
  JoinedBlocks result;
  collectPieces(cut, result);
  BlockComplex& complex = result.complex;
  complex.boundaryNames = cut.boundaryNames;
  complex.boundaryTypes = cut.boundaryTypes;
  complex.tangledCells = cut.tangledCells;
  complex.warnings = cut.warnings;
  complex.notes = cut.notes;
  makeBlocks(cut, result);
  makeFaces(cut, result);
  numberVerticesAndEdges(complex);
  markCreases(cut, result);

  int joined = 0;
  std::string names;
  for (std::size_t b = 0; b < result.blocks.size(); ++b)
  {
    if (result.blocks[b].pieces.size() > 1 && ++joined <= MostListed)
    {
      names += (joined == 1 ? "" : ", ") + complex.blocks[b].name;
    }
  }
  if (joined > 0)
  {
    complex.creaseNote = std::to_string(joined) + (joined == 1 ? " block stays" : " blocks stay") +
      " whole, with knots of multiplicity 3 where creases would cut: " + names + (joined > MostListed ? ", .." : "") +
      ".";
  }
  return result;
}

std::vector<double> joinedKnots(
  const JoinedBlock& block, int direction, const std::vector<std::array<std::vector<double>, 3>>& knots)
{
  std::vector<double> result = knots[pieceAlong(block, direction, 0)][direction];
  for (int n = 1; n < block.counts[direction]; ++n)
  {
    const std::vector<double>& next = knots[pieceAlong(block, direction, n)][direction];
    const double start = result.back();
    result.pop_back();
    std::transform(
      next.begin() + 4, next.end(), std::back_inserter(result), [start](double knot) { return start + knot; });
  }
  return result;
}

void joinNets(const JoinedBlock& block, const std::vector<std::array<std::vector<double>, 3>>& knots,
  const std::vector<ControlNetStorage>& nets, const ControlNetStorage& to, const Execution& run)
{
  const std::array<std::vector<int>, 3> first = firstControlPoints(block, knots);
  const Index rowStride = controlPoints(joinedKnots(block, 0, knots));
  const Index layerStride = rowStride * controlPoints(joinedKnots(block, 1, knots));
  auto piece = block.pieces.begin();
  for (const int k0 : first[2])
  {
    for (const int j0 : first[1])
    {
      for (const int i0 : first[0])
      {
        const std::array<std::vector<double>, 3>& own = knots[*piece];
        const ControlNetStorage& from = nets[*piece++];
        const int ni = controlPoints(own[0]), nj = controlPoints(own[1]), nk = controlPoints(own[2]);
        run.parallelFor(nk, 4, [&](Index begin, Index end) {
          for (Index k = begin; k < end; ++k)
          {
            for (int j = 0; j < nj; ++j)
            {
              const Index source = Index(ni) * (j + Index(nj) * k);
              const Index target = i0 + rowStride * (j0 + j) + layerStride * (k0 + k);
              std::copy_n(from.points + 3 * source, 3 * Index(ni), to.points + 3 * target);
              std::copy_n(from.rules + source, ni, to.rules + target);
            }
          }
        });
      }
    }
  }
}

} // namespace bsv
