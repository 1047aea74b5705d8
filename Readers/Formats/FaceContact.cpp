// SPDX-License-Identifier: BSD-3-Clause
#include "Formats/FaceContact.h"

#include "Complex/BlockComplex.h"
#include "Mesh/PointExchange.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <sstream>
#include <tuple>

namespace bsv
{

namespace
{

/// Fraction of the shortest edge below which two points are one; that of BlockComplexOptions.
constexpr double MatchTolerance = 0.05;

/// Squared length of the shortest mesh edge at a point that is not collapsed.
double shortestEdge(const GridView& points, const Ijk& at)
{
  double shortest = std::numeric_limits<double>::infinity();
  for (int d = 0; d < 3; ++d)
  {
    for (const int step : { -1, 1 })
    {
      Ijk next = at;
      next[d] += step;
      if (next[d] >= 0 && next[d] < points.counts()[d])
      {
        const double length = (points(next) - points(at)).squaredNorm();
        shortest = length > 0.0 ? std::min(shortest, length) : shortest;
      }
    }
  }
  return shortest;
}

Ijk lastPoint(const MeshBlock& block)
{
  const Ijk& counts = block.points.counts();
  return { counts[0] - 1, counts[1] - 1, counts[2] - 1 };
}

std::string describe(const MeshBlock& block, int face, const Ijk& at, const Vec3& x)
{
  std::ostringstream text;
  text.precision(9);
  text << "block '" << block.name << "', face "
       << "ijk"[faceDirection(face)] << (faceSide(face) ? " max" : " min") << ", point (" << at[0] << ", " << at[1]
       << ", " << at[2] << ") at (" << x[0] << ", " << x[1] << ", " << x[2] << ")";
  return text.str();
}

/// The points that checkContact() reads of a side.
PointBox neighbourhood(const MeshBlock& block, int index, int face, const FaceRange& range)
{
  const Ijk last = lastPoint(block);
  PointBox box;
  box.block = index;
  box.lo = facePoint(last, face, std::max(0, range.lo[0] - 1), std::max(0, range.lo[1] - 1));
  box.hi = facePoint(
    last, face, std::min(last[faceAxis(face, 0)], range.hi[0] + 1), std::min(last[faceAxis(face, 1)], range.hi[1] + 1));
  const int normal = faceDirection(face);
  (faceSide(face) ? box.lo[normal] : box.hi[normal]) += faceSide(face) ? -1 : 1;
  return box;
}

auto key(const Interface& c)
{
  return std::tie(c.blockA, c.faceA, c.rangeA.lo, c.rangeA.hi, c.blockB, c.faceB, c.originB, c.orientation);
}

} // namespace

FaceRange DirectedRange::range() const
{
  FaceRange range;
  for (int axis = 0; axis < 2; ++axis)
  {
    range.lo[axis] = std::min(this->begin[axis], this->end[axis]);
    range.hi[axis] = std::max(this->begin[axis], this->end[axis]);
  }
  return range;
}

Interface faceContact(const DirectedRange& a, const DirectedRange& b, bool swapped)
{
  Interface contact;
  contact.blockA = a.block;
  contact.faceA = a.face;
  contact.blockB = b.block;
  contact.faceB = b.face;
  contact.rangeA = a.range();
  contact.originB = b.range().lo;
  contact.orientation = swapped ? 1 : 0;
  for (int axisB = 0; axisB < 2; ++axisB)
  {
    const int axisA = swapped ? 1 - axisB : axisB;
    const int stepsA = a.end[axisA] - a.begin[axisA];
    const int stepsB = b.end[axisB] - b.begin[axisB];
    if (std::abs(stepsA) != std::abs(stepsB))
    {
      throw Error("the two sides differ in size: " + std::to_string(std::abs(stepsA)) + " against " +
        std::to_string(std::abs(stepsB)) + " cells");
    }
    if ((stepsA < 0) != (stepsB < 0))
    {
      contact.orientation |= axisB == 0 ? 2 : 4;
    }
  }
  return contact;
}

Interface orderedContact(const Interface& contact)
{
  Interface reversed;
  reversed.blockA = contact.blockB;
  reversed.faceA = contact.faceB;
  reversed.rangeA = contact.rangeB();
  reversed.blockB = contact.blockA;
  reversed.faceB = contact.faceA;
  reversed.originB = contact.rangeA.lo;
  reversed.orientation = inverseOrientation(contact.orientation);
  return key(reversed) < key(contact) ? reversed : contact;
}

bool operator<(const Interface& a, const Interface& b)
{
  return key(a) < key(b);
}

namespace
{

void checkContact(const BlockMesh& mesh, const Interface& contact)
{
  const MeshBlock& blockA = mesh.blocks[contact.blockA];
  const MeshBlock& blockB = mesh.blocks[contact.blockB];
  const FaceRange& range = contact.rangeA;
  const int ns = range.hi[0] - range.lo[0];
  const int nt = range.hi[1] - range.lo[1];
  for (int t = 0; t <= nt; ++t)
  {
    for (int s = 0; s <= ns; ++s)
    {
      const std::array<int, 2> onB = mapFacePoint(contact.orientation, s, t, ns, nt);
      const Ijk a = facePoint(lastPoint(blockA), contact.faceA, range.lo[0] + s, range.lo[1] + t);
      const Ijk b =
        facePoint(lastPoint(blockB), contact.faceB, contact.originB[0] + onB[0], contact.originB[1] + onB[1]);
      const Vec3 xa = blockA.points(a);
      const Vec3 xb = blockB.points(b);
      if (xa == xb)
      {
        continue;
      }
      const double tolerance =
        MatchTolerance * std::sqrt(std::min(shortestEdge(blockA.points, a), shortestEdge(blockB.points, b)));
      const double distance = (xa - xb).norm();
      if (!(distance <= tolerance))
      {
        std::ostringstream text;
        text << "the points of the two sides do not coincide: " << describe(blockA, contact.faceA, a, xa) << " and "
             << describe(blockB, contact.faceB, b, xb) << " are " << distance << " apart, allowed is " << tolerance;
        throw Error(text.str());
      }
    }
  }
}

} // namespace

void checkContacts(BlockMesh mesh, const std::vector<DeclaredContact>& contacts, const Ranks& ranks)
{
  // The rank of block A checks.
  const auto isHere = [&](int block) { return mesh.blocks[block].points.isHere(); };
  std::vector<PointBox> wanted;
  for (const DeclaredContact& declared : contacts)
  {
    const Interface& c = declared.contact;
    if (ranks.size() > 1 && isHere(c.blockA) && !isHere(c.blockB))
    {
      wanted.push_back(neighbourhood(mesh.blocks[c.blockB], c.blockB, c.faceB, c.rangeB()));
    }
  }
  const auto fetched = fetchPoints(
    wanted, static_cast<int>(mesh.blocks.size()), [&](int block) { return mesh.blocks[block].rank; },
    [&](int block) -> GridView& { return mesh.blocks[block].points; }, ranks);

  for (std::size_t i = 0; i < contacts.size(); ++i)
  {
    const Interface& c = contacts[i].contact;
    if (!isHere(c.blockA) || (ranks.size() == 1 && !isHere(c.blockB)))
    {
      continue;
    }
    try
    {
      checkContact(mesh, c);
    }
    catch (const Error& error)
    {
      throw ErrorAt(static_cast<Index>(i), contacts[i].where + ": " + error.what());
    }
  }
  ranks.nextStep();
}

void checkRange(const BlockMesh& mesh, const DirectedRange& range)
{
  const MeshBlock& block = mesh.blocks[range.block];
  for (int axis = 0; axis < 2; ++axis)
  {
    const int count = block.points.counts()[faceAxis(range.face, axis)];
    const auto [low, high] = std::minmax(range.begin[axis], range.end[axis]);
    if (low < 0 || high >= count || low == high)
    {
      // One-based, as files count.
      throw Error("range " + std::to_string(range.begin[axis] + Index(1)) + ".." +
        std::to_string(range.end[axis] + Index(1)) + " along " + "ijk"[faceAxis(range.face, axis)] + " of block '" +
        block.name + "' is not a range of at least two points within 1.." + std::to_string(count));
    }
  }
}

} // namespace bsv
