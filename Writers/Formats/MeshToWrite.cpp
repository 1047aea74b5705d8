// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/MeshToWrite.h"

#include "Complex/BlockComplex.h"
#include "Data/BoundaryPatterns.h"
#include "Mesh/FlatFaces.h"
#include "Ranks/OwnedValues.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cctype>
#include <numeric>
#include <set>
#include <utility>

namespace bsv
{

namespace
{

std::string rangeText(const FaceRange& range)
{
  const auto axis = [&](int a) { return std::to_string(range.lo[a]) + ".." + std::to_string(range.hi[a]); };
  return axis(0) + " x " + axis(1);
}

FaceRange wholeFace(const Ijk& counts, int face)
{
  return { { 0, 0 }, { counts[faceAxis(face, 0)] - 1, counts[faceAxis(face, 1)] - 1 } };
}

Index quadCount(const FaceRange& range)
{
  return Index(range.hi[0] - range.lo[0]) * (range.hi[1] - range.lo[1]);
}

/// What covers a block face.
struct FaceCover
{
  std::vector<FaceRange> interfaces;
  /// Indices of boundary patches.
  std::vector<int> boundaries;
};

class MeshPreparation
{
public:
  MeshPreparation(const BlockMesh& mesh, MeshToWrite& result)
    : Mesh(mesh)
    , Result(result)
  {
  }

  void prepare(const Execution& run)
  {
    this->Result.interfaces = this->Mesh.interfaces;
    this->cover();
    if (this->uncovered())
    {
      this->findInterfaces(run);
      this->cover();
    }
    this->boundaries();
  }

private:
  const Ijk& counts(int block) const { return this->Mesh.blocks[block].points.counts(); }

  void checkRange(int block, int face, const FaceRange& range, const char* what) const
  {
    const FaceRange whole = wholeFace(this->counts(block), face);
    for (int a = 0; a < 2; ++a)
    {
      if (range.lo[a] < 0 || range.lo[a] >= range.hi[a] || range.hi[a] > whole.hi[a])
      {
        throw Error(this->Result.label(block) + ", face " + std::to_string(face) + ": the range " + rangeText(range) +
          " of " + what + " is not in the face's points " + rangeText(whole));
      }
    }
  }

  void cover()
  {
    this->Faces.assign(6 * this->Mesh.blocks.size(), {});
    for (const Interface& contact : this->Result.interfaces)
    {
      this->checkRange(contact.blockA, contact.faceA, contact.rangeA, "an interface");
      this->checkRange(contact.blockB, contact.faceB, contact.rangeB(), "an interface");
      this->Faces[6 * contact.blockA + contact.faceA].interfaces.push_back(contact.rangeA);
      this->Faces[6 * contact.blockB + contact.faceB].interfaces.push_back(contact.rangeB());
    }
    for (std::size_t b = 0; b < this->Mesh.boundaries.size(); ++b)
    {
      const BoundaryPatch& patch = this->Mesh.boundaries[b];
      this->checkRange(patch.block, patch.face, patch.range, "a boundary");
      this->Faces[6 * patch.block + patch.face].boundaries.push_back(static_cast<int>(b));
    }
  }

  /// Whether there are quadrilaterals in no interface and no boundary. Overlaps may hide some: they are found later.
  bool uncovered() const
  {
    for (std::size_t f = 0; f < this->Faces.size(); ++f)
    {
      Index covered = 0;
      for (const FaceRange& range : this->Faces[f].interfaces)
      {
        covered += quadCount(range);
      }
      for (const int b : this->Faces[f].boundaries)
      {
        covered += quadCount(this->Mesh.boundaries[b].range);
      }
      if (covered < quadCount(wholeFace(this->counts(static_cast<int>(f / 6)), static_cast<int>(f % 6))))
      {
        return true;
      }
    }
    return false;
  }

  /// The interfaces of the complex, which cuts blocks until they meet face to face, put together again.
  void findInterfaces(const Execution& run)
  {
    BlockComplexOptions options;
    options.allowDegenerate = true;
    const BlockComplex complex = buildBlockComplex(this->Mesh, options, run);
    std::vector<Interface> found;
    for (const ComplexFace& face : complex.faces)
    {
      if (face.uses.size() != 2 || this->isCut(complex, face.uses[0]))
      {
        continue;
      }
      const ComplexBlock& a = complex.blocks[face.uses[0].block];
      const ComplexBlock& b = complex.blocks[face.uses[1].block];
      Interface contact;
      contact.blockA = a.parent;
      contact.faceA = face.uses[0].face;
      contact.blockB = b.parent;
      contact.faceB = face.uses[1].face;
      contact.orientation = face.orientation;
      for (int axis = 0; axis < 2; ++axis)
      {
        const int da = faceAxis(contact.faceA, axis);
        contact.rangeA.lo[axis] = a.offset[da];
        contact.rangeA.hi[axis] = a.offset[da] + a.cells(da);
        contact.originB[axis] = b.offset[faceAxis(contact.faceB, axis)];
      }
      found.push_back(contact);
    }
    while (this->mergeTwo(found))
    {
    }
    this->Result.interfaces = found;
  }

  /// Whether a face of a piece lies inside the block that was cut.
  bool isCut(const BlockComplex& complex, const FaceUse& use) const
  {
    const ComplexBlock& piece = complex.blocks[use.block];
    const int d = faceDirection(use.face);
    const int plane = piece.offset[d] + (faceSide(use.face) ? piece.cells(d) : 0);
    return plane != 0 && plane != this->counts(piece.parent)[d] - 1;
  }

  /// Joins two contacts that are parts of one rectangle on both sides.
  static bool mergeTwo(std::vector<Interface>& contacts)
  {
    for (std::size_t m = 0; m < contacts.size(); ++m)
    {
      for (std::size_t n = m + 1; n < contacts.size(); ++n)
      {
        Interface& a = contacts[m];
        const Interface& b = contacts[n];
        if (a.blockA != b.blockA || a.faceA != b.faceA || a.blockB != b.blockB || a.faceB != b.faceB ||
          a.orientation != b.orientation)
        {
          continue;
        }
        for (int axis = 0; axis < 2; ++axis)
        {
          const int other = 1 - axis;
          if (a.rangeA.lo[other] != b.rangeA.lo[other] || a.rangeA.hi[other] != b.rangeA.hi[other] ||
            (a.rangeA.hi[axis] != b.rangeA.lo[axis] && b.rangeA.hi[axis] != a.rangeA.lo[axis]))
          {
            continue;
          }
          Interface both = a;
          both.rangeA.lo[axis] = std::min(a.rangeA.lo[axis], b.rangeA.lo[axis]);
          both.rangeA.hi[axis] = std::max(a.rangeA.hi[axis], b.rangeA.hi[axis]);
          for (int s = 0; s < 2; ++s)
          {
            both.originB[s] = std::min(a.originB[s], b.originB[s]);
          }
          const auto image = [](const Interface& c, int s, int t) {
            const std::array<int, 2> p = mapFacePoint(c.orientation, s - c.rangeA.lo[0], t - c.rangeA.lo[1],
              c.rangeA.hi[0] - c.rangeA.lo[0], c.rangeA.hi[1] - c.rangeA.lo[1]);
            return std::array<int, 2>{ p[0] + c.originB[0], p[1] + c.originB[1] };
          };
          const auto agrees = [&](const Interface& c) {
            return image(both, c.rangeA.lo[0], c.rangeA.lo[1]) == image(c, c.rangeA.lo[0], c.rangeA.lo[1]) &&
              image(both, c.rangeA.hi[0], c.rangeA.hi[1]) == image(c, c.rangeA.hi[0], c.rangeA.hi[1]);
          };
          if (agrees(a) && agrees(b))
          {
            a = both;
            contacts.erase(contacts.begin() + static_cast<std::ptrdiff_t>(n));
            return true;
          }
        }
      }
    }
    return false;
  }

  /// The declared boundaries without what is in interfaces or in an earlier one, then the rest of the faces.
  void boundaries()
  {
    std::vector<std::pair<std::size_t, BoundaryPatch>> patches;
    const std::size_t unnamed = this->Mesh.boundaries.size();
    Index cut = 0;
    for (std::size_t f = 0; f < this->Faces.size(); ++f)
    {
      const FaceCover& cover = this->Faces[f];
      const int block = static_cast<int>(f / 6);
      const int face = static_cast<int>(f % 6);
      const FaceRange whole = wholeFace(this->counts(block), face);
      if (cover.interfaces.size() == 1 && cover.boundaries.empty() && cover.interfaces[0] == whole)
      {
        continue;
      }
      if (cover.interfaces.empty() && cover.boundaries.size() == 1 &&
        this->Mesh.boundaries[cover.boundaries[0]].range == whole)
      {
        patches.emplace_back(cover.boundaries[0], this->Mesh.boundaries[cover.boundaries[0]]);
        continue;
      }
      cut += this->cutFace(block, face, whole, cover, patches);
    }
    std::stable_sort(patches.begin(), patches.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    Index rest = 0;
    for (auto& [order, patch] : patches)
    {
      if (order == unnamed)
      {
        patch.tag = -1;
        rest += quadCount(patch.range);
      }
      this->Result.boundaries.push_back(patch);
    }
    if (cut > 0)
    {
      this->Result.notes.push_back(std::to_string(cut) +
        " quadrilaterals are in a boundary and in an interface or another boundary: written as the interface, or as "
        "the first boundary");
    }
    if (rest > 0)
    {
      this->Result.notes.push_back(
        std::to_string(rest) + " quadrilaterals are in no interface and in no boundary with a name");
    }
  }

  /// @return quadrilaterals that were taken from a declared boundary
  Index cutFace(int block, int face, const FaceRange& whole, const FaceCover& cover,
    std::vector<std::pair<std::size_t, BoundaryPatch>>& patches) const
  {
    const int width = whole.hi[0];
    constexpr int Free = -1;
    constexpr int Taken = -2;
    std::vector<int> owner(static_cast<std::size_t>(quadCount(whole)), Free);
    const auto fill = [&](const FaceRange& range, int value) {
      Index lost = 0;
      for (int t = range.lo[1]; t < range.hi[1]; ++t)
      {
        for (int s = range.lo[0]; s < range.hi[0]; ++s)
        {
          int& quad = owner[static_cast<std::size_t>(t) * width + s];
          lost += quad != Free;
          quad = quad == Free ? value : quad;
        }
      }
      return lost;
    };
    for (const FaceRange& range : cover.interfaces)
    {
      if (fill(range, Taken) > 0)
      {
        throw Error(this->Result.label(block) + ", face " + std::to_string(face) + ": two interfaces overlap at " +
          rangeText(range));
      }
    }
    Index lost = 0;
    for (const int b : cover.boundaries)
    {
      lost += fill(this->Mesh.boundaries[b].range, b);
    }
    // Rectangles: as long as possible, then as high.
    for (int t = 0; t < whole.hi[1]; ++t)
    {
      for (int s = 0; s < width; ++s)
      {
        const auto row = [&](int at) { return owner.begin() + static_cast<std::ptrdiff_t>(at) * width; };
        const int value = row(t)[s];
        if (value == Taken)
        {
          continue;
        }
        const FaceRange declared = value == Free ? whole : this->Mesh.boundaries[value].range;
        int end = s;
        while (end < declared.hi[0] && row(t)[end] == value)
        {
          ++end;
        }
        int top = t;
        while (top < declared.hi[1] && std::all_of(row(top) + s, row(top) + end, [&](int own) { return own == value; }))
        {
          std::fill(row(top) + s, row(top) + end, Taken);
          ++top;
        }
        const int tag = value == Free ? -1 : this->Mesh.boundaries[value].tag;
        patches.emplace_back(value == Free ? this->Mesh.boundaries.size() : static_cast<std::size_t>(value),
          BoundaryPatch{ block, face, { { s, t }, { end, top } }, tag });
      }
    }
    return lost;
  }

  const BlockMesh& Mesh;
  MeshToWrite& Result;
  std::vector<FaceCover> Faces;
};

/// Sign of the volume that the surface of a block encloses: 1 or -1, by the divergence theorem.
bool isLeftHanded(const GridView& points)
{
  const Ijk& counts = points.counts();
  const Vec3 origin = points(0, 0, 0);
  double volume = 0.0;
  for (int face = 0; face < 6; ++face)
  {
    const int d = faceDirection(face);
    const int ds = faceAxis(face, 0);
    const int dt = faceAxis(face, 1);
    // The axes of j faces are i, k, whose cross product is -j.
    const double sign = (faceSide(face) ? 1.0 : -1.0) * (d == 1 ? -1.0 : 1.0);
    Ijk p{};
    p[d] = faceSide(face) ? counts[d] - 1 : 0;
    const auto at = [&](int s, int t) {
      Ijk q = p;
      q[ds] = s;
      q[dt] = t;
      return Vec3(points(q) - origin);
    };
    for (int t = 0; t + 1 < counts[dt]; ++t)
    {
      for (int s = 0; s + 1 < counts[ds]; ++s)
      {
        const Vec3 a = at(s, t);
        const Vec3 b = at(s + 1, t);
        const Vec3 c = at(s, t + 1);
        const Vec3 e = at(s + 1, t + 1);
        volume += sign * (a + b + c + e).dot((e - a).cross(c - b));
      }
    }
  }
  return volume < 0.0;
}

} // namespace

Index MeshToWrite::pointCount() const
{
  Index count = 0;
  for (const BlockToWrite& block : this->blocks)
  {
    count += block.size();
  }
  return count;
}

Index MeshToWrite::cellCount() const
{
  Index count = 0;
  for (const BlockToWrite& block : this->blocks)
  {
    count += block.cellCount();
  }
  return count;
}

bool MeshToWrite::isFloat() const
{
  return std::all_of(
    this->blocks.begin(), this->blocks.end(), [](const BlockToWrite& block) { return block.points.isFloat(); });
}

Index MeshToWrite::unnamedQuads() const
{
  Index count = 0;
  for (const BoundaryPatch& patch : this->boundaries)
  {
    count += patch.tag < 0 ? quadCount(patch.range) : 0;
  }
  return count;
}

std::string MeshToWrite::label(std::size_t block) const
{
  return "block " + std::to_string(block) + " '" + this->blocks[block].name + "'";
}

MeshToWrite meshToWrite(const BlockMesh& mesh, const std::vector<const int*>& iblank, const Execution& run)
{
  MeshToWrite result;
  const std::vector<char> left = gatherFromOwners<char>(
    *run.ranks, mesh.blocks.size(), [&](std::size_t b) { return mesh.blocks[b].rank; },
    [&](std::size_t b) { return isLeftHanded(mesh.blocks[b].points) ? 1 : 0; });
  // The precision of blocks on other ranks.
  const std::vector<char> isFloat = gatherFromOwners<char>(
    *run.ranks, mesh.blocks.size(), [&](std::size_t b) { return mesh.blocks[b].rank; },
    [&](std::size_t b) { return mesh.blocks[b].points.isFloat() ? 1 : 0; });
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b)
  {
    BlockToWrite block;
    block.points = mesh.blocks[b].points;
    if (block.points.isElsewhere() && isFloat[b])
    {
      block.points = GridView(static_cast<const float*>(nullptr), block.points.counts());
    }
    block.rank = mesh.blocks[b].rank;
    block.name = mesh.blocks[b].name;
    block.counts = block.points.counts();
    block.iblank = iblank.empty() ? nullptr : iblank[b];
    block.leftHanded = left[b] != 0;
    result.blocks.push_back(block);
  }
  result.boundaryNames = mesh.boundaryNames;
  result.boundaryTypes = completeTypes(mesh.boundaryNames, mesh.boundaryTypes);
  MeshPreparation(mesh, result).prepare(run);
  return result;
}

MeshToWrite coarsened(const MeshToWrite& mesh, int step)
{
  MeshToWrite result = mesh;
  const auto divided = [&](int value, const std::string& what) {
    if (value % step != 0)
    {
      throw Error(what + ", which " + std::to_string(step) + " does not divide: there is no coarser level");
    }
    return value / step;
  };
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b)
  {
    BlockToWrite& block = result.blocks[b];
    block.step *= step;
    for (int d = 0; d < 3; ++d)
    {
      block.counts[d] = 1 +
        divided(block.cells(d), mesh.label(b) + " has " + std::to_string(block.cells(d)) + " cells along " + "ijk"[d]);
    }
  }
  const auto divideRange = [&](FaceRange& range, int block, int face, const char* what) {
    for (int* value : { range.lo.data(), range.lo.data() + 1, range.hi.data(), range.hi.data() + 1 })
    {
      *value = divided(*value,
        mesh.label(block) + ", face " + std::to_string(face) + ": " + what + " ends at point " +
          std::to_string(*value));
    }
  };
  for (Interface& contact : result.interfaces)
  {
    FaceRange rangeB = contact.rangeB();
    divideRange(rangeB, contact.blockB, contact.faceB, "an interface");
    divideRange(contact.rangeA, contact.blockA, contact.faceA, "an interface");
    contact.originB = rangeB.lo;
  }
  for (BoundaryPatch& patch : result.boundaries)
  {
    divideRange(patch.range, patch.block, patch.face, "a boundary");
  }
  return result;
}

std::string typeOfBoundary(const std::string& name)
{
  static const std::vector<std::string> types{ "BCAxisymmetricWedge", "BCDegenerateLine", "BCDegeneratePoint",
    "BCDirichlet", "BCExtrapolate", "BCFarfield", "BCGeneral", "BCInflow", "BCInflowSubsonic", "BCInflowSupersonic",
    "BCNeumann", "BCOutflow", "BCOutflowSubsonic", "BCOutflowSupersonic", "BCSymmetryPlane", "BCSymmetryPolar",
    "BCTunnelInflow", "BCTunnelOutflow", "BCWall", "BCWallInviscid", "BCWallViscous", "BCWallViscousHeatFlux",
    "BCWallViscousIsothermal" };
  if (std::find(types.begin(), types.end(), name) != types.end())
  {
    return name;
  }
  static const std::vector<std::pair<BoundaryPatterns, std::string>> patterns{
    { { "*viscous*", "*no*slip*" }, "BCWallViscous" },
    { { "*inviscid*", "*slip*wall*" }, "BCWallInviscid" },
    { { "*symm*" }, "BCSymmetryPlane" },
    { { "*far*field*", "*far_field*", "farf*", "*freestream*", "far" }, "BCFarfield" },
    { { "*inflow*", "*inlet*" }, "BCInflow" },
    { { "*outflow*", "*outlet*" }, "BCOutflow" },
  };
  for (const auto& [list, type] : patterns)
  {
    if (matchesAny(list, name))
    {
      return type;
    }
  }
  return matchesAny(defaultBodyBoundaries(), name) ? "BCWall" : "BCTypeUserDefined";
}

std::vector<std::string> completeTypes(const std::vector<std::string>& names, const std::vector<std::string>& types)
{
  std::vector<std::string> result;
  for (std::size_t n = 0; n < names.size(); ++n)
  {
    const std::string type = n < types.size() ? types[n] : "";
    result.push_back(type.empty() || type == "BCTypeNull" ? typeOfBoundary(names[n]) : type);
  }
  return result;
}

std::vector<std::string> allowedNames(
  const std::vector<std::string>& names, const std::string& allowed, std::size_t longest)
{
  std::set<std::string> used;
  std::vector<std::string> result;
  for (const std::string& name : names)
  {
    std::string base = name.empty() ? "unnamed" : name;
    for (char& c : base)
    {
      const auto byte = static_cast<unsigned char>(c);
      c = (byte < 128 && std::isalnum(byte)) || allowed.find(c) != std::string::npos ? c : '_';
    }
    std::string unique = base.substr(0, longest);
    for (int n = 2; !used.insert(unique).second; ++n)
    {
      const std::string suffix = "_" + std::to_string(n);
      unique = base.substr(0, longest - suffix.size()) + suffix;
    }
    result.push_back(unique);
  }
  return result;
}

std::string turnedCellsNote(const MeshToWrite& mesh, const Execution& run)
{
  const std::vector<TurnedCells> turned = gatherFromOwners<TurnedCells>(
    *run.ranks, mesh.blocks.size(), [&](std::size_t b) { return mesh.blocks[b].rank; },
    [&](std::size_t b) { return turnedCells(mesh.blocks[b].points, mesh.blocks[b].step, run); });
  return turnedCellsNote(turned, [&](std::size_t b) { return mesh.label(b); });
}

FirstCells firstCells(const MeshToWrite& mesh, const Execution& run)
{
  std::vector<double> heights;
  for (const BoundaryPatch& patch : mesh.boundaries)
  {
    const BlockToWrite& block = mesh.blocks[patch.block];
    if (block.rank != run.ranks->rank() || patch.tag < 0 || mesh.boundaryTypes[patch.tag].compare(0, 6, "BCWall") != 0)
    {
      continue;
    }
    const int d = faceDirection(patch.face);
    Ijk p{};
    p[d] = faceSide(patch.face) ? block.counts[d] - 1 : 0;
    for (int t = patch.range.lo[1]; t <= patch.range.hi[1]; ++t)
    {
      for (int s = patch.range.lo[0]; s <= patch.range.hi[0]; ++s)
      {
        p[faceAxis(patch.face, 0)] = s;
        p[faceAxis(patch.face, 1)] = t;
        Ijk q = p;
        q[d] += faceSide(patch.face) ? -1 : 1;
        heights.push_back((block.at(q[0], q[1], q[2]) - block.at(p[0], p[1], p[2])).norm());
      }
    }
  }
  heights = run.ranks->gatherAll(heights);
  // Sorted, so that the sum does not depend on how the blocks are numbered or shared out.
  std::sort(heights.begin(), heights.end());
  FirstCells result;
  if (!heights.empty())
  {
    result.count = static_cast<Index>(heights.size());
    result.smallest = heights.front();
    result.largest = heights.back();
    result.mean = std::accumulate(heights.begin(), heights.end(), 0.0) / static_cast<double>(heights.size());
  }
  return result;
}

} // namespace bsv
