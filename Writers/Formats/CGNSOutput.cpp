// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/CGNSOutput.h"

#include "Formats/CGNSFile.h"
#include "Ranks/Ranks.h"

#include <algorithm>
#include <memory>
#include <set>

namespace bsv
{

namespace
{

/// Names of the zones, in the order of the blocks.
std::vector<std::string> zoneNames(const MeshToWrite& mesh)
{
  std::vector<std::string> names;
  bool kept = true;
  for (const BlockToWrite& block : mesh.blocks)
  {
    const std::string& name = block.name;
    kept = kept && !name.empty() && name.size() <= 32 && name.find('/') == std::string::npos && name != "." &&
      name != ".." && name.front() != ' ' && name.back() != ' ' && (names.empty() || names.back() < name) &&
      std::all_of(name.begin(), name.end(), [](char c) { return static_cast<unsigned char>(c) >= ' '; });
    names.push_back(name);
  }
  if (kept)
  {
    return names;
  }
  const std::size_t digits = std::max<std::size_t>(3, std::to_string(names.size()).size());
  for (std::size_t b = 0; b < names.size(); ++b)
  {
    const std::string number = std::to_string(b + 1);
    const std::string plain = allowedNames({ names[b] }, "-.", 32).front();
    names[b] = (std::string(digits - number.size(), '0') + number + "_" + plain).substr(0, 32);
  }
  return names;
}

/// Begin and end of a rectangle of points on a face, as CGNS wants it: from 1.
std::array<cgsize_t, 6> pointRange(
  const BlockToWrite& block, int face, const std::array<int, 2>& begin, const std::array<int, 2>& end)
{
  std::array<cgsize_t, 6> range{};
  const int d = faceDirection(face);
  range[d] = range[3 + d] = faceSide(face) ? block.counts[d] : 1;
  for (int axis = 0; axis < 2; ++axis)
  {
    range[faceAxis(face, axis)] = begin[axis] + 1;
    range[3 + faceAxis(face, axis)] = end[axis] + 1;
  }
  return range;
}

/// All but the coordinates.
class StructureWriter
{
public:
  StructureWriter(const MeshToWrite& mesh, const CGNSFile& file, std::vector<std::string>& notes)
    : Mesh(mesh)
    , File(file)
    , Zones(zoneNames(mesh))
    , Families(familyNames(mesh.boundaryNames))
    , Contacts(mesh.blocks.size(), 0)
    , Conditions(mesh.blocks.size(), 0)
  {
    for (std::size_t n = 0; n < this->Families.size(); ++n)
    {
      if (this->Families[n] != mesh.boundaryNames[n])
      {
        notes.push_back("boundary '" + mesh.boundaryNames[n] + "' is family '" + this->Families[n] + "' in the file");
      }
    }
  }

  void write(std::vector<std::string>& notes)
  {
    const int file = this->File.number();
    int base = 0;
    this->File.check(cg_base_write(file, "Base", 3, 3, &base), "the base");
    if (!writeUnits(this->File, base, this->Mesh.lengthUnit))
    {
      notes.push_back("CGNS has no name for the unit of length; the file declares none");
    }
    writeFamilies(this->File, base, this->Families, this->Mesh.boundaryTypes);
    for (std::size_t b = 0; b < this->Zones.size(); ++b)
    {
      const BlockToWrite& block = this->Mesh.blocks[b];
      std::array<cgsize_t, 9> size{};
      for (int d = 0; d < 3; ++d)
      {
        size[d] = block.counts[d];
        size[3 + d] = block.cells(d);
      }
      int zone = 0;
      this->File.check(cg_zone_write(file, base, this->Zones[b].c_str(), size.data(), CGNS_ENUMV(Structured), &zone),
        "zone '" + this->Zones[b] + "'");
      if (this->Zones[b] != block.name)
      {
        this->File.check(cg_goto(file, base, "Zone_t", zone, "end"), "a name");
        this->File.check(cg_descriptor_write("BlockName", block.name.c_str()), "a name");
      }
    }
    for (const Interface& contact : this->Mesh.interfaces)
    {
      this->writeSide(contact);
      Interface back = contact;
      std::swap(back.blockA, back.blockB);
      std::swap(back.faceA, back.faceB);
      back.orientation = inverseOrientation(contact.orientation);
      back.rangeA = contact.rangeB();
      back.originB = contact.rangeA.lo;
      this->writeSide(back);
    }
    for (const BoundaryPatch& patch : this->Mesh.boundaries)
    {
      if (patch.tag >= 0)
      {
        this->writeBoundary(patch);
      }
    }
  }

private:
  void writeSide(const Interface& c)
  {
    const int ns = c.rangeA.hi[0] - c.rangeA.lo[0];
    const int nt = c.rangeA.hi[1] - c.rangeA.lo[1];
    std::array<int, 2> begin = mapFacePoint(c.orientation, 0, 0, ns, nt);
    std::array<int, 2> end = mapFacePoint(c.orientation, ns, nt, ns, nt);
    for (int axis = 0; axis < 2; ++axis)
    {
      begin[axis] += c.originB[axis];
      end[axis] += c.originB[axis];
    }
    const auto range = pointRange(this->Mesh.blocks[c.blockA], c.faceA, c.rangeA.lo, c.rangeA.hi);
    const auto donor = pointRange(this->Mesh.blocks[c.blockB], c.faceB, begin, end);
    const std::array<int, 3> transform = cgnsTransform(c.faceA, c.faceB, c.orientation);
    const std::string name = "interface_" + std::to_string(++this->Contacts[c.blockA]);
    int index = 0;
    this->File.check(cg_1to1_write(this->File.number(), 1, c.blockA + 1, name.c_str(), this->Zones[c.blockB].c_str(),
                       range.data(), donor.data(), transform.data(), &index),
      "an interface of zone '" + this->Zones[c.blockA] + "'");
  }

  void writeBoundary(const BoundaryPatch& patch)
  {
    const std::string& family = this->Families[patch.tag];
    const auto range = pointRange(this->Mesh.blocks[patch.block], patch.face, patch.range.lo, patch.range.hi);
    const std::string number = "_" + std::to_string(++this->Conditions[patch.block]);
    const std::string name = family.substr(0, 32 - number.size()) + number;
    const std::string what = "boundary condition '" + name + "' of zone '" + this->Zones[patch.block] + "'";
    const int file = this->File.number();
    int index = 0;
    this->File.check(cg_boco_write(file, 1, patch.block + 1, name.c_str(), CGNS_ENUMV(FamilySpecified),
                       CGNS_ENUMV(PointRange), 2, range.data(), &index),
      what);
    this->File.check(cg_goto(file, 1, "Zone_t", patch.block + 1, "ZoneBC_t", 1, "BC_t", index, "end"), what);
    this->File.check(cg_famname_write(family.c_str()), what);
  }

  const MeshToWrite& Mesh;
  const CGNSFile& File;
  const std::vector<std::string> Zones;
  const std::vector<std::string> Families;
  std::vector<int> Contacts;
  std::vector<int> Conditions;
};

/// x, y, z of some layers of a block, each apart.
template <typename Real>
std::vector<Real> layers(const BlockToWrite& block, int first, int last)
{
  const std::size_t size = static_cast<std::size_t>(block.counts[0]) * block.counts[1] * (last - first);
  std::vector<Real> values(3 * size);
  std::size_t at = 0;
  for (int k = first; k < last; ++k)
  {
    for (int j = 0; j < block.counts[1]; ++j)
    {
      block.row(j, k, [&](const auto* x, Index stride) {
        for (int i = 0; i < block.counts[0]; ++i, ++at)
        {
          for (int c = 0; c < 3; ++c)
          {
            values[c * size + at] = static_cast<Real>(x[i * stride + c]);
          }
        }
      });
    }
  }
  return values;
}

template <typename Real>
void writeCoordinates(
  const MeshToWrite& mesh, std::size_t b, const CGNSFile* file, const Execution& run, double done, double total)
{
  static constexpr const char* Axes[3] = { "CoordinateX", "CoordinateY", "CoordinateZ" };
  const Ranks& ranks = *run.ranks;
  const BlockToWrite& block = mesh.blocks[b];
  const Index layer = Index(block.counts[0]) * block.counts[1];
  const int step = static_cast<int>(std::clamp<Index>((Index(1) << 19) / layer, 1, block.counts[2]));
  for (int k = 0; k < block.counts[2]; k += step)
  {
    const int end = std::min(k + step, block.counts[2]);
    std::vector<Real> values;
    run.report((done + static_cast<double>(layer * k)) / total);
    if (block.rank == ranks.rank())
    {
      values = layers<Real>(block, k, end);
    }
    if (block.rank != 0)
    {
      std::vector<std::vector<Real>> toRank(ranks.size());
      toRank[0] = std::move(values);
      values = std::move(ranks.exchange(std::move(toRank))[block.rank]);
    }
    if (ranks.rank() == 0)
    {
      const std::array<cgsize_t, 3> first{ 1, 1, k + 1 };
      const std::array<cgsize_t, 3> last{ block.counts[0], block.counts[1], end };
      for (int c = 0; c < 3; ++c)
      {
        int index = 0;
        file->check(cg_coord_partial_write(file->number(), 1, static_cast<int>(b) + 1,
                      sizeof(Real) == 4 ? CGNS_ENUMV(RealSingle) : CGNS_ENUMV(RealDouble), Axes[c], first.data(),
                      last.data(), values.data() + c * (values.size() / 3), &index),
          Axes[c]);
      }
    }
  }
}

} // namespace

void writeCGNS(const MeshToWrite& mesh, AtomicFile& file, const Execution& run, std::vector<std::string>& notes)
{
  const Ranks& ranks = *run.ranks;
  std::unique_ptr<CGNSFile> output;
  if (ranks.rank() == 0)
  {
    // Zones with coordinates, both sides of the interfaces, families and boundary conditions.
    const double nodes = 8.0 + 10.0 * static_cast<double>(mesh.blocks.size()) +
      8.0 * static_cast<double>(mesh.interfaces.size()) + 2.0 * static_cast<double>(mesh.boundaryNames.size()) +
      4.0 * static_cast<double>(mesh.boundaries.size());
    output =
      std::make_unique<CGNSFile>(file, static_cast<double>(mesh.pointCount()) * (mesh.isFloat() ? 12.0 : 24.0), nodes);
    StructureWriter(mesh, *output, notes).write(notes);
  }
  double done = 0.0;
  const double total = static_cast<double>(mesh.pointCount()) + 1.0;
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b)
  {
    mesh.blocks[b].points.isFloat() ? writeCoordinates<float>(mesh, b, output.get(), run, done, total)
                                    : writeCoordinates<double>(mesh, b, output.get(), run, done, total);
    done += static_cast<double>(mesh.blocks[b].size());
  }
  if (output)
  {
    output->close();
  }
}

} // namespace bsv
