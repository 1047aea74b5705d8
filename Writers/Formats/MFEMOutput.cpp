// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/VolumeFormats.h"

#include "IO/TextOutput.h"
#include "Mesh/SharedEntities.h"
#include "Ranks/Ranks.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace bsv
{

namespace
{

/// MFEM's vertices of a cube as our corners (BlockTopology.h).
constexpr int CubeCorners[8] = { 0, 1, 3, 2, 4, 5, 7, 6 };
/// More cuts than this are a mesh that cutting does not help.
constexpr int MostCuts = 100;

SharedEntities entitiesOf(const VolumeToWrite& volume)
{
  return sharedEntities(
    static_cast<int>(volume.volumes.size()), volume.interfaces, [&](int block) { return volume.label(block); });
}

/// A block and a direction in which a cut would tell apart what has the same vertices; block -1: all differ.
std::array<int, 2> ambiguous(const SharedEntities& shared)
{
  for (std::size_t b = 0; b < shared.blocks.size(); ++b)
  {
    const std::array<int, 8>& vertices = shared.blocks[b].vertices;
    for (int v = 0; v < 8; ++v)
    {
      for (int w = v + 1; w < 8; ++w)
      {
        if (vertices[v] == vertices[w])
        {
          const int differ = v ^ w;
          return { static_cast<int>(b), (differ & 1) ? 0 : (differ & 2) ? 1 : 2 };
        }
      }
    }
  }
  std::map<std::array<int, 2>, std::size_t> edges;
  for (std::size_t e = 0; e < shared.edges.size(); ++e)
  {
    std::array<int, 2> ends = shared.edges[e].vertices;
    std::sort(ends.begin(), ends.end());
    if (!edges.emplace(ends, e).second)
    {
      return { shared.edges[e].block, edgeDirection(shared.edges[e].edge) };
    }
  }
  std::map<std::array<int, 4>, std::size_t> faces;
  for (std::size_t f = 0; f < shared.faces.size(); ++f)
  {
    const auto& [uses, block, face] = shared.faces[f];
    std::array<int, 4> corners{};
    for (int c = 0; c < 4; ++c)
    {
      corners[c] = shared.blocks[block].vertices[faceCorner(face, c & 1, c >> 1)];
    }
    std::sort(corners.begin(), corners.end());
    if (!faces.emplace(corners, f).second)
    {
      return { block, faceAxis(face, 0) };
    }
  }
  return { -1, -1 };
}

/// Which knot vector each block has in each direction, and whether it runs against it.
class KnotClasses
{
public:
  KnotClasses(const VolumeToWrite& volume)
    : Volume(volume)
    , Parent(3 * volume.volumes.size())
    , Against(3 * volume.volumes.size(), 0)
  {
    for (std::size_t i = 0; i < this->Parent.size(); ++i)
    {
      this->Parent[i] = static_cast<int>(i);
      // A left-handed block is written with u reversed.
      this->Against[i] = 0;
    }
    for (const Interface& contact : volume.interfaces)
    {
      for (int axis = 0; axis < 2; ++axis)
      {
        const int axisB = swapsAxes(contact.orientation) ? 1 - axis : axis;
        const bool turned = (contact.orientation & (axisB == 0 ? 2 : 4)) != 0;
        this->unite(3 * contact.blockA + faceAxis(contact.faceA, axis),
          3 * contact.blockB + faceAxis(contact.faceB, axisB), turned);
      }
    }
    for (std::size_t i = 0; i < this->Parent.size(); ++i)
    {
      const int root = this->find(static_cast<int>(i)).first;
      if (root == static_cast<int>(i))
      {
        this->Number[root] = static_cast<int>(this->Number.size());
      }
    }
  }

  int number(int block, int direction) { return this->Number.at(this->find(3 * block + direction).first); }
  bool against(int block, int direction) { return this->find(3 * block + direction).second; }

private:
  std::pair<int, bool> find(int item)
  {
    bool against = false;
    while (this->Parent[item] != item)
    {
      against = against != (this->Against[item] != 0);
      item = this->Parent[item];
    }
    return { item, against };
  }

  void unite(int a, int b, bool turned)
  {
    this->checkKnots(a, b, turned);
    const auto [rootA, againstA] = this->find(a);
    const auto [rootB, againstB] = this->find(b);
    const bool between = againstA != (againstB != turned);
    if (rootA == rootB)
    {
      if (between)
      {
        throw Error(this->Volume.label(a / 3) + " meets itself turned round along " + "uvw"[a % 3] +
          " through its neighbours, and MFEM's knot vectors have one sense each");
      }
      return;
    }
    this->Parent[std::max(rootA, rootB)] = std::min(rootA, rootB);
    this->Against[std::max(rootA, rootB)] = between ? 1 : 0;
  }

  /// MFEM takes the knots of one patch for all: they must be equal, but for their range.
  void checkKnots(int a, int b, bool turned) const
  {
    const BSplineVolume& one = this->Volume.volumes[a / 3];
    const BSplineVolume& other = this->Volume.volumes[b / 3];
    const std::vector<double>& s = one.knots[a % 3];
    const std::vector<double>& t = other.knots[b % 3];
    bool equal = one.degree[a % 3] == other.degree[b % 3] && s.size() == t.size();
    for (std::size_t i = 0; equal && i < s.size(); ++i)
    {
      const double u = (s[i] - s.front()) / (s.back() - s.front());
      const double v = turned ? (t.back() - t[t.size() - 1 - i]) / (t.back() - t.front())
                              : (t[i] - t.front()) / (t.back() - t.front());
      equal = std::abs(u - v) <= 1e-12;
    }
    if (!equal)
    {
      throw Error(this->Volume.label(a / 3) + " and " + this->Volume.label(b / 3) +
        " share a face, but have different degrees or knots there, which an MFEM mesh cannot hold");
    }
  }

  const VolumeToWrite& Volume;
  std::vector<int> Parent;
  std::vector<char> Against;
  std::map<int, int> Number;
};

std::string oneLine(std::string text)
{
  std::replace_if(
    text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < ' '; }, ' ');
  return text;
}

void writePatch(
  TextOutput out, OutputBuffer& file, const BSplineVolume& volume, bool reversed, const PartReport& report)
{
  out << "\nknotvectors\n3\n";
  for (int d = 0; d < 3; ++d)
  {
    const std::vector<double>& knots = volume.knots[d];
    out << volume.degree[d] << " " << volume.count(d);
    for (std::size_t i = 0; i < knots.size(); ++i)
    {
      out << " " << (reversed && d == 0 ? knots.front() + (knots.back() - knots[knots.size() - 1 - i]) : knots[i]);
    }
    out << "\n";
  }
  out << "dimension\n3\ncontrolpoints_cartesian\n";
  const int n = volume.count(0);
  const Index rows = Index(volume.count(1)) * volume.count(2);
  for (Index row = 0; row < rows; ++row)
  {
    if (row % 256 == 0)
    {
      report(static_cast<double>(row * n));
    }
    for (int i = 0; i < n; ++i)
    {
      const Index at = row * n + (reversed ? n - 1 - i : i);
      char* to = file.room(130);
      for (int c = 0; c < 4; ++c)
      {
        const double value = c < 3 ? volume.points[3 * at + c] : (volume.weights ? volume.weights[at] : 1.0);
        to = std::to_chars(to, to + 30, value).ptr;
        *to++ = c < 3 ? ' ' : '\n';
      }
      file.advance(to);
    }
  }
}

} // namespace

void writeMFEM(VolumeToWrite volume, AtomicFile& file, const Execution& run, std::vector<std::string>& notes)
{
  SharedEntities shared = entitiesOf(volume);
  int cuts = 0;
  for (std::array<int, 2> at = ambiguous(shared); at[0] >= 0; at = ambiguous(shared))
  {
    if (++cuts > MostCuts)
    {
      throw Error(volume.label(at[0]) + " meets itself or a neighbour more than once, also after " +
        std::to_string(MostCuts) + " cuts, and MFEM knows faces by their vertices alone");
    }
    cutSheet(volume, at[0], at[1]);
    shared = entitiesOf(volume);
  }
  if (cuts > 0 && run.ranks->rank() == 0)
  {
    notes.push_back("blocks that meet themselves, or a neighbour more than once, were cut " + std::to_string(cuts) +
      (cuts == 1 ? " time" : " times") +
      ", since MFEM knows faces by their vertices alone: " + std::to_string(volume.volumes.size()) + " patches for " +
      std::to_string(1 + *std::max_element(volume.parents.begin(), volume.parents.end())) + " blocks");
  }
  KnotClasses classes(volume);

  if (run.ranks->rank() == 0)
  {
    TextOutput out(file);
    out << "MFEM NURBS mesh v1.0\n#\n";
    int before = -1;
    for (std::size_t b = 0; b < volume.names.size(); ++b)
    {
      if (volume.parents[b] > before)
      {
        before = volume.parents[b];
        out << "# element attribute " << before + 1 << ": " << oneLine(volume.names[b]) << "\n";
      }
    }
    const int names = static_cast<int>(volume.boundaryNames.size());
    for (int n = 0; n < names; ++n)
    {
      out << "# boundary attribute " << n + 1 << ": " << oneLine(volume.boundaryNames[n]) << "\n";
    }
    out << "#\n\ndimension\n3\n\nelements\n" << static_cast<int>(volume.volumes.size()) << "\n";
    for (std::size_t b = 0; b < volume.volumes.size(); ++b)
    {
      out << volume.parents[b] + 1 << " 5";
      for (const int corner : CubeCorners)
      {
        out << " " << shared.blocks[b].vertices[volume.leftHanded[b] ? corner ^ 1 : corner];
      }
      out << "\n";
    }
    out << "\nboundary\n" << static_cast<int>(volume.boundaries.size()) << "\n";
    for (const BoundaryPatch& patch : volume.boundaries)
    {
      out << (patch.tag >= 0 ? patch.tag : names) + 1 << " 3";
      for (int c = 0; c < 4; ++c)
      {
        out << " " << shared.blocks[patch.block].vertices[faceCorner(patch.face, c == 1 || c == 2, c >> 1)];
      }
      out << "\n";
    }
    out << "\nedges\n" << static_cast<int>(shared.edges.size()) << "\n";
    for (const SharedEntities::Edge& edge : shared.edges)
    {
      const int d = edgeDirection(edge.edge);
      const bool against = classes.against(edge.block, d);
      out << classes.number(edge.block, d) << " " << edge.vertices[against ? 1 : 0] << " "
          << edge.vertices[against ? 0 : 1] << "\n";
    }
    out << "\nvertices\n" << shared.vertices << "\n\npatches\n";
  }
  std::vector<FilePart> parts;
  for (std::size_t b = 0; b < volume.volumes.size(); ++b)
  {
    const BSplineVolume& block = volume.volumes[b];
    const bool reversed = volume.leftHanded[b] != 0;
    parts.push_back({ block.rank, double(block.count(0)) * block.count(1) * block.count(2),
      [&block, reversed](
        OutputBuffer& out, const PartReport& report) { writePatch(TextOutput(out), out, block, reversed, report); } });
  }
  writeParts(file, parts, run);
}

} // namespace bsv
