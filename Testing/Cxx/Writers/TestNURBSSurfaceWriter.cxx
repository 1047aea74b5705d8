// SPDX-License-Identifier: BSD-3-Clause
// Walls of volumes and bodies as STEP and IGES files: what OpenCASCADE and our own reader find in them is what was
// written.
#include "Data/BSplineVolumeData.h"
#include "Data/HexBlockData.h"
#include "Data/NURBSSurfaceData.h"
#include "Support/Files.h"
#include "Support/Messages.h"
#include "Support/VolumeCases.h"
#include "vtkNURBSSurfaceReader.h"
#include "vtkNURBSSurfaceWriter.h"
#include "vtkWingFuselageSource.h"

#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkNew.h>
#include <vtkPartitionedDataSetCollection.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkStructuredGrid.h>

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <random>

#ifdef BSPLINEVOLUME_WITH_OPENCASCADE
#include <BRep_Tool.hxx>
#include <Geom_Surface.hxx>
#include <IGESControl_Controller.hxx>
#include <IGESControl_Reader.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <STEPControl_Controller.hxx>
#include <STEPControl_Reader.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedDataMapOfShapeListOfShape.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#endif

using namespace bsv;
using bsvtest::Block;
using bsvtest::readFile;
using bsvtest::TemporaryFolder;

namespace
{

/// What a writer says.
struct Writing
{
  std::vector<std::string> errors;
  std::vector<std::string> warnings;
  int result = 0;
  vtkNew<vtkNURBSSurfaceWriter> writer;

  Writing(vtkDataObject* input, const std::string& fileName, int unit = 0)
  {
    const bsvtest::Messages messages(this->writer, this->errors, this->warnings);
    this->writer->SetInputDataObject(input);
    this->writer->SetFileName(fileName.c_str());
    this->writer->SetLengthUnit(unit);
    this->result = this->writer->Write();
  }
};

/// A volume with named outer faces, as data: face f of block b has the name name(b, f), or none.
vtkSmartPointer<vtkPartitionedDataSetCollection> volumeData(const std::vector<Block>& blocks,
  const std::function<std::string(int, int)>& name, const std::vector<Interface>* interfaces = nullptr)
{
  auto collection = vtkSmartPointer<vtkPartitionedDataSetCollection>::New();
  std::vector<std::string> names;
  std::vector<BoundaryPatch> boundaries;
  for (std::size_t b = 0; b < blocks.size(); ++b)
  {
    const BSplineVolume volume = blocks[b].view();
    vtkNew<vtkStructuredGrid> grid;
    grid->SetDimensions(volume.count(0), volume.count(1), volume.count(2));
    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    for (std::size_t i = 0; i < blocks[b].points.size(); i += 3)
    {
      points->InsertNextPoint(blocks[b].points.data() + i);
    }
    grid->SetPoints(points);
    if (!blocks[b].weights.empty())
    {
      vtkNew<vtkDoubleArray> weights;
      weights->SetName("Weights");
      for (const double weight : blocks[b].weights)
      {
        weights->InsertNextValue(weight);
      }
      grid->GetPointData()->AddArray(weights);
    }
    setDegreeAndKnots(grid, volume);
    collection->SetPartition(static_cast<unsigned>(b), 0, grid);
    for (int f = 0; f < 6; ++f)
    {
      const std::string own = name(static_cast<int>(b), f);
      if (own.empty())
      {
        continue;
      }
      const auto at = std::find(names.begin(), names.end(), own);
      BoundaryPatch patch;
      patch.block = static_cast<int>(b);
      patch.face = f;
      patch.range.hi = { volume.count(faceAxis(f, 0)) - 1, volume.count(faceAxis(f, 1)) - 1 };
      patch.tag = static_cast<int>(at - names.begin());
      if (at == names.end())
      {
        names.push_back(own);
      }
      boundaries.push_back(patch);
    }
  }
  setWholeFaceContacts(collection, interfaces ? *interfaces : std::vector<Interface>(), boundaries, names);
  if (!interfaces)
  {
    collection->GetFieldData()->RemoveArray("Interfaces");
  }
  return collection;
}

/// Six blocks around a cube, from its surface (k = 0) outwards; stored in random orientations. Control points and
/// weights are functions of the place in one lattice, the same bits in all blocks that share it.
struct Shell
{
  std::vector<Block> blocks;
  /// The face of each block on the cube, and the one far from it.
  std::vector<int> wall;
  std::vector<int> far;

  Shell(std::mt19937& random, bool rational)
  {
    const int cells = 3;
    const int n = cells + 2; // steps between control points
    const std::vector<bsvtest::Orientation> orientations = bsvtest::allOrientations();
    for (int side = 0; side < 6; ++side)
    {
      Block plain;
      plain.volume.knots = { clampedIntegerKnots(cells), clampedIntegerKnots(cells), clampedIntegerKnots(2) };
      bsvtest::forEach(plain.counts(), [&](const Ijk& i) {
        const int d = side / 2;
        Ijk place{};
        place[d] = side % 2 ? n : -n;
        place[(d + 1) % 3] = 2 * i[0] - n;
        place[(d + 2) % 3] = 2 * i[1] - n;
        for (int c = 0; c < 3; ++c)
        {
          const double wave = std::sin(1.7 * place[c] + 0.9 * place[(c + 1) % 3] * place[(c + 2) % 3] + 0.3 * c);
          plain.points.push_back((1.0 + 0.5 * i[2]) * (place[c] + 0.2 * wave));
        }
        if (rational)
        {
          plain.weights.push_back(1.0 + 0.4 * std::sin(place[0] + 2.0 * place[1] + 3.0 * place[2] + 0.7 * i[2]));
        }
      });
      const bsvtest::Orientation o = orientations[std::uniform_int_distribution<std::size_t>(0, 47)(random)];
      this->blocks.push_back(bsvtest::reoriented(plain, o));
      const int across = static_cast<int>(std::find(o.order.begin(), o.order.end(), 2) - o.order.begin());
      this->wall.push_back(2 * across + (o.flip[across] ? 1 : 0));
      this->far.push_back(2 * across + (o.flip[across] ? 0 : 1));
    }
  }

  std::string name(int block, int face) const
  {
    return face == this->wall[block] ? "wall" : face == this->far[block] ? "far" : "";
  }
};

#ifdef BSPLINEVOLUME_WITH_OPENCASCADE

/// A file as OpenCASCADE reads it, numbers as they are.
TopoDS_Shape shapeOf(const std::string& fileName)
{
  Message::DefaultMessenger()->ChangePrinters().Clear();
  TopoDS_Shape shape;
  if (fileName.find(".igs") != std::string::npos)
  {
    IGESControl_Controller::Init();
    IGESControl_Reader reader;
    EXPECT_EQ(reader.ReadFile(fileName.c_str()), IFSelect_RetDone);
    reader.TransferRoots();
    shape = reader.OneShape();
  }
  else
  {
    STEPControl_Controller::Init();
    STEPControl_Reader reader;
    EXPECT_EQ(reader.ReadFile(fileName.c_str()), IFSelect_RetDone);
    reader.TransferRoots();
    shape = reader.OneShape();
  }
  return shape;
}

struct Counts
{
  int shells, faces, edges, vertices, freeEdges;
  bool operator==(const Counts& o) const
  {
    return std::tie(shells, faces, edges, vertices, freeEdges) ==
      std::tie(o.shells, o.faces, o.edges, o.vertices, o.freeEdges);
  }
};

std::ostream& operator<<(std::ostream& stream, const Counts& c)
{
  return stream << c.shells << " shells, " << c.faces << " faces, " << c.edges << " edges, " << c.vertices
                << " vertices, " << c.freeEdges << " free edges";
}

/// An edge is free if it is there once: a seam is twice in the same face.
Counts countsOf(const TopoDS_Shape& shape)
{
  const auto count = [&](TopAbs_ShapeEnum kind) {
    TopTools_IndexedMapOfShape map;
    TopExp::MapShapes(shape, kind, map);
    return map.Extent();
  };
  std::map<int, int> uses;
  TopTools_IndexedMapOfShape edges;
  TopTools_IndexedMapOfShape faces;
  TopExp::MapShapes(shape, TopAbs_EDGE, edges);
  TopExp::MapShapes(shape, TopAbs_FACE, faces);
  int degenerate = 0;
  for (int f = 1; f <= faces.Extent(); ++f)
  {
    for (TopExp_Explorer at(faces(f), TopAbs_EDGE); at.More(); at.Next())
    {
      ++uses[edges.FindIndex(at.Current())];
    }
  }
  int freeEdges = 0;
  for (const auto& [edge, times] : uses)
  {
    const bool collapsed = BRep_Tool::Degenerated(TopoDS::Edge(edges(edge)));
    degenerate += collapsed;
    freeEdges += times == 1 && !collapsed;
  }
  return { count(TopAbs_SHELL), faces.Extent(), edges.Extent() - degenerate, count(TopAbs_VERTEX), freeEdges };
}

std::vector<BodyPatch> patchesOf(const std::string& fileName, std::string* unit = nullptr)
{
  vtkNew<vtkNURBSSurfaceReader> reader;
  reader->SetFileName(fileName.c_str());
  reader->Update();
  EXPECT_EQ(reader->GetErrorCode(), 0u);
  EXPECT_EQ(reader->GetNumberOfTrimmedPatches(), 0);
  if (unit)
  {
    *unit = reader->GetDeclaredUnit();
  }
  return bodyPatches(reader->GetOutputDataObject(0));
}

#endif

} // namespace

TEST(NURBSSurfaceWriter, ChoosesTheWall)
{
  const TemporaryFolder folder;
  std::mt19937 random(1);
  const Shell shell(random, false);
  const auto data = volumeData(shell.blocks, [&](int b, int f) { return shell.name(b, f); });
  Writing good(data, folder / "a.g2");
  EXPECT_EQ(good.result, 1);
  EXPECT_TRUE(good.errors.empty());
  const std::string text = readFile(folder / "a.g2");
  std::size_t surfaces = 0;
  for (std::size_t at = text.find("200 1 0 0"); at != std::string::npos; at = text.find("200 1 0 0", at + 1))
  {
    ++surfaces;
  }
  EXPECT_EQ(surfaces, 6u);

  const auto none = volumeData(shell.blocks, [&](int b, int f) { return shell.name(b, f) == "wall" ? "skin" : ""; });
  Writing bad(none, folder / "b.g2");
  ASSERT_EQ(bad.errors.size(), 1u);
  EXPECT_NE(bad.errors[0].find("'skin'"), std::string::npos) << bad.errors[0];
  EXPECT_FALSE(std::filesystem::exists(folder / "b.g2"));

  Writing extension(data, folder / "a.obj");
  ASSERT_EQ(extension.errors.size(), 1u);
  EXPECT_NE(extension.errors[0].find("extension must be"), std::string::npos);
}

#ifndef BSPLINEVOLUME_WITH_OPENCASCADE

TEST(NURBSSurfaceWriter, CADFilesNeedOpenCASCADE)
{
  const TemporaryFolder folder;
  std::mt19937 random(1);
  const Shell shell(random, false);
  const auto data = volumeData(shell.blocks, [&](int b, int f) { return shell.name(b, f); });
  Writing refused(data, folder / "a.step");
  ASSERT_EQ(refused.errors.size(), 1u);
  EXPECT_NE(refused.errors[0].find("OpenCASCADE"), std::string::npos);
}

#else

TEST(NURBSSurfaceWriter, ClosedWallOfAVolume)
{
  // All orientations of blocks: sewn is the same closed surface, and evaluation gives the points of the volume.
  const TemporaryFolder folder;
  std::mt19937 random(7);
  for (int trial = 0; trial < 6; ++trial)
  {
    const bool rational = trial % 2 == 1;
    const Shell shell(random, rational);
    const auto data = volumeData(shell.blocks, [&](int b, int f) { return shell.name(b, f); });
    for (const char* name : { "a.step", "a.igs" })
    {
      Writing writing(data, folder / name);
      ASSERT_TRUE(writing.errors.empty()) << writing.errors[0];
      EXPECT_TRUE(writing.warnings.empty()) << writing.warnings[0];
      EXPECT_EQ(countsOf(shapeOf(folder / name)), (Counts{ 1, 6, 12, 8, 0 })) << name << " trial " << trial;

      const std::vector<BodyPatch> patches = patchesOf(folder / name);
      ASSERT_EQ(patches.size(), 6u);
      for (int b = 0; b < 6; ++b)
      {
        const BodyPatch& patch = patches[b];
        EXPECT_EQ(patch.name, "wall");
        EXPECT_EQ(patch.surface.rational(), rational);
        const BSplineVolume volume = shell.blocks[b].view();
        const int face = shell.wall[b];
        bool asStored = false;
        double largest = 0.0;
        for (const bool reversed : { false, true })
        {
          double deviation = 0.0;
          for (int n = 0; n < 50; ++n)
          {
            const double u = patch.surface.last(0) * ((7 * n) % 50 / 49.0);
            const double v = patch.surface.last(1) * (n / 49.0);
            Vec3 at;
            at[faceDirection(face)] =
              faceSide(face) ? volume.knots[faceDirection(face)].back() : volume.knots[faceDirection(face)].front();
            at[faceAxis(face, 0)] = reversed ? patch.surface.last(0) - u : u;
            at[faceAxis(face, 1)] = v;
            deviation = std::max(deviation, (evaluate(patch.surface, u, v).x - evaluate(volume, at)).norm());
          }
          asStored = asStored || deviation <= 1e-14 * 40.0;
          largest = std::max(largest, deviation);
        }
        EXPECT_TRUE(asStored) << name << " block " << b;
        // Outward of the cube.
        const SurfaceGeometry middle =
          surfaceGeometry(patch.surface, 0.5 * patch.surface.last(0), 0.5 * patch.surface.last(1), patch.reversed);
        EXPECT_GT(middle.normal.dot(middle.point), 0.0) << name << " block " << b;
      }
    }
  }
}

TEST(NURBSSurfaceWriter, BlockThatMeetsItself)
{
  // One block around the z axis, closed in u: the wall has a seam, and its two rims are free.
  const TemporaryFolder folder;
  Block block;
  block.volume.knots = { clampedIntegerKnots(5), clampedIntegerKnots(2), clampedIntegerKnots(2) };
  const int n = block.counts()[0] - 1;
  bsvtest::forEach(block.counts(), [&](const Ijk& i) {
    const double angle = 2.0 * M_PI * (i[0] % n) / n;
    block.points.insert(block.points.end(),
      { (1.0 + i[1]) * std::cos(angle), (1.0 + i[1]) * std::sin(angle), 0.5 * i[2] + 0.1 * std::cos(angle) });
  });
  const auto data = volumeData({ block }, [](int, int f) { return f == 2 ? "wall" : f >= 2 ? "other" : ""; });
  for (const char* name : { "a.step", "a.igs" })
  {
    Writing writing(data, folder / name);
    ASSERT_TRUE(writing.errors.empty()) << writing.errors[0];
    EXPECT_TRUE(writing.warnings.empty()) << writing.warnings[0];
    EXPECT_EQ(countsOf(shapeOf(folder / name)), (Counts{ 1, 1, 3, 2, 2 })) << name;
    const std::vector<BodyPatch> patches = patchesOf(folder / name);
    ASSERT_EQ(patches.size(), 1u);
    EXPECT_EQ(patches[0].surface.count(0), n + 1);
    EXPECT_TRUE(patches[0].loops.empty());
  }
}

TEST(NURBSSurfaceWriter, BothSidesOfAThinPlate)
{
  // Two layers of three blocks; between the middle ones is a plate without thickness. Its sides have the same points,
  // but are sewn only where one meets the other around the volume.
  const TemporaryFolder folder;
  std::vector<Block> blocks;
  for (int layer = 0; layer < 2; ++layer)
  {
    for (int column = 0; column < 3; ++column)
    {
      Block block;
      block.volume.knots = { clampedIntegerKnots(2), clampedIntegerKnots(2), clampedIntegerKnots(3) };
      bsvtest::forEach(block.counts(), [&](const Ijk& i) {
        block.points.insert(
          block.points.end(), { 4.0 * column + i[0], (layer ? 1.0 : -1.0) * i[1], i[2] + 0.01 * column * i[2] * i[2] });
      });
      blocks.push_back(block);
    }
  }
  // The lower layer is the mirrored upper one: its blocks are left-handed.
  std::vector<Interface> interfaces;
  const auto meet = [&](int a, int fa, int b, int fb) {
    Interface contact;
    contact.blockA = a;
    contact.faceA = fa;
    contact.blockB = b;
    contact.faceB = fb;
    contact.rangeA.hi = { blocks[a].counts()[faceAxis(fa, 0)] - 1, blocks[a].counts()[faceAxis(fa, 1)] - 1 };
    interfaces.push_back(contact);
  };
  for (int layer = 0; layer < 2; ++layer)
  {
    meet(3 * layer, 1, 3 * layer + 1, 0);
    meet(3 * layer + 1, 1, 3 * layer + 2, 0);
  }
  meet(0, 2, 3, 2);
  meet(2, 2, 5, 2);
  // Neighbouring columns share their points.
  for (int b : { 0, 1, 3, 4 })
  {
    bsvtest::forEach({ 1, blocks[b].counts()[1], blocks[b].counts()[2] }, [&](const Ijk& i) {
      const Ijk last{ blocks[b].counts()[0] - 1, i[1], i[2] };
      std::copy_n(blocks[b].points.data() + 3 * blocks[b].at(last), 3,
        blocks[b + 1].points.data() + 3 * blocks[b + 1].at({ 0, i[1], i[2] }));
    });
  }
  const auto data = volumeData(
    blocks, [](int b, int f) { return (b == 1 || b == 4) && f == 2 ? "wall" : ""; }, &interfaces);
  for (const char* name : { "a.step", "a.igs" })
  {
    Writing writing(data, folder / name);
    ASSERT_TRUE(writing.errors.empty()) << writing.errors[0];
    EXPECT_TRUE(writing.warnings.empty()) << writing.warnings[0];
    EXPECT_EQ(countsOf(shapeOf(folder / name)), (Counts{ 1, 2, 6, 4, 4 })) << name;
  }
}

TEST(NURBSSurfaceWriter, NamesUnitsAndDates)
{
  const TemporaryFolder folder;
  std::mt19937 random(3);
  const Shell shell(random, false);
  const std::vector<std::string> names{ "wall fl\xc3\xbcgel", "wall 'a' \\ \"b\"",
    std::string("wall ") + std::string(200, 'x'), "wall, (1;2) 5H", "wall \xe7\xbf\xbc \xf0\x9f\x9b\xa9",
    "wall fl\xc3\xbcgel" };
  const auto data = volumeData(shell.blocks, [&](int b, int f) {
    return f == shell.wall[b] ? names[b] : f == shell.far[b] ? "far" : "";
  });
  for (const char* name : { "a.step", "a.igs" })
  {
    Writing writing(data, folder / name, vtkNURBSSurfaceWriter::MILLIMETRE);
    ASSERT_TRUE(writing.errors.empty()) << writing.errors[0];
    EXPECT_TRUE(writing.warnings.empty()) << writing.warnings[0];
    std::string unit;
    const std::vector<BodyPatch> patches = patchesOf(folder / name, &unit);
    ASSERT_EQ(patches.size(), names.size());
    for (std::size_t b = 0; b < names.size(); ++b)
    {
      EXPECT_EQ(patches[b].name, names[b]) << name;
    }
    EXPECT_EQ(unit, "millimetre");
    // Every unit is declared, and the numbers stay the same.
    const char* const units[] = { "", "metre", "centimetre", "millimetre", "micrometre", "kilometre", "inch", "foot" };
    for (int u = 1; u <= vtkNURBSSurfaceWriter::FOOT; ++u)
    {
      Writing scaled(data, folder / name, u);
      const std::vector<BodyPatch> same = patchesOf(folder / name, &unit);
      EXPECT_EQ(unit, units[u]) << name;
      EXPECT_EQ(same[0].surface.points, patches[0].surface.points) << name << ' ' << unit;
    }

    // Nothing but the time of the environment is in the file.
    Writing first(data, folder / name);
    const std::string text = readFile(folder / name);
    setenv("SOURCE_DATE_EPOCH", "86400", 1);
    Writing later(data, folder / name);
    unsetenv("SOURCE_DATE_EPOCH");
    std::string dated = readFile(folder / name);
    EXPECT_NE(text, dated);
    const bool step = std::string(name) == "a.step";
    const std::string day = step ? "1970-01-02" : "19700102";
    for (std::size_t at = dated.find(day); at != std::string::npos; at = dated.find(day))
    {
      dated.replace(at, day.size(), step ? "1970-01-01" : "19700101");
    }
    EXPECT_EQ(text, dated);
  }
}

TEST(NURBSSurfaceWriter, BodyOfPatches)
{
  // Half of a body, with a pole: sewn but for its border on the symmetry plane, and the same bits again.
  const TemporaryFolder folder;
  vtkNew<vtkWingFuselageSource> source;
  source->SetResolution(3);
  source->Update();
  vtkDataObject* body = source->GetOutputDataObject(1);
  const std::vector<BodyPatch> given = bodyPatches(body);
  for (const char* name : { "a.step", "a.igs" })
  {
    Writing writing(body, folder / name);
    ASSERT_TRUE(writing.errors.empty()) << writing.errors[0];
    EXPECT_TRUE(writing.warnings.empty()) << writing.warnings[0];
    const TopoDS_Shape shape = shapeOf(folder / name);
    TopTools_IndexedDataMapOfShapeListOfShape uses;
    TopExp::MapShapesAndAncestors(shape, TopAbs_EDGE, TopAbs_FACE, uses);
    for (int e = 1; e <= uses.Extent(); ++e)
    {
      const TopoDS_Edge edge = TopoDS::Edge(uses.FindKey(e));
      if (uses(e).Extent() == 1 && !BRep_Tool::Degenerated(edge))
      {
        TopTools_IndexedMapOfShape ends;
        TopExp::MapShapes(edge, TopAbs_VERTEX, ends);
        for (int v = 1; v <= ends.Extent(); ++v)
        {
          const gp_Pnt at = BRep_Tool::Pnt(TopoDS::Vertex(ends(v)));
          EXPECT_NEAR(at.Y(), 0.0, 1e-9) << name << ": " << at.X() << ' ' << at.Y() << ' ' << at.Z();
        }
      }
    }
    const std::vector<BodyPatch> read = patchesOf(folder / name);
    ASSERT_EQ(read.size(), given.size());
    for (std::size_t p = 0; p < given.size(); ++p)
    {
      EXPECT_EQ(read[p].name, given[p].name);
      EXPECT_EQ(read[p].surface.points, given[p].surface.points) << name << ' ' << given[p].name;
      EXPECT_EQ(read[p].surface.knots, given[p].surface.knots) << name << ' ' << given[p].name;
    }
  }
}

#endif
