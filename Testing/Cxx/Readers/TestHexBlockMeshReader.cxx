// SPDX-License-Identifier: BSD-3-Clause
// Meshes are written in every form that the reader knows, by writers of this test's own, and must come back unchanged.
#include "Support/MeshFiles.h"

#include "Data/HexBlockData.h"

#include <vtkCommand.h>
#include <vtkDataAssembly.h>
#include <vtkErrorCode.h>
#include <vtkInformation.h>
#include <vtkIntArray.h>
#include <vtkPointData.h>
#include <vtkStructuredGrid.h>

using namespace meshfiles;
using bsv::BlockMesh;
using bsv::Interface;
using bsv::Vec3;

namespace
{

/// Blocks of different sizes, with partial contacts, in random orientations, all contacts and boundaries declared.
MeshCase shuffledCase(unsigned seed)
{
  MeshCase mesh = meshcases::latticeBlocks({ { { 0, 0, 0 }, { 2, 4, 3 } }, { { 2, 0, 0 }, { 5, 2, 3 } },
                                             { { 2, 2, 0 }, { 4, 4, 3 } }, { { 0, 0, 3 }, { 3, 2, 4 } } },
    meshcases::wavy);
  mesh.boundaryNames = { "wall", "far field" };
  meshcases::shuffle(mesh, seed, true);
  meshcases::declareAll(mesh, seed);
  for (std::size_t i = 0; i < mesh.boundaries.size(); ++i)
  {
    mesh.boundaries[i].tag = static_cast<int>(i % 2);
  }
  mesh.boundaryNames = { "wall", "far field" };
  return mesh;
}

/// The core's view of what was read, with the grids that hold it.
struct ReadMesh
{
  std::vector<vtkSmartPointer<vtkStructuredGrid>> grids;
  BlockMesh mesh;
};

ReadMesh readMesh(Reading& reading)
{
  EXPECT_TRUE(reading.errors.empty()) << reading.errors[0];
  ReadMesh result;
  result.mesh = bsv::structuredBlocks(reading.output, result.grids);
  return result;
}

void expectSamePoints(const MeshCase& expected, const BlockMesh& found, bool isFloat, const std::string& what)
{
  ASSERT_EQ(found.blocks.size(), expected.blocks.size()) << what;
  for (std::size_t b = 0; b < found.blocks.size(); ++b)
  {
    const MeshCase::Block& block = expected.blocks[b];
    const bsv::GridView& points = found.blocks[b].points;
    ASSERT_EQ(points.counts(), block.counts) << what;
    ASSERT_EQ(points.isFloat(), isFloat) << what;
    for (int k = 0; k < block.counts[2]; ++k)
    {
      for (int j = 0; j < block.counts[1]; ++j)
      {
        for (int i = 0; i < block.counts[0]; ++i)
        {
          const Vec3 x = points(i, j, k);
          for (int d = 0; d < 3; ++d)
          {
            const double wanted = block.at({ i, j, k })[d];
            ASSERT_EQ(x[d], isFloat ? double(float(wanted)) : wanted)
              << what << ", block " << b << ", point " << i << " " << j << " " << k;
          }
        }
      }
    }
  }
}

/// Everything about a contact, from the side that sorts first.
std::vector<int> contactKey(const Interface& c)
{
  Interface r;
  r.blockA = c.blockB;
  r.faceA = c.faceB;
  r.blockB = c.blockA;
  r.faceB = c.faceA;
  r.rangeA = c.rangeB();
  r.originB = c.rangeA.lo;
  r.orientation = bsv::inverseOrientation(c.orientation);
  const auto key = [](const Interface& i) {
    return std::vector<int>{ i.blockA, i.faceA, i.rangeA.lo[0], i.rangeA.lo[1], i.rangeA.hi[0], i.rangeA.hi[1],
      i.blockB, i.faceB, i.originB[0], i.originB[1], i.orientation };
  };
  return std::min(key(c), key(r));
}

std::vector<std::vector<int>> contactKeys(const std::vector<Interface>& contacts)
{
  std::vector<std::vector<int>> keys;
  for (const Interface& contact : contacts)
  {
    keys.push_back(contactKey(contact));
  }
  std::sort(keys.begin(), keys.end());
  return keys;
}

/// The named quadrilaterals: (block, face, s, t, name).
template <typename Mesh>
std::vector<std::tuple<int, int, int, int, std::string>> namedQuads(const Mesh& mesh)
{
  std::vector<std::tuple<int, int, int, int, std::string>> quads;
  for (const bsv::BoundaryPatch& patch : mesh.boundaries)
  {
    for (int t = patch.range.lo[1]; t < patch.range.hi[1]; ++t)
    {
      for (int s = patch.range.lo[0]; s < patch.range.hi[0]; ++s)
      {
        quads.emplace_back(patch.block, patch.face, s, t, mesh.boundaryNames[patch.tag]);
      }
    }
  }
  std::sort(quads.begin(), quads.end());
  return quads;
}

void expectSameConnectivity(const MeshCase& expected, const BlockMesh& found, const std::string& what)
{
  EXPECT_EQ(contactKeys(found.interfaces), contactKeys(expected.interfaces)) << what;
  EXPECT_EQ(namedQuads(found), namedQuads(expected)) << what;
}

} // namespace

TEST(HexBlockMeshReader, FindsEveryPlot3DLayout)
{
  TemporaryFolder folder;
  const MeshCase multi = shuffledCase(1);
  MeshCase single = multi;
  single.blocks.resize(1);
  for (const Plot3DKind& kind : allPlot3DKinds())
  {
    const MeshCase& mesh = kind.multiBlock ? multi : single;
    const std::string file = folder / "mesh.x";
    writeFile(file, plot3D(mesh, kind));
    Reading reading;
    read(reading, file);
    const ReadMesh found = readMesh(reading);
    expectSamePoints(mesh, found.mesh, kind.isFloat, kind.name());
    EXPECT_EQ(reading.reader->GetFileLayout(), "PLOT3D, " + kind.name());
    EXPECT_EQ(vtkHexBlockMeshReader::CanReadFile(file.c_str()), 1) << kind.name();
    for (const auto& grid : found.grids)
    {
      auto* iblank = vtkIntArray::SafeDownCast(grid->GetPointData()->GetArray("IBlank"));
      ASSERT_EQ(iblank != nullptr, kind.iblank) << kind.name();
      for (vtkIdType p = 0; iblank && p < iblank->GetNumberOfTuples(); ++p)
      {
        ASSERT_EQ(iblank->GetValue(p), iblankValue(p)) << kind.name();
      }
    }
  }
}

TEST(HexBlockMeshReader, RecordsCutInAnyWay)
{
  TemporaryFolder folder;
  const MeshCase mesh = meshcases::cutBox({ 5, 3, 2 }, { { { 3 }, {}, {} } }, meshcases::wavy);
  for (const Plot3DKind& kind : allPlot3DKinds())
  {
    if (kind.ascii || kind.marker == 0 || !kind.multiBlock)
    {
      continue;
    }
    SCOPED_TRACE(kind.name());
    Plot3DKind raw = kind;
    raw.marker = 0;
    const std::string content = plot3D(mesh, raw);
    // Lengths of records.
    const std::size_t real = kind.isFloat ? 4 : 8;
    std::vector<std::size_t> perCoordinate{ 4, 24 };
    std::vector<std::size_t> perBlock{ 4, 24 };
    std::vector<std::size_t> sizes{ 4, 12, 12 };
    for (const MeshCase::Block& block : mesh.blocks)
    {
      const std::size_t points = block.points.size();
      perCoordinate.insert(perCoordinate.end(), 3, real * points);
      perCoordinate.insert(perCoordinate.end(), kind.iblank ? 1 : 0, 4 * points);
      perBlock.push_back(points * (3 * real + (kind.iblank ? 4 : 0)));
      sizes.push_back(perBlock.back());
    }
    std::vector<std::size_t> oneHeader{ 28 };
    oneHeader.insert(oneHeader.end(), perBlock.begin() + 2, perBlock.end());
    // A record that is longer goes on in the next one.
    const auto write = [&](const std::vector<std::size_t>& lengths, std::size_t longest) {
      std::string file;
      std::size_t at = 0;
      for (const std::size_t length : lengths)
      {
        for (std::size_t done = 0; done < length; done += std::min(longest, length - done))
        {
          const std::size_t part = std::min(longest, length - done);
          const auto marker = [&](bool negative) {
            const auto value = static_cast<std::int64_t>(part) * (negative ? -1 : 1);
            kind.marker == 4 ? append(file, std::int32_t(value), kind.bigEndian) : append(file, value, kind.bigEndian);
          };
          marker(done + part < length);
          file += content.substr(at, part);
          at += part;
          marker(done > 0);
        }
      }
      EXPECT_EQ(at, content.size());
      writeFile(folder / "cut.x", file);
      Reading reading;
      read(reading, folder / "cut.x");
      ASSERT_TRUE(reading.errors.empty()) << reading.errors[0];
      EXPECT_NE(std::string(reading.reader->GetFileLayout()).find("in records of its own"), std::string::npos);
      expectSamePoints(mesh, readMesh(reading).mesh, kind.isFloat, kind.name());
    };
    constexpr std::size_t Any = 1 << 30;
    write(perCoordinate, Any);
    write(oneHeader, Any);
    write(sizes, Any);
    write(perBlock, 40);
  }
}

TEST(HexBlockMeshReader, LayoutGivenIsTheLayoutTaken)
{
  TemporaryFolder folder;
  const MeshCase mesh = shuffledCase(2);
  for (const Plot3DKind& kind : allPlot3DKinds())
  {
    if (!kind.multiBlock)
    {
      continue;
    }
    const std::string file = folder / "mesh.x";
    writeFile(file, plot3D(mesh, kind));
    Reading right;
    right.reader->SetFormat(kind.ascii ? 1 : 2 + kind.marker / 4);
    right.reader->SetByteOrder(kind.bigEndian ? 2 : 1);
    right.reader->SetPrecision(kind.isFloat ? 1 : 2);
    right.reader->SetIBlank(kind.iblank ? 2 : 1);
    read(right, file);
    expectSamePoints(mesh, readMesh(right).mesh, kind.isFloat, kind.name());

    // Anything else than what the file holds is refused.
    Reading otherIBlank;
    otherIBlank.reader->SetIBlank(kind.iblank ? 1 : 2);
    EXPECT_NE(refusal(otherIBlank, file).find("iblank"), std::string::npos) << kind.name();
    Reading otherFormat;
    otherFormat.reader->SetFormat(kind.ascii ? 2 : 1);
    refusal(otherFormat, file);
    if (!kind.ascii)
    {
      Reading otherOrder;
      otherOrder.reader->SetByteOrder(kind.bigEndian ? 1 : 2);
      refusal(otherOrder, file);
      Reading otherPrecision;
      otherPrecision.reader->SetPrecision(kind.isFloat ? 2 : 1);
      refusal(otherPrecision, file);
    }
  }
}

TEST(HexBlockMeshReader, ReadsFortranListDirectedText)
{
  TemporaryFolder folder;
  writeFile(folder / "mesh.fmt",
    "1\r\n 3*2\r\n"
    "2*0., 2*1.D0 ,+0 -0\t1 ,1\n"             // x
    "0,0.0e+0,1.5d-1,1.5Q-01,2*.0,2*+.15\n\n" // y
    "4*1-3, 4*2.5-100\n");                    // z: exponents without a letter
  Reading reading;
  read(reading, folder / "mesh.fmt");
  const ReadMesh found = readMesh(reading);
  ASSERT_EQ(found.mesh.blocks.size(), 1u);
  const bsv::GridView& points = found.mesh.blocks[0].points;
  EXPECT_EQ(points(0, 0, 0), Vec3(0, 0, 1e-3));
  EXPECT_EQ(points(1, 0, 0), Vec3(0, 0, 1e-3));
  EXPECT_EQ(points(0, 1, 0), Vec3(1, 0.15, 1e-3));
  EXPECT_EQ(points(1, 1, 1), Vec3(1, 0.15, 2.5e-100));
}

TEST(HexBlockMeshReader, NumbersOfAFixedWidthRunIntoEachOther)
{
  TemporaryFolder folder;
  MeshCase mesh = meshcases::cutBox({ 7, 3, 2 }, { { { 4 }, {}, {} } }, meshcases::wavy);
  for (MeshCase::Block& block : mesh.blocks)
  {
    for (Vec3& point : block.points)
    {
      point -= Vec3(3.5, 1.5, 100.0);
    }
  }
  for (const char* format : { "%15.8E", "%11.6f", "%24.16E" })
  {
    std::string joined;
    for (const bool blanks : { false, true })
    {
      std::string text = "2\n5 4 3\n4 4 3\n";
      int written = 0;
      for (const MeshCase::Block& block : mesh.blocks)
      {
        for (int axis = 0; axis < 3; ++axis)
        {
          for (const Vec3& point : block.points)
          {
            char number[40];
            std::snprintf(number, sizeof(number), format, point[axis]);
            text += std::string(blanks ? " " : "") + number + (++written % 5 == 0 ? "\n" : "");
          }
        }
      }
      writeFile(folder / (blanks ? "apart.xyz" : "joined.xyz"), text);
      joined = blanks ? joined : text;
    }
    ASSERT_NE(joined.find_first_of('-', joined.find_first_of('-') + 1), std::string::npos);
    Reading apart;
    read(apart, folder / "apart.xyz");
    Reading together;
    read(together, folder / "joined.xyz");
    ASSERT_TRUE(together.errors.empty()) << together.errors[0];
    const ReadMesh a = readMesh(apart);
    const ReadMesh b = readMesh(together);
    for (int block = 0; block < 2; ++block)
    {
      for (bsv::Index p = 0; p < a.mesh.blocks[block].points.size(); ++p)
      {
        ASSERT_EQ(a.mesh.blocks[block].points.atPlace(p), b.mesh.blocks[block].points.atPlace(p)) << format;
      }
    }
  }
  // Exponents without a letter stay with their numbers.
  writeFile(folder / "exponents.xyz", "1 2 2 2\n1.5-100-2.5-.25+3.5D+2-1E-3+7 2*-.5-3\n 8*1 8*-1\n");
  Reading reading;
  read(reading, folder / "exponents.xyz");
  ASSERT_TRUE(reading.errors.empty()) << reading.errors[0];
  const ReadMesh found = readMesh(reading);
  const double expected[8] = { 1.5e-100, -2.5, -0.25, 350.0, -1e-3, 7.0, -0.5e-3, -0.5e-3 };
  for (bsv::Index p = 0; p < 8; ++p)
  {
    EXPECT_EQ(found.mesh.blocks[0].points.atPlace(p)[0], expected[p]) << p;
  }
}

TEST(HexBlockMeshReader, NeutralMapOfAnyOrientation)
{
  TemporaryFolder folder;
  std::array<bool, 8> seen{};
  for (unsigned seed = 0; seed < 30; ++seed)
  {
    const MeshCase mesh = shuffledCase(seed);
    for (const Interface& contact : mesh.interfaces)
    {
      seen[contact.orientation] = true;
    }
    writeFile(folder / "mesh.xyz", plot3D(mesh, {}));
    writeFile(folder / "mesh.nmf", neutralMap(mesh, seed % 2 == 1));
    Reading reading;
    read(reading, folder / "mesh.xyz");
    expectSameConnectivity(mesh, readMesh(reading).mesh, "seed " + std::to_string(seed));
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), true), 8);
}

TEST(HexBlockMeshReader, NeutralMapProperties)
{
  TemporaryFolder folder;
  const MeshCase mesh = shuffledCase(3);
  writeFile(folder / "mesh.xyz", plot3D(mesh, {}));
  writeFile(folder / "mesh.nmf", "rubbish");
  writeFile(folder / "other.nmf", neutralMap(mesh));

  EXPECT_NE(refusal(folder / "mesh.xyz").find("mesh.nmf, line 1"), std::string::npos);
  Reading other;
  other.reader->SetNeutralMapFile((folder / "other.nmf").c_str());
  read(other, folder / "mesh.xyz");
  EXPECT_EQ(readMesh(other).mesh.interfaces.size(), mesh.interfaces.size());
  Reading none;
  none.reader->UseNeutralMapOff();
  read(none, folder / "mesh.xyz");
  const ReadMesh plain = readMesh(none);
  EXPECT_TRUE(plain.mesh.interfaces.empty());
  EXPECT_TRUE(plain.mesh.boundaries.empty());
}

TEST(HexBlockMeshReader, CGNSOfAnyOrientation)
{
  TemporaryFolder folder;
  for (unsigned seed = 0; seed < 12; ++seed)
  {
    const MeshCase mesh = shuffledCase(seed);
    CGNSKind kind;
    kind.fileType = seed % 2 == 0 ? CG_FILE_ADF : CG_FILE_HDF5;
    kind.isFloat = seed % 4 >= 2;
    kind.points = static_cast<CGNSKind::Points>(seed % 3);
    const std::string file = folder / ("mesh" + std::to_string(seed) + ".cgns");
    writeCGNS(mesh, file, kind);
    Reading reading;
    read(reading, file);
    const ReadMesh found = readMesh(reading);
    const std::string what = "seed " + std::to_string(seed);
    expectSamePoints(mesh, found.mesh, kind.isFloat, what);
    expectSameConnectivity(mesh, found.mesh, what);
    EXPECT_EQ(found.mesh.blocks[1].name, "zone 2");
    EXPECT_EQ(vtkHexBlockMeshReader::CanReadFile(file.c_str()), 1);
  }
}

TEST(HexBlockMeshReader, CGNSPeriodicContactsAreBoundaries)
{
  TemporaryFolder folder;
  MeshCase mesh = meshcases::cutBox({ 3, 2, 2 });
  writeCGNS(mesh, folder / "mesh.cgns");
  int file = 0;
  int id = 0;
  require(cg_open((folder / "mesh.cgns").c_str(), CG_MODE_MODIFY, &file));
  const cgsize_t low[6] = { 1, 1, 1, 1, 3, 3 };
  const cgsize_t high[6] = { 4, 1, 1, 4, 3, 3 };
  const int transform[3] = { 1, 2, 3 };
  const float zero[3] = { 0, 0, 0 };
  const float period[3] = { 3, 0, 0 };
  require(cg_1to1_write(file, 1, 1, "periodic", "zone 1", low, high, transform, &id));
  require(cg_1to1_periodic_write(file, 1, 1, id, zero, zero, period));
  require(cg_close(file));

  Reading reading;
  read(reading, folder / "mesh.cgns");
  const ReadMesh found = readMesh(reading);
  EXPECT_TRUE(found.mesh.interfaces.empty());
  ASSERT_EQ(found.mesh.boundaries.size(), 1u);
  EXPECT_EQ(found.mesh.boundaries[0].face, 0);
  EXPECT_EQ(found.mesh.boundaryNames[0], "Periodic");
}

TEST(HexBlockMeshReader, CGNSConditionsWithoutFamilyKeepTheirNames)
{
  TemporaryFolder folder;
  writeCGNS(meshcases::cutBox({ 3, 2, 2 }), folder / "mesh.cgns");
  int file = 0;
  int id = 0;
  require(cg_open((folder / "mesh.cgns").c_str(), CG_MODE_MODIFY, &file));
  const cgsize_t low[6] = { 1, 1, 1, 1, 3, 3 };
  const cgsize_t high[6] = { 4, 1, 1, 4, 3, 3 };
  const cgsize_t line[6] = { 1, 1, 1, 4, 1, 1 };
  require(cg_boco_write(file, 1, 1, "a", CGNS_ENUMV(BCWallViscous), CGNS_ENUMV(PointRange), 2, low, &id));
  require(cg_boco_write(file, 1, 1, "mine", CGNS_ENUMV(BCTypeUserDefined), CGNS_ENUMV(PointRange), 2, high, &id));
  require(cg_boco_write(file, 1, 1, "line", CGNS_ENUMV(BCDegenerateLine), CGNS_ENUMV(PointRange), 2, line, &id));
  require(cg_close(file));

  Reading reading;
  read(reading, folder / "mesh.cgns");
  const ReadMesh found = readMesh(reading);
  EXPECT_EQ(found.mesh.boundaryNames, (std::vector<std::string>{ "a", "mine" }));
  EXPECT_EQ(found.mesh.boundaryTypes, (std::vector<std::string>{ "BCWallViscous", "BCTypeUserDefined" }));
  ASSERT_EQ(found.mesh.boundaries.size(), 2u);
  EXPECT_EQ(found.mesh.boundaries[1].face, 1);
}

TEST(HexBlockMeshReader, CGNSPointListOverSeveralFaces)
{
  // One list with all points of the faces i = 0 and j = 0, and an L-shaped part of face k = 0.
  TemporaryFolder folder;
  const MeshCase box = meshcases::cutBox({ 4, 3, 3 });
  writeCGNS(box, folder / "mesh.cgns");
  std::vector<cgsize_t> points;
  std::vector<std::array<int, 4>> expected;
  for (int a = 0; a < 3; ++a)
  {
    for (int b = 0; b < 3; ++b)
    {
      expected.push_back({ 0, 0, a, b });
    }
    for (int b = 0; b < 4; ++b)
    {
      expected.push_back({ 0, 2, b, a });
    }
  }
  for (const std::array<int, 2>& quad : std::vector<std::array<int, 2>>{ { 0, 0 }, { 1, 0 }, { 0, 1 } })
  {
    expected.push_back({ 0, 4, quad[0], quad[1] });
  }
  for (int k = 1; k <= 4; ++k)
  {
    for (int j = 1; j <= 4; ++j)
    {
      for (int i = 1; i <= 5; ++i)
      {
        const bool inL = (i <= 3 && j <= 2) || (i <= 2 && j <= 3);
        if (i == 1 || j == 1 || (k == 1 && inL))
        {
          points.insert(points.end(), { i, j, k });
        }
      }
    }
  }
  int file = 0;
  int id = 0;
  require(cg_open((folder / "mesh.cgns").c_str(), CG_MODE_MODIFY, &file));
  require(cg_boco_write(file, 1, 1, "wall", CGNS_ENUMV(BCWall), CGNS_ENUMV(PointList),
    static_cast<cgsize_t>(points.size() / 3), points.data(), &id));
  require(cg_close(file));

  Reading reading;
  read(reading, folder / "mesh.cgns");
  std::vector<std::array<int, 4>> found;
  for (const auto& [block, face, s, t, name] : namedQuads(readMesh(reading).mesh))
  {
    EXPECT_EQ(name, "wall");
    found.push_back({ block, face, s, t });
  }
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(found, expected);
}

TEST(HexBlockMeshReader, NamesBlocksInAssembly)
{
  TemporaryFolder folder;
  const MeshCase mesh = shuffledCase(4);
  writeFile(folder / "mesh.xyz", plot3D(mesh, {}));
  Reading reading;
  read(reading, folder / "mesh.xyz");
  vtkDataAssembly* assembly = reading.output->GetDataAssembly();
  ASSERT_NE(assembly, nullptr);
  const std::vector<int> nodes = assembly->GetChildNodes(assembly->GetRootNode());
  ASSERT_EQ(nodes.size(), mesh.blocks.size());
  for (unsigned int b = 0; b < nodes.size(); ++b)
  {
    const std::string name = "block " + std::to_string(b + 1);
    EXPECT_EQ(assembly->GetDataSetIndices(nodes[b]), std::vector<unsigned int>{ b });
    EXPECT_EQ(assembly->GetAttributeOrDefault(nodes[b], "label", ""), name);
    EXPECT_EQ(reading.output->GetMetaData(b)->Get(vtkCompositeDataSet::NAME()), name);
  }
}

TEST(HexBlockMeshReader, AbortLeavesNothingAndIsNoError)
{
  TemporaryFolder folder;
  const MeshCase mesh = meshcases::cutBox({ 30, 30, 30 });
  for (const bool ascii : { true, false })
  {
    writeFile(folder / "mesh.xyz", plot3D(mesh, { ascii }));
    Reading reading;
    vtkNew<vtkCallbackCommand> abort;
    abort->SetCallback(
      [](vtkObject* caller, unsigned long, void*, void*) { static_cast<vtkAlgorithm*>(caller)->SetAbortExecute(1); });
    reading.reader->AddObserver(vtkCommand::ProgressEvent, abort);
    read(reading, folder / "mesh.xyz");
    EXPECT_TRUE(reading.errors.empty());
    EXPECT_EQ(reading.output->GetNumberOfPartitionedDataSets(), 0u);
  }
}

TEST(HexBlockMeshReader, RefusesALongFileOfZerosAtOnce)
{
  TemporaryFolder folder;
  for (const char* name : { "zeros.xyz", "zeros.cgns" })
  {
    // An empty record in every 8 bytes.
    writeFile(folder / name, "");
    std::filesystem::resize_file(folder / name, std::uintmax_t(5) << 30);
    EXPECT_NE(refusal(folder / name).find("no PLOT3D layout explains the file"), std::string::npos);
  }
}

TEST(HexBlockMeshReader, ReadsAgainAfterAnError)
{
  TemporaryFolder folder;
  const MeshCase mesh = shuffledCase(5);
  writeFile(folder / "good.xyz", plot3D(mesh, {}));
  writeFile(folder / "bad.xyz", "?");
  Reading reading;
  refusal(reading, folder / "bad.xyz");
  EXPECT_STREQ(reading.reader->GetFileLayout(), "");
  reading.errors.clear();
  read(reading, folder / "good.xyz");
  expectSamePoints(mesh, readMesh(reading).mesh, false, "after an error");
  EXPECT_EQ(reading.reader->GetErrorCode(), static_cast<unsigned long>(vtkErrorCode::NoError));
}
