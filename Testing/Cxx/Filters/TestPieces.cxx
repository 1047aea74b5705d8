// SPDX-License-Identifier: BSD-3-Clause
// Readers and sources in pieces: together the pieces are the whole, each block in one of them.
#include "Support/MeshFiles.h"
#include "Support/ThreadRanks.h"
#include "Support/VolumeCases.h"

#include "Formats/FaceContact.h"
#include "Formats/NeutralMapFile.h"
#include "Quadflow/QuadflowFormat.h"
#include "Ranks/Ranks.h"

#include "vtkBSplineVolumeReader.h"
#include "vtkQuadflowReader.h"
#include "vtkWingFuselageSource.h"

#include <vtkCellData.h>
#include <vtkDataAssembly.h>
#include <vtkFieldData.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkStringArray.h>
#include <vtkStructuredGrid.h>

#include <sstream>

using namespace meshfiles;
using bsv::Execution;
using bsv::Index;
using bsv::Piece;

namespace
{

std::string bytesOf(vtkAbstractArray* array)
{
  std::string bytes = array->GetName() ? array->GetName() : "";
  bytes += "(" + std::to_string(array->GetNumberOfComponents()) + ", " + array->GetClassName() + ")";
  if (auto* strings = vtkStringArray::SafeDownCast(array))
  {
    for (vtkIdType i = 0; i < strings->GetNumberOfValues(); ++i)
    {
      bytes += strings->GetValue(i) + "\n";
    }
    return bytes;
  }
  const auto size = static_cast<std::size_t>(array->GetNumberOfValues()) * array->GetDataTypeSize();
  return bytes.append(static_cast<const char*>(array->GetVoidPointer(0)), size);
}

std::string bytesOf(vtkFieldData* fields)
{
  std::string bytes;
  for (int a = 0; a < fields->GetNumberOfArrays(); ++a)
  {
    bytes += bytesOf(fields->GetAbstractArray(a));
  }
  return bytes;
}

/// Everything that a block holds.
std::string bytesOf(vtkStructuredGrid* grid)
{
  Ijk counts;
  grid->GetDimensions(counts.data());
  const std::string size(reinterpret_cast<const char*>(counts.data()), sizeof(counts));
  return size + bytesOf(grid->GetPoints()->GetData()) + bytesOf(grid->GetPointData()) + bytesOf(grid->GetCellData()) +
    bytesOf(grid->GetFieldData());
}

/// A data set per block, empty if it is elsewhere, and what every piece must have.
struct Output
{
  std::vector<std::string> blocks;
  std::vector<Index> points;
  std::string common;
};

Output outputOf(vtkAlgorithm* algorithm)
{
  auto* data = vtkPartitionedDataSetCollection::SafeDownCast(algorithm->GetOutputDataObject(0));
  Output output;
  for (unsigned int b = 0; b < data->GetNumberOfPartitionedDataSets(); ++b)
  {
    output.common += std::string(data->GetMetaData(b)->Get(vtkCompositeDataSet::NAME())) + "\n";
    EXPECT_LE(data->GetNumberOfPartitions(b), 1u);
    const bool isHere = data->GetNumberOfPartitions(b) == 1;
    auto* grid = isHere ? vtkStructuredGrid::SafeDownCast(data->GetPartition(b, 0)) : nullptr;
    EXPECT_EQ(grid != nullptr, isHere);
    output.blocks.push_back(grid ? bytesOf(grid) : "");
    output.points.push_back(grid ? grid->GetNumberOfPoints() : 0);
  }
  output.common += data->GetDataAssembly() ? data->GetDataAssembly()->SerializeToXML(vtkIndent()) : "no assembly";
  output.common += bytesOf(data->GetFieldData());
  return output;
}

/// @param shares what the blocks are shared out by; their points if empty.
void expectPieces(vtkAlgorithm* algorithm, const std::string& what, std::vector<Index> shares = {})
{
  algorithm->UpdatePiece(0, 1, 0);
  const Output whole = outputOf(algorithm);
  ASSERT_GT(whole.blocks.size(), 1u) << what;
  shares = shares.empty() ? whole.points : shares;
  for (const int count : { 1, 2, 3, 5, static_cast<int>(whole.blocks.size()) + 3 })
  {
    const std::vector<int> owners = bsv::distributeBlocks(shares, count);
    for (int number = 0; number < count; ++number)
    {
      const std::string place = what + ", piece " + std::to_string(number) + " of " + std::to_string(count);
      algorithm->UpdatePiece(number, count, 0);
      const Output piece = outputOf(algorithm);
      ASSERT_EQ(piece.common, whole.common) << place;
      ASSERT_EQ(piece.blocks.size(), whole.blocks.size()) << place;
      for (std::size_t b = 0; b < owners.size(); ++b)
      {
        // No message of the bytes.
        EXPECT_TRUE(piece.blocks[b] == (owners[b] == number ? whole.blocks[b] : "")) << place << ", block " << b;
      }
    }
  }
}

/// The one error of a piece, with an empty output.
std::string refusalOfPiece(vtkAlgorithm* algorithm, int number, int count)
{
  std::vector<std::string> errors;
  vtkNew<vtkCallbackCommand> observer;
  observer->SetCallback([](vtkObject*, unsigned long, void* list, void* text) {
    static_cast<std::vector<std::string>*>(list)->emplace_back(static_cast<const char*>(text));
  });
  observer->SetClientData(&errors);
  const unsigned long tag = algorithm->AddObserver(vtkCommand::ErrorEvent, observer);
  vtkNew<vtkCallbackCommand> silence;
  const unsigned long silent = algorithm->GetExecutive()->AddObserver(vtkCommand::ErrorEvent, silence);
  algorithm->UpdatePiece(number, count, 0);
  algorithm->RemoveObserver(tag);
  algorithm->GetExecutive()->RemoveObserver(silent);
  EXPECT_EQ(errors.size(), 1u);
  auto* output = vtkPartitionedDataSetCollection::SafeDownCast(algorithm->GetOutputDataObject(0));
  EXPECT_EQ(output->GetNumberOfPartitionedDataSets(), 0u);
  return errors.empty() ? "" : errors[0];
}

/// Blocks of different sizes, with partial contacts, in random orientations, all contacts and boundaries declared.
MeshCase blockCase(unsigned seed)
{
  MeshCase mesh = meshcases::latticeBlocks({ { { 0, 0, 0 }, { 2, 4, 3 } }, { { 2, 0, 0 }, { 5, 2, 3 } },
                                             { { 2, 2, 0 }, { 4, 4, 3 } }, { { 0, 0, 3 }, { 3, 2, 4 } } },
    meshcases::wavy);
  mesh.boundaryNames = { "wall" };
  meshcases::shuffle(mesh, seed, true);
  meshcases::declareAll(mesh, seed);
  return mesh;
}

/// Four blocks of different sizes.
bsvtest::Volumes volumeCase()
{
  std::mt19937 random(5);
  return bsvtest::cutLattice(random, { { { 2, 5 }, { 3 }, { 1, 4 } } });
}

bsv::QuadflowCase quadflowCase(const bsvtest::Volumes& volumes)
{
  bsv::QuadflowInput input;
  for (const bsvtest::Block& block : volumes.blocks)
  {
    input.volumes.push_back(block.view());
    input.names.push_back("block " + std::to_string(input.names.size()));
  }
  input.hasInterfaces = true;
  input.interfaces = volumes.interfaces;
  return bsv::makeQuadflowCase(input);
}

/// The volumes as a GoTools file.
std::string g2(const bsvtest::Volumes& volumes)
{
  std::ostringstream text;
  text.precision(17);
  for (const bsvtest::Block& block : volumes.blocks)
  {
    text << "700 1 0 0\n3 0\n";
    for (int d = 0; d < 3; ++d)
    {
      text << block.volume.count(d) << " " << block.volume.degree[d] + 1 << "\n";
      for (const double knot : block.volume.knots[d])
      {
        text << knot << " ";
      }
      text << "\n";
    }
    for (std::size_t i = 0; i < block.points.size(); ++i)
    {
      text << block.points[i] << (i % 3 == 2 ? "\n" : " ");
    }
  }
  return text.str();
}

/// Bytes that this process has read from files so far, or -1 if the system does not say.
Index bytesRead()
{
  std::ifstream io("/proc/self/io");
  std::string word;
  Index bytes = -1;
  io >> word >> bytes;
  return io && word == "rchar:" ? bytes : -1;
}

/// Eight blocks that are large against what is read of each to find its place.
MeshCase largeCase()
{
  std::vector<std::pair<Ijk, Ijk>> boxes;
  for (int b = 0; b < 8; ++b)
  {
    boxes.push_back({ { 24 * b, 0, 0 }, { 24 * b + 24, 24, 24 } });
  }
  return meshcases::latticeBlocks(boxes, [](const bsv::Vec3& x) -> bsv::Vec3 { return 0.1 * x; });
}

} // namespace

TEST(Pieces, Plot3D)
{
  TemporaryFolder folder;
  unsigned seed = 0;
  for (const Plot3DKind& kind : allPlot3DKinds())
  {
    if (kind.multiBlock)
    {
      const MeshCase mesh = blockCase(seed);
      const std::string name = folder / ("mesh" + std::to_string(seed++));
      writeFile(name + ".xyz", plot3D(mesh, kind));
      writeFile(name + ".nmf", neutralMap(mesh));
      vtkNew<vtkHexBlockMeshReader> reader;
      reader->SetFileName((name + ".xyz").c_str());
      expectPieces(reader, kind.name());
    }
  }
}

// Repeats that run from one coordinate, and from one block, into the next.
TEST(Pieces, Plot3DTextWithRepeats)
{
  TemporaryFolder folder;
  // x y z of three blocks of 2 x 2 x 2 points: 72 values.
  writeFile(folder / "mesh.xyz", "3\n 9*2\n 4*0. 10*1.,  22*2.5 2*7\n 14*-1. 20*3d0\n");
  vtkNew<vtkHexBlockMeshReader> reader;
  reader->SetFileName((folder / "mesh.xyz").c_str());
  expectPieces(reader, "repeats");
}

TEST(Pieces, CGNS)
{
  TemporaryFolder folder;
  for (const int type : { CG_FILE_ADF, CG_FILE_HDF5 })
  {
    CGNSKind kind;
    kind.fileType = type;
    const std::string file = folder / ("mesh" + std::to_string(type) + ".cgns");
    writeCGNS(blockCase(7), file, kind);
    vtkNew<vtkHexBlockMeshReader> reader;
    reader->SetFileName(file.c_str());
    expectPieces(reader, "CGNS " + std::to_string(type));
  }
}

TEST(Pieces, Quadflow)
{
  TemporaryFolder folder;
  const bsvtest::Volumes volumes = volumeCase();
  for (int kind = 0; kind < 4; ++kind)
  {
    bsv::QuadflowOptions options;
    options.binary = kind % 2 == 1;
    options.separateGeometry = kind / 2 == 1;
    const std::string file = folder / ("volume" + std::to_string(kind) + ".qfmb");
    bsv::writeQuadflow(quadflowCase(volumes), file, options);
    vtkNew<vtkQuadflowReader> reader;
    reader->SetFileName(file.c_str());
    expectPieces(reader, "kind " + std::to_string(kind));
  }
}

TEST(Pieces, GoTools)
{
  TemporaryFolder folder;
  writeFile(folder / "volume.g2", g2(volumeCase()));
  vtkNew<vtkBSplineVolumeReader> reader;
  reader->SetFileName((folder / "volume.g2").c_str());
  expectPieces(reader, "g2");
}

TEST(Pieces, WingFuselage)
{
  vtkNew<vtkWingFuselageSource> source;
  source->SetResolution(2);
  expectPieces(source, "wing and fuselage");

  // The second output is whole in every piece; who asks for it gets that piece of the mesh.
  vtkNew<vtkWingFuselageSource> other;
  other->SetResolution(2);
  vtkNew<vtkInformationVector> requests;
  requests->SetNumberOfInformationObjects(2);
  vtkInformation* request = requests->GetInformationObject(1);
  request->Set(vtkStreamingDemandDrivenPipeline::UPDATE_PIECE_NUMBER(), 1);
  request->Set(vtkStreamingDemandDrivenPipeline::UPDATE_NUMBER_OF_PIECES(), 3);
  request->Set(vtkStreamingDemandDrivenPipeline::UPDATE_NUMBER_OF_GHOST_LEVELS(), 0);
  other->Update(1, requests);
  source->UpdatePiece(1, 3, 0);
  EXPECT_TRUE(outputOf(other).blocks == outputOf(source).blocks);
  auto* body = vtkPartitionedDataSetCollection::SafeDownCast(other->GetOutputDataObject(1));
  auto* whole = vtkPartitionedDataSetCollection::SafeDownCast(source->GetOutputDataObject(1));
  EXPECT_EQ(body->GetNumberOfPoints(), whole->GetNumberOfPoints());
  EXPECT_GT(body->GetNumberOfPoints(), 0);
}

TEST(Pieces, OfBinaryFilesOnlyTheirPartIsRead)
{
  if (bytesRead() < 0)
  {
    GTEST_SKIP() << "the system does not count the bytes";
  }
  TemporaryFolder folder;
  const MeshCase mesh = largeCase();
  std::vector<std::pair<std::string, vtkSmartPointer<vtkAlgorithm>>> readers;
  const auto add = [&](const std::string& name) {
    vtkNew<vtkHexBlockMeshReader> reader;
    reader->SetFileName((folder / name).c_str());
    readers.emplace_back(folder / name, reader);
  };
  for (const int marker : { 0, 4 })
  {
    Plot3DKind kind;
    kind.marker = marker;
    writeFile(folder / ("mesh" + std::to_string(marker) + ".xyz"), plot3D(mesh, kind));
    add("mesh" + std::to_string(marker) + ".xyz");
  }
  for (const int type : { CG_FILE_ADF, CG_FILE_HDF5 })
  {
    CGNSKind kind;
    kind.fileType = type;
    const std::string name = "mesh" + std::to_string(type) + ".cgns";
    writeCGNS(mesh, folder / name, kind);
    add(name);
  }
  std::mt19937 random(1);
  bsv::QuadflowOptions binary;
  binary.binary = true;
  const bsvtest::Volumes volumes = bsvtest::cutLattice(random, { { std::vector<int>(8, 22), { 22 }, { 22 } } });
  bsv::writeQuadflow(quadflowCase(volumes), folder / "volume.qfmb", binary);
  vtkNew<vtkQuadflowReader> quadflow;
  quadflow->SetFileName((folder / "volume.qfmb").c_str());
  readers.emplace_back(folder / "volume.qfmb", quadflow);

  // The program that reads CGNS files is read, too, with its libraries.
  writeCGNS(meshcases::cutBox({ 1, 1, 1 }), folder / "small.cgns");
  vtkNew<vtkHexBlockMeshReader> small;
  small->SetFileName((folder / "small.cgns").c_str());
  const Index start = bytesRead();
  small->Update();
  const Index program = bytesRead() - start;

  for (const auto& entry : readers)
  {
    const double size = static_cast<double>(std::filesystem::file_size(entry.first));
    const bool apart = entry.first.find(".cgns") != std::string::npos;
    for (const int count : { 1, 2, 4 })
    {
      const Index before = bytesRead();
      entry.second->UpdatePiece(count - 1, count, 0);
      const double share = static_cast<double>(bytesRead() - before - (apart ? program : 0)) / size;
      // Headers, and what is read ahead of each of the eight blocks; the tree of a CGNS file is read twice, for its
      // time steps and for its blocks.
      EXPECT_LT(share, 1.0 / count + (apart ? 0.25 : 0.15)) << entry.first;
    }
  }
}

TEST(Pieces, WhatIsMissingElsewhereIsMissingHere)
{
  TemporaryFolder folder;
  const MeshCase mesh = blockCase(1);
  const bsvtest::Volumes volumes = volumeCase();
  bsv::QuadflowOptions binary;
  binary.binary = true;
  bsv::writeQuadflow(quadflowCase(volumes), folder / "text.qfmb");
  bsv::writeQuadflow(quadflowCase(volumes), folder / "binary.qfmb", binary);
  CGNSKind hdf5;
  hdf5.fileType = CG_FILE_HDF5;
  writeCGNS(mesh, folder / "mesh.cgns", hdf5);
  Plot3DKind ascii, raw;
  ascii.ascii = true;
  raw.marker = 0;
  writeFile(folder / "ascii.xyz", plot3D(mesh, ascii));
  writeFile(folder / "raw.xyz", plot3D(mesh, raw));
  writeFile(folder / "fortran.xyz", plot3D(mesh, {}));
  writeFile(folder / "volumes.g2", g2(volumes));
  for (const std::string name :
    { "text.qfmb", "binary.qfmb", "mesh.cgns", "ascii.xyz", "raw.xyz", "fortran.xyz", "volumes.g2" })
  {
    const std::string whole = readFile(folder / name);
    writeFile(folder / name, whole.substr(0, whole.size() - 100));
    vtkNew<vtkHexBlockMeshReader> meshes;
    meshes->SetFileName((folder / name).c_str());
    vtkNew<vtkQuadflowReader> quadflow;
    quadflow->SetFileName((folder / name).c_str());
    vtkNew<vtkBSplineVolumeReader> spline;
    spline->SetFileName((folder / name).c_str());
    vtkAlgorithm* reader = name.find("qfmb") != std::string::npos ? static_cast<vtkAlgorithm*>(quadflow)
      : name.find("g2") != std::string::npos                      ? static_cast<vtkAlgorithm*>(spline)
                                                                  : meshes;
    const std::string error = refusalOfPiece(reader, 0, 1);
    EXPECT_NE(error.find(name), std::string::npos) << error;
    for (const int number : { 0, 2 })
    {
      const std::string ofPiece = refusalOfPiece(reader, number, 3);
      EXPECT_NE(ofPiece.find(name), std::string::npos) << ofPiece;
      // What is left out of a text is not looked at so closely.
      EXPECT_TRUE(ofPiece == error || name == "text.qfmb") << ofPiece << error;
    }
  }
}

// Every rank is told of the first contact that is wrong, whoever has its blocks.
TEST(Pieces, RanksCheckContactsTogether)
{
  TemporaryFolder folder;
  for (const unsigned seed : { 1u, 2u, 3u })
  {
    const MeshCase mesh = blockCase(seed);
    ASSERT_GE(mesh.interfaces.size(), 4u);
    const std::string map = folder / "mesh.nmf";
    writeFile(map, neutralMap(mesh));
    // The number of contacts that are torn open, from the last; 0: all are right.
    for (const int torn : { 0, 1, 2 })
    {
      std::vector<std::vector<double>> points;
      for (const MeshCase::Block& block : mesh.blocks)
      {
        points.emplace_back();
        for (const bsv::Vec3& x : block.points)
        {
          points.back().insert(points.back().end(), x.data(), x.data() + 3);
        }
      }
      for (int n = 0; n < torn; ++n)
      {
        const bsv::Interface& c = mesh.interfaces[mesh.interfaces.size() - 1 - n];
        const Ijk& counts = mesh.blocks[c.blockB].counts;
        const Ijk at =
          bsv::facePoint({ counts[0] - 1, counts[1] - 1, counts[2] - 1 }, c.faceB, c.originB[0], c.originB[1]);
        points[c.blockB][3 * (at[0] + Index(counts[0]) * (at[1] + Index(counts[1]) * at[2])) + 1] += 0.5;
      }
      const auto readOn = [&](const Execution& run, const std::vector<int>& owners) {
        bsv::BlockMesh here;
        for (std::size_t b = 0; b < points.size(); ++b)
        {
          bsv::MeshBlock block;
          block.rank = owners[b];
          block.points = owners[b] == run.ranks->rank() ? bsv::GridView(points[b].data(), mesh.blocks[b].counts)
                                                        : bsv::GridView::elsewhere(mesh.blocks[b].counts);
          block.name = "block " + std::to_string(b + 1);
          here.blocks.push_back(block);
        }
        std::vector<std::string> warnings;
        bsv::readNeutralMap(map, here, warnings, run);
        return here.interfaces.size();
      };
      const std::string serial =
        bsvtest::onRanks(1, [&](const Execution& run) { readOn(run, std::vector<int>(points.size(), 0)); })[0];
      EXPECT_EQ(serial.empty(), torn == 0);
      for (const int ranks : { 2, 3, 5 })
      {
        std::vector<int> owners;
        for (std::size_t b = 0; b < points.size(); ++b)
        {
          owners.push_back(static_cast<int>(b * 7 + seed) % ranks);
        }
        const auto errors = bsvtest::onRanks(
          ranks, [&](const Execution& run) { EXPECT_EQ(readOn(run, owners), mesh.interfaces.size()); });
        for (const std::string& error : errors)
        {
          EXPECT_EQ(error, serial);
        }
      }
    }
  }
}

TEST(Pieces, RanksReadOneVolumeTogether)
{
  TemporaryFolder folder;
  const bsvtest::Volumes volumes = volumeCase();
  const std::string file = folder / "volume.qfmb";
  bsv::writeQuadflow(quadflowCase(volumes), file);
  const auto readOn = [&](const Execution& run) {
    Index points = 0;
    std::vector<std::vector<double>> memory;
    const bsv::QuadflowStorage storage = [&](int, const std::array<int, 3>& counts) {
      points += Index(counts[0]) * counts[1] * counts[2];
      memory.emplace_back(3 * static_cast<std::size_t>(counts[0]) * counts[1] * counts[2]);
      return memory.back().data();
    };
    bsv::readQuadflow(file, storage, run, { run.ranks->rank(), run.ranks->size() });
    return points;
  };
  Index whole = 0;
  for (const bsvtest::Block& block : volumes.blocks)
  {
    whole += static_cast<Index>(block.points.size()) / 3;
  }
  for (const int ranks : { 1, 2, 3, 5 })
  {
    const auto errors = bsvtest::onRanks(ranks, [&](const Execution& run) {
      Index sum = 0;
      for (const Index count : run.ranks->gatherAll(std::vector<Index>{ readOn(run) }))
      {
        sum += count;
      }
      EXPECT_EQ(sum, whole);
    });
    EXPECT_EQ(errors, std::vector<std::string>(ranks)) << ranks;
  }

  // A number in the last block that is none: only its rank looks at it, all refuse the file.
  std::string text = readFile(file);
  const std::size_t end = text.rfind("\nend");
  text.replace(end - 3, 3, "x.y");
  writeFile(file, text);
  const std::string serial = bsvtest::onRanks(1, [&](const Execution& run) { readOn(run); })[0];
  EXPECT_NE(serial.find("volume.qfmb, line"), std::string::npos) << serial;
  for (const int ranks : { 2, 3, 5 })
  {
    EXPECT_EQ(
      bsvtest::onRanks(ranks, [&](const Execution& run) { readOn(run); }), std::vector<std::string>(ranks, serial));
  }

  // Two sides of an interface that differ: every split of the blocks finds them.
  for (const bsv::Interface& contact : volumes.interfaces)
  {
    bsv::QuadflowCase torn = quadflowCase(volumes);
    const bsvtest::Block& block = volumes.blocks[contact.blockA];
    std::vector<double> points = block.points;
    points[3 * block.at(bsvtest::facePosition(block.counts(), contact.faceA, 1, 1)) + 2] += 1.0;
    torn.blocks[contact.blockA].volume.points = points.data();
    bsv::writeQuadflow(torn, file);
    const std::string difference = bsvtest::onRanks(1, [&](const Execution& run) { readOn(run); })[0];
    EXPECT_NE(difference.find("differ"), std::string::npos) << difference;
    for (const int ranks : { 2, 3, 5 })
    {
      EXPECT_EQ(bsvtest::onRanks(ranks, [&](const Execution& run) { readOn(run); }),
        std::vector<std::string>(ranks, difference));
    }
  }
}
