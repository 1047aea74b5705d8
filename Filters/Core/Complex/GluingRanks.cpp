// SPDX-License-Identifier: BSD-3-Clause
#include "Complex/GluingRanks.h"

#include "Base/BoxTree.h"
#include "Complex/BlockComplex.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

namespace bsv
{

namespace
{

/// A face with undecided quadrilaterals, and the points around them.
struct OpenFace
{
  int block;
  int face;
  FaceRange range;
};

/// Makes the range hold one more quadrilateral; it is empty if it has no height.
void extend(FaceRange& range, const QuadAt& at)
{
  if (range.lo[1] == range.hi[1])
  {
    range = { { at.s, at.t }, { at.s, at.t } };
  }
  range.lo = { std::min(range.lo[0], at.s), std::min(range.lo[1], at.t) };
  range.hi = { std::max(range.hi[0], at.s + 1), std::max(range.hi[1], at.t + 1) };
}

/// Calls visit(quadrilateral) for the undecided ones with points in a range.
template <typename Visit>
void forEachUndecided(const Contacts& contacts, int block, int face, const FaceRange& range, const Visit& visit)
{
  QuadAt at{ block, face, 0, 0 };
  for (at.t = range.lo[1]; at.t < range.hi[1]; ++at.t)
  {
    for (at.s = range.lo[0]; at.s < range.hi[0]; ++at.s)
    {
      if (contacts.undecided(at))
      {
        visit(at);
      }
    }
  }
}

FaceRange wholeFace(const SurfaceNumbering& surface, int block, int face)
{
  return { { 0, 0 }, { surface.faceCells(block, face, 0), surface.faceCells(block, face, 1) } };
}

std::vector<OpenFace> openFaces(const SurfaceNumbering& surface, const Contacts& contacts)
{
  std::vector<OpenFace> faces;
  for (int block = 0; block < surface.blockCount(); ++block)
  {
    for (int face = 0; face < 6; ++face)
    {
      FaceRange range = wholeFace(surface, block, face);
      if (!contacts.onePiece(block, face))
      {
        FaceRange found;
        forEachUndecided(contacts, block, face, range, [&](const QuadAt& at) { extend(found, at); });
        range = found;
      }
      else if (!contacts.undecided(block, face))
      {
        continue;
      }
      if (range.lo[1] < range.hi[1])
      {
        faces.push_back({ block, face, range });
      }
    }
  }
  return faces;
}

/// A box in space, as ranks send it.
struct Extent
{
  std::array<double, 3> lo{ 0.0, 0.0, 0.0 };
  std::array<double, 3> hi{ 0.0, 0.0, 0.0 };
};

/// Quadrilaterals and their partners whose numbers are linear in a counter.
struct Series
{
  Index quad = 0;
  Index partner = 0;
  Index count = 1;
  Index quadStep = 0;
  Index partnerStep = 0;

  /// Appends a pair, if it continues the series.
  bool append(Index nextQuad, Index nextPartner)
  {
    if (this->count == 1)
    {
      this->quadStep = nextQuad - this->quad;
      this->partnerStep = nextPartner - this->partner;
    }
    if (nextQuad != this->quad + this->count * this->quadStep ||
      nextPartner != this->partner + this->count * this->partnerStep)
    {
      return false;
    }
    ++this->count;
    return true;
  }
};

/// What was found for a rectangle of quadrilaterals: equal rows, of which `rows` lists the first quadrilaterals.
struct Patch
{
  Series rows;
  Series row;
  /// Of the contact; -1 for a boundary.
  int orientation = -1;
};

/// The decisions for the quadrilaterals that are here. A contact is told by the rank of the lower quadrilateral.
std::vector<Patch> patches(
  const Contacts& contacts, const std::vector<Index>& quads, const SurfaceNumbering& surface, const PartialMesh& mesh)
{
  std::vector<Patch> rows;
  QuadAt at;
  for (Index quad : quads)
  {
    at = surface.quadAt(quad, at.block);
    const bool boundary = contacts.boundary(at);
    if (contacts.undecided(at) || !mesh.isHere(at.block) || (!boundary && contacts.partner(at) < quad))
    {
      continue;
    }
    const Index partner = boundary ? -1 : contacts.partner(at);
    const int orientation = boundary ? -1 : contacts.orientation(at);
    if (rows.empty() || rows.back().orientation != orientation || !rows.back().row.append(quad, partner))
    {
      Patch patch;
      patch.rows.quad = patch.row.quad = quad;
      patch.rows.partner = patch.row.partner = partner;
      patch.orientation = orientation;
      rows.push_back(patch);
    }
  }
  std::vector<Patch> result;
  for (const Patch& next : rows)
  {
    const auto alike = [&](const Patch& other) {
      return other.orientation == next.orientation && other.row.count == next.row.count &&
        other.row.quadStep == next.row.quadStep && other.row.partnerStep == next.row.partnerStep;
    };
    if (result.empty() || !alike(result.back()) || !result.back().rows.append(next.row.quad, next.row.partner))
    {
      result.push_back(next);
    }
  }
  return result;
}

} // namespace

double matchDistance(const GridView& points, const Ijk& p, double matchTolerance)
{
  const Vec3 x = points(p);
  double shortest = std::numeric_limits<double>::max();
  for (int d = 0; d < 3; ++d)
  {
    for (int step = -1; step <= 1; step += 2)
    {
      Ijk q = p;
      q[d] += step;
      if (q[d] >= 0 && q[d] < points.counts()[d])
      {
        const double length = (points(q) - x).norm();
        // Edges of no length, where allowed, say nothing about the spacing.
        shortest = length > 0.0 ? std::min(shortest, length) : shortest;
      }
    }
  }
  return shortest == std::numeric_limits<double>::max() ? 0.0 : matchTolerance * shortest;
}

void appendUndecided(const SurfaceNumbering& surface, const Contacts& contacts, int block, int face,
  const FaceRange* range, std::vector<Index>& quads)
{
  if (contacts.onePiece(block, face) && !contacts.undecided(block, face))
  {
    return;
  }
  forEachUndecided(contacts, block, face, range ? *range : wholeFace(surface, block, face),
    [&](const QuadAt& at) { quads.push_back(surface.quad(at)); });
}

std::vector<Index> fetchNearQuads(PartialMesh& mesh, const SurfaceNumbering& surface, const Contacts& contacts,
  double matchTolerance, const Execution& run)
{
  const Ranks& ranks = *run.ranks;
  const std::vector<OpenFace> faces = openFaces(surface, contacts);
  const Index faceCount = static_cast<Index>(faces.size());

  // All ranks get the boxes of all these faces, inflated by the largest match distance on each.
  std::vector<double> distances(faceCount, 0.0);
  std::vector<Extent> extents(faceCount);
  run.parallelFor(faceCount, 1, [&](Index begin, Index end) {
    for (Index n = begin; n < end; ++n)
    {
      const OpenFace& face = faces[n];
      if (!mesh.isHere(face.block))
      {
        continue;
      }
      const GridView& points = mesh.mesh().blocks[face.block].points;
      Box box;
      for (int t = face.range.lo[1]; t <= face.range.hi[1]; ++t)
      {
        for (int s = face.range.lo[0]; s <= face.range.hi[0]; ++s)
        {
          const Ijk p = facePoint(surface.cells(face.block), face.face, s, t);
          box.extend(points(p));
          distances[n] = std::max(distances[n], matchDistance(points, p, matchTolerance));
        }
      }
      box = inflated(box, distances[n]);
      std::copy_n(box.min().data(), 3, extents[n].lo.begin());
      std::copy_n(box.max().data(), 3, extents[n].hi.begin());
    }
  });
  ranks.share(extents, [&](Index n) { return mesh.rankOf(faces[n].block); });
  std::vector<Box> boxes;
  for (const Extent& extent : extents)
  {
    boxes.emplace_back(Vec3(extent.lo.data()), Vec3(extent.hi.data()));
  }

  // Each rank finds what others need of its faces: of each the smallest rectangle with all quadrilaterals whose
  // inflated box meets that of a face of the other rank.
  struct Offer
  {
    Index openFace;
    FaceRange range;
  };
  const BoxTree tree(boxes);
  std::vector<std::map<int, FaceRange>> needed(faceCount);
  run.parallelFor(faceCount, 1, [&](Index begin, Index end) {
    for (Index n = begin; n < end; ++n)
    {
      const OpenFace& face = faces[n];
      std::map<int, std::vector<Box>> perRank;
      if (mesh.isHere(face.block))
      {
        tree.search(boxes[n], [&](Index other) {
          if (!mesh.isHere(faces[other].block) && boxes[n].intersects(boxes[other]))
          {
            perRank[mesh.rankOf(faces[other].block)].push_back(boxes[other]);
          }
        });
      }
      if (perRank.empty())
      {
        continue;
      }
      forEachUndecided(contacts, face.block, face.face, face.range, [&](const QuadAt& at) {
        Box box;
        for (int c = 0; c < 4; ++c)
        {
          box.extend(mesh.mesh().blocks[face.block].points(surface.corner(at, c & 1, c >> 1)));
        }
        box = inflated(box, distances[n]);
        for (const auto& others : perRank)
        {
          if (std::any_of(others.second.begin(), others.second.end(), [&](const Box& b) { return b.intersects(box); }))
          {
            extend(needed[n][others.first], at);
          }
        }
      });
    }
  });
  std::vector<std::vector<Offer>> offers(ranks.size());
  for (Index n = 0; n < faceCount; ++n)
  {
    for (const auto& part : needed[n])
    {
      offers[part.first].push_back({ n, part.second });
    }
  }
  // Of faces that are here everything is known, of others what is offered.
  std::vector<FaceRange> knownRanges(faceCount);
  for (Index n = 0; n < faceCount; ++n)
  {
    knownRanges[n] = mesh.isHere(faces[n].block) ? faces[n].range : FaceRange();
  }
  std::vector<PointBox> wanted;
  for (const std::vector<Offer>& part : ranks.exchange(offers))
  {
    for (const Offer& offer : part)
    {
      const OpenFace& face = faces[offer.openFace];
      knownRanges[offer.openFace] = offer.range;
      // The match distance of a point needs its neighbours.
      wanted.push_back(pointsAtFace(mesh.mesh(), face.block, face.face, offer.range, 2, 1));
    }
  }
  mesh.fetch(wanted);

  std::vector<Index> known;
  for (Index n = 0; n < faceCount; ++n)
  {
    appendUndecided(surface, contacts, faces[n].block, faces[n].face, &knownRanges[n], known);
  }
  return known;
}

void shareContacts(Contacts& contacts, const Contacts& before, const std::vector<Index>& quads,
  const SurfaceNumbering& surface, const PartialMesh& mesh, const Ranks& ranks)
{
  if (ranks.size() == 1)
  {
    return;
  }
  const std::vector<Patch> found = ranks.gatherAll(patches(contacts, quads, surface, mesh));
  contacts = before;
  QuadAt at, partner;
  for (const Patch& patch : found)
  {
    for (Index n = 0; n < patch.rows.count; ++n)
    {
      for (Index m = 0; m < patch.row.count; ++m)
      {
        at = surface.quadAt(patch.row.quad + n * patch.rows.quadStep + m * patch.row.quadStep, at.block);
        if (patch.orientation < 0)
        {
          contacts.setBoundary(at, -1);
        }
        else
        {
          partner =
            surface.quadAt(patch.row.partner + n * patch.rows.partnerStep + m * patch.row.partnerStep, partner.block);
          contacts.setContact(at, partner, patch.orientation);
        }
      }
    }
  }
}

} // namespace bsv
