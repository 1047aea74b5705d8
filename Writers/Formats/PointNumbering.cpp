// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/PointNumbering.h"

#include "Base/UnionFind.h"

#include <numeric>

namespace bsv
{

namespace
{

SurfaceNumbering surfaceOf(const std::vector<Ijk>& counts)
{
  BlockMesh mesh;
  for (const Ijk& block : counts)
  {
    mesh.blocks.emplace_back();
    mesh.blocks.back().points = GridView::elsewhere(block);
  }
  return SurfaceNumbering(mesh);
}

Ijk pointOnFace(const Ijk& counts, int face, int s, int t)
{
  Ijk p{};
  p[faceDirection(face)] = faceSide(face) ? counts[faceDirection(face)] - 1 : 0;
  p[faceAxis(face, 0)] = s;
  p[faceAxis(face, 1)] = t;
  return p;
}

} // namespace

Interface reversed(const Interface& contact)
{
  Interface back = contact;
  back.blockA = contact.blockB;
  back.faceA = contact.faceB;
  back.blockB = contact.blockA;
  back.faceB = contact.faceA;
  back.orientation = inverseOrientation(contact.orientation);
  back.rangeA = contact.rangeB();
  back.originB = contact.rangeA.lo;
  return back;
}

PointNumbering::PointNumbering(
  const std::vector<Ijk>& counts, const std::vector<Interface>& interfaces, const Execution& run)
  : Counts(counts)
  , Numbering(surfaceOf(counts))
{
  UnionFind sets(this->Numbering.pointCount());
  for (const Interface& c : interfaces)
  {
    run.report(0.0);
    const int ns = c.rangeA.hi[0] - c.rangeA.lo[0];
    const int nt = c.rangeA.hi[1] - c.rangeA.lo[1];
    for (int t = 0; t <= nt; ++t)
    {
      for (int s = 0; s <= ns; ++s)
      {
        const std::array<int, 2> q = mapFacePoint(c.orientation, s, t, ns, nt);
        sets.unite(this->Numbering.point(
                     c.blockA, pointOnFace(counts[c.blockA], c.faceA, c.rangeA.lo[0] + s, c.rangeA.lo[1] + t)),
          this->Numbering.point(
            c.blockB, pointOnFace(counts[c.blockB], c.faceB, c.originB[0] + q[0], c.originB[1] + q[1])));
      }
    }
  }

  this->Surface.assign(static_cast<std::size_t>(this->Numbering.pointCount()), -1);
  Index next = 0;
  for (std::size_t b = 0; b < counts.size(); ++b)
  {
    const Ijk& n = counts[b];
    const int block = static_cast<int>(b);
    this->BlockStart.push_back(next);
    this->FirstRow.push_back(static_cast<Index>(this->RowStart.size()));
    const auto onSurface = [&](const Ijk& p) {
      const Index own = this->Numbering.point(block, p);
      Index& number = this->Surface[sets.find(own)];
      // The smallest member of a set is its representative, and has its number at its own place.
      next += number < 0 ? 1 : 0;
      number = number < 0 ? next - 1 : number;
      this->Surface[own] = number;
    };
    for (int k = 0; k < n[2]; ++k)
    {
      run.report(0.0);
      for (int j = 0; j < n[1]; ++j)
      {
        const bool surface = j == 0 || k == 0 || j + 1 == n[1] || k + 1 == n[2];
        this->RowStart.push_back(0);
        onSurface({ 0, j, k });
        this->RowStart.back() = next - 1;
        for (int i = 1; surface && i + 1 < n[0]; ++i)
        {
          onSurface({ i, j, k });
        }
        next += surface ? 0 : n[0] - 2;
        onSurface({ n[0] - 1, j, k });
      }
    }
  }
  this->BlockStart.push_back(next);
}

FaceNeighbours::FaceNeighbours(const std::vector<Ijk>& counts, const std::vector<Interface>& interfaces)
  : Counts(counts)
  , Sides(6 * counts.size())
{
  for (const Interface& contact : interfaces)
  {
    this->Sides[6 * std::size_t(contact.blockA) + contact.faceA].push_back(contact);
    this->Sides[6 * std::size_t(contact.blockB) + contact.faceB].push_back(reversed(contact));
  }
}

} // namespace bsv
