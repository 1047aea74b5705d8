// SPDX-License-Identifier: BSD-3-Clause
#include "Data/BlockTags.h"

#include "Complex/GluingRanks.h"
#include "Mesh/BlockSurface.h"

#include <vtkCellType.h>
#include <vtkDataSet.h>
#include <vtkFieldData.h>
#include <vtkIdList.h>
#include <vtkIdTypeArray.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPartitionedDataSetCollection.h>
#include <vtkPointData.h>
#include <vtkStringArray.h>
#include <vtkStructuredGrid.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <limits>
#include <map>
#include <optional>

namespace bsv
{

namespace
{

constexpr const char* OwnArrays[] = { "BlockKey", "BlockDimensions", "BlockFirstPoint", "BlockInterfaces",
  "BlockInterfaceKeys", "BlockBoundaries", "BlockBoundaryNames", "BlockBoundaryTypes", "BlockCreases" };

FaceRange wholeFace(const Ijk& counts, int face)
{
  return { { 0, 0 }, { counts[faceAxis(face, 0)] - 1, counts[faceAxis(face, 1)] - 1 } };
}

Ijk pointAt(const Ijk& counts, Index n)
{
  return { static_cast<int>(n % counts[0]), static_cast<int>(n / counts[0] % counts[1]),
    static_cast<int>(n / counts[0] / counts[1]) };
}

Index sizeOf(const Ijk& counts)
{
  return Index(counts[0]) * counts[1] * counts[2];
}

class Hash
{
public:
  void add(const void* data, std::size_t size)
  {
    for (std::size_t n = 0; n < size; ++n)
    {
      this->Value = (this->Value ^ static_cast<const unsigned char*>(data)[n]) * 1099511628211u;
    }
  }
  void add(const std::string& text) { this->add(text.c_str(), text.size() + 1); }
  void add(int value) { this->add(&value, sizeof value); }
  std::string text() const
  {
    char digits[17];
    std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(this->Value));
    return digits;
  }

private:
  std::uint64_t Value = 14695981039346656037u; // FNV-1a
};

/// The same on all ranks: it is made of what all of them know.
std::string meshKey(const BlockMesh& mesh, const std::string& source)
{
  Hash hash;
  hash.add(source);
  for (const MeshBlock& block : mesh.blocks)
  {
    hash.add(block.name);
  }
  for (const Interface& c : mesh.interfaces)
  {
    for (int n : { c.blockA, c.faceA, c.blockB, c.faceB, c.orientation, c.rangeA.lo[0], c.rangeA.lo[1] })
    {
      hash.add(n);
    }
  }
  for (const BoundaryPatch& patch : mesh.boundaries)
  {
    for (int n : { patch.block, patch.face, patch.tag, patch.range.lo[0], patch.range.lo[1] })
    {
      hash.add(n);
    }
  }
  return hash.text();
}

std::string blockKey(const std::string& meshKey, std::size_t block)
{
  return meshKey + "/" + std::to_string(block);
}

vtkSmartPointer<vtkStringArray> strings(const char* name, const std::vector<std::string>& values)
{
  auto array = vtkSmartPointer<vtkStringArray>::New();
  array->SetName(name);
  for (const std::string& value : values)
  {
    array->InsertNextValue(value);
  }
  return array;
}

vtkSmartPointer<vtkIntArray> ints(const char* name, int components, const std::vector<int>& values)
{
  auto array = vtkSmartPointer<vtkIntArray>::New();
  array->SetName(name);
  array->SetNumberOfComponents(components);
  array->SetNumberOfValues(static_cast<vtkIdType>(values.size()));
  std::copy(values.begin(), values.end(), array->GetPointer(0));
  return array;
}

std::vector<std::string> stringsOf(vtkFieldData* fields, const char* name)
{
  std::vector<std::string> values;
  auto* array = fields ? vtkStringArray::SafeDownCast(fields->GetAbstractArray(name)) : nullptr;
  for (vtkIdType n = 0; array && n < array->GetNumberOfValues(); ++n)
  {
    values.push_back(array->GetValue(n));
  }
  return values;
}

std::vector<int> intsOf(vtkFieldData* fields, const char* name, int components)
{
  auto* array = fields ? vtkIntArray::SafeDownCast(fields->GetAbstractArray(name)) : nullptr;
  if (!array || array->GetNumberOfComponents() != components)
  {
    return {};
  }
  return { array->GetPointer(0), array->GetPointer(array->GetNumberOfValues()) };
}

/// Numbers the points of a block from `first` on.
template <typename Array>
void addPointNumbers(vtkStructuredGrid* grid, Index first)
{
  vtkNew<Array> array;
  array->SetName("MeshPointIds");
  array->SetNumberOfValues(grid->GetNumberOfPoints());
  for (vtkIdType n = 0; n < grid->GetNumberOfPoints(); ++n)
  {
    array->SetValue(n, static_cast<typename Array::ValueType>(first + n));
  }
  grid->GetPointData()->AddArray(array);
}

/// What a block brings with it, and where its points were in the block that it was.
struct Tags
{
  std::string key;
  /// Points per direction of the block that it was.
  Ijk counts{ 0, 0, 0 };
  /// False if its points form no box of that block.
  bool placed = false;
  /// Direction of the former block along which each direction runs, and the places there.
  Ijk axis{ 0, 1, 2 };
  std::array<std::vector<int>, 3> places;

  struct Contact
  {
    Interface contact; // blockA and blockB are not used
    std::string other;
  };
  std::vector<Contact> contacts;
  struct Boundary
  {
    int face;
    FaceRange range;
    std::string name;
    std::string type;
  };
  std::vector<Boundary> boundaries;
  std::vector<CreaseLine> creases; // block is not used

  bool was(const Ijk& points) const { return this->counts == points; }
};

/// Sends tags between ranks: whole numbers and texts.
class Packed
{
public:
  std::vector<char> bytes;

  void add(int value)
  {
    const char* data = reinterpret_cast<const char*>(&value);
    this->bytes.insert(this->bytes.end(), data, data + sizeof value);
  }
  void add(const std::string& text)
  {
    this->add(static_cast<int>(text.size()));
    this->bytes.insert(this->bytes.end(), text.begin(), text.end());
  }
  int number()
  {
    int value = 0;
    std::memcpy(&value, this->bytes.data() + this->at, sizeof value);
    this->at += sizeof value;
    return value;
  }
  std::string text()
  {
    const int size = this->number();
    std::string value(this->bytes.data() + this->at, size);
    this->at += size;
    return value;
  }
  bool atEnd() const { return this->at >= this->bytes.size(); }

private:
  std::size_t at = 0;
};

void pack(Packed& to, const Tags& tags)
{
  to.add(tags.key);
  to.add(tags.placed ? 1 : 0);
  for (int d = 0; d < 3; ++d)
  {
    to.add(tags.counts[d]);
    to.add(tags.axis[d]);
    to.add(static_cast<int>(tags.places[d].size()));
    for (int place : tags.places[d])
    {
      to.add(place);
    }
  }
  const auto range = [&](const FaceRange& r) {
    for (int n : { r.lo[0], r.hi[0], r.lo[1], r.hi[1] })
    {
      to.add(n);
    }
  };
  to.add(static_cast<int>(tags.contacts.size()));
  for (const Tags::Contact& c : tags.contacts)
  {
    for (int n :
      { c.contact.faceA, c.contact.faceB, c.contact.originB[0], c.contact.originB[1], c.contact.orientation })
    {
      to.add(n);
    }
    range(c.contact.rangeA);
    to.add(c.other);
  }
  to.add(static_cast<int>(tags.boundaries.size()));
  for (const Tags::Boundary& b : tags.boundaries)
  {
    to.add(b.face);
    range(b.range);
    to.add(b.name);
    to.add(b.type);
  }
  to.add(static_cast<int>(tags.creases.size()));
  for (const CreaseLine& line : tags.creases)
  {
    for (int d = 0; d < 3; ++d)
    {
      to.add(line.from[d]);
      to.add(line.to[d]);
    }
  }
}

Tags unpack(Packed& from)
{
  Tags tags;
  tags.key = from.text();
  tags.placed = from.number() == 1;
  for (int d = 0; d < 3; ++d)
  {
    tags.counts[d] = from.number();
    tags.axis[d] = from.number();
    tags.places[d].resize(from.number());
    for (int& place : tags.places[d])
    {
      place = from.number();
    }
  }
  const auto range = [&] {
    FaceRange r;
    for (int* n : { &r.lo[0], &r.hi[0], &r.lo[1], &r.hi[1] })
    {
      *n = from.number();
    }
    return r;
  };
  tags.contacts.resize(from.number());
  for (Tags::Contact& c : tags.contacts)
  {
    for (int* n :
      { &c.contact.faceA, &c.contact.faceB, &c.contact.originB[0], &c.contact.originB[1], &c.contact.orientation })
    {
      *n = from.number();
    }
    c.contact.rangeA = range();
    c.other = from.text();
  }
  tags.boundaries.resize(from.number());
  for (Tags::Boundary& b : tags.boundaries)
  {
    b.face = from.number();
    b.range = range();
    b.name = from.text();
    b.type = from.text();
  }
  tags.creases.resize(from.number());
  for (CreaseLine& line : tags.creases)
  {
    for (int d = 0; d < 3; ++d)
    {
      line.from[d] = from.number();
      line.to[d] = from.number();
    }
  }
  return tags;
}

/// Finds where the points of a grid were in the block that it was.
void placePoints(vtkStructuredGrid* grid, Tags& tags)
{
  Ijk counts{};
  grid->GetDimensions(counts.data());
  vtkDataArray* ids = grid->GetPointData()->GetArray("MeshPointIds");
  auto* first = vtkDataArray::SafeDownCast(grid->GetFieldData()->GetAbstractArray("BlockFirstPoint"));
  if (!ids || !first || first->GetNumberOfTuples() != 1 || ids->GetNumberOfTuples() != sizeOf(counts))
  {
    // Nothing tells of another place; a grid of the same size is taken as the block itself.
    tags.placed = tags.was(counts);
    for (int d = 0; d < 3 && tags.placed; ++d)
    {
      for (int n = 0; n < counts[d]; ++n)
      {
        tags.places[d].push_back(n);
      }
    }
    return;
  }
  const Index size = sizeOf(tags.counts);
  const auto place = [&](const Ijk& p) -> std::optional<Ijk> {
    const double id =
      ids->GetTuple1(p[0] + vtkIdType(counts[0]) * (p[1] + vtkIdType(counts[1]) * p[2])) - first->GetTuple1(0);
    if (!(id >= 0.0 && id < static_cast<double>(size)))
    {
      return std::nullopt;
    }
    return pointAt(tags.counts, static_cast<Index>(id));
  };
  const std::optional<Ijk> origin = place({ 0, 0, 0 });
  if (!origin)
  {
    return;
  }
  for (int d = 0; d < 3; ++d)
  {
    std::vector<Ijk> line;
    for (int n = 0; n < counts[d]; ++n)
    {
      Ijk p{ 0, 0, 0 };
      p[d] = n;
      const std::optional<Ijk> at = place(p);
      if (!at)
      {
        return;
      }
      line.push_back(*at);
    }
    int axis = -1;
    for (int e = 0; e < 3; ++e)
    {
      if (line[1][e] != line[0][e])
      {
        if (axis >= 0)
        {
          return;
        }
        axis = e;
      }
    }
    if (axis < 0)
    {
      return;
    }
    tags.axis[d] = axis;
    const bool up = line[1][axis] > line[0][axis];
    for (std::size_t n = 0; n < line.size(); ++n)
    {
      Ijk expected = *origin;
      expected[axis] = line[n][axis];
      if (line[n] != expected || (n > 0 && (line[n][axis] > line[n - 1][axis]) != up) ||
        (n > 0 && line[n][axis] == line[n - 1][axis]))
      {
        return;
      }
      tags.places[d].push_back(line[n][axis]);
    }
  }
  if (tags.axis[0] == tags.axis[1] || tags.axis[0] == tags.axis[2] || tags.axis[1] == tags.axis[2])
  {
    return;
  }
  for (int c = 0; c < 8; ++c)
  {
    Ijk p{};
    Ijk expected{};
    for (int d = 0; d < 3; ++d)
    {
      p[d] = cornerSide(c, d) * (counts[d] - 1);
      expected[tags.axis[d]] = tags.places[d][p[d]];
    }
    if (place(p) != expected)
    {
      return;
    }
  }
  tags.placed = true;
}

/// Tags of a grid that is here; one without a key brings nothing.
Tags readTags(vtkStructuredGrid* grid)
{
  Tags tags;
  vtkFieldData* fields = grid->GetFieldData();
  const std::vector<std::string> key = stringsOf(fields, "BlockKey");
  const std::vector<int> counts = intsOf(fields, "BlockDimensions", 3);
  if (key.size() != 1 || counts.size() != 3 || counts[0] < 2 || counts[1] < 2 || counts[2] < 2)
  {
    return tags;
  }
  tags.key = key[0];
  std::copy(counts.begin(), counts.end(), tags.counts.begin());
  placePoints(grid, tags);
  const auto valid = [&](int face, const FaceRange& range) {
    if (face < 0 || face > 5)
    {
      return false;
    }
    const FaceRange whole = wholeFace(tags.counts, face);
    return range.lo[0] >= 0 && range.lo[0] < range.hi[0] && range.hi[0] <= whole.hi[0] && range.lo[1] >= 0 &&
      range.lo[1] < range.hi[1] && range.hi[1] <= whole.hi[1];
  };
  const std::vector<int> contacts = intsOf(fields, "BlockInterfaces", 9);
  const std::vector<std::string> others = stringsOf(fields, "BlockInterfaceKeys");
  for (std::size_t n = 0; n + 9 <= contacts.size() && n / 9 < others.size(); n += 9)
  {
    const int* c = contacts.data() + n;
    Tags::Contact contact{ { 0, c[0], 0, c[5], c[8], { { c[1], c[3] }, { c[2], c[4] } }, { c[6], c[7] } },
      others[n / 9] };
    if (valid(c[0], contact.contact.rangeA) && c[5] >= 0 && c[5] < 6 && c[8] >= 0 && c[8] < 8)
    {
      tags.contacts.push_back(contact);
    }
  }
  const std::vector<int> boundaries = intsOf(fields, "BlockBoundaries", 5);
  const std::vector<std::string> names = stringsOf(fields, "BlockBoundaryNames");
  const std::vector<std::string> types = stringsOf(fields, "BlockBoundaryTypes");
  for (std::size_t n = 0; n + 5 <= boundaries.size() && n / 5 < names.size(); n += 5)
  {
    const int* b = boundaries.data() + n;
    const Tags::Boundary boundary{ b[0], { { b[1], b[3] }, { b[2], b[4] } }, names[n / 5],
      n / 5 < types.size() ? types[n / 5] : std::string() };
    if (valid(boundary.face, boundary.range))
    {
      tags.boundaries.push_back(boundary);
    }
  }
  const std::vector<int> creases = intsOf(fields, "BlockCreases", 6);
  for (std::size_t n = 0; n + 6 <= creases.size(); n += 6)
  {
    const int* c = creases.data() + n;
    tags.creases.push_back({ 0, { c[0], c[1], c[2] }, { c[3], c[4], c[5] } });
  }
  return tags;
}

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
        this->count(this->Lost, 1);
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
  static void count(int& counter, int more) { counter += more; }

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
      if (moved[n])
      {
        ++this->Moved;
      }
      else
      {
        kept.push_back(this->Mesh.interfaces[n]);
      }
    }
    this->Mesh.interfaces = std::move(kept);
  }

  static Ijk pointOn(const Ijk& counts, int face, int s, int t)
  {
    Ijk p{};
    p[faceDirection(face)] = faceSide(face) ? counts[faceDirection(face)] - 1 : 0;
    p[faceAxis(face, 0)] = s;
    p[faceAxis(face, 1)] = t;
    return p;
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

void removeMeshKeys(vtkFieldData* fields)
{
  fields->RemoveArray("MeshBlockKeys");
  fields->RemoveArray("MeshBlockDimensions");
}

void tagBlocks(
  vtkPartitionedDataSetCollection* collection, const BlockMesh& mesh, const std::string& source, bool numberPoints)
{
  const std::string key = meshKey(mesh, source);
  std::vector<std::string> keys;
  std::vector<int> dimensions;
  std::vector<Index> first;
  Index points = 0;
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b)
  {
    const Ijk& counts = mesh.blocks[b].points.counts();
    keys.push_back(blockKey(key, b));
    dimensions.insert(dimensions.end(), counts.begin(), counts.end());
    first.push_back(points);
    points += sizeOf(counts);
  }
  std::vector<std::vector<int>> contacts(mesh.blocks.size());
  std::vector<std::vector<std::string>> others(mesh.blocks.size());
  for (const Interface& c : mesh.interfaces)
  {
    contacts[c.blockA].insert(contacts[c.blockA].end(),
      { c.faceA, c.rangeA.lo[0], c.rangeA.hi[0], c.rangeA.lo[1], c.rangeA.hi[1], c.faceB, c.originB[0], c.originB[1],
        c.orientation });
    others[c.blockA].push_back(keys[c.blockB]);
  }
  std::vector<std::vector<int>> boundaries(mesh.blocks.size());
  std::vector<std::vector<std::string>> names(mesh.blocks.size());
  std::vector<std::vector<std::string>> types(mesh.blocks.size());
  for (const BoundaryPatch& b : mesh.boundaries)
  {
    boundaries[b.block].insert(
      boundaries[b.block].end(), { b.face, b.range.lo[0], b.range.hi[0], b.range.lo[1], b.range.hi[1] });
    names[b.block].push_back(mesh.boundaryNames[b.tag]);
    types[b.block].push_back(mesh.boundaryTypes.empty() ? std::string() : mesh.boundaryTypes[b.tag]);
  }
  std::vector<std::vector<int>> creases(mesh.blocks.size());
  for (const CreaseLine& line : mesh.creases)
  {
    creases[line.block].insert(creases[line.block].end(), line.from.begin(), line.from.end());
    creases[line.block].insert(creases[line.block].end(), line.to.begin(), line.to.end());
  }

  for (std::size_t b = 0; b < mesh.blocks.size(); ++b)
  {
    auto* grid = vtkStructuredGrid::SafeDownCast(collection->GetPartitionAsDataObject(static_cast<unsigned int>(b), 0));
    if (!grid)
    {
      continue;
    }
    vtkFieldData* fields = grid->GetFieldData();
    for (const char* name : OwnArrays)
    {
      fields->RemoveArray(name);
    }
    fields->AddArray(strings("BlockKey", { keys[b] }));
    fields->AddArray(ints("BlockDimensions", 3, { dimensions.begin() + 3 * b, dimensions.begin() + 3 * b + 3 }));
    if (!contacts[b].empty())
    {
      fields->AddArray(ints("BlockInterfaces", 9, contacts[b]));
      fields->AddArray(strings("BlockInterfaceKeys", others[b]));
    }
    if (!boundaries[b].empty())
    {
      fields->AddArray(ints("BlockBoundaries", 5, boundaries[b]));
      fields->AddArray(strings("BlockBoundaryNames", names[b]));
      fields->AddArray(strings("BlockBoundaryTypes", types[b]));
    }
    if (!creases[b].empty())
    {
      fields->AddArray(ints("BlockCreases", 6, creases[b]));
    }
    if (!numberPoints)
    {
      continue;
    }
    vtkNew<vtkIdTypeArray> firstPoint;
    firstPoint->SetName("BlockFirstPoint");
    firstPoint->InsertNextValue(first[b]);
    fields->AddArray(firstPoint);
    if (points <= std::numeric_limits<int>::max())
    {
      addPointNumbers<vtkIntArray>(grid, first[b]);
    }
    else
    {
      addPointNumbers<vtkIdTypeArray>(grid, first[b]);
    }
  }
  removeMeshKeys(collection->GetFieldData());
  collection->GetFieldData()->AddArray(strings("MeshBlockKeys", keys));
  // Of volumes the sizes of blocks that are elsewhere are not known; each block has its own.
  if (numberPoints)
  {
    collection->GetFieldData()->AddArray(ints("MeshBlockDimensions", 3, dimensions));
  }
}

bool arraysFitBlocks(vtkFieldData* fields, const BlockMesh& mesh,
  const std::vector<vtkSmartPointer<vtkStructuredGrid>>& grids, const Ranks& ranks)
{
  const std::vector<std::string> keys = stringsOf(fields, "MeshBlockKeys");
  const std::vector<int> dimensions = intsOf(fields, "MeshBlockDimensions", 3);
  const bool counted = !keys.empty() && (dimensions.empty() || dimensions.size() == 3 * keys.size());
  const bool anyArray =
    fields && (fields->HasArray("Interfaces") || fields->HasArray("Boundaries") || fields->HasArray("CreaseEdges"));
  bool fits = true;
  if (!counted)
  {
    // Arrays that nobody counted are taken as they are; without any the blocks may bring theirs.
    const bool brought = std::any_of(grids.begin(), grids.end(),
      [](vtkStructuredGrid* grid) { return grid && grid->GetFieldData()->HasArray("BlockKey"); });
    // A grid alone is no mesh: what it brings is its own.
    const bool own = fields && fields->HasArray("BlockKey");
    return !ranks.any(brought && (!anyArray || own));
  }
  fits = keys.size() == mesh.blocks.size();
  for (std::size_t b = 0; b < mesh.blocks.size() && fits; ++b)
  {
    fits = dimensions.empty() ||
      std::equal(dimensions.begin() + 3 * b, dimensions.begin() + 3 * b + 3, mesh.blocks[b].points.counts().begin());
    if (fits && grids[b] && grids[b]->GetFieldData()->HasArray("BlockKey"))
    {
      const Tags tags = readTags(grids[b]);
      fits = tags.key == keys[b] && tags.placed;
      for (int d = 0; d < 3 && fits; ++d)
      {
        fits = tags.axis[d] == d && tags.places[d].front() == 0;
      }
    }
  }
  return !ranks.any(!fits);
}

void takeTags(BlockMesh& mesh, const std::vector<vtkSmartPointer<vtkStructuredGrid>>& grids, const Ranks& ranks)
{
  Packed mine;
  for (std::size_t b = 0; b < grids.size(); ++b)
  {
    if (grids[b])
    {
      mine.add(static_cast<int>(b));
      pack(mine, readTags(grids[b]));
    }
  }
  std::vector<Tags> tags(mesh.blocks.size());
  for (std::vector<char>& bytes : ranks.gather(mine.bytes))
  {
    Packed from;
    from.bytes = std::move(bytes);
    while (!from.atEnd())
    {
      const int b = from.number();
      tags[b] = unpack(from);
    }
  }
  Rebuilder(mesh, tags, grids, ranks).rebuild();
}

FormerBoundaries::FormerBoundaries(vtkFieldData* mesh, vtkDataSet* grid)
{
  if (!grid->GetPointData()->HasArray("MeshPointIds"))
  {
    return;
  }
  const std::vector<int> dimensions = intsOf(mesh, "MeshBlockDimensions", 3);
  if (!dimensions.empty())
  {
    Index first = 0;
    for (std::size_t b = 0; 3 * b + 3 <= dimensions.size(); ++b)
    {
      this->Counts.push_back({ dimensions[3 * b], dimensions[3 * b + 1], dimensions[3 * b + 2] });
      this->First.push_back(first);
      first += sizeOf(this->Counts.back());
    }
    const std::vector<std::string> names = stringsOf(mesh, "BoundaryNames");
    const std::vector<std::string> types = stringsOf(mesh, "BoundaryTypes");
    for (int components : { 3, 7 })
    {
      const std::vector<int> values = intsOf(mesh, "Boundaries", components);
      for (std::size_t n = 0; n + components <= values.size(); n += components)
      {
        const int* v = values.data() + n;
        if (v[0] >= 0 && v[0] < static_cast<int>(this->Counts.size()) && v[1] >= 0 && v[1] < 6 && v[2] >= 0 &&
          v[2] < static_cast<int>(names.size()))
        {
          const FaceRange range =
            components == 3 ? wholeFace(this->Counts[v[0]], v[1]) : FaceRange{ { v[3], v[5] }, { v[4], v[6] } };
          this->addPatch(v[0], v[1], range, names[v[2]], types.size() == names.size() ? types[v[2]] : std::string());
        }
      }
    }
    this->addContacts(mesh);
    if (!this->Patches.empty())
    {
      this->addMergedPoints(grid);
    }
    return;
  }
  const std::vector<int> counts = intsOf(grid->GetFieldData(), "BlockDimensions", 3);
  auto* first = vtkDataArray::SafeDownCast(grid->GetFieldData()->GetAbstractArray("BlockFirstPoint"));
  if (counts.size() != 3 || !first || first->GetNumberOfTuples() != 1)
  {
    return;
  }
  this->Counts.push_back({ counts[0], counts[1], counts[2] });
  this->First.push_back(static_cast<Index>(first->GetTuple1(0)));
  const std::vector<int> values = intsOf(grid->GetFieldData(), "BlockBoundaries", 5);
  const std::vector<std::string> names = stringsOf(grid->GetFieldData(), "BlockBoundaryNames");
  const std::vector<std::string> types = stringsOf(grid->GetFieldData(), "BlockBoundaryTypes");
  for (std::size_t n = 0; 5 * n + 5 <= values.size() && n < names.size(); ++n)
  {
    const int* v = values.data() + 5 * n;
    if (v[0] >= 0 && v[0] < 6)
    {
      this->addPatch(
        0, v[0], { { v[1], v[3] }, { v[2], v[4] } }, names[n], n < types.size() ? types[n] : std::string());
    }
  }
}

void FormerBoundaries::addPatch(
  int block, int face, const FaceRange& range, const std::string& name, const std::string& type)
{
  this->OfBlock.resize(this->Counts.size());
  this->OfBlock[block].push_back({ face, range, this->Patches.size() });
  this->Patches.push_back({ name, type });
}

void FormerBoundaries::addContacts(vtkFieldData* mesh)
{
  this->Contacts.resize(this->Counts.size());
  const std::vector<int> values = intsOf(mesh, "Interfaces", 12);
  const int blocks = static_cast<int>(this->Counts.size());
  for (std::size_t n = 0; n + 12 <= values.size(); n += 12)
  {
    const int* v = values.data() + n;
    if (v[0] < 0 || v[0] >= blocks || v[1] < 0 || v[1] > 5 || v[2] < 0 || v[2] >= blocks || v[3] < 0 || v[3] > 5 ||
      v[4] < 0 || v[4] > 7)
    {
      continue;
    }
    Interface c{ v[0], v[1], v[2], v[3], v[4], wholeFace(this->Counts[v[0]], v[1]), { 0, 0 } };
    if (v[5] == 1)
    {
      c.rangeA = { { v[6], v[8] }, { v[7], v[9] } };
      c.originB = { v[10], v[11] };
    }
    this->Contacts[c.blockA].push_back(c);
    this->Contacts[c.blockB].push_back(
      { c.blockB, c.faceB, c.blockA, c.faceA, inverseOrientation(c.orientation), c.rangeB(), c.rangeA.lo });
  }
}

void FormerBoundaries::addMergedPoints(vtkDataSet* grid)
{
  vtkDataArray* numbers = grid->GetPointData()->GetArray("MeshPointIds");
  // A cell as it was: its first corner in a block.
  struct Cell
  {
    int block;
    Ijk place;
    int corners;
  };
  constexpr std::array<int, 8> BlockCorner{ 0, 1, 3, 2, 4, 5, 7, 6 };
  vtkNew<vtkIdList> list;
  for (vtkIdType c = 0; c < grid->GetNumberOfCells(); ++c)
  {
    const int type = grid->GetCellType(c);
    if (type != VTK_HEXAHEDRON && type != VTK_VOXEL)
    {
      continue;
    }
    vtkIdType count = 0;
    const vtkIdType* points = nullptr;
    grid->GetCellPoints(c, count, points, list);
    std::array<Index, 8> ids{};
    std::vector<Cell> found;
    for (int v = 0; v < 8; ++v)
    {
      const int corner = type == VTK_VOXEL ? v : BlockCorner[v];
      ids[corner] = static_cast<Index>(numbers->GetTuple1(points[v]));
      const std::pair<int, Ijk> before = this->placeOf(ids[corner]);
      const int block = before.first;
      Ijk place = before.second;
      bool inside = block >= 0;
      for (int d = 0; d < 3 && inside; ++d)
      {
        place[d] -= cornerSide(corner, d);
        inside = place[d] >= 0 && place[d] < this->Counts[block][d] - 1;
      }
      if (!inside)
      {
        continue;
      }
      auto same = std::find_if(
        found.begin(), found.end(), [&](const Cell& cell) { return cell.block == block && cell.place == place; });
      if (same == found.end())
      {
        same = found.insert(found.end(), { block, place, 0 });
      }
      ++same->corners;
    }
    const auto [lowest, highest] = std::minmax_element(ids.begin(), ids.end());
    const int firstBlock = this->placeOf(*lowest).first;
    if (firstBlock >= 0 && firstBlock == this->placeOf(*highest).first &&
      this->idAt(firstBlock, { 1, 1, 1 }) - this->idAt(firstBlock, { 0, 0, 0 }) == *highest - *lowest)
    {
      // A whole cell of the block. In another order of corners, as Reflect makes them, the others say nothing.
      if (found.empty() || found.front().corners < 8)
      {
        this->Merged.clear();
        return;
      }
      continue;
    }
    // Most corners have their numbers in the block that the cell is of.
    const auto fewer = [](const Cell& a, const Cell& b) { return a.corners < b.corners; };
    const auto most = std::max_element(found.begin(), found.end(), fewer);
    if (most == found.end() || most->corners == 8 ||
      std::any_of(std::next(most), found.end(), [&](const Cell& cell) { return cell.corners == most->corners; }))
    {
      continue;
    }
    const Cell best = *most;
    for (int corner = 0; corner < 8; ++corner)
    {
      Ijk p = best.place;
      for (int d = 0; d < 3; ++d)
      {
        p[d] += cornerSide(corner, d);
      }
      const Index own = this->idAt(best.block, p);
      if (own != ids[corner])
      {
        this->Merged.insert(this->Merged.end(), { { own, ids[corner] }, { ids[corner], own } });
      }
    }
  }
  std::sort(this->Merged.begin(), this->Merged.end());
  this->Merged.erase(std::unique(this->Merged.begin(), this->Merged.end()), this->Merged.end());
}

std::pair<int, Ijk> FormerBoundaries::placeOf(Index meshPointId) const
{
  const auto after = std::upper_bound(this->First.begin(), this->First.end(), meshPointId);
  if (after == this->First.begin())
  {
    return { -1, {} };
  }
  const int block = static_cast<int>(after - this->First.begin()) - 1;
  const Index n = meshPointId - this->First[block];
  return { n < sizeOf(this->Counts[block]) ? block : -1, pointAt(this->Counts[block], n) };
}

Index FormerBoundaries::idAt(int block, const Ijk& p) const
{
  const Ijk& counts = this->Counts[block];
  return this->First[block] + p[0] + counts[0] * (p[1] + Index(counts[1]) * p[2]);
}

std::vector<Index> FormerBoundaries::copies(Index meshPointId) const
{
  std::vector<Index> ids{ meshPointId };
  const auto add = [&ids](Index id) {
    if (std::find(ids.begin(), ids.end(), id) == ids.end())
    {
      ids.push_back(id);
    }
  };
  // The list grows while it is walked. NOLINTNEXTLINE(modernize-loop-convert)
  for (std::size_t n = 0; n < ids.size(); ++n)
  {
    for (auto at = std::lower_bound(this->Merged.begin(), this->Merged.end(), std::make_pair(ids[n], Index(0)));
         at != this->Merged.end() && at->first == ids[n]; ++at)
    {
      add(at->second);
    }
    const auto [block, p] = this->placeOf(ids[n]);
    for (std::size_t i = 0;
         block >= 0 && block < static_cast<int>(this->Contacts.size()) && i < this->Contacts[block].size(); ++i)
    {
      const Interface& c = this->Contacts[block][i];
      const int d = faceDirection(c.faceA);
      const int s = p[faceAxis(c.faceA, 0)];
      const int t = p[faceAxis(c.faceA, 1)];
      const FaceRange& a = c.rangeA;
      if (p[d] != (faceSide(c.faceA) ? this->Counts[block][d] - 1 : 0) || s < a.lo[0] || s > a.hi[0] || t < a.lo[1] ||
        t > a.hi[1])
      {
        continue;
      }
      const auto onB = mapFacePoint(c.orientation, s - a.lo[0], t - a.lo[1], a.hi[0] - a.lo[0], a.hi[1] - a.lo[1]);
      Ijk q{};
      const int e = faceDirection(c.faceB);
      q[e] = faceSide(c.faceB) ? this->Counts[c.blockB][e] - 1 : 0;
      q[faceAxis(c.faceB, 0)] = c.originB[0] + onB[0];
      q[faceAxis(c.faceB, 1)] = c.originB[1] + onB[1];
      add(this->idAt(c.blockB, q));
    }
  }
  return ids;
}

const FormerBoundaries::Name* FormerBoundaries::find(const std::array<Index, 4>& meshPointIds) const
{
  const int block = this->placeOf(meshPointIds[0]).first;
  if (const Name* found = block < 0 ? nullptr : this->findIn(block, meshPointIds))
  {
    return found;
  }
  // Where blocks meet a point may have the number that it has in another block.
  std::array<std::vector<Index>, 4> all;
  for (int c = 0; c < 4; ++c)
  {
    all[c] = this->copies(meshPointIds[c]);
  }
  for (Index first : all[0])
  {
    std::array<Index, 4> ids{ first, -1, -1, -1 };
    const int wanted = this->placeOf(first).first;
    for (int c = 1; c < 4; ++c)
    {
      for (Index id : all[c])
      {
        ids[c] = wanted >= 0 && this->placeOf(id).first == wanted ? id : ids[c];
      }
    }
    if (const Name* found = wanted < 0 ? nullptr : this->findIn(wanted, ids))
    {
      return found;
    }
  }
  return nullptr;
}

const FormerBoundaries::Name* FormerBoundaries::findIn(int block, const std::array<Index, 4>& meshPointIds) const
{
  if (block >= static_cast<int>(this->OfBlock.size()))
  {
    return nullptr;
  }
  const Ijk& counts = this->Counts[block];
  Ijk lo = counts;
  Ijk hi{ -1, -1, -1 };
  for (Index id : meshPointIds)
  {
    const auto [own, p] = this->placeOf(id);
    if (own != block)
    {
      return nullptr;
    }
    for (int d = 0; d < 3; ++d)
    {
      lo[d] = std::min(lo[d], p[d]);
      hi[d] = std::max(hi[d], p[d]);
    }
  }
  for (const Patch& patch : this->OfBlock[block])
  {
    const int d = faceDirection(patch.face);
    const int layer = faceSide(patch.face) ? counts[d] - 1 : 0;
    const int s = faceAxis(patch.face, 0);
    const int t = faceAxis(patch.face, 1);
    if (lo[d] == layer && hi[d] == layer && lo[s] >= patch.range.lo[0] && hi[s] <= patch.range.hi[0] &&
      lo[t] >= patch.range.lo[1] && hi[t] <= patch.range.hi[1])
    {
      return &this->Patches[patch.name];
    }
  }
  return nullptr;
}

} // namespace bsv
