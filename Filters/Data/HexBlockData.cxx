// SPDX-License-Identifier: BSD-3-Clause
#include "Data/HexBlockData.h"

#include "Data/BlockTags.h"
#include "Data/HexMeshData.h"
#include "Data/SurfaceNames.h"
#include "Execution/FilterExecution.h"

#include <vtkAOSDataArrayTemplate.h>
#include <vtkCompositeDataSet.h>
#include <vtkDataAssembly.h>
#include <vtkDataObjectTree.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkInformation.h>
#include <vtkIntArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPartitionedDataSet.h>
#include <vtkPartitionedDataSetCollection.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkStringArray.h>
#include <vtkStructuredGrid.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>

namespace bsv
{

namespace
{

/// Place of a block in the tree, the same on all ranks: the partitions of a data set can be on several of them.
struct Leaf
{
  vtkDataObject* data;
  std::string name;
  /// Number of the data set, and of the partition in it.
  int dataSet;
  int partition;
};

std::string metaName(vtkInformation* information)
{
  const char* name =
    information && information->Has(vtkCompositeDataSet::NAME()) ? information->Get(vtkCompositeDataSet::NAME()) : "";
  return name ? name : "";
}

/// Leaves in flat order, missing ones included. A leaf without a name has that of its parent: partitions have none.
void collectLeaves(vtkDataObject* node, const std::string& name, std::vector<Leaf>& leaves)
{
  const auto visit = [&](unsigned int count, auto&& child, auto&& information) {
    for (unsigned int i = 0; i < count; ++i)
    {
      const std::string own = metaName(information(i));
      collectLeaves(child(i), own.empty() ? name : own, leaves);
    }
  };
  const int dataSet = leaves.empty() ? 0 : leaves.back().dataSet + 1;
  if (auto* collection = vtkPartitionedDataSetCollection::SafeDownCast(node))
  {
    visit(
      collection->GetNumberOfPartitionedDataSets(),
      [&](unsigned int i) -> vtkDataObject* { return collection->GetPartitionedDataSet(i); },
      [&](unsigned int i) { return collection->HasMetaData(i) ? collection->GetMetaData(i) : nullptr; });
  }
  else if (auto* blocks = vtkMultiBlockDataSet::SafeDownCast(node))
  {
    visit(
      blocks->GetNumberOfBlocks(), [&](unsigned int i) { return blocks->GetBlock(i); },
      [&](unsigned int i) { return blocks->HasMetaData(i) ? blocks->GetMetaData(i) : nullptr; });
  }
  else if (auto* partitions = vtkPartitionedDataSet::SafeDownCast(node))
  {
    // An empty partitioned data set keeps the numbers of the blocks behind it.
    if (partitions->GetNumberOfPartitions() == 0)
    {
      leaves.push_back({ nullptr, name, dataSet, 0 });
    }
    for (unsigned int i = 0; i < partitions->GetNumberOfPartitions(); ++i)
    {
      const std::string own = metaName(partitions->HasMetaData(i) ? partitions->GetMetaData(i) : nullptr);
      leaves.push_back(
        { partitions->GetPartitionAsDataObject(i), own.empty() ? name : own, dataSet, static_cast<int>(i) });
    }
  }
  else
  {
    leaves.push_back({ node, name, dataSet, 0 });
  }
}

template <typename Real>
const Real* xyzTriples(vtkDataArray* array)
{
  auto* values = vtkAOSDataArrayTemplate<Real>::FastDownCast(array);
  return values ? values->GetPointer(0) : nullptr;
}

/// Points per direction of a grid that can be a block.
Ijk pointCounts(vtkStructuredGrid* grid, const std::string& name)
{
  Ijk counts;
  grid->GetDimensions(counts.data());
  for (int d = 0; d < 3; ++d)
  {
    if (counts[d] < 2)
    {
      throw Error("Block '" + name + "' has " + std::to_string(counts[0]) + " x " + std::to_string(counts[1]) + " x " +
        std::to_string(counts[2]) + " points; hexahedra need at least 2 in each direction.");
    }
  }
  // Any two numbers below 2^31 have a product; three may have none.
  if (Index(counts[0]) * counts[1] > std::numeric_limits<Index>::max() / 3 / counts[2])
  {
    throw Error("Block '" + name + "' says that it has " + std::to_string(counts[0]) + " x " +
      std::to_string(counts[1]) + " x " + std::to_string(counts[2]) + " points, more than can be counted.");
  }
  const Index size = Index(counts[0]) * counts[1] * counts[2];
  if (!grid->GetPoints() || grid->GetNumberOfPoints() != size)
  {
    throw Error("Block '" + name + "' has " + std::to_string(grid->GetPoints() ? grid->GetNumberOfPoints() : 0) +
      " points; its dimensions say " + std::to_string(size) + ".");
  }
  return counts;
}

/// Points and point arrays of a block that is here.
void readPoints(vtkSmartPointer<vtkStructuredGrid>& grid, MeshBlock& block)
{
  const Ijk counts = block.points.counts();
  vtkDataArray* points = grid->GetPoints()->GetData();
  if (const float* floats = xyzTriples<float>(points))
  {
    block.points = GridView(floats, counts);
  }
  else if (const double* doubles = xyzTriples<double>(points))
  {
    block.points = GridView(doubles, counts);
  }
  else
  {
    vtkNew<vtkPoints> converted;
    converted->SetDataTypeToDouble();
    converted->DeepCopy(grid->GetPoints());
    vtkNew<vtkStructuredGrid> copy;
    copy->ShallowCopy(grid);
    copy->SetPoints(converted);
    grid = copy;
    block.points = GridView(xyzTriples<double>(converted->GetData()), counts);
  }

  if (const auto sharpness = doublePointArray(grid, "CreaseSharpness", 1, block.name))
  {
    block.creaseSharpness.assign(sharpness->GetPointer(0), sharpness->GetPointer(0) + block.points.size());
  }
}

/// A block as the tree of one rank has it.
struct LeafRecord
{
  int dataSet;
  int partition;
  Ijk counts;
  int nameLength;
};

/// A block of the mesh, on all ranks.
struct SharedLeaf
{
  Ijk counts{ 0, 0, 0 };
  /// The lowest rank that has it, or -1 if it is missing everywhere.
  int rank = -1;
  /// May be empty.
  std::string name;
  /// The leaf of this rank's own tree, or null.
  const Leaf* own = nullptr;
};

std::string blockName(const std::string& name, std::size_t leaf)
{
  return name.empty() ? "block " + std::to_string(leaf) : name;
}

/// All leaves in flat order, from what every rank has. Collective.
std::vector<SharedLeaf> shareLeaves(const std::vector<Leaf>& leaves, const Ranks& ranks)
{
  std::vector<int> sizes; // partitions per data set
  std::vector<LeafRecord> records;
  std::vector<char> names;
  for (std::size_t i = 0; i < leaves.size(); ++i)
  {
    const Leaf& leaf = leaves[i];
    sizes.resize(leaf.dataSet + 1, 0);
    sizes[leaf.dataSet] = leaf.partition + 1;
    const std::string name = blockName(leaf.name, i);
    auto* grid = vtkStructuredGrid::SafeDownCast(leaf.data);
    if (leaf.data && !grid)
    {
      throw Error(
        "Block '" + name + "' is a " + leaf.data->GetClassName() + "; only vtkStructuredGrid can be a block.");
    }
    // A grid without points is how a missing block travels through filters that keep the structure.
    if (grid && grid->GetNumberOfPoints() > 0)
    {
      records.push_back({ leaf.dataSet, leaf.partition, pointCounts(grid, name), static_cast<int>(leaf.name.size()) });
      names.insert(names.end(), leaf.name.begin(), leaf.name.end());
    }
  }
  // Partitions are counted where there are several; a rank without any block may have no tree at all.
  std::vector<int> widths{ static_cast<int>(sizes.size()) };
  for (std::size_t s = 0; s < sizes.size(); ++s)
  {
    if (sizes[s] > 1)
    {
      widths.insert(widths.end(), { static_cast<int>(s), sizes[s] });
    }
  }
  const std::vector<std::vector<int>> allWidths = ranks.gather(widths);
  const std::vector<std::vector<LeafRecord>> allRecords = ranks.gather(records);
  const std::vector<std::vector<char>> allNames = ranks.gather(names);

  int first = -1; // rank with blocks
  std::vector<int> places;
  for (int r = 0; r < ranks.size(); ++r)
  {
    const int dataSets = allWidths[r][0];
    if (!allRecords[r].empty() && first >= 0 && dataSets != allWidths[first][0])
    {
      throw Error("The mesh has " + std::to_string(allWidths[first][0]) + " data sets on rank " +
        std::to_string(first) + ", but " + std::to_string(dataSets) + " on rank " + std::to_string(r) +
        "; every rank must have all of them, without the blocks that are on other ranks.");
    }
    first = first < 0 && !allRecords[r].empty() ? r : first;
    places.resize(std::max<std::size_t>(places.size(), dataSets), 1);
    for (std::size_t w = 1; w < allWidths[r].size(); w += 2)
    {
      int& width = places[allWidths[r][w]];
      width = std::max(width, allWidths[r][w + 1]);
    }
  }
  std::vector<SharedLeaf> shared;
  std::vector<std::size_t> start; // first leaf of a data set
  for (const int count : places)
  {
    start.push_back(shared.size());
    shared.resize(shared.size() + count);
  }
  const auto state = [](std::size_t place, const std::string& name, const Ijk& counts, int rank) {
    return "'" + blockName(name, place) + "' of " + std::to_string(counts[0]) + " x " + std::to_string(counts[1]) +
      " x " + std::to_string(counts[2]) + " points on rank " + std::to_string(rank);
  };
  for (int r = 0; r < ranks.size(); ++r)
  {
    auto text = allNames[r].begin();
    for (const LeafRecord& record : allRecords[r])
    {
      const std::string name(text, text + record.nameLength);
      text += record.nameLength;
      const std::size_t place = start[record.dataSet] + record.partition;
      SharedLeaf& leaf = shared[place];
      if (leaf.rank < 0)
      {
        leaf.rank = r;
        leaf.counts = record.counts;
      }
      leaf.name = leaf.name.empty() ? name : leaf.name;
      if (leaf.counts != record.counts || (!name.empty() && leaf.name != name))
      {
        throw Error("Block " + std::to_string(place) + " is " + state(place, leaf.name, leaf.counts, leaf.rank) +
          ", but " + state(place, name, record.counts, r) + ".");
      }
    }
  }

  // Names that ranks without the block have.
  for (const Leaf& leaf : leaves)
  {
    shared[start[leaf.dataSet] + leaf.partition].own = &leaf;
  }
  for (std::size_t i = 0; i < shared.size(); ++i)
  {
    const SharedLeaf& leaf = shared[i];
    if (leaf.rank >= 0 && leaf.own && !leaf.name.empty() && !leaf.own->name.empty() && leaf.own->name != leaf.name)
    {
      throw Error("Block " + std::to_string(i) + " is " + state(i, leaf.name, leaf.counts, leaf.rank) +
        ", but has the name '" + leaf.own->name + "' on rank " + std::to_string(ranks.rank()) + ".");
    }
  }
  ranks.nextStep();
  std::vector<SharedLeaf*> unnamed;
  std::vector<char> known; // each with a zero behind it
  for (SharedLeaf& leaf : shared)
  {
    if (leaf.rank >= 0 && leaf.name.empty())
    {
      unnamed.push_back(&leaf);
      const char* name = leaf.own ? leaf.own->name.c_str() : "";
      known.insert(known.end(), name, name + std::strlen(name) + 1);
    }
  }
  if (!unnamed.empty())
  {
    for (const std::vector<char>& text : ranks.gather(known))
    {
      auto at = text.begin();
      for (SharedLeaf* leaf : unnamed)
      {
        leaf->name = leaf->name.empty() ? std::string(&*at) : leaf->name;
        at = std::find(at, text.end(), '\0') + 1;
      }
    }
  }
  return shared;
}

/// An array of the field data: its name and the numbers of components allowed.
struct IntArrayKind
{
  const char* name;
  std::vector<int> components;
};

const IntArrayKind InterfacesArray{ "Interfaces", { 12 } };
const IntArrayKind BoundariesArray{ "Boundaries", { 3, 7 } };
const IntArrayKind CreasesArray{ "CreaseEdges", { 7 } };

/// The array, or null.
vtkIntArray* intArray(vtkFieldData* fields, const IntArrayKind& kind)
{
  vtkAbstractArray* any = fields ? fields->GetAbstractArray(kind.name) : nullptr;
  if (!any)
  {
    return nullptr;
  }
  auto* array = vtkIntArray::SafeDownCast(any);
  const int found = any->GetNumberOfComponents();
  if (!array || std::find(kind.components.begin(), kind.components.end(), found) == kind.components.end())
  {
    std::string allowed;
    for (const int count : kind.components)
    {
      allowed += (allowed.empty() ? "" : " or ") + std::to_string(count);
    }
    throw Error("Field data array '" + std::string(kind.name) + "' must be of type int with " + allowed +
      " components, but is " + any->GetClassName() + " with " + std::to_string(found) + ".");
  }
  return array;
}

/// The arrays of one string per boundary.
constexpr const char* BoundaryTexts[] = { "BoundaryNames", "BoundaryTypes" };

/// One of BoundaryTexts, or null.
vtkStringArray* boundaryTexts(vtkFieldData* fields, const char* name)
{
  vtkAbstractArray* any = fields ? fields->GetAbstractArray(name) : nullptr;
  auto* texts = vtkStringArray::SafeDownCast(any);
  if (any && (!texts || texts->GetNumberOfComponents() != 1))
  {
    throw Error("Field data array '" + std::string(name) + "' must hold strings, one a tuple, but is " +
      std::string(any->GetClassName()) + " with " + std::to_string(any->GetNumberOfComponents()) + " components.");
  }
  return texts;
}

/// Gives every rank the array that some of them have, and refuses different ones. Collective.
/// @param mine its content, null if there is none here.
/// @return its content, null if no rank has it.
template <typename T>
std::unique_ptr<std::vector<T>> sharedArray(
  std::unique_ptr<std::vector<T>> mine, const std::string& name, const Ranks& ranks)
{
  // Not the arrays themselves, or the traffic would grow with the number of ranks.
  struct Digest
  {
    std::uint64_t here, hash;
  };
  Digest digest{ 0, 14695981039346656037u }; // of FNV-1a, by whole numbers
  if (mine)
  {
    digest.here = 1;
    for (const T& value : *mine)
    {
      digest.hash = (digest.hash ^ static_cast<std::uint64_t>(value)) * 1099511628211u;
    }
  }
  const std::vector<Digest> all = ranks.gatherAll(std::vector<Digest>{ digest });
  int owner = -1;
  for (int r = 0; r < ranks.size(); ++r)
  {
    if (owner >= 0 && all[r].here && all[r].hash != all[owner].hash)
    {
      throw Error("Field data array '" + name + "' is not the same on the ranks " + std::to_string(owner) + " and " +
        std::to_string(r) + ".");
    }
    owner = owner < 0 && all[r].here ? r : owner;
  }
  if (owner < 0 || std::all_of(all.begin(), all.end(), [](const Digest& other) { return other.here != 0; }))
  {
    return mine;
  }
  std::vector<std::vector<T>> toRank(ranks.size());
  for (int r = 0; r < ranks.size(); ++r)
  {
    if (owner == ranks.rank() && !all[r].here)
    {
      toRank[r] = *mine;
    }
  }
  std::vector<std::vector<T>> received = ranks.exchange(toRank);
  return mine ? std::move(mine) : std::make_unique<std::vector<T>>(std::move(received[owner]));
}

/// The arrays of this file that any rank has in its field data. Collective.
vtkSmartPointer<vtkFieldData> sharedFields(vtkFieldData* mine, const Ranks& ranks)
{
  if (ranks.size() == 1)
  {
    return mine;
  }
  for (const IntArrayKind* kind : { &InterfacesArray, &BoundariesArray, &CreasesArray })
  {
    intArray(mine, *kind);
  }
  for (const char* name : BoundaryTexts)
  {
    boundaryTexts(mine, name);
  }
  auto fields = vtkSmartPointer<vtkFieldData>::New();
  for (const IntArrayKind* kind : { &InterfacesArray, &BoundariesArray, &CreasesArray })
  {
    // The number of components, then the values.
    std::unique_ptr<std::vector<int>> values;
    if (vtkIntArray* array = intArray(mine, *kind))
    {
      values = std::make_unique<std::vector<int>>(array->GetPointer(0), array->GetPointer(array->GetNumberOfValues()));
      values->insert(values->begin(), array->GetNumberOfComponents());
    }
    if (const auto all = sharedArray(std::move(values), kind->name, ranks))
    {
      vtkNew<vtkIntArray> array;
      array->SetName(kind->name);
      array->SetNumberOfComponents(all->front());
      array->SetNumberOfValues(static_cast<vtkIdType>(all->size()) - 1);
      std::copy(all->begin() + 1, all->end(), array->GetPointer(0));
      fields->AddArray(array);
    }
  }
  for (const char* array : BoundaryTexts)
  {
    // Each text with a zero behind it.
    std::unique_ptr<std::vector<char>> letters;
    if (vtkStringArray* texts = boundaryTexts(mine, array))
    {
      letters = std::make_unique<std::vector<char>>();
      for (vtkIdType i = 0; i < texts->GetNumberOfValues(); ++i)
      {
        const char* text = texts->GetValue(i).c_str();
        letters->insert(letters->end(), text, text + std::strlen(text) + 1);
      }
    }
    if (const auto all = sharedArray(std::move(letters), array, ranks))
    {
      vtkNew<vtkStringArray> texts;
      texts->SetName(array);
      for (auto at = all->begin(); at != all->end(); at = std::find(at, all->end(), '\0') + 1)
      {
        texts->InsertNextValue(&*at);
      }
      fields->AddArray(texts);
    }
  }
  return fields;
}

/// Reads one entry of a field data array and checks it against the blocks.
class Entry
{
public:
  /// `blockOfLeaf`: block of the mesh per leaf, -1 if it is missing.
  Entry(vtkIntArray* array, vtkIdType index, const std::vector<MeshBlock>& blocks, const std::vector<int>& blockOfLeaf)
    : Array(array)
    , At(index)
    , Blocks(blocks)
    , BlockOfLeaf(blockOfLeaf)
  {
  }

  int value(int component) const { return this->Array->GetTypedComponent(this->At, component); }

  int value(int component, int last, const char* what) const
  {
    const int found = this->value(component);
    if (found < 0 || found > last)
    {
      this->fail("component " + std::to_string(component) + ", " + what + " " + std::to_string(found) +
        (last < 0 ? ", but there are none" : ", is out of range 0.." + std::to_string(last)));
    }
    return found;
  }

  [[noreturn]] void fail(const std::string& what) const
  {
    throw Error("Field data array '" + std::string(this->Array->GetName()) + "', entry " + std::to_string(this->At) +
      ": " + what + ".");
  }

  /// Block of the mesh, -1 if it is missing.
  int block(int component) const
  {
    return this->BlockOfLeaf[this->value(component, static_cast<int>(this->BlockOfLeaf.size()) - 1, "block")];
  }

  /// Last mesh point along a face's axis.
  int last(int block, int face, int axis) const
  {
    return this->Blocks[block].points.counts()[faceAxis(face, axis)] - 1;
  }

  FaceRange whole(int block, int face) const
  {
    return { { 0, 0 }, { this->last(block, face, 0), this->last(block, face, 1) } };
  }

  /// Range from four components sMin, sMax, tMin, tMax.
  FaceRange range(int component, int block, int face) const
  {
    FaceRange range;
    for (int axis = 0; axis < 2; ++axis)
    {
      const int at = component + 2 * axis;
      range.hi[axis] = this->value(at + 1, this->last(block, face, axis), "end of the range");
      range.lo[axis] = this->value(at, range.hi[axis] - 1, "start of the range");
    }
    return range;
  }

private:
  vtkIntArray* Array;
  vtkIdType At;
  const std::vector<MeshBlock>& Blocks;
  const std::vector<int>& BlockOfLeaf;
};

using EntryReader = std::function<void(const Entry&)>;

void forEachEntry(
  vtkIntArray* array, const BlockMesh& mesh, const std::vector<int>& blockOfLeaf, const EntryReader& read)
{
  for (vtkIdType i = 0; array && i < array->GetNumberOfTuples(); ++i)
  {
    read(Entry(array, i, mesh.blocks, blockOfLeaf));
  }
}

void readInterfaces(vtkFieldData* fields, const std::vector<int>& blockOfLeaf, BlockMesh& mesh)
{
  vtkIntArray* array = intArray(fields, InterfacesArray);
  forEachEntry(array, mesh, blockOfLeaf, [&](const Entry& entry) {
    Interface contact;
    contact.blockA = entry.block(0);
    contact.faceA = entry.value(1, 5, "face");
    contact.blockB = entry.block(2);
    contact.faceB = entry.value(3, 5, "face");
    contact.orientation = entry.value(4, 7, "orientation");
    if (contact.blockA < 0 || contact.blockB < 0)
    {
      return;
    }
    const bool partial = entry.value(5, 1, "flag of a partial range") == 1;
    contact.rangeA =
      partial ? entry.range(6, contact.blockA, contact.faceA) : entry.whole(contact.blockA, contact.faceA);
    for (int axis = 0; partial && axis < 2; ++axis)
    {
      contact.originB[axis] =
        entry.value(10 + axis, entry.last(contact.blockB, contact.faceB, axis), "start of the range");
    }
    const FaceRange whole = entry.whole(contact.blockB, contact.faceB);
    const FaceRange rangeB = contact.rangeB();
    if (partial ? rangeB.hi[0] > whole.hi[0] || rangeB.hi[1] > whole.hi[1] : rangeB != whole)
    {
      entry.fail("face " + std::to_string(contact.faceA) + " of block '" + mesh.blocks[contact.blockA].name +
        "' and face " + std::to_string(contact.faceB) + " of block '" + mesh.blocks[contact.blockB].name +
        "' do not have the same numbers of points");
    }
    mesh.interfaces.push_back(contact);
  });
}

void readBoundaries(vtkFieldData* fields, const std::vector<int>& blockOfLeaf, BlockMesh& mesh)
{
  vtkStringArray* names = boundaryTexts(fields, "BoundaryNames");
  for (vtkIdType i = 0; names && i < names->GetNumberOfValues(); ++i)
  {
    mesh.boundaryNames.push_back(names->GetValue(i));
  }
  vtkStringArray* types = boundaryTexts(fields, "BoundaryTypes");
  if (types && types->GetNumberOfValues() != static_cast<vtkIdType>(mesh.boundaryNames.size()))
  {
    throw Error("Field data array 'BoundaryTypes' has " + std::to_string(types->GetNumberOfValues()) +
      " entries, but 'BoundaryNames' has " + std::to_string(mesh.boundaryNames.size()) +
      "; there must be one per name.");
  }
  for (vtkIdType i = 0; types && i < types->GetNumberOfValues(); ++i)
  {
    mesh.boundaryTypes.push_back(types->GetValue(i));
  }

  vtkIntArray* array = intArray(fields, BoundariesArray);
  forEachEntry(array, mesh, blockOfLeaf, [&](const Entry& entry) {
    BoundaryPatch patch;
    patch.block = entry.block(0);
    patch.face = entry.value(1, 5, "face");
    patch.tag = entry.value(2, static_cast<int>(mesh.boundaryNames.size()) - 1, "tag in BoundaryNames");
    if (patch.block < 0)
    {
      return;
    }
    patch.range = array->GetNumberOfComponents() == 7 ? entry.range(3, patch.block, patch.face)
                                                      : entry.whole(patch.block, patch.face);
    mesh.boundaries.push_back(patch);
  });
}

void readCreases(vtkFieldData* fields, const std::vector<int>& blockOfLeaf, BlockMesh& mesh)
{
  vtkIntArray* array = intArray(fields, CreasesArray);
  forEachEntry(array, mesh, blockOfLeaf, [&](const Entry& entry) {
    CreaseLine line;
    line.block = entry.block(0);
    if (line.block < 0)
    {
      return;
    }
    int directions = 0;
    for (int d = 0; d < 3; ++d)
    {
      const int last = mesh.blocks[line.block].points.counts()[d] - 1;
      line.from[d] = entry.value(1 + d, last, "mesh point");
      line.to[d] = entry.value(4 + d, last, "mesh point");
      directions += line.from[d] != line.to[d];
    }
    if (directions != 1)
    {
      entry.fail("the two points must differ in exactly one direction, not in " + std::to_string(directions));
    }
    mesh.creases.push_back(line);
  });
}

/// Replaces the int array `name` by the tuples given; removes it if there are none.
template <typename Item>
void setIntArray(vtkFieldData* fields, const char* name, int components, const std::vector<Item>& items,
  const std::function<std::vector<int>(const Item&)>& tuple)
{
  fields->RemoveArray(name);
  if (items.empty())
  {
    return;
  }
  vtkNew<vtkIntArray> array;
  array->SetName(name);
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(static_cast<vtkIdType>(items.size()));
  for (std::size_t i = 0; i < items.size(); ++i)
  {
    array->SetTypedTuple(static_cast<vtkIdType>(i), tuple(items[i]).data());
  }
  fields->AddArray(array);
}

FaceRange wholeFace(const Ijk& counts, int face)
{
  return { { 0, 0 }, { counts[faceAxis(face, 0)] - 1, counts[faceAxis(face, 1)] - 1 } };
}

/// @param ownFields those of the tree on this rank; may be null
BlockMesh blocksOfLeaves(const std::vector<Leaf>& leaves, vtkFieldData* ownFields,
  std::vector<vtkSmartPointer<vtkStructuredGrid>>& grids, const Ranks& ranks)
{
  const std::vector<SharedLeaf> shared = shareLeaves(leaves, ranks);

  BlockMesh mesh;
  grids.clear();
  std::vector<int> blockOfLeaf(shared.size(), -1);
  for (std::size_t i = 0; i < shared.size(); ++i)
  {
    const SharedLeaf& leaf = shared[i];
    if (leaf.rank < 0)
    {
      continue;
    }
    blockOfLeaf[i] = static_cast<int>(mesh.blocks.size());
    MeshBlock block;
    block.points = GridView::elsewhere(leaf.counts);
    block.rank = leaf.rank;
    block.name = blockName(leaf.name, i);
    vtkSmartPointer<vtkStructuredGrid> grid;
    if (leaf.rank == ranks.rank())
    {
      grid = vtkStructuredGrid::SafeDownCast(leaf.own->data);
      readPoints(grid, block);
    }
    mesh.blocks.push_back(std::move(block));
    grids.push_back(grid);
  }
  // Of a block with its vertices, edges and faces.
  constexpr double BytesPerBlock = 2300.0;
  requireMemory(BytesPerBlock * static_cast<double>(mesh.blocks.size()), std::to_string(mesh.blocks.size()) + " blocks",
    "their topology");
  ranks.nextStep();

  if (!arraysFitBlocks(ownFields, mesh, grids, ranks))
  {
    takeTags(mesh, grids, ranks);
    return mesh;
  }
  const vtkSmartPointer<vtkFieldData> fields = sharedFields(ownFields, ranks);
  readInterfaces(fields, blockOfLeaf, mesh);
  readBoundaries(fields, blockOfLeaf, mesh);
  readCreases(fields, blockOfLeaf, mesh);
  return mesh;
}

/// Takes the surfaces out of a tree that has blocks, too. Their places count as those of missing blocks. Collective.
std::vector<NamedLeaf> takeSurfaces(std::vector<Leaf>& leaves, const Ranks& ranks)
{
  std::vector<NamedLeaf> surfaces;
  const auto isBlock = [](const Leaf& leaf) {
    auto* grid = vtkStructuredGrid::SafeDownCast(leaf.data);
    return grid && grid->GetNumberOfPoints() > 0 && !isSurface(grid);
  };
  if (!ranks.any(std::any_of(leaves.begin(), leaves.end(), isBlock)))
  {
    return surfaces;
  }
  for (std::size_t i = 0; i < leaves.size(); ++i)
  {
    if (isSurface(leaves[i].data))
    {
      surfaces.push_back({ leaves[i].data, blockName(leaves[i].name, i) });
      leaves[i].data = nullptr;
    }
  }
  return surfaces;
}

} // namespace

std::vector<NamedLeaf> namedLeaves(vtkDataObject* input)
{
  std::vector<Leaf> leaves;
  if (input)
  {
    collectLeaves(input, "", leaves);
  }
  std::vector<NamedLeaf> result;
  for (const Leaf& leaf : leaves)
  {
    result.push_back({ leaf.data, leaf.name });
  }
  return result;
}

BlockMesh blockMesh(vtkDataObject* input, std::vector<vtkSmartPointer<vtkStructuredGrid>>& grids, const Execution& run)
{
  const Ranks& ranks = *run.ranks;
  if (!ranks.any(needsBlocks(input)))
  {
    std::vector<Leaf> leaves;
    if (input)
    {
      collectLeaves(input, "", leaves);
    }
    const std::vector<NamedLeaf> surfaces = takeSurfaces(leaves, ranks);
    BlockMesh mesh = blocksOfLeaves(leaves, input ? input->GetFieldData() : nullptr, grids, ranks);
    nameBySurfaces(mesh, surfaces, ranks);
    return mesh;
  }
  vtkNew<vtkPartitionedDataSetCollection> blocks;
  HexMeshReport report = hexMeshToBlocks(input, nullptr, {}, blocks, run);
  BlockMesh mesh = structuredBlocks(blocks, grids, ranks);
  mesh.notes = std::move(report.notes);
  mesh.notes.insert(mesh.notes.begin(),
    std::to_string(report.cells) + " unstructured hexahedra were made to " + std::to_string(report.blocks) +
      " blocks (Hex Mesh To Blocks).");
  mesh.warnings = std::move(report.warnings);
  return mesh;
}

BlockMesh structuredBlocks(
  vtkDataObject* input, std::vector<vtkSmartPointer<vtkStructuredGrid>>& grids, const Ranks& ranks)
{
  std::vector<Leaf> leaves;
  if (input)
  {
    collectLeaves(input, "", leaves);
  }
  return blocksOfLeaves(leaves, input ? input->GetFieldData() : nullptr, grids, ranks);
}

vtkSmartPointer<vtkDoubleArray> doublePointArray(
  vtkStructuredGrid* grid, const char* name, int components, const std::string& block)
{
  vtkAbstractArray* any = grid->GetPointData()->GetAbstractArray(name);
  if (!any)
  {
    return nullptr;
  }
  auto* array = vtkDataArray::SafeDownCast(any);
  if (!array || array->GetNumberOfComponents() != components || array->GetNumberOfTuples() != grid->GetNumberOfPoints())
  {
    throw Error("Point data array '" + std::string(name) + "' of block '" + block + "' must have " +
      std::to_string(components) + " numbers for each of " + std::to_string(grid->GetNumberOfPoints()) +
      " points, but is " + any->GetClassName() + " with " + std::to_string(any->GetNumberOfComponents()) +
      " for each of " + std::to_string(any->GetNumberOfTuples()) + ".");
  }
  if (auto* doubles = vtkDoubleArray::SafeDownCast(array))
  {
    return doubles;
  }
  auto converted = vtkSmartPointer<vtkDoubleArray>::New();
  converted->DeepCopy(array);
  return converted;
}

void setInterfaces(vtkFieldData* fields, const std::vector<Interface>& interfaces, const std::vector<Ijk>& counts)
{
  removeMeshKeys(fields);
  setIntArray<Interface>(fields, "Interfaces", 12, interfaces, [&](const Interface& contact) {
    const bool whole = contact.rangeA == wholeFace(counts[contact.blockA], contact.faceA) &&
      contact.rangeB() == wholeFace(counts[contact.blockB], contact.faceB);
    std::vector<int> tuple{ contact.blockA, contact.faceA, contact.blockB, contact.faceB, contact.orientation,
      whole ? 0 : 1, contact.rangeA.lo[0], contact.rangeA.hi[0], contact.rangeA.lo[1], contact.rangeA.hi[1],
      contact.originB[0], contact.originB[1] };
    if (whole)
    {
      std::fill(tuple.begin() + 6, tuple.end(), 0);
    }
    return tuple;
  });
}

void setBoundaries(vtkFieldData* fields, const std::vector<BoundaryPatch>& boundaries,
  const std::vector<std::string>& names, const std::vector<Ijk>& counts, const std::vector<std::string>& types)
{
  const bool partial = std::any_of(boundaries.begin(), boundaries.end(),
    [&](const BoundaryPatch& patch) { return patch.range != wholeFace(counts[patch.block], patch.face); });
  setIntArray<BoundaryPatch>(fields, "Boundaries", partial ? 7 : 3, boundaries, [](const BoundaryPatch& patch) {
    return std::vector<int>{ patch.block, patch.face, patch.tag, patch.range.lo[0], patch.range.hi[0],
      patch.range.lo[1], patch.range.hi[1] };
  });

  for (const char* name : BoundaryTexts)
  {
    fields->RemoveArray(name);
    const std::vector<std::string>& texts = name == BoundaryTexts[0] ? names : types;
    if (!texts.empty())
    {
      vtkNew<vtkStringArray> array;
      array->SetName(name);
      for (const std::string& text : texts)
      {
        array->InsertNextValue(text);
      }
      fields->AddArray(array);
    }
  }
}

void setCreases(vtkFieldData* fields, const std::vector<CreaseLine>& creases)
{
  setIntArray<CreaseLine>(fields, "CreaseEdges", 7, creases, [](const CreaseLine& line) {
    return std::vector<int>{ line.block, line.from[0], line.from[1], line.from[2], line.to[0], line.to[1], line.to[2] };
  });
}

void setConnectivity(vtkFieldData* fields, const BlockMesh& mesh)
{
  std::vector<Ijk> counts;
  for (const MeshBlock& block : mesh.blocks)
  {
    counts.push_back(block.points.counts());
  }
  setInterfaces(fields, mesh.interfaces, counts);
  setBoundaries(fields, mesh.boundaries, mesh.boundaryNames, counts, mesh.boundaryTypes);
  setCreases(fields, mesh.creases);
}

vtkSmartPointer<vtkStructuredGrid> blockGrid(const Ijk& counts, double*& points)
{
  vtkNew<vtkDoubleArray> values;
  values->SetNumberOfComponents(3);
  values->SetNumberOfTuples(vtkIdType(counts[0]) * counts[1] * counts[2]);
  vtkNew<vtkPoints> owner;
  owner->SetData(values);
  auto grid = vtkSmartPointer<vtkStructuredGrid>::New();
  grid->SetDimensions(counts.data());
  grid->SetPoints(owner);
  points = values->GetPointer(0);
  return grid;
}

std::string nodeName(const std::string& name)
{
  std::string valid = name;
  // Left out, "block 2.1" would have the name of "block 21".
  std::replace_if(
    valid.begin(), valid.end(), [](unsigned char c) { return !std::isalnum(c) && c != '_'; }, '_');
  return vtkDataAssembly::MakeValidNodeName(valid.c_str());
}

void setBlocks(vtkPartitionedDataSetCollection* collection,
  const std::vector<vtkSmartPointer<vtkStructuredGrid>>& grids, const std::vector<std::string>& names, const char* root)
{
  collection->Initialize();
  collection->SetNumberOfPartitionedDataSets(static_cast<unsigned int>(grids.size()));
  vtkNew<vtkDataAssembly> assembly;
  assembly->SetRootNodeName(nodeName(root).c_str());
  for (unsigned int i = 0; i < grids.size(); ++i)
  {
    if (grids[i])
    {
      collection->SetPartition(i, 0, grids[i]);
    }
    collection->GetMetaData(i)->Set(vtkCompositeDataSet::NAME(), names[i].c_str());
    const int node = assembly->AddNode(nodeName(names[i]).c_str());
    assembly->AddDataSetIndex(node, i);
    assembly->SetAttribute(node, "label", names[i].c_str());
  }
  collection->SetDataAssembly(assembly);
}

} // namespace bsv
