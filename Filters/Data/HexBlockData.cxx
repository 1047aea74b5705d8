// SPDX-License-Identifier: BSD-3-Clause
#include "Data/HexBlockData.h"

#include "Base/MemoryCheck.h"
#include "Data/BlockTags.h"
#include "Data/HexMeshData.h"
#include "Data/SurfaceNames.h"
#include "Data/TreeLeaves.h"
#include "Execution/FilterExecution.h"
#include "Ranks/Texts.h"

#include <vtkAOSDataArrayTemplate.h>
#include <vtkCompositeDataSet.h>
#include <vtkDataAssembly.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkInformation.h>
#include <vtkNew.h>
#include <vtkPartitionedDataSetCollection.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkStructuredGrid.h>

#include <algorithm>
#include <cctype>

namespace bsv
{

namespace
{

template <typename Real>
const Real* xyzTriples(vtkDataArray* array)
{
  auto* values = vtkAOSDataArrayTemplate<Real>::FastDownCast(array);
  return values ? values->GetPointer(0) : nullptr;
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
  readConnectivity(ownFields, blockOfLeaf, mesh, ranks);
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

/// Gives all ranks what the first one, which makes the blocks, has to say. Collective.
void shareReport(HexMeshReport& report, const Ranks& ranks)
{
  const auto share = [&](std::vector<std::string>& sentences) {
    sentences = textsOf(ranks.gather(lettersOf(sentences)).front());
  };
  share(report.notes);
  share(report.warnings);
  const std::vector<std::vector<Index>> counts = ranks.gather(std::vector<Index>{ report.cells, report.blocks });
  report.cells = counts.front()[0];
  report.blocks = counts.front()[1];
}

} // namespace

std::vector<NamedLeaf> namedLeaves(vtkDataObject* input)
{
  std::vector<NamedLeaf> result;
  for (const Leaf& leaf : leavesOf(input))
  {
    result.push_back({ leaf.data, leaf.name });
  }
  return result;
}

BlockMesh blockMesh(vtkDataObject* given, std::vector<vtkSmartPointer<vtkStructuredGrid>>& grids, const Execution& run)
{
  const Ranks& ranks = *run.ranks;
  const vtkSmartPointer<vtkDataObject> input = withExplicitPoints(given);
  if (!ranks.any(needsBlocks(input)))
  {
    std::vector<Leaf> leaves = leavesOf(input);
    const std::vector<NamedLeaf> surfaces = takeSurfaces(leaves, ranks);
    BlockMesh mesh = blocksOfLeaves(leaves, input ? input->GetFieldData() : nullptr, grids, ranks);
    nameBySurfaces(mesh, surfaces, ranks);
    return mesh;
  }
  vtkNew<vtkPartitionedDataSetCollection> blocks;
  HexMeshReport report = hexMeshToBlocks(input, nullptr, {}, blocks, run);
  shareReport(report, ranks);
  BlockMesh mesh = structuredBlocks(blocks, grids, ranks);
  mesh.notes = std::move(report.notes);
  if (!mesh.blocks.empty())
  {
    mesh.notes.insert(mesh.notes.begin(),
      std::to_string(report.cells) + " unstructured hexahedra were made to " + std::to_string(report.blocks) +
        " blocks (Hex Mesh To Blocks).");
  }
  mesh.warnings = std::move(report.warnings);
  return mesh;
}

BlockMesh structuredBlocks(
  vtkDataObject* input, std::vector<vtkSmartPointer<vtkStructuredGrid>>& grids, const Ranks& ranks)
{
  return blocksOfLeaves(leavesOf(input), input ? input->GetFieldData() : nullptr, grids, ranks);
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
