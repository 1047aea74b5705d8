// SPDX-License-Identifier: BSD-3-Clause
#include "QuadflowFormat.h"

#include "AtomicFile.h"
#include "Conversion.h"
#include "SharedEntities.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <string_view>

#include <sys/stat.h>

namespace bsv
{

namespace
{

std::string faceName(int block, int face)
{
  return "block " + std::to_string(block) + ", face " + std::to_string(face);
}

std::string pointName(const Ijk& i)
{
  return "(" + std::to_string(i[0]) + ", " + std::to_string(i[1]) + ", " + std::to_string(i[2]) + ")";
}

const double* pointAt(const BSplineVolume& volume, const Ijk& i)
{
  return volume.points + 3 * (i[0] + volume.count(0) * (i[1] + Index(volume.count(1)) * i[2]));
}

bool sameBits(const double* a, const double* b)
{
  return std::memcmp(a, b, 3 * sizeof(double)) == 0;
}

Ijk onFace(const BSplineVolume& volume, int face, int s, int t)
{
  Ijk i{};
  i[faceDirection(face)] = faceSide(face) ? volume.count(faceDirection(face)) - 1 : 0;
  i[faceAxis(face, 0)] = s;
  i[faceAxis(face, 1)] = t;
  return i;
}

Ijk cornerPoint(const BSplineVolume& volume, int corner)
{
  Ijk i{};
  for (int d = 0; d < 3; ++d)
  {
    i[d] = cornerSide(corner, d) ? volume.count(d) - 1 : 0;
  }
  return i;
}

int spans(const BSplineVolume& volume, int d)
{
  return static_cast<int>(nonEmptySpans(volume.degree[d], volume.knots[d]).size());
}

/// Why two faces do not meet, or nothing. `where` is the control point of A, if one is to blame.
std::string difference(
  const BSplineVolume& a, int faceA, const BSplineVolume& b, int faceB, int orientation, Ijk* where = nullptr)
{
  for (int axis = 0; axis < 2; ++axis)
  {
    const int axisB = swapsAxes(orientation) ? 1 - axis : axis;
    const int dA = faceAxis(faceA, axis);
    const int dB = faceAxis(faceB, axisB);
    const bool reversed = (orientation & (axisB == 0 ? 2 : 4)) != 0;
    const std::vector<double>& kA = a.knots[dA];
    const std::vector<double>& kB = b.knots[dB];
    if (a.degree[dA] != b.degree[dB])
    {
      return "degrees " + std::to_string(a.degree[dA]) + " and " + std::to_string(b.degree[dB]) + " differ";
    }
    if (kA.size() != kB.size())
    {
      return std::to_string(a.count(dA)) + " and " + std::to_string(b.count(dB)) + " control points";
    }
    // Equal but for what rounding does to distances from the two ends.
    const double largest =
      std::max({ std::abs(kA.front()), std::abs(kA.back()), std::abs(kB.front()), std::abs(kB.back()) });
    const double tolerance = 8.0 * std::numeric_limits<double>::epsilon() * largest;
    for (std::size_t i = 0; i < kA.size(); ++i)
    {
      const double fromA = kA[i] - kA.front();
      const double fromB = reversed ? kB.back() - kB[kB.size() - 1 - i] : kB[i] - kB.front();
      if (std::abs(fromA - fromB) > tolerance)
      {
        return "knots differ";
      }
    }
  }
  const int ns = a.count(faceAxis(faceA, 0)) - 1;
  const int nt = a.count(faceAxis(faceA, 1)) - 1;
  for (int t = 0; t <= nt; ++t)
  {
    for (int s = 0; s <= ns; ++s)
    {
      const auto m = mapFacePoint(orientation, s, t, ns, nt);
      const Ijk iA = onFace(a, faceA, s, t);
      const Ijk iB = onFace(b, faceB, m[0], m[1]);
      if (!sameBits(pointAt(a, iA), pointAt(b, iB)))
      {
        if (where)
        {
          *where = iA;
        }
        return "control points " + pointName(iA) + " and " + pointName(iB) + " differ";
      }
    }
  }
  return "";
}

/// The whole face, in control points.
Interface wholeFaces(const std::vector<BSplineVolume>& volumes, int blockA, int faceA, int blockB, int faceB, int o)
{
  const BSplineVolume& a = volumes[blockA];
  return { blockA, faceA, blockB, faceB, o,
    { { 0, 0 }, { a.count(faceAxis(faceA, 0)) - 1, a.count(faceAxis(faceA, 1)) - 1 } }, { 0, 0 } };
}

/// Pairs of faces whose control points are equal bit for bit.
std::vector<Interface> findInterfaces(const std::vector<BSplineVolume>& volumes)
{
  using Key = std::array<std::array<std::uint64_t, 3>, 4>;
  std::map<Key, std::vector<int>> candidates; // by the corners, in any order
  for (int f = 0; f < 6 * static_cast<int>(volumes.size()); ++f)
  {
    Key key;
    for (int c = 0; c < 4; ++c)
    {
      const BSplineVolume& volume = volumes[f / 6];
      std::memcpy(key[c].data(), pointAt(volume, cornerPoint(volume, faceCorner(f % 6, c & 1, c >> 1))), sizeof(key[c]));
    }
    std::sort(key.begin(), key.end());
    candidates[key].push_back(f);
  }
  std::vector<Interface> interfaces;
  std::set<int> taken;
  for (const auto& candidate : candidates)
  {
    const std::vector<int>& faces = candidate.second;
    for (std::size_t x = 0; x < faces.size(); ++x)
    {
      for (std::size_t y = x + 1; y < faces.size(); ++y)
      {
        const int a = faces[x];
        const int b = faces[y];
        for (int o = 0; o < 8; ++o)
        {
          if (!difference(volumes[a / 6], a % 6, volumes[b / 6], b % 6, o).empty())
          {
            continue;
          }
          if (!taken.insert(a).second || !taken.insert(b).second)
          {
            throw Error(faceName(a / 6, a % 6) + " meets " + faceName(b / 6, b % 6) +
              " and more; the interfaces must be given");
          }
          interfaces.push_back(wholeFaces(volumes, a / 6, a % 6, b / 6, b % 6, o));
        }
      }
    }
  }
  std::sort(interfaces.begin(), interfaces.end(), [](const Interface& a, const Interface& b) {
    return std::make_pair(a.blockA, a.faceA) < std::make_pair(b.blockA, b.faceA);
  });
  return interfaces;
}

QuadflowEdgeClass edgeClass(const SharedEntities::Edge& edge, const BSplineVolume& volume, const unsigned char* rules)
{
  const bool extraordinary = !edge.boundary && edge.uses != 4;
  if (extraordinary)
  {
    return QuadflowEdgeClass::Extraordinary;
  }
  bool crease = false;
  bool planar = false;
  bool other = false;
  const int d = edgeDirection(edge.edge);
  Ijk i = cornerPoint(volume, edgeCorner(edge.edge, 0));
  // The ends belong to the vertices.
  for (i[d] = 1; rules && i[d] + 1 < volume.count(d); ++i[d])
  {
    const auto rule = static_cast<ControlPointRule>(rules[(pointAt(volume, i) - volume.points) / 3]);
    crease = crease || rule == ControlPointRule::Crease;
    planar = planar || rule == ControlPointRule::PlanarSide;
    other = other || (rule != ControlPointRule::PlanarSide && rule != ControlPointRule::Corner);
  }
  return edge.boundary && crease ? QuadflowEdgeClass::Crease
    : planar && !other           ? QuadflowEdgeClass::Planar
    : edge.boundary              ? QuadflowEdgeClass::Boundary
                                 : QuadflowEdgeClass::Regular;
}

std::vector<QuadflowBoundaryName> numberedBoundaries(const QuadflowInput& input)
{
  std::map<std::string, int> given;
  std::set<int> used;
  for (const auto& [name, id] : input.boundaryIds)
  {
    if (id < 1)
    {
      throw Error("boundary '" + name + "': the id " + std::to_string(id) + " is not positive");
    }
    if (!given.emplace(name, id).second || !used.insert(id).second)
    {
      throw Error("boundary '" + name + "': the name or the id " + std::to_string(id) + " is given twice");
    }
  }
  std::vector<QuadflowBoundaryName> result;
  int next = 1;
  for (const std::string& name : input.boundaryNames)
  {
    const auto found = given.find(name);
    int id = found == given.end() ? 0 : found->second;
    if (id == 0)
    {
      while (used.count(next) > 0)
      {
        ++next;
      }
      id = next++;
    }
    result.push_back({ id, name });
  }
  return result;
}

} // namespace

//------------------------------------------------------------------------------
QuadflowCase makeQuadflowCase(const QuadflowInput& input)
{
  const int blocks = static_cast<int>(input.volumes.size());
  const auto label = [&](int block) { return "block " + std::to_string(block) + " '" + input.names[block] + "'"; };
  for (int b = 0; b < blocks; ++b)
  {
    const BSplineVolume& volume = input.volumes[b];
    checkBSplineVolume(volume, label(b));
    for (const double* x = volume.points; x != volume.points + 3 * Index(volume.count(0)) * volume.count(1) * volume.count(2); ++x)
    {
      if (!std::isfinite(*x))
      {
        throw Error(label(b) + ": control point " + std::to_string((x - volume.points) / 3) + " is not finite");
      }
    }
  }

  QuadflowCase all;
  std::vector<Interface> contacts = input.interfaces;
  if (!input.hasInterfaces)
  {
    contacts = findInterfaces(input.volumes);
  }
  for (Interface& contact : contacts)
  {
    contact = wholeFaces(
      input.volumes, contact.blockA, contact.faceA, contact.blockB, contact.faceB, contact.orientation);
    all.interfaces.push_back({ contact, cgnsTransform(contact.faceA, contact.faceB, contact.orientation) });
  }
  const SharedEntities entities = sharedEntities(blocks, contacts);

  all.boundaryNames = numberedBoundaries(input);
  std::vector<int> boundaryOf(6 * static_cast<std::size_t>(blocks), -1);
  for (const BoundaryPatch& patch : input.boundaries)
  {
    int& id = boundaryOf[6 * patch.block + patch.face];
    if (id != -1)
    {
      throw Error(faceName(patch.block, patch.face) + " is in two boundaries");
    }
    id = all.boundaryNames[patch.tag].id;
    all.boundaryFaces.push_back({ patch.block, patch.face, id });
  }

  all.vertices.resize(entities.vertices);
  for (int b = 0; b < blocks; ++b)
  {
    const SharedEntities::Block& shared = entities.blocks[b];
    QuadflowBlock block;
    block.name = input.names[b];
    block.volume = input.volumes[b];
    for (int d = 0; d < 3; ++d)
    {
      block.cells[d] = spans(block.volume, d);
    }
    block.vertices = shared.vertices;
    block.edges = shared.edges;
    block.edgeReversed = shared.edgeReversed;
    block.faces = shared.faces;
    block.faceOrientations = shared.faceOrientations;
    for (int corner = 0; corner < 8; ++corner)
    {
      const double* x = pointAt(block.volume, cornerPoint(block.volume, corner));
      all.vertices[block.vertices[corner]].position = Vec3(x[0], x[1], x[2]);
    }
    for (int face = 0; face < 6; ++face)
    {
      if (entities.faces[shared.faces[face]].uses == 1 && boundaryOf[6 * b + face] == -1)
      {
        boundaryOf[6 * b + face] = 0;
        all.boundaryFaces.push_back({ b, face, 0 });
      }
    }
    all.blocks.push_back(std::move(block));
  }
  for (const SharedEntities::Edge& shared : entities.edges)
  {
    QuadflowEdge edge;
    edge.vertices = shared.vertices;
    edge.cells = all.blocks[shared.block].cells[edgeDirection(shared.edge)];
    edge.kind = edgeClass(shared, input.volumes[shared.block],
      input.rules.empty() ? nullptr : input.rules[shared.block]);
    edge.valence = edge.kind == QuadflowEdgeClass::Extraordinary ? shared.uses : 0;
    all.edges.push_back(edge);
  }
  for (const SharedEntities::Face& shared : entities.faces)
  {
    const QuadflowBlock& block = all.blocks[shared.block];
    QuadflowFace face;
    for (int c = 0; c < 4; ++c)
    {
      face.vertices[c] = block.vertices[faceCorner(shared.face, c & 1, c >> 1)];
      face.edges[c] = block.edges[faceEdge(shared.face, c >> 1, c & 1)];
    }
    face.cells = { block.cells[faceAxis(shared.face, 0)], block.cells[faceAxis(shared.face, 1)] };
    face.blocks = shared.uses;
    face.boundary = shared.uses == 1 ? boundaryOf[6 * shared.block + shared.face] : 0;
    all.faces.push_back(face);
  }
  checkQuadflowCase(all);
  return all;
}

//------------------------------------------------------------------------------
namespace
{

/// The checks of checkQuadflowCase(), in the order in which they rest on each other.
class CaseCheck
{
public:
  CaseCheck(const QuadflowCase& all, const std::string& file, const std::string& geometryFile)
    : All(all)
    , File(file)
    , GeometryFile(geometryFile.empty() ? file : geometryFile)
  {
  }

  void run()
  {
    this->boundaryNames();
    this->geometry();
    this->everyFaceOnce();
    const SharedEntities entities = this->derivedEntities();
    this->sameNumbering(entities);
    this->blocks();
    this->edges(entities);
    this->faces(entities);
    this->corners();
    this->interfaces();
  }

private:
  [[noreturn]] void fail(int line, const std::string& what, bool inGeometry = false) const
  {
    const std::string& file = inGeometry ? this->GeometryFile : this->File;
    std::string where = file.empty() ? "" : file + ", ";
    where += line > 0 ? "line " + std::to_string(line) + ": " : "";
    throw Error(where + what);
  }

  /// Ids as in the text.
  std::string id(std::size_t index) const { return std::to_string(index + this->All.indexBase); }
  std::string blockName(std::size_t block) const { return "block " + this->id(block); }
  std::string faceName(std::size_t block, int face) const
  {
    return this->blockName(block) + ", face " + std::to_string(face);
  }

  void boundaryNames() const
  {
    std::set<int> ids;
    std::set<std::string> names;
    for (const QuadflowBoundaryName& boundary : this->All.boundaryNames)
    {
      if (boundary.id < 1 || !ids.insert(boundary.id).second || !names.insert(boundary.name).second)
      {
        this->fail(boundary.line,
          "boundary " + std::to_string(boundary.id) + " '" + boundary.name + "': ids must be positive, " +
            "ids and names unique");
      }
    }
    for (const QuadflowBoundaryFace& face : this->All.boundaryFaces)
    {
      if (face.boundary != 0 && ids.count(face.boundary) == 0)
      {
        this->fail(face.line,
          this->faceName(face.block, face.face) + ": there is no boundary " + std::to_string(face.boundary));
      }
    }
  }

  void geometry() const
  {
    for (std::size_t b = 0; b < this->All.blocks.size(); ++b)
    {
      const QuadflowBlock& block = this->All.blocks[b];
      const std::string name = this->blockName(b);
      try
      {
        checkBSplineVolume(block.volume, name);
      }
      catch (const Error& error)
      {
        this->fail(block.pointsLine, error.what(), true);
      }
      for (int d = 0; d < 3; ++d)
      {
        const std::vector<double>& knots = block.volume.knots[d];
        const int p = block.volume.degree[d];
        if (knots[0] != knots[p] || knots[knots.size() - 1 - p] != knots.back())
        {
          this->fail(block.pointsLine,
            name + ": the knots of direction " + std::to_string(d) + " are not clamped; the corners would not be vertices",
            true);
        }
        if (spans(block.volume, d) != block.cells[d])
        {
          this->fail(block.pointsLine,
            name + " has " + std::to_string(block.cells[d]) + " cells but " + std::to_string(spans(block.volume, d)) +
              " knot spans in direction " + std::to_string(d),
            true);
        }
      }
    }
  }

  void everyFaceOnce() const
  {
    constexpr int None = -1;
    std::vector<int> line(6 * this->All.blocks.size(), None);
    const auto cover = [&](int block, int face, int at) {
      int& seen = line[6 * static_cast<std::size_t>(block) + face];
      if (seen != None)
      {
        this->fail(at,
          this->faceName(block, face) + " is already in another interface or boundary" +
            (seen > 0 ? ", line " + std::to_string(seen) : ""));
      }
      seen = at;
    };
    for (const QuadflowInterface& entry : this->All.interfaces)
    {
      const Interface& c = entry.contact;
      cover(c.blockA, c.faceA, entry.line);
      cover(c.blockB, c.faceB, entry.line);
      if (entry.transform != cgnsTransform(c.faceA, c.faceB, c.orientation))
      {
        this->fail(entry.line,
          this->faceName(c.blockA, c.faceA) + " to " + this->faceName(c.blockB, c.faceB) +
            ": the transform does not belong to orientation " + std::to_string(c.orientation));
      }
    }
    for (const QuadflowBoundaryFace& face : this->All.boundaryFaces)
    {
      cover(face.block, face.face, face.line);
    }
    for (std::size_t f = 0; f < line.size(); ++f)
    {
      if (line[f] == None)
      {
        this->fail(this->All.blocks[f / 6].line,
          this->faceName(f / 6, static_cast<int>(f % 6)) + " is in no interface and no boundary");
      }
    }
  }

  SharedEntities derivedEntities() const
  {
    std::vector<Interface> contacts;
    for (const QuadflowInterface& entry : this->All.interfaces)
    {
      contacts.push_back(entry.contact);
    }
    try
    {
      return sharedEntities(static_cast<int>(this->All.blocks.size()), contacts);
    }
    catch (const Error& error)
    {
      this->fail(0, error.what());
    }
  }

  /// The ids must be those of the derived entities, up to their order.
  void sameNumbering(const SharedEntities& entities) const
  {
    const auto compare = [&](const char* what, std::size_t derived, std::size_t found, auto&& derivedIds, auto&& ids) {
      if (derived != found)
      {
        this->fail(0,
          "there are " + std::to_string(found) + " " + what + ", but the interfaces make " + std::to_string(derived));
      }
      std::vector<int> toFound(derived, -1);
      std::vector<int> toDerived(found, -1);
      for (std::size_t b = 0; b < this->All.blocks.size(); ++b)
      {
        const auto& expected = derivedIds(entities.blocks[b]);
        const auto& actual = ids(this->All.blocks[b]);
        for (std::size_t i = 0; i < actual.size(); ++i)
        {
          int& forward = toFound[expected[i]];
          int& backward = toDerived[actual[i]];
          if ((forward != -1 || backward != -1) && (forward != actual[i] || backward != expected[i]))
          {
            this->fail(this->All.blocks[b].line,
              this->blockName(b) + ": " + what + ", entry " + std::to_string(i) + ", does not agree with the interfaces");
          }
          forward = actual[i];
          backward = expected[i];
        }
      }
    };
    compare("vertices", entities.vertices, this->All.vertices.size(),
      [](const auto& block) -> const auto& { return block.vertices; },
      [](const auto& block) -> const auto& { return block.vertices; });
    compare("edges", entities.edges.size(), this->All.edges.size(),
      [](const auto& block) -> const auto& { return block.edges; },
      [](const auto& block) -> const auto& { return block.edges; });
    compare("faces", entities.faces.size(), this->All.faces.size(),
      [](const auto& block) -> const auto& { return block.faces; },
      [](const auto& block) -> const auto& { return block.faces; });
  }

  /// Vertices, edges and faces as the block sees them.
  void blocks() const
  {
    for (std::size_t b = 0; b < this->All.blocks.size(); ++b)
    {
      const QuadflowBlock& block = this->All.blocks[b];
      const std::string name = this->blockName(b);
      for (int e = 0; e < 12; ++e)
      {
        const QuadflowEdge& edge = this->All.edges[block.edges[e]];
        const bool reversed = block.edgeReversed[e];
        if (block.vertices[edgeCorner(e, reversed ? 1 : 0)] != edge.vertices[0] ||
          block.vertices[edgeCorner(e, reversed ? 0 : 1)] != edge.vertices[1])
        {
          this->fail(block.line,
            name + ", edge " + std::to_string(e) + ": its corners are not the vertices of edge " +
              this->id(block.edges[e]) + ", or its sign is wrong");
        }
        if (block.cells[edgeDirection(e)] != edge.cells)
        {
          this->fail(block.line,
            name + ", edge " + std::to_string(e) + ": " + std::to_string(block.cells[edgeDirection(e)]) +
              " cells, but edge " + this->id(block.edges[e]) + " has " + std::to_string(edge.cells));
        }
      }
      for (int f = 0; f < 6; ++f)
      {
        const QuadflowFace& face = this->All.faces[block.faces[f]];
        const int o = block.faceOrientations[f];
        for (int c = 0; c < 4; ++c)
        {
          // Corner c, and edge c: along axis c / 2 at side c % 2 of the other.
          const auto corner = mapFacePoint(o, c & 1, c >> 1, 1, 1);
          const int axis = c >> 1;
          const auto start = mapFacePoint(o, axis == 0 ? 0 : c & 1, axis == 0 ? c & 1 : 0, 1, 1);
          const int axisHere = swapsAxes(o) ? 1 - axis : axis;
          if (block.vertices[faceCorner(f, corner[0], corner[1])] != face.vertices[c] ||
            block.edges[faceEdge(f, axisHere, start[1 - axisHere])] != face.edges[c])
          {
            this->fail(block.line,
              name + ", face " + std::to_string(f) + ": its corners and edges are not those of face " +
                this->id(block.faces[f]) + " in orientation " + std::to_string(o));
          }
        }
        for (int axis = 0; axis < 2; ++axis)
        {
          if (block.cells[faceAxis(f, swapsAxes(o) ? 1 - axis : axis)] != face.cells[axis])
          {
            this->fail(block.line,
              name + ", face " + std::to_string(f) + ": its cells are not those of face " +
                this->id(block.faces[f]));
          }
        }
      }
    }
  }

  void edges(const SharedEntities& entities) const
  {
    std::vector<int> against(this->All.edges.size(), -1);
    for (std::size_t b = 0; b < this->All.blocks.size(); ++b)
    {
      const QuadflowBlock& block = this->All.blocks[b];
      for (int e = 0; e < 12; ++e)
      {
        const int id = block.edges[e];
        const QuadflowEdge& edge = this->All.edges[id];
        const SharedEntities::Edge& derived = entities.edges[entities.blocks[b].edges[e]];
        // An edge that is closed on itself says nothing by its vertices, but its uses must agree.
        const int turned = block.edgeReversed[e] != entities.blocks[b].edgeReversed[e];
        if (against[id] != -1 && against[id] != turned)
        {
          this->fail(block.line, this->blockName(b) + ", edge " + std::to_string(e) + ": its sign is wrong");
        }
        against[id] = turned;
        if (edge.vertices[0] > edge.vertices[1])
        {
          this->fail(edge.line, "edge " + this->id(id) + " runs from the higher vertex to the lower");
        }
        const bool planar = edge.kind == QuadflowEdgeClass::Planar;
        const bool good = derived.boundary
          ? edge.kind == QuadflowEdgeClass::Boundary || edge.kind == QuadflowEdgeClass::Crease || planar
          : derived.uses == 4
          ? edge.kind == QuadflowEdgeClass::Regular || planar
          : edge.kind == QuadflowEdgeClass::Extraordinary && edge.valence == derived.uses;
        if (!good)
        {
          this->fail(edge.line,
            "edge " + this->id(id) + " (" + this->blockName(b) + ", edge " + std::to_string(e) +
              "): its class is wrong, " + std::to_string(derived.uses) + " blocks meet there " +
              (derived.boundary ? "on the boundary" : "inside"));
        }
      }
    }
  }

  void faces(const SharedEntities& entities) const
  {
    std::vector<int> boundary(this->All.faces.size(), 0);
    for (const QuadflowBoundaryFace& entry : this->All.boundaryFaces)
    {
      boundary[this->All.blocks[entry.block].faces[entry.face]] = entry.boundary;
    }
    for (std::size_t b = 0; b < this->All.blocks.size(); ++b)
    {
      for (int f = 0; f < 6; ++f)
      {
        const int id = this->All.blocks[b].faces[f];
        const QuadflowFace& face = this->All.faces[id];
        const std::string name = "face " + this->id(id) + " (" + this->faceName(b, f) + ")";
        if (face.blocks != entities.faces[entities.blocks[b].faces[f]].uses)
        {
          this->fail(face.line, name + ": wrong number of blocks " + std::to_string(face.blocks));
        }
        if (face.boundary != boundary[id])
        {
          this->fail(face.line,
            name + ": boundary " + std::to_string(face.boundary) + " is not that of the list of boundary faces, " +
              std::to_string(boundary[id]));
        }
      }
    }
  }

  void corners() const
  {
    for (std::size_t b = 0; b < this->All.blocks.size(); ++b)
    {
      const QuadflowBlock& block = this->All.blocks[b];
      for (int corner = 0; corner < 8; ++corner)
      {
        const QuadflowVertex& vertex = this->All.vertices[block.vertices[corner]];
        if (!sameBits(vertex.position.data(), pointAt(block.volume, cornerPoint(block.volume, corner))))
        {
          this->fail(vertex.line,
            "vertex " + this->id(block.vertices[corner]) + " is not the control point at corner " +
              std::to_string(corner) + " of " + this->blockName(b));
        }
      }
    }
  }

  void interfaces() const
  {
    for (const QuadflowInterface& entry : this->All.interfaces)
    {
      const Interface& c = entry.contact;
      const std::string name = this->faceName(c.blockA, c.faceA) + " and " + this->faceName(c.blockB, c.faceB) +
        " in orientation " + std::to_string(c.orientation) + ": ";
      const int oA = this->All.blocks[c.blockA].faceOrientations[c.faceA];
      const int oB = this->All.blocks[c.blockB].faceOrientations[c.faceB];
      for (int corner = 0; corner < 4; ++corner)
      {
        const auto a = mapFacePoint(oA, corner & 1, corner >> 1, 1, 1);
        if (mapFacePoint(c.orientation, a[0], a[1], 1, 1) != mapFacePoint(oB, corner & 1, corner >> 1, 1, 1))
        {
          this->fail(entry.line, name + "the blocks give their common face other orientations");
        }
      }
      const QuadflowBlock& blockA = this->All.blocks[c.blockA];
      Ijk at{ -1, -1, -1 };
      const std::string what =
        difference(blockA.volume, c.faceA, this->All.blocks[c.blockB].volume, c.faceB, c.orientation, &at);
      if (!what.empty())
      {
        const bool inGeometry = at[0] >= 0 && blockA.pointsLine > 0;
        const Index offset = inGeometry ? (pointAt(blockA.volume, at) - blockA.volume.points) / 3 : 0;
        this->fail(inGeometry ? blockA.pointsLine + static_cast<int>(offset) : entry.line, name + what, inGeometry);
      }
    }
  }

  const QuadflowCase& All;
  const std::string& File;
  std::string GeometryFile;
};

} // namespace

void checkQuadflowCase(const QuadflowCase& all, const std::string& file, const std::string& geometryFile)
{
  CaseCheck(all, file, geometryFile).run();
}

//------------------------------------------------------------------------------
// From here on: the text.
namespace
{

constexpr const char* Magic = "QFMB";
constexpr const char* GeometryMagic = "QFBSP";
constexpr const char* Version = "1.0";
constexpr const char* KnotLabels[3] = { "knots_i", "knots_j", "knots_k" };
constexpr const char* EdgeClassNames[5] = { "regular", "boundary", "extraordinary", "crease", "planar" };

/// A name as one word without blanks: bytes that would end it, '%' and '#' become %XX; an empty name becomes "-".
std::string encoded(const std::string& name)
{
  if (name.empty())
  {
    return "-";
  }
  static const char* digits = "0123456789ABCDEF";
  std::string result;
  for (const char c : name)
  {
    const auto byte = static_cast<unsigned char>(c);
    if (byte <= ' ' || byte == 127 || c == '%' || c == '#' || name == "-")
    {
      result += { '%', digits[byte >> 4], digits[byte & 15] };
    }
    else
    {
      result += c;
    }
  }
  return result;
}

class Text
{
public:
  explicit Text(const std::string& path)
    : File(path)
  {
  }

  Text& operator<<(const std::string& text)
  {
    this->File.write(text);
    return *this;
  }
  Text& operator<<(int value)
  {
    char* to = this->File.room(16);
    this->File.advance(std::to_chars(to, to + 16, value).ptr);
    return *this;
  }
  /// Shortest digits that read back to the same value.
  Text& operator<<(double value)
  {
    char* to = this->File.room(32);
    this->File.advance(std::to_chars(to, to + 32, value).ptr);
    return *this;
  }
  void point(const double* x)
  {
    char* to = this->File.room(100);
    for (int c = 0; c < 3; ++c)
    {
      to = std::to_chars(to, to + 32, x[c]).ptr;
      *to++ = c < 2 ? ' ' : '\n';
    }
    this->File.advance(to);
  }
  AtomicFile& file() { return this->File; }

private:
  AtomicFile File;
};

void writeHeader(Text& text, const char* magic, const QuadflowOptions& options)
{
  text << "# Multi-block B-spline topology, dialect of BSplineVolume; see quadflow_format.md.\n"
       << magic << " " << Version << "\n"
       << "dimension 3\nindex_base " << options.indexBase << "\nknots " << (options.unitKnots ? "unit" : "integer")
       << "\ncp_order ijk\n";
}

void writeTopology(Text& text, const QuadflowCase& all, int base)
{
  text << "counts vertices " << static_cast<int>(all.vertices.size()) << " edges " << static_cast<int>(all.edges.size())
       << " faces " << static_cast<int>(all.faces.size()) << " blocks " << static_cast<int>(all.blocks.size()) << "\n";
  int id = base;
  text << "VERTICES # id x y z\n";
  for (const QuadflowVertex& vertex : all.vertices)
  {
    text << id++ << " ";
    text.point(vertex.position.data());
  }
  id = base;
  text << "EDGES # id v0 v1 n class\n";
  for (const QuadflowEdge& edge : all.edges)
  {
    text << id++ << " " << edge.vertices[0] + base << " " << edge.vertices[1] + base << " " << edge.cells << " "
         << EdgeClassNames[static_cast<int>(edge.kind)];
    if (edge.kind == QuadflowEdgeClass::Extraordinary)
    {
      text << ":" << edge.valence;
    }
    text << "\n";
  }
  id = base;
  text << "FACES # id v00 v10 v01 v11 es0 es1 et0 et1 ns nt nblocks bc\n";
  for (const QuadflowFace& face : all.faces)
  {
    text << id++;
    for (const int vertex : face.vertices)
    {
      text << " " << vertex + base;
    }
    for (const int edge : face.edges)
    {
      text << " " << edge + base;
    }
    text << " " << face.cells[0] << " " << face.cells[1] << " " << face.blocks << " " << face.boundary << "\n";
  }
  id = base;
  text << "BLOCKS\n";
  for (const QuadflowBlock& block : all.blocks)
  {
    text << "block " << id++ << " type BSPLINE cells " << block.cells[0] << " " << block.cells[1] << " "
         << block.cells[2] << " zone " << encoded(block.name) << "\n v";
    for (const int vertex : block.vertices)
    {
      text << " " << vertex + base;
    }
    text << "\n e";
    for (int e = 0; e < 12; ++e)
    {
      text << " " << block.edges[e] + base << (block.edgeReversed[e] ? ":-1" : ":+1");
    }
    text << "\n f";
    for (int f = 0; f < 6; ++f)
    {
      text << " " << block.faces[f] + base << ":" << block.faceOrientations[f];
    }
    text << "\n";
  }
  text << "CONNECTIVITY # blockA faceA blockB faceB o T1 T2 T3\n";
  for (const QuadflowInterface& entry : all.interfaces)
  {
    const Interface& c = entry.contact;
    text << c.blockA + base << " " << c.faceA << " " << c.blockB + base << " " << c.faceB << " " << c.orientation;
    for (const int direction : entry.transform)
    {
      text << " " << direction;
    }
    text << "\n";
  }
  text << "BOUNDARY # block face bc\n";
  for (const QuadflowBoundaryFace& face : all.boundaryFaces)
  {
    text << face.block + base << " " << face.face << " " << face.boundary << "\n";
  }
  text << "BCTABLE # bc name\n";
  for (const QuadflowBoundaryName& boundary : all.boundaryNames)
  {
    text << boundary.id << " " << encoded(boundary.name) << "\n";
  }
}

void writeGeometry(Text& text, const QuadflowCase& all, const QuadflowOptions& options, const Execution& run)
{
  double total = 1.0;
  for (const QuadflowBlock& block : all.blocks)
  {
    total += static_cast<double>(block.volume.count(0)) * block.volume.count(1) * block.volume.count(2);
  }
  double done = 0.0;
  int id = options.indexBase;
  for (const QuadflowBlock& block : all.blocks)
  {
    const BSplineVolume& volume = block.volume;
    text << "block " << id++ << "\n degree " << volume.degree[0] << " " << volume.degree[1] << " " << volume.degree[2]
         << "\n ncp " << volume.count(0) << " " << volume.count(1) << " " << volume.count(2) << "\n";
    for (int d = 0; d < 3; ++d)
    {
      const std::vector<double>& knots = volume.knots[d];
      text << " " << KnotLabels[d];
      for (const double knot : knots)
      {
        text << " " << (options.unitKnots ? (knot - knots.front()) / (knots.back() - knots.front()) : knot);
      }
      text << "\n";
    }
    text << " points\n";
    const Index size = Index(volume.count(0)) * volume.count(1) * volume.count(2);
    for (Index i = 0; i < size; ++i, done += 1.0)
    {
      if (i % (1 << 16) == 0)
      {
        run.report(done / total);
      }
      text.point(volume.points + 3 * i);
    }
  }
}

std::string withoutExtension(const std::string& path)
{
  const std::size_t slash = path.rfind('/');
  const std::size_t dot = path.rfind('.');
  const std::size_t name = slash == std::string::npos ? 0 : slash + 1;
  return dot == std::string::npos || dot <= name ? path : path.substr(0, dot);
}

std::string folderOf(const std::string& path)
{
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos ? "" : path.substr(0, slash + 1);
}

} // namespace

//------------------------------------------------------------------------------
void writeQuadflow(
  const QuadflowCase& all, const std::string& path, const QuadflowOptions& options, const Execution& run)
{
  if (options.indexBase != 0 && options.indexBase != 1)
  {
    throw Error("the index base must be 0 or 1, not " + std::to_string(options.indexBase));
  }
  Text topology(path);
  writeHeader(topology, Magic, options);
  writeTopology(topology, all, options.indexBase);
  if (!options.separateGeometry)
  {
    topology << "GEOMETRY\n";
    writeGeometry(topology, all, options, run);
    topology << "end\n";
    topology.file().finish();
  }
  else
  {
    const std::string geometryPath = withoutExtension(path) + ".bsp";
    if (geometryPath == path)
    {
      throw Error("'" + path + "': the extension .bsp is that of the geometry file");
    }
    topology << "GEOMETRY file " << encoded(geometryPath.substr(folderOf(geometryPath).size())) << "\nend\n";
    topology.file().finish();
    Text geometry(geometryPath);
    writeHeader(geometry, GeometryMagic, options);
    geometry << "counts blocks " << static_cast<int>(all.blocks.size()) << "\nGEOMETRY\n";
    writeGeometry(geometry, all, options, run);
    geometry << "end\n";
    geometry.file().finish();
    run.report(1.0);
    geometry.file().publish();
  }
  run.report(1.0);
  topology.file().publish();
}

//------------------------------------------------------------------------------
namespace
{

/// Lines of a file without comments and empty ones, and the words on them.
class Lines
{
public:
  explicit Lines(const std::string& path)
    : Path(path)
    , File(std::fopen(path.c_str(), "rb"), &std::fclose)
    , Buffer(std::size_t(1) << 20)
  {
    struct stat status;
    if (!this->File || ::fstat(::fileno(this->File.get()), &status) != 0)
    {
      throw Error("Cannot open '" + path + "': " + std::strerror(errno));
    }
    if (!S_ISREG(status.st_mode))
    {
      throw Error("Cannot read '" + path + "': it is not a regular file");
    }
    this->Remaining = status.st_size;
  }

  const std::string& path() const { return this->Path; }
  int line() const { return this->Line; }
  /// Bytes after the current line.
  Index remaining() const { return this->Remaining; }

  [[noreturn]] void fail(const std::string& what) const
  {
    throw Error(this->Path + ", line " + std::to_string(this->Line) + ": " + what);
  }

  /// Goes to the next line that holds anything; `expected` says in the message what should have come.
  void next(const char* expected)
  {
    do
    {
      if (!this->nextRaw())
      {
        this->fail(std::string("the file ends, but ") + expected + " should follow");
      }
      this->skipBlanks();
    } while (this->At == this->End);
  }

  bool atEnd()
  {
    this->skipBlanks();
    return this->At == this->End;
  }

  /// Next word of the line, empty at its end.
  std::string_view word()
  {
    this->skipBlanks();
    const char* start = this->At;
    while (this->At != this->End && !isBlank(*this->At))
    {
      ++this->At;
    }
    return { start, static_cast<std::size_t>(this->At - start) };
  }

  /// The first word of the line without taking it.
  std::string_view peek()
  {
    const char* start = this->At;
    const std::string_view result = this->word();
    this->At = start;
    return result;
  }

  void expect(std::string_view text)
  {
    const std::string_view found = this->word();
    if (found != text)
    {
      this->fail("'" + std::string(text) + "' expected, '" + shown(found) + "' found");
    }
  }

  void end()
  {
    if (!this->atEnd())
    {
      this->fail("nothing more expected, '" + shown(this->word()) + "' found");
    }
  }

  int integer(const char* what, int first, int last) { return this->integer(this->word(), what, first, last); }

  int integer(std::string_view text, const char* what, int first, int last) const
  {
    int value = 0;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || stop != text.data() + text.size())
    {
      this->fail(std::string(what) + ": integer expected, '" + shown(text) + "' found");
    }
    if (value < first || value > last)
    {
      this->fail(std::string(what) + " " + std::to_string(value) +
        (last < first ? ": there are none" : " is not in " + std::to_string(first) + ".." + std::to_string(last)));
    }
    return value;
  }

  double number(const char* what)
  {
    this->skipBlanks();
    double value = 0.0;
    const auto [stop, error] = std::from_chars(this->At, this->End, value);
    if (error != std::errc() || !std::isfinite(value) || (stop != this->End && !isBlank(*stop)))
    {
      this->fail(std::string(what) + ": finite number expected, '" + shown(this->word()) + "' found");
    }
    this->At = stop;
    return value;
  }

  std::string name(const char* what)
  {
    const std::string_view text = this->word();
    if (text.empty())
    {
      this->fail(std::string(what) + " expected");
    }
    if (text == "-")
    {
      return "";
    }
    std::string result;
    for (std::size_t i = 0; i < text.size(); ++i)
    {
      if (text[i] != '%')
      {
        result += text[i];
        continue;
      }
      int byte = 0;
      const char* digits = text.data() + i + 1;
      const std::size_t left = text.size() - i - 1;
      if (left < 2 || std::from_chars(digits, digits + 2, byte, 16).ptr != digits + 2 || byte < 0)
      {
        this->fail(std::string(what) + ": '" + shown(text) + "' has a % without two hexadecimal digits");
      }
      result += static_cast<char>(byte);
      i += 2;
    }
    return result;
  }

private:
  static bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

  /// Text from the file as it can stand in a message.
  static std::string shown(std::string_view text)
  {
    std::string result(text.substr(0, 40));
    for (char& c : result)
    {
      c = std::isprint(static_cast<unsigned char>(c)) ? c : '?';
    }
    return result + (text.size() > 40 ? ".." : "");
  }

  void skipBlanks()
  {
    while (this->At != this->End && isBlank(*this->At))
    {
      ++this->At;
    }
  }

  bool nextRaw()
  {
    const char* data = this->Buffer.data();
    const char* newline = nullptr;
    std::size_t searched = 0;
    while (true)
    {
      const char* start = data + this->First;
      newline = static_cast<const char*>(std::memchr(start + searched, '\n', this->Last - this->First - searched));
      if (newline || this->Finished)
      {
        break;
      }
      searched = this->Last - this->First;
      std::memmove(this->Buffer.data(), start, searched);
      this->First = 0;
      this->Last = searched;
      if (this->Last == this->Buffer.size())
      {
        constexpr std::size_t LongestLine = std::size_t(1) << 26;
        if (this->Last >= LongestLine)
        {
          ++this->Line;
          this->fail("the line is longer than " + std::to_string(LongestLine) + " bytes");
        }
        this->Buffer.resize(2 * this->Last);
      }
      data = this->Buffer.data();
      const std::size_t read =
        std::fread(this->Buffer.data() + this->Last, 1, this->Buffer.size() - this->Last, this->File.get());
      this->Last += read;
      this->Finished = read == 0;
      if (std::ferror(this->File.get()))
      {
        throw Error("Cannot read '" + this->Path + "': " + std::strerror(errno));
      }
    }
    const char* start = data + this->First;
    const char* stop = newline ? newline : data + this->Last;
    if (!newline && start == stop)
    {
      return false;
    }
    const std::size_t taken = static_cast<std::size_t>(stop - start) + (newline ? 1 : 0);
    this->First += taken;
    this->Remaining -= static_cast<Index>(taken);
    ++this->Line;
    const char* comment = static_cast<const char*>(std::memchr(start, '#', stop - start));
    this->At = start;
    this->End = comment ? comment : stop;
    return true;
  }

  std::string Path;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> File;
  std::vector<char> Buffer;
  std::size_t First = 0;
  std::size_t Last = 0;
  bool Finished = false;
  Index Remaining = 0;
  int Line = 0;
  const char* At = nullptr;
  const char* End = nullptr;
};

constexpr int Any = std::numeric_limits<int>::max();

class QuadflowReader
{
public:
  QuadflowReader(const std::string& path, const QuadflowStorage& storage, const Execution& run)
    : Storage(storage)
    , Run(run)
    , In(path)
  {
  }

  QuadflowCase read()
  {
    this->header(this->In, Magic);
    this->counts();
    this->vertices();
    this->edges();
    this->faces();
    this->blocks();
    this->interfaces();
    this->boundaryFaces();
    this->boundaryNames();

    std::string geometryPath;
    this->In.expect("GEOMETRY");
    if (this->In.atEnd())
    {
      this->geometry(this->In);
      this->finish(this->In);
    }
    else
    {
      this->In.expect("file");
      const std::string name = this->In.name("file name");
      if (name.empty() || name == "." || name == ".." || name.find('/') != std::string::npos ||
        name.find('\0') != std::string::npos)
      {
        this->In.fail("the geometry file must lie in the same folder");
      }
      this->In.end();
      geometryPath = folderOf(this->In.path()) + name;
      Lines geometry(geometryPath);
      this->header(geometry, GeometryMagic);
      geometry.next("counts");
      geometry.expect("counts");
      geometry.expect("blocks");
      const int blocks = static_cast<int>(this->All.blocks.size());
      geometry.integer("number of blocks", blocks, blocks);
      geometry.end();
      geometry.next("GEOMETRY");
      geometry.expect("GEOMETRY");
      geometry.end();
      this->geometry(geometry);
      this->finish(geometry);
      this->In.next("end");
      this->finish(this->In, true);
    }
    checkQuadflowCase(this->All, this->In.path(), geometryPath);
    this->Run.report(1.0);
    return std::move(this->All);
  }

private:
  void header(Lines& in, const char* magic)
  {
    in.next(magic);
    in.expect(magic);
    in.expect(Version);
    in.end();
    in.next("dimension");
    in.expect("dimension");
    in.expect("3");
    in.end();
    in.next("index_base");
    in.expect("index_base");
    const int base = in.integer("index base", 0, 1);
    in.end();
    in.next("knots");
    in.expect("knots");
    const std::string_view scale = in.word();
    if (scale != "integer" && scale != "unit")
    {
      in.fail("'integer' or 'unit' expected, '" + std::string(scale.substr(0, 40)) + "' found");
    }
    const bool unit = scale == "unit";
    in.end();
    if (&in != &this->In && (base != this->Base || unit != this->UnitKnots))
    {
      in.fail("index base and knots are not those of '" + this->In.path() + "'");
    }
    this->Base = base;
    this->UnitKnots = unit;
    this->All.indexBase = base;
    in.next("cp_order");
    in.expect("cp_order");
    in.expect("ijk");
    in.end();
  }

  void counts()
  {
    this->In.next("counts");
    this->In.expect("counts");
    const auto count = [&](const char* what) {
      this->In.expect(what);
      return this->In.integer(what, 0, Any - 1);
    };
    const Index vertices = count("vertices");
    const Index edges = count("edges");
    const Index faces = count("faces");
    const Index blocks = count("blocks");
    this->In.end();
    // The shortest possible lines. The numbers are also those of memory that is asked for.
    if (8 * vertices + 15 * edges + 26 * faces + 130 * blocks > this->In.remaining())
    {
      this->In.fail("the counts need more than the " + std::to_string(this->In.remaining()) +
        " bytes that follow in the file");
    }
    this->All.vertices.resize(vertices);
    this->All.edges.resize(edges);
    this->All.faces.resize(faces);
    this->All.blocks.resize(blocks);
  }

  void section(const char* name)
  {
    this->In.next(name);
    this->In.expect(name);
    this->In.end();
  }

  /// The own id that begins a line: they count up.
  void ownId(Lines& in, std::size_t index)
  {
    const int expected = static_cast<int>(index) + this->Base;
    in.integer("id", expected, expected);
  }

  int id(Lines& in, const char* what, std::size_t count) { return this->id(in, in.word(), what, count); }
  int id(Lines& in, std::string_view text, const char* what, std::size_t count)
  {
    return in.integer(text, what, this->Base, static_cast<int>(count) + this->Base - 1) - this->Base;
  }

  void vertices()
  {
    this->section("VERTICES");
    for (std::size_t i = 0; i < this->All.vertices.size(); ++i)
    {
      QuadflowVertex& vertex = this->All.vertices[i];
      this->In.next("a vertex");
      this->ownId(this->In, i);
      for (int c = 0; c < 3; ++c)
      {
        vertex.position[c] = this->In.number("coordinate");
      }
      this->In.end();
      vertex.line = this->In.line();
    }
  }

  void edges()
  {
    this->section("EDGES");
    for (std::size_t i = 0; i < this->All.edges.size(); ++i)
    {
      QuadflowEdge& edge = this->All.edges[i];
      this->In.next("an edge");
      this->ownId(this->In, i);
      edge.vertices[0] = this->id(this->In, "vertex", this->All.vertices.size());
      edge.vertices[1] = this->id(this->In, "vertex", this->All.vertices.size());
      edge.cells = this->In.integer("number of cells", 1, Any);
      std::string_view kind = this->In.word();
      const std::size_t colon = kind.find(':');
      const std::string_view valence = colon == std::string_view::npos ? "" : kind.substr(colon + 1);
      const std::string_view name = kind.substr(0, colon);
      const auto found = std::find(std::begin(EdgeClassNames), std::end(EdgeClassNames), name);
      edge.kind = static_cast<QuadflowEdgeClass>(found - std::begin(EdgeClassNames));
      const bool known = found != std::end(EdgeClassNames);
      if (!known || (edge.kind == QuadflowEdgeClass::Extraordinary) != (colon != std::string_view::npos))
      {
        this->In.fail("'" + std::string(kind.substr(0, 40)) +
          "' is no class of an edge: regular, boundary, extraordinary:<valence>, crease, planar");
      }
      if (edge.kind == QuadflowEdgeClass::Extraordinary)
      {
        edge.valence = this->In.integer(valence, "valence", 1, Any);
      }
      this->In.end();
      edge.line = this->In.line();
    }
  }

  void faces()
  {
    this->section("FACES");
    for (std::size_t i = 0; i < this->All.faces.size(); ++i)
    {
      QuadflowFace& face = this->All.faces[i];
      this->In.next("a face");
      this->ownId(this->In, i);
      for (int& vertex : face.vertices)
      {
        vertex = this->id(this->In, "vertex", this->All.vertices.size());
      }
      for (int& edge : face.edges)
      {
        edge = this->id(this->In, "edge", this->All.edges.size());
      }
      face.cells[0] = this->In.integer("number of cells", 1, Any);
      face.cells[1] = this->In.integer("number of cells", 1, Any);
      face.blocks = this->In.integer("number of blocks", 1, 2);
      face.boundary = this->In.integer("boundary", 0, Any);
      this->In.end();
      face.line = this->In.line();
    }
  }

  void blocks()
  {
    this->section("BLOCKS");
    for (std::size_t i = 0; i < this->All.blocks.size(); ++i)
    {
      QuadflowBlock& block = this->All.blocks[i];
      this->In.next("a block");
      this->In.expect("block");
      this->ownId(this->In, i);
      this->In.expect("type");
      this->In.expect("BSPLINE");
      this->In.expect("cells");
      for (int& cells : block.cells)
      {
        cells = this->In.integer("number of cells", 1, Any - MaxDegree);
      }
      this->In.expect("zone");
      block.name = this->In.name("name");
      this->In.end();
      block.line = this->In.line();

      this->In.next("v");
      this->In.expect("v");
      for (int& vertex : block.vertices)
      {
        vertex = this->id(this->In, "vertex", this->All.vertices.size());
      }
      this->In.end();
      this->In.next("e");
      this->In.expect("e");
      for (int e = 0; e < 12; ++e)
      {
        const auto [edge, sign] = this->pair("edge:sign");
        if (sign != "+1" && sign != "-1")
        {
          this->In.fail("edge:sign: +1 or -1 expected, '" + std::string(sign.substr(0, 40)) + "' found");
        }
        block.edges[e] = this->id(this->In, edge, "edge", this->All.edges.size());
        block.edgeReversed[e] = sign == "-1";
      }
      this->In.end();
      this->In.next("f");
      this->In.expect("f");
      for (int f = 0; f < 6; ++f)
      {
        const auto [face, orientation] = this->pair("face:orientation");
        block.faces[f] = this->id(this->In, face, "face", this->All.faces.size());
        block.faceOrientations[f] = this->In.integer(orientation, "orientation", 0, 7);
      }
      this->In.end();
    }
  }

  std::pair<std::string_view, std::string_view> pair(const char* what)
  {
    const std::string_view text = this->In.word();
    const std::size_t colon = text.find(':');
    if (colon == std::string_view::npos)
    {
      this->In.fail(std::string(what) + " expected, '" + std::string(text.substr(0, 40)) + "' found");
    }
    return { text.substr(0, colon), text.substr(colon + 1) };
  }

  void interfaces()
  {
    this->section("CONNECTIVITY");
    for (this->In.next("BOUNDARY"); this->In.peek() != "BOUNDARY"; this->In.next("BOUNDARY"))
    {
      QuadflowInterface entry;
      Interface& c = entry.contact;
      c.blockA = this->id(this->In, "block", this->All.blocks.size());
      c.faceA = this->In.integer("face", 0, 5);
      c.blockB = this->id(this->In, "block", this->All.blocks.size());
      c.faceB = this->In.integer("face", 0, 5);
      c.orientation = this->In.integer("orientation", 0, 7);
      for (int& direction : entry.transform)
      {
        direction = this->In.integer("transform", -3, 3);
      }
      this->In.end();
      entry.line = this->In.line();
      this->All.interfaces.push_back(entry);
    }
    this->In.expect("BOUNDARY");
    this->In.end();
  }

  void boundaryFaces()
  {
    for (this->In.next("BCTABLE"); this->In.peek() != "BCTABLE"; this->In.next("BCTABLE"))
    {
      QuadflowBoundaryFace face;
      face.block = this->id(this->In, "block", this->All.blocks.size());
      face.face = this->In.integer("face", 0, 5);
      face.boundary = this->In.integer("boundary", 0, Any);
      this->In.end();
      face.line = this->In.line();
      this->All.boundaryFaces.push_back(face);
    }
    this->In.expect("BCTABLE");
    this->In.end();
  }

  void boundaryNames()
  {
    for (this->In.next("GEOMETRY"); this->In.peek() != "GEOMETRY"; this->In.next("GEOMETRY"))
    {
      QuadflowBoundaryName boundary;
      boundary.id = this->In.integer("boundary", 1, Any);
      boundary.name = this->In.name("name");
      this->In.end();
      boundary.line = this->In.line();
      this->All.boundaryNames.push_back(boundary);
    }
  }

  void geometry(Lines& in)
  {
    const double total = static_cast<double>(in.remaining()) + 1.0;
    for (std::size_t b = 0; b < this->All.blocks.size(); ++b)
    {
      QuadflowBlock& block = this->All.blocks[b];
      BSplineVolume& volume = block.volume;
      in.next("a block");
      in.expect("block");
      this->ownId(in, b);
      in.end();
      in.next("degree");
      in.expect("degree");
      for (int& degree : volume.degree)
      {
        degree = in.integer("degree", 1, MaxDegree);
      }
      in.end();
      in.next("ncp");
      in.expect("ncp");
      std::array<int, 3> counts{};
      // "0 0 0" and a line end, which the last line of the file may lack.
      const Index room = (in.remaining() + 1) / 6;
      Index size = 1;
      for (int d = 0; d < 3; ++d)
      {
        counts[d] = in.integer("number of control points", volume.degree[d] + 1, Any - 2 * MaxDegree);
        size = size > room / counts[d] ? room + 1 : size * counts[d];
      }
      in.end();
      if (size > room)
      {
        in.fail("block " + std::to_string(b + this->Base) + ": the control points need more than the " +
          std::to_string(in.remaining()) + " bytes that follow in the file");
      }
      for (int d = 0; d < 3; ++d)
      {
        this->knots(in, d, counts[d], block);
      }
      in.next("points");
      in.expect("points");
      in.end();
      double* points = this->Storage(static_cast<int>(b), counts);
      volume.points = points;
      for (Index i = 0; i < size; ++i)
      {
        if (i % (1 << 16) == 0)
        {
          this->Run.report(std::max(0.0, 1.0 - static_cast<double>(in.remaining()) / total));
        }
        in.next("a control point");
        if (i == 0)
        {
          block.pointsLine = in.line();
        }
        for (int c = 0; c < 3; ++c)
        {
          *points++ = in.number("coordinate");
        }
        in.end();
      }
    }
    for (QuadflowInterface& entry : this->All.interfaces)
    {
      Interface& c = entry.contact;
      const BSplineVolume& volume = this->All.blocks[c.blockA].volume;
      c.rangeA.hi = { volume.count(faceAxis(c.faceA, 0)) - 1, volume.count(faceAxis(c.faceA, 1)) - 1 };
    }
  }

  void knots(Lines& in, int d, int count, QuadflowBlock& block)
  {
    in.next(KnotLabels[d]);
    in.expect(KnotLabels[d]);
    std::vector<double>& knots = block.volume.knots[d];
    const std::size_t expected = static_cast<std::size_t>(count) + block.volume.degree[d] + 1;
    while (!in.atEnd())
    {
      knots.push_back(in.number("knot"));
    }
    if (knots.size() != expected)
    {
      in.fail("block " + std::to_string(&block - this->All.blocks.data() + this->Base) + ": " +
        std::to_string(knots.size()) + " knots instead of " + std::to_string(expected));
    }
    const double cells = block.cells[d];
    for (double& knot : knots)
    {
      if (this->UnitKnots)
      {
        // Integer knots divided by their number come back as integers.
        const double nearest = std::round(knot * cells);
        const double slack = 4.0 * std::numeric_limits<double>::epsilon() * cells;
        knot = std::abs(knot * cells - nearest) <= slack ? nearest : knot * cells;
      }
    }
  }

  void finish(Lines& in, bool atLine = false)
  {
    if (!atLine)
    {
      in.next("end");
    }
    in.expect("end");
    in.end();
  }

  QuadflowStorage Storage;
  Execution Run;
  Lines In;
  int Base = 0;
  bool UnitKnots = false;
  QuadflowCase All;
};

} // namespace

QuadflowCase readQuadflow(const std::string& path, const QuadflowStorage& storage, const Execution& run)
{
  return QuadflowReader(path, storage, run).read();
}

} // namespace bsv
