// SPDX-License-Identifier: BSD-3-Clause
#include "Data/BlockTagArrays.h"

#include <vtkFieldData.h>
#include <vtkIntArray.h>
#include <vtkPointData.h>
#include <vtkStringArray.h>
#include <vtkStructuredGrid.h>

#include <cstring>
#include <optional>
#include <type_traits>

namespace bsv
{

namespace
{

/// Where the points of a line of a grid are: all numbers of `places` but those along one direction are the same.
struct PlacedLine
{
  int axis;
  std::vector<int> places;
};

/// Nothing if the line is not straight, or turns back.
std::optional<PlacedLine> placeLine(const std::vector<Ijk>& line)
{
  PlacedLine result{ -1, {} };
  if (line.size() < 2)
  {
    return std::nullopt;
  }
  for (int d = 0; d < 3; ++d)
  {
    if (line[1][d] != line[0][d])
    {
      if (result.axis >= 0)
      {
        return std::nullopt;
      }
      result.axis = d;
    }
  }
  if (result.axis < 0)
  {
    return std::nullopt;
  }
  const int axis = result.axis;
  const bool up = line[1][axis] > line[0][axis];
  for (std::size_t n = 0; n < line.size(); ++n)
  {
    Ijk expected = line[0];
    expected[axis] = line[n][axis];
    if (line[n] != expected || (n > 0 && (line[n][axis] > line[n - 1][axis]) != up) ||
      (n > 0 && line[n][axis] == line[n - 1][axis]))
    {
      return std::nullopt;
    }
    result.places.push_back(line[n][axis]);
  }
  return result;
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
    const std::optional<PlacedLine> placed = placeLine(line);
    if (!placed)
    {
      return;
    }
    tags.axis[d] = placed->axis;
    tags.places[d] = placed->places;
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

/// Sends tags between ranks: whole numbers and texts. The same words write and read them.
class Packed
{
public:
  Packed() = default;
  explicit Packed(std::vector<char> received)
    : bytes(std::move(received))
    , reads(true)
  {
  }
  std::vector<char> bytes;

  bool atEnd() const { return this->at >= this->bytes.size(); }

  void operator()(int& value) { this->copy(reinterpret_cast<char*>(&value), sizeof value); }
  void operator()(bool& value)
  {
    int number = value ? 1 : 0;
    (*this)(number);
    value = number == 1;
  }
  void operator()(std::string& text)
  {
    this->resize(text);
    this->copy(text.data(), text.size());
  }
  template <typename Item, typename Each>
  void operator()(std::vector<Item>& items, const Each& each)
  {
    this->resize(items);
    for (Item& item : items)
    {
      each(item);
    }
  }

private:
  template <typename List>
  void resize(List& list)
  {
    int size = static_cast<int>(list.size());
    (*this)(size);
    list.resize(static_cast<std::size_t>(size));
  }
  void copy(char* data, std::size_t size)
  {
    if (this->reads)
    {
      std::memcpy(data, this->bytes.data() + this->at, size);
      this->at += size;
    }
    else
    {
      this->bytes.insert(this->bytes.end(), data, data + size);
    }
  }

  bool reads = false;
  std::size_t at = 0;
};

void pack(Packed& packed, FaceRange& range)
{
  for (int* n : { &range.lo[0], &range.hi[0], &range.lo[1], &range.hi[1] })
  {
    packed(*n);
  }
}

/// Writes tags, or reads them.
void pack(Packed& packed, Tags& tags)
{
  packed(tags.key);
  packed(tags.placed);
  for (int d = 0; d < 3; ++d)
  {
    packed(tags.counts[d]);
    packed(tags.axis[d]);
    packed(tags.places[d], [&](int& place) { packed(place); });
  }
  packed(tags.contacts, [&](Tags::Contact& c) {
    Interface& contact = c.contact;
    for (int* n : { &contact.faceA, &contact.faceB, &contact.originB[0], &contact.originB[1], &contact.orientation })
    {
      packed(*n);
    }
    pack(packed, contact.rangeA);
    packed(c.other);
  });
  packed(tags.boundaries, [&](Tags::Boundary& boundary) {
    packed(boundary.face);
    pack(packed, boundary.range);
    packed(boundary.name);
    packed(boundary.type);
  });
  packed(tags.creases, [&](CreaseLine& line) {
    for (int d = 0; d < 3; ++d)
    {
      packed(line.from[d]);
      packed(line.to[d]);
    }
  });
}

} // namespace

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

std::vector<Tags> gatherTags(const std::vector<vtkSmartPointer<vtkStructuredGrid>>& grids, const Ranks& ranks)
{
  Packed mine;
  for (int b = 0; b < static_cast<int>(grids.size()); ++b)
  {
    if (grids[b])
    {
      Tags tags = readTags(grids[b]);
      mine(b);
      pack(mine, tags);
    }
  }
  std::vector<Tags> tags(grids.size());
  for (std::vector<char>& bytes : ranks.gather(mine.bytes))
  {
    Packed from(std::move(bytes));
    while (!from.atEnd())
    {
      int b = 0;
      from(b);
      pack(from, tags[b]);
    }
  }
  return tags;
}

} // namespace bsv
