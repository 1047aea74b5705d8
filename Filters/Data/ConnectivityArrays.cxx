// SPDX-License-Identifier: BSD-3-Clause
// Contacts, boundaries and creases as arrays of the field data.
#include "Data/BlockTagArrays.h"
#include "Data/TreeLeaves.h"

#include "Ranks/Ranks.h"
#include "Ranks/Texts.h"

#include <vtkFieldData.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkStringArray.h>

#include <algorithm>
#include <functional>
#include <memory>

namespace bsv
{

namespace
{

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
    std::unique_ptr<std::vector<char>> letters;
    if (vtkStringArray* texts = boundaryTexts(mine, array))
    {
      letters = std::make_unique<std::vector<char>>(
        lettersOf({ texts->GetPointer(0), texts->GetPointer(0) + texts->GetNumberOfValues() }));
    }
    if (const auto all = sharedArray(std::move(letters), array, ranks))
    {
      vtkNew<vtkStringArray> texts;
      texts->SetName(array);
      for (const std::string& text : textsOf(*all))
      {
        texts->InsertNextValue(text);
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

  FaceRange whole(int block, int face) const { return wholeFace(this->Blocks[block].points.counts(), face); }

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

} // namespace

void readConnectivity(vtkFieldData* mine, const std::vector<int>& blockOfLeaf, BlockMesh& mesh, const Ranks& ranks)
{
  const vtkSmartPointer<vtkFieldData> fields = sharedFields(mine, ranks);
  readInterfaces(fields, blockOfLeaf, mesh);
  readBoundaries(fields, blockOfLeaf, mesh);
  readCreases(fields, blockOfLeaf, mesh);
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

} // namespace bsv
