// SPDX-License-Identifier: BSD-3-Clause
// Block meshes to VTK data objects and back: nothing is lost, nothing is copied without need, bad arrays are refused.
#include "Data/HexBlockData.h"
#include "Support/MeshCases.h"
#include "Support/ThreadRanks.h"

#include <vtkCompositeDataSet.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkInformation.h>
#include <vtkIntArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPartitionedDataSet.h>
#include <vtkPartitionedDataSetCollection.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSOADataArrayTemplate.h>
#include <vtkStringArray.h>
#include <vtkStructuredGrid.h>

#include <gtest/gtest.h>

#include <functional>
#include <sstream>

using meshcases::MeshCase;
using Grids = std::vector<vtkSmartPointer<vtkStructuredGrid>>;

namespace
{

MeshCase partialContacts()
{
  MeshCase mesh = meshcases::latticeBlocks(
    { { { 0, 0, 0 }, { 2, 4, 3 } }, { { 2, 0, 0 }, { 5, 2, 3 } }, { { 2, 2, 0 }, { 4, 4, 3 } } });
  mesh.boundaryNames = { "wall", "far field" };
  meshcases::declareAll(mesh, 1);
  mesh.creases.push_back({ 1, { 0, 1, 0 }, { 3, 1, 0 } });
  return mesh;
}

template <typename Array>
vtkSmartPointer<vtkStructuredGrid> toGrid(const MeshCase::Block& block)
{
  auto array = vtkSmartPointer<Array>::New();
  array->SetNumberOfComponents(3);
  array->SetNumberOfTuples(static_cast<vtkIdType>(block.points.size()));
  for (std::size_t p = 0; p < block.points.size(); ++p)
  {
    array->SetTuple(static_cast<vtkIdType>(p), block.points[p].data());
  }
  vtkNew<vtkPoints> points;
  points->SetData(array);
  auto grid = vtkSmartPointer<vtkStructuredGrid>::New();
  grid->SetDimensions(block.counts.data());
  grid->SetPoints(points);
  return grid;
}

vtkSmartPointer<vtkPartitionedDataSetCollection> toCollection(MeshCase& mesh)
{
  Grids grids;
  std::vector<std::string> names;
  for (const MeshCase::Block& block : mesh.blocks)
  {
    grids.push_back(toGrid<vtkDoubleArray>(block));
    names.push_back("name of " + std::to_string(names.size()));
  }
  auto collection = vtkSmartPointer<vtkPartitionedDataSetCollection>::New();
  bsv::setBlocks(collection, grids, names, "mesh");
  bsv::setConnectivity(collection->GetFieldData(), mesh.mesh());
  return collection;
}

void setInts(vtkFieldData* fields, const char* name, int components, const std::vector<int>& values)
{
  vtkNew<vtkIntArray> array;
  array->SetName(name);
  array->SetNumberOfComponents(components);
  for (std::size_t i = 0; i < values.size(); i += components)
  {
    array->InsertNextTypedTuple(&values[i]);
  }
  fields->RemoveArray(name);
  fields->AddArray(array);
}

std::string refusal(vtkDataObject* data)
{
  Grids grids;
  try
  {
    bsv::blockMesh(data, grids);
  }
  catch (const bsv::Error& error)
  {
    return error.what();
  }
  return "";
}

/// What a rank has of the collection: the blocks that `isHere` says.
vtkSmartPointer<vtkPartitionedDataSetCollection> partOf(
  vtkPartitionedDataSetCollection* whole, const std::function<bool(int block)>& isHere)
{
  auto part = vtkSmartPointer<vtkPartitionedDataSetCollection>::New();
  Grids grids;
  std::vector<std::string> names;
  for (unsigned int b = 0; b < whole->GetNumberOfPartitionedDataSets(); ++b)
  {
    auto* grid = vtkStructuredGrid::SafeDownCast(whole->GetPartitionAsDataObject(b, 0));
    grids.push_back(isHere(static_cast<int>(b)) ? grid : nullptr);
    names.push_back(whole->GetMetaData(b)->Get(vtkCompositeDataSet::NAME()));
  }
  bsv::setBlocks(part, grids, names, "mesh");
  part->GetFieldData()->ShallowCopy(whole->GetFieldData());
  return part;
}

/// Everything but the points.
std::string topologyOf(const bsv::BlockMesh& mesh)
{
  std::ostringstream text;
  const auto range = [&](const bsv::FaceRange& r) {
    text << r.lo[0] << ' ' << r.hi[0] << ' ' << r.lo[1] << ' ' << r.hi[1] << '\n';
  };
  for (const bsv::MeshBlock& block : mesh.blocks)
  {
    const auto& counts = block.points.counts();
    text << block.name << ": " << counts[0] << ' ' << counts[1] << ' ' << counts[2] << '\n';
  }
  for (const bsv::Interface& contact : mesh.interfaces)
  {
    text << contact.blockA << ' ' << contact.faceA << ' ' << contact.blockB << ' ' << contact.faceB << ' '
         << contact.orientation << ' ';
    range(contact.rangeA);
    range(contact.rangeB());
  }
  for (const bsv::BoundaryPatch& patch : mesh.boundaries)
  {
    text << patch.block << ' ' << patch.face << ' ' << mesh.boundaryNames[patch.tag] << ' ';
    range(patch.range);
  }
  for (const bsv::CreaseLine& line : mesh.creases)
  {
    text << line.block << ' ' << line.from[0] << line.from[1] << line.from[2] << line.to[0] << line.to[1] << line.to[2]
         << '\n';
  }
  return text.str();
}

} // namespace

TEST(HexBlockData, RoundTrip)
{
  MeshCase mesh = partialContacts();
  const auto collection = toCollection(mesh);
  Grids grids;
  const bsv::BlockMesh found = bsv::blockMesh(collection, grids);

  ASSERT_EQ(found.blocks.size(), mesh.blocks.size());
  for (std::size_t b = 0; b < found.blocks.size(); ++b)
  {
    EXPECT_EQ(found.blocks[b].name, "name of " + std::to_string(b));
    EXPECT_EQ(found.blocks[b].points.counts(), mesh.blocks[b].counts);
    EXPECT_EQ(found.blocks[b].points.address<double>(0, 0, 0),
      vtkDoubleArray::SafeDownCast(grids[b]->GetPoints()->GetData())->GetPointer(0));
  }
  ASSERT_EQ(found.interfaces.size(), mesh.interfaces.size());
  for (std::size_t i = 0; i < found.interfaces.size(); ++i)
  {
    const bsv::Interface& a = found.interfaces[i];
    const bsv::Interface& b = mesh.interfaces[i];
    EXPECT_EQ(std::make_tuple(a.blockA, a.faceA, a.blockB, a.faceB, a.orientation, a.originB),
      std::make_tuple(b.blockA, b.faceA, b.blockB, b.faceB, b.orientation, b.originB));
    EXPECT_EQ(a.rangeA, b.rangeA);
  }
  ASSERT_EQ(found.boundaries.size(), mesh.boundaries.size());
  for (std::size_t i = 0; i < found.boundaries.size(); ++i)
  {
    const bsv::BoundaryPatch& a = found.boundaries[i];
    const bsv::BoundaryPatch& b = mesh.boundaries[i];
    EXPECT_EQ(std::make_tuple(a.block, a.face, a.tag), std::make_tuple(b.block, b.face, b.tag));
    EXPECT_EQ(a.range, b.range);
  }
  EXPECT_EQ(found.boundaryNames, mesh.boundaryNames);
  ASSERT_EQ(found.creases.size(), 1u);
  EXPECT_EQ(found.creases[0].block, 1);
  EXPECT_EQ(found.creases[0].to, (bsv::Ijk{ 3, 1, 0 }));

  bsv::setConnectivity(collection->GetFieldData(), {});
  EXPECT_EQ(collection->GetFieldData()->GetNumberOfArrays(), 0);
}

TEST(HexBlockData, WholeFacesNeedNoRanges)
{
  MeshCase mesh = meshcases::cutBox({ 4, 2, 2 }, { { { 2 }, {}, {} } });
  mesh.boundaryNames = { "wall" };
  meshcases::declareAll(mesh);
  const auto collection = toCollection(mesh);
  EXPECT_EQ(collection->GetFieldData()->GetArray("Boundaries")->GetNumberOfComponents(), 3);
  EXPECT_EQ(collection->GetFieldData()->GetArray("Interfaces")->GetComponent(0, 5), 0.0);
  Grids grids;
  const bsv::BlockMesh found = bsv::blockMesh(collection, grids);
  EXPECT_EQ(found.interfaces[0].rangeA, mesh.interfaces[0].rangeA);
  EXPECT_EQ(found.boundaries[0].range, mesh.boundaries[0].range);
}

TEST(HexBlockData, AnyPointArray)
{
  const MeshCase mesh = meshcases::cutBox({ 2, 3, 1 });
  const MeshCase::Block& block = mesh.blocks[0];
  const std::vector<vtkSmartPointer<vtkStructuredGrid>> inputs = { toGrid<vtkDoubleArray>(block),
    toGrid<vtkFloatArray>(block), toGrid<vtkIntArray>(block), toGrid<vtkSOADataArrayTemplate<float>>(block) };
  for (const auto& input : inputs)
  {
    Grids grids;
    const bsv::BlockMesh found = bsv::blockMesh(input, grids);
    ASSERT_EQ(found.blocks.size(), 1u);
    for (int k = 0; k < 2; ++k)
    {
      for (int j = 0; j < 4; ++j)
      {
        for (int i = 0; i < 3; ++i)
        {
          EXPECT_EQ(found.blocks[0].points(i, j, k), block.at({ i, j, k }));
        }
      }
    }
    const bool copied = grids[0] != input;
    EXPECT_EQ(copied, input == inputs[2] || input == inputs[3]);
  }
}

TEST(HexBlockData, MissingLeavesKeepTheirNumbers)
{
  MeshCase mesh = partialContacts();
  const auto collection = toCollection(mesh);
  vtkNew<vtkMultiBlockDataSet> inner;
  inner->SetBlock(0, nullptr);
  inner->GetMetaData(0u)->Set(vtkCompositeDataSet::NAME(), "gone");
  inner->SetBlock(1, collection->GetPartition(1, 0));
  inner->GetMetaData(1u)->Set(vtkCompositeDataSet::NAME(), "second");
  vtkNew<vtkMultiBlockDataSet> outer;
  outer->SetBlock(0, inner);
  outer->SetBlock(1, collection->GetPartition(2, 0));
  outer->GetFieldData()->ShallowCopy(collection->GetFieldData());
  Grids grids;
  const bsv::BlockMesh found = bsv::blockMesh(outer, grids);

  ASSERT_EQ(found.blocks.size(), 2u);
  EXPECT_EQ(found.blocks[0].name, "second");
  EXPECT_EQ(found.blocks[1].name, "block 2");
  // Only the contact of the blocks 1 and 2 is left; these are the blocks 0 and 1 now.
  ASSERT_EQ(found.interfaces.size(), 1u);
  EXPECT_EQ(found.interfaces[0].blockA + found.interfaces[0].blockB, 1);
  for (const bsv::BoundaryPatch& patch : found.boundaries)
  {
    EXPECT_LT(patch.block, 2);
  }
  EXPECT_EQ(found.creases[0].block, 0);
}

TEST(HexBlockData, Nothing)
{
  Grids grids;
  EXPECT_TRUE(bsv::blockMesh(nullptr, grids).blocks.empty());
  vtkNew<vtkPartitionedDataSetCollection> empty;
  EXPECT_TRUE(bsv::blockMesh(empty, grids).blocks.empty());
}

TEST(HexBlockData, CreaseSharpness)
{
  const MeshCase mesh = meshcases::cutBox({ 1, 1, 1 });
  auto grid = toGrid<vtkDoubleArray>(mesh.blocks[0]);
  vtkNew<vtkFloatArray> sharpness;
  sharpness->SetName("CreaseSharpness");
  for (int i = 0; i < 8; ++i)
  {
    sharpness->InsertNextValue(float(i));
  }
  grid->GetPointData()->AddArray(sharpness);
  Grids grids;
  EXPECT_EQ(bsv::blockMesh(grid, grids).blocks[0].creaseSharpness, (std::vector<double>{ 0, 1, 2, 3, 4, 5, 6, 7 }));

  sharpness->SetNumberOfComponents(2);
  EXPECT_NE(refusal(grid).find("CreaseSharpness"), std::string::npos);
  sharpness->SetNumberOfComponents(1);
  sharpness->SetNumberOfTuples(5);
  EXPECT_NE(refusal(grid).find("each of 8 points, but is vtkFloatArray with 1 for each of 5"), std::string::npos)
    << refusal(grid);
}

TEST(HexBlockData, RefusesWhatIsNoBlockMesh)
{
  vtkNew<vtkMultiBlockDataSet> tree;
  vtkNew<vtkPolyData> picture;
  tree->SetBlock(0, picture);
  tree->GetMetaData(0u)->Set(vtkCompositeDataSet::NAME(), "picture");
  const std::string error = refusal(tree);
  EXPECT_NE(error.find("'picture'"), std::string::npos) << error;
  EXPECT_NE(error.find("vtkPolyData"), std::string::npos) << error;

  MeshCase mesh = meshcases::cutBox({ 2, 2, 2 });
  auto flat = toGrid<vtkDoubleArray>(mesh.blocks[0]);
  flat->SetDimensions(27, 1, 1);
  EXPECT_NE(refusal(flat).find("27 x 1 x 1"), std::string::npos);
  auto few = toGrid<vtkDoubleArray>(mesh.blocks[0]);
  few->SetDimensions(3, 3, 4);
  EXPECT_NE(refusal(few).find("27"), std::string::npos);
}

TEST(HexBlockData, RefusesBadArrays)
{
  struct Bad
  {
    const char* what;
    const char* array;
    int components;
    std::vector<int> values;
    std::vector<std::string> parts;
  };
  // Blocks of 3 x 3 x 3 and 3 x 3 x 3 points.
  const std::vector<Bad> all = {
    { "components", "Interfaces", 5, { 0, 1, 1, 0, 0 }, { "12", "5" } },
    { "block", "Interfaces", 12, { 0, 1, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0 }, { "entry 0", "block 2", "0..1" } },
    { "negative block", "Interfaces", 12, { -1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0 }, { "block -1" } },
    { "face", "Interfaces", 12, { 0, 6, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0 }, { "face 6", "0..5" } },
    { "orientation", "Interfaces", 12, { 0, 1, 1, 0, 8, 0, 0, 0, 0, 0, 0, 0 }, { "orientation 8" } },
    { "flag", "Interfaces", 12, { 0, 1, 1, 0, 0, 2, 0, 0, 0, 0, 0, 0 }, { "flag", "2" } },
    { "range", "Interfaces", 12, { 0, 1, 1, 0, 0, 1, 0, 3, 0, 2, 0, 0 }, { "range 3", "0..2" } },
    { "empty range", "Interfaces", 12, { 0, 1, 1, 0, 0, 1, 1, 1, 0, 2, 0, 0 }, { "range 1", "0..0" } },
    { "range on B", "Interfaces", 12, { 0, 1, 1, 0, 0, 1, 0, 2, 0, 2, 1, 0 }, { "numbers of points" } },
    { "second entry", "Interfaces", 12, { 0, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 7, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0 },
      { "entry 1", "face 7" } },
    { "components", "Boundaries", 4, { 0, 0, 0, 0 }, { "3 or 7" } },
    { "block", "Boundaries", 3, { 5, 0, 0 }, { "block 5" } },
    { "face", "Boundaries", 3, { 0, -1, 0 }, { "face -1" } },
    { "tag", "Boundaries", 3, { 0, 0, 1 }, { "tag", "1", "0..0" } },
    { "range", "Boundaries", 7, { 0, 0, 0, 0, 2, 0, 9 }, { "range 9", "0..2" } },
    { "point", "CreaseEdges", 7, { 0, 0, 0, 0, 3, 0, 0 }, { "mesh point 3", "0..2" } },
    { "diagonal", "CreaseEdges", 7, { 0, 0, 0, 0, 2, 1, 0 }, { "entry 0", "one direction" } },
    { "no extent", "CreaseEdges", 7, { 0, 1, 1, 1, 1, 1, 1 }, { "one direction" } },
  };
  for (const Bad& bad : all)
  {
    MeshCase mesh = meshcases::cutBox({ 4, 2, 2 }, { { { 2 }, {}, {} } });
    mesh.boundaryNames = { "wall" };
    const auto collection = toCollection(mesh);
    setInts(collection->GetFieldData(), bad.array, bad.components, bad.values);
    const std::string error = refusal(collection);
    EXPECT_NE(error.find(bad.array), std::string::npos) << bad.what << ": " << error;
    for (const std::string& part : bad.parts)
    {
      EXPECT_NE(error.find(part), std::string::npos) << bad.what << ": " << error;
    }
  }

  MeshCase mesh = meshcases::cutBox({ 2, 2, 2 });
  const auto collection = toCollection(mesh);
  vtkNew<vtkDoubleArray> doubles;
  doubles->SetName("Interfaces");
  doubles->SetNumberOfComponents(12);
  collection->GetFieldData()->AddArray(doubles);
  EXPECT_NE(refusal(collection).find("vtkDoubleArray"), std::string::npos);
  collection->GetFieldData()->RemoveArray("Interfaces");
  doubles->SetName("BoundaryNames");
  collection->GetFieldData()->AddArray(doubles);
  EXPECT_NE(refusal(collection).find("BoundaryNames"), std::string::npos);
}

// Blocks are chosen by the paths of their nodes.
TEST(HexBlockData, DifferentNamesAreDifferentNodes)
{
  EXPECT_EQ(bsv::nodeName("wing_upper_1"), "wing_upper_1");
  EXPECT_NE(bsv::nodeName("block 2.1"), bsv::nodeName("block 21"));
  EXPECT_NE(bsv::nodeName("a|b"), bsv::nodeName("ab"));
}

// Blocks on some of the ranks, on all of them, or all on one that is not the first; field data on one rank only.
TEST(HexBlockData, RanksKnowAllBlocks)
{
  MeshCase mesh = partialContacts();
  const auto whole = toCollection(mesh);
  Grids wholeGrids;
  const std::string expected = topologyOf(bsv::blockMesh(whole, wholeGrids));
  using Distribution = std::function<bool(int block, int rank)>;
  const std::vector<Distribution> distributions = { [](int, int) { return true; },
    [](int, int rank) { return rank == 1; }, [](int block, int rank) { return block == rank; },
    [](int block, int rank) { return rank > 0 && block % 2 == rank % 2; } };
  for (int size = 2; size <= 5; ++size)
  {
    for (std::size_t d = 0; d < distributions.size(); ++d)
    {
      if (size == 2 && d > 1)
      {
        continue; // these need three ranks
      }
      const auto errors = bsvtest::onRanks(size, [&](const bsv::Execution& run) {
        const int rank = run.ranks->rank();
        const auto part = partOf(whole, [&](int block) { return distributions[d](block, rank); });
        if (rank != 1)
        {
          part->GetFieldData()->Initialize();
        }
        vtkNew<vtkPartitionedDataSetCollection> nothing;
        Grids grids;
        const bsv::BlockMesh found = bsv::blockMesh(rank == 4 && d > 0 ? nothing.Get() : part.Get(), grids, run);
        EXPECT_EQ(topologyOf(found), expected);
        for (int b = 0; b < 3; ++b)
        {
          int owner = 0;
          while (!distributions[d](b, owner))
          {
            ++owner;
          }
          EXPECT_EQ(found.blocks[b].rank, owner);
          EXPECT_EQ(found.blocks[b].points.isHere(), owner == rank);
          EXPECT_EQ(grids[b] != nullptr, owner == rank);
        }
      });
      EXPECT_EQ(errors, std::vector<std::string>(size)) << size << " ranks, distribution " << d;
    }
  }
}

TEST(HexBlockData, PartitionsOfOneDataSetOnSeveralRanks)
{
  const MeshCase mesh = meshcases::cutBox({ 6, 2, 2 }, { { { 2, 4 }, {}, {} } });
  const auto errors = bsvtest::onRanks(2, [&](const bsv::Execution& run) {
    vtkNew<vtkPartitionedDataSetCollection> collection;
    collection->SetNumberOfPartitionedDataSets(2);
    if (run.ranks->rank() == 0)
    {
      collection->SetPartition(1, 0, toGrid<vtkDoubleArray>(mesh.blocks[2]));
    }
    else
    {
      collection->SetPartition(0, 1, toGrid<vtkDoubleArray>(mesh.blocks[1]));
      collection->GetMetaData(1u)->Set(vtkCompositeDataSet::NAME(), "last");
    }
    Grids grids;
    const bsv::BlockMesh found = bsv::blockMesh(collection, grids, run);
    ASSERT_EQ(found.blocks.size(), 2u);
    EXPECT_EQ(found.blocks[0].name, "block 1");
    EXPECT_EQ(found.blocks[0].rank, 1);
    // Only the rank without the block knows its name.
    EXPECT_EQ(found.blocks[1].name, "last");
    EXPECT_EQ(found.blocks[1].rank, 0);
  });
  EXPECT_EQ(errors, std::vector<std::string>(2));
}

TEST(HexBlockData, RanksMustAgree)
{
  MeshCase mesh = partialContacts();
  const auto whole = toCollection(mesh);
  struct Bad
  {
    const char* what;
    std::function<void(vtkPartitionedDataSetCollection* part, int rank)> spoil;
    std::vector<std::string> parts;
  };
  const std::vector<Bad> all = {
    { "name",
      [](auto* part, int rank) {
        if (rank == 2)
        {
          part->GetMetaData(0u)->Set(vtkCompositeDataSet::NAME(), "other");
        }
      },
      { "'name of 0'", "'other'", "rank 0", "rank 2" } },
    { "size",
      [&](auto* part, int rank) {
        if (rank == 2)
        {
          part->SetPartition(1, 0, part->GetPartition(0, 0) ? part->GetPartition(0, 0) : part->GetPartition(2, 0));
        }
      },
      { "'name of 1' of 4 x 3 x 4", "'name of 1' of 3 x 3 x 4", "rank 1", "rank 2" } },
    { "array",
      [](auto* part, int rank) {
        if (rank == 1)
        {
          part->GetFieldData()->RemoveArray("Boundaries");
        }
        else if (rank == 2)
        {
          setInts(part->GetFieldData(), "Boundaries", 3, { 0, 0, 1 });
        }
      },
      { "'Boundaries'", "0 and 2" } },
    { "bad array",
      [](auto* part, int rank) {
        if (rank == 1)
        {
          setInts(part->GetFieldData(), "CreaseEdges", 2, { 0, 0 });
        }
      },
      { "'CreaseEdges'", "7", "2" } },
    { "points",
      [](auto* part, int rank) {
        if (rank == 1)
        {
          vtkStructuredGrid::SafeDownCast(part->GetPartitionAsDataObject(1, 0))->SetDimensions(2, 2, 2);
        }
      },
      { "'name of 1'", "48", "8" } },
    { "structure",
      [](auto* part, int rank) {
        if (rank == 1)
        {
          part->SetNumberOfPartitionedDataSets(5);
        }
      },
      { "3 data sets on rank 0", "5 on rank 1" } },
  };
  for (const Bad& bad : all)
  {
    const auto errors = bsvtest::onRanks(3, [&](const bsv::Execution& run) {
      const int rank = run.ranks->rank();
      const auto shared = partOf(whole, [&](int block) { return block == rank; });
      vtkNew<vtkPartitionedDataSetCollection> part; // grids of its own
      part->DeepCopy(shared);
      bad.spoil(part, rank);
      Grids grids;
      bsv::blockMesh(part, grids, run);
    });
    EXPECT_EQ(errors, std::vector<std::string>(3, errors[0])) << bad.what;
    for (const std::string& part : bad.parts)
    {
      EXPECT_NE(errors[0].find(part), std::string::npos) << bad.what << ": " << errors[0];
    }
  }
}
