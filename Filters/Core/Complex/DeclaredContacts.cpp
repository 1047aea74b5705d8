// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/DeclaredContacts.h"

#include "Complex/BlockComplex.h"

#include <limits>

namespace bsv
{

void DeclaredContacts::operator()()
{
  this->takeInterfaces();
  for (std::size_t n = 0; n < this->Mesh.boundaries.size(); ++n)
  {
    this->takeBoundary(static_cast<int>(n));
  }
}

void DeclaredContacts::checkRange(const std::string& what, int block, int face, const FaceRange& range) const
{
  if (block < 0 || block >= this->Surface.blockCount())
  {
    throw Error(what + ": there is no block " + std::to_string(block));
  }
  if (face < 0 || face > 5)
  {
    throw Error(what + ": there is no face " + std::to_string(face));
  }
  for (int axis = 0; axis < 2; ++axis)
  {
    const int n = this->Surface.faceCells(block, face, axis);
    if (range.lo[axis] < 0 || range.lo[axis] >= range.hi[axis] || range.hi[axis] > n)
    {
      throw Error(what + ": range " + std::to_string(range.lo[axis]) + " to " + std::to_string(range.hi[axis]) +
        " of axis " + std::to_string(axis) + " is not inside 0 to " + std::to_string(n) + " of " +
        blockLabel(this->Mesh, block) + " " + faceLabel(face));
    }
  }
}

std::vector<GluingPass::Comparison> DeclaredContacts::compareDeclared()
{
  const std::vector<Interface>& all = this->Mesh.interfaces;
  if (this->alone())
  {
    return this->compare(all, false);
  }
  std::vector<Comparison> results = this->compare(all, true);
  std::vector<Interface> different;
  for (std::size_t n = 0; n < all.size(); ++n)
  {
    if (!results[n].sameBits)
    {
      different.push_back(all[n]);
    }
  }
  const std::vector<Comparison> compared = this->compare(different, false);
  auto next = compared.begin();
  for (Comparison& result : results)
  {
    result = result.sameBits ? result : *next++;
  }
  return results;
}

void DeclaredContacts::takeInterfaces()
{
  for (std::size_t n = 0; n < this->Mesh.interfaces.size(); ++n)
  {
    const Interface& contact = this->Mesh.interfaces[n];
    const std::string what = "interface " + std::to_string(n);
    if (contact.orientation < 0 || contact.orientation > 7)
    {
      throw Error(what + ": there is no orientation " + std::to_string(contact.orientation));
    }
    this->checkRange(what, contact.blockA, contact.faceA, contact.rangeA);
    // The size of A is known to be sane now; the origin on B may be anything.
    for (int axis = 0; axis < 2; ++axis)
    {
      if (contact.originB[axis] < 0 || contact.originB[axis] > std::numeric_limits<int>::max() / 2)
      {
        throw Error(what + ": there is no point " + std::to_string(contact.originB[axis]) + " on its second face");
      }
    }
    this->checkRange(what, contact.blockB, contact.faceB, contact.rangeB());
  }
  const std::vector<Comparison> compared = this->compareDeclared();
  for (std::size_t n = 0; n < compared.size(); ++n)
  {
    const Interface& contact = this->Mesh.interfaces[n];
    const Comparison& c = compared[n];
    const std::string what = "interface " + std::to_string(n);
    if (c.distance > c.allowed)
    {
      throw Error(what + " does not match the coordinates: point " + text(c.pointA) + " of " +
        blockLabel(this->Mesh, contact.blockA) + " " + faceLabel(contact.faceA) + " and point " + text(c.pointB) +
        " of " + blockLabel(this->Mesh, contact.blockB) + " " + faceLabel(contact.faceB) + " are " + text(c.distance) +
        " apart, allowed is " + text(c.allowed));
    }
    this->take(contact, what);
    this->noteSameBits(contact, c);
  }
}

void DeclaredContacts::takeBoundary(int n)
{
  const BoundaryPatch& patch = this->Mesh.boundaries[n];
  const std::string what = "boundary " + std::to_string(n);
  this->checkRange(what, patch.block, patch.face, patch.range);
  const int names = static_cast<int>(this->Mesh.boundaryNames.size());
  if (patch.tag < 0 || patch.tag >= names)
  {
    throw Error(
      what + ": there is no boundary name " + std::to_string(patch.tag) + ", " + std::to_string(names) + " are given");
  }
  if (this->whole(patch.block, patch.face, patch.range) && this->Result.undecided(patch.block, patch.face))
  {
    this->Result.setBoundary(patch.block, patch.face, patch.tag);
    return;
  }
  for (int t = patch.range.lo[1]; t < patch.range.hi[1]; ++t)
  {
    for (int s = patch.range.lo[0]; s < patch.range.hi[0]; ++s)
    {
      const QuadAt quad{ patch.block, patch.face, s, t };
      if (!this->Result.undecided(quad))
      {
        if (!this->Result.boundary(quad))
        {
          throw Error(what + ": " + this->where(quad) + " is in an interface already");
        }
        if (this->Result.tag(quad) != patch.tag)
        {
          throw Error(what + ": " + this->where(quad) + " belongs to boundary \"" +
            this->Mesh.boundaryNames[this->Result.tag(quad)] + "\" already");
        }
      }
      this->Result.setBoundary(quad, patch.tag);
    }
  }
}

} // namespace bsv
