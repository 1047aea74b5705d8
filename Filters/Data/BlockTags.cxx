// SPDX-License-Identifier: BSD-3-Clause
#include "Data/BlockTags.h"

#include "Data/BlockTagArrays.h"

#include <vtkFieldData.h>
#include <vtkIdTypeArray.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPartitionedDataSetCollection.h>
#include <vtkPointData.h>
#include <vtkStringArray.h>
#include <vtkStructuredGrid.h>

#include <cstdio>
#include <limits>

namespace bsv
{

namespace
{

constexpr const char* OwnArrays[] = { "BlockKey", "BlockDimensions", "BlockFirstPoint", "BlockInterfaces",
  "BlockInterfaceKeys", "BlockBoundaries", "BlockBoundaryNames", "BlockBoundaryTypes", "BlockCreases" };

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

/// Values of the arrays of a block.
struct TagValues
{
  std::vector<int> contacts, boundaries, creases;
  std::vector<std::string> others, names, types;
};

/// Of all blocks.
std::vector<TagValues> tagValues(const BlockMesh& mesh, const std::vector<std::string>& keys)
{
  std::vector<TagValues> values(mesh.blocks.size());
  for (const Interface& c : mesh.interfaces)
  {
    TagValues& block = values[c.blockA];
    block.contacts.insert(block.contacts.end(),
      { c.faceA, c.rangeA.lo[0], c.rangeA.hi[0], c.rangeA.lo[1], c.rangeA.hi[1], c.faceB, c.originB[0], c.originB[1],
        c.orientation });
    block.others.push_back(keys[c.blockB]);
  }
  for (const BoundaryPatch& b : mesh.boundaries)
  {
    TagValues& block = values[b.block];
    block.boundaries.insert(
      block.boundaries.end(), { b.face, b.range.lo[0], b.range.hi[0], b.range.lo[1], b.range.hi[1] });
    block.names.push_back(mesh.boundaryNames[b.tag]);
    block.types.push_back(mesh.boundaryTypes.empty() ? std::string() : mesh.boundaryTypes[b.tag]);
  }
  for (const CreaseLine& line : mesh.creases)
  {
    std::vector<int>& creases = values[line.block].creases;
    creases.insert(creases.end(), line.from.begin(), line.from.end());
    creases.insert(creases.end(), line.to.begin(), line.to.end());
  }
  return values;
}

void setTags(vtkFieldData* fields, const std::string& key, const Ijk& counts, const TagValues& values)
{
  for (const char* name : OwnArrays)
  {
    fields->RemoveArray(name);
  }
  fields->AddArray(strings("BlockKey", { key }));
  fields->AddArray(ints("BlockDimensions", 3, { counts.begin(), counts.end() }));
  if (!values.contacts.empty())
  {
    fields->AddArray(ints("BlockInterfaces", 9, values.contacts));
    fields->AddArray(strings("BlockInterfaceKeys", values.others));
  }
  if (!values.boundaries.empty())
  {
    fields->AddArray(ints("BlockBoundaries", 5, values.boundaries));
    fields->AddArray(strings("BlockBoundaryNames", values.names));
    fields->AddArray(strings("BlockBoundaryTypes", values.types));
  }
  if (!values.creases.empty())
  {
    fields->AddArray(ints("BlockCreases", 6, values.creases));
  }
}

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
  const std::vector<TagValues> values = tagValues(mesh, keys);
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b)
  {
    auto* grid = vtkStructuredGrid::SafeDownCast(collection->GetPartitionAsDataObject(static_cast<unsigned int>(b), 0));
    if (!grid)
    {
      continue;
    }
    setTags(grid->GetFieldData(), keys[b], mesh.blocks[b].points.counts(), values[b]);
    if (!numberPoints)
    {
      continue;
    }
    vtkNew<vtkIdTypeArray> firstPoint;
    firstPoint->SetName("BlockFirstPoint");
    firstPoint->InsertNextValue(first[b]);
    grid->GetFieldData()->AddArray(firstPoint);
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
  if (!counted)
  {
    // Arrays that nobody counted are taken as they are; without any the blocks may bring theirs.
    const bool brought = std::any_of(grids.begin(), grids.end(),
      [](vtkStructuredGrid* grid) { return grid && grid->GetFieldData()->HasArray("BlockKey"); });
    // A grid alone is no mesh: what it brings is its own.
    const bool own = fields && fields->HasArray("BlockKey");
    return !ranks.any(brought && (!anyArray || own));
  }
  bool fits = keys.size() == mesh.blocks.size();
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

} // namespace bsv
