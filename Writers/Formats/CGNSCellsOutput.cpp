// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/CellFormats.h"

#include "Formats/CGNSFile.h"
#include "Ranks/Ranks.h"

#include <algorithm>
#include <memory>

namespace bsv
{

namespace
{

/// Numbers, from 1, of nodes of cells, one cell after the other.
void appendNumbers(
  std::vector<cgsize_t>& numbers, const CurvedCells& cells, int block, const Ijk& cell, const NodeList& nodes)
{
  for (const Ijk& local : nodes)
  {
    numbers.push_back(static_cast<cgsize_t>(cells.numbers()(block, cells.node(block, cell, local)) + 1));
  }
}

class CellWriter
{
public:
  CellWriter(const CurvedCells& cells, const CGNSFile& file)
    : Cells(cells)
    , Volume(cells.volume())
    , File(file)
    , Families(familyNames(cells.volume().boundaryNames))
  {
  }

  void begin(double lengthUnit, std::vector<std::string>& notes) const
  {
    int index = 0;
    this->File.check(cg_base_write(this->File.number(), "Base", 3, 3, &index), "the base");
    if (!writeUnits(this->File, 1, lengthUnit))
    {
      notes.push_back("CGNS has no name for the unit of length; the file declares none");
    }
    writeFamilies(this->File, 1, this->Families, this->Volume.boundaryTypes);
    const cgsize_t size[3] = { static_cast<cgsize_t>(this->Cells.numbers().count()),
      static_cast<cgsize_t>(this->Cells.cellCount()), 0 };
    this->File.check(
      cg_zone_write(this->File.number(), 1, "volume", size, CGNS_ENUMV(Unstructured), &index), "the zone");
    for (std::size_t n = 0; n < this->Families.size(); ++n)
    {
      if (this->Families[n] != this->Volume.boundaryNames[n])
      {
        notes.push_back(
          "boundary '" + this->Volume.boundaryNames[n] + "' is family '" + this->Families[n] + "' in the file");
      }
    }
  }

  /// The nodes that are met first in a block. @param pause called in between
  template <typename Pause>
  void nodes(int block, const std::vector<double>& positions, const Pause& pause) const
  {
    static constexpr const char* Axes[3] = { "CoordinateX", "CoordinateY", "CoordinateZ" };
    const cgsize_t first = static_cast<cgsize_t>(this->Cells.numbers().firstOf(block)) + 1;
    const cgsize_t last = static_cast<cgsize_t>(this->Cells.numbers().firstOf(block + 1));
    std::vector<double> values(positions.size() / 3);
    for (int c = 0; c < 3 && last >= first; ++c)
    {
      pause();
      for (std::size_t n = 0; n < values.size(); ++n)
      {
        values[n] = positions[3 * n + c];
      }
      int index = 0;
      this->File.check(cg_coord_partial_write(this->File.number(), 1, 1, CGNS_ENUMV(RealDouble), Axes[c], &first, &last,
                         values.data(), &index),
        Axes[c]);
    }
  }

  void cells(const Execution& run) const
  {
    const int order = this->Cells.order();
    const NodeList nodes = cellNodes(NodeOrder::CGNS, order);
    const cgsize_t total = static_cast<cgsize_t>(this->Cells.cellCount());
    int section = 0;
    this->File.check(cg_section_partial_write(this->File.number(), 1, 1, "cells",
                       order == 2 ? CGNS_ENUMV(HEXA_27) : CGNS_ENUMV(HEXA_64), 1, total, 0, &section),
      "cells");
    for (int b = 0; b < this->Cells.blockCount(); ++b)
    {
      const Ijk& spans = this->Cells.spans(b);
      for (int k = 0; k < spans[2]; ++k)
      {
        run.report(
          0.8 + 0.2 * static_cast<double>(this->Cells.cellNumber(b, { 0, 0, k })) / static_cast<double>(total));
        std::vector<cgsize_t> numbers;
        for (int j = 0; j < spans[1]; ++j)
        {
          for (int i = 0; i < spans[0]; ++i)
          {
            appendNumbers(numbers, this->Cells, b, { i, j, k }, nodes);
          }
        }
        const cgsize_t first = static_cast<cgsize_t>(this->Cells.cellNumber(b, { 0, 0, k })) + 1;
        this->File.check(cg_elements_partial_write(this->File.number(), 1, 1, section, first,
                           first + static_cast<cgsize_t>(spans[0]) * spans[1] - 1, numbers.data()),
          "cells");
      }
    }
  }

  void boundaries() const
  {
    const int order = this->Cells.order();
    cgsize_t first = static_cast<cgsize_t>(this->Cells.cellCount()) + 1;
    const int names = static_cast<int>(this->Families.size());
    for (int tag = 0; tag <= names; ++tag)
    {
      std::vector<cgsize_t> numbers;
      cgsize_t quads = 0;
      for (const BoundaryPatch& patch : this->Volume.boundaries)
      {
        if (patch.tag != (tag < names ? tag : -1))
        {
          continue;
        }
        const NodeList nodes = sideNodes(this->Cells.sideOf(patch.block, patch.face), order);
        this->Cells.forQuads(
          patch, [&](const Ijk& cell) { appendNumbers(numbers, this->Cells, patch.block, cell, nodes); });
        quads += static_cast<cgsize_t>(this->Cells.quadCount(patch));
      }
      if (quads == 0)
      {
        continue;
      }
      const std::string name = tag < names ? this->Families[tag] : "without a name";
      int index = 0;
      this->File.check(
        cg_section_write(this->File.number(), 1, 1, name == "cells" ? "cells_" : name.c_str(),
          order == 2 ? CGNS_ENUMV(QUAD_9) : CGNS_ENUMV(QUAD_16), first, first + quads - 1, 0, numbers.data(), &index),
        "the sides of '" + name + "'");
      if (tag < names)
      {
        const cgsize_t range[2] = { first, first + quads - 1 };
        this->File.check(cg_boco_write(this->File.number(), 1, 1, name.c_str(), CGNS_ENUMV(FamilySpecified),
                           CGNS_ENUMV(PointRange), 2, range, &index),
          "boundary condition '" + name + "'");
        this->File.check(
          cg_boco_gridlocation_write(this->File.number(), 1, 1, index, CGNS_ENUMV(FaceCenter)), "a location");
        this->File.check(cg_goto(this->File.number(), 1, "Zone_t", 1, "ZoneBC_t", 1, "BC_t", index, "end"), "a family");
        this->File.check(cg_famname_write(name.c_str()), "a family");
      }
      first += quads;
    }
  }

private:
  const CurvedCells& Cells;
  const VolumeToWrite& Volume;
  const CGNSFile& File;
  const std::vector<std::string> Families;
};

} // namespace

void writeCGNSCells(
  const CurvedCells& cells, AtomicFile& file, double lengthUnit, const Execution& run, std::vector<std::string>& notes)
{
  const Ranks& ranks = *run.ranks;
  std::unique_ptr<CGNSFile> output;
  std::unique_ptr<CellWriter> writer;
  if (ranks.rank() == 0)
  {
    const double nodes = cells.order() == 2 ? 27.0 : 64.0;
    double numbers = nodes * static_cast<double>(cells.cellCount());
    for (const BoundaryPatch& patch : cells.volume().boundaries)
    {
      numbers += nodes * static_cast<double>(cells.quadCount(patch));
    }
    // A zone, its coordinates and cells; a family, sides and a boundary condition for every name.
    output =
      std::make_unique<CGNSFile>(file, 24.0 * static_cast<double>(cells.numbers().count()) + sizeof(cgsize_t) * numbers,
        24.0 + 12.0 * static_cast<double>(cells.volume().boundaryNames.size()));
    writer = std::make_unique<CellWriter>(cells, *output);
    writer->begin(lengthUnit, notes);
  }
  const PointNumbering& numbers = cells.numbers();
  for (int b = 0; b < cells.blockCount(); ++b)
  {
    const int owner = cells.volume().volumes[b].rank;
    const double done = 0.8 * static_cast<double>(cells.firstCell(b)) / (static_cast<double>(cells.cellCount()) + 1.0);
    std::vector<double> values;
    run.report(done);
    if (owner == ranks.rank())
    {
      Execution quiet = run;
      quiet.progress = [](double) { return true; };
      const std::vector<double> all = cells.positions(b, quiet);
      const Ijk counts = cells.nodes(b);
      numbers.forFirst(b, [&](const Ijk& p) {
        const double* x = all.data() + 3 * (p[0] + Index(counts[0]) * (p[1] + Index(counts[1]) * p[2]));
        values.insert(values.end(), x, x + 3);
      });
    }
    values = onFirstRank(ranks, owner, std::move(values));
    if (writer)
    {
      writer->nodes(b, values, [&] { run.report(done); });
    }
  }
  if (writer)
  {
    writer->cells(run);
    writer->boundaries();
    output->close();
  }
}

} // namespace bsv
