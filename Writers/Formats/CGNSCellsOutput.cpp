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
  CellWriter(const CurvedCells& cells, CGNSFile& file)
    : Cells(cells)
    , Volume(cells.volume())
    , File(file)
    , Families(familyNames(cells.volume().boundaryNames))
  {
  }

  void begin(double lengthUnit, std::vector<std::string>& notes)
  {
    writeHeader(this->File, lengthUnit, this->Families, this->Volume.boundaryNames, this->Volume.boundaryTypes, notes);
    this->File.call<&CGNSLibrary::zone>("volume",
      std::vector<cgsize_t>{
        static_cast<cgsize_t>(this->Cells.numbers().count()), static_cast<cgsize_t>(this->Cells.cellCount()), 0 });
  }

  /// The nodes that are met first in a block. @param pause called in between
  template <typename Pause>
  void nodes(int block, const std::vector<double>& positions, const Pause& pause)
  {
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
      this->File.call<&CGNSLibrary::coordinates<double>>(
        1, c, std::vector<cgsize_t>{ first }, std::vector<cgsize_t>{ last }, values);
    }
  }

  void cells(const Execution& run)
  {
    const int order = this->Cells.order();
    const NodeList nodes = cellNodes(NodeOrder::CGNS, order);
    const cgsize_t total = static_cast<cgsize_t>(this->Cells.cellCount());
    this->File.call<&CGNSLibrary::section>("cells", int(order == 2 ? CGNS_ENUMV(HEXA_27) : CGNS_ENUMV(HEXA_64)), total);
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
        this->File.call<&CGNSLibrary::elements>(first, first + static_cast<cgsize_t>(spans[0]) * spans[1] - 1, numbers);
      }
    }
  }

  void boundaries()
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
      this->File.call<&CGNSLibrary::sides>(name == "cells" ? "cells_" : name,
        int(order == 2 ? CGNS_ENUMV(QUAD_9) : CGNS_ENUMV(QUAD_16)), first, first + quads - 1, numbers);
      if (tag < names)
      {
        this->File.call<&CGNSLibrary::boundary>(1, name, name, std::vector<cgsize_t>{ first, first + quads - 1 }, true);
      }
      first += quads;
    }
  }

private:
  const CurvedCells& Cells;
  const VolumeToWrite& Volume;
  CGNSFile& File;
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
    const double bytes = 24.0 * static_cast<double>(cells.numbers().count()) + sizeof(cgsize_t) * numbers;
    file.requireRoom(bytes);
    output = std::make_unique<CGNSFile>(file, writingSeconds(bytes), run, notes);
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
      values.reserve(3 * static_cast<std::size_t>(numbers.firstOf(b + 1) - numbers.firstOf(b)));
      constexpr std::size_t Often = 3 << 16;
      numbers.forFirst(b, [&](const Ijk& p) {
        if (values.size() % Often == 0)
        {
          run.report(done);
        }
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
    file.takeOver();
  }
}

} // namespace bsv
