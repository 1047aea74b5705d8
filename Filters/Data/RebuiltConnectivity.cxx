// SPDX-License-Identifier: BSD-3-Clause
// Contacts, boundaries and creases of a mesh out of what its blocks bring with them.
#include "Data/BlockTagArrays.h"

#include "Complex/GluingRanks.h"
#include "Mesh/BlockSurface.h"

#include <vtkStructuredGrid.h>

#include <map>

namespace bsv
{

namespace
{

/// A run of neighbouring places of a direction: first and last number along it.
struct Run
{
  int first = 0;
  int last = -1;
  int size() const { return this->last - this->first + 1; }
};

/// The numbers along a direction whose places are in [lo, hi].
Run within(const std::vector<int>& places, int lo, int hi)
{
  Run run;
  bool any = false;
  for (int n = 0; n < static_cast<int>(places.size()); ++n)
  {
    if (places[n] >= lo && places[n] <= hi)
    {
      run.first = any ? run.first : n;
      run.last = n;
      any = true;
    }
  }
  return run;
}

/// The direction that runs along a direction of the former block.
int along(const Tags& tags, int former)
{
  return tags.axis[0] == former ? 0 : tags.axis[1] == former ? 1 : 2;
}

/// The face that a face of the former block became, or -1 if its points are not there.
int faceNow(const Tags& tags, int face)
{
  const int d = along(tags, faceDirection(face));
  const int layer = faceSide(face) ? tags.counts[faceDirection(face)] - 1 : 0;
  return tags.places[d].front() == layer ? 2 * d : tags.places[d].back() == layer ? 2 * d + 1 : -1;
}

/// Rectangle of runs along the two directions of a face that they belong to.
FaceRange rangeOf(int face, int directionA, const Run& a, const Run& b)
{
  const bool first = faceAxis(face, 0) == directionA;
  const Run& s = first ? a : b;
  const Run& t = first ? b : a;
  return { { s.first, t.first }, { s.last, t.last } };
}

/// Makes connectivity of what the blocks bring.
class Rebuilder
{
public:
  Rebuilder(BlockMesh& mesh, const std::vector<Tags>& tags,
    const std::vector<vtkSmartPointer<vtkStructuredGrid>>& grids, const Ranks& ranks)
    : Mesh(mesh)
    , AllTags(tags)
    , Grids(grids)
    , Ranks_(ranks)
  {
  }

  void rebuild()
  {
    std::map<std::string, int> copies;
    for (const Tags& tags : this->AllTags)
    {
      ++copies[tags.key];
    }
    for (int b = 0; b < static_cast<int>(this->AllTags.size()); ++b)
    {
      const Tags& tags = this->AllTags[b];
      if (tags.key.empty())
      {
        continue;
      }
      if (!tags.placed)
      {
        ++this->Lost;
        this->Total[0] += static_cast<int>(tags.contacts.size());
        this->Total[1] += static_cast<int>(tags.boundaries.size());
        continue;
      }
      this->BlockOf[tags.key] = b;
      for (const Tags::Boundary& boundary : tags.boundaries)
      {
        this->takeBoundary(b, boundary);
      }
      for (const CreaseLine& line : tags.creases)
      {
        this->takeCrease(b, line);
      }
    }
    for (int b = 0; b < static_cast<int>(this->AllTags.size()); ++b)
    {
      const Tags& tags = this->AllTags[b];
      for (const Tags::Contact& contact : tags.contacts)
      {
        if (!tags.placed)
        {
          continue;
        }
        ++this->Total[0];
        const int other = contact.other == tags.key ? b : this->find(contact.other);
        if (other < 0)
        {
          ++this->Absent;
        }
        else if (contact.other != tags.key && (copies[tags.key] > 1 || copies[contact.other] > 1))
        {
          ++this->Ambiguous;
        }
        else
        {
          this->takeContact(b, other, contact.contact);
        }
      }
    }
    this->dropMoved();
    this->tell();
  }

private:
  int find(const std::string& key) const
  {
    const auto found = this->BlockOf.find(key);
    return found == this->BlockOf.end() ? -1 : found->second;
  }

  void takeBoundary(int b, const Tags::Boundary& boundary)
  {
    ++this->Total[1];
    const Tags& tags = this->AllTags[b];
    const int face = faceNow(tags, boundary.face);
    const int s = along(tags, faceAxis(boundary.face, 0));
    const int t = along(tags, faceAxis(boundary.face, 1));
    const Run runS = within(tags.places[s], boundary.range.lo[0], boundary.range.hi[0]);
    const Run runT = within(tags.places[t], boundary.range.lo[1], boundary.range.hi[1]);
    if (face < 0 || runS.size() < 2 || runT.size() < 2)
    {
      ++this->OutsideBoundaries;
      return;
    }
    this->Between += this->endsBetween(tags.places[s], runS, boundary.range.lo[0], boundary.range.hi[0]) ||
      this->endsBetween(tags.places[t], runT, boundary.range.lo[1], boundary.range.hi[1]);
    this->Mesh.boundaries.push_back({ b, face, rangeOf(face, s, runS, runT), this->tag(boundary) });
  }

  /// Whether a border of [lo, hi] falls between two of the places.
  static bool endsBetween(const std::vector<int>& places, const Run& run, int lo, int hi)
  {
    const auto cut = [&](int n, int beyond) {
      return beyond >= 0 && beyond < static_cast<int>(places.size()) && places[n] != lo && places[n] != hi;
    };
    return cut(run.first, run.first - 1) || cut(run.last, run.last + 1);
  }

  int tag(const Tags::Boundary& boundary)
  {
    for (std::size_t n = 0; n < this->Mesh.boundaryNames.size(); ++n)
    {
      if (this->Mesh.boundaryNames[n] == boundary.name && this->Mesh.boundaryTypes[n] == boundary.type)
      {
        return static_cast<int>(n);
      }
    }
    this->Mesh.boundaryNames.push_back(boundary.name);
    this->Mesh.boundaryTypes.push_back(boundary.type);
    return static_cast<int>(this->Mesh.boundaryNames.size()) - 1;
  }

  void takeCrease(int b, const CreaseLine& line)
  {
    const Tags& tags = this->AllTags[b];
    CreaseLine result;
    result.block = b;
    int directions = 0;
    for (int former = 0; former < 3; ++former)
    {
      const int d = along(tags, former);
      const Run run = within(
        tags.places[d], std::min(line.from[former], line.to[former]), std::max(line.from[former], line.to[former]));
      if (run.size() < 1 || (line.from[former] != line.to[former] && run.size() < 2))
      {
        return;
      }
      result.from[d] = run.first;
      result.to[d] = run.last;
      directions += run.size() > 1;
    }
    if (directions == 1)
    {
      this->Mesh.creases.push_back(result);
    }
  }

  void takeContact(int a, int b, const Interface& former)
  {
    const Tags& tagsA = this->AllTags[a];
    const Tags& tagsB = this->AllTags[b];
    const FaceRange whole = wholeFace(tagsB.counts, former.faceB);
    const FaceRange rangeB = former.rangeB();
    if (former.originB[0] < 0 || former.originB[1] < 0 || rangeB.hi[0] > whole.hi[0] || rangeB.hi[1] > whole.hi[1])
    {
      ++this->Absent;
      return;
    }
    Interface contact;
    contact.blockA = a;
    contact.blockB = b;
    contact.faceA = faceNow(tagsA, former.faceA);
    contact.faceB = faceNow(tagsB, former.faceB);
    if (contact.faceA < 0 || contact.faceB < 0)
    {
      ++this->Absent;
      return;
    }
    const bool swap = swapsAxes(former.orientation);
    Run runsA[2];
    Run runsB[2]; // of the axis of B that meets the axis of A
    for (int axis = 0; axis < 2; ++axis)
    {
      const int axisB = swap ? 1 - axis : axis;
      const bool reversed = (former.orientation & (axisB == 0 ? 2 : 4)) != 0;
      const int dA = along(tagsA, faceAxis(former.faceA, axis));
      const int dB = along(tagsB, faceAxis(former.faceB, axisB));
      const std::vector<int>& placesA = tagsA.places[dA];
      const std::vector<int>& placesB = tagsB.places[dB];
      const int lo = former.rangeA.lo[axis];
      const int hi = former.rangeA.hi[axis];
      // Where a place of A is on B, both within the contact.
      const auto onB = [&](int place) { return rangeB.lo[axisB] + (reversed ? hi - place : place - lo); };
      const auto onA = [&](int place) {
        return reversed ? hi - (place - rangeB.lo[axisB]) : lo + (place - rangeB.lo[axisB]);
      };
      Run runA = within(placesA, lo, hi);
      Run runB = within(placesB, rangeB.lo[axisB], rangeB.hi[axisB]);
      if (runA.size() < 2 || runB.size() < 2)
      {
        ++this->Absent;
        return;
      }
      // What both have.
      const auto ends = std::minmax({ placesA[runA.first], placesA[runA.last] });
      const auto endsB = std::minmax({ onA(placesB[runB.first]), onA(placesB[runB.last]) });
      const int from = std::max(ends.first, endsB.first);
      const int to = std::min(ends.second, endsB.second);
      runA = within(placesA, from, to);
      const auto shared = std::minmax({ onB(from), onB(to) });
      runB = within(placesB, shared.first, shared.second);
      if (from >= to || runA.size() < 2 || runB.size() < 2)
      {
        ++this->Absent;
        return;
      }
      const bool same = onB(placesA[runA.first]) == placesB[runB.first];
      bool matches = runA.size() == runB.size();
      for (int n = 0; matches && n < runA.size(); ++n)
      {
        matches = onB(placesA[runA.first + n]) == placesB[same ? runB.first + n : runB.last - n];
      }
      if (!matches)
      {
        ++this->Unmatched;
        return;
      }
      runsA[axis] = runA;
      runsB[axis] = runB;
      // Axis of the face now, on both sides.
      const int nowB = faceAxis(contact.faceB, 0) == dB ? 0 : 1;
      const int nowA = faceAxis(contact.faceA, 0) == dA ? 0 : 1;
      contact.orientation |= nowA != nowB ? 1 : 0;
      contact.orientation |= same ? 0 : nowB == 0 ? 2 : 4;
      contact.originB[nowB] = runB.first;
    }
    contact.rangeA = rangeOf(contact.faceA, along(tagsA, faceAxis(former.faceA, 0)), runsA[0], runsA[1]);
    this->Mesh.interfaces.push_back(contact);
  }

  /// Leaves out contacts whose blocks were moved away from each other.
  void dropMoved()
  {
    std::vector<char> moved(this->Mesh.interfaces.size(), false);
    for (std::size_t n = 0; n < moved.size(); ++n)
    {
      const Interface& c = this->Mesh.interfaces[n];
      if (!this->Grids[c.blockA] || !this->Grids[c.blockB])
      {
        continue;
      }
      const GridView& a = this->Mesh.blocks[c.blockA].points;
      const GridView& b = this->Mesh.blocks[c.blockB].points;
      const int ns = c.rangeA.hi[0] - c.rangeA.lo[0];
      const int nt = c.rangeA.hi[1] - c.rangeA.lo[1];
      for (int corner = 0; corner < 4 && !moved[n]; ++corner)
      {
        const int s = corner & 1 ? ns : 0;
        const int t = corner & 2 ? nt : 0;
        const auto onB = mapFacePoint(c.orientation, s, t, ns, nt);
        const Ijk p = pointOn(a.counts(), c.faceA, c.rangeA.lo[0] + s, c.rangeA.lo[1] + t);
        const Ijk q = pointOn(b.counts(), c.faceB, c.originB[0] + onB[0], c.originB[1] + onB[1]);
        // Looser than the gluing, which has the last word.
        constexpr double Apart = 0.5;
        moved[n] = (a(p) - b(q)).norm() > std::max(matchDistance(a, p, Apart), matchDistance(b, q, Apart));
      }
    }
    this->Ranks_.share(moved, [&](Index n) { return this->Mesh.blocks[this->Mesh.interfaces[n].blockA].rank; });
    std::vector<Interface> kept;
    for (std::size_t n = 0; n < moved.size(); ++n)
    {
      if (!moved[n])
      {
        kept.push_back(this->Mesh.interfaces[n]);
      }
    }
    this->Moved = static_cast<int>(moved.size() - kept.size());
    this->Mesh.interfaces = std::move(kept);
  }

  void tell()
  {
    if (std::all_of(this->Mesh.boundaryTypes.begin(), this->Mesh.boundaryTypes.end(),
          [](const std::string& type) { return type.empty(); }))
    {
      this->Mesh.boundaryTypes.clear();
    }
    for (std::string& type : this->Mesh.boundaryTypes)
    {
      type = type.empty() ? "BCTypeUserDefined" : type;
    }
    std::string note =
      "The blocks are not those that the arrays of the mesh count; what they bring with them is used: " +
      std::to_string(this->Mesh.interfaces.size()) + " of " + std::to_string(this->Total[0]) + " interfaces";
    std::string dropped;
    const auto add = [&](int number, const char* what) {
      if (number > 0)
      {
        dropped += (dropped.empty() ? "" : ", ") + std::to_string(number) + " " + what;
      }
    };
    add(this->Absent, "with faces that are not there");
    add(this->Unmatched, "of different points on both sides");
    add(this->Ambiguous, "between blocks that are there several times");
    add(this->Moved, "of blocks that were moved apart");
    note += dropped.empty() ? "" : " (dropped: " + dropped + ")";
    note += ", " + std::to_string(this->Mesh.boundaries.size()) + " of " + std::to_string(this->Total[1]) +
      " parts of named boundaries";
    dropped.clear();
    add(this->OutsideBoundaries, "outside");
    note += dropped.empty() ? "" : " (dropped: " + dropped + ")";
    note += ".";
    this->Mesh.notes.push_back(note);
    if (this->Between > 0)
    {
      this->Mesh.notes.push_back("The border of " + std::to_string(this->Between) +
        " parts of named boundaries falls between the points that are left; it was moved inwards.");
    }
    if (this->Lost > 0)
    {
      this->Mesh.warnings.push_back("The points of " + std::to_string(this->Lost) +
        " blocks are no box of the block that they were; their names and contacts are dropped.");
    }
  }

  BlockMesh& Mesh;
  const std::vector<Tags>& AllTags;
  const std::vector<vtkSmartPointer<vtkStructuredGrid>>& Grids;
  const Ranks& Ranks_;
  std::map<std::string, int> BlockOf;
  /// Contacts and boundaries that all blocks brought.
  int Total[2] = { 0, 0 };
  int Lost = 0;
  int Absent = 0;
  int Unmatched = 0;
  int Ambiguous = 0;
  int Moved = 0;
  int OutsideBoundaries = 0;
  int Between = 0;
};

} // namespace

void takeTags(BlockMesh& mesh, const std::vector<vtkSmartPointer<vtkStructuredGrid>>& grids, const Ranks& ranks)
{
  const std::vector<Tags> tags = gatherTags(grids, ranks);
  Rebuilder(mesh, tags, grids, ranks).rebuild();
}

} // namespace bsv
