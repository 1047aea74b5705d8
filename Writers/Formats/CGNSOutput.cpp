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
  StructureWriter(const MeshToWrite& mesh, CGNSFile& file)
    : Mesh(mesh)
    , File(file)
    , Zones(zoneNames(mesh))
    , Families(familyNames(mesh.boundaryNames))
    , Contacts(mesh.blocks.size(), 0)
    , Conditions(mesh.blocks.size(), 0)
  {
  }

  void write(std::vector<std::string>& notes)
  {
    writeHeader(
      this->File, this->Mesh.lengthUnit, this->Families, this->Mesh.boundaryNames, this->Mesh.boundaryTypes, notes);
    for (std::size_t b = 0; b < this->Zones.size(); ++b)
    {
      const BlockToWrite& block = this->Mesh.blocks[b];
      std::vector<cgsize_t> size(9, 0);
      for (int d = 0; d < 3; ++d)
      {
        size[d] = block.counts[d];
        size[3 + d] = block.cells(d);
      }
      this->File.call<&CGNSLibrary::zone>(this->Zones[b], size);
      if (this->Zones[b] != block.name)
      {
        this->File.call<&CGNSLibrary::description>(static_cast<int>(b) + 1, "BlockName", block.name);
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
    this->File.call<&CGNSLibrary::interface>(c.blockA + 1, name, this->Zones[c.blockB], range, donor, transform);
  }

  void writeBoundary(const BoundaryPatch& patch)
  {
    const std::string& family = this->Families[patch.tag];
    const auto range = pointRange(this->Mesh.blocks[patch.block], patch.face, patch.range.lo, patch.range.hi);
    const std::string number = "_" + std::to_string(++this->Conditions[patch.block]);
    const std::string name = family.substr(0, 32 - number.size()) + number;
    this->File.call<&CGNSLibrary::boundary>(
      patch.block + 1, name, family, std::vector<cgsize_t>(range.begin(), range.end()), false);
  }

  const MeshToWrite& Mesh;
  CGNSFile& File;
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
  const MeshToWrite& mesh, std::size_t b, CGNSFile* file, const Execution& run, double done, double total)
{
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
      const std::vector<cgsize_t> first{ 1, 1, k + 1 };
      const std::vector<cgsize_t> last{ block.counts[0], block.counts[1], end };
      for (int c = 0; c < 3; ++c)
      {
        const auto begin = values.begin() + c * static_cast<std::ptrdiff_t>(values.size() / 3);
        file->call<&CGNSLibrary::coordinates<Real>>(static_cast<int>(b) + 1, c, first, last,
          std::vector<Real>(begin, begin + static_cast<std::ptrdiff_t>(values.size() / 3)));
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
    const double bytes = static_cast<double>(mesh.pointCount()) * (mesh.isFloat() ? 12.0 : 24.0);
    file.requireRoom(bytes);
    output = std::make_unique<CGNSFile>(file, writingSeconds(bytes), run, notes);
    StructureWriter(mesh, *output).write(notes);
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
    file.takeOver();
  }
}

} // namespace bsv
