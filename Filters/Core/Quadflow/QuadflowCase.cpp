// SPDX-License-Identifier: BSD-3-Clause
#include "Quadflow/QuadflowCase.h"

#include "Base/Numbers.h"
#include "Mesh/PointExchange.h"
#include "Mesh/SharedEntities.h"
#include "Volume/ControlPointRule.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <set>

namespace bsv
{

namespace
{

std::string faceName(int block, int face)
{
  return "block " + std::to_string(block) + ", face " + std::to_string(face);
}

Index offsetOf(const BSplineVolume& volume, const Ijk& i)
{
  return i[0] + volume.count(0) * (i[1] + Index(volume.count(1)) * i[2]);
}

std::string pointName(const Ijk& i)
{
  return "(" + std::to_string(i[0]) + ", " + std::to_string(i[1]) + ", " + std::to_string(i[2]) + ")";
}

bool sameBits(const Vec3& a, const Vec3& b)
{
  return std::memcmp(a.data(), b.data(), 3 * sizeof(double)) == 0;
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

/// The control points of all blocks, of those on other ranks only some faces.
class ControlPoints
{
public:
  /// A face of a block, as 6 * block + face.
  using Face = int;

  /// Collective. @param faces that are read here of blocks on other ranks; a process that is alone gets none.
  ControlPoints(const std::vector<const BSplineVolume*>& volumes, const std::set<Face>& faces, const Ranks& ranks)
    : Volumes(volumes)
  {
    for (const BSplineVolume* volume : volumes)
    {
      const Ijk counts{ volume->count(0), volume->count(1), volume->count(2) };
      this->Views.push_back(volume->points ? GridView(volume->points, counts) : GridView::elsewhere(counts));
    }
    if (ranks.size() == 1)
    {
      return;
    }
    this->Fetched = faces;
    std::vector<PointBox> boxes;
    for (const Face f : faces)
    {
      const BSplineVolume& volume = *volumes[f / 6];
      PointBox box{ f / 6, onFace(volume, f % 6, 0, 0), {} };
      box.hi = onFace(volume, f % 6, volume.count(faceAxis(f % 6, 0)) - 1, volume.count(faceAxis(f % 6, 1)) - 1);
      boxes.push_back(box);
    }
    this->Memory = fetchPoints(
      boxes, static_cast<int>(volumes.size()), [&](int block) { return volumes[block]->rank; },
      [this](int block) -> GridView& { return this->Views[block]; }, ranks);
  }
  const BSplineVolume& volume(int block) const { return *this->Volumes[block]; }
  const GridView& operator[](int block) const { return this->Views[block]; }
  bool knows(int block, int face) const
  {
    return this->Views[block].isHere() || this->Fetched.count(6 * block + face) > 0;
  }

private:
  const std::vector<const BSplineVolume*>& Volumes;
  std::set<Face> Fetched;
  std::vector<GridView> Views;
  std::vector<std::shared_ptr<PointBoxes>> Memory;
};

/// The control points at the eight corners of every block, on all ranks.
std::vector<std::array<Vec3, 8>> cornerPoints(const std::vector<const BSplineVolume*>& volumes, const Ranks& ranks)
{
  std::vector<std::array<Triple, 8>> corners(volumes.size());
  for (std::size_t b = 0; b < volumes.size(); ++b)
  {
    for (int corner = 0; volumes[b]->rank == ranks.rank() && corner < 8; ++corner)
    {
      const Index at = offsetOf(*volumes[b], cornerPoint(*volumes[b], corner));
      std::copy_n(volumes[b]->points + 3 * at, 3, corners[b][corner].data());
    }
  }
  ranks.share(corners, [&](Index b) { return volumes[b]->rank; });
  std::vector<std::array<Vec3, 8>> result(volumes.size());
  for (std::size_t b = 0; b < volumes.size(); ++b)
  {
    std::transform(corners[b].begin(), corners[b].end(), result[b].begin(), vec3);
  }
  return result;
}

/// Why two faces do not meet, or nothing. Points that are not known are not compared.
std::string difference(const ControlPoints& points, int blockA, int faceA, int blockB, int faceB, int orientation)
{
  const BSplineVolume& a = points.volume(blockA);
  const BSplineVolume& b = points.volume(blockB);
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
  const bool known = points.knows(blockA, faceA) && points.knows(blockB, faceB);
  for (int t = 0; known && t <= nt; ++t)
  {
    for (int s = 0; s <= ns; ++s)
    {
      const auto m = mapFacePoint(orientation, s, t, ns, nt);
      const Ijk iA = onFace(a, faceA, s, t);
      const Ijk iB = onFace(b, faceB, m[0], m[1]);
      if (!sameBits(points[blockA](iA), points[blockB](iB)))
      {
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
std::vector<Interface> findInterfaces(const std::vector<BSplineVolume>& volumes,
  const std::vector<const BSplineVolume*>& pointers, const std::vector<std::array<Vec3, 8>>& corners,
  const Ranks& ranks)
{
  using Key = std::array<std::array<std::uint64_t, 3>, 4>;
  std::map<Key, std::vector<int>> candidates; // by the corners, in any order
  for (int f = 0; f < 6 * static_cast<int>(volumes.size()); ++f)
  {
    Key key;
    for (int c = 0; c < 4; ++c)
    {
      std::memcpy(key[c].data(), corners[f / 6][faceCorner(f % 6, c & 1, c >> 1)].data(), sizeof(key[c]));
    }
    std::sort(key.begin(), key.end());
    candidates[key].push_back(f);
  }

  // The rank of the first face of a pair looks at all its points.
  struct Match
  {
    std::size_t pair;
    unsigned orientations; ///< bit per code
  };
  std::vector<std::array<int, 2>> pairs;
  std::set<int> wanted;
  for (const auto& [key, faces] : candidates)
  {
    for (std::size_t x = 0; x < faces.size(); ++x)
    {
      for (std::size_t y = x + 1; y < faces.size(); ++y)
      {
        pairs.push_back({ faces[x], faces[y] });
        if (volumes[faces[x] / 6].rank == ranks.rank())
        {
          wanted.insert(faces[y]);
        }
      }
    }
  }
  const ControlPoints points(pointers, wanted, ranks);
  std::vector<Match> matches;
  for (std::size_t p = 0; p < pairs.size(); ++p)
  {
    const auto [a, b] = pairs[p];
    unsigned found = 0;
    for (int o = 0; volumes[a / 6].rank == ranks.rank() && o < 8; ++o)
    {
      const bool same = difference(points, a / 6, a % 6, b / 6, b % 6, o).empty();
      found |= same ? 1u << o : 0u;
    }
    if (found != 0)
    {
      matches.push_back({ p, found });
    }
  }
  matches = ranks.gatherAll(matches);
  std::sort(matches.begin(), matches.end(), [](const Match& x, const Match& y) { return x.pair < y.pair; });

  std::vector<Interface> interfaces;
  std::set<int> taken;
  for (const Match& match : matches)
  {
    const auto [a, b] = pairs[match.pair];
    for (int o = 0; o < 8; ++o)
    {
      if ((match.orientations & 1u << o) == 0)
      {
        continue;
      }
      if (!taken.insert(a).second || !taken.insert(b).second)
      {
        throw Error(
          faceName(a / 6, a % 6) + " meets " + faceName(b / 6, b % 6) + " and more; the interfaces must be given");
      }
      interfaces.push_back(wholeFaces(volumes, a / 6, a % 6, b / 6, b % 6, o));
    }
  }
  std::sort(interfaces.begin(), interfaces.end(), [](const Interface& a, const Interface& b) {
    return std::make_pair(a.blockA, a.faceA) < std::make_pair(b.blockA, b.faceA);
  });
  return interfaces;
}

/// @param given classes of the block's edges, or null
QuadflowEdgeClass edgeClass(
  const SharedEntities::Edge& edge, const BSplineVolume& volume, const unsigned char* rules, const unsigned char* given)
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
    const auto rule = static_cast<ControlPointRule>(rules[offsetOf(volume, i)]);
    crease = crease || rule == ControlPointRule::Crease;
    planar = planar || rule == ControlPointRule::PlanarSide;
    other = other || (rule != ControlPointRule::PlanarSide && rule != ControlPointRule::Corner);
  }
  if (!rules && given)
  {
    const auto kind = static_cast<QuadflowEdgeClass>(given[edge.edge]);
    crease = kind == QuadflowEdgeClass::Crease;
    planar = kind == QuadflowEdgeClass::Planar;
  }
  return edge.boundary && crease ? QuadflowEdgeClass::Crease
    : planar && !other           ? QuadflowEdgeClass::Planar
    : edge.boundary              ? QuadflowEdgeClass::Boundary
                                 : QuadflowEdgeClass::Regular;
}

/// Of all edges; the rank of the block that names an edge first has its rules.
std::vector<QuadflowEdgeClass> edgeClasses(
  const std::vector<SharedEntities::Edge>& edges, const QuadflowInput& input, const Ranks& ranks)
{
  std::vector<QuadflowEdgeClass> result(edges.size());
  for (std::size_t e = 0; e < edges.size(); ++e)
  {
    const int block = edges[e].block;
    if (input.volumes[block].rank == ranks.rank())
    {
      result[e] = edgeClass(edges[e], input.volumes[block], input.rules.empty() ? nullptr : input.rules[block],
        input.edgeClasses.empty() ? nullptr : input.edgeClasses[block]);
    }
  }
  ranks.share(result, [&](Index e) { return input.volumes[edges[e].block].rank; });
  return result;
}

std::vector<QuadflowBoundaryName> numberedBoundaries(const QuadflowInput& input)
{
  std::map<std::string, int> given;
  std::set<int> used;
  for (const auto& [name, id] : input.boundaryIds)
  {
    if (id < 1)
    {
      throw Error("Boundary Ids: the id " + std::to_string(id) + " of '" + name + "' is not positive");
    }
    if (!given.emplace(name, id).second || !used.insert(id).second)
    {
      throw Error("Boundary Ids: '" + name + "' or its id " + std::to_string(id) + " is given twice");
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
QuadflowCase makeQuadflowCase(const QuadflowInput& input, const Execution& run)
{
  const Ranks& ranks = *run.ranks;
  const int blocks = static_cast<int>(input.volumes.size());
  const auto label = [&](int block) { return "block " + std::to_string(block) + " '" + input.names[block] + "'"; };
  for (int b = 0; b < blocks; ++b)
  {
    const BSplineVolume& volume = input.volumes[b];
    checkBSplineVolume(volume, label(b));
    if (volume.rank != ranks.rank())
    {
      continue;
    }
    for (const double* x = volume.points;
         x != volume.points + 3 * Index(volume.count(0)) * volume.count(1) * volume.count(2); ++x)
    {
      if (!std::isfinite(*x))
      {
        throw ErrorAt(b, label(b) + ": control point " + std::to_string((x - volume.points) / 3) + " is not finite");
      }
    }
  }
  std::vector<const BSplineVolume*> volumes;
  for (const BSplineVolume& volume : input.volumes)
  {
    volumes.push_back(&volume);
  }
  const std::vector<std::array<Vec3, 8>> corners = cornerPoints(volumes, ranks);

  QuadflowCase all;
  std::vector<Interface> contacts = input.interfaces;
  if (!input.hasInterfaces)
  {
    contacts = findInterfaces(input.volumes, volumes, corners, ranks);
  }
  for (Interface& contact : contacts)
  {
    contact =
      wholeFaces(input.volumes, contact.blockA, contact.faceA, contact.blockB, contact.faceB, contact.orientation);
    all.interfaces.push_back({ contact, cgnsTransform(contact.faceA, contact.faceB, contact.orientation) });
  }
  const SharedEntities entities = sharedEntities(blocks, contacts, label);

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
    for (int e = 0; e < 12; ++e)
    {
      // Edges of the format run from the vertex with the lower id.
      const auto& ends = entities.edges[shared.edges[e]].vertices;
      block.edgeReversed[e] = shared.edgeReversed[e] != (ends[0] > ends[1]);
    }
    block.faces = shared.faces;
    block.faceOrientations = shared.faceOrientations;
    for (int corner = 0; corner < 8; ++corner)
    {
      all.vertices[block.vertices[corner]].position = corners[b][corner];
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
  const std::vector<QuadflowEdgeClass> kinds = edgeClasses(entities.edges, input, ranks);
  for (std::size_t e = 0; e < entities.edges.size(); ++e)
  {
    const SharedEntities::Edge& shared = entities.edges[e];
    QuadflowEdge edge;
    const auto ends = std::minmax(shared.vertices[0], shared.vertices[1]);
    edge.vertices = { ends.first, ends.second };
    edge.cells = all.blocks[shared.block].cells[edgeDirection(shared.edge)];
    edge.kind = kinds[e];
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
  checkQuadflowCase(all, "", "", run);
  return all;
}

//------------------------------------------------------------------------------
namespace
{

/// The checks of checkQuadflowCase(), in the order in which they rest on each other.
class CaseCheck
{
public:
  CaseCheck(const QuadflowCase& all, const std::string& file, const std::string& geometryFile, const Execution& run)
    : All(all)
    , RankGroup(*run.ranks)
    , File(file)
    , GeometryFile(geometryFile.empty() ? file : geometryFile)
  {
  }

  void run()
  {
    this->boundaryNames();
    this->geometry();
    this->everyFaceOnce();
    this->contacts();
    const SharedEntities entities = this->derivedEntities();
    this->sameNumbering(entities);
    this->blocks();
    this->edges(entities);
    this->faces(entities);
    this->corners();
    this->orientations();
  }

private:
  /// @param place of an error that not all ranks meet, for ErrorAt
  [[noreturn]] void fail(int line, const std::string& what, bool inGeometry = false, Index place = 0) const
  {
    const std::string& file = inGeometry ? this->GeometryFile : this->File;
    std::string where = file.empty() ? "" : file + ", ";
    where += line > 0 ? "line " + std::to_string(line) + ": " : "";
    throw ErrorAt(place, where + what);
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
        this->fail(
          face.line, this->faceName(face.block, face.face) + ": there is no boundary " + std::to_string(face.boundary));
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
            name + ": the knots of direction " + std::to_string(d) +
              " are not clamped; the corners would not be vertices",
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
      return sharedEntities(
        static_cast<int>(this->All.blocks.size()), contacts, [this](int block) { return this->blockName(block); });
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
        this->fail(this->All.countsLine,
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
              this->blockName(b) + ": " + what + ", entry " + std::to_string(i) +
                ", does not agree with the interfaces");
          }
          forward = actual[i];
          backward = expected[i];
        }
      }
    };
    compare(
      "vertices", entities.vertices, this->All.vertices.size(),
      [](const auto& block) -> const auto& { return block.vertices; },
      [](const auto& block) -> const auto& { return block.vertices; });
    compare(
      "edges", entities.edges.size(), this->All.edges.size(),
      [](const auto& block) -> const auto& { return block.edges; },
      [](const auto& block) -> const auto& { return block.edges; });
    compare(
      "faces", entities.faces.size(), this->All.faces.size(),
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
              name + ", face " + std::to_string(f) + ": its cells are not those of face " + this->id(block.faces[f]));
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
          : derived.uses == 4 ? edge.kind == QuadflowEdgeClass::Regular || planar
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

  /// By the rank that has the block.
  void corners() const
  {
    for (std::size_t b = 0; b < this->All.blocks.size(); ++b)
    {
      const QuadflowBlock& block = this->All.blocks[b];
      for (int corner = 0; corner < 8 && this->isHere(b); ++corner)
      {
        const QuadflowVertex& vertex = this->All.vertices[block.vertices[corner]];
        const Index at = offsetOf(block.volume, cornerPoint(block.volume, corner));
        if (!sameBits(vertex.position, Eigen::Map<const Vec3>(block.volume.points + 3 * at)))
        {
          this->fail(vertex.line,
            "vertex " + this->id(block.vertices[corner]) + " is not the control point at corner " +
              std::to_string(corner) + " of " + this->blockName(b),
            false, static_cast<Index>(b));
        }
      }
    }
    this->RankGroup.nextStep();
  }

  /// The two sides of every interface are equal. By the rank that has block A.
  void contacts() const
  {
    std::vector<const BSplineVolume*> volumes;
    for (const QuadflowBlock& block : this->All.blocks)
    {
      volumes.push_back(&block.volume);
    }
    std::set<int> wanted;
    for (const QuadflowInterface& entry : this->All.interfaces)
    {
      if (this->isHere(entry.contact.blockA))
      {
        wanted.insert(6 * entry.contact.blockB + entry.contact.faceB);
      }
    }
    const ControlPoints points(volumes, wanted, this->RankGroup);
    for (const QuadflowInterface& entry : this->All.interfaces)
    {
      const Interface& c = entry.contact;
      const std::string what = difference(points, c.blockA, c.faceA, c.blockB, c.faceB, c.orientation);
      if (!what.empty())
      {
        this->fail(entry.line, this->interfaceName(c) + what, false, &entry - this->All.interfaces.data());
      }
    }
    this->RankGroup.nextStep();
  }

  bool isHere(std::size_t block) const { return this->All.blocks[block].volume.points != nullptr; }

  /// The two blocks of every interface see their common face in orientations that agree.
  void orientations() const
  {
    for (const QuadflowInterface& entry : this->All.interfaces)
    {
      const Interface& c = entry.contact;
      const int oA = this->All.blocks[c.blockA].faceOrientations[c.faceA];
      const int oB = this->All.blocks[c.blockB].faceOrientations[c.faceB];
      for (int corner = 0; corner < 4; ++corner)
      {
        const auto a = mapFacePoint(oA, corner & 1, corner >> 1, 1, 1);
        if (mapFacePoint(c.orientation, a[0], a[1], 1, 1) != mapFacePoint(oB, corner & 1, corner >> 1, 1, 1))
        {
          this->fail(
            entry.line, this->interfaceName(c) + "the blocks give their common face orientations that do not agree");
        }
      }
    }
  }

  std::string interfaceName(const Interface& c) const
  {
    return this->faceName(c.blockA, c.faceA) + " and " + this->faceName(c.blockB, c.faceB) + " in orientation " +
      std::to_string(c.orientation) + ": ";
  }

  const QuadflowCase& All;
  const Ranks& RankGroup;
  const std::string& File;
  std::string GeometryFile;
};

} // namespace

void checkQuadflowCase(
  const QuadflowCase& all, const std::string& file, const std::string& geometryFile, const Execution& run)
{
  CaseCheck(all, file, geometryFile, run).run();
}

} // namespace bsv
