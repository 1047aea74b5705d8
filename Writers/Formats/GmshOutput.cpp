// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/CellFormats.h"

#include "IO/TextOutput.h"
#include "Ranks/OwnedValues.h"

#include <algorithm>
#include <limits>

namespace bsv
{

namespace
{

constexpr int HexType[4] = { 0, 5, 12, 92 };
constexpr int QuadType[4] = { 0, 3, 10, 36 };
/// Physical tags of boundaries count from 1; the volume's dimension tells it apart.
constexpr int VolumeTag = 1;

/// x min, y min, z min, x max, .. of the control points of a box of them, which contain what they control.
using Box = std::array<double, 6>;

Box boxOf(const BSplineVolume& volume, const Ijk& first, const Ijk& last)
{
  Box box;
  for (int c = 0; c < 3; ++c)
  {
    box[c] = std::numeric_limits<double>::infinity();
    box[3 + c] = -box[c];
  }
  for (int k = first[2]; k <= last[2]; ++k)
  {
    for (int j = first[1]; j <= last[1]; ++j)
    {
      for (int i = first[0]; i <= last[0]; ++i)
      {
        const double* x = volume.points + 3 * (i + Index(volume.count(0)) * (j + Index(volume.count(1)) * k));
        for (int c = 0; c < 3; ++c)
        {
          box[c] = std::min(box[c], x[c]);
          box[3 + c] = std::max(box[3 + c], x[c]);
        }
      }
    }
  }
  return box;
}

std::string quoted(std::string text)
{
  std::replace_if(
    text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < ' ' || c == '"'; }, '_');
  return "\"" + text + "\"";
}

class GmshWriter
{
public:
  GmshWriter(const CurvedCells& cells, AtomicFile& file, GmshVersion version, const Execution& run)
    : Cells(cells)
    , Volume(cells.volume())
    , File(file)
    , V4(version == GmshVersion::V4)
    , Run(run)
    , CellNodes(cellNodes(NodeOrder::Gmsh, cells.order()))
  {
    for (int side = 0; side < 6; ++side)
    {
      this->SideNodes[side] = sideNodes(side, cells.order());
    }
    this->Quads = 0;
    for (const BoundaryPatch& patch : this->Volume.boundaries)
    {
      this->FirstQuad.push_back(this->Quads);
      this->Quads += cells.quadCount(patch);
    }
  }

  void write()
  {
    this->onFirst([&](TextOutput& out) {
      out << "$MeshFormat\n" << (this->V4 ? "4.1" : "2.2") << " 0 8\n$EndMeshFormat\n";
      const int names = static_cast<int>(this->Volume.boundaryNames.size());
      const bool unnamed = std::any_of(this->Volume.boundaries.begin(), this->Volume.boundaries.end(),
        [](const BoundaryPatch& patch) { return patch.tag < 0; });
      out << "$PhysicalNames\n" << names + 1 + (unnamed ? 1 : 0) << "\n";
      for (int n = 0; n < names; ++n)
      {
        out << "2 " << n + 1 << " " << quoted(this->Volume.boundaryNames[n]) << "\n";
      }
      if (unnamed)
      {
        out << "2 " << names + 1 << " \"unnamed\"\n";
      }
      out << "3 " << VolumeTag << " \"volume\"\n$EndPhysicalNames\n";
    });
    if (this->V4)
    {
      this->entities();
    }
    this->nodes();
    this->elements();
  }

private:
  template <typename Write>
  void onFirst(const Write& write)
  {
    if (this->Run.ranks->rank() == 0)
    {
      TextOutput out(this->File);
      write(out);
    }
  }

  int physical(const BoundaryPatch& patch) const
  {
    return (patch.tag >= 0 ? patch.tag : static_cast<int>(this->Volume.boundaryNames.size())) + 1;
  }

  void entities()
  {
    const auto owner = [&](int block) { return this->Volume.volumes[block].rank; };
    const std::vector<Box> volumes = gatherFromOwners<Box>(
      *this->Run.ranks, this->Volume.volumes.size(), [&](std::size_t b) { return owner(static_cast<int>(b)); },
      [&](std::size_t b) {
        const BSplineVolume& volume = this->Volume.volumes[b];
        return boxOf(volume, { 0, 0, 0 }, { volume.count(0) - 1, volume.count(1) - 1, volume.count(2) - 1 });
      });
    const std::vector<Box> surfaces = gatherFromOwners<Box>(
      *this->Run.ranks, this->Volume.boundaries.size(),
      [&](std::size_t n) { return owner(this->Volume.boundaries[n].block); },
      [&](std::size_t n) {
        const BoundaryPatch& patch = this->Volume.boundaries[n];
        const BSplineVolume& volume = this->Volume.volumes[patch.block];
        const int d = faceDirection(patch.face);
        Ijk first{ 0, 0, 0 };
        Ijk last{ volume.count(0) - 1, volume.count(1) - 1, volume.count(2) - 1 };
        (faceSide(patch.face) ? first : last)[d] = (faceSide(patch.face) ? last : first)[d];
        return boxOf(volume, first, last);
      });
    this->onFirst([&](TextOutput& out) {
      out << "$Entities\n0 0 " << static_cast<int>(surfaces.size()) << " " << static_cast<int>(volumes.size()) << "\n";
      const auto entity = [&](std::size_t tag, const Box& box, int physical, const std::vector<int>& bounding) {
        out << static_cast<int>(tag);
        for (const double x : box)
        {
          out << " " << x;
        }
        out << " 1 " << physical << " " << static_cast<int>(bounding.size());
        for (const int surface : bounding)
        {
          out << " " << surface;
        }
        out << "\n";
      };
      for (std::size_t n = 0; n < surfaces.size(); ++n)
      {
        entity(n + 1, surfaces[n], this->physical(this->Volume.boundaries[n]), {});
      }
      for (std::size_t b = 0; b < volumes.size(); ++b)
      {
        std::vector<int> bounding;
        for (std::size_t n = 0; n < surfaces.size(); ++n)
        {
          if (this->Volume.boundaries[n].block == static_cast<int>(b))
          {
            bounding.push_back(static_cast<int>(n) + 1);
          }
        }
        entity(b + 1, volumes[b], VolumeTag, bounding);
      }
      out << "$EndEntities\n";
    });
  }

  void nodes()
  {
    const PointNumbering& numbers = this->Cells.numbers();
    this->onFirst([&](TextOutput& out) {
      out << "$Nodes\n";
      if (this->V4)
      {
        out << this->Cells.blockCount() << " " << numbers.count() << " 1 ";
      }
      out << numbers.count() << "\n";
    });
    std::vector<FilePart> parts;
    for (int b = 0; b < this->Cells.blockCount(); ++b)
    {
      parts.push_back({ this->Volume.volumes[b].rank, static_cast<double>(this->Cells.cellCount(b)),
        [this, b](OutputBuffer& out, const PartReport& report) { this->blockNodes(out, b, report); } });
    }
    writeParts(this->File, parts, this->Run);
    this->onFirst([&](TextOutput& out) { out << "$EndNodes\n"; });
  }

  void blockNodes(OutputBuffer& file, int b, const PartReport& report) const
  {
    const PointNumbering& numbers = this->Cells.numbers();
    const Ijk counts = this->Cells.nodes(b);
    Execution quiet = this->Run;
    quiet.progress = [&](double) {
      report(0.0);
      return true;
    };
    const std::vector<double> points = this->Cells.positions(b, quiet);
    TextOutput out(file);
    Index number = numbers.firstOf(b) + 1;
    if (this->V4)
    {
      out << "3 " << b + 1 << " 0 " << numbers.firstOf(b + 1) - numbers.firstOf(b) << "\n";
      for (Index n = number; n <= numbers.firstOf(b + 1); ++n)
      {
        out << n << "\n";
      }
    }
    numbers.forFirst(b, [&](const Ijk& p) {
      if (!this->V4)
      {
        out << number++ << " ";
      }
      out.point(points.data() + 3 * (p[0] + Index(counts[0]) * (p[1] + Index(counts[1]) * p[2])));
    });
    report(static_cast<double>(this->Cells.cellCount(b)));
  }

  void elements()
  {
    const Index total = this->Quads + this->Cells.cellCount();
    this->onFirst([&](TextOutput& out) {
      out << "$Elements\n";
      if (this->V4)
      {
        out << static_cast<int>(this->Volume.boundaries.size()) + this->Cells.blockCount() << " " << total << " 1 ";
      }
      out << total << "\n";
    });
    std::vector<FilePart> parts;
    for (std::size_t n = 0; n < this->Volume.boundaries.size(); ++n)
    {
      const BoundaryPatch& patch = this->Volume.boundaries[n];
      parts.push_back({ this->Volume.volumes[patch.block].rank, static_cast<double>(this->Cells.quadCount(patch)),
        [this, n](OutputBuffer& out, const PartReport&) { this->patchElements(out, n); } });
    }
    for (int b = 0; b < this->Cells.blockCount(); ++b)
    {
      parts.push_back({ this->Volume.volumes[b].rank, static_cast<double>(this->Cells.cellCount(b)),
        [this, b](OutputBuffer& out, const PartReport& report) { this->blockElements(out, b, report); } });
    }
    writeParts(this->File, parts, this->Run);
    this->onFirst([&](TextOutput& out) { out << "$EndElements\n"; });
  }

  void begin(TextOutput& out, Index element, int type, int physical, int entity) const
  {
    out << element;
    if (!this->V4)
    {
      out << " " << type << " 2 " << physical << " " << entity;
    }
  }

  void patchElements(OutputBuffer& file, std::size_t n) const
  {
    const BoundaryPatch& patch = this->Volume.boundaries[n];
    TextOutput out(file);
    const int entity = static_cast<int>(n) + 1;
    const int type = QuadType[this->Cells.order()];
    if (this->V4)
    {
      out << "2 " << entity << " " << type << " " << this->Cells.quadCount(patch) << "\n";
    }
    Index element = this->FirstQuad[n] + 1;
    this->Cells.forQuads(patch, [&](const Ijk& cell) {
      this->begin(out, element++, type, this->physical(patch), entity);
      this->nodeNumbers(out, patch.block, cell, this->SideNodes[this->Cells.sideOf(patch.block, patch.face)]);
    });
  }

  void blockElements(OutputBuffer& file, int b, const PartReport& report) const
  {
    TextOutput out(file);
    const Ijk& spans = this->Cells.spans(b);
    const int type = HexType[this->Cells.order()];
    if (this->V4)
    {
      out << "3 " << b + 1 << " " << type << " " << this->Cells.cellCount(b) << "\n";
    }
    Index element = this->Quads + this->Cells.firstCell(b) + 1;
    for (int k = 0; k < spans[2]; ++k)
    {
      report(static_cast<double>(Index(spans[0]) * spans[1] * k));
      for (int j = 0; j < spans[1]; ++j)
      {
        for (int i = 0; i < spans[0]; ++i)
        {
          this->begin(out, element++, type, VolumeTag, b + 1);
          this->nodeNumbers(out, b, { i, j, k }, this->CellNodes);
        }
      }
    }
  }

  void nodeNumbers(TextOutput& out, int block, const Ijk& cell, const NodeList& nodes) const
  {
    for (const Ijk& local : nodes)
    {
      out << " " << this->Cells.numbers()(block, this->Cells.node(block, cell, local)) + 1;
    }
    out << "\n";
  }

  const CurvedCells& Cells;
  const VolumeToWrite& Volume;
  AtomicFile& File;
  const bool V4;
  const Execution& Run;
  const NodeList CellNodes;
  std::array<NodeList, 6> SideNodes;
  /// Elements before those of every boundary patch, and of all.
  std::vector<Index> FirstQuad;
  Index Quads = 0;
};

} // namespace

void writeGmsh(const CurvedCells& cells, AtomicFile& file, GmshVersion version, const Execution& run)
{
  GmshWriter(cells, file, version, run).write();
}

} // namespace bsv
