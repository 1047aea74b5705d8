// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/CellFormats.h"

#include "Ranks/Ranks.h"

#include <vtk_hdf5.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>

#include <unistd.h>

namespace bsv
{

namespace
{

constexpr int CurvedHexahedron = 208;
constexpr int CurvedQuadrilateral = 24;
constexpr std::size_t NameLength = 255;

/// HOPR's sides: k min, j min, i max, j max, i min, k max, as sides of HexSides, and their corners.
constexpr int Sides[6] = { 4, 2, 1, 3, 0, 5 };
constexpr int SideCorners[6][4] = { { 0, 3, 2, 1 }, { 0, 1, 5, 4 }, { 1, 2, 6, 5 }, { 2, 3, 7, 6 }, { 0, 4, 7, 3 },
  { 4, 5, 6, 7 } };

/// HOPR's number, from 0, of a side of HexSides.
int hoprSide(int side)
{
  return static_cast<int>(std::find(std::begin(Sides), std::end(Sides), side) - std::begin(Sides));
}

/// Something of the HDF5 library that has to be closed.
class Handle
{
public:
  Handle(hid_t id, herr_t (*close)(hid_t))
    : Id(id)
    , Close(close)
  {
  }
  ~Handle()
  {
    if (this->Id >= 0)
    {
      this->Close(this->Id);
    }
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return this->Id; }

private:
  hid_t Id;
  herr_t (*Close)(hid_t);
};

/// An HDF5 file under the temporary name of an AtomicFile.
class HDF5File
{
public:
  HDF5File(AtomicFile& file, double bytes)
    : File(file)
  {
    file.requireRoom(bytes);
    // Errors become exceptions here, and nothing is printed.
    H5Eget_auto2(H5E_DEFAULT, &this->Report, &this->ReportData);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    this->Id = H5Fcreate(file.temporaryPath().c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    if (this->Id < 0)
    {
      H5Eset_auto2(H5E_DEFAULT, this->Report, this->ReportData);
      throw FileError("Cannot create '" + file.target() + "'", errno);
    }
  }
  ~HDF5File()
  {
    if (this->Id >= 0)
    {
      // The library needs room for what it still holds.
      (void)!::truncate(this->File.temporaryPath().c_str(), 0);
      H5Fclose(this->Id);
    }
    H5Eset_auto2(H5E_DEFAULT, this->Report, this->ReportData);
  }
  HDF5File(const HDF5File&) = delete;
  HDF5File& operator=(const HDF5File&) = delete;

  void close()
  {
    this->check(H5Fflush(this->Id, H5F_SCOPE_GLOBAL), "the end");
    const hid_t id = this->Id;
    this->Id = -1;
    this->check(H5Fclose(id), "the end");
    this->File.takeOver();
  }

  void attribute(const char* name, double value) { this->attribute(name, H5T_NATIVE_DOUBLE, &value); }
  void attribute(const char* name, int value) { this->attribute(name, H5T_NATIVE_INT, &value); }

  /// A data set of rows, to be filled by rows().
  void create(const char* name, hid_t type, Index rows, int columns)
  {
    const hsize_t size[2] = { static_cast<hsize_t>(rows), static_cast<hsize_t>(columns) };
    const Handle space(H5Screate_simple(columns > 0 ? 2 : 1, size, nullptr), &H5Sclose);
    const Handle properties(H5Pcreate(H5P_DATASET_CREATE), &H5Pclose);
    // The time of day would make equal meshes to different files.
    this->check(H5Pset_obj_track_times(properties, false), name);
    const Handle set(H5Dcreate2(this->Id, name, type, space, H5P_DEFAULT, properties, H5P_DEFAULT), &H5Dclose);
    this->check(set, name);
  }

  /// Writes the rows [first, first + count). @param columns 0: one value a row
  void rows(const char* name, hid_t type, Index first, Index count, int columns, const void* values)
  {
    if (count == 0)
    {
      return;
    }
    const hsize_t start[2] = { static_cast<hsize_t>(first), 0 };
    const hsize_t size[2] = { static_cast<hsize_t>(count), static_cast<hsize_t>(columns) };
    const int rank = columns > 0 ? 2 : 1;
    const Handle set(H5Dopen2(this->Id, name, H5P_DEFAULT), &H5Dclose);
    const Handle space(H5Dget_space(set), &H5Sclose);
    const Handle memory(H5Screate_simple(rank, size, nullptr), &H5Sclose);
    this->check(H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, size, nullptr), name);
    this->check(H5Dwrite(set, type, memory, space, H5P_DEFAULT, values), name);
  }

private:
  void check(hid_t status, const char* what) const
  {
    if (status < 0)
    {
      throw FileError(std::string("Cannot write ") + what + " to '" + this->File.target() + "'", errno);
    }
  }

  void attribute(const char* name, hid_t type, const void* value)
  {
    const hsize_t one = 1;
    const Handle space(H5Screate_simple(1, &one, nullptr), &H5Sclose);
    const Handle attribute(H5Acreate2(this->Id, name, type, space, H5P_DEFAULT, H5P_DEFAULT), &H5Aclose);
    this->check(H5Awrite(attribute, type, value), name);
  }

  AtomicFile& File;
  hid_t Id = -1;
  H5E_auto2_t Report = nullptr;
  void* ReportData = nullptr;
};

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
  HOPRWriter(const CurvedCells& cells, HDF5File& file)
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
    this->File.attribute("Version", 1.0);
    this->File.attribute("Ngeo", this->Cells.order());
    this->File.attribute("nElems", static_cast<int>(count));
    this->File.attribute("nSides", static_cast<int>(6 * count));
    this->File.attribute("nNodes", static_cast<int>(this->NodesPerCell * count));
    this->File.attribute("nUniqueSides", static_cast<int>(this->UniqueSides));
    this->File.attribute("nUniqueNodes", static_cast<int>(this->Cells.numbers().count()));
    this->File.attribute("nBCs", conditions);

    this->File.create("ElemInfo", H5T_STD_I32LE, count, 6);
    this->File.create("SideInfo", H5T_STD_I32LE, 6 * count, 5);
    this->File.create("NodeCoords", H5T_IEEE_F64LE, this->NodesPerCell * count, 3);
    this->File.create("GlobalNodeIDs", H5T_STD_I32LE, this->NodesPerCell * count, 0);
    this->File.create("ElemBarycenters", H5T_IEEE_F64LE, count, 3);
    this->File.create("ElemWeight", H5T_IEEE_F64LE, count, 0);

    const Handle text(H5Tcopy(H5T_C_S1), &H5Tclose);
    H5Tset_size(text, NameLength);
    H5Tset_strpad(text, H5T_STR_SPACEPAD);
    std::vector<char> labels(NameLength * conditions, ' ');
    std::vector<int> types(4 * static_cast<std::size_t>(conditions), 0);
    for (int n = 0; n < conditions; ++n)
    {
      const std::string name = n < names ? this->Volume.boundaryNames[n] : "unnamed";
      std::memcpy(labels.data() + NameLength * n, name.data(), std::min(name.size(), NameLength));
      types[4 * n] = n < names ? boundaryType(this->Volume.boundaryTypes[n]) : 1;
    }
    this->File.create("BCNames", text, conditions, 0);
    this->File.rows("BCNames", text, 0, conditions, 0, labels.data());
    this->File.create("BCType", H5T_STD_I32LE, conditions, 4);
    this->File.rows("BCType", H5T_NATIVE_INT, 0, conditions, 4, types.data());
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
      this->File.rows("ElemInfo", H5T_NATIVE_INT, first, count, 6, elements.data());
      this->File.rows("SideInfo", H5T_NATIVE_INT, 6 * first, 6 * count, 5, sides.data());
      this->File.rows(
        "GlobalNodeIDs", H5T_NATIVE_INT, this->NodesPerCell * first, this->NodesPerCell * count, 0, numbers.data());
      this->File.rows("ElemWeight", H5T_NATIVE_DOUBLE, first, count, 0, weights.data());
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
      this->File.rows(
        "NodeCoords", H5T_NATIVE_DOUBLE, this->NodesPerCell * first, this->NodesPerCell * count, 3, points.data());
      this->File.rows("ElemBarycenters", H5T_NATIVE_DOUBLE, first, count, 3, centres.data());
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
  HDF5File& File;
  const int NodesPerCell;
  /// Boundary condition, from 1, of every block face on the boundary.
  std::vector<int> BoundaryOf;
  Index UniqueSides = 0;
  std::vector<int> Numbers;
};

} // namespace

void writeHOPR(const CurvedCells& cells, AtomicFile& file, const Execution& run)
{
  const Ranks& ranks = *run.ranks;
  std::unique_ptr<HDF5File> output;
  std::unique_ptr<HOPRWriter> writer;
  if (ranks.rank() == 0)
  {
    const double perCell = std::pow(cells.order() + 1.0, 3);
    // The arrays, and no less than HDF5 takes beside them: it cannot let go of what it may not write (RLIMIT_FSIZE).
    output = std::make_unique<HDF5File>(file,
      (28.0 * perCell + 176.0) * static_cast<double>(cells.cellCount()) +
        300.0 * static_cast<double>(cells.volume().boundaryNames.size()) + 65536.0);
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
  }
}

} // namespace bsv
