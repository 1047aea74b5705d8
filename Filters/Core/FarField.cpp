// SPDX-License-Identifier: BSD-3-Clause
#include "FarField.h"

#include "OrderFreeSum.h"

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
  FarFieldSearch(const BlockComplex& complex, const ConversionOptions& options)
    : Complex(complex)
    , Options(options)
  {
    Eigen::AlignedBox3d box;
    for (const ComplexVertex& vertex : complex.vertices)
    {
      const CornerUse& use = vertex.corners.front();
      this->Vertices.push_back(this->corner(use.block, use.corner));
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

  std::vector<FarFieldSide> automatic() const
  {
    if (this->BodyFaces.empty())
    {
      return {};
    }
    std::vector<Candidate> candidates;
    std::vector<Plane> tested;
    for (std::size_t f = 0; f < this->Complex.faces.size(); ++f)
    {
      const ComplexFace& face = this->Complex.faces[f];
      if (face.boundary())
      {
        continue;
      }
      Plane plane = this->planeOf(face.uses.front());
      const bool known = std::any_of(tested.begin(), tested.end(), [&](const Plane& other) {
        return this->liesIn(face.uses.front(), other);
      });
      if (known || plane.normal.isZero() || !this->liesIn(face.uses.front(), plane))
      {
        continue;
      }
      tested.push_back(plane);
      if (this->orient(plane))
      {
        Candidate candidate = this->cut(plane);
        if (!candidate.side.faces.empty())
        {
          candidates.push_back(std::move(candidate));
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

  std::vector<FarFieldSide> named() const
  {
    const auto isNamed = [&](const FaceUse& use) {
      const int parent = this->Complex.blocks[use.block].parent;
      return parent < static_cast<int>(this->Options.extensionBlocks.size()) && this->Options.extensionBlocks[parent];
    };
    std::vector<Candidate> candidates;
    std::vector<Plane> planes;
    for (const ComplexFace& face : this->Complex.faces)
    {
      if (face.boundary() || isNamed(face.uses[0]) == isNamed(face.uses[1]))
      {
        continue;
      }
      const FaceUse& use = face.uses[0];
      Plane plane = this->planeOf(use);
      if (plane.normal.isZero() || !this->liesIn(use, plane) ||
        std::any_of(planes.begin(), planes.end(), [&](const Plane& other) { return this->liesIn(use, other); }))
      {
        continue;
      }
      planes.push_back(plane);
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
      for (const ComplexFace& other : this->Complex.faces)
      {
        if (!other.boundary() && isNamed(other.uses[0]) != isNamed(other.uses[1]) && this->liesIn(other.uses[0], plane))
        {
          const FaceUse& outer = other.uses[isNamed(other.uses[0]) ? 0 : 1];
          votes += this->blockHeight(outer.block, plane) > 0.0 ? this->area(outer) : -this->area(outer);
        }
      }
      const bool flip = bodyHigh != bodyLow ? bodyHigh > -bodyLow : votes < 0.0;
      plane.normal = flip ? Vec3(-plane.normal) : plane.normal;
      candidates.push_back(this->cut(plane));
    }
    if (candidates.empty())
    {
      throw Error("Extension Blocks: none of the named blocks is attached to another block in a plane");
    }
    return this->finish(std::move(candidates));
  }

private:
  struct Candidate
  {
    Plane plane;
    FarFieldSide side;
    /// Per block: beyond the plane.
    std::vector<char> outside;
  };

  Vec3 corner(int block, int corner) const
  {
    const ComplexBlock& owner = this->Complex.blocks[block];
    Ijk ijk;
    for (int d = 0; d < 3; ++d)
    {
      ijk[d] = cornerSide(corner, d) ? owner.cells(d) : 0;
    }
    return owner.points(ijk);
  }

  template <typename Body>
  void forPoints(const FaceUse& use, const Body& body) const
  {
    const ComplexBlock& owner = this->Complex.blocks[use.block];
    const Ijk cells{ owner.cells(0), owner.cells(1), owner.cells(2) };
    for (int t = 0; t <= cells[faceAxis(use.face, 1)]; ++t)
    {
      for (int s = 0; s <= cells[faceAxis(use.face, 0)]; ++s)
      {
        body(owner.points(facePoint(cells, use.face, s, t)));
      }
    }
  }

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

  bool liesIn(const FaceUse& use, const Plane& plane) const
  {
    for (const Vec3& x : this->corners(use))
    {
      if (!(std::abs(plane.height(x)) <= this->Tolerance))
      {
        return false;
      }
    }
    bool inside = true;
    this->forPoints(use, [&](const Vec3& x) { inside = inside && std::abs(plane.height(x)) <= this->Tolerance; });
    return inside;
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

  /// Turns the plane's normal away from the body. False if the body touches or crosses it, or a block crosses it.
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
    for (const FaceUse& body : this->BodyFaces)
    {
      this->forPoints(body, [&](const Vec3& x) { touches = touches || !(plane.height(x) < -this->Tolerance); });
    }
    return !touches;
  }

  /// All inner faces in the plane, with the blocks on both sides of it.
  Candidate cut(const Plane& plane) const
  {
    Candidate result;
    result.plane = plane;
    for (std::size_t b = 0; b < this->Complex.blocks.size(); ++b)
    {
      result.outside.push_back(this->blockHeight(static_cast<int>(b), plane) > 0.0 ? 1 : 0);
    }
    for (std::size_t f = 0; f < this->Complex.faces.size(); ++f)
    {
      const ComplexFace& face = this->Complex.faces[f];
      if (face.boundary() || result.outside[face.uses[0].block] == result.outside[face.uses[1].block] ||
        !this->liesIn(face.uses[0], plane))
      {
        continue;
      }
      const int outer = result.outside[face.uses[0].block] ? 0 : 1;
      result.side.faces.push_back(static_cast<int>(f));
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
        return other.plane.normal.dot(candidate.plane.normal) > 1.0 - AngleTolerance &&
          candidate.plane.height(other.plane.origin) > this->Tolerance;
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

  bool isCuboid(const std::vector<Candidate>& sides) const
  {
    std::vector<Plane> planes;
    for (const Candidate& side : sides)
    {
      planes.push_back(side.plane);
    }
    std::vector<int> insideBlocks;
    for (int b = 0; b < static_cast<int>(this->Complex.blocks.size()); ++b)
    {
      if (this->isInside(sides, b))
      {
        insideBlocks.push_back(b);
      }
    }
    for (const int b : insideBlocks)
    {
      for (int f = 0; f < 6; ++f)
      {
        const ComplexFace& face = this->Complex.faces[this->Complex.blocks[b].faces[f]];
        if (!face.boundary() || roleOf(this->Options, face) == BoundaryRole::Body ||
          std::any_of(planes.begin(), planes.end(), [&](const Plane& plane) { return this->liesIn({ b, f }, plane); }))
        {
          continue;
        }
        const Plane plane = this->planeOf({ b, f });
        if (plane.normal.isZero() || !this->liesIn({ b, f }, plane))
        {
          return false;
        }
        planes.push_back(plane);
      }
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

  std::vector<FarFieldSide> finish(std::vector<Candidate> sides) const
  {
    std::vector<FarFieldSide> result;
    for (Candidate& candidate : sides)
    {
      FarFieldSide& side = candidate.side;
      OrderFreeSum sum;
      double quads = 0.0;
      for (std::size_t i = 0; i < side.faces.size(); ++i)
      {
        const int block = side.inner[i].block;
        bool onCuboid = true;
        for (const Candidate& other : sides)
        {
          onCuboid = onCuboid && !other.outside[block];
        }
        side.onCuboid.push_back(onCuboid);
        // Cross products of the diagonals: another numbering changes their sign alone.
        const ComplexBlock& owner = this->Complex.blocks[block];
        const Ijk cells{ owner.cells(0), owner.cells(1), owner.cells(2) };
        const int face = side.inner[i].face;
        for (int t = 0; t < cells[faceAxis(face, 1)]; ++t)
        {
          for (int s = 0; s < cells[faceAxis(face, 0)]; ++s)
          {
            const auto x = [&](int ds, int dt) { return owner.points(facePoint(cells, face, s + ds, t + dt)); };
            const Vec3 area = (x(1, 1) - x(0, 0)).cross(x(0, 1) - x(1, 0));
            quads += 1.0;
            sum.add(1.0, area.dot(candidate.plane.normal) < 0.0 ? Vec3(-area) : area);
          }
        }
      }
      side.normal = sum.result(quads).normalized();
      result.push_back(std::move(side));
    }
    std::sort(result.begin(), result.end(), [](const FarFieldSide& a, const FarFieldSide& b) {
      return std::lexicographical_compare(
        a.normal.data(), a.normal.data() + 3, b.normal.data(), b.normal.data() + 3);
    });
    return result;
  }

  const BlockComplex& Complex;
  const ConversionOptions& Options;
  std::vector<Vec3> Vertices;
  std::vector<FaceUse> BodyFaces;
  double Tolerance = 0.0;
};

} // namespace

BoundaryRole roleOf(const ConversionOptions& options, const ComplexFace& face)
{
  return face.boundary() && face.tag >= 0 && face.tag < static_cast<int>(options.roles.size())
    ? options.roles[face.tag]
    : BoundaryRole::Other;
}

std::vector<FarFieldSide> farFieldSides(const BlockComplex& complex, const ConversionOptions& options)
{
  const FarFieldSearch search(complex, options);
  return options.extensionBlocks.empty() ? search.automatic() : search.named();
}

} // namespace bsv
