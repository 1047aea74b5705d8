// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/CellFormats.h"

#include "Formats/HOPRFile.h"
#include "Ranks/Ranks.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>

namespace bsv
{

namespace
{

constexpr int CurvedHexahedron = 208;
constexpr int CurvedQuadrilateral = 24;

/// HOPR's sides: k min, j min, i max, j max, i min, k max, as sides of HexSides, and their corners.
constexpr int Sides[6] = { 4, 2, 1, 3, 0, 5 };
constexpr int SideCorners[6][4] = { { 0, 3, 2, 1 }, { 0, 1, 5, 4 }, { 1, 2, 6, 5 }, { 2, 3, 7, 6 }, { 0, 4, 7, 3 },
  { 4, 5, 6, 7 } };

/// HOPR's number, from 0, of a side of HexSides.
int hoprSide(int side)
{
  return static_cast<int>(std::find(std::begin(Sides), std::end(Sides), side) - std::begin(Sides));
}

/// Boundary condition types of HOPR's users: 2 outer boundaries, 4 walls, 9 symmetry planes.
int boundaryType(const std::string& type)
{
  if (type.compare(0, 6, "BCWall") == 0)
  {
    return 4;
  }
  return type == "BCSymmetryPlane" ? 9 : 2;
}

class HOPRWriter
{
public:
  HOPRWriter(const CurvedCells& cells, HOPRFile& file)
    : Cells(cells)
    , Volume(cells.volume())
    , File(file)
    , NodesPerCell(static_cast<int>(cellNodes(NodeOrder::Lexicographic, cells.order()).size()))
    , BoundaryOf(6 * cells.volume().volumes.size(), 0)
  {
    Index boundary = 0;
    const int names = static_cast<int>(this->Volume.boundaryNames.size());
    for (const BoundaryPatch& patch : this->Volume.boundaries)
    {
      this->BoundaryOf[6 * std::size_t(patch.block) + patch.face] = (patch.tag >= 0 ? patch.tag : names) + 1;
      boundary += cells.quadCount(patch);
    }
    const Index count = cells.cellCount();
    this->UniqueSides = (6 * count + boundary) / 2;
    if (6 * count > std::numeric_limits<int>::max() ||
      this->NodesPerCell * count > Index(std::numeric_limits<int>::max()))
    {
      throw Error("the volume has " + std::to_string(count) + " spans, and HOPR's numbers of 32 bits hold " +
        std::to_string(std::numeric_limits<int>::max() / this->NodesPerCell));
    }
  }

  void begin()
  {
    const Index count = this->Cells.cellCount();
    const int names = static_cast<int>(this->Volume.boundaryNames.size());
    const bool unnamed = std::any_of(this->Volume.boundaries.begin(), this->Volume.boundaries.end(),
      [](const BoundaryPatch& patch) { return patch.tag < 0; });
    const int conditions = names + (unnamed ? 1 : 0);
    this->File.call<&HOPRLibrary::number>("Version", 1.0);
    this->File.call<&HOPRLibrary::count>("Ngeo", this->Cells.order());
    this->File.call<&HOPRLibrary::count>("nElems", static_cast<int>(count));
    this->File.call<&HOPRLibrary::count>("nSides", static_cast<int>(6 * count));
    this->File.call<&HOPRLibrary::count>("nNodes", static_cast<int>(this->NodesPerCell * count));
    this->File.call<&HOPRLibrary::count>("nUniqueSides", static_cast<int>(this->UniqueSides));
    this->File.call<&HOPRLibrary::count>("nUniqueNodes", static_cast<int>(this->Cells.numbers().count()));
    this->File.call<&HOPRLibrary::count>("nBCs", conditions);

    this->File.call<&HOPRLibrary::create>("ElemInfo", HDF5Type::Integer, count, 6);
    this->File.call<&HOPRLibrary::create>("SideInfo", HDF5Type::Integer, 6 * count, 5);
    this->File.call<&HOPRLibrary::create>("NodeCoords", HDF5Type::Real, this->NodesPerCell * count, 3);
    this->File.call<&HOPRLibrary::create>("GlobalNodeIDs", HDF5Type::Integer, this->NodesPerCell * count, 0);
    this->File.call<&HOPRLibrary::create>("ElemBarycenters", HDF5Type::Real, count, 3);
    this->File.call<&HOPRLibrary::create>("ElemWeight", HDF5Type::Real, count, 0);

    std::vector<char> labels(HOPRLibrary::TextLength * conditions, ' ');
    std::vector<int> types(4 * static_cast<std::size_t>(conditions), 0);
    for (int n = 0; n < conditions; ++n)
    {
      const std::string name = n < names ? this->Volume.boundaryNames[n] : "unnamed";
      std::memcpy(
        labels.data() + HOPRLibrary::TextLength * n, name.data(), std::min(name.size(), HOPRLibrary::TextLength));
      types[4 * n] = n < names ? boundaryType(this->Volume.boundaryTypes[n]) : 1;
    }
    this->File.call<&HOPRLibrary::create>("BCNames", HDF5Type::Text, conditions, 0);
    this->File.call<&HOPRLibrary::texts>("BCNames", 0, conditions, 0, labels);
    this->File.call<&HOPRLibrary::create>("BCType", HDF5Type::Integer, conditions, 4);
    this->File.call<&HOPRLibrary::integers>("BCType", 0, conditions, 4, types);
  }

  /// All but the coordinates of the cells of a block, layer by layer.
  void topology(int block)
  {
    const Ijk& spans = this->Cells.spans(block);
    const NodeList nodes = cellNodes(NodeOrder::Lexicographic, this->Cells.order());
    for (int k = 0; k < spans[2]; ++k)
    {
      std::vector<int> elements;
      std::vector<int> sides;
      std::vector<int> numbers;
      const Index first = this->Cells.cellNumber(block, { 0, 0, k });
      Index cell = first;
      for (int j = 0; j < spans[1]; ++j)
      {
        for (int i = 0; i < spans[0]; ++i, ++cell)
        {
          const int perCell = this->NodesPerCell;
          elements.insert(elements.end(),
            { CurvedHexahedron, 1, static_cast<int>(6 * cell), static_cast<int>(6 * cell + 6),
              static_cast<int>(perCell * cell), static_cast<int>(perCell * cell + perCell) });
          for (int s = 0; s < 6; ++s)
          {
            this->appendSide(sides, block, { i, j, k }, s);
          }
          for (const Ijk& local : nodes)
          {
            numbers.push_back(
              static_cast<int>(this->Cells.numbers()(block, this->Cells.node(block, { i, j, k }, local)) + 1));
          }
        }
      }
      const Index count = cell - first;
      const std::vector<double> weights(static_cast<std::size_t>(count), 1.0);
      this->File.call<&HOPRLibrary::integers>("ElemInfo", first, count, 6, elements);
      this->File.call<&HOPRLibrary::integers>("SideInfo", 6 * first, 6 * count, 5, sides);
      this->File.call<&HOPRLibrary::integers>(
        "GlobalNodeIDs", this->NodesPerCell * first, this->NodesPerCell * count, 0, numbers);
      this->File.call<&HOPRLibrary::reals>("ElemWeight", first, count, 0, weights);
    }
  }

  /// Positions of the nodes of a block, i fastest.
  void coordinates(int block, const std::vector<double>& positions)
  {
    const Ijk& spans = this->Cells.spans(block);
    const Ijk counts = this->Cells.nodes(block);
    const NodeList nodes = cellNodes(NodeOrder::Lexicographic, this->Cells.order());
    for (int k = 0; k < spans[2]; ++k)
    {
      std::vector<double> points;
      std::vector<double> centres;
      for (int j = 0; j < spans[1]; ++j)
      {
        for (int i = 0; i < spans[0]; ++i)
        {
          double sum[3] = { 0.0, 0.0, 0.0 };
          for (const Ijk& local : nodes)
          {
            const Ijk p = this->Cells.node(block, { i, j, k }, local);
            const double* x = positions.data() + 3 * (p[0] + Index(counts[0]) * (p[1] + Index(counts[1]) * p[2]));
            points.insert(points.end(), x, x + 3);
            for (int c = 0; c < 3; ++c)
            {
              sum[c] += x[c];
            }
          }
          for (const double value : sum)
          {
            centres.push_back(value / static_cast<double>(nodes.size()));
          }
        }
      }
      const Index first = this->Cells.cellNumber(block, { 0, 0, k });
      const Index count = Index(spans[0]) * spans[1];
      this->File.call<&HOPRLibrary::reals>(
        "NodeCoords", this->NodesPerCell * first, this->NodesPerCell * count, 3, points);
      this->File.call<&HOPRLibrary::reals>("ElemBarycenters", first, count, 3, centres);
    }
  }

private:
  /// Number of a node at a corner of a side of a cell.
  Index corner(int block, const Ijk& cell, int side, int corner) const
  {
    const Ijk& at = HexCorners[SideCorners[side][corner]];
    const int p = this->Cells.order();
    return this->Cells.numbers()(block, this->Cells.node(block, cell, { p * at[0], p * at[1], p * at[2] }));
  }

  /// The cell and side (HOPR's) across a side, block -1 on the boundary.
  struct Across
  {
    int block = -1;
    Ijk cell{};
    int side = 0;
  };
  Across across(int block, const Ijk& cell, int side) const
  {
    const int face = this->Cells.sideOf(block, Sides[side]);
    const int d = faceDirection(face);
    Across other;
    if (cell[d] != (faceSide(face) ? this->Cells.spans(block)[d] - 1 : 0))
    {
      other.block = block;
      other.cell = cell;
      other.cell[d] += faceSide(face) ? 1 : -1;
      other.side = hoprSide(this->Cells.sideOf(block, face ^ 1));
      return other;
    }
    const FaceNeighbours::Neighbour found = this->Cells.across(block, face, cell);
    if (found.quad.block >= 0)
    {
      other.block = found.quad.block;
      other.cell = this->Cells.cellAt(found.quad);
      other.side = hoprSide(this->Cells.sideOf(other.block, found.quad.face));
    }
    return other;
  }

  void appendSide(std::vector<int>& sides, int block, const Ijk& cell, int side)
  {
    const Across other = this->across(block, cell, side);
    if (other.block < 0)
    {
      const int face = this->Cells.sideOf(block, Sides[side]);
      sides.insert(sides.end(),
        { CurvedQuadrilateral, this->uniqueNumber(block, cell, side), 0, 0,
          this->BoundaryOf[6 * std::size_t(block) + face] });
      return;
    }
    const Index own = 6 * this->Cells.cellNumber(block, cell) + side;
    const Index theirs = 6 * this->Cells.cellNumber(other.block, other.cell) + other.side;
    const bool master = own < theirs;
    const int number =
      master ? this->uniqueNumber(block, cell, side) : this->uniqueNumber(other.block, other.cell, other.side);
    const Index first = this->corner(block, cell, side, 0);
    int flip = 1;
    while (flip < 4 && this->corner(other.block, other.cell, other.side, flip - 1) != first)
    {
      ++flip;
    }
    sides.insert(sides.end(),
      { CurvedQuadrilateral, master ? number : -number,
        static_cast<int>(this->Cells.cellNumber(other.block, other.cell)) + 1, 10 * (other.side + 1) + flip, 0 });
  }

  /// Number, from 1, of the side of a master: masters and boundaries count in the order of the cells' sides. The
  /// numbers are found once, and kept: one per side.
  int uniqueNumber(int block, const Ijk& cell, int side)
  {
    if (this->Numbers.empty())
    {
      this->Numbers.assign(static_cast<std::size_t>(6 * this->Cells.cellCount()), 0);
      int next = 0;
      Index at = 0;
      for (int b = 0; b < this->Cells.blockCount(); ++b)
      {
        const Ijk& spans = this->Cells.spans(b);
        for (int k = 0; k < spans[2]; ++k)
        {
          for (int j = 0; j < spans[1]; ++j)
          {
            for (int i = 0; i < spans[0]; ++i)
            {
              for (int s = 0; s < 6; ++s, ++at)
              {
                const Across other = this->across(b, { i, j, k }, s);
                if (other.block < 0 || at < 6 * this->Cells.cellNumber(other.block, other.cell) + other.side)
                {
                  this->Numbers[at] = ++next;
                }
              }
            }
          }
        }
      }
    }
    return this->Numbers[6 * this->Cells.cellNumber(block, cell) + side];
  }

  const CurvedCells& Cells;
  const VolumeToWrite& Volume;
  HOPRFile& File;
  const int NodesPerCell;
  /// Boundary condition, from 1, of every block face on the boundary.
  std::vector<int> BoundaryOf;
  Index UniqueSides = 0;
  std::vector<int> Numbers;
};

} // namespace

void writeHOPR(const CurvedCells& cells, AtomicFile& file, const Execution& run, std::vector<std::string>& notes)
{
  const Ranks& ranks = *run.ranks;
  std::unique_ptr<HOPRFile> output;
  std::unique_ptr<HOPRWriter> writer;
  if (ranks.rank() == 0)
  {
    const double bytes = (28.0 * std::pow(cells.order() + 1.0, 3) + 176.0) * static_cast<double>(cells.cellCount());
    file.requireRoom(bytes);
    output = std::make_unique<HOPRFile>(file, writingSeconds(bytes), run, notes);
    writer = std::make_unique<HOPRWriter>(cells, *output);
    writer->begin();
  }
  for (int b = 0; b < cells.blockCount(); ++b)
  {
    const int owner = cells.volume().volumes[b].rank;
    std::vector<double> positions;
    run.report(static_cast<double>(cells.firstCell(b)) / (static_cast<double>(cells.cellCount()) + 1.0));
    if (owner == ranks.rank())
    {
      Execution quiet = run;
      quiet.progress = [](double) { return true; };
      positions = cells.positions(b, quiet);
    }
    positions = onFirstRank(ranks, owner, std::move(positions));
    if (writer)
    {
      writer->topology(b);
      writer->coordinates(b, positions);
    }
  }
  if (writer)
  {
    output->close();
    file.takeOver();
  }
}

} // namespace bsv
