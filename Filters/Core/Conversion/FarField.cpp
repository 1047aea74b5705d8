// SPDX-License-Identifier: BSD-3-Clause
#include "Conversion/FarField.h"

#include "Base/CanonicalOrder.h"
#include "Base/Numbers.h"
#include "Base/OrderFreeSum.h"
#include "Complex/FacePoints.h"
#include "Ranks/OwnedValues.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace bsv
{
namespace
{

/// Sine of the angle by which the sides of a cuboid may miss right angles.
constexpr double AngleTolerance = 1e-3;

struct Plane
{
  Vec3 origin;
  Vec3 normal;

  double height(const Vec3& x) const { return this->normal.dot(x - this->origin); }
};

class FarFieldSearch
{
public:
  /// This and the methods that are not const are collective.
  FarFieldSearch(const BlockComplex& complex, const ConversionOptions& options, const Ranks& ranks)
    : Complex(complex)
    , Options(options)
    , Processes(ranks)
  {
    Eigen::AlignedBox3d box;
    const auto cornerOf = [&](std::size_t vertex) { return complex.vertices[vertex].corners.front(); };
    const std::vector<Triple> vertices = gatherFromOwners<Triple>(
      ranks, complex.vertices.size(), [&](std::size_t v) { return complex.blocks[cornerOf(v).block].rank; },
      [&](std::size_t v) {
        const ComplexBlock& owner = complex.blocks[cornerOf(v).block];
        Ijk ijk;
        for (int d = 0; d < 3; ++d)
        {
          ijk[d] = cornerSide(cornerOf(v).corner, d) ? owner.cells(d) : 0;
        }
        const Vec3 x = owner.points(ijk);
        return triple(x);
      });
    for (const Triple& x : vertices)
    {
      this->Vertices.emplace_back(x[0], x[1], x[2]);
      box.extend(this->Vertices.back());
    }
    this->Tolerance = options.planarTolerance * (box.isEmpty() ? 0.0 : box.diagonal().norm());
    for (const ComplexFace& face : complex.faces)
    {
      if (face.boundary() && roleOf(options, face) == BoundaryRole::Body)
      {
        this->BodyFaces.push_back(face.uses.front());
      }
    }
  }

  std::vector<FarFieldSide> automatic()
  {
    if (this->BodyFaces.empty())
    {
      return {};
    }
    std::vector<int> inner;
    for (std::size_t f = 0; f < this->Complex.faces.size(); ++f)
    {
      if (!this->Complex.faces[f].boundary())
      {
        inner.push_back(static_cast<int>(f));
      }
    }
    std::vector<FacesInPlane> cuts;
    for (FacesInPlane& tested : this->planesOf(inner))
    {
      if (this->orient(tested.plane))
      {
        cuts.push_back(std::move(tested));
      }
    }
    const std::vector<bool> behind = this->bodyIsBehind(cuts);
    std::vector<Candidate> candidates;
    for (std::size_t i = 0; i < cuts.size(); ++i)
    {
      if (behind[i])
      {
        candidates.push_back(this->cut(cuts[i]));
        if (candidates.back().side.faces.empty())
        {
          candidates.pop_back();
        }
      }
    }
    std::vector<Candidate> chosen = this->outermost(candidates);
    if (!this->hasIrregularEdge(chosen) || !this->isCuboid(chosen))
    {
      return {};
    }
    return this->finish(std::move(chosen));
  }

  std::vector<FarFieldSide> named()
  {
    const auto isNamed = [&](const FaceUse& use) {
      const int parent = this->Complex.blocks[use.block].parent;
      return parent < static_cast<int>(this->Options.extensionBlocks.size()) && this->Options.extensionBlocks[parent];
    };
    std::vector<int> borders;
    for (std::size_t f = 0; f < this->Complex.faces.size(); ++f)
    {
      const ComplexFace& face = this->Complex.faces[f];
      if (!face.boundary() && isNamed(face.uses[0]) != isNamed(face.uses[1]))
      {
        borders.push_back(static_cast<int>(f));
      }
    }
    std::vector<Candidate> candidates;
    for (FacesInPlane& found : this->planesOf(borders))
    {
      Plane& plane = found.plane;
      // Outwards: away from the body, or else to the larger area of named blocks.
      double bodyLow = 0.0, bodyHigh = 0.0;
      for (const FaceUse& body : this->BodyFaces)
      {
        for (int c = 0; c < 4; ++c)
        {
          const double height = plane.height(this->corner(body.block, faceCorner(body.face, c & 1, c >> 1)));
          bodyLow = std::min(bodyLow, height);
          bodyHigh = std::max(bodyHigh, height);
        }
      }
      double votes = 0.0;
      for (const int border : borders)
      {
        if (found.holds(border))
        {
          const ComplexFace& other = this->Complex.faces[border];
          const FaceUse& outer = other.uses[isNamed(other.uses[0]) ? 0 : 1];
          votes += this->blockHeight(outer.block, plane) > 0.0 ? this->area(outer) : -this->area(outer);
        }
      }
      const bool flip = bodyHigh != bodyLow ? bodyHigh > -bodyLow : votes < 0.0;
      plane.normal = flip ? Vec3(-plane.normal) : plane.normal;
      candidates.push_back(this->cut(found));
    }
    if (candidates.empty())
    {
      throw Error("Extension Blocks: none of the named blocks is attached to another block in a plane");
    }
    return this->finish(std::move(candidates));
  }

private:
  struct FacesInPlane
  {
    Plane plane;
    /// All global faces whose points lie in it, ascending.
    std::vector<int> faces;

    bool holds(int face) const { return std::binary_search(this->faces.begin(), this->faces.end(), face); }
  };

  struct Candidate
  {
    FacesInPlane cut;
    FarFieldSide side;
    /// Per block: beyond the plane.
    std::vector<char> outside;
  };

  const Vec3& corner(int block, int corner) const
  {
    return this->Vertices[this->Complex.blocks[block].vertices[corner]];
  }

  int ownerOf(int face) const { return this->Complex.blocks[this->Complex.faces[face].uses.front().block].rank; }

  std::array<Vec3, 4> corners(const FaceUse& use) const
  {
    std::array<Vec3, 4> x;
    for (int c = 0; c < 4; ++c)
    {
      x[c] = this->corner(use.block, faceCorner(use.face, c & 1, c >> 1));
    }
    return x;
  }

  double area(const FaceUse& use) const
  {
    const std::array<Vec3, 4> x = this->corners(use);
    return (x[3] - x[0]).cross(x[2] - x[1]).norm();
  }

  /// Plane through the corners of a face; its normal is zero if they span none.
  Plane planeOf(const FaceUse& use) const
  {
    const std::array<Vec3, 4> x = this->corners(use);
    const Vec3 normal = (x[3] - x[0]).cross(x[2] - x[1]);
    const double length = normal.norm();
    return { 0.25 * (x[0] + x[1] + x[2] + x[3]), length > 0.0 ? Vec3(normal / length) : Vec3(Vec3::Zero()) };
  }

  bool cornersLieIn(const FaceUse& use, const Plane& plane) const
  {
    const std::array<Vec3, 4> x = this->corners(use);
    return std::all_of(
      x.begin(), x.end(), [&](const Vec3& corner) { return std::abs(plane.height(corner)) <= this->Tolerance; });
  }

  bool pointsLieIn(const FaceUse& use, const Plane& plane) const
  {
    bool inside = true;
    forFacePoints(
      this->Complex, use, [&](const Vec3& x) { inside = inside && std::abs(plane.height(x)) <= this->Tolerance; });
    return inside;
  }

  /// Planes through the corners of faces that lie in them: those of `faces` for which neither `known` nor an earlier
  /// one will do. What they hold of all faces of the complex is found for many planes at once.
  std::vector<FacesInPlane> planesOf(std::vector<int> faces, const std::vector<FacesInPlane>& known = {})
  {
    const auto useOf = [&](int face) { return this->Complex.faces[face].uses.front(); };
    std::vector<char> covered(this->Complex.faces.size(), 0);
    const auto cover = [&](const FacesInPlane& entry) {
      for (const int face : entry.faces)
      {
        covered[face] = 1;
      }
    };
    std::for_each(known.begin(), known.end(), cover);
    const std::vector<char> flat = gatherFromOwners<char>(
      this->Processes, faces.size(), [&](std::size_t i) { return this->ownerOf(faces[i]); },
      [&](std::size_t i) {
        const Plane own = this->planeOf(useOf(faces[i]));
        return !own.normal.isZero() && this->cornersLieIn(useOf(faces[i]), own) &&
          this->pointsLieIn(useOf(faces[i]), own);
      });
    std::vector<int> open;
    for (std::size_t i = 0; i < faces.size(); ++i)
    {
      if (flat[i])
      {
        open.push_back(faces[i]);
      }
    }
    std::vector<FacesInPlane> result;
    while (!open.empty())
    {
      // A face with its corners in a plane of this round waits for what is found of it.
      const std::size_t first = result.size();
      std::vector<int> waiting;
      for (const int face : open)
      {
        if (covered[face])
        {
          continue;
        }
        const bool waits = std::any_of(result.begin() + first, result.end(),
          [&](const FacesInPlane& entry) { return this->cornersLieIn(useOf(face), entry.plane); });
        if (waits)
        {
          waiting.push_back(face);
        }
        else
        {
          result.push_back({ this->planeOf(useOf(face)), {} });
        }
      }
      struct Pair
      {
        std::size_t plane;
        int face;
      };
      std::vector<Pair> pairs;
      for (std::size_t p = first; p < result.size(); ++p)
      {
        for (int face = 0; face < static_cast<int>(this->Complex.faces.size()); ++face)
        {
          if (this->cornersLieIn(useOf(face), result[p].plane))
          {
            pairs.push_back({ p, face });
          }
        }
      }
      const std::vector<char> lies = gatherFromOwners<char>(
        this->Processes, pairs.size(), [&](std::size_t i) { return this->ownerOf(pairs[i].face); },
        [&](std::size_t i) { return this->pointsLieIn(useOf(pairs[i].face), result[pairs[i].plane].plane); });
      for (std::size_t i = 0; i < pairs.size(); ++i)
      {
        if (lies[i])
        {
          result[pairs[i].plane].faces.push_back(pairs[i].face);
        }
      }
      std::for_each(result.begin() + first, result.end(), cover);
      open = std::move(waiting);
    }
    return result;
  }

  double blockHeight(int block, const Plane& plane) const
  {
    double height = 0.0;
    for (const int vertex : this->Complex.blocks[block].vertices)
    {
      height += plane.height(this->Vertices[vertex]);
    }
    return height;
  }

  /// Turns the plane's normal away from the corners of the body. False if one touches it, or they or a block cross it.
  bool orient(Plane& plane) const
  {
    bool below = false, above = false, touches = false;
    for (const FaceUse& body : this->BodyFaces)
    {
      for (const Vec3& x : this->corners(body))
      {
        const double height = plane.height(x);
        touches = touches || !(std::abs(height) > this->Tolerance);
        (height > 0.0 ? above : below) = true;
      }
      if (touches || (below && above))
      {
        return false;
      }
    }
    if (above)
    {
      plane.normal = -plane.normal;
    }
    for (const ComplexBlock& block : this->Complex.blocks)
    {
      bool low = false, high = false;
      for (const int vertex : block.vertices)
      {
        const double height = plane.height(this->Vertices[vertex]);
        low = low || height < -this->Tolerance;
        high = high || height > this->Tolerance;
      }
      if (low && high)
      {
        return false;
      }
    }
    return true;
  }

  /// Per plane, whether all points of the body are behind it.
  std::vector<bool> bodyIsBehind(const std::vector<FacesInPlane>& cuts)
  {
    std::vector<char> touches(cuts.size(), 0);
    for (std::size_t i = 0; i < cuts.size(); ++i)
    {
      for (const FaceUse& body : this->BodyFaces)
      {
        if (this->Complex.blocks[body.block].rank == this->Processes.rank())
        {
          forFacePoints(this->Complex, body,
            [&](const Vec3& x) { touches[i] = touches[i] || !(cuts[i].plane.height(x) < -this->Tolerance); });
        }
      }
    }
    std::vector<bool> behind(cuts.size(), true);
    for (const std::vector<char>& part : this->Processes.gather(touches))
    {
      for (std::size_t i = 0; i < cuts.size(); ++i)
      {
        behind[i] = behind[i] && !part[i];
      }
    }
    return behind;
  }

  /// All inner faces in the plane, with the blocks on both sides of it.
  Candidate cut(const FacesInPlane& found) const
  {
    Candidate result;
    result.cut = found;
    const Plane& plane = found.plane;
    for (std::size_t b = 0; b < this->Complex.blocks.size(); ++b)
    {
      result.outside.push_back(this->blockHeight(static_cast<int>(b), plane) > 0.0 ? 1 : 0);
    }
    for (const int f : found.faces)
    {
      const ComplexFace& face = this->Complex.faces[f];
      if (face.boundary() || result.outside[face.uses[0].block] == result.outside[face.uses[1].block])
      {
        continue;
      }
      const int outer = result.outside[face.uses[0].block] ? 0 : 1;
      result.side.faces.push_back(f);
      result.side.outer.push_back(face.uses[outer]);
      result.side.inner.push_back(face.uses[1 - outer]);
    }
    return result;
  }

  /// Per direction the outermost plane, if all blocks beyond it reach from it to the outer boundary.
  std::vector<Candidate> outermost(const std::vector<Candidate>& candidates) const
  {
    std::vector<Candidate> chosen;
    for (const Candidate& candidate : candidates)
    {
      const bool last = std::none_of(candidates.begin(), candidates.end(), [&](const Candidate& other) {
        return other.cut.plane.normal.dot(candidate.cut.plane.normal) > 1.0 - AngleTolerance &&
          candidate.cut.plane.height(other.cut.plane.origin) > this->Tolerance;
      });
      if (last && this->isLayer(candidate))
      {
        chosen.push_back(candidate);
      }
    }
    return chosen;
  }

  bool isLayer(const Candidate& side) const
  {
    for (std::size_t b = 0; b < this->Complex.blocks.size(); ++b)
    {
      bool reaches = side.outside[b] == 0;
      for (int f = 0; f < 6 && !reaches; ++f)
      {
        const std::array<int, 6>& faces = this->Complex.blocks[b].faces;
        reaches = std::binary_search(side.side.faces.begin(), side.side.faces.end(), faces[f]) &&
          this->Complex.faces[faces[f ^ 1]].boundary();
      }
      if (!reaches)
      {
        return false;
      }
    }
    return true;
  }

  /// Whether an edge in one of the planes is not as in a grid.
  bool hasIrregularEdge(const std::vector<Candidate>& sides) const
  {
    for (const Candidate& side : sides)
    {
      for (const FaceUse& use : side.side.inner)
      {
        for (int n = 0; n < 4; ++n)
        {
          const int number = this->Complex.blocks[use.block].edges[faceEdge(use.face, n & 1, n >> 1)];
          const ComplexEdge& edge = this->Complex.edges[number];
          if (edge.valence() != (edge.boundary ? 2 : 4))
          {
            return true;
          }
        }
      }
    }
    return false;
  }

  bool isInside(const std::vector<Candidate>& sides, int block) const
  {
    return std::none_of(sides.begin(), sides.end(), [&](const Candidate& side) { return side.outside[block] != 0; });
  }

  bool isCuboid(const std::vector<Candidate>& sides)
  {
    std::vector<FacesInPlane> cuts;
    for (const Candidate& side : sides)
    {
      cuts.push_back(side.cut);
    }
    std::vector<int> insideBlocks, outline;
    for (int b = 0; b < static_cast<int>(this->Complex.blocks.size()); ++b)
    {
      if (this->isInside(sides, b))
      {
        insideBlocks.push_back(b);
      }
    }
    for (const int b : insideBlocks)
    {
      for (const int f : this->Complex.blocks[b].faces)
      {
        const ComplexFace& face = this->Complex.faces[f];
        if (face.boundary() && roleOf(this->Options, face) != BoundaryRole::Body)
        {
          outline.push_back(f);
        }
      }
    }
    for (FacesInPlane& more : this->planesOf(outline, cuts))
    {
      cuts.push_back(std::move(more));
    }
    for (const int face : outline)
    {
      if (std::none_of(cuts.begin(), cuts.end(), [&](const FacesInPlane& entry) { return entry.holds(face); }))
      {
        return false;
      }
    }
    std::vector<Plane> planes;
    for (const FacesInPlane& entry : cuts)
    {
      planes.push_back(entry.plane);
    }
    for (const Plane& plane : planes)
    {
      for (const Plane& other : planes)
      {
        const double cosine = std::abs(plane.normal.dot(other.normal));
        if (cosine > AngleTolerance && plane.normal.cross(other.normal).norm() > AngleTolerance)
        {
          return false;
        }
      }
      bool low = false, high = false;
      for (const int b : insideBlocks)
      {
        for (const int vertex : this->Complex.blocks[b].vertices)
        {
          const double height = plane.height(this->Vertices[vertex]);
          low = low || height < -this->Tolerance;
          high = high || height > this->Tolerance;
        }
      }
      if (low && high)
      {
        return false;
      }
    }
    return true;
  }

  std::vector<FarFieldSide> finish(std::vector<Candidate> sides)
  {
    std::vector<FarFieldSide> result;
    for (Candidate& candidate : sides)
    {
      FarFieldSide& side = candidate.side;
      for (const FaceUse& use : side.inner)
      {
        side.onCuboid.push_back(std::none_of(
          sides.begin(), sides.end(), [&](const Candidate& other) { return other.outside[use.block] != 0; }));
      }
      const auto areas = gatherListsFromOwners<Triple>(
        this->Processes, side.inner.size(),
        [&](std::size_t i) { return this->Complex.blocks[side.inner[i].block].rank; },
        [&](std::size_t i) { return this->areasOf(side.inner[i], candidate.cut.plane.normal); });
      OrderFreeSum sum;
      double quads = 0.0;
      for (const std::vector<Triple>& ofFace : areas)
      {
        for (const Triple& area : ofFace)
        {
          quads += 1.0;
          sum.add(1.0, Vec3(area[0], area[1], area[2]));
        }
      }
      side.normal = sum.result(quads).normalized();
      result.push_back(std::move(side));
    }
    std::sort(result.begin(), result.end(),
      [](const FarFieldSide& a, const FarFieldSide& b) { return comesBefore(a.normal, b.normal); });
    return result;
  }

  /// Twice the area vectors of a face's quadrilaterals, along `normal`: cross products of their diagonals, of which
  /// another numbering changes the sign alone.
  std::vector<Triple> areasOf(const FaceUse& use, const Vec3& normal) const
  {
    const ComplexBlock& owner = this->Complex.blocks[use.block];
    const Ijk cells{ owner.cells(0), owner.cells(1), owner.cells(2) };
    std::vector<Triple> areas;
    for (int t = 0; t < cells[faceAxis(use.face, 1)]; ++t)
    {
      for (int s = 0; s < cells[faceAxis(use.face, 0)]; ++s)
      {
        const auto x = [&](int ds, int dt) { return owner.points(facePoint(cells, use.face, s + ds, t + dt)); };
        Vec3 area = (x(1, 1) - x(0, 0)).cross(x(0, 1) - x(1, 0));
        area = area.dot(normal) < 0.0 ? Vec3(-area) : area;
        areas.push_back({ area[0], area[1], area[2] });
      }
    }
    return areas;
  }

  const BlockComplex& Complex;
  const ConversionOptions& Options;
  const Ranks& Processes;
  std::vector<Vec3> Vertices;
  std::vector<FaceUse> BodyFaces;
  double Tolerance = 0.0;
};

} // namespace

BoundaryRole roleOf(const ConversionOptions& options, const ComplexFace& face)
{
  return face.boundary() && face.tag >= 0 && face.tag < static_cast<int>(options.roles.size()) ? options.roles[face.tag]
                                                                                               : BoundaryRole::Other;
}

std::vector<FarFieldSide> farFieldSides(
  const BlockComplex& complex, const ConversionOptions& options, const Execution& run)
{
  FarFieldSearch search(complex, options, *run.ranks);
  return options.extensionBlocks.empty() ? search.automatic() : search.named();
}

} // namespace bsv
