// SPDX-License-Identifier: BSD-3-Clause
#include "Data/TreeLeaves.h"

#include "Base/MemoryCheck.h"
#include "Ranks/Ranks.h"
#include "Ranks/Texts.h"

#include <vtkCellData.h>
#include <vtkCompositeDataSet.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkFieldData.h>
#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkPartitionedDataSet.h>
#include <vtkPartitionedDataSetCollection.h>
#include <vtkPointData.h>
#include <vtkRectilinearGrid.h>
#include <vtkStructuredGrid.h>

#include <algorithm>
#include <limits>

namespace bsv
{

namespace
{

std::string metaName(vtkInformation* information)
{
  const char* name =
    information && information->Has(vtkCompositeDataSet::NAME()) ? information->Get(vtkCompositeDataSet::NAME()) : "";
  return name ? name : "";
}

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

/// Whether the points of a grid are given by spacings or coordinates per direction. @param[out] counts points per
/// direction
bool hasImplicitPoints(vtkDataObject* data, Ijk& counts)
{
  auto* image = vtkImageData::SafeDownCast(data);
  auto* rectilinear = vtkRectilinearGrid::SafeDownCast(data);
  if (image)
  {
    image->GetDimensions(counts.data());
  }
  else if (rectilinear)
  {
    rectilinear->GetDimensions(counts.data());
  }
  return image || rectilinear;
}

/// A structured grid with the same points and arrays.
vtkSmartPointer<vtkStructuredGrid> structuredGrid(vtkDataSet* data, const Ijk& counts)
{
  const vtkIdType size = data->GetNumberOfPoints();
  requireMemory(3.0 * sizeof(double) * static_cast<double>(size), data->GetClassName(), "its points");
  double* points = nullptr;
  vtkSmartPointer<vtkStructuredGrid> grid =
    size > 0 ? blockGrid(counts, points) : vtkSmartPointer<vtkStructuredGrid>::New();
  for (vtkIdType p = 0; p < size; ++p)
  {
    data->GetPoint(p, points + 3 * p);
  }
  grid->GetPointData()->ShallowCopy(data->GetPointData());
  grid->GetCellData()->ShallowCopy(data->GetCellData());
  grid->GetFieldData()->ShallowCopy(data->GetFieldData());
  return grid;
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

/// A block as the tree of one rank has it.
struct LeafRecord
{
  int dataSet;
  int partition;
  Ijk counts;
  int nameLength;
};

/// What every rank has.
struct LeavesOfRanks
{
  /// The number of data sets; then those of several partitions with how many.
  std::vector<std::vector<int>> widths;
  std::vector<std::vector<LeafRecord>> records;
  /// One behind the other.
  std::vector<std::vector<char>> names;
};

LeavesOfRanks gatherLeaves(const std::vector<Leaf>& leaves, const Ranks& ranks)
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
  return { ranks.gather(widths), ranks.gather(records), ranks.gather(names) };
}

/// Partitions per data set.
std::vector<int> countPlaces(const LeavesOfRanks& all, const Ranks& ranks)
{
  int first = -1; // rank with blocks
  std::vector<int> places;
  for (int r = 0; r < ranks.size(); ++r)
  {
    const int dataSets = all.widths[r][0];
    if (!all.records[r].empty() && first >= 0 && dataSets != all.widths[first][0])
    {
      throw Error("The mesh has " + std::to_string(all.widths[first][0]) + " data sets on rank " +
        std::to_string(first) + ", but " + std::to_string(dataSets) + " on rank " + std::to_string(r) +
        "; every rank must have all of them, without the blocks that are on other ranks.");
    }
    first = first < 0 && !all.records[r].empty() ? r : first;
    places.resize(std::max<std::size_t>(places.size(), dataSets), 1);
    for (std::size_t w = 1; w < all.widths[r].size(); w += 2)
    {
      int& width = places[all.widths[r][w]];
      width = std::max(width, all.widths[r][w + 1]);
    }
  }
  return places;
}

/// Names of blocks that have none where they are, from ranks that know them without the block. Collective.
void nameLeaves(std::vector<SharedLeaf>& shared, const Ranks& ranks)
{
  std::vector<SharedLeaf*> unnamed;
  std::vector<std::string> known;
  for (SharedLeaf& leaf : shared)
  {
    if (leaf.rank >= 0 && leaf.name.empty())
    {
      unnamed.push_back(&leaf);
      known.push_back(leaf.own ? leaf.own->name : "");
    }
  }
  if (!unnamed.empty())
  {
    for (const std::vector<char>& letters : ranks.gather(lettersOf(known)))
    {
      const std::vector<std::string> names = textsOf(letters);
      for (std::size_t i = 0; i < unnamed.size(); ++i)
      {
        unnamed[i]->name = unnamed[i]->name.empty() ? names[i] : unnamed[i]->name;
      }
    }
  }
}

} // namespace

std::vector<Leaf> leavesOf(vtkDataObject* input)
{
  std::vector<Leaf> leaves;
  if (input)
  {
    collectLeaves(input, "", leaves);
  }
  return leaves;
}

vtkSmartPointer<vtkDataObject> withExplicitPoints(vtkDataObject* input)
{
  Ijk counts;
  if (hasImplicitPoints(input, counts))
  {
    return structuredGrid(vtkDataSet::SafeDownCast(input), counts);
  }
  auto* tree = vtkDataObjectTree::SafeDownCast(input);
  if (!tree)
  {
    return input;
  }
  vtkSmartPointer<vtkDataObjectTree> copy;
  const auto leaves = vtkSmartPointer<vtkDataObjectTreeIterator>::Take(tree->NewTreeIterator());
  for (leaves->InitTraversal(); !leaves->IsDoneWithTraversal(); leaves->GoToNextItem())
  {
    vtkDataObject* leaf = leaves->GetCurrentDataObject();
    if (hasImplicitPoints(leaf, counts))
    {
      if (!copy)
      {
        copy.TakeReference(tree->NewInstance());
        copy->ShallowCopy(tree);
      }
      copy->SetDataSet(leaves, structuredGrid(vtkDataSet::SafeDownCast(leaf), counts));
    }
  }
  if (copy)
  {
    return copy;
  }
  return input;
}

std::string blockName(const std::string& name, std::size_t leaf)
{
  return name.empty() ? "block " + std::to_string(leaf) : name;
}

std::vector<SharedLeaf> shareLeaves(const std::vector<Leaf>& leaves, const Ranks& ranks)
{
  const LeavesOfRanks all = gatherLeaves(leaves, ranks);
  const std::vector<int> places = countPlaces(all, ranks);
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
    auto text = all.names[r].begin();
    for (const LeafRecord& record : all.records[r])
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
  nameLeaves(shared, ranks);
  return shared;
}

} // namespace bsv
