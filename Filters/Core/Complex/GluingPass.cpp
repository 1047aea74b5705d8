// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/GluingPass.h"

#include "Complex/BlockComplex.h"

#include <algorithm>

namespace bsv
{

GluingPass::GluingPass(PartialMesh& mesh, const SurfaceNumbering& surface, const std::vector<bool>& leftHanded,
  const BlockComplexOptions& options, const Execution& run, Contacts& result)
  : Part(mesh)
  , Mesh(mesh.mesh())
  , Surface(surface)
  , LeftHanded(leftHanded)
  , Options(options)
  , Run(run)
  , Ranks(*run.ranks)
  , Result(result)
{
}

double GluingPass::tolerance(int block, const Ijk& p) const
{
  return matchDistance(this->Mesh.blocks[block].points, p, this->Options.matchTolerance);
}

Vec3 GluingPass::corner(const QuadAt& at, int cs, int ct) const
{
  return this->Mesh.blocks[at.block].points(this->Surface.corner(at, cs, ct));
}

Vec3 GluingPass::center(const QuadAt& at) const
{
  return 0.25 * ((this->corner(at, 0, 0) + this->corner(at, 1, 1)) + (this->corner(at, 1, 0) + this->corner(at, 0, 1)));
}

std::string GluingPass::where(const QuadAt& at) const
{
  return blockLabel(this->Mesh, at.block) + " " + faceLabel(at.face) + " quadrilateral (" + std::to_string(at.s) +
    ", " + std::to_string(at.t) + ")";
}

std::string GluingPass::where(Index quad) const
{
  return this->where(this->Surface.quadAt(quad));
}

GluingPass::Comparison GluingPass::compare(const Interface& contact, bool bitsOnly) const
{
  const FaceRange& a = contact.rangeA;
  const int ns = a.hi[0] - a.lo[0];
  const int nt = a.hi[1] - a.lo[1];
  const GridView& pointsA = this->Mesh.blocks[contact.blockA].points;
  const GridView& pointsB = this->Mesh.blocks[contact.blockB].points;
  const auto onA = [&](int s, int t) {
    return facePoint(this->Surface.cells(contact.blockA), contact.faceA, a.lo[0] + s, a.lo[1] + t);
  };
  const auto onB = [&](int s, int t) {
    const auto st = mapFacePoint(contact.orientation, s, t, ns, nt);
    return facePoint(
      this->Surface.cells(contact.blockB), contact.faceB, contact.originB[0] + st[0], contact.originB[1] + st[1]);
  };
  const Index startA = pointsA.place(onA(0, 0)), startB = pointsB.place(onB(0, 0));
  const Index alongSA = pointsA.place(onA(1, 0)) - startA, alongSB = pointsB.place(onB(1, 0)) - startB;
  const Index alongTA = pointsA.place(onA(0, 1)) - startA, alongTB = pointsB.place(onB(0, 1)) - startB;
  Comparison result;
  for (int t = 0; t <= nt; ++t)
  {
    for (int s = 0; s <= ns; ++s)
    {
      const Vec3 x = pointsA.atPlace(startA + s * alongSA + t * alongTA);
      const Vec3 y = pointsB.atPlace(startB + s * alongSB + t * alongTB);
      if (sameBits(x, y))
      {
        continue;
      }
      result.sameBits = false;
      if (bitsOnly)
      {
        return result;
      }
      result.pointA = onA(s, t);
      result.pointB = onB(s, t);
      result.distance = (x - y).norm();
      result.allowed =
        std::min(this->tolerance(contact.blockA, result.pointA), this->tolerance(contact.blockB, result.pointB));
      if (result.distance > result.allowed)
      {
        return result;
      }
    }
  }
  return result;
}

std::vector<GluingPass::Comparison> GluingPass::compare(const std::vector<Interface>& contacts, bool bitsOnly)
{
  std::vector<PointBox> wanted;
  for (const Interface& contact : contacts)
  {
    if (this->Part.isHere(contact.blockA) && !this->Part.isHere(contact.blockB))
    {
      // Tolerances need the points next to those of the contact.
      wanted.push_back(
        pointsAtFace(this->Mesh, contact.blockB, contact.faceB, contact.rangeB(), bitsOnly ? 1 : 2, bitsOnly ? 0 : 1));
    }
  }
  this->Part.fetch(wanted);
  std::vector<Comparison> results(contacts.size());
  this->Run.parallelFor(static_cast<Index>(contacts.size()), 16, [&](Index begin, Index end) {
    for (Index n = begin; n < end; ++n)
    {
      if (this->Part.isHere(contacts[n].blockA))
      {
        results[n] = this->compare(contacts[n], bitsOnly);
      }
    }
  });
  this->Ranks.share(results, [&](Index n) { return this->Part.rankOf(contacts[n].blockA); });
  return results;
}

void GluingPass::noteSameBits(const Interface& contact, const Comparison& compared)
{
  if (compared.sameBits && this->whole(contact))
  {
    this->Result.setSameBits(contact.blockA, contact.faceA);
    this->Result.setSameBits(contact.blockB, contact.faceB);
  }
}

bool GluingPass::whole(int block, int face, const FaceRange& range) const
{
  return range.lo == std::array<int, 2>{ 0, 0 } && range.hi[0] == this->Surface.faceCells(block, face, 0) &&
    range.hi[1] == this->Surface.faceCells(block, face, 1);
}

bool GluingPass::whole(const Interface& contact) const
{
  return this->whole(contact.blockA, contact.faceA, contact.rangeA) &&
    this->whole(contact.blockB, contact.faceB, contact.rangeB());
}

void GluingPass::take(const Interface& contact, const std::string& what)
{
  const bool folded = contact.blockA == contact.blockB && contact.faceA == contact.faceB;
  if (this->whole(contact) && !folded && this->Result.undecided(contact.blockA, contact.faceA) &&
    this->Result.undecided(contact.blockB, contact.faceB))
  {
    this->Result.setContact(contact);
    return;
  }
  const FaceRange& a = contact.rangeA;
  const int ns = a.hi[0] - a.lo[0];
  const int nt = a.hi[1] - a.lo[1];
  for (int t = 0; t < nt; ++t)
  {
    for (int s = 0; s < ns; ++s)
    {
      // The quadrilateral (s, t) is the point (s, t) of a grid that has one point less per axis.
      const auto onB = mapFacePoint(contact.orientation, s, t, ns - 1, nt - 1);
      const QuadAt quadA{ contact.blockA, contact.faceA, a.lo[0] + s, a.lo[1] + t };
      const QuadAt quadB{ contact.blockB, contact.faceB, contact.originB[0] + onB[0], contact.originB[1] + onB[1] };
      if (folded && quadA.s == quadB.s && quadA.t == quadB.t)
      {
        throw Error(what + ": " + this->where(quadA) + " meets itself");
      }
      for (const QuadAt& quad : { quadA, quadB })
      {
        if (!this->Result.undecided(quad))
        {
          throw Error(what + ": " + this->where(quad) + " is in another interface already");
        }
      }
      this->Result.setContact(quadA, quadB, contact.orientation);
    }
  }
}

} // namespace bsv
